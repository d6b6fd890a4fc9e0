//! The error analysis as a picture: errors against the aspect ratio, with and without kinked states.

use std::error::Error;
use std::path::Path;

use pennate_analysis::fit::errors::{LengthErrors, by_length};
use pennate_analysis::fit::{Fitted, KINKED};
use plotters::coord::Shift;
use plotters::prelude::*;

const PANEL: (u32, u32) = (400, 340);
const LABELS: [&str; 3] = ["axial error (mm)", "bending error (mm)", "slope error (deg)"];
/// Half the width of the ends of an error bar, and the shift of one series against the other, in aspect ratios.
const WHISKER: f64 = 0.12;
const SHIFT: f64 = 0.1;

/// Draws mean and standard deviation over the pressures at every length.
///
/// # Errors
/// Where the file cannot be written.
pub fn draw(fitted: &Fitted, path: &Path) -> Result<(), Box<dyn Error>> {
    let all = by_length(fitted, None);
    let round = by_length(fitted, Some(KINKED));
    let series: Vec<(&[LengthErrors], &str, RGBColor)> = match all == round {
        true => vec![(&all, "all states", RGBColor(31, 78, 168))],
        false => {
            vec![(&all, "all states", RGBColor(31, 78, 168)), (&round, "without kinked states", RGBColor(192, 72, 24))]
        }
    };
    let area = SVGBackend::new(path, (3 * PANEL.0, PANEL.1)).into_drawing_area();
    area.fill(&WHITE)?;
    for (kind, panel) in area.split_evenly((1, 3)).iter().enumerate() {
        draw_panel(kind, &series, panel)?;
    }
    area.present()?;
    Ok(())
}

fn draw_panel(
    kind: usize,
    series: &[(&[LengthErrors], &str, RGBColor)],
    area: &DrawingArea<SVGBackend<'_>, Shift>,
) -> Result<(), Box<dyn Error>> {
    let all = || series.iter().flat_map(|(errors, ..)| errors.iter());
    let high = all().map(|e| e.mean[kind] + e.deviation[kind]).fold(0.0, f64::max);
    let ratios = all()
        .map(|e| e.aspect_ratio)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(56)
        .build_cartesian_2d(ratios.0 - 1.0..ratios.1 + 1.0, 0.0..1.15 * high.max(1e-9))?;
    chart
        .configure_mesh()
        .max_light_lines(1)
        .x_labels(6)
        .y_labels(6)
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12))
        .x_desc("aspect ratio L/D")
        .y_desc(LABELS[kind])
        .axis_desc_style(("sans-serif", 15))
        .label_style(("sans-serif", 13))
        .draw()?;
    for (index, (errors, name, colour)) in series.iter().enumerate() {
        let shift = SHIFT * (2.0 * index as f64 - (series.len() - 1) as f64);
        for e in *errors {
            let x = e.aspect_ratio + shift;
            let (low, high) = ((e.mean[kind] - e.deviation[kind]).max(0.0), e.mean[kind] + e.deviation[kind]);
            for bar in [
                vec![(x, low), (x, high)],
                vec![(x - WHISKER, low), (x + WHISKER, low)],
                vec![(x - WHISKER, high), (x + WHISKER, high)],
            ] {
                chart.draw_series([PathElement::new(bar, colour.mix(0.6))])?;
            }
        }
        let points: Vec<(f64, f64)> = errors.iter().map(|e| (e.aspect_ratio + shift, e.mean[kind])).collect();
        chart.draw_series(LineSeries::new(points.iter().copied(), colour.stroke_width(2)))?;
        chart.draw_series(points.iter().map(|&point| Circle::new(point, 3, colour.filled())))?;
        if kind == 0 {
            let y = 1.15 * high * (0.95 - 0.07 * index as f64);
            let x = ratios.0 - 0.8;
            chart.draw_series([PathElement::new(vec![(x, y), (x + 0.6, y)], colour.stroke_width(2))])?;
            chart.draw_series([Text::new((*name).to_owned(), (x + 0.75, y * 1.012), ("sans-serif", 13))])?;
        }
    }
    Ok(())
}
