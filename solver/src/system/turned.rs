//! Bars that would turn about themselves.
//!
//! A straight bar that is pinned at both ends, or a line of them, may turn about itself without resistance: one end, or one
//! joint, is kept from that ([`EndKind::Free`], [`Idle::Spin`]). Where something bends the bar in its course it has a moment about
//! itself there, which nothing takes.

use std::collections::BTreeSet;

use pennate_elements::rotation::turn;
use pennate_elements::small::dot;

use super::System;
use crate::joints::{EndKind, Idle};
use crate::structure::MemberId;

/// Part of the largest moment that is no moment of a bar about itself: the accuracy asked for where nothing else is said.
const NONE: f64 = 1e-6;

impl<const D: usize> System<D> {
    /// Members with a moment about themselves that nothing takes, at the last assembly; none where they cannot turn out of a plane.
    pub(crate) fn turned_about_themselves(&self) -> Vec<MemberId> {
        if D == 3 {
            return Vec::new();
        }
        let mut torques = vec![(0.0, Vec::new()); self.topology.idle.len()];
        let mut found = BTreeSet::new();
        let moves = |moment: f64| moment.abs() > NONE * self.tangent.moment_scale;
        for (index, ends) in self.tangent.ends.iter().enumerate() {
            for (end, info) in self.end_info(index, ends).iter().enumerate() {
                let joint = self.topology.links[self.structure.members[index].nodes[end]].joint;
                match (info.kind, &self.topology.idle[joint]) {
                    (EndKind::Free { spin_removed: true }, _) => {
                        let tangent = turn(info.release.rotation, info.tangent);
                        if moves(dot(info.moment, tangent)) {
                            found.insert(index);
                        }
                    }
                    (EndKind::Welded | EndKind::Axes { .. }, Idle::Spin(axis)) => {
                        let (torque, members): &mut (f64, Vec<MemberId>) = &mut torques[joint];
                        *torque += dot(info.moment, turn(info.joint_rotation, *axis));
                        members.push(index);
                    }
                    _ => {}
                }
            }
        }
        found.extend(torques.into_iter().filter(|(torque, _)| moves(*torque)).flat_map(|(_, members)| members));
        // One that is alike in all directions is the same however it is turned: its moments are rounding.
        found.into_iter().filter(|&member| self.round_axis(member).is_none()).collect()
    }
}
