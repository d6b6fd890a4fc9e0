//! One design: its structure on the common mesh, and what a solve of it says.

use pennate_models::{Model, discretize};
use pennate_solver::history::{History, Note, Status, StepHistory};
use pennate_solver::options::Options;
use pennate_solver::structure::{Step, Structure};

use super::group::Answer;
use super::{Control, Problem, Reason, mesh, outputs};
use crate::solution::{self, ProbeTable};
use crate::together::Posed;

/// Gives every member that follows a drive the laws of the pieces that the drives lie on: they go on beyond the corners of
/// tables.
pub(super) fn take_pieces(structure: &mut Structure, drives: &[f64]) {
    for member in &mut structure.members {
        let Some(control) = member.control else { continue };
        for segment in &mut member.segments {
            if let Some(piece) = structure.laws[segment.law].piece(drives[control]) {
                segment.law = structure.laws.len();
                structure.laws.push(piece);
            }
        }
    }
}

/// A design on the mesh of its problem.
pub(super) struct Design {
    pub model: Model,
    pub structure: Structure,
    /// Those that the outputs need.
    pub steps: Vec<Step>,
    /// Whether another model may be evaluated in this one.
    pub may_serve: bool,
}

impl Design {
    /// What is solved.
    pub(super) fn posed(&self) -> Posed<'_> {
        (&self.structure, &self.steps)
    }

    /// Components that a step holds where they are, or moves on from there.
    pub(super) fn kept_by(&self, step: usize) -> Vec<(usize, usize)> {
        self.steps.get(step).into_iter().flat_map(Step::kept).collect()
    }

    /// Those of the step after one.
    pub(super) fn kept_after(&self, index: usize) -> Vec<(usize, usize)> {
        self.kept_by(index + 1)
    }
}

impl Problem {
    /// The design of a row of values.
    pub(super) fn design(&self, row: &[f64]) -> Result<Design, Reason> {
        Ok(self.design_of(self.model(row)?))
    }

    /// A design that tells how the one beside it changes.
    pub(super) fn design_beside(&self, row: &[f64]) -> Result<Design, Reason> {
        Ok(self.design_of(self.model_beside(row)?))
    }

    /// The same in the memory of the model of another design, where there is one to spare.
    pub(super) fn design_in(&self, row: &[f64], spare: Option<Model>) -> Result<Design, Reason> {
        let mut may_serve = true;
        let model = self.evaluated(row, |reading, values| match reading.model_again(values, spare) {
            Some(model) => Ok(model),
            None => {
                may_serve = false;
                reading.model(values)
            }
        })?;
        Ok(Design { may_serve, ..self.design_of(model) })
    }

    fn design_of(&self, model: Model) -> Design {
        let (mut structure, mut steps) = discretize(&model, &mesh::fitted(&self.mesh, &self.middle, &model));
        steps.truncate(self.steps());
        if !outputs::need_stiffness(&model.probes, &self.outputs) {
            structure.compliances.clear();
        }
        Design { model, structure, steps, may_serve: false }
    }

    /// The outputs of a row of values, as far as its steps went, and why they went no farther.
    pub(super) fn solve(&self, row: &[f64], control: &Control) -> Answer {
        match self.design(row) {
            Ok(design) => self.solve_design(&design, control),
            Err(reason) => Answer::nothing(self.outputs.len(), reason),
        }
    }

    /// The same of a design.
    pub(super) fn solve_design(&self, design: &Design, control: &Control) -> Answer {
        let options = Options { stop: control.stop.clone(), ..Options::default() };
        let wanted = || !control.is_stopped();
        match pennate_solver::solve(&design.structure, &design.steps, &options, &mut |_| wanted()) {
            Ok(mut history) => self.read(&design.model, &mut history),
            Err(error) => Answer::nothing(self.outputs.len(), error.into()),
        }
    }

    /// The outputs in a history, and why it ends early.
    pub(super) fn read(&self, model: &Model, history: &mut History) -> Answer {
        self.mesh.name_segments(model, history);
        let failed = history.steps.iter().position(|step| step.status != Status::Converged);
        let table = ProbeTable::new(model, history);
        let reached = failed.unwrap_or(history.steps.len());
        let reason = failed.map(|index| {
            let step = &history.steps[index];
            match step.status {
                Status::Interrupted => Reason::Interrupted,
                status => {
                    let cause = step.failure.as_ref().map(|failure| failure.cause);
                    Reason::Stopped { step: index, status, fraction: step.fraction, cause }
                }
            }
        });
        let unbalanced = || history.steps.iter().position(is_unbalanced).map(|step| Reason::Unbalanced { step });
        let reason = reason.or_else(unbalanced);
        let values = outputs::values(&table, &self.outputs, reached);
        Answer { values, reason, stable: solution::stable(history) }
    }
}

/// Whether a moment at the end of a step is taken by nothing.
pub(super) fn is_unbalanced(step: &StepHistory) -> bool {
    step.notes.iter().any(|note| matches!(note, Note::Untaken { .. }))
}
