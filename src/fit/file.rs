//! The muscle file: what a network file refers to, with where its numbers come from.

use std::fmt::Write;

use pennate_analysis::fit::Fitted;
use pennate_analysis::fit::errors::by_length;
use pennate_analysis::fit::select::words;

use super::report::{bounds, method};
use crate::output::text::{number, shown};

/// The file as text: TOML, in mm, N and MPa.
pub fn text(fitted: &Fitted) -> String {
    let mut text = String::new();
    let unit = &fitted.data.pressure_unit;
    for line in provenance(fitted) {
        let _ = writeln!(text, "# {}", shown(&line));
    }
    let tube = &fitted.tube;
    let _ = write!(
        text,
        "units = \"mm-N-MPa\"\ndiameter = {}\nwall = {}\nend_length = {}\npressure_unit = \"{unit}\"\n",
        tube.diameter,
        tube.wall,
        rounded(tube.end_length)
    );
    if tube.shear {
        text += "shear = true\n";
    }
    text += "table = [\n";
    let two = fitted.has_two_moduli();
    for fitted in &fitted.rows {
        let row = &fitted.row;
        let end = if two { format!("E1 = {}, ", rounded(row.end_modulus)) } else { String::new() };
        let _ = writeln!(
            text,
            "  {{ pressure = {}, E = {}, {end}alpha = {:e}, R1 = {}, R2 = {} }},",
            row.pressure,
            rounded(row.youngs_modulus),
            rounded(row.alpha),
            rounded(row.end_radius),
            rounded(row.middle_radius)
        );
    }
    text + "]\n"
}

fn provenance(fitted: &Fitted) -> Vec<String> {
    let unit = &fitted.data.pressure_unit;
    let selection = &fitted.selection;
    let name = std::path::Path::new(&fitted.data.source.name)
        .file_name()
        .map_or_else(|| fitted.data.source.name.clone(), |name| name.to_string_lossy().into_owned());
    let variant = if selection.variant.is_empty() { String::new() } else { format!(", variant {}", selection.variant) };
    let cases: usize = selection.pressures.iter().map(|at| at.cases.len()).sum();
    let tests: Vec<&str> = selection.tests.iter().map(String::as_str).filter(|test| !test.is_empty()).collect();
    let tests = if tests.is_empty() { String::new() } else { format!(" ({})", tests.join(", ")) };
    let pressures: Vec<f64> = fitted.rows.iter().map(|row| row.row.pressure).collect();
    let mut lines = vec![
        format!(
            "Fitted to {name}{variant}: {cases} load cases{tests} of muscles {} mm long, at {}.",
            selection.length,
            words(&pressures, unit)
        ),
        format!("By pennate {} fit, {}.", env!("CARGO_PKG_VERSION"), method(fitted.method)),
        String::new(),
        "Mean absolute errors, axial motion, deflection and slope, with the largest measured:".to_owned(),
    ];
    for row in &fitted.rows {
        let [axial, bending, slope] = row.errors.mean;
        let [of_axial, of_bending, of_slope] = row.errors.largest;
        lines.push(format!(
            "{:>6} {unit}: {axial:.3} of {of_axial:.1} mm, {bending:.3} of {of_bending:.1} mm, {slope:.3} of {of_slope:.1} deg",
            row.row.pressure
        ));
    }
    if selection.lengths.len() > 1 {
        lines.push("Over all pressures, at the lengths of the data:".to_owned());
        for line in by_length(fitted, None) {
            let [axial, bending, slope] = line.mean;
            lines.push(format!("{:>6} mm: {axial:.2} mm, {bending:.2} mm, {slope:.2} deg", line.length));
        }
    }
    lines.push(String::new());
    let [first, .., last] = &pressures[..] else {
        return with_bounds(fitted, with_range(fitted, lines, pressures[0], pressures[0]));
    };
    let lines = with_range(fitted, lines, *first, *last);
    with_bounds(fitted, lines)
}

/// What the data cover: beyond it the table has nothing to go by.
fn with_range(fitted: &Fitted, mut lines: Vec<String>, first: f64, last: f64) -> Vec<String> {
    let unit = &fitted.data.pressure_unit;
    let cases = || fitted.selection.pressures.iter().flat_map(|at| &at.cases);
    let pull = cases().filter(|case| case.is_axial()).map(|case| case.force[0]).fold(0.0, f64::max);
    let deflection = cases().map(|case| case.tip[1].abs() / case.length).fold(0.0, f64::max);
    lines.push(format!(
        "Range: {first} to {last} {unit}, pulls up to {} N, deflections up to {:.2} of the length.",
        number(pull),
        deflection
    ));
    if let ([shortest, .., longest], _) = (&fitted.selection.lengths[..], ()) {
        lines.push(format!("Compared at lengths of {shortest} to {longest} mm."));
    }
    lines.push(format!("Below {first} {unit} the values of the first row hold."));
    lines
}

fn with_bounds(fitted: &Fitted, mut lines: Vec<String>) -> Vec<String> {
    lines.extend(bounds(fitted));
    lines
}

/// Seven digits: more than any measurement has.
fn rounded(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}
