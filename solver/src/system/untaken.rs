//! Forces and moments that nothing takes: what joints, and ends that are kept from turning, are out of balance by.
//!
//! Equations hold the motions in balance that joints are free to make. Motions that no force belongs to are none of them
//! ([`Idle`], [`EndKind`]), so a force on one of these would be silent, were it not measured here. It is there for a good reason where a
//! straight bar that is pinned at both ends is kept from turning about itself, and bends in its course: then it has a moment about
//! itself there, which nothing takes.

use std::collections::BTreeSet;

use pennate_elements::rotation::turn;
use pennate_elements::small::{V3, cross, dot, norm, sub};

use super::System;
use crate::joints::{EndKind, Idle};
use crate::reduce::kept_spin;
use crate::structure::{Member, MemberId, NodeId};

/// Part of the largest moment that is no moment: the accuracy asked for where nothing else is said.
const NONE: f64 = 1e-6;

/// What nothing takes at a state.
#[derive(Debug, Default)]
pub(crate) struct Untaken {
    /// Bars with a moment about themselves.
    pub bars: Vec<MemberId>,
    /// Nodes with a moment on their joint.
    pub nodes: Vec<NodeId>,
}

/// The moment about itself of a bar that is kept from turning: at an end of it, or at a joint of its line.
struct Torque {
    moment: f64,
    members: Vec<MemberId>,
}

impl<const D: usize> System<D> {
    /// What nothing takes at the last assembly, where it is more than a little.
    pub(crate) fn untaken(&mut self) -> Untaken {
        self.find_multipliers();
        let (_, scale) = self.tangent.scales(&self.loading, self.size);
        let mut found = Untaken::default();
        let mut bars = BTreeSet::new();
        for (joint, mut force) in self.left_on_joints().into_iter().enumerate() {
            // What is left along free motions is the residual.
            let free = self.pattern.equations.unbalanced(joint, &force);
            force.iter_mut().zip(free).for_each(|(force, free)| *force -= free);
            if !(norm([force[3], force[4], force[5]]) > NONE * scale) {
                continue;
            }
            match self.spinning_at(joint, &force) {
                Some(torque) if torque.moment > NONE * scale => bars.extend(torque.members),
                _ => found.nodes.push(self.topology.references[joint]),
            }
        }
        bars.extend(self.kept_ends().filter(|torque| torque.moment > NONE * scale).flat_map(|torque| torque.members));
        // One that is alike in all directions is the same however it is turned: its moments are rounding.
        found.bars = bars.into_iter().filter(|&member| self.round_axis(member).is_none()).collect();
        found
    }

    /// Whether what acts on nodes in part has a moment that nothing takes, at the last assembly: what keeps hinges there from turning about
    /// themselves. What is in no balance is no equilibrium.
    pub fn leaves_moments(&mut self) -> bool {
        let acted = |(joint, idle): (usize, &Idle)| {
            matches!(idle, Idle::Spin(_) | Idle::Spins(_))
                && !self.topology.turned[self.topology.references[joint]].is_left_alone()
        };
        D == 6 && self.topology.idle.iter().enumerate().any(acted) && !self.untaken().nodes.is_empty()
    }

    /// What is left of all forces and moments on joints, and on ends that are kept from turning, over the largest of their kind: the
    /// larger of both. Reactions are those that were found last.
    pub(crate) fn joint_balance(&self) -> f64 {
        let mut largest = [0.0; 2];
        for [f0, f1, f2, m0, m1, m2] in self.left_on_joints() {
            largest = [f64::max(largest[0], norm([f0, f1, f2])), f64::max(largest[1], norm([m0, m1, m2]))];
        }
        let kept = self.kept_ends().map(|torque| torque.moment).fold(0.0, f64::max);
        let (force, moment) = self.tangent.scales(&self.loading, self.size);
        (largest[0] / force).max(largest[1].max(kept) / moment)
    }

    /// The force on every joint less the reactions that were found last.
    fn left_on_joints(&self) -> Vec<[f64; 6]> {
        let mut left = self.tangent.forces.clone();
        let equations = &self.pattern.equations;
        for (index, held) in equations.held.iter().enumerate() {
            let link = self.topology.links[held.node];
            let (force, moment) = equations.reaction(index, &self.topology, &self.places.joints);
            let lever = turn(self.places.joints[link.joint].place.rotation, link.arm);
            let about = cross(lever, force);
            let own = &mut left[link.joint];
            for &c in &equations.active {
                own[c] -= if c < 3 { force[c] } else { moment[c - 3] + about[c - 3] };
            }
        }
        left
    }

    /// What keeps the bars of a line from turning at a joint takes, of all that is left there, where it is along the line.
    fn spinning_at(&self, joint: usize, left: &[f64; 6]) -> Option<Torque> {
        let Idle::Spin(axis) = self.topology.idle[joint] else { return None };
        let along = |&(_, member): &(usize, &Member)| norm(cross(member.axes[0], axis)) < 1e-9;
        let here =
            |&(_, member): &(usize, &Member)| member.nodes.iter().any(|&node| self.topology.links[node].joint == joint);
        let members = self.structure.members.iter().enumerate().filter(here).filter(along);
        let members: Vec<MemberId> = members.map(|(index, _)| index).collect();
        let axis = turn(self.places.joints[joint].place.rotation, axis);
        let moment: V3<f64> = [left[3], left[4], left[5]];
        let across = sub(moment, axis.map(|c| c * dot(moment, axis)));
        (!members.is_empty() && norm(across) < dot(moment, axis).abs())
            .then(|| Torque { moment: dot(moment, axis).abs(), members })
    }

    /// Moments about themselves of bars one end of which is kept from turning.
    fn kept_ends(&self) -> impl Iterator<Item = Torque> {
        let bars = self
            .topology
            .ends
            .iter()
            .enumerate()
            .filter(move |_| D != 3)
            .filter(|(_, ends)| ends.iter().any(EndKind::keeps_spin));
        bars.map(|(index, _)| {
            let ends = self.end_info(index, &self.tangent.ends[index]);
            let of = |end| kept_spin(&end).map_or(0.0, |axis| dot(end.moment, axis).abs());
            Torque { moment: ends.into_iter().map(of).fold(0.0, f64::max), members: vec![index] }
        })
    }
}
