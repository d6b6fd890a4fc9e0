//! The structure to be solved: nodes, members, supports, bodies, springs and what drives them.
//!
//! A [`Structure`] is fixed once built. Whatever moves during a solve, a pressure, a load, a prescribed
//! displacement, is a *drive* or a [`Change`] of a [`Step`]; every drive starts at zero and is moved along a
//! straight ramp from where the last step left it.

use std::fmt::Debug;
use std::sync::Arc;

pub use pennate_chains::Fibres;
pub use pennate_elements::laws::Formulation;
use pennate_elements::section::Section;

pub use crate::spring::Spring;

/// Index of a node in [`Structure::nodes`].
pub type NodeId = usize;
/// Index of a member in [`Structure::members`].
pub type MemberId = usize;
/// Index of a drive in [`Structure::drives`].
pub type DriveId = usize;

/// Whether the network is solved in the x-y plane (three unknowns a node) or in space (six).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// In the x-y plane: displacements along x and y, rotation about z.
    Plane,
    /// Three displacements and three rotations.
    Space,
}

/// In which space the stability of a plane network is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// In space: the out-of-plane tangent is factorized at every accepted increment too.
    Space,
    /// In the plane alone, because the user asked for it.
    Plane,
}

/// A network of slender members, ready to be solved. All quantities in one consistent system of units.
#[derive(Clone, Debug)]
pub struct Structure {
    /// Where it is solved.
    pub dimension: Dimension,
    /// Asked for; the solver falls back to [`Stability::Plane`] where the supports do not hold the unloaded
    /// network out of its plane, and says so in the history.
    pub stability: Stability,
    /// Reference positions; z = 0 in the plane.
    pub nodes: Vec<[f64; 3]>,
    /// Bars between nodes; [`MemberId`] counts them.
    pub members: Vec<Member>,
    /// Sections that segments refer to by index.
    pub laws: Vec<Arc<dyn SectionLaw>>,
    /// What the ground holds from the beginning.
    pub supports: Vec<Support>,
    /// Nodes that move as one.
    pub bodies: Vec<RigidBody>,
    /// Springs to the ground and between nodes.
    pub springs: Vec<Spring>,
    /// Values that steps move; [`DriveId`] counts them.
    pub drives: Vec<Drive>,
    /// Nodes whose compliance is wanted at every accepted state.
    pub compliances: Vec<ComplianceOf>,
    /// Members whose section forces along them are wanted at every accepted state.
    pub sections: Vec<MemberId>,
}

impl Structure {
    /// Whether no end of a member is released.
    pub(crate) fn is_welded(&self) -> bool {
        let is_welded = |release: &Release| matches!(release, Release::Welded);
        self.members.iter().all(|member| member.releases.iter().all(is_welded))
    }

    /// Whether any spring has a force where the nodes are unloaded.
    pub fn is_prestressed(&self) -> bool {
        self.springs.iter().any(|spring| spring.is_prestressed(&self.nodes))
    }
}

/// A node whose compliance is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComplianceOf {
    /// The node.
    pub node: NodeId,
    /// A direction of displacement (0, 1, 2) or rotation (3, 4, 5) in global axes that is let go where something holds
    /// it: what holds the node along it is what would feel its stiffness.
    pub along: [f64; 6],
}

/// A member: segments in a row from one node to another, meshed by elements of one order.
#[derive(Clone, Debug)]
pub struct Member {
    /// Start and end.
    pub nodes: [NodeId; 2],
    /// Unit vectors of the material axes 1, 2, 3 at the start, unloaded, in global axes.
    pub axes: [[f64; 3]; 3],
    /// At least one, in a row from start to end.
    pub segments: Vec<Segment>,
    /// Connection of the start and of the end to the node.
    pub releases: [Release; 2],
    /// The pressure or actuation that the section laws of this member are evaluated at.
    pub control: Option<DriveId>,
    /// Kind of the elements.
    pub formulation: Formulation,
    /// Polynomial order of the elements, 1 to 4; corotational elements have order 1.
    pub order: usize,
}

impl Member {
    /// Unloaded length.
    pub fn length(&self) -> f64 {
        self.segments.iter().map(|segment| segment.length).sum()
    }
}

/// A stretch of a member with one section and one initial curvature.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Unloaded length.
    pub length: f64,
    /// Number of elements, equally long.
    pub elements: usize,
    /// Index into [`Structure::laws`].
    pub law: usize,
    /// Twist and curvatures about axes 1, 2, 3 of the unloaded rod (1/length).
    pub initial_curvature: [f64; 3],
}

/// How the section of a segment follows the control (pressure or actuation) of its member.
pub trait SectionLaw: Debug + Send + Sync {
    /// Section and induced strains at a control value. Called once an increment, not in iterations.
    fn at(&self, control: f64) -> SectionState;

    /// The outermost fibres, where the section has a shape; strains of bending are those of these.
    fn fibres(&self) -> Fibres {
        Fibres::default()
    }

    /// Where the law has corners: that of the smooth piece that a control value lies on, at a corner the one below, which goes
    /// on beyond its ends. Derivatives are those of this piece.
    fn piece(&self, _control: f64) -> Option<Arc<dyn SectionLaw>> {
        None
    }
}

/// Section and induced strains at one value of the control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionState {
    /// Stiffnesses and masses.
    pub section: Section,
    /// Induced axial strain ε*, negative for a muscle that contracts.
    pub strain: f64,
    /// Induced twist and curvatures κ* about axes 1, 2, 3 (1/length).
    pub curvature: [f64; 3],
}

impl SectionState {
    /// All of its numbers in the order of the fields, each in the units of its own; [`SectionState::of_numbers`] is the way back.
    #[must_use]
    pub fn numbers(&self) -> [f64; 13] {
        let Section { ea, ga2, ga3, gj, ei2, ei3, mass_per_length, rotary_inertia: [about2, about3] } = self.section;
        let [twist, bend2, bend3] = self.curvature;
        [ea, ga2, ga3, gj, ei2, ei3, mass_per_length, about2, about3, self.strain, twist, bend2, bend3]
    }

    /// The section of numbers in the order of [`SectionState::numbers`].
    #[must_use]
    pub fn of_numbers(numbers: [f64; 13]) -> Self {
        let [ea, ga2, ga3, gj, ei2, ei3, mass_per_length, about2, about3, strain, curvature @ ..] = numbers;
        let section = Section { ea, ga2, ga3, gj, ei2, ei3, mass_per_length, rotary_inertia: [about2, about3] };
        Self { section, strain, curvature }
    }
}

/// Connection of a member's end to its node.
#[derive(Clone, Debug, PartialEq)]
pub enum Release {
    /// The end moves and turns with the node.
    Welded,
    /// All rotations of the end are free.
    Pin,
    /// Rotations about one or two axes are free: unit vectors in global axes, unloaded, turning with the node.
    Axes(Vec<[f64; 3]>),
}

/// Components ux uy uz rx ry rz of a node that are held.
#[derive(Clone, Debug)]
pub struct Support {
    /// The node that is held.
    pub node: NodeId,
    /// Which of ux uy uz rx ry rz are held.
    pub fixed: [bool; 6],
    /// Unit vectors along which the components are measured; the global axes unless the support is turned.
    pub axes: [[f64; 3]; 3],
}

/// Nodes that move as one rigid body.
#[derive(Clone, Debug)]
pub struct RigidBody {
    /// All nodes of the body, the reference included or not.
    pub nodes: Vec<NodeId>,
    /// The node whose motion is that of the body.
    pub reference: NodeId,
    /// At the reference.
    pub mass: f64,
}

/// A value that steps move. Component 0, 1, 2 is x, y, z in global axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// Pressure or actuation of the members that refer to it.
    Control,
    /// Dead force on a node.
    Force(NodeId, usize),
    /// Dead moment on a node.
    Moment(NodeId, usize),
    /// Force on a node that turns with it, given by its components in the unloaded state.
    FollowerForce(NodeId, usize),
    /// Moment on a node that turns with it, given by its components in the unloaded state.
    FollowerMoment(NodeId, usize),
    /// Acceleration that acts on every mass.
    Gravity(usize),
    /// Dead force per unloaded length along a member.
    Distributed(MemberId, usize),
}

/// One step: what moves, and where to.
#[derive(Clone, Debug, Default)]
pub struct Step {
    /// Absolute values that drives reach at the end of the step; the others stay.
    pub targets: Vec<(DriveId, f64)>,
    /// Changes of the constraints, made at the beginning of the step.
    pub changes: Vec<Change>,
    /// At least so many increments.
    pub min_increments: Option<usize>,
    /// How the step goes along its ramp.
    pub method: Method,
    /// Which way it takes at a bifurcation.
    pub branch: Branch,
    /// Where an arc-length step ends, besides the end of its ramp.
    pub stop: Option<Stop>,
}

impl Step {
    /// Nodes and components that it holds where they are, or moves on from there.
    pub fn kept(&self) -> impl Iterator<Item = (NodeId, usize)> {
        let stays = |change: &&Change| matches!(change, Change::Hold { .. } | Change::MoveBy { .. });
        self.changes.iter().filter(stays).map(Change::place)
    }
}

/// How a step goes along its ramp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// With the ramp, up to the first limit point.
    #[default]
    Newton,
    /// Along the arc of the path, through limit points.
    ArcLength,
    /// With the ramp, and from a lost equilibrium to the next stable one.
    Jump,
}

/// Which way a path takes at a bifurcation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Branch {
    /// Onto the branch that is stable, where there is one.
    #[default]
    Stable,
    /// Straight on, stable or not.
    Primary,
}

/// Where an arc-length step ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stop {
    /// A displacement (0, 1, 2, global axes) or rotation vector (3, 4, 5, radians) of a node reaches a value.
    At {
        /// The node.
        node: NodeId,
        /// 0, 1, 2 displacement along x, y, z; 3, 4, 5 rotation about them.
        component: usize,
        /// Length or radians.
        value: f64,
    },
    /// The fraction of the ramp reaches a value, from either side.
    Fraction(f64),
    /// So many increments have been made.
    Increments(usize),
}

/// A change of what holds a component of a node: 0, 1, 2 displacement, 3, 4, 5 rotation vector (radians).
/// Components are those of the node's support axes where the node has a turned support, else global.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// Held, and moved to this value (from the unloaded position) over the step.
    Prescribe {
        /// The node.
        node: NodeId,
        /// 0, 1, 2 displacement; 3, 4, 5 rotation vector.
        component: usize,
        /// Length or radians.
        to: f64,
    },
    /// Held where it is.
    Hold {
        /// The node.
        node: NodeId,
        /// 0, 1, 2 displacement; 3, 4, 5 rotation vector.
        component: usize,
    },
    /// Held, and moved by this much over the step.
    MoveBy {
        /// The node.
        node: NodeId,
        /// 0, 1, 2 displacement; 3, 4, 5 rotation vector.
        component: usize,
        /// Length or radians.
        by: f64,
    },
    /// No longer held; the reaction found falls to zero over the step.
    Free {
        /// The node.
        node: NodeId,
        /// 0, 1, 2 displacement; 3, 4, 5 rotation vector.
        component: usize,
    },
}

impl Change {
    /// The node whose hold changes, and the component: 0, 1, 2 displacement; 3, 4, 5 rotation vector.
    pub fn place(&self) -> (NodeId, usize) {
        let (Self::Prescribe { node, component, .. }
        | Self::Hold { node, component }
        | Self::MoveBy { node, component, .. }
        | Self::Free { node, component }) = *self;
        (node, component)
    }
}
