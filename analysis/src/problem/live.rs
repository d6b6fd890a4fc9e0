//! Equilibria that are kept, and followed as parameters change.

use std::fmt;

use pennate_models::{Model, discretize};
use pennate_solver::base::{self, Followed};
use pennate_solver::history::{Equilibrium, History, Status, StepHistory};
use pennate_solver::options::Options;
use pennate_solver::structure::{Dimension, Step, Structure};
use rayon::prelude::*;

use super::design::Design;
use super::numbers::{self, Numbers, Places};
use super::track::{self, Track};
use super::{Problem, Reason, mesh, neighbour};
use crate::solution::ProbeTable;

/// Part of a change that is gone at once, at the least.
const SHORTEST: f64 = 1e-3;
/// How much shorter a part is tried where one leads elsewhere, and how much longer one after a success.
const SHORTER: f64 = 0.4;
const LONGER: f64 = 2.0;

/// An equilibrium at the end of the last step that is kept, and followed to other values of the parameters.
///
/// It goes from one equilibrium to the next one, as a load that grows slowly would: by as many parts of a change as its
/// iteration needs, each of which must lead to an equilibrium nearby of the same stability. Structure may change on the way as
/// loads may. Where steps of the file held something where it was, it stays there.
pub struct Live {
    problem: Problem,
    track: Followable,
    /// The record of the last step, and the values of all probes after those before it.
    record: StepHistory,
    after: Vec<Vec<f64>>,
    /// What those steps were solved with, where outputs ask for them.
    earlier: Option<Earlier>,
    wanted: Vec<f64>,
    present: Vec<f64>,
    values: Vec<f64>,
}

/// The steps before the last one, as they were solved.
#[derive(Clone)]
struct Earlier {
    /// Values of controls there.
    controls: Vec<f64>,
    numbers: Numbers,
}

enum Followable {
    Plane(Box<Track<3>>),
    Space(Box<Track<6>>),
}

impl fmt::Debug for Live {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Live").field("present", &self.present).field("values", &self.values).finish_non_exhaustive()
    }
}

impl Problem {
    /// Equilibria at the values of the file, to be followed from there side by side: so many of them.
    ///
    /// # Errors
    /// As [`Problem::live`].
    pub fn live_all(&self, count: usize) -> Result<Lives, Reason> {
        let first = self.live()?;
        let mut states: Vec<Live> = (1..count).map(|_| first.another()).collect();
        states.extend((count > 0).then_some(first));
        Ok(Lives { states })
    }

    /// An equilibrium at the values of the file, to be followed from there.
    ///
    /// # Errors
    /// Where a step does not reach its end.
    pub fn live(&self) -> Result<Live, Reason> {
        self.live_at(&self.middle())
    }

    /// An equilibrium at these values, to be followed from there.
    ///
    /// # Errors
    /// Where a step does not reach its end.
    pub fn live_at(&self, row: &[f64]) -> Result<Live, Reason> {
        let design = self.whole_design(row)?;
        let earlier = self.reads_earlier(design.steps.len()).then(|| Earlier::of(&design));
        let Design { model, structure, steps } = design;
        let options = Options::default();
        let (followed, mut history) = base::follow(&structure, &steps, steps.len(), &options, &mut |_| true)?;
        self.mesh.name_segments(&model, &mut history);
        if let Some(index) = history.steps.iter().position(|step| step.status != Status::Converged) {
            let step = &history.steps[index];
            let cause = step.failure.as_ref().map(|failure| failure.cause);
            return Err(Reason::Stopped { step: index, status: step.status, fraction: step.fraction, cause });
        }
        if let Some(step) = history.steps.iter().find(|step| step.fraction != 1.0) {
            return Err(Reason::Lost { fraction: step.fraction });
        }
        let track = match followed {
            Followed::Plane(path) => {
                let path = *path;
                let sideways = path.stability == Dimension::Space && path.lateral.is_some();
                Followable::Plane(Box::new(Track::new(track::plane(), path.system, sideways, steps)))
            }
            Followed::Space(path) => Followable::Space(Box::new(Track::new(track::space(), path.system, false, steps))),
        };
        let table = ProbeTable::new(&model, &history);
        let mut after: Vec<Vec<f64>> = table.steps.iter().filter_map(|step| step.last()).map(<[f64]>::to_vec).collect();
        let last = after.pop().unwrap_or_default();
        let record = history.steps.pop().ok_or(Reason::Interrupted)?;
        let record = neighbour::history_of(&record, Equilibrium::default()).steps.remove(0);
        let (present, wanted) = (row.to_vec(), row.to_vec());
        let values = Vec::new();
        let mut live = Live { problem: self.clone(), track, record, after, earlier, wanted, present, values };
        live.values = live.outputs(&last);
        Ok(live)
    }

    /// The design of a row of values with all of its steps.
    fn whole_design(&self, row: &[f64]) -> Result<Design, Reason> {
        let model = self.model(row)?;
        let (structure, steps) = discretize(&model, &mesh::fitted(&self.mesh, &self.middle, &model));
        Ok(Design { model, structure, steps })
    }

    /// Whether any output is that of a step before the last of so many, or refers to one.
    fn reads_earlier(&self, steps: usize) -> bool {
        (0..steps.saturating_sub(1)).any(|step| self.reads(step))
    }
}

impl Earlier {
    fn of(design: &Design) -> Self {
        let before = before(design);
        let controls = numbers::controls(&design.structure, before);
        Self { numbers: Numbers::of(&design.model, &design.structure, before, &controls), controls }
    }

    /// Whether the steps before the last one are the same in another design.
    fn is_of(&self, design: &Design) -> bool {
        let before = before(design);
        let other = Numbers::of(&design.model, &design.structure, before, &self.controls);
        let probes = Places::of(&design.structure, before).probes;
        other.len() == self.numbers.len() && !(0..probes).any(|part| other.differs(&self.numbers, part))
    }
}

fn before(design: &Design) -> &[Step] {
    &design.steps[..design.steps.len().saturating_sub(1)]
}

impl Live {
    /// Sets a parameter, by its place in a row, to a value that the next [`Live::solve`] goes to.
    ///
    /// # Panics
    /// Where there is no parameter of that place.
    pub fn set(&mut self, parameter: usize, value: f64) {
        self.wanted[parameter] = value;
    }

    /// Values of the parameters that the present state belongs to.
    pub fn present(&self) -> &[f64] {
        &self.present
    }

    /// Goes to the values that were set.
    ///
    /// # Errors
    /// Where the way does not lead there: an equilibrium that ends or loses its stability, or values that make no network. The
    /// state is then the last one on the way, [`Live::present`] says whose, and what was set stays set.
    pub fn solve(&mut self) -> Result<(), Reason> {
        let from = self.present.clone();
        let went = self.go();
        if self.present != from {
            self.look_back();
        }
        went
    }

    fn go(&mut self) -> Result<(), Reason> {
        let from = self.present.clone();
        let (mut at, mut part) = (0.0, 1.0);
        while at < 1.0 {
            let next = f64::min(at + part, 1.0);
            let row: Vec<f64> = match next {
                1.0 => self.wanted.clone(),
                _ => from.iter().zip(&self.wanted).map(|(from, to)| from + next * (to - from)).collect(),
            };
            if self.step(row)? {
                (at, part) = (next, LONGER * part);
            } else {
                part = SHORTER * (next - at);
                if part < SHORTEST {
                    return Err(Reason::Lost { fraction: at });
                }
            }
        }
        Ok(())
    }

    /// Goes to values nearby; false where no equilibrium of the same stability is there.
    fn step(&mut self, row: Vec<f64>) -> Result<bool, Reason> {
        let Design { model, structure, steps } = self.problem.whole_design(&row)?;
        let Some(state) = self.track.step(structure, steps) else { return Ok(false) };
        self.evaluate(&model, state);
        self.present = row;
        Ok(true)
    }

    /// Reads the outputs in a state.
    fn evaluate(&mut self, model: &Model, state: Equilibrium) {
        let problem = &self.problem;
        let values = if problem.mesh.grading.is_empty() || state.sections.is_empty() {
            model.probes.evaluate(&state, &self.after)
        } else {
            let mut history: History = neighbour::history_of(&self.record, state);
            problem.mesh.name_segments(model, &mut history);
            model.probes.evaluate(&history.steps[0].increments[0].state, &self.after)
        };
        self.values = self.outputs(&values);
    }

    /// Solves the steps before the last one again, where outputs ask for them and the parameters made others of them.
    fn look_back(&mut self) {
        let Some(earlier) = &self.earlier else { return };
        let Ok(design) = self.problem.whole_design(&self.present) else { return };
        if earlier.is_of(&design) {
            return;
        }
        self.earlier = Some(Earlier::of(&design));
        let Design { model, structure, steps } = design;
        let count = steps.len() - 1;
        self.after = vec![vec![f64::NAN; model.probes.len()]; count];
        if let Ok(mut history) = pennate_solver::solve(&structure, &steps[..count], &Options::default(), &mut |_| true)
        {
            self.problem.mesh.name_segments(&model, &mut history);
            let table = ProbeTable::new(&model, &history);
            let ends = history.steps.iter().zip(&table.steps).take_while(|(step, _)| step.status == Status::Converged);
            for (after, (_, values)) in self.after.iter_mut().zip(ends) {
                if let Some(last) = values.last() {
                    *after = last.to_vec();
                }
            }
        }
        let state = self.track.read();
        self.evaluate(&model, state);
    }

    /// The outputs among the probes, and among those after the steps before.
    fn outputs(&self, probes: &[f64]) -> Vec<f64> {
        let value = |output: &super::Output| self.after.get(output.step).map_or(probes, Vec::as_slice)[output.probe];
        self.problem.outputs.iter().map(value).collect()
    }

    /// The outputs: in the present state, or those of a step before the last one on a way to it from the beginning; not a
    /// number where that way does not reach the end of such a step.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Whether the present state is stable; `None` where loads have no potential.
    pub fn stable(&self) -> Option<bool> {
        match &self.track {
            Followable::Plane(track) => track.stable(),
            Followable::Space(track) => track.stable(),
        }
    }

    /// Another state of its own, at the same equilibrium.
    pub fn another(&self) -> Self {
        let track = match &self.track {
            Followable::Plane(track) => Followable::Plane(Box::new(track.another())),
            Followable::Space(track) => Followable::Space(Box::new(track.another())),
        };
        Self {
            problem: self.problem.clone(),
            track,
            record: self.record.clone(),
            after: self.after.clone(),
            earlier: self.earlier.clone(),
            wanted: self.wanted.clone(),
            present: self.present.clone(),
            values: self.values.clone(),
        }
    }
}

impl Followable {
    fn step(&mut self, structure: Structure, steps: Vec<Step>) -> Option<Equilibrium> {
        match self {
            Self::Plane(track) => track.step(structure, steps).then(|| track.read()),
            Self::Space(track) => track.step(structure, steps).then(|| track.read()),
        }
    }

    fn read(&mut self) -> Equilibrium {
        match self {
            Self::Plane(track) => track.read(),
            Self::Space(track) => track.read(),
        }
    }
}

/// Equilibria of one problem that are kept and followed side by side, on the threads of the current pool.
#[derive(Debug)]
pub struct Lives {
    states: Vec<Live>,
}

impl Lives {
    /// Sets all parameters of all states: a row of k values each.
    ///
    /// # Panics
    /// Where `x` has not n rows of k values.
    pub fn set(&mut self, x: &[f64]) {
        let width = self.states.first().map_or(0, |state| state.wanted.len());
        assert_eq!(x.len(), width * self.states.len(), "one row of values for every state");
        for (state, row) in self.states.iter_mut().zip(x.chunks_exact(width.max(1))) {
            state.wanted.copy_from_slice(row);
        }
    }

    /// Goes to the values that were set; gives for every state why it did not get there, where it did not.
    pub fn solve(&mut self) -> Vec<Option<Reason>> {
        self.states.par_iter_mut().map(|state| state.solve().err()).collect()
    }

    /// The outputs in the present states: a row of m values each.
    pub fn values(&self) -> Vec<f64> {
        self.states.iter().flat_map(|state| state.values()).copied().collect()
    }

    /// Whether the present states are stable, as [`Live::stable`].
    pub fn stable(&self) -> Vec<Option<bool>> {
        self.states.iter().map(Live::stable).collect()
    }

    /// One of the states.
    pub fn state(&mut self, index: usize) -> Option<&mut Live> {
        self.states.get_mut(index)
    }
}
