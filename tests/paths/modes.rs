//! Natural frequencies from network files against closed forms and exact frequency equations.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn pennate(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pennate")).args(arguments).output().expect("pennate can be started")
}

/// `modes.json` of a file.
fn modes(file: &Path, more: &[&str]) -> Value {
    let mut arguments = vec!["modes", file.to_str().expect("a path in letters"), "--json"];
    arguments.extend(more);
    let output = pennate(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// Angular frequencies of one family, or of all, by rising value.
fn frequencies(modes: &Value, family: Option<&str>) -> Vec<f64> {
    let entries = modes["modes"].as_array().expect("a list of modes").iter();
    let kept = entries.filter(|mode| family.is_none_or(|family| mode["family"] == family));
    kept.map(|mode| mode["angular_frequency"].as_f64().expect("a frequency")).collect()
}

struct Network {
    _directory: tempfile::TempDir,
    file: PathBuf,
}

fn network(text: &str) -> Network {
    let directory = tempfile::tempdir().expect("a directory");
    let file = directory.path().join("network.toml");
    std::fs::write(&file, format!("format = \"pennate/1\"\n{text}")).expect("a file");
    Network { _directory: directory, file }
}

#[track_caller]
fn assert_near(found: &[f64], expected: &[f64], tolerance: f64) {
    assert!(found.len() >= expected.len(), "{} of {} frequencies", found.len(), expected.len());
    for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
        let error = (found / expected - 1.0).abs();
        assert!(error <= tolerance, "frequency {}: {found} instead of {expected}, error {error:.1e}", k + 1);
    }
}

/// All frequencies of the reference, to 1e-6 with default settings, and no others between them.
#[test]
fn frequencies_are_those_of_the_exact_frequency_equations() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/19_natural_frequencies");
    let text = std::fs::read_to_string(folder.join("reference.json")).expect("the reference");
    let reference: Value = serde_json::from_str(&text).expect("JSON");
    let cases: [(&str, &[&str]); 4] = [
        ("cantilever.toml", &[]),
        ("cantilever.toml", &["--set", "L=10"]),
        ("hsim.toml", &["--step", "straight"]),
        ("hsim.toml", &[]),
    ];
    for (k, (file, settings)) in cases.into_iter().enumerate() {
        let result = &reference["results"][k];
        let list = |name: &str| -> Vec<f64> {
            let numbers = result[format!("{name}_angular_frequencies_rad_s")].as_array();
            let text = numbers.into_iter().flatten().map(|number| number.as_str().expect("a number as text"));
            text.map(|number| number.parse().expect("a number")).collect()
        };
        let (bending, axial, torsion) = (list("bending"), list("axial"), list("torsion"));
        let found = modes(&folder.join(file), &[&["--count", "40"], settings].concat());

        // Every list is complete up to its last frequency.
        let merged = |lists: &[&[f64]]| {
            let limit = lists.iter().map(|list| list[list.len() - 1]).fold(f64::INFINITY, f64::min);
            let mut all: Vec<f64> = lists.concat().into_iter().filter(|w| *w <= limit).collect();
            all.sort_by(f64::total_cmp);
            all
        };
        assert_near(&frequencies(&found, Some("in_plane")), &merged(&[&bending, &axial]), 1e-6);
        let out_of_plane = frequencies(&found, Some("out_of_plane"));
        if torsion.is_empty() {
            for expected in &bending[..5] {
                let nearest = out_of_plane.iter().map(|w| (w / expected - 1.0).abs()).fold(f64::INFINITY, f64::min);
                assert!(nearest <= 1e-6, "{file}: {expected}, error {nearest:.1e}");
            }
        } else {
            assert_near(&out_of_plane, &merged(&[&bending, &torsion]), 1e-6);
        }
    }
}

/// Shear-rigid, without rotatory inertia, the bar is Euler's: ω = β² √(EI/ρA) / L², cos β cosh β = −1.
#[test]
fn a_shear_rigid_cantilever_vibrates_as_eulers() {
    let bar = network(
        r#"
[nodes]
A = [0, 0, 0]
B = [2, 0, 0]
[sections]
rod = { stiffness = { EA = 1e6, GJ = 5, EI2 = 3, EI3 = 12, mass_per_length = 0.7 } }
[members]
bar = { nodes = ["A", "B"], section = "rod" }
[supports]
A = "clamped"
"#,
    );
    let found = frequencies(&modes(&bar.file, &["--count", "6"]), None);
    let roots: [f64; 4] = [1.875_104_068_711_961, 4.694_091_132_974_175, 7.854_757_438_237_613, 10.995_540_734_875_467];
    let of = |stiffness: f64| roots.map(|root| root * root * (stiffness / 0.7_f64).sqrt() / 4.0);
    let mut expected = [of(3.0), of(12.0)].concat();
    expected.sort_by(f64::total_cmp);
    assert_near(&found, &expected[..6], 1e-6);
}

/// A rod between pins under tension: ωₙ = (nπ/L)² √(EI/ρA) √(1 + N L²/(n²π² EI)), rigid in shear and stretch.
#[test]
fn tension_raises_the_frequencies_of_a_rod() {
    let rod = network(
        r#"
[nodes]
A = [0, 0]
B = [3, 0]
[sections]
rod = { stiffness = { EA = 1, EI3 = 2, mass_per_length = 0.5 }, shear = false, stretch = false }
[members]
rod = { nodes = ["A", "B"], section = "rod" }
[supports]
A = "pinned"
B = ["uy"]
[[steps]]
name = "pull"
force = { B = [50, 0, 0] }
"#,
    );
    let expected: Vec<f64> = (1..=5)
        .map(|n| {
            let k = f64::from(n) * PI / 3.0;
            k * k * (2.0_f64 / 0.5).sqrt() * (1.0 + 50.0 / (2.0 * k * k)).sqrt()
        })
        .collect();
    assert_near(&frequencies(&modes(&rod.file, &["--count", "5"]), Some("in_plane")), &expected, 1e-6);
}

/// A body at the tip of a nearly massless cantilever: ω² = 3 EI/(m L³) sideways both ways.
#[test]
fn a_body_moves_on_a_cantilever_as_a_mass_on_a_spring() {
    let rod = network(
        r#"
[nodes]
A = [0, 0, 0]
B = [2, 0, 0]
C = [2, 0.3, 0]
[sections]
rod = { stiffness = { EA = 1e6, GJ = 5, EI2 = 3, EI3 = 12, mass_per_length = 1e-9 } }
[members]
rod = { nodes = ["A", "B"], section = "rod" }
[rigid_bodies]
tip = { nodes = ["B", "C"], reference = "B", mass = 4 }
[supports]
A = "clamped"
"#,
    );
    let found = frequencies(&modes(&rod.file, &["--count", "2"]), None);
    assert_near(&found, &[3.0, 12.0].map(|stiffness: f64| (3.0 * stiffness / (4.0 * 8.0)).sqrt()), 1e-6);
}

/// A network whose unknowns go beyond what is solved as a whole: twelve equal cantilevers, every frequency twelve times.
#[test]
fn equal_frequencies_of_equal_members_are_all_found() {
    let mut text = "dimension = \"space\"\n".to_owned();
    text += "sections.rod = { stiffness = { EA = 1e6, GJ = 5, EI2 = 3, EI3 = 12, mass_per_length = 0.7 } }\n";
    for k in 0..12 {
        text += &format!("nodes.A{k} = [0, {k}, 0]\nnodes.B{k} = [2, {k}, 0]\nsupports.A{k} = \"clamped\"\n");
        text += &format!("members.m{k} = {{ nodes = [\"A{k}\", \"B{k}\"], section = \"rod\" }}\n");
    }
    let comb = network(&text);
    let found = frequencies(&modes(&comb.file, &["--count", "30"]), None);
    let of = |root: f64, stiffness: f64| root * root * (stiffness / 0.7_f64).sqrt() / 4.0;
    let first = of(1.875_104_068_711_961, 3.0);
    let second = of(1.875_104_068_711_961, 12.0);
    let third = of(4.694_091_132_974_175, 3.0);
    let expected = [[first; 12].as_slice(), &[second; 12], &[third; 6]].concat();
    assert_near(&found, &expected, 1e-6);
}

/// A rod with a body at its end that is by far heavier swings slowly as a whole, and beside that as if it were pinned there: of one and of
/// twelve, whatever the body weighs, with all digits.
#[test]
fn heavy_bodies_hide_no_vibrations_of_what_is_light() {
    let (ea, ei2, ei3, line): (f64, f64, f64, f64) = (1e3, 3.0, 12.0, 0.7);
    for (rods, mass) in [(1, 1e8), (1, 1e16), (12, 1e8), (12, 1e16)] {
        let mut text = "dimension = \"space\"\n".to_owned();
        text += &format!(
            "sections.rod = {{ stiffness = {{ EA = {ea}, GJ = 5, EI2 = {ei2}, EI3 = {ei3}, mass_per_length = {line} }} }}\n"
        );
        for k in 0..rods {
            text += &format!("nodes.A{k} = [0, {k}, 0]\nnodes.B{k} = [2, {k}, 0]\nsupports.A{k} = \"clamped\"\n");
            text += &format!("members.m{k} = {{ nodes = [\"A{k}\", \"B{k}\"], section = \"rod\" }}\n");
            text += &format!("rigid_bodies.b{k} = {{ nodes = [\"B{k}\"], mass = {mass:e} }}\n");
        }
        let found = modes(&network(&text).file, &["--count", &(6 * rods).to_string()]);
        let swaying = |ei: f64| (3.0 * ei / (8.0 * mass)).sqrt();
        let pinned = |root: f64, ei: f64| root * root * (ei / line).sqrt() / 4.0;
        let [first, second] = [3.926_602_312_047_919, 7.068_582_745_628_732];
        let expected = [
            swaying(ei2),
            swaying(ei3),
            (ea / (2.0 * mass)).sqrt(),
            pinned(first, ei2),
            pinned(first, ei3),
            pinned(second, ei2),
        ];
        let expected: Vec<f64> = expected.iter().flat_map(|&value| vec![value; rods]).collect();
        assert_near(&frequencies(&found, None), &expected, 1e-6);
        assert_eq!(found["notes"].as_array().expect("notes").len(), 0, "{}", found["notes"]);
    }
}

/// Sixty modes of one rod, of spaces in which 1/ω² is small beside one: ωₙ = (n − ½)²π²/L² √(EI/m) to what the first roots differ by.
#[test]
fn many_modes_of_a_stiff_rod_are_found() {
    let (ei, line, length): (f64, f64, f64) = (98.0, 7.854e-10, 20.0);
    let text = format!(
        "dimension = \"plane\"\nnodes.A = [0, 0]\nnodes.B = [0, {length}]\nsupports.A = \"clamped\"\n\
         sections.rod = {{ stiffness = {{ EA = 1e9, EI3 = {ei}, mass_per_length = {line:e} }}, shear = false }}\n\
         members.rod = {{ nodes = [\"A\", \"B\"], section = \"rod\" }}\n"
    );
    let all = modes(&network(&text).file, &["--count", "60"]);
    let found = frequencies(&all, None);
    assert_eq!(found.len(), 60);
    // From the sixth root on cos x cosh x = −1 is cos x = 0 to 1e-7.
    let expected: Vec<f64> =
        (6..=60).map(|n| ((f64::from(n) - 0.5) * PI / length).powi(2) * (ei / line).sqrt()).collect();
    assert_near(&found[5..], &expected, 1e-6);
    assert!(!all["notes"].to_string().contains("missing"), "{}", all["notes"]);
}

/// Four storeys of columns under beams ten thousand times as stiff, at nine tenths of the critical load: whether members cannot be
/// stretched, or next to nothing, the vibrations are the same, and none is lost.
#[test]
fn stiff_beams_on_columns_that_cannot_be_stretched_do_not_hide_vibrations() {
    let frame = |axial: &str| {
        let (mut nodes, mut members, mut supports, mut loads) =
            (String::new(), String::new(), String::new(), String::new());
        for line in 0..4 {
            for storey in 0..5 {
                nodes += &format!("J{line}_{storey} = [{}, {}]\n", 100 * line, 100 * storey);
                if storey == 0 {
                    supports += &format!("J{line}_0 = \"clamped\"\n");
                    continue;
                }
                let below = storey - 1;
                members += &format!(
                    "c{line}_{storey} = {{ nodes = [\"J{line}_{below}\", \"J{line}_{storey}\"], section = \"column\" }}\n"
                );
                if line < 3 {
                    let next = line + 1;
                    members += &format!(
                        "b{line}_{storey} = {{ nodes = [\"J{line}_{storey}\", \"J{next}_{storey}\"], section = \"beam\" }}\n"
                    );
                }
            }
            loads += &format!("J{line}_4 = [0, {:?}], ", -0.09 * PI * PI);
        }
        let section = |ei: &str| format!("{{ stiffness = {{ EI3 = {ei}, mass_per_length = 1e-6, {axial} }}");
        network(&format!(
            "dimension = \"plane\"\n[nodes]\n{nodes}[sections]\ncolumn = {}\nbeam = {}\n[members]\n{members}\
             [supports]\n{supports}\n[[steps]]\nname = \"load\"\nforce = {{ {loads} }}\n",
            section("1e3"),
            section("1e7"),
        ))
    };
    let found = |axial: &str| modes(&frame(axial).file, &["--count", "4"]);
    let rigid = found("EA = 1 }, stretch = false");
    let stiff = frequencies(&found("EA = 1e10 }"), None);
    assert_eq!(stiff.len(), 4);
    assert_near(&frequencies(&rigid, None), &stiff, 1e-5);
    let notes = rigid["notes"].to_string();
    assert!(!notes.contains("missing"), "{notes}");
}

/// A thread under tension, clamped and turned round at its end by half a turn: it bends within a few tenths of a millimetre of its
/// ends, which elements of equal length do not follow. The vibrations are those of a taut string between clamps,
/// ωₙ = (nπ/L) √(N/ρA) (1 + 2ε + (4 + n²π²/2) ε²) with ε = √(EI/N)/L (P. M. Morse, Vibration and Sound, 1948), its stretch taken into
/// account.
#[test]
fn a_thread_that_bends_at_its_ends_alone_has_the_frequencies_of_a_string() {
    let (ea, ei, force, length): (f64, f64, f64, f64) = (121e3, 0.0234, 55.0, 100.0);
    let thread = network(&format!(
        r#"
dimension = "space"
[nodes]
A = [0, 0, 0]
B = [{length:?}, 0, 0]
[sections]
thread = {{ stiffness = {{ EA = {ea:?}, EI2 = {ei:?}, EI3 = {ei:?}, GJ = 0.0164, mass_per_length = 1e-6 }} }}
[members]
thread = {{ nodes = ["A", "B"], section = "thread" }}
[supports]
A = "clamped"
B = ["uy", "uz", "rx", "ry", "rz"]
[[steps]]
name = "pull"
force = {{ B = [{force:?}, 0, 0] }}
[[steps]]
name = "turn"
rotation = {{ B = [176.7, 0, 13.31] }}
"#
    ));
    let found = frequencies(&modes(&thread.file, &["--count", "4"]), None);
    let ends = (ei / force).sqrt() / length;
    let expected = [1.0, 1.0, 2.0, 2.0].map(|n: f64| {
        let clamped = 1.0 + 2.0 * ends + (4.0 + 0.5 * (n * PI).powi(2)) * ends * ends;
        n * PI / length * (force / 1e-6 / (1.0 + force / ea)).sqrt() * clamped
    });
    // The turned end bends the thread a little, and twists it.
    assert_near(&found, &expected, 3e-6);
}

/// What one element lacks that the file forces, finer ones of the members beside it do not make up for: the search ends there.
#[test]
fn members_beside_elements_that_are_forced_do_not_grow_without_end() {
    let bent = network(
        "nodes = { A = [0, 0], B = [60, 10], C = [100, -30], D = [160, 30] }
         materials.m = { youngs_modulus = 2000, poissons_ratio = 0.3, density = 1e-9 }
         sections.s = { circle = { radius = 2 } }
         members.a = { nodes = ['A', 'B'], section = 's', material = 'm' }
         members.b = { nodes = ['B', 'C'], section = 's', material = 'm', elements = 1 }
         members.c = { nodes = ['C', 'D'], section = 's', material = 'm' }
         supports = { A = 'clamped', D = 'pinned' }",
    );
    let found = modes(&bent.file, &["--count", "3", "--accuracy", "1e-5"]);
    let errors = found["modes"].as_array().expect("a list of modes").iter().map(|mode| mode["error"].as_f64());
    assert!(errors.flatten().any(|error| error > 1e-3), "{}", found["modes"]);
    let elements = found["mesh"]["elements"].as_u64().expect("a number of elements");
    assert!(elements < 5000, "{elements} elements");
}

/// Pictures hold the mode as a displacement and its frequency.
#[test]
fn every_mode_has_a_picture() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/19_natural_frequencies");
    let out = tempfile::tempdir().expect("a directory");
    let directory = out.path().to_str().expect("a path in letters");
    let file = folder.join("hsim.toml");
    let found = modes(&file, &["--count", "3", "-o", directory, "--vtk"]);
    let written = std::fs::read_to_string(out.path().join("modes.json")).expect("modes.json");
    let written: Value = serde_json::from_str(&written).expect("JSON");
    assert_eq!(written["modes"], found["modes"]);
    for k in 1..=3 {
        let picture = std::fs::read_to_string(out.path().join(format!("hsim_mode_0{k}.vtu"))).expect("a picture");
        assert!(picture.contains(r#"Name="displacement""#), "mode {k}");
        let frequency = found["modes"][k - 1]["frequency_hz"].as_f64().expect("a frequency");
        let field = r#"Name="frequency_hz" NumberOfTuples="1" format="ascii">"#;
        let (_, value) = picture.split_once(field).expect("the field");
        let value: f64 = value.split('<').next().and_then(|text| text.trim().parse().ok()).expect("a number");
        assert!((value - frequency).abs() <= 1e-15 * frequency, "mode {k}: {value} and {frequency}");
    }
}

/// What is missing or free is said with the member's or step's name, and ends with status 2.
#[test]
fn refusals_say_what_to_do() {
    let rod = |section: &str, supports: &str| {
        network(&format!(
            "[nodes]\nA = [0, 0]\nB = [1, 0]\n[sections]\nrod = {{ stiffness = {{ EA = 1, GA2 = 1, EI3 = 1{section} }} }}\n\
             [members]\nstrut = {{ nodes = [\"A\", \"B\"], section = \"rod\" }}\n[supports]\nA = {supports}\n"
        ))
    };
    let mass = ", mass_per_length = 1";
    let cases = [
        (rod("", "\"clamped\""), &[][..], "member 'strut' has no mass"),
        (rod(mass, "[\"ux\", \"uy\"]"), &[], "mechanism"),
        (rod(mass, "\"clamped\""), &["--step", "later"], "no step 'later'"),
    ];
    for (network, more, expected) in cases {
        let mut arguments = vec!["modes", network.file.to_str().expect("a path in letters")];
        arguments.extend(more);
        let output = pennate(&arguments);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(expected) && message.contains("help:"), "{message}");
        assert!(output.stdout.is_empty());
    }
}
