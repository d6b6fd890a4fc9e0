//! What supports and steps hold, and what they let go.

use std::f64::consts::TAU;
use std::sync::Arc;

use pennate_elements::small::{V3, add, dot, norm, scale, sub};

use super::{Continuation, QUARTER_TURN};
use crate::history::{Note, StepHistory};
use crate::joints::{Held, HeldKind, Topology, Turned};
use crate::structure::{Change, NodeId, Step, Structure};
use crate::system::System;

/// How near a whole turn is (turns). That near it the tangent map of the rotation vector (Eq. 5.2) makes spins across the axis this many
/// times as small, $2 \sin(\theta/2) / \theta$: free components hardly turn a node any more.
const NEAR_WHOLE: f64 = 0.01;

/// Whether a rotation vector (radians) that goes straight from one value to another comes to the length of a whole turn or of several.
fn comes_to_whole_turn(from: V3<f64>, to: V3<f64>) -> bool {
    let way = sub(to, from);
    // Where it is shortest.
    let share = (-dot(from, way) / dot(way, way)).clamp(0.0, 1.0);
    let least = if share.is_nan() { norm(to) } else { norm(add(from, scale(share, way))) };
    let most = norm(from).max(norm(to));
    let first = (least / TAU - NEAR_WHOLE).ceil().max(1.0);
    first <= most / TAU + NEAR_WHOLE
}

impl<const D: usize> Continuation<'_, D> {
    /// Axes in which a node's components are measured.
    fn axes(&self, node: NodeId) -> [[f64; 3]; 3] {
        const GLOBAL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        self.axes.get(&node).copied().unwrap_or(GLOBAL)
    }

    pub(super) fn insert(&mut self, node: NodeId, component: usize, from: f64, to: f64) {
        let axis = self.axes(node)[component % 3];
        let kind = HeldKind::of(component, axis);
        self.held.insert((node, component), Held { node, component, kind, from, to });
    }

    /// Present value of a component.
    pub(super) fn present(&self, node: NodeId, component: usize) -> f64 {
        self.system.present(node, component, self.axes(node)[component % 3])
    }

    /// Applies the changes that a step makes to what is held; gives the reactions that fade.
    pub(super) fn change(&mut self, changes: &[Change]) {
        for held in self.held.values_mut() {
            held.from = held.to;
        }
        self.system.loading.fading.clear();
        for change in changes {
            match *change {
                Change::Prescribe { node, component, to } => {
                    let from =
                        self.held.get(&(node, component)).map_or_else(|| self.present(node, component), |h| h.to);
                    self.insert(node, component, from, to);
                }
                Change::Hold { node, component } => {
                    let value = self.present(node, component);
                    self.insert(node, component, value, value);
                }
                Change::MoveBy { node, component, by } => {
                    let from = self.present(node, component);
                    self.insert(node, component, from, from + by);
                }
                Change::Free { node, component } => {
                    self.held.remove(&(node, component));
                    let reaction = self.system.fading_reaction(node, component);
                    self.system.loading.fading.push(reaction);
                }
            }
        }
        self.system.hold(self.held.values().copied().collect());
    }

    /// Notes how far the elements of the next order stand from these where a step goes on from where the last one came to: what they
    /// hold differs by as much, so that the error of the step before is part of those that follow.
    pub(super) fn take_over_errors(&mut self, changes: &[Change]) {
        for change in changes {
            let (node, component) = change.place();
            self.refined_held.remove(&(node, component));
            let stays = matches!(change, Change::Hold { .. } | Change::MoveBy { .. });
            let Some(refined) = self.refined.as_ref().filter(|_| stays && self.refined_stands) else { continue };
            let theirs = refined.present(node, component, self.axes(node)[component % 3]);
            let apart = theirs - self.present(node, component);
            // A rotation that was counted another way round tells nothing.
            if component < 3 || apart.abs() < QUARTER_TURN {
                self.refined_held.insert((node, component), apart);
            }
        }
    }

    /// Notes which nodes, of those whose rotations are held in part, the present step has brought to a whole turn or through it.
    pub(super) fn note_whole_turns(&self, record: &mut StepHistory) {
        if D == 2 {
            return;
        }
        let mut nodes: Vec<NodeId> = self.held.keys().filter(|(_, row)| *row >= 3).map(|&(node, _)| node).collect();
        nodes.dedup();
        for node in nodes {
            let rows: Vec<&Held> = self.held.range((node, 3)..=(node, 5)).map(|(_, held)| held).collect();
            let held_at = |fraction: f64| {
                let mut theta = [0.0; 3];
                rows.iter().for_each(|held| theta[held.component - 3] = held.at(fraction));
                theta
            };
            let [from, to] = [0.0, record.fraction].map(held_at);
            if rows.len() < 3 && from != to && comes_to_whole_turn(from, to) {
                record.notes.push(Note::WholeTurn { node, is_there: comes_to_whole_turn(to, to) });
            }
        }
    }

    /// Brings another system of the network, at the end of the present step, to the beginning of the ramp of the next one.
    pub(crate) fn begin(&mut self, step: &Step, system: &mut System<D>) {
        let held = self.held.clone();
        std::mem::swap(&mut self.system, system);
        self.change(&step.changes);
        self.system.loading.fraction = 0.0;
        self.system.apply_drives();
        std::mem::swap(&mut self.system, system);
        self.held = held;
    }
}

/// Rows that supports and the first step hold, at rest.
pub fn first_rows(structure: &Structure, steps: &[Step]) -> Vec<(NodeId, usize)> {
    let mut rows: Vec<_> =
        structure.supports.iter().flat_map(|s| (0..6).filter(|&c| s.fixed[c]).map(|c| (s.node, c))).collect();
    for change in steps.first().map_or(&[][..], |s| &s.changes) {
        match *change {
            Change::Prescribe { node, component, .. }
            | Change::Hold { node, component }
            | Change::MoveBy { node, component, .. } => rows.push((node, component)),
            Change::Free { .. } => {}
        }
    }
    rows
}

/// Builds the topology of a structure for its steps.
pub fn topology(structure: &Structure, steps: &[Step]) -> Arc<Topology> {
    Arc::new(Topology::new(structure, Turned::nodes(structure, steps)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Degrees that components of a rotation vector go through: one, and two at once.
    #[test]
    fn a_whole_turn_is_seen_wherever_the_way_passes_it() {
        let comes = |from: [f64; 2], to: [f64; 2]| {
            let [from, to] = [from, to].map(|[x, y]| [x.to_radians(), y.to_radians(), 0.0]);
            comes_to_whole_turn(from, to)
        };
        for (from, to) in
            [(0.0, 360.0), (350.0, 370.0), (358.0, 362.0), (362.0, 358.0), (-400.0, 400.0), (500.0, 900.0)]
        {
            assert!(comes([from, 0.0], [to, 0.0]) && comes([to, 0.0], [from, 0.0]), "{from} to {to}");
        }
        for (from, to) in [(0.0, 350.0), (-350.0, 350.0), (370.0, 710.0), (0.0, 0.0)] {
            assert!(!comes([from, 0.0], [to, 0.0]), "{from} to {to}");
        }
        // Neither component makes a whole turn here; both together do, or come nearer on the way than at its ends.
        assert!(comes([0.0, 0.0], [300.0, 300.0]) && !comes([0.0, 0.0], [250.0, 250.0]));
        assert!(comes([500.0, 0.0], [0.0, 500.0]) && !comes([500.0, 400.0], [500.0, -200.0]));
        assert!(comes([360.0, 0.0], [360.0, 0.0]) && !comes([370.0, 0.0], [370.0, 0.0]));
    }
}
