//! Stiffness of a cross section.
//!
//! Theory: docs/theory/rod.md, Eq. 1.2.

/// Stiffness and mass of a cross section, per unit of unloaded length.
///
/// Axis 1 is the tangent, axes 2 and 3 lie in the section. A stiffness of `f64::INFINITY` in `ea`, `ga2` or
/// `ga3` stands for an inextensible or shear-rigid rod, which is met exactly (by a Lagrange multiplier) and
/// not by a large number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Axial stiffness EA (force).
    pub ea: f64,
    /// Shear stiffness along axis 2, shear correction included (force).
    pub ga2: f64,
    /// Shear stiffness along axis 3, shear correction included (force).
    pub ga3: f64,
    /// Torsional stiffness (force times length squared).
    pub gj: f64,
    /// Bending stiffness about axis 2 (force times length squared).
    pub ei2: f64,
    /// Bending stiffness about axis 3 (force times length squared).
    pub ei3: f64,
    /// Mass per unit of unloaded length.
    pub mass_per_length: f64,
    /// Rotatory inertia ρI about axes 2 and 3 per unit of unloaded length; about axis 1 it is their sum.
    pub rotary_inertia: [f64; 2],
}
