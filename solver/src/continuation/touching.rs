//! Where a path touches a singular state and goes on with the same stability: the change point of a linkage.
//!
//! Bars that come into one line carry nothing across it, and from there two ways go on. What resists the motion that leads from the one
//! to the other is the square of how far the bars are from that line, so no pivot changes its sign. What that motion strains
//! the bars by does (`system/posture.rs`). Bars that miss the line by a little have two paths that come near each other and
//! part again; each keeps to its side, so that an increment that leads to the other posture changed over.
//!
//! Theory: docs/theory/stability.md, Eq. 7.11.

use super::Continuation;
use super::follow::Run;
use super::locate::{Root, Value};
use crate::history::Note;
use crate::newton::Start;
use crate::system::Answer;

/// Halvings of an increment after which members that still turn over do so at one place: such that are strained in another way because the
/// network has turned are so on all of the way.
const HALVINGS: usize = 4;
/// Part of the largest determinant on a path that is zero beside it: bars that come into one line have up to 1.4e-4 of it for what rounding
/// leaves of them, and such that miss it by 1e-8 of their length 4e-4.
const ZERO: f64 = 2e-4;

/// What lies between two states of a path whose members are strained in opposite ways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Between {
    /// Nothing that is to be told: they are not.
    Nothing,
    /// States in which that comes bit by bit, as far as an increment of this length tells.
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
        let Some((own, next)) = before.posture.as_ref().zip(after.posture.as_ref()) else { return Between::Nothing };
        let seen = own.against(next);
        next.follow_firmness(own, &seen);
        for posture in [own, next] {
            let firmness = posture.firmness();
            run.firmest.resize(firmness.len(), f64::NEG_INFINITY);
            run.firmest.iter_mut().zip(firmness).for_each(|(firmest, firmness)| *firmest = firmest.max(*firmness));
        }
        let Some(&part) = seen.turned_over.first() else { return Between::Nothing };
        self.system.save(&mut self.next);
        let between = self.look_between(run, ends, [before, after], part);
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

    /// What lies between the states `last` and `next`, in which this part is strained in opposite ways.
    fn look_between(&mut self, run: &mut Run<'_>, ends: [f64; 2], answers: [&Answer; 2], part: usize) -> Between {
        let Some(guess) = self.turns_over_at(run, ends, answers, part) else { return Between::Turned };
        let (beyond, firmest) = (answers[1].posture.as_ref(), run.firmest[part]);
        let mut locator = self.locator(run.ramp);
        let mut most = 0;
        // Where the determinant is zero as far as rounding can tell a state is on either way by chance: the next states on both sides of that
        // say where the point is.
        let mut touches = false;
        let mut sides = [None; 2];
        let root = locator.root(ends, None, Value::Smooth, &mut |system, point| {
            most = point.inertia.negative.max(most);
            let posture = system.answer().and_then(|answer| answer.posture);
            let found = posture.as_ref().zip(beyond).map(|(own, beyond)| own.ratio(beyond, part));
            if let Some((posture, found)) = posture.zip(found) {
                let is_zero = (posture.firmness()[part] - firmest).exp() <= ZERO;
                touches |= is_zero;
                let side: &mut Option<(f64, f64)> = &mut sides[usize::from(found > 0.0)];
                if !is_zero && side.is_none_or(|(nearest, _)| found.abs() < nearest.abs()) {
                    *side = Some((found, point.fraction));
                }
            }
            (found.is_none_or(|found| found < 0.0), found)
        });
        run.effort.factorizations += locator.factorizations;
        // A path that loses its stability there, or on which the ramp turns back, comes to the second state by a longer way.
        let beside = self.tuning.shortest * (ends[1] - ends[0]).abs();
        let [low, high] = [ends[0].min(ends[1]) - beside, ends[0].max(ends[1]) + beside];
        let own = self.base.own;
        let goes_on = |root: &Root| (low..=high).contains(&root.fraction) && root.beyond.unwrap_or(most) <= own;
        let Some(root) = root.filter(goes_on) else { return Between::Leapt(guess) };
        match sides {
            [Some((a, from)), Some((b, to))] if touches => Between::Touched(from + a / (a - b) * (to - from)),
            _ if touches => Between::Touched(root.fraction),
            _ => Between::Leapt(root.fraction),
        }
    }

    /// The fraction, nearly, at which a part turns over between the states `last` and `next`; nothing where that comes bit by bit.
    fn turns_over_at(&mut self, run: &mut Run<'_>, ends: [f64; 2], answers: [&Answer; 2], part: usize) -> Option<f64> {
        let [mut before, mut after] = answers.map(Clone::clone);
        let mut bracket = [0.0, 1.0];
        let mut middle = 0.5;
        let turns = |before: &Answer, after: &Answer| before.parts_turned_over(after).contains(&part);
        for _ in 0..HALVINGS {
            run.ramp.apply(&mut self.system, ends[0] + middle * (ends[1] - ends[0]));
            self.system.predict(&self.last, &self.next, middle - 1.0);
            let outcome = self.newton.solve(&mut self.system, Start::nearby());
            run.effort.count(&outcome);
            // So near to a singular state an iteration may find nothing, and there may be no factors.
            let Some(answer) = outcome.ok().and_then(|_| self.system.answer()) else { break };
            if turns(&before, &answer) {
                (bracket[1], after) = (middle, answer);
            } else if turns(&answer, &after) {
                (bracket[0], before) = (middle, answer);
            } else {
                return None;
            }
            middle = 0.5 * (bracket[0] + bracket[1]);
        }
        Some(ends[0] + middle * (ends[1] - ends[0]))
    }
}
