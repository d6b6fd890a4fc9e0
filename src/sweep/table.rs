//! `sweep.csv`: one row a combination of parameters, and what it takes to go on with it later.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Writer};
use serde::{Deserialize, Serialize};

use super::CONVERGED;
use crate::output::csv::head;
use crate::output::files::{WriteError, write_whole};

/// What a table belongs to: rows of another network, or of another accuracy, are of no use.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Name of the format.
    pub format: String,
    /// Version of the program.
    pub version: String,
    /// Mesh error asked for, relative.
    pub accuracy: f64,
    /// The texts of all files that were read.
    pub sources: Vec<(String, String)>,
}

/// Columns of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Columns {
    /// What tells rows from each other: file, where there are several, and parameters.
    pub keys: Vec<String>,
    /// Names of the probes, in the order of their columns.
    pub probes: Vec<String>,
    /// What the probes are measured in; empty where they have no unit.
    pub units: Vec<String>,
}

/// One row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Values of the key columns, as written.
    pub keys: Vec<String>,
    /// How the design ended.
    pub status: String,
    /// Whether the ends of all steps are stable; `None` where that is not known, or has no meaning.
    pub stable: Option<bool>,
    /// In the order of the probes; empty where there is no value.
    pub probes: Vec<Option<f64>>,
    /// Estimated error relative to the largest value of its kind.
    pub error: Option<f64>,
    /// Why there is no answer.
    pub reason: String,
}

impl Columns {
    fn header(&self) -> Vec<String> {
        let keys = self.keys.iter().cloned();
        let probes = self.probes.iter().zip(&self.units).map(|(name, unit)| head(name, unit));
        let words = |words: [&str; 2]| words.map(str::to_owned);
        keys.chain(words(["status", "stable"])).chain(probes).chain(words(["error", "reason"])).collect()
    }
}

impl Row {
    /// Whether the row is an answer: all its steps converged, and ended in states that the real network can be in.
    pub fn is_solved(&self) -> bool {
        self.status == CONVERGED && self.stable != Some(false)
    }

    fn record(&self) -> Vec<String> {
        let number = |value: &Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
        let mut record = self.keys.clone();
        record.push(self.status.clone());
        record.push(STABLE.iter().find(|(_, stable)| *stable == self.stable).map_or("", |known| known.0).to_owned());
        record.extend(self.probes.iter().map(number));
        // Two digits are more than an estimate has.
        record.push(self.error.map(|error| format!("{error:.1e}")).unwrap_or_default());
        record.push(self.reason.clone());
        record
    }

    fn from_record(record: &StringRecord, columns: &Columns) -> Option<Self> {
        if record.len() != columns.header().len() {
            return None;
        }
        let number = |text: &str| if text.is_empty() { Some(None) } else { text.parse().ok().map(Some) };
        let fields: Vec<&str> = record.iter().collect();
        let (keys, rest) = fields.split_at(columns.keys.len());
        let (probes, end) = rest[2..].split_at(columns.probes.len());
        Some(Self {
            stable: STABLE.iter().find(|(word, _)| *word == rest[1])?.1,
            keys: keys.iter().map(|&key| key.to_owned()).collect(),
            status: rest[0].to_owned(),
            probes: probes.iter().map(|text| number(text)).collect::<Option<_>>()?,
            error: number(end[0])?,
            reason: end[1].to_owned(),
        })
    }
}

/// How the end of a row's steps is called in the table.
const STABLE: [(&str, Option<bool>); 3] = [("yes", Some(true)), ("no", Some(false)), ("", None)];

/// What an earlier run left in a directory.
#[derive(Clone, Debug, PartialEq)]
pub enum Earlier {
    /// There is none.
    None,
    /// Rows of the same sweep, by their keys.
    Same(HashMap<Vec<String>, Row>),
    /// A table of something else, and what is different.
    Other(&'static str),
}

/// Looks at the table that there is in a directory.
pub fn earlier(directory: &Path, manifest: &Manifest, columns: &Columns) -> Earlier {
    let path = directory.join("sweep.csv");
    if !path.exists() {
        return Earlier::None;
    }
    let known = std::fs::read_to_string(directory.join("sweep.json")).ok();
    let known: Option<Manifest> = known.and_then(|text| serde_json::from_str(&text).ok());
    match known {
        None => return Earlier::Other("there is no sweep.json that says what it belongs to"),
        Some(known) if known.sources != manifest.sources => {
            return Earlier::Other("its network or what was set in it was different");
        }
        Some(known) if known.accuracy != manifest.accuracy => return Earlier::Other("its accuracy was different"),
        Some(known) if known != *manifest => return Earlier::Other("another version of pennate wrote it"),
        Some(_) => {}
    }
    let reader = ReaderBuilder::new().flexible(true).from_path(path);
    let Ok(mut reader) = reader else { return Earlier::Other("it cannot be read") };
    if reader.headers().is_ok_and(|header| header.iter().ne(columns.header().iter().map(String::as_str))) {
        return Earlier::Other("its columns are different");
    }
    // A run that was cut off may have left half a row at the end.
    let rows = reader.records().map_while(Result::ok).filter_map(|record| Row::from_record(&record, columns));
    let rows = rows.filter(|row| row.status != "interrupted");
    Earlier::Same(rows.map(|row| (row.keys.clone(), row)).collect())
}

/// A table that grows while the sweep runs, so that nothing solved is lost.
pub struct Journal {
    writer: Writer<File>,
}

impl Journal {
    /// Begins the table anew with the rows that are known already.
    ///
    /// # Errors
    /// Where the directory cannot be written.
    pub fn begin<'a>(
        directory: &Path,
        manifest: &Manifest,
        columns: &Columns,
        known: impl Iterator<Item = &'a Row>,
    ) -> Result<Self, WriteError> {
        write_table(directory, columns, known)?;
        write_whole(&directory.join("sweep.json"), |out| Ok(serde_json::to_writer_pretty(out, manifest)?))?;
        let path = directory.join("sweep.csv");
        let file = File::options().append(true).open(&path).map_err(|source| WriteError { path, source })?;
        Ok(Self { writer: Writer::from_writer(file) })
    }

    /// Adds a row.
    ///
    /// # Errors
    /// Those of the file.
    pub fn add(&mut self, row: &Row) -> io::Result<()> {
        self.writer.write_record(row.record())?;
        self.writer.flush()
    }
}

/// Writes the whole table.
///
/// # Errors
/// Where the directory cannot be written.
pub fn write_table<'a>(
    directory: &Path,
    columns: &Columns,
    rows: impl Iterator<Item = &'a Row>,
) -> Result<(), WriteError> {
    write_whole(&directory.join("sweep.csv"), |out| {
        let mut writer = Writer::from_writer(out as &mut dyn Write);
        writer.write_record(columns.header())?;
        for row in rows {
            writer.write_record(row.record())?;
        }
        writer.flush()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn manifest() -> Manifest {
        let sources = vec![("a.toml".to_owned(), "text".to_owned())];
        Manifest { format: "pennate-sweep/1".into(), version: "1".into(), accuracy: 1e-6, sources }
    }

    fn columns() -> Columns {
        Columns {
            keys: vec!["beta".into()],
            probes: vec!["stroke".into(), "f, \"N\"".into()],
            units: vec!["mm".into(), String::new()],
        }
    }

    fn row(beta: &str) -> Row {
        Row {
            keys: vec![beta.into()],
            status: "converged".into(),
            stable: Some(true),
            probes: vec![Some(1.0 / 3.0), None],
            error: Some(2e-7),
            reason: "one,\n\"two\"".into(),
        }
    }

    #[test]
    fn what_was_solved_is_found_again() {
        let directory = tempfile::tempdir().unwrap();
        let mut journal = Journal::begin(directory.path(), &manifest(), &columns(), [row("1")].iter()).unwrap();
        journal.add(&row("2")).unwrap();
        // Cut off in the middle of a row.
        let mut file = File::options().append(true).open(directory.path().join("sweep.csv")).unwrap();
        file.write_all(b"3,conv").unwrap();
        let Earlier::Same(found) = earlier(directory.path(), &manifest(), &columns()) else { panic!("not found") };
        assert_eq!(found.len(), 2);
        assert_eq!(found[&vec!["2".to_owned()]], row("2"));
    }

    #[test]
    fn rows_of_another_network_are_not_taken() {
        let directory = tempfile::tempdir().unwrap();
        Journal::begin(directory.path(), &manifest(), &columns(), [row("1")].iter()).unwrap();
        let mut other = manifest();
        other.sources[0].1 = "another text".into();
        let why = |manifest: &Manifest, columns: &Columns| match earlier(directory.path(), manifest, columns) {
            Earlier::Other(why) => why,
            found => panic!("{found:?}"),
        };
        assert!(why(&other, &columns()).contains("network"));
        let fewer = Columns { probes: vec!["stroke".into()], units: vec![String::new()], ..columns() };
        assert!(why(&manifest(), &fewer).contains("columns"));
        std::fs::remove_file(directory.path().join("sweep.json")).unwrap();
        assert!(why(&manifest(), &columns()).contains("sweep.json"));
    }
}
