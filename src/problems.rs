//! Why there is no problem, and why a design of one has no answer, in words.

use pennate_analysis::problem::{Problem, ProblemError, Reason};
use pennate_analysis::solution::status_name;
use pennate_models::input::suggest;
use pennate_solver::error::SolveError;

use crate::explain;
use crate::output::text::{percent, shown};

/// Why a design has no answer, or not all of it: one sentence without a full stop.
pub fn reason(problem: &Problem, reason: &Reason) -> String {
    let model = problem.network();
    let step = |index: usize| model.step_names().get(index).map_or_else(String::new, |name| shown(name));
    match reason {
        Reason::NotFinite { parameter } => {
            let name = problem.parameters().nth(*parameter).unwrap_or_default();
            format!("the value of parameter '{}' is no finite number", shown(name))
        }
        Reason::Refused(errors) => match errors.errors.first() {
            Some(first) => first.message.clone(),
            None => "these values make no network".to_owned(),
        },
        Reason::OtherTopology => {
            "these values make a network with other nodes, members, supports or steps; only numbers may differ"
                .to_owned()
        }
        Reason::Mechanism(motions) => match motions.first() {
            Some(motion) => explain::mechanism(model, motion).title,
            None => "the network is a mechanism: it can move without force".to_owned(),
        },
        Reason::Stopped { step: index, status, fraction, .. } => {
            let how = status_name(*status).replace('_', " ");
            format!("step '{}' ends at {} of its ramp: {how}", step(*index), percent(*fraction))
        }
        Reason::Singular { step: index, begins } => {
            let place = if *begins { "where step" } else { "at the end of step" };
            let begins = if *begins { " begins" } else { "" };
            format!(
                "the stiffness {place} '{}'{begins} is singular, or so nearly that there is no derivative",
                step(*index)
            )
        }
        Reason::Unbalanced { step: index } => {
            format!(
                "a moment at the end of step '{}' is taken by nothing: hold the rotations of nodes along the axes of their hinges, or across all of them",
                step(*index)
            )
        }
        Reason::StopsShort { step: index } => {
            format!(
                "step '{}' ends at its stop, before the end of its ramp: what follows has no derivatives, and no live state",
                step(*index)
            )
        }
        Reason::NoDerivative { output } => {
            let name = problem.outputs().get(*output).map_or("", |output| output.name.as_str());
            format!("the probe '{}' has no derivative there", shown(name))
        }
        Reason::Inexact { output, error } => {
            let name = problem.outputs().get(*output).map_or("", |output| output.name.as_str());
            format!("derivatives of the probe '{}' are known to no better than {error:.0e} of the largest", shown(name))
        }
        Reason::Edge { parameter, reason: why } => {
            let name = problem.parameters().nth(*parameter).unwrap_or_default();
            let why = self::reason(problem, why);
            format!("there is no derivative by '{}' at the edge of what makes a network: beyond it {why}", shown(name))
        }
        Reason::Lost { fraction } => {
            format!("the equilibrium, or its stability, is lost at {} of the way", percent(*fraction))
        }
        Reason::Interrupted => "interrupted".to_owned(),
    }
}

/// The word for the kind of a reason, for programs.
pub fn kind(reason: &Reason) -> &'static str {
    match reason {
        Reason::NotFinite { .. } => "not_finite",
        Reason::Refused(_) => "refused",
        Reason::OtherTopology => "other_topology",
        Reason::Mechanism(_) => "mechanism",
        Reason::Stopped { status, .. } => status_name(*status),
        Reason::Singular { .. } => "singular",
        Reason::Unbalanced { .. } => "unbalanced",
        Reason::NoDerivative { .. } | Reason::StopsShort { .. } | Reason::Edge { .. } => "no_derivative",
        Reason::Inexact { .. } => "inexact",
        Reason::Lost { .. } => "lost",
        Reason::Interrupted => "interrupted",
    }
}

/// Why there is no problem, where neither the network nor a mechanism is to blame: what is wrong, and what would help.
pub fn wrong(error: &ProblemError) -> (String, Option<String>) {
    match error {
        ProblemError::UnknownParameter { name, known } => {
            (format!("there is no parameter '{}'", shown(name)), Some(likely(name, known, "parameters")))
        }
        ProblemError::UnknownProbe { name, known } => {
            (format!("there is no probe '{}'", shown(name)), Some(likely(name, known, "probes")))
        }
        ProblemError::UnknownStep { probe, step, known } => (
            format!("there is no step '{}' for the probe '{}'", shown(step), shown(probe)),
            Some(likely(step, known, "steps")),
        ),
        ProblemError::Unsolvable(SolveError::Mechanism(_)) | ProblemError::Network(_) => (error.to_string(), None),
        ProblemError::Twice { .. }
        | ProblemError::Counts { .. }
        | ProblemError::ChangesTopology { .. }
        | ProblemError::Interrupted => (error.to_string(), None),
    }
}

/// The names that may have been meant by one that there is not.
pub fn likely(name: &str, known: &[String], plural: &str) -> String {
    let known: Vec<String> = known.iter().map(|name| shown(name)).collect();
    suggest(name, known.iter().map(String::as_str), plural)
}
