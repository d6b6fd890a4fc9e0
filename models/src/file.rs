//! Texts of a user's files, read within reason.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Bytes of a file at most: a network of a million members needs less.
const LIMIT: u64 = 256 << 20;
/// The byte order mark.
const MARK: &[u8] = "\u{feff}".as_bytes();

/// Where the files come from that a network refers to.
#[derive(Clone, Debug, Default)]
pub(crate) struct Folder {
    /// Where their paths begin.
    pub(crate) directory: PathBuf,
    /// Texts that are known already, by their paths: what stands there now does not matter.
    pub(crate) known: Arc<HashMap<PathBuf, String>>,
}

impl Folder {
    pub(crate) fn at(directory: &Path) -> Self {
        Self { directory: directory.to_owned(), known: Arc::default() }
    }

    /// The path of a file, and its text.
    pub(crate) fn read(&self, name: &str) -> (PathBuf, io::Result<String>) {
        let path = self.directory.join(name);
        let text = self.known.get(&path).cloned().map_or_else(|| read(&path), Ok);
        (path, text)
    }
}

/// The text of a file.
///
/// # Errors
/// Those of the system; a file of more than 256 MiB, which is refused before it takes memory; bytes that are no text.
pub fn read(path: &Path) -> io::Result<String> {
    let file = File::open(path)?;
    // Only files of a known size: a pipe has none.
    if file.metadata()?.len() > LIMIT {
        return Err(too_large());
    }
    read_from(file)
}

/// The text that a reader holds up to its end, of a pipe or of standard input for instance.
///
/// # Errors
/// Those of [`read`].
pub fn read_from(reader: impl Read) -> io::Result<String> {
    let mut bytes = Vec::new();
    if reader.take(LIMIT + 1).read_to_end(&mut bytes)? as u64 > LIMIT {
        return Err(too_large());
    }
    // A parser would find fault with every one of them.
    if bytes.contains(&0) {
        return Err(io::Error::new(io::ErrorKind::InvalidData, "it holds zero bytes and is no text"));
    }
    // Some editors begin every file with this mark, which says no more than that it is UTF-8.
    if bytes.starts_with(MARK) {
        bytes.drain(..MARK.len());
    }
    String::from_utf8(bytes).map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is no text in UTF-8"))
}

fn too_large() -> io::Error {
    io::Error::new(io::ErrorKind::FileTooLarge, format!("it is larger than {} MiB", LIMIT >> 20))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_end_is_refused() {
        assert_eq!(read_from(io::repeat(b'#')).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert_eq!(read_from(&b"a\0b"[..]).unwrap_err().kind(), io::ErrorKind::InvalidData);
        assert_eq!(read_from(&b"\xff"[..]).unwrap_err().kind(), io::ErrorKind::InvalidData);
        assert_eq!(read_from("ä".as_bytes()).unwrap(), "ä");
    }

    #[test]
    fn a_byte_order_mark_is_no_part_of_the_text() {
        assert_eq!(read_from("\u{feff}a = 1".as_bytes()).unwrap(), "a = 1");
    }
}
