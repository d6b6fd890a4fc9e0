//! The linear response of a state to the beginning of a ramp.
//!
//! It is found on a part of the ramp, on twice and on four times as much, against the state at rest that is solved for in the same
//! way: what is of second and third order in the part drops out, and what the state was out of balance by. How far the three are out
//! of proportion says what may be left, and how short a part has to be; a shorter one than that would have more rounding.
//! Forces on joints alone have a response in exact proportion, on the whole ramp. Loads along members and on levers are in the tangent
//! that they are answered with, and sections, held motions and held strains change it.

use pennate_elements::small::{add, norm, scale, sub};

use super::Beginning;
use crate::chain::{self, ElementState};
use crate::held::HeldForces;
use crate::spectral::operators::Stressing;
use crate::structure::Drive;
use crate::system::{State, System};

/// Part of the ramp by which its beginning is known, to begin with: of loads alone the whole.
const BEGINNING: f64 = 1e-3;
const WHOLE: f64 = 1.0;
/// Part of the response that what is left of higher orders may be.
const SURE: f64 = 1e-11;
/// By how much the part is made shorter where that is more, beyond what brings it there, and at most.
const BEYOND: f64 = 0.3;
const SHORTER: f64 = 1e-5;
/// How often. A shorter part that leaves more than this of it shows rounding, and is the last.
const TIMES: usize = 4;
const STRAIGHTER: f64 = 0.5;
/// Solves with corrected multipliers of rigid components, at most, and part of the largest force that these may be off by then. Of
/// a response in which they are more nothing is known.
const CORRECTIONS: usize = 60;
const HELD: f64 = 1e-11;
/// The same at rest, where multipliers are what they are, and motions rounding.
const AT_REST: usize = 4;
const UNKNOWN: f64 = 1.0;
/// They are corrected where a solve moves joints by no more than this beside the one before. What is below the other is no longer
/// what they have to be corrected by, but rounding.
const SAME: f64 = 1e-13;
const FALLING: f64 = 1e-8;
/// There, a difference that is more than this part of the one before does not fall any more.
const FALLS: f64 = 0.1;
/// Moments count no less than this part of forces times the size of the network, spins than this part of displacements over it.
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
    /// Whether the multipliers of held strains have come to what they are.
    is_settled: bool,
    /// Part of the motions by which corrections differ that bring nothing new.
    rounding: f64,
}

impl Beginning {
    /// Loads and sections at a fraction of the ramp.
    pub(super) fn set(&mut self, fraction: f64) {
        let system = &mut self.base.system;
        system.loading.fraction = fraction;
        for (value, (from, to)) in system.loading.drives.iter_mut().zip(self.from.iter().zip(&self.to)) {
            *value = from + fraction * (to - from);
        }
        system.apply_drives();
    }

    /// The response of the state; nothing where it has none.
    pub(super) fn response(&mut self) -> Option<Response> {
        let system = &self.base.system;
        let start = system.snapshot();
        let ends = system.tangent.ends.clone();
        let controls = system.structure.drives.iter().zip(self.from.iter().zip(&self.to));
        let sections = controls.into_iter().any(|(drive, (from, to))| matches!(drive, Drive::Control) && from != to);
        let moving = system.pattern.equations.held.iter().any(|row| row.from != row.to);
        let rigid = states(system).iter().flatten().any(|state| state.moduli.held != [0.0; 6]);
        let part = if sections || moving || rigid { BEGINNING } else { WHOLE };
        let part = part.min(self.longest);
        let response = self.beginning(&start, &ends, rigid, part)?;
        self.set(0.0);
        self.base.system.assemble(false);
        Some(response)
    }

    /// The response found on a part of the ramp that is short enough for it to be straight.
    fn beginning(&mut self, start: &State, before: &[[[f64; 6]; 2]], rigid: bool, mut part: f64) -> Option<Response> {
        let rest = self.step(start, before, 0.0, rigid)?;
        let size = self.base.system.size;
        let mut on = |part: f64| -> Option<(Response, f64)> {
            // Backwards it may be another row of a muscle's table.
            let mut at = |times: f64| self.step(start, before, times * part, rigid);
            let steps = [at(1.0)?, at(2.0)?, at(4.0)?];
            let is_settled = steps.iter().all(|step| step.is_settled);
            let rounding = steps.iter().fold(0.0f64, |most, step| most.max(step.rounding));
            let error = if is_settled { left_out(&rest, &steps, size) } else { UNKNOWN };
            Some((Response { error: error.max(rounding), ..Response::between(&rest, &steps, part) }, error))
        };
        let mut found = on(part);
        for _ in 0..TIMES {
            // Where a part leads beyond a singular point there is no response.
            let error = found.as_ref().map_or(f64::INFINITY, |found| found.1);
            if error <= SURE {
                break;
            }
            part *= (BEYOND * SURE / error).cbrt().max(SHORTER);
            match on(part) {
                Some(shorter) if shorter.1 < STRAIGHTER * error => found = Some(shorter),
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
        let (mut held, mut is_settled, mut rounding) = (HeldForces::default(), !rigid, 0.0f64);
        let mut difference = f64::INFINITY;
        held.begin(system);
        let most = if fraction > 0.0 { CORRECTIONS } else { AT_REST };
        for _ in 0..if rigid { most } else { 1 } {
            system.assemble(true);
            system.advance(true)?;
            system.restore_shape(start, 1.0);
            if held.follow(system, true).is_some() {
                break;
            }
            let joints = 0..system.places.joints.len();
            let moved = joints.map(|joint| system.pattern.equations.motion(joint, &system.tangent.rhs, true)).collect();
            let last = std::mem::replace(&mut motions, moved);
            is_settled |= rigid && held.are_settled(system, HELD);
            let apart = apart(&last, &motions, system.size);
            if apart <= FALLING {
                rounding = rounding.max(apart);
            }
            let stands = apart <= FALLING && apart > FALLS * difference;
            difference = apart;
            if is_settled && (apart <= SAME || stands) {
                break;
            }
        }
        let states = states(system);
        let ends = before.iter().enumerate().map(|(member, before)| system.forces_after(member, before)).collect();
        system.restore(start);
        Some(Stepped { states, ends, motions, is_settled, rounding })
    }
}

impl Response {
    /// The rate at the state at rest, from the states at a part of the ramp, at twice and at four times as much.
    fn between(rest: &Stepped, steps: &[Stepped; 3], part: f64) -> Self {
        let weights = [8.0 / 3.0, -1.0, 1.0 / 12.0].map(|weight| weight / part);
        let change = |rest: &ElementState<6>, steps: [&ElementState<6>; 3]| {
            let sum = |of: &dyn Fn(&ElementState<6>) -> f64| -> f64 {
                (0..3).map(|k| weights[k] * (of(steps[k]) - of(rest))).sum()
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
            elements.map(|(e, rest)| change(rest, [0, 1, 2].map(|k| &steps[k].states[index][e]))).collect()
        };
        let sum = |rest: &[f64; 6], of: &dyn Fn(&Stepped) -> [f64; 6]| {
            (0..3).fold([0.0; 6], |all, k| add(all, scale(weights[k], sub(of(&steps[k]), *rest))))
        };
        let forces = |index: usize| [0, 1].map(|end| sum(&rest.ends[index][end], &|step| step.ends[index][end]));
        let motions = rest.motions.iter().enumerate();
        Self {
            stressings: (0..rest.states.len()).map(member).collect(),
            ends: (0..rest.ends.len()).map(forces).collect(),
            motions: motions.map(|(joint, rest)| sum(rest, &|step| step.motions[joint])).collect(),
            part,
            error: 0.0,
        }
    }
}

/// Part of motions by which they differ from those of a solve before; displacements beside displacements and spins beside spins.
fn apart(before: &[[f64; 6]], now: &[[f64; 6]], size: f64) -> f64 {
    let part = |motion: &[f64; 6], first: usize| norm([motion[first], motion[first + 1], motion[first + 2]]);
    let off = |first| before.iter().zip(now).map(|(a, b)| part(&sub(*a, *b), first)).fold(0.0, f64::max);
    let largest = |first| now.iter().map(|motion| part(motion, first)).fold(0.0, f64::max);
    let (shift, spin) = (largest(0), largest(3));
    let over = |off: f64, whole: f64| if off > 0.0 { off / whole } else { 0.0 };
    let parts = [over(off(0), shift.max(LEVER * spin * size)), over(off(3), spin.max(LEVER * shift / size))];
    if before.is_empty() { f64::INFINITY } else { parts[0].max(parts[1]) }
}

/// Part of the stresses' rates that higher orders may be, forces against forces and moments against moments.
///
/// With D(p) the rate by a part p, 2 D(p) − D(2p) is off by the second order. How far that is from the same of twice the part, times
/// how far D(p) is from D(2p), is about what the third one leaves.
fn left_out(rest: &Stepped, steps: &[Stepped; 3], size: f64) -> f64 {
    let (mut off, mut changes) = ([[0.0f64; 2]; 2], [0.0f64; 2]);
    let all = |stepped: &'_ Stepped| -> Vec<[f64; 6]> {
        stepped.states.iter().flatten().flat_map(|state| state.stress.iter().copied()).collect()
    };
    let [first, second, third] = [0, 1, 2].map(|k| all(&steps[k]));
    for (((rest, first), second), third) in all(rest).iter().zip(first).zip(second).zip(third) {
        let rates =
            [(first, 1.0), (second, 0.5), (third, 0.25)].map(|(stress, weight)| scale(weight, sub(stress, *rest)));
        let bends = [sub(rates[1], rates[0]), sub(rates[2], rates[1])];
        for kind in 0..2 {
            let part = |of: &[f64; 6]| norm([of[3 * kind], of[3 * kind + 1], of[3 * kind + 2]]);
            off[kind][0] = off[kind][0].max(part(&bends[0]));
            off[kind][1] = off[kind][1].max(part(&sub(bends[1], scale(2.0, bends[0]))));
            changes[kind] = changes[kind].max(part(&rates[0]));
        }
    }
    let changes = [changes[0].max(LEVER * changes[1] / size), changes[1].max(LEVER * changes[0] * size)];
    let over = |off: f64, change: f64| if off > 0.0 { off / change } else { 0.0 };
    let orders = [0, 1].map(|order| over(off[0][order], changes[0]).max(over(off[1][order], changes[1])));
    orders[1] * orders[0].max(orders[1])
}

/// All elements of all members.
fn states(system: &System<6>) -> Vec<Vec<ElementState<6>>> {
    let member = |slot: &crate::system::MemberSlot| {
        let pack = system.members.packs[slot.pack].as_ref();
        (0..pack.mesh().elements()).map(|e| chain::element(pack, slot.lane, e)).collect()
    };
    system.members.slots.iter().map(member).collect()
}
