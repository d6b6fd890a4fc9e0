//! The network as joints and member ends; motions that no force belongs to.
//!
//! Theory: docs/theory/joints.md, motions that nothing resists.

use pennate_elements::small::{V3, cross, norm, sub};

use super::{PARALLEL, Turned};
use crate::structure::{NodeId, Release, Structure};

/// Where a node sits: its joint, and its unloaded position against the joint's reference node.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    /// Index of the joint.
    pub joint: usize,
    /// From the reference of the joint to the node, unloaded, in global axes.
    pub arm: V3<f64>,
}

impl Link {
    /// Whether the node is not the reference.
    #[inline]
    pub fn has_arm(&self) -> bool {
        self.arm.iter().any(|&x| x != 0.0)
    }
}

/// Connection of a member's end, motions that no force belongs to taken out.
#[derive(Clone, Debug, PartialEq)]
pub enum EndKind {
    /// The end turns with the joint.
    Welded,
    /// The end turns freely; with `spin_removed` not about the member itself.
    Free {
        /// Whether the end is kept from turning about the member itself.
        spin_removed: bool,
    },
    /// Free about axes that turn with the joint.
    Axes(Vec<V3<f64>>),
}

/// The network as joints and member ends.
#[derive(Clone, Debug)]
pub struct Topology {
    /// Where every node sits.
    pub links: Vec<Link>,
    /// Reference node of every joint.
    pub references: Vec<NodeId>,
    /// Connections of both ends of every member.
    pub ends: Vec<[EndKind; 2]>,
    /// Motions of joints that no force belongs to: rotation as a whole, or spin about one axis.
    pub idle: Vec<Idle>,
}

/// A motion of a joint that no force belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Idle {
    /// There is none.
    None,
    /// The joint has no rotation of its own.
    Rotation,
    /// It does not turn about this axis (global, unloaded, carried along).
    Spin(V3<f64>),
}

fn parallel(a: V3<f64>, b: V3<f64>) -> bool {
    norm(cross(a, b)) < PARALLEL * norm(a) * norm(b)
}

/// Members at every joint, and with which end, joint after joint.
struct Attached {
    starts: Vec<usize>,
    ends: Vec<(usize, usize)>,
}

impl Attached {
    fn of(structure: &Structure, topology: &Topology) -> Self {
        let joint = |node: NodeId| topology.links[node].joint;
        let mut starts = vec![0; topology.references.len() + 1];
        structure.members.iter().flat_map(|member| member.nodes).for_each(|node| starts[joint(node) + 1] += 1);
        for index in 1..starts.len() {
            starts[index] += starts[index - 1];
        }
        let mut next = starts.clone();
        let mut ends = vec![(0, 0); 2 * structure.members.len()];
        for (index, member) in structure.members.iter().enumerate() {
            for (end, &node) in member.nodes.iter().enumerate() {
                let place = &mut next[joint(node)];
                ends[*place] = (index, end);
                *place += 1;
            }
        }
        Self { starts, ends }
    }

    fn at(&self, joint: usize) -> &[(usize, usize)] {
        &self.ends[self.starts[joint]..self.starts[joint + 1]]
    }
}

impl Topology {
    /// Whether joints have the same nodes and the same idle motions as those of another structure: rows that hold components one by
    /// one leave them the same ones free.
    pub(crate) fn moves_like(&self, other: &Self) -> bool {
        let same = |(a, b): (&Link, &Link)| a.joint == b.joint && a.has_arm() == b.has_arm();
        self.idle == other.idle
            && self.links.len() == other.links.len()
            && self.links.iter().zip(&other.links).all(same)
    }

    /// `turned` tells of every node what acts on its rotation.
    pub(crate) fn new(structure: &Structure, turned: &[Turned]) -> Self {
        let count = structure.nodes.len();
        let mut reference: Vec<NodeId> = (0..count).collect();
        for body in &structure.bodies {
            for &node in &body.nodes {
                reference[node] = body.reference;
            }
            reference[body.reference] = body.reference;
        }
        let mut references = Vec::new();
        let mut joint_of = vec![usize::MAX; count];
        for node in 0..count {
            if reference[node] == node {
                joint_of[node] = references.len();
                references.push(node);
            }
        }
        let links: Vec<Link> = (0..count)
            .map(|node| {
                let home = reference[node];
                Link { joint: joint_of[home], arm: sub(structure.nodes[node], structure.nodes[home]) }
            })
            .collect();

        let ends: Vec<[EndKind; 2]> = structure
            .members
            .iter()
            .map(|member| {
                std::array::from_fn(|end| match &member.releases[end] {
                    Release::Welded => EndKind::Welded,
                    Release::Pin => EndKind::Free { spin_removed: false },
                    Release::Axes(axes) if axes.len() >= 3 => EndKind::Free { spin_removed: false },
                    Release::Axes(axes) => EndKind::Axes(axes.clone()),
                })
            })
            .collect();
        let mut topology = Self { idle: vec![Idle::None; references.len()], links, references, ends };
        let attached = Attached::of(structure, &topology);
        let engaged = topology.rotation_engaged(structure);
        topology.free_lone_ends(turned, &attached, &engaged);
        topology.remove_idle_joints(turned, &attached, &engaged);
        topology.remove_idle_spins(structure, turned, &attached, &engaged);
        topology
    }

    /// Whether bodies or springs engage the rotation of joints.
    fn rotation_engaged(&self, structure: &Structure) -> Vec<bool> {
        let mut engaged = vec![false; self.references.len()];
        for body in &structure.bodies {
            engaged[self.links[body.reference].joint] |= body.nodes.len() > 1;
        }
        for spring in &structure.springs {
            for (&node, turns) in spring.nodes().iter().zip(spring.engages()) {
                engaged[self.links[node].joint] |= turns;
            }
        }
        engaged
    }

    /// An end with released axes that shares its joint with pinned ends alone takes no moment at all.
    fn free_lone_ends(&mut self, turned: &[Turned], attached: &Attached, engaged: &[bool]) {
        for joint in 0..self.references.len() {
            let takes = |&&(member, end): &&(usize, usize)| !matches!(self.ends[member][end], EndKind::Free { .. });
            let mut taking = attached.at(joint).iter().filter(takes);
            if let (Some(&(member, end)), None) = (taking.next(), taking.next())
                && !engaged[joint]
                && turned[self.references[joint]].is_left_alone()
                && matches!(self.ends[member][end], EndKind::Axes(_))
            {
                self.ends[member][end] = EndKind::Free { spin_removed: false };
            }
        }
    }

    fn remove_idle_joints(&mut self, turned: &[Turned], attached: &Attached, engaged: &[bool]) {
        for joint in 0..self.references.len() {
            if engaged[joint] {
                continue;
            }
            let mut axis: Option<V3<f64>> = None;
            let mut common = true;
            let mut welded = false;
            for &(member, end) in attached.at(joint) {
                match &self.ends[member][end] {
                    EndKind::Welded => welded = true,
                    EndKind::Free { .. } => {}
                    EndKind::Axes(axes) if axes.len() == 1 => match axis {
                        None => axis = Some(axes[0]),
                        Some(other) => common &= parallel(other, axes[0]),
                    },
                    EndKind::Axes(_) => common = false,
                }
            }
            let turned = &turned[self.references[joint]];
            self.idle[joint] = match (welded, common, axis) {
                (true, ..) | (_, false, _) => Idle::None,
                (false, true, None) if turned.moments.is_empty() => Idle::Rotation,
                (false, true, Some(axis)) if !turned.keeps_spin(axis) => Idle::Spin(axis),
                _ => Idle::None,
            };
        }
    }

    /// A straight line of bars that nothing keeps from spinning about itself is kept from it at one end.
    ///
    /// Bars of a line are joined rigidly, or at least about the line, at joints where nothing else takes a torque; at
    /// its ends stand released ends, or joints whose rotation is free.
    fn remove_idle_spins(&mut self, structure: &Structure, turned: &[Turned], attached: &Attached, engaged: &[bool]) {
        let straight = |index: usize| structure.members[index].segments.iter().all(|s| s.initial_curvature == [0.0; 3]);
        let mut seen = vec![false; structure.members.len()];
        // The line that a bar was last put into, by its first bar.
        let mut line_of = vec![usize::MAX; structure.members.len()];
        // Bars of the line; ends at which the spin is free, and joints that spin with it.
        let (mut line, mut free_ends, mut free_joints) = (Vec::new(), Vec::new(), Vec::new());
        for index in 0..structure.members.len() {
            if seen[index] || !straight(index) {
                continue;
            }
            let axis = structure.members[index].axes[0];
            let spins = |kind: &EndKind| match kind {
                EndKind::Welded => false,
                EndKind::Free { .. } => true,
                EndKind::Axes(axes) => axes.iter().any(|a| parallel(*a, axis)),
            };
            line.clear();
            free_ends.clear();
            free_joints.clear();
            line.push(index);
            line_of[index] = index;
            let mut spinning = true;
            let mut next = 0;
            while let Some(&bar) = line.get(next) {
                next += 1;
                seen[bar] = true;
                for end in 0..2 {
                    if spins(&self.ends[bar][end]) {
                        free_ends.push((bar, end));
                        continue;
                    }
                    let joint = self.links[structure.members[bar].nodes[end]].joint;
                    let taking = attached.at(joint).iter().filter(|&&(m, e)| !spins(&self.ends[m][e]));
                    let in_line = |m: usize| straight(m) && parallel(structure.members[m].axes[0], axis);
                    if engaged[joint]
                        || turned[self.references[joint]].acts_about(axis)
                        || !taking.clone().all(|&(member, _)| in_line(member))
                    {
                        spinning = false;
                        continue;
                    }
                    if taking.clone().count() == 1 && self.idle[joint] == Idle::None {
                        free_joints.push(joint);
                    }
                    for &(member, _) in taking {
                        if line_of[member] != index {
                            line_of[member] = index;
                            line.push(member);
                        }
                    }
                }
            }
            if !spinning {
                continue;
            }
            if let Some(&(bar, end)) = free_ends.first() {
                match &mut self.ends[bar][end] {
                    EndKind::Free { spin_removed } => *spin_removed = true,
                    EndKind::Axes(axes) => {
                        axes.retain(|a| !parallel(*a, axis));
                        if axes.is_empty() {
                            self.ends[bar][end] = EndKind::Welded;
                        }
                    }
                    EndKind::Welded => {}
                }
            } else if let Some(&joint) = free_joints.first() {
                self.idle[joint] = Idle::Spin(axis);
            }
        }
    }
}
