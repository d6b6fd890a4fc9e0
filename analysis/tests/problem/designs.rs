//! Many designs at once against the same designs one by one.

use std::time::{Duration, Instant};

use pennate_analysis::problem::{Control, Problem, ProblemError, Reason};
use pennate_models::Document;

const DYAD: &str = include_str!("../../../models/networks/dyad.toml");
const INVERTER: &str = include_str!("inverter.toml");
const STAGE: &str = include_str!("../../../models/networks/tip_tilt_stage.toml");
const TRIPOD: &str = include_str!("../../../models/networks/tripod.toml");
const ARM: &str = include_str!("../../../examples/designs/br2.toml");
const HEAD: &str =
    "format = \"pennate/1\"\nsections = { bar = { stiffness = { EA = 2000, GA2 = 700, EI3 = 4000 } } }\n";

/// Numbers between −1 and 1, the same for the same seed.
fn numbers(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        2.0 * (seed >> 11) as f64 / (1_u64 << 53) as f64 - 1.0
    }
}

/// Random designs by a part of their values about those of the file: the largest difference over the largest value of an
/// output, and how many have no answer. Those that have none have none one by one either.
fn compare(text: &str, parameters: &[&str], probes: &[&str], spread: f64) -> usize {
    let document = Document::from_text("network.toml", text);
    let problem = Problem::new(&document, &[], parameters, probes, 1e-6).unwrap();
    let mut random = numbers(7);
    let middle = problem.middle();
    let rows: Vec<f64> =
        (0..30).flat_map(|_| middle.iter().map(|x| x * (1.0 + spread * random())).collect::<Vec<_>>()).collect();
    let all = problem.evaluate(&rows);
    let outputs = probes.len();
    let largest = |output: usize| {
        all.values.iter().skip(output).step_by(outputs).filter(|y| y.is_finite()).fold(0.0f64, |m, y| m.max(y.abs()))
    };
    let mut unanswered = 0;
    for (design, row) in rows.chunks_exact(middle.len()).enumerate() {
        let (alone, reason, stable) = problem.evaluate_alone(row);
        assert_eq!(stable, all.stable[design], "{row:?}");
        assert_eq!(reason.is_some(), all.reasons[design].is_some(), "{row:?}: {reason:?} {:?}", all.reasons[design]);
        unanswered += usize::from(reason.is_some());
        for (output, &one) in alone.iter().enumerate() {
            let other = all.values[design * outputs + output];
            let miss = (one - other).abs();
            assert!(one.is_nan() && other.is_nan() || miss <= 1e-9 * largest(output), "{row:?}: {one} {other}");
        }
    }
    unanswered
}

#[test]
fn designs_of_ten_topologies_have_the_answers_that_they_have_alone() {
    let dyad = DYAD.replace("L = 130", "p = 20\nL = 130").replace("left = \"25 psi\", pair = 25", "all = \"= p\"");
    assert_eq!(compare(&dyad, &["p", "L", "beta"], &["stroke@inflate", "holding", "gear"], 0.1), 0);
    let kept = dyad.replace("displacement = { J = { uy = 0.0 } }", "displace_by = { J = { uy = 3 } }");
    assert_eq!(compare(&kept, &["p", "beta"], &["holding"], 0.1), 0);
    assert_eq!(compare(STAGE, &["L", "beta", "rp"], &["height", "tilt@tilt"], 0.05), 0);
    let tripod = format!("{TRIPOD}\n").replace("[probes]", "[probes]\nlow = { node = \"plate\", position = \"z\" }");
    assert_eq!(compare(&tripod, &["side", "foot"], &["low"], 0.05), 0);
    assert_eq!(compare(ARM, &["Pb", "Pr"], &["x", "y", "z"], 0.1), 0);
    let cantilever = r#"
        nodes = { A = [0, 0], B = ["= L", 0] }
        members = { rod = { nodes = ["A", "B"], section = "bar" } }
        supports = { A = "clamped" }
        steps = [{ force = { B = [0, "= F"] } }, { moment = { B = [0, 0, "= 10 * F"] } }]
        probes = { uy = { node = "B", displacement = "uy" }, root = { node = "A", reaction = "rz" } }
    "#;
    assert_eq!(
        compare(&format!("{HEAD}parameters = {{ L = 100, F = 0.4 }}\n{cantilever}"), &["L", "F"], &["uy", "root"], 0.3),
        0
    );
    let follower = cantilever.replace("force", "follower_force");
    assert_eq!(
        compare(&format!("{HEAD}parameters = {{ L = 100, F = 0.4 }}\n{follower}"), &["L", "F"], &["uy", "root"], 0.3),
        0
    );
    let portal = r#"
        parameters = { w = 100, h = 80, F = 1 }
        nodes = { A = [0, 0], B = [0, "= h"], C = ["= w", "= h"], D = ["= w", 0] }
        members = { left = { nodes = ["A", "B"], section = "bar" }, beam = { nodes = ["B", "C"], section = "bar", release = { start = "pin" } },
                    right = { nodes = ["C", "D"], section = "bar" } }
        supports = { A = "clamped", D = "pinned" }
        springs = { grip = { node = "C", stiffness = { ux = 0.05 } } }
        steps = [{ force = { B = ["= F", "= -F"] } }]
        probes = { sway = { node = "B", displacement = "ux" } }
    "#;
    assert_eq!(compare(&format!("{HEAD}{portal}"), &["w", "h", "F"], &["sway"], 0.2), 0);
    let beam = r#"
        parameters = { L = 100, q = -0.02 }
        nodes = { A = [0, 0], B = ["= L", 0] }
        members = { rod = { nodes = ["A", "B"], section = "bar" } }
        supports = { A = "clamped", B = ["uy"] }
        steps = [{ distributed = { rod = [0, "= q"] } }]
        probes = { end = { node = "B", rotation = "rz" }, force = { node = "B", reaction = "uy" } }
    "#;
    assert_eq!(compare(&format!("{HEAD}{beam}"), &["L", "q"], &["end", "force"], 0.3), 0);
    // An arch that snaps through: some designs have an answer, and some have none.
    let arch = r#"
        dimension = "plane"
        parameters = { F = 0.5, h = 10 }
        nodes = { A = [-100, 0], C = [0, "= h"], B = [100, 0] }
        members = { a = { nodes = ["A", "C"], section = "bar" }, b = { nodes = ["C", "B"], section = "bar" } }
        supports = { A = "pinned", B = "pinned" }
        steps = [{ force = { C = [0, "= -F"] } }]
        probes = { drop = { node = "C", displacement = "uy" } }
    "#;
    compare(&format!("{HEAD}{arch}"), &["F", "h"], &["drop"], 0.6);
}

/// Ends that nobody reads are foretold by parabolas and found roughly, but for those whose places the next step keeps.
#[test]
fn steps_in_a_row_end_where_they_end_alone() {
    let rods = r#"
        parameters = { L = 100, F = 0.08 }
        nodes = { A = [0, 0, 0], B = ["= L", 0, 0], C = ["= L", "= 0.6 * L", 0] }
        sections = { bar = { stiffness = { EA = 2000, GA2 = 700, GA3 = 700, GJ = 3000, EI2 = 4000, EI3 = 5000 } } }
        members = { a = { nodes = ["A", "B"], section = "bar" },
                    b = { nodes = ["B", "C"], section = "bar", release = { start = ["ry"] } } }
        supports = { A = "clamped", C = ["uz"] }
        probes = { y = { node = "C", displacement = "uy" }, turn = { node = "B", rotation = "rz" },
                   root = { node = "A", reaction = "rz" } }
    "#;
    let ramp = |times: &[f64]| -> String {
        let step =
            |times: &f64| format!("[[steps]]\nforce = {{ B = [0, \"= {times} * F\", 0], C = [0, 0, \"= F\"] }}\n");
        times.iter().map(step).collect()
    };
    let all = ["y", "turn", "root"];
    let network = |steps: &str| format!("format = \"pennate/1\"\n{rods}\n{steps}");
    // Even steps, steps that grow and shrink, one back, and one that holds what the ones before have led to.
    for times in
        [&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0][..], &[1.0, 2.0, 4.0, 7.0, 7.5, 8.5, 10.0], &[2.0, 4.0, 6.0, 5.0, 4.0]]
    {
        assert_eq!(compare(&network(&ramp(times)), &["L", "F"], &all, 0.2), 0);
    }
    let held = "[[steps]]\nhold = { C = [\"ux\"] }\n[[steps]]\nforce = { B = [0, 0, 0], C = [0, 0, 0] }\n";
    let probes = rods.replace("probes = {", "probes = { kept = { node = \"C\", reaction = \"ux\" },");
    let text = format!("format = \"pennate/1\"\n{probes}\n{}{held}", ramp(&[3.0, 5.0, 6.0]));
    assert_eq!(compare(&text, &["L", "F"], &["y", "turn", "root", "kept"], 0.2), 0);
}

/// Ends that nobody reads are passed where the way is straight: not those before a limit point, which some designs meet.
#[test]
fn steps_that_are_passed_end_where_they_end_one_by_one() {
    let mut unanswered = Vec::new();
    for (height, force, spread) in [(10.0, 0.6, 0.6), (14.0, 1.0, 0.3), (25.0, 1.7, 0.5)] {
        let step = |k: usize| format!("[[steps]]\nforce = {{ C = [\"= {k} * H\", \"= -{k} * F\"] }}\n");
        let steps: String = (1..=12).map(step).collect();
        let arch = format!(
            r#"
            dimension = "plane"
            parameters = {{ F = {force}, H = 1e-3, h = {height} }}
            nodes = {{ A = [-100, 0], C = [0, "= h"], B = [100, 0] }}
            members = {{ a = {{ nodes = ["A", "C"], section = "bar" }}, b = {{ nodes = ["C", "B"], section = "bar" }} }}
            supports = {{ A = "pinned", B = "pinned" }}
            probes = {{ drop = {{ node = "C", displacement = "uy" }}, shift = {{ node = "C", displacement = "ux" }} }}
        "#,
            force = force / 12.0,
        );
        unanswered.push(compare(&format!("{HEAD}{arch}\n{steps}"), &["F", "H", "h"], &["drop", "shift"], spread));
    }
    assert!(unanswered.iter().all(|count| (1..30).contains(count)), "{unanswered:?}");
}

/// Two pinned bars that a force presses towards the line of their ends: shallow ones snap through, and move less than tall soft
/// ones that do not.
#[test]
fn a_design_that_snaps_is_noticed_beside_those_that_move_farther() {
    let bars = r#"format = "pennate/1"
        dimension = "plane"
        parameters = { h = 6, F = 8, EA = 2000 }
        nodes = { a = [-100, 0], b = [100, 0], c = [0, "= h"] }
        sections = { bar = { stiffness = { EA = "= EA", EI3 = 2e6 } } }
        members = { left = { nodes = ["a", "c"], section = "bar", release = { end = "pin" } },
                    right = { nodes = ["c", "b"], section = "bar" } }
        supports = { a = "pinned", b = "pinned" }
        steps = [{ force = { c = [0, "= -F"] } }]
        probes = { drop = { node = "c", displacement = "uy" } }
    "#;
    let document = Document::from_text("bars.toml", bars);
    let problem = Problem::new(&document, &[], &["h", "F", "EA"], &["drop"], 1e-4).unwrap();
    let shallow = [6.0, 8.0, 2e3];
    let tall = |k: u8| [150.0, 25.0 + f64::from(k), 1e2];
    assert!(matches!(problem.evaluate(&shallow).reasons[0], Some(Reason::Stopped { .. })));
    let designs = [tall(0), tall(1), shallow, tall(2), tall(3), tall(4)];
    for (k, reason) in problem.evaluate(designs.as_flattened()).reasons.iter().enumerate() {
        assert_eq!(matches!(reason, Some(Reason::Stopped { .. })), k == 2, "{k}: {reason:?}");
        assert_eq!(reason.is_some(), k == 2, "{k}: {reason:?}");
    }
}

/// What is judged out of the plane is not looked at before the first step is gone, where there are few: a network that nothing holds
/// there is not judged all the same, and one that is held and falls over sideways is.
#[test]
fn stability_out_of_the_plane_is_that_of_designs_one_by_one() {
    let hinged = r#"format = "pennate/1"
        parameters = { h = 150, F = 25, EA = 100 }
        nodes = { a = [-100, 0], b = [100, 0], c = [0, "= h"] }
        sections = { bar = { stiffness = { EA = "= EA", EI3 = 2e6 } } }
        members = { left = { nodes = ["a", "c"], section = "bar", release = { end = "pin" } },
                    right = { nodes = ["c", "b"], section = "bar" } }
        supports = { a = "pinned", b = "pinned" }
        steps = [{ force = { c = [0, "= -F"] } }, { force = { c = ["= 0.1 * F", "= -F"] } }]
        probes = { drop = { node = "c", displacement = "uy" } }
    "#;
    assert_eq!(compare(hinged, &["h", "F", "EA"], &["drop"], 0.05), 0);
    let strip = r#"format = "pennate/1"
        parameters = { F = 0.0161 }
        nodes = { a = [0, 0], b = [100, 0] }
        sections = { bar = { stiffness = { EA = 1e4, GA2 = 5e3, GA3 = 5e3, GJ = 40, EI2 = 40, EI3 = 4e3 } } }
        members = { strip = { nodes = ["a", "b"], section = "bar" } }
        supports = { a = "clamped" }
        steps = [{ force = { b = [0, "= F"] } }]
        probes = { rise = { node = "b", displacement = "uy" } }
    "#;
    compare(strip, &["F"], &["rise"], 0.4);
    let document = Document::from_text("strip.toml", strip);
    let problem = Problem::new(&document, &[], &["F"], &["rise"], 1e-6).unwrap();
    // It falls over at 4.01 √(EI₂ GJ) / L².
    let found = problem.evaluate(&[0.012, 0.02, 0.013, 0.021]);
    assert_eq!(found.reasons.iter().map(Option::is_some).collect::<Vec<_>>(), [false, true, false, true]);
}

/// A strip between pins that its load bends about its stiffer axis would turn about itself: side by side, alone and followed.
#[test]
fn strips_that_would_turn_about_themselves_are_not_stable() {
    for coordinates in [["0, 0", "100, 0", "0, -0.01"], ["0, 0, 0", "100, 0, 0", "0, -0.01, 0"]] {
        let [start, end, load] = coordinates;
        let text = format!(
            r#"
            format = "pennate/1"
            parameters = {{ height = 10 }}
            nodes = {{ A = [{start}], B = [{end}] }}
            materials = {{ m = {{ youngs_modulus = 100, poissons_ratio = 0.3 }} }}
            sections = {{ s = {{ rectangle = {{ width = 2, height = "= height" }} }} }}
            supports = {{ A = "clamped", B = "clamped" }}
            members.bar = {{ nodes = ["A", "B"], section = "s", material = "m", release = {{ start = "pin", end = "pin" }} }}
            steps = [{{ distributed = {{ bar = [{load}] }} }}]
            probes = {{ push = {{ member = "bar", moment = "max" }} }}
            "#
        );
        let document = Document::from_text("strip.toml", &text);
        let problem = Problem::new(&document, &[], &["height"], &["push"], 1e-6).unwrap();
        let heights = [10.0, 1.0, 9.0, 1.5, 8.0, 1.2, 10.0, 10.0];
        let right = heights.map(|height| Some(height < 2.0));
        assert_eq!(problem.evaluate(&heights).stable, right, "{start}");
        let alone: Vec<_> = heights.iter().flat_map(|&height| problem.evaluate(&[height]).stable).collect();
        assert_eq!(alone, right, "{start}");
        let mut live = problem.live().unwrap();
        assert_eq!(live.stable(), Some(false), "{start}");
        live.set(0, 9.5);
        live.solve().unwrap();
        assert_eq!(live.stable(), Some(false), "{start}");
    }
}

/// A component of a rotation that is held across a hinge acts about it in part once the node has turned, and nothing takes that: such a
/// state is no equilibrium, side by side, alone, followed and for derivatives.
#[test]
fn a_moment_that_nothing_takes_is_a_reason() {
    for (held, is_balanced) in [("rx", false), ("ry", true)] {
        let text = format!(
            r#"
            format = "pennate/1"
            parameters = {{ push = 30 }}
            nodes = {{ A = [0, 0, 0], J = [50, 0, 0], B = [90, 20, 10] }}
            sections.rod = {{ stiffness = {{ EA = 1e4, EI2 = 9e3, EI3 = 7e3, GJ = 6e3 }} }}
            [members]
            first = {{ nodes = ["A", "J"], section = "rod", release = {{ end = {{ hinge = [0, 1, 0] }} }} }}
            second = {{ nodes = ["J", "B"], section = "rod", release = {{ start = {{ hinge = [0, 1, 0] }} }} }}
            [supports]
            A = "clamped"
            B = "pinned"
            J = ["{held}"]
            [[steps]]
            force = {{ J = [0, -20, "= push"] }}
            [probes]
            drop = {{ node = "J", displacement = "uz" }}
            "#
        );
        let document = Document::from_text("hinge.toml", &text);
        let problem = Problem::new(&document, &[], &["push"], &["drop"], 1e-6).unwrap();
        let pushes = [30.0, 20.0, 25.0, 28.0];
        let stable = is_balanced.then_some(true);
        let is_right = |reason: &Option<Reason>| match reason {
            None => is_balanced,
            Some(reason) => !is_balanced && matches!(reason, Reason::Unbalanced { step: 0 }),
        };
        let together = problem.evaluate(&pushes);
        for (&push, (together, reason)) in pushes.iter().zip(together.values.iter().zip(&together.reasons)) {
            let alone = problem.evaluate_alone(&[push]);
            assert!((alone.0[0] - together).abs() < 1e-9 * together.abs());
            assert!(is_right(reason) && is_right(&alone.1), "{held}: {reason:?}");
        }
        assert_eq!(together.stable, [stable; 4], "{held}");
        let slopes = problem.gradient(&[30.0]);
        assert!(is_right(&slopes.reasons[0]) && slopes.jacobian[0].is_finite() == is_balanced, "{held}");
        assert_eq!(slopes.stable, [stable], "{held}");
        let mut live = problem.live().unwrap();
        assert_eq!(live.stable(), stable, "{held}");
        live.set(0, 29.0);
        live.solve().unwrap();
        assert_eq!(live.stable(), stable, "{held}");
    }
}

/// Stiffnesses are found of all designs at once: also of a node that is held along what is asked for, and of strains that are held.
#[test]
fn stiffnesses_side_by_side_are_those_of_each_design_alone() {
    let stage = STAGE.replace(
        "[probes]",
        "[probes]\nlift = { body = \"stage\", stiffness = \"uz\" }\nlean = { node = \"P1\", compliance = \"ry\" }",
    );
    assert_eq!(compare(&stage, &["L", "beta", "rp"], &["lift", "lean@tilt", "height"], 0.05), 0);
    let dyad = DYAD.replace("[probes]", "[probes]\nk = { node = \"J\", stiffness = \"uy\" }");
    assert_eq!(compare(&dyad, &["L", "beta"], &["k@inflate", "k", "holding"], 0.1), 0);
    let frame = r#"
        format = "pennate/1"
        dimension = "plane"
        parameters = { EI = 3000, h = 40 }
        nodes = { A = [0, 0], B = [0, "= h"], C = [50, "= h"], D = [50, 0] }
        sections = { s = { stiffness = { EA = 1e4, EI3 = "= EI" } } }
        members = { l = { nodes = ["A", "B"], section = "s" }, t = { nodes = ["B", "C"], section = "s" },
                    r = { nodes = ["D", "C"], section = "s" } }
        supports = { A = "clamped", D = "pinned" }
        steps = [{ name = "s", force = { B = [4, -6] } }]
        probes = { k = { node = "C", stiffness = "ux" }, per = "= k / 2" }
    "#;
    assert_eq!(compare(frame, &["EI", "h"], &["k", "per"], 0.2), 0);
}

/// Those side by side go on until the last of them has converged, which leaves each with other rounding in other company, and no more.
#[test]
fn answers_depend_on_company_by_rounding_alone() {
    for (text, parameters, probes) in [
        (DYAD, &["beta", "L"][..], &["stroke@inflate", "holding"][..]),
        (STAGE, &["L", "beta", "rp"], &["height", "tilt@tilt"]),
    ] {
        let document = Document::from_text("network.toml", text);
        let problem = Problem::new(&document, &[], parameters, probes, 1e-6).unwrap();
        let mut random = numbers(11);
        let row = || problem.middle().iter().map(|x| x * (1.0 + 0.1 * random())).collect::<Vec<_>>();
        let rows: Vec<Vec<f64>> = std::iter::repeat_with(row).take(19).collect();
        let values = |rows: &[Vec<f64>]| problem.evaluate(&rows.concat()).values;
        let all = values(&rows);
        let mut turned: Vec<f64> = values(&rows.iter().rev().cloned().collect::<Vec<_>>());
        turned.reverse();
        let alone: Vec<f64> = rows.iter().flat_map(|row| values(std::slice::from_ref(row))).collect();
        let outputs = probes.len();
        for (design, own) in all.chunks(outputs).enumerate() {
            let turned = turned[design * outputs..][..outputs].iter().rev();
            for ((one, other), alone) in own.iter().zip(turned).zip(&alone[design * outputs..]) {
                assert!((one - other).abs().max((one - alone).abs()) <= 1e-11 * one.abs(), "{one} {other} {alone}");
            }
        }
    }
}

/// Groups follow the order of the list alone.
#[test]
fn answers_do_not_depend_on_the_number_of_threads() {
    let document = Document::from_text("dyad.toml", DYAD);
    let problem = Problem::new(&document, &[], &["beta"], &["stroke@inflate", "holding"], 1e-6).unwrap();
    let angles: Vec<f64> = (0..20).map(|k| 15.0 + f64::from(k)).collect();
    let [one, two] = [1, 2].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| problem.evaluate(&angles)).values
    });
    assert!(one.iter().all(|value| value.is_finite()));
    assert_eq!(one, two);
}

#[test]
fn designs_that_nobody_waits_for_are_told() {
    let document = Document::from_text("dyad.toml", DYAD);
    let over = Control { until: Some(Instant::now()), ..Control::default() };
    let compiled = |sample: &[f64], control: &Control| {
        Problem::with_sample(&document, &[], &["beta", "L"], &["stroke"], 1e-6, sample, control)
    };
    let problem = compiled(&[], &Control::default()).unwrap();
    let rows = problem.middle().repeat(20);
    assert!(matches!(compiled(&rows, &over), Err(ProblemError::Interrupted)));
    let (found, slopes) = (problem.evaluate_while(&rows, &over), problem.gradient_while(&rows, &over));
    for (reasons, stable) in [(&found.reasons, &found.stable), (&slopes.reasons, &slopes.stable)] {
        assert_eq!((reasons.len(), stable.len()), (20, 20));
        assert!(reasons.iter().all(|reason| matches!(reason, Some(Reason::Interrupted))));
    }
    assert_eq!([found.values.len(), slopes.values.len(), slopes.jacobian.len()], [20, 20, 40]);
    assert!(found.values.iter().chain(&slopes.values).chain(&slopes.jacobian).all(|value| value.is_nan()));
    let later = Control { until: Some(Instant::now() + Duration::from_secs(1000)), ..Control::default() };
    assert_eq!(problem.evaluate_while(&rows, &later).values, problem.evaluate(&rows).values);
}

#[test]
fn a_sample_serves_where_the_design_of_the_file_has_no_answer() {
    let text = r#"
        dimension = "plane"
        parameters = { k = 0 }
        nodes = { A = [0, 0], B = [100, 0] }
        members = { bar = { nodes = ["A", "B"], section = "bar" } }
        supports = { A = ["ux", "uy"] }
        springs = { foot = { node = "B", stiffness = { ux = 5, uy = "= k" } } }
        steps = [{ force = { B = [0, -1] } }]
        probes = { sinks = { node = "B", displacement = [0, -1] } }
    "#;
    let document = Document::from_text("network.toml", &format!("{HEAD}{text}"));
    let compiled =
        |sample: &[f64]| Problem::with_sample(&document, &[], &["k"], &["sinks"], 1e-6, sample, &Control::default());
    assert!(matches!(compiled(&[]), Err(ProblemError::Unsolvable(_))));
    let found = compiled(&[2.0]).unwrap().evaluate(&[0.0, 4.0]);
    assert!(matches!(found.reasons[0], Some(Reason::Mechanism(_))) && found.reasons[1].is_none());
    assert!((found.values[1] - 0.25).abs() < 1e-4);
}

/// Wires that are pushed back to where they were snap through on the way: an iteration that leaps there comes out on a path that the way
/// crosses. Out of the plane a step may lose its stability, and have it again at its end.
#[test]
fn designs_that_snap_on_the_way_are_not_leapt_over() {
    // Both halves, which may leave their plane.
    let nodes = "[nodes]\nK = [\"= L1 * cos(t1)\", \"= -L1 * sin(t1)\"]\nH = [\"= xG\", \"= -yG\"]";
    let members = r#"[members]
        N = { nodes = ["I", "K"], muscle = "silicone" }
        U = { nodes = ["K", "O"], section = "wire", material = "steel" }
        E = { nodes = ["H", "K"], section = "wire", material = "steel" }"#;
    let whole = INVERTER
        .replace("dimension = \"plane\"", "")
        .replace("[nodes]", nodes)
        .replace("[members]", members)
        .replace("O = [\"uy\", \"rx\", \"rz\"]", "H = \"clamped\"");
    let designs = [
        (
            INVERTER,
            vec![
                [165.77394680098737, 19.529888775711356, 207.30068697919924, 221.1770320315755, 1.5826013424978815],
                [176.57983886463958, 32.526659736039406, 210.5258695792553, 238.18905526231225, 39.66853144173983],
                [164.00134006747592, 19.51823333889286, 209.27364620293667, 223.80068844809216, 2.5245144367544143],
                [133.5151599685742, 26.909743957925095, 192.63418044917418, 169.81171763240795, 4.95629693297991],
            ],
        ),
        (
            &whole,
            vec![
                [97.59379137268019, 52.80945016693005, 63.01591882543781, 95.12351054457542, 72.05615133941338],
                [96.45356687454588, 53.1355363358236, 62.800941489283204, 100.75210541950005, 72.9309524926355],
            ],
        ),
    ];
    for (text, designs) in designs {
        let document = Document::from_text("inverter.toml", text);
        let names = ["L1", "t1", "xO", "xG", "yG"];
        let problem = Problem::new(&document, &[], &names, &["u@free", "f@blocked"], 1e-4).unwrap();
        let found = problem.evaluate(&designs.concat());
        for (index, design) in designs.iter().enumerate() {
            let (alone, reason, _) = problem.evaluate_alone(design);
            assert_eq!(found.reasons[index].is_some(), reason.is_some(), "{design:?}: {reason:?}");
            for (one, other) in alone.iter().zip(&found.values[2 * index..]) {
                let alike = (one - other).abs() <= 1e-9 * one.abs() || one.is_nan() && other.is_nan();
                assert!(alike, "{design:?}: {one} {other}");
            }
        }
    }
}

/// Four bars that pass, by a small turn of their crank, near where all of them lie in one line: from there two ways go on.
#[test]
fn designs_that_pass_a_change_point_go_the_way_that_they_go_alone() {
    let four_bars = r#"
        dimension = "plane"
        parameters = { xB = -0.99, yB = 0.1, xC = 1.01, yC = 0.1, turn = 10, k = 0.1 }
        nodes = { A = [0, 0], B = ["= xB", "= yB"], C = ["= xC", "= yC"], D = [2, 0] }
        sections = { rod = { circle = { radius = 0.02 }, shear = false } }
        materials = { steel = { youngs_modulus = 2e5, poissons_ratio = 0.3 } }
        supports = { A = "clamped", D = "clamped" }
        springs = { S = { node = "C", stiffness = { uy = "= k" } } }
        steps = [{ rotation = { A = [0, 0, "= turn"] } }]
        probes = { x = { node = "C", displacement = "ux" }, y = { node = "C", displacement = "uy" } }
        [members]
        AB = { nodes = ["A", "B"], section = "rod", material = "steel" }
        BC = { nodes = ["B", "C"], section = "rod", material = "steel", release = { start = "pin", end = "pin" } }
        CD = { nodes = ["C", "D"], section = "rod", material = "steel", release = { end = "pin" } }
    "#;
    let text = format!("format = \"pennate/1\"\n{four_bars}");
    let names = ["xB", "yB", "xC", "yC", "turn", "k"];
    let problem = Problem::new(&Document::from_text("four_bars.toml", &text), &[], &names, &["x", "y"], 1e-4).unwrap();
    let designs = [
        [
            -0.9980082055014998,
            0.0630842432916192,
            1.000878967431955,
            -0.04191851953688235,
            11.727189570904095,
            0.021012549893512766,
        ],
        [
            -0.9977219568268576,
            0.06361140043416107,
            1.0021361895737038,
            0.06532852241948295,
            8.082414522595915,
            0.0033160479417905647,
        ],
        [
            -0.9991979757828462,
            0.04930915006006535,
            1.0007992504569674,
            0.052640070811196406,
            5.919798856842843,
            0.002525493569525967,
        ],
        [
            -0.9996272909310634,
            0.027299802670039005,
            1.0006339024886928,
            0.035600605964242485,
            7.685361848602379,
            0.006130751088190339,
        ],
        [
            -0.9942530140233173,
            0.10705579902812001,
            1.000723072924523,
            -0.04069628804753274,
            9.829024246014944,
            0.026076737625135665,
        ],
        [
            -0.9929662466532657,
            0.11072312387975045,
            1.0067848013551857,
            0.11629088176181929,
            13.769457923195564,
            0.012306169136566231,
        ],
        [
            -0.9994222985563808,
            0.03398630824729971,
            1.0005777014436195,
            0.033986308247328026,
            9.358448520628839,
            0.020961092966386527,
        ],
        [
            -0.9929783196222338,
            0.11829647822401475,
            1.0007826290959143,
            -0.03955560242907891,
            13.256006622034697,
            0.005098043681177716,
        ],
        [
            -0.9884253824755133,
            0.07006583206424663,
            1.0093493486093685,
            -0.018933926131863663,
            13.470452716587582,
            0.05883955218073628,
        ],
    ];
    let found = problem.evaluate(&designs.concat());
    for (index, design) in designs.iter().enumerate() {
        let (alone, ..) = problem.evaluate_alone(design);
        for (one, other) in alone.iter().zip(&found.values[2 * index..]) {
            assert!((one - other).abs() <= 1e-9 * one.abs(), "{design:?}: {one} {other}");
        }
    }
}

/// What is kept from one call to the next, for speed, moves no digit: a search that is stopped and gone on with writes the same bytes.
#[test]
fn answers_do_not_depend_on_what_was_solved_before() {
    // Either member may be the stiffer way to the joint between them, which it then carries along.
    let inverter = r#"
        dimension = "plane"
        parameters = { x = 80, y = 60, right = 150, F = 4 }
        nodes = { A = [0, 0], J = ["= x", "= y"], O = ["= right", 0] }
        members = { a = { nodes = ["A", "J"], section = "bar" }, b = { nodes = ["J", "O"], section = "bar" } }
        supports = { A = "clamped", O = ["uy", "rx", "rz"] }
        steps = [{ force = { J = [0, "= F"] } }, { displacement = { O = { ux = 0 } } }]
        probes = { u = { node = "J", displacement = "ux" }, f = { node = "O", reaction = "ux" } }
    "#;
    let document = Document::from_text("network.toml", &format!("{HEAD}{inverter}"));
    let problem = || Problem::new(&document, &[], &["x", "y", "right", "F"], &["u", "f"], 1e-6).unwrap();
    let mut random = numbers(11);
    let rows: Vec<f64> = (0..200)
        .flat_map(|_| [70.0 + 40.0 * random(), 50.0 + 30.0 * random(), 170.0 + 50.0 * random(), 3.0 * random()])
        .collect();
    same_with_nothing_kept(&problem, &rows);
    // Steps that hold something, levers, releases and springs, rotations in space.
    let dyad = DYAD.replace("displacement = { J = { uy = 0.0 } }", "displace_by = { J = { uy = 3 } }");
    let networks = [
        (&*dyad, &["L", "beta"][..], &["stroke@inflate", "holding"][..], 0.1),
        (STAGE, &["L", "beta", "rp"], &["height", "tilt@tilt"], 0.05),
        (ARM, &["Pb", "Pr"], &["x", "y", "z"], 0.1),
    ];
    for (text, parameters, probes, spread) in networks {
        let document = Document::from_text("network.toml", text);
        let problem = || Problem::new(&document, &[], parameters, probes, 1e-6).unwrap();
        let middle = problem().middle();
        let row = |_| middle.iter().map(|x| x * (1.0 + spread * random())).collect::<Vec<_>>();
        let rows: Vec<f64> = (0..24).flat_map(row).collect();
        same_with_nothing_kept(&problem, &rows);
    }
}

/// Whether groups of designs have the same answers one after the other as each by itself, where nothing was solved before.
fn same_with_nothing_kept(problem: &dyn Fn() -> Problem, rows: &[f64]) {
    let bits = |problem: &Problem, rows: &[f64]| -> Vec<u64> {
        problem.evaluate(rows).values.iter().map(|value| value.to_bits()).collect()
    };
    let one = problem();
    let all = bits(&one, rows);
    let widths = [one.parameters().len(), one.outputs().len()].map(|width| 8 * width);
    for (rows, known) in rows.chunks_exact(widths[0]).zip(all.chunks_exact(widths[1])) {
        assert_eq!(bits(&problem(), rows), known);
    }
}
