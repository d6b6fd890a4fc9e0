//! Deformed shape, section forces and strains of a member.

use pennate_elements::beam::{Beam, Placement};
use pennate_elements::interpolation::node;
use pennate_elements::real::{Real, Work};
use pennate_elements::rotation;
use pennate_elements::small::{M3, V3, add, apply, axpy, cross, norm, scale, sub, tapply, tmul};

use crate::held::stiffness;
use crate::lanes::{self, lane_of, lanes};
use crate::member::{MemberShape, ShapeCell, ShapePoint};
use crate::{Chain, Pack};

/// Local unknowns of one element, as work in lanes.
struct LocalUnknowns<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize>(&'a Chain<T, B, D, P>, usize);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for LocalUnknowns<'_, T, B, D, P> {
    type Output = [[T; D]; P];

    #[inline(always)]
    fn run(self) -> [[T; D]; P] {
        let Self(chain, e) = self;
        let frame = B::frame(&chain.pieces[e], &chain.state.nodes[e], &chain.state.nodes[e + 1]);
        chain.local_of(e, &frame)
    }
}

/// Strains of one element, as work in lanes.
pub(super) struct Strains<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize>(
    pub(super) &'a Chain<T, B, D, P>,
    pub(super) usize,
);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Strains<'_, T, B, D, P> {
    type Output = [[T; D]; P];

    #[inline(always)]
    fn run(self) -> [[T; D]; P] {
        let Self(chain, e) = self;
        let local = LocalUnknowns(chain, e).run();
        B::strains(&chain.at(e, &local))
    }
}

/// Largest strain that a held component has, beyond that which its mixed stress explains, as work in lanes.
struct Violation<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize>(&'a Chain<T, B, D, P>);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Violation<'_, T, B, D, P> {
    type Output = T;

    #[inline(always)]
    fn run(self) -> T {
        let Self(chain) = self;
        let mut largest = T::zero();
        for (e, &segment) in chain.mesh.segment_of.iter().enumerate() {
            let moduli = &chain.moduli[segment];
            let (mut held, mut compliance) = (T::zero(), [T::zero(); D]);
            for d in 0..D {
                held += moduli.held[d];
                compliance[d] = (T::one() - moduli.held[d]) / moduli.stiffness[d];
            }
            if (0..T::LANES).all(|lane| held.lane(lane) == 0.0) {
                continue;
            }
            let strains = Strains(chain, e).run();
            let stress = chain.stress_of(e);
            for g in 0..P {
                for d in 0..D {
                    let own = compliance[d] * stress[g][d];
                    let off = moduli.held[d] * (strains[g][d] - moduli.rest[d] - own);
                    largest = largest.max(off.abs());
                }
            }
        }
        largest
    }
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    pub(super) fn violation_impl(&self) -> f64 {
        let largest = T::run(Violation(self));
        (0..T::LANES).fold(0.0, |all, lane| all.max(largest.lane(lane)))
    }

    pub(super) fn middle_impl(&self, lane: usize) -> (V3<f64>, V3<f64>) {
        let mut left = 0.5 * self.total_length.lane(lane);
        let mut carried = [0.0; 3];
        for (e, piece) in self.pieces.iter().enumerate() {
            let length = piece.length.lane(lane);
            let here = left.min(length);
            axpy(&mut carried, here, lane_of(&self.loads[self.mesh.segment_of[e]], lane));
            if left <= length * (1.0 + 1e-12) || e + 1 == self.pieces.len() {
                let s = (left / length).min(1.0);
                let (local, _) = self.sample(lane, e, s);
                let first = self.element_end(lane, e);
                let place = B::interior(piece, &first, [0.0; 3], local, lane);
                let bend = rotation::exp(scale(s * length, self.initial_curvature(e, lane)));
                let unloaded = tapply(&lanes(&piece.axes, lane), &rotation::turn(bend, [1.0, 0.0, 0.0]));
                return (rotation::turn(place.rotation, unloaded), carried);
            }
            left -= length;
        }
        ([1.0, 0.0, 0.0], carried)
    }

    pub(super) fn shape_impl(&self, lane: usize, origin: V3<f64>, force: V3<f64>, moment: V3<f64>) -> MemberShape {
        let mut shape = MemberShape::default();
        let start = self.element_end(lane, 0);
        let mut first = point(origin, &start, &lanes(&self.pieces[0].axes, lane), &pennate_elements::small::identity());
        shape.points.push(first);
        let mut unloaded = origin;
        let mut load_so_far = [0.0; 3];
        let mut load_moment = [0.0; 3];
        for e in 0..self.frames.len() {
            let segment = self.mesh.segment_of[e];
            let axes = lanes(&self.pieces[e].axes, lane);
            let from = self.element_end(lane, e);
            let local = self.local_unknowns(e);
            let strains = self.strains(e);
            let length = self.pieces[e].length.lane(lane);
            let load = scale(length / P as f64, lanes::lane(&self.loads[segment], lane));
            for i in 0..P {
                let reference = lanes::lane(&self.reference(e, i), lane);
                let placement = if i + 1 == P {
                    self.element_end(lane, e + 1)
                } else {
                    B::interior(&self.pieces[e], &from, reference, lanes::lane(&local[i], lane), lane)
                };
                let bend = self.curves.get(e).map(|_| self.bend(e, lane, i));
                let at = add(unloaded, tapply(&axes, &reference));
                let next = point(at, &placement, &axes, &bend.unwrap_or(pennate_elements::small::identity()));

                // Statics: what acts on the start and on the part before the middle of the cell, on the curved axis.
                let s = node(2 * i + 1, 2 * P);
                let moved = self.place_impl(lane, e, s).displacement;
                let middle = add(add(unloaded, tapply(&axes, &self.unloaded(lane, e, s))), moved);
                let here = sub(position(&shape.points[0]), middle);
                let half = scale(0.5, load);
                let quarter = scale(0.5, add(position(&first), middle));
                let total = add(force, add(load_so_far, half));
                let about = add(add(moment, cross(here, force)), moment_about(load_moment, load_so_far, middle));
                let about = add(about, cross(sub(quarter, middle), half));
                let mean = mean_axes(&first.axes, &next.axes);
                let strain = strains[i.min(P - 1)];
                let kappa =
                    if D == 6 { [strain[4].lane(lane), strain[5].lane(lane)] } else { [0.0, strain[2].lane(lane)] };
                let initial = self.initial_curvature(e, lane);
                let curvature = (kappa[0] + initial[1]).hypot(kappa[1] + initial[2]);
                shape.cells.push(ShapeCell {
                    segment,
                    force: apply(&mean, &scale(-1.0, total)),
                    moment: apply(&mean, &scale(-1.0, about)),
                    strain: strain[0].lane(lane),
                    induced_strain: self.moduli[segment].rest[0].lane(lane),
                    curvature,
                });
                load_moment = add(load_moment, cross(middle, load));
                load_so_far = add(load_so_far, load);
                shape.points.push(next);
                first = next;
            }
            unloaded = add(unloaded, tapply(&axes, &lane_of(&self.pieces[e].chord, lane)));
        }
        shape
    }

    /// Energy of the Legendre component of order P − 1 of the strains; held ones have none.
    pub(super) fn top_energy_impl(&self, lane: usize) -> f64 {
        // The highest polynomial that P Gauss points see, up to a factor: the alternating one of the divided difference.
        let points = &self.table.points;
        let mode: [f64; P] = std::array::from_fn(|g| {
            let product: f64 = (0..P).filter(|&o| o != g).map(|o| points[g] - points[o]).product();
            1.0 / product
        });
        let size: f64 = (0..P).map(|g| mode[g] * mode[g] / self.table.weights[g]).sum();
        let mut energy = 0.0;
        for e in 0..self.frames.len() {
            let strains = self.strains(e);
            let moduli = &self.moduli[self.mesh.segment_of[e]];
            for d in 0..D {
                if moduli.held[d].lane(lane) < 1.0 {
                    let top: f64 = (0..P).map(|g| mode[g] * strains[g][d].lane(lane)).sum();
                    let stiffness = stiffness(moduli, d, lane) * self.pieces[e].length.lane(lane);
                    energy += 0.5 * stiffness * top * top / size;
                }
            }
        }
        energy
    }

    pub(super) fn strains(&self, e: usize) -> [[T; D]; P] {
        T::run(Strains(self, e))
    }

    /// Local unknowns of an element.
    pub(super) fn local_unknowns(&self, e: usize) -> [[T; D]; P] {
        T::run(LocalUnknowns(self, e))
    }

    /// Rotation vector from the first to the last Gauss frame over their distance: the initial curvature.
    pub(super) fn initial_curvature(&self, e: usize, lane: usize) -> V3<f64> {
        let Some(curve) = self.curves.get(e) else { return [0.0; 3] };
        let s = self.table.points[0] * self.pieces[e].length.lane(lane);
        let frame = lanes(&curve.frames[0], lane);
        let axis = [frame[2][1] - frame[1][2], frame[0][2] - frame[2][0], frame[1][0] - frame[0][1]];
        let sine = 0.5 * norm(axis);
        let cosine = 0.5 * (frame[0][0] + frame[1][1] + frame[2][2] - 1.0);
        if sine == 0.0 { [0.0; 3] } else { scale(sine.atan2(cosine) / (2.0 * sine * s), axis) }
    }

    /// Unloaded axes at node i + 1 of an element in those of its start: the columns.
    pub(super) fn bend(&self, e: usize, lane: usize, i: usize) -> M3<f64> {
        let s = node(i + 1, P) * self.pieces[e].length.lane(lane);
        rotation::matrix(rotation::exp(scale(s, self.initial_curvature(e, lane))))
    }
}

/// Moment about `place` of forces whose moment about the origin and whose sum are known.
pub(super) fn moment_about(about_origin: V3<f64>, sum: V3<f64>, place: V3<f64>) -> V3<f64> {
    sub(about_origin, cross(place, sum))
}

pub(super) fn position(point: &ShapePoint) -> V3<f64> {
    add(point.reference, point.displacement)
}

/// Rows normalized between those of two neighbouring frames.
fn mean_axes(a: &M3<f64>, b: &M3<f64>) -> M3<f64> {
    let first = add(a[0], b[0]);
    let first = scale(1.0 / norm(first), first);
    let second = add(a[1], b[1]);
    let second = sub(second, scale(pennate_elements::small::dot(first, second), first));
    let second = scale(1.0 / norm(second), second);
    [first, second, cross(first, second)]
}

/// `axes` are the unloaded axes of the element's start by rows, `bend` leads from them to those of the point.
pub(super) fn point(reference: V3<f64>, placement: &Placement, axes: &M3<f64>, bend: &M3<f64>) -> ShapePoint {
    let unloaded = tmul(bend, axes);
    ShapePoint {
        reference,
        displacement: placement.displacement,
        rotation: rotation::log(placement.rotation),
        axes: unloaded.map(|axis| rotation::turn(placement.rotation, axis)),
    }
}
