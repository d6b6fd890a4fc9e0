//! Single lanes of numbers that lie side by side, and block products.

use pennate_elements::real::Real;
use pennate_elements::small::{V3, mul, sub};

pub fn lane<T: Real, const N: usize>(a: &[T; N], lane: usize) -> [f64; N] {
    a.map(|x| x.lane(lane))
}

pub fn lanes<T: Real, const N: usize, const M: usize>(a: &[[T; M]; N], index: usize) -> [[f64; M]; N] {
    a.map(|row| lane(&row, index))
}

pub fn lane_of<T: Real>(a: &V3<T>, index: usize) -> V3<f64> {
    lane(a, index)
}

#[inline(always)]
pub fn sub_matrix<T: Real, const N: usize, const M: usize>(a: [[T; M]; N], b: [[T; M]; N]) -> [[T; M]; N] {
    let mut c = a;
    for i in 0..N {
        c[i] = sub(a[i], b[i]);
    }
    c
}

#[inline(always)]
pub fn mul_block<T: Real, const D: usize>(a: &[[T; D]; D], b: &[[T; D]; D]) -> [[T; D]; D] {
    mul(a, b)
}
