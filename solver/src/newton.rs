//! Newton's iteration at fixed loads, with mixed integration points.

use crate::system::{Inertia, Residual, System};

/// When an iteration is converged and when it is given up.
#[derive(Clone, Copy, Debug)]
pub struct Newton {
    pub max_iterations: usize,
    /// Size of the last increment (radians, or lengths of a member) below which the next would be rounding: its square.
    pub increment: f64,
    /// Residual above which such a state is iterated once more.
    pub settled: f64,
    /// Residual of the joints over the largest force or moment that counts as equilibrium.
    pub residual: f64,
    /// An increment that grows and exceeds this has lost its way.
    pub lost: f64,
}

impl Default for Newton {
    fn default() -> Self {
        Self { max_iterations: 16, increment: 1e-7, settled: 1e-10, residual: 1e-6, lost: 0.5 }
    }
}

/// An equilibrium that was found.
#[derive(Clone, Copy, Debug, Default)]
pub struct Convergence {
    pub iterations: usize,
    /// Pivots and residual at the equilibrium.
    pub inertia: Inertia,
    pub residual: Residual,
    /// Negative pivots of the linear extrapolation of state and stresses to these loads.
    pub foreseen_negative: usize,
}

/// An iteration that was given up.
#[derive(Clone, Copy, Debug)]
pub struct Lost {
    pub iterations: usize,
    pub residual: Residual,
    pub why: Why,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Why {
    /// Too many iterations.
    Slow,
    /// Increments grow.
    Astray,
    /// The tangent has no factors.
    Singular,
    /// The linear extrapolation to these loads is unstable: a limit point may lie between.
    Unstable,
}

/// Where an iteration starts from.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// The state is an extrapolation already, not the last equilibrium.
    pub predicted: bool,
    /// Give up where the linear extrapolation to the loads has more negative pivots than this.
    pub negative_limit: usize,
    /// The equilibrium is one to go on from, not one to read off: a larger residual will do.
    pub passing: bool,
}

impl Start {
    /// To full accuracy from a state nearby.
    pub fn nearby() -> Self {
        Self { predicted: true, negative_limit: usize::MAX, passing: false }
    }
}

impl Newton {
    /// Brings the system to equilibrium at its present loads; every iteration is one factorization.
    ///
    /// The last factorization is at the equilibrium itself: it gives the residual there, the reactions and the pivots.
    pub fn solve<const D: usize>(&self, system: &mut System<D>, start: Start) -> Result<Convergence, Lost> {
        let mut last = f64::INFINITY;
        let mut before = f64::INFINITY;
        let mut foreseen_negative = 0;
        for iterations in 1..=self.max_iterations {
            let pending = iterations == 1 || system.equations.has_general();
            let inertia = system.assemble(pending);
            let residual = system.residual();
            #[cfg(feature = "trace")]
            eprintln!("{iterations:3} {:.1e} {:.1e} {last:.1e} {inertia:?}", residual.force, residual.moment);
            // A second increment below the limit is rounding: no iteration makes the residual smaller.
            let rounding = before <= self.increment && residual.largest() <= self.residual;
            let settled = residual.largest() <= self.settled;
            let passing = start.passing && last <= 1e3 * self.increment && residual.largest() <= 1e3 * self.settled;
            if last <= self.increment && (settled || rounding) || passing {
                return Ok(Convergence { iterations, inertia, residual, foreseen_negative });
            }
            if iterations == if start.predicted { 1 } else { 2 } {
                foreseen_negative = inertia.negative;
                if foreseen_negative > start.negative_limit {
                    return Err(Lost { iterations, residual, why: Why::Unstable });
                }
            }
            let lost = |why| Err(Lost { iterations, residual, why });
            if iterations == self.max_iterations {
                return lost(Why::Slow);
            }
            let Some(size) = system.advance(pending) else { return lost(Why::Singular) };
            let size = size.largest();
            // The negation catches a NaN too.
            if !(size <= self.lost || size <= last) {
                return lost(Why::Astray);
            }
            before = last;
            last = size;
        }
        unreachable!("the loop ends at its last iteration")
    }
}
