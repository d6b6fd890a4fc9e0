//! One ramp, increment by increment.
//!
//! Theory: docs/theory/continuation.md, Eq. 8.1.

use super::critical::After;
use super::doubt::{MANY, leapt};
use super::{Count, Path};
use crate::chain::Size;
use crate::history::{Status, StepHistory};
use crate::newton::{Aim, Convergence, Lost, Newton, Start, Why};
use crate::structure::{Branch, Method, Stop};
use crate::system::{Inertia, System};

/// A rise of the count of negative pivots within less of the ramp than this is a critical point.
pub(super) const BRACKET: f64 = 2e-3;
/// Increments are not shortened below this part of the ramp.
pub(super) const SHORTEST: f64 = 1e-4;
/// An iteration that wandered is not believed on an increment longer than this.
const LONG: f64 = 0.01;
/// A first increment larger than this (radians, or lengths of a member) foresees too much by far.
const WILD: f64 = 3.0;
/// One of this size is a guess that iterations can start from.
const TAME: f64 = 1.2;
/// An extrapolation that misses by no more than this (radians, or lengths of a member) takes few iterations to mend.
const FORESEEN: f64 = 0.05;
/// One that misses by more may lead anywhere; so may a first increment that leaves more.
const WRONG: f64 = 0.15;
const ALL_WRONG: f64 = 1.0;
/// Near a fold the state moves ever faster with the loads: by so much more than at first.
const FOLD: f64 = 4.0;

/// The values that a ramp moves.
pub(super) struct Ramp {
    pub drives: [Vec<f64>; 2],
    pub prestress: [f64; 2],
    pub longest: f64,
}

impl Ramp {
    pub(crate) fn apply<const D: usize>(&self, system: &mut System<D>, fraction: f64) {
        let [from, to] = &self.drives;
        system.fraction = fraction;
        for (value, (from, to)) in system.drives.iter_mut().zip(from.iter().zip(to)) {
            *value = if fraction == 1.0 { *to } else { from + fraction * (to - from) };
        }
        system.prestress = self.prestress[0] + fraction * (self.prestress[1] - self.prestress[0]);
        system.apply_drives();
    }
}

/// How a ramp is followed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Course {
    pub method: Method,
    pub branch: Branch,
    pub stop: Option<Stop>,
}

/// Progress of one ramp.
pub(super) struct Tally {
    pub iterations: usize,
    pub factorizations: usize,
    pub accepted: usize,
}

impl<const D: usize> Path<'_, D> {
    /// Counts pivots at the present state, before a step moves it.
    pub(super) fn start_count(&mut self, record: &mut StepHistory) {
        self.system.fraction = 0.0;
        self.system.apply_drives();
        let inertia = self.at_rest.take().unwrap_or_else(|| self.system.assemble(false));
        record.factorizations += 1;
        self.base = self.count(&inertia);
    }

    pub(super) fn count(&mut self, inertia: &Inertia) -> Count {
        let known = self.base.lateral;
        let potential = self.system.has_potential();
        let mut count = Count {
            own: inertia.negative,
            lateral: 0,
            odd: inertia.is_odd(),
            potential,
            lateral_potential: true,
            smallest: inertia.smallest,
            neutral: inertia.neutral > 0,
        };
        if count.own > self.base.own {
            let certain = self.system.certain_negative().max(self.base.own);
            #[cfg(feature = "trace")]
            eprintln!("{} negative, {certain} certain, softest {:e}", count.own, self.system.softest_stiffness());
            count.neutral |= certain < count.own;
            count.own = count.own.min(certain);
        }
        if let Some(lateral) = &mut self.lateral {
            let (inertia, potential) = lateral.confirmed(&mut self.system, known);
            count.lateral = inertia.negative;
            count.lateral_potential = potential;
            count.neutral |= inertia.neutral > 0;
        }
        count
    }

    /// Whether the loads have a potential along the whole of a ramp; the state is left at its beginning.
    ///
    /// Loads that lack one at the end lack it on the way.
    pub(super) fn is_conservative(&mut self, ramp: &Ramp) -> bool {
        ramp.apply(&mut self.system, 1.0);
        let conservative = self.system.loads_have_potential();
        ramp.apply(&mut self.system, 0.0);
        conservative
    }

    /// Follows a ramp to its end, from the present state at the fraction `from`; false where it stopped short.
    pub(super) fn follow(
        &mut self,
        ramp: &Ramp,
        record: &mut StepHistory,
        watch: &mut dyn FnMut(f64) -> bool,
        course: Option<&Course>,
        from: f64,
    ) -> bool {
        let is_step = course.is_some();
        let course = course.copied().unwrap_or_default();
        let mut tally = Tally { iterations: 0, factorizations: 0, accepted: 0 };
        let mut fraction = from;
        // Whether the state before the last one is on the same branch, near enough to extrapolate from.
        let mut behind = false;
        let mut increment = self.options.first_increment.min(ramp.longest).clamp(SHORTEST, 1.0);
        let mut last_increment = 0.0;
        let (mut first_rate, mut last_rate) = (0.0, 0.0);
        self.system.save(&mut self.last);
        let conservative = self.is_conservative(ramp);
        let mut retries = 0;
        // Why the last increments failed, where a member is held at both ends.
        let mut overheld = None;
        loop {
            let step = if fraction + increment * 1.0001 >= 1.0 { 1.0 - fraction } else { increment };
            let target = if fraction + step >= 1.0 - 1e-12 { 1.0 } else { fraction + step };
            ramp.apply(&mut self.system, target);
            let predicted = behind;
            if predicted {
                self.system.predict(&self.before, &self.last, step / last_increment);
            }
            let foreseen = if predicted { self.system.distances(&self.last) } else { Vec::new() };
            let doubt = conservative && step > BRACKET;
            let negative_limit = if doubt { self.base.own } else { usize::MAX };
            let aim = match target {
                _ if self.options.rough => Aim::Rough,
                ..1.0 => Aim::Passing,
                _ => Aim::Result,
            };
            let start = Start { predicted, rest: Some(&self.last), negative_limit, aim, may_wander: step <= LONG };
            let mut outcome = self.newton.solve(&mut self.system, start);
            if let Err(Lost { iterations, factorizations, why: Why::Astray, .. }) = outcome
                && self.system.own_first < WILD
            {
                // A chain that is bent far too much at first curls up beyond measure: straight on it comes back.
                tally.iterations += iterations;
                tally.factorizations += factorizations;
                self.system.restore(&self.last);
                self.system.straight = true;
                outcome = self.newton.solve(&mut self.system, Start { predicted: false, rest: None, ..start });
                self.system.straight = false;
            }
            if let (Err(lost), true) = (&outcome, retries > 0)
                && !matches!(lost.why, Why::Unstable(_) | Why::Wandered)
            {
                // Mixed stresses of a far iterate can mislead where stresses change sign: try without them.
                tally.iterations += lost.iterations;
                tally.factorizations += lost.factorizations;
                self.system.restore(&self.last);
                self.system.set_plain(true);
                outcome = self.newton.solve(&mut self.system, Start { predicted: false, rest: None, ..start });
                self.system.set_plain(false);
            }
            let rough = match outcome {
                Ok(mut found) => {
                    tally.iterations += found.iterations - 1;
                    tally.factorizations += found.factorizations;
                    let missed = self.system.own_first;
                    let foreseen = if predicted { foreseen } else { self.system.first_moves.clone() };
                    let mut count = self.count(&found.inertia);
                    let mut rose = count.own > self.base.own || count.lateral > self.base.lateral;
                    if count.neutral && aim != Aim::Result {
                        // The stiffness of a motion that needs no force is as small as the state is exact.
                        let exact = Newton { increment: 1e-9, ..self.newton };
                        if let Ok(better) = exact.solve(&mut self.system, Start::nearby()) {
                            tally.factorizations += better.factorizations;
                            count = self.count(&better.inertia);
                            rose = count.own > self.base.own || count.lateral > self.base.lateral;
                        }
                    }
                    let guarded = rose && self.guards(&count);
                    let moved = self.system.distances(&self.last);
                    // Each part of a network for itself: one that leaps may move less than another that does not.
                    let doubtful = moved.iter().zip(&foreseen).any(|(moved, foreseen)| leapt(*moved, *foreseen));
                    let flipped = !conservative && count.odd != self.base.odd;
                    let rose = !conservative && count.own > self.base.own;
                    if self.options.stop_unstable && (guarded || flipped) {
                        self.system.restore(&self.last);
                        return self.gave_up(record, fraction, &tally);
                    }
                    // Where loads have a potential a long way is no sign of another path, unless it was foreseen wrongly.
                    let limit = if predicted { WRONG } else { ALL_WRONG };
                    let wrong = conservative && missed > limit && found.iterations >= MANY && !self.system.hangs();
                    let hard = wrong || !conservative && found.iterations >= self.too_many(rose);
                    let far = (guarded || doubtful || flipped) && step > BRACKET;
                    let mut torn = doubtful && found.iterations >= MANY;
                    let mut passed = None;
                    if flipped && !far && !torn {
                        // A determinant that is zero nowhere on the way belongs to another path.
                        passed = self.locate_changes(ramp, &count, [fraction, target], &mut tally);
                        torn = passed.as_ref().is_some_and(Vec::is_empty);
                    }
                    if far || torn && step > SHORTEST {
                        self.system.restore(&self.last);
                        increment =
                            if torn { (0.2 * step).max(0.9 * SHORTEST) } else { (0.4 * step).max(0.9 * BRACKET) };
                        continue;
                    }
                    torn |= hard && step <= SHORTEST;
                    if rose && step > BRACKET || hard && step > SHORTEST {
                        let ratio = behind.then_some(step / last_increment);
                        let again =
                            (!rose || !hard).then(|| self.in_two_parts(ramp, [fraction, target], ratio, &mut tally));
                        let Some(again) = again.flatten() else {
                            self.system.restore(&self.last);
                            increment = 0.5 * step;
                            continue;
                        };
                        if rose
                            && !self.system.hangs()
                            && let Some(part) = self.passed_twice(ramp, [fraction, target], &mut tally)
                        {
                            self.system.restore(&self.last);
                            increment = (part * step).max(0.9 * BRACKET);
                            continue;
                        }
                        count = self.count(&again.inertia);
                        found = Convergence { iterations: found.iterations, ..again };
                    }
                    if guarded || torn || doubtful && self.system.jumped(&self.last, behind.then_some(&self.before)) {
                        let sideways = guarded && count.own <= self.base.own;
                        self.rough_stop(target, sideways, behind)
                    } else {
                        if passed.is_none() {
                            passed = self.locate_changes(ramp, &count, [fraction, target], &mut tally);
                        }
                        self.note_changes(record, &count, target, passed);
                        self.base = count;
                        last_rate = moved.into_iter().fold(Size::default(), Size::join).largest() / step;
                        if tally.accepted == 0 {
                            first_rate = last_rate;
                        }
                        self.shift_states();
                        behind = true;
                        fraction = target;
                        last_increment = step;
                        retries = 0;
                        overheld = None;
                        tally.accepted += 1;
                        if is_step {
                            self.accept(record, fraction, &found, &tally);
                        }
                        if !watch(fraction) && fraction < 1.0 {
                            record.status = Status::Interrupted;
                            self.settle(record, fraction, &tally);
                            return false;
                        }
                        if fraction >= 1.0 {
                            return self.arrived(record, &tally);
                        }
                        increment = match found.iterations {
                            // What extrapolation misses goes with the square of the increment.
                            0..=6 if predicted => (FORESEEN / missed).sqrt().clamp(2.0, 4.0) * step,
                            // What was not extrapolated says too little of how far one can go.
                            0..=6 => 2.0 * step,
                            7..=8 => step,
                            _ => 0.6 * step,
                        }
                        .min(ramp.longest);
                        continue;
                    }
                }
                Err(mut lost) => {
                    tally.iterations += lost.iterations;
                    tally.factorizations += lost.factorizations;
                    self.system.restore(&self.last);
                    increment = 0.4 * step;
                    if let Why::Overheld(_) = lost.why {
                        overheld = Some(lost.why);
                    }
                    if lost.why == Why::Astray && self.system.own_first > WILD {
                        increment = increment.min(TAME / self.system.own_first * step);
                    }
                    if lost.why == Why::Wandered {
                        increment = 0.5 * step;
                        continue;
                    }
                    if let Why::Unstable(excess) = lost.why {
                        // Past a limit point the extrapolation is unstable: go nearer before believing what comes; the
                        // more of it is unstable, the farther away are stable loads.
                        if !predicted {
                            increment *= 0.4f64.powf(excess.min(9) as f64 / 4.0 - 0.25);
                        }
                        increment = increment.max(0.9 * BRACKET);
                        continue;
                    }
                    retries += 1;
                    if increment >= SHORTEST && retries <= 14 {
                        if watch(fraction) {
                            continue;
                        }
                        record.status = Status::Interrupted;
                        self.settle(record, fraction, &tally);
                        return false;
                    }
                    // What grew without end under more load does not settle under less, where forces are in balance.
                    if lost.why == Why::Slow && lost.residual.largest() <= self.newton.residual {
                        lost.why = overheld.unwrap_or(lost.why);
                    }
                    let fold = last_rate > FOLD * first_rate && tally.accepted > 1;
                    self.rough_end(target, &lost, fold)
                }
            };
            if self.options.stop_unstable {
                return self.gave_up(record, fraction, &tally);
            }
            match self.lose_stability(ramp, record, fraction, &course, rough, &mut tally) {
                After::Stop => return false,
                After::GoOn { at, .. } if at >= 1.0 => return self.arrived(record, &tally),
                After::GoOn { at, next, last } => {
                    fraction = at;
                    increment = next;
                    last_increment = last.unwrap_or(0.0);
                    behind = last.is_some();
                    retries = 0;
                }
            }
        }
    }

    /// Ends a step at the end of its ramp.
    pub(super) fn arrived(&mut self, record: &mut StepHistory, tally: &Tally) -> bool {
        self.settle(record, 1.0, tally);
        record.status = Status::Converged;
        true
    }

    /// Ends a step at the last state, without a look at what is beyond.
    fn gave_up(&mut self, record: &mut StepHistory, fraction: f64, tally: &Tally) -> bool {
        self.settle(record, fraction, tally);
        record.status = Status::NotConverged;
        false
    }

    /// Whether a rise of the count is to be trusted as a loss of stability.
    fn guards(&self, count: &Count) -> bool {
        let own = count.own > self.base.own && count.potential;
        let lateral = count.lateral > self.base.lateral && count.lateral_potential;
        own || lateral
    }
}
