//! What a path passes: changes of stability, and turns of the ramp.
//!
//! Theory: docs/theory/stability.md; docs/theory/continuation.md, Eq. 8.4.

use super::arc::{ArcIncrement, ByArc, Purpose};
use super::branch::{Onward, top_between};
use super::follow::{Control, Next, Run};
use super::locate::Interval;
use super::{Continuation, Count};
use crate::history::{CriticalKind, CriticalPoint, Increment, Note, StepHistory};
use crate::newton::{Lost, Why};
use crate::structure::Branch;
use crate::system::Inertia;
use pennate_elements::small::{norm, sub};

/// What lies between two states of a path.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Events {
    /// Count at the second.
    pub count: Count,
    /// Whether the fraction turned back.
    pub limit: bool,
    /// How many pivots of the network, and of motions out of its plane, changed their signs; without a potential, whether the
    /// determinant did.
    pub changed: usize,
    pub aside: usize,
    /// Whether loads have a potential at both.
    pub conservative: bool,
    /// The fraction turned back where two branches meet, and no pivot changed its sign.
    pub touched: bool,
}

impl Events {
    pub(super) fn any(&self) -> bool {
        self.number() > 0
    }

    /// Singular points at least.
    pub(super) fn number(&self) -> usize {
        (self.changed + self.aside).max(usize::from(self.limit))
    }

    /// Whether there is a bifurcation that the network's own count tells, besides a limit point.
    pub(super) fn bifurcates(&self) -> bool {
        self.changed > usize::from(self.limit)
    }

    pub(super) fn turns_back_alone(&self) -> bool {
        self.limit && self.changed == 0
    }
}

impl<const D: usize> Continuation<'_, D> {
    /// Counts pivots at the present state, before a step moves it.
    pub(super) fn start_count(&mut self, record: &mut StepHistory) {
        self.system.loading.fraction = 0.0;
        self.system.apply_drives();
        let inertia = self.at_rest.take().unwrap_or_else(|| self.system.assemble(false));
        record.factorizations += 1;
        self.first_answer = self.system.answer();
        self.base = self.count(&inertia);
    }

    pub(super) fn count(&mut self, inertia: &Inertia) -> Count {
        let known = self.base.lateral;
        let potential = self.system.tangent.has_potential();
        let mut count = Count {
            own: inertia.negative,
            lateral: 0,
            odd: inertia.is_odd(),
            potential,
            lateral_potential: true,
            lateral_stiffness: 0.0,
            smallest: inertia.smallest,
            neutral: inertia.neutral > 0,
        };
        if count.own > self.base.own {
            let certain = self.system.certain_negative().max(self.base.own);
            #[cfg(feature = "trace")]
            eprintln!(
                "{} negative, {certain} certain, softest {:e}",
                count.own,
                self.system.tangent.softest_stiffness(&self.system.pattern, self.system.size)
            );
            count.neutral |= certain < count.own;
            count.own = count.own.min(certain);
        }
        if let Some(lateral) = &mut self.lateral {
            let (inertia, potential) = lateral.confirmed(&mut self.system, known);
            count.lateral = inertia.negative;
            count.lateral_potential = potential;
            count.lateral_stiffness = lateral.overall_stiffness().unwrap_or(0.0);
            self.stiffest_aside = self.stiffest_aside.max(count.lateral_stiffness);
            count.neutral |= inertia.neutral > 0;
        }
        count
    }

    /// What lies between the last state and one with this count, by the arc between them.
    pub(super) fn events_at(&self, count: &Count, turns_back: bool) -> Events {
        let base = &self.base;
        let conservative = count.potential && base.potential;
        let changed = if conservative {
            count.own.abs_diff(base.own)
        } else {
            usize::from(count.odd != base.odd && count.potential == base.potential)
        };
        let aside = if count.lateral_potential { count.lateral.abs_diff(base.lateral) } else { 0 };
        Events { count: *count, limit: turns_back, changed, aside, conservative, touched: false }
    }

    /// Whether all pivots that change their signs between the state `last` and the present one, at these fractions, do so at one
    /// place, as those of equal parts of a network do: within this part of the way. `negative` are their numbers at both.
    ///
    /// Shorter increments would not separate them, and lead to where every tangent is singular. The states in between are
    /// interpolated, which keeps what is equal.
    pub(super) fn are_together(
        &mut self,
        run: &mut Run<'_>,
        [from, to]: [f64; 2],
        negative: [usize; 2],
        part: f64,
    ) -> bool {
        let [near, far] = negative;
        self.system.save(&mut self.next);
        let mut bracket = [0.0, 1.0];
        let mut together = true;
        while together && bracket[1] - bracket[0] > part {
            let middle = 0.5 * (bracket[0] + bracket[1]);
            run.ramp.apply(&mut self.system, from + middle * (to - from));
            self.system.predict(&self.last, &self.next, middle - 1.0);
            run.effort.factorizations += 1;
            let negative = self.system.assemble(false).negative;
            if negative == far {
                bracket[1] = middle;
            } else {
                bracket[0] = middle;
                together = negative == near;
            }
        }
        self.on_to_next(run.ramp, to);
        run.effort.factorizations += 1;
        together
    }

    /// Singular points that the present state has passed since the last one, at these fractions; `None` where stability is as it
    /// was.
    pub(super) fn locate_changes(
        &mut self,
        run: &mut Run<'_>,
        count: &Count,
        ends: [f64; 2],
    ) -> Option<Vec<CriticalPoint>> {
        let mut events = self.events_at(count, false);
        if !self.base.lateral_potential {
            events.aside = 0;
        }
        events.any().then(|| {
            self.system.save(&mut self.next);
            let points = self.pinpoint(run, Interval { ends, metric: None, events: &events });
            self.on_to_next(run.ramp, ends[1]);
            points
        })
    }

    /// Notes what the present state has passed since the last one, at these fractions.
    pub(super) fn note_changes(
        &mut self,
        record: &mut StepHistory,
        count: &Count,
        [from, fraction]: [f64; 2],
        passed: Option<Vec<CriticalPoint>>,
    ) {
        if let Some(mut points) = passed {
            if points.is_empty() {
                let sideways = count.lateral != self.base.lateral && count.own == self.base.own;
                points.push(self.rough_point(CriticalKind::Bifurcation, (Some(from), fraction), sideways));
            }
            record.place(&mut points);
            record.critical_points.append(&mut points);
        }
        if count.neutral && !self.base.neutral {
            record.notes.push(Note::TouchedSingular { fraction });
        }
    }

    /// Locates what an increment along the arc passed, from `last` to `next`, and does what is due there; `None` where the arc
    /// goes on from `next`, which is the present state then.
    pub(super) fn pass_events(&mut self, run: &mut Run<'_>, by: &mut ByArc, increment: &ArcIncrement) -> Option<Next> {
        let events = &increment.events;
        let ends = [by.fraction, increment.point.fraction];
        let mut points = self.pinpoint(run, Interval { ends, metric: Some(by.metric), events });
        if points.is_empty() && by.again + 1 < self.tuning.few() {
            // A singular point that is not found lies on another path, where the increment leapt.
            by.again += 1;
            by.retry(self.tuning.shorter * increment.length);
            by.longest = by.next;
            return Some(Next::GoOn);
        }
        let stops = match by.purpose {
            Purpose::Search => true,
            Purpose::Jump => self.is_lost(events),
            Purpose::Whole => false,
        };
        let found = !points.is_empty();
        if !found {
            points.push(self.point_between(run, by, increment));
        }
        run.record.place(&mut points);
        if stops {
            return Some(self.stop_or_go_on(run, by, (points, found), ends, events));
        }
        if found && points[0].fraction > 1.0 && ends[0] < 1.0 && self.reach_end(run) {
            return Some(Next::End(self.arrived(run)));
        }
        run.record.critical_points.extend(points.iter().cloned());
        if found {
            let residual = self.system.residual();
            self.accept(run.record, self.system.loading.fraction, residual);
            let is_fold = matches!(points.as_slice(), [point] if point.kind == CriticalKind::LimitPoint);
            if is_fold && self.closes_a_loop(run.record) {
                let residual = self.system.residual();
                let lost = Lost { iterations: 0, factorizations: 0, residual, why: Why::Long };
                return Some(Next::End(self.end_lost(run, self.system.loading.fraction, &lost)));
            }
        }
        let is_left = |point: &&CriticalPoint| {
            let bifurcation = point.kind == CriticalKind::Bifurcation && !point.sideways;
            bifurcation && run.request.branch == Branch::Stable && self.base.own == 0
        };
        if let [point] = points.as_slice()
            && let Some(from) = Some(point).filter(is_left).map(|point| point.fraction)
            && let near = self.system.loading.fraction
            && let Some(at) = self.switch(run, from).or_else(|| self.switch_inside(run, point, near))
            && let Some(onward) = self.onward(run, by, at, (at - from).abs())
        {
            self.accept(run.record, at, Default::default());
            return Some(Next::By(Control::Arc(Box::new(onward))));
        }
        self.on_to_next(run.ramp, ends[1]);
        None
    }

    /// Whether the last state of a record, a limit point, is one that the path came through long before: it goes round in a loop.
    fn closes_a_loop(&self, record: &StepHistory) -> bool {
        let Some((last, before)) = record.increments.split_last() else { return false };
        let size = self.system.size;
        let is_last = |increment: &Increment| {
            let nodes = increment.state.nodes.iter().zip(&last.state.nodes);
            let mut apart = nodes.map(|(a, b)| norm(sub(a.displacement, b.displacement)));
            (increment.fraction - last.fraction).abs() <= self.tuning.tolerance()
                && apart.all(|apart| apart <= self.tuning.shortest * size)
        };
        before.iter().rev().skip(self.tuning.iterations).any(is_last)
    }

    /// What an increment along the arc passed, from `last` to `next`, where it could not be located: as far as its ends tell. The
    /// state is the second then.
    fn point_between(&mut self, run: &mut Run<'_>, by: &ByArc, increment: &ArcIncrement) -> CriticalPoint {
        let (events, ends) = (&increment.events, [by.fraction, increment.point.fraction]);
        self.on_to_next(run.ramp, ends[1]);
        if !events.limit {
            return self.rough_point(
                CriticalKind::Bifurcation,
                (Some(ends[0]), ends[1]),
                events.aside > 0 && !events.bifurcates(),
            );
        }
        // A ramp that turns back has gone farther than both ends.
        let (top, _) = top_between(by, increment);
        let far = if (top - ends[0]).abs() > (top - ends[1]).abs() { ends[0] } else { ends[1] };
        self.rough_point(CriticalKind::LimitPoint, (Some(far), top), false)
    }

    /// Whether stability is lost where these are passed, or the ramp turns back.
    fn is_lost(&self, events: &Events) -> bool {
        let count = &events.count;
        let aside = count.lateral > self.base.lateral && count.lateral_potential;
        events.limit || count.own > self.base.own || aside
    }

    /// Ends a ramp where its stability is lost, between `last` and `next` at these fractions, or goes on from there.
    fn stop_or_go_on(
        &mut self,
        run: &mut Run<'_>,
        by: &mut ByArc,
        (points, found): (Vec<CriticalPoint>, bool),
        ends: [f64; 2],
        events: &Events,
    ) -> Next {
        let beyond = points.first().filter(|point| point.fraction > 1.0).map(|point| point.fraction);
        if let Some(beyond) = beyond {
            if self.reach_end(run) {
                return Next::End(self.arrived(run));
            }
            run.ramp.apply(&mut self.system, beyond);
            self.system.assemble(false);
        }
        match self.meet(run, (points, found), ends, events) {
            Onward::Nowhere => Next::End(false),
            Onward::From { at, .. } if at >= 1.0 => Next::End(self.arrived(run)),
            Onward::From { at, next, last } => match by.suspended.take() {
                Some((mut fraction, ..)) => {
                    fraction.begin_again(at, next, last);
                    Next::By(Control::Fraction(fraction))
                }
                None => {
                    let reach = 2.0 * self.tuning.miss * at.abs().max(self.tuning.near);
                    let onward = self.onward(run, by, at, reach);
                    Next::By(match onward {
                        Some(mut onward) => {
                            onward.lengthen();
                            Control::Arc(Box::new(onward))
                        }
                        None => Control::Fraction(self.by_fraction(run, at)),
                    })
                }
            },
        }
    }
}
