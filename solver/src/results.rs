//! From the state of a system to the quantities of a user.

use pennate_elements::rotation::{log, turn};
use pennate_elements::small::{V3, add, dot, norm};

use crate::chain::{self, Measures, Middle, middle, total_load};
use crate::history::{Equilibrium, MemberShape, MemberState, NodeState, Peak, SectionForces};
use crate::joints::EndKind;
use crate::structure::Dimension;
use crate::system::System;

/// Reads the equilibrium that the last assembly belongs to.
pub fn equilibrium<const D: usize>(system: &mut System<D>) -> Equilibrium {
    read(system, true)
}

/// The same but for what is measured along members, and what all forces together leave: these are no numbers.
pub fn motions_and_forces<const D: usize>(system: &mut System<D>) -> Equilibrium {
    read(system, false)
}

fn read<const D: usize>(system: &mut System<D>, measured: bool) -> Equilibrium {
    let forces = system.tangent.forces.clone();
    let fraction = system.loading.fraction;
    let topology = system.topology.clone();
    let states = system.places.joints.clone();
    system.pattern.equations.find_multipliers(&topology, &states, &forces, fraction);

    let mut nodes: Vec<NodeState> = topology
        .links
        .iter()
        .map(|link| {
            let joint = &states[link.joint];
            NodeState {
                displacement: joint.point(link.arm),
                rotation: log(joint.place.rotation),
                rotation_total: if D == 3 { joint.place.angle } else { 0.0 },
                ..NodeState::default()
            }
        })
        .collect();
    for (index, held) in system.pattern.equations.held.iter().enumerate() {
        let (force, moment) = system.pattern.equations.reaction(index, &topology, &states);
        let node = &mut nodes[held.node];
        node.reaction_force = add(node.reaction_force, force);
        node.reaction_moment = add(node.reaction_moment, moment);
    }

    let ends = system.settled_ends();
    let mut members = Vec::with_capacity(system.members.count());
    let mut energy = system.tangent.spring_energy;
    let packs = system.members.packs.iter().filter(|_| measured);
    let measures: Vec<Vec<Measures>> = packs.map(|pack| pack.measures()).collect();
    for (index, slot) in system.members.slots.iter().enumerate() {
        let pack = system.members.packs[slot.pack].as_ref();
        energy += pack.interior(slot.lane).energy;
        let part = |end: usize, offset: usize| std::array::from_fn(|c| ends[index][end][offset + c]);
        let mut end_moments = [part(0, 3), part(1, 3)];
        for (end, kind) in topology.ends[index].iter().enumerate() {
            if let EndKind::Free { .. } = kind {
                end_moments[end] = [0.0; 3];
            }
        }
        let end_forces: [V3<f64>; 2] = [part(0, 0), part(1, 0)];
        let control = system.structure.members[index].control.map_or(0.0, |drive| system.loading.drives[drive]);
        if !measured {
            let [length, axial_force, value, at, top_energy] = [f64::NAN; 5];
            let [stretch, bending] = [Peak { value, at }; 2];
            let axial_force_ends = [f64::NAN; 2];
            members.push(MemberState {
                length,
                stretch,
                bending,
                axial_force,
                axial_force_ends,
                end_forces,
                end_moments,
                control,
                top_energy,
            });
            continue;
        }
        let axial = |end: usize| {
            let place = pack.node(slot.lane, end * pack.mesh().elements());
            let tangent = turn(place.rotation, slot.tangents[end]);
            let sign = if end == 0 { -1.0 } else { 1.0 };
            sign * dot(tangent, end_forces[end])
        };
        let Middle { tangent, carried, .. } = middle(pack, slot.lane);
        let Measures { length, stretch, bending, top_energy } = measures[slot.pack][slot.lane];
        members.push(MemberState {
            length,
            stretch,
            bending,
            axial_force: -dot(tangent, add(end_forces[0], carried)),
            axial_force_ends: [axial(0), axial(1)],
            end_forces,
            end_moments,
            control,
            top_energy,
        });
    }
    let residual = system.residual();
    let (balance, joint_balance) =
        if measured { (balance(system, &nodes), system.joint_balance()) } else { (f64::NAN, f64::NAN) };
    let compliances = Vec::new();
    let springs = system.tangent.spring_forces.clone();
    let residual = residual.largest();
    let sections = sections(system, &ends);
    Equilibrium {
        nodes,
        members,
        springs,
        compliances,
        sections,
        energy,
        residual,
        balance,
        joint_balance,
        rounding: None,
    }
}

/// Section forces along the members that a structure asks for, in the members' own axes.
fn sections<const D: usize>(system: &System<D>, ends: &[[[f64; 6]; 2]]) -> Vec<Vec<SectionForces>> {
    let along = |&member: &usize| {
        let slot = &system.members.slots[member];
        let origin = system.structure.nodes[system.structure.members[member].nodes[0]];
        let [f0, f1, f2, m0, m1, m2] = ends[member][0];
        let pack = system.members.packs[slot.pack].as_ref();
        let mut all = chain::sections(pack, slot.lane, origin, [f0, f1, f2], [m0, m1, m2]);
        if system.structure.dimension == Dimension::Plane {
            for section in &mut all {
                section.force = slot.turn.back_vector(section.force);
                section.moment = slot.turn.back_vector(section.moment);
            }
        }
        all
    };
    system.structure.sections.iter().map(along).collect()
}

/// Sum of all external forces over the largest of them; zero where these are what the residual leaves on all joints together.
fn balance<const D: usize>(system: &System<D>, nodes: &[NodeState]) -> f64 {
    let mut sum = [0.0; 3];
    let mut largest: f64 = 0.0;
    let mut count = |force: V3<f64>| {
        sum = add(sum, force);
        largest = largest.max(norm(force));
    };
    for node in nodes {
        count(node.reaction_force);
    }
    for (node, load) in system.loading.nodes.iter().enumerate() {
        let rotation = system.places.joints[system.topology.links[node].joint].place.rotation;
        count(add(load.force, turn(rotation, load.follower_force)));
    }
    for slot in &system.members.slots {
        count(total_load(system.members.packs[slot.pack].as_ref(), slot.lane));
    }
    for spring in &system.structure.springs {
        if let Some(mut force) = spring.ground_force(nodes[spring.nodes()[0]].displacement) {
            if D == 3 {
                force[2] = 0.0;
            }
            count(force);
        }
    }
    let left = system.forces_left().max(system.loading.rounding());
    if largest > left { norm(sum) / largest } else { 0.0 }
}

/// Shapes of all members, in the members' own axes.
pub(crate) fn shapes<const D: usize>(system: &System<D>) -> Vec<MemberShape> {
    let ends = system.settled_ends();
    system
        .members
        .slots
        .iter()
        .zip(&ends)
        .enumerate()
        .map(|(index, (slot, &[f, _]))| {
            let member = &system.structure.members[index];
            let origin = system.structure.nodes[member.nodes[0]];
            let pack = system.members.packs[slot.pack].as_ref();
            let mut shape = chain::shape(pack, slot.lane, origin, [f[0], f[1], f[2]], [f[3], f[4], f[5]]);
            if system.structure.dimension == Dimension::Plane {
                for point in &mut shape.points {
                    point.axes = slot.turn.back(&point.axes);
                }
                for cell in &mut shape.cells {
                    cell.force = slot.turn.back_vector(cell.force);
                    cell.moment = slot.turn.back_vector(cell.moment);
                }
            }
            shape
        })
        .collect()
}
