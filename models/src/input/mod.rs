//! The input file, as written by a user, with places kept for messages.
//!
//! One set of types says what a file may hold, how it is read and what its JSON Schema is; nothing is
//! evaluated or looked up here.

pub(crate) mod load_flow;
pub(crate) mod probe;
pub(crate) mod read;
pub(crate) mod step;
pub mod tree;
pub mod write;

use std::borrow::Cow;

use pennate_solver::structure::Formulation;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

pub use self::read::suggest;

pub(crate) use self::load_flow::{FlowInput, LoadFlow, Requirement};
pub(crate) use self::probe::{AxialPlace, Direction, Greatest, Probe, ProbeTable, RotationProbe};
pub(crate) use self::step::{Branch, Method, Motion, Step, Stop};

use self::read::{Count, Counted, Input, Map, Number, Spanned, record, words, wrong_type};
use self::tree::{Kind, Value};
use crate::error::{InputError, Span};

record! {
    /// A network of pneumatic muscles and compliant members.
    pub(crate) struct Network as "a network file" {
        /// "pennate/1".
        format: Option<Spanned<String>>,
        title: Option<String>,
        /// Unit system of bare numbers; "mm-N-MPa" by default.
        units: Option<UnitsWord>,
        /// Solve in the plane or in space; found out by default.
        dimension: Option<Spanned<DimensionWord>>,
        /// Of members that do not say otherwise; "exact" by default.
        formulation: Option<Spanned<FormulationWord>>,
        /// Strain of members that are no muscles above which a warning is given; 0.1 by default.
        strain_limit: Option<Number>,
        /// Numbers that expressions may use.
        parameters: Option<Map<Number>>,
        /// Named points [x, y] or [x, y, z].
        nodes: Option<Map<Spanned<Vec<Number>>>>,
        materials: Option<Map<Spanned<Material>>>,
        sections: Option<Map<Spanned<Section>>>,
        muscles: Option<Map<Spanned<Muscle>>>,
        members: Option<Map<Spanned<Member>>>,
        /// What holds the nodes.
        supports: Option<Map<Spanned<Support>>>,
        rigid_bodies: Option<Map<Spanned<RigidBody>>>,
        springs: Option<Map<Spanned<Spring>>>,
        /// Copies of all this, or of some members.
        patterns: Option<Vec<Spanned<Pattern>>>,
        steps: Option<Vec<Spanned<Step>>>,
        /// Numbers wanted by name, at every increment.
        probes: Option<Map<Spanned<Probe>>>,
        /// Where the network is driven and what it moves, for its load flow.
        load_flow: Option<Spanned<LoadFlow>>,
    }
}

record! {
    /// Copies, each moved from the one before by one turn and one translation; copy k of a name is name-k.
    pub(crate) struct Pattern as "a pattern" {
        /// How many there are in the end, the original among them.
        count: Spanned<Counted>,
        /// Members and groups that are copied, with their nodes, bodies and springs; all by default.
        members: Option<Spanned<Vec<Spanned<String>>>>,
        translation: Option<Spanned<Vec<Number>>>,
        rotation: Option<Spanned<PatternRotation>>,
        /// Nodes of a copy nearer than this to others are these; 1e-9 of the network's size by default.
        merge: Option<Number>,
        /// true: supports of copied nodes and springs to the ground are copied too.
        supports: Option<bool>,
    }
}

record! {
    /// A turn from one copy to the next.
    pub(crate) struct PatternRotation as "a rotation" {
        angle: Number,
        /// Direction of the axis; global z by default.
        axis: Option<Spanned<Vec<Number>>>,
        /// A point of the axis; the origin by default.
        point: Option<Spanned<Vec<Number>>>,
    }
}

words! {
    pub(crate) enum UnitsWord as "a unit system" {
        MmNMpa = "mm-N-MPa",
        MNPa = "m-N-Pa",
    }
}

words! {
    pub(crate) enum DimensionWord as "a dimension" {
        Plane = "plane",
        Space = "space",
    }
}

record! {
    /// An elastic material: Poisson's ratio or shear modulus.
    pub(crate) struct Material as "a material" {
        youngs_modulus: Number,
        poissons_ratio: Option<Number>,
        shear_modulus: Option<Number>,
        density: Option<Number>,
    }
}

record! {
    /// A cross section: one of circle, annulus, rectangle, stiffness.
    pub(crate) struct Section as "a section" {
        circle: Option<Spanned<Circle>>,
        annulus: Option<Spanned<Annulus>>,
        rectangle: Option<Spanned<Rectangle>>,
        stiffness: Option<Spanned<Stiffness>>,
        /// Shear correction factor, instead of that of the shape.
        shear_factor: Option<Number>,
        /// false: shear-rigid.
        shear: Option<bool>,
        /// false: inextensible.
        stretch: Option<bool>,
    }
}

record! {
    pub(crate) struct Circle as "a circle" {
        radius: Number,
    }
}

record! {
    pub(crate) struct Annulus as "an annulus" {
        outer_radius: Number,
        wall: Number,
    }
}

record! {
    /// The height is along axis 2, the width along axis 3.
    pub(crate) struct Rectangle as "a rectangle" {
        width: Number,
        height: Number,
    }
}

record! {
    /// Stiffnesses given outright. GA2, GA3 left out: shear-rigid; in the plane EA, GA2, EI3 suffice.
    #[allow(non_snake_case)]
    pub(crate) struct Stiffness as "a stiffness" {
        EA: Option<Number>,
        GA2: Option<Number>,
        GA3: Option<Number>,
        GJ: Option<Number>,
        EI2: Option<Number>,
        EI3: Option<Number>,
        mass_per_length: Option<Number>,
    }
}

record! {
    /// Data of an HSIM muscle, or the file that holds them, or the name of a muscle that the program knows.
    pub(crate) struct Muscle as "a muscle" {
        /// Name of a muscle that comes with the program.
        library: Option<Spanned<String>>,
        /// File with the data of the muscle, relative to the network file.
        file: Option<Spanned<String>>,
        /// Unit system of the bare numbers of a muscle file; that of the network by default.
        units: Option<Spanned<UnitsWord>>,
        /// Undeformed outer diameter.
        diameter: Option<Number>,
        /// Length of the end segments; the diameter by default.
        end_length: Option<Number>,
        wall: Option<Number>,
        /// Unit of bare pressures of this muscle.
        pressure_unit: Option<Spanned<String>>,
        density: Option<Number>,
        /// 0.5 by default.
        poissons_ratio: Option<Number>,
        shear_factor: Option<Number>,
        /// true: shear-flexible; shear-rigid by default.
        shear: Option<bool>,
        /// false: inextensible.
        stretch: Option<bool>,
        table: Option<Spanned<Vec<Spanned<MuscleRow>>>>,
    }
}

record! {
    /// Parameters of a muscle at one pressure.
    #[allow(non_snake_case)]
    pub(crate) struct MuscleRow as "a row of a muscle's table" {
        pressure: Number,
        E: Number,
        /// Modulus of the ends; E by default.
        E1: Option<Number>,
        /// Contraction per unit of pressure, negative.
        alpha: Number,
        /// Outer radius of the ends.
        R1: Number,
        /// Outer radius of the middle.
        R2: Number,
    }
}

record! {
    /// A bar between two nodes, or bars along a path of them: one of muscle, section, segments.
    pub(crate) struct Member as "a member" {
        /// Start and end.
        nodes: Option<Spanned<Vec<Spanned<String>>>>,
        /// Instead of nodes: one bar from each to the next, name.1, name.2 and so on, which the name addresses together.
        path: Option<Spanned<Vec<Spanned<String>>>>,
        muscle: Option<Spanned<String>>,
        section: Option<Spanned<String>>,
        material: Option<Spanned<String>>,
        segments: Option<Spanned<Vec<Spanned<Segment>>>>,
        group: Option<Spanned<String>>,
        /// Direction of axis 2 at the start, made normal to the tangent.
        orientation: Option<Spanned<Vec<Number>>>,
        release: Option<Spanned<Releases>>,
        /// A point [x, y, z]: the member is the circle through start, point and end; or { rise = 8 }.
        arc: Option<Spanned<Arc>>,
        length: Option<Number>,
        /// Direction of the unloaded centre line at the start.
        tangent: Option<Spanned<Vec<Number>>>,
        /// Twist and curvatures about axes 1, 2, 3.
        initial_curvature: Option<Spanned<Vec<Number>>>,
        /// Number of elements of each segment.
        elements: Option<Spanned<Counted>>,
        /// Order of the elements, 1 to 4.
        order: Option<Spanned<Count>>,
        /// "exact", or "corotational": two-node elements; that of the network by default.
        formulation: Option<Spanned<FormulationWord>>,
    }
}

impl Member {
    /// Names of the nodes, as far as they are written.
    pub(crate) fn ends(&self) -> &[Spanned<String>] {
        self.nodes.as_ref().map_or(&[], |nodes| &nodes.value)
    }

    /// The point that an arc goes through, and its place in the file.
    pub(crate) fn through(&self) -> Option<(&[Number], Span)> {
        match &self.arc {
            Some(Spanned { span, value: Arc::Through(point) }) => Some((point, *span)),
            _ => None,
        }
    }
}

record! {
    /// How far the middle of an arc lies from the line between its ends: positive towards axis 2 of a straight member
    /// there, in the plane to the left.
    pub(crate) struct Rise as "an arc" {
        rise: Number,
    }
}

/// A circle through a point, or of a rise.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum Arc {
    Through(Vec<Number>),
    Rise(Rise),
}

impl Input for Arc {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        match value.kind {
            Kind::Array(_) => Vec::read(value, errors).map(Self::Through),
            Kind::Table(_) => Rise::read(value, errors).map(Self::Rise),
            _ => wrong_type(value, "a point [x, y] or { rise = 8 }", errors),
        }
    }
}

/// A formulation, by the word of its law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FormulationWord(pub(crate) Formulation);

impl FormulationWord {
    fn words() -> impl Iterator<Item = &'static str> + Clone {
        Formulation::ALL.iter().map(|formulation| formulation.about().word)
    }
}

impl Input for FormulationWord {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        let place = read::word(value, "a formulation", Self::words(), errors)?;
        Some(Self(Formulation::ALL[place]))
    }
}

impl JsonSchema for FormulationWord {
    fn schema_name() -> Cow<'static, str> {
        "Formulation".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string", "enum": Self::words().collect::<Vec<_>>() })
    }
}

record! {
    /// A stretch of a member.
    pub(crate) struct Segment as "a segment" {
        length: Number,
        section: Spanned<String>,
        material: Option<Spanned<String>>,
        initial_curvature: Option<Spanned<Vec<Number>>>,
        /// Induced axial strain at actuation 1.
        strain: Option<Number>,
        /// Induced twist and curvatures at actuation 1.
        curvature: Option<Spanned<Vec<Number>>>,
        elements: Option<Spanned<Counted>>,
    }
}

record! {
    /// How the ends of a member are connected to their nodes, where they are not welded.
    pub(crate) struct Releases as "a release" {
        start: Option<Spanned<EndRelease>>,
        end: Option<Spanned<EndRelease>>,
    }
}

words! {
    pub(crate) enum PinWord as "a release: \"pin\", a list of rx ry rz, or { hinge = […] }" {
        Pin = "pin",
    }
}

words! {
    /// Rotations about the member's own axes.
    pub(crate) enum RotationWord as "one of rx, ry, rz" {
        Rx = "rx",
        Ry = "ry",
        Rz = "rz",
    }
}

record! {
    pub(crate) struct Hinge as "a hinge" {
        /// The free axis, in global directions.
        hinge: Spanned<Vec<Number>>,
    }
}

/// What is free at one end of a member.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum EndRelease {
    Word(PinWord),
    Axes(Vec<RotationWord>),
    Hinge(Hinge),
}

impl Input for EndRelease {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        match value.kind {
            Kind::Array(_) => Vec::read(value, errors).map(Self::Axes),
            Kind::Table(_) => Hinge::read(value, errors).map(Self::Hinge),
            _ => PinWord::read(value, errors).map(Self::Word),
        }
    }
}

words! {
    /// Displacements and rotations of a node.
    pub(crate) enum Component as "one of ux, uy, uz, rx, ry, rz" {
        Ux = "ux",
        Uy = "uy",
        Uz = "uz",
        Rx = "rx",
        Ry = "ry",
        Rz = "rz",
    }
}

impl Component {
    pub(crate) fn index(self) -> usize {
        self as usize
    }
}

words! {
    pub(crate) enum SupportWord as "a support: \"clamped\", \"pinned\", or a list of ux uy uz rx ry rz" {
        /// Nothing moves.
        Clamped = "clamped",
        /// Only rotations are free.
        Pinned = "pinned",
    }
}

/// Components that are held.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum Fix {
    Word(SupportWord),
    List(Vec<Component>),
}

impl Input for Fix {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        match value.kind {
            Kind::Array(_) => Vec::read(value, errors).map(Self::List),
            _ => SupportWord::read(value, errors).map(Self::Word),
        }
    }
}

record! {
    /// A support in turned axes.
    pub(crate) struct TurnedSupport as "a support" {
        fix: Fix,
        /// Direction of its x axis; its y axis is global z × x, or global y where x is along z.
        x_axis: Option<Spanned<Vec<Number>>>,
    }
}

/// What holds a node.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum Support {
    Fix(Fix),
    Turned(TurnedSupport),
}

impl Input for Support {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        match value.kind {
            Kind::Table(_) => TurnedSupport::read(value, errors).map(Self::Turned),
            _ => Fix::read(value, errors).map(Self::Fix),
        }
    }
}

record! {
    /// Nodes that move as one.
    pub(crate) struct RigidBody as "a rigid body" {
        nodes: Spanned<Vec<Spanned<String>>>,
        /// The node whose motion is that of the body; the first of its nodes by default.
        reference: Option<Spanned<String>>,
        mass: Option<Number>,
    }
}

record! {
    /// A spring from a node to the ground, or between two nodes.
    pub(crate) struct Spring as "a spring" {
        node: Option<Spanned<String>>,
        nodes: Option<Spanned<Vec<Spanned<String>>>>,
        stiffness: Spanned<SpringStiffness>,
        /// Of an axial spring; the distance of its nodes by default.
        natural_length: Option<Number>,
    }
}

/// One stiffness along the line between two nodes, or one for each component.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum SpringStiffness {
    Axial(Number),
    Components(Box<Components>),
}

impl Input for SpringStiffness {
    fn read(value: &Value, errors: &mut Vec<InputError>) -> Option<Self> {
        match value.kind {
            Kind::Table(_) => Components::read(value, errors).map(|all| Self::Components(Box::new(all))),
            _ => Number::read(value, errors).map(Self::Axial),
        }
    }
}

record! {
    /// Values by component.
    pub(crate) struct Components as "a table of ux uy uz rx ry rz" {
        ux: Option<Number>,
        uy: Option<Number>,
        uz: Option<Number>,
        rx: Option<Number>,
        ry: Option<Number>,
        rz: Option<Number>,
    }
}

impl Components {
    /// The values in the order ux uy uz rx ry rz.
    pub(crate) fn in_order(&self) -> [&Option<Number>; 6] {
        [&self.ux, &self.uy, &self.uz, &self.rx, &self.ry, &self.rz]
    }
}

/// The JSON Schema of the network file.
pub fn schema() -> serde_json::Value {
    let mut schema = schemars::schema_for!(Network);
    schema.insert("title".to_owned(), "pennate network".into());
    schema.to_value()
}
