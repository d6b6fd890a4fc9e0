//! `expected.toml`: what is compared with what.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::Value;

use super::scales::numbers;

/// `expected.toml`: which results of which network file stand where in `reference.json`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Expected {
    /// Places of `reference.json` without a check, `*` for any one name.
    #[serde(default)]
    pub(super) not_compared: Vec<String>,
    /// Lists of checks by name, which steps refer to.
    pub(super) checks: BTreeMap<String, Vec<Check>>,
    /// All solves of the folder.
    pub(super) run: Vec<Run>,
}

/// One solve of one network file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Network file, in the folder.
    pub network: String,
    /// Parameters that it is solved with, in the units of the file.
    #[serde(default)]
    pub(super) set: BTreeMap<String, f64>,
    /// Where the references of all steps stand.
    pub(super) at: Option<String>,
    /// Largest relative error with default settings.
    pub(super) tolerance: Option<f64>,
    /// The same on the fine mesh.
    pub(super) fine_tolerance: Option<f64>,
    /// The steps that are compared.
    pub(super) steps: Vec<Step>,
}

/// A step of a run.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Step {
    /// As the results have it.
    pub(super) name: String,
    /// Where the references stand: a JSON pointer.
    pub(super) at: Option<String>,
    /// Name of a list of checks.
    pub(super) check: String,
    /// The verdict on its end that is expected, if one is.
    pub(super) stable: Option<bool>,
    /// Largest number of factorizations with default settings.
    pub(super) max_factorizations: Option<u64>,
}

/// One quantity: `factor` times the computed value is the reference.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Check {
    /// The node that has the quantity.
    pub(super) node: Option<String>,
    /// Or the probe that is it.
    pub(super) probe: Option<String>,
    /// Of a node: a quantity of the results, with `.x`, `.y` or `.z` for one component.
    pub(super) quantity: Option<String>,
    /// What its error is relative to: displacement, rotation, force or moment; found out by default.
    pub(super) kind: Option<String>,
    /// Below the place of the step.
    pub(super) reference: String,
    /// The computed value times this is the reference.
    #[serde(default = "one")]
    pub(super) factor: f64,
}

fn one() -> f64 {
    1.0
}

impl Check {
    /// The quantity of the results without its component.
    pub(super) fn base(&self) -> (&str, Option<usize>) {
        let quantity = self.quantity.as_deref().unwrap_or_default();
        match quantity.split_once('.') {
            Some((base, component)) => (base, "xyz".find(component)),
            None => (quantity, None),
        }
    }

    /// How it is called in a table.
    pub(super) fn label(&self) -> String {
        match (&self.node, &self.probe) {
            (Some(node), _) => format!("{} of {node}", self.base().0),
            (None, probe) => format!("probe {}", probe.as_deref().unwrap_or("?")),
        }
    }

    /// What its error is relative to.
    pub(super) fn kind(&self) -> &str {
        self.kind.as_deref().unwrap_or(match self.base().0 {
            "position" | "displacement" => "displacement",
            "rotation_vector" | "rotation_total" => "rotation",
            "reaction_force" => "force",
            "reaction_moment" => "moment",
            other => other,
        })
    }

    /// Its value in the results of a step, one number a component.
    pub(super) fn computed(&self, result: &Value) -> Option<Vec<f64>> {
        if let Some(probe) = &self.probe {
            return numbers(&result["probes"][probe.as_str()]);
        }
        let (base, component) = self.base();
        let values = numbers(&result["nodes"][self.node.as_deref()?][base])?;
        component.map_or(Some(values.clone()), |i| Some(vec![*values.get(i)?]))
    }

    /// The error that the results state of it.
    pub(super) fn estimate(&self, result: &Value) -> Option<f64> {
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
