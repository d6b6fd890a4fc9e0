//! How well load cases determine the parameters: standard errors and correlations of a fit by least squares.
//!
//! With the differences r, their derivatives J by the logarithms of the parameters, n of the former and k of the latter:
//! s² = |r|²/(n − k) and C = s² (Jᵀ J)⁻¹. It holds near the optimum, for differences that are independent and of one size
//! over their scales; what a model cannot follow is counted as scatter.

use nalgebra::{DMatrix, DVector};

use super::parameters::Parameter;
use super::problem::Problem;

/// Standard errors of the parameters that are not on a bound.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Uncertainty {
    /// Those that are not on a bound.
    pub parameters: Vec<Parameter>,
    /// In the units of the parameters.
    pub errors: Vec<f64>,
    /// Of two parameters, -1 to 1, by their places in `parameters`.
    pub correlations: Vec<Vec<f64>>,
}

impl Uncertainty {
    /// At these values, without the parameters that are on a bound; `None` where the cases do not tell the rest apart.
    pub fn of(problem: &mut Problem, values: &[f64], bound: &[Parameter]) -> Option<Self> {
        let free: Vec<usize> =
            (0..values.len()).filter(|&index| !bound.contains(&problem.space.parameters[index])).collect();
        let found = problem.differences(values, true)?;
        let jacobian = DMatrix::from_fn(found.residuals.len(), free.len(), |i, j| found.derivatives[i][free[j]]);
        let (errors, correlations) = covariance(&jacobian, &DVector::from_vec(found.residuals))?;
        Some(Self {
            parameters: free.iter().map(|&index| problem.space.parameters[index]).collect(),
            errors: free.iter().zip(errors).map(|(&index, part)| part * values[index]).collect(),
            correlations,
        })
    }

    /// Standard error of a parameter.
    pub fn error(&self, parameter: Parameter) -> Option<f64> {
        self.parameters.iter().position(|&known| known == parameter).map(|index| self.errors[index])
    }
}

/// Standard deviations and correlations of the unknowns of a least-squares problem.
fn covariance(jacobian: &DMatrix<f64>, residuals: &DVector<f64>) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
    let (rows, columns) = jacobian.shape();
    if rows <= columns || columns == 0 {
        return None;
    }
    let variance = residuals.norm_squared() / (rows - columns) as f64;
    let inverse = (jacobian.transpose() * jacobian).cholesky()?.inverse();
    let deviations: Vec<f64> = (0..columns).map(|i| (variance * inverse[(i, i)]).sqrt()).collect();
    let correlation = |i: usize, j: usize| inverse[(i, j)] / (inverse[(i, i)] * inverse[(j, j)]).sqrt();
    let correlations = (0..columns).map(|i| (0..columns).map(|j| correlation(i, j)).collect()).collect();
    Some((deviations, correlations))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A straight line through (0, 1), (1, 2), (2, 4), (3, 5): 0.9 + 1.4 x, s² = 0.1, by hand.
    #[test]
    fn a_straight_line_has_the_errors_of_the_textbook() {
        let jacobian = DMatrix::from_row_slice(4, 2, &[1.0, 0.0, 1.0, 1.0, 1.0, 2.0, 1.0, 3.0]);
        let residuals = DVector::from_vec(vec![-0.1, 0.3, -0.3, 0.1]);
        let (errors, correlations) = covariance(&jacobian, &residuals).unwrap();
        // (JᵀJ)⁻¹ = [[14, -6], [-6, 4]]/20
        assert!((errors[0] - (0.1 * 0.7_f64).sqrt()).abs() < 1e-12, "{errors:?}");
        assert!((errors[1] - (0.1 * 0.2_f64).sqrt()).abs() < 1e-12, "{errors:?}");
        assert!((correlations[0][1] + 6.0 / 56.0_f64.sqrt()).abs() < 1e-12, "{correlations:?}");
        assert!(covariance(&jacobian.rows(0, 2).into_owned(), &residuals.rows(0, 2).into_owned()).is_none());
    }
}
