//! Whether a network lies and acts in the plane z = 0.
//!
//! Springs never leave it: their components are those of the global axes.

use nalgebra::Vector3;
use pennate_solver::structure::{Change, ComplianceOf, Release, Support};

use crate::error::Span;
use crate::input;
use crate::input::read::{Map, Spanned};
use crate::model::{Member, Node, SegmentLaw, Step, Target};
use crate::probes::Probes;

/// Below this sine a direction counts as lying in the plane, or along z.
const FLAT: f64 = 1e-9;

/// What leaves the plane, in words, and where it is defined.
pub(crate) type Reason = (String, Span);

/// The first thing that keeps a network out of the plane; `None` where it can be solved there.
pub(crate) fn leaves_plane(
    nodes: &[Node],
    members: &[Member],
    (supports, places): (&[Support], &[Span]),
    steps: &[Step],
) -> Option<Reason> {
    let size = nodes.iter().flat_map(|node| node.position).fold(0.0_f64, |size, x| size.max(x.abs()));
    let out = nodes.iter().find(|node| node.position[2].abs() > 1e-12 * size);
    if let Some(node) = out {
        return Some((format!("node '{}' has z = {}", node.name, node.position[2]), node.span));
    }
    if let Some((member, reason)) = members.iter().find_map(|member| Some((member, member_leaves(member)?))) {
        return Some((format!("member '{}' {reason}", member.name), member.span));
    }
    let turned = supports.iter().zip(places).find(|(support, _)| support.axes[2][2].abs() < 1.0 - FLAT);
    if let Some((support, span)) = turned {
        return Some((format!("the support of node '{}' is turned out of the plane", nodes[support.node].name), *span));
    }
    steps.iter().find_map(|step| Some((format!("step '{}' {}", step.name, step_leaves(step)?), step.span)))
}

/// A stiffness wanted out of the plane is that of the network in space.
pub(crate) fn probe_leaves(probes: &Probes, written: Option<&Map<Spanned<input::Probe>>>) -> Option<Reason> {
    let out = |of: &ComplianceOf| of.along[2..5].iter().any(|&part| part != 0.0);
    let wanted = probes.compliances();
    let names = (0..probes.len()).filter(|&probe| probes.is_stiffness(probe));
    let (index, _) = names.zip(&wanted).find(|(_, of)| out(of))?;
    let span = written?.0.get(index)?.span;
    Some((format!("probe '{}' asks for a stiffness out of the plane", probes.names[index]), span))
}

fn along_z(vector: [f64; 3]) -> bool {
    let vector = Vector3::from(vector);
    vector.xy().norm() <= FLAT * vector.norm()
}

fn member_leaves(member: &Member) -> Option<&'static str> {
    let axes = member.axes;
    if axes[0][2].abs() > FLAT {
        return Some("starts out of the plane");
    }
    let in_line = axes[1][2].abs().max(axes[2][2].abs()) > 1.0 - FLAT;
    let global = |local: [f64; 3]| -> [f64; 3] {
        let along = |axis: usize| Vector3::from(axes[axis]) * local[axis];
        (along(0) + along(1) + along(2)).into()
    };
    for segment in &member.segments {
        if !along_z(global(segment.initial_curvature)) {
            return Some("is curved out of the plane");
        }
        if let SegmentLaw::Fixed(law) = &segment.material {
            let section = &law.section;
            if !in_line && (section.ei2 != section.ei3 || section.ga2 != section.ga3) {
                return Some("has neither of its axes 2 and 3 along z, and different stiffness about them");
            }
            if !along_z(global(law.curvature)) {
                return Some("is actuated out of the plane");
            }
        }
    }
    for release in &member.releases {
        if let Release::Axes(free) = release
            && !free.iter().all(|axis| along_z(*axis))
        {
            return Some("is hinged about an axis in the plane");
        }
    }
    None
}

fn step_leaves(step: &Step) -> Option<&'static str> {
    let load = step.targets.iter().filter(|(_, value)| *value != 0.0).find_map(|(target, _)| match target {
        Target::Force(_, 2) | Target::FollowerForce(_, 2) => Some("has a force along z"),
        Target::Moment(_, 0 | 1) | Target::FollowerMoment(_, 0 | 1) => Some("has a moment about x or y"),
        Target::Gravity(2) => Some("has gravity along z"),
        Target::Distributed(_, 2) => Some("has a distributed force along z"),
        _ => None,
    });
    let out = |component: usize, value: f64| (2..5).contains(&component) && value != 0.0;
    let moved = step.changes.iter().any(|change| match *change {
        Change::Prescribe { component, to, .. } => out(component, to),
        Change::MoveBy { component, by, .. } => out(component, by),
        _ => false,
    });
    load.or(moved.then_some("moves a node out of the plane"))
}
