//! A step whose end is known from a coarser mesh.
//!
//! Where a coarser mesh went without a singular point, the end of a step on a finer one lies next to it: a few
//! iterations lead there, and the way need not be gone again. If they do not, or if stability is another, it is. So it is
//! once a step was gone again: the next may begin on another branch than it did on the coarser mesh.

use super::Continuation;
use super::follow::Run;
use crate::history::{Status, StepHistory};
use crate::newton::{Convergence, Start};
use crate::structure::{Method, Step};
use crate::system::{State, System};

/// What a solve on a coarser mesh went through.
pub struct Coarse<const D: usize> {
    /// The structure on the coarser mesh.
    pub system: System<D>,
    /// The ends of steps.
    pub ends: Vec<End>,
    /// Whether increments of a step were cut short.
    cut: Vec<bool>,
    /// The same on elements of the next order, where there is one: it is much nearer.
    pub refined: Option<System<D>>,
    /// The same on the next order of elements.
    pub refined_ends: Vec<End>,
}

/// The end of a step, for a finer mesh to start from.
#[derive(Debug)]
pub enum End {
    /// It may not start from there.
    Unfit,
    /// The state of the system is the end of its last step: nothing is copied that no finer mesh may ever ask for.
    Present,
    /// The state.
    Kept(State),
}

impl End {
    /// That of a system that is there.
    fn of<const D: usize>(system: &System<D>, is_last: bool) -> Self {
        if is_last { Self::Present } else { Self::Kept(system.snapshot()) }
    }

    fn is_fit(&self) -> bool {
        !matches!(self, Self::Unfit)
    }
}

/// Keeps the end of the last step before the system is brought to others.
fn keep_present<const D: usize>(system: &System<D>, ends: &mut [End]) {
    for end in ends.iter_mut().filter(|end| matches!(end, End::Present)) {
        *end = End::Kept(system.snapshot());
    }
}

/// Part of its stiffness that a network has left where a singular point is near enough for a mesh to decide whether the path comes to it:
/// where one of two branches is left for the other, the paths of a coarse mesh and of a finer one may go on differently.
const HALVED: f64 = 0.5;

/// How the overall stiffness went along a path, and whether its increments had to be short.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Way {
    highest: f64,
    /// The lowest that was less than half of what was before.
    lowest: Option<f64>,
    dipped: bool,
    /// Whether an increment on the way was made again shorter.
    was_cut: bool,
}

impl Way {
    /// Goes on to a state with this stiffness.
    pub(super) fn go_on(&mut self, stiffness: f64) {
        if stiffness < HALVED * self.highest {
            self.lowest = Some(self.lowest.map_or(stiffness, |lowest| lowest.min(stiffness)));
        }
        self.dipped |= self.lowest.is_some_and(|lowest| lowest < HALVED * stiffness);
        self.highest = self.highest.max(stiffness);
    }

    /// An increment was made again shorter: beyond it stability would be lost, or the iteration was.
    pub(super) fn cut_short(&mut self) {
        self.was_cut = true;
    }

    /// Whether the path came so near to a singular point that a finer mesh may come to it, or may not.
    fn is_for_the_mesh(&self) -> bool {
        self.dipped || self.was_cut
    }
}

impl<const D: usize> Coarse<D> {
    /// Keeps what a solve on a finer mesh starts from, and gives back what is of no use to it before it needs memory of its own.
    pub(crate) fn shed(&mut self) {
        keep_present(&self.system, &mut self.ends);
        if let Some(refined) = &self.refined {
            keep_present(refined, &mut self.refined_ends);
        }
        for system in std::iter::once(&mut self.system).chain(&mut self.refined) {
            system.members.packs.iter_mut().for_each(|pack| pack.shed());
        }
    }
}

impl<'a, const D: usize> Continuation<'a, D> {
    /// Takes a solve on a coarser mesh with its steps, and from it what is the same on every mesh: the pattern of the equations, that there
    /// is no mechanism, and, nearly, the stiffness of the unloaded structure.
    pub(crate) fn follow_after(&mut self, coarse: Coarse<D>, steps: &'a [StepHistory]) {
        self.system.hold_like(&coarse.system);
        self.system.tangent.take_rest(&self.system.pattern, &coarse.system.tangent);
        self.system.hold(self.held.values().copied().collect());
        self.coarse = Some((coarse, steps));
    }

    /// Whether the end of a step is known from a coarser mesh.
    pub(super) fn is_known_from_coarse(&self, index: usize) -> bool {
        self.coarse.as_ref().is_some_and(|(coarse, _)| coarse.ends.get(index).is_some_and(End::is_fit))
    }

    /// What is known of the way of a step when it begins. Where the increments of a coarser mesh were cut short those of this one end where
    /// they did, and go by what cut them without a word.
    pub(super) fn way_on_this_mesh(&self, index: usize) -> Way {
        let was_cut = self.coarse.as_ref().is_some_and(|(coarse, _)| coarse.cut.get(index) == Some(&true));
        Way { was_cut, ..Way::default() }
    }

    /// Where increments on a coarser mesh ended on the way of a step, up to where they became short or a singular point is near: what
    /// was not to be passed at once there is not to be here.
    pub(super) fn landmarks_of_coarse(&self, index: usize) -> Vec<f64> {
        let Some((_, steps)) = &self.coarse else { return Vec::new() };
        let StepHistory { increments, critical_points, fraction, .. } = &steps[index];
        let first = critical_points.iter().map(|point| point.fraction).fold(*fraction, f64::min);
        let ends = increments.iter().map(|increment| increment.fraction);
        let begins = std::iter::once(0.0).chain(ends.clone());
        let near = self.tuning.near;
        let long = |&(begin, end): &(f64, f64)| end - begin > near && end + near < first;
        begins.zip(ends).take_while(long).map(|(_, end)| end).collect()
    }

    /// Goes to the end of a step by way of the coarser mesh; false where that is not possible, with nothing changed.
    pub(super) fn end_from_coarse(&mut self, run: &mut Run<'_>, index: usize, step: &Step) -> bool {
        let simple = step.method == Method::Newton && step.stop.is_none() && step.min_increments.is_none();
        let Some((coarse, steps)) = &mut self.coarse else { return false };
        let before: &'a StepHistory = &steps[index];
        let Some(End::Kept(end)) = coarse.ends.get(index).filter(|_| simple) else { return false };
        self.system.save(&mut self.last);
        match (&mut coarse.refined, coarse.refined_ends.get(index)) {
            (Some(refined), Some(End::Kept(end))) => {
                refined.restore(end);
                self.system.prolong(refined);
            }
            _ => {
                coarse.system.restore(end);
                self.system.prolong(&coarse.system);
            }
        }
        run.ramp.apply(&mut self.system, 1.0);
        self.system.place_ends();
        let known = before.negative_pivots;
        let start = Start { negative_limit: known, may_wander: false, ..Start::nearby() };
        let outcome = self.newton.solve(&mut self.system, start);
        // How far parts swing with what carries them says little: what counts is what they move by themselves.
        let near = |found: &Convergence| {
            found.iterations <= self.tuning.many && self.system.moves.first_own <= self.tuning.wrong()
        };
        let alike = outcome.as_ref().ok().copied().filter(near).and_then(|found| {
            let count = self.count(&found.inertia);
            (count.negative() == known).then_some((found, count))
        });
        let Some((found, count)) = alike else {
            self.system.restore(&self.last);
            run.ramp.apply(&mut self.system, 0.0);
            return false;
        };
        run.effort.count(&outcome);
        self.base = count;
        let way = before.increments.len().saturating_sub(1);
        run.record.increments.extend_from_slice(&before.increments[..way]);
        run.record.iterations += before.iterations;
        run.record.factorizations += before.factorizations;
        self.accept(run.record, 1.0, found.residual);
        (run.watch)(1.0);
        self.arrived(run)
    }

    /// What a solve on a finer mesh may start from.
    pub(crate) fn into_coarse(self) -> Coarse<D> {
        let Self { system, ends, cut, refined, refined_ends, .. } = self;
        Coarse { system, ends, cut, refined, refined_ends }
    }

    /// The refined end of a step, where a finer mesh may start from the end itself.
    pub(super) fn refined_end(&self, is_last: bool) -> End {
        match &self.refined {
            Some(refined) if self.ends.last().is_some_and(End::is_fit) => End::of(refined, is_last),
            _ => End::Unfit,
        }
    }

    /// Keeps the end of a step that a finer mesh may start from.
    pub(super) fn keep_end(&mut self, record: &StepHistory, is_last: bool) {
        if !self.keeps {
            return;
        }
        let plain = record.status == Status::Converged
            && record.critical_points.is_empty()
            && record.jumps.is_empty()
            && record.notes.is_empty()
            && !self.way.is_for_the_mesh();
        self.cut.push(self.way.was_cut);
        self.ends.push(if plain { End::of(&self.system, is_last) } else { End::Unfit });
    }
}
