//! One file, as the commands take it.

use std::time::{Duration, Instant};

use pennate::diagnostics::{Message, Severity, text};
use pennate::explain;
use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_models::{Mesh, Model, discretize, file, read_text};
use pennate_solver::history::{Equilibrium, Status};
use pennate_solver::options::Options;

/// Time of a solve, after which it is told to stop.
const BUDGET: Duration = Duration::from_secs(2);
/// Sum of all loads and reactions, over the largest of them.
const BALANCE: f64 = 1e-6;
/// So many times what rounding is estimated to leave of the largest force may be left of it too.
const TIMES: f64 = 10.0;

/// Reads a file and checks the network, with every message that would be shown.
///
/// # Errors
/// What should not be.
pub fn check(name: &str, bytes: &[u8]) -> Result<&'static str, String> {
    let (model, refused) = read(name, bytes);
    let Some(model) = model else { return Ok(refused) };
    let (structure, steps) = discretize(&model, &Mesh::initial(&model, 1e-3));
    let motions = pennate_solver::free_motions(&structure, &steps);
    for motion in motions.iter().take(10) {
        say(&explain::mechanism(&model, motion), &model)?;
    }
    if !motions.is_empty() {
        return Ok("a mechanism");
    }
    match pennate_solver::near_motion(&structure, &steps) {
        Some(near) => say(&explain::near_mechanism(&model, &near), &model).map(|()| "nearly a mechanism"),
        None => Ok("ready to be solved"),
    }
}

fn read(name: &str, bytes: &[u8]) -> (Option<Model>, &'static str) {
    let Ok(content) = file::read_from(bytes) else { return (None, "no text") };
    match read_text(name, &content, &[]) {
        Ok(model) => (Some(model), ""),
        Err(errors) => {
            for error in errors.errors.iter().take(4) {
                text(Severity::Error, &Message::from(error), &errors.sources);
            }
            let parsed = errors.errors.iter().all(|error| !error.message.starts_with("this is not"));
            (None, if parsed { "refused" } else { "neither TOML nor JSON" })
        }
    }
}

fn say(message: &Message, model: &Model) -> Result<(), String> {
    let shown = text(Severity::Error, message, &model.sources);
    if shown.contains("NaN") { Err(format!("says {shown}")) } else { Ok(()) }
}

/// Solves a network within a budget.
///
/// # Errors
/// What should not be: a state that is called converged, and is none.
pub fn solve(name: &str, bytes: &[u8]) -> Result<&'static str, String> {
    let (model, refused) = read(name, bytes);
    let Some(model) = model else { return Ok(refused) };
    let (start, mut late) = (Instant::now(), false);
    let options = Options { estimate: true, ..Options::default() };
    let solved = solve_to_accuracy(model, 1e-4, &options, &mut |_| {
        late = start.elapsed() > BUDGET;
        !late
    });
    let Ok(solution) = solved else { return Ok("a mechanism") };
    explain::failed_steps(&solution.model, &solution.history.steps)
        .try_for_each(|message| say(&message, &solution.model))?;
    for (index, step) in solution.history.steps.iter().enumerate() {
        for (number, increment) in step.increments.iter().enumerate() {
            let last = number + 1 == step.increments.len();
            let nodes = increment.state.nodes.iter();
            let finite = nodes.flat_map(|node| node.displacement.into_iter().chain(node.rotation)).all(f64::is_finite);
            if !finite {
                return Err(format!("step {index} holds what is not finite"));
            }
            if !(increment.state.balance <= balance(&increment.state, last)) {
                return Err(format!("step {index} is out of balance by {:e}", increment.state.balance));
            }
        }
    }
    Ok(match solution.history.steps.iter().map(|step| step.status).find(|&status| status != Status::Converged) {
        _ if late => "stopped at the end of its time",
        None => "solved",
        Some(Status::LimitPoint) => "a limit point",
        Some(Status::Bifurcation) => "a bifurcation",
        Some(_) => "no equilibrium found",
    })
}

/// What may be left of a state's balance: reactions may be what rounding leaves of far larger forces inside the network, or of
/// none at all; increments on the way of a large network are not to be read off.
fn balance(state: &Equilibrium, last: bool) -> f64 {
    let Some(rounding) = state.rounding else { return if last { BALANCE } else { f64::INFINITY } };
    let size = |force: &[f64; 3]| force.iter().map(|x| x * x).sum::<f64>().sqrt();
    let reaction = state.nodes.iter().map(|node| size(&node.reaction_force)).fold(0.0, f64::max);
    let inner = state.members.iter().flat_map(|member| &member.end_forces).map(size).fold(0.0, f64::max);
    rounding.errors[2].map_or(f64::INFINITY, |error| BALANCE.max(TIMES * error * inner / reaction))
}
