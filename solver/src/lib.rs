//! Equilibrium of a structure of beam elements.
//!
//! A [`structure::Structure`] and its steps go in, a [`history::History`] comes out. Each member is a chain of elements
//! that is condensed onto its two ends ([`chain`]); ends meet in joints ([`joints`]), whose equations are factorized
//! (`linear`) by a system ([`system`]) that Newton's iteration ([`newton`]) brings to equilibrium, increment by
//! increment ([`path`]).

pub mod base;
mod blocks;
pub mod buckling;
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
pub mod path;
mod reduce;
pub mod results;
mod rounding;
pub mod sensitivity;
pub mod spectral;
mod split;
mod spring;
pub mod structure;
pub mod system;

pub use pennate_chains as chain;

use std::sync::Arc;

use chain::Pack;
use error::{FreeMotion, NearMotion, SolveError};
use history::{History, Note, StepHistory};
use joints::{Active, Topology};
use lateral::Lateral;
use options::{Options, Progress};
use path::{Guide, OutOfPlane, Path};
use split::Split;
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
pub struct Trail(Kind);

impl Trail {
    fn shed(&mut self) {
        match &mut self.0 {
            Kind::Plane(guide) => guide.shed(),
            Kind::Space(guide) => guide.shed(),
        }
    }
}

enum Kind {
    Plane(Box<Guide<3>>),
    Space(Box<Guide<6>>),
}

impl std::fmt::Debug for Trail {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Trail").finish_non_exhaustive()
    }
}

/// The same as [`solve`], by way of a solve on a coarser mesh of the same network: its trail, and its history.
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
    coarse: Option<(Trail, &History)>,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Result<(History, Option<Trail>), SolveError> {
    let structure = Arc::new(structure.clone());
    let coarse = coarse.map(|(mut trail, history)| {
        trail.shed();
        (trail, history)
    });
    // What the unloaded structure does is known from the coarser mesh.
    let known = coarse.as_ref().map(|(_, history)| history.near_motion.clone());
    let options = &Options { near_motion: options.near_motion && known.is_none(), ..options.clone() };
    let (mut history, trail) = follow(&structure, steps, options, coarse, observe)?;
    history.near_motion = history.near_motion.or(known.flatten());
    if history.inside.is_empty() {
        return Ok((history, Some(trail)));
    }
    let split = Split::new(&structure, steps, &history.inside);
    let near_motion = history.near_motion.clone();
    match follow(&split.structure, &split.steps, options, None, observe) {
        Ok((better, _)) => Ok((History { near_motion, ..split.joined(better) }, None)),
        // A bar that spins about itself between two pins is a mechanism in halves.
        Err(SolveError::Mechanism(_)) => Ok((history, None)),
    }
}

fn follow(
    structure: &Arc<Structure>,
    steps: &[Step],
    options: &Options,
    coarse: Option<(Trail, &History)>,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Result<(History, Trail), SolveError> {
    let topology = path::topology(structure, steps);
    match structure.dimension {
        Dimension::Space => {
            let guide = match coarse {
                Some((Trail(Kind::Space(guide)), history)) => Some((*guide, history.steps.as_slice())),
                _ => None,
            };
            let mut path = prepare(structure, &topology, steps, options, SPACE, packs::space, guide)?;
            path.vibration = Some(|space, _| flutter::judge(&|enrich| base::of_space(space, enrich)));
            let history = path.run(steps, observe);
            let guide = path.into_guide();
            Ok((history, Trail(Kind::Space(Box::new(guide)))))
        }
        Dimension::Plane => {
            let mut path = prepare(structure, &topology, steps, options, PLANE, packs::plane, None)?;
            if let Some((Trail(Kind::Plane(guide)), history)) = coarse {
                path.guide = Some((*guide, &history.steps));
            }
            add_lateral(&mut path, structure);
            path.vibration =
                Some(|plane, stability| flutter::judge(&|enrich| base::of_plane(plane, stability, enrich)));
            let history = path.run(steps, observe);
            let guide = path.into_guide();
            Ok((history, Trail(Kind::Plane(Box::new(guide)))))
        }
    }
}

fn prepare<'a, const D: usize>(
    structure: &Arc<Structure>,
    topology: &Arc<Topology>,
    steps: &[Step],
    options: &Options,
    active: Active<D>,
    packs: fn(&Structure, usize) -> Vec<Box<dyn Pack<D>>>,
    guide: Option<(Guide<D>, &'a [StepHistory])>,
) -> Result<Path<'a, D>, SolveError> {
    let parallel = options.threads > 1;
    let (structure, topology) = (Arc::clone(structure), Arc::clone(topology));
    let stop = options.stop.clone();
    let build = move |enrich| {
        let packs = packs(&structure, enrich);
        let mut system = System::new(Arc::clone(&structure), Arc::clone(&topology), packs, active, parallel);
        system.stop.clone_from(&stop);
        system
    };
    let mut path = Path::new(build(0), options.clone());
    path.keeps = options.estimate;
    match guide {
        Some((guide, steps)) => path.follow_after(guide, steps),
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
fn add_lateral(path: &mut Path<'_, 3>, structure: &Structure) {
    path.stability = Dimension::Plane;
    if structure.stability == Stability::Plane {
        return;
    }
    let mut lateral = Lateral::new(&path.system, lateral::rows(structure));
    let (inertia, _) = lateral.inertia(&mut path.system);
    if inertia.idle > 0 || inertia.negative > 0 {
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
    let topology = path::topology(&structure, steps);
    let options = Options::default();
    match structure.dimension {
        Dimension::Space => {
            let packs = packs::space(&structure, 0);
            Path::new(System::new(structure, topology, packs, SPACE, false), options).free_motions(steps)
        }
        Dimension::Plane => {
            let packs = packs::plane(&structure, 0);
            Path::new(System::new(structure, topology, packs, PLANE, false), options).free_motions(steps)
        }
    }
}

/// Finds the softest motion of the unloaded structure, where its stiffness is next to nothing, but something.
///
/// What the first step holds counts as held.
pub fn near_motion(structure: &Structure, steps: &[Step]) -> Option<NearMotion> {
    let structure = Arc::new(structure.clone());
    let topology = path::topology(&structure, steps);
    let options = Options::default();
    match structure.dimension {
        Dimension::Space => {
            let packs = packs::space(&structure, 0);
            Path::new(System::new(structure, topology, packs, SPACE, false), options).near_motion(steps)
        }
        Dimension::Plane => {
            let packs = packs::plane(&structure, 0);
            Path::new(System::new(structure, topology, packs, PLANE, false), options).near_motion(steps)
        }
    }
}
