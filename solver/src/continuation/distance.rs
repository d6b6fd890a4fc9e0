//! Equilibria at a distance along a path.
//!
//! A path is measured by a functional n of the motion since a saved state and of the fraction of the ramp; Newton's
//! iteration solves for both with the bordered matrix, by two solutions with one factorization (Riks, Int. J. Solids
//! Struct. 15, 1979; Keller 1977).
//!
//! Theory: docs/theory/continuation.md, Eq. 8.2.

use super::Tuning;
use super::direction::Direction;
use super::ramp::Ramp;
use crate::newton::{Lost, Newton, Start, Unknowns};
use crate::system::{Inertia, Linearized, Residual, State, System};

/// An equilibrium on a path.
#[derive(Clone, Debug)]
pub(super) struct Point {
    pub fraction: f64,
    /// Its distance, as it was asked for.
    pub distance: f64,
    pub iterations: usize,
    pub inertia: Inertia,
    pub residual: Residual,
    /// Motion of the joints for a unit of the fraction.
    pub rate: Vec<[f64; 6]>,
    /// What the functional grows by for a unit of the fraction: without bound at a limit point.
    pub gain: f64,
}

impl Point {
    /// Change of the fraction for a unit of the functional: zero at a limit point.
    pub(super) fn rate_of_fraction(&self) -> f64 {
        1.0 / self.gain
    }
}

/// The state and the fraction, at a distance along a path.
struct AtDistance<'a> {
    ramp: &'a Ramp,
    /// Where distances are measured from, its fraction, and the functional that measures them.
    origin: (&'a State, f64),
    functional: &'a Direction,
    distance: f64,
    fraction: f64,
    /// Distance of the fractions whose difference stands for the derivative: rounding and curvature cost as much of it.
    ahead: f64,
    linearized: Linearized,
    is_solved: bool,
    gain: f64,
    /// What a change of the fraction does between the ends of members follows an iteration later.
    changed: f64,
}

impl<const D: usize> Unknowns<D> for AtDistance<'_> {
    fn linearize(&mut self, system: &mut System<D>, _: bool) -> Inertia {
        (self.linearized, self.is_solved) = linearize(system, self.ramp, self.fraction, self.ahead);
        self.gain = self.functional.along(&self.linearized.rate_motions, 1.0);
        self.linearized.inertia
    }

    fn are_settled(&self, tuning: &Tuning) -> bool {
        self.changed <= tuning.rounding
    }

    fn advance(&mut self, system: &mut System<D>) -> Option<f64> {
        let (origin, from) = self.origin;
        let gap = self.functional.along(&system.seen_since(origin), self.fraction - from) - self.distance;
        let change = -(gap + self.functional.along(&self.linearized.step_motions, 0.0)) / self.gain;
        if !self.is_solved || !change.is_finite() {
            return None;
        }
        let mut solution = std::mem::take(&mut self.linearized.step);
        for (x, rate) in solution.iter_mut().zip(&self.linearized.rate) {
            *x += change * rate;
        }
        self.fraction += change;
        self.changed = change.abs();
        system.loading.fraction = self.fraction;
        system.pattern.equations.update(&system.topology, &system.places.joints, self.fraction, true);
        if self.functional.motions.len() > system.places.joints.len() {
            // What members between joints that do not move do by the change of the fraction belongs to this increment: near a singular
            // tangent it is as large as what they do at the old one, and takes it back.
            self.ramp.apply(system, self.fraction);
            system.gather(true);
        }
        Some(system.move_by(&solution, true).largest().max(change.abs()))
    }
}

fn linearize<const D: usize>(system: &mut System<D>, ramp: &Ramp, fraction: f64, ahead: f64) -> (Linearized, bool) {
    // A difference that stays within the tables of muscles.
    let ahead = if fraction > 0.5 { -ahead } else { ahead };
    system.linearize(fraction, ahead, &mut |system: &mut System<D>, fraction: f64| ramp.apply(system, fraction))
}

/// What finds points of a path between two saved states.
pub(super) struct Locator<'a, const D: usize> {
    pub system: &'a mut System<D>,
    /// The state that distances are measured from, and one ahead.
    pub last: &'a State,
    pub next: &'a State,
    pub newton: Newton,
    pub ramp: &'a Ramp,
    /// Factorizations so far.
    pub factorizations: usize,
}

impl<const D: usize> Locator<'_, D> {
    fn ahead(&self) -> f64 {
        self.newton.tuning.rounding.sqrt()
    }

    /// The path's direction at the present state, which is an equilibrium: motion of the joints for a unit of the
    /// fraction.
    pub(crate) fn rate(&mut self, fraction: f64) -> Option<Vec<[f64; 6]>> {
        if self.is_misled() {
            return self.rate_as_stiff_as_it_is(fraction);
        }
        let ahead = self.ahead();
        let (linearized, solved) = linearize(self.system, self.ramp, fraction, ahead);
        self.factorizations += 1;
        solved.then_some(linearized.rate_motions)
    }

    /// Whether the tangent is that of eased strains, and tells another direction of the path: members between joints that do not move
    /// hang by the stretch that is eased, and a taut thread sags by its tangent 1.6 times as fast as in truth.
    fn is_misled(&self) -> bool {
        self.system.loading.auxiliary.eases() && !self.system.out_of_sight().is_empty()
    }

    /// The path's direction by the tangent of strains as stiff as they are.
    fn rate_as_stiff_as_it_is(&mut self, fraction: f64) -> Option<Vec<[f64; 6]>> {
        let (ahead, ramp) = (self.ahead(), self.ramp);
        let (linearized, solved) = self.system.uneased(|system| linearize(system, ramp, fraction, ahead));
        // One with these strains, one for the linearization, and one to come back.
        self.factorizations += 3;
        solved.then_some(linearized.rate_motions)
    }

    /// Brings the present state to the equilibrium at the distance `s`, measured by `n`, from the last saved one.
    ///
    /// `from` is the fraction of the saved state, `guess` that of the present one.
    pub(crate) fn correct(&mut self, n: &Direction, s: f64, from: f64, guess: f64) -> Result<Point, Lost> {
        let mut unknowns = AtDistance {
            ramp: self.ramp,
            origin: (self.last, from),
            functional: n,
            distance: s,
            fraction: guess,
            ahead: self.ahead(),
            linearized: Linearized::default(),
            is_solved: false,
            gain: 0.0,
            changed: f64::INFINITY,
        };
        let outcome = self.newton.solve_for(self.system, Start::nearby(), &mut unknowns);
        self.factorizations += outcome.as_ref().map_or_else(|lost| lost.factorizations, |found| found.factorizations);
        let found = outcome?;
        let AtDistance { fraction, linearized, mut gain, .. } = unknowns;
        let mut rate = linearized.rate_motions;
        if self.is_misled()
            && let Some(stiff) = self.rate_as_stiff_as_it_is(fraction)
        {
            gain = n.along(&stiff, 1.0);
            rate = stiff;
        }
        Ok(Point {
            fraction,
            distance: s,
            iterations: found.iterations,
            inertia: found.inertia,
            residual: found.residual,
            rate,
            gain,
        })
    }
}
