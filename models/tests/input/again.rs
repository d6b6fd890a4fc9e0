//! Networks that are read once, and evaluated again for other values of their parameters.

use pennate_models::scenes::SCENES;
use pennate_models::{Document, Model};

/// What parameters are multiplied by; some of it makes no network.
const TIMES: [f64; 4] = [1.01, 0.97, 1.3, 0.5];

/// A network written so that every kind of part follows a parameter.
const ALL: &str = r#"
    format = "pennate/1"
    title = "all"
    parameters = { a = 100, b = "= a / 2", r = 2, E = 5, k = 3, m = 1e-6, p = 8, F = 2, turn = 20, low = "= b - 10" }
    nodes = { A = [0, 0], B = ["= a", 0], C = ["= a", "= b"], D = [0, "= b"], G = [0, -30], H = [30, -30] }
    materials.soft = { youngs_modulus = "= E", poissons_ratio = 0.4, density = 1e-9 }
    sections.tube = { annulus = { outer_radius = "= r", wall = 1 } }
    sections.wire = { stiffness = { EA = "= 100 * E", EI3 = 400 } }
    muscles.made = { diameter = 13, wall = 2, pressure_unit = "psi", table = [
        { pressure = 10, E = "= E", alpha = -9e-3, R1 = 6.8, R2 = 7.9 },
        { pressure = 20, E = 4, alpha = -8e-3, R1 = 7, R2 = "= 6.7 + r" },
    ] }
    members.ab = { nodes = ["A", "B"], section = "tube", material = "soft" }
    members.bc = { nodes = ["B", "C"], section = "wire", release = { end = { hinge = [0, 0, 1] } } }
    members.dc = { nodes = ["D", "C"], muscle = "made", group = "pulls" }
    members.gh = { nodes = ["G", "H"], segments = [
        { length = 10, section = "wire" },
        { length = 20, section = "wire", strain = "= 0.01 * k", curvature = [0, 0, 0.001] },
    ] }
    rigid_bodies.plate = { nodes = ["B", "H"], reference = "B", mass = "= m" }
    supports = { A = "clamped", D = "pinned", G = { fix = ["ux", "uy", "rz"], x_axis = ["= cos(turn)", "= sin(turn)"] } }
    springs.s = { node = "C", stiffness = { ux = "= k" } }
    springs.t = { nodes = ["A", "C"], stiffness = 0.1 }
    [[steps]]
    name = "inflate"
    pressure = { pulls = "= p" }
    gravity = [0, -9810]
    [[steps]]
    force = { C = ["= F", 0] }
    actuation = { gh = "= k" }
    displacement = { D = { ux = "= F / 10" } }
    [probes]
    far = { nodes = ["A", "C"], distance = true }
    at = { node = "C", position = "y" }
    most = { member = "ab", stress = "max" }
    sum = "= far + at@inflate + low"
"#;

/// Every number of a network is what it is where everything is evaluated, and what is wrong is said alike.
#[test]
fn numbers_that_are_evaluated_again_are_those_of_a_network_with_these_parameters() {
    let all = Document::from_text("all.toml", ALL);
    let mut compared = compare(&all, true);
    for scene in SCENES {
        let Ok(text) = scene.write(&[]) else { continue };
        compared += compare(&Document::from_text("scene.toml", &text), false);
    }
    assert!(compared > 300, "{compared}");
}

/// How many networks with values of their own there were.
fn compare(document: &Document, strict: bool) -> usize {
    let (reading, first) = document.reading(&[]).unwrap();
    let mut compared = 0;
    for (place, (name, value)) in first.parameters.iter().enumerate() {
        for times in TIMES {
            let other = value * times;
            let settings = [(name.clone(), other.to_string())];
            match (reading.model(&[(place, other)]), document.model(&settings)) {
                (Ok(again), Ok(whole)) => {
                    let whole = Model { warnings: Vec::new(), sources: Vec::new(), settings: Vec::new(), ..whole };
                    assert_eq!(format!("{again:?}"), format!("{whole:?}"), "{} {name} {other}", first.title);
                    let set = reading.set(&settings).map(|set| Model { settings: Vec::new(), ..set });
                    assert!(set.is_some() || !strict, "{name} {other}: numbers alone serve");
                    assert!(set.is_none_or(|set| format!("{set:?}") == format!("{again:?}")), "{name} {other}");
                    compared += 1;
                }
                (Err(again), Err(whole)) => assert_eq!(again.errors.len(), whole.errors.len(), "{name} {other}"),
                (again, whole) => {
                    let units = first.parameters.iter().any(|(known, _)| known == name) && !strict;
                    // A parameter with a unit keeps it here, and loses it where it is set.
                    assert!(units, "{} {name} {other}: {} {}", first.title, again.is_ok(), whole.is_ok());
                }
            }
        }
    }
    compared
}
