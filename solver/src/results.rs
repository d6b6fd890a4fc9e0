//! From the state of a system to the quantities of a user.

use pennate_elements::rotation::{log, turn};
use pennate_elements::small::{V3, add, dot, norm};

use crate::history::{Equilibrium, MemberShape, MemberState, NodeState};
use crate::joints::EndKind;
use crate::structure::{Dimension, Drive, Spring};
use crate::system::System;

/// Reads the equilibrium that the last assembly belongs to.
pub fn equilibrium<const D: usize>(system: &mut System<D>) -> Equilibrium {
    let forces = system.forces.clone();
    let fraction = system.fraction;
    let topology = system.topology.clone();
    let states = system.state.joints.clone();
    system.equations.find_multipliers(&topology, &states, &forces, fraction);

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
    for (index, held) in system.equations.held.iter().enumerate() {
        let (force, moment) = system.equations.reaction(index, &topology, &states);
        let node = &mut nodes[held.node];
        node.reaction_force = add(node.reaction_force, force);
        node.reaction_moment = add(node.reaction_moment, moment);
    }

    let mut members = Vec::with_capacity(system.members.len());
    let mut energy = system.spring_energy;
    for (index, slot) in system.members.iter().enumerate() {
        let pack = &system.packs[slot.pack];
        energy += pack.energy(slot.lane);
        let part = |end: usize, offset: usize| std::array::from_fn(|c| slot.ends[end][offset + c]);
        let mut end_moments = [part(0, 3), part(1, 3)];
        for (end, kind) in topology.ends[index].iter().enumerate() {
            if let EndKind::Free { .. } = kind {
                end_moments[end] = [0.0; 3];
            }
        }
        let end_forces: [V3<f64>; 2] = [part(0, 0), part(1, 0)];
        let axial = |end: usize| {
            let tangent = turn(pack.end(slot.lane, end).rotation, slot.tangents[end]);
            let sign = if end == 0 { -1.0 } else { 1.0 };
            sign * dot(tangent, end_forces[end])
        };
        let (tangent, carried) = pack.middle(slot.lane);
        members.push(MemberState {
            length: pack.length(slot.lane),
            axial_force: -dot(tangent, add(end_forces[0], carried)),
            axial_force_ends: [axial(0), axial(1)],
            end_forces,
            end_moments,
            control: system.structure.members[index].control.map_or(0.0, |drive| system.drives[drive]),
        });
    }
    let residual = system.residual();
    let balance = balance(system, &nodes);
    Equilibrium { nodes, members, springs: system.spring_forces.clone(), energy, residual: residual.largest(), balance }
}

/// Sum of all external forces over the largest of them.
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
    for (node, load) in system.loads.iter().enumerate() {
        let rotation = system.state.joints[system.topology.links[node].joint].place.rotation;
        count(add(load.force, turn(rotation, load.follower_force)));
    }
    for slot in &system.members {
        count(system.packs[slot.pack].total_load(slot.lane));
    }
    for (spring, _) in system.structure.springs.iter().zip(&system.spring_forces) {
        if let Spring::Ground { node, stiffness } = spring {
            let u = nodes[*node].displacement;
            count(std::array::from_fn(|c| if D == 3 && c == 2 { 0.0 } else { -stiffness[c] * u[c] }));
        }
    }
    if largest > system.rounding() { norm(sum) / largest } else { 0.0 }
}

/// Shapes of all members, in the members' own axes.
pub fn shapes<const D: usize>(system: &System<D>) -> Vec<MemberShape> {
    system
        .members
        .iter()
        .enumerate()
        .map(|(index, slot)| {
            let member = &system.structure.members[index];
            let origin = system.structure.nodes[member.nodes[0]];
            let f = slot.ends[0];
            let mut shape = system.packs[slot.pack].shape(slot.lane, origin, [f[0], f[1], f[2]], [f[3], f[4], f[5]]);
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

/// Whether any drive of a structure may load rotations of this node.
pub fn turns_node(drive: &Drive, node: usize) -> bool {
    matches!(*drive, Drive::Moment(n, _) | Drive::FollowerMoment(n, _) if n == node)
}
