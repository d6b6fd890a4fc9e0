//! Regression of a parameter of the pseudo-rigid-body model over aspect ratio, fibre angle and pressure (Eq. 5).

use nalgebra::{DMatrix, DVector};

/// Steps of the iteration for singular values at most, which has no limit of its own: two or three for each are the rule.
const STEPS: usize = 1000;

/// A polynomial fitted by least squares.
#[derive(Clone, Debug)]
pub struct Regression {
    /// Names of the terms, the constant first, and their coefficients.
    pub terms: Vec<(String, f64)>,
    /// Root of the mean squared residual.
    pub rms: f64,
    /// Akaike's criterion n ln(RSS/n) + 2 (k + 1): k coefficients and a variance. The smaller, the better.
    pub akaike: f64,
    /// Residuals over their own standard deviations, s √(1 − h).
    pub standardized: Vec<f64>,
}

/// Fits a polynomial of order 1 or 2 in the factors to values, one row a point; a factor that does not vary has no terms.
///
/// `None` where there are too few points, or points that do not tell the terms apart.
pub fn regress(names: &[&str], points: &[Vec<f64>], values: &[f64], order: usize) -> Option<Regression> {
    let varies = |factor: &usize| points.iter().any(|point| point[*factor] != points[0][*factor]);
    let factors: Vec<usize> = (0..names.len()).filter(varies).collect();
    // Factors about their mean and over their range, so that powers can be told apart; undone for the coefficients.
    let mut terms: Vec<Vec<usize>> = vec![Vec::new()];
    terms.extend(factors.iter().map(|&factor| vec![factor]));
    if order == 2 {
        for (i, &a) in factors.iter().enumerate() {
            terms.extend(factors[i..].iter().map(|&b| vec![a, b]));
        }
    }
    let (n, k) = (points.len(), terms.len());
    if n <= k + 1 {
        return None;
    }
    let size = |factor: usize| points.iter().map(|point| point[factor].abs()).fold(f64::MIN_POSITIVE, f64::max);
    let scales: Vec<f64> = (0..names.len()).map(size).collect();
    let term = |point: &[f64], term: &[usize]| term.iter().map(|&f| point[f] / scales[f]).product::<f64>();
    let design = DMatrix::from_fn(n, k, |i, j| term(&points[i], &terms[j]));
    let target = DVector::from_column_slice(values);
    let svd = design.clone().try_svd(true, true, 5.0 * f64::EPSILON, STEPS)?;
    if svd.singular_values.min() < 1e-10 * svd.singular_values.max() {
        return None;
    }
    let coefficients = svd.solve(&target, 0.0).ok()?;
    let residuals = &target - &design * &coefficients;
    let sum = residuals.norm_squared();
    let deviation = (sum / (n - k) as f64).sqrt();
    let left = svd.u?;
    let standardized = (0..n)
        .map(|i| {
            let leverage = left.row(i).norm_squared();
            residuals[i] / (deviation * (1.0 - leverage).max(0.0).sqrt())
        })
        .collect();
    let name = |term: &[usize]| match term {
        [] => "1".to_owned(),
        [a] => names[*a].to_owned(),
        [a, b] if a == b => format!("{}^2", names[*a]),
        many => many.iter().map(|&f| names[f]).collect::<Vec<_>>().join(" "),
    };
    let unscaled = |j: usize| coefficients[j] / terms[j].iter().map(|&f| scales[f]).product::<f64>();
    Some(Regression {
        terms: terms.iter().enumerate().map(|(j, term)| (name(term), unscaled(j))).collect(),
        rms: (sum / n as f64).sqrt(),
        akaike: n as f64 * (sum / n as f64).ln() + 2.0 * (k + 1) as f64,
        standardized,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Vec<Vec<f64>> {
        let values = |i: usize| vec![6.0 + 2.0 * (i % 5) as f64, 30.0, 10.0 + 5.0 * (i / 5) as f64];
        (0..20).map(values).collect()
    }

    /// A small deterministic disturbance, so that the sum of squares is not rounding.
    fn noise(i: usize) -> f64 {
        1e-3 * ((7 * i % 11) as f64 - 5.0)
    }

    #[test]
    fn a_polynomial_is_found_and_its_order_chosen_by_akaike() {
        let names = ["lambda", "alpha", "P"];
        let points = grid();
        let linear = |p: &[f64]| 2.0 - 0.1 * p[0] + 0.03 * p[2];
        let curved = |p: &[f64]| linear(p) + 0.02 * p[0] * p[0] - 0.004 * p[0] * p[2];
        let values =
            |f: &dyn Fn(&[f64]) -> f64| points.iter().enumerate().map(|(i, p)| f(p) + noise(i)).collect::<Vec<_>>();
        let [first, second] = [1, 2].map(|order| regress(&names, &points, &values(&curved), order).unwrap());
        assert!(second.akaike < first.akaike - 10.0);
        assert_eq!(second.terms.len(), 6);
        let coefficient = |name: &str| second.terms.iter().find(|(term, _)| term == name).unwrap().1;
        assert!((coefficient("lambda^2") - 0.02).abs() < 1e-3 && (coefficient("lambda P") + 0.004).abs() < 1e-3);
        let [first, second] = [1, 2].map(|order| regress(&names, &points, &values(&linear), order).unwrap());
        assert!(first.akaike < second.akaike + 6.0);
        assert!((first.terms[1].1 + 0.1).abs() < 1e-3 && (first.terms[2].1 - 0.03).abs() < 1e-3);
        // Standardized residuals are of size one.
        let mean: f64 = first.standardized.iter().map(|r| r * r).sum::<f64>() / 20.0;
        assert!((mean - 1.0).abs() < 0.15, "{mean}");
    }

    #[test]
    fn too_few_points_are_no_regression() {
        assert!(regress(&["lambda", "alpha", "P"], &grid()[..4], &[1.0, 2.0, 3.0, 4.0], 2).is_none());
    }
}
