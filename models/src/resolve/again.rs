//! The numbers of a network that follow its parameters, evaluated again.
//!
//! Nothing is said of what is wrong: there is no model then.

use std::borrow::Cow;

use pennate_solver::structure::Dimension;

use super::compiled::Compiled;
use super::context::Context;
use super::joints::{self, Bodies};
use super::members::{self, Surroundings};
use super::properties::{self, Properties};
use super::topology::{self, Place};
use super::{check_planar_only, dimension, has_mass, node_place, plane, probes, steps, strain_limit};
use crate::discretize::plane_turn;
use crate::model::{Model, Target};
use crate::probes::{Operand, Probe};

/// Gives a model of the first evaluation, or of one like this, the numbers that follow the parameters.
pub(super) fn evaluate(compiled: &Compiled, model: &mut Model, cx: &mut Context) -> Option<()> {
    let properties = made_of(compiled, cx)?;
    place(compiled, model, &properties, cx)?;
    join(compiled, model, cx)?;
    act(compiled, model, &properties, cx)?;
    observe(compiled, model, &properties, cx)?;
    lie(compiled, model, cx)?;
    model.strain_limit = strain_limit(&compiled.network, cx);
    for (parameter, stated) in model.parameters.iter_mut().zip(&cx.stated) {
        parameter.value = stated.number;
    }
    Some(())
}

/// Materials, sections and muscles.
fn made_of<'a>(compiled: &'a Compiled, cx: &mut Context) -> Option<Cow<'a, Properties>> {
    let (network, follows) = (&compiled.network, &compiled.follows);
    let mut all = Cow::Borrowed(&compiled.found.properties);
    for &index in &follows.materials {
        all.to_mut().materials[index] = Some(properties::material(&network.materials.as_ref()?.0[index], cx)?);
    }
    for &index in &follows.sections {
        all.to_mut().sections[index] = Some(properties::profile(&network.sections.as_ref()?.0[index], cx)?);
    }
    for &index in &follows.muscles {
        all.to_mut().muscles[index] = Some(cx.muscle(&network.muscles.as_ref()?.0[index])?);
    }
    Some(all)
}

/// Nodes and members.
fn place(compiled: &Compiled, model: &mut Model, properties: &Properties, cx: &mut Context) -> Option<()> {
    let (network, follows) = (&compiled.network, &compiled.follows);
    for &index in &follows.nodes {
        model.nodes[index].position = node_place(&network.nodes.as_ref()?.0[index], cx)?;
    }
    let Model { nodes, members, .. } = model;
    let place = |node: usize| Some(nodes[node].position);
    let (names, formulation) = (&compiled.found.nodes, compiled.formulation());
    let around = Surroundings { names, place: &place, properties, formulation };
    for &index in &follows.members {
        members::again(&mut members[index], &network.members.as_ref()?.0[index], &around, cx)?;
    }
    for &index in &follows.made {
        members::made_again(&mut members[index], &network.members.as_ref()?.0[index], properties, cx)?;
    }
    for &index in &follows.muscles {
        model.muscles[index] = properties.muscles[index].as_ref()?.muscle.clone();
    }
    Some(())
}

/// Bodies, supports and springs, and that no two nodes came to one place.
fn join(compiled: &Compiled, model: &mut Model, cx: &mut Context) -> Option<()> {
    let (network, follows, found) = (&compiled.network, &compiled.follows, &compiled.found);
    if follows.bodies {
        let bodies = Bodies::resolve(network.rigid_bodies.as_ref(), &found.nodes, model.nodes.len(), cx).bodies;
        for (body, again) in model.bodies.iter_mut().zip(bodies) {
            body.mass = again.mass;
        }
    }
    if follows.supports {
        let supports = joints::supports(network.supports.as_ref(), &found.nodes, &found.bodies, cx);
        for (support, (again, _)) in model.supports.iter_mut().zip(supports) {
            support.axes = again.axes;
        }
    }
    let Model { nodes, springs, .. } = model;
    let place = |node: usize| Some(nodes[node].position);
    if follows.springs {
        *springs = joints::springs(network.springs.as_ref(), &found.nodes, &place, cx);
    }
    let place: &Place<'_> = &place;
    let apart =
        follows.nodes.is_empty() || topology::coincident(nodes.len(), place, springs, &found.bodies, 1).is_empty();
    apart.then_some(())
}

/// Steps.
fn act(compiled: &Compiled, model: &mut Model, properties: &Properties, cx: &mut Context) -> Option<()> {
    let (network, follows, found) = (&compiled.network, &compiled.follows, &compiled.found);
    let rotations = match follows.rotations {
        true => {
            let members = model.members.iter();
            Cow::Owned(topology::rotations(model.nodes.len(), members, &model.springs, &found.bodies))
        }
        false => Cow::Borrowed(found.rotations.as_slice()),
    };
    let actors = compiled.actors(properties, &rotations);
    for (index, held) in &follows.steps {
        let data = &network.steps.as_ref()?[*index].value;
        steps::again(&mut model.steps[*index], data, &actors, &mut held.clone(), cx);
    }
    // Where nothing has a mass any more, or something has for the first time, there is more to say about gravity.
    let is_heavy = |target: &Target| matches!(target, Target::Gravity(_));
    let pulled = model.steps.iter().flat_map(|step| &step.targets).any(|(target, _)| is_heavy(target));
    let massive = || {
        let heavy = model.bodies.iter().any(|body| body.mass > 0.0);
        heavy || model.members.iter().any(|member| has_mass(member, properties))
    };
    (!pulled || massive() == found.has_mass).then_some(())
}

/// Probes.
fn observe(compiled: &Compiled, model: &mut Model, properties: &Properties, cx: &Context) -> Option<()> {
    let follows = &compiled.follows;
    for &(probe, operand, parameter) in &follows.operands {
        if let Probe::Expression { operands, .. } = &mut model.probes.probes[probe] {
            operands[operand] = Operand::Parameter(cx.parameters[parameter]?.value);
        }
    }
    let Model { nodes, members, probes, dimension, .. } = model;
    let place = |node: usize| nodes[node].position;
    for probe in &mut probes.probes {
        match probe {
            Probe::Position { node, unloaded, .. } => *unloaded = place(*node),
            Probe::Distance { nodes: [first, second], unloaded } => {
                let [first, second] = [place(*first), place(*second)];
                *unloaded = std::array::from_fn(|c| second[c] - first[c]);
            }
            Probe::Greatest { members: along, .. } => {
                for along in along {
                    let member = &members[along.member];
                    for (matter, segment) in along.segments.iter_mut().zip(&member.segments) {
                        *matter = probes::matter(&segment.material, properties)?;
                    }
                    along.turn = plane_turn(*dimension, member);
                }
            }
            _ => {}
        }
    }
    Some(())
}

/// Whether the network lies in the plane, or leaves it, as before.
fn lie(compiled: &Compiled, model: &mut Model, cx: &mut Context) -> Option<()> {
    let found = &compiled.found;
    let supports = (model.supports.as_slice(), found.support_places.as_slice());
    let written = compiled.network.probes.as_ref();
    let out = plane::leaves_plane(&model.nodes, &model.members, supports, &model.steps)
        .or_else(|| plane::probe_leaves(&model.probes, written));
    if dimension(compiled.network.dimension, out.as_ref(), cx) != model.dimension {
        return None;
    }
    check_planar_only(&model.members, &found.planar_only, model.dimension, out.as_ref(), cx);
    model.why_space = out.map(|(reason, _)| reason).filter(|_| model.dimension == Dimension::Space);
    Some(())
}
