//! Prints what a design, its derivatives and a live step cost, as a Markdown table.
//!
//!     cargo run --release --example designs
//!
//! Times are medians on one thread, warm. "One by one" solves the same designs with the ordinary solver, from the structure
//! on the same mesh to the ends of all steps, in the same run.
//!
//!     cargo run --release --example designs -- campaign 1000
//!
//! compares so many random designs of each of eleven networks with solves one by one, and prints how many of them have an
//! answer, and the largest difference over the largest value.
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
use pennate_models::discretize;

mod costs;
mod networks;

use costs::{Costs, alone, on_threads, study};
use networks::{Network, all, find, topologies};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["campaign", count] => campaign(count.parse().expect("a number of designs")),
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
        let largest = largest_difference(&network, &problem, &rows, &answers);
        let [all, answered, refused, stopped] = counts;
        println!("| {} | {all} | {answered} | {refused} | {stopped} | {largest:.1e} |", network.name);
        total.iter_mut().zip(counts).for_each(|(total, count)| *total += count);
        worst = worst.max(largest);
    }
    let [all, answered, refused, stopped] = total;
    println!("| all | {all} | {answered} | {refused} | {stopped} | {worst:.1e} |");
}

/// The largest difference of an output from that of the ordinary solver, over the largest of its values.
fn largest_difference(network: &Network, problem: &Problem, rows: &[f64], answers: &Evaluation) -> f64 {
    let (width, outputs) = (network.parameters.len(), network.probes.len());
    let scales: Vec<f64> = (0..outputs)
        .map(|output| {
            let values = answers.values.iter().skip(output).step_by(outputs).filter(|value| value.is_finite());
            values.fold(0.0, |largest: f64, value| largest.max(value.abs()))
        })
        .collect();
    let mut worst = 0.0f64;
    for (design, row) in rows.chunks_exact(width).enumerate() {
        let (single, reason, _) = problem.evaluate_alone(row);
        assert_eq!(reason.is_none(), answers.reasons[design].is_none(), "{}: {row:?}", network.name);
        for (output, value) in single.iter().enumerate() {
            let other = answers.values[design * outputs + output];
            assert_eq!(value.is_finite(), other.is_finite(), "{}: {row:?}", network.name);
            if value.is_finite() {
                worst = worst.max((value - other).abs() / scales[output]);
            }
        }
    }
    worst
}
