//! Typed reading off the tree: every complaint with its place, as many at once as there are.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::tree::{Entry, Kind, Value};
use crate::error::{InputError, Span};

/// A type that can be read off the tree. `None` means that an error was reported.
pub(crate) trait Input: Sized {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self>;

    /// What stands for a key that is not there: an error unless the type is optional.
    fn absent(owner: Span, what: &str, key: &str, errors: &mut Vec<InputError>) -> Option<Self> {
        errors.push(
            InputError::new(format!("{what} needs the key '{key}'"))
                .at(owner)
                .label(format!("'{key}' is missing"))
                .help(format!("add {key} = …")),
        );
        None
    }
}

impl<T: Input> Input for Option<T> {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        if matches!(value.kind, Kind::Null) { Some(None) } else { T::read(value, errors).map(Some) }
    }

    fn absent(_: Span, _: &str, _: &str, _: &mut Vec<InputError>) -> Option<Self> {
        Some(None)
    }
}

/// A value with its place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Spanned<T> {
    pub span: Span,
    pub value: T,
}

impl<T: Input> Input for Spanned<T> {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        Some(Self { span: value.span, value: T::read(value, errors)? })
    }
}

/// A named entry of a table.
#[derive(Clone, Debug)]
pub(crate) struct Named<T> {
    pub name: String,
    /// Place of the name.
    pub span: Span,
    pub value: T,
}

/// A table whose keys the user chooses, in the order of the file.
#[derive(Clone, Debug)]
pub(crate) struct Map<T>(pub Vec<Named<T>>);

impl<T> Default for Map<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Map<T> {
    pub(crate) fn iter(&self) -> std::slice::Iter<'_, Named<T>> {
        self.0.iter()
    }
}

impl<'a, T> IntoIterator for &'a Map<T> {
    type Item = &'a Named<T>;
    type IntoIter = std::slice::Iter<'a, Named<T>>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl<T: Input> Input for Map<T> {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        let entries = table(value, "a table of names", errors)?;
        let before = errors.len();
        let mut named = Vec::with_capacity(entries.len());
        for entry in entries {
            if let Some(value) = T::read(&entry.value, errors) {
                named.push(Named { name: entry.key.clone(), span: entry.key_span, value });
            }
        }
        (errors.len() == before).then_some(Self(named))
    }
}

impl<T: Input> Input for Vec<T> {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        let Kind::Array(items) = &value.kind else { return wrong_type(value, "a list", errors) };
        let read: Vec<Option<T>> = items.iter().map(|item| T::read(item, errors)).collect();
        read.into_iter().collect()
    }
}

impl Input for String {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        match &value.kind {
            Kind::String(text) => Some(text.clone()),
            _ => wrong_type(value, "a text in quotes", errors),
        }
    }
}

impl Input for bool {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        match value.kind {
            Kind::Bool(flag) => Some(flag),
            _ => wrong_type(value, "true or false", errors),
        }
    }
}

/// A number as written: bare, or a text with a unit or an expression.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Written {
    Bare(f64),
    Text(String),
}

/// A number as written, with its place.
pub(crate) type Number = Spanned<Written>;

impl Input for Written {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        match &value.kind {
            Kind::Number(number) if number.is_finite() => Some(Self::Bare(*number)),
            Kind::Number(number) => {
                let what = if number.is_nan() { "not a number" } else { "infinite" };
                errors.push(
                    InputError::new(format!("this number is {what}"))
                        .at(value.span)
                        .label("must be finite")
                        .help("write a finite number"),
                );
                None
            }
            Kind::String(text) => Some(Self::Text(text.clone())),
            _ => wrong_type(value, "a number, a text with a unit or an expression \"= …\"", errors),
        }
    }
}

/// A count of something, at least one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Count(pub usize);

impl Count {
    /// More of anything than any computer could mesh.
    pub(crate) const LIMIT: usize = 1_000_000;
}

impl Input for Count {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        match value.kind {
            #[expect(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            Kind::Number(number) if number.fract() == 0.0 && number >= 1.0 && number <= Self::LIMIT as f64 => {
                Some(Self(number as usize))
            }
            Kind::Number(_) => {
                errors.push(
                    InputError::new(format!("a whole number from 1 to {} is expected", Self::LIMIT))
                        .at(value.span)
                        .help("write for example 4"),
                );
                None
            }
            _ => wrong_type(value, "a whole number", errors),
        }
    }
}

/// A count, or an expression of the parameters that gives one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Counted {
    Bare(Count),
    Expression(String),
}

impl Input for Counted {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        match &value.kind {
            Kind::String(text) if text.trim_start().starts_with('=') => Some(Self::Expression(text.clone())),
            _ => Count::read(value, errors).map(Self::Bare),
        }
    }
}

/// Reports that something else is expected here.
pub(crate) fn wrong_type<T>(value: &Value, expected: &str, errors: &mut Vec<InputError>) -> Option<T> {
    errors.push(
        InputError::new(format!("{expected} is expected here, not {}", value.description()))
            .at(value.span)
            .label(format!("this is {}", value.description()))
            .help(format!("write {expected}")),
    );
    None
}

/// The entries of a table.
pub(crate) fn table<'a>(value: &'a Value, what: &str, errors: &mut Vec<InputError>) -> Option<&'a [Entry]> {
    match &value.kind {
        Kind::Table(entries) => Some(entries),
        _ => wrong_type(value, what, errors),
    }
}

/// Reports the keys that are none of `known`.
pub(crate) fn refuse_unknown(entries: &[Entry], what: &str, known: &[&str], errors: &mut Vec<InputError>) {
    for entry in entries.iter().filter(|entry| !known.contains(&entry.key.as_str())) {
        errors.push(
            InputError::new(format!("unknown key '{}' in {what}", entry.key))
                .at(entry.key_span)
                .label("unknown key")
                .help(suggest(&entry.key, known.iter().copied(), "keys")),
        );
    }
}

/// A help that names what is nearest to a name, or else everything there is.
pub fn suggest<'a>(name: &str, known: impl Iterator<Item = &'a str>, plural: &str) -> String {
    const SHOWN: usize = 12;
    let known: Vec<&str> = known.collect();
    let lower = name.to_lowercase();
    let nearest = known
        .iter()
        .map(|candidate| (strsim::jaro_winkler(&lower, &candidate.to_lowercase()), *candidate))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let list = || {
        let quoted: Vec<String> = known.iter().take(SHOWN).map(|name| format!("'{name}'")).collect();
        let more = if known.len() > SHOWN { format!(" and {} more", known.len() - SHOWN) } else { String::new() };
        format!("{}{more}", quoted.join(", "))
    };
    match nearest {
        None => format!("no {plural} are defined"),
        Some((likeness, candidate)) if likeness > 0.75 => match known.len() {
            2..=SHOWN => format!("did you mean '{candidate}'? known {plural}: {}", list()),
            _ => format!("did you mean '{candidate}'?"),
        },
        Some(_) => format!("known {plural}: {}", list()),
    }
}

/// Keys of lists of tables, which TOML writes in double brackets.
const LISTED: [&str; 2] = ["steps", "patterns"];

/// Reads one key of a table.
pub(crate) fn field<T: Input>(
    entries: &[Entry],
    owner: Span,
    what: &str,
    key: &str,
    errors: &mut Vec<InputError>,
) -> Option<T> {
    match entries.iter().find(|entry| entry.key == key) {
        Some(Entry { value: Value { kind: Kind::Table(_), .. }, key_span, .. }) if LISTED.contains(&key) => {
            errors.push(
                InputError::new(format!("'{key}' is a list, even where there is one of them"))
                    .at(*key_span)
                    .label("a single table")
                    .help(format!("write [[{key}]], with two brackets on each side, above every one of them")),
            );
            None
        }
        Some(entry) => T::read(&entry.value, errors),
        None => T::absent(owner, what, key, errors),
    }
}

/// Defines a table with fixed keys: its type, how it is read, and its schema.
macro_rules! record {
    ($(#[$meta:meta])* $vis:vis struct $name:ident as $what:literal {
        $($(#[$field_meta:meta])* $field:ident: $type:ty,)*
    }) => {
        $(#[$meta])*
        #[derive(Clone, Debug, schemars::JsonSchema)]
        #[schemars(deny_unknown_fields)]
        $vis struct $name { $($(#[$field_meta])* pub $field: $type,)* }

        impl $crate::input::read::Input for $name {
            #[allow(non_snake_case)]
            fn read(
                value: &$crate::input::tree::Value,
                errors: &mut Vec<$crate::error::InputError>,
            ) -> Option<Self> {
                use $crate::input::read::{field, refuse_unknown, table};
                let entries = table(value, $what, errors)?;
                refuse_unknown(entries, $what, &[$(stringify!($field)),*], errors);
                $(let $field = field(entries, value.span, $what, stringify!($field), errors);)*
                Some(Self { $($field: $field?,)* })
            }
        }
    };
}
pub(crate) use record;

/// The place of the word that a value is.
pub(crate) fn word<'a>(
    value: &Value,
    what: &str,
    words: impl Iterator<Item = &'a str> + Clone,
    errors: &mut Vec<InputError>,
) -> Option<usize> {
    let Kind::String(word) = &value.kind else { return wrong_type(value, what, errors) };
    let found = words.clone().position(|known| known == word);
    if found.is_none() {
        errors.push(
            InputError::new(format!("'{word}' is not {what}"))
                .at(value.span)
                .label("unknown word")
                .help(suggest(word, words, "words")),
        );
    }
    found
}

/// Defines a choice among words: its type, how it is read, and its schema.
macro_rules! words {
    ($(#[$meta:meta])* $vis:vis enum $name:ident as $what:literal {
        $($(#[$word_meta:meta])* $variant:ident = $word:literal,)*
    }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, schemars::JsonSchema)]
        $vis enum $name { $($(#[$word_meta])* #[schemars(rename = $word)] $variant,)* }

        impl $name {
            /// The words as written.
            pub(crate) const WORDS: &'static [&'static str] = &[$($word),*];
            const ALL: &'static [Self] = &[$(Self::$variant),*];
        }

        impl $crate::input::read::Input for $name {
            fn read(
                value: &$crate::input::tree::Value,
                errors: &mut Vec<$crate::error::InputError>,
            ) -> Option<Self> {
                let words = Self::WORDS.iter().copied();
                $crate::input::read::word(value, $what, words, errors).map(|place| Self::ALL[place])
            }
        }
    };
}
pub(crate) use words;

impl<T: JsonSchema> JsonSchema for Spanned<T> {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> Cow<'static, str> {
        T::schema_name()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        generator.subschema_for::<T>()
    }
}

impl<T: JsonSchema> JsonSchema for Map<T> {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> Cow<'static, str> {
        format!("MapOf{}", T::schema_name()).into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let value = generator.subschema_for::<T>();
        json_schema!({ "type": "object", "additionalProperties": value })
    }
}

impl JsonSchema for Written {
    fn schema_name() -> Cow<'static, str> {
        "Number".into()
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A number in the file's units, a text with a unit (\"0.5 in\"), or an expression (\"= L * cos(beta)\")",
            "type": ["number", "string"]
        })
    }
}

impl JsonSchema for Count {
    fn schema_name() -> Cow<'static, str> {
        "Count".into()
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "integer", "minimum": 1, "maximum": Self::LIMIT })
    }
}

impl JsonSchema for Counted {
    fn schema_name() -> Cow<'static, str> {
        "CountOrExpression".into()
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A whole number, or an expression (\"= n / 2\") that gives one",
            "anyOf": [
                { "type": "integer", "minimum": 1, "maximum": Count::LIMIT },
                { "type": "string" }
            ]
        })
    }
}
