//! The values that a sweep gives to parameters.

use std::collections::HashSet;
use std::str::FromStr;

/// More combinations than anyone waits for are a slip of the pen.
const MOST: usize = 1_000_000;

/// A parameter and the values it takes one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Vary {
    /// Name of the parameter.
    pub name: String,
    /// Numbers as texts.
    pub values: Vec<String>,
    /// The unit behind the values; empty where there is none.
    pub unit: String,
}

impl FromStr for Vary {
    type Err = String;

    /// Reads `beta=10:60:2`, `pressure=10,15,20` or the same with a unit behind it, `beta=10:60:2 deg`.
    fn from_str(text: &str) -> Result<Self, String> {
        let usage =
            "NAME=FROM:TO:STEP or NAME=VALUE,VALUE,… expected, such as beta=10:60:2 or \"pressure=10,15,20 psi\"";
        let (name, values) = text.split_once('=').ok_or(usage)?;
        let (name, values) = (name.trim(), values.trim());
        let end = values.rfind(|c: char| c.is_ascii_digit() || c == '.').map_or(0, |at| at + 1);
        // A unit may end in a digit, "g/cm^3": then it begins at the first space.
        let end = values.find(char::is_whitespace).map_or(end, |space| end.min(space));
        let (numbers, unit) = (&values[..end], values[end..].trim());
        if name.is_empty() || numbers.is_empty() || unit.starts_with([',', ':']) {
            return Err(usage.to_owned());
        }
        let numbers = match numbers.split(':').collect::<Vec<_>>()[..] {
            [from, to, step] => range(number(from)?, number(to)?, number(step)?)?,
            [list] => list.split(',').map(number).collect::<Result<_, _>>()?,
            _ => return Err(usage.to_owned()),
        };
        let mut seen = HashSet::new();
        let values: Vec<String> = numbers.iter().map(f64::to_string).collect();
        if let Some(twice) = values.iter().find(|value| !seen.insert(value.as_str())) {
            return Err(format!("'{name}' has the value {twice} twice: each is solved once"));
        }
        Ok(Self { name: name.to_owned(), unit: unit.to_owned(), values })
    }
}

fn number(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| format!("'{}' is not a number", text.trim()))
}

/// From, by steps, up to and including the end where a step meets it.
fn range(from: f64, to: f64, step: f64) -> Result<Vec<f64>, String> {
    let count = (to - from) / step;
    if !(count.is_finite() && count >= 0.0) {
        return Err(format!("{from} by steps of {step} never gets to {to}"));
    }
    if count > MOST as f64 {
        return Err(format!("more than {MOST} values from {from} to {to}"));
    }
    // What rounding leaves of a decimal step is no part of the value.
    let decimal = |value: f64| format!("{value:.12e}").parse().unwrap_or(value);
    let last = (count * (1.0 + 1e-12) + 1e-9).floor() as usize;
    Ok((0..=last).map(|index| decimal(from + index as f64 * step)).collect())
}

/// All combinations, the last parameter running fastest.
///
/// # Errors
/// More of them than anyone waits for, in words.
pub fn combinations(vary: &[Vary]) -> Result<Vec<Vec<String>>, String> {
    let count = vary.iter().try_fold(1_usize, |count, each| count.checked_mul(each.values.len()));
    if count.is_none_or(|count| count > MOST) {
        return Err(format!("more than {MOST} combinations"));
    }
    let mut all = vec![Vec::new()];
    for each in vary {
        let longer = |start: &Vec<String>| {
            each.values.iter().map(|value| [start.as_slice(), std::slice::from_ref(value)].concat()).collect::<Vec<_>>()
        };
        all = all.iter().flat_map(longer).collect();
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Vec<String> {
        let vary = text.parse::<Vary>().unwrap();
        let with_unit = |value: String| format!("{value} {}", vary.unit).trim().to_owned();
        vary.values.into_iter().map(with_unit).collect()
    }

    #[test]
    fn ranges_end_where_a_step_meets_the_end() {
        assert_eq!(values("b=10:60:25"), ["10", "35", "60"]);
        assert_eq!(values("b=10:59:25"), ["10", "35"]);
        assert_eq!(values("b=0:0.3:0.1"), ["0", "0.1", "0.2", "0.3"]);
        assert_eq!(values("b=3:1:-1"), ["3", "2", "1"]);
        assert_eq!(values("b=5:5:1"), ["5"]);
    }

    #[test]
    fn a_unit_behind_the_values_belongs_to_each() {
        assert_eq!(values("p=10,15 psi"), ["10 psi", "15 psi"]);
        assert_eq!(values("b=10:20:5deg"), ["10 deg", "15 deg", "20 deg"]);
        assert_eq!(values("rho=1,2 g/cm^3"), ["1 g/cm^3", "2 g/cm^3"]);
        assert_eq!("b = 1, 2".parse::<Vary>().unwrap_err(), "'' is not a number");
    }

    #[test]
    fn slips_are_refused() {
        for text in ["b", "b=", "=1", "b=1:2", "b=1:2:0", "b=2:1:1", "b=1:2:3:4", "b=1,x", "b=0:1:1e-9", "b=inf"] {
            assert!(text.parse::<Vary>().is_err(), "{text}");
        }
    }

    #[test]
    fn the_last_parameter_runs_fastest() {
        let vary = ["a=1,2", "b=3,4"].map(|text| text.parse().unwrap());
        assert_eq!(combinations(&vary).unwrap(), [["1", "3"], ["1", "4"], ["2", "3"], ["2", "4"]]);
        let many: Vec<Vary> = (0..4).map(|_| "a=1:100:1".parse().unwrap()).collect();
        assert!(combinations(&many).is_err());
    }
}
