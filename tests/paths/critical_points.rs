//! Limit points and bifurcations of the references, from their network files with default settings.

use std::path::{Path, PathBuf};

use pennate_analysis::accuracy::{Verdict, solve_to_accuracy};
use pennate_analysis::solution::Solution;
use pennate_models::{read, read_text};
use pennate_solver::history::{Cause, CriticalKind, Status};
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

pub(super) fn reference(case: &str) -> Value {
    let text = std::fs::read_to_string(validation(case).join("reference.json")).expect("a reference");
    serde_json::from_str(&text).expect("a reference in JSON")
}

pub(super) fn solve(file: &str, settings: &[(&str, &str)]) -> Solution {
    let settings: Vec<_> = settings.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let model = read(&validation(file), &settings).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = Options { estimate: true, ..Options::default() };
    solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}"))
}

/// The displacement of a node at the last increment of the first step.
pub(super) fn last_displacement(solution: &Solution, node: &str) -> [f64; 3] {
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
pub(super) fn assert_load(now: f64, expected: f64) {
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

pub(super) fn solve_text(text: &str, accuracy: f64) -> Solution {
    let model = read_text("network.toml", text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = Options { estimate: true, ..Options::default() };
    solve_to_accuracy(model, accuracy, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}"))
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

/// Its end is at (12, 16) and may go to (20, 0): no element leans so far against its chord that the rod comes longer than it is.
#[test]
fn a_corotational_rod_ends_at_its_reach() {
    let history = solve("../tests/cases/pulled_beyond_its_reach.toml", &[]).history;
    let step = &history.steps[0];
    let point = step.critical_points.last().expect("a point");
    assert_eq!((step.status, point.kind), (Status::LimitPoint, CriticalKind::LimitPoint));
    let located = point.located.expect("how far off it is");
    assert!((point.fraction - 8.0 / 14.0).abs() <= located && located < 1e-4, "{} ± {located}", point.fraction);
    assert!(step.fraction <= 8.0 / 14.0, "{}", step.fraction);
}
