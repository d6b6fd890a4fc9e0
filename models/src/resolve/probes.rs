//! Probes: names looked up, expressions compiled and put in order.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use nalgebra::{Matrix3, Vector3};

use super::context::{Context, Names};
use super::joints::Bodies;
use super::properties::Properties;
use super::steps::Groups;
use crate::error::{InputError, Span};
use crate::hsim::Part;
use crate::input::read::{Map, Named, Spanned, suggest};
use crate::input::{self, Component, Direction, Greatest, ProbeTable, RotationProbe};
use crate::model::{FixedLaw, Member, Node, PRESTRESS, SegmentLaw, Step};
use crate::probes::{Along, AxialPlace, Matter, Operand, Probe, Probes, Quantity};

/// What probes refer to.
pub(crate) struct Observed<'a> {
    pub(crate) nodes: &'a [Option<Node>],
    pub(crate) node_names: &'a Names,
    pub(crate) member_names: &'a Names,
    pub(crate) members: &'a [Option<Member>],
    pub(crate) groups: &'a Groups,
    pub(crate) properties: &'a Properties,
    pub(crate) bodies: &'a Bodies,
    pub(crate) steps: &'a [Step],
}

/// Warns of probes of the rotation of nodes that have none, of those that stand `still`.
pub(crate) fn warn_of_rotations(
    probes: &Probes,
    map: Option<&Map<Spanned<input::Probe>>>,
    still: &[bool],
    nodes: &[Node],
    cx: &mut Context,
) {
    for (probe, named) in probes.probes.iter().zip(map.into_iter().flatten()) {
        let (Probe::Rotation { node, .. } | Probe::Angle { node }) = *probe else { continue };
        if still[node] {
            let message = format!(
                "probe '{}' asks for the rotation of node '{}', which has none and stays at zero: the ends of members there are released from it",
                named.name, nodes[node].name
            );
            cx.warn(
                InputError::new(message)
                    .at(named.value.span)
                    .help("weld the end of the member whose rotation is meant to the node"),
            );
        }
    }
}

/// Resolves the probes; whether they are those of a plane network is set later.
pub(crate) fn probes(map: Option<&Map<Spanned<input::Probe>>>, observed: &Observed<'_>, cx: &mut Context) -> Probes {
    let entries: Vec<&Named<Spanned<input::Probe>>> = map.into_iter().flatten().collect();
    let names = Names::new("probe", entries.iter().map(|named| named.name.as_str()));
    let step_names: Vec<&str> = match observed.steps {
        [] => vec![PRESTRESS],
        steps => steps.iter().map(|step| step.name.as_str()).collect(),
    };
    let steps = Names::new("step", step_names.into_iter());
    let parameters: FxHashMap<String, f64> = cx.parameter_values().collect();
    let probes: Vec<Option<Probe>> = entries
        .iter()
        .map(|named| match &named.value.value {
            input::Probe::Expression(text) => expression(named, text, &names, &steps, &parameters, cx),
            input::Probe::Quantity(table) => quantity(named, table, observed, cx),
        })
        .collect();
    let Some(mut probes) = probes.into_iter().collect::<Option<Vec<Probe>>>() else { return Probes::default() };
    let indices = probes.iter_mut().filter_map(|probe| match probe {
        Probe::Stiffness { index, .. } => Some(index),
        _ => None,
    });
    for (index, next) in indices.zip(0..) {
        *index = next;
    }
    number_sections(&mut probes);
    let order = order(&probes, &entries, cx).unwrap_or_default();
    Probes { names: names.iter().map(str::to_owned).collect(), probes, order, in_plane: false }
}

/// Numbers the members whose sections are looked at in the order in which the probes name them.
fn number_sections(probes: &mut [Probe]) {
    let mut known = FxHashMap::default();
    for probe in probes {
        let Probe::Greatest { members, .. } = probe else { continue };
        for along in members {
            let next = known.len();
            along.index = *known.entry(along.member).or_insert(next);
        }
    }
}

fn needs(probe: &Probe) -> Vec<usize> {
    let Probe::Expression { operands, .. } = probe else { return Vec::new() };
    let needed = operands.iter().filter_map(|operand| match operand {
        Operand::Probe(probe) | Operand::After { probe, .. } => Some(*probe),
        Operand::Parameter(_) => None,
    });
    needed.collect()
}

/// An order in which each probe comes after those that it needs.
fn order(probes: &[Probe], entries: &[&Named<Spanned<input::Probe>>], cx: &mut Context) -> Option<Vec<usize>> {
    let needs: Vec<Vec<usize>> = probes.iter().map(needs).collect();
    let mut users = vec![Vec::new(); probes.len()];
    for (user, needed) in needs.iter().enumerate() {
        needed.iter().for_each(|&probe| users[probe].push(user));
    }
    let mut open: Vec<usize> = needs.iter().map(Vec::len).collect();
    let mut ready: Vec<usize> = (0..probes.len()).rev().filter(|&probe| open[probe] == 0).collect();
    let mut order = Vec::with_capacity(probes.len());
    while let Some(probe) = ready.pop() {
        order.push(probe);
        for &user in &users[probe] {
            open[user] -= 1;
            if open[user] == 0 {
                ready.push(user);
            }
        }
    }
    if order.len() == probes.len() {
        return Some(order);
    }
    let stuck = (0..probes.len()).find(|&probe| open[probe] > 0)?;
    cx.error(
        InputError::new(format!("probe '{}' depends on itself", entries[stuck].name))
            .at(entries[stuck].value.span)
            .label("refers to itself, perhaps through others")
            .help("let one of the probes measure a node, a body or a member"),
    );
    None
}

fn expression(
    named: &Named<Spanned<input::Probe>>,
    text: &str,
    names: &Names,
    steps: &Names,
    parameters: &FxHashMap<String, f64>,
    cx: &mut Context,
) -> Option<Probe> {
    let span = named.value.span;
    if !text.trim_start().starts_with('=') {
        cx.error(
            InputError::new(format!("the text of probe '{}' is no expression", named.name))
                .at(span)
                .help(format!("an expression begins with '=': \"= {}\"", text.trim())),
        );
        return None;
    }
    let start = text.find('=').map_or(0, |at| at + 1);
    let parsed = match cx.parsed(&text[start..]) {
        Ok(parsed) => parsed,
        Err(error) => {
            let at = cx.inside(span, text, start + error.place.start..start + error.place.end);
            cx.error(InputError::new(error.message).at(at).help("write for example \"= -stroke / 17.9\""));
            return None;
        }
    };
    let mut operands = Vec::new();
    for reference in parsed.expression.references() {
        let at = cx.inside(span, text, start + reference.place.start..start + reference.place.end);
        let probe = names.get(&reference.name);
        operands.push(match (&reference.step, probe, parameters.get(&reference.name)) {
            (None, Some(probe), _) => Operand::Probe(probe),
            (None, None, Some(&value)) => Operand::Parameter(value),
            (Some(step), Some(probe), _) => {
                let owner = format!("probe '{}'", named.name);
                Operand::After { probe, step: steps.find(step, at, &owner, cx)? }
            }
            _ => {
                let known: Vec<&str> = names.iter().chain(parameters.keys().map(String::as_str)).collect();
                cx.error(
                    InputError::new(format!(
                        "probe '{}' refers to '{}', which is no probe or parameter",
                        named.name, reference.name
                    ))
                    .at(at)
                    .label("not known")
                    .help(suggest(&reference.name, known.into_iter(), "names")),
                );
                return None;
            }
        });
    }
    Some(Probe::Expression { expression: Arc::clone(&parsed.expression), operands })
}

/// The one quantity that a table asks for.
fn quantity(
    named: &Named<Spanned<input::Probe>>,
    table: &ProbeTable,
    observed: &Observed<'_>,
    cx: &mut Context,
) -> Option<Probe> {
    let owner = format!("probe '{}'", named.name);
    let moved = [table.displacement.is_some(), table.position.is_some(), table.rotation.is_some()];
    let compliant = [table.stiffness.is_some(), table.compliance.is_some()];
    let along = [table.stress.is_some(), table.strain.is_some(), table.moment.is_some()];
    let count = |given: &[bool]| given.iter().filter(|&&given| given).count();
    let single =
        [table.reaction.is_some(), table.normal.is_some(), table.distance.is_some(), table.axial_force.is_some()];
    let [reaction, normal, distant, axial] = single;
    let places = [table.node.is_some(), table.nodes.is_some(), table.body.is_some(), table.member.is_some()];
    let one = count(&moved) + count(&compliant) + count(&along) + count(&single) == 1 && count(&places) == 1;
    let fitting = match (&table.node, &table.nodes, &table.body) {
        (Some(_), ..) => reaction || count(&moved) + count(&compliant) == 1,
        (_, Some(_), _) => distant,
        (_, _, Some(_)) => normal || count(&moved) + count(&compliant) == 1,
        _ => axial || count(&along) == 1,
    };
    if !one || !fitting {
        cx.error(
            InputError::new(format!("{owner} does not ask for one quantity of one thing")).at(named.value.span).help(
                "{ node, displacement | position | rotation | reaction | stiffness }, { nodes, distance = true }, \
                 { body, displacement | position | rotation | normal | stiffness } or \
                 { member, axial_force | stress | strain | moment }",
            ),
        );
        return None;
    }
    if let Some(node) = &table.node {
        let index = observed.node_names.find(&node.value, node.span, &owner, cx)?;
        return node_quantity(index, table, observed, &owner, cx);
    }
    if let Some(list) = &table.nodes {
        return distance(list, table, observed, &owner, cx);
    }
    if let Some(body) = &table.body {
        let names = Names::new("rigid body", observed.bodies.bodies.iter().map(|body| body.name.as_str()));
        let index = names.find(&body.value, body.span, &owner, cx);
        let Some(normal) = &table.normal else {
            return node_quantity(observed.bodies.bodies[index?].reference, table, observed, &owner, cx);
        };
        let normal = cx.direction(normal, format_args!("the normal of {owner}"));
        return Some(Probe::Tilt { reference: observed.bodies.bodies[index?].reference, normal: normal?.into() });
    }
    let member = table.member.as_ref()?;
    let Some(place) = &table.axial_force else { return greatest(member, table, observed, &owner, cx) };
    let place = match place.value {
        input::AxialPlace::Start => AxialPlace::Start,
        input::AxialPlace::Middle => AxialPlace::Middle,
        input::AxialPlace::End => AxialPlace::End,
    };
    Some(Probe::AxialForce { member: observed.member_names.find(&member.value, member.span, &owner, cx)?, place })
}

/// The greatest stress, strain or moment along a member, or along all of a group or of the network.
fn greatest(
    name: &Spanned<String>,
    table: &ProbeTable,
    observed: &Observed<'_>,
    owner: &str,
    cx: &mut Context,
) -> Option<Probe> {
    let (word, whole, bending) = match (&table.stress, &table.strain, &table.moment) {
        (Some(word), ..) => (word, Quantity::Stress, Quantity::BendingStress),
        (_, Some(word), _) => (word, Quantity::Strain, Quantity::BendingStrain),
        (.., word) => (word.as_ref()?, Quantity::Moment, Quantity::Moment),
    };
    let quantity = match word.value {
        Greatest::Max => whole,
        Greatest::Bending => bending,
    };
    let named: Vec<usize> = match observed.groups.get(name.value.as_str()) {
        Some(group) => group.clone(),
        None if name.value == "all" => (0..observed.members.len()).collect(),
        None => vec![observed.member_names.find(&name.value, name.span, owner, cx)?],
    };
    let mut members = Vec::with_capacity(named.len());
    for index in named {
        let member = observed.members[index].as_ref()?;
        let segments: Option<Vec<Matter>> =
            member.segments.iter().map(|segment| matter(&segment.material, observed.properties)).collect();
        let along = Along { member: index, index: 0, segments: segments?, turn: Matrix3::identity() };
        let shapeless = along.segments.iter().any(|matter| matches!(matter, Matter::Fixed { shape: None, .. }));
        if shapeless && quantity != Quantity::Moment {
            cx.error(
                InputError::new(format!(
                    "{owner} asks for a stress or strain of member '{}', whose section gives stiffnesses outright",
                    member.name
                ))
                .at(word.span)
                .label("no shape, no outermost fibre")
                .help("ask for moment = \"max\", or give the section as a circle, annulus or rectangle"),
            );
            return None;
        }
        members.push(along);
    }
    Some(Probe::Greatest { quantity, members })
}

pub(crate) fn matter(law: &SegmentLaw, properties: &Properties) -> Option<Matter> {
    let muscle = |index: usize, part| {
        let muscle = properties.muscles[index].as_ref()?.muscle.clone();
        Some(Matter::Muscle { muscle, part })
    };
    match *law {
        SegmentLaw::MuscleEnd(index) => muscle(index, Part::End),
        SegmentLaw::MuscleMiddle(index) => muscle(index, Part::Middle),
        SegmentLaw::Fixed(FixedLaw { section, shape, .. }) => Some(Matter::Fixed { section, shape }),
    }
}

fn distance(
    list: &Spanned<Vec<Spanned<String>>>,
    table: &ProbeTable,
    observed: &Observed<'_>,
    owner: &str,
    cx: &mut Context,
) -> Option<Probe> {
    let complain = |cx: &mut Context, message: String, span: Span| {
        cx.error(InputError::new(message).at(span).help("write { nodes = [\"A\", \"B\"], distance = true }"));
    };
    let [first, second] = list.value.as_slice() else {
        complain(cx, format!("{owner} measures between two nodes, not {}", list.value.len()), list.span);
        return None;
    };
    if let Some(distance) = &table.distance
        && !distance.value
    {
        complain(cx, format!("{owner} says distance = false"), distance.span);
        return None;
    }
    let first = observed.node_names.find(&first.value, first.span, owner, cx);
    let second = observed.node_names.find(&second.value, second.span, owner, cx);
    let nodes = [first?, second?];
    let [start, end] = nodes.map(|node| observed.nodes[node].as_ref().map(|node| Vector3::from(node.position)));
    Some(Probe::Distance { nodes, unloaded: (end? - start?).into() })
}

fn node_quantity(
    node: usize,
    table: &ProbeTable,
    observed: &Observed<'_>,
    owner: &str,
    cx: &mut Context,
) -> Option<Probe> {
    let unit = |axis: usize| std::array::from_fn(|other| if other == axis { 1.0 } else { 0.0 });
    if let Some(displacement) = &table.displacement {
        let direction = match &displacement.value {
            Direction::Word(component) if component.index() < 3 => unit(component.index()),
            Direction::Word(component) => {
                cx.error(
                    InputError::new(format!(
                        "{owner} asks for the displacement '{}'",
                        Component::WORDS[component.index()]
                    ))
                    .at(displacement.span)
                    .help(format!("write rotation = \"{}\"", Component::WORDS[component.index()])),
                );
                return None;
            }
            Direction::Vector(list) => along(list, displacement.span, owner, cx)?,
        };
        return Some(Probe::Displacement { node, direction });
    }
    if let Some(position) = &table.position {
        let direction = match &position.value {
            Direction::Word(axis) => unit(*axis as usize),
            Direction::Vector(list) => along(list, position.span, owner, cx)?,
        };
        let unloaded = observed.nodes[node].as_ref()?.position;
        return Some(Probe::Position { node, unloaded, direction });
    }
    if let Some(rotation) = &table.rotation {
        return Some(match rotation.value {
            RotationProbe::Angle => Probe::Angle { node },
            component => Probe::Rotation { node, axis: component as usize },
        });
    }
    if table.stiffness.is_some() || table.compliance.is_some() {
        return stiffness(node, table, owner, cx);
    }
    let reaction = table.reaction.as_ref()?;
    Some(match &reaction.value {
        Direction::Word(component) if component.index() < 3 => {
            Probe::ReactionForce { node, direction: unit(component.index()) }
        }
        Direction::Word(component) => Probe::ReactionMoment { node, axis: component.index() - 3 },
        Direction::Vector(list) => Probe::ReactionForce { node, direction: along(list, reaction.span, owner, cx)? },
    })
}

fn stiffness(node: usize, table: &ProbeTable, owner: &str, cx: &mut Context) -> Option<Probe> {
    let inverse = table.stiffness.is_none();
    let asked = table.stiffness.as_ref().or(table.compliance.as_ref())?;
    let mut direction = [0.0; 6];
    match &asked.value {
        Direction::Word(component) => direction[component.index()] = 1.0,
        Direction::Vector(list) => direction[..3].copy_from_slice(&along(list, asked.span, owner, cx)?),
    }
    // The indices are set when all probes are known.
    Some(Probe::Stiffness { index: 0, node, along: direction, inverse })
}

fn along(list: &[input::read::Number], span: Span, owner: &str, cx: &mut Context) -> Option<[f64; 3]> {
    let list = Spanned { span, value: list.to_vec() };
    Some(cx.direction(&list, format_args!("the direction of {owner}"))?.into())
}
