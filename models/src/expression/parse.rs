//! From the text of an expression to its operations: tokens, then recursive descent.

use std::ops::Range;

use super::{Expression, ExpressionError, FUNCTIONS, Function, Operation, Reference};

const DEPTH_LIMIT: usize = 100;

/// Compiles a text.
pub(crate) fn parse(text: &str) -> Result<Expression, ExpressionError> {
    let tokens = tokenize(text)?;
    let out = Expression { operations: Vec::new(), names: Vec::new() };
    let mut parser = Parser { tokens, at: 0, end: text.len(), depth: 0, out };
    parser.sum()?;
    match parser.peek() {
        None => Ok(parser.out),
        Some(token) => Err(ExpressionError {
            message: format!("'{}' is not expected here", &text[token.place.clone()]),
            place: token.place.clone(),
        }),
    }
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
