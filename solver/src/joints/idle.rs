//! Motions that no force belongs to, as long as the same rows are held.
//!
//! Theory: docs/theory/joints.md, motions that nothing resists.

use pennate_elements::small::{V3, cross, norm};

use super::topology::{Attached, EndKind, Topology};
use super::{Held, HeldKind, PARALLEL};
use crate::structure::{MemberId, Structure};

/// Motions of a joint that no force belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Idle {
    /// There is none.
    None,
    /// The joint has no rotation of its own.
    Rotation,
    /// It does not turn about this axis (global, unloaded, carried along).
    Spin(V3<f64>),
    /// It does not turn about either of these axes, about both of which its only end that takes a moment is released.
    Spins([V3<f64>; 2]),
}

impl Idle {
    /// Axes about which the joint does not turn, where it has a rotation of its own.
    pub fn axes(&self) -> &[V3<f64>] {
        match self {
            Self::None | Self::Rotation => &[],
            Self::Spin(axis) => std::slice::from_ref(axis),
            Self::Spins(axes) => axes,
        }
    }
}

/// Where a straight line of bars is kept from spinning about itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kept {
    /// At the released end of a bar: the bar, and which of its ends.
    End(MemberId, usize),
    /// At a joint of the line.
    Joint(usize),
}

/// A straight line of bars that nothing keeps from spinning about itself.
#[derive(Debug)]
pub(crate) struct Line {
    /// Its bars, one at least.
    pub bars: Vec<MemberId>,
    /// Where it is kept from that.
    pub kept: Kept,
}

fn parallel(a: V3<f64>, b: V3<f64>) -> bool {
    norm(cross(a, b)) < PARALLEL * norm(a) * norm(b)
}

impl Topology {
    /// The same where these rows are held; none where they are already.
    pub(crate) fn held_by(&self, structure: &Structure, rows: &[Held]) -> Option<Self> {
        let held = || {
            rows.iter().filter_map(|row| match row.kind {
                HeldKind::Rotation { axis } => Some((row.node, axis)),
                HeldKind::Translation { .. } => None,
            })
        };
        let known: usize = self.turned.iter().map(|turned| turned.held.len()).sum();
        let same = known == held().count() && held().all(|(node, axis)| self.turned[node].held.contains(&axis));
        if same || !self.follows_rows {
            return None;
        }
        let mut after = self.clone();
        after.turned.iter_mut().for_each(|turned| turned.held.clear());
        held().for_each(|(node, axis)| after.turned[node].held.push(axis));
        let attached = Attached::of(structure, &after);
        let engaged = after.rotation_engaged(structure);
        after.find_idle(structure, &attached, &engaged);
        Some(after)
    }

    /// Finds what is idle as long as the rows in `turned` are held.
    pub(super) fn find_idle(&mut self, structure: &Structure, attached: &Attached, engaged: &[bool]) {
        self.idle.fill(Idle::None);
        self.ends.iter_mut().flatten().for_each(EndKind::release_spin);
        self.remove_idle_joints(attached, engaged);
        self.remove_idle_spins(structure, attached, engaged);
    }

    fn remove_idle_joints(&mut self, attached: &Attached, engaged: &[bool]) {
        for joint in (0..self.references.len()).filter(|&joint| !engaged[joint]) {
            let ends = attached.at(joint).iter().map(|&(member, end)| &self.ends[member][end]);
            let all = ends.filter(|kind| !matches!(kind, EndKind::Free { .. }));
            let mut taking = all.clone();
            let about = |kind: &EndKind, axis| matches!(kind, EndKind::Axes { axes, .. } if axes.len() == 1 && parallel(axes[0], axis));
            let hinged_about = |axis: V3<f64>| all.clone().all(|kind| about(kind, axis));
            let turned = &self.turned[self.references[joint]];
            self.idle[joint] = match (taking.next(), taking.next()) {
                (None, _) if turned.moments.is_empty() => Idle::Rotation,
                // Turns of the end about both axes make up for those of the joint.
                (Some(EndKind::Axes { axes, .. }), None) if axes.len() == 2 => turned.left_of([axes[0], axes[1]]),
                (Some(EndKind::Axes { axes, .. }), _) if hinged_about(axes[0]) && !turned.acts_about(axes[0]) => {
                    Idle::Spin(axes[0])
                }
                _ => Idle::None,
            };
        }
    }

    /// A straight line of bars that nothing keeps from spinning about itself is kept from it at one end.
    fn remove_idle_spins(&mut self, structure: &Structure, attached: &Attached, engaged: &[bool]) {
        let mut kept = Vec::new();
        self.spinning_lines(structure, attached, engaged, |bars, at| kept.push((bars[0], at)));
        for (bar, at) in kept {
            let axis = structure.members[bar].axes[0];
            match at {
                Kept::End(bar, end) => match &mut self.ends[bar][end] {
                    EndKind::Free { spin_removed } => *spin_removed = true,
                    EndKind::Axes { axes, kept } => *kept = axes.iter().position(|a| parallel(*a, axis)),
                    EndKind::Welded => {}
                },
                Kept::Joint(joint) => self.idle[joint] = Idle::Spin(axis),
            }
        }
    }

    /// The lines of bars that are kept from spinning about themselves at present.
    pub(crate) fn kept_lines(&self, structure: &Structure) -> Vec<Line> {
        let mut lines = Vec::new();
        if !self.ends.iter().flatten().any(EndKind::keeps_spin)
            && !self.idle.iter().any(|idle| matches!(idle, Idle::Spin(_)))
        {
            return lines;
        }
        let mut free = self.clone();
        let attached = Attached::of(structure, &free);
        let engaged = free.rotation_engaged(structure);
        free.idle.fill(Idle::None);
        free.remove_idle_joints(&attached, &engaged);
        free.spinning_lines(structure, &attached, &engaged, |bars, kept| {
            lines.push(Line { bars: bars.to_vec(), kept })
        });
        lines
    }

    /// The same with these lines free to spin. What is idle stays as it is from here on.
    pub(crate) fn let_spin(&self, lines: &[Line]) -> Self {
        let mut after = Self { follows_rows: false, ..self.clone() };
        for line in lines {
            match line.kept {
                Kept::End(bar, end) => after.ends[bar][end].release_spin(),
                Kept::Joint(joint) => after.idle[joint] = Idle::None,
            }
        }
        after
    }

    /// Finds the straight lines of bars that nothing keeps from spinning about themselves, and where they are to be kept from it.
    ///
    /// Bars of a line are joined rigidly, or at least about the line, at joints where nothing else takes a torque; at
    /// its ends stand released ends, or joints whose rotation is free.
    fn spinning_lines(
        &self,
        structure: &Structure,
        attached: &Attached,
        engaged: &[bool],
        mut found: impl FnMut(&[MemberId], Kept),
    ) {
        // A twisted bar is straight, too.
        let is_straight = |index: usize| {
            let segments = &structure.members[index].segments;
            segments.iter().all(|segment| segment.initial_curvature[1..] == [0.0; 2])
        };
        let mut seen = vec![false; structure.members.len()];
        // The line that a bar was last put into, by its first bar.
        let mut line_of = vec![usize::MAX; structure.members.len()];
        // Bars of the line; ends at which the spin is free, and joints that spin with it.
        let (mut line, mut free_ends, mut free_joints) = (Vec::new(), Vec::new(), Vec::new());
        for index in 0..structure.members.len() {
            if seen[index] || !is_straight(index) {
                continue;
            }
            let axis = structure.members[index].axes[0];
            let spins = |kind: &EndKind| match kind {
                EndKind::Welded => false,
                EndKind::Free { .. } => true,
                EndKind::Axes { axes, .. } => axes.iter().any(|a| parallel(*a, axis)),
            };
            line.clear();
            free_ends.clear();
            free_joints.clear();
            line.push(index);
            line_of[index] = index;
            let mut spinning = true;
            let mut next = 0;
            while let Some(&bar) = line.get(next) {
                next += 1;
                seen[bar] = true;
                for end in 0..2 {
                    if spins(&self.ends[bar][end]) {
                        free_ends.push((bar, end));
                        continue;
                    }
                    let joint = self.links[structure.members[bar].nodes[end]].joint;
                    let taking = attached.at(joint).iter().filter(|&&(m, e)| !spins(&self.ends[m][e]));
                    let in_line = |m: usize| is_straight(m) && parallel(structure.members[m].axes[0], axis);
                    if engaged[joint]
                        || self.turned[self.references[joint]].acts_about(axis)
                        || !taking.clone().all(|&(member, _)| in_line(member))
                    {
                        spinning = false;
                        continue;
                    }
                    if taking.clone().count() == 1 && self.idle[joint] == Idle::None {
                        free_joints.push(joint);
                    }
                    for &(member, _) in taking {
                        if line_of[member] != index {
                            line_of[member] = index;
                            line.push(member);
                        }
                    }
                }
            }
            if !spinning {
                continue;
            }
            let end = free_ends.first().map(|&(bar, end)| Kept::End(bar, end));
            if let Some(kept) = end.or_else(|| free_joints.first().map(|&joint| Kept::Joint(joint))) {
                found(&line, kept);
            }
        }
    }
}
