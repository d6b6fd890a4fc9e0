//! Solving a scene, and reading its probes.

use pennate::accuracy::solve_to_accuracy;
use pennate::solution::{Solution, status_name};
use pennate_models::scenes;
use pennate_solver::history::Status;
use pennate_solver::options::Options;

/// Solves a scene; a step that does not converge is an error.
pub fn solve(scene: &str, settings: &[(String, String)], accuracy: f64) -> Result<Solution, String> {
    let text = scenes::write(scene, settings).map_err(|errors| errors.to_string())?;
    let model = pennate_models::read_text(scene, &text, &[]).map_err(|errors| errors.to_string())?;
    let options = Options { estimate: true, ..Options::default() };
    let solution = solve_to_accuracy(model, accuracy, &options, &mut |_| true);
    let solution = solution.map_err(|_| "it is a mechanism".to_owned())?;
    match solution.status() {
        Status::Converged => Ok(solution),
        status => Err(status_name(status).to_owned()),
    }
}

/// Value of a probe after a step, or after the last one.
pub fn value(solution: &Solution, probe: &str, step: Option<&str>) -> f64 {
    let at = solution.model.probes.names.iter().position(|name| name == probe);
    let at = at.unwrap_or_else(|| panic!("no probe '{probe}'"));
    let steps = solution.model.step_names();
    let step = step.map_or(steps.len() - 1, |name| {
        steps.iter().position(|step| *step == name).unwrap_or_else(|| panic!("no step '{name}'"))
    });
    solution.probes.steps[step].last().map_or(f64::NAN, |values| values[at])
}
