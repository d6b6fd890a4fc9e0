//! `expected.toml`: what is compared with what.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::Value;

use super::scales::numbers;

/// `expected.toml`: which results of which network file stand where in `reference.json`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expected {
    /// Places of `reference.json` without a check, `*` for any one name.
    #[serde(default)]
    pub not_compared: Vec<String>,
    pub checks: BTreeMap<String, Vec<Check>>,
    pub run: Vec<Run>,
}

/// One solve of one network file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Run {
    pub network: String,
    #[serde(default)]
    pub set: BTreeMap<String, f64>,
    /// Where the references of all steps stand.
    pub at: Option<String>,
    /// Largest relative error with default settings, and on the fine mesh.
    pub tolerance: Option<f64>,
    pub fine_tolerance: Option<f64>,
    pub steps: Vec<Step>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    pub name: String,
    /// Where the references stand: a JSON pointer.
    pub at: Option<String>,
    /// Name of a list of checks.
    pub check: String,
    pub stable: Option<bool>,
    /// Largest number of factorizations with default settings.
    pub max_factorizations: Option<u64>,
}

/// One quantity: `factor` times the computed value is the reference.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Check {
    pub node: Option<String>,
    pub probe: Option<String>,
    /// Of a node: a quantity of the results, with `.x`, `.y` or `.z` for one component.
    pub quantity: Option<String>,
    pub kind: Option<String>,
    /// Below the place of the step.
    pub reference: String,
    #[serde(default = "one")]
    pub factor: f64,
}

fn one() -> f64 {
    1.0
}

impl Check {
    /// The quantity of the results without its component.
    pub fn base(&self) -> (&str, Option<usize>) {
        let quantity = self.quantity.as_deref().unwrap_or_default();
        match quantity.split_once('.') {
            Some((base, component)) => (base, "xyz".find(component)),
            None => (quantity, None),
        }
    }

    pub fn label(&self) -> String {
        match (&self.node, &self.probe) {
            (Some(node), _) => format!("{} of {node}", self.base().0),
            (None, probe) => format!("probe {}", probe.as_deref().unwrap_or("?")),
        }
    }

    pub fn kind(&self) -> &str {
        self.kind.as_deref().unwrap_or(match self.base().0 {
            "position" | "displacement" => "displacement",
            "rotation_vector" | "rotation_total" => "rotation",
            "reaction_force" => "force",
            "reaction_moment" => "moment",
            other => other,
        })
    }

    pub fn computed(&self, result: &Value) -> Option<Vec<f64>> {
        if let Some(probe) = &self.probe {
            return numbers(&result["probes"][probe.as_str()]);
        }
        let (base, component) = self.base();
        let values = numbers(&result["nodes"][self.node.as_deref()?][base])?;
        component.map_or(Some(values.clone()), |i| Some(vec![*values.get(i)?]))
    }

    pub fn estimate(&self, result: &Value) -> Option<f64> {
        if let Some(probe) = &self.probe {
            return result["probe_errors"][probe.as_str()].as_f64();
        }
        let key = match self.base().0 {
            "position" => "displacement",
            "rotation_vector" | "rotation_total" => "rotation",
            other => other,
        };
        result["nodes"][self.node.as_deref()?]["errors"][key].as_f64()
    }
}
