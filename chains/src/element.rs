//! One element of a chain with all that it is evaluated at, out of the lanes.

use pennate_elements::beam::{Beam, Moduli, Piece, Placement, interior};
use pennate_elements::interpolation::node;
use pennate_elements::laws::{Formulation, LocalLaw, WithLaw};
use pennate_elements::real::Real;
use pennate_elements::rotation;
use pennate_elements::small::{M3, V3, add, axpy, dot, identity, norm, scale, zeros};

use crate::lanes::{lane, lane_of, lanes, of_element};
use crate::strains::{LocalUnknowns, Strains};
use crate::{Bent, Chain, MOST_NODES, Pack, PackMesh};

/// Geometry, section and state of one element of one member.
#[derive(Clone, Debug)]
pub struct ElementState<const D: usize> {
    /// Kind of the element.
    pub formulation: Formulation,
    /// Unloaded geometry.
    pub piece: Piece<f64>,
    /// Initial curvature in the axes of the element's start.
    pub curvature: V3<f64>,
    /// Index of its segment in the member.
    pub segment: usize,
    /// Displacements and rotations of its ends.
    pub ends: [Placement; 2],
    /// Local unknowns and unloaded local positions of nodes 1…P.
    pub local: Vec<[f64; D]>,
    /// Unloaded places of its nodes.
    pub reference: Vec<V3<f64>>,
    /// Gauss frames of an initially curved element.
    pub curved: Option<Vec<M3<f64>>>,
    /// Mixed stresses at the Gauss points.
    pub stress: Vec<[f64; D]>,
    /// Stiffness and induced strains of the section.
    pub moduli: Moduli<f64, D>,
    /// Dead force per unloaded length, in global axes.
    pub load: V3<f64>,
}

/// Section of a segment, and the load along it.
#[derive(Clone, Copy, Debug)]
pub struct SegmentState<const D: usize> {
    /// Stiffness and induced strains.
    pub moduli: Moduli<f64, D>,
    /// Dead force per unloaded length, in global axes.
    pub load: V3<f64>,
}

impl<const D: usize> SegmentState<D> {
    /// Those of all segments of a member.
    pub(crate) fn all(pack: &dyn Pack<D>, lane: usize) -> Vec<Self> {
        (0..pack.mesh().segments()).map(|segment| pack.segment(lane, segment)).collect()
    }

    /// Stiffness against a strain, infinite for one that is held.
    pub fn stiffness(&self, component: usize) -> f64 {
        self.moduli.stiffness[component] / (1.0 - self.moduli.held[component])
    }
}

impl ElementState<6> {
    /// Stiffness in this state: where it depends on the state, that is seen as fixed.
    pub fn stiffness(&self) -> [f64; 6] {
        self.formulation.apply(Stiffness(self))
    }
}

/// The stiffness of an element that one law has.
struct Stiffness<'a>(&'a ElementState<6>);

impl WithLaw for Stiffness<'_> {
    type Output = [f64; 6];

    fn with<L: LocalLaw>(self) -> [f64; 6] {
        let Self(state) = self;
        let [x, y, z, ..] = state.local[0];
        let chord = scale(1.0 / state.piece.length, add(state.piece.chord, [x, y, z]));
        L::stiffness(&state.moduli, dot(chord, chord))
    }
}

/// Unloaded geometry of an element.
#[derive(Clone, Copy, Debug)]
pub struct Unloaded {
    /// Length, axes and chord.
    pub piece: Piece<f64>,
    /// Local positions of nodes 1…P.
    pub nodes: [V3<f64>; MOST_NODES],
    /// Material axes at the Gauss points in those of the start, the columns; none where no member of the pack is curved.
    pub frames: Option<[M3<f64>; MOST_NODES]>,
    /// Initial curvature in the axes of the start.
    pub curvature: V3<f64>,
}

impl Unloaded {
    /// Position at a unit coordinate, in the axes of the start.
    pub fn position(&self, s: f64) -> V3<f64> {
        if self.frames.is_none() {
            return scale(s, self.piece.chord);
        }
        let bent = Bent { length: self.piece.length, curvature: self.curvature };
        bent.position(s * bent.length)
    }

    /// Axes at a unit coordinate in those of the start: the columns.
    pub fn bend(&self, s: f64) -> M3<f64> {
        match self.frames {
            Some(_) => rotation::matrix(rotation::exp(scale(s * self.piece.length, self.curvature))),
            None => identity(),
        }
    }
}

/// Initial curvature of an element by its axes at a distance `s` from the start.
fn curvature(frame: &M3<f64>, s: f64) -> V3<f64> {
    let axis = [frame[2][1] - frame[1][2], frame[0][2] - frame[2][0], frame[1][0] - frame[0][1]];
    let sine = 0.5 * norm(axis);
    let cosine = 0.5 * (frame[0][0] + frame[1][1] + frame[2][2] - 1.0);
    if sine == 0.0 { [0.0; 3] } else { scale(sine.atan2(cosine) / (2.0 * sine * s), axis) }
}

/// An element with all that it is evaluated at.
pub fn element<const D: usize>(pack: &dyn Pack<D>, lane: usize, index: usize) -> ElementState<D> {
    let mesh = pack.mesh();
    let (segment, order) = (mesh.segment_of(index), mesh.order);
    let Unloaded { piece, nodes, frames, curvature } = pack.unloaded(lane, index);
    let SegmentState { moduli, load } = pack.segment(lane, segment);
    ElementState {
        formulation: mesh.formulation,
        piece,
        curvature,
        segment,
        ends: [pack.node(lane, index), pack.node(lane, index + 1)],
        local: pack.local(lane, index)[..order].to_vec(),
        reference: nodes[..order].to_vec(),
        curved: frames.map(|frames| frames[..order].to_vec()),
        stress: pack.stress(lane, index)[..order].to_vec(),
        moduli,
        load,
    }
}

/// Where a member is at a unit coordinate of one of its elements.
pub fn place<const D: usize>(pack: &dyn Pack<D>, lane: usize, index: usize, s: f64) -> Placement {
    let (nodes, unloaded) = (pack.local(lane, index), pack.unloaded(lane, index));
    let local = at_nodes(pack.mesh(), &nodes, s);
    let last = &nodes[pack.mesh().order - 1];
    interior(&unloaded.piece, &pack.node(lane, index), last, unloaded.position(s), &local)
}

/// Interior state of an element at a unit coordinate: local unknowns, and mixed stress (extrapolated from the Gauss points).
pub fn sample<const D: usize>(pack: &dyn Pack<D>, lane: usize, index: usize, s: f64) -> ([f64; D], [f64; D]) {
    let mesh = pack.mesh();
    (at_nodes(mesh, &pack.local(lane, index), s), at_points(mesh, &pack.stress(lane, index), s))
}

/// What is known at the nodes of an element, at a unit coordinate.
pub(crate) fn at_nodes<const D: usize>(mesh: &PackMesh, values: &[[f64; D]; MOST_NODES], s: f64) -> [f64; D] {
    sum(mesh.order, &node_weights(mesh.order, s), values)
}

/// What is known at the Gauss points of an element, at a unit coordinate.
pub(crate) fn at_points<const D: usize>(mesh: &PackMesh, values: &[[f64; D]; MOST_NODES], s: f64) -> [f64; D] {
    sum(mesh.order, &point_weights(mesh.points(), s), values)
}

fn sum<const D: usize>(order: usize, weights: &[f64; MOST_NODES], values: &[[f64; D]; MOST_NODES]) -> [f64; D] {
    let mut sum = [0.0; D];
    for (weight, value) in weights.iter().zip(values).take(order) {
        axpy(&mut sum, *weight, *value);
    }
    sum
}

/// Values at `s` of the shape functions of nodes 1 to `order`.
pub(crate) fn node_weights(order: usize, s: f64) -> [f64; MOST_NODES] {
    let mut weights = [0.0; MOST_NODES];
    for i in 1..=order {
        let others = (0..=order).filter(|&j| j != i);
        weights[i - 1] = others.map(|j| (s - node(j, order)) / (node(i, order) - node(j, order))).product();
    }
    weights
}

/// Values at `s` of the polynomials that are one at one of the points and zero at the others.
pub(crate) fn point_weights(points: &[f64], s: f64) -> [f64; MOST_NODES] {
    let mut weights = [0.0; MOST_NODES];
    for (g, point) in points.iter().enumerate() {
        let others = points.iter().filter(|other| *other != point);
        weights[g] = others.map(|other| (s - other) / (point - other)).product();
    }
    weights
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    pub(super) fn unloaded_impl(&self, lane: usize, e: usize) -> Unloaded {
        let packed = self.piece(e);
        let mut unloaded = Unloaded {
            piece: Piece {
                length: packed.length.lane(lane),
                axes: lanes(&packed.axes, lane),
                chord: lane_of(&packed.chord, lane),
                bulge: lane_of(&packed.bulge, lane),
            },
            nodes: [[0.0; 3]; MOST_NODES],
            frames: None,
            curvature: [0.0; 3],
        };
        for i in 0..P {
            unloaded.nodes[i] = lane_of(&self.reference(e, i), lane);
        }
        if let Some(curve) = self.curves.get(e) {
            let mut frames = [zeros(); MOST_NODES];
            for g in 0..P {
                frames[g] = lanes(&curve.frames[g], lane);
            }
            unloaded.curvature = curvature(&frames[0], self.table.points[0] * unloaded.piece.length);
            unloaded.frames = Some(frames);
        }
        unloaded
    }

    pub(super) fn segment_impl(&self, index: usize, segment: usize) -> SegmentState<D> {
        let moduli = &self.moduli[segment];
        SegmentState {
            moduli: Moduli {
                stiffness: lane(&moduli.stiffness, index),
                rest: lane(&moduli.rest, index),
                held: lane(&moduli.held, index),
                softening: lane(&moduli.softening, index),
            },
            load: lane_of(&self.loads[segment], index),
        }
    }

    pub(super) fn stress_impl(&self, lane: usize, e: usize) -> [[f64; D]; MOST_NODES] {
        of_element(self.stress_of(e), lane)
    }

    pub(super) fn local_impl(&self, lane: usize, e: usize) -> [[f64; D]; MOST_NODES] {
        of_element(&T::run(LocalUnknowns(self, e)), lane)
    }

    pub(super) fn strains_impl(&self, lane: usize, e: usize) -> [[f64; D]; MOST_NODES] {
        of_element(&T::run(Strains(self, e)), lane)
    }
}
