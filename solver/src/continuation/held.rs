//! What supports and steps hold, and what they let go.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::{Continuation, QUARTER_TURN};
use crate::joints::{Held, HeldKind, Topology, Turned};
use crate::structure::{Change, NodeId, Step, Structure};
use crate::system::System;

/// What is left of a whole turn where free components of a rotation vector hardly turn a node any more: a hundredth of them does.
const WHOLE: f64 = 0.01;

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

    /// Nodes whose rotations are held in part, in space, and which the present step has turned up to a whole turn or through it at this
    /// fraction. There the rotation vector is singular: its components across the axis do not change the rotation (Eq. 5.6).
    pub(super) fn turned_whole(&self, fraction: f64) -> Vec<NodeId> {
        if D == 2 {
            return Vec::new();
        }
        let rotations = |node: NodeId| self.held.range((node, 3)..=(node, 5)).map(|(_, held)| held);
        let mut nodes: Vec<NodeId> =
            self.held.keys().filter(|(_, component)| *component >= 3).map(|&(n, _)| n).collect();
        nodes.dedup();
        nodes.retain(|&node| {
            let whole_turns = |angle: &dyn Fn(&Held) -> f64| {
                (rotations(node).map(|held| angle(held).powi(2)).sum::<f64>().sqrt() / TAU + WHOLE).floor()
            };
            rotations(node).count() < 3 && whole_turns(&|held| held.from) != whole_turns(&|held| held.at(fraction))
        });
        nodes
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
