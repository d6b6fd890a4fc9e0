//! What every part of the reading needs: parameters, units, and the list of what is wrong.

use std::collections::HashMap;
use std::ops::Range;
use std::path::PathBuf;

use nalgebra::Vector3;

use crate::error::{InputError, InputErrors, Source, Span, Warning};
use crate::expression::{Expression, Quantity};
use crate::input::read::{Map, Number, Spanned, Written, suggest};
use crate::input::tree::Value;
use crate::model::Units;
use crate::unit::{self, Kind, Unit};

/// The state of a reading.
pub struct Context {
    pub errors: Vec<InputError>,
    pub warnings: Vec<Warning>,
    pub sources: Vec<Source>,
    /// The trees of the sources, as far as they could be parsed.
    pub trees: Vec<Option<Value>>,
    /// Where files that the network refers to are looked for.
    pub directory: PathBuf,
    pub units: Units,
    /// `None` where evaluating the parameter failed: no message about what depends on it.
    parameters: HashMap<String, Option<Quantity>>,
    parameter_names: Vec<String>,
}

/// Names of one kind of thing, in the order of the file.
#[derive(Clone, Debug, Default)]
pub struct Names {
    what: &'static str,
    order: Vec<String>,
    index: HashMap<String, usize>,
}

impl Names {
    pub fn new<'a>(what: &'static str, names: impl Iterator<Item = &'a str>) -> Self {
        let order: Vec<String> = names.map(str::to_owned).collect();
        let index = order.iter().enumerate().map(|(index, name)| (name.clone(), index)).collect();
        Self { what, order, index }
    }

    pub fn get(&self, name: &str) -> Option<usize> {
        self.index.get(name).copied()
    }

    pub fn of(&self, index: usize) -> &str {
        &self.order[index]
    }

    pub fn iter(&self) -> impl Iterator<Item = &str> {
        self.order.iter().map(String::as_str)
    }

    /// Index of a name, or an error that says who refers to what is not there.
    pub fn find(&self, name: &str, span: Span, owner: &str, cx: &mut Context) -> Option<usize> {
        let found = self.get(name);
        // Who has read a hundred messages needs no more, and looking for likely names takes time.
        if found.is_none() && cx.errors.len() < 100 {
            cx.error(
                InputError::new(format!("{owner} refers to {} '{name}', which is not defined", self.what))
                    .at(span)
                    .label(format!("no such {}", self.what))
                    .help(suggest(name, self.iter(), &plural(self.what))),
            );
        }
        found
    }
}

fn plural(what: &str) -> String {
    match what.strip_suffix('y') {
        Some(stem) => format!("{stem}ies"),
        None => format!("{what}s"),
    }
}

impl Context {
    pub fn new(directory: PathBuf) -> Self {
        Self {
            errors: Vec::new(),
            warnings: Vec::new(),
            sources: Vec::new(),
            trees: Vec::new(),
            directory,
            units: Units::default(),
            parameters: HashMap::new(),
            parameter_names: Vec::new(),
        }
    }

    pub fn error(&mut self, error: InputError) {
        self.errors.push(error);
    }

    pub fn warn(&mut self, warning: Warning) {
        self.warnings.push(warning);
    }

    /// Everything found wrong, with key paths filled in.
    pub fn into_errors(mut self) -> InputErrors {
        let mut errors = std::mem::take(&mut self.errors);
        self.fill_paths(&mut errors);
        InputErrors { errors, sources: self.sources }
    }

    pub fn fill_paths(&self, findings: &mut [InputError]) {
        for finding in findings.iter_mut().filter(|finding| finding.path.is_empty()) {
            if let Some(span) = finding.span
                && let Some(Some(tree)) = self.trees.get(span.file)
            {
                finding.path = tree.path_to(span);
            }
        }
    }

    /// Values of the parameters that could be evaluated, in the order of the file.
    pub fn parameter_values(&self) -> Vec<(String, f64)> {
        let value = |name: &String| Some((name.clone(), self.parameters.get(name)?.as_ref()?.value));
        self.parameter_names.iter().filter_map(value).collect()
    }

    /// Takes in the parameters of the file, replaced by those set from outside.
    pub fn set_parameters(&mut self, parameters: &Map<Number>, settings: &[(String, String)]) {
        let mut numbers: Vec<(String, Number)> =
            parameters.iter().map(|named| (named.name.clone(), named.value.clone())).collect();
        for (name, text) in settings {
            let text = text.trim();
            let written = match text.parse::<f64>() {
                Ok(number) if number.is_finite() => Written::Bare(number),
                _ => Written::Text(text.to_owned()),
            };
            match numbers.iter_mut().find(|(known, _)| known == name) {
                // A setting has no place in the file: its messages say where it came from.
                Some((_, number)) => *number = Number { span: SETTING, value: written },
                None => {
                    let known = parameters.iter().map(|named| named.name.as_str());
                    self.error(InputError::new(format!("there is no parameter '{name}' to set")).help(suggest(
                        name,
                        known,
                        "parameters",
                    )));
                }
            }
        }
        self.parameter_names = numbers.iter().map(|(name, _)| name.clone()).collect();
        self.evaluate_parameters(&numbers);
    }

    fn evaluate_parameters(&mut self, numbers: &[(String, Number)]) {
        let index: HashMap<&str, usize> =
            numbers.iter().enumerate().map(|(index, (name, _))| (name.as_str(), index)).collect();
        let needs = |number: &Number| -> Vec<usize> {
            let Written::Text(text) = &number.value else { return Vec::new() };
            let Some(formula) = text.trim().strip_prefix('=') else { return Vec::new() };
            let Ok(expression) = Expression::parse(formula) else { return Vec::new() };
            expression.references().iter().filter_map(|name| index.get(name.name.as_str()).copied()).collect()
        };
        let needs: Vec<Vec<usize>> = numbers.iter().map(|(_, number)| needs(number)).collect();
        let mut users = vec![Vec::new(); numbers.len()];
        let mut open: Vec<usize> = needs.iter().map(Vec::len).collect();
        for (user, needed) in needs.iter().enumerate() {
            needed.iter().for_each(|&needed| users[needed].push(user));
        }
        let mut ready: Vec<usize> = (0..numbers.len()).filter(|&at| open[at] == 0).collect();
        while let Some(at) = ready.pop() {
            let (name, number) = &numbers[at];
            let value = self.parameter(name, number);
            self.parameters.insert(name.clone(), value);
            for &user in &users[at] {
                open[user] -= 1;
                if open[user] == 0 {
                    ready.push(user);
                }
            }
        }
        if let Some(first) = (0..numbers.len()).find(|&at| open[at] > 0) {
            self.refuse_cycle(numbers, &needs, &open, first);
        }
    }

    fn refuse_cycle(&mut self, numbers: &[(String, Number)], needs: &[Vec<usize>], open: &[usize], first: usize) {
        // Every open parameter needs an open one, so going on long enough ends up in a cycle.
        let next = |at: usize| needs[at].iter().copied().find(|&needed| open[needed] > 0).unwrap_or(at);
        let start = (0..numbers.len()).fold(first, |at, _| next(at));
        let mut round = vec![start];
        while next(round[round.len() - 1]) != start && round.len() < numbers.len() {
            round.push(next(round[round.len() - 1]));
        }
        let names: Vec<&str> = round.iter().chain([&start]).take(8).map(|&at| numbers[at].0.as_str()).collect();
        let error = InputError::new(format!("parameter '{}' depends on itself: {}", names[0], names.join(" → ")))
            .help("give one of them a number");
        self.error(place(error, numbers[start].1.span));
        for (_, (name, _)) in numbers.iter().enumerate().filter(|(at, _)| open[*at] > 0) {
            self.parameters.insert(name.clone(), None);
        }
    }

    /// A parameter: a bare number, an expression, or a text whose unit is converted to the file's (angles to degrees).
    fn parameter(&mut self, name: &str, number: &Number) -> Option<Quantity> {
        let text = match &number.value {
            Written::Bare(value) => return Some((*value).into()),
            Written::Text(text) => text,
        };
        if text.trim().starts_with('=') {
            let before = self.errors.len();
            let value = self.expression(text, number.span);
            if number.span == SETTING {
                for error in &mut self.errors[before..] {
                    error.message = format!("parameter '{name}' set to '{text}': {}", error.message);
                }
            }
            return value;
        }
        let failed = |error: String| {
            let error =
                if number.span == SETTING { format!("parameter '{name}' set to '{text}': {error}") } else { error };
            place(InputError::new(error), number.span)
        };
        match unit::split_quantity(text) {
            Some((value, "")) if number.span == SETTING => {
                if value.is_finite() {
                    return Some(value.into());
                }
                self.error(failed("the number is not finite".to_owned()).help("give a finite number"));
                None
            }
            Some((value, unit)) => match unit::parse(unit) {
                Ok(unit) => {
                    let factor = unit.to_file(self.units);
                    let factor = if unit.is_angle() { factor.to_degrees() } else { factor };
                    Some(Quantity { value: value * factor, is_pressure: unit.is_pressure() })
                }
                Err(error) => {
                    self.error(failed(error).help("write for example \"172 kPa\", or a number without quotes"));
                    None
                }
            },
            None => {
                self.error(
                    failed(format!("'{text}' is neither a number nor a quantity"))
                        .help("write for example 30, \"172 kPa\" or \"= 2 * L\""),
                );
                None
            }
        }
    }

    /// Value of an expression "= …" of the parameters.
    fn expression(&mut self, text: &str, span: Span) -> Option<Quantity> {
        let start = text.find('=').map_or(0, |at| at + 1);
        let inner = |cx: &Self, place: Range<usize>| cx.inside(span, text, start + place.start..start + place.end);
        let expression = match Expression::parse(&text[start..]) {
            Ok(expression) => expression,
            Err(error) => {
                let at = inner(self, error.place);
                self.error(
                    place(InputError::new(error.message), at)
                        .help("write for example \"= L * cos(beta)\"; ^ is the power"),
                );
                return None;
            }
        };
        let mut values = Vec::with_capacity(expression.references().len());
        for reference in expression.references() {
            let at = inner(self, reference.place.clone());
            if reference.step.is_some() {
                self.error(
                    place(InputError::new(format!("'{}@…' has a meaning in probes only", reference.name)), at)
                        .help("use parameters and numbers here"),
                );
                return None;
            }
            match self.parameters.get(&reference.name) {
                Some(value) => values.push((*value)?),
                None => {
                    let known = self.parameter_names.iter().map(String::as_str);
                    let help = if self.parameter_names.is_empty() {
                        "define it under [parameters]".to_owned()
                    } else {
                        suggest(&reference.name, known, "parameters")
                    };
                    self.error(
                        place(InputError::new(format!("unknown parameter '{}' in an expression", reference.name)), at)
                            .label("not a parameter")
                            .help(help),
                    );
                    return None;
                }
            }
        }
        match expression.evaluate(&values) {
            Ok(value) => Some(value),
            Err(error) => {
                let mut names: Vec<String> = expression
                    .references()
                    .iter()
                    .zip(&values)
                    .map(|(reference, value)| format!("{} = {}", reference.name, value.value))
                    .collect();
                names.dedup();
                let help = if names.is_empty() {
                    "change the numbers".to_owned()
                } else {
                    format!("with {}", names.join(", "))
                };
                let at = inner(self, error.place);
                self.error(place(InputError::new(format!("an expression fails: {}", error.message)), at).help(help));
                None
            }
        }
    }

    /// Place of a part of a text value; the whole value where escapes hide the part.
    pub fn inside(&self, span: Span, text: &str, part: Range<usize>) -> Span {
        let written = self.sources.get(span.file).and_then(|source| source.text.get(span.start..span.end));
        let Some(at) = written.and_then(|written| written.find(text)) else { return span };
        let start = span.start + at;
        // An empty part, such as the end of an expression, is shown by what stands before it.
        let first = if part.is_empty() { part.start.saturating_sub(1) } else { part.start };
        Span { start: start + first, end: start + part.end.max(first + 1).min(text.len()), ..span }
    }

    /// A quantity of a kind in the file's units; angles in radians.
    pub fn number(&mut self, number: &Number, kind: Kind) -> Option<f64> {
        let value = match &number.value {
            Written::Bare(value) => *value,
            Written::Text(text) if text.trim_start().starts_with('=') => self.expression(text, number.span)?.value,
            Written::Text(text) => {
                let (value, unit) = self.quantity(text, number.span, kind)?;
                return self.sensible(value * unit.to_file(self.units), number.span);
            }
        };
        self.sensible(if kind == Kind::Angle { value.to_radians() } else { value }, number.span)
    }

    /// A value whose square does not overflow.
    fn sensible(&mut self, value: f64, span: Span) -> Option<f64> {
        const LIMIT: f64 = 1e100;
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
    pub fn pressure(&mut self, number: &Number, unit: &Unit) -> Option<f64> {
        let value = match &number.value {
            Written::Bare(value) => *value,
            Written::Text(text) if text.trim_start().starts_with('=') => {
                let quantity = self.expression(text, number.span)?;
                let factor = if quantity.is_pressure { Unit::file_pressure(self.units) / unit.factor } else { 1.0 };
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
    pub fn inverse_pressure(&mut self, number: &Number, unit: &Unit) -> Option<f64> {
        match &number.value {
            Written::Text(text) if !text.trim_start().starts_with('=') => {
                let (value, given) = self.quantity(text, number.span, Kind::InversePressure)?;
                self.sensible(value * (given.factor * unit.factor), number.span)
            }
            _ => self.number(number, Kind::Pure),
        }
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
    pub fn positive(&mut self, number: &Number, kind: Kind, what: &str) -> Option<f64> {
        let value = self.number(number, kind)?;
        if value > 0.0 {
            return Some(value);
        }
        self.error(
            place(InputError::new(format!("{what} is {value}, it must be greater than zero")), number.span)
                .help("write a positive number"),
        );
        None
    }

    /// A quantity that must not be negative.
    pub fn not_negative(&mut self, number: &Number, kind: Kind, what: &str) -> Option<f64> {
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
    pub fn vector(&mut self, list: &Spanned<Vec<Number>>, kind: Kind, what: &str) -> Option<[f64; 3]> {
        if !(2..=3).contains(&list.value.len()) {
            let count = list.value.len();
            self.error(
                place(InputError::new(format!("{what} has {count} number(s), it needs two or three")), list.span)
                    .help("write [x, y] or [x, y, z]"),
            );
            return None;
        }
        let values: Vec<Option<f64>> = list.value.iter().map(|number| self.number(number, kind)).collect();
        Some([values[0]?, values[1]?, values.get(2).copied().unwrap_or(Some(0.0))?])
    }

    /// A list of three components.
    pub fn triple(&mut self, list: &Spanned<Vec<Number>>, kind: Kind, what: &str) -> Option<[f64; 3]> {
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
    pub fn direction(&mut self, list: &Spanned<Vec<Number>>, what: &str) -> Option<Vector3<f64>> {
        let vector = Vector3::from(self.vector(list, Kind::Pure, what)?);
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
const SETTING: Span = Span { file: usize::MAX, start: 0, end: 0 };

fn place(error: InputError, span: Span) -> InputError {
    if span == SETTING { error } else { error.at(span) }
}
