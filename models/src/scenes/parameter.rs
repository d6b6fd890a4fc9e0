//! Parameters of scenes: their defaults, what they may be, and what a user makes of them.

use std::fmt;

use crate::error::InputError;

use crate::input::read::suggest;
use crate::model::Units;
use crate::unit::{self, Kind, Unit};

use super::file::NetworkFile;

/// Why a scene is not written.
pub type Refused = Box<InputError>;

/// A parameter of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// The name that it is set by.
    pub name: &'static str,
    /// What it is, in a few words.
    pub what: &'static str,
    /// Its value unless set.
    pub default: Default,
}

/// What a parameter is unless set, and what it may be.
#[derive(Clone, Copy, Debug)]
pub enum Default {
    /// A quantity that the file keeps as a parameter, in the unit of its dimension.
    Quantity(f64, Dimension, Range),
    /// A number of things, which shapes the file.
    Count(usize, usize, usize),
    /// A choice among words, which shapes the file; the first is the default.
    Choice(&'static [&'static str]),
}

/// Kind of a quantity, which gives its unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// In mm.
    Length,
    /// In degrees.
    Angle,
    /// In psi, the unit of the muscles' tables.
    Pressure,
    /// In kPa, the unit of pressures that enter formulas.
    Kilopascal,
    /// In N.
    Force,
    /// A mass in g.
    Gram,
}

/// Bounds of a quantity; a bound that is open does not belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Where it begins.
    pub low: Bound,
    /// Where it ends.
    pub high: Bound,
}

/// An end of the range of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// There is none.
    None,
    /// The quantity does not reach it.
    Open(f64),
    /// The quantity may be equal to it.
    Closed(f64),
}

impl Parameter {
    /// A parameter with its name, what it is, and its default.
    pub const fn new(name: &'static str, what: &'static str, default: Default) -> Self {
        Self { name, what, default }
    }

    /// How the parameter is set, where it shapes the file and so is none of the parameters in it.
    pub fn shape(&self) -> Option<String> {
        let choices = match self.default {
            Default::Quantity(..) => return None,
            Default::Count(_, low, high) => format!("{low} to {high}"),
            Default::Choice(words) => words.join(" | "),
        };
        Some(format!("Also --set {}=…, {}: {choices}", self.name, self.what))
    }

    /// A length in mm, greater than `above`.
    pub const fn length(name: &'static str, value: f64, above: f64, what: &'static str) -> Self {
        let range = Range { low: Bound::Open(above), high: Bound::None };
        Self::new(name, what, Default::Quantity(value, Dimension::Length, range))
    }

    /// An angle in degrees, between 0 and 90, both excluded.
    pub const fn angle(name: &'static str, value: f64, what: &'static str) -> Self {
        let range = Range { low: Bound::Open(0.0), high: Bound::Open(90.0) };
        Self::new(name, what, Default::Quantity(value, Dimension::Angle, range))
    }

    /// A pressure in psi up to the end of a muscle's table.
    pub const fn pressure(name: &'static str, value: f64, highest: f64, what: &'static str) -> Self {
        let range = Range { low: Bound::Closed(0.0), high: Bound::Closed(highest) };
        Self::new(name, what, Default::Quantity(value, Dimension::Pressure, range))
    }
}

impl Dimension {
    /// Its unit, as network files have it.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Length => "mm",
            Self::Angle => "deg",
            Self::Pressure => "psi",
            Self::Kilopascal => "kPa",
            Self::Force => "N",
            Self::Gram => "g",
        }
    }

    fn kind(self) -> Kind {
        match self {
            Self::Length => Kind::Length,
            Self::Angle => Kind::Angle,
            Self::Pressure | Self::Kilopascal => Kind::Stress,
            Self::Force => Kind::Force,
            Self::Gram => Kind::Mass,
        }
    }

    /// A value with this unit, in the unit of this dimension.
    fn convert(self, value: f64, unit: &Unit) -> f64 {
        match self {
            Self::Length | Self::Force => value * unit.to_file(Units::MmNMpa),
            Self::Angle => (value * unit.to_file(Units::MmNMpa)).to_degrees(),
            Self::Pressure | Self::Kilopascal | Self::Gram => {
                value * unit.factor / unit::parse(self.unit()).map_or(1.0, |own| own.factor)
            }
        }
    }
}

impl Range {
    /// Whether a value lies within the bounds.
    pub fn holds(self, value: f64) -> bool {
        let above = match self.low {
            Bound::None => true,
            Bound::Open(low) => value > low,
            Bound::Closed(low) => value >= low,
        };
        let below = match self.high {
            Bound::None => true,
            Bound::Open(high) => value < high,
            Bound::Closed(high) => value <= high,
        };
        above && below
    }

    /// The range in words, with the unit of its bounds.
    pub fn words(self, unit: &str) -> String {
        match (self.low, self.high) {
            (Bound::None, Bound::None) => "any number".to_owned(),
            (low, Bound::None) => format!("{} {unit}", low.words("greater than", "at least")),
            (Bound::None, high) => format!("{} {unit}", high.words("less than", "at most")),
            (low, high) => {
                format!("{} and {} {unit}", low.words("greater than", "at least"), high.words("less than", "at most"))
            }
        }
    }
}

impl Bound {
    fn words(self, open: &str, closed: &str) -> String {
        match self {
            Self::None => String::new(),
            Self::Open(value) => format!("{open} {value}"),
            Self::Closed(value) => format!("{closed} {value}"),
        }
    }
}

impl fmt::Display for Default {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Quantity(value, dimension, _) => write!(f, "{value} {}", dimension.unit()),
            Self::Count(value, ..) => write!(f, "{value}"),
            Self::Choice(words) => write!(f, "{}", words.join(" | ")),
        }
    }
}

/// Value of a parameter.
#[derive(Clone, Debug, PartialEq)]
enum Value {
    Number(f64),
    Count(usize),
    Word(&'static str),
}

/// The parameters of a scene with their values.
#[derive(Clone, Debug)]
pub struct Settings {
    scene: &'static str,
    parameters: &'static [Parameter],
    values: Vec<Value>,
    /// What differs from the defaults, as written by the user.
    pub given: Vec<(String, String)>,
}

impl Settings {
    /// Takes in what a user sets.
    ///
    /// # Errors
    /// Unknown names, what is no value, and values out of their range.
    pub fn new(
        scene: &'static str,
        parameters: &'static [Parameter],
        given: &[(String, String)],
    ) -> Result<Self, Vec<InputError>> {
        let values = parameters.iter().map(|parameter| match parameter.default {
            Default::Quantity(value, ..) => Value::Number(value),
            Default::Count(value, ..) => Value::Count(value),
            Default::Choice(words) => Value::Word(words[0]),
        });
        let mut settings = Self { scene, parameters, values: values.collect(), given: given.to_vec() };
        let mut errors = Vec::new();
        for (name, text) in given {
            match settings.set(name, text.trim()) {
                Ok(()) => {}
                Err(error) => errors.push(*error),
            }
        }
        if errors.is_empty() { Ok(settings) } else { Err(errors) }
    }

    fn set(&mut self, name: &str, text: &str) -> Result<(), Refused> {
        let Some(at) = self.parameters.iter().position(|parameter| parameter.name == name) else {
            let known = self.parameters.iter().map(|parameter| parameter.name);
            let message = format!("scene '{}' has no parameter '{name}'", self.scene);
            return Err(Box::new(InputError::new(message).about(name).help(suggest(name, known, "parameters"))));
        };
        self.values[at] = match self.parameters[at].default {
            Default::Quantity(_, dimension, range) => {
                let value = quantity(name, text, dimension)?;
                if !range.holds(value) {
                    return Err(self.out_of_range(
                        name,
                        &format!("{value} {}", dimension.unit()),
                        &range.words(dimension.unit()),
                    ));
                }
                Value::Number(value)
            }
            Default::Count(_, low, high) => match text.parse::<usize>() {
                Ok(count) if (low..=high).contains(&count) => Value::Count(count),
                _ => return Err(self.out_of_range(name, text, &format!("a whole number from {low} to {high}"))),
            },
            Default::Choice(words) => match words.iter().find(|word| **word == text) {
                Some(word) => Value::Word(word),
                None => {
                    let message = format!("'{name}' of scene '{}' is '{text}'", self.scene);
                    return Err(Box::new(InputError::new(message).help(suggest(text, words.iter().copied(), "words"))));
                }
            },
        };
        Ok(())
    }

    fn out_of_range(&self, name: &str, value: &str, range: &str) -> Refused {
        Box::new(
            InputError::new(format!("'{name}' of scene '{}' is {value}, out of its range", self.scene))
                .help(format!("{name} must be {range}")),
        )
    }

    /// Refuses the value of a parameter that does not go together with the others.
    ///
    /// # Errors
    /// Where `fits` is false: `range` says what is permitted, and why.
    pub fn require(&self, name: &str, fits: bool, range: &str) -> Result<(), Refused> {
        if fits {
            return Ok(());
        }
        let value = match self.value(name) {
            Value::Number(value) => value.to_string(),
            Value::Count(count) => count.to_string(),
            Value::Word(word) => format!("'{word}'"),
        };
        Err(self.out_of_range(name, &value, range))
    }

    fn value(&self, name: &str) -> &Value {
        let at = self.parameters.iter().position(|parameter| parameter.name == name);
        at.map(|at| &self.values[at]).unwrap_or_else(|| panic!("scene '{}' defines no parameter '{name}'", self.scene))
    }

    /// A quantity, in the unit of its dimension.
    pub fn number(&self, name: &str) -> f64 {
        match self.value(name) {
            Value::Number(value) => *value,
            other => panic!("parameter '{name}' is {other:?}, no quantity"),
        }
    }

    /// Value of a parameter that is a count.
    pub fn count(&self, name: &str) -> usize {
        match self.value(name) {
            Value::Count(count) => *count,
            other => panic!("parameter '{name}' is {other:?}, no count"),
        }
    }

    /// Value of a parameter that is a choice.
    pub fn word(&self, name: &str) -> &'static str {
        match self.value(name) {
            Value::Word(word) => word,
            other => panic!("parameter '{name}' is {other:?}, no word"),
        }
    }

    /// Writes the quantities into the file as its parameters, in the order of the scene.
    pub fn write_parameters(&self, file: &mut NetworkFile) {
        for (parameter, value) in self.parameters.iter().zip(&self.values) {
            if let (Value::Number(value), Default::Quantity(_, dimension, _)) = (value, parameter.default) {
                let remark = format!("{}, {}", parameter.what, dimension.unit());
                file.line("parameters", parameter.name, value.to_string(), &remark);
            }
        }
    }
}

fn quantity(name: &str, text: &str, dimension: Dimension) -> Result<f64, Refused> {
    let wrong = |message: String| {
        let help = format!("write a number of {}, or a quantity with its unit", dimension.unit());
        Box::new(InputError::new(message).help(help))
    };
    match unit::split_quantity(text) {
        Some((value, "")) if value.is_finite() => Ok(value),
        Some((value, symbols)) if value.is_finite() => match unit::parse(symbols) {
            Ok(unit) if unit.fits(dimension.kind()) => Ok(dimension.convert(value, &unit)),
            Ok(unit) => Err(wrong(format!("'{name}' is set to '{text}', which is {}", unit.description()))),
            Err(message) => Err(wrong(format!("'{name}' is set to '{text}': {message}"))),
        },
        _ => Err(wrong(format!("'{name}' is set to '{text}', which is no quantity"))),
    }
}
