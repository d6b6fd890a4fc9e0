//! Single lanes of numbers that lie side by side.

use pennate_elements::real::Real;
use pennate_elements::small::V3;
pub(crate) use pennate_elements::small::{lane, lanes};

use crate::MOST_NODES;

pub(crate) fn lane_of<T: Real>(a: &V3<T>, index: usize) -> V3<f64> {
    lane(a, index)
}

/// Numbers of the nodes or Gauss points of an element; what its order does not have is zero.
pub(crate) fn of_element<T: Real, const D: usize>(all: &[[T; D]], index: usize) -> [[f64; D]; MOST_NODES] {
    let mut numbers = [[0.0; D]; MOST_NODES];
    for (target, own) in numbers.iter_mut().zip(all) {
        *target = lane(own, index);
    }
    numbers
}
