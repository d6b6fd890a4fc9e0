//! Expressions such as "L * cos(beta)": + − * / ^, parentheses, functions, angles in degrees.
//!
//! An expression is compiled to a list of operations on a stack, so that no text, however long, nests calls.

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

const DEPTH_LIMIT: usize = 100;

impl Expression {
    /// Compiles a text, without the leading `=`.
    ///
    /// # Errors
    /// What is not understood, with its place.
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        let tokens = tokenize(text)?;
        let mut parser =
            Parser { tokens, at: 0, end: text.len(), depth: 0, out: Self { operations: vec![], names: vec![] } };
        parser.sum()?;
        match parser.peek() {
            None => Ok(parser.out),
            Some(token) => Err(ExpressionError {
                message: format!("'{}' is not expected here", &text[token.place.clone()]),
                place: token.place.clone(),
            }),
        }
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

#[derive(Clone, Debug)]
struct Token {
    kind: TokenKind,
    place: Range<usize>,
}

#[derive(Clone, Debug, PartialEq)]
enum TokenKind {
    Number(f64),
    Word(String),
    Sign(char),
}

fn tokenize(text: &str) -> Result<Vec<Token>, ExpressionError> {
    let mut tokens = Vec::new();
    let mut rest = text.char_indices().peekable();
    while let Some(&(start, c)) = rest.peek() {
        let error = |message: String, end: usize| Err(ExpressionError { message, place: start..end });
        if c.is_whitespace() {
            rest.next();
            continue;
        }
        let kind = if c.is_ascii_digit() || c == '.' {
            let length = number_length(&text[start..]);
            let Ok(value) = text[start..start + length].parse() else {
                return error(
                    format!("'{}' is not a number", &text[start..start + length.max(1)]),
                    start + length.max(1),
                );
            };
            while rest.next_if(|(at, _)| *at < start + length).is_some() {}
            TokenKind::Number(value)
        } else if c.is_alphabetic() || c == '_' {
            let mut word = String::new();
            while let Some((_, c)) = rest.next_if(|(_, c)| c.is_alphanumeric() || *c == '_') {
                word.push(c);
            }
            TokenKind::Word(word)
        } else if c == '\'' || c == '"' {
            rest.next();
            let mut word = String::new();
            loop {
                match rest.next() {
                    Some((_, end)) if end == c => break,
                    Some((_, letter)) => word.push(letter),
                    None => return error("this quote is not closed".to_owned(), text.len()),
                }
            }
            TokenKind::Word(word)
        } else {
            rest.next();
            match c {
                '−' | '–' => TokenKind::Sign('-'),
                '·' | '×' => TokenKind::Sign('*'),
                '+' | '-' | '*' | '/' | '^' | '(' | ')' | ',' | '@' => TokenKind::Sign(c),
                _ => return error(format!("'{c}' is not expected here"), start + c.len_utf8()),
            }
        };
        let end = rest.peek().map_or(text.len(), |(at, _)| *at);
        tokens.push(Token { kind, place: start..end });
    }
    Ok(tokens)
}

fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |mut at: usize| {
        while bytes.get(at).is_some_and(u8::is_ascii_digit) {
            at += 1;
        }
        at
    };
    let mut end = digits(0);
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = end + 1 + usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        if digits(sign) > sign {
            end = digits(sign);
        }
    }
    end
}

struct Parser {
    tokens: Vec<Token>,
    at: usize,
    end: usize,
    depth: usize,
    out: Expression,
}

impl Parser {
    fn peek(&self) -> Option<&Token> {
        self.tokens.get(self.at)
    }

    fn take_sign(&mut self, signs: &[char]) -> Option<(char, Range<usize>)> {
        let token = self.peek()?;
        let TokenKind::Sign(sign) = token.kind else { return None };
        let found = signs.contains(&sign).then(|| (sign, token.place.clone()));
        self.at += usize::from(found.is_some());
        found
    }

    fn start(&self) -> usize {
        self.peek().map_or(self.end, |token| token.place.start)
    }

    fn push(&mut self, operation: Operation, start: usize) {
        let end = self.tokens.get(self.at.saturating_sub(1)).map_or(self.end, |token| token.place.end);
        self.out.operations.push((operation, start..end));
    }

    fn sum(&mut self) -> Result<(), ExpressionError> {
        let start = self.start();
        self.product()?;
        while let Some((sign, _)) = self.take_sign(&['+', '-']) {
            self.product()?;
            self.push(if sign == '+' { Operation::Add } else { Operation::Subtract }, start);
        }
        Ok(())
    }

    fn product(&mut self) -> Result<(), ExpressionError> {
        let start = self.start();
        self.signed()?;
        while let Some((sign, _)) = self.take_sign(&['*', '/']) {
            self.signed()?;
            self.push(if sign == '*' { Operation::Multiply } else { Operation::Divide }, start);
        }
        Ok(())
    }

    /// A sign binds weaker than a power: −2^2 = −4.
    fn signed(&mut self) -> Result<(), ExpressionError> {
        let start = self.start();
        match self.take_sign(&['+', '-']) {
            None => self.power(),
            Some((sign, place)) => {
                self.deeper(&place)?;
                self.signed()?;
                self.depth -= 1;
                if sign == '-' {
                    self.push(Operation::Negate, start);
                }
                Ok(())
            }
        }
    }

    fn power(&mut self) -> Result<(), ExpressionError> {
        let start = self.start();
        self.atom()?;
        if let Some((_, place)) = self.take_sign(&['^']) {
            self.deeper(&place)?;
            self.signed()?;
            self.depth -= 1;
            self.push(Operation::Power, start);
        }
        Ok(())
    }

    fn atom(&mut self) -> Result<(), ExpressionError> {
        let Some(token) = self.peek().cloned() else {
            return Err(ExpressionError {
                message: "the expression is not complete".to_owned(),
                place: self.end..self.end,
            });
        };
        self.at += 1;
        let start = token.place.start;
        match token.kind {
            TokenKind::Number(value) => self.push(Operation::Number(value), start),
            TokenKind::Sign('(') => {
                self.deeper(&token.place)?;
                self.sum()?;
                self.close(&token.place)?;
                self.depth -= 1;
            }
            TokenKind::Sign(sign) => {
                return Err(ExpressionError { message: format!("'{sign}' is not expected here"), place: token.place });
            }
            TokenKind::Word(word) => {
                if self.take_sign(&['(']).is_some() {
                    self.call(&word, &token.place)?;
                } else if word == "pi" {
                    self.push(Operation::Number(std::f64::consts::PI), start);
                } else {
                    self.reference(word, token.place)?;
                }
            }
        }
        Ok(())
    }

    fn call(&mut self, word: &str, place: &Range<usize>) -> Result<(), ExpressionError> {
        let error = |message: String| Err(ExpressionError { message, place: place.clone() });
        let Some((_, function)) = FUNCTIONS.iter().find(|(name, _)| *name == word) else {
            let names: Vec<&str> = FUNCTIONS.iter().map(|(name, _)| *name).collect();
            return error(format!("unknown function '{word}'; there are {}", names.join(" ")));
        };
        self.deeper(place)?;
        let mut arguments = 1;
        self.sum()?;
        while self.take_sign(&[',']).is_some() {
            self.sum()?;
            arguments += 1;
        }
        self.close(place)?;
        self.depth -= 1;
        let expected = match function {
            Function::Min | Function::Max => arguments,
            Function::Atan2 => 2,
            _ => 1,
        };
        if arguments != expected {
            return error(format!("{word} takes {expected} argument(s), not {arguments}"));
        }
        self.push(Operation::Call(*function, arguments), place.start);
        Ok(())
    }

    fn reference(&mut self, name: String, mut place: Range<usize>) -> Result<(), ExpressionError> {
        let mut step = None;
        if let Some((_, at)) = self.take_sign(&['@']) {
            match self.peek().cloned() {
                Some(Token { kind: TokenKind::Word(word), place: of_word }) => {
                    self.at += 1;
                    place.end = of_word.end;
                    step = Some(word);
                }
                _ => {
                    return Err(ExpressionError {
                        message: "after '@' the name of a step is expected".to_owned(),
                        place: at,
                    });
                }
            }
        }
        let start = place.start;
        self.out.names.push(Reference { name, step, place });
        self.push(Operation::Name(self.out.names.len() - 1), start);
        Ok(())
    }

    fn close(&mut self, open: &Range<usize>) -> Result<(), ExpressionError> {
        if self.take_sign(&[')']).is_some() {
            return Ok(());
        }
        Err(ExpressionError { message: "this parenthesis is not closed".to_owned(), place: open.clone() })
    }

    fn deeper(&mut self, place: &Range<usize>) -> Result<(), ExpressionError> {
        self.depth += 1;
        if self.depth > DEPTH_LIMIT {
            let message = "the expression is nested too deeply".to_owned();
            return Err(ExpressionError { message, place: place.clone() });
        }
        Ok(())
    }
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
