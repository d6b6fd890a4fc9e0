//! Passages from one equilibrium to another, and what tells that no path joins them.
//!
//! An iteration comes to rest at some equilibrium. That it is the one that follows on the path of the last is seen by how far it is
//! from where it was foreseen, by how hard it was to find, by the tangents of the path at both ends, and by what lies half way
//! (`between.rs`). Where loads have a potential, a rise of the count of negative pivots tells besides.
//!
//! Each part of a network is judged for itself: one that leaps may move less than another that does not.
//!
//! Theory: docs/theory/continuation.md, section By the fraction.

use std::f64::consts::PI;

use super::Tuning;
use super::ramp::Ramp;
use crate::chain::Size;
use crate::newton::{Aside, Convergence};
use crate::system::{Answer, State, System};

/// A way over those that the tangents at both ends make of a passage: where the rate of a path rises, or falls, all along, its way
/// is between them.
const FARTHER: f64 = 1.5;
/// Contraction of an iteration whose first increment says where it leads: all that follow move it by about as much as this part of
/// that one (Deuflhard, Newton Methods for Nonlinear Problems, 2004, sec. 2.1).
const CONTRACTS: f64 = 0.05;
/// Times the part of an increment by which the state half way may miss the cubic, for one that begins where nothing is known of the path before:
/// such a one is as long as the ramp, as a rule, and none that extrapolation foresaw. Pennate dyads that are inflated at once miss it by
/// up to 0.16 on one path.
const AT_FIRST: f64 = 2.0;
/// An angle (radians) by which a hinge turns in one increment at most, a sixth of a right one: bars that are hinged pass dead centres,
/// and windows without a stable state, that neither end of a longer increment tells of.
const HINGE: f64 = PI / 12.0;
/// An angle (radians) by which the linear answer to an increment turns anything at most: beyond half a turn its rotation vectors do not
/// say any more which way it went.
pub(super) const HALF_A_TURN: f64 = PI;
/// A rotation (radians) after which pivots may be lost, and iterations be many, on any path.
pub(super) const RADIAN: f64 = 1.0;

/// A passage from one equilibrium to the present state, another one that an iteration found.
pub struct Passage<'a> {
    /// The state that it began at.
    pub last: &'a State,
    /// The state before that, and how many times as far this passage goes as that from there, where it began at an extrapolation.
    pub before: Option<(&'a State, f64)>,
    /// What it goes along; `None` where more than the values of a ramp is another now, which leaves nothing to say of what lies
    /// between.
    pub ramp: Option<&'a Ramp>,
    /// Fractions of the ramp at both ends.
    pub ends: [f64; 2],
    /// Whether that ramp begins at the unloaded network.
    pub from_rest: bool,
    /// Directions in which the state that it began at is unstable.
    pub negative: usize,
    /// Whether the network became softer on the way to the state that it began at, or much stiffer since: there may be a limit point
    /// between, and other paths that come near it.
    pub softens: bool,
    /// The iteration.
    pub found: Convergence,
    /// How far every part of the network moved, in radians or lengths of a member.
    pub moved: &'a [Size],
    /// How far it was foreseen to, likewise: by the extrapolation, or else by the first increment of the iteration.
    pub foreseen: &'a [Size],
}

/// What becomes of a passage: how the network answers at its end, where members can turn against each other; or the parts of it that may
/// have come to another path than the one that they were on, all of them where nothing tells which.
pub type Verdict = Result<Option<Answer>, Vec<usize>>;

impl Passage<'_> {
    /// Whether the passage is to be believed, from a state at which the network `answered` so, with the same rows held. `lost_aside` counts
    /// motions that lose their stiffness beside those of the tangent.
    ///
    /// # Errors
    /// With the parts that are not to be believed.
    pub fn judge<const D: usize>(
        &self,
        system: &mut System<D>,
        answered: Option<&Answer>,
        lost_aside: Aside<'_, D>,
        tuning: &Tuning,
    ) -> Verdict {
        let none_of = |parts: Vec<usize>| if parts.is_empty() { Ok(()) } else { Err(parts) };
        none_of(self.parts().filter(|&part| self.part_leapt(part, tuning.near, tuning)).collect())?;
        let blind = self.ramp.is_none() && self.found.iterations > tuning.few();
        if blind || self.is_doubtful(system, tuning) {
            return Err(self.parts().collect());
        }
        if self.ramp.is_some() && self.may_have_passed(system, tuning) {
            if self.is_too_hard(tuning) {
                return Err(self.parts().collect());
            }
            none_of(self.parts_that_swing(system, lost_aside, tuning).swinging)?;
        }
        none_of(self.parts_aside(system, tuning))?;
        let answer = system.answer_of_hinged();
        if let (Some(before), Some(after)) = (answered, &answer) {
            // What turns over passes a singular state, or comes to another path (`touching.rs`).
            none_of(before.parts_turned_over(after))?;
        }
        Ok(answer)
    }

    /// The numbers of all parts.
    fn parts(&self) -> std::ops::Range<usize> {
        0..self.moved.len()
    }

    /// Whether a part of the network moved much farther than its linear extrapolation, and far away: over a limit point, perhaps.
    pub(super) fn leapt(&self, tuning: &Tuning) -> bool {
        self.parts().any(|part| self.part_leapt(part, tuning.near, tuning))
    }

    /// Whether a part moved by more than `near`, and much more than was foreseen.
    fn part_leapt(&self, part: usize, near: f64, tuning: &Tuning) -> bool {
        let (moved, foreseen) = (self.moved[part], self.foreseen[part]);
        let leap = |moved: f64, foreseen: f64| moved > near && moved > tuning.longer * foreseen;
        leap(moved.displacement, foreseen.displacement.max(foreseen.rotation))
            || leap(moved.rotation, foreseen.rotation.max(foreseen.displacement))
    }

    /// Whether the present state may lie on another path by how far away it is from where it was foreseen, and how hard to find.
    ///
    /// Where loads have a potential a long way alone is no sign of that, but a linear answer of more than half a turn is one always.
    pub(super) fn is_doubtful<const D: usize>(&self, system: &System<D>, tuning: &Tuning) -> bool {
        if system.moves.first_turn > HALF_A_TURN {
            return true;
        }
        let most = |sizes: &[Size]| sizes.iter().copied().fold(Size::default(), Size::join).largest();
        let (way, ahead) = (most(self.moved), most(self.foreseen));
        let (predicted, iterations) = (self.before.is_some(), self.found.iterations);
        let missed = system.moves.first_own;
        let limit = if predicted { tuning.wrong() } else { 2.0 * tuning.trust };
        let far = missed > limit && iterations >= tuning.many && !system.hangs();
        // What comes to rest goes no other way.
        let moves = way > tuning.shortest && way > tuning.contraction * ahead;
        // A bifurcation that is not quite perfect lies where the extrapolation points to, perhaps, and the state beyond it.
        let elsewhere = predicted && moves && missed > tuning.missed * way.max(ahead);
        let leapt = || self.parts().any(|part| self.part_leapt(part, tuning.shortest, tuning));
        far || iterations > tuning.few() && (elsewhere || leapt())
    }

    /// Whether the iteration may have passed something on its way: of more steps than lead to what lies near, or from an extrapolation that
    /// was less stable than the last state, or farther away than it was to be.
    ///
    /// A tree that a single joint holds has nothing to pass where loads grow on it from none: it bends their way. What was bent before may
    /// snap back.
    pub(super) fn may_have_passed<const D: usize>(&self, system: &System<D>, tuning: &Tuning) -> bool {
        let is_off = self.before.is_some() && system.moves.first_own > tuning.miss;
        let is_hard = self.found.iterations > tuning.few() || is_off || self.began_beyond();
        is_hard && !(self.from_rest && system.hangs())
    }

    /// Whether an extrapolation of a network that softens led to the present state by more steps than can be believed from one, whatever
    /// lies half way.
    pub(super) fn is_too_hard(&self, tuning: &Tuning) -> bool {
        self.softens && self.before.is_some() && self.found.iterations >= tuning.many
    }

    /// The part of its way by which a part of the network may miss the cubic half way.
    pub(super) fn most_swing(&self, tuning: &Tuning) -> f64 {
        if self.before.is_some() || self.softens { tuning.swing } else { AT_FIRST * tuning.swing }
    }

    /// Whether the extrapolation was less stable than the last state: what is foreseen beyond a singular point is unstable, however near,
    /// and what is found there may be stable again.
    pub(super) fn began_beyond(&self) -> bool {
        self.before.is_some() && self.found.negative_at_first > self.negative
    }

    /// Whether the iteration contracted at once to about what was foreseen.
    pub(super) fn is_quick(&self, tuning: &Tuning) -> bool {
        let is_as_foreseen = |(moved, foreseen): (&Size, &Size)| {
            let [moved, foreseen] = [moved, foreseen].map(|size| size.largest());
            let times = tuning.longer.sqrt();
            moved <= times * foreseen && foreseen <= times * moved
        };
        self.found.contraction <= CONTRACTS && self.moved.iter().zip(self.foreseen).all(is_as_foreseen)
    }

    /// The parts that came to the present state another way than their path does: they moved from the last state in another direction
    /// than the tangent of the path has where they came to, or than the path had before, or farther than foreseen and than that
    /// tangent explains.
    ///
    /// Hinges that turn far say nothing of what lies between.
    ///
    /// An iteration that leaps over a limit point comes out on a path that the way there crosses, or that hardly moves any more. The
    /// factors are those of the present state.
    pub(super) fn parts_aside<const D: usize>(&self, system: &mut System<D>, tuning: &Tuning) -> Vec<usize> {
        let hinged = system.hinges_turned(self.last);
        if hinged.iter().any(|&turned| turned > HINGE) {
            return self.parts().filter(|&part| hinged[part] > HINGE).collect();
        }
        if self.is_quick(tuning) {
            return Vec::new();
        }
        let Some(ramp) = self.ramp else { return Vec::new() };
        let way = system.relative_since(self.last);
        let ways = system.products_by_part(&way, &way);
        let is_far = |part: usize| ways[part][0].sqrt() > tuning.near;
        if !self.parts().any(is_far) {
            return Vec::new();
        }
        // A difference that stays within the tables of muscles.
        let [from, to] = self.ends;
        let ahead = tuning.rounding.sqrt() * if to > 0.5 { -1.0 } else { 1.0 };
        let mut apply = |system: &mut System<D>, fraction: f64| ramp.apply(system, fraction);
        let Some(mut rate) = system.rate_motions(to, ahead, &mut apply) else { return Vec::new() };
        rate.iter_mut().flatten().for_each(|x| *x *= to - from);
        let rate = system.relative_rates(&rate);
        // Any path turns where members are bent far, and sooner in space, where axes of rotation turn too, but by no more than they are
        // bent. An iteration that was hard points to a leap where it turns less.
        let far = if D == 3 { RADIAN } else { 0.5 * RADIAN };
        let hard = self.found.iterations >= tuning.many;
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
        let before =
            self.before.map(|(before, _)| system.products_by_part(&way, &system.relative_between(before, self.last)));
        let came_aside = |&part: &usize| {
            let [way, _, end] = at_end[part];
            let farther = way.sqrt() > FARTHER * end.sqrt()
                && self.moved[part].largest() > FARTHER * self.foreseen[part].largest();
            farther || turns(at_end[part], hard) || before.as_ref().is_some_and(|before| turns(before[part], false))
        };
        self.parts().filter(|&part| is_far(part)).filter(came_aside).collect()
    }
}
