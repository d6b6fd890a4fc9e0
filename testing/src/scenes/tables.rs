//! Tables of figures that the scenes are compared with.

use std::collections::BTreeMap;
use std::path::Path;

use pennate_models::scenes;
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
    /// Name of the scene.
    pub scene: String,
    /// Its parameters and their values, as on a command line.
    pub settings: Vec<(String, String)>,
    /// What its probes should be.
    pub expected: Vec<Expected>,
}

/// What a probe should be.
#[derive(Clone, Debug)]
pub struct Expected {
    /// Name of the probe.
    pub probe: String,
    /// The step after which it is taken; the last one without.
    pub step: Option<String>,
    /// What it should be, in the units of the scene.
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
