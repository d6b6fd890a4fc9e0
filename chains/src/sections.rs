//! Section forces along a member, by statics from the actions on its start.
//!
//! At the nodes of the elements they are as accurate as the displacements of these nodes, which the strains inside of
//! an element are not.

use pennate_elements::beam::interior;
use pennate_elements::interpolation::node;
use pennate_elements::small::{V3, add, apply, axpy, cross, identity, scale, sub, tapply};

use crate::Pack;
use crate::element::SegmentState;
use crate::member::{SectionForces, ShapePoint};
use crate::shape::{moment_about, point, position};

/// Sum of the load along a member up to a place, and its moment about the origin.
#[derive(Clone, Copy, Default)]
struct Carried {
    force: V3<f64>,
    moment: V3<f64>,
}

impl Carried {
    /// Adds a constant load between two places: the integral of the cubic that meets both and their tangents.
    fn add(&mut self, load: V3<f64>, length: f64, from: &ShapePoint, to: &ShapePoint) {
        let mut mean = scale(0.5, add(position(from), position(to)));
        axpy(&mut mean, length / 12.0, sub(from.axes[0], to.axes[0]));
        let force = scale(length, load);
        self.force = add(self.force, force);
        self.moment = add(self.moment, cross(mean, force));
    }
}

/// Section forces at all nodes of the elements, from the actions on the start of the member.
pub fn sections<const D: usize>(
    pack: &dyn Pack<D>,
    lane: usize,
    origin: V3<f64>,
    force: V3<f64>,
    moment: V3<f64>,
) -> Vec<SectionForces> {
    let mesh = pack.mesh();
    let order = mesh.order;
    let segments = SegmentState::all(pack, lane);
    let mut sections = Vec::with_capacity(mesh.elements() * order + mesh.segments());
    let start = point(origin, &pack.node(lane, 0), &pack.unloaded(lane, 0).piece.axes, &identity());
    let mut last = start;
    let mut unloaded = origin;
    let mut carried = Carried::default();
    let mut before = 0.0;
    let total = (0..mesh.elements()).fold(0.0, |whole, e| whole + mesh.length(lane, e));
    let section = |place: &ShapePoint, carried: &Carried, at: f64, segment: usize| {
        let here = position(place);
        let sum = add(force, carried.force);
        let lever = sub(position(&start), here);
        let about = add(add(moment, cross(lever, force)), moment_about(carried.moment, carried.force, here));
        SectionForces {
            at: at / total,
            segment,
            force: apply(&place.axes, &scale(-1.0, sum)),
            moment: apply(&place.axes, &scale(-1.0, about)),
        }
    };
    for e in 0..mesh.elements() {
        let segment = mesh.segment_of(e);
        let own = pack.unloaded(lane, e);
        let (axes, length) = (own.piece.axes, own.piece.length);
        let from = pack.node(lane, e);
        let local = pack.local(lane, e);
        if e == 0 || mesh.segment_of(e - 1) != segment {
            sections.push(section(&last, &carried, before, segment));
        }
        for i in 0..order {
            let reference = own.nodes[i];
            let placement = match i + 1 == order {
                true => pack.node(lane, e + 1),
                false => interior(&own.piece, &from, &local[order - 1], reference, &local[i]),
            };
            let s = node(i + 1, order);
            let next = point(add(unloaded, tapply(&axes, &reference)), &placement, &axes, &own.bend(s));
            carried.add(segments[segment].load, length / order as f64, &last, &next);
            last = next;
            sections.push(section(&last, &carried, before + s * length, segment));
        }
        unloaded = add(unloaded, tapply(&axes, &own.piece.chord));
        before += length;
    }
    sections
}
