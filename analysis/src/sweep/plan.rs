//! What a sweep solves: parameters, and a value of each for every row of its table.

use std::path::Path;

use pennate_models::{InputError, InputErrors};

use super::vary::{self, Vary};
use crate::rows::place;

/// Parameters with their units, and rows of values for them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// What is varied.
    pub parameters: Vec<Parameter>,
    /// Numbers as texts, in the order of the parameters.
    pub rows: Vec<Vec<String>>,
    /// Rows of a list have a number of their own, since two of them may have the same values.
    pub is_list: bool,
}

/// A parameter that is varied.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// As the network file has it.
    pub name: String,
    /// Of the values; empty where there is none.
    pub unit: String,
}

impl Parameter {
    /// Name and value with its unit, as parameters are set.
    pub fn setting(&self, value: &str) -> (String, String) {
        let text = if self.unit.is_empty() { value.to_owned() } else { format!("{value} {}", self.unit) };
        (self.name.clone(), text)
    }
}

impl Plan {
    /// All combinations of some values, the last parameter running fastest.
    ///
    /// # Errors
    /// More combinations than anyone waits for.
    pub fn combinations(vary: &[Vary]) -> Result<Self, InputErrors> {
        let rows =
            vary::combinations(vary).map_err(|message| alone(InputError::new(message).help("vary less at once")))?;
        let parameters = vary.iter().map(|each| Parameter { name: each.name.clone(), unit: each.unit.clone() });
        Ok(Self { parameters: parameters.collect(), rows, is_list: false })
    }

    /// The rows of a CSV file, whose heads are parameters, `beta` or `beta (deg)`.
    ///
    /// # Errors
    /// A file that cannot be read or holds something else, with the line.
    pub fn list(path: &Path) -> Result<Self, InputErrors> {
        let shown = path.display();
        let wrong = |message: String| {
            let help =
                "a head with the names of parameters, such as \"beta (deg),pressure\", and one row of numbers a design";
            alone(InputError::new(format!("{shown}: {message}")).help(help))
        };
        let text = std::fs::read_to_string(path).map_err(|error| wrong(error.to_string()))?;
        let mut reader =
            csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text.as_bytes());
        let heads = reader.headers().map_err(|error| wrong(error.to_string()))?.clone();
        let parameters: Vec<Parameter> = heads.iter().map(parameter).collect();
        if parameters.iter().any(|parameter| parameter.name.is_empty()) {
            return Err(wrong("a column has no name".to_owned()));
        }
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|error| wrong(error.to_string()))?;
            let (_, line) = place(&text, record.position());
            let number = |(text, parameter): (&str, &Parameter)| match text.parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(value.to_string()),
                _ => Err(wrong(format!("line {line}: '{text}' is no number for '{}'", parameter.name))),
            };
            rows.push(record.iter().zip(&parameters).map(number).collect::<Result<_, _>>()?);
        }
        if rows.is_empty() {
            return Err(wrong("there are no designs in it".to_owned()));
        }
        Ok(Self { parameters, rows, is_list: true })
    }

    /// Distinct values of a parameter, in rising order.
    pub fn values(&self, parameter: usize) -> Vec<f64> {
        let mut values: Vec<f64> = self.rows.iter().filter_map(|row| row[parameter].parse().ok()).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    }
}

/// A head with its unit taken off: `beta (deg)`.
fn parameter(head: &str) -> Parameter {
    let split = head.strip_suffix(')').and_then(|head| head.rsplit_once('('));
    let (name, unit) = split.unwrap_or((head, ""));
    Parameter { name: name.trim().to_owned(), unit: unit.trim().to_owned() }
}

fn alone(error: InputError) -> InputErrors {
    InputErrors { errors: vec![error], sources: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_has_heads_with_units_and_rows_of_numbers() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("designs.csv");
        std::fs::write(&path, "beta (deg), L\n# a comment\n22, 130\n30,1.0e2\n").unwrap();
        let plan = Plan::list(&path).unwrap();
        assert_eq!(plan.parameters[0], Parameter { name: "beta".into(), unit: "deg".into() });
        assert_eq!(plan.rows, [["22", "130"], ["30", "100"]]);
        assert_eq!(plan.parameters[0].setting("22"), ("beta".to_owned(), "22 deg".to_owned()));
        assert_eq!(plan.values(1), [100.0, 130.0]);
        for (text, message) in [
            ("beta\nx\n", "line 2: 'x' is no number for 'beta'"),
            ("beta,L\n1\n", "designs.csv"),
            ("beta\n", "no designs"),
            ("beta,\n1,2\n", "a column has no name"),
        ] {
            std::fs::write(&path, text).unwrap();
            let errors = Plan::list(&path).unwrap_err();
            assert!(errors.errors[0].message.contains(message), "{errors}");
        }
    }
}
