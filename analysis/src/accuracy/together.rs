//! Networks of one topology, solved side by side.

use pennate_models::{Mesh, Model, discretize};

use super::error::relative_error;
use super::judge::every_end_is_estimated;
use crate::batch::{self, Design};
use crate::solution::{ProbeTable, stable};

/// Solves networks of one topology side by side on the meshes that their accuracy should need, without what they share
/// more than once; nothing for those that need more than that, which [`super::solve_to_accuracy`] has to solve.
pub(crate) fn solve_together(models: &[&Model], asked: f64, wanted: &dyn Fn() -> bool) -> Vec<Option<Shared>> {
    let meshes: Vec<Mesh> = models.iter().map(|model| Mesh::initial(model, asked)).collect();
    let large = models.iter().zip(&meshes).any(|(model, mesh)| mesh.of_the_way(model, asked).is_some());
    if large {
        return models.iter().map(|_| None).collect();
    }
    let designs: Vec<Design> = models
        .iter()
        .zip(&meshes)
        .map(|(model, mesh)| {
            let (structure, steps) = discretize(model, mesh);
            Design { structure, steps }
        })
        .collect();
    let histories = batch::histories(&designs, wanted);
    let judged = models.iter().zip(&meshes).zip(&designs).zip(histories).map(|(((model, mesh), design), history)| {
        let history = history?;
        let probes = ProbeTable::new(model, &history);
        let error = relative_error(model, &design.structure, &history, &probes)?;
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
