//! The state of a chain taken over by one of another order, or by a spatial one.

use pennate_elements::beam::{Beam, Piece, Placement};
use pennate_elements::interpolation::{node, shapes};
use pennate_elements::real::Real;
use pennate_elements::small::{axpy, scale};

use super::lanes;
use super::{Bent, Chain, Pack};

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    pub(super) fn prolong_impl(&mut self, lane: usize, coarse: &dyn Pack<D>, from: usize) {
        if self.frames.len() == coarse.elements() {
            self.enrich(lane, coarse, from);
        } else {
            self.divide(lane, coarse, from);
        }
    }

    /// Takes over the state of a member of the same elements and another order.
    fn enrich(&mut self, lane: usize, coarse: &dyn Pack<D>, from: usize) {
        for index in 0..self.state.nodes.len() {
            B::set_pose(&mut self.state.nodes[index], lane, &coarse.element_end(from, index));
        }
        for e in 0..self.frames.len() {
            for i in 0..P {
                let (local, _) = coarse.sample(from, e, node(i + 1, P));
                let (_, stress) = coarse.sample(from, e, self.table.points[i]);
                for d in 0..D {
                    self.state.local[e * P + i][d].set_lane(lane, local[d]);
                    self.state.stress[e * P + i][d].set_lane(lane, stress[d]);
                }
            }
        }
    }

    /// Takes over the state of a member of the same segments, divided into another number of elements.
    fn divide(&mut self, lane: usize, coarse: &dyn Pack<D>, from: usize) {
        let mut element = 0;
        for segment in 0..self.segments {
            let (start, count) = coarse.elements_of(segment);
            let own = self.elements_of(segment).1;
            // Element of the coarse member, and the place in it.
            let locate = |x: f64| {
                let x = x * count as f64 / own as f64;
                let e = (x as usize).min(count - 1);
                (start + e, x - e as f64)
            };
            for k in 0..own {
                let ends = [k, k + 1].map(|k| {
                    let (e, s) = locate(k as f64);
                    coarse.place(from, e, s)
                });
                B::set_pose(&mut self.state.nodes[element], lane, &ends[0]);
                B::set_pose(&mut self.state.nodes[element + 1], lane, &ends[1]);
                for i in 0..P {
                    let (e, s) = locate(k as f64 + node(i + 1, P));
                    let mut pose = B::Pose::default();
                    B::set_pose(&mut pose, lane, &coarse.place(from, e, s));
                    let piece = Piece { chord: self.reference(element, i), ..self.pieces[element] };
                    let frame = B::frame(&piece, &self.state.nodes[element], &pose);
                    let local = lanes::lane(&B::last_local(&frame), lane);
                    let (e, s) = locate(k as f64 + self.table.points[i]);
                    let (_, stress) = coarse.sample(from, e, s);
                    for d in 0..D {
                        self.state.local[element * P + i][d].set_lane(lane, local[d]);
                        self.state.stress[element * P + i][d].set_lane(lane, stress[d]);
                    }
                }
                element += 1;
            }
        }
    }

    pub(super) fn place_impl(&self, lane: usize, element: usize, s: f64) -> Placement {
        let piece = &self.pieces[element];
        let reference = if self.curves.is_empty() {
            scale(s, piece.chord.map(|x| x.lane(lane)))
        } else {
            let bent = Bent { length: piece.length.lane(lane), curvature: self.initial_curvature(element, lane) };
            bent.position(s * bent.length)
        };
        let (local, _) = self.sample_impl(lane, element, s);
        B::interior(piece, &self.element_end(lane, element), reference, local, lane)
    }

    pub(super) fn lift_impl(&mut self, plane: &dyn Pack<3>) {
        for lane in 0..self.members.len() {
            for index in 0..self.state.nodes.len() {
                B::set_pose(&mut self.state.nodes[index], lane, &plane.element_end(lane, index));
            }
            for e in 0..self.frames.len() {
                for i in 0..P {
                    let (local, _) = plane.sample(lane, e, node(i + 1, P));
                    let (_, stress) = plane.sample(lane, e, self.table.points[i]);
                    let flat = [local[0], local[1], 0.0, 0.0, 0.0, (0.5 * local[2]).tan()];
                    let forces = [stress[0], stress[1], 0.0, 0.0, 0.0, stress[2]];
                    for d in 0..D {
                        self.state.local[e * P + i][d].set_lane(lane, flat[d]);
                        self.state.stress[e * P + i][d].set_lane(lane, forces[d]);
                    }
                }
            }
        }
    }

    pub(super) fn sample_impl(&self, lane: usize, element: usize, s: f64) -> ([f64; D], [f64; D]) {
        let local = self.local_unknowns(element);
        let (values, _) = shapes::<P>(s);
        let mut at = [0.0; D];
        for i in 0..P {
            axpy(&mut at, values[i], lanes::lane(&local[i], lane));
        }
        // Lagrange interpolation through the Gauss points.
        let mut stress = [0.0; D];
        for g in 0..P {
            let mut weight = 1.0;
            for other in (0..P).filter(|&o| o != g) {
                weight *= (s - self.table.points[other]) / (self.table.points[g] - self.table.points[other]);
            }
            axpy(&mut stress, weight, lanes::lane(&self.state.stress[element * P + g], lane));
        }
        (at, stress)
    }
}
