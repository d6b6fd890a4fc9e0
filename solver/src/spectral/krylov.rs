//! The largest eigenvalues of a symmetric operator, by Krylov spaces of blocks with thick restarts.
//!
//! What is known of the operator is a basis V, its image A V and their product Vᵀ A V, all kept whole: eigenvalues are those
//! of the product (Rayleigh–Ritz), residuals A y − θ y are computed and not estimated, and an operator that maps the basis
//! into itself ends the search instead of breaking it down. A restart keeps the motions of the largest eigenvalues (K. Wu and
//! H. Simon, SIAM J. Matrix Anal. Appl. 22, 2000); those at the other end of the spectrum cost a part of the basis, no more.

use faer::{Mat, MatMut, MatRef, Scale, concat};

use super::eigen;

/// Vectors that the space grows by at once: multiple eigenvalues of that many are found together.
const BLOCK: usize = 4;
/// Blocks of a space that tells roughly how large the largest eigenvalue is.
const FEW: usize = 3;
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
    /// Whether the search came to its end: what was not found is not there, but for copies.
    pub is_over: bool,
}

/// What a search is for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted {
    /// How many of the largest eigenvalues.
    pub count: usize,
    /// So many more are given, where they have been found by then.
    pub extra: usize,
    /// Residual of a pair that is enough, over the largest eigenvalue by size.
    pub tolerance: f64,
    /// Part of that eigenvalue below which none is waited for or given: rounding of the largest holds too many of its digits.
    pub span: f64,
}

/// The largest eigenvalue of an operator of `size` unknowns in the Krylov space of `FEW` blocks.
pub(crate) fn largest_of_few(size: usize, apply: &mut Images) -> f64 {
    let mut space = Space::new(size, (FEW * BLOCK).min(size));
    let starts: Vec<Vec<f64>> = (0..BLOCK).map(|k| start(size, k)).collect();
    let mut fresh = apply(Mat::from_fn(size, BLOCK, |i, k| starts[k][i]).as_ref());
    for _ in 0..FEW {
        let known = space.count;
        space.add(fresh, apply);
        fresh = space.images.subcols(known, space.count - known).to_owned();
    }
    space.ritz().values.first().copied().unwrap_or(0.0)
}

/// Searches for the largest eigenvalues of an operator of `size` unknowns; `seed` sets where the search begins.
///
/// `apply` gives the images of vectors, which are columns.
///
/// A pair is found when its residual is below the tolerance times the size of the operator, or `SETTLED` times its eigenvalue;
/// only those are given. Where a restart changes no eigenvalue any more, rounding leaves no better ones, and all are given with their residuals.
/// Where none is above `NEGLIGIBLE` of the largest by size, `any_above` is asked whether there are any above a value: an operator
/// without positive eigenvalues makes no end to a search for the one that is nearest to zero.
pub(crate) fn largest(
    size: usize,
    wanted: Wanted,
    seed: usize,
    apply: &mut Images,
    any_above: &dyn Fn(f64) -> bool,
) -> Largest {
    let Wanted { count, extra, tolerance, span } = wanted;
    let most = (2 * (count + extra) + BLOCKS * BLOCK).min(size);
    let mut space = Space::new(size, most);
    let mut scale = 0.0f64;
    let starts: Vec<Vec<f64>> = (0..BLOCK).map(|k| start(size, seed * BLOCK + k)).collect();
    let mut fresh = apply(Mat::from_fn(size, BLOCK, |i, k| starts[k][i]).as_ref());
    let mut before: Vec<f64> = Vec::new();
    for _ in 0..RESTARTS {
        let mut ritz;
        loop {
            let known = space.count;
            space.add(fresh, apply);
            ritz = space.ritz();
            scale = ritz.values.iter().fold(scale, |scale, value| scale.max(value.abs()));
            let invariant = space.count == known;
            let wanted = count.min(ritz.values.len());
            let [floor, least] = [tolerance, span].map(|part| part * scale);
            let is_found = |k: usize| ritz.values[k].abs() < least || space.settled(&ritz, k, floor).is_some();
            // From the smallest on, which is found last.
            let found = wanted == count && (0..wanted).rev().all(is_found);
            if found || invariant {
                return Largest { pairs: space.pairs(&ritz, count + extra, [floor, least]), scale, is_over: true };
            }
            if space.count == most {
                break;
            }
            fresh = space.images.subcols(known, space.count - known).to_owned();
        }
        let values: Vec<f64> = ritz.values.iter().take(count).copied().collect();
        let least = span * scale;
        let still = |(now, before): (&f64, &f64)| {
            let nothing = now.abs().max(before.abs()) <= ROUNDING.max(span) * scale;
            nothing || (now - before).abs() <= STILL * now.abs()
        };
        let negligible = NEGLIGIBLE * scale;
        if before.is_empty() && values.iter().all(|value| *value < negligible) && !any_above(negligible) {
            return Largest { pairs: Vec::new(), scale, is_over: true };
        }
        if !before.is_empty() && values.iter().zip(&before).all(still) {
            return Largest { pairs: space.pairs(&ritz, count + extra, [f64::INFINITY, least]), scale, is_over: true };
        }
        before = values;
        let kept = (count + extra + BLOCK).min(most.saturating_sub(BLOCK)).max(1);
        fresh = space.residuals(&ritz, kept, tolerance * scale);
        space.restart(&ritz, kept);
    }
    let ritz = space.ritz();
    let limits = [tolerance, span].map(|part| part * scale);
    Largest { pairs: space.pairs(&ritz, count + extra, limits), scale, is_over: false }
}

/// The images of vectors, which are columns.
type Images<'a> = dyn FnMut(MatRef<'_, f64>) -> Mat<f64> + 'a;

/// An orthonormal basis with its image: the first `count` columns.
struct Space {
    vectors: Mat<f64>,
    images: Mat<f64>,
    /// Vᵀ A V, the lower triangle.
    product: Mat<f64>,
    count: usize,
}

/// Eigenvalues of the operator in a space by falling size, with their weights in the basis as columns.
struct Ritz {
    values: Vec<f64>,
    weights: Mat<f64>,
}

impl Space {
    fn new(size: usize, most: usize) -> Self {
        Self {
            vectors: Mat::zeros(size, most),
            images: Mat::zeros(size, most),
            product: Mat::zeros(most, most),
            count: 0,
        }
    }

    /// The pair of a Ritz value that has been found.
    fn settled(&self, ritz: &Ritz, k: usize, floor: f64) -> Option<Pair> {
        let value = ritz.values[k];
        let weights = ritz.weights.subcols(k, 1);
        let vector = self.vectors.subcols(0, self.count) * weights;
        let mut left = self.images.subcols(0, self.count) * weights;
        left -= Scale(value) * &vector;
        let residual = left.norm_l2();
        let pair = || Pair { value, vector: vector.col(0).iter().copied().collect(), residual };
        (residual <= floor.max(SETTLED * value.abs())).then(pair)
    }

    /// Those of the first `count` pairs that are found, and no smaller than the least.
    fn pairs(&self, ritz: &Ritz, count: usize, [floor, least]: [f64; 2]) -> Vec<Pair> {
        let is_given = |k: &usize| ritz.values[*k].abs() >= least;
        (0..count.min(ritz.values.len())).filter(is_given).filter_map(|k| self.settled(ritz, k, floor)).collect()
    }

    /// Adds what vectors have beside the basis, as far as there is room.
    fn add(&mut self, mut fresh: Mat<f64>, apply: &mut Images) {
        let known = self.count;
        let before: Vec<f64> = fresh.col_iter().map(|column| column.norm_l2()).collect();
        let basis = self.vectors.subcols(0, known);
        // Twice is enough (Kahan and Parlett).
        take_out(basis, fresh.as_mut());
        take_out(basis, fresh.as_mut());
        for (column, before) in fresh.col_iter().zip(before) {
            if self.count == self.vectors.ncols() {
                break;
            }
            let mut vector = column.to_owned();
            for _ in 0..2 {
                take_out(self.vectors.subcols(known, self.count - known), vector.as_mat_mut());
            }
            let left = vector.norm_l2();
            if left <= NOTHING * before {
                continue;
            }
            vector /= Scale(left);
            // Of what is little beside its neighbours, more lies in the basis than rounding.
            take_out(self.vectors.subcols(0, self.count), vector.as_mat_mut());
            let length = vector.norm_l2();
            self.vectors.col_mut(self.count).copy_from(Scale(1.0 / length) * vector);
            self.count += 1;
        }
        let fresh = self.count - known;
        if fresh == 0 {
            return;
        }
        let images = apply(self.vectors.subcols(known, fresh));
        let product = images.transpose() * self.vectors.subcols(0, self.count);
        self.product.submatrix_mut(known, 0, fresh, self.count).copy_from(product);
        self.images.subcols_mut(known, fresh).copy_from(images);
    }

    fn ritz(&self) -> Ritz {
        let product = self.product.submatrix(0, 0, self.count, self.count);
        let (values, weights) = eigen::symmetric(product).unwrap_or_else(|| (Vec::new(), Mat::new()));
        Ritz { values, weights }
    }

    /// A block of what A y − θ y of the first pairs span, as far as they are longer than `least`.
    ///
    /// They all lie in the block that the space would grow by, but for rounding, which short ones are full of: it is made of the longest.
    fn residuals(&self, ritz: &Ritz, count: usize, least: f64) -> Mat<f64> {
        let weights = ritz.weights.subcols(0, count.min(ritz.values.len()));
        let mut left = self.images.subcols(0, self.count) * weights;
        let scaled = Mat::from_fn(self.count, weights.ncols(), |i, k| weights[(i, k)] * ritz.values[k]);
        left -= self.vectors.subcols(0, self.count) * scaled;
        let mut block = Mat::<f64>::zeros(left.nrows(), 0);
        for _ in 0..BLOCK {
            let lengths = left.col_iter().map(|column| column.norm_l2());
            let longest = lengths.enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b));
            let Some((longest, length)) = longest.filter(|(_, length)| *length > least) else { break };
            let unit = Scale(1.0 / length) * left.subcols(longest, 1);
            take_out(unit.as_ref(), left.as_mut());
            block = concat![[block, unit]];
        }
        block
    }

    /// Keeps the motions of the first pairs.
    fn restart(&mut self, ritz: &Ritz, kept: usize) {
        let kept = kept.min(ritz.values.len());
        let weights = ritz.weights.subcols(0, kept);
        let vectors = self.vectors.subcols(0, self.count) * weights;
        let images = self.images.subcols(0, self.count) * weights;
        self.vectors.subcols_mut(0, kept).copy_from(vectors);
        self.images.subcols_mut(0, kept).copy_from(images);
        self.product.fill(0.0);
        for k in 0..kept {
            self.product[(k, k)] = ritz.values[k];
        }
        self.count = kept;
    }
}

/// Takes out of vectors what lies in an orthonormal basis.
pub(crate) fn take_out(basis: MatRef<'_, f64>, mut vectors: MatMut<'_, f64>) {
    if basis.ncols() > 0 {
        let along = basis.transpose() * &vectors;
        vectors -= basis * along;
    }
}

/// A vector without any pattern that a network may share.
pub(crate) fn start(size: usize, seed: usize) -> Vec<f64> {
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

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: Wanted = Wanted { count: 0, extra: 0, tolerance: 1e-12, span: 0.0 };

    /// A space that the operator maps into itself is all there is: the search ends, with what it found.
    #[test]
    fn an_operator_of_low_rank_ends_the_search() {
        let size = 400;
        let weight = |i: usize| match i {
            3 => 2.0,
            7 => 0.5,
            9 => -300.0,
            _ => 0.0,
        };
        let mut apply = |xs: MatRef<'_, f64>| Mat::from_fn(size, xs.ncols(), |i, k| weight(i) * xs[(i, k)]);
        let found = largest(size, Wanted { count: 5, ..NONE }, 0, &mut apply, &|_| true);
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
        let mut apply = |xs: MatRef<'_, f64>| Mat::from_fn(size, xs.ncols(), |i, k| value(i) * xs[(i, k)]);
        let found = largest(size, Wanted { count: 6, ..NONE }, 1, &mut apply, &|_| true);
        assert_eq!(found.pairs.len(), 6);
        for (k, pair) in found.pairs.iter().enumerate() {
            let (found, exact) = (pair.value, value(2 * k + 1));
            assert!((found / exact - 1.0).abs() < 1e-10, "{k}: {found} {exact}");
        }
    }
}
