//! Lagrange interpolation of order P on [0, 1] and Gauss quadrature with P points.
//!
//! Theory: docs/theory/quadrature.md, Eq. 3.1 and 3.2.

/// Values and slopes of the shape functions of nodes 1…P at the P Gauss points of the unit interval.
///
/// Node 0 is left out: local quantities vanish there.
#[derive(Clone, Copy, Debug)]
pub struct Table<const P: usize> {
    /// Gauss points in (0, 1) and their weights, which sum to one.
    pub points: [f64; P],
    /// Weights of the integration points; their sum is one.
    pub weights: [f64; P],
    /// `values[g][i]`: shape function of node i + 1 at Gauss point g.
    pub values: [[f64; P]; P],
    /// Slopes with respect to the unit coordinate.
    pub slopes: [[f64; P]; P],
    /// Integrals over the unit interval of the shape functions of nodes 1…P.
    pub integrals: [f64; P],
}

/// Position of node i (of 0…P) in the unit interval.
pub fn node(i: usize, order: usize) -> f64 {
    i as f64 / order as f64
}

/// Values and slopes at `s` of the shape functions of nodes 1…P.
pub fn shapes<const P: usize>(s: f64) -> ([f64; P], [f64; P]) {
    let mut values = [0.0; P];
    let mut slopes = [0.0; P];
    for i in 1..=P {
        let mut value = 1.0;
        let mut slope = 0.0;
        for j in (0..=P).filter(|&j| j != i) {
            let d = node(i, P) - node(j, P);
            slope = slope * (s - node(j, P)) / d + value / d;
            value *= (s - node(j, P)) / d;
        }
        values[i - 1] = value;
        slopes[i - 1] = slope;
    }
    (values, slopes)
}

impl<const P: usize> Default for Table<P> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const P: usize> Table<P> {
    /// The points and shape functions of order P.
    pub fn new() -> Self {
        let (points, weights) = gauss::<P>();
        let mut values = [[0.0; P]; P];
        let mut slopes = [[0.0; P]; P];
        for g in 0..P {
            (values[g], slopes[g]) = shapes::<P>(points[g]);
        }
        // P Gauss points integrate the shape functions, polynomials of order P ≤ 2P − 1, exactly.
        let integrals = std::array::from_fn(|i| (0..P).map(|g| weights[g] * values[g][i]).sum());
        Self { points, weights, values, slopes, integrals }
    }
}

/// Gauss points and weights on [0, 1], by Newton's iteration on the Legendre polynomial.
pub fn gauss<const P: usize>() -> ([f64; P], [f64; P]) {
    let mut points = [0.0; P];
    let mut weights = [0.0; P];
    for g in 0..P {
        let mut x = -((g as f64 + 0.75) / (P as f64 + 0.5) * std::f64::consts::PI).cos();
        let mut slope = 1.0;
        for _ in 0..30 {
            let (mut previous, mut value) = (1.0, x);
            for n in 2..=P {
                let n = n as f64;
                (previous, value) = (value, ((2.0 * n - 1.0) * x * value - (n - 1.0) * previous) / n);
            }
            slope = P as f64 * (x * value - previous) / (x * x - 1.0);
            let step = value / slope;
            x -= step;
            if step.abs() < 1e-16 {
                break;
            }
        }
        points[g] = 0.5 * (1.0 + x);
        weights[g] = 1.0 / ((1.0 - x * x) * slope * slope);
    }
    (points, weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadrature_is_exact_to_order_2p_minus_1() {
        let (points, weights) = gauss::<4>();
        for power in 0..8 {
            let sum: f64 = (0..4).map(|g| weights[g] * points[g].powi(power)).sum();
            assert!((sum - 1.0 / (power as f64 + 1.0)).abs() < 1e-15);
        }
        assert_eq!(gauss::<1>(), ([0.5], [1.0]));
    }

    #[test]
    fn shape_functions_reproduce_a_cubic_and_its_slope() {
        let f = |s: f64| s * s * s - 0.4 * s;
        let (values, slopes) = shapes::<3>(0.37);
        let value: f64 = (1..=3).map(|i| values[i - 1] * f(node(i, 3))).sum();
        let slope: f64 = (1..=3).map(|i| slopes[i - 1] * f(node(i, 3))).sum();
        assert!((value - f(0.37)).abs() < 1e-15);
        assert!((slope - (3.0 * 0.37f64.powi(2) - 0.4)).abs() < 1e-14);
    }
}
