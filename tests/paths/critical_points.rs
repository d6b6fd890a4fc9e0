//! Limit points and bifurcations of the references, from their network files with default settings.

use std::path::{Path, PathBuf};

use pennate_analysis::accuracy::{Verdict, solve_to_accuracy};
use pennate_analysis::solution::Solution;
use pennate_models::{read, read_text};
use pennate_solver::history::{Cause, CriticalKind, Status, StepHistory};
use pennate_solver::options::Options;
use pennate_solver::structure::Formulation;
use serde_json::Value;

/// Error of a critical load, over the load.
const LOAD: f64 = 1e-6;
/// Error of the state at the critical load, over the largest displacement there.
const STATE: f64 = 1e-5;

fn validation(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("validation").join(path)
}

fn reference(case: &str) -> Value {
    let text = std::fs::read_to_string(validation(case).join("reference.json")).expect("a reference");
    serde_json::from_str(&text).expect("a reference in JSON")
}

fn solve(file: &str, settings: &[(&str, &str)]) -> Solution {
    let settings: Vec<_> = settings.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let model = read(&validation(file), &settings).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = Options { estimate: true, ..Options::default() };
    solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}"))
}

/// The displacement of a node at the last increment of the first step.
fn last_displacement(solution: &Solution, node: &str) -> [f64; 3] {
    let index = solution.model.nodes.iter().position(|n| n.name == node).expect("the node");
    solution.history.steps[0].increments.last().expect("a state").state.nodes[index].displacement
}

#[track_caller]
fn assert_state(solution: &Solution, node: &str, expected: &Value) {
    let now = last_displacement(solution, node);
    let expected: [f64; 3] = serde_json::from_value(expected.clone()).expect("a displacement");
    let largest = expected.iter().fold(0.0f64, |a, b| a.max(b.abs()));
    for (now, expected) in now.iter().zip(expected) {
        assert!((now - expected).abs() <= STATE * largest, "{node}: {now} instead of {expected}");
    }
}

#[track_caller]
fn assert_load(now: f64, expected: f64) {
    let error = (now / expected - 1.0).abs();
    println!("{now} against {expected}: {error:.1e}");
    assert!(error <= LOAD, "{now} instead of {expected}");
}

/// A case: file, settings, load at the end of the ramp, what it ends with, and the node that the reference shows.
type Case<'a> = (&'a str, &'a [(&'a str, &'a str)], f64, Status, &'a str, usize);

#[track_caller]
fn stops_at(case: &str, pointers: [&str; 2], (file, settings, load, status, node, result): Case<'_>) {
    let solution = solve(&format!("{case}/{file}"), settings);
    let step = &solution.history.steps[0];
    assert_eq!(step.status, status);
    let data = &reference(case)["results"][result]["quantities"];
    let expected = data.pointer(pointers[0]).and_then(Value::as_f64).expect("a load");
    let point = step.critical_points.last().expect("a critical point");
    assert_load(load * point.fraction, expected);
    assert_eq!(point.fraction, step.fraction);
    assert_state(&solution, node, data.pointer(pointers[1]).expect("a state"));
}

#[test]
fn lees_frame_williams_toggle_and_the_deep_arch_end_at_their_limit_points() {
    let limit = Status::LimitPoint;
    stops_at("05_lee_frame", ["/load", "/load_point/displacement"], ("lee_frame.toml", &[], 2.0, limit, "P", 0));
    let stiff = [("stiff", "1e4")];
    stops_at("05_lee_frame", ["/load", "/load_point/displacement"], ("lee_frame.toml", &stiff, 2.0, limit, "P", 2));
    stops_at("06_williams_toggle", ["/load", "/apex/displacement"], ("toggle_load.toml", &[], 40.0, limit, "C", 0));
    stops_at("07_deep_arch_215", ["/load", "/apex/displacement"], ("arch.toml", &[], 900.0, limit, "P", 0));
}

/// Corotational elements lose their stability where exact ones do: at limit points, sideways, and twisted by more than
/// half a turn.
#[test]
fn corotational_elements_have_the_same_singular_points() {
    let cases: [(&str, &str, f64, &str); 5] = [
        ("05_lee_frame", "lee_frame.toml", 2.0, "/results/0/quantities/load"),
        ("07_deep_arch_215", "arch.toml", 900.0, "/results/0/quantities/load"),
        ("08_right_angle_frame", "cantilever.toml", 1.5, "/results/0/quantities/critical_load_factor"),
        ("08_right_angle_frame", "hinged.toml", 700.0, "/results/2/quantities/critical_load_factor"),
        (
            "11_twist_buckling",
            "twist.toml",
            720f64.to_radians(),
            "/results_reissner/0/quantities/critical_end_rotation",
        ),
    ];
    for (case, file, end, pointer) in cases {
        let mut model = read(&validation(&format!("{case}/{file}")), &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
        model.members.iter_mut().for_each(|member| member.formulation = Formulation::Corotational);
        let options = Options { estimate: true, ..Options::default() };
        let solution =
            solve_to_accuracy(model, 1e-4, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}"));
        let step = &solution.history.steps[0];
        let point = step.critical_points.last().expect("a critical point");
        let expected = reference(case).pointer(pointer).and_then(Value::as_f64).expect("a number");
        let (error, estimate) = (end * point.fraction / expected - 1.0, end * point.error.unwrap_or(0.0) / expected);
        println!(
            "{file}: {:?}, error {error:.1e}, estimated {estimate:.1e}, {} elements",
            step.status,
            solution.mesh.elements()
        );
        assert!(error.abs() <= 2e-4, "{file}: {} instead of {expected}", end * point.fraction);
        assert!(
            error.abs() < 10.0 * estimate && estimate < 10.0 * error.abs(),
            "{file}: {error:.1e}, not {estimate:.1e}"
        );
    }
}

/// Both legs lie in a plane and are loaded in it; what is lost is their stability out of it.
#[test]
fn the_right_angle_frame_buckles_sideways() {
    let pointers = ["/critical_load_factor", "/planar_displacement"];
    let lost = Status::Bifurcation;
    let case = "08_right_angle_frame";
    stops_at(case, pointers, ("cantilever.toml", &[], 1.5, lost, "T", 0));
    stops_at(case, pointers, ("cantilever.toml", &[("P", "-1")], -1.0, lost, "T", 1));
    stops_at(case, pointers, ("hinged.toml", &[], 700.0, lost, "C", 2));
    stops_at(case, pointers, ("hinged.toml", &[("M", "-700")], -700.0, lost, "C", 3));
}

/// In space the same frame has the same critical load, and goes on along the branch that is stable.
#[test]
fn in_space_the_right_angle_frame_goes_on_sideways() {
    let text = std::fs::read_to_string(validation("08_right_angle_frame/cantilever.toml")).expect("the network");
    let text = text.replace("[parameters]", "dimension = \"space\"\n[parameters]");
    let model = pennate_models::read_text("space.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = Options { estimate: true, ..Options::default() };
    let solution =
        solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}"));
    let step = &solution.history.steps[0];
    assert_eq!((step.status, step.stable), (Status::Converged, Some(true)));
    let data = reference("08_right_angle_frame");
    let expected = data["results"][0]["quantities"]["critical_load_factor"].as_f64().expect("a load");
    assert_load(1.5 * step.critical_points[0].fraction, expected);
    assert!(last_displacement(&solution, "T")[2].abs() > 10.0);
}

#[test]
fn the_arc_length_passes_both_limit_points_of_lees_frame() {
    let solution = solve("05_lee_frame/path.toml", &[]);
    let step = &solution.history.steps[0];
    assert_eq!((step.status, step.fraction), (Status::Converged, 1.0));
    let kinds: Vec<_> = step.critical_points.iter().map(|point| point.kind).collect();
    assert_eq!(kinds, [CriticalKind::LimitPoint; 2]);
    let data = reference("05_lee_frame");
    let loaded = solution.model.nodes.iter().position(|node| node.name == "P").expect("the loaded node");
    for (point, result) in step.critical_points.iter().zip(0..) {
        let quantities = &data["results"][result]["quantities"];
        assert_load(2.0 * point.fraction, quantities["load"].as_f64().expect("a load"));
        let there = step.increments.iter().find(|increment| increment.fraction == point.fraction).expect("its state");
        let expected: [f64; 3] =
            serde_json::from_value(quantities["load_point"]["displacement"].clone()).expect("a displacement");
        for (now, expected) in there.state.nodes[loaded].displacement.iter().zip(expected) {
            assert!((now - expected).abs() <= STATE * 90.0, "{now} instead of {expected}");
        }
    }
    assert_eq!(step.stable, Some(true));
}

/// The rod buckles between its ends, where nothing moves in the mode: two modes at once, since it is round.
#[test]
fn a_twisted_rod_buckles_between_its_ends() {
    let data = reference("11_twist_buckling");
    for (settings, result) in [(&[][..], 0), (&[("EA", "1e10"), ("GA", "1e10")][..], 1)] {
        let solution = solve("11_twist_buckling/twist.toml", settings);
        let step = &solution.history.steps[0];
        assert_eq!(step.status, Status::Bifurcation);
        let point = step.critical_points.last().expect("a critical point");
        assert_eq!(point.member, Some(0));
        let expected = &data["results_reissner"][result]["quantities"]["critical_end_rotation"];
        assert_load(720f64.to_radians() * point.fraction, expected.as_f64().expect("an angle"));
    }
}

/// The straight column stays an equilibrium; the way on is the buckled one, in the plane and in space.
#[test]
fn a_perfect_column_follows_its_stable_branch() {
    for times in ["1.1", "1.2", "2", "3", "4"] {
        let solution = solve("columns/cantilever.toml", &[("times", times)]);
        let step = &solution.history.steps[0];
        assert_eq!((step.status, step.stable), (Status::Converged, Some(true)));
        assert_eq!(step.critical_points.len(), 1);
        assert_eq!(step.critical_points[0].kind, CriticalKind::Bifurcation);
        let times: f64 = times.parse().expect("a number");
        assert_load(times * step.critical_points[0].fraction, 1.0);
        // The elastica: load over Euler's load = (2 K(sin(angle / 2)) / pi)^2.
        let index = solution.model.nodes.iter().position(|n| n.name == "T").expect("the tip");
        let turned = step.increments.last().expect("a state").state.nodes[index].rotation_total;
        let expected = (2.0 / std::f64::consts::PI * complete_elliptic((0.5 * turned).sin())).powi(2);
        assert!((times / expected - 1.0).abs() < 1e-5, "{times} against {expected}");
    }
}

/// A round strut that can be neither sheared nor stretched, clamped at both ends and pressed by 1.2 times its critical load, as
/// one member and as two: its plane of buckling is free, and no other motion is softer.
#[test]
fn a_round_clamped_strut_follows_its_stable_branch() {
    let critical = 4.0 * std::f64::consts::PI.powi(2) / 100.0f64.powi(2);
    let halves = "M = [50, 0]\n";
    for (node, members) in [
        ("", "m = { nodes = ['A', 'B'], section = 's' }"),
        (halves, "a = { nodes = ['A', 'M'], section = 's' }\nb = { nodes = ['M', 'B'], section = 's' }"),
    ] {
        let text = format!(
            "format = 'pennate/1'\n[nodes]\nA = [0, 0]\nB = [100, 0]\n{node}\n\
             [sections.s]\nstiffness = {{ EI2 = 1, EI3 = 1, GJ = 0.8 }}\nstretch = false\nshear = false\n\
             [members]\n{members}\n[supports]\nA = 'clamped'\nB = ['uy', 'uz', 'rx', 'ry', 'rz']\n\
             [[steps]]\nforce = {{ B = [{}, 0] }}\n",
            -1.2 * critical
        );
        let model = read_text("strut.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
        let options = Options { estimate: true, ..Options::default() };
        let solution = solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, e)| panic!("{e}"));
        let step = &solution.history.steps[0];
        assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{members}");
        assert_load(1.2 * step.critical_points[0].fraction, 1.0);
        // The elastica of a quarter: K(k) = L/4 sqrt(P/EI), and the ends come nearer by 2 L (1 - E/K).
        let wanted = 0.25 * std::f64::consts::TAU * 1.2f64.sqrt();
        let (mut low, mut high) = (0.0, 0.99);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *(if complete_elliptic(middle) < wanted { &mut low } else { &mut high }) = middle;
        }
        let expected = -200.0 * (1.0 - second_elliptic(low) / wanted);
        let [shortened, ..] = last_displacement(&solution, "B");
        assert!((shortened / expected - 1.0).abs() < 1e-5, "{shortened} against {expected}");
    }
}

/// A column between two hinges under a load that its upper end follows straight down: no joint moves by what it loses, and it goes
/// on along the elastica.
#[test]
fn a_column_hinged_at_both_ends_bends_between_joints_that_stay() {
    let critical = std::f64::consts::PI.powi(2) / 100.0f64.powi(2);
    for (times, increments) in [(1.02, 1), (1.2, 1), (1.2, 7), (1.2, 60), (1.6, 1)] {
        let text = format!(
            "format = 'pennate/1'\ndimension = 'plane'\n[nodes]\nA = [0, 0]\nT = [0, 100]\n\
             [sections.s]\nstiffness = {{ EI2 = 3, EI3 = 1, GJ = 0.8 }}\nstretch = false\nshear = false\n\
             [members]\nm = {{ nodes = ['A', 'T'], section = 's', release = {{ start = 'pin', end = 'pin' }} }}\n\
             [supports]\nA = 'clamped'\nT = ['ux', 'rz']\n\
             [[steps]]\nincrements = {increments}\nforce = {{ T = [0, {}] }}\n",
            -times * critical
        );
        let model = read_text("column.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
        let options = Options { estimate: true, ..Options::default() };
        let solution = solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, e)| panic!("{e}"));
        let step = &solution.history.steps[0];
        assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{times} {increments}");
        let [point] = step.critical_points.as_slice() else { panic!("{:?}", step.critical_points) };
        assert_eq!((point.kind, point.member), (CriticalKind::Bifurcation, Some(0)));
        assert_load(times * point.fraction, 1.0);
        // The elastica of a half: K(k) = L/2 sqrt(P/EI), and the ends come nearer by 2 L (1 - E/K).
        let wanted = 0.5 * std::f64::consts::PI * f64::sqrt(times);
        let (mut low, mut high) = (0.0, 0.99);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *(if complete_elliptic(middle) < wanted { &mut low } else { &mut high }) = middle;
        }
        let expected = -200.0 * (1.0 - second_elliptic(low) / wanted);
        let [_, shortened, _] = last_displacement(&solution, "T");
        assert!((shortened / expected - 1.0).abs() < 1e-5, "{times} {increments}: {shortened} against {expected}");
    }
}

/// A frame whose middle column, between two hinges, is lost first: it goes on as the same frame does whose members are drawn as two,
/// whatever the number of increments.
#[test]
fn a_frame_goes_on_where_a_column_between_hinges_buckles() {
    let solve = |halves: bool, increments: usize| {
        let members = [
            ("l", ["A", "D"], [0, 0], [0, 80], "c", ""),
            ("m", ["B", "E"], [100, 0], [100, 80], "c", "pin"),
            ("r", ["C", "F"], [200, 0], [200, 80], "c", ""),
            ("s", ["D", "E"], [0, 80], [100, 80], "b", ""),
            ("t", ["E", "F"], [100, 80], [200, 80], "b", ""),
        ];
        let mut nodes =
            "[nodes]\nA = [0, 0]\nB = [100, 0]\nC = [200, 0]\nD = [0, 80]\nE = [100, 80]\nF = [200, 80]\n".to_owned();
        let mut words = "[members]\n".to_owned();
        for (name, [start, end], from, to, section, release) in members {
            let pins = |which: &str| {
                let ends: Vec<_> =
                    ["start", "end"].iter().filter(|end| which.contains(**end) && !release.is_empty()).collect();
                let ends: Vec<_> = ends.iter().map(|end| format!("{end} = 'pin'")).collect();
                if ends.is_empty() { String::new() } else { format!(", release = {{ {} }}", ends.join(", ")) }
            };
            let member = |name: &str, nodes: [&str; 2], pins: String| {
                format!("{name} = {{ nodes = ['{}', '{}'], section = '{section}'{pins} }}\n", nodes[0], nodes[1])
            };
            if halves {
                let middle = format!("N{name}");
                nodes += &format!("{middle} = [{}, {}]\n", (from[0] + to[0]) / 2, (from[1] + to[1]) / 2);
                words += &member(&format!("{name}1"), [start, &middle], pins("start"));
                words += &member(&format!("{name}2"), [&middle, end], pins("end"));
            } else {
                words += &member(name, [start, end], pins("start end"));
            }
        }
        let text = format!(
            "format = 'pennate/1'\ndimension = 'plane'\n{nodes}{words}\
             [sections.c]\nstiffness = {{ EI2 = 3, EI3 = 1, GJ = 0.8 }}\nstretch = false\n\
             [sections.b]\nstiffness = {{ EI2 = 3, EI3 = 20, GJ = 0.8 }}\nstretch = false\n\
             [supports]\nA = 'clamped'\nB = 'clamped'\nC = 'clamped'\n\
             [[steps]]\nincrements = {increments}\nforce = {{ D = [1e-6, -2e-4], E = [0, -2e-3], F = [0, -2e-4] }}\n"
        );
        let model = read_text("frame.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
        let options = Options { estimate: true, ..Options::default() };
        solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, e)| panic!("{e}"))
    };
    let reference = solve(true, 1);
    let expected = last_displacement(&reference, "D");
    for increments in [1, 7, 20, 60] {
        let solution = solve(false, increments);
        let step = &solution.history.steps[0];
        assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{increments}");
        assert_eq!(step.critical_points.len(), reference.history.steps[0].critical_points.len(), "{increments}");
        for (now, expected) in last_displacement(&solution, "D").into_iter().zip(expected) {
            assert!((now - expected).abs() <= 1e-5, "{increments}: {now} against {expected}");
        }
    }
}

/// E(k) by the arithmetic-geometric mean.
fn second_elliptic(k: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - k * k).sqrt());
    let (mut sum, mut power) = (0.5 * k * k, 0.5);
    for _ in 0..40 {
        let c = 0.5 * (a - b);
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
        power *= 2.0;
        sum += power * c * c;
    }
    (1.0 - sum) * complete_elliptic(k)
}

/// K(k) by the arithmetic-geometric mean.
fn complete_elliptic(k: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - k * k).sqrt());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    std::f64::consts::FRAC_PI_2 / a
}

/// Reference 10, reached without a kick and without a node in the middle.
#[test]
fn a_clamped_column_buckles_between_its_ends() {
    let solution = solve("columns/clamped.toml", &[]);
    let step = &solution.history.steps[0];
    assert_eq!((step.status, step.stable), (Status::Converged, Some(true)));
    assert_eq!(step.critical_points[0].member, Some(0));
    let state = &step.increments.last().expect("a state").state;
    assert_load(-state.nodes[1].reaction_force[0], 41.103135822);
    assert_eq!(state.members.len(), 1);
}

/// A ramp that ends a little before a limit point reaches its end, however near that is; a little beyond, it does not.
#[test]
fn a_ramp_that_ends_before_a_limit_point_reaches_its_end() {
    let text = std::fs::read_to_string(validation("05_lee_frame/lee_frame.toml")).expect("the network");
    for (part, expected) in [(0.998, Status::Converged), (0.99995, Status::Converged), (1.001, Status::LimitPoint)] {
        let text = text.replace("[0, -2, 0]", &format!("[0, {}, 0]", -1.85445270944 * part));
        let model = pennate_models::read_text("near.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
        let options = Options { estimate: true, ..Options::default() };
        let solution =
            solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}"));
        let step = &solution.history.steps[0];
        assert_eq!(step.status, expected, "{part} of the limit load, fraction {}", step.fraction);
        assert_eq!(step.stable, Some(true));
    }
}

/// A state at a critical load is no place to end an increment at: the point is located from the states before and beyond it,
/// and the frame goes on along its stable branch.
#[test]
fn an_increment_to_a_critical_load_loses_nothing() {
    let step = &solve("../tests/cases/increment_to_a_critical_load.toml", &[]).history.steps[0];
    let [sways, falls] = step.critical_points.as_slice() else { panic!("{:?}", step.critical_points) };
    assert_eq!((sways.kind, falls.kind), (CriticalKind::Bifurcation, CriticalKind::LimitPoint));
    let error = sways.error.expect("an error");
    assert!((sways.fraction - 1.0 / 3.0).abs() <= 2.0 * error + 1e-8 && error <= 1e-6, "{} ± {error}", sways.fraction);
    assert!(falls.error.is_some());
}

/// Nor is one to end an increment along the arc at: the tangent there says nothing of where the path leads.
#[test]
fn an_arc_to_a_critical_load_goes_on_along_its_path() {
    let step = &solve("../tests/cases/arc_to_a_critical_load.toml", &[]).history.steps[0];
    let [sways] = step.critical_points.as_slice() else { panic!("{:?}", step.critical_points) };
    let error = sways.error.expect("an error");
    assert!((sways.fraction - 0.5).abs() <= 2.0 * error && error <= 1e-6, "{} ± {error}", sways.fraction);
    assert_eq!((step.status, step.stable), (Status::Converged, Some(false)));
}

/// What is lost may lie within members whose joints hardly move by it: the branch is entered by the farthest of all motions.
#[test]
fn networks_go_on_along_branches_that_bend_what_lies_between_joints() {
    for file in ["brace_that_buckles", "backbone_between_muscles"] {
        let step = &solve(&format!("../tests/cases/{file}.toml"), &[]).history.steps[0];
        assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{file}");
        let kinds: Vec<_> = step.critical_points.iter().map(|point| point.kind).collect();
        assert_eq!(kinds, [CriticalKind::Bifurcation], "{file}");
    }
}

/// Members that are as good as inextensible cost no digits of a critical load, and no word where one is passed.
#[test]
fn slender_frames_drawn_not_quite_straight_have_their_limit_points() {
    let limits = |file: &str, fraction: f64| {
        let step = &solve(file, &[]).history.steps[0];
        let first = step.critical_points.first().expect("a limit point");
        let error = first.error.expect("an error");
        assert_eq!((first.kind, step.stable), (CriticalKind::LimitPoint, Some(true)));
        let apart = (first.fraction - fraction).abs();
        assert!(apart <= 10.0 * error && error <= 1e-6, "{file}: {} ± {error}, off by {apart:e}", first.fraction);
    };
    // What a hundred increments by the fraction come to, with an accuracy of 1e-9.
    limits("../tests/cases/slender_frame.toml", 0.300_177_587_07);
    limits("../tests/cases/slender_frame_along_the_arc.toml", 0.871_511_823_57);
}

/// A network that cannot be stretched everywhere leaves its plane along the motion that nothing resists, and so does its mirror
/// image.
#[test]
fn a_network_and_its_mirror_image_leave_their_plane_alike() {
    let file = "../tests/cases/branch_of_a_mirrored_network.toml";
    let text = std::fs::read_to_string(validation(file)).expect("the network");
    let places = [("[-40, 50]", "[40, 50]"), ("[30, 0]", "[-30, 0]"), ("[1, 0]", "[-1, 0]"), ("[-2, 0]", "[2, 0]")];
    let mirrored = places.iter().fold(text.clone(), |text, (place, mirrored)| text.replace(place, mirrored));
    assert_ne!(text, mirrored);
    let points = [text, mirrored].map(|text| {
        let model = pennate_models::read_text("drawn.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
        let options = Options { estimate: true, ..Options::default() };
        let solution =
            solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}"));
        solution
            .history
            .steps
            .into_iter()
            .map(|step| {
                assert_eq!((step.status, step.stable), (Status::Converged, Some(true)));
                let [point] = step.critical_points.as_slice() else { panic!("{:?}", step.critical_points) };
                point.fraction
            })
            .collect::<Vec<_>>()
    });
    for (drawn, mirrored) in points[0].iter().zip(&points[1]) {
        assert!((drawn - mirrored).abs() <= 1e-7, "{drawn} and {mirrored}");
    }
}

/// An arch of one member between clamped nodes has no joint that moves, and snaps all the same: as one with a node in its crown.
#[test]
fn an_arch_without_a_joint_that_moves_snaps_like_one_with_a_node_in_its_crown() {
    let network = |node: &str, members: &str, method: &str| {
        let text = format!(
            "format = \"pennate/1\"\ndimension = \"plane\"\nnodes = {{ A = [0, 0], B = [100, 0]{node} }}
            sections.s = {{ stiffness = {{ EA = 4e5, EI3 = 1e3 }} }}
            supports = {{ A = \"clamped\", B = \"clamped\" }}\n{members}
            [[steps]]\nmethod = \"{method}\"\ndistributed = {{ all = [0.002, -0.15] }}\n"
        );
        let model = pennate_models::read_text("arch.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
        let options = Options { estimate: true, ..Options::default() };
        solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}"))
    };
    let one = "members.a = { nodes = [\"A\", \"B\"], section = \"s\", arc = [50, 4] }";
    // The circle through A, M and B: a quarter of it from A.
    let radius = (50.0f64.powi(2) + 16.0) / 8.0;
    let part = 0.5 * (50.0 / radius).asin();
    let [x, y] = [50.0 - radius * part.sin(), radius * (part.cos() - 1.0) + 4.0];
    let half = |name: &str, ends: &str, x: f64| {
        format!("members.{name} = {{ nodes = [{ends}], section = \"s\", arc = [{x}, {y}] }}\n")
    };
    let two = half("a", "\"A\", \"M\"", x) + &half("b", "\"M\", \"B\"", 100.0 - x);
    for method in ["newton", "jump", "arc_length"] {
        let (one, two) = (network("", one, method), network(", M = [50, 4]", &two, method));
        let (a, b) = (&one.history.steps[0], &two.history.steps[0]);
        assert_eq!((a.status, a.stable), (b.status, b.stable), "{method}");
        assert_eq!(a.critical_points.len(), b.critical_points.len(), "{method}");
        for (a, b) in a.critical_points.iter().zip(&b.critical_points) {
            assert_eq!((a.kind, a.member), (b.kind, Some(0)), "{method}");
            assert_load(a.fraction, b.fraction);
        }
        if a.status == Status::Converged {
            let reaction = |step: &StepHistory| step.increments.last().expect("a state").state.nodes[0].reaction_force;
            let (a, b) = (reaction(a), reaction(b));
            assert!((0..2).all(|c| (a[c] - b[c]).abs() < 1e-5 * b[0].abs()), "{method}: {a:?} {b:?}");
        }
    }
}

/// From the first limit point of Lee's frame to the stable path beyond the second, under the same load.
#[test]
fn a_jump_lands_where_the_arc_length_arrives() {
    let jumped = solve("05_lee_frame/jump.toml", &[]);
    let followed = solve("05_lee_frame/path.toml", &[]);
    let step = &jumped.history.steps[0];
    assert_eq!((step.status, step.stable), (Status::Converged, Some(true)));
    assert_eq!(step.jumps.len(), 1);
    assert!(step.jumps[0].released > 0.0);
    let (a, b) = (last_displacement(&jumped, "P"), last_displacement(&followed, "P"));
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() < 1e-4, "{a} against {b}");
    }
}

/// A prototype gave 6.61 N for the greatest load of the guided chain, 194 mm after the snap at 6.67 N, and the first
/// increment beyond its loss of symmetry without guides at 3.4 N.
#[test]
fn a_chain_of_muscles_leans_over_or_snaps() {
    let load = 6.8;
    let pressed = |solution: &Solution| {
        let inflated = &solution.history.steps[0].increments.last().expect("a state").state;
        let pressed = &solution.history.steps[1].increments.last().expect("a state").state;
        let end = solution.model.nodes.iter().position(|node| node.name == "Q").expect("the end");
        inflated.nodes[end].displacement[1] - pressed.nodes[end].displacement[1]
    };
    let guided = solve("wheel_chain/guided.toml", &[]);
    let step = &guided.history.steps[1];
    assert_eq!((step.status, step.stable), (Status::Converged, Some(true)));
    let largest = step.critical_points.iter().map(|point| load * point.fraction).fold(0.0, f64::max);
    assert!((largest / 6.61 - 1.0).abs() < 0.03, "{largest}");
    assert!(!step.jumps.is_empty() && step.jumps.iter().all(|jump| jump.released > 0.0));
    assert!((pressed(&guided) / 194.0 - 1.0).abs() < 0.02, "{}", pressed(&guided));

    let free = solve("wheel_chain/free.toml", &[]);
    let point = &free.history.steps[1].critical_points[0];
    assert_eq!(point.kind, CriticalKind::Bifurcation);
    assert!((2.5..3.4).contains(&(load * point.fraction)), "{}", load * point.fraction);
    // From 10 to 100 increments, which agree in nine digits; it leans over to one side from there.
    assert!((point.fraction / 0.429_253_555 - 1.0).abs() < LOAD, "{}", point.fraction);
    assert!(point.error.is_some_and(|error| error < LOAD));
    assert_eq!((free.history.steps[1].status, free.history.steps[1].stable), (Status::Converged, Some(true)));
    assert!((pressed(&free) / 178.4957 - 1.0).abs() < 1e-5, "{}", pressed(&free));
}

/// A shallow clamped arch, pushed down by its crown and let up again: it leans aside between two points of its straight path.
const ARCH: &str = r#"
    format = "pennate/1"
    nodes = { A = [-50, 0], M = [0, 8], B = [50, 0] }
    materials.abs = { youngs_modulus = 2200, poissons_ratio = 0.3 }
    sections.strip = { rectangle = { width = 10, height = 1 } }
    supports = { A = "clamped", B = "clamped" }
    [members]
    left  = { nodes = ["A", "M"], section = "strip", material = "abs", arc = [-25, 6.037910151091438] }
    right = { nodes = ["M", "B"], section = "strip", material = "abs", arc = [25, 6.037910151091438] }
    [probes]
    force = { node = "M", reaction = "uy" }
    turn = { node = "M", rotation = "rz" }
"#;

fn arch(steps: &str) -> Solution {
    let text = format!("{ARCH}{steps}");
    let model = pennate_models::read_text("arch.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = Options { estimate: true, ..Options::default() };
    solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}"))
}

/// Where the branch that leans aside comes back to the straight one the arc goes on along that, both ways and from any
/// number of increments, to the state that the ramp of displacements leads to.
/// Arches whose crown is pushed down by so much lean to a side, in space as in the plane, whichever way their halves are
/// drawn: a mesh that is not the same from either end of an element would bend the path to the leaning branch.
#[test]
fn arches_in_space_lean_at_the_bifurcation_that_they_have_in_the_plane() {
    let hinged = "[\"ux\", \"uy\", \"uz\", \"rx\", \"ry\"]";
    for (radius, side, rise, down, support) in
        [(65.72, 28.43, 27.06, 17.8, hinged), (50.0, 20.0, 20.0, 14.0, hinged), (109.0, 27.3, 12.1, 9.0, "\"clamped\"")]
    {
        let height = |x: f64| rise - radius + f64::sqrt(radius * radius - x * x);
        let end = f64::sqrt(radius * radius - (radius - rise).powi(2));
        let text = |dimension: &str, halves: [&str; 2]| {
            let way = |x: f64| format!("[{x}, {}]", height(x));
            format!(
                "format = \"pennate/1\"\ndimension = \"{dimension}\"\n\
                 [sections.s]\nstiffness = {{ EA = 8000, EI2 = 5, EI3 = 1, GJ = 0.8 }}\n\
                 [nodes]\nA = [{}, 0]\nB = [{end}, 0]\nC = [0, {rise}]\n\
                 [members]\n1 = {{ nodes = [{}], section = \"s\", arc = {} }}\n\
                 2 = {{ nodes = [{}], section = \"s\", arc = {} }}\n\
                 [supports]\nA = {support}\nB = {support}\n[[steps]]\ndisplacement = {{ C = {{ uy = {} }} }}\n",
                -end,
                halves[0],
                way(-side),
                halves[1],
                way(side),
                -down,
            )
        };
        let run = |dimension: &str, halves: [&str; 2]| {
            let text = text(dimension, halves);
            let model = read_text("arch.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
            let options = Options { estimate: true, ..Options::default() };
            let solution =
                solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, e)| panic!("{e}"));
            let step = &solution.history.steps[0];
            assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{dimension} {halves:?}");
            step.critical_points.iter().map(|point| (point.kind, point.fraction)).collect::<Vec<_>>()
        };
        let plane = run("plane", ["\"A\", \"C\"", "\"C\", \"B\""]);
        assert_eq!(plane.len(), 1, "{plane:?}");
        for halves in [["\"A\", \"C\"", "\"C\", \"B\""], ["\"A\", \"C\"", "\"B\", \"C\""]] {
            let space = run("space", halves);
            assert_eq!(space.len(), 1, "{space:?}");
            assert_eq!((plane[0].0, space[0].0), (CriticalKind::Bifurcation, CriticalKind::Bifurcation));
            assert_load(space[0].1, plane[0].1);
        }
    }
}

fn solve_text(text: &str, accuracy: f64) -> Solution {
    let model = read_text("network.toml", text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = Options { estimate: true, ..Options::default() };
    solve_to_accuracy(model, accuracy, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}"))
}

/// A mesh that is refined for the leaning state of an arch is not symmetric, and meets no bifurcation: that of the mesh before it is
/// listed all the same, without an error, and the accuracy is not met.
#[test]
fn a_point_that_a_finer_mesh_does_not_meet_is_kept() {
    let text = "format = \"pennate/1\"\ndimension = \"plane\"\n\
        [sections.s]\nstiffness = { EA = 0.38007009, EI3 = 1 }\n\
        [nodes]\nA = [-50, 0]\nB = [50, 0]\nC = [0, 49]\n\
        [members]\nl = { nodes = [\"A\", \"C\"], section = \"s\", arc = [-35.00357124637428, 34.7077257616064] }\n\
        r = { nodes = [\"C\", \"B\"], section = \"s\", arc = [35.00357124637428, 34.7077257616064] }\n\
        [supports]\nA = \"pinned\"\nB = \"pinned\"\n[[steps]]\ndisplacement = { C = { uy = -22.9494 } }\n";
    for accuracy in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8] {
        let solution = solve_text(text, accuracy);
        let step = &solution.history.steps[0];
        assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{accuracy}");
        let [point] = step.critical_points.as_slice() else { panic!("{accuracy}: {:?}", step.critical_points.len()) };
        assert_eq!(point.kind, CriticalKind::Bifurcation);
        // On the meshes that these accuracies need it lies within 2e-4 of where the finest has it.
        assert!((point.fraction - 0.436_741_26).abs() < 2e-4, "{accuracy}: {}", point.fraction);
        assert!(point.error.is_some() || !solution.accuracy.is_met(), "{accuracy}");
    }
}

/// A strip between a clamp and an end that is pulled and turned: a rotation that names rx and ry holds them where stability in space is
/// judged, and one that names rz alone does not.
#[test]
fn what_a_step_holds_out_of_the_plane_is_held() {
    for (rotation, expected) in [("[0, 0, 36.5]", Status::Converged), ("{ rz = 36.5 }", Status::Bifurcation)] {
        let solution = solve_text(
            &format!(
                "format = \"pennate/1\"\n[sections.t]\nstiffness = {{ EA = 5.445, EI3 = 1, EI2 = 1, GJ = 0.8 }}\n\
                 [nodes]\nA = [0, 0]\nB = [68.93785589546296, 0]\n\
                 [members]\nm = {{ nodes = [\"A\", \"B\"], section = \"t\" }}\n[supports]\nA = \"clamped\"\n\
                 [[steps]]\nforce = {{ B = [0.13866870977870352, 0] }}\n[[steps]]\nrotation = {{ B = {rotation} }}\n"
            ),
            1e-6,
        );
        assert_eq!(solution.history.steps[1].status, expected, "{rotation}");
    }
}

/// The error with which a place was reached is that of the place where it is held.
#[test]
fn the_error_of_a_place_that_is_held_is_known_afterwards() {
    let text = "format = \"pennate/1\"\ndimension = \"plane\"\n[sections.s]\nstiffness = { EA = 1e4, EI3 = 1e3 }\n\
        [nodes]\nA = [0, 0]\nB = [100, 0]\nC = [100, 60]\n\
        [members]\na = { nodes = [\"A\", \"B\"], section = \"s\" }\nb = { nodes = [\"B\", \"C\"], section = \"s\" }\n\
        [supports]\nA = \"clamped\"\n[[steps]]\nforce = { C = [0.4, -0.5] }\n\
        [[steps]]\nhold = { C = [\"ux\", \"uy\"] }\nforce = { C = [0, 0] }\n";
    let (coarse, exact) = (solve_text(text, 1e-3), solve_text(text, 1e-10));
    for step in 0..2 {
        let [state, right] = [&coarse, &exact].map(|solution| solution.history.steps[step].increments.last());
        let [state, right] = [state, right].map(|increment| &increment.expect("a state").state);
        let refined = coarse.history.steps[step].refined.as_ref().expect("an estimate");
        for node in 1..3 {
            let apart = |other: &[f64; 3]| {
                let here = &state.nodes[node].displacement;
                here.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
            };
            let (stated, wrong) = (apart(&refined.nodes[node].displacement), apart(&right.nodes[node].displacement));
            println!("step {step}, node {node}: {stated:e} stated, {wrong:e} wrong");
            assert!(
                wrong > 1e-9 && (wrong / 3.0..3.0 * wrong).contains(&stated),
                "{step} {node}: {stated:e} {wrong:e}"
            );
        }
    }
}

/// Two bars as a V, `h` high, whose middle at `x` is pushed down by `by` and let back, with as many increments for each step.
fn pushed_and_let_back((h, x): (f64, f64), (stiffness, by): (f64, f64), increments: usize) -> Solution {
    let step = |to: f64| format!("[[steps]]\nincrements = {increments}\ndisplacement = {{ M = {{ uy = {to} }} }}\n");
    let text = format!(
        "format = \"pennate/1\"\ndimension = \"plane\"\n[sections.s]\nstiffness = {{ EA = {stiffness}, EI3 = 1 }}\n\
         [nodes]\nA = [-50, 0]\nM = [{x}, {h}]\nB = [50, 0]\n\
         [members]\nl = {{ nodes = [\"A\", \"M\"], section = \"s\" }}\nr = {{ nodes = [\"M\", \"B\"], section = \"s\" }}\n\
         [supports]\nA = \"pinned\"\nB = \"pinned\"\n{}{}",
        step(by),
        step(0.0)
    );
    solve_text(&text, 1e-6)
}

/// On the way back a leaning branch ends where it began on the way there, whatever the increments: at the same place of the ramp, seen
/// from its other end. A network that is nearly symmetric has no such place on its way.
#[test]
fn the_way_back_lists_where_a_leaning_branch_ends() {
    let nets = [(8.106_386_75, 23.905_871_05, -6.055_898_47), (7.905_168_92, 730.959_027_68, -2.821_107_19)];
    for (h, stiffness, by) in nets {
        for increments in [1, 7, 60] {
            let solution = pushed_and_let_back((h, 0.0), (stiffness, by), increments);
            let [there, back] = &solution.history.steps[..] else { panic!("two steps") };
            let one = |step: &StepHistory| {
                assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{h} {increments}");
                let [point] = step.critical_points.as_slice() else { panic!("{h} {increments}: not one point") };
                assert_eq!((point.kind, point.sideways), (CriticalKind::Bifurcation, false));
                (point.fraction, point.error.expect("an error"))
            };
            let ((first, doubt), (last, other)) = (one(there), one(back));
            let apart = (first + last - 1.0).abs();
            assert!(apart <= doubt + other && apart < 1e-7, "{h} {increments}: {first} {last}, {doubt:e} {other:e}");
        }
    }
    let imperfect = pushed_and_let_back((nets[0].0, 0.1), (nets[0].1, nets[0].2), 1);
    for step in &imperfect.history.steps {
        assert_eq!((step.status, step.critical_points.len()), (Status::Converged, 0));
    }
}

#[test]
fn the_arc_of_a_shallow_arch_goes_on_where_its_leaning_branch_ends() {
    let ramp = |method: &str, increments: usize| {
        let step = |by: i32| {
            format!(
                "[[steps]]\nmethod = \"{method}\"\nincrements = {increments}\ndisplace_by = {{ M = {{ uy = {by} }} }}\n"
            )
        };
        arch(&format!("{}{}", step(-16), step(16)))
    };
    let direct = ramp("newton", 1);
    for (method, increments) in
        [("arc_length", 1), ("arc_length", 3), ("arc_length", 40), ("arc_length", 200), ("jump", 1), ("jump", 15)]
    {
        let solution = ramp(method, increments);
        for (index, step) in solution.history.steps.iter().enumerate() {
            assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{method} {increments}");
            let kinds: Vec<_> = step.critical_points.iter().map(|point| point.kind).collect();
            assert_eq!(kinds, [CriticalKind::Bifurcation; 2], "{method} {increments}");
            for (point, expected) in step.critical_points.iter().zip(&direct.history.steps[index].critical_points) {
                assert_load(point.fraction, expected.fraction);
            }
            let probes = |solution: &Solution| solution.probes.steps[index].last().expect("a state").to_vec();
            for (found, expected) in probes(&solution).iter().zip(probes(&direct)) {
                assert!((found - expected).abs() < 1e-5, "{method} {increments}: {found} {expected}");
            }
            // It did lean aside on the way.
            let leant = step.increments.iter().map(|increment| increment.state.nodes[1].rotation_total.abs());
            assert!(leant.fold(0.0, f64::max) > 0.05);
        }
    }
}

/// Under a force the same arch goes through both limit points, and through both ends of the branch that leans aside.
#[test]
fn the_arc_of_a_shallow_arch_under_a_force_goes_through_its_limit_points_both_ways() {
    for increments in [1, 30] {
        let step = |force: f64| {
            format!("[[steps]]\nmethod = \"arc_length\"\nincrements = {increments}\nforce = {{ M = [0, {force}] }}\n")
        };
        let solution = arch(&format!("{}{}", step(-20.0), step(20.0)));
        for step in &solution.history.steps {
            assert_eq!((step.status, step.stable), (Status::Converged, Some(true)));
            let kinds: Vec<_> = step.critical_points.iter().map(|point| point.kind).collect();
            use CriticalKind::{Bifurcation, LimitPoint};
            assert_eq!(kinds, [LimitPoint, Bifurcation, Bifurcation, LimitPoint]);
        }
    }
}

/// A path that comes through one of its limit points again is a loop: no further round is made.
#[test]
fn a_path_that_closes_to_a_loop_is_left_after_one_round() {
    let step = &solve("../tests/cases/toggles_in_a_loop.toml", &[]).history.steps[0];
    let cause = step.failure.as_ref().map(|failure| failure.cause);
    assert_eq!((step.status, cause), (Status::NotConverged, Some(Cause::Endless)));
    assert!(step.increments.len() < 2000, "{}", step.increments.len());
}

#[test]
fn a_path_that_leads_away_from_its_ramp_is_given_up() {
    let step = &solve("../tests/cases/path_leads_away.toml", &[]).history.steps[0];
    assert_eq!(step.failure.as_ref().map(|failure| failure.cause), Some(Cause::LeadsAway));
    assert!(step.status == Status::NotConverged && step.fraction < -100.0, "ends at {}", step.fraction);
    assert!(step.critical_points.len() >= 4, "what it passed is listed");
}

#[test]
fn no_finer_mesh_is_tried_for_a_point_that_none_locates_better() {
    let solution = solve("../tests/cases/branches_that_nearly_meet.toml", &[]);
    let step = &solution.history.steps[0];
    let first = &step.critical_points[0];
    let error = first.error.expect("an error");
    // Where a ramp from two increments on has its limit point, with an accuracy of 1e-9.
    assert!((first.fraction - 0.098_728_8).abs() < error && error < 1e-3, "{} ± {error}", first.fraction);
    assert_eq!((step.status, solution.accuracy.verdict), (Status::Converged, Verdict::Stalled));
    // Two that follow its path, and two that refine all members, which tell its error.
    assert!(solution.accuracy.rounds <= 4, "{} meshes", solution.accuracy.rounds);
}

#[test]
fn the_end_of_the_ramp_comes_before_a_stop_beyond_it() {
    let step = &solve("../tests/cases/stop_beyond_the_ramp.toml", &[]).history.steps[0];
    assert_eq!((step.status, step.fraction), (Status::Converged, 1.0));
}

/// Far from the point where both sways are lost the twist is the softest motion, and the smallest pivot is zero beside it.
#[test]
fn motions_that_are_lost_together_are_located_alike_by_all_methods() {
    let path = validation("../tests/cases/plate_on_columns.toml");
    let text = std::fs::read_to_string(path).expect("a file");
    for method in ["newton", "arc_length", "jump"] {
        let text = text.replace("\"jump\"", &format!("\"{method}\""));
        let model = pennate_models::read_text("plate.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
        let options = Options { estimate: true, ..Options::default() };
        let solution =
            solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}"));
        let first = &solution.history.steps[0].critical_points[0];
        let error = first.error.expect("an error");
        assert_eq!(first.kind, CriticalKind::Bifurcation);
        // From 100 increments on the straight path, with elements of a sixteenth of a column.
        assert!((first.fraction - 0.492_438_071).abs() < 1e-8, "{method}: {} ± {error}", first.fraction);
        assert!(error < 1e-7, "{method}: {error}");
    }
}

/// Long elements have limit points there that short ones have not; two meshes that share the elements at the turned end agree.
#[test]
fn taut_rods_are_turned_without_a_limit_point() {
    let step = &solve("../tests/cases/turned_taut_rods.toml", &[]).history.steps[0];
    assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{}", step.fraction);
    assert!(step.critical_points.is_empty());
}

#[test]
fn a_later_step_that_pulls_members_taut_costs_no_digits_of_a_critical_load() {
    let history = solve("../tests/cases/taut_in_a_later_step.toml", &[]).history;
    let step = &history.steps[1];
    let point = &step.critical_points[0];
    let error = point.error.expect("an error");
    assert_eq!((step.status, point.kind), (Status::Converged, CriticalKind::Bifurcation));
    // The same without the later steps, on up to 256 elements a member.
    assert!((point.fraction - 0.310_480_926).abs() < (10.0 * error).min(1e-5), "{} ± {error}", point.fraction);
}
