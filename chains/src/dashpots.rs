//! Dashpots on the nodes of a chain: what makes a step of the flow down the energy out of an equilibrium.
//!
//! A backward Euler step of the flow M u' = -dE/du from a state u0 is the minimum of E(u) + s/2 (u - u0)' M (u - u0),
//! with the stiffness s the inverse of the step in time. M has a unit of mass for a unit of length, lumped to the nodes.

use pennate_elements::beam::Beam;
use pennate_elements::real::Real;
use pennate_elements::rotation;
use pennate_elements::small::sub;

use crate::Chain;

/// Stiffness and force of the dashpots at the present state.
#[derive(Debug)]
pub(super) struct Dashpots<T, const D: usize> {
    /// Diagonals and forces of the nodes between elements, by the element that follows.
    pub stiffnesses: Vec<[T; D]>,
    pub forces: Vec<[T; D]>,
    /// The same of the nodes within elements.
    pub inner_stiffness: Vec<[T; D]>,
    pub inner_force: Vec<[T; D]>,
}

impl<T, const D: usize> Default for Dashpots<T, D> {
    fn default() -> Self {
        Self { stiffnesses: Vec::new(), forces: Vec::new(), inner_stiffness: Vec::new(), inner_force: Vec::new() }
    }
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    /// Brings the dashpots to the present state.
    pub(super) fn load_dashpots(&mut self) {
        let elements = self.pieces.len();
        let mut dashpots = std::mem::take(&mut self.dashpots);
        let zero = [T::zero(); D];
        dashpots.stiffnesses.resize(elements + 1, zero);
        dashpots.forces.resize(elements + 1, zero);
        dashpots.inner_stiffness.resize(elements * Self::INNER_NODES, zero);
        dashpots.inner_force.resize(elements * Self::INNER_NODES, zero);
        let saved = self.saved(&self.settings.anchor);
        for lane in 0..T::LANES {
            for index in 1..elements {
                let [mass, inertia] = self.mesh.end_mass(lane, index);
                let (now, then) =
                    (B::pose(&self.state.nodes[index], lane), B::pose(&saved.node::<T, B, D>(index), lane));
                let u = sub(now.displacement, then.displacement);
                let spin = if D == 3 {
                    [0.0, 0.0, now.angle - then.angle]
                } else {
                    rotation::log(rotation::compose(now.rotation, rotation::inverse(then.rotation)))
                };
                let change = [u[0], u[1], u[2], spin[0], spin[1], spin[2]];
                for d in 0..D {
                    let component = if D == 6 { d } else { [0, 1, 5][d] };
                    let weight: f64 = self.settings.dashpots * (if d < Self::TRANSLATIONS { mass } else { inertia });
                    dashpots.stiffnesses[index][d].set_lane(lane, weight);
                    dashpots.forces[index][d].set_lane(lane, weight * change[component]);
                }
            }
            for element in 0..elements {
                let mass = self.pieces[element].length.lane(lane) / P as f64;
                for i in 0..Self::INNER_NODES {
                    let (node, local) = (element * Self::INNER_NODES + i, element * P + i);
                    for d in 0..D {
                        let weight: f64 =
                            self.settings.dashpots * (if d < Self::TRANSLATIONS { mass } else { mass * mass * mass });
                        let change = self.state.local[local][d].lane(lane) - saved.local::<T, D>(local)[d].lane(lane);
                        dashpots.inner_stiffness[node][d].set_lane(lane, weight);
                        dashpots.inner_force[node][d].set_lane(lane, weight * change);
                    }
                }
            }
        }
        self.dashpots = dashpots;
    }
}
