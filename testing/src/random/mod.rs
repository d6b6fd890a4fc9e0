//! Random networks by seed, and the check of their states without the solver.

pub mod case;
pub mod check;
pub mod network;
pub mod shapes;
pub mod stiff;
