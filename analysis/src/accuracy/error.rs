//! The discretization error of a run: what its probes, or all of its nodes, differ by from those on elements of the next order.

use pennate_models::Model;
use pennate_models::probes::ProbeKind;
use pennate_solver::history::{Equilibrium, History, NodeState, StepHistory};
use pennate_solver::packs::AUXILIARY;
use pennate_solver::structure::{Dimension, Segment, Structure};

use crate::solution::{NodeError, ProbeSteps, ProbeTable, diagonal, largest_force, largest_moment, last_state, norm};

/// Part of what the network's size or forces suggest below which values are rounding alone.
const ROUNDING: f64 = 1e-9;
/// The same for forces against the axial stiffness of the members.
const FORCE_ROUNDING: f64 = 1e-13;
/// The same against the auxiliary stiffness of stretches that are held.
const HELD_ROUNDING: f64 = 1e-14;
/// Rotations below this part of displacement over size are what is left of a symmetry.
const TURN_ROUNDING: f64 = 1e-6;
/// Part of the network's size or forces below which an error is nothing.
const FLOOR: f64 = 1e-15;
/// Part of the largest error of a step below which the error of a probe is not believed.
const BY_CHANCE: f64 = 0.05;
/// Moments count as no smaller than this part of force times network size.
const MOMENT_FLOOR: f64 = 1e-3;

/// The largest error of a run over the largest value of its kind; `None` where no step was estimated.
pub(super) fn relative_error(
    model: &Model,
    structure: &Structure,
    history: &History,
    probes: &ProbeTable,
) -> Option<f64> {
    history.steps.iter().find(|step| step.refined.is_some())?;
    let kinds = match (0..model.probes.len()).all(|probe| !model.probes.kind(probe).is_asked()) {
        true => kinds_of_nodes(model.dimension, &history.steps),
        false => kinds_of_probes(model, &probes.steps),
    };
    let noise = Noise::of(structure, history);
    let ratios = kinds.ratios(&noise);
    Some(ratios.into_iter().flatten().fold(0.0, f64::max))
}

/// What is stated of the nodes, step by step, and sets the least error that is stated of every probe: what two meshes differ by may
/// vanish by chance. Of nodes, which are many, no less than a part of the largest error of the kind is stated, of probes no less than
/// that of the largest of any kind.
pub(super) fn state_errors(
    model: &Model,
    structure: &Structure,
    history: &History,
    probes: &mut ProbeTable,
) -> Vec<Vec<NodeError>> {
    if history.steps.iter().all(|step| step.refined.is_none()) {
        return vec![Vec::new(); history.steps.len()];
    }
    let noise = Noise::of(structure, history);
    let kinds = |steps: &[StepHistory], probes: &[ProbeSteps]| {
        kinds_of_nodes(model.dimension, steps).joined(kinds_of_probes(model, probes))
    };
    let run = kinds(&history.steps, &probes.steps);
    let state = |(step, probes): (&StepHistory, &mut ProbeSteps)| {
        let own = kinds(std::slice::from_ref(step), std::slice::from_ref(probes));
        let largest = run.with_errors_of(own).ratios(&noise).into_iter().flatten().fold(0.0, f64::max);
        let of_probe = |(index, value): (usize, &f64)| {
            let size = probes.increments.iter().map(|values| values[index].abs()).fold(0.0, f64::max);
            let scale = match model.probes.kind(index) {
                ProbeKind::Displacement => run.displacement.value,
                ProbeKind::Rotation => run.rotation.value.to_degrees(),
                ProbeKind::Force => run.force.value,
                ProbeKind::Moment => run.moment.value,
                ProbeKind::GreatestMoment | ProbeKind::Stress | ProbeKind::Strain | ProbeKind::Other => value.abs(),
            };
            // What is zero by symmetry or by statics is so on every mesh.
            if size > ROUNDING * scale { BY_CHANCE * largest * scale } else { 0.0 }
        };
        probes.least = probes.last().unwrap_or_default().iter().enumerate().map(of_probe).collect();
        let (Some(last), Some(refined)) = (last_state(step), &step.refined) else { return Vec::new() };
        let kinds = kinds_of_nodes(model.dimension, std::slice::from_ref(step));
        let of_node = |(node, better): (&NodeState, &NodeState)| {
            let turn = norm(node.rotation).max(node.rotation_total.abs());
            let error = NodeError::between(node, better, model.dimension);
            NodeError {
                displacement: kinds.displacement.stated(error.displacement, norm(node.displacement)),
                rotation: kinds.rotation.stated(error.rotation, turn),
                reaction_force: kinds.force.stated(error.reaction_force, norm(node.reaction_force)),
                reaction_moment: kinds.moment.stated(error.reaction_moment, norm(node.reaction_moment)),
            }
        };
        last.nodes.iter().zip(&refined.nodes).map(of_node).collect()
    };
    history.steps.iter().zip(&mut probes.steps).map(state).collect()
}

/// Largest value and largest error of one kind of quantity.
#[derive(Clone, Copy, Debug, Default)]
struct Kind {
    value: f64,
    error: f64,
}

impl Kind {
    fn take(&mut self, value: f64, error: Option<f64>) {
        // A value that is not a number, such as a probe of a later step, is no evidence.
        self.value = self.value.max(value.abs());
        self.error = self.error.max(error.unwrap_or(0.0));
    }

    /// What is stated of a value of this kind where it differs by `error` on the other mesh: what is zero by symmetry or by statics, or
    /// prescribed, is so on every mesh.
    fn stated(self, error: f64, value: f64) -> f64 {
        let by_chance = value > ROUNDING * self.value && error > FLOOR * self.value;
        if by_chance { error.max(BY_CHANCE * self.error) } else { error }
    }

    /// Error over value; `None` for a kind that is rounding alone.
    fn ratio(self, rounding: f64, floor: f64) -> Option<f64> {
        (self.value > rounding).then(|| if self.error <= floor { 0.0 } else { self.error / self.value })
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Kinds {
    displacement: Kind,
    rotation: Kind,
    force: Kind,
    moment: Kind,
}

impl Kinds {
    fn pairs(self, other: Self, join: fn(Kind, Kind) -> Kind) -> Self {
        Self {
            displacement: join(self.displacement, other.displacement),
            rotation: join(self.rotation, other.rotation),
            force: join(self.force, other.force),
            moment: join(self.moment, other.moment),
        }
    }

    fn joined(self, other: Self) -> Self {
        self.pairs(other, |a, b| Kind { value: a.value.max(b.value), error: a.error.max(b.error) })
    }

    fn with_errors_of(self, other: Self) -> Self {
        self.pairs(other, |a, b| Kind { error: b.error, ..a })
    }

    fn ratios(mut self, noise: &Noise) -> [Option<f64>; 4] {
        let force = if self.force.value > 0.0 { self.force.value } else { noise.largest_force };
        let moment_rounding = noise.force * noise.size;
        if self.moment.value > moment_rounding {
            self.moment.value = self.moment.value.max(MOMENT_FLOOR * force * noise.size);
        }
        let floor = FLOOR * noise.largest_force;
        [
            self.displacement.ratio(ROUNDING * noise.size, FLOOR * noise.size),
            self.rotation.ratio(ROUNDING.max(TURN_ROUNDING * self.displacement.value / noise.size), FLOOR),
            self.force.ratio(noise.force, floor),
            self.moment.ratio(moment_rounding, floor * noise.size),
        ]
    }
}

fn kinds_of_probes(model: &Model, steps: &[ProbeSteps]) -> Kinds {
    let mut kinds = Kinds::default();
    for step in steps {
        let errors = step.errors();
        for index in 0..model.probes.len() {
            let largest = step.increments.iter().map(|values| values[index].abs()).fold(0.0, f64::max);
            let error = errors.as_ref().map(|errors| errors[index]);
            match model.probes.kind(index) {
                ProbeKind::Displacement => kinds.displacement.take(largest, error),
                ProbeKind::Rotation => kinds.rotation.take(largest.to_radians(), error.map(f64::to_radians)),
                ProbeKind::Force => kinds.force.take(largest, error),
                ProbeKind::Moment => kinds.moment.take(largest, error),
                // No claim is made on what is greatest somewhere, nor on what is made of other probes.
                ProbeKind::GreatestMoment | ProbeKind::Stress | ProbeKind::Strain | ProbeKind::Other => {}
            }
        }
    }
    kinds
}

fn kinds_of_nodes(dimension: Dimension, steps: &[StepHistory]) -> Kinds {
    let mut kinds = Kinds::default();
    for step in steps {
        for state in step.increments.iter().map(|increment| &increment.state) {
            take_nodes(&mut kinds, state);
        }
        let (Some(last), Some(refined)) = (last_state(step), &step.refined) else { continue };
        for (node, better) in last.nodes.iter().zip(&refined.nodes) {
            let error = NodeError::between(node, better, dimension);
            kinds.displacement.take(0.0, Some(error.displacement));
            kinds.rotation.take(0.0, Some(error.rotation));
            kinds.force.take(0.0, Some(error.reaction_force));
            kinds.moment.take(0.0, Some(error.reaction_moment));
        }
    }
    kinds
}

fn take_nodes(kinds: &mut Kinds, state: &Equilibrium) {
    // Increments on the way are solved for less: reactions that their residual explains are none.
    let beyond = |value: f64, largest: f64| if value > state.residual * largest { value } else { 0.0 };
    let (force, moment) = (largest_force(state), largest_moment(state));
    for node in &state.nodes {
        kinds.displacement.take(norm(node.displacement), None);
        kinds.rotation.take(norm(node.rotation).max(node.rotation_total.abs()), None);
        kinds.force.take(beyond(norm(node.reaction_force), force), None);
        kinds.moment.take(beyond(norm(node.reaction_moment), moment), None);
    }
}

/// What the network's size and forces suggest about rounding.
struct Noise {
    /// Diagonal of the box around the unloaded network.
    size: f64,
    /// The largest force anywhere in the run.
    largest_force: f64,
    /// Forces below this are rounding.
    force: f64,
}

impl Noise {
    fn of(structure: &Structure, history: &History) -> Self {
        let size = diagonal(structure.nodes.iter().copied());
        let largest_force = history.steps.iter().filter_map(last_state).map(largest_force).fold(0.0, f64::max);
        let stiff = structure.members.iter().flat_map(|member| {
            let lengths = [member.length(); 2];
            let rounding = move |segment: &Segment| {
                let section = structure.laws[segment.law].at(0.0).section;
                match section.ea.is_finite() {
                    true => FORCE_ROUNDING * section.ea,
                    false => HELD_ROUNDING * AUXILIARY.of_bending(section.ei2.max(section.ei3), lengths),
                }
            };
            member.segments.iter().map(rounding)
        });
        // What bends by moments alone has no forces but rounding.
        let moments = history.steps.iter().filter_map(last_state).map(largest_moment).fold(0.0, f64::max);
        let scale = if size > 0.0 { largest_force.max(moments / size) } else { largest_force };
        let force = stiff.filter(|rounding| rounding.is_finite()).fold(ROUNDING * scale, f64::max);
        Self { size, largest_force, force }
    }
}

#[cfg(test)]
mod tests {
    use pennate_solver::history::{Increment, MemberState, NodeState, Status};

    use super::*;

    fn noise() -> Noise {
        Noise { size: 100.0, largest_force: 10.0, force: 1e-8 }
    }

    #[test]
    fn kinds_of_rounding_alone_are_left_out() {
        let mut kinds = Kinds::default();
        kinds.displacement.take(1e-9, Some(1e-9));
        kinds.rotation.take(0.5, Some(1e-6));
        kinds.force.take(1e-9, Some(1e-9));
        assert_eq!(kinds.ratios(&noise()), [None, Some(2e-6), None, None]);
    }

    /// A moment of 1e-4 beside forces of 10 in a network of 100 counts as 1.
    #[test]
    fn small_moments_are_measured_by_force_times_size() {
        let mut kinds = Kinds::default();
        kinds.force.take(10.0, Some(0.0));
        kinds.moment.take(1e-4, Some(1e-5));
        assert_eq!(kinds.ratios(&noise())[3], Some(1e-5));
    }

    /// What two meshes agree on by chance has a twentieth of the largest error; what is nothing, or the same to the last digit, has its own.
    #[test]
    fn values_that_agree_by_chance_have_an_error() {
        let kind = Kind { value: 10.0, error: 2e-3 };
        assert_eq!(kind.stated(1e-9, 3.0), 1e-4);
        assert_eq!(kind.stated(5e-4, 3.0), 5e-4);
        assert_eq!(kind.stated(1e-9, 1e-9), 1e-9);
        assert_eq!(kind.stated(0.0, 3.0), 0.0);
    }

    /// What the residual explains of reactions, and of moments apart, is left out; what members carry is the measure.
    #[test]
    fn reactions_that_are_left_over_are_none() {
        let node =
            NodeState { reaction_force: [3e-8, 0.0, 0.0], reaction_moment: [0.0, 0.0, 5.0], ..NodeState::default() };
        let member = MemberState { end_forces: [[10.0, 0.0, 0.0]; 2], ..MemberState::default() };
        let state =
            |residual| Equilibrium { residual, nodes: vec![node], members: vec![member], ..Equilibrium::default() };
        let largest = |residual| {
            let mut kinds = Kinds::default();
            take_nodes(&mut kinds, &state(residual));
            [kinds.force.value, kinds.moment.value]
        };
        assert_eq!([largest(1e-8), largest(1e-9)], [[0.0, 5.0], [3e-8, 5.0]]);
    }

    /// A state whose second node has moved by this part of a length and turned by seven times that.
    fn state(part: f64) -> Equilibrium {
        let moved =
            NodeState { displacement: [0.0, -2.0 * part, 0.0], rotation_total: 7.0 * part, ..NodeState::default() };
        Equilibrium { nodes: vec![NodeState::default(), moved], ..Equilibrium::default() }
    }

    #[test]
    fn without_probes_every_node_is_judged() {
        let increment = |fraction| Increment { fraction, state: state(fraction), shapes: Vec::new() };
        let step = StepHistory {
            status: Status::Converged,
            fraction: 0.75,
            prestress: None,
            iterations: 0,
            factorizations: 0,
            increments: vec![increment(0.5), increment(0.75)],
            refined: Some(state(0.75 + 1e-9)),
            missing: Vec::new(),
            variations: Vec::new(),
            stable: None,
            vibration: None,
            stability: Dimension::Plane,
            negative_pivots: 0,
            critical_points: Vec::new(),
            jumps: Vec::new(),
            notes: Vec::new(),
            failure: None,
        };
        let [displacement, rotation, ..] = kinds_of_nodes(Dimension::Plane, &[step]).ratios(&noise());
        assert!((displacement.unwrap() - 2e-9 / 1.5).abs() < 1e-15);
        assert!((rotation.unwrap() - 7e-9 / 5.25).abs() < 1e-15);
    }
}
