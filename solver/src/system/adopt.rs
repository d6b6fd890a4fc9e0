//! The state of a system taken over by one of the same topology and mesh whose numbers are others.

use super::System;
use crate::chain::adopt;
use crate::joints::{EndKind, Held};

impl<const D: usize> System<D> {
    /// Takes over the state of a system with the same joints, members and elements, number by number: displacements,
    /// rotations, local unknowns and stresses. Geometry, sections and loads may differ, and stay.
    ///
    /// What nodes move by is kept, and not where they are: the state of an equilibrium is next to that of another one where
    /// the numbers of both are.
    pub fn adopt(&mut self, other: &Self) {
        self.places.copy_from(&other.places);
        (self.loading.prestress, self.loading.fraction) = (other.loading.prestress, other.loading.fraction);
        for pack in &mut self.members.packs {
            for (lane, member) in pack.mesh().members.clone().into_iter().enumerate() {
                let (from, theirs) = other.members.chain(member);
                adopt(pack.as_mut(), lane, from, theirs);
            }
        }
        self.turn_released_ends();
        self.place_ends();
    }

    /// Turns released ends from their joints by the turns about their axes: axes of another design take them elsewhere.
    pub(super) fn turn_released_ends(&mut self) {
        for (index, member) in self.structure.members.iter().enumerate() {
            for (end, release) in self.places.releases[index].iter_mut().enumerate() {
                if let EndKind::Axes { axes, .. } = &self.topology.ends[index][end] {
                    let place = &self.places.joints[self.topology.links[member.nodes[end]].joint].place;
                    release.turn_from(axes, (place.rotation, place.angle));
                }
            }
        }
    }

    /// Takes over the state of one of the designs that another system has side by side: from so many nodes and members on. False,
    /// with nothing changed, where its joints are not those of this system.
    pub fn adopt_part(&mut self, other: &Self, nodes: usize, members: usize) -> bool {
        let joint = |&node: &usize| other.topology.links[node + nodes].joint;
        let joints: Vec<usize> = self.topology.references.iter().map(joint).collect();
        let alike = |(&own, &joint): (&usize, &usize)| other.topology.references[joint] == own + nodes;
        if !self.topology.references.iter().zip(&joints).all(alike) {
            return false;
        }
        for (own, &joint) in self.places.joints.iter_mut().zip(&joints) {
            *own = other.places.joints[joint];
        }
        let releases = &other.places.releases[members..members + self.places.releases.len()];
        self.places.releases.copy_from_slice(releases);
        (self.loading.prestress, self.loading.fraction) = (other.loading.prestress, other.loading.fraction);
        for pack in &mut self.members.packs {
            for (lane, member) in pack.mesh().members.clone().into_iter().enumerate() {
                let (from, theirs) = other.members.chain(member + members);
                adopt(pack.as_mut(), lane, from, theirs);
            }
        }
        self.place_ends();
        true
    }

    /// Holds what another system of the same joints holds, with rows and drives of its own; the state is that at the end of
    /// a step.
    pub fn stand_at_end(&mut self, other: &Self, held: Vec<Held>, drives: &[f64]) {
        self.hold_like(other);
        self.hold(held);
        self.loading.fading.clear();
        self.loading.end(drives);
        self.apply_drives();
    }
}
