//! Rods, joints and meshes: laws that every network keeps, and known solutions.

mod convergence;
mod corotational;
mod digits;
mod frames;
mod joints;
mod laws;
mod layers;
mod objectivity;
mod patch;
mod stiffness;
mod strains;
mod variations;
