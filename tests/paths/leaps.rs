//! Networks that snap in the middle of a step: the increments that are chosen end where short ones do.

use std::path::Path;

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_models::read_text;
use pennate_solver::history::{CriticalKind, History, Status};
use pennate_solver::options::Options;

/// A network of `tests/cases`, with so many increments of the ramp in each of its steps, or with those that are chosen.
fn solve(name: &str, increments: Option<usize>) -> History {
    let file = format!("{name}.toml");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases").join(&file);
    let mut text = std::fs::read_to_string(path).expect("a file");
    if let Some(count) = increments {
        text = text.replace("method = \"arc_length\"", "");
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
        "toggle_on_torsion_springs",
        "body_let_back_over_a_fold",
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

/// Right before the fold the path is so steep that a leap to the straight branch looks like the way there.
#[test]
fn no_number_of_increments_leaps_a_fold_that_comes_near_another_path() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases/drawn_back_to_a_fold.toml");
    let text = std::fs::read_to_string(path).expect("a file");
    let pushed = 8.052_948;
    // From 2,000 increments: the place of the node in the middle.
    let fold = 0.992_171_593 * (0.043_87 + pushed) - pushed;
    let mut ends = vec![(3, 0.043_87), (60, 0.043_87), (100, 0.043_87)];
    // A leap of less than a ten-thousandth of the ramp is at the last of these.
    ends.extend([0.03, 0.05, 0.1, 0.7, 2.0, 3.0].map(|end| (1, end)));
    for (increments, end) in ends {
        let settings = [("n".to_owned(), increments.to_string()), ("U".to_owned(), end.to_string())];
        let model =
            read_text("drawn_back_to_a_fold.toml", &text, &settings).unwrap_or_else(|errors| panic!("{errors:?}"));
        let history = solve_to_accuracy(model, 1e-4, &Options::default(), &mut |_| true);
        let history = history.unwrap_or_else(|(_, error)| panic!("{error}")).history;
        let step = history.steps.last().expect("a step");
        assert_eq!(step.status, Status::LimitPoint, "{increments} increments to {end}");
        let place = step.critical_points.last().expect("a point").fraction * (end + pushed) - pushed;
        assert!((place - fold).abs() < 1e-4, "{increments} increments to {end}: {place}");
    }
}

/// Networks lose their stability on the way of a step, at the place that short increments find.
fn assert_loses_stability(names: &[&str], kind: CriticalKind) {
    for name in names {
        let [chosen, short] = [None, Some(60)].map(|increments| solve(name, increments));
        let [(here, error), (there, other)] = [&chosen, &short].map(|history| {
            let step = history.steps.iter().find(|step| step.status != Status::Converged).expect("a step ends");
            let point = step.critical_points.last().expect("a point");
            assert_eq!(point.kind, kind, "{name}");
            // A point that coarser meshes do not have has no error.
            (point.fraction, point.error.unwrap_or(1e-8))
        });
        assert!((here - there).abs() <= 10.0 * (error + other), "{name}: {here} and {there}, {error}");
    }
}

/// Both ends of an increment over all of that are stable.
#[test]
fn no_increment_leaps_what_lies_out_of_the_plane() {
    assert_loses_stability(&["vee_pushed_through", "arch_pushed_through"], CriticalKind::Bifurcation);
}

#[test]
fn no_increment_goes_where_its_tangents_point_apart() {
    assert_loses_stability(&["bent_far"], CriticalKind::LimitPoint);
}

/// The coarse mesh goes on there, and the end that it came to is an equilibrium of the fine one as well, of another path.
#[test]
fn a_path_that_comes_near_a_singular_point_is_followed_on_every_mesh() {
    assert_loses_stability(&["frame_of_two_meshes", "portal_of_two_meshes"], CriticalKind::LimitPoint);
}

/// Nothing of the coarse path is nearly singular, but its increments had to be short.
#[test]
fn a_path_of_increments_that_were_cut_short_is_followed_on_every_mesh() {
    let names = ["frame_of_a_fold_on_fine_meshes", "network_of_a_fold_on_fine_meshes"];
    assert_loses_stability(&names, CriticalKind::LimitPoint);
}

/// A strut buckles to one side on the coarse mesh and to the other on the finer one, whose next step begins there.
#[test]
fn a_step_that_changes_nothing_stays_on_the_branch_of_its_own_mesh() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases/strut_of_two_meshes.toml");
    let text = std::fs::read_to_string(path).expect("a file");
    let model = read_text("strut_of_two_meshes.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
    let history = solve_to_accuracy(model, 1e-4, &Options::default(), &mut |_| true);
    let history = history.unwrap_or_else(|(_, error)| panic!("{error}")).history;
    let [first, second] = history.steps.as_slice() else { panic!("two steps") };
    assert_eq!([first.status, second.status], [Status::Converged; 2]);
    let [before, after] = [first, second].map(|step| &step.increments.last().expect("an end").state.nodes);
    for (a, b) in before.iter().zip(after) {
        for (x, y) in a.displacement.iter().zip(b.displacement) {
            assert!((x - y).abs() < 1e-6, "{:?} and {:?}", a.displacement, b.displacement);
        }
    }
}

/// Both ends of an increment are stable there, with tangents along the way, and no path joins them.
#[test]
fn no_increment_leaps_a_limit_point_that_only_the_middle_tells_of() {
    let names = ["limit_point_within_an_increment", "limit_point_within_a_short_increment"];
    assert_loses_stability(&names, CriticalKind::LimitPoint);
}

/// Nothing thrusts there but the loads, against what holds one end.
#[test]
fn no_increment_of_a_single_member_leaps_its_fold() {
    let names = [
        "column_let_back_over_a_fold",
        "strut_let_back_over_a_fold",
        "bar_on_springs",
        "bar_on_springs_under_a_follower",
    ];
    assert_loses_stability(&names, CriticalKind::LimitPoint);
}

/// What is lost within an increment and regained in it leaves no trace at the ends.
#[test]
fn no_increment_leaps_two_bifurcations_at_once() {
    let [chosen, short] = [None, Some(60)].map(|increments| solve("vee_pushed_flat", increments));
    let points = [&chosen, &short].map(|history| &history.steps[0].critical_points);
    assert_eq!(points.map(Vec::len), [2, 2]);
    for (a, b) in points[0].iter().zip(points[1]) {
        assert_eq!([a.kind, b.kind], [CriticalKind::Bifurcation; 2]);
        let error = a.error.expect("an error") + b.error.expect("an error");
        assert!((a.fraction - b.fraction).abs() <= 10.0 * error, "{} and {}, {error}", a.fraction, b.fraction);
    }
}

#[test]
fn no_increment_along_the_arc_goes_over_to_the_branch_of_the_other_side() {
    let [chosen, short] = [None, Some(60)].map(|increments| solve("bars_drawn_taut_along_the_arc", increments));
    let ends = [&chosen, &short].map(|history| {
        let [step] = history.steps.as_slice() else { panic!("one step") };
        assert_eq!(step.status, Status::Converged);
        assert!(step.critical_points.is_empty(), "{:?}", step.critical_points);
        step.increments
            .last()
            .expect("an increment")
            .state
            .nodes
            .iter()
            .map(|node| node.displacement)
            .collect::<Vec<_>>()
    });
    for (along, by_ramp) in ends[0].iter().zip(&ends[1]) {
        let apart = (0..3).map(|c| (along[c] - by_ramp[c]).abs()).fold(0.0, f64::max);
        assert!(apart <= 1e-7, "{along:?} instead of {by_ramp:?} mm");
    }
}
