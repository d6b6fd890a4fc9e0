//! What a network file says for its load flow.

use schemars::JsonSchema;

use super::read::{Input, Map, Number, Spanned, record};
use super::tree::{Kind, Value};
use crate::error::InputError;

record! {
    /// Where a mechanism is driven, what it moves, and which muscles may take the place of its members.
    pub(crate) struct LoadFlow as "a load flow" {
        /// Where it is driven: one table, or a list of tables that act together.
        input: FlowInputs,
        /// Nodes that it moves.
        outputs: Spanned<Vec<Spanned<String>>>,
        /// Members of the mechanism; all by default.
        members: Option<Spanned<Vec<Spanned<String>>>>,
        /// The muscle that takes the place of transmitters; the only one of the file by default.
        muscle: Option<Spanned<String>>,
        /// Pressure of these muscles; the largest of the muscle's table by default.
        pressure: Option<Number>,
        /// Members shorter than this are not replaced; 45 mm by default.
        shortest: Option<Number>,
        /// Limits of probes: the replacement ends with the first network that keeps all of them.
        requirements: Option<Map<Spanned<Requirement>>>,
    }
}

record! {
    /// Limits of a probe of this name.
    pub(crate) struct Requirement as "a requirement" {
        /// The probe is to be at least this, in the units of the file.
        least: Option<Number>,
        /// The probe is to be at most this.
        most: Option<Number>,
    }
}

record! {
    /// A force or a moment of one that drives a mechanism.
    pub(crate) struct FlowInput as "an input of a load flow" {
        node: Spanned<String>,
        /// Direction of the force.
        direction: Option<Spanned<Vec<Number>>>,
        /// Axis of the moment, in place of a force.
        about: Option<Spanned<Vec<Number>>>,
        /// false: the supports of the file hold the input; by default all but the motion along the force is held.
        guided: Option<bool>,
    }
}

/// One input, or several that act together.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum FlowInputs {
    One(Box<Spanned<FlowInput>>),
    Many(Vec<Spanned<FlowInput>>),
}

impl FlowInputs {
    /// The inputs, in the order of the file.
    pub(crate) fn all(&self) -> &[Spanned<FlowInput>] {
        match self {
            Self::One(input) => std::slice::from_ref(input.as_ref()),
            Self::Many(inputs) => inputs,
        }
    }
}

impl Input for FlowInputs {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        match value.kind {
            Kind::Array(_) => Vec::read(value, errors).map(Self::Many),
            _ => Spanned::read(value, errors).map(|input| Self::One(Box::new(input))),
        }
    }
}
