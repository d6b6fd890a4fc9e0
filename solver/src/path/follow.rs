//! One ramp, increment by increment.
//!
//! Theory: docs/theory/continuation.md, Eq. 8.1.

use super::critical::After;
use super::doubt::{MANY, is_doubtful, leapt};
use super::march::{Judged, March, Reached, Shorter, Stride};
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
pub(super) const WILD: f64 = 3.0;
/// Pivots that are lost together at a point that is not singular.
const PAIR: usize = 2;

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

impl Tally {
    fn count(&mut self, lost: &Lost) {
        self.iterations += lost.iterations;
        self.factorizations += lost.factorizations;
    }
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
    /// Loads that lack one on the way lack it at an end: at the last where they grow, at the first where they fade.
    pub(super) fn is_conservative(&mut self, ramp: &Ramp) -> bool {
        let mut has_potential = |fraction: f64| {
            ramp.apply(&mut self.system, fraction);
            self.system.loads_have_potential()
        };
        let conservative = has_potential(1.0);
        has_potential(0.0) && conservative
    }

    /// Follows a ramp to its end, from the present state at the fraction `from`; false where it stopped short.
    ///
    /// Without a course it is no step of the user's: nothing is recorded on the way.
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
        let first = self.options.first_increment.min(ramp.longest).clamp(SHORTEST, 1.0);
        self.system.save(&mut self.last);
        let mut march = March::new(from, first, self.is_conservative(ramp));
        loop {
            let stride = march.stride(&self.options);
            let foreseen = self.predict(ramp, &march, &stride);
            let rough = match self.reach(&march, &stride, &mut tally) {
                Ok(found) => match self.assess(ramp, &march, &stride, found, foreseen, &mut tally) {
                    Judged::Accepted(mut reached) => {
                        self.note_changes(record, &reached.count, stride.target, reached.passed.take());
                        self.base = reached.count;
                        self.shift_states();
                        tally.accepted += 1;
                        march.go_on(&stride, &reached, ramp.longest);
                        if is_step {
                            self.accept(record, march.fraction, &reached.found, &tally);
                        }
                        if !watch(march.fraction) && march.fraction < 1.0 {
                            return self.interrupted(record, march.fraction, &tally);
                        }
                        if march.fraction >= 1.0 {
                            return self.arrived(record, &tally);
                        }
                        continue;
                    }
                    Judged::TooLong(increment) => {
                        self.system.restore(&self.last);
                        march.increment = increment;
                        continue;
                    }
                    Judged::Lost(rough) => rough,
                },
                Err(lost) => {
                    self.system.restore(&self.last);
                    match march.shorten(&stride, &lost, self.system.own_first) {
                        Shorter::Nearer => continue,
                        Shorter::Again if watch(march.fraction) => continue,
                        Shorter::Again => return self.interrupted(record, march.fraction, &tally),
                        Shorter::Never => {}
                    }
                    let fold = march.nears_a_fold() && tally.accepted > 1;
                    self.rough_end(stride.target, &march.reason(lost, self.newton.residual), fold)
                }
            };
            match self.lose_stability(ramp, record, march.fraction, &course, rough, &mut tally) {
                After::Stop => return false,
                After::GoOn { at, .. } if at >= 1.0 => return self.arrived(record, &tally),
                After::GoOn { at, next, last } => march.begin_again(at, next, last),
            }
        }
    }

    /// Puts the system at the loads of a stride, on the extrapolation of the last two states where there are two; how far each
    /// part of the network moves by that.
    fn predict(&mut self, ramp: &Ramp, march: &March, stride: &Stride) -> Vec<Size> {
        ramp.apply(&mut self.system, stride.target);
        if !march.behind {
            return Vec::new();
        }
        self.system.predict(&self.before, &self.last, stride.length / march.last_increment);
        self.system.distances(&self.last)
    }

    /// Iterates to the equilibrium at the end of a stride; where that gets lost, again from the last state, more carefully.
    fn reach(&mut self, march: &March, stride: &Stride, tally: &mut Tally) -> Result<Convergence, Lost> {
        let doubt = march.conservative && stride.length > BRACKET;
        let start = Start {
            predicted: march.behind,
            rest: Some(&self.last),
            negative_limit: if doubt { self.base.own } else { usize::MAX },
            aim: stride.aim,
            may_wander: stride.length <= LONG,
        };
        let again = Start { predicted: false, rest: None, ..start };
        let mut outcome = self.newton.solve(&mut self.system, start);
        if let Err(lost) = &outcome
            && lost.why == Why::Astray
            && self.system.own_first < WILD
        {
            // A chain that is bent far too much at first curls up beyond measure: straight on it comes back.
            tally.count(lost);
            self.system.restore(&self.last);
            self.system.straight = true;
            outcome = self.newton.solve(&mut self.system, again);
            self.system.straight = false;
        }
        if let Err(lost) = &outcome
            && march.retries > 0
            && !matches!(lost.why, Why::Unstable(_) | Why::Wandered)
        {
            // Mixed stresses of a far iterate can mislead where stresses change sign: try without them.
            tally.count(lost);
            self.system.restore(&self.last);
            self.system.set_plain(true);
            outcome = self.newton.solve(&mut self.system, again);
            self.system.set_plain(false);
        }
        match &outcome {
            Ok(found) => {
                tally.iterations += found.iterations - 1;
                tally.factorizations += found.factorizations;
            }
            Err(lost) => tally.count(lost),
        }
        outcome
    }

    /// Whether the equilibrium that a stride led to is the one that follows the last on its path.
    fn assess(
        &mut self,
        ramp: &Ramp,
        march: &March,
        stride: &Stride,
        mut found: Convergence,
        foreseen: Vec<Size>,
        tally: &mut Tally,
    ) -> Judged {
        let (step, predicted) = (stride.length, march.behind);
        let ends = [march.fraction, stride.target];
        let missed = self.system.own_first;
        let foreseen = if predicted { foreseen } else { self.system.first_moves.clone() };
        let mut count = self.count(&found.inertia);
        if count.neutral && stride.aim != Aim::Result {
            // The stiffness of a motion that needs no force is as small as the state is exact.
            let exact = Newton { increment: 1e-9, ..self.newton };
            if let Ok(better) = exact.solve(&mut self.system, Start::nearby()) {
                tally.factorizations += better.factorizations;
                count = self.count(&better.inertia);
            }
        }
        // A moment on a joint that supports hold about some axes may have a potential where the joint has not turned yet.
        let conservative = march.conservative && count.potential;
        let guarded = self.guards(&count);
        let moved = self.system.distances(&self.last);
        // Each part of a network for itself: one that leaps may move less than another that does not.
        let doubtful = leapt((&moved, &foreseen));
        let flipped = !conservative && count.odd != self.base.odd;
        let rose = !conservative && count.own > self.base.own;
        let wrong = is_doubtful(&self.system, (&moved, &foreseen), predicted, found.iterations);
        let beyond = march.foresees_buckling && found.iterations >= MANY;
        let hard = wrong || beyond || !conservative && found.iterations >= self.too_many(rose);
        let far = (guarded || doubtful || flipped) && step > BRACKET;
        let mut torn = doubtful && found.iterations >= MANY;
        let mut passed = None;
        if flipped && !far && !torn {
            // A determinant that is zero nowhere on the way belongs to another path.
            passed = self.locate_changes(ramp, &count, ends, tally);
            torn = passed.as_ref().is_some_and(Vec::is_empty);
        }
        if torn && (far || step > SHORTEST) {
            return Judged::TooLong((0.2 * step).max(0.9 * SHORTEST));
        }
        // One pair of pivots may be lost at once where nothing is singular; more of them hide what lies between.
        if !conservative && count.own > self.base.own + PAIR && step > SHORTEST {
            return Judged::TooLong((0.4 * step).max(0.9 * SHORTEST));
        }
        if far {
            return Judged::TooLong((0.4 * step).max(0.9 * BRACKET));
        }
        torn |= hard && step <= SHORTEST;
        if rose && step > BRACKET || hard && step > SHORTEST {
            let ratio = march.behind.then_some(step / march.last_increment);
            let again = if rose && hard { None } else { self.in_two_parts(ramp, ends, ratio, tally) };
            let Some(again) = again else { return Judged::TooLong(0.5 * step) };
            if rose
                && !self.system.hangs()
                && let Some(part) = self.passed_twice(ramp, ends, tally)
            {
                return Judged::TooLong((part * step).max(0.9 * BRACKET));
            }
            count = self.count(&again.inertia);
            found = Convergence { iterations: found.iterations, ..again };
        }
        let before = march.behind.then_some(&self.before);
        if guarded || torn || doubtful && self.system.jumped(&self.last, before) {
            let sideways = guarded && count.own <= self.base.own;
            return Judged::Lost(self.rough_stop(stride.target, sideways, march.behind));
        }
        if passed.is_none() {
            passed = self.locate_changes(ramp, &count, ends, tally);
        }
        let rate = moved.into_iter().fold(Size::default(), Size::join).largest() / step;
        Judged::Accepted(Reached { found, count, passed, missed, rate })
    }

    /// Ends a step at the end of its ramp.
    pub(super) fn arrived(&mut self, record: &mut StepHistory, tally: &Tally) -> bool {
        self.settle(record, 1.0, tally);
        record.status = Status::Converged;
        true
    }

    /// Ends a step where nobody wants to wait any longer.
    fn interrupted(&mut self, record: &mut StepHistory, fraction: f64, tally: &Tally) -> bool {
        record.status = Status::Interrupted;
        self.settle(record, fraction, tally);
        false
    }

    /// Whether a rise of the count is to be trusted as a loss of stability.
    fn guards(&self, count: &Count) -> bool {
        let own = count.own > self.base.own && count.potential;
        let lateral = count.lateral > self.base.lateral && count.lateral_potential;
        own || lateral
    }
}
