//! Probes as written.

use schemars::JsonSchema;

use super::Component;
use super::read::{Input, Number, Spanned, record, words, wrong_type};
use super::tree::{Kind, Value};
use crate::error::InputError;

/// A number wanted by name.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum Probe {
    /// An expression over other probes, "= -stroke / 17.9"; `stroke@inflate` is the value after a step.
    Expression(String),
    Quantity(Box<ProbeTable>),
}

impl Input for Probe {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        match &value.kind {
            Kind::String(text) => Some(Self::Expression(text.clone())),
            Kind::Table(_) => ProbeTable::read(value, errors).map(|probe| Self::Quantity(Box::new(probe))),
            _ => wrong_type(value, "a table { node = … } or an expression \"= …\"", errors),
        }
    }
}

record! {
    /// A quantity of a node, a body, two nodes or a member.
    pub(crate) struct ProbeTable as "a probe" {
        node: Option<Spanned<String>>,
        nodes: Option<Spanned<Vec<Spanned<String>>>>,
        body: Option<Spanned<String>>,
        member: Option<Spanned<String>>,
        displacement: Option<Spanned<Direction<Component>>>,
        position: Option<Spanned<Direction<PositionWord>>>,
        rotation: Option<Spanned<RotationProbe>>,
        reaction: Option<Spanned<Direction<Component>>>,
        /// Force or moment for a unit of displacement or a radian, everything else free to follow.
        stiffness: Option<Spanned<Direction<Component>>>,
        /// The inverse of that.
        compliance: Option<Spanned<Direction<Component>>>,
        /// A direction of the body; the probe is the angle by which it has turned.
        normal: Option<Spanned<Vec<Number>>>,
        distance: Option<Spanned<bool>>,
        axial_force: Option<Spanned<AxialPlace>>,
        /// The greatest stress along a member, or along those of a group or of "all".
        stress: Option<Spanned<Greatest>>,
        /// The greatest strain, without what pressure and actuation induce.
        strain: Option<Spanned<Greatest>>,
        /// The greatest bending moment, about axes 2 and 3 together.
        moment: Option<Spanned<Greatest>>,
    }
}

words! {
    pub(crate) enum Greatest as "one of max, bending" {
        /// Of the outermost fibres, bending and axial part together.
        Max = "max",
        /// Of bending alone.
        Bending = "bending",
    }
}

/// A component by name, or a direction.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(untagged, rename = "Direction_{T}")]
pub(crate) enum Direction<T> {
    Word(T),
    Vector(Vec<Number>),
}

impl<T: Input> Input for Direction<T> {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        match value.kind {
            Kind::Array(_) => Vec::read(value, errors).map(Self::Vector),
            _ => T::read(value, errors).map(Self::Word),
        }
    }
}

words! {
    pub(crate) enum PositionWord as "one of x, y, z" {
        X = "x",
        Y = "y",
        Z = "z",
    }
}

words! {
    pub(crate) enum RotationProbe as "one of rx, ry, rz, angle" {
        Rx = "rx",
        Ry = "ry",
        Rz = "rz",
        Angle = "angle",
    }
}

words! {
    pub(crate) enum AxialPlace as "one of start, middle, end" {
        Start = "start",
        Middle = "middle",
        End = "end",
    }
}
