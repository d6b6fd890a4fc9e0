//! The elements of one member in a row, and the elimination of its interior.
//!
//! A [`Chain`] owns what belongs to its members alone: geometry, section stiffness, the state of interior nodes and the
//! factors of their elimination. Inside an element the nodes between its ends are eliminated first, block by block,
//! then the element ends from the start of the member to its end. What is left is a stiffness between the two ends of
//! the member. Members of equal mesh may lie side by side in the lanes of `T`.

use pennate_elements::beam::{At, Beam, Condensed, Ends, Local, Moduli, Piece, Placement, Turn};
use pennate_elements::interpolation::{Table, gauss, node};
use pennate_elements::plane;
use pennate_elements::real::Real;
use pennate_elements::rotation;
use pennate_elements::small::{
    Ldl, M3, V3, add, apply, axpy, cross, madd, mscale, norm, scale, sub, tapply, tmul, transpose, zeros,
};

use crate::history::{MemberShape, ShapeCell, ShapePoint};
use crate::linear::PIVOT_NOISE;

/// How often a state can be put aside: the last converged one, the one before it, and one more for a detour.
pub const SLOTS: usize = 3;

/// Mesh and unloaded geometry of one member, as its chain is built from it.
#[derive(Clone, Debug)]
pub struct ChainMesh {
    pub member: usize,
    /// Material axes at the start by rows; in the plane axis 3 is z.
    pub axes: M3<f64>,
    pub segments: Vec<SegmentMesh>,
}

#[derive(Clone, Copy, Debug)]
pub struct SegmentMesh {
    pub length: f64,
    pub elements: usize,
    /// In the axes of [`ChainMesh::axes`].
    pub curvature: V3<f64>,
}

/// What changes in a chain during a solve.
#[derive(Clone, Debug)]
struct ChainState<Pose, T, const D: usize> {
    /// Element ends.
    nodes: Vec<Pose>,
    /// Interior local unknowns, P an element (the last is a copy of the element's end).
    local: Vec<[T; D]>,
    /// Mixed stresses at the Gauss points, P an element.
    stress: Vec<[T; D]>,
}

/// Factors of an element end that was eliminated.
#[derive(Clone, Copy, Debug)]
struct NodeFactor<T, const D: usize> {
    left: [[T; D]; D],
    next: [[T; D]; D],
    rest: [T; D],
}

/// The size of an increment: largest rotation (radians) and largest displacement over the member's length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Size {
    pub rotation: f64,
    pub displacement: f64,
}

impl Size {
    pub fn join(self, other: Self) -> Self {
        Self {
            rotation: larger(self.rotation, other.rotation),
            displacement: larger(self.displacement, other.displacement),
        }
    }

    pub fn largest(self) -> f64 {
        larger(self.rotation, self.displacement)
    }
}

/// The larger of two numbers; a NaN wins, so that it is never overlooked.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// What is left of a member after elimination: stiffness and residual of its two ends in global axes.
pub type MemberEnds<const D: usize> = Ends<f64, D>;

/// The chains of the members that lie side by side in one `T`, whatever their order.
pub trait Pack<const D: usize>: Send {
    fn members(&self) -> &[usize];
    fn segments(&self) -> usize;
    fn element_length(&self, lane: usize, segment: usize) -> f64;
    fn set_moduli(&mut self, lane: usize, segment: usize, moduli: &Moduli<f64, 6>);
    /// Dead force per unloaded length.
    fn set_load(&mut self, lane: usize, segment: usize, load: V3<f64>);
    fn end(&self, lane: usize, end: usize) -> Placement;
    fn set_end(&mut self, lane: usize, end: usize, placement: &Placement);
    /// Linearizes every element and eliminates everything between the ends.
    fn condense(&mut self);
    fn condensed(&self, lane: usize) -> MemberEnds<D>;
    /// Number of negative pivots of the eliminated interior, and the smallest pivot ratio met there.
    fn pivots(&self, lane: usize) -> (usize, f64);
    fn energy(&self, lane: usize) -> f64;
    fn set_increment(&mut self, lane: usize, ends: &[[f64; D]; 2]);
    /// Back-substitution for the increments of the ends, and the move of the interior; the ends move with
    /// [`Pack::set_end`].
    fn advance(&mut self);
    fn size(&self, lane: usize) -> Size;
    /// With `plain` the geometric stiffness uses the stresses of the present strains (no mixed integration points).
    fn set_plain(&mut self, plain: bool);
    /// Part of a diagonal entry below which its pivot has no sign.
    fn set_pivot_noise(&mut self, noise: f64);
    /// Takes positions and local unknowns of a saved state, and a part of the change of the mixed stresses since.
    fn restore_shape(&mut self, slot: usize, part: f64);
    /// How far the present element ends are from a saved state.
    fn distance(&self, lane: usize, slot: usize) -> Size;
    fn save(&mut self, slot: usize);
    fn restore(&mut self, slot: usize);
    /// Exchanges two saved states.
    fn swap(&mut self, a: usize, b: usize);
    /// Linear extrapolation from two saved states.
    fn predict(&mut self, before: usize, last: usize, ratio: f64);
    /// The lateral stiffness of a plane chain: components uz, φx, φy; with the pivots of its interior.
    fn lateral(&mut self, lane: usize, stiffness: &[[f64; 6]]) -> (Ends<f64, 3>, usize, f64);
    /// Copies the state of a chain with the same elements and another order.
    fn prolong(&mut self, coarse: &dyn Pack<D>);
    /// Copies the state of a plane chain with the same elements and order into a spatial one.
    fn lift(&mut self, plane: &dyn Pack<3>);
    /// Interior state of an element at a unit coordinate: local unknowns, and mixed stress (extrapolated from the
    /// Gauss points).
    fn sample(&self, lane: usize, element: usize, s: f64) -> ([f64; D], [f64; D]);
    fn element_end(&self, lane: usize, index: usize) -> Placement;
    fn elements(&self) -> usize;
    fn order(&self) -> usize;
    fn length(&self, lane: usize) -> f64;
    /// Tangent at the middle of the unloaded length, and the load along the member up to there.
    fn middle(&self, lane: usize) -> (V3<f64>, V3<f64>);
    /// Sum of the load along the member.
    fn total_load(&self, lane: usize) -> V3<f64>;
    /// Shape and section forces; `force` and `moment` act on the start of the member, `origin` is its unloaded place.
    fn shape(&self, lane: usize, origin: V3<f64>, force: V3<f64>, moment: V3<f64>) -> MemberShape;
}

/// Chains of equal mesh with elements of order P.
#[derive(Debug)]
pub struct Chain<T: Real, B: Beam<T, D>, const D: usize, const P: usize> {
    members: Vec<usize>,
    table: Table<P>,
    pieces: Vec<Piece<T>>,
    /// Gauss frames and unloaded local positions of nodes 1…P; empty for straight members.
    curves: Vec<Curve<T, P>>,
    segment_of: Vec<usize>,
    segments: usize,
    moduli: Vec<Moduli<T, D>>,
    loads: Vec<V3<T>>,
    loaded: bool,
    plain: bool,
    noise: f64,
    state: ChainState<B::Pose, T, D>,
    saved: [ChainState<B::Pose, T, D>; SLOTS],
    frames: Vec<B::Frame>,
    /// Elimination inside the elements: blocks x_ij, j > i, right-hand sides, and turn columns.
    inner: Vec<[[T; D]; D]>,
    inner_rest: Vec<[T; D]>,
    inner_turn: Vec<[[T; 3]; D]>,
    factors: Vec<NodeFactor<T, D>>,
    ends: Ends<T, D>,
    increments: Vec<[T; D]>,
    negative: T,
    smallest: T,
    energy: T,
    total_length: T,
}

#[derive(Clone, Copy, Debug)]
struct Curve<T, const P: usize> {
    frames: [M3<T>; P],
    nodes: [V3<T>; P],
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    const INNER_BLOCKS: usize = P * (P - 1) / 2;
    const INNER_NODES: usize = P - 1;
    /// Translations of a node.
    const TRANSLATIONS: usize = if D == 6 { 3 } else { 2 };

    /// Chains of as many members as `T` has lanes (the last is repeated where there are fewer), all of equal mesh.
    pub fn new(meshes: &[ChainMesh]) -> Self {
        let first = &meshes[0];
        let segment_of: Vec<usize> =
            first.segments.iter().enumerate().flat_map(|(i, s)| std::iter::repeat_n(i, s.elements)).collect();
        let elements = segment_of.len();
        let curved = meshes.iter().flat_map(|m| &m.segments).any(|s| s.curvature != [0.0; 3]);
        let mut pieces = vec![Piece::default(); elements];
        let zero_curve = Curve { frames: [zeros(); P], nodes: [[T::zero(); 3]; P] };
        let mut curves = vec![zero_curve; if curved { elements } else { 0 }];
        let mut total_length = T::zero();
        for lane in 0..T::LANES {
            let mesh = &meshes[lane.min(meshes.len() - 1)];
            let mut axes = mesh.axes;
            let mut total = 0.0;
            for (e, &segment) in segment_of.iter().enumerate() {
                let SegmentMesh { length, elements, curvature } = mesh.segments[segment];
                let length = length / elements as f64;
                total += length;
                let bent = Bent { length, curvature };
                set_piece(&mut pieces[e], lane, &bent.piece::<P>(&axes));
                if curved {
                    let curve = bent.curve::<P>();
                    for g in 0..P {
                        for i in 0..3 {
                            curves[e].nodes[g][i].set_lane(lane, curve.nodes[g][i]);
                            for j in 0..3 {
                                curves[e].frames[g][i][j].set_lane(lane, curve.frames[g][i][j]);
                            }
                        }
                    }
                }
                axes = tmul(&bent.frame(length), &axes);
            }
            total_length.set_lane(lane, total);
        }
        let segments = first.segments.len();
        let state = ChainState {
            nodes: vec![B::Pose::default(); elements + 1],
            local: vec![[T::zero(); D]; elements * P],
            stress: vec![[T::zero(); D]; elements * P],
        };
        let frame = B::frame(&pieces[0], &state.nodes[0], &state.nodes[1]);
        let o = T::zero();
        let factor = NodeFactor { left: zeros(), next: zeros(), rest: [o; D] };
        Self {
            members: meshes.iter().map(|m| m.member).collect(),
            table: Table::new(),
            pieces,
            curves,
            segment_of,
            segments,
            moduli: vec![Moduli::default(); segments],
            loads: vec![[o; 3]; segments],
            loaded: false,
            plain: false,
            noise: PIVOT_NOISE,
            saved: std::array::from_fn(|_| state.clone()),
            state,
            frames: vec![frame; elements],
            inner: vec![zeros(); elements * Self::INNER_BLOCKS],
            inner_rest: vec![[o; D]; elements * Self::INNER_NODES],
            inner_turn: vec![zeros(); elements * Self::INNER_NODES],
            factors: vec![factor; elements - 1],
            ends: Ends { k00: zeros(), k01: zeros(), k11: zeros(), r0: [o; D], r1: [o; D] },
            increments: vec![[o; D]; elements + 1],
            negative: o,
            smallest: T::one(),
            energy: o,
            total_length,
        }
    }

    fn curved(&self, element: usize) -> Option<&[M3<T>; P]> {
        self.curves.get(element).map(|curve| &curve.frames)
    }

    /// Unloaded local position of node i + 1 of an element.
    fn reference(&self, element: usize, i: usize) -> V3<T> {
        match self.curves.get(element) {
            Some(curve) => curve.nodes[i],
            None => scale(T::splat(node(i + 1, P)), self.pieces[element].chord),
        }
    }

    /// Local unknowns of an element, the last node's from its frame.
    fn local_of(&self, element: usize, frame: &B::Frame) -> [[T; D]; P] {
        let mut local: [[T; D]; P] = std::array::from_fn(|i| self.state.local[element * P + i]);
        local[P - 1] = B::last_local(frame);
        local
    }

    fn stress_of(&self, element: usize) -> [[T; D]; P] {
        std::array::from_fn(|g| self.state.stress[element * P + g])
    }

    /// Condenses one element to its last node, and stores the factors.
    #[inline(always)]
    fn condense_element(&mut self, e: usize) -> Ends<T, D> {
        let frame = B::frame(&self.pieces[e], &self.state.nodes[e], &self.state.nodes[e + 1]);
        self.frames[e] = frame;
        let local = self.local_of(e, &frame);
        if self.plain {
            self.reset_stress(e);
        }
        let stress = self.stress_of(e);
        let moduli = self.moduli[self.segment_of[e]];
        let mut k = Local::zero();
        let at = At {
            table: &self.table,
            piece: &self.pieces[e],
            curved: self.curved(e),
            moduli: &moduli,
            local: &local,
            stress: &stress,
        };
        B::local::<P, true>(&at, &mut k);
        self.energy += k.energy;

        let mut turn = self.loaded.then(|| self.load_element(e, &frame, &local, &mut k));
        let mut coupling = turn.map(|t| t.1);
        let (blocks, nodes) = (e * Self::INNER_BLOCKS, e * Self::INNER_NODES);
        let mut block = blocks;
        for i in 0..P - 1 {
            let ldl = Ldl::with_noise(&k.tangent[i][i], T::splat(self.noise));
            self.negative += ldl.negative;
            self.smallest = -((-self.smallest).max(-ldl.smallest));
            let rest = ldl.solve_vector(&k.gradient[i]);
            self.inner_rest[nodes + i] = rest;
            if let (Some((t, _)), Some(coupling)) = (&mut turn, &mut coupling) {
                let solved = ldl.solve(&coupling[i]);
                self.inner_turn[nodes + i] = solved;
                let own = coupling[i];
                t.tangent = sub_matrix(t.tangent, tmul(&own, &solved));
                t.gradient = sub(t.gradient, tapply(&own, &rest));
                for (j, row) in k.tangent[i].iter().enumerate().skip(i + 1) {
                    coupling[j] = sub_matrix(coupling[j], tmul(row, &solved));
                }
            }
            for j in i + 1..P {
                let kij = k.tangent[i][j];
                let solved = ldl.solve(&kij);
                self.inner[block] = solved;
                block += 1;
                k.gradient[j] = sub(k.gradient[j], tapply(&kij, &rest));
                for l in i + 1..=j {
                    let other = k.tangent[i][l];
                    let update = tmul(&other, &solved);
                    k.tangent[l][j] = sub_matrix(k.tangent[l][j], update);
                }
            }
        }
        let turn = turn.map(|(t, _)| Turn { coupling: coupling.unwrap_or([zeros(); P])[P - 1], ..t });
        let condensed =
            Condensed { tangent: k.tangent[P - 1][P - 1], gradient: k.gradient[P - 1], mixed_end: k.mixed_end, turn };
        let mut ends = B::expand(&frame, &condensed);
        if self.loaded {
            let force = scale(self.pieces[e].length, self.loads[self.segment_of[e]]);
            let last = T::splat(self.table.integrals[P - 1]);
            for d in 0..Self::TRANSLATIONS {
                ends.r0[d] -= (T::one() - last) * force[d];
                ends.r1[d] -= last * force[d];
            }
        }
        ends
    }

    /// Stresses of the present strains in place of mixed ones; multipliers stay.
    fn reset_stress(&mut self, e: usize) {
        let strains = self.strains(e);
        let moduli = self.moduli[self.segment_of[e]];
        for (g, strain) in strains.iter().enumerate() {
            let stress = &mut self.state.stress[e * P + g];
            for i in 0..D {
                let elastic = moduli.stiffness[i] * (strain[i] - moduli.rest[i]);
                stress[i] = elastic + moduli.held[i] * stress[i];
            }
        }
    }

    /// Adds the load along an element to its interior nodes; gives what couples to the turn of the frame.
    fn load_element(
        &self,
        e: usize,
        frame: &B::Frame,
        local: &[[T; D]; P],
        k: &mut Local<T, D, P>,
    ) -> (Turn<T, D>, [[[T; 3]; D]; P]) {
        let load = scale(self.pieces[e].length, B::pull_back(frame, self.loads[self.segment_of[e]]));
        let inverse = T::one() / self.pieces[e].length;
        let mut arm = scale(inverse, self.pieces[e].bulge);
        let mut coupling = [zeros(); P];
        for i in 0..P - 1 {
            let weight = T::splat(self.table.integrals[i]);
            let mut position = self.reference(e, i);
            for d in 0..Self::TRANSLATIONS {
                position[d] += local[i][d];
                k.gradient[i][d] -= weight * load[d];
            }
            axpy(&mut arm, weight, position);
            coupling[i] = B::load_coupling(scale(weight, load));
        }
        let (gradient, tangent) = B::load_turn(load, arm);
        (Turn { coupling: zeros(), tangent, gradient }, coupling)
    }
}

fn sub_matrix<T: Real, const N: usize, const M: usize>(a: [[T; M]; N], b: [[T; M]; N]) -> [[T; M]; N] {
    std::array::from_fn(|i| sub(a[i], b[i]))
}

fn lane<T: Real, const N: usize>(a: &[T; N], lane: usize) -> [f64; N] {
    a.map(|x| x.lane(lane))
}

fn lanes<T: Real, const N: usize, const M: usize>(a: &[[T; M]; N], index: usize) -> [[f64; M]; N] {
    a.map(|row| lane(&row, index))
}

fn set_piece<T: Real>(piece: &mut Piece<T>, lane: usize, value: &Piece<f64>) {
    piece.length.set_lane(lane, value.length);
    for i in 0..3 {
        piece.chord[i].set_lane(lane, value.chord[i]);
        piece.bulge[i].set_lane(lane, value.bulge[i]);
        for j in 0..3 {
            piece.axes[i][j].set_lane(lane, value.axes[i][j]);
        }
    }
}

/// A piece of constant curvature.
struct Bent {
    length: f64,
    curvature: V3<f64>,
}

impl Bent {
    /// Material axes at s, in those of the start: the columns.
    fn frame(&self, s: f64) -> M3<f64> {
        rotation::matrix(rotation::exp(scale(s, self.curvature)))
    }

    /// Position at s: s times the mean of the tangents up to there.
    fn position(&self, s: f64) -> V3<f64> {
        scale(s, apply(&rotation::tangent_map(scale(s, self.curvature)), &[1.0, 0.0, 0.0]))
    }

    fn curve<const P: usize>(&self) -> Curve<f64, P> {
        let (points, _) = gauss::<P>();
        Curve {
            frames: std::array::from_fn(|g| self.frame(points[g] * self.length)),
            nodes: std::array::from_fn(|i| self.position(node(i + 1, P) * self.length)),
        }
    }

    fn piece<const P: usize>(&self, axes: &M3<f64>) -> Piece<f64> {
        let table = Table::<P>::new();
        let mut bulge = [0.0; 3];
        if self.curvature != [0.0; 3] {
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

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Pack<D> for Chain<T, B, D, P> {
    fn members(&self) -> &[usize] {
        &self.members
    }

    fn segments(&self) -> usize {
        self.segments
    }

    fn element_length(&self, lane: usize, segment: usize) -> f64 {
        let element = self.segment_of.iter().position(|&s| s == segment).unwrap_or(0);
        self.pieces[element].length.lane(lane)
    }

    fn set_moduli(&mut self, lane: usize, segment: usize, moduli: &Moduli<f64, 6>) {
        let target = &mut self.moduli[segment];
        for d in 0..D {
            let from = if D == 6 { d } else { [0, 1, 5][d] };
            target.stiffness[d].set_lane(lane, moduli.stiffness[from]);
            target.rest[d].set_lane(lane, moduli.rest[from]);
            target.held[d].set_lane(lane, moduli.held[from]);
        }
    }

    fn set_load(&mut self, lane: usize, segment: usize, load: V3<f64>) {
        for (target, value) in self.loads[segment].iter_mut().zip(load) {
            target.set_lane(lane, value);
        }
        self.loaded = self.loads.iter().flatten().any(|q| (0..T::LANES).any(|l| q.lane(l) != 0.0));
    }

    fn end(&self, lane: usize, end: usize) -> Placement {
        B::pose(&self.state.nodes[end * self.frames.len()], lane)
    }

    fn set_end(&mut self, lane: usize, end: usize, placement: &Placement) {
        let index = end * self.frames.len();
        B::set_pose(&mut self.state.nodes[index], lane, placement);
    }

    fn condense(&mut self) {
        self.negative = T::zero();
        self.smallest = T::one();
        self.energy = T::zero();
        let first = self.condense_element(0);
        let (mut left, mut link, mut here) = (first.k00, first.k01, first.k11);
        let (mut left_rest, mut rest) = (first.r0, first.r1);
        for e in 1..self.frames.len() {
            let next = self.condense_element(e);
            let pivot = madd(here, next.k00);
            let ldl = Ldl::with_noise(&pivot, T::splat(self.noise));
            self.negative += ldl.negative;
            self.smallest = -((-self.smallest).max(-ldl.smallest));
            let factor = NodeFactor {
                left: ldl.solve(&transpose(&link)),
                next: ldl.solve(&next.k01),
                rest: ldl.solve_vector(&add(rest, next.r0)),
            };
            left = sub_matrix(left, mul_block(&link, &factor.left));
            left_rest = sub(left_rest, apply(&link, &factor.rest));
            here = sub_matrix(next.k11, tmul(&next.k01, &factor.next));
            rest = sub(next.r1, tapply(&next.k01, &factor.rest));
            link = mscale(-T::one(), mul_block(&link, &factor.next));
            self.factors[e - 1] = factor;
        }
        self.ends = Ends { k00: left, k01: link, k11: here, r0: left_rest, r1: rest };
    }

    fn condensed(&self, lane: usize) -> MemberEnds<D> {
        Ends {
            k00: lanes(&self.ends.k00, lane),
            k01: lanes(&self.ends.k01, lane),
            k11: lanes(&self.ends.k11, lane),
            r0: self::lane(&self.ends.r0, lane),
            r1: self::lane(&self.ends.r1, lane),
        }
    }

    fn pivots(&self, lane: usize) -> (usize, f64) {
        (self.negative.lane(lane) as usize, self.smallest.lane(lane))
    }

    fn energy(&self, lane: usize) -> f64 {
        self.energy.lane(lane)
    }

    fn set_increment(&mut self, lane: usize, ends: &[[f64; D]; 2]) {
        let last = self.increments.len() - 1;
        for d in 0..D {
            self.increments[0][d].set_lane(lane, ends[0][d]);
            self.increments[last][d].set_lane(lane, ends[1][d]);
        }
    }

    fn advance(&mut self) {
        let elements = self.frames.len();
        let first = self.increments[0];
        for k in (1..elements).rev() {
            let factor = &self.factors[k - 1];
            let ahead = self.increments[k + 1];
            let sum = add(add(apply(&factor.left, &first), apply(&factor.next, &ahead)), factor.rest);
            self.increments[k] = scale(-T::one(), sum);
        }
        for e in 0..elements {
            let frame = self.frames[e];
            let (last, turn) = B::restrict(&frame, &self.increments[e], &self.increments[e + 1]);
            let mut change = [[T::zero(); D]; P];
            change[P - 1] = last;
            let (blocks, nodes) = (e * Self::INNER_BLOCKS, e * Self::INNER_NODES);
            for i in (0..P - 1).rev() {
                let mut sum = self.inner_rest[nodes + i];
                // Blocks of row i start after those of the rows before it.
                let row = blocks + i * (2 * P - i - 1) / 2;
                for j in i + 1..P {
                    sum = add(sum, apply(&self.inner[row + j - i - 1], &change[j]));
                }
                if self.loaded {
                    sum = add(sum, apply(&self.inner_turn[nodes + i], &turn));
                }
                change[i] = scale(-T::one(), sum);
            }
            let local = self.local_of(e, &frame);
            let stress = self.stress_of(e);
            let moduli = self.moduli[self.segment_of[e]];
            let at = At {
                table: &self.table,
                piece: &self.pieces[e],
                curved: self.curved(e),
                moduli: &moduli,
                local: &local,
                stress: &stress,
            };
            let stress = B::extrapolate(&at, &change);
            for i in 0..P {
                self.state.stress[e * P + i] = stress[i];
                if i < P - 1 {
                    axpy(&mut self.state.local[e * P + i], T::one(), change[i]);
                }
            }
        }
        for k in 1..elements {
            B::advance(&mut self.state.nodes[k], &self.increments[k]);
        }
    }

    fn size(&self, lane: usize) -> Size {
        let mut size = Size::default();
        let length = self.total_length.lane(lane);
        for increment in &self.increments {
            for (d, x) in increment.iter().enumerate() {
                let x = x.lane(lane).abs();
                if d < Self::TRANSLATIONS {
                    size.displacement = larger(size.displacement, x / length);
                } else {
                    size.rotation = larger(size.rotation, x);
                }
            }
        }
        size
    }

    fn set_plain(&mut self, plain: bool) {
        self.plain = plain;
    }

    fn set_pivot_noise(&mut self, noise: f64) {
        self.noise = noise;
    }

    fn restore_shape(&mut self, slot: usize, part: f64) {
        for (stress, saved) in self.state.stress.iter_mut().zip(&self.saved[slot].stress) {
            *stress = add(*saved, scale(T::splat(part), sub(*stress, *saved)));
        }
        self.state.nodes.copy_from_slice(&self.saved[slot].nodes);
        self.state.local.copy_from_slice(&self.saved[slot].local);
    }

    fn distance(&self, lane: usize, slot: usize) -> Size {
        let length = self.total_length.lane(lane);
        self.state.nodes.iter().zip(&self.saved[slot].nodes).fold(Size::default(), |size, (a, b)| {
            let (a, b) = (B::pose(a, lane), B::pose(b, lane));
            let turned = rotation::compose(a.rotation, rotation::inverse(b.rotation));
            size.join(Size {
                rotation: norm(rotation::log(turned)),
                displacement: norm(sub(a.displacement, b.displacement)) / length,
            })
        })
    }

    fn save(&mut self, slot: usize) {
        copy(&self.state, &mut self.saved[slot]);
    }

    fn restore(&mut self, slot: usize) {
        copy(&self.saved[slot], &mut self.state);
    }

    fn swap(&mut self, a: usize, b: usize) {
        self.saved.swap(a, b);
    }

    fn predict(&mut self, before: usize, last: usize, ratio: f64) {
        let (a, b) = (&self.saved[before], &self.saved[last]);
        for (target, (a, b)) in self.state.nodes.iter_mut().zip(a.nodes.iter().zip(&b.nodes)) {
            *target = B::predict(a, b, ratio);
        }
        let ahead = |target: &mut Vec<[T; D]>, a: &[[T; D]], b: &[[T; D]]| {
            for (target, (a, b)) in target.iter_mut().zip(a.iter().zip(b)) {
                *target = add(*b, scale(T::splat(ratio), sub(*b, *a)));
            }
        };
        ahead(&mut self.state.local, &a.local, &b.local);
        ahead(&mut self.state.stress, &a.stress, &b.stress);
    }

    fn lateral(&mut self, lane: usize, stiffness: &[[f64; 6]]) -> (Ends<f64, 3>, usize, f64) {
        let plane: Vec<[f64; 3]> = self.state.nodes.iter().map(|n| B::pose(n, lane)).map(flat).collect();
        let mut negative = 0;
        let mut smallest = 1.0f64;
        let mut chain: Option<Ends<f64, 3>> = None;
        for e in 0..self.frames.len() {
            let segment = self.segment_of[e];
            let next = self.lateral_element(lane, e, &plane, &stiffness[segment], &mut negative, &mut smallest);
            chain = Some(match chain {
                None => next,
                Some(so_far) => {
                    let ldl = Ldl::new(&madd(so_far.k11, next.k00));
                    negative += ldl.negative as usize;
                    smallest = smallest.min(ldl.smallest);
                    let (back, ahead) = (ldl.solve(&transpose(&so_far.k01)), ldl.solve(&next.k01));
                    Ends {
                        k00: sub_matrix(so_far.k00, mul_block(&so_far.k01, &back)),
                        k01: mscale(-1.0, mul_block(&so_far.k01, &ahead)),
                        k11: sub_matrix(next.k11, tmul(&next.k01, &ahead)),
                        ..next
                    }
                }
            });
        }
        let ends = chain.unwrap_or(Ends { k00: zeros(), k01: zeros(), k11: zeros(), r0: [0.0; 3], r1: [0.0; 3] });
        (ends, negative, smallest)
    }

    fn prolong(&mut self, coarse: &dyn Pack<D>) {
        for lane in 0..self.members.len() {
            for index in 0..self.state.nodes.len() {
                B::set_pose(&mut self.state.nodes[index], lane, &coarse.element_end(lane, index));
            }
            for e in 0..self.frames.len() {
                for i in 0..P {
                    let (local, _) = coarse.sample(lane, e, node(i + 1, P));
                    let (_, stress) = coarse.sample(lane, e, self.table.points[i]);
                    for d in 0..D {
                        self.state.local[e * P + i][d].set_lane(lane, local[d]);
                        self.state.stress[e * P + i][d].set_lane(lane, stress[d]);
                    }
                }
            }
        }
    }

    fn lift(&mut self, plane: &dyn Pack<3>) {
        for lane in 0..self.members.len() {
            for index in 0..self.state.nodes.len() {
                B::set_pose(&mut self.state.nodes[index], lane, &plane.element_end(lane, index));
            }
            for e in 0..self.frames.len() {
                for i in 0..P {
                    let (local, _) = plane.sample(lane, e, node(i + 1, P));
                    let (_, stress) = plane.sample(lane, e, self.table.points[i]);
                    let flat = [local[0], local[1], 0.0, 0.0, 0.0, (0.5 * local[2]).tan()];
                    let forces = [stress[0], stress[1], 0.0, 0.0, 0.0, stress[2]];
                    for d in 0..D {
                        self.state.local[e * P + i][d].set_lane(lane, flat[d]);
                        self.state.stress[e * P + i][d].set_lane(lane, forces[d]);
                    }
                }
            }
        }
    }

    fn sample(&self, lane: usize, element: usize, s: f64) -> ([f64; D], [f64; D]) {
        let frame = B::frame(&self.pieces[element], &self.state.nodes[element], &self.state.nodes[element + 1]);
        let local = self.local_of(element, &frame);
        let (values, _) = pennate_elements::interpolation::shapes::<P>(s);
        let mut at = [0.0; D];
        for i in 0..P {
            axpy(&mut at, values[i], self::lane(&local[i], lane));
        }
        // Lagrange interpolation through the Gauss points.
        let mut stress = [0.0; D];
        for g in 0..P {
            let mut weight = 1.0;
            for other in (0..P).filter(|&o| o != g) {
                weight *= (s - self.table.points[other]) / (self.table.points[g] - self.table.points[other]);
            }
            axpy(&mut stress, weight, self::lane(&self.state.stress[element * P + g], lane));
        }
        (at, stress)
    }

    fn element_end(&self, lane: usize, index: usize) -> Placement {
        B::pose(&self.state.nodes[index], lane)
    }

    fn elements(&self) -> usize {
        self.frames.len()
    }

    fn order(&self) -> usize {
        P
    }

    fn length(&self, lane: usize) -> f64 {
        let mut length = 0.0;
        for e in 0..self.frames.len() {
            for (g, strain) in self.strains(e).iter().enumerate() {
                let mut gamma = [1.0 + strain[0].lane(lane), strain[1].lane(lane), 0.0];
                if D == 6 {
                    gamma[2] = strain[2].lane(lane);
                }
                length += self.table.weights[g] * self.pieces[e].length.lane(lane) * norm(gamma);
            }
        }
        length
    }

    fn middle(&self, lane: usize) -> (V3<f64>, V3<f64>) {
        let mut left = 0.5 * self.total_length.lane(lane);
        let mut carried = [0.0; 3];
        for (e, piece) in self.pieces.iter().enumerate() {
            let length = piece.length.lane(lane);
            let here = left.min(length);
            axpy(&mut carried, here, lane_of(&self.loads[self.segment_of[e]], lane));
            if left <= length * (1.0 + 1e-12) || e + 1 == self.pieces.len() {
                let s = (left / length).min(1.0);
                let (local, _) = self.sample(lane, e, s);
                let first = self.element_end(lane, e);
                let place = B::interior(piece, &first, [0.0; 3], local, lane);
                let bend = rotation::exp(scale(s * length, self.initial_curvature(e, lane)));
                let unloaded = tapply(&lanes(&piece.axes, lane), &rotation::turn(bend, [1.0, 0.0, 0.0]));
                return (rotation::turn(place.rotation, unloaded), carried);
            }
            left -= length;
        }
        ([1.0, 0.0, 0.0], carried)
    }

    fn total_load(&self, lane: usize) -> V3<f64> {
        let mut total = [0.0; 3];
        for (piece, &segment) in self.pieces.iter().zip(&self.segment_of) {
            axpy(&mut total, piece.length.lane(lane), lane_of(&self.loads[segment], lane));
        }
        total
    }

    fn shape(&self, lane: usize, origin: V3<f64>, force: V3<f64>, moment: V3<f64>) -> MemberShape {
        let mut shape = MemberShape::default();
        let start = self.element_end(lane, 0);
        let mut first = point(origin, &start, &lanes(&self.pieces[0].axes, lane), &pennate_elements::small::identity());
        shape.points.push(first);
        let mut unloaded = origin;
        let mut load_so_far = [0.0; 3];
        let mut load_moment = [0.0; 3];
        for e in 0..self.frames.len() {
            let segment = self.segment_of[e];
            let axes = lanes(&self.pieces[e].axes, lane);
            let from = self.element_end(lane, e);
            let frame = B::frame(&self.pieces[e], &self.state.nodes[e], &self.state.nodes[e + 1]);
            let local = self.local_of(e, &frame);
            let strains = self.strains(e);
            let length = self.pieces[e].length.lane(lane);
            let load = scale(length / P as f64, self::lane(&self.loads[segment], lane));
            for i in 0..P {
                let reference = self::lane(&self.reference(e, i), lane);
                let placement = if i + 1 == P {
                    self.element_end(lane, e + 1)
                } else {
                    B::interior(&self.pieces[e], &from, reference, self::lane(&local[i], lane), lane)
                };
                let bend = self.curves.get(e).map(|_| self.bend(e, lane, i));
                let at = add(unloaded, tapply(&axes, &reference));
                let next = point(at, &placement, &axes, &bend.unwrap_or(pennate_elements::small::identity()));

                // Statics: what acts on the start and on the part before the middle of the cell.
                let middle = scale(0.5, add(position(&first), position(&next)));
                let here = sub(position(&shape.points[0]), middle);
                let half = scale(0.5, load);
                let quarter = scale(0.5, add(position(&first), middle));
                let total = add(force, add(load_so_far, half));
                let about = add(add(moment, cross(here, force)), moved(load_moment, load_so_far, middle));
                let about = add(about, cross(sub(quarter, middle), half));
                let mean = mean_axes(&first.axes, &next.axes);
                let strain = strains[i.min(P - 1)];
                let kappa =
                    if D == 6 { [strain[4].lane(lane), strain[5].lane(lane)] } else { [0.0, strain[2].lane(lane)] };
                let initial = self.initial_curvature(e, lane);
                let curvature = (kappa[0] + initial[1]).hypot(kappa[1] + initial[2]);
                shape.cells.push(ShapeCell {
                    segment,
                    force: apply(&mean, &scale(-1.0, total)),
                    moment: apply(&mean, &scale(-1.0, about)),
                    strain: strain[0].lane(lane),
                    induced_strain: self.moduli[segment].rest[0].lane(lane),
                    curvature,
                });
                load_moment = add(load_moment, cross(middle, load));
                load_so_far = add(load_so_far, load);
                shape.points.push(next);
                first = next;
            }
            unloaded = add(unloaded, tapply(&axes, &lane_of(&self.pieces[e].chord, lane)));
        }
        shape
    }
}

/// Moment about `place` of forces whose moment about the origin and whose sum are known.
fn moved(about_origin: V3<f64>, sum: V3<f64>, place: V3<f64>) -> V3<f64> {
    sub(about_origin, cross(place, sum))
}

fn lane_of<T: Real>(a: &V3<T>, index: usize) -> V3<f64> {
    lane(a, index)
}

fn position(point: &ShapePoint) -> V3<f64> {
    add(point.reference, point.displacement)
}

fn flat(p: Placement) -> [f64; 3] {
    [p.displacement[0], p.displacement[1], p.angle]
}

/// Rows normalized between those of two neighbouring frames.
fn mean_axes(a: &M3<f64>, b: &M3<f64>) -> M3<f64> {
    let first = add(a[0], b[0]);
    let first = scale(1.0 / norm(first), first);
    let second = add(a[1], b[1]);
    let second = sub(second, scale(pennate_elements::small::dot(first, second), first));
    let second = scale(1.0 / norm(second), second);
    [first, second, cross(first, second)]
}

/// `axes` are the unloaded axes of the element's start by rows, `bend` leads from them to those of the point.
fn point(reference: V3<f64>, placement: &Placement, axes: &M3<f64>, bend: &M3<f64>) -> ShapePoint {
    let unloaded = tmul(bend, axes);
    ShapePoint {
        reference,
        displacement: placement.displacement,
        rotation: rotation::log(placement.rotation),
        axes: unloaded.map(|axis| rotation::turn(placement.rotation, axis)),
    }
}

fn mul_block<T: Real, const D: usize>(a: &[[T; D]; D], b: &[[T; D]; D]) -> [[T; D]; D] {
    pennate_elements::small::mul(a, b)
}

fn copy<Pose: Copy, T: Copy, const D: usize>(from: &ChainState<Pose, T, D>, to: &mut ChainState<Pose, T, D>) {
    to.nodes.copy_from_slice(&from.nodes);
    to.local.copy_from_slice(&from.local);
    to.stress.copy_from_slice(&from.stress);
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    fn strains(&self, e: usize) -> [[T; D]; P] {
        let frame = B::frame(&self.pieces[e], &self.state.nodes[e], &self.state.nodes[e + 1]);
        let local = self.local_of(e, &frame);
        let stress = self.stress_of(e);
        let moduli = self.moduli[self.segment_of[e]];
        B::strains(&At {
            table: &self.table,
            piece: &self.pieces[e],
            curved: self.curved(e),
            moduli: &moduli,
            local: &local,
            stress: &stress,
        })
    }

    /// Rotation vector from the first to the last Gauss frame over their distance: the initial curvature.
    fn initial_curvature(&self, e: usize, lane: usize) -> V3<f64> {
        let Some(curve) = self.curves.get(e) else { return [0.0; 3] };
        let s = self.table.points[0] * self.pieces[e].length.lane(lane);
        let frame = curve.frames[0].map(|row| self::lane(&row, lane));
        let axis = [frame[2][1] - frame[1][2], frame[0][2] - frame[2][0], frame[1][0] - frame[0][1]];
        let sine = 0.5 * norm(axis);
        let cosine = 0.5 * (frame[0][0] + frame[1][1] + frame[2][2] - 1.0);
        if sine == 0.0 { [0.0; 3] } else { scale(sine.atan2(cosine) / (2.0 * sine * s), axis) }
    }

    /// Unloaded axes at node i + 1 of an element in those of its start: the columns.
    fn bend(&self, e: usize, lane: usize, i: usize) -> M3<f64> {
        let s = node(i + 1, P) * self.pieces[e].length.lane(lane);
        rotation::matrix(rotation::exp(scale(s, self.initial_curvature(e, lane))))
    }

    /// Lateral stiffness of one element of a plane chain.
    fn lateral_element(
        &self,
        lane: usize,
        e: usize,
        nodes: &[[f64; 3]],
        stiffness: &[f64; 6],
        negative: &mut usize,
        smallest: &mut f64,
    ) -> Ends<f64, 3> {
        let packed = &self.pieces[e];
        let piece = Piece {
            length: packed.length.lane(lane),
            chord: lane_of(&packed.chord, lane),
            bulge: lane_of(&packed.bulge, lane),
            axes: lanes(&packed.axes, lane),
        };
        let frame = <plane::Plane as Beam<f64, 3>>::frame(&piece, &nodes[e], &nodes[e + 1]);
        let mut local: [[f64; 3]; P] =
            std::array::from_fn(|i| std::array::from_fn(|d| self.state.local[e * P + i][d].lane(lane)));
        local[P - 1] = frame.local;
        let stress: [[f64; 3]; P] =
            std::array::from_fn(|g| std::array::from_fn(|d| self.state.stress[e * P + g][d].lane(lane)));
        let curved: Option<[M3<f64>; P]> = self.curved(e).map(|c| c.map(|m| lanes(&m, lane)));
        let moduli = Moduli { stiffness: [stiffness[0], stiffness[1], stiffness[5]], rest: [0.0; 3], held: [0.0; 3] };
        let at = At {
            table: &self.table,
            piece: &piece,
            curved: curved.as_ref(),
            moduli: &moduli,
            local: &local,
            stress: &stress,
        };
        let mut k = Local::<f64, 3, P>::zero();
        plane::lateral(&at, stiffness, &mut k);
        let mut plane_part = Local::<f64, 3, P>::zero();
        <plane::Plane as Beam<f64, 3>>::local::<P, true>(&at, &mut plane_part);

        // Weight in the plane turns with the frame about axes 1 and 2.
        let mut turn = None;
        let mut coupling = [[[0.0; 3]; 3]; P];
        if self.loaded {
            let load = scale(piece.length, lane_of(&self.loads[self.segment_of[e]], lane));
            let load = <plane::Plane as Beam<f64, 3>>::pull_back(&frame, load);
            let mut arm = scale(1.0 / piece.length, piece.bulge);
            for i in 0..P - 1 {
                let weight = self.table.integrals[i];
                let mut position = lane_of(&self.reference(e, i), lane);
                position[0] += local[i][0];
                position[1] += local[i][1];
                axpy(&mut arm, weight, position);
                // Row U₃ of the spatial coupling: columns of the spins about axes 1 and 2.
                coupling[i][0] = [weight * load[1], -weight * load[0], 0.0];
            }
            turn = Some(mscale(-1.0, rotation::second_variation(load, arm)));
        }
        for i in 0..P - 1 {
            let ldl = Ldl::new(&k.tangent[i][i]);
            *negative += ldl.negative as usize;
            *smallest = smallest.min(ldl.smallest);
            if let Some(turn) = &mut turn {
                let solved = ldl.solve(&coupling[i]);
                *turn = sub_matrix(*turn, tmul(&coupling[i], &solved));
                for j in i + 1..P {
                    coupling[j] = sub_matrix(coupling[j], tmul(&k.tangent[i][j], &solved));
                }
            }
            for j in i + 1..P {
                let solved = ldl.solve(&k.tangent[i][j]);
                for l in i + 1..=j {
                    k.tangent[l][j] = sub_matrix(k.tangent[l][j], tmul(&k.tangent[i][l], &solved));
                }
            }
        }
        plane::expand_lateral(
            &frame,
            &k.tangent[P - 1][P - 1],
            plane_part.mixed_end,
            turn.as_ref(),
            Some(&coupling[P - 1]),
        )
    }
}
