//! `history.csv`: the unloaded state and one row an increment, with the step, the fraction of its ramp, the loads and
//! pressures, and the probes.

use std::io::{self, Write};

use csv::Writer;
use pennate_analysis::solution::{Solution, unloaded};
use pennate_models::Model;

use super::loads;
use super::table::unit;

/// Writes the history of the loads and the probes.
///
/// # Errors
/// Those of the writer.
pub fn write(solution: &Solution, writer: &mut dyn Write) -> io::Result<()> {
    let mut table = Writer::from_writer(writer);
    let model = &solution.model;
    let loads = loads::columns(model);
    let probes = model.probes.names.iter().enumerate().map(|(index, name)| head(name, probe_unit(model, index)));
    let heads = ["step", "fraction"].map(str::to_owned).into_iter();
    table.write_record(heads.chain(loads.iter().map(|column| column.head.clone())).chain(probes))?;
    let at = |step: usize, fraction: f64| loads.iter().map(|column| column.at(step, fraction)).collect::<Vec<_>>();
    if let Some(name) = model.step_names().first() {
        let mut before = model.probes.evaluate(&unloaded(model), &[]);
        before.resize(model.probes.names.len(), f64::NAN);
        table.serialize((name, 0.0, vec![0.0; loads.len()], finite(&before)))?;
    }
    for (index, ((name, step), probes)) in solution.steps().zip(&solution.probes.steps).enumerate() {
        for (increment, values) in step.increments.iter().zip(&probes.increments) {
            table.serialize((name, increment.fraction, at(index, increment.fraction), finite(values)))?;
        }
    }
    table.flush()
}

fn probe_unit(model: &Model, index: usize) -> &'static str {
    if index < model.probes.len() { unit(model, model.probes.kind(index)) } else { "" }
}

/// A name with its unit, as columns have it.
pub fn head(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} ({unit})") }
}

/// A value that is not a number leaves its field empty.
fn finite(values: &[f64]) -> Vec<Option<f64>> {
    // −0 is a number like any other to a program and a riddle to a person.
    values.iter().map(|&value| value.is_finite().then_some(value + 0.0)).collect()
}

#[cfg(test)]
mod tests {
    use crate::fixture;

    #[test]
    fn names_with_separators_and_quotes_come_back_whole() {
        let mut solution = fixture::solution();
        solution.model.probes.names = vec!["a,\"b\"\nc".to_owned(), "ä".to_owned()];
        for increment in &mut solution.probes.steps[0].increments {
            *increment = vec![1.0 / 3.0, f64::NAN];
        }
        let mut out = Vec::new();
        super::write(&solution, &mut out).unwrap();
        let mut reader = csv::Reader::from_reader(out.as_slice());
        assert_eq!(reader.headers().unwrap(), vec!["step", "fraction", "a,\"b\"\nc", "ä"]);
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 3);
        assert_eq!(rows[0], vec!["push; \"hard\"", "0.0", "", ""]);
        assert_eq!(rows[2], vec!["push; \"hard\"", "0.75", "0.3333333333333333", ""]);
    }
}
