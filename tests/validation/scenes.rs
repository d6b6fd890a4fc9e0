//! The scenes of the dissertation: values of an independent solver, and the trends that need no tuning.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3};
use pennate_analysis::solution::Solution;

use pennate_testing::scenes::run::{solve, value};
use pennate_testing::scenes::{figures, tables};

fn set(settings: &[(&str, &str)]) -> Vec<(String, String)> {
    settings.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect()
}

/// A probe of a scene after its last step.
#[track_caller]
fn probe(scene: &str, settings: &[(&str, &str)], name: &str) -> f64 {
    let solution = solve(scene, &set(settings), 1e-8).unwrap_or_else(|why| panic!("{scene} {settings:?}: {why}"));
    value(&solution, name, None)
}

#[track_caller]
fn near(value: f64, expected: f64, relative: f64) {
    assert!((value - expected).abs() <= relative * expected.abs(), "{value} is not {expected}");
}

#[test]
fn scenes_agree_with_an_independent_solver() {
    agree("prototype.toml");
}

#[test]
fn scenes_agree_beyond_singular_points() {
    agree("beyond.toml");
}

fn agree(file: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/scenes").join(file);
    let mut wrong = String::new();
    for row in tables::read(&path) {
        let solution = match solve(&row.scene, &row.settings, 1e-8) {
            Ok(solution) => solution,
            Err(why) => {
                writeln!(wrong, "{} {:?}: {why}", row.scene, row.settings).unwrap();
                continue;
            }
        };
        for expected in &row.expected {
            let found = value(&solution, &expected.probe, expected.step.as_deref());
            if !((found - expected.value).abs() <= expected.tolerance) {
                let name = &expected.probe;
                let settings = &row.settings;
                writeln!(wrong, "{} {settings:?}: {name} is {found}, not {}", row.scene, expected.value).unwrap();
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// A shear-rigid, inextensible rod in the same state, integrated backwards from its tip; both signs, and the base turned.
#[test]
fn the_soft_arm_is_where_an_integration_of_the_rod_puts_it() {
    for (settings, expected) in [
        (&[][..], [184.0473, -95.4755, -164.2103]),
        (&[("Pr", "-124.1")][..], [184.0473, 95.4755, -164.2103]),
        (&[("swivel", "90")][..], [95.4755, 184.0473, -164.2103]),
    ] {
        for (axis, expected) in ["x", "y", "z"].into_iter().zip(expected) {
            let found = probe("br2", settings, axis);
            assert!((found - expected).abs() < 1e-4, "{settings:?}: {axis} is {found}, not {expected}");
        }
    }
}

/// Table 5: strokes of stages add, forces of columns add.
#[test]
fn networks_multiply_the_stroke_and_the_force_of_one_dyad() {
    let measure = |scene: &str, n: &str, m: &str| {
        let stroke = probe(scene, &[("n", n), ("m", m)], "stroke");
        let force = probe(scene, &[("n", n), ("m", m), ("test", "blocked")], "force");
        (stroke, force)
    };
    let (stroke, force) = measure("conventional", "1", "1");
    for (scene, n, m, strokes, forces) in [
        ("conventional", "2", "1", 1.0, 2.0),
        ("conventional", "3", "2", 1.0, 6.0),
        ("inverted", "2", "1", 2.0, 1.0),
        ("inverted", "3", "2", 3.0, 2.0),
        ("hybrid", "2", "1", 2.0, 2.0),
        ("hybrid", "3", "2", 3.0, 4.0),
    ] {
        let found = measure(scene, n, m);
        near(found.0, strokes * stroke, 1e-9);
        near(found.1, forces * force, 1e-9);
    }
}

/// A blocked muscle pulls with f; two of them with 2 f sin χ, whatever their joints.
#[test]
fn a_blocked_dyad_pulls_with_twice_the_sine() {
    let force = |chi: f64, joints: &str| {
        probe(
            "dyad",
            &[("chi", &chi.to_string()), ("joints", joints), ("pressure", "20"), ("test", "blocked")],
            "force",
        )
    };
    let single = force(30.0, "fixed");
    near(single, 44.02, 1e-4);
    for chi in [5.0_f64, 22.0, 45.0, 60.0, 85.0] {
        for joints in ["fixed", "pinned"] {
            near(force(chi, joints), 2.0 * single * chi.to_radians().sin(), 1e-8);
        }
    }
}

#[test]
fn a_pinned_dyad_moves_farther_than_a_fixed_one() {
    for chi in ["29", "35", "45", "60", "80"] {
        let stroke = |joints: &str| probe("dyad", &[("chi", chi), ("joints", joints), ("pressure", "20")], "stroke");
        assert!(stroke("pinned") > stroke("fixed"), "at {chi} degrees");
    }
}

/// Forces of strains that only the extrapolation left do not turn with the rings: a stack is as soft against them as it is long.
#[test]
fn a_long_spiral_takes_few_increments() {
    let solution = solve("spiral", &set(&[("cells", "24")]), 1e-6).unwrap_or_else(|why| panic!("{why}"));
    let step = &solution.history.steps[0];
    // 77 in 11 increments where they do.
    let (increments, factorizations) = (step.increments.len(), step.factorizations);
    assert!(factorizations <= 50 && increments <= 7, "{factorizations} in {increments}");
}

/// Elements half as long where they lack most took twice the time, for an error four times as large.
#[test]
fn a_stack_that_misses_an_accuracy_takes_a_higher_order() {
    let solution = solve("spiral", &set(&[("cells", "36")]), 1e-4).unwrap_or_else(|why| panic!("{why}"));
    assert_eq!((solution.mesh.order, solution.accuracy.rounds), (3, 2));
    assert!(solution.accuracy.estimated.is_some_and(|error| error < 1e-5), "{:?}", solution.accuracy);
}

/// Nothing loads the stack, so its reactions are what the residuals leave: what two meshes differ by there is no error of its motions.
#[test]
fn a_free_stack_has_the_errors_of_its_motions() {
    for cells in ["8", "12"] {
        let solution = solve("spiral", &set(&[("cells", cells)]), 1e-6).unwrap_or_else(|why| panic!("{why}"));
        let errors = solution.probes.steps[0].errors().unwrap();
        // 170 mm were stated of 8 cells, 2.3 mm of 12.
        assert!(errors.iter().all(|&error| error < 1e-3), "{cells} cells: {errors:?}");
        assert!(solution.history.steps[0].increments.iter().all(|increment| increment.state.balance < 1e-6));
    }
}

/// Nothing loads the stack, so each cell moves as one alone does: the last ring is moved by the product of the cells.
#[test]
fn a_spiral_is_the_product_of_its_cells() {
    let state = |cells: &str| solve("spiral", &set(&[("cells", cells)]), 1e-8).unwrap();
    let motion = |solution: &Solution, node: &str| {
        let at = solution.model.nodes.iter().position(|each| each.name == node).unwrap();
        let last = solution.history.steps[0].increments.last().unwrap();
        let node = &last.state.nodes[at];
        let turn = Rotation3::new(Vector3::from(node.rotation));
        Isometry3::from_parts(Vector3::from(node.displacement).into(), turn.into())
    };
    let height = Translation3::new(0.0, 0.0, 100.0);
    // From the lower ring to the upper one, then turned for the next cell.
    let alone = motion(&state("1"), "R1");
    let cell = Isometry3::from_parts((alone.translation.vector + height.vector).into(), alone.rotation);
    let offset = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 10_f64.to_radians());
    let mut product = Isometry3::identity();
    for _ in 0..6 {
        product = product * cell * offset;
    }
    let stack = motion(&state("6"), "R1-6");
    let place = stack.translation.vector + 6.0 * height.vector;
    let error = (place - product.translation.vector).norm();
    assert!(error < 1e-6 * place.norm(), "{error}: {place:?} is not {:?}", product.translation.vector);
    // The product ends with the offset of a seventh cell; the ring knows of no offset but as it was built.
    let built = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 60_f64.to_radians());
    assert!((stack.rotation * built).angle_to(&product.rotation) < 1e-6);
}

/// The stage is softest near the angle at which it moves farthest.
#[test]
fn the_stage_is_softest_beside_its_greatest_stroke() {
    let angles: Vec<f64> = (20..=40).map(f64::from).collect();
    let states = angles.iter().map(|beta| solve("stage", &set(&[("beta", &beta.to_string())]), 1e-6).unwrap());
    let states: Vec<_> = states.collect();
    let at = |worst: fn(f64, f64) -> bool, probe: &str, step: &str| {
        let values = states.iter().map(|state| value(state, probe, Some(step)));
        let best = values.enumerate().reduce(|a, b| if worst(b.1, a.1) { b } else { a }).unwrap();
        angles[best.0]
    };
    let (softest, farthest) = (at(|a, b| a < b, "stiffness", "push"), at(|a, b| a > b, "stroke", "high"));
    assert!((farthest - softest).abs() <= 3.0 && softest > 20.0 && softest < 40.0, "{softest}, {farthest}");
}

/// `pennate scene NAME | pennate solve -`, and what is refused.
#[test]
fn the_command_writes_what_solve_reads() {
    let pennate = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pennate"));
        command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().unwrap()
    };
    let written = pennate(&["scene", "motor", "--set", "zeta=30"]).wait_with_output().unwrap();
    assert_eq!(written.status.code(), Some(0));
    let mut solve = pennate(&["solve", "-", "--json"]);
    solve.stdin.take().unwrap().write_all(&written.stdout).unwrap();
    let solved = solve.wait_with_output().unwrap();
    let results: serde_json::Value = serde_json::from_slice(&solved.stdout).unwrap();
    near(results["steps"][0]["probes"]["turn"].as_f64().unwrap(), 46.67, 0.02);
    let list = String::from_utf8(pennate(&["scene"]).wait_with_output().unwrap().stdout).unwrap();
    for scene in pennate_models::scenes::SCENES {
        assert!(list.contains(scene.name), "{list}");
    }
    let refused = pennate(&["scene", "motor", "--set", "zeta=90"]).wait_with_output().unwrap();
    assert_eq!((refused.status.code(), refused.stdout.as_slice()), (Some(2), [].as_slice()));
    let shown = String::from_utf8(refused.stderr).unwrap();
    assert!(shown.contains("zeta must be at least 0 and less than 90 deg"), "{shown}");
}

/// Every figure of the table for people names a scene, a parameter and a probe that there are.
#[test]
fn reported_figures_are_found() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/scenes/reported.toml");
    for figure in figures::read(&path) {
        match figure.found() {
            Ok(found) => assert!(found.is_finite(), "{}: {found}", figure.what),
            Err(why) => assert_eq!((figure.what.as_str(), why.as_str()), ("dyad, pinned: the same", "limit_point")),
        }
        assert!(!figure.reported.is_empty() && !figure.certainty.is_empty());
    }
}
