//! One design step by step, with the derivatives at the ends of its steps.

use std::collections::BTreeMap;

use pennate_models::Model;
use pennate_solver::continuation::{Beginning, Continuation};
use pennate_solver::history::{Equilibrium, History, Status};
use pennate_solver::packs::MODERATE;
use pennate_solver::results;
use pennate_solver::structure::Change;
use pennate_solver::system::System;

use super::adjoint::Exact;
use super::design::Design;
use super::estimate::Estimate;
use super::explicit::Kept;
use super::gradient::Row;
use super::nearby::{Nearby, apart};
use super::{Control, Problem, Reason, design, neighbour};
use crate::solution;
use crate::together::{self, Found, Packs, Standing};

/// A component of a node, in the axes of its support.
pub(super) type Component = (usize, usize);

/// A state that derivatives are found in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// Where the first step begins: the equilibrium of the prestress.
    Beginning,
    /// The end of a step.
    End(usize),
}

impl Stage {
    /// How many steps are behind.
    pub(super) fn behind(self) -> usize {
        match self {
            Self::Beginning => 0,
            Self::End(step) => step + 1,
        }
    }

    /// The step that ends there, or the first one where that begins.
    pub(super) fn step(self) -> usize {
        self.behind().saturating_sub(1)
    }

    /// Its tangent is singular, or so nearly that there are no derivatives.
    pub(super) fn singular(self) -> Reason {
        Reason::Singular { step: self.step(), begins: self == Self::Beginning }
    }
}

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
        let mut copies = Kept::default();
        let reached = history.steps.first().is_some_and(|step| step.status == Status::Converged);
        let mut reason = if reached { self.begin(&mut path, packs, &mut copies) } else { None };
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
        if self.begins_moved() {
            return None;
        }
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
            let at = (Stage::End(index), &end.as_ref()?.state);
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
        let beyond = slopes.split_off(self.design.model.probes.len() * self.row.len());
        self.slopes[index] = slopes;
        self.keep_components(kept, &beyond);
    }

    /// Takes note of derivatives of components that the next step keeps.
    fn keep_components(&mut self, kept: &[Component], slopes: &[Estimate]) {
        for (&component, rates) in kept.iter().zip(slopes.chunks_exact(self.row.len().max(1))) {
            self.holds.insert(component, Hold::From(None, rates.iter().map(|rate| rate.slope).collect()));
        }
    }

    /// Values of all probes in a state; none before the first step.
    pub(super) fn values_at(&self, stage: Stage) -> &[f64] {
        match stage {
            Stage::Beginning => &[],
            Stage::End(step) => &self.after[step],
        }
    }

    /// Whether the first step keeps components where a prestress may have moved them: one of this design, or of designs beside it.
    fn begins_moved(&self) -> bool {
        let structure = &self.design.structure;
        if self.design.kept_by(0).is_empty() || structure.springs.is_empty() {
            return false;
        }
        let beside = |(input, times): (usize, f64)| {
            let mut row = self.row.to_vec();
            row[input] += times * apart(self.row[input]);
            self.problem.design_beside(&row).is_ok_and(|design| design.structure.is_prestressed())
        };
        let mut sides = (0..self.row.len()).flat_map(|input| [(input, -1.0), (input, 1.0)]);
        structure.is_prestressed() || sides.any(beside)
    }

    /// Derivatives of the components that the first step keeps where it begins; with the reason where some are not known.
    fn begin<const D: usize>(
        &mut self,
        path: &mut Continuation<'static, D>,
        packs: Packs<D>,
        copies: &mut Kept<D>,
    ) -> Option<Reason> {
        let Beginning { state, held } = path.beginning.take().filter(|_| self.begins_moved())?;
        let ended = &path.system;
        let mut system = together::system(ended, packs, (*ended.structure).clone(), &self.design.steps);
        system.restore(&state);
        system.loading.auxiliary = ended.loading.auxiliary;
        system.stand_at_end(ended, held, &vec![0.0; ended.loading.drives.len()]);
        system.place_ends();
        neighbour::settle(&mut system);
        let state = results::equilibrium(&mut system);
        let (stage, kept) = (Stage::Beginning, self.design.kept_by(0));
        let (mut slopes, reason) = self.find(&mut system, packs, (stage, &state), &kept, copies);
        let useless = self.note_inexact((stage, &state), &mut slopes);
        self.keep_components(&kept, &slopes[self.design.model.probes.len() * self.row.len()..]);
        reason.or(useless)
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
        let at = (Stage::End(index), &last.state);
        let (mut slopes, reason) = self.find(&mut path.system, packs, at, &kept, copies);
        let corner = self.combine(index, &last.state, &mut slopes);
        let useless = self.note_inexact(at, &mut slopes);
        let reason = reason.or(corner).or(useless);
        self.keep(index, &kept, slopes);
        reason.map_or(Ok(()), Err)
    }

    /// Derivatives in a state in which a system stands, of the probes that are needed there and of components that the next step keeps: by
    /// the adjoint method, and where that does not do by neighbours; with the reason where some are not known.
    fn find<const D: usize>(
        &mut self,
        system: &mut System<D>,
        packs: Packs<D>,
        at: (Stage, &Equilibrium),
        kept: &[Component],
        copies: &mut Kept<D>,
    ) -> (Vec<Estimate>, Option<Reason>) {
        let exact = match self.adjoint(system, at, (kept, false), copies) {
            Some(Err(reason)) => {
                let count = self.design.model.probes.len() + kept.len();
                return (vec![Estimate::NONE; count * self.row.len()], Some(reason));
            }
            Some(Ok(exact)) if exact.serves() => return (exact.found, None),
            found => found.and_then(Result::ok),
        };
        // Neighbours strain what is held by motions of second order: where that gives, they are found.
        let own = system.loading.auxiliary;
        if system.loading.holds_strains() {
            system.loading.auxiliary = MODERATE;
            system.apply_drives();
        }
        system.assemble(false);
        let (mut found, reason) = self.by_neighbours(system, packs, at, kept, exact.as_ref());
        if system.loading.auxiliary != own {
            system.loading.auxiliary = own;
            system.apply_drives();
            system.assemble(false);
        }
        if let Some(Exact { found: exact, regular, .. }) = exact {
            // Where neighbours show no singular point, they leave no doubt about what no distance goes into.
            let both = found.iter_mut().zip(exact);
            let better = both.filter(|(near, exact)| exact.error <= near.error && (regular || near.slope.is_finite()));
            better.for_each(|(near, exact)| *near = exact);
        }
        (found, reason)
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

    /// Takes note of what a step changes about what is held; where components were is known from the step before, or from where the first
    /// one begins.
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
