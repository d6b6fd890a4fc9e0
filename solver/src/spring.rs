//! Springs between joints: all that the rest of the solver, the models and the analysis know of a kind of them.
//!
//! Energies, forces and tangents are those of `elements/src/spring.rs`. Here stands what belongs to the equations: which nodes
//! a spring acts on, which of their rotations, what it is like before any load, and what rounding makes in it.

use std::f64::consts::TAU;

use pennate_elements::rotation::{log, turn};
use pennate_elements::small::{V3, add, norm, scale, sub};
use pennate_elements::space::Pose;
use pennate_elements::spring::{self, SpringResponse, SpringStrain};

use crate::structure::NodeId;

/// A linear spring. Stiffnesses are force per length for components 0, 1, 2 and moment per radian for 3, 4, 5.
#[derive(Clone, Debug, PartialEq)]
pub enum Spring {
    /// Node to ground: energy ½ Σ k u² + ½ Σ k θ², θ the rotation vector of the node.
    Ground {
        /// The node.
        node: NodeId,
        /// Force per length; of six components also moment per radian.
        stiffness: [f64; 6],
    },
    /// Along the line between two nodes: energy ½ k (l − natural length)².
    Axial {
        /// First and second node.
        nodes: [NodeId; 2],
        /// Force per length.
        stiffness: f64,
        /// Length without force.
        natural_length: f64,
    },
    /// Six components, at the second node's place, in axes that turn with the first node.
    Coupling {
        /// First and second node.
        nodes: [NodeId; 2],
        /// Force per length; of six components also moment per radian.
        stiffness: [f64; 6],
    },
}

/// Part of a stiffness that rounding of directions makes.
const ROUNDED: f64 = 1e-12;

/// Where the nodes of a spring are.
pub(crate) struct Placed {
    /// Displacement and rotation of both nodes; of the only one twice.
    pub poses: [Pose<f64>; 2],
    /// The places of both, unloaded.
    pub unloaded: [V3<f64>; 2],
    /// Rotation vector of the first node, whole turns included.
    pub theta: V3<f64>,
    /// Angles of both nodes, whole turns included, where rotations are those of the plane.
    pub angles: Option<[f64; 2]>,
    /// Length without force, as far as the prestress has come.
    pub natural_length: f64,
}

impl Placed {
    /// The second node seen from the first, unloaded.
    fn arm(&self) -> V3<f64> {
        sub(self.unloaded[1], self.unloaded[0])
    }
}

impl Spring {
    /// The nodes that it acts on: one, or two that it joins.
    pub fn nodes(&self) -> &[NodeId] {
        match self {
            Self::Ground { node, .. } => std::slice::from_ref(node),
            Self::Axial { nodes, .. } | Self::Coupling { nodes, .. } => nodes,
        }
    }

    /// The same, to be numbered anew.
    pub fn nodes_mut(&mut self) -> &mut [NodeId] {
        match self {
            Self::Ground { node, .. } => std::slice::from_mut(node),
            Self::Axial { nodes, .. } | Self::Coupling { nodes, .. } => nodes,
        }
    }

    /// The two nodes that it joins, if it joins any.
    pub fn pair(&self) -> Option<[NodeId; 2]> {
        <[NodeId; 2]>::try_from(self.nodes()).ok()
    }

    /// Which of its nodes have a rotation that it acts on, or that it turns with.
    pub fn engages(&self) -> [bool; 2] {
        let turns = |stiffness: &[f64; 6]| stiffness[3..].iter().any(|&k| k != 0.0);
        match self {
            Self::Ground { stiffness, .. } => [turns(stiffness), false],
            Self::Axial { .. } => [false, false],
            Self::Coupling { stiffness, .. } => [true, turns(stiffness)],
        }
    }

    /// The numbers that describe it.
    pub fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Ground { stiffness, .. } | Self::Coupling { stiffness, .. } => stiffness.to_vec(),
            Self::Axial { stiffness, natural_length, .. } => vec![*stiffness, *natural_length],
        }
    }

    /// The same, to be changed.
    pub fn numbers_mut(&mut self) -> Vec<&mut f64> {
        match self {
            Self::Ground { stiffness, .. } | Self::Coupling { stiffness, .. } => stiffness.iter_mut().collect(),
            Self::Axial { stiffness, natural_length, .. } => vec![stiffness, natural_length],
        }
    }

    /// Whether another spring is of this kind and on these nodes.
    pub fn is_like(&self, other: &Self) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other) && self.nodes() == other.nodes()
    }

    /// Length without force, of a spring along a line.
    pub(crate) fn natural_length(&self) -> Option<f64> {
        match self {
            Self::Axial { natural_length, .. } => Some(*natural_length),
            Self::Ground { .. } | Self::Coupling { .. } => None,
        }
    }

    /// The nodes of a spring along a line that pushes or pulls where these are in one place: a bar with two hinges.
    pub(crate) fn bar(&self) -> Option<[NodeId; 2]> {
        self.pair().filter(|_| self.natural_length().is_some_and(|length| length > 0.0))
    }

    /// Makes a spring along a line free of force at a length.
    pub fn relax(&mut self, length: f64) {
        match self {
            Self::Axial { natural_length, .. } => *natural_length = length,
            Self::Ground { .. } | Self::Coupling { .. } => {}
        }
    }

    /// Whether it has a force where the nodes are unloaded.
    pub fn is_prestressed(&self, nodes: &[[f64; 3]]) -> bool {
        let (Some(natural_length), Some(pair)) = (self.natural_length(), self.pair()) else { return false };
        let [a, b] = pair.map(|node| nodes[node]);
        let length = (0..3).map(|c| (b[c] - a[c]) * (b[c] - a[c])).sum::<f64>().sqrt();
        (length - natural_length).abs() > 1e-12 * length
    }

    /// Its stiffness against turning across an axis, on which its nodes lie (moment per radian); nothing where it is not alike in all
    /// directions across, against displacements too.
    pub(crate) fn stiffness_around(&self, axis: V3<f64>) -> Option<f64> {
        match self {
            Self::Ground { stiffness, .. } | Self::Coupling { stiffness, .. } => {
                let of = |offset: usize| across(std::array::from_fn(|c| stiffness[offset + c]), axis);
                of(0).and(of(3))
            }
            Self::Axial { .. } => Some(0.0),
        }
    }

    /// The force on the structure of a spring to the ground whose node is displaced by `u`.
    pub(crate) fn ground_force(&self, u: V3<f64>) -> Option<V3<f64>> {
        match self {
            Self::Ground { stiffness, .. } => Some(std::array::from_fn(|c| -stiffness[c] * u[c])),
            Self::Axial { .. } | Self::Coupling { .. } => None,
        }
    }

    /// Energy, gradient and tangent, and the force that results say: along the line, or the size of that on the last node.
    pub(crate) fn respond(&self, at: &Placed) -> (SpringResponse, f64) {
        let [first, second] = &at.poses;
        match self {
            Self::Ground { stiffness, .. } => {
                let response = ground(stiffness, at);
                let force = norm([response.gradient[0], response.gradient[1], response.gradient[2]]);
                (response, force)
            }
            Self::Axial { stiffness, .. } => spring::axial(*stiffness, at.natural_length, at.arm(), [first, second]),
            Self::Coupling { stiffness, .. } => {
                let response = coupling(stiffness, at);
                let force = norm([response.gradient[6], response.gradient[7], response.gradient[8]]);
                (response, force)
            }
        }
    }

    /// Its strains, by displacements and spins of its nodes.
    pub(crate) fn strains(&self, at: &Placed) -> Vec<SpringStrain> {
        let [first, second] = &at.poses;
        match self {
            Self::Ground { stiffness, .. } => spring::ground_strains(stiffness, first, at.theta),
            Self::Axial { stiffness, .. } => {
                vec![spring::axial_strain(*stiffness, at.natural_length, at.arm(), [first, second])]
            }
            Self::Coupling { stiffness, .. } => spring::coupling_strains(stiffness, at.arm(), [first, second]),
        }
    }

    /// Force and moment on each of its nodes by rounding, of signs that are drawn, in units of the last place of one; `force`
    /// is that of the results.
    pub(crate) fn rounded(&self, at: &Placed, force: f64, draw: &mut impl FnMut() -> f64) -> [[V3<f64>; 2]; 2] {
        let zero = [0.0; 3];
        match self {
            Self::Ground { stiffness, .. } => {
                let (u, theta) = (at.poses[0].displacement, log(at.poses[0].rotation));
                let force = std::array::from_fn(|c| draw() * stiffness[c] * u[c]);
                let moment = std::array::from_fn(|c| draw() * stiffness[3 + c] * theta[c]);
                [[force, moment], [zero; 2]]
            }
            Self::Axial { stiffness, .. } => {
                let [a, b] = [0, 1].map(|end| add(at.unloaded[end], at.poses[end].displacement));
                let chord = sub(b, a);
                let size = draw() * (stiffness + force.abs() / norm(chord));
                let force = if size.is_finite() { scale(size, chord) } else { zero };
                [[scale(-1.0, force), zero], [force, zero]]
            }
            Self::Coupling { stiffness, .. } => {
                let reach = norm(at.arm()) + norm(at.poses[1].displacement);
                let rotation = at.poses[0].rotation;
                let force = std::array::from_fn(|c| draw() * stiffness[c] * reach);
                let moment = std::array::from_fn(|c| draw() * stiffness[3 + c]);
                let (force, moment) = (turn(rotation, force), turn(rotation, moment));
                [[scale(-1.0, force), scale(-1.0, moment)], [force, moment]]
            }
        }
    }
}

/// What stiffnesses along x, y and z are in all directions across an axis; nothing where they differ.
fn across(stiffness: V3<f64>, axis: V3<f64>) -> Option<f64> {
    let along: f64 = (0..3).map(|c| stiffness[c] * axis[c] * axis[c]).sum();
    let across = 0.5 * (stiffness.iter().sum::<f64>() - along);
    let largest = stiffness.iter().fold(0.0, |most: f64, k| most.max(k.abs()));
    let is_same = |i: usize, j: usize| {
        let own = if i == j { stiffness[i] - across } else { 0.0 };
        (own - (along - across) * axis[i] * axis[j]).abs() <= ROUNDED * largest
    };
    (0..3).all(|i| (0..3).all(|j| is_same(i, j))).then_some(across)
}

/// In the plane the rotation between two nodes counts whole turns.
fn coupling(stiffness: &[f64; 6], at: &Placed) -> SpringResponse {
    let mut response = spring::coupling(stiffness, at.arm(), [&at.poses[0], &at.poses[1]]);
    if let Some([first, second]) = at.angles {
        let angle = second - first;
        let reduced = angle - TAU * (angle / TAU).round();
        response.energy += 0.5 * stiffness[5] * (angle * angle - reduced * reduced);
        response.gradient[5] -= stiffness[5] * (angle - reduced);
        response.gradient[11] += stiffness[5] * (angle - reduced);
    }
    response
}

/// The rotation of a ground spring counts whole turns.
fn ground(stiffness: &[f64; 6], at: &Placed) -> SpringResponse {
    let Some([angle, _]) = at.angles else { return spring::ground(stiffness, &at.poses[0], at.theta) };
    let mut response = spring::ground(stiffness, &at.poses[0], [0.0; 3]);
    let reduced = log(at.poses[0].rotation)[2];
    response.energy += 0.5 * stiffness[5] * (angle * angle - reduced * reduced);
    response.gradient[5] = stiffness[5] * angle;
    response.tangent[5][5] = stiffness[5];
    response
}
