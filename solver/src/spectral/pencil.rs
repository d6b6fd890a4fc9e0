//! The largest θ of B x = θ K x among the x with G x = 0; K is positive definite there.
//!
//! With K = L D Lᵀ this is the symmetric operator A = Π L⁻¹ B L⁻ᵀ Π (permutation and D left out). Π is the projection
//! onto the motions that the constraints leave. K holds Gᵀ G with a large factor, so that for W = L⁻¹ Gᵀ the singular
//! values are one but for a small part, and Π is the limit of (I − W Wᵀ)ⁿ, reached in a few steps: the same repeated
//! correction of the multipliers by which equilibria meet rigid components.
//!
//! Eigenvalues are found in Krylov spaces of blocks (`krylov.rs`), which need no matrix of A. A block sees as many motions
//! of a multiple eigenvalue as it has vectors: what was found is deflated and the search repeated until the count of negative
//! pivots of K − B/θ (Sylvester's law of inertia) says that nothing is missing above the last one wanted. Of a small network
//! all eigenvalues of the whole A are taken.

use faer::{Mat, Side};
use sprs::CsMat;

use super::factor::Factor;
use super::krylov::{self, Largest};

/// Unknowns up to which the whole spectrum is computed.
const SMALL: usize = 200;
/// Searches with what was found taken out, at most.
const SEARCHES: usize = 40;
/// Pairs beyond those wanted.
const EXTRA: usize = 2;
/// By how much the limit of a count lies above an eigenvalue.
const FINE: f64 = 1.0 + 1e-6;
const COARSE: f64 = 1.01;
/// Residual of a pair over the largest eigenvalue.
const TOLERANCE: f64 = 1e-12;
/// Eigenvalues below this part of the largest are rounding.
const ROUNDING: f64 = 1e-11;
/// Corrections of the multipliers at most, and the part of a vector at which they are done.
const CORRECTIONS: usize = 30;
const CORRECTED: f64 = 1e-14;

/// B x = θ K x with G x = 0.
#[derive(Debug)]
pub struct Pencil<'a> {
    factor: Factor,
    stiffness: &'a CsMat<f64>,
    other: &'a CsMat<f64>,
    constraints: &'a CsMat<f64>,
}

/// Eigenvalues by falling size, and their motions with xᵀ K x = 1.
#[derive(Clone, Debug, Default)]
pub struct Pairs {
    pub values: Vec<f64>,
    pub vectors: Vec<Vec<f64>>,
    /// Whether the count of pivots confirms that none is missing above the last.
    pub complete: bool,
}

impl<'a> Pencil<'a> {
    /// `factor` is that of `stiffness`, without negative pivots.
    pub fn new(factor: Factor, stiffness: &'a CsMat<f64>, other: &'a CsMat<f64>, constraints: &'a CsMat<f64>) -> Self {
        Self { factor, stiffness, other, constraints }
    }

    /// The `count` largest eigenvalues above `least`, which is positive.
    ///
    /// Where the count of pivots says that there are none, nothing is searched for. An auxiliary stiffness in place of a
    /// rigid one makes that count too large at most.
    pub fn largest_above(&self, least: f64, count: usize) -> Pairs {
        if self.count_above(least) == Some(0) {
            return Pairs { complete: true, ..Pairs::default() };
        }
        let mut pairs = self.largest(count);
        let kept = pairs.values.iter().take_while(|value| **value > least).count();
        pairs.values.truncate(kept);
        pairs.vectors.truncate(kept);
        pairs
    }

    /// The `count` largest positive eigenvalues.
    pub fn largest(&self, count: usize) -> Pairs {
        let size = self.factor.size();
        if size <= SMALL || size < 8 * (count + EXTRA) {
            return self.pairs(&self.all(), count, true);
        }
        let mut found: Vec<(f64, Vec<f64>)> = Vec::new();
        for search in 0..SEARCHES {
            let Largest { pairs: fresh, scale } = self.search(&found, count + EXTRA, search);
            let largest = found.iter().fold(scale, |largest, pair| largest.max(pair.0.abs()));
            let exhausted = fresh.iter().all(|pair| pair.0.abs() <= ROUNDING * largest);
            let next = fresh.iter().fold(0.0f64, |largest, pair| largest.max(pair.0));
            found.extend(fresh);
            found.sort_by(|a, b| b.0.total_cmp(&a.0));
            if exhausted || self.is_complete(&found, count, next) {
                return self.pairs(&found, count, true);
            }
        }
        self.pairs(&found, count, false)
    }

    fn pairs(&self, found: &[(f64, Vec<f64>)], count: usize, complete: bool) -> Pairs {
        let largest = found.iter().fold(0.0f64, |largest, pair| largest.max(pair.0.abs()));
        let kept = found.iter().filter(|pair| pair.0 > ROUNDING * largest).take(count);
        let (values, vectors) = kept.map(|(value, y)| (*value, self.factor.backward(&self.project(y)))).unzip();
        Pairs { values, vectors, complete }
    }

    /// Whether nothing is missing above the last pair wanted; `next` is the largest eigenvalue that came last.
    fn is_complete(&self, found: &[(f64, Vec<f64>)], count: usize, next: f64) -> bool {
        let Some(&(last, _)) = found.get(count - 1).filter(|pair| pair.0 > 0.0) else { return false };
        // An auxiliary stiffness in place of a rigid one makes eigenvalues a little larger than they are: the count is
        // coarse there, and a search that brings nothing larger has to agree.
        let rigid = self.constraints.rows() > 0;
        let limit = last * if rigid { COARSE } else { FINE };
        let above = found.iter().take_while(|pair| pair.0 > limit).count();
        (!rigid || next <= last * FINE) && self.count_above(limit) == Some(above)
    }

    /// Number of eigenvalues above a positive limit: negative pivots of K − B/limit.
    fn count_above(&self, limit: f64) -> Option<usize> {
        let shifted = self.stiffness - &self.other.map(|value| value / limit);
        Factor::new(&shifted).map(|factor| factor.negative)
    }

    /// The largest pairs beside those that are known.
    fn search(&self, known: &[(f64, Vec<f64>)], count: usize, search: usize) -> Largest {
        let operator = Deflated { pencil: self, known };
        krylov::largest(self.factor.size(), count, search, TOLERANCE, &mut |y, out| operator.act(y, out))
    }

    /// All pairs of a small network, by falling eigenvalues.
    fn all(&self) -> Vec<(f64, Vec<f64>)> {
        let size = self.factor.size();
        let mut dense = Mat::<f64>::zeros(size, size);
        let (mut unit, mut column) = (vec![0.0; size], vec![0.0; size]);
        for j in 0..size {
            unit[j] = 1.0;
            self.apply(&unit, &mut column);
            unit[j] = 0.0;
            for i in 0..size {
                dense[(i, j)] += 0.5 * column[i];
                dense[(j, i)] += 0.5 * column[i];
            }
        }
        let Ok(eigen) = dense.self_adjoint_eigen(Side::Lower) else { return Vec::new() };
        let (values, vectors) = (eigen.S().column_vector(), eigen.U());
        let pair = |k: usize| (values[k], (0..size).map(|i| vectors[(i, k)]).collect());
        let mut all: Vec<(f64, Vec<f64>)> = (0..size).map(pair).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        all
    }

    /// A y
    fn apply(&self, y: &[f64], out: &mut [f64]) {
        let x = self.factor.backward(&self.project(y));
        let mut b = vec![0.0; x.len()];
        multiply(self.other, &x, &mut b);
        out.copy_from_slice(&self.project(&self.factor.forward(&b)));
    }

    /// Π y
    fn project(&self, y: &[f64]) -> Vec<f64> {
        let mut y = y.to_vec();
        if self.constraints.rows() == 0 {
            return y;
        }
        let length = y.iter().map(|x| x * x).sum::<f64>().sqrt();
        let mut before = f64::INFINITY;
        for _ in 0..CORRECTIONS {
            let x = self.factor.backward(&y);
            let mut strains = vec![0.0; self.constraints.rows()];
            multiply(self.constraints, &x, &mut strains);
            let left = strains.iter().map(|x| x * x).sum::<f64>().sqrt();
            // What rounding leaves does not shrink any more.
            if left <= CORRECTED * length || left > 0.9 * before {
                break;
            }
            before = left;
            let mut back = vec![0.0; x.len()];
            for (row, strain) in self.constraints.outer_iterator().zip(&strains) {
                for (column, value) in row.iter() {
                    back[column] += value * strain;
                }
            }
            y.iter_mut().zip(self.factor.forward(&back)).for_each(|(y, f)| *y -= f);
        }
        y
    }
}

/// out = M x
pub fn multiply(matrix: &CsMat<f64>, x: &[f64], out: &mut [f64]) {
    for (row, out) in matrix.outer_iterator().zip(out) {
        *out = row.iter().map(|(column, value)| value * x[column]).sum();
    }
}

/// A with known pairs taken out.
#[derive(Debug)]
struct Deflated<'a> {
    pencil: &'a Pencil<'a>,
    known: &'a [(f64, Vec<f64>)],
}

impl Deflated<'_> {
    fn act(&self, y: &[f64], out: &mut [f64]) {
        let mut y = y.to_vec();
        self.take_out(&mut y);
        self.pencil.apply(&y, out);
        self.take_out(out);
    }

    fn take_out(&self, y: &mut [f64]) {
        for (_, known) in self.known {
            let along: f64 = y.iter().zip(known).map(|(a, b)| a * b).sum();
            y.iter_mut().zip(known).for_each(|(y, k)| *y -= along * k);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sprs::TriMat;

    /// Copies of one row of springs and masses between walls: ω² = 2 − 2 cos(kπ/(n + 1)), each as often as there are
    /// copies.
    #[test]
    fn multiple_eigenvalues_are_found_as_often_as_they_are() {
        let (copies, n) = (12, 60);
        let size = copies * n;
        let mut stiffness = TriMat::new((size, size));
        let mut mass = TriMat::new((size, size));
        for i in 0..size {
            stiffness.add_triplet(i, i, 2.0);
            mass.add_triplet(i, i, 1.0);
            if i % n + 1 < n {
                stiffness.add_triplet(i, i + 1, -1.0);
                stiffness.add_triplet(i + 1, i, -1.0);
            }
        }
        let (stiffness, mass): (CsMat<f64>, CsMat<f64>) = (stiffness.to_csr(), mass.to_csr());
        let none = TriMat::new((0, size)).to_csr();
        let pencil = Pencil::new(Factor::new(&stiffness).unwrap(), &stiffness, &mass, &none);
        for count in [6, 30] {
            let pairs = pencil.largest(count);
            assert!(pairs.complete);
            assert_eq!(pairs.values.len(), count);
            for (k, value) in pairs.values.iter().enumerate() {
                let angle = (k / copies + 1) as f64 * std::f64::consts::PI / (n + 1) as f64;
                let exact = 1.0 / (2.0 - 2.0 * angle.cos());
                assert!((value / exact - 1.0).abs() < 1e-11, "{count}, {k}: {value} {exact}");
            }
        }
    }
}
