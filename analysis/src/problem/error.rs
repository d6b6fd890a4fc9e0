//! Why there is no problem, and why a design has no answer.

use pennate_models::InputErrors;
use pennate_solver::error::{FreeMotion, SolveError};
use pennate_solver::history::{Cause, Status};

/// Why a network cannot be compiled for some parameters and probes.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ProblemError {
    /// The network is wrong.
    #[error("{0}")]
    Network(InputErrors),
    /// The network has no equilibrium to look for at the values of its file.
    #[error("the network cannot be solved at the values of its file: {0}")]
    Unsolvable(SolveError),
    /// There is no such parameter.
    #[error("there is no parameter '{name}'; the parameters are {}", list(known))]
    UnknownParameter {
        /// As it was given.
        name: String,
        /// Those of the file.
        known: Vec<String>,
    },
    /// A parameter is named twice.
    #[error("parameter '{name}' is named twice")]
    Twice {
        /// The parameter.
        name: String,
    },
    /// A number of copies, elements or increments depends on a parameter.
    #[error("parameter '{name}' sets a count, which is the same in all designs; make a problem for each of its values")]
    Counts {
        /// The parameter.
        name: String,
    },
    /// Nodes, members, supports or steps are others for other values of a parameter.
    #[error("parameter '{name}' changes which {what} the network has; only numbers may differ from design to design")]
    ChangesTopology {
        /// The parameter.
        name: String,
        /// What is another then.
        what: &'static str,
    },
    /// There is no such probe.
    #[error("there is no probe '{name}'; the probes are {}", list(known))]
    UnknownProbe {
        /// As it was given.
        name: String,
        /// Those of the file.
        known: Vec<String>,
    },
    /// There is no such step.
    #[error("there is no step '{step}' for the probe '{probe}'; the steps are {}", list(known))]
    UnknownStep {
        /// The probe as it was given.
        probe: String,
        /// The step behind the @.
        step: String,
        /// Those of the file.
        known: Vec<String>,
    },
    /// Nobody wanted to wait any longer.
    #[error("interrupted")]
    Interrupted,
}

impl ProblemError {
    /// The name that is to blame, if one is.
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::UnknownParameter { name, .. }
            | Self::Twice { name }
            | Self::Counts { name }
            | Self::ChangesTopology { name, .. }
            | Self::UnknownProbe { name, .. }
            | Self::UnknownStep { step: name, .. } => Some(name),
            Self::Network(_) | Self::Unsolvable(_) | Self::Interrupted => None,
        }
    }
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

/// Why a design has no answer, or not all of it.
#[derive(Clone, Debug)]
pub enum Reason {
    /// The value of this parameter, by its place in the row, is no finite number.
    NotFinite {
        /// Place in the row.
        parameter: usize,
    },
    /// The values of the parameters make no network.
    Refused(Box<InputErrors>),
    /// The values of the parameters make a network with other nodes, members, supports or steps.
    OtherTopology,
    /// The unloaded network can move without force.
    Mechanism(Vec<FreeMotion>),
    /// A step stopped short, at this part of its ramp; outputs of the steps before it are known.
    Stopped {
        /// The step.
        step: usize,
        /// How it ended.
        status: Status,
        /// Part of its ramp that was reached.
        fraction: f64,
        /// Why, where the solver can tell.
        cause: Option<Cause>,
    },
    /// The tangent at the end of this step, or where the first one begins and holds something, is singular to within rounding, or so nearly
    /// that derivatives have no digits: values are known, derivatives are not.
    Singular {
        /// The step.
        step: usize,
        /// Whether it is so where that begins, before it has gone anywhere.
        begins: bool,
    },
    /// A moment at the end of this step is taken by nothing ([`pennate_solver::history::Note::Untaken`]): values are those of a state that is no
    /// equilibrium, and have no derivatives.
    Unbalanced {
        /// The step.
        step: usize,
    },
    /// This step ends at its `stop`, before the end of its ramp, at a fraction that follows all parameters: what comes after has values, no
    /// derivatives, and no state that can be followed.
    StopsShort {
        /// The step.
        step: usize,
    },
    /// The probe of this output has no derivative there, or none that is known.
    NoDerivative {
        /// Place among the outputs.
        output: usize,
    },
    /// A derivative of this output by some parameter may be wrong by this part of the largest, which is more than is promised. It is a number
    /// up to a ten thousandth.
    Inexact {
        /// Place among the outputs.
        output: usize,
        /// Estimated error, over the largest derivative of the output, each times its parameter.
        error: f64,
    },
    /// There is no network beside the value of this parameter, and so no derivative by it.
    Edge {
        /// Place in the row.
        parameter: usize,
        /// Why there is none.
        reason: Box<Reason>,
    },
    /// A state that was followed lost its stability, or its equilibrium, at this part of the change that was asked for.
    Lost {
        /// Part of the change, from 0 to 1.
        fraction: f64,
    },
    /// Nobody wanted to wait any longer.
    Interrupted,
}

impl From<SolveError> for Reason {
    fn from(error: SolveError) -> Self {
        match error {
            SolveError::Mechanism(motions) => Self::Mechanism(motions),
        }
    }
}
