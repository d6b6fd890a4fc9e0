//! The way back: where a branch that leans to one side ends on the straight one.
//!
//! A network that was pushed past a bifurcation, and is let back, comes to where its branch and the mirrored one meet in the straight
//! one. Both sides are stable there, and no pivot changes its sign along the way: what tells is that a motion is gone that neither
//! loads nor anything that is moved has a part in. The straight branch, followed back, loses its stability at the meeting.
//!
//! Theory: docs/theory/continuation.md, section Branches.

use super::direction::{Direction, Metric};
use super::events::Events;
use super::follow::Run;
use super::locate::Interval;
use super::{Continuation, Count};
use crate::history::CriticalPoint;
use crate::newton::Start;
use crate::system::{State, System};

/// Where two branches meet, and how far the one that was left is a parabola.
pub(super) struct Meeting {
    pub point: CriticalPoint,
    /// Part of the way in the fraction from the meeting to the last state at which the lean is [`PART`] of what it is there.
    opens: Option<f64>,
}

/// Part of a lean at which the branch is looked at once more.
const PART: f64 = 0.4;
/// Part of a lean by which extrapolation misses it where the iteration contracts at once and the path goes on: with a half of it
/// one meeting in ninety of pushed V frames passed for that.
const FORESEEN: f64 = 0.1;
/// Iterations for the softest motion of a state: at first, and in all where others may be nearly as soft.
const FEW: usize = 6;
const PURE: usize = 24;
/// Halvings that lead so near to where a motion is lost that it is by far the softest.
const HALVINGS: usize = 4;
/// Cosine of the angle between what is lost at a meeting and the path that goes on straight, at most: rounding alone. Symmetric V
/// frames and portals have 1e-14 to 1e-6, arches up to 1e-5, V frames drawn 0.2 % of their half span aside 1e-4 to 1.
const STRAIGHT: f64 = 1e-5;
/// The same where the straight branch bends aside for certain.
const BENT: f64 = 1e-3;

impl Meeting {
    /// Whether the branch leads from the last state to the meeting: beyond it there is nothing of it.
    pub(super) fn is_behind(&self) -> bool {
        self.opens.is_none_or(|part| part > 0.0)
    }

    /// Whether it does so as a parabola, which leaves room for nothing else on the way.
    pub(super) fn is_plain(&self) -> bool {
        self.opens.is_some_and(|part| part > 0.5 * PART * PART && part < 2.0 * PART * PART)
    }
}

/// What a branch may have leaned along: the softest motion of the straight one.
struct Lean {
    metric: Metric,
    mode: Direction,
    /// The mode along the equations of the joints.
    solution: Vec<f64>,
}

impl Lean {
    /// Part of a motion that is one along the softest motion.
    fn part(&self, of: &Direction) -> f64 {
        self.metric.inner(&self.mode, of) / self.metric.inner(&self.mode, &self.mode)
    }
}

/// The cosine of the angle between a way and a mode, whose largest part is one, without its sign; zero where there is no more of the
/// mode in the way than `rounding`: what is flat may not move at all.
fn cosine(metric: Metric, mode: &Direction, way: &Direction, rounding: f64) -> f64 {
    let (square, along) = (metric.inner(mode, mode), metric.inner(mode, way).abs());
    if along <= rounding * square { 0.0 } else { along / (square * metric.inner(way, way)).sqrt() }
}

impl<const D: usize> Continuation<'_, D> {
    /// The meeting of branches between the last state and the present one, at these fractions, stable as that one; `ratio` is that
    /// of the increment to the one before, where there is one to extrapolate from, and `quick` whether the iteration contracted at
    /// once to what was foreseen.
    pub(super) fn meeting(
        &mut self,
        run: &mut Run<'_>,
        ends: [f64; 2],
        (count, ratio, quick): (Count, Option<f64>, bool),
    ) -> Option<Meeting> {
        if run.is_nearly_symmetric {
            return None;
        }
        let mut lean = self.softest_lean(FEW);
        let mut way = lean.part(&self.since_last());
        // The largest part of the motion is one.
        if !(way.abs() > self.tuning.shortest) {
            return None;
        }
        if let Some(ratio) = ratio.filter(|_| quick) {
            let before = Direction { motions: self.system.motions_since(&self.before), rate: 0.0 };
            let foreseen = ratio * (lean.part(&before) - way);
            if (way - foreseen).abs() <= FORESEEN * foreseen.abs() {
                return None;
            }
        }
        let solution =
            self.system.tangent.softest_motion_from(lean.solution, PURE - FEW, &self.system.pattern, self.system.size);
        lean = self.lean_along(solution);
        way = lean.part(&self.since_last());
        let along = (ends[1] - ends[0]) * lean.part(&self.rate_at(run, ends[1])?);
        #[cfg(feature = "trace")]
        eprintln!("lean {way:e} along {along:e} from {ends:?} quick {quick}");
        // Of a path that bends the tangent at an end has as much of any motion as the way has, or nearly.
        if along.abs() > self.tuning.near * way.abs() {
            return None;
        }
        let leaning = self.last.clone();
        self.aside_from(run, ends[1], |path, run| path.trace_back(run, ends, (count, Some(&leaning))))
    }

    /// The same where the path to the last state was seen to turn back at the fraction `top`, from the present state beyond it, at
    /// the fraction `at`.
    pub(super) fn meeting_at(&mut self, run: &mut Run<'_>, [top, at]: [f64; 2], count: Count) -> Option<Meeting> {
        if run.is_nearly_symmetric {
            return None;
        }
        #[cfg(feature = "trace")]
        eprintln!("meeting at {top} from {at}");
        let ends = [2.0 * top - at, at];
        let found = self.aside_from(run, at, |path, run| path.trace_back(run, ends, (count, None)));
        found.filter(|met| (met.point.fraction - top).abs() <= 0.5 * (at - top).abs())
    }

    /// Looks for something elsewhere, and comes back to the present state at this fraction.
    fn aside_from<R>(
        &mut self,
        run: &mut Run<'_>,
        fraction: f64,
        look: impl FnOnce(&mut Self, &mut Run<'_>) -> Option<R>,
    ) -> Option<R> {
        let (base, last, here) = (self.base, self.last.clone(), self.system.snapshot());
        let found = look(self, run);
        (self.base, self.last) = (base, last);
        self.system.restore(&here);
        run.ramp.apply(&mut self.system, fraction);
        self.system.assemble(false);
        run.effort.factorizations += 1;
        found
    }

    /// The softest motion at the present state.
    fn softest_lean(&mut self, iterations: usize) -> Lean {
        let solution = self.system.tangent.softest_motion_after(iterations, &self.system.pattern, self.system.size);
        self.lean_along(solution)
    }

    fn lean_along(&self, solution: Vec<f64>) -> Lean {
        let motions = self.system.pattern.motions_of(&solution);
        let metric = Metric::balanced(&motions, 0.0, self.system.size, self.tuning.near);
        Lean { metric, mode: Direction { motions, rate: 0.0 }, solution }
    }

    /// Whether the present state goes on from the state `next` by `step` at this rate, rather than to another branch.
    fn is_along(&self, rate: &Direction, step: f64) -> bool {
        let foreseen = rate.motions.iter().map(|motion| motion.map(|x| step * x));
        let metric = Metric::balanced(&[], 0.0, self.system.size, self.tuning.near);
        let square = |motions: Vec<[f64; 6]>| {
            let motions = Direction { motions, rate: 0.0 };
            metric.inner(&motions, &motions)
        };
        let since = self.system.motions_since(&self.next);
        let missed = since.iter().zip(foreseen.clone()).map(|(a, b)| std::array::from_fn(|c| a[c] - b[c])).collect();
        square(missed) <= self.tuning.shorter.powi(2) * square(foreseen.collect())
    }

    fn since_last(&self) -> Direction {
        Direction { motions: self.system.motions_since(&self.last), rate: 0.0 }
    }

    /// How the present state moves for a unit of the fraction.
    fn rate_at(&mut self, run: &Run<'_>, fraction: f64) -> Option<Direction> {
        // A difference that stays within the tables of muscles.
        let ahead = self.tuning.rounding.sqrt() * if fraction > 0.5 { -1.0 } else { 1.0 };
        let mut apply = |system: &mut System<D>, fraction: f64| run.ramp.apply(system, fraction);
        let motions = self.system.rate_motions(fraction, ahead, &mut apply)?;
        Some(Direction { motions, rate: 0.0 })
    }

    /// Follows the straight branch back from the present state to where it loses its stability, and locates that.
    fn trace_back(
        &mut self,
        run: &mut Run<'_>,
        [from, to]: [f64; 2],
        (count, leaning): (Count, Option<&State>),
    ) -> Option<Meeting> {
        self.base = count;
        // What an increment leaves of a lean is none of the straight branch.
        let exact = self.newton.exact().solve(&mut self.system, Start::nearby());
        run.effort.count(&exact);
        exact.ok()?;
        let mut rate = self.rate_at(run, to)?;
        self.system.save(&mut self.next);
        let (mut at, mut length) = (to, to - from);
        for _ in 0..self.tuning.iterations {
            let target = if (at - length - from) * (to - from) <= 0.0 { from } else { at - length };
            self.system.restore(&self.next);
            run.ramp.apply(&mut self.system, target);
            let outcome =
                self.newton.solve(&mut self.system, Start { predicted: false, may_wander: false, ..Start::nearby() });
            run.effort.count(&outcome);
            let found = outcome.ok().map(|found| found.inertia);
            let near = found.map(|inertia| self.count(&inertia));
            #[cfg(feature = "trace")]
            eprintln!("  straight at {target} from {at}: {:?}", near.map(|near| near.own));
            match near {
                Some(near) if near.own == count.own && self.is_along(&rate, target - at) => {
                    if target == from {
                        return None;
                    }
                    at = target;
                    self.system.save(&mut self.next);
                    rate = self.rate_at(run, target)?;
                }
                // Equal parts of a network lose theirs at one place.
                Some(near)
                    if near.own == count.own + 1
                        || near.own > count.own && (at - target).abs() <= self.tuning.shortest =>
                {
                    self.system.save(&mut self.last);
                    if self.bends_aside(run, [target, at], count) {
                        run.is_nearly_symmetric = true;
                        return None;
                    }
                    self.base = near;
                    let changed = near.own - count.own;
                    let events = Events { count, changed, conservative: true, ..Events::default() };
                    let interval = Interval { ends: [target, at], metric: None, events: &events };
                    if let Some(point) = self.pinpoint(run, interval).pop() {
                        let leaning = leaning.map(|state| (state, from));
                        return self.meeting_found(run, point, [target, at], leaning);
                    }
                    self.base = count;
                    length = 0.5 * (at - target);
                }
                _ => length = self.tuning.shorter * (at - target),
            }
            if length.abs() <= self.tuning.increment * (to - from).abs() {
                return None;
            }
        }
        None
    }

    /// Whether the way between the states `last` and `next`, at these fractions, bends aside along what is lost in between; `count` is
    /// that of the second.
    ///
    /// The states looked at are interpolated, which keeps them straight.
    fn bends_aside(&mut self, run: &mut Run<'_>, ends: [f64; 2], count: Count) -> bool {
        let way = Direction { motions: self.system.motions_since(&self.next), rate: 0.0 };
        let mut bracket = [0.0, 1.0];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (bracket[0] + bracket[1]);
            run.ramp.apply(&mut self.system, ends[0] + middle * (ends[1] - ends[0]));
            self.system.predict(&self.last, &self.next, middle - 1.0);
            run.effort.factorizations += 1;
            let is_near = self.system.assemble(false).negative > count.own;
            bracket[usize::from(!is_near)] = middle;
        }
        let lean = self.softest_lean(PURE);
        cosine(lean.metric, &lean.mode, &way, self.tuning.exact) > BENT
    }

    /// The meeting at a bifurcation of the straight branch, the present state, between the states `last` and `next` of that at the
    /// fractions `ends`; `leaning` is what is to lean there, and its fraction.
    ///
    /// What is lost at a meeting is at right angles to the straight branch. In a network that is nearly symmetric it is not: there
    /// the straight branch is one that folds, and nothing meets. So near to the point rounding moves the state along what is lost,
    /// and what lies on the straight line between both states has no part of that.
    fn meeting_found(
        &mut self,
        run: &mut Run<'_>,
        point: CriticalPoint,
        ends: [f64; 2],
        leaning: Option<(&State, f64)>,
    ) -> Option<Meeting> {
        let fraction = self.system.loading.fraction;
        let here = self.system.snapshot();
        // Of motions that are lost together that is meant in which the branch leans.
        let leans = leaning.map(|(leaning, _)| {
            self.system.restore(leaning);
            self.system.motions_since(&here)
        });
        self.system.restore(&self.next);
        let way = self.since_last();
        run.ramp.apply(&mut self.system, fraction);
        self.system.predict(&self.last, &self.next, (fraction - ends[1]) / (ends[1] - ends[0]));
        self.system.assemble(true);
        self.system.advance(true)?;
        self.system.assemble(false);
        run.effort.factorizations += 2;
        self.last = here;
        let System { tangent, pattern, size, .. } = &mut self.system;
        let mode = match leans {
            Some(leans) => tangent.softest_motion_in(&leans, PURE, pattern, *size),
            None => tangent.softest_motion_after(PURE, pattern, *size),
        };
        let motions = self.system.pattern.motions_of(&mode);
        let metric = Metric::balanced(&motions, 0.0, self.system.size, self.tuning.near);
        let lost = Direction { motions, rate: 0.0 };
        let aside = cosine(metric, &lost, &way, self.tuning.exact);
        #[cfg(feature = "trace")]
        eprintln!("  point {} {:?} cosine {aside:e}", point.fraction, point.located);
        if aside > STRAIGHT {
            run.is_nearly_symmetric |= aside > BENT;
            return None;
        }
        let opens = leaning.and_then(|(leaning, from)| self.opens(run, fraction, (mode, lost), (leaning, from)));
        #[cfg(feature = "trace")]
        eprintln!("  opens {opens:?}");
        Some(Meeting { point, opens })
    }

    /// The part of the way in the fraction from a bifurcation, the state `last` at this one, to a state at the fraction `from` at
    /// which the branch along its critical motion has [`PART`] of the lean that it has there.
    fn opens(
        &mut self,
        run: &mut Run<'_>,
        fraction: f64,
        (mode, lost): (Vec<f64>, Direction),
        (leaning, from): (&State, f64),
    ) -> Option<f64> {
        let metric = Metric::balanced(&lost.motions, 0.0, self.system.size, self.tuning.near);
        let n = metric.functional(&metric.unit(lost.clone()));
        let length = n.along(&lost.motions, 0.0);
        self.system.restore(leaning);
        let lean = PART * n.along(&self.since_last().motions, 0.0);
        self.back_to_last(run.ramp, fraction);
        let aside: Vec<f64> = mode.iter().map(|x| lean / length * x).collect();
        self.system.move_by(&aside, false);
        let mut locator = self.locator(run.ramp);
        let found = locator.correct(&n, lean, fraction, fraction);
        run.effort.factorizations += locator.factorizations;
        found.ok().map(|point| (fraction - point.fraction) / (fraction - from))
    }
}
