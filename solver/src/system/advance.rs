//! How a solution of the joint equations moves the network.

use std::sync::Arc;

use pennate_elements::beam::Placement;
use pennate_elements::small::norm;

use super::System;
use super::carriers::Carrier;
use crate::chain::{MemberEnds, NodesBy, Size};
use crate::reduce::{self, MAX_FREE};

impl<const D: usize> System<D> {
    /// Solves for the increment at the last assembly and moves the state by it; `None` where there is no solution.
    pub fn advance(&mut self, pending: bool) -> Option<Size> {
        let mut solution = std::mem::take(&mut self.tangent.rhs);
        solution.iter_mut().for_each(|x| *x = -*x);
        let solved = self.tangent.solve(&mut solution);
        let size = solved.then(|| self.move_by(&solution, pending));
        self.tangent.rhs = solution;
        size
    }

    /// Moves joints, ends and interiors by a solution of the joint equations.
    ///
    /// Joints that something holds move by the solution; the others go where members carry them, which is the same to
    /// first order.
    pub fn move_by(&mut self, solution: &[f64], pending: bool) -> Size {
        let mut motions = std::mem::take(&mut self.moves.motions);
        for (joint, motion) in motions.iter_mut().enumerate() {
            *motion = self.pattern.equations.motion(joint, solution, pending);
        }
        self.move_interiors(&motions);
        self.measure(&motions);
        self.moves.turn = self.turned_by(solution);
        self.move_joints(&motions, pending);
        self.move_releases();
        self.moves.motions = motions;
        self.place_ends();
        let by = if self.straight { NodesBy::Increments } else { NodesBy::Elements };
        self.members.place_nodes(by);
        self.moves.size()
    }

    /// Corrects the forces on ends and joints, to first order, by what the last assembly left out of balance: by the move that would
    /// follow, which is not made.
    ///
    /// Places have 16 digits, and a member that can hardly be stretched makes forces of what they round: 10⁻¹⁶ of its stiffness.
    /// Forces in balance are free of that. Where there is no solution, nothing changes.
    pub fn correct_forces(&mut self, pending: bool) {
        let mut solution: Vec<f64> = self.tangent.rhs.iter().map(|x| -x).collect();
        if !self.tangent.solve(&mut solution) || solution.iter().any(|x| !x.is_finite()) {
            return;
        }
        let motion = |joint: usize| self.pattern.equations.motion(joint, &solution, pending);
        let motions: Vec<[f64; 6]> = (0..self.places.joints.len()).map(motion).collect();
        let changes = self.times(&motions);
        for (force, change) in self.tangent.forces.iter_mut().flatten().zip(changes.iter().flatten()) {
            *force += change;
        }
        for index in 0..self.members.count() {
            let ends = self.moved_ends(index, &motions);
            self.tangent.ends[index] = ends;
            self.tangent.releases[index].settle();
        }
    }

    /// Forces and moments on the ends of a member whose joints move like this, to first order.
    fn moved_ends(&self, index: usize, motions: &[[f64; 6]]) -> [[f64; 6]; 2] {
        let ([first, last], _) = self.end_motions(index, motions);
        let MemberEnds { k00, k01, k11, .. } = self.members.condensed(index);
        let [mut start, mut end] = self.tangent.ends[index];
        for (i, &component) in self.pattern.equations.active.iter().enumerate() {
            for j in 0..D {
                start[component] += k00[i][j] * first[j] + k01[i][j] * last[j];
                end[component] += k01[j][i] * first[j] + k11[i][j] * last[j];
            }
        }
        [start, end]
    }

    /// Forces and moments on the ends of all members: of those that are released when nothing turns their ends any further, as in the forces of
    /// joints. A stiff one makes a force of what rounding and the iteration left of that turn.
    pub(crate) fn settled_ends(&self) -> Vec<[[f64; 6]; 2]> {
        let still = vec![[0.0; 6]; self.places.joints.len()];
        let settled = |(index, ends): (usize, &[[f64; 6]; 2])| {
            if self.members.slots[index].released { self.moved_ends(index, &still) } else { *ends }
        };
        self.tangent.ends.iter().enumerate().map(settled).collect()
    }

    /// What the ends of a member move by where joints move like this, and its released rotations, where it has any.
    pub(super) fn end_motions(&self, index: usize, motions: &[[f64; 6]]) -> ([[f64; D]; 2], Option<[f64; MAX_FREE]>) {
        let active = &self.pattern.equations.active;
        let moves =
            self.structure.members[index].nodes.map(|n| self.places.motion_of(&self.topology.links[n], motions));
        if self.members.slots[index].released {
            let kinds = self.topology.ends[index].each_ref();
            let (ends, released) = reduce::recover(active, kinds, &self.tangent.releases[index], &moves);
            return (ends, Some(released));
        }
        (moves.map(|motion| active.map(|component| motion[component])), None)
    }

    /// Moves what is between the ends of members, by motions of the joints from the state before the move.
    pub(super) fn move_interiors(&mut self, motions: &[[f64; 6]]) {
        let side = self.pattern.side.clone();
        if let Some(side) = &side {
            self.fill_side(side, motions);
        }
        for index in 0..self.members.count() {
            if side.as_ref().is_some_and(|side| side.has(self.members.slots[index].pack)) {
                continue;
            }
            let (ends, released) = self.end_motions(index, motions);
            if let Some(released) = released {
                self.moves.releases[index] = released;
            }
            self.members.set_motions(index, &ends);
        }
        let (members, rows) = (&mut self.members, self.side_rows.motions());
        members.advance(|pack| side.as_ref()?.joints_of(pack).map(|joints| (rows, joints)));
    }

    /// Measures how far members and joints move.
    fn measure(&mut self, motions: &[[f64; 6]]) {
        let Self { members, moves, pattern, .. } = self;
        let mut own = Size::default();
        moves.by_part.fill(Size::default());
        for (slot, &part) in members.slots.iter().zip(&pattern.parts.members) {
            let pack = &members.packs[slot.pack];
            let [whole, without_start] = pack.sizes(slot.lane);
            moves.by_part[part] = moves.by_part[part].join(whole);
            own = own.join(if slot.released { whole } else { without_start });
        }
        let joints = motions.iter().zip(&pattern.carried).zip(&pattern.parts.joints);
        for ((motion, carried), &part) in joints.filter(|((motion, _), _)| **motion != [0.0; 6]) {
            let (u, spin) = ([motion[0], motion[1], motion[2]], [motion[3], motion[4], motion[5]]);
            let moved = Size { rotation: norm(spin), displacement: norm(u) / self.size };
            moves.by_part[part] = moves.by_part[part].join(moved);
            if !carried {
                own = own.join(moved);
            }
        }
        moves.own = own;
    }

    /// The largest angle by which a solution turns a joint that no member carries: what carries a joint follows it through any turn.
    fn turned_by(&self, solution: &[f64]) -> f64 {
        let uncarried = self.pattern.carried.iter().enumerate().filter(|(_, carried)| !**carried);
        let turn = |(joint, _): (usize, &bool)| {
            let [.., x, y, z] = self.pattern.equations.motion(joint, solution, false);
            norm([x, y, z])
        };
        uncarried.map(turn).fold(0.0, f64::max)
    }

    /// Moves the joints: those that something holds by `motions`, the others with what carries them.
    ///
    /// The elements have their new local unknowns already.
    pub(super) fn move_joints(&mut self, motions: &[[f64; 6]], pending: bool) {
        let all = self.places.joints.iter_mut().zip(motions).zip(&self.pattern.carried);
        for ((state, motion), _) in all.filter(|(_, carried)| self.straight || !**carried) {
            state.advance(motion);
        }
        if pending {
            self.pattern.equations.enforce(&mut self.places.joints, self.loading.fraction);
        }
        let carriers = if self.straight { Arc::default() } else { Arc::clone(&self.pattern.carriers) };
        for &Carrier { joint, member, end } in carriers.iter() {
            let nodes = self.structure.members[member].nodes;
            let links = nodes.map(|n| self.topology.links[n]);
            let from = &self.places.joints[links[1 - end].joint];
            let start = Placement { displacement: from.point(links[1 - end].arm), ..from.place };
            let (pack, lane) = self.members.chain(member);
            let place = pack.carried(lane, end, &start);
            let state = &mut self.places.joints[joint];
            *state = state.carried(&place, links[end].arm, &motions[joint], D == 3);
        }
    }

    /// Moves released ends, once their joints are where they are.
    pub(super) fn move_releases(&mut self) {
        for index in (0..self.members.count()).filter(|&index| self.members.slots[index].released) {
            let (factor, moves) = (&self.tangent.releases[index], &self.moves.releases[index]);
            for (end, kind) in self.topology.ends[index].iter().enumerate() {
                let node = self.structure.members[index].nodes[end];
                let place = &self.places.joints[self.topology.links[node].joint].place;
                let after = (place.rotation, place.angle);
                let state = &mut self.places.releases[index][end];
                reduce::move_release(kind, end, factor, moves, after, state);
            }
        }
    }
}
