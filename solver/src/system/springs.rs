//! Springs in the equations of the joints.

use pennate_elements::small::cross;

use super::System;
use super::scatter::add_local;
use crate::joints::EndKind;
use crate::reduce::{self, End, Reduced, ReleaseState};
use crate::spring::Placed;
use crate::structure::{NodeId, Spring};

impl<const D: usize> System<D> {
    pub(super) fn assemble_spring(&mut self, index: usize, pending: bool, moved: &mut [[f64; 6]]) {
        if index == 0 {
            self.tangent.spring_energy = 0.0;
        }
        let structure = self.structure.clone();
        let spring = &structure.springs[index];
        let (response, force) = spring.respond(&self.placed(index));
        self.tangent.spring_forces[index] = force;
        self.tangent.spring_energy += response.energy;
        let (nodes, count) = (ends(spring), spring.nodes().len());
        let active = self.pattern.equations.active;
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
            self.tangent.note_scale(&full[a]);
        }
        let links = nodes.map(|n| self.topology.links[n]);
        for a in 0..count {
            if links[a].has_arm() {
                let rotation = self.places.joints[links[a].joint].place.rotation;
                let lever = self.places.lever(&links[a]);
                // The moments of a body on springs along lines are those of their forces on its arms.
                let [x, y, z] = cross(lever, [full[a][0], full[a][1], full[a][2]]);
                self.tangent.note_scale(&[0.0, 0.0, 0.0, x, y, z]);
                let end = End {
                    kind: &EndKind::Welded,
                    release: &ReleaseState::default(),
                    joint_rotation: rotation,
                    lever,
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
            self.scatter_spring(index, &single, &joints[..1]);
        } else {
            self.add_reduced(&reduced, joints, pending, moved);
            self.scatter_spring(index, &reduced, &joints);
        }
    }

    /// Adds the stiffness of a spring to the matrix alone.
    fn scatter_spring(&mut self, index: usize, reduced: &Reduced, joints: &[usize]) {
        if !self.tangent.keeps_matrix {
            let scatters = &*self.pattern.scatters;
            let scatter = (scatters, &scatters.springs[index]);
            add_local(&self.pattern.equations, reduced, joints, scatter, &mut self.tangent.linear);
        }
    }

    /// Where the nodes of a spring are.
    pub(crate) fn placed(&self, index: usize) -> Placed {
        let spring = &self.structure.springs[index];
        let nodes = ends(spring);
        let joints = nodes.map(|node| &self.places.joints[self.topology.links[node].joint]);
        let is_plane = D == 3 && self.pattern.equations.active.contains(&5);
        Placed {
            poses: nodes.map(|node| self.places.pose(&self.topology.links[node])),
            unloaded: nodes.map(|node| self.structure.nodes[node]),
            theta: joints[0].theta,
            angles: is_plane.then(|| joints.map(|joint| joint.place.angle)),
            natural_length: self.loading.natural_length(index, spring),
        }
    }
}

/// Both nodes of a spring; the only one twice.
fn ends(spring: &Spring) -> [NodeId; 2] {
    spring.pair().unwrap_or([spring.nodes()[0]; 2])
}
