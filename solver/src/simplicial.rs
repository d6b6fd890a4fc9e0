//! Where the factors L D Lᵀ of a sparse matrix have their entries, column by column, for eliminations of our own.

use faer::Side;
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};

/// An order of elimination, and the pattern of the factors in that order.
#[derive(Debug)]
pub(crate) struct Simplicial {
    /// Row of the matrix by row of the factors.
    pub(crate) order: Vec<usize>,
    /// Row of the factors by row of the matrix.
    pub(crate) place_of: Vec<usize>,
    /// Columns of the factors: the diagonal first, then what is below it, by rows.
    pub(crate) starts: Vec<usize>,
    pub(crate) rows: Vec<usize>,
}

impl Simplicial {
    /// The factors of a pattern, columns of the lower triangle from the diagonal on; nothing where memory does not suffice.
    pub(crate) fn of(starts: &[usize], rows: &[usize]) -> Option<Self> {
        let size = starts.len() - 1;
        let pattern = SymbolicSparseColMatRef::new_checked(size, size, starts, None, rows);
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SIMPLICIAL,
            ..CholeskySymbolicParams::default()
        };
        let symbolic = factorize_symbolic_cholesky(pattern, Side::Lower, SymmetricOrdering::Amd, parameters).ok()?;
        let SymbolicCholeskyRaw::Simplicial(factors) = symbolic.raw() else { return None };
        let order: Vec<usize> = symbolic.perm().map_or_else(|| (0..size).collect(), |p| p.arrays().0.to_vec());
        let mut place_of = vec![0; size];
        order.iter().enumerate().for_each(|(place, &row)| place_of[row] = place);
        Some(Self { order, place_of, starts: factors.col_ptr().to_vec(), rows: factors.row_idx().to_vec() })
    }

    /// Where an entry of the factors is, given by its row and column among them, on or below the diagonal.
    pub(crate) fn place(&self, row: usize, column: usize) -> Option<usize> {
        let range = self.starts[column]..self.starts[column + 1];
        let found = self.rows[range.clone()].binary_search(&row).ok()?;
        Some(range.start + found)
    }

    /// Where each entry of the matrix is among the factors, in the order of its columns.
    pub(crate) fn places(&self, starts: &[usize], rows: &[usize]) -> Option<Vec<usize>> {
        let columns = starts.windows(2).zip(&self.place_of);
        let entries = columns.flat_map(|(range, &b)| rows[range[0]..range[1]].iter().map(move |&row| (row, b)));
        entries.map(|(row, b)| self.place(self.place_of[row].max(b), self.place_of[row].min(b))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ring of five rows: eliminating any of them joins its neighbours, two entries more than the matrix has.
    #[test]
    fn a_ring_fills_in_what_joins_its_neighbours() {
        let (starts, rows) = (vec![0, 3, 5, 7, 9, 10], vec![0, 1, 4, 1, 2, 2, 3, 3, 4, 4]);
        let factors = Simplicial::of(&starts, &rows).expect("a pattern");
        assert_eq!(factors.rows.len(), rows.len() + 2);
        for (place, &row) in factors.order.iter().enumerate() {
            assert_eq!(factors.place_of[row], place);
            assert_eq!(factors.rows[factors.starts[place]], place);
        }
        let places = factors.places(&starts, &rows).expect("the factors hold the matrix");
        let mut distinct = places.clone();
        distinct.sort_unstable();
        distinct.dedup();
        assert_eq!(distinct.len(), rows.len());
        for (column, range) in starts.windows(2).enumerate() {
            for entry in range[0]..range[1] {
                let [a, b] = [rows[entry], column].map(|row| factors.place_of[row]);
                assert_eq!(factors.rows[places[entry]], a.max(b));
                assert!((factors.starts[a.min(b)]..factors.starts[a.min(b) + 1]).contains(&places[entry]));
            }
        }
    }
}
