//! Many designs of one topology, solved side by side.
//!
//! Designs that differ in geometry, sections or loads alone are put into one structure, a few at a time: their members of
//! equal mesh share the lanes of the processor, and what a solve costs besides its members is paid once. They need not
//! take the same way, so a group that does not reach its end cleanly is halved, and each half solved anew; a design that
//! is left alone is solved as any other structure is, and what became of it is its answer.

use rayon::prelude::*;

use crate::error::SolveError;
use crate::history::{Cause, History, MemberState, NodeState, Status};
use crate::options::Options;
use crate::structure::{Change, Drive, Method, Spring, Step, Structure};

/// Designs that are solved together at first: two lanes' worth of every member.
const TOGETHER: usize = 8;

/// A structure with the steps that are made of it.
#[derive(Clone, Debug)]
pub struct Design {
    pub structure: Structure,
    pub steps: Vec<Step>,
}

/// A design at the end of one of its steps. Vectors are in global axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EndState {
    pub nodes: Vec<NodeState>,
    pub members: Vec<MemberState>,
}

/// Why a design has no answer.
#[derive(Clone, Debug)]
pub enum Reason {
    /// It has no equilibrium to look for.
    Refused(SolveError),
    /// A step stopped short, at this part of its ramp.
    Stopped { step: usize, status: Status, fraction: f64, cause: Option<Cause> },
}

/// The ends of all steps of a design, or why there is none.
pub type Outcome = Result<Vec<EndState>, Reason>;

/// Solves all designs; answers come in their order, and do not depend on the number of threads.
///
/// Neighbours in the list are solved together where they have the same number of nodes, members, supports and steps;
/// designs with gravity or with steps that follow an arc or jump are solved alone. A singular point on the way is no
/// failure, as in [`crate::solve`].
pub fn solve(designs: &[Design], threads: usize) -> Vec<Outcome> {
    let groups: Vec<&[Design]> =
        designs.chunk_by(alike).flat_map(|run| run.chunks(if joins(&run[0]) { TOGETHER } else { 1 })).collect();
    let each = |group: &&[Design]| solve_group(group);
    if threads <= 1 {
        return groups.iter().flat_map(each).collect();
    }
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(|| groups.par_iter().flat_map_iter(each).collect()),
        // Threads that cannot be had cost time, not the answer.
        Err(_) => groups.iter().flat_map(each).collect(),
    }
}

/// Whether two designs have one topology.
fn alike(a: &Design, b: &Design) -> bool {
    let (x, y) = (&a.structure, &b.structure);
    let members = || x.members.iter().zip(&y.members);
    x.dimension == y.dimension
        && x.nodes.len() == y.nodes.len()
        && x.members.len() == y.members.len()
        && x.supports.len() == y.supports.len()
        && a.steps.len() == b.steps.len()
        && members().all(|(a, b)| (a.nodes, a.segments.len(), a.order) == (b.nodes, b.segments.len(), b.order))
}

/// Whether a design may be solved together with others.
fn joins(design: &Design) -> bool {
    let gravity = design.structure.drives.iter().any(|drive| matches!(drive, Drive::Gravity(_)));
    let plain = design.steps.iter().all(|step| step.method == Method::Newton && step.stop.is_none());
    !gravity && plain
}

fn solve_group(group: &[Design]) -> Vec<Outcome> {
    if let [design] = group {
        return vec![alone(design)];
    }
    let (structure, steps) = join(group);
    let solved = crate::solve(&structure, &steps, &Options::default(), &mut |_| true);
    match solved {
        Ok(history) if history.steps.iter().all(clean) => {
            let mut at = [0, 0];
            let ends = group.iter().map(|design| {
                let [nodes, members] = [design.structure.nodes.len(), design.structure.members.len()];
                let ranges = [at[0]..at[0] + nodes, at[1]..at[1] + members];
                at = [ranges[0].end, ranges[1].end];
                Ok(ends_of(&history, ranges))
            });
            ends.collect()
        }
        _ => group.chunks(group.len().div_ceil(2)).flat_map(solve_group).collect(),
    }
}

/// Whether a step of several designs tells what becomes of each.
fn clean(step: &crate::history::StepHistory) -> bool {
    step.status == Status::Converged && step.critical_points.is_empty() && step.negative_pivots == 0
}

fn alone(design: &Design) -> Outcome {
    let solved = crate::solve(&design.structure, &design.steps, &Options::default(), &mut |_| true);
    let history = solved.map_err(Reason::Refused)?;
    match history.steps.iter().position(|step| step.status != Status::Converged) {
        None => Ok(ends_of(&history, [0..design.structure.nodes.len(), 0..design.structure.members.len()])),
        Some(index) => {
            let step = &history.steps[index];
            let cause = step.failure.as_ref().map(|failure| failure.cause);
            Err(Reason::Stopped { step: index, status: step.status, fraction: step.fraction, cause })
        }
    }
}

fn ends_of(history: &History, [nodes, members]: [std::ops::Range<usize>; 2]) -> Vec<EndState> {
    let last = history.steps.iter().filter_map(|step| step.increments.last());
    let end = last.map(|increment| EndState {
        nodes: increment.state.nodes[nodes.clone()].to_vec(),
        members: increment.state.members[members.clone()].to_vec(),
    });
    end.collect()
}

/// One structure of several designs that have nothing in common.
fn join(group: &[Design]) -> (Structure, Vec<Step>) {
    let mut all = Structure {
        nodes: Vec::new(),
        members: Vec::new(),
        laws: Vec::new(),
        supports: Vec::new(),
        bodies: Vec::new(),
        springs: Vec::new(),
        drives: Vec::new(),
        compliances: Vec::new(),
        dimension: group[0].structure.dimension,
        stability: group[0].structure.stability,
    };
    let mut steps = vec![Step::default(); group[0].steps.len()];
    for Design { structure, steps: own } in group {
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
            match &mut moved {
                Spring::Ground { node: at, .. } => *at += node,
                Spring::Axial { nodes, .. } | Spring::Coupling { nodes, .. } => *nodes = nodes.map(|n| n + node),
            }
            moved
        }));
        all.drives.extend(structure.drives.iter().map(|&moved| match moved {
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
            step.branch = own.branch;
        }
    }
    (all, steps)
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
