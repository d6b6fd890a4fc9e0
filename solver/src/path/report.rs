//! What a step's history says: states, singular points, and why it stopped.

use super::follow::{BEFORE, LAST, Tally};
use super::{Count, Path};
use crate::history::{Cause, CriticalKind, CriticalPoint, Failure, Increment, Note, Status, StepHistory};
use crate::newton::{Convergence, Lost, Why};
use crate::results;
use crate::structure::{Dimension, NodeId};

impl<const D: usize> Path<'_, D> {
    /// Singular points that the accepted increment has passed.
    pub(super) fn note_changes(&mut self, record: &mut StepHistory, count: &Count, fraction: f64) {
        let fell = count.own < self.base.own || count.lateral < self.base.lateral;
        let conservative = count.potential && self.base.potential;
        let flipped = !conservative && count.odd != self.base.odd && self.base.potential == count.potential;
        if (fell && conservative) || flipped {
            let node = self.mode_node();
            let sideways = count.own == self.base.own;
            record.critical_points.push(CriticalPoint { kind: CriticalKind::Bifurcation, fraction, node, sideways });
        }
        if count.neutral && !self.base.neutral {
            record.notes.push(Note::TouchedSingular { fraction });
        }
    }

    pub(super) fn stop_at_critical(&mut self, record: &mut StepHistory, target: f64, sideways: bool) {
        let jumped = self.system.jumped(LAST, BEFORE, record.increments.len() > 1);
        let kind = if jumped { CriticalKind::LimitPoint } else { CriticalKind::Bifurcation };
        let node = self.mode_node();
        record.critical_points.push(CriticalPoint { kind, fraction: target, node, sideways });
        record.status = match kind {
            CriticalKind::LimitPoint => Status::LimitPoint,
            CriticalKind::Bifurcation => Status::Bifurcation,
        };
        let residual = self.system.residual();
        record.failure = Some(Failure {
            tried: target,
            worst_node: Some(node),
            worst_component: residual.worst_component,
            worst_residual: residual.largest(),
            cause: match (kind, sideways) {
                (CriticalKind::LimitPoint, _) => Cause::LimitPoint,
                (CriticalKind::Bifurcation, false) => Cause::Bifurcation,
                (CriticalKind::Bifurcation, true) => Cause::SidewaysBifurcation,
            },
        });
    }

    pub(super) fn give_up(&mut self, record: &mut StepHistory, target: f64, lost: &Lost, fold: bool) {
        let node = self.system.topology.references.get(lost.residual.worst_joint).copied();
        let cause = if fold {
            Cause::LimitPoint
        } else if lost.why == Why::Singular {
            Cause::IllConditioned
        } else {
            Cause::StepTooSmall
        };
        record.status = if fold { Status::LimitPoint } else { Status::NotConverged };
        if fold {
            let node = self.mode_node();
            let kind = CriticalKind::LimitPoint;
            record.critical_points.push(CriticalPoint { kind, fraction: target, node, sideways: false });
        }
        record.failure = Some(Failure {
            tried: target,
            worst_node: node,
            worst_component: lost.residual.worst_component,
            worst_residual: lost.residual.largest(),
            cause,
        });
    }

    fn mode_node(&mut self) -> NodeId {
        let joint = self.system.softest_joint();
        self.system.topology.references.get(joint).copied().unwrap_or(0)
    }

    /// Ends a step at the state it is in.
    pub(super) fn settle(&mut self, record: &mut StepHistory, fraction: f64, tally: &Tally) {
        record.iterations += tally.iterations;
        record.factorizations += tally.factorizations;
        record.fraction = fraction;
    }

    /// Records an accepted increment.
    pub(super) fn accept(&mut self, record: &mut StepHistory, fraction: f64, found: &Convergence, _tally: &Tally) {
        let mut state = results::equilibrium(&mut self.system);
        state.residual = found.residual.largest();
        let shapes = if self.options.shapes { results::shapes(&self.system) } else { Vec::new() };
        record.increments.push(Increment { fraction, state, shapes });
        record.negative_pivots = self.base.own + self.base.lateral;
        let potential = self.base.potential && self.base.lateral_potential;
        record.stable = potential.then_some(record.negative_pivots == 0);
        record.stability = self.stability;
    }
}

pub(super) fn empty_step(stability: Dimension, notes: Vec<Note>) -> StepHistory {
    StepHistory {
        status: Status::NotConverged,
        fraction: 0.0,
        iterations: 0,
        factorizations: 0,
        increments: Vec::new(),
        refined: None,
        stable: None,
        stability,
        negative_pivots: 0,
        critical_points: Vec::new(),
        notes,
        failure: None,
    }
}
