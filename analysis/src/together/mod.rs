//! Designs of one topology, side by side in the lanes of the processor.
//!
//! They are put into one structure: members of equal mesh share the lanes, and what a solve costs besides its members is paid
//! once. Designs that need not take the same way, or whose way is not plain, are left to the ordinary solver.

mod join;
mod kept;
mod kind;
mod walk;

use std::fmt;
use std::rc::Rc;
use std::sync::{Mutex, PoisonError};

use pennate_models::Model;
use pennate_solver::structure::{Dimension, Step, Structure};
use pennate_solver::system::System;

use self::join::Share;
pub(crate) use self::join::join;
use self::kept::Analysed;
pub(crate) use self::kind::{Kind, Packs, axis, plane, present, space, system};
use self::walk::is_plain;
pub(crate) use self::walk::{End, Look, joins};

/// Designs that are solved side by side: as many as the widest lanes hold of one member.
pub(crate) const TOGETHER: usize = 8;
/// Forces of a design smaller than this part of the largest of its group are not looked at closely enough there.
const FEEBLE: f64 = 1e-2;

/// A structure and its steps.
pub(crate) type Posed<'a> = (&'a Structure, &'a [Step]);

/// What is asked of designs.
pub(crate) struct Asked<'a> {
    /// What is wanted of the end of a step.
    pub look: &'a dyn Fn(usize) -> Look,
    /// Whether anybody still waits.
    pub wanted: &'a dyn Fn() -> bool,
}

/// What is kept from one group to the next: analyses of equations, which no answer depends on.
#[derive(Default)]
pub(crate) struct Workspace {
    /// Models of designs that were solved, which those of others may be evaluated in.
    pub models: Vec<Model>,
    plane: Analysed<3>,
    space: Analysed<6>,
}

/// Those that no thread uses at present: as many as threads did at once.
#[derive(Default)]
pub(crate) struct Workspaces(Mutex<Vec<Workspace>>);

impl Workspaces {
    pub(crate) fn take(&self) -> Workspace {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default()
    }

    pub(crate) fn give_back(&self, workspace: Workspace) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(workspace);
    }
}

impl fmt::Debug for Workspaces {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Workspaces")
    }
}

/// What was found of a design: the ends of its steps, those not looked at empty, and where the system is in which it stands there.
pub(crate) struct Found {
    pub ends: Vec<Option<End>>,
    systems: Systems,
    share: Share,
}

/// Systems of a group at the ends of steps.
#[derive(Clone)]
enum Systems {
    Plane(Vec<Option<Rc<System<3>>>>),
    Space(Vec<Option<Rc<System<6>>>>),
}

/// A system of one design at the end of a step.
pub(crate) enum Standing {
    Plane(System<3>),
    Space(System<6>),
}

impl Found {
    /// The system of a design at the end of a step that [`Look::System`] was asked of.
    pub(crate) fn system(&self, design: Posed<'_>, step: usize) -> Option<Standing> {
        match &self.systems {
            Systems::Plane(all) => self.share.alone(all[step].as_deref()?, design, &plane(1)).map(Standing::Plane),
            Systems::Space(all) => self.share.alone(all[step].as_deref()?, design, &space(1)).map(Standing::Space),
        }
    }
}

/// The ends of the steps of some designs of one topology, those not looked at empty; nothing for designs that have to be
/// solved alone. A workspace serves designs of one topology alone.
pub(crate) fn solve(
    designs: &[Posed<'_>],
    asked: &Asked<'_>,
    workspace: Option<&mut Workspace>,
) -> Vec<Option<Vec<Option<End>>>> {
    find(designs, asked, workspace).into_iter().map(|found| found.map(|found| found.ends)).collect()
}

/// The same, with the systems that [`Look::System`] asks for.
pub(crate) fn find(
    designs: &[Posed<'_>],
    asked: &Asked<'_>,
    mut workspace: Option<&mut Workspace>,
) -> Vec<Option<Found>> {
    let are_plain: Vec<bool> = designs.iter().map(|&(structure, steps)| is_plain(structure, steps)).collect();
    let plain: Vec<Posed<'_>> =
        designs.iter().zip(&are_plain).filter_map(|(design, plain)| plain.then_some(*design)).collect();
    let mut found = if plain.iter().all(|&(structure, _)| joins(structure)) {
        solve_joined(&plain, asked, workspace.as_deref_mut())
    } else {
        plain.iter().flat_map(|&design| solve_joined(&[design], asked, workspace.as_deref_mut())).collect()
    }
    .into_iter();
    are_plain.into_iter().map(|plain| if plain { found.next().flatten() } else { None }).collect()
}

fn solve_joined(designs: &[Posed<'_>], asked: &Asked<'_>, mut workspace: Option<&mut Workspace>) -> Vec<Option<Found>> {
    let Some((structure, steps, shares)) = join(designs) else { return Vec::new() };
    let count = designs.len();
    let ends = match structure.dimension {
        Dimension::Plane => {
            let analysed = workspace.as_deref_mut().map(|kept| kept.plane.entry(count).or_default());
            let found = walk::ends(structure, &steps, &plane(count), analysed, asked);
            found.map(|(ends, systems)| (ends, Systems::Plane(systems)))
        }
        Dimension::Space => {
            let analysed = workspace.as_deref_mut().map(|kept| kept.space.entry(count).or_default());
            let found = walk::ends(structure, &steps, &space(count), analysed, asked);
            found.map(|(ends, systems)| (ends, Systems::Space(systems)))
        }
    };
    let in_doubt = match ends {
        Ok((ends, systems)) => return shared_out(&shares, &ends, &systems),
        Err(in_doubt) => in_doubt,
    };
    // Of two it is as good to solve both alone, and one that is left has none beside it.
    if count <= 2 || in_doubt.len() + 1 == count || !(asked.wanted)() {
        return designs.iter().map(|_| None).collect();
    }
    // Others need not wait for those that are in doubt; where nothing tells which these are, halves are tried.
    if (1..count).contains(&in_doubt.len()) {
        let is_known = |design: &usize| !in_doubt.contains(design);
        let others: Vec<Posed<'_>> = (0..count).filter(is_known).map(|design| designs[design]).collect();
        let mut found = solve_joined(&others, asked, workspace).into_iter();
        return (0..count).map(|design| if is_known(&design) { found.next().flatten() } else { None }).collect();
    }
    let (first, second) = designs.split_at(count / 2);
    let mut found = solve_joined(first, asked, workspace.as_deref_mut());
    found.extend(solve_joined(second, asked, workspace));
    found
}

/// What of the ends of a group belongs to each design; nothing for those whose forces are too small beside those of others.
fn shared_out(shares: &[Share], ends: &[Option<End>], systems: &Systems) -> Vec<Option<Found>> {
    let forces: Vec<Vec<f64>> = ends.iter().flatten().map(|end| largest_forces(shares, end)).collect();
    let found = |(design, share): (usize, &Share)| {
        let feeble = |forces: &Vec<f64>| forces[design] < FEEBLE * forces.iter().copied().fold(0.0, f64::max);
        if forces.iter().any(feeble) {
            return None;
        }
        let ends = ends.iter().map(|end| end.as_ref().map(|end| share.end(end))).collect();
        Some(Found { ends, systems: systems.clone(), share: share.clone() })
    };
    shares.iter().enumerate().map(found).collect()
}

/// The largest force on the members of every design at the end of a step.
fn largest_forces(shares: &[Share], end: &End) -> Vec<f64> {
    shares.iter().map(|share| share.largest_force(&end.state)).collect()
}
