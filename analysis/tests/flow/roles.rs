//! Roles, senses, levels and networks with muscles.

use pennate_analysis::flow::{Decision, End, Flow, MemberFlow, NoFlow, Role, flow};
use pennate_models::Document;
use pennate_solver::history::Status;
use pennate_solver::options::Options;

use crate::{of, of_text, text};

fn member<'a>(flow: &'a Flow, name: &str) -> &'a MemberFlow {
    let at = flow.request.members.iter().position(|&member| flow.model.members[member].name == name);
    &flow.members[at.unwrap()]
}

/// Transmitters as they are named, with + for tension and - for compression, and the axial share of the least of them;
/// all others are no transmitters, and the axial share of the largest of them.
fn transmitters(flow: &Flow) -> (String, f64, f64) {
    let (mut words, mut least, mut most) = (Vec::new(), 1.0_f64, 0.0_f64);
    for (index, member) in flow.members.iter().enumerate() {
        let name = &flow.model.members[flow.request.members[index]].name;
        if member.role == Role::Transmitter {
            words.push(format!("{name}{}", if member.axial > 0.0 { '+' } else { '-' }));
            least = least.min(member.shares[0]);
        } else {
            most = most.max(member.shares[0]);
        }
    }
    (words.join(" "), least, most)
}

/// Names of the members that became muscles at each step.
fn steps(flow: &Flow) -> Vec<String> {
    let mut before = 0;
    let new = |step: &pennate_analysis::flow::Replacement| {
        let names: Vec<&str> =
            step.muscles[before..].iter().map(|&member| flow.model.members[member].name.as_str()).collect();
        before = step.muscles.len();
        names.join(" ")
    };
    flow.steps.iter().map(new).collect()
}

#[track_caller]
fn assert_transmitters(flow: &Flow, expected: &str) {
    let (found, least, most) = transmitters(flow);
    assert_eq!(found, expected);
    assert!(least > 0.8 && most < 0.2, "axial shares of transmitters {least}, of others {most}");
    for member in flow.members.iter().filter(|member| member.role != Role::Idle) {
        assert!((member.shares.iter().sum::<f64>() - 1.0).abs() < 1e-12 && member.passed <= 1.0 + 1e-9);
    }
}

#[test]
fn inverter_transmits_by_tension_and_then_by_compression() {
    let flow = of("inverter");
    assert_transmitters(&flow, "T1+ T2+ T3-");
    assert_eq!(steps(&flow), ["T1", "T2"]);
    // The third level is in compression, and the last.
    assert_eq!((flow.levels.last().unwrap().decision, &flow.end), (Decision::PassOver, &End::Paths));
    assert!(flow.steps.iter().all(|step| step.status == Status::Converged && step.stable == Some(true)));
}

#[test]
fn gripper_passes_over_the_level_in_compression() {
    let flow = of("gripper");
    let (found, ..) = transmitters(&flow);
    assert_eq!(found, "T1+ T2- T3+ T4+");
    assert_eq!(steps(&flow), ["T1", "T3", "T4"]);
    for (name, axial) in [("T1", 1.0), ("T2", 0.962), ("T3", 1.0), ("T4", 1.0), ("C1", 0.0), ("C2", 0.0), ("jaw1", 0.0)]
    {
        assert!((member(&flow, name).shares[0] - axial).abs() < 1e-3, "{name}: {:?}", member(&flow, name).shares);
    }
}

#[test]
fn morphing_surface_ends_at_a_level_of_both_senses() {
    let flow = of("morphing");
    assert_transmitters(&flow, "T1+ T2+ T3+ T4- T5+ T6+");
    assert_eq!(steps(&flow), ["T1 T3 T5"]);
    let names: Vec<&str> = match &flow.end {
        End::Mixed(stay) => stay.iter().map(|&member| flow.model.members[member].name.as_str()).collect(),
        other => panic!("{other:?}"),
    };
    assert_eq!(names, ["T4"]);
    // Outputs of a nonlinear solution with the same assumed coordinates, mm.
    for (output, expected) in flow.steps[0].outputs.iter().zip([-6.8, 4.7, -6.4]) {
        assert!((output[1] - expected).abs() < 0.05, "{} instead of {expected}", output[1]);
    }
}

#[test]
fn drive_of_the_3d_gripper_has_two_paths_of_two_levels_in_tension() {
    let flow = of("ring_drive");
    assert_transmitters(&flow, "first1+ second1+ first2+ second2+");
    assert_eq!(flow.graph.paths.len(), 2);
    assert_eq!(steps(&flow), ["first1 first2", "second1 second2"]);
}

/// Shorter than the shortest muscle, the second level stays as it is.
#[test]
fn short_members_are_not_replaced() {
    let flow = of_text(&text("ring_drive").replace("shortest = 30", ""), &[]);
    assert_eq!(steps(&flow), ["first1 first2"]);
    assert!(matches!(flow.end, End::Short(_)), "{:?}", flow.end);
}

#[test]
fn cage_of_the_3d_gripper_has_no_transmitters() {
    for twist in ["0", "75"] {
        let flow = of_text(&text("cage"), &[("twist", twist)]);
        let (found, _, most) = transmitters(&flow);
        assert!(found.is_empty() && most < 0.01, "twist {twist}: {found}, axial share {most}");
        assert_eq!(flow.end, End::NoMuscle);
    }
}

#[test]
fn pushed_chain_has_nothing_that_a_contracting_muscle_replaces() {
    let flow = of("pushed_chain");
    assert_transmitters(&flow, "first- second-");
    assert!(flow.steps.is_empty() && flow.end == End::Paths);
}

#[test]
fn senses_are_seen_from_the_input() {
    let flow = of("pulled_chain");
    assert_transmitters(&flow, "first+ second+");
    assert_eq!(steps(&flow), ["second", "first"]);
}

#[test]
fn lever_passes_load_on_by_bending() {
    let flow = of("lever");
    let arm = member(&flow, "arm");
    assert_eq!(arm.role, Role::Constraint);
    assert!(arm.shares[0].abs() < 1e-9, "{:?}", arm.shares);
    assert!(flow.steps.is_empty());
}

#[test]
fn paths_of_different_length_are_treated_together() {
    let flow = of("two_paths");
    assert_transmitters(&flow, "left+ right+ next+");
    assert_eq!(flow.graph.paths.len(), 2);
    assert_eq!(steps(&flow), ["left right", "next"]);
}

#[test]
fn mechanisms_in_space_have_transmitters() {
    assert_transmitters(&of("tripod"), "LA+ LB+ LC+");
    // The strip is held by what it drives, and bends as well.
    let (found, least, most) = transmitters(&of("chain_in_space"));
    assert_eq!(found, "first+ second+");
    assert!(least > 0.5 && most < 0.01, "axial shares of transmitters {least}, of others {most}");
}

/// Muscles of a file stand for wires of the mechanism; members that are not named are left out.
#[test]
fn muscles_count_as_wires() {
    let wires = of("inverter");
    let wire = "T1 = { nodes = [\"I\", \"J1\"], section = \"wire\", material = \"steel\" }";
    let muscle = "T1 = { nodes = [\"I\", \"J1\"], muscle = \"silicone\" }\n\
                  pull = { nodes = [\"F\", \"I\"], muscle = \"silicone\" }";
    let changed = text("inverter").replace(wire, muscle).replace("[nodes]", "[nodes]\nF = [-170, 0]");
    let changed =
        changed.replace("[load_flow]", "F = \"clamped\"\n\n[load_flow]\nmembers = [\"T1\", \"T2\", \"T3\", \"C\"]");
    let muscles = of_text(&changed, &[]);
    for name in ["T1", "T2", "T3", "C"] {
        let (a, b) = (member(&wires, name).shares, member(&muscles, name).shares);
        assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-9), "{name}: {a:?} {b:?}");
    }
    let (a, b) = (&wires.steps[1].outputs[0], &muscles.steps[1].outputs[0]);
    assert!((a[0] - b[0]).abs() < 1e-3, "{} {}", a[0], b[0]);
}

/// The replacement ends with the first network that keeps to all requirements; where none does, with the last one.
#[test]
fn requirements_end_the_replacement() {
    let probes = "
[probes]
worst = { member = \"all\", stress = \"max\" }
closed = \"= abs(O_y)\"
O_y = { node = \"O\", displacement = \"uy\" }
idle = { node = \"G1\", reaction = \"uy\" }
";
    let with = |required: &str| of_text(&format!("{}requirements = {required}\n{probes}", text("gripper")), &[]);
    let free = of("gripper");
    let moved: Vec<f64> = free.steps.iter().map(|step| step.outputs[0][1].abs()).collect();
    let stress: Vec<f64> = free.steps.iter().map(|step| step.stress.unwrap()).collect();
    assert!(moved[0] < moved[1] && moved[1] < moved[2], "{moved:?}");
    let between = 0.5 * (moved[0] + moved[1]);
    let met = with(&format!("{{ closed = {{ least = {between} }} }}"));
    assert_eq!((steps(&met), &met.end), (vec!["T1".to_owned(), "T3".to_owned()], &End::Met));
    assert!((met.steps[1].required[0] - moved[1]).abs() < 1e-9 * moved[1]);
    // Both at once: as long as one of them is not met, it goes on.
    let most = 0.5 * stress.iter().fold(f64::INFINITY, |least: f64, stress| least.min(*stress));
    let both = with(&format!("{{ closed = {{ least = {between} }}, worst = {{ most = {most} }} }}"));
    assert_eq!((steps(&both).len(), &both.end), (3, &End::Paths));
    for (step, stress) in both.steps.iter().zip(&stress) {
        assert!((step.required[1] - stress).abs() < 1e-6 * stress, "{} {stress}", step.required[1]);
    }
}

#[test]
fn requirements_that_cannot_be_are_refused() {
    let probes =
        "[probes]\nu = { node = \"O\", displacement = \"uy\" }\nlate = \"= u@push\"\n[[steps]]\nname = \"push\"";
    let cases = [
        ("{ v = { least = 1 } }", "refers to probe 'v', which is not defined"),
        ("{ u = {} }", "the requirement 'u' has no limit"),
        ("{ u = { least = 2, most = 1 } }", "the requirement 'u' is more than its greatest value"),
        ("{ late = { most = 1 } }", "the requirement 'late' is about a step of the file"),
        ("{ u = { lest = 1 } }", "lest"),
    ];
    for (required, message) in cases {
        let text = format!("{}requirements = {required}\n{probes}\n", text("gripper"));
        let document = Document::from_text("case.toml", &text);
        match flow(&document, &[], &Options::default(), &mut |_| true) {
            Err(NoFlow::Input(errors)) => {
                assert!(errors.errors[0].message.contains(message), "{}", errors.errors[0].message)
            }
            other => panic!("{required}: {other:?}"),
        }
    }
}
