//! Random linkages, driven in one increment and again in many: who comes to the same place, alone and beside other designs.
//!
//! `cargo run --release --example linkages [-- COUNT [SEED]]` prints the table, for so many designs of each family. Linkages whose bars
//! come into one line have two ways on, which are stable both: what an increment leads to is the way that small ones lead to.
//! Designs that end elsewhere without a word are listed with their parameters.

use pennate_analysis::problem::{Problem, Reason};
use pennate_models::Document;
use rayon::prelude::*;

/// Increments of the run that the others are held against.
const SMALL: usize = 400;
/// Distance over the length of a bar within which two places are the same.
const SAME: f64 = 1e-6;
/// Estimated relative error that the mesh is made for.
const ACCURACY: f64 = 1e-4;

struct Family {
    name: &'static str,
    /// Values of the parameters of an ordinary design, by which the mesh is chosen, and random ones.
    parameters: &'static [(&'static str, f64)],
    network: &'static str,
    outputs: &'static [&'static str],
    draw: fn(&mut fastrand::Rng) -> Vec<f64>,
}

const FOUR_BARS: &str = r#"
[nodes]
A = [0, 0]
B = ["= xb", "= yb"]
C = ["= xc", "= yc"]
D = ["= xd", 0]
[members]
AB = { nodes = ["A", "B"] }
BC = { nodes = ["B", "C"], release = { start = "pin", end = "pin" } }
CD = { nodes = ["C", "D"], release = { end = "pin" } }
[supports]
A = "clamped"
D = "clamped"
[springs]
S = { node = "C", stiffness = { uy = "= k" } }
[[steps]]
rotation.A = [0, 0, "= turn"]
[probes]
x = { node = "C", displacement = "ux" }
y = { node = "C", displacement = "uy" }
"#;

const TOGGLES: &str = r#"
[nodes]
A = [0, 0]
B = [1, "= y1"]
C = ["= 2 + x2", 0]
D = ["= 3 + x2", "= y2"]
E = [4, 0]
[members]
AB = { nodes = ["A", "B"] }
BC = { nodes = ["B", "C"], release = { start = "pin" } }
CD = { nodes = ["C", "D"], release = { start = "pin", end = "pin" } }
DE = { nodes = ["D", "E"] }
[supports]
A = "pinned"
E = "pinned"
C = ["uy"]
[springs]
S = { node = "D", stiffness = { uy = "= k" } }
[[steps]]
displacement.B = { uy = "= -move * y1" }
[probes]
x = { node = "C", displacement = "ux" }
y = { node = "D", displacement = "uy" }
"#;

const SLIDER: &str = r#"
[nodes]
A = [0, 0]
B = ["= xb", "= yb"]
C = ["= xc", 0]
[members]
AB = { nodes = ["A", "B"] }
BC = { nodes = ["B", "C"], release = { start = "pin", end = "pin" } }
[supports]
A = "clamped"
C = ["uy", "rz"]
[springs]
S = { node = "C", stiffness = { ux = "= k" } }
[[steps]]
rotation.A = [0, 0, "= turn"]
[probes]
x = { node = "B", displacement = "uy" }
y = { node = "C", displacement = "ux" }
"#;

const SIX_BARS: &str = r#"
[nodes]
A = [0, 0]
B = ["= xb", "= yb"]
C = ["= xc", "= yc"]
D = ["= xd", 0]
E = ["= xe", "= ye"]
F = ["= xf", 0]
[members]
AB = { nodes = ["A", "B"] }
BC = { nodes = ["B", "C"], release = { start = "pin", end = "pin" } }
CD = { nodes = ["C", "D"], release = { end = "pin" } }
CE = { nodes = ["C", "E"], release = { start = "pin", end = "pin" } }
EF = { nodes = ["E", "F"], release = { end = "pin" } }
[supports]
A = "clamped"
D = "clamped"
F = "clamped"
[springs]
S = { node = "E", stiffness = { uy = "= k" } }
[[steps]]
rotation.A = [0, 0, "= turn"]
[probes]
x = { node = "C", displacement = "ux" }
y = { node = "E", displacement = "uy" }
"#;

const FORCED: &str = r#"
[nodes]
A = [0, 0]
B = ["= xb", "= yb"]
C = ["= xc", "= yc"]
D = ["= xd", 0]
[members]
AB = { nodes = ["A", "B"] }
BC = { nodes = ["B", "C"], release = { start = "pin", end = "pin" } }
CD = { nodes = ["C", "D"], release = { end = "pin" } }
[supports]
A = "pinned"
D = "clamped"
[springs]
S = { node = "C", stiffness = { ux = "= k", uy = "= k" } }
[[steps]]
force.B = ["= fx", "= fy"]
[probes]
x = { node = "C", displacement = "ux" }
y = { node = "C", displacement = "uy" }
"#;

/// A number between two others.
fn between(random: &mut fastrand::Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * random.f64()
}

/// A stiffness from a thousandth to a tenth (N/mm), even in its logarithm.
fn stiffness(random: &mut fastrand::Rng) -> f64 {
    10f64.powf(between(random, -3.0, -1.0))
}

/// Crank and coupler nearly in one line, as the ordinary design is; a turn leads past the line.
fn near_the_line(random: &mut fastrand::Rng) -> Vec<f64> {
    vec![
        between(random, -0.995, -0.985),
        between(random, 0.06, 0.14),
        between(random, 1.0, 1.01),
        between(random, -0.06, 0.12),
        2.0,
        between(random, 13.0, 14.0),
        stiffness(random),
    ]
}

fn of_any_proportion(random: &mut fastrand::Rng) -> Vec<f64> {
    vec![
        between(random, -1.0, 1.0),
        between(random, 0.0, 0.2),
        between(random, 0.3, 1.3),
        between(random, -0.2, 0.2),
        between(random, 1.4, 2.2),
        between(random, -25.0, 25.0),
        stiffness(random),
    ]
}

fn parallelogram(random: &mut fastrand::Rng) -> Vec<f64> {
    let angle = between(random, 0.05, 0.4);
    let near = 10f64.powf(between(random, -6.0, -2.0));
    let mut miss = || near * between(random, -1.0, 1.0);
    let [b, c] = [[angle.cos() + miss(), angle.sin() + miss()], [1.5 + angle.cos() + miss(), angle.sin() + miss()]];
    let turn = -angle.to_degrees() * between(random, 1.05, 3.0);
    vec![b[0], b[1], c[0], c[1], 1.5, turn, stiffness(random)]
}

fn two_toggles(random: &mut fastrand::Rng) -> Vec<f64> {
    vec![
        between(random, 0.03, 0.3),
        between(random, -0.1, 0.1),
        between(random, -0.3, 0.3),
        stiffness(random),
        between(random, 1.0, 2.5),
    ]
}

fn slider(random: &mut fastrand::Rng) -> Vec<f64> {
    let angle = between(random, -3.0, 3.0);
    let crank = between(random, 0.4, 1.0);
    let [x, y] = [crank * angle.cos(), crank * angle.sin()];
    let coupler = (crank * between(random, 0.9, 1.3)).max(1.02 * y.abs());
    vec![x, y, x + (coupler * coupler - y * y).sqrt(), between(random, -60.0, 60.0), stiffness(random)]
}

fn six_bars(random: &mut fastrand::Rng) -> Vec<f64> {
    let mut values = of_any_proportion(random);
    let (turn, k) = (values[5], values[6]);
    values.truncate(5);
    values.extend([between(random, 1.6, 2.6), between(random, -0.3, 0.3), between(random, 2.4, 3.4), turn, k]);
    values
}

fn forced(random: &mut fastrand::Rng) -> Vec<f64> {
    let mut values = of_any_proportion(random);
    let k = values[6];
    values.truncate(5);
    let size = k * between(random, 0.02, 0.5);
    let angle = between(random, -3.2, 3.2);
    values.extend([size * angle.cos(), size * angle.sin(), k]);
    values
}

const FOUR: &[(&str, f64)] =
    &[("xb", -0.99), ("yb", 0.1), ("xc", 1.005), ("yc", 0.03), ("xd", 2.0), ("turn", 13.5), ("k", 0.01)];

const FAMILIES: [Family; 7] = [
    Family {
        name: "four bars near their change point",
        parameters: FOUR,
        network: FOUR_BARS,
        outputs: &["x", "y"],
        draw: near_the_line,
    },
    Family {
        name: "four bars of any proportion",
        parameters: FOUR,
        network: FOUR_BARS,
        outputs: &["x", "y"],
        draw: of_any_proportion,
    },
    Family {
        name: "parallelograms through their line",
        parameters: &[("xb", 0.95), ("yb", 0.3), ("xc", 2.45), ("yc", 0.3), ("xd", 1.5), ("turn", -25.0), ("k", 0.01)],
        network: FOUR_BARS,
        outputs: &["x", "y"],
        draw: parallelogram,
    },
    Family {
        name: "two toggles in a row",
        parameters: &[("y1", 0.1), ("x2", 0.0), ("y2", 0.1), ("k", 0.01), ("move", 1.5)],
        network: TOGGLES,
        outputs: &["x", "y"],
        draw: two_toggles,
    },
    Family {
        name: "slider cranks",
        parameters: &[("xb", 0.5), ("yb", 0.5), ("xc", 1.4), ("turn", 30.0), ("k", 0.01)],
        network: SLIDER,
        outputs: &["x", "y"],
        draw: slider,
    },
    Family {
        name: "six bars",
        parameters: &[
            ("xb", -0.99),
            ("yb", 0.1),
            ("xc", 1.005),
            ("yc", 0.03),
            ("xd", 2.0),
            ("xe", 2.1),
            ("ye", 0.1),
            ("xf", 3.0),
            ("turn", 13.5),
            ("k", 0.01),
        ],
        network: SIX_BARS,
        outputs: &["x", "y"],
        draw: six_bars,
    },
    Family {
        name: "four bars under a force",
        parameters: &[
            ("xb", -0.99),
            ("yb", 0.1),
            ("xc", 1.005),
            ("yc", 0.03),
            ("xd", 2.0),
            ("fx", 1e-4),
            ("fy", 1e-4),
            ("k", 0.01),
        ],
        network: FORCED,
        outputs: &["x", "y"],
        draw: forced,
    },
];

/// Rods of slender and of stout section, in mm.
const RADII: [f64; 2] = [0.02, 0.06];

fn main() {
    let number = |place: usize| std::env::args().nth(place).and_then(|text| text.parse().ok());
    let (count, seed) = (number(1).unwrap_or(200), number(2).unwrap_or(0));
    println!(
        "| linkages | rod radius | designs | with an answer | elsewhere than {SMALL} increments | beside others elsewhere than alone |"
    );
    println!("|---|---:|---:|---:|---:|---:|");
    for family in &FAMILIES {
        for radius in RADII {
            compare(family, radius, count as usize, seed);
        }
    }
}

/// The problem of a family, in so many increments.
fn problem(family: &Family, radius: f64, increments: usize) -> Problem {
    let parameters: Vec<String> = family.parameters.iter().map(|(name, value)| format!("{name} = {value:?}")).collect();
    let members = family
        .network
        .replace("\"] }", "\"], section = \"rod\", material = \"steel\" }")
        .replace("\"], release", "\"], section = \"rod\", material = \"steel\", release");
    let steps = if increments > 1 { format!("[[steps]]\nincrements = {increments}") } else { "[[steps]]".to_owned() };
    let text = format!(
        "format = \"pennate/1\"\ndimension = \"plane\"\n[parameters]\n{}\n[materials]\nsteel = {{ youngs_modulus = 2e5, \
         poissons_ratio = 0.3 }}\n[sections]\nrod = {{ circle = {{ radius = {radius:?} }}, shear = false }}\n{}",
        parameters.join("\n"),
        members.replace("[[steps]]", &steps)
    );
    let document = Document::from_text("linkage.toml", &text);
    let names: Vec<&str> = family.parameters.iter().map(|(name, _)| *name).collect();
    Problem::new(&document, &[], &names, family.outputs, ACCURACY).unwrap_or_else(|error| panic!("{error}"))
}

fn compare(family: &Family, radius: f64, count: usize, seed: u64) {
    let mut random = fastrand::Rng::with_seed(seed);
    let rows: Vec<Vec<f64>> = (0..count).map(|_| (family.draw)(&mut random)).collect();
    let [at_once, slowly] = [1, SMALL].map(|increments| problem(family, radius, increments));
    let beside = at_once.evaluate(&rows.concat());
    let runs: Vec<[Run; 2]> =
        rows.par_iter().map(|row| [&at_once, &slowly].map(|problem| problem.evaluate_alone(row))).collect();
    let (mut answered, mut elsewhere, mut otherwise) = (0, 0, 0);
    for (index, [alone, careful]) in runs.into_iter().enumerate() {
        answered += usize::from(alone.1.is_none());
        let outputs = family.outputs.len();
        let values = beside.values[index * outputs..(index + 1) * outputs].to_vec();
        let together = (values, beside.reasons[index].clone(), beside.stable[index]);
        for (other, what, number) in
            [(&careful, "in small increments", &mut elsewhere), (&together, "beside others", &mut otherwise)]
        {
            if differ(&alone, other) {
                *number += 1;
                eprintln!(
                    "{}, rod radius {radius}, design {index} of seed {seed}: {:?}\n  at once {}\n  {what} {}",
                    family.name,
                    rows[index],
                    told(&alone),
                    told(other)
                );
            }
        }
    }
    println!("| {} | {radius} | {count} | {answered} | {elsewhere} | {otherwise} |", family.name);
}

type Run = (Vec<f64>, Option<Reason>, Option<bool>);

/// Whether both have an answer and another one, or one of them has none where the other has one that is stable.
fn differ(one: &Run, other: &Run) -> bool {
    match (&one.1, &other.1) {
        (None, None) => one.0.iter().zip(&other.0).any(|(a, b)| (a - b).abs() > SAME),
        (a, b) => a.is_some() != b.is_some(),
    }
}

fn told((values, reason, stable): &Run) -> String {
    match reason {
        None => format!("{values:?}, stable {stable:?}"),
        Some(reason) => format!("{reason:?}"),
    }
}
