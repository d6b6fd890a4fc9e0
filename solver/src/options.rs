//! What a caller may choose about a solve.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use crate::continuation::Tuning;

/// Options of a solve; the defaults serve every network.
#[derive(Clone, Debug)]
pub struct Options {
    /// First increment as a part of the step's ramp.
    pub first_increment: f64,
    /// Keep the shapes of members at every accepted increment (for pictures).
    pub shapes: bool,
    /// Solve the end of every step on a mesh of the next order too, to estimate the discretization error.
    pub estimate: bool,
    /// Look whether the unloaded structure has a motion that next to nothing resists.
    pub near_motion: bool,
    /// Ends of steps are to go on from, on a finer mesh, and not to be read off. Where no step needs more than one
    /// increment, they are not solved on a mesh of the next order.
    pub rough: bool,
    /// Threads that condense members; results do not depend on it.
    pub threads: usize,
    /// Set from outside where nobody wants to wait any longer: an iteration under way is given up, and the observer is
    /// asked at once.
    pub stop: Option<Arc<AtomicBool>>,
    /// The numbers that steer iterations and paths.
    pub tuning: Tuning,
    /// The time since some moment, by which parts of a solve are timed. The default one stands still: not every platform
    /// has a clock, and nothing but times depends on it.
    pub clock: fn() -> Duration,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            first_increment: 1.0,
            shapes: false,
            estimate: false,
            near_motion: false,
            rough: false,
            threads: 1,
            stop: None,
            tuning: Tuning::default(),
            clock: || Duration::ZERO,
        }
    }
}

/// News of a running solve, given to its observer after every accepted increment.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Index of the step.
    pub step: usize,
    /// How many steps there are.
    pub steps: usize,
    /// Part of its ramp that was reached.
    pub fraction: f64,
}
