//! What steps do to nodes beyond loading them: prescribe, hold, move, free.

use nalgebra::Vector3;
use pennate_solver::structure::Change;

use super::joints::fixed;
use super::steps::StepReader;
use super::topology::JointRotation;
use crate::error::{InputError, Span};
use crate::input::read::{Map, Named, Spanned};
use crate::input::{self, Motion};
use crate::unit::Kind;

const COMPONENTS: [&str; 6] = ["ux", "uy", "uz", "rx", "ry", "rz"];

impl StepReader<'_, '_> {
    pub(crate) fn motions(&mut self, entries: Option<&Map<Spanned<Motion>>>, key: &'static str) {
        for named in entries.into_iter().flatten() {
            let node = self.node(named, key);
            let values = self.motion(named, key);
            let (Some(node), Some(values)) = (node, values) else { continue };
            for (component, value) in values.into_iter().enumerate() {
                let Some(value) = value else { continue };
                let Some((node, component)) = self.claim(node, component, key, named.value.span) else { continue };
                if component >= 3 && value != 0.0 {
                    self.check_turn(node, component, &named.name, named.value.span);
                }
                self.held[node][component] = true;
                self.changes.push(match key {
                    "displace_by" => Change::MoveBy { node, component, by: value },
                    _ => Change::Prescribe { node, component, to: value },
                });
            }
        }
    }

    fn check_turn(&mut self, node: usize, component: usize, name: &str, span: Span) {
        let mut axis = Vector3::zeros();
        axis[component - 3] = 1.0;
        let rotation = self.actors.rotations[node];
        if !rotation.turns_nothing(axis) {
            return;
        }
        let (message, label) = match rotation {
            JointRotation::NoSpin(_) => (
                format!(
                    "a rotation {} of node '{name}' turns nothing: all ends there are hinged about that axis",
                    COMPONENTS[component]
                ),
                "turns about the hinge alone",
            ),
            _ => {
                (format!("node '{name}' has no rotation to prescribe: all ends there are released"), "no rotation here")
            }
        };
        self.cx.error(InputError::new(message).at(span).label(label).help("weld one of the members to the node"));
    }

    /// Values of the six components, as far as given.
    fn motion(&mut self, named: &Named<Spanned<Motion>>, key: &str) -> Option<[Option<f64>; 6]> {
        let what = format_args!("{key} of node '{}'", named.name);
        let span = named.value.span;
        let mut values = [None; 6];
        match &named.value.value {
            Motion::Vector(list) if key == "rotation" => {
                let list = Spanned { span, value: list.clone() };
                let vector = self.cx.triple(&list, Kind::Angle, what)?;
                (0..3).for_each(|component| values[3 + component] = Some(vector[component]));
            }
            Motion::Vector(list) => {
                let count = list.len();
                let list = Spanned { span, value: list.clone() };
                let vector = self.cx.vector(&list, Kind::Length, what)?;
                (0..count).for_each(|component| values[component] = Some(vector[component]));
            }
            Motion::Components(components) => {
                for (component, number) in components.in_order().into_iter().enumerate() {
                    let Some(number) = number else { continue };
                    let turns = component >= 3;
                    if (key == "rotation" && !turns) || (key == "displacement" && turns) {
                        let other = if turns { "rotation" } else { "displacement" };
                        self.cx.error(
                            InputError::new(format!("{what} has the component '{}'", COMPONENTS[component]))
                                .at(number.span)
                                .help(format!("write it under {other} = {{ … }}")),
                        );
                        return None;
                    }
                    values[component] = Some(self.cx.number(number, if turns { Kind::Angle } else { Kind::Length })?);
                }
            }
        }
        Some(values)
    }

    pub(crate) fn hold_or_free(&mut self, entries: Option<&Map<Spanned<input::Fix>>>, key: &'static str) {
        for named in entries.into_iter().flatten() {
            let Some(node) = self.node(named, key) else { continue };
            let components = fixed(&named.value.value);
            for component in (0..6).filter(|&component| components[component]) {
                let Some((node, component)) = self.claim(node, component, key, named.value.span) else { continue };
                if key == "hold" {
                    self.held[node][component] = true;
                    self.changes.push(Change::Hold { node, component });
                    continue;
                }
                if !self.held[node][component] {
                    self.cx.error(
                        InputError::new(format!(
                            "step '{}' frees {} of node '{}', which nothing holds",
                            self.name, COMPONENTS[component], named.name
                        ))
                        .at(named.value.span)
                        .label("already free")
                        .help("free what a support, a hold or a prescribed motion holds"),
                    );
                }
                self.held[node][component] = false;
                self.changes.push(Change::Free { node, component });
            }
        }
    }

    /// Notes that a component is changed in this step; rotations of a body are those of its reference.
    fn claim(&mut self, node: usize, component: usize, key: &'static str, span: Span) -> Option<(usize, usize)> {
        let node = if component >= 3 { self.actors.bodies.turns_with(node) } else { node };
        let Some(other) = self.changed.insert((node, component), key) else { return Some((node, component)) };
        self.cx.error(
            InputError::new(format!(
                "step '{}' changes {} of node '{}' twice, by {other} and by {key}",
                self.name,
                COMPONENTS[component],
                self.actors.nodes.of(node)
            ))
            .at(span)
            .label("contradicts what stands before")
            .help("keep one of them, or use two steps"),
        );
        None
    }
}
