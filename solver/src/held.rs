//! Axial forces that no strain gives: those of members that cannot be stretched.
//!
//! Such a force N is a multiplier. An iteration adds to it the auxiliary stiffness k times the stretch that is left (the
//! method of multipliers: Bertsekas, Constrained Optimization and Lagrange Multiplier Methods, 1982, chapter 2). With F, the
//! stretch by which the rest of the network gives way to a unit of N, the error of N falls by 1/(1 + k F) an iteration: to
//! nothing, but where the rest is nearly as stiff as the auxiliary stiffness, or stiffer. There the response of what an
//! iteration adds to what it began with is known from the iterations so far, and a secant through them leads to where
//! nothing is added any more (Anderson, J. ACM 12, 1965; Walker & Ni, SIAM J. Numer. Anal. 49, 2011).
//!
//! Two cases have no answer. Where F is zero nothing determines N: a straight member between two nodes that cannot come
//! nearer. And under a load across it such a member has no equilibrium: it could bend only if its ends came nearer, F falls
//! as the square of what N lets it bend, and every secant leads to a larger N. A member that can hardly be stretched always has one:
//! its own stretch answers to N.

use crate::chain::{HeldForce, add_held_force, held_force};
use crate::structure::MemberId;
use crate::system::System;

/// What an iteration adds is slow to vanish where it is more than this part of what the one before added.
const SLOW: f64 = 0.1;
/// An iteration takes back no more than all, and this, of what the forces changed by.
const ALL: f64 = 1.5;
/// Iterations that a secant is drawn through at most.
const DEPTH: usize = 6;
/// Steps of the iteration for singular values at most: two or three for each are the rule.
const STEPS: usize = 1000;
/// Responses smaller than this part of the largest are rounding, and so are all where they are this part of what is added.
const RESPONSE: f64 = 1e-9;
/// A secant that adds more than this part of the force, with its sign, so many times in a row leads to no finite force: where
/// the response is linear the first one leaves next to nothing to the second.
const GROWS: f64 = 0.1;
const TIMES: usize = 6;
/// A secant through forces that differ by more than this part of the larger tells nothing of the response to either.
const NEAR: f64 = 0.1;
/// Strain that is rounding: so many units in the last place of the places of the ends, over the length of the member.
const PLACES: f64 = 16.0;
/// Part of the largest force that such a strain may stand for where something determines the force.
const RESOLVED: f64 = 1e-2;
/// Strain whose force, with the auxiliary stiffness, is tried on a member to see whether anything answers to it; iterations
/// in which what answers takes most of it back; and the part of it that the last one must take back then.
const TRIED: f64 = 1e-9;
const ANSWERS: usize = 4;
const ANSWERED: f64 = 1e-6;
/// The part of what was tried that must be left for nothing to have answered.
const LEFT: f64 = 1e-2;

/// Forces that an iteration began with, and what it added to them.
#[derive(Clone, Debug, Default)]
struct Tried {
    forces: Vec<f64>,
    added: Vec<f64>,
}

/// The axial forces of the members that cannot be stretched, along an iteration.
///
/// A system keeps it from one solve to the next for its memory: what it holds is of one solve.
#[derive(Debug, Default)]
pub struct HeldForces {
    members: Vec<MemberId>,
    /// What the present iteration begins with.
    forces: Vec<f64>,
    /// What it came to.
    reached: Vec<f64>,
    /// Iterations so far, as near as they tell of the next, the oldest first.
    tried: Vec<Tried>,
    /// Memory of iterations that were dropped.
    spare: Vec<Tried>,
    /// Whether secants lead on.
    hastened: bool,
    /// How many of them in a row asked for much more of the same.
    grown: usize,
    /// Part of a change of the forces that the last of them took back.
    response: f64,
}

impl HeldForces {
    /// Begins with the forces of the present state.
    pub(crate) fn begin<const D: usize>(&mut self, system: &System<D>) {
        self.members.clear();
        self.drop_oldest(self.tried.len());
        (self.hastened, self.grown, self.response) = (false, 0, 0.0);
        if !system.loading.holds_strains() {
            return;
        }
        let holds = |&member: &MemberId| held_of(system, member).is_some();
        self.members.extend((0..system.members.count()).filter(holds));
        read(system, &self.members, &mut self.forces);
        // Once for all solves: an iteration takes no memory.
        self.tried.reserve(DEPTH);
        self.spare.resize_with(DEPTH, Tried::default);
        for spare in &mut self.spare {
            spare.forces.reserve(self.members.len());
            spare.added.reserve(self.members.len());
        }
    }

    fn drop_oldest(&mut self, count: usize) {
        self.spare.extend(self.tried.drain(..count));
    }

    /// Takes note of what an iteration added, and hastens the forces where that is slow to vanish.
    ///
    /// `near` tells whether the iteration was so small that the next one will be like it. Gives the member whose force grows
    /// without end, where there is one.
    pub(crate) fn follow<const D: usize>(&mut self, system: &mut System<D>, near: bool) -> Option<MemberId> {
        if self.members.is_empty() {
            return None;
        }
        read(system, &self.members, &mut self.reached);
        if !near {
            (self.hastened, self.grown) = (false, 0);
            self.drop_oldest(self.tried.len());
        }
        if self.tried.len() == DEPTH {
            self.drop_oldest(1);
        }
        let mut own = self.spare.pop().unwrap_or_default();
        own.added.clear();
        own.added.extend(self.reached.iter().zip(&self.forces).map(|(a, b)| a - b));
        std::mem::swap(&mut own.forces, &mut self.forces);
        std::mem::swap(&mut self.forces, &mut self.reached);
        self.tried.push(own);
        self.forget_what_differs();
        let [.., before, last] = self.tried.as_slice() else { return None };
        let rounded = (0..self.members.len()).all(|index| self.is_rounding(system, index));
        self.hastened |= !rounded && largest(&last.added).1 > SLOW * largest(&before.added).1;
        if !self.hastened {
            return None;
        }
        let moved = farthest(&last.forces, &before.forces);
        if moved > 0.0 {
            self.response = farthest(&last.added, &before.added) / moved;
        }
        if rounded {
            let index = largest(&before.added).0;
            return (!self.is_resolved(system, index) && self.is_rigid(system, index)).then(|| self.members[index]);
        }
        let Some(shift) = self.secant() else {
            // Nothing answers: the ends of the member are farther apart, or nearer, than it is long.
            self.grown += 1;
            let index = largest(&last.added).0;
            return (self.grown >= TIMES && self.is_rigid(system, index)).then(|| self.members[index]);
        };
        let (index, most) = largest(&shift);
        let grows = shift[index] * self.forces[index] > 0.0 && most > GROWS * self.forces[index].abs();
        self.grown = if grows { self.grown + 1 } else { 0 };
        if self.grown >= TIMES && self.is_rigid(system, index) {
            return Some(self.members[index]);
        }
        for (index, &by) in shift.iter().enumerate() {
            add(system, self.members[index], by);
            self.forces[index] += by;
        }
        None
    }

    /// Drops what tells nothing of the next iteration.
    ///
    /// An iteration takes back a part of what it finds too much, between none and all of it: what changes by more than the forces
    /// did is that the network moved.
    fn forget_what_differs(&mut self) {
        let [.., before, last] = self.tried.as_slice() else { return };
        if farthest(&last.added, &before.added) > ALL * farthest(&last.forces, &before.forces) {
            self.drop_oldest(self.tried.len() - 1);
            (self.hastened, self.grown) = (false, 0);
        }
    }

    /// What leads from the forces of the last iteration to where nothing would be added any more.
    fn secant(&self) -> Option<Vec<f64>> {
        let (rows, last) = (self.members.len(), self.tried.last()?);
        // More differences than forces would contradict each other.
        let columns = (self.tried.len() - 1).min(rows);
        let pairs = &self.tried[self.tried.len() - columns - 1..];
        let change = |of: fn(&Tried) -> &[f64]| {
            nalgebra::DMatrix::from_fn(rows, columns, |i, j| of(&pairs[j + 1])[i] - of(&pairs[j])[i])
        };
        let (begun, added) = (change(|tried| &tried.forces), change(|tried| &tried.added));
        // Singular values of what is not finite are iterated for without end.
        if !added.iter().all(|by| by.is_finite()) {
            return None;
        }
        let svd = added.clone().try_svd(true, true, 5.0 * f64::EPSILON, STEPS)?;
        let most = svd.singular_values.max();
        if !(most > RESPONSE * largest(&last.added).1) {
            return None;
        }
        let target = nalgebra::DVector::from_column_slice(&last.added);
        let weights = svd.solve(&target, RESPONSE * most).ok()?;
        let shift = -(begun + added) * weights;
        shift.iter().all(|by| by.is_finite()).then(|| shift.iter().copied().collect())
    }

    /// Whether the forces would change by no more than this part of the largest force in the network.
    pub(crate) fn are_settled<const D: usize>(&self, system: &System<D>, part: f64) -> bool {
        let Some(last) = self.tried.last() else { return true };
        let scale = force_scale(system);
        (0..self.members.len()).all(|index| {
            let added = last.added[index].abs();
            let left = match self.tried.as_slice() {
                [.., before, last] => {
                    let forces = [last.forces[index], before.forces[index]];
                    let apart = (forces[0] - forces[1]).abs();
                    if self.hastened
                        && added > 0.0
                        && apart > (NEAR * forces[0].abs().max(forces[1].abs())).max(part * scale)
                    {
                        return false;
                    }
                    // Where an iteration takes back the part s of an error, the rest of it is left.
                    let response = (last.added[index] - before.added[index]).abs();
                    let s = response / apart;
                    if self.hastened { added / s } else { added * (1.0 - s).abs() / s }
                }
                _ => added,
            };
            // A force that did not change tells nothing of its response.
            let left = if left.is_nan() { added } else { left };
            let determined = || self.is_resolved(system, index) || !self.is_rigid(system, index);
            let rounded = self.is_rounding(system, index) && (!self.hastened || determined());
            left <= part * scale || rounded
        })
    }

    /// Whether what the last iteration added is what rounding makes of the stretch.
    fn is_rounding<const D: usize>(&self, system: &System<D>, index: usize) -> bool {
        self.tried.last().is_none_or(|last| last.added[index].abs() <= self.rounding(system, index))
    }

    /// Whether the response to a force is so large that rounding leaves some digits of the force.
    fn is_resolved<const D: usize>(&self, system: &System<D>, index: usize) -> bool {
        self.rounding(system, index) <= RESOLVED * self.response * force_scale(system)
    }

    /// What iterations leave of so many times the forces that are tried on the members, and what the last of them changed of it, as
    /// strains of the auxiliary stiffness; the state is as it was. `None` where there is no iteration.
    fn left_of<const D: usize>(&self, system: &mut System<D>, auxiliary: &[f64], times: f64) -> Option<[Vec<f64>; 2]> {
        let here = system.snapshot();
        let (mut begun, mut now) = (Vec::new(), Vec::new());
        read(system, &self.members, &mut begun);
        let mut left: Vec<f64> = (0..auxiliary.len()).map(|index| times * tried(index)).collect();
        for (index, &member) in self.members.iter().enumerate() {
            add(system, member, left[index] * auxiliary[index]);
        }
        let pending = system.pattern.equations.has_general();
        let mut change = Vec::new();
        for _ in 0..ANSWERS {
            system.assemble(pending);
            if system.advance(pending).is_none() {
                change.clear();
                break;
            }
            read(system, &self.members, &mut now);
            let since: Vec<f64> = (0..now.len()).map(|index| (now[index] - begun[index]) / auxiliary[index]).collect();
            change = since.iter().zip(&left).map(|(since, left)| since - left).collect();
            left = since;
            if times > 0.0 && largest(&left).1 <= LEFT * TRIED {
                break;
            }
        }
        system.restore(&here);
        system.assemble(pending);
        (!change.is_empty()).then_some([left, change])
    }

    /// Whether nothing of the member answers to its force: one that can hardly be stretched has a stretch that does, however small.
    fn is_rigid<const D: usize>(&self, system: &System<D>, index: usize) -> bool {
        held_of(system, self.members[index]).is_some_and(|held| held.is_rigid)
    }

    /// Force that an iteration adds for what rounding makes of the stretch.
    fn rounding<const D: usize>(&self, system: &System<D>, index: usize) -> f64 {
        let strain = |length: f64| PLACES * f64::EPSILON * (system.size / length).max(1.0);
        held_of(system, self.members[index]).map_or(0.0, |held| strain(held.length) * held.auxiliary)
    }
}

/// Members that cannot be stretched whose axial force nothing determines at the present state, which is an equilibrium.
///
/// A little more force is tried on all of them; iterations take back what anything answers to. It is measured by the strain that the
/// auxiliary stiffness of each member would have under it: forces that are in equilibrium with each other are of one size in soft and in
/// stiff members, and what is left of that size in a stiff one is nothing beside what was tried on it.
pub(crate) fn undetermined<const D: usize>(system: &mut System<D>) -> Vec<MemberId> {
    let mut held = HeldForces::default();
    held.begin(system);
    held.members.retain(|&member| held_of(system, member).is_some_and(|held| held.is_rigid));
    if held.members.is_empty() {
        return Vec::new();
    }
    let auxiliary: Vec<f64> =
        held.members.iter().map(|&member| held_of(system, member).map_or(1.0, |held| held.auxiliary)).collect();
    let Some([mut left, change]) = held.left_of(system, &auxiliary, 1.0) else { return Vec::new() };
    if largest(&left).1 <= LEFT * TRIED {
        return Vec::new();
    }
    // Beside a singular state iterations move what they began with too, and not by what was tried.
    let Some([moved, _]) = held.left_of(system, &auxiliary, 0.0) else { return Vec::new() };
    left.iter_mut().zip(moved).for_each(|(left, moved)| *left -= moved);
    // What grows on with what was tried is not taken back either.
    let taken = |(change, left): (&f64, &f64)| -change * left.signum();
    let all_stay = change.iter().zip(&left).all(|by| taken(by) <= ANSWERED * largest(&left).1);
    // What answers slowly in one part of the network says nothing of the others.
    let stays = |index: usize| {
        let rounding = held.rounding(system, index) / auxiliary[index];
        all_stay || change[index].abs() <= (ANSWERED * left[index].abs()).max(rounding)
    };
    let shows = |&index: &usize| left[index].abs() > LEFT * TRIED && stays(index);
    let force = |index: usize| left[index].abs() * auxiliary[index];
    let most = (0..left.len()).filter(shows).map(force).fold(0.0, f64::max);
    let kept = |&index: &usize| most > 0.0 && force(index) > LEFT * most && stays(index);
    (0..left.len()).filter(kept).map(|index| held.members[index]).collect()
}

/// The strain that stands for the force tried on the member of this index.
///
/// Of no pattern: forces that are undetermined together are so in one proportion alone, and in a frame that needs no support their
/// products with the lengths of its members add up to zero (Maxwell 1864), so that equal strains would show nothing of them.
fn tried(index: usize) -> f64 {
    // Multiples of the golden ratio leave parts that are spread as evenly as can be.
    let part = (index as f64 * 0.618_033_988_749_894_9).fract();
    let sign = if part < 0.5 { 1.0 } else { -1.0 };
    sign * TRIED * (1.0 - part.min(1.0 - part))
}

/// The axial force of a member that no strain gives, if there is one.
fn held_of<const D: usize>(system: &System<D>, member: MemberId) -> Option<HeldForce> {
    let slot = &system.members.slots[member];
    held_force(system.members.packs[slot.pack].as_ref(), slot.lane)
}

fn read<const D: usize>(system: &System<D>, members: &[MemberId], forces: &mut Vec<f64>) {
    let force = |&member: &MemberId| held_of(system, member).map_or(0.0, |held| held.force);
    forces.clear();
    forces.extend(members.iter().map(force));
}

fn add<const D: usize>(system: &mut System<D>, member: MemberId, by: f64) {
    let slot = &system.members.slots[member];
    let (pack, lane) = (slot.pack, slot.lane);
    add_held_force(system.members.packs[pack].as_mut(), lane, by);
}

/// The largest force of the last assembly; where there are moments alone, what counts as no less beside them.
fn force_scale<const D: usize>(system: &System<D>) -> f64 {
    system.tangent.force_scale.max(1e-3 * system.tangent.moment_scale / system.size)
}

/// Largest difference of two numbers of the same place.
fn farthest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Where the number of largest size stands, and that size.
fn largest(values: &[f64]) -> (usize, f64) {
    let sizes = values.iter().map(|value| value.abs()).enumerate();
    sizes.fold((0, 0.0), |most, size| if size.1 > most.1 { size } else { most })
}
