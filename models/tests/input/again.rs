//! Networks that are read once, and evaluated again for other values of their parameters.

use pennate_models::parameter::Parameter;
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

/// A network whose parameters have units, one of them an inch, in a file of millimetres.
const MEASURED: &str = r#"
    format = "pennate/1"
    parameters = { L = "2 in", half = "= L / 2", turn = "0.5 rad", p = "100 kPa", more = "= 1.2 * p", F = "1 lbf", A = "= 0.2 * L^2",
                   pushed = "= F / A", m = "12 g", bare = 8, E = "= 3 * E0", E0 = "1.2 MPa" }
    nodes = { A = [0, 0], B = ["= L", 0], C = ["= half", "= L"], D = ["= 4 * L", 0], E = ["= 5 * L", 0] }
    muscles.made = { diameter = 13, wall = 2, pressure_unit = "psi", table = [
        { pressure = 10, E = "= E", alpha = -9e-3, R1 = 6.8, R2 = 7.9 },
        { pressure = 30, E = 4, alpha = -8e-3, R1 = 7, R2 = 8.7 },
    ] }
    members.ab = { nodes = ["A", "B"], muscle = "made" }
    members.bc = { nodes = ["C", "B"], muscle = "made" }
    members.ca = { nodes = ["C", "A"], muscle = "made" }
    members.de = { nodes = ["D", "E"], muscle = "made" }
    rigid_bodies.plate = { nodes = ["C"], mass = "= m" }
    supports = { A = "clamped", B = { fix = ["ux", "uy"], x_axis = ["= cos(turn)", "= sin(turn)"] }, D = "clamped" }
    [[steps]]
    name = "inflate"
    pressure = { ab = "= p", bc = "= more", ca = "= pushed", de = "= bare" }
    gravity = [0, -9810]
    force = { C = ["= F", 0] }
"#;

/// A number for a parameter means the same wherever it is set: it is in the unit that the parameter is written with, an expression
/// in that of the first parameter which measures the same.
#[test]
fn numbers_are_in_the_unit_of_their_parameter() {
    let document = Document::from_text("measured.toml", MEASURED);
    let (_, first) = document.reading(&[]).unwrap();
    let unit = |of: &Parameter| of.unit.as_ref().map_or(String::new(), |unit| unit.name.to_string());
    let stated: Vec<(&str, f64, String)> =
        first.parameters.iter().map(|each| (each.name.as_str(), each.value, unit(each))).collect();
    let known =
        |name: &str| stated.iter().find(|(known, ..)| *known == name).map(|(_, value, unit)| (*value, unit.as_str()));
    assert_eq!(known("L"), Some((2.0, "in")));
    assert_eq!(known("half"), Some((1.0, "in")));
    assert_eq!(known("turn"), Some((0.5, "rad")));
    assert_eq!(known("p"), Some((100.0, "kPa")));
    assert_eq!(known("bare"), Some((8.0, "")));
    assert_eq!(known("m"), Some((12.0, "g")));
    let near = |name: &str, value: f64, unit: &str| {
        let (found, of) = known(name).unwrap();
        assert!((found - value).abs() < 1e-12 * value && of == unit, "{name}: {found} {of}");
    };
    near("more", 120.0, "kPa");
    // What nothing in the expression measures is in the unit of the file: 4.448 N on 516 mm².
    near("pushed", 4.448_221_615_260_5 / (0.2 * 50.8 * 50.8), "MPa");
    near("E", 3.6, "MPa");
    near("A", 0.2 * 50.8 * 50.8, "mm^2");
    // The same by number, by text, and evaluated again.
    assert!(compare(&document, true) > 30);
    for (name, value, unit) in &stated {
        let by = |text: String| document.model(&[((*name).to_owned(), text)]).unwrap();
        let numbers = |model: Model| format!("{:?} {:?} {:?}", model.nodes, model.steps, model.bodies);
        let (number, text) = (format!("{:e}", 1.01 * value), format!("{:e} {unit}", 1.01 * value));
        assert_eq!(numbers(by(number)), numbers(by(text)), "{name}");
        // What a network says of itself is what it is.
        assert_eq!(numbers(by(format!("{value:e}"))), numbers(first.clone()), "{name}");
    }
    // A text with another unit is converted; that of a bare parameter is the file's from then on.
    for (name, text, value, of) in
        [("p", "20 psi", 20.0 * 6.894_757_293_168_36, "kPa"), ("bare", "80 kPa", 0.08, "MPa")]
    {
        let (reading, set) = document.reading(&[(name.to_owned(), text.to_owned())]).unwrap();
        let place = reading.parameter(name).unwrap();
        let found = &set.parameters[place];
        assert!((found.value - value).abs() < 1e-12 * value && unit(found) == of, "{found:?}");
        let [by_number, by_text] =
            [reading.model(&[(place, found.value)]), document.model(&[(name.to_owned(), text.to_owned())])];
        let drives = |model: Model| model.steps[0].targets.iter().map(|target| target.1).collect::<Vec<f64>>();
        for (a, b) in drives(by_number.unwrap()).into_iter().zip(drives(by_text.unwrap())) {
            assert!((a - b).abs() <= 1e-14 * a.abs(), "{name}: {a} {b}");
        }
    }
}

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
    for (place, Parameter { name, value, .. }) in first.parameters.iter().enumerate() {
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
                    panic!("{} {name} {other}: {} {}", first.title, again.is_ok(), whole.is_ok());
                }
            }
        }
    }
    compared
}
