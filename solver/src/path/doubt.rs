//! Increments that may have left their path, and how they are held against shorter ones.
//!
//! Where loads have a potential, a rise of the count of negative pivots tells. Without one the count may rise rightly, two
//! at a time, and the determinant keeps its sign over two limit points at once: what tells then is how hard the state was to find.

use super::Path;
use super::follow::{Ramp, Tally};
use crate::chain::Size;
use crate::newton::{Aim, Convergence, Start};
use crate::system::System;

/// So many iterations are no short way to the next state of a path.
pub(super) const MANY: usize = 7;
/// A first increment of an extrapolated state that misses by more (radians, or lengths of a member) may lead anywhere; so may
/// one of the last state that leaves more.
const WRONG: f64 = 0.15;
const ALL_WRONG: f64 = 1.0;
/// An extrapolation that misses by more than this part of the whole way points elsewhere: a bifurcation that is not quite
/// perfect lies on it, perhaps, and the state on the other side of that. Less than this part of what was foreseen is no way.
const MISSED: f64 = 0.8;
const AT_REST: f64 = 0.5;
/// What so few iterations lead to lies near, whatever was foreseen.
const FEW: usize = 5;
/// So many are none where the tangent lost positive pivots on the way.
const MANY_RISEN: usize = 5;
/// A state that turned by more (radians) may need long, and lose pivots, on any path.
const TURNED: f64 = 1.0;
/// The first part of an increment that is made again in two. Not a half: a rod that rolls up by an even number of turns is
/// at whole turns in the middle too, where its tangent is singular.
const FIRST_PART: f64 = 0.47;
/// Places within an increment that are looked at for a determinant of the other sign.
const PLACES: usize = 16;
/// Two states nearer than this (radians, or lengths) are one.
pub(super) const SAME: f64 = 1e-4;

impl<const D: usize> Path<'_, D> {
    /// Iterations that are too many to believe that the present state is the next one of the path.
    pub(super) fn too_many(&self, rose: bool) -> usize {
        match rose {
            _ if self.system.distance(&self.last).rotation > TURNED => usize::MAX,
            true => MANY_RISEN,
            false => MANY,
        }
    }

    /// Makes an increment to the present state again in two parts, `None` where they end elsewhere or need many iterations.
    ///
    /// `ratio` is that of the increment to the one before, if there is one to extrapolate from.
    pub(super) fn in_two_parts(
        &mut self,
        ramp: &Ramp,
        [from, to]: [f64; 2],
        ratio: Option<f64>,
        tally: &mut Tally,
    ) -> Option<Convergence> {
        let here = self.system.snapshot();
        self.system.restore(&self.last);
        let middle = from + FIRST_PART * (to - from);
        let start = Start { may_wander: false, ..Start::nearby() };
        for target in [middle, to] {
            ramp.apply(&mut self.system, target);
            if target == to {
                self.system.save(&mut self.next);
                self.system.predict(&self.last, &self.next, (1.0 - FIRST_PART) / FIRST_PART);
            } else if let Some(ratio) = ratio {
                self.system.predict(&self.before, &self.last, FIRST_PART * ratio);
            }
            let predicted = target == to || ratio.is_some();
            let aim = if target < 1.0 { Aim::Passing } else { Aim::Result };
            let outcome = self.newton.solve(&mut self.system, Start { predicted, aim, ..start });
            let iterations = outcome.as_ref().map_or_else(|lost| lost.iterations, |found| found.iterations);
            tally.iterations += iterations - 1;
            tally.factorizations += iterations;
            let found = outcome.ok().filter(|found| found.inertia.is_odd() == self.base.odd)?;
            if found.iterations >= self.too_many(found.inertia.negative > self.base.own) {
                return None;
            }
            if target == to {
                return (self.system.distance(&here).largest() <= SAME).then_some(found);
            }
        }
        None
    }
}

impl<const D: usize> Path<'_, D> {
    /// The part of an increment to the present state at which the determinant has the other sign, if there is one: two
    /// singular points lie within.
    ///
    /// Pivots are lost two at a time there, as they may be where nothing is singular: the symmetric part of the tangent has
    /// them, and the determinant of the whole tells. The states looked at are interpolated, which is near enough.
    pub(super) fn passed_twice(&mut self, ramp: &Ramp, [from, to]: [f64; 2], tally: &mut Tally) -> Option<f64> {
        self.system.save(&mut self.next);
        let mut part = None;
        for place in 1..=PLACES {
            let s = (place as f64 - FIRST_PART) / PLACES as f64;
            ramp.apply(&mut self.system, from + s * (to - from));
            self.system.predict(&self.last, &self.next, s - 1.0);
            tally.factorizations += 1;
            if self.system.assemble(false).is_odd() != self.base.odd {
                part = Some(s);
                break;
            }
        }
        self.system.restore(&self.next);
        ramp.apply(&mut self.system, to);
        self.system.assemble(false);
        tally.factorizations += 1;
        part
    }
}

/// Whether the present state may lie on another path than the one that led to the last: `moved` from there by parts of the
/// network, `foreseen` to move by extrapolation (`predicted`) or else by the first increment of its iteration.
///
/// Where loads have a potential a long way alone is no sign of that.
pub fn is_doubtful<const D: usize>(
    system: &System<D>,
    (moved, foreseen): (&[Size], &[Size]),
    predicted: bool,
    iterations: usize,
) -> bool {
    let most = |sizes: &[Size]| sizes.iter().copied().fold(Size::default(), Size::join).largest();
    let (way, ahead) = (most(moved), most(foreseen));
    let missed = system.own_first;
    let limit = if predicted { WRONG } else { ALL_WRONG };
    let far = missed > limit && iterations >= MANY && !system.hangs();
    // What comes to rest goes no other way.
    let elsewhere = predicted && way > SAME && way > AT_REST * ahead && missed > MISSED * way.max(ahead);
    let leapt = || moved.iter().zip(foreseen).any(|(&moved, &foreseen)| is_farther(moved, foreseen, SAME));
    far || iterations > FEW && (elsewhere || leapt())
}

/// Whether a part of the network moved much farther than its linear extrapolation, and far away: over a limit point, perhaps.
pub(super) fn leapt((moved, foreseen): (&[Size], &[Size])) -> bool {
    const FAR: f64 = 0.01;
    moved.iter().zip(foreseen).any(|(&moved, &foreseen)| is_farther(moved, foreseen, FAR))
}

/// Whether more than `near` was moved, and much more than was foreseen.
fn is_farther(moved: Size, foreseen: Size, near: f64) -> bool {
    const FARTHER: f64 = 4.0;
    let leap = |moved: f64, foreseen: f64| moved > near && moved > FARTHER * foreseen;
    leap(moved.displacement, foreseen.displacement.max(foreseen.rotation))
        || leap(moved.rotation, foreseen.rotation.max(foreseen.displacement))
}
