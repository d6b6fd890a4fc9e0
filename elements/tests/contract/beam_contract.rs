//! Beams of every order keep the element contract, straight and curved, in space, in the plane and out of it.

use pennate_elements::beam::{At, Beam, Condensed, Local, Moduli, Piece};
use pennate_elements::check::{Answer, contract};
use pennate_elements::interpolation::Table;
use pennate_elements::laws::{Exact, Formulation, LocalLaw, WithLaw};
use pennate_elements::plane::{self, Plane};
use pennate_elements::rotation;
use pennate_elements::small::{M3, mul, transpose};
use pennate_elements::space::{Pose, Space, SpatialBeam};

fn moduli() -> Moduli<f64, 6> {
    Moduli {
        stiffness: [300.0, 60.0, 40.0, 500.0, 700.0, 1100.0],
        rest: [-0.15, 0.0, 0.0, 0.01, -0.02, 0.03],
        held: [0.0; 6],
        softening: [0.0021, 0.0034],
    }
}

fn piece(curved: bool) -> (Piece<f64>, [f64; 3]) {
    let axes = transpose(&rotation::matrix(rotation::exp([0.3, -0.5, 0.9])));
    let chord = if curved { [4.7, 1.0, 0.4] } else { [5.0, 0.0, 0.0] };
    let piece = Piece { length: 5.0, axes, chord, bulge: [0.0; 3] };
    (piece, pennate_elements::small::tapply(&axes, &chord))
}

/// Any rotations serve: the contract holds for whatever unloaded curve the axes describe.
fn curve<const P: usize>() -> [M3<f64>; P] {
    std::array::from_fn(|g| {
        let s = (g as f64 + 0.5) / P as f64;
        rotation::matrix(rotation::exp([0.1 * s, -0.2 * s, 0.5 * s]))
    })
}

fn space_contract<L: LocalLaw, const P: usize>(curved: bool, turn: [f64; 3]) {
    let table = Table::<P>::new();
    let (piece, end) = piece(curved);
    let (moduli, axes) = (moduli(), curve::<P>());
    let own = rotation::exp([0.2, 0.7, -0.3]);
    let poses = [
        Pose { displacement: [0.3, -0.4, 0.2], rotation: own },
        Pose { displacement: [-0.6, 0.9, 1.1], rotation: rotation::compose(own, rotation::exp(turn)) },
    ];
    let interior: [[f64; 6]; P] =
        std::array::from_fn(|i| std::array::from_fn(|d| 0.1 * ((3 * i + d) as f64 * 1.7).sin()));
    let respond = |poses: &[Pose<f64>]| {
        let frame = Space::frame(&piece, &poses[0], &poses[1]);
        let mut local = interior;
        local[P - 1] = Space::last_local(&frame);
        let zero = [[0.0; 6]; P];
        let at = At {
            table: &table,
            piece: &piece,
            curved: curved.then_some(&axes),
            moduli: &moduli,
            local: &local,
            stress: &zero,
        };
        // From no stress and for no change, the stresses are those of the strains.
        let stress = SpatialBeam::<L>::extrapolate(&at, &zero);
        let mut out = Local::zero();
        SpatialBeam::<L>::local::<P, true>(&At { stress: &stress, ..at }, &mut out);
        let condensed = Condensed {
            tangent: out.tangent[P - 1][P - 1],
            gradient: out.gradient[P - 1],
            mixed_end: out.mixed_end,
            turn: None,
        };
        let ends = Space::expand(&frame, &condensed);
        let mut tangent = vec![vec![0.0; 12]; 12];
        for i in 0..6 {
            for j in 0..6 {
                tangent[i][j] = ends.k00[i][j];
                tangent[i][6 + j] = ends.k01[i][j];
                tangent[6 + j][i] = ends.k01[i][j];
                tangent[6 + i][6 + j] = ends.k11[i][j];
            }
        }
        Answer { energy: out.energy, gradient: vec![ends.r0, ends.r1], tangent }
    };
    contract(&[[0.0; 3], end], &poses, &respond);
}

/// The contract of every order of a law.
struct Contract {
    curved: bool,
    turn: [f64; 3],
}

impl WithLaw for Contract {
    type Output = ();

    fn with<L: LocalLaw>(self) {
        let Self { curved, turn } = self;
        space_contract::<L, 1>(curved, turn);
        if L::HIGHER_ORDERS {
            space_contract::<L, 2>(curved, turn);
            space_contract::<L, 3>(curved, turn);
            space_contract::<L, 4>(curved, turn);
            space_contract::<L, 5>(curved, turn);
        }
    }
}

#[test]
fn spatial_beams_keep_the_contract() {
    for formulation in Formulation::ALL {
        for curved in [false, true] {
            formulation.apply(Contract { curved, turn: [0.3, -0.6, 0.8] });
        }
    }
}

/// Up to large turns within one element, and at none.
#[test]
fn beams_of_two_nodes_keep_the_contract_over_large_turns() {
    for formulation in Formulation::ALL.iter().filter(|formulation| !formulation.has_higher_orders()) {
        for curved in [false, true] {
            for turn in [[0.0; 3], [1e-5, -2e-5, 1e-5], [1.2, 0.7, -1.3]] {
                formulation.apply(Contract { curved, turn });
            }
        }
    }
}

/// The interior of the local tangent against differences of the local gradient.
#[test]
fn local_tangent_is_the_derivative_of_the_local_gradient() {
    fn check<const P: usize>(curved: bool) {
        let table = Table::<P>::new();
        let (piece, _) = piece(curved);
        let (moduli, axes) = (moduli(), curve::<P>());
        let local: [[f64; 6]; P] =
            std::array::from_fn(|i| std::array::from_fn(|d| 0.3 * ((3 * i + 2 * d) as f64 * 1.3).cos()));
        let run = |local: &[[f64; 6]; P]| {
            let zero = [[0.0; 6]; P];
            let at = At {
                table: &table,
                piece: &piece,
                curved: curved.then_some(&axes),
                moduli: &moduli,
                local,
                stress: &zero,
            };
            let strains = Space::strains(&at);
            let stress: [[f64; 6]; P] = std::array::from_fn(|g| {
                std::array::from_fn(|i| moduli.stiffness[i] * (strains[g][i] - moduli.rest[i]))
            });
            let mut out = Local::zero();
            Space::local::<P, true>(&At { stress: &stress, ..at }, &mut out);
            out
        };
        let out = run(&local);
        let h = 1e-6;
        for i in 0..P {
            for d in 0..6 {
                let (mut ahead, mut behind) = (local, local);
                ahead[i][d] += h;
                behind[i][d] -= h;
                let (ahead, behind) = (run(&ahead), run(&behind));
                for j in i..P {
                    for e in 0..6 {
                        let slope = (ahead.gradient[j][e] - behind.gradient[j][e]) / (2.0 * h);
                        assert!((slope - out.tangent[i][j][d][e]).abs() < 1e-5, "{i}{d} {j}{e}");
                    }
                }
            }
        }
    }
    for curved in [false, true] {
        check::<2>(curved);
        check::<3>(curved);
    }
}

/// Elements of an order, straight, their nodes anywhere: energy and the forces on both ends, and the same turned end for end.
struct FromEitherEnd;

impl WithLaw for FromEitherEnd {
    type Output = ();

    fn with<L: LocalLaw>(self) {
        from_either_end::<L, 1>();
        if L::HIGHER_ORDERS {
            from_either_end::<L, 2>();
            from_either_end::<L, 3>();
            from_either_end::<L, 4>();
            from_either_end::<L, 5>();
        }
    }
}

fn from_either_end<L: LocalLaw, const P: usize>() {
    let table = Table::<P>::new();
    let moduli = Moduli { rest: [-0.15, 0.0, 0.0, 0.02, 0.0, 0.0], ..moduli() };
    let place = |i: usize| 5.0 * i as f64 / P as f64;
    // Poses of all nodes: those of a screw, and something beside it.
    let direction = transpose(&rotation::matrix(rotation::exp([0.3, -0.5, 0.9])));
    let poses: Vec<Pose<f64>> = (0..=P)
        .map(|i| {
            let s = i as f64;
            let beside = [0.1 * (1.7 * s).sin(), 0.2 * (0.6 * s).cos(), -0.1 * (2.3 * s).sin()];
            Pose { displacement: beside, rotation: rotation::exp([0.2 + 0.3 * s, 0.7 - 0.2 * s, beside[1] + 0.4 * s]) }
        })
        .collect();
    let evaluate = |axes: M3<f64>, poses: &[Pose<f64>]| {
        let piece = Piece { length: 5.0, axes, chord: [5.0, 0.0, 0.0], bulge: [0.0; 3] };
        let ends = [&poses[0], &poses[P]];
        let frame = Space::frame(&piece, ends[0], ends[1]);
        let local: [[f64; 6]; P] =
            std::array::from_fn(|i| Space::local_at(&piece, ends, &poses[i + 1], [place(i + 1), 0.0, 0.0]));
        let last = Space::last_local(&frame);
        assert!((0..6).all(|d| (local[P - 1][d] - last[d]).abs() < 1e-14));
        let zero = [[0.0; 6]; P];
        let at = At { table: &table, piece: &piece, curved: None, moduli: &moduli, local: &local, stress: &zero };
        let mut out = Local::zero();
        SpatialBeam::<L>::local::<P, false>(&at, &mut out);
        out.energy
    };
    // Turned about axis 2: axes 1 and 3 swap their senses.
    let back = [direction[0].map(|x| -x), direction[1], direction[2].map(|x| -x)];
    let reversed: Vec<_> = poses.iter().rev().copied().collect();
    let (there, again) = (evaluate(direction, &poses), evaluate(back, &reversed));
    assert!((there - again).abs() < 1e-13 * there, "order {P}: {there} {again}");
}

/// An element knows no first and no last node, so that a symmetric network is one on its mesh.
#[test]
fn elements_are_the_same_from_either_end() {
    for formulation in Formulation::ALL {
        formulation.apply(FromEitherEnd);
    }
}

/// The plane beam is the spatial one at a plane state; what the plane leaves out is its lateral tangent.
#[test]
fn plane_and_lateral_tangents_are_those_of_the_spatial_beam() {
    const P: usize = 1;
    let table = Table::<P>::new();
    let angle = 0.4f64;
    let axes = [[angle.cos(), angle.sin(), 0.0], [-angle.sin(), angle.cos(), 0.0], [0.0, 0.0, 1.0]];
    let bend = 0.3f64;
    let curved = [[[bend.cos(), -bend.sin(), 0.0], [bend.sin(), bend.cos(), 0.0], [0.0, 0.0, 1.0]]];
    let piece = Piece { length: 5.0, axes, chord: [4.8, 0.9, 0.0], bulge: [0.0; 3] };
    let stiffness = [300.0, 60.0, 40.0, 500.0, 700.0, 1100.0];
    let spatial = Moduli { stiffness, rest: [-0.15, 0.0, 0.0, 0.0, 0.0, 0.03], held: [0.0; 6], softening: [0.0; 2] };
    let flat = plane::plane_moduli(&spatial);
    let (first, last) = ([0.3, -0.4, 0.7], [-0.6, 0.9, 1.2]);
    let frame = Plane::frame(&piece, &first, &last);
    let local = [<Plane as Beam<f64, 3>>::last_local(&frame)];
    let zero = [[0.0; 3]; P];
    let at = At { table: &table, piece: &piece, curved: Some(&curved), moduli: &flat, local: &local, stress: &zero };
    // One Gauss point in the middle: the Gibbs interpolation differs there from that of the angle, so the spatial beam
    // is given the angle of the plane one by halving tan(θ/2) accordingly.
    let strains = Plane::strains(&at);
    let stress: [[f64; 3]; P] = [std::array::from_fn(|i| flat.stiffness[i] * (strains[0][i] - flat.rest[i]))];
    let at = At { stress: &stress, ..at };
    let mut out = Local::zero();
    Plane::local::<P, true>(&at, &mut out);
    let condensed =
        Condensed { tangent: out.tangent[0][0], gradient: out.gradient[0], mixed_end: out.mixed_end, turn: None };
    let ends = <Plane as Beam<f64, 3>>::expand(&frame, &condensed);

    // In-plane: differences of the gradient.
    let gradient = |first: [f64; 3], last: [f64; 3]| {
        let frame = Plane::frame(&piece, &first, &last);
        let local = [<Plane as Beam<f64, 3>>::last_local(&frame)];
        let at = At { local: &local, ..at };
        let mut out = Local::zero();
        Plane::local::<P, false>(&at, &mut out);
        Plane::expand_gradient(&frame, &out.gradient[0], [0.0; 3])
    };
    let h = 1e-6;
    for d in 0..3 {
        let (mut a, mut b) = (last, last);
        a[d] += h;
        b[d] -= h;
        let (a, b) = (gradient(first, a), gradient(first, b));
        let (mut c, mut e) = (first, first);
        c[d] += h;
        e[d] -= h;
        let (c, e) = (gradient(c, last), gradient(e, last));
        for i in 0..3 {
            assert!(((a[0][i] - b[0][i]) / (2.0 * h) - ends.k01[i][d]).abs() < 1e-5);
            assert!(((a[1][i] - b[1][i]) / (2.0 * h) - ends.k11[i][d]).abs() < 1e-5);
            assert!(((c[0][i] - e[0][i]) / (2.0 * h) - ends.k00[i][d]).abs() < 1e-5);
            assert!(((c[1][i] - e[1][i]) / (2.0 * h) - ends.k01[d][i]).abs() < 1e-5);
        }
    }

    // Out of the plane: against the spatial beam turned rigidly about an axis in the plane. The moments and forces of a
    // rigid spin φ about an in-plane axis turn with it: K φ-motion = φ × force, exactly as for the spatial beam.
    let mut lateral = Local::zero();
    plane::lateral::<f64, Exact, P>(&at, &spatial, &mut lateral);
    let side = plane::expand_lateral(&frame, &lateral.tangent[0][0], out.mixed_end, None);
    let [r0, r1] = Plane::expand_gradient(&frame, &out.gradient[0], [0.0; 3]);
    let x = mul(&transpose(&axes), &[[4.8], [0.9], [0.0]]);
    let x1 = [x[0][0] + last[0] - first[0], x[1][0] + last[1] - first[1]];
    for (px, py) in [(1.0, 0.0), (0.0, 1.0)] {
        // spin (px, py, 0) about the first node: uz at the last node is px y − py x.
        let first_motion = [0.0, px, py];
        let last_motion = [px * x1[1] - py * x1[0], px, py];
        let apply = |k: &[[f64; 3]; 3], v: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|i| k[i][0] * v[0] + k[i][1] * v[1] + k[i][2] * v[2])
        };
        let a = apply(&side.k00, first_motion);
        let b = apply(&side.k01, last_motion);
        let c = apply(&transpose(&side.k01), first_motion);
        let e = apply(&side.k11, last_motion);
        // d(force)_z = φ × f, and H φ = ∂m/∂φ φ + ½ m × φ = φ × m + ½ m × φ = ½ φ × m for m along z.
        let expect = |r: [f64; 3]| [px * r[1] - py * r[0], 0.5 * py * r[2], -0.5 * px * r[2]];
        for (got, want) in
            [(pennate_elements::small::add(a, b), expect(r0)), (pennate_elements::small::add(c, e), expect(r1))]
        {
            for i in 0..3 {
                assert!((got[i] - want[i]).abs() < 1e-9, "{got:?} {want:?}");
            }
        }
    }
}
