//! Vectors and matrices of three, and blocks of D, generic over the scalar.
//!
//! Plain arrays, because the kernels must compile to straight-line code for numbers and for lanes alike; plain loops,
//! because what is called with a closure may stay a call, without the instructions of the lanes. Matrices are stored by
//! rows.

use crate::real::Real;

/// Three components.
pub type V3<T> = [T; 3];
/// Three rows of three.
pub type M3<T> = [[T; 3]; 3];

/// One lane of numbers that lie side by side.
#[inline]
pub fn lane<T: Real, const N: usize>(a: &[T; N], lane: usize) -> [f64; N] {
    let mut own = [0.0; N];
    for i in 0..N {
        own[i] = a[i].lane(lane);
    }
    own
}

/// One lane of a matrix or of several vectors.
#[inline]
pub fn lanes<T: Real, const N: usize, const M: usize>(a: &[[T; M]; N], index: usize) -> [[f64; M]; N] {
    let mut own = [[0.0; M]; N];
    for i in 0..N {
        own[i] = lane(&a[i], index);
    }
    own
}

/// Scalar product.
#[inline(always)]
pub fn dot<T: Real>(a: V3<T>, b: V3<T>) -> T {
    (a[0] * b[0]).plus(a[1], b[1]).plus(a[2], b[2])
}

/// a × b, every product rounded on its own, so that a × a is zero.
#[inline(always)]
pub fn cross<T: Real>(a: V3<T>, b: V3<T>) -> V3<T> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Sum.
#[inline(always)]
pub fn add<T: Real, const N: usize>(a: [T; N], b: [T; N]) -> [T; N] {
    let mut c = a;
    for i in 0..N {
        c[i] += b[i];
    }
    c
}

/// Difference.
#[inline(always)]
pub fn sub<T: Real, const N: usize>(a: [T; N], b: [T; N]) -> [T; N] {
    let mut c = a;
    for i in 0..N {
        c[i] -= b[i];
    }
    c
}

/// A multiple.
#[inline(always)]
pub fn scale<T: Real, const N: usize>(s: T, a: [T; N]) -> [T; N] {
    let mut c = a;
    for i in 0..N {
        c[i] = s * a[i];
    }
    c
}

/// a += s b
#[inline(always)]
pub fn axpy<T: Real, const N: usize>(a: &mut [T; N], s: T, b: [T; N]) {
    for i in 0..N {
        a[i] = a[i].plus(s, b[i]);
    }
}

/// Length.
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

/// The unit matrix.
#[inline(always)]
pub fn identity<T: Real>() -> M3<T> {
    diagonal(T::one())
}

/// That multiple of the unit matrix.
#[inline(always)]
pub fn diagonal<T: Real>(s: T) -> M3<T> {
    let o = T::zero();
    [[s, o, o], [o, s, o], [o, o, s]]
}

/// A + b cᵀ
#[inline(always)]
pub fn plus_outer<T: Real>(a: M3<T>, b: V3<T>, c: V3<T>) -> M3<T> {
    let mut sum = a;
    for i in 0..3 {
        axpy(&mut sum[i], b[i], c);
    }
    sum
}

/// a bᵀ
#[inline(always)]
pub fn outer<T: Real>(a: V3<T>, b: V3<T>) -> M3<T> {
    [scale(a[0], b), scale(a[1], b), scale(a[2], b)]
}

/// N rows of M zeros.
#[inline(always)]
pub fn zeros<T: Real, const N: usize, const M: usize>() -> [[T; M]; N] {
    [[T::zero(); M]; N]
}

/// Sum of two matrices.
#[inline(always)]
pub fn madd<T: Real, const N: usize, const M: usize>(a: [[T; M]; N], b: [[T; M]; N]) -> [[T; M]; N] {
    let mut c = a;
    for i in 0..N {
        c[i] = add(c[i], b[i]);
    }
    c
}

/// A multiple of a matrix.
#[inline(always)]
pub fn mscale<T: Real, const N: usize, const M: usize>(s: T, a: [[T; M]; N]) -> [[T; M]; N] {
    let mut c = a;
    for i in 0..N {
        c[i] = scale(s, a[i]);
    }
    c
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

/// Rows for columns.
#[inline(always)]
pub fn transpose<T: Real, const N: usize, const M: usize>(a: &[[T; M]; N]) -> [[T; N]; M] {
    let mut b = zeros();
    for i in 0..M {
        for j in 0..N {
            b[i][j] = a[j][i];
        }
    }
    b
}

/// A B
#[inline(always)]
pub fn mul<T: Real, const N: usize, const K: usize, const M: usize>(a: &[[T; K]; N], b: &[[T; M]; K]) -> [[T; M]; N] {
    let mut c = zeros();
    for i in 0..N {
        let mut row = scale(a[i][0], b[0]);
        for k in 1..K {
            axpy(&mut row, a[i][k], b[k]);
        }
        c[i] = row;
    }
    c
}

/// Aᵀ B
#[inline(always)]
pub fn tmul<T: Real, const N: usize, const K: usize, const M: usize>(a: &[[T; N]; K], b: &[[T; M]; K]) -> [[T; M]; N] {
    let mut c = zeros();
    for i in 0..N {
        let mut row = scale(a[0][i], b[0]);
        for k in 1..K {
            axpy(&mut row, a[k][i], b[k]);
        }
        c[i] = row;
    }
    c
}

/// C − Aᵀ B, in place.
#[inline(always)]
pub fn sub_tmul<T: Real, const N: usize, const K: usize, const M: usize>(
    c: &mut [[T; M]; N],
    a: &[[T; N]; K],
    b: &[[T; M]; K],
) {
    for i in 0..N {
        let mut row = c[i];
        for k in 0..K {
            for j in 0..M {
                row[j] = row[j].minus(a[k][i], b[k][j]);
            }
        }
        c[i] = row;
    }
}

/// C − Aᵀ B, in place, where both are symmetric: the upper right quarter is copied, as is the rest of the upper triangle.
#[inline(always)]
pub fn sub_tmul_symmetric<T: Real, const N: usize, const K: usize>(
    c: &mut [[T; N]; N],
    a: &[[T; N]; K],
    b: &[[T; N]; K],
) {
    let half = N.div_ceil(2);
    for i in 0..half {
        let mut row = c[i];
        for k in 0..K {
            for j in 0..half {
                row[j] = row[j].minus(a[k][i], b[k][j]);
            }
        }
        c[i] = row;
    }
    for i in half..N {
        let mut row = c[i];
        for k in 0..K {
            for j in 0..N {
                row[j] = row[j].minus(a[k][i], b[k][j]);
            }
        }
        c[i] = row;
    }
    for i in 1..N {
        for j in 0..i {
            c[j][i] = c[i][j];
        }
    }
}

/// C + Aᵀ B, where all are symmetric: the lower triangle is computed, and copied.
#[inline(always)]
pub fn tmul_symmetric<T: Real>(c: &M3<T>, a: &M3<T>, b: &M3<T>) -> M3<T> {
    let mut sum = *c;
    for i in 0..3 {
        for j in 0..=i {
            for k in 0..3 {
                sum[i][j] = sum[i][j].plus(a[k][i], b[k][j]);
            }
            sum[j][i] = sum[i][j];
        }
    }
    sum
}

/// A skew(x)
#[inline(always)]
pub fn mul_skew<T: Real>(a: &M3<T>, x: V3<T>) -> M3<T> {
    [cross(a[0], x), cross(a[1], x), cross(a[2], x)]
}

/// skew(x)ᵀ A
#[inline(always)]
pub fn skew_tmul<T: Real>(x: V3<T>, a: &M3<T>) -> M3<T> {
    let columns: M3<T> = transpose(a);
    transpose(&[cross(columns[0], x), cross(columns[1], x), cross(columns[2], x)])
}

/// A v
#[inline(always)]
pub fn apply<T: Real, const N: usize, const M: usize>(a: &[[T; M]; N], v: &[T; M]) -> [T; N] {
    let mut r = [T::zero(); N];
    for i in 0..N {
        r[i] = a[i][0] * v[0];
        for j in 1..M {
            r[i] = r[i].plus(a[i][j], v[j]);
        }
    }
    r
}

/// Aᵀ v
#[inline(always)]
pub fn tapply<T: Real, const N: usize, const M: usize>(a: &[[T; M]; N], v: &[T; N]) -> [T; M] {
    let mut r = scale(v[0], a[0]);
    for i in 1..N {
        axpy(&mut r, v[i], a[i]);
    }
    r
}

/// v − A w, in place.
#[inline(always)]
pub fn sub_apply<T: Real, const N: usize, const M: usize>(v: &mut [T; N], a: &[[T; M]; N], w: &[T; M]) {
    for i in 0..N {
        for j in 0..M {
            v[i] = v[i].minus(a[i][j], w[j]);
        }
    }
}

/// v − Aᵀ w, in place.
#[inline(always)]
pub fn sub_tapply<T: Real, const N: usize, const M: usize>(v: &mut [T; M], a: &[[T; M]; N], w: &[T; N]) {
    for i in 0..N {
        for j in 0..M {
            v[j] = v[j].minus(a[i][j], w[i]);
        }
    }
}

/// R A Rᵀ
#[inline(always)]
pub fn rotate<T: Real>(r: &M3<T>, a: &M3<T>) -> M3<T> {
    let ra = mul(r, a);
    let mut c = zeros();
    for i in 0..3 {
        for j in 0..3 {
            c[i][j] = dot(ra[i], r[j]);
        }
    }
    c
}

/// R A Rᵀ of a symmetric matrix: the lower triangle is computed, and copied.
#[inline(always)]
pub fn rotate_symmetric<T: Real>(r: &M3<T>, a: &M3<T>) -> M3<T> {
    let ra = mul(r, a);
    let mut c = zeros();
    for i in 0..3 {
        for j in 0..=i {
            c[i][j] = dot(ra[i], r[j]);
            c[j][i] = c[i][j];
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
    /// The largest diagonal entry over the pivot that is left of it, in magnitude: infinite for a singular block.
    pub largest: T,
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
        let mut l = zeros::<T, D, D>();
        let mut inverse_pivots = [T::zero(); D];
        let mut negative = T::zero();
        let mut largest = T::zero();
        for j in 0..D {
            let mut pivot = a[j][j];
            // L D: what a row of L is before its division by the pivots.
            let mut row = [T::zero(); D];
            for k in 0..j {
                let mut entry = a[j][k];
                for m in 0..k {
                    entry = entry.minus(row[m], l[k][m]);
                }
                row[k] = entry;
                l[j][k] = entry * inverse_pivots[k];
                pivot = pivot.minus(entry, l[j][k]);
            }
            let diagonal = a[j][j].abs();
            let inverse = T::one() / pivot;
            negative += pivot.plus(noise, diagonal).is_negative();
            largest = largest.max(((diagonal + T::splat(f64::MIN_POSITIVE)) * inverse).abs());
            inverse_pivots[j] = inverse;
        }
        Self { l, inverse_pivots, negative, largest }
    }

    /// Solves for every column of the right-hand side.
    #[inline(always)]
    pub fn solve<const M: usize>(&self, b: &[[T; M]; D]) -> [[T; M]; D] {
        let mut x = zeros();
        self.solve_into(b, &mut x);
        x
    }

    /// The same, where the solution is to be kept: a copy of the right-hand side there would cost as much as a column.
    #[inline(always)]
    pub fn solve_into<const M: usize>(&self, b: &[[T; M]; D], x: &mut [[T; M]; D]) {
        for m in 0..M {
            let mut column = [T::zero(); D];
            for i in 0..D {
                column[i] = b[i][m];
            }
            let column = self.solve_vector(&column);
            for i in 0..D {
                x[i][m] = column[i];
            }
        }
    }

    /// The solution for one right-hand side.
    #[inline(always)]
    pub fn solve_vector(&self, b: &[T; D]) -> [T; D] {
        let mut x = *b;
        for i in 1..D {
            for k in 0..i {
                x[i] = x[i].minus(self.l[i][k], x[k]);
            }
        }
        for i in (0..D).rev() {
            x[i] = x[i] * self.inverse_pivots[i];
            for k in i + 1..D {
                x[i] = x[i].minus(self.l[k][i], x[k]);
            }
        }
        x
    }
}
