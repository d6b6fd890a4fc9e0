//! What holds and joins nodes: supports, rigid bodies, springs.

use nalgebra::{Matrix3, Vector3};
use pennate_solver::structure::{self, Support};

use super::context::{Context, Names, Owner};
use super::curve::{self, columns};
use super::topology::Place;
use crate::error::{InputError, Span};
use crate::input::read::{Map, Named, Spanned};
use crate::input::{self, Fix, SpringStiffness, SupportWord};
use crate::model::{Body, Spring};
use crate::unit::Kind;

/// The bodies, and which of them each node belongs to.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bodies {
    pub(crate) bodies: Vec<Body>,
    pub(crate) of_node: Vec<Option<usize>>,
}

impl Bodies {
    pub(crate) fn resolve(
        bodies: Option<&Map<Spanned<input::RigidBody>>>,
        names: &Names,
        count: usize,
        cx: &mut Context,
    ) -> Self {
        let mut all = Self { bodies: Vec::new(), of_node: vec![None; count] };
        for named in bodies.into_iter().flatten() {
            all.bodies.extend(body(named, names, cx));
        }
        for (index, body) in all.bodies.iter().enumerate() {
            for &node in &body.nodes {
                if let Some(other) = all.of_node[node].replace(index)
                    && other != index
                {
                    cx.error(
                        InputError::new(format!(
                            "node '{}' is in two rigid bodies, '{}' and '{}'",
                            names.of(node),
                            all.bodies[other].name,
                            body.name
                        ))
                        .at(body.span)
                        .help("make one body of them, or join them by a member"),
                    );
                }
            }
        }
        all
    }

    /// The node whose rotation is that of a node: the reference of its body.
    pub(crate) fn turns_with(&self, node: usize) -> usize {
        self.of_node[node].map_or(node, |body| self.bodies[body].reference)
    }
}

fn body(named: &Named<Spanned<input::RigidBody>>, names: &Names, cx: &mut Context) -> Option<Body> {
    let data = &named.value.value;
    let owner = Owner("rigid body", &named.name);
    let listed: Vec<_> = data.nodes.value.iter().map(|node| names.find(&node.value, node.span, owner, cx)).collect();
    let listed: Vec<usize> = listed.into_iter().collect::<Option<_>>()?;
    let reference = match &data.reference {
        Some(reference) => names.find(&reference.value, reference.span, owner, cx)?,
        None => match listed.first() {
            Some(&first) => first,
            None => {
                cx.error(
                    InputError::new(format!("{owner} has no nodes"))
                        .at(data.nodes.span)
                        .help("name the nodes that move as one"),
                );
                return None;
            }
        },
    };
    let mass = match &data.mass {
        Some(mass) => cx.not_negative(mass, Kind::Mass, format_args!("the mass of {owner}"))?,
        None => 0.0,
    };
    let mut nodes = vec![reference];
    let mut known: std::collections::HashSet<usize> = [reference].into();
    nodes.extend(listed.into_iter().filter(|&node| known.insert(node)));
    Some(Body { name: named.name.clone(), span: named.span, nodes, reference, mass })
}

/// Which of the six components are held.
pub(crate) fn fixed(fix: &Fix) -> [bool; 6] {
    let mut fixed = [false; 6];
    match fix {
        Fix::Word(SupportWord::Clamped) => fixed = [true; 6],
        Fix::Word(SupportWord::Pinned) => fixed[..3].fill(true),
        Fix::List(list) => list.iter().for_each(|component| fixed[component.index()] = true),
    }
    fixed
}

/// The supports, each with the place of its definition.
pub(crate) fn supports(
    supports: Option<&Map<Spanned<input::Support>>>,
    names: &Names,
    bodies: &Bodies,
    cx: &mut Context,
) -> Vec<(Support, Span)> {
    let mut all = Vec::new();
    for named in supports.into_iter().flatten() {
        let Some(node) = names.find(&named.name, named.span, "a support", cx) else { continue };
        let (fix, x_axis) = match &named.value.value {
            input::Support::Fix(fix) => (fix, None),
            input::Support::Turned(turned) => (&turned.fix, turned.x_axis.as_ref()),
        };
        let axes = match x_axis {
            None => Matrix3::identity(),
            Some(list) => match cx.direction(list, "the x axis of a support") {
                Some(direction) => support_axes(direction),
                None => continue,
            },
        };
        let fixed = fixed(fix);
        if fixed == [false; 6] {
            cx.error(
                InputError::new(format!("the support of node '{}' holds nothing", named.name))
                    .at(named.value.span)
                    .help("write \"clamped\", \"pinned\" or a list such as [\"ux\", \"uy\"]"),
            );
        }
        let reference = bodies.turns_with(node);
        if reference != node && fixed[3..].contains(&true) {
            cx.error(
                InputError::new(format!(
                    "the support of node '{}' holds a rotation, but the node turns with its rigid body",
                    named.name
                ))
                .at(named.value.span)
                .help(format!("hold rotations at its reference '{}'; here use ux uy uz", names.of(reference))),
            );
        }
        all.push((Support { node, fixed, axes: columns(&axes) }, named.value.span));
    }
    all
}

/// Makes pins of a plane network what they are there: pins about z, which hold rotations about x and y.
///
/// Nothing of that counts in the plane; it is heeded where stability is judged out of it.
pub(crate) fn pin_about_z(written: Option<&Map<Spanned<input::Support>>>, names: &Names, supports: &mut [Support]) {
    let is_pin = |support: &input::Support| {
        let (input::Support::Fix(fix) | input::Support::Turned(input::TurnedSupport { fix, .. })) = support;
        matches!(fix, Fix::Word(SupportWord::Pinned))
    };
    let pins = written.into_iter().flatten().filter(|named| is_pin(&named.value.value));
    let pins: std::collections::HashSet<usize> = pins.filter_map(|named| names.get(&named.name)).collect();
    for support in supports.iter_mut().filter(|support| pins.contains(&support.node)) {
        support.fixed[3..5].fill(true);
    }
}

/// Axes of a turned support: y is global z × x, or global y where x is along z.
fn support_axes(x: Vector3<f64>) -> Matrix3<f64> {
    // The rule is that of members, whose default always finds an axis.
    curve::frame(x, None).unwrap_or_else(Matrix3::identity)
}

/// The springs of the network.
pub(crate) fn springs(
    springs: Option<&Map<Spanned<input::Spring>>>,
    names: &Names,
    place: &Place<'_>,
    cx: &mut Context,
) -> Vec<Spring> {
    let mut all = Vec::new();
    for named in springs.into_iter().flatten() {
        if let Some(spring) = spring(named, names, place, cx) {
            all.push(Spring { name: named.name.clone(), span: named.span, spring });
        }
    }
    all
}

fn spring(
    named: &Named<Spanned<input::Spring>>,
    names: &Names,
    place: &Place<'_>,
    cx: &mut Context,
) -> Option<structure::Spring> {
    let data = &named.value.value;
    let owner = Owner("spring", &named.name);
    let axial = matches!(data.stiffness.value, SpringStiffness::Axial(_));
    if let Some(length) = &data.natural_length
        && !(axial && data.nodes.is_some())
    {
        cx.error(
            InputError::new(format!("{owner} has a natural_length, but does not act along a line"))
                .at(length.span)
                .help("leave it out, or write nodes = [ … ] and one number as stiffness"),
        );
    }
    match (&data.node, &data.nodes) {
        (Some(node), None) => {
            let node_index = names.find(&node.value, node.span, owner, cx);
            let SpringStiffness::Components(_) = &data.stiffness.value else {
                cx.error(
                    InputError::new(format!("{owner} to the ground needs a stiffness for each component"))
                        .at(data.stiffness.span)
                        .help("write stiffness = { ux = 2.0, rz = 5.0 }"),
                );
                return None;
            };
            let stiffness = components(&data.stiffness, owner, cx)?;
            Some(structure::Spring::Ground { node: node_index?, stiffness })
        }
        (None, Some(list)) => {
            let help = "write nodes = [\"A\", \"B\"], or node = \"A\" for a spring to the ground";
            let pair = names.pair(list, owner, help, cx)?;
            match &data.stiffness.value {
                SpringStiffness::Components(_) => Some(structure::Spring::Coupling {
                    nodes: pair,
                    stiffness: components(&data.stiffness, owner, cx)?,
                }),
                SpringStiffness::Axial(stiffness) => {
                    let stiffness =
                        cx.not_negative(stiffness, Kind::Stiffness, format_args!("the stiffness of {owner}"));
                    let natural = match &data.natural_length {
                        Some(length) => Some(cx.not_negative(
                            length,
                            Kind::Length,
                            format_args!("the natural length of {owner}"),
                        )?),
                        None => None,
                    };
                    axial_spring(pair, stiffness?, natural, place, owner, list.span, cx)
                }
            }
        }
        _ => {
            cx.error(
                InputError::new(format!("{owner} needs either node or nodes"))
                    .at(named.span)
                    .help("node = \"A\" goes to the ground, nodes = [\"A\", \"B\"] joins two nodes"),
            );
            None
        }
    }
}

fn axial_spring(
    pair: [usize; 2],
    stiffness: f64,
    natural: Option<f64>,
    place: &Place<'_>,
    owner: Owner<'_>,
    span: Span,
    cx: &mut Context,
) -> Option<structure::Spring> {
    let [start, end] = pair.map(|node| place(node).map(Vector3::from));
    let distance = (end? - start?).norm();
    let natural_length = natural.unwrap_or(distance);
    if distance > 0.0 {
        return Some(structure::Spring::Axial { nodes: pair, stiffness, natural_length });
    }
    if natural_length > 0.0 {
        cx.error(
            InputError::new(format!("{owner} joins two nodes at one place and has no direction"))
                .at(span)
                .help("move a node, set natural_length = 0, or give a stiffness for each component"),
        );
        return None;
    }
    // Without natural length ½ k l² has no direction to lose: the same in all three components.
    let all = [stiffness, stiffness, stiffness, 0.0, 0.0, 0.0];
    Some(structure::Spring::Coupling { nodes: pair, stiffness: all })
}

fn components(stiffness: &Spanned<SpringStiffness>, owner: Owner<'_>, cx: &mut Context) -> Option<[f64; 6]> {
    let SpringStiffness::Components(components) = &stiffness.value else { return None };
    let mut values = [0.0; 6];
    let mut complete = true;
    for (index, number) in components.in_order().into_iter().enumerate() {
        let Some(number) = number else { continue };
        let kind = if index < 3 { Kind::Stiffness } else { Kind::RotationalStiffness };
        match cx.not_negative(number, kind, format_args!("a stiffness of {owner}")) {
            Some(value) => values[index] = value,
            None => complete = false,
        }
    }
    if complete && values == [0.0; 6] {
        cx.error(
            InputError::new(format!("{owner} has no stiffness"))
                .at(stiffness.span)
                .help("write for example stiffness = { ux = 2.0 }"),
        );
        return None;
    }
    complete.then_some(values)
}
