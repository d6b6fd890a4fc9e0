//! Axial forces of members that cannot be stretched: found, said to be undetermined, or said not to exist.

use std::path::Path;

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_models::{Mesh, discretize, read, read_text};
use pennate_solver::error::SolveError;
use pennate_solver::history::{Cause, History, Note, Status};
use pennate_solver::options::Options;

fn solve(case: &str, settings: &[(&str, &str)], increments: Option<usize>) -> History {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases").join(case);
    let settings: Vec<_> = settings.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let model = read(&file, &settings).expect("a network");
    let (structure, mut steps) = discretize(&model, &Mesh::initial(&model, 1e-6));
    steps.iter_mut().for_each(|step| step.min_increments = increments);
    pennate_solver::solve(&structure, &steps, &Options::default(), &mut |_| true).expect("no mechanism")
}

/// Straight between two clamps it cannot bend, and no axial force carries what acts across it; that is no limit point.
#[test]
fn a_bar_held_at_both_ends_under_a_load_across_has_no_equilibrium() {
    for across in ["0.01", "1"] {
        for increments in [None, Some(100)] {
            let history = solve("overheld.toml", &[("across", across)], increments);
            let step = &history.steps[0];
            assert_eq!(step.status, Status::NotConverged, "{across} {increments:?}");
            assert_eq!(step.failure.as_ref().expect("a cause").cause, Cause::Overheld { member: 0 });
            // A hundredth of the load of 1 bends the bar by less than rounding can tell from no stretch at all.
            let reached = step.fraction * across.parse::<f64>().expect("a number").abs();
            assert!(step.critical_points.is_empty() && reached < 0.01, "{across} {increments:?}: {reached}");
        }
    }
}

/// A moment on its end alone bends it no more than a load across does.
#[test]
fn a_bar_held_at_both_ends_under_a_moment_has_no_equilibrium() {
    for increments in [None, Some(10), Some(100)] {
        let history = solve("overheld_by_a_moment.toml", &[], increments);
        let step = &history.steps[0];
        assert_eq!(step.status, Status::NotConverged, "{increments:?}");
        assert_eq!(step.failure.as_ref().expect("a cause").cause, Cause::Overheld { member: 0 }, "{increments:?}");
    }
}

/// What nothing holds against turning about itself is said where it has a moment; where a node holds it, it is not.
#[test]
fn a_bar_that_would_turn_about_itself_is_named() {
    let note = Note::TurnedAboutItself { members: vec![0] };
    let said = |across: &str| solve("turned_bar.toml", &[("across", across)], None).steps[0].notes.contains(&note);
    assert!(said("0.01"));
    assert!(!said("0"));
}

/// A motion whose stiffness is no more than rounding is free, whatever sign its pivot has; on any mesh.
#[test]
fn what_rounding_alone_resists_is_a_mechanism() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases/turns_about_its_support.toml");
    let model = read(&file, &[]).expect("a network");
    for accuracy in [1e-2, 1e-4, 1e-6, 1e-8] {
        let (structure, steps) = discretize(&model, &Mesh::initial(&model, accuracy));
        let solved = pennate_solver::solve(&structure, &steps, &Options::default(), &mut |_| true);
        assert!(matches!(solved, Err(SolveError::Mechanism(_))), "{accuracy:e}");
    }
}

/// Without a load across any axial force is in equilibrium.
#[test]
fn the_force_of_a_bar_held_at_both_ends_is_undetermined() {
    let history = solve("overheld.toml", &[("across", "0")], None);
    let step = &history.steps[0];
    assert_eq!(step.status, Status::Converged);
    assert!(step.notes.contains(&Note::Undetermined { members: vec![0] }), "{:?}", step.notes);
}

/// A braced frame on two clamps, or on a body at the end of a stalk that bends by 30°; with one bar less than `redundant` it is
/// statically determinate.
fn braced(on_a_stalk: bool, redundant: bool, soft: f64) -> String {
    let [soft, stiff] =
        [soft, 50.0].map(|bending| format!("{{ stiffness = {{ EI3 = {bending:e} }}, stretch = false }}"));
    let foot = match on_a_stalk {
        true => {
            "supports.G = \"clamped\"\nrigid_bodies.base = { nodes = [\"P0\", \"P1\"] }\n\
             members.stalk = { nodes = [\"G\", \"P0\"], section = \"stalk\" }\n"
        }
        false => "supports = { G = \"clamped\", P0 = \"clamped\", P1 = \"clamped\" }\n",
    };
    let last = if redundant { "members.f = { nodes = [\"P1\", \"P3\"], section = \"stiff\" }\n" } else { "" };
    format!(
        "format = \"pennate/1\"\ndimension = \"plane\"\n\
         nodes = {{ G = [0, 0], P0 = [100, 0], P1 = [140, 0], P2 = [140, 40], P3 = [100, 40] }}\n\
         sections.stalk = {{ stiffness = {{ EA = 1e4, EI3 = 100 }} }}\n\
         sections.soft = {soft}\nsections.stiff = {stiff}\n\
         members.b = {{ nodes = [\"P1\", \"P2\"], section = \"soft\" }}\n\
         members.c = {{ nodes = [\"P2\", \"P3\"], section = \"stiff\" }}\n\
         members.d = {{ nodes = [\"P3\", \"P0\"], section = \"stiff\" }}\n\
         members.e = {{ nodes = [\"P0\", \"P2\"], section = \"soft\" }}\n{last}{foot}\
         steps = [{{ force.P2 = [0, {load}] }}]\n",
        load = if on_a_stalk { 1e-2 } else { 1e-6 },
    )
}

/// Forces that are in equilibrium with each other are of one size in soft and in stiff members.
#[test]
fn forces_of_a_redundant_frame_are_undetermined_however_stiff_its_members_are_beside_each_other() {
    for on_a_stalk in [false, true] {
        for soft in [50.0, 5e-2, 5e-3] {
            for redundant in [false, true] {
                let model = read_text("frame.toml", &braced(on_a_stalk, redundant, soft), &[]).expect("a network");
                let bars: Vec<_> = (0..model.members.len()).filter(|&id| model.members[id].name != "stalk").collect();
                let solution =
                    solve_to_accuracy(model, 1e-6, &Options::default(), &mut |_| true).expect("no mechanism");
                let step = &solution.history.steps[0];
                let case = format!("{on_a_stalk} {soft} {redundant}: {:?}", step.notes);
                assert_eq!(step.status, Status::Converged, "{case}");
                let named = step.notes.iter().find_map(|note| match note {
                    Note::Undetermined { members } => Some(members),
                    _ => None,
                });
                assert_eq!(named, redundant.then_some(&bars), "{case}");
            }
        }
    }
}

/// Where a shallow arch of two bars buckles, next to nothing is needed to move it; two bars that meet at an angle determine their forces.
#[test]
fn forces_beside_a_singular_state_are_determined() {
    let text = "format = \"pennate/1\"\ndimension = \"plane\"\n\
                nodes = { P0 = [0, 0], P1 = [2.2378142327136006, -45.117514484312274], P2 = [0, -93.25803865732722] }\n\
                sections.s = { stiffness.EI3 = 0.17844687922342464, stretch = false }\n\
                members.a = { nodes = [\"P0\", \"P1\"], section = \"s\" }\n\
                members.b = { nodes = [\"P1\", \"P2\"], section = \"s\" }\n\
                supports = { P0 = \"clamped\", P2 = \"pinned\" }\n\
                steps = [{ force.P1 = [-0.0003374248278649969, 9.261062799463998e-6] }]\n";
    let model = read_text("arch.toml", text, &[]).expect("a network");
    let solution = solve_to_accuracy(model, 1e-6, &Options::default(), &mut |_| true).expect("no mechanism");
    let notes = &solution.history.steps[0].notes;
    assert!(!notes.iter().any(|note| matches!(note, Note::Undetermined { .. })), "{notes:?}");
}

/// The wire gives way by less than the auxiliary stiffness of the bar does, down to a ten-thousandth of it: the force is that of
/// the wire all the same, after few iterations.
#[test]
fn a_stiff_wire_determines_the_force_of_a_bar_that_cannot_be_stretched() {
    for (stiffness, value) in [("1e3", 1e3), ("1e5", 1e5), ("1e7", 1e7), ("1e8", 1e8)] {
        let history = solve("taut_row.toml", &[("EA", stiffness)], None);
        let step = &history.steps[0];
        assert_eq!(step.status, Status::Converged, "{stiffness}: {:?}", step.failure);
        assert!(step.notes.is_empty(), "{stiffness}: {:?}", step.notes);
        assert!(step.iterations <= 12, "{stiffness}: {} iterations", step.iterations);
        let force = step.increments.last().expect("a state").state.members[0].axial_force;
        let expected = value * 1e-3 / 100.0;
        assert!((force - expected).abs() < 1e-7 * expected, "{stiffness}: {force} for {expected}");
    }
}

/// Its tension is many times the auxiliary stiffness that would hold its shear if bending alone told it: what that cannot bear would
/// pass for a loss of stability.
#[test]
fn a_taut_thread_that_cannot_be_sheared_is_stable() {
    for angle in ["0", "30"] {
        for stiffness in ["1e5", "1e7", "1e9"] {
            for increments in [None, Some(10)] {
                let settings = [("angle", angle), ("EA", stiffness)];
                let history = solve("taut_thread.toml", &settings, increments);
                let step = &history.steps[0];
                assert_eq!(step.status, Status::Converged, "{settings:?} {increments:?}: {:?}", step.failure);
                assert!(step.critical_points.is_empty() && step.stable == Some(true), "{settings:?} {increments:?}");
                let force = step.increments.last().expect("a state").state.members[0].axial_force;
                let expected = 0.007 * stiffness.parse::<f64>().expect("a number");
                assert!((force - expected).abs() < 1e-9 * expected, "{settings:?}: {force} for {expected}");
            }
        }
    }
}

/// Bars that cannot be stretched, pulled farther apart than they reach, turned in their plane and kinked by so much: the part of the
/// ramp at which they are straight.
fn pulled(bars: usize, kink: f64, turn: f64, farther: f64) -> (String, f64) {
    let (sine, cosine) = turn.sin_cos();
    let place = |x: f64, y: f64| format!("[{}, {}]", cosine * x - sine * y, sine * x + cosine * y);
    let node = |k: usize| format!("N{k} = {}\n", place(50.0 * k as f64, if k % 2 == 1 { kink } else { 0.0 }));
    let bar = |k: usize| format!("m{k} = {{ nodes = [\"N{k}\", \"N{}\"], section = \"s\" }}\n", k + 1);
    let (nodes, members): (String, String) = ((0..=bars).map(node).collect(), (0..bars).map(bar).collect());
    let apart = farther * (bars as f64 * 50.0f64.hypot(kink) - 50.0 * bars as f64);
    let text = format!(
        "format = \"pennate/1\"\n[nodes]\n{nodes}[sections]\ns = {{ stiffness = {{ EI3 = 120 }}, stretch = false }}\n\
         [members]\n{members}[supports]\nN0 = \"clamped\"\n[[steps]]\ndisplacement = {{ N{bars} = {{ ux = {}, uy = {} }} }}\n",
        cosine * apart,
        sine * apart
    );
    (text, 1.0 / farther)
}

/// No equilibrium branches off and no path turns back where a chain of bars is pulled straight: the limit is its reach, and told as
/// well as that is said.
#[test]
fn bars_that_are_pulled_straight_end_at_their_reach() {
    for (bars, kink, turn, farther) in
        [(2, 20.0, 0.0, 1.5), (2, 5.0, 0.7, 1.1), (4, 12.0, 2.0, 1.8), (2, 30.0, -1.1, 3.0)]
    {
        for increments in [None, Some(40_usize)] {
            let (text, exact) = pulled(bars, kink, turn, farther);
            let text = increments.map_or(text.clone(), |count| format!("{text}increments = {count}\n"));
            let model = read_text("bars.toml", &text, &[]).expect("a network");
            let options = Options { estimate: true, ..Options::default() };
            let solution = solve_to_accuracy(model, 1e-6, &options, &mut |_| true).expect("no mechanism");
            let step = &solution.history.steps[0];
            let case = format!("{bars} {kink} {increments:?}: {:?}", step.critical_points);
            assert_eq!(step.status, Status::LimitPoint, "{case}");
            assert!(matches!(step.failure.as_ref().expect("a cause").cause, Cause::Taut { .. }), "{case}");
            let [point] = step.critical_points.as_slice() else { panic!("{case}") };
            let located = point.located.expect("how well");
            assert!((point.fraction - exact).abs() <= located && located < 1e-3, "{case}, {exact}");
            assert!(step.fraction < exact, "{case}");
        }
    }
}
