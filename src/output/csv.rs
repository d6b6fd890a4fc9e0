//! `history.csv`: the unloaded state and one row an increment, with the step, the fraction of its ramp, the loads and
//! pressures, and the probes.

use std::io::{self, Write};

use csv::Writer;
use pennate_analysis::solution::{Solution, unloaded};

use super::loads;
use super::table::probe_unit;

/// A history by columns: the unloaded state, then one row an increment.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// Name of the step of each row.
    pub steps: Vec<String>,
    /// Fraction of the step's ramp, in each row.
    pub fractions: Vec<f64>,
    /// Loads and pressures, then the probes.
    pub columns: Vec<Column>,
}

/// One column with its values, which are not a number where there is none.
#[derive(Clone, Debug)]
pub struct Column {
    /// What it is, without its unit.
    pub name: String,
    /// Empty where there is none.
    pub unit: String,
    /// One a row.
    pub values: Vec<f64>,
}

impl Table {
    /// The history of the loads and the probes.
    pub fn of(solution: &Solution) -> Self {
        let model = &solution.model;
        let loads = loads::columns(model, &solution.history.steps);
        let probes = model.probes.names.iter().enumerate();
        let probes = probes.map(|(index, name)| (name.clone(), probe_unit(model, index).to_owned()));
        let heads = loads.iter().map(|column| (column.name.clone(), column.unit.clone())).chain(probes);
        let columns = heads.map(|(name, unit)| Column { name, unit, values: Vec::new() }).collect();
        let mut table = Self { columns, ..Self::default() };
        if let Some(name) = model.step_names().first() {
            let mut before = model.probes.evaluate(&unloaded(model), &[]);
            before.resize(model.probes.names.len(), f64::NAN);
            table.add(name, 0.0, vec![0.0; loads.len()].iter().chain(&before));
        }
        for (index, ((name, step), probes)) in solution.steps().zip(&solution.probes.steps).enumerate() {
            for (increment, values) in step.increments.iter().zip(&probes.increments) {
                let at: Vec<f64> = loads.iter().map(|column| column.at(index, increment.fraction)).collect();
                table.add(name, increment.fraction, at.iter().chain(values));
            }
        }
        table
    }

    fn add<'a>(&mut self, step: &str, fraction: f64, values: impl Iterator<Item = &'a f64>) {
        self.steps.push(step.to_owned());
        self.fractions.push(fraction);
        for (column, &value) in self.columns.iter_mut().zip(values) {
            // −0 is a number like any other to a program and a riddle to a person.
            column.values.push(if value.is_finite() { value + 0.0 } else { f64::NAN });
        }
    }
}

/// Writes the history of the loads and the probes.
///
/// # Errors
/// Those of the writer.
pub fn write(solution: &Solution, writer: &mut dyn Write) -> io::Result<()> {
    let history = Table::of(solution);
    let mut table = Writer::from_writer(writer);
    let heads = ["step", "fraction"].map(str::to_owned).into_iter();
    table.write_record(heads.chain(history.columns.iter().map(|column| head(&column.name, &column.unit))))?;
    for (row, (step, fraction)) in history.steps.iter().zip(&history.fractions).enumerate() {
        // A value that is not a number leaves its field empty.
        let values = history.columns.iter().map(|column| Some(column.values[row]).filter(|value| !value.is_nan()));
        table.serialize((step, fraction, values.collect::<Vec<_>>()))?;
    }
    table.flush()
}

/// A name with its unit, as columns have it.
pub fn head(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} ({unit})") }
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
