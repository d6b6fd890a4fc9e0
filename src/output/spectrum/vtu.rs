//! Pictures of modes: one `.vtu` a mode, points where the state has them, the mode as their displacement.
//!
//! A mode is scaled so that its largest displacement is a tenth of the network's extent: warped by its own displacement it
//! can be seen. Field data hold its number, its frequency (Hz) or factor, and the scale over the normalized mode.

use std::io::{self, Write};
use std::path::Path;

use pennate_analysis::spectrum::{Entry, Question, Spectrum};
use pennate_solver::modes::extent;

use super::frequency;
use crate::output::files::{WriteError, write_whole};
use crate::output::motion::{AMPLITUDE, Moving, Point, part};

/// Spin of a mode without displacements in a picture, radians.
const TURN: f64 = 0.5;

/// Writes `NAME_mode_01.vtu`, or `NAME_buckling_01.vtu`, … into a directory, so that one folder can hold both; adds their names.
///
/// # Errors
/// [`WriteError`] names the file that could not be written.
pub fn write(spectrum: &Spectrum, directory: &Path, name: &str, written: &mut Vec<String>) -> Result<(), WriteError> {
    let kind = match spectrum.question {
        Question::Modes => "mode",
        Question::Buckling => "buckling",
    };
    for (index, entry) in spectrum.entries.iter().enumerate() {
        let file = format!("{name}_{kind}_{:02}.vtu", index + 1);
        write_whole(&directory.join(&file), |writer| write_mode(spectrum, index, entry, writer))?;
        written.push(file);
    }
    Ok(())
}

fn write_mode(spectrum: &Spectrum, index: usize, entry: &Entry, writer: &mut dyn Write) -> io::Result<()> {
    let scale = picture_scale(spectrum, entry);
    let moving = Moving {
        model: &spectrum.model,
        nodes: &spectrum.place.nodes,
        members: &spectrum.place.members,
        controls: &spectrum.place.controls,
        node_motions: &entry.shape.nodes,
        member_motions: &entry.shape.members,
    };
    let data = |points: &[Point]| vec![part(points, "displacement", 0), part(points, "rotation", 3)];
    moving.write(scale, data, &fields(spectrum, index, entry, scale), writer)
}

fn picture_scale(spectrum: &Spectrum, entry: &Entry) -> f64 {
    let displacement = entry.shape.displacement();
    match entry.largest.component {
        0..3 if displacement > 0.0 => AMPLITUDE * extent(&spectrum.place) / displacement,
        _ => TURN / entry.largest.value.abs().max(f64::MIN_POSITIVE),
    }
}

fn fields(spectrum: &Spectrum, index: usize, entry: &Entry, scale: f64) -> Vec<(&'static str, f64)> {
    let mut values = vec![("mode", (index + 1) as f64)];
    match spectrum.question {
        Question::Modes => {
            values.push(("eigenvalue", entry.value));
            values.extend(frequency(entry.value).map(|hertz| ("frequency_hz", hertz)));
        }
        Question::Buckling => values.push(("factor", entry.value)),
    }
    values.push(("scale", scale));
    values
}
