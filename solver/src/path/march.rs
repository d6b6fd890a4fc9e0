//! How far the next increment of a ramp goes, and what is made of the one that was tried.
//!
//! Theory: docs/theory/continuation.md, Eq. 8.1.

use super::Count;
use super::follow::{BRACKET, SHORTEST, WILD};
use super::report::Rough;
use crate::history::CriticalPoint;
use crate::newton::{Aim, Convergence, Lost, Why};
use crate::options::Options;

/// One of this size is a guess that iterations can start from.
const TAME: f64 = 1.2;
/// An extrapolation that misses by no more than this (radians, or lengths of a member) takes few iterations to mend.
const FORESEEN: f64 = 0.05;
/// Increments in a row that find nothing, before the last state is believed to be the last.
const RETRIES: usize = 14;
/// Near a fold the state moves ever faster with the loads: by so much more than at first.
const FOLD: f64 = 4.0;

/// The next increment: its length, where it leads to, and what the state there is for.
pub(super) struct Stride {
    pub length: f64,
    pub target: f64,
    pub aim: Aim,
}

/// An equilibrium that follows the last one on its path.
pub(super) struct Reached {
    pub found: Convergence,
    pub count: Count,
    /// Singular points on the way, where there are any or stability is another.
    pub passed: Option<Vec<CriticalPoint>>,
    /// What the first increment of the iteration moved by, in radians or lengths of a member.
    pub missed: f64,
    /// How far the network moved, in radians or lengths, for a unit of the fraction.
    pub rate: f64,
}

/// What is to be made of an equilibrium that a stride led to.
pub(super) enum Judged {
    Accepted(Reached),
    /// It may lie on another path: try again with this increment.
    TooLong(f64),
    /// Stability is lost before it, or the path cannot be followed there.
    Lost(Rough),
}

/// What a shorter increment is worth.
pub(super) enum Shorter {
    /// It is nearer to what is known.
    Nearer,
    /// The same as before, so many times.
    Again,
    Never,
}

/// Where the march along a ramp is, and how far its next increment goes.
pub(super) struct March {
    pub fraction: f64,
    /// Whether the state before the last one is on the same branch, near enough to extrapolate from.
    pub behind: bool,
    pub increment: f64,
    pub last_increment: f64,
    /// How fast the network moved in the first increment, if there was one, and in the last.
    pub first_rate: Option<f64>,
    pub last_rate: f64,
    /// Increments in a row that found nothing.
    pub retries: usize,
    /// Whether linear buckling foresees, from the state that the march began at, a critical load on the way: many iterations
    /// may lead to the other side of it.
    pub foresees_buckling: bool,
    /// Why the last increments failed, where a member is held at both ends.
    pub overheld: Option<Why>,
    /// Whether loads have a potential along the whole ramp.
    pub conservative: bool,
}

impl March {
    pub(super) fn new(fraction: f64, increment: f64, conservative: bool) -> Self {
        Self {
            fraction,
            behind: false,
            increment,
            last_increment: 0.0,
            first_rate: None,
            last_rate: 0.0,
            retries: 0,
            foresees_buckling: false,
            overheld: None,
            conservative,
        }
    }

    /// The next increment, one that would leave next to nothing of the ramp drawn out to its end.
    pub(super) fn stride(&self, options: &Options) -> Stride {
        let left = 1.0 - self.fraction;
        let length = if self.fraction + self.increment * 1.0001 >= 1.0 { left } else { self.increment };
        let target = if self.fraction + length >= 1.0 - 1e-12 { 1.0 } else { self.fraction + length };
        let aim = match target {
            _ if options.rough => Aim::Rough,
            ..1.0 => Aim::Passing,
            _ => Aim::Result,
        };
        Stride { length, target, aim }
    }

    /// Goes on from an equilibrium that was accepted.
    pub(super) fn go_on(&mut self, stride: &Stride, reached: &Reached, longest: f64) {
        let step = stride.length;
        let next = match reached.found.iterations {
            // What extrapolation misses goes with the square of the increment.
            0..=6 if self.behind => (FORESEEN / reached.missed).sqrt().clamp(2.0, 4.0) * step,
            // What was not extrapolated says too little of how far one can go.
            0..=6 => 2.0 * step,
            7..=8 => step,
            _ => 0.6 * step,
        };
        self.increment = next.min(longest);
        self.last_rate = reached.rate;
        self.first_rate.get_or_insert(reached.rate);
        self.fraction = stride.target;
        self.last_increment = step;
        self.behind = true;
        self.retries = 0;
        self.foresees_buckling = false;
        self.overheld = None;
    }

    /// Goes on from a singular point, or from beyond it; `last` is the increment between the last two states, where they may
    /// be extrapolated.
    pub(super) fn begin_again(&mut self, at: f64, next: f64, last: Option<f64>) {
        self.fraction = at;
        self.increment = next;
        self.last_increment = last.unwrap_or(0.0);
        self.behind = last.is_some();
        self.retries = 0;
        self.foresees_buckling = false;
    }

    /// Near a fold the state moves ever faster with the loads.
    pub(super) fn nears_a_fold(&self) -> bool {
        self.first_rate.is_some_and(|first| self.last_rate > FOLD * first)
    }

    /// Why no equilibrium was found in the end; an iteration is lost where its residual is larger than `residual`.
    pub(super) fn reason(&self, lost: Lost, residual: f64) -> Lost {
        // What grew without end under more load does not settle under less, where forces are in balance.
        let settled = lost.why == Why::Slow && lost.residual.largest() <= residual;
        Lost { why: self.overheld.filter(|_| settled).unwrap_or(lost.why), ..lost }
    }

    /// Shortens the increment after an iteration that was given up; `first` is how far its first increment moved.
    pub(super) fn shorten(&mut self, stride: &Stride, lost: &Lost, first: f64) -> Shorter {
        let step = stride.length;
        self.increment = 0.4 * step;
        self.foresees_buckling |= self.first_rate.is_none() && matches!(lost.why, Why::Unstable(_));
        if let Why::Overheld(_) = lost.why {
            self.overheld = Some(lost.why);
        }
        match lost.why {
            Why::Wandered => {
                self.increment = 0.5 * step;
                Shorter::Nearer
            }
            Why::Unstable(excess) => {
                // Past a limit point the extrapolation is unstable: go nearer before believing what comes; the more of it
                // is unstable, the farther away are stable loads.
                if !self.behind {
                    self.increment *= 0.4f64.powf(excess.min(9) as f64 / 4.0 - 0.25);
                }
                self.increment = self.increment.max(0.9 * BRACKET);
                Shorter::Nearer
            }
            why => {
                if why == Why::Astray && first > WILD {
                    self.increment = self.increment.min(TAME / first * step);
                }
                self.retries += 1;
                if self.increment < SHORTEST || self.retries > RETRIES { Shorter::Never } else { Shorter::Again }
            }
        }
    }
}
