//! Stability under loads without a potential: by small vibrations, with the masses that are known.

use nalgebra::Complex;
use pennate_solver::history::{Growth, StepHistory};
use pennate_testing::network;

/// Beck's column: a cantilever of unit stiffness, length and mass, under `follower` at its tip and `dead` along it, in the
/// plane or with another stiffness out of it.
fn column(follower: f64, dead: f64, out_of_plane: Option<f64>) -> StepHistory {
    let (z, more, dimension) = match out_of_plane {
        Some(ei2) => (", 0", format!("GJ = 1, EI2 = {ei2}, GA2 = 1e6, GA3 = 1e6, "), "space"),
        None => ("", String::new(), "plane"),
    };
    let held = if out_of_plane.is_some() { "" } else { ", shear = false, stretch = false" };
    let text = format!(
        "format = \"pennate/1\"\nunits = \"m-N-Pa\"\ndimension = \"{dimension}\"\n\
         [nodes]\nA = [0, 0{z}]\nB = [1, 0{z}]\n\
         [sections]\nstrip = {{ stiffness = {{ EA = 1e6, {more}EI3 = 1, mass_per_length = 1 }}{held} }}\n\
         [members]\ncolumn = {{ nodes = [\"A\", \"B\"], section = \"strip\" }}\n\
         [supports]\nA = \"clamped\"\n\
         [[steps]]\nname = \"push\"\nbranch = \"primary\"\n\
         follower_force = {{ B = [-{follower}, 0{z}] }}\nforce = {{ B = [-{dead}, 0{z}] }}\n"
    );
    network::solve(&text).step("push").clone()
}

fn growth(step: &StepHistory) -> Growth {
    let vibration = step.vibration.expect("a verdict by vibrations");
    assert_eq!(step.stable, Some(vibration.growth == Growth::None));
    vibration.growth
}

/// Its critical load is 20.05095 EI/L² (Beck 1952), where it begins to swing at 11.016 (EI/m)^½/L².
#[test]
fn the_column_of_beck_flutters_at_its_critical_load() {
    for (load, stable) in [(1.0, true), (19.0, true), (20.0508, true), (20.0511, false), (21.0, false), (60.0, false)] {
        let step = column(load, 0.0, None);
        match growth(&step) {
            Growth::None => assert!(stable, "{load}"),
            Growth::Flutter { frequency, .. } => {
                assert!(!stable, "{load}");
                assert!(load > 20.06 || (frequency - 11.016).abs() < 1e-2, "{load}: {frequency}");
            }
            other => panic!("{load}: {other:?}"),
        }
        assert_eq!(step.vibration.expect("vibrations").mass, 1.0);
    }
}

/// A column of radius 1.5 and length 100 mm under a follower force (N), on a clamped node that other members end at: nothing of theirs
/// reaches it. Its critical load is 20.05095 EI/L² = 15.94 N.
fn clamped_with(whiskers: &[[f64; 2]], force: f64) -> StepHistory {
    let mut text =
        "format = \"pennate/1\"\n[materials]\nm = { youngs_modulus = 2000, poissons_ratio = 0.3, density = 1e-9 }\n\
        [sections]\ns = { circle = { radius = 1.5 } }\n[supports]\nA = \"clamped\"\n\
        [members]\na = { nodes = [\"A\", \"B\"], section = \"s\", material = \"m\" }\n"
            .to_owned();
    let mut nodes = "[nodes]\nA = [0, 0]\nB = [0, 100]\n".to_owned();
    for (index, [x, y]) in whiskers.iter().enumerate() {
        text += &format!("w{index} = {{ nodes = [\"A\", \"W{index}\"], section = \"s\", material = \"m\" }}\n");
        nodes += &format!("W{index} = [{x}, {y}]\n");
    }
    text += &nodes;
    text += &format!("[[steps]]\nname = \"push\"\nfollower_force = {{ B = [0, -{force}] }}\n");
    network::solve(&text).step("push").clone()
}

/// Ten frequencies of long members lie below those of the column.
#[test]
fn members_that_no_load_reaches_hide_no_flutter() {
    for whiskers in
        [&[][..], &[[240.0, 0.0], [-264.0, 0.0]], &[[240.0, 0.0], [-264.0, 0.0], [200.0, 200.0], [-180.0, 220.0]]]
    {
        assert_eq!(growth(&clamped_with(whiskers, 15.5)), Growth::None);
        let Growth::Flutter { frequency, rate } = growth(&clamped_with(whiskers, 20.0)) else { panic!("{whiskers:?}") };
        // By another program: 533.6 /s at 178.5 Hz.
        assert!(
            (rate - 533.6).abs() < 5.0 && (frequency / std::f64::consts::TAU - 178.5).abs() < 0.5,
            "{rate} {frequency}"
        );
    }
}

/// Members that are alike have equal frequencies: the verdict ends, and is that of each by itself.
#[test]
fn equal_members_have_a_verdict() {
    for (force, stable) in [(15.0, true), (20.0, false)] {
        let step = clamped_with(&[[100.0, 0.0], [-100.0, 0.0], [0.0, -100.0]], force);
        assert_eq!(growth(&step) == Growth::None, stable, "{force}");
    }
}

/// A follower force across the tip that is small beside EI/L² (58 N for the tube) moves few frequencies by more than rounding: those of motions
/// that it reaches are judged all the same, on the mesh that the state itself needs.
#[test]
fn small_follower_forces_have_a_verdict() {
    let sections = [
        "annulus = { outer_radius = 5, wall = 1 }",
        "circle = { radius = 4 }",
        "rectangle = { width = 8, height = 5 }",
    ];
    for (section, dimension) in
        sections.into_iter().flat_map(|section| ["plane", "space"].map(|dimension| (section, dimension)))
    {
        for force in [4.0, 0.4, -0.04, 4e-5] {
            let text = format!(
                r#"format = "pennate/1"
                dimension = "{dimension}"
                nodes = {{ A = [0, 0], B = [100, 0] }}
                materials.m = {{ youngs_modulus = 2000, poissons_ratio = 0.3, density = 1e-9 }}
                sections.s = {{ {section} }}
                members.b = {{ nodes = ["A", "B"], section = "s", material = "m" }}
                supports.A = "clamped"
                steps = [{{ name = "push", follower_force = {{ B = [0, {force}] }} }}]"#
            );
            let solved = network::solve(&text);
            assert_eq!(solved.step("push").stable, Some(true), "{section} {dimension} {force}");
        }
    }
}

/// Beyond its critical load Beck's column swings and grows by a root of 2 ω² + p² + p ω sin a sinh b + 2 ω² cos a cosh b = 0, where
/// a² and b² are (p² / 4 + ω²)^½ with p / 2 added and taken away: rate and frequency are as near to it as they say.
#[test]
fn rates_and_frequencies_know_their_error() {
    for load in [21.0, 25.0, 60.0, 90.0] {
        let step = column(load, 0.0, None);
        let vibration = step.vibration.expect("vibrations");
        let Growth::Flutter { frequency, rate } = vibration.growth else { panic!("{load}: {:?}", vibration.growth) };
        let found = Complex::new(frequency, rate);
        let of = |omega: Complex<f64>| {
            let root = (omega * omega + 0.25 * load * load).sqrt();
            let (a, b) = ((root + 0.5 * load).sqrt(), (root - 0.5 * load).sqrt());
            let squares = omega * omega * 2.0;
            squares + load * load + omega * a.sin() * b.sinh() * load + squares * a.cos() * b.cosh()
        };
        // Newton's method from there, with differences.
        let mut exact = found;
        for _ in 0..20 {
            let h = Complex::new(1e-6 * exact.norm(), 0.0);
            exact -= of(exact) * h * 2.0 / (of(exact + h) - of(exact - h));
        }
        let error = (found - exact).norm() / exact.norm();
        println!("{load}: {error:.1e}, {:.1e} stated", vibration.error);
        assert!(
            error <= 2.0 * vibration.error && vibration.error < 0.1,
            "{load}: {error:.1e}, {:.1e} stated",
            vibration.error
        );
    }
}

/// In space too, where it is as soft to all sides, so that all frequencies come in pairs, and where it is stiffer to one. Sheared a
/// little, it is critical by 1e-5 of the load sooner.
#[test]
fn it_flutters_to_the_side_that_is_softest() {
    for ei2 in [1.0, 2.0] {
        assert_eq!(growth(&column(20.05, 0.0, Some(ei2))), Growth::None, "{ei2}");
        assert!(matches!(growth(&column(20.06, 0.0, Some(ei2))), Growth::Flutter { .. }), "{ei2}");
    }
}

/// The same column in forty members: 720 unknowns in the plane, 1,440 in space.
#[test]
fn a_column_of_many_members_flutters_at_the_same_load() {
    const MEMBERS: usize = 40;
    for space in [false, true] {
        let (z, dimension) = if space { (", 0", "space") } else { ("", "plane") };
        let nodes: String = (0..=MEMBERS).map(|i| format!("n{i} = [{}, 0{z}]\n", i as f64 / MEMBERS as f64)).collect();
        let bar = |i: usize| format!("m{i} = {{ nodes = [\"n{i}\", \"n{}\"], section = \"strip\" }}\n", i + 1);
        let members: String = (0..MEMBERS).map(bar).collect();
        for (load, stable) in [(20.04, true), (20.06, false)] {
            let text = format!(
                "format = \"pennate/1\"\nunits = \"m-N-Pa\"\ndimension = \"{dimension}\"\n[nodes]\n{nodes}\
                 [sections]\nstrip = {{ stiffness = {{ EA = 1e5, GJ = 3, EI2 = 4, EI3 = 1, mass_per_length = 1 }} }}\n\
                 [members]\n{members}[supports]\nn0 = \"clamped\"\n\
                 [[steps]]\nname = \"push\"\nfollower_force = {{ n{MEMBERS} = [-{load}, 0{z}] }}\n"
            );
            let step = network::solve(&text).step("push").clone();
            let grown = growth(&step);
            assert_eq!(grown == Growth::None, stable, "{dimension} {load}");
            assert!(stable || matches!(grown, Growth::Flutter { .. }), "{dimension} {load}: {grown:?}");
        }
    }
}

/// A cantilever of unit stiffness and length under a follower load at its tip, with springs there across (0.714) and against rotation
/// (6.95): its straight state is lost to divergence at 14.8 and found again at 29.0, with nothing bent in between. Clamped at 0 its
/// deflections are A (cos kx - 1) + B (sin kx - kx).
#[test]
fn a_stiffness_that_a_follower_load_takes_and_gives_back_is_seen() {
    let (across, against, load) = (0.714, 6.95, 34.6);
    let text = format!(
        "format = \"pennate/1\"\nunits = \"m-N-Pa\"\ndimension = \"plane\"\n\
         nodes = {{ A = [0, 0], B = [1, 0] }}\n\
         sections.rod = {{ stiffness = {{ EI3 = 1 }}, stretch = false, shear = false }}\n\
         members.column = {{ nodes = [\"A\", \"B\"], section = \"rod\", elements = 8 }}\n\
         supports.A = \"clamped\"\n\
         springs.tip = {{ node = \"B\", stiffness = {{ uy = {across}, rz = {against} }} }}\n\
         steps = [{{ name = \"push\", follower_force = {{ B = [-{load}, 0] }}, branch = \"primary\" }}]\n"
    );
    let step = network::solve(&text).step("push").clone();
    let determinant = |load: f64| {
        let k = load.sqrt();
        let (sin, cos) = k.sin_cos();
        let moment = [-k * k * cos - against * k * sin, -k * k * sin + against * k * (cos - 1.0)];
        let shear = [k.powi(3) * sin - across * (cos - 1.0), -k.powi(3) * cos - across * (sin - k)];
        moment[0] * shear[1] - moment[1] * shear[0]
    };
    assert_eq!(step.critical_points.len(), 2, "{:?}", step.critical_points);
    for (point, [mut low, mut high]) in step.critical_points.iter().zip([[10.0, 20.0], [25.0, 33.0]]) {
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let is_beyond = (determinant(middle) > 0.0) == (determinant(high) > 0.0);
            *(if is_beyond { &mut high } else { &mut low }) = middle;
        }
        let found = load * point.fraction;
        assert!((found / low - 1.0).abs() < 2e-6, "{found} for {low}");
    }
}

/// Under a load of which a small part alone follows it diverges, at π²/4 EI/L² as under a dead load.
#[test]
fn divergence_is_told_apart_from_flutter() {
    let euler = std::f64::consts::PI.powi(2) / 4.0;
    assert_eq!(growth(&column(1e-4, 0.999 * euler, None)), Growth::None);
    let Growth::Divergence { rate } = growth(&column(1e-4, 1.001 * euler, None)) else { panic!("no divergence") };
    assert!(rate > 0.0 && rate < 1.0, "{rate}");
}

/// Two rigid bars on hinges of stiffness k, with masses 2 m in the middle and m at the tip: (7/2 − √2) k/L (Ziegler 1952). The
/// hinges are a thousandth of the bars long, and add that much to the lever of the load.
#[test]
fn the_pendulum_of_ziegler_flutters_at_its_critical_load() {
    let critical = 3.5 - 2f64.sqrt();
    for (part, flutters) in [(0.5, false), (0.999, false), (1.002, true), (1.5, true)] {
        let hinge = 1e-3;
        let text = format!(
            "format = \"pennate/1\"\nunits = \"m-N-Pa\"\ndimension = \"plane\"\n\
             [nodes]\nO = [0, 0]\nA = [{hinge}, 0]\nB = [1, 0]\nC = [{}, 0]\nT = [2, 0]\n\
             [sections]\nhinge = {{ stiffness = {{ EA = 1e4, EI3 = {hinge} }}, shear = false }}\n\
             [members]\nfirst = {{ nodes = [\"O\", \"A\"], section = \"hinge\" }}\n\
             second = {{ nodes = [\"B\", \"C\"], section = \"hinge\" }}\n\
             [rigid_bodies]\nlower = {{ nodes = [\"A\", \"B\"], reference = \"B\", mass = 2 }}\n\
             upper = {{ nodes = [\"C\", \"T\"], reference = \"T\", mass = 1 }}\n\
             [supports]\nO = \"clamped\"\n\
             [[steps]]\nname = \"push\"\nfollower_force = {{ T = [{}, 0] }}\n",
            1.0 + hinge,
            -part * critical
        );
        let found = growth(network::solve(&text).step("push"));
        assert_eq!(matches!(found, Growth::Flutter { .. }), flutters, "{part}: {found:?}");
    }
}

/// A rod of stiffness one in every way but the one of `ei2` under a twisting moment at its free end, and what else there is.
fn twisted(ei2: f64, moment: f64, more: &str) -> StepHistory {
    let text = format!(
        "format = \"pennate/1\"\nunits = \"m-N-Pa\"\nnodes.A = [0, 0, 0]\nnodes.B = [1, 0, 0]\n{more}\
         [sections]\nrod = {{ stiffness = {{ EA = 1e5, GA2 = 1e5, GA3 = 1e5, GJ = 1, EI2 = {ei2}, EI3 = 1, mass_per_length = 1 }} }}\n\
         [members]\nrod = {{ nodes = [\"A\", \"B\"], section = \"rod\" }}\n[supports]\nA = \"clamped\"\n\
         [[steps]]\nname = \"twist\"\nmoment = {{ B = [{moment}, 0, 0] }}\n"
    );
    network::solve(&text).step("twist").clone()
}

/// A round rod flutters under however small a twisting moment at its free end, an oval one does not (Nikolai 1928).
#[test]
fn the_rod_of_nikolai_flutters_where_it_is_round() {
    for (ei2, moment, flutters) in
        [(1.0, 0.01, true), (1.0, 0.5, true), (1.5, 0.01, false), (1.5, 0.5, false), (1.5, 2.0, true)]
    {
        let found = growth(&twisted(ei2, moment, ""));
        assert_eq!(matches!(found, Growth::Flutter { .. }), flutters, "{ei2} {moment}: {found:?}");
    }
}

/// The rate is the same beside a body on soft springs, whose frequency lies below it by up to eight orders of magnitude.
#[test]
fn a_heavy_body_beside_it_hides_no_flutter() {
    let rate = |more: &str| match growth(&twisted(1.0, 0.5, more)) {
        Growth::Flutter { rate, frequency } => [rate, frequency],
        other => panic!("{other:?}"),
    };
    let alone = rate("");
    for mass in [1e-3, 1.0, 1e3, 1e6, 1e10, 1e14] {
        let beside = rate(&format!(
            "nodes.P = [2, 2, 0]\nrigid_bodies.stage = {{ nodes = [\"P\"], mass = {mass:e} }}\n\
             springs.soft = {{ node = \"P\", stiffness = {{ ux = 0.01, uy = 0.01, uz = 0.01, rx = 1, ry = 1, rz = 1 }} }}\n"
        ));
        for (beside, alone) in beside.iter().zip(alone) {
            assert!((beside / alone - 1.0).abs() < 1e-6, "{mass:e}: {beside} instead of {alone}");
        }
    }
}

/// Nor does one on the rod itself: a body at its middle that is heavy enough holds that as a support does.
#[test]
fn a_heavy_body_on_a_rod_is_a_support_to_what_flutters() {
    let rate = |more: &str| {
        let text = format!(
            "format = \"pennate/1\"\nunits = \"m-N-Pa\"\nnodes = {{ A = [0, 0, 0], B = [1, 0, 0], C = [2, 0, 0] }}\n\
             sections.rod = {{ stiffness = {{ EA = 1e5, GA2 = 1e5, GA3 = 1e5, GJ = 1, EI2 = 1, EI3 = 1, mass_per_length = 1 }} }}\n\
             members.first = {{ nodes = [\"A\", \"B\"], section = \"rod\" }}\n\
             members.second = {{ nodes = [\"B\", \"C\"], section = \"rod\" }}\nsupports.A = \"clamped\"\n{more}\n\
             [[steps]]\nname = \"twist\"\nmoment = {{ C = [0.5, 0, 0] }}\n"
        );
        match growth(network::solve(&text).step("twist")) {
            Growth::Flutter { rate, frequency } => [rate, frequency],
            other => panic!("{more}: {other:?}"),
        }
    };
    let held = rate("supports.B = \"pinned\"");
    for mass in [1e8, 1e10, 1e12] {
        let heavy = rate(&format!("rigid_bodies.body = {{ nodes = [\"B\"], mass = {mass:e} }}"));
        for (heavy, held) in heavy.iter().zip(held) {
            assert!((heavy / held - 1.0).abs() < 1e-6, "{mass:e}: {heavy} instead of {held}");
        }
    }
}

/// Without masses there is no verdict, and no guess at one.
#[test]
fn without_masses_nothing_is_said() {
    let text = "format = \"pennate/1\"\nunits = \"m-N-Pa\"\ndimension = \"plane\"\n[nodes]\nA = [0, 0]\nB = [1, 0]\n\
                [sections]\nstrip = { stiffness = { EA = 1e6, EI3 = 1 }, shear = false }\n\
                [members]\ncolumn = { nodes = [\"A\", \"B\"], section = \"strip\" }\n[supports]\nA = \"clamped\"\n\
                [[steps]]\nname = \"push\"\nfollower_force = { B = [-1, 0] }\n";
    let solved = network::solve(text);
    let step = solved.step("push");
    assert_eq!((step.stable, step.vibration), (None, None));
}
