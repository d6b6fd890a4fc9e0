//! Parts of a design that a parameter reaches, moved on along its derivatives: as many of them side by side as there are.

use std::sync::{Arc, OnceLock};

use pennate_elements::small::sub;
use pennate_solver::chain::{ChainMesh, Pack};
use pennate_solver::compliance::Pull;
use pennate_solver::joints::{EndKind, Link, Topology, dot6};
use pennate_solver::packs;
use pennate_solver::structure::{
    Drive, Fibres, Member, MemberId, Release, RigidBody, SectionLaw, SectionState, Segment, Spring, Structure,
};
use pennate_solver::system::System;

use super::design::Design;
use super::nearby::{Nearby, change, changes};
use super::numbers::Places;
use crate::together::{self, Posed};

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
        changes(self.nearby.around().map(|design| design.structure.nodes[node]))
    }

    /// The change of the axis along which a component of a node is held, from the lower to the upper design.
    pub(super) fn axis(&self, node: usize, component: usize) -> [f64; 3] {
        let supports = &self.design.structure.supports;
        match supports.iter().position(|support| support.node == node) {
            Some(support) if self.owns(self.places.supports + support) => {
                changes(self.nearby.around().map(|design| together::axis(&design.structure, node, component)))
            }
            _ => [0.0; 3],
        }
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

    /// The laws of all segments of some members: of the design, and of those around it where the member follows the parameter.
    /// They are on the pieces of their tables that the drives lie on: differences over a corner would be those of no piece.
    pub(super) fn laws(&self, members: &[MemberId], drives: &[f64]) -> Vec<[Arc<Known>; 5]> {
        let law = |design: &Design, member: MemberId, segment: usize| {
            let own = &design.structure.members[member];
            let law = &design.structure.laws[own.segments[segment].law];
            let piece = own.control.and_then(|control| law.piece(drives[control]));
            Arc::new(Known { law: piece.unwrap_or_else(|| Arc::clone(law)), found: OnceLock::new() })
        };
        let segments = |&member: &MemberId| {
            let count = self.design.structure.members[member].segments.len();
            (0..count).map(move |segment| (member, segment))
        };
        let all = |(member, segment): (MemberId, usize)| {
            let middle = law(self.design, member, segment);
            if self.owns(self.places.members + member) {
                let [low, high, lower, higher] = self.nearby.around().map(|design| law(design, member, segment));
                [middle, low, high, lower, higher]
            } else {
                std::array::from_fn(|_| Arc::clone(&middle))
            }
        };
        members.iter().flat_map(segments).map(all).collect()
    }

    /// The parts with these laws, so many times as far as half the way from the lower to the upper design.
    ///
    /// Springs are among them where `whole`, or where any of them may change.
    pub(super) fn at(&self, members: &[MemberId], known: &[[Arc<Known>; 5]], times: f64, whole: bool) -> Moved {
        let structure = &self.design.structure;
        let around = self.nearby.around().map(|design| &design.structure);
        let between = Between { times };
        let mut laws: Vec<Arc<dyn SectionLaw>> = Vec::with_capacity(known.len());
        let nodes = |node: usize| match self.moves_node(node) {
            true => between.vector(structure.nodes[node], around.map(|structure| structure.nodes[node])),
            false => structure.nodes[node],
        };
        let member = |&member: &MemberId| {
            let own = &structure.members[member];
            if !self.owns(self.places.members + member) {
                let segment = |segment: &Segment| {
                    laws.push(Arc::clone(&known[laws.len()][0]) as Arc<dyn SectionLaw>);
                    Segment { law: laws.len() - 1, ..*segment }
                };
                return Member { segments: own.segments.iter().map(segment).collect(), ..own.clone() };
            }
            let others = around.map(|structure| &structure.members[member]);
            let segment = |(index, part): (usize, &Segment)| {
                let segments = others.map(|other| &other.segments[index]);
                laws.push(Arc::new(BetweenLaws { known: known[laws.len()].clone(), between }));
                Segment {
                    length: between.number(part.length, segments.map(|segment| segment.length)),
                    law: laws.len() - 1,
                    initial_curvature: between
                        .vector(part.initial_curvature, segments.map(|segment| segment.initial_curvature)),
                    ..*part
                }
            };
            let release = |end: usize| {
                let Release::Axes(axes) = &own.releases[end] else { return own.releases[end].clone() };
                let axis = |(index, own): (usize, &[f64; 3])| {
                    let axis = |other: &Member| match &other.releases[end] {
                        Release::Axes(axes) => axes.get(index).copied().unwrap_or(*own),
                        _ => *own,
                    };
                    between.vector(*own, others.map(axis))
                };
                Release::Axes(axes.iter().enumerate().map(axis).collect())
            };
            Member {
                segments: own.segments.iter().enumerate().map(segment).collect(),
                axes: std::array::from_fn(|axis| between.vector(own.axes[axis], others.map(|other| other.axes[axis]))),
                releases: [release(0), release(1)],
                ..own.clone()
            }
        };
        let chosen: Vec<Member> = members.iter().map(member).collect();
        let has_springs = whole || self.springs();
        let spring = |index: usize| {
            let own = &structure.springs[index];
            match self.owns(self.places.springs + index) {
                true => between.spring(own, around.map(|structure| &structure.springs[index])),
                false => own.clone(),
            }
        };
        let body = |(index, own): (usize, &RigidBody)| {
            let masses = around.map(|structure| structure.bodies[index].mass);
            let owned = self.owns(self.places.bodies + index);
            RigidBody { mass: if owned { between.number(own.mass, masses) } else { own.mass }, ..own.clone() }
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
    /// The packs of the design that the packs here are like, lane by lane.
    sources: Vec<usize>,
    count: usize,
}

impl<const D: usize> Copies<D> {
    /// Systems of parts of one that is given; `still` gives some members of it where they are.
    pub(super) fn of(system: &System<D>, all: Vec<Moved>, still: impl Fn(&[MemberId]) -> Moved) -> Self {
        if all.is_empty() || system.places.joints.is_empty() {
            return Self { systems: Vec::new() };
        }
        // Gravity would be that of all.
        let alone = !together::joins(&all[0].structure);
        let systems = match alone {
            true => all.into_iter().filter_map(|one| Copy::of(system, vec![one], &still)).collect(),
            false => Copy::of(system, all, &still).into_iter().collect(),
        };
        Self { systems }
    }

    /// Forces on the joints of a system, where parts of it are these under drives of their own, one after the other.
    pub(super) fn forces(&mut self, system: &System<D>, drives: &[Vec<f64>]) -> Vec<Vec<[f64; 6]>> {
        let joints = system.places.joints.len();
        let (mut all, mut rest) = (Vec::with_capacity(drives.len()), drives);
        for copy in &mut self.systems {
            rest = copy.stand_in(system, rest);
            let forces = copy.system.exert(system, &copy.sources);
            all.extend(forces.chunks_exact(joints).take(copy.count).map(<[_]>::to_vec));
        }
        all
    }

    /// The work u · K u of the stiffness K of the same parts for the motion u of every pull, where joints have moved.
    pub(super) fn works(
        &mut self,
        system: &System<D>,
        drives: &[Vec<f64>],
        moves: &[Vec<[f64; 6]>],
        pulls: &[Pull],
    ) -> Vec<Vec<f64>> {
        let (mut all, mut rest) = (Vec::with_capacity(drives.len()), drives);
        for copy in &mut self.systems {
            rest = copy.stand_in(system, rest);
            let first = all.len();
            all.resize_with(first + copy.count, Vec::new);
            let mut own = moves[first..first + copy.count].concat();
            own.resize(copy.system.places.joints.len(), [0.0; 6]);
            copy.system.linearize_parts(&own);
            for Pull { motions, .. } in pulls {
                let mut alike = motions.repeat(copy.count);
                alike.resize(copy.system.places.joints.len(), [0.0; 6]);
                let forces = copy.system.transposed_times(&alike);
                for (works, forces) in all[first..].iter_mut().zip(forces.chunks_exact(motions.len())) {
                    works.push(forces.iter().zip(motions).map(|(force, motion)| dot6(force, motion)).sum());
                }
            }
        }
        all
    }
}

impl<const D: usize> Copy<D> {
    /// Stands where a system does, under the first of these drives; the rest of them.
    fn stand_in<'a>(&mut self, system: &System<D>, drives: &'a [Vec<f64>]) -> &'a [Vec<f64>] {
        let (own, rest) = drives.split_at(self.count);
        self.system.loading.auxiliary = system.loading.auxiliary;
        let mut drives = own.concat();
        // What nobody looks at bears nothing: gravity would be that of all.
        drives.resize(self.system.loading.drives.len(), 0.0);
        self.system.stand_in(system, &self.sources, &self.members, &drives);
        rest
    }

    /// Every member lies in the lane that it has in the design, so that the factors there serve it: as many packs like one of
    /// the design as its members have copies at the most. Lanes that are left over hold a member that nobody looks at.
    fn of(like: &System<D>, mut all: Vec<Moved>, still: &impl Fn(&[MemberId]) -> Moved) -> Option<Self> {
        let count = all.len();
        let mut copies: Vec<Vec<usize>> = vec![Vec::new(); like.members.count()];
        let members = all.iter().flat_map(|moved| &moved.members);
        members.enumerate().for_each(|(index, &member)| copies[member].push(index));
        let counts =
            |pack: &dyn Pack<D>| pack.mesh().members.iter().map(|&member| copies[member].len()).collect::<Vec<_>>();
        let counts: Vec<Vec<usize>> = like.members.packs.iter().map(|pack| counts(pack.as_ref())).collect();
        let rows: Vec<usize> = counts.iter().map(|counts| counts.iter().copied().max().unwrap_or(0)).collect();
        let left_over = |pack: &usize| counts[*pack].iter().any(|&count| count < rows[*pack]);
        let spare: Vec<MemberId> = (0..like.members.packs.len())
            .filter(left_over)
            .map(|pack| like.members.packs[pack].mesh().members[0])
            .collect();
        let first_spare = all.iter().map(|moved| moved.members.len()).sum::<usize>();
        all.push(still(&spare));
        let members: Vec<MemberId> = all.iter().flat_map(|moved| moved.members.iter().copied()).collect();
        let topology = topology(&like.topology, &all);
        let posed: Vec<Posed<'_>> = all.iter().map(|moved| (&moved.structure, &[][..])).collect();
        let (structure, ..) = together::join(&posed)?;
        let (mut packs, mut sources) = (Vec::new(), Vec::new());
        for (source, (pack, &rows)) in like.members.packs.iter().zip(&rows).enumerate() {
            for row in 0..rows {
                let mesh = |&member: &MemberId| {
                    let spare =
                        first_spare + spare.iter().position(|&one| one == pack.mesh().members[0]).unwrap_or_default();
                    let index = copies[member].get(row).copied().unwrap_or(spare);
                    packs::mesh(&structure, index, &structure.members[index])
                };
                let meshes: Vec<ChainMesh> = pack.mesh().members.iter().map(mesh).collect();
                packs.push(pack.like(&meshes));
                sources.push(source);
            }
        }
        let system = System::new(Arc::new(structure), Arc::new(topology), packs, like.pattern.equations.active, false);
        Some(Self { system, members, sources, count })
    }
}

/// As many copies of the joints, with arms and axes of each.
fn topology(own: &Topology, all: &[Moved]) -> Topology {
    let mut topology = Topology {
        links: Vec::new(),
        references: Vec::new(),
        ends: Vec::new(),
        idle: Vec::new(),
        turned: Vec::new(),
        follows_rows: false,
    };
    for (copy, moved) in all.iter().enumerate() {
        let nodes = &moved.structure.nodes;
        let link = |(node, link): (usize, &Link)| Link {
            joint: link.joint + copy * own.references.len(),
            arm: sub(nodes[node], nodes[own.references[link.joint]]),
        };
        topology.links.extend(own.links.iter().enumerate().map(link));
        topology.references.extend(own.references.iter().map(|node| node + copy * nodes.len()));
        topology.idle.extend_from_slice(&own.idle);
        topology.turned.extend_from_slice(&own.turned);
        for (member, moved) in moved.members.iter().zip(&moved.structure.members) {
            let kind = |end: usize| match (&own.ends[*member][end], &moved.releases[end]) {
                (&EndKind::Axes { kept, .. }, Release::Axes(axes)) => EndKind::Axes { axes: axes.clone(), kept },
                (kind, _) => kind.clone(),
            };
            topology.ends.push([kind(0), kind(1)]);
        }
    }
    topology
}

/// Numbers so many times as far from the middle as half the way from the lower to the upper design, by their derivative: from what they
/// are in these two, and in those twice as far away.
#[derive(Clone, Copy, Debug)]
struct Between {
    times: f64,
}

impl Between {
    fn number(self, middle: f64, around: [f64; 4]) -> f64 {
        let [low, high, ..] = around;
        if low == high { middle } else { middle + 0.5 * self.times * change(around) }
    }

    fn vector<const N: usize>(self, middle: [f64; N], around: [[f64; N]; 4]) -> [f64; N] {
        std::array::from_fn(|i| self.number(middle[i], around.map(|vector| vector[i])))
    }

    fn spring(self, middle: &Spring, around: [&Spring; 4]) -> Spring {
        let mut spring = middle.clone();
        let around: [Vec<f64>; 4] = around.map(|spring| spring.numbers().into_iter().collect());
        for (index, number) in spring.numbers_mut().into_iter().enumerate() {
            *number = self.number(*number, around.each_ref().map(|numbers| numbers[index]));
        }
        spring
    }

    /// The section of five: of the middle, the lower and the upper design, and those twice as far away.
    fn section(self, states: &[SectionState; 5]) -> SectionState {
        let [middle, low, high, lower, higher] = states.each_ref().map(SectionState::numbers);
        let mut numbers = middle;
        for (n, number) in numbers.iter_mut().enumerate() {
            *number = self.number(middle[n], [low[n], high[n], lower[n], higher[n]]);
        }
        SectionState::of_numbers(numbers)
    }
}

/// A law, and what it gives at the first control that it was asked at: most are asked there again and again.
#[derive(Debug)]
pub(super) struct Known {
    law: Arc<dyn SectionLaw>,
    found: OnceLock<(f64, SectionState)>,
}

impl SectionLaw for Known {
    fn at(&self, control: f64) -> SectionState {
        let (at, state) = *self.found.get_or_init(|| (control, self.law.at(control)));
        if at == control { state } else { self.law.at(control) }
    }

    fn fibres(&self) -> Fibres {
        self.law.fibres()
    }
}

/// The sections of a segment, between those of designs: of the middle, the lower and the upper one, and those twice as far away.
#[derive(Debug)]
struct BetweenLaws {
    known: [Arc<Known>; 5],
    between: Between,
}

impl SectionLaw for BetweenLaws {
    fn at(&self, control: f64) -> SectionState {
        self.between.section(&self.known.each_ref().map(|known| known.at(control)))
    }

    fn fibres(&self) -> Fibres {
        self.known[0].fibres()
    }
}
