//! Equilibria that are followed.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use pennate_analysis::problem::{Control, Live, Problem, Reason};
use pennate_models::Document;

const DYAD: &str = include_str!("../../../models/networks/dyad.toml");

fn dyad() -> Problem {
    let text = DYAD.replace("L = 130", "p = 20\nL = 130").replace("left = \"25 psi\", pair = 25", "all = \"= p\"");
    let document = Document::from_text("dyad.toml", &text);
    Problem::new(&document, &[], &["p", "L", "beta"], &["holding", "stroke"], 1e-6).unwrap()
}

fn is_near(live: &Live, problem: &Problem) {
    let answer = problem.evaluate(live.present());
    for (followed, solved) in live.values().iter().zip(&answer.values) {
        assert!((followed - solved).abs() < 1e-8 * (1.0 + solved.abs()), "{followed} {solved}");
    }
}

/// Pressure alone, then geometry too: where the state is followed to is where a solve from the beginning ends.
#[test]
fn a_followed_state_is_the_one_that_is_solved_for() {
    let problem = dyad();
    let mut live = problem.live().unwrap();
    is_near(&live, &problem);
    for (parameter, value) in [(0, 21.0), (0, 12.5), (2, 25.0), (1, 120.0), (0, 24.0)] {
        live.set(parameter, value);
        live.solve().unwrap();
        assert_eq!(live.present()[parameter], value);
        assert_eq!(live.stable(), Some(true));
        is_near(&live, &problem);
    }
}

/// A flat arch that is pushed down follows its load up to the limit point, and stays at the last good state before it.
#[test]
fn a_state_that_ends_is_kept_where_it_ended() {
    let text = r#"
        format = "pennate/1"
        dimension = "plane"
        parameters = { F = 0.1, h = 10 }
        nodes = { A = [-100, 0], C = [0, "= h"], B = [100, 0] }
        sections = { bar = { stiffness = { EA = 1000, GA2 = 1000, EI3 = 1e4 } } }
        members = { a = { nodes = ["A", "C"], section = "bar" }, b = { nodes = ["C", "B"], section = "bar" } }
        supports = { A = "pinned", B = "pinned" }
        steps = [{ name = "push", force = { C = [0, "= -F"] } }]
        probes = { drop = { node = "C", displacement = "uy" } }
    "#;
    let document = Document::from_text("arch.toml", text);
    let problem = Problem::new(&document, &[], &["F", "h"], &["drop"], 1e-6).unwrap();
    let mut live = problem.live().unwrap();
    live.set(0, 50.0);
    assert!(matches!(live.solve(), Err(Reason::Lost { .. })));
    let reached = live.present()[0];
    assert!(reached > 0.1 && reached < 50.0, "{reached}");
    assert_eq!(live.stable(), Some(true));
    is_near(&live, &problem);
    // From there it goes back.
    live.set(0, 0.2);
    live.solve().unwrap();
    is_near(&live, &problem);
}

#[test]
fn many_states_are_followed_side_by_side() {
    let problem = dyad();
    let mut all = problem.live_all(3).unwrap();
    all.set(&[20.0, 130.0, 22.0, 15.0, 130.0, 22.0, 20.0, 128.0, 24.0]);
    assert!(all.solve().iter().all(Option::is_none));
    let answer = problem.evaluate(&[20.0, 130.0, 22.0, 15.0, 130.0, 22.0, 20.0, 128.0, 24.0]);
    for (followed, solved) in all.values().iter().zip(&answer.values) {
        assert!((followed - solved).abs() < 1e-8 * (1.0 + solved.abs()), "{followed} {solved}");
    }
    assert_eq!(all.stable(), [Some(true); 3]);
}

/// Outputs of steps before the last one are those of a solve from the beginning, whatever the parameter changes.
#[test]
fn outputs_of_earlier_steps_follow_too() {
    let text = DYAD
        .replace("L = 130", "p = 20\ndown = 0\nL = 130")
        .replace("left = \"25 psi\", pair = 25", "all = \"= p\"")
        .replace("uy = 0.0", "uy = \"= down\"")
        .replace("[probes]", "[probes]\nboth = \"= holding + stroke@inflate\"");
    let document = Document::from_text("dyad.toml", &text);
    let probes = ["stroke@inflate", "holding", "both"];
    let problem = Problem::new(&document, &[], &["p", "down", "beta"], &probes, 1e-6).unwrap();
    let mut live = problem.live().unwrap();
    is_near(&live, &problem);
    for (parameter, value) in [(1, -1.0), (0, 22.0), (2, 25.0), (1, 0.5)] {
        live.set(parameter, value);
        live.solve().unwrap();
        is_near(&live, &problem);
    }
    let mut other = live.another();
    other.set(0, 18.0);
    other.solve().unwrap();
    is_near(&other, &problem);
    is_near(&live, &problem);
}

/// What is held where it was stays there, whatever a solve from the beginning would hold.
#[test]
fn what_is_held_where_it_was_stays_there() {
    let end = DYAD.find("[[steps]]").unwrap();
    let probes = DYAD.find("[probes]").unwrap();
    let steps = r#"
[[steps]]
name = "inflate"
pressure = { all = "= p" }
[[steps]]
name = "hold"
hold = { J = ["uy"] }
pressure = { all = "= 0.5 * p" }
"#;
    let text = format!("{}{steps}{}", &DYAD[..end], &DYAD[probes..]).replace("L = 130", "p = 22\nL = 130");
    let document = Document::from_text("dyad.toml", &text);
    let problem = Problem::new(&document, &[], &["p"], &["stroke", "stroke@inflate"], 1e-6).unwrap();
    let mut live = problem.live().unwrap();
    let held = live.values()[0];
    live.set(0, 18.0);
    live.solve().unwrap();
    assert!((live.values()[0] - held).abs() < 1e-9 * held.abs(), "{} {held}", live.values()[0]);
    let solved = problem.evaluate(&[18.0]).values;
    assert!((solved[0] - held).abs() > 1e-3 * held.abs());
    assert!((live.values()[1] - solved[1]).abs() < 1e-8 * solved[1].abs());
}

/// A component that is moved on from a prescribed place is where both of these lead, at any values.
#[test]
fn what_is_moved_on_from_a_prescribed_place_follows_both() {
    let text = r#"
        format = "pennate/1"
        parameters = { d = 5, more = 3 }
        nodes = { A = [0, 0], B = [100, 0] }
        sections.s = { stiffness = { EA = 1e5, EI3 = 2e6, GA2 = 1e4 } }
        members.m = { nodes = ["A", "B"], section = "s" }
        supports = { A = "clamped" }
        probes = { y = { node = "B", displacement = "uy" }, push = { node = "B", reaction = "uy" } }
        steps = [{ name = "one", displacement = { B = { uy = "= d" } } }, { name = "two", hold = { B = ["uy"] } },
                 { name = "three", displace_by = { B = { uy = "= more" } } }]
    "#;
    let probes = ["y@one", "y@two", "y", "push"];
    let problem = Problem::new(&Document::from_text("bar.toml", text), &[], &["d", "more"], &probes, 1e-6).unwrap();
    let mut live = problem.live().unwrap();
    live.set(0, 5.5);
    live.set(1, 3.3);
    live.solve().unwrap();
    assert!((live.values()[2] - 8.8).abs() < 1e-9, "{:?}", live.values());
    is_near(&live, &problem);
}

/// A state whose earlier step has lost its end is there, with a word about the end that is not.
#[test]
fn an_earlier_end_that_is_lost_is_said() {
    let text = r#"
        format = "pennate/1"
        dimension = "plane"
        parameters = { F = 3 }
        nodes = { A = [-100, 0], T = [0, 10], B = [100, 0] }
        sections.s = { stiffness = { EA = 1e4, EI3 = 1e6, GA2 = 1e4 } }
        members.a = { nodes = ["A", "T"], section = "s", release = { start = ["rz"], end = ["rz"] } }
        members.b = { nodes = ["T", "B"], section = "s", release = { end = ["rz"] } }
        supports = { A = "pinned", B = "pinned" }
        probes.drop = { node = "T", displacement = "uy" }
        steps = [{ name = "all", force = { T = [0, "= -F"] } }, { name = "half", force = { T = [0, "= -F / 2"] } }]
    "#;
    let problem =
        Problem::new(&Document::from_text("arch.toml", text), &[], &["F"], &["drop@all", "drop"], 1e-6).unwrap();
    let mut live = problem.live().unwrap();
    assert!(live.values().iter().all(|value| value.is_finite()));
    live.set(0, 5.0);
    assert!(matches!(live.solve(), Err(Reason::Stopped { step: 0, .. })));
    assert!(live.values()[0].is_nan() && live.present() == [5.0]);
    let half = problem.evaluate(&[2.5]).values[0];
    assert!((live.values()[1] - half).abs() < 1e-8 * half.abs(), "{:?} {half}", live.values());
    live.set(0, 2.0);
    live.solve().unwrap();
    is_near(&live, &problem);
}

/// Where a step stops follows all parameters: what comes after has no state that follows them at the values of its end, and no derivatives.
#[test]
fn what_follows_a_stop_is_not_followed() {
    let text = r#"
        format = "pennate/1"
        parameters = { F = -50, M = 30, s = -2 }
        nodes = { A = [0, 0], B = [100, 0] }
        sections.s = { stiffness = { EA = 1e5, EI3 = 2e6, GA2 = 1e4 } }
        members.m = { nodes = ["A", "B"], section = "s" }
        supports = { A = "clamped" }
        probes.y = { node = "B", displacement = "uy" }
        steps = [{ name = "a", force = { B = [0, "= F"] }, method = "arc_length", stop = { node = "B", displacement = "uy", at = "= s" } },
                 { name = "b", moment = { B = [0, 0, "= M"] } }]
    "#;
    let document = Document::from_text("bar.toml", text);
    let problem = Problem::new(&document, &[], &["F", "M", "s"], &["y@b"], 1e-6).unwrap();
    assert!(matches!(problem.live().unwrap_err(), Reason::StopsShort { step: 0 }));
    let found = problem.gradient(&problem.middle());
    assert!(matches!(found.reasons[0], Some(Reason::StopsShort { step: 0 })), "{:?}", found.reasons);
    assert!(found.values[0].is_finite() && found.jacobian.iter().all(|slope| slope.is_nan()));
    // A load that does not come to the stop is all there.
    let found = problem.gradient(&[-10.0, 30.0, -2.0]);
    assert!(found.reasons[0].is_none() && found.jacobian.iter().all(|slope| slope.is_finite()));
    let [low, high] = [-10.01, -9.99].map(|force| problem.evaluate(&[force, 30.0, -2.0]).values[0]);
    assert!((found.jacobian[0] - (high - low) / 0.02).abs() < 1e-6 * found.jacobian[0], "{:?}", found.jacobian);
}

/// Loads that turn with their node have no potential: where masses are known small vibrations tell, whoever is asked.
#[test]
fn the_verdict_is_that_of_a_solve() {
    for (density, known) in [("", None), (", density = 1e-9", Some(true))] {
        for force in ["[\"= -0.2 * F\", \"= F\"]", "[\"= -0.2 * F\", \"= F\", \"= 0.4 * F\"]"] {
            let text = format!(
                r#"format = "pennate/1"
                parameters = {{ F = 0.5, L = 100 }}
                nodes = {{ A = [0, 0], B = ["= L", 0] }}
                materials.polymer = {{ youngs_modulus = 2000, poissons_ratio = 0.4{density} }}
                sections.rod = {{ circle = {{ radius = 1.5 }} }}
                members.rod = {{ nodes = ["A", "B"], section = "rod", material = "polymer" }}
                supports = {{ A = "clamped" }}
                steps = [{{ name = "push", follower_force = {{ B = {force} }} }}]
                probes = {{ x = {{ node = "B", position = "x" }} }}
            "#
            );
            let document = Document::from_text("rod.toml", &text);
            let problem = Problem::new(&document, &[], &["F", "L"], &["x"], 1e-6).unwrap();
            let row = [0.6, 103.0];
            assert_eq!(problem.evaluate(&row).stable, [known]);
            assert_eq!(problem.gradient(&row).stable, [known]);
            let mut all = problem.live_all(2).unwrap();
            assert_eq!(all.stable(), [known; 2]);
            all.set(&[row, row].concat());
            assert!(all.solve().iter().all(Option::is_none));
            assert_eq!(all.judged(), known.is_none().then(|| vec![None; 2]));
            assert_eq!(all.stable(), [known; 2]);
            assert_eq!(all.judged(), Some(vec![known; 2]));
        }
    }
}

/// A way that is stopped ends at an equilibrium on it, whose values are those that are told.
#[test]
fn a_way_that_is_stopped_ends_where_it_came_to() {
    let text = DYAD
        .replace("L = 130", "p = 20\nL = 130")
        .replace("left = \"25 psi\", pair = 25", "all = \"= p\"")
        .replace("[probes]", "[probes]\nboth = \"= holding + stroke@inflate\"");
    let document = Document::from_text("dyad.toml", &text);
    let problem = Problem::new(&document, &[], &["p", "beta"], &["stroke@inflate", "holding", "both"], 1e-6).unwrap();
    let mut live = problem.live().unwrap();
    let stopped = Control { stop: Some(Arc::new(AtomicBool::new(true))), ..Control::default() };
    let before = live.values().to_vec();
    live.set(0, 24.0);
    assert!(matches!(live.solve_while(&stopped), Err(Reason::Interrupted)));
    assert_eq!((live.values(), live.present()[0]), (before.as_slice(), 20.0));
    assert!(matches!(problem.live_while(&stopped), Err(Reason::Interrupted)));
    assert!(matches!(problem.live_all_while(3, &stopped), Err(Reason::Interrupted)));
    let gradient = problem.gradient_while(&problem.middle(), &stopped);
    assert!(matches!(gradient.reasons[0], Some(Reason::Interrupted)));

    // Wherever on the way that is, and whether it comes in time.
    for round in 0..60 {
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        let finger = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_micros(40 * (round % 20)));
            flag.store(true, Ordering::Relaxed);
        });
        let wanted = [[14.0, 40.0], [24.0, 20.0]][usize::from(round % 2 == 0)];
        (0..2).for_each(|parameter| live.set(parameter, wanted[parameter]));
        let went = live.solve_while(&Control { stop: Some(stop), ..Control::default() });
        finger.join().unwrap();
        let solved = problem.evaluate(live.present()).values;
        for (index, (followed, solved)) in live.values().iter().zip(&solved).enumerate() {
            let near = (followed - solved).abs() < 1e-8 * (1.0 + solved.abs());
            // Ends of earlier steps that nobody waited for are not told.
            assert!(near || went.is_err() && index != 1 && followed.is_nan(), "{followed} {solved}");
        }
        match went {
            Ok(()) => assert_eq!(live.present(), wanted),
            Err(reason) => assert!(matches!(reason, Reason::Interrupted), "{reason:?}"),
        }
    }
    live.solve().unwrap();
    is_near(&live, &problem);
}

/// What a step holds out of the plane is held by copies too, and after a first move: the rotation of an end about z holds those about x
/// and y.
#[test]
fn what_is_held_out_of_the_plane_stays_held() {
    let text = r#"
        format = "pennate/1"
        strain_limit = 1e9
        parameters = { turn = -270.0 }
        nodes = { A = [0, 0], B = [-8.404649522661371, -82.20453490161422] }
        materials = { m = { youngs_modulus = 59.7204, poissons_ratio = 0.3 } }
        sections = { s = { annulus = { outer_radius = 6.04696, wall = 2.1989 }, shear = false } }
        members = { m = { nodes = ["A", "B"], section = "s", material = "m" } }
        supports = { A = "clamped" }
        probes = { x = { node = "B", displacement = "ux" }, turning = { node = "B", stiffness = "rz" } }
        steps = [{ name = "turn", rotation = { B = [0, 0, "= turn"] } }]
    "#;
    for probes in [&["x"][..], &["x", "turning"]] {
        let problem = Problem::new(&Document::from_text("bar.toml", text), &[], &["turn"], probes, 1e-6).unwrap();
        assert_eq!(problem.evaluate(&[-270.0]).stable, [Some(true)]);
        let mut lives = problem.live_all(3).unwrap();
        assert_eq!(lives.stable(), [Some(true); 3]);
        lives.set(&[-268.0, -271.0, -272.0]);
        assert!(lives.solve().iter().all(Option::is_none));
        let solved = problem.evaluate(&[-268.0, -271.0, -272.0]).values;
        for (followed, solved) in lives.values().iter().zip(&solved) {
            assert!((followed - solved).abs() < 1e-8 * solved.abs(), "{followed} {solved}");
        }
    }
}

/// Pushed back all at once, the output of this inverter comes out on another path than the one that leads there: its wire snaps through.
#[test]
fn what_snaps_on_the_way_is_not_leapt_over() {
    let document = Document::from_text("inverter.toml", include_str!("inverter.toml"));
    let names = ["L1", "t1", "xO", "xG", "yG", "push"];
    let problem = Problem::new(&document, &[], &names, &["f"], 1e-4).unwrap();
    let design =
        [165.77394680098737, 19.529888775711356, 207.30068697919924, 221.1770320315755, 1.5826013424978815, 0.0];
    let mut live = problem.live_at(&design[..5].iter().copied().chain([2.5]).collect::<Vec<_>>()).unwrap();
    live.set(5, 0.0);
    live.solve().unwrap();
    let (solved, reason, _) = problem.evaluate_alone(&design);
    assert!(
        reason.is_none() && (live.values()[0] - solved[0]).abs() < 1e-6 * solved[0],
        "{:?} {solved:?}",
        live.values()
    );
}

/// An arch right before its limit point, from which a change of its shape leads away: a thousandth of that is too much at once.
#[test]
fn a_way_that_begins_at_the_edge_leads_away_from_it() {
    let text = r#"
        format = "pennate/1"
        parameters = { F = 1.4259, h = 7.5925 }
        nodes = { A = [-100, 0], B = [100, 0], C = [0, "= h"] }
        materials = { m = { youngs_modulus = 1000, poissons_ratio = 0.3 } }
        sections = { r = { rectangle = { width = 5, height = 3 } } }
        members = { a = { nodes = ["A", "C"], section = "r", material = "m" }, b = { nodes = ["C", "B"], section = "r", material = "m" } }
        supports = { A = "pinned", B = "pinned" }
        steps = [{ name = "push", force = { C = [0.02, "= -F"] } }]
        probes = { drop = { node = "C", displacement = "uy" } }
    "#;
    let document = Document::from_text("arch.toml", text);
    let problem = Problem::new(&document, &[], &["F", "h"], &["drop"], 1e-6).unwrap();
    let mut live = problem.live().unwrap();
    live.set(0, 0.3);
    live.set(1, 12.0);
    live.solve().unwrap();
    is_near(&live, &problem);
}
