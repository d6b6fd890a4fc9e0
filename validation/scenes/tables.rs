//! Tables of figures that the scenes are compared with, and the solving of their rows.

use std::collections::BTreeMap;
use std::path::Path;

use pennate::accuracy::solve_to_accuracy;
use pennate::solution::{Solution, status_name};
use pennate_models::scenes;
use pennate_solver::history::Status;
use pennate_solver::options::Options;
use serde::Deserialize;

/// Part of a prototype's value by which it may be off.
const TOLERANCE: f64 = 0.02;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    tables: Vec<Table>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    scene: String,
    #[serde(default)]
    set: BTreeMap<String, serde_json::Value>,
    tolerance: Option<f64>,
    table: String,
}

/// A scene with settings, and the values expected of it.
#[derive(Clone, Debug)]
pub struct Row {
    pub scene: String,
    pub settings: Vec<(String, String)>,
    pub expected: Vec<Expected>,
}

/// What a probe should be.
#[derive(Clone, Debug)]
pub struct Expected {
    pub probe: String,
    /// The step after which it is taken; the last one without.
    pub step: Option<String>,
    pub value: f64,
    /// By how much it may be off.
    pub tolerance: f64,
}

/// Reads the rows of all tables of a file.
pub fn read(path: &Path) -> Vec<Row> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let file: File = toml::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    file.tables.iter().flat_map(rows).collect()
}

fn rows(table: &Table) -> Vec<Row> {
    let scene = scenes::find(&table.scene).unwrap_or_else(|error| panic!("{error}"));
    let mut lines = table.table.lines().filter(|line| !line.trim().is_empty());
    let header: Vec<&str> = lines.next().map(|line| line.split_whitespace().collect()).unwrap_or_default();
    let fixed = table
        .set
        .iter()
        .map(|(name, value)| (name.clone(), value.as_str().map_or_else(|| value.to_string(), str::to_owned)));
    let fixed: Vec<(String, String)> = fixed.collect();
    let is_parameter = |name: &str| scene.parameters.iter().any(|parameter| parameter.name == name);
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split_whitespace().collect();
            assert_eq!(cells.len(), header.len(), "{}: {line}", table.scene);
            let mut row = Row { scene: table.scene.clone(), settings: fixed.clone(), expected: Vec::new() };
            for (name, cell) in header.iter().zip(cells) {
                if cell == "-" {
                    continue;
                }
                if is_parameter(name) {
                    row.settings.push(((*name).to_owned(), cell.to_owned()));
                } else {
                    row.expected.push(expected(name, cell, table.tolerance.unwrap_or(TOLERANCE)));
                }
            }
            row
        })
        .collect()
}

fn expected(name: &str, cell: &str, relative: f64) -> Expected {
    let (probe, step) = match name.split_once('@') {
        Some((probe, step)) => (probe, Some(step.to_owned())),
        None => (name, None),
    };
    let value: f64 = cell.parse().unwrap_or_else(|_| panic!("'{cell}' is no number"));
    let decimals = cell.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let half_digit = 0.5 * 0.1_f64.powi(decimals as i32);
    Expected { probe: probe.to_owned(), step, value, tolerance: half_digit.max(relative * value.abs()) }
}

/// Solves a scene; a step that does not converge is an error.
pub fn solve(scene: &str, settings: &[(String, String)], accuracy: f64) -> Result<Solution, String> {
    let text = scenes::write(scene, settings).map_err(|errors| errors.to_string())?;
    let model = pennate_models::read_text(scene, &text, &[]).map_err(|errors| errors.to_string())?;
    let options = Options { estimate: true, ..Options::default() };
    let solution = solve_to_accuracy(model, accuracy, &options, &mut |_| true);
    let solution = solution.map_err(|_| "it is a mechanism".to_owned())?;
    match solution.status() {
        Status::Converged => Ok(solution),
        status => Err(status_name(status).to_owned()),
    }
}

/// Value of a probe after a step, or after the last one.
pub fn value(solution: &Solution, probe: &str, step: Option<&str>) -> f64 {
    let at = solution.model.probes.names.iter().position(|name| name == probe);
    let at = at.unwrap_or_else(|| panic!("no probe '{probe}'"));
    let steps = solution.model.step_names();
    let step = step.map_or(steps.len() - 1, |name| {
        steps.iter().position(|step| *step == name).unwrap_or_else(|| panic!("no step '{name}'"))
    });
    solution.probes.steps[step].last().map_or(f64::NAN, |values| values[at])
}
