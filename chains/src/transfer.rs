//! The state of members taken over from other packs: of other meshes, of another order, from the plane into space.

use pennate_elements::beam::{Beam, Placement};
use pennate_elements::interpolation::node;
use pennate_elements::real::{Real, Work};
use pennate_elements::small::axpy;

use crate::element::{at_nodes, at_points, node_weights, place, point_weights, sample};
use crate::lanes::lane;
use crate::state::Saved;
use crate::{Chain, MOST_NODES, Pack, PackMesh};

/// State of an element that it is to have.
#[derive(Clone, Copy, Debug)]
pub struct NewState<'a, const D: usize> {
    /// Where its ends are.
    pub ends: [Placement; 2],
    /// Where nodes 1…P are.
    pub nodes: NewNodes<'a, D>,
    /// Mixed stresses at the Gauss points.
    pub stress: [[f64; D]; MOST_NODES],
}

/// Where nodes 1…P of an element are.
#[derive(Clone, Copy, Debug)]
pub enum NewNodes<'a, const D: usize> {
    /// By their local unknowns.
    Local(&'a [[f64; D]; MOST_NODES]),
    /// By their places.
    Placed(&'a [Placement; MOST_NODES]),
}

/// Takes over the states of the same members on elements of other lengths, order or formulation: for every member of a pack
/// another pack and the lane there.
pub fn prolong<const D: usize>(pack: &mut dyn Pack<D>, sources: &[(&dyn Pack<D>, usize)]) {
    if let Some(&(source, _)) = sources.first().filter(|(source, _)| lie_alike(pack.mesh(), source.mesh(), sources)) {
        let mut row = Vec::new();
        source.save(&mut row);
        pack.enrich(&row, source.mesh());
        return;
    }
    for (lane, &(source, from)) in sources.iter().enumerate() {
        if pack.mesh().is_divided_like(lane, source.mesh(), from) {
            enrich(pack, lane, source, from);
        } else {
            divide(pack, lane, source, from);
        }
    }
}

/// Whether these are the same members in the same lanes of one other pack, on the same elements of any order.
fn lie_alike<const D: usize>(own: &PackMesh, other: &PackMesh, sources: &[(&dyn Pack<D>, usize)]) -> bool {
    let alike =
        |(lane, &(_, from)): (usize, &(&dyn Pack<D>, usize))| lane == from && own.is_divided_like(lane, other, from);
    own.lanes == other.lanes && own.members == other.members && sources.iter().enumerate().all(alike)
}

/// Takes over the state of a member with as many elements of the same order and formulation, number by number: its geometry may be
/// another.
pub fn adopt<const D: usize>(pack: &mut dyn Pack<D>, lane: usize, source: &dyn Pack<D>, from: usize) {
    let (own, other) = (pack.mesh(), source.mesh());
    debug_assert_eq!((own.elements(), own.order), (other.elements(), other.order));
    for e in 0..pack.mesh().elements() {
        let ends = [source.node(from, e), source.node(from, e + 1)];
        let nodes = NewNodes::Local(&source.local(from, e));
        pack.set_element(lane, e, &NewState { ends, nodes, stress: source.stress(from, e) });
    }
}

/// Copies the state of plane members with the same elements into spatial ones.
pub fn lift(space: &mut dyn Pack<6>, plane: &dyn Pack<3>) {
    let (order, points) = (space.mesh().order, space.mesh().points().to_vec());
    for lane in 0..space.mesh().members.len() {
        for e in 0..space.mesh().elements() {
            let ends = [plane.node(lane, e), plane.node(lane, e + 1)];
            let (local, stress) = (plane.local(lane, e), plane.stress(lane, e));
            let (mut unknowns, mut forces) = ([[0.0; 6]; MOST_NODES], [[0.0; 6]; MOST_NODES]);
            // Both are seen from the mean of the ends.
            let half = 0.5 * local[plane.mesh().order - 1][2];
            for i in 0..order {
                let [x, y, angle] = at_nodes(plane.mesh(), &local, node(i + 1, order));
                unknowns[i] = [x, y, 0.0, 0.0, 0.0, (0.5 * (angle - half)).tan() + (0.5 * half).tan()];
                let [axial, shear, moment] = at_points(plane.mesh(), &stress, points[i]);
                forces[i] = [axial, shear, 0.0, 0.0, 0.0, moment];
            }
            space.set_element(lane, e, &NewState { ends, nodes: NewNodes::Local(&unknowns), stress: forces });
        }
    }
}

/// Weights of the nodes and of the Gauss points of another order, at every node and point of an order.
fn weights(own: &PackMesh, other: &PackMesh) -> [[[f64; MOST_NODES]; MOST_NODES]; 2] {
    let mut weights = [[[0.0; MOST_NODES]; MOST_NODES]; 2];
    for (i, &point) in own.points().iter().enumerate() {
        weights[0][i] = node_weights(other.order, node(i + 1, own.order));
        weights[1][i] = point_weights(other.points(), point);
    }
    weights
}

/// Takes over the state of a member of the same elements and another order.
fn enrich<const D: usize>(pack: &mut dyn Pack<D>, lane: usize, coarse: &dyn Pack<D>, from: usize) {
    let (elements, order) = (pack.mesh().elements(), pack.mesh().order);
    let [at_nodes, at_points] = weights(pack.mesh(), coarse.mesh());
    for e in 0..elements {
        let (unknowns, stresses) = (coarse.local(from, e), coarse.stress(from, e));
        let (mut local, mut stress) = ([[0.0; D]; MOST_NODES], [[0.0; D]; MOST_NODES]);
        for i in 0..order {
            for k in 0..coarse.mesh().order {
                axpy(&mut local[i], at_nodes[i][k], unknowns[k]);
                axpy(&mut stress[i], at_points[i][k], stresses[k]);
            }
        }
        let ends = [coarse.node(from, e), coarse.node(from, e + 1)];
        pack.set_element(lane, e, &NewState { ends, nodes: NewNodes::Local(&local), stress });
    }
}

/// Takes over the state of a member divided into other elements.
fn divide<const D: usize>(pack: &mut dyn Pack<D>, lane: usize, coarse: &dyn Pack<D>, from: usize) {
    let (own, others) = (pack.mesh().spans(lane), coarse.mesh().spans(from));
    // Element of the coarse member, and the place in it.
    let locate = |x: f64| {
        let e = others[1..others.len() - 1].partition_point(|&end| end <= x);
        (e, ((x - others[e]) / (others[e + 1] - others[e])).clamp(0.0, 1.0))
    };
    let (elements, order, points) = (pack.mesh().elements(), pack.mesh().order, pack.mesh().points().to_vec());
    // At a unit coordinate of an element.
    let at = |element: usize, x: f64| locate(own[element] + x * (own[element + 1] - own[element]));
    let placed = |element: usize, x: f64| {
        let (e, s) = at(element, x);
        place(coarse, from, e, s)
    };
    let mut first = placed(0, 0.0);
    for element in 0..elements {
        let last = if element + 1 < elements { placed(element + 1, 0.0) } else { placed(element, 1.0) };
        let (mut nodes, mut stress) = ([Placement::default(); MOST_NODES], [[0.0; D]; MOST_NODES]);
        for i in 0..order {
            nodes[i] = placed(element, node(i + 1, order));
            let (e, s) = at(element, points[i]);
            (_, stress[i]) = sample(coarse, from, e, s);
        }
        let nodes = NewNodes::Placed(&nodes);
        pack.set_element(lane, element, &NewState { ends: [first, last], nodes, stress });
        first = last;
    }
}

/// The state of members of the same elements and another order, as work in lanes.
struct Enrich<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize> {
    chain: &'a mut Chain<T, B, D, P>,
    order: usize,
    saved: Saved<'a>,
    /// Weights of the nodes and of the Gauss points of the other order, at every node and point of this one.
    weights: [[[f64; MOST_NODES]; MOST_NODES]; 2],
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Enrich<'_, T, B, D, P> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { chain, order, saved, weights: [at_nodes, at_points] } = self;
        for (index, node) in chain.state.nodes.iter_mut().enumerate() {
            *node = saved.node::<T, B, D>(index);
        }
        for e in 0..chain.frames.len() {
            let piece = chain.piece(e);
            let last = B::last_local(&B::frame(piece, &chain.state.nodes[e], &chain.state.nodes[e + 1]));
            for i in 0..P {
                let (mut x, mut s) = ([T::zero(); D], [T::zero(); D]);
                for k in 0..order {
                    let unknowns = if k + 1 == order { last } else { saved.local(e * order + k) };
                    let stress: [T; D] = saved.stress(e * order + k);
                    for d in 0..D {
                        x[d] = x[d].plus(T::splat(at_nodes[i][k]), unknowns[d]);
                        s[d] = s[d].plus(T::splat(at_points[i][k]), stress[d]);
                    }
                }
                chain.state.local[e * P + i] = x;
                chain.state.stress[e * P + i] = s;
            }
        }
    }
}

/// Local unknowns that belong to the places of the nodes of an element, as work in lanes.
struct Locals<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize> {
    chain: &'a Chain<T, B, D, P>,
    element: usize,
    first: B::Pose,
    nodes: [B::Pose; P],
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Locals<'_, T, B, D, P> {
    type Output = [[T; D]; P];

    #[inline(always)]
    fn run(self) -> [[T; D]; P] {
        let Self { chain, element, first, nodes } = self;
        let mut local = [[T::zero(); D]; P];
        for i in 0..P {
            local[i] =
                B::local_at(chain.piece(element), [&first, &nodes[P - 1]], &nodes[i], chain.reference(element, i));
        }
        local
    }
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    pub(super) fn enrich_impl(&mut self, row: &[f64], from: &PackMesh) {
        let (saved, weights) = (self.saved_on(row, from.order), weights(&self.mesh, from));
        T::run(Enrich { chain: self, order: from.order, saved, weights });
    }

    pub(super) fn set_element_impl(&mut self, index: usize, element: usize, state: &NewState<'_, D>) {
        for (node, end) in self.state.nodes[element..element + 2].iter_mut().zip(&state.ends) {
            B::set_pose(node, index, end);
        }
        let local = match state.nodes {
            NewNodes::Local(local) => *local,
            NewNodes::Placed(places) => self.local_of_places(index, element, places),
        };
        for i in 0..P {
            let at = element * P + i;
            for d in 0..D {
                self.state.local[at][d].set_lane(index, local[i][d]);
                self.state.stress[at][d].set_lane(index, state.stress[i][d]);
            }
        }
    }

    /// Local unknowns of the nodes of an element at these places, seen from where it begins.
    fn local_of_places(
        &self,
        index: usize,
        element: usize,
        places: &[Placement; MOST_NODES],
    ) -> [[f64; D]; MOST_NODES] {
        let mut nodes = [B::Pose::default(); P];
        for (node, place) in nodes.iter_mut().zip(places) {
            B::set_pose(node, index, place);
        }
        let found = T::run(Locals { chain: self, element, first: self.state.nodes[element], nodes });
        let mut local = [[0.0; D]; MOST_NODES];
        for (local, found) in local.iter_mut().zip(&found) {
            *local = lane(found, index);
        }
        local
    }
}
