//! The linear response of a state to the beginning of a ramp.
//!
//! It is found on a part of the ramp, on twice and on four times as much, against the state at rest that is solved for in the same
//! way: what is of second and third order in the part drops out, and what the state was out of balance by. How far the three are out
//! of proportion says what may be left, and how short a part has to be; a shorter one than that would have more rounding.
//! Forces on joints alone have a response in exact proportion, on the whole ramp. Loads along members and on levers are in the tangent
//! that they are answered with, and sections, held motions and held strains change it.
//!
//! Forces of held strains are what an auxiliary stiffness makes of the strains that are left, and those are differences of motions,
//! known to their rounding. So that stiffness is a small one here ([`packs::SOFT`]), in series with strains that are stiff themselves.
//! By how much the last correction still changed the stresses is what rounding makes of them.

use pennate_elements::small::{add, norm, scale, sub};

use super::Beginning;
use crate::chain::{self, ElementState};
use crate::held::HeldForces;
use crate::packs;
use crate::spectral::operators::Stressing;
use crate::spectral::springs;
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
/// They are corrected where a correction changes stresses by no more than this part of what the ramp makes of them. What is below the
/// other is no longer what they have to be corrected by, but rounding, if it is more than this part of what the one before changed.
const SAME: f64 = 1e-13;
const FALLING: f64 = 1e-8;
const FALLS: f64 = 0.5;
/// So many corrections in a row that do not change less and less, of which none changes more than this part, are enough where axial
/// forces are not told to be what they are; stresses may then be off by so many times what these changed.
const STANDING: usize = 6;
const STOOD: f64 = 1e-2;
const UNSURE: f64 = 10.0;
/// Moments count no less than this part of forces times the size of the network, and forces than this part of moments over it.
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
    /// Whether the stresses have come to what they are.
    is_settled: bool,
    /// Forces and moments by which the last correction changed the stresses.
    changed: [f64; 2],
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
        let auxiliary = std::mem::replace(&mut self.base.system.loading.auxiliary, packs::SOFT);
        self.set(0.0);
        let soft = states(&self.base.system);
        let response = self.softly();
        self.base.system.loading.auxiliary = auxiliary;
        let response = response.map(|response| {
            let error = response.error.max(self.rounding_of_springs(&response));
            Response { error, ..self.with_stiffness(&soft, response) }
        });
        self.set(0.0);
        self.base.system.assemble(false);
        response
    }

    /// The response with held strains held softly.
    fn softly(&mut self) -> Option<Response> {
        let system = &self.base.system;
        let start = system.snapshot();
        let ends = system.tangent.ends.clone();
        let controls = system.structure.drives.iter().zip(self.from.iter().zip(&self.to));
        let sections = controls.into_iter().any(|(drive, (from, to))| matches!(drive, Drive::Control) && from != to);
        let moving = system.pattern.equations.held.iter().any(|row| row.from != row.to);
        let rigid = states(system).iter().flatten().any(|state| state.moduli.held != [0.0; 6]);
        let part = if sections || moving || rigid { BEGINNING } else { WHOLE };
        self.beginning(&start, &ends, rigid, part.min(self.longest))
    }

    /// The same with the change of the stiffness of strains that were held softly and are not held, in the elements `soft`.
    fn with_stiffness(&mut self, soft: &[Vec<ElementState<6>>], mut response: Response) -> Response {
        let is_soft = |(soft, own): (&ElementState<6>, &ElementState<6>)| soft.moduli.held != own.moduli.held;
        self.set(0.0);
        if !soft.iter().flatten().zip(states(&self.base.system).iter().flatten()).any(is_soft) {
            return response;
        }
        let mut at = |times: f64| {
            self.set(times * response.part);
            states(&self.base.system)
        };
        let [rest, steps @ ..] = [0.0, 1.0, 2.0, 4.0].map(&mut at);
        let weights = weights(response.part);
        for (member, stressings) in response.stressings.iter_mut().enumerate() {
            for (e, stressing) in stressings.iter_mut().enumerate() {
                let (soft, rest) = (&soft[member][e].moduli, &rest[member][e].moduli);
                for d in (0..6).filter(|&d| soft.held[d] != 0.0 && rest.held[d] == 0.0) {
                    let by = |k: usize| steps[k][member][e].moduli.stiffness[d] - rest.stiffness[d];
                    stressing.stiffness[d] = (0..3).map(|k| weights[k] * by(k)).sum();
                }
            }
        }
        response
    }

    /// Part of a response that rounding of the forces of springs may be.
    fn rounding_of_springs(&self, response: &Response) -> f64 {
        let system = &self.base.system;
        let [mut changes, rounding] = springs::changed(system, &response.motions);
        for stress in response.stressings.iter().flatten().flat_map(|stressing| &stressing.stress) {
            let sizes = sizes(stress);
            changes = [changes[0].max(sizes[0]), changes[1].max(sizes[1])];
        }
        beside(rounding, changes, system.size)
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
            let [bent, rounding] = left_out(&rest, &steps, size, part);
            let bent = if is_settled { bent } else { UNKNOWN };
            Some((Response { error: bent.max(rounding), ..Response::between(&rest, &steps, part) }, bent))
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
        let (mut held, mut is_settled, mut has_force) = (HeldForces::default(), !rigid, false);
        let (mut changed, mut difference) = ([0.0; 2], f64::INFINITY);
        let mut stood: Option<(usize, Vec<Vec<ElementState<6>>>)> = None;
        let (rest, size) = (if rigid { states(system) } else { Vec::new() }, system.size);
        let (mut motions, mut now) = (Vec::new(), rest.clone());
        held.begin(system);
        let most = if fraction > 0.0 { CORRECTIONS } else { AT_REST };
        for correction in 0..if rigid { most } else { 1 } {
            system.assemble(true);
            system.advance(true)?;
            system.restore_shape(start, 1.0);
            if held.follow(system, true).is_some() {
                break;
            }
            let joints = 0..system.places.joints.len();
            motions = joints.map(|joint| system.pattern.equations.motion(joint, &system.tangent.rhs, true)).collect();
            let last = std::mem::replace(&mut now, states(system));
            has_force |= held.are_settled(system, HELD);
            if correction == 0 {
                continue;
            }
            changed = most_of(&last, &now);
            let apart = beside(changed, most_of(&rest, &now), size);
            let falls = apart <= FALLS * difference;
            difference = apart;
            if has_force && (apart <= SAME || apart <= FALLING && !falls) {
                is_settled = true;
                break;
            }
            // Rounding of what is stiffer than the auxiliary stiffness may be all that is left of an axial force.
            match &stood {
                _ if falls || apart > STOOD => stood = None,
                None => stood = Some((correction, now.clone())),
                Some((since, first)) if correction == since + STANDING => {
                    let drift = most_of(first, &now);
                    changed = [0, 1].map(|kind| UNSURE * changed[kind].max(drift[kind]));
                    is_settled = true;
                    break;
                }
                Some(_) => {}
            }
        }
        let ends = before.iter().enumerate().map(|(member, before)| system.forces_after(member, before)).collect();
        system.restore(start);
        Some(Stepped { states: now, ends, motions, is_settled, changed })
    }
}

impl Response {
    /// The rate at the state at rest, from the states at a part of the ramp, at twice and at four times as much.
    fn between(rest: &Stepped, steps: &[Stepped; 3], part: f64) -> Self {
        let weights = weights(part);
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

/// Weights of the changes of a state on a part of a ramp, on twice and on four times as much in its rate.
fn weights(part: f64) -> [f64; 3] {
    [8.0 / 3.0, -1.0, 1.0 / 12.0].map(|weight| weight / part)
}

/// The largest force and the largest moment by which stresses of elements differ.
fn most_of(before: &[Vec<ElementState<6>>], now: &[Vec<ElementState<6>>]) -> [f64; 2] {
    let mut most = [0.0f64; 2];
    for (before, now) in before.iter().flatten().zip(now.iter().flatten()) {
        for (before, now) in before.stress.iter().zip(&now.stress) {
            let sizes = sizes(&sub(*now, *before));
            most = [most[0].max(sizes[0]), most[1].max(sizes[1])];
        }
    }
    most
}

/// Sizes of a force and of a moment.
fn sizes(stress: &[f64; 6]) -> [f64; 2] {
    [0, 3].map(|first| norm([stress[first], stress[first + 1], stress[first + 2]]))
}

/// A force beside the largest one or a moment beside the largest one, where that is more, in a network of this size.
fn beside(part: [f64; 2], whole: [f64; 2], size: f64) -> f64 {
    let whole = [whole[0].max(LEVER * whole[1] / size), whole[1].max(LEVER * whole[0] * size)];
    let over = |kind: usize| if part[kind] > 0.0 { part[kind] / whole[kind] } else { 0.0 };
    over(0).max(over(1))
}

/// Part of the stresses' rates by `part` of the ramp that higher orders may be, and that rounding may be: forces against forces and
/// moments against moments.
///
/// With D(p) the rate by a part p, 2 D(p) − D(2p) is off by the second order. How far that is from the same of twice the part, times
/// how far D(p) is from D(2p), is about what the third one leaves.
fn left_out(rest: &Stepped, steps: &[Stepped; 3], size: f64, part: f64) -> [f64; 2] {
    let (mut off, mut rates) = ([[0.0f64; 2]; 2], [0.0f64; 2]);
    let all = |stepped: &'_ Stepped| -> Vec<[f64; 6]> {
        stepped.states.iter().flatten().flat_map(|state| state.stress.iter().copied()).collect()
    };
    let [first, second, third] = [0, 1, 2].map(|k| all(&steps[k]));
    for (((rest, first), second), third) in all(rest).iter().zip(first).zip(second).zip(third) {
        let [first, second, third] =
            [(first, 1.0), (second, 0.5), (third, 0.25)].map(|(stress, weight)| scale(weight, sub(stress, *rest)));
        let bends = [sub(second, first), sub(third, second)];
        let [first_order, second_order] = [sizes(&bends[0]), sizes(&sub(bends[1], scale(2.0, bends[0])))];
        let first = sizes(&first);
        for kind in 0..2 {
            off[0][kind] = off[0][kind].max(first_order[kind]);
            off[1][kind] = off[1][kind].max(second_order[kind]);
            rates[kind] = rates[kind].max(first[kind]);
        }
    }
    let orders = off.map(|off| beside(off, rates, size));
    let rounding = |kind: usize| -> f64 {
        let weights = weights(part).map(f64::abs).into_iter();
        let changed = |step: &Stepped| part * (step.changed[kind] + rest.changed[kind]);
        weights.zip(steps).map(|(weight, step)| weight * changed(step)).sum()
    };
    [orders[1] * orders[0].max(orders[1]), beside([0, 1].map(rounding), rates, size)]
}

/// All elements of all members.
fn states(system: &System<6>) -> Vec<Vec<ElementState<6>>> {
    let member = |slot: &crate::system::MemberSlot| {
        let pack = system.members.packs[slot.pack].as_ref();
        (0..pack.mesh().elements()).map(|e| chain::element(pack, slot.lane, e)).collect()
    };
    system.members.slots.iter().map(member).collect()
}
