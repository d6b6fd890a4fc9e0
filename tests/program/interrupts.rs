//! Runs that are interrupted.

use std::io::Read;
use std::process::{Command, Stdio};

use crate::workplace::{DYAD, MUSCLE, Workplace, results, solve};

/// A lattice of ten thousand bars under many increments is given up at once.
#[cfg(unix)]
#[test]
fn an_interrupt_ends_a_large_solve_at_once() {
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
    // A second, and what a busy machine takes to get round to it; the whole solve would take many minutes.
    assert!(start.elapsed().as_secs_f64() < 5.0, "{:?}", start.elapsed());
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
