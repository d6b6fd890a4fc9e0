//! Designs solved side by side end where each ends alone.

use pennate::batch::{self, Design, Reason};
use pennate_models::{Mesh, discretize, read_text};
use pennate_solver::options::Options;

const DYAD: &str = include_str!("../models/networks/dyad.toml");

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
    let together = batch::solve(&designs, 1);
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
                    assert!((a.displacement[c] - b.displacement[c]).abs() < 1e-7, "{a:?} {b:?}");
                    assert!((a.reaction_force[c] - b.reaction_force[c]).abs() < 1e-6, "{a:?} {b:?}");
                }
            }
            for (a, b) in end.members.iter().zip(&state.members) {
                assert!((a.axial_force - b.axial_force).abs() < 1e-6, "{a:?} {b:?}");
                assert!((a.length - b.length).abs() < 1e-7 && a.control == b.control, "{a:?} {b:?}");
            }
        }
    }
}

#[test]
fn a_design_that_fails_keeps_its_reason_and_spoils_no_other() {
    let designs: Vec<Design> = (0..11).map(|k| dyad(20.0 + f64::from(k), k == 4)).collect();
    let outcomes = batch::solve(&designs, 1);
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
    let [one, two] = [1, 2].map(|threads| batch::solve(&designs, threads));
    for (a, b) in one.iter().zip(&two) {
        assert_eq!(a.as_ref().ok(), b.as_ref().ok());
    }
}
