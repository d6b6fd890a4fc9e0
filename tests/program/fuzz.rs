//! A short run of the fuzz: files that are wrong, or strange, or both.

use std::path::Path;
use std::time::{Duration, Instant};

use pennate_testing::fuzz::corpus::Corpus;
use pennate_testing::fuzz::{mutate, trial};

#[test]
fn changed_networks_are_refused_or_checked() {
    let corpus = Corpus::read(Path::new(env!("CARGO_MANIFEST_DIR")));
    for seed in 0..1_000 {
        let case = mutate::case(&corpus, seed);
        trial::check(case.name, &case.bytes).unwrap_or_else(|wrong| panic!("seed {seed}: {wrong}"));
    }
}

/// Numbers of valid networks changed: what is called converged is in balance.
#[test]
fn varied_networks_are_solved_or_say_why_not() {
    let corpus = Corpus::read(Path::new(env!("CARGO_MANIFEST_DIR")));
    for seed in 0..20 {
        let case = mutate::varied(&corpus, seed);
        trial::solve(case.name, &case.bytes).unwrap_or_else(|wrong| panic!("seed {seed}: {wrong}"));
    }
}

/// Parts of a network, as many as a file may well have: looking at all for each would take minutes.
#[test]
fn large_networks_are_checked_in_proportion_to_their_size() {
    const HEAD: &str = "format = \"pennate/1\"\nsections.s = { stiffness = { EA = 1e4, GA2 = 4e3, EI3 = 100 } }\n";
    const MEMBER: &str =
        "nodes = { A = [0, 0], B = [10, 3] }\nmembers.m = { nodes = [\"A\", \"B\"], section = \"s\" }\n";
    let copies = |rest: &str| format!("{HEAD}{MEMBER}supports.A = \"clamped\"\n{rest}");
    let list = |count: usize, line: &dyn Fn(usize) -> String| -> String { (0..count).map(line).collect() };
    let lonely = list(20_000, &|i| format!("nodes.N{i} = [{i}, 50]\nsupports.N{i} = \"clamped\"\n"));
    let heap = list(20_000, &|i| format!("nodes.N{i} = [0, 50]\nsupports.N{i} = \"clamped\"\n"));
    let bars = list(20_000, &|i| {
        format!(
            "nodes.N{i} = [{i}, 50]\nnodes.M{i} = [{i}, 60]\nmembers.N{i} = {{ nodes = [\"N{i}\", \"M{i}\"], section = \"s\", group = \"g{i}\" }}\n"
        )
    });
    let pressed = list(20_000, &|i| format!("g{i} = [0, 1], ")) + "m = [0, 1]";
    let pins = list(20_000, &|i| format!("supports.N{i} = \"pinned\"\n"));
    for (what, text) in [
        ("a chain", copies("[[patterns]]\ncount = 20000\ntranslation = [10, 3]\n")),
        ("supports", copies("[[patterns]]\ncount = 20000\ntranslation = [20, 3]\nsupports = true\n")),
        ("a fan", copies("[[patterns]]\ncount = 20000\nrotation = { angle = 0.01 }\n")),
        (
            "bodies",
            copies("rigid_bodies.b = { nodes = [\"A\", \"B\"] }\n[[patterns]]\ncount = 20000\ntranslation = [10, 3]\n"),
        ),
        ("warnings", copies(&lonely)),
        ("nodes at one place", copies(&heap)),
        ("groups", copies(&format!("{bars}[[steps]]\ndistributed = {{ {pressed} }}\n"))),
        ("free motions", copies(&format!("{bars}{pins}"))),
    ] {
        let start = Instant::now();
        trial::check("large.toml", text.as_bytes()).unwrap();
        let time = start.elapsed();
        assert!(time < Duration::from_secs(30), "{what}: {time:.1?}");
    }
}

/// A few bytes never ask for a gigabyte.
#[test]
fn short_files_do_not_make_large_networks() {
    const HEAD: &str = "format = \"pennate/1\"\nsections.s = { stiffness = { EA = 1e4, GA2 = 4e3, EI3 = 100 } }\n\
        nodes = { A = [0, 0], B = [10, 3] }\nsupports.A = \"clamped\"\n";
    let bar = |rest: &str| format!("{HEAD}members.m = {{ nodes = [\"A\", \"B\"], section = \"s\"{rest} }}\n");
    let pattern = |count: &str| format!("[[patterns]]\ncount = {count}\ntranslation = [20, 3]\n");
    for (text, message) in [
        (bar("") + &pattern("1e9"), "a whole number from 1 to 1000000 is expected"),
        (bar("") + &pattern("1000000"), "a pattern makes more than 100000 nodes, members and other parts"),
        (bar("") + &pattern("1000").repeat(2), "a pattern makes more than 100000 nodes, members and other parts"),
        (bar(", elements = 1000000"), "the network asks for more than 200000 elements"),
        (bar(", elements = 3000") + &pattern("100"), "the network asks for more than 200000 elements"),
    ] {
        let errors = pennate_models::read_text("short.toml", &text, &[]).unwrap_err();
        assert!(errors.to_string().contains(message), "{errors}");
    }
}
