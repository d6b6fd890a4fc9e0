//! Deformed shape and section forces of a member.

use pennate_elements::beam::{Placement, interior};
use pennate_elements::interpolation::node;
use pennate_elements::rotation;
use pennate_elements::small::{M3, V3, add, apply, axpy, cross, dot, identity, norm, scale, sub, tapply, tmul};

use crate::Pack;
use crate::element::{SegmentState, at_nodes, at_points};
use crate::member::{MemberShape, ShapeCell, ShapePoint};

/// A member at the middle of its unloaded length.
#[derive(Clone, Copy, Debug)]
pub struct Middle {
    /// Displacement (length) in global axes.
    pub displacement: V3<f64>,
    /// Rotation vector (radians) in global axes.
    pub rotation_vector: V3<f64>,
    /// Unit tangent.
    pub tangent: V3<f64>,
    /// The load along the member up to there.
    pub carried: V3<f64>,
}

/// What a member is at the middle of its unloaded length.
pub fn middle<const D: usize>(pack: &dyn Pack<D>, lane: usize) -> Middle {
    let mesh = pack.mesh();
    let whole = (0..mesh.elements()).fold(0.0, |whole, e| whole + mesh.length(lane, e));
    let mut left = 0.5 * whole;
    let mut carried = [0.0; 3];
    let mut load = [0.0; 3];
    for e in 0..mesh.elements() {
        let (length, segment) = (mesh.length(lane, e), mesh.segment_of(e));
        if e == 0 || segment != mesh.segment_of(e - 1) {
            load = pack.segment(lane, segment).load;
        }
        let here = left.min(length);
        axpy(&mut carried, here, load);
        if left <= length * (1.0 + 1e-12) || e + 1 == mesh.elements() {
            let s = (left / length).min(1.0);
            let (nodes, unloaded) = (pack.local(lane, e), pack.unloaded(lane, e));
            let local = at_nodes(mesh, &nodes, s);
            let place = interior(&unloaded.piece, &pack.node(lane, e), &nodes[mesh.order - 1], [0.0; 3], &local);
            let bend = rotation::exp(scale(s * length, unloaded.curvature));
            let unloaded = tapply(&unloaded.piece.axes, &rotation::turn(bend, [1.0, 0.0, 0.0]));
            return Middle {
                displacement: place.displacement,
                rotation_vector: rotation::log(place.rotation),
                tangent: rotation::turn(place.rotation, unloaded),
                carried,
            };
        }
        left -= length;
    }
    Middle { displacement: [0.0; 3], rotation_vector: [0.0; 3], tangent: [1.0, 0.0, 0.0], carried }
}

/// Shape and section forces; `force` and `moment` act on the start of the member, `origin` is its unloaded place.
pub fn shape<const D: usize>(
    pack: &dyn Pack<D>,
    lane: usize,
    origin: V3<f64>,
    force: V3<f64>,
    moment: V3<f64>,
) -> MemberShape {
    let mesh = pack.mesh();
    let order = mesh.order;
    let segments = SegmentState::all(pack, lane);
    let mut shape = MemberShape::default();
    let start = pack.node(lane, 0);
    let mut first = point(origin, &start, &pack.unloaded(lane, 0).piece.axes, &identity());
    shape.points.push(first);
    let mut unloaded = origin;
    let mut load_so_far = [0.0; 3];
    let mut load_moment = [0.0; 3];
    for e in 0..mesh.elements() {
        let segment = mesh.segment_of(e);
        let own = pack.unloaded(lane, e);
        let axes = own.piece.axes;
        let from = pack.node(lane, e);
        let local = pack.local(lane, e);
        let last = &local[order - 1];
        let strains = pack.strains(lane, e);
        let load = scale(own.piece.length / order as f64, segments[segment].load);
        for i in 0..order {
            let reference = own.nodes[i];
            let placement = match i + 1 == order {
                true => pack.node(lane, e + 1),
                false => interior(&own.piece, &from, last, reference, &local[i]),
            };
            let at = add(unloaded, tapply(&axes, &reference));
            let next = point(at, &placement, &axes, &own.bend(node(i + 1, order)));

            // Statics: what acts on the start and on the part before the middle of the cell, on the curved axis.
            let s = node(2 * i + 1, 2 * order);
            let position_here = own.position(s);
            let moved = interior(&own.piece, &from, last, position_here, &at_nodes(mesh, &local, s)).displacement;
            let middle = add(add(unloaded, tapply(&axes, &position_here)), moved);
            let here = sub(position(&shape.points[0]), middle);
            let half = scale(0.5, load);
            let quarter = scale(0.5, add(position(&first), middle));
            let total = add(force, add(load_so_far, half));
            let about = add(add(moment, cross(here, force)), moment_about(load_moment, load_so_far, middle));
            let about = add(about, cross(sub(quarter, middle), half));
            let mean = mean_axes(&first.axes, &next.axes);
            let strain = at_points(mesh, &strains, s);
            let kappa = if D == 6 { [strain[4], strain[5]] } else { [0.0, strain[2]] };
            let curvature = (kappa[0] + own.curvature[1]).hypot(kappa[1] + own.curvature[2]);
            shape.cells.push(ShapeCell {
                segment,
                force: apply(&mean, &scale(-1.0, total)),
                moment: apply(&mean, &scale(-1.0, about)),
                strain: strain[0],
                induced_strain: segments[segment].moduli.rest[0],
                curvature,
            });
            load_moment = add(load_moment, cross(middle, load));
            load_so_far = add(load_so_far, load);
            shape.points.push(next);
            first = next;
        }
        unloaded = add(unloaded, tapply(&axes, &own.piece.chord));
    }
    shape
}

/// Moment about `place` of forces whose moment about the origin and whose sum are known.
pub(crate) fn moment_about(about_origin: V3<f64>, sum: V3<f64>, place: V3<f64>) -> V3<f64> {
    sub(about_origin, cross(place, sum))
}

pub(crate) fn position(point: &ShapePoint) -> V3<f64> {
    add(point.reference, point.displacement)
}

/// Rows normalized between those of two neighbouring frames.
fn mean_axes(a: &M3<f64>, b: &M3<f64>) -> M3<f64> {
    let first = add(a[0], b[0]);
    let first = scale(1.0 / norm(first), first);
    let second = add(a[1], b[1]);
    let second = sub(second, scale(dot(first, second), first));
    let second = scale(1.0 / norm(second), second);
    [first, second, cross(first, second)]
}

/// `axes` are the unloaded axes of the element's start by rows, `bend` leads from them to those of the point.
pub(crate) fn point(reference: V3<f64>, placement: &Placement, axes: &M3<f64>, bend: &M3<f64>) -> ShapePoint {
    let unloaded = tmul(bend, axes);
    ShapePoint {
        reference,
        displacement: placement.displacement,
        rotation: rotation::log(placement.rotation),
        axes: unloaded.map(|axis| rotation::turn(placement.rotation, axis)),
    }
}
