//! A step whose end is known from a coarser mesh.
//!
//! Where a coarser mesh went without a singular point, the end of a step on a finer one lies next to it: a few
//! iterations lead there, and the way need not be gone again. If they do not, or if stability is another, it is.

use super::Path;
use super::follow::{Ramp, Tally};
use crate::history::{Status, StepHistory};
use crate::newton::{Aim, Start};
use crate::structure::{Method, Step};
use crate::system::{State, System};

/// Iterations that a state of a coarser mesh may need on a finer one.
const FEW: usize = 7;
/// A first increment larger than this (radians, or lengths of a member) leads elsewhere; how far parts swing with what
/// carries them says little.
const ASIDE: f64 = 0.2;

/// What a solve on a coarser mesh went through.
pub struct Guide<const D: usize> {
    /// The structure on the coarser mesh.
    pub system: System<D>,
    /// The states at the ends of steps, where a finer mesh may start from them.
    pub ends: Vec<Option<State>>,
    /// The same on elements of the next order, where there is one: it is much nearer.
    pub refined: Option<System<D>>,
    /// The same on the next order of elements.
    pub refined_ends: Vec<Option<State>>,
}

impl<const D: usize> Guide<D> {
    /// Gives back what is of no use to a solve on a finer mesh, before that needs memory of its own.
    pub fn shed(&mut self) {
        for system in std::iter::once(&mut self.system).chain(&mut self.refined) {
            system.packs.iter_mut().for_each(|pack| pack.shed());
        }
    }
}

impl<'a, const D: usize> Path<'a, D> {
    /// Takes a guide with its steps, and from it what is the same on every mesh: the pattern of the equations, that there
    /// is no mechanism, and, nearly, the stiffness of the unloaded structure.
    pub fn follow_after(&mut self, guide: Guide<D>, steps: &'a [StepHistory]) {
        self.system.hold_like(&guide.system);
        self.system.take_rest(&guide.system);
        self.system.hold(self.held.values().copied().collect());
        self.guide = Some((guide, steps));
    }

    /// Whether the end of a step is known from a guide.
    pub(super) fn is_guided(&self, index: usize) -> bool {
        self.guide.as_ref().is_some_and(|(guide, _)| guide.ends.get(index).is_some_and(Option::is_some))
    }

    /// Goes to the end of a step by way of the coarser mesh; false where that is not possible, with nothing changed.
    pub(super) fn guided(
        &mut self,
        index: usize,
        step: &Step,
        ramp: &Ramp,
        record: &mut StepHistory,
        watch: &mut dyn FnMut(f64) -> bool,
    ) -> bool {
        let simple = step.method == Method::Newton && step.stop.is_none() && step.min_increments.is_none();
        let Some((guide, steps)) = &mut self.guide else { return false };
        let before: &'a StepHistory = &steps[index];
        let Some(Some(end)) = guide.ends.get(index).filter(|_| simple) else { return false };
        self.system.save(&mut self.last);
        match (&mut guide.refined, guide.refined_ends.get(index)) {
            (Some(refined), Some(Some(end))) => {
                refined.restore(end);
                self.system.prolong(refined);
            }
            _ => {
                guide.system.restore(end);
                self.system.prolong(&guide.system);
            }
        }
        ramp.apply(&mut self.system, 1.0);
        self.system.place_ends();
        let known = before.negative_pivots;
        let start = Start { predicted: true, rest: None, negative_limit: known, aim: Aim::Result, may_wander: false };
        let mut tally = Tally { iterations: 0, factorizations: 0, accepted: 0 };
        let found = match self.newton.solve(&mut self.system, start) {
            Ok(found) if found.iterations <= FEW && self.system.own_first <= ASIDE => Some(found),
            _ => None,
        };
        let alike = found.and_then(|found| {
            let count = self.count(&found.inertia);
            (count.negative() == known).then_some((found, count))
        });
        let Some((found, count)) = alike else {
            self.system.restore(&self.last);
            ramp.apply(&mut self.system, 0.0);
            return false;
        };
        tally.iterations = found.iterations - 1;
        tally.factorizations = found.factorizations;
        self.base = count;
        let way = before.increments.len().saturating_sub(1);
        record.increments.extend_from_slice(&before.increments[..way]);
        record.iterations += before.iterations;
        record.factorizations += before.factorizations;
        self.accept(record, 1.0, &found, &tally);
        self.settle(record, 1.0, &tally);
        record.status = Status::Converged;
        watch(1.0);
        true
    }

    /// What a solve on a finer mesh may start from.
    pub fn into_guide(self) -> Guide<D> {
        let Self { system, ends, refined, refined_ends, .. } = self;
        Guide { system, ends, refined, refined_ends }
    }

    /// Keeps the refined end of a step, where the end itself was kept.
    pub(super) fn keep_refined(&mut self) -> Option<State> {
        self.ends.last()?.as_ref()?;
        self.refined.as_ref().map(System::snapshot)
    }

    /// Keeps the end of a step that a finer mesh may start from.
    pub(super) fn keep_end(&mut self, record: &StepHistory) {
        if !self.keeps {
            return;
        }
        let plain = record.status == Status::Converged
            && record.critical_points.is_empty()
            && record.jumps.is_empty()
            && record.notes.is_empty();
        self.ends.push(plain.then(|| self.system.snapshot()));
    }
}
