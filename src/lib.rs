//! Reads a network, solves it and writes the results: what the command line does, for programs and tests.

pub mod cli;
pub mod commands;
pub mod diagnostics;
pub mod explain;
pub mod fit;
#[cfg(test)]
mod fixture;
pub mod flow;
pub mod memory;
pub mod output;
pub mod problems;
pub mod progress;
pub mod spectrum;
pub mod strains;
pub mod sweep;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

use pennate_analysis::accuracy;
use pennate_analysis::solution::Solution;
use pennate_models::{InputError, InputErrors, Mesh, Model, discretize};
use pennate_solver::error::{FreeMotion, NearMotion, SolveError};
use pennate_solver::options::{Options, Progress};

/// Where a network comes from, and the parameters that are set in it.
#[derive(Clone, Debug, Default)]
pub struct Input {
    /// The network file; `-` is TOML from standard input.
    pub file: PathBuf,
    /// Parameters by name with their new values as text.
    pub settings: Vec<(String, String)>,
}

/// What to solve, and how.
#[derive(Clone, Debug)]
pub struct Job {
    /// The network file.
    pub input: Input,
    /// Discretization error asked for, relative to the largest value of its kind.
    pub accuracy: f64,
    /// Threads to solve on; as many as there are processors by default.
    pub threads: Option<usize>,
    /// Keep the shapes of members, for pictures.
    pub shapes: bool,
}

/// Why a network is not solved at all: the input is wrong.
#[derive(Debug)]
pub enum Refusal {
    /// The file is wrong.
    Input(InputErrors),
    /// The network can move without force.
    Mechanism(Box<Model>, Vec<FreeMotion>),
}

/// Reads a network.
///
/// # Errors
/// Everything found wrong, with its place.
pub fn read(input: &Input) -> Result<Model, InputErrors> {
    if input.file != Path::new("-") {
        return pennate_models::read(&input.file, &input.settings);
    }
    match pennate_models::file::read_from(std::io::stdin().lock()) {
        Ok(text) => pennate_models::read_text("<stdin>", &text, &input.settings),
        Err(error) => {
            let error = InputError::new(format!("standard input cannot be read: {error}"));
            Err(InputErrors { errors: vec![error], sources: Vec::new() })
        }
    }
}

/// Reads a network and solves it; `observe` hears of every accepted increment and may stop the solve.
///
/// # Errors
/// A [`Refusal`] where the input is wrong; a step that fails is part of the solution.
pub fn run(job: &Job, observe: &mut (dyn FnMut(&Progress) -> bool + Send)) -> Result<Solution, Refusal> {
    run_until(job, None, observe)
}

/// The same, given up as soon as `stop` is set: within an iteration, and not only after an increment.
///
/// # Errors
/// Those of [`run`].
pub fn run_until(
    job: &Job,
    stop: Option<Arc<AtomicBool>>,
    observe: &mut (dyn FnMut(&Progress) -> bool + Send),
) -> Result<Solution, Refusal> {
    let start = clock();
    let model = read(&job.input).map_err(Refusal::Input)?;
    let read = clock().saturating_sub(start);
    let options = Options { shapes: job.shapes, stop, ..Options::default() };
    let mut solution = solve(model, job.accuracy, job.threads, &options, observe)?;
    solution.timing.read = read;
    Ok(solution)
}

/// Solves a network that was read, with the estimates and the remarks that a person is told.
///
/// # Errors
/// A [`Refusal`] where the network can move without force; a step that fails is part of the solution.
pub fn solve(
    model: Model,
    accuracy: f64,
    threads: Option<usize>,
    wishes: &Options,
    observe: &mut (dyn FnMut(&Progress) -> bool + Send),
) -> Result<Solution, Refusal> {
    on_threads(threads, |threads| {
        let options = Options { estimate: true, near_motion: true, threads, clock, ..wishes.clone() };
        accuracy::solve_to_accuracy(model, accuracy, &options, observe)
    })
    .map_err(|(model, SolveError::Mechanism(motions))| Refusal::Mechanism(model, motions))
}

/// Looks for motions that need no force, and for the softest one if that is nearly free.
///
/// # Errors
/// The motions that need no force.
pub fn near_motion(model: &Model) -> Result<Option<NearMotion>, Vec<FreeMotion>> {
    // Free motions are those of the joints, whatever the mesh.
    let (structure, steps) = discretize(model, &Mesh::initial(model, 1e-3));
    let motions = pennate_solver::free_motions(&structure, &steps);
    if motions.is_empty() { Ok(pennate_solver::near_motion(&structure, &steps)) } else { Err(motions) }
}

/// The time since the program first asked for it.
pub fn clock() -> Duration {
    static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
    BEGIN.elapsed()
}

/// Options of a solve on so many threads, timed by the program's clock.
pub fn options(threads: usize) -> Options {
    Options { threads, clock, ..Options::default() }
}

/// Does work on threads of its own, where it is to have more than one; it hears how many there are.
pub fn on_threads<T: Send>(threads: Option<usize>, work: impl FnOnce(usize) -> T + Send) -> T {
    let threads = threads.unwrap_or(1);
    if threads <= 1 {
        return work(1);
    }
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(|| work(threads)),
        // Threads that cannot be had cost time, not the answer.
        Err(_) => work(1),
    }
}
