//! Patterns: what the file describes once, repeated with a step of translation and rotation.
//!
//! Copy k of a name is `name-k`; the original is the first. Copy k of a later pattern is `name-1-k`, and of copy j of
//! the pattern before it `name-j-k`. Nodes of a copy that fall on nodes there are become
//! these, members and springs that fall on what they are copies of are that, and rigid bodies that come to share a node become one.

use std::collections::{HashMap, HashSet};

use nalgebra::{Rotation3, Unit, Vector3};

use super::context::Context;
use super::curve;
use super::grid::Grid;
use crate::error::{InputError, Span};
use crate::input::read::{Named, Number, Spanned, Written, suggest};
use crate::input::{
    Arc, EndRelease, Fix, Member, Network, Pattern, Releases, RigidBody, Spring, SpringStiffness, Support, SupportWord,
    TurnedSupport,
};
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
    let there = There::of(network);
    let mut copier = Copier {
        network,
        roots: (0..places.len()).collect(),
        tie: MERGE * size(&places),
        places,
        grid: Grid::new(merge),
        merge,
        step: &step,
        span: pattern.span,
        numbers,
        held: Held::default(),
        made: Vec::new(),
        there,
        overlaid: Vec::new(),
    };
    for index in 0..copier.places.len() {
        copier.grid.add(copier.places[index], index);
    }
    let second_axes = copier.second_axes(&selection, cx)?;
    for (copy, motion) in (2..=count).zip(step.motions()) {
        copier.copy(&selection, copy, motion, &second_axes, supports, cx)?;
    }
    copier.warn(cx);
    let_go.extend(copier.made.into_iter().filter(|[name, _]| grounded.contains(name)).map(|[_, copy]| copy));
    fuse_bodies(network, cx)?;
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

/// Makes copies and keeps what they need to know of each other.
struct Copier<'a> {
    network: &'a mut Network,
    /// Positions of the nodes of the network.
    places: Vec<Vector3<f64>>,
    /// What each node is a copy of: its index, or its own.
    roots: Vec<usize>,
    grid: Grid,
    /// Nodes nearer than this are one.
    merge: f64,
    /// Distances that differ by less are equal.
    tie: f64,
    step: &'a Step,
    span: Span,
    numbers: &'a mut Numbers,
    held: Held,
    /// Names of nodes and of their copies, but for copies that became a node that was there.
    made: Vec<[String; 2]>,
    there: There,
    /// Copies of members that lie on other members, and these.
    overlaid: Vec<[String; 2]>,
}

/// What there is already, to be found by its nodes.
#[derive(Default)]
struct There {
    members: HashMap<[String; 2], Vec<Laid>>,
    /// Springs by what they are copies of, with their nodes in order.
    springs: HashSet<(usize, Vec<String>)>,
    /// Bodies by what they are copies of, with their references.
    bodies: HashSet<(usize, String)>,
}

/// A member between two nodes.
struct Laid {
    index: usize,
    /// What it is a copy of: its index, or its own.
    root: usize,
    /// Number of its copy, and how that is turned.
    copy: usize,
    rotation: Rotation3<f64>,
}

impl There {
    fn of(network: &Network) -> Self {
        let mut there = Self::default();
        for (index, member) in network.members.iter().flatten().enumerate() {
            if let Some(ends) = ends(&member.value.value) {
                let laid = Laid { index, root: index, copy: 1, rotation: Rotation3::identity() };
                there.members.entry(ends).or_default().push(laid);
            }
        }
        let springs = network.springs.iter().flatten().enumerate();
        there.springs = springs.map(|(index, spring)| (index, names_of(&spring.value.value))).collect();
        let bodies = network.rigid_bodies.iter().flatten().enumerate();
        let bodies = bodies.filter_map(|(index, body)| Some((index, reference(&body.value.value)?.to_owned())));
        there.bodies = bodies.collect();
        there
    }
}

/// Names of the nodes of a member, in alphabetical order.
fn ends(member: &Member) -> Option<[String; 2]> {
    let [start, end] = member.ends() else { return None };
    let mut ends = [start.value.clone(), end.value.clone()];
    ends.sort();
    Some(ends)
}

/// Names of the nodes of a spring, in alphabetical order.
fn names_of(spring: &Spring) -> Vec<String> {
    let mut names: Vec<String> = spring_nodes(spring).map(|name| name.value.clone()).collect();
    names.sort();
    names
}

/// The node whose motion is that of a body.
fn reference(body: &RigidBody) -> Option<&str> {
    body.reference.as_ref().or(body.nodes.value.first()).map(|name| name.value.as_str())
}

/// Supports that are there, as far as they were looked at: names of their nodes, and which of them are repeated.
#[derive(Default)]
struct Held {
    names: HashSet<String>,
    repeated: Vec<usize>,
    seen: usize,
}

impl Copier<'_> {
    fn copy(
        &mut self,
        selection: &Selection,
        copy: usize,
        motion: Motion,
        second_axes: &[Vector3<f64>],
        supports: bool,
        cx: &mut Context,
    ) -> Option<()> {
        let renamed = self.nodes(selection, copy, motion, cx)?;
        for (at, &index) in selection.members.iter().enumerate() {
            let original = self.network.members.as_ref()?.0[index].clone();
            let moved = moved(original, motion, second_axes.get(at), &renamed, cx)?;
            let new =
                Laid { index: self.network.members.as_ref()?.0.len(), root: index, copy, rotation: motion.rotation };
            if self.is_there(&moved, &new, cx)? {
                continue;
            }
            let member = self.named(moved, copy, cx);
            if let Some(ends) = ends(&member.value.value) {
                self.there.members.entry(ends).or_default().push(new);
            }
            self.network.members.as_mut()?.0.push(member);
        }
        for &index in &selection.bodies {
            let mut body = self.network.rigid_bodies.as_ref()?.0[index].clone();
            body.name = self.numbers.copied(&body.name, copy);
            body.value.value.nodes.value.iter_mut().for_each(|name| rename(name, &renamed));
            body.value.value.reference.iter_mut().for_each(|name| rename(name, &renamed));
            // A copy that has its reference in common with what it is a copy of is that, and its mass is there.
            let own = reference(&body.value.value)?.to_owned();
            if !self.there.bodies.insert((index, own)) {
                body.value.value.mass = None;
            }
            self.network.rigid_bodies.as_mut()?.0.push(body);
        }
        for &index in &selection.springs {
            let mut spring = self.network.springs.as_ref()?.0[index].clone();
            let data = &mut spring.value.value;
            // A spring to the ground is a support.
            if data.node.is_some() && !supports {
                continue;
            }
            if matches!(data.stiffness.value, SpringStiffness::Components(_)) && self.step.turns() {
                cx.error(
                    InputError::new(format!("a pattern turns the spring '{}', whose axes are global", spring.name))
                        .at(spring.span)
                        .help("repeat it by translation alone, or write the springs of the copies yourself"),
                );
                return None;
            }
            data.node.iter_mut().for_each(|name| rename(name, &renamed));
            data.nodes.iter_mut().flat_map(|nodes| &mut nodes.value).for_each(|name| rename(name, &renamed));
            if !self.there.springs.insert((index, names_of(data))) {
                continue;
            }
            spring.name = self.numbers.copied(&spring.name, copy);
            self.network.springs.as_mut()?.0.push(spring);
        }
        if supports { self.supports(&renamed, motion, cx) } else { Some(()) }
    }

    /// Adds the nodes of a copy that are not there yet; returns all of its names by those of the original.
    ///
    /// A node becomes the nearest one that was there before the copy. Of several at one place, as those of a hinge, that is itself, another
    /// copy of what it is a copy of, or one that no other node of the copy became.
    fn nodes(
        &mut self,
        selection: &Selection,
        copy: usize,
        motion: Motion,
        cx: &mut Context,
    ) -> Option<HashMap<String, String>> {
        let mut renamed = HashMap::new();
        let Some(nodes) = self.network.nodes.as_mut() else { return Some(renamed) };
        let before = nodes.0.len();
        let mut taken: HashMap<usize, usize> = HashMap::new();
        for &index in &selection.nodes {
            let place = motion.rotation * self.places[index] + motion.translation;
            let original = &nodes.0[index];
            let distance = |node: usize| (self.places[node] - place).norm();
            let near = || self.grid.near(place).filter(|&node| node < before && distance(node) <= self.merge);
            let nearest = near().map(distance).fold(f64::INFINITY, f64::min);
            let strange = |node: usize| match node {
                _ if node == index => 0,
                _ if self.roots[node] == self.roots[index] => 1,
                _ => 2 + usize::from(taken.contains_key(&node)),
            };
            let nearest = near().filter(|&node| distance(node) <= nearest + self.tie);
            let there = nearest.min_by_key(|&node| (strange(node), node));
            if let Some(other) = there.and_then(|there| taken.insert(there, index)) {
                let [one, two, on] = [other, index, there.unwrap_or_default()].map(|node| &nodes.0[node].name);
                cx.error(
                    InputError::new(format!(
                        "nodes '{one}' and '{two}' of a pattern both fall on node '{on}' in copy {copy}"
                    ))
                    .at(self.span)
                    .help("give the pattern a smaller merge, or repeat some members alone, with members = [...]"),
                );
                return None;
            }
            let name = there.map_or_else(|| self.numbers.copied(&original.name, copy), |at| nodes.0[at].name.clone());
            renamed.insert(original.name.clone(), name.clone());
            if there.is_none() {
                self.made.push([original.name.clone(), name.clone()]);
                let span = original.value.span;
                let coordinates = place.iter().map(|&x| bare(x, span)).collect();
                let node = Named { name, span: original.span, value: Spanned { span, value: coordinates } };
                self.grid.add(place, nodes.0.len());
                self.places.push(place);
                self.roots.push(self.roots[index]);
                nodes.0.push(node);
            }
        }
        Some(renamed)
    }

    /// Whether a copy of a member lies on what it is a copy of; notes it where it lies on another member.
    fn is_there(&mut self, member: &Named<Spanned<Member>>, new: &Laid, cx: &mut Context) -> Option<bool> {
        let Some(others) = ends(&member.value.value).and_then(|ends| self.there.members.get(&ends)) else {
            return Some(false);
        };
        let data = &member.value.value;
        // What is alike from both ends may be turned end for end.
        let alike = data.release.is_none() && data.segments.is_none();
        let mut on = None;
        for other in others {
            let laid = &self.network.members.as_ref()?.0[other.index];
            let same_order = data.ends()[0].value == laid.value.value.ends()[0].value;
            // What is straight has one way between its ends; what is curved otherwise than through a point goes with its axes.
            let same = match (course(member, cx)?, course(laid, cx)?) {
                (Course::Straight, Course::Straight) => true,
                (Course::Through(a), Course::Through(b)) => (a - b).norm() <= self.merge.max(self.tie),
                (Course::Other, Course::Other) => {
                    other.root == new.root && same_order && (new.rotation.inverse() * other.rotation).angle() < 1e-9
                }
                _ => false,
            };
            if same && other.root == new.root && (same_order || alike) {
                return Some(true);
            }
            if same && other.copy != new.copy {
                on = on.or(Some(laid.name.clone()));
            }
        }
        self.overlaid.extend(on.map(|on| [member.name.clone(), on]));
        Some(false)
    }

    /// Warns of copies that lie on other members.
    fn warn(&self, cx: &mut Context) {
        let Some([member, on]) = self.overlaid.first() else { return };
        let more = match self.overlaid.len() - 1 {
            0 => String::new(),
            more => format!(", and so do {more} more"),
        };
        cx.warn(
            InputError::new(format!(
                "a copy of member '{member}' lies on member '{on}', between the same nodes{more}: both count"
            ))
            .at(self.span)
            .help("leave one of them out, with members = [...], unless two are meant"),
        );
    }

    /// A copy of a member under its name.
    fn named(&mut self, mut member: Named<Spanned<Member>>, copy: usize, cx: &mut Context) -> Named<Spanned<Member>> {
        let copied = self.numbers.copied(&member.name, copy);
        if let Some(path) = cx.paths.get(&member.name).cloned() {
            cx.paths.insert(copied.clone(), path);
        }
        member.name = copied;
        member
    }

    /// Axes 2 of the members that a turning pattern copies: their default is global and would not turn with the copy.
    fn second_axes(&self, selection: &Selection, cx: &mut Context) -> Option<Vec<Vector3<f64>>> {
        if !self.step.turns() {
            return Some(Vec::new());
        }
        let names = self.network.nodes.iter().flatten().map(|named| named.name.as_str());
        let places: HashMap<&str, Vector3<f64>> = names.zip(self.places.iter().copied()).collect();
        let members = &self.network.members.as_ref()?.0;
        selection.members.iter().map(|&index| second_axis(&members[index], &places, cx)).collect()
    }
    /// Copies the supports of nodes, unless the copy of the node has one already.
    fn supports(&mut self, renamed: &HashMap<String, String>, motion: Motion, cx: &mut Context) -> Option<()> {
        let Some(supports) = self.network.supports.as_mut() else { return Some(()) };
        let held = &mut self.held;
        for (index, named) in supports.iter().enumerate().skip(held.seen) {
            held.names.insert(named.name.clone());
            if renamed.contains_key(&named.name) {
                held.repeated.push(index);
            }
        }
        held.seen = supports.0.len();
        for &index in &held.repeated {
            let name = &renamed[&supports.0[index].name];
            if !held.names.insert(name.clone()) {
                continue;
            }
            let mut named = supports.0[index].clone();
            named.name.clone_from(name);
            if self.step.turns() {
                named.value.value = turned(&named, motion, cx)?;
            }
            supports.0.push(named);
        }
        Some(())
    }
}

/// A member of a copy, under the name of the original.
fn moved(
    mut member: Named<Spanned<Member>>,
    motion: Motion,
    second_axis: Option<&Vector3<f64>>,
    renamed: &HashMap<String, String>,
    cx: &mut Context,
) -> Option<Named<Spanned<Member>>> {
    let data = &mut member.value.value;
    // Without a turn there are no second axes, and nothing to do.
    if let Some(second) = second_axis {
        let owner = format!("member '{}'", member.name);
        let turn = |list: &mut Spanned<Vec<Number>>, cx: &mut Context| {
            let direction = cx.direction(list, format_args!("a direction of {owner}"))?;
            list.value = (motion.rotation * direction).iter().map(|&x| bare(x, list.span)).collect();
            Some(())
        };
        match &mut data.orientation {
            Some(orientation) => turn(orientation, cx)?,
            None => {
                let turned = (motion.rotation * second).iter().map(|&x| bare(x, member.span)).collect();
                data.orientation = Some(Spanned { span: member.span, value: turned });
            }
        }
        if let Some(tangent) = &mut data.tangent {
            turn(tangent, cx)?;
        }
        if let Some(Spanned { value: Releases { start, end }, .. }) = &mut data.release {
            for release in [start, end].into_iter().flatten() {
                if let EndRelease::Hinge(hinge) = &mut release.value {
                    turn(&mut hinge.hinge, cx)?;
                }
            }
        }
    }
    if let Some((point, span)) = data.through() {
        let point = Spanned { span, value: point.to_vec() };
        let place =
            Vector3::from(cx.vector(&point, Kind::Length, format_args!("the arc of member '{}'", member.name))?);
        let moved = motion.rotation * place + motion.translation;
        let moved = moved.iter().map(|&x| bare(x, span)).collect();
        data.arc = Some(Spanned { span, value: Arc::Through(moved) });
    }
    data.nodes.iter_mut().flat_map(|nodes| &mut nodes.value).for_each(|name| rename(name, renamed));
    Some(member)
}

/// The way of a member between its ends.
enum Course {
    Straight,
    /// A circle through a point.
    Through(Vector3<f64>),
    /// What goes with the axes of the member.
    Other,
}

fn course(member: &Named<Spanned<Member>>, cx: &mut Context) -> Option<Course> {
    let data = &member.value.value;
    if let Some((point, span)) = data.through() {
        let point = Spanned { span, value: point.to_vec() };
        let owner = format_args!("the arc of member '{}'", member.name);
        return Some(Course::Through(Vector3::from(cx.vector(&point, Kind::Length, owner)?)));
    }
    let is_straight = data.arc.is_none() && data.tangent.is_none() && data.initial_curvature.is_none();
    Some(if is_straight { Course::Straight } else { Course::Other })
}

/// Axis 2 at the start of a member that leaves it to the default.
fn second_axis(
    member: &Named<Spanned<Member>>,
    places: &HashMap<&str, Vector3<f64>>,
    cx: &mut Context,
) -> Option<Vector3<f64>> {
    let (data, owner) = (&member.value.value, format!("member '{}'", member.name));
    let end = |index: usize| places.get(data.ends().get(index)?.value.as_str()).copied();
    let tangent = match (&data.tangent, data.through(), end(0), end(1)) {
        (Some(tangent), ..) => Some(cx.direction(tangent, format_args!("the tangent of {owner}"))?),
        (None, Some((point, span)), Some(start), Some(end)) => {
            let point = Spanned { span, value: point.to_vec() };
            let point = cx.vector(&point, Kind::Length, format_args!("the arc of {owner}"))?.into();
            curve::arc(start, point, end).map(|arc| arc.tangent)
        }
        (None, None, Some(start), Some(end)) => (end - start).try_normalize(0.0),
        _ => None,
    };
    let frame = tangent.and_then(|tangent| curve::frame(tangent, None));
    if frame.is_none() {
        cx.error(
            InputError::new(format!("a pattern cannot turn {owner}, which has no direction"))
                .at(member.span)
                .help("name two nodes at different places; an arc needs a third one beside their line"),
        );
    }
    Some(frame?.column(1).into_owned())
}

/// Makes one body of those that share nodes; their masses add.
fn fuse_bodies(network: &mut Network, cx: &mut Context) -> Option<()> {
    if network.rigid_bodies.is_none() {
        return Some(());
    }
    let places = places(network, cx)?;
    let tie = MERGE * size(&places);
    let names = network.nodes.iter().flatten().map(|named| named.name.clone());
    let places: HashMap<String, Vector3<f64>> = names.zip(places).collect();
    let Some(bodies) = network.rigid_bodies.as_mut() else { return Some(()) };
    // The earliest body of those that each shares nodes with, itself or one nearer to it.
    let mut earlier: Vec<usize> = (0..bodies.0.len()).collect();
    let mut owner: HashMap<&str, usize> = HashMap::new();
    for (index, body) in bodies.iter().enumerate() {
        for name in body_nodes(&body.value.value) {
            let other = *owner.entry(name).or_insert(index);
            let [a, b] = [other, index].map(|body| first(&mut earlier, body));
            earlier[a.max(b)] = a.min(b);
        }
    }
    let mut kept: Vec<Named<Spanned<RigidBody>>> = Vec::new();
    // Where the earliest ones are among those kept, and the nodes of those that others were added to.
    let mut place = HashMap::new();
    let mut known: HashMap<usize, HashSet<String>> = HashMap::new();
    for (index, body) in std::mem::take(&mut bodies.0).into_iter().enumerate() {
        let keeper = first(&mut earlier, index);
        if keeper == index {
            place.insert(index, kept.len());
            kept.push(body);
            continue;
        }
        let keeping = &mut kept[place[&keeper]];
        let at = |body: &RigidBody| reference(body).and_then(|name| places.get(name).copied());
        let apart = match (at(&body.value.value), at(&keeping.value.value)) {
            (Some(a), Some(b)) => (a - b).norm() > tie,
            _ => false,
        };
        if body.value.value.mass.is_some() && apart {
            cx.error(
                InputError::new(format!(
                    "bodies '{}' and '{}' share a node and become one, but their references, where masses are, lie apart",
                    keeping.name, body.name
                ))
                .at(body.span)
                .help("give them one reference, or write one body, with the mass of all at its centre"),
            );
            return None;
        }
        let (body, into) = (body.value.value, &mut keeping.value.value);
        let known = known.entry(keeper).or_insert_with(|| body_nodes(into).map(str::to_owned).collect());
        let names = body.nodes.value.into_iter().chain(body.reference);
        into.nodes.value.extend(names.filter(|name| known.insert(name.value.clone())));
        into.mass = match (into.mass.take(), body.mass) {
            (Some(a), Some(b)) => {
                let sum = cx.number(&a, Kind::Mass)? + cx.number(&b, Kind::Mass)?;
                Some(bare(sum, a.span))
            }
            (a, b) => a.or(b),
        };
    }
    bodies.0 = kept;
    Some(())
}

/// The earliest body of those that are one; the way there is shortened for the next time.
fn first(earlier: &mut [usize], mut body: usize) -> usize {
    while earlier[body] != body {
        earlier[body] = earlier[earlier[body]];
        body = earlier[body];
    }
    body
}

/// A support in the axes of a copy.
fn turned(named: &Named<Spanned<Support>>, motion: Motion, cx: &mut Context) -> Option<Support> {
    let (fix, x_axis) = match &named.value.value {
        Support::Fix(Fix::Word(word @ (SupportWord::Clamped | SupportWord::Pinned))) => {
            return Some(Support::Fix(Fix::Word(*word)));
        }
        Support::Fix(fix) => (fix.clone(), Vector3::x()),
        Support::Turned(support) => {
            let direction = match &support.x_axis {
                Some(list) => cx.direction(list, "the x axis of a support")?,
                None => Vector3::x(),
            };
            (support.fix.clone(), direction)
        }
    };
    if (motion.rotation * Vector3::z() - Vector3::z()).norm() > 1e-12 {
        cx.error(
            InputError::new(format!("a pattern tilts the support of node '{}', whose z axis is global", named.name))
                .at(named.value.span)
                .help("write the supports of the copies yourself, or turn about z"),
        );
        return None;
    }
    let turned = (motion.rotation * x_axis).iter().map(|&x| bare(x, named.value.span)).collect();
    let x_axis = Some(Spanned { span: named.value.span, value: turned });
    Some(Support::Turned(TurnedSupport { fix, x_axis }))
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

fn rename(name: &mut Spanned<String>, renamed: &HashMap<String, String>) {
    if let Some(new) = renamed.get(&name.value) {
        name.value.clone_from(new);
    }
}

fn bare(value: f64, span: Span) -> Number {
    Spanned { span, value: Written::Bare(value) }
}
