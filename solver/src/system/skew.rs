//! Loads without a potential: the unsymmetric part of the tangent by the identity of Woodbury.
//!
//! Theory: docs/theory/mixed-points.md, Eq. 6.7.

use super::{Inertia, System};
use crate::dense::Dense;

/// Columns of a joint: its equations at most.
const SKEW_COLUMNS: usize = 6;

/// Loads without a potential: K = S + Σ E N Eᵀ, solved by the identity of Woodbury.
#[derive(Debug, Default)]
pub(super) struct Skew {
    /// Equations of the columns, and N by blocks of joints.
    pub joints: Vec<(usize, nalgebra::SMatrix<f64, 6, 6>)>,
    pub columns: Vec<f64>,
    /// I + N Eᵀ S⁻¹ E, factorized.
    pub small: Dense,
    /// N Eᵀ of a right-hand side.
    pub rest: Vec<f64>,
}

impl<const D: usize> System<D> {
    pub(super) fn factorize_skew(&mut self, inertia: &mut Inertia) {
        if self.skew.joints.is_empty() {
            return;
        }
        let size = self.linear.size();
        let count = self.skew.joints.len() * SKEW_COLUMNS;
        self.skew.columns.clear();
        self.skew.columns.resize(count * size, 0.0);
        for (k, (joint, _)) in self.skew.joints.iter().enumerate() {
            let equations = &self.equations.joints[*joint];
            for e in 0..equations.count {
                self.skew.columns[(k * SKEW_COLUMNS + e) * size + equations.first + e] = 1.0;
            }
        }
        self.linear.solve(&mut self.skew.columns, count);
        self.skew.small.set_identity(count);
        for (k, (joint, n)) in self.skew.joints.iter().enumerate() {
            let equations = &self.equations.joints[*joint];
            for column in 0..count {
                for a in 0..equations.count {
                    let mut sum = 0.0;
                    for b in 0..equations.count {
                        sum += n[(a, b)] * self.skew.columns[column * size + equations.first + b];
                    }
                    self.skew.small.add(k * SKEW_COLUMNS + a, column, sum);
                }
            }
        }
        self.skew.small.factorize();
        inertia.skew_negative = self.skew.small.is_negative();
    }

    /// K⁻¹ b in place, loads without a potential included.
    pub fn solve_in_place(&mut self, b: &mut [f64]) -> bool {
        if !self.linear.solve(b, 1) {
            return false;
        }
        let size = self.linear.size();
        let Skew { joints, columns, small, rest } = &mut self.skew;
        if joints.is_empty() {
            return true;
        }
        rest.clear();
        rest.resize(joints.len() * SKEW_COLUMNS, 0.0);
        for (k, (joint, n)) in joints.iter().enumerate() {
            let equations = &self.equations.joints[*joint];
            for a in 0..equations.count {
                for c in 0..equations.count {
                    rest[k * SKEW_COLUMNS + a] += n[(a, c)] * b[equations.first + c];
                }
            }
        }
        if !small.solve(rest) {
            return false;
        }
        for (column, factor) in rest.iter().enumerate() {
            for i in 0..size {
                b[i] -= factor * columns[column * size + i];
            }
        }
        b.iter().all(|x| x.is_finite())
    }
}
