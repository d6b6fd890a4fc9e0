//! Pictures drawn finer than their pixels: curves are smooth, and not made of whole ones.

use std::error::Error;
use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;

/// What is drawn with is this many times smaller than a pixel: every size is to be multiplied by it.
pub const FINE: u32 = 10;

/// The font of all texts, of a size in pixels.
pub fn font(size: u32) -> TextStyle<'static> {
    ("sans-serif", FINE * size).into_font().color(&BLACK)
}

/// Draws a picture of so many pixels on a white ground into a file.
///
/// # Errors
/// Those of drawing and of writing the file.
pub fn draw(
    path: &Path,
    size: (u32, u32),
    fill: impl FnOnce(&DrawingArea<SVGBackend<'_>, Shift>) -> Result<(), Box<dyn Error>>,
) -> Result<(), Box<dyn Error>> {
    std::fs::write(path, text(size, fill)?)?;
    Ok(())
}

/// The same as a text.
///
/// # Errors
/// Those of drawing.
pub fn text(
    (width, height): (u32, u32),
    fill: impl FnOnce(&DrawingArea<SVGBackend<'_>, Shift>) -> Result<(), Box<dyn Error>>,
) -> Result<String, Box<dyn Error>> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, (FINE * width, FINE * height)).into_drawing_area();
        area.fill(&WHITE)?;
        fill(&area)?;
        area.present()?;
    }
    // The view box stays as fine as it was drawn; the picture has the size in pixels.
    let fine = format!("width=\"{}\" height=\"{}\" viewBox", FINE * width, FINE * height);
    let coarse = format!("width=\"{width}\" height=\"{height}\" viewBox");
    Ok(text.replacen(&fine, &coarse, 1))
}
