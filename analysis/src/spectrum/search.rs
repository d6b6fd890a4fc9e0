//! The search for a mesh on which a spectrum is accurate enough.

use pennate_models::model::MemberId;
use pennate_models::{Mesh, Model, discretize};
use pennate_solver::buckling::{self, Asked, Buckling, NoFactors};
use pennate_solver::error::{FreeMotion, SolveError};
use pennate_solver::history::{History, Status};
use pennate_solver::modes::{self, Found, NoModes};
use pennate_solver::options::{Options, Progress};
use pennate_solver::structure::{Step, Structure};

use super::place::Where;
use super::values::{Judged, Values};
use super::{NoSpectrum, Question, Request, with_orders_beyond};
use crate::accuracy::refine::{refinement_factor, shortened};
use crate::accuracy::solve_to_accuracy;
use crate::adapt::{Adaptive, Next};

/// Meshes that are tried at most, and those among them on which there may be no answer.
const MAX_ROUNDS: usize = 6;
const MAX_LOST: usize = 3;
/// So many meshes in a row whose errors are larger than this part of the smallest before, or rounding, end the search,
const STALLS: usize = 2;
const STALLED: f64 = 0.5;
/// if that was smaller than this, or the file forces elements.
const NEAR: f64 = 1e-3;

/// What came of one mesh.
pub(super) struct Round {
    pub mesh: Mesh,
    /// `None` where the state was not reached, and a finer mesh may reach it.
    pub values: Option<Values>,
    /// The largest error of a value.
    pub worst: f64,
    /// How many meshes in a row, this one the last, have not made it much smaller.
    stalls: usize,
    /// The mesh to go on with, where that is known.
    next: Option<Mesh>,
}

impl Round {
    /// A mesh on which there is no answer.
    fn lost(mesh: Mesh, next: Option<Mesh>) -> Self {
        Self { mesh, values: None, worst: f64::INFINITY, stalls: 0, next }
    }
}

pub(super) struct Search<'a> {
    pub model: &'a Model,
    pub request: &'a Request,
    pub place: Where,
    pub options: &'a Options,
    pub observe: &'a mut dyn FnMut(&Progress) -> bool,
    /// Meshes that were tried.
    pub rounds: usize,
    /// Those of them that brought no answer.
    pub lost: usize,
    /// Those of them, up to the last, that were no better than one before.
    pub stalls: usize,
    /// Whether a mesh on which the state is not found again is to be followed by the one that the state needs.
    pub asks_of_state: bool,
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

    fn find(&mut self, mesh: Mesh, best: Option<&Round>) -> Result<Round, Failure> {
        self.rounds += 1;
        let (structure, steps) = discretize(self.model, &mesh);
        if self.request.question == Question::Modes {
            let massless = modes::massless(&structure);
            if !massless.is_empty() {
                return Err(Failure::Massless(massless));
            }
        }
        let (history, values) = match self.solve(&structure, &steps, &mesh, best) {
            Ok(found) => found,
            Err(Failure::NoModes(NoModes::NotFound) | Failure::NoFactors(NoFactors::NotFound))
                if best.is_some_and(|best| best.values.is_some()) =>
            {
                // Rounding of so fine a mesh hides what the one before told.
                return Ok(Round { stalls: STALLS, ..Round::lost(mesh, None) });
            }
            Err(Failure::NoModes(_) | Failure::NoFactors(_)) if best.is_some_and(|best| best.worst < NEAR) => {
                // So fine a mesh that rounding leaves nothing: what is known stays.
                return Ok(Round { stalls: STALLS, ..Round::lost(mesh, None) });
            }
            Err(
                failure @ (Failure::NoModes(NoModes::NotSettled | NoModes::NotFound)
                | Failure::NoFactors(NoFactors::NotSettled | NoFactors::NotFound)),
            ) => {
                let asks = std::mem::take(&mut self.asks_of_state);
                let next = if asks { self.mesh_of_state(&mesh) } else { None };
                if next.is_some() {
                    self.lost = 0;
                }
                if next.is_some() || self.is_lost(&mesh) {
                    return Ok(Round::lost(mesh, next));
                }
                return Err(failure);
            }
            Err(Failure::NoFactors(NoFactors::Unstable(_) | NoFactors::Neutral)) if self.is_lost(&mesh) => {
                return Ok(Round::lost(mesh, None));
            }
            Err(failure) => return Err(failure),
        };
        let worst = match &values {
            Some(values) => {
                // Of a vibration that elements of the lower order do not have, nothing is known.
                let unknown = if self.request.question == Question::Modes { 1.0 } else { 0.0 };
                values.entries.iter().map(|entry| entry.error.unwrap_or(unknown)).fold(0.0, f64::max)
            }
            None if history.steps.iter().any(|step| step.status == Status::Interrupted) => {
                return Err(Failure::Interrupted);
            }
            // A path that ends early may do so for want of elements.
            None if self.is_lost(&mesh) => f64::INFINITY,
            None => return Err(Failure::NotSolved(Box::new(history))),
        };
        // All nodes of all elements take part, and rounding grows with the fourth power of their number.
        // What elements lack that the file forces, no finer ones beside them make up for, however large it is.
        let may_stall = |before: &Round| before.worst < NEAR || Mesh::is_forced(self.model);
        let stalled = best.is_some_and(|before| may_stall(before) && worst > STALLED * before.worst);
        // Nor does a finer mesh take away what rounding makes, or tell a response that is not known.
        let by_rounding = |values: &Values| worst > self.request.accuracy && values.rounding >= worst;
        let stalled = stalled || values.as_ref().is_some_and(by_rounding);
        self.stalls = if stalled { self.stalls + 1 } else { 0 };
        Ok(Round { mesh, values, worst, stalls: self.stalls, next: None })
    }

    fn judge(&self, found: &Round, _: Option<&Round>, rounds: usize) -> Next<()> {
        let Round { mesh, values, worst, stalls, next } = found;
        let (model, accuracy) = (self.model, self.request.accuracy);
        let Some(values) = values else {
            let next = || next.clone().unwrap_or_else(|| shortened(model, mesh, 2));
            return if *stalls < STALLS { Next::Refine(next()) } else { Next::End(()) };
        };
        let order = mesh.lowest_order(model) + values.raised;
        let finer = shortened(model, mesh, refinement_factor(values.left * worst / accuracy, order));
        let goes_on = *worst > accuracy && rounds < MAX_ROUNDS && *stalls < STALLS && finer != *mesh;
        if goes_on { Next::Refine(finer) } else { Next::End(()) }
    }

    fn is_better(&self, found: &Round, best: &Round, _: &Next<()>) -> bool {
        !(best.worst < found.worst)
    }
}

impl Search<'_> {
    /// The mesh that the state needs, with short elements where members bend over short lengths; nothing where that is no other
    /// one than this.
    fn mesh_of_state(&mut self, mesh: &Mesh) -> Option<Mesh> {
        let options = Options { estimate: true, ..self.options.clone() };
        let solution = solve_to_accuracy(self.model.clone(), self.request.accuracy, &options, self.observe).ok()?;
        let other = with_orders_beyond(solution.mesh, self.request.question);
        (other != *mesh).then_some(other)
    }

    /// Whether a mesh on which there is no answer is too coarse, as far as can be told.
    fn is_lost(&mut self, mesh: &Mesh) -> bool {
        self.lost += 1;
        self.lost < MAX_LOST && shortened(self.model, mesh, 2) != *mesh
    }

    /// The history of a mesh, and the values where the state was reached.
    fn solve(
        &mut self,
        structure: &Structure,
        steps: &[Step],
        mesh: &Mesh,
        best: Option<&Round>,
    ) -> Result<(History, Option<Values>), Failure> {
        let (Where { count, ramp }, wanted) = (self.place, self.request.count);
        let (order, accuracy) = (mesh.lowest_order(self.model), self.request.accuracy);
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
                let before = best.and_then(|best| Some((best.values.as_ref()?, &best.mesh)));
                let may_follow = self.rounds < MAX_ROUNDS && shortened(self.model, mesh, 2) != *mesh;
                let judged = Judged::new(ramp, accuracy, (mesh, order), before, may_follow);
                let are_enough = |levels: &[Buckling]| judged.is_enough(levels);
                let near = before.map(|(values, _)| &values.near);
                let asked = Asked { count: wanted, near, are_enough: &are_enough };
                let found = buckling::buckle(structure, steps, ramp, &asked, self.options, self.observe);
                let Found { history, result } = found.map_err(mechanism)?;
                match result {
                    Ok(levels) => {
                        let values = Values::of_buckling(structure, &judged, levels);
                        Ok((history, Some(values)))
                    }
                    Err(NoFactors::NotReached) => Ok((history, None)),
                    Err(why) => Err(Failure::NoFactors(why)),
                }
            }
        }
    }
}
