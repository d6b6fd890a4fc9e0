//! What is said of copies that nothing holds.

use pennate::explain;
use pennate_models::{Mesh, discretize, read_text};
use pennate_solver::error::SolveError;
use pennate_solver::history::Status;
use pennate_solver::options::Options;

const TOWER: &str = r#"format = "pennate/1"
nodes = { A = [0, 0], B = [0, 10] }
sections.s = { stiffness = { EA = 100, EI3 = 10 } }
members.m = { nodes = ["A", "B"], section = "s" }
"#;
const HELD: [&str; 2] =
    ["supports.A = \"clamped\"\n", "springs.k = { node = \"A\", stiffness = { ux = 1, uy = 1, rz = 1 } }\n"];
const ASIDE: &str = "[[patterns]]\ncount = 3\ntranslation = [20, 0]\n";

/// The help with everything that is wrong with a network, or that can move in it.
fn helps(rest: &str) -> Vec<String> {
    helps_of(&format!("{TOWER}{rest}"))
}

fn helps_of(text: &str) -> Vec<String> {
    let model = match read_text("tower.toml", text, &[]) {
        Ok(model) => model,
        Err(errors) => return errors.errors.into_iter().filter_map(|error| error.help).collect(),
    };
    let (structure, steps) = discretize(&model, &Mesh::initial(&model, 1e-3));
    let motions = pennate_solver::free_motions(&structure, &steps);
    motions.iter().filter_map(|motion| explain::mechanism(&model, motion).help).collect()
}

/// Copies that float are those of what is held, and the message says what was left out.
#[test]
fn floating_copies_name_the_key_that_was_left_out() {
    for held in HELD {
        let helps = helps(&format!("{held}{ASIDE}"));
        assert_eq!(helps.len(), 2, "{helps:?}");
        for (help, node) in helps.iter().zip(["A-2", "A-3"]) {
            assert!(help.contains(&format!("'{node}'")) && help.contains("write supports = true"), "{helps:?}");
        }
    }
}

/// A copy of a copy that was let go is let go as well.
#[test]
fn copies_of_floating_copies_name_it_too() {
    let helps = helps(&format!("{}{ASIDE}[[patterns]]\ncount = 2\ntranslation = [0, 50]\n", HELD[0]));
    assert_eq!(helps.len(), 5);
    assert!(helps.iter().all(|help| help.contains("supports = true")), "{helps:?}");
}

/// A copy that hangs on the original by a pin swings about it.
#[test]
fn swinging_copies_name_it_too() {
    let helps = helps_of(
        r#"format = "pennate/1"
        nodes = { A = [0, 0], B = [0, 10], C = [20, 10] }
        supports = { A = "clamped", C = ["uy"] }
        sections.s = { stiffness = { EA = 100, EI3 = 10 } }
        members.post = { nodes = ["A", "B"], section = "s" }
        members.arm = { nodes = ["B", "C"], section = "s", release = { start = "pin" } }
        patterns = [{ count = 2, members = ["arm"], rotation = { angle = 90, point = [0, 10] } }]"#,
    );
    assert!(!helps.is_empty() && helps.iter().all(|help| help.contains("supports = true")), "{helps:?}");
}

/// Copies that hang on the original need no supports, and what floats without any is not the pattern's doing.
#[test]
fn other_mechanisms_do_not_speak_of_patterns() {
    assert!(helps(&format!("{}[[patterns]]\ncount = 3\ntranslation = [0, 10]\n", HELD[0])).is_empty());
    assert!(helps(&format!("{}{ASIDE}supports = true\n", HELD[0])).is_empty());
    let floating = helps(ASIDE);
    assert!(!floating.is_empty() && floating.iter().all(|help| !help.contains("pattern")), "{floating:?}");
}

/// A prestressed spring may hold what is loose without it, and need not: that is seen once it is in place.
#[test]
fn what_a_prestressed_spring_does_not_hold_is_refused() {
    let text = include_str!("../cases/loose_about_a_spring.toml");
    let solved = |text: &str| {
        let model = read_text("spring.toml", text, &[]).expect("a network");
        let (structure, steps) = discretize(&model, &Mesh::initial(&model, 1e-3));
        pennate_solver::solve(&structure, &steps, &Options::default(), &mut |_| true)
    };
    let Err(SolveError::Mechanism(motions)) = solved(text) else { panic!("no mechanism") };
    assert_eq!(motions.len(), 1, "{motions:?}");
    assert_eq!(motions[0].nodes, [2, 3]);
    // Past the hinge its line holds the turn.
    let history = solved(&text.replace("nodes = [\"D\", \"B\"]", "nodes = [\"D\", \"A\"]")).expect("an answer");
    assert_eq!(history.steps[0].status, Status::Converged);
}
