//! P K Pᵀ = L D Lᵀ of a sparse symmetric matrix by faer, and the two halves of its solve.
//!
//! faer solves with both halves at once. A symmetric eigenvalue problem needs them one by one, so the factors are those
//! of the simplicial kind, whose columns can be read.

use std::cell::RefCell;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Par, Side};
use sprs::CsMat;

use crate::linear::PIVOT_NOISE;

/// Iterations towards the softest motion of a matrix.
const SOFTEST: usize = 6;

/// Factors of a symmetric matrix.
#[derive(Clone, Debug)]
pub(crate) struct Factor {
    /// Original index of every row of the factors.
    original: Vec<usize>,
    starts: Vec<usize>,
    rows: Vec<usize>,
    /// Columns of L, its diagonal replaced by D.
    values: Vec<f64>,
    /// Roots of the magnitudes of D.
    roots: Vec<f64>,
    /// Negative pivots.
    pub negative: usize,
    /// Pivots at noise level.
    pub neutral: usize,
}

/// Where a symmetric matrix has entries, and in which order it is factorized.
#[derive(Debug)]
pub(crate) struct Analysis {
    pattern: SymbolicSparseColMat<usize>,
    symbolic: SymbolicCholesky<usize>,
}

/// The analysis of the last one of several matrices, most of which have their entries in the same places.
#[derive(Debug, Default)]
pub(crate) struct Analyzed(RefCell<Option<Analysis>>);

impl Analyzed {
    /// Factors of one of the matrices; nothing where a pivot vanishes.
    pub(crate) fn factor(&self, matrix: &CsMat<f64>) -> Option<Factor> {
        Factor::with(matrix, &mut self.0.borrow_mut())
    }
}

/// Entries of the lower triangle by columns, and the diagonal.
struct Lower {
    starts: Vec<usize>,
    rows: Vec<usize>,
    entries: Vec<f64>,
    diagonal: Vec<f64>,
}

impl Lower {
    fn of(matrix: &CsMat<f64>) -> Self {
        let size = matrix.rows();
        let mut lower =
            Self { starts: vec![0; size + 1], rows: Vec::new(), entries: Vec::new(), diagonal: vec![0.0; size] };
        for (column, vector) in matrix.outer_iterator().enumerate() {
            // By symmetry row `column` is the column, and its entries from the diagonal on the lower triangle.
            for (row, &value) in vector.iter().filter(|entry| entry.0 >= column) {
                lower.rows.push(row);
                lower.entries.push(value);
                if row == column {
                    lower.diagonal[row] = value;
                }
            }
            lower.starts[column + 1] = lower.rows.len();
        }
        lower
    }
}

impl Analysis {
    fn of(size: usize, lower: &Lower) -> Option<Self> {
        let pattern = SymbolicSparseColMat::new_checked(size, size, lower.starts.clone(), None, lower.rows.clone());
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SIMPLICIAL,
            ..CholeskySymbolicParams::default()
        };
        let symbolic =
            factorize_symbolic_cholesky(pattern.as_ref(), Side::Lower, SymmetricOrdering::Amd, parameters).ok()?;
        Some(Self { pattern, symbolic })
    }

    fn is_of(&self, lower: &Lower) -> bool {
        self.pattern.col_ptr() == lower.starts && self.pattern.row_idx() == lower.rows
    }
}

impl Factor {
    /// Factorizes a matrix with both triangles; nothing where a pivot vanishes.
    pub(crate) fn new(matrix: &CsMat<f64>) -> Option<Self> {
        Self::with(matrix, &mut None)
    }

    /// The same with the analysis of one before, where its entries were in the same places; it is left for the next one.
    fn with(matrix: &CsMat<f64>, known: &mut Option<Analysis>) -> Option<Self> {
        let (size, lower) = (matrix.rows(), Lower::of(matrix));
        let analysis = match known.take().filter(|analysis| analysis.is_of(&lower)) {
            Some(analysis) => analysis,
            None => Analysis::of(size, &lower)?,
        };
        let Analysis { pattern, symbolic } = known.insert(analysis);
        let Lower { entries, diagonal, .. } = lower;
        let mut values = vec![0.0; symbolic.len_val()];
        let scratch = symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default());
        symbolic
            .factorize_numeric_ldlt(
                &mut values,
                SparseColMatRef::new(pattern.as_ref(), &entries),
                Side::Lower,
                LdltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut MemBuffer::new(scratch)),
                Default::default(),
            )
            .ok()?;
        let SymbolicCholeskyRaw::Simplicial(simplicial) = symbolic.raw() else {
            unreachable!("simplicial factors were asked for")
        };
        let original: Vec<usize> = match symbolic.perm() {
            Some(permutation) => permutation.arrays().0.to_vec(),
            None => (0..size).collect(),
        };
        let (starts, rows) = (simplicial.col_ptr().to_vec(), simplicial.row_idx().to_vec());
        let pivots: Vec<f64> = (0..size).map(|column| values[starts[column]]).collect();
        if pivots.iter().any(|pivot| !pivot.is_finite() || *pivot == 0.0) {
            return None;
        }
        let noise = |column: usize| PIVOT_NOISE * diagonal[original[column]].abs();
        let is_neutral = |column: &usize| pivots[*column].abs() <= noise(*column);
        Some(Self {
            negative: pivots.iter().filter(|pivot| **pivot < 0.0).count(),
            neutral: (0..size).filter(is_neutral).count(),
            roots: pivots.iter().map(|pivot| pivot.abs().sqrt()).collect(),
            original,
            starts,
            rows,
            values,
        })
    }

    /// Number of rows.
    pub(crate) fn size(&self) -> usize {
        self.original.len()
    }

    /// y = |D|^-½ L⁻¹ P b, for W columns side by side.
    pub(crate) fn forward<const W: usize>(&self, b: &[[f64; W]]) -> Vec<[f64; W]> {
        let mut y: Vec<[f64; W]> = self.original.iter().map(|&i| b[i]).collect();
        for column in 0..y.len() {
            let x = y[column];
            for k in self.starts[column] + 1..self.starts[column + 1] {
                let (below, value) = (&mut y[self.rows[k]], self.values[k]);
                for w in 0..W {
                    below[w] -= value * x[w];
                }
            }
        }
        for (y, root) in y.iter_mut().zip(&self.roots) {
            y.iter_mut().for_each(|y| *y /= root);
        }
        y
    }

    /// x = Pᵀ L⁻ᵀ |D|^-½ y, for W columns side by side.
    pub(crate) fn backward<const W: usize>(&self, y: &[[f64; W]]) -> Vec<[f64; W]> {
        let mut z = y.to_vec();
        for (z, root) in z.iter_mut().zip(&self.roots) {
            z.iter_mut().for_each(|z| *z /= root);
        }
        for column in (0..z.len()).rev() {
            let mut sum = [0.0; W];
            for k in self.starts[column] + 1..self.starts[column + 1] {
                let (below, value) = (&z[self.rows[k]], self.values[k]);
                for w in 0..W {
                    sum[w] += value * below[w];
                }
            }
            for w in 0..W {
                z[column][w] -= sum[w];
            }
        }
        let mut x = vec![[0.0; W]; z.len()];
        for (&i, z) in self.original.iter().zip(z) {
            x[i] = z;
        }
        x
    }
}

impl Factor {
    /// K⁻¹ b, for W columns side by side.
    pub(crate) fn solve<const W: usize>(&self, b: &[[f64; W]]) -> Vec<[f64; W]> {
        let mut y = self.forward(b);
        if self.negative > 0 {
            for (y, &start) in y.iter_mut().zip(&self.starts) {
                if self.values[start] < 0.0 {
                    y.iter_mut().for_each(|y| *y = -*y);
                }
            }
        }
        self.backward(&y)
    }

    /// About the least stiffness of a motion of the matrix K that these are the factors of, over that of its diagonal.
    pub(crate) fn softest(&self, stiffness: &CsMat<f64>) -> f64 {
        let diagonal: Vec<f64> = stiffness.diag().iter().map(|(_, value)| value.abs()).collect();
        let mut forces: Vec<[f64; 1]> = (0..self.size()).map(|i| [(1.3 * i as f64 + 0.7).sin()]).collect();
        let mut softest = f64::INFINITY;
        for _ in 0..SOFTEST {
            let motion = self.solve(&forces);
            let weighed: Vec<[f64; 1]> = motion.iter().zip(&diagonal).map(|(x, d)| [x[0] * d]).collect();
            let product = |forces: &[[f64; 1]]| motion.iter().zip(forces).map(|(x, f)| x[0] * f[0]).sum::<f64>();
            let (energy, weight) = (product(&forces), product(&weighed));
            softest = (energy / weight).abs();
            forces = weighed.iter().map(|f| [f[0] / weight.sqrt()]).collect();
        }
        softest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sprs::TriMat;

    /// A row of springs with one negative: both halves together solve, and D shows its sign.
    #[test]
    fn halves_make_a_solve_and_pivots_show_signs() {
        let size = 40;
        for negative in [None, Some(7)] {
            let mut triplets = TriMat::new((size, size));
            for i in 0..size {
                triplets.add_triplet(i, i, if negative == Some(i) { -3.0 } else { 4.0 });
                if i + 1 < size {
                    triplets.add_triplet(i, i + 1, -1.0);
                    triplets.add_triplet(i + 1, i, -1.0);
                }
                if i + 9 < size {
                    triplets.add_triplet(i, i + 9, 0.5);
                    triplets.add_triplet(i + 9, i, 0.5);
                }
            }
            let matrix: CsMat<f64> = triplets.to_csr();
            let factor = Factor::new(&matrix).unwrap();
            assert_eq!((factor.negative, factor.neutral), (usize::from(negative.is_some()), 0));
            let b: Vec<[f64; 2]> = (0..size).map(|i| [(i as f64).cos(), (2.0 * i as f64).sin()]).collect();
            let x = factor.solve(&b);
            for (i, row) in matrix.outer_iterator().enumerate() {
                for w in 0..2 {
                    let sum: f64 = row.iter().map(|(j, k)| k * x[j][w]).sum();
                    assert!((sum - b[i][w]).abs() < 1e-13);
                }
            }
        }
    }
}
