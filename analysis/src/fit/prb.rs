//! Fit of the pseudo-rigid-body model: γ, K_th and K_ex of one length at one pressure.
//!
//! A bounded search by Nelder–Mead from several places, 0.1 ≤ γ ≤ 0.85 and 0 ≤ K ≤ 10 in the dissertation's units, on the same
//! differences as for the muscle ([`super::problem`]).

use argmin::core::{CostFunction, Executor};
use argmin::solver::neldermead::NelderMead;
use pennate_models::prb::{Prb, TORSION_UNIT};

use super::data::Case;
use super::errors::Errors;
use super::problem::{Difference, scales};

/// γ, K_th, K_ex.
const BOUNDS: [[f64; 2]; 3] = [[0.1, 0.85], [0.0, 10.0], [0.0, 10.0]];
/// Names of the three.
pub const NAMES: [&str; 3] = ["gamma", "K_th", "K_ex"];
const STARTS: [[f64; 3]; 5] = [[0.7, 1.5, 1.3], [0.4, 1.0, 2.5], [0.8, 3.0, 0.8], [0.3, 5.0, 5.0], [0.6, 0.4, 0.5]];
const SIMPLEX: f64 = 0.2;
/// A parameter this near to a bound, as a part of the range, is on it.
const ON_BOUND: f64 = 1e-3;
/// Sum of squares of a set of parameters for which some load has no equilibrium.
const HOPELESS: f64 = 1e6;

/// A fitted model.
#[derive(Clone, Debug)]
pub struct FittedPrb {
    /// The model; lengths in mm, stiffnesses in N and mm.
    pub model: Prb,
    /// In the unit of the data.
    pub pressure: f64,
    /// Sum of squared differences over their scales.
    pub cost: f64,
    /// Mean differences of the cases that were fitted.
    pub errors: Errors,
    /// How many starts came to this optimum, of how many.
    pub agreeing: [usize; 2],
    /// Names of parameters on a bound.
    pub on_bounds: Vec<&'static str>,
    /// How often all load cases were solved.
    pub evaluations: u64,
}

impl FittedPrb {
    /// γ, K_th and K_ex in the dissertation's units.
    pub fn parameters(&self) -> [f64; 3] {
        [self.model.gamma, self.model.torsion / TORSION_UNIT, self.model.extension]
    }
}

/// Fits the model to load cases of one length and pressure; its free stroke is that of the muscle.
///
/// `None` where no start has an equilibrium for all loads.
pub fn fit(stroke: f64, cases: &[Case]) -> Option<FittedPrb> {
    let first = cases.first()?;
    let sum = Sum { length: first.length, stroke, cases, scales: scales(cases.iter()) };
    let mut evaluations = 0;
    let mut found: Vec<(Vec<f64>, f64)> = Vec::new();
    for start in STARTS {
        let mut centre = variables(start);
        let mut best = f64::INFINITY;
        // Anew from its best, until that gains nothing more.
        for _ in 0..3 {
            let corner = |i: usize| {
                let mut corner = centre.clone();
                corner[i] += SIMPLEX;
                corner
            };
            let simplex = std::iter::once(centre.clone()).chain((0..3).map(corner)).collect();
            let solver = NelderMead::new(simplex).with_sd_tolerance(1e-12).ok()?;
            let Sum { length, stroke, cases, scales } = sum;
            let problem = Sum { length, stroke, cases, scales };
            let result = Executor::new(problem, solver).configure(|state| state.max_iters(300)).run().ok()?;
            evaluations += result.problem.counts.get("cost_count").copied().unwrap_or(0);
            let gained = best - result.state.best_cost;
            if gained > 0.0 {
                best = result.state.best_cost;
                centre = result.state.best_param?;
            }
            if gained <= 1e-9 * best {
                break;
            }
        }
        found.push((centre, best));
    }
    let (z, cost) = found.iter().min_by(|a, b| a.1.total_cmp(&b.1))?.clone();
    if cost >= HOPELESS {
        return None;
    }
    let near = found.iter().filter(|(_, other)| *other <= cost * (1.0 + 1e-6)).count();
    let model = sum.model(&z);
    let on_bounds = z.iter().zip(NAMES).filter(|(z, _)| {
        let part = 0.5 * (1.0 + z.sin());
        !(ON_BOUND..=1.0 - ON_BOUND).contains(&part)
    });
    Some(FittedPrb {
        model,
        pressure: first.pressure,
        cost,
        errors: Errors::over(cases, cases.iter().map(|case| compare(&model, case))),
        agreeing: [near, STARTS.len()],
        on_bounds: on_bounds.map(|(_, name)| name).collect(),
        evaluations,
    })
}

/// Difference of the model from a load case; `None` without an equilibrium.
pub fn compare(model: &Prb, case: &Case) -> Option<Difference> {
    let [x, y, slope] = model.under_load(case.force, case.moment).ok()?;
    Some(match case.is_axial() {
        true => Difference::Axial(x - case.tip[0]),
        false => Difference::Lateral { deflection: y - case.tip[1], slope: slope - case.slope },
    })
}

/// Unbounded variables, as [`super::parameters`] but without the logarithm: a stiffness may be zero.
fn variables(values: [f64; 3]) -> Vec<f64> {
    let one =
        |(value, [low, high]): (f64, [f64; 2])| (2.0 * (value - low) / (high - low) - 1.0).clamp(-1.0, 1.0).asin();
    values.into_iter().zip(BOUNDS).map(one).collect()
}

struct Sum<'a> {
    length: f64,
    stroke: f64,
    cases: &'a [Case],
    scales: [f64; 3],
}

impl Sum<'_> {
    fn model(&self, z: &[f64]) -> Prb {
        let value = |i: usize| {
            let [low, high] = BOUNDS[i];
            low + (high - low) * 0.5 * (1.0 + z[i].sin())
        };
        Prb {
            length: self.length,
            stroke: self.stroke,
            gamma: value(0),
            torsion: value(1) * TORSION_UNIT,
            extension: value(2),
        }
    }
}

impl CostFunction for Sum<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, z: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        let model = self.model(z);
        let mut sum = 0.0;
        for case in self.cases {
            match compare(&model, case) {
                Some(Difference::Axial(axial)) => sum += (axial / self.scales[0]).powi(2),
                Some(Difference::Lateral { deflection, slope }) => {
                    sum += (deflection / self.scales[1]).powi(2) + (slope / self.scales[2]).powi(2);
                }
                None => return Ok(HOPELESS),
            }
        }
        Ok(sum)
    }
}
