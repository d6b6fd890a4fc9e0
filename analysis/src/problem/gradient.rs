//! Derivatives of the outputs by the parameters.

use pennate_solver::base::{self, Followed};
use pennate_solver::options::Options;
use pennate_solver::packs;
use rayon::prelude::*;

use super::slopes::Slopes;
use super::{Control, Problem, Reason};

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

impl Problem {
    /// The outputs of some designs and their derivatives: `x` has one row of k values a design.
    ///
    /// Derivatives are those of the equilibrium on the mesh, by every parameter: geometry, sections, tables of muscles, loads,
    /// pressures, springs, what steps prescribe. They are found by the adjoint method: one solve with the factors of the
    /// equilibrium for every output, and for every parameter the forces of the parts that it reaches. Where
    /// supports in turned axes hold a node partly, or an output is read from more than motions and reactions, they are differences
    /// of equilibria a thousandth of a parameter apart, which the factors at hand lead to; two distances tell whether these
    /// are to be trusted, and shorter ones are tried where they are not. Next to a limit point, where derivatives grow without
    /// bound, there is a reason in place of numbers.
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
        let each = |row: &&[f64]| self.gradient_of(row, control);
        let all: Vec<Row> = self.rows(x).par_iter().map(each).collect();
        let mut derivatives =
            Derivatives { values: Vec::new(), jacobian: Vec::new(), reasons: Vec::new(), stable: Vec::new() };
        for row in all {
            derivatives.values.extend(row.values);
            derivatives.jacobian.extend(row.jacobian);
            derivatives.reasons.push(row.reason);
            derivatives.stable.push(row.stable);
        }
        derivatives
    }

    fn gradient_of(&self, row: &[f64], control: &Control) -> Row {
        let (outputs, inputs) = (self.outputs.len(), self.inputs.len());
        let nothing = |reason| Row {
            values: vec![f64::NAN; outputs],
            jacobian: vec![f64::NAN; outputs * inputs],
            reason: Some(reason),
            stable: None,
        };
        let design = match self.design(row) {
            Ok(design) => design,
            Err(reason) => return nothing(reason),
        };
        let options = Options { stop: control.stop.clone(), ..Options::default() };
        let (structure, steps) = (&design.structure, &design.steps);
        let mut wanted = |_: &_| !control.is_stopped();
        let first = steps.len().min(1);
        match base::follow(structure, steps, first, &options, &mut wanted) {
            Err(error) => nothing(error.into()),
            Ok((Followed::Plane(path), history)) => {
                Slopes::new(self, row, &design, control).run(*path, packs::plane, history)
            }
            Ok((Followed::Space(path), history)) => {
                Slopes::new(self, row, &design, control).run(*path, packs::space, history)
            }
        }
    }
}
