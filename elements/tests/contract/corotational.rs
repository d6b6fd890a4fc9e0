//! The local law of the corotational beam, its plane form, and what of it leaves the plane.

use pennate_elements::beam::{At, Beam, Condensed, Ends, Local, Moduli, Piece};
use pennate_elements::interpolation::Table;
use pennate_elements::laws::Corotational;
use pennate_elements::plane::{self, CorotationalPlane};
use pennate_elements::rotation::{self, compose};
use pennate_elements::small::{M3, apply, norm, sub, tapply, transpose};
use pennate_elements::space::{CorotationalSpace, Pose};

const LENGTH: f64 = 5.0;

/// Unequal stiffness against bending, shear along axis 2 rigid, along axis 3 not.
fn moduli() -> Moduli<f64, 6> {
    let [ei2, ei3] = [700.0, 1100.0];
    Moduli {
        stiffness: [300.0, f64::INFINITY, 40.0, 500.0, ei2, ei3],
        rest: [-0.15, 0.0, 0.0, 0.0, 0.0, 0.03],
        held: [0.0; 6],
        softening: [LENGTH * LENGTH / (12.0 * ei3), LENGTH * LENGTH / (12.0 * ei2)],
    }
}

fn straight(axes: M3<f64>) -> Piece<f64> {
    Piece { length: LENGTH, axes, chord: [LENGTH, 0.0, 0.0], bulge: [0.0; 3] }
}

struct Evaluated<const D: usize> {
    energy: f64,
    stress: [f64; D],
    strain: [f64; D],
    local: Local<f64, D, 1>,
    ends: Ends<f64, D>,
}

fn evaluate<B: Beam<f64, D>, const D: usize>(
    piece: &Piece<f64>,
    curved: Option<&[M3<f64>; 1]>,
    moduli: &Moduli<f64, D>,
    poses: &[B::Pose; 2],
) -> Evaluated<D> {
    let table = Table::<1>::new();
    let frame = B::frame(piece, &poses[0], &poses[1]);
    let local = [B::last_local(&frame)];
    let zero = [[0.0; D]];
    let at = At { table: &table, piece, curved, moduli, local: &local, stress: &zero };
    let stress = B::extrapolate(&at, &zero);
    let at = At { stress: &stress, ..at };
    let mut out = Local::zero();
    B::local::<1, true>(&at, &mut out);
    let [[tangent]] = out.tangent;
    let condensed = Condensed { tangent, gradient: out.gradient[0], mixed_end: out.mixed_end, turn: None };
    let ends = B::expand(&frame, &condensed);
    Evaluated { energy: out.energy, stress: stress[0], strain: B::strains(&at)[0], local: out, ends }
}

/// Γ₁ = λ cos γ − 1, Γ₂ = −λ sin γ, κ = θ/h and 1/GA* = 1/GA + λ²h²/12EI, at 17 % contraction and off the axes.
#[test]
fn strains_are_those_of_the_chord_against_the_mean_rotation() {
    let (direction, stretch, chord_angle, ends) = (0.7f64, 0.83, 0.4f64, [0.9f64, 0.3]);
    let axes = [[direction.cos(), direction.sin(), 0.0], [-direction.sin(), direction.cos(), 0.0], [0.0, 0.0, 1.0]];
    let piece = straight(axes);
    let place = direction + chord_angle;
    let first = [0.2, -0.1, ends[0]];
    let last = [
        first[0] + LENGTH * (stretch * place.cos() - direction.cos()),
        first[1] + LENGTH * (stretch * place.sin() - direction.sin()),
        ends[1],
    ];
    for shear in [60.0, f64::INFINITY] {
        let spatial = Moduli { stiffness: [300.0, shear, 40.0, 500.0, 700.0, 1100.0], ..moduli() };
        let flat = plane::plane_moduli(&spatial);
        let found = evaluate::<CorotationalPlane, 3>(&piece, None, &flat, &[first, last]);
        // The mean of the nodes' rotations against the chord, which lies behind both.
        let against: f64 = 0.5 * (ends[0] + ends[1]) - chord_angle;
        let strain = [stretch * against.cos() - 1.0, -stretch * against.sin(), (ends[1] - ends[0]) / LENGTH];
        assert!(norm(sub(found.strain, strain)) < 1e-15, "{:?} {strain:?}", found.strain);
        let compliance = 1.0 / shear + (stretch * LENGTH).powi(2) / (12.0 * 1100.0);
        let stress = [300.0 * (strain[0] + 0.15), strain[1] / compliance, 1100.0 * (strain[2] - 0.03)];
        assert!(norm(sub(found.stress, stress)) < 1e-12);
        let energy =
            0.5 * LENGTH * (stress[0] * (strain[0] + 0.15) + stress[1] * strain[1] + stress[2] * (strain[2] - 0.03));
        assert!((found.energy - energy).abs() < 1e-13 * energy);
    }
}

/// An element knows no first and no last node: turned end for end, curved or straight, it has the same energy.
#[test]
fn elements_are_the_same_from_either_end() {
    let bend = [0.04, -0.05, 0.09];
    let half = rotation::exp(bend.map(|k| 0.5 * LENGTH * k));
    let whole = rotation::exp(bend.map(|k| LENGTH * k));
    let chord = apply(&rotation::tangent_map(bend.map(|k| LENGTH * k)), &[LENGTH, 0.0, 0.0]);
    let start = transpose(&rotation::matrix(rotation::exp([0.3, -0.5, 0.9])));
    let piece = Piece { length: LENGTH, axes: start, chord, bulge: [0.0; 3] };
    let curved = [rotation::matrix(half)];
    let poses = [
        Pose { displacement: [0.3, -0.4, 0.2], rotation: rotation::exp([0.2, 0.7, -0.3]) },
        Pose { displacement: [-0.6, 0.9, 1.1], rotation: rotation::exp([0.5, 0.1, 1.4]) },
    ];
    let moduli = Moduli { rest: [-0.15, 0.0, 0.0, 0.02, 0.0, 0.0], ..moduli() };
    let there = evaluate::<CorotationalSpace, 6>(&piece, Some(&curved), &moduli, &poses);

    // Turned about axis 2: axes 1 and 3 swap their senses. The curvature about 2 and the twist keep theirs.
    let turned = |axes: M3<f64>| [axes[0].map(|x| -x), axes[1], axes[2].map(|x| -x)];
    let end = pennate_elements::small::mul(&transpose(&rotation::matrix(whole)), &start);
    let back = turned(end);
    let chord = apply(&back, &tapply(&start, &chord.map(|x| -x)));
    let piece = Piece { length: LENGTH, axes: back, chord, bulge: [0.0; 3] };
    let middle = turned(pennate_elements::small::mul(&transpose(&rotation::matrix(half)), &start));
    // Columns are the axes at the middle in those of the new start.
    let curved = [pennate_elements::small::mul(&back, &transpose(&middle))];
    let again = evaluate::<CorotationalSpace, 6>(&piece, Some(&curved), &moduli, &[poses[1], poses[0]]);
    assert!((there.energy - again.energy).abs() < 1e-12 * there.energy, "{} {}", there.energy, again.energy);
    for i in 0..6 {
        assert!(
            (there.ends.r0[i] - again.ends.r1[i]).abs() < 1e-10 && (there.ends.r1[i] - again.ends.r0[i]).abs() < 1e-10
        );
    }
}

/// At a plane state the spatial element is the plane one, and its tangent out of the plane the lateral one; turned by
/// more than half a turn, stretched, with an initial curvature.
#[test]
fn plane_and_lateral_tangents_are_those_of_the_spatial_beam() {
    let angle = 0.4f64;
    let axes = [[angle.cos(), angle.sin(), 0.0], [-angle.sin(), angle.cos(), 0.0], [0.0, 0.0, 1.0]];
    let bend = 0.3f64;
    let curved = [[[bend.cos(), -bend.sin(), 0.0], [bend.sin(), bend.cos(), 0.0], [0.0, 0.0, 1.0]]];
    let spatial = moduli();
    let flat = plane::plane_moduli(&spatial);
    let bent = Piece { length: LENGTH, axes, chord: [4.6, 1.4, 0.0], bulge: [0.0; 3] };
    for (piece, curved) in [(straight(axes), None), (bent, Some(&curved))] {
        for ends in [[[0.3, -0.4, 0.7], [-0.6, 0.9, 1.2]], [[0.3, -0.4, 3.7], [-7.2, -8.5, 4.6]]] {
            let pose =
                |p: [f64; 3]| Pose { displacement: [p[0], p[1], 0.0], rotation: rotation::exp([0.0, 0.0, p[2]]) };
            let plane_one = evaluate::<CorotationalPlane, 3>(&piece, curved, &flat, &ends);
            let space_one = evaluate::<CorotationalSpace, 6>(&piece, curved, &spatial, &ends.map(pose));
            assert!((plane_one.energy - space_one.energy).abs() < 1e-12 * plane_one.energy);
            let largest = plane_one.ends.k11.iter().flatten().fold(0.0f64, |a, b| a.max(b.abs()));
            let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-11 * largest, "{a} {b}");
            const FLAT: [usize; 3] = [0, 1, 5];
            const SIDE: [usize; 3] = [2, 3, 4];

            let table = Table::<1>::new();
            let frame = CorotationalPlane::frame(&piece, &ends[0], &ends[1]);
            let local = [<CorotationalPlane as Beam<f64, 3>>::last_local(&frame)];
            let stress = [plane_one.stress];
            let at = At { table: &table, piece: &piece, curved, moduli: &flat, local: &local, stress: &stress };
            let mut out = Local::zero();
            plane::lateral::<f64, Corotational, 1>(&at, &spatial, &mut out);
            let side = plane::expand_lateral(&frame, &out.tangent[0][0], plane_one.local.mixed_end, None);
            for i in 0..3 {
                near(plane_one.ends.r0[i], space_one.ends.r0[FLAT[i]]);
                near(plane_one.ends.r1[i], space_one.ends.r1[FLAT[i]]);
                for j in 0..3 {
                    near(plane_one.ends.k00[i][j], space_one.ends.k00[FLAT[i]][FLAT[j]]);
                    near(plane_one.ends.k01[i][j], space_one.ends.k01[FLAT[i]][FLAT[j]]);
                    near(plane_one.ends.k11[i][j], space_one.ends.k11[FLAT[i]][FLAT[j]]);
                    near(side.k00[i][j], space_one.ends.k00[SIDE[i]][SIDE[j]]);
                    near(side.k01[i][j], space_one.ends.k01[SIDE[i]][SIDE[j]]);
                    near(side.k11[i][j], space_one.ends.k11[SIDE[i]][SIDE[j]]);
                }
            }
        }
    }
}

/// The tangent with stresses of their own: the derivative of the gradient that they have, and what the elastic ones add.
#[test]
fn mixed_tangent_is_that_of_the_mixed_functional() {
    let table = Table::<1>::new();
    let piece = straight(transpose(&rotation::matrix(rotation::exp([0.3, -0.5, 0.9]))));
    let local = [[-0.6, 0.4, 0.3, 0.2, -0.4, 0.3]];
    let stress = [[-20.0, 13.0, 9.0, 30.0, -40.0, 55.0]];
    let moduli = moduli();
    let at = At { table: &table, piece: &piece, curved: None, moduli: &moduli, local: &local, stress: &stress };
    let mut out = Local::<f64, 6, 1>::zero();
    CorotationalSpace::local::<1, true>(&at, &mut out);

    let h = 1e-6;
    let moved = |i: usize, by: f64| {
        let mut local = local;
        local[0][i] += by;
        local
    };
    // The gradient of given stresses: of a section without stiffness that holds all of them.
    let held = Moduli { stiffness: [0.0; 6], rest: [0.0; 6], held: [1.0; 6], softening: moduli.softening };
    let gradient = |local: &[[f64; 6]; 1]| {
        let mut out = Local::<f64, 6, 1>::zero();
        CorotationalSpace::local::<1, false>(&At { local, moduli: &held, ..at }, &mut out);
        out.gradient[0]
    };
    assert!(gradient(&local).iter().zip(out.mixed_end).all(|(a, b)| (a - b).abs() < 1e-13 * (1.0 + b.abs())));
    // The change of the stresses with the unknowns, and of the strains at the same stresses: K = Gᵀ dσ + ∂g.
    let change: [[f64; 6]; 6] = std::array::from_fn(|i| {
        let mut unit = [[0.0; 6]];
        unit[0][i] = 1.0;
        let ([with], [without]) =
            (CorotationalSpace::extrapolate(&at, &unit), CorotationalSpace::extrapolate(&at, &[[0.0; 6]]));
        sub(with, without)
    });
    for i in 0..6 {
        let (ahead, behind) = (gradient(&moved(i, h)), gradient(&moved(i, -h)));
        for j in 0..6 {
            let geometric = (ahead[j] - behind[j]) / (2.0 * h);
            // Gᵀ is what a unit of each stress adds to the gradient.
            let material: f64 = (0..6)
                .map(|d| {
                    let by = 1e-4;
                    let with = |s: f64| {
                        let mut stress = stress;
                        stress[0][d] += s;
                        let mut out = Local::<f64, 6, 1>::zero();
                        let at = At { stress: &stress, moduli: &held, ..at };
                        CorotationalSpace::local::<1, false>(&at, &mut out);
                        out.gradient[0][j]
                    };
                    (with(by) - with(-by)) / (2.0 * by) * change[i][d]
                })
                .sum();
            let entry = out.tangent[0][0][i][j];
            assert!((entry - geometric - material).abs() < 1e-6 * (1.0 + entry.abs()), "{i} {j}: {entry}");
        }
    }
}

/// A rigid motion of the unloaded bent element leaves it without strain, whole turns included.
#[test]
fn rigid_motions_make_no_strain() {
    let bend = [0.02, -0.05, 0.12];
    let half = rotation::matrix(rotation::exp(bend.map(|k| 0.5 * LENGTH * k)));
    let chord = apply(&rotation::tangent_map(bend.map(|k| LENGTH * k)), &[LENGTH, 0.0, 0.0]);
    let axes = transpose(&rotation::matrix(rotation::exp([0.3, -0.5, 0.9])));
    let piece = Piece { length: LENGTH, axes, chord, bulge: [0.0; 3] };
    let turn = compose(rotation::exp([2.0, -3.0, 1.0]), rotation::exp([0.0, 2.5, 2.0]));
    let end = tapply(&axes, &chord);
    let carried = sub(rotation::turn(turn, end), end);
    let poses = [Pose { displacement: [0.0; 3], rotation: turn }, Pose { displacement: carried, rotation: turn }];
    let moduli = Moduli { rest: [0.0; 6], ..moduli() };
    let found = evaluate::<CorotationalSpace, 6>(&piece, Some(&[half]), &moduli, &poses);
    assert!(found.strain.iter().all(|strain| strain.abs() < 1e-15), "{:?}", found.strain);
}
