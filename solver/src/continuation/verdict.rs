//! Whether rounding hides if the end of a step is stable.

use super::Continuation;
use super::ramp::Ramp;
use crate::flutter;
use crate::history::{Growth, Note, Status, StepHistory};
use crate::newton::Start;
use crate::structure::Dimension;
use crate::system::Spins;

impl<const D: usize> Continuation<'_, D> {
    /// Takes back the verdict on the end of a step where rounding hides the sign of the lowest stiffness.
    ///
    /// A motion that needs no force at all (a buckled round strut turns freely about its axis) has no sign to hide, neither
    /// at the end nor a little before: it counts as neither, and takes no part in the verdict. The stiffness that a load is about to
    /// take away is there a little before, by that part of what the load takes in all.
    pub(super) fn judge_end(&mut self, ramp: &Ramp, record: &mut StepHistory) {
        let before = std::mem::take(&mut self.undecided);
        if !self.base.potential && record.status == Status::Converged {
            return self.judge_vibration(record);
        }
        // What ends at a singular point is said to: its verdict is that of the states that led there.
        let singular = matches!(record.status, Status::LimitPoint | Status::Bifurcation);
        if record.increments.is_empty() || record.stable != Some(true) || singular {
            return;
        }
        let end = record.fraction;
        if record.status != Status::Converged {
            ramp.apply(&mut self.system, end);
            self.system.assemble(false);
        }
        let hidden = self.hidden_signs(record.stability);
        if hidden == 0 {
            return;
        }
        let here = self.system.snapshot();
        ramp.apply(&mut self.system, end - self.tuning.beside());
        let found = self.newton.solve(&mut self.system, Start::nearby()).is_ok();
        let free = if found { self.hidden_signs(record.stability) } else { 0 };
        self.system.restore(&here);
        ramp.apply(&mut self.system, end);
        self.system.assemble(false);
        if hidden > free || before || self.system.may_hide_bending() {
            self.undecided = true;
            record.stable = None;
            record.notes.retain(|note| *note != Note::TouchedSingular { fraction: end });
            record.notes.push(Note::WithinRounding);
        }
    }

    /// Judges the end of a step whose loads have no potential by how small vibrations go on about it, where masses are known.
    fn judge_vibration(&mut self, record: &mut StepHistory) {
        if !flutter::may_judge(&self.system) {
            return;
        }
        record.vibration = self.judges.and_then(|judges| (judges.vibration)(&self.system, record.stability));
        record.stable = record.vibration.map(|vibration| vibration.growth == Growth::None);
        if record.vibration.is_none() {
            record.notes.push(Note::VibrationsUnknown);
        }
    }

    /// Takes back the verdict on the end of a step where bars would turn about themselves, had they not been kept from it.
    pub(super) fn judge_spins(&mut self, record: &mut StepHistory) {
        let Some(judges) = self.judges else { return };
        let may_judge = self.base.potential && record.stable == Some(true) && record.status == Status::Converged;
        if !may_judge || self.options.rough || record.increments.is_empty() || !self.system.may_spin() {
            return;
        }
        // What is held by nothing is no equilibrium, and has no stability either.
        if !self.system.untaken().bars.is_empty() {
            record.stable = None;
            return;
        }
        match (judges.spins)(&self.system, record.stability) {
            None => {
                record.stable = None;
                record.notes.push(Note::SpinsUnknown);
            }
            Some(Spins { motions: 0, .. }) => {}
            Some(Spins { motions, members }) => {
                record.stable = Some(false);
                record.negative_pivots += motions;
                record.notes.push(Note::WouldTurn { members });
            }
        }
    }

    /// Motions of which rounding hides the sign of the stiffness at the last assembly.
    fn hidden_signs(&mut self, space: Dimension) -> usize {
        let own = self.system.hidden_signs();
        match &mut self.lateral {
            Some(lateral) if space == Dimension::Space => own.max(lateral.hidden_signs(&mut self.system)),
            _ => own,
        }
    }
}
