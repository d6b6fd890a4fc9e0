//! `sweep.svg`: every probe against the first parameter, one curve for each combination of the others; of two parameters
//! with many values each, a map.

use std::error::Error;
use std::path::Path;

use pennate_analysis::sweep::Plan;
use plotters::prelude::*;

use super::{DESIGN, Outcome, head};
use crate::output::svg::{self, FINE, font};

/// Sizes of a panel in pixels.
const PANEL: (u32, u32) = (560, 380);
const ROW: u32 = 20;
/// Room for the line and the margins of a row of the legend, and for a letter of its text.
const LEGEND: (u32, f64) = (64, 7.6);
/// Curves named in the legend; of more the rest is counted.
const NAMED: usize = 40;
/// A probe whose values differ by less than this part of them is rounding and no curve.
const CONSTANT: f64 = 1e-9;
/// Values beyond this have no axis: the width of one, with its margins, would be no number.
const WIDEST: f64 = 1e300;
/// Values that each of two parameters has to have for a map to say more than curves.
const MAPPED: usize = 5;
/// Steps of the colour bar of a map.
const SHADES: usize = 64;

/// Part of a map by which its cells overlap.
const SEAM: f64 = 0.004;

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

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
pub fn draw(outcome: &Outcome, plan: &Plan, path: &Path) -> Result<bool, Box<dyn Error>> {
    // Designs of a list need not lie on any curve.
    let Some(first) = plan.parameters.first().filter(|_| !plan.is_list) else { return Ok(false) };
    if (0..plan.parameters.len()).flat_map(|index| plan.values(index)).any(|value| value.abs() > WIDEST) {
        return Ok(false);
    }
    let two = plan.parameters.len() == 2 && outcome.columns.keys.len() == 2;
    if two && (0..2).all(|index| plan.values(index).len() >= MAPPED) {
        return draw_maps(outcome, plan, path);
    }
    let names = combinations(outcome, &head(first));
    let panels = panels(outcome, &head(first), &names);
    if panels.is_empty() {
        return Ok(false);
    }
    let legend = legend(&names);
    let (columns, rows) = grid(panels.len());
    let longest = legend.iter().map(|name| name.chars().count()).max();
    let legend_width = longest.map_or(0, |letters| LEGEND.0 + (LEGEND.1 * letters as f64).ceil() as u32);
    let height = (rows as u32 * PANEL.1).max(30 + ROW * legend.len() as u32);
    svg::draw(path, (columns as u32 * PANEL.0 + legend_width, height), |area| {
        let (charts, beside) = area.split_horizontally(FINE * columns as u32 * PANEL.0);
        let (charts, _) = charts.split_vertically(FINE * rows as u32 * PANEL.1);
        for (panel, area) in panels.iter().zip(charts.split_evenly((rows, columns))) {
            draw_panel(panel, &head(first), names.len(), &area)?;
        }
        draw_legend(&legend, names.len(), &beside)
    })?;
    Ok(true)
}

/// Columns and rows for so many panels.
fn grid(panels: usize) -> (usize, usize) {
    let columns = if panels > 1 { 2 } else { 1 };
    (columns, panels.div_ceil(columns))
}

/// The lines of the legend: names of combinations, and how many more there are; nothing where there is one curve.
fn legend(names: &[String]) -> Vec<String> {
    if names.iter().all(String::is_empty) {
        return Vec::new();
    }
    let mut lines: Vec<String> = names.iter().take(NAMED).cloned().collect();
    if names.len() > NAMED {
        lines.push(format!("and {} more", names.len() - NAMED));
    }
    lines
}

fn draw_legend(lines: &[String], combinations: usize, area: &Area<'_>) -> Result<(), Box<dyn Error>> {
    let fine = FINE as i32;
    for (index, name) in lines.iter().enumerate() {
        let y = (30 + ROW as i32 * index as i32) * fine;
        if index < combinations.min(NAMED) {
            let line = [(10 * fine, y), (34 * fine, y)];
            area.draw(&PathElement::new(line, colour(index, combinations).stroke_width(2 * FINE)))?;
        }
        area.draw(&Text::new(name.clone(), (42 * fine, y - 7 * fine), font(14)))?;
    }
    Ok(())
}

/// A map of every probe that varies, over the first parameter to the right and the second upwards.
fn draw_maps(outcome: &Outcome, plan: &Plan, path: &Path) -> Result<bool, Box<dyn Error>> {
    let varies = |probe: &usize| {
        let values = outcome.rows.iter().filter(|row| row.is_solved()).filter_map(|row| row.probes[*probe]);
        is_drawn(bounds(values))
    };
    let probes: Vec<usize> = (0..outcome.columns.probes.len()).filter(varies).collect();
    if probes.is_empty() {
        return Ok(false);
    }
    let (columns, rows) = grid(probes.len());
    svg::draw(path, (columns as u32 * PANEL.0, rows as u32 * PANEL.1), |area| {
        for (&probe, area) in probes.iter().zip(area.split_evenly((rows, columns))) {
            draw_map(outcome, plan, probe, &area)?;
        }
        Ok(())
    })?;
    Ok(true)
}

fn draw_map(outcome: &Outcome, plan: &Plan, probe: usize, area: &Area<'_>) -> Result<(), Box<dyn Error>> {
    let [x, y] = [0, 1].map(|index| borders(&plan.values(index)));
    let number = |text: &String| text.parse::<f64>().ok();
    let points: Vec<([f64; 2], f64)> = outcome
        .rows
        .iter()
        .filter(|row| row.is_solved())
        .filter_map(|row| Some(([number(&row.keys[0])?, number(&row.keys[1])?], row.probes[probe]?)))
        .collect();
    let (low, high) = bounds(points.iter().map(|point| point.1));
    let (map, bar) = area.split_horizontally(FINE * (PANEL.0 - 110));
    let mut chart = ChartBuilder::on(&map)
        .margin(12 * FINE)
        .x_label_area_size(44 * FINE)
        .y_label_area_size(64 * FINE)
        .build_cartesian_2d(x[0]..x[x.len() - 1], y[0]..y[y.len() - 1])?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_desc(head(&plan.parameters[0]))
        .y_desc(head(&plan.parameters[1]))
        .axis_desc_style(font(15))
        .label_style(font(13))
        .axis_style(BLACK.mix(0.5).stroke_width(FINE))
        .set_all_tick_mark_size(5 * FINE)
        .x_label_formatter(&|value| short(*value, [x[0], x[x.len() - 1]]))
        .y_label_formatter(&|value| short(*value, [y[0], y[y.len() - 1]]))
        .draw()?;
    // What was not solved stays grey.
    chart.draw_series([Rectangle::new(
        [(x[0], y[0]), (x[x.len() - 1], y[y.len() - 1])],
        RGBColor(224, 224, 224).filled(),
    )])?;
    let cell = |borders: &[f64], value: f64| {
        let after = borders.partition_point(|border| *border <= value).clamp(1, borders.len() - 1);
        [borders[after - 1], borders[after]]
    };
    chart.draw_series(points.iter().map(|&([at_x, at_y], value)| {
        let ([left, right], [bottom, top]) = (cell(&x, at_x), cell(&y, at_y));
        // A little over the next cells, which cover it: else the ground shines through between them.
        let over = [&x, &y].map(|borders| SEAM * (borders[borders.len() - 1] - borders[0]));
        let corner = [(right, x[x.len() - 1], over[0]), (top, y[y.len() - 1], over[1])];
        let [right, top] = corner.map(|(end, last, over)| (end + over).min(last));
        Rectangle::new([(left, bottom), (right, top)], shade((value - low) / (high - low)).filled())
    }))?;
    let label = crate::output::csv::head(&outcome.columns.probes[probe], &outcome.columns.units[probe]);
    let mut scale = ChartBuilder::on(&bar)
        .margin_top(12 * FINE)
        .margin_bottom((12 + 44) * FINE)
        .margin_right(12 * FINE)
        .y_label_area_size(74 * FINE)
        .build_cartesian_2d(0.0..1.0, low..high)?;
    scale
        .configure_mesh()
        .disable_mesh()
        .disable_x_axis()
        .y_desc(label)
        .axis_desc_style(font(15))
        .label_style(font(13))
        .y_label_formatter(&|value| short(*value, [low, high]))
        .draw()?;
    let step = (high - low) / SHADES as f64;
    scale.draw_series((0..SHADES).map(|index| {
        let from = low + step * index as f64;
        let to = (from + step * (1.0 + 10.0 * SEAM)).min(high);
        Rectangle::new([(0.0, from), (1.0, to)], shade((index as f64 + 0.5) / SHADES as f64).filled())
    }))?;
    Ok(())
}

/// Borders of cells around rising values: halfway between them, and as far beyond the first and the last.
fn borders(values: &[f64]) -> Vec<f64> {
    let between = values.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    let last = values.len() - 1;
    let [first, end] = [1.5 * values[0] - 0.5 * values[1], 1.5 * values[last] - 0.5 * values[last - 1]];
    std::iter::once(first).chain(between).chain([end]).collect()
}

/// A colour from dark blue by green to yellow, which rises in lightness all the way.
fn shade(part: f64) -> RGBColor {
    // A few colours of viridis (van der Walt and Smith, 2015), in between straight lines.
    const COLOURS: [[f64; 3]; 5] =
        [[68.0, 1.0, 84.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 201.0, 98.0], [253.0, 231.0, 37.0]];
    let at = part.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
    let index = (at.floor() as usize).min(COLOURS.len() - 2);
    let mix = |c: usize| {
        let [a, b] = [COLOURS[index][c], COLOURS[index + 1][c]];
        (a + (at - index as f64) * (b - a)).round() as u8
    };
    RGBColor(mix(0), mix(1), mix(2))
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
    let others = outcome.columns.keys.iter().zip(keys).filter(|(key, _)| *key != first && *key != DESIGN);
    let words = others.map(|(key, value)| match key.strip_suffix(')').and_then(|key| key.rsplit_once(" (")) {
        _ if key == "file" => value.clone(),
        Some((name, unit)) => format!("{name} = {value} {unit}"),
        None => format!("{key} = {value}"),
    });
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
                (Some(x), Some(y)) if row.is_solved() => {
                    if let Some(last) = stretches.last_mut() {
                        last.push((x, y));
                    }
                }
                _ => stretches.push(Vec::new()),
            }
        }
        if varies(&curves) {
            let unit = outcome.columns.units.get(probe).map_or("", String::as_str);
            panels.push(Panel { label: crate::output::csv::head(name, unit), curves });
        }
    }
    panels
}

fn points(curves: &[Curve]) -> impl Iterator<Item = (f64, f64)> + '_ {
    curves.iter().flat_map(|curve| curve.stretches.iter().flatten().copied())
}

fn varies(curves: &[Curve]) -> bool {
    is_drawn(bounds(points(curves).map(|point| point.1)))
}

/// Whether values between these are drawn: they differ by more than rounding, and by no more than an axis can have.
fn is_drawn((low, high): (f64, f64)) -> bool {
    high - low > CONSTANT * low.abs().max(high.abs()) && high.abs().max(low.abs()) < WIDEST
}

fn bounds(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

fn draw_panel(panel: &Panel, axis: &str, combinations: usize, area: &Area<'_>) -> Result<(), Box<dyn Error>> {
    let x = padded(bounds(points(&panel.curves).map(|point| point.0)), 0.02);
    let y = padded(bounds(points(&panel.curves).map(|point| point.1)), 0.06);
    let mut chart = ChartBuilder::on(area)
        .margin(12 * FINE)
        .x_label_area_size(44 * FINE)
        .y_label_area_size(64 * FINE)
        .build_cartesian_2d(x.0..x.1, y.0..y.1)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12).stroke_width(FINE))
        .axis_style(BLACK.mix(0.5).stroke_width(FINE))
        .x_desc(axis)
        .y_desc(&panel.label)
        .axis_desc_style(font(15))
        .label_style(font(13))
        .set_all_tick_mark_size(5 * FINE)
        .x_label_formatter(&|value| short(*value, [x.0, x.1]))
        .y_label_formatter(&|value| short(*value, [y.0, y.1]))
        .draw()?;
    for curve in &panel.curves {
        let colour = colour(curve.index, combinations);
        for stretch in curve.stretches.iter().filter(|stretch| !stretch.is_empty()) {
            chart.draw_series(LineSeries::new(stretch.iter().copied(), colour.stroke_width(2 * FINE)))?;
            chart.draw_series(stretch.iter().map(|&point| Circle::new(point, 2 * FINE, colour.filled())))?;
        }
    }
    Ok(())
}

/// The range with a margin; one of no width gets some.
fn padded((low, high): (f64, f64), part: f64) -> (f64, f64) {
    let margin = if high > low { part * (high - low) } else { 0.5 * high.abs().max(1.0) };
    (low - margin, high + margin)
}

/// A number on an axis between two others, without the digits that are rounding.
fn short(value: f64, [low, high]: [f64; 2]) -> String {
    let rounded: f64 = format!("{value:.6e}").parse().unwrap_or(value);
    if rounded.abs() < CONSTANT * (high - low).abs() { "0".to_owned() } else { rounded.to_string() }
}

/// Colours from blue to red, told apart by lightness as well.
fn colour(index: usize, count: usize) -> HSLColor {
    let part = if count > 1 { index as f64 / (count - 1) as f64 } else { 0.0 };
    HSLColor(0.62 * (1.0 - part), 0.75, 0.36 + 0.12 * (1.0 - (2.0 * part - 1.0).abs()))
}

#[cfg(test)]
mod tests {
    use super::super::CONVERGED;
    use super::super::table::{Columns, Row};
    use super::*;

    fn outcome() -> Outcome {
        let row = |beta: &str, pressure: &str, status: &str, stroke: Option<f64>| Row {
            keys: vec![beta.into(), pressure.into()],
            status: status.into(),
            stable: Some(true),
            probes: vec![stroke, Some(1.0)],
            ..Row::default()
        };
        let columns = Columns {
            keys: vec!["beta (deg)".into(), "p".into()],
            probes: vec!["stroke".into(), "one".into()],
            units: vec!["mm".into(), String::new()],
        };
        let rows = vec![
            row("1", "10", CONVERGED, Some(1.0)),
            row("1", "20", CONVERGED, Some(2.0)),
            row("2", "10", "limit_point", Some(9.0)),
            row("2", "20", CONVERGED, Some(3.0)),
            row("3", "10", CONVERGED, Some(2.0)),
        ];
        Outcome { columns, rows, reused: 0, interrupted: false }
    }

    #[test]
    fn what_failed_leaves_a_gap_and_what_is_constant_no_panel() {
        let names = combinations(&outcome(), "beta (deg)");
        assert_eq!(names, ["p = 10", "p = 20"]);
        let panels = panels(&outcome(), "beta (deg)", &names);
        assert_eq!(panels.len(), 1);
        assert_eq!(panels[0].label, "stroke (mm)");
        assert_eq!(panels[0].curves[0].stretches, [vec![(1.0, 1.0)], vec![(3.0, 2.0)]]);
        assert_eq!(panels[0].curves[1].stretches, [vec![(1.0, 2.0), (2.0, 3.0)]]);
    }

    #[test]
    fn what_no_axis_can_hold_is_not_drawn() {
        let mut outcome = outcome();
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("sweep.svg");
        assert!(draw(&outcome, &plan(["beta=1:3:1 deg", "p=10,20"]), &path).unwrap());
        assert!(!draw(&outcome, &plan(["beta=-1e308,1e308", "p=10,20"]), &path).unwrap());
        outcome.rows.iter_mut().for_each(|row| row.probes[0] = row.probes[0].map(|value| value * 9e307));
        assert!(!draw(&outcome, &plan(["beta=1:3:1 deg", "p=10,20"]), &path).unwrap());
        assert_eq!([1e-15, 1e-24].map(|value| short(value, [0.0, 2e-15])), ["0.000000000000001", "0"]);
    }

    fn plan(vary: [&str; 2]) -> Plan {
        Plan::combinations(&vary.map(|text| text.parse().unwrap())).unwrap()
    }

    /// The widest line of a legend decides on the width of the picture.
    #[test]
    fn no_line_of_a_legend_is_cut() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("sweep.svg");
        let width = |outcome: &Outcome| -> f64 {
            draw(outcome, &plan(["beta=1:3:1 deg", "p=10,20"]), &path).unwrap();
            let svg = std::fs::read_to_string(&path).unwrap();
            svg.split("width=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
        };
        let mut long = outcome();
        long.columns.keys[1] = "a parameter with quite a long name".to_owned();
        assert!(width(&long) > width(&outcome()) + 150.0);
    }

    #[test]
    fn two_parameters_of_many_values_make_a_map() {
        let plan = plan(["beta=1:6:1 deg", "p=10:60:10"]);
        let row = |keys: &Vec<String>| Row {
            keys: keys.clone(),
            status: "converged".into(),
            probes: vec![keys[0].parse().ok(), Some(1.0)],
            ..Row::default()
        };
        let rows = plan.rows.iter().map(row).collect();
        let mapped = Outcome { rows, ..outcome() };
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("sweep.svg");
        assert!(draw(&mapped, &plan, &path).unwrap());
        let svg = std::fs::read_to_string(&path).unwrap();
        assert!(svg.matches("<rect").count() >= 36 + SHADES, "{svg}");
        for text in ["beta (deg)", "stroke (mm)", "#440154", "#FDE725"] {
            assert!(svg.contains(text), "{text}");
        }
    }

    #[test]
    fn the_picture_names_axes_units_and_curves() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("sweep.svg");
        assert!(draw(&outcome(), &plan(["beta=1:3:1 deg", "p=10,20"]), &path).unwrap());
        let svg = std::fs::read_to_string(&path).unwrap();
        for text in ["beta (deg)", "stroke (mm)", "p = 10", "p = 20"] {
            assert!(svg.contains(text), "{text} in {svg}");
        }
    }
}
