//! The length of the ends that explains the data best.
//!
//! Several lengths: the free stroke is |α| p (L − 2 l₁), so its growth with L gives α and where it vanishes gives l₁. One
//! l₁ for all pressures, since the table of a muscle has one. A single length: the l₁ of the smallest sum of squares that
//! stage 2 comes to.

use argmin::core::{CostFunction, Executor};
use argmin::solver::brent::BrentOpt;
use pennate_models::error::InputError;

use super::data::Case;
use super::problem::Tube;
use super::select::{Selection, distinct};
use super::{Request, fit_tube};

/// Finds the end length in mm.
pub fn fit(selection: &Selection, request: &Request) -> Result<f64, Box<InputError>> {
    let free: Vec<&Case> = selection.all.iter().filter(|case| case.is_free()).collect();
    let pressures = distinct(selection.pressures.iter().map(|at| at.pressure));
    let groups: Vec<Vec<&Case>> = pressures
        .iter()
        .map(|pressure| free.iter().copied().filter(|case| case.pressure == *pressure).collect())
        .collect();
    let several = groups.iter().all(|group| distinct(group.iter().map(|case| case.length)).len() >= 2);
    let shortest = selection.all.iter().map(|case| case.length).fold(f64::INFINITY, f64::min);
    let [least, most] = [0.02 * request.diameter, (2.0 * request.diameter).min(0.4 * shortest)];
    // Two thousandths of a diameter are more than any data can tell.
    let search = BrentOpt::new(least, most).set_tolerance(1e-4, 1e-3 * request.diameter);
    let best = if several {
        let result = Executor::new(Strokes(&groups), search).configure(|state| state.max_iters(60)).run();
        result.ok().and_then(|result| result.state.best_param)
    } else {
        let fits = Fits { selection, request };
        let result = Executor::new(fits, search).configure(|state| state.max_iters(25)).run();
        result.ok().and_then(|result| result.state.best_param)
    };
    let length = best.ok_or_else(|| Box::new(InputError::new("no end length explains the load cases")))?;
    if length - least < 1e-2 * (most - least) || most - length < 1e-2 * (most - least) {
        let message = format!("the fitted end length {length:.3} mm lies on a bound ({least:.3} to {most:.3} mm)");
        let help = format!("the data do not determine it; give one with {}", request.words.end_length);
        return Err(Box::new(InputError::new(message).help(help)));
    }
    Ok(length)
}

/// Squared differences of the free strokes, with the best α at every pressure.
struct Strokes<'a>(&'a [Vec<&'a Case>]);

impl CostFunction for Strokes<'_> {
    type Param = f64;
    type Output = f64;

    fn cost(&self, end_length: &f64) -> Result<f64, argmin::core::Error> {
        let one = |group: &Vec<&Case>| {
            let pairs = || group.iter().map(|case| (case.length - 2.0 * end_length, case.length - case.tip[0]));
            let strain = pairs().map(|(middle, stroke)| middle * stroke).sum::<f64>()
                / pairs().map(|(middle, _)| middle * middle).sum::<f64>();
            pairs().map(|(middle, stroke)| (strain * middle - stroke).powi(2)).sum::<f64>()
        };
        Ok(self.0.iter().map(one).sum())
    }
}

/// Sum of squares of whole fits.
struct Fits<'a> {
    selection: &'a Selection,
    request: &'a Request,
}

impl CostFunction for Fits<'_> {
    type Param = f64;
    type Output = f64;

    fn cost(&self, end_length: &f64) -> Result<f64, argmin::core::Error> {
        let Request { diameter, wall, shear, .. } = *self.request;
        let tube = Tube { diameter, wall, end_length: *end_length, shear };
        // Where the ends leave too little to contract there is no fit.
        let rows = fit_tube(self.selection, tube, self.request);
        Ok(rows.map_or(f64::MAX, |rows| rows.iter().map(|row| row.cost).sum()))
    }
}
