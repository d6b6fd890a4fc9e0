//! Eigenvalue problems of a whole network, all nodes of all members: operators, factors and the search for eigenvalues.

pub mod factor;
mod krylov;
pub mod operators;
pub mod pencil;
pub mod prolong;
pub mod shape;
pub mod unknowns;
