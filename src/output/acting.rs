//! What acts on a network in one increment, for pictures: loads on nodes and members, and what holds the nodes.

use nalgebra::{Rotation3, Vector3};
use pennate_models::Model;
use pennate_models::model::Target;
use pennate_solver::history::{Increment, StepHistory};
use pennate_solver::structure::Change;

use super::loads::{end, on_the_way};

const GLOBAL_AXES: [[f64; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// The loads that steps put on nodes and members, follower loads as they are turned; and the held components of each node.
pub(crate) struct Acting {
    pub forces: Vec<[f64; 3]>,
    pub moments: Vec<[f64; 3]>,
    /// Of each member, force per unloaded length.
    pub distributed: Vec<[f64; 3]>,
    pub holds: Vec<Hold>,
}

/// What holds a node: its supports, with what steps have prescribed, held and freed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Hold {
    /// Components that are held, as the sum of 1 ux, 2 uy, 4 uz, 8 rx, 16 ry, 32 rz.
    pub components: i32,
    /// Directions of the first two components; zero where nothing is held.
    pub axes: [[f64; 3]; 2],
}

impl Acting {
    /// What acts in an increment of a step, where the steps came so far; of a step that there is not, in the unloaded state.
    pub(crate) fn of(model: &Model, steps: &[StepHistory], step: usize, increment: &Increment) -> Self {
        let none = |count: usize| vec![Vector3::zeros(); count];
        let nodes = model.nodes.len();
        let [mut dead, mut following] = [[none(nodes), none(nodes)], [none(nodes), none(nodes)]];
        let mut distributed = none(model.members.len());
        for (index, each) in model.steps.get(..=step).unwrap_or_default().iter().enumerate() {
            // What a step names moves from where it was towards its target; the present step is on its way.
            let part = if index == step { increment.fraction } else { end(steps, index) };
            for (target, value) in &each.targets {
                let (list, at, axis) = match *target {
                    Target::Force(node, axis) => (&mut dead[0], node, axis),
                    Target::Moment(node, axis) => (&mut dead[1], node, axis),
                    Target::FollowerForce(node, axis) => (&mut following[0], node, axis),
                    Target::FollowerMoment(node, axis) => (&mut following[1], node, axis),
                    Target::Distributed(member, axis) => (&mut distributed, member, axis),
                    Target::Control(_) | Target::Gravity(_) => continue,
                };
                list[at][axis] = on_the_way([list[at][axis], *value], part);
            }
        }
        let turned = |node: usize| Rotation3::new(Vector3::from(increment.state.nodes[node].rotation));
        let sum = |kind: usize| {
            (0..nodes).map(|node| (dead[kind][node] + turned(node) * following[kind][node]).into()).collect()
        };
        Self {
            forces: sum(0),
            moments: sum(1),
            distributed: distributed.into_iter().map(Into::into).collect(),
            holds: holds(model, step),
        }
    }
}

/// What holds each node during a step: one that is being freed counts as free.
fn holds(model: &Model, step: usize) -> Vec<Hold> {
    let mut holds = vec![Hold::default(); model.nodes.len()];
    for support in &model.supports {
        let held = support.fixed.iter().enumerate().filter(|(_, fixed)| **fixed);
        let components = held.map(|(component, _)| 1 << component).sum();
        holds[support.node] = Hold { components, axes: [support.axes[0], support.axes[1]] };
    }
    for change in model.steps.get(..=step).unwrap_or_default().iter().flat_map(|each| &each.changes) {
        match *change {
            Change::Prescribe { node, component, .. }
            | Change::Hold { node, component }
            | Change::MoveBy { node, component, .. } => {
                if holds[node].axes == Hold::default().axes {
                    holds[node].axes = GLOBAL_AXES;
                }
                holds[node].components |= 1 << component;
            }
            Change::Free { node, component } => holds[node].components &= !(1 << component),
        }
    }
    holds
}

#[cfg(test)]
mod tests {
    use pennate_solver::structure::Support;

    use super::*;

    /// A guide in turned axes; a step that prescribes a component of another node, and one that frees it again.
    #[test]
    fn a_node_is_held_by_its_support_and_by_what_steps_prescribe_until_they_free_it() {
        let mut model = crate::fixture::model();
        let axes = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        model.supports = vec![Support { node: 0, fixed: [true, false, false, false, false, true], axes }];
        model.steps[0].changes = vec![Change::Prescribe { node: 2, component: 1, to: 3.0 }];
        model.steps[1].changes = vec![Change::Free { node: 2, component: 1 }];

        let guide = Hold { components: 33, axes: [axes[0], axes[1]] };
        assert_eq!(holds(&model, usize::MAX), [guide, Hold::default(), Hold::default()]);
        assert_eq!(holds(&model, 0)[2], Hold { components: 2, axes: GLOBAL_AXES });
        assert_eq!(holds(&model, 1)[2].components, 0);
        assert_eq!(holds(&model, 1)[0], guide);
    }

    /// Half of the second step on the way from 4 to 1 N/mm along y, and from the 3 N/mm that a step reached which stopped short.
    #[test]
    fn a_distributed_load_is_on_its_way_from_one_step_to_the_next() {
        let solution = crate::fixture::solution();
        let mut model = solution.model;
        model.steps[0].targets = vec![(Target::Distributed(0, 1), 4.0)];
        model.steps[1].targets = vec![(Target::Distributed(0, 1), 1.0)];
        let steps = &[StepHistory { fraction: 1.0, ..solution.history.steps[0].clone() }];
        let increment = &steps[0].increments[0];
        assert_eq!(increment.fraction, 0.5);
        assert_eq!(Acting::of(&model, steps, 1, increment).distributed, [[0.0, 2.5, 0.0]]);
        assert_eq!(Acting::of(&model, steps, usize::MAX, increment).distributed, [[0.0; 3]]);
        let short = &[StepHistory { fraction: 0.75, ..steps[0].clone() }];
        assert_eq!(Acting::of(&model, short, 1, increment).distributed, [[0.0, 2.0, 0.0]]);
    }
}
