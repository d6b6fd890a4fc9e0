//! The geometrically exact law.
//!
//! Theory: docs/theory/rod.md, Eq. 1.5 and 1.6.

use super::{About, Formulation, LocalLaw, Softening};
use crate::beam::{Moduli, Piece};
use crate::real::Real;
use crate::small::{M3, V3};
use crate::space::{self, Geometric, Kinematics};

/// The geometrically exact law: c is the rotation at the point, and the section what it is.
#[derive(Clone, Copy, Debug)]
pub struct Exact;

impl LocalLaw for Exact {
    const FORMULATION: Formulation = Formulation::Exact;
    const ABOUT: About = About { word: "exact", sheared_by_bending: false, elements: 1 };
    const HIGHER_ORDERS: bool = true;
    const SEEN_FROM: f64 = 0.5;

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
