//! What every part of the reading needs: parameters, units, and the list of what is wrong.

use std::fmt::{self, Display};
use std::ops::Range;
use std::sync::Arc;

use nalgebra::Vector3;
use rustc_hash::FxHashMap;

use super::compiled::Compiled;
use super::lasting::Lasting;
use crate::error::{InputError, InputErrors, Source, Span, Warning};
use crate::expression::{Certainty, Quantity};
use crate::file::Folder;
use crate::input::read::{Count, Counted, Number, Spanned, Written, suggest};
use crate::model::Units;
use crate::parameter::Stated;
use crate::unit::{self, Kind, Unit};

/// The largest number that a network needs: its square does not overflow, and neither does its inverse's.
const LIMIT: f64 = 1e100;

/// The state of a reading.
pub(crate) struct Context {
    pub(crate) errors: Vec<InputError>,
    pub(crate) warnings: Vec<Warning>,
    pub(crate) sources: Vec<Source>,
    /// Where files that the network refers to come from.
    pub(crate) folder: Folder,
    pub(crate) units: Units,
    /// Values of the parameters by their place; `None` where evaluating one failed: no message about what depends on it.
    pub(crate) parameters: Vec<Option<Quantity>>,
    pub(crate) parameter_names: Names,
    /// The same as they are stated: numbers in these units.
    pub(crate) stated: Vec<Stated>,
    /// What takes the place of what the file and settings say.
    pub(crate) given: FxHashMap<String, Stated>,
    /// Whether pressures may lie beside the tables of their muscles.
    pub(crate) beside: bool,
    /// Whether what follows the parameters is to be found out.
    pub(crate) again: bool,
    /// Parameters that a count depends on, by itself or through others.
    pub(crate) counting: Vec<String>,
    /// Parameters that are expressions, each after those that it needs.
    pub(crate) worked_out: Vec<(usize, String, Span)>,
    /// The parameters that a parameter is worked out from.
    pub(crate) sources_of: FxHashMap<String, Vec<String>>,
    /// The path that a member is a part of, by the name of the member.
    pub(crate) paths: FxHashMap<String, String>,
    /// What an evaluation before found out for good.
    pub(crate) known: Arc<Lasting>,
    /// The same of this evaluation, where it is asked for.
    pub(crate) lasting: Option<Lasting>,
    /// The same network, ready to be evaluated again; nothing where that has to be done as a whole.
    pub(crate) compiled: Option<Compiled>,
    /// How many expressions were met so far.
    pub(crate) expressions_met: usize,
}

/// What a message is about: "member 'left'".
#[derive(Clone, Copy, Debug)]
pub(crate) struct Owner<'a>(pub(crate) &'static str, pub(crate) &'a str);

impl Display for Owner<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} '{}'", self.0, self.1)
    }
}

/// Names of one kind of thing, in the order of the file; a copy shares them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Names {
    what: &'static str,
    table: Arc<Table>,
}

#[derive(Debug, Default)]
struct Table {
    order: Vec<String>,
    index: FxHashMap<String, usize>,
}

impl Names {
    pub(crate) fn new<'a>(what: &'static str, names: impl Iterator<Item = &'a str>) -> Self {
        let order: Vec<String> = names.map(str::to_owned).collect();
        let index = order.iter().enumerate().map(|(index, name)| (name.clone(), index)).collect();
        Self { what, table: Arc::new(Table { order, index }) }
    }

    pub(crate) fn get(&self, name: &str) -> Option<usize> {
        self.table.index.get(name).copied()
    }

    pub(crate) fn of(&self, index: usize) -> &str {
        &self.table.order[index]
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &str> {
        self.table.order.iter().map(String::as_str)
    }

    /// Index of a name, or an error that says who refers to what is not there.
    pub(crate) fn find(&self, name: &str, span: Span, owner: impl Display, cx: &mut Context) -> Option<usize> {
        self.find_or(name, span, owner, &[], cx)
    }

    /// The same, where the name may as well have been one of others.
    pub(crate) fn find_or(
        &self,
        name: &str,
        span: Span,
        owner: impl Display,
        others: &[&str],
        cx: &mut Context,
    ) -> Option<usize> {
        let found = self.get(name);
        if found.is_none() && !cx.has_many_errors() {
            let others = others.iter().copied().filter(|other| self.get(other).is_none());
            cx.error(
                InputError::new(format!("{owner} refers to {} '{name}', which is not defined", self.what))
                    .at(span)
                    .label(format!("no such {}", self.what))
                    .help(suggest(name, self.iter().chain(others), &plural(self.what))),
            );
        }
        found
    }

    /// The two different names of a list; `help` says how it is written.
    pub(crate) fn pair(
        &self,
        list: &Spanned<Vec<Spanned<String>>>,
        owner: impl Display,
        help: &str,
        cx: &mut Context,
    ) -> Option<[usize; 2]> {
        let [first, second] = list.value.as_slice() else {
            let title = format!("{owner} has {} {}(s)", list.value.len(), self.what);
            cx.error(InputError::new(title).at(list.span).help(help));
            return None;
        };
        let start = self.find(&first.value, first.span, &owner, cx);
        let end = self.find(&second.value, second.span, &owner, cx);
        let pair = [start?, end?];
        if pair[0] == pair[1] {
            cx.error(
                InputError::new(format!("{owner} starts and ends at {} '{}'", self.what, first.value))
                    .at(list.span)
                    .label(format!("one {} twice", self.what))
                    .help(format!("name two different {}", plural(self.what))),
            );
            return None;
        }
        Some(pair)
    }
}

fn plural(what: &str) -> String {
    match what.strip_suffix('y') {
        Some(stem) => format!("{stem}ies"),
        None => format!("{what}s"),
    }
}

impl Context {
    pub(crate) fn new(folder: Folder) -> Self {
        Self {
            errors: Vec::new(),
            warnings: Vec::new(),
            sources: Vec::new(),
            folder,
            units: Units::default(),
            parameters: Vec::new(),
            parameter_names: Names::default(),
            stated: Vec::new(),
            given: FxHashMap::default(),
            beside: false,
            again: false,
            counting: Vec::new(),
            worked_out: Vec::new(),
            sources_of: FxHashMap::default(),
            paths: FxHashMap::default(),
            known: Arc::default(),
            lasting: None,
            compiled: None,
            expressions_met: 0,
        }
    }

    /// Whether more messages of one kind help nobody: looking for likely names takes time.
    pub(crate) fn has_many_errors(&self) -> bool {
        self.errors.len() >= 100
    }

    pub(crate) fn error(&mut self, error: InputError) {
        self.errors.push(error);
    }

    pub(crate) fn warn(&mut self, warning: Warning) {
        self.warnings.push(warning);
    }

    /// Everything found wrong.
    pub(crate) fn into_errors(self) -> InputErrors {
        InputErrors { errors: self.errors, sources: self.sources }
    }

    /// Place of a part of a text value; the whole value where escapes hide the part.
    pub(crate) fn inside(&self, span: Span, text: &str, part: Range<usize>) -> Span {
        let written = self.sources.get(span.file).and_then(|source| source.text.get(span.start..span.end));
        let Some(at) = written.and_then(|written| written.find(text)) else { return span };
        let start = span.start + at;
        // An empty part, such as the end of an expression, is shown by what stands before it.
        let first = if part.is_empty() { part.start.saturating_sub(1) } else { part.start };
        Span { start: start + first, end: start + part.end.max(first + 1).min(text.len()), ..span }
    }

    /// A quantity of a kind in the file's units; angles in radians.
    pub(crate) fn number(&mut self, number: &Number, kind: Kind) -> Option<f64> {
        let value = match &number.value {
            Written::Bare(value) => *value,
            Written::Text(text) if text.trim_start().starts_with('=') => {
                let quantity = self.expression(text, number.span)?;
                self.check_measure(&quantity, kind, text, number.span)?;
                quantity.value
            }
            Written::Text(text) => {
                let (value, unit) = self.quantity(text, number.span, kind)?;
                return self.sensible(value * unit.to_file(self.units), number.span);
            }
        };
        self.sensible(if kind == Kind::Angle { value.to_radians() } else { value }, number.span)
    }

    /// A value whose square does not overflow.
    fn sensible(&mut self, value: f64, span: Span) -> Option<f64> {
        if value.abs() <= LIMIT {
            return Some(value);
        }
        self.error(
            place(InputError::new(format!("the number {value:e} is too large")), span)
                .help(format!("no network needs more than {LIMIT:e}")),
        );
        None
    }

    /// A pressure in a unit: bare numbers are in it, texts and parameters with another unit are converted.
    pub(crate) fn pressure(&mut self, number: &Number, unit: &Unit) -> Option<f64> {
        let value = match &number.value {
            Written::Bare(value) => *value,
            Written::Text(text) if text.trim_start().starts_with('=') => {
                let quantity = self.expression(text, number.span)?;
                self.check_measure(&quantity, Kind::Stress, text, number.span)?;
                let factor = match quantity.is_pressure() {
                    true => Unit::file_pressure(self.units) / unit.factor,
                    false => 1.0,
                };
                // In the unit of the file a bare number means what it says.
                if factor != 1.0 && quantity.measure.is_some_and(|measure| measure.is_mixed) {
                    self.error(
                        place(
                            InputError::new(format!(
                                "'{}' adds a bare number to a pressure, and does not say in which unit",
                                text.trim()
                            )),
                            number.span,
                        )
                        .label("a pressure and a bare number")
                        .help("make the number a parameter with its unit, such as dp = \"10 psi\", and write \"= p + dp\""),
                    );
                    return None;
                }
                quantity.value * factor
            }
            Written::Text(text) => {
                let (value, given) = self.quantity(text, number.span, Kind::Stress)?;
                value * (given.factor / unit.factor)
            }
        };
        self.sensible(value, number.span)
    }

    /// Contraction per pressure, in the inverse of a unit.
    pub(crate) fn inverse_pressure(&mut self, number: &Number, unit: &Unit) -> Option<f64> {
        match &number.value {
            Written::Text(text) if !text.trim_start().starts_with('=') => {
                let (value, given) = self.quantity(text, number.span, Kind::InversePressure)?;
                self.sensible(value * (given.factor * unit.factor), number.span)
            }
            Written::Text(text) => {
                let quantity = self.expression(text, number.span)?;
                if quantity.measure.is_none_or(|measure| measure.exponents == [0; 4]) {
                    return self.sensible(quantity.value, number.span);
                }
                self.check_measure(&quantity, Kind::InversePressure, text, number.span)?;
                let known = quantity.measure.is_some_and(|measure| Kind::InversePressure.fits(measure.exponents));
                let factor = if known { unit.factor / Unit::file_pressure(self.units) } else { 1.0 };
                self.sensible(quantity.value * factor, number.span)
            }
            Written::Bare(value) => self.sensible(*value, number.span),
        }
    }

    /// What the units of an expression say it measures must be what is asked for.
    fn check_measure(&mut self, quantity: &Quantity, kind: Kind, text: &str, span: Span) -> Option<()> {
        let Some(measure) = quantity.measure else { return Some(()) };
        // A number without unit that a bare quotient left is any quantity; an angle in degrees is a number like any other.
        if kind.fits(measure.exponents) || measure.certainty == Certainty::Guessed {
            return Some(());
        }
        let wrong = place(
            InputError::new(format!(
                "'{}' is {}; {} is expected",
                text.trim(),
                unit::describe(measure.exponents),
                kind.description()
            )),
            span,
        )
        .label("wrong unit");
        if measure.certainty == Certainty::Likely {
            let help = "give the numbers in it their units, as parameters of their own: A = \"3 mm^2\"";
            self.warn(wrong.help(help));
            return Some(());
        }
        self.error(wrong.help("change the unit of the parameter, or write it without one"));
        None
    }

    /// A count of something, written or worked out.
    pub(crate) fn count(&mut self, counted: &Spanned<Counted>) -> Option<usize> {
        let text = match &counted.value {
            Counted::Bare(count) => return Some(count.0),
            Counted::Expression(text) => text,
        };
        self.note_counting(text);
        let quantity = self.expression(text, counted.span)?;
        self.check_measure(&quantity, Kind::Pure, text, counted.span)?;
        let value = quantity.value.round();
        // What rounding leaves of a quotient is no part of it.
        let whole = (quantity.value - value).abs() <= 1e-9 * value.abs();
        if whole && (1.0..=Count::LIMIT as f64).contains(&value) {
            return Some(value as usize);
        }
        self.error(
            place(
                InputError::new(format!(
                    "'{}' is {}; a whole number from 1 to {} is expected",
                    text.trim(),
                    quantity.value,
                    Count::LIMIT
                )),
                counted.span,
            )
            .label("no count")
            .help("change the parameters, or write a whole number"),
        );
        None
    }

    fn quantity(&mut self, text: &str, span: Span, kind: Kind) -> Option<(f64, Unit)> {
        let expected = kind.description();
        let error = |message: String, help: String| Some(place(InputError::new(message), span).help(help));
        let wrong = match unit::split_quantity(text) {
            None if text.chars().any(|c| "+-*/^(".contains(c)) => error(
                format!("'{text}' is no quantity; {expected} is expected"),
                format!("an expression begins with '=': \"= {}\"", text.trim()),
            ),
            None => error(
                format!("'{text}' is no quantity; {expected} is expected"),
                "write a number, a text with a unit, or an expression \"= …\"".to_owned(),
            ),
            Some((value, "")) => error(
                format!("the text '{text}' has no unit"),
                format!("write {value} without quotes, or with its unit; {expected} is expected"),
            ),
            Some((value, _)) if !value.is_finite() => {
                error(format!("'{text}' is not finite"), "write a finite number".to_owned())
            }
            Some((value, symbols)) => match unit::parse(symbols) {
                Err(message) => error(message, format!("{expected} is expected")),
                Ok(unit) if unit.fits(kind) => return Some((value, unit)),
                Ok(unit) => error(
                    format!("'{text}' is {}; {expected} is expected", unit.description()),
                    "change the unit, or write a number without quotes".to_owned(),
                ),
            },
        };
        self.errors.extend(wrong.map(|wrong| wrong.label("wrong unit or value")));
        None
    }

    /// A quantity that must be greater than zero.
    pub(crate) fn positive(&mut self, number: &Number, kind: Kind, what: impl Display) -> Option<f64> {
        let value = self.number(number, kind)?;
        if value >= LIMIT.recip() {
            return Some(value);
        }
        if value > 0.0 {
            self.error(
                place(InputError::new(format!("{what} is {value:e}, which is too small")), number.span)
                    .help(format!("no network needs less than {:e}", LIMIT.recip())),
            );
            return None;
        }
        self.error(
            place(InputError::new(format!("{what} is {value}, it must be greater than zero")), number.span)
                .help("write a positive number"),
        );
        None
    }

    /// A quantity that must not be negative.
    pub(crate) fn not_negative(&mut self, number: &Number, kind: Kind, what: impl Display) -> Option<f64> {
        let value = self.number(number, kind)?;
        if value >= 0.0 {
            return Some(value);
        }
        self.error(
            place(InputError::new(format!("{what} is {value}, it must not be negative")), number.span)
                .help("write zero or a positive number"),
        );
        None
    }

    /// A list of two or three components; the third is zero where it is left out.
    pub(crate) fn vector(&mut self, list: &Spanned<Vec<Number>>, kind: Kind, what: impl Display) -> Option<[f64; 3]> {
        if !(2..=3).contains(&list.value.len()) {
            let count = list.value.len();
            self.error(
                place(InputError::new(format!("{what} has {count} number(s), it needs two or three")), list.span)
                    .help("write [x, y] or [x, y, z]"),
            );
            return None;
        }
        let mut values = [Some(0.0); 3];
        for (value, number) in values.iter_mut().zip(&list.value) {
            *value = self.number(number, kind);
        }
        Some([values[0]?, values[1]?, values[2]?])
    }

    /// A list of three components.
    pub(crate) fn triple(&mut self, list: &Spanned<Vec<Number>>, kind: Kind, what: impl Display) -> Option<[f64; 3]> {
        if list.value.len() != 3 {
            let count = list.value.len();
            self.error(
                place(InputError::new(format!("{what} has {count} number(s), it needs three")), list.span)
                    .help("write three numbers in [ ], zeros included"),
            );
            return None;
        }
        self.vector(list, kind, what)
    }

    /// A direction as a unit vector.
    pub(crate) fn direction(&mut self, list: &Spanned<Vec<Number>>, what: impl Display) -> Option<Vector3<f64>> {
        let vector = Vector3::from(self.vector(list, Kind::Pure, &what)?);
        let largest = vector.amax();
        if largest == 0.0 {
            self.error(
                place(InputError::new(format!("{what} is zero and points nowhere")), list.span)
                    .help("write a direction such as [0, 0, 1]"),
            );
            return None;
        }
        Some((vector / largest).normalize())
    }
}

/// Place of what was set from outside.
pub(crate) const SETTING: Span = Span { file: usize::MAX, start: 0, end: 0 };

/// An error at a place; without one where the span is that of a setting.
pub(crate) fn place(error: InputError, span: Span) -> InputError {
    if span == SETTING { error } else { error.at(span) }
}
