//! Sweeps: one network for many values of its parameters, solved side by side.

mod plan;
mod vary;

use std::sync::atomic::{AtomicBool, Ordering};

use pennate_models::{Document, InputErrors, Model, Reading};
use pennate_solver::error::{FreeMotion, SolveError};
use pennate_solver::history::Status;
use pennate_solver::options::Options;
use rayon::prelude::*;

use crate::accuracy::{Shared, Verdict, solve_to_accuracy, solve_together};
use crate::solution::Solution;
use crate::together::TOGETHER;

pub use plan::{Parameter, Plan};
pub use vary::{Vary, combinations};

/// One network of a sweep: a file, and parameters that are set in it.
#[derive(Clone, Debug)]
pub struct Case<'a> {
    /// The network file.
    pub document: &'a Document,
    /// Names and values as text.
    pub settings: Vec<(String, String)>,
}

/// What came of a case.
#[derive(Debug)]
pub enum Answer {
    /// The values of the parameters make no network.
    Refused(InputErrors),
    /// The unloaded network can move without force.
    Mechanism(Box<Model>, Vec<FreeMotion>),
    /// It was solved side by side with others: all its steps converged.
    Together(Box<Model>, Shared),
    /// It needed more than the others, and was solved alone; a step that fails is part of the solution.
    Alone(Box<Solution>),
}

/// Solves cases on the threads of the current pool. `answered` hears of each, by its number, as soon as it has an answer;
/// those that are not `wanted`, or interrupted on the way, have none.
///
/// Neighbours of one file are solved together whether all of them are wanted or not, so that the digits of an answer do not
/// depend on what else is wanted, nor on the number of threads.
pub fn solve(
    cases: &[Case<'_>],
    wanted: &(dyn Fn(usize) -> bool + Sync),
    accuracy: f64,
    interrupted: &AtomicBool,
    answered: &(dyn Fn(usize, Answer) + Sync),
) {
    let indices: Vec<usize> = (0..cases.len()).collect();
    let of_files: Vec<&[usize]> =
        indices.chunk_by(|&a, &b| std::ptr::eq(cases[a].document, cases[b].document)).collect();
    // A file is read once, if that serves.
    let read = |of_file: &&[usize]| cases[of_file[0]].document.reading(&[]).ok().map(|(reading, _)| reading);
    let readings: Vec<Option<Reading>> = of_files.par_iter().map(read).collect();
    let groups: Vec<(&[usize], Option<&Reading>)> = of_files
        .iter()
        .zip(&readings)
        .flat_map(|(of_file, reading)| of_file.chunks(TOGETHER).map(move |group| (group, reading.as_ref())))
        .filter(|(group, _)| group.iter().any(|&index| wanted(index)))
        .collect();
    groups.par_iter().for_each(|&group| solve_group(cases, group, wanted, accuracy, interrupted, answered));
}

/// The network of a case.
fn model(case: &Case<'_>, reading: Option<&Reading>) -> Result<Model, InputErrors> {
    let numbers = reading.and_then(|reading| reading.set(&case.settings));
    numbers.map_or_else(|| case.document.model(&case.settings), Ok)
}

/// Solves cases of one file side by side, and those alone that need more than the others.
fn solve_group(
    cases: &[Case<'_>],
    (group, reading): (&[usize], Option<&Reading>),
    wanted: &(dyn Fn(usize) -> bool + Sync),
    accuracy: f64,
    interrupted: &AtomicBool,
    answered: &(dyn Fn(usize, Answer) + Sync),
) {
    let options = Options { estimate: true, ..Options::default() };
    let stopped = || interrupted.load(Ordering::Relaxed);
    if stopped() {
        return;
    }
    let models: Vec<_> = group.iter().map(|&index| model(&cases[index], reading)).collect();
    let sound: Vec<&Model> = models.iter().flatten().collect();
    let mut together = solve_together(&sound, accuracy, &|| !stopped()).into_iter();
    let shared: Vec<Option<Shared>> =
        models.iter().map(|model| model.as_ref().ok().and_then(|_| together.next().flatten())).collect();
    let finish = |((&index, model), shared): ((&usize, Result<Model, InputErrors>), Option<Shared>)| {
        if !wanted(index) {
            return;
        }
        let answer = match (model, shared) {
            (Err(errors), _) => Answer::Refused(errors),
            (Ok(model), Some(shared)) => Answer::Together(Box::new(model), shared),
            (Ok(_), None) if stopped() => return,
            (Ok(model), None) => match solve_to_accuracy(model, accuracy, &options, &mut |_| !stopped()) {
                Err((model, SolveError::Mechanism(motions))) => Answer::Mechanism(model, motions),
                Ok(solution) if is_interrupted(&solution) => return,
                Ok(solution) => Answer::Alone(Box::new(solution)),
            },
        };
        answered(index, answer);
    };
    group.par_iter().zip(models).zip(shared).for_each(finish);
}

fn is_interrupted(solution: &Solution) -> bool {
    solution.status() == Status::Interrupted || solution.accuracy.verdict == Verdict::Interrupted
}
