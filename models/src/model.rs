//! The checked description of a network: names resolved, units consistent, everything evaluated.
//!
//! Everything is in the unit system of the file, with three exceptions: pressures are in the pressure unit
//! of their muscle, angles are radians, and the values that a user reads (probes) show angles in degrees.

use std::sync::Arc;

use pennate_elements::section::Section;
use pennate_solver::structure::{self, Dimension, Formulation, NodeId, Release, Stability};

use crate::error::{Source, Span, Warning};
use crate::hsim::{Muscle, Part};
use crate::parameter::Parameter;
use crate::probes::Probes;
use crate::section::Shape;
use crate::unit;

/// Index of a member in [`Model::members`].
pub type MemberId = usize;

/// A network of muscles and members with its supports, its steps and the numbers wanted from it.
#[derive(Clone, Debug)]
pub struct Model {
    /// As the file has it; may be empty.
    pub title: String,
    /// Of all bare numbers here.
    pub units: Units,
    /// Whether the network is solved in the plane or in space.
    pub dimension: Dimension,
    /// Why the network is solved in space, where it is: a sentence to show to a user.
    pub why_space: Option<String>,
    /// Where a plane network's stability is judged.
    pub stability: Stability,
    /// Strain of a bar that is no muscle above which a person is warned.
    pub strain_limit: f64,
    /// In the order of the file.
    pub parameters: Vec<Parameter>,
    /// Those that were set from outside, as written there.
    pub settings: Vec<(String, String)>,
    /// In the order of the file; [`NodeId`] counts them.
    pub nodes: Vec<Node>,
    /// Kinds of muscle, each for any number of members.
    pub muscles: Vec<Arc<Muscle>>,
    /// In the order of the file.
    pub members: Vec<Member>,
    /// What the ground holds from the beginning.
    pub supports: Vec<structure::Support>,
    /// Copies of nodes that a support or a spring to the ground holds, made by patterns that copy neither; in order.
    pub let_go: Vec<NodeId>,
    /// Rigid bodies.
    pub bodies: Vec<Body>,
    /// In the order of the file.
    pub springs: Vec<Spring>,
    /// The steps of the file; empty where it has none, and the network is solved for its prestress alone.
    pub steps: Vec<Step>,
    /// The numbers wanted by name.
    pub probes: Probes,
    /// Where the network is driven and what it moves, where the file says so.
    pub load_flow: Option<LoadFlow>,
    /// What is remarkable about the file.
    pub warnings: Vec<Warning>,
    /// The texts that spans refer to: the network file first.
    pub sources: Vec<Source>,
}

/// Unit system of the bare numbers in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Units {
    /// Millimetre, newton, megapascal, tonne, second.
    #[default]
    MmNMpa,
    /// Metre, newton, pascal, kilogram, second.
    MNPa,
}

impl Units {
    /// The name used in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::MmNMpa => "mm-N-MPa",
            Self::MNPa => "m-N-Pa",
        }
    }

    /// Name of the unit of mass that goes with them.
    pub fn mass(self) -> &'static str {
        match self {
            Self::MmNMpa => "tonne",
            Self::MNPa => "kg",
        }
    }

    /// Names of the units of length, force and stress.
    pub fn symbols(self) -> [&'static str; 3] {
        match self {
            Self::MmNMpa => ["mm", "N", "MPa"],
            Self::MNPa => ["m", "N", "Pa"],
        }
    }
}

/// A named point.
#[derive(Clone, Debug)]
pub struct Node {
    /// As the file has it.
    pub name: String,
    /// Unloaded position.
    pub position: [f64; 3],
    /// Its place in the file.
    pub span: Span,
}

/// A physical bar between two nodes.
#[derive(Clone, Debug)]
pub struct Member {
    /// As the file has it.
    pub name: String,
    /// Its place in the file.
    pub span: Span,
    /// Start and end.
    pub nodes: [NodeId; 2],
    /// The name by which steps address it together with others.
    pub group: Option<String>,
    /// Muscle, actuated or passive.
    pub kind: MemberKind,
    /// Unloaded length along the centre line.
    pub length: f64,
    /// Unit vectors of the material axes 1, 2, 3 at the start, unloaded.
    pub axes: [[f64; 3]; 3],
    /// At least one; their lengths sum to that of the member.
    pub segments: Vec<Segment>,
    /// Connection of the start and of the end to the node.
    pub releases: [Release; 2],
    /// Kind of its elements.
    pub formulation: Formulation,
    /// Order of the elements asked for in the file.
    pub order: Option<usize>,
}

/// Whether a bar is inflated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemberKind {
    /// An HSIM muscle, controlled by its pressure: index into [`Model::muscles`].
    Muscle(usize),
    /// A bar with induced strains, controlled by its actuation.
    Actuated,
    /// A bar that nothing controls.
    Passive,
}

/// A stretch of a member with one section and one initial curvature.
#[derive(Clone, Debug)]
pub struct Segment {
    /// Unloaded length.
    pub length: f64,
    /// Its section, and how that follows the control.
    pub material: SegmentLaw,
    /// Twist and curvatures about axes 1, 2, 3 of the unloaded rod (1/length).
    pub initial_curvature: [f64; 3],
    /// Number of elements asked for in the file; such a segment is never refined.
    pub elements: Option<usize>,
}

/// What a segment is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum SegmentLaw {
    /// End segment of a muscle: index into [`Model::muscles`].
    MuscleEnd(usize),
    /// Middle segment of a muscle: index into [`Model::muscles`].
    MuscleMiddle(usize),
    /// A section that does not change.
    Fixed(FixedLaw),
}

/// A section with the strains that an actuation of one induces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedLaw {
    /// Stiffnesses and masses; constant.
    pub section: Section,
    /// Radius of the round bar drawn for it: outer radius; of a rectangle sqrt(width height/π); of stiffnesses
    /// given outright 2 sqrt(EI/EA), which is right for a solid circle.
    pub radius: f64,
    /// Shape of the section, where it is known: not of stiffnesses given outright.
    pub shape: Option<Shape>,
    /// Induced axial strain at actuation 1.
    pub strain: f64,
    /// Induced twist and curvatures at actuation 1 (1/length).
    pub curvature: [f64; 3],
}

/// Nodes that move as one.
#[derive(Clone, Debug)]
pub struct Body {
    /// As the file has it.
    pub name: String,
    /// Its place in the file.
    pub span: Span,
    /// All nodes of the body; the reference is the first.
    pub nodes: Vec<NodeId>,
    /// The node whose motion is that of the body.
    pub reference: NodeId,
    /// At the reference, in the file's unit of mass (tonnes or kilograms).
    pub mass: f64,
}

/// A spring to the ground or between two nodes.
#[derive(Clone, Debug)]
pub struct Spring {
    /// As the file has it.
    pub name: String,
    /// Its place in the file.
    pub span: Span,
    /// What it connects, and its stiffness.
    pub spring: structure::Spring,
}

/// One step: what moves, and where to.
#[derive(Clone, Debug)]
pub struct Step {
    /// As the file has it, or a number.
    pub name: String,
    /// Its place in the file.
    pub span: Span,
    /// Absolute values at the end of the step; what is not named stays.
    pub targets: Vec<(Target, f64)>,
    /// Changes of what holds the nodes; rotations in radians.
    pub changes: Vec<structure::Change>,
    /// At least so many increments.
    pub increments: Option<usize>,
    /// How the path is followed.
    pub method: structure::Method,
    /// Which branch is followed beyond a bifurcation.
    pub branch: structure::Branch,
    /// Where an arc-length step ends before its ramp does; rotations in radians.
    pub stop: Option<structure::Stop>,
}

/// Where a mechanism is driven, what it moves, and which muscle may take the place of its members.
#[derive(Clone, Debug)]
pub struct LoadFlow {
    /// Its place in the file.
    pub span: Span,
    /// Unit loads that act together; at least one.
    pub inputs: Vec<FlowInput>,
    /// Nodes that are moved; at least one.
    pub outputs: Vec<NodeId>,
    /// Members of the mechanism, in the order of the file.
    pub members: Vec<MemberId>,
    /// The muscle that replaces transmitters, an index into [`Model::muscles`]; `None` where the file has no muscle.
    pub muscle: Option<usize>,
    /// Pressure of these muscles, in their pressure unit.
    pub pressure: f64,
    /// Members shorter than this are not replaced.
    pub shortest: f64,
    /// What the replacement ends at, when all of them are met; empty where nothing is required.
    pub requirements: Vec<Requirement>,
}

/// Limits of a probe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Requirement {
    /// Index into the probes of the network.
    pub probe: usize,
    /// The least value that will do, in the units of the probe; minus infinity where there is none.
    pub least: f64,
    /// The largest value that will do.
    pub most: f64,
}

impl Requirement {
    /// Whether a value will do.
    pub fn is_met(&self, value: f64) -> bool {
        (self.least..=self.most).contains(&value)
    }
}

/// A unit force or moment on a node.
#[derive(Clone, Copy, Debug)]
pub struct FlowInput {
    /// Where it acts.
    pub node: NodeId,
    /// Force and moment along the global axes; one of them is a unit vector, the other zero.
    pub load: [f64; 6],
    /// Whether everything but the motion along the load is held; otherwise the supports of the file are what holds.
    pub guided: bool,
}

/// A quantity that steps move. Component 0, 1, 2 is x, y, z in global axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Target {
    /// Pressure of a muscle (in its pressure unit) or actuation of a member.
    Control(MemberId),
    /// Dead force on a node.
    Force(NodeId, usize),
    /// Dead moment on a node.
    Moment(NodeId, usize),
    /// Force that turns with its node.
    FollowerForce(NodeId, usize),
    /// Moment that turns with its node.
    FollowerMoment(NodeId, usize),
    /// Acceleration, in the file's units.
    Gravity(usize),
    /// Force per unloaded length.
    Distributed(MemberId, usize),
}

impl Model {
    /// Names of the steps in results: those of the file, or `prestress` alone.
    pub fn step_names(&self) -> Vec<&str> {
        if self.steps.is_empty() { vec![PRESTRESS] } else { self.steps.iter().map(|step| step.name.as_str()).collect() }
    }

    /// The axial strain at which a member would lose its stability in tension: where shear lets it, that is where
    /// N (1/GA - 1/EA) = 1 with N = EA ε.
    ///
    /// Linearized about a straight rod in tension N, the rotation φ of its sections obeys
    /// EI φ'' = N (1 + N/EA - N/GA) φ: from there on it may swing along a long rod.
    pub fn tensile_limit(&self, member: MemberId, control: f64) -> Option<f64> {
        let limit = |segment: &Segment| {
            let section = self.section(&segment.material, control);
            let ratio = section.ea / section.ga2.min(section.ga3);
            (ratio > 1.0 && ratio.is_finite()).then(|| 1.0 / (ratio - 1.0))
        };
        self.members[member].segments.iter().filter_map(limit).reduce(f64::min)
    }

    /// The force in tension at which a member that cannot be stretched, but sheared, would lose its stability: its shear stiffness.
    /// See [`Model::tensile_limit`], with 1/EA = 0.
    pub fn tensile_force(&self, member: MemberId, control: f64) -> Option<f64> {
        let force = |segment: &Segment| {
            let section = self.section(&segment.material, control);
            let shear = section.ga2.min(section.ga3);
            (section.ea.is_infinite() && shear.is_finite()).then_some(shear)
        };
        self.members[member].segments.iter().filter_map(force).reduce(f64::min)
    }

    fn section(&self, law: &SegmentLaw, control: f64) -> Section {
        match law {
            SegmentLaw::MuscleEnd(muscle) => self.muscles[*muscle].part(Part::End, control).0,
            SegmentLaw::MuscleMiddle(muscle) => self.muscles[*muscle].part(Part::Middle, control).0,
            SegmentLaw::Fixed(law) => law.section,
        }
    }

    /// Unit of the pressures in pictures, so that they compare like with like: that of the first muscle of the network. None where there
    /// are no muscles.
    pub fn pressure_unit(&self) -> Option<&str> {
        self.members.iter().find_map(|member| match member.kind {
            MemberKind::Muscle(muscle) => Some(self.muscles[muscle].pressure_unit.as_str()),
            _ => None,
        })
    }

    /// What pressures of each of [`Model::muscles`] are multiplied by in pictures, to be in that unit.
    pub fn pressure_factors(&self) -> Vec<f64> {
        let in_pascals = |unit: &str| unit::parse(unit).map_or(1.0, |unit| unit.factor);
        let shown = self.pressure_unit().map_or(1.0, in_pascals);
        self.muscles.iter().map(|muscle| in_pascals(&muscle.pressure_unit) / shown).collect()
    }

    /// Outer radius of a segment at a control value (pressure or actuation), for pictures.
    pub fn segment_radius(&self, member: MemberId, segment: usize, control: f64) -> f64 {
        match &self.members[member].segments[segment].material {
            SegmentLaw::MuscleEnd(muscle) => self.muscles[*muscle].at(control).end_radius,
            SegmentLaw::MuscleMiddle(muscle) => self.muscles[*muscle].at(control).middle_radius,
            SegmentLaw::Fixed(law) => law.radius,
        }
    }
}

impl Member {
    /// Whether the file leaves elements of the member to choose.
    pub fn has_free_elements(&self) -> bool {
        self.segments.iter().any(|segment| segment.elements.is_none())
    }

    /// Whether the member is a muscle.
    pub fn is_muscle(&self) -> bool {
        matches!(self.kind, MemberKind::Muscle(_))
    }

    /// Order of the elements, where `order` is that of members that do not ask for one.
    pub fn order(&self, order: usize) -> usize {
        if self.formulation.has_higher_orders() { self.order.unwrap_or(order) } else { 1 }
    }
}

/// Name of the only entry of results where a file has no steps.
pub const PRESTRESS: &str = "prestress";
