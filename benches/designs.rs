//! Designs of one network, one by one and side by side.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use pennate_analysis::problem::Problem;
use pennate_models::Document;

/// Designs that are solved in one go.
const DESIGNS: u32 = 64;

const DYAD: &str = include_str!("../models/networks/dyad.toml");

fn dyads(criterion: &mut Criterion) {
    let document = Document::from_text("dyad.toml", DYAD);
    let problem = Problem::new(&document, &[], &["beta"], &["stroke@inflate", "holding"], 1e-4);
    let problem = problem.expect("a network of the repository");
    let angles: Vec<f64> = (0..DESIGNS).map(|k| 15.0 + 0.5 * f64::from(k)).collect();
    criterion.bench_function(&format!("{DESIGNS} dyads: one by one"), |bencher| {
        bencher.iter(|| {
            for angle in &angles {
                black_box(problem.evaluate_alone(std::slice::from_ref(angle)));
            }
        });
    });
    criterion.bench_function(&format!("{DESIGNS} dyads: side by side"), |bencher| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        pool.install(|| bencher.iter(|| black_box(problem.evaluate(&angles))));
    });
}

criterion_group!(benches, dyads);
criterion_main!(benches);
