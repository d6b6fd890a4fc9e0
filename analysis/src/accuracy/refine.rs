//! By how much shorter the elements of a mesh must be.
//!
//! Nodal values converge with h^2p, so elements shorter by the factor (2 e / asked)^(1/2p) are expected to do for the error
//! e, with a margin of two.

use pennate_models::{Mesh, Model};
use pennate_solver::history::History;

/// A mesh is refined by no more at once: an error far above what was asked for is a poor guide.
const MAX_FACTOR: usize = 8;
/// Elements of a member at most.
const MAX_ELEMENTS: usize = 100_000;

/// The mesh with elements half as long.
pub(crate) fn halved(model: &Model, mesh: &Mesh) -> Mesh {
    mesh.refined(model, &vec![2; mesh.refinement.len()])
}

/// The mesh with elements shorter by one factor, where members do not get too many of them.
pub(crate) fn shortened(model: &Model, mesh: &Mesh, factor: usize) -> Mesh {
    let factors: Vec<usize> = mesh.refinement.iter().map(|segments| capped(factor, segments)).collect();
    mesh.refined(model, &factors)
}

/// Whether a member has as many elements as it may.
pub(crate) fn is_at_limit(mesh: &Mesh) -> bool {
    mesh.refinement.iter().any(|segments| capped(2, segments) == 1)
}

/// How many times the elements of the mesh before a mesh has at least, in any stretch that may have more; nothing where they are
/// graded differently.
pub(crate) fn least_ratio(model: &Model, mesh: &Mesh, before: &Mesh) -> Option<f64> {
    if mesh.grading != before.grading {
        return None;
    }
    let members = mesh.refinement.iter().zip(&before.refinement).enumerate();
    let ratios = members.flat_map(|(member, (now, then))| {
        let counts = now.iter().zip(then).enumerate();
        let free = counts.filter(move |(index, _)| mesh.is_free_at(model, member, *index));
        free.map(|(_, (&now, &then))| now as f64 / then as f64)
    });
    Some(ratios.reduce(f64::min).unwrap_or(1.0))
}

/// Whether every stretch that may have more elements on a mesh than on the one before has twice as many.
pub(crate) fn is_finer_everywhere(model: &Model, mesh: &Mesh, before: &Mesh) -> bool {
    least_ratio(model, mesh, before).is_some_and(|ratio| ratio >= 2.0)
}

/// How many times the elements of another mesh a mesh has in every stretch; nothing where that is not one number of two or more.
pub(crate) fn multiplied(mesh: &Mesh, other: &Mesh) -> Option<usize> {
    let counts = || mesh.refinement.iter().flatten().zip(other.refinement.iter().flatten());
    let (first, before) = counts().next()?;
    let times = first / before;
    let is_same = times > 1 && counts().all(|(now, before)| *now == times * before);
    (is_same && mesh.grading == other.grading).then_some(times)
}

/// By how much shorter elements of one order must be for an error that is too large by `excess`.
pub(crate) fn refinement_factor(excess: f64, order: usize) -> usize {
    let factor = (2.0 * excess).powf(0.5 / order as f64).ceil();
    (factor as usize).clamp(2, MAX_FACTOR)
}

/// Energy that every member lacks in the worst step; empty where none was estimated.
pub(crate) fn missing(history: &History) -> Vec<f64> {
    history.steps.iter().map(|step| &step.missing).fold(Vec::new(), |worst, here| match worst.is_empty() {
        true => here.clone(),
        false if here.is_empty() => worst,
        false => worst.iter().zip(here).map(|(a, b)| a.max(*b)).collect(),
    })
}

/// What members lack that have elements which the file leaves to choose, nothing of the others, and which part of all it is.
pub(crate) fn missing_where_free(model: &Model, missing: Vec<f64>) -> (Vec<f64>, f64) {
    let members = missing.iter().zip(&model.members);
    let of_free: Vec<f64> =
        members.map(|(lacks, member)| if member.has_free_elements() { *lacks } else { 0.0 }).collect();
    let share = of_free.iter().sum::<f64>() / missing.iter().sum::<f64>();
    if share.is_finite() { (of_free, share) } else { (missing, 1.0) }
}

/// Factors for the elements of all members that reduce an error which is too large by `excess`.
///
/// The error is taken to go with the energy that the elements lack: member i, refined by f, keeps f^-2p of its part.
/// The fewest elements that do have f proportional to (energy / elements)^(1/(2p + 1)).
pub(crate) fn member_factors(mesh: &Mesh, order: usize, missing: &[f64], excess: f64) -> Vec<usize> {
    let uniform = refinement_factor(excess, order);
    let total: f64 = missing.iter().sum();
    let counts: Vec<f64> = mesh.refinement.iter().map(|segments| segments.iter().sum::<usize>() as f64).collect();
    if !(total > 0.0 && total.is_finite()) || missing.len() != counts.len() {
        return mesh.refinement.iter().map(|segments| capped(uniform, segments)).collect();
    }
    let exponent = 2.0 * order as f64;
    let wish: Vec<f64> = missing.iter().zip(&counts).map(|(m, n)| (m / n).powf(1.0 / (exponent + 1.0))).collect();
    let factors = |scale: f64| wish.iter().map(move |w| (scale * w).clamp(1.0, MAX_FACTOR as f64));
    let left = |scale: f64| missing.iter().zip(factors(scale)).map(|(m, f)| m * f.powf(-exponent)).sum::<f64>();
    let target = total / (2.0 * excess);
    let largest = wish.iter().copied().fold(0.0, f64::max);
    let smallest = wish.iter().copied().filter(|w| *w > 0.0).fold(largest, f64::min);
    // The scale at which just enough is left, between no refinement and the most.
    let (mut low, mut high) = ((1.0 / largest).ln(), (MAX_FACTOR as f64 / smallest).ln());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if left(middle.exp()) > target { low = middle } else { high = middle }
    }
    let factors: Vec<usize> = factors(high.exp()).map(|f| (f - 0.05).ceil().max(1.0) as usize).collect();
    let factors: Vec<usize> = mesh.refinement.iter().zip(factors).map(|(segments, f)| capped(f, segments)).collect();
    // Rounding down must not end in the same mesh again.
    if factors.iter().all(|&f| f == 1) {
        return mesh.refinement.iter().map(|segments| capped(uniform, segments)).collect();
    }
    factors
}

/// The factor, made smaller where a member would get too many elements.
pub(crate) fn capped(factor: usize, segments: &[usize]) -> usize {
    factor.min(MAX_ELEMENTS / segments.iter().sum::<usize>().max(1)).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_shrink_as_the_order_demands() {
        assert_eq!(refinement_factor(32.0, 3), 2); // 64^(1/6)
        assert_eq!(refinement_factor(33.0, 3), 3);
        assert_eq!(refinement_factor(5000.0, 1), MAX_FACTOR);
        assert_eq!(refinement_factor(1.001, 4), 2);
    }

    #[test]
    fn members_do_not_grow_without_bound() {
        assert_eq!(capped(50, &[10, 20, 10]), 50);
        assert_eq!(capped(50, &[10_000, 20_000]), 3);
        assert_eq!(capped(2, &[60_000]), 1);
    }
}
