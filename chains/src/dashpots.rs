//! Dashpots, forces and springs on the nodes of a chain: what makes a step of the flow down the energy out of an equilibrium,
//! and what shows where it gives way between its ends.
//!
//! A backward Euler step of the flow M u' = -dE/du from a state u0 is the minimum of E(u) + s/2 (u - u0)' M (u - u0),
//! with the stiffness s the inverse of the step in time. M has a unit of mass for a unit of length, lumped to the nodes.

use pennate_elements::beam::Beam;
use pennate_elements::real::Real;
use pennate_elements::rotation;
use pennate_elements::small::sub;

use crate::Chain;
use crate::pack::{Drawn, InnerNode, any};

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
    /// Brings what acts on the nodes to the present state.
    pub(super) fn load_dashpots(&mut self) {
        let elements = self.frames.len();
        let mut dashpots = std::mem::take(&mut self.dashpots);
        let zero = [T::zero(); D];
        for (rows, count) in [
            (&mut dashpots.stiffnesses, elements + 1),
            (&mut dashpots.forces, elements + 1),
            (&mut dashpots.inner_stiffness, elements * Self::INNER_NODES),
            (&mut dashpots.inner_force, elements * Self::INNER_NODES),
        ] {
            rows.clear();
            rows.resize(count, zero);
        }
        if self.settings.dashpots > 0.0 {
            self.tie_nodes(&mut dashpots);
        }
        if self.settings.push != 0.0 {
            self.push_nodes(&mut dashpots);
        }
        for drawn in &self.settings.drawn {
            self.draw_node(&mut dashpots, drawn);
        }
        self.dashpots = dashpots;
    }

    /// Dashpots that tie every node to where it is in the state of the settings.
    fn tie_nodes(&self, dashpots: &mut Dashpots<T, D>) {
        let elements = self.frames.len();
        let stiffness = self.settings.dashpots;
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
                    let weight: f64 = stiffness * (if d < Self::TRANSLATIONS { mass } else { inertia });
                    dashpots.stiffnesses[index][d].set_lane(lane, weight);
                    dashpots.forces[index][d].set_lane(lane, weight * change[component]);
                }
            }
            for element in 0..elements {
                let mass = self.inner_mass(lane, element);
                for i in 0..Self::INNER_NODES {
                    let (node, local) = (element * Self::INNER_NODES + i, element * P + i);
                    for d in 0..D {
                        let weight: f64 = stiffness * (if d < Self::TRANSLATIONS { mass } else { mass * mass * mass });
                        let change = self.state.local[local][d].lane(lane) - saved.local::<T, D>(local)[d].lane(lane);
                        dashpots.inner_stiffness[node][d].set_lane(lane, weight);
                        dashpots.inner_force[node][d].set_lane(lane, weight * change);
                    }
                }
            }
        }
    }

    /// Mass of a node within an element, of a unit for a unit of length.
    fn inner_mass(&self, lane: usize, element: usize) -> f64 {
        self.piece(element).length.lane(lane) / P as f64
    }

    /// Forces on every node that single out no motion.
    fn push_nodes(&self, dashpots: &mut Dashpots<T, D>) {
        let (elements, push) = (self.frames.len(), self.settings.push);
        let share = |d: usize, mass: f64| if d < Self::TRANSLATIONS { mass } else { mass * mass };
        for lane in 0..T::LANES {
            for index in 1..elements {
                let [mass, _] = self.mesh.end_mass(lane, index);
                for d in 0..D {
                    dashpots.forces[index][d].set_lane(lane, push * any(D * index + d) * share(d, mass));
                }
            }
            for node in 0..elements * Self::INNER_NODES {
                let mass = self.inner_mass(lane, node / Self::INNER_NODES);
                for d in 0..D {
                    dashpots.inner_force[node][d].set_lane(lane, push * any(D * node + d) * share(d, mass));
                }
            }
        }
    }

    /// Springs on one node.
    fn draw_node(&self, dashpots: &mut Dashpots<T, D>, drawn: &Drawn) {
        let Drawn { lane, stiffness, to, .. } = *drawn;
        for d in 0..Self::TRANSLATIONS {
            let Some(to) = to[d] else { continue };
            let (stiffnesses, forces, at) = match drawn.node {
                InnerNode::Between(index) => {
                    let place = B::pose(&self.state.nodes[index], lane).displacement[d];
                    (&mut dashpots.stiffnesses[index], &mut dashpots.forces[index], place)
                }
                InnerNode::Within(element, i) => {
                    let node = element * Self::INNER_NODES + i;
                    let place = self.state.local[element * P + i][d].lane(lane);
                    (&mut dashpots.inner_stiffness[node], &mut dashpots.inner_force[node], place)
                }
            };
            stiffnesses[d].set_lane(lane, stiffnesses[d].lane(lane) + stiffness);
            forces[d].set_lane(lane, forces[d].lane(lane) + stiffness * (at - to));
        }
    }
}
