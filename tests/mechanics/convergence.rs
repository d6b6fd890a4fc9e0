//! The error of nodal values falls at the rate that theory gives: h^2p for elements of order p, h² for those of two nodes.
//!
//! All tend to the same values, those of elements of order 4.

use pennate_models::{Mesh, Model};
use pennate_solver::structure::Formulation;

use pennate_testing::network::{Solved, Vector, model, solve_on};

/// Solves on `elements` of an order in each segment.
fn on(model: &Model, order: usize, elements: usize) -> Solved {
    let refinement = model.members.iter().map(|member| vec![elements; member.segments.len()]).collect();
    solve_on(model.clone(), &Mesh::new(order, refinement))
}

/// Checks the rates of p = 1, 2, … from two numbers of `elements` each, and those of formulations of two nodes from the first two.
fn check(text: &str, node: &str, elements: &[[usize; 2]], finest: usize) {
    let model = model(text);
    let with = |formulation: &Formulation| {
        let mut model = model.clone();
        model.members.iter_mut().for_each(|member| member.formulation = *formulation);
        model
    };
    let of_two_nodes = Formulation::ALL.iter().filter(|formulation| !formulation.has_higher_orders());
    let of_two_nodes: Vec<Model> = of_two_nodes.map(with).collect();
    let finest = on(&model, 4, finest);
    let exact = (1..).zip(elements).map(|(order, &elements)| (&model, order, elements));
    for (model, order, [coarse, fine]) in exact.chain(of_two_nodes.iter().map(|model| (model, 1, elements[0]))) {
        let error = |count| {
            let solved = on(model, order, count);
            let shift = solved.shift(node) - finest.shift(node);
            let turn = solved.rotation(node).angle_to(&finest.rotation(node));
            (shift.norm(), turn, solved.shift(node))
        };
        let (first, second) = (error(coarse), error(fine));
        let rate = (first.0 / second.0).ln() / (fine as f64 / coarse as f64).ln();
        let expected = 2.0 * order as f64;
        let size = Vector::norm(&finest.shift(node));
        println!("{node} p = {order}: {:.2e} {:.2e} of {size:.2e}, rate {rate:.2}", first.0, second.0);
        assert!(second.0 > 1e-12 * size, "order {order}: rounding");
        assert!((rate - expected).abs() < 0.5, "order {order}: rate {rate:.2}, {:.1e}, {:.1e}", first.0, second.0);
    }
}

#[test]
fn elastica() {
    let text = r#"
        format = "pennate/1"
        nodes = { A = [0, 0], B = [1, 0] }
        sections.wire = { stiffness = { EA = 1e6, EI3 = 1 }, stretch = false }
        members.wire = { nodes = ["A", "B"], section = "wire" }
        supports.A = "clamped"
        steps = [{ force = { B = [0, 10] } }]
    "#;
    check(text, "B", &[[32, 64], [16, 32], [8, 16], [3, 6]], 32);
}

#[test]
fn bend_of_45_degrees() {
    let text = r#"
        format = "pennate/1"
        nodes = { A = [0, 0, 0], B = ["= 100 * sin(45)", "= 100 * (1 - cos(45))", 0] }
        sections.square = { stiffness = { EA = 1e7, GA2 = 5e6, GA3 = 5e6, GJ = 833333.3333333333, EI2 = "= 1e7 / 12", EI3 = "= 1e7 / 12" } }
        members.bend = { nodes = ["A", "B"], section = "square", arc = ["= 100 * sin(22.5)", "= 100 * (1 - cos(22.5))", 0] }
        supports.A = "clamped"
        steps = [{ force = { B = [0, 0, 600] } }]
    "#;
    check(text, "B", &[[32, 64], [16, 32], [8, 16], [4, 8]], 32);
}

#[test]
fn muscle_cantilever() {
    let text = r#"
        format = "pennate/1"
        nodes = { A = [0, 0], B = [130, 0] }
        muscles.m = { diameter = 13, wall = 2, pressure_unit = "psi", table = [
            { pressure = 10, E = 3.60, alpha = -9.135e-3, R1 = 6.80, R2 = 7.90 },
            { pressure = 25, E = 4.25, alpha = -6.885e-3, R1 = 7.15, R2 = 8.90 } ] }
        members.m = { nodes = ["A", "B"], muscle = "m" }
        supports.A = "clamped"
        steps = [{ pressure = { m = 25 }, force = { B = [0.5, -2] } }]
    "#;
    check(text, "B", &[[16, 32], [4, 8], [2, 4], [1, 2]], 16);
}

#[test]
fn tripod() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("models/networks/tripod.toml");
    let text = std::fs::read_to_string(path).unwrap();
    check(&text, "plate", &[[16, 32], [8, 16], [4, 8], [2, 4]], 12);
}

/// Three eighths of a turn: where the circle closes, every polygon does.
#[test]
fn roll_up() {
    let text = r#"
        format = "pennate/1"
        nodes = { A = [0, 0], B = [10, 0] }
        sections.rod = { stiffness = { EA = 1e4, GA2 = 5e3, EI3 = 100 } }
        members.rod = { nodes = ["A", "B"], section = "rod" }
        supports.A = "clamped"
        steps = [{ moment = { B = [0, 0, "= 0.375 * 2 * pi * 100 / 10"] } }]
    "#;
    check(text, "B", &[[32, 64], [4, 8], [2, 4], [1, 2]], 16);
}

#[test]
fn dyad() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("models/networks/dyad.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let steps = text.find("[[steps]]").unwrap();
    let text = format!("{}\n[[steps]]\npressure = {{ all = 25 }}\nforce = {{ J = [1, 2] }}\n", &text[..steps]);
    check(&text, "J", &[[32, 64], [8, 16], [4, 8]], 16);
}
