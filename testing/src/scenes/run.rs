//! Solving a scene, and reading its probes.

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_analysis::solution::{Solution, status_name};
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
    let steps = solution.model.step_names();
    let step = step.unwrap_or_else(|| steps[steps.len() - 1]);
    solution.probe(probe, step).unwrap_or_else(|| panic!("no probe '{probe}' after step '{step}'"))
}
