//! A finer mesh that starts from the states of a coarser one.

use std::path::Path;

use pennate_models::{Mesh, discretize, read};
use pennate_solver::history::{History, Status};
use pennate_solver::options::Options;
use pennate_solver::{solve, solve_along};

/// The end of every step is that of the path followed anew, at a fraction of its cost.
fn ends_are_the_same(file: &str, factor: usize) {
    let model = read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(file), &[]).expect("a network");
    let options = Options { estimate: true, ..Options::default() };
    let coarse = Mesh::initial(&model, 1e-5);
    let fine = coarse.refined(&model, &vec![factor; model.members.len()]);
    let (structure, steps) = discretize(&model, &coarse);
    let (first, trail) = solve_along(&structure, &steps, &options, None, &mut |_| true).expect("a solution");
    let (structure, steps) = discretize(&model, &fine);
    let trail = trail.expect("a trail");
    let (guided, _) =
        solve_along(&structure, &steps, &options, Some((trail, &first)), &mut |_| true).expect("a solution");
    let anew = solve(&structure, &steps, &options, &mut |_| true).expect("a solution");

    assert_eq!(guided.mesh, anew.mesh);
    let mut spent = [0, 0];
    for ((guided, anew), first) in guided.steps.iter().zip(&anew.steps).zip(&first.steps) {
        assert_eq!((guided.status, guided.stable), (Status::Converged, anew.stable), "{file}");
        spent[0] += guided.factorizations - first.factorizations;
        spent[1] += anew.factorizations;
    }
    assert!(distance(&guided, &anew) < 1e-8, "{file}: {}", distance(&guided, &anew));
    // The meshes differ by more than that: the states are not those of the first.
    assert!(distance(&guided, &first) > 1e-7, "{file}: {}", distance(&guided, &first));
    assert!(spent[0] < spent[1], "{file}: {spent:?}");
}

/// The largest distance of nodes at the ends of steps over the largest displacement.
fn distance(a: &History, b: &History) -> f64 {
    let ends = |history: &History| -> Vec<[f64; 3]> {
        let last = history.steps.iter().filter_map(|step| step.increments.last());
        last.flat_map(|increment| increment.state.nodes.iter().map(|node| node.displacement)).collect()
    };
    let norm = |a: [f64; 3]| a.iter().map(|x| x * x).sum::<f64>().sqrt();
    let (a, b) = (ends(a), ends(b));
    let largest = b.iter().map(|&u| norm(u)).fold(0.0, f64::max);
    let apart = |(a, b): (&[f64; 3], &[f64; 3])| norm([a[0] - b[0], a[1] - b[1], a[2] - b[2]]);
    a.iter().zip(&b).map(apart).fold(0.0, f64::max) / largest
}

#[test]
fn of_a_plane_dyad() {
    ends_are_the_same("models/networks/dyad.toml", 2);
}

#[test]
fn of_a_tripod() {
    ends_are_the_same("validation/15_tripod/tripod.toml", 3);
}

#[test]
fn of_a_curved_rod() {
    ends_are_the_same("validation/04_bathe_bolourchi_bend/bend.toml", 2);
}

#[test]
fn of_a_muscle() {
    ends_are_the_same("models/networks/muscle_cantilever.toml", 2);
}
