//! What an equilibrium needs for its derivatives: forces on joints that stay where they are, of parts whose numbers are
//! others, and products with the tangent and the transposed one.

use std::sync::Arc;

use pennate_elements::beam::Moduli;
use pennate_elements::small::{M3, V3};

use super::System;
use super::scatter::Scatters;
use crate::chain::{MemberEnds, NodesBy};
use crate::joints::{Held, dot6};
use crate::structure::MemberId;

impl<const D: usize> System<D> {
    /// Stands where another system does at the end of its step: this one has some of its members (by their indices there),
    /// each as often as wanted, and all of its joints, one copy of them after the other. `sources` are the packs there that the
    /// packs here were made from, lane by lane.
    pub fn stand_in(&mut self, other: &Self, sources: &[usize], members: &[MemberId], drives: &[f64]) {
        let joints = other.places.joints.len().max(1);
        for copy in self.places.joints.chunks_exact_mut(joints) {
            copy.copy_from_slice(&other.places.joints);
        }
        let mut row = Vec::new();
        for (pack, &source) in self.members.packs.iter_mut().zip(sources) {
            other.members.packs[source].save(&mut row);
            pack.restore(&row, 0.0);
        }
        for (releases, &member) in self.places.releases.iter_mut().zip(members) {
            *releases = other.places.releases[member];
        }
        self.turn_released_ends();
        self.loading.end(drives);
        self.apply_drives();
        self.place_ends();
    }

    /// Internal less external force of every joint at the present state, interiors of members in equilibrium: by the factors
    /// that the system has which this one stands in for, to first order in what differs. There are no equations afterwards.
    pub fn exert(&mut self, other: &Self, sources: &[usize]) -> &[[f64; 6]] {
        self.forget_equations();
        for (pack, &source) in self.members.packs.iter_mut().zip(sources) {
            pack.refresh(Some(other.members.packs[source].as_ref()));
        }
        self.tangent.forces.fill([0.0; 6]);
        let mut unused = std::mem::take(&mut self.moves.motions);
        self.assemble_members(&mut unused);
        for index in 0..self.structure.springs.len() {
            self.assemble_spring(index, false, &mut unused);
        }
        self.moves.motions = unused;
        self.assemble_loads(None);
        &self.tangent.forces
    }

    /// Moves the joints, and linearizes all parts with interiors and released ends in equilibrium to first order, for
    /// [`System::transposed_times`]. There are no equations afterwards.
    pub fn linearize_parts(&mut self, motions: &[[f64; 6]]) {
        self.forget_equations();
        let mut unused = std::mem::take(&mut self.moves.motions);
        self.members.condense();
        self.assemble_members(&mut unused);
        self.move_interiors(motions);
        self.places.joints.iter_mut().zip(motions).for_each(|(joint, motion)| joint.advance(motion));
        self.move_releases();
        self.place_ends();
        self.members.place_nodes(if self.straight { NodesBy::Increments } else { NodesBy::Elements });
        self.members.condense();
        self.assemble_members(&mut unused);
        self.moves.motions = unused;
    }

    fn forget_equations(&mut self) {
        self.pattern.scatters = Arc::new(self.no_scatters());
        self.pattern.find_loaded_nodes(&self.structure, &self.loading.fading);
    }

    fn assemble_members(&mut self, unused: &mut [[f64; 6]]) {
        self.take_end_forces();
        for index in 0..self.members.count() {
            self.assemble_member(index, false, unused);
        }
    }

    /// The transposed tangent of all components, held ones included, times a motion of every joint.
    ///
    /// The last assembly, its factors too, stays what it is.
    pub fn transposed_times(&mut self, motions: &[[f64; 6]]) -> Vec<[f64; 6]> {
        let mut product = self.parts_times(motions);
        self.add_loads_times(motions, &mut product, |block, i, j| block[j][i]);
        self.add_constraints_times(motions, &mut product, |curved, i, j| curved[j][i]);
        product
    }

    /// The tangent of all components, held ones included, times a motion of every joint. It is another than the transposed one where
    /// loads turn with their nodes, or moments are dead, though these nodes be held from turning.
    pub fn tangent_times(&mut self, motions: &[[f64; 6]]) -> Vec<[f64; 6]> {
        let mut product = self.times(motions);
        self.add_constraints_times(motions, &mut product, |curved, i, j| curved[i][j]);
        product
    }

    /// Adds what rows that turn with their joints bear more or less as these move.
    fn add_constraints_times(
        &self,
        motions: &[[f64; 6]],
        product: &mut [[f64; 6]],
        entry: impl Fn(&M3<f64>, usize, usize) -> f64,
    ) {
        let equations = &self.pattern.equations;
        for (joint, motion) in motions.iter().enumerate().filter(|(joint, _)| equations.is_general(*joint)) {
            let state = &self.places.joints[joint];
            let curved = equations.constraint_stiffness(&self.topology, joint, state, self.loading.fraction);
            for i in 0..3 {
                for j in 0..3 {
                    product[joint][3 + i] += entry(&curved, i, j) * motion[3 + j];
                }
            }
        }
    }

    /// The tangent of all components times a motion of every joint: what the forces on joints change by, without those of what holds
    /// them.
    pub(super) fn times(&mut self, motions: &[[f64; 6]]) -> Vec<[f64; 6]> {
        let mut product = self.parts_times(motions);
        self.add_loads_times(motions, &mut product, |block, i, j| block[i][j]);
        product
    }

    /// What the entries of the stiffness of members add to its work along a motion of every joint, each taken by itself, and what they would
    /// add by stresses of strains that are held as large as their auxiliary stiffness.
    ///
    /// Held strains are nothing but rounding, a part of one: so is their stress of that stiffness, and members that it draws or presses
    /// resist turning the more or the less.
    pub(crate) fn terms_of_work(&self, motions: &[[f64; 6]]) -> f64 {
        let of_member = |index: usize| {
            let ([first, last], _) = self.end_motions(index, motions);
            let MemberEnds { k00, k01, k11, .. } = self.members.condensed(index);
            let mut sum = 0.0;
            for i in 0..D {
                for j in 0..D {
                    let (own, other) = (k00[i][j] * first[i] * first[j], k11[i][j] * last[i] * last[j]);
                    sum += own.abs() + other.abs() + 2.0 * (k01[i][j] * first[i] * last[j]).abs();
                }
            }
            let length = self.structure.members[index].length();
            let turned = |motion: &[f64; D]| motion[Self::TRANSLATIONS..].iter().map(|spin| spin * spin).sum::<f64>();
            let apart = first.iter().zip(last).take(Self::TRANSLATIONS).map(|(a, b)| (b - a).powi(2)).sum::<f64>();
            let square = turned(&first).max(turned(&last)).max(apart / (length * length));
            sum + self.holding(index) * length * square
        };
        (0..self.members.count()).map(of_member).sum()
    }

    /// The largest auxiliary stiffness (force) that stands for a held strain of a member; none where it has none.
    fn holding(&self, member: MemberId) -> f64 {
        let (pack, lane) = self.members.chain(member);
        let of_segment = |segment: usize| {
            let Moduli { stiffness, held, .. } = pack.segment(lane, segment).moduli;
            let forces = stiffness.into_iter().zip(held).take(Self::TRANSLATIONS);
            forces.filter(|(_, held)| *held > 0.0).fold(0.0, |most: f64, (stiffness, _)| most.max(stiffness))
        };
        (0..pack.mesh().segments()).map(of_segment).fold(0.0, f64::max)
    }

    /// Adds the tangent of the loads, of whose blocks `entry` is the one in a row and a column, times a motion of every joint.
    fn add_loads_times(
        &self,
        motions: &[[f64; 6]],
        product: &mut [[f64; 6]],
        entry: impl Fn(&[[f64; 6]; 6], usize, usize) -> f64,
    ) {
        let active = &self.pattern.equations.active;
        for &node in &self.pattern.loaded_nodes {
            let load = self.load_at(node);
            for &i in active {
                for &j in active {
                    product[load.joint][i] += entry(&load.block, i, j) * motions[load.joint][j];
                }
            }
        }
    }

    /// What is symmetric, the stiffness of members and springs, times a motion of every joint.
    fn parts_times(&mut self, motions: &[[f64; 6]]) -> Vec<[f64; 6]> {
        let pending = std::mem::replace(&mut self.pattern.equations.pending, motions.to_vec());
        let none = Arc::new(self.no_scatters());
        let scatters = std::mem::replace(&mut self.pattern.scatters, none);
        let sums = self.tangent.sums();
        let mut product = vec![[0.0; 6]; motions.len()];
        for index in 0..self.members.count() {
            self.assemble_member(index, true, &mut product);
        }
        for index in 0..self.structure.springs.len() {
            self.assemble_spring(index, true, &mut product);
        }
        (self.pattern.equations.pending, self.pattern.scatters) = (pending, scatters);
        self.tangent.set_sums(sums);
        product
    }

    /// The value of a held row less its target, and its derivatives by the motion of the joint, where the node is at this arm
    /// from its joint.
    pub fn row_at(&self, held: &Held, arm: V3<f64>) -> (f64, [f64; 6]) {
        let joint = self.topology.links[held.node].joint;
        self.pattern.equations.row_at(held, &self.places.joints[joint], arm)
    }

    /// The smallest motion of a joint by which its held rows, by their indices, change so much each and the others not at all;
    /// and the weights of the joint's force in the sum of the reactions along rows, each so many times.
    pub fn along_rows(&self, joint: usize, shares: &[(usize, f64)]) -> [f64; 6] {
        self.pattern.equations.along_rows(&self.topology, joint, &self.places.joints[joint], shares)
    }

    /// The reaction along a held row, by its index, at the last assembly.
    pub fn reaction_along(&self, row: usize) -> f64 {
        let joint = self.topology.links[self.pattern.equations.held[row].node].joint;
        dot6(&self.along_rows(joint, &[(row, 1.0)]), &self.tangent.forces[joint])
    }

    fn no_scatters(&self) -> Scatters {
        Scatters::none(self.members.count(), self.structure.springs.len(), self.places.joints.len())
    }
}
