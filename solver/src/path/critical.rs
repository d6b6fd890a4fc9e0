//! Where stability is lost: the exact point, and the way on.

use super::arc::{Direction, Metric, NEXT, Tracer};
use super::follow::{BRACKET, Course, LAST, Ramp, SHORTEST, Tally};
use super::jump::Landing;
use super::report::{Rough, cause_of, status_of};
use super::{Count, Path};
use crate::history::{Cause, CriticalKind, CriticalPoint, Failure, Note, Status, StepHistory};
use crate::newton::{Convergence, DETOUR, Start};
use crate::structure::{Branch, Method, Stop};
use crate::system::System;

/// A walk that gets farther than this part of the ramp has found nothing to stop for.
const FALSE_ALARM: f64 = 3.0 * BRACKET;
/// Increments of a walk to a singular point that must be near.
const STRIDES: usize = 80;
/// How often a walk goes back to where it leapt, by what part of the stride it goes on there, and how fast strides may grow
/// again.
const AGAIN: usize = 4;
const SHORTER: f64 = 0.2;
const GROWTH: f64 = 1.5;
/// How far along the mode the first state of a branch is looked for, in lengths of the network or radians.
const AMPLITUDES: [f64; 3] = [0.02, 0.005, 0.08];
/// How far from a singular point an equilibrium right beyond it may lie, over what the ramp moved so far at the same rate.
const BESIDE: f64 = 20.0;
/// Part of the ramp that the first increment along an arc makes.
const FIRST_REACH: f64 = 0.05;
/// Increments of an arc-length step at most, where nothing else ends it.
const MANY: usize = 5000;

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
        rough: Rough,
        tally: &mut Tally,
    ) -> After {
        let begin = self.base;
        let mut ends = None;
        let mut points = Vec::new();
        let mut again = 0;
        if let Some(mut walk) = self.walk(ramp, fraction, 0.5 * BRACKET, tally) {
            for _ in 0..STRIDES {
                let begin = walk.clone();
                let Ok((_, passed)) = self.stride(&mut walk, ramp, tally) else { break };
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
                walk.longest *= GROWTH;
                if walk.fraction > fraction + FALSE_ALARM {
                    // Nothing was lost: what looked so was a longer step onto another branch.
                    let last = walk.fraction - walk.before;
                    return After::GoOn { at: walk.fraction, next: 2.0 * last, last: Some(last) };
                }
            }
        }
        if let Some((ends, passed)) = ends {
            let located = !points.is_empty();
            if !located {
                let kind = if passed.limit { CriticalKind::LimitPoint } else { CriticalKind::Bifurcation };
                self.system.restore(NEXT);
                ramp.apply(&mut self.system, ends[1]);
                self.system.assemble(false);
                points.push(self.rough_point(kind, ends[1], passed.sideways && !passed.own));
            }
            let first = points[0].clone();
            if first.fraction > 1.0 {
                if let Some(after) = self.reach_end(ramp, record, tally) {
                    return after;
                }
                ramp.apply(&mut self.system, first.fraction);
                self.system.assemble(false);
            }
            let found = Convergence { residual: self.system.residual(), ..Convergence::default() };
            self.accept(record, self.system.fraction, &found, tally);
            record.critical_points.extend(points.iter().cloned());
            if let Some(after) = self.go_on(ramp, record, course, &first, ends, (located, passed.count), tally) {
                return after;
            }
            self.end_at(record, first, tally);
            return After::Stop;
        }
        // No walk gets there: the last state is what is sure.
        self.base = begin;
        points.extend(rough.point);
        record.critical_points.append(&mut points);
        record.status = rough.status;
        record.failure = Some(rough.failure);
        self.system.restore(LAST);
        ramp.apply(&mut self.system, fraction);
        self.settle(record, fraction, tally);
        After::Stop
    }

    /// From the state LAST to the end of the ramp, where no singular point lies between.
    fn reach_end(&mut self, ramp: &Ramp, record: &mut StepHistory, tally: &mut Tally) -> Option<After> {
        self.system.save(DETOUR);
        self.system.restore(LAST);
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
        self.system.restore(DETOUR);
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
                self.system.restore(NEXT);
                self.keep(beyond);
                let last = ends[1] - ends[0];
                return Some(After::GoOn { at: ends[1], next: (2.0 * last).max(BRACKET), last: Some(last) });
            }
            if !point.sideways {
                self.system.save(DETOUR);
                self.note_inside(ramp, ends);
                self.system.restore(DETOUR);
                ramp.apply(&mut self.system, point.fraction);
                self.system.assemble(false);
            }
            if !point.sideways
                && self.inside.is_empty()
                && let Some(at) = self.switch(ramp, point.fraction, tally)
            {
                let found = Convergence { residual: self.system.residual(), ..Convergence::default() };
                self.accept(record, at, &found, tally);
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
                    self.system.save(LAST);
                    let found = Convergence { residual: self.system.residual(), ..Convergence::default() };
                    self.accept(record, fraction, &found, tally);
                    return Some(After::GoOn { at: fraction, next: 5.0 * BRACKET, last: None });
                }
                Landing::Endless => record.failure = Some(Failure { cause: Cause::Unbounded, ..failure_at(point) }),
                Landing::Lost => {}
            }
            self.system.restore(LAST);
            ramp.apply(&mut self.system, point.fraction);
            self.system.assemble(false);
        }
        None
    }

    /// From a singular point, the present state, to a stable equilibrium right beyond it; the fraction there.
    ///
    /// Two mirrored equilibria may meet in a symmetric one that stays: a dyad that its own muscles pull flat.
    fn touch(&mut self, ramp: &Ramp, fraction: f64, tally: &mut Tally) -> Option<f64> {
        if !self.base.potential || fraction >= 1.0 {
            return None;
        }
        self.system.save(LAST);
        let at = (fraction + 0.5 * BRACKET).min(1.0);
        ramp.apply(&mut self.system, at);
        let base = self.base;
        let beside = BESIDE * (at - fraction) / fraction.max(BRACKET) * self.system.moved();
        let found = self.flow(beside, tally);
        self.system.set_dashpots(0.0, NEXT);
        if found == Some(true) && self.base.lateral <= base.lateral {
            self.system.save(LAST);
            return Some(at);
        }
        self.base = base;
        self.system.restore(LAST);
        ramp.apply(&mut self.system, fraction);
        self.system.assemble(false);
        None
    }

    /// Notes the members that have more negative pivots between their ends at NEXT than at LAST.
    fn note_inside(&mut self, ramp: &Ramp, ends: [f64; 2]) {
        let system = &mut self.system;
        let mut pivots = [(LAST, ends[0]), (NEXT, ends[1])].map(|(slot, fraction)| {
            system.restore(slot);
            ramp.apply(system, fraction);
            system.gather(false);
            system.members.iter().map(|m| system.packs[m.pack].pivots(m.lane).0).collect::<Vec<_>>()
        });
        let far = std::mem::take(&mut pivots[1]);
        self.inside = (0..far.len()).filter(|&member| far[member] > pivots[0][member]).collect();
    }

    /// From a bifurcation, the present state, onto the branch that is stable and leads on; the fraction there.
    fn switch(&mut self, ramp: &Ramp, fraction: f64, tally: &mut Tally) -> Option<f64> {
        if !self.base.potential {
            return None;
        }
        self.system.save(LAST);
        let mode = self.system.softest_motion();
        let motions = self.system.motions_of(&mode);
        let metric = Metric::balanced(&motions, 0.0, self.system.size);
        let direction = metric.unit(Direction { motions, rate: 0.0 });
        let n = metric.functional(&direction);
        let length = n.along(&self.system.motions_of(&mode), 0.0);
        for amplitude in AMPLITUDES {
            for sign in [1.0, -1.0] {
                self.system.restore(LAST);
                ramp.apply(&mut self.system, fraction);
                self.system.assemble(false);
                let aside: Vec<f64> = mode.iter().map(|x| sign * amplitude * x).collect();
                self.system.move_by(&aside, false);
                let mut tracer = Tracer { system: &mut self.system, newton: self.newton, ramp, factorizations: 0 };
                let found = tracer.correct(&n, sign * amplitude * length, fraction, fraction);
                tally.factorizations += tracer.factorizations;
                let Ok(point) = found else { continue };
                let count = self.count(&point.inertia);
                if point.fraction > fraction && count.own <= self.base.own && count.lateral <= self.base.lateral {
                    self.base = count;
                    self.system.save(LAST);
                    return Some(point.fraction);
                }
            }
        }
        self.system.restore(LAST);
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

    /// Follows a path by its arclength to the end of the ramp, or to where it is to stop.
    pub(super) fn follow_arc(
        &mut self,
        ramp: &Ramp,
        record: &mut StepHistory,
        watch: &mut dyn FnMut(f64) -> bool,
        course: &Course,
    ) -> bool {
        let mut tally = Tally { iterations: 0, factorizations: 0, accepted: 0 };
        self.system.save(LAST);
        let most = match course.stop {
            Some(Stop::Increments(count)) => count,
            _ => MANY,
        };
        let reach = self.options.first_increment.min(ramp.longest).min(FIRST_REACH);
        let Some(mut walk) = self.walk(ramp, 0.0, reach, &mut tally) else {
            let residual = self.system.residual();
            let lost =
                crate::newton::Lost { iterations: 1, factorizations: 1, residual, why: crate::newton::Why::Singular };
            return self.end_roughly(record, 0.0, &lost, &tally);
        };
        if ramp.longest < 1.0 {
            walk.longest = ramp.longest / reach * walk.next;
        }
        for _ in 0..most {
            let (point, passed) = match self.stride(&mut walk, ramp, &mut tally) {
                Ok(found) => found,
                Err(lost) => {
                    self.system.restore(LAST);
                    return self.end_roughly(record, walk.fraction, &lost, &tally);
                }
            };
            let ends = [walk.before, walk.fraction];
            self.system.save(NEXT);
            if let Some(last) = self.arrive(ramp, course, ends, walk.metric, &mut tally) {
                let found = Convergence { residual: self.system.residual(), ..Convergence::default() };
                self.finish_arc(record, last, &found, &tally);
                return true;
            }
            if passed.any() {
                let points = self.pinpoint(ramp, ends, Some(walk.metric), &passed, &mut tally);
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
                    && let Some(mut onward) = self.walk(ramp, at, (at - first.fraction).abs(), &mut tally)
                {
                    onward.longest = walk.longest;
                    walk = onward;
                    self.accept(record, at, &Convergence::default(), &tally);
                    continue;
                }
                self.system.restore(NEXT);
                ramp.apply(&mut self.system, walk.fraction);
                self.system.assemble(false);
            }
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
        let lost = crate::newton::Lost { iterations: 0, factorizations: 0, residual, why: crate::newton::Why::Slow };
        self.end_roughly(record, last, &lost, &tally)
    }

    fn end_roughly(
        &mut self,
        record: &mut StepHistory,
        fraction: f64,
        lost: &crate::newton::Lost,
        tally: &Tally,
    ) -> bool {
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

    /// Where the path between LAST and NEXT reaches its end: the state is there then.
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
            self.system.restore(LAST);
            let begin = read(&self.system);
            self.system.restore(NEXT);
            if begin != 0.0 && begin * read(&self.system) <= 0.0 {
                let mut tracer = Tracer { system: &mut self.system, newton: self.newton, ramp, factorizations: 0 };
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
        self.system.predict(LAST, NEXT, s - 1.0);
        let found = self.newton.solve(&mut self.system, Start::nearby());
        match found {
            Ok(found) => {
                tally.factorizations += found.iterations;
                self.base = self.count(&found.inertia);
                self.system.save_as(LAST, super::follow::BEFORE);
                Some(target)
            }
            Err(_) => {
                self.system.restore(NEXT);
                None
            }
        }
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
