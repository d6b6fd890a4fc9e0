//! Increments by the arclength of a path: past limit points, through bifurcations, and onto singular points.
//!
//! The length of the arc is indifferent to how much of the ramp an event takes: a snap at a thousandth of the ramp is met like
//! one at its end, and two that are near each other are met one after the other.
//!
//! Theory: docs/theory/continuation.md, Eq. 8.2, 8.3 and 8.5.

use super::direction::{Direction, Metric};
use super::distance::{Locator, Point};
use super::events::Events;
use super::follow::{Control, Next, Run, Tried};
use super::fraction::ByFraction;
use super::locate::Value;
use super::ramp::Ramp;
use super::record::Ending;
use super::touching::Between;
use super::{Continuation, Count, Tuning};
use crate::history::{CriticalPoint, Status};
use crate::newton::{Lost, Why};
use crate::structure::Stop;
use crate::system::{Answer, Residual, System};

/// What a path is followed along its arc for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// To the end of the ramp, whatever is passed.
    Whole,
    /// From each loss of stability to the next stable equilibrium.
    Jump,
    /// For what stopped a ramp that is followed by its fraction.
    Search,
}

/// Where a path is, and how far its next increment goes.
pub(super) struct ByArc {
    pub purpose: Purpose,
    pub fraction: f64,
    /// Fraction of the state before the last one.
    before: f64,
    /// Unit tangent at the last state, forward.
    pub tangent: Direction,
    pub metric: Metric,
    /// Next increment of the arc, the last one, and the first.
    pub next: f64,
    last: Option<f64>,
    first: f64,
    /// The longest increment for now, and that which is asked for: a part of the ramp, or the same part of what lies behind, since a
    /// path that turns back is longer than its ramp was expected to be.
    pub longest: f64,
    longest_asked: f64,
    part_asked: f64,
    behind: f64,
    /// Length that the next increment was tried with first, and how many others were tried for a state too near to a singular one.
    begun: Option<f64>,
    others: usize,
    /// Whether a path that turns back without a change of stability is handed over at once: it may touch another one there.
    pub touches: bool,
    /// The fraction where it seemed to turn back when that was last seen.
    pub top: Option<f64>,
    /// Negative pivots at the last state, those of motions that pass for neutral among them.
    negative: usize,
    /// What passes zero at a singular tangent, at the last state and at the one before it, where that is known.
    tests: [Option<f64>; 2],
    /// How the network answers at the last state, where that is known.
    answer: Option<Answer>,
    /// How often an increment was made again because no singular point was found between its ends.
    pub again: usize,
    /// Increments that are left.
    left: usize,
    /// The increments by the fraction that the search interrupted, the count there, and how they end if it finds nothing; they go on
    /// where nothing has stopped them.
    pub suspended: Option<(ByFraction, Count, Option<Ending>)>,
}

/// An increment along the arc that was accepted.
pub(super) struct ArcIncrement {
    pub length: f64,
    pub point: Point,
    pub events: Events,
    /// Whether singular points on the way are counted alone.
    counted: bool,
    /// Unit tangent at its end, forward.
    pub ahead: Direction,
    /// How the network answers there.
    answer: Option<Answer>,
    /// The fraction at which the path touched another one, if it did.
    meets: Option<f64>,
}

impl ByArc {
    /// How fast the fraction grows along the arc.
    pub(crate) fn rate(&self) -> f64 {
        self.tangent.rate
    }

    /// Forgets that increments were made shorter.
    pub(super) fn lengthen(&mut self) {
        self.longest = self.longest_asked;
    }

    /// Makes the last increment again, of this length.
    pub(super) fn retry(&mut self, length: f64) {
        self.next = length;
        self.begun = None;
    }

    fn advance(&mut self, increment: ArcIncrement, tuning: &Tuning) {
        let ArcIncrement { length, point, ahead, answer, .. } = increment;
        self.next = tuning.next_length(length, point.iterations, None);
        self.last = Some(length);
        self.before = self.fraction;
        self.fraction = point.fraction;
        self.tangent = ahead;
        self.tests = [answer.as_ref().map(|answer| answer.test), self.tests[0]];
        self.answer = answer;
        self.negative = point.inertia.negative;
        self.begun = None;
        self.again = 0;
        self.touches = true;
        self.behind += length;
        self.longest_asked = self.longest_asked.max(self.part_asked * self.behind);
        self.longest = (tuning.longer.sqrt() * self.longest).min(self.longest_asked);
    }

    /// Whether the tangent seems to be nearly singular between the last state and one at the distance `s`, and is not at either:
    /// two branches come near each other there, and an increment that is longer than their distance changes over.
    ///
    /// What passes zero at a singular tangent goes with a parabola through its last three values.
    fn nears_a_singular_tangent(&self, s: f64, test: Option<f64>, tuning: &Tuning) -> bool {
        let ([Some(here), Some(before)], Some(ahead), Some(last)) = (self.tests, test, self.last) else { return false };
        if here * before <= 0.0 || here * ahead <= 0.0 {
            return false;
        }
        let slopes = [(here - before) / last, (ahead - here) / s];
        let curvature = (slopes[1] - slopes[0]) / (last + s);
        let slope = slopes[1] - curvature * s;
        let place = -0.5 * slope / curvature;
        let extreme = here + 0.5 * slope * place;
        0.0 < place && place < s && extreme / here < tuning.contraction * (ahead / here).min(1.0)
    }

    /// Shortens an increment whose end is not to be believed. One that would be too short comes too near to a singular
    /// tangent: other lengths, that lead past it, are tried first.
    fn shorten(&mut self, length: f64, tuning: &Tuning) {
        let shorter = tuning.shorter * length;
        let short = tuning.beside() * self.first;
        let others = [1.0 / tuning.shorter, tuning.missed];
        if shorter <= short && length > short && self.others < others.len() {
            self.next = others[self.others] * self.begun.unwrap_or(length);
            self.others += 1;
        } else {
            self.next = shorter;
        }
    }
}

impl<const D: usize> Continuation<'_, D> {
    pub(super) fn locator<'b>(&'b mut self, ramp: &'b Ramp) -> Locator<'b, D> {
        let Self { system, last, next, newton, .. } = self;
        Locator { system, last, next, newton: *newton, ramp, factorizations: 0 }
    }

    /// Begins along the arc, at the first state of a ramp.
    pub(super) fn first_arc(&mut self, run: &mut Run<'_>, purpose: Purpose) -> Option<ByArc> {
        let most = if purpose == Purpose::Jump { self.tuning.near } else { self.tuning.miss };
        let reach = self.options.first_increment.min(run.longest).min(most);
        let mut by = self.arc_from_last(run, 0.0, reach, purpose)?;
        if run.longest < 1.0 {
            by.part_asked = run.longest;
            by.longest_asked = by.part_asked / reach * by.next;
            by.longest = by.longest_asked;
        }
        if let Some(Stop::Increments(count)) = run.request.stop {
            by.left = count;
        }
        Some(by)
    }

    /// Begins along the arc at the last saved state, towards larger fractions; `None` where the path has no direction there.
    ///
    /// `reach` is the part of the ramp that the first increment is to make.
    pub(super) fn arc_from_last(
        &mut self,
        run: &mut Run<'_>,
        fraction: f64,
        reach: f64,
        purpose: Purpose,
    ) -> Option<ByArc> {
        self.system.restore(&self.last);
        let mut locator = self.locator(run.ramp);
        let rate = locator.rate(fraction);
        run.effort.factorizations += locator.factorizations;
        let rate = rate?;
        let metric = Metric::balanced(&rate, 1.0, self.system.size, self.tuning.near);
        let tangent = Direction { motions: rate, rate: 1.0 };
        let first = reach * metric.inner(&tangent, &tangent).sqrt();
        let left = match purpose {
            Purpose::Search => 5 * self.tuning.iterations,
            // Half as many as the shortest ones that a ramp has.
            Purpose::Whole | Purpose::Jump => (0.5 / self.tuning.shortest) as usize,
        };
        Some(ByArc {
            purpose,
            fraction,
            before: fraction,
            tangent: metric.unit(tangent),
            metric,
            next: first,
            last: None,
            first,
            longest: f64::INFINITY,
            longest_asked: f64::INFINITY,
            part_asked: 1.0,
            behind: 0.0,
            begun: None,
            others: 0,
            touches: true,
            top: None,
            negative: self.system.tangent.inertia().negative,
            tests: [None; 2],
            answer: None,
            again: 0,
            left,
            suspended: None,
        })
    }

    /// Goes on along the arc from the last saved state, at the fraction `at`, the way that leads from before to there.
    pub(super) fn onward(&mut self, run: &mut Run<'_>, by: &ByArc, at: f64, reach: f64) -> Option<ByArc> {
        let mut onward = self.arc_from_last(run, at, reach.abs(), by.purpose)?;
        if reach < 0.0 {
            onward.tangent.reverse();
        }
        (onward.longest, onward.longest_asked) = (by.longest, by.longest_asked);
        (onward.part_asked, onward.behind) = (by.part_asked, by.behind);
        (onward.touches, onward.left) = (by.touches, by.left);
        Some(onward)
    }

    /// Tries the next increment along the arc: the state is at its end then, and not saved yet.
    ///
    /// An increment that passes more than one singular point is shortened as long as that separates them.
    pub(super) fn increment_by_arc(&mut self, run: &mut Run<'_>, by: &mut ByArc) -> Tried<ArcIncrement, Lost> {
        let away = by.fraction < -self.tuning.endless;
        if away || by.left == 0 {
            let (residual, why) = (self.system.residual(), if away { Why::Away } else { Why::Long });
            return Tried::Lost(Lost { iterations: 0, factorizations: 0, residual, why });
        }
        let s = by.next.min(by.longest);
        if by.begun.is_none() {
            (by.begun, by.others) = (Some(s), 0);
        }
        let point = match self.correct_by_arc(run, by, s) {
            Ok(point) => point,
            Err(lost) => {
                self.system.restore(&self.last);
                if self.system.is_stopped() {
                    return Tried::Interrupted;
                }
                by.shorten(s, &self.tuning);
                // What is held at both ends is so in shorter increments too.
                let overheld = matches!(lost.why, Why::Overheld(_));
                let least = if overheld { self.tuning.beside() } else { self.tuning.increment };
                return if by.next < least * by.first { Tried::Lost(lost) } else { Tried::Again };
            }
        };
        match self.assess_by_arc(run, by, s, point) {
            Some(increment) => {
                by.left -= 1;
                Tried::Accepted(increment)
            }
            None => Tried::Again,
        }
    }

    /// Iterates to the point at the distance `s` along the arc, from the extrapolation of the last two states where there are two.
    fn correct_by_arc(&mut self, run: &mut Run<'_>, by: &ByArc, s: f64) -> Result<Point, Lost> {
        let n = by.metric.functional(&by.tangent);
        let mut guess = by.fraction;
        self.system.restore(&self.last);
        if let Some(last) = by.last {
            guess += (by.fraction - by.before) * s / last;
            run.ramp.apply(&mut self.system, guess);
            self.system.predict(&self.before, &self.last, s / last);
        } else {
            guess += s * by.tangent.rate;
        }
        let mut locator = self.locator(run.ramp);
        let found = locator.correct(&n, s, by.fraction, guess);
        let spent = locator.factorizations;
        run.effort.factorizations += spent;
        run.effort.iterations += spent;
        found
    }

    /// Whether a point is the next one of its path, and what lies between; where it is not, the increment is shorter now.
    fn assess_by_arc(&mut self, run: &mut Run<'_>, by: &mut ByArc, s: f64, point: Point) -> Option<ArcIncrement> {
        let tuning = self.tuning;
        let short = s <= tuning.beside() * by.first;
        let mut ahead = by.metric.unit(Direction { motions: point.rate.clone(), rate: 1.0 });
        if by.metric.inner(&ahead, &by.tangent) < 0.0 {
            ahead.reverse();
        }
        let chord = Direction { motions: self.system.seen_since(&self.last), rate: point.fraction - by.fraction };
        let tangents = [&by.tangent, &ahead];
        // States that are one lie on one path, whatever the tangents and the number of iterations say: those of members that cannot
        // be stretched give way a little, as the auxiliary stiffness does, and near a bifurcation that sways a frame which in truth
        // does not move.
        let one = self.system.distance(&self.last).largest() <= tuning.shortest;
        if !short && !one && !by.metric.bends_evenly(&chord, tangents, &tuning) {
            by.next = tuning.shorter * s;
            return None;
        }
        let aside = !by.metric.is_chord(&chord, tangents, &tuning);
        let bent = by.metric.inner(&ahead, &by.tangent) < tuning.straight;
        let shortest = tuning.increment * by.first;
        if !one && (aside && s > shortest || (bent || point.iterations > tuning.many) && !short) {
            by.shorten(s, &tuning);
            return None;
        }
        let count = self.count(&point.inertia);
        // A singular state has no tangent of its own: rounding says where a path that goes on from there leads.
        if count.neutral && !self.base.neutral && s > shortest {
            by.shorten(s, &tuning);
            return None;
        }
        let turns_back = ahead.rate * by.tangent.rate < 0.0;
        let mut events = self.events_at(&count, turns_back);
        let counted = !turns_back && self.only_counts(run, &count);
        // At a fold a pivot changes its sign, though it may be small enough to pass for neutral.
        let same = point.inertia.negative == by.negative;
        let touched = events.turns_back_alone() && events.aside == 0 && by.touches && same;
        let together = |path: &mut Self, run: &mut Run<'_>| {
            let ends = [by.fraction, point.fraction];
            let part = tuning.beside() * by.first / s;
            events.conservative
                && events.aside == 0
                && path.are_together(run, ends, [by.negative, point.inertia.negative], part)
        };
        if !short && !touched && (events.turns_back_alone() || events.number() > 1 && !counted && !together(self, run))
        {
            by.next = tuning.shorter * s;
            return None;
        }
        let far = s > tuning.bracket * (by.behind + s);
        if far
            && !one
            && !touched
            && !counted
            && events.conservative
            && events.bifurcates()
            && self.leans(&by.metric, &ahead)
        {
            by.next = tuning.shorter * s;
            return None;
        }
        let answer = self.system.answer();
        let test = answer.as_ref().map(|answer| answer.test);
        let hidden = || turns_twice(by, &chord, &ahead) || by.nears_a_singular_tangent(s, test, &tuning);
        if !short && !touched && !turns_back && hidden() {
            by.next = tuning.shorter * s;
            return None;
        }
        events.touched = touched;
        let ends = [by.fraction, point.fraction];
        let between = if events.any() { Between::Nothing } else { self.seen_between(run, ends, [&by.answer, &answer]) };
        let meets = match between {
            Between::Nothing | Between::Turned => None,
            Between::Leapt(_) if !short => {
                by.next = tuning.shorter * s;
                return None;
            }
            Between::Touched(fraction) | Between::Leapt(fraction) => Some(fraction),
        };
        Some(ArcIncrement { length: s, point, events, counted, ahead, answer, meets })
    }

    /// Whether a path, with this tangent at the present state, moves along the softest motion too.
    ///
    /// The one that is lost at a bifurcation is at right angles to a path that goes on there. Where it is not the path may turn aside
    /// just before the point, which then lies on another one that comes near it: it is only believed from right beside.
    fn leans(&mut self, metric: &Metric, ahead: &Direction) -> bool {
        let mode = self.system.tangent.softest_motion(&self.system.pattern, self.system.size);
        let aside = metric.unit(Direction { motions: self.system.pattern.motions_of(&mode), rate: 0.0 });
        metric.inner(&aside, ahead).abs() > self.tuning.rounding.sqrt()
    }

    /// Takes an increment that was accepted, and does what is due at what it passed.
    pub(super) fn advance_by_arc(&mut self, run: &mut Run<'_>, by: &mut ByArc, increment: ArcIncrement) -> Next {
        self.system.save(&mut self.next);
        let ends = [by.fraction, increment.point.fraction];
        if increment.events.touched {
            return self.pass_where_branches_meet(run, by, &increment);
        }
        let passes = increment.events.any()
            && !increment.counted
            && !(by.purpose == Purpose::Whole && self.ends_before_events(run, by, ends));
        if passes && let Some(next) = self.pass_events(run, by, &increment) {
            return next;
        }
        if by.purpose != Purpose::Search
            && let Some(end) = self.arrive(run, by, (ends, increment.counted))
        {
            return end;
        }
        if by.purpose == Purpose::Search && ends[1] >= 1.0 {
            return match self.reach_end(run) {
                true => Next::End(self.arrived(run)),
                false => self.end_search(run, by),
            };
        }
        let residual = increment.point.residual;
        if let Some(fraction) = increment.meets.filter(|_| by.purpose != Purpose::Search) {
            self.note_touched(run, fraction);
        }
        if increment.counted {
            self.note_counted(run.record, &increment.events.count, ends, 0);
        }
        self.base = increment.events.count;
        self.shift_states();
        by.advance(increment, &self.tuning);
        if by.purpose == Purpose::Search {
            return Self::go_on_searching(by, &self.tuning);
        }
        let stops = by.left == 0 && matches!(run.request.stop, Some(Stop::Increments(_)));
        let residual = if stops { self.sharpen(run, by.fraction).unwrap_or(residual) } else { residual };
        self.accept(run.record, by.fraction, residual);
        if !(run.watch)(by.fraction.clamp(0.0, 1.0)) {
            return Next::End(self.interrupted(run, by.fraction));
        }
        if stops {
            self.stay(by.fraction);
            run.record.status = Status::Converged;
            self.settle(run, by.fraction);
            return Next::End(true);
        }
        Next::GoOn
    }

    /// Iterates the last state, which was only to be passed, until it is a result, and gives its residual; `None`, with the state as it
    /// was, where no equilibrium lies so near at this fraction, as beside a limit point.
    fn sharpen(&mut self, run: &mut Run<'_>, fraction: f64) -> Option<Residual> {
        let found = self.solve_at(run, fraction);
        let is_same = self.system.distance(&self.last).largest() <= self.tuning.shortest;
        let Some(found) = found.filter(|_| is_same) else {
            self.back_to_last(run.ramp, fraction);
            return None;
        };
        self.system.save(&mut self.last);
        Some(found.residual)
    }

    /// Goes on by the fraction again where a search got far beyond what it was for: what looked like a loss of stability was
    /// a longer increment onto another branch.
    fn go_on_searching(by: &mut ByArc, tuning: &Tuning) -> Next {
        let far = by.suspended.as_ref().is_some_and(|s| by.fraction > s.0.fraction + 3.0 * tuning.bracket * s.0.whole);
        let Some((mut fraction, ..)) = by.suspended.take_if(|_| far) else { return Next::GoOn };
        let last = by.fraction - by.before;
        fraction.begin_again(by.fraction, 2.0 * last, Some(last));
        Next::By(Control::Fraction(fraction))
    }

    /// Leaves an arc that cannot be followed any further.
    pub(super) fn leave_arc(&mut self, run: &mut Run<'_>, by: &mut ByArc, lost: Lost) -> Next {
        self.system.restore(&self.last);
        match by.purpose {
            Purpose::Whole => Next::End(self.end_lost(run, by.fraction, &lost)),
            // Where the arc cannot be followed the ramp may be.
            Purpose::Jump if by.left > 0 && lost.why != Why::Away => {
                Next::By(Control::Fraction(self.by_fraction(run, by.fraction)))
            }
            Purpose::Jump => Next::End(self.end_lost(run, by.fraction, &lost)),
            Purpose::Search => {
                if let (Why::Overheld(_), Some((.., Some(ending)))) = (lost.why, &mut by.suspended) {
                    // What changed signs on the way was the force of this member, which grows without end.
                    *ending = self.ending_of([ending.failure.tried; 2], &lost, false);
                }
                self.end_search(run, by)
            }
        }
    }

    /// Ends a ramp whose search found nothing: the state that it began at is what is sure.
    fn end_search(&mut self, run: &mut Run<'_>, by: &mut ByArc) -> Next {
        let Some((mut fraction, count, ending)) = by.suspended.take() else { return Next::GoOn };
        let Some(ending) = ending else {
            // No fold can be told where one was foretold: on from where the arc led to.
            self.system.restore(&self.last);
            let onward = by.fraction - by.before;
            if by.last.is_some() {
                let next = onward.max(self.tuning.shortest * fraction.whole);
                fraction.begin_again(by.fraction, next, (onward > 0.0).then_some(onward));
            }
            return Next::By(Control::Fraction(fraction));
        };
        Next::End(self.end_short(run, fraction.fraction, count, ending))
    }

    /// Ends a ramp at the last state.
    pub(super) fn end_short(&mut self, run: &mut Run<'_>, fraction: f64, count: Count, ending: Ending) -> bool {
        self.base = count;
        let mut points: Vec<CriticalPoint> = ending.point.into_iter().collect();
        run.record.place(&mut points);
        run.record.critical_points.append(&mut points);
        run.record.status = ending.status;
        run.record.failure = Some(ending.failure);
        self.system.restore(&self.last);
        run.ramp.apply(&mut self.system, fraction);
        self.settle(run, fraction);
        false
    }

    /// Whether a path reaches its end or its stop between `last` and `next`, at these fractions, before stability changes; the
    /// state is `next`.
    fn ends_before_events(&mut self, run: &mut Run<'_>, by: &ByArc, ends: [f64; 2]) -> bool {
        let Some((_, count)) = self.find_end(run, by, ends) else { return false };
        let passes = self.events_at(&count, false).any();
        self.on_to_next(run.ramp, ends[1]);
        !passes
    }

    /// Ends a path between `last` and `next`, at these fractions, if it reaches its end or its stop there.
    fn arrive(&mut self, run: &mut Run<'_>, by: &ByArc, (ends, counted): ([f64; 2], bool)) -> Option<Next> {
        let (fraction, count) = self.find_end(run, by, ends)?;
        if counted {
            self.note_counted(run.record, &count, [ends[0], fraction], 0);
        }
        self.base = count;
        self.shift_states();
        let residual = self.system.residual();
        self.stay(fraction);
        self.accept(run.record, fraction, residual);
        run.record.status = Status::Converged;
        self.settle(run, fraction);
        Some(Next::End(true))
    }

    /// What was on its way to the end of the ramp stays where it is.
    fn stay(&mut self, fraction: f64) {
        for held in self.held.values_mut() {
            held.to = held.at(fraction);
        }
    }

    /// Where the path between `last` and `next` reaches its end, and the count there: the state is there then.
    fn find_end(&mut self, run: &mut Run<'_>, by: &ByArc, ends: [f64; 2]) -> Option<(f64, Count)> {
        let crosses = |value: f64| (ends[0] - value) * (ends[1] - value) <= 0.0 && ends[0] != value;
        let target = match run.request.stop {
            Some(Stop::Fraction(value)) if crosses(value) => Some(value),
            _ => (ends[1] >= 1.0).then_some(1.0),
        };
        if let Some(Stop::At { node, component, value }) = run.request.stop {
            let link = self.system.topology.links[node];
            let read = |system: &System<D>| system.places.component::<D>(&link, component) - value;
            self.system.restore(&self.last);
            let begin = read(&self.system);
            self.system.restore(&self.next);
            if begin != 0.0 && begin * read(&self.system) <= 0.0 {
                let mut locator = self.locator(run.ramp);
                let found = locator.root(ends, Some(by.metric), Value::Smooth, &mut |system, _| {
                    let now = read(system);
                    (now * begin > 0.0, Some(now))
                });
                run.effort.factorizations += locator.factorizations;
                // Beyond the end of the ramp that comes first.
                if let Some(root) = found.filter(|root| target.is_none() || root.fraction <= 1.0) {
                    return Some((root.fraction, self.count(&root.point.inertia)));
                }
                self.on_to_next(run.ramp, ends[1]);
            }
        }
        let target = target?;
        let s = (target - ends[0]) / (ends[1] - ends[0]);
        run.ramp.apply(&mut self.system, target);
        self.system.predict(&self.last, &self.next, s - 1.0);
        match self.solve_at(run, target) {
            Some(found) => Some((target, self.count(&found.inertia))),
            None => {
                self.system.restore(&self.next);
                None
            }
        }
    }
}

/// Whether the ramp turns back twice between the last state and one at the end of a chord, by the cubic that has the tangents of
/// both.
fn turns_twice(by: &ByArc, chord: &Direction, ahead: &Direction) -> bool {
    let mean = chord.rate / by.metric.inner(chord, chord).sqrt();
    let [first, second] = [by.tangent.rate, ahead.rate];
    // The slope is first + 2 t linear + t² square.
    let linear = 3.0 * mean - 2.0 * first - second;
    let square = 3.0 * (first + second - 2.0 * mean);
    let place = -linear / square;
    first * second > 0.0 && 0.0 < place && place < 1.0 && first * (first + linear * place) < 0.0
}
