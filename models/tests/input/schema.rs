//! The JSON Schema tells the truth: it takes what the reader takes and refuses unknown keys.

use pennate_models::input::tree::{Kind, Language, Value, parse};
use serde_json::{Map, Value as Json, json};

/// Validates against the keywords that the schema uses; any other keyword fails the test.
fn validate(schema: &Json, root: &Json, value: &Json) -> Result<(), String> {
    let schema = match schema {
        Json::Bool(true) => return Ok(()),
        Json::Bool(false) => return Err("nothing is allowed here".into()),
        Json::Object(schema) => schema,
        other => panic!("no schema: {other}"),
    };
    for (keyword, rule) in schema {
        match keyword.as_str() {
            "$schema" | "title" | "description" | "$defs" | "format" | "default" => {}
            "$ref" => {
                let name = rule.as_str().unwrap().strip_prefix("#/$defs/").unwrap();
                validate(&root["$defs"][name], root, value)?;
            }
            "type" => {
                let fits = |name: &Json| match name.as_str().unwrap() {
                    "object" => value.is_object(),
                    "array" => value.is_array(),
                    "string" => value.is_string(),
                    "boolean" => value.is_boolean(),
                    "number" => value.is_number(),
                    "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
                    "null" => value.is_null(),
                    other => panic!("type {other}"),
                };
                let fitting = rule.as_array().map_or_else(|| fits(rule), |names| names.iter().any(fits));
                fitting.then_some(()).ok_or_else(|| format!("{value} is not {rule}"))?;
            }
            "enum" => rule.as_array().unwrap().contains(value).then_some(()).ok_or(format!("{value} not in {rule}"))?,
            "const" => (rule == value).then_some(()).ok_or(format!("{value} is not {rule}"))?,
            "minimum" => (value.as_f64() >= rule.as_f64()).then_some(()).ok_or("too small")?,
            "maximum" => (value.as_f64() <= rule.as_f64()).then_some(()).ok_or("too large")?,
            "anyOf" | "oneOf" => {
                let tried: Vec<_> = rule.as_array().unwrap().iter().map(|rule| validate(rule, root, value)).collect();
                let fitting = tried.iter().filter(|result| result.is_ok()).count();
                let enough = fitting == 1 || (keyword == "anyOf" && fitting > 1);
                enough.then_some(()).ok_or_else(|| format!("{value}: {tried:?}"))?;
            }
            "items" => value.as_array().into_iter().flatten().try_for_each(|item| validate(rule, root, item))?,
            "required" => {
                let missing = |key: &&Json| value.is_object() && value.get(key.as_str().unwrap()).is_none();
                rule.as_array().unwrap().iter().find(missing).map_or(Ok(()), |key| Err(format!("{key} is missing")))?;
            }
            "properties" => {
                for (key, rule) in rule.as_object().unwrap() {
                    value.get(key).map_or(Ok(()), |value| validate(rule, root, value))?;
                }
            }
            "additionalProperties" => {
                let known = schema.get("properties").and_then(Json::as_object);
                for (key, value) in value.as_object().into_iter().flatten() {
                    if !known.is_some_and(|known| known.contains_key(key)) {
                        validate(rule, root, value).map_err(|error| format!("{key}: {error}"))?;
                    }
                }
            }
            other => panic!("the test does not know the keyword {other}"),
        }
    }
    Ok(())
}

fn check(value: &Json) -> Result<(), String> {
    let schema = pennate_models::schema();
    validate(&schema, &schema, value)
}

fn to_json(value: &Value) -> Json {
    match &value.kind {
        Kind::Null | Kind::Date => Json::Null,
        Kind::Bool(flag) => json!(flag),
        Kind::Number(number) => json!(number),
        Kind::String(text) => json!(text),
        Kind::Array(items) => items.iter().map(to_json).collect(),
        Kind::Table(entries) => {
            Json::Object(entries.iter().map(|entry| (entry.key.clone(), to_json(&entry.value))).collect::<Map<_, _>>())
        }
    }
}

fn network(text: &str) -> Json {
    to_json(&parse(text, Language::Toml, 0).unwrap())
}

#[test]
fn the_schema_accepts_every_network_of_this_crate() {
    for entry in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/networks")).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let value = match path.extension().unwrap().to_str().unwrap() {
            "json" => serde_json::from_str(&text).unwrap(),
            _ => network(&text),
        };
        check(&value).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
}

#[test]
fn the_schema_accepts_every_form_of_every_key() {
    check(&network(include_str!("../every_key.toml"))).unwrap();
}

#[test]
fn the_schema_refuses_unknown_keys_and_wrong_types() {
    for text in [
        "title = 3",
        "nodse = {}",
        "members.m = { nodes = [\"A\", \"B\"], sectoin = \"x\" }",
        "supports = { A = \"clampd\" }",
        "supports = { A = [\"ux\", \"uq\"] }",
        "steps = [{ presure = { all = 1 } }]",
        "units = \"furlong\"",
        "members.m = { nodes = [\"A\", \"B\"], elements = 0 }",
        "probes.p = { node = \"J\", displacment = \"uy\" }",
        "springs.k = { node = \"J\", stiffness = { uv = 1 } }",
    ] {
        assert!(check(&network(text)).is_err(), "{text}");
    }
}
