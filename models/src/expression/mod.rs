//! Expressions such as "L * cos(beta)": + − * / ^, parentheses, functions, angles in degrees.
//!
//! An expression is compiled to a list of operations on a stack, so that no text, however long, nests calls.

mod parse;

use std::ops::Range;

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
    pub name: String,
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
    pub message: String,
    pub place: Range<usize>,
}

/// A number, and whether it is a pressure: that keeps its meaning when it reaches a muscle with another unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    pub value: f64,
    pub is_pressure: bool,
}

impl From<f64> for Quantity {
    fn from(value: f64) -> Self {
        Self { value, is_pressure: false }
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
        let mut stack: Vec<Quantity> = Vec::with_capacity(8);
        for (operation, place) in &self.operations {
            let result = apply(*operation, values, &mut stack);
            if !result.value.is_finite() {
                let message = match operation {
                    Operation::Divide => "division by zero, or a result too large".to_owned(),
                    Operation::Call(function, _) => {
                        let name = FUNCTIONS.iter().find(|(_, known)| known == function).map_or("", |known| known.0);
                        format!("{name} has no finite value here")
                    }
                    _ => "the result is not a finite number".to_owned(),
                };
                return Err(ExpressionError { message, place: place.clone() });
            }
            stack.push(result);
        }
        Ok(stack.pop().unwrap_or(Quantity::from(f64::NAN)))
    }

    /// Value, or not a number where there is no finite one.
    pub fn value(&self, values: &[f64]) -> f64 {
        let values: Vec<Quantity> = values.iter().map(|&value| value.into()).collect();
        self.evaluate(&values).map_or(f64::NAN, |quantity| quantity.value)
    }
}

fn apply(operation: Operation, values: &[Quantity], stack: &mut Vec<Quantity>) -> Quantity {
    let mut pop = || stack.pop().unwrap_or(Quantity::from(f64::NAN));
    match operation {
        Operation::Number(value) => value.into(),
        Operation::Name(index) => values.get(index).copied().unwrap_or(Quantity::from(f64::NAN)),
        Operation::Negate => {
            let operand = pop();
            Quantity { value: -operand.value, ..operand }
        }
        Operation::Call(function, arguments) => {
            let arguments = stack.split_off(stack.len().saturating_sub(arguments));
            call(function, &arguments)
        }
        _ => {
            let (right, left) = (pop(), pop());
            let (a, b) = (left.value, right.value);
            let (p, q) = (left.is_pressure, right.is_pressure);
            let (value, is_pressure) = match operation {
                Operation::Add => (a + b, p || q),
                Operation::Subtract => (a - b, p || q),
                Operation::Multiply => (a * b, p != q),
                Operation::Divide => (a / b, p && !q),
                _ => (a.powf(b), false),
            };
            Quantity { value, is_pressure }
        }
    }
}

fn call(function: Function, arguments: &[Quantity]) -> Quantity {
    let x = arguments.first().map_or(f64::NAN, |argument| argument.value);
    let is_pressure = arguments.iter().any(|argument| argument.is_pressure);
    let all = arguments.iter().map(|argument| argument.value);
    let value = match function {
        Function::Abs => return Quantity { value: x.abs(), is_pressure },
        Function::Min => return Quantity { value: all.fold(f64::INFINITY, f64::min), is_pressure },
        Function::Max => return Quantity { value: all.fold(f64::NEG_INFINITY, f64::max), is_pressure },
        Function::Sqrt => x.sqrt(),
        Function::Exp => x.exp(),
        Function::Ln => x.ln(),
        Function::Sin => sine(x),
        Function::Cos => sine(x + 90.0),
        Function::Tan => sine(x) / sine(x + 90.0),
        Function::Asin => x.asin().to_degrees(),
        Function::Acos => x.acos().to_degrees(),
        Function::Atan => x.atan().to_degrees(),
        Function::Atan2 => x.atan2(arguments.get(1).map_or(f64::NAN, |argument| argument.value)).to_degrees(),
    };
    value.into()
}

/// Sine of an angle in degrees, exact at whole multiples of 30 where its value is a short decimal: a node at
/// "= L * cos(90)" shall lie on its axis.
fn sine(degrees: f64) -> f64 {
    let turned = degrees.rem_euclid(360.0);
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
        let pressure = Quantity { value: 2.0, is_pressure: true };
        let is = |text: &str| Expression::parse(text).unwrap().evaluate(&[pressure; 2]).unwrap().is_pressure;
        assert!(is("p") && is("2 * p") && is("-p / 3 + p") && is("max(p, 1)"));
        let ratio = Expression::parse("p / q").unwrap();
        assert!(!ratio.evaluate(&[pressure, pressure]).unwrap().is_pressure);
    }
}
