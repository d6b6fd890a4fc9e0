//! Mechanics of one element; knows no equations and no files.
//!
//! # Notation
//! Γ = Rᵀ r′ − e₁ stretch and shear, κ = axial(Rᵀ R′) twist and curvature, N and M their forces and moments, all in
//! material axes; S, and every stiffness, load and mass per length, belong to the unloaded rod. Axis 1 is the tangent,
//! positive κ₃ turns axis 1 towards axis 2. Units are consistent and never converted.
//!
//! # Elements
//! [`space::Space`] and [`plane::Plane`], geometrically exact beams of order 1 to 5; [`space::CorotationalSpace`] and
//! [`plane::CorotationalPlane`], [corotational](laws::Corotational) beams of two nodes; [`spring`]s. For vibration and buckling: all nodes of
//! a spatial element at once ([`whole`]), and its [`mass`].

pub mod beam;
pub mod check;
pub mod interpolation;
pub mod jet;
pub mod lanes;
pub mod laws;
pub mod mass;
pub mod plane;
pub mod real;
pub mod rotation;
pub mod section;
pub mod small;
pub mod space;
pub mod spring;
pub mod whole;
