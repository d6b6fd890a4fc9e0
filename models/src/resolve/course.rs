//! How a step goes along its ramp: method, branch, and where it stops.

use pennate_solver::structure::{Branch, Method, Stop};

use super::context::{Context, Names};
use crate::error::InputError;
use crate::input;
use crate::input::read::Spanned;
use crate::unit::Kind;

/// Method, branch and stop of a step.
pub(crate) fn course(step: &input::Step, nodes: &Names, cx: &mut Context) -> (Method, Branch, Option<Stop>) {
    let method = match &step.method {
        None | Some(Spanned { value: input::Method::Newton, .. }) => Method::Newton,
        Some(Spanned { value: input::Method::ArcLength, .. }) => Method::ArcLength,
        Some(Spanned { value: input::Method::Jump, .. }) => Method::Jump,
    };
    let branch = match &step.branch {
        None | Some(Spanned { value: input::Branch::Stable, .. }) => Branch::Stable,
        Some(Spanned { value: input::Branch::Primary, .. }) => Branch::Primary,
    };
    if let (Some(free), Method::ArcLength) = (&step.free, method) {
        let first = free.0.first();
        cx.error(
            InputError::new(
                "a step along the arc length cannot set anything free: a reaction fades over the whole ramp",
            )
            .at(first.map_or_else(Default::default, |named| named.span))
            .help("free it in a step of its own before this one"),
        );
    }
    let stop = step.stop.as_ref().and_then(|stop| {
        if method != Method::ArcLength {
            cx.error(
                InputError::new("stop belongs to a step along the arc length")
                    .at(stop.span)
                    .help("add method = \"arc_length\", or prescribe the displacement with displacement = { ... }"),
            );
        }
        resolve_stop(stop, nodes, cx)
    });
    (method, branch, stop)
}

fn resolve_stop(stop: &Spanned<input::Stop>, nodes: &Names, cx: &mut Context) -> Option<Stop> {
    let input::Stop { node, displacement, at, fraction, increments } = &stop.value;
    match (node, displacement, at, fraction, increments) {
        (Some(node), Some(component), Some(at), None, None) => {
            let index = nodes.find(&node.value, node.span, "stop", cx);
            let component = component.index();
            let value = cx.number(at, if component < 3 { Kind::Length } else { Kind::Angle });
            Some(Stop::At { node: index?, component, value: value? })
        }
        (None, None, None, Some(fraction), None) => cx.number(fraction, Kind::Pure).map(Stop::Fraction),
        (None, None, None, None, Some(count)) => cx.count(count).map(Stop::Increments),
        _ => {
            cx.error(InputError::new("a stop names one thing that ends the step").at(stop.span).help(
                "write { node = \"J\", displacement = \"uy\", at = -60 }, { fraction = 0.8 } or { increments = 50 }",
            ));
            None
        }
    }
}
