//! Single lanes of numbers that lie side by side, and block products.

use pennate_elements::real::Real;
use pennate_elements::small::{V3, mul, sub};

// Loops: a closure that `map` calls takes its number by way of the stack.
#[inline]
pub fn lane<T: Real, const N: usize>(a: &[T; N], lane: usize) -> [f64; N] {
    let mut own = [0.0; N];
    for i in 0..N {
        own[i] = a[i].lane(lane);
    }
    own
}

#[inline]
pub fn lanes<T: Real, const N: usize, const M: usize>(a: &[[T; M]; N], index: usize) -> [[f64; M]; N] {
    let mut own = [[0.0; M]; N];
    for i in 0..N {
        for j in 0..M {
            own[i][j] = a[i][j].lane(index);
        }
    }
    own
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
