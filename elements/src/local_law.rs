//! What the formulations of a beam differ in, within one element.
//!
//! Nodes, frames, elimination and the loops over Gauss points are the same for all. A [`LocalLaw`] says how the local
//! unknowns make strains, and how stiff the section is against them. Everything here is resolved by the compiler: the
//! exact law leaves no trace in its kernels.

use std::fmt::Debug;

use crate::beam::{Formulation, Moduli, Piece};
use crate::real::Real;
use crate::small::{M3, V3};
use crate::space::{self, Geometric, Kinematics};

/// Strains at a Gauss point, and the stiffness against them.
pub trait LocalLaw: Copy + Debug + Send + Sync + 'static {
    /// The kind of the element.
    const FORMULATION: Formulation;

    /// What v = U′ + … begins with in the unloaded state, in the local frame, where the unloaded tangent is given.
    fn unloaded<T: Real>(piece: &Piece<T>, tangent: V3<T>) -> V3<T>;

    /// Strains and their derivatives with respect to U′ and to the interpolated Gibbs vector c and its slope d.
    fn kinematics<T: Real>(u: V3<T>, unloaded: V3<T>, c: V3<T>, d: V3<T>, curved: Option<&M3<T>>) -> Kinematics<T>;

    /// Second derivatives of n·Γ + m·κ, with n and m in axes turned back by the initial curvature.
    fn geometric<T: Real>(n: V3<T>, m: V3<T>, v: V3<T>, c: V3<T>, d: V3<T>) -> Geometric<T>;

    /// Components about z of c and d of a plane state, for its interpolated angle and curvature.
    fn gibbs<T: Real>(angle: T, curvature: T) -> [T; 2];

    /// Stiffness where v·v is `square`.
    fn stiffness<T: Real, const D: usize>(moduli: &Moduli<T, D>, square: T) -> [T; D];

    /// How that stiffness changes with v under these stresses; `None` where it does not.
    fn softening<T: Real, const D: usize>(moduli: &Moduli<T, D>, stress: &[T; D]) -> Option<Softening<T>>;
}

/// Effect of shear compliances a + b v·v, one along axis 2 and one along axis 3, under the mixed shear forces q.
///
/// The energy q Γ − ½ (a + b v·v) q² of one of them is linearized in v and q. With the force Q of the present strain,
/// ```text
/// gradient   Q ∂Γ − (2 q Q − q²) b v            −b q² v once Q is q
/// tangent    (∂Γ − 2 b q v)(∂Γ − 2 b q v)ᵀ/(a + b v·v) + q ∂²Γ − b q² I
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Softening<T> {
    /// 2 b q
    pub slope: [T; 2],
    /// Σ b q²
    pub pull: T,
}

/// The geometrically exact law: c is the rotation at the point, and the section what it is.
#[derive(Clone, Copy, Debug)]
pub struct Exact;

impl LocalLaw for Exact {
    const FORMULATION: Formulation = Formulation::Exact;

    #[inline(always)]
    fn unloaded<T: Real>(_: &Piece<T>, tangent: V3<T>) -> V3<T> {
        tangent
    }

    #[inline(always)]
    fn kinematics<T: Real>(u: V3<T>, unloaded: V3<T>, c: V3<T>, d: V3<T>, curved: Option<&M3<T>>) -> Kinematics<T> {
        space::kinematics(u, unloaded, c, d, curved)
    }

    #[inline(always)]
    fn geometric<T: Real>(n: V3<T>, m: V3<T>, v: V3<T>, c: V3<T>, d: V3<T>) -> Geometric<T> {
        space::geometric(n, m, v, c, d)
    }

    #[inline(always)]
    fn gibbs<T: Real>(angle: T, curvature: T) -> [T; 2] {
        let half = T::splat(0.5);
        let (sin, cos) = (half * angle).sin_cos();
        let c = sin / cos;
        [c, half * (T::one() + c * c) * curvature]
    }

    #[inline(always)]
    fn stiffness<T: Real, const D: usize>(moduli: &Moduli<T, D>, _: T) -> [T; D] {
        moduli.stiffness
    }

    #[inline(always)]
    fn softening<T: Real, const D: usize>(_: &Moduli<T, D>, _: &[T; D]) -> Option<Softening<T>> {
        None
    }
}
