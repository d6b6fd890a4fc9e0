//! All nodes of one spatial element at once: tangent and strains in global axes, nothing eliminated.
//!
//! A solve for equilibrium eliminates the nodes between the ends of an element; vibration and buckling need them. Node i
//! of 0…P has the components of its displacement and of its spatial spin, in global axes. With the local unknowns
//! (X, c)ᵢ of the element, their linear change J by the global ones and the gradient (f, w) of the energy,
//! ```text
//! K = Jᵀ k J + Σᵢ (second variation of node i's local unknowns against fᵢ, wᵢ)
//! ```
//! The local unknowns of a node depend on its own motion and on that of the frame, whose spin follows both ends.
//!
//! Theory: docs/theory/frames.md, Eq. 2.1 to 2.4.

use crate::beam::{At, Beam, Local, Moduli};
use crate::laws::LocalLaw;
use crate::rotation::second_variation;
use crate::small::{
    M3, V3, add, axpy, cross, diagonal, dot, identity, madd, mscale, mul, outer, rotate, scale, skew, sub, tapply,
    tmul, transpose, zeros,
};
use crate::space::{Frame, SpatialBeam, gibbs_map};

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
    /// Place of node i + 1 in the frame.
    fn position(&self, i: usize) -> V3<f64> {
        let [x, y, z, ..] = self.local[i];
        add(self.reference[i], [x, y, z])
    }

    /// Gibbs vector of node i + 1 against the frame.
    pub(crate) fn gibbs(&self, i: usize) -> V3<f64> {
        let [_, _, _, a, b, c] = self.local[i];
        sub([a, b, c], self.frame.half)
    }

    /// The spin of the frame for the spins of both ends, in local axes.
    pub(crate) fn frame_spin(&self) -> [M3<f64>; 2] {
        let last = madd(diagonal(0.5), skew(scale(-0.5, self.frame.half)));
        [transpose(&last), last]
    }

    /// J: change of the local unknowns (rows) for changes of the global ones (columns).
    fn restriction(&self) -> Rows {
        let mut rows = vec![vec![0.0; 6 * (P + 1)]; 6 * P];
        let mut put = |row: usize, node: usize, half: usize, block: &M3<f64>| {
            let block = mul(block, &transpose(&self.frame.axes));
            for a in 0..3 {
                for b in 0..3 {
                    rows[row + a][6 * node + 3 * half + b] += block[a][b];
                }
            }
        };
        let one: M3<f64> = identity();
        let minus = |block: &M3<f64>| mscale(-1.0, *block);
        let ends = [0, P];
        let stretch = diagonal(self.frame.stretch());
        for i in 0..P {
            put(6 * i, 0, 0, &minus(&one));
            put(6 * i, i + 1, 0, &one);
            let lever = skew(self.position(i));
            let map = gibbs_map(self.gibbs(i));
            for (end, spin) in ends.into_iter().zip(&self.frame_spin()) {
                put(6 * i, end, 1, &mul(&lever, spin));
                if i + 1 < P {
                    put(6 * i + 3, end, 1, &minus(&mul(&map, spin)));
                }
            }
            // What all nodes share is half of what the last one has.
            let share = if i + 1 < P { mscale(0.5, stretch) } else { stretch };
            put(6 * i + 3, P, 1, &share);
            put(6 * i + 3, 0, 1, &minus(&share));
            if i + 1 < P {
                put(6 * i + 3, i + 1, 1, &map);
            }
        }
        rows
    }

    /// Second variation of the local unknowns against a gradient of the energy, by the global ones; `load` on the whole element
    /// has the lever `arm` about the first node.
    fn second_variation(&self, gradient: &[[f64; 6]; P], load: V3<f64>, arm: V3<f64>) -> Rows {
        let half = self.frame.half;
        let mut sum = Second::<P>::new(&self.frame.axes);
        let mut moment = cross(load, arm);
        sum.frame = mscale(-1.0, second_variation(load, arm));
        let mut shared = [0.0; 3];
        for i in 0..P {
            let [f, w] = [[0, 1, 2], [3, 4, 5]].map(|rows| rows.map(|row| gradient[i][row]));
            let position = self.position(i);
            moment = add(moment, cross(f, position));
            sum.frame = madd(sum.frame, second_variation(f, position));
            let turned = skew(scale(-1.0, f));
            sum.add_coupling(i + 1, 0, &turned);
            sum.add_coupling(0, 0, &mscale(-1.0, turned));
            axpy(&mut shared, if i + 1 < P { 0.5 } else { 1.0 }, w);
            if i + 1 == P {
                continue;
            }
            let c = self.gibbs(i);
            let m = tapply(&gibbs_map(c), &w);
            moment = sub(moment, m);
            // By the spin of the node against the frame: ψ = φᵢ − φ.
            let own = mscale(0.5, madd(outer(m, c), outer(c, m)));
            let turned = skew(scale(0.5, m));
            sum.add(i + 1, i + 1, &own);
            // Rows of the node: those of ½ m̂, and what is taken off with the frame.
            sum.add_coupling(i + 1, 1, &madd(transpose(&turned), mscale(-1.0, own)));
            // ½ m̂ and its transpose cancel.
            sum.frame = madd(sum.frame, own);
        }
        let m = scale(self.frame.stretch(), shared);
        let own = mscale(0.25, madd(outer(m, half), outer(half, m)));
        for (a, b, sign) in [(P, P, 1.0), (0, 0, 1.0), (P, 0, -1.0), (0, P, -1.0)] {
            sum.add(a, b, &mscale(sign, own));
        }
        let along = madd(outer(moment, half), diagonal(-dot(moment, half)));
        let coupling = transpose(&madd(skew(scale(0.5, m)), mscale(0.25, along)));
        sum.add_coupling(P, 1, &coupling);
        sum.add_coupling(0, 1, &mscale(-1.0, coupling));
        sum.of_all_nodes(&self.frame_spin())
    }
}

/// A quadratic form in the motions of all nodes and in the spin of the frame, which follows both ends.
struct Second<'a, const P: usize> {
    axes: &'a M3<f64>,
    /// In global axes.
    nodes: Rows,
    /// Of the nodes' components with the spin of the frame: rows in global axes, columns in local ones.
    coupling: Vec<V3<f64>>,
    /// Of the spin of the frame, in local axes.
    frame: M3<f64>,
}

impl<'a, const P: usize> Second<'a, P> {
    fn new(axes: &'a M3<f64>) -> Self {
        let n = 6 * (P + 1);
        Self { axes, nodes: vec![vec![0.0; n]; n], coupling: vec![[0.0; 3]; n], frame: zeros() }
    }

    /// Adds what the spins of two nodes have with one another, in local axes.
    fn add(&mut self, node: usize, other: usize, block: &M3<f64>) {
        let block = rotate(self.axes, block);
        for a in 0..3 {
            for b in 0..3 {
                self.nodes[6 * node + 3 + a][6 * other + 3 + b] += block[a][b];
            }
        }
    }

    /// Adds what displacements (0) or spins (1) of a node have with the spin of the frame, in local axes.
    fn add_coupling(&mut self, node: usize, half: usize, block: &M3<f64>) {
        let block = mul(self.axes, block);
        for a in 0..3 {
            let row = &mut self.coupling[6 * node + 3 * half + a];
            *row = add(*row, block[a]);
        }
    }

    /// The form in the motions of the nodes alone, in global axes, for the spin of the frame that those of both ends make.
    fn of_all_nodes(self, spin: &[M3<f64>; 2]) -> Rows {
        let Self { axes, mut nodes, coupling, frame } = self;
        // From spins of the ends in global axes.
        let spin = spin.map(|spin| mul(&spin, &transpose(axes)));
        let ends = [(0, &spin[0]), (P, &spin[1])];
        for (end, spin) in ends {
            for (row, coupling) in coupling.iter().enumerate() {
                for (b, along) in tapply(spin, coupling).into_iter().enumerate() {
                    nodes[row][6 * end + 3 + b] += along;
                    nodes[6 * end + 3 + b][row] += along;
                }
            }
            for (other, turned) in ends {
                let block = tmul(spin, &mul(&frame, turned));
                for a in 0..3 {
                    for b in 0..3 {
                        nodes[6 * end + 3 + a][6 * other + 3 + b] += block[a][b];
                    }
                }
            }
        }
        nodes
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
    let arm = scale(1.0 / at.piece.length, at.piece.bulge);
    let second = nodes.second_variation(&gradient::<L, P>(at), load, arm);
    for (row, more) in whole.iter_mut().zip(&second) {
        row.iter_mut().zip(more).for_each(|(entry, more)| *entry += more);
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
