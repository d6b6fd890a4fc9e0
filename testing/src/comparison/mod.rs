//! Runs the network files of a validation folder and compares every result with its reference;
//! `validation/README.md` explains the files.

mod expected;
mod scales;

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

pub use expected::Run;
use expected::{Check, Expected, Step};
use scales::{Scales, largest, network_size, numbers};

/// True errors below this, relative, say nothing about the estimate: they hold rounding too.
pub const ESTIMATE_FLOOR: f64 = 1e-9;

/// Which mesh the solver is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// `--accuracy` left out.
    Default,
    /// `--accuracy 1e-10`
    Fine,
}

impl Setting {
    /// What the command line is told, if anything.
    pub fn accuracy(self) -> Option<&'static str> {
        match self {
            Self::Default => None,
            Self::Fine => Some("1e-10"),
        }
    }

    /// Largest relative error that passes unless a run states its own.
    fn tolerance(self) -> f64 {
        match self {
            Self::Default => 1e-5,
            Self::Fine => 1e-8,
        }
    }
}

/// A folder of `validation/`.
#[derive(Debug)]
pub struct Case {
    /// Of the folder.
    pub name: String,
    folder: PathBuf,
    expected: Expected,
    reference: Value,
}

/// How far one quantity is from its reference.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name of the step.
    pub step: String,
    /// What was compared: a quantity of a node, or a probe.
    pub quantity: String,
    /// displacement, rotation, force or moment.
    pub kind: String,
    /// Largest difference of a component, in the units of the quantity.
    pub error: f64,
    /// What the error is relative to, in the units of the quantity.
    pub scale: f64,
    /// The error that the solver expects, where it gives one.
    pub estimate: Option<f64>,
}

impl Row {
    /// The error over its scale.
    pub fn relative(&self) -> f64 {
        if self.error == 0.0 { 0.0 } else { self.error / self.scale }
    }
}

/// A run and everything that was compared in it.
#[derive(Debug)]
pub struct Outcome {
    /// The network file with its parameters, as on a command line.
    pub label: String,
    /// Which mesh was asked for.
    pub setting: Setting,
    /// Largest relative error that passes.
    pub tolerance: f64,
    /// All quantities that were compared.
    pub rows: Vec<Row>,
    /// What is wrong besides the numbers: a step that did not converge, a state that is not stable.
    pub faults: Vec<String>,
    /// Elements of the last mesh.
    pub elements: u64,
    /// Factorizations of all steps.
    pub factorizations: u64,
    /// Time of the solver on every mesh that it tried (s).
    pub solve_seconds: f64,
}

impl Outcome {
    /// The quantity with the largest relative error.
    pub fn worst(&self) -> Option<&Row> {
        self.rows.iter().max_by(|a, b| a.relative().total_cmp(&b.relative()))
    }

    /// The estimate that is farthest from its true error, and the factor (above 1: the error is larger).
    pub fn worst_estimate(&self) -> Option<(f64, &Row)> {
        let factors = self
            .rows
            .iter()
            .filter(|row| row.relative() > ESTIMATE_FLOOR)
            .filter_map(|row| row.estimate.map(|estimate| (row.error / estimate, row)));
        factors.max_by(|a, b| a.0.ln().abs().total_cmp(&b.0.ln().abs()))
    }

    /// Everything that makes this run fail, one line each.
    pub fn failures(&self) -> Vec<String> {
        let mut failures = self.faults.clone();
        for row in self.rows.iter().filter(|row| row.relative().is_nan() || row.relative() > self.tolerance) {
            failures.push(format!(
                "{}, {}: relative error {:.1e}, allowed {:.0e}",
                row.step,
                row.quantity,
                row.relative(),
                self.tolerance
            ));
        }
        failures
    }
}

impl Case {
    /// Reads a folder of `validation/`.
    pub fn open(name: &str) -> Self {
        let folder = validation().join(name);
        let text = |file: &str| {
            let path = folder.join(file);
            fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
        };
        let expected = toml::from_str(&text("expected.toml")).unwrap_or_else(|error| panic!("{name}: {error}"));
        let reference = serde_json::from_str(&text("reference.json")).unwrap_or_else(|error| panic!("{name}: {error}"));
        Self { name: name.to_owned(), expected, reference, folder }
    }

    /// Names of all folders with expected results, in order.
    pub fn names() -> Vec<String> {
        let folders = fs::read_dir(validation()).expect("validation/ can be read").flatten();
        let mut names: Vec<_> = folders
            .filter(|folder| folder.path().join("expected.toml").is_file())
            .filter_map(|folder| folder.file_name().into_string().ok())
            .collect();
        names.sort();
        names
    }

    /// The solves of the folder.
    pub fn runs(&self) -> &[Run] {
        &self.expected.run
    }

    /// Solves one run with `solve` (file, parameters, accuracy → results) and compares it.
    pub fn compare(
        &self,
        run: &Run,
        setting: Setting,
        solve: impl FnOnce(&Path, &[(String, String)], Option<&str>) -> Result<Value, String>,
    ) -> Outcome {
        let set: Vec<_> = run.set.iter().map(|(name, value)| (name.clone(), value.to_string())).collect();
        let stated = if setting == Setting::Default { run.tolerance } else { run.fine_tolerance };
        let mut outcome = Outcome {
            label: set.iter().fold(run.network.clone(), |label, (name, value)| format!("{label} {name}={value}")),
            setting,
            tolerance: stated.unwrap_or(setting.tolerance()),
            rows: Vec::new(),
            faults: Vec::new(),
            elements: 0,
            factorizations: 0,
            solve_seconds: 0.0,
        };
        match solve(&self.folder.join(&run.network), &set, setting.accuracy()) {
            Ok(results) => self.fill(&mut outcome, run, &results),
            Err(message) => outcome.faults.push(message),
        }
        outcome
    }

    fn fill(&self, outcome: &mut Outcome, run: &Run, results: &Value) {
        outcome.elements = results["mesh"]["elements"].as_u64().unwrap_or(0);
        outcome.solve_seconds = results["timing"]["solve_s"].as_f64().unwrap_or(0.0);
        let steps = results["steps"].as_array().map_or(&[][..], Vec::as_slice);
        outcome.factorizations = steps.iter().filter_map(|step| step["factorizations"].as_u64()).sum();
        let scales = self.run_scales(run, steps);
        for step in &run.steps {
            let Some(result) = steps.iter().find(|result| result["name"] == step.name.as_str()) else {
                outcome.faults.push(format!("{}: not in the results", step.name));
                continue;
            };
            if result["status"] != "converged" {
                outcome.faults.push(format!("{}: {}", step.name, result["status"]));
                continue;
            }
            if let Some(stable) = step.stable
                && result["stable"] != stable
            {
                outcome.faults.push(format!("{}: stable is {}", step.name, result["stable"]));
            }
            if let (Some(most), Setting::Default) = (step.max_factorizations, outcome.setting)
                && result["factorizations"].as_u64().is_none_or(|count| count > most)
            {
                outcome.faults.push(format!(
                    "{}: {} factorizations, at most {most} expected",
                    step.name, result["factorizations"]
                ));
            }
            self.compare_step(outcome, run, step, result, &scales);
        }
    }

    fn compare_step(&self, outcome: &mut Outcome, run: &Run, step: &Step, result: &Value, run_scales: &Scales) {
        let scales = self.step_scales(run, step, result).at_least(run_scales);
        // Checks of one computed quantity (its components, say) share one row: its estimate is one number.
        let mut rows: Vec<Row> = Vec::new();
        for check in self.checks(step) {
            let reference = self.reference(run, step, check);
            let Some(computed) = check.computed(result) else {
                outcome.faults.push(format!("{}: no {}", step.name, check.label()));
                continue;
            };
            let computed: Vec<_> = computed.iter().map(|value| value * check.factor).collect();
            assert_eq!(computed.len(), reference.len(), "{}: components of {}", self.name, check.reference);
            let row = Row {
                step: step.name.clone(),
                quantity: check.label(),
                kind: check.kind().to_owned(),
                error: largest(computed.iter().zip(&reference).map(|(computed, reference)| computed - reference)),
                scale: scales.of(check.kind()),
                estimate: check.estimate(result).map(|estimate| estimate * check.factor.abs()),
            };
            match rows.iter_mut().find(|other| other.quantity == row.quantity && other.kind == row.kind) {
                Some(other) if row.error.is_nan() || row.error > other.error => *other = row,
                Some(_) => {}
                None => rows.push(row),
            }
        }
        outcome.rows.extend(rows);
    }

    fn checks(&self, step: &Step) -> &[Check] {
        let checks = self.expected.checks.get(&step.check);
        checks.unwrap_or_else(|| panic!("{}: no list of checks '{}'", self.name, step.check))
    }

    fn pointer(&self, run: &Run, step: &Step, check: &Check) -> String {
        let at = step.at.as_ref().or(run.at.as_ref());
        let at = at.unwrap_or_else(|| panic!("{}: step '{}' says not where its reference is", self.name, step.name));
        format!("{at}/{}", check.reference)
    }

    fn reference(&self, run: &Run, step: &Step, check: &Check) -> Vec<f64> {
        let pointer = self.pointer(run, step, check);
        let value = self.reference.pointer(&pointer).and_then(numbers);
        value.unwrap_or_else(|| panic!("{}: no number at {pointer} of reference.json", self.name))
    }

    /// The largest reference of every kind in all results of a run.
    fn run_scales(&self, run: &Run, results: &[Value]) -> Scales {
        let mut scales = Scales::default();
        for step in &run.steps {
            if let Some(result) = results.iter().find(|result| result["name"] == step.name.as_str()) {
                scales.include(&self.step_scales(run, step, result));
            }
        }
        scales.couple(results.first().map_or(1.0, network_size));
        scales
    }

    /// The largest reference of every kind in one result.
    fn step_scales(&self, run: &Run, step: &Step, result: &Value) -> Scales {
        let mut scales = Scales::default();
        for check in self.checks(step) {
            let mut reference = self.reference(run, step, check);
            if check.quantity.as_deref() == Some("position") {
                // A position is measured from the unloaded one, as the displacement that it is.
                let node = &result["nodes"][check.node.as_deref().unwrap_or_default()];
                let unloaded = numbers(&node["position"]).zip(numbers(&node["displacement"]));
                if let Some((position, displacement)) = unloaded {
                    for (i, value) in reference.iter_mut().enumerate() {
                        *value -= position[i] - displacement[i];
                    }
                }
            }
            scales.raise(check.kind(), largest(reference.into_iter()));
        }
        scales
    }

    /// Places of `reference.json` that hold a result and that no check looks at.
    pub fn unchecked(&self) -> Vec<String> {
        let mut used = Vec::new();
        for run in &self.expected.run {
            for step in &run.steps {
                used.extend(self.checks(step).iter().map(|check| self.pointer(run, step, check)));
            }
        }
        let mut places = Vec::new();
        for (key, value) in self.reference.as_object().into_iter().flatten() {
            for (i, result) in value.as_array().into_iter().flatten().enumerate() {
                if key.starts_with("results") {
                    let (below, quantities) = match result.get("quantities") {
                        Some(quantities) => ("/quantities", quantities),
                        None => ("", result),
                    };
                    leaves(quantities, format!("/{key}/{i}{below}"), &mut places);
                }
            }
        }
        let covered = |place: &String, pattern: &String| {
            let (mut place, pattern) = (place.split('/'), pattern.split('/'));
            pattern.into_iter().all(|name| place.next().is_some_and(|part| name == "*" || part == name))
        };
        places.retain(|place| !used.iter().chain(&self.expected.not_compared).any(|pattern| covered(place, pattern)));
        places
    }
}

fn validation() -> PathBuf {
    crate::repository("validation")
}

fn leaves(value: &Value, place: String, places: &mut Vec<String>) {
    match value {
        Value::Object(entries) => {
            for (key, value) in entries {
                leaves(value, format!("{place}/{key}"), places);
            }
        }
        value => places.extend(numbers(value).map(|_| place)),
    }
}
