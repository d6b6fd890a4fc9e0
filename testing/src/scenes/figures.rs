//! Figures that the dissertation reports, and what pennate makes of them.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use super::run::{solve, value};

/// Mesh error asked for, far below the last digit of any figure.
const ACCURACY: f64 = 1e-6;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    figures: Vec<Figure>,
}

/// One reported number.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// What it is a figure of.
    pub what: String,
    scene: String,
    #[serde(default)]
    set: BTreeMap<String, serde_json::Value>,
    /// Probe, or probe@step.
    probe: String,
    over: Option<Over>,
    find: Option<Find>,
    share_of: Option<BTreeMap<String, serde_json::Value>>,
    /// As printed.
    pub reported: String,
    /// How certain the settings are that it was printed for.
    pub certainty: String,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Over {
    parameter: String,
    from: u32,
    to: u32,
    step: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Find {
    Place,
    Value,
}

/// The figures of a file.
pub fn read(path: &Path) -> Vec<Figure> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let file: File = toml::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    file.figures
}

impl Figure {
    /// What pennate says.
    ///
    /// # Errors
    /// Why it has no answer: where a range is searched, that of the first place without one.
    pub fn found(&self) -> Result<f64, String> {
        let Some(over) = &self.over else {
            let found = self.at(&self.set, None)?;
            return Ok(match &self.share_of {
                Some(other) => {
                    let mut set = self.set.clone();
                    set.extend(other.clone());
                    found / self.at(&set, None)?
                }
                None => found,
            });
        };
        let mut best: Option<(f64, f64)> = None;
        for place in (over.from..=over.to).step_by(over.step as usize) {
            let found = self.at(&self.set, Some((&over.parameter, place)))?;
            if best.is_none_or(|(_, value)| found > value) {
                best = Some((f64::from(place), found));
            }
        }
        let (place, value) = best.ok_or("nothing to search")?;
        Ok(if self.find == Some(Find::Place) { place } else { value })
    }

    fn at(&self, set: &BTreeMap<String, serde_json::Value>, place: Option<(&str, u32)>) -> Result<f64, String> {
        let text = |value: &serde_json::Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        let mut settings: Vec<(String, String)> = set.iter().map(|(name, value)| (name.clone(), text(value))).collect();
        settings.extend(place.map(|(name, value)| (name.to_owned(), value.to_string())));
        let solution = solve(&self.scene, &settings, ACCURACY)?;
        let (probe, step) = match self.probe.split_once('@') {
            Some((probe, step)) => (probe, Some(step)),
            None => (self.probe.as_str(), None),
        };
        Ok(value(&solution, probe, step))
    }
}
