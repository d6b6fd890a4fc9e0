//! The state of a chain taken over by one of another order, or by a spatial one.

use std::any::Any;

use pennate_elements::beam::{Beam, Piece, Placement};
use pennate_elements::interpolation::node;
use pennate_elements::real::{Real, Work};
use pennate_elements::small::{V3, axpy, scale};

use crate::lanes;
use crate::{Bent, Chain, MOST_NODES as MOST, Pack};

/// Local unknowns of the nodes of an element and mixed stresses at its Gauss points; what its order does not have is zero.
#[derive(Clone, Copy, Debug)]
pub struct Field<const D: usize> {
    local: [[f64; D]; MOST],
    stress: [[f64; D]; MOST],
}

/// The state of a pack as it lies in the lanes: nodes, local unknowns and stresses are vectors of the kinds that its own
/// chain has.
pub struct InLanes<'a> {
    pub nodes: &'a dyn Any,
    pub local: &'a dyn Any,
    pub stress: &'a dyn Any,
}

/// The state of members of the same elements and another order, as work in lanes.
struct Enrich<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize> {
    chain: &'a mut Chain<T, B, D, P>,
    order: usize,
    nodes: &'a [B::Pose],
    local: &'a [[T; D]],
    stress: &'a [[T; D]],
    /// Weights of the nodes and of the Gauss points of the other order, at every node and point of this one.
    weights: [[[f64; MOST]; P]; 2],
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Enrich<'_, T, B, D, P> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { chain, order, nodes, local, stress, weights: [at_nodes, at_points] } = self;
        chain.state.nodes.copy_from_slice(nodes);
        for (e, piece) in chain.pieces.iter().enumerate() {
            let last = B::last_local(&B::frame(piece, &nodes[e], &nodes[e + 1]));
            for i in 0..P {
                let (mut x, mut s) = ([T::zero(); D], [T::zero(); D]);
                for k in 0..order {
                    let unknowns = if k + 1 == order { &last } else { &local[e * order + k] };
                    for d in 0..D {
                        x[d] = x[d].plus(T::splat(at_nodes[i][k]), unknowns[d]);
                        s[d] = s[d].plus(T::splat(at_points[i][k]), stress[e * order + k][d]);
                    }
                }
                chain.state.local[e * P + i] = x;
                chain.state.stress[e * P + i] = s;
            }
        }
    }
}

/// Local unknowns that belong to the places of the nodes within the elements, as work in lanes.
struct Locals<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize>(&'a Chain<T, B, D, P>, &'a [B::Pose]);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Locals<'_, T, B, D, P> {
    type Output = Vec<[T; D]>;

    #[inline(always)]
    fn run(self) -> Vec<[T; D]> {
        let Self(chain, poses) = self;
        let mut local = Vec::with_capacity(poses.len());
        for (e, piece) in chain.pieces.iter().enumerate() {
            for i in 0..P {
                let piece = Piece { chord: chain.reference(e, i), ..*piece };
                local.push(B::last_local(&B::frame(&piece, &chain.state.nodes[e], &poses[e * P + i])));
            }
        }
        local
    }
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    pub(super) fn prolong_impl(&mut self, sources: &[(&dyn Pack<D>, usize)]) {
        if self.enrich_in_lanes(sources) {
            return;
        }
        let mut divided = Vec::new();
        let mut poses = Vec::new();
        for (lane, &(coarse, from)) in sources.iter().enumerate() {
            if self.mesh.is_divided_like(lane, coarse.mesh(), from) {
                self.enrich(lane, coarse, from);
            } else {
                poses.resize(self.state.local.len(), B::Pose::default());
                self.divide(lane, coarse, from, &mut poses);
                divided.push(lane);
            }
        }
        if divided.is_empty() {
            return;
        }
        let local = T::run(Locals(self, &poses));
        for (own, placed) in self.state.local.iter_mut().zip(&local) {
            for d in 0..D {
                for &lane in &divided {
                    own[d].set_lane(lane, placed[d].lane(lane));
                }
            }
        }
    }

    /// Takes over the state of a pack of the same members and elements that lie in the same lanes; false for any other.
    fn enrich_in_lanes(&mut self, sources: &[(&dyn Pack<D>, usize)]) -> bool {
        let coarse = sources[0].0;
        let alike = |(lane, &(_, from)): (usize, &(&dyn Pack<D>, usize))| {
            lane == from && self.mesh.is_divided_like(lane, coarse.mesh(), from)
        };
        if coarse.mesh().members != self.mesh.members || !sources.iter().enumerate().all(alike) {
            return false;
        }
        let InLanes { nodes, local, stress } = coarse.in_lanes();
        let kinds = nodes
            .downcast_ref::<Vec<B::Pose>>()
            .zip(local.downcast_ref::<Vec<[T; D]>>())
            .zip(stress.downcast_ref::<Vec<[T; D]>>());
        let Some(((nodes, local), stress)) = kinds else { return false };
        let order = coarse.mesh().order;
        let weights = self.weights_of(order, coarse.mesh().points());
        T::run(Enrich { chain: self, order, nodes, local, stress, weights });
        true
    }

    pub(super) fn adopt_impl(&mut self, lane: usize, source: &dyn Pack<D>, from: usize) {
        debug_assert_eq!((self.frames.len(), P), (source.mesh().elements(), source.mesh().order));
        for index in 0..self.state.nodes.len() {
            B::set_pose(&mut self.state.nodes[index], lane, &source.element_end(from, index));
        }
        for e in 0..self.frames.len() {
            let field = source.field(from, e);
            for i in 0..P {
                for d in 0..D {
                    self.state.local[e * P + i][d].set_lane(lane, field.local[i][d]);
                    self.state.stress[e * P + i][d].set_lane(lane, field.stress[i][d]);
                }
            }
        }
    }

    pub(super) fn in_lanes_impl(&self) -> InLanes<'_> {
        InLanes { nodes: &self.state.nodes, local: &self.state.local, stress: &self.state.stress }
    }

    /// Weights of the nodes and of the Gauss points of another order, at every node and point of this one.
    fn weights_of(&self, order: usize, points: &[f64]) -> [[[f64; MOST]; P]; 2] {
        let mut weights = [[[0.0; MOST]; P]; 2];
        for i in 0..P {
            weights[0][i] = node_weights(order, node(i + 1, P));
            weights[1][i] = point_weights(points, self.table.points[i]);
        }
        weights
    }

    /// Takes over the state of a member of the same elements and another order.
    fn enrich(&mut self, lane: usize, coarse: &dyn Pack<D>, from: usize) {
        for index in 0..self.state.nodes.len() {
            B::set_pose(&mut self.state.nodes[index], lane, &coarse.element_end(from, index));
        }
        let order = coarse.mesh().order;
        let [at_nodes, at_points] = self.weights_of(order, coarse.mesh().points());
        for e in 0..self.frames.len() {
            let field = coarse.field(from, e);
            for i in 0..P {
                let (mut local, mut stress) = ([0.0; D], [0.0; D]);
                for k in 0..order {
                    axpy(&mut local, at_nodes[i][k], field.local[k]);
                    axpy(&mut stress, at_points[i][k], field.stress[k]);
                }
                for d in 0..D {
                    self.state.local[e * P + i][d].set_lane(lane, local[d]);
                    self.state.stress[e * P + i][d].set_lane(lane, stress[d]);
                }
            }
        }
    }

    /// Takes over the state of a member divided into other elements, but for the local unknowns, whose places are left
    /// in `poses`.
    fn divide(&mut self, lane: usize, coarse: &dyn Pack<D>, from: usize, poses: &mut [B::Pose]) {
        let (own, others) = (self.mesh.spans(lane), coarse.mesh().spans(from));
        // Element of the coarse member, and the place in it.
        let locate = |x: f64| {
            let e = others[1..others.len() - 1].partition_point(|&end| end <= x);
            (e, ((x - others[e]) / (others[e + 1] - others[e])).clamp(0.0, 1.0))
        };
        let points = self.table.points;
        for element in 0..self.frames.len() {
            let [start, end] = [own[element], own[element + 1]];
            let at = |x: f64| locate(start + x * (end - start));
            for (node, x) in [(element, 0.0), (element + 1, 1.0)] {
                let (e, s) = at(x);
                B::set_pose(&mut self.state.nodes[node], lane, &coarse.place(from, e, s));
            }
            for i in 0..P {
                let (e, s) = at(node(i + 1, P));
                B::set_pose(&mut poses[element * P + i], lane, &coarse.place(from, e, s));
                let (e, s) = at(points[i]);
                let (_, stress) = coarse.sample(from, e, s);
                for d in 0..D {
                    self.state.stress[element * P + i][d].set_lane(lane, stress[d]);
                }
            }
        }
    }

    pub(super) fn place_impl(&self, lane: usize, element: usize, s: f64) -> Placement {
        let (local, _) = self.sample_impl(lane, element, s);
        let reference = self.unloaded(lane, element, s);
        B::interior(&self.pieces[element], &self.element_end(lane, element), reference, local, lane)
    }

    /// Unloaded position at a unit coordinate of an element, in its own axes.
    pub(super) fn unloaded(&self, lane: usize, element: usize, s: f64) -> V3<f64> {
        let piece = &self.pieces[element];
        if self.curves.is_empty() {
            return scale(s, lanes::lane(&piece.chord, lane));
        }
        let bent = Bent { length: piece.length.lane(lane), curvature: self.initial_curvature(element, lane) };
        bent.position(s * bent.length)
    }

    pub(super) fn lift_impl(&mut self, plane: &dyn Pack<3>) {
        for lane in 0..self.mesh.members.len() {
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

    pub(super) fn sample_impl(&self, lane: usize, element: usize, s: f64) -> ([f64; D], [f64; D]) {
        let field = self.field_impl(lane, element);
        let (at_nodes, at_points) = (node_weights(P, s), point_weights(&self.table.points, s));
        let (mut local, mut stress) = ([0.0; D], [0.0; D]);
        for k in 0..P {
            axpy(&mut local, at_nodes[k], field.local[k]);
            axpy(&mut stress, at_points[k], field.stress[k]);
        }
        (local, stress)
    }

    pub(super) fn field_impl(&self, lane: usize, element: usize) -> Field<D> {
        let unknowns = self.local_unknowns(element);
        let (mut local, mut stress) = ([[0.0; D]; MOST], [[0.0; D]; MOST]);
        for k in 0..P {
            local[k] = lanes::lane(&unknowns[k], lane);
            stress[k] = lanes::lane(&self.state.stress[element * P + k], lane);
        }
        Field { local, stress }
    }
}

/// Values at `s` of the shape functions of nodes 1 to `order`.
fn node_weights(order: usize, s: f64) -> [f64; MOST] {
    let mut weights = [0.0; MOST];
    for i in 1..=order {
        let others = (0..=order).filter(|&j| j != i);
        weights[i - 1] = others.map(|j| (s - node(j, order)) / (node(i, order) - node(j, order))).product();
    }
    weights
}

/// Values at `s` of the polynomials that are one at one of the points and zero at the others.
fn point_weights(points: &[f64], s: f64) -> [f64; MOST] {
    let mut weights = [0.0; MOST];
    for (g, point) in points.iter().enumerate() {
        let others = points.iter().filter(|other| *other != point);
        weights[g] = others.map(|other| (s - other) / (point - other)).product();
    }
    weights
}
