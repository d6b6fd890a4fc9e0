//! Eigenvalue problems of a whole network, all nodes of all members: operators, factors and the search for eigenvalues.

pub(crate) mod eigen;
pub(crate) mod factor;
mod krylov;
pub(crate) mod operators;
pub(crate) mod pencil;
pub(crate) mod prolong;
pub mod shape;
pub(crate) mod springs;
pub mod unknowns;
