//! What a step's history says: states, singular points, and why it stopped.

use super::Continuation;
use super::follow::Run;
use crate::compliance;
use crate::held;
use crate::history::{Cause, CriticalKind, CriticalPoint, Failure, Increment, Note, Status, StepHistory};
use crate::newton::{Lost, Why};
use crate::results;
use crate::rounding::{self, Estimate};
use crate::structure::{Dimension, NodeId};
use crate::system::{Residual, Untaken};
use pennate_elements::small::norm;

impl StepHistory {
    /// Says of singular points that they lie behind the increments that there are by now.
    pub(super) fn place(&self, points: &mut [CriticalPoint]) {
        points.iter_mut().for_each(|point| point.increments_before = self.increments.len());
    }
}

impl<const D: usize> Continuation<'_, D> {
    /// What a step ends with at a loss of stability that could not be located.
    pub(super) fn ending_at_loss(&mut self, [from, target]: [f64; 2], sideways: bool, behind: bool) -> Ending {
        let jumped = self.system.jumped(&self.last, behind.then_some(&self.before), &self.tuning);
        let kind = if jumped { CriticalKind::LimitPoint } else { CriticalKind::Bifurcation };
        let point = self.rough_point(kind, (Some(from), target), sideways);
        let residual = self.system.residual();
        let failure = Failure {
            tried: target,
            worst_node: Some(point.node),
            worst_component: residual.worst_component,
            worst_residual: residual.largest(),
            cause: cause_of(kind, sideways),
        };
        Ending { status: status_of(kind), point: Some(point), failure, loses: false }
    }

    /// What a step ends with where no equilibrium was found at the fraction `target`; `from` is where the last one was.
    pub(super) fn ending_of(&mut self, [from, target]: [f64; 2], lost: &Lost, fold: bool) -> Ending {
        let node = self.system.topology.references.get(lost.residual.worst_joint).copied();
        let fold = fold && !matches!(lost.why, Why::Overheld(_));
        let cause = match lost.why {
            _ if fold => Cause::LimitPoint,
            Why::Overheld(member) => Cause::Overheld { member },
            Why::Singular => Cause::IllConditioned,
            Why::Away => Cause::LeadsAway,
            Why::Long => Cause::Endless,
            _ => Cause::StepTooSmall,
        };
        let status = if fold { Status::LimitPoint } else { Status::NotConverged };
        let point = fold.then(|| self.rough_point(CriticalKind::LimitPoint, (Some(from), target), false));
        let failure = Failure {
            tried: target,
            worst_node: node,
            worst_component: lost.residual.worst_component,
            worst_residual: lost.residual.largest(),
            cause,
        };
        Ending { status, point, failure, loses: false }
    }

    /// Notes the members that cannot be stretched and whose axial force nothing determines at the end of a step.
    pub(super) fn note_undetermined(&mut self, record: &mut StepHistory) {
        if record.increments.is_empty() || !self.system.loading.holds_strains() {
            return;
        }
        let members = held::undetermined(&mut self.system);
        if !members.is_empty() {
            record.notes.push(Note::Undetermined { members });
        }
    }

    /// Notes the members that would turn about themselves at the end of a step, had an end not been kept from it, nodes that are kept
    /// from turning by what no force should belong to, and parts that nothing resists turning about their line.
    pub(super) fn note_turned(&mut self, record: &mut StepHistory) {
        if record.increments.is_empty() {
            return;
        }
        let Untaken { bars: members, nodes } = self.system.untaken();
        if !members.is_empty() {
            record.notes.push(Note::TurnedAboutItself { members });
        }
        if !nodes.is_empty() {
            // What is not in balance is no equilibrium, and has no stability either.
            record.stable = None;
            record.notes.push(Note::Untaken { nodes });
        }
        for part in self.system.turning.iter().filter(|part| self.system.has_left(part)) {
            record.notes.push(Note::TurnsFreely { axis: part.axis, nodes: part.nodes.clone() });
        }
    }

    /// A singular point near the last assembly, as far as an increment tells: it lies since the first of these fractions, where
    /// one is known, and is said to lie at the second.
    pub(super) fn rough_point(
        &mut self,
        kind: CriticalKind,
        (since, fraction): (Option<f64>, f64),
        sideways: bool,
    ) -> CriticalPoint {
        let mode = self.system.tangent.softest_motion(&self.system.pattern, self.system.size);
        let motions = self.system.pattern.motions_of(&mode);
        let (node, mode) = self.mode_of(&motions);
        // Where rounding hides the sign of a stiffness at the near end already, and that may bend a member, it may be lost before.
        let is_hidden = self.base.neutral && self.system.may_hide_bending();
        let hidden = if is_hidden { self.tuning.bracket * fraction.abs() } else { 0.0 };
        let located = since.map(|since| (fraction - since).abs().max(hidden));
        let middles = Vec::new();
        CriticalPoint {
            kind,
            fraction,
            in_prestress: false,
            increments_before: 0,
            error: None,
            located,
            node,
            member: None,
            sideways,
            mode,
            middles,
        }
    }

    /// The node that moves most, and the motion of every node.
    pub(super) fn mode_of(&self, motions: &[[f64; 6]]) -> (NodeId, Vec<[f64; 6]>) {
        let system = &self.system;
        let mode: Vec<[f64; 6]> =
            system.topology.links.iter().map(|link| system.places.motion_of(link, motions)).collect();
        let moves = |m: &[f64; 6]| (norm([m[0], m[1], m[2]]) / system.size).max(1e-3 * norm([m[3], m[4], m[5]]));
        let mut best = (0, 0.0);
        for (node, motion) in mode.iter().enumerate() {
            if moves(motion) > best.1 * (1.0 + 1e-6) {
                best = (node, moves(motion));
            }
        }
        (best.0, mode)
    }

    /// Ends a step at the state it is in.
    pub(super) fn settle(&mut self, run: &mut Run<'_>, fraction: f64) {
        run.record.iterations += run.effort.iterations;
        run.record.factorizations += run.effort.factorizations;
        run.record.fraction = fraction;
    }

    /// Records an accepted increment.
    pub(super) fn accept(&mut self, record: &mut StepHistory, fraction: f64, residual: Residual) {
        // What is only gone on from is not worth it.
        let (estimate, polished) = if self.options.rough { (None, false) } else { self.polish(record, fraction) };
        let mut state = results::equilibrium(&mut self.system);
        if !polished {
            state.residual = residual.largest();
        }
        state.rounding = estimate.map(|estimate| estimate.rounding);
        state.compliances = compliance::of_nodes(&mut self.system);
        if self.options.estimate {
            record.variations = self.variations();
        }
        let shapes = if self.options.shapes { results::shapes(&self.system) } else { Vec::new() };
        record.increments.push(Increment { fraction, state, shapes });
        record.negative_pivots = self.base.negative();
        record.stable = self.base.potential.then_some(record.negative_pivots == 0);
        // A dead moment about z has a potential for rotations in the plane and none out of it.
        let in_plane = self.base.potential && !self.base.lateral_potential;
        record.stability = if in_plane { Dimension::Plane } else { self.stability };
    }
}

impl<const D: usize> Continuation<'_, D> {
    /// Estimates rounding at an accepted state; at the end of a step, iterates on where it is not what limits the digits.
    ///
    /// An increment is small against the network long before it is small against its motion, where that is small itself
    /// and still nonlinear: bars that are nearly in one line.
    fn polish(&mut self, record: &mut StepHistory, fraction: f64) -> (Option<Estimate>, bool) {
        const MOST: usize = 4;
        let mut best = rounding::estimate(&mut self.system);
        let mut polished = false;
        let pending = self.system.pattern.equations.has_general();
        for _ in 0..MOST {
            let Some(before) = best.filter(|best| fraction >= 1.0 && !best.settled && best.left < self.tuning.shortest)
            else {
                break;
            };
            let here = self.system.snapshot();
            self.system.assemble(pending);
            self.system.advance(pending);
            self.system.assemble(pending);
            record.iterations += 1;
            record.factorizations += 2;
            let after = rounding::estimate(&mut self.system).filter(|after| after.left < 0.5 * before.left);
            if after.is_none() {
                self.system.restore(&here);
                self.system.assemble(pending);
                record.factorizations += 1;
                break;
            }
            best = after;
            polished = true;
        }
        (best, polished)
    }
}

/// How a step ends for want of anything better.
pub(super) struct Ending {
    pub status: Status,
    pub point: Option<CriticalPoint>,
    pub failure: Failure,
    /// Whether stability was seen to be lost.
    pub loses: bool,
}

pub(super) fn status_of(kind: CriticalKind) -> Status {
    match kind {
        CriticalKind::LimitPoint => Status::LimitPoint,
        CriticalKind::Bifurcation => Status::Bifurcation,
    }
}

pub(super) fn cause_of(kind: CriticalKind, sideways: bool) -> Cause {
    match (kind, sideways) {
        (CriticalKind::LimitPoint, _) => Cause::LimitPoint,
        (CriticalKind::Bifurcation, false) => Cause::Bifurcation,
        (CriticalKind::Bifurcation, true) => Cause::SidewaysBifurcation,
    }
}
