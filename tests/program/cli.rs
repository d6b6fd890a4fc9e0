//! The command line as a user meets it: exit status, messages, files.

use std::fs;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

const MUSCLE: &str = r#"
[muscles.silicone]
diameter = 13
wall = 2.0
pressure_unit = "psi"
density = 1.1e-9
table = [
  { pressure = 10, E = 3.60, alpha = -9.135e-3, R1 = 6.80, R2 = 7.90 },
  { pressure = 25, E = 4.25, alpha = -6.885e-3, R1 = 7.15, R2 = 8.90 },
]
"#;

const DYAD: &str = r#"format = "pennate/1"
title = "dyad"

[parameters]
L = 130
beta = 22

[nodes]
A = ["= -L * cos(beta)", "= -L * sin(beta)"]
B = ["= L * cos(beta)", "= -L * sin(beta)"]
J = [0, 0]

[members]
left = { nodes = ["A", "J"], muscle = "silicone" }
right = { nodes = ["B", "J"], muscle = "silicone" }

[supports]
A = "clamped"
B = "clamped"

[[steps]]
name = "inflate"
pressure = { all = 25 }

[[steps]]
name = "push back"
displacement = { J = { uy = 0.0 } }

[probes]
stroke = { node = "J", displacement = "uy" }
holding = { node = "J", reaction = "uy" }
"#;

/// A shallow arch of two struts that snaps through under its load.
const TOGGLE: &str = r#"format = "pennate/1"
dimension = "plane"
[nodes]
A = [-100, 0]
B = [100, 0]
J = [0, 4]
[materials]
steel = { youngs_modulus = 1000, poissons_ratio = 0.3 }
[sections]
strut = { circle = { radius = 1 } }
[members]
left = { nodes = ["A", "J"], section = "strut", material = "steel" }
right = { nodes = ["B", "J"], section = "strut", material = "steel" }
[supports]
A = "clamped"
B = "clamped"
[[steps]]
name = "pull"
force = { J = [0, 0.01, 0] }
[[steps]]
name = "push"
force = { J = [0, -0.2, 0] }
increments = 40
[[steps]]
name = "rest"
force = { J = [0, 0, 0] }
[probes]
depth = { node = "J", displacement = "uy" }
"#;

struct Workplace {
    directory: TempDir,
}

impl Workplace {
    fn new() -> Self {
        Self { directory: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    fn file(&self, name: &str, text: &str) -> PathBuf {
        fs::write(self.path(name), text).unwrap();
        self.path(name)
    }

    fn dyad(&self) -> PathBuf {
        self.file("dyad.toml", &format!("{DYAD}{MUSCLE}"))
    }

    fn entries(&self) -> usize {
        fs::read_dir(self.directory.path()).unwrap().count()
    }
}

fn pennate() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pennate"));
    command.stdin(Stdio::null());
    command
}

fn solve(file: &Path) -> Command {
    let mut command = pennate();
    command.arg("solve").arg(file);
    command
}

fn out(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).unwrap()
}

fn err(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).unwrap()
}

#[track_caller]
fn expect(output: &Output, status: i32) {
    assert_eq!(output.status.code(), Some(status), "\n{}\n{}", out(output), err(output));
    assert!(!err(output).contains("panicked"), "{}", err(output));
}

fn results(directory: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(directory.join("results.json")).unwrap()).unwrap()
}

#[test]
fn a_dyad_is_solved_and_a_table_printed_and_nothing_written() {
    let place = Workplace::new();
    let output = solve(&place.dyad()).output().unwrap();
    expect(&output, 0);
    assert!(err(&output).is_empty(), "{}", err(&output));
    for word in ["dyad", "inflate", "push back", "converged", "stroke", "holding", "mm", "N"] {
        assert!(out(&output).contains(word), "{word} in\n{}", out(&output));
    }
    assert_eq!(place.entries(), 1);
}

#[test]
fn results_history_and_pictures_are_written_where_asked() {
    let place = Workplace::new();
    let directory = place.path("deep/results");
    let output = solve(&place.dyad()).arg("-o").arg(&directory).arg("--vtk").output().unwrap();
    expect(&output, 0);
    let results = results(&directory);
    let increments: u64 =
        results["steps"].as_array().unwrap().iter().map(|step| step["increments"].as_u64().unwrap()).sum();
    let history = fs::read_to_string(directory.join("history.csv")).unwrap();
    assert_eq!(history.lines().count() as u64, increments + 2, "a head, the unloaded state, the increments");
    assert!(history.starts_with("step,fraction,pressure all (psi),stroke (mm),holding (N)\ninflate,0.0,0.0,0.0,0.0\n"));
    assert!(history.contains("\ninflate,1.0,25.0,"), "{history}");
    let pictures = (0..=increments).filter(|count| directory.join(format!("dyad_{count:04}.vtu")).is_file()).count();
    assert_eq!(pictures as u64, increments + 1);
    let files = fs::read_dir(&directory).unwrap().count();
    assert_eq!(files, pictures + 3, "nothing else is left behind");
    let stroke = results["steps"][0]["probes"]["stroke"].as_f64().unwrap();
    assert!(stroke < -30.0, "{stroke}");
    assert_eq!(results["steps"][1]["probes"]["stroke"].as_f64(), Some(0.0));
}

/// Points and a vector of point data of a picture.
fn picture(path: &Path, name: &str) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    use vtkio::model::{Attribute, DataSet, Vtk};
    let DataSet::UnstructuredGrid { pieces, .. } = Vtk::import(path).unwrap().data else { panic!("no grid") };
    let piece = pieces[0].load_piece_data(None).unwrap();
    let triples = |values: Vec<f64>| values.chunks(3).map(|x| [x[0], x[1], x[2]]).collect::<Vec<_>>();
    let data = piece.data.point.iter().find_map(|attribute| match attribute {
        Attribute::DataArray(array) if array.name == name => array.data.clone().cast_into::<f64>(),
        _ => None,
    });
    (triples(piece.points.cast_into::<f64>().unwrap()), triples(data.expect("the point data")))
}

/// The mode of a column that is clamped at both ends is 1 - cos(2 pi x / L), to which the cubics come near.
#[test]
fn the_mode_of_a_critical_point_is_drawn_inside_of_members_too() {
    let place = Workplace::new();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/columns/clamped.toml");
    expect(&solve(&file).arg("-o").arg(place.path("out")).arg("--vtk").output().unwrap(), 0);
    let results = results(&place.path("out"));
    let points = results["steps"].as_array().unwrap().iter().map(|s| s["critical_points"].as_array().unwrap().len());
    let count: usize = points.sum();
    assert_eq!(count, 1);
    assert!(!place.path("out/clamped_mode_0002.vtu").exists());
    let (places, mode) = picture(&place.path("out/clamped_mode_0001.vtu"), "mode");
    assert_eq!(places.len(), mode.len());
    let length = places.iter().map(|p| p[0]).fold(0.0, f64::max);
    let largest = mode.iter().map(|m| m[1].hypot(m[2])).fold(0.0, f64::max);
    assert!((largest / length - 0.1).abs() < 0.01, "{largest} of {length}");
    for (place, mode) in places.iter().zip(&mode) {
        let expected = 0.5 * (1.0 - (std::f64::consts::TAU * place[0] / length).cos()) * largest;
        assert!((mode[1].hypot(mode[2]) - expected).abs() < 0.03 * largest, "{place:?}: {mode:?}");
        assert!(mode[0].abs() < 0.01 * largest, "{mode:?}");
    }
}

#[cfg(unix)]
#[test]
fn results_can_be_read_by_those_whom_the_umask_allows() {
    use std::os::unix::fs::PermissionsExt;
    let place = Workplace::new();
    let other = place.file("other", "");
    expect(&solve(&place.dyad()).arg("-o").arg(place.path("out")).output().unwrap(), 0);
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&place.path("out/results.json")), mode(&other));
}

#[test]
fn json_goes_to_standard_output_and_nothing_else_does() {
    let place = Workplace::new();
    let output = solve(&place.dyad()).arg("--json").output().unwrap();
    expect(&output, 0);
    let printed: Value = serde_json::from_str(out(&output)).unwrap();
    assert_eq!(printed["format"], "pennate-results/1");
    assert_eq!(place.entries(), 1);
}

#[test]
fn a_network_can_come_from_standard_input_with_other_parameters() {
    let mut child = pennate()
        .args(["solve", "-", "--json", "--set", "beta=30", "--set", "L = 120"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(format!("{DYAD}{MUSCLE}").as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    expect(&output, 0);
    let printed: Value = serde_json::from_str(out(&output)).unwrap();
    let position = printed["steps"][0]["nodes"]["A"]["position"][1].as_f64().unwrap();
    assert!((position + 60.0).abs() < 1e-12, "{position}");
}

#[test]
fn wrong_input_is_shown_at_its_place_and_nothing_is_written() {
    let cases = [
        ("muscle = \"silicone\" }\nright", "muscle = \"silicon\" }\nright", "silicone"),
        ("beta = 22", "beta = nan", "beta"),
        ("[supports]", "[suports]", "supports"),
        ("\"= -L * sin(beta)\"]\nB", "\"= -L * sin(betta)\"]\nB", "beta"),
        ("[nodes]", "[nodes", "dyad.toml:8"),
        ("J = [0, 0]", "J = \"= 1 / 0\"", "J"),
        ("pressure = { all = 25 }", "pressure = { all = 26 }", "25"),
        ("wall = 2.0", "wall = 7.0", "wall"),
    ];
    for (right, wrong, word) in cases {
        let place = Workplace::new();
        let text = format!("{DYAD}{MUSCLE}");
        assert!(text.contains(right), "{right}");
        let file = place.file("dyad.toml", &text.replacen(right, wrong, 1));
        for command in ["solve", "check"] {
            let mut run = pennate();
            run.arg(command).arg(&file);
            if command == "solve" {
                run.arg("--json").arg("-o").arg(place.path("out"));
            }
            let output = run.output().unwrap();
            expect(&output, 2);
            assert!(out(&output).is_empty(), "{}", out(&output));
            assert!(err(&output).starts_with("error: "), "{}", err(&output));
            assert!(err(&output).contains("dyad.toml:"), "{}", err(&output));
            assert!(err(&output).contains(word), "{word} in\n{}", err(&output));
            assert!(!err(&output).contains('\u{1b}'), "colour where no terminal is");
        }
        assert_eq!(place.entries(), 1, "{wrong}");
    }
}

#[test]
fn a_file_that_is_not_there_and_bytes_that_are_no_text_are_wrong_input() {
    let place = Workplace::new();
    let output = solve(&place.path("nowhere.toml")).output().unwrap();
    expect(&output, 2);
    assert!(err(&output).contains("nowhere.toml"), "{}", err(&output));
    fs::write(place.path("bytes.toml"), [0xff, 0xfe, 0x00]).unwrap();
    expect(&solve(&place.path("bytes.toml")).output().unwrap(), 2);
    expect(&solve(place.directory.path()).output().unwrap(), 2);
    expect(&solve(&place.file("empty.toml", "")).output().unwrap(), 2);
}

#[test]
fn wrong_arguments_are_wrong_input() {
    let place = Workplace::new();
    let dyad = place.dyad();
    for arguments in [
        &["--accuracy", "0"][..],
        &["--accuracy", "nan"],
        &["--threads", "0"],
        &["--set", "beta"],
        &["--vtk"],
        &["--nonsense"],
    ] {
        expect(&solve(&dyad).args(arguments).output().unwrap(), 2);
    }
    let output = solve(&dyad).args(["--set", "gamma=3"]).output().unwrap();
    expect(&output, 2);
    assert!(err(&output).contains("gamma"), "{}", err(&output));
}

/// Every free motion by itself: of the network as a whole, of parts of it, and of single nodes.
#[test]
fn free_motions_are_told_one_by_one() {
    const HEAD: &str = r#"format = "pennate/1"
sections.rod = { stiffness = { EA = 3e4, GA2 = 1e4, GA3 = 1.4e4, GJ = 7e3, EI2 = 1e4, EI3 = 2e4 } }
"#;
    let frame = r#"
nodes = { A = [0, 0], B = [60, 0], C = [60, 40] }
members = { a = { nodes = ["A", "B"], section = "rod" }, b = { nodes = ["B", "C"], section = "rod" } }
"#;
    let hinges = r#"
[nodes]
A = [0, 0]
B = [60, 0]
C = [120, 0]
D = [0, 60]
[members]
a = { nodes = ["A", "B"], section = "rod" }
b = { nodes = ["B", "C"], section = "rod", release = { start = "pin" } }
c = { nodes = ["A", "D"], section = "rod", release = { start = "pin" } }
[supports]
A = "clamped"
"#;
    let parts = r#"
[nodes]
A = [0, 0]
B = [60, 0]
C = [120, 7]
D = [150, 60]
[members]
a = { nodes = ["A", "B"], section = "rod" }
b = { nodes = ["C", "D"], section = "rod" }
[supports]
A = "clamped"
C = ["rz"]
"#;
    let plane = "dimension = \"plane\"\n";
    let space = "dimension = \"space\"\n";
    let cases: [(String, &[&str]); 6] = [
        (
            format!("{HEAD}{plane}{frame}supports = {{ A = [\"rz\"] }}\n"),
            &["the whole network moves freely along x", "the whole network moves freely along y"],
        ),
        (
            format!("{HEAD}{plane}{frame}supports = {{ A = \"pinned\" }}\n"),
            &["the whole network turns freely about z at node A"],
        ),
        (
            format!("{HEAD}{plane}{frame}supports = {{ A = [\"uy\", \"rz\"] }}\n"),
            &["the whole network moves freely along x"],
        ),
        (
            format!("{HEAD}{space}{frame}supports = {{ A = [\"uz\"] }}\n"),
            &[
                "the whole network moves freely along x",
                "the whole network moves freely along y",
                "the whole network turns freely about z",
                "the whole network turns freely about x at node A",
                "the whole network turns freely about y at node A",
            ],
        ),
        (
            format!("{HEAD}{plane}{hinges}"),
            &["node D moves freely along (1, 0, 0)", "node C moves freely along (0, 1, 0)"],
        ),
        (
            format!("{HEAD}{plane}{parts}"),
            &["the part with node C moves freely along x", "the part with node C moves freely along y"],
        ),
    ];
    for (text, expected) in cases {
        let place = Workplace::new();
        let output = pennate().arg("check").arg(place.file("loose.toml", &text)).output().unwrap();
        expect(&output, 2);
        let titles: Vec<&str> = err(&output).lines().filter(|line| line.contains("is a mechanism")).collect();
        assert_eq!(titles.len(), expected.len(), "{}", err(&output));
        for words in expected {
            assert!(titles.iter().any(|title| title.ends_with(words)), "{words} in\n{}", err(&output));
        }
    }
}

/// A chain of two bars that is held at its end by a spring, soft or all but nothing.
#[test]
fn what_holds_a_network_by_next_to_nothing_is_warned_of() {
    for (stiffness, warned) in [("5e-11", true), ("1e-6", false)] {
        let text = format!(
            r#"format = "pennate/1"
dimension = "plane"
[nodes]
A = [0, 0]
B = [60, 0]
C = [120, 0]
[sections]
rod = {{ stiffness = {{ EA = 3e4, GA2 = 1e4, GA3 = 1.4e4, GJ = 7e3, EI2 = 1e4, EI3 = 2e4 }} }}
[members]
a = {{ nodes = ["A", "B"], section = "rod" }}
b = {{ nodes = ["B", "C"], section = "rod", release = {{ start = "pin" }} }}
[supports]
A = "clamped"
[springs]
held = {{ node = "C", stiffness = {{ uy = {stiffness} }} }}
[[steps]]
force = {{ C = [1, 0] }}
"#
        );
        let place = Workplace::new();
        let file = place.file("soft.toml", &text);
        for command in ["solve", "check"] {
            let output = pennate().arg(command).arg(&file).output().unwrap();
            expect(&output, 0);
            let found = err(&output).contains("warning: the network is nearly a mechanism: node C moves almost freely");
            assert_eq!(found, warned, "{}", err(&output));
            assert!(!warned || err(&output).contains("help:"), "{}", err(&output));
        }
    }
}

#[test]
fn a_mechanism_is_refused_by_check_and_solve_with_its_motion() {
    let place = Workplace::new();
    let text = format!("{DYAD}{MUSCLE}").replace("A = \"clamped\"", "A = \"pinned\"").replace("B = \"clamped\"\n", "");
    let file = place.file("dyad.toml", &text);
    for command in ["solve", "check"] {
        let output = pennate().arg(command).arg(&file).output().unwrap();
        expect(&output, 2);
        assert!(out(&output).is_empty());
        assert!(err(&output).contains("mechanism"), "{}", err(&output));
        assert!(err(&output).contains("freely"), "{}", err(&output));
        assert!(err(&output).contains("dyad.toml:"), "{}", err(&output));
    }
}

#[test]
fn check_says_what_the_network_is() {
    let place = Workplace::new();
    let output = pennate().arg("check").arg(place.dyad()).output().unwrap();
    expect(&output, 0);
    assert!(out(&output).contains("plane network of 3 nodes and 2 muscles"), "{}", out(&output));
}

#[test]
fn the_schema_is_json() {
    let output = pennate().arg("schema").output().unwrap();
    expect(&output, 0);
    let schema: Value = serde_json::from_str(out(&output)).unwrap();
    assert!(schema.is_object());
}

#[test]
fn a_step_without_equilibrium_exits_1_and_keeps_what_had_converged() {
    let place = Workplace::new();
    let file = place.file("toggle.toml", TOGGLE);
    let output = solve(&file).arg("-o").arg(place.path("out")).output().unwrap();
    expect(&output, 1);
    for word in ["step 'push'", "node J", "help:", "toggle.toml:", "1 later step"] {
        assert!(err(&output).contains(word), "{word} in\n{}", err(&output));
    }
    let results = results(&place.path("out"));
    let statuses: Vec<&str> =
        results["steps"].as_array().unwrap().iter().map(|step| step["status"].as_str().unwrap()).collect();
    assert!(matches!(statuses[..], ["converged", "limit_point" | "not_converged", "not_reached"]), "{statuses:?}");
    assert_eq!(results["status"], statuses[1]);
    assert!(results["steps"][1]["nodes"]["J"].is_object(), "what had converged is kept");
    assert!(results["steps"][2]["nodes"].as_object().unwrap().is_empty());
}

/// The forces of a wire a thousand million times stiffer than what it hangs on are those of a motion of 1e-13 of it.
#[test]
fn few_digits_are_warned_of_with_their_place() {
    let place = Workplace::new();
    let network = |stiffness: f64| {
        format!(
            "format = \"pennate/1\"\nnodes = {{ A = [0, 0], M = [40, 30], T = [80, 60] }}\n\
             sections.soft = {{ stiffness = {{ EA = 1e4, GA2 = 5e3, EI3 = 1e4 }} }}\n\
             sections.wire = {{ stiffness = {{ EA = {stiffness:?}, GA2 = {stiffness:?}, EI3 = {stiffness:?} }} }}\n\
             members.soft = {{ nodes = [\"A\", \"M\"], section = \"soft\" }}\n\
             members.wire = {{ nodes = [\"M\", \"T\"], section = \"wire\" }}\n\
             supports.A = \"clamped\"\n[[steps]]\nname = \"pull\"\nforce.T = [1, 3]\n"
        )
    };
    for (stiffness, warned) in [(1e5, false), (1e13, true)] {
        let file = place.file("wire.toml", &network(stiffness));
        let output = solve(&file).arg("-o").arg(place.path("out")).output().unwrap();
        expect(&output, 0);
        let digits = results(&place.path("out"))["steps"][0]["digits"].clone();
        let force = digits["force"].as_f64().unwrap();
        assert!(digits["displacement"].as_f64().unwrap() > 10.0, "{digits}");
        assert_eq!(force < 6.0, warned, "{digits}");
        assert!(out(&output).contains(&format!("rounding leaves {} digits", force.floor())), "{}", out(&output));
        let message = err(&output);
        assert_eq!(message.contains("warning: rounding leaves about"), warned, "{message}");
        for words in ["digits of the forces", "step 'pull'", "most at node", "help: look at the units"] {
            assert_eq!(message.contains(words), warned, "{words} in\n{message}");
        }
    }
}

#[test]
fn a_broken_pipe_is_neither_panic_nor_message() {
    let place = Workplace::new();
    for arguments in [&["--json"][..], &[]] {
        let mut child =
            solve(&place.dyad()).args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let mut message = String::new();
        child.stderr.take().unwrap().read_to_string(&mut message).unwrap();
        assert_eq!(message, "");
        assert_eq!(child.wait().unwrap().code(), Some(0));
    }
}

#[test]
fn a_directory_that_cannot_be_written_is_named() {
    let place = Workplace::new();
    let taken = place.file("taken", "");
    for directory in [taken.clone(), taken.join("below")] {
        let output = solve(&place.dyad()).arg("-o").arg(&directory).output().unwrap();
        expect(&output, 1);
        assert!(err(&output).starts_with("error: cannot write"), "{}", err(&output));
        assert!(err(&output).contains("taken"), "{}", err(&output));
    }
}

/// Writing to /dev/full fails as a full disk does.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_with_words() {
    let place = Workplace::new();
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = solve(&place.dyad()).arg("--json").stdout(full).output().unwrap();
    expect(&output, 1);
    assert!(err(&output).contains("cannot write standard output: no space left on device"), "{}", err(&output));
}

#[test]
fn names_of_any_kind_survive_in_every_output() {
    let place = Workplace::new();
    let (node, probe, step) = ("J \"\\n<ä> & 'q'\\t,", "str,\\\"oke\\n∂", "in; \\\"flate\\n");
    let node_toml = node.replace('"', "\\\"");
    let text = format!("{DYAD}{MUSCLE}")
        .replace("J = [0, 0]", &format!("\"{node_toml}\" = [0, 0]"))
        .replace("\"J\"", &format!("\"{node_toml}\""))
        .replace("J = { uy", &format!("\"{node_toml}\" = {{ uy"))
        .replace("stroke =", &format!("\"{probe}\" ="))
        .replace("\"inflate\"", &format!("\"{step}\""));
    let file = place.file("na \"me & <ä>.toml", &text);
    let output = solve(&file).arg("-o").arg(place.path("out")).arg("--vtk").output().unwrap();
    expect(&output, 0);
    let results = results(&place.path("out"));
    assert_eq!(results["steps"][0]["name"], "in; \"flate\n");
    assert!(results["steps"][0]["nodes"]["J \"\n<ä> & 'q'\t,"].is_object());
    assert!(results["steps"][0]["probes"]["str,\"oke\n∂"].is_number());
    let mut history = csv::Reader::from_path(place.path("out/history.csv")).unwrap();
    assert_eq!(
        history.headers().unwrap(),
        vec!["step", "fraction", "pressure all (psi)", "str,\"oke\n∂ (mm)", "holding (N)"]
    );
    assert_eq!(&history.records().next().unwrap().unwrap()[0], "in; \"flate\n");
    let collection = fs::read_to_string(place.path("out/na \"me & <ä>.pvd")).unwrap();
    assert!(collection.contains("file=\"na &quot;me &amp; &lt;ä&gt;_0001.vtu\""), "{collection}");
    assert_eq!(out(&output).lines().filter(|line| line.contains("str,\"oke\\n∂")).count(), 1);
}

/// A second run under the same name leaves no picture of the first, and nothing that is not pennate's goes.
#[test]
fn pictures_of_an_earlier_run_go() {
    let place = Workplace::new();
    let (file, directory) = (place.dyad(), place.path("out"));
    let pictures = || {
        let names = fs::read_dir(&directory).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.filter(|name| name.ends_with(".vtu")).collect();
        names.sort();
        names
    };
    let text = fs::read_to_string(&file)
        .unwrap()
        .replace("pressure = { all = 25 }", "pressure = { all = 25 }\nincrements = 5");
    fs::write(&file, text).unwrap();
    let run = |vtk: &[&str]| expect(&solve(&file).arg("-o").arg(&directory).args(vtk).output().unwrap(), 0);
    run(&["--vtk"]);
    assert!(pictures().len() >= 7, "{:?}", pictures());
    fs::write(directory.join("dyad_0099.vtu"), "mine").unwrap();
    run(&["--vtk", "ends"]);
    assert_eq!(pictures(), ["dyad_0000.vtu", "dyad_0001.vtu", "dyad_0002.vtu", "dyad_0099.vtu"]);
    run(&["--vtk", "every=3"]);
    assert_eq!(pictures().len(), 5, "{:?}", pictures());
    run(&[]);
    assert_eq!(pictures(), ["dyad_0099.vtu"]);
    assert!(!directory.join("dyad.pvd").exists());
    let output = solve(&file).arg("-o").arg(&directory).args(["--vtk=often"]).output().unwrap();
    expect(&output, 2);
    assert!(err(&output).contains("every=N, ends or all"), "{}", err(&output));
}

/// Whose results they are can be told from them.
#[test]
fn results_name_what_they_come_from() {
    let place = Workplace::new();
    let directory = place.path("out");
    let output = solve(&place.dyad()).arg("-o").arg(&directory).args(["--set", "beta=30 deg"]).output().unwrap();
    expect(&output, 0);
    let input = &results(&directory)["input"];
    assert_eq!(input["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(input["set"]["beta"], "30 deg");
    assert!((input["parameters"]["beta"].as_f64().unwrap() - 30.0).abs() < 1e-12 && input["parameters"]["L"] == 130.0);
    assert_eq!(input["files"][0]["name"], "dyad.toml");
    let hash = input["files"][0]["sha256"].as_str().unwrap().to_owned();
    assert!(hash.len() == 64 && hash.bytes().all(|byte| byte.is_ascii_hexdigit()));
    fs::write(place.path("dyad.toml"), format!("{DYAD}{MUSCLE}# edited\n")).unwrap();
    expect(&solve(&place.path("dyad.toml")).arg("-o").arg(&directory).output().unwrap(), 0);
    assert_ne!(results(&directory)["input"]["files"][0]["sha256"], hash.as_str());
}

/// A lattice of ten thousand bars under many increments is given up within a second.
#[cfg(unix)]
#[test]
fn an_interrupt_ends_a_large_solve_within_a_second() {
    let place = Workplace::new();
    let cell = "[nodes]\nA = [0, 0, 0]\nB = [10, 0, 0]\nC = [0, 10, 0]\nD = [0, 0, 10]\n[materials]\nm = { youngs_modulus = 2000, \
                poissons_ratio = 0.3 }\n[sections]\ns = { circle = { radius = 0.5 } }\n[members]\nx = { nodes = [\"A\", \"B\"], section = \
                \"s\", material = \"m\" }\ny = { nodes = [\"A\", \"C\"], section = \"s\", material = \"m\" }\nz = { nodes = [\"A\", \"D\"], \
                section = \"s\", material = \"m\" }\n[supports]\nA = \"clamped\"\n[[patterns]]\ncount = 15\ntranslation = [10, 0, \
                0]\n[[patterns]]\ncount = 15\ntranslation = [0, 10, 0]\n[[patterns]]\ncount = 15\ntranslation = [0, 0, 10]\n[[steps]]\n\
                gravity = [0, 0, -1e9]\nincrements = 1000\n";
    let cell = cell.replace("poissons_ratio = 0.3", "poissons_ratio = 0.3, density = 1e-9");
    let file = place.file("lattice.toml", &format!("format = \"pennate/1\"\n{cell}"));
    let mut child = solve(&file).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(1500));
    assert!(child.try_wait().unwrap().is_none(), "the run is over before it could be interrupted");
    let start = std::time::Instant::now();
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    // A second, and what a busy machine takes to get round to it.
    assert!(start.elapsed().as_secs_f64() < 2.0, "{:?}", start.elapsed());
}

/// Interrupted while its many increments are under way, a run keeps what it has.
#[cfg(unix)]
#[test]
fn an_interrupt_keeps_what_had_converged() {
    let place = Workplace::new();
    let text =
        format!("{DYAD}{MUSCLE}").replace("pressure = { all = 25 }", "pressure = { all = 25 }\nincrements = 1000000");
    let file = place.file("dyad.toml", &text);
    let mut child =
        solve(&file).arg("-o").arg(place.path("out")).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(700));
    assert!(child.try_wait().unwrap().is_none(), "the run is over before it could be interrupted");
    let interrupt = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(interrupt.success());
    let mut message = String::new();
    child.stderr.take().unwrap().read_to_string(&mut message).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{message}");
    let results = results(&place.path("out"));
    assert_eq!(results["status"], "interrupted");
    assert!(results["steps"][0]["fraction"].as_f64().unwrap() > 0.0);
    assert!(message.contains("interrupted"), "{message}");
}
