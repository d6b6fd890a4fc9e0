//! Parts of a network that nothing connects: each has its own equilibrium.

use crate::joints::Topology;
use crate::structure::Structure;

use super::System;

/// The part that every joint and every member belongs to.
#[derive(Clone, Debug, Default)]
pub(super) struct Parts {
    pub count: usize,
    pub joints: Vec<usize>,
    pub members: Vec<usize>,
    pub springs: Vec<usize>,
}

impl Parts {
    pub(crate) fn of(structure: &Structure, topology: &Topology) -> Self {
        let joint = |node: usize| topology.links[node].joint;
        let mut root: Vec<usize> = (0..topology.references.len()).collect();
        let springs = structure.springs.iter().map(|spring| spring.nodes().to_vec());
        for nodes in structure.members.iter().map(|member| member.nodes.to_vec()).chain(springs) {
            let [first, last] = [nodes[0], nodes[nodes.len() - 1]].map(|node| find(&mut root, joint(node)));
            root[first.max(last)] = first.min(last);
        }
        // A part has the number of its first joint among those of all parts.
        let mut count = 0;
        let mut joints = vec![0; root.len()];
        for index in 0..root.len() {
            let home = find(&mut root, index);
            joints[index] = if home == index { count } else { joints[home] };
            count += usize::from(home == index);
        }
        let of = |nodes: &[usize]| joints[joint(nodes[0])];
        let members = structure.members.iter().map(|member| of(&member.nodes)).collect();
        let springs = structure.springs.iter().map(|spring| of(spring.nodes())).collect();
        Self { count, members, springs, joints }
    }
}

impl<const D: usize> System<D> {
    /// Whether the network is a tree of members that a single joint holds: nothing thrusts against anything there, and
    /// no arch can snap through.
    pub(crate) fn hangs(&self) -> bool {
        let joint = |node: usize| self.topology.links[node].joint;
        let first = self.pattern.equations.held.first().map(|held| joint(held.node));
        let one = self.pattern.equations.held.iter().all(|held| Some(joint(held.node)) == first);
        let tree = self.pattern.parts.count == 1 && self.members.count() + 1 == self.topology.references.len();
        one && tree && self.structure.springs.is_empty()
    }
}

/// The joint that stands for a part; those on the way to it are nearer afterwards.
pub(super) fn find(root: &mut [usize], mut joint: usize) -> usize {
    while root[joint] != joint {
        root[joint] = root[root[joint]];
        joint = root[joint];
    }
    joint
}
