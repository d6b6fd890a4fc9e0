//! What the tangent says where strains are held, by what it says where they give a little.
//!
//! An auxiliary stiffness stands for strains that are held. It is a compliance c that should be none. Equilibria do not know of it, but the
//! tangent does: compliances and derivatives go as f(c) = f(0) + f′ c + …. What f(0) is follows from some of them, each c a tenth of
//! the one before, by the parabola through the last three. What that leaves goes as the product of the three over the compliances of the rest
//! of the network, and rounding grows as they fall. So there are as many as it takes until the parabola and the line through the last two agree.
//! Rounding moves both alike, so that they may agree by chance: what counts is the parabola that is nearest to its line and to the parabola
//! before it.

use crate::packs::{self, Auxiliary};

/// Auxiliary stiffnesses, the softest first.
pub const AUXILIARIES: [Auxiliary; 9] =
    [of(1e4), of(1e5), packs::MODERATE, packs::EXACTING, packs::AUXILIARY, of(1e9), of(1e10), of(1e11), of(1e12)];
/// Difference of parabola and line, over the largest number of the same row, below which there is nothing more to gain: a tenth of the accuracy
/// that derivatives are asked for, and what the parabola leaves is far less.
const AGREES: f64 = 1e-8;
/// Difference beyond which a row is not known: what the parabola leaves is a good part of what it differs by from the line.
const KNOWN: f64 = 1e-4;
/// Weights of the last three, and of the last two, where each compliance is a tenth of the one before.
const PARABOLA: [f64; 3] = [10.0 / 8910.0, -100.0 / 810.0, 1000.0 / 891.0];
const LINE: [f64; 2] = [-1.0 / 9.0, 10.0 / 9.0];

/// So many times the stiffness of the member, and of the force that it carries in proportion.
const fn of(member: f64) -> Auxiliary {
    Auxiliary { member, carried: 1e-4 * member, ..packs::AUXILIARY }
}

/// Rows of numbers, with one compliance after the other.
#[derive(Debug)]
pub struct Limit<'a> {
    /// By what the numbers of a row are multiplied to compare them.
    sizes: &'a [f64],
    /// Those of the last three compliances.
    rounds: Vec<Vec<f64>>,
    /// How many compliances there were.
    count: usize,
    rows: Vec<Row>,
}

/// What is known of a row without a compliance.
#[derive(Clone, Debug)]
struct Row {
    best: Vec<f64>,
    /// How far the best is from its line, or from the parabola before it, whichever is more, over the largest number of the row.
    off: f64,
    /// How many compliances it took.
    count: usize,
    /// Whether a parabola and its line agreed.
    agrees: bool,
    /// The last parabola.
    last: Vec<f64>,
}

impl<'a> Limit<'a> {
    /// Rows of as many numbers as there are `sizes`, by which they are multiplied to compare them.
    pub fn new(sizes: &'a [f64]) -> Self {
        Self { sizes, rounds: Vec::new(), count: 0, rows: Vec::new() }
    }

    /// Takes the numbers with the next of [`AUXILIARIES`], row after row. Tells whether there is nothing more to gain.
    pub fn add(&mut self, numbers: Vec<f64>) -> bool {
        if self.rounds.len() == 3 {
            self.rounds.remove(0);
        }
        self.rounds.push(numbers);
        self.count += 1;
        let [first, second, third] = self.rounds.as_slice() else { return false };
        let width = self.sizes.len().max(1);
        let unknown = Row { best: Vec::new(), off: f64::INFINITY, count: 0, agrees: false, last: Vec::new() };
        self.rows.resize(third.len() / width, unknown);
        for (row, known) in self.rows.iter_mut().enumerate() {
            let (mut largest, mut apart, mut moved) = (0.0f64, 0.0f64, 0.0f64);
            let mut found = Vec::with_capacity(width);
            for (place, size) in self.sizes.iter().enumerate() {
                let [a, b, c] = [first, second, third].map(|round| round[row * width + place]);
                let parabola = PARABOLA[0] * a + PARABOLA[1] * b + PARABOLA[2] * c;
                largest = largest.max((size * parabola).abs());
                apart = apart.max((size * (parabola - LINE[0] * b - LINE[1] * c)).abs());
                moved = moved.max(known.last.get(place).map_or(0.0, |last| (size * (parabola - last)).abs()));
                found.push(parabola);
            }
            let of_largest = |by: f64| if by > 0.0 { by / largest } else { 0.0 };
            known.agrees |= of_largest(apart) <= AGREES;
            // Rounding grows where compliances fall.
            let off = of_largest(apart.max(moved));
            if off < known.off {
                (known.best, known.off, known.count) = (found.clone(), off, self.count);
            }
            known.last = found;
        }
        self.rows.iter().all(|row| row.agrees)
    }

    /// Whether a row is known without a compliance: it is not where what is left without one is none.
    pub fn is_known(&self, row: usize) -> bool {
        self.rows.get(row).is_some_and(|row| row.off <= KNOWN)
    }

    /// How far a row is from what other weights make of it, over its largest number: that is more than what is left of compliances. With it
    /// comes how many of these it took. Nothing is left where there is one compliance alone.
    pub fn off(&self, row: usize) -> (f64, usize) {
        self.rows.get(row).map_or((0.0, self.count), |row| (row.off, row.count))
    }

    /// What they are without a compliance, as near as they are known; where there is one compliance alone, what they are with it.
    pub fn take(mut self) -> Vec<f64> {
        match self.rows.is_empty() {
            true => self.rounds.pop().unwrap_or_default(),
            false => self.rows.into_iter().flat_map(|row| row.best).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_that_moves_line_and_parabola_alike_is_no_agreement() {
        let exact = |compliance: f64| 1.0 / (1.0 + 0.02 * compliance);
        let mut limit = Limit::new(&[1.0]);
        assert!(![1.0, 0.1, 0.01].map(|compliance| limit.add(vec![exact(compliance)])).contains(&true));
        // They agree to a hundred-millionth, and both are off by fifty times as much.
        assert!(limit.add(vec![exact(0.001) + 5e-7]));
        let (off, count) = limit.off(0);
        assert_eq!(count, 3);
        let found = limit.take();
        assert!((found[0] - 1.0).abs() < off && off < 1e-4, "{off:e}");
        assert!((found[0] - 1.0).abs() < 2e-8, "{found:?}");
    }
}
