//! What is wrong with an input file, where, and what would help.

use std::fmt;
use std::path::PathBuf;

/// A text that was read: the network file, or a file that it refers to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// As shown in messages: the path given by the user.
    pub name: String,
    /// Where it was read from; empty for a text that is no file.
    pub path: PathBuf,
    /// What was read.
    pub text: String,
}

impl Source {
    /// Line and column of a byte offset, both counted from one, columns in characters.
    pub fn line_column(&self, offset: usize) -> (usize, usize) {
        let before = &self.text.as_bytes()[..offset.min(self.text.len())];
        let line = before.iter().filter(|&&byte| byte == b'\n').count() + 1;
        let start = before.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
        (line, String::from_utf8_lossy(&before[start..]).chars().count() + 1)
    }
}

/// A place in a source: byte range `start..end` of the source with index `file`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    /// Index of the source.
    pub file: usize,
    /// First byte.
    pub start: usize,
    /// Byte behind the last one.
    pub end: usize,
}

/// One thing that is wrong with the input (or, as a warning, remarkable), in the user's words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputError {
    /// What is wrong, with the names of what it concerns; one sentence without a full stop.
    pub message: String,
    /// Where; `None` where no place in a file is to blame (a file that cannot be read, a `--set`).
    pub span: Option<Span>,
    /// A few words to stand under the marked place.
    pub label: Option<String>,
    /// What to do about it.
    pub help: Option<String>,
    /// The name that is to blame, where no place in a file is.
    pub name: Option<String>,
}

impl InputError {
    /// An error without place, to be completed by the methods below.
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), span: None, label: None, help: None, name: None }
    }

    /// The error with its place.
    pub fn at(mut self, span: Span) -> Self {
        self.span = Some(span);
        self
    }

    /// The error with a few words to stand under its place.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = Some(label.into());
        self
    }

    /// The error with the name that is to blame.
    pub fn about(mut self, name: impl Into<String>) -> Self {
        self.name = Some(name.into());
        self
    }

    /// The error with what to do about it.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for InputError {}

/// A remark on an input that can be solved all the same.
pub type Warning = InputError;

/// Everything that was found wrong in one reading, with the texts to show it in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputErrors {
    /// At least one, in the order found.
    pub errors: Vec<InputError>,
    /// What [`Span::file`] counts.
    pub sources: Vec<Source>,
}

impl InputErrors {
    /// File name, line and column of an error, where it has a place.
    pub fn place(&self, error: &InputError) -> Option<(&str, usize, usize)> {
        let span = error.span?;
        let source = self.sources.get(span.file)?;
        let (line, column) = source.line_column(span.start);
        Some((&source.name, line, column))
    }
}

impl fmt::Display for InputErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, error) in self.errors.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            if let Some((file, line, column)) = self.place(error) {
                write!(f, "{file}:{line}:{column}: ")?;
            }
            write!(f, "{error}")?;
            if let Some(help) = &error.help {
                write!(f, " (help: {help})")?;
            }
        }
        Ok(())
    }
}

impl std::error::Error for InputErrors {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_count_characters() {
        let source = Source { name: "a".into(), path: PathBuf::new(), text: "x = 1\nä = ?".into() };
        assert_eq!(source.line_column(0), (1, 1));
        assert_eq!(source.line_column(6 + "ä = ".len()), (2, 5));
        assert_eq!(source.line_column(10_000), (2, 6));
    }
}
