//! Points of a path by its arclength: past limit points, through bifurcations, and onto singular points.
//!
//! A path is measured by a functional n of the motion since a saved state and of the fraction of the ramp; Newton's
//! iteration solves for both with the bordered matrix, by two solutions with one factorization (Riks, Int. J. Solids
//! Struct. 15, 1979; Keller 1977). Singular points are roots of a test function along the path: the rate of the fraction
//! at a limit point, 1 / (bᵀ K⁻¹ b) at a bifurcation, b near the critical mode.
//!
//! Theory: docs/theory/continuation.md, Eq. 8.2 to 8.4.

use super::follow::Ramp;
use crate::held::HeldForces;
use crate::newton::{Aim, Lost, NEAR, Newton, Why};
use crate::system::{Inertia, Residual, State, System};
/// Motion of a whole ramp, in sizes of the network or radians, below which joints hardly move.
const HARDLY: f64 = 1e-2;
/// Cosine of the angle between a chord of a path and the mean of the tangents at its ends, which curvature that changes by
/// as much as itself takes to a sixth of the angle between the tangents.
const PARALLEL: f64 = 0.98;
/// Angle (radians) that a path turns by in one increment without a look at where it does, and by how much the turn of one half may
/// exceed that of the other.
const BENT: f64 = 0.1;
const UNEVEN: f64 = 2.5;
/// Distance of the fractions whose difference stands for the derivative.
const AHEAD: f64 = 1e-6;
/// Part of a bracket within which a singular point is found.
const EXACT: f64 = 1e-9;
/// Part of a bracket up to which it is made smaller where rounding stands in the way, and one that is good enough then.
const NEARLY: f64 = 1e-5;
const NEAR_ENOUGH: f64 = 0.02;
/// Part of the fraction by which a bracket may have to begin sooner.
pub(super) const BEHIND: f64 = 1e-4;
/// Value of the test function, over that at the ends of the bracket, that is zero.
const SMALL: f64 = 1e-8;
/// Part of a bracket by which states are apart that tell how well a root in it is known.
const APART: f64 = 1e-3;
/// Trials for one singular point.
const TRIALS: usize = 60;

/// A motion of the joints together with a change of the fraction, or a functional of both.
#[derive(Clone, Debug, Default)]
pub(super) struct Direction {
    pub motions: Vec<[f64; 6]>,
    pub rate: f64,
}

/// Weight of displacements and rotations against the fraction: the square of what a unit of the fraction counts for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Metric {
    displacement: f64,
    rotation: f64,
}

impl Metric {
    /// Joints and fraction count for the same where the joints move as they do here, but for joints that hardly move:
    /// a straight column only shortens until it buckles, and must not be measured by that.
    pub(crate) fn balanced(motions: &[[f64; 6]], rate: f64, size: f64) -> Self {
        let plain = Self { displacement: 1.0 / (size * size), rotation: 1.0 };
        let moved = plain.product(motions, motions).max((HARDLY * rate).powi(2));
        let factor = if moved > 0.0 && rate != 0.0 { rate * rate / moved } else { 1.0 };
        Self { displacement: factor * plain.displacement, rotation: factor }
    }

    fn product(&self, a: &[[f64; 6]], b: &[[f64; 6]]) -> f64 {
        let part = |a: &[f64; 6], b: &[f64; 6], from: usize| (from..from + 3).map(|c| a[c] * b[c]).sum::<f64>();
        let sum = |from| a.iter().zip(b).map(|(a, b)| part(a, b, from)).sum::<f64>();
        self.displacement * sum(0) + self.rotation * sum(3)
    }

    pub(crate) fn inner(&self, a: &Direction, b: &Direction) -> f64 {
        self.product(&a.motions, &b.motions) + a.rate * b.rate
    }

    /// The direction, made of length one.
    pub(crate) fn unit(&self, mut direction: Direction) -> Direction {
        let length = self.inner(&direction, &direction).sqrt().max(f64::MIN_POSITIVE);
        direction.motions.iter_mut().flatten().for_each(|x| *x /= length);
        direction.rate /= length;
        direction
    }

    /// Whether the way between two points of a path goes the way of the unit tangents at both, taken together.
    ///
    /// It does where the path bends as a circle, whatever the angle; a chord that does not leads to another path.
    pub(crate) fn is_chord(&self, chord: &Direction, tangents: [&Direction; 2]) -> bool {
        let [first, second] = tangents;
        let along = self.inner(chord, first) + self.inner(chord, second);
        let length = (2.0 + 2.0 * self.inner(first, second)).max(0.0).sqrt();
        along >= PARALLEL * length * self.inner(chord, chord).sqrt()
    }

    /// Whether the path that a chord cuts off bends about as much in its first half as in its second: on to another one, at
    /// a kink, it does not. Where it hardly bends there is nothing to compare.
    ///
    /// The angles of a chord with the tangents at its ends differ by a factor of two where the curvature rises evenly from zero.
    pub(crate) fn bends_evenly(&self, chord: &Direction, tangents: [&Direction; 2]) -> bool {
        let length = self.inner(chord, chord).sqrt();
        let [first, second] = tangents.map(|tangent| (self.inner(chord, tangent) / length).clamp(-1.0, 1.0).acos());
        first + second <= BENT || first.max(second) <= UNEVEN * first.min(second)
    }

    /// The functional that measures along a direction.
    pub(crate) fn functional(&self, direction: &Direction) -> Direction {
        let mut functional = direction.clone();
        for motion in &mut functional.motions {
            for (c, x) in motion.iter_mut().enumerate() {
                *x *= if c < 3 { self.displacement } else { self.rotation };
            }
        }
        functional
    }
}

impl Direction {
    /// Value of this functional.
    pub(crate) fn along(&self, motions: &[[f64; 6]], fraction: f64) -> f64 {
        let joints: f64 = self.motions.iter().zip(motions).map(|(n, m)| (0..6).map(|c| n[c] * m[c]).sum::<f64>()).sum();
        joints + self.rate * fraction
    }
}

/// An equilibrium on a path.
#[derive(Debug)]
pub(super) struct Point {
    pub fraction: f64,
    /// Its distance, as it was asked for.
    pub distance: f64,
    /// Fraction of the state, where that of the point is interpolated.
    pub near: f64,
    pub iterations: usize,
    pub inertia: Inertia,
    pub residual: Residual,
    /// How far the fraction of a singular point is from a second location of it.
    pub scatter: f64,
    /// Change of the test function of a singular point with the fraction, where that is known.
    pub slope: Option<f64>,
    /// Motion of the joints for a unit of the fraction, at this state.
    pub rate: Vec<[f64; 6]>,
    /// What the functional grows by for a unit of the fraction: without bound at a limit point.
    pub gain: f64,
}

/// Whether a point is still on the near side of a singular point, and the value of a test function.
pub(super) type Judge<'a, const D: usize> = dyn FnMut(&mut System<D>, &Point) -> (bool, Option<f64>) + 'a;

/// What finds points of a path.
pub(super) struct Tracer<'a, const D: usize> {
    pub system: &'a mut System<D>,
    /// The state that distances are measured from, and one ahead.
    pub last: &'a State,
    pub next: &'a State,
    pub newton: Newton,
    pub ramp: &'a Ramp,
    /// Factorizations so far.
    pub factorizations: usize,
}

impl<const D: usize> Tracer<'_, D> {
    /// The path's direction at the present state, which is an equilibrium: motion of the joints for a unit of the
    /// fraction.
    pub(crate) fn rate(&mut self, fraction: f64) -> Option<Vec<[f64; 6]>> {
        let ramp = self.ramp;
        let mut apply = |system: &mut System<D>, fraction: f64| ramp.apply(system, fraction);
        let (linearized, solved) = self.system.linearize(fraction, ahead(fraction), &mut apply);
        self.factorizations += 1;
        solved.then_some(linearized.rate_motions)
    }

    /// Brings the present state to the equilibrium at the distance `s`, measured by `n`, from the last saved one.
    ///
    /// `from` is the fraction of the saved state, `guess` that of the present one.
    pub(crate) fn correct(&mut self, n: &Direction, s: f64, from: f64, guess: f64) -> Result<Point, Lost> {
        let newton = self.newton;
        let ramp = self.ramp;
        let mut apply = |system: &mut System<D>, fraction: f64| ramp.apply(system, fraction);
        let mut fraction = guess;
        let (mut last, mut before) = (f64::INFINITY, f64::INFINITY);
        // What a change of the fraction does between the ends of members follows an iteration later.
        let mut changed = f64::INFINITY;
        let mut held = HeldForces::default();
        held.begin(self.system);
        for iterations in 1..=newton.max_iterations {
            let (linearized, solved) = self.system.linearize(fraction, ahead(fraction), &mut apply);
            self.factorizations += 1;
            let residual = linearized.residual;
            #[cfg(feature = "trace")]
            eprintln!(
                "{iterations:3} {:.1e} {:.1e} {last:.1e} at {fraction} {:?}",
                residual.force, residual.moment, linearized.inertia
            );
            let gap = n.along(&self.system.motions_since(self.last), fraction - from) - s;
            let gain = n.along(&linearized.rate_motions, 1.0);
            let converged = changed <= newton.foreseen && newton.is_converged(last, before, residual);
            let is_held = || {
                let settled = held.are_settled(self.system, newton.held_part(Aim::Result));
                settled && self.system.violation() <= newton.violation
            };
            if converged && is_held() {
                let (inertia, rate) = (linearized.inertia, linearized.rate_motions);
                let near = fraction;
                let (distance, scatter, slope) = (s, 0.0, None);
                return Ok(Point {
                    fraction,
                    distance,
                    near,
                    iterations,
                    inertia,
                    residual,
                    scatter,
                    slope,
                    rate,
                    gain,
                });
            }
            let lost = |why| Err(Lost { iterations, factorizations: iterations, residual, why });
            let change = -(gap + n.along(&linearized.step_motions, 0.0)) / gain;
            if !solved || !change.is_finite() {
                return lost(Why::Singular);
            }
            let mut solution = linearized.step;
            for (x, rate) in solution.iter_mut().zip(&linearized.rate) {
                *x += change * rate;
            }
            fraction += change;
            changed = change.abs();
            let system = &mut *self.system;
            system.fraction = fraction;
            system.equations.update(&system.topology, &system.state.joints, fraction);
            let size = system.move_by(&solution, true).largest().max(change.abs());
            if !(size <= newton.lost || size <= last) {
                return lost(Why::Astray);
            }
            if let Some(member) = held.follow(system, size <= NEAR) {
                return lost(Why::Overheld(member));
            }
            before = last;
            last = size;
        }
        let (iterations, residual) = (newton.max_iterations, self.system.residual());
        Err(Lost { iterations, factorizations: iterations, residual, why: Why::Slow })
    }

    /// The singular point between the saved states `last` and `next`, at fractions `ends`; the system is left there.
    ///
    /// The path between them is measured with `metric`; without one, joints and fraction count for the same between the
    /// two states, which does where no limit point lies there.
    ///
    /// `judge` tells for a point whether it is still on the near side, and the value of a test function that is zero
    /// at the singular point. Where the value has different signs at both ends it decides, else the side does.
    pub(crate) fn singular_point(
        &mut self,
        ends: [f64; 2],
        metric: Option<Metric>,
        judge: &mut Judge<'_, D>,
    ) -> Option<Point> {
        self.system.restore(self.next);
        let motions = self.system.motions_since(self.last);
        let rate = ends[1] - ends[0];
        let metric = metric.unwrap_or_else(|| Metric::balanced(&motions, rate, self.system.size));
        let secant = Direction { motions, rate };
        let length = metric.inner(&secant, &secant);
        let mut n = metric.functional(&secant);
        n.motions.iter_mut().flatten().for_each(|x| *x /= length);
        n.rate /= length;
        let mut at = |tracer: &mut Self, s: f64| {
            let guess = ends[0] + s * (ends[1] - ends[0]);
            tracer.ramp.apply(tracer.system, guess);
            tracer.system.predict(tracer.last, tracer.next, s - 1.0);
            let point = tracer.correct(&n, s, ends[0], guess).ok()?;
            let (near, value) = judge(tracer.system, &point);
            Some((point, near, value))
        };
        let (mut first, mut near, mut low) = at(self, 0.0)?;
        let mut begin = 0.0;
        // With a softer auxiliary stiffness the point lies a little before where the path was found to pass it.
        let behind = -BEHIND * ends[1].abs() / rate.abs();
        if !near && behind < 0.0 {
            (first, near, low) = at(self, behind)?;
            begin = behind;
        }
        let start = first.fraction;
        let (mut best, far, mut high) = at(self, 1.0)?;
        if !near || far {
            return None;
        }
        // The count of pivots has noise that a smooth function has not.
        let first = low.zip(high).filter(|(a, b)| a * b < 0.0);
        let small = first.map_or(0.0, |(a, b)| SMALL * a.abs().max(b.abs()));
        let mut bracket = [begin, 1.0];
        let mut fractions = [start, best.fraction];
        let mut kept = 0;
        // What the iteration does not find for rounding.
        let mut blind: Option<[f64; 2]> = None;
        let mut values = [low, high];
        for _ in 0..TRIALS {
            let width = bracket[1] - bracket[0];
            if width <= EXACT {
                break;
            }
            let middle = 0.5 * (bracket[0] + bracket[1]);
            let s = match (low, high) {
                _ if let Some([from, to]) = blind => {
                    // From both sides, as near as rounding lets.
                    let gaps = [from - bracket[0], bracket[1] - to];
                    if gaps[0].max(gaps[1]) <= (to - from).max(NEARLY) {
                        break;
                    }
                    if gaps[0] > gaps[1] { from - 0.5 * gaps[0] } else { to + 0.5 * gaps[1] }
                }
                (Some(a), Some(b)) if a * b < 0.0 && kept < 4 => {
                    let s = bracket[0] - a * width / (b - a);
                    // A root that is known already is straddled, so that the bracket closes from both sides.
                    s.clamp(bracket[0] + 0.01 * EXACT, bracket[1] - 0.01 * EXACT)
                }
                _ => {
                    kept = 0;
                    middle
                }
            };
            let Some((point, near, value)) = at(self, s) else {
                // So near to a singular tangent rounding alone moves the state.
                blind = Some(blind.map_or([s, s], |[from, to]| [from.min(s), to.max(s)]));
                continue;
            };
            let near = first.zip(value).map_or(near, |((a, _), v)| v * a > 0.0);
            let settled = value.is_some_and(|v| v.abs() <= small);
            let side = usize::from(!near);
            fractions[side] = point.fraction;
            best = point;
            bracket[side] = s;
            blind = blind.filter(|[from, to]| bracket[0] < *from && *to < bracket[1]);
            values[side] = value;
            if settled {
                break;
            }
            // Illinois: an end that stays twice counts for half as much.
            let (this, other) = if near { (&mut low, &mut high) } else { (&mut high, &mut low) };
            *this = value;
            if bracket[1] - bracket[0] > 0.5 * width {
                kept += 1;
                *other = other.map(|x| 0.5 * x);
            } else {
                kept = 0;
            }
        }
        // A test function that grows without bound has a pole there, and no root.
        let grown = |value: &Option<f64>| value.zip(first).is_some_and(|(v, (a, b))| v.abs() > a.abs().max(b.abs()));
        if values.iter().all(grown) {
            return None;
        }
        if blind.is_none() {
            // The test function is linear so near to its root: from two states apart follows where it is once more.
            let root = best.distance;
            let sides = [root - APART, root + APART]
                .map(|s| at(self, s).and_then(|(point, _, value)| Some((point.fraction, value?))));
            let line = match sides {
                [Some((from, a)), Some((to, b))] if a * b < 0.0 => Some((from, a, (b - a) / (to - from))),
                _ => None,
            };
            let (point, ..) = at(self, root)?;
            let second = line.map(|(from, a, slope)| from - a / slope);
            let scatter = second.map_or(fractions[1] - fractions[0], |second| second - point.fraction).abs();
            let slope = line.map(|line| line.2);
            return Some(Point { scatter, slope, ..point });
        }
        // What is known on the near side is good enough, and the fraction follows by interpolation.
        let part = match values {
            [Some(a), Some(b)] if a * b < 0.0 => a / (a - b),
            _ => 0.5,
        };
        if bracket[1] - bracket[0] > NEAR_ENOUGH {
            return None;
        }
        let fraction = fractions[0] + part * (fractions[1] - fractions[0]);
        let scatter = (fractions[1] - fractions[0]).abs();
        at(self, bracket[0]).map(|(point, ..)| Point { fraction, scatter, ..point })
    }
}

/// A difference that stays within the tables of muscles.
fn ahead(fraction: f64) -> f64 {
    if fraction > 0.5 { -AHEAD } else { AHEAD }
}
