//! Steps that go along the arc of their path: through limit points, or from each to the next stable equilibrium.
//!
//! The length of the arc is indifferent to how much of the ramp an event takes: a snap at a thousandth of the ramp is met
//! like one at its end, and two that are near each other are met one after the other.

use super::Path;
use super::arc::Metric;
use super::critical::After;
use super::follow::{Course, Ramp, Tally};
use super::trace::{Passed, Walk};
use crate::history::{CriticalKind, Note, Status, StepHistory};
use crate::newton::{Convergence, Lost, Start, Why};
use crate::structure::{Branch, Method, Stop};
use crate::system::System;

/// Part of the ramp that the first increment along an arc makes.
const FIRST_REACH: f64 = 0.05;
/// The same where snaps are to be met one by one, and after one of them the part of the fraction where it was.
const FIRST_TO_SNAP: f64 = 0.01;
const AFTER_SNAP: f64 = 0.1;
/// Increments along an arc at most, where nothing else ends them.
const MANY: usize = 5000;
/// How often a stride is made again where no singular point is found between its ends, by what part of it, and how fast
/// strides may grow again.
const AGAIN: usize = 4;
const SHORTER: f64 = 0.2;
const GROWTH: f64 = 1.5;
/// Where a branch meets another one, the other is entered so far beyond that point, over its fraction.
const BEYOND: [f64; 2] = [1e-3, 4e-3];
/// Part of the way to such a point within which two strides of different length must see it.
const SAME_TOP: f64 = 0.1;
/// How far from there the other may lie, over what the ramp moved so far at the same rate.
const BESIDE: f64 = 5.0;

impl<const D: usize> Path<'_, D> {
    /// Follows a path by its arclength to the end of the ramp, or to where it is to stop.
    ///
    /// With [`Method::Jump`] a loss of stability ends the arc there, or another begins where the network snaps to.
    pub(super) fn follow_arc(
        &mut self,
        ramp: &Ramp,
        record: &mut StepHistory,
        watch: &mut dyn FnMut(f64) -> bool,
        course: &Course,
    ) -> bool {
        let mut tally = Tally { iterations: 0, factorizations: 0, accepted: 0 };
        let jumps = course.method == Method::Jump;
        self.system.save(&mut self.last);
        let most = match course.stop {
            Some(Stop::Increments(count)) => count,
            _ => MANY,
        };
        let first = if jumps { FIRST_TO_SNAP } else { FIRST_REACH };
        let reach = self.options.first_increment.min(ramp.longest).min(first);
        let Some(mut walk) = self.walk(ramp, 0.0, reach, &mut tally) else {
            if jumps {
                return self.follow(ramp, record, watch, Some(course), 0.0);
            }
            let residual = self.system.residual();
            let lost = Lost { iterations: 1, factorizations: 1, residual, why: Why::Singular };
            return self.end_roughly(record, 0.0, &lost, &tally);
        };
        walk.touches = true;
        let mut longest = f64::INFINITY;
        if ramp.longest < 1.0 {
            longest = ramp.longest / reach * walk.next;
            walk.longest = longest;
        }
        let mut again = 0;
        for _ in 0..most {
            let begin = walk.clone();
            let (point, passed) = match self.stride(&mut walk, ramp, &mut tally) {
                Ok(found) => found,
                Err(lost) => {
                    self.system.restore(&self.last);
                    if jumps {
                        // Where the arc cannot be followed the ramp may be.
                        self.settle(record, walk.fraction, &tally);
                        return self.follow(ramp, record, watch, Some(course), walk.fraction);
                    }
                    return self.end_roughly(record, walk.fraction, &lost, &tally);
                }
            };
            let ends = [walk.before, walk.fraction];
            self.system.save(&mut self.next);
            if passed.touched {
                let (top, part) = top_between(&begin, &walk);
                let near = SAME_TOP * (top - begin.fraction).abs();
                if !begin.top.is_some_and(|known| (top - known).abs() <= near) {
                    // Seen from nearer it is the same place, or a leap onto another path.
                    let next = SHORTER * walk.last.unwrap_or(walk.next);
                    walk = begin;
                    (walk.next, walk.top) = (next, Some(top));
                    continue;
                }
                let other = match course.branch {
                    Branch::Stable => self.rejoin(ramp, (top, part), [&begin, &walk], &mut tally),
                    Branch::Primary => None,
                };
                let Some((touched, at)) = other else {
                    // Nothing to go on to: nearer before it is believed.
                    let next = SHORTER * walk.last.unwrap_or(walk.next);
                    walk = begin;
                    (walk.next, walk.touches) = (next, false);
                    continue;
                };
                record.notes.push(Note::TouchedSingular { fraction: touched });
                let found = Convergence { residual: self.system.residual(), ..Convergence::default() };
                self.accept(record, at, &found, &tally);
                let Some(onward) = self.onward(ramp, &walk, at, at - touched, &mut tally) else {
                    return self.lost_direction(record, at, &tally);
                };
                walk = onward;
                continue;
            }
            if !jumps && let Some(last) = self.arrive(ramp, course, ends, walk.metric, &mut tally) {
                let found = Convergence { residual: self.system.residual(), ..Convergence::default() };
                self.finish_arc(record, last, &found, &tally);
                return true;
            }
            if passed.any() {
                let points = self.pinpoint(ramp, ends, Some(walk.metric), &passed, &mut tally);
                if points.is_empty() && again < AGAIN {
                    // A singular point that is not found lies on another path, where the stride leapt.
                    again += 1;
                    let next = SHORTER * walk.last.unwrap_or(walk.next);
                    walk = begin;
                    (walk.next, walk.longest) = (next, next);
                    continue;
                }
                if jumps && self.is_lost(&passed) {
                    let beyond = points.first().is_some_and(|point| point.fraction > 1.0);
                    if beyond && self.reach_end(ramp, record, &mut tally).is_some() {
                        return self.arrived(record, &tally);
                    }
                    let After::GoOn { at, .. } = self.meet(ramp, record, course, points, ends, &passed, &mut tally)
                    else {
                        return false;
                    };
                    if at >= 1.0 {
                        return self.arrived(record, &tally);
                    }
                    let reach = AFTER_SNAP * at.abs().max(FIRST_TO_SNAP);
                    let Some(onward) = self.onward(ramp, &walk, at, reach, &mut tally) else {
                        return self.follow(ramp, record, watch, Some(course), at);
                    };
                    walk = onward;
                    walk.longest = longest;
                    continue;
                } else {
                    record.critical_points.extend(points.iter().cloned());
                    if !points.is_empty() {
                        let found = Convergence { residual: self.system.residual(), ..Convergence::default() };
                        self.accept(record, self.system.fraction, &found, &tally);
                    }
                    let first = points.first().filter(|point| {
                        point.kind == CriticalKind::Bifurcation && course.branch == Branch::Stable && self.base.own == 0
                    });
                    if let Some(first) = first
                        && !first.sideways
                        && points.len() == 1
                        && let Some(at) = self.switch(ramp, first.fraction, &mut tally)
                        && let Some(onward) = self.onward(ramp, &walk, at, (at - first.fraction).abs(), &mut tally)
                    {
                        walk = onward;
                        self.accept(record, at, &Convergence::default(), &tally);
                        continue;
                    }
                }
                self.system.restore(&self.next);
                ramp.apply(&mut self.system, walk.fraction);
                self.system.assemble(false);
            }
            if jumps && let Some(last) = self.arrive(ramp, course, ends, walk.metric, &mut tally) {
                let found = Convergence { residual: self.system.residual(), ..Convergence::default() };
                self.finish_arc(record, last, &found, &tally);
                return true;
            }
            again = 0;
            walk.touches = true;
            walk.longest = (GROWTH * walk.longest).min(longest);
            self.keep(passed.count);
            let found = Convergence { residual: point.residual, ..Convergence::default() };
            self.accept(record, walk.fraction, &found, &tally);
            if !watch(walk.fraction.clamp(0.0, 1.0)) {
                record.status = Status::Interrupted;
                self.settle(record, walk.fraction, &tally);
                return false;
            }
        }
        let last = walk.fraction;
        if matches!(course.stop, Some(Stop::Increments(_))) {
            self.stay(last);
            record.status = Status::Converged;
            self.settle(record, last, &tally);
            return true;
        }
        let residual = self.system.residual();
        let lost = Lost { iterations: 0, factorizations: 0, residual, why: Why::Slow };
        self.end_roughly(record, last, &lost, &tally)
    }

    /// Whether stability is lost where these are passed, or the ramp turns back.
    fn is_lost(&self, passed: &Passed) -> bool {
        let Passed { count, limit, .. } = *passed;
        limit || count.own > self.base.own || count.lateral > self.base.lateral && count.lateral_potential
    }

    /// A walk from the last saved state, at the fraction `at`, the way that leads from another walk to there.
    fn onward(&mut self, ramp: &Ramp, walk: &Walk, at: f64, reach: f64, tally: &mut Tally) -> Option<Walk> {
        let mut onward = self.walk(ramp, at, reach.abs(), tally)?;
        if reach < 0.0 {
            onward.turn_back();
        }
        (onward.longest, onward.touches) = (walk.longest, walk.touches);
        Some(onward)
    }

    fn lost_direction(&mut self, record: &mut StepHistory, fraction: f64, tally: &Tally) -> bool {
        let residual = self.system.residual();
        let lost = Lost { iterations: 1, factorizations: 1, residual, why: Why::Singular };
        self.end_roughly(record, fraction, &lost, tally)
    }

    /// From a branch that turns back where it meets another one, between `last` and `next`, onto that other one beyond; the
    /// fractions where they meet and where the state is then.
    ///
    /// Branches that buckle to either side are one curve, on which the fraction is greatest (or least) where it crosses
    /// the straight one: both of its sides are as stable as that is beyond. No eigenvalue changes its sign there, and
    /// the equations bordered along the curve are singular; beyond, those of the straight branch at a fixed fraction are not.
    fn rejoin(
        &mut self,
        ramp: &Ramp,
        (top, part): (f64, f64),
        [before, after]: [&Walk; 2],
        tally: &mut Tally,
    ) -> Option<(f64, f64)> {
        let scale = top.abs().max(FIRST_TO_SNAP);
        self.system.restore(&self.next);
        let apart = self.system.distance(&self.last).largest();
        let moved = self.system.moved();
        // A branch that is stable is left for what lies ahead; from one that is not either side will do, if it is stable.
        let ahead = before.rate().signum();
        let unstable = self.base.negative() > 0;
        let sides = [ahead, -ahead];
        let sides = &sides[..=usize::from(unstable)];
        for (side, beyond) in sides.iter().flat_map(|side| BEYOND.map(|beyond| (side, beyond))) {
            let at = top + side * beyond * scale;
            let reach = apart + BESIDE * beyond * moved;
            if self.settles(ramp, at, part, reach, tally) {
                self.shift_states();
                return Some((top, at));
            }
        }
        self.system.restore(&self.next);
        ramp.apply(&mut self.system, after.fraction);
        self.system.assemble(false);
        None
    }

    /// Brings what lies at a part of the way from `last` to `next` to a stable equilibrium at the fraction `at`, no farther than
    /// `reach` from `last`; false, with `next` as it was, where there is none.
    fn settles(&mut self, ramp: &Ramp, at: f64, part: f64, reach: f64, tally: &mut Tally) -> bool {
        let base = self.base;
        ramp.apply(&mut self.system, at);
        self.system.predict(&self.last, &self.next, part - 1.0);
        let found = self.newton.solve(&mut self.system, Start::nearby());
        tally.factorizations += found.as_ref().map_or_else(|lost| lost.iterations, |found| found.iterations);
        if let Ok(found) = found
            && self.system.distance(&self.last).largest() <= reach
        {
            let count = self.count(&found.inertia);
            if count.negative() == 0 {
                self.base = count;
                return true;
            }
        }
        if !base.potential {
            return false;
        }
        // So near to the meeting of branches iterations may come out on any of them; what is stable is where energy is least.
        self.system.restore(&self.next);
        let here = self.system.snapshot();
        self.system.predict(&self.last, &self.next, part - 1.0);
        let found = self.flow(reach, tally);
        self.system.remove_dashpots();
        if found == Some(true) && self.base.lateral <= base.lateral {
            return true;
        }
        self.base = base;
        self.system.restore(&here);
        self.system.save(&mut self.next);
        false
    }

    fn end_roughly(&mut self, record: &mut StepHistory, fraction: f64, lost: &Lost, tally: &Tally) -> bool {
        let rough = self.rough_end(fraction, lost, false);
        record.status = rough.status;
        record.failure = Some(rough.failure);
        self.settle(record, fraction, tally);
        false
    }

    fn finish_arc(&mut self, record: &mut StepHistory, fraction: f64, found: &Convergence, tally: &Tally) {
        self.stay(fraction);
        self.accept(record, fraction, found, tally);
        record.status = Status::Converged;
        self.settle(record, fraction, tally);
    }

    /// What was on its way to the end of the ramp stays where it is.
    fn stay(&mut self, fraction: f64) {
        for held in self.held.values_mut() {
            held.to = held.at(fraction);
        }
    }

    /// Where the path between `last` and `next` reaches its end: the state is there then.
    fn arrive(
        &mut self,
        ramp: &Ramp,
        course: &Course,
        ends: [f64; 2],
        metric: Metric,
        tally: &mut Tally,
    ) -> Option<f64> {
        let crosses = |value: f64| (ends[0] - value) * (ends[1] - value) <= 0.0 && ends[0] != value;
        let target = match course.stop {
            Some(Stop::Fraction(value)) if crosses(value) => Some(value),
            _ => (ends[1] >= 1.0).then_some(1.0),
        };
        if let Some(Stop::At { node, component, value }) = course.stop {
            let read = |system: &System<D>| system.component(node, component) - value;
            self.system.restore(&self.last);
            let begin = read(&self.system);
            self.system.restore(&self.next);
            if begin != 0.0 && begin * read(&self.system) <= 0.0 {
                let mut tracer = self.tracer(ramp);
                let found = tracer.singular_point(ends, Some(metric), &mut |system, _| {
                    let now = read(system);
                    (now * begin > 0.0, Some(now))
                });
                tally.factorizations += tracer.factorizations;
                if let Some(point) = found {
                    self.base = self.count(&point.inertia);
                    return Some(point.fraction);
                }
            }
        }
        let target = target?;
        let s = (target - ends[0]) / (ends[1] - ends[0]);
        ramp.apply(&mut self.system, target);
        self.system.predict(&self.last, &self.next, s - 1.0);
        let found = self.newton.solve(&mut self.system, Start::nearby());
        match found {
            Ok(found) => {
                tally.factorizations += found.iterations;
                self.base = self.count(&found.inertia);
                self.shift_states();
                Some(target)
            }
            Err(_) => {
                self.system.restore(&self.next);
                None
            }
        }
    }
}

/// The fraction at which a path turns back between two states of a walk, and the part of the way there: the top of the
/// parabola that has the slopes of both.
fn top_between(before: &Walk, after: &Walk) -> (f64, f64) {
    let (rises, falls) = (before.rate(), after.rate());
    let part = rises / (rises - falls);
    (before.fraction + 0.5 * rises * part * after.last.unwrap_or(0.0), part)
}
