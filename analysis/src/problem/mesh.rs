//! One mesh for many designs.

use std::borrow::Cow;

use pennate_models::{Mesh, Model};
use pennate_solver::error::SolveError;

use super::outputs;

/// A mesh that serves some designs.
pub(super) struct Served {
    pub mesh: Mesh,
    /// Estimated error of every output: the largest of these designs.
    pub error: Vec<f64>,
}

/// What serves the designs of both, as far as they have an answer.
pub(super) fn joined(one: Result<Served, SolveError>, other: Result<Served, SolveError>) -> Result<Served, SolveError> {
    match (one, other) {
        (Ok(mut one), Ok(other)) => {
            outputs::join_errors(&mut one.error, &other.error);
            Ok(Served { mesh: finer(one.mesh, other.mesh), error: one.error })
        }
        (Ok(alone), Err(_)) | (Err(_), Ok(alone)) => Ok(alone),
        (refused, Err(_)) => refused,
    }
}

/// The mesh that serves what either of two serves.
///
/// Of meshes that are graded, or of different elements, the one with more nodes is taken.
fn finer(a: Mesh, b: Mesh) -> Mesh {
    let nodes = |mesh: &Mesh| mesh.order * mesh.elements();
    let alike = a.grading.is_empty() && b.grading.is_empty() && a.refinement.len() == b.refinement.len();
    if !alike {
        return if nodes(&b) > nodes(&a) { b } else { a };
    }
    let order = a.order.max(b.order);
    let pairs = a.refinement.iter().zip(&b.refinement);
    let refinement = pairs.map(|(a, b)| a.iter().zip(b).map(|(&a, &b)| a.max(b)).collect()).collect();
    Mesh::new(order, refinement)
}

/// The mesh of one design for another: stretches of graded members keep their parts of their segments.
pub(super) fn fitted<'a>(mesh: &'a Mesh, of: &Model, to: &Model) -> Cow<'a, Mesh> {
    if mesh.grading.is_empty() {
        return Cow::Borrowed(mesh);
    }
    let mut fitted = mesh.clone();
    for (&member, stretches) in &mut fitted.grading {
        let [from, to] = [of, to].map(|model| &model.members[member].segments);
        for stretch in stretches {
            stretch.length *= to[stretch.segment].length / from[stretch.segment].length;
        }
    }
    Cow::Owned(fitted)
}
