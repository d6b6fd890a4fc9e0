//! Writers of `pennate modes` and `pennate buckle`.

pub mod json;
pub mod table;
pub mod vtu;

use std::path::Path;

use pennate_analysis::spectrum::{Question, Spectrum};
use pennate_solver::spectral::unknowns::Family;

use super::files::{WriteError, make_directory, write_whole};

/// Writes `modes.json` or `buckling.json` into a directory and, if asked for, a picture of each mode.
///
/// # Errors
/// [`WriteError`] names the file that could not be written; no half file remains.
pub fn write_files(spectrum: &Spectrum, directory: &Path, name: &str, pictures: bool) -> Result<(), WriteError> {
    make_directory(directory)?;
    let file = match spectrum.question {
        Question::Modes => "modes.json",
        Question::Buckling => "buckling.json",
    };
    super::stale::clear(directory, name, file)?;
    let mut written = Vec::new();
    let pictures = if pictures { vtu::write(spectrum, directory, name, &mut written) } else { Ok(()) };
    let results = write_whole(&directory.join(file), |writer| json::write(spectrum, &written, writer));
    results.and(pictures)
}

/// Frequency in cycles per unit of time for ω²; nothing where the motion is no vibration.
pub fn frequency(eigenvalue: f64) -> Option<f64> {
    (eigenvalue >= 0.0).then(|| eigenvalue.sqrt() / std::f64::consts::TAU)
}

/// Name of a family in results.
pub fn family_name(family: Family) -> &'static str {
    match family {
        Family::Space => "space",
        Family::InPlane => "in_plane",
        Family::OutOfPlane => "out_of_plane",
    }
}
