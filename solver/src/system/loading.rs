//! What drives make of a structure: sections, loads along members and loads on nodes.

use pennate_elements::small::{V3, add, norm, scale, sub};

use super::beside::forces_beside;
use super::members::Members;
use super::parts::Parts;
use crate::chain::{MOST_LANES, Pack};
use crate::joints::Topology;
use crate::packs::{self, Auxiliary};
use crate::structure::{Drive, Member, MemberId, NodeId, SectionState, Spring, Structure};

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

impl NodeLoad {
    /// Whether nothing but a dead force acts.
    pub(super) fn is_dead_force(&self) -> bool {
        [self.moment, self.follower_force, self.follower_moment] == [[0.0; 3]; 3]
    }
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

/// Part of what bends the softest member as a whole that the rounding of a sum with others may take.
const BENDS: f64 = 1e-5;

/// What the section stiffness and the load of a member follow from.
#[derive(Clone, Copy, Debug, PartialEq)]
struct MadeOf {
    control: f64,
    auxiliary: Auxiliary,
    carried: f64,
    line: V3<f64>,
    gravity: V3<f64>,
}

/// The sections of a member as they are: most stay what they are from one increment to the next.
#[derive(Clone, Copy, Debug, Default)]
struct Sections {
    made_of: Option<MadeOf>,
    /// The force up to which the auxiliary stiffness of held strains need not follow that of the member; nothing where no strain
    /// is held.
    bears: Option<f64>,
    /// See [`Loading::noise`].
    noise: [f64; 2],
    /// See [`Loading::slenderness`].
    slenderness: f64,
    /// Whether a strain that is not held is stiffer than what holds others.
    is_stiff: bool,
    /// Stiffness of the member against stretch, as held by [`packs::AUXILIARY`] where it is no less, and EI/L³.
    stretch_and_bending: [f64; 2],
}

/// How far loads, pressures and prescribed motions are, and what that makes of sections and nodes.
#[derive(Debug)]
pub struct Loading {
    /// Present values of the drives.
    pub drives: Vec<f64>,
    /// Part of the springs' misfit that is in place.
    pub prestress: f64,
    /// Part of the step's ramp.
    pub fraction: f64,
    /// Reactions of what a step sets free: they fall to zero over it.
    pub fading: Vec<Fading>,
    /// See [`packs::AUXILIARY`]; counts from the next [`super::System::apply_drives`].
    pub auxiliary: Auxiliary,
    /// Present loads by index of the node.
    pub nodes: Vec<NodeLoad>,
    /// Distance of both nodes of every spring without prestress.
    unstressed: Vec<f64>,
    sections: Vec<Sections>,
    /// Sections of all segments, member after member, at the control that their member was made with; and the first of each.
    states: Vec<Option<SectionState>>,
    first_states: Vec<usize>,
    /// Force and moment that rounding alone may leave: 1e-10 of the stiffness.
    noise: [f64; 2],
    slenderness: f64,
    /// Stiffness against stretch and EI/L³, the largest and the least of every part.
    extremes: Vec<[f64; 2]>,
    holds_strains: bool,
    /// Forces by which the network answers to members that cannot be stretched, or hardly.
    beside: Vec<f64>,
}

impl Loading {
    /// Nothing acts yet.
    pub(super) fn new(structure: &Structure, topology: &Topology) -> Self {
        let mut states = 0;
        let mut first = |member: &Member| {
            states += member.segments.len();
            states - member.segments.len()
        };
        let first_states = structure.members.iter().map(&mut first).collect();
        Self {
            states: vec![None; states],
            first_states,
            drives: vec![0.0; structure.drives.len()],
            prestress: 0.0,
            fraction: 0.0,
            fading: Vec::new(),
            auxiliary: packs::AUXILIARY,
            nodes: vec![NodeLoad::default(); structure.nodes.len()],
            unstressed: unstressed(structure).collect(),
            sections: vec![Sections::default(); structure.members.len()],
            noise: [0.0; 2],
            slenderness: 0.0,
            extremes: Vec::new(),
            holds_strains: false,
            beside: forces_beside(structure, topology),
        }
    }

    /// The same of another structure of the same topology and mesh, in the memory at hand; with members or without.
    pub(super) fn renew(&mut self, structure: &Structure, topology: &Topology, has_members: bool) {
        self.states.fill(None);
        self.sections.fill(Sections::default());
        self.drives.fill(0.0);
        (self.prestress, self.fraction) = (0.0, 0.0);
        self.fading.clear();
        self.auxiliary = packs::AUXILIARY;
        self.nodes.fill(NodeLoad::default());
        self.unstressed.clear();
        self.unstressed.extend(unstressed(structure));
        (self.noise, self.slenderness, self.holds_strains) = ([0.0; 2], 0.0, false);
        self.extremes.clear();
        if has_members {
            self.beside = forces_beside(structure, topology);
        }
    }

    /// Takes over how far another one of the same structure is.
    pub(super) fn follow(&mut self, other: &Self) {
        self.drives.copy_from_slice(&other.drives);
        (self.prestress, self.fraction) = (other.prestress, other.fraction);
    }

    /// Stands at the end of a step, with these values of the drives.
    pub(super) fn end(&mut self, drives: &[f64]) {
        self.drives.copy_from_slice(drives);
        (self.prestress, self.fraction) = (1.0, 1.0);
    }

    /// Lets all sections be made anew.
    pub(super) fn forget_sections(&mut self) {
        self.sections.fill(Sections::default());
    }

    /// Section of a segment at the present control.
    pub(crate) fn section(&self, structure: &Structure, member: MemberId, segment: usize) -> SectionState {
        let description = &structure.members[member];
        let control = description.control.map_or(0.0, |drive| self.drives[drive]);
        let made = self.sections[member].made_of.is_some_and(|made_of| made_of.control == control);
        let known = if made { self.states[self.first_states[member] + segment] } else { None };
        known.unwrap_or_else(|| structure.laws[description.segments[segment].law].at(control))
    }

    /// Natural length of a spring, at the part of its misfit that is in place.
    pub(super) fn natural_length(&self, index: usize, spring: &Spring) -> f64 {
        let unstressed = self.unstressed[index];
        unstressed + self.prestress * (spring.natural_length().unwrap_or_default() - unstressed)
    }

    /// Whether the stress of any strain is a number of its own: of one that is held, as in sections rigid in shear or not to be
    /// stretched, or of a stiff one that is eased.
    pub fn holds_strains(&self) -> bool {
        self.holds_strains
    }

    /// Whether any section has a strain so stiff that it may be eased.
    pub(super) fn is_stiff(&self) -> bool {
        self.sections.iter().any(|sections| sections.is_stiff)
    }

    /// Takes another auxiliary stiffness; whether stiff strains are eased stays.
    pub(crate) fn set_auxiliary(&mut self, auxiliary: Auxiliary) {
        self.auxiliary = Auxiliary { eased_from: self.auxiliary.eased_from, ..auxiliary };
    }

    /// Force and moment that rounding alone may leave.
    pub(super) fn noise(&self) -> [f64; 2] {
        self.noise
    }

    /// Slenderness of a member: its length over the radius of gyration, what holds strains included.
    pub fn slenderness_of(&self, member: MemberId) -> f64 {
        self.sections[member].slenderness
    }

    /// Largest slenderness of a member: its length over the radius of gyration, what holds strains included.
    pub(crate) fn slenderness(&self) -> f64 {
        self.slenderness
    }

    /// Whether members of one part are so much stiffer than others that a sum of both in one number costs digits of what these bear.
    pub(super) fn is_diverse(&self) -> bool {
        self.extremes.iter().any(|[stretch, bending]| f64::EPSILON * stretch > BENDS * bending)
    }

    /// Force that is rounding of the stiffness alone.
    pub(crate) fn rounding(&self) -> f64 {
        1e-6 * self.noise[0]
    }

    /// Brings loads on nodes, sections and loads along members up to date with the drives; `size` is that of the network.
    pub(super) fn apply<const D: usize>(
        &mut self,
        structure: &Structure,
        members: &mut Members<D>,
        parts: &Parts,
        size: f64,
    ) {
        let mut gravity = [0.0; 3];
        let mut along: Vec<(MemberId, V3<f64>)> = Vec::new();
        self.nodes.fill(NodeLoad::default());
        for (drive, &value) in structure.drives.iter().zip(&self.drives) {
            match *drive {
                Drive::Control => {}
                Drive::Force(node, c) => self.nodes[node].force[c] += value,
                Drive::Moment(node, c) => self.nodes[node].moment[c] += value,
                Drive::FollowerForce(node, c) => self.nodes[node].follower_force[c] += value,
                Drive::FollowerMoment(node, c) => self.nodes[node].follower_moment[c] += value,
                Drive::Gravity(c) => gravity[c] += value,
                Drive::Distributed(member, c) => {
                    let mut load = [0.0; 3];
                    load[c] = value;
                    along.push((member, load));
                }
            }
        }
        for fading in &self.fading {
            let load = &mut self.nodes[fading.node];
            load.force = add(load.force, scale(1.0 - self.fraction, fading.force));
            load.moment = add(load.moment, scale(1.0 - self.fraction, fading.moment));
        }
        if gravity != [0.0; 3] {
            for body in &structure.bodies {
                let load = &mut self.nodes[body.reference].force;
                *load = add(*load, scale(body.mass, gravity));
            }
        }
        let mut line = vec![[0.0; 3]; if along.is_empty() { 0 } else { structure.members.len() }];
        for (member, load) in along {
            line[member] = add(line[member], load);
        }
        (self.noise, self.slenderness) = ([0.0; 2], 0.0);
        self.extremes.clear();
        self.extremes.resize(parts.count, [0.0, f64::INFINITY]);
        for pack in 0..members.packs.len() {
            let forces = self.carried_forces(members.packs[pack].as_ref());
            for lane in 0..members.packs[pack].mesh().members.len() {
                let (member, carried) = (members.packs[pack].mesh().members[lane], forces[lane]);
                let control = structure.members[member].control.map_or(0.0, |drive| self.drives[drive]);
                let line = line.get(member).copied().unwrap_or([0.0; 3]);
                let made_of = MadeOf { control, auxiliary: self.auxiliary, carried, line, gravity };
                if self.sections[member].made_of.as_ref() != Some(&made_of) {
                    let states = &mut self.states[self.first_states[member]..];
                    self.sections[member] = made_of.put(structure, members, member, size, states);
                    self.holds_strains |= self.sections[member].bears.is_some();
                }
                for (noise, own) in self.noise.iter_mut().zip(self.sections[member].noise) {
                    *noise = noise.max(own);
                }
                self.slenderness = self.slenderness.max(self.sections[member].slenderness);
                let [stretch, bending] = self.sections[member].stretch_and_bending;
                let [most, least] = &mut self.extremes[parts.members[member]];
                (*most, *least) = (most.max(stretch), least.min(bending));
            }
        }
    }

    /// The largest force that a section of every member of a pack carries, rounded up to a power of four, or by which the network answers to
    /// it; zero where no auxiliary stiffness needs to follow either.
    pub(crate) fn carried_forces<const D: usize>(&self, pack: &dyn Pack<D>) -> [f64; MOST_LANES] {
        let mut carried = [0.0; MOST_LANES];
        if !self.holds_strains {
            for (&member, carried) in pack.mesh().members.iter().zip(&mut carried) {
                *carried = self.beside[member];
            }
            return carried;
        }
        let forces = pack.carried_forces();
        for ((&member, force), carried) in pack.mesh().members.iter().zip(forces).zip(&mut carried) {
            *carried = self.beside[member];
            let Some(bears) = self.sections[member].bears else { continue };
            if force > bears.max(*carried) && force.is_finite() {
                *carried = 4f64.powf((0.5 * force.log2()).ceil());
            }
        }
        carried
    }

    /// Whether the auxiliary stiffness of any member was made for another force than it carries now.
    pub(super) fn is_outgrown<const D: usize>(&self, members: &Members<D>) -> bool {
        let outgrown = |pack: &dyn Pack<D>| {
            let own = |(&member, carried): (&MemberId, f64)| {
                self.sections[member].made_of.as_ref().is_some_and(|made_of| made_of.carried != carried)
            };
            pack.mesh().members.iter().zip(self.carried_forces(pack)).any(own)
        };
        self.holds_strains && members.packs.iter().any(|pack| outgrown(pack.as_ref()))
    }
}

impl MadeOf {
    /// Puts sections and loads into the elements of a member.
    fn put<const D: usize>(
        self,
        structure: &Structure,
        members: &mut Members<D>,
        member: MemberId,
        size: f64,
        states: &mut [Option<SectionState>],
    ) -> Sections {
        let slot = &members.slots[member];
        let chain = &mut members.packs[slot.pack];
        let description = &structure.members[member];
        let mut sections = Sections { made_of: Some(self), ..Sections::default() };
        let whole = description.length();
        let mut first = None;
        for (segment, of) in description.segments.iter().enumerate() {
            let lengths = [chain.mesh().element_length(slot.lane, segment), whole];
            let weigh = |section: &SectionState| match self.gravity {
                [0.0, 0.0, 0.0] => self.line,
                gravity => add(self.line, scale(section.section.mass_per_length, gravity)),
            };
            // Both ends of a muscle are alike.
            if let Some((law, length, section, moduli)) = &first
                && (*law, *length) == (of.law, lengths[0])
            {
                states[segment] = Some(*section);
                chain.set_segment(slot.lane, segment, moduli, weigh(section));
                continue;
            }
            let section = structure.laws[of.law].at(self.control);
            states[segment] = Some(section);
            let moduli =
                packs::moduli(&section, chain.mesh().about(), lengths, &slot.turn, self.auxiliary, self.carried);
            sections.is_stiff |= packs::is_stiff(&section, lengths);
            if moduli.held.iter().any(|&held| held != 0.0) {
                let [.., second, third] = moduli.stiffness;
                let own = self.auxiliary.bears(if D == 3 { third } else { second.min(third) }, lengths);
                sections.bears = Some(sections.bears.map_or(own, |bears| bears.min(own)));
            }
            sections.noise[0] = sections.noise[0].max(1e-10 * moduli.stiffness[0]);
            sections.noise[1] = sections.noise[1].max(1e-10 * moduli.stiffness[5] / size);
            let [forces @ .., _, second, third] = moduli.stiffness;
            let stiffest = forces.into_iter().filter(|force| force.is_finite()).fold(0.0, f64::max);
            let bending = if D == 3 { third } else { second.min(third) };
            sections.slenderness = sections.slenderness.max(whole * (stiffest / bending).sqrt());
            let [stretch, bends] = packs::stretch_and_bending(&section, whole, &slot.turn, D == 3);
            sections.stretch_and_bending[0] = sections.stretch_and_bending[0].max(stretch);
            let least = sections.stretch_and_bending[1];
            sections.stretch_and_bending[1] = if segment == 0 { bends } else { least.min(bends) };
            chain.set_segment(slot.lane, segment, &moduli, weigh(&section));
            first.get_or_insert((of.law, lengths[0], section, moduli));
        }
        sections
    }
}

/// Distance of both nodes of every spring without prestress.
fn unstressed(structure: &Structure) -> impl Iterator<Item = f64> + '_ {
    structure.springs.iter().map(|spring| match (spring.natural_length(), spring.pair()) {
        (Some(_), Some([a, b])) => norm(sub(structure.nodes[b], structure.nodes[a])),
        _ => 0.0,
    })
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
