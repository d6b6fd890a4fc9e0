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

use std::time::Instant;

use pennate_analysis::problem::{Evaluation, Problem, Reason};
use pennate_models::{Document, discretize};
use pennate_solver::options::Options;

mod networks;

use networks::{Network, all, topologies};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["campaign", count] => campaign(count.parse().expect("a number of designs")),
        ["repeat", work, name, count] => repeat(work, name, count.parse().expect("how many times")),
        ["study", count] => study(count.parse().expect("a number of designs")),
        _ => on_threads(1, table),
    }
}

/// Does some work on so many threads; that of a problem takes all that there are, otherwise.
fn on_threads(threads: usize, work: impl FnOnce() + Send) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(work);
}

/// Seconds that many designs of the mechanism take on two threads.
fn study(count: usize) {
    let network = all().into_iter().find(|network| network.name.contains("mechanism")).expect("a network of the table");
    let problem = network.problem();
    let rows = network.rows(&problem, count);
    on_threads(2, || {
        let start = Instant::now();
        let found = problem.evaluate(&rows);
        let answered = found.reasons.iter().filter(|reason| reason.is_none()).count();
        println!("{answered} of {count} designs with an answer in {:.1} s", start.elapsed().as_secs_f64());
    });
}

/// One piece of work on designs of one network, again and again; values and derivatives are those of eight designs at once.
fn repeat(work: &str, name: &str, count: usize) {
    let network = all().into_iter().find(|network| network.name.contains(name)).expect("a network of the table");
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
            "gradient" => drop(problem.gradient(next())),
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
        let problem = network.problem();
        let rows = network.rows(&problem, 256);
        let many = time(|| drop(problem.evaluate(&rows))) / 256.0;
        let few = &rows[..16 * network.parameters.len()];
        let single = time(|| {
            drop(few.chunks_exact(network.parameters.len()).map(|row| alone(&problem, row)).collect::<Vec<_>>())
        }) / 16.0;
        let solve = solve_alone(&problem, few);
        let gradient = time(|| drop(problem.gradient(few))) / 16.0;
        let live = live(&problem);
        let name = network.name;
        println!(
            "| {name} | {:.0} µs | {:.0} µs | {:.0} µs | {:.2} | {:.2} ({} parameters, {} outputs) | {:.0} µs |",
            1e6 * many,
            1e6 * single,
            1e6 * solve,
            single / many,
            gradient / single,
            network.parameters.len(),
            network.probes.len(),
            1e6 * live,
        );
    }
}

/// Median time of some work, repeated for half a second or so.
fn time(mut work: impl FnMut()) -> f64 {
    let begin = Instant::now();
    let mut times = Vec::new();
    while times.len() < 3 || begin.elapsed().as_secs_f64() < 0.5 {
        let start = Instant::now();
        work();
        times.push(start.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// The outputs of one design by the ordinary solver.
fn alone(problem: &Problem, row: &[f64]) -> Vec<f64> {
    problem.evaluate_alone(row).0
}

/// Median time of a solve from the structure to the ends of the steps.
fn solve_alone(problem: &Problem, rows: &[f64]) -> f64 {
    let width = problem.parameters().len();
    let designs: Vec<_> = rows
        .chunks_exact(width)
        .filter_map(|row| problem.model(row).ok())
        .map(|model| discretize(&model, problem.mesh()))
        .collect();
    let solve = || {
        for (structure, steps) in &designs {
            let _ = pennate_solver::solve(structure, steps, &Options::default(), &mut |_| true);
        }
    };
    time(solve) / designs.len().max(1) as f64
}

/// Median time of a live step by a fiftieth of the first parameter, there and back.
fn live(problem: &Problem) -> f64 {
    let Ok(mut live) = problem.live() else { return f64::NAN };
    let here = problem.middle()[0];
    let mut away = false;
    time(|| {
        away = !away;
        live.set(0, if away { 0.98 * here } else { here });
        let _ = live.solve();
    })
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

impl Network {
    fn problem(&self) -> Problem {
        let document = Document::from_text(&format!("{}.toml", self.name), &self.text);
        let problem = Problem::new(&document, &[], &self.parameters, &self.probes, 1e-6);
        problem.unwrap_or_else(|error| panic!("{}: {error}", self.name))
    }

    /// Random designs about the values of the file.
    fn rows(&self, problem: &Problem, count: usize) -> Vec<f64> {
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        let middle = problem.middle();
        (0..count)
            .flat_map(|_| {
                middle.iter().map(|value| value * (1.0 + self.spread * (2.0 * random() - 1.0))).collect::<Vec<_>>()
            })
            .collect()
    }
}
