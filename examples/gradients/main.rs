//! Derivatives of random networks by random numbers of them, against differences of converged solves.
//!
//!     cargo run --release --example gradients -- 200 0
//!
//! takes so many networks from a seed on: two to six nodes in the plane or in space, sections, muscles with their tables, actuated
//! members, springs, a rigid body, loads with and without a potential, one to three steps. Up to ten of their numbers are
//! parameters. A derivative is held against differences of fourth order at up to five distances, and where none of these is near
//! against those of eighth order at three that are longer; the nearest counts: long ones are curved, and short ones rounding. Printed
//! is by how far the worst derivative of a network misses, over the largest of its probe (each times its parameter); those that miss
//! by more than 10⁻⁷, or by more than the reason beside them says, are listed by their seed, and end the program with status 1.
//!
//!     cargo run --release --example gradients -- show 53
//!
//! prints one of the networks, its derivatives, and the differences.
//!
//!     cargo run --release --example gradients -- held 200 0
//!
//! takes the same networks with a step before the others that holds a component where the prestress of their springs has brought it, or
//! moves it on from there; `show-held 53` prints one of them.
//!
//!     cargo run --release --example gradients -- seeds 53 54 61
//!
//! judges these networks alone.

use std::collections::BTreeMap;
use std::process::ExitCode;

use pennate_analysis::problem::{Problem, Reason};
use pennate_models::Document;
use rayon::prelude::*;

mod random;

use random::{Random, network, network_held};

/// What derivatives are to miss differences by at most, of the largest of their probe.
const WITHIN: f64 = 1e-7;
/// Distances of differences, as parts of a parameter, and how many of them: those that tell most first. Where rounding of an answer is a
/// good part of what it changes by, as that of an axial force in a stiff member, they are far apart and many.
const PARTS: [(f64, &[f64]); 8] = [
    (1e-3, &FOURTH),
    (3e-3, &FOURTH),
    (3e-4, &FOURTH),
    (1e-2, &FOURTH),
    (1e-4, &FOURTH),
    (1e-2, &EIGHTH),
    (2e-2, &EIGHTH),
    (4e-2, &EIGHTH),
];
/// Weights of central differences at once, twice … a distance, each over it.
const FOURTH: [f64; 2] = [2.0 / 3.0, -1.0 / 12.0];
const EIGHTH: [f64; 4] = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
/// Nearer than this part of what is allowed, no other distance is looked at.
const ENOUGH: f64 = 0.1;
/// What statics or symmetry fixes has no derivative: a probe whose derivatives are less than this part of its value, or of what such
/// networks move, turn and weigh, is measured by that.
const FIXED: f64 = 1e-3;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["show", seed] => {
            show(&network(seed.parse().expect("a seed")));
            ExitCode::SUCCESS
        }
        ["show-held", seed] => {
            show(&network_held(seed.parse().expect("a seed")));
            ExitCode::SUCCESS
        }
        ["seeds", ref seeds @ ..] => {
            campaign(seeds.iter().map(|seed| seed.parse().expect("a seed")).collect(), network)
        }
        ["held", count, first] => campaign(range(count, first), network_held),
        [count, first] => campaign(range(count, first), network),
        _ => campaign((0..200).collect(), network),
    }
}

/// So many seeds from one on.
fn range(count: &str, first: &str) -> Vec<u64> {
    let first: u64 = first.parse().expect("a seed");
    (first..first + count.parse::<u64>().expect("a number")).collect()
}

/// How it went with one network.
enum Outcome {
    /// There is no network, no answer, or no derivative, for a reason.
    Refused(String),
    Missed(Miss),
}

/// The worst miss of a network, and where.
#[derive(Default)]
struct Miss {
    by: f64,
    /// By how much it may.
    within: f64,
    probe: String,
    parameter: String,
}

fn campaign(seeds: Vec<u64>, network: fn(u64) -> Random) -> ExitCode {
    let judged: Vec<(u64, Outcome, Random)> = seeds
        .into_par_iter()
        .map(|seed| {
            let random = network(seed);
            (seed, judge(&random), random)
        })
        .collect();
    let mut table: BTreeMap<String, usize> = BTreeMap::new();
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    let mut wrong = false;
    for (seed, outcome, random) in &judged {
        let row = match outcome {
            Outcome::Refused(why) => why.clone(),
            Outcome::Missed(Miss { by, .. }) if *by == 0.0 => "nothing changes".to_owned(),
            Outcome::Missed(Miss { by, within, probe, parameter }) => {
                random.kinds.iter().for_each(|kind| *kinds.entry(kind).or_default() += 1);
                if by > within {
                    wrong = true;
                    println!("seed {seed}: {probe} by {parameter} misses by {by:.1e}, where {within:.1e} is said");
                }
                match *within > WITHIN {
                    true => "said to be less exact than others".to_owned(),
                    false => format!("within 1e{}", by.log10().ceil().max(-10.0)),
                }
            }
        };
        *table.entry(row).or_default() += 1;
    }
    println!("| derivatives | networks |\n|---|---:|");
    table.iter().for_each(|(row, count)| println!("| {row} | {count} |"));
    let kinds: Vec<String> = kinds.iter().map(|(kind, count)| format!("{kind} {count}")).collect();
    println!("\nParameters: {}.", kinds.join(", "));
    ExitCode::from(u8::from(wrong))
}

/// The network as a problem, or why there is none.
fn problem(random: &Random) -> Result<Problem, String> {
    let document = Document::from_text("network.toml", &random.text);
    let [parameters, probes] =
        [&random.parameters, &random.probes].map(|names| names.iter().map(String::as_str).collect::<Vec<_>>());
    Problem::new(&document, &[], &parameters, &probes, 1e-6).map_err(|error| error.to_string())
}

/// The differences of all probes by one parameter at one distance, with these weights; nothing where there is no answer beside it.
fn differences(problem: &Problem, x: &[f64], input: usize, (part, weights): (f64, &[f64])) -> Option<Vec<f64>> {
    let apart = part * x[input];
    let row = |times: f64| {
        let mut row = x.to_vec();
        row[input] += times * apart;
        row
    };
    let rows: Vec<f64> =
        (1..=weights.len()).flat_map(|times| [row(times as f64), row(-(times as f64))].concat()).collect();
    let answer = problem.evaluate(&rows);
    let probes = answer.values.len() / (2 * weights.len());
    let y = |row: usize, probe: usize| answer.values[row * probes + probe];
    let slope = |probe: usize| {
        let pairs = weights.iter().enumerate();
        pairs.map(|(pair, weight)| weight * (y(2 * pair, probe) - y(2 * pair + 1, probe)) / apart).sum()
    };
    answer.reasons.iter().all(Option::is_none).then(|| (0..probes).map(slope).collect())
}

fn judge(random: &Random) -> Outcome {
    let problem = match problem(random) {
        Ok(problem) => problem,
        Err(_) => return Outcome::Refused("no network".to_owned()),
    };
    let x = problem.middle();
    let found = problem.gradient(&x);
    let are_known = |values: &[f64]| values.iter().all(|value| value.is_finite());
    let within = match found.reasons[0] {
        None => WITHIN,
        Some(Reason::Inexact { error, .. }) if are_known(&found.jacobian) => error,
        Some(_) => {
            let why = if are_known(&found.values) { "no derivative, for a reason" } else { "no answer" };
            return Outcome::Refused(why.to_owned());
        }
    };
    let (inputs, probes) = (x.len(), random.probes.len());
    let largest = |probe: usize| {
        let floor = FIXED * found.values[probe].abs().max(random.scales[probe]);
        let sizes = (0..inputs).map(|input| (found.jacobian[probe * inputs + input] * x[input]).abs());
        sizes.fold(floor, f64::max)
    };
    let largest: Vec<f64> = (0..probes).map(largest).collect();
    let mut worst = Miss { within, ..Miss::default() };
    for input in 0..inputs {
        let mut nearest = vec![f64::INFINITY; probes];
        for part in PARTS {
            for (probe, slope) in differences(&problem, &x, input, part).into_iter().flatten().enumerate() {
                let miss = (slope - found.jacobian[probe * inputs + input]).abs() * x[input].abs();
                nearest[probe] = nearest[probe].min(miss / largest[probe]);
            }
            if nearest.iter().all(|&by| by <= ENOUGH * WITHIN) {
                break;
            }
        }
        for (probe, &by) in nearest.iter().enumerate() {
            if largest[probe] > 0.0 && by > worst.by {
                let parameter = format!("{} ({})", random.parameters[input], random.kinds[input]);
                worst = Miss { by, within, probe: random.probes[probe].clone(), parameter };
            }
        }
    }
    Outcome::Missed(worst)
}

fn show(random: &Random) {
    println!("{}", random.text);
    let problem = match problem(random) {
        Ok(problem) => problem,
        Err(error) => return println!("{error}"),
    };
    let x = problem.middle();
    let found = problem.gradient(&x);
    println!("{:?} {:?}", found.values, found.reasons[0]);
    let parts = PARTS.map(|(part, _)| part);
    println!("Derivatives, each times its parameter, and differences at {parts:?} of it:");
    for (input, (name, kind)) in random.parameters.iter().zip(&random.kinds).enumerate() {
        let columns = PARTS.map(|part| differences(&problem, &x, input, part));
        for (output, probe) in random.probes.iter().enumerate() {
            print!("{probe} by {name} ({kind}): {:.10e} |", found.jacobian[output * x.len() + input] * x[input]);
            for column in &columns {
                print!(" {:.10e}", column.as_ref().map_or(f64::NAN, |slopes| slopes[output] * x[input]));
            }
            println!();
        }
    }
}
