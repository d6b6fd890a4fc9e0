//! Consistent mass of one spatial element, over all its nodes in global axes.
//!
//! The kinetic energy per unloaded length is ½ ρA |ẋ|² + ½ ω·J ω, J = diag(ρ(I₂ + I₃), ρI₂, ρI₃) in material axes, with the
//! velocities that the element's own interpolation gives:
//! ```text
//! ẋ(s) = Σ Nᵢ u̇ᵢ + φ̇ × b(s)                                    i = 0…P
//! ω(s) = φ̇ + Q G(c)⁻¹ Σ Nᵢ G(cᵢ) Qᵀ (φ̇ᵢ − φ̇)                 i = 0…P
//! ```
//! u and φ are displacement and spin of the nodes, Q the local frame and φ̇ its spin, c the Gibbs vector against the frame with
//! δc = G(c) ψ, and b what the unloaded curve bulges beyond the interpolation of its nodes. A rigid motion has its exact
//! kinetic energy but for the interpolation of the deformed shape.
//!
//! Theory: docs/theory/quadrature.md, Eq. 3.5.

use crate::beam::Piece;
use crate::interpolation::{gauss, shapes};
use crate::rotation;
use crate::small::{
    M3, V3, apply, axpy, diagonal, dot, identity, madd, mscale, mul, outer, scale, skew, transpose, zeros,
};
use crate::space::gibbs_map;
use crate::whole::{Nodes, Rows};

/// Gauss points: exact for products of the highest shape functions and a little more.
const POINTS: usize = 7;

/// Mass and rotatory inertia per unloaded length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inertia {
    /// Mass per length.
    pub mass: f64,
    /// About the material axes 1, 2, 3.
    pub rotary: [f64; 3],
}

/// Mass matrix of all nodes; `curvature` is the initial one, in local axes.
pub fn mass<const P: usize>(piece: &Piece<f64>, curvature: V3<f64>, nodes: &Nodes<P>, inertia: &Inertia) -> Rows {
    let n = 6 * (P + 1);
    let mut whole = vec![vec![0.0; n]; n];
    let (points, weights) = gauss::<POINTS>();
    for g in 0..POINTS {
        let weight = weights[g] * piece.length;
        let motion = Velocities::at(points[g], piece, curvature, nodes);
        let moved = motion.rows();
        for (c, row) in moved.iter().enumerate() {
            let density = weight * if c < 3 { inertia.mass } else { inertia.rotary[c - 3] };
            if density == 0.0 {
                continue;
            }
            for (whole, &left) in whole.iter_mut().zip(row) {
                if left != 0.0 {
                    whole.iter_mut().zip(row).for_each(|(w, right)| *w += density * left * right);
                }
            }
        }
    }
    whole
}

/// Velocities at one point of an element for those of its nodes.
struct Velocities<const P: usize> {
    /// Shape functions of nodes 1…P.
    values: [f64; P],
    /// The bulge in global axes.
    bulge: V3<f64>,
    /// The spin of the frame by those of both ends, from global into local axes.
    frame: [M3<f64>; 2],
    /// The frame's axes in global axes.
    frame_axes: M3<f64>,
    /// G(c)⁻¹ Nᵢ G(cᵢ) for nodes 1…P, in local axes; in the last place what both ends make of the spin between them.
    spins: [M3<f64>; P],
    /// Material axes at the point in local axes, by rows.
    axes: M3<f64>,
}

impl<const P: usize> Velocities<P> {
    fn at(s: f64, piece: &Piece<f64>, curvature: V3<f64>, nodes: &Nodes<P>) -> Self {
        let (values, _) = shapes::<P>(s);
        let turn = scale(s * piece.length, curvature);
        // The unloaded curve, and what its nodes make of it.
        let mut bulge = scale(s * piece.length, apply(&rotation::tangent_map(turn), &[1.0, 0.0, 0.0]));
        let mut c = [0.0; 3];
        for i in 0..P {
            axpy(&mut bulge, -values[i], nodes.reference[i]);
            let [_, _, _, x, y, z] = nodes.local[i];
            axpy(&mut c, values[i], [x, y, z]);
        }
        axpy(&mut c, -1.0, nodes.frame.half);
        let frame = nodes.frame.axes;
        let square = dot(c, c);
        let inverse = mscale(2.0 / (1.0 + square), madd(identity(), skew(c)));
        let local = mscale(
            1.0 / (1.0 + square),
            madd(mscale(1.0 - square, identity()), madd(mscale(2.0, outer(c, c)), mscale(2.0, skew(c)))),
        );
        let axes = transpose(&mul(&local, &rotation::matrix(rotation::exp(turn))));
        let shared: f64 = 0.5 * values[..P - 1].iter().sum::<f64>() + values[P - 1] - 0.5;
        let spins = std::array::from_fn(|i| match i + 1 == P {
            true => mscale(shared * nodes.frame.stretch(), inverse),
            false => mscale(values[i], mul(&inverse, &gibbs_map(nodes.gibbs(i)))),
        });
        let spin = nodes.frame_spin().map(|spin| mul(&spin, &transpose(&frame)));
        Self { values, bulge: apply(&frame, &bulge), frame: spin, frame_axes: frame, spins, axes }
    }

    /// Rows of velocity in global axes and of spin in material axes, over the components of all nodes.
    fn rows(&self) -> [Vec<f64>; 6] {
        let mut rows: [Vec<f64>; 6] = std::array::from_fn(|_| vec![0.0; 6 * (P + 1)]);
        let mut put = |half: usize, node: usize, component: usize, block: &M3<f64>| {
            for a in 0..3 {
                for b in 0..3 {
                    rows[3 * half + a][6 * node + 3 * component + b] += block[a][b];
                }
            }
        };
        let first = 1.0 - self.values.iter().sum::<f64>();
        put(0, 0, 0, &diagonal(first));
        let back = transpose(&self.frame_axes);
        let lever = mul(&skew(scale(-1.0, self.bulge)), &self.frame_axes);
        // What the interior nodes turn more than the frame.
        let mut relative = zeros();
        for i in 0..P {
            put(0, i + 1, 0, &diagonal(self.values[i]));
            if i + 1 < P {
                relative = madd(relative, self.spins[i]);
                put(1, i + 1, 1, &mul(&self.axes, &mul(&self.spins[i], &back)));
            }
        }
        let carried = madd(identity(), mscale(-1.0, relative));
        let between = mul(&self.axes, &mul(&self.spins[P - 1], &back));
        for (end, spin, sign) in [(0, &self.frame[0], -1.0), (P, &self.frame[1], 1.0)] {
            put(0, end, 1, &mul(&lever, spin));
            put(1, end, 1, &mul(&self.axes, &mul(&carried, spin)));
            put(1, end, 1, &mscale(sign, between));
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpolation::node;
    use crate::space::Frame;

    /// A rigid motion of an unloaded bent rod has the kinetic energy of its mass: ½ m v², ½ ∫ ρA |r|² + ρI.
    #[test]
    fn rigid_motions_have_their_exact_kinetic_energy() {
        const P: usize = 3;
        let (length, curvature) = (0.8, [0.4, -0.5, 1.3]);
        let place = |s: f64| scale(s, apply(&rotation::tangent_map(scale(s, curvature)), &[1.0, 0.0, 0.0]));
        let reference: [V3<f64>; P] = std::array::from_fn(|i| place(node(i + 1, P) * length));
        let frame = Frame { axes: identity(), position: reference[P - 1], displacement: [0.0; 3], half: [0.0; 3] };
        let nodes = Nodes { frame: &frame, reference: &reference, local: &[[0.0; 6]; P] };
        let piece = Piece { length, axes: identity(), chord: reference[P - 1], bulge: [0.0; 3] };
        let inertia = Inertia { mass: 2.5, rotary: [0.3, 0.1, 0.2] };
        let whole = mass(&piece, curvature, &nodes, &inertia);
        let energy = |motion: &dyn Fn(V3<f64>) -> [f64; 6]| -> f64 {
            let x: Vec<f64> = (0..=P).flat_map(|i| motion(place(node(i, P) * length))).collect();
            whole.iter().zip(&x).map(|(row, left)| left * row.iter().zip(&x).map(|(m, r)| m * r).sum::<f64>()).sum()
        };
        let shifted = energy(&|_| [1.0, 2.0, -2.0, 0.0, 0.0, 0.0]);
        assert!((shifted - 9.0 * 2.5 * length).abs() < 1e-13);

        let spin = [0.6, -0.3, 0.5];
        let turned = energy(&|r| {
            let v = crate::small::cross(spin, r);
            [v[0], v[1], v[2], spin[0], spin[1], spin[2]]
        });
        let (points, weights) = gauss::<POINTS>();
        let mut exact = 0.0;
        for g in 0..POINTS {
            let s = points[g] * length;
            let v = crate::small::cross(spin, place(s));
            let axes = transpose(&rotation::matrix(rotation::exp(scale(s, curvature))));
            let own = apply(&axes, &spin);
            let rotary: f64 = (0..3).map(|k| inertia.rotary[k] * own[k] * own[k]).sum();
            exact += weights[g] * length * (inertia.mass * dot(v, v) + rotary);
        }
        assert!((turned / exact - 1.0).abs() < 1e-12, "{turned} {exact}");
    }
}
