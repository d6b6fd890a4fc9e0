//! The network as joints and member ends.
//!
//! Theory: docs/theory/joints.md, motions that nothing resists.

use pennate_elements::small::{V3, sub};

use super::{Idle, Turned};
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
    Axes {
        /// One axis, or two.
        axes: Vec<V3<f64>>,
        /// The one that lies along the member, where the end is kept from turning about that for now.
        kept: Option<usize>,
    },
}

impl EndKind {
    /// Whether the end is kept from turning about the member itself.
    pub(crate) fn keeps_spin(&self) -> bool {
        matches!(self, Self::Free { spin_removed: true } | Self::Axes { kept: Some(_), .. })
    }

    /// Lets the end turn about the member itself, where it was kept from that.
    pub(super) fn release_spin(&mut self) {
        match self {
            Self::Welded => {}
            Self::Free { spin_removed } => *spin_removed = false,
            Self::Axes { kept, .. } => *kept = None,
        }
    }
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
    /// Motions of joints that no force belongs to, by what is held at present.
    pub idle: Vec<Idle>,
    /// What acts on the rotation of every node.
    pub turned: Vec<Turned>,
    /// Whether what is idle goes by what is held; copies of other joints keep what is idle there.
    pub follows_rows: bool,
}

/// Members at every joint, and with which end, joint after joint.
pub(super) struct Attached {
    starts: Vec<usize>,
    ends: Vec<(usize, usize)>,
}

impl Attached {
    pub(super) fn of(structure: &Structure, topology: &Topology) -> Self {
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

    pub(super) fn at(&self, joint: usize) -> &[(usize, usize)] {
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

    /// `turned` tells of every node what acts on its rotation, with the rows that are held at first.
    pub(crate) fn new(structure: &Structure, turned: Vec<Turned>) -> Self {
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
                    Release::Axes(axes) => EndKind::Axes { axes: axes.clone(), kept: None },
                })
            })
            .collect();
        let idle = vec![Idle::None; references.len()];
        let mut topology = Self { links, references, ends, idle, turned, follows_rows: true };
        let attached = Attached::of(structure, &topology);
        let engaged = topology.rotation_engaged(structure);
        topology.free_lone_ends(&attached, &engaged);
        topology.find_idle(structure, &attached, &engaged);
        topology
    }

    /// Whether bodies or springs engage the rotation of joints.
    pub(super) fn rotation_engaged(&self, structure: &Structure) -> Vec<bool> {
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
    fn free_lone_ends(&mut self, attached: &Attached, engaged: &[bool]) {
        for joint in 0..self.references.len() {
            let takes = |&&(member, end): &&(usize, usize)| !matches!(self.ends[member][end], EndKind::Free { .. });
            let mut taking = attached.at(joint).iter().filter(takes);
            if let (Some(&(member, end)), None) = (taking.next(), taking.next())
                && !engaged[joint]
                && self.turned[self.references[joint]].is_left_alone()
                && matches!(self.ends[member][end], EndKind::Axes { .. })
            {
                self.ends[member][end] = EndKind::Free { spin_removed: false };
            }
        }
    }
}
