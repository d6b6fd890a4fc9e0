//! Parameters: set, evaluated in the order of their needs, and used in expressions.

use std::ops::Range;
use std::sync::Arc;

use super::context::{Context, Names, SETTING, place};
use crate::error::{InputError, Span};
use crate::expression::{Measure, Quantity, Reference};
use crate::input::read::{Map, Number, Written, suggest};
use crate::parameter::{Parameter, ParameterUnit, Stated};
use crate::unit;

impl Context {
    /// Names of the parameters that could be evaluated, and their values in the units of the file, angles in degrees.
    pub(crate) fn parameter_values(&self) -> impl Iterator<Item = (String, f64)> {
        let both = self.parameter_names.iter().zip(&self.parameters);
        both.filter_map(|(name, value)| Some((name.to_owned(), (*value)?.value)))
    }

    /// The parameters as they are stated.
    pub(crate) fn stated_parameters(&self) -> Vec<Parameter> {
        let all = self.parameter_names.iter().zip(&self.stated);
        let parameter = |(name, stated): (&str, &Stated)| Parameter {
            name: name.to_owned(),
            value: stated.number,
            unit: stated.unit.clone(),
        };
        all.map(parameter).collect()
    }

    /// Notes the parameters that an expression for a count refers to, and those that these are worked out from.
    pub(crate) fn note_counting(&mut self, text: &str) {
        let mut open = self.names_in(text);
        while let Some(name) = open.pop() {
            if !self.counting.contains(&name) {
                open.extend(self.sources_of.get(&name).into_iter().flatten().cloned());
                self.counting.push(name);
            }
        }
    }

    /// Takes in the parameters of the file, replaced by those set from outside.
    pub(crate) fn set_parameters(&mut self, parameters: &Map<Number>, settings: &[(String, String)]) {
        let mut numbers: Vec<(String, Number)> =
            parameters.iter().map(|named| (named.name.clone(), named.value.clone())).collect();
        let in_file = if settings.is_empty() { Vec::new() } else { self.units_in_file(&numbers) };
        let mut units = vec![None; numbers.len()];
        for (name, text) in settings {
            let text = text.trim();
            let written = match text.parse::<f64>() {
                Ok(number) if number.is_finite() => Written::Bare(number),
                _ => Written::Text(text.to_owned()),
            };
            match numbers.iter().position(|(known, _)| known == name) {
                // A setting has no place in the file: its messages say where it came from.
                Some(at) => {
                    numbers[at].1 = Number { span: SETTING, value: written };
                    units[at].clone_from(&in_file[at]);
                }
                None => {
                    let known = parameters.iter().map(|named| named.name.as_str());
                    self.error(
                        InputError::new(format!("there is no parameter '{name}' to set")).about(name).help(suggest(
                            name,
                            known,
                            "parameters",
                        )),
                    );
                }
            }
        }
        for named in parameters.iter().filter(|named| named.name == "pi") {
            self.error(
                InputError::new("a parameter cannot be called 'pi'")
                    .at(named.span)
                    .help("in expressions pi is 3.14159…; choose another name"),
            );
        }
        self.evaluate_parameters(&numbers, units);
    }

    /// The units that the file gives its parameters, whatever is set.
    fn units_in_file(&self, numbers: &[(String, Number)]) -> Vec<Option<ParameterUnit>> {
        let mut file = Self::new(self.folder.clone());
        (file.units, file.known) = (self.units, Arc::clone(&self.known));
        file.evaluate_parameters(numbers, vec![None; numbers.len()]);
        file.stated.into_iter().map(|stated| stated.unit).collect()
    }

    /// Evaluates parameters; what is set is stated in these units.
    fn evaluate_parameters(&mut self, numbers: &[(String, Number)], units: Vec<Option<ParameterUnit>>) {
        self.parameter_names = Names::new("parameter", numbers.iter().map(|(name, _)| name.as_str()));
        self.parameters = vec![None; numbers.len()];
        self.stated = units.into_iter().map(|unit| Stated { number: f64::NAN, unit }).collect();
        let index = self.parameter_names.clone();
        let given = std::mem::take(&mut self.given);
        let mut needs = Vec::with_capacity(numbers.len());
        for (name, number) in numbers {
            let names = match &number.value {
                Written::Text(text) if !given.contains_key(name) => self.names_in(text),
                _ => Vec::new(),
            };
            needs.push(names.iter().filter_map(|name| index.get(name)).collect::<Vec<usize>>());
            if !names.is_empty() {
                self.sources_of.insert(name.clone(), names);
            }
        }
        let mut users = vec![Vec::new(); numbers.len()];
        let mut open: Vec<usize> = needs.iter().map(Vec::len).collect();
        for (user, needed) in needs.iter().enumerate() {
            needed.iter().for_each(|&needed| users[needed].push(user));
        }
        let mut ready: Vec<usize> = (0..numbers.len()).filter(|&at| open[at] == 0).collect();
        while let Some(at) = ready.pop() {
            let (name, number) = &numbers[at];
            if let Written::Text(text) = &number.value
                && text.trim().starts_with('=')
            {
                self.worked_out.push((at, text.clone(), number.span));
            }
            self.parameters[at] = match given.get(name) {
                Some(stated) => {
                    self.stated[at].clone_from(stated);
                    Some(stated.quantity())
                }
                None => self.parameter(at, name, number),
            };
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
    }

    /// A parameter: a bare number, an expression, or a text with a unit, which in the file is that of the parameter.
    fn parameter(&mut self, at: usize, name: &str, number: &Number) -> Option<Quantity> {
        let text = match &number.value {
            Written::Bare(value) => return Some(self.stated[at].take((*value).into())),
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
            let value = value?;
            self.stated[at].unit = value.measure.map(|measure| self.unit_of(text, measure));
            return Some(self.stated[at].take(value));
        }
        let failed = |error: String| {
            let error =
                if number.span == SETTING { format!("parameter '{name}' set to '{text}': {error}") } else { error };
            place(InputError::new(error), number.span)
        };
        match unit::split_quantity(text) {
            Some((value, "")) if number.span == SETTING => {
                if value.is_finite() {
                    return Some(self.stated[at].take(value.into()));
                }
                self.error(failed("the number is not finite".to_owned()).help("give a finite number"));
                None
            }
            Some((value, symbols)) => match unit::parse(symbols) {
                Ok(unit) => {
                    let written = ParameterUnit::written(symbols, &unit, self.units);
                    let stated = Stated { number: value, unit: Some(written) };
                    let found = stated.quantity();
                    match found.measure {
                        // What is set is converted: the unit of a parameter does not depend on how it is set.
                        Some(measure) if number.span == SETTING => {
                            let usual = self.stated[at].unit.as_ref().and_then(|unit| unit.of(measure));
                            self.stated[at].unit =
                                Some(usual.unwrap_or_else(|| ParameterUnit::of_file(measure, self.units)));
                            self.stated[at].take(found);
                        }
                        _ => self.stated[at] = stated,
                    }
                    Some(found)
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

    /// The unit of what an expression gives: that of the first parameter in it that measures the same, else that of the file.
    fn unit_of(&mut self, text: &str, measure: Measure) -> ParameterUnit {
        let parsed = text.trim().strip_prefix('=').and_then(|formula| self.parsed(formula).ok());
        let places = parsed.iter().flat_map(|parsed| &parsed.places).flatten();
        let mut units = places.filter_map(|&place| self.stated[place].unit.as_ref());
        units.find_map(|unit| unit.of(measure)).unwrap_or_else(|| ParameterUnit::of_file(measure, self.units))
    }

    /// Takes what the expression of a parameter gives now.
    pub(crate) fn work_out(&mut self, at: usize, found: Quantity) {
        self.parameters[at] = Some(self.stated[at].take(found));
    }

    /// Value of an expression "= …" of the parameters.
    pub(crate) fn expression(&mut self, text: &str, span: Span) -> Option<Quantity> {
        let start = text.find('=').map_or(0, |at| at + 1);
        let inner = |cx: &Self, place: Range<usize>| cx.inside(span, text, start + place.start..start + place.end);
        let parsed = match self.parsed(&text[start..]) {
            Ok(parsed) => parsed,
            Err(error) => {
                let at = inner(self, error.place);
                self.error(
                    place(InputError::new(error.message), at)
                        .help("write for example \"= L * cos(beta)\"; ^ is the power"),
                );
                return None;
            }
        };
        let expression = &parsed.expression;
        for (reference, place_of) in expression.references().iter().zip(&parsed.places) {
            if reference.step.is_some() {
                let at = inner(self, reference.place.clone());
                self.error(
                    place(InputError::new(format!("'{}@…' has a meaning in probes only", reference.name)), at)
                        .help("use parameters and numbers here"),
                );
                return None;
            }
            match place_of {
                // Why one has no value was said.
                Some(parameter) if self.parameters[*parameter].is_none() => return None,
                Some(_) => {}
                None => {
                    let at = inner(self, reference.place.clone());
                    let help = match self.parameters.is_empty() {
                        true => "define it under [parameters]".to_owned(),
                        false => suggest(&reference.name, self.parameter_names.iter(), "parameters"),
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
        let of = |place: usize| parsed.places[place].and_then(|parameter| self.parameters[parameter]);
        match expression.evaluate_with(|place| of(place).unwrap_or(f64::NAN.into())) {
            Ok(value) => Some(value),
            Err(error) => {
                let named = |(place, reference): (usize, &Reference)| {
                    of(place).map(|quantity| format!("{} = {}", reference.name, quantity.value))
                };
                let mut names: Vec<String> = expression.references().iter().enumerate().filter_map(named).collect();
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

    /// Names that an expression "= …" refers to; none in any other text.
    fn names_in(&mut self, text: &str) -> Vec<String> {
        let Some(formula) = text.trim().strip_prefix('=') else { return Vec::new() };
        let Ok(parsed) = self.parsed(formula) else { return Vec::new() };
        parsed.expression.references().iter().map(|reference| reference.name.clone()).collect()
    }
}
