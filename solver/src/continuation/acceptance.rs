//! Increments that may have left their path, and how they are held against shorter ones.
//!
//! Where loads have a potential, a rise of the count of negative pivots tells. Without one the count may rise rightly, two
//! at a time, and the determinant keeps its sign over two limit points at once: what tells then is how far the state is from
//! where it was foreseen, and how hard it was to find.

use std::f64::consts::PI;

use super::Continuation;
use super::Tuning;
use super::follow::Run;
use crate::chain::Size;
use crate::newton::{Aim, Convergence, Start};
use crate::system::{State, System};

/// The first part of an increment that is made again in two. Not a half: a rod that rolls up by an even number of turns is
/// at whole turns in the middle too, where its tangent is singular.
const FIRST_PART: f64 = 0.47;
/// A way over those that the tangents at both ends make of an increment: where the rate of a path rises, or falls, all along, its way
/// is between them.
const FARTHER: f64 = 1.5;
/// Contraction of an iteration whose first increment says where it leads: all that follow move it by about as much as this part of
/// that one (Deuflhard, Newton Methods for Nonlinear Problems, 2004, sec. 2.1).
const CONTRACTS: f64 = 0.05;
/// An angle (radians) by which a hinge turns in one increment at most, a sixth of a right one: bars that are hinged pass dead centres,
/// and windows without a stable state, that neither end of a longer increment tells of.
const HINGE: f64 = PI / 12.0;
/// An angle (radians) by which the linear answer to an increment turns anything at most: beyond half a turn its rotation vectors do not
/// say any more which way it went.
pub(super) const HALF_A_TURN: f64 = PI;
/// A rotation (radians) after which pivots may be lost, and iterations be many, on any path.
const RADIAN: f64 = 1.0;

impl<const D: usize> Continuation<'_, D> {
    /// Iterations that are too many to believe that a part of an increment led to the next state of the path: after a radian none are.
    pub(super) fn too_many(&self, rose: bool) -> usize {
        match self.system.distance(&self.last).rotation > RADIAN {
            true => usize::MAX,
            false => self.tuning.most_nearby(rose),
        }
    }

    /// Makes an increment to the present state again in two parts, `None` where they end elsewhere or need many iterations.
    ///
    /// `ratio` is that of the increment to the one before, if there is one to extrapolate from.
    pub(super) fn in_two_parts(
        &mut self,
        run: &mut Run<'_>,
        [from, to]: [f64; 2],
        ratio: Option<f64>,
    ) -> Option<Convergence> {
        let here = self.system.snapshot();
        self.system.restore(&self.last);
        let middle = from + FIRST_PART * (to - from);
        let start = Start { may_wander: false, ..Start::nearby() };
        for target in [middle, to] {
            run.ramp.apply(&mut self.system, target);
            if target == to {
                self.system.save(&mut self.next);
                self.system.predict(&self.last, &self.next, (1.0 - FIRST_PART) / FIRST_PART);
            } else if let Some(ratio) = ratio {
                self.system.predict(&self.before, &self.last, FIRST_PART * ratio);
            }
            let predicted = target == to || ratio.is_some();
            let aim = if target < 1.0 { Aim::Passing } else { Aim::Result };
            let outcome = self.newton.solve(&mut self.system, Start { predicted, aim, ..start });
            run.effort.count(&outcome);
            let found = outcome.ok().filter(|found| found.inertia.is_odd() == self.base.odd)?;
            if found.iterations >= self.too_many(found.inertia.negative > self.base.own) {
                return None;
            }
            if target == to {
                return (self.system.distance(&here).largest() <= self.tuning.shortest).then_some(found);
            }
        }
        None
    }

    /// The part of an increment to the present state at which the determinant has the other sign, where the overall stiffness, which
    /// was `before` at its beginning if that is known, falls towards a place between as if to pass zero there, and rises again.
    ///
    /// Loads without a potential take a stiffness away and give it back, on a straight column as well. The states looked at are
    /// interpolated, and corrected once where they are out of balance.
    pub(super) fn dipped_below(&mut self, run: &mut Run<'_>, [from, to]: [f64; 2], before: Option<f64>) -> Option<f64> {
        self.system.save(&mut self.next);
        let end = self.overall_stiffness()?;
        let begin = match before {
            Some(before) => before,
            None => {
                self.back_to_last(run.ramp, from);
                run.effort.factorizations += 1;
                self.overall_stiffness()?
            }
        };
        let mut known = vec![(0.0, begin), (1.0, end)];
        let (mut place, mut part) = (FIRST_PART, None);
        for _ in 0..self.tuning.few() {
            run.ramp.apply(&mut self.system, from + place * (to - from));
            self.system.predict(&self.last, &self.next, place - 1.0);
            let mut inertia = self.system.assemble(true);
            run.effort.factorizations += 1;
            if self.system.residual().largest() > self.tuning.near && self.system.advance(true).is_some() {
                inertia = self.system.assemble(false);
                run.effort.factorizations += 1;
            }
            if inertia.is_odd() != self.base.odd {
                part = Some(place);
                break;
            }
            known.push((place, self.overall_stiffness()?));
            known.sort_by(|a, b| a.0.total_cmp(&b.0));
            let lowest = (1..known.len() - 1).min_by(|&a, &b| known[a].1.total_cmp(&known[b].1)).unwrap_or(1);
            let Some((lower, least)) = lowest_of_parabola([known[lowest - 1], known[lowest], known[lowest + 1]]) else {
                break;
            };
            // What is not halved on the way there does not vanish.
            if least > 0.5 * known[lowest].1 || known.iter().any(|(known, _)| (known - lower).abs() <= self.tuning.near)
            {
                break;
            }
            place = lower;
        }
        self.on_to_next(run.ramp, to);
        run.effort.factorizations += 1;
        part
    }

    /// The part of an increment to the present state at which the determinant has the other sign, if there is one: two
    /// singular points lie within.
    ///
    /// Pivots are lost two at a time there, as they may be where nothing is singular: the symmetric part of the tangent has
    /// them, and the determinant of the whole tells. The states looked at are interpolated, which is near enough.
    pub(super) fn passed_twice(&mut self, run: &mut Run<'_>, [from, to]: [f64; 2]) -> Option<f64> {
        self.system.save(&mut self.next);
        let places = self.tuning.iterations;
        let mut part = None;
        for place in 1..=places {
            let s = (place as f64 - FIRST_PART) / places as f64;
            run.ramp.apply(&mut self.system, from + s * (to - from));
            self.system.predict(&self.last, &self.next, s - 1.0);
            run.effort.factorizations += 1;
            if self.system.assemble(false).is_odd() != self.base.odd {
                part = Some(s);
                break;
            }
        }
        self.on_to_next(run.ramp, to);
        run.effort.factorizations += 1;
        part
    }
}

/// Where the parabola through three points, one after the other, is lowest between the outer ones, and its value there; nothing where
/// that is at one of these.
fn lowest_of_parabola([(a, fa), (b, fb), (c, fc)]: [(f64, f64); 3]) -> Option<(f64, f64)> {
    let (left, right) = ((fb - fa) / (b - a), (fc - fb) / (c - b));
    let bend = (right - left) / (c - a);
    let lowest = 0.5 * (a + b) - 0.5 * left / bend;
    (bend > 0.0 && lowest > a && lowest < c).then_some((lowest, fa + (lowest - a) * (left + bend * (lowest - b))))
}

/// Whether the present state may lie on another path than the one that led to the last: `moved` from there by parts of the
/// network, `foreseen` to move by extrapolation (`predicted`) or else by the first increment of its iteration.
///
/// Where loads have a potential a long way alone is no sign of that, but a linear answer of more than half a turn is one always.
pub fn is_doubtful<const D: usize>(
    system: &System<D>,
    (moved, foreseen): (&[Size], &[Size]),
    predicted: bool,
    iterations: usize,
    tuning: &Tuning,
) -> bool {
    if system.moves.first_turn > HALF_A_TURN {
        return true;
    }
    let most = |sizes: &[Size]| sizes.iter().copied().fold(Size::default(), Size::join).largest();
    let (way, ahead) = (most(moved), most(foreseen));
    let missed = system.moves.first_own;
    let limit = if predicted { tuning.wrong() } else { 2.0 * tuning.trust };
    let far = missed > limit && iterations >= tuning.many && !system.hangs();
    // What comes to rest goes no other way.
    let moves = way > tuning.shortest && way > tuning.contraction * ahead;
    // A bifurcation that is not quite perfect lies where the extrapolation points to, perhaps, and the state beyond it.
    let elsewhere = predicted && moves && missed > tuning.missed * way.max(ahead);
    let leapt =
        || moved.iter().zip(foreseen).any(|(&moved, &foreseen)| is_farther(moved, foreseen, tuning.shortest, tuning));
    far || iterations > tuning.few() && (elsewhere || leapt())
}

/// Whether an iteration may have passed something on its way to the present state, where anything thrusts: of more steps than lead to
/// what lies near, or from an extrapolation that was less stable than the `negative` directions of the last state.
pub fn may_have_passed<const D: usize>(
    system: &System<D>,
    found: Convergence,
    predicted: bool,
    negative: usize,
    tuning: &Tuning,
) -> bool {
    let near = if predicted { tuning.few() } else { tuning.many };
    // What is foreseen beyond a singular point is unstable, however near, and what is found there may be stable again.
    let was_beyond = predicted && found.negative_at_first > negative;
    (found.iterations > near || was_beyond) && !system.hangs()
}

/// Whether a part of the network came to the present state another way than its path does: it `moved` from the last state in
/// another direction than the tangent of the path has where it came to, or than the path had before, or farther than it was
/// `foreseen` to and than that tangent explains.
///
/// Hinges that turn far say nothing of what lies between.
///
/// An iteration that leaps over a limit point comes out on a path that the way there crosses, or that hardly moves any more. The
/// factors are those of the present state, at this fraction of a ramp that is `step` beyond the last state; `apply` brings the
/// drives to a fraction.
pub fn came_aside<const D: usize>(
    system: &mut System<D>,
    (before, last): (Option<&State>, &State),
    (moved, foreseen): (&[Size], &[Size]),
    (found, fraction, step): (Convergence, f64, f64),
    apply: &mut dyn FnMut(&mut System<D>, f64),
    tuning: &Tuning,
) -> bool {
    if system.hinges_turned(last) > HINGE {
        return true;
    }
    if is_quick((moved, foreseen), found, tuning) {
        return false;
    }
    let way = system.relative_since(last);
    let ways = system.products_by_part(&way, &way);
    let is_far = |part: usize| ways[part][0].sqrt() > tuning.near;
    if !(0..moved.len()).any(is_far) {
        return false;
    }
    // A difference that stays within the tables of muscles.
    let ahead = tuning.rounding.sqrt() * if fraction > 0.5 { -1.0 } else { 1.0 };
    let Some(mut rate) = system.rate_motions(fraction, ahead, apply) else { return false };
    rate.iter_mut().flatten().for_each(|x| *x *= step);
    let rate = system.relative_rates(&rate);
    // Any path turns where members are bent far, and sooner in space, where axes of rotation turn too, but by no more than they are
    // bent. An iteration that was hard points to a leap where it turns less.
    let far = if D == 3 { RADIAN } else { 0.5 * RADIAN };
    let hard = found.iterations >= tuning.many;
    let turns = |[way, along, other]: [f64; 3], hard: bool| {
        let [way, other] = [way.sqrt(), other.sqrt()];
        let is_bent = way > far;
        let most = tuning.straight.acos();
        let most = match (is_bent, hard) {
            // What turns with its members turns by no more than they do.
            (true, false) => most.max(way),
            (true, true) | (false, false) => most,
            (false, true) => 0.5 * most,
        };
        other > tuning.near * way && along < most.min(PI).cos() * way * other
    };
    let at_end = system.products_by_part(&way, &rate);
    let leaves = before.map(|before| system.products_by_part(&way, &system.relative_between(before, last)));
    (0..moved.len()).filter(|&part| is_far(part)).any(|part| {
        let [way, _, end] = at_end[part];
        let farther = way.sqrt() > FARTHER * end.sqrt() && moved[part].largest() > FARTHER * foreseen[part].largest();
        farther || turns(at_end[part], hard) || leaves.as_ref().is_some_and(|leaves| turns(leaves[part], false))
    })
}

/// Whether an iteration contracted at once to about what was foreseen.
pub(super) fn is_quick((moved, foreseen): (&[Size], &[Size]), found: Convergence, tuning: &Tuning) -> bool {
    let is_as_foreseen = |(moved, foreseen): (&Size, &Size)| {
        let [moved, foreseen] = [moved, foreseen].map(|size| size.largest());
        let times = tuning.longer.sqrt();
        moved <= times * foreseen && foreseen <= times * moved
    };
    found.contraction <= CONTRACTS && moved.iter().zip(foreseen).all(is_as_foreseen)
}

/// Whether a part of the network moved much farther than its linear extrapolation, and far away: over a limit point, perhaps.
pub fn leapt((moved, foreseen): (&[Size], &[Size]), tuning: &Tuning) -> bool {
    moved.iter().zip(foreseen).any(|(&moved, &foreseen)| is_farther(moved, foreseen, tuning.near, tuning))
}

/// Whether more than `near` was moved, and much more than was foreseen.
fn is_farther(moved: Size, foreseen: Size, near: f64, tuning: &Tuning) -> bool {
    let leap = |moved: f64, foreseen: f64| moved > near && moved > tuning.longer * foreseen;
    leap(moved.displacement, foreseen.displacement.max(foreseen.rotation))
        || leap(moved.rotation, foreseen.rotation.max(foreseen.displacement))
}
