//! How a solution of the joint equations moves the network.

use std::sync::Arc;

use pennate_elements::beam::Placement;
use pennate_elements::rotation::turn;
use pennate_elements::small::{cross, norm};
use rayon::prelude::*;

use super::System;
use super::carriers::Carrier;
use crate::chain::{Pack, Size};
use crate::joints::EndKind;
use crate::reduce;

impl<const D: usize> System<D> {
    /// Solves for the increment at the last assembly and moves the state by it; `None` where there is no solution.
    pub fn advance(&mut self, pending: bool) -> Option<Size> {
        let mut solution = std::mem::take(&mut self.rhs);
        solution.iter_mut().for_each(|x| *x = -*x);
        let solved = self.solve_in_place(&mut solution);
        let size = solved.then(|| self.move_by(&solution, pending));
        self.rhs = solution;
        size
    }

    /// Moves joints, ends and interiors by a solution of the joint equations.
    ///
    /// Joints that something holds move by the solution; the others go where members carry them, which is the same to
    /// first order.
    pub fn move_by(&mut self, solution: &[f64], pending: bool) -> Size {
        let mut motions = std::mem::take(&mut self.motions);
        for (joint, motion) in motions.iter_mut().enumerate() {
            *motion = self.equations.motion(joint, solution, pending);
        }
        let active = self.equations.active;
        let structure = self.structure.clone();
        let topology = self.topology.clone();
        // Increments of the ends, at the state before the move.
        for index in 0..self.members.len() {
            let [first, last] = structure.members[index].nodes;
            let motion = |node: usize| self.node_motion(&topology.links[node], &motions);
            let moves = [motion(first), motion(last)];
            let kinds = [&topology.ends[index][0], &topology.ends[index][1]];
            let slot = &mut self.members[index];
            let (ends, free) = reduce::recover(&active, kinds, &slot.factor, &moves);
            slot.moves = free;
            self.packs[slot.pack].set_increment(slot.lane, &ends);
        }
        self.for_packs(|pack| pack.advance());
        let mut own = Size::default();
        self.moves.fill(Size::default());
        for (slot, &part) in self.members.iter().zip(&self.parts.members) {
            let pack = &self.packs[slot.pack];
            let whole = pack.size(slot.lane);
            self.moves[part] = self.moves[part].join(whole);
            own = own.join(if slot.released { whole } else { pack.own_size(slot.lane) });
        }
        for ((motion, carried), &part) in motions.iter().zip(&self.carried).zip(&self.parts.joints) {
            let (u, spin) = ([motion[0], motion[1], motion[2]], [motion[3], motion[4], motion[5]]);
            let moved = Size { rotation: norm(spin), displacement: norm(u) / self.size };
            self.moves[part] = self.moves[part].join(moved);
            if !carried {
                own = own.join(moved);
            }
        }
        self.own_size = own;
        let size = self.moves.iter().copied().fold(Size::default(), Size::join);
        self.move_joints(&motions, pending);
        for index in 0..self.members.len() {
            let slot = &self.members[index];
            if !slot.released {
                continue;
            }
            for (end, kind) in topology.ends[index].iter().enumerate() {
                let place = &self.state.joints[topology.links[structure.members[index].nodes[end]].joint].place;
                let after = (place.rotation, place.angle);
                let state = &mut self.state.releases[index][end];
                reduce::move_release(kind, end, &slot.factor, &slot.moves, after, state);
            }
        }
        self.motions = motions;
        self.place_ends();
        if self.straight {
            self.for_packs(|pack| pack.shift());
        } else {
            self.for_packs(|pack| pack.unroll());
        }
        size
    }

    /// Moves the joints: those that something holds by `motions`, the others with what carries them.
    ///
    /// The elements have their new local unknowns already.
    pub(super) fn move_joints(&mut self, motions: &[[f64; 6]], pending: bool) {
        let mut before = std::mem::take(&mut self.scratch);
        before.clear();
        before.extend_from_slice(&self.state.joints);
        for (state, motion) in self.state.joints.iter_mut().zip(motions) {
            state.advance(motion);
        }
        if pending {
            self.equations.enforce(&mut self.state.joints, self.fraction);
        }
        let carriers = if self.straight { Arc::default() } else { Arc::clone(&self.carriers) };
        for &Carrier { joint, member, end } in carriers.iter() {
            let nodes = self.structure.members[member].nodes;
            let links = nodes.map(|n| self.topology.links[n]);
            let from = &self.state.joints[links[1 - end].joint];
            let start = Placement { displacement: from.point(links[1 - end].arm), ..from.place };
            let slot = &self.members[member];
            let place = self.packs[slot.pack].carried(slot.lane, end, &start);
            self.state.joints[joint] = before[joint].carried(&place, links[end].arm, &motions[joint], D == 3);
        }
        self.scratch = before;
    }

    /// Notes what the last increment moved as the first of an iteration.
    pub fn note_first(&mut self) {
        self.own_first = self.own_size.largest();
        self.first_moves.clone_from(&self.moves);
    }

    /// Lets all packs do the same, side by side where that pays.
    pub(super) fn for_packs(&mut self, act: impl Fn(&mut Box<dyn Pack<D>>) + Sync + Send) {
        if self.parallel {
            self.packs.par_iter_mut().for_each(act);
        } else {
            self.packs.iter_mut().for_each(act);
        }
    }

    /// The motion of a node by those of the joints.
    pub fn node_motion(&self, link: &crate::joints::Link, motions: &[[f64; 6]]) -> [f64; 6] {
        let mut motion = motions[link.joint];
        if link.has_arm() {
            let lever = turn(self.state.joints[link.joint].place.rotation, link.arm);
            let shift = cross([motion[3], motion[4], motion[5]], lever);
            for c in 0..3 {
                motion[c] += shift[c];
            }
        }
        motion
    }

    /// Puts the ends of all chains where their joints are.
    pub fn place_ends(&mut self) {
        for index in 0..self.members.len() {
            let slot = &self.members[index];
            for end in 0..2 {
                let link = self.topology.links[self.structure.members[index].nodes[end]];
                let joint = &self.state.joints[link.joint];
                let mut place = joint.place;
                place.displacement = joint.point(link.arm);
                if self.topology.ends[index][end] != EndKind::Welded {
                    let release = &self.state.releases[index][end];
                    place.rotation = release.rotation;
                    place.angle = release.angle;
                }
                self.packs[slot.pack].set_end(slot.lane, end, &place);
            }
        }
    }
}
