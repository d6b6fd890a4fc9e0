//! Tables of docs/validation.md that examples fill.

use std::fs;

const PAGE: &str = "docs/validation.md";

/// Replaces what stands between the two markers of a table.
pub fn put(name: &str, table: &str) -> Result<(), String> {
    let (begin, end) = (format!("<!-- {name}: begin -->"), format!("<!-- {name}: end -->"));
    let path = crate::repository(PAGE);
    let text = fs::read_to_string(&path).map_err(|error| format!("{PAGE}: {error}"))?;
    let parts = text.split_once(&begin).and_then(|(before, rest)| Some((before, rest.split_once(&end)?.1)));
    let (before, after) = parts.ok_or_else(|| format!("{PAGE} has no markers for the {name}"))?;
    fs::write(&path, format!("{before}{begin}\n{table}\n{end}{after}")).map_err(|error| format!("{PAGE}: {error}"))
}
