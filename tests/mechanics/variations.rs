//! Eighty slips of a user, of magnitude, unit, name, sign and type: nearly all are refused or warned about.

use pennate::{explain, strains};
use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_models::read_text;
use pennate_solver::options::Options;

const GOOD: &str = r#"format = "pennate/1"
title = "two muscles lift a forearm"
[parameters]
L = 130
beta = "22 deg"
p = "20 psi"
r = "3 mm"
load = "0.2 N"
[nodes]
A = ["= -L * cos(beta)", "= -L * sin(beta)"]
B = ["= L * cos(beta)", "= -L * sin(beta)"]
J = [0, 0]
T = [0, 60]
[materials]
abs = { youngs_modulus = 2200, poissons_ratio = 0.3, density = 1.04e-9 }
[sections]
arm = { rectangle = { width = 10, height = 6 } }
rod = { circle = { radius = "= r" } }
[muscles.silicone]
diameter = 13
wall = 2.0
pressure_unit = "psi"
density = 1.1e-9
table = [
  { pressure = 10, E = 3.60, alpha = -9.135e-3, R1 = 6.80, R2 = 7.90 },
  { pressure = 25, E = 4.25, alpha = -6.885e-3, R1 = 7.15, R2 = 8.90 },
]
[members]
left = { nodes = ["A", "J"], muscle = "silicone", group = "pair" }
right = { nodes = ["B", "J"], muscle = "silicone", group = "pair" }
forearm = { nodes = ["J", "T"], section = "arm", material = "abs" }
[supports]
A = "clamped"
B = "clamped"
[[steps]]
name = "inflate"
pressure = { pair = "= p" }
gravity = [0, -9810, 0]
[[steps]]
name = "load"
force = { T = ["= load", 0] }
[probes]
stroke = { node = "J", displacement = "uy" }
bent = { member = "forearm", stress = "max" }
"#;

/// What is replaced by what. The number of the case is its place.
const SLIPS: &[(&str, &str)] = &[
    // Magnitudes.
    ("width = 10, height = 6", "width = 0.01, height = 0.006"),
    ("r = \"3 mm\"", "r = \"3 m\""),
    ("youngs_modulus = 2200", "youngs_modulus = 2.2e9"),
    ("youngs_modulus = 2200", "youngs_modulus = 0.0000022"),
    ("density = 1.04e-9", "density = 1040"),
    ("density = 1.04e-9", "density = 1.04"),
    ("gravity = [0, -9810, 0]", "gravity = [0, -9.81, 0]"),
    ("gravity = [0, -9810, 0]", "gravity = [0, -9810000, 0]"),
    ("load = \"0.2 N\"", "load = \"200 N\""),
    ("load = \"0.2 N\"", "load = \"200 kN\""),
    ("L = 130", "L = 0.13"),
    ("L = 130", "L = 1.3"),
    ("diameter = 13", "diameter = 0.013"),
    ("wall = 2.0", "wall = 20"),
    ("pressure = 25, E = 4.25", "pressure = 25, E = 4.25e6"),
    ("pressure = 25, E = 4.25", "pressure = 2.5, E = 4.25"),
    ("p = \"20 psi\"", "p = \"200 psi\""),
    ("p = \"20 psi\"", "p = \"20 MPa\""),
    ("alpha = -6.885e-3", "alpha = -6.885"),
    ("R1 = 7.15", "R1 = 14.3"),
    ("R2 = 8.90", "R2 = 0.00890"),
    ("T = [0, 60]", "T = [0, 0.06]"),
    ("T = [0, 60]", "T = [0, 6e6]"),
    // Units.
    ("r = \"3 mm\"", "r = \"3 N\""),
    ("p = \"20 psi\"", "p = \"20 deg\""),
    ("pair = \"= p\"", "pair = \"= p + 5\""),
    ("pair = \"= p\"", "pair = \"20 Nm\""),
    ("\"= load\", 0", "\"= beta\", 0"),
    ("\"= load\", 0", "\"2 mm\", 0"),
    ("\"= load\", 0", "\"= load + r\", 0"),
    ("beta = \"22 deg\"", "beta = \"22 mm\""),
    ("beta = \"22 deg\"", "beta = \"22 degr\""),
    ("pressure_unit = \"psi\"", "pressure_unit = \"mm\""),
    ("pressure_unit = \"psi\"\n", ""),
    ("pressure_unit = \"psi\"", "pressure_unit = \"PSI\""),
    ("width = 10", "width = \"10 N\""),
    ("width = 10", "width = \"= p\""),
    ("width = 10", "width = \"= 2 * p\""),
    ("youngs_modulus = 2200", "youngs_modulus = \"2200\""),
    ("youngs_modulus = 2200", "youngs_modulus = \"2.2 GPA\""),
    ("youngs_modulus = 2200", "youngs_modulus = \"2.2 kg\""),
    ("alpha = -6.885e-3", "alpha = \"-6.885e-3 psi\""),
    ("format = \"pennate/1\"", "format = \"pennate/1\"\nunits = \"m-N-Pa\""),
    ("format = \"pennate/1\"", "format = \"pennate/1\"\nunits = \"mm-N\""),
    // Names.
    ("nodes = [\"A\", \"J\"]", "nodes = [\"A\", \"K\"]"),
    ("muscle = \"silicone\", group = \"pair\" }\nright", "muscle = \"silicon\", group = \"pair\" }\nright"),
    ("section = \"arm\"", "section = \"Arm\""),
    ("material = \"abs\"", "material = \"ABS\""),
    ("material = \"abs\"", "materiel = \"abs\""),
    (", material = \"abs\"", ""),
    ("pressure = { pair", "pressure = { pairs"),
    ("pressure = { pair", "pressure = { forearm"),
    ("force = { T", "force = { t"),
    ("member = \"forearm\"", "member = \"arm\""),
    ("youngs_modulus", "young_modulus"),
    ("poissons_ratio", "poisson"),
    ("\"= load\", 0", "\"= laod\", 0"),
    ("displacement = \"uy\"", "displacement = \"y\""),
    ("[supports]", "[support]"),
    ("stress = \"max\"", "stress = \"maximum\""),
    ("name = \"load\"", "name = \"inflate\""),
    ("group = \"pair\" }\nright", "group = \"right\" }\nright"),
    // Signs.
    ("width = 10", "width = -10"),
    ("poissons_ratio = 0.3", "poissons_ratio = -3"),
    ("poissons_ratio = 0.3", "poissons_ratio = 0.6"),
    ("alpha = -6.885e-3", "alpha = 6.885e-3"),
    ("p = \"20 psi\"", "p = \"-20 psi\""),
    ("density = 1.1e-9", "density = -1.1e-9"),
    ("E = 3.60", "E = -3.60"),
    ("beta = \"22 deg\"", "beta = \"180 deg\""),
    // Types and forms.
    ("[[steps]]\nname = \"inflate\"", "[steps]\nname = \"inflate\""),
    ("J = [0, 0]", "J = 0"),
    ("J = [0, 0]", "J = [0]"),
    ("J = [0, 0]", "J = [0, 0, 0, 0]"),
    ("A = \"clamped\"", "A = true"),
    ("A = \"clamped\"\n", ""),
    ("A = \"clamped\"\nB = \"clamped\"", "J = \"pinned\""),
    ("nodes = [\"A\", \"J\"]", "nodes = \"AJ\""),
    ("section = \"arm\"", "section = \"arm\", elements = 2.5"),
    ("section = \"arm\"", "section = \"arm\", muscle = \"silicone\""),
    ("force = { T = [\"= load\", 0] }", "force = { T = \"= load\" }"),
    ("stress = \"max\"", "stress = true"),
    ("L = 130", "L = \"130\""),
    ("T = [0, 60]", "T = [0, 0]"),
];

/// What a user is told; nothing where a slip goes unnoticed.
fn told(text: &str) -> Option<String> {
    let model = match read_text("net.toml", text, &[]) {
        Ok(model) => model,
        Err(errors) => {
            let first = &errors.errors[0];
            assert!(first.help.is_some(), "no cure: {errors}");
            return Some(first.message.clone());
        }
    };
    if let Some(warning) = model.warnings.first() {
        assert!(warning.help.is_some(), "no cure: {warning:?}");
        return Some(warning.message.clone());
    }
    let options = Options { estimate: true, near_motion: true, ..Options::default() };
    let solution = match solve_to_accuracy(model, 1e-4, &options, &mut |_| true) {
        Ok(solution) => solution,
        Err((model, pennate_solver::error::SolveError::Mechanism(motions))) => {
            return Some(explain::mechanism(&model, &motions[0]).title);
        }
    };
    let mut failed = explain::failed_steps(&solution.model, &solution.history.steps);
    let warned = strains::warnings(&solution).into_iter().next();
    let message = failed.next().or(warned)?;
    assert!(message.help.is_some() && message.span.is_some(), "no place or cure: {message:?}");
    Some(message.title)
}

#[test]
fn nearly_every_slip_is_noticed() {
    assert_eq!(told(GOOD), None);
    assert!(SLIPS.len() >= 80);
    let unnoticed: Vec<String> = SLIPS
        .iter()
        .filter_map(|(old, new)| {
            let text = GOOD.replacen(old, new, 1);
            assert_ne!(text, GOOD, "{old}");
            let told = told(&text);
            println!("{new:?}: {}", told.as_deref().unwrap_or("NOTHING"));
            told.is_none().then(|| format!("{old} -> {new}"))
        })
        .collect();
    assert!(20 * unnoticed.len() <= SLIPS.len(), "{} of {}: {unnoticed:#?}", unnoticed.len(), SLIPS.len());
}
