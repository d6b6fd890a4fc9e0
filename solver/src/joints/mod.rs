//! Joints: what is left of the nodes once rigid bodies are merged, what holds them, and their equations.
//!
//! A joint is a node, or a rigid body, with the six components of its reference node. What holds it is a list of
//! [`Held`] rows; the free motions of a joint are the basis of the null space of its rows, so that supports in turned
//! axes, supports on points of a body and partly held rotations are met exactly, by transformation.

mod equations;
mod gradients;
mod held;
mod idle;
mod topology;
mod turned;

pub use equations::{Active, Basis, Equations, JointEquations, dot6};
pub use held::{Held, HeldKind, JointState};
pub use idle::Idle;
pub(crate) use idle::{Kept, Line};
pub use topology::{EndKind, Link, Topology};
pub use turned::Turned;

/// Directions whose sine is smaller are parallel.
const PARALLEL: f64 = 1e-9;
