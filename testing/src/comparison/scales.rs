//! What errors are relative to.

use std::collections::BTreeMap;

use serde_json::Value;

/// What counts as no smaller than this part of the largest comparable value.
const SMALL: f64 = 1e-3;

/// What an error of each kind is relative to: the largest reference of its kind in one result.
///
/// Where a result has next to nothing of a kind (no moment in a hinge), 1e-3 of the largest in the run counts, or of
/// what the other kind of the pair makes over the size of the network: a force times a length is a moment.
#[derive(Clone, Debug, Default)]
pub(super) struct Scales {
    largest: BTreeMap<String, f64>,
}

impl Scales {
    /// Lets forces and moments, and displacements and rotations, stand in for each other over the size of the network.
    pub(super) fn couple(&mut self, size: f64) {
        let [displacement, force, moment] = ["displacement", "force", "moment"].map(|kind| self.of(kind));
        self.raise("rotation", displacement / size);
        self.raise("force", moment / size);
        self.raise("moment", force * size);
    }

    /// Raises these scales to those of another result.
    pub(super) fn include(&mut self, other: &Self) {
        for (kind, &value) in &other.largest {
            self.raise(kind, value);
        }
    }

    /// Raises the scale of a kind to a value.
    pub(super) fn raise(&mut self, kind: &str, value: f64) {
        let largest = self.largest.entry(kind.to_owned()).or_default();
        *largest = largest.max(value);
    }

    /// The scale of a kind; zero where nothing was compared.
    pub(super) fn of(&self, kind: &str) -> f64 {
        self.largest.get(kind).copied().unwrap_or(0.0)
    }

    /// These scales, none of them smaller than a part of those of the whole run.
    pub(super) fn at_least(mut self, run: &Self) -> Self {
        for (kind, value) in &run.largest {
            self.raise(kind, SMALL * value);
        }
        self
    }
}

/// Largest distance in one coordinate between unloaded nodes.
pub(super) fn network_size(result: &Value) -> f64 {
    let mut bounds = [(f64::INFINITY, f64::NEG_INFINITY); 3];
    for node in result["nodes"].as_object().into_iter().flatten().map(|(_, node)| node) {
        if let Some((position, displacement)) = numbers(&node["position"]).zip(numbers(&node["displacement"])) {
            for (i, (low, high)) in bounds.iter_mut().enumerate() {
                let unloaded = position[i] - displacement[i];
                (*low, *high) = (low.min(unloaded), high.max(unloaded));
            }
        }
    }
    largest(bounds.into_iter().map(|(low, high)| high - low))
}

/// Largest absolute value; not a number if one of them is none.
pub(super) fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |largest: f64, value| {
        if value.is_nan() {
            value
        } else if largest.is_nan() {
            largest
        } else {
            largest.max(value.abs())
        }
    })
}

/// A number, a number written as a string (with more digits than a double has), or a list of them.
pub(super) fn numbers(value: &Value) -> Option<Vec<f64>> {
    match value {
        Value::Number(number) => Some(vec![number.as_f64()?]),
        Value::String(text) => Some(vec![text.parse().ok()?]),
        Value::Array(values) => values.iter().map(Value::as_f64).collect(),
        _ => None,
    }
}
