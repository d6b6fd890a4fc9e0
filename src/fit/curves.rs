//! Measured against fitted: what the tip does under loads, points from the data and curves from the muscle.

use std::error::Error;
use std::path::Path;

use pennate_analysis::fit::Fitted;
use pennate_analysis::fit::cantilever::{Cantilever, Load};
use pennate_analysis::fit::data::Case;
use plotters::coord::Shift;
use plotters::prelude::*;

use crate::output::svg::{self, FINE, font};
use crate::output::text::number;

const PANEL: (u32, u32) = (430, 360);
const LEGEND: u32 = 150;
/// Points of a curve.
const POINTS: usize = 41;

/// Load and motion of a kind of test, by their labels.
struct Kind {
    labels: [&'static str; 2],
    /// Component of the force.
    load: usize,
    /// Component of tip and slope, and where its motion begins.
    output: usize,
    /// Whether the motion is how far the tip is from the unloaded length.
    shortening: bool,
}

const KINDS: [Kind; 3] = [
    Kind { labels: ["force along the axis (N)", "shortening (mm)"], load: 0, output: 0, shortening: true },
    Kind { labels: ["force across the axis (N)", "deflection (mm)"], load: 1, output: 1, shortening: false },
    Kind { labels: ["force across the axis (N)", "slope (deg)"], load: 1, output: 2, shortening: false },
];

/// One pressure in one panel.
struct Series {
    measured: Vec<(f64, f64)>,
    fitted: Vec<(f64, f64)>,
}

/// Draws the load cases of the fitted length whose force is along or across the axis, at every pressure.
///
/// # Errors
/// Where the file cannot be written.
pub fn draw(fitted: &Fitted, path: &Path) -> Result<(), Box<dyn Error>> {
    let names: Vec<String> =
        fitted.rows.iter().map(|row| format!("{} {}", number(row.row.pressure), fitted.data.pressure_unit)).collect();
    svg::draw(path, (3 * PANEL.0 + LEGEND, PANEL.1), |area| {
        let (panels, legend) = area.split_horizontally(FINE * 3 * PANEL.0);
        for (kind, area) in KINDS.iter().zip(panels.split_evenly((1, 3))) {
            let series: Vec<Series> = (0..fitted.rows.len()).map(|index| series(fitted, index, kind)).collect();
            draw_panel(kind, &series, &area)?;
        }
        let fine = FINE as i32;
        for (index, name) in names.iter().enumerate() {
            let y = (30 + 20 * index as i32) * fine;
            let colour = colour(index, names.len());
            legend.draw(&PathElement::new([(10 * fine, y), (34 * fine, y)], colour.stroke_width(2 * FINE)))?;
            legend.draw(&Circle::new((22 * fine, y), 3 * FINE, colour.filled()))?;
            legend.draw(&Text::new(name.clone(), (42 * fine, y - 7 * fine), font(14)))?;
        }
        let y = (40 + 20 * names.len() as i32) * fine;
        legend.draw(&Text::new("points: measured", (10 * fine, y), font(13)))?;
        legend.draw(&Text::new("lines: fitted", (10 * fine, y + 18 * fine), font(13)))?;
        Ok(())
    })
}

fn series(fitted: &Fitted, index: usize, kind: &Kind) -> Series {
    let at = &fitted.selection.pressures[index];
    let length = fitted.selection.length;
    let pure = |case: &&Case| case.moment == 0.0 && case.force[1 - kind.load] == 0.0 && case.length == length;
    let motion = |tip: [f64; 3]| match kind.shortening {
        true => length - tip[0],
        false if kind.output == 2 => tip[2].to_degrees(),
        false => tip[kind.output],
    };
    let measured: Vec<(f64, f64)> = at
        .free
        .iter()
        .chain(&at.cases)
        .filter(pure)
        .map(|case| (case.force[kind.load], motion([case.tip[0], case.tip[1], case.slope])))
        .collect();
    let (low, high) = bounds(measured.iter().map(|point| point.0));
    let mut rod = Cantilever::new(&fitted.tube.muscle(fitted.rows[index].row), length);
    let load = |k: usize| {
        let value = low + (high - low) * k as f64 / (POINTS - 1) as f64;
        let mut force = [0.0; 2];
        force[kind.load] = value;
        (value, Load { force, moment: 0.0 })
    };
    let mut curve = |k: usize| {
        let (value, load) = load(k);
        let tip = rod.solve(&[load], false).ok()?[0].tip;
        Some((value, motion(tip)))
    };
    let fitted = if high > low { (0..POINTS).filter_map(&mut curve).collect() } else { Vec::new() };
    Series { measured, fitted }
}

fn draw_panel(kind: &Kind, series: &[Series], area: &DrawingArea<SVGBackend<'_>, Shift>) -> Result<(), Box<dyn Error>> {
    let all = || series.iter().flat_map(|series| series.measured.iter().chain(&series.fitted));
    let padded = |(low, high): (f64, f64)| match high > low {
        true => (low - 0.04 * (high - low), high + 0.04 * (high - low)),
        false => (-1.0, 1.0),
    };
    let (x, y) = (padded(bounds(all().map(|point| point.0))), padded(bounds(all().map(|point| point.1))));
    let mut chart = ChartBuilder::on(area)
        .margin(12 * FINE)
        .x_label_area_size(44 * FINE)
        .y_label_area_size(56 * FINE)
        .build_cartesian_2d(x.0..x.1, y.0..y.1)?;
    chart
        .configure_mesh()
        .max_light_lines(1)
        .x_labels(6)
        .y_labels(6)
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12).stroke_width(FINE))
        .axis_style(BLACK.mix(0.5).stroke_width(FINE))
        .x_desc(kind.labels[0])
        .y_desc(kind.labels[1])
        .axis_desc_style(font(15))
        .label_style(font(13))
        .set_all_tick_mark_size(5 * FINE)
        .draw()?;
    for (index, one) in series.iter().enumerate() {
        let colour = colour(index, series.len());
        chart.draw_series(LineSeries::new(one.fitted.iter().copied(), colour.stroke_width(2 * FINE)))?;
        chart.draw_series(one.measured.iter().map(|&point| Circle::new(point, 3 * FINE, colour.filled())))?;
    }
    Ok(())
}

fn bounds(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

fn colour(index: usize, count: usize) -> HSLColor {
    let part = if count > 1 { index as f64 / (count - 1) as f64 } else { 0.0 };
    HSLColor(0.62 * (1.0 - part), 0.75, 0.4)
}
