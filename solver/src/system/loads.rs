//! Loads on nodes in the equations of the joints, and those without a potential.

use nalgebra::SMatrix;
use pennate_elements::rotation::{second_variation, turn};
use pennate_elements::small::{V3, add, cross, skew, sub};

use super::System;
use super::scatter::unit_motion;
use crate::joints::dot6;
use crate::structure::NodeId;

/// The load on a node at its present place.
pub(super) struct LoadAt {
    /// The joint of the node.
    pub joint: usize,
    force: V3<f64>,
    moment: V3<f64>,
    /// About the reference of the joint.
    total: V3<f64>,
    /// Its part of the tangent, in components of the joint.
    pub block: [[f64; 6]; 6],
}

impl<const D: usize> System<D> {
    /// Adds the loads on nodes; to `moved` what they change by where their joints move by what is pending.
    pub(super) fn assemble_loads(&mut self, mut moved: Option<&mut [[f64; 6]]>) {
        // What has no potential is in the factors, and stays with them.
        if !self.tangent.keeps_matrix {
            self.tangent.skew.joints.clear();
        }
        for position in 0..self.pattern.loaded_nodes.len() {
            let node = self.pattern.loaded_nodes[position];
            let (link, load) = (&self.topology.links[node], &self.loading.nodes[node]);
            // A dead force on the joint itself acts as it is, and has no part in the tangent.
            if load.is_dead_force() && !link.has_arm() {
                let [x, y, z] = load.force;
                self.tangent.note_scale(&[x, y, z, 0.0, 0.0, 0.0]);
                let target = &mut self.tangent.forces[link.joint];
                for c in 0..3 {
                    target[c] -= load.force[c];
                }
                continue;
            }
            let LoadAt { joint, force, moment, total, block } = self.load_at(node);
            self.tangent.note_scale(&[force[0], force[1], force[2], moment[0], moment[1], moment[2]]);
            let target = &mut self.tangent.forces[joint];
            for c in 0..3 {
                target[c] -= force[c];
                target[3 + c] -= total[c];
            }
            if block.iter().flatten().any(|&entry| entry != 0.0) {
                self.add_joint_block(joint, &block, moved.as_deref_mut());
            }
        }
    }

    /// The load on a node at its present place.
    pub(super) fn load_at(&self, node: NodeId) -> LoadAt {
        let load = self.loading.nodes[node];
        let link = self.topology.links[node];
        let rotation = self.places.joints[link.joint].place.rotation;
        let lever = self.places.lever(&link);
        let follower = turn(rotation, load.follower_force);
        let follower_moment = turn(rotation, load.follower_moment);
        let force = add(load.force, follower);
        let moment = add(load.moment, follower_moment);
        let total = add(moment, cross(lever, force));
        // Symmetric part: a dead force on a lever. The rest has no potential.
        let mut block = [[0.0; 6]; 6];
        if lever != [0.0; 3] {
            let geometric = second_variation(load.force, lever);
            for i in 0..3 {
                for j in 0..3 {
                    block[3 + i][3 + j] -= geometric[i][j];
                }
            }
        }
        let f = skew(follower);
        let half = skew(sub(add(follower_moment, cross(lever, follower)), load.moment));
        for i in 0..3 {
            for j in 0..3 {
                block[i][3 + j] += f[i][j];
                block[3 + i][3 + j] += 0.5 * half[i][j];
            }
        }
        LoadAt { joint: link.joint, force, moment, total, block }
    }

    /// Adds the symmetric part of a joint's block to the matrix, and puts its skew part aside; to `moved` what the block makes of the
    /// motion of the joint that is pending.
    pub(super) fn add_joint_block(&mut self, joint: usize, block: &[[f64; 6]; 6], moved: Option<&mut [[f64; 6]]>) {
        let equations = &self.pattern.equations;
        if let Some(moved) = moved {
            let motion = &equations.pending[joint];
            for (sum, row) in moved[joint].iter_mut().zip(block) {
                *sum += dot6(row, motion);
            }
        }
        let (first, count) = (equations.joints[joint].first, equations.joints[joint].count);
        let mut small = SMatrix::<f64, 6, 6>::zeros();
        let mut solution = [0.0; 6];
        let mut columns = [[0.0; 6]; 6];
        for e in 0..count {
            solution[e] = 1.0;
            columns[e] = unit_motion(equations, joint, &solution[..count]);
            solution[e] = 0.0;
        }
        for a in 0..count {
            for b in 0..count {
                let mut sum = 0.0;
                for &i in &equations.active {
                    for &j in &equations.active {
                        sum += columns[a][i] * block[i][j] * columns[b][j];
                    }
                }
                small[(a, b)] = sum;
            }
        }
        let symmetric = 0.5 * (small + small.transpose());
        let keeps = self.tangent.keeps_matrix;
        for &(i, j, position) in self.pattern.scatters.joints[joint].entries.iter().filter(|_| !keeps) {
            self.tangent.linear.add(position as usize, symmetric[(i as usize, j as usize)]);
        }
        let rest = small - symmetric;
        // Directions of turned supports round, and what is left of large terms may be small.
        let largest = block.iter().flatten().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        if !keeps && rest.amax() > 1e-13 * largest {
            self.tangent.skew.add(joint, first, count, rest);
        }
    }

    /// A node whose moment has no potential at the last assembly.
    pub(crate) fn endless_moment(&self) -> Option<NodeId> {
        let loaded = |node: &NodeId| {
            let load = &self.loading.nodes[*node];
            let joint = self.topology.links[*node].joint;
            (load.moment != [0.0; 3] || load.follower_moment != [0.0; 3])
                && self.tangent.skew.joints.iter().any(|skew| skew.joint == joint)
        };
        (0..self.loading.nodes.len()).find(|node| loaded(node))
    }

    /// Whether the loads at the present drives have a potential; leaves forces and matrix to the next assembly.
    pub fn loads_have_potential(&mut self) -> bool {
        self.pattern.equations.update(&self.topology, &self.places.joints, self.loading.fraction, true);
        self.assemble_loads(None);
        self.tangent.has_potential()
    }
}
