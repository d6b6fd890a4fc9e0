//! A converged state with all that vibration and buckling about it need: always in space, on elements of any order.

use std::sync::Arc;

use crate::chain::Pack;
use crate::continuation::{self, Continuation};
use crate::error::SolveError;
use crate::flutter;
use crate::history::{History, Status, Vibration};
use crate::joints::{Active, Held};
use crate::lateral;
use crate::newton::{Newton, Start};
use crate::options::{Options, Progress};
use crate::packs::{self, Auxiliary};
use crate::structure::{Dimension, Step, Structure};
use crate::system::{Spins, System, spins_of};
use crate::{PLANE, SPACE, add_lateral, prepare, run};

/// Auxiliary stiffness of rigid components, as [`packs::AUXILIARY`].
///
/// Motions are projected onto those that rigid components allow, so that eigenvalues do not depend on it, and a smaller
/// one keeps digits: with 1e7 per element the critical load of an inextensible column was off by a tenth.
const AUXILIARY: Auxiliary = Auxiliary::new(0.0, 1e4, 1e2);

/// Motions that are asked of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// A spatial network.
    Space,
    /// A plane network whose supports hold it out of its plane too.
    BothWays,
    /// A plane network that is judged in its plane alone.
    InPlane,
}

/// A network at the end of some of its steps.
pub enum Followed<'a> {
    /// In the plane.
    Plane(Box<Continuation<'a, 3>>),
    /// In space.
    Space(Box<Continuation<'a, 6>>),
}

/// A state as a spatial network, at equilibrium.
pub(crate) struct Base {
    /// The structure in the state.
    pub system: System<6>,
    /// How far the steps came.
    pub reach: Reach,
}

/// Follows the first `count` of the steps.
///
/// # Errors
/// Those of [`crate::solve`]; a step that fails is part of the history.
pub fn follow<'a>(
    structure: &Structure,
    steps: &[Step],
    count: usize,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Result<(Followed<'a>, History), SolveError> {
    follow_with(structure, steps, count, options, observe, false)
}

/// The same, with the verdicts of [`crate::solve`]: where loads have no potential vibrations are looked at.
///
/// # Errors
/// As [`follow`].
pub fn follow_judged<'a>(
    structure: &Structure,
    steps: &[Step],
    count: usize,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Result<(Followed<'a>, History), SolveError> {
    follow_with(structure, steps, count, options, observe, true)
}

fn follow_with<'a>(
    structure: &Structure,
    steps: &[Step],
    count: usize,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> bool,
    judged: bool,
) -> Result<(Followed<'a>, History), SolveError> {
    let structure = Arc::new(structure.clone());
    let topology = continuation::topology(&structure, steps);
    let steps = &steps[..count];
    match structure.dimension {
        Dimension::Space => {
            let mut path = prepare(&structure, &topology, steps, options, SPACE, packs::space, None)?;
            path.judges = judged.then_some(JUDGES_IN_SPACE);
            let history = run(&mut path, steps, observe)?;
            Ok((Followed::Space(Box::new(path)), history))
        }
        Dimension::Plane => {
            let mut path = prepare(&structure, &topology, steps, options, PLANE, packs::plane, None)?;
            add_lateral(&mut path, &structure);
            path.judges = judged.then_some(JUDGES_IN_PLANE);
            let history = run(&mut path, steps, observe)?;
            Ok((Followed::Plane(Box::new(path)), history))
        }
    }
}

/// Whether vibrations about a state are looked at where its loads have no potential: masses are known, and unknowns not too many.
pub fn vibrations_tell<const D: usize>(system: &System<D>) -> bool {
    flutter::may_judge(system)
}

/// Judges of states that the tangent of a path does not tell the stability of, in the plane alone or out of it too.
#[derive(Clone, Copy, Debug)]
pub struct Judges<const D: usize> {
    /// What small vibrations about a state do, where its loads have no potential; nothing where that cannot be said.
    pub vibration: fn(&System<D>, Dimension) -> Option<Vibration>,
    /// What bars that are kept from turning about themselves would do at a state that is stable otherwise, and at which some may
    /// ([`System::may_spin`]); nothing where that cannot be said.
    pub spins: fn(&System<D>, Dimension) -> Option<Spins>,
}

/// Those of a path in space.
pub const JUDGES_IN_SPACE: Judges<6> = Judges {
    vibration: |space, _| {
        vibrations_tell(space).then(|| flutter::judge(&space.structure, &|enrich| of_space(space, enrich)))?
    },
    spins: |space, _| of_space(space, 0).map(spins_about),
};

/// Those of a path in the plane.
pub const JUDGES_IN_PLANE: Judges<3> = Judges {
    vibration: |plane, stability| {
        let state = |enrich| of_plane(plane, stability, enrich);
        vibrations_tell(plane).then(|| flutter::judge(&plane.structure, &state))?
    },
    spins: |plane, stability| match stability {
        Dimension::Plane => Some(Spins::default()),
        Dimension::Space => of_plane(plane, stability, 0).map(spins_about),
    },
};

fn spins_about(mut base: Base) -> Spins {
    spins_of(&mut base.system)
}

/// Whether every step of a history reached its end.
pub fn is_complete(history: &History) -> bool {
    history.steps.iter().all(|step| step.status == Status::Converged)
}

impl Followed<'_> {
    /// The beginning of the ramp of a step on elements whose order is higher by `enrich`; nothing where it is not found there.
    ///
    /// What the step holds where it is, or lets go, is where these elements have it: differences between orders are to show all
    /// that depends on the mesh.
    pub(crate) fn beginning(&mut self, step: &Step, enrich: usize) -> Option<Base> {
        match self {
            Self::Plane(path) => {
                let chains = packs::plane(&path.system.structure, enrich);
                let plane = beginning(path, chains, PLANE, step)?;
                of_plane(&plane, path.stability, enrich)
            }
            Self::Space(path) => {
                let chains = packs::space(&path.system.structure, enrich);
                let space = beginning(path, chains, SPACE, step)?;
                of_space(&space, enrich)
            }
        }
    }

    /// Values of the drives, and what is held.
    pub(crate) fn drives(&self) -> &[f64] {
        match self {
            Self::Plane(path) => &path.system.loading.drives,
            Self::Space(path) => &path.system.loading.drives,
        }
    }

    /// The present state on elements whose order is higher by `enrich`; nothing where it is not found there.
    pub(crate) fn base(&mut self, enrich: usize) -> Option<Base> {
        match self {
            Self::Space(path) => of_space(&path.system, enrich),
            Self::Plane(path) => of_plane(&path.system, path.stability, enrich),
        }
    }
}

/// The state of a spatial system on elements whose order is higher by `enrich`; nothing where it is not found there.
pub(crate) fn of_space(system: &System<6>, enrich: usize) -> Option<Base> {
    let mut space = spatial(system, enrich);
    space.hold(system.pattern.equations.held.clone());
    settle(&mut space, |space| space.prolong(system))?;
    Some(Base { system: space, reach: Reach::Space })
}

/// The same of a plane system, with motions out of its plane where stability is judged there too.
pub(crate) fn of_plane(plane: &System<3>, stability: Dimension, enrich: usize) -> Option<Base> {
    let mut space = spatial(plane, enrich);
    // The equilibrium is looked for in the plane, where it is.
    space.hold(lateral::flat_rows(plane));
    settle(&mut space, |space| space.lift(plane))?;
    if stability == Dimension::Plane {
        return Some(Base { system: space, reach: Reach::InPlane });
    }
    let mut rows: Vec<Held> = lateral::rows(plane);
    rows.retain(|row| {
        plane.pattern.equations.held.iter().all(|held| (held.node, held.component) != (row.node, row.component))
    });
    rows.extend(&plane.pattern.equations.held);
    space.hold(rows);
    space.assemble(false);
    Some(Base { system: space, reach: Reach::BothWays })
}

/// The system of a path on other elements, at the beginning of the ramp of a step.
fn beginning<const D: usize>(
    path: &mut Continuation<'_, D>,
    chains: Vec<Box<dyn Pack<D>>>,
    active: Active<D>,
    step: &Step,
) -> Option<System<D>> {
    let (structure, topology) = (Arc::clone(&path.system.structure), Arc::clone(&path.system.topology));
    let mut system = System::new(structure, topology, chains, active, false);
    system.loading.fading.clone_from(&path.system.loading.fading);
    system.hold_like(&path.system);
    system.prolong(&path.system);
    Newton::default().solve(&mut system, Start::nearby()).ok()?;
    path.begin(step, &mut system);
    Some(system)
}

fn spatial<const D: usize>(system: &System<D>, enrich: usize) -> System<6> {
    let structure = Arc::clone(&system.structure);
    let packs = packs::space(&structure, enrich);
    let mut space = System::new(structure, Arc::clone(&system.topology), packs, SPACE, false);
    space.loading.fading.clone_from(&system.loading.fading);
    space.loading.auxiliary = AUXILIARY;
    space
}

/// Brings a state from nearby to equilibrium, its mixed stresses too. Where that is not found at once it is with the auxiliary
/// stiffness that states are found with, on the way.
fn settle(system: &mut System<6>, take_over: impl Fn(&mut System<6>)) -> Option<()> {
    take_over(system);
    if Newton::default().solve(system, Start::nearby()).is_err() {
        take_over(system);
        for auxiliary in [packs::AUXILIARY, AUXILIARY] {
            system.loading.set_auxiliary(auxiliary);
            Newton::default().solve(system, Start::nearby()).ok()?;
        }
    }
    // Mixed stresses are one iteration behind the state: the geometric stiffness is to be that of the equilibrium.
    system.advance(system.pattern.equations.has_general())?;
    system.assemble(false);
    Some(())
}
