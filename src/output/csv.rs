//! `history.csv`: one row an increment, with the step, the fraction of its ramp and the probes.

use std::io::{self, Write};

use csv::Writer;

use crate::solution::Solution;

/// Writes the history of the probes.
///
/// # Errors
/// Those of the writer.
pub fn write(solution: &Solution, writer: &mut dyn Write) -> io::Result<()> {
    let mut table = Writer::from_writer(writer);
    let header = ["step", "fraction"].into_iter().chain(solution.model.probes.names.iter().map(String::as_str));
    table.write_record(header)?;
    for ((name, step), probes) in solution.steps().zip(&solution.probes.steps) {
        for (increment, values) in step.increments.iter().zip(&probes.increments) {
            table.serialize((name, increment.fraction, finite(values)))?;
        }
    }
    table.flush()
}

/// A value that is not a number leaves its field empty.
fn finite(values: &[f64]) -> Vec<Option<f64>> {
    values.iter().map(|&value| value.is_finite().then_some(value)).collect()
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
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[1], vec!["push; \"hard\"", "0.75", "0.3333333333333333", ""]);
    }
}
