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
mod deflated;
mod near;

use faer::Mat;
use sprs::CsMat;

use super::eigen;
use super::factor::{Analyzed, Factor};
use super::krylov::{self, Largest, Pair, ROUNDING, Wanted};
use super::operators::{Form, dot, multiply};
use allowed::{CORRECTIONS, RAISE, RAISES};
use deflated::Deflated;
use near::Space;

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
/// Part of the largest eigenvalue of masses down to which others are found beside it: below it those found are taken out first.
const SPAN: f64 = 1e-7;

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
    /// Whether B is a mass matrix, without negative eigenvalues: its small ones are as exact as its large ones.
    pub is_mass: bool,
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
        let found = shifted.search(&Deflated::new(&shifted, shifted.corrections()), &[], 1, 0).pairs;
        let found: Vec<Pair> = found.into_iter().map(|pair| shifted.unshifted_pair(pair)).collect();
        let pairs = shifted.pairs(&found, 1, true);
        let bracket = if shifted.shift > 0.0 { SHIFT / (ROUGH * BRACKETED * shifted.shift) } else { 0.0 };
        let pairs =
            if pairs.values.first().is_some_and(|value| *value >= bracket) { pairs } else { shifted.largest(1) };
        pairs.above(least)
    }

    /// Factors of K − B/θ: they have as many negative pivots as there are eigenvalues above θ.
    fn factor_at(&self, value: f64) -> Option<Factor> {
        self.factor_of(self.stiffness, value)
    }

    /// The same for another K.
    fn factor_of(&self, stiffness: &CsMat<f64>, value: f64) -> Option<Factor> {
        self.analyzed.factor(&(stiffness - &self.other.map(|entry| entry / value)))
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
            return self.largest_of_all(count);
        }
        let mut found: Vec<Pair> = Vec::new();
        let mut operator = Deflated::new(self, self.corrections());
        let mut largest = 0.0f64;
        let mut in_vain = 0;
        let mut fresh: Vec<Pair> = Vec::new();
        for search in 0..SEARCHES {
            operator.take(&fresh);
            let search = self.search(&operator, &found, count, search);
            let Largest { scale, is_over, .. } = search;
            fresh = search.pairs;
            largest = fresh.iter().fold(largest.max(scale), |largest, pair| largest.max(pair.value.abs()));
            let exhausted = is_over && fresh.iter().all(|pair| self.is_rounding(pair, largest));
            if fresh.is_empty() && !is_over {
                break;
            }
            let known = found.len();
            found.extend(fresh.iter().map(|pair| self.unshifted_pair(pair.clone())));
            let next = found[known..].iter().fold(0.0f64, |largest, pair| largest.max(pair.value));
            found.sort_by(|a, b| b.value.total_cmp(&a.value));
            if exhausted {
                return self.pairs(&found, count, self.is_exhausted(&found, largest));
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

    /// The same of a small network, all eigenvalues of which are computed, those of masses in stages: each takes out what the ones
    /// before have found.
    fn largest_of_all(&self, count: usize) -> Pairs {
        let mut found: Vec<Pair> = Vec::new();
        let mut operator = Deflated::new(self, CORRECTIONS);
        let mut largest = 0.0f64;
        let mut motions = 0;
        let mut fresh: Vec<Pair> = Vec::new();
        loop {
            operator.take(&fresh);
            fresh = self.all(&operator);
            if !self.is_mass {
                return self.pairs(&fresh, count, true);
            }
            largest = fresh.iter().fold(largest, |largest, pair| largest.max(pair.value.abs()));
            let more = fresh.iter().filter(|pair| !self.is_rounding(pair, largest)).count();
            motions += more;
            found.extend(fresh.iter().cloned());
            found.sort_by(|a, b| b.value.total_cmp(&a.value));
            if more == 0 || motions >= count + EXTRA {
                let complete = motions >= count || self.is_exhausted(&found, largest);
                return self.pairs(&found, count, complete);
            }
        }
    }

    /// Whether a pair is what rounding makes of the largest eigenvalue.
    ///
    /// Of masses, a motion is one whatever its eigenvalue is if its own mass and stiffness, which no other takes part in, say the same.
    fn is_rounding(&self, pair: &Pair, largest: f64) -> bool {
        if pair.value.abs() > ROUNDING * largest {
            return false;
        }
        let own = || {
            let motion = self.motion(pair);
            dot(&motion, &self.image(&motion)) / self.form.energy(&motion)
        };
        !(self.is_mass && (own() / pair.value - 1.0).abs() <= COUNTABLE)
    }

    /// Whether the count of pivots says that no eigenvalue of masses is missing above what is rounding among those found.
    fn is_exhausted(&self, found: &[Pair], largest: f64) -> bool {
        if !self.is_mass {
            return true;
        }
        let (rounding, motions): (Vec<&Pair>, Vec<&Pair>) =
            found.iter().partition(|pair| self.is_rounding(pair, largest));
        let limit = rounding.iter().fold(0.0f64, |limit, pair| limit.max(CLEAR * pair.value.abs()));
        limit == 0.0 || self.are_all_above(limit, motions.iter().filter(|pair| pair.value > limit).count())
    }

    /// The pairs in the space of the motions found, with the energy of each as the form has it.
    fn pairs(&self, found: &[Pair], count: usize, complete: bool) -> Pairs {
        let largest = found.iter().fold(0.0f64, |largest, pair| largest.max(pair.value.abs()));
        let is_kept = |pair: &&Pair| pair.value > 0.0 && !self.is_rounding(pair, largest);
        let kept: Vec<&Pair> = found.iter().filter(is_kept).take(count + EXTRA).collect();
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
        let mut space = Space::new(self);
        space.extend(pairs.iter().map(|pair| pair.1.clone()).collect());
        for (value, motion) in pairs {
            let mut left = self.image(motion);
            left.iter_mut().zip(self.form.image(motion)).for_each(|(left, held)| *left -= value * held);
            space.extend(vec![self.response(&left)]);
        }
        let better = space.pairs(pairs.len())?;
        Some(better.into_iter().map(|(value, found)| (value, found.motion)).collect())
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
        let mut space = Space::new(self);
        space.extend(motions.to_vec());
        let pairs = space.pairs(motions.len())?;
        Some(pairs.into_iter().map(|(value, found)| (value, found.motion)).collect())
    }

    /// Whether nothing is missing above the last pair wanted; `next` is the largest eigenvalue that came last. Nothing where
    /// another search may tell.
    fn is_complete(&self, found: &[Pair], count: usize, next: f64) -> Option<bool> {
        let last = found.get(count - 1).filter(|pair| pair.value > 0.0)?;
        // What rounding makes of a stiffness is also what it may make of a count: the factors of another shift have their own. At the
        // limit a motion has −θ/limit times its stiffness in K − B/limit, beside which that is the less the larger its eigenvalue is.
        let motions: Vec<Vec<f64>> = found[..count].iter().map(|pair| self.motion(pair)).collect();
        let energies = self.form.products(&motions);
        let part = |k: usize| {
            (energies[k][k] - 1.0).abs().max(found[k].residual / found[k].value) * last.value / found[k].value
        };
        let off = (0..count).fold(0.0f64, |off, k| off.max(part(k)));
        if !(off <= COUNTABLE) {
            return Some(false);
        }
        // A limit between the last pair and the next one leaves none out, where they are far enough apart.
        let below = found.get(count).map_or(APART * last.value, |pair| pair.value.max(0.0));
        let between = 0.5 * (last.value + below);
        if between * COARSE <= last.value && self.are_all_above(between, count) {
            return Some(true);
        }
        // An auxiliary stiffness in place of a rigid one makes eigenvalues a little larger than they are: the count is
        // coarse there, and a search that brings nothing larger has to agree.
        let rigid = self.constraints.rows() > 0;
        let fine = FINE.max(1.0 + CLEAR * off);
        let limit = last.value * if rigid { fine.max(COARSE) } else { fine };
        let above = found.iter().take_while(|pair| pair.value > limit).count();
        ((!rigid || next <= last.value * fine) && self.are_all_above(limit, above)).then_some(true)
    }

    /// Whether the count of pivots confirms that no more than `known` motions have eigenvalues above a limit.
    ///
    /// A heavy body that is held by an auxiliary stiffness counts as a motion where that is soft beside its mass. One that is stiffer by any
    /// factor leaves what the constraints allow as it is, and its count is never too small.
    fn are_all_above(&self, limit: f64, known: usize) -> bool {
        let counted = self.count_above(limit);
        if counted == Some(known) || self.constraints.rows() == 0 {
            return counted == Some(known);
        }
        let held = &self.constraints.transpose_view().to_csr() * self.constraints;
        let raised = |raise: usize| self.stiffness + &held.map(|entry| (RAISE.powi(raise as i32) - 1.0) * entry);
        let count = |raise| self.factor_of(&raised(raise), limit).map(|factor| factor.negative);
        (1..=RAISES)
            .map(count)
            .take_while(|count| count.is_some_and(|count| count >= known))
            .any(|count| count == Some(known))
    }

    /// Number of eigenvalues above a positive limit: negative pivots of K − B/limit.
    fn count_above(&self, limit: f64) -> Option<usize> {
        self.factor_at(limit).map(|factor| factor.negative)
    }

    /// The largest eigenvalue in a small space, negative ones included.
    fn largest_of_few(&self) -> f64 {
        let operator = Deflated::new(self, self.corrections());
        krylov::largest_of_few(self.factor.size(), &mut |ys| operator.act(ys.to_owned()))
    }

    /// The largest pairs of the shifted pencil beside those that are known and taken out of its operator, with eigenvalues μ.
    fn search(&self, operator: &Deflated<'_>, known: &[Pair], count: usize, search: usize) -> Largest {
        let any_above = |limit: f64| {
            let limit = self.unshifted(limit);
            self.count_above(limit) != Some(known.iter().filter(|pair| pair.value > limit).count())
        };
        krylov::largest(
            self.factor.size(),
            Wanted { count, extra: EXTRA, tolerance: TOLERANCE, span: self.span() },
            search,
            &mut |ys| operator.act(ys.to_owned()),
            &any_above,
        )
    }

    /// Part of the largest eigenvalue down to which others are found beside it.
    fn span(&self) -> f64 {
        if self.is_mass { SPAN } else { 0.0 }
    }

    /// All pairs of a small network beside those that its operator lacks, by falling eigenvalues.
    fn all(&self, operator: &Deflated<'_>) -> Vec<Pair> {
        let size = self.factor.size();
        let mut dense = Mat::<f64>::zeros(size, size);
        for first in (0..size).step_by(WIDTH) {
            let columns = first..size.min(first + WIDTH);
            let units = Mat::from_fn(size, columns.len(), |i, k| f64::from(u8::from(i == first + k)));
            let images = operator.act(units);
            for (k, j) in columns.enumerate() {
                for i in 0..size {
                    dense[(i, j)] += 0.5 * images[(i, k)];
                    dense[(j, i)] += 0.5 * images[(i, k)];
                }
            }
        }
        let Some((values, vectors)) = eigen::symmetric(dense.as_ref()) else { return Vec::new() };
        let vector = |k: usize| (0..size).map(|i| vectors[(i, k)]).collect();
        let pair = |k: usize| self.unshifted_pair(Pair { value: values[k], vector: vector(k), residual: 0.0 });
        // What is known was taken out, and has eigenvalues of rounding.
        let mut all: Vec<Pair> = (0..size).map(pair).collect();
        all.sort_by(|a, b| b.value.total_cmp(&a.value));
        all.truncate(size - operator.count());
        let least = all.first().map_or(0.0, |first| self.span() * first.value);
        all.retain(|pair| !self.is_mass || pair.value >= least);
        all
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
        let pencil = Pencil {
            factor,
            shift: 0.0,
            stiffness,
            form: &form,
            other,
            constraints,
            analyzed: &analyzed,
            is_mass: true,
        };
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
