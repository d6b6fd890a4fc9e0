//! What a chain is built from.

use pennate_elements::small::{M3, V3};

use crate::fibres::Fibres;

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
