//! The way on from a singular point: straight on, along another branch, or back to the end of the ramp.
//!
//! Theory: docs/theory/continuation.md, section Branches.

use super::arc::{ArcIncrement, ByArc};
use super::direction::{Direction, Metric};
use super::events::Events;
use super::follow::{Control, Next, Run};
use super::meeting::Meeting;
use super::record::{cause_of, status_of};
use super::release::Release;
use super::{Continuation, Count};
use crate::history::{Cause, CriticalKind, CriticalPoint, Failure, Note};
use crate::packs;
use crate::structure::{Branch, Method};

/// What follows a loss of stability.
pub(super) enum Onward {
    Nowhere,
    /// The path goes on from this fraction with the next increment; `last` is the increment between the saved states,
    /// where they may be extrapolated.
    From {
        at: f64,
        next: f64,
        last: Option<f64>,
    },
}

impl<const D: usize> Continuation<'_, D> {
    /// Notes a loss of stability between the states `last` and `next`, at these fractions, and goes on from there where that is
    /// possible; the state is at the last of these points, or at `next` where it could not be located.
    pub(super) fn meet(
        &mut self,
        run: &mut Run<'_>,
        (mut points, located): (Vec<CriticalPoint>, bool),
        ends: [f64; 2],
        events: &Events,
    ) -> Onward {
        run.record.place(&mut points);
        let first = points[0].clone();
        let residual = self.system.residual();
        self.accept(run.record, self.system.loading.fraction, residual);
        run.record.critical_points.append(&mut points);
        let onward = match first.kind {
            CriticalKind::Bifurcation => self.leave_bifurcation(run, &first, ends, (located, events.count)),
            CriticalKind::LimitPoint => self.touch(run, &first),
        };
        if let Some(onward) = onward.or_else(|| self.release_from(run, &first)) {
            return onward;
        }
        // The ramp ends at the singular point, which is the present state.
        run.record.status = status_of(first.kind);
        run.record.failure.get_or_insert_with(|| failure_at(&first));
        self.settle(run, first.fraction);
        Onward::Nowhere
    }

    /// From the state `last` to the end of the ramp, where no singular point lies between; false, with the state as it was, where
    /// that is not possible.
    pub(super) fn reach_end(&mut self, run: &mut Run<'_>) -> bool {
        let here = self.system.snapshot();
        self.system.restore(&self.last);
        if let Some(found) = self.solve_at(run, 1.0) {
            let count = self.count(&found.inertia);
            if count.own <= self.base.own && count.lateral <= self.base.lateral {
                self.base = count;
                self.shift_states();
                self.accept(run.record, 1.0, found.residual);
                return true;
            }
        }
        self.system.restore(&here);
        false
    }

    /// The way on from a bifurcation, the present state; `None` where there is none.
    fn leave_bifurcation(
        &mut self,
        run: &mut Run<'_>,
        point: &CriticalPoint,
        ends: [f64; 2],
        (located, beyond): (bool, Count),
    ) -> Option<Onward> {
        // Increments by the fraction pass those without a potential, and note them: a search that finds one does the same.
        let passes = located && !point.sideways && !(self.base.potential && beyond.potential);
        if run.request.branch == Branch::Primary || passes {
            let last = ends[1] - ends[0];
            if ends[1] > 1.0 {
                return self.end_between(run, ends).then_some(Onward::From { at: 1.0, next: last, last: None });
            }
            self.system.restore(&self.next);
            run.ramp.apply(&mut self.system, ends[1]);
            self.base = beyond;
            self.shift_states();
            return Some(Onward::From { at: ends[1], next: (2.0 * last).max(self.tuning.bracket), last: Some(last) });
        }
        if point.sideways {
            return None;
        }
        let near = self.system.loading.fraction;
        let inside = self.gives_way_inside(run, ends, near);
        let by_joints = if inside { None } else { self.switch(run, point.fraction) };
        let at = by_joints.or_else(|| self.switch_inside(run, point, near))?;
        let residual = self.system.residual();
        self.accept(run.record, at, residual);
        let next = (4.0 * (at - point.fraction)).clamp(2.0 * self.tuning.shortest, 1.0);
        Some(Onward::From { at, next, last: None })
    }

    /// From a singular point to the next stable equilibrium, where the step asks for that; `None`, with the state at the point,
    /// where there is none.
    fn release_from(&mut self, run: &mut Run<'_>, point: &CriticalPoint) -> Option<Onward> {
        if run.request.method != Method::Jump || !self.base.potential || point.sideways {
            return None;
        }
        match self.release(run, point) {
            Release::Stable { fraction, jump } => {
                run.record.jumps.push(jump);
                if self.base.lateral > 0 {
                    let mut aside = [self.rough_point(CriticalKind::Bifurcation, (None, fraction), true)];
                    run.record.place(&mut aside);
                    run.record.critical_points.extend(aside);
                }
                self.system.save(&mut self.last);
                let residual = self.system.residual();
                self.accept(run.record, fraction, residual);
                return Some(Onward::From { at: fraction, next: 5.0 * self.tuning.bracket, last: None });
            }
            Release::Endless => run.record.failure = Some(Failure { cause: Cause::Unbounded, ..failure_at(point) }),
            Release::Lost => {}
        }
        self.back_to_last(run.ramp, point.fraction);
        None
    }

    /// To the end of the ramp, which lies between the states `last` and `next` at these fractions; false, with the state `last`, where
    /// it is not found there.
    fn end_between(&mut self, run: &mut Run<'_>, [from, to]: [f64; 2]) -> bool {
        self.system.restore(&self.next);
        let apart = self.system.distance(&self.last).largest();
        run.ramp.apply(&mut self.system, 1.0);
        self.system.predict(&self.last, &self.next, (1.0 - to) / (to - from));
        let found = self.solve_at(run, 1.0);
        let Some(found) = found.filter(|_| self.system.distance(&self.last).largest() <= apart) else {
            self.back_to_last(run.ramp, from);
            return false;
        };
        self.base = self.count(&found.inertia);
        self.system.save(&mut self.last);
        self.accept(run.record, 1.0, found.residual);
        true
    }

    /// How far (radians, or lengths) a state may be from one at a fraction that differs by so much, where both are beside a
    /// singular point: sixteen times as far as at the rate of the whole way so far.
    fn beside(&self, difference: f64) -> f64 {
        self.tuning.longer.powi(2) * difference.abs() * self.system.places.moved::<D>(self.system.size)
    }

    /// How far a state that is `beside` may be where the network is let back: it has moved next to nowhere in the end, and whether
    /// branches meet there says more.
    fn reach(&self, beside: f64) -> f64 {
        beside.max(self.tuning.near * self.moved_at_start.min(1.0))
    }

    /// From a limit point, the present state, to a stable equilibrium right beyond it, where there is one: two mirrored
    /// equilibria may meet in a symmetric one that stays, as those of a dyad do that its own muscles pull flat.
    fn touch(&mut self, run: &mut Run<'_>, point: &CriticalPoint) -> Option<Onward> {
        let fraction = point.fraction;
        if !self.base.potential || fraction >= 1.0 {
            return None;
        }
        self.system.save(&mut self.last);
        // What is far beyond a point depends on how far that is itself.
        let scale = fraction.clamp(self.tuning.near, 1.0);
        let beyond = self.tuning.beside() * scale;
        let at = (fraction + beyond).min(1.0);
        let beside = self.beside(beyond / fraction.max(self.tuning.near));
        run.ramp.apply(&mut self.system, at);
        let base = self.base;
        let mut found = self.flow(run, beside) == Some(true);
        let is_near = found;
        if !found && self.reach(beside) > beside {
            self.base = base;
            self.system.restore(&self.last);
            run.ramp.apply(&mut self.system, at);
            found = self.flow(run, self.reach(beside)) == Some(true);
        }
        self.system.remove_dashpots();
        let meets = found && at > fraction && self.base.negative() == base.negative();
        let met = if meets { self.meeting_at(run, [fraction, at], self.base) } else { None };
        if !found || met.is_none() && !is_near || self.base.lateral > base.lateral {
            self.base = base;
            self.back_to_last(run.ramp, fraction);
            return None;
        }
        self.system.save(&mut self.last);
        run.record.critical_points.retain(|noted| noted != point);
        note_meeting(run, met, fraction);
        let residual = self.system.residual();
        self.accept(run.record, at, residual);
        Some(Onward::From { at, next: self.tuning.bracket, last: None })
    }

    /// Whether a member has more negative pivots between its ends at `next` than at `last`, at these fractions; the state is as it
    /// was, at the fraction `at`.
    fn gives_way_inside(&mut self, run: &mut Run<'_>, ends: [f64; 2], at: f64) -> bool {
        let here = self.system.snapshot();
        let system = &mut self.system;
        let pivots = [(&self.last, ends[0]), (&self.next, ends[1])].map(|(state, fraction)| {
            system.restore(state);
            run.ramp.apply(system, fraction);
            system.gather(false);
            system.members.chains().map(|(pack, lane)| pack.interior(lane).negative).collect::<Vec<_>>()
        });
        self.system.restore(&here);
        run.ramp.apply(&mut self.system, at);
        self.system.assemble(false);
        pivots[1].iter().zip(&pivots[0]).any(|(far, near)| far > near)
    }

    /// The motion that nothing resists at a singular point, the present state; the factors are not those of increments then.
    ///
    /// The point was found with the auxiliary stiffness that this takes. With the larger one of increments the critical
    /// motion of an inextensible network may be stiffer there than other soft ones.
    pub(super) fn critical_motion(&mut self, run: &mut Run<'_>) -> Vec<f64> {
        let system = &mut self.system;
        if system.loading.holds_strains() {
            system.loading.set_auxiliary(packs::EXACTING);
            run.ramp.apply(system, system.loading.fraction);
            system.assemble(false);
            run.effort.factorizations += 1;
            system.loading.set_auxiliary(packs::AUXILIARY);
        }
        system.tangent.softest_motion(&system.pattern, system.size)
    }

    /// From a bifurcation, the present state, onto the branch that is stable and leads on; the fraction there, which is not beyond
    /// the end of the ramp.
    pub(super) fn switch(&mut self, run: &mut Run<'_>, fraction: f64) -> Option<f64> {
        if !self.base.potential {
            return None;
        }
        self.system.save(&mut self.last);
        let tuning = self.tuning;
        let mode = self.critical_motion(run);
        let motions = self.system.pattern.motions_of(&mode);
        let metric = Metric::balanced(&motions, 0.0, self.system.size, tuning.near);
        let direction = metric.unit(Direction { motions, rate: 0.0 });
        let n = metric.functional(&direction);
        let length = n.along(&self.system.pattern.motions_of(&mode), 0.0);
        let base = self.base;
        let point_at = |path: &mut Self, run: &mut Run<'_>, amplitude: f64| {
            let kick = |path: &mut Self, run: &Run<'_>, amplitude: f64| {
                path.back_to_last(run.ramp, fraction);
                let aside: Vec<f64> = mode.iter().map(|x| amplitude * x).collect();
                path.system.move_by(&aside, false).largest()
            };
            let moved = kick(path, run, amplitude);
            // What gives way may lie within members, whose joints hardly move: the farthest of all goes by the amplitude.
            let far = moved > tuning.longer * amplitude.abs();
            let amplitude = if far { amplitude * amplitude.abs() / moved } else { amplitude };
            if far {
                kick(path, run, amplitude);
            }
            let mut locator = path.locator(run.ramp);
            let found = locator.correct(&n, amplitude * length, fraction, fraction);
            run.effort.factorizations += locator.factorizations;
            let point = found.ok().filter(|point| point.fraction > fraction)?;
            let count = path.count(&point.inertia);
            (count.own <= base.own && count.lateral <= base.lateral).then_some((point.fraction, count))
        };
        self.enter(run, fraction, point_at)
    }

    /// Onto a branch that leaves the state `last`, a bifurcation at this fraction, and is stable and leads on; the fraction there.
    /// `point_at` finds it at an amplitude.
    pub(super) fn enter(
        &mut self,
        run: &mut Run<'_>,
        fraction: f64,
        mut point_at: impl FnMut(&mut Self, &mut Run<'_>, f64) -> Option<(f64, Count)>,
    ) -> Option<f64> {
        let tuning = self.tuning;
        // Where something else gives way soon after, as the other one of two struts, the branch is stable right beside the point alone.
        for factor in [1.0, 1.0 / tuning.longer, tuning.longer, tuning.longer.powi(-2)] {
            for sign in [1.0, -1.0] {
                let amplitude = sign * factor * tuning.amplitude;
                // A branch that first turns back is reached by a snap alone.
                if point_at(self, run, tuning.shorter * amplitude).is_some()
                    && let Some((at, count)) = point_at(self, run, amplitude)
                    && let Some((at, count)) = match at <= 1.0 {
                        true => Some((at, count)),
                        false => self.end_of_branch(run, fraction, (amplitude, at), &mut point_at),
                    }
                {
                    self.base = count;
                    self.system.save(&mut self.last);
                    return Some(at);
                }
            }
        }
        self.back_to_last(run.ramp, fraction);
        None
    }

    /// The end of the ramp on a branch that leaves the state `last` at this fraction, and was found beyond it at this amplitude and
    /// fraction; `point_at` finds it at another amplitude.
    ///
    /// So near to where it begins the stiffness grows from zero, and the fraction with the square of the amplitude: an iteration
    /// at a fraction comes from right beside.
    fn end_of_branch(
        &mut self,
        run: &mut Run<'_>,
        fraction: f64,
        mut far: (f64, f64),
        point_at: &mut impl FnMut(&mut Self, &mut Run<'_>, f64) -> Option<(f64, Count)>,
    ) -> Option<(f64, Count)> {
        let mut near = (0.0, fraction);
        for _ in 0..self.tuning.iterations {
            let part = (1.0 - near.1) / (far.1 - near.1);
            let square = near.0 * near.0 + part * (far.0 * far.0 - near.0 * near.0);
            let amplitude = square.sqrt().copysign(far.0);
            let (at, _) = point_at(self, run, amplitude)?;
            if (at - 1.0).abs() <= self.tuning.near * (1.0 - fraction) {
                let here = self.system.snapshot();
                let found = self.solve_at(run, 1.0)?;
                let moved = self.system.distance(&here).largest();
                let count = self.count(&found.inertia);
                let is_near = moved <= 2.0 * self.tuning.near * self.system.distance(&self.last).largest();
                let is_stable = count.own <= self.base.own && count.lateral <= self.base.lateral;
                return (is_near && is_stable).then_some((1.0, count));
            }
            *(if at > 1.0 { &mut far } else { &mut near }) = (amplitude, at);
        }
        None
    }

    /// Goes on where the ramp turns back without a change of stability, between `last` and `next`: along the branch that meets
    /// this one there, or nearer.
    pub(super) fn pass_where_branches_meet(
        &mut self,
        run: &mut Run<'_>,
        by: &mut ByArc,
        increment: &ArcIncrement,
    ) -> Next {
        let top = top_between(by, increment);
        let near = 2.0 * self.tuning.miss * (top.0 - by.fraction).abs();
        let shorter = self.tuning.shorter * increment.length;
        if !by.top.is_some_and(|known| (top.0 - known).abs() <= near) {
            // Seen from nearer it is the same place, or a leap onto another path.
            by.retry(shorter);
            by.top = Some(top.0);
            return Next::GoOn;
        }
        let other = match run.request.branch {
            Branch::Stable => self.rejoin(run, top, by.rate().signum(), increment.point.fraction),
            Branch::Primary => None,
        };
        let Some((at, met)) = other else {
            // Nothing to go on to: nearer before it is believed.
            by.retry(shorter);
            by.touches = false;
            return Next::GoOn;
        };
        note_meeting(run, met, top.0);
        let residual = self.system.residual();
        self.accept(run.record, at, residual);
        if let Some((mut fraction, ..)) = by.suspended.take() {
            let next = self.tuning.bracket * fraction.whole;
            fraction.begin_again(at, next, None);
            return Next::By(Control::Fraction(fraction));
        }
        match self.onward(run, by, at, at - top.0) {
            Some(onward) => Next::By(Control::Arc(Box::new(onward))),
            None => {
                let lost = self.no_direction();
                Next::End(self.end_lost(run, at, &lost))
            }
        }
    }

    /// From a branch that turns back where it meets another one, between `last` and `next`, onto that other one beyond; the
    /// fraction where the state is then. `top` is the fraction where they meet, and the part of the way there.
    ///
    /// Branches that buckle to either side are one curve, on which the fraction is greatest (or least) where it crosses
    /// the straight one: both of its sides are as stable as that is beyond. No eigenvalue changes its sign there, and
    /// the equations bordered along the curve are singular; beyond, those of the straight branch at a fixed fraction are not.
    fn rejoin(
        &mut self,
        run: &mut Run<'_>,
        (top, part): (f64, f64),
        ahead: f64,
        next: f64,
    ) -> Option<(f64, Option<Meeting>)> {
        let scale = top.abs().max(self.tuning.near);
        self.system.restore(&self.next);
        let apart = self.system.distance(&self.last).largest();
        // A branch that is stable is left for what lies ahead; from one that is not either side will do, if it is stable.
        let unstable = self.base.negative() > 0;
        let sides = [ahead, -ahead];
        let sides = &sides[..=usize::from(unstable)];
        let beyond = [1.0, self.tuning.longer].map(|times| times * self.tuning.beside());
        for (side, beyond) in sides.iter().flat_map(|side| beyond.map(|beyond| (side, beyond))) {
            let at = top + side * beyond * scale;
            let reach = apart + self.beside(beyond);
            let farther = Some(self.reach(reach)).filter(|farther| *farther > reach);
            // What lies near comes first: an iteration that leads farther away would hide it.
            for reached in [Some(reach), farther].into_iter().flatten() {
                self.system.restore(&self.next);
                let (base, ahead_of) = (self.base, self.next.clone());
                if !self.settles(run, at, part, reached) {
                    continue;
                }
                let meets = *side == ahead && self.base.negative() == base.negative() && self.base.potential;
                let met = if meets { self.meeting_at(run, [top, at], self.base) } else { None };
                if met.is_some() || self.system.distance(&self.last).largest() <= reach {
                    self.shift_states();
                    return Some((at, met));
                }
                (self.base, self.next) = (base, ahead_of);
            }
        }
        self.on_to_next(run.ramp, next);
        None
    }

    /// Brings what lies at a part of the way from `last` to `next` to a stable equilibrium at the fraction `at`, no farther than
    /// `reach` from `last`; false, with `next` as it was, where there is none.
    fn settles(&mut self, run: &mut Run<'_>, at: f64, part: f64, reach: f64) -> bool {
        let base = self.base;
        run.ramp.apply(&mut self.system, at);
        self.system.predict(&self.last, &self.next, part - 1.0);
        if let Some(found) = self.solve_at(run, at)
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
        let found = self.flow(run, reach);
        self.system.remove_dashpots();
        if found == Some(true) && self.base.lateral <= base.lateral {
            return true;
        }
        self.base = base;
        self.system.restore(&here);
        self.system.save(&mut self.next);
        false
    }
}

/// Notes where a branch meets another one: the point, where it was found, or else that there is one.
fn note_meeting(run: &mut Run<'_>, met: Option<Meeting>, fraction: f64) {
    match met {
        Some(Meeting { mut point, .. }) => {
            run.record.place(std::slice::from_mut(&mut point));
            run.record.critical_points.push(point);
        }
        None => run.record.notes.push(Note::TouchedSingular { fraction }),
    }
}

/// The fraction at which a path turns back in an increment, and the part of the way there: the top of the parabola that has the
/// slopes of both ends.
pub(super) fn top_between(by: &ByArc, increment: &ArcIncrement) -> (f64, f64) {
    let (rises, falls) = (by.rate(), increment.ahead.rate);
    let part = rises / (rises - falls);
    (by.fraction + 0.5 * rises * part * increment.length, part)
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
