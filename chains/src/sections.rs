//! Section forces along a member, by statics from the actions on its start.
//!
//! At the nodes of the elements they are as accurate as the displacements of these nodes, which the strains inside of
//! an element are not.

use pennate_elements::beam::Beam;
use pennate_elements::interpolation::node;
use pennate_elements::real::Real;
use pennate_elements::small::{V3, add, apply, axpy, cross, identity, scale, sub, tapply};

use crate::Chain;
use crate::lanes::{self, lane_of, lanes};
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

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    pub(super) fn sections_impl(
        &self,
        lane: usize,
        origin: V3<f64>,
        force: V3<f64>,
        moment: V3<f64>,
    ) -> Vec<SectionForces> {
        let mut sections = Vec::with_capacity(self.frames.len() * P + self.mesh.segments());
        let start = point(origin, &self.element_end_of(lane, 0), &lanes(&self.pieces[0].axes, lane), &identity());
        let mut last = start;
        let mut unloaded = origin;
        let mut carried = Carried::default();
        let mut before = 0.0;
        let total = self.total_length.lane(lane);
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
        for (e, piece) in self.pieces.iter().enumerate() {
            let segment = self.mesh.segment_of[e];
            let axes = lanes(&piece.axes, lane);
            let from = self.element_end_of(lane, e);
            let local = self.local_unknowns(e);
            let length = piece.length.lane(lane);
            let load = lane_of(&self.loads[segment], lane);
            if e == 0 || self.mesh.segment_of[e - 1] != segment {
                sections.push(section(&last, &carried, before, segment));
            }
            for i in 0..P {
                let reference = lanes::lane(&self.reference(e, i), lane);
                let placement = match i + 1 == P {
                    true => self.element_end_of(lane, e + 1),
                    false => B::interior(piece, &from, reference, lanes::lane(&local[i], lane), lane),
                };
                let bend = match self.curves.get(e) {
                    Some(_) => self.bend(e, lane, i),
                    None => identity(),
                };
                let next = point(add(unloaded, tapply(&axes, &reference)), &placement, &axes, &bend);
                carried.add(load, length / P as f64, &last, &next);
                last = next;
                sections.push(section(&last, &carried, before + node(i + 1, P) * length, segment));
            }
            unloaded = add(unloaded, tapply(&axes, &lane_of(&piece.chord, lane)));
            before += length;
        }
        sections
    }

    fn element_end_of(&self, lane: usize, index: usize) -> pennate_elements::beam::Placement {
        B::pose(&self.state.nodes[index], lane)
    }
}
