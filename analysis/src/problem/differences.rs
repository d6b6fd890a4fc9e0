//! Derivatives by differences of neighbours: equilibria of designs that have one parameter a little larger or smaller.

use pennate_models::discretize;
use pennate_solver::history::Equilibrium;
use pennate_solver::joints::Held;
use pennate_solver::structure::{Change, Step};
use pennate_solver::system::System;

use super::adjoint::Exact;
use super::design::take_pieces;
use super::estimate::{Estimate, Greatest, OF_USE, WITHIN};
use super::nearby::{self, size};
use super::neighbour::{self, NOTHING};
use super::slopes::{Component, Hold, Slopes, Stage};
use super::{Reason, mesh};
use crate::together::{self, Packs};

/// Parts of a parameter by which neighbours are apart: the first that two distances agree at is taken.
///
/// With differences at h and 2 h extrapolated to h = 0 what is left goes with h⁴, and with those at 4 h, where there are any, with h⁶:
/// 10⁻¹⁰ of the fifth derivative at the first of them, where rounding of the states, 10⁻¹³ or so, leaves 3 · 10⁻¹¹. At a third of it,
/// rounding of forces along members whose stretch counts was 5 · 10⁻⁷ of the largest derivative.
const APART: [f64; 5] = [3e-3, 1e-3, 3e-4, 1e-4, 3e-5];
/// Part by which the differences at both distances may differ: its square is left after extrapolation.
const AGREED: f64 = 1e-4;
/// The same as a part of what is greatest of its kind, over the whole of a parameter, where a shorter distance may tell more and where
/// none does: a derivative that vanishes, as that of a reaction that statics fixes, has no part of its own.
const VANISHES: [f64; 2] = [1e-7, 1e-6];
/// By how much the tangent may change over this part of a parameter: it vanishes about so far away where it changes by all.
/// The path bends by as much: half of what both neighbours moved by together, over half of what they moved apart.
const CHANGED: f64 = 0.3;
const NEAR: f64 = 1e-4;
/// How many times as large the jump of a derivative may seem at one distance as at the next.
const ALIKE: f64 = 2.0;
/// How many times as much a path bends at most over twice the distance where that is by a corner.
const AS_MUCH: f64 = 1.2;
/// Part of the largest value of a probe that rounding may move it by.
const ROUNDING: f64 = 1e-12;
/// What differences at both distances, extrapolated to none, leave over the square of what they differ by: the fourth power of the
/// distance over that to where the state ceases to be, which goes with the square.
const LEFT: f64 = 4.0 / 9.0;
/// How many times that three distances may tell apart: sixteen times as much is left at twice the distance.
const EXPLAINED: f64 = 32.0;
/// How many times what three distances tell apart rounding may leave: it may make them agree by chance.
const BY_CHANCE: f64 = 3.0;
/// An estimated error, over a derivative, below which no shorter distance is looked at: a tenth of what is promised.
const ENOUGH: f64 = 0.1 * WITHIN;
/// Part of its value that rounding moves a probe by at least.
const LEAST: f64 = 2e-14;

/// A neighbour: probes, then components that the next step holds where they are, and how far its joints moved.
struct Neighbour {
    values: Vec<f64>,
    moved: Vec<f64>,
    /// Whether its held strains are what they are in equilibrium: what is left of them does not fall as the square of the distance.
    settled: bool,
}

/// How much the path bends between two neighbours on both sides of the design.
fn bend(ahead: &[f64], behind: &[f64]) -> f64 {
    let largest = |part: fn(f64, f64) -> f64| {
        ahead.iter().zip(behind).map(|(&ahead, &behind)| part(ahead, behind).abs()).fold(0.0, f64::max)
    };
    let (together, apart) = (largest(|ahead, behind| ahead + behind), largest(|ahead, behind| ahead - behind));
    if apart > NOTHING { together / apart } else { 0.0 }
}

/// A derivative by differences at a distance and at twice as much, and where it is known at four times as much; with `rounding` times the
/// part of a value that rounding moves it by.
///
/// Two distances leave the fourth power of them, three the sixth. What the three tell apart is by the fourth power, which is known from the
/// two, or else it is rounding.
fn extrapolated([one, two]: [f64; 2], four: Option<f64>, rounding: f64) -> Estimate {
    let (near, apart) = (one + (one - two) / 3.0, (one - two).abs());
    let left = if apart > 0.0 { LEFT * apart * (apart / one.abs().max(two.abs())) } else { 0.0 };
    let Some(four) = four else { return Estimate { slope: near, error: left + ROUNDING * rounding } };
    let gap = near - (two + (two - four) / 3.0);
    let error = if gap.abs() <= EXPLAINED * left { left } else { BY_CHANCE * gap.abs() };
    Estimate { slope: near + gap / 15.0, error: error + LEAST * rounding }
}

/// Values at neighbours on both sides of a design, ahead and behind: at a distance, at twice as much, and where there are any at four times
/// as much.
struct Around {
    apart: f64,
    near: [Vec<f64>; 2],
    far: [Vec<f64>; 2],
    beyond: Option<[Vec<f64>; 2]>,
}

impl Around {
    /// By how much the derivative of a quantity jumps in the middle, as three distances tell; nothing where there are two.
    fn jump(&self, quantity: usize) -> f64 {
        let both = |[ahead, behind]: &[Vec<f64>; 2]| ahead[quantity] + behind[quantity];
        let Some(beyond) = &self.beyond else { return 0.0 };
        let (near, far, beyond) = (both(&self.near), both(&self.far), both(beyond));
        nearby::jump(far - near, beyond - far, self.apart)
    }

    /// The differences of a quantity at the two smaller distances, and what they are extrapolated to.
    fn estimate(&self, quantity: usize) -> ([f64; 2], Estimate) {
        let slope = |[ahead, behind]: &[Vec<f64>; 2], times: f64| {
            (ahead[quantity] - behind[quantity]) / (2.0 * times * self.apart)
        };
        let differences = [slope(&self.near, 1.0), slope(&self.far, 2.0)];
        let four = self.beyond.as_ref().map(|beyond| slope(beyond, 4.0));
        (differences, extrapolated(differences, four, self.near[0][quantity].abs() / self.apart))
    }
}

impl Slopes<'_> {
    /// Derivatives of all probes in the state of a system, and of components that the next one keeps, by equilibria nearby; with
    /// the reason where there are none, or not all.
    pub(super) fn by_neighbours<const D: usize>(
        &self,
        system: &mut System<D>,
        packs: Packs<D>,
        at: (Stage, &Equilibrium),
        kept: &[Component],
        exact: Option<&Exact>,
    ) -> (Vec<Estimate>, Option<Reason>) {
        let inputs = self.row.len();
        let probes = &self.design.model.probes;
        let count = probes.len() + kept.len();
        let mut found = vec![Estimate::NONE; count * inputs];
        let mut reason = None;
        let regular = exact.is_some_and(|exact| exact.regular);
        let needed = self.needed(at.0);
        // Expressions follow what they refer to.
        let is_wanted = |quantity: usize| {
            quantity >= probes.len() || needed.contains(&quantity) && probes.operands(quantity).is_none()
        };
        for input in 0..inputs {
            let stated = |quantity: usize| exact.is_some_and(|exact| exact.states(quantity, input));
            let settled = |quantity: usize| exact.is_some_and(|exact| exact.is_near(quantity, input));
            // What is known without neighbours need not be known by them, unless they are to tell whether a singular point is near.
            let known = |quantity: usize| !is_wanted(quantity) || regular && settled(quantity);
            let counts = |quantity: usize| !known(quantity);
            if !(0..count).any(counts) {
                continue;
            }
            // What is stated already, though not as near as it should be, needs no other reason.
            let matters = |quantity: usize| counts(quantity) && !(regular && stated(quantity));
            match self.slope(system, packs, at, (input, [&known, &counts, &matters]), kept) {
                Ok((column, doubtful)) => {
                    for (quantity, estimate) in column.into_iter().enumerate() {
                        found[quantity * inputs + input] = estimate;
                    }
                    reason = reason.or(doubtful);
                }
                Err(Reason::Interrupted) => return (found, Some(Reason::Interrupted)),
                Err(why) if (0..count).any(matters) => reason = reason.or(Some(why)),
                Err(_) => {}
            }
        }
        (found, reason)
    }

    /// Derivatives of all probes, and of the components that the next step keeps, by one parameter; with the reason where some
    /// of them are not to be trusted, and are no numbers. Which of them are known in another way, which are looked for, and which have to
    /// be trusted, is given.
    fn slope<const D: usize>(
        &self,
        system: &mut System<D>,
        packs: Packs<D>,
        (stage, state): (Stage, &Equilibrium),
        (input, [known, counts, matters]): (usize, [&dyn Fn(usize) -> bool; 3]),
        kept: &[Component],
    ) -> Result<(Vec<Estimate>, Option<Reason>), Reason> {
        let size = size(self.row[input]);
        let largest =
            self.values_at(stage).iter().filter(|value| value.is_finite()).fold(0.0, |m: f64, v| m.max(v.abs()));
        let probes = &self.design.model.probes;
        let greatest = Greatest::of(state);
        let mut found: Vec<Estimate> = Vec::new();
        let mut open: Vec<usize> = Vec::new();
        let (mut agreed, mut jumps): (Vec<bool>, Vec<Option<f64>>) = (Vec::new(), Vec::new());
        for (round, part) in APART.into_iter().enumerate() {
            let last = round + 1 == APART.len();
            // Nearer by, the factors at hand lead to neighbours that they do not lead to here; a singular point stays one.
            let around = match self.around(system, packs, stage, (input, part * size, last), kept) {
                Ok(around) => around,
                Err(Reason::Singular { .. }) if !last => continue,
                Err(reason) => return Err(reason),
            };
            let values = &around.near[0];
            let all: Vec<usize> =
                if found.is_empty() { (0..values.len()).collect() } else { std::mem::take(&mut open) };
            found.resize(values.len(), Estimate::NONE);
            agreed.resize(values.len(), false);
            jumps.resize(values.len(), None);
            for quantity in all {
                let ([one, two], estimate) = around.estimate(quantity);
                let noise = ROUNDING * largest.max(values[quantity].abs()) / around.apart;
                let kind = (quantity < probes.len()).then(|| probes.kind(quantity));
                let nothing = VANISHES[usize::from(last)] * greatest.like(kind, values[quantity]) / size;
                let measure = estimate.slope.abs().max(self.floor(stage, &greatest, quantity) / size);
                let is_near = around.beyond.is_some() && estimate.error <= ENOUGH * measure;
                // What is not a number in the state itself is none here either.
                agreed[quantity] |= is_near || !((one - two).abs() > (AGREED * one.abs()).max(nothing) + noise);
                // A corner is one from nearer by, too; rounding leaves another jump at every distance.
                let jump = around.jump(quantity);
                let as_before = jumps[quantity].is_none_or(|before| jump < ALIKE * before && before < ALIKE * jump);
                let is_first = round == 0 || jumps[quantity].is_some();
                let counts = jump > (OF_USE * measure).max(noise);
                jumps[quantity] = (counts && is_first && as_before).then_some(jump);
                if !agreed[quantity] || jumps[quantity].is_some() {
                    open.push(quantity);
                }
                if estimate.error < found[quantity].error {
                    found[quantity] = estimate;
                }
            }
            if !open.iter().any(|&quantity| counts(quantity)) {
                break;
            }
        }
        let mut reason = None;
        for quantity in open {
            if known(quantity) {
                continue;
            }
            found[quantity] = Estimate::NONE;
            if matters(quantity) {
                reason = reason.or_else(|| Some(self.doubt(stage, quantity, jumps[quantity].is_some())));
            }
        }
        Ok((found, reason))
    }

    /// Neighbours whose parameter is this much larger and smaller, and multiples of it, in the same state. Unless no shorter distance is
    /// left, only such as have settled.
    fn around<const D: usize>(
        &self,
        system: &mut System<D>,
        packs: Packs<D>,
        stage: Stage,
        (input, apart, last): (usize, f64, bool),
        kept: &[Component],
    ) -> Result<Around, Reason> {
        let straight = CHANGED / (NEAR * size(self.row[input]));
        let index = stage.step();
        let mut neighbours = |by: f64| {
            let mut neighbour = |by: f64| self.neighbour(system, packs, stage, (input, by), kept);
            let (ahead, behind) = (neighbour(by)?, neighbour(-by)?);
            let (bend, settled) = (bend(&ahead.moved, &behind.moved), last || ahead.settled && behind.settled);
            Ok::<_, Reason>(([ahead.values, behind.values], bend, settled))
        };
        let serves = |by: f64, bend: f64, settled: bool| settled && bend <= straight * by;
        let mut pair = |by: f64| match neighbours(by)? {
            (values, bend, settled) if serves(by, bend, settled) => Ok(values),
            // Towards a singular point a path bends the more over twice the distance, at a corner as much.
            (_, one, _) if last && neighbours(2.0 * by).is_ok_and(|(_, two, _)| two < AS_MUCH * one) => {
                Err(Reason::NoDerivative { output: self.output_after(index) })
            }
            _ => Err(stage.singular()),
        };
        Ok(Around { apart, near: pair(apart)?, far: pair(2.0 * apart)?, beyond: pair(4.0 * apart).ok() })
    }

    /// Why a derivative is not to be trusted: there is a corner, or what is greatest somewhere may have one.
    fn doubt(&self, stage: Stage, quantity: usize, is_corner: bool) -> Reason {
        let probes = &self.design.model.probes;
        if is_corner || quantity < probes.len() && !probes.kind(quantity).is_asked() {
            Reason::NoDerivative { output: self.output_of(stage.step(), quantity) }
        } else {
            stage.singular()
        }
    }

    /// All probes of the design whose parameter is this much larger, in the same state.
    fn neighbour<const D: usize>(
        &self,
        known: &mut System<D>,
        packs: Packs<D>,
        stage: Stage,
        (input, by): (usize, f64),
        kept: &[Component],
    ) -> Result<Neighbour, Reason> {
        self.wanted()?;
        let mut row = self.row.to_vec();
        row[input] += by;
        let model = self
            .problem
            .model_beside(&row)
            .map_err(|reason| Reason::Edge { parameter: input, reason: reason.into() })?;
        let (mut structure, steps) =
            discretize(&model, &mesh::fitted(&self.problem.mesh, &self.problem.middle, &model));
        let held = self.held(&known.held(), &steps, (input, by));
        let held = neighbour::rows(&held, &structure);
        take_pieces(&mut structure, &known.loading.drives);
        let mut drives = vec![0.0; structure.drives.len()];
        for &(drive, value) in steps.iter().take(stage.behind()).flat_map(|step| &step.targets) {
            drives[drive] = value;
        }
        let mut system = together::system(known, packs, structure, &self.design.steps);
        system.adopt(known);
        system.loading.auxiliary = known.loading.auxiliary;
        system.stand_at_end(known, held, &drives);
        let (moved, near) = neighbour::approach(&mut system, known).ok_or(stage.singular())?;
        let settled = neighbour::polish(&mut system) && near;
        let state = neighbour::read(&mut system);
        let mut values = self.probes(&model, state, &[]);
        values.extend(kept.iter().map(|&(node, component)| together::present(&system, node, component)));
        Ok(Neighbour { values, moved, settled })
    }

    /// What is held in the present state, with the values of a neighbour.
    fn held(&self, held: &[Held], steps: &[Step], (input, by): (usize, f64)) -> Vec<Held> {
        let value = |steps: &[Step], (step, place): (usize, usize)| match steps[step].changes[place] {
            Change::Prescribe { to, .. } => to,
            Change::MoveBy { by, .. } => by,
            Change::Hold { .. } | Change::Free { .. } => 0.0,
        };
        let row = |row: &Held| {
            let to = match self.holds.get(&(row.node, row.component)) {
                None => row.to,
                Some(Hold::To(step, place)) => value(steps, (*step, *place)),
                Some(Hold::From(moved, rates)) => {
                    let moved = moved.map_or(0.0, |at| value(steps, at) - value(&self.design.steps, at));
                    row.to + moved + by * rates[input]
                }
            };
            Held { to, ..*row }
        };
        held.iter().map(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Differences of a function over a distance, and over two and four times as much.
    fn differences(value: impl Fn(f64) -> f64, by: f64) -> [f64; 3] {
        [1.0, 2.0, 4.0].map(|times| (value(times * by) - value(-times * by)) / (2.0 * times * by))
    }

    #[test]
    fn what_a_smooth_function_leaves_is_less_than_is_said() {
        let [one, two, four] = differences(|x| 1.0 / (1.0 - x), 0.01);
        let (of_two, of_three) = (extrapolated([one, two], None, 0.0), extrapolated([one, two], Some(four), 0.0));
        for found in [of_two, of_three] {
            assert!((found.slope - 1.0).abs() <= 1.01 * found.error && found.error < 1e-7, "{found:?}");
        }
        assert!((of_three.slope - 1.0).abs() < 1e-2 * (of_two.slope - 1.0).abs(), "{of_three:?} {of_two:?}");
    }

    #[test]
    fn rounding_is_told_by_the_third_distance() {
        for rounding in [3e-9, -3e-9, 1e-8] {
            let [one, two, four] = differences(|x| x.sin() + if x == 1e-3 { rounding } else { 0.0 }, 1e-3);
            let found = extrapolated([one, two], Some(four), 0.0);
            let miss = (found.slope - 1.0).abs();
            assert!(miss > 1e-6 && miss <= found.error && found.error < 10.0 * miss, "{found:?} {miss:e}");
        }
    }
}
