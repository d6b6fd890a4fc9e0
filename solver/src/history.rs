//! What happened during a solve: converged states with all that a user may ask of them.

use std::time::Duration;

pub use pennate_chains::member::{MemberShape, Peak, SectionForces, ShapeCell, ShapePoint, Variation};

use crate::error::NearMotion;
use crate::structure::{Dimension, MemberId, NodeId};

/// Everything that a solve brought, in the order of the steps.
#[derive(Clone, Debug, Default)]
pub struct History {
    /// In order; one of the prestress where no steps were given.
    pub steps: Vec<StepHistory>,
    /// How large the mesh is.
    pub mesh: MeshSize,
    /// The softest motion of the unloaded structure, where it was asked for and is nearly free.
    pub near_motion: Option<NearMotion>,
    /// Time that the refined states took (those of [`StepHistory::refined`]), by [`crate::options::Options::clock`].
    pub estimate: Duration,
}

/// Size of the discretization.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshSize {
    /// Nodes of all elements, interior ones among them.
    pub nodes: usize,
    /// Elements of all members.
    pub elements: usize,
    /// Free components of all nodes of elements.
    pub unknowns: usize,
}

/// How a step ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// It reached its end.
    Converged,
    /// It ended at a limit point.
    LimitPoint,
    /// It ended at a bifurcation.
    Bifurcation,
    /// No equilibrium was found further on.
    NotConverged,
    /// It was told to stop.
    Interrupted,
    /// A step before it did not reach its end.
    NotReached,
}

/// What became of a step.
#[derive(Clone, Debug)]
pub struct StepHistory {
    /// How it ended.
    pub status: Status,
    /// Part of the step's ramp that was reached, 0 to 1.
    pub fraction: f64,
    /// Part of the prestress at which the way to the first step ended before its ramp began; `None` where it came to an end.
    pub prestress: Option<f64>,
    /// Newton iterations and factorizations, tries that were given up included.
    pub iterations: usize,
    /// Factorizations of the tangent, those of increments that were taken back among them.
    pub factorizations: usize,
    /// Accepted states in order; the last is the state at the end of the step. Empty only where nothing converged.
    pub increments: Vec<Increment>,
    /// The same state on a mesh of the next order, where an estimate was asked for.
    pub refined: Option<Equilibrium>,
    /// Strain energy of every member that its elements are too coarse for, where an estimate was asked for.
    pub missing: Vec<f64>,
    /// How fast the last state accepted may vary along the elements of every member, where an estimate was asked for.
    pub variations: Vec<Vec<Variation>>,
    /// Whether the last state is stable; `None` where loads have no potential and masses are not known, and where rounding hides the sign of the lowest
    /// stiffness ([`Note::WithinRounding`]) or the mesh does ([`Note::TooCoarse`]).
    pub stable: Option<bool>,
    /// In which space that was judged.
    pub stability: Dimension,
    /// What small vibrations about the last state do, where its loads have no potential and masses are known: that is the
    /// verdict then.
    pub vibration: Option<Vibration>,
    /// Directions in which the last state is unstable, where that is defined; else pivots of the symmetric part.
    pub negative_pivots: usize,
    /// Singular points that were passed or ended the step, in order.
    pub critical_points: Vec<CriticalPoint>,
    /// Jumps to another equilibrium, in order.
    pub jumps: Vec<Jump>,
    /// Remarks of the solver that a user should read, one sentence each.
    pub notes: Vec<Note>,
    /// Why the step did not reach its end.
    pub failure: Option<Failure>,
}

impl StepHistory {
    /// One that has not begun.
    pub fn empty(stability: Dimension) -> Self {
        Self {
            status: Status::NotConverged,
            fraction: 0.0,
            prestress: None,
            iterations: 0,
            factorizations: 0,
            increments: Vec::new(),
            refined: None,
            missing: Vec::new(),
            variations: Vec::new(),
            stable: None,
            vibration: None,
            stability,
            negative_pivots: 0,
            critical_points: Vec::new(),
            jumps: Vec::new(),
            notes: Vec::new(),
            failure: None,
        }
    }
}

/// Small vibrations about a state without damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vibration {
    /// All mass of the network.
    pub mass: f64,
    /// The motion that grows fastest.
    pub growth: Growth,
    /// Estimated error of its frequency and rate, over the root of the sum of their squares: what elements of a lower order, and
    /// fewer motions, make of them.
    pub error: f64,
}

/// How a vibration grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Growth {
    /// Not at all: the state is stable.
    None,
    /// As e^(rate t), without swinging.
    Divergence {
        /// 1/time
        rate: f64,
    },
    /// As e^(rate t), while it swings.
    Flutter {
        /// Angular, rad/time
        frequency: f64,
        /// 1/time
        rate: f64,
    },
}

/// A remark on a step that is no failure.
#[derive(Clone, Debug, PartialEq)]
pub enum Note {
    /// The path touched a singular state at this fraction and went on without a change of sign.
    TouchedSingular {
        /// Of the ramp of the step.
        fraction: f64,
    },
    /// A moment in space has no potential: a node that it turns over and over takes energy from it without end.
    EndlessMoment {
        /// The node that turns.
        node: NodeId,
    },
    /// Nothing determines the axial forces of these members, which cannot be stretched.
    Undetermined {
        /// By index.
        members: Vec<MemberId>,
    },
    /// What bends these members would turn them about themselves, since both of their ends are pinned: one end is kept from it,
    /// and the state depends on the way there.
    TurnedAboutItself {
        /// By index.
        members: Vec<MemberId>,
    },
    /// These members would turn about themselves, since both of their ends are pinned and a load bends them about their stiffer axis:
    /// one end is kept from it, and what is shown is not stable.
    WouldTurn {
        /// By index.
        members: Vec<MemberId>,
    },
    /// Whether bars that are kept from turning about themselves would turn is not known: elements that tell have no such state.
    SpinsUnknown,
    /// Rotations of these nodes are kept from motions that no force should belong to, and take a moment.
    Untaken {
        /// By index.
        nodes: Vec<NodeId>,
    },
    /// Nothing resists turning a part of the network about the line that it lay on unloaded, and it has left that line: the direction in
    /// which it did is one of many.
    TurnsFreely {
        /// The nodes of the part.
        nodes: Vec<usize>,
        /// Along the line: unit vector in global axes.
        axis: [f64; 3],
    },
    /// The rotation of a node is held in part, and the step brings it to a whole turn or through it. That is the same rotation about any
    /// axis: what is held does not tell there how the node is turned.
    WholeTurn {
        /// The node that turns.
        node: NodeId,
        /// Whether the step ends, or stops, there.
        is_there: bool,
    },
    /// The sign of the lowest stiffness at the end of a step is smaller than what rounding can tell.
    WithinRounding,
    /// Elements of the next order lose stability where these do not, or the other way round, or lose most of the stiffness that is
    /// left: the end of a step is nearer to a singular state than these can tell.
    TooCoarse,
    /// So many motions are unstable that what was passed was counted, and not located.
    Crowded(Crowded),
    /// Small vibrations about the end of a step are not known: elements of another order, or a smaller space of motions, has others.
    VibrationsUnknown,
    /// Stability could only be judged in the plane: the supports do not hold the network out of it.
    StabilityInPlane,
    /// Stability could only be judged in the plane: a moment about z has no potential for rotations out of it.
    NoPotentialOutOfPlane,
}

/// Singular points of a step that were counted, and not located.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crowded {
    /// Pivots that changed their signs.
    pub changes: usize,
    /// Fraction of the ramp of the step from which on they were counted.
    pub from: f64,
    /// Fraction of the ramp up to which they were.
    pub to: f64,
    /// Negative pivots on elements of the next order at the end of the step, where they are others.
    pub other: Option<usize>,
}

/// A converged increment.
#[derive(Clone, Debug)]
pub struct Increment {
    /// Fraction of the step's ramp.
    pub fraction: f64,
    /// The state.
    pub state: Equilibrium,
    /// Shapes of all members, where asked for (`Options::shapes`), in the order of the members.
    pub shapes: Vec<MemberShape>,
}

/// An equilibrium in the user's quantities. Vectors are in global axes.
#[derive(Clone, Debug, Default)]
pub struct Equilibrium {
    /// By index, as in the structure.
    pub nodes: Vec<NodeState>,
    /// By index, as in the structure.
    pub members: Vec<MemberState>,
    /// Force of an axial spring (positive in tension), else the norm of the force; in the order of the springs.
    pub springs: Vec<f64>,
    /// Displacement and rotation of the nodes of [`crate::structure::Structure::compliances`] for unit forces and moments
    /// on them, by columns, with everything else free to follow; global axes. Not a number where members that cannot be stretched or
    /// sheared leave the node no motion along what is asked for.
    pub compliances: Vec<[[f64; 6]; 6]>,
    /// Section forces along the members of [`crate::structure::Structure::sections`], from start to end.
    pub sections: Vec<Vec<SectionForces>>,
    /// Strain energy, springs included.
    pub energy: f64,
    /// Norm of the condensed residual over the largest force (moments apart; the larger of both).
    pub residual: f64,
    /// Norm of all reactions plus all loads over the largest of them.
    pub balance: f64,
    /// The force and the moment that are left on any joint, reactions and loads included, over the largest of their kind: the larger of both. Unlike
    /// the residual it counts motions that no force should belong to.
    pub joint_balance: f64,
    /// What rounding may have moved; `None` where it was not asked for, or where a motion needs no force.
    pub rounding: Option<Rounding>,
}

/// Error that rounding leaves, estimated from the factors of the tangent: displacements, rotations, forces and moments.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rounding {
    /// Over the largest value of its kind; `None` for a kind that is rounding alone.
    pub errors: [Option<f64>; 4],
    /// The nodes where they are largest.
    pub nodes: [NodeId; 4],
}

impl Rounding {
    /// Decimal digits that are left of a kind.
    pub fn digits(&self, kind: usize) -> Option<f64> {
        self.errors[kind].map(|error| -error.log10())
    }

    /// The kind with the fewest digits, and these.
    pub fn worst(&self) -> Option<(usize, f64)> {
        let known = (0..4).filter_map(|kind| Some((kind, self.digits(kind)?)));
        known.min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// A node in a state; vectors are in global axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NodeState {
    /// From the unloaded position.
    pub displacement: [f64; 3],
    /// Rotation vector (radians), of norm at most π; zero where the node has no rotation of its own.
    pub rotation: [f64; 3],
    /// Total rotation about z, whole turns included (plane only).
    pub rotation_total: f64,
    /// Action of the support (or of what prescribes the motion) on the structure.
    pub reaction_force: [f64; 3],
    /// Its moment about the node.
    pub reaction_moment: [f64; 3],
}

/// A member in a state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MemberState {
    /// Length of the deformed centre line.
    pub length: f64,
    /// Axial force at the middle of the member, tension positive.
    pub axial_force: f64,
    /// Axial force at the start and at the end, tension positive.
    pub axial_force_ends: [f64; 2],
    /// Actions on the member at start and end: forces, then moments about the end points.
    pub end_forces: [[f64; 3]; 2],
    /// Moments on its start and its end, in global axes.
    pub end_moments: [[f64; 3]; 2],
    /// Value of the member's control (pressure or actuation); zero without one.
    pub control: f64,
    /// Axial strain that stresses the member, the induced one apart, where its size is largest; positive in tension.
    pub stretch: Peak,
    /// Largest strain that bending brings to a fibre, where sections have a shape; induced curvature apart.
    pub bending: Peak,
    /// Strain energy that elements of the next lower order lack: that of the highest mode of the strains of its elements.
    pub top_energy: f64,
}

/// A singular point that a path passed or stopped at.
#[derive(Clone, Debug, PartialEq)]
pub struct CriticalPoint {
    /// Limit point or bifurcation.
    pub kind: CriticalKind,
    /// Fraction of the step's ramp; an arc length may leave 0 to 1.
    pub fraction: f64,
    /// Whether it lies on the way to the first step, and the fraction is a part of the prestress.
    pub in_prestress: bool,
    /// Increments of the step that come before it on the path: fractions alone do not tell where a path turns back or jumps.
    pub increments_before: usize,
    /// Estimated discretization error of the fraction.
    pub error: Option<f64>,
    /// How well the fraction is located on its mesh: how far apart two locations of it are, or where it was not located the
    /// increment in which it lies. `None` for what is only known to lie near.
    pub located: Option<f64>,
    /// The node that moves most in the mode.
    pub node: NodeId,
    /// The member whose interior moves more than any node.
    pub member: Option<MemberId>,
    /// Whether a plane network loses stability out of its plane.
    pub sideways: bool,
    /// Displacement and rotation vector of every node in the mode, in global axes, the largest of these and of the middles one
    /// length of the network or one radian.
    pub mode: Vec<[f64; 6]>,
    /// The same of the middle of members that bend between their ends, where what gives way lies there.
    pub middles: Vec<(MemberId, [f64; 6])>,
}

/// A snap from a lost equilibrium to the next stable one, at constant loads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// Fraction of the step's ramp.
    pub fraction: f64,
    /// Strain energy and potential of the loads that were set free.
    pub released: f64,
    /// The farthest displacement of a node, or of the middle of a member.
    pub moved: f64,
    /// The node that moves most, or one of the member.
    pub node: NodeId,
    /// The member whose middle that is, where it moves far more than any node.
    pub member: Option<MemberId>,
}

/// What a path meets at a singular point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CriticalKind {
    /// The load has an extremum along the path.
    LimitPoint,
    /// Another path crosses.
    Bifurcation,
}

/// Why a step stopped short.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    /// Fraction of the ramp at which the last try failed.
    pub tried: f64,
    /// Where the residual of the last try is largest, and in which component (0 to 5).
    pub worst_node: Option<NodeId>,
    /// Component of that residual: 0, 1, 2 of force, 3, 4, 5 of moment, in global axes.
    pub worst_component: usize,
    /// Residual there, over the largest force or moment.
    pub worst_residual: f64,
    /// What it looks like.
    pub cause: Cause,
}

/// What a failure looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The equilibrium path turns back: no equilibrium nearby at a larger fraction.
    LimitPoint,
    /// Another equilibrium branches off and the present one loses its stability.
    Bifurcation,
    /// The same, out of the plane of a plane network.
    SidewaysBifurcation,
    /// Newton's iteration does not converge though the tangent is regular.
    StepTooSmall,
    /// The energy falls without bound: nothing holds the network beyond a limit point.
    Unbounded,
    /// Stiffness ratios exhaust double precision.
    IllConditioned,
    /// The path that is followed along its arc turned back and leads to many times the loads the other way.
    LeadsAway,
    /// The path that is followed along its arc does not come to the end of its ramp after thousands of increments.
    Endless,
    /// No finite axial force of this member, which cannot be stretched, is in equilibrium: its ends cannot come as near as
    /// they would where it bends.
    Overheld {
        /// By index.
        member: MemberId,
    },
    /// This member, which cannot be stretched, is pulled straight: its force grows without bound towards the limit point of the
    /// step, where its ends can go no further apart.
    Taut {
        /// By index.
        member: MemberId,
    },
    /// It was told to stop.
    Interrupted,
}
