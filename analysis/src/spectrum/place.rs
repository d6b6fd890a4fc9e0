//! Which state a spectrum is about, and what its factors multiply.

use pennate_models::Model;
use pennate_solver::buckling::Ramp;

use super::{Question, Request};

/// The state and the ramp that a request names, by index.
#[derive(Clone, Copy, Debug)]
pub(super) struct Where {
    /// Steps that are solved.
    pub count: usize,
    pub ramp: Ramp,
}

impl Where {
    /// The state and ramp of a request.
    ///
    /// # Errors
    /// The name of a step that the network does not have.
    pub(super) fn of(request: &Request, model: &Model) -> Result<Self, String> {
        let names = model.step_names();
        let find = |name: &Option<String>| match name {
            None => Ok(None),
            Some(name) => names.iter().position(|known| known == name).map(Some).ok_or_else(|| name.clone()),
        };
        let (step, along) = (find(&request.step)?, find(&request.along)?);
        let last = model.steps.len().saturating_sub(1);
        let end_of = |index: usize| if model.steps.is_empty() { 0 } else { index + 1 };
        Ok(match (request.question, step, along) {
            (Question::Modes, step, _) => {
                let index = step.unwrap_or(last);
                Self { count: end_of(index), ramp: Ramp::Present(index) }
            }
            (Question::Buckling, Some(index), _) => Self { count: end_of(index), ramp: Ramp::Present(index) },
            (Question::Buckling, None, along) if !model.steps.is_empty() => {
                let index = along.unwrap_or(last);
                Self { count: index, ramp: Ramp::Of(index) }
            }
            (Question::Buckling, None, _) => Self { count: 0, ramp: Ramp::Present(0) },
        })
    }
}
