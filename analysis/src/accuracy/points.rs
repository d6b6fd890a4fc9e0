//! The errors of singular points: how far a finer mesh moves them along the ramp.

use pennate_solver::history::{CriticalPoint, History, Note, Status, StepHistory};

/// Part of a ramp by which one mesh follows it as far as another one.
const SCATTER: f64 = 0.01;
/// Part of itself by which a singular point is found at best.
const LOCATED: f64 = 1e-9;

/// Whether a singular point was found that no coarser mesh tells the error of.
pub(super) fn has_unknown_points(history: &History) -> bool {
    history.steps.iter().flat_map(|step| &step.critical_points).any(|point| point.error.is_none())
}

/// Whether all singular points whose errors are not known were located nearer than the increments that led past them.
pub(super) fn are_located(history: &History) -> bool {
    let mut unknown = history.steps.iter().flat_map(|step| &step.critical_points).filter(|point| point.error.is_none());
    unknown.all(|point| point.located.is_some())
}

/// Estimates the errors of singular points from how far they lie from those of a coarser mesh, on which every stretch that may have
/// more has `ratio` times fewer elements at least.
///
/// Those of stretches that are the same on both do not show: a column that is straight until it buckles lacks no energy, and is not
/// refined for that.
pub(super) fn estimate_critical_points(coarse: &History, fine: &mut History, ratio: f64, order: usize) {
    let gain = ratio.powi(2 * i32::try_from(order).unwrap_or(1)) - 1.0;
    if gain > 0.0 {
        compare_points(coarse, fine, gain);
    }
}

/// Takes the singular points of a run in place of those of coarser ones, and nothing else of it, but for steps that it did not follow
/// as far: what a coarser mesh found there is all that is known.
pub(super) fn note_points(run: &History, known: &mut History) {
    for (index, step) in run.steps.iter().enumerate() {
        let points = StepHistory {
            fraction: step.fraction,
            critical_points: step.critical_points.clone(),
            ..StepHistory::empty(step.stability)
        };
        match known.steps.get_mut(index) {
            Some(before) if step.fraction < before.fraction - SCATTER => {}
            Some(before) => *before = points,
            None => known.steps.push(points),
        }
    }
}

/// Takes over the singular points of steps that a coarser mesh went to the end of as well, and that are none of those of a run: found
/// on one mesh alone, their errors are not known.
///
/// A mesh that is refined for a leaning state is none that is symmetric, and the path bends to the branch where it met it before.
pub(super) fn keep_lost_points(coarse: &History, fine: &mut History) {
    for (other, own) in coarse.steps.iter().zip(&mut fine.steps) {
        if [other.status, own.status] != [Status::Converged; 2] {
            continue;
        }
        let (others, known) = (&other.critical_points, &own.critical_points);
        let near = |point: &CriticalPoint| {
            known.iter().any(|own| {
                own.in_prestress == point.in_prestress
                    && (own.fraction - point.fraction).abs() <= SCATTER * point.fraction.abs()
            })
        };
        // What the finer mesh counts it knows of.
        let is_counted = |point: &CriticalPoint| {
            let spans =
                |note: &Note| matches!(note, Note::Crowded(crowd) if (crowd.from..=crowd.to).contains(&point.fraction));
            !point.in_prestress && own.notes.iter().any(spans)
        };
        let is_lost = |index: &usize| {
            let point = &others[*index];
            partner(others, *index, known).is_none() && !near(point) && !is_counted(point)
        };
        let lost: Vec<usize> = (0..others.len()).filter(is_lost).collect();
        for point in lost.into_iter().map(|index| &others[index]) {
            // Those of the prestress come first.
            let place = |point: &CriticalPoint| (!point.in_prestress, point.fraction);
            let later = own.critical_points.iter().position(|own| place(own) > place(point));
            // Of increments of this mesh; both paths come to their end, and where one went further it did so by its fraction.
            let increments_before = own.increments.iter().take_while(|before| before.fraction < point.fraction).count();
            let lost = CriticalPoint { error: None, located: None, increments_before, ..point.clone() };
            own.critical_points.insert(later.unwrap_or(own.critical_points.len()), lost);
        }
    }
}

/// Takes for the errors of singular points that have none those of a coarser mesh of the same grading, and how far they were moved
/// since: what the coarser mesh knew holds still.
pub(super) fn inherit_errors(coarse: &History, fine: &mut History) {
    for_partners(coarse, fine, |point, partner, located| {
        let inherited = || Some(partner.error?.max(located) + (point.fraction - partner.fraction).abs());
        point.error.or_else(inherited)
    });
}

/// Takes a part, one over `gain`, of the distance between the singular points of a run and those of another one for their errors;
/// a point that the other run has not keeps its error.
pub(super) fn compare_points(other: &History, own: &mut History, gain: f64) {
    for_partners(other, own, |point, partner, located| {
        Some((point.fraction - partner.fraction).abs() / gain + located)
    });
}

/// Sets the errors of those singular points of a run that another run has too, by the point there and how well the own is located.
fn for_partners(
    other: &History,
    own: &mut History,
    error: impl Fn(&CriticalPoint, &CriticalPoint, f64) -> Option<f64>,
) {
    for (other, own) in other.steps.iter().zip(&mut own.steps) {
        let partners: Vec<_> = (0..own.critical_points.len())
            .map(|index| partner(&own.critical_points, index, &other.critical_points))
            .collect();
        for (point, partner) in own.critical_points.iter_mut().zip(partners) {
            let (Some(partner), Some(located)) = (partner, point.located) else { continue };
            let located = located.max(LOCATED * point.fraction.abs());
            point.error = error(point, partner, located).or(point.error);
        }
    }
}

/// The point among others that is the same one: the nearest of its kind, to which it is the nearest.
fn partner<'a>(own: &[CriticalPoint], index: usize, others: &'a [CriticalPoint]) -> Option<&'a CriticalPoint> {
    let other = &others[nearest(&own[index], others)?];
    (nearest(other, own) == Some(index)).then_some(other)
}

/// The nearest of the same kind.
fn nearest(to: &CriticalPoint, among: &[CriticalPoint]) -> Option<usize> {
    let alike = |(_, other): &(usize, &CriticalPoint)| {
        other.kind == to.kind && other.sideways == to.sideways && other.in_prestress == to.in_prestress
    };
    let distance = |(_, other): &(usize, &CriticalPoint)| (other.fraction - to.fraction).abs();
    let found = among.iter().enumerate().filter(alike).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    Some(found.0)
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
    // What a prestress is a fraction of is all of it: it may pass a point at next to none, as what is loose without it does.
    let size = |point: &CriticalPoint| if point.in_prestress { 1.0 } else { point.fraction.abs() };
    let largest = points().map(size).fold(f64::MIN_POSITIVE, f64::max);
    let errors = || points().filter_map(|point| Some((point.error?, point.error? - point.located?)));
    let whole = errors().map(|(whole, _)| whole).reduce(f64::max)?;
    let of_mesh = errors().map(|(_, of_mesh)| of_mesh).reduce(f64::max)?;
    Some(CriticalError { whole: whole / largest, of_mesh: of_mesh / largest })
}
