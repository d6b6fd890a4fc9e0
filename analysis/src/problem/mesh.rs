//! One mesh for many designs.

use std::borrow::Cow;

use pennate_models::{Mesh, Model, Stretch};
use pennate_solver::error::SolveError;

use super::outputs;

/// Part of an element that rounding of lengths makes of its stretch.
const ROUNDING: f64 = 1e-6;

/// A mesh that serves some designs.
pub(super) struct Served {
    pub mesh: Mesh,
    /// Estimated error of every output: the largest of these designs.
    pub error: Vec<f64>,
}

/// What serves the designs of both, as far as they have an answer; meshes are those for the network of `model`.
pub(super) fn joined(
    one: Result<Served, SolveError>,
    other: Result<Served, SolveError>,
    model: &Model,
) -> Result<Served, SolveError> {
    match (one, other) {
        (Ok(mut one), Ok(other)) => {
            outputs::join_errors(&mut one.error, &other.error);
            Ok(Served { mesh: finer(&one.mesh, &other.mesh, model), error: one.error })
        }
        (Ok(alone), Err(_)) | (Err(_), Ok(alone)) => Ok(alone),
        (refused, Err(_)) => refused,
    }
}

/// The mesh that serves what either of two serves: as high an order, and nowhere longer elements.
fn finer(a: &Mesh, b: &Mesh, model: &Model) -> Mesh {
    let mut mesh = Mesh::new(a.order.max(b.order), Vec::with_capacity(model.members.len()));
    for member in 0..model.members.len() {
        let counts = [a, b].map(|mesh| &mesh.refinement[member]);
        if [a, b].iter().any(|mesh| mesh.grading.contains_key(&member)) {
            let (stretches, counts) = overlaid([a, b].map(|mesh| stretches(mesh, model, member)));
            mesh.grading.insert(member, stretches);
            mesh.refinement.push(counts);
        } else {
            mesh.refinement.push(counts[0].iter().zip(counts[1]).map(|(&a, &b)| a.max(b)).collect());
        }
    }
    mesh
}

/// The stretches of a member, and how many elements each has.
fn stretches(mesh: &Mesh, model: &Model, member: usize) -> Vec<(Stretch, usize)> {
    let counts = mesh.refinement[member].iter().enumerate();
    counts.map(|(index, &count)| (mesh.stretch(model, member, index), count)).collect()
}

/// Stretches of one member divided where those of either end, with elements as short as the shorter ones there, and their numbers.
fn overlaid([one, other]: [Vec<(Stretch, usize)>; 2]) -> (Vec<Stretch>, Vec<usize>) {
    let (mut stretches, mut counts) = (Vec::new(), Vec::new());
    let [mut one, mut other] = [one, other].map(|stretches| stretches.into_iter().map(Piece::of).peekable());
    while let (Some(a), Some(b)) = (one.peek_mut(), other.peek_mut()) {
        let length = f64::min(a.left, b.left);
        stretches.push(Stretch { segment: a.segment, length });
        counts.push((length / f64::min(a.element, b.element) - ROUNDING).ceil().max(1.0) as usize);
        for (pieces_left, element) in [(&mut a.left, a.element), (&mut b.left, b.element)] {
            *pieces_left -= length;
            // What rounding leaves of a stretch is none.
            if *pieces_left <= ROUNDING * element {
                *pieces_left = 0.0;
            }
        }
        let ends = [a.left == 0.0, b.left == 0.0];
        one.next_if(|_| ends[0]);
        other.next_if(|_| ends[1]);
    }
    (stretches, counts)
}

/// What is left of a stretch, and the length of its elements.
struct Piece {
    segment: usize,
    left: f64,
    element: f64,
}

impl Piece {
    fn of((stretch, count): (Stretch, usize)) -> Self {
        Self { segment: stretch.segment, left: stretch.length, element: stretch.length / count as f64 }
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlaid_stretches_are_as_fine_as_either() {
        let stretch = |segment, length, count| (Stretch { segment, length }, count);
        let one = vec![stretch(0, 60.0, 3), stretch(0, 40.0, 8), stretch(1, 30.0, 1)];
        let other = vec![stretch(0, 100.0, 10), stretch(1, 10.0, 4), stretch(1, 20.000_000_000_001, 1)];
        let (stretches, counts) = overlaid([one, other]);
        let found: Vec<_> = stretches.iter().map(|stretch| (stretch.segment, stretch.length.round())).collect();
        assert_eq!(found, [(0, 60.0), (0, 40.0), (1, 10.0), (1, 20.0)]);
        assert_eq!(counts, [6, 8, 4, 1]);
    }
}
