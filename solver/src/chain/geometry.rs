//! Unloaded geometry of elements of constant curvature.

use pennate_elements::beam::Piece;
use pennate_elements::interpolation::{Table, gauss, node};
use pennate_elements::real::Real;
use pennate_elements::rotation;
use pennate_elements::small::{M3, V3, apply, axpy, scale};

#[derive(Clone, Copy, Debug)]
pub(crate) struct Curve<T, const P: usize> {
    pub frames: [M3<T>; P],
    pub nodes: [V3<T>; P],
}

/// A piece of constant curvature.
pub(crate) struct Bent {
    pub length: f64,
    pub curvature: V3<f64>,
}

impl Bent {
    /// Material axes at s, in those of the start: the columns.
    pub fn frame(&self, s: f64) -> M3<f64> {
        rotation::matrix(rotation::exp(scale(s, self.curvature)))
    }

    /// Position at s: s times the mean of the tangents up to there.
    pub fn position(&self, s: f64) -> V3<f64> {
        scale(s, apply(&rotation::tangent_map(scale(s, self.curvature)), &[1.0, 0.0, 0.0]))
    }

    pub fn curve<const P: usize>(&self) -> Curve<f64, P> {
        let (points, _) = gauss::<P>();
        Curve {
            frames: std::array::from_fn(|g| self.frame(points[g] * self.length)),
            nodes: std::array::from_fn(|i| self.position(node(i + 1, P) * self.length)),
        }
    }

    pub fn piece<const P: usize>(&self, axes: &M3<f64>) -> Piece<f64> {
        let mut bulge = [0.0; 3];
        if self.curvature != [0.0; 3] {
            let table = Table::<P>::new();
            let (points, weights) = gauss::<8>();
            for g in 0..8 {
                axpy(&mut bulge, self.length * weights[g], self.position(points[g] * self.length));
            }
            for i in 0..P {
                let at = self.position(node(i + 1, P) * self.length);
                axpy(&mut bulge, -self.length * table.integrals[i], at);
            }
        }
        Piece { length: self.length, axes: *axes, chord: self.position(self.length), bulge }
    }
}

pub(super) fn set_piece<T: Real>(piece: &mut Piece<T>, lane: usize, value: &Piece<f64>) {
    piece.length.set_lane(lane, value.length);
    for i in 0..3 {
        piece.chord[i].set_lane(lane, value.chord[i]);
        piece.bulge[i].set_lane(lane, value.bulge[i]);
        for j in 0..3 {
            piece.axes[i][j].set_lane(lane, value.axes[i][j]);
        }
    }
}
