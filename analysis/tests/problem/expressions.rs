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
    let text = beam(STRETCHED, "probes.corner = \"= abs(F - 0.3) + drop\"\nprobes.square = \"= (F - 0.3) ^ 2 + drop\"");
    let found = gradient(&text, &["F", "x"], &["corner", "square"]);
    assert!(matches!(found.reasons[0], Some(Reason::NoDerivative { output: 0 })), "{:?}", found.reasons);
    assert!(found.jacobian[0].is_nan() && found.jacobian[1..].iter().all(|slope| slope.is_finite()), "{found:?}");
}
