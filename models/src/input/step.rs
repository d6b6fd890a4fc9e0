//! Steps as written.

use schemars::JsonSchema;

use super::read::{Counted, Input, Map, Number, Spanned, record, words, wrong_type};
use super::tree::{Kind, Value};
use super::{Component, Components, Fix};
use crate::error::InputError;

/// A vector, or some of its components.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum Motion {
    Vector(Vec<Number>),
    Components(Box<Components>),
}

impl Input for Motion {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        match value.kind {
            Kind::Table(_) => Components::read(value, errors).map(|all| Self::Components(Box::new(all))),
            Kind::Array(_) => Vec::read(value, errors).map(Self::Vector),
            _ => wrong_type(value, "a list [x, y, z] or a table { uy = … }", errors),
        }
    }
}

record! {
    /// One step: absolute targets that are reached together; what is not named stays.
    pub(crate) struct Step as "a step" {
        name: Option<Spanned<String>>,
        /// Of muscles, by member, group or "all".
        pressure: Option<Map<Number>>,
        /// Of members with strain or curvature, by member, group or "all".
        actuation: Option<Map<Number>>,
        /// Prescribed, from the unloaded position, by node.
        displacement: Option<Map<Spanned<Motion>>>,
        /// Prescribed rotation vector, by node.
        rotation: Option<Map<Spanned<Motion>>>,
        /// Dead forces by node.
        force: Option<Map<Spanned<Vec<Number>>>>,
        /// Dead moments by node.
        moment: Option<Map<Spanned<Vec<Number>>>>,
        /// Forces that turn with their node.
        follower_force: Option<Map<Spanned<Vec<Number>>>>,
        /// Moments that turn with their node.
        follower_moment: Option<Map<Spanned<Vec<Number>>>>,
        /// Acceleration of gravity.
        gravity: Option<Spanned<Vec<Number>>>,
        /// Force per unloaded length, by member, group or "all".
        distributed: Option<Map<Spanned<Vec<Number>>>>,
        /// Components kept where they are, by node.
        hold: Option<Map<Spanned<Fix>>>,
        /// Prescribed, from the present position, by node.
        displace_by: Option<Map<Spanned<Motion>>>,
        /// Components whose reaction is ramped to zero, by node.
        free: Option<Map<Spanned<Fix>>>,
        method: Option<Spanned<Method>>,
        stop: Option<Spanned<Stop>>,
        branch: Option<Spanned<Branch>>,
        /// At least so many increments.
        increments: Option<Spanned<Counted>>,
    }
}

words! {
    pub(crate) enum Method as "a method" {
        Newton = "newton",
        ArcLength = "arc_length",
        Jump = "jump",
    }
}

words! {
    pub(crate) enum Branch as "a branch" {
        Stable = "stable",
        Primary = "primary",
    }
}

record! {
    /// Where an arc-length step ends before its ramp does: where a component of a node reaches a value, where the ramp
    /// reaches a fraction, or after so many increments.
    pub(crate) struct Stop as "a stop" {
        node: Option<Spanned<String>>,
        /// One of ux uy uz, or of rx ry rz.
        displacement: Option<Component>,
        /// Length, or degrees.
        at: Option<Number>,
        /// Part of the ramp; may lie outside of 0 to 1.
        fraction: Option<Number>,
        increments: Option<Spanned<Counted>>,
    }
}
