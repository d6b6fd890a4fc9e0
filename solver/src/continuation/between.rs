//! What lies between the ends of an increment that was hard to make.
//!
//! Both of its ends may be stable, and each the next state of some path, while no path joins them: an iteration that passes a limit
//! point comes out on a path that the way there crosses. What tells is what lies between. The state at the end of an increment and
//! its rate there, with the state before its beginning, or the rate there, say by a cubic where the path is half way. A smooth path
//! is there to fourth order in the length; one that is not, swings between, or is two.
//!
//! Theory: docs/theory/continuation.md, section By the fraction.

use super::follow::Run;
use super::passage::Passage;
use super::ramp::Ramp;
use super::{Continuation, Tuning};
use crate::chain::Size;
use crate::newton::{Aside, Convergence};
use crate::system::{State, System};

/// What a look half way found.
pub(super) struct Looked {
    /// The parts that are not on a path that joins both ends.
    pub swinging: Vec<usize>,
    /// Factorizations that it took.
    pub factorizations: usize,
}

impl Passage<'_> {
    /// The parts of which what lies half way is not on a path that joins both ends: an iteration leads them far from where a cubic says
    /// that they are. All parts where it does not settle, or where a motion has lost its stiffness there that has some at both ends, one
    /// that `lost_aside` counts among them.
    ///
    /// The iteration came to rest, but by more steps than lead to what lies near. The factors of the end would not do for the middle:
    /// what is stiff turns with its members.
    pub(super) fn parts_that_swing<const D: usize>(
        &self,
        system: &mut System<D>,
        lost_aside: Aside<'_, D>,
        tuning: &Tuning,
    ) -> Looked {
        let moved = system.distances(self.last);
        let Some(ramp) = self.ramp.filter(|_| moved.iter().any(|moved| moved.largest() > tuning.shortest)) else {
            return Looked { swinging: Vec::new(), factorizations: 0 };
        };
        // The end once more, and the beginning where nothing is known of the path before.
        let mut factorizations = if self.before.is_some() { 1 } else { 2 };
        let [from, to] = self.ends;
        let next = system.snapshot();
        let swinging = self.state_between(system, &next, ramp, tuning).map(|cubic| {
            system.restore(&cubic);
            ramp.apply(system, 0.5 * (from + to));
            system.follow_carried_forces();
            let own = system.assemble(true).negative > self.negative;
            let lost = own || lost_aside(system) > 0;
            let (settled, steps) = settle(system, &cubic, &moved, tuning);
            factorizations += steps;
            let apart = system.distances(&cubic);
            #[cfg(feature = "trace")]
            eprintln!("between {from} and {to}: {apart:?} of {moved:?}, lost {lost}");
            let far = |part: &usize| {
                // The negation catches a NaN too.
                let [moved, apart] = [&moved, &apart].map(|sizes: &Vec<Size>| sizes[*part].largest());
                moved > tuning.shortest && !(apart <= self.most_swing(tuning) * moved)
            };
            let all = 0..moved.len();
            if lost || !settled { all.collect() } else { all.filter(far).collect() }
        });
        system.restore(&next);
        ramp.apply(system, to);
        system.assemble(false);
        Looked { swinging: swinging.unwrap_or_default(), factorizations }
    }

    /// Where the path is half way to the present state `next`, by the cubic through both ends with their rates, or with that of the
    /// second and the state before the first.
    fn state_between<const D: usize>(
        &self,
        system: &mut System<D>,
        next: &State,
        ramp: &Ramp,
        tuning: &Tuning,
    ) -> Option<State> {
        let [from, to] = self.ends;
        let middle = 0.5 * (from + to);
        // A rate is a difference over a part of the way: small against what bends on it, and large against what an iteration leaves of
        // its residual.
        let part = tuning.near;
        let onward = |system: &mut System<D>, at: f64| {
            ramp.apply(system, at + part * (middle - at));
            system.refresh(true);
            system.advance(true)?;
            Some(system.snapshot())
        };
        let ahead = onward(system, to)?;
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
                ramp.apply(system, from);
                system.assemble(false);
                here = onward(system, from)?;
                (&here, [-0.5, -0.25 / part, 0.25 / part])
            }
        };
        ramp.apply(system, middle);
        system.combine([known, self.last, next, &ahead], times);
        Some(system.snapshot())
    }
}

/// Iterates from a state half way, linearized, to the equilibrium that is near it, until a move is small beside how far each part `moved`
/// over the whole way; whether it comes to rest so, and by how many factorizations. One step is enough beside a smooth path, and says
/// little of how far an equilibrium is that lies on another one.
fn settle<const D: usize>(system: &mut System<D>, from: &State, moved: &[Size], tuning: &Tuning) -> (bool, usize) {
    let is_small = |by: &[Size]| {
        by.iter().zip(moved).all(|(by, moved)| by.largest() <= tuning.near * moved.largest().max(tuning.shortest))
    };
    let steps = 1 + tuning.few();
    let mut before = None;
    for step in 1..=steps {
        if step > 1 {
            before = Some(system.snapshot());
            system.assemble(true);
        }
        if system.advance(true).is_none() {
            return (false, step);
        }
        if is_small(&system.distances(before.as_ref().unwrap_or(from))) {
            return (true, step);
        }
    }
    (false, steps)
}

impl<const D: usize> Continuation<'_, D> {
    /// Whether what lies half way between the last state and the present one, at these fractions, is not on a path that joins them.
    /// `ratio` is that of the increment to the one before, where there is one to extrapolate from.
    pub(super) fn swings_between(
        &mut self,
        run: &mut Run<'_>,
        ends: [f64; 2],
        ratio: Option<f64>,
        (found, softens): (Convergence, bool),
        (moved, foreseen): (&[Size], &[Size]),
    ) -> bool {
        let before = ratio.map(|ratio| (&self.before, ratio));
        // Without a potential pivots are lost and come back where nothing is singular.
        let negative = if run.conservative { self.base.own } else { usize::MAX };
        let (last, ramp) = (&self.last, Some(run.ramp));
        let from_rest = self.began_at_rest();
        let passage = Passage { last, before, ramp, ends, from_rest, negative, softens, found, moved, foreseen };
        let (known, lateral) = (self.base.lateral, &mut self.lateral);
        let mut lost_aside = |system: &mut System<D>| {
            let found = lateral.as_mut().map(|lateral| lateral.inertia(system));
            found.filter(|(_, potential)| *potential).map_or(0, |(inertia, _)| inertia.negative.saturating_sub(known))
        };
        let looked = passage.parts_that_swing(&mut self.system, &mut lost_aside, &self.tuning);
        run.effort.factorizations += looked.factorizations;
        !looked.swinging.is_empty()
    }
}
