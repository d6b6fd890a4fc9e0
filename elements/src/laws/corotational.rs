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
//! The frame of the element turns with R, and half a rotation by θ about n has the Gibbs vector c = tan(θ/4) n, half the local
//! unknown of the last node. So Γ − Γ₀ = Aᵀ U′, and the rotation vector is θ n = 4 B(c·c) c with B(x²) = arctan(x)/x.
//!
//! The frame: M. A. Crisfield, G. F. Moita, Int. J. Solids Struct. 33 (1996), mean rotation of the two nodes;
//! the flexibility of a linear moment: J. S. Przemieniecki, Theory of Matrix Structural Analysis (1968), ch. 5.
//!
//! Theory: docs/theory/frames.md, Eq. 2.5 to 2.8.

use super::{About, Formulation, LocalLaw, Softening};
use crate::beam::{Moduli, Piece};
use crate::real::Real;
use crate::small::{M3, V3, diagonal, dot, identity, madd, mscale, outer, scale, tapply, tmul, transpose, zeros};
use crate::space::{Geometric, Kinematics};

/// The corotational law, for elements of order 1.
#[derive(Clone, Copy, Debug)]
pub struct Corotational;

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

impl LocalLaw for Corotational {
    const FORMULATION: Formulation = Formulation::Corotational;
    const ABOUT: About = About { word: "corotational", sheared_by_bending: true, elements: 8 };
    const HIGHER_ORDERS: bool = false;
    // Half of the unknown of the last node is what κ is made of.
    const SEEN_FROM: f64 = 0.0;

    /// The unloaded chord over the length: seen from the middle, a rigid motion leaves it alone.
    #[inline(always)]
    fn unloaded<T: Real>(piece: &Piece<T>, _: V3<T>) -> V3<T> {
        scale(T::one() / piece.length, piece.chord)
    }

    /// At the middle, c is the Gibbs vector of half the rotation, and d twice that over h.
    #[inline(always)]
    fn kinematics<T: Real>(u: V3<T>, _: V3<T>, c: V3<T>, d: V3<T>, curved: Option<&M3<T>>) -> Kinematics<T> {
        let (two, four) = (T::splat(2.0), T::splat(4.0));
        let [b, b1, _] = arctangent(dot(c, c));
        let kappa = scale(two * b, d);
        let kappa_c = mscale(four * b1, outer(d, c));
        let (kappa_d, gamma_v, gamma_c) = (diagonal(two * b), identity(), zeros());
        match curved {
            None => Kinematics { gamma: u, kappa, gamma_v, gamma_c, kappa_c, kappa_d },
            Some(axes) => Kinematics {
                gamma: tapply(axes, &u),
                kappa: tapply(axes, &kappa),
                gamma_v: transpose(axes),
                gamma_c,
                kappa_c: tmul(axes, &kappa_c),
                kappa_d: tmul(axes, &kappa_d),
            },
        }
    }

    #[inline(always)]
    fn geometric<T: Real>(_: V3<T>, m: V3<T>, _: V3<T>, c: V3<T>, d: V3<T>) -> Geometric<T> {
        let (two, four) = (T::splat(2.0), T::splat(4.0));
        let [_, b1, b2] = arctangent(dot(c, c));
        let along = four * dot(m, d);
        Geometric {
            vc: zeros(),
            cc: madd(diagonal(along * b1), mscale(two * along * b2, outer(c, c))),
            dc: mscale(four * b1, outer(m, c)),
        }
    }

    #[inline(always)]
    fn gibbs<T: Real>(angle: T, curvature: T) -> [T; 2] {
        // The angle at the middle is half that of the last node, of which h times the curvature is the whole.
        let (sin, cos) = (T::splat(0.5) * angle).sin_cos();
        let size = Real::max(angle.abs(), T::splat(f64::MIN_POSITIVE));
        let (sine, _) = (T::splat(0.5) * size).sin_cos();
        [sin / cos, curvature * (sine / size) / cos]
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

    /// B against the arctangent, its derivatives against differences.
    #[test]
    fn the_arctangent_has_its_derivatives() {
        for y in [1e-20, 1e-16, 0.005, 0.1, 0.33] {
            let x: f64 = y.sqrt();
            let [value, first, second] = arctangent::<f64>(y);
            assert!((value * x - x.atan()).abs() < 3e-16 + 2e-15 * x, "{y}: {} {}", value * x, x.atan());
            let h = 1e-5 * (1.0 + y);
            if y < 2.0 * h {
                assert!((first + 1.0 / 3.0).abs() < 1e-14 && (second - 0.4).abs() < 1e-14);
                continue;
            }
            let (ahead, behind) = (arctangent(y + h), arctangent(y - h));
            assert!((first - (ahead[0] - behind[0]) / (2.0 * h)).abs() < 1e-9, "{y}");
            assert!((second - (ahead[1] - behind[1]) / (2.0 * h)).abs() < 1e-9, "{y}");
        }
    }
}
