//! The operator of a pencil with what is known of its pairs taken out.
//!
//! Theory: docs/theory/stability.md, Eq. 7.5.

use faer::{Mat, MatRef, Scale, concat};

use super::{Pencil, WIDTH};
use crate::spectral::krylov::{self, Pair};
use crate::spectral::operators::dot;

/// A with known pairs taken out.
#[derive(Debug)]
pub(super) struct Deflated<'a> {
    pencil: &'a Pencil<'a>,
    /// The vectors, of length one.
    known: Mat<f64>,
    /// Of masses, the motions x of known pairs, and M x over xᵀ M x.
    motions: Mat<f64>,
    images: Mat<f64>,
    corrections: usize,
}

impl<'a> Deflated<'a> {
    pub(super) fn new(pencil: &'a Pencil<'a>, corrections: usize) -> Self {
        let none = || Mat::zeros(pencil.factor.size(), 0);
        Self { pencil, known: none(), motions: none(), images: none(), corrections }
    }

    /// How many pairs are taken out.
    pub(super) fn count(&self) -> usize {
        self.known.ncols()
    }

    /// Takes out more pairs, by falling eigenvalues.
    pub(super) fn take(&mut self, pairs: &[Pair]) {
        let size = self.pencil.factor.size();
        let mut fresh = Mat::from_fn(size, pairs.len(), |i, k| pairs[k].vector[i]);
        if self.pencil.is_mass && !pairs.is_empty() {
            // What a vector is off by towards motions of far smaller eigenvalues, applying A makes as many times smaller. Left in it, it
            // would leave as much of the large eigenvalue beside them.
            fresh = self.act(fresh);
            for k in 0..pairs.len() {
                let mut vector = unit(fresh.subcols(k, 1));
                krylov::take_out(fresh.subcols(0, k), vector.as_mut());
                fresh.subcols_mut(k, 1).copy_from(unit(vector.as_ref()));
            }
            let mut motions = Mat::zeros(size, pairs.len());
            let mut images = Mat::zeros(size, pairs.len());
            for k in 0..pairs.len() {
                let column: Vec<[f64; 1]> = fresh.col(k).iter().map(|y| [*y]).collect();
                let motion = self.pencil.project(&column, self.corrections).1.into_flattened();
                let image = self.pencil.image(&motion);
                let mass = dot(&motion, &image);
                if mass > 0.0 {
                    (0..size).for_each(|i| [motions[(i, k)], images[(i, k)]] = [motion[i], image[i] / mass]);
                }
            }
            self.motions = concat![[self.motions, motions]];
            self.images = concat![[self.images, images]];
        }
        self.known = concat![[self.known, fresh]];
    }

    /// A y of columns.
    pub(super) fn act(&self, mut ys: Mat<f64>) -> Mat<f64> {
        krylov::take_out(self.known.as_ref(), ys.as_mut());
        for first in (0..ys.ncols()).step_by(WIDTH) {
            let count = WIDTH.min(ys.ncols() - first);
            let mut columns = vec![[0.0; WIDTH]; ys.nrows()];
            for w in 0..count {
                columns.iter_mut().zip(ys.col(first + w).iter()).for_each(|(row, y)| row[w] = *y);
            }
            let mut motions = self.pencil.project(&columns, self.corrections).1;
            self.take_out(&mut motions);
            let out = self.pencil.answer(&motions, self.corrections);
            for w in 0..count {
                ys.col_mut(first + w).iter_mut().zip(&out).for_each(|(y, row)| *y = row[w]);
            }
        }
        krylov::take_out(self.known.as_ref(), ys.as_mut());
        ys
    }

    /// Takes out of motions what rounding of the factors has left in them of those that are known: a body that is heavy enough would make
    /// any of it large.
    fn take_out(&self, motions: &mut [[f64; WIDTH]]) {
        for (known, image) in self.motions.col_iter().zip(self.images.col_iter()) {
            let mut part = [0.0; WIDTH];
            for (motion, image) in motions.iter().zip(image.iter()) {
                (0..WIDTH).for_each(|w| part[w] += motion[w] * image);
            }
            for (motion, known) in motions.iter_mut().zip(known.iter()) {
                (0..WIDTH).for_each(|w| motion[w] -= part[w] * known);
            }
        }
    }
}

/// A column of length one along another; nothing of nothing.
fn unit(vector: MatRef<'_, f64>) -> Mat<f64> {
    let length = vector.norm_l2();
    Scale(if length > 0.0 { 1.0 / length } else { 0.0 }) * vector
}
