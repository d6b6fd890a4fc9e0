//! How the equilibrium moves with the fraction of a ramp.

use super::{Inertia, Residual, System, between};

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
    /// The same two as motions of the joints, what is held included, and after them of the middles of members out of sight.
    pub step_motions: Vec<[f64; 6]>,
    /// Motions of these for a unit of the fraction.
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
        let members = self.out_of_sight();
        apply(self, fraction + ahead);
        self.gather(true);
        let there = self.sides();
        let middles_there = if members.is_empty() { Vec::new() } else { self.middles_ahead(&members) };
        apply(self, fraction);
        let inertia = self.assemble(true);
        let residual = self.residual();
        let mut step: Vec<f64> = self.tangent.rhs.iter().map(|r| -r).collect();
        let mut slope = self.slope_to(there, ahead);
        let solved = self.tangent.solve(&mut step) && self.tangent.solve(&mut slope.rhs);
        let equations = &self.pattern.equations;
        let joints = 0..equations.joints.len();
        let mut step_motions: Vec<[f64; 6]> = joints.map(|joint| equations.motion(joint, &step, true)).collect();
        let mut rate_motions = self.motions_of(&slope);
        if !members.is_empty() {
            let here = self.middles(&members);
            let stepped = self.middles_ahead(&members);
            step_motions.extend(between(&here, &stepped));
            rate_motions.extend(between(&stepped, &middles_there).map(|motion| motion.map(|x| x / ahead)));
        }
        (Linearized { inertia, residual, step, rate: slope.rhs, step_motions, rate_motions }, solved)
    }

    /// Motions of the joints for a unit of the fraction at the present state, an equilibrium that was assembled last, by the factors
    /// that it has; `None` where it has none.
    pub(crate) fn rate_motions(
        &mut self,
        fraction: f64,
        ahead: f64,
        apply: &mut dyn FnMut(&mut Self, f64),
    ) -> Option<Vec<[f64; 6]>> {
        let (drives, prestress) = (self.loading.drives.clone(), self.loading.prestress);
        apply(self, fraction + ahead);
        // Where the ramp moves nothing but what is held, members have the forces of the state already.
        let stay = self.loading.drives == drives && self.loading.prestress == prestress;
        self.refresh(true);
        let there = self.sides();
        apply(self, fraction);
        if stay {
            self.refresh_joints(true);
        } else {
            self.refresh(true);
        }
        let mut slope = self.slope_to(there, ahead);
        self.tangent.solve(&mut slope.rhs).then(|| self.motions_of(&slope))
    }

    /// What the last assembly was to be solved for.
    fn sides(&self) -> Sides {
        Sides { rhs: self.tangent.rhs.clone(), pending: self.pattern.equations.pending.clone() }
    }

    /// What a unit of the fraction changes of that, by a difference to what it is `ahead` of here.
    fn slope_to(&self, mut there: Sides, ahead: f64) -> Sides {
        for (there, here) in there.rhs.iter_mut().zip(&self.tangent.rhs) {
            *there = -(*there - here) / ahead;
        }
        for (there, here) in there.pending.iter_mut().zip(&self.pattern.equations.pending) {
            for c in 0..6 {
                there[c] = (there[c] - here[c]) / ahead;
            }
        }
        there
    }

    /// Motions of the joints by a solution and by what held components are moved.
    fn motions_of(&self, solved: &Sides) -> Vec<[f64; 6]> {
        let mut motions = self.pattern.motions_of(&solved.rhs);
        for (motion, pending) in motions.iter_mut().zip(&solved.pending) {
            for c in 0..6 {
                motion[c] += pending[c];
            }
        }
        motions
    }
}

/// What the equations are solved for: forces, and the motion of held components.
struct Sides {
    rhs: Vec<f64>,
    pending: Vec<[f64; 6]>,
}
