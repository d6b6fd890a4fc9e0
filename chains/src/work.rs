//! Loads along a member and their work.

use pennate_elements::beam::interior;
use pennate_elements::small::{V3, axpy, dot};

use crate::Pack;
use crate::element::SegmentState;

/// Sum of the load along a member.
pub fn total_load<const D: usize>(pack: &dyn Pack<D>, lane: usize) -> V3<f64> {
    let mesh = pack.mesh();
    let mut total = [0.0; 3];
    for segment in 0..mesh.segments() {
        let load = pack.segment(lane, segment).load;
        for _ in 0..mesh.elements_of(segment).1 {
            axpy(&mut total, mesh.element_length(lane, segment), load);
        }
    }
    total
}

/// Work of the load along a member from the unloaded state.
pub fn load_work<const D: usize>(pack: &dyn Pack<D>, lane: usize) -> f64 {
    let mesh = pack.mesh();
    let integrals = mesh.integrals();
    let segments = SegmentState::all(pack, lane);
    let mut work = 0.0;
    for element in 0..mesh.elements() {
        let load = segments[mesh.segment_of(element)].load;
        if load == [0.0; 3] {
            continue;
        }
        let (first, last) = (pack.node(lane, element), pack.node(lane, element + 1));
        let (unloaded, local) = (pack.unloaded(lane, element), pack.local(lane, element));
        let mut mean = [0.0; 3];
        for (i, &weight) in integrals[..mesh.order - 1].iter().enumerate() {
            let place = interior(&unloaded.piece, &first, &local[mesh.order - 1], unloaded.nodes[i], &local[i]);
            axpy(&mut mean, weight, place.displacement);
        }
        axpy(&mut mean, integrals[mesh.order - 1], last.displacement);
        axpy(&mut mean, 1.0 - integrals.iter().sum::<f64>(), first.displacement);
        work += unloaded.piece.length * dot(load, mean);
    }
    work
}
