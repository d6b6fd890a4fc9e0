//! The unknowns of a network over all its nodes, nothing eliminated.
//!
//! First the equations of the joints, in which supports and rigid bodies are met by transformation as in a solve for
//! equilibrium; then the turns of released ends; then six components of every node between the ends of a member.

use pennate_elements::rotation::second_variation;
use pennate_elements::small::{V3, add, cross, scale};

use crate::joints::EndKind;
use crate::reduce::{self, End};
use crate::system::System;

/// One unknown, and the motion of a node that it stands for.
pub(crate) type Column = (usize, [f64; 6]);

/// Part of a motion below which it is rounding.
const ROUNDING: f64 = 1e-9;

/// Which motions of a network are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// All of a spatial network.
    Space,
    /// Of a plane network: in its plane.
    InPlane,
    /// Of a plane network: out of its plane.
    OutOfPlane,
}

/// Numbers of the unknowns of a network.
#[derive(Clone, Debug)]
pub(crate) struct Unknowns {
    /// How many there are.
    pub size: usize,
    /// Free spins of both ends of every member, and their first unknown.
    releases: Vec<[(usize, Vec<V3<f64>>); 2]>,
    /// First unknown of the nodes between the ends of every member.
    inner: Vec<usize>,
}

impl Unknowns {
    /// Numbers the free components of all nodes.
    pub(crate) fn new(system: &System<6>) -> Self {
        let mut size = system.pattern.equations.size;
        let mut releases = Vec::with_capacity(system.members.count());
        for index in 0..system.members.count() {
            let info = system.end_info(index, &system.tangent.ends[index]);
            releases.push(info.map(|end| {
                let mut spins = [[0.0; 3]; 3];
                let count = reduce::free_spins(&system.pattern.equations.active, &end, &mut spins);
                let first = size;
                size += count;
                (first, spins[..count].to_vec())
            }));
        }
        let mut inner = Vec::with_capacity(system.members.count());
        for slot in &system.members.slots {
            let pack = &system.members.packs[slot.pack];
            inner.push(size);
            size += 6 * (pack.mesh().elements() * pack.mesh().order - 1);
        }
        Self { size, releases, inner }
    }

    /// Free spins of an end of a member, and their first unknown.
    pub(crate) fn release(&self, member: usize, end: usize) -> (usize, &[V3<f64>]) {
        let (first, spins) = &self.releases[member][end];
        (*first, spins)
    }

    /// How many unknowns, the first ones, are of joints and released ends.
    pub(crate) fn shared(&self) -> usize {
        self.inner.first().copied().unwrap_or(self.size)
    }

    /// First of the six unknowns of a node between the ends of a member.
    pub(crate) fn inner(&self, member: usize, node: usize) -> usize {
        self.inner[member] + 6 * (node - 1)
    }

    /// Motions of node `node` of a member, counted from its start.
    pub(crate) fn member_node(&self, system: &System<6>, member: usize, node: usize) -> Vec<Column> {
        let slot = &system.members.slots[member];
        let pack = &system.members.packs[slot.pack];
        let last = pack.mesh().elements() * pack.mesh().order;
        let end = match node {
            0 => 0,
            _ if node == last => 1,
            _ => {
                let first = self.inner(member, node);
                let unit = |c: usize| -> [f64; 6] { std::array::from_fn(|i| if i == c { 1.0 } else { 0.0 }) };
                return (0..6).map(|c| (first + c, unit(c))).collect();
            }
        };
        let mut columns = network_node(system, system.structure.members[member].nodes[end]);
        if let EndKind::Free { .. } = system.topology.ends[member][end] {
            for (_, motion) in &mut columns {
                motion[3..].fill(0.0);
            }
        }
        let (first, spins) = self.release(member, end);
        columns.extend(spins.iter().enumerate().map(|(a, s)| (first + a, [0.0, 0.0, 0.0, s[0], s[1], s[2]])));
        columns
    }

    /// Which unknowns belong to a family, numbered anew; `None` where one belongs to both sides of the plane.
    pub(crate) fn of_family(&self, system: &System<6>, family: Family) -> Option<Vec<Option<usize>>> {
        let mut belongs = vec![family == Family::Space; self.size];
        if family != Family::Space {
            let mut judge = |unknown: usize, motion: &[f64; 6]| {
                let part = |components: [usize; 3]| components.iter().fold(0.0f64, |a, &c| a.max(motion[c].abs()));
                let (inside, outside) = (part([0, 1, 5]), part([2, 3, 4]));
                belongs[unknown] = (inside > outside) == (family == Family::InPlane);
                inside.min(outside) <= ROUNDING * inside.max(outside)
            };
            for joint in 0..system.pattern.equations.joints.len() {
                let first = system.pattern.equations.joints[joint].first;
                for (e, motion) in system.pattern.joint_motions(joint).iter().enumerate() {
                    if !judge(first + e, motion) {
                        return None;
                    }
                }
            }
            for (first, spins) in self.releases.iter().flatten() {
                for (a, s) in spins.iter().enumerate() {
                    if !judge(first + a, &[0.0, 0.0, 0.0, s[0], s[1], s[2]]) {
                        return None;
                    }
                }
            }
            let inner = self.shared();
            for unknown in inner..self.size {
                belongs[unknown] = matches!((unknown - inner) % 6, 0 | 1 | 5) == (family == Family::InPlane);
            }
        }
        let mut next = 0;
        let number = belongs.into_iter().map(|belongs| {
            belongs.then(|| {
                next += 1;
                next - 1
            })
        });
        Some(number.collect())
    }
}

/// Motions of a node of the network.
pub(crate) fn network_node(system: &System<6>, node: usize) -> Vec<Column> {
    let link = &system.topology.links[node];
    let lever = system.places.lever(link);
    let first = system.pattern.equations.joints[link.joint].first;
    let motions = system.pattern.joint_motions(link.joint);
    let moved = motions.into_iter().map(|mut motion| {
        let shift = cross([motion[3], motion[4], motion[5]], lever);
        for c in 0..3 {
            motion[c] += shift[c];
        }
        motion
    });
    moved.enumerate().map(|(e, motion)| (first + e, motion)).collect()
}

/// Second variation of the ends of a member against the forces on them: pairs of unknowns with their stiffness.
pub(crate) fn end_curvature(
    system: &System<6>,
    unknowns: &Unknowns,
    member: usize,
    ends: &[[f64; 6]; 2],
    add_entry: &mut impl FnMut(usize, usize, f64),
) {
    let info = system.end_info(member, ends);
    for (end, info) in info.iter().enumerate() {
        let node = system.structure.members[member].nodes[end];
        let joint = system.topology.links[node].joint;
        let first = system.pattern.equations.joints[joint].first;
        let motions = system.pattern.joint_motions(joint);
        lever_curvature(first, &motions, (info.force, info.lever), add_entry);
        add_release_curvature(unknowns.release(member, end), info, first, &motions, add_entry);
    }
}

/// Second variation of a force on a lever of a joint, whose `motions` are the unknowns from `first` on: pairs of unknowns with their
/// stiffness.
pub(super) fn lever_curvature(
    first: usize,
    motions: &[[f64; 6]],
    (force, lever): (V3<f64>, V3<f64>),
    add_entry: &mut impl FnMut(usize, usize, f64),
) {
    if lever == [0.0; 3] {
        return;
    }
    let geometric = second_variation(force, lever);
    for (a, left) in motions.iter().enumerate() {
        for (b, right) in motions.iter().enumerate() {
            let sum: f64 = (0..9).map(|k| left[3 + k / 3] * geometric[k / 3][k % 3] * right[3 + k % 3]).sum();
            add_entry(first + a, first + b, sum);
        }
    }
}

fn add_release_curvature(
    (first_turn, spins): (usize, &[V3<f64>]),
    info: &End<'_>,
    first: usize,
    motions: &[[f64; 6]],
    add_entry: &mut impl FnMut(usize, usize, f64),
) {
    if !matches!(info.kind, EndKind::Axes { .. }) {
        return;
    }
    for (a, axis) in spins.iter().enumerate() {
        let twist = scale(0.5, cross(*axis, info.moment));
        for (b, motion) in motions.iter().enumerate() {
            let value = twist[0] * motion[3] + twist[1] * motion[4] + twist[2] * motion[5];
            add_entry(first_turn + a, first + b, value);
            add_entry(first + b, first_turn + a, value);
        }
        for b in 0..spins.len() {
            add_entry(first_turn + a, first_turn + b, reduce::axes_curvature(info, spins.len(), [a, b]));
        }
    }
}

/// Motion of a node for a vector of unknowns.
pub(crate) fn motion(columns: &[Column], x: &[f64]) -> [f64; 6] {
    columns.iter().fold([0.0; 6], |sum, (unknown, column)| add(sum, scale(x[*unknown], *column)))
}
