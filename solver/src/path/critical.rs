//! Where stability is lost: the exact point, and the way on.

use super::arc::{Direction, Metric};
use super::doubt::SAME;
use super::follow::{BRACKET, Course, Ramp, SHORTEST, Tally};
use super::jump::Landing;
use super::report::{Rough, cause_of, status_of};
use super::trace::Passed;
use super::{Count, Path};
use crate::history::{Cause, CriticalKind, CriticalPoint, Failure, Note, StepHistory};
use crate::newton::{Convergence, Start, Why};
use crate::structure::{Branch, Method};

/// A walk that gets farther than this part of the ramp has found nothing to stop for.
const FALSE_ALARM: f64 = 3.0 * BRACKET;
/// Increments of a walk to a singular point that must be near.
const STRIDES: usize = 80;
/// How often a walk goes back to the same state where it leapt, by what part of the stride it goes on there, and how fast
/// strides may grow again.
const AGAIN: usize = 4;
const SHORTER: f64 = 0.2;
const GROWTH: f64 = 1.5;
/// How far along the mode the first state of a branch is looked for, in lengths of the network or radians.
const AMPLITUDES: [f64; 3] = [0.02, 0.005, 0.08];
/// The part of that where the branch has to be too.
const NEARER: f64 = 0.4;
/// A fraction of the ramp counts as no less than this where it measures what is near it.
const LEAST: f64 = 0.01;
/// How far from a singular point an equilibrium right beyond it may lie, over what the ramp moved so far at the same rate.
const BESIDE: f64 = 20.0;

/// What follows a loss of stability.
pub(super) enum After {
    Stop,
    /// The path goes on from this fraction with the next increment; `last` is the increment between the saved states,
    /// where they may be extrapolated.
    GoOn {
        at: f64,
        next: f64,
        last: Option<f64>,
    },
}

impl<const D: usize> Path<'_, D> {
    /// Finds out what happens beyond the last state, at `fraction`: a singular point, which is noted, or nothing.
    pub(super) fn lose_stability(
        &mut self,
        ramp: &Ramp,
        record: &mut StepHistory,
        fraction: f64,
        course: &Course,
        mut rough: Rough,
        tally: &mut Tally,
    ) -> After {
        let begin = self.base;
        let mut ends = None;
        let mut points = Vec::new();
        let mut again = 0;
        // A member that is held at both ends is no singular point, and shorter strides change nothing.
        let overheld = matches!(rough.failure.cause, Cause::Overheld { .. });
        let walk = if overheld { None } else { self.walk(ramp, fraction, 0.5 * BRACKET, tally) };
        if let Some(mut walk) = walk {
            for _ in 0..STRIDES {
                let begin = walk.clone();
                let passed = match self.stride(&mut walk, ramp, tally) {
                    Ok((_, passed)) => passed,
                    Err(lost) => {
                        if let Why::Overheld(_) = lost.why {
                            // What changed signs on the way was the force of this member, which grows without end.
                            rough = self.rough_end(rough.failure.tried, &lost, false);
                        }
                        break;
                    }
                };
                if passed.any() {
                    let between = [walk.before, walk.fraction];
                    points = self.pinpoint(ramp, between, Some(walk.metric), &passed, tally);
                    if points.is_empty() && again < AGAIN {
                        // A singular point that is not found lies on another path, where the stride leapt.
                        again += 1;
                        let next = SHORTER * walk.last.unwrap_or(walk.next);
                        walk = begin;
                        (walk.next, walk.longest) = (next, next);
                        continue;
                    }
                    ends = Some((between, passed));
                    break;
                }
                if walk.fraction >= 1.0 {
                    if let Some(after) = self.reach_end(ramp, record, tally) {
                        return after;
                    }
                    break;
                }
                self.keep(passed.count);
                again = 0;
                walk.longest *= GROWTH;
                if walk.fraction > fraction + FALSE_ALARM {
                    // Nothing was lost: what looked so was a longer step onto another branch.
                    let last = walk.fraction - walk.before;
                    return After::GoOn { at: walk.fraction, next: 2.0 * last, last: Some(last) };
                }
            }
        }
        if let Some((ends, passed)) = ends {
            let beyond = points.first().is_some_and(|point| point.fraction > 1.0);
            if beyond && let Some(after) = self.reach_end(ramp, record, tally) {
                return after;
            }
            if beyond {
                ramp.apply(&mut self.system, points[0].fraction);
                self.system.assemble(false);
            }
            return self.meet(ramp, record, course, points, ends, &passed, tally);
        }
        // No walk gets there: the last state is what is sure.
        self.base = begin;
        points.extend(rough.point);
        record.critical_points.append(&mut points);
        record.status = rough.status;
        record.failure = Some(rough.failure);
        self.system.restore(&self.last);
        ramp.apply(&mut self.system, fraction);
        self.settle(record, fraction, tally);
        After::Stop
    }

    /// Notes a loss of stability between the states `last` and `next`, at these fractions, and goes on from there where that is
    /// possible; the state is at the last of these points, if any was located.
    #[expect(clippy::too_many_arguments, reason = "all that is known of a loss of stability")]
    pub(super) fn meet(
        &mut self,
        ramp: &Ramp,
        record: &mut StepHistory,
        course: &Course,
        mut points: Vec<CriticalPoint>,
        ends: [f64; 2],
        passed: &Passed,
        tally: &mut Tally,
    ) -> After {
        let located = !points.is_empty();
        if !located {
            let kind = if passed.limit { CriticalKind::LimitPoint } else { CriticalKind::Bifurcation };
            self.system.restore(&self.next);
            ramp.apply(&mut self.system, ends[1]);
            self.system.assemble(false);
            points.push(self.rough_point(kind, ends[1], passed.sideways && !passed.own));
        }
        let first = points[0].clone();
        let found = Convergence { residual: self.system.residual(), ..Convergence::default() };
        self.accept(record, self.system.fraction, &found, tally);
        record.critical_points.append(&mut points);
        if let Some(after) = self.go_on(ramp, record, course, &first, ends, (located, passed.count), tally) {
            return after;
        }
        self.end_at(record, first, tally);
        After::Stop
    }

    /// From the state `last` to the end of the ramp, where no singular point lies between.
    pub(super) fn reach_end(&mut self, ramp: &Ramp, record: &mut StepHistory, tally: &mut Tally) -> Option<After> {
        let here = self.system.snapshot();
        self.system.restore(&self.last);
        ramp.apply(&mut self.system, 1.0);
        if let Ok(found) = self.newton.solve(&mut self.system, Start::nearby()) {
            tally.factorizations += found.iterations;
            let count = self.count(&found.inertia);
            if count.own <= self.base.own && count.lateral <= self.base.lateral {
                self.keep(count);
                self.accept(record, 1.0, &found, tally);
                return Some(After::GoOn { at: 1.0, next: 1.0, last: None });
            }
        }
        self.system.restore(&here);
        None
    }

    /// The way on from a singular point, the present state; `None` where there is none.
    #[expect(clippy::too_many_arguments, reason = "all that is known at a singular point")]
    fn go_on(
        &mut self,
        ramp: &Ramp,
        record: &mut StepHistory,
        course: &Course,
        point: &CriticalPoint,
        ends: [f64; 2],
        (located, beyond): (bool, Count),
        tally: &mut Tally,
    ) -> Option<After> {
        if point.kind == CriticalKind::Bifurcation {
            // Increments pass those without a potential, and note them: a walk that finds one does the same.
            let passes = located && !point.sideways && !(self.base.potential && beyond.potential);
            if course.branch == Branch::Primary || passes {
                self.system.restore(&self.next);
                ramp.apply(&mut self.system, ends[1]);
                self.keep(beyond);
                let last = ends[1] - ends[0];
                let at = self.back_to_end(ramp, record, ends[1], tally);
                return Some(After::GoOn { at, next: (2.0 * last).max(BRACKET), last: Some(last) });
            }
            if !point.sideways {
                let here = self.system.snapshot();
                self.note_inside(ramp, ends);
                self.system.restore(&here);
                ramp.apply(&mut self.system, point.fraction);
                self.system.assemble(false);
            }
            if !point.sideways
                && self.inside.is_empty()
                && let Some(at) = self.switch(ramp, point.fraction, tally)
            {
                if at <= 1.0 {
                    let found = Convergence { residual: self.system.residual(), ..Convergence::default() };
                    self.accept(record, at, &found, tally);
                }
                let at = self.back_to_end(ramp, record, at, tally);
                let next = (4.0 * (at - point.fraction)).clamp(2.0 * SHORTEST, 1.0);
                return Some(After::GoOn { at, next, last: None });
            }
        }
        if point.kind == CriticalKind::LimitPoint
            && let Some(at) = self.touch(ramp, point.fraction, tally)
        {
            record.critical_points.retain(|noted| noted != point);
            record.notes.push(Note::TouchedSingular { fraction: point.fraction });
            let found = Convergence { residual: self.system.residual(), ..Convergence::default() };
            self.accept(record, at, &found, tally);
            return Some(After::GoOn { at, next: BRACKET, last: None });
        }
        if course.method == Method::Jump && self.base.potential && !point.sideways {
            match self.jump(ramp, point, tally) {
                Landing::Stable { fraction, jump } => {
                    record.jumps.push(jump);
                    if self.base.lateral > 0 {
                        let aside = self.rough_point(CriticalKind::Bifurcation, fraction, true);
                        record.critical_points.push(aside);
                    }
                    self.system.save(&mut self.last);
                    let found = Convergence { residual: self.system.residual(), ..Convergence::default() };
                    self.accept(record, fraction, &found, tally);
                    return Some(After::GoOn { at: fraction, next: 5.0 * BRACKET, last: None });
                }
                Landing::Endless => record.failure = Some(Failure { cause: Cause::Unbounded, ..failure_at(point) }),
                Landing::Lost => {}
            }
            self.system.restore(&self.last);
            ramp.apply(&mut self.system, point.fraction);
            self.system.assemble(false);
        }
        None
    }

    /// From a state that a singular point led to, at this fraction, back to the end of the ramp if it lies beyond; the fraction
    /// where the state is then.
    fn back_to_end(&mut self, ramp: &Ramp, record: &mut StepHistory, at: f64, tally: &mut Tally) -> f64 {
        if at <= 1.0 {
            return at;
        }
        self.system.save(&mut self.last);
        ramp.apply(&mut self.system, 1.0);
        let found = self.newton.solve(&mut self.system, Start::nearby());
        tally.factorizations += found.as_ref().map_or_else(|lost| lost.iterations, |found| found.iterations);
        let near = BESIDE * (at - 1.0) * self.system.moved() + SAME;
        let found = found.ok().filter(|_| self.system.distance(&self.last).largest() <= near);
        let Some(found) = found else {
            self.system.restore(&self.last);
            ramp.apply(&mut self.system, at);
            self.system.assemble(false);
            let found = Convergence { residual: self.system.residual(), ..Convergence::default() };
            self.accept(record, at, &found, tally);
            return at;
        };
        self.base = self.count(&found.inertia);
        self.system.save(&mut self.last);
        self.accept(record, 1.0, &found, tally);
        1.0
    }

    /// From a singular point, the present state, to a stable equilibrium right beyond it; the fraction there.
    ///
    /// Two mirrored equilibria may meet in a symmetric one that stays: a dyad that its own muscles pull flat.
    fn touch(&mut self, ramp: &Ramp, fraction: f64, tally: &mut Tally) -> Option<f64> {
        if !self.base.potential || fraction >= 1.0 {
            return None;
        }
        self.system.save(&mut self.last);
        // What is far beyond a point depends on how far that is itself.
        let beyond = 0.5 * BRACKET * fraction.clamp(LEAST, 1.0);
        let at = (fraction + beyond).min(1.0);
        ramp.apply(&mut self.system, at);
        let base = self.base;
        let beside = BESIDE * beyond / fraction.max(LEAST) * self.system.moved();
        let found = self.flow(beside, tally);
        self.system.remove_dashpots();
        if found == Some(true) && self.base.lateral <= base.lateral {
            self.system.save(&mut self.last);
            return Some(at);
        }
        self.base = base;
        self.system.restore(&self.last);
        ramp.apply(&mut self.system, fraction);
        self.system.assemble(false);
        None
    }

    /// Notes the members that have more negative pivots between their ends at `next` than at `last`.
    fn note_inside(&mut self, ramp: &Ramp, ends: [f64; 2]) {
        let system = &mut self.system;
        let mut pivots = [(&self.last, ends[0]), (&self.next, ends[1])].map(|(state, fraction)| {
            system.restore(state);
            ramp.apply(system, fraction);
            system.gather(false);
            system.members.iter().map(|m| system.packs[m.pack].pivots(m.lane).0).collect::<Vec<_>>()
        });
        let far = std::mem::take(&mut pivots[1]);
        self.inside = (0..far.len()).filter(|&member| far[member] > pivots[0][member]).collect();
    }

    /// From a bifurcation, the present state, onto the branch that is stable and leads on; the fraction there.
    pub(super) fn switch(&mut self, ramp: &Ramp, fraction: f64, tally: &mut Tally) -> Option<f64> {
        if !self.base.potential {
            return None;
        }
        self.system.save(&mut self.last);
        let mode = self.system.softest_motion();
        let motions = self.system.motions_of(&mode);
        let metric = Metric::balanced(&motions, 0.0, self.system.size);
        let direction = metric.unit(Direction { motions, rate: 0.0 });
        let n = metric.functional(&direction);
        let length = n.along(&self.system.motions_of(&mode), 0.0);
        let base = self.base;
        let mut point_at = |path: &mut Self, amplitude: f64| {
            path.system.restore(&path.last);
            ramp.apply(&mut path.system, fraction);
            path.system.assemble(false);
            let aside: Vec<f64> = mode.iter().map(|x| amplitude * x).collect();
            path.system.move_by(&aside, false);
            let mut tracer = path.tracer(ramp);
            let found = tracer.correct(&n, amplitude * length, fraction, fraction);
            tally.factorizations += tracer.factorizations;
            let count =
                found.ok().filter(|point| point.fraction > fraction).map(|p| (p.fraction, path.count(&p.inertia)));
            count.filter(|(_, count)| count.own <= base.own && count.lateral <= base.lateral)
        };
        for amplitude in AMPLITUDES {
            for sign in [1.0, -1.0] {
                // A branch that first turns back is reached by a snap alone.
                if point_at(self, NEARER * sign * amplitude).is_some()
                    && let Some((at, count)) = point_at(self, sign * amplitude)
                {
                    self.base = count;
                    self.system.save(&mut self.last);
                    return Some(at);
                }
            }
        }
        self.system.restore(&self.last);
        ramp.apply(&mut self.system, fraction);
        self.system.assemble(false);
        None
    }

    /// Ends a step at a singular point, which is the present state.
    fn end_at(&mut self, record: &mut StepHistory, point: CriticalPoint, tally: &mut Tally) {
        record.status = status_of(point.kind);
        record.failure.get_or_insert_with(|| failure_at(&point));
        self.settle(record, point.fraction, tally);
    }
}

/// A path that ends in a singular point.
fn failure_at(point: &CriticalPoint) -> Failure {
    Failure {
        tried: point.fraction,
        worst_node: Some(point.node),
        worst_component: 0,
        worst_residual: 0.0,
        cause: cause_of(point.kind, point.sideways),
    }
}
