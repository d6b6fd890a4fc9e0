//! A strut with a small imperfection, loaded far beyond its critical load, ends buckled and stable.

use std::path::Path;

use pennate_models::{Mesh, discretize, read};
use pennate_solver::history::Status;
use pennate_solver::options::Options;

/// At 3.65 times the critical load the nearly straight state is an equilibrium too, with two negative pivots; whatever the
/// first increment, the solve must not end there.
#[test]
fn every_first_increment_leads_to_the_buckled_state() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/peers/imperfect_strut.toml");
    let model = read(&file, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
    let mesh = Mesh::new(3, vec![vec![8]]);
    let (structure, steps) = discretize(&model, &mesh);
    let tip = model.nodes.iter().position(|node| node.name == "T").expect("the strut has a tip");
    for first_increment in [1.0, 0.5, 0.25, 0.1] {
        let options = Options { first_increment, ..Options::default() };
        let history = pennate_solver::solve(&structure, &steps, &options, &mut |_| true).expect("no mechanism");
        let step = &history.steps[0];
        println!("first increment {first_increment}: {} factorizations", step.factorizations);
        assert_eq!(step.status, Status::Converged, "first increment {first_increment}");
        assert_eq!(step.stable, Some(true), "first increment {first_increment}");
        let rotation = step.increments.last().expect("a last state").state.nodes[tip].rotation_total;
        assert!(rotation.abs() > 2.0, "first increment {first_increment}: the tip turns by {rotation} rad");
    }
}
