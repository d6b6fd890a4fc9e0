//! Factors L D Lᵀ in twice the digits, for sums of entries that differ by many orders.
//!
//! A stiff beam on soft columns adds its stiffness to both of its joints and takes it from their product: what is left of the two as
//! one is that of the columns, and a sum in sixteen digits has lost it. Members keep what they are as a whole to the last bit, so
//! that a sum of two numbers, and an elimination that goes on with both, has it still.
//!
//! Theory: docs/theory/stability.md.

use crate::simplicial::Simplicial;

/// A number as the sum of two, the second of which is rounding of the first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Double {
    pub high: f64,
    pub low: f64,
}

/// The sum of two numbers, and what its rounding left.
#[inline(always)]
pub(crate) fn two_sum(a: f64, b: f64) -> Double {
    let high = a + b;
    let part = high - a;
    Double { high, low: (a - (high - part)) + (b - part) }
}

/// The same where the first is the larger one.
#[inline(always)]
fn quick_sum(a: f64, b: f64) -> Double {
    let high = a + b;
    Double { high, low: b - (high - a) }
}

/// Halves of a number, products of which are exact (T. J. Dekker, Numer. Math. 18, 1971).
#[inline(always)]
fn halves(x: f64) -> [f64; 2] {
    const SPLITTER: f64 = 134_217_729.0;
    let large = SPLITTER * x;
    let first = large - (large - x);
    [first, x - first]
}

/// The product of two numbers, and what its rounding left.
fn two_product(a: f64, b: f64) -> Double {
    let high = a * b;
    let ([a1, a2], [b1, b2]) = (halves(a), halves(b));
    Double { high, low: ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2 }
}

impl Double {
    pub(crate) fn plus(self, other: Self) -> Self {
        let (sum, rest) = (two_sum(self.high, other.high), two_sum(self.low, other.low));
        let first = quick_sum(sum.high, sum.low + rest.high);
        quick_sum(first.high, first.low + rest.low)
    }

    pub(crate) fn times_number(self, other: f64) -> Self {
        let product = two_product(self.high, other);
        quick_sum(product.high, product.low + self.low * other)
    }

    /// Less a product, to twice the digits of the larger of both.
    #[inline(always)]
    fn minus_product(self, a: Self, b: Self) -> Self {
        let product = a.high * b.high;
        let ([a1, a2], [b1, b2]) = (halves(a.high), halves(b.high));
        let rest = (((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2) + (a.high * b.low + a.low * b.high);
        let sum = two_sum(self.high, -product);
        quick_sum(sum.high, sum.low + (self.low - rest))
    }

    fn over(self, other: Self) -> Self {
        let first = self.high / other.high;
        let rest = self.minus_product(Self::from(first), other);
        let second = rest.high / other.high;
        let rest = rest.minus_product(Self::from(second), other);
        quick_sum(first, second).plus(Self::from(rest.high / other.high))
    }
}

impl From<f64> for Double {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

/// Where the factors are, and the factors.
#[derive(Debug)]
pub(crate) struct Wide {
    /// Row of the matrix by row of the factors.
    order: Vec<usize>,
    /// Where each entry of the matrix is among the factors.
    places: Vec<usize>,
    /// Columns of the factors: the diagonal first, then what is below it.
    starts: Vec<usize>,
    rows: Vec<usize>,
    factors: Vec<Double>,
    /// Of a row: where it is in the column that is eliminated.
    place_of_row: Vec<usize>,
    room: Vec<Double>,
}

impl Wide {
    /// Room for the factors of a pattern, columns of the lower triangle from the diagonal on.
    pub(crate) fn of(starts: &[usize], rows: &[usize]) -> Option<Self> {
        let size = starts.len() - 1;
        let factors = Simplicial::of(starts, rows)?;
        Some(Self {
            places: factors.places(starts, rows)?,
            factors: vec![Double::default(); factors.rows.len()],
            order: factors.order,
            starts: factors.starts,
            rows: factors.rows,
            place_of_row: vec![0; size],
            room: vec![Double::default(); size],
        })
    }

    /// Factorizes the sum of both values of every entry; false where a pivot is zero, or no number.
    pub(crate) fn factorize(&mut self, high: &[f64], low: &[f64]) -> bool {
        let Self { places, starts, rows, factors, place_of_row, .. } = self;
        factors.fill(Double::default());
        for ((&place, &high), &low) in places.iter().zip(high).zip(low) {
            factors[place] = two_sum(high, low);
        }
        for column in 0..starts.len() - 1 {
            let (first, end) = (starts[column], starts[column + 1]);
            let pivot = factors[first];
            if pivot.high == 0.0 || !pivot.high.is_finite() {
                return false;
            }
            // Columns to the right first, by what this one is before its division.
            for k in first + 1..end {
                let target = rows[k];
                let scaled = factors[k].over(pivot);
                let own = starts[target];
                // The rows of this column from there on are among those of the other: where they are as many, they are the same.
                if starts[target + 1] - own == end - k {
                    let (before, after) = factors.split_at_mut(own);
                    for (factor, &other) in after.iter_mut().zip(&before[k..end]) {
                        *factor = factor.minus_product(scaled, other);
                    }
                    continue;
                }
                (own..starts[target + 1]).for_each(|place| place_of_row[rows[place]] = place);
                for i in k..end {
                    let place = place_of_row[rows[i]];
                    factors[place] = factors[place].minus_product(scaled, factors[i]);
                }
            }
            for factor in &mut factors[first + 1..end] {
                *factor = factor.over(pivot);
            }
        }
        true
    }

    /// Rows of the matrix, and the pivots that were found for them.
    pub(crate) fn pivots(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.order.iter().zip(&self.starts).map(|(&row, &start)| (row, self.factors[start].high))
    }

    /// Solves in place for one right-hand side.
    pub(crate) fn solve(&mut self, rhs: &mut [f64]) {
        let Self { order, starts, rows, factors, room, .. } = self;
        for (own, &row) in room.iter_mut().zip(&*order) {
            *own = Double::from(rhs[row]);
        }
        for column in 0..order.len() {
            let x = room[column];
            for k in starts[column] + 1..starts[column + 1] {
                room[rows[k]] = room[rows[k]].minus_product(factors[k], x);
            }
        }
        for column in (0..order.len()).rev() {
            let mut x = room[column].over(factors[starts[column]]);
            for k in starts[column] + 1..starts[column + 1] {
                x = x.minus_product(factors[k], room[rows[k]]);
            }
            room[column] = x;
        }
        for (own, &row) in room.iter().zip(&*order) {
            rhs[row] = own.high;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two masses on soft springs to the ground, and a spring between them that is stiffer by more than all digits.
    #[test]
    fn what_is_soft_beside_a_sum_is_kept() {
        let (soft, stiff) = (3.0e-11, 1.0e9 + 1.0);
        let sum = two_sum(stiff, soft);
        let mut wide = Wide::of(&[0, 2, 3], &[0, 1, 1]).unwrap();
        assert!(wide.factorize(&[sum.high, -stiff, sum.high], &[sum.low, 0.0, sum.low]));
        let mut x = [1.0, 1.0];
        wide.solve(&mut x);
        assert!(x.iter().all(|x| (x * soft - 1.0).abs() < 1e-11), "{x:?}");
        assert!(wide.pivots().all(|(_, pivot)| pivot > 0.0));
    }

    #[test]
    fn solves_as_the_narrow_one_does() {
        let size = 40;
        let mut pairs = Vec::new();
        for i in 0..size {
            pairs.extend([i, (i + 7) % size].map(|j| (i.max(j), i.min(j))));
        }
        let mut k = crate::linear::Symmetric::new(size, &mut pairs, false);
        for (row, column) in pairs {
            let position = k.position(row, column).unwrap();
            k.values[position] = if row == column { (row as f64 + 0.5).sin() * 9.0 } else { 1.0 / (1 + row) as f64 };
        }
        let narrow = k.factorize();
        let b: Vec<f64> = (0..size).map(|i| (i as f64).cos()).collect();
        let (mut x, mut y) = (b.clone(), b);
        assert!(k.solve(&mut x, 1));
        k.widen(true);
        let wide = k.factorize();
        assert!(k.solve(&mut y, 1));
        assert_eq!(narrow.negative, wide.negative);
        assert!(x.iter().zip(&y).all(|(a, b)| (a - b).abs() < 1e-9 * a.abs().max(1.0)), "{x:?} {y:?}");
    }
}
