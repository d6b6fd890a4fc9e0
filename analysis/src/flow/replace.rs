//! Muscles in place of transmitters, level by level: network files, each solved.

use std::collections::BTreeSet;

use pennate_models::Document;
use pennate_models::error::Span;
use pennate_models::input::tree::{Entry, Kind, Value};
use pennate_models::model::{MemberId, SegmentLaw};
use pennate_models::probes::Operand;
use pennate_solver::error::SolveError;
use pennate_solver::history::Status;
use pennate_solver::options::{Options, Progress};
use pennate_solver::structure::Dimension;

use super::graph::Decision;
use super::{End, Flow, NoFlow, Replacement};
use crate::accuracy::solve_to_accuracy;
use crate::solution::{last_state, stable};

/// Error of the solved networks, relative to the largest value of its kind.
const ACCURACY: f64 = 1e-6;

/// Solves the network after every level that is replaced, until one is lost.
pub(super) fn replace(
    flow: &mut Flow,
    document: &Document,
    settings: &[(String, String)],
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Result<(), NoFlow> {
    let Some(muscle) = flow.request.muscle else {
        flow.end = End::NoMuscle;
        return Ok(());
    };
    let tree = document.tree().map_err(NoFlow::Input)?;
    let tree = mechanism(tree, flow, settings, document);
    let mut muscles: Vec<MemberId> = Vec::new();
    for level in flow.levels.clone() {
        if level.decision != Decision::Replace {
            continue;
        }
        let members: Vec<MemberId> = level.members.iter().map(|&member| flow.request.members[member]).collect();
        let short = |&&member: &&MemberId| flow.model.members[member].length < flow.request.shortest;
        if let Some(&member) = members.iter().find(short) {
            flow.end = End::Short(member);
            return Ok(());
        }
        muscles.extend(members);
        let name = format!("level_{}.toml", level.number);
        let document = document.with_tree(&name, &with_muscles(&tree, flow, &muscles, muscle));
        let solved = solve(flow, &document, level.number, &muscles, options, observe)?;
        let required = solved.required.iter().zip(&flow.request.requirements);
        let met = !solved.required.is_empty() && required.into_iter().all(|(&value, limits)| limits.is_met(value));
        let lost = solved.status != Status::Converged || solved.stable == Some(false);
        flow.steps.push(solved);
        if lost {
            flow.end = End::Lost;
            return Ok(());
        }
        if met {
            flow.end = End::Met;
            return Ok(());
        }
    }
    Ok(())
}

fn solve(
    flow: &Flow,
    document: &Document,
    level: usize,
    muscles: &[MemberId],
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Result<Replacement, NoFlow> {
    let model = document.model(&[]).map_err(NoFlow::Input)?;
    let options = Options { estimate: true, ..options.clone() };
    let places: Vec<Option<usize>> = flow
        .request
        .outputs
        .iter()
        .map(|&output| model.nodes.iter().position(|node| node.name == flow.model.nodes[output].name))
        .collect();
    let solution = match solve_to_accuracy(model, ACCURACY, &options, observe) {
        Ok(solution) => solution,
        Err((model, SolveError::Mechanism(motions))) => return Err(NoFlow::Mechanism(model, motions)),
    };
    if solution.status() == Status::Interrupted {
        return Err(NoFlow::Interrupted);
    }
    let state = solution.history.steps.last().and_then(last_state);
    let output = |place: &Option<usize>| -> [f64; 6] {
        let Some(node) = state.and_then(|state| state.nodes.get((*place)?)) else { return [f64::NAN; 6] };
        let (u, r) = (node.displacement, node.rotation);
        [u[0], u[1], u[2], r[0], r[1], r[2]]
    };
    // What is required, and the greatest stress, of a network that got to its end.
    let last = if solution.status() == Status::Converged { solution.probes.steps.last() } else { None };
    let value = |name: &str| {
        let probe = solution.model.probes.names.iter().position(|known| known == name)?;
        last?.last()?.get(probe).copied()
    };
    let required = flow.request.requirements.iter().map(|limits| &flow.model.probes.names[limits.probe]);
    let required = required.map(|name| value(name).unwrap_or(f64::NAN)).collect();
    Ok(Replacement {
        level,
        muscles: muscles.to_vec(),
        document: document.clone(),
        status: solution.status(),
        stable: stable(&solution.history),
        outputs: places.iter().map(output).collect(),
        stress: value(STRESS).filter(|_| has_shapes(flow)),
        required,
    })
}

/// The tree of the mechanism alone: its members, its input clamped, one step that inflates all muscles, and the motion of the
/// outputs as probes.
fn mechanism(mut tree: Value, flow: &Flow, settings: &[(String, String)], document: &Document) -> Value {
    for key in ["steps", "load_flow"] {
        remove(&mut tree, key);
    }
    let kept = required(flow);
    entries(entry(&mut tree, "probes")).retain(|probe| kept.contains(probe.key.as_str()));
    for (name, value) in settings {
        let value = value.trim().parse().map_or_else(|_| text(value), number);
        set(entry(&mut tree, "parameters"), name, value);
    }
    let kept: Vec<&str> = flow.request.members.iter().map(|&member| flow.model.members[member].name.as_str()).collect();
    entries(entry(&mut tree, "members")).retain(|member| kept.contains(&member.key.as_str()));
    let left_out = unused(flow);
    for key in ["nodes", "supports"] {
        entries(entry(&mut tree, key)).retain(|named| !left_out.contains(&named.key.as_str()));
    }
    for input in &flow.request.inputs {
        set(entry(&mut tree, "supports"), &flow.model.nodes[input.node].name, text("clamped"));
    }
    // The written network may stand in another directory than the files that it refers to.
    for muscle in entries(entry(&mut tree, "muscles")) {
        let Kind::Table(data) = &mut muscle.value.kind else { continue };
        for Entry { key, value, .. } in data {
            if let (true, Kind::String(file)) = (key == "file", &mut value.kind) {
                let path = document.directory().join(&*file);
                *file = std::path::absolute(&path).unwrap_or(path).display().to_string();
            }
        }
    }
    let pressure = table(vec![("all", number(flow.request.pressure))]);
    let inflate = table(vec![("name", text("inflate")), ("pressure", pressure)]);
    set(&mut tree, "steps", Value { span: Span::default(), kind: Kind::Array(vec![inflate]) });
    let components: &[&str] = match flow.model.dimension {
        Dimension::Plane => &["ux", "uy"],
        Dimension::Space => &["ux", "uy", "uz"],
    };
    for &output in &flow.request.outputs {
        let name = &flow.model.nodes[output].name;
        for component in components {
            let probe = table(vec![("node", text(name)), ("displacement", text(component))]);
            add(entry(&mut tree, "probes"), &format!("{name}_{component}"), probe);
        }
    }
    if has_shapes(flow) {
        let probe = table(vec![("member", text("all")), ("stress", text("max"))]);
        set(entry(&mut tree, "probes"), STRESS, probe);
    }
    tree
}

/// Names of the probes that something is required of, and of those that they are made of.
fn required(flow: &Flow) -> BTreeSet<&str> {
    let probes = &flow.model.probes;
    let mut open: Vec<usize> = flow.request.requirements.iter().map(|limits| limits.probe).collect();
    let mut kept = BTreeSet::new();
    while let Some(probe) = open.pop() {
        if kept.insert(probes.names[probe].as_str()) {
            open.extend(probes.operands(probe).into_iter().flatten().filter_map(|operand| match *operand {
                Operand::Probe(other) | Operand::After { probe: other, .. } => Some(other),
                Operand::Parameter(_) => None,
            }));
        }
    }
    kept
}

/// Whether the sections of all members have a shape, so that they have stresses.
fn has_shapes(flow: &Flow) -> bool {
    let members = flow.request.members.iter().map(|&member| &flow.model.members[member]);
    members.flat_map(|member| &member.segments).all(|segment| match &segment.material {
        SegmentLaw::Fixed(law) => law.shape.is_some(),
        SegmentLaw::MuscleEnd(_) | SegmentLaw::MuscleMiddle(_) => true,
    })
}

/// Nodes that only members outside of the mechanism use.
fn unused(flow: &Flow) -> Vec<&str> {
    let model = &flow.model;
    let only = |node: usize| {
        let mut at = (0..model.members.len()).filter(|&member| model.members[member].nodes.contains(&node)).peekable();
        at.peek().is_some() && at.all(|member| !flow.request.members.contains(&member))
    };
    let in_body = |node: usize| model.bodies.iter().any(|body| body.nodes.contains(&node));
    let nodes = (0..model.nodes.len()).filter(|&node| only(node) && !in_body(node));
    nodes.map(|node| model.nodes[node].name.as_str()).collect()
}

/// The mechanism with muscles in place of some members; muscles of the base mechanism that are not among them are wires.
fn with_muscles(tree: &Value, flow: &Flow, muscles: &[MemberId], muscle: usize) -> Value {
    let mut tree = tree.clone();
    let name = &flow.model.muscles[muscle].name;
    let mut wires = false;
    for &member in &flow.request.members {
        let is_muscle = flow.model.members[member].is_muscle();
        let data = entry(entry(&mut tree, "members"), &flow.model.members[member].name);
        if muscles.contains(&member) {
            ["section", "material", "segments", "release", "elements"].iter().for_each(|key| remove(data, key));
            set(data, "muscle", text(name));
        } else if is_muscle {
            remove(data, "muscle");
            set(data, "section", text(WIRE));
            set(data, "material", text(STEEL));
            wires = true;
        }
    }
    if wires {
        let circle = table(vec![("radius", text("0.75 mm"))]);
        let section =
            table(vec![("circle", circle), ("shear", Value { span: Span::default(), kind: Kind::Bool(false) })]);
        let steel = table(vec![("youngs_modulus", text("200 GPa")), ("poissons_ratio", number(0.3))]);
        set(entry(&mut tree, "sections"), WIRE, section);
        set(entry(&mut tree, "materials"), STEEL, steel);
    }
    tree
}

/// Names of what stands for a muscle that became a wire: with a blank, so that no file has them by chance.
const WIRE: &str = "transmitter wire";
const STEEL: &str = "transmitter steel";
/// The probe of the greatest stress.
const STRESS: &str = "greatest stress";

fn number(value: f64) -> Value {
    Value { span: Span::default(), kind: Kind::Number(value) }
}

fn text(value: &str) -> Value {
    Value { span: Span::default(), kind: Kind::String(value.to_owned()) }
}

fn table(entries: Vec<(&str, Value)>) -> Value {
    let mut made = Value { span: Span::default(), kind: Kind::Table(Vec::new()) };
    entries.into_iter().for_each(|(key, value)| set(&mut made, key, value));
    made
}

/// The entries of a table; what is none becomes an empty one.
fn entries(value: &mut Value) -> &mut Vec<Entry> {
    if !matches!(value.kind, Kind::Table(_)) {
        value.kind = Kind::Table(Vec::new());
    }
    match &mut value.kind {
        Kind::Table(entries) => entries,
        _ => unreachable!("made a table above"),
    }
}

/// The value of a key, a new empty table where there is none.
fn entry<'a>(value: &'a mut Value, key: &str) -> &'a mut Value {
    let all = entries(value);
    let place = all.iter().position(|entry| entry.key == key).unwrap_or_else(|| {
        all.push(Entry { key: key.to_owned(), key_span: Span::default(), value: table(Vec::new()) });
        all.len() - 1
    });
    &mut all[place].value
}

/// Sets a key that is not there yet.
fn add(value: &mut Value, key: &str, to: Value) {
    if !entries(value).iter().any(|entry| entry.key == key) {
        set(value, key, to);
    }
}

fn set(value: &mut Value, key: &str, to: Value) {
    *entry(value, key) = to;
}

fn remove(value: &mut Value, key: &str) {
    entries(value).retain(|entry| entry.key != key);
}
