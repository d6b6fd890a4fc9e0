//! Results do not depend on how many threads found them, to the last bit.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// The results of the command line, without the times.
fn results(network: &str, threads: &str) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_pennate"))
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")))
        .args(["solve", network, "--accuracy", "1e-4", "--threads", threads, "--json"])
        .output()
        .expect("pennate can be started");
    let mut results: Value = serde_json::from_slice(&output.stdout).expect("results");
    let timing = results.as_object_mut().and_then(|results| results.remove("timing"));
    assert!(timing.is_some(), "times are kept apart from results");
    results
}

fn same_bytes(network: &str) {
    // Compared as text, so that every digit counts.
    let text = |threads: &str| format!("{}", results(network, threads));
    let one = text("1");
    assert!(one == text("2"), "{network}: two threads give other digits than one");
    assert!(one == text("1"), "{network}: a second run gives other digits than the first");
}

#[test]
fn in_space() {
    same_bytes("validation/peers/p6_4.toml");
}

#[test]
fn in_the_plane() {
    same_bytes("models/networks/dyad.toml");
}
