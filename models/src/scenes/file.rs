//! A network file in the making: tables of lines, written in the order a person reads them.

use std::fmt;

/// Tables in the order in which they are written; steps follow, probes come last.
const TABLES: [&str; 8] =
    ["parameters", "nodes", "materials", "sections", "muscles", "members", "rigid_bodies", "supports"];

/// A network file in the making.
#[derive(Clone, Debug, Default)]
pub struct NetworkFile {
    title: String,
    /// Comments at the top, one a line.
    remarks: Vec<String>,
    dimension: Option<&'static str>,
    tables: Vec<(&'static str, Vec<Entry>)>,
    patterns: Vec<Vec<String>>,
    steps: Vec<Vec<String>>,
    probes: Vec<Entry>,
}

/// A line of a table.
#[derive(Clone, Debug)]
struct Entry {
    key: String,
    value: String,
    remark: String,
}

impl NetworkFile {
    /// A file with a title and nothing in it.
    pub fn new(title: &str) -> Self {
        Self { title: title.to_owned(), ..Self::default() }
    }

    /// A comment at the top of the file.
    pub fn remark(&mut self, text: &str) {
        self.remarks.extend(text.lines().map(|line| line.trim().to_owned()));
    }

    /// Solves in space even where everything lies in the plane.
    pub fn in_space(&mut self) {
        self.dimension = Some("space");
    }

    /// Adds a line to a table, with a comment or `""`.
    pub fn line(&mut self, table: &'static str, key: impl Into<String>, value: impl Into<String>, remark: &str) {
        let entry = Entry { key: key.into(), value: value.into(), remark: remark.to_owned() };
        match self.tables.iter_mut().find(|(name, _)| *name == table) {
            Some((_, entries)) => entries.push(entry),
            None => self.tables.push((table, vec![entry])),
        }
    }

    /// A parameter that follows from others.
    pub fn derived(&mut self, name: &str, formula: &str, remark: &str) {
        self.line("parameters", name, format!("\"= {formula}\""), remark);
    }

    /// A node; coordinates are numbers or, beginning with `=`, expressions.
    pub fn node<const N: usize>(&mut self, name: impl Into<String>, coordinates: [&str; N], remark: &str) {
        self.line("nodes", name, format!("[{}]", coordinates.map(quoted).join(", ")), remark);
    }

    /// A member: its nodes, and what else stands between the braces, such as `muscle = "silicone"`.
    pub fn member(&mut self, name: impl Into<String>, nodes: [&str; 2], rest: &str) {
        self.line("members", name, format!("{{ nodes = [\"{}\", \"{}\"], {rest} }}", nodes[0], nodes[1]), "");
    }

    /// A support: its node, what it holds, and a comment or `""`.
    pub fn support(&mut self, node: impl Into<String>, held: &str, remark: &str) {
        self.line("supports", node, held, remark);
    }

    /// Copies of what stands above: the lines of one entry of `[[patterns]]`.
    pub fn pattern(&mut self, lines: &[String]) {
        self.patterns.push(lines.to_vec());
    }

    /// A step: its name and its lines.
    pub fn step(&mut self, name: &str, lines: &[&str]) {
        let name = format!("name = \"{name}\"");
        self.steps.push(std::iter::once(name).chain(lines.iter().map(|line| (*line).to_owned())).collect());
    }

    /// A probe; one beginning with `=` is an expression.
    pub fn probe(&mut self, name: &str, value: &str, remark: &str) {
        let value = quoted(value);
        self.probes.push(Entry { key: name.to_owned(), value, remark: remark.to_owned() });
    }
}

/// An expression in quotes; anything else as it is.
fn quoted(text: &str) -> String {
    if text.starts_with('=') { format!("\"{text}\"") } else { text.to_owned() }
}

impl fmt::Display for NetworkFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for remark in &self.remarks {
            writeln!(f, "{}", format!("# {remark}").trim_end())?;
        }
        writeln!(f, "format = \"pennate/1\"\ntitle = \"{}\"", self.title)?;
        if let Some(dimension) = self.dimension {
            writeln!(f, "dimension = \"{dimension}\"")?;
        }
        for name in TABLES {
            if let Some((_, entries)) = self.tables.iter().find(|(table, _)| *table == name) {
                writeln!(f, "\n[{name}]")?;
                write_entries(f, entries)?;
            }
        }
        for (header, blocks) in [("patterns", &self.patterns), ("steps", &self.steps)] {
            for lines in blocks {
                writeln!(f, "\n[[{header}]]")?;
                lines.iter().try_for_each(|line| writeln!(f, "{line}"))?;
            }
        }
        if !self.probes.is_empty() {
            writeln!(f, "\n[probes]")?;
            write_entries(f, &self.probes)?;
        }
        Ok(())
    }
}

/// Lines with their comments below each other.
fn write_entries(f: &mut fmt::Formatter<'_>, entries: &[Entry]) -> fmt::Result {
    /// Longer lines do not push the comments of the others to the right.
    const WIDEST: usize = 64;
    let lines: Vec<String> = entries.iter().map(|entry| format!("{} = {}", entry.key, entry.value)).collect();
    let with_remark = lines.iter().zip(entries).filter(|(_, entry)| !entry.remark.is_empty());
    let width = with_remark.map(|(line, _)| line.chars().count()).filter(|&width| width <= WIDEST).max().unwrap_or(0);
    for (line, entry) in lines.iter().zip(entries) {
        match entry.remark.as_str() {
            "" => writeln!(f, "{line}")?,
            remark => writeln!(f, "{line:width$}  # {remark}")?,
        }
    }
    Ok(())
}
