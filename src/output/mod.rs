//! Writers: each reads a solution and writes one kind of output.

mod acting;
pub mod critical;
pub mod csv;
pub mod drawing;
pub mod files;
pub mod flow;
pub mod json;
mod layout;
pub mod loads;
mod motion;
mod origin;
pub mod spectrum;
mod stale;
pub mod svg;
pub mod table;
pub mod text;
pub mod vtu;

use std::path::Path;
use std::time::Instant;

use files::{WriteError, make_directory, write_whole};
use pennate_analysis::solution::Solution;
pub use vtu::Pictures;

/// Writes the files of a run into a directory: `results.json`, `history.csv` and, if asked for, pictures.
///
/// Pictures that an earlier run left there under the same name go first: they are of another solution.
///
/// # Errors
/// [`WriteError`] names the file that could not be written; no half file remains.
pub fn write_files(
    solution: &mut Solution,
    directory: &Path,
    name: &str,
    pictures: Option<Pictures>,
) -> Result<(), WriteError> {
    let start = Instant::now();
    make_directory(directory)?;
    stale::clear(directory, name, "results.json")?;
    let history = write_whole(&directory.join("history.csv"), |writer| csv::write(solution, writer));
    let mut written = Vec::new();
    let pictures = match pictures {
        Some(which) => vtu::write(solution, directory, name, which, &mut written)
            .and_then(|()| critical::write(solution, directory, name, &mut written)),
        None => Ok(()),
    };
    solution.timing.write = start.elapsed();
    // The results come last for the sake of their timing, and come even where a picture did not find room.
    let results = write_whole(&directory.join("results.json"), |writer| json::write(solution, &written, writer));
    results.and(history).and(pictures)
}
