//! What the chain of elements asks of a beam, in the plane and in space.
//!
//! An element of order P has nodes 0…P at equal distances of unloaded arclength. It works in a *local frame* that begins at its
//! first node and turns with the mean of both ends: unknowns of nodes 1…P are the displacement U against the unloaded shape
//! and the rotation against the first node, interpolated by Lagrange polynomials. Interior nodes live in the local frame for
//! good, so that only the two end nodes are ever seen from outside. With D components a node (3 in the plane, 6 in
//! space) a section has D strains and D stresses: Γ₁ Γ₂ κ₃ in the plane, Γ₁ Γ₂ Γ₃ κ₁ κ₂ κ₃ in space.
//!
//! **Mixed integration points.** Residual and solution are those of the displacement method; the geometric part of the
//! tangent uses section stresses extrapolated linearly from the last iterate (Magisano, Leonetti, Garcea, Comput.
//! Methods Appl. Mech. Engrg. 313, 2017). Where a stiffness is infinite the same number is the Lagrange multiplier of
//! the constraint, and the strain tends to zero for whatever auxiliary stiffness stands in its place.
//!
//! Theory: docs/theory/frames.md, Eq. 2.1 to 2.4; docs/theory/mixed-points.md, Eq. 6.1 to 6.4.

use std::fmt::Debug;

use crate::interpolation::Table;
use crate::laws::LocalLaw;
use crate::real::Real;
use crate::rotation::Quaternion;
use crate::small::{M3, V3};
use crate::{plane, space};

/// Geometry of one element, unloaded.
#[derive(Clone, Copy, Debug, Default)]
pub struct Piece<T> {
    /// Unloaded arclength.
    pub length: T,
    /// Material axes at the start, in global axes: row i is axis i.
    pub axes: M3<T>,
    /// Position of the last node against the first, in these axes.
    pub chord: V3<T>,
    /// Integral of the position along the unloaded curve less that of its interpolation, in these axes; zero for a
    /// straight element. Weight acts there.
    pub bulge: V3<T>,
}

/// Stiffness and rest strain of a section; a held component has its stress as an unknown.
///
/// The stress is C ε + h σ, with the mixed stress σ. Where h lies between zero and one, as for a strain that is stiff and not
/// held, it tends to C ε / (1 − h).
#[derive(Clone, Copy, Debug)]
pub struct Moduli<T, const D: usize> {
    /// Stiffness; for a held component the auxiliary stiffness of its multiplier.
    pub stiffness: [T; D],
    /// Induced strain.
    pub rest: [T; D],
    /// Part of the mixed stress that stays: one where the strain is held at its rest value (infinite stiffness).
    pub held: [T; D],
    /// h²/12EI₃ and h²/12EI₂: what bending within a corotational element adds to its shear compliances along axes 2
    /// and 3, for a unit of the squared stretch. Other elements do not ask for it.
    pub softening: [T; 2],
}

impl<T: Real, const D: usize> Default for Moduli<T, D> {
    fn default() -> Self {
        let o = T::zero();
        Self { stiffness: [T::one(); D], rest: [o; D], held: [o; D], softening: [o; 2] }
    }
}

/// What one element is evaluated at.
#[derive(Clone, Copy, Debug)]
pub struct At<'a, T, const D: usize, const P: usize> {
    /// Shape functions at the nodes and at the integration points.
    pub table: &'a Table<P>,
    /// Unloaded geometry.
    pub piece: &'a Piece<T>,
    /// Material axes at the Gauss points of an initially curved element, in those of its start: the columns.
    pub curved: Option<&'a [M3<T>; P]>,
    /// Stiffness and induced strains of the section.
    pub moduli: &'a Moduli<T, D>,
    /// Local unknowns of nodes 1…P.
    pub local: &'a [[T; D]; P],
    /// Mixed stresses at the Gauss points, in material axes.
    pub stress: &'a [[T; D]; P],
}

/// Gradient and tangent of the strain energy with respect to the local unknowns of nodes 1…P.
#[derive(Clone, Copy, Debug)]
pub struct Local<T, const D: usize, const P: usize> {
    /// Blocks `[i][j]` with j ≥ i.
    pub tangent: [[[[T; D]; D]; P]; P],
    /// Derivative of the energy by the D motions of each of the P nodes: forces, then moments.
    pub gradient: [[T; D]; P],
    /// Gradient at the last node computed with the mixed stresses: what turns with the frame in the tangent.
    pub mixed_end: [T; D],
    /// Strain energy.
    pub energy: T,
}

impl<T: Real, const D: usize, const P: usize> Local<T, D, P> {
    /// All zero.
    #[inline(always)]
    pub fn zero() -> Self {
        let o = T::zero();
        Self { tangent: [[[[o; D]; D]; P]; P], gradient: [[o; D]; P], mixed_end: [o; D], energy: o }
    }

    /// Sets the sums to zero; the tangent is written anew.
    #[inline(always)]
    pub fn clear(&mut self) {
        let o = T::zero();
        self.gradient = [[o; D]; P];
        self.mixed_end = [o; D];
        self.energy = o;
    }
}

/// Tangent and gradient of what is left after elimination: the last node's unknowns e, and the turn of the frame.
#[derive(Clone, Copy, Debug)]
pub struct Condensed<T, const D: usize> {
    /// Second derivatives of the energy by the D motions of the node.
    pub tangent: [[T; D]; D],
    /// Its derivative by them: forces, then moments.
    pub gradient: [T; D],
    /// Second derivatives by the node and by the elongation of the element.
    pub mixed_end: [T; D],
    /// Coupling to the turn of the frame, where loads along the element make one (in the plane column 0 alone).
    pub turn: Option<Turn<T, D>>,
}

/// Part of the tangent and gradient that belongs to the turn φ of the local frame.
#[derive(Clone, Copy, Debug)]
pub struct Turn<T, const D: usize> {
    /// Second derivatives by the D motions of the node and by the three of the frame.
    pub coupling: [[T; 3]; D],
    /// Second derivatives by those of the frame.
    pub tangent: M3<T>,
    /// First derivatives by those of the frame.
    pub gradient: V3<T>,
}

/// Tangent and gradient of two end nodes in global axes and spatial spins.
#[derive(Clone, Copy, Debug)]
pub struct Ends<T, const D: usize> {
    /// Stiffness of the first end, D by D, forces over displacements in global axes.
    pub k00: [[T; D]; D],
    /// Force on the first end over motions of the second.
    pub k01: [[T; D]; D],
    /// Stiffness of the second end.
    pub k11: [[T; D]; D],
    /// Internal force, then moment, on the first end.
    pub r0: [T; D],
    /// Internal force, then moment, on the second end.
    pub r1: [T; D],
}

/// A beam with D components a node.
pub trait Beam<T: Real, const D: usize>: Copy + Debug + Send + Sync + 'static {
    /// How it makes strains.
    type Law: LocalLaw;
    /// Displacement and rotation of a node against the unloaded state.
    type Pose: Copy + Debug + Default + Send + Sync + 'static;
    /// The local frame, and the last node seen from it.
    type Frame: Copy + Debug + Send + Sync;

    /// The frame of an element by the poses of its first and last node.
    fn frame(piece: &Piece<T>, first: &Self::Pose, last: &Self::Pose) -> Self::Frame;

    /// Local unknowns of the last node.
    fn last_local(frame: &Self::Frame) -> [T; D];

    /// Local unknowns of a node between the ends; `reference` is its unloaded place.
    fn local_at(piece: &Piece<T>, ends: [&Self::Pose; 2], node: &Self::Pose, reference: V3<T>) -> [T; D];

    /// Global force turned into the local frame.
    fn pull_back(frame: &Self::Frame, force: V3<T>) -> V3<T>;

    /// Energy and gradient, and the tangent where `TANGENT`.
    fn local<const P: usize, const TANGENT: bool>(at: &At<T, D, P>, out: &mut Local<T, D, P>);

    /// Stresses for a small change of the local unknowns, linear in it; held components keep their sum.
    fn extrapolate<const P: usize>(at: &At<T, D, P>, change: &[[T; D]; P]) -> [[T; D]; P];

    /// Strains at the Gauss points, in material axes, the induced part included.
    fn strains<const P: usize>(at: &At<T, D, P>) -> [[T; D]; P];

    /// From local unknowns of the last node to both end nodes in global axes; both tangents and gradients exact.
    fn expand(frame: &Self::Frame, condensed: &Condensed<T, D>) -> Ends<T, D>;

    /// The gradient part of [`Beam::expand`].
    fn expand_gradient(frame: &Self::Frame, gradient: &[T; D], turn: V3<T>) -> [[T; D]; 2];

    /// Linear change of the last node's local unknowns, and the turn of the frame, for changes of the end nodes.
    fn restrict(frame: &Self::Frame, first: &[T; D], last: &[T; D]) -> ([T; D], V3<T>);

    /// Local unknowns of the last node after a move: the displacement by its linear change `shift`, the rotation by the
    /// exponential of what the last node turns more than the first, so that no turn gets lost.
    fn moved(piece: &Piece<T>, ends: [&Self::Pose; 2], turns: [&[T; D]; 2], local: &[T; D], shift: &[T; D]) -> [T; D];

    /// The last node for these local unknowns, where the first one is known.
    fn last(piece: &Piece<T>, first: &Self::Pose, local: &[T; D]) -> Self::Pose;

    /// Displacement and small rotation (spatial) that lead from one pose to another.
    fn between(from: &Self::Pose, to: &Self::Pose) -> [T; D];

    /// Moves a node: displacement added, rotation by the exponential.
    fn advance(pose: &mut Self::Pose, change: &[T; D]);

    /// Columns by which a force on a node couples to the turn of the frame: `[d][k]` for component d and spin k.
    fn load_coupling(load: V3<T>) -> [[T; 3]; D];

    /// Gradient and tangent with respect to the turn of the frame of the potential of a force at a local position.
    fn load_turn(load: V3<T>, position: V3<T>) -> (V3<T>, M3<T>);

    /// Displacement of a node against the unloaded state.
    fn displacement(pose: &Self::Pose) -> V3<T>;

    /// How far one node is turned against another: a number that grows with the angle, see [`Beam::angle`].
    fn turned(a: &Self::Pose, b: &Self::Pose) -> T;

    /// The angle that belongs to it, radians.
    fn angle(turned: f64) -> f64;

    /// Placement of the node of one lane.
    fn pose(pose: &Self::Pose, lane: usize) -> Placement;

    /// Puts the node of one lane somewhere.
    fn set_pose(pose: &mut Self::Pose, lane: usize, placement: &Placement);

    /// How many numbers a pose has in each lane.
    const POSE: usize;

    /// Puts a pose in a row of [`Beam::POSE`] numbers for each lane.
    fn store_pose(pose: &Self::Pose, row: &mut [f64]);

    /// The pose that [`Beam::store_pose`] put in a row.
    fn load_pose(row: &[f64]) -> Self::Pose;
}

/// Where a point of an element is: by its unloaded local position and its local unknowns, and by those of the last node.
pub fn interior<const D: usize>(
    piece: &Piece<f64>,
    first: &Placement,
    last: &[f64; D],
    reference: V3<f64>,
    local: &[f64; D],
) -> Placement {
    if D == 3 {
        plane::interior(piece, first, last, reference, local)
    } else {
        space::interior(piece, first, last, reference, local)
    }
}

/// Displacement and rotation of one node of one member, in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Displacement from the unloaded position, in global axes.
    pub displacement: V3<f64>,
    /// Rotation from the unloaded frame, a unit quaternion (w, x, y, z).
    pub rotation: Quaternion<f64>,
    /// Angle about z with whole turns, kept in the plane alone.
    pub angle: f64,
}

impl Default for Placement {
    fn default() -> Self {
        Self { displacement: [0.0; 3], rotation: crate::rotation::IDENTITY, angle: 0.0 }
    }
}
