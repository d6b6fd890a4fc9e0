//! Derivatives of the outputs by the parameters.

use rayon::prelude::*;

use super::{Control, Problem, Reason};

/// Answers of some designs with their derivatives.
#[derive(Clone, Debug)]
pub struct Derivatives {
    /// Rows of outputs, one a design: n × m. Not a number where there is no answer.
    pub values: Vec<f64>,
    /// Derivatives of every output by every parameter: n × m × k. Not a number where there is none.
    pub jacobian: Vec<f64>,
    /// Why a design has no answer, or not all of it.
    pub reasons: Vec<Option<Reason>>,
}

/// Part of a parameter by which designs are apart.
const APART: f64 = 1e-4;

impl Problem {
    /// The outputs of some designs and their derivatives: `x` has one row of k values a design.
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
        let all: Vec<_> = self.rows(x).par_iter().map(each).collect();
        let mut derivatives = Derivatives { values: Vec::new(), jacobian: Vec::new(), reasons: Vec::new() };
        for (values, jacobian, reason) in all {
            derivatives.values.extend(values);
            derivatives.jacobian.extend(jacobian);
            derivatives.reasons.push(reason);
        }
        derivatives
    }

    /// By central differences of converged solves.
    fn gradient_of(&self, row: &[f64], control: &Control) -> (Vec<f64>, Vec<f64>, Option<Reason>) {
        let (outputs, inputs) = (self.outputs.len(), self.inputs.len());
        let (values, mut reason) = self.solve(row, control);
        let mut jacobian = vec![f64::NAN; outputs * inputs];
        for parameter in 0..inputs {
            let apart = APART * if row[parameter] == 0.0 { 1.0 } else { row[parameter].abs() };
            let at = |by: f64| {
                let mut moved = row.to_vec();
                moved[parameter] += by;
                self.solve(&moved, control)
            };
            let ((ahead, first), (behind, second)) = (at(apart), at(-apart));
            for output in 0..outputs {
                jacobian[output * inputs + parameter] = (ahead[output] - behind[output]) / (2.0 * apart);
            }
            reason = reason.or(first).or(second);
        }
        (values, jacobian, reason)
    }
}
