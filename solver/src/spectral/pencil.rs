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

use faer::{Mat, Side};
use sprs::CsMat;

use super::factor::{Analyzed, Factor};
use super::krylov::{self, Largest, Pair, ROUNDING};

use super::operators::{Form, Operators, dot, multiply, multiply_columns};

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
/// Corrections of the multipliers at most, and the part of a vector at which they are done.
const CORRECTIONS: usize = 30;
const CORRECTED: f64 = 1e-14;
/// The same of motions near those of other elements, beside strains of the energy one. Eigenvalues are off by that times the strains
/// that the auxiliary stiffness needs to hold a motion, which are a hundredth or less.
const IMPROVED: f64 = 1e-12;
/// The same in a search. Its motions are corrected when it is over, and eigenvalues are off by the square of what they were.
const NEARLY: f64 = 1e-3;

/// What does not shrink any more is rounding where it is no more than so many times what is asked for.
const ROUNDED: f64 = 1e4;
/// Part of the strains that one correction may leave; corrections in which that shows; and the part of the first strains below which
/// there is rounding alone.
const LEAVES: f64 = 0.1;
const SHOWING: usize = 5;
const SHOWN: f64 = 1e-9;
/// By how much the auxiliary stiffness of stretches is raised where a correction leaves more, and how often at most.
const RAISE: f64 = 30.0;
const RAISES: usize = 8;

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
/// Motions of other elements are improved so often at most, or until no eigenvalue changes by more than rounding.
const IMPROVEMENTS: usize = 12;
const STILL: f64 = 1e-13;
/// What is left of the energy of a motion that lies in a space.
const NOTHING: f64 = 1e-20;
/// A smallest factor that was found may be larger than where it was looked for by this part.
const BRACKETED: f64 = 1.01;
/// Least part that is left of a stiffness by the shift.
const LEFT: f64 = 1e-12;

/// What is to be brought to what the constraints allow.
#[derive(Clone, Copy, Debug)]
enum Of<'a> {
    /// Motions of energy one.
    Motions,
    /// Forces that are left of motions of energy one, whose eigenvalues these are by size.
    Forces(&'a [f64]),
}

/// Matrices in which corrections take what is held out of a motion within few steps, and what `made` makes of them, with its factors.
///
/// A correction takes the part k F/(1 + k F) out of a stretch, k being the auxiliary stiffness and F what the rest of the network gives
/// way by. Columns that carry a beam a hundred thousand times as stiff as they are move it, if they stretch, as a stiff spring: where k
/// follows from the bending of the columns alone, next to nothing is taken out. It is raised then as far as it has to be, and with it
/// what counts of pivots say of motions without a stretch.
///
/// Where no stiffness that is tried makes corrections fast, as where members hold each other twice, matrices stay as they are.
pub(crate) fn firm<T>(
    operators: &Operators,
    made: &dyn Fn(&Operators) -> Option<T>,
    factor: &dyn Fn(&T) -> &Factor,
) -> Option<(Option<Operators>, T)> {
    let first = made(operators)?;
    let least = operators.holding.iter().copied().fold(f64::INFINITY, f64::min);
    let is_firm =
        |constraints: &CsMat<f64>, factor: &Factor| factor.negative > 0 || leaves(constraints, factor) <= LEAVES;
    if !least.is_finite() || is_firm(&operators.constraints, factor(&first)) {
        return Some((None, first));
    }
    for raise in 1..=RAISES {
        let raised = operators.raised(least * RAISE.powi(raise as i32));
        let Some(again) = made(&raised) else { break };
        if is_firm(&raised.constraints, factor(&again)) {
            return Some((Some(raised), again));
        }
    }
    Some((None, first))
}

/// The largest part that a correction leaves of strains, as far as a few show it.
fn leaves(constraints: &CsMat<f64>, factor: &Factor) -> f64 {
    let start: Vec<[f64; 1]> = krylov::start(factor.size(), 0).into_iter().map(|y| [y]).collect();
    let mut x = factor.backward(&start);
    let mut strains = vec![[0.0]; constraints.rows()];
    multiply_columns(constraints, &x, &mut strains);
    let first = lengths(&strains)[0];
    let (mut before, mut most) = (first, 0.0f64);
    for _ in 0..SHOWING {
        let correction = factor.solve(&back(constraints, &strains));
        x.iter_mut().zip(&correction).for_each(|(x, by)| x[0] -= by[0]);
        multiply_columns(constraints, &x, &mut strains);
        let left = lengths(&strains)[0];
        if !(left > SHOWN * first) {
            break;
        }
        most = most.max(left / before);
        before = left;
    }
    most
}

/// Gᵀ of strains.
fn back<const W: usize>(constraints: &CsMat<f64>, strains: &[[f64; W]]) -> Vec<[f64; W]> {
    let mut back = vec![[0.0; W]; constraints.cols()];
    for (row, strain) in constraints.outer_iterator().zip(strains) {
        for (column, value) in row.iter() {
            for w in 0..W {
                back[column][w] += value * strain[w];
            }
        }
    }
    back
}

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

    /// The pairs near motions of other elements; nothing where these are not near enough.
    ///
    /// What the factors make of the forces that a motion leaves, B x − θ K x, is about what it is off by. Eigenvalues are those of
    /// the space of the motions and of all that they have been found to be off by (E. R. Davidson, J. Comput. Phys. 17, 1975). They are
    /// found when the part of them that may be left is no more than `enough` says of eigenvalue k.
    pub(crate) fn near(&self, motions: &[Vec<f64>], enough: &dyn Fn(usize, f64) -> f64) -> Option<Pairs> {
        let mut space = Space::new(self);
        space.extend(self.allowed(motions, Of::Motions));
        let mut before: Vec<f64> = Vec::new();
        for _ in 0..IMPROVEMENTS {
            let pairs = space.pairs(motions.len())?;
            let left: Vec<Vec<f64>> = pairs.iter().map(|(value, motion)| space.left(*value, motion)).collect();
            let changes = self.allowed(&left, Of::Forces(&pairs.iter().map(|pair| pair.0.abs()).collect::<Vec<f64>>()));
            let part = |(change, pair): (&Vec<f64>, &(f64, _))| self.form.energy(change).max(0.0) / (pair.0 * pair.0);
            let rounding: Vec<f64> = changes.iter().zip(&pairs).map(part).collect();
            let still = |(pair, before): (&(f64, _), &f64)| (pair.0 - before).abs() <= STILL * pair.0.abs();
            let stands = !before.is_empty() && pairs.iter().zip(&before).all(still);
            let is_found = |k: usize| rounding[k] <= enough(k, pairs[k].0);
            let open: Vec<usize> = (0..pairs.len()).filter(|&k| !is_found(k)).collect();
            let near = rounding.iter().all(|part| *part <= COUNTABLE);
            if open.is_empty() || (stands && near) {
                // Sums of strains that cancel hold the rounding of each: the energies of the motions found are made afresh.
                let found: Vec<Vec<f64>> = pairs.into_iter().map(|pair| pair.1.motion).collect();
                let (values, vectors) = self.combined(&found)?.into_iter().unzip();
                return Some(Pairs { values, rounding, vectors, ..Pairs::default() });
            }
            before = pairs.iter().map(|pair| pair.0).collect();
            space.extend(open.iter().map(|&k| changes[k].clone()).collect());
        }
        None
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

    /// The motion that forces lead to, among those that the constraints allow.
    pub(crate) fn response(&self, forces: &[f64]) -> Vec<f64> {
        self.held(&self.factor.forward(forces.as_chunks::<1>().0))
    }

    /// L⁻ᵀ Π y
    fn held(&self, y: &[[f64; 1]]) -> Vec<f64> {
        let mut x = self.factor.backward(y);
        if self.constraints.rows() > 0 {
            self.hold(&mut x, &lengths(y).map(|length| CORRECTED * length));
        }
        x.into_flattened()
    }

    /// The parts of motions that the constraints allow, or those of the motions that forces lead to. The factors may have negative
    /// pivots.
    fn allowed(&self, vectors: &[Vec<f64>], of: Of<'_>) -> Vec<Vec<f64>> {
        let mut allowed = Vec::with_capacity(vectors.len());
        for (index, some) in vectors.chunks(WIDTH).enumerate() {
            let first = index * WIDTH;
            allowed.extend(match some.len() {
                1 => self.allowed_columns::<1>(some, first, of),
                2 => self.allowed_columns::<2>(some, first, of),
                3 => self.allowed_columns::<3>(some, first, of),
                _ => self.allowed_columns::<WIDTH>(some, first, of),
            });
        }
        allowed
    }

    /// The same of W vectors side by side, the first of which has this place among all.
    fn allowed_columns<const W: usize>(&self, vectors: &[Vec<f64>], first: usize, of: Of<'_>) -> Vec<Vec<f64>> {
        let columns: Vec<[f64; W]> = (0..vectors[0].len()).map(|i| std::array::from_fn(|w| vectors[w][i])).collect();
        let mut motions = match of {
            Of::Motions => columns,
            Of::Forces(_) => self.factor.solve(&columns),
        };
        // Motions have the energy one, and what forces lead to is a part of such a motion times its eigenvalue: strains are lengths
        // beside that.
        let least: [f64; W] = std::array::from_fn(|w| match of {
            Of::Motions => IMPROVED,
            Of::Forces(values) => IMPROVED * values[first + w],
        });
        if self.constraints.rows() > 0 {
            self.hold(&mut motions, &least);
        }
        (0..W).map(|w| motions.iter().map(|row| row[w]).collect()).collect()
    }

    /// Takes out of motions what the constraints do not allow, until strains are no longer than `least`.
    ///
    /// One correction x − F⁻¹ Gᵀ G x after the other, F being what the factors are of, leaves as many times what the first one leaves. Near a
    /// critical factor that is a large part in few directions: so steps are combined to the least length of G x (generalized conjugate
    /// residuals; S. C. Eisenstat, H. C. Elman, M. H. Schultz, SIAM J. Numer. Anal. 20, 1983).
    fn hold<const W: usize>(&self, motions: &mut [[f64; W]], least: &[f64; W]) {
        let strains_of = |x: &[[f64; W]]| {
            let mut strains = vec![[0.0; W]; self.constraints.rows()];
            multiply_columns(self.constraints, x, &mut strains);
            strains
        };
        let mut strains = strains_of(motions);
        let mut steps: Vec<[Vec<[f64; W]>; 2]> = Vec::new();
        let mut before = [[f64::INFINITY; W]; 2];
        for _ in 0..CORRECTIONS {
            let left = lengths(&strains);
            // What rounding leaves does not shrink any more.
            let stands = |w: usize| left[w] > 0.9 * before[0][w] && left[w] <= ROUNDED * least[w];
            if (0..W).all(|w| left[w] <= least[w] || stands(w)) {
                break;
            }
            before = [before[1], left];
            let mut change = self.factor.solve(&back(self.constraints, &strains));
            let mut made = strains_of(&change);
            for [known, known_strains] in &steps {
                let along = dots(known_strains, &made).map(|part| -part);
                add_columns(&mut change, &along, known);
                add_columns(&mut made, &along, known_strains);
            }
            let scale = lengths(&made).map(|length| if length > 0.0 { 1.0 / length } else { 0.0 });
            for columns in [&mut change, &mut made] {
                columns.iter_mut().for_each(|row| (0..W).for_each(|w| row[w] *= scale[w]));
            }
            let part = dots(&made, &strains).map(|part| -part);
            add_columns(motions, &part, &change);
            add_columns(&mut strains, &part, &made);
            steps.push([change, made]);
        }
    }

    /// Gᵀ G x, and the length of G x.
    fn held_back<const W: usize>(&self, x: &[[f64; W]]) -> (Vec<[f64; W]>, [f64; W]) {
        let mut strains = vec![[0.0; W]; self.constraints.rows()];
        multiply_columns(self.constraints, x, &mut strains);
        (back(self.constraints, &strains), lengths(&strains))
    }

    /// So many corrections that a motion nearly meets the constraints.
    fn corrections(&self) -> usize {
        if self.constraints.rows() == 0 {
            return 0;
        }
        let start: Vec<[f64; 1]> = krylov::start(self.factor.size(), 0).into_iter().map(|y| [y]).collect();
        let length = lengths(&start)[0];
        let left = |corrections: &usize| {
            let mut strains = vec![[0.0]; self.constraints.rows()];
            multiply_columns(self.constraints, &self.project(&start, *corrections).1, &mut strains);
            lengths(&strains)[0]
        };
        (1..CORRECTIONS).find(|corrections| left(corrections) <= NEARLY * length).unwrap_or(CORRECTIONS)
    }

    /// A y, with so many corrections in place of each Π: an operator as symmetric as A.
    fn apply<const W: usize>(&self, y: &[[f64; W]], corrections: usize) -> Vec<[f64; W]> {
        let (_, x) = self.project(y, corrections);
        let mut b = vec![[0.0; W]; x.len()];
        multiply_columns(self.other, &x, &mut b);
        self.project(&self.factor.forward(&b), corrections).0
    }

    /// Π y, and L⁻ᵀ Π y, by so many corrections at most.
    fn project<const W: usize>(&self, y: &[[f64; W]], corrections: usize) -> (Vec<[f64; W]>, Vec<[f64; W]>) {
        let mut y = y.to_vec();
        let mut x = self.factor.backward(&y);
        if self.constraints.rows() == 0 {
            return (y, x);
        }
        let lengths = lengths(&y);
        let mut before = [f64::INFINITY; W];
        for _ in 0..corrections {
            let (back, left) = self.held_back(&x);
            // What rounding leaves does not shrink any more.
            if (0..W).all(|w| left[w] <= CORRECTED * lengths[w] || left[w] > 0.9 * before[w]) {
                break;
            }
            before = left;
            for (y, correction) in y.iter_mut().zip(self.factor.forward(&back)) {
                for w in 0..W {
                    y[w] -= correction[w];
                }
            }
            x = self.factor.backward(&y);
        }
        (y, x)
    }
}

/// A motion with what the matrices of a pencil make of it.
#[derive(Clone, Debug)]
struct Imaged {
    motion: Vec<f64>,
    /// E x
    strains: Vec<f64>,
    /// R x
    rest: Vec<f64>,
    /// B x
    image: Vec<f64>,
}

impl Imaged {
    fn parts(&mut self) -> [&mut Vec<f64>; 4] {
        [&mut self.motion, &mut self.strains, &mut self.rest, &mut self.image]
    }

    fn add(&mut self, factor: f64, other: &Self) {
        let others = [&other.motion, &other.strains, &other.rest, &other.image];
        for (own, other) in self.parts().into_iter().zip(others) {
            own.iter_mut().zip(other).for_each(|(own, other)| *own += factor * other);
        }
    }

    /// xᵀ K y
    fn energy(&self, other: &Self) -> f64 {
        dot(&self.strains, &other.strains) + dot(&self.motion, &other.rest)
    }
}

/// Motions with xᵢᵀ K xⱼ = δᵢⱼ, and the space of them.
struct Space<'a> {
    pencil: &'a Pencil<'a>,
    basis: Vec<Imaged>,
    /// xᵢᵀ B xⱼ, j ≤ i
    products: Vec<Vec<f64>>,
}

impl<'a> Space<'a> {
    fn new(pencil: &'a Pencil<'a>) -> Self {
        Self { pencil, basis: Vec::new(), products: Vec::new() }
    }

    /// Adds what motions have beside the space.
    fn extend(&mut self, motions: Vec<Vec<f64>>) {
        let Pencil { form, other, .. } = self.pencil;
        let apply = |matrix: &CsMat<f64>, x: &[f64]| {
            let mut out = vec![0.0; matrix.rows()];
            multiply(matrix, x, &mut out);
            out
        };
        for motion in motions {
            let (strains, rest) = (apply(&form.strains, &motion), apply(&form.rest, &motion));
            let mut fresh = Imaged { motion, strains, rest, image: Vec::new() };
            let before = fresh.energy(&fresh);
            // Twice is enough (Kahan and Parlett).
            for _ in 0..2 {
                for known in &self.basis {
                    fresh.add(-known.energy(&fresh), known);
                }
            }
            let energy = fresh.energy(&fresh);
            if !(energy > NOTHING * before) {
                continue;
            }
            let factor = 1.0 / energy.sqrt();
            fresh.parts().into_iter().flatten().for_each(|x| *x *= factor);
            fresh.image = apply(other, &fresh.motion);
            self.basis.push(fresh);
            let fresh = &self.basis[self.basis.len() - 1];
            self.products.push(self.basis.iter().map(|known| dot(&known.motion, &fresh.image)).collect());
        }
    }

    /// The pairs of the space with the largest eigenvalues; nothing where it has fewer.
    fn pairs(&self, count: usize) -> Option<Vec<(f64, Imaged)>> {
        let size = self.basis.len();
        if size < count {
            return None;
        }
        let product = Mat::from_fn(size, size, |i, j| self.products[i.max(j)][i.min(j)]);
        let eigen = product.self_adjoint_eigen(Side::Lower).ok()?;
        let (values, weights) = (eigen.S().column_vector(), eigen.U());
        let pair = |k: usize| {
            let mut motion = self.basis[0].clone();
            motion.parts().into_iter().flatten().for_each(|x| *x *= weights[(0, k)]);
            (1..size).for_each(|i| motion.add(weights[(i, k)], &self.basis[i]));
            (values[k], motion)
        };
        Some((size - count..size).rev().map(pair).collect())
    }

    /// The forces that a motion leaves, B x − θ K x.
    fn left(&self, value: f64, motion: &Imaged) -> Vec<f64> {
        let held = self.pencil.form.image_of(&motion.strains, motion.rest.clone());
        motion.image.iter().zip(held).map(|(image, held)| image - value * held).collect()
    }
}

/// The products of W columns side by side, each with one of others.
fn dots<const W: usize>(a: &[[f64; W]], b: &[[f64; W]]) -> [f64; W] {
    let mut sums = [0.0; W];
    for (a, b) in a.iter().zip(b) {
        (0..W).for_each(|w| sums[w] += a[w] * b[w]);
    }
    sums
}

/// Adds to W columns side by side parts of others.
fn add_columns<const W: usize>(columns: &mut [[f64; W]], parts: &[f64; W], others: &[[f64; W]]) {
    for (own, other) in columns.iter_mut().zip(others) {
        (0..W).for_each(|w| own[w] += parts[w] * other[w]);
    }
}

/// The lengths of W columns side by side.
fn lengths<const W: usize>(columns: &[[f64; W]]) -> [f64; W] {
    let mut squares = [0.0; W];
    for row in columns {
        for w in 0..W {
            squares[w] += row[w] * row[w];
        }
    }
    squares.map(f64::sqrt)
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
