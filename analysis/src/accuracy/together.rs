//! Networks of one topology, solved side by side.

use pennate_models::{Mesh, Model, discretize};
use pennate_solver::history::{History, Increment, Status, StepHistory};
use pennate_solver::structure::{Dimension, Step, Structure};

use super::error::relative_error;
use super::judge::every_end_is_estimated;
use crate::solution::{ProbeTable, stable};
use crate::together::{self, Asked, End, Look, Posed, TOGETHER};

/// A structure and its steps.
type Design = (Structure, Vec<Step>);

/// Solves networks of one topology side by side on the meshes that their accuracy should need, without what they share
/// more than once; nothing for those that need more than that, which [`super::solve_to_accuracy`] has to solve.
pub(crate) fn solve_together(models: &[&Model], asked: f64, wanted: &dyn Fn() -> bool) -> Vec<Option<Shared>> {
    let meshes: Vec<Mesh> = models.iter().map(|model| Mesh::initial(model, asked)).collect();
    let large = models.iter().zip(&meshes).any(|(model, mesh)| mesh.of_the_way(model, asked).is_some());
    if large {
        return models.iter().map(|_| None).collect();
    }
    let designs: Vec<Design> = models.iter().zip(&meshes).map(|(model, mesh)| discretize(model, mesh)).collect();
    let histories = histories(&designs, wanted);
    let judged = models.iter().zip(&meshes).zip(&designs).zip(histories).map(|(((model, mesh), design), history)| {
        let (structure, _) = design;
        let history = history?;
        let probes = ProbeTable::new(model, &history);
        let error = relative_error(model, structure, &history, &probes)?;
        let states: Vec<_> = history.steps.iter().map(|step| step.variations.as_slice()).collect();
        let resolved = every_end_is_estimated(&history) && !mesh.graded(model, &states, asked).unresolved;
        let stable = stable(&history);
        (error <= asked && resolved).then_some(Shared { probes, error, stable })
    });
    judged.collect()
}

/// What came of a network that was solved together with others: all its steps converged.
#[derive(Clone, Debug)]
pub struct Shared {
    /// The probes at the ends of its steps.
    pub probes: ProbeTable,
    /// Estimated error relative to the largest value of its kind.
    pub error: f64,
    /// Whether the ends of all steps are stable, see [`stable`].
    pub stable: Option<bool>,
}

/// The ends of the steps of designs with what their errors are estimated by, as histories of one increment a step without numbers
/// of iterations or notes; nothing for those that have to be looked at alone, or that nobody waits for any longer.
fn histories(designs: &[Design], wanted: &dyn Fn() -> bool) -> Vec<Option<History>> {
    let asked = Asked { look: &|_| Look::Error, wanted };
    let solve = |group: &[Design]| match group {
        [_] => vec![None],
        _ => {
            let posed: Vec<Posed<'_>> = group.iter().map(|(structure, steps)| (structure, steps.as_slice())).collect();
            together::solve(&posed, &asked, None)
        }
    };
    let ends = designs.chunk_by(alike).flat_map(|run| run.chunks(TOGETHER)).flat_map(solve);
    let history = |((structure, _), ends): (&Design, Option<Vec<Option<End>>>)| {
        let record = |end| record(end, structure.dimension);
        Some(History { steps: ends?.into_iter().flatten().map(record).collect(), ..History::default() })
    };
    designs.iter().zip(ends).map(history).collect()
}

/// Whether two designs have one topology.
fn alike((x, of_x): &Design, (y, of_y): &Design) -> bool {
    let mut members = x.members.iter().zip(&y.members);
    x.dimension == y.dimension
        && x.nodes.len() == y.nodes.len()
        && x.members.len() == y.members.len()
        && x.supports.len() == y.supports.len()
        && of_x.len() == of_y.len()
        && members.all(|(a, b)| (a.nodes, a.segments.len(), a.order) == (b.nodes, b.segments.len(), b.order))
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
