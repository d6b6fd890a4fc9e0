//! Many designs at once.

use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::{Control, Problem, Reason};

/// Answers of some designs.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// Rows of outputs, one a design: n × m. Not a number where there is no answer.
    pub values: Vec<f64>,
    /// Why a design has no answer, or not all of it.
    pub reasons: Vec<Option<Reason>>,
}

impl Problem {
    /// The outputs of some designs: `x` has one row of k values a design, the answer one row of m.
    ///
    /// Designs are solved on the threads of the current pool; an answer depends neither on the others nor on their order nor
    /// on the number of threads.
    ///
    /// # Panics
    /// Where the length of `x` is no multiple of the number of parameters.
    pub fn evaluate(&self, x: &[f64]) -> Evaluation {
        self.evaluate_while(x, &Control::default())
    }

    /// The same, which may be stopped on the way.
    ///
    /// # Panics
    /// As [`Problem::evaluate`].
    pub fn evaluate_while(&self, x: &[f64], control: &Control) -> Evaluation {
        let rows = self.rows(x);
        let each = |row: &&[f64]| {
            if control.is_stopped() {
                return (vec![f64::NAN; self.outputs.len()], Some(Reason::Interrupted));
            }
            self.solve(row, control)
        };
        let answers: Vec<(Vec<f64>, Option<Reason>)> = rows.par_iter().map(each).collect();
        let (values, reasons): (Vec<Vec<f64>>, _) = answers.into_iter().unzip();
        Evaluation { values: values.concat(), reasons }
    }

    /// The outputs of one design by the ordinary solver, as far as its steps went, and why they went no farther.
    pub fn evaluate_alone(&self, row: &[f64]) -> (Vec<f64>, Option<Reason>) {
        self.solve(row, &Control::default())
    }

    /// Rows of values, one a design. Without parameters there is one design.
    pub(super) fn rows<'a>(&self, x: &'a [f64]) -> Vec<&'a [f64]> {
        let width = self.inputs.len();
        if width == 0 {
            return vec![&[]];
        }
        assert!(x.len().is_multiple_of(width), "{} values are no rows of {width} parameters", x.len());
        x.chunks_exact(width).collect()
    }
}

impl Control {
    /// Whether nobody wants to wait any longer.
    pub(super) fn is_stopped(&self) -> bool {
        self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed))
    }
}
