//! The largest θ of B x = θ K x among the x with G x = 0; K is positive definite there.
//!
//! With K = L D Lᵀ this is the symmetric operator A = Π L⁻¹ B L⁻ᵀ Π (permutation and D left out). Π is the projection
//! onto the motions that the constraints leave. K holds Gᵀ G with a large factor, so that for W = L⁻¹ Gᵀ the singular
//! values are one but for a small part, and Π is the limit of (I − W Wᵀ)ⁿ, reached in a few steps: the same repeated
//! correction of the multipliers by which equilibria meet rigid components.
//!
//! Of a ramp that also stiffens the network the other eigenvalues, which are negative, may be far larger than those wanted. K is
//! replaced then by K − σ B, which is positive definite for a shift σ below the smallest positive 1/θ: eigenvalues become
//! μ = θ / (1 − σ θ), which are larger than before where they are positive, and above −1/σ where they are not (the shift and
//! inversion of Grimes, Lewis and Simon, SIAM J. Matrix Anal. Appl. 15, 1994).
//!
//! Eigenvalues are found in Krylov spaces of blocks (`krylov.rs`), which need no matrix of A. A block sees as many motions
//! of a multiple eigenvalue as it has vectors: what was found is deflated and the search repeated until the count of negative
//! pivots of K − B/θ (Sylvester's law of inertia) says that nothing is missing above the last one wanted. Of a small network
//! all eigenvalues of the whole A are taken.
//!
//! Of a stiff network the factors of K hold rounding that is large beside its soft motions. Eigenvalues are those of the
//! space of the motions found, with K in the form that it is made of (`Form`): by Rayleigh's principle they are off by the square
//! of what the motions are. How far the two are apart says how much of that there is.
//!
//! Theory: docs/theory/stability.md, Eq. 7.5.

mod allowed;
mod near;

use faer::{Mat, Side};
use sprs::CsMat;

use super::factor::{Analyzed, Factor};
use super::krylov::{self, Largest, Pair, ROUNDING};
use super::operators::{Form, dot, multiply};
use allowed::CORRECTIONS;

pub(crate) use allowed::firm;

/// Unknowns up to which the whole spectrum is computed.
const SMALL: usize = 100;
/// Searches with what was found taken out, at most, and how many of them in a row may bring nothing larger than what is known.
const SEARCHES: usize = 40;
const IN_VAIN: usize = 4;
/// Pairs beyond those wanted.
const EXTRA: usize = 2;
/// By how much the limit of a count lies above an eigenvalue.
const FINE: f64 = 1.0 + 1e-6;
const COARSE: f64 = 1.01;
/// Part of the last pair that the next one is taken for where none is known.
const APART: f64 = 0.97;
/// Residual of a pair over the largest eigenvalue.
const TOLERANCE: f64 = 1e-12;

/// Vectors that go through the factors side by side.
const WIDTH: usize = 4;

/// Part of an eigenvalue that rounding may be without a correction.
const EXACT: f64 = 1e-12;
/// Part of an eigenvalue by which its motion may fail for a count of pivots to say anything.
const COUNTABLE: f64 = 0.05;
/// How many times an eigenvalue the one with the energy of the form may be.
const HELD: f64 = 10.0;
/// By how much the limit of a count lies above an eigenvalue, over the part that rounding makes of it.
const CLEAR: f64 = 10.0;

/// Part of what is known to be below the smallest positive 1/θ that the shift is, and how near that has to be known for it.
const SHIFT: f64 = 0.9;
const ROUGH: f64 = 1.5;
/// Where nothing limits it, it is looked for from so many times K over B on, down by such strides, so many of them at most.
const FARTHEST: f64 = 1e6;
const STRIDE: f64 = 30.0;
const STRIDES: usize = 20;
/// A smallest factor that was found may be larger than where it was looked for by this part.
const BRACKETED: f64 = 1.01;
/// Least part that is left of a stiffness by the shift.
const LEFT: f64 = 1e-12;

/// B x = θ K x with G x = 0.
#[derive(Debug)]
pub(crate) struct Pencil<'a> {
    /// Of `stiffness` less the shifted part of `other`, without negative pivots.
    pub factor: Factor,
    /// σ
    pub shift: f64,
    /// K with Gᵀ G.
    pub stiffness: &'a CsMat<f64>,
    /// K without.
    pub form: &'a Form,
    /// B
    pub other: &'a CsMat<f64>,
    /// G
    pub constraints: &'a CsMat<f64>,
    /// Of sums of K and B.
    pub analyzed: &'a Analyzed,
}

/// Eigenvalues by falling size, and their motions with xᵀ K x = 1.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pairs {
    /// Eigenvalues, in order.
    pub values: Vec<f64>,
    /// Part of each that rounding, and what the search leaves, may be.
    pub rounding: Vec<f64>,
    /// Their vectors, one a row.
    pub vectors: Vec<Vec<f64>>,
    /// Whether the count of pivots confirms that none is missing above the last.
    pub complete: bool,
    /// What was found beyond them, which no count confirms to be the next ones.
    pub beyond: Vec<(f64, Vec<f64>)>,
}

impl Pairs {
    /// Those whose eigenvalue is larger.
    fn above(mut self, least: f64) -> Self {
        let kept = self.values.iter().take_while(|value| **value > least).count();
        self.values.truncate(kept);
        self.rounding.truncate(kept);
        self.vectors.truncate(kept);
        self.beyond.retain(|(value, _)| *value > least);
        self
    }
}

impl Pencil<'_> {
    /// The `count` largest eigenvalues above what is known of them, none of them negative, where `other` may have large
    /// negative ones.
    ///
    /// Where the count of pivots says that there are none, nothing is searched for. An auxiliary stiffness in place of a
    /// rigid one makes that count too large at most.
    pub(crate) fn largest_above(self, least: f64, count: usize) -> Pairs {
        if least > 0.0 && self.count_above(least) == Some(0) {
            return Pairs { complete: true, ..Pairs::default() };
        }
        self.shifted(least).largest(count).above(least)
    }

    /// The largest eigenvalue above what is known of it, whose motion is enough: no count confirms that none is larger, but it lies
    /// where a shift says that the largest is.
    pub(crate) fn nearest(self, least: f64) -> Pairs {
        if least > 0.0 && self.count_above(least) == Some(0) {
            return Pairs::default();
        }
        let shifted = self.shifted(least);
        let found = shifted.search(&[], 1, 0).pairs;
        let found: Vec<Pair> = found.into_iter().map(|pair| shifted.unshifted_pair(pair)).collect();
        let pairs = shifted.pairs(&found, 1, true);
        let bracket = if shifted.shift > 0.0 { SHIFT / (ROUGH * BRACKETED * shifted.shift) } else { 0.0 };
        let pairs =
            if pairs.values.first().is_some_and(|value| *value >= bracket) { pairs } else { shifted.largest(1) };
        pairs.above(least)
    }

    /// Factors of K − B/θ: they have as many negative pivots as there are eigenvalues above θ.
    fn factor_at(&self, value: f64) -> Option<Factor> {
        self.analyzed.factor(&(self.stiffness - &self.other.map(|entry| entry / value)))
    }

    /// The same pencil with the factors of a shift, where it is large and has an eigenvalue above the least.
    ///
    /// The smallest positive 1/θ lies between a shift that leaves all pivots positive and one that does not, which few
    /// factorizations tell far sooner than a search among large negative eigenvalues.
    fn shifted(self, least: f64) -> Self {
        if self.factor.size() <= SMALL {
            return self;
        }
        let trace = |matrix: &CsMat<f64>| matrix.diag().iter().map(|(_, value)| value.abs()).sum::<f64>();
        let definite = |shift: f64| {
            let factor = self.factor_at(1.0 / shift);
            factor.filter(|factor| factor.negative == 0 && factor.neutral == 0)
        };
        // An eigenvalue in a small space is no larger than the largest of all.
        let known = self.largest_of_few().max(least);
        let mut high = if known > 0.0 { 1.0 / known } else { FARTHEST * trace(self.stiffness) / trace(self.other) };
        if !high.is_finite() || (known <= least && definite(high).is_some()) {
            return self;
        }
        let mut low = high / if known > least { ROUGH } else { STRIDE };
        for _ in 0..STRIDES {
            if definite(low).is_some() {
                break;
            }
            (low, high) = (low / STRIDE, low);
        }
        while high > ROUGH * low {
            let between = (low * high).sqrt();
            if definite(between).is_some() {
                low = between;
            } else {
                high = between;
            }
        }
        let shift = SHIFT * low;
        match definite(shift) {
            Some(factor) => Self { factor, shift, ..self },
            None => self,
        }
    }

    /// θ of an eigenvalue μ of the shifted pencil.
    fn unshifted(&self, value: f64) -> f64 {
        value / (1.0 + self.shift * value).max(LEFT)
    }

    fn unshifted_pair(&self, pair: Pair) -> Pair {
        let left = (1.0 + self.shift * pair.value).max(LEFT);
        Pair { value: pair.value / left, residual: pair.residual / (left * left), ..pair }
    }

    /// The `count` largest positive eigenvalues.
    pub(crate) fn largest(&self, count: usize) -> Pairs {
        let size = self.factor.size();
        if size <= SMALL || size < 8 * (count + EXTRA) {
            return self.pairs(&self.all(), count, true);
        }
        let mut found: Vec<Pair> = Vec::new();
        let mut largest = 0.0f64;
        let mut in_vain = 0;
        for search in 0..SEARCHES {
            let Largest { pairs: fresh, scale, is_over } = self.search(&found, count, search);
            largest = fresh.iter().fold(largest.max(scale), |largest, pair| largest.max(pair.value.abs()));
            let exhausted = is_over && fresh.iter().all(|pair| pair.value.abs() <= ROUNDING * largest);
            if fresh.is_empty() && !is_over {
                break;
            }
            let known = found.len();
            found.extend(fresh.into_iter().map(|pair| self.unshifted_pair(pair)));
            let next = found[known..].iter().fold(0.0f64, |largest, pair| largest.max(pair.value));
            found.sort_by(|a, b| b.value.total_cmp(&a.value));
            if exhausted {
                return self.pairs(&found, count, true);
            }
            if let Some(complete) = self.is_complete(&found, count, next) {
                let pairs = self.pairs(&found, count, complete);
                // Where some of those counted are no motions, there may be others.
                let complete = complete && pairs.values.len() == count;
                return Pairs { complete, ..pairs };
            }
            let more = found.get(count - 1).is_none_or(|last| next > last.value * FINE) || known < count;
            in_vain = if more { 0 } else { in_vain + 1 };
            if in_vain == IN_VAIN {
                break;
            }
        }
        self.pairs(&found, count, false)
    }

    /// The pairs in the space of the motions found, with the energy of each as the form has it.
    fn pairs(&self, found: &[Pair], count: usize, complete: bool) -> Pairs {
        let largest = found.iter().fold(0.0f64, |largest, pair| largest.max(pair.value.abs()));
        let kept: Vec<&Pair> =
            found.iter().filter(|pair| pair.value > ROUNDING * largest).take(count + EXTRA).collect();
        let motions: Vec<Vec<f64>> = kept.iter().map(|pair| self.motion(pair)).collect();
        let mut pairs = Pairs { complete, ..Pairs::default() };
        match self.combined(&motions) {
            Some(combined) => {
                // The motion is off by this part, its eigenvalue by the square.
                let off = |(pair, found): (&&Pair, &(f64, _))| {
                    (pair.value / found.0 - 1.0).abs().max(pair.residual / pair.value)
                };
                let rounding: Vec<f64> = kept.iter().zip(&combined).map(off).map(|off| off * off).collect();
                let better = if rounding.iter().any(|part| *part > EXACT) { self.corrected(&combined) } else { None };
                let better = better.unwrap_or_else(|| combined.clone());
                // What strains only what is held has an energy beside which that of the form is nothing: no motion.
                let is_motion = |(pair, found): (&&Pair, &(f64, _))| found.0 <= HELD * pair.value;
                let motions: Vec<bool> = kept.iter().zip(&combined).map(is_motion).collect();
                for (((before, (value, vector)), rounding), is_motion) in
                    combined.iter().zip(better).zip(rounding).zip(motions)
                {
                    if !is_motion {
                        continue;
                    }
                    // What a correction was of the first order leaves one of the second.
                    let change = (value / before.0 - 1.0).abs();
                    pairs.values.push(value);
                    pairs.rounding.push(if change > 0.0 { change.min(rounding) } else { rounding });
                    pairs.vectors.push(vector);
                }
            }
            // Rounding of the factors is as large as the energy: nothing is known of these but that they are there.
            None => {
                pairs.values = kept.iter().map(|pair| pair.value).collect();
                pairs.rounding = vec![1.0; kept.len()];
                pairs.vectors = motions;
            }
        }
        let kept = count.min(pairs.values.len());
        pairs.beyond = pairs.values.split_off(kept).into_iter().zip(pairs.vectors.split_off(kept)).collect();
        pairs.rounding.truncate(kept);
        pairs
    }

    /// The same pairs in the space of their motions and of what the factors make of the forces that these leave: B x − θ K x, with
    /// K as the form has it. What rounding the factors hold enters squared once more.
    fn corrected(&self, pairs: &[(f64, Vec<f64>)]) -> Option<Vec<(f64, Vec<f64>)>> {
        let mut motions: Vec<Vec<f64>> = pairs.iter().map(|pair| pair.1.clone()).collect();
        for (value, motion) in pairs {
            let mut left = self.image(motion);
            left.iter_mut().zip(self.form.image(motion)).for_each(|(left, held)| *left -= value * held);
            let change = self.response(&left);
            let length = self.form.energy(&change).sqrt();
            if length > 0.0 {
                motions.push(change.iter().map(|x| x / length).collect());
            }
        }
        let mut better = self.combined(&motions)?;
        better.truncate(pairs.len());
        Some(better)
    }

    /// B x
    fn image(&self, motion: &[f64]) -> Vec<f64> {
        let mut image = vec![0.0; motion.len()];
        multiply(self.other, motion, &mut image);
        image
    }

    /// The motion of a pair, with xᵀ K x = 1.
    fn motion(&self, pair: &Pair) -> Vec<f64> {
        let mut motion = self.held(pair.vector.as_chunks::<1>().0);
        // What is of length one has xᵀ (K − σ B) x = 1.
        let part = (1.0 - self.shift * pair.value).max(LEFT).sqrt();
        motion.iter_mut().for_each(|x| *x *= part);
        motion
    }

    /// Eigenvalues of B x = θ K x in a space of motions, by falling size, and their motions with xᵀ K x = 1; nothing where K is
    /// not positive there.
    fn combined(&self, motions: &[Vec<f64>]) -> Option<Vec<(f64, Vec<f64>)>> {
        let size = motions.len();
        if size == 0 {
            return Some(Vec::new());
        }
        let energy = self.form.products(motions);
        let images: Vec<Vec<f64>> = motions.iter().map(|x| self.image(x)).collect();
        let eigen = Mat::from_fn(size, size, |i, j| energy[i.max(j)][i.min(j)]).self_adjoint_eigen(Side::Lower).ok()?;
        let (levels, turns) = (eigen.S().column_vector(), eigen.U());
        if (0..size).any(|k| !(levels[k] > 0.0)) {
            return None;
        }
        // In combinations of energy one.
        let single = |k: usize| combine(motions, &|i| turns[(i, k)] / levels[k].sqrt());
        let single_image = |k: usize| combine(&images, &|i| turns[(i, k)] / levels[k].sqrt());
        let (units, unit_images): (Vec<_>, Vec<_>) = (0..size).map(|k| (single(k), single_image(k))).unzip();
        let product = Mat::from_fn(size, size, |i, j| dot(&units[i.max(j)], &unit_images[i.min(j)]));
        let eigen = product.self_adjoint_eigen(Side::Lower).ok()?;
        let (values, weights) = (eigen.S().column_vector(), eigen.U());
        Some((0..size).rev().map(|k| (values[k], combine(&units, &|i| weights[(i, k)]))).collect())
    }

    /// Whether nothing is missing above the last pair wanted; `next` is the largest eigenvalue that came last. Nothing where
    /// another search may tell.
    fn is_complete(&self, found: &[Pair], count: usize, next: f64) -> Option<bool> {
        let last = found.get(count - 1).filter(|pair| pair.value > 0.0)?;
        // What rounding makes of the largest is also what it may make of a count: the factors of another shift have their own.
        let motions: Vec<Vec<f64>> = found[..count].iter().map(|pair| self.motion(pair)).collect();
        let energies = self.form.products(&motions);
        let part = |k: usize| (energies[k][k] - 1.0).abs().max(found[k].residual / found[k].value);
        let off = (0..count).fold(0.0f64, |off, k| off.max(part(k)));
        if !(off <= COUNTABLE) {
            return Some(false);
        }
        // A limit between the last pair and the next one leaves none out, where they are far enough apart.
        let below = found.get(count).map_or(APART * last.value, |pair| pair.value.max(0.0));
        let between = 0.5 * (last.value + below);
        if between * COARSE <= last.value && self.count_above(between) == Some(count) {
            return Some(true);
        }
        // An auxiliary stiffness in place of a rigid one makes eigenvalues a little larger than they are: the count is
        // coarse there, and a search that brings nothing larger has to agree.
        let rigid = self.constraints.rows() > 0;
        let fine = FINE.max(1.0 + CLEAR * off);
        let limit = last.value * if rigid { fine.max(COARSE) } else { fine };
        let above = found.iter().take_while(|pair| pair.value > limit).count();
        ((!rigid || next <= last.value * fine) && self.count_above(limit) == Some(above)).then_some(true)
    }

    /// Number of eigenvalues above a positive limit: negative pivots of K − B/limit.
    fn count_above(&self, limit: f64) -> Option<usize> {
        self.factor_at(limit).map(|factor| factor.negative)
    }

    /// The largest eigenvalue in a small space, negative ones included.
    fn largest_of_few(&self) -> f64 {
        let operator = Deflated::new(self, &[]);
        krylov::largest_of_few(self.factor.size(), &mut |ys| operator.act(ys.to_owned()))
    }

    /// The largest pairs of the shifted pencil beside those that are known, with eigenvalues μ.
    fn search(&self, known: &[Pair], count: usize, search: usize) -> Largest {
        let operator = Deflated::new(self, known);
        let any_above = |limit: f64| {
            let limit = self.unshifted(limit);
            self.count_above(limit) != Some(known.iter().filter(|pair| pair.value > limit).count())
        };
        krylov::largest(
            self.factor.size(),
            [count, EXTRA],
            search,
            TOLERANCE,
            &mut |ys| operator.act(ys.to_owned()),
            &any_above,
        )
    }

    /// All pairs of a small network, by falling eigenvalues.
    fn all(&self) -> Vec<Pair> {
        let size = self.factor.size();
        let mut dense = Mat::<f64>::zeros(size, size);
        for first in (0..size).step_by(WIDTH) {
            let columns = first..size.min(first + WIDTH);
            let mut units = vec![[0.0; WIDTH]; size];
            for j in columns.clone() {
                units[j][j - first] = 1.0;
            }
            let images = self.apply(&units, CORRECTIONS);
            for j in columns {
                for (i, image) in images.iter().enumerate() {
                    dense[(i, j)] += 0.5 * image[j - first];
                    dense[(j, i)] += 0.5 * image[j - first];
                }
            }
        }
        let Ok(eigen) = dense.self_adjoint_eigen(Side::Lower) else { return Vec::new() };
        let (values, vectors) = (eigen.S().column_vector(), eigen.U());
        let vector = |k: usize| (0..size).map(|i| vectors[(i, k)]).collect();
        let pair = |k: usize| self.unshifted_pair(Pair { value: values[k], vector: vector(k), residual: 0.0 });
        let mut all: Vec<Pair> = (0..size).map(pair).collect();
        all.sort_by(|a, b| b.value.total_cmp(&a.value));
        all
    }
}

/// Σ weight(i) xᵢ
fn combine(vectors: &[Vec<f64>], weight: &dyn Fn(usize) -> f64) -> Vec<f64> {
    let mut sum = vec![0.0; vectors.first().map_or(0, Vec::len)];
    for (i, vector) in vectors.iter().enumerate() {
        let weight = weight(i);
        sum.iter_mut().zip(vector).for_each(|(s, x)| *s += weight * x);
    }
    sum
}

/// A with known pairs taken out.
#[derive(Debug)]
struct Deflated<'a> {
    pencil: &'a Pencil<'a>,
    known: Mat<f64>,
    corrections: usize,
}

impl<'a> Deflated<'a> {
    fn new(pencil: &'a Pencil<'a>, known: &[Pair]) -> Self {
        let known = Mat::from_fn(pencil.factor.size(), known.len(), |i, k| known[k].vector[i]);
        Self { pencil, known, corrections: pencil.corrections() }
    }

    fn act(&self, mut ys: Mat<f64>) -> Mat<f64> {
        krylov::take_out(self.known.as_ref(), ys.as_mut());
        for first in (0..ys.ncols()).step_by(WIDTH) {
            let count = WIDTH.min(ys.ncols() - first);
            let mut columns = vec![[0.0; WIDTH]; ys.nrows()];
            for w in 0..count {
                columns.iter_mut().zip(ys.col(first + w).iter()).for_each(|(row, y)| row[w] = *y);
            }
            let out = self.pencil.apply(&columns, self.corrections);
            for w in 0..count {
                ys.col_mut(first + w).iter_mut().zip(&out).for_each(|(y, row)| *y = row[w]);
            }
        }
        krylov::take_out(self.known.as_ref(), ys.as_mut());
        ys
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
        let form = Form { strains: none.clone(), rest: stiffness.clone() };
        let analyzed = Analyzed::default();
        let factor = analyzed.factor(&stiffness).unwrap();
        let (stiffness, other, constraints) = (&stiffness, &mass, &none);
        let pencil = Pencil { factor, shift: 0.0, stiffness, form: &form, other, constraints, analyzed: &analyzed };
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
