//! Rotations: unit quaternions, rotation vectors, and the maps between them.
//!
//! A quaternion is stored as `[w, x, y, z]`. Spins φ are spatial: the new rotation is exp(φ) R.

use crate::real::Real;
use crate::small::{M3, V3, add, cross, diagonal, dot, madd, mscale, mul, norm, outer, scale, skew};

/// A unit quaternion `[w, x, y, z]`.
pub type Quaternion<T> = [T; 4];

/// No rotation.
pub const IDENTITY: Quaternion<f64> = [1.0, 0.0, 0.0, 0.0];

/// Product of two rotations, `b` first.
#[inline(always)]
pub fn compose<T: Real>(a: Quaternion<T>, b: Quaternion<T>) -> Quaternion<T> {
    let (av, bv) = ([a[1], a[2], a[3]], [b[1], b[2], b[3]]);
    let v = add(add(scale(a[0], bv), scale(b[0], av)), cross(av, bv));
    [a[0] * b[0] - dot(av, bv), v[0], v[1], v[2]]
}

/// The rotation back.
#[inline(always)]
pub fn inverse<T: Real>(q: Quaternion<T>) -> Quaternion<T> {
    [q[0], -q[1], -q[2], -q[3]]
}

/// Angle of a rotation, 0 to π radians.
pub fn angle(q: Quaternion<f64>) -> f64 {
    2.0 * norm([q[1], q[2], q[3]]).atan2(q[0].abs())
}

/// R y − y, without the cancellation of forming R y first.
#[inline(always)]
pub fn turn_less_identity<T: Real>(q: Quaternion<T>, y: V3<T>) -> V3<T> {
    let b = [q[1], q[2], q[3]];
    let by = cross(b, y);
    scale(T::splat(2.0), add(scale(q[0], by), cross(b, by)))
}

/// R y
#[inline(always)]
pub fn turn<T: Real>(q: Quaternion<T>, y: V3<T>) -> V3<T> {
    add(y, turn_less_identity(q, y))
}

/// The rotation matrix, by rows.
#[inline(always)]
pub fn matrix<T: Real>(q: Quaternion<T>) -> M3<T> {
    let [w, x, y, z] = q;
    let two = T::splat(2.0);
    let one = T::one();
    [
        [one - two * (y * y + z * z), two * (x * y - w * z), two * (x * z + w * y)],
        [two * (x * y + w * z), one - two * (x * x + z * z), two * (y * z - w * x)],
        [two * (x * z - w * y), two * (y * z + w * x), one - two * (x * x + y * y)],
    ]
}

/// Gibbs vector tan(θ/2) n of the rotation that leads from `a` to `b`, in axes that turn with `a`.
#[inline(always)]
pub fn relative_gibbs<T: Real>(a: Quaternion<T>, b: Quaternion<T>) -> V3<T> {
    let r = compose(inverse(a), b);
    let f = T::one() / r[0];
    [r[1] * f, r[2] * f, r[3] * f]
}

/// Exponential of a spin, as a quaternion.
#[inline(always)]
pub fn exp<T: Real>(spin: V3<T>) -> Quaternion<T> {
    // Half the spin is halved until it is small, then sine and cosine come from `sin_cos`; the quotient sin(x)/x keeps
    // its digits near zero because the square under the root is shifted by less than rounding.
    let half = scale(T::splat(0.5), spin);
    let length = (dot(half, half) + T::splat(1e-60)).sqrt();
    let (sin, cos) = length.sin_cos();
    let f = sin / length;
    [cos, half[0] * f, half[1] * f, half[2] * f]
}

/// Rotation vector of norm at most π.
pub fn log(q: Quaternion<f64>) -> V3<f64> {
    let sign = if q[0] < 0.0 { -1.0 } else { 1.0 };
    let v = [sign * q[1], sign * q[2], sign * q[3]];
    let n = norm(v);
    if n < 1e-150 {
        return scale(2.0, v);
    }
    scale(2.0 * n.atan2(sign * q[0]) / n, v)
}

/// Scales the quaternion back to unit length.
#[inline(always)]
pub fn normalize<T: Real>(q: Quaternion<T>) -> Quaternion<T> {
    let n = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    let f = T::one() / n.sqrt();
    [q[0] * f, q[1] * f, q[2] * f, q[3] * f]
}

/// Tangent map of the exponential: the spin φ = T(θ) δθ by which exp(θ + δθ) = exp(φ) exp(θ).
///
/// T = I + a skew(θ) + b skew(θ)², with a = (1 − cos θ)/θ² and b = (θ − sin θ)/θ³. Below θ = 0.01 the series of the two factors is
/// used, since their closed forms cancel.
pub fn tangent_map(theta: V3<f64>) -> M3<f64> {
    let [a, b] = tangent_factors(dot(theta, theta));
    let s = skew(theta);
    madd(diagonal(1.0), madd(mscale(a, s), mscale(b, mul(&s, &s))))
}

/// How T(θ) `of` changes with θ `along` a vector: the derivative of [`tangent_map`].
///
/// Where c is the vector along, (a skew(c) + b (skew(c) skew(θ) + skew(θ) skew(c)) + (θ·c) (a' skew(θ) + b' skew(θ)²)) `of`, with the
/// derivatives by θ²/2 a' = (θ sin θ − 2 (1 − cos θ))/θ⁴ and b' = (3 sin θ − θ (2 + cos θ))/θ⁵.
pub fn tangent_slope(theta: V3<f64>, along: V3<f64>, of: V3<f64>) -> V3<f64> {
    let square = dot(theta, theta);
    let [a, b] = tangent_factors(square);
    let [da, db] = if square < 1e-3 {
        let [in_a, in_b] = [[-1.0 / 12.0, 1.0 / 180.0, -1.0 / 6720.0], [-1.0 / 60.0, 1.0 / 1260.0, -1.0 / 60480.0]];
        [series(in_a, square), series(in_b, square)]
    } else {
        let angle = square.sqrt();
        let (sin, cos) = angle.sin_cos();
        let fourth = square * square;
        [(angle * sin - 2.0 * (1.0 - cos)) / fourth, (3.0 * sin - angle * (2.0 + cos)) / (fourth * angle)]
    };
    let turned = cross(theta, of);
    let factors = scale(dot(theta, along), add(scale(da, turned), scale(db, cross(theta, turned))));
    let twice = add(cross(along, turned), cross(theta, cross(along, of)));
    add(factors, add(scale(a, cross(along, of)), scale(b, twice)))
}

/// The factors a and b of the tangent map, from the square of the angle.
fn tangent_factors(square: f64) -> [f64; 2] {
    if square < 1e-4 {
        return [
            series([0.5, -1.0 / 24.0, 1.0 / 720.0], square),
            series([1.0 / 6.0, -1.0 / 120.0, 1.0 / 5040.0], square),
        ];
    }
    let angle = square.sqrt();
    [(1.0 - angle.cos()) / square, (angle - angle.sin()) / (square * angle)]
}

/// The first three terms of a series.
fn series([first, second, third]: [f64; 3], x: f64) -> f64 {
    first + x * (second + x * third)
}

/// Half the sum of a bᵀ and b aᵀ, less (a·b) I: the second variation of a·(exp(φ) b) in the chart of spins.
#[inline(always)]
pub fn second_variation<T: Real>(a: V3<T>, b: V3<T>) -> M3<T> {
    let half = T::splat(0.5);
    madd(mscale(half, madd(outer(a, b), outer(b, a))), diagonal(-dot(a, b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::small::{apply, sub};

    #[test]
    fn logarithm_inverts_exponential_up_to_a_turn() {
        for theta in [[0.3, -0.2, 0.9], [1e-9, 0.0, 2e-9], [0.0, 0.0, 0.0], [1.7, 2.0, -1.2]] {
            assert!(norm(sub(log(exp(theta)), theta)) < 1e-14);
        }
    }

    #[test]
    fn tangent_map_is_the_derivative_of_the_exponential() {
        for theta in [[0.4, -0.7, 1.1], [3e-3, 1e-3, -2e-3], [2.0, 2.5, 1.0]] {
            let direction = [0.2, 0.5, -0.3];
            let h = 1e-5;
            let ahead = exp(add(theta, scale(h, direction)));
            let behind = exp(add(theta, scale(-h, direction)));
            let spin = scale(0.5 / h, log(compose(ahead, inverse(behind))));
            assert!(norm(sub(spin, apply(&tangent_map(theta), &direction))) < 1e-9);
        }
    }

    #[test]
    fn tangent_slope_is_the_derivative_of_the_tangent_map() {
        let (along, of) = ([0.3, -0.4, 0.8], [-0.6, 0.2, 0.5]);
        // Of both forms, on either side of where one takes over, and at none.
        let thetas = [
            [0.4, -0.7, 1.1],
            [2.0, 2.5, 1.0],
            [0.0; 3],
            [0.02, -0.01, 0.021],
            [0.02, -0.01, 0.023],
            [3e-3, 6e-3, 7e-3],
        ];
        for theta in thetas {
            // Differences of fourth order.
            let h = 1e-2;
            let at = |times: f64| apply(&tangent_map(add(theta, scale(times * h, along))), &of);
            let [near, far] = [sub(at(1.0), at(-1.0)), sub(at(2.0), at(-2.0))];
            let expected = scale(1.0 / h, add(scale(2.0 / 3.0, near), scale(-1.0 / 12.0, far)));
            let found = tangent_slope(theta, along, of);
            assert!(norm(sub(found, expected)) < 1e-9, "{theta:?}: {found:?}, {expected:?}");
        }
    }

    #[test]
    fn matrix_and_quaternion_turn_alike() {
        let q = exp([0.4, 1.2, -2.0]);
        let y = [0.3, -1.0, 0.7];
        assert!(norm(sub(apply(&matrix(q), &y), turn(q, y))) < 1e-15);
    }
}
