//! What is said of steps that stop short: it fits the network and what the step asks for.

use pennate::diagnostics::Message;
use pennate::explain;
use pennate_models::{Model, read_text};
use pennate_solver::history::{Cause, Failure, Note, Status, StepHistory};
use pennate_solver::structure::Dimension;

use crate::workplace::{DYAD, MUSCLE};

const STRUTS: &str = "format = \"pennate/1\"\ndimension = \"plane\"\n\
    nodes = { A = [-100, 0], J = [0, 40], B = [100, 0] }\nsupports = { A = \"pinned\", B = \"pinned\" }\n\
    sections.s.stiffness = { EA = 1e4, EI3 = 1e4 }\nmembers.right = { nodes = [\"J\", \"B\"], section = \"s\" }\n";
const WELDED: &str = "members.left = { nodes = [\"A\", \"J\"], section = \"s\" }\n";
const HINGED: &str = "members.left = { nodes = [\"A\", \"J\"], section = \"s\", release.end = \"pin\" }\n";

fn network(text: &str) -> Model {
    read_text("network.toml", text, &[]).expect("a network")
}

/// What is said of the first step of a network where it stops for this cause.
fn said(model: &Model, cause: Cause) -> String {
    said_with(model, cause, Vec::new())
}

/// The same of a step that has notes.
fn said_with(model: &Model, cause: Cause, noted: Vec<Note>) -> String {
    let (tried, worst_node, worst_component, worst_residual) = (0.5, Some(1), 0, 0.0);
    let failure = Some(Failure { tried, worst_node, worst_component, worst_residual, cause });
    let status = match cause {
        Cause::LimitPoint => Status::LimitPoint,
        Cause::Bifurcation => Status::Bifurcation,
        _ => Status::NotConverged,
    };
    let stopped = StepHistory { status, fraction: 0.4, failure, notes: noted, ..StepHistory::empty(Dimension::Plane) };
    let messages: Vec<Message> = explain::failed_steps(model, &[stopped]).collect();
    let [Message { notes, help: Some(help), .. }] = &messages[..] else { panic!("one message with help") };
    format!("{}\n{help}", notes.join("\n"))
}

/// A step is not told to do what it does already, nor what it cannot.
#[test]
fn no_advice_is_what_the_step_does() {
    for cause in [Cause::LimitPoint, Cause::Bifurcation, Cause::Endless, Cause::LeadsAway] {
        for method in ["newton", "jump", "arc_length"] {
            for branch in ["stable", "primary"] {
                let step = format!("steps = [{{ force.J = [0, -1], method = \"{method}\", branch = \"{branch}\" }}]\n");
                let said = said(&network(&format!("{STRUTS}{WELDED}{step}")), cause);
                let case = format!("{cause:?} {method} {branch}: {said}");
                assert!(!said.contains(&format!("method = \"{method}\"")), "{case}");
                assert!(branch != "primary" || !said.contains("branch = \"primary\" follows"), "{case}");
                let bifurcates = cause == Cause::Bifurcation;
                assert_eq!(bifurcates && branch == "stable", said.contains("branch = \"primary\" follows"), "{case}");
                assert_eq!(bifurcates && branch == "primary", said.contains("the unstable path that"), "{case}");
                assert_eq!(bifurcates, said.contains("a small imperfection"), "{case}");
            }
        }
        let freed = format!("{STRUTS}{WELDED}steps = [{{ free.B = [\"ux\"] }}]\n");
        assert!(!said(&network(&freed), cause).contains("arc_length"), "nothing can be let go of along the arc");
    }
}

/// What may have stopped an iteration is something that the network has.
#[test]
fn a_lost_way_is_put_down_to_what_there_is() {
    let cause = Cause::StepTooSmall;
    let of = |rest: &str| said(&network(&format!("{STRUTS}{rest}")), cause);
    let push = "steps = [{ force.J = [0, -1] }]\n";
    let spring = "springs.k = { node = \"J\", stiffness.ux = 1 }\n";
    let words = ["as when a muscle kinks", "come into one line", "snaps aside", "lets go of ux of node B"];
    let cases = [
        (said(&network(&format!("{DYAD}{MUSCLE}")), cause), words[0]),
        (of(&format!("{HINGED}{push}")), words[1]),
        (of(&format!("{WELDED}{spring}{push}")), words[1]),
        (of(&format!("{WELDED}{push}")), words[2]),
        (of(&format!("{HINGED}steps = [{{ free.B = [\"ux\"] }}]\n")), words[3]),
    ];
    for (said, expected) in cases {
        let found: Vec<_> = words.into_iter().filter(|words| said.contains(words)).collect();
        assert_eq!(found, [expected], "{said}");
        assert_eq!(said.contains("hold what is loose"), expected == words[3], "{said}");
    }
}

/// A whole turn is what stops a step that stops there, and not one that went on from it.
#[test]
fn a_whole_turn_explains_only_what_stops_there() {
    let model = network(&format!("{STRUTS}{WELDED}steps = [{{ force.J = [0, -1] }}]\n"));
    for is_there in [true, false] {
        let said = said_with(&model, Cause::StepTooSmall, vec![Note::WholeTurn { node: 1, is_there }]);
        assert_eq!(said.contains("node J is at a whole turn"), is_there, "{said}");
        assert_eq!(said.contains("hold all three rotations"), is_there, "{said}");
        assert_eq!(said.contains("snaps aside"), !is_there, "{said}");
    }
}
