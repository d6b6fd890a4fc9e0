//! How the parts of a network hang together, and what is wrong with that.

use rustc_hash::{FxHashMap, FxHashSet};

use nalgebra::Vector3;
use pennate_solver::structure::{Change, Release, Support};

use super::context::Context;
use super::grid::Grid;
use super::joints::Bodies;
use crate::error::InputError;
use crate::model::{Member, Node, Spring, Step, Target};

/// So many nodes are few.
const FEW: usize = 24;
/// So many nodes at one place are told of.
const MANY: usize = 20;

/// What a node has of a rotation of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum JointRotation {
    Full,
    /// Every end there is released.
    None,
    /// Every end there is hinged about this axis.
    NoSpin([f64; 3]),
}

impl JointRotation {
    /// Whether a rotation about this axis turns nothing.
    pub(crate) fn turns_nothing(self, axis: Vector3<f64>) -> bool {
        match self {
            Self::NoSpin(spin) => axis.cross(&Vector3::from(spin)).norm() <= 1e-9 * axis.norm(),
            _ => self.lacks(axis),
        }
    }

    /// Whether nothing takes a moment about this axis.
    pub(crate) fn lacks(self, axis: Vector3<f64>) -> bool {
        match self {
            Self::Full => false,
            Self::None => axis != Vector3::zeros(),
            Self::NoSpin(spin) => axis.dot(&Vector3::from(spin)).abs() > 1e-9 * axis.norm(),
        }
    }
}

/// The parts of a network that topology is about.
pub(crate) struct Parts<'a> {
    pub(crate) nodes: &'a [Option<Node>],
    pub(crate) members: &'a [Option<Member>],
    pub(crate) springs: &'a [Spring],
    pub(crate) bodies: &'a Bodies,
    pub(crate) supports: &'a [Support],
    /// Copies of held nodes, made by patterns that do not copy what holds them.
    pub(crate) let_go: &'a [usize],
}

/// The rotation that each of so many nodes has.
pub(crate) fn rotations<'a>(
    count: usize,
    members: impl Iterator<Item = &'a Member>,
    springs: &[Spring],
    bodies: &Bodies,
) -> Vec<JointRotation> {
    let mut rotations = vec![JointRotation::None; count];
    let mut join = |node: usize, end: JointRotation| {
        rotations[node] = match (rotations[node], end) {
            (JointRotation::None, other) | (other, JointRotation::None) => other,
            (JointRotation::NoSpin(a), JointRotation::NoSpin(b))
                if Vector3::from(a).cross(&Vector3::from(b)).norm() < 1e-6 =>
            {
                JointRotation::NoSpin(a)
            }
            _ => JointRotation::Full,
        };
    };
    for member in members {
        for (node, release) in member.nodes.into_iter().zip(&member.releases) {
            join(
                node,
                match release {
                    Release::Welded => JointRotation::Full,
                    Release::Pin => JointRotation::None,
                    Release::Axes(axes) if axes.len() == 1 => JointRotation::NoSpin(axes[0]),
                    Release::Axes(_) => JointRotation::Full,
                },
            );
        }
    }
    for spring in springs {
        let engaged = spring.spring.nodes().iter().zip(spring.spring.engages()).filter(|(_, turns)| *turns);
        engaged.for_each(|(&node, _)| join(node, JointRotation::Full));
    }
    for (node, body) in bodies.of_node.iter().enumerate() {
        if body.is_some() {
            join(node, JointRotation::Full);
        }
    }
    rotations
}

/// Whether the rotation of each node stays zero, since no moment ever goes through the node: all ends there are pinned, or all but one that
/// has a rotation of its own released, and nothing acts on its rotation.
pub(crate) fn stand_still(parts: &Parts<'_>, steps: &[Step]) -> Vec<bool> {
    let count = parts.nodes.len();
    let (mut acted, mut ends) = (vec![false; count], vec![(0, false); count]);
    for member in parts.members.iter().flatten() {
        for (node, release) in member.nodes.into_iter().zip(&member.releases) {
            let (taking, welded) = &mut ends[node];
            *taking += usize::from(*release != Release::Pin);
            *welded |= *release == Release::Welded;
        }
    }
    for spring in parts.springs {
        let engaged = spring.spring.nodes().iter().zip(spring.spring.engages()).filter(|(_, turns)| *turns);
        engaged.for_each(|(&node, _)| acted[node] = true);
    }
    for support in parts.supports {
        acted[support.node] |= support.fixed[3..].contains(&true);
    }
    for step in steps {
        for change in &step.changes {
            let (node, component) = change.place();
            acted[node] |= component >= 3;
        }
        for (target, value) in &step.targets {
            if let Target::Moment(node, _) | Target::FollowerMoment(node, _) | Target::FollowerForce(node, _) = *target
            {
                acted[node] |= *value != 0.0;
            }
        }
    }
    let is_still = |node: usize| {
        let (taking, welded) = ends[node];
        taking <= 1 && !welded && !acted[node] && parts.bodies.of_node[node].is_none()
    };
    (0..count).map(is_still).collect()
}

/// Where nodes are; `None` where the definition of one is wrong.
pub(crate) type Place<'a> = dyn Fn(usize) -> Option<[f64; 3]> + 'a;

/// Nodes of so many that are at one place, though neither a spring nor a body joins them: each with the first of those before
/// it that are there; so many at most.
pub(crate) fn coincident(
    count: usize,
    place: &Place<'_>,
    springs: &[Spring],
    bodies: &Bodies,
    most: usize,
) -> Vec<(usize, usize)> {
    let tolerance = 1e-9 * size((0..count).filter_map(place));
    let mut joined: FxHashSet<(usize, usize)> = FxHashSet::default();
    for spring in springs {
        if let Some([a, b]) = spring.spring.pair() {
            joined.insert((a.min(b), a.max(b)));
        }
    }
    // A few nodes are compared with one another sooner than they are sorted.
    let few = count <= FEW;
    let mut grid = Grid::new(tolerance);
    let mut found = Vec::new();
    for index in 0..count {
        let Some(here) = place(index).map(Vector3::from) else { continue };
        let (before, near) = match few {
            true => (0..index, None),
            false => (0..0, Some(grid.near(here))),
        };
        let same = before.chain(near.into_iter().flatten()).filter(|&other| {
            let there = place(other).map_or([f64::NAN; 3], |place| place);
            let one_body = bodies.of_node[other].is_some() && bodies.of_node[other] == bodies.of_node[index];
            (Vector3::from(there) - here).norm() <= tolerance && !one_body && !joined.contains(&(other, index))
        });
        if let Some(other) = same.min() {
            // In a heap of nodes every one is near all others.
            if found.len() == most {
                break;
            }
            found.push((other, index));
        }
        if !few {
            grid.add(here, index);
        }
    }
    found
}

fn size(places: impl Iterator<Item = [f64; 3]>) -> f64 {
    let mut points = places.map(Vector3::from);
    let Some(first) = points.next() else { return 0.0 };
    let (low, high) = points.fold((first, first), |(low, high), point| (low.inf(&point), high.sup(&point)));
    (high - low).norm()
}

impl Parts<'_> {
    /// Components that supports hold.
    pub(crate) fn held(&self) -> Vec<[bool; 6]> {
        let mut held = vec![[false; 6]; self.nodes.len()];
        for support in self.supports {
            held[support.node] = support.fixed;
        }
        held
    }

    pub(crate) fn check(&self, steps: &[Step], cx: &mut Context) {
        // A part that could not be read would make other parts look loose.
        if self.members.iter().any(Option::is_none) || self.nodes.iter().any(Option::is_none) {
            return;
        }
        self.check_places(cx);
        // What hangs together does so for any values of the parameters.
        if cx.is_first() {
            self.check_lonely_nodes(steps, cx);
            self.check_supported(steps, cx);
        }
    }

    /// Two nodes at one place are most often one node written twice.
    fn check_places(&self, cx: &mut Context) {
        let place = |node: usize| self.nodes[node].as_ref().map(|node| node.position);
        for pair in coincident(self.nodes.len(), &place, self.springs, self.bodies, MANY) {
            let (Some(other), Some(node)) = (&self.nodes[pair.0], &self.nodes[pair.1]) else { continue };
            cx.error(
                InputError::new(format!("nodes '{}' and '{}' are at one place", other.name, node.name))
                    .at(node.span)
                    .label(format!("same place as '{}'", other.name))
                    .help("use one node for both, or join them by a spring or a rigid body"),
            );
        }
    }

    /// A node in no member, spring or body moves with nothing.
    fn check_lonely_nodes(&self, steps: &[Step], cx: &mut Context) {
        let mut used = vec![false; self.nodes.len()];
        for member in self.members.iter().flatten() {
            member.nodes.into_iter().for_each(|node| used[node] = true);
        }
        for spring in self.springs {
            spring.spring.nodes().iter().for_each(|&node| used[node] = true);
        }
        for (node, body) in self.bodies.of_node.iter().enumerate() {
            used[node] |= body.is_some();
        }
        let loaded: FxHashSet<usize> = steps.iter().flat_map(loaded_nodes).collect();
        let held = self.held();
        for (index, node) in self.nodes.iter().enumerate() {
            let Some(node) = node else { continue };
            if used[index] {
                continue;
            }
            let free = held[index][..3].contains(&false);
            let finding = |what: &str| {
                InputError::new(format!("node '{}' is in no member, spring or body{what}", node.name)).at(node.span)
            };
            if loaded.contains(&index) {
                cx.error(finding(", but a step loads or moves it").label("loaded").help("connect it, or leave it out"));
            } else if free {
                cx.error(
                    finding(" and nothing holds it").label("free").help("connect it, support it, or leave it out"),
                );
            } else {
                cx.warn(finding("").label("has no effect").help("leave it out"));
            }
        }
    }

    /// A part of the network that nothing holds flies away.
    fn check_supported(&self, steps: &[Step], cx: &mut Context) {
        let mut sets = Sets::new(self.nodes.len());
        for member in self.members.iter().flatten() {
            sets.join(member.nodes[0], member.nodes[1]);
        }
        let mut holders: Vec<usize> = self.supports.iter().map(|support| support.node).collect();
        for spring in self.springs {
            match spring.spring.pair() {
                Some([a, b]) => sets.join(a, b),
                None => holders.extend(spring.spring.nodes()),
            }
        }
        for body in &self.bodies.bodies {
            body.nodes.iter().for_each(|&node| sets.join(body.reference, node));
        }
        holders.extend(steps.first().into_iter().flat_map(|step| &step.changes).filter_map(|change| match change {
            Change::Prescribe { node, .. } | Change::Hold { node, .. } | Change::MoveBy { node, .. } => Some(*node),
            Change::Free { .. } => None,
        }));
        let held: FxHashSet<usize> = holders.into_iter().map(|node| sets.root(node)).collect();
        let let_go: FxHashMap<usize, usize> = self.let_go.iter().rev().map(|&node| (sets.root(node), node)).collect();
        let mut reported = FxHashSet::default();
        for member in self.members.iter().flatten() {
            let root = sets.root(member.nodes[0]);
            if held.contains(&root) || !reported.insert(root) {
                continue;
            }
            let help = "support one of its nodes under [supports], or join it to what is supported";
            let copy = let_go.get(&root).and_then(|&node| self.nodes[node].as_ref());
            let help = copy.map_or_else(
                || help.to_owned(),
                |copy| {
                    format!(
                        "the pattern that made node '{}' did not copy what holds its original: write supports = true in it, or {help}",
                        copy.name
                    )
                },
            );
            cx.error(
                InputError::new(format!(
                    "member '{}' hangs on no support, nor does anything it is joined to",
                    member.name
                ))
                .at(member.span)
                .label("held by nothing")
                .help(help),
            );
        }
    }
}

fn loaded_nodes(step: &Step) -> impl Iterator<Item = usize> + '_ {
    let targets = step.targets.iter().filter_map(|(target, _)| match target {
        Target::Force(node, _)
        | Target::Moment(node, _)
        | Target::FollowerForce(node, _)
        | Target::FollowerMoment(node, _) => Some(*node),
        _ => None,
    });
    let changes = step.changes.iter().map(|change| match change {
        Change::Prescribe { node, .. }
        | Change::Hold { node, .. }
        | Change::MoveBy { node, .. }
        | Change::Free { node, .. } => *node,
    });
    targets.chain(changes)
}

/// Disjoint sets of nodes.
struct Sets(Vec<usize>);

impl Sets {
    fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    fn root(&mut self, mut node: usize) -> usize {
        while self.0[node] != node {
            self.0[node] = self.0[self.0[node]];
            node = self.0[node];
        }
        node
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a] = b;
    }
}
