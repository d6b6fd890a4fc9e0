//! How near a derivative is known, and what is said where that is less than is promised.

use pennate_models::probes::ProbeKind;
use pennate_solver::history::{Equilibrium, NodeState};

use super::nearby::size;
use super::slopes::{Slopes, Stage};
use super::{Output, Reason};
use crate::solution;

/// By how much a derivative may be wrong, over the largest of its probe, without a word.
pub(super) const WITHIN: f64 = 1e-7;
/// By how much it may be wrong and still be a number: four digits lead an optimization on.
pub(super) const OF_USE: f64 = 1e-4;
/// A probe whose derivatives are less than this part of what is greatest of its kind is measured by that.
const FIXED: f64 = 1e-3;

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

impl Slopes<'_> {
    /// What derivatives of a quantity are measured by, each times its parameter: the largest of them, or a part of what is greatest of
    /// its kind where statics or symmetry fixes it.
    pub(super) fn measure(&self, found: &[Estimate], floor: f64) -> f64 {
        let sizes = found.iter().zip(self.row).map(|(found, &value)| found.slope.abs() * size(value));
        sizes.filter(|size| size.is_finite()).fold(floor, f64::max)
    }

    /// What derivatives of a quantity are measured by at least, each over the whole of a parameter.
    pub(super) fn floor(&self, stage: Stage, greatest: &Greatest, quantity: usize) -> f64 {
        let probes = &self.design.model.probes;
        let kind = (quantity < probes.len()).then(|| probes.kind(quantity));
        let value = self.values_at(stage).get(quantity).copied().unwrap_or(0.0);
        FIXED * greatest.like(kind, value)
    }

    /// Notes what may be wrong by more than is promised of an output, or of a component that the next step keeps. Puts no number where one
    /// would be of no use, with the reason.
    pub(super) fn note_inexact(
        &mut self,
        (stage, state): (Stage, &Equilibrium),
        found: &mut [Estimate],
    ) -> Option<Reason> {
        let (greatest, mut reason) = (Greatest::of(state), None);
        let (probes, index) = (self.design.model.probes.len(), stage.step());
        for (quantity, found) in found.chunks_exact_mut(self.row.len().max(1)).enumerate() {
            let is_output = |output: &Output| output.probe == quantity && stage == Stage::End(output.step);
            let is_probe = quantity < probes;
            if is_probe && !self.problem.outputs.iter().any(is_output) {
                continue;
            }
            let floor = if is_probe { self.floors[index][quantity] } else { self.floor(stage, &greatest, quantity) };
            let measure = self.measure(found, floor);
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
        Reason::Inexact { output: self.output_of(index, quantity), error }
    }
}
