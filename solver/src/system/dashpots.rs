//! Dashpots on every node, and the potential of what is conservative: for the flow down the energy.

use pennate_elements::small::{dot, norm};

use super::{Places, State, System};
use crate::chain::load_work;

/// Dashpots between every node and where it was.
#[derive(Debug, Default)]
pub(super) struct Dashpots {
    /// Stiffness for a unit of mass; zero where there are none.
    stiffness: f64,
    /// Where they tie to.
    anchor: Places,
    /// Mass and inertia of the joints; empty until they are asked for.
    masses: Vec<[f64; 2]>,
}

impl<const D: usize> System<D> {
    /// Ties every node to where it is in a state, by dashpots of this stiffness for a unit of mass.
    pub(crate) fn set_dashpots(&mut self, stiffness: f64, anchor: &State) {
        self.dashpots.stiffness = stiffness;
        self.dashpots.anchor.clone_from(&anchor.places);
        for (pack, row) in self.members.packs.iter_mut().zip(&anchor.chains) {
            let settings = pack.settings();
            settings.dashpots = stiffness;
            settings.anchor.clone_from(row);
        }
        if self.dashpots.masses.is_empty() {
            self.dashpots.masses = self.joint_masses();
        }
    }

    /// Mass and inertia of the joints.
    fn joint_masses(&self) -> Vec<[f64; 2]> {
        // A mass for springs and bodies without members too, that no joint is free of inertia.
        let least = 1e-6 * self.size;
        let mut masses = vec![[least, least * self.size * self.size]; self.places.joints.len()];
        for member in 0..self.members.count() {
            let (pack, lane) = self.members.chain(member);
            let nodes = self.structure.members[member].nodes;
            for (end, node) in [0, pack.mesh().elements()].into_iter().zip(nodes) {
                let [mass, inertia] = pack.mesh().end_mass(lane, end);
                let link = &self.topology.links[node];
                let arm = norm(link.arm);
                masses[link.joint][0] += mass;
                masses[link.joint][1] += inertia + mass * arm * arm;
            }
        }
        masses
    }

    /// Takes the dashpots away.
    pub(crate) fn remove_dashpots(&mut self) {
        self.dashpots.stiffness = 0.0;
        self.members.packs.iter_mut().for_each(|pack| pack.settings().dashpots = 0.0);
    }

    pub(super) fn assemble_dashpots(&mut self) {
        let stiffness = self.dashpots.stiffness;
        if stiffness == 0.0 {
            return;
        }
        let motions = self.places.motions_since::<D>(&self.dashpots.anchor);
        for (joint, motion) in motions.iter().enumerate() {
            let [mass, inertia] = self.dashpots.masses[joint];
            let mut block = [[0.0; 6]; 6];
            for c in 0..6 {
                let weight = stiffness * if c < 3 { mass } else { inertia };
                block[c][c] = weight;
                self.tangent.forces[joint][c] += weight * motion[c];
            }
            self.add_joint_block(joint, &block);
        }
    }

    /// Strain energy less the work of all loads: what a conservative network lowers when it moves by itself.
    ///
    /// Read after an assembly. Moments count by the rotation about their axis, which is their potential in the plane.
    pub(crate) fn potential_energy(&self) -> f64 {
        let mut energy = self.tangent.spring_energy;
        for member in 0..self.members.count() {
            let (pack, lane) = self.members.chain(member);
            energy += pack.interior(lane).energy - load_work(pack, lane);
        }
        for (node, load) in self.loading.nodes.iter().enumerate() {
            let link = &self.topology.links[node];
            let joint = &self.places.joints[link.joint];
            energy -= dot(load.force, joint.point(link.arm));
            let turned = if D == 3 { [0.0, 0.0, joint.place.angle] } else { joint.theta };
            energy -= dot(load.moment, turned);
        }
        energy
    }
}
