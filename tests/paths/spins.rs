//! Straight bars between pins that loads bend about the stiffer of their axes: they would turn about themselves.

use pennate_models::read_text;
use pennate_solver::history::{Note, Status, StepHistory};
use pennate_solver::options::Options;

/// Sections of a strip, 2 by 10: on edge, flat, and in place of it a round rod.
const SECTIONS: &str = "
    [sections]
    edge = { rectangle = { width = 2, height = 10 } }
    flat = { rectangle = { width = 10, height = 2 } }
    round = { circle = { radius = 2 } }
    [materials]
    m = { youngs_modulus = 100, poissons_ratio = 0.3 }
";

/// The last step of a network.
fn last_step(text: &str) -> StepHistory {
    let model = read_text("spins.toml", &format!("format = \"pennate/1\"\n{text}"), &[])
        .unwrap_or_else(|errors| panic!("{errors:?}\n{text}"));
    let (structure, steps) = pennate_models::discretize(&model, &pennate_models::Mesh::initial(&model, 1e-6));
    let solved = pennate_solver::solve(&structure, &steps, &Options::default(), &mut |_| true).expect("no mechanism");
    solved.steps.last().expect("a step").clone()
}

/// Ways to let a strip spin about itself: by the pins of its supports, by those of its ends, by hinges about itself, by a pin at one end;
/// the second in the plane, with stability judged in space.
const WAYS: [&str; 4] = [
    r#"
    nodes = { A = [0, 0, 0], M = [50, 0, 0], B = [100, 0, 0] }
    members.bar = { path = ["A", "M", "B"], section = "edge", material = "m" }
    supports = { A = "pinned", B = "pinned" }
    steps = [{ force = { M = [0, -0.4, 0] } }]
    "#,
    r#"
    nodes = { A = [0, 0], B = [100, 0] }
    members.bar = { nodes = ["A", "B"], section = "edge", material = "m", release = { start = "pin", end = "pin" } }
    supports = { A = "clamped", B = "clamped" }
    steps = [{ distributed = { bar = [0, -0.01] } }]
    "#,
    r#"
    nodes = { A = [0, 0, 0], B = [100, 0, 0] }
    members.bar.nodes = ["A", "B"]
    members.bar.section = "edge"
    members.bar.material = "m"
    members.bar.release = { start = ["rx", "rz"], end = ["rx", "rz"] }
    supports = { A = "clamped", B = "clamped" }
    steps = [{ distributed = { bar = [0, -0.01, 0] } }]
    "#,
    r#"
    nodes = { A = [0, 0, 0], B = [100, 0, 0] }
    members.bar = { nodes = ["A", "B"], section = "edge", material = "m", release = { start = "pin", end = ["ry", "rz"] } }
    supports = { A = "clamped", B = "pinned" }
    steps = [{ distributed = { bar = [0, -0.01, 0] } }]
    "#,
];

#[test]
fn a_strip_on_edge_would_turn_flat() {
    for way in WAYS {
        for (section, stable) in [("edge", false), ("flat", true), ("round", true)] {
            let step = last_step(&format!("dimension = \"space\"{way}{SECTIONS}").replacen(
                "section = \"edge\"",
                &format!("section = \"{section}\""),
                1,
            ));
            assert_eq!((step.status, step.stable), (Status::Converged, Some(stable)), "{section}: {way}");
            let said = step.notes.iter().any(|note| matches!(note, Note::WouldTurn { .. }));
            assert_eq!(said, !stable, "{section}: {way}");
        }
    }
    let step = last_step(&format!("{}{SECTIONS}", WAYS[1]));
    assert_eq!(step.stable, Some(false), "in the plane");
}

/// Of two strips, one on edge and one flat, the first is named alone.
#[test]
fn the_strip_that_would_turn_is_named() {
    let step = last_step(&format!(
        r#"
        nodes = {{ A = [0, 0, 0], B = [100, 0, 0], C = [160, 80, 0] }}
        members.one = {{ nodes = ["A", "B"], section = "flat", material = "m", release = {{ start = "pin", end = "pin" }} }}
        members.two = {{ nodes = ["B", "C"], section = "edge", material = "m", release = {{ start = "pin", end = "pin" }} }}
        supports = {{ A = "clamped", B = "pinned", C = "clamped" }}
        steps = [{{ distributed = {{ one = [0, -0.01, 0], two = [0.008, -0.006, 0] }} }}]
        {SECTIONS}"#
    ));
    assert_eq!((step.status, step.stable), (Status::Converged, Some(false)));
    assert_eq!(step.notes, [Note::WouldTurn { members: vec![1] }]);
}

/// A strip that has buckled turns about the line between its ends, and no force resists: it is stable, and not unstable by rounding.
#[test]
fn a_buckled_strip_is_not_unstable() {
    let ends =
        [r#"supports = { A = "pinned", B = ["uy", "uz"] }"#, r#"supports = { A = "clamped", B = ["uy", "uz"] }"#];
    let releases = ["", r#", release = { start = "pin", end = "pin" }"#];
    for height in [2.2, 4.0, 10.0] {
        for over in [1.1, 1.8] {
            // EI over the squared length, times π².
            let thrust = over * std::f64::consts::PI.powi(2) * (100.0 * height * 8.0 / 12.0) / 1e4;
            for (supports, release) in ends.iter().zip(releases) {
                let step = last_step(&format!(
                    r#"
                    nodes = {{ A = [0, 0, 0], B = [100, 0, 0] }}
                    members.bar = {{ nodes = ["A", "B"], section = "s", material = "m"{release} }}
                    {supports}
                    sections.s = {{ rectangle = {{ width = 2, height = {height} }} }}
                    materials.m = {{ youngs_modulus = 100, poissons_ratio = 0.3 }}
                    [[steps]]
                    force = {{ B = [-{thrust}, 0, 0] }}
                    distributed = {{ bar = [0, 0, 1e-5] }}
                    [[steps]]
                    distributed = {{ bar = [0, 0, 0] }}
                    "#
                ));
                assert_eq!(step.status, Status::Converged, "{height} {over} {release}");
                assert_eq!(step.stable, Some(true), "{height} {over} {release}: {:?}", step.notes);
            }
        }
    }
}
