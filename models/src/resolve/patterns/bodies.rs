//! Rigid bodies that come to share a node.

use std::collections::{HashMap, HashSet};

use nalgebra::Vector3;

use super::super::context::Context;
use super::{bare, body_nodes, reference};
use crate::error::InputError;
use crate::input::read::{Named, Spanned};
use crate::input::{Network, RigidBody};
use crate::unit::Kind;

/// Makes one body of those that share nodes, of a network whose nodes are at these places; their masses, which are at one place within `tie`, add.
pub(super) fn fuse_bodies(network: &mut Network, places: &[Vector3<f64>], tie: f64, cx: &mut Context) -> Option<()> {
    let Some(bodies) = network.rigid_bodies.as_mut() else { return Some(()) };
    let names = network.nodes.iter().flatten().map(|named| named.name.as_str());
    let places: HashMap<&str, Vector3<f64>> = names.zip(places.iter().copied()).collect();
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
