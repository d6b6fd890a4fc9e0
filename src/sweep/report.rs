//! What a person reads after a sweep.

use std::time::Duration;

use super::Outcome;
use crate::output::text::{Align, columns, duration, number, shown};

/// Failures told one by one.
const FAILED: usize = 10;

/// What came of a sweep: how many were solved, what was not and why, and the range of every probe.
pub fn report(outcome: &Outcome, took: Duration) -> String {
    let (done, failed): (Vec<_>, Vec<_>) = outcome.rows.iter().partition(|row| row.is_solved());
    let mut text = format!("{} solved, {} not solved", done.len(), failed.len());
    if outcome.reused > 0 {
        text += &format!("; {} of them taken from an earlier run", outcome.reused);
    }
    text += &format!(". Took {}.\n", duration(took.as_secs_f64()));
    let head = ["probe", "least", "greatest", "unit"].map(str::to_owned).to_vec();
    let mut rows = vec![head];
    for (index, name) in outcome.columns.probes.iter().enumerate() {
        let values = || done.iter().filter_map(|row| row.probes[index]);
        let Some(least) = values().reduce(f64::min) else { continue };
        let greatest = values().fold(least, f64::max);
        let unit = outcome.columns.units.get(index).cloned().unwrap_or_default();
        rows.push(vec![shown(name), number(least), number(greatest), unit]);
    }
    if rows.len() > 1 {
        text += &format!("\n{}", columns(&[Align::Left, Align::Right, Align::Right, Align::Left], &rows));
    }
    if !failed.is_empty() {
        text += "\n";
    }
    for row in failed.iter().take(FAILED) {
        let keys = outcome.columns.keys.iter().zip(&row.keys).map(|(key, value)| format!("{key} = {value}"));
        text += &format!("{}: {}\n", keys.collect::<Vec<_>>().join(", "), row.reason);
    }
    if failed.len() > FAILED {
        text += &format!("and {} more, in the table\n", failed.len() - FAILED);
    }
    text
}
