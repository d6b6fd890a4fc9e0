//! Single lanes of numbers that lie side by side.

use pennate_elements::real::Real;
use pennate_elements::small::V3;
pub(crate) use pennate_elements::small::{lane, lanes};

pub(crate) fn lane_of<T: Real>(a: &V3<T>, index: usize) -> V3<f64> {
    lane(a, index)
}
