//! Resisting what turns parts of a network about the axes that everything about them is symmetric to.
//!
//! Turned about its line as a whole, with everything on it spun back about itself by as much, Λ → R Λ Rᵀ for every joint, a part keeps its
//! energy. As long as it is straight that moves nothing. Once it has buckled the plane in which it bends turns, and no force resists: the
//! tangent has a motion without stiffness, of which rounding, the residual and the stiffness behind held strains make a small one of
//! either sign. Since that motion is known exactly it need not be judged: a spring on one joint resists it, from where the state is, so
//! that it bears no force. No other motion becomes stiffer by that: where K t = 0 the negative pivots of K + k n nᵀ, with n·t other than
//! zero, are those of K. Newton's increments, whose right-hand side is at right angles to t, have no part along n then.
//!
//! A round member between two hinges, in any network, may be turned about the line between its ends in the same way, with nothing else
//! moving: the spring is on one of its ends then.
//!
//! Theory: docs/theory/stability.md, section Turning freely.

use pennate_elements::rotation::{compose, inverse, log, turn};
use pennate_elements::small::{V3, add, cross, dot, norm, scale, sub};

use super::symmetry::{is_round, lies_along};
use super::{State, System, Turning};
use crate::chain::{MemberEnds, Middle};
use crate::joints::EndKind;
use crate::structure::MemberId;

/// Motion of a joint (radians, or displacement over the size of the network) for a radian by which all is turned, below which the network
/// lies along the axis still: columns that stand straight keep to it within 1e-12 up to their critical load, and lean by 2e-2 a
/// ten-thousandth beyond it, and else with the root of that.
pub(super) const IN_LINE: f64 = 1e-6;

impl<const D: usize> System<D> {
    /// Parts that may be turned while no joint moves in that.
    pub(super) fn turned_inside(&self) -> Vec<&Turning> {
        self.turning.iter().filter(|turning| self.turned_most(turning).is_none()).collect()
    }

    /// The axis of a member that is straight and bends alike in all directions, in space.
    pub(super) fn round_axis(&self, index: usize) -> Option<V3<f64>> {
        (D == 6 && self.bends_alike(index)).then_some(self.structure.members[index].axes[0])
    }

    /// Whether a member is straight and bends alike in all directions.
    pub(super) fn bends_alike(&self, index: usize) -> bool {
        let member = &self.structure.members[index];
        let is_straight = |segment: usize| member.segments[segment].initial_curvature[1..] == [0.0; 2];
        (0..member.segments.len()).all(|segment| is_straight(segment) && is_round(&self.section(index, segment)))
    }

    /// Resists turning every part that has left its axis.
    pub(crate) fn resist_turning(&mut self) {
        let parts = std::mem::take(&mut self.turning);
        for turning in &parts {
            if let Some((joint, motion)) = self.turned_most(turning) {
                let factor = (turning.stiffness / self.square(&motion)).sqrt();
                let along = self.measured(&motion).map(|n| n * factor);
                let block = std::array::from_fn(|i| std::array::from_fn(|j| along[i] * along[j]));
                self.add_joint_block(joint, &block, None);
            }
        }
        self.turning = parts;
    }

    /// Whether a part has left its axis, so that turning it moves anything.
    pub(crate) fn has_left(&self, turning: &Turning) -> bool {
        let is_aside = |middle: &Middle| norm(cross(turning.axis, middle.displacement)) > IN_LINE * self.size;
        let own = |member: &MemberId| turning.members.contains(member);
        let inside: Vec<MemberId> = self.out_of_sight().into_iter().filter(own).collect();
        self.turned_most(turning).is_some() || self.middles(&inside).iter().any(is_aside)
    }

    /// The joint that moves most where a part is turned about its axis, and how it moves for a radian; nothing where none does.
    fn turned_most(&self, turning: &Turning) -> Option<(usize, [f64; 6])> {
        let axis = turning.axis;
        let motion = |joint: usize| {
            let place = &self.places.joints[joint].place;
            let (moved, spun) = (cross(axis, place.displacement), sub(axis, turn(place.rotation, axis)));
            [moved[0], moved[1], moved[2], spun[0], spun[1], spun[2]]
        };
        let is_free = |joint: &usize| self.pattern.equations.joints[*joint].count > 0;
        let joints = turning.joints.iter().copied().filter(is_free).map(|joint| (joint, motion(joint)));
        let most = joints.max_by(|(_, a), (_, b)| self.square(a).total_cmp(&self.square(b)));
        most.filter(|(_, motion)| self.square(motion) > IN_LINE * IN_LINE)
    }

    /// A motion of a joint as a functional: over lengths of the network, and in radians.
    fn measured(&self, motion: &[f64; 6]) -> [f64; 6] {
        std::array::from_fn(|c| if c < 3 { motion[c] / (self.size * self.size) } else { motion[c] })
    }

    fn square(&self, motion: &[f64; 6]) -> f64 {
        motion.iter().zip(self.measured(motion)).map(|(x, n)| x * n).sum()
    }

    /// How far (lengths of the network, or radians) joints, and middles of members out of sight, moved since a state besides what
    /// turning parts about their axes does: along these or away from them, or out of line by more. A spin about themselves is left out:
    /// of pinned members it is anything.
    pub(crate) fn moved_but_for_turning(&mut self, then: &State, parts: &[Turning]) -> f64 {
        let along_and_away = |axis: V3<f64>, vector: V3<f64>| [dot(axis, vector), norm(cross(axis, vector))];
        let apart = |axis: Option<V3<f64>>, now: V3<f64>, then: V3<f64>| {
            let Some(axis) = axis else { return norm(sub(now, then)) };
            let [[a, b], [c, d]] = [now, then].map(|vector| along_and_away(axis, vector));
            (a - c).abs().max((b - d).abs())
        };
        let members = self.out_of_sight();
        let now = self.middles(&members);
        let middles_then = self.middles_at(&members, then);
        let of_member =
            |member: &MemberId| parts.iter().find(|part| part.members.contains(member)).map(|part| part.axis);
        let axes = members.iter().map(of_member);
        let middles = axes.zip(now.iter().zip(&middles_then));
        let middles = middles.map(|(axis, (now, then))| apart(axis, now.displacement, then.displacement));
        let inside = middles.fold(0.0, f64::max) / self.size;
        let joints = self.places.joints.iter().zip(&then.places.joints).enumerate();
        let moved = joints.map(|(joint, (now, then))| {
            let axis = parts.iter().find(|part| part.joints.contains(&joint)).map(|part| part.axis);
            let [now, then] = [&now.place, &then.place];
            let shifted = apart(axis, now.displacement, then.displacement) / self.size;
            shifted.max(match axis {
                Some(own) => apart(axis, turn(now.rotation, own), turn(then.rotation, own)),
                None => norm(log(compose(now.rotation, inverse(then.rotation)))),
            })
        });
        moved.fold(inside, f64::max)
    }

    /// Resists turning a member by one of its released ends: about the line between its ends, where both are free to turn and nothing
    /// loads it across that line, or about the axis of its part where no joint moves in that. `ends` is what the member is
    /// eliminated to.
    pub(super) fn resist_turning_of_member(&self, index: usize, ends: &mut MemberEnds<D>) {
        if self.pattern.equations.active.len() != 6 {
            return;
        }
        let part = || {
            let own = self.turning.iter().find(|part| part.members.contains(&index));
            own.filter(|part| self.turned_most(part).is_none()).map(|part| (part.axis, part.stiffness))
        };
        let Some((axis, stiffness)) = self.turning_of_member(index).or_else(part) else { return };
        let Some((end, across)) = self.end_turned_most(index, axis) else { return };
        let square = dot(across, across);
        let block = if end == 0 { &mut ends.k00 } else { &mut ends.k11 };
        for i in 0..3 {
            for j in 0..3 {
                block[3 + i][3 + j] += stiffness / square * across[i] * across[j];
            }
        }
    }

    /// The released end of a member that leans most from an axis that it is turned about, and the part across it of its spin for a
    /// radian, whatever it spins about itself; nothing where none leans.
    pub(super) fn end_turned_most(&self, index: usize, axis: V3<f64>) -> Option<(usize, V3<f64>)> {
        let spin = |end: usize| {
            let tangent = turn(self.places.releases[index][end].rotation, self.members.slots[index].tangents[end]);
            (end, sub(axis, scale(dot(axis, tangent), tangent)))
        };
        let most = (0..2)
            .filter(|&end| self.turns_alike(index, end, axis))
            .map(spin)
            .max_by(|(_, a), (_, b)| norm(*a).total_cmp(&norm(*b)));
        most.filter(|(_, spin)| norm(*spin) > IN_LINE)
    }

    /// Whether an end lets a round member bend alike about all axes across this one: it is released, or hinged about two axes. Where the other
    /// end keeps the member from twisting these have to be across, too; else it spins about itself by as much as hinges ask for.
    fn turns_alike(&self, index: usize, end: usize, axis: V3<f64>) -> bool {
        let ends = &self.topology.ends[index];
        match &ends[end] {
            EndKind::Welded => false,
            EndKind::Free { .. } => true,
            EndKind::Axes { axes, kept } => {
                let [first, second] = axes[..] else { return false };
                let link = &self.topology.links[self.structure.members[index].nodes[end]];
                let normal = turn(self.places.joints[link.joint].place.rotation, cross(first, second));
                let spins = matches!(ends[1 - end], EndKind::Free { .. });
                kept.is_none() && (spins || lies_along(axis, normal))
            }
        }
    }

    /// The line between the ends of a member about which it may be turned with nothing else moving, and EI/L.
    fn turning_of_member(&self, index: usize) -> Option<(V3<f64>, f64)> {
        let member = &self.structure.members[index];
        if self.topology.ends[index].contains(&EndKind::Welded) {
            return None;
        }
        let places = member
            .nodes
            .map(|node| add(self.structure.nodes[node], self.places.pose(&self.topology.links[node]).displacement));
        let chord = sub(places[1], places[0]);
        let axis = scale(1.0 / norm(chord), chord);
        if !(0..2).all(|end| self.turns_alike(index, end, axis)) {
            return None;
        }
        let (pack, lane) = self.members.chain(index);
        let own = |segment: usize| self.section(index, segment);
        let turns = (0..member.segments.len()).all(|segment| {
            member.segments[segment].initial_curvature[1..] == [0.0; 2]
                && is_round(&own(segment))
                && lies_along(axis, pack.segment(lane, segment).load)
        });
        let bending = (0..member.segments.len()).map(|segment| own(segment).section.ei3).fold(0.0, f64::max);
        let stiffness = bending / member.length();
        (turns && norm(chord) > 0.0 && stiffness > 0.0).then_some((axis, stiffness))
    }

    /// Looks at the present state, linearized with nothing that resists turning; it is linearized as it was again afterwards.
    pub(crate) fn turning_freely<R>(&mut self, look: impl FnOnce(&mut Self) -> R) -> R {
        if self.turning.is_empty() {
            return look(self);
        }
        let turning = std::mem::take(&mut self.turning);
        self.assemble(false);
        let seen = look(self);
        self.turning = turning;
        self.assemble(false);
        seen
    }
}
