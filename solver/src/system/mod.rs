//! Residual and tangent of the joints; owns every large buffer.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use pennate_elements::beam::Ends;
use pennate_elements::rotation::turn;
use pennate_elements::small::{M3, V3, norm, scale, sub};

use crate::chain::{Pack, Size};
use crate::held::HeldForces;
use crate::joints::{Active, EndKind, Equations, Held, HeldKind, JointState, Topology};
use crate::linear::{Pivots, Symmetric};
use crate::packs::{self, Auxiliary, Turn};
use crate::reduce::{self, End, MAX_FREE, Reduced, ReleaseFactor, ReleaseState};
use crate::structure::{MemberId, NodeId, SectionState, Structure};

mod adopt;
mod advance;
mod after;
mod carriers;
mod certain;
mod dashpots;
mod explicit;
mod loads;
mod parts;
mod rates;
mod remainder;
mod scatter;
mod skew;
mod springs;
mod states;
mod turned;

use carriers::Carrier;
use loads::{Sections, loaded_nodes};
use parts::Parts;
pub use rates::Linearized;
use scatter::{Scatters, add_local, unit_motion};
use skew::Skew;
pub use states::State;

/// Where joints and released ends are.
#[derive(Debug, Default)]
pub struct Places {
    /// By index of the joint.
    pub joints: Vec<JointState>,
    /// Rotations of released ends, by index of the member.
    pub releases: Vec<[ReleaseState; 2]>,
}

impl Clone for Places {
    fn clone(&self) -> Self {
        Self { joints: self.joints.clone(), releases: self.releases.clone() }
    }

    /// Without allocation, where both are of one system.
    fn clone_from(&mut self, from: &Self) {
        self.joints.clone_from(&from.joints);
        self.releases.clone_from(&from.releases);
    }
}

impl Places {
    /// Takes over the places in a system of the same topology.
    fn copy_from(&mut self, from: &Self) {
        self.joints.copy_from_slice(&from.joints);
        self.releases.copy_from_slice(&from.releases);
    }
}

/// Loads on one node, at the present values of the drives.
#[derive(Clone, Copy, Debug, Default)]
pub struct NodeLoad {
    /// Dead force, in global axes.
    pub force: V3<f64>,
    /// Dead moment, in global axes.
    pub moment: V3<f64>,
    /// Components in the unloaded state.
    pub follower_force: V3<f64>,
    /// Components in the unloaded state.
    pub follower_moment: V3<f64>,
}

/// A force and a moment on a node that fade over a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fading {
    /// The node that is set free.
    pub node: NodeId,
    /// Reaction force at the beginning of the step, in global axes.
    pub force: V3<f64>,
    /// Reaction moment at the beginning of the step, in global axes.
    pub moment: V3<f64>,
}

/// Largest residual of the joints, over the scale of its kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    /// Of forces, over the largest force that acts on a joint.
    pub force: f64,
    /// Of moments, over the largest moment that acts on a joint.
    pub moment: f64,
    /// Index of the joint where most is left.
    pub worst_joint: usize,
    /// Component there: 0, 1, 2 of force, 3, 4, 5 of moment.
    pub worst_component: usize,
}

impl Residual {
    /// The larger of both.
    pub fn largest(&self) -> f64 {
        self.force.max(self.moment)
    }
}

/// Pivots of a whole network: joints, interiors, released ends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inertia {
    /// Negative pivots.
    pub negative: usize,
    /// Pivots that are rounding.
    pub neutral: usize,
    /// Pivots that would be rounding in an unloaded structure, neutral ones included.
    pub idle: usize,
    /// The smallest pivot, over the largest stiffness of its component.
    pub smallest: f64,
    /// Sign of the determinant of the unsymmetric correction.
    pub skew_negative: bool,
}

impl Inertia {
    /// Whether the determinant of the whole tangent is negative.
    pub fn is_odd(&self) -> bool {
        (self.negative % 2 == 1) != self.skew_negative
    }
}

/// A member's place among the packs, and what its ends are.
#[derive(Clone, Debug)]
pub struct MemberSlot {
    /// Index of its pack.
    pub pack: usize,
    /// Its lane in the pack.
    pub lane: usize,
    /// From its axes to those of its chain.
    pub turn: Turn,
    /// Unloaded tangents at both ends.
    pub tangents: [V3<f64>; 2],
    /// Factors of its released rotations.
    pub factor: ReleaseFactor,
    /// Whether an end of it is released.
    pub released: bool,
    /// Moves of its released rotations in the last increment.
    pub moves: [f64; MAX_FREE],
    /// Forces on the ends at the last assembly.
    pub ends: [[f64; 6]; 2],
}

/// The equations of a structure in D components a joint.
pub struct System<const D: usize> {
    /// Section laws are replaced by [`System::set_laws`] alone: members that are as they were keep their stiffness.
    pub structure: Arc<Structure>,
    /// The structure as joints and member ends.
    pub topology: Arc<Topology>,
    /// Chains of all members, those of equal mesh side by side.
    pub packs: Vec<Box<dyn Pack<D>>>,
    /// Where every member is among them.
    pub members: Vec<MemberSlot>,
    /// Where joints and released ends are.
    pub state: Places,
    /// Present values of the drives.
    pub drives: Vec<f64>,
    /// Part of the springs' misfit that is in place.
    pub prestress: f64,
    unstressed: Vec<f64>,
    /// Part of the step's ramp.
    pub fraction: f64,
    /// Free and held components of the joints.
    pub equations: Equations<D>,
    /// The symmetric part of the tangent of the joints, and its factors.
    pub linear: Symmetric,
    scatters: Arc<Scatters>,
    /// Whether the structure is that of designs side by side, one or many: their joints are eliminated block by block. Counts from
    /// the next [`System::hold`].
    pub in_blocks: bool,
    /// Internal less external force of every joint.
    pub forces: Vec<[f64; 6]>,
    /// Present loads by index of the node.
    pub loads: Vec<NodeLoad>,
    loaded_nodes: Vec<NodeId>,
    /// Reactions of what a step sets free: they fall to zero over it.
    pub fading: Vec<Fading>,
    /// Forces of axial springs, positive in tension; zero of others.
    pub spring_forces: Vec<f64>,
    /// Energy of all springs.
    pub spring_energy: f64,
    /// Right-hand side of the equations, then their solution.
    pub rhs: Vec<f64>,
    motions: Vec<[f64; 6]>,
    skew: Skew,
    /// Memory of the last solve, of forces that held rows bear.
    pub held_forces: HeldForces,
    /// Largest force that acts on a joint.
    pub force_scale: f64,
    /// Largest moment that acts on a joint, no smaller than 1e-3 of force times size.
    pub moment_scale: f64,
    /// Largest extent of the unloaded structure along an axis.
    pub size: f64,
    /// See [`crate::options::Options::stop`].
    pub stop: Option<Arc<AtomicBool>>,
    /// Force and moment that rounding alone may leave: 1e-10 of the stiffness.
    noise: [f64; 2],
    sections: Vec<Sections>,
    /// Stiffness of dashpots for a unit of mass, and the joints of the state that they tie to.
    dashpots: (f64, Vec<JointState>),
    /// See [`packs::AUXILIARY`]; counts from the next [`System::apply_drives`].
    pub auxiliary: Auxiliary,
    holds_strains: bool,
    /// Mass and inertia of the joints, for dashpots; empty until they are asked for.
    masses: Vec<[f64; 2]>,
    parallel: bool,
    /// Joints that a member carries, in the order in which they move.
    carriers: Arc<Vec<Carrier>>,
    carried: Vec<bool>,
    /// Whether nodes move straight along a solution, each on its own, instead of being carried by their members.
    pub straight: bool,
    /// Size of the last increment, without what members and joints move as a whole with what carries them.
    pub own_size: Size,
    /// The same of the first increment of an iteration.
    pub own_first: f64,
    /// Parts of the network that nothing connects, and what each of them moved by in the last increment, and in the first
    /// one of an iteration.
    parts: Parts,
    moves: Vec<Size>,
    /// By how much each part of the network moved in the first increment of an iteration.
    pub first_moves: Vec<Size>,
    scratch: Vec<JointState>,
    released_neutral: usize,
    released_negative: usize,
    last_inertia: Inertia,
    /// How often the state was linearized: what was found at the last linearization holds until the next.
    linearizations: u64,
    /// Sum of the stiffness of members and springs on every component, and the same of the unloaded structure.
    stiffness: Vec<[f64; 6]>,
    rest_stiffness: Vec<[f64; 6]>,
    /// Members with a released rotation that nothing resists, at the last assembly.
    pub idle_members: Vec<MemberId>,
}

impl<const D: usize> System<D> {
    /// A structure at rest, with the chains of its members.
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
                    moves: [0.0; MAX_FREE],
                    released: topology.ends[member].iter().any(|e| *e != EndKind::Welded),
                    ends: [[0.0; 6]; 2],
                });
            }
        }
        let state = Places {
            joints: vec![JointState::default(); joints],
            releases: vec![[ReleaseState::default(); 2]; structure.members.len()],
        };
        let unstressed = structure
            .springs
            .iter()
            .map(|spring| match (spring.natural_length(), spring.pair()) {
                (Some(_), Some([a, b])) => norm(sub(structure.nodes[b], structure.nodes[a])),
                _ => 0.0,
            })
            .collect();
        let size = extent(&structure.nodes);
        let parts = Parts::of(&structure, &topology);
        let sections = vec![Sections::default(); structure.members.len()];
        let mut system = Self {
            equations: Equations::new(&topology, active, Vec::new()),
            linear: Symmetric::new(0, &mut Vec::new(), false),
            scatters: Arc::default(),
            in_blocks: false,
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
            state,
            members: members.into_iter().flatten().collect(),
            packs,
            topology,
            structure,
            held_forces: HeldForces::default(),
            force_scale: 0.0,
            moment_scale: 0.0,
            size,
            stop: None,
            noise: [0.0; 2],
            sections,
            dashpots: (0.0, Vec::new()),
            auxiliary: packs::AUXILIARY,
            holds_strains: false,
            masses: Vec::new(),
            parallel,
            carriers: Arc::default(),
            carried: vec![false; joints],
            straight: false,
            own_size: Size::default(),
            own_first: 0.0,
            moves: vec![Size::default(); parts.count],
            first_moves: Vec::new(),
            parts,
            scratch: Vec::new(),
            released_neutral: 0,
            released_negative: 0,
            last_inertia: Inertia::default(),
            linearizations: 0,
            stiffness: vec![[0.0; 6]; joints],
            rest_stiffness: vec![[0.0; 6]; joints],
            idle_members: Vec::new(),
        };
        system.apply_drives();
        system
    }

    /// Whether nobody wants to wait any longer.
    pub fn is_stopped(&self) -> bool {
        self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed))
    }

    /// Sets what is held; analyses the equations anew where that is not the same as before.
    pub fn hold(&mut self, held: Vec<Held>) {
        if self.set_held(held) {
            let links = &self.topology.links;
            let joints = |nodes: &[NodeId]| nodes.iter().map(|&n| links[n].joint).collect::<Vec<_>>();
            let members: Vec<_> = self.structure.members.iter().map(|member| joints(&member.nodes)).collect();
            let springs: Vec<_> = self.structure.springs.iter().map(|spring| joints(spring.nodes())).collect();
            let (linear, scatters) = Scatters::analyse(&self.equations, &members, &springs, self.in_blocks);
            self.linear = linear;
            self.scatters = Arc::new(scatters);
            self.set_carriers(Arc::new(self.find_carriers()));
            self.measure_by_rest();
        }
    }

    /// Holds what another system of the same joints holds; its analysis, which no number depends on, serves both.
    pub fn hold_like(&mut self, other: &Self) {
        if self.set_held(other.equations.held.clone()) {
            self.linear = other.linear.alike();
            self.scatters = Arc::clone(&other.scatters);
            self.set_carriers(Arc::new(self.find_carriers()));
            self.measure_by_rest();
        }
    }

    /// Sets what is held; true where the equations have to be analysed.
    fn set_held(&mut self, held: Vec<Held>) -> bool {
        let held: Vec<Held> = held.into_iter().filter(|h| self.concerns(h)).collect();
        let same = |a: &Held, b: &Held| (a.node, a.component, a.kind) == (b.node, b.component, b.kind);
        let known = &self.equations.held;
        let analysed = self.scatters.joints.len() == self.equations.joints.len();
        let unchanged = known.len() == held.len() && known.iter().zip(&held).all(|(a, b)| same(a, b));
        self.find_loaded_nodes();
        if analysed && unchanged {
            self.equations.held = held;
            return false;
        }
        self.equations = Equations::new(&self.topology, self.equations.active, held);
        self.rhs = vec![0.0; self.equations.size];
        self.skew = Skew::default();
        true
    }

    fn find_loaded_nodes(&mut self) {
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
        let mut inertia = self.gather(pending);
        let pivots = self.linear.factorize();
        self.join(&mut inertia, &pivots);
        self.factorize_skew(&mut inertia);
        self.last_inertia = inertia;
        inertia
    }

    /// Linearizes everything at the present state; pivots are those of the interiors of the members alone.
    pub fn gather(&mut self, pending: bool) -> Inertia {
        self.condense();
        self.collect(pending)
    }

    /// The forces of the present state, by the factors that members have of the one before: for a state that little was moved
    /// since. The stiffness is what it was.
    pub fn refresh(&mut self, pending: bool) {
        self.for_packs(|pack| pack.refresh());
        self.collect(pending);
    }

    /// Puts together what members, springs and loads give.
    fn collect(&mut self, pending: bool) -> Inertia {
        self.linearizations += 1;
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
        self.assemble_dashpots();
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
        inertia
    }

    /// Largest strain that a rigid component of any member still has.
    pub fn violation(&self) -> f64 {
        self.packs.iter().map(|pack| pack.violation()).fold(0.0, f64::max)
    }

    /// A number that changes with every linearization.
    pub fn linearizations(&self) -> u64 {
        self.linearizations
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
        add_local(&self.equations, reduced, &joints, &self.scatters.members[index], &mut self.linear.values);
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
        inertia.idle += pivots.idle + self.released_neutral;
        inertia.smallest = inertia.smallest.min(pivots.smallest);
    }

    fn condense(&mut self) {
        self.for_packs(|pack| pack.condense());
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
        // Few members have a factor, and those that have none should not pay for its copies.
        let released = self.members[index].released;
        let mut factor = released.then(|| self.members[index].factor);
        let reduced = reduce::reduce(&ends, &active, &self.end_info(index, full), factor.as_mut());
        if let Some(factor) = factor {
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
        add_local(&self.equations, &reduced, &joints, &self.scatters.members[index], &mut self.linear.values);
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

    /// Takes the stiffness of the unloaded structure from the same structure on another mesh.
    pub fn take_rest(&mut self, other: &Self) {
        self.rest_stiffness.copy_from_slice(&other.rest_stiffness);
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

    /// What residuals of forces and moments are measured by: the largest of their kind, and no less than what rounding
    /// makes of the stiffness.
    fn scales(&self) -> (f64, f64) {
        let (force, moment) = (self.force_scale, self.moment_scale);
        (
            force.max(1e-3 * moment / self.size).max(self.noise[0]).max(f64::MIN_POSITIVE),
            moment.max(1e-3 * force * self.size).max(self.noise[1]).max(f64::MIN_POSITIVE),
        )
    }

    /// Force that is rounding of the stiffness alone.
    pub fn rounding(&self) -> f64 {
        1e-6 * self.noise[0]
    }

    /// Residual of the joints, forces and moments apart.
    pub fn residual(&self) -> Residual {
        let mut residual = Residual::default();
        let (force_scale, moment_scale) = self.scales();
        let mut worst = -1.0;
        for joint in 0..self.forces.len() {
            // Rows that contradict each other are no equilibrium, whatever the forces.
            let [shift, turn] = self.equations.missed[joint];
            if shift > 1e-9 * self.size || turn > 1e-9 {
                residual.force = 1.0;
            }
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
}

/// A 3 × 3 block on the spins of a joint.
fn spin_block(a: &M3<f64>) -> [[f64; 6]; 6] {
    std::array::from_fn(|i| std::array::from_fn(|j| if i >= 3 && j >= 3 { a[i - 3][j - 3] } else { 0.0 }))
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
