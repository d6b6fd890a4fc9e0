//! Singular points, as roots of test functions along a path: bracketed, closed in from both sides, and found twice.
//!
//! The test function is the rate of the fraction at a limit point, 1 / (bᵀ K⁻¹ b) at a bifurcation, b near the critical mode.
//!
//! Theory: docs/theory/continuation.md, Eq. 8.4 to 8.6.

use super::direction::{Direction, Metric};
use super::distance::{Locator, Point};
use super::events::Events;
use super::follow::Run;
use super::ramp::Ramp;
use super::{Continuation, OutOfPlane};
use crate::history::{CriticalKind, CriticalPoint};
use crate::packs::{self, Auxiliary};
use crate::system::{Inertia, State, System};

/// Times in a row that a bracket is closed in by the secant before it is halved.
const SECANTS: usize = 4;
/// Part of a critical load by which held strains that give move it, at most: 10⁻⁸ to 10⁻⁶ for columns and frames.
const GIVEN: f64 = 1e-5;

/// A root of a test function, and the path there.
pub(super) struct Root {
    pub point: Point,
    pub fraction: f64,
    /// How far the fraction is from a second location of it.
    scatter: f64,
    /// Change of the test function with the fraction, where that is known.
    slope: Option<f64>,
    /// Negative pivots right before it and right beyond it, where they are known.
    before: Option<usize>,
    pub beyond: Option<usize>,
}

/// Whether a point is still on the near side of a singular point, and the value of a test function.
pub(super) type Judge<'a, const D: usize> = dyn FnMut(&mut System<D>, &Point) -> (bool, Option<f64>) + 'a;

/// Where a point would lie with an infinite auxiliary stiffness, by where it lies with two: it moves with one over that.
fn extrapolated((stiffer, with_stiffer): (Auxiliary, f64), (softer, with_softer): (Auxiliary, f64)) -> f64 {
    with_stiffer + share(stiffer, softer) * (with_stiffer - with_softer)
}

/// Part of what a point moves by from one auxiliary stiffness to a stiffer one that is left to an infinite one.
fn share(stiffer: Auxiliary, softer: Auxiliary) -> f64 {
    softer.member / (stiffer.member - softer.member)
}

/// What the value of a test function is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Value {
    /// Zero at the root alone.
    Smooth,
    /// That of a pivot, which may be zero near the root already: the side that a point is on tells where the root is.
    Side,
}

/// Two points of a path and what lies between them: index 0 is the near side.
struct Bracket {
    /// Distances, fractions, and values of the test function; those of an end that stays are weighed down.
    at: [f64; 2],
    fractions: [f64; 2],
    values: [Option<f64>; 2],
    weighed: [Option<f64>; 2],
    /// Distances between which rounding alone moves the state: so near to a singular tangent no iteration converges.
    blind: Option<[f64; 2]>,
    /// Secants in a row that left more than half.
    kept: usize,
}

impl Bracket {
    fn width(&self) -> f64 {
        self.at[1] - self.at[0]
    }

    /// Where to look next; `None` where rounding lets it come no nearer. `exact` is the width that will do, `nearly` that which
    /// will do beside what is blind.
    fn next(&mut self, exact: f64, nearly: f64) -> Option<f64> {
        let [low, high] = self.at;
        if let Some([from, to]) = self.blind {
            // From both sides, as near as rounding lets.
            let gaps = [from - low, high - to];
            if gaps[0].max(gaps[1]) <= (to - from).max(nearly) {
                return None;
            }
            return Some(if gaps[0] > gaps[1] { from - 0.5 * gaps[0] } else { to + 0.5 * gaps[1] });
        }
        if let [Some(a), Some(b)] = self.weighed
            && a * b < 0.0
            && self.kept < SECANTS
        {
            let s = low - a * self.width() / (b - a);
            // A root that is known already is straddled, so that the bracket closes from both sides.
            return Some(s.clamp(low + 0.01 * exact, high - 0.01 * exact));
        }
        self.kept = 0;
        Some(0.5 * (low + high))
    }

    /// Puts an end where a point was found.
    fn close(&mut self, side: usize, at: f64, fraction: f64, value: Option<f64>) {
        let width = self.width();
        self.at[side] = at;
        self.fractions[side] = fraction;
        (self.values[side], self.weighed[side]) = (value, value);
        let [low, high] = self.at;
        self.blind = self.blind.filter(|[from, to]| low < *from && *to < high);
        // Illinois: an end that stays twice counts for half as much.
        if self.width() > 0.5 * width {
            self.kept += 1;
            self.weighed[1 - side] = self.weighed[1 - side].map(|x| 0.5 * x);
        } else {
            self.kept = 0;
        }
    }
}

/// Two points of a path, as exact as an iteration makes them.
///
/// What lies between is begun from them: where a motion is about to lose its stiffness an iteration multiplies what it begins with of
/// it, and what an increment left of it would hide the point.
struct Known {
    /// Distances along the path, and fractions.
    at: [f64; 2],
    fractions: [f64; 2],
    states: [State; 2],
}

impl Known {
    /// Puts a system between them, or beyond; the fraction there.
    fn predict<const D: usize>(&self, system: &mut System<D>, ramp: &Ramp, at: f64) -> f64 {
        let ratio = (at - self.at[1]) / (self.at[1] - self.at[0]);
        let fraction = self.fractions[1] + ratio * (self.fractions[1] - self.fractions[0]);
        ramp.apply(system, fraction);
        system.predict(&self.states[0], &self.states[1], ratio);
        fraction
    }
}

impl<const D: usize> Locator<'_, D> {
    /// The singular point between the saved states `last` and `next`, at fractions `ends`; the system is left there.
    ///
    /// The path between them is measured with `metric`; without one, joints and fraction count for the same between the
    /// two states, which does where no limit point lies there.
    ///
    /// `judge` tells for a point whether it is still on the near side, and the value of a test function that is zero
    /// at the singular point. Where the value has different signs at both ends it decides, else the side does.
    pub(crate) fn root(
        &mut self,
        ends: [f64; 2],
        metric: Option<Metric>,
        value_is: Value,
        judge: &mut Judge<'_, D>,
    ) -> Option<Root> {
        let tuning = self.newton.tuning;
        let (exact, nearly) = (tuning.exact, tuning.residual.sqrt());
        self.system.restore(self.next);
        let motions = self.system.seen_since(self.last);
        let rate = ends[1] - ends[0];
        let metric = metric.unwrap_or_else(|| Metric::balanced(&motions, rate, self.system.size, tuning.near));
        let secant = Direction { motions, rate };
        let length = metric.inner(&secant, &secant);
        let mut n = metric.functional(&secant);
        n.motions.iter_mut().flatten().for_each(|x| *x /= length);
        n.rate /= length;
        let mut at = |locator: &mut Self, s: f64, known: Option<&Known>| {
            let guess = match known {
                Some(known) => known.predict(locator.system, locator.ramp, s),
                None => {
                    let guess = ends[0] + s * (ends[1] - ends[0]);
                    locator.ramp.apply(locator.system, guess);
                    locator.system.predict(locator.last, locator.next, s - 1.0);
                    guess
                }
            };
            let point = locator.correct(&n, s, ends[0], guess).ok()?;
            let (near, value) = judge(locator.system, &point);
            Some((point, near, value))
        };
        let mut begin = 0.0;
        let (mut first, mut near, mut low) = at(self, begin, None)?;
        // With a softer auxiliary stiffness the point lies a little before where the path was found to pass it.
        let behind = -tuning.shortest * ends[1].abs() / rate.abs();
        if !near && behind < 0.0 {
            (first, near, low) = at(self, behind, None)?;
            begin = behind;
        }
        let near_state = self.system.snapshot();
        let (mut best, far, high) = at(self, 1.0, None)?;
        if !near || far {
            return None;
        }
        let known = Known {
            at: [begin, 1.0],
            fractions: [first.fraction, best.fraction],
            states: [near_state, self.system.snapshot()],
        };
        let mut at = |locator: &mut Self, s: f64| at(locator, s, Some(&known));
        // The count of pivots has noise that a smooth function has not.
        let signs = low.zip(high).filter(|(a, b)| a * b < 0.0);
        let small = signs.map_or(0.0, |(a, b)| 10.0 * exact * a.abs().max(b.abs()));
        let mut bracket = Bracket {
            at: [begin, 1.0],
            fractions: [first.fraction, best.fraction],
            values: [low, high],
            weighed: [low, high],
            blind: None,
            kept: 0,
        };
        for _ in 0..4 * tuning.iterations {
            if bracket.width() <= exact {
                break;
            }
            let Some(s) = bracket.next(exact, nearly) else { break };
            let Some((point, near, value)) = at(self, s) else {
                bracket.blind = Some(bracket.blind.map_or([s, s], |[from, to]| [from.min(s), to.max(s)]));
                continue;
            };
            let near = signs.zip(value).map_or(near, |((a, _), v)| v * a > 0.0);
            let settled = value_is == Value::Smooth && value.is_some_and(|v| v.abs() <= small);
            bracket.close(usize::from(!near), s, point.fraction, value);
            best = point;
            if settled {
                break;
            }
        }
        // A test function that grows without bound has a pole there, and no root.
        let grown = |value: &Option<f64>| value.zip(signs).is_some_and(|(v, (a, b))| v.abs() > a.abs().max(b.abs()));
        if bracket.values.iter().all(grown) {
            return None;
        }
        let [from, to] = bracket.fractions;
        if bracket.blind.is_none() {
            // The test function is linear so near to its root: from two states apart follows where it is once more.
            let root = best.distance;
            let apart = tuning.beside();
            let sides = [root - apart, root + apart].map(|s| {
                let (point, _, value) = at(self, s)?;
                Some((point.fraction, value, point.inertia.negative))
            });
            let line = match sides {
                [Some((from, Some(a), _)), Some((to, Some(b), _))] if a * b < 0.0 => {
                    Some((from, a, (b - a) / (to - from)))
                }
                _ => None,
            };
            let [before, beyond] = sides.map(|side| side.map(|(.., negative)| negative));
            let (point, ..) = at(self, root)?;
            let second = line.map(|(from, a, slope)| from - a / slope);
            let scatter = second.map_or(to - from, |second| second - point.fraction).abs();
            let slope = line.map(|line| line.2);
            return Some(Root { fraction: point.fraction, point, scatter, slope, before, beyond });
        }
        // What is known on the near side is good enough, and the fraction follows by interpolation.
        let part = match bracket.values {
            [Some(a), Some(b)] if a * b < 0.0 => a / (a - b),
            _ => 0.5,
        };
        let apart = (to - from).abs();
        if bracket.width() > tuning.near && apart > tuning.shortest * to.abs() {
            return None;
        }
        let (point, ..) = at(self, bracket.at[0])?;
        let fraction = from + part * (to - from);
        Some(Root { point, fraction, scatter: apart, slope: None, before: None, beyond: None })
    }
}

/// A state that was saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Saved {
    Last,
    Next,
}

/// The tangent out of the plane, where stability is judged there.
type Lateral<'a, const D: usize> = Option<Box<dyn OutOfPlane<D> + 'a>>;

/// What is zero at a bifurcation.
#[derive(Clone, Copy)]
enum Test {
    /// The stiffness of a mode.
    Mode,
    /// The smallest pivot, with a sign by the side.
    Pivot,
}

/// The increment in which singular points are looked for, between the saved states `last` and `next`.
#[derive(Clone, Copy)]
pub(super) struct Interval<'a> {
    /// Fractions of the ramp of both states.
    pub ends: [f64; 2],
    /// What measures distances between them, where it is not the fraction.
    pub metric: Option<Metric>,
    /// What differs between them.
    pub events: &'a Events,
}

/// A kind of singular point that is looked for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Wanted {
    Limit,
    Bifurcation,
    Sideways,
}

impl Wanted {
    fn kind(self) -> CriticalKind {
        match self {
            Wanted::Limit => CriticalKind::LimitPoint,
            Wanted::Bifurcation | Wanted::Sideways => CriticalKind::Bifurcation,
        }
    }
}

impl<const D: usize> Continuation<'_, D> {
    /// The singular points in an increment; the state is left at the last of them.
    pub(super) fn pinpoint(&mut self, run: &mut Run<'_>, interval: Interval<'_>) -> Vec<CriticalPoint> {
        let Interval { ends, events, .. } = interval;
        let wanted = [
            (Wanted::Limit, events.limit),
            (Wanted::Bifurcation, events.bifurcates()),
            (Wanted::Sideways, events.aside > 0),
        ];
        let mut found = Vec::new();
        for (kind, _) in wanted.into_iter().filter(|wanted| wanted.1) {
            found.extend(self.pinpoint_one(run, interval, kind));
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

    /// The singular point of one kind in an increment.
    fn pinpoint_one(&mut self, run: &mut Run<'_>, interval: Interval<'_>, wanted: Wanted) -> Option<CriticalPoint> {
        // The auxiliary stiffness of held strains lowers a critical load by the load over itself, and a large one costs
        // digits: two moderate ones tell what an infinite one would give.
        let mut other = None;
        if self.system.loading.holds_strains() {
            // The softer one may move the point out of the bracket.
            other = [packs::MODERATE, packs::AUXILIARY].into_iter().find_map(|auxiliary| {
                let (point, _) = self.locate(run, interval, wanted, auxiliary)?;
                Some((auxiliary, point.fraction, point.located))
            });
        }
        let mut found = self.locate(run, interval, wanted, packs::EXACTING);
        if found.is_none() && self.system.loading.holds_strains() {
            // Softer ones may move the point out of a bracket as narrow as this.
            found = self.locate(run, interval, wanted, packs::AUXILIARY);
            if let Some((point, _)) = &mut found {
                let moved = self.system.members.give() * point.fraction.abs();
                point.located = point.located.map(|located| located + moved);
            }
            other = None;
        }
        if let (Some((point, near)), Some((auxiliary, fraction, located))) = (&mut found, other) {
            let (mut stiffer, mut exact) = (packs::EXACTING, point.fraction);
            let mut doubt = 0.0;
            // What holds strains more stiffly lowers no stiffness, and loses none earlier.
            let ahead = (interval.ends[1] - interval.ends[0]).signum();
            let forward = if interval.events.count.own > self.base.own { ahead } else { -ahead };
            let known = point.located.unwrap_or(0.0) + located.unwrap_or(0.0);
            // One that moves by much need not go with their stiffness at all: that is looked at below.
            let is_earlier =
                |exact: f64| (exact - fraction) * forward < -known && (exact - fraction).abs() <= GIVEN * exact.abs();
            if wanted == Wanted::Bifurcation && is_earlier(exact) {
                // Where the other one is the usual one already there is no third.
                let third = if auxiliary == packs::AUXILIARY {
                    None
                } else {
                    self.locate(run, interval, wanted, packs::AUXILIARY)
                };
                match third.filter(|(third, _)| !is_earlier(third.fraction)) {
                    Some((third, at)) => {
                        (stiffer, exact) = (packs::AUXILIARY, third.fraction);
                        (*point, *near) = (third, at);
                    }
                    None => doubt = (exact - fraction).abs(),
                }
            }
            point.fraction = extrapolated((stiffer, exact), (auxiliary, fraction));
            let weight = share(stiffer, auxiliary).abs();
            // A point that moves by more may not go with their stiffness: where a buckled branch crosses the straight one bending
            // alone makes a member shorter, and by next to nothing. Another pair of stiffnesses tells.
            if stiffer == packs::EXACTING && (point.fraction - exact).abs() > GIVEN * exact.abs() {
                let third = if auxiliary == packs::MODERATE {
                    self.locate(run, interval, wanted, packs::AUXILIARY)
                } else {
                    None
                };
                doubt = (exact - fraction).abs();
                if let Some((third, at)) = third {
                    let again = extrapolated((packs::AUXILIARY, third.fraction), (packs::EXACTING, exact));
                    (doubt, *near) = ((again - point.fraction).abs(), at);
                }
            }
            point.located =
                point.located.zip(located).map(|(this, that)| (1.0 + weight) * this + weight * that + doubt);
        }
        self.system.loading.set_auxiliary(packs::AUXILIARY);
        run.ramp.apply(&mut self.system, found.as_ref().map_or(interval.ends[1], |&(_, near)| near));
        self.system.assemble(false);
        found.map(|(point, _)| point)
    }

    /// The softest motion at the last assembly, out of the plane where that is looked for.
    fn softest(&mut self, lateral: &mut Lateral<'_, D>, wanted: Wanted) -> Vec<f64> {
        match lateral {
            Some(lateral) if wanted == Wanted::Sideways => lateral.softest(),
            _ => self.system.tangent.softest_motion(&self.system.pattern, self.system.size),
        }
    }

    /// The stiffness of a motion at a state that was saved, at this fraction.
    fn stiffness_at(&mut self, run: &mut Run<'_>, state: Saved, fraction: f64, mode: &[f64]) -> Option<f64> {
        self.system.restore(if state == Saved::Last { &self.last } else { &self.next });
        run.ramp.apply(&mut self.system, fraction);
        self.system.assemble(false);
        run.effort.factorizations += 1;
        self.system.tangent.singular_test(mode)
    }

    /// The motion that is lost at a bifurcation, and what is zero there; `softest` is the softest motion at the far end, where the
    /// present state is.
    ///
    /// Far from the point that may be another one: then the softest motion near to it is looked at. What is lost within a member moves
    /// no joint, and the smallest pivot tells.
    fn critical_mode(
        &mut self,
        run: &mut Run<'_>,
        interval: Interval<'_>,
        softest: Vec<f64>,
        is_near: &dyn Fn(&Inertia) -> bool,
    ) -> (Vec<f64>, &'static [Test]) {
        const BOTH: &[Test] = &[Test::Mode, Test::Pivot];
        let [from, to] = interval.ends;
        let is_lost = |before: Option<f64>, after: Option<f64>| before.zip(after).is_some_and(|(a, b)| a * b < 0.0);
        let after = self.system.tangent.singular_test(&softest);
        let before = self.stiffness_at(run, Saved::Last, from, &softest);
        // Of several that are lost the softest one need not be the first.
        if !self.loses_several_within(interval.events) && is_lost(before, after) {
            return (softest, BOTH);
        }
        let mut locator = self.locator(run.ramp);
        locator.newton.tuning.exact = locator.newton.tuning.near;
        let found =
            locator.root(interval.ends, interval.metric, Value::Side, &mut |_, point| (is_near(&point.inertia), None));
        run.effort.factorizations += locator.factorizations;
        if found.is_some() {
            let mode = self.system.tangent.softest_motion(&self.system.pattern, self.system.size);
            let before = self.stiffness_at(run, Saved::Last, from, &mode);
            let after = self.stiffness_at(run, Saved::Next, to, &mode);
            if is_lost(before, after) {
                return (mode, BOTH);
            }
        }
        (softest, &[Test::Pivot])
    }

    /// Whether more than one motion is lost up to the present state, of these events, and some of it between the ends of members.
    fn loses_several_within(&self, events: &Events) -> bool {
        let mut chains = self.system.members.chains();
        events.count.own > self.base.own + 1 && chains.any(|(pack, lane)| pack.interior(lane).negative > 0)
    }

    /// The singular point of one kind in an increment, with an auxiliary stiffness of held strains; the state is left there, or
    /// near there at a fraction of its own.
    fn locate(
        &mut self,
        run: &mut Run<'_>,
        interval: Interval<'_>,
        wanted: Wanted,
        auxiliary: Auxiliary,
    ) -> Option<(CriticalPoint, f64)> {
        let Interval { ends, metric, events } = interval;
        self.system.loading.set_auxiliary(auxiliary);
        // The mode, from the far end of the bracket.
        self.system.restore(&self.next);
        run.ramp.apply(&mut self.system, ends[1]);
        let inertia = self.system.assemble(false);
        let mut lateral = self.lateral.take();
        let lateral_far = lateral.as_mut().map_or(0, |lateral| lateral.inertia(&mut self.system).0.negative);
        let softest = self.softest(&mut lateral, wanted);
        let (base, count) = (self.base, events.count);
        let conservative = base.potential && count.potential;
        let far = inertia.negative;
        // Where several are lost in an increment that is too short to separate them, the first one counts. Motions of joints tell one
        // mode from the other, but where all of them bend the same member: what is lost there is told by its number.
        let several = self.loses_several_within(events);
        let lost = if several { count.own - base.own } else { usize::from(count.own > base.own) };
        let is_near = move |inertia: &Inertia| {
            if !conservative {
                inertia.is_odd() == base.odd
            } else if lost > 0 {
                inertia.negative + lost <= far
            } else {
                inertia.negative > far
            }
        };
        let (mode, tests) = match wanted {
            Wanted::Bifurcation => self.critical_mode(run, interval, softest, &is_near),
            Wanted::Limit | Wanted::Sideways => (softest, [Test::Mode].as_slice()),
        };
        let mut near_rate = None;
        // The least rate of the fraction at both ends, and the largest.
        let mut rates = [f64::INFINITY, 0.0];
        let mut locator = self.locator(run.ramp);
        let mut judge = |test: Test, system: &mut System<D>, point: &Point| match wanted {
            Wanted::Limit => {
                let first = *near_rate.get_or_insert(point.rate_of_fraction());
                (point.rate_of_fraction() * first > 0.0, Some(point.rate_of_fraction()))
            }
            Wanted::Sideways => match &mut lateral {
                Some(lateral) => {
                    let (inertia, _) = lateral.inertia(system);
                    let rises = count.lateral > base.lateral;
                    let near = if rises { inertia.negative < lateral_far } else { inertia.negative > lateral_far };
                    (near, lateral.singular_test(&mode))
                }
                None => (false, None),
            },
            Wanted::Bifurcation => {
                if !(0.0 < point.distance && point.distance < 1.0) {
                    let rate = point.rate_of_fraction().abs();
                    rates = [rates[0].min(rate), rates[1].max(rate)];
                }
                let near = is_near(&point.inertia);
                let smallest = point.inertia.smallest;
                let value = match test {
                    Test::Mode => system.tangent.singular_test(&mode),
                    Test::Pivot => Some(if near { smallest } else { -smallest }),
                };
                (near, value)
            }
        };
        let mut find = |&test: &Test| {
            let value = if matches!(test, Test::Mode) { Value::Smooth } else { Value::Side };
            let root = locator.root(ends, metric, value, &mut |system, point| judge(test, system, point))?;
            // The stiffness of a mode that changes its sign with every one that is lost may find a later one.
            let is_later = || root.before.is_some_and(|before| before + lost > far);
            let others = wanted == Wanted::Bifurcation && conservative && several && is_later();
            if others && matches!(test, Test::Mode) {
                return None;
            }
            Some(Root { slope: root.slope.filter(|_| matches!(test, Test::Mode)), ..root })
        };
        let found = tests.iter().find_map(&mut find);
        run.effort.factorizations += locator.factorizations;
        // A ramp that turns back there and not between both ends does so on another path, which the increment went over to.
        let turned = self.tuning.near * rates[0];
        let turns = |root: &Root| !events.limit && root.point.rate_of_fraction().abs() < turned;
        let found = found.filter(|root| wanted != Wanted::Bifurcation || !turns(root));
        // One point makes of the count right before it what the count is right beyond: where those are others at the ends, the
        // increment went over to another path before the point, or behind it.
        let one = conservative && events.number() == 1 && wanted == Wanted::Limit;
        let is_before = |before: usize| before + count.own == far + base.own;
        let is_one = |root: &Root| root.before.is_none_or(is_before) && root.beyond.is_none_or(|beyond| beyond == far);
        let found = found.filter(|root| !one || is_one(root));
        let found = found.filter(|root| wanted == Wanted::Limit || self.lies_between(root.point.distance));
        // Along the ramp itself the fraction does not turn back: what lies outside of the bracket is of another path.
        let [from, to] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        let room = self.tuning.shortest * to.abs();
        let found = found.filter(|root| metric.is_some() || (from - room..=to + room).contains(&root.fraction));
        let located = found.map(|root| {
            let slope = root.slope.filter(|_| wanted == Wanted::Bifurcation);
            let softest = self.softest(&mut lateral, wanted);
            let doubt = match wanted {
                Wanted::Sideways => 0.0,
                _ if slope.is_some() => self.moved_by_rounding(run, ends, &root, (&mode, slope)),
                _ => self.moved_by_rounding(run, ends, &root, (&softest, None)),
            };
            let mode = softest;
            let motions = match &lateral {
                Some(lateral) if wanted == Wanted::Sideways => lateral.motions_of(&mode),
                _ => self.system.pattern.motions_of(&mode),
            };
            let (node, mode) = self.mode_of(&motions);
            let mut noted = CriticalPoint {
                kind: wanted.kind(),
                fraction: root.fraction,
                in_prestress: false,
                increments_before: 0,
                error: None,
                located: Some(root.scatter.max(doubt)),
                node,
                member: None,
                sideways: wanted == Wanted::Sideways,
                mode,
                middles: Vec::new(),
            };
            if wanted == Wanted::Limit {
                self.draw_out_of_sight(&mut noted, &root.point.rate);
            }
            (noted, root.point.fraction)
        });
        self.lateral = lateral;
        located
    }

    /// How far rounding may move a root along the ramp, the present state between `last` and `next` at the fractions `ends`: what it
    /// may change the stiffness of a motion by, over the slope of that with the fraction, where it is not known from the root to the
    /// farther end.
    fn moved_by_rounding(
        &mut self,
        run: &mut Run<'_>,
        ends: [f64; 2],
        root: &Root,
        (mode, slope): (&[f64], Option<f64>),
    ) -> f64 {
        let Some(change) = self.system.doubt(mode) else { return 0.0 };
        let slope = slope.or_else(|| {
            let here = self.system.snapshot();
            let apart = ends.map(|end| (end - root.fraction).abs());
            let (state, end) = if apart[0] > apart[1] { (Saved::Last, ends[0]) } else { (Saved::Next, ends[1]) };
            let there = self.stiffness_at(run, state, end, mode);
            self.system.restore(&here);
            run.ramp.apply(&mut self.system, root.point.fraction);
            self.system.assemble(false);
            run.effort.factorizations += 1;
            there.map(|there| there / (end - root.fraction))
        });
        slope.map_or(0.0, |slope| (change / slope).abs())
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
        aside.largest() <= self.tuning.shorter * far.largest() + self.tuning.shortest
    }
}
