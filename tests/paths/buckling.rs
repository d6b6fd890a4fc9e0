//! Critical factors from network files against closed forms and exact solutions.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use pennate_testing::frames::Frame;
use pennate_testing::repository;
use serde_json::Value;

fn pennate(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pennate")).args(arguments).output().expect("pennate can be started")
}

/// `buckling.json` of a file.
fn buckling(file: &Path, more: &[&str]) -> Value {
    let mut arguments = vec!["buckle", file.to_str().expect("a path in letters"), "--json"];
    arguments.extend(more);
    let output = pennate(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// Factors in order.
fn factors(buckling: &Value) -> Vec<f64> {
    let modes = buckling["modes"].as_array().expect("a list of modes");
    modes.iter().map(|mode| mode["factor"].as_f64().expect("a factor")).collect()
}

/// Errors stated of factors, in order.
fn errors(buckling: &Value) -> Vec<f64> {
    let modes = buckling["modes"].as_array().expect("a list of modes");
    modes.iter().map(|mode| mode["error"].as_f64().expect("an error")).collect()
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("validation").join(name)
}

#[track_caller]
fn assert_near(found: f64, expected: f64, tolerance: f64) {
    let error = (found / expected - 1.0).abs();
    assert!(error <= tolerance, "{found} instead of {expected}, error {error:.1e}");
}

fn column(directory: &tempfile::TempDir, section: &str, supports: &str) -> PathBuf {
    let path = directory.path().join("column.toml");
    let text = format!(
        "format = \"pennate/1\"\n[parameters]\nP = 1\n[nodes]\nA = [0, 0]\nB = [1, 0]\n[sections]\nrod = {{ {section} }}\n\
         [members]\nrod = {{ nodes = [\"A\", \"B\"], section = \"rod\" }}\n[supports]\n{supports}\n\
         [[steps]]\nname = \"push\"\nforce = {{ B = [\"= -P\", 0, 0] }}\n"
    );
    std::fs::write(&path, text).expect("a file");
    path
}

const ELASTICA: &str = "stiffness = { EA = 1, EI3 = 1 }, shear = false, stretch = false";

/// The elastica: between clamps 4π², 8.183π², 16π², between pins n²π², clamped at one end π²/4, times EI/L².
#[test]
fn a_column_has_eulers_critical_loads() {
    let directory = tempfile::tempdir().expect("a directory");
    // The second load of the clamped column: tan x = x with x = L/2 √(P/EI).
    let second = 2.0 * 4.493_409_457_909_064_f64;
    let cases = [
        ("A = \"clamped\"\nB = [\"uy\", \"rz\"]", vec![4.0 * PI * PI, second * second, 16.0 * PI * PI]),
        ("A = \"pinned\"\nB = [\"uy\"]", vec![PI * PI, 4.0 * PI * PI, 9.0 * PI * PI]),
        ("A = \"clamped\"", vec![PI * PI / 4.0, 9.0 * PI * PI / 4.0]),
    ];
    for (supports, expected) in cases {
        let found = factors(&buckling(&column(&directory, ELASTICA, supports), &["--count", "3"]));
        for (found, expected) in found.iter().zip(expected) {
            assert_near(*found, expected, 1e-6);
        }
    }
}

/// About a compressed state the factor multiplies the load that is there.
#[test]
fn present_loads_are_multiplied() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = column(&directory, ELASTICA, "A = \"clamped\"\nB = [\"uy\", \"rz\"]");
    let found = factors(&buckling(&file, &["--step", "push", "--set", "P=30", "--count", "1"]));
    assert_near(found[0], 4.0 * PI * PI / 30.0, 1e-6);
}

/// The column of the post-buckling reference: P (1 + P/GA − P/EA) = 4π² EI/L², from a state near the critical one to 1e-6.
///
/// From the unloaded state its shape is that of the longer column: the error is of the order P/GA.
#[test]
fn a_shear_flexible_column_is_softer() {
    let directory = tempfile::tempdir().expect("a directory");
    let section = "stiffness = { EA = 1e4, GA2 = 3e3, GA3 = 3e3, GJ = 1, EI2 = 1, EI3 = 1 }";
    let file = column(&directory, section, "A = \"clamped\"\nB = [\"uy\", \"rz\"]");
    let softening: f64 = 1.0 / 3e3 - 1.0 / 1e4;
    let critical = ((1.0 + 16.0 * PI * PI * softening).sqrt() - 1.0) / (2.0 * softening);
    let first = factors(&buckling(&file, &["--count", "1"]))[0];
    assert_near(first, critical, critical / 3e3);
    let near = 0.9999 * critical;
    let found = factors(&buckling(&file, &["--step", "push", "--set", &format!("P={near:?}"), "--count", "1"]));
    assert_near(near * found[0], critical, 1e-6);
}

/// The right-angle frame, plane in shape and load, buckles sideways at 1.0875178408 and at −0.68042736226.
#[test]
fn a_plane_frame_buckles_sideways() {
    for (critical, near) in [(1.087_517_840_8, "P=1.0875"), (-0.680_427_362_26, "P=-0.6804")] {
        let load: f64 = near[2..].parse().expect("a number");
        let found =
            buckling(&file("08_right_angle_frame/cantilever.toml"), &["--step", "load", "--set", near, "--count", "1"]);
        assert_eq!(found["modes"][0]["family"], "out_of_plane");
        assert_near(load * factors(&found)[0], critical, 1e-6);
        // From the unloaded state, by the deformation in its plane off.
        let linear = buckling(&file("08_right_angle_frame/cantilever.toml"), &["--set", near, "--count", "1"]);
        assert_near(load * factors(&linear)[0], critical, 1e-3);
    }
    let unloaded = buckling(&file("08_right_angle_frame/cantilever.toml"), &["--set", "P=1", "--count", "1"]);
    assert_near(unloaded["reversed"].as_f64().expect("a factor"), -0.680_427_362_26, 1e-3);
}

/// A cantilever under a force across its tip tilts sideways at 4.0126 √(EI GJ)/L², and at 12.85 √(EI GJ)/L³ of a load along it,
/// S. P. Timoshenko and J. M. Gere, Theory of Elastic Stability (1961), art. 6.3: twice the first zero of the Bessel function of order
/// −1/4, and six times that of the one of order −1/6; upwards as downwards.
///
/// Held strains answer a ramp by multipliers, and loads along a member are part of the tangent that they are answered with: the
/// rates of both are those of the beginning of the ramp however far it leads.
#[test]
fn a_cantilever_tilts_at_the_same_load_whatever_the_ramp() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("cantilever.toml");
    let root = (2e3f64 * 3e3).sqrt();
    for shear in ["GA2 = 1e7, GA3 = 1e7, EA = 1e7", "EA = 300", "stretch = false"] {
        for (kind, critical) in
            [("force.T", 4.012_599_343_578_9 * root / 1e4), ("distributed.m", 12.853_763_321_383 * root / 1e6)]
        {
            for load in [1e-3, 1.0, 1e3] {
                let text = format!(
                    "format = \"pennate/1\"\nnodes = {{ A = [0, 0], T = [100, 0] }}\n\
                     sections.r = {{ stiffness = {{ GJ = 2e3, EI2 = 3e3, EI3 = 4e3, {shear} }} }}\n\
                     members.m = {{ nodes = [\"A\", \"T\"], section = \"r\" }}\nsupports.A = \"clamped\"\n\
                     [[steps]]\n{kind} = [0, {load:?}, 0]\n"
                )
                .replace(", stretch = false }", ", EA = 1 }, shear = false, stretch = false");
                std::fs::write(&file, text).expect("a file");
                let found = buckling(&file, &["--count", "1"]);
                assert_eq!(found["modes"][0]["family"], "out_of_plane");
                assert_near(load * factors(&found)[0], critical, 1e-6);
                assert_near(load * found["reversed"].as_f64().expect("a factor"), -critical, 1e-6);
                let error = found["reversed_error"].as_f64().expect("an error");
                assert!(error > 0.0 && error < 1e-6, "{error:.1e}");
            }
        }
    }
}

/// A bar that cannot be stretched in a row with a wire, pushed together by a support: Euler's load between clamps, 4π² EI/L², however
/// much stiffer than its bending the wire is, which alone says what force a push is.
#[test]
fn a_bar_that_cannot_be_stretched_has_the_force_of_its_neighbour() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("row.toml");
    for (stiffness, push) in [(1e2, 1e-3), (1e4, 1e-3), (1e7, 1e-3), (1e4, 10.0)] {
        let section = format!("stiffness = {{ EA = {stiffness:?}, GJ = 1, EI2 = 1, EI3 = 1 }}, shear = false");
        let text = format!(
            "format = \"pennate/1\"\nnodes = {{ A = [0, 0], B = [100, 0], C = [200, 0] }}\n\
             sections.bar = {{ {section}, stretch = false }}\nsections.wire = {{ {section} }}\n\
             [members]\nbar = {{ nodes = [\"A\", \"B\"], section = \"bar\" }}\n\
             wire = {{ nodes = [\"B\", \"C\"], section = \"wire\" }}\n\
             [supports]\nA = \"clamped\"\nC = \"clamped\"\n[[steps]]\ndisplacement.C.ux = -{push:?}\n"
        );
        std::fs::write(&file, text).expect("a file");
        let force = stiffness / 100.0 * push;
        assert_near(factors(&buckling(&file, &["--count", "1"]))[0], 4.0 * PI * PI / 4e4 / force, 1e-6);
    }
}

/// A force on a lever is part of the tangent that it is answered with; its critical value is the same however far a ramp leads.
#[test]
fn a_force_on_a_lever_is_critical_at_the_same_value_whatever_the_ramp() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("lever.toml");
    let mut first = None;
    for load in [1e-3, 1.0, 1e3] {
        let text = format!(
            "format = \"pennate/1\"\nnodes = {{ A = [0, 0, 0], T = [100, 0, 0], H = [110, 4, 7] }}\n\
             sections.r = {{ stiffness = {{ GJ = 2e3, EI2 = 3e3, EI3 = 4e3, EA = 300 }} }}\n\
             members.m = {{ nodes = [\"A\", \"T\"], section = \"r\" }}\n\
             rigid_bodies.head = {{ nodes = [\"T\", \"H\"], reference = \"T\" }}\nsupports.A = \"clamped\"\n\
             [[steps]]\nforce.H = [{load:?}, {load:?}, 0]\n"
        );
        std::fs::write(&file, text).expect("a file");
        let found = buckling(&file, &["--count", "1"]);
        let critical = load * factors(&found)[0];
        assert_near(critical, *first.get_or_insert(critical), 1e-6);
    }
}

/// Rigid pendulums that stand on their springs, askew in space, fall at their stiffness against turning over their height.
#[test]
fn pendulums_fall_at_what_the_springs_at_their_feet_bear() {
    let directory = tempfile::tempdir().expect("a directory");
    let foot = "stiffness = { ux = 1e6, uy = 1e6, uz = 1e6, rx = 100, ry = 100, rz = 100 }";
    let body = |reference: &str| {
        format!(
            "rigid_bodies.R = {{ nodes = [\"T\", \"F\"], reference = \"{reference}\" }}\n\
             springs.foot = {{ node = \"F\", {foot} }}\n"
        )
    };
    let joint = format!("supports.F = \"clamped\"\nsprings.foot = {{ nodes = [\"T\", \"F\"], {foot} }}\n");
    let top = [20.0, -10.0, 20.0].map(|x| x / 3.0);
    let push = top.map(|x| -0.1 * x);
    for text in [body("T"), body("F"), joint] {
        let path = directory.path().join("pendulum.toml");
        let text = format!(
            "format = \"pennate/1\"\ndimension = \"space\"\nnodes = {{ T = {top:?}, F = [0, 0, 0] }}\n\
             {text}[[steps]]\nforce = {{ T = {push:?} }}\n"
        );
        std::fs::write(&path, text).expect("a file");
        // The shape is frozen: up to there the foot gives by a millionth of the height.
        assert_near(factors(&buckling(&path, &[]))[0], 10.0, 1.1e-6);
    }
}

/// A column with a joint of springs in its middle: what does not give before it buckles buckles where its path forks.
#[test]
fn a_column_with_a_joint_of_springs_buckles_where_its_path_forks() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path().join("column.toml");
    let text = "format = \"pennate/1\"\ndimension = \"space\"\n\
        nodes = { A = [0, 0, 0], B = [60, 80, 0], C = [66, 88, 0], D = [126, 168, 0] }\n\
        [sections]\nx = { stiffness = { EI2 = 1e4, EI3 = 2e4, GJ = 1e4 }, shear = false, stretch = false }\n\
        [members]\nm = { nodes = [\"A\", \"B\"], section = \"x\" }\nn = { nodes = [\"C\", \"D\"], section = \"x\" }\n\
        [supports]\nA = \"clamped\"\n\
        [springs]\ng = { nodes = [\"B\", \"C\"], stiffness = { ux = 1e6, uy = 1e6, uz = 50, rx = 1e3, ry = 1e3, rz = 1e3 } }\n\
        [[steps]]\nforce = { D = [-0.6, -0.8, 0] }\n";
    std::fs::write(&path, text).expect("a file");
    let output = pennate(&["solve", path.to_str().expect("a path in letters"), "--json"]);
    let results: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let fork = results["steps"][0]["critical_points"][0]["fraction"].as_f64().expect("a bifurcation");
    assert_near(factors(&buckling(&path, &[]))[0], fork, 1e-5);
}

/// A round column that has buckled may turn about its ends: whatever rounding makes of that is no loss of stability.
#[test]
fn a_buckled_round_column_is_neutral_out_of_its_plane() {
    let found: Vec<Value> = ["1e-4", "1e-6", "1e-8"]
        .map(|accuracy| buckling(&file("10_euler_post_buckling/column.toml"), &["--accuracy", accuracy]))
        .into();
    for buckling in &found {
        let notes = buckling["notes"].as_array().expect("a list of notes");
        assert!(notes.iter().any(|note| note.as_str().is_some_and(|note| note.contains("neutral out of the plane"))));
        for (factor, best) in factors(buckling).iter().zip(factors(&found[2])) {
            assert_near(*factor, best, 1e-4);
        }
        assert_near(factors(buckling)[0], factors(&found[2])[0], 1e-5);
    }
}

/// A muscle between clamps: it pulls as it contracts, and no pressure buckles it.
///
/// Without shear, that is: the shear-flexible rod of the reference buckles in tension, at forces of the order of GA.
#[test]
fn contraction_between_clamps_stabilizes() {
    let text = std::fs::read_to_string(file("12_hsim_member/blocked.toml")).expect("a network");
    assert!(text.contains("shear = true"));
    let directory = tempfile::tempdir().expect("a directory");
    let rigid = directory.path().join("rigid.toml");
    std::fs::write(&rigid, text.replace("shear = true", "shear = false")).expect("a file");
    let found = buckling(&rigid, &["--count", "2"]);
    assert_eq!(factors(&found), Vec::<f64>::new());
    assert!(found["reversed"].as_f64().expect("an expansion buckles it") < 0.0);
    let sheared = factors(&buckling(&file("12_hsim_member/blocked.toml"), &["--count", "2"]));
    assert!(sheared.iter().all(|factor| *factor > 1.0), "{sheared:?}");
}

/// A ramp that moves nothing has no factor: said, not computed.
#[test]
fn a_ramp_that_moves_nothing_is_refused() {
    let directory = tempfile::tempdir().expect("a directory");
    let file = column(&directory, ELASTICA, "A = \"clamped\"");
    let output = pennate(&["buckle", file.to_str().expect("a path in letters"), "--set", "P=0"]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("nothing to multiply") && message.contains("help:"), "{message}");
}

/// Muscles that contract freely get no stresses, and no pressure buckles them: rounding is no factor.
#[test]
fn free_contraction_has_no_factor() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path().join("tower.toml");
    let scene = pennate(&["scene", "conventional", "--set", "n=3", "--set", "m=3"]);
    assert_eq!(scene.status.code(), Some(0));
    std::fs::write(&path, scene.stdout).expect("a file");
    let found = buckling(&path, &["--accuracy", "1e-6"]);
    assert_eq!(factors(&found), Vec::<f64>::new());
}

/// A rigid body turns the forces of its members with it: their rates are those at the ends, not at the nearest nodes, so that the
/// factors of a coarse mesh are as near as its elements are good. What is stated covers how near, and is not far from it.
#[test]
fn errors_of_a_coarse_mesh_are_those_that_it_states() {
    for network in ["tripod", "muscle_cantilever", "dyad"] {
        let path = repository(&format!("models/networks/{network}.toml"));
        let [coarse, fine] = ["1e-4", "1e-9"].map(|accuracy| buckling(&path, &["--accuracy", accuracy]));
        let apart: Vec<f64> =
            factors(&coarse).iter().zip(factors(&fine)).map(|(coarse, fine)| (coarse / fine - 1.0).abs()).collect();
        for ((apart, stated), exact) in apart.iter().zip(errors(&coarse)).zip(errors(&fine)) {
            assert!(*apart <= 10.0 * stated + exact, "{network}: {apart:.1e} off, {stated:.1e} stated");
        }
        let [apart, stated] = [apart, errors(&coarse)].map(|all| all.into_iter().fold(0.0, f64::max));
        println!("{network}: {apart:.1e} off, {stated:.1e} stated");
        assert!(stated <= 10.0 * apart.max(1e-12), "{network}: {apart:.1e} off, {stated:.1e} stated");
    }
}

/// A motion that a step begins where the one before has led to begins elsewhere on every mesh and order, and a single factor may
/// agree on two orders by chance: neither is left out of what is stated.
#[test]
fn motions_that_begin_at_a_state_and_single_factors_have_the_errors_that_are_stated() {
    for network in ["models/networks/dyad.toml", "models/networks/muscle_cantilever.toml"] {
        let path = repository(network);
        for count in ["1", "2", "6"] {
            let at = |accuracy: &str| buckling(&path, &["--count", count, "--accuracy", accuracy]);
            let fine = at("1e-9");
            for accuracy in ["1e-3", "1e-4", "1e-5", "1e-6"] {
                let found = at(accuracy);
                let apart = (factors(&found)[0] / factors(&fine)[0] - 1.0).abs();
                let most = 3.0 * (errors(&found)[0] + errors(&fine)[0]);
                assert!(apart <= most, "{network}, {count} at {accuracy}: {apart:.1e} off, {most:.1e} allowed");
            }
        }
    }
}

/// Errors by two orders, by three, and by two meshes: whichever ends the search, every factor is as near as it says.
#[test]
fn errors_of_scenes_are_those_that_are_stated() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path().join("scene.toml");
    for scene in ["dyad", "motor", "br2", "stage", "compliant_gripper", "wire_gripper", "ring_gripper"] {
        std::fs::write(&path, pennate(&["scene", scene]).stdout).expect("a file");
        let fine = buckling(&path, &["--accuracy", "1e-9"]);
        for accuracy in ["1e-3", "1e-4", "1e-5", "1e-6"] {
            let found = buckling(&path, &["--accuracy", accuracy]);
            let values = factors(&found).into_iter().zip(errors(&found));
            let exact = factors(&fine).into_iter().zip(errors(&fine));
            for (mode, ((found, stated), (exact, left))) in values.zip(exact).enumerate() {
                let (apart, most) = ((found / exact - 1.0).abs(), 3.0 * (stated + left));
                assert!(apart <= most, "{scene}, mode {mode} at {accuracy}: {apart:.1e} off, {most:.1e} allowed");
            }
        }
    }
}

/// The first factor of a frame times its loads, and the estimated part that it is off.
fn first_factor(directory: &tempfile::TempDir, frame: &Frame, times: f64, more: &[&str]) -> (f64, f64) {
    let path = directory.path().join("frame.toml");
    std::fs::write(&path, frame.network(times, 0.0, "")).expect("a file");
    let found = buckling(&path, &[&["--count", "1"], more].concat());
    (times * factors(&found)[0], found["modes"][0]["error"].as_f64().expect("an error"))
}

/// A frame whose members cannot be stretched, or next to nothing: its sway is ten orders softer than they are.
#[test]
fn slender_frames_have_the_critical_loads_of_stability_functions() {
    let directory = tempfile::tempdir().expect("a directory");
    let mut rng = fastrand::Rng::with_seed(23);
    for case in 0..18 {
        let slenderness = [f64::INFINITY, 1e4, 1e5][case % 3];
        let frame = Frame::random(&mut rng, slenderness);
        let exact = Frame { slenderness: f64::INFINITY, ..frame.clone() }.critical_factor();
        let (found, stated) = first_factor(&directory, &frame, 0.6 * exact, &[]);
        let error = (found / exact - 1.0).abs();
        // What members of finite slenderness are stretched by is left out of the exact load.
        let stretch = if slenderness.is_finite() { 100.0 / slenderness.powi(2) } else { 0.0 };
        assert!(error <= 1e-6 + stretch, "case {case}: {found} instead of {exact}, {error:.1e} off; {frame:?}");
        assert!(error <= 10.0 * stated + stretch, "case {case}: {error:.1e} off, {stated:.1e} stated; {frame:?}");
    }
}

/// Columns that cannot be stretched under beams that are thousands of times as stiff: what holds a column at its length has to be stiff
/// beside these beams, not beside the column alone.
#[test]
fn stiff_beams_on_columns_that_cannot_be_stretched_do_not_hide_the_factor() {
    let directory = tempfile::tempdir().expect("a directory");
    let mut rng = fastrand::Rng::with_seed(5);
    for case in 0..12 {
        let (storeys, bays) = (3 + case % 2, 3);
        let mut around = |middle: f64, spread: f64| middle * spread.powf(2.0 * rng.f64() - 1.0);
        let (height, width) = (around(95.0, 1.5), around(110.0, 1.8));
        let frame = Frame {
            heights: vec![height; storeys],
            widths: vec![width; bays],
            columns: vec![1e3; storeys],
            beams: vec![around(5e6, 6.0); storeys],
            loads: (0..storeys).map(|storey| if storey + 1 == storeys { 1.0 } else { 0.0 }).collect(),
            slenderness: f64::INFINITY,
            clamped: rng.bool(),
            braced: false,
        };
        let exact = frame.critical_factor();
        let (found, stated) = first_factor(&directory, &frame, 0.3 * exact, &[]);
        let error = (found / exact - 1.0).abs();
        assert!(
            error <= 1e-6 && error <= 10.0 * stated,
            "case {case}: {error:.1e} off, {stated:.1e} stated; {frame:?}"
        );
    }
}

/// The frame sways under a beam that is stiffer than its columns by more digits than a number has.
#[test]
fn a_beam_of_any_stiffness_leaves_the_factor_of_its_columns() {
    let directory = tempfile::tempdir().expect("a directory");
    for stiffer in [1e3, 1e5, 1e7] {
        let frame = Frame { beams: vec![1e4 * stiffer], clamped: true, ..Frame::portal(f64::INFINITY) };
        let exact = frame.critical_factor();
        let (found, stated) = first_factor(&directory, &frame, 0.5 * exact, &[]);
        let error = (found / exact - 1.0).abs();
        assert!(error <= 1e-7 && error <= 10.0 * stated, "{stiffer}: {error:.1e} off, {stated:.1e} stated");
    }
}

/// Who asks for more does not get less.
#[test]
fn a_higher_accuracy_is_no_larger_error() {
    let directory = tempfile::tempdir().expect("a directory");
    for slenderness in [1e4, 1e5, f64::INFINITY] {
        let frame = Frame::portal(slenderness);
        let exact = Frame::portal(f64::INFINITY).critical_factor();
        let stretch = if slenderness.is_finite() { 10.0 / slenderness.powi(2) } else { 1e-12 };
        let mut before = f64::INFINITY;
        for accuracy in ["1e-4", "1e-6", "1e-8", "1e-10"] {
            let (found, _) = first_factor(&directory, &frame, 12.0, &["--accuracy", accuracy]);
            let error = (found / exact - 1.0).abs();
            assert!(
                error <= before.max(stretch),
                "L/r {slenderness}, {accuracy} asked: {error:.1e} off, {before:.1e} before"
            );
            before = error;
        }
    }
}

/// The first of two bars can hardly be stretched and sheared, or not at all; the stress of stiff strains was rounding once.
#[test]
fn strains_that_are_stiff_or_held_leave_the_digits_that_are_stated() {
    let directory = tempfile::tempdir().unwrap();
    let bending = "GJ = 2000, EI2 = 3000, EI3 = 5000";
    let stiff = |ea: &str| format!("stiffness = {{ EA = {ea}, GA2 = {ea}, GA3 = {ea}, {bending} }}");
    let soft = format!("stiffness = {{ EA = 2e4, GA2 = 1e4, GA3 = 1e4, {bending} }}");
    let held = format!("{soft}, shear = false, stretch = false");
    let [long, short] = ["", ", elements = 60"];
    for (section, elements, expected) in [
        (stiff("1e8"), long, 0.206_176_589_48),
        (stiff("1e12"), long, 0.206_176_581_31),
        (held.clone(), long, 0.206_176_581_31),
        (held, short, 0.206_176_581_31),
    ] {
        let network = directory.path().join("bars.toml");
        let text = format!(
            "format = \"pennate/1\"\ndimension = \"space\"\n\
             [nodes]\na = [0, 0, 0]\nb = [30, 40, 20]\nc = [90, 20, 50]\n\
             [sections]\ns = {{ {section} }}\nt = {{ {soft} }}\n\
             [members]\nm0 = {{ nodes = [\"a\", \"b\"], section = \"s\", orientation = [0.1, 0.2, 1]{elements} }}\n\
             m1 = {{ nodes = [\"b\", \"c\"], section = \"t\", orientation = [0.1, 0.2, 1] }}\n\
             [supports]\na = \"clamped\"\nc = [\"ux\", \"uz\", \"ry\"]\n\
             [[steps]]\nforce = {{ b = [1, -2, 0.5], c = [0, 1, 0] }}\n"
        );
        std::fs::write(&network, text).unwrap();
        for accuracy in ["1e-4", "1e-6", "1e-8"] {
            let found = buckling(&network, &["--accuracy", accuracy, "--count", "3"]);
            let (factor, error) = (factors(&found)[0], errors(&found)[0]);
            assert!(error < 1e-7, "{section}, {accuracy}: {error:e}");
            assert_near(factor, expected, error + 5e-11);
        }
    }
}

/// Factors of a column with a joint of springs go to a limit with one over the stiffness; as entries of a matrix such springs left
/// three digits of it, or none.
#[test]
fn stiff_springs_leave_the_digits_that_are_stated() {
    let directory = tempfile::tempdir().expect("a directory");
    let network = directory.path().join("column.toml");
    // The first two were found to 1e-12 and lie on one line in 1 / stiffness, on which the last one follows: 3.85281217989 at zero.
    for (stiffness, expected) in [("1e7", 3.852_812_037_43), ("1e9", 3.852_812_178_47), ("1e11", 3.852_812_179_87)] {
        let text = format!(
            "format = \"pennate/1\"\n[nodes]\na = [0, 0]\nm = [3, 4]\nb = [30, 40]\nc = [33, 44]\n\
             [sections]\nt = {{ stiffness = {{ EA = 2e4, GA2 = 1e4, GA3 = 1e4, GJ = 2000, EI2 = 3000, EI3 = 5000 }} }}\n\
             [members]\nm0 = {{ nodes = [\"a\", \"m\"], section = \"t\" }}\n\
             m1 = {{ nodes = [\"b\", \"c\"], section = \"t\" }}\n[supports]\na = \"clamped\"\n\
             [springs]\nj = {{ nodes = [\"m\", \"b\"], stiffness = {{ ux = {stiffness}, uy = {stiffness}, rz = 1e4 }} }}\n\
             [[steps]]\nforce = {{ c = [-3, -4, 0] }}\n"
        );
        std::fs::write(&network, text).expect("a file");
        for accuracy in ["1e-4", "1e-8"] {
            let found = buckling(&network, &["--accuracy", accuracy, "--count", "1"]);
            let (factor, error) = (factors(&found)[0], errors(&found)[0]);
            assert!(error < 1e-7, "{stiffness}, {accuracy}: {error:e}");
            assert_near(factor, expected, error + 5e-11);
        }
    }
}
