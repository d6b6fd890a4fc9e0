//! Pairs near motions that are known: those of another mesh, or of the same network nearby.
//!
//! Theory: docs/theory/stability.md, Eq. 7.5.

use faer::Mat;
use sprs::CsMat;

use super::allowed::Of;
use super::{COUNTABLE, Pairs, Pencil};
use crate::spectral::eigen;
use crate::spectral::operators::{dot, multiply};

/// Motions of other elements are improved so often at most, or until no eigenvalue changes by more than rounding.
const IMPROVEMENTS: usize = 12;
const STILL: f64 = 1e-13;
/// What is left of the energy of a motion that lies in a space.
const NOTHING: f64 = 1e-20;

impl Pencil<'_> {
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
}

/// A motion with what the matrices of a pencil make of it.
#[derive(Clone, Debug)]
pub(super) struct Imaged {
    pub(super) motion: Vec<f64>,
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
pub(super) struct Space<'a> {
    pencil: &'a Pencil<'a>,
    basis: Vec<Imaged>,
    /// xᵢᵀ B xⱼ, j ≤ i
    products: Vec<Vec<f64>>,
}

impl<'a> Space<'a> {
    pub(super) fn new(pencil: &'a Pencil<'a>) -> Self {
        Self { pencil, basis: Vec::new(), products: Vec::new() }
    }

    /// Adds what motions have beside the space.
    pub(super) fn extend(&mut self, motions: Vec<Vec<f64>>) {
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
    pub(super) fn pairs(&self, count: usize) -> Option<Vec<(f64, Imaged)>> {
        let size = self.basis.len();
        if size < count {
            return None;
        }
        let product = Mat::from_fn(size, size, |i, j| self.products[i.max(j)][i.min(j)]);
        let (values, weights) =
            if self.pencil.is_mass { eigen::graded(product) } else { eigen::symmetric(product.as_ref())? };
        let pair = |k: usize| {
            let mut motion = self.basis[0].clone();
            motion.parts().into_iter().flatten().for_each(|x| *x *= weights[(0, k)]);
            (1..size).for_each(|i| motion.add(weights[(i, k)], &self.basis[i]));
            (values[k], motion)
        };
        Some((0..count).map(pair).collect())
    }

    /// The forces that a motion leaves, B x − θ K x.
    fn left(&self, value: f64, motion: &Imaged) -> Vec<f64> {
        let held = self.pencil.form.image_of(&motion.strains, motion.rest.clone());
        motion.image.iter().zip(held).map(|(image, held)| image - value * held).collect()
    }
}
