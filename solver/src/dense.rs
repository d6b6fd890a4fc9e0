//! Small dense systems, factorized L U with row pivoting in a buffer that is kept.

/// A square matrix and, once factorized, its factors.
#[derive(Clone, Debug, Default)]
pub(crate) struct Dense {
    size: usize,
    /// By rows.
    values: Vec<f64>,
    /// The row that each step exchanged its own with.
    exchanged: Vec<usize>,
    negative: bool,
}

impl Dense {
    /// Makes this an identity matrix; allocates only where it grows.
    pub(crate) fn set_identity(&mut self, size: usize) {
        self.size = size;
        self.values.clear();
        self.values.resize(size * size, 0.0);
        self.values.iter_mut().step_by(size + 1).for_each(|x| *x = 1.0);
    }

    pub(crate) fn add(&mut self, row: usize, column: usize, value: f64) {
        self.values[row * self.size + column] += value;
    }

    pub(crate) fn factorize(&mut self) {
        let n = self.size;
        self.exchanged.clear();
        self.negative = false;
        for k in 0..n {
            let largest = |best: usize, row: usize| {
                if self.values[row * n + k].abs() > self.values[best * n + k].abs() { row } else { best }
            };
            let pivot = (k + 1..n).fold(k, largest);
            self.exchanged.push(pivot);
            if pivot != k {
                self.negative = !self.negative;
                let (above, below) = self.values.split_at_mut(pivot * n);
                above[k * n..(k + 1) * n].swap_with_slice(&mut below[..n]);
            }
            let (above, below) = self.values.split_at_mut((k + 1) * n);
            let row = &above[k * n..];
            self.negative ^= row[k] < 0.0;
            for other in below.chunks_exact_mut(n) {
                let factor = other[k] / row[k];
                other[k] = factor;
                for j in k + 1..n {
                    other[j] -= factor * row[j];
                }
            }
        }
    }

    /// Whether the determinant of the factorized matrix is negative.
    pub(crate) fn is_negative(&self) -> bool {
        self.negative
    }

    /// Solves in place with the factors; false where the matrix is singular.
    pub(crate) fn solve(&self, b: &mut [f64]) -> bool {
        let n = self.size;
        for (k, &pivot) in self.exchanged.iter().enumerate() {
            b.swap(k, pivot);
        }
        for i in 1..n {
            let sum: f64 = (0..i).map(|j| self.values[i * n + j] * b[j]).sum();
            b[i] -= sum;
        }
        for k in (0..n).rev() {
            let sum: f64 = (k + 1..n).map(|j| self.values[k * n + j] * b[j]).sum();
            let pivot = self.values[k * n + k];
            if pivot == 0.0 {
                return false;
            }
            b[k] = (b[k] - sum) / pivot;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_exchanged_and_the_sign_of_the_determinant_is_kept() {
        let mut matrix = Dense::default();
        matrix.set_identity(3);
        // [[0, 2, 1], [1, 1, 0], [4, 0, 1]] has the determinant −6.
        for (row, column, value) in [(0, 0, -1.0), (0, 1, 2.0), (0, 2, 1.0), (1, 0, 1.0), (2, 0, 4.0)] {
            matrix.add(row, column, value);
        }
        matrix.factorize();
        assert!(matrix.is_negative());
        let mut b = [7.0, 3.0, 7.0];
        assert!(matrix.solve(&mut b));
        let error = b.iter().zip([1.0, 2.0, 3.0]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-15, "{b:?}");
    }

    #[test]
    fn a_singular_matrix_has_no_solution() {
        let mut matrix = Dense::default();
        matrix.set_identity(2);
        matrix.add(1, 1, -1.0);
        matrix.factorize();
        assert!(!matrix.solve(&mut [1.0, 1.0]));
    }
}
