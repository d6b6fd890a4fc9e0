//! Network files as trees: read from TOML, and printed as a person would write them.

use serde_json::{Map, Number, Value};

/// The tree of a network file in TOML, keys in the order of the file.
///
/// # Errors
/// What is wrong with the text.
pub fn parse(text: &str) -> Result<Value, String> {
    toml::from_str(text).map_err(|error| error.to_string())
}

/// A tree as TOML: keys of the top first, then one table after the other with an entry a line.
///
/// Null has no TOML; what holds it is refused when it is read.
pub fn print(tree: &Value) -> String {
    let empty = Map::new();
    let top = tree.as_object().unwrap_or(&empty);
    let entries = |table: &Map<String, Value>| -> String {
        table.iter().map(|(key, value)| format!("{} = {}\n", word(key), inline(value))).collect()
    };
    let mut text = String::new();
    for (key, value) in top.iter().filter(|(_, value)| !value.is_object() && tables(value).is_none()) {
        text += &format!("{} = {}\n", word(key), inline(value));
    }
    for (key, value) in top {
        if let Some(table) = value.as_object() {
            text += &format!("\n[{}]\n{}", word(key), entries(table));
        } else {
            for table in tables(value).into_iter().flatten() {
                text += &format!("\n[[{}]]\n{}", word(key), entries(table));
            }
        }
    }
    text
}

/// The tables of an array of nothing else.
fn tables(value: &Value) -> Option<Vec<&Map<String, Value>>> {
    let items = value.as_array().filter(|items| !items.is_empty())?;
    items.iter().map(Value::as_object).collect()
}

/// A value on one line.
pub fn inline(value: &Value) -> String {
    match value {
        Value::Object(map) => {
            let entries: Vec<String> =
                map.iter().map(|(key, value)| format!("{} = {}", word(key), inline(value))).collect();
            format!("{{ {} }}", entries.join(", "))
        }
        Value::Array(items) => format!("[{}]", items.iter().map(inline).collect::<Vec<_>>().join(", ")),
        Value::String(text) => quoted(text),
        Value::Number(number) => plain(number),
        other => other.to_string(),
    }
}

/// A number without a decimal point where it needs none.
fn plain(number: &Number) -> String {
    let text = number.to_string();
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// A key, quoted only where it has to be.
pub fn word(key: &str) -> String {
    let bare = !key.is_empty() && key.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"_-".contains(&byte));
    if bare { key.to_owned() } else { quoted(key) }
}

/// JSON's way of quoting is one of TOML's.
fn quoted(text: &str) -> String {
    Value::String(text.to_owned()).to_string()
}

/// A number; null if it is not finite.
pub fn number(value: f64) -> Value {
    Number::from_f64(value).map_or(Value::Null, Value::Number)
}
