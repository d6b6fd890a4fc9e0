//! Members split at their middle, where one of them loses its stability between its ends.
//!
//! What a path is steered by are the motions of the joints. A clamped column that buckles between its ends moves none of
//! them, so it is given one more joint, in its middle, and the path is followed anew. Results are those of the members
//! as they were.

use std::sync::Arc;

use pennate_elements::small::{add, apply, tmul, transpose};

use crate::chain::Bent;
use crate::history::{Cause, Equilibrium, Failure, History, MemberShape, MemberState, Note, Peak, SectionForces};
use crate::structure::{Drive, Member, MemberId, NodeId, Release, Segment, Step, Structure};

/// Part of a member's length within which a boundary between segments is its middle.
const NEAR: f64 = 1e-6;

/// A structure with some members in two halves.
pub(crate) struct Split {
    pub structure: Arc<Structure>,
    pub steps: Vec<Step>,
    /// Nodes and members of the structure as it was.
    nodes: usize,
    members: usize,
    /// The members that were split, and the segment that their second halves begin with. Half k is member
    /// `members + k`, between the halves lies node `nodes + k`.
    halves: Vec<(MemberId, usize)>,
    /// Members whose sections are asked for.
    sampled: Vec<MemberId>,
}

impl Split {
    /// Splits members at their middle.
    pub(crate) fn new(structure: &Structure, steps: &[Step], members: &[MemberId]) -> Self {
        let mut split = structure.clone();
        let mut steps = steps.to_vec();
        let mut halves = Vec::new();
        for &index in members {
            let member = structure.members[index].clone();
            let (first, second, segment, middle) = halve(structure, &member, split.nodes.len());
            split.nodes.push(middle);
            split.members[index] = first;
            split.members.push(second);
            halves.push((index, segment));
            for (drive, description) in structure.drives.iter().enumerate() {
                let Drive::Distributed(loaded, component) = *description else { continue };
                if loaded != index {
                    continue;
                }
                split.drives.push(Drive::Distributed(split.members.len() - 1, component));
                let copy = split.drives.len() - 1;
                for step in &mut steps {
                    let same: Vec<_> = step.targets.iter().filter(|t| t.0 == drive).map(|t| (copy, t.1)).collect();
                    step.targets.extend(same);
                }
            }
        }
        for sampled in &structure.sections {
            if let Some(k) = halves.iter().position(|(member, _)| member == sampled) {
                split.sections.push(structure.members.len() + k);
            }
        }
        Self {
            sampled: structure.sections.clone(),
            structure: Arc::new(split),
            steps,
            nodes: structure.nodes.len(),
            members: structure.members.len(),
            halves,
        }
    }

    /// The same history, of the members as they were.
    pub(crate) fn joined(&self, mut history: History) -> History {
        for step in &mut history.steps {
            for increment in &mut step.increments {
                self.join_state(&mut increment.state);
                if !increment.shapes.is_empty() {
                    for (k, &(member, segment)) in self.halves.iter().enumerate() {
                        let second = std::mem::take(&mut increment.shapes[self.members + k]);
                        join_shapes(&mut increment.shapes[member], second, segment);
                    }
                    increment.shapes.truncate(self.members);
                }
            }
            if let Some(refined) = &mut step.refined {
                self.join_state(refined);
            }
            if step.variations.len() > self.members {
                let seconds = step.variations.split_off(self.members);
                for (second, &(member, _)) in seconds.into_iter().zip(&self.halves) {
                    step.variations[member].extend(second);
                }
            }
            for point in &mut step.critical_points {
                let middles = point.mode.split_off(self.nodes);
                // What is known of the middle of a half is of no use to the whole, whose middle is a node here.
                point
                    .middles
                    .retain(|(member, _)| *member < self.members && self.halves.iter().all(|half| half.0 != *member));
                point.middles.extend(self.halves.iter().map(|half| half.0).zip(middles));
                point.member = point.member.map(|member| self.whole(member));
                if let Some(member) = self.member_of(point.node) {
                    point.member = Some(member);
                    point.node = self.structure.members[member].nodes[0];
                }
            }
            for jump in &mut step.jumps {
                if let Some(member) = self.member_of(jump.node) {
                    jump.node = self.structure.members[member].nodes[0];
                }
            }
            for note in &mut step.notes {
                if let Note::Undetermined { members } | Note::TurnedAboutItself { members } = note {
                    members.iter_mut().for_each(|member| *member = self.whole(*member));
                    members.sort_unstable();
                    members.dedup();
                }
            }
            if let Some(Failure { cause: Cause::Overheld { member }, .. }) = &mut step.failure {
                *member = self.whole(*member);
            }
            if let Some(failure) = &mut step.failure
                && let Some(member) = failure.worst_node.and_then(|node| self.member_of(node))
            {
                failure.worst_node = Some(self.structure.members[member].nodes[0]);
            }
        }
        history.inside = self.halves.iter().map(|half| half.0).collect();
        history
    }

    /// The member as it was that this one is, or is the second half of.
    fn whole(&self, member: MemberId) -> MemberId {
        member.checked_sub(self.members).map_or(member, |k| self.halves[k].0)
    }

    fn member_of(&self, node: NodeId) -> Option<MemberId> {
        node.checked_sub(self.nodes).map(|k| self.halves[k].0)
    }

    /// Sections of second halves follow those that were asked for, in the order of the halves.
    fn join_sections(&self, sections: &mut Vec<Vec<SectionForces>>) {
        let asked = self.sampled.len();
        let mut halves = sections.split_off(asked.min(sections.len())).into_iter();
        for (own, sampled) in sections.iter_mut().zip(&self.sampled) {
            let Some(&(_, segment)) = self.halves.iter().find(|(member, _)| member == sampled) else { continue };
            own.iter_mut().for_each(|section| section.at *= 0.5);
            own.extend(halves.next().unwrap_or_default().into_iter().map(|mut section| {
                section.at = 0.5 * (section.at + 1.0);
                section.segment += segment;
                section
            }));
        }
    }

    fn join_state(&self, state: &mut Equilibrium) {
        for (k, &(member, _)) in self.halves.iter().enumerate() {
            let second = state.members[self.members + k];
            let first = &mut state.members[member];
            *first = MemberState {
                length: first.length + second.length,
                axial_force: first.axial_force_ends[1],
                axial_force_ends: [first.axial_force_ends[0], second.axial_force_ends[1]],
                end_forces: [first.end_forces[0], second.end_forces[1]],
                end_moments: [first.end_moments[0], second.end_moments[1]],
                control: first.control,
                stretch: larger(half(first.stretch, 0), half(second.stretch, 1)),
                bending: larger(half(first.bending, 0), half(second.bending, 1)),
            };
        }
        self.join_sections(&mut state.sections);
        for node in state.rounding.iter_mut().flat_map(|rounding| &mut rounding.nodes) {
            if let Some(member) = self.member_of(*node) {
                *node = self.structure.members[member].nodes[0];
            }
        }
        state.members.truncate(self.members);
        state.nodes.truncate(self.nodes);
    }
}

/// A place on the first (0) or second (1) half of a member as a place on the whole.
fn half(peak: Peak, side: u8) -> Peak {
    Peak { at: 0.5 * (peak.at + f64::from(side)), ..peak }
}

fn larger(a: Peak, b: Peak) -> Peak {
    if b.value.abs() > a.value.abs() { b } else { a }
}

fn join_shapes(first: &mut MemberShape, second: MemberShape, segment: usize) {
    first.points.extend(second.points.into_iter().skip(1));
    first.cells.extend(second.cells.into_iter().map(|mut cell| {
        cell.segment += segment;
        cell
    }));
}

/// Both halves of a member, the segment that the second begins with, and the node between them.
fn halve(structure: &Structure, member: &Member, node: NodeId) -> (Member, Member, usize, [f64; 3]) {
    let length: f64 = member.segments.iter().map(|segment| segment.length).sum();
    let (mut first, mut second) = (Vec::new(), Vec::new());
    let mut axes = member.axes;
    let mut position = structure.nodes[member.nodes[0]];
    let mut at = 0.0;
    let mut begins = 0;
    for (index, segment) in member.segments.iter().enumerate() {
        let part = (0.5 * length - at) / segment.length;
        if part >= 1.0 - NEAR {
            move_along(&mut position, &mut axes, segment, segment.length);
            first.push(*segment);
        } else if part > NEAR {
            let (left, right) = cut(segment, part);
            move_along(&mut position, &mut axes, segment, left.length);
            begins = index;
            first.push(left);
            second.push(right);
        } else {
            if second.is_empty() {
                begins = index;
            }
            second.push(*segment);
        }
        at += segment.length;
    }
    let [start, end] = member.nodes;
    let [released, also] = member.releases.clone();
    let half = |nodes, axes, segments, releases| Member { nodes, axes, segments, releases, ..member.clone() };
    (
        half([start, node], member.axes, first, [released, Release::Welded]),
        half([node, end], axes, second, [Release::Welded, also]),
        begins,
        position,
    )
}

fn cut(segment: &Segment, part: f64) -> (Segment, Segment) {
    let elements = segment.elements.max(1);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a part of a count")]
    let left = ((part * elements as f64).round() as usize).clamp(1, elements.max(2) - 1);
    let right = (elements - left.min(elements)).max(1);
    let piece = |part: f64, elements| Segment { length: part * segment.length, elements, ..*segment };
    (piece(part, left), piece(1.0 - part, right))
}

/// Moves a point and the material axes there along an unloaded segment.
fn move_along(position: &mut [f64; 3], axes: &mut [[f64; 3]; 3], segment: &Segment, length: f64) {
    let bent = Bent { length, curvature: segment.initial_curvature };
    *position = add(*position, apply(&transpose(axes), &bent.position(length)));
    *axes = tmul(&bent.frame(length), axes);
}
