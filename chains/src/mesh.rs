//! What a chain is built from, and how its members are divided into elements.

use pennate_elements::interpolation::Table;
use pennate_elements::laws::{About, Formulation};
use pennate_elements::small::{M3, V3};

use crate::fibres::Fibres;
use crate::{MOST_LANES, MOST_NODES};

/// Mesh and unloaded geometry of one member, as its chain is built from it.
#[derive(Clone, Debug)]
pub struct ChainMesh {
    /// Index of the member in the structure.
    pub member: usize,
    /// Material axes at the start by rows; in the plane axis 3 is z.
    pub axes: M3<f64>,
    /// At least one, in a row from start to end.
    pub segments: Vec<SegmentMesh>,
}

/// A stretch of a member with equal elements.
#[derive(Clone, Copy, Debug)]
pub struct SegmentMesh {
    /// Unloaded length.
    pub length: f64,
    /// Number of elements.
    pub elements: usize,
    /// In the axes of [`ChainMesh::axes`].
    pub curvature: V3<f64>,
    /// In the same axes.
    pub fibres: Fibres,
}

/// Elements whose lengths differ by no more than this part are the same: rounding.
const SAME: f64 = 1e-12;

/// How the members of a pack are divided into elements: plain numbers, whatever the pack computes with.
#[derive(Clone, Debug)]
pub struct PackMesh {
    /// Members of the lanes, by index in the structure.
    pub members: Vec<usize>,
    /// Numbers that lie side by side, those of the members and more where these do not fill the lanes.
    pub lanes: usize,
    /// Formulation of the elements.
    pub formulation: Formulation,
    /// Their polynomial order.
    pub order: usize,
    pub(crate) segment_of: Vec<usize>,
    /// Unloaded lengths of the elements of every segment, by lane.
    lengths: Vec<[f64; MOST_LANES]>,
    points: [f64; MOST_NODES],
    weights: [f64; MOST_NODES],
    integrals: [f64; MOST_NODES],
}

impl PackMesh {
    /// Of members of equal mesh, on elements of order P.
    pub(crate) fn new<const P: usize>(
        lanes: usize,
        formulation: Formulation,
        table: &Table<P>,
        meshes: &[ChainMesh],
    ) -> Self {
        let segments = &meshes[0].segments;
        let mut segment_of = Vec::new();
        let mut lengths = vec![[0.0; MOST_LANES]; segments.len()];
        for (index, segment) in segments.iter().enumerate() {
            segment_of.resize(segment_of.len() + segment.elements, index);
            for (length, mesh) in lengths[index].iter_mut().zip(meshes) {
                let own = &mesh.segments[index];
                *length = own.length / own.elements as f64;
            }
        }
        let mut mesh = Self {
            members: meshes.iter().map(|mesh| mesh.member).collect(),
            lanes,
            formulation,
            order: P,
            segment_of,
            lengths,
            points: [0.0; MOST_NODES],
            weights: [0.0; MOST_NODES],
            integrals: [0.0; MOST_NODES],
        };
        mesh.points[..P].copy_from_slice(&table.points);
        mesh.weights[..P].copy_from_slice(&table.weights);
        mesh.integrals[..P].copy_from_slice(&table.integrals);
        mesh
    }

    /// What is known of the law of the elements.
    pub fn about(&self) -> About {
        self.formulation.about()
    }

    /// Number of segments of each member.
    pub fn segments(&self) -> usize {
        self.lengths.len()
    }

    /// Number of elements of each member.
    #[inline]
    pub fn elements(&self) -> usize {
        self.segment_of.len()
    }

    /// Segment that an element belongs to.
    #[inline]
    pub fn segment_of(&self, element: usize) -> usize {
        self.segment_of[element]
    }

    /// First element of a segment, and their number.
    pub fn elements_of(&self, segment: usize) -> (usize, usize) {
        let first = |segment: usize| self.segment_of.partition_point(|&s| s < segment);
        (first(segment), first(segment + 1) - first(segment))
    }

    /// Unloaded length of the elements of a segment.
    #[inline]
    pub fn element_length(&self, lane: usize, segment: usize) -> f64 {
        self.lengths[segment][lane]
    }

    /// Unloaded length of an element.
    #[inline]
    pub fn length(&self, lane: usize, element: usize) -> f64 {
        self.lengths[self.segment_of[element]][lane]
    }

    /// Where the elements of a member begin and end along its unloaded length: one more than elements, from zero on.
    pub fn spans(&self, lane: usize) -> Vec<f64> {
        let mut ends = Vec::with_capacity(self.elements() + 1);
        let mut at = 0.0;
        ends.push(at);
        for element in 0..self.elements() {
            at += self.length(lane, element);
            ends.push(at);
        }
        ends
    }

    /// Gauss points in the unit interval.
    pub fn points(&self) -> &[f64] {
        &self.points[..self.order]
    }

    /// Weights of the Gauss points; their sum is one.
    pub fn weights(&self) -> &[f64] {
        &self.weights[..self.order]
    }

    /// Integrals over the unit interval of the shape functions of all nodes of an element but the first.
    pub fn integrals(&self) -> &[f64] {
        &self.integrals[..self.order]
    }

    /// Mass of an element end, against displacements and against rotations, for a unit of mass for a unit of length.
    #[inline]
    pub fn end_mass(&self, lane: usize, end: usize) -> [f64; 2] {
        let part = |element: usize| self.length(lane, element) / (2.0 * self.order as f64);
        let left = if end > 0 { part(end - 1) } else { 0.0 };
        let right = if end < self.elements() { part(end) } else { 0.0 };
        let mass = left + right;
        [mass, mass * (2.0 * mass) * (2.0 * mass)]
    }

    /// Whether a member has the same elements here and in another pack, whatever their order.
    pub fn is_divided_like(&self, lane: usize, other: &Self, from: usize) -> bool {
        let same = |segment: usize| {
            let [own, others] = [self.element_length(lane, segment), other.element_length(from, segment)];
            (own - others).abs() <= SAME * own
        };
        self.segment_of == other.segment_of && self.segments() == other.segments() && (0..self.segments()).all(same)
    }
}
