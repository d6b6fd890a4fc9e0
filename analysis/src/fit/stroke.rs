//! Stage 1: the contraction coefficient from the free stroke.

use argmin::core::{CostFunction, Executor};
use argmin::solver::brent::BrentOpt;
use pennate_models::error::InputError;

use super::Words;
use super::cantilever::Cantilever;
use super::data::Case;
use super::muscle;
use super::problem::Tube;

/// The line search looks this far on either side of Δl/(p (l₂ − l₁)).
const REACH: f64 = 0.2;

/// α with which the muscle contracts as its unloaded cases do: a line search about Δl/(p (l₂ − l₁)).
///
/// The muscle of HSIM, free of load, contracts by just |α| p (l₂ − l₁); the search confirms it with the forward model, and
/// finds the mean of several cases in the sense of least squares.
pub fn contraction(free: &[Case], tube: Tube, words: Words) -> Result<f64, Vec<InputError>> {
    let [first, ..] = free else { return Ok(0.0) };
    let middle = |case: &Case| case.length - 2.0 * tube.end_length;
    let stroke = |case: &Case| case.length - case.tip[0];
    for case in free {
        if stroke(case) >= middle(case) {
            let message = format!(
                "row {}, column 'tip_x': a stroke of {:.4} mm is more than the {:.4} mm between the ends can contract",
                case.line,
                stroke(case),
                middle(case).max(0.0)
            );
            let help = format!("the ends are {:.4} mm long each; see {}", tube.end_length, words.end_length);
            return Err(vec![InputError::new(message).at(case.x_span).help(help)]);
        }
    }
    let guesses = free.iter().map(|case| stroke(case) / (case.pressure * middle(case)));
    let guess = guesses.sum::<f64>() / free.len() as f64;
    let search = BrentOpt::new((1.0 - REACH) * guess, (1.0 + REACH) * guess).set_tolerance(1e-12, 1e-15 * guess);
    let found = Executor::new(Strokes { free, tube }, search)
        .configure(|state| state.max_iters(100))
        .run()
        .ok()
        .and_then(|result| result.state.best_param);
    match found {
        Some(alpha) => Ok(-alpha),
        None => {
            let message = format!("the free stroke at pressure {} has no contraction coefficient", first.pressure);
            Err(vec![InputError::new(message).at(first.x_span)])
        }
    }
}

/// Squared differences of the free strokes by |α|.
struct Strokes<'a> {
    free: &'a [Case],
    tube: Tube,
}

impl CostFunction for Strokes<'_> {
    type Param = f64;
    type Output = f64;

    fn cost(&self, alpha: &f64) -> Result<f64, argmin::core::Error> {
        let radius = 0.5 * self.tube.diameter;
        let one = |case: &Case| {
            let row = muscle::row(case.pressure, -alpha, [radius; 2], [1.0; 2]);
            let mut cantilever = Cantilever::new(&self.tube.muscle(row), case.length);
            let tip = cantilever.solve(&[super::cantilever::Load::default()], false).map(|found| found[0].tip[0]);
            tip.map_or(f64::INFINITY, |x| (x - case.tip[0]).powi(2))
        };
        Ok(self.free.iter().map(one).sum())
    }
}
