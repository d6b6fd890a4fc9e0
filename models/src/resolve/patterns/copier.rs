//! Copies of nodes, members, bodies, springs and supports, and what there is already where they fall.

use std::collections::{HashMap, HashSet};

use nalgebra::{Rotation3, Vector3};

use super::super::context::Context;
use super::super::curve;
use super::super::grid::Grid;
use super::{MERGE, Motion, Numbers, Selection, Step, bare, reference, size, spring_nodes};
use crate::error::{InputError, Span};
use crate::input::read::{Named, Number, Spanned};
use crate::input::{
    Arc, EndRelease, Fix, Member, Network, Releases, Spring, SpringStiffness, Support, SupportWord, TurnedSupport,
};
use crate::unit::Kind;

/// Makes copies and keeps what they need to know of each other.
pub(super) struct Copier<'a> {
    network: &'a mut Network,
    /// Positions of the nodes of the network.
    pub(super) places: Vec<Vector3<f64>>,
    /// What each node is a copy of: its index, or its own.
    roots: Vec<usize>,
    grid: Grid,
    /// Nodes nearer than this are one.
    merge: f64,
    /// Distances that differ by less are equal.
    pub(super) tie: f64,
    step: &'a Step,
    span: Span,
    numbers: &'a mut Numbers,
    held: Held,
    /// Names of nodes and of their copies, but for copies that became a node that was there.
    pub(super) made: Vec<[String; 2]>,
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

/// Supports that are there, as far as they were looked at: names of their nodes, and which of them are repeated.
#[derive(Default)]
struct Held {
    names: HashSet<String>,
    repeated: Vec<usize>,
    seen: usize,
}

impl<'a> Copier<'a> {
    /// Copies of a network whose nodes are at these places, and nearer to each other than `merge` are one.
    pub(super) fn new(
        network: &'a mut Network,
        places: Vec<Vector3<f64>>,
        merge: f64,
        (step, span): (&'a Step, Span),
        numbers: &'a mut Numbers,
    ) -> Self {
        let mut grid = Grid::new(merge);
        places.iter().enumerate().for_each(|(index, place)| grid.add(*place, index));
        Self {
            there: There::of(network),
            network,
            roots: (0..places.len()).collect(),
            grid,
            merge,
            tie: MERGE * size(&places),
            places,
            step,
            span,
            numbers,
            held: Held::default(),
            made: Vec::new(),
            overlaid: Vec::new(),
        }
    }

    /// Makes a copy of all that is selected.
    pub(super) fn copy(
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
            let same = match (centre_line(member, cx)?, centre_line(laid, cx)?) {
                (CentreLine::Straight, CentreLine::Straight) => true,
                (CentreLine::Through(a), CentreLine::Through(b)) => (a - b).norm() <= self.merge.max(self.tie),
                (CentreLine::Other, CentreLine::Other) => {
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
    pub(super) fn warn(&self, cx: &mut Context) {
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
    pub(super) fn second_axes(&self, selection: &Selection, cx: &mut Context) -> Option<Vec<Vector3<f64>>> {
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
enum CentreLine {
    Straight,
    /// A circle through a point.
    Through(Vector3<f64>),
    /// What goes with the axes of the member.
    Other,
}

fn centre_line(member: &Named<Spanned<Member>>, cx: &mut Context) -> Option<CentreLine> {
    let data = &member.value.value;
    if let Some((point, span)) = data.through() {
        let point = Spanned { span, value: point.to_vec() };
        let owner = format_args!("the arc of member '{}'", member.name);
        return Some(CentreLine::Through(Vector3::from(cx.vector(&point, Kind::Length, owner)?)));
    }
    let is_straight = data.arc.is_none() && data.tangent.is_none() && data.initial_curvature.is_none();
    Some(if is_straight { CentreLine::Straight } else { CentreLine::Other })
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

fn rename(name: &mut Spanned<String>, renamed: &HashMap<String, String>) {
    if let Some(new) = renamed.get(&name.value) {
        name.value.clone_from(new);
    }
}
