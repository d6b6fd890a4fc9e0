//! What a user may ask of one member in one state.

/// The deformed shape of a member: points along it, and section forces between neighbouring points.
#[derive(Clone, Debug, Default)]
pub struct MemberShape {
    /// Along the cell, from its start to its end.
    pub points: Vec<ShapePoint>,
    /// One less than points.
    pub cells: Vec<ShapeCell>,
}

/// A point of the centre line of a member.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShapePoint {
    /// Unloaded position.
    pub reference: [f64; 3],
    /// From its unloaded place, in global axes.
    pub displacement: [f64; 3],
    /// Rotation vector (radians) from the unloaded state, of norm at most π.
    pub rotation: [f64; 3],
    /// Material axes in the deformed state.
    pub axes: [[f64; 3]; 3],
}

/// Section forces and strains in material axes, at the middle of the cell.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShapeCell {
    /// Segment of the member that the cell belongs to.
    pub segment: usize,
    /// N, Q₂, Q₃.
    pub force: [f64; 3],
    /// Torque, M₂, M₃.
    pub moment: [f64; 3],
    /// Axial strain Γ₁ − 1, the induced part included.
    pub strain: f64,
    /// Induced axial strain ε*.
    pub induced_strain: f64,
    /// Bending curvature: norm of κ₂, κ₃, the initial part included.
    pub curvature: f64,
}

/// Forces and moments that the part of a member beyond a place exerts on the part before it, in material axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SectionForces {
    /// Part of the member's unloaded length from its start.
    pub at: f64,
    /// Index of its segment in the member.
    pub segment: usize,
    /// N, Q₂, Q₃.
    pub force: [f64; 3],
    /// Torque, M₂, M₃.
    pub moment: [f64; 3],
}

/// The largest of the values at the integration points of a member.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peak {
    /// The strain there.
    pub value: f64,
    /// Part of the member's unloaded length from its start.
    pub at: f64,
}

/// How fast the state of a rod may vary along one of its elements.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Variation {
    /// Unloaded length of the element.
    pub length: f64,
    /// One over the length of the boundary layers or waves that its section forces make (1/length).
    pub rate: f64,
}
