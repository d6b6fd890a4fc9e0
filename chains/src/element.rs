//! One element of a chain with all that it is evaluated at, out of the lanes.

use pennate_elements::beam::{Beam, Moduli, Piece, Placement};
use pennate_elements::laws::{Formulation, LocalLaw, WithLaw};
use pennate_elements::real::Real;
use pennate_elements::small::{M3, V3, add, dot, scale};

use crate::lanes::{lane, lane_of, lanes};
use crate::{Chain, Pack};

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

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    pub(super) fn element_impl(&self, index: usize, e: usize) -> ElementState<D> {
        let packed = &self.pieces[e];
        let segment = self.mesh.segment_of[e];
        let moduli = &self.moduli[segment];
        ElementState {
            formulation: B::Law::FORMULATION,
            piece: Piece {
                length: packed.length.lane(index),
                axes: lanes(&packed.axes, index),
                chord: lane_of(&packed.chord, index),
                bulge: lane_of(&packed.bulge, index),
            },
            curvature: self.initial_curvature(e, index),
            segment,
            ends: [self.element_end(index, e), self.element_end(index, e + 1)],
            local: self.local_unknowns(e).iter().map(|node| lane(node, index)).collect(),
            reference: (0..P).map(|i| lane_of(&self.reference(e, i), index)).collect(),
            curved: self.curved(e).map(|frames| frames.iter().map(|frame| lanes(frame, index)).collect()),
            stress: self.stress_of(e).iter().map(|stress| lane(stress, index)).collect(),
            moduli: Moduli {
                stiffness: lane(&moduli.stiffness, index),
                rest: lane(&moduli.rest, index),
                held: lane(&moduli.held, index),
                softening: lane(&moduli.softening, index),
            },
            load: lane_of(&self.loads[segment], index),
        }
    }
}
