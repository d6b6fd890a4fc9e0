//! Forces along the rows of a joint, and motions that change them: both need the pseudo-inverse of the rows' gradients.
//!
//! Rows may depend on each other, so the gradients, as columns of A, are decomposed with their rank: A = Q L W, where the columns of Q
//! and the rows of W are orthonormal, and L is lower triangular. That takes the same operations whatever the numbers are; an
//! iteration for singular values does not end where one of them is not finite.

use super::dot6;

/// Part of the largest gradient below which what is left of another is that of the rows before it.
const DEPENDENT: f64 = 1e-10;

/// A row of a joint: the gradient of what it holds, and its column of W.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gradient {
    pub by_motion: [f64; 6],
    column: [f64; 6],
}

impl Gradient {
    pub(super) fn new(by_motion: [f64; 6]) -> Self {
        Self { by_motion, column: [0.0; 6] }
    }
}

/// The gradients of the rows of a joint, decomposed.
#[derive(Debug)]
pub(super) struct Gradients<'a> {
    rows: &'a mut [Gradient],
    rank: usize,
    q: [[f64; 6]; 6],
    l: [[f64; 6]; 6],
}

impl<'a> Gradients<'a> {
    pub(super) fn of(rows: &'a mut [Gradient]) -> Self {
        let mut own = Self { rows, rank: 0, q: [[0.0; 6]; 6], l: [[0.0; 6]; 6] };
        own.span();
        own.split();
        own
    }

    /// Finds Q: what is left of the gradients, the largest first.
    fn span(&mut self) {
        let mut largest = 0.0;
        while self.rank < 6 {
            let mut best = ([0.0; 6], 0.0);
            for row in self.rows.iter() {
                let left = without(row.by_motion, &self.q[..self.rank]);
                let length = dot6(&left, &left).sqrt();
                if !(length <= best.1) {
                    best = (left, length);
                }
            }
            let (left, length) = best;
            if length <= DEPENDENT * largest || length == 0.0 {
                break;
            }
            largest = f64::max(largest, length);
            self.q[self.rank] = left.map(|x| x / length);
            self.rank += 1;
        }
    }

    /// Finds L and W from the components of the gradients along Q, row by row.
    fn split(&mut self) {
        for k in 0..self.rank {
            for row in self.rows.iter_mut() {
                row.column[k] = dot6(&self.q[k], &row.by_motion);
            }
            // Twice is enough for what is orthogonal to the last digit.
            for _ in 0..2 {
                for before in 0..k {
                    let along: f64 = self.rows.iter().map(|row| row.column[before] * row.column[k]).sum();
                    self.l[k][before] += along;
                    self.rows.iter_mut().for_each(|row| row.column[k] -= along * row.column[before]);
                }
            }
            let length = self.rows.iter().map(|row| row.column[k] * row.column[k]).sum::<f64>().sqrt();
            self.l[k][k] = length;
            self.rows.iter_mut().for_each(|row| row.column[k] /= length);
        }
    }

    /// The smallest multipliers of the rows that come nearest to a force: λ with A λ = force, in the order of the rows.
    pub(super) fn shares(&self, force: &[f64; 6]) -> impl Iterator<Item = f64> {
        let mut along = [0.0; 6];
        for k in 0..self.rank {
            let known: f64 = (0..k).map(|before| self.l[k][before] * along[before]).sum();
            along[k] = (dot6(&self.q[k], force) - known) / self.l[k][k];
        }
        self.rows.iter().map(move |row| dot6(&row.column, &along))
    }

    /// The smallest motion that comes nearest to these changes of the rows: Aᵀ motion = changes.
    pub(super) fn motion(&self, changes: impl Iterator<Item = f64>) -> [f64; 6] {
        let mut along = [0.0; 6];
        for (row, change) in self.rows.iter().zip(changes) {
            (0..self.rank).for_each(|k| along[k] += row.column[k] * change);
        }
        let mut motion = [0.0; 6];
        for k in (0..self.rank).rev() {
            let known: f64 = (k + 1..self.rank).map(|after| self.l[after][k] * along[after]).sum();
            along[k] = (along[k] - known) / self.l[k][k];
            (0..6).for_each(|c| motion[c] += along[k] * self.q[k][c]);
        }
        motion
    }
}

/// What is left of a vector beside orthonormal others.
fn without(mut vector: [f64; 6], others: &[[f64; 6]]) -> [f64; 6] {
    for _ in 0..2 {
        for other in others {
            let along = dot6(&vector, other);
            (0..6).for_each(|c| vector[c] -= along * other[c]);
        }
    }
    vector
}

#[cfg(test)]
mod tests {
    use super::*;
    use pennate_elements::small::norm;

    fn rows(gradients: &[[f64; 6]]) -> Vec<Gradient> {
        gradients.iter().copied().map(Gradient::new).collect()
    }

    fn made_of(gradients: &[[f64; 6]], shares: &[f64]) -> [f64; 6] {
        let mut sum = [0.0; 6];
        for (gradient, share) in gradients.iter().zip(shares) {
            (0..6).for_each(|c| sum[c] += share * gradient[c]);
        }
        sum
    }

    const SKEW: [[f64; 6]; 4] = [
        [0.6, 0.8, 0.0, 0.0, 30.0, -40.0],
        [0.0, 0.0, 1.0, 7.0, -3.0, 0.0],
        [0.0, 0.0, 0.0, 0.9, 0.1, 0.3],
        [0.0, 0.0, 0.0, 0.2, -0.5, 0.7],
    ];

    /// The shares of rows that do not depend on each other are what their sum was made of, and motions change rows as asked.
    #[test]
    fn independent_rows_share_what_they_make() {
        let shares = [3.0, -2.0, 0.5, 11.0];
        let mut own = rows(&SKEW);
        let gradients = Gradients::of(&mut own);
        let found: Vec<f64> = gradients.shares(&made_of(&SKEW, &shares)).collect();
        let changes = [0.1, -0.4, 2.0, 0.7];
        let motion = gradients.motion(changes.into_iter());
        for r in 0..4 {
            assert!((found[r] - shares[r]).abs() < 1e-12 * 11.0);
            assert!((dot6(&SKEW[r], &motion) - changes[r]).abs() < 1e-12);
        }
    }

    /// Rows that repeat others, more of them than motions, take equal parts, which is the least; what no row reaches is left.
    #[test]
    fn dependent_rows_take_the_least() {
        let twice: Vec<[f64; 6]> = SKEW.iter().chain(&SKEW).copied().collect();
        let shares = [3.0, -2.0, 0.5, 11.0];
        let mut own = rows(&twice);
        let gradients = Gradients::of(&mut own);
        let found: Vec<f64> = gradients.shares(&made_of(&SKEW, &shares)).collect();
        for r in 0..8 {
            assert!((found[r] - 0.5 * shares[r % 4]).abs() < 1e-12 * 11.0, "{found:?}");
        }
        // Of motions that change nothing there is nothing in the smallest one.
        let changes = [0.1, -0.4, 2.0, 0.7];
        let motion = gradients.motion((0..8).map(|r| changes[r % 4]));
        let mut single = rows(&SKEW);
        let other = Gradients::of(&mut single).motion(changes.into_iter());
        let apart: Vec<f64> = (0..6).map(|c| motion[c] - other[c]).collect();
        assert!(norm([apart[0], apart[1], apart[2]]) + norm([apart[3], apart[4], apart[5]]) < 1e-12);
    }

    /// What is no number gives none, and the work ends.
    #[test]
    fn what_is_not_finite_stays_so() {
        for wrong in [f64::NAN, f64::INFINITY] {
            let mut gradients = SKEW;
            gradients[2][4] = wrong;
            let mut own = rows(&gradients);
            let found: Vec<f64> = Gradients::of(&mut own).shares(&[1.0; 6]).collect();
            assert!(found.iter().any(|share| share.is_nan()), "{found:?}");
        }
    }
}
