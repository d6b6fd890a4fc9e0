//! Several structures as one: nothing joins them, but members of equal mesh share the lanes of the processor.

use crate::structure::{Change, Drive, Step, Structure};

/// One structure of several of one topology that have nothing in common, one after the other, and their steps side by side;
/// nothing of no structure. Gravity of one would be that of all, and compliances are left out.
pub fn join(all: impl IntoIterator<Item = (Structure, Vec<Step>)>) -> Option<(Structure, Vec<Step>)> {
    let mut rest = all.into_iter();
    let (mut all, mut steps) = rest.next()?;
    all.compliances.clear();
    for (structure, own) in rest {
        append(&mut all, &mut steps, structure, &own);
    }
    Some((all, steps))
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
        moved.nodes_mut().iter_mut().for_each(|n| *n += node);
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
