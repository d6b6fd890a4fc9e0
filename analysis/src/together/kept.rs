//! What one group of designs leaves to the next one of the same topology: analyses and memory, which no answer depends on.

use std::collections::BTreeMap;

use pennate_solver::continuation::OutOfPlane;
use pennate_solver::system::{State, System};

/// What is kept, by the number of designs in a group.
pub(crate) type Analysed<const D: usize> = BTreeMap<usize, Kept<D>>;

/// What groups of so many designs leave.
#[derive(Default)]
pub(crate) struct Kept<const D: usize> {
    /// Systems whose equations are analysed: one for the unloaded structure and for every step that changes what is held.
    pub systems: Vec<System<D>>,
    /// Whether a group was not stable out of the plane: unloaded networks are looked at there.
    pub looks_aside: bool,
    /// What the last group worked in.
    pub memory: Memory<D>,
}

/// What a group works in: the next one begins anew in it.
#[derive(Default)]
pub(crate) struct Memory<const D: usize> {
    pub system: Option<System<D>>,
    pub lateral: Option<Box<dyn OutOfPlane<D> + Send>>,
    pub states: [State; 3],
}
