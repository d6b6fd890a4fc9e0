//! The discretization error of a run, and the mesh that meets the accuracy asked for.
//!
//! The solver repeats the end of every step on a mesh of the next order; what differs there is the error of the mesh in
//! use. Corotational elements count as order 1; what they are compared with are exact ones of order 2, of the same
//! length.

mod error;
mod free;
mod judge;
mod points;
pub(crate) mod refine;
mod together;

use pennate_models::grading::Grading;
use pennate_models::{Mesh, Model, discretize};
use pennate_solver::CoarseSolve;
use pennate_solver::error::SolveError;
use pennate_solver::history::{History, Status, StepHistory};
use pennate_solver::options::{Options, Progress};
use pennate_solver::structure::Structure;

use crate::adapt::{Adapted, Adaptive, Next, adapt};
use crate::solution::{ProbeTable, Solution, Timing};

use self::error::{relative_error, state_errors};
use self::free::compare_with_free;
use self::judge::{every_end_is_estimated, judge};
use self::points::{
    critical_error, estimate_critical_points, has_unknown_points, inherit_errors, keep_lost_points, note_points,
};

pub use self::together::Shared;
pub(crate) use self::together::solve_together;

/// Meshes that are graded for the sake of a step that ends short: where a member is pulled taut its force grows without end, and
/// its layers are as thin as the end is near.
const GRADINGS: usize = 2;

/// The accuracy asked for, and what came of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Relative to the largest value of its kind.
    pub asked: f64,
    /// Estimated error relative to the largest value of its kind; `None` where nothing could be estimated.
    pub estimated: Option<f64>,
    /// Why no finer mesh was tried.
    pub verdict: Verdict,
    /// Meshes that were solved.
    pub rounds: usize,
}

/// Whether the mesh is fine enough.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The error is no larger than asked for.
    Met,
    /// The element counts are forced by the file.
    Forced,
    /// A finer mesh would have too many elements, or too many meshes were tried.
    TooFine,
    /// The last refinement made it no better, on elements that resolve all layers, or none can: what is left is rounding, or
    /// how near to each other branches lie where they meet.
    Stalled,
    /// The finer mesh got less far along the path.
    PathLost,
    /// The error is no larger than asked for, but for singular points that were found on one mesh alone.
    UnknownPoints,
    /// The user did not want to wait for the finer mesh.
    Interrupted,
    /// Nothing to compare with was found for the end of a step, or none has come to its end.
    NotEstimated,
}

impl Verdict {
    /// The word for it in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Met => "met",
            Self::Forced => "forced_elements",
            Self::TooFine => "too_fine_a_mesh",
            Self::Stalled => "rounding",
            Self::PathLost => "path_lost",
            Self::UnknownPoints => "unknown_points",
            Self::Interrupted => "interrupted",
            Self::NotEstimated => "no_estimate",
        }
    }
}

impl Accuracy {
    /// Whether the error is known, and no larger than asked for; not where the finer mesh says otherwise, nor where it knows nothing
    /// of a singular point.
    pub fn is_met(&self) -> bool {
        !matches!(self.verdict, Verdict::PathLost | Verdict::UnknownPoints)
            && self.estimated.is_some_and(|error| error <= self.asked)
    }
}

/// What came of one mesh.
struct Round {
    mesh: Mesh,
    structure: Structure,
    history: History,
    probes: ProbeTable,
    /// Relative error; `None` where it is not known.
    error: Option<f64>,
    /// Part of it that a finer mesh can take away.
    of_mesh: Option<f64>,
    grading: Grading,
}

/// Solves a network on the mesh that its accuracy needs: the estimated error of its probes, or of its nodes where it has
/// none, relative to the largest value of their kind. [`Options::estimate`] must be set, or no error is known.
///
/// `observe` hears of every accepted increment, and stops the solve where it says false.
///
/// # Errors
/// Those of the solver; a step that fails is part of the solution.
pub fn solve_to_accuracy(
    model: Model,
    asked: f64,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Result<Solution, (Box<Model>, SolveError)> {
    let start = (options.clock)();
    let mesh = Mesh::initial(&model, asked);
    let timing = Timing { mesh: (options.clock)().saturating_sub(start), ..Timing::default() };
    let way = mesh.of_the_way(&model, asked);
    let rough = Options { rough: way.is_some(), ..options.clone() };
    let mut search = Search {
        model: &model,
        asked,
        options: rough,
        observe,
        coarse_solve: None,
        points_before: History::default(),
        gradings: 0,
        timing,
    };
    let adapted = match adapt(&mut search, way.unwrap_or(mesh)) {
        Ok(adapted) => adapted,
        Err(error) => return Err((Box::new(model), error)),
    };
    let Adapted { found: mut round, end: mut verdict, rounds } = adapted;
    if round.grading.unresolved || round.error.is_none() {
        verdict = search.compare(&mut round, verdict);
    } else if has_unknown_points(&round.history) {
        verdict = search.compare_points(&mut round, verdict);
    }
    let timing = search.timing;
    let Round { mesh, structure, history, mut probes, error: estimated, .. } = round;
    let errors = state_errors(&model, &structure, &history, &mut probes);
    let accuracy = Accuracy { asked, estimated, verdict, rounds };
    Ok(Solution { model, mesh, history, probes, errors, accuracy, timing })
}

/// The search for a mesh that is fine enough.
struct Search<'a> {
    model: &'a Model,
    asked: f64,
    options: Options,
    observe: &'a mut dyn FnMut(&Progress) -> bool,
    /// Way of the solve on the last mesh.
    coarse_solve: Option<CoarseSolve>,
    /// Singular points of the meshes before the last one that are graded alike.
    points_before: History,
    /// Meshes that were graded anew.
    gradings: usize,
    timing: Timing,
}

impl Adaptive for Search<'_> {
    type Found = Round;
    type Failure = SolveError;
    type End = Verdict;

    fn find(&mut self, mesh: Mesh, best: Option<&Round>) -> Result<Round, SolveError> {
        let (model, clock) = (self.model, self.options.clock);
        let start = clock();
        let (structure, steps) = discretize(model, &mesh);
        let begin = clock();
        self.timing.mesh += begin.saturating_sub(start);
        let coarse = self.coarse_solve.take().zip(best.map(|round| &round.history));
        let solved = pennate_solver::solve_along(&structure, &steps, &self.options, coarse, self.observe);
        let spent = clock().saturating_sub(begin);
        let (mut history, coarse_solve) = solved?;
        self.coarse_solve = coarse_solve;
        self.timing.estimate += history.estimate;
        self.timing.solve += spent.saturating_sub(history.estimate);
        mesh.name_segments(model, &mut history);
        if let Some(before) = best
            && before.mesh.order == mesh.order
            && let Some(ratio) = refine::least_ratio(model, &mesh, &before.mesh)
        {
            note_points(&before.history, &mut self.points_before);
            estimate_critical_points(&self.points_before, &mut history, ratio, mesh.lowest_order(model));
        } else {
            self.points_before = History::default();
        }
        if let Some(before) = best.filter(|before| before.error.is_some() && !before.grading.unresolved) {
            keep_lost_points(&before.history, &mut history);
        }
        let probes = ProbeTable::new(model, &history);
        let known = self.options.rough || every_end_is_estimated(&history);
        let error = relative_error(model, &structure, &history, &probes);
        let [error, of_mesh] = with_points(error, &history).map(|error| error.filter(|_| known));
        self.options.rough = false;
        self.gradings += usize::from(best.is_some_and(|before| before.mesh.grading != mesh.grading));
        let counts = |step: &&StepHistory| step.status == Status::Converged || self.gradings < GRADINGS;
        let states: Vec<_> = history.steps.iter().filter(counts).map(|step| step.variations.as_slice()).collect();
        let grading = mesh.graded(model, &states, self.asked);
        Ok(Round { mesh, structure, history, probes, error, of_mesh, grading })
    }

    fn judge(&self, found: &Round, best: Option<&Round>, rounds: usize) -> Next<Verdict> {
        judge(self.model, found, self.asked, rounds, best)
    }

    /// On a coarser mesh the network was none: a sum of stiff and soft parts lost too many digits on this one.
    fn end_of(&self, SolveError::Mechanism(_): &SolveError) -> Option<Verdict> {
        Some(Verdict::PathLost)
    }

    fn is_better(&self, _: &Round, _: &Round, next: &Next<Verdict>) -> bool {
        !matches!(next, Next::End(Verdict::PathLost | Verdict::Interrupted))
    }
}

impl Search<'_> {
    /// The error of a round that does not tell it itself, against elements that the file does not force, and what becomes
    /// of the verdict.
    fn compare(&mut self, round: &mut Round, verdict: Verdict) -> Verdict {
        round.error = None;
        let interrupted = verdict == Verdict::Interrupted;
        self.compare_with_free(round, interrupted);
        match round.error {
            Some(error) if error <= self.asked => Verdict::Met,
            Some(_) if verdict == Verdict::NotEstimated => Verdict::Forced,
            Some(_) => verdict,
            None if interrupted => verdict,
            None => Verdict::NotEstimated,
        }
    }

    /// The errors of singular points that the last mesh alone has found, or refined in part, against elements that the file does not
    /// force or else by what coarser meshes knew, and what becomes of the verdict.
    fn compare_points(&mut self, round: &mut Round, verdict: Verdict) -> Verdict {
        let before = round.error;
        self.compare_with_free(round, verdict == Verdict::Interrupted);
        let unmet = if has_unknown_points(&round.history) { Verdict::TooFine } else { Verdict::Forced };
        inherit_errors(&self.points_before, &mut round.history);
        // What finer elements of the same mesh say of all else is no less than what those of another one say.
        let error = before.into_iter().chain(round.error).reduce(f64::max);
        [round.error, round.of_mesh] = with_points(error, &round.history);
        match verdict {
            Verdict::Met if round.error.is_some_and(|error| error > self.asked) => unmet,
            Verdict::Met if has_unknown_points(&round.history) => Verdict::UnknownPoints,
            _ => verdict,
        }
    }

    /// Compares a round with elements that the file does not force, where it forces any.
    fn compare_with_free(&mut self, round: &mut Round, interrupted: bool) {
        let start = (self.options.clock)();
        if !interrupted && compare_with_free(self.model, round, self.asked, &self.options, self.observe) {
            round.probes = ProbeTable::new(self.model, &round.history);
            let error = relative_error(self.model, &round.structure, &round.history, &round.probes);
            [round.error, round.of_mesh] = with_points(error, &round.history);
        }
        self.timing.estimate += (self.options.clock)().saturating_sub(start);
    }
}

/// The largest of an error and those of the singular points of a run, and of what a finer mesh can take away of it.
fn with_points(error: Option<f64>, history: &History) -> [Option<f64>; 2] {
    let critical = critical_error(history);
    let with = |critical: Option<f64>| error.into_iter().chain(critical).reduce(f64::max);
    [with(critical.map(|critical| critical.whole)), with(critical.map(|critical| critical.of_mesh))]
}
