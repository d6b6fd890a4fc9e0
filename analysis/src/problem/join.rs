//! Several designs in one structure, side by side: members of equal mesh share the lanes of the processor.

use std::ops::Range;

use pennate_solver::history::Equilibrium;
use pennate_solver::structure::{Change, Drive, Spring, Step, Structure};

/// What belongs to one of the designs in a state of all.
#[derive(Clone, Debug)]
pub(super) struct Share {
    nodes: Range<usize>,
    members: Range<usize>,
    springs: Range<usize>,
    sections: Range<usize>,
}

impl Share {
    /// The state of one design.
    pub(super) fn of(&self, all: &Equilibrium) -> Equilibrium {
        Equilibrium {
            nodes: all.nodes[self.nodes.clone()].to_vec(),
            members: all.members[self.members.clone()].to_vec(),
            springs: all.springs[self.springs.clone()].to_vec(),
            sections: all.sections[self.sections.clone()].to_vec(),
            compliances: Vec::new(),
            rounding: None,
            ..*all
        }
    }

    /// The largest force on the members of one design.
    pub(super) fn largest_force(&self, all: &Equilibrium) -> f64 {
        let forces = all.members[self.members.clone()].iter().flat_map(|member| member.end_forces);
        forces.flatten().fold(0.0, |largest, force| largest.max(force.abs()))
    }
}

/// One structure of designs that have nothing in common but their topology, the steps of all, and what belongs to each.
pub(super) fn join(designs: Vec<(Structure, Vec<Step>)>) -> Option<(Structure, Vec<Step>, Vec<Share>)> {
    let mut designs = designs.into_iter();
    let (mut all, mut steps) = designs.next()?;
    let mut shares = vec![share(&all, [0; 4])];
    for (structure, own) in designs {
        let at = [all.nodes.len(), all.members.len(), all.springs.len(), all.sections.len()];
        shares.push(share(&structure, at));
        append(&mut all, &mut steps, structure, &own);
    }
    Some((all, steps, shares))
}

fn share(structure: &Structure, [node, member, spring, section]: [usize; 4]) -> Share {
    Share {
        nodes: node..node + structure.nodes.len(),
        members: member..member + structure.members.len(),
        springs: spring..spring + structure.springs.len(),
        sections: section..section + structure.sections.len(),
    }
}

fn append(all: &mut Structure, steps: &mut [Step], structure: Structure, own: &[Step]) {
    let (node, member) = (all.nodes.len(), all.members.len());
    let (law, drive) = (all.laws.len(), all.drives.len());
    all.nodes.extend(structure.nodes);
    all.laws.extend(structure.laws);
    all.members.extend(structure.members.into_iter().map(|mut moved| {
        moved.nodes = moved.nodes.map(|n| n + node);
        moved.segments.iter_mut().for_each(|segment| segment.law += law);
        moved.control = moved.control.map(|control| control + drive);
        moved
    }));
    all.sections.extend(structure.sections.into_iter().map(|moved| moved + member));
    all.supports.extend(structure.supports.into_iter().map(|mut moved| {
        moved.node += node;
        moved
    }));
    all.bodies.extend(structure.bodies.into_iter().map(|mut moved| {
        moved.nodes.iter_mut().for_each(|n| *n += node);
        moved.reference += node;
        moved
    }));
    all.springs.extend(structure.springs.into_iter().map(|mut moved| {
        match &mut moved {
            Spring::Ground { node: at, .. } => *at += node,
            Spring::Axial { nodes, .. } | Spring::Coupling { nodes, .. } => *nodes = nodes.map(|n| n + node),
        }
        moved
    }));
    all.drives.extend(structure.drives.into_iter().map(|moved| match moved {
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
