//! What a solve brought: the history, the probes evaluated in it, and the error of the discretization.

use std::time::Duration;

use nalgebra::{UnitQuaternion, Vector3};
use pennate_models::model::{Member, MemberId};
use pennate_models::{Mesh, Model};
use pennate_solver::history::{Equilibrium, History, MemberState, NodeState, SectionForces, Status, StepHistory};
use pennate_solver::structure::Dimension;

use crate::accuracy::Accuracy;

/// A solved network, ready to be written.
#[derive(Debug)]
pub struct Solution {
    /// The network.
    pub model: Model,
    /// The mesh whose states these are.
    pub mesh: Mesh,
    /// The equilibria of all increments of all steps.
    pub history: History,
    /// The probes in them.
    pub probes: ProbeTable,
    /// The error of the mesh at the nodes where every step ends; none of a step that was not estimated.
    pub errors: Vec<Vec<NodeError>>,
    /// The error of the mesh, asked for and estimated.
    pub accuracy: Accuracy,
    /// What it took.
    pub timing: Timing,
}

/// Time of the parts of a run, by the clock that its caller gave ([`pennate_solver::options::Options::clock`]).
#[derive(Clone, Copy, Debug, Default)]
pub struct Timing {
    /// Reading the network; filled in by who reads it.
    pub read: Duration,
    /// Dividing members into elements.
    pub mesh: Duration,
    /// Finding equilibria, on all meshes.
    pub solve: Duration,
    /// Estimating the error of the mesh.
    pub estimate: Duration,
    /// Writing results; filled in by who writes them.
    pub write: Duration,
}

impl Solution {
    /// Status of the run: that of the first step that did not converge.
    pub fn status(&self) -> Status {
        let failed = self.history.steps.iter().map(|step| step.status).find(|&status| status != Status::Converged);
        failed.unwrap_or(Status::Converged)
    }

    /// Steps with their names, in order.
    pub fn steps(&self) -> impl Iterator<Item = (&str, &StepHistory)> {
        self.model.step_names().into_iter().zip(&self.history.steps)
    }

    /// Value of a probe at the end of a step, in the model's units, angles in degrees; `None` where there is no probe or
    /// step of that name, or no equilibrium in the step.
    pub fn probe(&self, name: &str, step: &str) -> Option<f64> {
        let probe = self.model.probes.names.iter().position(|known| known == name)?;
        let step = self.model.step_names().into_iter().position(|known| known == step)?;
        self.probes.steps.get(step)?.last()?.get(probe).copied()
    }
}

/// Words for a status, as written in results.
pub fn status_name(status: Status) -> &'static str {
    match status {
        Status::Converged => "converged",
        Status::LimitPoint => "limit_point",
        Status::Bifurcation => "bifurcation",
        Status::NotConverged => "not_converged",
        Status::Interrupted => "interrupted",
        Status::NotReached => "not_reached",
    }
}

/// The state before anything acts, prestress included: nothing has moved, nothing is stressed.
pub fn unloaded(model: &Model) -> Equilibrium {
    let member = |member: &Member| MemberState { length: member.length, ..MemberState::default() };
    let along = |member: MemberId| {
        let last = model.members[member].segments.len() - 1;
        let at = |at: f64, segment: usize| SectionForces { at, segment, ..SectionForces::default() };
        vec![at(0.0, 0), at(1.0, last)]
    };
    Equilibrium {
        nodes: vec![NodeState::default(); model.nodes.len()],
        members: model.members.iter().map(member).collect(),
        springs: vec![0.0; model.springs.len()],
        sections: model.probes.sections().into_iter().map(along).collect(),
        ..Equilibrium::default()
    }
}

/// The last equilibrium of a step, where it has one.
pub fn last_state(step: &StepHistory) -> Option<&Equilibrium> {
    step.increments.last().map(|increment| &increment.state)
}

/// Whether the ends of all steps that got somewhere are stable; `None` where loads have no potential.
pub fn stable(history: &History) -> Option<bool> {
    let ends = history.steps.iter().filter(|step| !step.increments.is_empty());
    all_stable(&ends.map(|step| step.stable).collect::<Vec<_>>())
}

/// Whether all of some states are stable; `None` where there is none, or one of them is not known to be stable or unstable.
pub(crate) fn all_stable(verdicts: &[Option<bool>]) -> Option<bool> {
    if verdicts.contains(&Some(false)) {
        return Some(false);
    }
    (!verdicts.is_empty() && verdicts.iter().all(Option::is_some)).then_some(true)
}

/// Where rounding leaves the fewest digits of a run: the step, the kind (displacements, rotations, forces, moments) and
/// the digits.
///
/// Steps that end at a singular point are left out: how few digits there are next to it is a matter of how near.
pub fn fewest_digits(history: &History) -> Option<(usize, usize, f64)> {
    let done = history.steps.iter().enumerate().filter(|(_, step)| step.status == Status::Converged);
    let ends = done.filter_map(|(index, step)| Some((index, last_state(step)?.rounding?)));
    let fewest = ends.filter_map(|(index, rounding)| rounding.worst().map(|(kind, digits)| (index, kind, digits)));
    fewest.min_by(|a, b| a.2.total_cmp(&b.2))
}

/// Digits that can be relied on.
pub fn whole_digits(digits: f64) -> u32 {
    // What is below one digit is none.
    digits.max(0.0).floor() as u32
}

/// Values of all probes: at every increment of every step, and at the end of the step on the refined mesh.
#[derive(Clone, Debug, Default)]
pub struct ProbeTable {
    /// One entry a step.
    pub steps: Vec<ProbeSteps>,
}

/// Values of the probes during one step, each list in the order of the probes.
#[derive(Clone, Debug, Default)]
pub struct ProbeSteps {
    /// One list an increment.
    pub increments: Vec<Vec<f64>>,
    /// At the end of the step on the refined mesh, where it was solved there.
    pub refined: Option<Vec<f64>>,
    /// The least errors that are stated; empty before the others are known.
    pub least: Vec<f64>,
}

impl ProbeTable {
    /// Evaluates the probes in all equilibria of a history.
    pub fn new(model: &Model, history: &History) -> Self {
        let (mut after, mut refined_after) = (Vec::new(), Vec::new());
        let mut steps = Vec::with_capacity(history.steps.len());
        for step in &history.steps {
            let increments: Vec<Vec<f64>> =
                step.increments.iter().map(|each| model.probes.evaluate(&each.state, &after)).collect();
            let refined = step.refined.as_ref().map(|state| model.probes.evaluate(state, &refined_after));
            if let Some(last) = increments.last() {
                refined_after.push(refined.clone().unwrap_or_else(|| last.clone()));
                after.push(last.clone());
            }
            steps.push(ProbeSteps { increments, refined, least: Vec::new() });
        }
        Self { steps }
    }
}

impl ProbeSteps {
    /// Values at the end of the step.
    pub fn last(&self) -> Option<&[f64]> {
        self.increments.last().map(Vec::as_slice)
    }

    /// Discretization error of every probe at the end of the step, where it was estimated.
    pub fn errors(&self) -> Option<Vec<f64>> {
        let (last, refined) = (self.last()?, self.refined.as_ref()?);
        let least = self.least.iter().copied().chain(std::iter::repeat(0.0));
        Some(
            last.iter()
                .zip(refined)
                .zip(least)
                .map(|((value, better), least)| least.max((value - better).abs()))
                .collect(),
        )
    }
}

/// Discretization error of a node: norms of what its vectors are wrong by, in the model's units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NodeError {
    /// Length.
    pub displacement: f64,
    /// Radians.
    pub rotation: f64,
    /// Force.
    pub reaction_force: f64,
    /// Moment.
    pub reaction_moment: f64,
}

impl NodeError {
    /// The distance of a node's state to the one on the refined mesh.
    pub fn between(state: &NodeState, refined: &NodeState, dimension: Dimension) -> Self {
        let rotation = match dimension {
            Dimension::Plane => (state.rotation_total - refined.rotation_total).abs(),
            Dimension::Space => angle_between(state.rotation, refined.rotation),
        };
        Self {
            displacement: distance(state.displacement, refined.displacement),
            rotation,
            reaction_force: distance(state.reaction_force, refined.reaction_force),
            reaction_moment: distance(state.reaction_moment, refined.reaction_moment),
        }
    }
}

/// Euclidean distance.
pub fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (Vector3::from(a) - Vector3::from(b)).norm()
}

/// Euclidean norm.
pub fn norm(a: [f64; 3]) -> f64 {
    Vector3::from(a).norm()
}

/// The largest force anywhere in a state: of supports, members and springs.
pub fn largest_force(state: &Equilibrium) -> f64 {
    let reactions = state.nodes.iter().map(|node| norm(node.reaction_force));
    let members = state.members.iter().flat_map(|member| member.end_forces).map(norm);
    reactions.chain(members).chain(state.springs.iter().map(|force| force.abs())).fold(0.0, f64::max)
}

/// Largest moment on a node or at the end of a member in a state.
pub(crate) fn largest_moment(state: &Equilibrium) -> f64 {
    let reactions = state.nodes.iter().map(|node| norm(node.reaction_moment));
    let members = state.members.iter().flat_map(|member| member.end_moments).map(norm);
    reactions.chain(members).fold(0.0, f64::max)
}

/// Diagonal of the box around some points.
pub fn diagonal(points: impl Iterator<Item = [f64; 3]>) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in points {
        for axis in 0..3 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    if low[0] <= high[0] { distance(low, high) } else { 0.0 }
}

/// The angle by which two rotations, given as rotation vectors, differ.
fn angle_between(a: [f64; 3], b: [f64; 3]) -> f64 {
    let rotation = |vector: [f64; 3]| UnitQuaternion::from_scaled_axis(Vector3::from(vector));
    (rotation(a).inverse() * rotation(b)).angle()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Half a turn forwards and half a turn backwards are one and the same.
    #[test]
    fn rotations_on_both_sides_of_half_a_turn_are_near_to_each_other() {
        let angle = angle_between([0.0, 0.0, PI - 1e-9], [0.0, 0.0, -PI + 1e-9]);
        assert!((angle - 2e-9).abs() < 1e-15, "{angle}");
    }
}
