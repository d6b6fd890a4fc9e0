//! How fast the state of a member may vary along it.
//!
//! The linear equations of a rod about a state in which it carries the force n and the moment m have solutions e^(±k S)
//! besides polynomials. Under tension they are boundary layers, under compression waves; of both the length is 1/k. In
//! the plane k² = |n|/EI at most; shear and what the rod has turned against n make it less. In space the softer axis
//! counts, and moments add |m|²/(EI min(GJ, EI)): a torque winds the rod, and bending about one axis couples twist with
//! bending about the other.
//!
//! Theory: docs/theory/error.md, Eq. 9.6.

use pennate_elements::beam::Beam;
use pennate_elements::real::Real;
use pennate_elements::small::norm;

use crate::held::stiffness;
use crate::member::Variation;
use crate::{Chain, lanes};

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    pub(super) fn variations_impl(&self, lane: usize) -> Vec<Variation> {
        let one = |element: usize| {
            let moduli = &self.moduli[self.mesh.segment_of[element]];
            let stiffness = |d: usize| stiffness(moduli, d, lane);
            let square = |stress: &[T; D]| {
                let stress = lanes::lane(stress, lane);
                if D == 3 {
                    stress[0].hypot(stress[1]) / stiffness(2)
                } else {
                    let bending = stiffness(4).min(stiffness(5));
                    let force = norm([stress[0], stress[1], stress[2]]);
                    let moment = norm([stress[3], stress[4], stress[5]]);
                    (force + moment * moment / stiffness(3).min(bending)) / bending
                }
            };
            let stress = &self.state.stress[element * P..(element + 1) * P];
            Variation {
                length: self.pieces[element].length.lane(lane),
                rate: stress.iter().map(square).fold(0.0, f64::max).sqrt(),
            }
        };
        (0..self.mesh.elements()).map(one).collect()
    }
}
