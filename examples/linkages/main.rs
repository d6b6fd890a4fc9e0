//! Random linkages, driven in one increment and again in many: who comes to the same place, alone and beside other designs.
//!
//! `cargo run --release --example linkages [-- COUNT [SEED [FAMILY]]]` prints the table, for so many designs of each family, or of those
//! whose name holds FAMILY. Linkages whose bars come into one line have two ways on, which are stable both: what an increment leads to is the way that small ones lead to.
//! Designs that end elsewhere without a word are listed with their parameters.

mod families;

use families::{FAMILIES, Family};
use pennate_analysis::problem::{Problem, Reason};
use pennate_models::Document;
use rayon::prelude::*;

/// Increments of the run that the others are held against.
const SMALL: usize = 400;
/// Distance over the length of a bar, or angle, within which two places are the same.
const SAME: f64 = 1e-6;
/// Estimated relative error that the mesh is made for.
const ACCURACY: f64 = 1e-4;

/// Radii of slender and of stout rods, over the length of a bar.
const RADII: [f64; 2] = [0.02, 0.06];

fn main() {
    let number = |place: usize| std::env::args().nth(place).and_then(|text| text.parse().ok());
    let (count, seed) = (number(1).unwrap_or(200), number(2).unwrap_or(0));
    let only = std::env::args().nth(3);
    println!(
        "| linkages | rod radius | designs | with an answer | elsewhere than {SMALL} increments | beside others elsewhere than alone |"
    );
    println!("|---|---:|---:|---:|---:|---:|");
    for family in FAMILIES.iter().filter(|family| only.as_ref().is_none_or(|name| family.name.contains(name))) {
        for radius in RADII {
            compare(family, radius, count as usize, seed);
        }
    }
}

/// The problem of a family, in so many increments.
fn problem(family: &Family, radius: f64, increments: usize) -> Problem {
    let parameters: Vec<String> = family.parameters.iter().map(|(name, value)| format!("{name} = {value:?}")).collect();
    let members = (family.network)()
        .replace("\"] }", "\"], section = \"rod\", material = \"steel\" }")
        .replace("\"], release", "\"], section = \"rod\", material = \"steel\", release");
    let steps = if increments > 1 { format!("[[steps]]\nincrements = {increments}") } else { "[[steps]]".to_owned() };
    let text = format!(
        "format = \"pennate/1\"\ndimension = \"{}\"\n[parameters]\n{}\n[materials]\nsteel = {{ youngs_modulus = 2e5, \
         poissons_ratio = 0.3 }}\n[sections]\nrod = {{ circle = {{ radius = {:?} }}, shear = false }}\n{}",
        family.dimension,
        parameters.join("\n"),
        radius * family.size,
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
            if differ(&alone, other, SAME * family.size) {
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

/// Whether both have an answer and another one by more than this distance, or one of them has none where the other has one that is stable.
fn differ(one: &Run, other: &Run, same: f64) -> bool {
    match (&one.1, &other.1) {
        (None, None) => one.0.iter().zip(&other.0).any(|(a, b)| (a - b).abs() > same),
        (a, b) => a.is_some() != b.is_some(),
    }
}

fn told((values, reason, stable): &Run) -> String {
    match reason {
        None => format!("{values:?}, stable {stable:?}"),
        Some(reason) => format!("{reason:?}"),
    }
}
