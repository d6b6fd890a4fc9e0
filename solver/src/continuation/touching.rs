//! Where a path touches a singular state and goes on with the same stability: the change point of a linkage.
//!
//! Bars that come into one line carry nothing across it, and from there two ways go on. What resists the motion that leads from the one
//! to the other is the square of how far the bars are from that line, so no pivot changes its sign. The forces by which members
//! carry a load do: they pass infinity. Bars that miss the line by a little have two paths that come near each other and
//! part again; each keeps to its side, so that an increment after which these forces are the opposite ones changed over.
//!
//! Theory: docs/theory/stability.md, Eq. 7.11.

use super::Continuation;
use super::follow::Run;
use super::locate::{Root, Value};
use crate::history::Note;
use crate::newton::Start;
use crate::system::{Answer, System};

/// Halvings of an increment after which members that still change over to opposite forces do so at one place: what carries a load in
/// another way because the network has turned does so on all of the way.
const HALVINGS: usize = 4;
/// Part of what they were, at most, that forces are on both sides of a place where they vanish, after so many halvings: an eighth where they
/// go evenly.
const VANISHES: f64 = 0.5;
/// Part of what forces are at the ends of an increment that is infinite beside them: bars that come into one line have 2e4 times as
/// much for what rounding leaves of them, and such that miss it by 1e-10 of their length 3e3.
const INFINITE: f64 = 1e4;

/// What lies between two states of a path whose members carry a load by opposite forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Between {
    /// Nothing but states at which they vanish.
    Nothing,
    /// States at which they turn bit by bit, as far as an increment of this length tells.
    Turned,
    /// A singular state, at this fraction: the path touches another one.
    Touched(f64),
    /// No state, at this fraction: the two lie on different paths, as far as an increment of this length tells.
    Leapt(f64),
}

impl<const D: usize> Continuation<'_, D> {
    /// What lies between the last state and the present one, at these fractions, that are of equal stability and answer so.
    pub(super) fn seen_between(&mut self, run: &mut Run<'_>, ends: [f64; 2], answers: [&Option<Answer>; 2]) -> Between {
        let [Some(before), Some(after)] = answers else { return Between::Nothing };
        // What goes from one way of carrying a load to the opposite one passes nothing, or infinity.
        if before.parts_unlike(after).is_empty() {
            return Between::Nothing;
        }
        self.system.save(&mut self.next);
        let between = self.look_between(run, ends, [before, after]);
        self.on_to_next(run.ramp, ends[1]);
        run.effort.factorizations += 1;
        between
    }

    /// Notes a singular state that the path touched at this fraction.
    pub(super) fn note_touched(&self, run: &mut Run<'_>, fraction: f64) {
        let is_known = |note: &Note| match note {
            Note::TouchedSingular { fraction: known } => (known - fraction).abs() <= self.tuning.shortest,
            _ => false,
        };
        if run.is_step && !run.record.notes.iter().any(is_known) {
            run.record.notes.push(Note::TouchedSingular { fraction });
        }
    }

    /// What lies between the states `last` and `next`.
    fn look_between(&mut self, run: &mut Run<'_>, ends: [f64; 2], answers: [&Answer; 2]) -> Between {
        let guess = match self.changes_over(run, ends, answers) {
            Ok(guess) => guess,
            Err(between) => return between,
        };
        let beyond = answers[1];
        let softness = |system: &mut System<D>| system.answer().map(|answer| 1.0 / answer.like(beyond));
        let mut locator = self.locator(run.ramp);
        let mut most = 0;
        let root = locator.root(ends, None, Value::Smooth, &mut |system, point| {
            most = point.inertia.negative.max(most);
            let softness = softness(system);
            (softness.is_none_or(|softness| softness < 0.0), softness)
        });
        run.effort.factorizations += locator.factorizations;
        // A path that loses its stability there, or on which the ramp turns back, comes to the second state by a longer way.
        let beside = self.tuning.shortest * (ends[1] - ends[0]).abs();
        let [low, high] = [ends[0].min(ends[1]) - beside, ends[0].max(ends[1]) + beside];
        let own = self.base.own;
        let goes_on = |root: &Root| (low..=high).contains(&root.fraction) && root.beyond.unwrap_or(most) <= own;
        let Some(root) = root.filter(goes_on) else { return Between::Leapt(guess) };
        let [before, after] = answers.map(|answer| answer.like(beyond).abs());
        let is_finite = softness(&mut self.system).is_some_and(|soft| INFINITE * soft.abs() * before.min(after) > 1.0);
        if is_finite { Between::Leapt(root.fraction) } else { Between::Touched(root.fraction) }
    }

    /// The fraction, nearly, at which the forces of members change over to opposite ones between the states `last` and `next`; or that they
    /// come to be others bit by bit, or vanish.
    fn changes_over(&mut self, run: &mut Run<'_>, ends: [f64; 2], answers: [&Answer; 2]) -> Result<f64, Between> {
        let [mut before, mut after] = answers.map(Clone::clone);
        let mut bracket = [0.0, 1.0];
        let mut middle = 0.5;
        for _ in 0..HALVINGS {
            run.ramp.apply(&mut self.system, ends[0] + middle * (ends[1] - ends[0]));
            self.system.predict(&self.last, &self.next, middle - 1.0);
            let outcome = self.newton.solve(&mut self.system, Start::nearby());
            run.effort.count(&outcome);
            // So near to a singular state an iteration may find nothing, and there may be no factors.
            let Some(answer) = outcome.ok().and_then(|_| self.system.answer()) else { break };
            if before.like(&answer) < 0.0 {
                (bracket[1], after) = (middle, answer);
            } else if answer.like(&after) < 0.0 {
                (bracket[0], before) = (middle, answer);
            } else {
                return Err(Between::Turned);
            }
            middle = 0.5 * (bracket[0] + bracket[1]);
        }
        let largest =
            |answers: [&Answer; 2]| answers.map(|answer| answer.like(answer).sqrt()).into_iter().fold(0.0, f64::max);
        let vanish = largest([&before, &after]) < VANISHES * largest(answers);
        if vanish { Err(Between::Nothing) } else { Ok(ends[0] + middle * (ends[1] - ends[0])) }
    }
}
