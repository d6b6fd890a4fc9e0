//! Parts of a design that a parameter reaches, moved on along its derivatives: as many of them side by side as there are.

use std::sync::Arc;

use pennate_elements::section::Section;
use pennate_elements::small::sub;
use pennate_solver::joints::{EndKind, Link, Topology};
use pennate_solver::structure::{
    Drive, Fibres, Member, MemberId, Release, RigidBody, SectionLaw, SectionState, Segment, Spring, Structure,
};
use pennate_solver::system::System;

use super::design::Design;
use super::nearby::Nearby;
use super::numbers::Places;
use crate::together::{self, Packs};

/// The parts of a design that a parameter reaches, and all joints.
pub(super) struct Moved {
    structure: Structure,
    /// The members, by their index in the design.
    members: Vec<MemberId>,
}

/// A parameter as it moves a design: the design and those on both sides.
pub(super) struct Mover<'a> {
    pub design: &'a Design,
    pub nearby: &'a Nearby,
    pub places: &'a Places,
    pub input: usize,
    /// By how much every drive changes from the lower to the upper design.
    pub drives: &'a [f64],
}

impl Mover<'_> {
    fn owns(&self, part: usize) -> bool {
        self.nearby.is_owned(part, self.input)
    }

    /// The nodes whose place changes.
    fn moves_node(&self, node: usize) -> bool {
        self.owns(node)
    }

    /// The change of the place of a node from the lower to the upper design.
    pub(super) fn node(&self, node: usize) -> [f64; 3] {
        if !self.moves_node(node) {
            return [0.0; 3];
        }
        sub(self.nearby.high.structure.nodes[node], self.nearby.low.structure.nodes[node])
    }

    /// The members whose forces change while the joints stay where they are.
    pub(super) fn members(&self, topology: &Topology) -> Vec<MemberId> {
        let structure = &self.design.structure;
        // Levers of rigid bodies change with both their ends.
        let shifts =
            |node: usize| self.moves_node(node) || self.moves_node(topology.references[topology.links[node].joint]);
        let driven = |drive: usize| self.drives[drive] != 0.0;
        let loaded: Vec<MemberId> = (structure.drives.iter().enumerate())
            .filter_map(|(drive, what)| match *what {
                Drive::Distributed(member, _) if driven(drive) => Some(member),
                _ => None,
            })
            .collect();
        let weighs = structure.drives.iter().enumerate();
        let weighs = weighs.filter(|(drive, _)| driven(*drive)).any(|(_, what)| matches!(what, Drive::Gravity(_)));
        let reached = |&member: &MemberId| {
            let own = &structure.members[member];
            weighs
                || self.owns(self.places.members + member)
                || own.nodes.iter().any(|&node| shifts(node))
                || own.control.is_some_and(driven)
                || loaded.contains(&member)
        };
        (0..structure.members.len()).filter(reached).collect()
    }

    /// Whether any force but those of members may change.
    fn springs(&self) -> bool {
        let Places { members, springs, bodies, .. } = *self.places;
        (0..members).chain(springs..bodies).any(|part| self.owns(part))
    }

    /// The drives, so many times as far as half the way from the lower to the upper design.
    pub(super) fn drives_at(&self, drives: &[f64], times: f64) -> Vec<f64> {
        drives.iter().zip(self.drives).map(|(value, way)| value + 0.5 * times * way).collect()
    }

    /// The parts, so many times as far as half the way from the lower to the upper design.
    pub(super) fn at(&self, members: &[MemberId], drives: &[f64], times: f64) -> Moved {
        let (structure, low, high) = (&self.design.structure, &self.nearby.low, &self.nearby.high);
        let between = Between { times };
        let mut laws: Vec<Arc<dyn SectionLaw>> = Vec::new();
        // On one piece of a table: differences over a corner would be those of no piece.
        let law = |design: &Design, own: &Member, segment: &Segment| {
            let law = &design.structure.laws[segment.law];
            own.control.and_then(|control| law.piece(drives[control])).unwrap_or_else(|| Arc::clone(law))
        };
        let nodes = |node: usize| match self.moves_node(node) {
            true => between.vector(structure.nodes[node], low.structure.nodes[node], high.structure.nodes[node]),
            false => structure.nodes[node],
        };
        let member = |&member: &MemberId| {
            let own = &structure.members[member];
            if !self.owns(self.places.members + member) {
                let segment = |segment: &Segment| {
                    laws.push(law(self.design, own, segment));
                    Segment { law: laws.len() - 1, ..*segment }
                };
                return Member { segments: own.segments.iter().map(segment).collect(), ..own.clone() };
            }
            let [low_member, high_member] = [low, high].map(|design| &design.structure.members[member]);
            let segment = |((part, from), to): ((&Segment, &Segment), &Segment)| {
                let [middle, low, high] = [law(self.design, own, part), law(low, own, from), law(high, own, to)];
                laws.push(Arc::new(BetweenLaws { middle, low, high, between }));
                Segment {
                    length: between.number(part.length, from.length, to.length),
                    law: laws.len() - 1,
                    initial_curvature: between.vector(
                        part.initial_curvature,
                        from.initial_curvature,
                        to.initial_curvature,
                    ),
                    ..*part
                }
            };
            let pairs = own.segments.iter().zip(&low_member.segments).zip(&high_member.segments);
            let release = |end: usize| {
                let all = (&own.releases[end], &low_member.releases[end], &high_member.releases[end]);
                match all {
                    (Release::Axes(own), Release::Axes(low), Release::Axes(high)) => {
                        let axes = own.iter().zip(low).zip(high);
                        Release::Axes(axes.map(|((own, low), high)| between.vector(*own, *low, *high)).collect())
                    }
                    _ => own.releases[end].clone(),
                }
            };
            Member {
                segments: pairs.map(segment).collect(),
                axes: std::array::from_fn(|axis| {
                    between.vector(own.axes[axis], low_member.axes[axis], high_member.axes[axis])
                }),
                releases: [release(0), release(1)],
                ..own.clone()
            }
        };
        let chosen: Vec<Member> = members.iter().map(member).collect();
        let has_springs = self.springs();
        let spring = |index: usize| {
            let own = &structure.springs[index];
            match self.owns(self.places.springs + index) {
                true => between.spring(own, &low.structure.springs[index], &high.structure.springs[index]),
                false => own.clone(),
            }
        };
        let body = |(index, own): (usize, &RigidBody)| {
            let [low, high] = [low, high].map(|design| design.structure.bodies[index].mass);
            let owned = self.owns(self.places.bodies + index);
            RigidBody { mass: if owned { between.number(own.mass, low, high) } else { own.mass }, ..own.clone() }
        };
        let drive = |drive: &Drive| match *drive {
            Drive::Distributed(member, component) => match members.iter().position(|&own| own == member) {
                Some(place) => Drive::Distributed(place, component),
                None => Drive::Control,
            },
            other => other,
        };
        Moved {
            members: members.to_vec(),
            structure: Structure {
                nodes: (0..structure.nodes.len()).map(nodes).collect(),
                members: chosen,
                laws,
                supports: Vec::new(),
                bodies: structure.bodies.iter().enumerate().map(body).collect(),
                springs: (0..structure.springs.len()).filter(|_| has_springs).map(spring).collect(),
                drives: structure.drives.iter().map(drive).collect(),
                compliances: Vec::new(),
                sections: Vec::new(),
                ..*structure
            },
        }
    }
}

/// Systems of parts that were moved, ready to stand where another one does.
pub(super) struct Copies<const D: usize> {
    systems: Vec<Copy<D>>,
}

/// Some of the parts side by side, and their members by their index in the design.
struct Copy<const D: usize> {
    system: System<D>,
    members: Vec<MemberId>,
    count: usize,
}

impl<const D: usize> Copies<D> {
    /// Systems of parts of one that is given.
    pub(super) fn of(system: &System<D>, packs: Packs<D>, all: Vec<Moved>) -> Self {
        if all.is_empty() || system.places.joints.is_empty() {
            return Self { systems: Vec::new() };
        }
        // Gravity would be that of all.
        let alone = all.len() > 1 && !together::joins(&all[0].structure);
        let systems = match alone {
            true => all.into_iter().filter_map(|one| Copy::of(system, packs, vec![one])).collect(),
            false => Copy::of(system, packs, all).into_iter().collect(),
        };
        Self { systems }
    }

    /// Forces on the joints of a system, where parts of it are these under drives of their own, one after the other.
    pub(super) fn forces(&mut self, system: &System<D>, drives: &[Vec<f64>]) -> Vec<Vec<[f64; 6]>> {
        let joints = system.places.joints.len();
        let (mut all, mut rest) = (Vec::with_capacity(drives.len()), drives);
        for copy in &mut self.systems {
            let (own, others) = rest.split_at(copy.count);
            rest = others;
            copy.system.loading.auxiliary = system.loading.auxiliary;
            copy.system.stand_in(system, &copy.members, &own.concat());
            all.extend(copy.system.exert().chunks_exact(joints).map(<[_]>::to_vec));
        }
        all
    }
}

impl<const D: usize> Copy<D> {
    fn of(like: &System<D>, packs: Packs<D>, all: Vec<Moved>) -> Option<Self> {
        let count = all.len();
        let members: Vec<MemberId> = all.iter().flat_map(|moved| moved.members.iter().copied()).collect();
        let topology = topology(&like.topology, &all);
        let (structure, ..) = together::join(all.into_iter().map(|moved| (moved.structure, Vec::new())).collect())?;
        let chains = packs(&structure, 0);
        let system = System::new(Arc::new(structure), Arc::new(topology), chains, like.pattern.equations.active, false);
        Some(Self { system, members, count })
    }
}

/// As many copies of the joints, with arms and axes of each.
fn topology(own: &Topology, all: &[Moved]) -> Topology {
    let mut topology = Topology { links: Vec::new(), references: Vec::new(), ends: Vec::new(), idle: Vec::new() };
    for (copy, moved) in all.iter().enumerate() {
        let nodes = &moved.structure.nodes;
        let link = |(node, link): (usize, &Link)| Link {
            joint: link.joint + copy * own.references.len(),
            arm: sub(nodes[node], nodes[own.references[link.joint]]),
        };
        topology.links.extend(own.links.iter().enumerate().map(link));
        topology.references.extend(own.references.iter().map(|node| node + copy * nodes.len()));
        topology.idle.extend_from_slice(&own.idle);
        for (member, moved) in moved.members.iter().zip(&moved.structure.members) {
            let kind = |end: usize| match (&own.ends[*member][end], &moved.releases[end]) {
                (EndKind::Axes(_), Release::Axes(axes)) => EndKind::Axes(axes.clone()),
                (kind, _) => kind.clone(),
            };
            topology.ends.push([kind(0), kind(1)]);
        }
    }
    topology
}

/// Numbers so many times as far from the middle as half the way from the low to the high one.
#[derive(Clone, Copy, Debug)]
struct Between {
    times: f64,
}

impl Between {
    fn number(self, middle: f64, low: f64, high: f64) -> f64 {
        if low == high { middle } else { middle + 0.5 * self.times * (high - low) }
    }

    fn vector<const N: usize>(self, middle: [f64; N], low: [f64; N], high: [f64; N]) -> [f64; N] {
        std::array::from_fn(|i| self.number(middle[i], low[i], high[i]))
    }

    fn spring(self, middle: &Spring, low: &Spring, high: &Spring) -> Spring {
        let mut spring = middle.clone();
        let values = low.numbers().into_iter().zip(high.numbers());
        for (number, (low, high)) in spring.numbers_mut().into_iter().zip(values) {
            *number = self.number(*number, low, high);
        }
        spring
    }

    fn section(self, middle: &Section, low: &Section, high: &Section) -> Section {
        let number = |of: fn(&Section) -> f64| self.number(of(middle), of(low), of(high));
        Section {
            ea: number(|section| section.ea),
            ga2: number(|section| section.ga2),
            ga3: number(|section| section.ga3),
            gj: number(|section| section.gj),
            ei2: number(|section| section.ei2),
            ei3: number(|section| section.ei3),
            mass_per_length: number(|section| section.mass_per_length),
            rotary_inertia: self.vector(middle.rotary_inertia, low.rotary_inertia, high.rotary_inertia),
        }
    }
}

/// The sections of a segment, between those of two designs.
#[derive(Debug)]
struct BetweenLaws {
    middle: Arc<dyn SectionLaw>,
    low: Arc<dyn SectionLaw>,
    high: Arc<dyn SectionLaw>,
    between: Between,
}

impl SectionLaw for BetweenLaws {
    fn at(&self, control: f64) -> SectionState {
        let [middle, low, high] = [&self.middle, &self.low, &self.high].map(|law| law.at(control));
        SectionState {
            section: self.between.section(&middle.section, &low.section, &high.section),
            strain: self.between.number(middle.strain, low.strain, high.strain),
            curvature: self.between.vector(middle.curvature, low.curvature, high.curvature),
        }
    }

    fn fibres(&self) -> Fibres {
        self.middle.fibres()
    }
}
