//! Many designs of one topology, solved side by side.
//!
//! Designs that differ in geometry, sections or loads alone are put into one structure, a few at a time: their members of
//! equal mesh share the lanes of the processor, and what a solve costs besides its members is paid once. They need not
//! take the same way, so those of a group that does not reach its end cleanly are solved alone, each as any other
//! structure is; what becomes of them there is their answer. Whether an increment led to another state than the one
//! nearby is judged for every design by itself.

use rayon::prelude::*;

use crate::error::SolveError;
use crate::history::{Cause, Equilibrium, History, Increment, MemberState, NodeState, Status, StepHistory};
use crate::join::join;
use crate::options::{Options, Progress};
use crate::structure::{Drive, Method, Step, Structure};

/// Designs that are solved together: as many as the widest lanes hold of one member.
pub const TOGETHER: usize = 8;
/// Forces of a design smaller than this part of the largest of its group are not looked at closely enough there.
const FEEBLE: f64 = 1e-2;

/// A structure with the steps that are made of it.
#[derive(Clone, Debug)]
pub struct Design {
    /// What is solved.
    pub structure: Structure,
    /// What is done to it, in order.
    pub steps: Vec<Step>,
}

/// A design at the end of one of its steps. Vectors are in global axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EndState {
    /// By index, as in the structure.
    pub nodes: Vec<NodeState>,
    /// By index, as in the structure.
    pub members: Vec<MemberState>,
}

/// Why a design has no answer.
#[derive(Clone, Debug)]
pub enum Reason {
    /// It has no equilibrium to look for.
    Refused(SolveError),
    /// A step stopped short, at this part of its ramp.
    Stopped {
        /// Index of the step.
        step: usize,
        /// How it ended.
        status: Status,
        /// Part of its ramp that was reached.
        fraction: f64,
        /// What it looks like, where that is known.
        cause: Option<Cause>,
    },
}

/// The ends of all steps of a design, or why there is none.
pub type Outcome = Result<Vec<EndState>, Reason>;

/// Solves all designs, on the threads of the caller's pool; answers come in their order, and do not depend on how many there are.
///
/// Neighbours in the list are solved together where they have the same number of nodes, members, supports and steps;
/// designs with gravity or with steps that follow an arc or jump are solved alone. A singular point on the way is no
/// failure, as in [`crate::solve`].
pub fn solve(designs: &[Design]) -> Vec<Outcome> {
    let groups: Vec<&[Design]> = groups(designs).collect();
    groups.par_iter().flat_map_iter(|group| solve_group(group)).collect()
}

/// The histories of designs that reach the ends of all their steps without a singular point; nothing for those that
/// have to be looked at alone.
///
/// Neighbours are grouped as in [`solve`]. The states of a history are those of its design; energy, residual, balance
/// and numbers of iterations are those of its group, and it has no notes.
pub fn histories(
    designs: &[Design],
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Vec<Option<History>> {
    let mut all = Vec::with_capacity(designs.len());
    for group in groups(designs) {
        let solved = if group.len() > 1 { together(group, options, observe) } else { None };
        match solved {
            Some(history) => all.extend(shares(group, &history).map(|(share, feeble)| (!feeble).then_some(share))),
            None => all.extend(group.iter().map(|_| None)),
        }
    }
    all
}

/// Neighbours that are solved together.
fn groups(designs: &[Design]) -> impl Iterator<Item = &[Design]> {
    designs.chunk_by(alike).flat_map(|run| run.chunks(if run.iter().all(joins) { TOGETHER } else { 1 }))
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
    let compliances = !design.structure.compliances.is_empty();
    let plain = design.steps.iter().all(|step| step.method == Method::Newton && step.stop.is_none());
    !gravity && !compliances && plain
}

fn solve_group(group: &[Design]) -> Vec<Outcome> {
    if let [design] = group {
        return vec![alone(design)];
    }
    match together(group, &Options::default(), &mut |_| true) {
        Some(history) => shares(group, &history)
            .zip(group)
            .map(|((share, feeble), design)| if feeble { alone(design) } else { Ok(ends_of(&share)) })
            .collect(),
        None => group.iter().map(alone).collect(),
    }
}

/// The history of several designs in one structure, where it tells what becomes of each.
fn together(group: &[Design], options: &Options, observe: &mut dyn FnMut(&Progress) -> bool) -> Option<History> {
    let (structure, steps) = join(group.iter().map(|design| (design.structure.clone(), design.steps.clone())))?;
    let options = Options { stop_unstable: true, ..options.clone() };
    let history = crate::solve(&structure, &steps, &options, observe).ok()?;
    (history.inside.is_empty() && history.steps.iter().all(clean)).then_some(history)
}

/// Every design's share of a history, and whether its forces are too small beside those of others.
fn shares<'a>(group: &'a [Design], history: &'a History) -> impl Iterator<Item = (History, bool)> + 'a {
    let largest = largest_force(history);
    let mut at = [0; 4];
    group.iter().map(move |Design { structure, .. }| {
        let counts =
            [structure.nodes.len(), structure.members.len(), structure.springs.len(), structure.sections.len()];
        let ranges: [_; 4] = std::array::from_fn(|kind| at[kind]..at[kind] + counts[kind]);
        at = ranges.each_ref().map(|range| range.end);
        let share = share(history, &ranges);
        let feeble = largest_force(&share) < FEEBLE * largest;
        (share, feeble)
    })
}

fn largest_force(history: &History) -> f64 {
    let states = history.steps.iter().filter_map(|step| step.increments.last());
    let forces = states.flat_map(|increment| &increment.state.members).flat_map(|member| member.end_forces);
    forces.flatten().fold(0.0, |largest, force| largest.max(force.abs()))
}

/// What belongs to these nodes, members, springs and members with sections.
fn share(history: &History, [nodes, members, springs, sections]: &[std::ops::Range<usize>; 4]) -> History {
    let state = |all: &Equilibrium| Equilibrium {
        nodes: all.nodes[nodes.clone()].to_vec(),
        members: all.members[members.clone()].to_vec(),
        springs: all.springs[springs.clone()].to_vec(),
        sections: all.sections[sections.clone()].to_vec(),
        rounding: None,
        compliances: Vec::new(),
        ..*all
    };
    let steps = history.steps.iter().map(|step| StepHistory {
        increments: step
            .increments
            .iter()
            .map(|increment| Increment { state: state(&increment.state), shapes: Vec::new(), ..*increment })
            .collect(),
        refined: step.refined.as_ref().map(state),
        missing: step.missing.get(members.clone()).unwrap_or_default().to_vec(),
        variations: step.variations.get(members.clone()).unwrap_or_default().to_vec(),
        notes: Vec::new(),
        critical_points: Vec::new(),
        jumps: Vec::new(),
        failure: None,
        ..*step
    });
    History { steps: steps.collect(), ..History::default() }
}

/// Whether a step of several designs tells what becomes of each.
fn clean(step: &StepHistory) -> bool {
    step.status == Status::Converged && step.critical_points.is_empty() && step.negative_pivots == 0
}

fn alone(design: &Design) -> Outcome {
    let solved = crate::solve(&design.structure, &design.steps, &Options::default(), &mut |_| true);
    let history = solved.map_err(Reason::Refused)?;
    match history.steps.iter().position(|step| step.status != Status::Converged) {
        None => Ok(ends_of(&history)),
        Some(index) => {
            let step = &history.steps[index];
            let cause = step.failure.as_ref().map(|failure| failure.cause);
            Err(Reason::Stopped { step: index, status: step.status, fraction: step.fraction, cause })
        }
    }
}

fn ends_of(history: &History) -> Vec<EndState> {
    let last = history.steps.iter().filter_map(|step| step.increments.last());
    last.map(|Increment { state, .. }| EndState { nodes: state.nodes.clone(), members: state.members.clone() })
        .collect()
}
