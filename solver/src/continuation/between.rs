//! What lies between the ends of an increment that was hard to make.
//!
//! Both of its ends may be stable, and each the next state of some path, while no path joins them: an iteration that passes a limit
//! point comes out on a path that the way there crosses. What tells is what lies between. The state at the end of an increment and
//! its rate there, with the state before its beginning, or the rate there, say by a cubic where the path is half way. A smooth path
//! is there to fourth order in the length; one that is not, swings between, or is two.
//!
//! Theory: docs/theory/continuation.md, section By the fraction.

use super::follow::Run;
use super::{Continuation, Tuning};
use crate::chain::Size;
use crate::system::{State, System};

/// An increment of a path: the state that it began at, and the one before that with how many times as far it went, where there is one to
/// extrapolate from; the fractions of its ramp that it joins; and the directions in which the state at its beginning is unstable.
pub struct Between<'a> {
    /// The state that it began at.
    pub last: &'a State,
    /// The state before that, and the ratio of this increment to the one that led from there.
    pub before: Option<(&'a State, f64)>,
    /// Fractions of the ramp at both ends.
    pub ends: [f64; 2],
    /// Directions in which the state that it began at is unstable.
    pub negative: usize,
}

/// Brings the drives of a system to a fraction of a ramp.
type Apply<'a, const D: usize> = &'a mut dyn FnMut(&mut System<D>, f64);

impl Between<'_> {
    /// Factorizations that [`Self::swings`] takes.
    const fn factorizations(&self) -> usize {
        if self.before.is_some() { 2 } else { 3 }
    }

    /// Whether what lies half way to the present state is not on a path that joins both ends: one step of an iteration leads a part
    /// of the network far from where a cubic says that it is, or a motion has lost its stiffness there that has some at both ends, one
    /// that `lost_aside` counts among them.
    ///
    /// The iteration came to rest, but by more steps than lead to what lies near. The factors of the end would not do for the middle:
    /// what is stiff turns with its members.
    pub fn swings<const D: usize>(
        &self,
        system: &mut System<D>,
        apply: Apply<'_, D>,
        lost_aside: &mut dyn FnMut(&mut System<D>) -> usize,
        tuning: &Tuning,
    ) -> bool {
        let moved = system.distances(self.last);
        if moved.iter().all(|moved| moved.largest() <= tuning.shortest) {
            return false;
        }
        let [from, to] = self.ends;
        let next = system.snapshot();
        let seen = self.state_between(system, &next, apply, tuning).map(|cubic| {
            system.restore(&cubic);
            apply(system, 0.5 * (from + to));
            system.follow_carried_forces();
            let own = system.assemble(true).negative > self.negative;
            let lost = own || lost_aside(system) > 0;
            let stepped = system.advance(true).is_some();
            let apart = system.distances(&cubic);
            let far = |(apart, moved): (&Size, &Size)| {
                // The negation catches a NaN too.
                moved.largest() > tuning.shortest && !(apart.largest() <= tuning.swing * moved.largest())
            };
            #[cfg(feature = "trace")]
            eprintln!("between {from} and {to}: {apart:?} of {moved:?}, lost {lost}");
            lost || !stepped || apart.iter().zip(&moved).any(far)
        });
        system.restore(&next);
        apply(system, to);
        system.assemble(false);
        seen == Some(true)
    }

    /// Where the path is half way to the present state `next`, by the cubic through both ends with their rates, or with that of the
    /// second and the state before the first.
    fn state_between<const D: usize>(
        &self,
        system: &mut System<D>,
        next: &State,
        apply: Apply<'_, D>,
        tuning: &Tuning,
    ) -> Option<State> {
        let [from, to] = self.ends;
        let middle = 0.5 * (from + to);
        // A rate is a difference over a part of the way: small against what bends on it, and large against what an iteration leaves of
        // its residual.
        let part = tuning.near;
        let onward = |system: &mut System<D>, apply: Apply<'_, D>, at: f64| {
            apply(system, at + part * (middle - at));
            system.refresh(true);
            system.advance(true)?;
            Some(system.snapshot())
        };
        let ahead = onward(system, apply, to)?;
        let here;
        // Multiples of the ways from the last state to the next, to the last from what is known there, and along the rate.
        let (known, times) = match self.before {
            Some((known, ratio)) => {
                let before = 1.0 / ratio;
                let share = (0.5 + before) / (2.0 * (1.0 + before));
                let bend = (0.5 * share - 0.25) / (1.0 + before);
                (known, [-0.5 + 0.5 * share + bend, -bend / before, share / part])
            }
            None => {
                system.restore(self.last);
                apply(system, from);
                system.assemble(false);
                here = onward(system, apply, from)?;
                (&here, [-0.5, -0.25 / part, 0.25 / part])
            }
        };
        apply(system, middle);
        system.combine([known, self.last, next, &ahead], times);
        Some(system.snapshot())
    }
}

impl<const D: usize> Continuation<'_, D> {
    /// Whether what lies half way between the last state and the present one, at these fractions, is not on a path that joins them.
    /// `ratio` is that of the increment to the one before, where there is one to extrapolate from.
    pub(super) fn swings_between(&mut self, run: &mut Run<'_>, ends: [f64; 2], ratio: Option<f64>) -> bool {
        let before = ratio.map(|ratio| (&self.before, ratio));
        let between = Between { last: &self.last, before, ends, negative: self.base.own };
        let (known, lateral) = (self.base.lateral, &mut self.lateral);
        let mut lost_aside = |system: &mut System<D>| {
            let found = lateral.as_mut().map(|lateral| lateral.inertia(system));
            found.filter(|(_, potential)| *potential).map_or(0, |(inertia, _)| inertia.negative.saturating_sub(known))
        };
        let mut apply = |system: &mut System<D>, fraction: f64| run.ramp.apply(system, fraction);
        let swings = between.swings(&mut self.system, &mut apply, &mut lost_aside, &self.tuning);
        run.effort.factorizations += between.factorizations();
        swings
    }
}
