//! How probes follow the state that they are read in, and what else they depend on.

use nalgebra::{Matrix3, Rotation3, Vector3};
use pennate_elements::rotation::tangent_map;
use pennate_solver::history::Equilibrium;
use pennate_solver::structure::NodeId;

use crate::expression::Expression;
use crate::probes::{Operand, Probe, Probes};

/// The derivatives of a probe by what it is read from. Angles of the probe are degrees, spins are radians.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Weights {
    /// By the displacement of nodes (0, 1, 2) and by their spin (3, 4, 5): small rotations on top of the present one, in
    /// global axes.
    pub motions: Vec<(NodeId, [f64; 6])>,
    /// By the reaction force on nodes and the reaction moment.
    pub reactions: Vec<(NodeId, [f64; 6])>,
}

/// An angle (radians) below which nobody can say in which direction it grows.
const NO_ANGLE: f64 = 1e-9;

/// The direction in which an angle grows; none where it vanishes.
fn along(rotation: Vector3<f64>) -> Option<Vector3<f64>> {
    (rotation.norm() > NO_ANGLE).then(|| rotation.normalize())
}

impl Probes {
    /// The derivatives of a probe by motions and reactions of nodes; `None` where it is read from anything else, or has no
    /// derivative there.
    pub fn weights(&self, probe: usize, state: &Equilibrium) -> Option<Weights> {
        let shift = |along: [f64; 3]| [along[0], along[1], along[2], 0.0, 0.0, 0.0];
        let spin = |about: Vector3<f64>| {
            let about = about.map(f64::to_degrees);
            [0.0, 0.0, 0.0, about.x, about.y, about.z]
        };
        let motions = |motions: Vec<(NodeId, [f64; 6])>| Weights { motions, reactions: Vec::new() };
        let vector = |node: NodeId| Vector3::from(state.nodes[node].rotation);
        let weights = match self.probes[probe] {
            Probe::Displacement { node, direction } | Probe::Position { node, direction, .. } => {
                motions(vec![(node, shift(direction))])
            }
            Probe::Distance { nodes: [first, second], unloaded } => {
                let [a, b] = [first, second].map(|node| Vector3::from(state.nodes[node].displacement));
                let along = (Vector3::from(unloaded) + b - a).normalize();
                motions(vec![(first, shift((-along).into())), (second, shift(along.into()))])
            }
            Probe::Rotation { node, axis: 2 } if self.in_plane => motions(vec![(node, spin(Vector3::z()))]),
            // A spin is the tangent map of the rotation vector times its change.
            Probe::Rotation { node, axis } => {
                let map: Matrix3<f64> = tangent_map(state.nodes[node].rotation).into();
                // Rows of the array are columns of the matrix.
                let inverse = map.transpose().try_inverse()?;
                motions(vec![(node, spin(inverse.row(axis).transpose()))])
            }
            Probe::Angle { node } if self.in_plane => {
                let angle = state.nodes[node].rotation_total;
                motions(vec![(node, spin(along(angle * Vector3::z())?))])
            }
            Probe::Angle { node } => motions(vec![(node, spin(along(vector(node))?))]),
            Probe::Tilt { reference, normal } => {
                let normal = Vector3::from(normal);
                let turned = Rotation3::from_scaled_axis(vector(reference)) * normal;
                motions(vec![(reference, spin(along(normal.cross(&turned))?))])
            }
            Probe::ReactionForce { node, direction } => {
                Weights { motions: Vec::new(), reactions: vec![(node, shift(direction))] }
            }
            Probe::ReactionMoment { node, axis } => {
                let mut about = [0.0; 6];
                about[3 + axis] = 1.0;
                Weights { motions: Vec::new(), reactions: vec![(node, about)] }
            }
            Probe::AxialForce { .. } | Probe::Greatest { .. } | Probe::Stiffness { .. } | Probe::Expression { .. } => {
                return None;
            }
        };
        let all = weights.motions.iter().chain(&weights.reactions);
        all.flat_map(|(_, weights)| weights).all(|weight| weight.is_finite()).then_some(weights)
    }

    /// What an expression of probes refers to; `None` for any other probe.
    pub fn operands(&self, probe: usize) -> Option<&[Operand]> {
        self.expression(probe).map(|(_, operands)| operands)
    }

    /// An expression of probes, with what it refers to; `None` for any other probe.
    pub fn expression(&self, probe: usize) -> Option<(&Expression, &[Operand])> {
        match &self.probes[probe] {
            Probe::Expression { expression, operands } => Some((expression, operands)),
            _ => None,
        }
    }

    /// The indices of all probes, each after those that it needs.
    pub fn order(&self) -> &[usize] {
        &self.order
    }

    /// The numbers of a probe that parameters may set, whatever they mean; those of sections left out.
    pub fn numbers(&self, probe: usize) -> Vec<f64> {
        match &self.probes[probe] {
            Probe::Displacement { direction, .. } | Probe::ReactionForce { direction, .. } => direction.to_vec(),
            Probe::Position { unloaded, direction, .. } => [*unloaded, *direction].concat(),
            Probe::Tilt { normal, .. } => normal.to_vec(),
            Probe::Distance { unloaded, .. } => unloaded.to_vec(),
            Probe::Stiffness { along, .. } => along.to_vec(),
            Probe::Expression { operands, .. } => {
                let number = |operand: &Operand| match operand {
                    Operand::Parameter(value) => *value,
                    Operand::Probe(_) | Operand::After { .. } => 0.0,
                };
                operands.iter().map(number).collect()
            }
            Probe::Rotation { .. }
            | Probe::Angle { .. }
            | Probe::ReactionMoment { .. }
            | Probe::AxialForce { .. }
            | Probe::Greatest { .. } => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use pennate_elements::rotation::{compose, exp, log};
    use pennate_solver::history::NodeState;

    use super::*;

    /// Weights against differences over small motions of two nodes.
    #[test]
    fn weights_are_derivatives() {
        let nodes = vec![
            NodeState { displacement: [1.0, 2.0, -0.5], rotation: [0.4, -0.8, 1.1], ..NodeState::default() },
            NodeState { displacement: [0.2, 0.1, 0.7], rotation: [-0.3, 0.2, 0.1], ..NodeState::default() },
        ];
        let state = Equilibrium { nodes, ..Equilibrium::default() };
        let probes = vec![
            Probe::Distance { nodes: [0, 1], unloaded: [3.0, 4.0, 5.0] },
            Probe::Rotation { node: 0, axis: 1 },
            Probe::Angle { node: 0 },
            Probe::Tilt { reference: 0, normal: [0.6, 0.0, 0.8] },
        ];
        let names = vec![String::new(); probes.len()];
        let all = Probes { names, order: (0..probes.len()).collect(), probes, in_plane: false };
        for probe in 0..all.len() {
            let weights = all.weights(probe, &state).unwrap();
            for node in 0..2 {
                for component in 0..6 {
                    let moved = |by: f64| {
                        let mut state = state.clone();
                        let own = &mut state.nodes[node];
                        let mut motion = [0.0; 3];
                        motion[component % 3] = by;
                        if component < 3 {
                            own.displacement[component] += by;
                        } else {
                            own.rotation = log(compose(exp(motion), exp(own.rotation)));
                        }
                        all.evaluate(&state, &[])[probe]
                    };
                    let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                    let own = weights.motions.iter().filter(|(at, _)| *at == node);
                    let found: f64 = own.map(|(_, weights)| weights[component]).sum();
                    assert!((slope - found).abs() < 1e-8 * (1.0 + found.abs()), "{probe} {component}: {slope} {found}");
                }
            }
        }
    }
}
