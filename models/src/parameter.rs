//! Parameters as a user states them: each by a number in the unit that it is written with.
//!
//! `p = "15 psi"` is 15, and whoever sets it to 20 means 20 psi, wherever that is done. Expressions see what is measured instead,
//! in the units of the file: see [`Quantity`].

use std::sync::Arc;

use crate::expression::{Measure, Quantity};
use crate::model::Units;
use crate::unit::{Exponents, Kind, Unit};

/// A parameter of a network.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Under `[parameters]`.
    pub name: String,
    /// In its unit.
    pub value: f64,
    /// Nothing for a parameter that is written without one: it is a bare number wherever it goes.
    pub unit: Option<ParameterUnit>,
}

/// The unit of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterUnit {
    /// As it is written, such as `psi`.
    pub name: Arc<str>,
    /// What one of it is in the units of the file; of an angle in degrees.
    pub scale: f64,
    /// What numbers in it measure.
    measure: Measure,
}

impl ParameterUnit {
    /// A unit that stands behind a number.
    pub(crate) fn written(name: &str, unit: &Unit, units: Units) -> Self {
        let factor = unit.to_file(units);
        let scale = if unit.is_angle() { factor.to_degrees() } else { factor };
        Self { name: name.into(), scale, measure: Measure::of(unit.exponents) }
    }

    /// The units of the file, an angle in degrees.
    pub(crate) fn of_file(measure: Measure, units: Units) -> Self {
        Self { name: name_in_file(measure.exponents, units).into(), scale: 1.0, measure }
    }

    /// The same unit for what measures the same, as far as is known; nothing for anything else.
    pub(crate) fn of(&self, measure: Measure) -> Option<Self> {
        (measure.exponents == self.measure.exponents).then(|| Self { measure, ..self.clone() })
    }

    fn quantity(&self, number: f64) -> Quantity {
        Quantity { value: number * self.scale, measure: Some(self.measure) }
    }
}

/// A unit made of those of a file, as it may be written behind a number.
fn name_in_file(exponents: Exponents, units: Units) -> String {
    let [length, force, pressure] = units.symbols();
    if exponents == Kind::Angle.exponents() {
        return "deg".to_owned();
    }
    if exponents == Kind::Stress.exponents() {
        return pressure.to_owned();
    }
    let [of_length, of_mass, of_time, of_angle] = exponents;
    let parts = match of_time == -2 * of_mass {
        true => [(force, of_mass), (length, of_length - of_mass), ("s", 0), ("rad", of_angle)],
        false => [(units.mass(), of_mass), (length, of_length), ("s", of_time), ("rad", of_angle)],
    };
    let part = |(symbol, exponent): &(&str, i32)| match exponent {
        0 => None,
        1 => Some((*symbol).to_owned()),
        _ => Some(format!("{symbol}^{exponent}")),
    };
    let parts: Vec<String> = parts.iter().filter_map(part).collect();
    if parts.is_empty() { "1".to_owned() } else { parts.join(" ") }
}

/// A number with the unit of its parameter.
#[derive(Clone, Debug)]
pub(crate) struct Stated {
    pub(crate) number: f64,
    pub(crate) unit: Option<ParameterUnit>,
}

impl Stated {
    /// What it measures.
    pub(crate) fn quantity(&self) -> Quantity {
        self.unit.as_ref().map_or(self.number.into(), |unit| unit.quantity(self.number))
    }

    /// Takes what an expression for the parameter gave, and says what that measures: a bare result is a number like any other, in
    /// the unit if there is one.
    pub(crate) fn take(&mut self, found: Quantity) -> Quantity {
        match (&self.unit, found.measure) {
            (Some(unit), Some(_)) => {
                self.number = found.value / unit.scale;
                found
            }
            _ => {
                self.number = found.value;
                self.quantity()
            }
        }
    }
}
