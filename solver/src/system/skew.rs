//! Loads without a potential: the unsymmetric part of the tangent by the identity of Woodbury.

use super::{Inertia, System};

/// Columns of a joint: its equations at most.
const SKEW_COLUMNS: usize = 6;

/// Loads without a potential: K = S + Σ E N Eᵀ, solved by the identity of Woodbury.
#[derive(Debug, Default)]
pub(super) struct Skew {
    /// Equations of the columns, and N by blocks of joints.
    pub joints: Vec<(usize, nalgebra::SMatrix<f64, 6, 6>)>,
    pub columns: Vec<f64>,
    pub small: nalgebra::DMatrix<f64>,
    pub solver: Option<nalgebra::LU<f64, nalgebra::Dyn, nalgebra::Dyn>>,
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
        let mut small = nalgebra::DMatrix::identity(count, count);
        for (k, (joint, n)) in self.skew.joints.iter().enumerate() {
            let equations = &self.equations.joints[*joint];
            for column in 0..count {
                for a in 0..equations.count {
                    let mut sum = 0.0;
                    for b in 0..equations.count {
                        sum += n[(a, b)] * self.skew.columns[column * size + equations.first + b];
                    }
                    small[(k * SKEW_COLUMNS + a, column)] += sum;
                }
            }
        }
        let lu = small.clone().lu();
        inertia.skew_negative = lu.determinant() < 0.0;
        self.skew.small = small;
        self.skew.solver = Some(lu);
    }

    /// K⁻¹ b in place, loads without a potential included.
    pub fn solve_in_place(&mut self, b: &mut [f64]) -> bool {
        if !self.linear.solve(b, 1) {
            return false;
        }
        let size = self.linear.size();
        let Some(lu) = &self.skew.solver else { return true };
        if self.skew.joints.is_empty() {
            return true;
        }
        let mut small = nalgebra::DVector::zeros(self.skew.small.nrows());
        for (k, (joint, n)) in self.skew.joints.iter().enumerate() {
            let equations = &self.equations.joints[*joint];
            for a in 0..equations.count {
                for c in 0..equations.count {
                    small[k * SKEW_COLUMNS + a] += n[(a, c)] * b[equations.first + c];
                }
            }
        }
        if !lu.solve_mut(&mut small) {
            return false;
        }
        for (column, factor) in small.iter().enumerate() {
            for i in 0..size {
                b[i] -= factor * self.skew.columns[column * size + i];
            }
        }
        b.iter().all(|x| x.is_finite())
    }
}
