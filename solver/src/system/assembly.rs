//! Linearizing everything at a state: members, springs, loads, and what held rows add, into the tangent.

use pennate_elements::small::{M3, V3};

use super::scatter::add_local;
use super::{Inertia, Residual, System};
use crate::chain::MemberEnds;
use crate::reduce::{self, End, Reduced};

impl<const D: usize> System<D> {
    /// Linearizes everything at the present state and factorizes; the residual is in `forces` and `rhs`.
    ///
    /// With `pending` the motion of held components is part of the right-hand side.
    pub fn assemble(&mut self, pending: bool) -> Inertia {
        let within = self.gather(pending);
        let inertia = self.tangent.factorize(within);
        self.tangent.inertia = inertia;
        inertia
    }

    /// The same where nothing but what is held is other than at the last assembly, or at a [`System::refresh`] beside it: members are
    /// left as they are.
    pub fn assemble_joints(&mut self, pending: bool) -> Inertia {
        let within = self.collect(pending);
        let inertia = self.tangent.factorize(within);
        self.tangent.inertia = inertia;
        inertia
    }

    /// Linearizes everything at the present state; pivots are those of the interiors of the members alone.
    pub fn gather(&mut self, pending: bool) -> Inertia {
        self.resist_turning_inside();
        self.members.condense();
        self.collect(pending)
    }

    /// The forces of the present state, by the factors that members have of the one before: for a state that little was moved
    /// since. The stiffness, its factors and its pivots are what they were; whether all members keep factors to go on with is said.
    pub fn refresh(&mut self, pending: bool) -> bool {
        self.resist_turning_inside();
        let keep = self.members.refresh();
        self.refresh_joints(pending);
        keep
    }

    /// The same where members have the forces of the present state.
    pub(crate) fn refresh_joints(&mut self, pending: bool) {
        self.tangent.keeps_matrix = true;
        self.collect(pending);
        self.tangent.keeps_matrix = false;
    }

    /// Puts together what members, springs and loads give.
    fn collect(&mut self, pending: bool) -> Inertia {
        self.begin(pending);
        self.tangent.linearizations += 1;
        let mut moved = std::mem::take(&mut self.moves.motions);
        if pending {
            moved.fill([0.0; 6]);
        }
        // What is still pending moves each part in its own way.
        let moves = pending && self.pattern.equations.pending.iter().flatten().any(|&x| x != 0.0);
        let side = self.pattern.side.clone().filter(|_| !moves && !self.tangent.linear.is_wide());
        self.take_end_forces();
        if let Some(side) = &side {
            self.assemble_side(side);
        }
        for index in 0..self.members.count() {
            let pack = self.members.slots[index].pack;
            if side.as_ref().is_none_or(|side| !side.has(pack)) {
                self.members.ask_for_ends_after(index);
                self.assemble_member(index, pending, &mut moved);
            }
        }
        for index in 0..self.structure.springs.len() {
            self.assemble_spring(index, pending, &mut moved);
        }
        let mut pulled = pending.then_some(&mut moved[..]);
        self.assemble_loads(pulled.as_deref_mut());
        self.assemble_dashpots(pulled.as_deref_mut());
        self.resist_turning();
        self.add_spins_of_joints();
        if self.pattern.equations.has_general() {
            self.find_multipliers();
            self.add_constraint_stiffness(pulled);
        }
        for (joint, force) in self.tangent.forces.iter().enumerate() {
            if self.pattern.equations.holds_all(joint) {
                continue;
            }
            let mut total = *force;
            if pending {
                for c in 0..6 {
                    total[c] += moved[joint][c];
                }
            }
            self.pattern.equations.project(joint, &total, &mut self.tangent.rhs);
        }
        self.moves.motions = moved;
        let (negative, smallest) = self.members.pivots();
        Inertia { negative, smallest, ..Inertia::default() }
    }

    /// Finds the reactions along held rows at the last assembly.
    pub(crate) fn find_multipliers(&mut self) {
        let (joints, fraction) = (&self.places.joints, self.loading.fraction);
        self.pattern.equations.find_multipliers(&self.topology, joints, &self.tangent.forces, fraction);
    }

    /// Residual of the joints at the last assembly, forces and moments apart.
    pub(crate) fn residual(&self) -> Residual {
        self.tangent.residual(&self.pattern, &self.loading, self.size)
    }

    /// The force that the residual of the last assembly may add up to over all joints.
    pub(crate) fn forces_left(&self) -> f64 {
        let (scale, _) = self.tangent.scales(&self.loading, self.size);
        self.residual().force * scale * self.tangent.forces.len() as f64
    }

    /// Brings the equations up to date with the state, with `pending` what is held and not there yet, and empties matrix and forces before an assembly.
    pub(crate) fn begin(&mut self, pending: bool) {
        self.pattern.equations.update(&self.topology, &self.places.joints, self.loading.fraction, pending);
        if !self.tangent.keeps_matrix {
            self.tangent.linear.widen(self.loading.is_diverse());
        }
        self.tangent.clear();
    }

    /// Adds the reduced stiffness of a member.
    pub(crate) fn add_member(&mut self, index: usize, reduced: &Reduced) {
        self.tangent.released_negative += reduced.negative;
        self.tangent.released_neutral += reduced.neutral;
        self.scatter_member(index, reduced);
    }

    /// Adds the reduced stiffness of a member to the matrix alone.
    pub(super) fn scatter_member(&mut self, index: usize, reduced: &Reduced) {
        if self.tangent.keeps_matrix {
            return;
        }
        let joints = self.structure.members[index].nodes.map(|n| self.topology.links[n].joint);
        let scatters = &*self.pattern.scatters;
        let scatter = (scatters, &scatters.members[index]);
        add_local(&self.pattern.equations, reduced, &joints, scatter, &mut self.tangent.linear);
    }

    /// Adds springs, loads and the curvature of constraints, those of the plane system included.
    pub(crate) fn add_springs_and_loads(&mut self, plane: Option<&Self>) {
        let mut unused = std::mem::take(&mut self.moves.motions);
        for index in 0..self.structure.springs.len() {
            self.assemble_spring(index, false, &mut unused);
        }
        self.moves.motions = unused;
        self.assemble_loads(None);
        let Some(plane) = plane else { return };
        let equations = &plane.pattern.equations;
        // In the plane an angle is a component of its own; out of it, the moment that holds one turns with the joint.
        let is_curved = |joint: &usize| equations.is_general(*joint) || equations.holds_a_rotation(*joint);
        for joint in (0..equations.joints.len()).filter(is_curved) {
            let state = &plane.places.joints[joint];
            let extra = equations.constraint_stiffness(&plane.topology, joint, state, plane.loading.fraction);
            self.add_joint_block(joint, &spin_block(&extra), None);
        }
    }

    /// Factorizes what was assembled; `within` is that of the interiors of the members.
    pub(crate) fn finish(&mut self, within: Inertia) -> Inertia {
        self.tangent.factorize(within)
    }

    /// The ends of a member as the reduction needs them, under these forces on them.
    pub(crate) fn end_info<'a>(&'a self, index: usize, ends: &[[f64; 6]; 2]) -> [End<'a>; 2] {
        let nodes = self.structure.members[index].nodes;
        std::array::from_fn(|end| {
            let link = &self.topology.links[nodes[end]];
            let [f0, f1, f2, m0, m1, m2] = ends[end];
            End {
                kind: &self.topology.ends[index][end],
                release: &self.places.releases[index][end],
                joint_rotation: self.places.joints[link.joint].place.rotation,
                lever: self.places.lever(link),
                tangent: self.members.slots[index].tangents[end],
                force: [f0, f1, f2],
                moment: [m0, m1, m2],
            }
        })
    }

    /// Takes the forces on the ends of all members as elimination left them; what is no component of the network stays zero.
    pub(super) fn take_end_forces(&mut self) {
        let active = self.pattern.equations.active;
        for pack in &self.members.packs {
            pack.put_end_forces(&active, &mut self.tangent.ends);
        }
    }

    /// Adds a member to the equations, whose end forces are known.
    pub(super) fn assemble_member(&mut self, index: usize, pending: bool, moved: &mut [[f64; 6]]) {
        let active = self.pattern.equations.active;
        for end in 0..2 {
            let forces = self.tangent.ends[index][end];
            let mut squares = [0.0; 2];
            for i in active {
                squares[usize::from(i >= 3)] += forces[i] * forces[i];
            }
            self.tangent.note_squares(squares);
        }
        let [first, last] = self.structure.members[index].nodes;
        let links = [&self.topology.links[first], &self.topology.links[last]];
        let joints = [links[0].joint, links[1].joint];
        let released = self.members.slots[index].released;
        if self.is_plain(index) {
            for end in 0..2 {
                let forces = self.tangent.ends[index][end];
                let sum = &mut self.tangent.forces[joints[end]];
                for i in active {
                    sum[i] += forces[i];
                }
            }
            if pending || !self.tangent.keeps_matrix {
                self.assemble_plain(index, joints, pending, moved);
            }
            return;
        }
        let moves = pending && joints.iter().any(|&joint| self.pattern.equations.pending[joint] != [0.0; 6]);
        if self.tangent.keeps_matrix && !released && !moves {
            self.assemble_forces(index, &self.levers(index));
            return;
        }
        if self.pattern.in_blocks && !released && !moves && self.pattern.scatters.members[index].is_plain {
            self.assemble_carried(index, joints);
            return;
        }
        let mut ends = self.members.condensed(index);
        if released {
            self.resist_turning_of_member(index, &mut ends);
            self.add_spins_of_member(index, &mut ends);
        }
        // Few members have a factor, and those that have none should not pay for its copies.
        let mut factor = released.then(|| self.tangent.releases[index]);
        let mut info = self.end_info(index, &self.tangent.ends[index]);
        // What turns with an arm, as what turns with an element, is what the mixed stresses make: where a state is far from
        // equilibrium the others are those of strains that only the extrapolation left.
        let (pack, lane) = self.members.chain(index);
        let mixed = pack.mixed_forces(lane);
        for (end, info) in info.iter_mut().enumerate().filter(|(end, _)| links[*end].has_arm()) {
            for (i, &component) in active.iter().enumerate().filter(|(_, component)| **component < 3) {
                info.force[component] = mixed[end][i];
            }
        }
        let reduced = reduce::reduce(&ends, &active, &info, factor.as_mut());
        if let Some(factor) = factor {
            self.tangent.releases[index] = factor;
            if reduced.neutral > 0 {
                self.tangent.idle_members.push(index);
            }
        }
        self.add_reduced(&reduced, joints, pending, moved);
        self.add_member(index, &reduced);
    }

    /// Whether the ends of a member are those of its joints, whose components are free or held each by itself.
    pub(crate) fn is_plain(&self, index: usize) -> bool {
        let arms = self.structure.members[index].nodes.iter().any(|&node| self.topology.links[node].has_arm());
        self.pattern.scatters.members[index].is_plain && !self.members.slots[index].released && !arms
    }

    /// From the joints of a member to its ends, turned.
    fn levers(&self, index: usize) -> [V3<f64>; 2] {
        self.structure.members[index].nodes.map(|node| self.places.lever(&self.topology.links[node]))
    }

    /// Adds the forces of a welded member alone to its joints, which may carry it by arms.
    fn assemble_forces(&mut self, index: usize, levers: &[V3<f64>; 2]) {
        let active = self.pattern.equations.active;
        let joints = self.structure.members[index].nodes.map(|node| self.topology.links[node].joint);
        for (end, lever) in levers.iter().enumerate() {
            let own = active.map(|component| self.tangent.ends[index][end][component]);
            let on_joint = reduce::on_joint(&active, *lever, own);
            let sum = &mut self.tangent.forces[joints[end]];
            for i in 0..D {
                sum[active[i]] += on_joint[i];
            }
        }
    }

    /// Adds a welded member whose joints carry it by arms, block by block: what [`reduce::reduce`] makes of it, but for rounding.
    fn assemble_carried(&mut self, index: usize, joints: [usize; 2]) {
        let active = self.pattern.equations.active;
        let levers = self.levers(index);
        let mut ends = self.members.condensed(index);
        let (pack, lane) = self.members.chain(index);
        let mixed = pack.mixed_forces(lane);
        for end in 0..2 {
            if levers[end] != [0.0; 3] {
                reduce::carry(&mut ends, &active, end, levers[end], &mixed[end]);
            }
        }
        self.assemble_forces(index, &levers);
        for i in 0..D {
            self.tangent.stiffness[joints[0]][active[i]] += ends.k00[i][i];
            self.tangent.stiffness[joints[1]][active[i]] += ends.k11[i][i];
        }
        self.scatter_plain(index, &ends);
    }

    /// Adds the stiffness of a member whose ends are those of its joints: there is nothing to reduce.
    fn assemble_plain(&mut self, index: usize, joints: [usize; 2], pending: bool, moved: &mut [[f64; 6]]) {
        let ends = self.members.condensed(index);
        let active = self.pattern.equations.active;
        if pending {
            for (from, &at) in joints.iter().enumerate() {
                let motion = self.pattern.equations.pending[at];
                if motion.iter().all(|&x| x == 0.0) {
                    continue;
                }
                for (i, &row) in active.iter().enumerate() {
                    for (j, &column) in active.iter().enumerate() {
                        let [first, last] =
                            if from == 0 { [ends.k00[i][j], ends.k01[j][i]] } else { [ends.k01[i][j], ends.k11[i][j]] };
                        moved[joints[0]][row] += first * motion[column];
                        moved[joints[1]][row] += last * motion[column];
                    }
                }
            }
        }
        if self.tangent.keeps_matrix {
            return;
        }
        for i in 0..D {
            self.tangent.stiffness[joints[0]][active[i]] += ends.k00[i][i];
            self.tangent.stiffness[joints[1]][active[i]] += ends.k11[i][i];
        }
        self.scatter_plain(index, &ends);
    }

    /// Adds the stiffness of the ends of a member that are those of its joints to the matrix alone.
    pub(crate) fn scatter_plain(&mut self, index: usize, ends: &MemberEnds<D>) {
        let blocks = [ends.k00.as_flattened(), ends.k01.as_flattened(), ends.k11.as_flattened()];
        let linear = &mut self.tangent.linear;
        if linear.is_wide() {
            for (block, places) in blocks.into_iter().zip(&self.pattern.scatters.members[index].plain) {
                places.iter().for_each(|&(place, position)| linear.add(position as usize, block[usize::from(place)]));
            }
            return;
        }
        let values = &mut linear.values;
        for (kind, places) in self.pattern.scatters.members[index].plain.iter().enumerate() {
            let block = blocks[kind];
            for &(place, position) in places {
                values[position as usize] += block[usize::from(place)];
            }
        }
    }

    /// Adds the force of a reduced member to its joints, and what pending motions make of its stiffness.
    pub(super) fn add_reduced(&mut self, reduced: &Reduced, joints: [usize; 2], pending: bool, moved: &mut [[f64; 6]]) {
        let active = self.pattern.equations.active;
        for end in 0..2 {
            for (i, &component) in active.iter().enumerate() {
                let row = end * D + i;
                self.tangent.forces[joints[end]][component] += reduced.force[row];
                if !self.tangent.keeps_matrix {
                    self.tangent.stiffness[joints[end]][component] += reduced.stiffness[row][row];
                }
            }
        }
        if !pending {
            return;
        }
        for from in 0..2 {
            let motion = self.pattern.equations.pending[joints[from]];
            if motion == [0.0; 6] {
                continue;
            }
            for to in 0..2 {
                for (i, &row) in active.iter().enumerate() {
                    for (j, &column) in active.iter().enumerate() {
                        moved[joints[to]][row] += reduced.stiffness[to * D + i][from * D + j] * motion[column];
                    }
                }
            }
        }
    }

    /// Adds what forces that hold a joint by an arm do where it turns; to `moved` what they do where it turns by what is pending.
    pub(super) fn add_constraint_stiffness(&mut self, mut moved: Option<&mut [[f64; 6]]>) {
        for joint in 0..self.pattern.equations.joints.len() {
            let equations = &self.pattern.equations;
            if !equations.is_general(joint) {
                continue;
            }
            let state = &self.places.joints[joint];
            let extra = equations.constraint_stiffness(&self.topology, joint, state, self.loading.fraction);
            self.add_joint_block(joint, &spin_block(&extra), moved.as_deref_mut());
        }
    }
}

/// A 3 × 3 block on the spins of a joint.
fn spin_block(a: &M3<f64>) -> [[f64; 6]; 6] {
    std::array::from_fn(|i| std::array::from_fn(|j| if i >= 3 && j >= 3 { a[i - 3][j - 3] } else { 0.0 }))
}
