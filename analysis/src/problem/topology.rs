//! What all designs of a problem have in common: everything but numbers.

use std::mem::discriminant;

use pennate_models::model::{Body, Member, SegmentLaw, Step};
use pennate_models::{Model, Reading};
use pennate_solver::structure::{Change, Release, Support};

use super::ProblemError;

/// Parts of a parameter by which it is moved to see whether it changes the topology.
const MOVES: [f64; 2] = [1e-3, -1e-3];

/// Refuses a parameter that changes more than numbers.
///
/// Values nearby that make no network tell nothing: they may be out of bounds.
pub(super) fn check(reading: &Reading, middle: &Model, inputs: &[(String, usize)]) -> Result<(), ProblemError> {
    for (name, place) in inputs {
        let value = middle.parameters[*place].value;
        let size = if value == 0.0 { 1.0 } else { value };
        for part in MOVES {
            let Ok(moved) = reading.model(&[(*place, value + part * size)]) else { continue };
            if let Some(what) = difference(middle, &moved) {
                return Err(ProblemError::ChangesTopology { name: name.clone(), what });
            }
        }
    }
    Ok(())
}

/// Whether two networks differ in numbers alone.
pub(super) fn alike(a: &Model, b: &Model) -> bool {
    difference(a, b).is_none()
}

/// What two networks have that is not the same but for numbers.
fn difference(a: &Model, b: &Model) -> Option<&'static str> {
    let same = |what, same: bool| (!same).then_some(what);
    let same_body = |a: &Body, b: &Body| (&a.nodes, a.reference) == (&b.nodes, b.reference);
    let same_support = |a: &Support, b: &Support| (a.node, a.fixed) == (b.node, b.fixed);
    same("dimension", a.dimension == b.dimension && a.stability == b.stability)
        .or_else(|| same("nodes", pairs(&a.nodes, &b.nodes, |a, b| a.name == b.name)))
        .or_else(|| same("members", pairs(&a.members, &b.members, same_member)))
        .or_else(|| same("supports", pairs(&a.supports, &b.supports, same_support)))
        .or_else(|| same("rigid bodies", pairs(&a.bodies, &b.bodies, same_body)))
        .or_else(|| same("springs", pairs(&a.springs, &b.springs, |a, b| a.spring.is_like(&b.spring))))
        .or_else(|| same("steps", pairs(&a.steps, &b.steps, same_step)))
        .or_else(|| same("probes", a.probes.names == b.probes.names))
}

fn pairs<T>(a: &[T], b: &[T], same: fn(&T, &T) -> bool) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b))
}

fn same_member(a: &Member, b: &Member) -> bool {
    let law = |a: &SegmentLaw, b: &SegmentLaw| match (a, b) {
        (SegmentLaw::Fixed(_), SegmentLaw::Fixed(_)) => true,
        (a, b) => a == b,
    };
    a.name == b.name
        && a.nodes == b.nodes
        && a.kind == b.kind
        && a.formulation == b.formulation
        && a.order == b.order
        && a.group == b.group
        && a.releases.iter().zip(&b.releases).all(|(a, b)| same_release(a, b))
        && a.segments.len() == b.segments.len()
        && a.segments.iter().zip(&b.segments).all(|(a, b)| a.elements == b.elements && law(&a.material, &b.material))
}

fn same_release(a: &Release, b: &Release) -> bool {
    match (a, b) {
        (Release::Axes(a), Release::Axes(b)) => a.len() == b.len(),
        (a, b) => discriminant(a) == discriminant(b),
    }
}

fn same_step(a: &Step, b: &Step) -> bool {
    let same_change = |a: &Change, b: &Change| discriminant(a) == discriminant(b) && a.place() == b.place();
    let same_stop = a.stop.map(|stop| discriminant(&stop)) == b.stop.map(|stop| discriminant(&stop));
    a.name == b.name
        && (a.increments, a.method, a.branch) == (b.increments, b.method, b.branch)
        && same_stop
        && a.targets.len() == b.targets.len()
        && a.targets.iter().zip(&b.targets).all(|(a, b)| a.0 == b.0)
        && a.changes.len() == b.changes.len()
        && a.changes.iter().zip(&b.changes).all(|(a, b)| same_change(a, b))
}
