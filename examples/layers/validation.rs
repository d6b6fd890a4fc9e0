//! The references of `validation/20_boundary_layers`.

use std::path::Path;

use nalgebra::Vector3;
use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_models::read;
use pennate_solver::options::Options;
use serde_json::{Value, json};

use crate::random::Case;
use crate::reference::{Held, Turned};

/// Prints them as they stand in `reference.json`.
pub(crate) fn print() {
    let by = |x, y| [Held::By(x), Held::By(y), Held::By(0.0)];
    let turned = |degrees: f64| Turned::To(Vector3::new(0.0, 0.0, degrees.to_radians()));
    let held = [Held::Pulled(50.0), Held::Pulled(0.0), Held::By(0.0)];
    let strip = result("strip", held, turned(90.0), 0.0);
    let thread = result("thread", [Held::Pulled(5.0), Held::By(12.0), Held::By(0.0)], turned(0.0), 0.0);
    let hanging = result("hanging", by(-20.0, 0.0), turned(0.0), 1e-3);
    println!("{:#}", json!({ "strip": strip, "thread": thread, "hanging": hanging }));
}

fn result(name: &str, held: [Held; 3], turned: Turned, weight: f64) -> Value {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("validation/20_boundary_layers/{name}.toml"));
    let model = read(&file, &[]).expect("a network");
    let options = Options { estimate: true, shapes: true, ..Options::default() };
    let solution = solve_to_accuracy(model, 1e-6, &options, &mut |_| true).expect("a solution");
    let weight = Vector3::new(0.0, -weight, 0.0);
    let case = Case { text: String::new(), space: false, weight, held, turned, follower: Vector3::zeros() };
    let ([start, end], scale, miss) = crate::reference(&case, &solution).expect("a reference");
    json!({
        "start": {
            "reaction_force": [-start[7], -start[8], 0.0],
            "reaction_moment": [0.0, 0.0, -start[12]],
        },
        "end": {
            "displacement": [end[0] - scale[0], end[1], 0.0],
            "reaction_moment": [0.0, 0.0, end[12]],
        },
        "error_estimate": miss,
    })
}
