//! Neighbours in the list of designs, side by side where they go the plain way.

use std::fmt;
use std::sync::{Mutex, PoisonError};

use pennate_models::probes::ProbeKind;
use pennate_solver::history::Equilibrium;
use pennate_solver::joints::Active;
use pennate_solver::structure::{Dimension, Step, Structure};

use super::design::Design;
use super::join::{self, Share};
use super::together::{self, Analysed};
use super::track::{self, Kind};
use super::{Control, Problem, Reason};

const PLANE: Active<3> = [0, 1, 5];
const SPACE: Active<6> = [0, 1, 2, 3, 4, 5];
/// Forces of a design smaller than this part of the largest of its group are not looked at closely enough there.
const FEEBLE: f64 = 1e-2;

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

/// What is kept from one group to the next: analyses of equations, which no answer depends on.
#[derive(Default)]
pub(super) struct Workspace {
    plane: Analysed<3>,
    space: Analysed<6>,
}

/// Those that no thread uses at present: as many as threads did at once.
#[derive(Default)]
pub(super) struct Workspaces(Mutex<Vec<Workspace>>);

impl Workspaces {
    pub(super) fn take(&self) -> Workspace {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default()
    }

    pub(super) fn give_back(&self, workspace: Workspace) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(workspace);
    }
}

impl fmt::Debug for Workspaces {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Workspaces")
    }
}

impl Problem {
    /// The answers of a group of designs, in order.
    pub(super) fn solve_group(&self, rows: &[&[f64]], control: &Control, workspace: &mut Workspace) -> Vec<Answer> {
        let nothing = |reason| Answer::nothing(self.outputs.len(), reason);
        if control.is_stopped() {
            return rows.iter().map(|_| nothing(Reason::Interrupted)).collect();
        }
        let designs: Vec<Result<Design, Reason>> = rows.iter().map(|row| self.design(row)).collect();
        let plain: Vec<&Design> = designs.iter().flatten().filter(|design| self.is_plain(design)).collect();
        let shared = plain.iter().all(|design| together::joins(&design.structure));
        let mut values: Vec<Option<Vec<f64>>> = match shared {
            true => self.solve_together(&plain, workspace),
            false => plain.iter().flat_map(|design| self.solve_together(&[*design], workspace)).collect(),
        };
        values.reverse();
        let answer = |design: Result<Design, Reason>| match design {
            Err(reason) => nothing(reason),
            Ok(design) => {
                let values = if self.is_plain(&design) { values.pop().flatten() } else { None };
                match values {
                    // Side by side nothing goes beyond a state that is not stable.
                    Some(values) => Answer { values, reason: None, stable: Some(true) },
                    None => self.solve_design(&design, control),
                }
            }
        };
        designs.into_iter().map(answer).collect()
    }

    fn is_plain(&self, design: &Design) -> bool {
        let graded = !self.mesh.grading.is_empty() && !design.structure.sections.is_empty();
        !graded && together::is_plain(&design.structure, &design.steps)
    }

    /// The outputs of designs of one group; nothing for those that have to be solved alone.
    fn solve_together(&self, designs: &[&Design], workspace: &mut Workspace) -> Vec<Option<Vec<f64>>> {
        let all = designs.iter().map(|design| (design.structure.clone(), design.steps.clone())).collect();
        let Some((structure, steps, shares)) = join::join(all) else { return Vec::new() };
        let count = designs.len();
        let states = match structure.dimension {
            Dimension::Plane => {
                let analysed = workspace.plane.entry(count).or_default();
                self.states(structure, &steps, (PLANE, &track::plane()), analysed)
            }
            Dimension::Space => {
                let analysed = workspace.space.entry(count).or_default();
                self.states(structure, &steps, (SPACE, &track::space()), analysed)
            }
        };
        let Some(states) = states else {
            // One of them is doubtful: others need not wait for it.
            let (first, second) = designs.split_at(count / 2);
            if first.is_empty() {
                return vec![None];
            }
            let mut found = self.solve_together(first, workspace);
            found.extend(self.solve_together(second, workspace));
            return found;
        };
        designs.iter().zip(&shares).map(|(design, share)| self.outputs_of(design, share, &shares, &states)).collect()
    }

    fn states<const D: usize>(
        &self,
        structure: Structure,
        steps: &[Step],
        of: (Active<D>, &Kind<D>),
        analysed: &mut Vec<pennate_solver::system::System<D>>,
    ) -> Option<Vec<Option<Equilibrium>>> {
        together::solve(structure, steps, of, analysed, &|step| self.reads(step))
    }

    /// Whether the end of a step is looked at: an expression may refer to any step before.
    pub(super) fn reads(&self, step: usize) -> bool {
        let probes = &self.middle.probes;
        let refers = |probe| probes.kind(probe) == ProbeKind::Other && !probes.is_stiffness(probe);
        self.outputs.iter().any(|output| output.step == step || output.step > step && refers(output.probe))
    }

    /// The outputs of one design of a group; nothing where its forces are small beside those of others.
    fn outputs_of(
        &self,
        design: &Design,
        share: &Share,
        all: &[Share],
        states: &[Option<Equilibrium>],
    ) -> Option<Vec<f64>> {
        let mut after: Vec<Vec<f64>> = Vec::with_capacity(states.len());
        for state in states {
            let Some(state) = state else {
                after.push(vec![f64::NAN; design.model.probes.len()]);
                continue;
            };
            let largest = all.iter().map(|share| share.largest_force(state)).fold(0.0, f64::max);
            if share.largest_force(state) < FEEBLE * largest {
                return None;
            }
            let values = design.model.probes.evaluate(&share.of(state), &after);
            after.push(values);
        }
        Some(self.outputs.iter().map(|output| after[output.step][output.probe]).collect())
    }
}
