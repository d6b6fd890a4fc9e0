//! Many designs of one topology, solved side by side.
//!
//! Designs that differ in geometry, sections or loads alone go a few at a time in the lanes of the processor. They need not take
//! the same way, so those whose way is not plain are solved alone, each as any other structure is; what becomes of them there
//! is their answer. Whether an increment led to another state than the one nearby is judged for every design by itself.

use pennate_solver::error::SolveError;
use pennate_solver::history::{Cause, History, Increment, MemberState, NodeState, Status, StepHistory};
use pennate_solver::options::Options;
use pennate_solver::structure::{Dimension, Step, Structure};
use rayon::prelude::*;

use crate::together::{self, Asked, End, Look, Posed, TOGETHER};

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
/// Neighbours in the list are solved together where they have the same number of nodes, members, supports and steps. A singular
/// point on the way is no failure, as in [`pennate_solver::solve`].
pub fn solve(designs: &[Design]) -> Vec<Outcome> {
    let groups: Vec<&[Design]> = groups(designs).collect();
    groups.par_iter().flat_map_iter(|group| solve_group(group)).collect()
}

fn solve_group(group: &[Design]) -> Vec<Outcome> {
    let asked = Asked { look: &|_| Look::State, wanted: &|| true };
    let ends = together::solve(&posed(group), &asked, None);
    group.iter().zip(ends).map(|(design, ends)| ends.map_or_else(|| alone(design), |ends| Ok(ends_of(ends)))).collect()
}

fn ends_of(ends: Vec<Option<End>>) -> Vec<EndState> {
    ends.into_iter()
        .flatten()
        .map(|End { state, .. }| EndState { nodes: state.nodes, members: state.members })
        .collect()
}

/// The ends of the steps of designs with what their errors are estimated by, as histories of one increment a step without numbers
/// of iterations or notes; nothing for those that have to be looked at alone, or that nobody waits for any longer.
pub(crate) fn histories(designs: &[Design], wanted: &dyn Fn() -> bool) -> Vec<Option<History>> {
    let asked = Asked { look: &|_| Look::Error, wanted };
    let solve = |group: &[Design]| match group {
        [_] => vec![None],
        _ => together::solve(&posed(group), &asked, None),
    };
    let ends = groups(designs).flat_map(solve);
    let history = |(design, ends): (&Design, Option<Vec<Option<End>>>)| {
        let record = |end| record(end, design.structure.dimension);
        Some(History { steps: ends?.into_iter().flatten().map(record).collect(), ..History::default() })
    };
    designs.iter().zip(ends).map(history).collect()
}

/// Side by side nothing goes beyond a state that is not stable.
fn record(End { state, finer }: End, dimension: Dimension) -> StepHistory {
    let increments = vec![Increment { fraction: 1.0, state, shapes: Vec::new() }];
    let (refined, missing, variations) = match finer {
        Some(finer) => (Some(finer.state), finer.missing, finer.variations),
        None => Default::default(),
    };
    let (status, stable) = (Status::Converged, Some(true));
    StepHistory {
        status,
        fraction: 1.0,
        increments,
        refined,
        missing,
        variations,
        stable,
        ..StepHistory::empty(dimension)
    }
}

fn posed(group: &[Design]) -> Vec<Posed<'_>> {
    group.iter().map(|design| (&design.structure, design.steps.as_slice())).collect()
}

/// Neighbours that are solved together.
fn groups(designs: &[Design]) -> impl Iterator<Item = &[Design]> {
    designs.chunk_by(alike).flat_map(|run| run.chunks(TOGETHER))
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

fn alone(design: &Design) -> Outcome {
    let solved = pennate_solver::solve(&design.structure, &design.steps, &Options::default(), &mut |_| true);
    let history = solved.map_err(Reason::Refused)?;
    match history.steps.iter().position(|step| step.status != Status::Converged) {
        None => Ok(last_states(&history)),
        Some(index) => {
            let step = &history.steps[index];
            let cause = step.failure.as_ref().map(|failure| failure.cause);
            Err(Reason::Stopped { step: index, status: step.status, fraction: step.fraction, cause })
        }
    }
}

fn last_states(history: &History) -> Vec<EndState> {
    let last = history.steps.iter().filter_map(|step| step.increments.last());
    last.map(|Increment { state, .. }| EndState { nodes: state.nodes.clone(), members: state.members.clone() })
        .collect()
}
