//! The state of a chain taken over by one of another order, or by a spatial one.

use pennate_elements::beam::Beam;
use pennate_elements::interpolation::{node, shapes};
use pennate_elements::real::Real;
use pennate_elements::small::axpy;

use super::lanes;
use super::{Chain, Pack};

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    pub(super) fn prolong_impl(&mut self, coarse: &dyn Pack<D>) {
        for lane in 0..self.members.len() {
            for index in 0..self.state.nodes.len() {
                B::set_pose(&mut self.state.nodes[index], lane, &coarse.element_end(lane, index));
            }
            for e in 0..self.frames.len() {
                for i in 0..P {
                    let (local, _) = coarse.sample(lane, e, node(i + 1, P));
                    let (_, stress) = coarse.sample(lane, e, self.table.points[i]);
                    for d in 0..D {
                        self.state.local[e * P + i][d].set_lane(lane, local[d]);
                        self.state.stress[e * P + i][d].set_lane(lane, stress[d]);
                    }
                }
            }
        }
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
