//! Results of the program, as a user of `--json` has them.

use std::ffi::OsStr;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// What a command of the program prints for a network file with `--json` and more arguments.
///
/// # Errors
/// What it says where it prints no results.
pub fn results(program: &str, command: &str, file: &Path, more: &[impl AsRef<OsStr>]) -> Result<Value, String> {
    let output = Command::new(program).arg(command).arg(file).arg("--json").args(more).output();
    let output = output.map_err(|error| format!("{program} cannot be started: {error}"))?;
    serde_json::from_slice(&output.stdout)
        .map_err(|_| format!("no results: {}", String::from_utf8_lossy(&output.stderr).trim()))
}

/// Parameters, as arguments.
pub fn settings(set: &[(String, String)]) -> Vec<String> {
    set.iter().map(|(name, value)| format!("--set={name}={value}")).collect()
}
