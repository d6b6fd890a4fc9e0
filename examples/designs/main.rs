//! Prints what a design, its derivatives and a live step cost, as a Markdown table.
//!
//!     cargo run --release --example designs
//!
//! Times are medians on one thread, warm. "One by one" solves the same designs with the ordinary solver, from the structure
//! on the same mesh to the ends of all steps, in the same run.
//!
//!     cargo run --release --example designs -- campaign 1000
//!
//! compares so many random designs of each of fifteen networks with solves one by one, and prints how many of them have an
//! answer, and the largest difference over the largest value.
//!
//!     cargo run --release --example designs -- random 200 0
//!
//! does the same with 24 designs each of so many random networks, those of the example `gradients`, from a seed on, and lists those
//! with designs that differ by more than 10⁻⁹ of the largest value, or end otherwise.
//!
//!     cargo run --release --example designs -- study 300000
//!
//! solves so many mechanisms on two threads, and prints the seconds.
//!
//!     cargo run --release --example designs -- repeat gradient dyad 100
//!
//! does nothing but one of `model`, `structure`, `values`, `alone`, `gradient` and `live` of one network so many times, for
//! programs that count instructions.

use pennate_analysis::problem::{Evaluation, Problem, Reason};
use pennate_models::{Document, discretize};
use rayon::prelude::*;

mod costs;
mod networks;
#[expect(dead_code, reason = "what kinds of numbers parameters are counts for derivatives alone")]
#[path = "../gradients/random.rs"]
mod random;

use costs::{Costs, alone, on_threads, study};
use networks::{all, find, rows_about, topologies};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["campaign", count] => campaign(count.parse().expect("a number of designs")),
        ["random", count, seed] => random(count.parse().expect("a number of networks"), seed.parse().expect("a seed")),
        ["repeat", work, name, count] => repeat(work, name, count.parse().expect("how many times")),
        ["study", count] => {
            let count = count.parse().expect("a number of designs");
            let (answered, seconds) = study(count);
            println!("{answered} of {count} designs with an answer in {seconds:.1} s");
        }
        _ => on_threads(1, table),
    }
}

/// One piece of work on designs of one network, again and again; values and derivatives are those of eight designs at once.
fn repeat(work: &str, name: &str, count: usize) {
    let network = find(name);
    let problem = network.problem();
    let rows = network.rows(&problem, 8);
    let mut designs = rows.chunks_exact(network.parameters.len()).cycle();
    let mut next = || designs.next().unwrap_or_default();
    let mut live = problem.live().ok();
    for _ in 0..count {
        match work {
            "model" => drop(problem.model(next())),
            "structure" => drop(problem.model(next()).map(|model| discretize(&model, problem.mesh()))),
            "values" => drop(problem.evaluate(&rows)),
            "alone" => drop(alone(&problem, next())),
            "gradient" => drop(problem.gradient(&rows)),
            "live" => {
                let Some(live) = &mut live else { return };
                next().iter().enumerate().take(1).for_each(|(place, &value)| live.set(place, value));
                let _ = live.solve();
            }
            _ => panic!("no such work: {work}"),
        }
    }
}

fn table() {
    println!("| network | a design | one by one | the solve alone | ratio | derivatives over values | a live step |");
    println!("|---|---:|---:|---:|---:|---:|---:|");
    for network in all() {
        let Costs { design, one_by_one, solve, gradient, live } = Costs::of(&network);
        println!(
            "| {} | {:.0} µs | {:.0} µs | {:.0} µs | {:.2} | {:.2} ({} parameters, {} outputs) | {:.0} µs |",
            network.name,
            1e6 * design,
            1e6 * one_by_one,
            1e6 * solve,
            one_by_one / design,
            gradient / one_by_one,
            network.parameters.len(),
            network.probes.len(),
            1e6 * live,
        );
    }
}

/// Random designs against solves one by one.
fn campaign(count: usize) {
    println!("| network | designs | with an answer | refused | stopped on the way | largest difference |");
    println!("|---|---:|---:|---:|---:|---:|");
    let mut total = [0; 4];
    let mut worst = 0.0_f64;
    for network in topologies() {
        let problem = network.problem();
        let rows = network.rows(&problem, count);
        let answers = problem.evaluate(&rows);
        let refused = |reason: &Reason| matches!(reason, Reason::Refused(_));
        let reasons: Vec<&Reason> = answers.reasons.iter().flatten().collect();
        let refusals = reasons.iter().filter(|reason| refused(reason)).count();
        let counts = [count, count - reasons.len(), refusals, reasons.len() - refusals];
        let least = vec![f64::MIN_POSITIVE; network.probes.len()];
        let (largest, others) = differences(&problem, &least, &rows, &answers);
        assert_eq!(others, 0, "{}: designs that end otherwise", network.name);
        let [all, answered, refused, stopped] = counts;
        println!("| {} | {all} | {answered} | {refused} | {stopped} | {largest:.1e} |", network.name);
        total.iter_mut().zip(counts).for_each(|(total, count)| *total += count);
        worst = worst.max(largest);
    }
    let [all, answered, refused, stopped] = total;
    println!("| all | {all} | {answered} | {refused} | {stopped} | {worst:.1e} |");
}

/// Designs of random networks against solves one by one.
fn random(count: u64, first: u64) {
    let of = |seed: u64| {
        let network = random::network(seed);
        let [parameters, probes] =
            [&network.parameters, &network.probes].map(|names| names.iter().map(String::as_str).collect::<Vec<_>>());
        let document = Document::from_text("network.toml", &network.text);
        let problem = Problem::new(&document, &[], &parameters, &probes, 1e-4).ok()?;
        let spread = [0.05, 0.15, 0.4][seed as usize % 3];
        let rows = rows_about(&problem.middle(), spread, 24, seed);
        let answers = problem.evaluate(&rows);
        let (largest, others) = differences(&problem, &network.scales, &rows, &answers);
        (largest > 1e-9 || others > 0).then(|| println!("seed {seed}: {largest:.1e}, {others} end otherwise"));
        Some((largest, others))
    };
    let found: Vec<(f64, usize)> = (first..first + count).into_par_iter().filter_map(of).collect();
    let off = found.iter().filter(|(largest, _)| *largest > 1e-9).count();
    let others: usize = found.iter().map(|(_, others)| others).sum();
    println!("{} networks of 24 designs: {off} with differences, {others} designs that end otherwise", found.len());
}

/// The largest difference of an output from that of the ordinary solver, over the largest of its values, or what is `least` of it, and
/// how many designs end otherwise.
fn differences(problem: &Problem, least: &[f64], rows: &[f64], answers: &Evaluation) -> (f64, usize) {
    let outputs = least.len();
    let largest = |(output, &least): (usize, &f64)| {
        let values = answers.values.iter().skip(output).step_by(outputs).filter(|value| value.is_finite());
        values.fold(least, |largest: f64, value| largest.max(value.abs()))
    };
    let scales: Vec<f64> = least.iter().enumerate().map(largest).collect();
    let (mut largest, mut others) = (0.0_f64, 0);
    let width = rows.len() / answers.reasons.len();
    for (design, row) in rows.chunks_exact(width).enumerate() {
        let (single, reason, stable) = problem.evaluate_alone(row);
        let together = &answers.values[design * outputs..(design + 1) * outputs];
        let alike = single.iter().zip(together).all(|(a, b)| a.is_finite() == b.is_finite());
        let ends = reason.is_none() == answers.reasons[design].is_none() && stable == answers.stable[design];
        others += usize::from(!alike || !ends);
        for ((a, b), scale) in
            single.iter().zip(together).zip(&scales).filter(|((a, b), _)| a.is_finite() && b.is_finite())
        {
            largest = largest.max((a - b).abs() / scale);
        }
    }
    (largest, others)
}
