//! Loads without a potential: the unsymmetric part of the tangent by the identity of Woodbury.
//!
//! Theory: docs/theory/mixed-points.md, Eq. 6.7.

use nalgebra::SMatrix;

use super::{Inertia, Tangent};
use crate::dense::Dense;

/// Columns of a joint: its equations at most.
const SKEW_COLUMNS: usize = 6;

/// The unsymmetric part N of the tangent between the equations of one joint.
#[derive(Clone, Debug)]
pub(super) struct SkewBlock {
    pub joint: usize,
    /// First equation of the joint, and their number.
    pub first: usize,
    pub count: usize,
    pub block: SMatrix<f64, 6, 6>,
}

/// Loads without a potential: K = S + Σ E N Eᵀ, solved by the identity of Woodbury.
#[derive(Debug, Default)]
pub(super) struct Skew {
    pub joints: Vec<SkewBlock>,
    /// S⁻¹ E.
    columns: Vec<f64>,
    /// I + N Eᵀ S⁻¹ E, factorized.
    small: Dense,
    /// N Eᵀ of a right-hand side.
    rest: Vec<f64>,
}

impl Skew {
    /// Adds to the block of a joint.
    pub(super) fn add(&mut self, joint: usize, first: usize, count: usize, block: SMatrix<f64, 6, 6>) {
        match self.joints.iter_mut().find(|own| own.joint == joint) {
            Some(own) => own.block += block,
            None => self.joints.push(SkewBlock { joint, first, count, block }),
        }
    }

    /// The same of the transposed tangent, not yet factorized.
    fn transposed(&self) -> Self {
        let joints = self.joints.iter().map(|own| SkewBlock { block: -own.block, ..own.clone() }).collect();
        Self { joints, ..Self::default() }
    }
}

impl<const D: usize> Tangent<D> {
    /// Brings what has no potential into the factors of the rest.
    pub(super) fn factorize_skew(&mut self, inertia: &mut Inertia) {
        let Skew { joints, columns, small, .. } = &mut self.skew;
        if joints.is_empty() {
            return;
        }
        let size = self.linear.size();
        let count = joints.len() * SKEW_COLUMNS;
        columns.clear();
        columns.resize(count * size, 0.0);
        for (k, own) in joints.iter().enumerate() {
            for e in 0..own.count {
                columns[(k * SKEW_COLUMNS + e) * size + own.first + e] = 1.0;
            }
        }
        self.linear.solve(columns, count);
        small.set_identity(count);
        for (k, own) in joints.iter().enumerate() {
            for column in 0..count {
                for a in 0..own.count {
                    let mut sum = 0.0;
                    for b in 0..own.count {
                        sum += own.block[(a, b)] * columns[column * size + own.first + b];
                    }
                    small.add(k * SKEW_COLUMNS + a, column, sum);
                }
            }
        }
        small.factorize();
        inertia.skew_negative = small.is_negative();
    }

    /// K⁻¹ b in place, loads without a potential included; false where there is no solution.
    pub fn solve(&mut self, b: &mut [f64]) -> bool {
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
        for (k, own) in joints.iter().enumerate() {
            for a in 0..own.count {
                for c in 0..own.count {
                    rest[k * SKEW_COLUMNS + a] += own.block[(a, c)] * b[own.first + c];
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

    /// Solves with the transposed tangent from now on, or with the tangent again.
    pub fn transpose(&mut self) {
        if !self.has_potential() {
            self.skew = self.skew.transposed();
            self.factorize_skew(&mut Inertia::default());
        }
    }

    /// Whether every load has a potential, at the state of the last assembly.
    pub fn has_potential(&self) -> bool {
        self.skew.joints.is_empty()
    }

    /// The part of the tangent that is not symmetric, by pairs of equations.
    pub(crate) fn skew_part(&self) -> Vec<(usize, usize, f64)> {
        let mut entries = Vec::new();
        for own in &self.skew.joints {
            for a in 0..own.count {
                for b in 0..own.count {
                    entries.push((own.first + a, own.first + b, own.block[(a, b)]));
                }
            }
        }
        entries
    }

    /// Part without a potential of the loads of the last assembly: equations of a joint that it couples, two by two.
    pub(crate) fn without_potential(&self) -> Vec<(usize, usize)> {
        self.skew_part().into_iter().filter(|entry| entry.2 != 0.0).map(|(row, column, _)| (row, column)).collect()
    }
}
