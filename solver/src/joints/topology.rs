//! The network as joints and member ends; motions that no force belongs to.

use pennate_elements::small::{V3, cross, norm, sub};

use super::PARALLEL;
use crate::structure::{NodeId, Release, Spring, Structure};

/// Where a node sits: its joint, and its unloaded position against the joint's reference node.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    pub joint: usize,
    pub arm: V3<f64>,
}

impl Link {
    pub fn has_arm(&self) -> bool {
        self.arm != [0.0; 3]
    }
}

/// Connection of a member's end, motions that no force belongs to taken out.
#[derive(Clone, Debug, PartialEq)]
pub enum EndKind {
    Welded,
    /// The end turns freely; with `spin_removed` not about the member itself.
    Free {
        spin_removed: bool,
    },
    /// Free about axes that turn with the joint.
    Axes(Vec<V3<f64>>),
}

/// The network as joints and member ends.
#[derive(Clone, Debug)]
pub struct Topology {
    pub links: Vec<Link>,
    /// Reference node of every joint.
    pub references: Vec<NodeId>,
    pub ends: Vec<[EndKind; 2]>,
    /// Motions of joints that no force belongs to: rotation as a whole, or spin about one axis.
    pub idle: Vec<Idle>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Idle {
    None,
    /// The joint has no rotation of its own.
    Rotation,
    /// It does not turn about this axis (global, unloaded, carried along).
    Spin(V3<f64>),
}

fn parallel(a: V3<f64>, b: V3<f64>) -> bool {
    norm(cross(a, b)) < PARALLEL * norm(a) * norm(b)
}

impl Topology {
    /// `turned` tells of nodes whose rotation is held, loaded or prescribed at any time.
    pub fn new(structure: &Structure, turned: &[bool]) -> Self {
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
        topology.remove_idle_joints(structure, turned);
        topology.remove_idle_spins(structure, turned);
        topology
    }

    /// Whether a node's rotation is engaged by anything but member ends.
    fn rotation_engaged(&self, structure: &Structure, turned: &[bool]) -> Vec<bool> {
        let mut engaged = vec![false; self.references.len()];
        for (node, link) in self.links.iter().enumerate() {
            engaged[link.joint] |= turned[node];
        }
        for body in &structure.bodies {
            engaged[self.links[body.reference].joint] |= body.nodes.len() > 1;
        }
        for spring in &structure.springs {
            match spring {
                Spring::Ground { node, stiffness } => {
                    engaged[self.links[*node].joint] |= stiffness[3..].iter().any(|&k| k != 0.0);
                }
                Spring::Coupling { nodes, .. } => nodes.iter().for_each(|&n| engaged[self.links[n].joint] = true),
                Spring::Axial { .. } => {}
            }
        }
        engaged
    }

    fn remove_idle_joints(&mut self, structure: &Structure, turned: &[bool]) {
        let engaged = self.rotation_engaged(structure, turned);
        for joint in 0..self.references.len() {
            if engaged[joint] {
                continue;
            }
            let mut axis: Option<V3<f64>> = None;
            let mut common = true;
            let mut welded = false;
            for (member, ends) in structure.members.iter().zip(&self.ends) {
                for end in 0..2 {
                    if self.links[member.nodes[end]].joint != joint {
                        continue;
                    }
                    match &ends[end] {
                        EndKind::Welded => welded = true,
                        EndKind::Free { .. } => {}
                        EndKind::Axes(axes) if axes.len() == 1 => match axis {
                            None => axis = Some(axes[0]),
                            Some(other) => common &= parallel(other, axes[0]),
                        },
                        EndKind::Axes(_) => common = false,
                    }
                }
            }
            self.idle[joint] = match (welded, common, axis) {
                (true, ..) | (_, false, _) => Idle::None,
                (false, true, None) => Idle::Rotation,
                (false, true, Some(axis)) => Idle::Spin(axis),
            };
        }
    }

    /// A straight bar that may spin about itself at both ends keeps one of them from it.
    fn remove_idle_spins(&mut self, structure: &Structure, turned: &[bool]) {
        let engaged = self.rotation_engaged(structure, turned);
        let mut attached = vec![0; self.references.len()];
        for member in &structure.members {
            for node in member.nodes {
                attached[self.links[node].joint] += 1;
            }
        }
        for (index, member) in structure.members.iter().enumerate() {
            if member.segments.iter().any(|s| s.initial_curvature != [0.0; 3]) {
                continue;
            }
            let axis = member.axes[0];
            let joints = member.nodes.map(|n| self.links[n].joint);
            let lone = joints.map(|j| attached[j] == 1 && !engaged[j] && self.idle[j] == Idle::None);
            let spins: [bool; 2] = std::array::from_fn(|end| match &self.ends[index][end] {
                EndKind::Welded => lone[end],
                EndKind::Free { .. } => true,
                EndKind::Axes(axes) => axes.iter().any(|a| parallel(*a, axis)) || lone[end],
            });
            if !(spins[0] && spins[1]) {
                continue;
            }
            for end in 0..2 {
                match &mut self.ends[index][end] {
                    EndKind::Free { spin_removed } => *spin_removed = true,
                    EndKind::Axes(axes) if axes.iter().any(|a| parallel(*a, axis)) => {
                        axes.retain(|a| !parallel(*a, axis));
                        if axes.is_empty() {
                            self.ends[index][end] = EndKind::Welded;
                        }
                    }
                    _ if lone[end] => self.idle[joints[end]] = Idle::Spin(axis),
                    _ => continue,
                }
                break;
            }
        }
    }
}
