//! Equal parts of a network side by side: members that lie in the lanes of the processor, one of each part, add to their joints
//! and follow them in the lanes too.
//!
//! Numbers of joints and entries of the matrix lie part after part. Here they lie in rows, those of as many parts as there are
//! lanes one after the other: a member adds those of all lanes at once, and what a part has is put together from its lane.

use pennate_elements::beam::Placement;
use pennate_elements::lanes::Width;

use super::System;
use super::members::Members;
use super::scatter::Scatters;
use crate::chain::{EndPlaces, EndRows};
use crate::joints::Topology;
use crate::structure::{MemberId, Structure};

/// Which members lie beside their likes of other parts, and where their joints are. No number depends on it.
#[derive(Debug)]
pub(super) struct Side {
    /// Parts whose numbers lie in a row.
    lanes: usize,
    /// How many rows of parts there are.
    rows: usize,
    /// Joints and entries of the matrix, of a part.
    joints: usize,
    entries: usize,
    /// By index of the pack.
    packs: Vec<Option<Beside>>,
}

/// The joints of the members of a pack, by row, and where their stiffness goes.
#[derive(Debug)]
struct Beside {
    joints: [usize; 2],
    places: EndPlaces,
}

/// What lies in rows: memory of an assembly and of an increment.
#[derive(Debug, Default)]
pub(super) struct Rows {
    ends: EndRows,
    motions: Vec<f64>,
    poses: Vec<f64>,
}

impl Rows {
    /// Motions of the joints.
    pub(super) fn motions(&self) -> &[f64] {
        &self.motions
    }
}

impl Side {
    /// Those of a structure; nothing where no member has its likes beside it, at joints alike. `entries` are those of the whole matrix.
    pub(super) fn of<const D: usize>(
        structure: &Structure,
        topology: &Topology,
        members: &Members<D>,
        scatters: &Scatters,
        entries: usize,
    ) -> Option<Self> {
        let joints_of = |member: usize| structure.members[member].nodes.map(|node| topology.links[node].joint);
        let first = members.packs.first()?.mesh().members.as_slice();
        let [one, next, ..] = *first else { return None };
        let lanes = first.len();
        let joints = joints_of(next)[0].checked_sub(joints_of(one)[0]).filter(|&joints| joints > 0)?;
        let count = topology.references.len();
        let parts = count / joints;
        let fits = parts * joints == count && parts.is_multiple_of(lanes) && entries.is_multiple_of(parts);
        if !fits || Width::widest().for_members(lanes).lanes() != lanes {
            return None;
        }
        let mut side = Self { lanes, rows: parts / lanes, joints, entries: entries / parts, packs: Vec::new() };
        for pack in &members.packs {
            let plain = |&member: &usize| {
                scatters.members[member].is_plain && meets_joints(structure, topology, members, member)
            };
            let own = &pack.mesh().members;
            let may = own.len() == lanes && own.iter().all(plain);
            let joints: Vec<[usize; 2]> = own.iter().map(|&member| joints_of(member)).collect();
            let places: Vec<&EndPlaces> = own.iter().map(|&member| &scatters.members[member].plain).collect();
            side.packs.push(if may { side.beside(&joints, &places) } else { None });
        }
        side.packs.iter().any(Option::is_some).then_some(side)
    }

    /// Where members are in rows, by their joints and the places of their stiffness; nothing where these differ.
    fn beside(&self, joints: &[[usize; 2]], places: &[&EndPlaces]) -> Option<Beside> {
        let first = joints[0][0] / self.joints;
        let row = first / self.lanes;
        let (joint, entry) = (first * self.joints, first * self.entries);
        let alike = |(lane, own): (usize, &[usize; 2])| {
            (0..2).all(|end| own[end] == joints[0][end] + lane * self.joints && own[end] / self.joints == first + lane)
        };
        if !first.is_multiple_of(self.lanes) || !joints.iter().enumerate().all(alike) {
            return None;
        }
        let mut own = EndPlaces::default();
        for (kind, own) in own.iter_mut().enumerate() {
            for (index, &(place, position)) in places[0][kind].iter().enumerate() {
                let same = |(lane, other): (usize, &&EndPlaces)| {
                    other[kind].get(index) == Some(&(place, position + (lane * self.entries) as u32))
                };
                let within = (position as usize).checked_sub(entry).filter(|&within| within < self.entries)?;
                if !places.iter().enumerate().all(same) {
                    return None;
                }
                own.push((place, (row * self.entries + within) as u32));
            }
        }
        Some(Beside { joints: joints[0].map(|own| row * self.joints + own - joint), places: own })
    }

    /// Whether it is that of another structure of the same equations too: arms and releases follow from numbers.
    pub(super) fn serves<const D: usize>(
        &self,
        structure: &Structure,
        topology: &Topology,
        members: &Members<D>,
    ) -> bool {
        let beside = members.packs.iter().zip(&self.packs).filter(|(_, beside)| beside.is_some());
        let mut own = beside.flat_map(|(pack, _)| &pack.mesh().members);
        own.all(|&member| meets_joints(structure, topology, members, member))
    }

    /// Whether the members of a pack lie beside their likes.
    pub(super) fn has(&self, pack: usize) -> bool {
        self.packs[pack].is_some()
    }

    /// The joints of the members of a pack, by row, where they lie beside their likes.
    pub(super) fn joints_of(&self, pack: usize) -> Option<[usize; 2]> {
        self.packs[pack].as_ref().map(|beside| beside.joints)
    }

    /// The parts in lanes of rows: row, lane and part.
    fn parts(&self) -> impl Iterator<Item = (usize, usize, usize)> {
        let lanes = self.lanes;
        (0..self.rows * lanes).map(move |part| (part / lanes, part % lanes, part))
    }

    /// Puts numbers of all joints in rows, N of each.
    fn fill<const N: usize>(&self, rows: &mut Vec<f64>, numbers: impl Fn(usize) -> [f64; N]) {
        rows.resize(self.rows * self.joints * N * self.lanes, 0.0);
        for (row, lane, part) in self.parts() {
            for joint in 0..self.joints {
                let own = numbers(part * self.joints + joint);
                let first = (row * self.joints + joint) * N * self.lanes + lane;
                for (n, number) in own.into_iter().enumerate() {
                    rows[first + n * self.lanes] = number;
                }
            }
        }
    }
}

/// Whether the ends of a member are those of its joints.
fn meets_joints<const D: usize>(
    structure: &Structure,
    topology: &Topology,
    members: &Members<D>,
    member: MemberId,
) -> bool {
    let arms = structure.members[member].nodes.iter().any(|&node| topology.links[node].has_arm());
    !members.slots[member].released && !arms
}

impl<const D: usize> System<D> {
    /// Adds what members beside their likes give to their joints.
    pub(super) fn assemble_side(&mut self, side: &Side) {
        let Self { tangent, members, pattern, side_rows: Rows { ends, .. }, .. } = self;
        let active = pattern.equations.active;
        let keeps = tangent.keeps_matrix;
        for rows in [&mut ends.forces, &mut ends.stiffness] {
            rows.clear();
            rows.resize(side.rows * side.joints * D * side.lanes, 0.0);
        }
        if !keeps {
            ends.values.clear();
            ends.values.resize(side.rows * side.entries * side.lanes, 0.0);
        }
        for (pack, beside) in members.packs.iter().zip(&side.packs) {
            let Some(Beside { joints, places }) = beside else { continue };
            let squares = pack.add_ends(ends, *joints, (!keeps).then_some(places));
            tangent.note_squares(squares);
        }
        for (row, lane, part) in side.parts() {
            for joint in 0..side.joints {
                let first = (row * side.joints + joint) * D * side.lanes + lane;
                let own = part * side.joints + joint;
                for i in 0..D {
                    tangent.forces[own][active[i]] += ends.forces[first + i * side.lanes];
                }
                if !keeps {
                    for i in 0..D {
                        tangent.stiffness[own][active[i]] += ends.stiffness[first + i * side.lanes];
                    }
                }
            }
            if !keeps {
                let own = &mut tangent.linear.values[part * side.entries..(part + 1) * side.entries];
                let rows = &ends.values[row * side.entries * side.lanes..(row + 1) * side.entries * side.lanes];
                let mut at = lane;
                for value in own {
                    *value += rows[at];
                    at += side.lanes;
                }
            }
        }
    }

    /// Puts motions of the joints in rows, for members beside their likes.
    pub(super) fn fill_side(&mut self, side: &Side, motions: &[[f64; 6]]) {
        let active = self.pattern.equations.active;
        side.fill(&mut self.side_rows.motions, |joint| {
            let mut own = [0.0; D];
            for i in 0..D {
                own[i] = motions[joint][active[i]];
            }
            own
        });
    }

    /// Puts the ends of members beside their likes where their joints are.
    pub(super) fn place_side(&mut self, side: &Side) {
        let joints = &self.places.joints;
        let Rows { poses, .. } = &mut self.side_rows;
        if D == 3 {
            side.fill(poses, |joint| {
                let Placement { displacement: [x, y, _], angle, .. } = joints[joint].place;
                [x, y, angle]
            });
        } else {
            side.fill(poses, |joint| {
                let Placement { displacement: [x, y, z], rotation: [a, b, c, d], .. } = joints[joint].place;
                [x, y, z, a, b, c, d]
            });
        }
        for (pack, beside) in self.members.packs.iter_mut().zip(&side.packs) {
            if let Some(Beside { joints, .. }) = beside {
                pack.set_ends(poses, *joints);
            }
        }
    }
}
