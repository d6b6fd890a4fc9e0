//! Writers: each reads a solution and writes one kind of output.

pub mod critical;
pub mod csv;
pub mod files;
pub mod json;
mod layout;
mod motion;
pub mod spectrum;
pub mod table;
pub mod text;
pub mod vtu;

use std::path::Path;
use std::time::Instant;

use crate::solution::Solution;
use files::{WriteError, make_directory, write_whole};

/// Writes the files of a run into a directory: `results.json`, `history.csv` and, if asked for, pictures.
///
/// # Errors
/// [`WriteError`] names the file that could not be written; no half file remains.
pub fn write_files(solution: &mut Solution, directory: &Path, name: &str, pictures: bool) -> Result<(), WriteError> {
    let start = Instant::now();
    make_directory(directory)?;
    let history = write_whole(&directory.join("history.csv"), |writer| csv::write(solution, writer));
    let pictures = match pictures {
        true => vtu::write(solution, directory, name).and_then(|()| critical::write(solution, directory, name)),
        false => Ok(()),
    };
    solution.timing.write = start.elapsed();
    // The results come last for the sake of their timing, and come even where a picture did not find room.
    let results = write_whole(&directory.join("results.json"), |writer| json::write(solution, writer));
    results.and(history).and(pictures)
}
