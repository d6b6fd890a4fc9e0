//! `flow.json`: members, paths and steps of a load flow.

use std::io::{self, Write};

use pennate_analysis::flow::{Decision, Flow, MemberFlow};
use pennate_analysis::solution::status_name;
use pennate_solver::structure::Dimension;
use serde::Serialize;
use serde_json::{Map, Value, json};

use super::{level, path, role, sense};
use crate::flow::end;
use crate::output::layout::write_json;
use crate::output::origin::Origin;

#[derive(Serialize)]
struct Results<'a> {
    format: &'static str,
    title: &'a str,
    dimension: &'static str,
    units: &'static str,
    /// Unit loads that act together: force and moment.
    inputs: Map<String, Value>,
    /// Motions under them: displacement and rotation vector, radians.
    outputs: Map<String, Value>,
    members: Map<String, Value>,
    /// Members between the input and a node at least.
    depth: Map<String, Value>,
    paths: Vec<Vec<String>>,
    levels: Vec<Value>,
    steps: Vec<Value>,
    end: String,
    input: Origin<'a>,
}

/// Writes all of a load flow.
///
/// # Errors
/// Those of the writer.
pub fn write(flow: &Flow, writer: &mut dyn Write) -> io::Result<()> {
    let model = &flow.model;
    let node = |node: usize| model.nodes[node].name.clone();
    let results = Results {
        format: "pennate-flow/1",
        title: &model.title,
        dimension: match model.dimension {
            Dimension::Plane => "plane",
            Dimension::Space => "space",
        },
        units: model.units.name(),
        inputs: flow.request.inputs.iter().map(|input| (node(input.node), json!(input.load))).collect(),
        outputs: flow
            .request
            .outputs
            .iter()
            .zip(&flow.outputs)
            .map(|(&at, motion)| (node(at), json!(motion)))
            .collect(),
        members: (0..flow.members.len()).map(|index| member(flow, index)).collect(),
        depth: (0..model.nodes.len())
            .filter_map(|index| Some((node(index), json!(flow.graph.depth[flow.graph.joints[index]]?))))
            .collect(),
        paths: flow.graph.paths.iter().map(|each| path(flow, each)).collect(),
        levels: flow.levels.iter().map(|level| decided(flow, level)).collect(),
        steps: flow.steps.iter().map(|step| replacement(flow, step)).collect(),
        end: end(flow),
        input: Origin::of(model),
    };
    write_json(&results, writer)
}

fn member(flow: &Flow, index: usize) -> (String, Value) {
    let member: &MemberFlow = &flow.members[index];
    let [axial, transverse, moment] = member.shares;
    let points = member.points.iter();
    let edge = &flow.graph.edges[index];
    let [start, end] = edge.joints.map(|joint| flow.model.nodes[joint].name.as_str());
    let (from, to) = if edge.forward { (start, end) } else { (end, start) };
    let points: Vec<Value> =
        points.map(|point| json!({ "position": point.position, "load": point.load, "motion": point.motion })).collect();
    let value = json!({
        "role": role(member),
        "sense": sense(member),
        "shares": { "axial": axial, "transverse": transverse, "moment": moment },
        "axial_load": member.axial,
        "passed": member.passed,
        "grounded": member.grounded,
        "from": from,
        "to": to,
        "level": level(flow, index),
        "points": points,
    });
    (flow.model.members[flow.request.members[index]].name.clone(), value)
}

fn decided(flow: &Flow, level: &pennate_analysis::flow::Level) -> Value {
    let decision = match level.decision {
        Decision::Replace => "replace",
        Decision::PassOver => "pass_over",
        Decision::Stop => "stop",
    };
    json!({ "level": level.number, "members": path(flow, &level.members), "decision": decision })
}

fn replacement(flow: &Flow, step: &pennate_analysis::flow::Replacement) -> Value {
    let names: Vec<&str> = step.muscles.iter().map(|&member| flow.model.members[member].name.as_str()).collect();
    let name = |node: usize| flow.model.nodes[node].name.clone();
    let moved = flow.request.outputs.iter().zip(&step.outputs);
    let outputs: Map<String, Value> = moved
        .map(|(&at, motion)| (name(at), json!({ "displacement": motion[..3], "rotation_vector": motion[3..] })))
        .collect();
    let limits = flow.request.requirements.iter().zip(&step.required);
    let required: Map<String, Value> = limits
        .map(|(limits, &value)| {
            let met = limits.is_met(value);
            (flow.model.probes.names[limits.probe].clone(), json!({ "value": value, "met": met }))
        })
        .collect();
    json!({
        "level": step.level,
        "muscles": names,
        "network": step.document.source().name,
        "status": status_name(step.status),
        "stable": step.stable,
        "outputs": outputs,
        "stress": step.stress,
        "required": required,
    })
}
