//! States of constant strain and curvature are met exactly, by every order and any number of elements, corotational or not.

use std::f64::consts::TAU;

use pennate_models::Mesh;
use pennate_solver::structure::Formulation;

use pennate_testing::network;

use pennate_testing::network::{Solved, Vector, assert_close, assert_near, model, solve_on};

const LENGTH: f64 = 60.0;

/// A rod clamped at the origin along x, in every order with one, three and eight elements, and corotational with more:
/// in tension these have to be clearly shorter than √(12 EI/N).
fn every_mesh(shear: &str, rest: &str, check: impl Fn(&Solved, &str)) {
    for dimension in ["plane", "space"] {
        if dimension == "plane" && rest.contains("space only") {
            continue;
        }
        let model = model(&format!(
            r#"
            format = "pennate/1"
            dimension = "{dimension}"
            sections.rod = {{ stiffness = {{ EA = 3e3, GA2 = 1e3, GA3 = 1.4e3, GJ = 700, EI2 = 1e3, EI3 = 2e3 }}{shear} }}
            nodes = {{ A = [0, 0, 0], B = [{LENGTH}, 0, 0] }}
            members.rod = {{ nodes = ["A", "B"], orientation = [0, 1, 0], section = "rod" }}
            supports.A = "clamped"
            {rest}
            "#
        ));
        for order in 1..=4 {
            for elements in [1, 3, 8] {
                let solved = solve_on(model.clone(), &Mesh::new(order, vec![vec![elements]]));
                check(&solved, &format!("{dimension}, order {order}, {elements} elements"));
            }
        }
        let mut model = model;
        model.members[0].formulation = Formulation::Corotational;
        for elements in [24, 32] {
            let solved = solve_on(model.clone(), &Mesh::new(1, vec![vec![elements]]));
            check(&solved, &format!("{dimension}, corotational, {elements} elements"));
        }
    }
}

#[test]
fn pure_stretch_is_exact() {
    every_mesh("", "steps = [{ force = { B = [600, 0, 0] } }]", |solved, mesh| {
        assert_close(solved.shift("B"), [0.2 * LENGTH, 0.0, 0.0], 1e-11 * LENGTH);
        assert_near(solved.member("rod").axial_force, 600.0, 1e-9);
        assert_near(solved.last().energy, 0.5 * 600.0 * 0.2 * LENGTH, 1e-8);
        // Three iterations, the end itself, and linear buckling.
        assert!(solved.factorizations() <= 5, "{mesh}");
    });
}

/// The moment M = EI θ/L bends a plane rod by θ, whatever the mesh: no element locks.
#[test]
fn pure_bending_in_the_plane_is_exact() {
    for angle in [0.3_f64, 1.2] {
        for shear in ["", ", shear = false"] {
            let moment = 2e3 * angle / LENGTH;
            let steps = format!("steps = [{{ follower_moment = {{ B = [0, 0, {moment:?}] }} }}]");
            every_mesh(shear, &steps, |solved, mesh| {
                // In space Gibbs vectors do not make a circle; corotational elements measure the angle itself.
                let plane = solved.model.dimension == pennate_solver::structure::Dimension::Plane;
                if plane || mesh.contains("corotational") {
                    assert_near(solved.node("B").rotation[2], angle, 1e-10);
                    assert_near(solved.member("rod").axial_force, 0.0, 1e-8);
                    assert_near(solved.last().energy, 0.5 * moment * angle, 1e-9);
                }
                if mesh.ends_with("order 4, 8 elements") {
                    let radius = LENGTH / angle;
                    let goal = Vector::new(radius * angle.sin(), radius * (1.0 - angle.cos()), 0.0);
                    assert_close(solved.place("B"), goal, 1e-10 * LENGTH);
                }
                assert!(solved.factorizations() < 12, "{mesh}: {}", solved.factorizations());
            });
        }
    }
}

/// Pure twist leaves the rod straight.
#[test]
fn pure_twist_keeps_a_rod_straight() {
    let steps = "# space only\nsteps = [{ follower_moment = { B = [9, 0, 0] } }]";
    every_mesh("", steps, |solved, mesh| {
        assert_close(solved.shift("B"), [0.0; 3], 1e-10 * LENGTH);
        let error = (solved.node("B").rotation[0] - 9.0 * LENGTH / 700.0).abs();
        assert!(error < 0.05, "{mesh}: {error}");
        let exact = mesh.ends_with("order 4, 8 elements") || mesh.contains("corotational");
        assert!(error < 1e-10 || !exact, "{mesh}: {error}");
    });
}

/// Free induced strain and curvature, and nothing else, leave no stress: an arc, a helix.
#[test]
fn induced_strains_alone_leave_no_stress() {
    for dimension in ["plane", "space"] {
        for order in 1..=4 {
            for elements in [4, 8] {
                let k = TAU / 4.0 / LENGTH;
                let model = model(&format!(
                    r#"
                    format = "pennate/1"
                    dimension = "{dimension}"
                    sections.rod = {{ stiffness = {{ EA = 3e3, GA2 = 1e3, GA3 = 1.4e3, GJ = 700, EI2 = 1e3, EI3 = 2e3 }} }}
                    nodes = {{ A = [0, 0, 0], B = [{LENGTH}, 0, 0] }}
                    supports.A = "clamped"
                    members.rod = {{ nodes = ["A", "B"], orientation = [0, 1, 0], segments = [
                        {{ length = {LENGTH}, section = "rod", strain = -0.2, curvature = [0, 0, {k:?}] }} ] }}
                    steps = [{{ actuation = {{ rod = 1 }} }}]
                    "#
                ));
                let solved = solve_on(model, &Mesh::new(order, vec![vec![elements]]));
                let radius = 0.8 / k;
                let goal = Vector::new(radius, radius, 0.0);
                assert_near(solved.last().energy, 0.0, 1e-12);
                assert_close(solved.place("B"), goal, [0.1, 1e-3, 1e-5, 1e-8][order - 1] * LENGTH);
            }
        }
    }
}

/// Unloaded curved rods of any kind stay as they are.
#[test]
fn unloaded_curved_rods_stay_as_they_are() {
    for shear in ["", ", shear = false", ", shear = false, stretch = false"] {
        for order in 1..=4 {
            let model = model(&format!(
                r#"
                format = "pennate/1"
                sections.rod = {{ stiffness = {{ EA = 3e3, GA2 = 1e3, GA3 = 1.4e3, GJ = 700, EI2 = 1e3, EI3 = 2e3 }}{shear} }}
                nodes = {{ A = [0, 0, 0], B = [0, 100, 0], C = [0, 100, 40], D = [30, 100, 80] }}
                supports = {{ A = "clamped", D = "clamped" }}
                members.arc = {{ nodes = ["A", "B"], section = "rod", arc = [50, 50, 0] }}
                members.post = {{ nodes = ["B", "C"], section = "rod" }}
                members.other = {{ nodes = ["C", "D"], section = "rod", arc = [12, 103, 65] }}
                "#
            ));
            let solved = solve_on(model, &Mesh::new(order, vec![vec![6], vec![1], vec![3]]));
            for node in &solved.last().nodes {
                assert_close(node.displacement, [0.0; 3], 1e-9);
                assert_close(node.reaction_force, [0.0; 3], 1e-6);
            }
        }
    }
}

/// Stiffness ratios of a million, and none at all, cost neither digits nor iterations.
#[test]
fn extreme_stiffness_ratios_balance() {
    for (load, section) in [
        (1e-4, "stiffness = { EA = 3e3, GA2 = 1e3, GA3 = 1e3, GJ = 700, EI2 = 1e6, EI3 = 1 }"),
        (1e-4, "stiffness = { EA = 3e3, GA2 = 1e3, GA3 = 1e3, GJ = 700, EI2 = 1, EI3 = 1e6 }"),
        (1e-6, "stiffness = { EA = 3e3, GA2 = 1e3, GA3 = 1e3, GJ = 1e-2, EI2 = 1e3, EI3 = 1e3 }"),
        (0.1, "stiffness = { EA = 3e3, GJ = 700, EI2 = 1e3, EI3 = 2e3 }, shear = false, stretch = false"),
        (0.1, "stiffness = { EA = 3e3, GJ = 700, EI2 = 1e3, EI3 = 2e3 }, shear = false"),
        (0.1, "stiffness = { EA = 3e9, GJ = 700, EI2 = 1e3, EI3 = 2e3 }"),
    ] {
        for elements in [1, 4] {
            for order in 1..=4 {
                let model = model(&format!(
                    r#"
                    format = "pennate/1"
                    sections.rod = {{ {section} }}
                    nodes = {{ A = [0, 0, 0], J = [60, 0, 0], B = [60, 60, 0] }}
                    supports.A = "clamped"
                    members.one = {{ nodes = ["A", "J"], section = "rod" }}
                    members.two = {{ nodes = ["J", "B"], section = "rod", arc = [45, 30, 10] }}
                    steps = [{{ force = {{ B = [{:?}, {:?}, {:?}] }} }}]
                    "#,
                    0.8 * load,
                    0.6 * load,
                    -load
                ));
                let solved = solve_on(model, &Mesh::new(order, vec![vec![elements], vec![2 * elements]]));
                let (force, moment) = solved.imbalance(&[("B", [0.8 * load, 0.6 * load, -load], [0.0; 3])]);
                assert!(
                    force < 1e-7 * load && moment < 1e-5 * load,
                    "{section} {order} {elements}: {force:.1e} {moment:.1e}"
                );
                assert!(solved.factorizations() < 14, "{section} {order} {elements}: {}", solved.factorizations());
            }
        }
    }
}

/// An inextensible bar between two clamps cannot be stretched: that is no equilibrium, however the multiplier grows.
#[test]
fn an_inextensible_bar_is_not_stretched() {
    let text = r#"
        format = "pennate/1"
        nodes = { A = [0, 0], B = [60, 0] }
        members = { b = { nodes = ["A", "B"], section = "rigid" } }
        supports = { A = "clamped", B = "clamped" }
        steps = [{ displacement = { B = [1, 0] } }]
        [sections]
        rigid = { stiffness = { EA = 3e4, GJ = 7e3, EI2 = 1e4, EI3 = 2e4 }, shear = false, stretch = false }
    "#;
    let model = network::model(text);
    let (structure, steps) = pennate_models::discretize(&model, &pennate_models::Mesh::initial(&model, 1e-6));
    let options = pennate_solver::options::Options::default();
    let history = pennate_solver::solve(&structure, &steps, &options, &mut |_| true).expect("no mechanism");
    assert_eq!(history.steps[0].status, pennate_solver::history::Status::NotConverged);
}
