//! Ways in which a network file can fail: what a [shrinker](crate::shrink) keeps while it takes the rest away.

use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::{Command, Stdio};

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_models::read_text;
use pennate_solver::options::Options;

use crate::increments::{Apart, SMALL, apart};
use crate::verdict::verdicts;

/// Difference of a probe that counts, over its value.
const PROBE: f64 = 1e-5;

/// What is wrong with a network.
#[derive(Clone, Debug, PartialEq)]
pub enum Failure {
    /// It ends elsewhere than in 100 increments: with another status, at another fraction, or in another state.
    Elsewhere,
    /// It ends with another status than in 100 increments.
    Status,
    /// Its lowest modes say other than its verdict on stability.
    Contradicted,
    /// Something panics.
    Panics,
    /// A probe has another value at the end than in 100 increments.
    Probe(String),
    /// A command of the shell, `{}` standing for the file, ends with status 0.
    Command(String),
}

impl Failure {
    /// Whether a network file fails so. What is refused does not.
    pub fn holds(&self, text: &str) -> bool {
        match self {
            Self::Elsewhere => apart(text).is_ok_and(|apart| apart.is_some()),
            Self::Status => matches!(apart(text), Ok(Some(Apart::Status(_)))),
            Self::Contradicted => {
                read_text("network.toml", text, &[]).is_ok_and(|model| !verdicts(model).contradicted.is_empty())
            }
            Self::Panics => catch_unwind(AssertUnwindSafe(|| end(text, None, "").is_some())).is_err(),
            Self::Probe(name) => match [None, Some(SMALL)].map(|increments| end(text, increments, name)) {
                [Some(a), Some(b)] => (a - b).abs() > PROBE * a.abs().max(b.abs()),
                _ => false,
            },
            Self::Command(command) => run(command, text).unwrap_or(false),
        }
    }
}

/// The value of a probe after the last step; zero where there is none.
fn end(text: &str, increments: Option<usize>, probe: &str) -> Option<f64> {
    let mut model = read_text("network.toml", text, &[]).ok()?;
    if increments.is_some() {
        model.steps.iter_mut().for_each(|step| step.increments = increments);
    }
    let options = Options { estimate: true, ..Options::default() };
    let solution = solve_to_accuracy(model, 1e-6, &options, &mut |_| true).ok()?;
    let last = *solution.model.step_names().last()?;
    if probe.is_empty() { Some(0.0) } else { solution.probe(probe, last) }
}

/// Whether the command ends with status 0 on the text.
fn run(command: &str, text: &str) -> std::io::Result<bool> {
    let mut file = tempfile::Builder::new().suffix(".toml").tempfile()?;
    file.write_all(text.as_bytes())?;
    file.flush()?;
    let command = command.replace("{}", &file.path().display().to_string());
    let status = Command::new("sh")
        .arg("-c")
        .arg(command)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()?;
    Ok(status.success())
}
