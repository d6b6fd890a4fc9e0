//! The state of a chain taken over by one of another order, or by a spatial one.

use std::any::Any;

use pennate_elements::beam::{Beam, Piece};
use pennate_elements::interpolation::node;
use pennate_elements::real::{Real, Work};
use pennate_elements::small::axpy;

use crate::element::{node_weights, place, point_weights, sample};
use crate::{Chain, MOST_NODES, Pack};

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
    weights: [[[f64; MOST_NODES]; P]; 2],
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
            B::set_pose(&mut self.state.nodes[index], lane, &source.node(from, index));
        }
        for e in 0..self.frames.len() {
            let (local, stress) = (source.local(from, e), source.stress(from, e));
            for i in 0..P {
                for d in 0..D {
                    self.state.local[e * P + i][d].set_lane(lane, local[i][d]);
                    self.state.stress[e * P + i][d].set_lane(lane, stress[i][d]);
                }
            }
        }
    }

    pub(super) fn in_lanes_impl(&self) -> InLanes<'_> {
        InLanes { nodes: &self.state.nodes, local: &self.state.local, stress: &self.state.stress }
    }

    /// Weights of the nodes and of the Gauss points of another order, at every node and point of this one.
    fn weights_of(&self, order: usize, points: &[f64]) -> [[[f64; MOST_NODES]; P]; 2] {
        let mut weights = [[[0.0; MOST_NODES]; P]; 2];
        for i in 0..P {
            weights[0][i] = node_weights(order, node(i + 1, P));
            weights[1][i] = point_weights(points, self.table.points[i]);
        }
        weights
    }

    /// Takes over the state of a member of the same elements and another order.
    fn enrich(&mut self, lane: usize, coarse: &dyn Pack<D>, from: usize) {
        for index in 0..self.state.nodes.len() {
            B::set_pose(&mut self.state.nodes[index], lane, &coarse.node(from, index));
        }
        let order = coarse.mesh().order;
        let [at_nodes, at_points] = self.weights_of(order, coarse.mesh().points());
        for e in 0..self.frames.len() {
            let (unknowns, stresses) = (coarse.local(from, e), coarse.stress(from, e));
            for i in 0..P {
                let (mut local, mut stress) = ([0.0; D], [0.0; D]);
                for k in 0..order {
                    axpy(&mut local, at_nodes[i][k], unknowns[k]);
                    axpy(&mut stress, at_points[i][k], stresses[k]);
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
                B::set_pose(&mut self.state.nodes[node], lane, &place(coarse, from, e, s));
            }
            for i in 0..P {
                let (e, s) = at(node(i + 1, P));
                B::set_pose(&mut poses[element * P + i], lane, &place(coarse, from, e, s));
                let (e, s) = at(points[i]);
                let (_, stress) = sample(coarse, from, e, s);
                for d in 0..D {
                    self.state.stress[element * P + i][d].set_lane(lane, stress[d]);
                }
            }
        }
    }

    pub(super) fn lift_impl(&mut self, plane: &dyn Pack<3>) {
        for lane in 0..self.mesh.members.len() {
            for index in 0..self.state.nodes.len() {
                B::set_pose(&mut self.state.nodes[index], lane, &plane.node(lane, index));
            }
            for e in 0..self.frames.len() {
                for i in 0..P {
                    let (local, _) = sample(plane, lane, e, node(i + 1, P));
                    let (_, stress) = sample(plane, lane, e, self.table.points[i]);
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
}
