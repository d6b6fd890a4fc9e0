//! Increments that may have left their path, held against shorter ones.
//!
//! Where loads have a potential, a rise of the count of negative pivots tells. Without one the count may rise rightly, two
//! at a time, and the determinant keeps its sign over two limit points at once: what tells then is how far the state is from
//! where it was foreseen, and how hard it was to find.

use super::Continuation;
use super::follow::Run;
use super::passage::RADIAN;
use crate::newton::{Aim, Convergence, Start};

/// The first part of an increment that is made again in two. Not a half: a rod that rolls up by an even number of turns is
/// at whole turns in the middle too, where its tangent is singular.
const FIRST_PART: f64 = 0.47;

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
