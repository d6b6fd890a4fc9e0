//! Derivatives of the outputs by the parameters.

use std::iter::repeat_n;

use pennate_solver::base::{self, Followed};
use pennate_solver::options::Options;
use pennate_solver::packs;
use rayon::prelude::*;

use super::design::Design;
use super::slopes::Slopes;
use super::{Control, Problem, Reason};
use crate::together::{Look, TOGETHER, Workspace};

/// Answers of some designs with their derivatives.
#[derive(Clone, Debug)]
pub struct Derivatives {
    /// Rows of outputs, one a design: n × m. Not a number where there is no answer.
    pub values: Vec<f64>,
    /// Derivatives of every output by every parameter: n × m × k, in the units of the output over those of the parameter. Not
    /// a number where there is none.
    pub jacobian: Vec<f64>,
    /// Why a design has no answer, or not all of it, or no derivatives.
    pub reasons: Vec<Option<Reason>>,
    /// Whether the ends of all steps of a design that got somewhere are stable; `None` where nobody can say.
    pub stable: Vec<Option<bool>>,
}

/// What becomes of one design.
pub(super) struct Row {
    pub values: Vec<f64>,
    pub jacobian: Vec<f64>,
    pub reason: Option<Reason>,
    pub stable: Option<bool>,
}

impl Derivatives {
    fn push(&mut self, row: Row) {
        self.values.extend(row.values);
        self.jacobian.extend(row.jacobian);
        self.reasons.push(row.reason);
        self.stable.push(row.stable);
    }

    /// So many designs that nobody waited for: there may be millions.
    fn push_interrupted(&mut self, designs: usize, outputs: usize, inputs: usize) {
        self.values.extend(repeat_n(f64::NAN, designs * outputs));
        self.jacobian.extend(repeat_n(f64::NAN, designs * outputs * inputs));
        self.reasons.extend(repeat_n(Some(Reason::Interrupted), designs));
        self.stable.extend(repeat_n(None, designs));
    }
}

impl Problem {
    /// The outputs of some designs and their derivatives: `x` has one row of k values a design.
    ///
    /// Derivatives are those of the equilibrium on the mesh, by every parameter: geometry, sections, tables of muscles, loads,
    /// pressures, springs, what steps prescribe. They are found by the adjoint method: one solve with the factors of the
    /// equilibrium for every output, and for every parameter the forces of the parts that it reaches. Those of stiffnesses
    /// come from tangents on the way along each parameter. Where
    /// rows hold a turn in space in part, or an output is read from more than that, they are differences
    /// of equilibria a thousandth of a parameter apart, which the factors at hand lead to; three distances tell whether these
    /// are to be trusted, and shorter ones are tried where they are not. Every derivative has an estimated error:
    /// where one may be wrong by more than 10⁻⁷ of the largest of its output there is [`Reason::Inexact`] beside the numbers, and beyond 10⁻⁴ no
    /// number. Next to a limit point, where derivatives grow without bound, there is a reason in place of numbers.
    ///
    /// # Panics
    /// As [`Problem::evaluate`].
    pub fn gradient(&self, x: &[f64]) -> Derivatives {
        self.gradient_while(x, &Control::default())
    }

    /// The same, which may be stopped on the way.
    ///
    /// # Panics
    /// As [`Problem::evaluate`].
    pub fn gradient_while(&self, x: &[f64], control: &Control) -> Derivatives {
        let rows = self.rows(x);
        // Groups follow the order of the rows alone.
        let each = |group: &[&[f64]]| {
            if control.is_stopped() {
                return Err(group.len());
            }
            let mut workspace = self.workspaces.take();
            let found = self.gradients_of(group, control, &mut workspace);
            self.workspaces.give_back(workspace);
            Ok(found)
        };
        let groups: Vec<Result<Vec<Row>, usize>> = rows.par_chunks(TOGETHER).map(each).collect();
        let (designs, outputs, inputs) = (rows.len(), self.outputs.len(), self.inputs.len());
        let mut found = Derivatives {
            values: Vec::with_capacity(designs * outputs),
            jacobian: Vec::with_capacity(designs * outputs * inputs),
            reasons: Vec::with_capacity(designs),
            stable: Vec::with_capacity(designs),
        };
        for group in groups {
            match group {
                Ok(rows) => rows.into_iter().for_each(|row| found.push(row)),
                Err(left) => found.push_interrupted(left, outputs, inputs),
            }
        }
        found
    }

    /// Equilibria side by side, then the derivatives of one design after the other.
    fn gradients_of(&self, rows: &[&[f64]], control: &Control, workspace: &mut Workspace) -> Vec<Row> {
        let designs: Vec<Result<Design, Reason>> = rows.iter().map(|row| self.design(row)).collect();
        let sound: Vec<&Design> = designs.iter().flatten().collect();
        let look = |step| match sound.first() {
            Some(design) if self.reads(step) || !design.kept_after(step).is_empty() => Look::System,
            _ => Look::Not,
        };
        let mut found = self.find_together(&sound, &look, control, workspace).into_iter();
        let row = |(&row, design): (&&[f64], &Result<Design, Reason>)| {
            let design = match design {
                Ok(design) => design,
                Err(reason) => return self.no_gradient(reason.clone()),
            };
            let found = found.next().flatten();
            let slopes = found.and_then(|found| Slopes::new(self, row, design, control).run_together(&found));
            slopes.unwrap_or_else(|| self.gradient_of(row, design, control))
        };
        rows.iter().zip(&designs).map(row).collect()
    }

    fn no_gradient(&self, reason: Reason) -> Row {
        let (outputs, inputs) = (self.outputs.len(), self.inputs.len());
        Row {
            values: vec![f64::NAN; outputs],
            jacobian: vec![f64::NAN; outputs * inputs],
            reason: Some(reason),
            stable: None,
        }
    }

    /// The derivatives of a design along a path of its own.
    fn gradient_of(&self, row: &[f64], design: &Design, control: &Control) -> Row {
        if control.is_stopped() {
            return self.no_gradient(Reason::Interrupted);
        }
        let options = Options { stop: control.stop.clone(), ..Options::default() };
        let (structure, steps) = (&design.structure, &design.steps);
        let mut wanted = |_: &_| !control.is_stopped();
        let first = steps.len().min(1);
        match base::follow_judged(structure, steps, first, &options, &mut wanted) {
            Err(error) => self.no_gradient(error.into()),
            Ok((Followed::Plane(path), history)) => {
                Slopes::new(self, row, design, control).run(*path, packs::plane, history)
            }
            Ok((Followed::Space(path), history)) => {
                Slopes::new(self, row, design, control).run(*path, packs::space, history)
            }
        }
    }
}
