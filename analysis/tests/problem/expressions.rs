//! Derivatives of expressions of probes.

use pennate_analysis::problem::{Derivatives, Problem, Reason};
use pennate_models::Document;

use crate::gradient::check;

const STRETCHED: &str = "stiffness = { EI3 = 12000, EA = 1e6 }";
const INEXTENSIBLE: &str = "circle = { radius = 1.6 }, stretch = false";

/// A beam on two supports under a force in its middle: nothing draws along it, whatever its parameters, so that `push` vanishes.
fn beam(section: &str, probes: &str) -> String {
    format!(
        r#"
        format = "pennate/1"
        parameters = {{ F = 0.3, x = 41, W = 1 }}
        nodes = {{ A = [0, 0], M = ["= x", 0], B = [100, 0] }}
        materials.m = {{ youngs_modulus = 2000, poissons_ratio = 0.3 }}
        sections.s = {{ {section} }}
        members = {{ a = {{ nodes = ["A", "M"], section = "s", material = "m" }}, b = {{ nodes = ["M", "B"], section = "s", material = "m" }} }}
        supports = {{ A = "pinned", B = {{ fix = ["uy"] }} }}
        steps = [{{ name = "load", force = {{ M = [0, "= -F"] }} }}, {{ name = "more", force = {{ M = [0, "= -2 * F"] }} }}]
        probes.drop = {{ node = "M", displacement = "uy" }}
        probes.push = {{ node = "A", reaction = "ux" }}
        {probes}
        "#
    )
}

fn gradient(text: &str, parameters: &[&str], probes: &[&str]) -> Derivatives {
    let problem = Problem::new(&Document::from_text("beam.toml", text), &[], parameters, probes, 1e-8).unwrap();
    problem.gradient(&problem.middle())
}

#[test]
fn a_vanishing_reaction_spoils_a_sum_with_a_word_only() {
    for section in [STRETCHED, "stiffness = { EI3 = 12000, EA = 1e9 }", INEXTENSIBLE] {
        let mut refused = 0;
        for weight in [1.0, 1e3, 1e6, 1e9, 1e12] {
            let text = beam(section, &format!("probes.sum = \"= drop + {weight} * push\""));
            let found = gradient(&text, &["F", "x"], &["drop", "sum"]);
            let (drop, sum) = found.jacobian.split_at(2);
            let size = |slopes: &[f64]| (0.3 * slopes[0]).abs().max((41.0 * slopes[1]).abs());
            let miss = size(&[sum[0] - drop[0], sum[1] - drop[1]]);
            match found.reasons[0] {
                None => assert!(miss <= 1e-7 * size(drop), "{section}, {weight}: {:?}", found.jacobian),
                Some(Reason::Inexact { output: 1, error }) => {
                    refused += 1;
                    assert!(!(miss > error * size(sum)), "{section}, {weight}, {error:e}: {:?}", found.jacobian);
                }
                ref other => panic!("{section}, {weight}: {other:?}"),
            }
        }
        // A weight of 10¹² makes a sum of rounding.
        assert!((1..5).contains(&refused), "{section}: {refused}");
    }
}

#[test]
fn what_vanishes_alone_is_measured_by_its_kind() {
    let text = beam(STRETCHED, "probes.twice = \"= 2 * push - push@load + abs(push)\"");
    let found = gradient(&text, &["F", "x"], &["push", "twice"]);
    assert!(found.reasons[0].is_none(), "{:?}", found.reasons);
    assert!(found.jacobian.iter().all(|slope| slope.abs() < 1e-9), "{:?}", found.jacobian);
}

#[test]
fn functions_steps_and_parameters_in_expressions() {
    let more = r#"
        probes.turn = { node = "A", rotation = "rz" }
        probes.cost = "= sqrt(drop^2 + drop@load^2) * W - exp(drop / x) * sin(3 * turn) + max(drop, turn) / F"
        probes.of = "= cost@load / cost + atan2(turn, drop)"
    "#;
    check(&beam(STRETCHED, more), &["F", "x", "W"], &["cost", "of", "drop"]);
}

#[test]
fn a_corner_has_no_derivative_and_a_minimum_has() {
    for corner in ["abs(F - 0.3) + drop", "drop + 0.02 * min(F, 0.3)", "sqrt(abs(drop - drop@more))"] {
        let probes = format!("probes.corner = \"= {corner}\"\nprobes.square = \"= (F - 0.3) ^ 2 + drop\"");
        let found = gradient(&beam(STRETCHED, &probes), &["F", "x"], &["corner", "square"]);
        assert!(matches!(found.reasons[0], Some(Reason::NoDerivative { output: 0 })), "{corner}: {:?}", found.reasons);
        assert!(found.jacobian[0].is_nan(), "{corner}: {found:?}");
        assert!(found.jacobian[2..].iter().all(|slope| slope.is_finite()), "{corner}: {found:?}");
    }
    let found = gradient(&beam(STRETCHED, "probes.fourth = \"= (F - 0.3) ^ 4\""), &["F", "x"], &["fourth"]);
    assert!(found.reasons[0].is_none() && found.jacobian.iter().all(|slope| slope.abs() < 1e-12), "{found:?}");
}

/// Corners of a load, of a section and of what a probe measures.
#[test]
fn a_corner_of_a_design_has_no_derivative() {
    let text = |force: &str, radius: &str| {
        format!(
            r#"
            format = "pennate/1"
            parameters = {{ L = 60, F = 2, a = 10, c = "= abs(a - 10)" }}
            nodes = {{ A = [0, 0], B = ["= L", 0] }}
            materials.m = {{ youngs_modulus = 2200, poissons_ratio = 0.3 }}
            sections.s = {{ circle = {{ radius = "= {radius}" }} }}
            members.m = {{ nodes = ["A", "B"], section = "s", material = "m" }}
            supports = {{ A = "clamped" }}
            steps = [{{ name = "load", force = {{ B = [0, "= -F + {force}"] }} }}]
            probes.u = {{ node = "B", displacement = "uy" }}
            probes.turn = {{ node = "B", rotation = "angle" }}
            probes.sum = "= u + c"
            "#
        )
    };
    for (force, radius, probe, place) in [
        ("0.5 * abs(a - 10)", "2", "u", 2),
        ("0.5 * sqrt((a - 10) ^ 2)", "2", "u", 2),
        ("0", "2 + 0.1 * abs(a - 10)", "u", 2),
        ("0", "2", "sum", 2),
        ("2", "2", "turn", 1),
        ("F - max(F, a / 5)", "2", "u", 1),
    ] {
        let found = gradient(&text(force, radius), &["L", "F", "a"], &[probe]);
        let reason = &found.reasons[0];
        assert!(matches!(reason, Some(Reason::NoDerivative { output: 0 })), "{force}, {radius}, {probe}: {reason:?}");
        assert!(
            found.jacobian[place].is_nan() && found.jacobian[0].is_finite(),
            "{force}, {radius}, {probe}: {found:?}"
        );
    }
}

/// Stiffnesses of a node whose rotation is held beside a load that turns with it.
#[test]
fn stiffnesses_beside_a_follower_force_whose_node_is_held() {
    for (support, steps) in [
        ("", "steps = [{ name = \"a\", follower_force = { B = [-180, 340] }, rotation = { B = [0, 0, \"= t\"] } }]"),
        (", B = [\"rz\"]", "steps = [{ name = \"a\", follower_force = { B = [\"= 9 * t\", 340] } }]"),
        (
            "",
            "steps = [{ name = \"a\", force = { B = [0, \"= -5 * t\"] } }, \
             { name = \"b\", hold = { B = [\"rz\"] }, follower_force = { B = [-50, 20] } }]",
        ),
    ] {
        let text = format!(
            r#"
            format = "pennate/1"
            strain_limit = 1e9
            parameters = {{ EI = 23460.5, k = 0.499437, t = -20 }}
            nodes = {{ A = [0, 0], B = [10, -16] }}
            sections.s = {{ stiffness = {{ EA = 38499, GA2 = 12254, EI3 = "= EI" }} }}
            members.m = {{ nodes = ["A", "B"], section = "s" }}
            supports = {{ A = "clamped"{support} }}
            springs.k0 = {{ node = "B", stiffness = {{ ux = "= k", uy = 0.25, rz = 162.6 }} }}
            {steps}
            probes.c = {{ node = "B", compliance = "rz" }}
            probes.kr = {{ node = "B", stiffness = "rz" }}
            probes.kx = {{ node = "B", stiffness = "ux" }}
            "#
        );
        let (parameters, probes) = (["EI", "k", "t"], ["c", "kr", "kx"]);
        let problem = Problem::new(&Document::from_text("bar.toml", &text), &[], &parameters, &probes, 1e-6).unwrap();
        let x = problem.middle();
        let found = problem.gradient(&x);
        assert!(matches!(found.reasons[0], None | Some(Reason::Inexact { .. })), "{:?}", found.reasons);
        for (output, row) in found.jacobian.chunks_exact(3).enumerate() {
            let largest = row.iter().zip(&x).fold(0.0, |most: f64, (slope, x)| most.max((slope * x).abs()));
            for input in 0..3 {
                let moved = |part: f64| {
                    let mut moved = x.clone();
                    moved[input] *= 1.0 + part;
                    problem.evaluate(&moved).values[output]
                };
                let (near, far) = (moved(1e-3) - moved(-1e-3), moved(2e-3) - moved(-2e-3));
                let difference = (8.0 * near - far) / 12e-3;
                let miss = (row[input] * x[input] - difference).abs();
                assert!(miss < 1e-6 * largest, "{steps} {output}, {input}: {miss:e} of {largest:e}");
            }
        }
    }
}
