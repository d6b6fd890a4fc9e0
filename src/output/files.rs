//! Files that are there whole or not at all.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

/// A file or directory that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {}", .path.display(), in_words(.source))]
pub struct WriteError {
    /// The file.
    pub path: PathBuf,
    /// What the system says.
    pub source: io::Error,
}

/// The system's own words, without its number.
fn in_words(error: &io::Error) -> String {
    let text = error.to_string();
    let text = text.split(" (os error").next().unwrap_or_default();
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

/// Writes a file beside its place and moves it there once it is complete.
///
/// # Errors
/// [`WriteError`] names the file; what stood at its place before is untouched then.
pub fn write_whole(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), WriteError> {
    let attempt = || -> io::Result<()> {
        let mut file = BufWriter::new(temporary_in(path.parent().unwrap_or(Path::new(".")))?);
        fill(&mut file)?;
        let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.persist(path)?;
        Ok(())
    };
    attempt().map_err(|source| WriteError { path: path.to_path_buf(), source })
}

/// Finds out before a long solve whether a directory, or the first one above it that exists, can be written.
///
/// # Errors
/// [`WriteError`] where it cannot.
pub fn check_writable(directory: &Path) -> Result<(), WriteError> {
    let existing = directory.ancestors().find(|path| path.exists()).unwrap_or(Path::new("."));
    let attempt = match existing.is_dir() {
        true => temporary_in(existing).map(drop),
        false => Err(io::Error::new(io::ErrorKind::NotADirectory, "there is a file of that name")),
    };
    attempt.map_err(|source| WriteError { path: directory.to_path_buf(), source })
}

/// Makes a directory with all that lie above it.
///
/// # Errors
/// [`WriteError`] where it cannot be made.
pub fn make_directory(directory: &Path) -> Result<(), WriteError> {
    fs::create_dir_all(directory).map_err(|source| WriteError { path: directory.to_path_buf(), source })
}

fn temporary_in(directory: &Path) -> io::Result<NamedTempFile> {
    let directory = if directory.as_os_str().is_empty() { Path::new(".") } else { directory };
    let mut builder = Builder::new();
    builder.prefix(".pennate-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666)); // the user's umask takes its part
    }
    builder.tempfile_in(directory)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_cannot_be_finished_leaves_nothing_behind() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("results.json");
        let failed = write_whole(&path, |file| {
            file.write_all(b"half")?;
            Err(io::Error::from(io::ErrorKind::StorageFull))
        });
        assert!(failed.unwrap_err().to_string().ends_with("results.json: no storage space"));
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_file_in_the_way_of_the_directory_is_noticed_before_the_solve() {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("taken");
        fs::write(&file, "").unwrap();
        assert!(check_writable(&directory.path().join("new/deep")).is_ok());
        assert!(check_writable(&file).unwrap_err().to_string().contains("there is a file of that name"));
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);
    }
}
