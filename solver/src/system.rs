//! Residual and tangent of the joints; owns every large buffer.

use std::sync::Arc;

use pennate_elements::beam::Ends;
use pennate_elements::rotation::{second_variation, turn};
use pennate_elements::section::Section;
use pennate_elements::small::{M3, V3, add, cross, norm, scale, skew, sub};
use pennate_elements::space::Pose;
use pennate_elements::spring::{self, SpringResponse};
use rayon::prelude::*;

use crate::chain::{Pack, SLOTS, Size};
use crate::joints::{Active, EndKind, Equations, Held, HeldKind, JointState, Topology};
use crate::linear::{Pivots, Symmetric};
use crate::packs::{self, Turn};
use crate::reduce::{self, End, Reduced, ReleaseFactor, ReleaseState};
use crate::structure::{Drive, MemberId, NodeId, SectionState, Spring, Structure};

/// Forces at most so many nodes without a potential before their correction is as large as the system.
const SKEW_COLUMNS: usize = 6;

/// Everything of the joints that changes during a solve.
#[derive(Clone, Debug, Default)]
pub struct State {
    pub joints: Vec<JointState>,
    pub releases: Vec<[ReleaseState; 2]>,
}

/// Loads on one node, at the present values of the drives.
#[derive(Clone, Copy, Debug, Default)]
pub struct NodeLoad {
    pub force: V3<f64>,
    pub moment: V3<f64>,
    /// Components in the unloaded state.
    pub follower_force: V3<f64>,
    pub follower_moment: V3<f64>,
}

/// A force and a moment on a node that fade over a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fading {
    pub node: NodeId,
    pub force: V3<f64>,
    pub moment: V3<f64>,
}

/// Where the entries of a member's or spring's reduced stiffness go.
#[derive(Clone, Debug, Default)]
struct Scatter {
    /// Local row, local column, position in the matrix.
    entries: Vec<(u8, u8, u32)>,
}

/// Largest residual of the joints, over the scale of its kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    pub force: f64,
    pub moment: f64,
    pub worst_joint: usize,
    pub worst_component: usize,
}

impl Residual {
    pub fn largest(&self) -> f64 {
        self.force.max(self.moment)
    }
}

/// Pivots of a whole network: joints, interiors, released ends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inertia {
    pub negative: usize,
    pub neutral: usize,
    pub smallest: f64,
    /// Sign of the determinant of the unsymmetric correction.
    pub skew_negative: bool,
}

/// A member's place among the packs, and what its ends are.
#[derive(Clone, Debug)]
pub struct MemberSlot {
    pub pack: usize,
    pub lane: usize,
    pub turn: Turn,
    /// Unloaded tangents at both ends.
    pub tangents: [V3<f64>; 2],
    pub factor: ReleaseFactor,
    pub released: bool,
    /// Forces on the ends at the last assembly.
    pub ends: [[f64; 6]; 2],
}

/// The equations of a structure in D components a joint.
pub struct System<const D: usize> {
    pub structure: Arc<Structure>,
    pub topology: Arc<Topology>,
    pub packs: Vec<Box<dyn Pack<D>>>,
    pub members: Vec<MemberSlot>,
    pub state: State,
    saved: [State; SLOTS],
    pub drives: Vec<f64>,
    /// Part of the springs' misfit that is in place.
    pub prestress: f64,
    unstressed: Vec<f64>,
    pub fraction: f64,
    pub equations: Equations<D>,
    pub linear: Symmetric,
    scatter: Vec<Scatter>,
    spring_scatter: Vec<Scatter>,
    joint_scatter: Vec<Scatter>,
    /// Internal less external force of every joint.
    pub forces: Vec<[f64; 6]>,
    pub loads: Vec<NodeLoad>,
    loaded_nodes: Vec<NodeId>,
    /// Reactions of what a step sets free: they fall to zero over it.
    pub fading: Vec<Fading>,
    pub spring_forces: Vec<f64>,
    pub spring_energy: f64,
    pub rhs: Vec<f64>,
    motions: Vec<[f64; 6]>,
    skew: Skew,
    pub force_scale: f64,
    pub moment_scale: f64,
    pub size: f64,
    /// Force and moment that rounding alone may leave: 1e-10 of the stiffness.
    noise: [f64; 2],
    parallel: bool,
    released_neutral: usize,
    released_negative: usize,
    last_inertia: Inertia,
    /// Sum of the stiffness of members and springs on every component, and the same of the unloaded structure.
    stiffness: Vec<[f64; 6]>,
    rest_stiffness: Vec<[f64; 6]>,
    /// Members with a released rotation that nothing resists, at the last assembly.
    pub idle_members: Vec<MemberId>,
}

/// Loads without a potential: K = S + Σ E N Eᵀ, solved by the identity of Woodbury.
#[derive(Debug, Default)]
struct Skew {
    /// Equations of the columns, and N by blocks of joints.
    joints: Vec<(usize, nalgebra::SMatrix<f64, 6, 6>)>,
    columns: Vec<f64>,
    small: nalgebra::DMatrix<f64>,
    solver: Option<nalgebra::LU<f64, nalgebra::Dyn, nalgebra::Dyn>>,
}

impl<const D: usize> System<D> {
    pub fn new(
        structure: Arc<Structure>,
        topology: Arc<Topology>,
        packs: Vec<Box<dyn Pack<D>>>,
        active: Active<D>,
        parallel: bool,
    ) -> Self {
        let joints = topology.references.len();
        let mut members: Vec<Option<MemberSlot>> = vec![None; structure.members.len()];
        for (pack, chain) in packs.iter().enumerate() {
            for (lane, &member) in chain.members().iter().enumerate() {
                let description = &structure.members[member];
                members[member] = Some(MemberSlot {
                    pack,
                    lane,
                    turn: Turn::of(structure.dimension, description),
                    tangents: end_tangents(description),
                    factor: ReleaseFactor::default(),
                    released: topology.ends[member].iter().any(|e| *e != EndKind::Welded),
                    ends: [[0.0; 6]; 2],
                });
            }
        }
        let state = State {
            joints: vec![JointState::default(); joints],
            releases: vec![[ReleaseState::default(); 2]; structure.members.len()],
        };
        let unstressed = structure
            .springs
            .iter()
            .map(|spring| match spring {
                Spring::Axial { nodes, .. } => norm(sub(structure.nodes[nodes[1]], structure.nodes[nodes[0]])),
                _ => 0.0,
            })
            .collect();
        let size = extent(&structure.nodes);
        let mut system = Self {
            equations: Equations::new(&topology, active, Vec::new()),
            linear: Symmetric::new(0, &mut Vec::new()),
            scatter: Vec::new(),
            spring_scatter: Vec::new(),
            joint_scatter: Vec::new(),
            forces: vec![[0.0; 6]; joints],
            loads: vec![NodeLoad::default(); structure.nodes.len()],
            loaded_nodes: Vec::new(),
            fading: Vec::new(),
            spring_forces: vec![0.0; structure.springs.len()],
            spring_energy: 0.0,
            rhs: Vec::new(),
            motions: vec![[0.0; 6]; joints],
            skew: Skew::default(),
            drives: vec![0.0; structure.drives.len()],
            prestress: 0.0,
            unstressed,
            fraction: 0.0,
            saved: std::array::from_fn(|_| state.clone()),
            state,
            members: members.into_iter().flatten().collect(),
            packs,
            topology,
            structure,
            force_scale: 0.0,
            moment_scale: 0.0,
            size,
            noise: [0.0; 2],
            parallel,
            released_neutral: 0,
            released_negative: 0,
            last_inertia: Inertia::default(),
            stiffness: vec![[0.0; 6]; joints],
            rest_stiffness: vec![[0.0; 6]; joints],
            idle_members: Vec::new(),
        };
        system.hold(Vec::new());
        system.apply_drives();
        system
    }

    /// Sets what is held, and analyses the equations anew.
    pub fn hold(&mut self, held: Vec<Held>) {
        let held = held.into_iter().filter(|h| self.concerns(h)).collect();
        self.equations = Equations::new(&self.topology, self.equations.active, held);
        let equations = &self.equations;
        let local = |joint: usize| {
            let e = &equations.joints[joint];
            (e.first..e.first + e.count).collect::<Vec<_>>()
        };
        let mut groups: Vec<Vec<usize>> = Vec::new();
        let links = &self.topology.links;
        for member in &self.structure.members {
            groups.push(member.nodes.iter().flat_map(|&n| local(links[n].joint)).collect());
        }
        for spring in &self.structure.springs {
            groups.push(spring_nodes(spring).iter().flat_map(|&n| local(links[n].joint)).collect());
        }
        for joint in 0..equations.joints.len() {
            groups.push(local(joint));
        }
        let mut pairs = Vec::new();
        for group in &groups {
            for &row in group {
                pairs.extend(group.iter().filter(|&&column| column <= row).map(|&column| (row, column)));
            }
        }
        self.linear = Symmetric::new(equations.size, &mut pairs);
        let mut scatters = groups.iter().map(|group| {
            let mut entries = Vec::new();
            for (i, &row) in group.iter().enumerate() {
                for (j, &column) in group.iter().enumerate() {
                    if column <= row
                        && let Some(position) = self.linear.position(row, column)
                    {
                        entries.push((i as u8, j as u8, position as u32));
                    }
                }
            }
            Scatter { entries }
        });
        self.scatter = scatters.by_ref().take(self.structure.members.len()).collect();
        self.spring_scatter = scatters.by_ref().take(self.structure.springs.len()).collect();
        self.joint_scatter = scatters.collect();
        self.rhs = vec![0.0; equations.size];
        self.skew = Skew::default();
        self.measure_by_rest();
        self.loaded_nodes = loaded_nodes(&self.structure);
        self.loaded_nodes.extend(self.fading.iter().map(|f| f.node));
        self.loaded_nodes.sort_unstable();
        self.loaded_nodes.dedup();
    }

    /// Whether a row holds any of the active components.
    fn concerns(&self, held: &Held) -> bool {
        let (vector, offset) = match held.kind {
            HeldKind::Translation { direction } => (direction, 0),
            HeldKind::Rotation { axis } => (axis, 3),
        };
        (0..3).any(|i| vector[i] != 0.0 && self.equations.active.contains(&(offset + i)))
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
            let control = member.control.map_or(0.0, |drive| self.drives[drive]);
            let chain = &mut self.packs[slot.pack];
            for (segment, description) in member.segments.iter().enumerate() {
                let section = structure.laws[description.law].at(control);
                let length = chain.element_length(slot.lane, segment);
                let moduli = packs::moduli(&section, length, &slot.turn);
                self.noise[0] = self.noise[0].max(1e-10 * moduli.stiffness[0]);
                self.noise[1] = self.noise[1].max(1e-10 * moduli.stiffness[5] / self.size);
                chain.set_moduli(slot.lane, segment, &moduli);
                let mut load = line.get(index).copied().unwrap_or([0.0; 3]);
                if weighs {
                    load = add(load, scale(section.section.mass_per_length, gravity));
                }
                chain.set_load(slot.lane, segment, load);
            }
        }
    }

    /// Section of a segment at the present control.
    pub fn section(&self, member: MemberId, segment: usize) -> SectionState {
        let description = &self.structure.members[member];
        let control = description.control.map_or(0.0, |drive| self.drives[drive]);
        self.structure.laws[description.segments[segment].law].at(control)
    }

    /// Linearizes everything at the present state and factorizes; the residual is in `forces` and `rhs`.
    ///
    /// With `pending` the motion of held components is part of the right-hand side.
    pub fn assemble(&mut self, pending: bool) -> Inertia {
        self.condense();
        self.equations.update(&self.topology, &self.state.joints, self.fraction);
        self.linear.clear();
        self.forces.fill([0.0; 6]);
        self.stiffness.fill([0.0; 6]);
        self.force_scale = 0.0;
        self.moment_scale = 0.0;
        self.released_neutral = 0;
        self.released_negative = 0;
        self.idle_members.clear();
        let mut inertia = Inertia { smallest: 1.0, ..Inertia::default() };
        let mut moved = std::mem::take(&mut self.motions);
        moved.fill([0.0; 6]);
        for index in 0..self.members.len() {
            let (negative, smallest) = self.packs[self.members[index].pack].pivots(self.members[index].lane);
            inertia.negative += negative;
            inertia.smallest = inertia.smallest.min(smallest);
            self.assemble_member(index, pending, &mut moved);
        }
        for index in 0..self.structure.springs.len() {
            self.assemble_spring(index, pending, &mut moved);
        }
        self.assemble_loads();
        if self.equations.has_general() {
            let forces = std::mem::take(&mut self.forces);
            self.equations.find_multipliers(&self.topology, &self.state.joints, &forces, self.fraction);
            self.forces = forces;
            self.add_constraint_stiffness();
        }
        for joint in 0..self.forces.len() {
            let total: [f64; 6] = std::array::from_fn(|c| self.forces[joint][c] + moved[joint][c]);
            self.equations.project(joint, &total, &mut self.rhs);
        }
        self.motions = moved;
        let pivots = self.linear.factorize();
        self.join(&mut inertia, &pivots);
        self.factorize_skew(&mut inertia);
        self.last_inertia = inertia;
        inertia
    }

    /// Pivots of the last assembly.
    pub fn inertia(&self) -> Inertia {
        self.last_inertia
    }

    /// Empties matrix and forces before an assembly.
    pub fn begin(&mut self) {
        self.equations.update(&self.topology, &self.state.joints, self.fraction);
        self.linear.clear();
        self.forces.fill([0.0; 6]);
        self.released_neutral = 0;
        self.released_negative = 0;
    }

    /// Adds the reduced stiffness of a member.
    pub fn add_member(&mut self, index: usize, reduced: &Reduced) {
        self.released_negative += reduced.negative;
        self.released_neutral += reduced.neutral;
        let joints = self.structure.members[index].nodes.map(|n| self.topology.links[n].joint);
        add_local(&self.equations, reduced, &joints, &self.scatter[index], &mut self.linear.values);
    }

    /// Adds springs, loads and the curvature of constraints, those of the plane system included.
    pub fn add_springs_and_loads(&mut self, plane: Option<&Self>) {
        let mut unused = std::mem::take(&mut self.motions);
        for index in 0..self.structure.springs.len() {
            self.assemble_spring(index, false, &mut unused);
        }
        self.motions = unused;
        self.assemble_loads();
        let Some(plane) = plane else { return };
        let active = self.equations.active;
        for joint in 0..plane.equations.joints.len() {
            if plane.equations.is_general(joint) {
                let state = &plane.state.joints[joint];
                let extra = plane.equations.constraint_stiffness(&plane.topology, joint, state, plane.fraction);
                self.add_joint_block(joint, &spin_block(&extra), &active);
            }
        }
    }

    /// Factorizes what was assembled.
    pub fn finish(&mut self, inertia: &mut Inertia) {
        let pivots = self.linear.factorize();
        self.join(inertia, &pivots);
        self.factorize_skew(inertia);
    }

    fn join(&self, inertia: &mut Inertia, pivots: &Pivots) {
        inertia.negative += pivots.negative + self.released_negative;
        inertia.neutral += pivots.neutral + self.released_neutral;
        inertia.smallest = inertia.smallest.min(pivots.smallest);
    }

    fn condense(&mut self) {
        if self.parallel {
            self.packs.par_iter_mut().for_each(|pack| pack.condense());
        } else {
            self.packs.iter_mut().for_each(|pack| pack.condense());
        }
    }

    /// The ends of a member as the reduction needs them.
    pub fn end_info<'a>(&'a self, index: usize, ends: [[f64; 6]; 2]) -> [End<'a>; 2] {
        let member = &self.structure.members[index];
        std::array::from_fn(|end| {
            let link = &self.topology.links[member.nodes[end]];
            let joint = &self.state.joints[link.joint];
            let f = ends[end];
            End {
                kind: &self.topology.ends[index][end],
                release: &self.state.releases[index][end],
                joint_rotation: joint.place.rotation,
                lever: if link.has_arm() { turn(joint.place.rotation, link.arm) } else { [0.0; 3] },
                tangent: self.members[index].tangents[end],
                force: [f[0], f[1], f[2]],
                moment: [f[3], f[4], f[5]],
            }
        })
    }

    fn assemble_member(&mut self, index: usize, pending: bool, moved: &mut [[f64; 6]]) {
        let (pack, lane) = (self.members[index].pack, self.members[index].lane);
        let ends: Ends<f64, D> = self.packs[pack].condensed(lane);
        let active = self.equations.active;
        let mut full = [[0.0; 6]; 2];
        for (i, &component) in active.iter().enumerate() {
            full[0][component] = ends.r0[i];
            full[1][component] = ends.r1[i];
        }
        self.members[index].ends = full;
        for end in full {
            self.note_scale(&end);
        }
        let mut factor = self.members[index].factor;
        let reduced = reduce::reduce(&ends, &active, &self.end_info(index, full), &mut factor);
        if self.members[index].released {
            self.members[index].factor = factor;
            self.released_negative += reduced.negative;
            self.released_neutral += reduced.neutral;
            if reduced.neutral > 0 {
                self.idle_members.push(index);
            }
        }
        let nodes = self.structure.members[index].nodes;
        let joints = nodes.map(|n| self.topology.links[n].joint);
        self.add_reduced(&reduced, joints, pending, moved);
        add_local(&self.equations, &reduced, &joints, &self.scatter[index], &mut self.linear.values);
    }

    fn note_scale(&mut self, force: &[f64; 6]) {
        self.force_scale = self.force_scale.max(norm([force[0], force[1], force[2]]));
        self.moment_scale = self.moment_scale.max(norm([force[3], force[4], force[5]]));
    }

    /// Takes the stiffness of the last assembly as that of the unloaded structure, which pivots are measured by.
    pub fn note_rest(&mut self) {
        self.rest_stiffness.copy_from_slice(&self.stiffness);
        self.measure_by_rest();
    }

    fn measure_by_rest(&mut self) {
        for joint in 0..self.rest_stiffness.len() {
            let equations = &self.equations.joints[joint];
            for e in 0..equations.count {
                let mut local = [0.0; 6];
                local[e] = 1.0;
                let motion = unit_motion(&self.equations, joint, &local[..equations.count]);
                let sum: f64 = (0..6).map(|c| motion[c] * motion[c] * self.rest_stiffness[joint][c].abs()).sum();
                self.linear.rest[equations.first + e] = sum;
            }
        }
    }

    /// Adds the force of a reduced member to its joints, and what pending motions make of its stiffness.
    fn add_reduced(&mut self, reduced: &Reduced, joints: [usize; 2], pending: bool, moved: &mut [[f64; 6]]) {
        let active = self.equations.active;
        for end in 0..2 {
            for (i, &component) in active.iter().enumerate() {
                let row = end * D + i;
                self.forces[joints[end]][component] += reduced.force[row];
                self.stiffness[joints[end]][component] += reduced.stiffness[row][row];
            }
        }
        if !pending {
            return;
        }
        for from in 0..2 {
            let motion = self.equations.pending[joints[from]];
            if motion == [0.0; 6] {
                continue;
            }
            for to in 0..2 {
                for (i, &row) in active.iter().enumerate() {
                    for (j, &column) in active.iter().enumerate() {
                        moved[joints[to]][row] += reduced.stiffness[to * D + i][from * D + j] * motion[column];
                    }
                }
            }
        }
    }

    fn pose(&self, node: NodeId) -> Pose<f64> {
        let link = &self.topology.links[node];
        let state = &self.state.joints[link.joint];
        Pose { displacement: state.point(link.arm), rotation: state.place.rotation }
    }

    fn assemble_spring(&mut self, index: usize, pending: bool, moved: &mut [[f64; 6]]) {
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
                let r = spring::coupling(stiffness, arm, [&self.pose(nodes[0]), &self.pose(nodes[1])]);
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
            add_local(&self.equations, &single, &joints[..1], &self.spring_scatter[index], &mut self.linear.values);
        } else {
            self.add_reduced(&reduced, joints, pending, moved);
            add_local(&self.equations, &reduced, &joints, &self.spring_scatter[index], &mut self.linear.values);
        }
    }

    /// In the plane the rotation of a ground spring counts whole turns.
    fn ground_response(&self, node: NodeId, stiffness: &[f64; 6]) -> SpringResponse {
        let mut response = spring::ground(stiffness, &self.pose(node));
        if D == 3 && self.equations.active.contains(&5) {
            let angle = self.state.joints[self.topology.links[node].joint].place.angle;
            let reduced = pennate_elements::rotation::log(self.pose(node).rotation)[2];
            response.energy += 0.5 * stiffness[5] * (angle * angle - reduced * reduced);
            response.gradient[5] = stiffness[5] * angle;
            response.tangent[5][5] = stiffness[5];
        }
        response
    }

    fn assemble_loads(&mut self) {
        self.skew.joints.clear();
        let active = self.equations.active;
        for position in 0..self.loaded_nodes.len() {
            let node = self.loaded_nodes[position];
            let load = self.loads[node];
            let link = self.topology.links[node];
            let rotation = self.state.joints[link.joint].place.rotation;
            let lever = if link.has_arm() { turn(rotation, link.arm) } else { [0.0; 3] };
            let follower = turn(rotation, load.follower_force);
            let follower_moment = turn(rotation, load.follower_moment);
            let force = add(load.force, follower);
            let moment = add(load.moment, follower_moment);
            let total = add(moment, cross(lever, force));
            self.note_scale(&[force[0], force[1], force[2], moment[0], moment[1], moment[2]]);
            let target = &mut self.forces[link.joint];
            for c in 0..3 {
                target[c] -= force[c];
                target[3 + c] -= total[c];
            }
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
            self.add_joint_block(link.joint, &block, &active);
        }
    }

    /// Adds the symmetric part of a joint's block to the matrix, and puts its skew part aside.
    fn add_joint_block(&mut self, joint: usize, block: &[[f64; 6]; 6], active: &Active<D>) {
        let equations = &self.equations.joints[joint];
        let count = equations.count;
        let mut small = nalgebra::SMatrix::<f64, 6, 6>::zeros();
        let mut solution = vec_zero();
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
        for &(i, j, position) in &self.joint_scatter[joint].entries {
            self.linear.values[position as usize] += symmetric[(i as usize, j as usize)];
        }
        let rest = small - symmetric;
        if rest.amax() > 1e-14 * small.amax() && rest.amax() > 0.0 {
            match self.skew.joints.iter_mut().find(|(j, _)| *j == joint) {
                Some((_, n)) => *n += rest,
                None => self.skew.joints.push((joint, rest)),
            }
        }
    }

    fn add_constraint_stiffness(&mut self) {
        let active = self.equations.active;
        for joint in 0..self.equations.joints.len() {
            if !self.equations.is_general(joint) {
                continue;
            }
            let state = self.state.joints[joint];
            let extra = self.equations.constraint_stiffness(&self.topology, joint, &state, self.fraction);
            self.add_joint_block(joint, &spin_block(&extra), &active);
        }
    }

    /// Whether every load has a potential, at the present state.
    pub fn has_potential(&self) -> bool {
        self.skew.joints.is_empty()
    }

    /// Whether the loads at the present drives have a potential; leaves forces and matrix to the next assembly.
    pub fn loads_have_potential(&mut self) -> bool {
        self.equations.update(&self.topology, &self.state.joints, self.fraction);
        self.assemble_loads();
        self.has_potential()
    }

    fn factorize_skew(&mut self, inertia: &mut Inertia) {
        if self.skew.joints.is_empty() {
            return;
        }
        let size = self.linear.size();
        let count = self.skew.joints.len() * SKEW_COLUMNS;
        self.skew.columns.clear();
        self.skew.columns.resize(count * size, 0.0);
        for (k, (joint, _)) in self.skew.joints.iter().enumerate() {
            let equations = &self.equations.joints[*joint];
            for e in 0..equations.count {
                self.skew.columns[(k * SKEW_COLUMNS + e) * size + equations.first + e] = 1.0;
            }
        }
        self.linear.solve(&mut self.skew.columns, count);
        let mut small = nalgebra::DMatrix::identity(count, count);
        for (k, (joint, n)) in self.skew.joints.iter().enumerate() {
            let equations = &self.equations.joints[*joint];
            for column in 0..count {
                for a in 0..equations.count {
                    let mut sum = 0.0;
                    for b in 0..equations.count {
                        sum += n[(a, b)] * self.skew.columns[column * size + equations.first + b];
                    }
                    small[(k * SKEW_COLUMNS + a, column)] += sum;
                }
            }
        }
        let lu = small.clone().lu();
        inertia.skew_negative = lu.determinant() < 0.0;
        self.skew.small = small;
        self.skew.solver = Some(lu);
    }

    /// K⁻¹ b in place, loads without a potential included.
    pub fn solve_in_place(&mut self, b: &mut [f64]) -> bool {
        if !self.linear.solve(b, 1) {
            return false;
        }
        let size = self.linear.size();
        let Some(lu) = &self.skew.solver else { return true };
        if self.skew.joints.is_empty() {
            return true;
        }
        let mut small = nalgebra::DVector::zeros(self.skew.small.nrows());
        for (k, (joint, n)) in self.skew.joints.iter().enumerate() {
            let equations = &self.equations.joints[*joint];
            for a in 0..equations.count {
                for c in 0..equations.count {
                    small[k * SKEW_COLUMNS + a] += n[(a, c)] * b[equations.first + c];
                }
            }
        }
        if !lu.solve_mut(&mut small) {
            return false;
        }
        for (column, factor) in small.iter().enumerate() {
            for i in 0..size {
                b[i] -= factor * self.skew.columns[column * size + i];
            }
        }
        b.iter().all(|x| x.is_finite())
    }

    /// What residuals of forces and moments are measured by: the largest of their kind, and no less than what rounding
    /// makes of the stiffness.
    fn scales(&self) -> (f64, f64) {
        let (force, moment) = (self.force_scale, self.moment_scale);
        (
            force.max(1e-3 * moment / self.size).max(self.noise[0]).max(f64::MIN_POSITIVE),
            moment.max(1e-3 * force * self.size).max(self.noise[1]).max(f64::MIN_POSITIVE),
        )
    }

    /// Residual of the joints, forces and moments apart.
    pub fn residual(&self) -> Residual {
        let mut residual = Residual::default();
        let (force_scale, moment_scale) = self.scales();
        let mut worst = -1.0;
        for joint in 0..self.forces.len() {
            let free = self.equations.unbalanced(joint, &self.forces[joint]);
            for (c, x) in free.iter().enumerate() {
                let relative = x.abs() / if c < 3 { force_scale } else { moment_scale };
                let target = if c < 3 { &mut residual.force } else { &mut residual.moment };
                *target = if relative.is_nan() { f64::INFINITY } else { target.max(relative) };
                if relative > worst {
                    worst = relative;
                    residual.worst_joint = joint;
                    residual.worst_component = c;
                }
            }
        }
        residual
    }

    /// Solves for the increment at the last assembly and moves the state by it; `None` where there is no solution.
    pub fn advance(&mut self, pending: bool) -> Option<Size> {
        let mut solution = std::mem::take(&mut self.rhs);
        solution.iter_mut().for_each(|x| *x = -*x);
        let solved = self.solve_in_place(&mut solution);
        let size = solved.then(|| self.move_by(&solution, pending));
        self.rhs = solution;
        size
    }

    /// Moves joints, ends and interiors by a solution of the joint equations.
    pub fn move_by(&mut self, solution: &[f64], pending: bool) -> Size {
        let mut motions = std::mem::take(&mut self.motions);
        for (joint, motion) in motions.iter_mut().enumerate() {
            *motion = self.equations.motion(joint, solution, pending);
        }
        let active = self.equations.active;
        let structure = self.structure.clone();
        let topology = self.topology.clone();
        let mut size = Size::default();
        // Increments of the ends, at the state before the move.
        for index in 0..self.members.len() {
            let nodes = structure.members[index].nodes;
            let moves: [[f64; 6]; 2] = nodes.map(|n| self.node_motion(&topology.links[n], &motions));
            let kinds = [&topology.ends[index][0], &topology.ends[index][1]];
            let slot = &self.members[index];
            let (ends, free) = reduce::recover(&active, kinds, &slot.factor, &moves);
            self.packs[slot.pack].set_increment(slot.lane, &ends);
            if slot.released {
                for end in 0..2 {
                    let joint = topology.links[nodes[end]].joint;
                    let mut after = self.state.joints[joint];
                    after.advance(&motions[joint]);
                    let slot = &self.members[index];
                    reduce::move_release(
                        kinds[end],
                        end,
                        &slot.factor,
                        &free,
                        (after.place.rotation, after.place.angle),
                        &mut self.state.releases[index][end],
                    );
                }
            }
        }
        if self.parallel {
            self.packs.par_iter_mut().for_each(|pack| pack.advance());
        } else {
            self.packs.iter_mut().for_each(|pack| pack.advance());
        }
        for slot in &self.members {
            size = size.join(self.packs[slot.pack].size(slot.lane));
        }
        for (state, motion) in self.state.joints.iter_mut().zip(&motions) {
            state.advance(motion);
            let (u, spin) = ([motion[0], motion[1], motion[2]], [motion[3], motion[4], motion[5]]);
            size = size.join(Size { rotation: norm(spin), displacement: norm(u) / self.size });
        }
        self.motions = motions;
        if pending {
            self.equations.enforce(&mut self.state.joints, self.fraction);
        }
        self.place_ends();
        size
    }

    fn node_motion(&self, link: &crate::joints::Link, motions: &[[f64; 6]]) -> [f64; 6] {
        let mut motion = motions[link.joint];
        if link.has_arm() {
            let lever = turn(self.state.joints[link.joint].place.rotation, link.arm);
            let shift = cross([motion[3], motion[4], motion[5]], lever);
            for c in 0..3 {
                motion[c] += shift[c];
            }
        }
        motion
    }

    /// Puts the ends of all chains where their joints are.
    pub fn place_ends(&mut self) {
        for index in 0..self.members.len() {
            let slot = &self.members[index];
            for end in 0..2 {
                let link = self.topology.links[self.structure.members[index].nodes[end]];
                let joint = &self.state.joints[link.joint];
                let mut place = joint.place;
                place.displacement = joint.point(link.arm);
                if self.topology.ends[index][end] != EndKind::Welded {
                    let release = &self.state.releases[index][end];
                    place.rotation = release.rotation;
                    place.angle = release.angle;
                }
                self.packs[slot.pack].set_end(slot.lane, end, &place);
            }
        }
    }

    /// Geometric stiffness by the stresses of the present strains instead of mixed ones.
    pub fn set_plain(&mut self, plain: bool) {
        self.packs.iter_mut().for_each(|pack| pack.set_plain(plain));
    }

    /// Part of a diagonal entry below which its pivot has no sign; until the next [`System::hold`].
    pub fn set_pivot_noise(&mut self, noise: f64) {
        self.linear.noise = noise;
        self.packs.iter_mut().for_each(|pack| pack.set_pivot_noise(noise));
    }

    /// Takes the shape of a saved state, and a part of the change of the mixed stresses since.
    pub fn restore_shape(&mut self, slot: usize, part: f64) {
        copy_state(&self.saved[slot], &mut self.state);
        self.packs.iter_mut().for_each(|pack| pack.restore_shape(slot, part));
    }

    /// How far the present state is from a saved one.
    pub fn distance(&self, slot: usize) -> Size {
        let joints = self.state.joints.iter().zip(&self.saved[slot].joints).map(|(a, b)| Size {
            rotation: norm(between(b.place.rotation, a.place.rotation)),
            displacement: norm(sub(a.place.displacement, b.place.displacement)) / self.size,
        });
        let members = self.members.iter().map(|m| self.packs[m.pack].distance(m.lane, slot));
        joints.chain(members).fold(Size::default(), Size::join)
    }

    pub fn save(&mut self, slot: usize) {
        copy_state(&self.state, &mut self.saved[slot]);
        self.packs.iter_mut().for_each(|pack| pack.save(slot));
    }

    pub fn restore(&mut self, slot: usize) {
        copy_state(&self.saved[slot], &mut self.state);
        self.packs.iter_mut().for_each(|pack| pack.restore(slot));
    }

    /// Keeps the state put aside in `last` as `before`, and puts aside the present one.
    pub fn save_as(&mut self, last: usize, before: usize) {
        let state = std::mem::take(&mut self.saved[last]);
        self.saved[last] = std::mem::replace(&mut self.saved[before], state);
        self.packs.iter_mut().for_each(|pack| pack.swap(last, before));
        self.save(last);
    }

    /// Whether the present state is much farther from the last saved one than that was from the one before.
    pub fn jumped(&self, last: usize, before: usize, has_before: bool) -> bool {
        let far = |a: &State, b: &State| {
            a.joints
                .iter()
                .zip(&b.joints)
                .fold(0.0f64, |far, (a, b)| far.max(norm(sub(a.place.displacement, b.place.displacement)) / self.size))
        };
        let now = far(&self.state, &self.saved[last]);
        let then = if has_before { far(&self.saved[last], &self.saved[before]) } else { 0.0 };
        now > (10.0 * then).max(0.05)
    }

    /// The joint that moves most in the softest motion of the last factorization.
    pub fn softest_joint(&mut self) -> usize {
        let size = self.linear.size();
        let mut x: Vec<f64> = (0..size).map(|i| (1.3 * i as f64 + 0.7).sin()).collect();
        for _ in 0..5 {
            if !self.linear.solve(&mut x, 1) {
                break;
            }
            let length = x.iter().map(|x| x * x).sum::<f64>().sqrt();
            x.iter_mut().for_each(|x| *x /= length.max(f64::MIN_POSITIVE));
        }
        let mut best = (0, 0.0);
        for joint in 0..self.forces.len() {
            let m = self.equations.motion(joint, &x, false);
            let moves = (norm([m[0], m[1], m[2]]) / self.size).max(1e-3 * norm([m[3], m[4], m[5]]));
            if moves > best.1 {
                best = (joint, moves);
            }
        }
        best.0
    }

    /// Extrapolates linearly from two saved states.
    pub fn predict(&mut self, before: usize, last: usize, ratio: f64) {
        for joint in 0..self.state.joints.len() {
            let (a, b) = (self.saved[before].joints[joint], self.saved[last].joints[joint]);
            self.state.joints[joint] = b;
            let spin = between(a.place.rotation, b.place.rotation);
            let spin = if D == 3 { [0.0, 0.0, b.place.angle - a.place.angle] } else { spin };
            let step = sub(b.place.displacement, a.place.displacement);
            let mut motion = [0.0; 6];
            for c in 0..3 {
                motion[c] = ratio * step[c];
                motion[3 + c] = ratio * spin[c];
            }
            self.state.joints[joint].advance(&motion);
        }
        for (index, kinds) in self.topology.ends.iter().enumerate() {
            for (end, kind) in kinds.iter().enumerate() {
                if *kind == EndKind::Welded {
                    continue;
                }
                let (a, b) = (self.saved[before].releases[index][end], self.saved[last].releases[index][end]);
                let target = &mut self.state.releases[index][end];
                *target = b;
                let spin = scale(ratio, between(a.rotation, b.rotation));
                for t in 0..2 {
                    target.turns[t] += ratio * (b.turns[t] - a.turns[t]);
                }
                target.angle += ratio * (b.angle - a.angle);
                target.rotation =
                    pennate_elements::rotation::compose(pennate_elements::rotation::exp(spin), b.rotation);
                if let EndKind::Axes(axes) = kind {
                    let node = self.structure.members[index].nodes[end];
                    let joint = self.state.joints[self.topology.links[node].joint].place;
                    let turned = axes.iter().zip(target.turns).fold([0.0; 3], |s, (a, t)| add(s, scale(t, *a)));
                    target.rotation =
                        pennate_elements::rotation::compose(joint.rotation, pennate_elements::rotation::exp(turned));
                    target.angle = joint.angle + turned[2];
                }
            }
        }
        self.packs.iter_mut().for_each(|pack| pack.predict(before, last, ratio));
        self.equations.enforce(&mut self.state.joints, self.fraction);
        self.place_ends();
    }

    /// Takes over the state of a system with the same elements and another order.
    pub fn prolong(&mut self, coarse: &Self) {
        copy_state(&coarse.state, &mut self.state);
        self.drives.copy_from_slice(&coarse.drives);
        self.prestress = coarse.prestress;
        self.fraction = coarse.fraction;
        for (fine, coarse) in self.packs.iter_mut().zip(&coarse.packs) {
            fine.prolong(coarse.as_ref());
        }
        self.apply_drives();
        self.place_ends();
    }
}

impl System<6> {
    /// Takes over the state of the same network solved in the plane.
    pub fn lift(&mut self, plane: &System<3>) {
        copy_state(&plane.state, &mut self.state);
        for joint in &mut self.state.joints {
            joint.theta = [0.0, 0.0, joint.place.angle];
        }
        self.drives.copy_from_slice(&plane.drives);
        self.prestress = plane.prestress;
        self.fraction = plane.fraction;
        for (space, plane) in self.packs.iter_mut().zip(&plane.packs) {
            space.lift(plane.as_ref());
        }
        self.apply_drives();
        self.place_ends();
    }
}

/// A 3 × 3 block on the spins of a joint.
fn spin_block(a: &M3<f64>) -> [[f64; 6]; 6] {
    std::array::from_fn(|i| std::array::from_fn(|j| if i >= 3 && j >= 3 { a[i - 3][j - 3] } else { 0.0 }))
}

fn between(a: [f64; 4], b: [f64; 4]) -> V3<f64> {
    use pennate_elements::rotation::{compose, inverse, log};
    log(compose(b, inverse(a)))
}

fn copy_state(from: &State, to: &mut State) {
    to.joints.copy_from_slice(&from.joints);
    to.releases.copy_from_slice(&from.releases);
}

fn vec_zero() -> [f64; 6] {
    [0.0; 6]
}

/// Motion of a joint for a solution of its own equations alone.
fn unit_motion<const D: usize>(equations: &Equations<D>, joint: usize, local: &[f64]) -> [f64; 6] {
    let own = &equations.joints[joint];
    let mut motion = [0.0; 6];
    match &own.basis {
        crate::joints::Basis::Components(components) => {
            for (c, e) in components.iter().enumerate() {
                if let Some(e) = e {
                    motion[c] = local[*e];
                }
            }
        }
        crate::joints::Basis::Columns(columns) => {
            for (e, column) in columns[..own.count].iter().enumerate() {
                for c in 0..6 {
                    motion[c] += local[e] * column[c];
                }
            }
        }
    }
    motion
}

/// Adds a reduced stiffness of one or two joints to the matrix.
fn add_local<const D: usize>(
    equations: &Equations<D>,
    reduced: &Reduced,
    joints: &[usize],
    scatter: &Scatter,
    values: &mut [f64],
) {
    let mut rows = [0usize; 12];
    let mut count = 0;
    let simple = joints.iter().all(|&joint| !equations.is_general(joint));
    if simple {
        for (end, &joint) in joints.iter().enumerate() {
            if let crate::joints::Basis::Components(components) = &equations.joints[joint].basis {
                for (i, &component) in equations.active.iter().enumerate() {
                    if components[component].is_some() {
                        rows[count] = end * D + i;
                        count += 1;
                    }
                }
            }
        }
        for &(i, j, position) in &scatter.entries {
            values[position as usize] += reduced.stiffness[rows[i as usize]][rows[j as usize]];
        }
        return;
    }
    // Motions of the local equations in components, then Bᵀ K B.
    let mut basis = [[0.0; 12]; 12];
    for (end, &joint) in joints.iter().enumerate() {
        let own = &equations.joints[joint];
        for e in 0..own.count {
            let mut local = [0.0; 6];
            local[e] = 1.0;
            let motion = unit_motion(equations, joint, &local);
            for (i, &component) in equations.active.iter().enumerate() {
                basis[count][end * D + i] = motion[component];
            }
            count += 1;
        }
    }
    let n = joints.len() * D;
    let mut half = [[0.0; 12]; 12];
    for a in 0..count {
        for j in 0..n {
            half[a][j] = (0..n).map(|i| basis[a][i] * reduced.stiffness[i][j]).sum();
        }
    }
    for &(i, j, position) in &scatter.entries {
        let sum: f64 = (0..n).map(|c| half[i as usize][c] * basis[j as usize][c]).sum();
        values[position as usize] += sum;
    }
}

fn spring_nodes(spring: &Spring) -> Vec<NodeId> {
    match spring {
        Spring::Ground { node, .. } => vec![*node],
        Spring::Axial { nodes, .. } | Spring::Coupling { nodes, .. } => nodes.to_vec(),
    }
}

/// Nodes that any drive, or the weight of a body, may load.
fn loaded_nodes(structure: &Structure) -> Vec<NodeId> {
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

/// Largest extent of the network.
fn extent(nodes: &[[f64; 3]]) -> f64 {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for node in nodes {
        for c in 0..3 {
            low[c] = low[c].min(node[c]);
            high[c] = high[c].max(node[c]);
        }
    }
    let size = norm(std::array::from_fn(|c| if high[c] > low[c] { high[c] - low[c] } else { 0.0 }));
    if size > 0.0 { size } else { 1.0 }
}

fn end_tangents(member: &crate::structure::Member) -> [V3<f64>; 2] {
    use pennate_elements::rotation::{exp, matrix};
    let mut axes = member.axes;
    for segment in &member.segments {
        let frame = matrix(exp(scale(segment.length, segment.initial_curvature)));
        axes = pennate_elements::small::tmul(&frame, &axes);
    }
    [member.axes[0], axes[0]]
}

/// Section with every stiffness finite, for a tangent that is no residual (out of the plane).
pub fn finite_stiffness(section: &Section, element_length: f64, turn: &Turn) -> [f64; 6] {
    let state = SectionState { section: *section, strain: 0.0, curvature: [0.0; 3] };
    packs::moduli(&state, element_length, turn).stiffness
}
