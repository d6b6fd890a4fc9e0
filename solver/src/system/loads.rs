//! Loads: what drives make of them, their part of the equations, and those without a potential.

use std::sync::Arc;

use pennate_elements::rotation::{second_variation, turn};
use pennate_elements::small::{V3, add, cross, scale, skew, sub};

use super::scatter::unit_motion;
use super::{NodeLoad, System};
use crate::joints::Active;
use crate::packs::{self, Auxiliary};
use crate::structure::{Drive, MemberId, NodeId, SectionLaw, Structure};

/// What the section stiffness and the load of a member follow from.
#[derive(Clone, Copy, Debug, PartialEq)]
struct MadeOf {
    control: f64,
    auxiliary: Auxiliary,
    line: V3<f64>,
    gravity: V3<f64>,
}

/// The sections of a member as they are: most stay what they are from one increment to the next.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sections {
    made_of: Option<MadeOf>,
    /// See [`System::noise`].
    noise: [f64; 2],
}

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
    /// Replaces the section laws; they count from the next [`System::apply_drives`].
    pub fn set_laws(&mut self, laws: Vec<Arc<dyn SectionLaw>>) {
        Arc::make_mut(&mut self.structure).laws = laws;
        self.sections.fill(Sections::default());
    }

    /// Brings sections, loads along members and loads on nodes up to date with the drives.
    pub fn apply_drives(&mut self) {
        let structure = self.structure.clone();
        let mut gravity = [0.0; 3];
        let mut along: Vec<(MemberId, V3<f64>)> = Vec::new();
        self.loads.fill(NodeLoad::default());
        for (drive, &value) in structure.drives.iter().zip(&self.drives) {
            match *drive {
                Drive::Control => {}
                Drive::Force(node, c) => self.loads[node].force[c] += value,
                Drive::Moment(node, c) => self.loads[node].moment[c] += value,
                Drive::FollowerForce(node, c) => self.loads[node].follower_force[c] += value,
                Drive::FollowerMoment(node, c) => self.loads[node].follower_moment[c] += value,
                Drive::Gravity(c) => gravity[c] += value,
                Drive::Distributed(member, c) => {
                    let mut load = [0.0; 3];
                    load[c] = value;
                    along.push((member, load));
                }
            }
        }
        for fading in &self.fading {
            let load = &mut self.loads[fading.node];
            load.force = add(load.force, scale(1.0 - self.fraction, fading.force));
            load.moment = add(load.moment, scale(1.0 - self.fraction, fading.moment));
        }
        self.noise = [0.0; 2];
        let weighs = gravity != [0.0; 3];
        if weighs {
            for body in &structure.bodies {
                let load = &mut self.loads[body.reference].force;
                *load = add(*load, scale(body.mass, gravity));
            }
        }
        let mut line = vec![[0.0; 3]; if along.is_empty() { 0 } else { structure.members.len() }];
        for (member, load) in along {
            line[member] = add(line[member], load);
        }
        for (index, slot) in self.members.iter().enumerate() {
            let member = &structure.members[index];
            let made_of = MadeOf {
                control: member.control.map_or(0.0, |drive| self.drives[drive]),
                auxiliary: self.auxiliary,
                line: line.get(index).copied().unwrap_or([0.0; 3]),
                gravity,
            };
            let sections = &mut self.sections[index];
            if sections.made_of != Some(made_of) {
                sections.made_of = Some(made_of);
                sections.noise = [0.0; 2];
                let chain = &mut self.packs[slot.pack];
                let member_length = member.length();
                for (segment, description) in member.segments.iter().enumerate() {
                    let section = structure.laws[description.law].at(made_of.control);
                    let length = chain.element_length(slot.lane, segment);
                    let lengths = [length, member_length];
                    let moduli = packs::moduli(&section, chain.about(), lengths, &slot.turn, self.auxiliary);
                    self.holds_strains |= moduli.held.iter().any(|&held| held != 0.0);
                    sections.noise[0] = sections.noise[0].max(1e-10 * moduli.stiffness[0]);
                    sections.noise[1] = sections.noise[1].max(1e-10 * moduli.stiffness[5] / self.size);
                    chain.set_moduli(slot.lane, segment, &moduli);
                    let weight = if weighs { scale(section.section.mass_per_length, gravity) } else { [0.0; 3] };
                    chain.set_load(slot.lane, segment, add(made_of.line, weight));
                }
            }
            for (noise, own) in self.noise.iter_mut().zip(sections.noise) {
                *noise = noise.max(own);
            }
        }
    }

    pub(super) fn assemble_loads(&mut self) {
        self.skew.joints.clear();
        let active = self.equations.active;
        for position in 0..self.loaded_nodes.len() {
            let LoadAt { joint, force, moment, total, block } = self.load_at(self.loaded_nodes[position]);
            self.note_scale(&[force[0], force[1], force[2], moment[0], moment[1], moment[2]]);
            let target = &mut self.forces[joint];
            for c in 0..3 {
                target[c] -= force[c];
                target[3 + c] -= total[c];
            }
            self.add_joint_block(joint, &block, &active);
        }
    }

    /// The load on a node at its present place.
    pub(super) fn load_at(&self, node: NodeId) -> LoadAt {
        let load = self.loads[node];
        let link = self.topology.links[node];
        let rotation = self.state.joints[link.joint].place.rotation;
        let lever = if link.has_arm() { turn(rotation, link.arm) } else { [0.0; 3] };
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

    /// Adds the symmetric part of a joint's block to the matrix, and puts its skew part aside.
    pub(super) fn add_joint_block(&mut self, joint: usize, block: &[[f64; 6]; 6], active: &Active<D>) {
        let equations = &self.equations.joints[joint];
        let count = equations.count;
        let mut small = nalgebra::SMatrix::<f64, 6, 6>::zeros();
        let mut solution = [0.0; 6];
        let mut columns = [[0.0; 6]; 6];
        for e in 0..count {
            solution[e] = 1.0;
            columns[e] = unit_motion(&self.equations, joint, &solution[..count]);
            solution[e] = 0.0;
        }
        for a in 0..count {
            for b in 0..count {
                let mut sum = 0.0;
                for &i in active {
                    for &j in active {
                        sum += columns[a][i] * block[i][j] * columns[b][j];
                    }
                }
                small[(a, b)] = sum;
            }
        }
        let symmetric = 0.5 * (small + small.transpose());
        for &(i, j, position) in &self.scatters.joints[joint].entries {
            self.linear.values[position as usize] += symmetric[(i as usize, j as usize)];
        }
        let rest = small - symmetric;
        // Directions of turned supports round, and what is left of large terms may be small.
        let largest = block.iter().flatten().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        if rest.amax() > 1e-13 * largest {
            match self.skew.joints.iter_mut().find(|(j, _)| *j == joint) {
                Some((_, n)) => *n += rest,
                None => self.skew.joints.push((joint, rest)),
            }
        }
    }

    /// Whether every load has a potential, at the present state.
    pub fn has_potential(&self) -> bool {
        self.skew.joints.is_empty()
    }

    /// A node whose moment has no potential at the last assembly.
    pub fn endless_moment(&self) -> Option<NodeId> {
        let loaded = |node: &NodeId| {
            let load = &self.loads[*node];
            let joint = self.topology.links[*node].joint;
            (load.moment != [0.0; 3] || load.follower_moment != [0.0; 3])
                && self.skew.joints.iter().any(|(skew, _)| *skew == joint)
        };
        (0..self.loads.len()).find(|node| loaded(node))
    }

    /// Whether the loads at the present drives have a potential; leaves forces and matrix to the next assembly.
    pub fn loads_have_potential(&mut self) -> bool {
        self.equations.update(&self.topology, &self.state.joints, self.fraction);
        self.assemble_loads();
        self.has_potential()
    }
}

/// Nodes that any drive, or the weight of a body, may load.
pub(super) fn loaded_nodes(structure: &Structure) -> Vec<NodeId> {
    let mut nodes: Vec<NodeId> = structure
        .drives
        .iter()
        .filter_map(|drive| match *drive {
            Drive::Force(n, _) | Drive::Moment(n, _) | Drive::FollowerForce(n, _) | Drive::FollowerMoment(n, _) => {
                Some(n)
            }
            _ => None,
        })
        .collect();
    if structure.drives.iter().any(|d| matches!(d, Drive::Gravity(_))) {
        nodes.extend(structure.bodies.iter().map(|b| b.reference));
    }
    nodes
}
