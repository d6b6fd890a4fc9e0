//! A tree as TOML again: tables of the file under headers, everything in them on one line.

use std::fmt::Write;

use super::tree::{Entry, Kind, Value};

/// The tree of a network file as TOML; what is null, and dates, which no key takes, are left out.
pub fn toml(tree: &Value) -> String {
    let Kind::Table(entries) = &tree.kind else { return String::new() };
    let (mut plain, mut tables) = (String::new(), String::new());
    for Entry { key, value, .. } in entries {
        match &value.kind {
            Kind::Table(inner) => table(&mut tables, &format!("[{}]", word(key)), inner),
            Kind::Array(items) if !items.is_empty() && items.iter().all(|item| matches!(item.kind, Kind::Table(_))) => {
                for item in items {
                    let Kind::Table(inner) = &item.kind else { continue };
                    table(&mut tables, &format!("[[{}]]", word(key)), inner);
                }
            }
            Kind::Null | Kind::Date => {}
            _ => line(&mut plain, key, value),
        }
    }
    plain + &tables
}

fn table(out: &mut String, header: &str, entries: &[Entry]) {
    // Writing to a text cannot fail.
    let _ = writeln!(out, "\n{header}");
    entries.iter().for_each(|Entry { key, value, .. }| line(out, key, value));
}

fn line(out: &mut String, key: &str, value: &Value) {
    if !matches!(value.kind, Kind::Null | Kind::Date) {
        let _ = writeln!(out, "{} = {}", word(key), inline(value));
    }
}

fn inline(value: &Value) -> String {
    match &value.kind {
        Kind::Null | Kind::Date => String::new(),
        Kind::Bool(flag) => flag.to_string(),
        Kind::Number(number) => shortest(*number),
        Kind::String(text) => quoted(text),
        Kind::Array(items) => format!("[{}]", items.iter().map(inline).collect::<Vec<_>>().join(", ")),
        Kind::Table(entries) => {
            let known = entries.iter().filter(|entry| !matches!(entry.value.kind, Kind::Null | Kind::Date));
            let inner: Vec<String> =
                known.map(|entry| format!("{} = {}", word(&entry.key), inline(&entry.value))).collect();
            if inner.is_empty() { "{}".to_owned() } else { format!("{{ {} }}", inner.join(", ")) }
        }
    }
}

/// A number with as many digits as it takes to read it again.
fn shortest(number: f64) -> String {
    // Beyond 2⁵³ whole numbers are not all doubles.
    if number.fract() == 0.0 && number.abs() < 9e15 { format!("{number:.0}") } else { format!("{number:?}") }
}

/// A key, in quotes where it needs them.
fn word(key: &str) -> String {
    let bare = !key.is_empty() && key.chars().all(|letter| letter.is_ascii_alphanumeric() || "-_".contains(letter));
    if bare { key.to_owned() } else { quoted(key) }
}

fn quoted(text: &str) -> String {
    let mut out = String::from('"');
    for letter in text.chars() {
        match letter {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            letter if letter.is_control() => {
                let _ = write!(out, "\\u{:04X}", u32::from(letter));
            }
            letter => out.push(letter),
        }
    }
    out + "\""
}

#[cfg(test)]
mod tests {
    use super::super::tree::{Language, parse};
    use super::*;

    #[test]
    fn what_is_written_reads_as_the_same_tree() {
        let text = "a = 1\n\"b c\" = [1, 2.5, -1e-9, 1e300]\n[t]\n\"x\\\"y\\n\" = { z = true, w = [{ v = \"= 2 * a\" }] }\n\
                    [[steps]]\nname = \"one\"\n[[steps]]\nname = \"two\"\n[empty]\n";
        let written = toml(&parse(text, Language::Toml, 0).unwrap());
        assert_eq!(toml(&parse(&written, Language::Toml, 0).unwrap()), written);
        for part in ["\"b c\" = [1, 2.5, -1e-9, 1e300]", "\"x\\\"y\\u000A\"", "[[steps]]\nname = \"two\"", "[empty]"] {
            assert!(written.contains(part), "{part} is not in {written}");
        }
    }
}
