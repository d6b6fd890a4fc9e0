//! Designs solved side by side end where each ends alone.

use pennate_analysis::batch::{self, Design, Reason};
use pennate_models::{Mesh, discretize, read_text};
use pennate_solver::options::Options;

const DYAD: &str = include_str!("../../models/networks/dyad.toml");

/// The dyad at an angle, its joint pushed back in a second step; pressed through its anchors where `crushed`.
fn dyad(beta: f64, crushed: bool) -> Design {
    let mut text = DYAD.to_owned();
    if crushed {
        text += "[[steps]]\nname = \"crush\"\nfree = { J = [\"uy\"] }\nforce = { J = [0, -400, 0] }\n";
    } else {
        text += "[[steps]]\nname = \"crush\"\nfree = { J = [\"uy\"] }\nforce = { J = [0, 1, 0] }\n";
    }
    let settings = [("beta".to_owned(), beta.to_string())];
    let model = read_text("dyad.toml", &text, &settings).unwrap_or_else(|errors| panic!("{errors:?}"));
    let (structure, steps) = discretize(&model, &Mesh::initial(&model, 1e-4));
    Design { structure, steps }
}

#[test]
fn designs_end_where_they_end_alone() {
    let designs: Vec<Design> = (0..21).map(|k| dyad(14.0 + 1.5 * f64::from(k), false)).collect();
    let together = batch::solve(&designs);
    assert_eq!(together.len(), designs.len());
    for (design, ends) in designs.iter().zip(&together) {
        let ends = ends.as_ref().expect("an equilibrium");
        let alone = pennate_solver::solve(&design.structure, &design.steps, &Options::default(), &mut |_| true);
        let alone = alone.expect("no mechanism");
        assert_eq!(ends.len(), alone.steps.len());
        for (end, step) in ends.iter().zip(&alone.steps) {
            let state = &step.increments.last().expect("a state").state;
            for (a, b) in end.nodes.iter().zip(&state.nodes) {
                for c in 0..3 {
                    assert!((a.displacement[c] - b.displacement[c]).abs() < 1e-9, "{a:?} {b:?}");
                    assert!((a.reaction_force[c] - b.reaction_force[c]).abs() < 1e-8, "{a:?} {b:?}");
                }
            }
            for (a, b) in end.members.iter().zip(&state.members) {
                assert!((a.axial_force - b.axial_force).abs() < 1e-8, "{a:?} {b:?}");
                assert!((a.length - b.length).abs() < 1e-9 && a.control == b.control, "{a:?} {b:?}");
            }
        }
    }
}

#[test]
fn a_design_that_fails_keeps_its_reason_and_spoils_no_other() {
    let designs: Vec<Design> = (0..11).map(|k| dyad(20.0 + f64::from(k), k == 4)).collect();
    let outcomes = batch::solve(&designs);
    for (k, outcome) in outcomes.iter().enumerate() {
        match outcome {
            Ok(ends) => assert!(k != 4 && ends.len() == 3, "{k}"),
            Err(Reason::Stopped { step, fraction, .. }) => assert!(k == 4 && *step == 2 && *fraction < 1.0, "{k}"),
            Err(Reason::Refused(error)) => panic!("{k}: {error}"),
        }
    }
}

#[test]
fn threads_change_nothing() {
    let designs: Vec<Design> = (0..20).map(|k| dyad(15.0 + f64::from(k), false)).collect();
    let [one, two] = [1, 2].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| batch::solve(&designs))
    });
    for (a, b) in one.iter().zip(&two) {
        assert_eq!(a.as_ref().ok(), b.as_ref().ok());
    }
}

/// Two pinned bars that a force presses towards the line of their ends, which is `rise` below it.
fn bars(rise: f64, force: f64, stiffness: f64) -> Design {
    let bending = 2e6; // they do not buckle
    let text = format!(
        r#"format = "pennate/1"
        dimension = "plane"
        [nodes]
        a = [-100, 0]
        b = [100, 0]
        c = [0, {rise}]
        [sections]
        bar = {{ stiffness = {{ EA = {stiffness}, EI3 = {bending} }} }}
        [members]
        left = {{ nodes = ["a", "c"], section = "bar", release = {{ end = "pin" }} }}
        right = {{ nodes = ["c", "b"], section = "bar" }}
        [supports]
        a = "pinned"
        b = "pinned"
        [[steps]]
        force = {{ c = [0, {force}, 0] }}
        "#
    );
    let model = read_text("bars.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
    let (structure, steps) = discretize(&model, &Mesh::initial(&model, 1e-4));
    Design { structure, steps }
}

/// A shallow pair of bars that snaps through moves less than tall soft ones that do not.
#[test]
fn a_design_that_snaps_is_noticed_beside_those_that_move_farther() {
    let shallow = bars(6.0, -8.0, 2e3);
    let alone = batch::solve(std::slice::from_ref(&shallow));
    assert!(matches!(&alone[0], Err(Reason::Stopped { .. })), "{alone:?}");
    let tall = |k: u8| bars(150.0, -25.0 - f64::from(k), 1e2);
    let designs = [tall(0), tall(1), shallow, tall(2), tall(3), tall(4)];
    for (k, outcome) in batch::solve(&designs).iter().enumerate() {
        assert_eq!(matches!(outcome, Err(Reason::Stopped { .. })), k == 2, "{k}: {outcome:?}");
    }
}
