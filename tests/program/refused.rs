//! Input that is refused: its place, its help, and its exit status.

use std::fs;

use crate::workplace::{DYAD, MUSCLE, Workplace, err, expect, out, pennate, solve};

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
