//! The scenes, and what their probes are held against: values of an independent solver, and figures as printed.

pub mod figures;
pub mod run;
pub mod tables;
