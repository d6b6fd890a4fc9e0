//! All nodes of one spatial element at once: tangent and strains in global axes, nothing eliminated.
//!
//! A solve for equilibrium eliminates the nodes between the ends of an element; vibration and buckling need them. Node i
//! of 0…P has the components of its displacement and of its spatial spin, in global axes. With the local unknowns
//! (X, c)ᵢ of the element, their linear change J by the global ones and the gradient (f, w) of the energy,
//! ```text
//! K = Jᵀ k J + Σᵢ (second variation of node i's local unknowns against fᵢ, wᵢ)
//! ```
//! The second variation is that of [`Beam::expand`], node by node, since the local unknowns of a node depend on its own
//! motion and that of the first node alone.

use crate::beam::{At, Beam, Condensed, Local, Moduli};
use crate::laws::LocalLaw;
use crate::small::{M3, V3, add, rotate, scale, zeros};
use crate::space::{Frame, Space, SpatialBeam};

/// A square matrix or a list of rows over the 6 (P + 1) components of an element, by rows.
pub type Rows = Vec<Vec<f64>>;

/// Where the nodes of an element are: its frame, and the unloaded local positions of nodes 1…P.
#[derive(Clone, Copy, Debug)]
pub struct Nodes<'a, const P: usize> {
    /// Frame of the element.
    pub frame: &'a Frame<f64>,
    /// Unloaded places of its nodes in that frame.
    pub reference: &'a [V3<f64>; P],
    /// Displacements and rotations of its nodes in that frame.
    pub local: &'a [[f64; 6]; P],
}

impl<const P: usize> Nodes<'_, P> {
    /// The element's frame, with node i + 1 in the place of the last one.
    fn frame_of(&self, i: usize) -> Frame<f64> {
        let [x, y, z, a, b, c] = self.local[i];
        Frame {
            axes: self.frame.axes,
            position: add(self.reference[i], [x, y, z]),
            displacement: [x, y, z],
            gibbs: [a, b, c],
        }
    }

    /// J: change of the local unknowns (rows) for changes of the global ones (columns).
    fn restriction(&self) -> Rows {
        let mut rows = vec![vec![0.0; 6 * (P + 1)]; 6 * P];
        for i in 0..P {
            let frame = self.frame_of(i);
            for d in 0..6 {
                let mut unit = [0.0; 6];
                unit[d] = 1.0;
                let (first, _) = Space::restrict(&frame, &unit, &[0.0; 6]);
                let (last, _) = Space::restrict(&frame, &[0.0; 6], &unit);
                for row in 0..6 {
                    rows[6 * i + row][d] += first[row];
                    rows[6 * i + row][6 * (i + 1) + d] += last[row];
                }
            }
        }
        rows
    }
}

/// Gradient of the energy with given stresses: what turns with the frame in the tangent.
fn gradient<L: LocalLaw, const P: usize>(at: &At<f64, 6, P>) -> [[f64; 6]; P] {
    // A section without stiffness whose every component is held has the given stresses and no others.
    let softening = at.moduli.softening;
    let moduli = Moduli { stiffness: [0.0; 6], rest: [0.0; 6], held: [1.0; 6], softening };
    let mut local = Local::zero();
    SpatialBeam::<L>::local::<P, false>(&At { moduli: &moduli, ..*at }, &mut local);
    local.gradient
}

/// Tangent of all nodes for the stiffness and the stresses in `at`; without softening linear in both taken together.
///
/// `load` is the dead force on the whole element in its local frame: only what a curved element bulges beyond the
/// interpolation of its nodes makes it part of the tangent.
pub fn tangent<L: LocalLaw, const P: usize>(at: &At<f64, 6, P>, nodes: &Nodes<P>, load: V3<f64>) -> Rows {
    let mut local = Local::<f64, 6, P>::zero();
    SpatialBeam::<L>::local::<P, true>(at, &mut local);
    let restriction = nodes.restriction();
    let n = 6 * (P + 1);
    let entry = |row: usize, column: usize| {
        let (i, j) = (row / 6, column / 6);
        if i <= j { local.tangent[i][j][row % 6][column % 6] } else { local.tangent[j][i][column % 6][row % 6] }
    };
    let mut half = vec![vec![0.0; n]; 6 * P];
    for (row, half) in half.iter_mut().enumerate() {
        for (column, motion) in restriction.iter().enumerate() {
            let k = entry(row, column);
            half.iter_mut().zip(motion).for_each(|(h, m)| *h += k * m);
        }
    }
    let mut whole = vec![vec![0.0; n]; n];
    for (motion, half) in restriction.iter().zip(&half) {
        for (whole, &m) in whole.iter_mut().zip(motion) {
            if m != 0.0 {
                whole.iter_mut().zip(half).for_each(|(w, h)| *w += m * h);
            }
        }
    }
    let gradient = gradient::<L, P>(at);
    for i in 0..P {
        let condensed = Condensed { tangent: zeros(), gradient: [0.0; 6], mixed_end: gradient[i], turn: None };
        let ends = Space::expand(&nodes.frame_of(i), &condensed);
        let last = 6 * (i + 1);
        for a in 0..6 {
            for b in 0..6 {
                whole[a][b] += ends.k00[a][b];
                whole[a][last + b] += ends.k01[a][b];
                whole[last + b][a] += ends.k01[a][b];
                whole[last + a][last + b] += ends.k11[a][b];
            }
        }
    }
    let arm = scale(1.0 / at.piece.length, at.piece.bulge);
    if load != [0.0; 3] && arm != [0.0; 3] {
        let turn: M3<f64> = <Space as Beam<f64, 6>>::load_turn(load, arm).1;
        let turn = rotate(&nodes.frame.axes, &turn);
        for a in 0..3 {
            for b in 0..3 {
                whole[3 + a][3 + b] += turn[a][b];
            }
        }
    }
    whole
}

/// Rows by which the strains at the Gauss points of an element change with the motions of its nodes, each times the root
/// of its stiffness and weight.
#[derive(Clone, Debug, Default)]
pub struct StrainRows {
    /// E of strains with a stiffness: a motion x has the material energy |E x|²/2.
    pub elastic: Rows,
    /// G of strains that are held, with the auxiliary stiffness: a motion that the rod can make has G x = 0.
    pub held: Rows,
}

impl StrainRows {
    /// Eᵀ E + Gᵀ G; nothing where there are no rows.
    pub fn products(&self) -> Rows {
        let all = || self.elastic.iter().chain(&self.held);
        let size = all().next().map_or(0, Vec::len);
        let mut product = vec![vec![0.0; size]; size];
        for row in all() {
            for (target, &left) in product.iter_mut().zip(row) {
                if left != 0.0 {
                    target.iter_mut().zip(row).for_each(|(t, right)| *t += left * right);
                }
            }
        }
        product
    }
}

/// The rows of an element with the section in `at`, at the shape of `nodes`.
///
/// The tangent of all nodes is Eᵀ E + Gᵀ G and the tangent for no stiffness and the same stresses. What the rows say of a motion
/// near to that of a rigid body is of the order of rounding, and enters its energy squared; what the products say of it
/// is the difference of large numbers.
pub fn strain_rows<L: LocalLaw, const P: usize>(at: &At<f64, 6, P>, nodes: &Nodes<P>) -> StrainRows {
    let restriction = nodes.restriction();
    let zero = [[0.0; 6]; P];
    // Stresses of held strains are no part of the change.
    let free = Moduli { held: [0.0; 6], ..*at.moduli };
    let held = at.moduli.held;
    let at = At { moduli: &free, ..*at };
    let still = SpatialBeam::<L>::extrapolate(&at, &zero);
    // The stiffness, which may depend on the shape: what one more unit of elastic strain adds to the stress.
    let more = Moduli { rest: free.rest.map(|rest| rest - 1.0), ..free };
    let strained = SpatialBeam::<L>::extrapolate(&At { moduli: &more, ..at }, &zero);
    let mut rows = StrainRows::default();
    let points = |d: usize| (0..P).map(move |g| (g, d));
    let places: Vec<(usize, usize)> = (0..6).flat_map(points).collect();
    let stiffness = |(g, d): (usize, usize)| strained[g][d] - still[g][d];
    let mut own: Vec<Vec<f64>> = vec![vec![0.0; 6 * (P + 1)]; places.len()];
    for (column, motion) in restriction.iter().enumerate() {
        let mut change = zero;
        change[column / 6][column % 6] = 1.0;
        let moved = SpatialBeam::<L>::extrapolate(&at, &change);
        for (row, &(g, d)) in own.iter_mut().zip(&places) {
            let stress = moved[g][d] - still[g][d];
            if stress != 0.0 {
                let root = (at.table.weights[g] * at.piece.length / stiffness((g, d))).sqrt();
                row.iter_mut().zip(motion).for_each(|(r, m)| *r += root * stress * m);
            }
        }
    }
    for (row, (g, d)) in own.into_iter().zip(places) {
        if held[d] != 0.0 {
            rows.held.push(row);
        } else if stiffness((g, d)) > 0.0 {
            rows.elastic.push(row);
        }
    }
    rows
}
