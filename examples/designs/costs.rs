//! What designs, derivatives and live states cost.

use std::time::Instant;

use pennate_analysis::problem::Problem;
use pennate_models::discretize;
use pennate_solver::options::Options;

use super::networks::{Network, find};

/// Median times of one design of a network, in seconds on one thread.
pub(crate) struct Costs {
    /// Side by side with others.
    pub design: f64,
    /// By the ordinary solver, from the values of the parameters to those of the probes.
    pub one_by_one: f64,
    /// By the ordinary solver, from the structure to the ends of the steps.
    pub solve: f64,
    /// The probes and their derivatives by all parameters.
    pub gradient: f64,
    /// A step of a live state by a fiftieth of the first parameter.
    pub live: f64,
}

impl Costs {
    /// Measures them on the thread that calls.
    pub(crate) fn of(network: &Network) -> Self {
        let (many, few, width) = (256, 16, network.parameters.len());
        let problem = network.problem();
        let rows = network.rows(&problem, many);
        let some = &rows[..few * width];
        Self {
            design: median(|| drop(problem.evaluate(&rows))) / many as f64,
            one_by_one: median(|| some.chunks_exact(width).for_each(|row| drop(alone(&problem, row)))) / few as f64,
            solve: solve(&problem, some),
            gradient: median(|| drop(problem.gradient(some))) / few as f64,
            live: live(&problem),
        }
    }
}

/// The outputs of one design by the ordinary solver.
pub(crate) fn alone(problem: &Problem, row: &[f64]) -> Vec<f64> {
    problem.evaluate_alone(row).0
}

/// How many of so many designs of the mechanism have an answer, and the seconds that two threads take for all of them.
pub(crate) fn study(count: usize) -> (usize, f64) {
    let network = find("mechanism");
    let problem = network.problem();
    let rows = network.rows(&problem, count);
    on_threads(2, || {
        let start = Instant::now();
        let found = problem.evaluate(&rows);
        (found.reasons.iter().filter(|reason| reason.is_none()).count(), start.elapsed().as_secs_f64())
    })
}

/// Does some work on so many threads; that of a problem takes all that there are, otherwise.
pub(crate) fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(work)
}

/// Median time of some work, repeated for half a second or so.
pub(crate) fn median(mut work: impl FnMut()) -> f64 {
    let begin = Instant::now();
    let mut times = Vec::new();
    while times.len() < 5 || begin.elapsed().as_secs_f64() < 0.5 {
        let start = Instant::now();
        work();
        times.push(start.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Median time of a solve from the structure to the ends of the steps.
fn solve(problem: &Problem, rows: &[f64]) -> f64 {
    let width = problem.parameters().len();
    let designs: Vec<_> = rows
        .chunks_exact(width)
        .filter_map(|row| problem.model(row).ok())
        .map(|model| discretize(&model, problem.mesh()))
        .collect();
    let solve = || {
        for (structure, steps) in &designs {
            let _ = pennate_solver::solve(structure, steps, &Options::default(), &mut |_| true);
        }
    };
    median(solve) / designs.len().max(1) as f64
}

/// Median time of a live step by a fiftieth of the first parameter, there and back.
fn live(problem: &Problem) -> f64 {
    let Ok(mut live) = problem.live() else { return f64::NAN };
    let here = problem.middle()[0];
    let mut away = false;
    median(|| {
        away = !away;
        live.set(0, if away { 0.98 * here } else { here });
        let _ = live.solve();
    })
}
