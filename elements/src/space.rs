//! The geometrically exact beam in space (Simo–Reissner), rotations by Gibbs vectors relative to the mean of its ends.
//!
//! With the local position X(s), v = X′, the Gibbs vector c(s) = tan(θ/2) n against the mean rotation of the ends, d = c′
//! and t = 2/(1 + c·c) the strains, in axes turned back by the initial curvature, are
//! ```text
//! Γ − Γ₀ = U′ + t (c × (c × v) − c × v)        κ − κ₀ = t (d − c × d)
//! ```
//! They need + − × ÷ alone. Rest strains vanish identically in the unloaded state, also for a curved rod, since c
//! measures against the unloaded curve. Their second derivatives are sums of rank-one and skew matrices; the tangent is
//! the Hessian in the chart exp(φ) R and symmetric. J. C. Simo, Comput. Methods Appl. Mech. Engrg. 49 (1985); the
//! objectivity of relative rotations: M. A. Crisfield, G. Jelenić, Proc. R. Soc. A 455 (1999). Seen from the mean of its
//! ends an element is the same from either of them, so that a symmetric network is one on its mesh, too.
//!
//! Theory: docs/theory/rod.md, Eq. 1.4 and 1.5; docs/theory/frames.md, Eq. 2.1 to 2.4.

use std::marker::PhantomData;

use crate::beam::{At, Beam, Condensed, Ends, Local, Piece, Placement};
use crate::interpolation::Table;
use crate::laws::{Corotational, Exact, LocalLaw, Softening};
use crate::real::{self, Real};
use crate::rotation::{self, Quaternion, compose, matrix, relative_gibbs, second_variation, turn_less_identity};
use crate::small::{
    self, M3, V3, add, apply, axpy, cross, diagonal, dot, madd, mscale, mul, mul_skew, outer, plus_outer, rotate,
    rotate_symmetric, scale, scale_rows, skew, skew_tmul, sub, tapply, tmul, tmul_symmetric, transpose, zeros,
};

/// A spatial beam with one local law.
#[derive(Clone, Copy, Debug)]
pub struct SpatialBeam<L>(PhantomData<L>);

/// The geometrically exact spatial beam.
pub type Space = SpatialBeam<Exact>;

/// The corotational spatial beam, of order 1.
pub type CorotationalSpace = SpatialBeam<Corotational>;

/// Displacement and rotation of a node against the unloaded state.
#[derive(Clone, Copy, Debug)]
pub struct Pose<T> {
    /// In global axes.
    pub displacement: V3<T>,
    /// From the unloaded state, a unit quaternion (w, x, y, z).
    pub rotation: Quaternion<T>,
}

impl<T: Real> Default for Pose<T> {
    fn default() -> Self {
        let o = T::zero();
        Self { displacement: [o; 3], rotation: [T::one(), o, o, o] }
    }
}

/// The local frame, and the last node seen from it.
#[derive(Clone, Copy, Debug)]
pub struct Frame<T> {
    /// Local axes in global axes: the columns.
    pub axes: M3<T>,
    /// Position of the last node.
    pub position: V3<T>,
    /// Displacement of the last node against the unloaded shape carried along by the frame.
    pub displacement: V3<T>,
    /// Gibbs vector of half the rotation from the first node to the last: that from the frame to the last.
    pub half: V3<T>,
}

impl<T: Real> Frame<T> {
    /// (1 + g·g)/2, by which a spin of the last node against the first changes twice the half rotation g.
    #[inline(always)]
    pub fn stretch(&self) -> T {
        T::splat(0.5) * (T::one() + dot(self.half, self.half))
    }

    /// The spin of the frame, for that of the first node and what the last node turns more, in local axes.
    #[inline(always)]
    pub fn spin(&self, first: V3<T>, more: V3<T>) -> V3<T> {
        add(first, scale(T::splat(0.5), sub(more, cross(self.half, more))))
    }
}

/// Strain at a point and its first derivatives with respect to v, c and d, in material axes.
#[derive(Clone, Copy, Debug)]
pub struct Kinematics<T> {
    /// Stretch less one, and shear, along axes 1, 2, 3.
    pub gamma: V3<T>,
    /// Twist and curvatures about axes 1, 2, 3 (1/length).
    pub kappa: V3<T>,
    /// Derivative of the stretches by the derivative of the position.
    pub gamma_v: M3<T>,
    /// Derivative of the stretches by the rotation parameters.
    pub gamma_c: M3<T>,
    /// Derivative of the curvatures by the rotation parameters.
    pub kappa_c: M3<T>,
    /// Derivative of the curvatures by the derivatives of the parameters along the rod.
    pub kappa_d: M3<T>,
}

/// Second derivatives of n·Γ + m·κ with respect to v, c and d; blocks not named are zero, or mirror images.
#[derive(Clone, Copy, Debug)]
pub struct Geometric<T> {
    /// By the derivative of the position, and the rotation parameters.
    pub vc: M3<T>,
    /// By the rotation parameters twice.
    pub cc: M3<T>,
    /// By the derivatives of the parameters along the rod, and the parameters.
    pub dc: M3<T>,
}

/// Tangent of one Gauss point with respect to v, c and d; the v–d block is zero.
#[derive(Clone, Copy, Debug)]
pub struct PointTangent<T> {
    /// By the derivative of the position twice.
    pub vv: M3<T>,
    /// By the derivative of the position, and the rotation parameters.
    pub vc: M3<T>,
    /// By the rotation parameters twice.
    pub cc: M3<T>,
    /// By the rotation parameters, and their derivatives along the rod.
    pub cd: M3<T>,
    /// By the derivatives of the parameters along the rod twice.
    pub dd: M3<T>,
}

impl<T: Real> PointTangent<T> {
    #[inline(always)]
    fn zero() -> Self {
        Self { vv: zeros(), vc: zeros(), cc: zeros(), cd: zeros(), dd: zeros() }
    }
}

/// Strains and their derivatives. `u` is U′ and `tangent` the unloaded tangent, so that v is their sum.
#[inline(always)]
pub fn kinematics<T: Real>(u: V3<T>, tangent: V3<T>, c: V3<T>, d: V3<T>, curved: Option<&M3<T>>) -> Kinematics<T> {
    let v = add(tangent, u);
    let t = T::splat(2.0) / (T::one() + dot(c, c));
    let cv = cross(c, v);
    let gamma = add(u, scale(t, sub(cross(c, cv), cv)));
    let z = sub(d, cross(c, d));
    let kappa = scale(t, z);
    let tc = scale(t, c);
    let kappa_d = [[t, tc[2], -tc[1]], [-tc[2], t, tc[0]], [tc[1], -tc[0], t]];
    let mut gamma_v = plus_outer(kappa_d, tc, c);
    for i in 0..3 {
        gamma_v[i][i] = (tc[i] * c[i] - T::one()) + t;
    }
    // skew(w) t (I − skew c), multiplied out.
    let w = add(gamma, tangent);
    let (tw, along) = (scale(t, w), dot(w, tc));
    let turn = [[along, -tw[2], tw[1]], [tw[2], along, -tw[0]], [-tw[1], tw[0], along]];
    let minus = -T::one();
    let gamma_c = plus_outer(turn, scale(minus, tc), w);
    let kappa_c = plus_outer(skew(scale(t, d)), scale(minus * t * t, z), c);
    match curved {
        None => Kinematics { gamma, kappa, gamma_v, gamma_c, kappa_c, kappa_d },
        Some(axes) => Kinematics {
            gamma: tapply(axes, &gamma),
            kappa: tapply(axes, &kappa),
            gamma_v: tmul(axes, &gamma_v),
            gamma_c: tmul(axes, &gamma_c),
            kappa_c: tmul(axes, &kappa_c),
            kappa_d: tmul(axes, &kappa_d),
        },
    }
}

/// Second derivatives of n·Γ + m·κ; n and m are given in axes turned back by the initial curvature.
#[inline(always)]
pub fn geometric<T: Real>(n: V3<T>, m: V3<T>, v: V3<T>, c: V3<T>, d: V3<T>) -> Geometric<T> {
    let t = T::splat(2.0) / (T::one() + dot(c, c));
    let tt = t * t;
    let (nc, cv) = (dot(n, c), dot(c, v));
    // φ = n·w + m·z with w = v − c × v + c (c·v), z = d − c × d: the energy density is −n·v + t φ.
    let w = add(sub(v, cross(c, v)), scale(cv, c));
    let z = sub(d, cross(c, d));
    let phi = dot(n, w) + dot(m, z);
    let phi_v = add(sub(n, cross(n, c)), scale(nc, c));
    let phi_d = sub(m, cross(m, c));
    let phi_c = add(add(cross(n, v), cross(m, d)), add(scale(cv, n), scale(nc, v)));
    let (tn, tm, ttc) = (scale(t, n), scale(t, m), scale(tt, c));
    let (along, double) = (t * nc, T::splat(2.0) * t * phi);
    let turn = [[along, tn[2], -tn[1]], [-tn[2], along, tn[0]], [tn[1], -tn[0], along]];
    let mut cc = zeros();
    for i in 0..3 {
        for j in 0..=i {
            let outer = (tn[i] * v[j]).plus(tn[j], v[i]);
            let radial = phi_c[i] - double * c[i];
            cc[i][j] = outer.minus(ttc[j], radial).minus(ttc[i], phi_c[j]);
            cc[j][i] = cc[i][j];
        }
        cc[i][i] = cc[i][i].minus(tt, phi);
    }
    let minus_ttc = scale(-T::one(), ttc);
    Geometric {
        vc: plus_outer(plus_outer(turn, c, tn), phi_v, minus_ttc),
        dc: plus_outer(skew(scale(-T::one(), tm)), phi_d, minus_ttc),
        cc,
    }
}

/// Tangent of a Gauss point: material part with stiffness `c6`, and the geometric part.
#[inline(always)]
pub fn point_tangent<T: Real>(k: &Kinematics<T>, c6: &[T; 6], geometric: &Geometric<T>) -> PointTangent<T> {
    let (c_n, c_m) = split(c6);
    let (cgv, cgc) = (scale_rows(c_n, &k.gamma_v), scale_rows(c_n, &k.gamma_c));
    let (ckc, ckd) = (scale_rows(c_m, &k.kappa_c), scale_rows(c_m, &k.kappa_d));
    PointTangent {
        vv: tmul_symmetric(&zeros(), &k.gamma_v, &cgv),
        vc: madd(geometric.vc, tmul(&k.gamma_v, &cgc)),
        cc: tmul_symmetric(&tmul_symmetric(&geometric.cc, &k.gamma_c, &cgc), &k.kappa_c, &ckc),
        cd: madd(transpose(&geometric.dc), tmul(&k.kappa_c, &ckd)),
        dd: tmul_symmetric(&zeros(), &k.kappa_d, &ckd),
    }
}

/// How the rotation that a law sees at a Gauss point follows the unknown of node i + 1.
#[inline(always)]
fn turning<L: LocalLaw, T: Real, const P: usize>(table: &Table<P>, g: usize, i: usize) -> T {
    T::splat(if i + 1 == P { table.values[g][i] - L::SEEN_FROM } else { table.values[g][i] })
}

/// U′, c and c′ at a Gauss point.
#[inline(always)]
fn interpolate<L: LocalLaw, T: Real, const P: usize>(
    at: &At<T, 6, P>,
    g: usize,
    field: &[[T; 6]; P],
) -> (V3<T>, V3<T>, V3<T>) {
    let inverse = T::one() / at.piece.length;
    let mut u = [T::zero(); 3];
    let mut c = [T::zero(); 3];
    let mut d = [T::zero(); 3];
    for (i, node) in field.iter().enumerate() {
        let value = turning::<L, T, P>(at.table, g, i);
        let slope = T::splat(at.table.slopes[g][i]) * inverse;
        let [x, y, z, a, b, e] = *node;
        axpy(&mut u, slope, [x, y, z]);
        axpy(&mut c, value, [a, b, e]);
        axpy(&mut d, slope, [a, b, e]);
    }
    (u, c, d)
}

#[inline(always)]
fn unloaded_tangent<T: Real>(curved: Option<&M3<T>>) -> V3<T> {
    match curved {
        None => [T::one(), T::zero(), T::zero()],
        Some(axes) => [axes[0][0], axes[1][0], axes[2][0]],
    }
}

/// Adds what a point gives to the gradient of a node.
#[inline(always)]
fn add_node<T: Real>(node: &mut [T; 6], value: T, slope: T, [v, c, d]: [V3<T>; 3]) {
    for a in 0..3 {
        node[a] = node[a].plus(slope, v[a]);
        node[3 + a] = node[3 + a].plus(value, c[a]).plus(slope, d[a]);
    }
}

/// The block of the local tangent that belongs to nodes i + 1 and j + 1.
#[inline(always)]
fn node_tangent<L: LocalLaw, T: Real, const P: usize>(
    table: &Table<P>,
    inverse: T,
    points: &[PointTangent<T>; P],
    [i, j]: [usize; 2],
    target: &mut [[T; 6]; 6],
) {
    let o = T::zero();
    let (mut vv, mut vc, mut cv, mut cc) = ([[o; 3]; 3], [[o; 3]; 3], [[o; 3]; 3], [[o; 3]; 3]);
    for (g, t) in points.iter().enumerate() {
        let (ni, nj) = (turning::<L, T, P>(table, g, i), turning::<L, T, P>(table, g, j));
        let (si, sj) = (T::splat(table.slopes[g][i]) * inverse, T::splat(table.slopes[g][j]) * inverse);
        let (ss, sn, ns, nn) = (si * sj, si * nj, ni * sj, ni * nj);
        for a in 0..3 {
            for b in 0..=a {
                vv[a][b] = vv[a][b].plus(ss, t.vv[a][b]);
                let twice = (nn * t.cc[a][b]).plus(ss, t.dd[a][b]);
                cc[a][b] += twice.plus(ns, t.cd[a][b]).plus(sn, t.cd[b][a]);
                if i != j && a != b {
                    cc[b][a] += twice.plus(ns, t.cd[b][a]).plus(sn, t.cd[a][b]);
                }
            }
            for b in 0..3 {
                vc[a][b] = vc[a][b].plus(sn, t.vc[a][b]);
                if i != j {
                    cv[b][a] = cv[b][a].plus(ns, t.vc[a][b]);
                }
            }
        }
    }
    for a in 0..3 {
        for b in 0..3 {
            let (low, high) = if a < b { (b, a) } else { (a, b) };
            target[a][b] = vv[low][high];
            target[a][3 + b] = vc[a][b];
            target[3 + a][b] = if i == j { vc[b][a] } else { cv[a][b] };
            target[3 + a][3 + b] = if i == j { cc[low][high] } else { cc[a][b] };
        }
    }
}

/// Shear strains less what the shear forces make of a softer section: their derivative in the mixed tangent.
#[inline(always)]
fn soften<T: Real>(k: &mut Kinematics<T>, softening: &Softening<T>, v: V3<T>) {
    for i in 0..2 {
        axpy(&mut k.gamma_v[1 + i], -softening.slope[i], v);
    }
}

/// The map from the spin of a node against the frame to the change of its Gibbs vector c.
#[inline(always)]
pub(crate) fn gibbs_map<T: Real>(c: V3<T>) -> M3<T> {
    let half = T::splat(0.5);
    let h = scale(half, c);
    let turn = [[half, h[2], -h[1]], [-h[2], half, h[0]], [h[1], -h[0], half]];
    plus_outer(turn, h, c)
}

/// Gibbs vector of half the rotation that leads from `a` to `b`, by at most half a turn, in axes that turn with `a`.
#[inline(always)]
fn half_gibbs<T: Real>(a: Quaternion<T>, b: Quaternion<T>) -> V3<T> {
    let r = compose(rotation::inverse(a), b);
    // Both signs of a quaternion are one rotation.
    let f = r[0] / (r[0].abs() + r[0] * r[0]);
    [r[1] * f, r[2] * f, r[3] * f]
}

/// The rotation by a Gibbs vector in the unloaded axes of an element, after another one.
#[inline(always)]
fn turned_on<T: Real>(piece: &Piece<T>, rotation: Quaternion<T>, gibbs: V3<T>) -> Quaternion<T> {
    let [x, y, z] = tapply(&piece.axes, &gibbs);
    rotation::normalize(compose(rotation, [T::one(), x, y, z]))
}

/// Displacement of a node against the unloaded shape that a rotation carries along, in local axes; `chord` is its unloaded place.
#[inline(always)]
fn displacement_against<T: Real>(piece: &Piece<T>, rotation: Quaternion<T>, chord: V3<T>, relative: V3<T>) -> V3<T> {
    let back = rotation::inverse(rotation);
    let carried = turn_less_identity(back, tapply(&piece.axes, &chord));
    apply(&piece.axes, &add(rotation::turn(back, relative), carried))
}

#[inline(always)]
fn split<T: Real>(a: &[T; 6]) -> (V3<T>, V3<T>) {
    ([a[0], a[1], a[2]], [a[3], a[4], a[5]])
}

#[inline(always)]
fn join<T: Real>(a: V3<T>, b: V3<T>) -> [T; 6] {
    [a[0], a[1], a[2], b[0], b[1], b[2]]
}

/// The 3 × 3 block of a 6 × 6 matrix that starts at (i, j).
#[inline(always)]
fn block<T: Real>(a: &[[T; 6]; 6], i: usize, j: usize) -> M3<T> {
    let mut part = zeros();
    for r in 0..3 {
        for c in 0..3 {
            part[r][c] = a[i + r][j + c];
        }
    }
    part
}

#[inline(always)]
fn blocks<T: Real>(a: &M3<T>, b: &M3<T>, c: &M3<T>, d: &M3<T>) -> [[T; 6]; 6] {
    [join(a[0], b[0]), join(a[1], b[1]), join(a[2], b[2]), join(c[0], d[0]), join(c[1], d[1]), join(c[2], d[2])]
}

/// From the tangent in local unknowns (X, e), e twice the half rotation, to blocks in (u, φ₀, ψ) in the local frame:
/// uu, uφ, uψ, φφ, φψ, ψψ.
#[inline(always)]
pub fn end_blocks<T: Real>(frame: &Frame<T>, condensed: &Condensed<T, 6>) -> [M3<T>; 6] {
    let k = &condensed.tangent;
    let (f, w) = split(&condensed.mixed_end);
    let (x, g, s) = (frame.position, frame.half, frame.stretch());
    let (half, quarter) = (T::splat(0.5), T::splat(0.25));
    let (kxx, kxe, kee) = (block(k, 0, 0), block(k, 0, 3), block(k, 3, 3));

    // With the spin of the frame in the place of φ₀.
    let m = scale(s, w);
    let mut moment = cross(f, x);
    let kxx_x = mul_skew(&kxx, x);
    let mut uw = mscale(s, kxe);
    let mut uf = madd(kxx_x, skew(scale(-T::one(), f)));
    let mut ff = madd(skew_tmul(x, &kxx_x), second_variation(f, x));
    let mut fw = madd(skew_tmul(x, &uw), skew(scale(half, m)));
    if let Some(turn) = &condensed.turn {
        let [x1, x2, x3, c1, c2, c3] = turn.coupling;
        let (kxf, kef) = ([x1, x2, x3], [c1, c2, c3]);
        let xk = skew_tmul(x, &kxf);
        uf = madd(uf, kxf);
        ff = madd(madd(ff, turn.tangent), madd(xk, transpose(&xk)));
        fw = madd(fw, mscale(s, transpose(&kef)));
        moment = add(moment, turn.gradient);
    }
    // The second variation of the frame itself.
    let along = outer(scale(quarter, moment), g);
    fw = madd(fw, madd(along, diagonal(-quarter * dot(moment, g))));
    let mg = outer(scale(quarter, m), g);
    let mut ww = madd(mscale(s * s, kee), madd(mg, transpose(&mg)));

    // The frame turns with both ends: φ₀ + B ψ, B = ½ (I − ĝ).
    let b = madd(diagonal(half), skew(scale(-half, g)));
    let before = tmul(&b, &fw);
    uw = madd(uw, mul(&uf, &b));
    fw = madd(fw, mul(&ff, &b));
    ww = tmul_symmetric(&madd(ww, transpose(&before)), &b, &fw);
    [kxx, uf, uw, ff, fw, ww]
}

impl<T: Real, L: LocalLaw> Beam<T, 6> for SpatialBeam<L> {
    type Law = L;
    type Pose = Pose<T>;
    type Frame = Frame<T>;

    #[inline(always)]
    fn frame(piece: &Piece<T>, first: &Pose<T>, last: &Pose<T>) -> Frame<T> {
        let half = apply(&piece.axes, &half_gibbs(first.rotation, last.rotation));
        let mean = turned_on(piece, first.rotation, half);
        let relative = sub(last.displacement, first.displacement);
        let displacement = displacement_against(piece, mean, piece.chord, relative);
        let axes = mul(&matrix(mean), &transpose(&piece.axes));
        Frame { axes, position: add(piece.chord, displacement), displacement, half }
    }

    #[inline(always)]
    fn last_local(frame: &Frame<T>) -> [T; 6] {
        join(frame.displacement, scale(T::splat(2.0), frame.half))
    }

    #[inline(always)]
    fn local_at(piece: &Piece<T>, [first, last]: [&Pose<T>; 2], node: &Pose<T>, reference: V3<T>) -> [T; 6] {
        let half = apply(&piece.axes, &half_gibbs(first.rotation, last.rotation));
        let mean = turned_on(piece, first.rotation, half);
        let relative = sub(node.displacement, first.displacement);
        let gibbs = apply(&piece.axes, &relative_gibbs(mean, node.rotation));
        join(displacement_against(piece, mean, reference, relative), add(half, gibbs))
    }

    #[inline(always)]
    fn pull_back(frame: &Frame<T>, force: V3<T>) -> V3<T> {
        tapply(&frame.axes, &force)
    }

    #[inline(always)]
    fn local<const P: usize, const TANGENT: bool>(at: &At<T, 6, P>, out: &mut Local<T, 6, P>) {
        out.clear();
        let inverse = T::one() / at.piece.length;
        let mut points = [PointTangent::zero(); P];
        for g in 0..P {
            let weight = T::splat(at.table.weights[g]) * at.piece.length;
            let curved = at.curved.map(|axes| &axes[g]);
            let unloaded = L::unloaded(at.piece, unloaded_tangent(curved));
            let (u, c, d) = interpolate::<L, T, P>(at, g, at.local);
            let v = add(unloaded, u);
            let mut k = L::kinematics(u, unloaded, c, d, curved);

            let section = L::stiffness(at.moduli, dot(v, v));
            let elastic = sub(join(k.gamma, k.kappa), at.moduli.rest);
            let mut stress = [T::zero(); 6];
            let mut stiffness = [T::zero(); 6];
            for i in 0..6 {
                stiffness[i] = weight * section[i];
                let spring = stiffness[i] * elastic[i];
                stress[i] = spring + weight * at.moduli.held[i] * at.stress[g][i];
                out.energy = out.energy.plus(T::splat(0.5) * stress[i], elastic[i]);
            }
            let (n, m) = split(&stress);
            let mut r_v = tapply(&k.gamma_v, &n);
            let softening = L::softening(at.moduli, &at.stress[g]);
            if let Some(softening) = &softening {
                let pull = softening.slope[0] * stress[1] + softening.slope[1] * stress[2];
                axpy(&mut r_v, weight * softening.pull - pull, v);
            }
            let r_c = add(tapply(&k.gamma_c, &n), tapply(&k.kappa_c, &m));
            let r_d = tapply(&k.kappa_d, &m);
            for i in 0..P {
                let value = turning::<L, T, P>(at.table, g, i);
                let slope = T::splat(at.table.slopes[g][i]) * inverse;
                add_node(&mut out.gradient[i], value, slope, [r_v, r_c, r_d]);
            }
            if !TANGENT {
                continue;
            }

            let (n, m) = split(&scale(weight, at.stress[g]));
            let value = turning::<L, T, P>(at.table, g, P - 1);
            let slope = T::splat(at.table.slopes[g][P - 1]) * inverse;
            let mut mixed_v = tapply(&k.gamma_v, &n);
            if let Some(softening) = &softening {
                axpy(&mut mixed_v, -weight * softening.pull, v);
                soften(&mut k, softening, v);
            }
            let mixed_c = add(tapply(&k.gamma_c, &n), tapply(&k.kappa_c, &m));
            let mixed_d = tapply(&k.kappa_d, &m);
            add_node(&mut out.mixed_end, value, slope, [mixed_v, mixed_c, mixed_d]);

            let (n, m) = match curved {
                None => (n, m),
                Some(axes) => (apply(axes, &n), apply(axes, &m)),
            };
            let mut t = point_tangent(&k, &stiffness, &L::geometric(n, m, v, c, d));
            if let Some(softening) = softening {
                t.vv = madd(t.vv, diagonal(-weight * softening.pull));
            }
            points[g] = t;
        }
        if TANGENT {
            for i in 0..P {
                for j in i..P {
                    node_tangent::<L, T, P>(at.table, inverse, &points, [i, j], &mut out.tangent[i][j]);
                }
            }
        }
    }

    #[inline(always)]
    fn extrapolate<const P: usize>(at: &At<T, 6, P>, change: &[[T; 6]; P]) -> [[T; 6]; P] {
        let mut stress = [[T::zero(); 6]; P];
        for (g, stress) in stress.iter_mut().enumerate() {
            *stress = at.stress[g];
            let curved = at.curved.map(|axes| &axes[g]);
            let (u, c, d) = interpolate::<L, T, P>(at, g, at.local);
            let unloaded = L::unloaded(at.piece, unloaded_tangent(curved));
            let v = add(unloaded, u);
            let mut k = L::kinematics(u, unloaded, c, d, curved);
            if let Some(softening) = L::softening(at.moduli, stress) {
                soften(&mut k, &softening, v);
            }
            let stiffness = L::stiffness(at.moduli, dot(v, v));
            let (du, dc, dd) = interpolate::<L, T, P>(at, g, change);
            let gamma = add(k.gamma, add(apply(&k.gamma_v, &du), apply(&k.gamma_c, &dc)));
            let kappa = add(k.kappa, add(apply(&k.kappa_c, &dc), apply(&k.kappa_d, &dd)));
            let elastic = sub(join(gamma, kappa), at.moduli.rest);
            for i in 0..6 {
                stress[i] = stiffness[i] * elastic[i] + at.moduli.held[i] * stress[i];
            }
        }
        stress
    }

    #[inline(always)]
    fn strains<const P: usize>(at: &At<T, 6, P>) -> [[T; 6]; P] {
        let mut strains = [[T::zero(); 6]; P];
        for (g, strain) in strains.iter_mut().enumerate() {
            let curved = at.curved.map(|axes| &axes[g]);
            let (u, c, d) = interpolate::<L, T, P>(at, g, at.local);
            let k = L::kinematics(u, L::unloaded(at.piece, unloaded_tangent(curved)), c, d, curved);
            *strain = join(k.gamma, k.kappa);
        }
        strains
    }

    #[inline(always)]
    fn expand(frame: &Frame<T>, condensed: &Condensed<T, 6>) -> Ends<T, 6> {
        let [uu, uf, uw, ff, fw, ww] = end_blocks(frame, condensed);
        let minus = -T::one();
        // ψ = φ_p − φ₀ and u = u_p − u₀.
        let u_first = rotate(&frame.axes, &madd(uf, mscale(minus, uw)));
        let u_last = rotate(&frame.axes, &uw);
        let uu = rotate_symmetric(&frame.axes, &uu);
        let first = madd(madd(ff, ww), mscale(minus, madd(fw, transpose(&fw))));
        let first = rotate_symmetric(&frame.axes, &first);
        let mixed = rotate(&frame.axes, &madd(fw, mscale(minus, ww)));
        let last = rotate_symmetric(&frame.axes, &ww);
        let negative = |a: &M3<T>| mscale(minus, *a);

        let turn = condensed.turn.map_or([T::zero(); 3], |turn| turn.gradient);
        let [r0, r1] = <Self as Beam<T, 6>>::expand_gradient(frame, &condensed.gradient, turn);
        Ends {
            k00: blocks(&uu, &negative(&u_first), &transpose(&negative(&u_first)), &first),
            k01: blocks(&negative(&uu), &negative(&u_last), &transpose(&u_first), &mixed),
            k11: blocks(&uu, &u_last, &transpose(&u_last), &last),
            r0,
            r1,
        }
    }

    #[inline(always)]
    fn expand_gradient(frame: &Frame<T>, gradient: &[T; 6], turn: V3<T>) -> [[T; 6]; 2] {
        let (f, w) = split(gradient);
        let moment = add(turn, cross(f, frame.position));
        let half = scale(T::splat(0.5), add(moment, cross(frame.half, moment)));
        let last = add(half, scale(frame.stretch(), w));
        let first = sub(moment, last);
        let force = apply(&frame.axes, &f);
        [join(scale(-T::one(), force), apply(&frame.axes, &first)), join(force, apply(&frame.axes, &last))]
    }

    #[inline(always)]
    fn restrict(frame: &Frame<T>, first: &[T; 6], last: &[T; 6]) -> ([T; 6], V3<T>) {
        let (u0, p0) = split(first);
        let (u1, p1) = split(last);
        let more = tapply(&frame.axes, &sub(p1, p0));
        let turn = frame.spin(tapply(&frame.axes, &p0), more);
        let u = add(tapply(&frame.axes, &sub(u1, u0)), cross(frame.position, turn));
        (join(u, scale(frame.stretch(), more)), turn)
    }

    #[inline(always)]
    fn moved(piece: &Piece<T>, ends: [&Pose<T>; 2], turns: [&[T; 6]; 2], local: &[T; 6], shift: &[T; 6]) -> [T; 6] {
        let (first, last) = (split(turns[0]).1, split(turns[1]).1);
        let turned = compose(rotation::exp(sub(last, first)), ends[1].rotation);
        let half = apply(&piece.axes, &half_gibbs(ends[0].rotation, turned));
        join(split(&add(*local, *shift)).0, scale(T::splat(2.0), half))
    }

    #[inline(always)]
    fn last(piece: &Piece<T>, first: &Pose<T>, local: &[T; 6]) -> Pose<T> {
        let (u, e) = split(local);
        let half = scale(T::splat(0.5), e);
        let mean = turned_on(piece, first.rotation, half);
        let carried = turn_less_identity(mean, tapply(&piece.axes, &piece.chord));
        let shifted = rotation::turn(mean, tapply(&piece.axes, &u));
        Pose { displacement: add(first.displacement, add(carried, shifted)), rotation: turned_on(piece, mean, half) }
    }

    #[inline(always)]
    fn between(from: &Pose<T>, to: &Pose<T>) -> [T; 6] {
        let two = T::splat(-2.0);
        let spin = scale(two, relative_gibbs(rotation::inverse(from.rotation), rotation::inverse(to.rotation)));
        join(sub(to.displacement, from.displacement), spin)
    }

    #[inline(always)]
    fn advance(pose: &mut Pose<T>, change: &[T; 6]) {
        let (u, spin) = split(change);
        pose.displacement = add(pose.displacement, u);
        pose.rotation = rotation::normalize(compose(rotation::exp(spin), pose.rotation));
    }

    #[inline(always)]
    fn load_coupling(load: V3<T>) -> [[T; 3]; 6] {
        // The potential −load · exp(φ) U has the mixed part φ · (load × δU).
        let s = skew(load);
        let o = [T::zero(); 3];
        let t: [V3<T>; 3] = transpose(&s);
        [t[0], t[1], t[2], o, o, o]
    }

    #[inline(always)]
    fn load_turn(load: V3<T>, position: V3<T>) -> (V3<T>, M3<T>) {
        (cross(load, position), mscale(-T::one(), second_variation(load, position)))
    }

    #[inline(always)]
    fn displacement(pose: &Pose<T>) -> V3<T> {
        pose.displacement
    }

    /// The squared distance of the quaternions, or of one from the opposite of the other: 4 sin² of a quarter of the
    /// angle.
    #[inline(always)]
    fn turned(a: &Pose<T>, b: &Pose<T>) -> T {
        let (mut near, mut far) = (T::zero(), T::zero());
        for i in 0..4 {
            let (less, more) = (a.rotation[i] - b.rotation[i], a.rotation[i] + b.rotation[i]);
            near = near.plus(less, less);
            far = far.plus(more, more);
        }
        -(-near).max(-far)
    }

    fn angle(turned: f64) -> f64 {
        4.0 * (0.5 * turned.sqrt()).asin()
    }

    #[inline]
    fn pose(pose: &Pose<T>, lane: usize) -> Placement {
        Placement {
            displacement: small::lane(&pose.displacement, lane),
            rotation: small::lane(&pose.rotation, lane),
            angle: 0.0,
        }
    }

    #[inline]
    fn set_pose(pose: &mut Pose<T>, lane: usize, placement: &Placement) {
        for (component, value) in pose.displacement.iter_mut().zip(placement.displacement) {
            component.set_lane(lane, value);
        }
        for (component, value) in pose.rotation.iter_mut().zip(placement.rotation) {
            component.set_lane(lane, value);
        }
    }

    const POSE: usize = 7;

    #[inline(always)]
    fn store_pose(pose: &Pose<T>, row: &mut [f64]) {
        let (displacement, rotation) = row.split_at_mut(3 * T::LANES);
        real::store(&pose.displacement, displacement);
        real::store(&pose.rotation, rotation);
    }

    #[inline(always)]
    fn load_pose(row: &[f64]) -> Pose<T> {
        let (displacement, rotation) = row.split_at(3 * T::LANES);
        Pose { displacement: real::load(displacement), rotation: real::load(rotation) }
    }
}

/// See [`beam::interior`](crate::beam::interior).
pub(crate) fn interior(
    piece: &Piece<f64>,
    first: &Placement,
    last: &[f64],
    reference: V3<f64>,
    local: &[f64],
) -> Placement {
    let half = [0.5 * last[3], 0.5 * last[4], 0.5 * last[5]];
    let (u, c) = ([local[0], local[1], local[2]], sub([local[3], local[4], local[5]], half));
    let mean = turned_on(piece, first.rotation, half);
    let carried = turn_less_identity(mean, tapply(&piece.axes, &reference));
    let shifted = rotation::turn(mean, tapply(&piece.axes, &u));
    Placement {
        displacement: add(first.displacement, add(carried, shifted)),
        rotation: turned_on(piece, mean, c),
        angle: 0.0,
    }
}
