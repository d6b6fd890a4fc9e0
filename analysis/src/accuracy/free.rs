//! What results on elements that the file forces are compared with, where these cannot tell their own error.

use pennate_models::Model;
use pennate_solver::options::{Options, Progress};

use super::points::{compare_points, critical_error};
use super::{Round, solve_to_accuracy};
use crate::solution::last_state;

/// Takes the ends of the steps on the mesh that the accuracy needs as what those on elements forced by the file are
/// compared with, and their singular points; false where there is no such mesh.
///
/// Elements of the next order tell nothing where they are as much too long as those that they are compared with, and where the
/// file forces all elements no other mesh tells how far singular points move.
pub(super) fn compare_with_free(
    model: &Model,
    round: &mut Round,
    asked: f64,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> bool {
    let mut free = model.clone();
    let forced = free.members.iter_mut().flat_map(|member| &mut member.segments).map(|segment| &mut segment.elements);
    // All of them are taken, not those up to the first.
    if forced.filter_map(Option::take).count() > 0 {
        let options = Options { shapes: false, near_motion: false, ..options.clone() };
        let Ok(solution) = solve_to_accuracy(free, asked, &options, observe) else { return false };
        if solution.accuracy.estimated.is_none() {
            return false;
        }
        let steps = || round.history.steps.iter().zip(&solution.history.steps);
        let alike = steps().all(|(own, free)| own.status == free.status);
        compare_points(&solution.history, &mut round.history, 1.0);
        if alike {
            for (own, free) in round.history.steps.iter_mut().zip(&solution.history.steps) {
                own.refined = last_state(free).cloned();
            }
        }
        // Ends on elements that are longer than a layer have no error but that against others.
        return alike || !round.grading.unresolved && critical_error(&round.history).is_some();
    }
    false
}
