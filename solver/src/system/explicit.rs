//! What an equilibrium needs for its derivatives: forces on joints that stay where they are, of parts whose numbers are
//! others, and products with the transposed tangent.

use std::sync::Arc;

use super::System;
use super::scatter::Scatters;
use super::skew::Skew;
use crate::structure::MemberId;

impl<const D: usize> System<D> {
    /// Stands where another system does at the end of its step: this one has some of its members (by their indices there),
    /// each as often as wanted, and all of its joints, one copy of them after the other.
    pub fn stand_in(&mut self, other: &Self, members: &[MemberId], drives: &[f64]) {
        let joints = other.state.joints.len().max(1);
        for copy in self.state.joints.chunks_exact_mut(joints) {
            copy.copy_from_slice(&other.state.joints);
        }
        for (index, &member) in members.iter().enumerate() {
            self.state.releases[index] = other.state.releases[member];
            let (to, from) = (&self.members[index], &other.members[member]);
            self.packs[to.pack].adopt(to.lane, other.packs[from.pack].as_ref(), from.lane);
        }
        self.drives.copy_from_slice(drives);
        (self.prestress, self.fraction) = (1.0, 1.0);
        self.apply_drives();
        self.place_ends();
    }

    /// Internal less external force of every joint at the present state. There are no equations afterwards.
    pub fn exert(&mut self) -> &[[f64; 6]] {
        self.scatters = Arc::new(self.no_scatters());
        self.find_loaded_nodes();
        self.condense();
        self.forces.fill([0.0; 6]);
        let mut unused = std::mem::take(&mut self.motions);
        for index in 0..self.members.len() {
            self.assemble_member(index, false, &mut unused);
        }
        for index in 0..self.structure.springs.len() {
            self.assemble_spring(index, false, &mut unused);
        }
        self.motions = unused;
        self.assemble_loads();
        &self.forces
    }

    /// The transposed tangent of all components, held ones included, times a motion of every joint.
    ///
    /// The last assembly, its factors too, stays what it is.
    pub fn transposed_times(&mut self, motions: &[[f64; 6]]) -> Vec<[f64; 6]> {
        let pending = std::mem::replace(&mut self.equations.pending, motions.to_vec());
        let none = Arc::new(self.no_scatters());
        let scatters = std::mem::replace(&mut self.scatters, none);
        let (forces, stiffness) = (self.forces.clone(), self.stiffness.clone());
        let (idle, scales) = (self.idle_members.clone(), (self.force_scale, self.moment_scale));
        let released = (self.released_negative, self.released_neutral);
        let mut product = vec![[0.0; 6]; motions.len()];
        for index in 0..self.members.len() {
            self.assemble_member(index, true, &mut product);
        }
        for index in 0..self.structure.springs.len() {
            self.assemble_spring(index, true, &mut product);
        }
        (self.equations.pending, self.scatters) = (pending, scatters);
        (self.forces, self.stiffness) = (forces, stiffness);
        (self.idle_members, (self.force_scale, self.moment_scale)) = (idle, scales);
        (self.released_negative, self.released_neutral) = released;
        for &node in &self.loaded_nodes {
            let load = self.load_at(node);
            for &i in &self.equations.active {
                for &j in &self.equations.active {
                    product[load.joint][j] += load.block[i][j] * motions[load.joint][i];
                }
            }
        }
        product
    }

    /// Solves with the transposed tangent from now on, or with the tangent again.
    pub fn transpose(&mut self) {
        if self.skew.joints.is_empty() {
            return;
        }
        let mut turned = std::mem::take(&mut self.skew);
        turned.joints.iter_mut().for_each(|(_, block)| *block = -*block);
        self.skew = Skew { joints: turned.joints, ..Skew::default() };
        self.factorize_skew(&mut super::Inertia::default());
    }

    fn no_scatters(&self) -> Scatters {
        Scatters::none(self.members.len(), self.structure.springs.len(), self.state.joints.len())
    }
}
