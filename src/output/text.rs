//! Numbers, names and columns for a person.

use pennate_solver::history::{Note, StepHistory};
use unicode_width::UnicodeWidthStr;

/// What a table, a sweep and the results say of the end of a step without a verdict on its stability though its loads have a potential.
pub fn undecided(step: &StepHistory) -> Option<&'static str> {
    let notes = step.stable.is_none().then_some(&step.notes);
    notes.into_iter().flatten().find_map(|note| match note {
        Note::WithinRounding => Some("within rounding of a singular state"),
        Note::VibrationsUnknown => Some("small vibrations about it are not known"),
        Note::TurnedAboutItself { .. } => Some("where nothing keeps a bar from turning about itself"),
        Note::Untaken { .. } => Some("where a moment on a node is taken by nothing"),
        Note::SpinsUnknown => Some("where bars may turn about themselves"),
        Note::TooCoarse => Some("nearer to a singular state than the mesh can tell"),
        _ => None,
    })
}

/// A name on one line: control characters are spelled out.
pub fn shown(name: &str) -> String {
    let spell = |letter: char| match letter.is_control() {
        true => letter.escape_debug().to_string(),
        false => letter.to_string(),
    };
    name.chars().map(spell).collect()
}

/// A number with seven significant digits, without an exponent where it can be read without.
pub fn number(value: f64) -> String {
    if !value.is_finite() {
        return "-".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = 6 - value.abs().log10().floor() as i32;
    if !(-1..=10).contains(&digits) {
        return format!("{value:.6e}");
    }
    let text = format!("{value:.*}", digits.max(0) as usize);
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// An error estimate: two digits are all it is worth.
pub fn estimate(value: f64) -> String {
    match value {
        value if !value.is_finite() => "-".to_owned(),
        0.0 => "0".to_owned(),
        value => format!("{value:.1e}"),
    }
}

/// A part of a whole in percent, with the digits that matter near its ends.
pub fn percent(fraction: f64) -> String {
    let text = format!("{:.2}", 100.0 * fraction);
    format!("{} %", text.trim_end_matches('0').trim_end_matches('.'))
}

/// A direction in the fewest words: an axis where it is one.
pub fn direction(vector: [f64; 3]) -> String {
    let component = |value: f64| number(if value.abs() < 1e-9 { 0.0 } else { (1e4 * value).round() / 1e4 });
    format!("({})", vector.map(component).join(", "))
}

/// "a, b and c", or "a, b, c and 9 more" where there are many.
pub fn list(names: &[String], most: usize) -> String {
    match names {
        [] => String::new(),
        [only] => only.clone(),
        _ if names.len() > most => format!("{} and {} more", names[..most].join(", "), names.len() - most),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// Side of a column on which its entries are flush.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// At the left edge of the column.
    Left,
    /// At its right edge.
    Right,
}

/// Rows in columns as wide as their widest entry, two blanks apart.
pub fn columns(align: &[Align], rows: &[Vec<String>]) -> String {
    let width = |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|entry| entry.width()).max();
    let widths: Vec<usize> = (0..align.len()).map(|column| width(column).unwrap_or(0)).collect();
    let mut out = String::new();
    for row in rows {
        let entries = row.iter().enumerate().map(|(column, entry)| {
            let blanks = " ".repeat(widths[column] - entry.width());
            match align[column] {
                Align::Left => format!("{entry}{blanks}"),
                Align::Right => format!("{blanks}{entry}"),
            }
        });
        out.push_str(entries.collect::<Vec<_>>().join("  ").trim_end());
        out.push('\n');
    }
    out
}

/// A time in seconds, in words.
pub fn duration(seconds: f64) -> String {
    if seconds < 1.0 { format!("{:.2} ms", 1e3 * seconds) } else { format!("{seconds:.2} s") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_seven_digits_and_no_exponent_where_it_can_be_avoided() {
        let cases = [
            (-39.9527234377, "-39.95272"),
            (0.0, "0"),
            (0.5, "0.5"),
            (12345678.9, "12345679"),
            (1.5e8, "1.500000e8"),
            (0.00012345678, "0.0001234568"),
            (1.0e-9, "1.000000e-9"),
            (f64::NAN, "-"),
        ];
        for (value, text) in cases {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn columns_line_up_whatever_the_letters() {
        let rows = [vec!["ä".to_owned(), "1".to_owned()], vec!["long".to_owned(), "10".to_owned()]];
        assert_eq!(columns(&[Align::Left, Align::Right], &rows), "ä      1\nlong  10\n");
    }

    #[test]
    fn long_lists_are_counted() {
        let names = ["a", "b", "c", "d"].map(String::from);
        assert_eq!(list(&names, 4), "a, b, c and d");
        assert_eq!(list(&names, 2), "a, b and 2 more");
        assert_eq!(shown("a\nb"), "a\\nb");
    }
}
