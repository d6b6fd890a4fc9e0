//! What a mesh is worth: whether it is fine enough, whether a finer one would help, and which.

use pennate_models::{Mesh, Model};
use pennate_solver::history::{History, Note, Status};

use super::points::{are_located, has_unknown_points};
use super::refine::{halved, is_at_limit, is_finer_everywhere, member_factors, missing, missing_where_free, shortened};
use super::{Round, Verdict};
use crate::adapt::Next;

/// Meshes that are tried at most, and as many where some are spent on grading or there is no estimate yet.
const ROUNDS: usize = 6;
const MAX_ROUNDS: usize = 8;
/// Meshes that are tried at most for a singular point of which a path tells no more than an increment: on finer ones it is no different.
const TRIES: usize = 3;
/// Relative error below which every refinement pays, as long as rounding is not in the way.
const ASYMPTOTIC: f64 = 1e-4;
/// By how much a limit point may move along a step's ramp from one mesh to the next.
const MESH_SCATTER: f64 = 0.05;
/// A path that a finer mesh follows no farther than this ends where it says.
const CONFIRMED: f64 = 0.01;

/// What to do after so many rounds, with what came of the last mesh and of the best one before it.
pub(super) fn judge(model: &Model, round: &Round, asked: f64, rounds: usize, best: Option<&Round>) -> Next<Verdict> {
    let Round { mesh, history, error, of_mesh, grading, .. } = round;
    let error = *error;
    let interrupted = history.steps.iter().any(|step| step.status == Status::Interrupted);
    if let Some(before) = best {
        if interrupted {
            return Next::End(Verdict::Interrupted);
        }
        // A finer mesh that finds a singular point on the way is right; one that finds nothing at all is lost.
        let lost = history.steps.iter().any(|step| step.status == Status::NotConverged);
        if lost && progress_of(history) < progress_of(&before.history) - MESH_SCATTER {
            // Where what the coarser mesh says is not to be trusted, a still finer one may follow the path.
            let trusted = before.error.is_some() && !before.grading.unresolved;
            let finer = grading.finer.clone().unwrap_or_else(|| halved(model, mesh));
            let open = !trusted && rounds < MAX_ROUNDS && finer != *mesh;
            return if open { Next::Refine(finer) } else { Next::End(Verdict::PathLost) };
        }
    }
    // What found the way of a large network is not near its end; and a higher order takes away more than elements half as long, but
    // tells less of singular points than more elements of the same order.
    let of_states = error.filter(|_| history.steps.iter().all(|step| step.critical_points.is_empty()));
    let raised = match mesh.is_of_the_way(asked) {
        true => Some(mesh.raised(asked, error)),
        false => mesh.higher(model, asked, of_states),
    };
    if let (Some((order, left)), false) = (raised, interrupted) {
        if let Some(finer) = &grading.finer {
            return Next::Refine(Mesh { order, ..finer.clone() });
        }
        let missing = missing(history);
        // A few members lack most of the energy: shorter elements there cost little.
        let factors = match missing.is_empty() {
            true => vec![1; mesh.refinement.len()],
            false => member_factors(mesh, order, &missing, (left / asked).max(1.0)),
        };
        return Next::Refine(Mesh { order, ..mesh.refined(model, &factors) });
    }
    // What elements that are longer than a layer say of a path or of an error is nothing.
    if let (Some(finer), true) = (&grading.finer, !interrupted && rounds < MAX_ROUNDS) {
        return Next::Refine(finer.clone());
    }
    // A path that ends early may do so for want of elements: a second mesh confirms it.
    let complete = history.steps.iter().all(|step| step.status == Status::Converged);
    let gained = best.is_none_or(|before| progress_of(history) > progress_of(&before.history) + CONFIRMED);
    if !complete && gained && rounds < ROUNDS {
        let finer = shortened(model, mesh, 2 * rounds);
        if finer != *mesh {
            return Next::Refine(finer);
        }
    }
    // The next order has another verdict on an end: it is nearer to a singular point than the mesh can tell.
    if !interrupted && is_too_coarse(history) && rounds < MAX_ROUNDS {
        let finer = halved(model, mesh);
        if finer != *mesh {
            return Next::Refine(finer);
        }
    }
    // A singular point is known as well as the last mesh moved it, where the mesh before it found it too.
    let most = if are_located(history) { ROUNDS } else { TRIES };
    if has_unknown_points(history) && rounds < most {
        let finer = halved(model, mesh);
        if finer != *mesh {
            return Next::Refine(finer);
        }
    }
    let Some(error) = error else {
        // Where the next order leads nowhere, shorter elements are another way.
        let shorter = halved(model, mesh);
        let open = !interrupted && !every_end_is_estimated(history) && rounds < MAX_ROUNDS && shorter != *mesh;
        return if open { Next::Refine(shorter) } else { Next::End(Verdict::NotEstimated) };
    };
    if error <= asked {
        return Next::End(Verdict::Met);
    }
    let of_mesh = of_mesh.unwrap_or(error);
    if of_mesh <= asked {
        return Next::End(Verdict::Stalled);
    }
    // What elements lack that the file forces, no finer ones beside them make up for.
    let is_forced = Mesh::is_forced(model);
    let (missing, share) = missing_where_free(model, missing(history));
    let of_free = share * of_mesh;
    if of_free <= asked {
        return Next::End(Verdict::Forced);
    }
    // An error that does not count what is not known of singular points is no measure of progress.
    let before = best.filter(|before| !has_unknown_points(&before.history)).and_then(|before| before.error);
    // At the end of a step that rounding does not tell from a singular state, displacements are what rounding makes them, on any mesh.
    let may_stall = error < ASYMPTOTIC || ends_within_rounding(history) || is_forced;
    let stalled = may_stall && before.is_some_and(|before| error > 0.5 * before);
    // Errors of elements that are longer than a layer fall as they like.
    let fine = grading.longest <= 1.0;
    if stalled && fine && best.is_some_and(|before| is_finer_everywhere(model, mesh, &before.mesh)) {
        return Next::End(if is_forced { Verdict::Forced } else { Verdict::Stalled });
    }
    let factors = match stalled {
        // Finer members here and there were of no use.
        true => vec![2; mesh.refinement.len()],
        false => member_factors(mesh, mesh.lowest_order(model), &missing, of_free / asked),
    };
    let finer = mesh.refined(model, &factors);
    if finer == *mesh {
        return Next::End(if is_at_limit(mesh) { Verdict::TooFine } else { Verdict::Forced });
    }
    let most = if mesh.grading.is_empty() { ROUNDS } else { MAX_ROUNDS };
    if rounds >= most { Next::End(Verdict::TooFine) } else { Next::Refine(finer) }
}

/// Whether elements of the next order have another verdict on the end of a step, or other vibrations about it.
fn is_too_coarse(history: &History) -> bool {
    let tells = |note: &Note| matches!(note, Note::TooCoarse | Note::VibrationsUnknown);
    history.steps.iter().any(|step| step.notes.iter().any(tells))
}

/// Whether rounding hides if the end of a step is a singular state.
fn ends_within_rounding(history: &History) -> bool {
    history.steps.iter().any(|step| step.notes.contains(&Note::WithinRounding))
}

/// Whether the end of every step that has come to it was found on a finer mesh too.
pub(super) fn every_end_is_estimated(history: &History) -> bool {
    history.steps.iter().all(|step| step.status != Status::Converged || step.refined.is_some())
}

/// How far along its steps a run came: those done, and the fraction of the next.
fn progress_of(history: &History) -> f64 {
    let converged = history.steps.iter().take_while(|step| step.status == Status::Converged).count();
    converged as f64 + history.steps.get(converged).map_or(0.0, |step| step.fraction.max(0.0))
}
