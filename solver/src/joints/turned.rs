//! What supports, steps and loads do to the rotations of nodes.

use std::collections::BTreeMap;

use pennate_elements::small::{V3, dot, norm, scale, sub};

use super::PARALLEL;
use crate::structure::{Change, Drive, NodeId, Step, Structure};

/// What acts on the rotation of a node from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Turned {
    /// Axes about which the rotation is held or moved at present.
    pub held: Vec<V3<f64>>,
    /// Moments that steps apply, any of them.
    pub moments: Vec<V3<f64>>,
    /// Whether supports or any step hold or move the rotation.
    pub at_times: bool,
}

impl Turned {
    /// For every node of a structure, at the beginning of the first step.
    pub(crate) fn nodes(structure: &Structure, steps: &[Step]) -> Vec<Self> {
        let mut turned = vec![Self::default(); structure.nodes.len()];
        let mut axes = vec![[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]; structure.nodes.len()];
        for support in &structure.supports {
            axes[support.node] = support.axes;
            let held = (0..3).filter(|&c| support.fixed[3 + c]).map(|c| support.axes[c]);
            turned[support.node].held.extend(held);
            turned[support.node].at_times |= support.fixed[3..].contains(&true);
        }
        for change in steps.first().map_or(&[][..], |step| &step.changes) {
            if let Change::Prescribe { node, component, .. }
            | Change::Hold { node, component }
            | Change::MoveBy { node, component, .. } = *change
                && component >= 3
            {
                let (held, axis) = (&mut turned[node].held, axes[node][component - 3]);
                if !held.contains(&axis) {
                    held.push(axis);
                }
            }
        }
        for step in steps {
            for change in &step.changes {
                let (Change::Prescribe { node, component, .. }
                | Change::Hold { node, component }
                | Change::MoveBy { node, component, .. }
                | Change::Free { node, component }) = *change;
                turned[node].at_times |= component >= 3;
            }
            let mut moments: BTreeMap<(NodeId, bool), V3<f64>> = BTreeMap::new();
            for &(drive, value) in &step.targets {
                match structure.drives[drive] {
                    Drive::Moment(node, c) => moments.entry((node, false)).or_default()[c] = value,
                    Drive::FollowerMoment(node, c) => moments.entry((node, true)).or_default()[c] = value,
                    _ => {}
                }
            }
            for ((node, _), moment) in moments {
                if moment != [0.0; 3] {
                    turned[node].moments.push(moment);
                }
            }
        }
        turned
    }

    /// Whether nothing ever acts on the rotation.
    pub(crate) fn is_left_alone(&self) -> bool {
        self.moments.is_empty() && !self.at_times
    }

    /// Whether anything acts about this axis.
    pub(crate) fn acts_about(&self, axis: V3<f64>) -> bool {
        let acts = |v: &V3<f64>| dot(*v, axis).abs() > PARALLEL * norm(*v);
        self.moments.iter().any(acts) || self.held.iter().any(acts)
    }

    /// Whether a moment acts about this axis, or what is held contains the rotation about it.
    pub(crate) fn keeps_spin(&self, axis: V3<f64>) -> bool {
        let mut rest = axis;
        let mut basis: Vec<V3<f64>> = Vec::new();
        let less = |v: V3<f64>, q: &V3<f64>| sub(v, scale(dot(v, *q), *q));
        for &row in &self.held {
            let left = basis.iter().fold(row, less);
            if norm(left) > 1e-6 {
                let q = scale(1.0 / norm(left), left);
                rest = less(rest, &q);
                basis.push(q);
            }
        }
        norm(rest) < 1e-6 || self.moments.iter().any(|m| dot(*m, axis).abs() > PARALLEL * norm(*m))
    }
}
