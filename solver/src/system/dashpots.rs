//! Dashpots on every node, and the potential of what is conservative: for the flow down the energy; forces on every node and
//! springs on one, for branches along which members bend between their ends.

use pennate_elements::small::{V3, cross, dot, norm, sub};

use super::turning::IN_LINE;
use super::{Places, State, System, Turning};
use crate::chain::{Drawn, InnerNode, PackMesh, any, load_work};
use crate::structure::MemberId;

/// Dashpots between every node and where it was.
#[derive(Debug, Default)]
pub(super) struct Dashpots {
    /// Stiffness for a unit of mass; zero where there are none.
    stiffness: f64,
    /// Where they tie to.
    anchor: Places,
    /// Force on every node for a unit of mass; zero where there is none.
    push: f64,
    /// Packs and lanes of the members that a spring on a node between their ends keeps from turning.
    turns: Vec<[usize; 2]>,
    /// Mass and inertia of the joints; empty until they are asked for.
    masses: Vec<[f64; 2]>,
}

/// Stiffness of a spring that draws a node between the ends of a member, over EI/L³: that of its middle is 48 between hinges
/// and 192 between clamps.
const SPRING: f64 = 100.0;

/// Stiffness of the spring that keeps a member from turning about the axis of its part, for a radian, over the EI/L of its bending. It
/// acts in one component, and what that has across the turn is drawn after in every iteration: one as stiff as bending itself lost
/// a column at 1.02 times its critical load.
const TURN: f64 = 0.25;

/// A node between the ends of a member, and where it is in two states: its displacements, which are those in the frame of the element
/// within elements.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inner {
    pub member: MemberId,
    node: InnerNode,
    /// The component in which it is drawn, and another one where the member bends alike in all directions.
    component: usize,
    other: Option<usize>,
    /// Of the member.
    length: f64,
    from: V3<f64>,
    to: V3<f64>,
}

impl Inner {
    /// How far it is from where it was in its component (lengths of the member).
    pub(crate) fn moved(&self) -> f64 {
        (self.to[self.component] - self.from[self.component]).abs() / self.length
    }

    /// The part of so many times its way that a place of it lies at.
    pub(crate) fn part(&self, place: V3<f64>, times: f64) -> f64 {
        let c = self.component;
        (place[c] - self.from[c]) / (times * (self.to[c] - self.from[c]))
    }

    /// Displacements that it is drawn to, at so many times its way.
    fn drawn(&self, times: f64) -> [Option<f64>; 3] {
        let mut to = [None; 3];
        for c in [Some(self.component), self.other].into_iter().flatten() {
            to[c] = Some(self.from[c] + times * (self.to[c] - self.from[c]));
        }
        to
    }
}

/// The component of a vector that is largest by size.
fn largest(vector: V3<f64>) -> usize {
    (0..3).fold(0, |most, c| if vector[c].abs() > vector[most].abs() { c } else { most })
}

/// Unloaded length of a member.
fn length_of(mesh: &PackMesh, lane: usize) -> f64 {
    (0..mesh.elements()).map(|element| mesh.length(lane, element)).sum()
}

impl<const D: usize> System<D> {
    /// Components of a displacement.
    pub(super) const TRANSLATIONS: usize = if D == 3 { 2 } else { 3 };

    /// Ties every node to where it is in a state, by dashpots of this stiffness for a unit of mass.
    pub(crate) fn set_dashpots(&mut self, stiffness: f64, anchor: &State) {
        self.dashpots.stiffness = stiffness;
        self.dashpots.anchor.clone_from(&anchor.places);
        for (pack, row) in self.members.packs.iter_mut().zip(&anchor.chains) {
            let settings = pack.settings();
            settings.dashpots = stiffness;
            settings.anchor.clone_from(row);
        }
        self.know_masses();
    }

    /// Pushes every node, those within members too, by a force for a unit of mass that singles out no motion; zero ends that.
    pub(crate) fn push(&mut self, force: f64) {
        self.dashpots.push = force;
        self.members.packs.iter_mut().for_each(|pack| pack.settings().push = force);
        self.know_masses();
    }

    /// Draws a node between the ends of a member so many times its way by springs, or none any more.
    pub(crate) fn draw(&mut self, inner: &Inner, times: Option<f64>) {
        let stiffness = SPRING * self.bending_of(inner.member);
        let slot = &self.members.slots[inner.member];
        let (lane, node) = (slot.lane, inner.node);
        let drawn = times.map(|times| Drawn { lane, node, stiffness, to: inner.drawn(times) });
        self.members.packs[slot.pack].settings().drawn = drawn.into_iter().collect();
        self.dashpots.turns.retain(|[pack, _]| *pack != slot.pack);
    }

    /// Resists turning the parts of which nothing but nodes between the ends of members moves in that: by a spring on the one that moves
    /// most, from where it is.
    pub(super) fn resist_turning_inside(&mut self) {
        for [pack, lane] in std::mem::take(&mut self.dashpots.turns) {
            self.members.packs[pack].settings().drawn.retain(|drawn| drawn.lane != lane);
        }
        if self.turning.is_empty() {
            return;
        }
        // Released ends of a part are resisted there: a second spring on the same motion would resist others.
        let by_ends = |part: &Turning| part.members.iter().any(|&own| self.end_turned_most(own, part.axis).is_some());
        let parts = self.turned_inside().into_iter().filter(|part| !by_ends(part));
        let turned: Vec<(Inner, f64)> = parts.filter_map(|part| self.turned_most_inside(part)).collect();
        for (inner, moved) in turned {
            let stiffness = TURN * self.bending_of(inner.member) * (inner.length / moved).powi(2);
            let slot = &self.members.slots[inner.member];
            let (pack, lane, node) = (slot.pack, slot.lane, inner.node);
            let drawn = &mut self.members.packs[pack].settings().drawn;
            if drawn.iter().all(|drawn| drawn.lane != lane) {
                drawn.push(Drawn { lane, node, stiffness, to: inner.drawn(1.0) });
                self.dashpots.turns.push([pack, lane]);
            }
        }
    }

    /// The node between the ends of the members of a part that moves most where that is turned about its axis, the component in which it
    /// does, and by how much for a radian; nothing where none does.
    fn turned_most_inside(&self, part: &Turning) -> Option<(Inner, f64)> {
        let between = |inner: &Inner| matches!(inner.node, InnerNode::Between(_));
        let nodes = part.members.iter().flat_map(|&member| self.nodes_within(member)).filter(between);
        let turned = nodes.map(|inner| (inner, cross(part.axis, inner.to)));
        let (inner, turns) = turned.max_by(|(_, a), (_, b)| norm(*a).total_cmp(&norm(*b)))?;
        let component = largest(turns);
        (norm(turns) > IN_LINE * self.size).then(|| (Inner { component, from: inner.to, ..inner }, turns[component]))
    }

    /// EI/L³ of a member (force per length), with the largest EI that it has and that is not infinite.
    pub(crate) fn bending_of(&self, member: MemberId) -> f64 {
        let (pack, lane) = self.members.chain(member);
        let axes = if D == 3 { 2..3 } else { 4..6 };
        let of_segment = |segment: usize| axes.clone().map(move |axis| (segment, axis));
        let all = (0..pack.mesh().segments()).flat_map(of_segment);
        let all = all.map(|(segment, axis)| pack.segment(lane, segment).stiffness(axis));
        all.filter(|stiffness| stiffness.is_finite()).fold(0.0, f64::max) / length_of(pack.mesh(), lane).powi(3)
    }

    /// The node between the ends of a member that is farthest from where it is in another state, over the length of its member.
    pub(crate) fn farthest_within(&mut self, since: &State) -> Option<Inner> {
        let here = self.snapshot();
        let mut nodes = self.inner_nodes();
        self.restore(since);
        nodes.iter_mut().for_each(|inner| inner.from = self.place_within(inner));
        self.restore(&here);
        let components = |inner: Inner| (0..Self::TRANSLATIONS).map(move |component| Inner { component, ..inner });
        let farthest = nodes.into_iter().flat_map(components).max_by(|a, b| a.moved().total_cmp(&b.moved()))?;
        Some(Inner { other: self.other_component(&farthest), ..farthest })
    }

    /// The component in which a node goes that is turned about the axis of its member, where that is round: it may bend that way as well
    /// as in the component in which it went.
    fn other_component(&self, inner: &Inner) -> Option<usize> {
        let axis = self.round_axis(inner.member)?;
        let axis = if let InnerNode::Between(_) = inner.node { axis } else { [1.0, 0.0, 0.0] };
        let turns = cross(axis, sub(inner.to, inner.from));
        let others = (0..3).filter(|&c| c != inner.component);
        others.max_by(|&a, &b| turns[a].abs().total_cmp(&turns[b].abs()))
    }

    /// The nodes between the ends of all members where they are.
    fn inner_nodes(&self) -> Vec<Inner> {
        (0..self.members.count()).flat_map(|member| self.nodes_within(member)).collect()
    }

    /// The nodes between the ends of a member where they are.
    fn nodes_within(&self, member: MemberId) -> Vec<Inner> {
        let mut nodes = Vec::new();
        let (pack, lane) = self.members.chain(member);
        let length = length_of(pack.mesh(), lane);
        let inner = |node, to| Inner { member, node, component: 0, other: None, length, from: to, to };
        for element in 0..pack.mesh().elements() {
            if element > 0 {
                nodes.push(inner(InnerNode::Between(element), pack.node(lane, element).displacement));
            }
            let local = pack.local(lane, element);
            for (i, u) in local.iter().enumerate().take(pack.mesh().order - 1) {
                let u = if D == 3 { [u[0], u[1], 0.0] } else { [u[0], u[1], u[2]] };
                nodes.push(inner(InnerNode::Within(element, i), u));
            }
        }
        nodes
    }

    /// Where a node between the ends of a member is.
    pub(crate) fn place_within(&self, inner: &Inner) -> V3<f64> {
        let (pack, lane) = self.members.chain(inner.member);
        match inner.node {
            InnerNode::Between(index) => pack.node(lane, index).displacement,
            InnerNode::Within(element, i) => {
                let u = pack.local(lane, element)[i];
                if D == 3 { [u[0], u[1], 0.0] } else { [u[0], u[1], u[2]] }
            }
        }
    }

    fn know_masses(&mut self) {
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

    pub(super) fn assemble_dashpots(&mut self, mut moved: Option<&mut [[f64; 6]]>) {
        let Dashpots { stiffness, push, .. } = self.dashpots;
        if push != 0.0 {
            for (joint, [mass, _]) in self.dashpots.masses.iter().enumerate() {
                for c in 0..6 {
                    let share = if c < 3 { *mass } else { mass * mass };
                    self.tangent.forces[joint][c] += push * any(6 * joint + c) * share;
                }
            }
        }
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
            self.add_joint_block(joint, &block, moved.as_deref_mut());
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
