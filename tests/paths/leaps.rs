//! Networks that snap in the middle of a step: the increments that are chosen end where short ones do.

use std::path::Path;

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_models::read_text;
use pennate_solver::history::{CriticalKind, History, Status};
use pennate_solver::options::Options;

/// A network of `tests/cases`, with so many increments in each of its steps, or with those that are chosen.
fn solve(name: &str, increments: Option<usize>) -> History {
    let file = format!("{name}.toml");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases").join(&file);
    let mut text = std::fs::read_to_string(path).expect("a file");
    if let Some(count) = increments {
        text = text.replace("[[steps]]", &format!("[[steps]]\nincrements = {count}"));
    }
    let model = read_text(&file, &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = Options { estimate: true, ..Options::default() };
    solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}")).history
}

#[test]
fn no_increment_leaps_a_limit_point_in_a_later_step() {
    let names = [
        "fan_of_muscles",
        "muscles_about_a_joint",
        "rods_that_push",
        "fan_that_turns_little",
        "fan_foretold_by_chance",
    ];
    for name in names {
        let [chosen, short] = [None, Some(60)].map(|increments| solve(name, increments));
        let ends = |history: &History| history.steps.iter().map(|step| step.status).collect::<Vec<_>>();
        assert_eq!(ends(&chosen), ends(&short), "{name}");
        let last = |history: &History| {
            let step = history.steps.iter().find(|step| step.status == Status::LimitPoint).expect("a step ends");
            let point = step.critical_points.last().expect("a point");
            assert_eq!(point.kind, CriticalKind::LimitPoint);
            (point.fraction, point.error.expect("an error"))
        };
        let [(here, error), (there, other)] = [&chosen, &short].map(last);
        assert!((here - there).abs() <= 10.0 * (error + other), "{name}: {here} and {there}, {error}");
    }
}
