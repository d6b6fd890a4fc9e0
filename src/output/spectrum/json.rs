//! `modes.json` and `buckling.json`: every mode with its value and the motion of the nodes.

use std::io::{self, Write};

use pennate_analysis::spectrum::{Entry, Question, Spectrum};
use pennate_solver::spectral::shape::Spot;
use pennate_solver::structure::Dimension;
use serde::Serialize;
use serde_json::{Map, Value, json};

use super::{family_name, frequency};
use crate::output::layout::write_json;
use crate::output::origin::Origin;
use crate::spectrum::note;

const COMPONENTS: [&str; 6] = ["ux", "uy", "uz", "rx", "ry", "rz"];

#[derive(Serialize)]
struct Results<'a> {
    format: &'static str,
    title: &'a str,
    dimension: &'static str,
    units: &'static str,
    /// The step at whose end the state is; null for the unloaded network.
    state: Option<&'a str>,
    /// Of buckling: the step whose ramp the factor is a fraction of; null where it multiplies the present loads.
    #[serde(skip_serializing_if = "Option::is_none")]
    along: Option<Option<&'a str>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reversed: Option<Option<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reversed_error: Option<Option<f64>>,
    mesh: Value,
    notes: Vec<String>,
    modes: Vec<Value>,
    input: Origin<'a>,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    pictures: &'a [String],
    timing: Value,
}

/// Writes all modes; `pictures` are the names of those that were written beside them.
///
/// # Errors
/// Those of the writer.
pub fn write(spectrum: &Spectrum, pictures: &[String], writer: &mut dyn Write) -> io::Result<()> {
    let model = &spectrum.model;
    let buckling = spectrum.question == Question::Buckling;
    let results = Results {
        format: if buckling { "pennate-buckling/1" } else { "pennate-modes/1" },
        title: &model.title,
        dimension: match model.dimension {
            Dimension::Plane => "plane",
            Dimension::Space => "space",
        },
        units: model.units.name(),
        state: spectrum.step.as_deref(),
        along: buckling.then_some(spectrum.along.as_deref()),
        reversed: buckling.then_some(spectrum.reversed.map(|reversed| reversed.value)),
        reversed_error: buckling.then_some(spectrum.reversed.and_then(|reversed| reversed.error)),
        mesh: json!({ "elements": spectrum.mesh.elements(), "unknowns": spectrum.unknowns }),
        notes: spectrum.notes.iter().map(note).collect(),
        modes: spectrum.entries.iter().map(|entry| mode(spectrum, entry)).collect(),
        input: Origin::of(model),
        pictures,
        timing: json!({
            "read_s": spectrum.timing.read.as_secs_f64(),
            "solve_s": spectrum.timing.solve.as_secs_f64(),
        }),
    };
    write_json(&results, writer)
}

fn mode(spectrum: &Spectrum, entry: &Entry) -> Value {
    let model = &spectrum.model;
    let mut mode = Map::new();
    match spectrum.question {
        Question::Modes => {
            mode.insert("frequency_hz".to_owned(), json!(frequency(entry.value)));
            mode.insert("angular_frequency".to_owned(), json!(frequency(entry.value).map(|_| entry.value.sqrt())));
            mode.insert("eigenvalue".to_owned(), json!(entry.value));
            if entry.value < 0.0 {
                mode.insert("growth_rate".to_owned(), json!((-entry.value).sqrt()));
            }
        }
        Question::Buckling => {
            mode.insert("factor".to_owned(), json!(entry.value));
        }
    }
    mode.insert("error".to_owned(), json!(entry.error));
    mode.insert("family".to_owned(), json!(family_name(entry.family)));
    let component = COMPONENTS[entry.largest.component];
    let value = entry.largest.value;
    let largest = match entry.largest.spot {
        Spot::Node(node) => json!({ "node": model.nodes[node].name, "component": component, "value": value }),
        Spot::Member(member, part) => {
            json!({ "member": model.members[member].name, "at": part, "component": component, "value": value })
        }
    };
    mode.insert("largest".to_owned(), largest);
    let nodes: Map<String, Value> = model
        .nodes
        .iter()
        .zip(&entry.shape.nodes)
        .map(|(node, m)| (node.name.clone(), json!({ "displacement": m[..3], "rotation_vector": m[3..] })))
        .collect();
    mode.insert("nodes".to_owned(), Value::Object(nodes));
    Value::Object(mode)
}
