//! Second-order differentiation: a value with its gradient and Hessian in N variables.
//!
//! For the few energies whose derivatives are long to write and seldom evaluated (springs with rotations).

use std::ops::{Add, Mul, Sub};

/// A value with exact first and second derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Jet<const N: usize> {
    /// Value of the function.
    pub value: f64,
    /// First derivatives by the N variables.
    pub gradient: [f64; N],
    /// Second derivatives by them.
    pub hessian: [[f64; N]; N],
}

impl<const N: usize> Jet<N> {
    /// A number that depends on none of the variables.
    pub fn constant(value: f64) -> Self {
        Self { value, gradient: [0.0; N], hessian: [[0.0; N]; N] }
    }

    /// The variable with this index, at this value.
    pub fn variable(value: f64, index: usize) -> Self {
        let mut jet = Self::constant(value);
        jet.gradient[index] = 1.0;
        jet
    }

    /// A multiple.
    pub fn scaled(self, s: f64) -> Self {
        self.mapped(s * self.value, s, 0.0)
    }

    /// f of this, given the value of f and its first two derivatives there.
    pub fn mapped(self, value: f64, first: f64, second: f64) -> Self {
        let g = self.gradient;
        Self {
            value,
            gradient: g.map(|x| first * x),
            hessian: std::array::from_fn(|i| {
                std::array::from_fn(|j| first * self.hessian[i][j] + second * g[i] * g[j])
            }),
        }
    }

    /// The reciprocal.
    pub fn recip(self) -> Self {
        let r = 1.0 / self.value;
        self.mapped(r, -r * r, 2.0 * r * r * r)
    }
}

impl<const N: usize> Add for Jet<N> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            gradient: std::array::from_fn(|i| self.gradient[i] + other.gradient[i]),
            hessian: std::array::from_fn(|i| std::array::from_fn(|j| self.hessian[i][j] + other.hessian[i][j])),
        }
    }
}

impl<const N: usize> Sub for Jet<N> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + other.scaled(-1.0)
    }
}

impl<const N: usize> Mul for Jet<N> {
    type Output = Self;
    #[allow(clippy::suspicious_arithmetic_impl, reason = "product rule")]
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self, other);
        Self {
            value: a.value * b.value,
            gradient: std::array::from_fn(|i| a.value * b.gradient[i] + b.value * a.gradient[i]),
            hessian: std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    a.value * b.hessian[i][j]
                        + b.value * a.hessian[i][j]
                        + a.gradient[i] * b.gradient[j]
                        + a.gradient[j] * b.gradient[i]
                })
            }),
        }
    }
}
