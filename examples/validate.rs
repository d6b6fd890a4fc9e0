//! Prints the errors of every validation case as a Markdown table, with what each solve cost.
//!
//!     cargo run --release --example validate              the table
//!     cargo run --release --example validate -- --write   the same, put into docs/validation.md
//!
//! One row is one network file; where it is solved with several sets of parameters, errors are the largest, elements
//! those of the largest mesh, factorizations and times sums. The time is that of the solver on every mesh it tried.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

use pennate::{Input, Job, Refusal};
use serde_json::Value;

use pennate_testing::comparison::{Case, Outcome, Row, Setting};
use pennate_testing::page;

const DEFAULT_ACCURACY: &str = "1e-6";

fn main() -> ExitCode {
    let write = std::env::args().any(|argument| argument == "--write");
    let mut failures = Vec::new();
    let mut lines = vec![
        "| case | worst quantity | error, default | error, fine | error / estimate | elements | factorizations | solve |"
            .to_owned(),
        "|---|---|---:|---:|---:|---:|---:|---:|".to_owned(),
    ];
    for case in Case::names().iter().map(|name| Case::open(name)) {
        let unchecked = case.unchecked().into_iter();
        failures.extend(unchecked.map(|place| format!("{}: nothing checks {place}", case.name)));
        for (network, [default, fine]) in outcomes(&case) {
            for outcome in default.iter().chain(&fine) {
                let title = format!("{}/{} ({:?})", case.name, outcome.label, outcome.setting);
                failures.extend(outcome.failures().into_iter().map(|failure| format!("{title}: {failure}")));
            }
            let name = format!("{}/{}", case.name, network.trim_end_matches(".toml"));
            lines.push(row(&name, &default, &fine));
        }
    }
    let table = lines.join("\n");
    println!("{table}");
    for failure in &failures {
        eprintln!("{failure}");
    }
    if write && let Err(message) = page::put("validation table", &table) {
        eprintln!("{message}");
        return ExitCode::FAILURE;
    }
    if failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// All runs of a case by network file, with default settings and on a fine mesh.
fn outcomes(case: &Case) -> BTreeMap<String, [Vec<Outcome>; 2]> {
    let mut outcomes: BTreeMap<String, [Vec<Outcome>; 2]> = BTreeMap::new();
    for run in case.runs() {
        let [default, fine] = outcomes.entry(run.network.clone()).or_default();
        default.push(case.compare(run, Setting::Default, solve));
        fine.push(case.compare(run, Setting::Fine, solve));
    }
    outcomes
}

fn row(name: &str, default: &[Outcome], fine: &[Outcome]) -> String {
    let worst = |outcomes: &[Outcome]| {
        let worst = outcomes.iter().filter_map(Outcome::worst);
        worst.max_by(|a, b| a.relative().total_cmp(&b.relative())).cloned()
    };
    let estimates = default.iter().chain(fine).filter_map(Outcome::worst_estimate);
    let estimate = estimates.map(|(factor, _)| factor).max_by(|a, b| a.ln().abs().total_cmp(&b.ln().abs()));
    let error = |row: Option<&Row>| row.map_or("–".to_owned(), |row| format!("{:.1e}", row.relative()));
    let worst_default = worst(default);
    format!(
        "| {name} | {} | {} | {} | {} | {} | {} | {:.1} ms |",
        worst_default.as_ref().map_or("–", |row| &row.quantity),
        error(worst_default.as_ref()),
        error(worst(fine).as_ref()),
        estimate.map_or("–".to_owned(), |factor| format!("{factor:.2}")),
        default.iter().map(|outcome| outcome.elements).max().unwrap_or(0),
        default.iter().map(|outcome| outcome.factorizations).sum::<u64>(),
        1e3 * default.iter().map(|outcome| outcome.solve_seconds).sum::<f64>(),
    )
}

fn solve(network: &Path, set: &[(String, String)], accuracy: Option<&str>) -> Result<Value, String> {
    let job = Job {
        input: Input { file: network.to_owned(), settings: set.to_vec() },
        accuracy: accuracy.unwrap_or(DEFAULT_ACCURACY).parse().map_err(|_| "not an accuracy".to_owned())?,
        threads: None,
        shapes: false,
    };
    let solution = pennate::run(&job, &mut |_| true).map_err(|refusal| match refusal {
        Refusal::Input(errors) => format!("{errors:?}"),
        Refusal::Mechanism(_, motions) => format!("a mechanism: {motions:?}"),
    })?;
    let mut json = Vec::new();
    pennate::output::json::write(&solution, &[], &mut json).map_err(|error| error.to_string())?;
    serde_json::from_slice(&json).map_err(|error| error.to_string())
}
