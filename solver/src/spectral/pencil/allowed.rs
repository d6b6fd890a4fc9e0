//! What the constraints allow of motions.
//!
//! Theory: docs/theory/stability.md, Eq. 7.5.

use sprs::CsMat;

use super::{Pencil, WIDTH};
use crate::spectral::factor::Factor;
use crate::spectral::krylov;
use crate::spectral::operators::{Operators, multiply_columns};

/// Corrections of the multipliers at most, and the part of a vector at which they are done.
pub(super) const CORRECTIONS: usize = 30;
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
pub(super) const RAISE: f64 = 30.0;
pub(super) const RAISES: usize = 8;

/// What is to be brought to what the constraints allow.
#[derive(Clone, Copy, Debug)]
pub(super) enum Of<'a> {
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

impl Pencil<'_> {
    /// The motion that forces lead to, among those that the constraints allow.
    pub(crate) fn response(&self, forces: &[f64]) -> Vec<f64> {
        self.held(&self.factor.forward(forces.as_chunks::<1>().0))
    }

    /// L⁻ᵀ Π y
    pub(super) fn held(&self, y: &[[f64; 1]]) -> Vec<f64> {
        let mut x = self.factor.backward(y);
        if self.constraints.rows() > 0 {
            self.hold(&mut x, &lengths(y).map(|length| CORRECTED * length));
        }
        x.into_flattened()
    }

    /// The parts of motions that the constraints allow, or those of the motions that forces lead to. The factors may have negative
    /// pivots.
    pub(super) fn allowed(&self, vectors: &[Vec<f64>], of: Of<'_>) -> Vec<Vec<f64>> {
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
    pub(super) fn corrections(&self) -> usize {
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

    /// Π L⁻¹ B x, with so many corrections in place of Π: of a projected motion x of y, with an operator as symmetric as A.
    pub(super) fn answer<const W: usize>(&self, x: &[[f64; W]], corrections: usize) -> Vec<[f64; W]> {
        let mut b = vec![[0.0; W]; x.len()];
        multiply_columns(self.other, x, &mut b);
        self.project(&self.factor.forward(&b), corrections).0
    }

    /// Π y, and L⁻ᵀ Π y, by so many corrections at most.
    pub(super) fn project<const W: usize>(&self, y: &[[f64; W]], corrections: usize) -> (Vec<[f64; W]>, Vec<[f64; W]>) {
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
