//! One Newton iteration of a spatial network, whole and in its parts: condensation of the chains, assembly, factorization.

use std::path::Path;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use pennate_models::{Mesh, discretize};
use pennate_solver::continuation::{self, Continuation};
use pennate_solver::newton::{Newton, Start};
use pennate_solver::options::Options;
use pennate_solver::packs;
use pennate_solver::system::System;

const SPACE: [usize; 6] = [0, 1, 2, 3, 4, 5];

/// The system of a network at a third of its first step, in equilibrium; saved as state 0.
fn system(file: &str) -> System<6> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/peers").join(file);
    let model = pennate_models::read(&file, &[]).expect("a network of the repository");
    let (structure, steps) = discretize(&model, &Mesh::initial(&model, 1e-4));
    let structure = Arc::new(structure);
    let topology = continuation::topology(&structure, &steps);
    let elements = packs::space(&structure, 0);
    let mut path = Continuation::new(System::new(structure, topology, elements, SPACE, false), Options::default());
    path.free_motions(&steps);
    let mut system = path.system;
    system.loading.fraction = 1.0;
    for &(drive, value) in &steps[0].targets {
        system.loading.drives[drive] = value / 3.0;
    }
    system.apply_drives();
    Newton::default().solve(&mut system, Start { predicted: false, ..Start::nearby() }).expect("an equilibrium");
    system
}

fn iteration(criterion: &mut Criterion) {
    for (name, file) in [("P6-16", "p6_16.toml"), ("P6-36", "p6_36.toml")] {
        let mut system = system(file);
        let state = system.snapshot();
        criterion.bench_function(&format!("{name}: one iteration"), |bencher| {
            bencher.iter(|| {
                system.restore(&state);
                system.place_ends();
                system.assemble(false);
                system.advance(false)
            });
        });
        criterion.bench_function(&format!("{name}: chains condensed"), |bencher| {
            bencher.iter(|| system.members.packs.iter_mut().for_each(|pack| pack.condense(None)));
        });
        criterion.bench_function(&format!("{name}: condensed, assembled and factorized"), |bencher| {
            bencher.iter(|| system.assemble(false));
        });
        criterion.bench_function(&format!("{name}: joints factorized"), |bencher| {
            bencher.iter(|| system.tangent.linear.factorize());
        });
        let mut rhs = vec![1.0; system.tangent.linear.size()];
        criterion.bench_function(&format!("{name}: joints solved"), |bencher| {
            bencher.iter(|| system.tangent.solve(&mut rhs));
        });
        let still = vec![0.0; system.tangent.linear.size()];
        criterion.bench_function(&format!("{name}: joints, ends and interiors moved"), |bencher| {
            bencher.iter(|| system.move_by(&still, false));
        });
        criterion.bench_function(&format!("{name}: loads and sections brought up to date"), |bencher| {
            bencher.iter(|| system.apply_drives());
        });
        criterion.bench_function(&format!("{name}: results read"), |bencher| {
            bencher.iter(|| pennate_solver::results::equilibrium(&mut system));
        });
    }
}

criterion_group!(benches, iteration);
criterion_main!(benches);
