//! Along a path by its arclength: increments that adapt, and what they pass.
//!
//! Theory: docs/theory/continuation.md, Eq. 8.5 and 8.6.

use super::arc::{BEHIND, Direction, Metric, Point, Tracer};
use super::doubt::{MANY, SAME};
use super::follow::{Ramp, Tally};
use super::{Count, Path};
use crate::history::{CriticalKind, CriticalPoint};
use crate::newton::{Lost, Why};
use crate::packs::{self, Auxiliary};
use crate::system::System;

/// Cosine of the angle by which the path may turn in one increment.
const STRAIGHT: f64 = 0.85;
/// One shorter than this part of the first is believed whatever its tangent, or the singular points that it passes at once;
/// before, strides of these parts of the one that failed are tried: what is in the way of shorter ones may be a state
/// next to which every tangent is singular.
const SHORT: f64 = 1e-3;
const OTHER: [f64; 2] = [2.3, 0.7];
/// The part of a stride that is gone where its end is a singular state, as far as rounding can tell.
const ELSEWHERE: f64 = 0.6;
/// An increment of the arc is not made shorter than this part of the first.
const SHORTEST_ARC: f64 = 1e-7;

/// A bifurcation lies no farther aside of the way between two states than this part of it.
const ASIDE: f64 = 0.3;

/// Where a walk along a path is.
#[derive(Clone)]
pub(super) struct Walk {
    pub fraction: f64,
    /// Fraction of the state before the last one.
    pub before: f64,
    /// Unit tangent at the last state, forward.
    tangent: Direction,
    pub metric: Metric,
    /// Next increment of the arc, the last one, and the first.
    pub next: f64,
    pub last: Option<f64>,
    first: f64,
    pub longest: f64,
    /// Whether a path that turns back without a change of stability is handed over at once: it may touch another one there.
    pub touches: bool,
    /// Negative pivots at the last state, those of motions that pass for neutral among them.
    negative: usize,
    /// The fraction where it seemed to turn back when that was last seen.
    pub top: Option<f64>,
}

impl Walk {
    /// How fast the fraction grows along the arc.
    pub(crate) fn rate(&self) -> f64 {
        self.tangent.rate
    }

    /// Goes the other way from here.
    pub(crate) fn turn_back(&mut self) {
        self.tangent.motions.iter_mut().flatten().for_each(|x| *x = -*x);
        self.tangent.rate = -self.tangent.rate;
    }
}

/// What is zero at a bifurcation.
#[derive(Clone, Copy)]
enum Test {
    /// The stiffness of a mode.
    Mode,
    /// The smallest pivot, with a sign by the side.
    Pivot,
}

/// What lies between two states.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passed {
    /// Count at the second.
    pub count: Count,
    pub limit: bool,
    pub own: bool,
    pub sideways: bool,
    /// The fraction turned back, and no pivot changed its sign.
    pub touched: bool,
}

impl Passed {
    pub(crate) fn any(&self) -> bool {
        self.limit || self.own || self.sideways
    }
}

impl<const D: usize> Path<'_, D> {
    pub(super) fn tracer<'b>(&'b mut self, ramp: &'b Ramp) -> Tracer<'b, D> {
        let Self { system, last, next, newton, .. } = self;
        Tracer { system, last, next, newton: *newton, ramp, factorizations: 0 }
    }

    /// Starts a walk at the last saved state, towards larger fractions; `None` where the path has no direction there.
    ///
    /// `reach` is the part of the ramp that the first increment is to make.
    pub(super) fn walk(&mut self, ramp: &Ramp, fraction: f64, reach: f64, tally: &mut Tally) -> Option<Walk> {
        self.system.restore(&self.last);
        let mut tracer = self.tracer(ramp);
        let rate = tracer.rate(fraction);
        tally.factorizations += tracer.factorizations;
        let rate = rate?;
        let metric = Metric::balanced(&rate, 1.0, self.system.size);
        let tangent = Direction { motions: rate, rate: 1.0 };
        let first = reach * metric.inner(&tangent, &tangent).sqrt();
        let tangent = metric.unit(tangent);
        let longest = f64::INFINITY;
        let (before, last, touches, top) = (fraction, None, false, None);
        let negative = self.system.inertia().negative;
        Some(Walk { fraction, before, tangent, metric, next: first, last, first, longest, touches, negative, top })
    }

    /// One increment of a walk: the state is at its end then, and not saved yet.
    ///
    /// An increment that passes more than one singular point is shortened as long as that separates them.
    pub(super) fn stride(&mut self, walk: &mut Walk, ramp: &Ramp, tally: &mut Tally) -> Result<(Point, Passed), Lost> {
        let begun = walk.next.min(walk.longest);
        let mut other = OTHER.into_iter();
        // The next try is shorter; one that would be too short comes too near to a singular tangent, and goes past it first.
        let mut again = |s: f64, first: f64| match 0.4 * s <= SHORT * first && s > SHORT * first {
            true => other.next().map_or(0.4 * s, |factor: f64| factor * begun),
            false => 0.4 * s,
        };
        loop {
            let s = walk.next.min(walk.longest);
            let short = s <= SHORT * walk.first;
            let n = walk.metric.functional(&walk.tangent);
            let mut guess = walk.fraction;
            self.system.restore(&self.last);
            if let Some(last) = walk.last {
                guess += (walk.fraction - walk.before) * s / last;
                ramp.apply(&mut self.system, guess);
                self.system.predict(&self.before, &self.last, s / last);
            } else {
                guess += s * walk.tangent.rate;
            }
            let mut tracer = self.tracer(ramp);
            let found = tracer.correct(&n, s, walk.fraction, guess);
            let spent = tracer.factorizations;
            tally.factorizations += spent;
            tally.iterations += spent;
            let point = match found {
                Ok(point) => point,
                Err(lost) => {
                    walk.next = again(s, walk.first);
                    // What is held at both ends is so in shorter strides too.
                    let overheld = matches!(lost.why, Why::Overheld(_));
                    let least = if overheld { SHORT } else { SHORTEST_ARC };
                    if walk.next < least * walk.first {
                        return Err(lost);
                    }
                    continue;
                }
            };
            let ahead = Direction { motions: point.rate.clone(), rate: 1.0 };
            let mut ahead = walk.metric.unit(ahead);
            let mut along = walk.metric.inner(&ahead, &walk.tangent);
            if along < 0.0 {
                along = -along;
                ahead.motions.iter_mut().flatten().for_each(|x| *x = -*x);
                ahead.rate = -ahead.rate;
            }
            let chord =
                Direction { motions: self.system.motions_since(&self.last), rate: point.fraction - walk.fraction };
            let parallel = walk.metric.is_chord(&chord, [&walk.tangent, &ahead]);
            let even = short || walk.metric.bends_evenly(&chord, [&walk.tangent, &ahead]);
            if !even {
                walk.next = 0.4 * s;
                continue;
            }
            if !parallel && s > SHORTEST_ARC * walk.first || (along < STRAIGHT || point.iterations > MANY) && !short {
                walk.next = again(s, walk.first);
                continue;
            }
            let count = self.count(&point.inertia);
            let base = self.base;
            if walk.touches && count.neutral && !base.neutral && !short {
                // So near to where branches meet the state may lie on either.
                walk.next = ELSEWHERE * s;
                continue;
            }
            let limit = ahead.rate * walk.tangent.rate < 0.0;
            let conservative = count.potential && base.potential;
            let changed = if conservative {
                count.own.abs_diff(base.own)
            } else {
                usize::from(count.odd != base.odd && count.potential == base.potential)
            };
            let aside = if count.lateral_potential { count.lateral.abs_diff(base.lateral) } else { 0 };
            let events = (changed + aside).max(usize::from(limit));
            let turned = limit && changed == 0;
            // At a fold a pivot changes its sign, though it may be small enough to pass for neutral.
            let same = point.inertia.negative == walk.negative;
            let touched = turned && aside == 0 && walk.touches && same;
            let together = |path: &mut Self, walk: &Walk, tally: &mut Tally| {
                conservative && aside == 0 && path.are_together(ramp, walk, &point, s, tally)
            };
            if !short && !touched && (turned || events > 1 && !together(self, walk, tally)) {
                walk.next = 0.4 * s;
                continue;
            }
            let own = changed > usize::from(limit);
            let iterations = point.iterations;
            let passed = Passed { count, limit, own, sideways: aside > 0, touched };
            if passed.any() {
                // The bracket of what was passed is this increment.
                self.system.save(&mut self.next);
            }
            walk.negative = point.inertia.negative;
            walk.last = Some(s);
            walk.before = walk.fraction;
            walk.fraction = point.fraction;
            walk.tangent = ahead;
            walk.next = s * match iterations {
                0..=4 => 2.0,
                5..=6 => 1.3,
                7..=8 => 1.0,
                _ => 0.6,
            };
            return Ok((point, passed));
        }
    }

    /// Whether all pivots that change their signs between the state `last` and the present one, a stride `s` away, do so at one
    /// place, as those of equal parts of a network do.
    ///
    /// Shorter strides would not separate them, and lead to where every tangent is singular. The states in between are
    /// interpolated, which keeps what is equal.
    fn are_together(&mut self, ramp: &Ramp, walk: &Walk, point: &Point, s: f64, tally: &mut Tally) -> bool {
        let far = point.inertia.negative;
        self.system.save(&mut self.next);
        let mut bracket = [0.0, 1.0];
        let mut together = true;
        while together && (bracket[1] - bracket[0]) * s > SHORT * walk.first {
            let middle = 0.5 * (bracket[0] + bracket[1]);
            ramp.apply(&mut self.system, walk.fraction + middle * (point.fraction - walk.fraction));
            self.system.predict(&self.last, &self.next, middle - 1.0);
            tally.factorizations += 1;
            let negative = self.system.assemble(false).negative;
            if negative == far {
                bracket[1] = middle;
            } else {
                bracket[0] = middle;
                together = negative == walk.negative;
            }
        }
        self.system.restore(&self.next);
        ramp.apply(&mut self.system, point.fraction);
        self.system.assemble(false);
        tally.factorizations += 1;
        together
    }

    /// The singular points between the saved states `last` and `next`, at these fractions; the state is left at the last
    /// of them.
    pub(super) fn pinpoint(
        &mut self,
        ramp: &Ramp,
        ends: [f64; 2],
        metric: Option<Metric>,
        passed: &Passed,
        tally: &mut Tally,
    ) -> Vec<CriticalPoint> {
        let mut found = Vec::new();
        for kind in [CriticalKind::LimitPoint, CriticalKind::Bifurcation] {
            for sideways in [false, true] {
                let wanted = match (kind, sideways) {
                    (CriticalKind::LimitPoint, false) => passed.limit,
                    (CriticalKind::LimitPoint, true) => false,
                    (CriticalKind::Bifurcation, false) => passed.own,
                    (CriticalKind::Bifurcation, true) => passed.sideways,
                };
                if wanted && let Some(point) = self.pinpoint_one(ramp, ends, metric, passed, (kind, sideways), tally) {
                    found.push(point);
                }
            }
        }
        found.sort_by(|a, b| ((a.fraction - b.fraction) * (ends[1] - ends[0])).total_cmp(&0.0));
        // What lies at one place is one point: a network that buckles in its plane and out of it at once, as a round column
        // does, buckles in its plane, and a branch that turns back where it leaves another is a bifurcation.
        found.dedup_by(|later, first| {
            let same = (later.fraction - first.fraction).abs() < 1e-7 * later.fraction.abs().max(1e-3);
            let rank = |point: &CriticalPoint| (point.sideways, point.kind == CriticalKind::LimitPoint);
            if same && rank(first) > rank(later) {
                std::mem::swap(later, first);
            }
            same
        });
        found
    }

    fn pinpoint_one(
        &mut self,
        ramp: &Ramp,
        ends: [f64; 2],
        metric: Option<Metric>,
        passed: &Passed,
        (kind, sideways): (CriticalKind, bool),
        tally: &mut Tally,
    ) -> Option<CriticalPoint> {
        // The auxiliary stiffness of held strains lowers a critical load by the load over itself, and a large one costs
        // digits: two moderate ones tell what an infinite one would give.
        let mut other = None;
        if self.system.holds_strains() {
            // The softer one may move the point out of the bracket.
            other = [packs::MODERATE, packs::AUXILIARY].into_iter().find_map(|auxiliary| {
                let (point, _) = self.locate(ramp, ends, metric, passed, (kind, sideways), (auxiliary, tally))?;
                Some((auxiliary, point.fraction, point.located))
            });
        }
        let mut found = self.locate(ramp, ends, metric, passed, (kind, sideways), (packs::EXACTING, tally));
        if let (Some((point, _)), Some((auxiliary, fraction, located))) = (&mut found, other) {
            let weight = auxiliary.member / (packs::EXACTING.member - auxiliary.member);
            point.located =
                point.located.zip(located).map(|(this, that)| (1.0 + weight).abs() * this + weight.abs() * that);
            point.fraction += weight * (point.fraction - fraction);
        }
        self.system.auxiliary = packs::AUXILIARY;
        ramp.apply(&mut self.system, found.as_ref().map_or(ends[1], |&(_, near)| near));
        self.system.assemble(false);
        found.map(|(point, _)| point)
    }

    /// The singular point of one kind between `last` and `next`, with an auxiliary stiffness of held strains; the state is
    /// left there, or near there at a fraction of its own.
    fn locate(
        &mut self,
        ramp: &Ramp,
        ends: [f64; 2],
        metric: Option<Metric>,
        passed: &Passed,
        (kind, sideways): (CriticalKind, bool),
        (auxiliary, tally): (Auxiliary, &mut Tally),
    ) -> Option<(CriticalPoint, f64)> {
        self.system.auxiliary = auxiliary;
        // The mode, from the far end of the bracket.
        self.system.restore(&self.next);
        ramp.apply(&mut self.system, ends[1]);
        let inertia = self.system.assemble(false);
        let mut lateral = self.lateral.take();
        let mode = match (&mut lateral, sideways) {
            (Some(lateral), true) => {
                lateral.inertia(&mut self.system);
                lateral.softest()
            }
            _ => self.system.softest_motion(),
        };
        let (base, count) = (self.base, passed.count);
        let conservative = base.potential && count.potential;
        let far = inertia.negative;
        let lateral_far = lateral.as_mut().map_or(0, |lateral| lateral.inertia(&mut self.system).0.negative);
        // The softest motion of the joints at the far end may be another one than that of the point: what is lost within a
        // member moves no joint. Then the smallest pivot tells.
        let mut tests = &[Test::Mode][..];
        if kind == CriticalKind::Bifurcation && !sideways {
            let value = self.system.singular_test(&mode);
            self.system.restore(&self.last);
            ramp.apply(&mut self.system, ends[0]);
            self.system.assemble(false);
            tally.factorizations += 1;
            let before = self.system.singular_test(&mode);
            let sees = value.zip(before).is_some_and(|(value, before)| value * before < 0.0);
            tests = if sees { &[Test::Mode, Test::Pivot] } else { &[Test::Pivot] };
        }
        let mut near_gain = None;
        let mut tracer = self.tracer(ramp);
        let mut judge = |test: Test, system: &mut System<D>, point: &Point| match (kind, sideways) {
            (CriticalKind::LimitPoint, _) => {
                let gain = 1.0 / point.gain;
                let first = *near_gain.get_or_insert(gain);
                (gain * first > 0.0, Some(gain))
            }
            (CriticalKind::Bifurcation, true) => match &mut lateral {
                Some(lateral) => {
                    let (inertia, _) = lateral.inertia(system);
                    let rises = count.lateral > base.lateral;
                    let near = if rises { inertia.negative < lateral_far } else { inertia.negative > lateral_far };
                    (near, lateral.singular_test(&mode))
                }
                None => (false, None),
            },
            (CriticalKind::Bifurcation, false) => {
                let near = if !conservative {
                    point.inertia.is_odd() == base.odd
                } else if count.own > base.own {
                    point.inertia.negative < far
                } else {
                    point.inertia.negative > far
                };
                let smallest = point.inertia.smallest;
                let value = match test {
                    Test::Mode => system.singular_test(&mode),
                    Test::Pivot => Some(if near { smallest } else { -smallest }),
                };
                (near, value)
            }
        };
        let mut find =
            |&test: &Test| tracer.singular_point(ends, metric, &mut |system, point| judge(test, system, point));
        let found = tests.iter().find_map(&mut find);
        tally.factorizations += tracer.factorizations;
        let found = found.filter(|point| kind == CriticalKind::LimitPoint || self.lies_between(point.distance));
        // Along the ramp itself the fraction does not turn back: what lies outside of the bracket is of another path.
        let [from, to] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        let room = BEHIND * to.abs();
        let found = found.filter(|point| metric.is_some() || (from - room..=to + room).contains(&point.fraction));
        let own = kind == CriticalKind::Bifurcation && !sideways;
        let point = found.map(|point| {
            // What rounding moves the root of the test function by.
            let slope = point.slope.filter(|_| own);
            let doubt =
                slope.map_or(0.0, |slope| self.system.doubt(&mode).map_or(0.0, |change| (change / slope).abs()));
            let motions = match (&mut lateral, sideways) {
                (Some(lateral), true) => {
                    let mode = lateral.softest();
                    lateral.motions_of(&mode)
                }
                _ => {
                    let mode = self.system.softest_motion();
                    self.system.motions_of(&mode)
                }
            };
            let (node, mode) = self.mode_of(&motions);
            let noted = CriticalPoint {
                kind,
                fraction: point.fraction,
                error: None,
                located: Some(point.scatter.max(doubt)),
                node,
                member: None,
                sideways,
                mode,
            };
            (noted, point.near)
        });
        self.lateral = lateral;
        point
    }

    /// Whether the present state, a bifurcation at this part of the way from `last` to `next`, is about where that leads.
    ///
    /// Where a path nearly meets another, both ends may be on one each, and what is found the fold of the other.
    fn lies_between(&mut self, part: f64) -> bool {
        let here = self.system.snapshot();
        self.system.restore(&self.next);
        let far = self.system.distance(&self.last);
        self.system.predict(&self.last, &self.next, part - 1.0);
        let aside = self.system.distance(&here);
        self.system.restore(&here);
        aside.largest() <= ASIDE * far.largest() + SAME
    }

    /// Keeps the present state as the last one of a walk.
    pub(super) fn keep(&mut self, count: Count) {
        self.base = count;
        self.shift_states();
    }

    /// The last state becomes the one before it, and the present one the last.
    pub(super) fn shift_states(&mut self) {
        std::mem::swap(&mut self.last, &mut self.before);
        self.system.save(&mut self.last);
    }
}
