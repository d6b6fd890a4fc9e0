//! The errors of singular points: how far a finer mesh moves them along the ramp.

use pennate_models::Mesh;
use pennate_solver::history::History;

/// Part of itself by which a singular point is found at best.
const LOCATED: f64 = 1e-9;

/// Whether a singular point was found that no coarser mesh tells the error of.
pub(super) fn has_unknown_points(history: &History) -> bool {
    history.steps.iter().flat_map(|step| &step.critical_points).any(|point| point.error.is_none())
}

/// Estimates the errors of singular points from how far they lie from those of a coarser mesh.
pub(super) fn estimate_critical_points(
    coarse: &History,
    fine: &mut History,
    elements: usize,
    mesh: &Mesh,
    order: usize,
) {
    let ratio = mesh.elements() as f64 / elements.max(1) as f64;
    let gain = ratio.powi(2 * i32::try_from(order).unwrap_or(1)) - 1.0;
    for (before, now) in coarse.steps.iter().zip(&mut fine.steps) {
        if before.critical_points.len() != now.critical_points.len() || gain <= 0.0 {
            continue;
        }
        for (before, now) in before.critical_points.iter().zip(&mut now.critical_points) {
            let moved = (now.fraction - before.fraction).abs() / gain;
            let located = now.located.map(|located| located.max(LOCATED * now.fraction.abs()));
            now.error = located.filter(|_| before.kind == now.kind).map(|located| moved + located);
        }
    }
}

/// The errors of singular points over the largest fraction of a ramp where there is one.
#[derive(Clone, Copy, Debug)]
pub(super) struct CriticalError {
    /// The largest of all.
    pub whole: f64,
    /// The largest of what a finer mesh can take away: a point that is not located any better stays where it is.
    pub of_mesh: f64,
}

/// The errors of the singular points of a run; `None` where no error is known.
pub(super) fn critical_error(history: &History) -> Option<CriticalError> {
    let points = || history.steps.iter().flat_map(|step| &step.critical_points);
    let largest = points().map(|point| point.fraction.abs()).fold(f64::MIN_POSITIVE, f64::max);
    let errors = || points().filter_map(|point| Some((point.error?, point.error? - point.located?)));
    let whole = errors().map(|(whole, _)| whole).reduce(f64::max)?;
    let of_mesh = errors().map(|(_, of_mesh)| of_mesh).reduce(f64::max)?;
    Some(CriticalError { whole: whole / largest, of_mesh: of_mesh / largest })
}
