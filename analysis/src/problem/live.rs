//! Equilibria that are kept, and followed as parameters change.

use std::fmt;

use pennate_models::{Model, discretize};
use pennate_solver::base::{self, Followed};
use pennate_solver::error::SolveError;
use pennate_solver::history::{Equilibrium, History, Status, StepHistory};
use pennate_solver::options::Options;
use pennate_solver::structure::{Dimension, Step, Structure};
use rayon::prelude::*;

use super::design::Design;
use super::numbers::{self, Numbers, Places};
use super::track::Track;
use super::{Control, Problem, Reason, mesh, neighbour};
use crate::solution::ProbeTable;
use crate::together;

/// Part of what is gone of a change already that is gone at once, at the least; the square of it where nothing is. A way ends within a
/// thousandth of the singular point that it leads to, and the next one begins there.
const SHORTEST: f64 = 1e-3;
/// How much shorter a part is tried where one leads elsewhere, and how much longer one after a success.
const SHORTER: f64 = 0.4;
const LONGER: f64 = 2.0;

/// An equilibrium at the end of the last step that is kept, and followed to other values of the parameters.
///
/// It goes from one equilibrium to the next one, as a load that grows slowly would: by as many parts of a change as its
/// iteration needs, each of which must lead to an equilibrium nearby of the same stability. Structure may change on the way as
/// loads may. What a step of the file holds where it was, or moves on from there, is held where it was at the values that the
/// state began with, where a solve from the beginning would hold it where the prestress and the steps before lead to at the new ones.
pub struct Live {
    problem: Problem,
    track: Followable,
    /// The record of the last step, and the values of all probes after those before it.
    record: StepHistory,
    after: Vec<Vec<f64>>,
    /// The states at the ends of those steps, where outputs ask for them.
    earlier: Option<Earlier>,
    /// The design that was reached last, and its state.
    reached: Option<(Design, Equilibrium)>,
    wanted: Vec<f64>,
    present: Vec<f64>,
    values: Vec<f64>,
}

/// The steps before the last one.
struct Earlier {
    /// Values of controls there.
    controls: Vec<f64>,
    numbers: Numbers,
    /// The states at their ends, followed as the last one is, or why there is none; nothing where no output asks for one.
    tracks: Vec<Option<Result<Followable, Reason>>>,
    /// Those that are not where the last state is: nobody waited for them.
    behind: Vec<bool>,
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
        self.live_all_while(count, &Control::default())
    }

    /// The same, which may be stopped on the way.
    ///
    /// # Errors
    /// As [`Problem::live`], and [`Reason::Interrupted`].
    pub fn live_all_while(&self, count: usize, control: &Control) -> Result<Lives, Reason> {
        let first = self.live_at_while(&self.middle(), control)?;
        let mut states: Vec<Live> = Vec::with_capacity(count);
        while states.len() + 1 < count {
            if control.is_stopped() {
                return Err(Reason::Interrupted);
            }
            states.push(first.another());
        }
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

    /// The same, which may be stopped on the way.
    ///
    /// # Errors
    /// As [`Problem::live`], and [`Reason::Interrupted`].
    pub fn live_while(&self, control: &Control) -> Result<Live, Reason> {
        self.live_at_while(&self.middle(), control)
    }

    /// An equilibrium at these values, to be followed from there.
    ///
    /// # Errors
    /// Where a step does not reach its end.
    pub fn live_at(&self, row: &[f64]) -> Result<Live, Reason> {
        self.live_at_while(row, &Control::default())
    }

    fn live_at_while(&self, row: &[f64], control: &Control) -> Result<Live, Reason> {
        let design = self.whole_design(row)?;
        let earlier = self.reads_earlier(design.steps.len()).then(|| Earlier::of(self, &design, control));
        let (followed, mut history) = follow(&design, design.steps.len(), control)?;
        if control.is_stopped() {
            return Err(Reason::Interrupted);
        }
        let Design { model, steps, .. } = design;
        self.mesh.name_segments(&model, &mut history);
        whole(&history)?;
        let track = Followable::of(followed, steps);
        let table = ProbeTable::new(&model, &history);
        let mut after: Vec<Vec<f64>> = table.steps.iter().filter_map(|step| step.last()).map(<[f64]>::to_vec).collect();
        let last = after.pop().unwrap_or_default();
        let record = history.steps.pop().ok_or(Reason::Interrupted)?;
        let record = neighbour::history_of(&record, Equilibrium::default()).steps.remove(0);
        let (present, wanted) = (row.to_vec(), row.to_vec());
        let values = Vec::new();
        let problem = self.clone();
        let mut live = Live { problem, track, record, after, earlier, reached: None, wanted, present, values };
        live.values = live.outputs(&last);
        Ok(live)
    }

    /// The design of a row of values with all of its steps.
    fn whole_design(&self, row: &[f64]) -> Result<Design, Reason> {
        let model = self.model(row)?;
        let (structure, steps) = discretize(&model, &mesh::fitted(&self.mesh, &self.middle, &model));
        Ok(Design { model, structure, steps, may_serve: false })
    }

    /// Values of all probes in a state at the end of a step, after those at the ends of the steps before it.
    fn probe_values(&self, model: &Model, like: &StepHistory, state: Equilibrium, after: &[Vec<f64>]) -> Vec<f64> {
        if self.mesh.grading.is_empty() || state.sections.is_empty() {
            return model.probes.evaluate(&state, after);
        }
        let mut history = neighbour::history_of(like, state);
        self.mesh.name_segments(model, &mut history);
        model.probes.evaluate(&history.steps[0].increments[0].state, after)
    }

    /// Whether any output is that of a step before the last of so many, or refers to one.
    fn reads_earlier(&self, steps: usize) -> bool {
        (0..steps.saturating_sub(1)).any(|step| self.reads(step))
    }
}

impl Earlier {
    fn of(problem: &Problem, design: &Design, control: &Control) -> Self {
        let before = before(design);
        let controls = numbers::controls(&design.structure, before);
        let numbers = Numbers::of(&design.model, &design.structure, before, &controls);
        let track = |step| problem.reads(step).then(|| Followable::at(design, step, control));
        let tracks = (0..before.len()).map(track).collect();
        Self { numbers, controls, tracks, behind: vec![false; before.len()] }
    }

    /// Goes to the ends of the steps of another design; false where they are the same.
    fn go(&mut self, problem: &Problem, design: &Design, control: &Control) -> bool {
        let before = before(design);
        let numbers = Numbers::of(&design.model, &design.structure, before, &self.controls);
        let probes = Places::of(&design.structure, before).probes;
        let same = numbers.len() == self.numbers.len() && !(0..probes).any(|part| numbers.differs(&self.numbers, part));
        if same && !self.is_behind() {
            return false;
        }
        self.controls = numbers::controls(&design.structure, before);
        self.numbers = Numbers::of(&design.model, &design.structure, before, &self.controls);
        let both = self.tracks.iter_mut().zip(&mut self.behind).enumerate();
        for (step, (track, behind)) in both.filter(|(step, _)| problem.reads(*step)) {
            let steps = design.steps[..=step].to_vec();
            let followed = |track: &mut Followable| track.step(design.structure.clone(), steps.clone(), control);
            if let Some(Ok(track)) = track
                && followed(track)
            {
                *behind = false;
                continue;
            }
            // A state that was not followed for want of time is worth keeping.
            let found = Followable::at(design, step, control);
            *behind = found.is_err() && control.is_stopped();
            if !*behind {
                *track = Some(found);
            }
        }
        true
    }

    /// Why the first end that there is none of is not there.
    fn lost(&self) -> Option<&Reason> {
        self.tracks.iter().flatten().find_map(|track| track.as_ref().err())
    }

    /// Whether any end is not where the last state is.
    fn is_behind(&self) -> bool {
        self.behind.contains(&true)
    }

    /// Values of all probes at the ends of the steps; not a number where there is no state.
    fn values(&mut self, problem: &Problem, model: &Model, record: &StepHistory) -> Vec<Vec<f64>> {
        let mut after: Vec<Vec<f64>> = Vec::with_capacity(self.tracks.len());
        for (track, &behind) in self.tracks.iter_mut().zip(&self.behind) {
            let values = match track {
                Some(Ok(track)) if !behind => problem.probe_values(model, record, track.read(), &after),
                _ => vec![f64::NAN; model.probes.len()],
            };
            after.push(values);
        }
        after
    }

    fn another(&self) -> Self {
        let another = |track: &Option<Result<Followable, Reason>>| {
            track.as_ref().map(|track| track.as_ref().map(Followable::another).map_err(Clone::clone))
        };
        let tracks = self.tracks.iter().map(another).collect();
        Self { controls: self.controls.clone(), numbers: self.numbers.clone(), tracks, behind: self.behind.clone() }
    }
}

/// Follows the first steps of a design.
fn follow(design: &Design, count: usize, control: &Control) -> Result<(Followed<'static>, History), SolveError> {
    let options = Options { stop: control.stop.clone(), ..Options::default() };
    base::follow(&design.structure, &design.steps[..count], count, &options, &mut |_| !control.is_stopped())
}

/// Whether all steps came to the ends of their ramps.
///
/// # Errors
/// Why the first that did not did not.
fn whole(history: &History) -> Result<(), Reason> {
    for (index, step) in history.steps.iter().enumerate() {
        if step.status != Status::Converged {
            let cause = step.failure.as_ref().map(|failure| failure.cause);
            return Err(Reason::Stopped { step: index, status: step.status, fraction: step.fraction, cause });
        }
        if step.fraction != 1.0 {
            return Err(Reason::StopsShort { step: index });
        }
    }
    Ok(())
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
    /// state is then the last one on the way, [`Live::present`] says whose, and what was set stays set. Where the way leads there, but an output
    /// asks for the end of an earlier step that has none any more, that is said, and the other outputs are those of the values that were set.
    pub fn solve(&mut self) -> Result<(), Reason> {
        self.solve_while(&Control::default())
    }

    /// The same, which may be stopped on the way: the state is then the last one that was reached, as where the way ends.
    /// Outputs of steps before the last one that were not followed there are no numbers, until the next solve.
    ///
    /// # Errors
    /// As [`Live::solve`], and [`Reason::Interrupted`].
    pub fn solve_while(&mut self, control: &Control) -> Result<(), Reason> {
        let went = self.go(control);
        if let Some((design, state)) = self.reached.take() {
            if let Some(earlier) = &mut self.earlier
                && earlier.go(&self.problem, &design, control)
            {
                self.after = earlier.values(&self.problem, &design.model, &self.record);
            }
            let values = self.problem.probe_values(&design.model, &self.record, state, &self.after);
            self.values = self.outputs(&values);
        }
        match &self.earlier {
            Some(earlier) if earlier.is_behind() => went.and(Err(Reason::Interrupted)),
            Some(earlier) => went.and_then(|()| earlier.lost().map_or(Ok(()), |reason| Err(reason.clone()))),
            None => went,
        }
    }

    fn go(&mut self, control: &Control) -> Result<(), Reason> {
        let from = self.present.clone();
        let (mut at, mut part) = (0.0, 1.0);
        while at < 1.0 {
            if control.is_stopped() {
                return Err(Reason::Interrupted);
            }
            let next = f64::min(at + part, 1.0);
            let row: Vec<f64> = match next {
                1.0 => self.wanted.clone(),
                _ => from.iter().zip(&self.wanted).map(|(from, to)| from + next * (to - from)).collect(),
            };
            if self.step(row, control)? {
                (at, part) = (next, LONGER * part);
            } else if !control.is_stopped() {
                part = SHORTER * (next - at);
                if part < SHORTEST * at.max(SHORTEST) {
                    return Err(Reason::Lost { fraction: at });
                }
            }
        }
        Ok(())
    }

    /// Goes to values nearby; false where no equilibrium of the same stability is there, or nobody waits any longer.
    fn step(&mut self, row: Vec<f64>, control: &Control) -> Result<bool, Reason> {
        let design = self.problem.whole_design(&row)?;
        if !self.track.step(design.structure.clone(), design.steps.clone(), control) {
            return Ok(false);
        }
        let state = self.track.read();
        self.reached = Some((design, state));
        self.present = row;
        Ok(true)
    }

    /// The outputs among the probes, and among those after the steps before.
    fn outputs(&self, probes: &[f64]) -> Vec<f64> {
        let value = |output: &super::Output| self.after.get(output.step).map_or(probes, Vec::as_slice)[output.probe];
        self.problem.outputs.iter().map(value).collect()
    }

    /// The outputs: in the present state, or those of a step before the last one, whose end is followed as the present state
    /// is, or solved for from the beginning where it ends; not a number where no way leads to it.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Whether the present state is stable, as a solve from the beginning says it; `None` where that is not known.
    ///
    /// Where loads have no potential and masses are known that is a matter of small vibrations, which are looked at when it is
    /// asked for, once a state: they take many times what the way to it took.
    pub fn stable(&mut self) -> Option<bool> {
        match &mut self.track {
            Followable::Plane(track) => track.stable(),
            Followable::Space(track) => track.stable(),
        }
    }

    /// [`Live::stable`], where it takes no time.
    pub fn judged(&self) -> Option<Option<bool>> {
        match &self.track {
            Followable::Plane(track) => track.judged(),
            Followable::Space(track) => track.judged(),
        }
    }

    /// Another state of its own, at the same equilibrium.
    pub fn another(&self) -> Self {
        let track = self.track.another();
        Self {
            problem: self.problem.clone(),
            track,
            record: self.record.clone(),
            after: self.after.clone(),
            earlier: self.earlier.as_ref().map(Earlier::another),
            reached: None,
            wanted: self.wanted.clone(),
            present: self.present.clone(),
            values: self.values.clone(),
        }
    }
}

impl Followable {
    fn of(followed: Followed<'_>, steps: Vec<Step>) -> Self {
        match followed {
            Followed::Plane(path) => {
                let path = *path;
                let sideways = path.stability == Dimension::Space && path.lateral.is_some();
                Self::Plane(Box::new(Track::new(together::plane(1), path.system, sideways, steps)))
            }
            Followed::Space(path) => Self::Space(Box::new(Track::new(together::space(1), path.system, false, steps))),
        }
    }

    /// The end of a step of a design, on a way to it from the beginning.
    ///
    /// # Errors
    /// Where that does not lead there.
    fn at(design: &Design, step: usize, control: &Control) -> Result<Self, Reason> {
        let (followed, history) = follow(design, step + 1, control)?;
        whole(&history)?;
        Ok(Self::of(followed, design.steps[..=step].to_vec()))
    }

    fn another(&self) -> Self {
        match self {
            Self::Plane(track) => Self::Plane(Box::new(track.another())),
            Self::Space(track) => Self::Space(Box::new(track.another())),
        }
    }

    fn step(&mut self, structure: Structure, steps: Vec<Step>, control: &Control) -> bool {
        match self {
            Self::Plane(track) => track.step(structure, steps, control),
            Self::Space(track) => track.step(structure, steps, control),
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
        self.solve_while(&Control::default())
    }

    /// The same, which may be stopped on the way: those that are not there yet then stay where they are.
    pub fn solve_while(&mut self, control: &Control) -> Vec<Option<Reason>> {
        self.states.par_iter_mut().map(|state| state.solve_while(control).err()).collect()
    }

    /// The outputs in the present states: a row of m values each.
    pub fn values(&self) -> Vec<f64> {
        self.states.iter().flat_map(|state| state.values()).copied().collect()
    }

    /// Values of the parameters that the present states belong to: a row of k values each.
    pub fn present(&self) -> Vec<f64> {
        self.states.iter().flat_map(Live::present).copied().collect()
    }

    /// Whether the present states are stable, as [`Live::stable`].
    pub fn stable(&mut self) -> Vec<Option<bool>> {
        self.stable_while(&Control::default())
    }

    /// The same, which may be stopped on the way: what was not looked at is not known then.
    pub fn stable_while(&mut self, control: &Control) -> Vec<Option<bool>> {
        let stable = |state: &mut Live| if control.is_stopped() { None } else { state.stable() };
        self.states.par_iter_mut().map(stable).collect()
    }

    /// The same, where it takes no time for all of them.
    pub fn judged(&self) -> Option<Vec<Option<bool>>> {
        self.states.iter().map(Live::judged).collect()
    }

    /// One of the states.
    pub fn state(&mut self, index: usize) -> Option<&mut Live> {
        self.states.get_mut(index)
    }
}
