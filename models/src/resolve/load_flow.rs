//! Where a mechanism is driven and what it moves.

use pennate_solver::structure::Dimension;

use super::context::{Context, Names, place};
use super::joints::Bodies;
use super::properties::Properties;
use crate::error::{InputError, Span};
use crate::input;
use crate::input::read::{Map, Spanned};
use crate::model::{FlowInput, LoadFlow, Requirement, Units};
use crate::probes::{Operand, Probes};
use crate::unit::Kind;

/// Members shorter than this are not replaced unless the file says otherwise, mm: the shortest muscle that the inverters
/// of the dissertation allow (section 3.4).
const SHORTEST: f64 = 45.0;
const OWNER: &str = "the load flow";

/// What a load flow refers to.
pub(crate) struct Mechanism<'a> {
    pub(crate) nodes: &'a Names,
    pub(crate) member_names: &'a Names,
    pub(crate) bodies: &'a Bodies,
    pub(crate) properties: &'a Properties,
    pub(crate) probes: &'a Probes,
    pub(crate) dimension: Dimension,
    /// Whether members are written in short: copies of patterns, parts of paths.
    pub(crate) has_copies: bool,
}

pub(crate) fn load_flow(
    flow: &Spanned<input::LoadFlow>,
    mechanism: &Mechanism<'_>,
    cx: &mut Context,
) -> Option<LoadFlow> {
    if mechanism.has_copies {
        let error = InputError::new("a load flow needs members written one by one").at(flow.span);
        cx.error(error.help("write the copies of patterns and the parts of paths as members of their own"));
        return None;
    }
    let Spanned { span, value: data } = flow;
    let inputs: Vec<_> = data.input.all().iter().map(|given| input(given, mechanism, cx)).collect();
    let outputs = find(&data.outputs, mechanism.nodes, cx);
    let members = match &data.members {
        Some(list) => find(list, mechanism.member_names, cx),
        None => Some((0..mechanism.member_names.iter().count()).collect()),
    };
    let muscle = muscle(data, mechanism, cx);
    let shortest = match (&data.shortest, cx.units) {
        (Some(number), _) => cx.not_negative(number, Kind::Length, "the shortest length of a muscle"),
        (None, Units::MmNMpa) => Some(SHORTEST),
        (None, Units::MNPa) => Some(SHORTEST / 1e3),
    };
    let requirements =
        data.requirements.as_ref().map_or(Some(Vec::new()), |all| requirements(all, mechanism.probes, cx));
    let inputs: Vec<FlowInput> = inputs.into_iter().collect::<Option<_>>()?;
    let (outputs, mut members) = (outputs?, members?);
    members.sort_unstable();
    members.dedup();
    let empty = [(inputs.is_empty(), "input"), (outputs.is_empty(), "output"), (members.is_empty(), "member")];
    if let Some((_, what)) = empty.iter().find(|(is_empty, _)| *is_empty) {
        cx.error(InputError::new(format!("{OWNER} has no {what}")).at(*span).help(format!("name at least one {what}")));
        return None;
    }
    let both = inputs.iter().find(|input| outputs.contains(&input.node));
    if let Some(input) = both {
        let title = format!("node '{}' is an input and an output of {OWNER}", mechanism.nodes.of(input.node));
        cx.error(InputError::new(title).at(data.outputs.span).help("name two different nodes"));
        return None;
    }
    let (muscle, pressure) = muscle?;
    let (shortest, requirements) = (shortest?, requirements?);
    Some(LoadFlow { span: *span, inputs, outputs, members, muscle, pressure, shortest, requirements })
}

/// Limits of probes that are read at the end of the one step that inflates the muscles.
fn requirements(all: &Map<Spanned<input::Requirement>>, probes: &Probes, cx: &mut Context) -> Option<Vec<Requirement>> {
    let names = Names::new("probe", probes.names.iter().map(String::as_str));
    let mut found = Vec::new();
    for entry in all {
        let Spanned { span, value } = &entry.value;
        let mut limit = |number: &Option<_>, none: f64| match number {
            Some(number) => cx.number(number, Kind::Pure),
            None => Some(none),
        };
        let (least, most) = (limit(&value.least, f64::NEG_INFINITY), limit(&value.most, f64::INFINITY));
        let probe = names.find(&entry.name, entry.span, OWNER, cx);
        let (Some(least), Some(most), Some(probe)) = (least, most, probe) else { continue };
        let wrong = if value.least.is_none() && value.most.is_none() {
            Some(("has no limit", "write least = 20, or most = 1200"))
        } else if least > most {
            Some(("is more than its greatest value", "let 'least' be below 'most'"))
        } else if is_of_a_step(probes, probe) {
            Some((
                "is about a step of the file",
                "the networks with muscles have one step of their own: leave out the @",
            ))
        } else {
            None
        };
        match wrong {
            Some((what, help)) => {
                cx.error(InputError::new(format!("the requirement '{}' {what}", entry.name)).at(*span).help(help));
            }
            None => found.push(Requirement { probe, least, most }),
        }
    }
    (found.len() == all.iter().count()).then_some(found)
}

/// Whether a probe, or one that it refers to, is read after a step.
fn is_of_a_step(probes: &Probes, probe: usize) -> bool {
    probes.operands(probe).into_iter().flatten().any(|operand| match *operand {
        Operand::After { .. } => true,
        Operand::Probe(other) => is_of_a_step(probes, other),
        Operand::Parameter(_) => false,
    })
}

fn find(list: &Spanned<Vec<Spanned<String>>>, names: &Names, cx: &mut Context) -> Option<Vec<usize>> {
    let found: Vec<_> = list.value.iter().map(|name| names.find(&name.value, name.span, OWNER, cx)).collect();
    found.into_iter().collect()
}

fn input(given: &Spanned<input::FlowInput>, mechanism: &Mechanism<'_>, cx: &mut Context) -> Option<FlowInput> {
    let data = &given.value;
    let node = mechanism.nodes.find(&data.node.value, data.node.span, OWNER, cx)?;
    let mut load = [0.0; 6];
    let (list, first, inside) = match (&data.direction, &data.about) {
        (Some(list), None) => (list, 0, [true, true, false]),
        (None, Some(list)) => (list, 3, [false, false, true]),
        _ => {
            let error = InputError::new("an input is a force or a moment").at(given.span);
            cx.error(error.help("write either direction = [1, 0] or about = [0, 0, 1]"));
            return None;
        }
    };
    let direction = cx.direction(list, "the direction of an input")?;
    load[first..first + 3].copy_from_slice(direction.as_slice());
    let leaves = (0..3).any(|axis| !inside[axis] && direction[axis] != 0.0);
    if mechanism.dimension == Dimension::Plane && leaves {
        return out_of_plane(list.span, cx);
    }
    let guided = data.guided.unwrap_or(true);
    let reference = mechanism.bodies.turns_with(node);
    if guided && reference != node {
        let title = format!("input '{}' is guided, but it moves with its rigid body", data.node.value);
        let help =
            format!("drive the reference '{}' of the body, or say guided = false", mechanism.nodes.of(reference));
        cx.error(InputError::new(title).at(data.node.span).help(help));
        return None;
    }
    Some(FlowInput { node, load, guided })
}

fn out_of_plane(span: Span, cx: &mut Context) -> Option<FlowInput> {
    let error = place(InputError::new("an input acts out of the plane of the network"), span);
    cx.error(error.help("give it a direction in the plane or an axis along z, or say dimension = \"space\""));
    None
}

/// The muscle that replaces transmitters, and its pressure.
fn muscle(data: &input::LoadFlow, mechanism: &Mechanism<'_>, cx: &mut Context) -> Option<(Option<usize>, f64)> {
    let properties = mechanism.properties;
    let index = match (&data.muscle, properties.muscles.len()) {
        (Some(name), _) => properties.muscle(name, OWNER, cx)?,
        (None, 1) => 0,
        (None, _) => return Some((None, 0.0)),
    };
    let muscle = properties.muscles[index].as_ref()?;
    let limit = muscle.muscle.pressure_limit();
    let pressure = match &data.pressure {
        Some(number) => cx.pressure(number, &muscle.unit)?,
        None => limit,
    };
    if pressure > 0.0 && pressure <= limit {
        return Some((Some(index), pressure));
    }
    let span = data.pressure.as_ref().map(|number| number.span).unwrap_or_default();
    let unit = &muscle.muscle.pressure_unit;
    let title =
        format!("the pressure of {OWNER} is {pressure} {unit}, the muscle is known above 0 up to {limit} {unit}");
    cx.error(place(InputError::new(title), span).help("give a pressure in the table of the muscle"));
    None
}
