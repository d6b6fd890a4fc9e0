//! Newton's iteration at fixed loads, with mixed integration points.

use crate::system::{Inertia, Residual, System};

/// When an iteration is converged and when it is given up.
#[derive(Clone, Copy, Debug)]
pub struct Newton {
    pub max_iterations: usize,
    /// Size of the last increment (radians, or lengths of a member) below which the next would be rounding: its square.
    pub increment: f64,
    /// Residual of the joints over the largest force or moment that counts as equilibrium.
    pub residual: f64,
    /// An increment that grows and exceeds this has lost its way.
    pub lost: f64,
}

impl Default for Newton {
    fn default() -> Self {
        Self { max_iterations: 16, increment: 1e-7, residual: 1e-6, lost: 0.5 }
    }
}

/// An equilibrium that was found.
#[derive(Clone, Copy, Debug, Default)]
pub struct Convergence {
    pub iterations: usize,
    /// Pivots and residual at the equilibrium.
    pub inertia: Inertia,
    pub residual: Residual,
}

/// An iteration that was given up.
#[derive(Clone, Copy, Debug)]
pub struct Lost {
    pub iterations: usize,
    pub residual: Residual,
    /// The tangent had no factors.
    pub singular: bool,
}

impl Newton {
    /// Brings the system to equilibrium at its present loads; every iteration is one factorization.
    ///
    /// The last factorization is at the equilibrium itself: it gives the residual there, the reactions and the pivots.
    pub fn solve<const D: usize>(&self, system: &mut System<D>) -> Result<Convergence, Lost> {
        let mut last = f64::INFINITY;
        for iterations in 1..=self.max_iterations {
            let pending = iterations == 1 || system.equations.has_general();
            let inertia = system.assemble(pending);
            let residual = system.residual();
            if last <= self.increment && residual.largest() <= self.residual {
                return Ok(Convergence { iterations, inertia, residual });
            }
            let lost = |singular| Err(Lost { iterations, residual, singular });
            if iterations == self.max_iterations {
                return lost(false);
            }
            let Some(size) = system.advance(pending) else { return lost(true) };
            let size = size.largest();
            if std::env::var("PENNATE_TRACE").is_ok() {
                eprintln!(
                    "it {iterations} residual {:.2e} {:.2e} size {size:.3e} neg {} neutral {} scale {:.2e} {:.2e}",
                    residual.force,
                    residual.moment,
                    inertia.negative,
                    inertia.neutral,
                    system.force_scale,
                    system.moment_scale
                );
            }
            // The negation catches a NaN too.
            if !(size <= self.lost || size <= last) {
                return lost(false);
            }
            // At the floor of rounding increments stop falling: nothing more is to be had.
            last = if size < 1e-9 { 0.0 } else { size };
        }
        unreachable!("the loop ends at its last iteration")
    }
}
