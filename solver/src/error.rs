//! Why a structure cannot be solved at all.

use crate::structure::{MemberId, NodeId};

/// A structure that has no solution to look for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// The unloaded structure can move without force.
    #[error("the structure is a mechanism: {} free motion(s)", .0.len())]
    Mechanism(Vec<FreeMotion>),
}

/// A motion that needs no force, described where it is largest.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeMotion {
    /// Where the motion is largest.
    pub place: Place,
    /// Unit direction of the motion there, or unit axis of the turn.
    pub direction: [f64; 3],
    /// Whether it is a turn; a displacement otherwise.
    pub turns: bool,
    /// All nodes that take part.
    pub nodes: Vec<NodeId>,
    /// How much of the structure moves as one.
    pub extent: Extent,
    /// A node on the axis of the turn of a part, where it is not the middle of the part.
    pub about: Option<NodeId>,
}

/// What moves as one rigid body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Nothing more than a node or a member.
    Local,
    /// A part that no member and no spring connects to the rest.
    Part,
    /// All of the structure.
    Whole,
}

/// A node or a member.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A node by its index.
    Node(NodeId),
    /// A member by its index.
    Member(MemberId),
}

/// A motion that next to nothing resists.
#[derive(Clone, Debug, PartialEq)]
pub struct NearMotion {
    /// How it goes.
    pub motion: FreeMotion,
    /// Its stiffness over that of its components one by one.
    pub stiffness: f64,
}
