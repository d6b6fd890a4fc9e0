//! Which joints a member carries along.
//!
//! A joint that nothing holds goes where the members between it and the supports carry it, not where the linearized
//! motion points: over a chain of many joints that curls up the straight line would stretch what lies between. Where
//! several ways lead to a support, the stiffest carries; the others follow with what they then miss.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::Arc;

use super::{Pattern, System};
use crate::joints::{EndKind, Idle};
use crate::structure::MemberId;

/// A joint, and the member at whose far end it goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Carrier {
    pub joint: usize,
    pub member: MemberId,
    /// The member's end at the joint.
    pub end: usize,
}

/// A compliance, to order by.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Softness(f64);

impl Eq for Softness {}

impl PartialOrd for Softness {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Softness {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl<const D: usize> Pattern<D> {
    /// Lets carriers be found anew, once it is known what is held.
    pub(super) fn forget_carriers(&mut self) {
        self.has_carriers = false;
    }

    fn set_carriers(&mut self, carriers: Vec<Carrier>) {
        self.carried.fill(false);
        for carrier in &carriers {
            self.carried[carrier.joint] = true;
        }
        self.carriers = Arc::new(carriers);
        self.has_carriers = true;
    }
}

impl<const D: usize> System<D> {
    /// Finds carriers where those that are known are of another structure or other rows.
    pub(super) fn renew_carriers(&mut self) {
        if !self.pattern.has_carriers {
            let carriers = self.find_carriers();
            self.pattern.set_carriers(carriers);
        }
    }

    /// The tree of stiffest ways (Dijkstra, compliance in bending as length) from the joints that something holds.
    fn find_carriers(&self) -> Vec<Carrier> {
        // Equations alone, as those out of the plane, move nothing.
        if self.members.packs.is_empty() {
            return Vec::new();
        }
        let count = self.pattern.equations.joints.len();
        let carried: Vec<bool> = (0..count)
            .map(|joint| self.topology.idle[joint] == Idle::None && self.pattern.equations.holds_nothing(joint))
            .collect();
        if !carried.contains(&true) {
            return Vec::new();
        }
        let mut ends = Vec::with_capacity(2 * self.members.count());
        let mut ways = Vec::with_capacity(self.members.count());
        for (index, member) in self.structure.members.iter().enumerate().take(self.members.count()) {
            let joints = member.nodes.map(|n| self.topology.links[n].joint);
            let welded = self.topology.ends[index].iter().all(|end| *end == EndKind::Welded);
            if welded && joints[0] != joints[1] {
                ends.extend(joints.map(|joint| (joint, index)));
            }
            ways.push((joints, self.softness(index)));
        }
        ends.sort_unstable();
        // Those of each joint, one after the other.
        let mut starts = vec![0; count + 1];
        ends.iter().for_each(|&(joint, _)| starts[joint + 1] += 1);
        (0..count).for_each(|joint| starts[joint + 1] += starts[joint]);

        let mut tree = Vec::with_capacity(count);
        let mut reached = vec![false; count];
        let mut heap = BinaryHeap::with_capacity(count + ends.len());
        // What no member leads to from a held joint starts a tree of its own.
        heap.extend((0..count).filter(|&joint| !carried[joint]).map(|joint| (Reverse(Softness(0.0)), joint, None)));
        for joint in 0..=count {
            while let Some((Reverse(Softness(softness)), joint, carrier)) = heap.pop() {
                if std::mem::replace(&mut reached[joint], true) {
                    continue;
                }
                tree.extend(carrier);
                for &(_, member) in &ends[starts[joint]..starts[joint + 1]] {
                    let (joints, own) = ways[member];
                    let end = usize::from(joints[0] == joint);
                    let next = joints[end];
                    if !reached[next] && carried[next] && self.topology.idle[joint] == Idle::None {
                        let carrier = Carrier { joint: next, member, end };
                        heap.push((Reverse(Softness(softness + own)), next, Some(carrier)));
                    }
                }
            }
            if joint < count && !reached[joint] {
                heap.push((Reverse(Softness(0.0)), joint, None));
            }
        }
        tree
    }

    /// By how much a member bends for a unit of force, without its factor.
    fn softness(&self, member: MemberId) -> f64 {
        let segments = &self.structure.members[member].segments;
        let length: f64 = segments.iter().map(|segment| segment.length).sum();
        let bending = |(index, segment): (usize, &crate::structure::Segment)| {
            let section = self.section(member, index).section;
            let stiffness = if D == 3 { section.ei3 } else { section.ei2.min(section.ei3) };
            segment.length / stiffness
        };
        length * length * segments.iter().enumerate().map(bending).sum::<f64>()
    }
}
