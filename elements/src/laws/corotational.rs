//! The corotational beam: two nodes, small strains in a frame that follows the mean rotation of both.
//!
//! With the chord x between the nodes, h the unloaded length, R the rotation half way from the first node to the last,
//! θ the rotation vector of the last against the first, and A the unloaded axes at the middle, the strains are those of
//! a Reissner beam at one point,
//! ```text
//! Γ − Γ₀ = Aᵀ (Rᵀ x − x₀)/h       κ − κ₀ = Aᵀ θ/h
//! W/h = ½ EA (Γ₁ − ε*)² + ½ GA₂* Γ₂² + ½ GA₃* Γ₃² + ½ Σ EI (κ − κ*)²
//! 1/GA₂* = 1/GA₂ + |x|²/12EI₃     1/GA₃* = 1/GA₃ + |x|²/12EI₂
//! ```
//! For a straight element in the plane that is Γ₁ = λ cos γ − 1 and Γ₂ = −λ sin γ with the stretch λ = |x|/h and the
//! mean rotation of the nodes against the chord γ. The bending moment within the element changes by the shear force
//! times the lever in the *stretched* element: ∫ M²/2EI dS = h (M² + |x|² Q²/12)/2EI, M at the middle. This is where the
//! second part of the shear compliance comes from, and why a shear-rigid element is not rigid against Γ₂. With h in the
//! place of |x|, or with the shear angle Φ of the linear Timoshenko beam, the element converges to another rod as soon
//! as that is stretched or contracts. Nodal errors fall with h².
//!
//! An axial force N in tension acts on the mean rotation against the chord as on a shear angle: once it exceeds about
//! GA* = 12EI/|x|², h about √(12 EI/N), the element gives way sideways. It has to resolve what bending of a stretched
//! rod there is at its ends anyway, of the length √(EI/N).
//!
//! Half a rotation by θ about n has the Gibbs vector g = tan(θ/4) n = α c, where c = tan(θ/2) n is the local unknown
//! and α = 1/(1 + q), q² = 1 + c·c. The rotation vector is θ n = 2β c, β = 2α B(g·g) with B(x²) = arctan(x)/x.
//!
//! The frame: M. A. Crisfield, G. F. Moita, Int. J. Solids Struct. 33 (1996), mean rotation of the two nodes;
//! the flexibility of a linear moment: J. S. Przemieniecki, Theory of Matrix Structural Analysis (1968), ch. 5.
//!
//! Theory: docs/theory/frames.md, Eq. 2.4 to 2.7.

use super::{About, Formulation, LocalLaw, Softening};
use crate::beam::{Moduli, Piece};
use crate::real::Real;
use crate::small::{M3, V3, add, axpy, cross, diagonal, dot, madd, mscale, mul, outer, scale, tapply, tmul};
use crate::space::{self, Geometric, Kinematics};

/// The corotational law, for elements of order 1.
#[derive(Clone, Copy, Debug)]
pub struct Corotational;

/// A function f of s = e·e with its first two derivatives.
#[derive(Clone, Copy, Debug)]
struct Radial<T> {
    value: T,
    first: T,
    second: T,
}

impl<T: Real> Radial<T> {
    /// From the derivatives by q = √(1 + s).
    #[inline(always)]
    fn of_root(q: T, [value, by_q, by_qq]: [T; 3]) -> Self {
        let half = T::splat(0.5) / q;
        Self { value, first: half * by_q, second: half * half * (by_qq - by_q / q) }
    }

    /// Derivative of f e with respect to e.
    #[inline(always)]
    fn jacobian(&self, e: V3<T>) -> M3<T> {
        madd(diagonal(self.value), mscale(T::splat(2.0) * self.first, outer(e, e)))
    }

    /// Second derivative of f e·w with respect to e.
    #[inline(always)]
    fn curvature(&self, e: V3<T>, w: V3<T>) -> M3<T> {
        let along = dot(w, e);
        let two = T::splat(2.0);
        let mixed = madd(madd(outer(w, e), outer(e, w)), diagonal(along));
        madd(mscale(two * self.first, mixed), mscale(two * two * self.second * along, outer(e, e)))
    }
}

/// Squares of the positive points of Gauss–Legendre quadrature with 16 points on [−1, 1], and their weights.
///
/// arctan(x)/x is the integral of 1/(1 + x²t²) over [0, 1]. So it has its derivatives without cancellation or branches,
/// to rounding for elements that turn by less than 120 degrees, and to 1e-12 up to half a turn.
const ARCTANGENT: [[f64; 2]; 8] = [
    [0.095_012_509_837_637_44 * 0.095_012_509_837_637_44, 0.189_450_610_455_068_5],
    [0.281_603_550_779_258_9 * 0.281_603_550_779_258_9, 0.182_603_415_044_923_6],
    [0.458_016_777_657_227_4 * 0.458_016_777_657_227_4, 0.169_156_519_395_002_54],
    [0.617_876_244_402_643_8 * 0.617_876_244_402_643_8, 0.149_595_988_816_576_73],
    [0.755_404_408_355_003 * 0.755_404_408_355_003, 0.124_628_971_255_533_87],
    [0.865_631_202_387_831_7 * 0.865_631_202_387_831_7, 0.095_158_511_682_492_78],
    [0.944_575_023_073_232_6 * 0.944_575_023_073_232_6, 0.062_253_523_938_647_89],
    [0.989_400_934_991_649_9 * 0.989_400_934_991_649_9, 0.027_152_459_411_754_095],
];

/// B(y) = arctan(√y)/√y with its first two derivatives.
#[inline(always)]
fn arctangent<T: Real>(y: T) -> [T; 3] {
    let mut sum = [T::zero(); 3];
    for [square, weight] in ARCTANGENT {
        let square = T::splat(square);
        let inverse = T::one() / (T::one() + y * square);
        let term = T::splat(weight) * inverse;
        let slope = square * inverse;
        sum[0] += term;
        sum[1] += -(term * slope);
        sum[2] += T::splat(2.0) * term * slope * slope;
    }
    sum
}

/// α and β of the Gibbs vector e.
#[inline(always)]
fn halves<T: Real>(e: V3<T>) -> (Radial<T>, Radial<T>) {
    let s = dot(e, e);
    let q = (T::one() + s).sqrt();
    let a = T::one() / (T::one() + q);
    let (two, four) = (T::splat(2.0), T::splat(4.0));
    let (a2, a3) = (a * a, a * a * a);
    let [b, b1, b2] = arctangent(s * a2);
    let alpha = Radial::of_root(q, [a, -a2, two * a3]);
    // g·g = (q − 1)/(q + 1) has the derivatives 2α² and −4α³ by q.
    let by_q = two * a2 * (two * a * b1 - b);
    let by_qq = four * a3 * (b - four * a * b1 + two * a2 * b2);
    (alpha, Radial::of_root(q, [two * a * b, by_q, by_qq]))
}

impl LocalLaw for Corotational {
    const FORMULATION: Formulation = Formulation::Corotational;
    const ABOUT: About = About { word: "corotational", sheared_by_bending: true, elements: 8 };
    const HIGHER_ORDERS: bool = false;

    /// The unloaded chord over the length: seen from the middle, a rigid motion leaves it alone.
    #[inline(always)]
    fn unloaded<T: Real>(piece: &Piece<T>, _: V3<T>) -> V3<T> {
        scale(T::one() / piece.length, piece.chord)
    }

    /// At the middle, c is half the Gibbs vector e of the last node, and d = e/h.
    #[inline(always)]
    fn kinematics<T: Real>(u: V3<T>, unloaded: V3<T>, c: V3<T>, d: V3<T>, curved: Option<&M3<T>>) -> Kinematics<T> {
        let two = T::splat(2.0);
        let e = scale(two, c);
        let (alpha, beta) = halves(e);
        let zero = [T::zero(); 3];
        let point = space::kinematics(u, unloaded, scale(alpha.value, e), zero, curved);
        let gamma_c = mul(&point.gamma_c, &mscale(two, alpha.jacobian(e)));
        let kappa = scale(two * beta.value, d);
        let kappa_c = mscale(T::splat(8.0) * beta.first, outer(d, e));
        let kappa_d = diagonal(two * beta.value);
        let (kappa, kappa_c, kappa_d) = match curved {
            None => (kappa, kappa_c, kappa_d),
            Some(axes) => (tapply(axes, &kappa), tmul(axes, &kappa_c), tmul(axes, &kappa_d)),
        };
        Kinematics { gamma: point.gamma, kappa, gamma_v: point.gamma_v, gamma_c, kappa_c, kappa_d }
    }

    #[inline(always)]
    fn geometric<T: Real>(n: V3<T>, m: V3<T>, v: V3<T>, c: V3<T>, d: V3<T>) -> Geometric<T> {
        let (two, four) = (T::splat(2.0), T::splat(4.0));
        let e = scale(two, c);
        let (alpha, beta) = halves(e);
        let g = scale(alpha.value, e);
        let zero = [T::zero(); 3];
        let point = space::geometric(n, zero, v, g, zero);
        let map = mscale(two, alpha.jacobian(e));

        // w = ∂(n·Γ)/∂g with Γ = Rᵀ v and ∂Γ/∂g = skew(Γ) t (I − skew g).
        let t = two / (T::one() + dot(g, g));
        let gv = cross(g, v);
        let turned = add(v, scale(t, add(cross(g, gv), scale(-T::one(), gv))));
        let moment = cross(n, turned);
        let mut w = moment;
        axpy(&mut w, T::one(), cross(g, moment));
        let w = scale(t, w);

        let along = dot(m, d);
        // κ = 2β d: derivatives of 2β(4 c·c) m·d.
        let own = madd(diagonal(two * beta.first), mscale(four * beta.second, outer(e, e)));
        let cc = madd(tmul(&map, &mul(&point.cc, &map)), mscale(four, alpha.curvature(e, w)));
        Geometric {
            vc: mul(&point.vc, &map),
            cc: madd(cc, mscale(T::splat(8.0) * along, own)),
            dc: mscale(T::splat(8.0) * beta.first, outer(m, e)),
        }
    }

    #[inline(always)]
    fn gibbs<T: Real>(angle: T, curvature: T) -> [T; 2] {
        // The angle at the middle is half that of the last node, of which h times the curvature is the whole.
        let half = T::splat(0.5);
        let (sin, cos) = angle.sin_cos();
        let size = Real::max(angle.abs(), T::splat(f64::MIN_POSITIVE));
        let (sine, _) = size.sin_cos();
        [half * sin / cos, half * curvature * (sine / size) / cos]
    }

    #[inline(always)]
    fn stiffness<T: Real, const D: usize>(moduli: &Moduli<T, D>, square: T) -> [T; D] {
        let mut stiffness = moduli.stiffness;
        for k in 0..if D == 6 { 2 } else { 1 } {
            let compliance = T::one() / stiffness[1 + k] + moduli.softening[k] * square;
            stiffness[1 + k] = T::one() / compliance;
        }
        stiffness
    }

    #[inline(always)]
    fn softening<T: Real, const D: usize>(moduli: &Moduli<T, D>, stress: &[T; D]) -> Option<Softening<T>> {
        let mut softening = Softening { slope: [T::zero(); 2], pull: T::zero() };
        for k in 0..if D == 6 { 2 } else { 1 } {
            let per_force = moduli.softening[k] * stress[1 + k];
            softening.slope[k] = T::splat(2.0) * per_force;
            softening.pull += per_force * stress[1 + k];
        }
        Some(softening)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// β and α against arctangents and square roots, their derivatives against differences.
    #[test]
    fn half_rotations_have_their_closed_forms_and_derivatives() {
        for s in [1e-20, 1e-16, 0.02, 0.4, 2.9] {
            let at = |s: f64| halves([s.sqrt(), 0.0, 0.0]);
            let (alpha, beta) = at(s);
            let x: f64 = s.sqrt();
            assert!((alpha.value * x - (0.5 * x.atan()).tan()).abs() < 1e-15 * x.max(1e-3), "{s}");
            assert!((beta.value * x - x.atan()).abs() < 3e-16 + 2e-15 * x, "{s}: {} {}", beta.value * x, x.atan());
            let h = 1e-5 * (1.0 + s);
            if s < 2.0 * h {
                assert!((alpha.first + 0.125).abs() < 1e-14 && (beta.first + 1.0 / 3.0).abs() < 1e-14);
                assert!((alpha.second - 0.125).abs() < 1e-14 && (beta.second - 0.4).abs() < 1e-14);
                continue;
            }
            let (ahead, behind) = (at(s + h), at(s - h));
            for (f, a, b) in [(alpha, ahead.0, behind.0), (beta, ahead.1, behind.1)] {
                assert!((f.first - (a.value - b.value) / (2.0 * h)).abs() < 1e-9, "{s}");
                assert!((f.second - (a.first - b.first) / (2.0 * h)).abs() < 1e-9, "{s}");
            }
        }
    }
}
