//! Sparse symmetric factorization L D Lᵀ of the joint equations: analysed once, factorized often.

use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par, Side};

use crate::blocks::Blocks;
use crate::wide::{Double, Wide, two_sum};

/// Pivots smaller than this part of the diagonal entry they came from are rounding in an unloaded structure.
pub(crate) const PIVOT_NOISE: f64 = 1e-12;
/// The same where motions may be as soft as loads make them: a unit in the last place for each of a few operations.
pub(crate) use pennate_chains::ROUNDING;

/// The same of sums in twice the digits.
const ROUNDING_IN_TWO: f64 = ROUNDING * f64::EPSILON;

/// From this size on columns are factorized several at once: joints have six of them each, which pays even where there
/// are few entries.
const SUPERNODAL: usize = 256;

/// What the pivots of a factorization say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pivots {
    pub negative: usize,
    /// Pivots that are rounding alone, whatever their sign.
    pub neutral: usize,
    /// Pivots that are rounding in an unloaded structure, those included.
    pub idle: usize,
    /// Smallest pivot over the diagonal entry it came from, in magnitude.
    pub smallest: f64,
}

/// Where the entries of a matrix are, and what was found out about its factors.
#[derive(Debug)]
struct Analysis {
    size: usize,
    /// Lower triangle by columns.
    pattern: SymbolicSparseColMat<usize>,
    /// Positions of the diagonal among the entries.
    diagonal: Vec<usize>,
    symbolic: Symbolic,
}

/// How a matrix is factorized.
#[derive(Debug)]
enum Symbolic {
    /// There is nothing to do.
    Nothing,
    Whole(SymbolicCholesky<usize>),
    Blocks(Blocks),
}

/// The symmetric matrix of the joints, its pattern and its factors.
pub struct Symmetric {
    analysis: Arc<Analysis>,
    /// Lower triangle by columns.
    pub values: Vec<f64>,
    /// What rounding takes from sums in `values`, where both are kept; else nothing.
    pub(crate) low: Vec<f64>,
    /// Factors of both.
    wide: Option<Box<Wide>>,
    factor: Vec<f64>,
    memory: MemBuffer,
    room: Vec<f64>,
    factorized: bool,
    /// Diagonal of the unloaded structure: where a softened one is smaller, pivots are measured by this.
    pub rest: Vec<f64>,
}

impl std::fmt::Debug for Symmetric {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Symmetric").field("size", &self.size()).field("entries", &self.values.len()).finish()
    }
}

impl Symmetric {
    /// The pattern of the lower triangle: pairs (row, column) with row ≥ column, in any order, repeats allowed. The
    /// diagonal is always there. With `in_blocks` equal blocks, one or many, are eliminated side by side where they are small.
    pub(crate) fn new(size: usize, pairs: &mut Vec<(usize, usize)>, in_blocks: bool) -> Self {
        pairs.extend((0..size).map(|i| (i, i)));
        // Pairs mostly come in order, and so does the diagonal: a sort that merges what is sorted has next to nothing to do.
        pairs.sort_by_key(|&(row, column)| (column, row));
        pairs.dedup();
        let mut column_starts = vec![0; size + 1];
        let mut diagonal = vec![0; size];
        for (position, &(row, column)) in pairs.iter().enumerate() {
            column_starts[column + 1] += 1;
            if row == column {
                diagonal[column] = position;
            }
        }
        for i in 0..size {
            column_starts[i + 1] += column_starts[i];
        }
        let rows = pairs.iter().map(|p| p.0).collect();
        let pattern = SymbolicSparseColMat::new_checked(size, size, column_starts, None, rows);
        let blocks = if in_blocks { Blocks::of(pattern.col_ptr(), pattern.row_idx()) } else { None };
        let symbolic = blocks.map_or_else(|| Self::whole(size, &pattern), Symbolic::Blocks);
        Self::of(Arc::new(Analysis { size, pattern, diagonal, symbolic }))
    }

    fn whole(size: usize, pattern: &SymbolicSparseColMat<usize>) -> Symbolic {
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: match size {
                SUPERNODAL.. => SupernodalThreshold::FORCE_SUPERNODAL,
                _ => SupernodalThreshold::AUTO,
            },
            ..CholeskySymbolicParams::default()
        };
        (size > 0)
            .then(|| factorize_symbolic_cholesky(pattern.as_ref(), Side::Lower, SymmetricOrdering::Amd, parameters))
            .and_then(Result::ok)
            .map_or(Symbolic::Nothing, Symbolic::Whole)
    }

    /// Another matrix of the same pattern, which need not be analysed again.
    pub(crate) fn alike(&self) -> Self {
        Self::of(Arc::clone(&self.analysis))
    }

    fn of(analysis: Arc<Analysis>) -> Self {
        let (length, memory, room) = match &analysis.symbolic {
            Symbolic::Nothing => (0, StackReq::empty(), 0),
            Symbolic::Blocks(blocks) => (blocks.len(), StackReq::empty(), blocks.room()),
            Symbolic::Whole(symbolic) => {
                let factorize = symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default());
                let solve = symbolic.solve_in_place_scratch::<f64>(6, Par::Seq);
                (symbolic.len_val(), factorize.or(solve), 0)
            }
        };
        Self {
            values: vec![0.0; analysis.pattern.row_idx().len()],
            rest: vec![0.0; analysis.size],
            low: Vec::new(),
            wide: None,
            analysis,
            factor: vec![0.0; length],
            memory: MemBuffer::new(memory),
            room: vec![0.0; room],
            factorized: false,
        }
    }

    pub fn size(&self) -> usize {
        self.analysis.size
    }

    /// Where the entry lies in `values`; `None` above the diagonal or outside the pattern.
    #[inline]
    pub(crate) fn position(&self, row: usize, column: usize) -> Option<usize> {
        let pattern = &self.analysis.pattern;
        let range = pattern.col_ptr()[column]..pattern.col_ptr()[column + 1];
        pattern.row_idx()[range.clone()].binary_search(&row).ok().map(|i| range.start + i)
    }

    /// Entries of the lower triangle: row, column, value.
    pub(crate) fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        let pattern = &self.analysis.pattern;
        let columns = pattern.col_ptr().windows(2).enumerate();
        columns.flat_map(move |(column, range)| {
            (range[0]..range[1]).map(move |k| (self.analysis.pattern.row_idx()[k], column, self.values[k]))
        })
    }

    pub(crate) fn clear(&mut self) {
        self.values.fill(0.0);
        self.low.fill(0.0);
    }

    /// Keeps sums and factors in twice the digits from the next assembly on, or no longer.
    pub(crate) fn widen(&mut self, wide: bool) {
        if wide == self.is_wide() || self.size() == 0 {
            return;
        }
        self.factorized = false;
        self.low.clear();
        if wide && self.wide.is_none() {
            let pattern = &self.analysis.pattern;
            self.wide = Wide::of(pattern.col_ptr(), pattern.row_idx()).map(Box::new);
        }
        if wide && self.wide.is_some() {
            self.low.resize(self.values.len(), 0.0);
        }
    }

    /// Whether sums and factors are kept in twice the digits.
    pub(crate) fn is_wide(&self) -> bool {
        !self.low.is_empty()
    }

    /// Adds to an entry.
    #[inline]
    pub(crate) fn add(&mut self, position: usize, value: f64) {
        if let Some(low) = self.low.get_mut(position) {
            let sum = two_sum(self.values[position], value);
            self.values[position] = sum.high;
            *low += sum.low;
        } else {
            self.values[position] += value;
        }
    }

    pub(crate) fn diagonal(&self, index: usize) -> f64 {
        self.values[self.analysis.diagonal[index]]
    }

    /// Whether the last factorization met no pivot of exactly zero, so that there is an inverse.
    pub(crate) fn is_factorized(&self) -> bool {
        self.factorized
    }

    /// Adds `factor` times the weights to the diagonal.
    pub(crate) fn shift(&mut self, factor: f64, weights: &[f64]) {
        for (&position, weight) in self.analysis.diagonal.iter().zip(weights) {
            self.values[position] += factor * weight;
        }
    }

    /// y = A x, for the matrix of the same pattern with these values.
    pub(crate) fn apply_values(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        let pattern = &self.analysis.pattern;
        let (starts, rows) = (pattern.col_ptr(), pattern.row_idx());
        y.fill(0.0);
        for column in 0..self.size() {
            for k in starts[column]..starts[column + 1] {
                let row = rows[k];
                y[row] += values[k] * x[column];
                if row != column {
                    y[column] += values[k] * x[row];
                }
            }
        }
    }

    /// xᵀ K x, for the matrix with these values.
    pub(crate) fn energy(&self, values: &[f64], x: &[f64]) -> f64 {
        if !self.is_wide() {
            let mut product = vec![0.0; x.len()];
            self.apply_values(values, x, &mut product);
            return x.iter().zip(&product).map(|(x, k)| x * k).sum();
        }
        let pattern = &self.analysis.pattern;
        let mut energy = Double::default();
        for column in 0..self.size() {
            for k in pattern.col_ptr()[column]..pattern.col_ptr()[column + 1] {
                let row = pattern.row_idx()[k];
                let times = if row == column { x[column] } else { 2.0 * x[column] };
                let entry = two_sum(values[k], self.low[k]);
                energy = energy.plus(entry.times_number(times).times_number(x[row]));
            }
        }
        energy.high
    }

    /// Factorizes; the pivots tell whether the result is of use.
    pub fn factorize(&mut self) -> Pivots {
        let wide = self.wide.as_mut().filter(|_| !self.low.is_empty());
        self.factorized = match (&self.analysis.symbolic, wide) {
            (_, Some(wide)) => wide.factorize(&self.values, &self.low),
            (Symbolic::Nothing, None) => true,
            (Symbolic::Blocks(blocks), None) => blocks.factorize(&self.values, &mut self.factor),
            (Symbolic::Whole(symbolic), None) => {
                let matrix = SparseColMatRef::new(self.analysis.pattern.as_ref(), &self.values);
                let outcome = symbolic.factorize_numeric_ldlt(
                    &mut self.factor,
                    matrix,
                    Side::Lower,
                    LdltRegularization::default(),
                    Par::Seq,
                    MemStack::new(&mut self.memory),
                    Default::default(),
                );
                outcome.is_ok()
            }
        };
        if !self.factorized {
            return Pivots { negative: 0, neutral: 1, idle: 1, smallest: 0.0 };
        }
        self.read_pivots()
    }

    fn read_pivots(&self) -> Pivots {
        let mut pivots = Pivots { smallest: f64::MAX, ..Pivots::default() };
        let wide = self.wide.as_ref().filter(|_| self.is_wide());
        let rounding = if wide.is_some() { ROUNDING_IN_TWO } else { ROUNDING };
        let mut count = |row: usize, pivot: f64| {
            let entry = self.diagonal(row).abs().max(self.rest[row]).max(f64::MIN_POSITIVE);
            let ratio = pivot.abs() / entry;
            if ratio.is_nan() || ratio < pivots.smallest {
                pivots.smallest = if ratio.is_nan() { 0.0 } else { ratio };
            }
            pivots.idle += usize::from(ratio <= PIVOT_NOISE || ratio.is_nan());
            if ratio <= rounding || ratio.is_nan() {
                pivots.neutral += 1;
            } else if pivot < 0.0 {
                pivots.negative += 1;
            }
        };
        match (&self.analysis.symbolic, wide) {
            (_, Some(wide)) => wide.pivots().for_each(|(row, pivot)| count(row, pivot)),
            (Symbolic::Nothing, None) => return Pivots { smallest: 1.0, ..Pivots::default() },
            (Symbolic::Blocks(blocks), None) => blocks.pivots(&self.factor).for_each(|(row, pivot)| count(row, pivot)),
            (Symbolic::Whole(symbolic), None) => self.whole_pivots(symbolic, count),
        }
        pivots
    }

    fn whole_pivots(&self, symbolic: &SymbolicCholesky<usize>, mut count: impl FnMut(usize, f64)) {
        let permutation = symbolic.perm().map(|p| p.arrays().0);
        let mut count = |permuted: usize, pivot: f64| count(permutation.map_or(permuted, |p| p[permuted]), pivot);
        match symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(simplicial) => {
                for (column, &start) in simplicial.col_ptr()[..self.size()].iter().enumerate() {
                    count(column, self.factor[start]);
                }
            }
            SymbolicCholeskyRaw::Supernodal(supernodal) => {
                for s in 0..supernodal.n_supernodes() {
                    let start = supernodal.supernode_begin()[s];
                    let columns = supernodal.supernode_end()[s] - start;
                    let first = supernodal.col_ptr_for_val()[s];
                    let height = (supernodal.col_ptr_for_val()[s + 1] - first) / columns.max(1);
                    for column in 0..columns {
                        count(start + column, self.factor[first + column * height + column]);
                    }
                }
            }
        }
    }

    /// Solves in place for `columns` right-hand sides, one after the other in `rhs`; false where there is no factor.
    pub(crate) fn solve(&mut self, rhs: &mut [f64], columns: usize) -> bool {
        let size = self.analysis.size;
        let wide = self.wide.as_mut().filter(|_| !self.low.is_empty());
        match (&self.analysis.symbolic, wide) {
            (Symbolic::Nothing, _) => return true,
            _ if !self.factorized => return false,
            (_, Some(wide)) => rhs[..columns * size].chunks_exact_mut(size).for_each(|column| wide.solve(column)),
            (Symbolic::Blocks(blocks), None) => {
                for column in rhs[..columns * size].chunks_exact_mut(size) {
                    blocks.solve(&self.factor, column, &mut self.room);
                }
            }
            (Symbolic::Whole(symbolic), None) => {
                let factor = LdltRef::new(symbolic, &self.factor);
                for first in (0..columns).step_by(6) {
                    let count = (columns - first).min(6);
                    let part = &mut rhs[first * size..(first + count) * size];
                    let part = MatMut::from_column_major_slice_mut(part, size, count);
                    factor.solve_in_place_with_conj(Conj::No, part, Par::Seq, MemStack::new(&mut self.memory));
                }
            }
        }
        rhs.iter().all(|x| x.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of springs with one negative one, small (simplicial) and large and dense (supernodal).
    fn check(size: usize, band: usize, negative: &[usize]) {
        let mut pairs = Vec::new();
        for i in 0..size {
            for j in i.saturating_sub(band)..i {
                pairs.push((i, j));
            }
        }
        let mut k = Symmetric::new(size, &mut pairs, false);
        for i in 0..size {
            for j in i.saturating_sub(band)..=i {
                let position = k.position(i, j).unwrap();
                let sign = if negative.contains(&i) { -1.0 } else { 1.0 };
                k.values[position] = if i == j { sign * 2.0 * (band as f64 + 1.0) } else { -0.5 / (i - j) as f64 };
            }
        }
        let pivots = k.factorize();
        assert_eq!((pivots.negative, pivots.neutral), (negative.len(), 0));
        let x: Vec<f64> = (0..size).map(|i| (i as f64).sin()).collect();
        let mut b = vec![0.0; size];
        k.apply_values(&k.values, &x, &mut b);
        assert!(k.solve(&mut b, 1));
        let error = x.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-12, "{error}");
    }

    #[test]
    fn solves_and_counts_negative_pivots_on_both_paths() {
        check(5, 1, &[2]);
        check(40, 2, &[]);
        check(300, 120, &[7, 150, 299]);
    }

    #[test]
    fn a_singular_matrix_shows_a_neutral_pivot() {
        let mut k = Symmetric::new(2, &mut vec![(1, 0)], false);
        k.values = vec![1.0, -1.0, 1.0];
        let pivots = k.factorize();
        assert_eq!(pivots.neutral, 1);
    }
}
