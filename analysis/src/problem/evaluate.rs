//! Many designs at once.

use std::iter::repeat_n;
use std::sync::atomic::Ordering;
use std::time::Instant;

use pennate_solver::options::Options;
use rayon::prelude::*;

use super::group::Answer;
use super::{Control, Output, Problem, Reason, outputs};
use crate::solution::ProbeTable;
use crate::together::TOGETHER;

/// Designs at most whose error is estimated for a batch.
const SAMPLE: usize = 8;

/// Answers of some designs.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// Rows of outputs, one a design: n × m. Not a number where there is no answer.
    pub values: Vec<f64>,
    /// Why a design has no answer, or not all of it.
    pub reasons: Vec<Option<Reason>>,
    /// Whether the ends of all steps of a design that got somewhere are stable; `None` where nobody can say.
    pub stable: Vec<Option<bool>>,
}

impl Evaluation {
    fn push(&mut self, answer: Answer) {
        self.values.extend(answer.values);
        self.reasons.push(answer.reason);
        self.stable.push(answer.stable);
    }

    /// So many designs that nobody waited for: there may be millions.
    fn push_interrupted(&mut self, designs: usize, outputs: usize) {
        self.values.extend(repeat_n(f64::NAN, designs * outputs));
        self.reasons.extend(repeat_n(Some(Reason::Interrupted), designs));
        self.stable.extend(repeat_n(None, designs));
    }
}

impl Problem {
    /// The outputs of some designs: `x` has one row of k values a design, the answer one row of m.
    ///
    /// Designs are solved on the threads of the current pool; an answer depends neither on the others nor on their order nor
    /// on the number of threads, but for rounding: designs that go the plain way are solved eight at a time.
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
        // Groups follow the order of the rows alone.
        let each = |group: &[&[f64]]| {
            if control.is_stopped() {
                return Err(group.len());
            }
            let mut workspace = self.workspaces.take();
            let answers = self.solve_group(group, control, &mut workspace);
            self.workspaces.give_back(workspace);
            Ok(answers)
        };
        let groups: Vec<Result<Vec<Answer>, usize>> = rows.par_chunks(TOGETHER).map(each).collect();
        let (designs, outputs) = (rows.len(), self.outputs.len());
        let mut found = Evaluation {
            values: Vec::with_capacity(designs * outputs),
            reasons: Vec::with_capacity(designs),
            stable: Vec::with_capacity(designs),
        };
        for group in groups {
            match group {
                Ok(answers) => answers.into_iter().for_each(|answer| found.push(answer)),
                Err(left) => found.push_interrupted(left, outputs),
            }
        }
        found
    }

    /// Estimated discretization error of every output: the largest of a sample of some designs, solved on elements of the next
    /// order too. Not a number where none of them tells.
    ///
    /// # Panics
    /// As [`Problem::evaluate`].
    pub fn estimate(&self, x: &[f64]) -> Vec<f64> {
        let rows = self.rows(x);
        let apart = rows.len().div_ceil(SAMPLE).max(1);
        let sample: Vec<&[f64]> = rows.into_iter().step_by(apart).collect();
        let errors: Vec<Option<Vec<f64>>> = sample.par_iter().map(|row| self.errors_of(row)).collect();
        let mut largest = vec![f64::NAN; self.outputs.len()];
        errors.iter().flatten().for_each(|errors| outputs::join_errors(&mut largest, errors));
        largest
    }

    fn errors_of(&self, row: &[f64]) -> Option<Vec<f64>> {
        let design = self.design(row).ok()?;
        let options = Options { estimate: true, ..Options::default() };
        let solved = pennate_solver::solve(&design.structure, &design.steps, &options, &mut |_| true);
        let mut history = solved.ok()?;
        self.mesh.name_segments(&design.model, &mut history);
        let table = ProbeTable::new(&design.model, &history);
        let error = |output: &Output| {
            let errors = table.steps.get(output.step).and_then(|step| step.errors());
            errors.and_then(|errors| errors.get(output.probe).copied()).unwrap_or(f64::NAN)
        };
        Some(self.outputs.iter().map(error).collect())
    }

    /// One design by the ordinary solver: its outputs as far as its steps went, why they went no farther, and whether it is
    /// stable.
    pub fn evaluate_alone(&self, row: &[f64]) -> (Vec<f64>, Option<Reason>, Option<bool>) {
        let answer = self.solve(row, &Control::default());
        (answer.values, answer.reason, answer.stable)
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
        let stopped = self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed));
        stopped || self.until.is_some_and(|until| Instant::now() >= until)
    }
}
