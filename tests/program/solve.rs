//! What a solve prints and writes, and what other commands say of a network.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::Stdio;

use serde_json::Value;

use crate::workplace::{DYAD, MUSCLE, TOGGLE, Workplace, err, expect, out, pennate, results, solve};

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

/// A path that ends where a member that cannot be stretched is straight turns back nowhere, and nothing would snap.
#[test]
fn a_member_that_is_pulled_straight_is_named() {
    let place = Workplace::new();
    let file = place.file(
        "taut.toml",
        "format = \"pennate/1\"\nnodes = { A = [0, 0], B = [60, 60] }\n\
         sections.tape = { stiffness = { EA = 1, EI3 = 1e4 }, stretch = false }\n\
         members.tape = { nodes = [\"A\", \"B\"], section = \"tape\" }\n\
         supports.A = \"clamped\"\n[[steps]]\nname = \"pull\"\ndisplacement.B = { ux = 60 }\n",
    );
    let output = solve(&file).output().unwrap();
    expect(&output, 1);
    for word in ["step 'pull'", "member 'tape' cannot be stretched and is pulled straight", "stretch = false"] {
        assert!(err(&output).contains(word), "{word} in\n{}", err(&output));
    }
    assert!(!err(&output).contains("snap"), "{}", err(&output));
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

/// A shallow toggle, pulled down by a spring that is too short for its place.
const PULLED: &str = r#"
format = "pennate/1"
dimension = "plane"
nodes = { A = [-50, 0], C = [0, 5], B = [50, 0], D = [0, -50] }
members.l = { nodes = ["A", "C"], section = "a" }
members.r = { nodes = ["C", "B"], section = "a" }
sections.a.stiffness = { EA = 100, EI3 = 80 }
springs.s = { nodes = ["C", "D"], stiffness = 0.01, natural_length = 10 }
steps = [{ name = "push", force = { C = [0, -1e-3] } }]
"#;

#[test]
fn what_a_network_meets_on_the_way_into_its_prestress_is_told_from_its_first_step() {
    let place = Workplace::new();
    let held =
        format!("{PULLED}supports = {{ A = \"pinned\", B = \"pinned\", C = [\"ux\", \"rz\"], D = \"pinned\" }}\n");
    let file = place.file("held.toml", &held);
    let output = solve(&file).arg("--json").output().unwrap();
    expect(&output, 1);
    for words in ["the prestress before step 'push' ends at a limit point", "no load of the step acts yet"] {
        assert!(err(&output).contains(words), "{words} in\n{}", err(&output));
    }
    assert!(!err(&output).contains("reached: force"), "{}", err(&output));
    let step = &serde_json::from_slice::<Value>(&output.stdout).unwrap()["steps"][0];
    assert_eq!(step["fraction"], 0.0);
    let part = step["prestress"].as_f64().unwrap();
    assert!(part > 0.0 && part < 1.0, "{part}");
    assert_eq!(step["critical_points"][0]["prestress"], true);

    // Slender ones buckle on the way.
    let free = format!("{PULLED}supports = {{ A = \"pinned\", B = \"pinned\", D = \"pinned\" }}\n")
        .replace("EI3 = 80", "EI3 = 1");
    let output = solve(&place.file("free.toml", &free)).arg("--json").output().unwrap();
    expect(&output, 0);
    let step = &serde_json::from_slice::<Value>(&output.stdout).unwrap()["steps"][0];
    assert!(step.get("prestress").is_none());
    let points = step["critical_points"].as_array().unwrap();
    assert!(!points.is_empty() && points.iter().all(|point| point["prestress"] == true), "{points:?}");
}
