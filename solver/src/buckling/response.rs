//! The linear response of a state to the beginning of a ramp.
//!
//! Loads alone have a response in exact proportion, which one solve finds. Where sections, held motions or held strains take part
//! it is found on a short part of the ramp and on one twice as long, against the state at rest that is solved for in the same
//! way: what is of second order in the part drops out, and what the state was out of balance by. How far the two are out of
//! proportion says how large the part may be that is left, which is the square of that.

use pennate_elements::small::{add, norm, scale, sub};

use super::Beginning;
use crate::chain::ElementState;
use crate::spectral::operators::Stressing;
use crate::structure::Drive;
use crate::system::{State, System};

/// Part of the ramp by which its beginning is known, to begin with.
const BEGINNING: f64 = 1e-3;
/// How far stresses may be out of proportion there: what is left is the square.
const BENT: f64 = 1e-5;
/// By how much the part is made shorter where they are more, beyond what brings them there, and at most.
const BEYOND: f64 = 0.3;
const SHORTER: f64 = 1e-5;
/// How often. A shorter part that leaves more than this of the bend shows rounding, and is the last.
const TIMES: usize = 4;
const STRAIGHTER: f64 = 0.5;
/// Solves with corrected multipliers of rigid components.
const CORRECTIONS: usize = 8;
/// They are corrected where a solve moves joints by no more than this beside the one before.
const SAME: f64 = 1e-13;
/// Moments count no less than this part of forces times the size of the network.
const LEVER: f64 = 1e-3;

/// The linear response to the beginning of a ramp, per unit of its fraction.
pub(super) struct Response {
    /// Of every element of every member.
    pub stressings: Vec<Vec<Stressing>>,
    /// Forces and moments on the sections at the ends of every member.
    pub ends: Vec<[[f64; 6]; 2]>,
    /// Motions of the joints.
    pub motions: Vec<[f64; 6]>,
    /// Part of the ramp that it was found on.
    pub part: f64,
    /// Part of it that it may be off.
    pub error: f64,
}

/// What a part of the ramp makes of the state.
struct Stepped {
    states: Vec<Vec<ElementState<6>>>,
    ends: Vec<[[f64; 6]; 2]>,
    motions: Vec<[f64; 6]>,
}

impl Beginning {
    /// Loads and sections at a fraction of the ramp.
    pub(super) fn set(&mut self, fraction: f64) {
        let system = &mut self.base.system;
        system.fraction = fraction;
        for (value, (from, to)) in system.drives.iter_mut().zip(self.from.iter().zip(&self.to)) {
            *value = from + fraction * (to - from);
        }
        system.apply_drives();
    }

    /// The response of the state; nothing where it has none.
    pub(super) fn response(&mut self) -> Option<Response> {
        let system = &self.base.system;
        let start = system.snapshot();
        let rest = Stepped {
            states: states(system),
            ends: system.members.iter().map(|slot| slot.ends).collect(),
            motions: vec![[0.0; 6]; system.forces.len()],
        };
        let controls = system.structure.drives.iter().zip(self.from.iter().zip(&self.to));
        let sections = controls.into_iter().any(|(drive, (from, to))| matches!(drive, Drive::Control) && from != to);
        let moving = system.equations.held.iter().any(|row| row.from != row.to);
        let rigid = rest.states.iter().flatten().any(|state| state.moduli.held != [0.0; 6]);
        let response = if sections || moving || rigid {
            self.beginning(&start, &rest.ends, rigid)?
        } else {
            let whole = self.step(&start, &rest.ends, 1.0, false)?;
            Response::between(&rest, [&whole, &whole], [1.0, 0.0], 1.0)
        };
        self.set(0.0);
        self.base.system.assemble(false);
        Some(response)
    }

    /// The response found on a part of the ramp that is short enough for it to be straight.
    fn beginning(&mut self, start: &State, before: &[[[f64; 6]; 2]], rigid: bool) -> Option<Response> {
        let rest = self.step(start, before, 0.0, rigid)?;
        let size = self.base.system.size;
        let mut on = |part: f64| -> Option<(Response, f64)> {
            // Backwards it may be another row of a muscle's table.
            let (first, second) =
                (self.step(start, before, part, rigid)?, self.step(start, before, 2.0 * part, rigid)?);
            let bend = bend(&rest, &first, &second, size);
            let error = if bend <= BENT { bend * bend } else { bend };
            let response = Response::between(&rest, [&first, &second], [2.0 / part, -0.5 / part], part);
            Some((Response { error, ..response }, bend))
        };
        let mut part = BEGINNING;
        let mut found = on(part);
        for _ in 0..TIMES {
            // Where a part leads beyond a singular point there is no response.
            let bend = found.as_ref().map_or(f64::INFINITY, |found| found.1);
            if bend <= BENT {
                break;
            }
            part *= (BEYOND * BENT / bend).max(SHORTER);
            match on(part) {
                Some(shorter) if shorter.1 < STRAIGHTER * bend => found = Some(shorter),
                _ => break,
            }
        }
        found.map(|found| found.0)
    }

    /// Solves once for a fraction of the ramp, at the shape of the state.
    fn step(&mut self, start: &State, before: &[[[f64; 6]; 2]], fraction: f64, rigid: bool) -> Option<Stepped> {
        self.set(fraction);
        let system = &mut self.base.system;
        // Multipliers of rigid components need more than one solve. Each takes the stresses of the last along in its
        // tangent, which is of second order in the fraction.
        let mut motions: Vec<[f64; 6]> = Vec::new();
        for _ in 0..if rigid { CORRECTIONS } else { 1 } {
            system.assemble(true);
            system.advance(true)?;
            system.restore_shape(start, 1.0);
            let joints = 0..system.forces.len();
            let moved = joints.map(|joint| system.equations.motion(joint, &system.rhs, true)).collect();
            let last = std::mem::replace(&mut motions, moved);
            if is_same(&last, &motions) {
                break;
            }
        }
        let states = states(system);
        let ends = before.iter().enumerate().map(|(member, before)| system.forces_after(member, before)).collect();
        system.restore(start);
        Some(Stepped { states, ends, motions })
    }
}

impl Response {
    /// The sum of two differences to the state at rest, each with its weight.
    fn between(rest: &Stepped, ends: [&Stepped; 2], weights: [f64; 2], part: f64) -> Self {
        let change = |rest: &ElementState<6>, ends: [&ElementState<6>; 2]| {
            let sum = |of: &dyn Fn(&ElementState<6>) -> f64| -> f64 {
                (0..2).map(|k| weights[k] * (of(ends[k]) - of(rest))).sum()
            };
            // Auxiliary stiffness is no part of the problem.
            let is_free = |d: usize| rest.moduli.held[d] == 0.0;
            Stressing {
                stiffness: std::array::from_fn(|d| if is_free(d) { sum(&|s| s.stiffness()[d]) } else { 0.0 }),
                stress: (0..rest.stress.len()).map(|g| std::array::from_fn(|d| sum(&|s| s.stress[g][d]))).collect(),
                load: std::array::from_fn(|c| sum(&|s| s.load[c])),
            }
        };
        let member = |index: usize| {
            let elements = rest.states[index].iter().enumerate();
            let ends = ends.map(|end| &end.states[index]);
            elements.map(|(e, rest)| change(rest, [&ends[0][e], &ends[1][e]])).collect()
        };
        let sum = |rest: &[f64; 6], first: &[f64; 6], second: &[f64; 6]| {
            add(scale(weights[0], sub(*first, *rest)), scale(weights[1], sub(*second, *rest)))
        };
        let forces = |index: usize| {
            [0, 1].map(|end| sum(&rest.ends[index][end], &ends[0].ends[index][end], &ends[1].ends[index][end]))
        };
        let motions = rest.motions.iter().zip(&ends[0].motions).zip(&ends[1].motions);
        Self {
            stressings: (0..rest.states.len()).map(member).collect(),
            ends: (0..rest.ends.len()).map(forces).collect(),
            motions: motions.map(|((rest, first), second)| sum(rest, first, second)).collect(),
            part,
            error: 0.0,
        }
    }
}

/// Whether motions are those of a solve before, so that another one would bring the same.
fn is_same(before: &[[f64; 6]], now: &[[f64; 6]]) -> bool {
    let largest = |first: usize| {
        let part = |motion: &[f64; 6]| norm([motion[first], motion[first + 1], motion[first + 2]]);
        let apart = before.iter().zip(now).map(|(a, b)| part(&sub(*a, *b))).fold(0.0, f64::max);
        (apart, now.iter().map(part).fold(0.0, f64::max))
    };
    !before.is_empty() && [0, 3].map(largest).iter().all(|(apart, size)| *apart <= SAME * size)
}

/// How far the stresses at twice a part of the ramp are from twice those at the part, over what they change by; forces
/// against forces and moments against moments.
fn bend(rest: &Stepped, first: &Stepped, second: &Stepped, size: f64) -> f64 {
    let (mut off, mut changes) = ([0.0f64; 2], [0.0f64; 2]);
    let all = |stepped: &'_ Stepped| -> Vec<[f64; 6]> {
        stepped.states.iter().flatten().flat_map(|state| state.stress.iter().copied()).collect()
    };
    for ((rest, first), second) in all(rest).iter().zip(all(first)).zip(all(second)) {
        let (once, twice) = (sub(first, *rest), sub(second, *rest));
        let left = sub(twice, scale(2.0, once));
        for kind in 0..2 {
            let part = |of: &[f64; 6]| norm([of[3 * kind], of[3 * kind + 1], of[3 * kind + 2]]);
            off[kind] = off[kind].max(part(&left));
            changes[kind] = changes[kind].max(part(&twice));
        }
    }
    let [force, moment] = [changes[0].max(LEVER * changes[1] / size), changes[1].max(LEVER * changes[0] * size)];
    let over = |off: f64, change: f64| if off > 0.0 { off / change } else { 0.0 };
    over(off[0], force).max(over(off[1], moment))
}

/// All elements of all members.
fn states(system: &System<6>) -> Vec<Vec<ElementState<6>>> {
    let member = |slot: &crate::system::MemberSlot| {
        let pack = &system.packs[slot.pack];
        (0..pack.elements()).map(|e| pack.element(slot.lane, e)).collect()
    };
    system.members.iter().map(member).collect()
}
