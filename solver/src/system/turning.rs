//! Turning a network about an axis that everything about it is symmetric to.
//!
//! Round members in one line, with supports and loads along it, keep their energy where they are turned about that line as a whole, and
//! every member at the same time about itself, back by as much: Λ → R Λ Rᵀ for every joint. As long as the members are straight that moves
//! nothing. Once they have buckled the plane in which they bend turns, and no force resists: the tangent has a motion without stiffness, of
//! which rounding, the residual and the stiffness behind held strains make a small one of either sign. Since that motion is known exactly
//! it need not be judged: a spring on one joint resists it, from where the state is, so that it bears no force. No other motion becomes
//! stiffer by that: where K t = 0 the negative pivots of K + k n nᵀ, with n·t other than zero, are those of K. Newton's increments, whose
//! right-hand side is at right angles to t, have no part along n then.
//!
//! A round member between two hinges, in any network, may be turned about the line between its ends in the same way, with nothing else
//! moving: the spring is on one of its ends then.
//!
//! Theory: docs/theory/stability.md, section Turning freely.

use pennate_elements::rotation::turn;
use pennate_elements::small::{V3, add, cross, dot, norm, scale, sub};

use super::{State, System};
use crate::chain::{MemberEnds, Middle};
use crate::joints::{EndKind, HeldKind};
use crate::structure::{Drive, Release, SectionState};

/// Part of a vector, or of a stiffness, that is rounding of what was read: directions, and sums of them.
const SAME: f64 = 1e-12;
/// Motion of a joint (radians, or displacement over the size of the network) for a radian by which all is turned, below which the network
/// lies along the axis still: columns that stand straight keep to it within 1e-12 up to their critical load, and lean by 2e-2 a
/// ten-thousandth beyond it, and else with the root of that.
pub(super) const IN_LINE: f64 = 1e-6;

/// How a network may be turned as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turning {
    /// Unit vector in global axes.
    pub axis: V3<f64>,
    /// What resists turning a joint by a radian: EI/L of the stiffest member, the same on every mesh.
    stiffness: f64,
}

/// Whether a vector lies along an axis.
fn lies_along(axis: V3<f64>, vector: V3<f64>) -> bool {
    norm(cross(axis, vector)) <= SAME * norm(vector)
}

/// Whether a section resists the same in all directions across the member.
fn is_round(state: &SectionState) -> bool {
    let section = &state.section;
    let same = |a: f64, b: f64| a == b || (a - b).abs() <= SAME * a.abs();
    same(section.ei2, section.ei3) && same(section.ga2, section.ga3) && state.curvature[1..] == [0.0; 2]
}

impl<const D: usize> System<D> {
    /// How the network may be turned at all loads of a ramp between these values of the drives, with what is held now and what fades;
    /// nothing where it may not.
    pub(crate) fn may_be_turned(&self, drives: [&[f64]; 2]) -> Option<Turning> {
        let axis = self.line_of_nodes()?;
        let stiffness = self.bending_of_round_members(axis, drives)?;
        let turns = drives.into_iter().all(|drives| self.loads_lie_along(axis, drives)) && self.held_is_symmetric(axis);
        turns.then_some(Turning { axis, stiffness })
    }

    /// The direction of the line that all nodes lie on, unloaded, in space.
    fn line_of_nodes(&self) -> Option<V3<f64>> {
        let (structure, active) = (&self.structure, self.pattern.equations.active.len());
        if active != 6 || !structure.bodies.is_empty() || !structure.springs.is_empty() {
            return None;
        }
        let first = *structure.nodes.first()?;
        let apart = |node: &V3<f64>| sub(*node, first);
        let far = structure.nodes.iter().map(apart).max_by(|a, b| norm(*a).total_cmp(&norm(*b)))?;
        let axis = scale(1.0 / norm(far), far);
        let in_line = |node: &V3<f64>| norm(cross(axis, apart(node))) <= SAME * self.size;
        (norm(far) > 0.0 && structure.nodes.iter().all(in_line)).then_some(axis)
    }

    /// EI/L of the stiffest member, where all of them are straight and round between these values of the drives.
    fn bending_of_round_members(&self, axis: V3<f64>, [from, to]: [&[f64]; 2]) -> Option<f64> {
        let structure = &self.structure;
        let mut stiffest = 0.0_f64;
        for member in &structure.members {
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
        (stiffest > 0.0).then_some(stiffest)
    }

    fn loads_lie_along(&self, axis: V3<f64>, drives: &[f64]) -> bool {
        let structure = &self.structure;
        let mut forces = vec![[0.0; 3]; structure.nodes.len()];
        let mut lines = vec![[0.0; 3]; structure.members.len()];
        let mut gravity = [0.0; 3];
        let mut turns = false;
        for (drive, &value) in structure.drives.iter().zip(drives) {
            match *drive {
                Drive::Control => {}
                Drive::Force(node, c) => forces[node][c] += value,
                Drive::Gravity(c) => gravity[c] += value,
                Drive::Distributed(member, c) => lines[member][c] += value,
                Drive::Moment(..) | Drive::FollowerForce(..) | Drive::FollowerMoment(..) => turns |= value != 0.0,
            }
        }
        let fades = |fading: &super::Fading| lies_along(axis, fading.force) && fading.moment == [0.0; 3];
        let mut all = forces.iter().chain(&lines).chain([&gravity]);
        !turns && all.all(|load| lies_along(axis, *load)) && self.loading.fading.iter().all(fades)
    }

    /// Whether what is held, displacements and rotation vectors apart, is the same however the network is turned about an axis.
    fn held_is_symmetric(&self, axis: V3<f64>) -> bool {
        let held = &self.pattern.equations.held;
        (0..self.structure.nodes.len()).all(|node| {
            [0, 3].into_iter().all(|offset| {
                let of_node = held.iter().filter(|held| held.node == node);
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

    /// The axis about which the network may be turned as a whole while no joint moves in that; nothing where there is none.
    pub(super) fn turns_inside(&self) -> Option<V3<f64>> {
        self.turning.map(|turning| turning.axis).filter(|axis| self.turned_most(*axis).is_none())
    }

    /// How the network may be turned at its present loads, where no joint moves in that.
    pub(crate) fn turning_inside(&self) -> Option<Turning> {
        let drives = self.loading.drives.as_slice();
        self.may_be_turned([drives; 2]).filter(|turning| self.turned_most(turning.axis).is_none())
    }

    /// The axis of a member that is straight and bends alike in all directions, in space.
    pub(super) fn round_axis(&self, index: usize) -> Option<V3<f64>> {
        let member = &self.structure.members[index];
        let is_straight = |segment: usize| member.segments[segment].initial_curvature[1..] == [0.0; 2];
        let alike =
            (0..member.segments.len()).all(|segment| is_straight(segment) && is_round(&self.section(index, segment)));
        (D == 6 && alike).then_some(member.axes[0])
    }

    /// Resists turning about the axis, where there is one and the network has left it.
    pub(super) fn resist_turning(&mut self) {
        let Some(Turning { axis, stiffness }) = self.turning else { return };
        let Some((joint, motion)) = self.turned_most(axis) else { return };
        let factor = (stiffness / self.square(&motion)).sqrt();
        let along = self.measured(&motion).map(|n| n * factor);
        let block = std::array::from_fn(|i| std::array::from_fn(|j| along[i] * along[j]));
        self.add_joint_block(joint, &block);
    }

    /// Whether the network has left an axis, so that turning it moves anything.
    pub(crate) fn has_left(&self, axis: V3<f64>) -> bool {
        let is_aside = |middle: &Middle| norm(cross(axis, middle.displacement)) > IN_LINE * self.size;
        self.turned_most(axis).is_some() || self.middles(&self.out_of_sight()).iter().any(is_aside)
    }

    /// The joint that moves most where the network is turned about an axis, and how it moves for a radian; nothing where none does.
    fn turned_most(&self, axis: V3<f64>) -> Option<(usize, [f64; 6])> {
        let motion = |joint: usize| {
            let place = &self.places.joints[joint].place;
            let (moved, spun) = (cross(axis, place.displacement), sub(axis, turn(place.rotation, axis)));
            [moved[0], moved[1], moved[2], spun[0], spun[1], spun[2]]
        };
        let is_free = |joint: &usize| self.pattern.equations.joints[*joint].count > 0;
        let joints = (0..self.places.joints.len()).filter(is_free).map(|joint| (joint, motion(joint)));
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
    /// turning the network about an axis does: along it or away from it, or out of line by more. A spin about themselves is left out: of
    /// pinned members it is anything.
    pub(crate) fn moved_but_for_turning(&mut self, then: &State, axis: V3<f64>) -> f64 {
        let parts = |vector: V3<f64>| [dot(axis, vector), norm(cross(axis, vector))];
        let apart = |now: V3<f64>, then: V3<f64>| {
            let ([a, b], [c, d]) = (parts(now), parts(then));
            (a - c).abs().max((b - d).abs())
        };
        let members = self.out_of_sight();
        let now = self.middles(&members);
        let middles_then = self.middles_at(&members, then);
        let middles = now.iter().zip(&middles_then).map(|(now, then)| apart(now.displacement, then.displacement));
        let inside = middles.fold(0.0, f64::max) / self.size;
        let joints = self.places.joints.iter().zip(&then.places.joints);
        let moved = joints.map(|(now, then)| {
            let [now, then] = [&now.place, &then.place];
            let shifted = apart(now.displacement, then.displacement) / self.size;
            shifted.max(apart(turn(now.rotation, axis), turn(then.rotation, axis)))
        });
        moved.fold(inside, f64::max)
    }

    /// Resists turning a member by one of its released ends: about the line between its ends, where both are free to turn and nothing
    /// loads it across that line, or about the axis of the whole network where no joint moves in that. `ends` is what the member is
    /// eliminated to.
    pub(super) fn resist_turning_of_member(&self, index: usize, ends: &mut MemberEnds<D>) {
        if self.pattern.equations.active.len() != 6 {
            return;
        }
        let whole = || self.turning.filter(|turning| self.turned_most(turning.axis).is_none());
        let Some(Turning { axis, stiffness }) = self.turning_of_member(index).or_else(whole) else { return };
        let Some((end, across)) = self.end_turned_most(index, axis) else { return };
        let square = dot(across, across);
        let block = if end == 0 { &mut ends.k00 } else { &mut ends.k11 };
        for i in 0..3 {
            for j in 0..3 {
                block[3 + i][3 + j] += stiffness / square * across[i] * across[j];
            }
        }
    }

    /// The released end of a member that spins most where it is turned about an axis, and its spin for a radian; nothing where none does.
    fn end_turned_most(&self, index: usize, axis: V3<f64>) -> Option<(usize, V3<f64>)> {
        let spin = |end: usize| {
            let rotation = self.places.releases[index][end].rotation;
            (end, sub(axis, turn(rotation, self.members.slots[index].tangents[end])))
        };
        let is_free = |end: &usize| matches!(self.topology.ends[index][*end], EndKind::Free { .. });
        let most = (0..2).filter(is_free).map(spin).max_by(|(_, a), (_, b)| norm(*a).total_cmp(&norm(*b)));
        most.filter(|(_, spin)| norm(*spin) > IN_LINE)
    }

    /// How a member may be turned about the line between its ends with nothing else moving.
    fn turning_of_member(&self, index: usize) -> Option<Turning> {
        let member = &self.structure.members[index];
        if !self.topology.ends[index].iter().all(|end| matches!(end, EndKind::Free { .. })) {
            return None;
        }
        let places = member
            .nodes
            .map(|node| add(self.structure.nodes[node], self.places.pose(&self.topology.links[node]).displacement));
        let chord = sub(places[1], places[0]);
        let axis = scale(1.0 / norm(chord), chord);
        let (pack, lane) = self.members.chain(index);
        let own = |segment: usize| self.section(index, segment);
        let turns = (0..member.segments.len()).all(|segment| {
            member.segments[segment].initial_curvature[1..] == [0.0; 2]
                && is_round(&own(segment))
                && lies_along(axis, pack.segment(lane, segment).load)
        });
        let bending = (0..member.segments.len()).map(|segment| own(segment).section.ei3).fold(0.0, f64::max);
        let stiffness = bending / member.length();
        (turns && norm(chord) > 0.0 && stiffness > 0.0).then_some(Turning { axis, stiffness })
    }

    /// Looks at the present state, linearized with nothing that resists turning; it is linearized as it was again afterwards.
    pub(crate) fn turning_freely<R>(&mut self, look: impl FnOnce(&mut Self) -> R) -> R {
        let Some(turning) = self.turning.take() else { return look(self) };
        self.assemble(false);
        let seen = look(self);
        self.turning = Some(turning);
        self.assemble(false);
        seen
    }
}
