//! Patterns: what the file describes once, repeated with a step of translation and rotation.
//!
//! Copy k of a name is `name-k`; the original is the first. Copy k of a later pattern is `name-1-k`, and of copy j of
//! the pattern before it `name-j-k`. Nodes of a copy that fall on nodes there are become
//! these, members and springs that fall on what they are copies of are that, and rigid bodies that come to share a node become one.

mod bodies;
mod copier;

use std::collections::{HashMap, HashSet};

use nalgebra::{Rotation3, Unit, Vector3};

use self::bodies::fuse_bodies;
use self::copier::Copier;
use super::context::Context;
use crate::error::{InputError, Span};
use crate::input::read::{Named, Number, Spanned, Written, suggest};
use crate::input::{Member, Network, Pattern, RigidBody, Spring};
use crate::unit::Kind;

/// Nodes, members, segments, springs and nodes of bodies that patterns may make: a short file takes a gigabyte at most.
const LIMIT: usize = 100_000;
/// Default of the merge tolerance over the size of the network.
const MERGE: f64 = 1e-9;

/// A network with all its patterns carried out.
pub(crate) struct Expanded {
    pub(crate) network: Network,
    /// Copies of nodes that a support or a spring to the ground holds, where the pattern copies neither.
    pub(crate) let_go: HashSet<String>,
}

/// The network with all its patterns carried out; `None` where one of them is wrong.
pub(crate) fn expand(network: &Network, cx: &mut Context) -> Option<Expanded> {
    let mut network = network.clone();
    let (mut numbers, mut let_go) = (Numbers::default(), HashSet::new());
    for pattern in network.patterns.take().unwrap_or_default() {
        repeat(&mut network, &pattern, &mut numbers, &mut let_go, cx)?;
        numbers.patterns += 1;
    }
    Some(Expanded { network, let_go })
}

/// The motion that brings the original to a copy: x ↦ R x + t.
#[derive(Clone, Copy, Debug)]
struct Motion {
    rotation: Rotation3<f64>,
    translation: Vector3<f64>,
}

/// One step of a pattern: a turn about an axis through a point, then a translation.
struct Step {
    axis: Unit<Vector3<f64>>,
    angle: f64,
    point: Vector3<f64>,
    translation: Vector3<f64>,
}

impl Step {
    fn read(pattern: &Pattern, cx: &mut Context) -> Option<Self> {
        let translation = match &pattern.translation {
            Some(list) => cx.vector(list, Kind::Length, "the translation of a pattern")?.into(),
            None => Vector3::zeros(),
        };
        let mut step = Self { axis: Vector3::z_axis(), angle: 0.0, point: Vector3::zeros(), translation };
        if let Some(rotation) = pattern.rotation.as_ref().map(|rotation| &rotation.value) {
            step.angle = cx.number(&rotation.angle, Kind::Angle)?;
            if let Some(axis) = &rotation.axis {
                step.axis = Unit::new_normalize(cx.direction(axis, "the axis of a pattern")?);
            }
            if let Some(point) = &rotation.point {
                step.point = cx.vector(point, Kind::Length, "the point of a pattern's axis")?.into();
            }
        }
        Some(step)
    }

    fn turns(&self) -> bool {
        self.angle != 0.0
    }

    /// The motions of one step, two steps and so on; angles are multiplied, so that a full turn comes back to its start.
    fn motions(&self) -> impl Iterator<Item = Motion> + '_ {
        let mut along = Vector3::zeros();
        let mut before = Rotation3::identity();
        (1..).map(move |count| {
            along += before * self.translation;
            before = Rotation3::from_axis_angle(&self.axis, self.angle * f64::from(count));
            Motion { rotation: before, translation: self.point - before * self.point + along }
        })
    }
}

/// What a pattern copies: indices in the network.
struct Selection {
    members: Vec<usize>,
    nodes: Vec<usize>,
    bodies: Vec<usize>,
    springs: Vec<usize>,
}

fn repeat(
    network: &mut Network,
    pattern: &Spanned<Pattern>,
    numbers: &mut Numbers,
    let_go: &mut HashSet<String>,
    cx: &mut Context,
) -> Option<()> {
    let step = Step::read(&pattern.value, cx)?;
    let count = cx.count(&pattern.value.count)?;
    if !step.turns() && step.translation == Vector3::zeros() {
        cx.error(
            InputError::new("a pattern neither moves nor turns its copies")
                .at(pattern.span)
                .help("add translation = [x, y, z] or rotation = { angle = 10 }"),
        );
        return None;
    }
    let places = places(network, cx)?;
    let selection = Selection::new(network, &pattern.value, cx)?;
    check_size(network, &selection, count, pattern.span, cx)?;
    let merge = match &pattern.value.merge {
        Some(merge) => cx.not_negative(merge, Kind::Length, "the merge tolerance of a pattern")?,
        None => MERGE * size(&places),
    };
    let supports = pattern.value.supports == Some(true);
    let grounded = if supports { HashSet::new() } else { grounded(network, let_go) };
    let mut copier = Copier::new(network, places, merge, (&step, pattern.span), numbers);
    let second_axes = copier.second_axes(&selection, cx)?;
    for (copy, motion) in (2..=count).zip(step.motions()) {
        copier.copy(&selection, copy, motion, &second_axes, supports, cx)?;
    }
    copier.warn(cx);
    let Copier { made, places, tie, .. } = copier;
    let_go.extend(made.into_iter().filter(|[name, _]| grounded.contains(name)).map(|[_, copy]| copy));
    fuse_bodies(network, &places, tie, cx)?;
    check_names(network, pattern.span, cx)
}

/// Nodes that the ground holds, and copies of such nodes that it does not hold any more.
fn grounded(network: &Network, let_go: &HashSet<String>) -> HashSet<String> {
    let supports = network.supports.iter().flatten().map(|support| &support.name);
    let springs = network.springs.iter().flatten().filter_map(|spring| spring.value.value.node.as_ref());
    supports.chain(springs.map(|node| &node.value)).chain(let_go).cloned().collect()
}

/// Positions of all nodes.
fn places(network: &Network, cx: &mut Context) -> Option<Vec<Vector3<f64>>> {
    let place = |named: &Named<Spanned<Vec<Number>>>| {
        cx.vector(&named.value, Kind::Length, format_args!("node '{}'", named.name)).map(Vector3::from)
    };
    network.nodes.iter().flatten().map(place).collect()
}

fn size(places: &[Vector3<f64>]) -> f64 {
    let start = places.first().copied().unwrap_or_default();
    let (low, high) = places.iter().fold((start, start), |(low, high), place| (low.inf(place), high.sup(place)));
    (high - low).norm()
}

impl Selection {
    /// The members named by the pattern with their nodes, and the bodies and springs among these; or all there is.
    fn new(network: &Network, pattern: &Pattern, cx: &mut Context) -> Option<Self> {
        let node_index: HashMap<&str, usize> =
            network.nodes.iter().flatten().enumerate().map(|(index, named)| (named.name.as_str(), index)).collect();
        let count = |length: Option<usize>| (0..length.unwrap_or(0)).collect::<Vec<_>>();
        let all = Self {
            members: count(network.members.as_ref().map(|map| map.0.len())),
            nodes: count(network.nodes.as_ref().map(|map| map.0.len())),
            bodies: count(network.rigid_bodies.as_ref().map(|map| map.0.len())),
            springs: count(network.springs.as_ref().map(|map| map.0.len())),
        };
        let Some(wanted) = &pattern.members else { return Some(all) };
        let members: Vec<&Named<Spanned<Member>>> = network.members.iter().flatten().collect();
        let paths = cx.paths.clone();
        let names = |member: &Named<Spanned<Member>>| {
            let group = member.value.value.group.as_ref().map(|group| group.value.clone());
            [Some(member.name.clone()), group, paths.get(&member.name).cloned()].into_iter().flatten()
        };
        let known: HashSet<String> = members.iter().flat_map(|member| names(member)).collect();
        if let Some(name) = wanted.value.iter().find(|name| !known.contains(&name.value)) {
            let known = members.iter().map(|member| member.name.as_str());
            cx.error(
                InputError::new(format!("a pattern repeats '{}', which is no member and no group", name.value))
                    .at(name.span)
                    .help(suggest(&name.value, known, "members")),
            );
            return None;
        }
        let wanted: HashSet<&str> = wanted.value.iter().map(|name| name.value.as_str()).collect();
        let chosen = |&index: &usize| names(members[index]).any(|name| wanted.contains(name.as_str()));
        let members_chosen: Vec<usize> = all.members.into_iter().filter(chosen).collect();
        let ends = members_chosen.iter().flat_map(|&index| members[index].value.value.ends());
        let mut nodes: HashSet<usize> = ends.filter_map(|name| node_index.get(name.value.as_str()).copied()).collect();
        let bodies: Vec<(usize, Vec<usize>)> = network
            .rigid_bodies
            .iter()
            .flatten()
            .map(|body| body_nodes(&body.value.value).filter_map(|name| node_index.get(name).copied()).collect())
            .enumerate()
            .collect();
        let touched = |body: &&(usize, Vec<usize>)| body.1.iter().any(|node| nodes.contains(node));
        let bodies: Vec<&(usize, Vec<usize>)> = bodies.iter().filter(touched).collect();
        nodes.extend(bodies.iter().flat_map(|body| &body.1));
        let inside = |name: &Spanned<String>| node_index.get(name.value.as_str()).is_some_and(|at| nodes.contains(at));
        let springs: Vec<&Named<Spanned<Spring>>> = network.springs.iter().flatten().collect();
        let springs_chosen =
            all.springs.into_iter().filter(|&index| spring_nodes(&springs[index].value.value).all(inside));
        Some(Self {
            members: members_chosen,
            bodies: bodies.iter().map(|body| body.0).collect(),
            springs: springs_chosen.collect(),
            nodes: all.nodes.into_iter().filter(|node| nodes.contains(node)).collect(),
        })
    }
}

fn body_nodes(body: &RigidBody) -> impl Iterator<Item = &str> {
    body.nodes.value.iter().chain(&body.reference).map(|name| name.value.as_str())
}

/// The node whose motion is that of a body.
fn reference(body: &RigidBody) -> Option<&str> {
    body.reference.as_ref().or(body.nodes.value.first()).map(|name| name.value.as_str())
}

fn spring_nodes(spring: &Spring) -> impl Iterator<Item = &Spanned<String>> {
    spring.node.iter().chain(spring.nodes.iter().flat_map(|nodes| &nodes.value))
}

fn check_size(network: &Network, selection: &Selection, count: usize, span: Span, cx: &mut Context) -> Option<()> {
    let members: Vec<&Named<Spanned<Member>>> = network.members.iter().flatten().collect();
    let bodies: Vec<&Named<Spanned<RigidBody>>> = network.rigid_bodies.iter().flatten().collect();
    let of_member =
        |&index: &usize| 1 + members[index].value.value.segments.as_ref().map_or(0, |list| list.value.len());
    let of_body = |&index: &usize| body_nodes(&bodies[index].value.value).count();
    let copied = selection.members.iter().map(of_member).chain(selection.bodies.iter().map(of_body));
    let one = selection.nodes.len() + selection.springs.len() + copied.sum::<usize>();
    let there = members.len() + network.nodes.as_ref().map_or(0, |map| map.0.len());
    if there.saturating_add(one.saturating_mul(count - 1)) <= LIMIT {
        return Some(());
    }
    cx.error(
        InputError::new(format!("a pattern makes more than {LIMIT} nodes, members and other parts"))
            .at(span)
            .help("ask for fewer copies"),
    );
    None
}

/// Names of copies may be taken already.
fn check_names(network: &Network, span: Span, cx: &mut Context) -> Option<()> {
    let mut fine = true;
    let nodes = network.nodes.iter().flatten().map(|named| named.name.as_str());
    let members = network.members.iter().flatten().map(|named| named.name.as_str());
    let bodies = network.rigid_bodies.iter().flatten().map(|named| named.name.as_str());
    let springs = network.springs.iter().flatten().map(|named| named.name.as_str());
    let lists: [(&str, Vec<&str>); 4] = [
        ("node", nodes.collect()),
        ("member", members.collect()),
        ("rigid body", bodies.collect()),
        ("spring", springs.collect()),
    ];
    for (what, names) in lists {
        let mut known = HashSet::new();
        if let Some(twice) = names.into_iter().find(|name| !known.insert(*name)) {
            cx.error(
                InputError::new(format!("the copies of a pattern give a second {what} '{twice}'"))
                    .at(span)
                    .help(format!("copies are called name-2, name-3 and so on; call the {what} of the file otherwise")),
            );
            fine = false;
        }
    }
    fine.then_some(())
}

/// The numbers that copies got.
#[derive(Default)]
struct Numbers {
    /// Patterns that were carried out.
    patterns: usize,
    /// How many of them gave a name a number.
    given: HashMap<String, usize>,
}

impl Numbers {
    /// Name of a copy: one number for each pattern, 1 for those that left the original alone.
    fn copied(&mut self, name: &str, copy: usize) -> String {
        // A name of the file that looks like a copy is refused once all names are there.
        let given = self.given.get(name).copied().unwrap_or(0);
        let copied = format!("{name}{}-{copy}", "-1".repeat(self.patterns.saturating_sub(given)));
        self.given.insert(copied.clone(), self.patterns + 1);
        copied
    }
}

fn bare(value: f64, span: Span) -> Number {
    Spanned { span, value: Written::Bare(value) }
}
