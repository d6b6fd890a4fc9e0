//! The geometrically exact beam in the plane (Reissner), with angles, and its tangent out of the plane.
//!
//! With v = X′ and the angle ϑ against the mean of the ends, R = rotation by ϑ, the strains, in axes turned back by the
//! initial curvature, are Γ − Γ₀ = U′ + (Rᵀ − I) v and κ − κ₀ = ϑ′. The unknowns of nodes are angles against the first one. E. Reissner, J. Appl. Math. Phys. 23 (1972).
//! Material axis 2 is normal to the rod in the plane, axis 3 is z.
//!
//! Theory: docs/theory/rod.md, Eq. 1.6; docs/theory/stability.md for the tangent out of the plane.

use std::marker::PhantomData;

use crate::beam::{At, Beam, Condensed, Ends, Local, Moduli, Piece, Placement};
use crate::interpolation::Table;
use crate::laws::{Corotational, Exact, LocalLaw};
use crate::real::{self, Real};
use crate::rotation;
use crate::small::{self, M3, V3, add, axpy, scale, sub, zeros};
use crate::space;

/// A plane beam with one local law: components ux, uy and the angle.
#[derive(Clone, Copy, Debug)]
pub struct PlaneBeam<L>(PhantomData<L>);

/// The geometrically exact plane beam.
pub type Plane = PlaneBeam<Exact>;

/// The corotational plane beam, of order 1: the angle at its middle is the mean of those of its nodes.
pub type CorotationalPlane = PlaneBeam<Corotational>;

/// Displacement ux, uy and angle (radians, whole turns kept) of a node.
pub type Pose<T> = [T; 3];

/// The local frame, and the last node seen from it.
#[derive(Clone, Copy, Debug)]
pub struct Frame<T> {
    /// Axis 1 in global axes.
    pub axis: [T; 2],
    /// The last node seen from the first, along the axes of the frame.
    pub position: [T; 2],
    /// Displacement of the last node against the unloaded shape carried along by the frame, and its angle against the first.
    pub local: [T; 3],
}

/// The mean of the angles of both ends.
#[inline(always)]
fn mean<T: Real>(first: &Pose<T>, last: &Pose<T>) -> T {
    first[2] + T::splat(0.5) * (last[2] - first[2])
}

/// Displacement of a node against the unloaded shape that the frame at this angle carries along, in local axes; `reference` is its
/// unloaded place there, and `relative` how far it is displaced against the first node.
#[inline(always)]
fn displacement_against<T: Real>(
    piece: &Piece<T>,
    (sin, versine): (T, T),
    reference: V3<T>,
    relative: [T; 2],
) -> [T; 2] {
    let start = [piece.axes[0][0], piece.axes[0][1]];
    let global = turned(start, [reference[0], reference[1]]);
    // Rᵀ Δu + (Rᵀ − I) x, in the unloaded axes of the element.
    let back = add(relative, [versine * relative[0] + sin * relative[1], versine * relative[1] - sin * relative[0]]);
    let swing = [versine * global[0] + sin * global[1], versine * global[1] - sin * global[0]];
    turned_back(start, add(back, swing))
}

/// Sine, and cosine less one, of an angle.
#[inline(always)]
fn sine_and_versine<T: Real>(angle: T) -> (T, T) {
    let (s, c) = (T::splat(0.5) * angle).sin_cos();
    let two = T::splat(2.0);
    (two * s * c, -two * s * s)
}

/// a turned by the angle with this sine and cosine.
#[inline(always)]
fn turned<T: Real>(axis: [T; 2], a: [T; 2]) -> [T; 2] {
    [axis[0] * a[0] - axis[1] * a[1], axis[1] * a[0] + axis[0] * a[1]]
}

/// a turned back.
#[inline(always)]
fn turned_back<T: Real>(axis: [T; 2], a: [T; 2]) -> [T; 2] {
    [axis[0] * a[0] + axis[1] * a[1], axis[0] * a[1] - axis[1] * a[0]]
}

/// Strains and their derivatives at a Gauss point; Γ in axes turned back by the initial curvature.
struct Kinematics<T> {
    gamma: [T; 2],
    kappa: T,
    /// Sine and cosine of ϑ.
    sin: T,
    cos: T,
    /// ∂Γ/∂ϑ.
    slope: [T; 2],
}

#[inline(always)]
fn kinematics<T: Real>(u: [T; 2], tangent: [T; 2], angle: T, kappa: T) -> Kinematics<T> {
    let (sin, versine) = sine_and_versine(angle);
    let cos = T::one() + versine;
    let v = add(u, tangent);
    let gamma = [u[0] + versine * v[0] + sin * v[1], u[1] - sin * v[0] + versine * v[1]];
    let full = add(gamma, tangent);
    Kinematics { gamma, kappa, sin, cos, slope: [full[1], -full[0]] }
}

/// How the angle against the mean of the ends follows the unknown of node i + 1 at a Gauss point.
#[inline(always)]
fn turning<T: Real, const P: usize>(table: &Table<P>, g: usize, i: usize) -> T {
    T::splat(if i + 1 == P { table.values[g][i] - 0.5 } else { table.values[g][i] })
}

#[inline(always)]
fn interpolate<T: Real, const P: usize>(at: &At<T, 3, P>, g: usize, field: &[[T; 3]; P]) -> ([T; 2], T, T) {
    let inverse = T::one() / at.piece.length;
    let mut u = [T::zero(); 2];
    let (mut angle, mut kappa) = (T::zero(), T::zero());
    for (i, node) in field.iter().enumerate() {
        let slope = T::splat(at.table.slopes[g][i]) * inverse;
        axpy(&mut u, slope, [node[0], node[1]]);
        angle += turning::<T, P>(at.table, g, i) * node[2];
        kappa += slope * node[2];
    }
    (u, angle, kappa)
}

/// Cosine and sine of the unloaded tangent against the start.
#[inline(always)]
fn unloaded_tangent<T: Real>(curved: Option<&M3<T>>) -> [T; 2] {
    match curved {
        None => [T::one(), T::zero()],
        Some(axes) => [axes[0][0], axes[1][0]],
    }
}

/// What v begins with in the unloaded state.
#[inline(always)]
fn unloaded<T: Real, L: LocalLaw>(piece: &Piece<T>, axis: [T; 2]) -> [T; 2] {
    let [x, y, _] = L::unloaded(piece, [axis[0], axis[1], T::zero()]);
    [x, y]
}

#[inline(always)]
fn square<T: Real>(a: [T; 2]) -> T {
    a[0] * a[0] + a[1] * a[1]
}

/// Tangent of one Gauss point with respect to v, the angle and the curvature.
#[derive(Clone, Copy, Debug)]
struct PointTangent<T> {
    vv: [[T; 2]; 2],
    va: [T; 2],
    aa: T,
    bending: T,
}

impl<T: Real> PointTangent<T> {
    #[inline(always)]
    fn zero() -> Self {
        let o = T::zero();
        Self { vv: [[o; 2]; 2], va: [o; 2], aa: o, bending: o }
    }
}

/// What the mixed stresses at a Gauss point pull the last node by: n in axes turned back by the initial curvature, and turned
/// by R; with what shear that softens along v takes off.
#[inline(always)]
fn mixed_end<T: Real, const P: usize>(
    at: &At<T, 3, P>,
    g: usize,
    k: &Kinematics<T>,
    (n, turned): ([T; 2], [T; 2]),
    softened: Option<(T, [T; 2])>,
) -> [T; 3] {
    let weight = T::splat(at.table.weights[g]) * at.piece.length;
    let value = turning::<T, P>(at.table, g, P - 1);
    let slope = T::splat(at.table.slopes[g][P - 1]) / at.piece.length;
    let mut pull = turned;
    if let Some((softening, v)) = softened {
        axpy(&mut pull, -weight * softening, v);
    }
    let along = n[0] * k.slope[0] + n[1] * k.slope[1];
    [slope * pull[0], slope * pull[1], value * along + slope * weight * at.stress[g][2]]
}

/// The block of the local tangent that belongs to nodes i + 1 and j + 1.
#[inline(always)]
fn node_tangent<T: Real, const P: usize>(
    table: &Table<P>,
    inverse: T,
    points: &[PointTangent<T>; P],
    [i, j]: [usize; 2],
) -> [[T; 3]; 3] {
    let mut target = zeros::<T, 3, 3>();
    for (g, t) in points.iter().enumerate() {
        let (ni, nj) = (turning::<T, P>(table, g, i), turning::<T, P>(table, g, j));
        let (si, sj) = (T::splat(table.slopes[g][i]) * inverse, T::splat(table.slopes[g][j]) * inverse);
        let (ss, sn, ns) = (si * sj, si * nj, ni * sj);
        for a in 0..2 {
            for b in 0..2 {
                target[a][b] = target[a][b].plus(ss, t.vv[a][b]);
            }
            target[a][2] = target[a][2].plus(sn, t.va[a]);
            target[2][a] = target[2][a].plus(ns, t.va[a]);
        }
        target[2][2] = target[2][2].plus(ni * nj, t.aa).plus(ss, t.bending);
    }
    target
}

impl<T: Real, L: LocalLaw> Beam<T, 3> for PlaneBeam<L> {
    type Law = L;
    type Pose = Pose<T>;
    type Frame = Frame<T>;

    #[inline(always)]
    fn frame(piece: &Piece<T>, first: &Pose<T>, last: &Pose<T>) -> Frame<T> {
        let start = [piece.axes[0][0], piece.axes[0][1]];
        let (sin, versine) = sine_and_versine(mean(first, last));
        let axis = turned([T::one() + versine, sin], start);
        let relative = [last[0] - first[0], last[1] - first[1]];
        let [x, y] = displacement_against(piece, (sin, versine), piece.chord, relative);
        let position = [piece.chord[0] + x, piece.chord[1] + y];
        Frame { axis, position, local: [x, y, last[2] - first[2]] }
    }

    #[inline(always)]
    fn last_local(frame: &Frame<T>) -> [T; 3] {
        frame.local
    }

    #[inline(always)]
    fn local_at(piece: &Piece<T>, [first, last]: [&Pose<T>; 2], node: &Pose<T>, reference: V3<T>) -> [T; 3] {
        let relative = [node[0] - first[0], node[1] - first[1]];
        let [x, y] = displacement_against(piece, sine_and_versine(mean(first, last)), reference, relative);
        [x, y, node[2] - first[2]]
    }

    #[inline(always)]
    fn pull_back(frame: &Frame<T>, force: V3<T>) -> V3<T> {
        let [x, y] = turned_back(frame.axis, [force[0], force[1]]);
        [x, y, T::zero()]
    }

    #[inline(always)]
    fn local<const P: usize, const TANGENT: bool>(at: &At<T, 3, P>, out: &mut Local<T, 3, P>) {
        out.clear();
        let inverse = T::one() / at.piece.length;
        let mut points = [PointTangent::zero(); P];
        for g in 0..P {
            let weight = T::splat(at.table.weights[g]) * at.piece.length;
            let axis = unloaded_tangent(at.curved.map(|axes| &axes[g]));
            let (u, angle, kappa) = interpolate(at, g, at.local);
            let unloaded = unloaded::<T, L>(at.piece, axis);
            let v = add(u, unloaded);
            let k = kinematics(u, unloaded, angle, kappa);
            let gamma = turned_back(axis, k.gamma);

            let section = L::stiffness(at.moduli, square(v));
            let elastic = sub([gamma[0], gamma[1], k.kappa], at.moduli.rest);
            let mut stress = [T::zero(); 3];
            let mut stiffness = [T::zero(); 3];
            for i in 0..3 {
                stiffness[i] = weight * section[i];
                let spring = stiffness[i] * elastic[i];
                stress[i] = spring + weight * at.moduli.held[i] * at.stress[g][i];
                out.energy = out.energy.plus(T::splat(0.5) * stress[i], elastic[i]);
            }
            let n = turned(axis, [stress[0], stress[1]]);
            let mut r_v = turned([k.cos, k.sin], n);
            let softening = L::softening(at.moduli, &at.stress[g]);
            if let Some(softening) = &softening {
                axpy(&mut r_v, weight * softening.pull - softening.slope[0] * stress[1], v);
            }
            let r_angle = n[0] * k.slope[0] + n[1] * k.slope[1];
            for i in 0..P {
                let value = turning::<T, P>(at.table, g, i);
                let slope = T::splat(at.table.slopes[g][i]) * inverse;
                let node = [slope * r_v[0], slope * r_v[1], value * r_angle + slope * stress[2]];
                out.gradient[i] = add(out.gradient[i], node);
            }
            if !TANGENT {
                continue;
            }

            let n = turned(axis, [weight * at.stress[g][0], weight * at.stress[g][1]]);
            let m_v = turned([k.cos, k.sin], n);
            let end = mixed_end(at, g, &k, (n, m_v), softening.as_ref().map(|softening| (softening.pull, v)));
            out.mixed_end = add(out.mixed_end, end);

            // Stiffness of Γ in axes turned back by the initial curvature (b), then in the local frame (C).
            let [c1, c2, c3] = stiffness;
            let b11 = axis[0] * axis[0] * c1 + axis[1] * axis[1] * c2;
            let b22 = axis[1] * axis[1] * c1 + axis[0] * axis[0] * c2;
            let b12 = axis[0] * axis[1] * (c1 - c2);
            let columns = [[b11, b12], [b12, b22]];
            // rows of R b, then R b Rᵀ.
            let rb = [turned([k.cos, k.sin], columns[0]), turned([k.cos, k.sin], columns[1])];
            let mut vv = [
                [k.cos * rb[0][0] - k.sin * rb[1][0], k.sin * rb[0][0] + k.cos * rb[1][0]],
                [k.cos * rb[0][1] - k.sin * rb[1][1], k.sin * rb[0][1] + k.cos * rb[1][1]],
            ];
            let cs = [b11 * k.slope[0] + b12 * k.slope[1], b12 * k.slope[0] + b22 * k.slope[1]];
            let material = turned([k.cos, k.sin], cs);
            // ∂/∂ϑ of R n is −(axis z × …): R turned by a right angle.
            let mut va = [material[0] - m_v[1], material[1] + m_v[0]];
            let full = [-k.slope[1], k.slope[0]];
            let aa = k.slope[0] * cs[0] + k.slope[1] * cs[1] - (n[0] * full[0] + n[1] * full[1]);
            if let Some(softening) = &softening {
                // The derivative of Γ₂ is softer along v: row 2 less v times the slope, in place of row 2.
                let row = turned([k.cos, k.sin], [-axis[1], axis[0]]);
                let along = softening.slope[0];
                for a in 0..2 {
                    for b in 0..2 {
                        vv[a][b] += c2 * along * (along * v[a] * v[b] - row[a] * v[b] - v[a] * row[b]);
                    }
                    vv[a][a] += -weight * softening.pull;
                }
                axpy(&mut va, -c2 * along * turned_back(axis, k.slope)[1], v);
            }
            points[g] = PointTangent { vv, va, aa, bending: c3 };
        }
        if TANGENT {
            for i in 0..P {
                for j in i..P {
                    out.tangent[i][j] = node_tangent(at.table, inverse, &points, [i, j]);
                }
            }
        }
    }

    #[inline(always)]
    fn extrapolate<const P: usize>(at: &At<T, 3, P>, change: &[[T; 3]; P]) -> [[T; 3]; P] {
        let mut stress = [[T::zero(); 3]; P];
        for (g, stress) in stress.iter_mut().enumerate() {
            *stress = at.stress[g];
            let axis = unloaded_tangent(at.curved.map(|axes| &axes[g]));
            let (u, angle, kappa) = interpolate(at, g, at.local);
            let unloaded = unloaded::<T, L>(at.piece, axis);
            let v = add(u, unloaded);
            let k = kinematics(u, unloaded, angle, kappa);
            let (du, da, dk) = interpolate(at, g, change);
            let turned_change = turned_back([k.cos, k.sin], du);
            let gamma = add(k.gamma, add(turned_change, scale(da, k.slope)));
            let mut gamma = turned_back(axis, gamma);
            if let Some(softening) = L::softening(at.moduli, stress) {
                gamma[1] += -softening.slope[0] * (v[0] * du[0] + v[1] * du[1]);
            }
            let stiffness = L::stiffness(at.moduli, square(v));
            let elastic = sub([gamma[0], gamma[1], k.kappa + dk], at.moduli.rest);
            for i in 0..3 {
                stress[i] = stiffness[i] * elastic[i] + at.moduli.held[i] * stress[i];
            }
        }
        stress
    }

    #[inline(always)]
    fn strains<const P: usize>(at: &At<T, 3, P>) -> [[T; 3]; P] {
        let mut strains = [[T::zero(); 3]; P];
        for (g, strain) in strains.iter_mut().enumerate() {
            let axis = unloaded_tangent(at.curved.map(|axes| &axes[g]));
            let (u, angle, kappa) = interpolate(at, g, at.local);
            let k = kinematics(u, unloaded::<T, L>(at.piece, axis), angle, kappa);
            let gamma = turned_back(axis, k.gamma);
            *strain = [gamma[0], gamma[1], k.kappa];
        }
        strains
    }

    #[inline(always)]
    fn expand(frame: &Frame<T>, condensed: &Condensed<T, 3>) -> Ends<T, 3> {
        let k = &condensed.tangent;
        let f = condensed.mixed_end;
        let x = frame.position;
        // δX = u + φ (X₂, −X₁) with the turn φ of the frame.
        let lever = [x[1], -x[0]];
        let kl = [k[0][0] * lever[0] + k[0][1] * lever[1], k[1][0] * lever[0] + k[1][1] * lever[1]];
        // The frame turns the relative displacement too: −φ z × u against f.
        let mut uf = [kl[0] - f[1], kl[1] + f[0]];
        let mut ff = lever[0] * kl[0] + lever[1] * kl[1] - (f[0] * x[0] + f[1] * x[1]);
        let mut fw = lever[0] * k[0][2] + lever[1] * k[1][2];
        if let Some(turn) = &condensed.turn {
            let c = [turn.coupling[0][0], turn.coupling[1][0]];
            uf = add(uf, c);
            ff += turn.tangent[0][0] + T::splat(2.0) * (lever[0] * c[0] + lever[1] * c[1]);
            fw += turn.coupling[2][0];
        }
        // φ is that of the first node and half of what the last one turns more.
        let half = T::splat(0.5);
        let ww = k[2][2] + fw + half * half * ff;
        let fw = fw + half * ff;
        let uw = turned(frame.axis, add([k[0][2], k[1][2]], scale(half, uf)));
        let uf = turned(frame.axis, uf);
        let u_first = sub(uf, uw);
        let c0 = turned(frame.axis, [k[0][0], k[1][0]]);
        let c1 = turned(frame.axis, [k[0][1], k[1][1]]);
        let a = frame.axis;
        let xx = a[0] * c0[0] - a[1] * c1[0];
        let xy = a[1] * c0[0] + a[0] * c1[0];
        let yy = a[1] * c0[1] + a[0] * c1[1];
        let first = ff + ww - T::splat(2.0) * fw;
        let mixed = fw - ww;

        let turn = condensed.turn.map_or([T::zero(); 3], |turn| turn.gradient);
        let [r0, r1] = <Self as Beam<T, 3>>::expand_gradient(frame, &condensed.gradient, turn);
        Ends {
            k00: [[xx, xy, -u_first[0]], [xy, yy, -u_first[1]], [-u_first[0], -u_first[1], first]],
            k01: [[-xx, -xy, -uw[0]], [-xy, -yy, -uw[1]], [u_first[0], u_first[1], mixed]],
            k11: [[xx, xy, uw[0]], [xy, yy, uw[1]], [uw[0], uw[1], ww]],
            r0,
            r1,
        }
    }

    #[inline(always)]
    fn expand_gradient(frame: &Frame<T>, gradient: &[T; 3], turn: V3<T>) -> [[T; 3]; 2] {
        let x = frame.position;
        let force = turned(frame.axis, [gradient[0], gradient[1]]);
        let half = T::splat(0.5) * (turn[0] + x[1] * gradient[0] - x[0] * gradient[1]);
        [[-force[0], -force[1], half - gradient[2]], [force[0], force[1], half + gradient[2]]]
    }

    #[inline(always)]
    fn restrict(frame: &Frame<T>, first: &[T; 3], last: &[T; 3]) -> ([T; 3], V3<T>) {
        let u = turned_back(frame.axis, [last[0] - first[0], last[1] - first[1]]);
        let (x, turn) = (frame.position, mean(first, last));
        ([u[0] + turn * x[1], u[1] - turn * x[0], last[2] - first[2]], [turn, T::zero(), T::zero()])
    }

    #[inline(always)]
    fn moved(_: &Piece<T>, _: [&Pose<T>; 2], _: [&[T; 3]; 2], local: &[T; 3], shift: &[T; 3]) -> [T; 3] {
        add(*local, *shift)
    }

    #[inline(always)]
    fn last(piece: &Piece<T>, first: &Pose<T>, local: &[T; 3]) -> Pose<T> {
        let start = [piece.axes[0][0], piece.axes[0][1]];
        let (sin, versine) = sine_and_versine(first[2] + T::splat(0.5) * local[2]);
        let chord = turned(start, [piece.chord[0], piece.chord[1]]);
        let carried = turned([versine, sin], chord);
        let shifted = turned([T::one() + versine, sin], turned(start, [local[0], local[1]]));
        [first[0] + carried[0] + shifted[0], first[1] + carried[1] + shifted[1], first[2] + local[2]]
    }

    #[inline(always)]
    fn between(from: &Pose<T>, to: &Pose<T>) -> [T; 3] {
        sub(*to, *from)
    }

    #[inline(always)]
    fn advance(pose: &mut Pose<T>, change: &[T; 3]) {
        *pose = add(*pose, *change);
    }

    #[inline(always)]
    fn load_coupling(load: V3<T>) -> [[T; 3]; 3] {
        // The potential −load · R(φ) U has the mixed part −φ (U₁ load₂ − U₂ load₁).
        let o = T::zero();
        [[-load[1], o, o], [load[0], o, o], [o, o, o]]
    }

    #[inline(always)]
    fn load_turn(load: V3<T>, position: V3<T>) -> (V3<T>, M3<T>) {
        let o = T::zero();
        let moment = position[0] * load[1] - position[1] * load[0];
        let along = position[0] * load[0] + position[1] * load[1];
        ([-moment, o, o], [[along, o, o], [o; 3], [o; 3]])
    }

    #[inline(always)]
    fn displacement(pose: &Pose<T>) -> V3<T> {
        [pose[0], pose[1], T::zero()]
    }

    #[inline(always)]
    fn turned(a: &Pose<T>, b: &Pose<T>) -> T {
        (a[2] - b[2]).abs()
    }

    fn angle(turned: f64) -> f64 {
        turned
    }

    #[inline]
    fn pose(pose: &Pose<T>, lane: usize) -> Placement {
        let [x, y, angle] = small::lane(pose, lane);
        Placement { displacement: [x, y, 0.0], rotation: rotation::exp([0.0, 0.0, angle]), angle }
    }

    #[inline]
    fn set_pose(pose: &mut Pose<T>, lane: usize, placement: &Placement) {
        pose[0].set_lane(lane, placement.displacement[0]);
        pose[1].set_lane(lane, placement.displacement[1]);
        pose[2].set_lane(lane, placement.angle);
    }

    const POSE: usize = 3;

    #[inline(always)]
    fn store_pose(pose: &Pose<T>, row: &mut [f64]) {
        real::store(pose, row);
    }

    #[inline(always)]
    fn load_pose(row: &[f64]) -> Pose<T> {
        real::load(row)
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
    let start = [piece.axes[0][0], piece.axes[0][1]];
    let (sin, versine) = sine_and_versine(first.angle + 0.5 * last[2]);
    let global = turned(start, [reference[0], reference[1]]);
    let carried = [versine * global[0] - sin * global[1], sin * global[0] + versine * global[1]];
    let shifted = turned([1.0 + versine, sin], turned(start, [local[0], local[1]]));
    let [x, y, _] = first.displacement;
    let angle = first.angle + local[2];
    Placement {
        displacement: [x + carried[0] + shifted[0], y + carried[1] + shifted[1], 0.0],
        rotation: rotation::exp([0.0, 0.0, angle]),
        angle,
    }
}

/// Tangent out of the plane of a plane element: local unknowns U₃, c₁, c₂ of nodes 1…P; and what turns with the frame.
///
/// `at` is the plane state, `moduli` are the spatial ones. In-plane and out-of-plane parts of the spatial Hessian do not
/// couple at a plane state, so that the rows (3, 4, 5) of the spatial tangent are all there is.
#[inline(always)]
pub fn lateral<T: Real, L: LocalLaw, const P: usize>(
    at: &At<T, 3, P>,
    moduli: &Moduli<T, 6>,
    out: &mut Local<T, 3, P>,
) {
    out.clear();
    for i in 0..P {
        for j in i..P {
            out.tangent[i][j] = zeros();
        }
    }
    let o = T::zero();
    let inverse = T::one() / at.piece.length;
    let seen_from = T::splat(0.5 - L::SEEN_FROM) * at.local[P - 1][2];
    let turning = |g: usize, i: usize| {
        let value = at.table.values[g][i];
        T::splat(if i + 1 == P { value - L::SEEN_FROM } else { value })
    };
    for g in 0..P {
        let weight = T::splat(at.table.weights[g]) * at.piece.length;
        let curved = at.curved.map(|axes| &axes[g]);
        let tangent = unloaded_tangent(curved);
        let (u, angle, kappa) = interpolate(at, g, at.local);
        let [c, slope] = L::gibbs(angle + seen_from, kappa);
        let start = unloaded::<T, L>(at.piece, tangent);
        let v = add(u, start);
        let (gibbs, slope) = ([o, o, c], [o, o, slope]);
        let k = L::kinematics([u[0], u[1], o], [start[0], start[1], o], gibbs, slope, curved);
        let stress = scale(weight, at.stress[g]);
        let n = turned(tangent, [stress[0], stress[1]]);
        let force = [n[0], n[1], o];
        let moment = [o, o, stress[2]];
        let stiffness = L::stiffness(moduli, square(v));
        let geometric = L::geometric(force, moment, [v[0], v[1], o], gibbs, slope);
        let mut t = space::point_tangent(&k, &scale(weight, stiffness), &geometric);
        let [n1, n2, m3] = at.stress[g];
        let softening = L::softening(moduli, &[n1, n2, o, o, o, m3]);
        if let Some(softening) = &softening {
            t.vv[2][2] += -weight * softening.pull;
        }
        let flat = kinematics(u, start, angle, kappa);
        let m_v = turned([flat.cos, flat.sin], n);
        // The shear along axis 2 alone softens along a v of the plane.
        let softened = L::softening(at.moduli, &at.stress[g]).map(|softening| (softening.pull, v));
        out.mixed_end = add(out.mixed_end, mixed_end(at, g, &flat, (n, m_v), softened));
        for i in 0..P {
            let (ni, si) = (turning(g, i), T::splat(at.table.slopes[g][i]) * inverse);
            for j in i..P {
                let (nj, sj) = (turning(g, j), T::splat(at.table.slopes[g][j]) * inverse);
                let (nn, ns, sn, ss) = (ni * nj, ni * sj, si * nj, si * sj);
                let target = &mut out.tangent[i][j];
                target[0][0] = target[0][0].plus(ss, t.vv[2][2]);
                for a in 0..2 {
                    target[0][1 + a] = target[0][1 + a].plus(sn, t.vc[2][a]);
                    target[1 + a][0] = target[1 + a][0].plus(ns, t.vc[2][a]);
                    for b in 0..2 {
                        let sum = target[1 + a][1 + b].plus(nn, t.cc[a][b]).plus(ns, t.cd[a][b]);
                        target[1 + a][1 + b] = sum.plus(sn, t.cd[b][a]).plus(ss, t.dd[a][b]);
                    }
                }
            }
        }
    }
}

/// What a load along an element adds to the tangent out of the plane: its turn with the frame about axes 1 and 2.
#[derive(Clone, Copy, Debug)]
pub struct LateralTurn<T> {
    /// Second derivatives by the spins of the frame.
    pub tangent: M3<T>,
    /// Second derivatives by U₃, c₁, c₂ of the last node and by these.
    pub coupling: [[T; 3]; 3],
    /// The moment about z that the load turns the frame with.
    pub moment: T,
}

/// From the lateral tangent in local unknowns to both end nodes: components uz, φx, φy in global axes.
///
/// `mixed_end` is the in-plane gradient at the last node with the mixed stresses, which turns with the frame.
#[inline(always)]
pub fn expand_lateral<T: Real>(
    frame: &Frame<T>,
    tangent: &[[T; 3]; 3],
    mixed_end: [T; 3],
    turn: Option<&LateralTurn<T>>,
) -> Ends<T, 3> {
    let o = T::zero();
    let (sin, cos) = (T::splat(0.25) * frame.local[2]).sin_cos();
    let half = sin / cos;
    let mut full = [[o; 6]; 6];
    const ROWS: [usize; 3] = [2, 3, 4];
    for (i, &a) in ROWS.iter().enumerate() {
        for (j, &b) in ROWS.iter().enumerate() {
            full[a][b] = tangent[i][j];
        }
    }
    let axis = frame.axis;
    let spatial = space::Frame {
        axes: [[axis[0], -axis[1], o], [axis[1], axis[0], o], [o, o, T::one()]],
        position: [frame.position[0], frame.position[1], o],
        displacement: [frame.local[0], frame.local[1], o],
        half: [o, o, half],
    };
    // The angle is four times the arc tangent of the half rotation, the unknown in space twice that.
    let couple = mixed_end[2] / spatial.stretch();
    let condensed = Condensed {
        tangent: full,
        gradient: [o; 6],
        mixed_end: [mixed_end[0], mixed_end[1], o, o, o, couple],
        turn: turn.map(|turn| {
            let mut coupling = [[o; 3]; 6];
            for (row, own) in ROWS.iter().zip(turn.coupling) {
                coupling[*row] = own;
            }
            crate::beam::Turn { coupling, tangent: turn.tangent, gradient: [o, o, turn.moment] }
        }),
    };
    let ends = <space::Space as Beam<T, 6>>::expand(&spatial, &condensed);
    let mut picked = Ends { k00: zeros(), k01: zeros(), k11: zeros(), r0: [o; 3], r1: [o; 3] };
    for (i, &a) in ROWS.iter().enumerate() {
        for (j, &b) in ROWS.iter().enumerate() {
            picked.k00[i][j] = ends.k00[a][b];
            picked.k01[i][j] = ends.k01[a][b];
            picked.k11[i][j] = ends.k11[a][b];
        }
    }
    picked
}

/// Plane moduli out of spatial ones whose axis 3 is z: Γ₁, Γ₂, κ₃.
#[inline(always)]
pub fn plane_moduli<T: Real>(spatial: &Moduli<T, 6>) -> Moduli<T, 3> {
    let Moduli { stiffness, rest, held, softening } = *spatial;
    Moduli {
        stiffness: [stiffness[0], stiffness[1], stiffness[5]],
        rest: [rest[0], rest[1], rest[5]],
        held: [held[0], held[1], held[5]],
        softening,
    }
}
