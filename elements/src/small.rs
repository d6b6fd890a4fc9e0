//! Vectors and matrices of three, and blocks of D, generic over the scalar.
//!
//! Plain arrays, because the kernels must compile to straight-line code for numbers and for lanes alike. Matrices are
//! stored by rows.

use crate::real::Real;

pub type V3<T> = [T; 3];
pub type M3<T> = [[T; 3]; 3];

#[inline(always)]
pub fn dot<T: Real>(a: V3<T>, b: V3<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub fn cross<T: Real>(a: V3<T>, b: V3<T>) -> V3<T> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
pub fn add<T: Real, const N: usize>(a: [T; N], b: [T; N]) -> [T; N] {
    std::array::from_fn(|i| a[i] + b[i])
}

#[inline(always)]
pub fn sub<T: Real, const N: usize>(a: [T; N], b: [T; N]) -> [T; N] {
    std::array::from_fn(|i| a[i] - b[i])
}

#[inline(always)]
pub fn scale<T: Real, const N: usize>(s: T, a: [T; N]) -> [T; N] {
    std::array::from_fn(|i| s * a[i])
}

/// a += s b
#[inline(always)]
pub fn axpy<T: Real, const N: usize>(a: &mut [T; N], s: T, b: [T; N]) {
    for i in 0..N {
        a[i] += s * b[i];
    }
}

#[inline(always)]
pub fn norm<T: Real>(a: V3<T>) -> T {
    dot(a, a).sqrt()
}

/// The matrix of the cross product: skew(a) b = a × b.
#[inline(always)]
pub fn skew<T: Real>(a: V3<T>) -> M3<T> {
    let o = T::zero();
    [[o, -a[2], a[1]], [a[2], o, -a[0]], [-a[1], a[0], o]]
}

#[inline(always)]
pub fn identity<T: Real>() -> M3<T> {
    diagonal(T::one())
}

#[inline(always)]
pub fn diagonal<T: Real>(s: T) -> M3<T> {
    let o = T::zero();
    [[s, o, o], [o, s, o], [o, o, s]]
}

/// a bᵀ
#[inline(always)]
pub fn outer<T: Real>(a: V3<T>, b: V3<T>) -> M3<T> {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i] * b[j]))
}

#[inline(always)]
pub fn zeros<T: Real, const N: usize, const M: usize>() -> [[T; M]; N] {
    [[T::zero(); M]; N]
}

#[inline(always)]
pub fn madd<T: Real, const N: usize, const M: usize>(a: [[T; M]; N], b: [[T; M]; N]) -> [[T; M]; N] {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] + b[i][j]))
}

#[inline(always)]
pub fn mscale<T: Real, const N: usize, const M: usize>(s: T, a: [[T; M]; N]) -> [[T; M]; N] {
    std::array::from_fn(|i| std::array::from_fn(|j| s * a[i][j]))
}

/// diag(s) A
#[inline(always)]
pub fn scale_rows<T: Real, const N: usize, const M: usize>(s: [T; N], a: &[[T; M]; N]) -> [[T; M]; N] {
    let mut b = *a;
    for i in 0..N {
        b[i] = scale(s[i], a[i]);
    }
    b
}

#[inline(always)]
pub fn transpose<T: Real, const N: usize, const M: usize>(a: &[[T; M]; N]) -> [[T; N]; M] {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}

/// A B
#[inline(always)]
pub fn mul<T: Real, const N: usize, const K: usize, const M: usize>(a: &[[T; K]; N], b: &[[T; M]; K]) -> [[T; M]; N] {
    let mut c = zeros();
    for i in 0..N {
        for k in 0..K {
            for j in 0..M {
                c[i][j] += a[i][k] * b[k][j];
            }
        }
    }
    c
}

/// Aᵀ B
#[inline(always)]
pub fn tmul<T: Real, const N: usize, const K: usize, const M: usize>(a: &[[T; N]; K], b: &[[T; M]; K]) -> [[T; M]; N] {
    let mut c = zeros();
    for k in 0..K {
        for i in 0..N {
            for j in 0..M {
                c[i][j] += a[k][i] * b[k][j];
            }
        }
    }
    c
}

/// A v
#[inline(always)]
pub fn apply<T: Real, const N: usize, const M: usize>(a: &[[T; M]; N], v: &[T; M]) -> [T; N] {
    let mut r = [T::zero(); N];
    for i in 0..N {
        for j in 0..M {
            r[i] += a[i][j] * v[j];
        }
    }
    r
}

/// Aᵀ v
#[inline(always)]
pub fn tapply<T: Real, const N: usize, const M: usize>(a: &[[T; M]; N], v: &[T; N]) -> [T; M] {
    let mut r = [T::zero(); M];
    for i in 0..N {
        for j in 0..M {
            r[j] += a[i][j] * v[i];
        }
    }
    r
}

/// R A Rᵀ
#[inline(always)]
pub fn rotate<T: Real>(r: &M3<T>, a: &M3<T>) -> M3<T> {
    let ra = mul(r, a);
    let mut c = zeros();
    for i in 0..3 {
        for j in 0..3 {
            c[i][j] = ra[i][0] * r[j][0] + ra[i][1] * r[j][1] + ra[i][2] * r[j][2];
        }
    }
    c
}

/// Symmetric block factorized as L D Lᵀ without pivoting.
#[derive(Clone, Copy, Debug)]
pub struct Ldl<T, const D: usize> {
    /// Strict lower triangle: L.
    l: [[T; D]; D],
    inverse_pivots: [T; D],
    /// How many pivots are negative, lane by lane.
    pub negative: T,
    /// The smallest pivot over the diagonal entry it came from, in magnitude: zero for a singular block.
    pub smallest: T,
}

impl<T: Real, const D: usize> Ldl<T, D> {
    /// Factorizes the lower triangle of `a`.
    #[inline(always)]
    pub fn new(a: &[[T; D]; D]) -> Self {
        Self::with_noise(a, T::zero())
    }

    /// The same; a negative pivot counts as such only beyond `noise` times the diagonal entry it came from.
    #[inline(always)]
    pub fn with_noise(a: &[[T; D]; D], noise: T) -> Self {
        let mut l = *a;
        let mut inverse_pivots = [T::zero(); D];
        let mut pivots = [T::zero(); D];
        let mut negative = T::zero();
        let mut smallest = T::splat(f64::MAX);
        for j in 0..D {
            let mut pivot = l[j][j];
            for k in 0..j {
                pivot -= l[j][k] * l[j][k] * pivots[k];
            }
            negative += (pivot + noise * a[j][j].abs()).is_negative();
            let ratio = (pivot / (a[j][j].abs() + T::splat(f64::MIN_POSITIVE))).abs();
            smallest = -((-smallest).max(-ratio));
            pivots[j] = pivot;
            inverse_pivots[j] = T::one() / pivot;
            for i in j + 1..D {
                let mut entry = a[i][j];
                for k in 0..j {
                    entry -= l[i][k] * l[j][k] * pivots[k];
                }
                l[i][j] = entry * inverse_pivots[j];
            }
        }
        Self { l, inverse_pivots, negative, smallest }
    }

    /// Solves for every column of the right-hand side.
    #[inline(always)]
    pub fn solve<const M: usize>(&self, b: &[[T; M]; D]) -> [[T; M]; D] {
        let mut x = *b;
        for i in 1..D {
            for k in 0..i {
                let f = self.l[i][k];
                for m in 0..M {
                    let t = x[k][m];
                    x[i][m] -= f * t;
                }
            }
        }
        for i in 0..D {
            for m in 0..M {
                x[i][m] = x[i][m] * self.inverse_pivots[i];
            }
        }
        for i in (0..D).rev() {
            for k in i + 1..D {
                let f = self.l[k][i];
                for m in 0..M {
                    let t = x[k][m];
                    x[i][m] -= f * t;
                }
            }
        }
        x
    }

    #[inline(always)]
    pub fn solve_vector(&self, b: &[T; D]) -> [T; D] {
        let x = self.solve(&std::array::from_fn::<[T; 1], D, _>(|i| [b[i]]));
        std::array::from_fn(|i| x[i][0])
    }
}
