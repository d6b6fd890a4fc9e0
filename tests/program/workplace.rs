//! A folder to run the program in, networks for it, and what it says.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

/// A muscle.
pub(crate) const MUSCLE: &str = r#"
[muscles.silicone]
diameter = 13
wall = 2.0
pressure_unit = "psi"
density = 1.1e-9
table = [
  { pressure = 10, E = 3.60, alpha = -9.135e-3, R1 = 6.80, R2 = 7.90 },
  { pressure = 25, E = 4.25, alpha = -6.885e-3, R1 = 7.15, R2 = 8.90 },
]
"#;

/// Two of these muscles, without it.
pub(crate) const DYAD: &str = r#"format = "pennate/1"
title = "dyad"

[parameters]
L = 130
beta = 22

[nodes]
A = ["= -L * cos(beta)", "= -L * sin(beta)"]
B = ["= L * cos(beta)", "= -L * sin(beta)"]
J = [0, 0]

[members]
left = { nodes = ["A", "J"], muscle = "silicone" }
right = { nodes = ["B", "J"], muscle = "silicone" }

[supports]
A = "clamped"
B = "clamped"

[[steps]]
name = "inflate"
pressure = { all = 25 }

[[steps]]
name = "push back"
displacement = { J = { uy = 0.0 } }

[probes]
stroke = { node = "J", displacement = "uy" }
holding = { node = "J", reaction = "uy" }
"#;

/// A shallow arch of two struts that snaps through under its load.
pub(crate) const TOGGLE: &str = r#"format = "pennate/1"
dimension = "plane"
[nodes]
A = [-100, 0]
B = [100, 0]
J = [0, 4]
[materials]
steel = { youngs_modulus = 1000, poissons_ratio = 0.3 }
[sections]
strut = { circle = { radius = 1 } }
[members]
left = { nodes = ["A", "J"], section = "strut", material = "steel" }
right = { nodes = ["B", "J"], section = "strut", material = "steel" }
[supports]
A = "clamped"
B = "clamped"
[[steps]]
name = "pull"
force = { J = [0, 0.01, 0] }
[[steps]]
name = "push"
force = { J = [0, -0.2, 0] }
increments = 40
[[steps]]
name = "rest"
force = { J = [0, 0, 0] }
[probes]
depth = { node = "J", displacement = "uy" }
"#;

/// A folder that goes with the test.
pub(crate) struct Workplace {
    pub(crate) directory: TempDir,
}

impl Workplace {
    /// An empty folder.
    pub(crate) fn new() -> Self {
        Self { directory: tempfile::tempdir().unwrap() }
    }

    /// A path in it.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    /// Writes a file into it.
    pub(crate) fn file(&self, name: &str, text: &str) -> PathBuf {
        fs::write(self.path(name), text).unwrap();
        self.path(name)
    }

    /// The dyad as a file in it.
    pub(crate) fn dyad(&self) -> PathBuf {
        self.file("dyad.toml", &format!("{DYAD}{MUSCLE}"))
    }

    /// How many files are in it.
    pub(crate) fn entries(&self) -> usize {
        fs::read_dir(self.directory.path()).unwrap().count()
    }
}

/// The program, without standard input.
pub(crate) fn pennate() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pennate"));
    command.stdin(Stdio::null());
    command
}

/// The program, told to solve a file.
pub(crate) fn solve(file: &Path) -> Command {
    let mut command = pennate();
    command.arg("solve").arg(file);
    command
}

/// What it printed.
pub(crate) fn out(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).unwrap()
}

/// What it said.
pub(crate) fn err(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).unwrap()
}

/// It ended with a status, and without a panic.
#[track_caller]
pub(crate) fn expect(output: &Output, status: i32) {
    assert_eq!(output.status.code(), Some(status), "\n{}\n{}", out(output), err(output));
    assert!(!err(output).contains("panicked"), "{}", err(output));
}

/// The results that it wrote.
pub(crate) fn results(directory: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(directory.join("results.json")).unwrap()).unwrap()
}
