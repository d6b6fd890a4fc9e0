//! The search for a mesh on which a spectrum is accurate enough.

use pennate_models::model::MemberId;
use pennate_models::{Mesh, Model, discretize};
use pennate_solver::buckling::{self, NoFactors};
use pennate_solver::error::{FreeMotion, SolveError};
use pennate_solver::history::{History, Status};
use pennate_solver::modes::{self, Found, NoModes};
use pennate_solver::options::{Options, Progress};
use pennate_solver::structure::{Step, Structure};

use super::place::Where;
use super::values::Values;
use super::{NoSpectrum, Question, Request};
use crate::accuracy::refine::{refinement_factor, shortened};
use crate::adapt::{Adaptive, Next};

/// Meshes that are tried at most, and those among them that may end before the state.
const MAX_ROUNDS: usize = 6;
const MAX_LOST: usize = 3;
/// A finer mesh whose error is larger than this part of the one before ends the search,
const STALLED: f64 = 0.5;
/// if that was smaller than this.
const NEAR: f64 = 1e-3;

/// What came of one mesh.
pub(super) struct Round {
    pub mesh: Mesh,
    /// `None` where the state was not reached, and a finer mesh may reach it.
    pub values: Option<Values>,
    /// The largest error of a value.
    pub worst: f64,
}

pub(super) struct Search<'a> {
    pub model: &'a Model,
    pub request: &'a Request,
    pub place: Where,
    pub options: &'a Options,
    pub observe: &'a mut dyn FnMut(&Progress) -> bool,
    /// Meshes that were tried.
    pub rounds: usize,
}

/// Why a search ends without an answer.
pub(super) enum Failure {
    Massless(Vec<MemberId>),
    Mechanism(Vec<FreeMotion>),
    NotSolved(Box<History>),
    Interrupted,
    NoModes(NoModes),
    NoFactors(NoFactors),
}

impl Failure {
    pub(super) fn with(self, model: Model) -> NoSpectrum {
        let model = Box::new(model);
        match self {
            Self::Massless(members) => NoSpectrum::Massless(model, members),
            Self::Mechanism(motions) => NoSpectrum::Mechanism(model, motions),
            Self::NotSolved(history) => NoSpectrum::NotSolved(model, history),
            Self::Interrupted => NoSpectrum::Interrupted,
            Self::NoModes(why) => NoSpectrum::NoModes(why),
            Self::NoFactors(why) => NoSpectrum::NoFactors(why),
        }
    }
}

impl Adaptive for Search<'_> {
    type Found = Round;
    type Failure = Failure;
    type End = ();

    fn find(&mut self, mesh: Mesh, _: Option<&Round>) -> Result<Round, Failure> {
        self.rounds += 1;
        let (structure, steps) = discretize(self.model, &mesh);
        if self.request.question == Question::Modes {
            let massless = modes::massless(&structure);
            if !massless.is_empty() {
                return Err(Failure::Massless(massless));
            }
        }
        let (history, values) = self.solve(&structure, &steps, mesh.lowest_order(self.model))?;
        let worst = match &values {
            Some(values) => values.entries.iter().filter_map(|entry| entry.error).fold(0.0, f64::max),
            None if history.steps.iter().any(|step| step.status == Status::Interrupted) => {
                return Err(Failure::Interrupted);
            }
            // A path that ends early may do so for want of elements.
            None if self.rounds < MAX_LOST && shortened(self.model, &mesh, 2) != mesh => f64::INFINITY,
            None => return Err(Failure::NotSolved(Box::new(history))),
        };
        Ok(Round { mesh, values, worst })
    }

    fn judge(&self, found: &Round, best: Option<&Round>, rounds: usize) -> Next<()> {
        let Round { mesh, values, worst } = found;
        let (model, accuracy) = (self.model, self.request.accuracy);
        let Some(values) = values else { return Next::Refine(shortened(model, mesh, 2)) };
        // All nodes of all elements take part, and rounding grows with the fourth power of their number.
        let stalled = best.is_some_and(|before| before.worst < NEAR && *worst > STALLED * before.worst);
        let finer =
            shortened(model, mesh, refinement_factor(worst / accuracy, mesh.lowest_order(model) + values.raised));
        let goes_on = *worst > accuracy && rounds < MAX_ROUNDS && !stalled && finer != *mesh;
        if goes_on { Next::Refine(finer) } else { Next::End(()) }
    }

    fn is_better(&self, found: &Round, best: &Round, _: &Next<()>) -> bool {
        !(best.worst < found.worst)
    }
}

impl Search<'_> {
    /// The history of a mesh, and the values where the state was reached.
    fn solve(
        &mut self,
        structure: &Structure,
        steps: &[Step],
        order: usize,
    ) -> Result<(History, Option<Values>), Failure> {
        let (Where { count, ramp }, wanted) = (self.place, self.request.count);
        let mechanism = |SolveError::Mechanism(motions)| Failure::Mechanism(motions);
        match self.request.question {
            Question::Modes => {
                let found = modes::modes(structure, steps, count, wanted, self.options, self.observe);
                let Found { history, result } = found.map_err(mechanism)?;
                match result {
                    Ok(levels) => Ok((history, Some(Values::of_modes(structure, levels)))),
                    Err(NoModes::NotReached) => Ok((history, None)),
                    Err(why) => Err(Failure::NoModes(why)),
                }
            }
            Question::Buckling => {
                let found = buckling::buckle(structure, steps, ramp, wanted, self.options, self.observe);
                let Found { history, result } = found.map_err(mechanism)?;
                match result {
                    Ok(levels) => Ok((history, Some(Values::of_buckling(structure, ramp, levels, order)))),
                    Err(NoFactors::NotReached) => Ok((history, None)),
                    Err(why) => Err(Failure::NoFactors(why)),
                }
            }
        }
    }
}
