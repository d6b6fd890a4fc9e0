//! Factors L D U of matrices that are unsymmetric and have the pattern of a symmetric one, for the sign and the size of their determinant.
//!
//! Pivots are taken as they come: what these matrices are is a symmetric positive matrix changed a little, and where that is not
//! so any more a rough determinant tells it. The factors are found row and column at once (Crout),
//! ```text
//! dₖ = aₖₖ − Σⱼ lₖⱼ dⱼ uⱼₖ        lᵢₖ dₖ = aᵢₖ − Σⱼ lᵢⱼ dⱼ uⱼₖ        dₖ uₖᵢ = aₖᵢ − Σⱼ lₖⱼ dⱼ uⱼᵢ        for j < k < i
//! ```

use crate::simplicial::Simplicial;

/// Where the entries of a matrix of several blocks are among its factors. Each block is eliminated in an order of its own, whatever
/// others there are.
#[derive(Debug, Default)]
pub(crate) struct Places {
    /// Row of the factors by row of the matrix.
    of: Vec<usize>,
    /// Columns of the factors, below the diagonal.
    starts: Vec<usize>,
    rows: Vec<usize>,
}

/// A matrix, and then its factors.
pub(crate) struct Unsymmetric<'a> {
    places: &'a Places,
    diagonal: Vec<f64>,
    /// Entries below the diagonal, by columns, and those of the transpose.
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl Places {
    /// Those of a matrix of so many rows, in blocks whose rows are given; no group of rows that meet reaches beyond a block.
    pub(crate) fn of(size: usize, blocks: &[Vec<usize>], groups: &[Vec<usize>]) -> Option<Self> {
        let mut local = vec![0; size];
        let mut block_of = vec![0; size];
        for (block, rows) in blocks.iter().enumerate() {
            for (index, &row) in rows.iter().enumerate() {
                (local[row], block_of[row]) = (index, block);
            }
        }
        let mut columns: Vec<Vec<Vec<usize>>> = blocks.iter().map(|rows| vec![Vec::new(); rows.len()]).collect();
        for group in groups {
            for (&a, &b) in group.iter().flat_map(|a| group.iter().map(move |b| (a, b))) {
                if local[a] > local[b] {
                    columns[block_of[b]][local[b]].push(local[a]);
                }
            }
        }
        let mut places = Self { of: vec![0; size], starts: vec![0], rows: Vec::new() };
        for (rows, columns) in blocks.iter().zip(columns) {
            places.add_block(rows, columns)?;
        }
        Some(places)
    }

    /// Adds a block of these rows, whose columns have these entries below the diagonal.
    fn add_block(&mut self, rows: &[usize], columns: Vec<Vec<usize>>) -> Option<()> {
        let first = self.starts.len() - 1;
        let (mut starts, mut entries) = (vec![0], Vec::new());
        for (diagonal, mut below) in columns.into_iter().enumerate() {
            below.sort_unstable();
            below.dedup();
            entries.push(diagonal);
            entries.extend(below);
            starts.push(entries.len());
        }
        let factors = Simplicial::of(&starts, &entries)?;
        for (row, place) in rows.iter().zip(&factors.place_of) {
            self.of[*row] = first + place;
        }
        for column in factors.starts.windows(2) {
            self.rows.extend(factors.rows[column[0] + 1..column[1]].iter().map(|row| first + row));
            self.starts.push(self.rows.len());
        }
        Some(())
    }

    /// A matrix of this pattern with nothing in it.
    pub(crate) fn matrix(&self) -> Unsymmetric<'_> {
        let zeros = || vec![0.0; self.rows.len()];
        Unsymmetric { places: self, diagonal: vec![0.0; self.of.len()], lower: zeros(), upper: zeros() }
    }
}

impl Unsymmetric<'_> {
    /// Adds to an entry of the matrix.
    pub(crate) fn add(&mut self, row: usize, column: usize, value: f64) {
        let [row, column] = [row, column].map(|index| self.places.of[index]);
        if row == column {
            self.diagonal[row] += value;
            return;
        }
        let (first, last) = (row.min(column), row.max(column));
        let range = self.places.starts[first]..self.places.starts[first + 1];
        if let Ok(found) = self.places.rows[range.clone()].binary_search(&last) {
            let values = if row > column { &mut self.lower } else { &mut self.upper };
            values[range.start + found] += value;
        }
    }

    /// The pivots, by rows of the matrix.
    pub(crate) fn pivots(mut self) -> Vec<f64> {
        self.eliminate();
        self.places.of.iter().map(|&place| self.diagonal[place]).collect()
    }

    fn eliminate(&mut self) {
        const NONE: usize = usize::MAX;
        let Self { places: Places { starts, rows, .. }, diagonal, lower, upper } = self;
        let size = diagonal.len();
        // Columns before this one that have an entry in its row, each in the list of the row that it comes to next.
        let (mut heads, mut followers) = (vec![NONE; size], vec![NONE; size]);
        let (mut reached, mut place) = (starts.clone(), vec![0; size]);
        for k in 0..size {
            let own = starts[k]..starts[k + 1];
            for at in own.clone() {
                place[rows[at]] = at;
            }
            let mut column = heads[k];
            while column != NONE {
                let follower = followers[column];
                let at = reached[column];
                let (left, right) = (lower[at], upper[at] * diagonal[column]);
                diagonal[k] -= left * right;
                for other in at + 1..starts[column + 1] {
                    let here = place[rows[other]];
                    lower[here] -= lower[other] * right;
                    upper[here] -= left * diagonal[column] * upper[other];
                }
                reached[column] = at + 1;
                if at + 1 < starts[column + 1] {
                    let next = rows[at + 1];
                    (followers[column], heads[next]) = (heads[next], column);
                }
                column = follower;
            }
            for at in own.clone() {
                lower[at] /= diagonal[k];
                upper[at] /= diagonal[k];
            }
            if let Some(&next) = rows[own].first() {
                (followers[k], heads[next]) = (heads[next], k);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::any;

    /// The determinant of a matrix by its pivots is that of the same matrix, dense, by faer, in two blocks at once.
    #[test]
    fn pivots_multiply_to_the_determinant() {
        let blocks = [vec![0, 2, 4, 6, 8, 9, 10], vec![1, 3, 5, 7]];
        let groups: Vec<Vec<usize>> =
            [&[0, 2, 4][..], &[4, 6], &[6, 8, 9], &[9, 10], &[1, 3], &[3, 5, 7]].map(<[usize]>::to_vec).into();
        let places = Places::of(11, &blocks, &groups).expect("a pattern");
        let mut matrix = places.matrix();
        let mut dense = faer::Mat::<f64>::zeros(11, 11);
        let mut seed = 0;
        for group in &groups {
            for &row in group {
                for &column in group {
                    seed += 1;
                    let value = any(seed) + if row == column { 3.0 } else { 0.0 };
                    matrix.add(row, column, value);
                    dense[(row, column)] += value;
                }
            }
        }
        let pivots = matrix.pivots();
        for block in &blocks {
            let own = faer::Mat::from_fn(block.len(), block.len(), |i, j| dense[(block[i], block[j])]);
            let found: f64 = block.iter().map(|&row| pivots[row]).product();
            assert!((found / own.determinant() - 1.0).abs() < 1e-12, "{found} {}", own.determinant());
        }
    }
}
