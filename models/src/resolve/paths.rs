//! Members written in short: those along a path of nodes, and arcs given by their rise.
//!
//! They become plain members before anything else looks at them: parts `name.1`, `name.2` … of a path, which `name`
//! addresses together, and arcs through a point.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::context::Context;
use super::curve;
use crate::error::InputError;
use crate::input::read::{Map, Named, Number, Spanned, Written};
use crate::input::{Arc, Member, Network, Releases};
use crate::unit::Kind;

/// The network with plain members; `None` where it has them already, or where something is wrong.
pub(crate) fn expand(network: &Network, cx: &mut Context) -> Option<Network> {
    let short = |member: &Named<Spanned<Member>>| {
        let member = &member.value.value;
        member.path.is_some() || matches!(member.arc, Some(Spanned { value: Arc::Rise(_), .. }))
    };
    network.members.iter().flatten().find(|member| short(member))?;
    let mut network = network.clone();
    let members = network.members.take()?;
    let written: HashMap<String, ()> = members.iter().map(|named| (named.name.clone(), ())).collect();
    let mut all = Vec::with_capacity(members.0.len());
    for member in members.0 {
        match member.value.value.path.clone() {
            Some(path) => parts(member, &path, &written, &mut all, cx),
            None => all.push(member),
        }
    }
    let nodes: HashMap<&str, &Spanned<Vec<Number>>> =
        network.nodes.iter().flatten().map(|named| (named.name.as_str(), &named.value)).collect();
    for member in &mut all {
        if let Some(Spanned { value: Arc::Rise(_), .. }) = member.value.value.arc {
            rise(member, &nodes, cx);
        }
    }
    network.members = Some(Map(all));
    Some(network)
}

/// Adds the members between neighbouring nodes of a path.
fn parts(
    member: Named<Spanned<Member>>,
    path: &Spanned<Vec<Spanned<String>>>,
    written: &HashMap<String, ()>,
    all: &mut Vec<Named<Spanned<Member>>>,
    cx: &mut Context,
) {
    let data = &member.value.value;
    let owner = format!("member '{}'", member.name);
    let twice = [
        ("nodes", data.nodes.as_ref().map(|list| list.span)),
        ("segments", data.segments.as_ref().map(|list| list.span)),
        ("arc", data.arc.as_ref().map(|arc| arc.span)),
        ("length", data.length.as_ref().map(|length| length.span)),
        ("tangent", data.tangent.as_ref().map(|list| list.span)),
        ("initial_curvature", data.initial_curvature.as_ref().map(|list| list.span)),
    ];
    if let Some((key, Some(span))) = twice.into_iter().find(|(_, span)| span.is_some()) {
        cx.error(
            InputError::new(format!("{owner} has a path, and {key} too")).at(span).help(
                "a path is straight from node to node; write members with nodes = [\"A\", \"B\"] for what is not",
            ),
        );
        return;
    }
    if path.value.len() < 2 {
        let count = path.value.len();
        cx.error(
            InputError::new(format!("the path of {owner} has {count} node(s)"))
                .at(path.span)
                .help("name two nodes at least: path = [\"A\", \"B\", \"C\"]"),
        );
        return;
    }
    let last = path.value.len() - 2;
    for (index, ends) in path.value.windows(2).enumerate() {
        let name = format!("{}.{}", member.name, index + 1);
        if written.contains_key(&name) {
            cx.error(
                InputError::new(format!(
                    "part {} of {owner} would be called '{name}', as another member is",
                    index + 1
                ))
                .at(member.span)
                .help("give one of them another name"),
            );
            continue;
        }
        let mut part = member.clone();
        let data = &mut part.value.value;
        data.path = None;
        data.nodes = Some(Spanned { span: path.span, value: ends.to_vec() });
        // The ends of the path are released; within it the parts are welded.
        if let Some(Spanned { value: Releases { start, end }, .. }) = &mut data.release {
            *start = start.take().filter(|_| index == 0);
            *end = end.take().filter(|_| index == last);
        }
        cx.paths.insert(name.clone(), member.name.clone());
        part.name = name;
        all.push(part);
    }
}

/// Makes an arc through a point of one that is given by its rise.
///
/// The rise is measured from the middle of the line between the nodes, towards `orientation` made normal to that line,
/// else towards axis 2 of a straight member there: in the plane to the left, seen from the first node.
fn rise(member: &mut Named<Spanned<Member>>, nodes: &HashMap<&str, &Spanned<Vec<Number>>>, cx: &mut Context) {
    let owner = format!("member '{}'", member.name);
    let data = &mut member.value.value;
    let Some(Spanned { span, value: Arc::Rise(given) }) = &data.arc else { return };
    let (span, given) = (*span, given.rise.clone());
    let Some(height) = cx.number(&given, Kind::Length) else { return };
    let ends: Vec<&Spanned<String>> = data.nodes.iter().flat_map(|list| &list.value).collect();
    // Nodes that are not there are reported where members are read.
    let place = |index: usize| ends.get(index).and_then(|name| nodes.get(name.value.as_str()));
    let (Some(start), Some(end)) = (place(0), place(1)) else {
        data.arc = None;
        return;
    };
    let at = |list: &Spanned<Vec<Number>>, cx: &mut Context| cx.vector(list, Kind::Length, "a node").map(Vector3::from);
    let (Some(start), Some(end)) = (at(start, cx), at(end, cx)) else { return };
    let towards = match &data.orientation {
        Some(list) => cx.direction(list, format_args!("the orientation of {owner}")),
        None => None,
    };
    let frame = (end - start).try_normalize(0.0).and_then(|along| curve::frame(along, towards));
    let Some(frame) = frame else {
        cx.error(
            InputError::new(format!("the rise of {owner} has no direction"))
                .at(span)
                .help("move its nodes apart, and give an orientation across the line between them"),
        );
        return;
    };
    if height == 0.0 {
        cx.error(
            InputError::new(format!("the arc of {owner} has no rise"))
                .at(given.span)
                .help("leave arc out for a straight member"),
        );
        return;
    }
    let middle = 0.5 * (start + end) + frame.column(1) * height;
    let point = middle.iter().map(|&value| Spanned { span: given.span, value: Written::Bare(value) }).collect();
    data.arc = Some(Spanned { span, value: Arc::Through(point) });
}
