//! Parts of a network that everything about them is symmetric to an axis of.
//!
//! Round members, springs that are alike in all directions across, and bodies, all on one line, with supports and loads along it, keep
//! their energy where they are turned about that line. What does not move at all parts a network: two columns on one base are two parts,
//! and each may be turned by itself.
//!
//! Theory: docs/theory/stability.md, section Turning freely.

use pennate_elements::small::{V3, add, cross, dot, norm, scale, sub};

use super::System;
use super::parts::find;
use crate::joints::{Held, HeldKind, Topology};
use crate::structure::{Drive, MemberId, NodeId, Release, SectionState};

/// Part of a vector, or of a stiffness, that is rounding of what was read: directions, and sums of them.
const SAME: f64 = 1e-12;

/// A part of a network that may be turned about an axis with nothing changing but which way it bends.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Turning {
    /// Unit vector in global axes, along the line of the part.
    pub axis: V3<f64>,
    /// The nodes on that line at which anything acts.
    pub nodes: Vec<NodeId>,
    /// The joints that move with it.
    pub joints: Vec<usize>,
    /// Its members.
    pub members: Vec<MemberId>,
    /// What resists turning a joint by a radian: EI/L of the stiffest member, the same on every mesh, or the stiffest spring.
    pub(super) stiffness: f64,
}

/// Members and springs, the joints that they move, and the nodes at which anything acts on all that.
#[derive(Default)]
struct Part {
    joints: Vec<usize>,
    members: Vec<MemberId>,
    springs: Vec<usize>,
    nodes: Vec<NodeId>,
}

/// Whether a vector lies along an axis.
pub(super) fn lies_along(axis: V3<f64>, vector: V3<f64>) -> bool {
    norm(cross(axis, vector)) <= SAME * norm(vector)
}

/// Whether a section resists the same in all directions across the member.
pub(super) fn is_round(state: &SectionState) -> bool {
    let section = &state.section;
    let same = |a: f64, b: f64| a == b || (a - b).abs() <= SAME * a.abs();
    same(section.ei2, section.ei3) && same(section.ga2, section.ga3) && state.curvature[1..] == [0.0; 2]
}

/// What holds a network, and what that leaves of its joints.
pub(crate) struct Holds<'a> {
    /// Displacements and rotations that are held.
    rows: &'a [Held],
    /// Of every joint, whether it is held in all motions.
    fixed: Vec<bool>,
    /// Of every joint, whether it is held anywhere but where it was unloaded.
    moved: Vec<bool>,
}

impl<'a> Holds<'a> {
    /// By these rows; `is_fixed` tells of a joint whether they leave it no motion.
    pub(crate) fn new(topology: &Topology, rows: &'a [Held], is_fixed: impl Fn(usize) -> bool) -> Self {
        let fixed = (0..topology.references.len()).map(is_fixed).collect();
        let mut moved = vec![false; topology.references.len()];
        for held in rows {
            moved[topology.links[held.node].joint] |= held.from != 0.0 || held.to != 0.0;
        }
        Self { rows, fixed, moved }
    }
}

impl<const D: usize> System<D> {
    /// The parts of the network that may be turned at all loads of a ramp between these values of the drives, with what is held now and
    /// what fades.
    pub(crate) fn may_be_turned(&self, drives: [&[f64]; 2]) -> Vec<Turning> {
        let equations = &self.pattern.equations;
        if equations.active.len() != 6 {
            return Vec::new();
        }
        let holds = Holds::new(&self.topology, &equations.held, |joint| equations.holds_all(joint));
        self.turned_where(&holds, drives)
    }

    /// The same with other rows held, as those of a plane network and those out of its plane together.
    pub(crate) fn turned_where(&self, holds: &Holds<'_>, drives: [&[f64]; 2]) -> Vec<Turning> {
        if self.bends_everywhere(holds) {
            return Vec::new();
        }
        let parts = self.parts_between(holds);
        parts.into_iter().filter_map(|part| self.turned_part(part, holds, drives)).collect()
    }

    fn turned_part(&self, part: Part, holds: &Holds<'_>, drives: [&[f64]; 2]) -> Option<Turning> {
        let axis = self.line_of(&part.nodes)?;
        let stiffness = self.bending_of_round_members(&part, axis, drives)?.max(self.stiffest_spring(&part, axis)?);
        let turns = stiffness > 0.0
            && drives.into_iter().all(|drives| self.loads_lie_along(&part, axis, drives))
            && self.held_is_symmetric(&part, holds, axis);
        let Part { joints, members, mut nodes, .. } = part;
        nodes.sort_unstable();
        nodes.dedup();
        turns.then_some(Turning { axis, nodes, joints, members, stiffness })
    }

    /// Whether every member ends in a joint that moves, and members of different directions meet in all of these: no part lies on a line.
    fn bends_everywhere(&self, holds: &Holds<'_>) -> bool {
        let mut bends = holds.fixed.clone();
        let mut along = vec![[0.0; 3]; bends.len()];
        for member in &self.structure.members {
            let joints = member.nodes.map(|node| self.topology.links[node].joint);
            if joints.iter().all(|joint| holds.fixed[*joint]) {
                return false;
            }
            for joint in joints {
                match along[joint] == [0.0; 3] {
                    true => along[joint] = member.axes[0],
                    false => bends[joint] |= !lies_along(along[joint], member.axes[0]),
                }
            }
        }
        bends.into_iter().all(|bends| bends)
    }

    /// The parts that joints which do not move leave of a network.
    fn parts_between(&self, holds: &Holds<'_>) -> Vec<Part> {
        let structure = &self.structure;
        let joint_of = |node: NodeId| self.topology.links[node].joint;
        let count = holds.fixed.len();
        let members = structure.members.iter().map(|member| member.nodes.as_slice());
        let ends: Vec<&[NodeId]> = members.chain(structure.springs.iter().map(|spring| spring.nodes())).collect();
        // Members and springs are counted on after the joints.
        let mut root: Vec<usize> = (0..count + ends.len()).collect();
        for (index, nodes) in ends.iter().enumerate() {
            for joint in nodes.iter().map(|node| joint_of(*node)).filter(|joint| !holds.fixed[*joint]) {
                let [a, b] = [joint, count + index].map(|index| find(&mut root, index));
                root[a.max(b)] = a.min(b);
            }
        }
        let mut parts: Vec<Part> = (0..root.len()).map(|_| Part::default()).collect();
        for (index, nodes) in ends.iter().enumerate() {
            let part = &mut parts[find(&mut root, count + index)];
            part.nodes.extend_from_slice(nodes);
            // What is held and moved carries its part along.
            for joint in
                nodes.iter().map(|node| joint_of(*node)).filter(|joint| holds.fixed[*joint] && holds.moved[*joint])
            {
                part.nodes.push(self.topology.references[joint]);
                part.nodes.extend(holds.rows.iter().map(|held| held.node).filter(|node| joint_of(*node) == joint));
            }
            match index.checked_sub(structure.members.len()) {
                None => part.members.push(index),
                Some(spring) => part.springs.push(spring),
            }
        }
        for (index, &node) in self.topology.references.iter().enumerate().filter(|(index, _)| !holds.fixed[*index]) {
            let part = &mut parts[find(&mut root, index)];
            part.joints.push(index);
            part.nodes.push(node);
        }
        let acts = |drive: &Drive| match *drive {
            Drive::Force(node, _) | Drive::Moment(node, _) => Some(node),
            Drive::FollowerForce(node, _) | Drive::FollowerMoment(node, _) => Some(node),
            Drive::Control | Drive::Gravity(_) | Drive::Distributed(..) => None,
        };
        let loaded =
            structure.drives.iter().filter_map(acts).chain(self.loading.fading.iter().map(|fading| fading.node));
        for node in loaded.chain(holds.rows.iter().map(|held| held.node)).filter(|node| !holds.fixed[joint_of(*node)]) {
            parts[find(&mut root, joint_of(node))].nodes.push(node);
        }
        parts.retain(|part| !part.members.is_empty() || !part.springs.is_empty());
        parts
    }

    /// The direction of the line that nodes lie on, unloaded.
    fn line_of(&self, nodes: &[NodeId]) -> Option<V3<f64>> {
        let places = &self.structure.nodes;
        let first = places[*nodes.first()?];
        let apart = |node: &NodeId| sub(places[*node], first);
        let far = nodes.iter().map(apart).max_by(|a, b| norm(*a).total_cmp(&norm(*b)))?;
        let axis = scale(1.0 / norm(far), far);
        let in_line = |node: &NodeId| norm(cross(axis, apart(node))) <= SAME * self.size;
        (norm(far) > 0.0 && nodes.iter().all(in_line)).then_some(axis)
    }

    /// EI/L of the stiffest member, where all of them are straight and round between these values of the drives.
    fn bending_of_round_members(&self, part: &Part, axis: V3<f64>, [from, to]: [&[f64]; 2]) -> Option<f64> {
        let structure = &self.structure;
        let mut stiffest = 0.0_f64;
        for &index in &part.members {
            let member = &structure.members[index];
            let turns = member.releases.iter().all(|release| !matches!(release, Release::Axes(_)));
            if !turns || !lies_along(axis, member.axes[0]) {
                return None;
            }
            let controls = match member.control {
                Some(drive) => [from[drive], 0.5 * (from[drive] + to[drive]), to[drive]],
                None => [0.0; 3],
            };
            for segment in &member.segments {
                let states = controls.map(|control| structure.laws[segment.law].at(control));
                if segment.initial_curvature[1..] != [0.0; 2] || !states.iter().all(is_round) {
                    return None;
                }
                stiffest = states.iter().fold(stiffest, |most, state| most.max(state.section.ei3 / member.length()));
            }
        }
        Some(stiffest)
    }

    /// The stiffness against turning of the stiffest spring, where all of them are alike in all directions across an axis.
    fn stiffest_spring(&self, part: &Part, axis: V3<f64>) -> Option<f64> {
        part.springs
            .iter()
            .try_fold(0.0, |most: f64, &index| Some(most.max(self.structure.springs[index].stiffness_around(axis)?)))
    }

    fn loads_lie_along(&self, part: &Part, axis: V3<f64>, drives: &[f64]) -> bool {
        let structure = &self.structure;
        let mut forces = vec![[0.0; 3]; structure.nodes.len()];
        let mut lines = vec![[0.0; 3]; structure.members.len()];
        let mut gravity = [0.0; 3];
        let mut turns = vec![false; structure.nodes.len()];
        for (drive, &value) in structure.drives.iter().zip(drives) {
            match *drive {
                Drive::Control => {}
                Drive::Force(node, c) => forces[node][c] += value,
                Drive::Gravity(c) => gravity[c] += value,
                Drive::Distributed(member, c) => lines[member][c] += value,
                Drive::Moment(node, _) | Drive::FollowerForce(node, _) | Drive::FollowerMoment(node, _) => {
                    turns[node] |= value != 0.0;
                }
            }
        }
        for fading in &self.loading.fading {
            turns[fading.node] |= !lies_along(axis, fading.force) || fading.moment != [0.0; 3];
        }
        let on_nodes = part.nodes.iter().all(|&node| !turns[node] && lies_along(axis, forces[node]));
        on_nodes && part.members.iter().all(|&member| lies_along(axis, lines[member])) && lies_along(axis, gravity)
    }

    /// Whether what is held, displacements and rotation vectors apart, is the same however a part is turned about an axis.
    fn held_is_symmetric(&self, part: &Part, holds: &Holds<'_>, axis: V3<f64>) -> bool {
        part.nodes.iter().all(|&node| {
            // At rest it is where it was unloaded, whatever is turned about it.
            let joint = self.topology.links[node].joint;
            if holds.fixed[joint] && !holds.moved[joint] {
                return true;
            }
            [0, 3].into_iter().all(|offset| {
                let of_node = holds.rows.iter().filter(|held| held.node == node);
                let (mut count, mut across) = (0, 0);
                let mut askew = false;
                let mut values = [[0.0; 3]; 2];
                for held in of_node {
                    let direction = match held.kind {
                        HeldKind::Translation { direction } if offset == 0 => direction,
                        HeldKind::Rotation { axis } if offset == 3 => axis,
                        _ => continue,
                    };
                    count += 1;
                    let is_across = dot(axis, direction).abs() <= SAME;
                    across += usize::from(is_across);
                    askew |= !is_across && !lies_along(axis, direction);
                    for (sum, value) in values.iter_mut().zip([held.from, held.to]) {
                        *sum = add(*sum, scale(value, direction));
                    }
                }
                let whole = count == 3 || !askew && across != 1;
                whole && values.into_iter().all(|value| lies_along(axis, value))
            })
        })
    }
}
