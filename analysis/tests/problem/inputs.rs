//! What goes in, what comes out, and what is refused.

use pennate_analysis::problem::{Problem, ProblemError, Reason};
use pennate_models::Document;

const WIRE: &str = r#"
    format = "pennate/1"
    parameters = { L = 100, F = 5, E = "200 GPa", n = 2, deep = 0 }
    nodes = { A = [0, 0], B = ["= L", 0, "= deep"] }
    materials.steel = { youngs_modulus = "= E", poissons_ratio = 0.3 }
    sections.wire = { circle = { radius = "0.75 mm" } }
    members.wire = { nodes = ["A", "B"], section = "wire", material = "steel", elements = "= n" }
    supports = { A = "clamped" }
    steps = [{ name = "push", force = { B = [0, "= -F"] } }, { name = "more", force = { B = [0, "= -2 * F"] } }]
    probes = { drop = { node = "B", displacement = "uy" }, reach = { node = "B", position = "x" } }
"#;

fn wire(parameters: &[&str], probes: &[&str]) -> Result<Problem, ProblemError> {
    Problem::new(&Document::from_text("wire.toml", WIRE), &[], parameters, probes, 1e-6)
}

#[test]
fn a_probe_is_read_at_the_end_of_the_step_that_it_names() {
    let problem = wire(&["L", "F"], &["drop", "drop@push", "reach"]).unwrap();
    assert_eq!(problem.middle(), [100.0, 5.0]);
    let answer = problem.evaluate(&[100.0, 5.0, 100.0, 2.5]);
    assert!(answer.reasons.iter().all(Option::is_none), "{:?}", answer.reasons);
    let [first, second] = [&answer.values[..3], &answer.values[3..]];
    assert!((first[1] + 30.325).abs() < 1e-3, "{first:?}");
    assert!((first[1] - second[0]).abs() < 1e-7, "the same force in another step");
    assert!(first[0] < first[1] && first[2] < 100.0);
}

/// Values are in the unit that the file writes a parameter with, as where a number is set: 200 is 200 GPa.
#[test]
fn a_parameter_with_a_unit_takes_values_in_its_unit() {
    let problem = wire(&["E"], &["drop@push"]).unwrap();
    assert_eq!(problem.middle(), [200.0]);
    let answer = problem.evaluate(&[200.0, 1e6]).values;
    assert!((answer[0] + 30.325).abs() < 1e-3 && (answer[1] + 0.0067).abs() < 1e-3, "{answer:?}");
    let set = [("E".to_owned(), "190".to_owned())];
    let other = Problem::new(&Document::from_text("wire.toml", WIRE), &set, &["E"], &["drop@push"], 1e-6).unwrap();
    assert_eq!(other.middle(), [190.0]);
    let both = [&problem, &other].map(|problem| problem.gradient(&[190.0]));
    assert!((both[0].values[0] - other.evaluate(&other.middle()).values[0]).abs() < 1e-7);
    // By GPa: a softer wire sinks farther.
    let by = problem.evaluate(&[191.0, 189.0]).values;
    for slope in both.map(|both| both.jacobian[0]) {
        assert!((slope - 0.5 * (by[0] - by[1])).abs() < 1e-4 * slope && slope > 0.0, "{slope}");
    }
}

#[test]
fn what_changes_more_than_numbers_is_refused_by_name() {
    assert!(matches!(wire(&["L", "n"], &["drop"]), Err(ProblemError::Counts { name }) if name == "n"));
    let space = wire(&["deep"], &["drop"]);
    assert!(
        matches!(&space, Err(ProblemError::ChangesTopology { name, what: "dimension" }) if name == "deep"),
        "{space:?}"
    );
    assert!(matches!(wire(&["l"], &["drop"]), Err(ProblemError::UnknownParameter { .. })));
    assert!(matches!(wire(&["L", "L"], &["drop"]), Err(ProblemError::Twice { .. })));
    assert!(matches!(wire(&["L"], &["dorp"]), Err(ProblemError::UnknownProbe { .. })));
    assert!(matches!(wire(&["L"], &["drop@pull"]), Err(ProblemError::UnknownStep { .. })));
}

#[test]
fn a_design_without_answer_says_why() {
    let problem = wire(&["L", "F"], &["drop"]).unwrap();
    let answer = problem.evaluate(&[0.0, 5.0, f64::NAN, 5.0, 100.0, 5.0]);
    assert!(matches!(answer.reasons[0], Some(Reason::Refused(_))), "{:?}", answer.reasons);
    assert!(matches!(answer.reasons[1], Some(Reason::NotFinite { parameter: 0 })));
    assert!(answer.reasons[2].is_none());
    assert!(answer.values[0].is_nan() && answer.values[1].is_nan() && answer.values[2].is_finite());
}
