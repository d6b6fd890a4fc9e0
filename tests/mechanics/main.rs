//! Rods, joints and meshes: laws that every network keeps, and known solutions.

mod bodies;
mod convergence;
mod corotational;
mod digits;
mod drawings;
mod frames;
mod laws;
mod layers;
mod mechanisms;
mod objectivity;
mod patch;
mod prescribed;
mod releases;
mod springs;
mod stiffness;
mod strains;
mod supports;
mod variations;
