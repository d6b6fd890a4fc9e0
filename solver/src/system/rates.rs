//! How the equilibrium moves with the fraction of a ramp, and motions of all joints as vectors.

use pennate_elements::rotation::{compose, inverse, log};
use pennate_elements::small::{norm, sub};

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
    /// same state, `ahead` apart: it steers, and has no part in what an equilibrium is. `None` where the tangent has
    /// no factors.
    pub fn linearize(
        &mut self,
        fraction: f64,
        ahead: f64,
        apply: &mut dyn FnMut(&mut Self, f64),
    ) -> (Linearized, bool) {
        apply(self, fraction + ahead);
        self.gather(true);
        let mut rate = self.rhs.clone();
        let mut pending_rate = self.equations.pending.clone();
        apply(self, fraction);
        let inertia = self.assemble(true);
        let residual = self.residual();
        let mut step: Vec<f64> = self.rhs.iter().map(|r| -r).collect();
        for (ahead_of, here) in rate.iter_mut().zip(&self.rhs) {
            *ahead_of = -(*ahead_of - here) / ahead;
        }
        for (ahead_of, here) in pending_rate.iter_mut().zip(&self.equations.pending) {
            for c in 0..6 {
                ahead_of[c] = (ahead_of[c] - here[c]) / ahead;
            }
        }
        let solved = self.solve_in_place(&mut step) && self.solve_in_place(&mut rate);
        let joints = self.forces.len();
        let step_motions = (0..joints).map(|joint| self.equations.motion(joint, &step, true)).collect();
        let mut rate_motions: Vec<[f64; 6]> =
            (0..joints).map(|joint| self.equations.motion(joint, &rate, false)).collect();
        for (motion, pending) in rate_motions.iter_mut().zip(&pending_rate) {
            for c in 0..6 {
                motion[c] += pending[c];
            }
        }
        (Linearized { inertia, residual, step, rate, step_motions, rate_motions }, solved)
    }

    /// Motions of all joints from where they were to where they are: displacements, and spins in global axes.
    pub(super) fn motions_between(&self, then: &[crate::joints::JointState]) -> Vec<[f64; 6]> {
        let motion = |(a, b): (&crate::joints::JointState, &crate::joints::JointState)| {
            let u = sub(b.place.displacement, a.place.displacement);
            let spin = if D == 3 {
                [0.0, 0.0, b.place.angle - a.place.angle]
            } else {
                log(compose(b.place.rotation, inverse(a.place.rotation)))
            };
            [u[0], u[1], u[2], spin[0], spin[1], spin[2]]
        };
        then.iter().zip(&self.state.joints).map(motion).collect()
    }

    /// Motions of all joints that a solution of the joint equations means.
    pub fn motions_of(&self, solution: &[f64]) -> Vec<[f64; 6]> {
        (0..self.forces.len()).map(|joint| self.equations.motion(joint, solution, false)).collect()
    }

    /// The softest motion of the last factorization, by inverse iteration; the largest part of it is positive, and of
    /// size one (in lengths of the network, or radians).
    pub fn softest_motion(&mut self) -> Vec<f64> {
        let size = self.linear.size();
        let weight = |i: usize| self.linear.diagonal(i).abs().max(self.linear.rest[i]).max(f64::MIN_POSITIVE);
        let weights: Vec<f64> = (0..size).map(weight).collect();
        let mut x: Vec<f64> = (0..size).map(|i| (1.3 * i as f64 + 0.7).sin() / weights[i].sqrt()).collect();
        for _ in 0..6 {
            // The weights make the iteration indifferent to units: what it looks for is soft against the rest.
            for (x, weight) in x.iter_mut().zip(&weights) {
                *x *= weight;
            }
            if !self.linear.solve(&mut x, 1) {
                break;
            }
            let length = x.iter().zip(&weights).map(|(x, w)| x * x * w).sum::<f64>().sqrt();
            x.iter_mut().for_each(|x| *x /= length.max(f64::MIN_POSITIVE));
        }
        let motions = self.motions_of(&x);
        let largest = motions.iter().flat_map(|m| (0..6).map(|c| if c < 3 { m[c] / self.size } else { m[c] }));
        let largest = largest.fold(0.0, |best: f64, x| if x.abs() > (1.0 + 1e-6) * best.abs() { x } else { best });
        if largest != 0.0 && largest.is_finite() {
            x.iter_mut().for_each(|x| *x /= largest);
        }
        x
    }

    /// Stiffness of the softest motion of the last factorization, over that of its components one by one.
    ///
    /// A pivot says whether a tangent is singular, and not how nearly: it is large where its component hardly takes part
    /// in the motion.
    pub fn softest_stiffness(&mut self) -> f64 {
        let x = self.softest_motion();
        let mut kx = vec![0.0; x.len()];
        self.linear.apply(&x, &mut kx);
        let stiffness: f64 = x.iter().zip(&kx).map(|(x, k)| x * k).sum();
        let weight = |i: usize| self.linear.diagonal(i).abs().max(self.linear.rest[i]);
        let apart: f64 = x.iter().enumerate().map(|(i, x)| x * x * weight(i)).sum();
        if apart > 0.0 { stiffness / apart } else { 1.0 }
    }

    /// The solution at the last factorization for a right-hand side, over which it is projected: 1 / (bᵀ K⁻¹ b) passes
    /// zero, smoothly, where the tangent is singular.
    pub fn singular_test(&mut self, b: &[f64]) -> Option<f64> {
        let mut y = b.to_vec();
        if !self.solve_in_place(&mut y) {
            return None;
        }
        let compliance: f64 = y.iter().zip(b).map(|(y, b)| y * b).sum();
        (compliance != 0.0).then(|| 1.0 / compliance)
    }

    /// Whether any section has a strain that is held: rigid in shear, or not to be stretched.
    pub fn holds_strains(&self) -> bool {
        self.holds_strains
    }

    /// Mean stiffness of the unloaded joints against displacements.
    pub fn rest_stiffness_of_displacements(&self) -> f64 {
        let sum: f64 = self.rest_stiffness.iter().map(|k| k[..3].iter().sum::<f64>()).sum();
        sum / (3 * self.rest_stiffness.len().max(1)) as f64
    }

    /// The largest displacement (over the size of the network) or rotation of a joint against the unloaded state.
    pub fn moved(&self) -> f64 {
        let of = |joint: &crate::joints::JointState| {
            let turned = if D == 3 { joint.place.angle.abs() } else { norm(log(joint.place.rotation)) };
            turned.max(norm(joint.place.displacement) / self.size)
        };
        self.state.joints.iter().map(of).fold(0.0, f64::max)
    }

    /// A displacement (0, 1, 2) or a rotation (3, 4, 5, radians) of a node, in global axes.
    pub fn component(&self, node: usize, component: usize) -> f64 {
        let link = &self.topology.links[node];
        let joint = &self.state.joints[link.joint];
        if component < 3 {
            joint.point(link.arm)[component]
        } else if D == 3 {
            if component == 5 { joint.place.angle } else { 0.0 }
        } else {
            log(joint.place.rotation)[component - 3]
        }
    }
}
