//! Derivatives of expressions by what they refer to.

use super::{Expression, Function, Operation, sine};

/// A number, and what it changes by with one of the references.
#[derive(Clone, Copy, Debug)]
struct Dual {
    value: f64,
    rate: f64,
}

impl From<f64> for Dual {
    fn from(value: f64) -> Self {
        Self { value, rate: 0.0 }
    }
}

impl Expression {
    /// The derivatives by all references, in order, with their values. Angles are degrees. At a corner, such as that of `abs(x)` where x
    /// vanishes, they are those of one side; not a number where there is none.
    pub fn partials(&self, values: &[f64]) -> Vec<f64> {
        let mut stack = Vec::with_capacity(self.operations.len());
        (0..self.names.len()).map(|name| self.partial(values, name, &mut stack)).collect()
    }

    /// The derivative by one of them.
    fn partial(&self, values: &[f64], by: usize, stack: &mut Vec<Dual>) -> f64 {
        stack.clear();
        for &(operation, _) in &self.operations {
            let mut pop = || stack.pop().unwrap_or(Dual::from(f64::NAN));
            let result = match operation {
                Operation::Number(value) => value.into(),
                Operation::Name(name) => {
                    let value = values.get(name).copied().unwrap_or(f64::NAN);
                    Dual { value, rate: if name == by { 1.0 } else { 0.0 } }
                }
                Operation::Negate => {
                    let Dual { value, rate } = pop();
                    Dual { value: -value, rate: -rate }
                }
                Operation::Call(function, count) => {
                    let first = stack.len().saturating_sub(count);
                    let result = call(function, &stack[first..]);
                    stack.truncate(first);
                    result
                }
                Operation::Add | Operation::Subtract | Operation::Multiply | Operation::Divide | Operation::Power => {
                    let (right, left) = (pop(), pop());
                    of_two(operation, left, right)
                }
            };
            stack.push(result);
        }
        stack.pop().map_or(f64::NAN, |result| result.rate)
    }
}

/// A factor times a rate: nothing where that is nothing, whatever the factor.
fn times(factor: f64, rate: f64) -> f64 {
    if rate == 0.0 { 0.0 } else { factor * rate }
}

fn of_two(operation: Operation, a: Dual, b: Dual) -> Dual {
    let (value, rate) = match operation {
        Operation::Add => (a.value + b.value, a.rate + b.rate),
        Operation::Subtract => (a.value - b.value, a.rate - b.rate),
        Operation::Multiply => (a.value * b.value, times(b.value, a.rate) + times(a.value, b.rate)),
        Operation::Divide => {
            let value = a.value / b.value;
            (value, times(1.0 / b.value, a.rate) - times(value / b.value, b.rate))
        }
        _ => {
            let value = a.value.powf(b.value);
            let by_base = if b.value == 0.0 { 0.0 } else { b.value * a.value.powf(b.value - 1.0) };
            (value, times(by_base, a.rate) + times(value * a.value.ln(), b.rate))
        }
    };
    Dual { value, rate }
}

fn call(function: Function, arguments: &[Dual]) -> Dual {
    let Dual { value: x, rate } = arguments.first().copied().unwrap_or(f64::NAN.into());
    // The first of those that are chosen from.
    let chosen = |is_better: fn(f64, f64) -> bool| {
        let best =
            arguments.iter().copied().reduce(|best, next| if is_better(next.value, best.value) { next } else { best });
        best.unwrap_or(f64::NAN.into())
    };
    let degree = 1f64.to_radians();
    let (value, slope) = match function {
        Function::Min => return chosen(|a, b| a < b),
        Function::Max => return chosen(|a, b| a > b),
        Function::Atan2 => {
            let over = arguments.get(1).copied().unwrap_or(f64::NAN.into());
            let square = x * x + over.value * over.value;
            let rate = times(over.value / square, rate) - times(x / square, over.rate);
            return Dual { value: x.atan2(over.value).to_degrees(), rate: rate.to_degrees() };
        }
        Function::Abs => (x.abs(), x.signum()),
        Function::Sqrt => (x.sqrt(), 0.5 / x.sqrt()),
        Function::Exp => (x.exp(), x.exp()),
        Function::Ln => (x.ln(), 1.0 / x),
        Function::Sin => (sine(x), degree * sine(x + 90.0)),
        Function::Cos => (sine(x + 90.0), -degree * sine(x)),
        Function::Tan => {
            let tangent = sine(x) / sine(x + 90.0);
            (tangent, degree * (1.0 + tangent * tangent))
        }
        Function::Asin => (x.asin().to_degrees(), (1.0 / (1.0 - x * x).sqrt()).to_degrees()),
        Function::Acos => (x.acos().to_degrees(), -(1.0 / (1.0 - x * x).sqrt()).to_degrees()),
        Function::Atan => (x.atan().to_degrees(), (1.0 / (1.0 + x * x)).to_degrees()),
    };
    Dual { value, rate: times(slope, rate) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The derivative of a text by a name, wherever it stands, and the value of the text.
    fn by_name(text: &str, values: &[(&str, f64)], name: &str) -> (f64, f64) {
        let expression = Expression::parse(text).unwrap();
        let value = |name: &str| values.iter().find(|(known, _)| *known == name).unwrap().1;
        let operands: Vec<f64> = expression.references().iter().map(|reference| value(&reference.name)).collect();
        let partials = expression.partials(&operands);
        let own = expression.references().iter().zip(partials).filter(|(reference, _)| reference.name == name);
        (own.map(|(_, partial)| partial).sum(), expression.value(&operands))
    }

    #[test]
    fn partials_are_what_differences_say() {
        let values = [("a", 0.3), ("b", -0.7), ("c", 1.9)];
        for text in [
            "a + 2 * b - c / 3",
            "a * b * c - -a",
            "(a - b) / (b * c)",
            "c ^ 3 + c ^ a + 2 ^ b + b ^ 2",
            "sqrt(c) + abs(b) * abs(c) + exp(a * b) - ln(c)",
            "min(a, b, c) + 2 * max(a, b, c)",
            "sin(100 * a) + cos(c * 40) * tan(30 * b)",
            "asin(a) + acos(b) / atan(c)",
            "atan2(a, b) - atan2(c, a * b)",
        ] {
            for (place, (name, _)) in values.iter().enumerate() {
                let (partial, _) = by_name(text, &values, name);
                let at = |by: f64| {
                    let mut moved = values;
                    moved[place].1 += by;
                    by_name(text, &moved, name).1
                };
                let by = 1e-4;
                let near = (at(by) - at(-by)) / (2.0 * by);
                let far = (at(2.0 * by) - at(-2.0 * by)) / (4.0 * by);
                let difference = near + (near - far) / 3.0;
                let miss = (partial - difference).abs();
                assert!(miss < 1e-8 * partial.abs().max(1.0), "{text}, {name}: {partial} {difference}");
            }
        }
    }

    #[test]
    fn what_a_reference_does_not_move_has_no_rate() {
        let partials = |text: &str, values: &[f64]| Expression::parse(text).unwrap().partials(values);
        assert_eq!(partials("sqrt(a) + b", &[0.0, 1.0]), [f64::INFINITY, 1.0]);
        assert_eq!(partials("(a - 3) ^ 2 + a ^ 0", &[1.0, 1.0]), [-4.0, 0.0]);
        assert_eq!(partials("max(a, b)", &[2.0, 1.0]), [1.0, 0.0]);
    }
}
