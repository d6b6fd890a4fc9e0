//! Several designs in one structure, side by side: members of equal mesh share the lanes of the processor.

use std::ops::Range;
use std::sync::Arc;

use pennate_solver::continuation;
use pennate_solver::history::Equilibrium;
use pennate_solver::joints::Held;
use pennate_solver::structure::{Change, Drive, Step, Structure};
use pennate_solver::system::System;

use super::walk::{End, Finer};
use super::{Kind, Posed};

/// What belongs to one of the designs in a state of all.
#[derive(Clone, Debug)]
pub(crate) struct Share {
    nodes: Range<usize>,
    members: Range<usize>,
    springs: Range<usize>,
    sections: Range<usize>,
    drives: Range<usize>,
    compliances: Range<usize>,
}

impl Share {
    /// The state of one design.
    fn of(&self, all: &Equilibrium) -> Equilibrium {
        Equilibrium {
            nodes: all.nodes[self.nodes.clone()].to_vec(),
            members: all.members[self.members.clone()].to_vec(),
            springs: all.springs[self.springs.clone()].to_vec(),
            sections: all.sections[self.sections.clone()].to_vec(),
            compliances: all.compliances.get(self.compliances.clone()).unwrap_or_default().to_vec(),
            rounding: None,
            ..*all
        }
    }

    /// The end of a step of one design.
    pub(super) fn end(&self, all: &End) -> End {
        let finer = all.finer.as_ref().map(|finer| Finer {
            state: self.of(&finer.state),
            missing: finer.missing[self.members.clone()].to_vec(),
            variations: finer.variations[self.members.clone()].to_vec(),
        });
        End { state: self.of(&all.state), finer }
    }

    /// A system of one design alone, where it is in that of all, at the end of a step; nothing where its joints are others.
    pub(super) fn alone<const D: usize>(
        &self,
        all: &System<D>,
        (structure, steps): Posed<'_>,
        kind: &Kind<D>,
    ) -> Option<System<D>> {
        let structure = Arc::new(structure.clone());
        let topology = continuation::topology(&structure, steps);
        let chains = (kind.packs)(&structure, 0);
        let mut system = System::new(structure, topology, chains, kind.active, false);
        if !system.adopt_part(all, self.nodes.start, self.members.start) {
            return None;
        }
        let own = all.held().into_iter().filter(|held| self.nodes.contains(&held.node));
        system.hold(own.map(|held| Held { node: held.node - self.nodes.start, ..held }).collect());
        system.loading.drives.copy_from_slice(&all.loading.drives[self.drives.clone()]);
        system.apply_drives();
        Some(system)
    }

    /// The largest force on the members of one design.
    pub(super) fn largest_force(&self, all: &Equilibrium) -> f64 {
        let forces = all.members[self.members.clone()].iter().flat_map(|member| member.end_forces);
        forces.flatten().fold(0.0, |largest, force| largest.max(force.abs()))
    }
}

/// One structure of designs of one topology that have nothing in common, one after the other, their steps side by side, and what
/// belongs to each; nothing of no design. Gravity of one would be that of all.
pub(crate) fn join(designs: &[Posed<'_>]) -> Option<(Structure, Vec<Step>, Vec<Share>)> {
    let mut at = [0; 6];
    let shares = designs.iter().map(|(structure, _)| share(structure, &mut at)).collect();
    let ((first, steps), rest) = designs.split_first()?;
    let (mut all, mut steps) = ((*first).clone(), steps.to_vec());
    for &(structure, own) in rest {
        append(&mut all, &mut steps, structure, own);
    }
    Some((all, steps, shares))
}

/// What belongs to a structure that comes after so many nodes, members, springs, sections, drives and compliances.
fn share(structure: &Structure, at: &mut [usize; 6]) -> Share {
    let Structure { nodes, members, springs, sections, drives, compliances, .. } = structure;
    let counts = [nodes.len(), members.len(), springs.len(), sections.len(), drives.len(), compliances.len()];
    let [nodes, members, springs, sections, drives, compliances] =
        std::array::from_fn(|kind| at[kind]..at[kind] + counts[kind]);
    *at = [nodes.end, members.end, springs.end, sections.end, drives.end, compliances.end];
    Share { nodes, members, springs, sections, drives, compliances }
}

fn append(all: &mut Structure, steps: &mut [Step], structure: &Structure, own: &[Step]) {
    let (node, member) = (all.nodes.len(), all.members.len());
    let (law, drive) = (all.laws.len(), all.drives.len());
    all.nodes.extend_from_slice(&structure.nodes);
    all.laws.extend_from_slice(&structure.laws);
    all.members.extend(structure.members.iter().cloned().map(|mut moved| {
        moved.nodes = moved.nodes.map(|n| n + node);
        moved.segments.iter_mut().for_each(|segment| segment.law += law);
        moved.control = moved.control.map(|control| control + drive);
        moved
    }));
    all.sections.extend(structure.sections.iter().map(|moved| moved + member));
    all.compliances.extend(structure.compliances.iter().copied().map(|mut moved| {
        moved.node += node;
        moved
    }));
    all.supports.extend(structure.supports.iter().cloned().map(|mut moved| {
        moved.node += node;
        moved
    }));
    all.bodies.extend(structure.bodies.iter().cloned().map(|mut moved| {
        moved.nodes.iter_mut().for_each(|n| *n += node);
        moved.reference += node;
        moved
    }));
    all.springs.extend(structure.springs.iter().cloned().map(|mut moved| {
        moved.nodes_mut().iter_mut().for_each(|n| *n += node);
        moved
    }));
    all.drives.extend(structure.drives.iter().copied().map(|moved| match moved {
        Drive::Force(at, component) => Drive::Force(at + node, component),
        Drive::Moment(at, component) => Drive::Moment(at + node, component),
        Drive::FollowerForce(at, component) => Drive::FollowerForce(at + node, component),
        Drive::FollowerMoment(at, component) => Drive::FollowerMoment(at + node, component),
        Drive::Distributed(at, component) => Drive::Distributed(at + member, component),
        Drive::Control | Drive::Gravity(_) => moved,
    }));
    for (step, own) in steps.iter_mut().zip(own) {
        step.targets.extend(own.targets.iter().map(|&(target, value)| (target + drive, value)));
        step.changes.extend(own.changes.iter().map(|&change| moved_change(change, node)));
        step.min_increments = step.min_increments.max(own.min_increments);
    }
}

fn moved_change(mut change: Change, by: usize) -> Change {
    match &mut change {
        Change::Prescribe { node, .. }
        | Change::Hold { node, .. }
        | Change::MoveBy { node, .. }
        | Change::Free { node, .. } => *node += by,
    }
    change
}
