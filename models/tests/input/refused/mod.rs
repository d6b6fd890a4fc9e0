//! Files that are wrong: what is said, where, and what would help.

mod geometry;
mod names;
mod numbers;
mod steps;

use pennate_models::{InputErrors, read_text};

/// A network that is right; the cases below replace one line of it.
const GOOD: &str = r#"format = "pennate/1"
[parameters]
L = 130
[nodes]
A = [0, 0]
B = ["= L", 0]
C = ["= L", 50]
[materials]
abs = { youngs_modulus = 2200, poissons_ratio = 0.3 }
[sections]
strut = { circle = { radius = 1.5 } }
tube = { annulus = { outer_radius = 6, wall = 2 } }
[muscles.silicone]
diameter = 13
wall = 2.0
pressure_unit = "psi"
table = [
  { pressure = 10, E = 3.60, alpha = -9.135e-3, R1 = 6.80, R2 = 7.90 },
  { pressure = 25, E = 4.25, alpha = -6.885e-3, R1 = 7.15, R2 = 8.90 },
]
[members]
left = { nodes = ["A", "B"], muscle = "silicone", group = "pair" }
bar = { nodes = ["B", "C"], section = "strut", material = "abs" }
[supports]
A = "clamped"
[[steps]]
name = "inflate"
pressure = { left = 25 }
[probes]
x = { node = "B", displacement = "ux" }
"#;

fn errors(old: &str, new: &str) -> InputErrors {
    let text = GOOD.replace(old, new);
    assert_ne!(text, GOOD, "{old}");
    match read_text("net.toml", &text, &[]) {
        Ok(_) => panic!("accepted: {new}"),
        Err(errors) => errors,
    }
}

/// The first error for a replacement: its message, line, column, and help.
#[track_caller]
fn case(old: &str, new: &str, message: &str, line: usize, column: usize, help: &str) {
    let errors = errors(old, new);
    let first = &errors.errors[0];
    assert!(first.message.contains(message), "message: {errors}");
    assert_eq!(
        errors.place(first).map(|(file, line, column)| (file.to_owned(), line, column)),
        Some(("net.toml".into(), line, column)),
        "{errors}"
    );
    assert!(first.help.as_deref().is_some_and(|text| text.contains(help)), "help: {errors}");
}

#[test]
fn the_network_of_these_tests_is_right() {
    let model = read_text("net.toml", GOOD, &[]).unwrap();
    assert!(model.warnings.is_empty());
}

#[test]
fn several_errors_come_at_once() {
    let text = GOOD.replace("section = \"strut\"", "section = \"strat\"").replace("{ left = 25 }", "{ left = 99 }");
    let errors = read_text("net.toml", &text, &[]).unwrap_err();
    assert_eq!(errors.errors.len(), 2, "{errors}");
}

/// What is wrong with a section is not said once more by the node of its member, which has no rotation without it.
#[test]
fn an_error_brings_no_others_with_it() {
    let turned = GOOD.replace("pressure = { left = 25 }", "rotation = { C = { rz = 5 } }");
    read_text("net.toml", &turned, &[]).unwrap();
    let errors = read_text("net.toml", &turned.replace("radius = 1.5", "radius = -1.5"), &[]).unwrap_err();
    assert_eq!(errors.errors.len(), 1, "{errors}");
}
