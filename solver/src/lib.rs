//! Equilibrium of a structure of beam elements.
//!
//! A [`structure::Structure`] and its steps go in, a [`history::History`] comes out. Each member is a chain of elements
//! that is condensed onto its two ends ([`chain`]); ends meet in joints ([`joints`]), whose equations are factorized
//! (`linear`) by a system ([`system`]) that Newton's iteration ([`newton`]) brings to equilibrium, increment by
//! increment ([`continuation`]).

pub mod base;
mod blocks;
pub mod buckling;
pub mod compliance;
pub mod continuation;
mod dense;
pub mod error;
mod flutter;
mod held;
pub mod history;
pub mod joints;
pub mod lateral;
mod linear;
mod mechanism;
pub mod modes;
pub mod newton;
pub mod options;
pub mod packs;
mod reduce;
pub mod results;
pub mod rigid;
mod rounding;
pub mod sensitivity;
mod simplicial;
pub mod spectral;
mod spring;
pub mod structure;
pub mod system;
mod unsymmetric;
mod wide;

pub use pennate_chains as chain;

use std::sync::Arc;

use chain::Pack;
use continuation::{Coarse, Continuation, OutOfPlane};
use error::{FreeMotion, NearMotion, SolveError};
use history::{History, Note, StepHistory};
use joints::{Active, Topology};
use lateral::Lateral;
use options::{Options, Progress};
use structure::{Dimension, Stability, Step, Structure};
use system::System;

const PLANE: Active<3> = [0, 1, 5];
const SPACE: Active<6> = [0, 1, 2, 3, 4, 5];

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
    solve_along(structure, steps, options, None, observe).map(|(history, _)| history)
}

/// States that a solve went through, for one of the same network on a finer mesh.
pub struct CoarseSolve(Kind);

impl CoarseSolve {
    fn shed(&mut self) {
        match &mut self.0 {
            Kind::Plane(coarse) => coarse.shed(),
            Kind::Space(coarse) => coarse.shed(),
        }
    }
}

enum Kind {
    Plane(Box<Coarse<3>>),
    Space(Box<Coarse<6>>),
}

impl std::fmt::Debug for CoarseSolve {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("CoarseSolve").finish_non_exhaustive()
    }
}

/// The same as [`solve`], by way of a solve on a coarser mesh of the same network: what it kept, and its history.
///
/// Steps that went without a singular point there start from their end; the increments before it are those of the
/// coarser mesh.
///
/// # Errors
/// As [`solve`].
pub fn solve_along(
    structure: &Structure,
    steps: &[Step],
    options: &Options,
    coarse: Option<(CoarseSolve, &History)>,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Result<(History, Option<CoarseSolve>), SolveError> {
    let structure = Arc::new(structure.clone());
    let coarse = coarse.map(|(mut kept, history)| {
        kept.shed();
        (kept, history)
    });
    // What the unloaded structure does is known from the coarser mesh.
    let known = coarse.as_ref().map(|(_, history)| history.near_motion.clone());
    let options = &Options { near_motion: options.near_motion && known.is_none(), ..options.clone() };
    let (mut history, kept) = follow(&structure, steps, options, coarse, observe)?;
    history.near_motion = history.near_motion.or(known.flatten());
    Ok((history, Some(kept)))
}

fn follow(
    structure: &Arc<Structure>,
    steps: &[Step],
    options: &Options,
    coarse: Option<(CoarseSolve, &History)>,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Result<(History, CoarseSolve), SolveError> {
    let topology = continuation::topology(structure, steps);
    match structure.dimension {
        Dimension::Space => {
            let coarse = match coarse {
                Some((CoarseSolve(Kind::Space(coarse)), history)) => Some((*coarse, history.steps.as_slice())),
                _ => None,
            };
            let mut path = prepare(structure, &topology, steps, options, SPACE, packs::space, coarse)?;
            path.judges = Some(base::JUDGES_IN_SPACE);
            let history = run(&mut path, steps, observe)?;
            let coarse = path.into_coarse();
            Ok((history, CoarseSolve(Kind::Space(Box::new(coarse)))))
        }
        Dimension::Plane => {
            let mut path = prepare(structure, &topology, steps, options, PLANE, packs::plane, None)?;
            if let Some((CoarseSolve(Kind::Plane(coarse)), history)) = coarse {
                path.coarse = Some((*coarse, &history.steps));
            }
            add_lateral(&mut path, structure);
            path.judges = Some(base::JUDGES_IN_PLANE);
            let history = run(&mut path, steps, observe)?;
            let coarse = path.into_coarse();
            Ok((history, CoarseSolve(Kind::Plane(Box::new(coarse)))))
        }
    }
}

/// Follows the steps; motions that not even a prestress resists are found on the way.
fn run<const D: usize>(
    path: &mut Continuation<'_, D>,
    steps: &[Step],
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Result<History, SolveError> {
    let history = path.run(steps, observe);
    let free = std::mem::take(&mut path.free);
    if free.is_empty() { Ok(history) } else { Err(SolveError::Mechanism(free)) }
}

fn prepare<'a, const D: usize>(
    structure: &Arc<Structure>,
    topology: &Arc<Topology>,
    steps: &[Step],
    options: &Options,
    active: Active<D>,
    packs: fn(&Structure, usize) -> Vec<Box<dyn Pack<D>>>,
    coarse: Option<(Coarse<D>, &'a [StepHistory])>,
) -> Result<Continuation<'a, D>, SolveError> {
    let parallel = options.threads > 1;
    let (structure, topology) = (Arc::clone(structure), Arc::clone(topology));
    let stop = options.stop.clone();
    let build = move |enrich| {
        let packs = packs(&structure, enrich);
        let mut system = System::new(Arc::clone(&structure), Arc::clone(&topology), packs, active, parallel);
        system.stop.clone_from(&stop);
        system
    };
    let mut path = Continuation::new(build(0), options.clone());
    path.keeps = options.estimate;
    match coarse {
        Some((coarse, steps)) => path.follow_after(coarse, steps),
        None => {
            let motions = path.free_motions(steps);
            if !motions.is_empty() {
                return Err(SolveError::Mechanism(motions));
            }
        }
    }
    if options.estimate {
        path.make_refined = Some(Box::new(move || build(1)));
    }
    Ok(path)
}

/// Adds the lateral tangent, where the supports hold the unloaded network out of its plane.
fn add_lateral(path: &mut Continuation<'_, 3>, structure: &Structure) {
    path.stability = Dimension::Plane;
    if structure.stability == Stability::Plane {
        return;
    }
    let mut lateral = Lateral::new(&path.system);
    if !lateral.is_held(&mut path.system) {
        path.notes.push(Note::StabilityInPlane);
        return;
    }
    path.stability = Dimension::Space;
    path.lateral = Some(Box::new(lateral));
}

/// Finds the motions that the unloaded structure can make without force; empty for a proper structure.
///
/// What the first step holds counts as held.
pub fn free_motions(structure: &Structure, steps: &[Step]) -> Vec<FreeMotion> {
    let structure = Arc::new(structure.clone());
    let topology = continuation::topology(&structure, steps);
    let options = Options::default();
    match structure.dimension {
        Dimension::Space => {
            let packs = packs::space(&structure, 0);
            Continuation::new(System::new(structure, topology, packs, SPACE, false), options).free_motions(steps)
        }
        Dimension::Plane => {
            let packs = packs::plane(&structure, 0);
            Continuation::new(System::new(structure, topology, packs, PLANE, false), options).free_motions(steps)
        }
    }
}

/// Finds the softest motion of the unloaded structure, where its stiffness is next to nothing, but something.
///
/// What the first step holds counts as held.
pub fn near_motion(structure: &Structure, steps: &[Step]) -> Option<NearMotion> {
    let structure = Arc::new(structure.clone());
    let topology = continuation::topology(&structure, steps);
    let options = Options::default();
    match structure.dimension {
        Dimension::Space => {
            let packs = packs::space(&structure, 0);
            Continuation::new(System::new(structure, topology, packs, SPACE, false), options).near_motion(steps)
        }
        Dimension::Plane => {
            let packs = packs::plane(&structure, 0);
            Continuation::new(System::new(structure, topology, packs, PLANE, false), options).near_motion(steps)
        }
    }
}
