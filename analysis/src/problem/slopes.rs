//! One design step by step, with the derivatives at the ends of its steps.

use std::collections::BTreeMap;

use pennate_models::Model;
use pennate_solver::continuation::Continuation;
use pennate_solver::history::{Equilibrium, History, Status};
use pennate_solver::packs::MODERATE;
use pennate_solver::structure::Change;

use super::adjoint::Exact;
use super::design::Design;
use super::estimate::Estimate;
use super::explicit::Kept;
use super::gradient::Row;
use super::nearby::Nearby;
use super::{Control, Problem, Reason, design, neighbour};
use crate::solution;
use crate::together::{Found, Packs, Standing};

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
    pub(super) slopes: Vec<Vec<Estimate>>,
    /// What the derivatives of every probe are measured by at least, each over the whole of a parameter.
    pub(super) floors: Vec<Vec<f64>>,
    /// The verdicts at the ends of the steps so far.
    stable: Vec<Option<bool>>,
    /// The first step that ended before the end of its ramp.
    stopped: Option<usize>,
    /// What is known less well than is promised.
    pub(super) inexact: Option<Reason>,
    /// Once they were asked for: nothing where there are none.
    pub(super) nearby: Option<Option<Vec<Nearby>>>,
}
impl<'a> Slopes<'a> {
    pub(super) fn new(problem: &'a Problem, row: &'a [f64], design: &'a Design, control: &'a Control) -> Self {
        Self {
            problem,
            row,
            design,
            control,
            holds: BTreeMap::new(),
            after: Vec::new(),
            slopes: Vec::new(),
            floors: Vec::new(),
            stable: Vec::new(),
            stopped: None,
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
        let (mut reason, mut copies) = (None, Kept::default());
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
        let (mut plane, mut space) = (Kept::default(), Kept::default());
        for (index, end) in found.ends.iter().enumerate() {
            let values = match end {
                Some(end) => self.design.model.probes.evaluate(&end.state, &self.after),
                None => vec![f64::NAN; self.design.model.probes.len()],
            };
            self.note_end(index, values);
            self.stable.push(Some(true));
            let kept = self.design.kept_after(index);
            if !self.problem.reads(index) && kept.is_empty() {
                continue;
            }
            let at = (index, &end.as_ref()?.state);
            let slopes = match found.system(self.design.posed(), index)? {
                Standing::Plane(mut system) => self.adjoint(&mut system, at, (&kept, true), &mut plane),
                Standing::Space(mut system) => self.adjoint(&mut system, at, (&kept, true), &mut space),
            };
            let exact = slopes?.ok().filter(Exact::serves)?;
            let mut found = exact.found;
            let corner = self.combine(index, at.1, &mut found);
            let useless = self.note_inexact(at, &mut found);
            if corner.or(useless).is_some() || self.inexact.is_some() {
                return None;
            }
            self.keep(index, &kept, found);
        }
        Some(self.finish(None))
    }

    /// Takes note of the values of all probes at the end of a step.
    fn note_end(&mut self, index: usize, values: Vec<f64>) {
        self.note_holds(index);
        self.after.push(values);
        self.slopes.push(Vec::new());
        self.floors.push(Vec::new());
    }

    /// Takes note of derivatives at the end of a step, of all probes and of components that the next one keeps.
    fn keep(&mut self, index: usize, kept: &[Component], mut slopes: Vec<Estimate>) {
        let (probes, inputs) = (self.after[index].len(), self.row.len());
        for (&component, rates) in kept.iter().zip(slopes[probes * inputs..].chunks_exact(inputs.max(1))) {
            self.holds.insert(component, Hold::From(None, rates.iter().map(|rate| rate.slope).collect()));
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
                step.map_or(f64::NAN, |slopes| slopes[output.probe * inputs + input].slope)
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
        copies: &mut Kept<D>,
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
        let values = self.probes(&self.design.model, last.state.clone(), &self.after);
        self.note_end(index, values);
        // What stops at a value of its own moves with all parameters along the path, and so does what goes on from there.
        if record.fraction != 1.0 {
            self.stopped.get_or_insert(index);
        }
        let kept = self.design.kept_after(index);
        if !self.problem.reads(index) && kept.is_empty() {
            return Ok(());
        }
        if let Some(step) = self.stopped {
            return Err(Reason::StopsShort { step });
        }
        let (probes, inputs) = (self.after[index].len(), self.row.len());
        if design::is_unbalanced(record) {
            self.keep(index, &kept, vec![Estimate::NONE; (probes + kept.len()) * inputs]);
            return Err(Reason::Unbalanced { step: index });
        }
        neighbour::settle(&mut path.system);
        let found = self.adjoint(&mut path.system, (index, &last.state), (&kept, false), copies);
        let (mut slopes, reason) = match found {
            Some(Err(reason)) => (vec![Estimate::NONE; (probes + kept.len()) * inputs], Some(reason)),
            Some(Ok(exact)) if exact.serves() => (exact.found, None),
            found => {
                let exact = found.and_then(Result::ok);
                // Neighbours strain what is held by motions of second order: where that gives, they are found.
                let own = path.system.loading.auxiliary;
                if path.system.loading.holds_strains() {
                    path.system.loading.auxiliary = MODERATE;
                    path.system.apply_drives();
                }
                path.system.assemble(false);
                let (mut found, reason) = self.by_neighbours(path, packs, (index, record), &kept, exact.as_ref());
                if path.system.loading.auxiliary != own {
                    path.system.loading.auxiliary = own;
                    path.system.apply_drives();
                    path.system.assemble(false);
                }
                if let Some(Exact { found: exact, regular, .. }) = exact {
                    // Where neighbours show no singular point, they leave no doubt about what no distance goes into.
                    let both = found.iter_mut().zip(exact);
                    let better =
                        both.filter(|(near, exact)| exact.error <= near.error && (regular || near.slope.is_finite()));
                    better.for_each(|(near, exact)| *near = exact);
                }
                (found, reason)
            }
        };
        let corner = self.combine(index, &last.state, &mut slopes);
        let useless = self.note_inexact((index, &last.state), &mut slopes);
        let reason = reason.or(corner).or(useless);
        self.keep(index, &kept, slopes);
        reason.map_or(Ok(()), Err)
    }

    /// Stops where nobody waits any longer.
    pub(super) fn wanted(&self) -> Result<(), Reason> {
        if self.control.is_stopped() { Err(Reason::Interrupted) } else { Ok(()) }
    }

    /// Values of all probes in a state.
    pub(super) fn probes(&self, model: &Model, mut state: Equilibrium, after: &[Vec<f64>]) -> Vec<f64> {
        self.problem.mesh.name_sections(model, &mut state);
        model.probes.evaluate(&state, after)
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
}
