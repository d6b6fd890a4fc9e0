//! Neighbours in the list of designs, side by side where they go the plain way.

use pennate_models::probes::ProbeKind;

use super::design::Design;
use super::{Control, Problem, Reason};
use crate::together::{self, Asked, End, Found, Look, Posed, Workspace};

/// What is known of a design.
pub(super) struct Answer {
    /// The outputs, as far as its steps went.
    pub values: Vec<f64>,
    /// Why they went no farther.
    pub reason: Option<Reason>,
    /// Whether the ends of its steps are stable; `None` where nobody can say.
    pub stable: Option<bool>,
}

impl Answer {
    /// No value, for a reason.
    pub(super) fn nothing(outputs: usize, reason: Reason) -> Self {
        Self { values: vec![f64::NAN; outputs], reason: Some(reason), stable: None }
    }
}

impl Problem {
    /// The answers of a group of designs, in order.
    pub(super) fn solve_group(&self, rows: &[&[f64]], control: &Control, workspace: &mut Workspace) -> Vec<Answer> {
        let nothing = |reason| Answer::nothing(self.outputs.len(), reason);
        let design = |row: &&[f64]| self.design_in(row, workspace.models.pop());
        let designs: Vec<Result<Design, Reason>> = rows.iter().map(design).collect();
        let sound: Vec<&Design> = designs.iter().flatten().collect();
        let mut values = self.solve_together(&sound, control, workspace).into_iter();
        let answer = |design: Result<Design, Reason>| match design {
            Err(reason) => nothing(reason),
            Ok(design) => {
                let answer = match values.next().flatten() {
                    // Side by side nothing goes beyond a state that is not stable.
                    Some(values) => Answer { values, reason: None, stable: Some(true) },
                    None => self.solve_design(&design, control),
                };
                workspace.models.extend(Some(design.model).filter(|_| design.may_serve));
                answer
            }
        };
        designs.into_iter().map(answer).collect()
    }

    /// The outputs of some designs; nothing for those that have to be solved alone.
    fn solve_together(
        &self,
        designs: &[&Design],
        control: &Control,
        workspace: &mut Workspace,
    ) -> Vec<Option<Vec<f64>>> {
        let own = if self.middle.probes.measure_members() { Look::State } else { Look::Nodes };
        let look = |step| if self.reads(step) { own } else { Look::Not };
        let found = self.find_together(designs, &look, control, workspace).into_iter();
        let outputs =
            |(design, found): (&&Design, Option<Found>)| found.map(|found| self.outputs_of(design, &found.ends));
        designs.iter().zip(found).map(outputs).collect()
    }

    /// What is looked at of some designs; nothing for those that have to be solved alone.
    pub(super) fn find_together(
        &self,
        designs: &[&Design],
        look: &dyn Fn(usize) -> Look,
        control: &Control,
        workspace: &mut Workspace,
    ) -> Vec<Option<Found>> {
        // Segments of graded members have to be named, which histories alone are.
        if !self.mesh.grading.is_empty() && designs.iter().any(|design| !design.structure.sections.is_empty()) {
            return designs.iter().map(|_| None).collect();
        }
        let posed: Vec<Posed<'_>> = designs.iter().map(|design| design.posed()).collect();
        let asked = Asked { look, wanted: &|| !control.is_stopped() };
        together::find(&posed, &asked, Some(workspace))
    }

    /// Whether the end of a step is looked at: an expression may refer to any step before.
    pub(super) fn reads(&self, step: usize) -> bool {
        let probes = &self.middle.probes;
        let refers = |probe| probes.kind(probe) == ProbeKind::Other && !probes.is_stiffness(probe);
        self.outputs.iter().any(|output| output.step == step || output.step > step && refers(output.probe))
    }

    /// The outputs of a design at the ends of its steps.
    fn outputs_of(&self, design: &Design, ends: &[Option<End>]) -> Vec<f64> {
        let mut after: Vec<Vec<f64>> = Vec::with_capacity(ends.len());
        for end in ends {
            let values = match end {
                Some(end) => design.model.probes.evaluate(&end.state, &after),
                None => vec![f64::NAN; design.model.probes.len()],
            };
            after.push(values);
        }
        self.outputs.iter().map(|output| after[output.step][output.probe]).collect()
    }
}
