//! What lies between the ends of an increment that was hard to make.
//!
//! Both of its ends may be stable, and each the next state of some path, while no path joins them: an iteration that passes a limit
//! point comes out on a path that the way there crosses. What tells is what lies between. The state at the end of an increment and
//! its rate there, with the state before its beginning, or the rate there, say by a cubic where the path is half way. A smooth path
//! is there to fourth order in the length; one that is not, swings between, or is two.
//!
//! Theory: docs/theory/continuation.md, section By the fraction.

use super::Continuation;
use super::follow::Run;
use crate::system::State;

impl<const D: usize> Continuation<'_, D> {
    /// Whether what lies half way between the last state and the present one, at these fractions, is not on a path that joins them: one
    /// step of an iteration leads far from where a cubic says that it is, or a motion has lost its stiffness there that has some at
    /// both ends. `ratio` is that of the increment to the one before, where there is one to extrapolate from.
    ///
    /// The iteration came to rest, but by more steps than lead to what lies near. The factors of the end would not do for the middle:
    /// what is stiff turns with its members.
    pub(super) fn swings_between(&mut self, run: &mut Run<'_>, [from, to]: [f64; 2], ratio: Option<f64>) -> bool {
        let moved = self.system.distance(&self.last).largest();
        if moved <= self.tuning.shortest {
            return false;
        }
        let middle = 0.5 * (from + to);
        self.system.save(&mut self.next);
        let seen = self.state_between(run, [from, to], ratio).map(|cubic| {
            self.system.restore(&cubic);
            run.ramp.apply(&mut self.system, middle);
            self.system.follow_carried_forces();
            let own = self.system.assemble(true).negative > self.base.own;
            run.effort.factorizations += 1;
            let known = self.base.lateral;
            let aside = self.lateral.as_mut().is_some_and(|lateral| {
                let (inertia, potential) = lateral.inertia(&mut self.system);
                potential && inertia.negative > known
            });
            let apart = self.system.advance(true).map_or(f64::INFINITY, |moves| moves.largest());
            #[cfg(feature = "trace")]
            eprintln!("between {from} and {to}: {:.2e} of {moved:.2e}, lost {own} {aside}", apart / moved);
            own || aside || !(apart <= self.tuning.swing * moved)
        });
        self.on_to_next(run.ramp, to);
        run.effort.factorizations += 1;
        seen == Some(true)
    }

    /// Where the path is half way between the states `last` and `next`, the present one, by the cubic through both with their rates, or
    /// with that of the second and the state before the first.
    fn state_between(&mut self, run: &mut Run<'_>, [from, to]: [f64; 2], ratio: Option<f64>) -> Option<State> {
        let middle = 0.5 * (from + to);
        // A rate is a difference over a part of the way: small against what bends on it, and large against what an iteration leaves of
        // its residual.
        let part = self.tuning.near;
        let onward = |path: &mut Self, at: f64| {
            run.ramp.apply(&mut path.system, at + part * (middle - at));
            path.system.refresh(true);
            path.system.advance(true)?;
            Some(path.system.snapshot())
        };
        let ahead = onward(self, to)?;
        // Multiples of the ways from the last state to the next, to the last from what is known there, and along the rate.
        let (known, times) = match ratio {
            Some(ratio) => {
                let before = 1.0 / ratio;
                let share = (0.5 + before) / (2.0 * (1.0 + before));
                let bend = (0.5 * share - 0.25) / (1.0 + before);
                (None, [-0.5 + 0.5 * share + bend, -bend / before, share / part])
            }
            None => {
                self.back_to_last(run.ramp, from);
                run.effort.factorizations += 1;
                (Some(onward(self, from)?), [-0.5, -0.25 / part, 0.25 / part])
            }
        };
        run.ramp.apply(&mut self.system, middle);
        let known = known.as_ref().unwrap_or(&self.before);
        self.system.combine([known, &self.last, &self.next, &ahead], times);
        Some(self.system.snapshot())
    }
}
