//! How fast the state of a member may vary along it.
//!
//! The linear equations of a rod about a state in which it carries the force n and the moment m have solutions e^(±k S)
//! besides polynomials. Under tension they are boundary layers, under compression waves; of both the length is 1/k. In
//! the plane k² = |n|/EI at most; shear and what the rod has turned against n make it less. In space the softer axis
//! counts, and moments add |m|²/(EI min(GJ, EI)): a torque winds the rod, and bending about one axis couples twist with
//! bending about the other.
//!
//! Theory: docs/theory/error.md, Eq. 9.6.

use pennate_elements::small::norm;

use crate::Pack;
use crate::element::SegmentState;
use crate::member::Variation;

/// How fast the state of a member may vary along each of its elements.
pub fn variations<const D: usize>(pack: &dyn Pack<D>, lane: usize) -> Vec<Variation> {
    let mesh = pack.mesh();
    let segments = SegmentState::all(pack, lane);
    let one = |element: usize| {
        let segment = &segments[mesh.segment_of(element)];
        let square = |stress: &[f64; D]| {
            if D == 3 {
                stress[0].hypot(stress[1]) / segment.stiffness(2)
            } else {
                let bending = segment.stiffness(4).min(segment.stiffness(5));
                let force = norm([stress[0], stress[1], stress[2]]);
                let moment = norm([stress[3], stress[4], stress[5]]);
                (force + moment * moment / segment.stiffness(3).min(bending)) / bending
            }
        };
        let stress = pack.stress(lane, element);
        Variation {
            length: mesh.length(lane, element),
            rate: stress[..mesh.order].iter().map(square).fold(0.0, f64::max).sqrt(),
        }
    };
    (0..mesh.elements()).map(one).collect()
}
