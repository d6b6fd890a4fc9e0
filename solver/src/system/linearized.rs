//! How the equilibrium moves with the fraction of a ramp.

use super::{Inertia, Residual, System};

/// The equations at a state, linearized in the motion of the joints and in the fraction of the ramp.
#[derive(Debug, Default)]
pub struct Linearized {
    /// Pivots of the tangent.
    pub inertia: Inertia,
    /// What is left of the equations.
    pub residual: Residual,
    /// Solution of the joint equations at a fixed fraction.
    pub step: Vec<f64>,
    /// What a unit of the fraction adds to it.
    pub rate: Vec<f64>,
    /// The same two as motions of the joints, what is held included.
    pub step_motions: Vec<[f64; 6]>,
    /// Motions of the joints for a unit of the fraction.
    pub rate_motions: Vec<[f64; 6]>,
}

impl<const D: usize> System<D> {
    /// Linearizes at the present state and factorizes.
    ///
    /// `apply` brings the drives to a fraction. The derivative by the fraction is a difference of two residuals of the
    /// same state, `ahead` apart: it steers, and has no part in what an equilibrium is. With it comes whether the tangent
    /// has factors: what is solved for is worth nothing where it has none.
    pub(crate) fn linearize(
        &mut self,
        fraction: f64,
        ahead: f64,
        apply: &mut dyn FnMut(&mut Self, f64),
    ) -> (Linearized, bool) {
        apply(self, fraction + ahead);
        self.gather(true);
        let mut rate = self.tangent.rhs.clone();
        let mut pending_rate = self.pattern.equations.pending.clone();
        apply(self, fraction);
        let inertia = self.assemble(true);
        let residual = self.residual();
        let mut step: Vec<f64> = self.tangent.rhs.iter().map(|r| -r).collect();
        for (ahead_of, here) in rate.iter_mut().zip(&self.tangent.rhs) {
            *ahead_of = -(*ahead_of - here) / ahead;
        }
        let equations = &self.pattern.equations;
        for (ahead_of, here) in pending_rate.iter_mut().zip(&equations.pending) {
            for c in 0..6 {
                ahead_of[c] = (ahead_of[c] - here[c]) / ahead;
            }
        }
        let solved = self.tangent.solve(&mut step) && self.tangent.solve(&mut rate);
        let joints = 0..equations.joints.len();
        let step_motions = joints.map(|joint| equations.motion(joint, &step, true)).collect();
        let mut rate_motions = self.pattern.motions_of(&rate);
        for (motion, pending) in rate_motions.iter_mut().zip(&pending_rate) {
            for c in 0..6 {
                motion[c] += pending[c];
            }
        }
        (Linearized { inertia, residual, step, rate, step_motions, rate_motions }, solved)
    }
}
