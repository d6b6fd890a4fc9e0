//! The largest eigenvalues of a symmetric operator, by Krylov spaces of blocks with thick restarts.
//!
//! What is known of the operator is a basis V, its image A V and their product Vᵀ A V, all kept whole: eigenvalues are those
//! of the product (Rayleigh–Ritz), residuals A y − θ y are computed and not estimated, and an operator that maps the basis
//! into itself ends the search instead of breaking it down. A restart keeps the motions of the largest eigenvalues (K. Wu and
//! H. Simon, SIAM J. Matrix Anal. Appl. 22, 2000); those at the other end of the spectrum cost a part of the basis, no more.

use faer::{Mat, Side};

use super::operators::dot;

/// Vectors that the space grows by at once: multiple eigenvalues of that many are found together.
const BLOCK: usize = 4;
/// Blocks of a basis beside the pairs wanted.
const BLOCKS: usize = 10;
/// Restarts at most.
const RESTARTS: usize = 200;
/// What orthogonalization leaves of a vector that lies in the basis.
const NOTHING: f64 = 1e-12;

/// Residual of a pair that has settled, over its eigenvalue: the eigenvalue is known to the square of that.
const SETTLED: f64 = 1e-7;
/// Part of the largest eigenvalue by size below which one is not looked for alone: of critical factors, one that is a million
/// times as large as that of the ramp the other way.
const NEGLIGIBLE: f64 = 1e-6;
/// Eigenvalues below this part of the largest are rounding.
pub(crate) const ROUNDING: f64 = 1e-11;
/// Change of an eigenvalue by a restart, over the eigenvalue, that is rounding: its residual is below the root of that, or does not
/// shrink.
const STILL: f64 = 1e-13;

/// An eigenvalue with its vector, and the length of what the operator makes of it beside.
#[derive(Clone, Debug)]
pub(crate) struct Pair {
    pub value: f64,
    pub vector: Vec<f64>,
    pub residual: f64,
}

/// Pairs of an operator by falling eigenvalues, and its largest eigenvalue by size, of either sign.
#[derive(Debug, Default)]
pub(crate) struct Largest {
    pub pairs: Vec<Pair>,
    pub scale: f64,
}

/// Searches for the `count` largest eigenvalues of an operator of `size` unknowns; `seed` sets where the search begins.
///
/// `apply` gives the images of vectors.
///
/// A pair is found when its residual is below `tolerance` times the size of the operator, or has settled; only those are
/// given. Where a restart changes no eigenvalue any more, rounding leaves no better ones, and all are given with their residuals.
/// Where none is above `NEGLIGIBLE` of the largest by size, `any_above` is asked whether there are any above a value: an operator
/// without positive eigenvalues makes no end to a search for the one that is nearest to zero.
pub(crate) fn largest(
    size: usize,
    count: usize,
    seed: usize,
    tolerance: f64,
    apply: &mut Images,
    any_above: &dyn Fn(f64) -> bool,
) -> Largest {
    let most = (2 * count + BLOCKS * BLOCK).min(size);
    let mut space = Space { vectors: Vec::new(), images: Vec::new(), product: Vec::new() };
    let mut scale = 0.0f64;
    let mut fresh = apply(&(0..BLOCK).map(|k| start(size, seed * BLOCK + k)).collect::<Vec<_>>());
    let mut before: Vec<f64> = Vec::new();
    for _ in 0..RESTARTS {
        let mut ritz;
        loop {
            let known = space.vectors.len();
            fresh.truncate(most - known);
            space.add(std::mem::take(&mut fresh), apply);
            ritz = space.ritz();
            scale = ritz.iter().fold(scale, |scale, (value, _)| scale.max(value.abs()));
            let invariant = space.vectors.len() == known;
            let wanted = &ritz[..count.min(ritz.len())];
            let floor = tolerance * scale;
            // From the smallest on, which is found last.
            let found = wanted.len() == count && wanted.iter().rev().all(|pair| space.settled(pair, floor).is_some());
            if found || invariant {
                return Largest { pairs: wanted.iter().filter_map(|pair| space.settled(pair, floor)).collect(), scale };
            }
            if space.vectors.len() == most {
                break;
            }
            fresh = space.images[known..].to_vec();
        }
        let values: Vec<f64> = ritz.iter().take(count).map(|(value, _)| *value).collect();
        let still = |(now, before): (&f64, &f64)| {
            let nothing = now.abs().max(before.abs()) <= ROUNDING * scale;
            nothing || (now - before).abs() <= STILL * now.abs()
        };
        let negligible = NEGLIGIBLE * scale;
        if before.is_empty() && values.iter().all(|value| *value < negligible) && !any_above(negligible) {
            return Largest { pairs: Vec::new(), scale };
        }
        if !before.is_empty() && values.iter().zip(&before).all(still) {
            let all = ritz.iter().take(count);
            return Largest { pairs: all.filter_map(|pair| space.settled(pair, f64::INFINITY)).collect(), scale };
        }
        before = values;
        let kept = (count + BLOCK).min(most.saturating_sub(BLOCK)).max(1);
        let residuals = ritz.iter().take(kept).map(|(value, weights)| space.residual(*value, weights));
        fresh = residuals.filter(|residual| norm(residual) > tolerance * scale).take(BLOCK).collect();
        space = space.restarted(&ritz[..kept]);
    }
    let floor = tolerance * scale;
    Largest { pairs: space.ritz().iter().take(count).filter_map(|pair| space.settled(pair, floor)).collect(), scale }
}

/// The images of vectors.
type Images<'a> = dyn FnMut(&[Vec<f64>]) -> Vec<Vec<f64>> + 'a;

/// An orthonormal basis with its image.
struct Space {
    vectors: Vec<Vec<f64>>,
    images: Vec<Vec<f64>>,
    /// The lower triangle of Vᵀ A V, by rows.
    product: Vec<Vec<f64>>,
}

impl Space {
    /// The pair of a Ritz value that has been found.
    fn settled(&self, (value, weights): &(f64, Vec<f64>), floor: f64) -> Option<Pair> {
        let residual = norm(&self.residual(*value, weights));
        let pair = || Pair { value: *value, vector: combine(&self.vectors, weights), residual };
        (residual <= floor.max(SETTLED * value.abs())).then(pair)
    }

    /// Adds what vectors have beside the basis.
    fn add(&mut self, fresh: Vec<Vec<f64>>, apply: &mut Images) {
        let known = self.vectors.len();
        for mut vector in fresh {
            let before = norm(&vector);
            // Twice is enough (Kahan and Parlett).
            for _ in 0..2 {
                for known in &self.vectors {
                    let along = dot(&vector, known);
                    vector.iter_mut().zip(known).for_each(|(x, k)| *x -= along * k);
                }
            }
            let left = norm(&vector);
            if left > NOTHING * before {
                vector.iter_mut().for_each(|x| *x /= left);
                self.vectors.push(vector);
            }
        }
        for image in apply(&self.vectors[known..]) {
            let row = &self.vectors[..=self.images.len()];
            self.product.push(row.iter().map(|known| dot(known, &image)).collect());
            self.images.push(image);
        }
    }

    /// Eigenvalues of the operator in this space by falling size, with their weights in the basis.
    fn ritz(&self) -> Vec<(f64, Vec<f64>)> {
        let size = self.vectors.len();
        let product = Mat::from_fn(size, size, |i, j| self.product[i.max(j)][i.min(j)]);
        let Ok(eigen) = product.self_adjoint_eigen(Side::Lower) else { return Vec::new() };
        let (values, weights) = (eigen.S().column_vector(), eigen.U());
        (0..size).rev().map(|k| (values[k], (0..size).map(|i| weights[(i, k)]).collect())).collect()
    }

    /// A y − θ y
    fn residual(&self, value: f64, weights: &[f64]) -> Vec<f64> {
        let mut residual = combine(&self.images, weights);
        for (vector, weight) in self.vectors.iter().zip(weights) {
            residual.iter_mut().zip(vector).for_each(|(r, x)| *r -= value * weight * x);
        }
        residual
    }

    fn restarted(&self, ritz: &[(f64, Vec<f64>)]) -> Self {
        let row = |k: usize| (0..=k).map(|i| if i == k { ritz[k].0 } else { 0.0 }).collect();
        Self {
            vectors: ritz.iter().map(|(_, weights)| combine(&self.vectors, weights)).collect(),
            images: ritz.iter().map(|(_, weights)| combine(&self.images, weights)).collect(),
            product: (0..ritz.len()).map(row).collect(),
        }
    }
}

/// A vector without any pattern that a network may share.
fn start(size: usize, seed: usize) -> Vec<f64> {
    // SplitMix64.
    let mut state = seed as u64;
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = state;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    (0..size).map(|_| next()).collect()
}

fn combine(vectors: &[Vec<f64>], weights: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; vectors.first().map_or(0, Vec::len)];
    for (vector, weight) in vectors.iter().zip(weights) {
        sum.iter_mut().zip(vector).for_each(|(s, x)| *s += weight * x);
    }
    sum
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A space that the operator maps into itself is all there is: the search ends, with what it found.
    #[test]
    fn an_operator_of_low_rank_ends_the_search() {
        let size = 400;
        let image = |x: &Vec<f64>| {
            let mut out = vec![0.0; size];
            (out[3], out[7], out[9]) = (2.0 * x[3], 0.5 * x[7], -300.0 * x[9]);
            out
        };
        let mut apply = |xs: &[Vec<f64>]| xs.iter().map(image).collect();
        let found = largest(size, 5, 0, 1e-12, &mut apply, &|_| true);
        let values: Vec<f64> = found.pairs.iter().map(|pair| pair.value).filter(|value| *value > 1e-9).collect();
        assert_eq!(values.len(), 2);
        assert!((values[0] - 2.0).abs() < 1e-10 && (values[1] - 0.5).abs() < 1e-10, "{values:?}");
        assert!((found.scale - 300.0).abs() < 1e-9);
    }

    /// Large negative eigenvalues are none of those wanted, and do not hide them.
    #[test]
    fn the_other_end_of_the_spectrum_does_not_count() {
        let size = 900;
        let value = |i: usize| if i.is_multiple_of(2) { -1e3 / (1.0 + i as f64) } else { 10.0 / i as f64 };
        let image = |x: &Vec<f64>| (0..size).map(|i| value(i) * x[i]).collect();
        let mut apply = |xs: &[Vec<f64>]| xs.iter().map(image).collect();
        let found = largest(size, 6, 1, 1e-12, &mut apply, &|_| true);
        assert_eq!(found.pairs.len(), 6);
        for (k, pair) in found.pairs.iter().enumerate() {
            let (found, exact) = (pair.value, value(2 * k + 1));
            assert!((found / exact - 1.0).abs() < 1e-10, "{k}: {found} {exact}");
        }
    }
}
