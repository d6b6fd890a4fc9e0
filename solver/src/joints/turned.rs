//! What supports, steps and loads do to the rotations of nodes.

use std::collections::BTreeMap;

use pennate_elements::small::{V3, dot, norm, scale, sub};

use super::{Idle, PARALLEL};
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
                let (node, component) = change.place();
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

    /// What of two axes nothing acts about: both of them, one in their plane, or none.
    pub(crate) fn left_of(&self, [a, b]: [V3<f64>; 2]) -> Idle {
        let acts = |v: &&V3<f64>| [a, b].iter().any(|axis| dot(**v, *axis).abs() > PARALLEL * norm(**v));
        let acting: Vec<&V3<f64>> = self.moments.iter().chain(&self.held).filter(acts).collect();
        let Some(first) = acting.first() else { return Idle::Spins([a, b]) };
        let across = sub(scale(dot(**first, b), a), scale(dot(**first, a), b));
        let left = scale(1.0 / norm(across), across);
        if self.acts_about(left) { Idle::None } else { Idle::Spin(left) }
    }
}
