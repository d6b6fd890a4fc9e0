//! Expressions such as "L * cos(beta)": + − * / ^, parentheses, functions, angles in degrees.
//!
//! An expression is compiled to a list of operations on a stack, so that no text, however long, nests calls.

mod parse;
mod partials;

use std::ops::Range;

use crate::unit::{self, Exponents, Kind};

/// A compiled expression.
#[derive(Clone, Debug)]
pub struct Expression {
    /// Operations in postfix order, each with the bytes of the text it came from.
    operations: Vec<(Operation, Range<usize>)>,
    /// What the expression refers to.
    names: Vec<Reference>,
}

/// A name in an expression, or a name after a step: `stroke@inflate`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reference {
    /// Of a parameter, or of another probe.
    pub name: String,
    /// Name of the step behind the @.
    pub step: Option<String>,
    /// Bytes of the text.
    pub place: Range<usize>,
}

#[derive(Clone, Copy, Debug)]
enum Operation {
    Number(f64),
    Name(usize),
    Negate,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Call(Function, usize),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Function {
    Sqrt,
    Abs,
    Min,
    Max,
    Exp,
    Ln,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Atan2,
}

const FUNCTIONS: [(&str, Function); 13] = [
    ("sqrt", Function::Sqrt),
    ("abs", Function::Abs),
    ("min", Function::Min),
    ("max", Function::Max),
    ("exp", Function::Exp),
    ("ln", Function::Ln),
    ("sin", Function::Sin),
    ("cos", Function::Cos),
    ("tan", Function::Tan),
    ("asin", Function::Asin),
    ("acos", Function::Acos),
    ("atan", Function::Atan),
    ("atan2", Function::Atan2),
];

/// What is wrong with an expression, and where in its text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExpressionError {
    /// What is wrong, without a full stop.
    pub message: String,
    /// Bytes of the expression's text.
    pub place: Range<usize>,
}

/// A number in the units of the file (angles in degrees), and what is known of what it measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// In the units of the file, angles in degrees.
    pub value: f64,
    /// `None` for a bare number, which may be anything.
    pub measure: Option<Measure>,
}

/// What a number measures, as far as units say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measure {
    /// Of length, mass, time and angle.
    pub exponents: Exponents,
    /// How sure these are.
    pub certainty: Certainty,
    /// A bare number was added: whose unit it was meant in is not said.
    pub is_mixed: bool,
}

/// How far the units of an expression tell what it measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Certainty {
    /// A bare parameter had a part in a product: it may have a unit of its own.
    Guessed,
    /// A bare number of the expression had: that is a mere factor, most likely.
    Likely,
    /// Known.
    Certain,
}

impl Measure {
    /// What a unit says.
    pub fn of(exponents: Exponents) -> Self {
        Self { exponents, certainty: Certainty::Certain, is_mixed: false }
    }
}

impl From<f64> for Quantity {
    fn from(value: f64) -> Self {
        Self { value, measure: None }
    }
}

impl Quantity {
    /// A number with a unit.
    pub fn with(value: f64, exponents: Exponents) -> Self {
        Self { value, measure: Some(Measure::of(exponents)) }
    }

    /// Whether it is a pressure, which keeps its meaning when it reaches a muscle with another unit.
    pub fn is_pressure(&self) -> bool {
        self.measure.is_some_and(|measure| Kind::Stress.fits(measure.exponents))
    }
}

/// An operand of an expression: numbers written there are no parameters without a unit.
#[derive(Clone, Copy, Debug)]
struct Operand {
    quantity: Quantity,
    is_literal: bool,
}

/// Operations of a short expression.
const SHORT: usize = 16;

/// Operands that wait for their operation.
struct Stack<'a> {
    room: &'a mut [Operand],
    height: usize,
}

impl Stack<'_> {
    fn push(&mut self, operand: Operand) {
        self.room[self.height] = operand;
        self.height += 1;
    }

    fn pop(&mut self) -> Operand {
        self.take(1).first().copied().unwrap_or(f64::NAN.into())
    }

    /// The last ones, or as many as there are.
    fn take(&mut self, count: usize) -> &[Operand] {
        let end = self.height;
        self.height = end.saturating_sub(count);
        &self.room[self.height..end]
    }
}

impl From<f64> for Operand {
    fn from(value: f64) -> Self {
        Self { quantity: value.into(), is_literal: true }
    }
}

impl Expression {
    /// Compiles a text, without the leading `=`.
    ///
    /// # Errors
    /// What is not understood, with its place.
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        parse::parse(text)
    }

    /// Everything that the expression refers to, `pi` left out.
    pub fn references(&self) -> &[Reference] {
        &self.names
    }

    /// Value, with `values` for the references, in order.
    ///
    /// # Errors
    /// The first operation without finite result.
    pub fn evaluate(&self, values: &[Quantity]) -> Result<Quantity, ExpressionError> {
        self.evaluate_with(|index| values.get(index).copied().unwrap_or(Quantity::from(f64::NAN)))
    }

    /// The same, with the value of a reference by its place.
    ///
    /// # Errors
    /// As [`Expression::evaluate`].
    pub fn evaluate_with(&self, values: impl Fn(usize) -> Quantity) -> Result<Quantity, ExpressionError> {
        // Most expressions are short: they need no memory of their own.
        let (mut room, mut more) = ([Operand::from(f64::NAN); SHORT], Vec::new());
        let room = if self.operations.len() <= SHORT {
            room.as_mut_slice()
        } else {
            more.resize(self.operations.len(), Operand::from(f64::NAN));
            more.as_mut_slice()
        };
        let mut stack = Stack { room, height: 0 };
        for (operation, place) in &self.operations {
            let fail = |message: String| ExpressionError { message, place: place.clone() };
            let result = apply(*operation, &values, &mut stack).map_err(fail)?;
            if !result.quantity.value.is_finite() {
                let message = match operation {
                    Operation::Divide => "division by zero, or a result too large".to_owned(),
                    Operation::Call(function, _) => format!("{} has no finite value here", function.name()),
                    _ => "the result is not a finite number".to_owned(),
                };
                return Err(fail(message));
            }
            stack.push(result);
        }
        Ok(stack.pop().quantity)
    }

    /// Value, or not a number where there is no finite one.
    pub fn value(&self, values: &[f64]) -> f64 {
        let of = |index: usize| Quantity::from(values.get(index).copied().unwrap_or(f64::NAN));
        self.evaluate_with(of).map_or(f64::NAN, |quantity| quantity.value)
    }
}

impl Function {
    fn name(self) -> &'static str {
        FUNCTIONS.iter().find(|(_, known)| *known == self).map_or("", |known| known.0)
    }
}

/// The result of an operation; a sentence where its operands measure different things.
fn apply(operation: Operation, values: &impl Fn(usize) -> Quantity, stack: &mut Stack<'_>) -> Result<Operand, String> {
    Ok(match operation {
        Operation::Number(value) => value.into(),
        Operation::Name(index) => Operand { quantity: values(index), is_literal: false },
        Operation::Negate => {
            let mut operand = stack.pop();
            operand.quantity.value = -operand.quantity.value;
            operand
        }
        Operation::Call(function, arguments) => call(function, stack.take(arguments))?,
        _ => {
            let (right, left) = (stack.pop(), stack.pop());
            let (a, b) = (left.quantity.value, right.quantity.value);
            let (value, measure) = match operation {
                Operation::Add => (a + b, common(&[left, right], "added to")?),
                Operation::Subtract => (a - b, common(&[right, left], "subtracted from")?),
                Operation::Multiply => (a * b, product(left, right, 1)),
                Operation::Divide => (a / b, product(left, right, -1)),
                _ => (a.powf(b), power(left, right)),
            };
            Operand { quantity: Quantity { value, measure }, is_literal: left.is_literal && right.is_literal }
        }
    })
}

/// What a sum or the larger of some operands measures: all of them the same, bare numbers aside.
fn common(operands: &[Operand], verb: &str) -> Result<Option<Measure>, String> {
    let mut found: Option<Measure> = None;
    for measure in operands.iter().filter_map(|operand| operand.quantity.measure) {
        found = Some(match found {
            None => measure,
            Some(before) => {
                let certain = before.certainty.min(measure.certainty);
                if before.exponents != measure.exponents && certain > Certainty::Guessed {
                    let [one, other] = [before, measure].map(|each| unit::describe(each.exponents));
                    return Err(format!("{one} is {verb} {other}"));
                }
                Measure {
                    certainty: certain,
                    is_mixed: before.is_mixed || measure.is_mixed,
                    ..if before.certainty >= measure.certainty { before } else { measure }
                }
            }
        });
    }
    let bare = operands.iter().any(|operand| operand.quantity.measure.is_none() && operand.quantity.value != 0.0);
    Ok(found.map(|found| Measure { is_mixed: found.is_mixed || bare, ..found }))
}

/// What a product (sign 1) or quotient (-1) measures.
fn product(left: Operand, right: Operand, sign: i32) -> Option<Measure> {
    let angle = Kind::Angle.exponents();
    let (measure, bare) = match (left.quantity.measure, right.quantity.measure) {
        (None, None) => return None,
        (Some(a), Some(b)) => {
            let exponents: Exponents = std::array::from_fn(|k| a.exponents[k] + sign * b.exponents[k]);
            // Degrees are no radians: what becomes of them in a product is not known.
            if exponents == [0; 4] || a.exponents == angle || b.exponents == angle {
                return None;
            }
            let certainty = a.certainty.min(b.certainty);
            return Some(Measure { exponents, certainty, is_mixed: a.is_mixed || b.is_mixed });
        }
        (Some(measure), None) => (measure, right),
        (None, Some(b)) => (Measure { exponents: b.exponents.map(|exponent| sign * exponent), ..b }, left),
    };
    if measure.exponents == angle {
        return None;
    }
    let certainty = if bare.is_literal { Certainty::Likely } else { Certainty::Guessed };
    Some(Measure { certainty: measure.certainty.min(certainty), ..measure })
}

/// What a power measures: known for whole numbers written as such.
fn power(base: Operand, exponent: Operand) -> Option<Measure> {
    let measure = base.quantity.measure?;
    let times = exponent.quantity.value;
    if !(exponent.is_literal && times.fract() == 0.0 && times.abs() <= 6.0) {
        return None;
    }
    let exponents = measure.exponents.map(|e| e * times as i32);
    (exponents != [0; 4]).then_some(Measure { exponents, ..measure })
}

fn call(function: Function, arguments: &[Operand]) -> Result<Operand, String> {
    let x = arguments.first().map_or(f64::NAN, |argument| argument.quantity.value);
    let all = arguments.iter().map(|argument| argument.quantity.value);
    let is_literal = arguments.iter().all(|argument| argument.is_literal);
    let kept = |value: f64| -> Result<Operand, String> {
        let measure = common(arguments, "compared with")?;
        Ok(Operand { quantity: Quantity { value, measure }, is_literal })
    };
    let value = match function {
        Function::Abs => return kept(x.abs()),
        Function::Min => return kept(all.fold(f64::INFINITY, f64::min)),
        Function::Max => return kept(all.fold(f64::NEG_INFINITY, f64::max)),
        Function::Sqrt => {
            let halved = arguments.first().and_then(|argument| argument.quantity.measure).and_then(halved);
            return Ok(Operand { quantity: Quantity { value: x.sqrt(), measure: halved }, is_literal });
        }
        Function::Exp => x.exp(),
        Function::Ln => x.ln(),
        Function::Sin => sine(x),
        Function::Cos => sine(x + 90.0),
        Function::Tan => sine(x) / sine(x + 90.0),
        Function::Asin => x.asin().to_degrees(),
        Function::Acos => x.acos().to_degrees(),
        Function::Atan => x.atan().to_degrees(),
        Function::Atan2 => {
            common(arguments, "compared with")?;
            x.atan2(arguments.get(1).map_or(f64::NAN, |argument| argument.quantity.value)).to_degrees()
        }
    };
    check_argument(function, arguments)?;
    Ok(Operand { quantity: value.into(), is_literal })
}

/// Sines are those of angles, other functions those of numbers.
fn check_argument(function: Function, arguments: &[Operand]) -> Result<(), String> {
    let takes_angle = matches!(function, Function::Sin | Function::Cos | Function::Tan);
    let Some(measure) = arguments.first().and_then(|argument| argument.quantity.measure) else { return Ok(()) };
    let fits = measure.certainty < Certainty::Certain
        || function == Function::Atan2
        || measure.exponents == [0; 4]
        || takes_angle && measure.exponents == Kind::Angle.exponents();
    if fits {
        return Ok(());
    }
    let wanted = if takes_angle { "an angle" } else { "a number without unit" };
    Err(format!("{} takes {wanted}, not {}", function.name(), unit::describe(measure.exponents)))
}

fn halved(measure: Measure) -> Option<Measure> {
    let even = measure.exponents.iter().all(|exponent| exponent % 2 == 0);
    even.then(|| Measure { exponents: measure.exponents.map(|exponent| exponent / 2), ..measure })
}

/// Sine of an angle in degrees, exact at whole multiples of 30 where its value is a short decimal: a node at
/// "= L * cos(90)" shall lie on its axis.
fn sine(degrees: f64) -> f64 {
    // Where there is no whole turn, none has to be taken off.
    let turned = if (0.0..360.0).contains(&degrees) { degrees } else { degrees.rem_euclid(360.0) };
    let (folded, sign) = if turned >= 180.0 { (turned - 180.0, -1.0) } else { (turned, 1.0) };
    let folded = if folded > 90.0 { 180.0 - folded } else { folded };
    let value = if folded == 0.0 {
        0.0
    } else if folded == 30.0 {
        0.5
    } else if folded == 90.0 {
        1.0
    } else {
        folded.to_radians().sin()
    };
    sign * value
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> f64 {
        Expression::parse(text).unwrap().evaluate(&[]).unwrap().value
    }

    #[test]
    fn arithmetic_follows_the_usual_rules() {
        for (text, expected) in [
            ("1 + 2 * 3", 7.0),
            ("-2^2", -4.0),
            ("2^-1", 0.5),
            ("2^3^2", 512.0),
            ("(1 + 2) * -3", -9.0),
            ("8 / 4 / 2", 1.0),
            ("1 − 2 · 3", -5.0),
            ("sqrt(9) + abs(-1) + min(3, 2, 5) + max(1)", 7.0),
            ("sin(30) + cos(60) + tan(45)", 2.0),
            ("cos(90) + sin(180) + sin(-360)", 0.0),
            ("asin(1) + acos(0) + atan(1)", 225.0),
            ("atan2(1, -1)", 135.0),
            ("ln(exp(2))", 2.0),
            ("1.5e-3 * 1e3", 1.5),
            ("pi", std::f64::consts::PI),
        ] {
            assert!((value(text) - expected).abs() < 1e-14, "{text} = {}", value(text));
        }
    }

    #[test]
    fn results_without_value_are_errors_with_a_place() {
        for (text, place) in
            [("1 + 2/(1-1)", 4..11), ("ln(0)", 0..5), ("sqrt(-1)", 0..8), ("1e300*1e300", 0..11), ("tan(90)", 0..7)]
        {
            let error = Expression::parse(text).unwrap().evaluate(&[]).unwrap_err();
            assert_eq!(error.place, place, "{text}: {}", error.message);
        }
    }

    #[test]
    fn malformed_texts_are_errors() {
        for text in [
            "",
            "1 +",
            "(1",
            "1)",
            "foo(1)",
            "sin(1, 2)",
            "atan2(1)",
            "1 2",
            "a@",
            "a@3",
            "'a",
            "..",
            "1 $ 2",
            "*2",
            "sin()",
            "é@",
        ] {
            assert!(Expression::parse(text).is_err(), "{text}");
        }
        for open in ["(", "-", "2^", "sin("] {
            assert!(Expression::parse(&open.repeat(100_000)).is_err());
        }
        assert_eq!(value(&vec!["1"; 100_000].join("+")), 100_000.0);
    }

    #[test]
    fn names_may_refer_to_steps() {
        let expression = Expression::parse("2 * stroke@inflate - holding@'push back'").unwrap();
        let names: Vec<_> = expression.references().iter().map(|r| (r.name.as_str(), r.step.as_deref())).collect();
        assert_eq!(names, [("stroke", Some("inflate")), ("holding", Some("push back"))]);
        assert_eq!(expression.value(&[3.0, 1.0]), 5.0);
    }

    #[test]
    fn pressures_stay_pressures() {
        let pressure = Quantity::with(2.0, Kind::Stress.exponents());
        let is = |text: &str| Expression::parse(text).unwrap().evaluate(&[pressure; 2]).unwrap().is_pressure();
        assert!(is("p") && is("2 * p") && is("-p / 3 + p") && is("max(p, 1)") && is("sqrt(p * q)"));
        assert!(!is("p / q") && !is("1 / p") && !is("p * q"));
    }

    #[test]
    fn what_an_expression_measures_is_known_as_far_as_units_say() {
        let [length, force] = [Kind::Length, Kind::Force].map(|kind| Quantity::with(3.0, kind.exponents()));
        let of = |text: &str| {
            let expression = Expression::parse(text).unwrap();
            let value = |name: &Reference| match name.name.as_str() {
                "l" => length,
                "f" => force,
                _ => Quantity::from(2.0),
            };
            let values: Vec<Quantity> = expression.references().iter().map(value).collect();
            expression.evaluate(&values).map(|all| all.measure)
        };
        let known = |text: &str, kind: Kind, certainty: Certainty| {
            let measure = of(text).unwrap().unwrap();
            assert_eq!((measure.exponents, measure.certainty), (kind.exponents(), certainty), "{text}");
        };
        known("f", Kind::Force, Certainty::Certain);
        known("-f + f", Kind::Force, Certainty::Certain);
        known("f / l * l", Kind::Force, Certainty::Certain);
        known("f * l", Kind::Moment, Certainty::Certain);
        known("l / 2", Kind::Length, Certainty::Likely);
        known("bare * l", Kind::Length, Certainty::Guessed);
        known("(l^2)^2 / l^3", Kind::Length, Certainty::Certain);
        known("sqrt(l * l)", Kind::Length, Certainty::Certain);
        assert_eq!(
            [of("l / l"), of("bare"), of("cos(bare)"), of("l ^ bare")],
            [Ok(None), Ok(None), Ok(None), Ok(None)]
        );
        assert!(of("l + f").unwrap_err().message.contains("a length"));
        assert!(of("cos(l)").unwrap_err().message.contains("takes an angle"));
        assert!(of("exp(f)").unwrap_err().message.contains("takes a number without unit"));
        assert!(of("max(l, 2)").unwrap().is_some_and(|measure| measure.is_mixed));
        assert!(of("max(l, 0)").unwrap().is_some_and(|measure| !measure.is_mixed));
    }
}
