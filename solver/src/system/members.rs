//! The chains of all members, those of equal mesh side by side.

use std::sync::atomic::{AtomicBool, Ordering};

use pennate_elements::rotation::{exp, matrix};
use pennate_elements::small::{V3, scale, tmul};
use rayon::prelude::*;

use super::{Places, State};
use crate::chain::{MemberEnds, NodesBy, OwnRows, Pack, PackMesh, Task, held_force};
use crate::joints::{EndKind, Topology};
use crate::packs::Turn;
use crate::structure::{Member, MemberId, Structure};

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
    /// Whether an end of it is released.
    pub released: bool,
}

impl MemberSlot {
    /// The place of a member in a lane of a pack.
    fn of(structure: &Structure, topology: &Topology, member: MemberId, [pack, lane]: [usize; 2]) -> Self {
        let description = &structure.members[member];
        Self {
            pack,
            lane,
            turn: Turn::of(structure.dimension, description),
            tangents: end_tangents(description),
            released: topology.ends[member].iter().any(|end| *end != EndKind::Welded),
        }
    }
}

/// Chains of all members, with the state of all between their ends.
pub struct Members<const D: usize> {
    /// Members of equal mesh side by side.
    pub packs: Vec<Box<dyn Pack<D>>>,
    /// Where every member is among them.
    pub slots: Vec<MemberSlot>,
    /// What the ends of the members of every pack move by, and where they are.
    rows: Vec<OwnRows<D>>,
    /// Whether packs work at the same time.
    parallel: bool,
    /// Whether they are more than what lies near the processor.
    far: bool,
}

impl<const D: usize> Members<D> {
    /// The chains of a structure's members.
    pub(super) fn new(
        structure: &Structure,
        topology: &Topology,
        packs: Vec<Box<dyn Pack<D>>>,
        parallel: bool,
    ) -> Self {
        let mut slots: Vec<Option<MemberSlot>> = vec![None; structure.members.len()];
        for (pack, chain) in packs.iter().enumerate() {
            for (lane, &member) in chain.mesh().members.iter().enumerate() {
                slots[member] = Some(MemberSlot::of(structure, topology, member, [pack, lane]));
            }
        }
        let rows = packs.iter().map(|pack| OwnRows::new(pack.mesh().lanes)).collect();
        let far = are_far(&packs);
        Self { packs, slots: slots.into_iter().flatten().collect(), rows, parallel, far }
    }

    /// Takes the members of another structure, whose chains the packs hold.
    pub(super) fn renew(&mut self, structure: &Structure, topology: &Topology) {
        for (member, slot) in self.slots.iter_mut().enumerate() {
            *slot = MemberSlot::of(structure, topology, member, [slot.pack, slot.lane]);
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.slots.len()
    }

    /// The pack of a member, and its lane there.
    pub(crate) fn chain(&self, member: MemberId) -> (&dyn Pack<D>, usize) {
        let slot = &self.slots[member];
        (self.packs[slot.pack].as_ref(), slot.lane)
    }

    /// The same of all members, in their order.
    pub fn chains(&self) -> impl Iterator<Item = (&dyn Pack<D>, usize)> {
        self.slots.iter().map(|slot| (self.packs[slot.pack].as_ref(), slot.lane))
    }

    /// Asks for the ends of a member of the next pack, while those of this one are taken.
    #[inline]
    pub(super) fn ask_for_ends_after(&self, member: MemberId) {
        let slot = &self.slots[member];
        if self.far
            && let Some(next) = self.packs.get(slot.pack + 1)
        {
            next.prefetch(Task::TakeEnds, slot.lane);
        }
    }

    /// Stiffness and forces of the ends of a member.
    pub(super) fn condensed(&self, member: MemberId) -> MemberEnds<D> {
        let (pack, lane) = self.chain(member);
        pack.condensed(lane)
    }

    /// Lets all packs do the same, side by side where that pays.
    pub(super) fn for_packs(&mut self, act: impl Fn(&mut Box<dyn Pack<D>>) + Sync + Send) {
        if self.parallel {
            self.packs.par_iter_mut().for_each(act);
        } else {
            self.packs.iter_mut().for_each(act);
        }
    }

    /// Sets what the ends of a member move by.
    pub(super) fn set_motions(&mut self, member: MemberId, ends: &[[f64; D]; 2]) {
        let slot = &self.slots[member];
        self.rows[slot.pack].set_motions(slot.lane, ends);
    }

    /// Moves what is between the ends of all members, of those packs that lie `beside` others by rows of joints, of the others by
    /// what was set.
    pub(super) fn advance<'a>(&mut self, beside: impl Fn(usize) -> Option<(&'a [f64], [usize; 2])> + Sync + Send) {
        let rows = &self.rows;
        in_turn(&mut self.packs, [self.parallel, self.far], |index, pack, next| {
            let (motions, joints) = beside(index).unwrap_or((&rows[index].motions, [0, 1]));
            pack.advance(motions, joints, next);
        });
    }

    /// Eliminates the interiors of all members at the present state.
    pub(super) fn condense(&mut self) {
        in_turn(&mut self.packs, [self.parallel, self.far], |_, pack, next| pack.condense(next));
    }

    /// Lets all packs keep the factors that [`Pack::refresh`] goes on with.
    pub fn keep_factors(&mut self) {
        self.packs.iter_mut().for_each(|pack| pack.settings().keeps_factors = true);
    }

    /// Places the nodes between the ends of all members.
    pub(super) fn place_nodes(&mut self, by: NodesBy) {
        in_turn(&mut self.packs, [self.parallel, self.far], |_, pack, next| pack.place_nodes(by, next));
    }

    /// Forces at the present state, by the factors of the one before; whether all packs keep what goes on with them.
    pub(super) fn refresh(&mut self) -> bool {
        let keep = AtomicBool::new(true);
        self.for_packs(|pack| _ = keep.fetch_and(pack.refresh(None), Ordering::Relaxed));
        keep.into_inner()
    }

    /// Whether the same members lie in the same lanes of others.
    pub(super) fn lie_as(&self, others: &Self) -> bool {
        let own = self.packs.iter().map(|pack| &pack.mesh().members);
        own.eq(others.packs.iter().map(|pack| &pack.mesh().members))
    }

    /// Puts the ends of the chains of some packs where their joints are.
    pub(super) fn place_ends(
        &mut self,
        structure: &Structure,
        topology: &Topology,
        places: &Places,
        of: impl Fn(usize) -> bool,
    ) {
        for (index, slot) in self.slots.iter().enumerate().filter(|(_, slot)| of(slot.pack)) {
            for end in 0..2 {
                let link = &topology.links[structure.members[index].nodes[end]];
                let joint = &places.joints[link.joint];
                let rows = &mut self.rows[slot.pack];
                if !link.has_arm() && !slot.released {
                    rows.set_pose(slot.lane, end, &joint.place);
                    continue;
                }
                let mut place = joint.place;
                if link.has_arm() {
                    place.displacement = joint.point(link.arm);
                }
                if topology.ends[index][end] != EndKind::Welded {
                    let release = &places.releases[index][end];
                    place.rotation = release.rotation;
                    place.angle = release.angle;
                }
                rows.set_pose(slot.lane, end, &place);
            }
        }
        for (index, (pack, own)) in self.packs.iter_mut().zip(&self.rows).enumerate() {
            if of(index) {
                pack.set_ends(&own.poses, [0, 1]);
            }
        }
    }

    /// Keeps what is between the ends.
    pub(super) fn save(&self, into: &mut Vec<Vec<f64>>) {
        into.resize_with(self.packs.len(), Vec::new);
        for (pack, row) in self.packs.iter().zip(into) {
            pack.save(row);
        }
    }

    /// Goes back to what was between the ends.
    pub(super) fn restore(&mut self, from: &State) {
        for (pack, row) in self.packs.iter_mut().zip(&from.chains) {
            pack.restore(row, 0.0);
        }
    }

    /// Geometric stiffness by the stresses of the present strains instead of mixed ones.
    pub(crate) fn set_plain(&mut self, plain: bool) {
        self.packs.iter_mut().for_each(|pack| pack.settings().plain = plain);
    }

    /// Largest strain that a rigid component of any member still has.
    pub(crate) fn violation(&self) -> f64 {
        self.packs.iter().map(|pack| pack.violation()).fold(0.0, f64::max)
    }

    /// Largest tangent of the angle by which bending within an element of any member that cannot be stretched lets its chord lean.
    pub(crate) fn lean(&self) -> f64 {
        self.packs.iter().map(|pack| pack.lean()).fold(0.0, f64::max)
    }

    /// The largest strain by which the auxiliary stiffness of strains that are held lets them give: critical loads are too low by this
    /// part.
    pub(crate) fn give(&self) -> f64 {
        let of = |pack: &dyn Pack<D>| {
            let forces = pack.carried_forces();
            let own = |lane: usize| held_force(pack, lane).map_or(0.0, |held| forces[lane] / held.auxiliary);
            (0..pack.mesh().members.len()).map(own).fold(0.0, f64::max)
        };
        self.packs.iter().map(|pack| of(pack.as_ref())).fold(0.0, f64::max)
    }

    /// Negative pivots of the interiors, and the smallest one of any over the largest stiffness of its component.
    pub(super) fn pivots(&self) -> (usize, f64) {
        let pivots = (0..self.count()).map(|member| {
            let (pack, lane) = self.chain(member);
            pack.interior(lane)
        });
        pivots.fold((0, 1.0), |(count, smallest), own| (count + own.negative, own.smallest.min(smallest)))
    }
}

/// The most packs that follow each other on one thread where several work at the same time: the last of them asks for nothing ahead.
const ROW: usize = 8;
/// So many such rows a thread, at least, share the work evenly enough.
const ROWS: usize = 8;
/// Bytes of factors that caches beside a processor hold: where there are more, packs ask for their memory ahead.
const NEAR: usize = 2 << 20;

/// Whether packs are more than what lies near the processor.
fn are_far<const D: usize>(packs: &[Box<dyn Pack<D>>]) -> bool {
    let bytes = |mesh: &PackMesh| {
        let blocks = 2 + mesh.order * (mesh.order - 1) / 2;
        size_of::<f64>() * D * D * blocks * mesh.elements() * mesh.lanes
    };
    packs.iter().map(|pack| bytes(pack.mesh())).sum::<usize>() > NEAR
}

/// Lets all packs do the same, side by side where that pays, each with its index and the one after it, where that is `far`.
fn in_turn<const D: usize>(
    packs: &mut [Box<dyn Pack<D>>],
    [parallel, far]: [bool; 2],
    act: impl Fn(usize, &mut dyn Pack<D>, Option<&dyn Pack<D>>) + Sync + Send,
) {
    let row = |mut index: usize, mut packs: &mut [Box<dyn Pack<D>>]| {
        while let Some((pack, rest)) = packs.split_first_mut() {
            let next = rest.first().filter(|_| far).map(|next| next.as_ref());
            act(index, pack.as_mut(), next);
            index += 1;
            packs = rest;
        }
    };
    if parallel {
        let most = if far { ROW } else { 1 };
        let count = (packs.len() / (ROWS * rayon::current_num_threads())).clamp(1, most);
        packs.par_chunks_mut(count).enumerate().for_each(|(index, packs)| row(index * count, packs));
    } else {
        row(0, packs);
    }
}

fn end_tangents(member: &Member) -> [V3<f64>; 2] {
    let mut axes = member.axes;
    for segment in member.segments.iter().filter(|segment| segment.initial_curvature != [0.0; 3]) {
        let frame = matrix(exp(scale(segment.length, segment.initial_curvature)));
        axes = tmul(&frame, &axes);
    }
    [member.axes[0], axes[0]]
}
