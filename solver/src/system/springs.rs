//! Springs in the equations of the joints.

use std::f64::consts::TAU;

use pennate_elements::rotation::turn;
use pennate_elements::small::{norm, sub};
use pennate_elements::space::Pose;
use pennate_elements::spring::{self, SpringResponse};

use super::System;
use super::scatter::add_local;
use crate::joints::EndKind;
use crate::reduce::{self, End, Reduced, ReleaseState};
use crate::structure::{NodeId, Spring};

impl<const D: usize> System<D> {
    pub(super) fn pose(&self, node: NodeId) -> Pose<f64> {
        let link = &self.topology.links[node];
        let state = &self.state.joints[link.joint];
        Pose { displacement: state.point(link.arm), rotation: state.place.rotation }
    }

    pub(super) fn assemble_spring(&mut self, index: usize, pending: bool, moved: &mut [[f64; 6]]) {
        if index == 0 {
            self.spring_energy = 0.0;
        }
        let structure = self.structure.clone();
        let positions = &structure.nodes;
        let (response, nodes, force): (SpringResponse, [NodeId; 2], f64) = match &structure.springs[index] {
            Spring::Ground { node, stiffness } => {
                let r = self.ground_response(*node, stiffness);
                let f = norm([r.gradient[0], r.gradient[1], r.gradient[2]]);
                (r, [*node, *node], f)
            }
            Spring::Axial { nodes, stiffness, natural_length } => {
                let arm = sub(positions[nodes[1]], positions[nodes[0]]);
                let rest = self.unstressed[index] + self.prestress * (natural_length - self.unstressed[index]);
                let (r, f) = spring::axial(*stiffness, rest, arm, [&self.pose(nodes[0]), &self.pose(nodes[1])]);
                (r, *nodes, f)
            }
            Spring::Coupling { nodes, stiffness } => {
                let arm = sub(positions[nodes[1]], positions[nodes[0]]);
                let r = self.coupling_response(*nodes, stiffness, arm);
                let f = norm([r.gradient[6], r.gradient[7], r.gradient[8]]);
                (r, *nodes, f)
            }
        };
        self.spring_forces[index] = force;
        self.spring_energy += response.energy;
        let count = if matches!(structure.springs[index], Spring::Ground { .. }) { 1 } else { 2 };
        let active = self.equations.active;
        let mut reduced = Reduced { stiffness: [[0.0; 12]; 12], force: [0.0; 12], negative: 0, neutral: 0 };
        let mut full = [[0.0; 6]; 2];
        for a in 0..count {
            for c in 0..6 {
                full[a][c] = response.gradient[6 * a + c];
            }
            for (i, &ci) in active.iter().enumerate() {
                reduced.force[a * D + i] = response.gradient[6 * a + ci];
                for b in 0..count {
                    for (j, &cj) in active.iter().enumerate() {
                        reduced.stiffness[a * D + i][b * D + j] = response.tangent[6 * a + ci][6 * b + cj];
                    }
                }
            }
            self.note_scale(&full[a]);
        }
        let links = nodes.map(|n| self.topology.links[n]);
        for a in 0..count {
            if links[a].has_arm() {
                let rotation = self.state.joints[links[a].joint].place.rotation;
                let end = End {
                    kind: &EndKind::Welded,
                    release: &ReleaseState::default(),
                    joint_rotation: rotation,
                    lever: turn(rotation, links[a].arm),
                    tangent: [0.0; 3],
                    force: [full[a][0], full[a][1], full[a][2]],
                    moment: [0.0; 3],
                };
                reduce::apply_lever(&mut reduced, &active, a, &end);
            }
        }
        let joints = [links[0].joint, links[1].joint];
        if count == 1 {
            // One node: only the first half is in use.
            let mut single = reduced;
            for i in D..2 * D {
                single.force[i] = 0.0;
            }
            self.add_reduced(&single, joints, pending, moved);
            add_local(&self.equations, &single, &joints[..1], &self.scatters.springs[index], &mut self.linear.values);
        } else {
            self.add_reduced(&reduced, joints, pending, moved);
            add_local(&self.equations, &reduced, &joints, &self.scatters.springs[index], &mut self.linear.values);
        }
    }

    /// In the plane the rotation between two nodes counts whole turns.
    fn coupling_response(&self, nodes: [NodeId; 2], stiffness: &[f64; 6], arm: [f64; 3]) -> SpringResponse {
        let poses = nodes.map(|node| self.pose(node));
        let mut response = spring::coupling(stiffness, arm, [&poses[0], &poses[1]]);
        if D == 3 && self.equations.active.contains(&5) {
            let [first, second] = nodes.map(|n| self.state.joints[self.topology.links[n].joint].place.angle);
            let angle = second - first;
            let reduced = angle - TAU * (angle / TAU).round();
            response.energy += 0.5 * stiffness[5] * (angle * angle - reduced * reduced);
            response.gradient[5] -= stiffness[5] * (angle - reduced);
            response.gradient[11] += stiffness[5] * (angle - reduced);
        }
        response
    }

    /// The rotation of a ground spring counts whole turns.
    fn ground_response(&self, node: NodeId, stiffness: &[f64; 6]) -> SpringResponse {
        let joint = &self.state.joints[self.topology.links[node].joint];
        let plane = D == 3 && self.equations.active.contains(&5);
        let theta = if plane { [0.0; 3] } else { joint.theta };
        let mut response = spring::ground(stiffness, &self.pose(node), theta);
        if plane {
            let angle = joint.place.angle;
            let reduced = pennate_elements::rotation::log(self.pose(node).rotation)[2];
            response.energy += 0.5 * stiffness[5] * (angle * angle - reduced * reduced);
            response.gradient[5] = stiffness[5] * angle;
            response.tangent[5][5] = stiffness[5];
        }
        response
    }
}
