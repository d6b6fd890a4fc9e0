//! No answer depends on the numbers that steer the way to it.

use std::path::Path;

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_models::read;
use pennate_solver::continuation::Tuning;
use pennate_solver::history::{CriticalKind, Status};
use pennate_solver::options::Options;
use pennate_testing::repository;
use rayon::prelude::*;

/// Every number by its name, to be multiplied by a factor. One that is not listed here does not compile.
fn moved(factor: f64) -> Vec<(&'static str, Tuning)> {
    let mut all = Vec::new();
    macro_rules! numbers {
        (counts: $($count:ident),*; sizes: $($size:ident),*) => {
            let Tuning { $($count: _,)* $($size: _,)* } = Tuning::default();
            $({
                let mut tuning = Tuning::default();
                tuning.$count = (factor * tuning.$count as f64).round() as usize;
                all.push((stringify!($count), tuning));
            })*
            $({
                let mut tuning = Tuning::default();
                tuning.$size *= factor;
                all.push((stringify!($size), tuning));
            })*
        };
    }
    numbers!(
        counts: iterations, many;
        sizes: increment, residual, rounding, contraction, trust, near, buckling, miss, shorter, longer, missed, swing,
        bracket, shortest, straight, exact, amplitude, endless
    );
    // No angle has a cosine beyond one; what is shortened must be shorter; and an iteration that begins 0.05 away comes to
    // rounding by squares in five.
    for (_, tuning) in &mut all {
        tuning.straight = tuning.straight.min(0.95);
        tuning.shorter = tuning.shorter.min(0.8);
        tuning.contraction = tuning.contraction.min(0.9);
        tuning.many = tuning.many.max(5);
    }
    all
}

/// How a step ends, and what it passes: kind, fraction of the ramp, and its error.
#[derive(Debug)]
struct End {
    status: Status,
    stable: Option<bool>,
    points: Vec<(CriticalKind, f64, f64)>,
}

/// What a network comes to: the ends of its steps, and every displacement there with what it may be off by.
#[derive(Debug)]
struct Answer {
    steps: Vec<End>,
    values: Vec<f64>,
    room: f64,
}

fn answer(file: &Path, tuning: Tuning) -> Result<Answer, String> {
    let model = read(file, &[]).map_err(|errors| format!("{errors:?}"))?;
    let options = Options { estimate: true, tuning, ..Options::default() };
    let solution = solve_to_accuracy(model, 1e-6, &options, &mut |_| true).map_err(|(_, error)| error.to_string())?;
    let (mut steps, mut values) = (Vec::new(), Vec::new());
    for step in &solution.history.steps {
        let points = step.critical_points.iter();
        let points = points.map(|p| (p.kind, p.fraction, p.error.unwrap_or(1e-3))).collect();
        steps.push(End { status: step.status, stable: step.stable, points });
        let Some(last) = step.increments.last() else { continue };
        values.extend(last.state.nodes.iter().flat_map(|node| node.displacement));
    }
    let largest = values.iter().fold(0.0f64, |largest, value| largest.max(value.abs()));
    Ok(Answer { steps, values, room: 3e-6 * largest.max(f64::MIN_POSITIVE) })
}

/// What differs, in words; nothing where the answers are the same.
fn difference(one: &Answer, other: &Answer) -> Option<String> {
    let places = |of: &Answer| of.steps.iter().map(|end| (end.status, end.stable, end.points.len())).collect();
    let (first, second): (Vec<_>, Vec<_>) = (places(one), places(other));
    if first != second {
        return Some(format!("{first:?}, moved {second:?}"));
    }
    for (end, moved) in one.steps.iter().zip(&other.steps) {
        for (a, b) in end.points.iter().zip(&moved.points) {
            if a.0 != b.0 || (a.1 - b.1).abs() > 3.0 * (a.2 + b.2) * a.1.abs().max(1.0) {
                return Some(format!("{a:?}, moved {b:?}"));
            }
        }
    }
    let farthest = one.values.iter().zip(&other.values).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    (farthest > one.room + other.room).then(|| format!("displacements by {farthest:e}, of {:e}", one.room / 3e-6))
}

/// Every number of the table, halved and doubled, leaves the answers to the networks of `validation/` as they are.
#[test]
fn every_number_may_be_twice_or_half_of_what_it_is() {
    let folders = std::fs::read_dir(repository("validation")).expect("the folder");
    let mut files: Vec<_> = folders
        .flatten()
        .filter(|folder| folder.file_name().to_string_lossy().starts_with(|c: char| c.is_ascii_digit()))
        .flat_map(|folder| std::fs::read_dir(folder.path()).expect("a folder").flatten().map(|file| file.path()))
        .filter(|file| file.extension().is_some_and(|extension| extension == "toml"))
        .filter(|file| std::fs::read_to_string(file).is_ok_and(|text| text.contains("pennate/1")))
        .collect();
    files.sort();
    assert!(files.len() >= 35, "only {}", files.len());
    let variants: Vec<_> =
        [0.5, 2.0].iter().flat_map(|&factor| moved(factor).into_iter().map(move |n| (factor, n))).collect();
    let failures: Vec<String> = files
        .par_iter()
        .flat_map(|file| {
            let own = answer(file, Tuning::default());
            let mut failures = Vec::new();
            for (factor, (name, tuning)) in &variants {
                let other = answer(file, *tuning);
                let wrong = match (&own, &other) {
                    (Ok(own), Ok(other)) => difference(own, other),
                    (Err(own), Err(other)) => (own != other).then(|| format!("{own}, moved {other}")),
                    (own, other) => Some(format!("{:?}, moved {:?}", own.is_ok(), other.as_ref().err())),
                };
                failures.extend(wrong.map(|wrong| format!("{name} × {factor}: {}: {wrong}", file.display())));
            }
            failures
        })
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
