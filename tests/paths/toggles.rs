//! Toggles, whose branches nearly meet beside their limit points: what is passed on the way there is passed on the way back.

use std::path::Path;

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_models::read_text;
use pennate_solver::history::{CriticalKind, History, Status, StepHistory};
use pennate_solver::options::Options;

/// The toggle of `tests/cases`, with these parameters, and its steps followed as these words say.
fn solve(words: &str, parameters: &[(&str, f64)]) -> History {
    solve_with("", words, parameters)
}

/// The same, with more words on its section.
fn solve_with(section: &str, words: &str, parameters: &[(&str, f64)]) -> History {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases/toggle.toml");
    let text = std::fs::read_to_string(path).expect("a file").replace("method = \"arc_length\"", words);
    let text = text.replace("[members]", &format!("{section}\n\n[members]"));
    let settings: Vec<_> = parameters.iter().map(|(name, value)| ((*name).to_owned(), value.to_string())).collect();
    let model = read_text("toggle.toml", &text, &settings).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = Options { estimate: true, ..Options::default() };
    solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}")).history
}

/// A soft toggle whose branches nearly meet once.
const SOFT: [(&str, f64); 6] = [
    ("apex", 1.256_440_648),
    ("rise", 0.259_643_739_2),
    ("EA", 1_668.898_999),
    ("EI", 0.103_657_346_9),
    ("fx", 0.050_097_721_66),
    ("fy", -7.656_541_708),
];

/// The points of the way back are those of the way there, in the other order.
#[track_caller]
fn assert_mirrored(history: &History, count: usize) {
    let [there, back] = history.steps.as_slice() else { panic!("two steps") };
    assert_eq!((there.critical_points.len(), back.critical_points.len()), (count, count));
    for (point, again) in there.critical_points.iter().zip(back.critical_points.iter().rev()) {
        assert_eq!(point.kind, again.kind);
        let error = point.error.expect("an error") + again.error.expect("an error");
        let apart = (point.fraction + again.fraction - 1.0).abs();
        assert!(apart < 10.0 * error + 1e-9, "{} {}: {apart} ± {error}", point.fraction, again.fraction);
    }
}

#[track_caller]
fn assert_at_rest(step: &StepHistory) {
    assert_eq!((step.status, step.stable), (Status::Converged, Some(true)));
    let moved = step.increments.last().expect("a state").state.nodes[1].displacement;
    assert!(moved.iter().all(|part| part.abs() < 1e-9), "{moved:?}");
}

#[test]
fn the_arc_of_a_toggle_comes_back_the_way_it_went() {
    for parameters in [[].as_slice(), &SOFT] {
        for increments in [1, 7, 40] {
            let history = solve(&format!("method = \"arc_length\"\nincrements = {increments}"), parameters);
            assert_mirrored(&history, 2);
            assert_at_rest(&history.steps[1]);
        }
    }
}

/// Both limit points lie within what is a fortieth of the ramp, and the load is nearly the same at both.
#[test]
fn a_jump_does_not_pass_two_limit_points_at_once() {
    let flat = [
        ("apex", 1.0),
        ("rise", 0.264_957_222_7),
        ("EA", 120.007_228_2),
        ("EI", 0.338_470_081_6),
        ("fx", -1.465_766_354),
        ("fy", -27.064_022_8),
    ];
    let step = &solve("method = \"jump\"", &flat).steps[0];
    assert_eq!((step.status, step.stable, step.jumps.len()), (Status::Converged, Some(true), 1));
    assert_eq!(step.critical_points[0].kind, CriticalKind::LimitPoint);
    let fine = &solve("method = \"arc_length\"\nincrements = 200", &flat).steps[0];
    let [first, fine] = [&step.critical_points[0], &fine.critical_points[0]];
    assert!((first.fraction - fine.fraction).abs() < 1e-7, "{} {}", first.fraction, fine.fraction);
}

/// Let go of in one increment, a straight toggle far above its critical loads passes all of them again.
#[test]
fn an_increment_does_not_pass_several_bifurcations_at_once() {
    let stiff = [
        ("apex", 1.285_651_086),
        ("rise", 0.227_795_287),
        ("EA", 1e8),
        ("EI", 1.004_560_476),
        ("fx", 5.428_701_569),
        ("fy", -69.520_793_83),
    ];
    let history = solve_with("s.stretch = false", "method = \"newton\"\nbranch = \"primary\"", &stiff);
    assert_mirrored(&history, history.steps[0].critical_points.len());
    assert!(history.steps[0].critical_points.len() >= 5);
    assert_at_rest(&history.steps[1]);
}
