//! Dashpots on every node, and the potential of what is conservative: for the flow down the energy.

use pennate_elements::small::{dot, norm};

use super::{State, System};

impl<const D: usize> System<D> {
    /// Ties every node to where it is in a state, by dashpots of this stiffness for a unit of mass.
    pub fn set_dashpots(&mut self, stiffness: f64, anchor: &State) {
        self.dashpots.0 = stiffness;
        self.dashpots.1.clone_from(&anchor.places.joints);
        for (pack, row) in self.packs.iter_mut().zip(&anchor.chains) {
            pack.set_dashpots(stiffness, row);
        }
        if !self.masses.is_empty() {
            return;
        }
        // A mass for springs and bodies without members too, that no joint is free of inertia.
        let least = 1e-6 * self.size;
        self.masses = vec![[least, least * self.size * self.size]; self.forces.len()];
        for (index, slot) in self.members.iter().enumerate() {
            let nodes = self.structure.members[index].nodes;
            for (node, [mass, inertia]) in nodes.into_iter().zip(self.packs[slot.pack].end_masses(slot.lane)) {
                let link = &self.topology.links[node];
                let arm = norm(link.arm);
                self.masses[link.joint][0] += mass;
                self.masses[link.joint][1] += inertia + mass * arm * arm;
            }
        }
    }

    /// Takes the dashpots away.
    pub fn remove_dashpots(&mut self) {
        self.dashpots.0 = 0.0;
        self.packs.iter_mut().for_each(|pack| pack.set_dashpots(0.0, &[]));
    }

    pub(super) fn assemble_dashpots(&mut self) {
        let stiffness = self.dashpots.0;
        if stiffness == 0.0 {
            return;
        }
        let active = self.equations.active;
        let motions = self.motions_between(&self.dashpots.1);
        for (joint, motion) in motions.iter().enumerate() {
            let [mass, inertia] = self.masses[joint];
            let mut block = [[0.0; 6]; 6];
            for c in 0..6 {
                let weight = stiffness * if c < 3 { mass } else { inertia };
                block[c][c] = weight;
                self.forces[joint][c] += weight * motion[c];
            }
            self.add_joint_block(joint, &block, &active);
        }
    }

    /// Strain energy less the work of all loads: what a conservative network lowers when it moves by itself.
    ///
    /// Read after an assembly. Moments count by the rotation about their axis, which is their potential in the plane.
    pub fn potential_energy(&self) -> f64 {
        let mut energy = self.spring_energy;
        for slot in &self.members {
            let pack = &self.packs[slot.pack];
            energy += pack.energy(slot.lane) - pack.load_work(slot.lane);
        }
        for (node, load) in self.loads.iter().enumerate() {
            let link = &self.topology.links[node];
            let joint = &self.state.joints[link.joint];
            energy -= dot(load.force, joint.point(link.arm));
            let turned = if D == 3 { [0.0, 0.0, joint.place.angle] } else { joint.theta };
            energy -= dot(load.moment, turned);
        }
        energy
    }
}
