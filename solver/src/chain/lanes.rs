//! Single lanes of numbers that lie side by side, and block products.

use pennate_elements::real::Real;
use pennate_elements::small::{V3, mul, sub};
pub(crate) use pennate_elements::small::{lane, lanes};

pub(crate) fn lane_of<T: Real>(a: &V3<T>, index: usize) -> V3<f64> {
    lane(a, index)
}

#[inline(always)]
pub(crate) fn sub_matrix<T: Real, const N: usize, const M: usize>(a: [[T; M]; N], b: [[T; M]; N]) -> [[T; M]; N] {
    let mut c = a;
    for i in 0..N {
        c[i] = sub(a[i], b[i]);
    }
    c
}

#[inline(always)]
pub(crate) fn mul_block<T: Real, const D: usize>(a: &[[T; D]; D], b: &[[T; D]; D]) -> [[T; D]; D] {
    mul(a, b)
}
