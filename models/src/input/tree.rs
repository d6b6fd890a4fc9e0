//! One tree for TOML and JSON, every value with its place.

use std::collections::HashSet;

use jsonc_parser::ast;
use toml::de::{DeTable, DeValue};

use crate::error::{InputError, Span};

/// Levels of nesting that are followed; no network needs ten.
const DEPTH_LIMIT: usize = 60;

/// A value and where it stands.
#[derive(Clone, Debug)]
pub struct Value {
    /// Its place in the file.
    pub span: Span,
    /// What it is.
    pub kind: Kind,
}

/// What a value is.
#[derive(Clone, Debug)]
pub enum Kind {
    /// JSON's null.
    Null,
    /// True or false.
    Bool(bool),
    /// A number.
    Number(f64),
    /// A text.
    String(String),
    /// A list.
    Array(Vec<Value>),
    /// Keys and values in the order of the file.
    Table(Vec<Entry>),
    /// A date or time of TOML, which no key takes.
    Date,
}

/// A key with its value.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The key.
    pub key: String,
    /// Its place in the file.
    pub key_span: Span,
    /// What it has.
    pub value: Value,
}

/// The language of an input file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// TOML.
    Toml,
    /// JSON.
    Json,
}

impl Value {
    /// What the value is, in a user's words.
    pub fn description(&self) -> &'static str {
        match self.kind {
            Kind::Null => "null",
            Kind::Bool(_) => "true or false",
            Kind::Number(_) => "a number",
            Kind::String(_) => "a text",
            Kind::Array(_) => "a list",
            Kind::Table(_) => "a table",
            Kind::Date => "a date",
        }
    }
}

/// Parses a text into a tree.
///
/// # Errors
/// What the language forbids, at its place.
pub fn parse(text: &str, language: Language, file: usize) -> Result<Value, Box<InputError>> {
    match language {
        Language::Toml => parse_toml(text, file),
        Language::Json => parse_json(text, file),
    }
}

fn parse_toml(text: &str, file: usize) -> Result<Value, Box<InputError>> {
    match DeTable::parse(text) {
        Ok(table) => {
            let span = Span { file, start: table.span().start, end: table.span().end };
            from_toml_table(table.into_inner(), span, file, 0)
        }
        Err(error) => {
            let at = error.span().unwrap_or(0..0);
            let message = error.message().lines().next().unwrap_or("not TOML").to_owned();
            let error = InputError::new(format!("this is not TOML: {message}"))
                .at(Span { file, start: at.start, end: at.end })
                .help("texts stand in quotes, lists in [ ], tables in { } on one line or under a [header]");
            Err(Box::new(error))
        }
    }
}

fn too_deep(span: Span) -> Box<InputError> {
    let error = InputError::new(format!("nested more than {DEPTH_LIMIT} levels deep"));
    Box::new(error.at(span).help("no network needs ten levels"))
}

fn from_toml_table(table: DeTable<'_>, span: Span, file: usize, depth: usize) -> Result<Value, Box<InputError>> {
    if depth > DEPTH_LIMIT {
        return Err(too_deep(span));
    }
    let mut entries = Vec::with_capacity(table.len());
    for (key, value) in table {
        let key_span = Span { file, start: key.span().start, end: key.span().end };
        let at = Span { file, start: value.span().start, end: value.span().end };
        let value = from_toml(value.into_inner(), at, file, depth + 1)?;
        entries.push(Entry { key: key.into_inner().into_owned(), key_span, value });
    }
    Ok(Value { span, kind: Kind::Table(entries) })
}

fn from_toml(value: DeValue<'_>, span: Span, file: usize, depth: usize) -> Result<Value, Box<InputError>> {
    if depth > DEPTH_LIMIT {
        return Err(too_deep(span));
    }
    let kind = match value {
        DeValue::String(text) => Kind::String(text.into_owned()),
        DeValue::Integer(integer) => match i128::from_str_radix(integer.as_str(), integer.radix()) {
            #[expect(clippy::cast_precision_loss, reason = "quantities are doubles")]
            Ok(integer) => Kind::Number(integer as f64),
            Err(_) => Kind::Number(f64::INFINITY),
        },
        DeValue::Float(float) => Kind::Number(float.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(flag) => Kind::Bool(flag),
        DeValue::Datetime(_) => Kind::Date,
        DeValue::Array(array) => {
            let mut items = Vec::with_capacity(array.len());
            for item in array {
                let at = Span { file, start: item.span().start, end: item.span().end };
                items.push(from_toml(item.into_inner(), at, file, depth + 1)?);
            }
            Kind::Array(items)
        }
        DeValue::Table(table) => return from_toml_table(table, span, file, depth),
    };
    Ok(Value { span, kind })
}

fn parse_json(text: &str, file: usize) -> Result<Value, Box<InputError>> {
    let strict = jsonc_parser::ParseOptions {
        allow_comments: false,
        allow_loose_object_property_names: false,
        allow_trailing_commas: false,
        allow_missing_commas: false,
        allow_single_quoted_strings: false,
        allow_hexadecimal_numbers: false,
        allow_unary_plus_numbers: false,
        allow_bare_decimal_point_numbers: false,
        allow_non_finite_numbers: false,
        allow_extended_string_escapes: false,
    };
    let not_json = |message: &str, start: usize, end: usize| {
        let error = InputError::new(format!("this is not JSON: {message}")).at(Span { file, start, end });
        Box::new(error.help("keys and texts stand in double quotes, no comma follows the last entry"))
    };
    let parsed = jsonc_parser::parse_to_ast(text, &jsonc_parser::CollectOptions::default(), &strict)
        .map_err(|error| not_json(&error.kind().to_string(), error.range().start, error.range().end))?;
    let value = parsed.value.ok_or_else(|| not_json("the file is empty", 0, 0))?;
    from_json(&value, file, 0)
}

fn from_json(value: &ast::Value<'_>, file: usize, depth: usize) -> Result<Value, Box<InputError>> {
    let place = |range: &jsonc_parser::common::Range| Span { file, start: range.start, end: range.end };
    let (range, kind) = match value {
        ast::Value::StringLit(text) => (&text.range, Kind::String(text.value.to_string())),
        ast::Value::NumberLit(number) => (&number.range, Kind::Number(number.value.parse().unwrap_or(f64::NAN))),
        ast::Value::BooleanLit(flag) => (&flag.range, Kind::Bool(flag.value)),
        ast::Value::NullKeyword(null) => (&null.range, Kind::Null),
        ast::Value::Array(array) => {
            if depth >= DEPTH_LIMIT {
                return Err(too_deep(place(&array.range)));
            }
            let items: Result<_, _> = array.elements.iter().map(|item| from_json(item, file, depth + 1)).collect();
            (&array.range, Kind::Array(items?))
        }
        ast::Value::Object(object) => {
            if depth >= DEPTH_LIMIT {
                return Err(too_deep(place(&object.range)));
            }
            let mut known = HashSet::new();
            let mut entries = Vec::with_capacity(object.properties.len());
            for property in &object.properties {
                let key = property.name.as_str().to_owned();
                let key_span = match &property.name {
                    ast::ObjectPropName::String(name) => place(&name.range),
                    ast::ObjectPropName::Word(name) => place(&name.range),
                };
                if !known.insert(key.clone()) {
                    let error = InputError::new(format!("the key '{key}' stands here twice"));
                    return Err(Box::new(error.at(key_span).help("keep one of them")));
                }
                entries.push(Entry { key, key_span, value: from_json(&property.value, file, depth + 1)? });
            }
            (&object.range, Kind::Table(entries))
        }
    };
    Ok(Value { span: place(range), kind })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_languages_give_one_tree() {
        let toml = parse("a = { b = [1, 2.5, \"x\"] }\nc = true", Language::Toml, 0).unwrap();
        let json = parse("{\"a\": {\"b\": [1, 2.5, \"x\"]}, \"c\": true}", Language::Json, 0).unwrap();
        fn plain(value: &Value) -> String {
            match &value.kind {
                Kind::Array(items) => format!("{:?}", items.iter().map(plain).collect::<Vec<_>>()),
                Kind::Table(entries) => {
                    format!("{:?}", entries.iter().map(|e| (&e.key, plain(&e.value))).collect::<Vec<_>>())
                }
                other => format!("{other:?}"),
            }
        }
        assert_eq!(plain(&toml), plain(&json));
    }

    #[test]
    fn deep_nesting_is_refused() {
        for depth in [70, 400, 3_000, 100_000] {
            let json = format!("{}{}", "[".repeat(depth), "]".repeat(depth));
            assert!(parse(&json, Language::Json, 0).is_err());
            assert!(parse(&format!("a = {json}"), Language::Toml, 0).is_err());
            let dotted = vec!["a"; depth].join(".");
            assert!(parse(&format!("{dotted} = 1"), Language::Toml, 0).is_err());
        }
    }

    #[test]
    fn json_is_strict() {
        for text in ["{\"a\": 1,}", "{a: 1}", "// x\n{}", "{\"a\": 1, \"a\": 2}", "", "{} {}", "[NaN]", "{\"a\" 1}"] {
            assert!(parse(text, Language::Json, 0).is_err(), "{text}");
        }
    }
}
