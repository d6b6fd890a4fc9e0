//! Designs of one topology, solved one by one and side by side.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use pennate_analysis::batch::{self, Design};
use pennate_models::{Mesh, discretize, read_text};
use pennate_solver::options::Options;

/// Designs that are solved in one go.
const DESIGNS: u32 = 64;

const DYAD: &str = include_str!("../models/networks/dyad.toml");

fn designs() -> Vec<Design> {
    let design = |k: u32| {
        let beta = 15.0 + 0.5 * f64::from(k);
        let settings = [("beta".to_owned(), beta.to_string())];
        let model = read_text("dyad.toml", DYAD, &settings).expect("a network of the repository");
        let (structure, steps) = discretize(&model, &Mesh::initial(&model, 1e-4));
        Design { structure, steps }
    };
    (0..DESIGNS).map(design).collect()
}

fn dyads(criterion: &mut Criterion) {
    let designs = designs();
    criterion.bench_function(&format!("{DESIGNS} dyads: one by one"), |bencher| {
        bencher.iter(|| {
            for design in &designs {
                let _ = black_box(pennate_solver::solve(
                    &design.structure,
                    &design.steps,
                    &Options::default(),
                    &mut |_| true,
                ));
            }
        });
    });
    criterion.bench_function(&format!("{DESIGNS} dyads: side by side"), |bencher| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        pool.install(|| bencher.iter(|| black_box(batch::solve(&designs))));
    });
}

criterion_group!(benches, dyads);
criterion_main!(benches);
