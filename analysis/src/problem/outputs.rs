//! Probes at the ends of steps.

use pennate_models::Model;
use pennate_models::probes::{Operand, Probes};

use super::ProblemError;
use crate::solution::{ProbeTable, Solution};

/// A probe at the end of a step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Output {
    /// As it was asked for: `stroke`, or `stroke@inflate`.
    pub name: String,
    /// Place of the probe in the network.
    pub probe: usize,
    /// The step at whose end it is read.
    pub step: usize,
}

/// The outputs of some names.
pub(super) fn outputs(model: &Model, names: &[&str]) -> Result<Vec<Output>, ProblemError> {
    let steps = model.step_names();
    let known = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
    let output = |&name: &&str| {
        let (probe, step) = match name.split_once('@') {
            Some((probe, step)) => (probe.trim(), Some(step.trim())),
            None => (name.trim(), None),
        };
        let Some(place) = model.probes.names.iter().position(|known| known == probe) else {
            let known = model.probes.names.clone();
            return Err(ProblemError::UnknownProbe { name: probe.to_owned(), known });
        };
        let step =
            match step {
                None => steps.len() - 1,
                Some(step) => steps.iter().position(|known| *known == step).ok_or_else(|| {
                    ProblemError::UnknownStep { probe: probe.to_owned(), step: step.to_owned(), known: known(&steps) }
                })?,
            };
        Ok(Output { name: name.to_owned(), probe: place, step })
    };
    names.iter().map(output).collect()
}

/// Whether any output is a stiffness or a compliance, or an expression of one.
pub(super) fn need_stiffness(probes: &Probes, outputs: &[Output]) -> bool {
    let mut open: Vec<usize> = outputs.iter().map(|output| output.probe).collect();
    let mut seen = vec![false; probes.len()];
    while let Some(probe) = open.pop() {
        if probes.is_stiffness(probe) {
            return true;
        }
        if std::mem::replace(&mut seen[probe], true) {
            continue;
        }
        for operand in probes.operands(probe).into_iter().flatten() {
            match *operand {
                Operand::Probe(other) | Operand::After { probe: other, .. } => open.push(other),
                Operand::Parameter(_) => {}
            }
        }
    }
    false
}

/// Values of the outputs; not a number where a step did not get so far.
pub(super) fn values(table: &ProbeTable, outputs: &[Output], reached: usize) -> Vec<f64> {
    let value = |output: &Output| {
        let last = table.steps.get(output.step).filter(|_| output.step < reached).and_then(|step| step.last());
        last.and_then(|values| values.get(output.probe)).copied().unwrap_or(f64::NAN)
    };
    outputs.iter().map(value).collect()
}

/// Estimated errors of the outputs; not a number where they are not known.
pub(super) fn errors(solution: &Solution, outputs: &[Output]) -> Vec<f64> {
    let error = |output: &Output| {
        let errors = solution.probes.steps.get(output.step).and_then(|step| step.errors());
        errors.and_then(|errors| errors.get(output.probe).copied()).unwrap_or(f64::NAN)
    };
    outputs.iter().map(error).collect()
}

/// Takes the larger error of every output.
pub(super) fn join_errors(errors: &mut [f64], others: &[f64]) {
    for (error, &other) in errors.iter_mut().zip(others) {
        *error = error.max(other);
    }
}
