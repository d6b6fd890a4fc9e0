//! The base mechanism: its members as wires, its input guided, each member cut at the points that are looked at.

use std::collections::VecDeque;

use nalgebra::{Matrix3, Rotation3, Vector3};
use pennate_models::model::{FixedLaw, LoadFlow, Member, MemberKind, Segment, SegmentLaw, Units};
use pennate_models::section::{self, Stiffening};
use pennate_models::{Mesh, Model, discretize};
use pennate_solver::structure::{self, Dimension, Formulation, NodeId, Release, Stability, Structure, Support};

/// Pieces of every member: the points looked at lie between them.
pub(super) const PIECES: usize = 8;
/// The wire that stands for a muscle of the base mechanism: the steel wire of the dissertation, section 3.4.
const WIRE_RADIUS: f64 = 0.75; // mm
const WIRE_MODULUS: f64 = 2e5; // MPa
const WIRE_POISSON: f64 = 0.3;
/// Elements of a piece that is curved; straight pieces of one section are exact with one.
const CURVED_ELEMENTS: usize = 4;
/// Order of the elements.
const ORDER: usize = 3;
const GLOBAL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The mechanism that a load flow is about, unloaded and without steps.
pub(super) fn base(model: &Model, request: &LoadFlow) -> Model {
    let mut base = model.clone();
    base.steps.clear();
    base.probes = Default::default();
    base.stability = Stability::Plane;
    base.members = request.members.iter().map(|&member| wire(model, &model.members[member])).collect();
    let places: Vec<_> = base.nodes.iter().map(|node| Vector3::from(node.position)).collect();
    for spring in &mut base.springs {
        if let Some([a, b]) = spring.spring.pair() {
            spring.spring.relax((places[b] - places[a]).norm());
        }
    }
    for input in request.inputs.iter().filter(|input| input.guided) {
        base.supports.retain(|support| support.node != input.node);
        base.supports.push(guide(input.node, &input.load, model.dimension));
    }
    for node in unused(&base) {
        base.supports.retain(|support| support.node != node);
        base.supports.push(Support { node, fixed: [true; 6], axes: GLOBAL });
    }
    base
}

/// A muscle as the wire that it stands for.
fn wire(model: &Model, member: &Member) -> Member {
    if !member.is_muscle() {
        return member.clone();
    }
    let (length, stress) = match model.units {
        Units::MmNMpa => (1.0, 1.0),
        Units::MNPa => (1e-3, 1e6),
    };
    let shape = section::circle(WIRE_RADIUS * length);
    let modulus = WIRE_MODULUS * stress;
    let stiffening = Stiffening { shear: false, stretch: true, shear_factor: None };
    let section = shape.section(modulus, modulus / (2.0 * (1.0 + WIRE_POISSON)), stiffening);
    let law = FixedLaw { section, radius: shape.radius, shape: Some(shape), strain: 0.0, curvature: [0.0; 3] };
    let material = SegmentLaw::Fixed(law);
    let segment = Segment { length: member.length, material, initial_curvature: [0.0; 3], elements: None };
    Member { kind: MemberKind::Passive, segments: vec![segment], ..member.clone() }
}

/// A support that leaves nothing but the motion along a unit load.
fn guide(node: NodeId, load: &[f64; 6], dimension: Dimension) -> Support {
    let turns = load[3..] != [0.0; 3];
    let along = Vector3::from_column_slice(if turns { &load[3..] } else { &load[..3] });
    if dimension == Dimension::Plane && turns {
        return Support { node, fixed: [true, true, true, true, true, false], axes: GLOBAL };
    }
    let upright = along.cross(&Vector3::z()).norm() < 1e-9;
    let second = if upright { Vector3::y() } else { Vector3::z().cross(&along).normalize() };
    let mut fixed = [true; 6];
    fixed[if turns { 3 } else { 0 }] = false;
    Support { node, fixed, axes: [along.into(), second.into(), along.cross(&second).into()] }
}

/// Nodes that nothing is attached to, where members were left out.
fn unused(model: &Model) -> Vec<NodeId> {
    let mut used = vec![false; model.nodes.len()];
    model.members.iter().for_each(|member| member.nodes.iter().for_each(|&node| used[node] = true));
    model.bodies.iter().flat_map(|body| &body.nodes).for_each(|&node| used[node] = true);
    for spring in &model.springs {
        spring.spring.nodes().iter().for_each(|&node| used[node] = true);
    }
    (0..used.len()).filter(|&node| !used[node]).collect()
}

/// Points of a member: its nodes in the cut structure and the unit tangents there, ends included.
pub(super) struct Points {
    pub(super) nodes: Vec<NodeId>,
    pub(super) tangents: Vec<Vector3<f64>>,
}

/// The structure of a mechanism, every member cut into [`PIECES`] of one length.
pub(super) fn cut(base: &Model) -> (Structure, Vec<Points>) {
    let (whole, _) =
        discretize(base, &Mesh::new(ORDER, base.members.iter().map(|m| vec![1; m.segments.len()]).collect()));
    let mut structure =
        Structure { members: Vec::new(), compliances: Vec::new(), sections: Vec::new(), ..whole.clone() };
    let points = whole.members.iter().map(|member| pieces(member, &mut structure)).collect();
    (structure, points)
}

fn pieces(member: &structure::Member, structure: &mut Structure) -> Points {
    let total = member.length();
    let mut rest: VecDeque<structure::Segment> = member.segments.iter().copied().collect();
    let mut axes = Matrix3::from_columns(&member.axes.map(Vector3::from));
    let mut place = Vector3::from(structure.nodes[member.nodes[0]]);
    let mut points = Points { nodes: vec![member.nodes[0]], tangents: vec![axes.column(0).into_owned()] };
    let releases = releases(member, structure.dimension);
    for piece in 0..PIECES {
        let start = axes;
        let mut segments = Vec::new();
        let mut left = total / PIECES as f64;
        while let Some(next) = rest.front_mut()
            && left > 1e-12 * total
        {
            // What rounding leaves of a segment belongs to it.
            let ends = next.length <= left + 1e-12 * total;
            let length = if ends { next.length } else { left };
            let curvature = Vector3::from(next.initial_curvature);
            let elements = if curvature == Vector3::zeros() { 1 } else { CURVED_ELEMENTS };
            segments.push(structure::Segment { length, elements, ..*next });
            place += axes * along(curvature, length);
            axes *= Rotation3::new(curvature * length).matrix();
            left -= length;
            next.length -= length;
            if ends {
                rest.pop_front();
            }
        }
        // Two-node elements are exact here, and hold shear-rigid sections without an auxiliary stiffness, which costs digits.
        let is_plain = segments.iter().all(|segment| {
            let section = structure.laws[segment.law].at(0.0).section;
            segment.initial_curvature == [0.0; 3] && section.ea.is_finite()
        });
        let (formulation, order) =
            if is_plain { (Formulation::Corotational, 1) } else { (member.formulation, member.order) };
        let end = if piece + 1 == PIECES { member.nodes[1] } else { structure.nodes.len() };
        if end == structure.nodes.len() {
            structure.nodes.push(place.into());
        }
        let release = |at: usize, is_end: bool| if is_end { releases[at].clone() } else { Release::Welded };
        structure.members.push(structure::Member {
            nodes: [points.nodes[piece], end],
            axes: [0, 1, 2].map(|axis| start.column(axis).into_owned().into()),
            segments,
            releases: [release(0, piece == 0), release(1, piece + 1 == PIECES)],
            control: member.control,
            formulation,
            order,
        });
        points.nodes.push(end);
        points.tangents.push(axes.column(0).into_owned());
    }
    points
}

/// From the start of a rod of constant curvature to a point of it, in the axes at the start.
fn along(curvature: Vector3<f64>, length: f64) -> Vector3<f64> {
    let tangent = Vector3::x();
    let size = curvature.norm();
    let angle = size * length;
    // Below this the chord is the arc within rounding.
    if angle < 1e-9 {
        return tangent * length;
    }
    let once = curvature.cross(&tangent);
    tangent * length
        + once * ((1.0 - angle.cos()) / (size * size))
        + curvature.cross(&once) * ((angle - angle.sin()) / size.powi(3))
}

/// The releases of a member; in space a bar that is pinned at both ends keeps its spin at the start, which no force
/// belongs to, and which its pieces would otherwise have each.
fn releases(member: &structure::Member, dimension: Dimension) -> [Release; 2] {
    match (&member.releases, dimension) {
        ([Release::Pin, Release::Pin], Dimension::Space) => {
            [Release::Axes(vec![member.axes[1], member.axes[2]]), Release::Pin]
        }
        (releases, _) => releases.clone(),
    }
}
