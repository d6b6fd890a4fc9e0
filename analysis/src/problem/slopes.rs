//! One design step by step, with the derivatives at the ends of its steps.

use std::collections::BTreeMap;

use pennate_models::probes::ProbeKind;
use pennate_models::{Model, discretize};
use pennate_solver::continuation::Continuation;
use pennate_solver::history::{Equilibrium, History, NodeState, Status, StepHistory};
use pennate_solver::joints::Held;
use pennate_solver::structure::{Change, Step};

use super::adjoint::Exact;
use super::design::{Design, take_pieces};
use super::explicit::Kept;
use super::gradient::Row;
use super::nearby::{Nearby, size};
use super::neighbour::{self, NOTHING};
use super::{Control, Problem, Reason, mesh};
use crate::solution;
use crate::together::{self, Found, Packs, Standing};

/// Parts of a parameter by which neighbours are apart: the first that two distances agree at is taken.
///
/// With differences at h and 2 h extrapolated to h = 0 what is left goes with h⁴, and with those at 4 h, where there are any, with h⁶:
/// 10⁻¹⁰ of the fifth derivative at the first of them, where rounding of the states, 10⁻¹³ or so, leaves 3 · 10⁻¹¹. At a third of it, rounding of forces along members whose
/// stretch counts was 5 · 10⁻⁷ of the largest derivative.
const APART: [f64; 5] = [3e-3, 1e-3, 3e-4, 1e-4, 3e-5];
/// Part by which the differences at both distances may differ: its square is left after extrapolation.
const AGREED: f64 = 1e-4;
/// The same as a part of what is greatest of its kind, over the whole of a parameter, where a shorter distance may tell more and where
/// none does: a derivative that vanishes, as that of a reaction that statics fixes, has no part of its own.
const VANISHES: [f64; 2] = [1e-7, 1e-6];
/// By how much the tangent may change over this part of a parameter: it vanishes about so far away where it changes by all.
/// The path bends by as much: half of what both neighbours moved by together, over half of what they moved apart.
const CHANGED: f64 = 0.3;
const NEAR: f64 = 1e-4;
/// Part of the largest value of a probe that rounding may move it by.
const ROUNDING: f64 = 1e-12;
/// What differences at both distances, extrapolated to none, leave over the square of what they differ by: the fourth power of the
/// distance over that to where the state ceases to be, which goes with the square.
const LEFT: f64 = 4.0 / 9.0;
/// How many times that three distances may tell apart: sixteen times as much is left at twice the distance.
const EXPLAINED: f64 = 32.0;
/// How many times what three distances tell apart rounding may leave: it may make them agree by chance.
const BY_CHANCE: f64 = 3.0;
/// An estimated error, over a derivative, below which no shorter distance is looked at: a tenth of what is promised.
const ENOUGH: f64 = 0.1 * WITHIN;
/// Part of its value that rounding moves a probe by at least.
const LEAST: f64 = 2e-14;
/// By how much a derivative may be wrong, over the largest of its probe, without a word.
pub(super) const WITHIN: f64 = 1e-7;
/// By how much it may be wrong and still be a number: four digits lead an optimization on.
const OF_USE: f64 = 1e-4;

/// A component of a node, in the axes of its support.
pub(super) type Component = (usize, usize);

/// What holds a component at the end of a step, where it is not a support at rest.
#[derive(Clone, Debug)]
pub(super) enum Hold {
    /// Moved to the value of this change of this step.
    To(usize, usize),
    /// Held where it was, or moved by the value of this change of this step from there; with the derivatives of where it was.
    From(Option<(usize, usize)>, Vec<f64>),
}

/// The derivatives of one design.
pub(super) struct Slopes<'a> {
    pub(super) problem: &'a Problem,
    pub(super) row: &'a [f64],
    pub(super) design: &'a Design,
    control: &'a Control,
    pub(super) holds: BTreeMap<Component, Hold>,
    /// Values of all probes after the steps so far, and their derivatives by the parameters (probe after probe).
    pub(super) after: Vec<Vec<f64>>,
    pub(super) slopes: Vec<Vec<f64>>,
    /// The verdicts at the ends of the steps so far.
    stable: Vec<Option<bool>>,
    /// What is known less well than is promised.
    inexact: Option<Reason>,
    /// Once they were asked for: nothing where there are none.
    pub(super) nearby: Option<Option<Vec<Nearby>>>,
}

/// A derivative, and by how much it may be wrong.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    pub slope: f64,
    pub error: f64,
}

impl Estimate {
    /// What is not known.
    pub(super) const NONE: Self = Self { slope: f64::NAN, error: f64::INFINITY };
}

/// A neighbour: probes, then components that the next step holds where they are, and how far its joints moved.
struct Neighbour {
    values: Vec<f64>,
    moved: Vec<f64>,
    /// Whether its held strains are what they are in equilibrium: what is left of them does not fall as the square of the distance.
    settled: bool,
}

/// How much the path bends between two neighbours on both sides of the design.
fn bend(ahead: &[f64], behind: &[f64]) -> f64 {
    let largest = |part: fn(f64, f64) -> f64| {
        ahead.iter().zip(behind).map(|(&ahead, &behind)| part(ahead, behind).abs()).fold(0.0, f64::max)
    };
    let (together, apart) = (largest(|ahead, behind| ahead + behind), largest(|ahead, behind| ahead - behind));
    if apart > NOTHING { together / apart } else { 0.0 }
}

/// What is greatest of its kind in a state.
#[derive(Default)]
pub(super) struct Greatest {
    displacement: f64,
    /// Radians.
    rotation: f64,
    force: f64,
    moment: f64,
}

impl Greatest {
    pub(super) fn of(state: &Equilibrium) -> Self {
        let among = |vector: fn(&NodeState) -> [f64; 3]| {
            state.nodes.iter().map(|node| solution::norm(vector(node))).fold(0.0, f64::max)
        };
        Self {
            displacement: among(|node| node.displacement),
            rotation: among(|node| node.rotation),
            force: solution::largest_force(state),
            moment: solution::largest_moment(state),
        }
    }

    /// Of the kind of a probe, or of a component of a node; at least the value itself.
    pub(super) fn like(&self, kind: Option<ProbeKind>, value: f64) -> f64 {
        let greatest = match kind {
            None => self.displacement.max(self.rotation),
            Some(ProbeKind::Displacement) => self.displacement,
            Some(ProbeKind::Rotation) => self.rotation.to_degrees(),
            Some(ProbeKind::Force) => self.force,
            Some(ProbeKind::Moment | ProbeKind::GreatestMoment) => self.moment,
            Some(ProbeKind::Stress | ProbeKind::Strain | ProbeKind::Other) => 0.0,
        };
        greatest.max(value.abs())
    }
}

/// A derivative by differences at a distance and at twice as much, and where it is known at four times as much; with `rounding` times the
/// part of a value that rounding moves it by.
///
/// Two distances leave the fourth power of them, three the sixth. What the three tell apart is by the fourth power, which is known from the
/// two, or else it is rounding.
fn extrapolated([one, two]: [f64; 2], four: Option<f64>, rounding: f64) -> Estimate {
    let (near, apart) = (one + (one - two) / 3.0, (one - two).abs());
    let left = if apart > 0.0 { LEFT * apart * (apart / one.abs().max(two.abs())) } else { 0.0 };
    let Some(four) = four else { return Estimate { slope: near, error: left + ROUNDING * rounding } };
    let gap = near - (two + (two - four) / 3.0);
    let error = if gap.abs() <= EXPLAINED * left { left } else { BY_CHANCE * gap.abs() };
    Estimate { slope: near + gap / 15.0, error: error + LEAST * rounding }
}

impl<'a> Slopes<'a> {
    pub(super) fn new(problem: &'a Problem, row: &'a [f64], design: &'a Design, control: &'a Control) -> Self {
        let (after, slopes, stable) = (Vec::new(), Vec::new(), Vec::new());
        Self {
            problem,
            row,
            design,
            control,
            holds: BTreeMap::new(),
            after,
            slopes,
            stable,
            inexact: None,
            nearby: None,
        }
    }

    /// Follows the steps from the end of the first one, whose history is given.
    pub(super) fn run<const D: usize>(
        mut self,
        mut path: Continuation<'static, D>,
        packs: Packs<D>,
        first: History,
    ) -> Row {
        let count = self.design.steps.len().max(1);
        let mut history = first;
        let (mut reason, mut copies) = (None, None);
        for index in 0..count {
            if index > 0 {
                let control = self.control;
                history = path.run(&self.design.steps[index..=index], &mut |_| !control.is_stopped());
            }
            let ends = history.steps.iter().filter(|step| !step.increments.is_empty());
            self.stable.extend(ends.map(|step| step.stable));
            if let Err(stopped) = self.step(&mut path, packs, (index, &history), &mut copies) {
                reason = reason.or(Some(stopped));
                if self.after.len() <= index {
                    break;
                }
            }
        }
        self.finish(reason)
    }

    /// The derivatives at the ends of steps that were found side by side with other designs; nothing where the adjoint method
    /// does not give all of them.
    pub(super) fn run_together(mut self, found: &Found) -> Option<Row> {
        let (mut plane, mut space) = (None, None);
        for (index, end) in found.ends.iter().enumerate() {
            let values = match end {
                Some(end) => self.design.model.probes.evaluate(&end.state, &self.after),
                None => vec![f64::NAN; self.design.model.probes.len()],
            };
            self.note_holds(index);
            self.after.push(values);
            self.slopes.push(Vec::new());
            self.stable.push(Some(true));
            let kept = self.kept_by_next(index);
            if !self.problem.reads(index) && kept.is_empty() {
                continue;
            }
            let at = (index, &end.as_ref()?.state);
            let slopes = match found.system(self.design.posed(), index)? {
                Standing::Plane(mut system) => self.adjoint(&mut system, at, (&kept, true), &mut plane),
                Standing::Space(mut system) => self.adjoint(&mut system, at, (&kept, true), &mut space),
            };
            let found = slopes?.ok()?;
            self.keep(index, &kept, found.serves().then(|| found.slopes())?);
        }
        Some(self.finish(None))
    }

    /// Takes note of derivatives at the end of a step, of all probes and of components that the next one keeps.
    fn keep(&mut self, index: usize, kept: &[Component], mut slopes: Vec<f64>) {
        let (probes, inputs) = (self.after[index].len(), self.row.len());
        for (&component, rates) in kept.iter().zip(slopes[probes * inputs..].chunks_exact(inputs.max(1))) {
            self.holds.insert(component, Hold::From(None, rates.to_vec()));
        }
        slopes.truncate(probes * inputs);
        self.slopes[index] = slopes;
    }

    /// The outputs of the steps that were reached.
    fn finish(self, reason: Option<Reason>) -> Row {
        let inputs = self.row.len();
        let (mut values, mut jacobian) = (Vec::new(), Vec::new());
        for output in &self.problem.outputs {
            let value = self.after.get(output.step).map_or(f64::NAN, |values| values[output.probe]);
            values.push(value);
            let slope = |input: usize| {
                let step = self.slopes.get(output.step).filter(|slopes| !slopes.is_empty());
                step.map_or(f64::NAN, |slopes| slopes[output.probe * inputs + input])
            };
            jacobian.extend((0..inputs).map(slope));
        }
        Row { values, jacobian, reason: reason.or(self.inexact), stable: solution::all_stable(&self.stable) }
    }

    /// Reads one step and, where anything is asked of it, its derivatives.
    fn step<const D: usize>(
        &mut self,
        path: &mut Continuation<'static, D>,
        packs: Packs<D>,
        (index, history): (usize, &History),
        copies: &mut Option<Kept<D>>,
    ) -> Result<(), Reason> {
        let Some(record) = history.steps.first() else { return Err(Reason::Interrupted) };
        if record.status != Status::Converged {
            let cause = record.failure.as_ref().map(|failure| failure.cause);
            return Err(match record.status {
                Status::Interrupted => Reason::Interrupted,
                status => Reason::Stopped { step: index, status, fraction: record.fraction, cause },
            });
        }
        let Some(last) = record.increments.last() else { return Err(Reason::Interrupted) };
        let values = self.probes(&self.design.model, record, last.state.clone(), &self.after);
        self.note_holds(index);
        self.after.push(values);
        self.slopes.push(Vec::new());
        let kept = self.kept_by_next(index);
        if !self.problem.reads(index) && kept.is_empty() {
            return Ok(());
        }
        // What stops at a value of its own moves with all parameters along the path.
        if record.fraction != 1.0 {
            let output = self.problem.outputs.iter().position(|output| output.step >= index).unwrap_or_default();
            return Err(Reason::NoDerivative { output });
        }
        neighbour::settle(&mut path.system);
        let (probes, inputs) = (self.after[index].len(), self.row.len());
        let found = self.adjoint(&mut path.system, (index, &last.state), (&kept, false), copies);
        let (slopes, reason) = match found {
            Some(Err(reason)) => (vec![f64::NAN; (probes + kept.len()) * inputs], Some(reason)),
            Some(Ok(exact)) if exact.serves() => (exact.slopes(), None),
            found => {
                path.system.assemble(false);
                let exact = found.and_then(Result::ok);
                let (mut found, reason) = self.by_neighbours(path, packs, (index, record), &kept, exact.as_ref());
                if let Some(Exact { found: exact, regular, .. }) = exact {
                    // Where neighbours show no singular point, they leave no doubt about what no distance goes into.
                    let both = found.iter_mut().zip(exact);
                    let better =
                        both.filter(|(near, exact)| exact.error <= near.error && (regular || near.slope.is_finite()));
                    better.for_each(|(near, exact)| *near = exact);
                }
                let useless = self.note_inexact((index, &last.state), &mut found);
                (found.into_iter().map(|estimate| estimate.slope).collect(), reason.or(useless))
            }
        };
        self.keep(index, &kept, slopes);
        reason.map_or(Ok(()), Err)
    }

    /// Stops where nobody waits any longer.
    pub(super) fn wanted(&self) -> Result<(), Reason> {
        if self.control.is_stopped() { Err(Reason::Interrupted) } else { Ok(()) }
    }

    /// What derivatives of a quantity are measured by, each times its parameter: the largest of them, or a part of what is greatest of
    /// its kind where statics or symmetry fixes it.
    pub(super) fn measure(&self, index: usize, greatest: &Greatest, quantity: usize, found: &[Estimate]) -> f64 {
        let sizes = found.iter().zip(self.row).map(|(found, &value)| found.slope.abs() * size(value));
        sizes.filter(|size| size.is_finite()).fold(self.floor(index, greatest, quantity), f64::max)
    }

    /// Notes what may be wrong by more than is promised. Puts no number where one would be of no use, with the reason.
    fn note_inexact(&mut self, (index, state): (usize, &Equilibrium), found: &mut [Estimate]) -> Option<Reason> {
        let (needed, greatest, mut reason) = (self.needed(index), Greatest::of(state), None);
        for (quantity, found) in found.chunks_exact_mut(self.row.len().max(1)).enumerate() {
            if quantity < self.after[index].len() && !needed.contains(&quantity) {
                continue;
            }
            let measure = self.measure(index, &greatest, quantity, found);
            for (estimate, &value) in found.iter_mut().zip(self.row) {
                let error = estimate.error * size(value) / measure;
                if !(estimate.slope.is_finite() && measure > 0.0 && error > WITHIN) {
                    continue;
                }
                let why = self.inexact(index, quantity, error);
                let worst = if let Some(Reason::Inexact { error, .. }) = self.inexact { error } else { WITHIN };
                if error > OF_USE {
                    *estimate = Estimate::NONE;
                    reason = reason.or(Some(why));
                } else if error > worst {
                    self.inexact = Some(why);
                }
            }
        }
        reason
    }

    /// What is said of a derivative of a quantity that may be wrong by this part of the largest of its probe.
    fn inexact(&self, index: usize, quantity: usize, error: f64) -> Reason {
        let outputs = &self.problem.outputs;
        let own = outputs.iter().position(|output| output.probe == quantity && output.step == index);
        let output = own.or_else(|| outputs.iter().position(|output| output.step >= index)).unwrap_or_default();
        Reason::Inexact { output, error }
    }

    /// Derivatives of all probes at the end of a step, and of components that the next one keeps, by equilibria nearby; with
    /// the reason where there are none, or not all.
    fn by_neighbours<const D: usize>(
        &self,
        path: &mut Continuation<'static, D>,
        packs: Packs<D>,
        at: (usize, &StepHistory),
        kept: &[Component],
        exact: Option<&Exact>,
    ) -> (Vec<Estimate>, Option<Reason>) {
        let inputs = self.row.len();
        let count = self.after[at.0].len() + kept.len();
        let mut found = vec![Estimate::NONE; count * inputs];
        let mut reason = None;
        let probes = &self.design.model.probes;
        let regular = exact.is_some_and(|exact| exact.regular);
        let refers = |quantity: usize| quantity < probes.len() && probes.operands(quantity).is_some();
        for input in 0..inputs {
            let stated = |quantity: usize| exact.is_some_and(|exact| exact.states(quantity, input));
            let settled = |quantity: usize| exact.is_some_and(|exact| exact.is_near(quantity, input));
            // What is known without neighbours need not be known by them, unless they are to tell whether a singular point is near:
            // expressions follow what they refer to.
            let known = |quantity: usize| settled(quantity) && (regular || refers(quantity));
            let counts = |quantity: usize| !known(quantity) && (stated(quantity) || self.counts(at.0, quantity));
            if !(0..count).any(counts) {
                continue;
            }
            // What is stated already, though not as near as it should be, needs no other reason.
            let matters = |quantity: usize| counts(quantity) && !(regular && stated(quantity));
            match self.slope(path, packs, at, (input, [&known, &counts, &matters]), kept) {
                Ok((column, doubtful)) => {
                    for (quantity, estimate) in column.into_iter().enumerate() {
                        found[quantity * inputs + input] = estimate;
                    }
                    reason = reason.or(doubtful);
                }
                Err(Reason::Interrupted) => return (found, Some(Reason::Interrupted)),
                Err(why) if (0..count).any(matters) => reason = reason.or(Some(why)),
                Err(_) => {}
            }
        }
        (found, reason)
    }

    /// Values of all probes in a state.
    fn probes(&self, model: &Model, record: &StepHistory, state: Equilibrium, after: &[Vec<f64>]) -> Vec<f64> {
        if self.problem.mesh.grading.is_empty() || state.sections.is_empty() {
            return model.probes.evaluate(&state, after);
        }
        let mut history = neighbour::history_of(record, state);
        self.problem.mesh.name_segments(model, &mut history);
        model.probes.evaluate(&history.steps[0].increments[0].state, after)
    }

    /// Components that the next step holds where they are.
    fn kept_by_next(&self, index: usize) -> Vec<Component> {
        self.design.kept_after(index)
    }

    /// Takes note of what a step changes about what is held; where components were is known from the step before.
    fn note_holds(&mut self, index: usize) {
        let Some(step) = self.design.steps.get(index) else { return };
        let inputs = self.row.len();
        for (place, change) in step.changes.iter().enumerate() {
            let rates = |holds: &BTreeMap<Component, Hold>, component| match holds.get(&component) {
                Some(Hold::From(_, rates)) => rates.clone(),
                // Held at rest from the beginning.
                _ => vec![0.0; inputs],
            };
            match *change {
                Change::Prescribe { node, component, .. } => {
                    self.holds.insert((node, component), Hold::To(index, place));
                }
                Change::Hold { node, component } => {
                    let rates = rates(&self.holds, (node, component));
                    self.holds.insert((node, component), Hold::From(None, rates));
                }
                Change::MoveBy { node, component, .. } => {
                    let rates = rates(&self.holds, (node, component));
                    self.holds.insert((node, component), Hold::From(Some((index, place)), rates));
                }
                Change::Free { node, component } => {
                    self.holds.remove(&(node, component));
                }
            }
        }
    }

    /// Derivatives of all probes, and of the components that the next step keeps, by one parameter; with the reason where some
    /// of them are not to be trusted, and are no numbers. Which of them are known in another way, which are looked for, and which have to
    /// be trusted, is given.
    fn slope<const D: usize>(
        &self,
        path: &mut Continuation<'static, D>,
        packs: Packs<D>,
        (index, record): (usize, &StepHistory),
        (input, [known, counts, matters]): (usize, [&dyn Fn(usize) -> bool; 3]),
        kept: &[Component],
    ) -> Result<(Vec<Estimate>, Option<Reason>), Reason> {
        let size = size(self.row[input]);
        let largest = self.after[index].iter().filter(|value| value.is_finite()).fold(0.0, |m: f64, v| m.max(v.abs()));
        let probes = &self.design.model.probes;
        let greatest = solution::last_state(record).map(Greatest::of).unwrap_or_default();
        let mut found: Vec<Estimate> = Vec::new();
        let mut open: Vec<usize> = Vec::new();
        for (round, part) in APART.into_iter().enumerate() {
            let apart = part * size;
            let mut pair = |by: f64| {
                let mut at = |by: f64| self.neighbour(path, packs, (index, record), (input, by), kept);
                let (ahead, behind) = (at(by)?, at(-by)?);
                let bends = bend(&ahead.moved, &behind.moved) > CHANGED * by / (NEAR * size);
                let unsettled = round + 1 < APART.len() && !(ahead.settled && behind.settled);
                match bends || unsettled {
                    true => Err(Reason::Singular { step: index }),
                    false => Ok([ahead.values, behind.values]),
                }
            };
            // Nearer by, the factors at hand lead to neighbours that they do not lead to here; a singular point stays one.
            let (near, far) = match pair(apart).and_then(|near| Ok((near, pair(2.0 * apart)?))) {
                Ok(both) => both,
                Err(Reason::Singular { .. }) if round + 1 < APART.len() => continue,
                Err(reason) => return Err(reason),
            };
            let beyond = pair(4.0 * apart).ok();
            let all: Vec<usize> =
                if found.is_empty() { (0..near[0].len()).collect() } else { std::mem::take(&mut open) };
            found.resize(near[0].len(), Estimate::NONE);
            for quantity in all {
                let slope =
                    |[ahead, behind]: &[Vec<f64>; 2], by: f64| (ahead[quantity] - behind[quantity]) / (2.0 * by);
                let (one, two) = (slope(&near, apart), slope(&far, 2.0 * apart));
                let noise = ROUNDING * largest.max(near[0][quantity].abs()) / apart;
                let kind = (quantity < probes.len()).then(|| probes.kind(quantity));
                let vanishes = VANISHES[usize::from(round + 1 == APART.len())];
                let nothing = vanishes * greatest.like(kind, near[0][quantity]) / size;
                let four = beyond.as_ref().map(|beyond| slope(beyond, 4.0 * apart));
                let estimate = extrapolated([one, two], four, near[0][quantity].abs() / apart);
                let measure = estimate.slope.abs().max(self.floor(index, &greatest, quantity) / size);
                let is_near = four.is_some() && estimate.error <= ENOUGH * measure;
                // What is not a number in the state itself is none here either.
                if !is_near && (one - two).abs() > (AGREED * one.abs()).max(nothing) + noise {
                    open.push(quantity);
                }
                if estimate.error < found[quantity].error {
                    found[quantity] = estimate;
                }
            }
            if !open.iter().any(|&quantity| counts(quantity)) {
                break;
            }
        }
        let mut reason = None;
        for quantity in open {
            if known(quantity) {
                continue;
            }
            found[quantity] = Estimate::NONE;
            if matters(quantity) {
                reason = reason.or(Some(self.doubt(index, quantity)));
            }
        }
        Ok((found, reason))
    }

    /// Whether the derivative of a probe, or of a component beyond them, is asked for.
    fn counts(&self, index: usize, quantity: usize) -> bool {
        let wanted = |output: &super::Output| output.probe == quantity && output.step == index;
        quantity >= self.after[index].len() || self.problem.outputs.iter().any(wanted)
    }

    /// Why a derivative is not to be trusted: what is greatest somewhere, or made by an expression, may have a corner.
    fn doubt(&self, index: usize, quantity: usize) -> Reason {
        let wanted = |output: &super::Output| output.probe == quantity && output.step == index;
        let output = self.problem.outputs.iter().position(wanted);
        let asked = output.filter(|_| !self.design.model.probes.kind(quantity).is_asked());
        asked.map_or(Reason::Singular { step: index }, |output| Reason::NoDerivative { output })
    }

    /// All probes of the design whose parameter is this much larger, at the end of a step.
    fn neighbour<const D: usize>(
        &self,
        path: &mut Continuation<'static, D>,
        packs: Packs<D>,
        (index, record): (usize, &StepHistory),
        (input, by): (usize, f64),
        kept: &[Component],
    ) -> Result<Neighbour, Reason> {
        self.wanted()?;
        let mut row = self.row.to_vec();
        row[input] += by;
        let model = self
            .problem
            .model_beside(&row)
            .map_err(|reason| Reason::Edge { parameter: input, reason: reason.into() })?;
        let (mut structure, steps) =
            discretize(&model, &mesh::fitted(&self.problem.mesh, &self.problem.middle, &model));
        let held = self.held(&path.system.pattern.equations.held, &steps, (input, by));
        let held = neighbour::rows(&held, &structure);
        take_pieces(&mut structure, &path.system.loading.drives);
        let mut drives = vec![0.0; structure.drives.len()];
        for &(drive, value) in steps.iter().take(index + 1).flat_map(|step| &step.targets) {
            drives[drive] = value;
        }
        let mut system = together::system(&path.system, packs, structure, &self.design.steps);
        system.adopt(&path.system);
        system.stand_at_end(&path.system, held, &drives);
        let (moved, near) =
            neighbour::approach(&mut system, &mut path.system).ok_or(Reason::Singular { step: index })?;
        let settled = neighbour::polish(&mut system) && near;
        let state = neighbour::read(&mut system);
        // Values after the steps before, to first order: that is all that counts.
        let inputs = self.row.len();
        let later = |(values, slopes): (&Vec<f64>, &Vec<f64>)| {
            let rate = |probe: usize| slopes.get(probe * inputs + input).copied().unwrap_or(f64::NAN);
            values.iter().enumerate().map(|(probe, value)| value + by * rate(probe)).collect()
        };
        let after: Vec<Vec<f64>> = self.after[..index].iter().zip(&self.slopes).map(later).collect();
        let mut values = self.probes(&model, record, state, &after);
        values.extend(kept.iter().map(|&(node, component)| together::present(&system, node, component)));
        Ok(Neighbour { values, moved, settled })
    }

    /// What is held at the end of the present step, with the values of a neighbour.
    fn held(&self, held: &[Held], steps: &[Step], (input, by): (usize, f64)) -> Vec<Held> {
        let value = |steps: &[Step], (step, place): (usize, usize)| match steps[step].changes[place] {
            Change::Prescribe { to, .. } => to,
            Change::MoveBy { by, .. } => by,
            Change::Hold { .. } | Change::Free { .. } => 0.0,
        };
        let row = |row: &Held| {
            let to = match self.holds.get(&(row.node, row.component)) {
                None => row.to,
                Some(Hold::To(step, place)) => value(steps, (*step, *place)),
                Some(Hold::From(moved, rates)) => {
                    let moved = moved.map_or(0.0, |at| value(steps, at) - value(&self.design.steps, at));
                    row.to + moved + by * rates[input]
                }
            };
            Held { to, ..*row }
        };
        held.iter().map(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Differences of a function over a distance, and over two and four times as much.
    fn differences(value: impl Fn(f64) -> f64, by: f64) -> [f64; 3] {
        [1.0, 2.0, 4.0].map(|times| (value(times * by) - value(-times * by)) / (2.0 * times * by))
    }

    #[test]
    fn what_a_smooth_function_leaves_is_less_than_is_said() {
        let [one, two, four] = differences(|x| 1.0 / (1.0 - x), 0.01);
        let (of_two, of_three) = (extrapolated([one, two], None, 0.0), extrapolated([one, two], Some(four), 0.0));
        for found in [of_two, of_three] {
            assert!((found.slope - 1.0).abs() <= 1.01 * found.error && found.error < 1e-7, "{found:?}");
        }
        assert!((of_three.slope - 1.0).abs() < 1e-2 * (of_two.slope - 1.0).abs(), "{of_three:?} {of_two:?}");
    }

    #[test]
    fn rounding_is_told_by_the_third_distance() {
        for rounding in [3e-9, -3e-9, 1e-8] {
            let [one, two, four] = differences(|x| x.sin() + if x == 1e-3 { rounding } else { 0.0 }, 1e-3);
            let found = extrapolated([one, two], Some(four), 0.0);
            let miss = (found.slope - 1.0).abs();
            assert!(miss > 1e-6 && miss <= found.error && found.error < 10.0 * miss, "{found:?} {miss:e}");
        }
    }
}
