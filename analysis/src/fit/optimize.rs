//! Stage 2: the parameters that make the differences least, by Levenberg–Marquardt or by Nelder–Mead.
//!
//! Both start from the undeformed geometry and 1 MPa, and again from other places: a least value that two starts agree on
//! is more likely the least of all.

use std::cell::RefCell;

use argmin::core::{CostFunction, Executor};
use argmin::solver::neldermead::NelderMead;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Owned};

use super::problem::Problem;

/// Which optimizer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Levenberg–Marquardt with exact derivatives.
    #[default]
    LeastSquares,
    /// Nelder–Mead on the sum of squares.
    NelderMead,
}

/// What an optimizer found.
#[derive(Clone, Debug)]
pub struct Optimum {
    /// In the variables of [`super::parameters::Space`].
    pub variables: Vec<f64>,
    /// Sum of the squared differences over their scales.
    pub cost: f64,
    /// How many starts came to a sum of squares within 1e-6 of this one, and how many there were.
    pub agreeing: [usize; 2],
}

/// A difference of a load without equilibrium: worse than any that has one.
const HOPELESS: f64 = 1e3;
/// Factors on radii of ends and middle, and on moduli, of the places to start from.
const STARTS: [[f64; 3]; 3] = [[1.0, 1.0, 1.0], [0.85, 1.35, 3.0], [1.2, 1.1, 5.0]];
/// A start is stiffened to twice the modulus so often.
const STIFFER: i32 = 5;
/// Nelder–Mead starts anew from its best so often, until that gains nothing more.
const RESTARTS: usize = 4;
const SIMPLEX: f64 = 0.15;

/// Finds the least sum of squared differences from every start; `None` where no start has an equilibrium.
pub fn optimize(problem: &mut Problem, method: Method) -> Option<Optimum> {
    let starts: Vec<Vec<f64>> = STARTS.iter().filter_map(|factors| start(problem, factors)).collect();
    let found: Vec<Optimum> = starts
        .into_iter()
        .filter_map(|start| match method {
            Method::LeastSquares => least_squares(problem, start),
            Method::NelderMead => nelder_mead(problem, start),
        })
        .collect();
    let best = found.iter().min_by(|a, b| a.cost.total_cmp(&b.cost))?;
    let near = found.iter().filter(|other| other.cost <= best.cost * (1.0 + 1e-6) + 1e-20).count();
    Some(Optimum { agreeing: [near, STARTS.len()], ..best.clone() })
}

/// A place to start from at which every load has an equilibrium: a tube that is too soft for one is stiffened.
fn start(problem: &mut Problem, [ends, middle, modulus]: &[f64; 3]) -> Option<Vec<f64>> {
    (0..STIFFER).find_map(|doubled| {
        let modulus = modulus * 2.0_f64.powi(doubled);
        let factors = [*ends, *middle, modulus, modulus];
        let values: Vec<f64> = problem.start().iter().zip(factors).map(|(value, factor)| value * factor).collect();
        problem.differences(&values, false)?;
        Some(problem.space.variables(&values))
    })
}

/// The problem as Levenberg–Marquardt takes it.
struct Squares<'a> {
    problem: &'a mut Problem,
    variables: DVector<f64>,
    residuals: DVector<f64>,
    jacobian: DMatrix<f64>,
}

impl Squares<'_> {
    fn update(&mut self) {
        let z = self.variables.as_slice();
        let (values, slopes) = (self.problem.space.values(z), self.problem.space.slopes(z));
        let (rows, columns) = (self.problem.len(), z.len());
        match self.problem.differences(&values, true) {
            Some(found) => {
                self.residuals = DVector::from_vec(found.residuals);
                self.jacobian = DMatrix::from_fn(rows, columns, |i, j| found.derivatives[i][j] * slopes[j]);
            }
            // The step that led here is taken back.
            None => self.residuals = DVector::from_element(rows, HOPELESS),
        }
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Squares<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, variables: &DVector<f64>) {
        self.variables.copy_from(variables);
        self.update();
    }

    fn params(&self) -> DVector<f64> {
        self.variables.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.residuals.clone())
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Some(self.jacobian.clone())
    }
}

fn least_squares(problem: &mut Problem, start: Vec<f64>) -> Option<Optimum> {
    let size = start.len();
    let rows = problem.len();
    let mut squares = Squares {
        problem,
        variables: DVector::from_vec(start),
        residuals: DVector::zeros(rows),
        jacobian: DMatrix::zeros(rows, size),
    };
    squares.update();
    // Without an equilibrium at the start there are no derivatives to go by.
    if squares.residuals.iter().all(|residual| *residual == HOPELESS) {
        return None;
    }
    // Along a valley, where two parameters make up for each other, hundreds of steps are no rarity.
    let solver = LevenbergMarquardt::new().with_ftol(1e-12).with_xtol(1e-10).with_gtol(1e-12).with_patience(400);
    let (squares, report) = solver.minimize(squares);
    Some(Optimum {
        variables: squares.variables.as_slice().to_vec(),
        cost: 2.0 * report.objective_function,
        agreeing: [1, 1],
    })
}

/// The problem as Nelder–Mead takes it.
struct Sum<'a>(&'a RefCell<&'a mut Problem>);

impl CostFunction for Sum<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, z: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        let mut problem = self.0.borrow_mut();
        let values = problem.space.values(z);
        let rows = problem.len() as f64;
        Ok(problem
            .differences(&values, false)
            .map_or(HOPELESS * HOPELESS * rows, |found| found.residuals.iter().map(|x| x * x).sum()))
    }
}

fn nelder_mead(problem: &mut Problem, start: Vec<f64>) -> Option<Optimum> {
    let cell = RefCell::new(problem);
    let mut best: Option<(Vec<f64>, f64)> = None;
    for _ in 0..RESTARTS {
        let centre = best.as_ref().map_or(&start, |(z, _)| z).clone();
        let mut simplex = vec![centre.clone()];
        for i in 0..centre.len() {
            let mut corner = centre.clone();
            corner[i] += SIMPLEX;
            simplex.push(corner);
        }
        let solver = NelderMead::new(simplex).with_sd_tolerance(1e-12).ok()?;
        let result = Executor::new(Sum(&cell), solver).configure(|state| state.max_iters(400)).run().ok()?;
        let (z, cost) = (result.state.best_param?, result.state.best_cost);
        let gained = best.as_ref().map_or(f64::INFINITY, |(_, before)| before - cost);
        if gained > 0.0 {
            best = Some((z, cost));
        }
        if gained <= 1e-9 * cost {
            break;
        }
    }
    best.map(|(variables, cost)| Optimum { variables, cost, agreeing: [1, 1] })
}
