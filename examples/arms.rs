//! States of a soft arm, in the plane and out of it, whose verdict on stability is held against their modes.
//!
//! `cargo run --release --example arms [-- COUNT [SEED]]` solves `tests/cases/soft_arm.toml` at COUNT (1,000) random
//! pressures and loads, half of them with no rotating pressure or next to none, where the arm buckles sideways. It prints
//! how many verdicts were confirmed, and ends with status 1 where the lowest eigenvalue contradicts one.

use std::path::Path;
use std::process::ExitCode;

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_models::{discretize, read};
use pennate_solver::history::Status;
use pennate_solver::options::Options;
use pennate_testing::verdict::{Verdict, confirm};
use rayon::prelude::*;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse().expect("a number"));
    let count: u64 = arguments.next().unwrap_or(1000);
    let seed: u64 = arguments.next().unwrap_or(0);
    let outcomes: Vec<&str> = (0..count).into_par_iter().map(|case| judge(seed.wrapping_add(case))).collect();
    for what in ["confirmed, stable", "confirmed, past a bifurcation", "stopped", "no modes", "contradicted"] {
        println!("{what}: {}", outcomes.iter().filter(|outcome| **outcome == what).count());
    }
    ExitCode::from(u8::from(outcomes.contains(&"contradicted")))
}

fn judge(case: u64) -> &'static str {
    let mut rng = fastrand::Rng::with_seed(case);
    let rotating = match case % 4 {
        0 => 0.0,
        1 => 0.5 * rng.f64(),
        _ => 193.05 * (2.0 * rng.f64() - 1.0),
    };
    let settings = [("Pb", 172.36 * rng.f64().sqrt()), ("Pr", rotating), ("load", 20.0 * rng.f64().sqrt())];
    let text: Vec<_> = settings.map(|(key, value)| (key.to_owned(), format!("{value}"))).to_vec();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases/soft_arm.toml");
    let model = read(&file, &text).expect("the arm's network file");
    let options = Options { estimate: true, ..Options::default() };
    let Ok(solution) = solve_to_accuracy(model, 1e-6, &options, &mut |_| true) else { return "stopped" };
    let last = solution.history.steps.last().expect("two steps");
    let (Status::Converged, Some(stable)) = (last.status, last.stable) else { return "stopped" };
    let (structure, steps) = discretize(&solution.model, &solution.mesh);
    match confirm(&structure, &steps, steps.len(), stable) {
        Verdict::Contradicted(lowest) => {
            println!("{settings:?}: stable {stable}, lowest eigenvalues {lowest:?}");
            "contradicted"
        }
        Verdict::Unknown => "no modes",
        Verdict::Confirmed if last.critical_points.is_empty() => "confirmed, stable",
        Verdict::Confirmed => "confirmed, past a bifurcation",
    }
}
