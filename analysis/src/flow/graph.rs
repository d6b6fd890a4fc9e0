//! The graph of a mechanism: joints by their distance from the input, and the paths to the outputs.

use std::collections::VecDeque;

use pennate_models::Model;
use pennate_models::model::LoadFlow;
use pennate_solver::structure::Dimension;
use pennate_solver::structure::NodeId;

/// Paths that are followed at most; a mechanism that a person draws has a few.
pub(super) const PATHS: usize = 10_000;

/// A member as an edge between two joints.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// Joints of its start and end.
    pub joints: [usize; 2],
    /// Whether the ground holds one of them: the edge lies on no path.
    pub grounded: bool,
    /// Whether the flow goes from its start to its end.
    pub forward: bool,
}

/// Joints, members and paths of a mechanism.
#[derive(Clone, Debug)]
pub struct Graph {
    /// The joint of every node: nodes of a rigid body share one.
    pub joints: Vec<usize>,
    /// Members between an input and a joint at least; `None` where no member leads there.
    pub depth: Vec<Option<usize>>,
    /// The members of the mechanism.
    pub edges: Vec<Edge>,
    /// Members from an input to the first output on the way, in order.
    pub paths: Vec<Vec<usize>>,
    grounded: Vec<bool>,
}

impl Graph {
    pub(super) fn new(base: &Model, request: &LoadFlow) -> Self {
        let mut joints: Vec<usize> = (0..base.nodes.len()).collect();
        for body in &base.bodies {
            body.nodes.iter().for_each(|&node| joints[node] = body.reference);
        }
        let components = if base.dimension == Dimension::Plane { 2 } else { 3 };
        let mut grounded = vec![false; base.nodes.len()];
        for support in &base.supports {
            let is_input = request.inputs.iter().any(|input| input.node == support.node);
            if !is_input && support.fixed[..components].iter().all(|&held| held) {
                grounded[joints[support.node]] = true;
            }
        }
        let edges: Vec<Edge> = base
            .members
            .iter()
            .map(|member| {
                let ends = member.nodes.map(|node| joints[node]);
                Edge { joints: ends, grounded: ends.iter().any(|&end| grounded[end]), forward: true }
            })
            .collect();
        let mut graph = Self { depth: vec![None; joints.len()], joints, edges, paths: Vec::new(), grounded };
        graph.measure(request);
        graph
    }

    /// Whether the ground holds a node.
    pub(super) fn is_grounded(&self, node: NodeId) -> bool {
        self.grounded[self.joints[node]]
    }

    /// Breadth first from the inputs.
    fn measure(&mut self, request: &LoadFlow) {
        let mut queue = VecDeque::new();
        for input in &request.inputs {
            let joint = self.joints[input.node];
            self.depth[joint] = Some(0);
            queue.push_back((joint, 0));
        }
        while let Some((joint, depth)) = queue.pop_front() {
            for (_, next) in self.neighbours(joint) {
                if self.depth[next].is_none() {
                    self.depth[next] = Some(depth + 1);
                    queue.push_back((next, depth + 1));
                }
            }
        }
        for edge in &mut self.edges {
            let [start, end] = edge.joints.map(|joint| self.depth[joint].unwrap_or(usize::MAX));
            edge.forward = start <= end;
        }
    }

    /// Members that carry the flow at a joint, and the joints at their other ends.
    fn neighbours(&self, joint: usize) -> Vec<(usize, usize)> {
        let at = |(index, edge): (usize, &Edge)| match edge.joints {
            _ if edge.grounded => None,
            [start, end] if start == joint => Some((index, end)),
            [start, end] if end == joint => Some((index, start)),
            _ => None,
        };
        self.edges.iter().enumerate().filter_map(at).collect()
    }

    /// The same with the paths from the inputs to the outputs, and members seen in the direction of the first path through them.
    ///
    /// # Errors
    /// More than [`PATHS`] of them.
    pub(super) fn with_paths(mut self, request: &LoadFlow) -> Result<Self, ()> {
        let outputs: Vec<usize> = request.outputs.iter().map(|&node| self.joints[node]).collect();
        let mut stack: Vec<(Vec<usize>, Vec<usize>)> =
            request.inputs.iter().rev().map(|input| (vec![self.joints[input.node]], Vec::new())).collect();
        let mut visited = 0;
        while let Some((joints, members)) = stack.pop() {
            let Some(&last) = joints.last() else { continue };
            if outputs.contains(&last) {
                self.paths.push(members);
                continue;
            }
            visited += 1;
            if visited > 100 * PATHS || self.paths.len() > PATHS {
                return Err(());
            }
            for (member, next) in self.neighbours(last).into_iter().rev() {
                if !joints.contains(&next) {
                    let mut longer = (joints.clone(), members.clone());
                    longer.0.push(next);
                    longer.1.push(member);
                    stack.push(longer);
                }
            }
        }
        let mut known = vec![false; self.edges.len()];
        for path in &self.paths {
            let mut from = usize::MAX;
            for (k, &member) in path.iter().enumerate() {
                let [start, end] = self.edges[member].joints;
                let forward = match (k, path.get(1)) {
                    (0, Some(&next)) => self.edges[next].joints.contains(&end),
                    (0, None) => outputs.contains(&end),
                    _ => start == from,
                };
                from = if forward { end } else { start };
                if !std::mem::replace(&mut known[member], true) {
                    self.edges[member].forward = forward;
                }
            }
        }
        Ok(self)
    }
}

/// What becomes of the members at one distance from the input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Level {
    /// Counted from one: the so many-th member of a path.
    pub number: usize,
    /// Members that are at this place of a path and not nearer to the input on another.
    pub members: Vec<usize>,
    /// What is done.
    pub decision: Decision,
}

/// What is done at a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// All of its members become muscles.
    Replace,
    /// None of them may; the next level is looked at.
    PassOver,
    /// Some may and some may not.
    Stop,
}

/// Levels of all paths at once, from the input on, and the members that end it: those of a mixed level that may not be replaced.
pub fn levels(paths: &[Vec<usize>], fits: &dyn Fn(usize) -> bool) -> (Vec<Level>, Option<Vec<usize>>) {
    let mut done: Vec<usize> = Vec::new();
    let mut levels = Vec::new();
    for k in 0..paths.iter().map(Vec::len).max().unwrap_or(0) {
        let mut here: Vec<usize> = paths.iter().filter_map(|path| path.get(k).copied()).collect();
        here.sort_unstable();
        here.dedup();
        here.retain(|member| !done.contains(member));
        if here.is_empty() {
            continue;
        }
        let stay: Vec<usize> = here.iter().copied().filter(|&member| !fits(member)).collect();
        let decision = match stay.len() {
            0 => Decision::Replace,
            count if count == here.len() => Decision::PassOver,
            _ => Decision::Stop,
        };
        done.extend(&here);
        levels.push(Level { number: k + 1, members: here, decision });
        if decision == Decision::Stop {
            return (levels, Some(stay));
        }
    }
    (levels, None)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four paths over three levels, the last with two members in compression: five members are replaced, then it ends.
    #[test]
    fn a_level_of_both_senses_ends_the_replacement() {
        let one_four_four = (1..5).map(|k| vec![0, k, k + 4]).collect::<Vec<_>>();
        let two_three_four = vec![vec![0, 2, 5], vec![0, 3, 6], vec![1, 4, 7], vec![1, 4, 8]];
        for (paths, pressed) in [(one_four_four, [6, 8]), (two_three_four, [6, 8])] {
            let (levels, stay) = levels(&paths, &|member| !pressed.contains(&member));
            let replaced = levels.iter().filter(|level| level.decision == Decision::Replace);
            assert_eq!(replaced.map(|level| level.members.len()).sum::<usize>(), 5);
            assert_eq!(levels.last().map(|level| (level.number, level.decision)), Some((3, Decision::Stop)));
            assert_eq!(stay.as_deref(), Some(pressed.as_slice()));
        }
    }

    /// A level without a member that fits is passed over; one that does not fit beside one that does is not.
    #[test]
    fn a_level_in_compression_is_passed_over() {
        let (levels, stay) = levels(&[vec![0, 1, 2]], &|member| member != 1);
        let decisions: Vec<Decision> = levels.iter().map(|level| level.decision).collect();
        assert_eq!((decisions, stay), (vec![Decision::Replace, Decision::PassOver, Decision::Replace], None));
    }
}
