//! Equilibria that are followed.

use pennate_analysis::problem::{Live, Problem, Reason};
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
