//! The discretization error of a run, and the mesh that meets the accuracy asked for.
//!
//! The solver repeats the end of every step on a mesh of the next order; what differs there is the error e of
//! the mesh in use. Nodal values converge with h^2p, so elements shorter by the factor (2 e / asked)^(1/2p)
//! are expected to do, with a margin of two. Corotational elements count as order 1; what they are compared with are
//! exact ones of order 2, of the same length.

use std::time::Instant;

use pennate_models::grading::Grading;
use pennate_models::probes::ProbeKind;
use pennate_models::{Mesh, Model, discretize};
use pennate_solver::batch::{self, Design};
use pennate_solver::error::SolveError;
use pennate_solver::history::{Equilibrium, History, Status, StepHistory};
use pennate_solver::options::{Options, Progress};
use pennate_solver::structure::{Dimension, Structure};

use crate::solution::{
    NodeError, ProbeSteps, ProbeTable, Solution, Timing, diagonal, largest_force, last_state, norm, stable,
};

/// Meshes that are tried at most, and as many where some are spent on grading or there is no estimate yet.
const ROUNDS: usize = 6;
const MAX_ROUNDS: usize = 8;
/// Relative error below which every refinement pays, as long as rounding is not in the way.
const ASYMPTOTIC: f64 = 1e-4;
/// A mesh is refined by no more at once: an error far above what was asked for is a poor guide.
const MAX_FACTOR: usize = 8;
/// Elements of a member at most.
const MAX_ELEMENTS: usize = 100_000;
/// Part of what the network's size or forces suggest below which values are rounding alone.
const ROUNDING: f64 = 1e-9;
/// The same for forces against the axial stiffness of the members.
const FORCE_ROUNDING: f64 = 1e-13;
/// Rotations below this part of displacement over size are what is left of a symmetry.
const TURN_ROUNDING: f64 = 1e-6;
/// Part of the network's size or forces below which an error is nothing.
const FLOOR: f64 = 1e-15;
/// By how much a limit point may move along a step's ramp from one mesh to the next.
const MESH_SCATTER: f64 = 0.05;
/// A path that a finer mesh follows no farther than this ends where it says.
const CONFIRMED: f64 = 0.01;
/// Part of itself by which a singular point is found at best.
const LOCATED: f64 = 1e-9;
/// Part of the largest error of a step below which the error of a probe is not believed.
const BY_CHANCE: f64 = 0.05;
/// Moments count as no smaller than this part of force times network size.
const MOMENT_FLOOR: f64 = 1e-3;

/// The accuracy asked for, and what came of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    pub asked: f64,
    /// Estimated error relative to the largest value of its kind; `None` where nothing could be estimated.
    pub estimated: Option<f64>,
    pub verdict: Verdict,
    /// Meshes that were solved.
    pub rounds: usize,
}

/// Whether the mesh is fine enough.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    Met,
    /// The element counts are forced by the file.
    Forced,
    /// A finer mesh would have too many elements, or too many meshes were tried.
    TooFine,
    /// The last refinement made it no better, on elements that resolve all layers: what is left is rounding.
    Stalled,
    /// The finer mesh got less far along the path.
    PathLost,
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
            Self::Interrupted => "interrupted",
            Self::NotEstimated => "no_estimate",
        }
    }
}

impl Accuracy {
    /// Whether the error is known, and no larger than asked for.
    pub fn is_met(&self) -> bool {
        self.estimated.is_some_and(|error| error <= self.asked)
    }
}

/// What came of one mesh.
struct Round {
    mesh: Mesh,
    history: History,
    probes: ProbeTable,
    /// Relative error; `None` where it is not known.
    error: Option<f64>,
    grading: Grading,
}

/// Solves a network on the mesh that its accuracy needs.
///
/// # Errors
/// Those of the solver; a step that fails is part of the solution.
pub fn solve_to_accuracy(
    model: Model,
    asked: f64,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Result<Solution, (Box<Model>, SolveError)> {
    let start = Instant::now();
    let mut mesh = Mesh::initial(&model, asked);
    let mut timing = Timing { mesh: start.elapsed(), ..Timing::default() };
    let mut best: Option<Round> = None;
    let mut trail = None;
    let way = mesh.of_the_way(&model, asked);
    let mut options = Options { rough: way.is_some(), ..options.clone() };
    mesh = way.unwrap_or(mesh);
    let mut rounds = 0;
    loop {
        rounds += 1;
        let start = Instant::now();
        let (structure, steps) = discretize(&model, &mesh);
        timing.mesh += start.elapsed();
        let start = Instant::now();
        let coarse = trail.take().zip(best.as_ref().map(|round| &round.history));
        let solved = pennate_solver::solve_along(&structure, &steps, &options, coarse, observe);
        let spent = start.elapsed();
        let mut history = match solved {
            Ok((history, left)) => {
                trail = left;
                history
            }
            Err(error) => return Err((Box::new(model), error)),
        };
        timing.estimate += history.estimate;
        timing.solve += spent.saturating_sub(history.estimate);
        mesh.name_segments(&model, &mut history);
        if let Some(Round { mesh: before, history: coarse, .. }) = &best
            && before.order == mesh.order
        {
            estimate_critical_points(coarse, &mut history, before.elements(), &mesh, mesh.lowest_order(&model));
        }
        let probes = ProbeTable::new(&model, &history);
        let known = options.rough || every_end_is_estimated(&history);
        let error = relative_error(&model, &structure, &history, &probes);
        let error = largest_of(error, critical_error(&history)).filter(|_| known);
        options.rough = false;
        let states: Vec<_> = history.steps.iter().map(|step| step.variations.as_slice()).collect();
        let grading = mesh.graded(&model, &states, asked);
        let mut round = Round { mesh, history, probes, error, grading };
        let mut verdict = match judge(&model, &round, asked, rounds, best.as_ref()) {
            Judgement::Refine(finer) => {
                best = Some(round);
                mesh = finer;
                continue;
            }
            Judgement::End(verdict) => verdict,
        };
        if matches!(verdict, Verdict::PathLost | Verdict::Interrupted) {
            round = best.unwrap_or(round);
        }
        if round.grading.unresolved || round.error.is_none() {
            round.error = None;
            let start = Instant::now();
            if verdict != Verdict::Interrupted && compare_with_free(&model, &mut round, asked, &options, observe) {
                round.probes = ProbeTable::new(&model, &round.history);
                round.error = relative_error(&model, &structure, &round.history, &round.probes);
            }
            timing.estimate += start.elapsed();
            verdict = match round.error {
                Some(error) if error <= asked => Verdict::Met,
                Some(_) => verdict,
                None if verdict == Verdict::Interrupted => verdict,
                None => Verdict::NotEstimated,
            };
        }
        let Round { mesh, history, mut probes, error: estimated, .. } = round;
        state_least_errors(&model, &structure, &history, &mut probes);
        let accuracy = Accuracy { asked, estimated, verdict, rounds };
        return Ok(Solution { model, mesh, history, probes, accuracy, timing });
    }
}

/// Whether the end of every step that has come to it was found on a finer mesh too.
fn every_end_is_estimated(history: &History) -> bool {
    history.steps.iter().all(|step| step.status != Status::Converged || step.refined.is_some())
}

/// Takes the ends of the steps on the mesh that the accuracy needs as what those on elements forced by the file are
/// compared with; false where there is no such mesh.
///
/// Elements of the next order tell nothing where they are as much too long as those that they are compared with.
fn compare_with_free(
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
        let alike = |(own, free): (&StepHistory, &StepHistory)| own.status == free.status;
        if solution.accuracy.estimated.is_some() && round.history.steps.iter().zip(&solution.history.steps).all(alike) {
            for (own, free) in round.history.steps.iter_mut().zip(&solution.history.steps) {
                own.refined = last_state(free).cloned();
            }
            return true;
        }
    }
    false
}

/// Solves networks of one topology side by side on the meshes that their accuracy should need, without what they share
/// more than once; nothing for those that need more than that, which [`solve_to_accuracy`] has to solve.
///
/// Numbers of iterations and the like are those of all that were solved together.
pub fn solve_together(
    models: &[&Model],
    asked: f64,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Vec<Option<Shared>> {
    let meshes: Vec<Mesh> = models.iter().map(|model| Mesh::initial(model, asked)).collect();
    let large = models.iter().zip(&meshes).any(|(model, mesh)| mesh.of_the_way(model, asked).is_some());
    if large {
        return models.iter().map(|_| None).collect();
    }
    let designs: Vec<Design> = models
        .iter()
        .zip(&meshes)
        .map(|(model, mesh)| {
            let (structure, steps) = discretize(model, mesh);
            Design { structure, steps }
        })
        .collect();
    let histories = batch::histories(&designs, options, observe);
    let judged = models.iter().zip(&meshes).zip(&designs).zip(histories).map(|(((model, mesh), design), history)| {
        let history = history?;
        let probes = ProbeTable::new(model, &history);
        let error = relative_error(model, &design.structure, &history, &probes)?;
        let states: Vec<_> = history.steps.iter().map(|step| step.variations.as_slice()).collect();
        let resolved = every_end_is_estimated(&history) && !mesh.graded(model, &states, asked).unresolved;
        let stable = stable(&history);
        (error <= asked && resolved).then_some(Shared { probes, error, stable })
    });
    judged.collect()
}

/// What came of a network that was solved together with others: all its steps converged.
#[derive(Clone, Debug)]
pub struct Shared {
    pub probes: ProbeTable,
    /// Estimated error relative to the largest value of its kind.
    pub error: f64,
    /// See [`stable`].
    pub stable: Option<bool>,
}

enum Judgement {
    Refine(Mesh),
    End(Verdict),
}

fn judge(model: &Model, round: &Round, asked: f64, rounds: usize, best: Option<&Round>) -> Judgement {
    let Round { mesh, history, error, grading, .. } = round;
    let error = *error;
    let interrupted = history.steps.iter().any(|step| step.status == Status::Interrupted);
    if let Some(before) = best {
        if interrupted {
            return Judgement::End(Verdict::Interrupted);
        }
        // A finer mesh that finds a singular point on the way is right; one that finds nothing at all is lost.
        let lost = history.steps.iter().any(|step| step.status == Status::NotConverged);
        if lost && progress_of(history) < progress_of(&before.history) - MESH_SCATTER {
            // Where what the coarser mesh says is not to be trusted, a still finer one may follow the path.
            let trusted = before.error.is_some() && !before.grading.unresolved;
            let finer = grading.finer.clone().unwrap_or_else(|| halved(model, mesh));
            let open = !trusted && rounds < MAX_ROUNDS && finer != *mesh;
            return if open { Judgement::Refine(finer) } else { Judgement::End(Verdict::PathLost) };
        }
    }
    // What found the way of a large network is not near its end.
    if let (Some((order, left)), false) = (mesh.raised(asked, error), interrupted) {
        if let Some(finer) = &grading.finer {
            return Judgement::Refine(Mesh { order, ..finer.clone() });
        }
        let missing = missing(history);
        // A few members lack most of the energy: shorter elements there cost little.
        let factors = match missing.is_empty() {
            true => vec![1; mesh.refinement.len()],
            false => member_factors(mesh, order, &missing, (left / asked).max(1.0)),
        };
        return Judgement::Refine(Mesh { order, ..mesh.refined(model, &factors) });
    }
    // What elements that are longer than a layer say of a path or of an error is nothing.
    if let (Some(finer), true) = (&grading.finer, !interrupted && rounds < MAX_ROUNDS) {
        return Judgement::Refine(finer.clone());
    }
    // A path that ends early may do so for want of elements: a second mesh confirms it.
    let complete = history.steps.iter().all(|step| step.status == Status::Converged);
    let gained = best.is_none_or(|before| progress_of(history) > progress_of(&before.history) + CONFIRMED);
    if !complete && gained && rounds < ROUNDS {
        let factors: Vec<usize> = mesh.refinement.iter().map(|segments| capped(2 * rounds, segments)).collect();
        let finer = mesh.refined(model, &factors);
        if finer != *mesh {
            return Judgement::Refine(finer);
        }
    }
    // A singular point is known as well as the last mesh moved it, where the mesh before it found it too.
    if has_unknown_points(history) && rounds < 4 {
        let finer = halved(model, mesh);
        if finer != *mesh {
            return Judgement::Refine(finer);
        }
    }
    let Some(error) = error else {
        // Where the next order leads nowhere, shorter elements are another way.
        let shorter = halved(model, mesh);
        let open = !interrupted && !every_end_is_estimated(history) && rounds < MAX_ROUNDS && shorter != *mesh;
        return if open { Judgement::Refine(shorter) } else { Judgement::End(Verdict::NotEstimated) };
    };
    if error <= asked {
        return Judgement::End(Verdict::Met);
    }
    // An error that does not count what is not known of singular points is no measure of progress.
    let before = best.filter(|before| !has_unknown_points(&before.history)).and_then(|before| before.error);
    let stalled = error < ASYMPTOTIC && before.is_some_and(|before| error > 0.5 * before);
    // Errors of elements that are longer than a layer fall as they like.
    let fine = grading.longest <= 1.0;
    if stalled && fine && best.is_some_and(|before| is_finer_everywhere(model, mesh, &before.mesh)) {
        return Judgement::End(Verdict::Stalled);
    }
    let factors = match stalled {
        // Finer members here and there were of no use.
        true => vec![2; mesh.refinement.len()],
        false => member_factors(mesh, mesh.lowest_order(model), &missing(history), error / asked),
    };
    let finer = mesh.refined(model, &factors);
    if finer == *mesh {
        let at_limit = mesh.refinement.iter().any(|segments| capped(2, segments) == 1);
        return Judgement::End(if at_limit { Verdict::TooFine } else { Verdict::Forced });
    }
    let most = if mesh.grading.is_empty() { ROUNDS } else { MAX_ROUNDS };
    if rounds >= most { Judgement::End(Verdict::TooFine) } else { Judgement::Refine(finer) }
}

/// Whether a singular point was found that no coarser mesh tells the error of.
fn has_unknown_points(history: &History) -> bool {
    history.steps.iter().flat_map(|step| &step.critical_points).any(|point| point.error.is_none())
}

/// The mesh with elements half as long.
fn halved(model: &Model, mesh: &Mesh) -> Mesh {
    mesh.refined(model, &vec![2; mesh.refinement.len()])
}

/// Whether every stretch that may have more elements on a mesh than on the one before has twice as many.
fn is_finer_everywhere(model: &Model, mesh: &Mesh, before: &Mesh) -> bool {
    let twice = |(member, (now, then)): (usize, (&Vec<usize>, &Vec<usize>))| {
        let counts = now.iter().zip(then).enumerate();
        counts.into_iter().all(|(index, (&now, &then))| !mesh.is_free_at(model, member, index) || now >= 2 * then)
    };
    let members = mesh.refinement.iter().zip(&before.refinement).enumerate();
    mesh.grading == before.grading && members.into_iter().all(twice)
}

/// Estimates the errors of singular points from how far they lie from those of a coarser mesh.
fn estimate_critical_points(coarse: &History, fine: &mut History, elements: usize, mesh: &Mesh, order: usize) {
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

/// The largest error of a singular point over the largest fraction of a ramp where there is one.
fn critical_error(history: &History) -> Option<f64> {
    let points = || history.steps.iter().flat_map(|step| &step.critical_points);
    let largest = points().map(|point| point.fraction.abs()).fold(0.0, f64::max);
    points().filter_map(|point| point.error).reduce(f64::max).map(|error| error / largest.max(f64::MIN_POSITIVE))
}

fn largest_of(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    a.into_iter().chain(b).reduce(f64::max)
}

/// How far along its steps a run came: those done, and the fraction of the next.
fn progress_of(history: &History) -> f64 {
    let converged = history.steps.iter().take_while(|step| step.status == Status::Converged).count();
    converged as f64 + history.steps.get(converged).map_or(0.0, |step| step.fraction)
}

/// By how much shorter elements of one order must be for an error that is too large by `excess`.
pub fn refinement_factor(excess: f64, order: usize) -> usize {
    let factor = (2.0 * excess).powf(0.5 / order as f64).ceil();
    (factor as usize).clamp(2, MAX_FACTOR)
}

/// Energy that every member lacks in the worst step; empty where none was estimated.
fn missing(history: &History) -> Vec<f64> {
    history.steps.iter().map(|step| &step.missing).fold(Vec::new(), |worst, here| match worst.is_empty() {
        true => here.clone(),
        false if here.is_empty() => worst,
        false => worst.iter().zip(here).map(|(a, b)| a.max(*b)).collect(),
    })
}

/// Factors for the elements of all members that reduce an error which is too large by `excess`.
///
/// The error is taken to go with the energy that the elements lack: member i, refined by f, keeps f^-2p of its part.
/// The fewest elements that do have f proportional to (energy / elements)^(1/(2p + 1)).
pub fn member_factors(mesh: &Mesh, order: usize, missing: &[f64], excess: f64) -> Vec<usize> {
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
pub fn capped(factor: usize, segments: &[usize]) -> usize {
    factor.min(MAX_ELEMENTS / segments.iter().sum::<usize>().max(1)).max(1)
}

/// The largest error of a run over the largest value of its kind; `None` where no step was estimated.
pub fn relative_error(model: &Model, structure: &Structure, history: &History, probes: &ProbeTable) -> Option<f64> {
    history.steps.iter().find(|step| step.refined.is_some())?;
    let kinds = match (0..model.probes.len()).all(|probe| !model.probes.kind(probe).is_asked()) {
        true => kinds_of_nodes(model.dimension, &history.steps),
        false => kinds_of_probes(model, &probes.steps),
    };
    let noise = Noise::of(structure, history);
    let ratios = kinds.ratios(&noise);
    Some(ratios.into_iter().flatten().fold(0.0, f64::max))
}

/// Sets the least error that is stated of every probe, a part of the largest one of the same step: what two meshes
/// differ by may vanish by chance.
fn state_least_errors(model: &Model, structure: &Structure, history: &History, probes: &mut ProbeTable) {
    if model.probes.is_empty() || history.steps.iter().all(|step| step.refined.is_none()) {
        return;
    }
    let noise = Noise::of(structure, history);
    let kinds = |steps: &[StepHistory], probes: &[ProbeSteps]| {
        kinds_of_nodes(model.dimension, steps).joined(kinds_of_probes(model, probes))
    };
    let run = kinds(&history.steps, &probes.steps);
    for (step, probes) in history.steps.iter().zip(&mut probes.steps) {
        let own = kinds(std::slice::from_ref(step), std::slice::from_ref(probes));
        let largest = run.with_errors_of(own).ratios(&noise).into_iter().flatten().fold(0.0, f64::max);
        let least = |(index, value): (usize, &f64)| {
            let size = probes.increments.iter().map(|values| values[index].abs()).fold(0.0, f64::max);
            let scale = match model.probes.kind(index) {
                ProbeKind::Displacement => run.displacement.value,
                ProbeKind::Rotation => run.rotation.value.to_degrees(),
                ProbeKind::Force => run.force.value,
                ProbeKind::Moment => run.moment.value,
                ProbeKind::GreatestMoment | ProbeKind::Stress | ProbeKind::Strain | ProbeKind::Other => value.abs(),
            };
            // What is zero by symmetry or by statics is so on every mesh.
            if size > ROUNDING * scale { BY_CHANCE * largest * scale } else { 0.0 }
        };
        probes.least = probes.last().unwrap_or_default().iter().enumerate().map(least).collect();
    }
}

/// Largest value and largest error of one kind of quantity.
#[derive(Clone, Copy, Debug, Default)]
struct Kind {
    value: f64,
    error: f64,
}

impl Kind {
    fn take(&mut self, value: f64, error: Option<f64>) {
        // A value that is not a number, such as a probe of a later step, is no evidence.
        self.value = self.value.max(value.abs());
        self.error = self.error.max(error.unwrap_or(0.0));
    }

    /// Error over value; `None` for a kind that is rounding alone.
    fn ratio(self, rounding: f64, floor: f64) -> Option<f64> {
        (self.value > rounding).then(|| if self.error <= floor { 0.0 } else { self.error / self.value })
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Kinds {
    displacement: Kind,
    rotation: Kind,
    force: Kind,
    moment: Kind,
}

impl Kinds {
    fn pairs(self, other: Self, join: fn(Kind, Kind) -> Kind) -> Self {
        Self {
            displacement: join(self.displacement, other.displacement),
            rotation: join(self.rotation, other.rotation),
            force: join(self.force, other.force),
            moment: join(self.moment, other.moment),
        }
    }

    fn joined(self, other: Self) -> Self {
        self.pairs(other, |a, b| Kind { value: a.value.max(b.value), error: a.error.max(b.error) })
    }

    fn with_errors_of(self, other: Self) -> Self {
        self.pairs(other, |a, b| Kind { error: b.error, ..a })
    }

    fn ratios(mut self, noise: &Noise) -> [Option<f64>; 4] {
        let force = if self.force.value > 0.0 { self.force.value } else { noise.largest_force };
        let moment_rounding = noise.force * noise.size;
        if self.moment.value > moment_rounding {
            self.moment.value = self.moment.value.max(MOMENT_FLOOR * force * noise.size);
        }
        let floor = FLOOR * noise.largest_force;
        [
            self.displacement.ratio(ROUNDING * noise.size, FLOOR * noise.size),
            self.rotation.ratio(ROUNDING.max(TURN_ROUNDING * self.displacement.value / noise.size), FLOOR),
            self.force.ratio(noise.force, floor),
            self.moment.ratio(moment_rounding, floor * noise.size),
        ]
    }
}

fn kinds_of_probes(model: &Model, steps: &[ProbeSteps]) -> Kinds {
    let mut kinds = Kinds::default();
    for step in steps {
        let errors = step.errors();
        for index in 0..model.probes.len() {
            let largest = step.increments.iter().map(|values| values[index].abs()).fold(0.0, f64::max);
            let error = errors.as_ref().map(|errors| errors[index]);
            match model.probes.kind(index) {
                ProbeKind::Displacement => kinds.displacement.take(largest, error),
                ProbeKind::Rotation => kinds.rotation.take(largest.to_radians(), error.map(f64::to_radians)),
                ProbeKind::Force => kinds.force.take(largest, error),
                ProbeKind::Moment => kinds.moment.take(largest, error),
                // No claim is made on what is greatest somewhere, nor on what is made of other probes.
                ProbeKind::GreatestMoment | ProbeKind::Stress | ProbeKind::Strain | ProbeKind::Other => {}
            }
        }
    }
    kinds
}

fn kinds_of_nodes(dimension: Dimension, steps: &[StepHistory]) -> Kinds {
    let mut kinds = Kinds::default();
    for step in steps {
        for state in step.increments.iter().map(|increment| &increment.state) {
            take_nodes(&mut kinds, state);
        }
        let (Some(last), Some(refined)) = (last_state(step), &step.refined) else { continue };
        for (node, better) in last.nodes.iter().zip(&refined.nodes) {
            let error = NodeError::between(node, better, dimension);
            kinds.displacement.take(0.0, Some(error.displacement));
            kinds.rotation.take(0.0, Some(error.rotation));
            kinds.force.take(0.0, Some(error.reaction_force));
            kinds.moment.take(0.0, Some(error.reaction_moment));
        }
    }
    kinds
}

fn take_nodes(kinds: &mut Kinds, state: &Equilibrium) {
    for node in &state.nodes {
        kinds.displacement.take(norm(node.displacement), None);
        kinds.rotation.take(norm(node.rotation).max(node.rotation_total.abs()), None);
        kinds.force.take(norm(node.reaction_force), None);
        kinds.moment.take(norm(node.reaction_moment), None);
    }
}

/// What the network's size and forces suggest about rounding.
struct Noise {
    /// Diagonal of the box around the unloaded network.
    size: f64,
    /// The largest force anywhere in the run.
    largest_force: f64,
    /// Forces below this are rounding.
    force: f64,
}

impl Noise {
    fn of(structure: &Structure, history: &History) -> Self {
        let size = diagonal(structure.nodes.iter().copied());
        let largest_force = history.steps.iter().filter_map(last_state).map(largest_force).fold(0.0, f64::max);
        let axial = structure.laws.iter().map(|law| law.at(0.0).section.ea).filter(|ea| ea.is_finite());
        let force = (ROUNDING * largest_force).max(FORCE_ROUNDING * axial.fold(0.0, f64::max));
        Self { size, largest_force, force }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;

    fn noise() -> Noise {
        Noise { size: 100.0, largest_force: 10.0, force: 1e-8 }
    }

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

    #[test]
    fn kinds_of_rounding_alone_are_left_out() {
        let mut kinds = Kinds::default();
        kinds.displacement.take(1e-9, Some(1e-9));
        kinds.rotation.take(0.5, Some(1e-6));
        kinds.force.take(1e-9, Some(1e-9));
        assert_eq!(kinds.ratios(&noise()), [None, Some(2e-6), None, None]);
    }

    /// A moment of 1e-4 beside forces of 10 in a network of 100 counts as 1.
    #[test]
    fn small_moments_are_measured_by_force_times_size() {
        let mut kinds = Kinds::default();
        kinds.force.take(10.0, Some(0.0));
        kinds.moment.take(1e-4, Some(1e-5));
        assert_eq!(kinds.ratios(&noise())[3], Some(1e-5));
    }

    #[test]
    fn without_probes_every_node_is_judged() {
        let solution = fixture::solution();
        let kinds = kinds_of_nodes(solution.model.dimension, &solution.history.steps);
        let [displacement, rotation, ..] = kinds.ratios(&noise());
        assert!((displacement.unwrap() - 2e-9 / 1.5).abs() < 1e-15);
        assert!((rotation.unwrap() - 7e-9 / 5.25).abs() < 1e-15);
    }
}
