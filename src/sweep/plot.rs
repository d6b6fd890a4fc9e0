//! `sweep.svg`: every probe against the first parameter, one curve for each combination of the others.

use std::error::Error;
use std::path::Path;

use plotters::prelude::*;

use super::vary::Vary;
use super::{CONVERGED, Outcome};

const PANEL: (u32, u32) = (560, 380);
const LEGEND: u32 = 230;
const ROW: i32 = 20;
/// Curves named in the legend; of more the rest is counted.
const NAMED: usize = 40;
/// A probe whose values differ by less than this part of them is rounding and no curve.
const CONSTANT: f64 = 1e-9;

/// A probe with its curves.
struct Panel {
    label: String,
    curves: Vec<Curve>,
}

/// Points in the order of the parameter; a combination without answer ends one stretch and begins another.
struct Curve {
    /// Number of its combination, which gives its colour and its name in the legend.
    index: usize,
    stretches: Vec<Vec<(f64, f64)>>,
}

/// Draws the table; `false` where there is nothing to draw.
///
/// # Errors
/// Where the file cannot be written.
pub fn draw(outcome: &Outcome, vary: &[Vary], path: &Path) -> Result<bool, Box<dyn Error>> {
    let Some(first) = vary.first() else { return Ok(false) };
    let names = combinations(outcome, &first.name);
    let panels = panels(outcome, &first.name, &names);
    if panels.is_empty() {
        return Ok(false);
    }
    let columns = if panels.len() > 1 { 2 } else { 1 };
    let rows = panels.len().div_ceil(columns);
    let named = names.iter().any(|name| !name.is_empty());
    let width = columns as u32 * PANEL.0 + if named { LEGEND } else { 0 };
    let area = SVGBackend::new(path, (width, rows as u32 * PANEL.1)).into_drawing_area();
    area.fill(&WHITE)?;
    let (charts, legend) = area.split_horizontally(columns as u32 * PANEL.0);
    let axis = labelled(&first.name, &first.unit);
    for (panel, area) in panels.iter().zip(charts.split_evenly((rows, columns))) {
        draw_panel(panel, &axis, names.len(), &area)?;
    }
    if named {
        for (index, name) in names.iter().take(NAMED).enumerate() {
            let y = 30 + ROW * index as i32;
            let line = [(10, y), (34, y)];
            legend.draw(&PathElement::new(line, colour(index, names.len()).stroke_width(2)))?;
            legend.draw(&Text::new(name.clone(), (42, y - 7), ("sans-serif", 14)))?;
        }
        if names.len() > NAMED {
            let text = format!("and {} more", names.len() - NAMED);
            legend.draw(&Text::new(text, (42, 30 + ROW * NAMED as i32 - 7), ("sans-serif", 14)))?;
        }
    }
    area.present()?;
    Ok(true)
}

/// Names of the combinations of all parameters but the first, in the order of the rows.
fn combinations(outcome: &Outcome, first: &str) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for row in &outcome.rows {
        let name = combination(outcome, first, &row.keys);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

fn combination(outcome: &Outcome, first: &str, keys: &[String]) -> String {
    let others = outcome.columns.keys.iter().zip(keys).filter(|(key, _)| *key != first);
    let words = others.map(|(key, value)| if key == "file" { value.clone() } else { format!("{key} = {value}") });
    words.collect::<Vec<_>>().join(", ")
}

fn panels(outcome: &Outcome, first: &str, names: &[String]) -> Vec<Panel> {
    let Some(x_column) = outcome.columns.keys.iter().position(|key| key == first) else { return Vec::new() };
    let x = |keys: &[String]| keys[x_column].split_whitespace().next().and_then(|text| text.parse::<f64>().ok());
    let mut panels = Vec::new();
    for (probe, name) in outcome.columns.probes.iter().enumerate() {
        let mut curves: Vec<Curve> =
            (0..names.len()).map(|index| Curve { index, stretches: vec![Vec::new()] }).collect();
        for row in &outcome.rows {
            let name = combination(outcome, first, &row.keys);
            let Some(index) = names.iter().position(|known| *known == name) else { continue };
            let stretches = &mut curves[index].stretches;
            match (x(&row.keys), row.probes[probe]) {
                (Some(x), Some(y)) if row.status == CONVERGED => {
                    if let Some(last) = stretches.last_mut() {
                        last.push((x, y));
                    }
                }
                _ => stretches.push(Vec::new()),
            }
        }
        if varies(&curves) {
            let unit = outcome.units.get(probe).map_or("", String::as_str);
            panels.push(Panel { label: labelled(name, unit), curves });
        }
    }
    panels
}

fn labelled(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} ({unit})") }
}

fn points(curves: &[Curve]) -> impl Iterator<Item = (f64, f64)> + '_ {
    curves.iter().flat_map(|curve| curve.stretches.iter().flatten().copied())
}

fn varies(curves: &[Curve]) -> bool {
    let (low, high) = bounds(points(curves).map(|point| point.1));
    high - low > CONSTANT * low.abs().max(high.abs())
}

fn bounds(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

fn draw_panel(
    panel: &Panel,
    axis: &str,
    combinations: usize,
    area: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
) -> Result<(), Box<dyn Error>> {
    let x = padded(bounds(points(&panel.curves).map(|point| point.0)), 0.02);
    let y = padded(bounds(points(&panel.curves).map(|point| point.1)), 0.06);
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d(x.0..x.1, y.0..y.1)?;
    chart
        .configure_mesh()
        .light_line_style(BLACK.mix(0.05))
        .bold_line_style(BLACK.mix(0.12))
        .x_desc(axis)
        .y_desc(&panel.label)
        .axis_desc_style(("sans-serif", 15))
        .label_style(("sans-serif", 13))
        .x_label_formatter(&|value| short(*value))
        .y_label_formatter(&|value| short(*value))
        .draw()?;
    for curve in &panel.curves {
        let colour = colour(curve.index, combinations);
        for stretch in curve.stretches.iter().filter(|stretch| !stretch.is_empty()) {
            chart.draw_series(LineSeries::new(stretch.iter().copied(), colour.stroke_width(2)))?;
            chart.draw_series(stretch.iter().map(|&point| Circle::new(point, 2, colour.filled())))?;
        }
    }
    Ok(())
}

/// The range with a margin; one of no width gets some.
fn padded((low, high): (f64, f64), part: f64) -> (f64, f64) {
    let margin = if high > low { part * (high - low) } else { 0.5 * high.abs().max(1.0) };
    (low - margin, high + margin)
}

/// A number without the digits that are rounding.
fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.6e}").parse().unwrap_or(value);
    if rounded.abs() < 1e-12 { "0".to_owned() } else { rounded.to_string() }
}

/// Colours from blue to red, told apart by lightness as well.
fn colour(index: usize, count: usize) -> HSLColor {
    let part = if count > 1 { index as f64 / (count - 1) as f64 } else { 0.0 };
    HSLColor(0.62 * (1.0 - part), 0.75, 0.36 + 0.12 * (1.0 - (2.0 * part - 1.0).abs()))
}

#[cfg(test)]
mod tests {
    use super::super::table::{Columns, Row};
    use super::*;

    fn outcome() -> Outcome {
        let row = |beta: &str, pressure: &str, status: &str, stroke: Option<f64>| Row {
            keys: vec![beta.into(), pressure.into()],
            status: status.into(),
            probes: vec![stroke, Some(1.0)],
            ..Row::default()
        };
        let columns = Columns { keys: vec!["beta".into(), "p".into()], probes: vec!["stroke".into(), "one".into()] };
        let rows = vec![
            row("1 deg", "10", CONVERGED, Some(1.0)),
            row("1 deg", "20", CONVERGED, Some(2.0)),
            row("2 deg", "10", "limit_point", Some(9.0)),
            row("2 deg", "20", CONVERGED, Some(3.0)),
            row("3 deg", "10", CONVERGED, Some(2.0)),
        ];
        let units = vec!["mm".into(), String::new()];
        Outcome { columns, rows, reused: 0, interrupted: false, units }
    }

    #[test]
    fn what_failed_leaves_a_gap_and_what_is_constant_no_panel() {
        let names = combinations(&outcome(), "beta");
        assert_eq!(names, ["p = 10", "p = 20"]);
        let panels = panels(&outcome(), "beta", &names);
        assert_eq!(panels.len(), 1);
        assert_eq!(panels[0].label, "stroke (mm)");
        assert_eq!(panels[0].curves[0].stretches, [vec![(1.0, 1.0)], vec![(3.0, 2.0)]]);
        assert_eq!(panels[0].curves[1].stretches, [vec![(1.0, 2.0), (2.0, 3.0)]]);
    }

    #[test]
    fn the_picture_names_axes_units_and_curves() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("sweep.svg");
        let vary: Vec<Vary> = vec!["beta=1:3:1 deg".parse().unwrap(), "p=10,20".parse().unwrap()];
        assert!(draw(&outcome(), &vary, &path).unwrap());
        let svg = std::fs::read_to_string(&path).unwrap();
        for text in ["beta (deg)", "stroke (mm)", "p = 10", "p = 20"] {
            assert!(svg.contains(text), "{text} in {svg}");
        }
    }
}
