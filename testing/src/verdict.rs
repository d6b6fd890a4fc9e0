//! The verdict on a state's stability, held against the lowest mode of vibration about it.

use std::sync::Arc;

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_models::{Model, discretize};
use pennate_solver::history::{Note, Status, StepHistory};
use pennate_solver::modes::{self, NoModes};
use pennate_solver::options::Options;
use pennate_solver::structure::{Drive, SectionLaw, SectionState, Step, Structure};

/// Mass per length of members that have none: the sign of an eigenvalue does not depend on it.
const MASS: f64 = 1e-6;

/// Modes that are looked at, and part of the highest of their eigenvalues below which the lowest one is rounding: a column
/// that has buckled in one of all planes turns freely.
const MODES: usize = 4;
const NEUTRAL: f64 = 1e-6;

/// What the modes say of a verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// Both orders of elements agree with it, or one of them finds a motion without stiffness.
    Confirmed,
    /// The lowest eigenvalues ω² on both orders (1/s²) have the other sign.
    Contradicted([f64; 2]),
    /// There are no modes about the state.
    Unknown,
}

/// The verdicts on the steps of a network.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdicts {
    /// How many were confirmed.
    pub confirmed: usize,
    /// Those that were contradicted: number of the step from 0, whether it was called stable, and the lowest eigenvalues ω² on
    /// both orders (1/s²).
    pub contradicted: Vec<(usize, bool, [f64; 2])>,
}

/// Whether a verdict is one on bars that are kept from turning about themselves, as they are where modes are looked for, too.
pub fn is_on_spins(step: &StepHistory) -> bool {
    step.notes.iter().any(|note| matches!(note, Note::WouldTurn { .. }))
}

/// Solves a network to 1e-6, and holds the verdict on every step against the lowest mode at its end; up to the first step that
/// did not converge or has no verdict that modes can tell.
pub fn verdicts(model: Model) -> Verdicts {
    let options = Options { estimate: true, ..Options::default() };
    let mut verdicts = Verdicts::default();
    let Ok(solution) = solve_to_accuracy(model, 1e-6, &options, &mut |_| true) else { return verdicts };
    let (structure, steps) = discretize(&solution.model, &solution.mesh);
    for (index, step) in solution.history.steps.iter().enumerate() {
        let (Status::Converged, Some(stable), true) = (step.status, step.stable, index < steps.len()) else { break };
        if is_on_spins(step) {
            break;
        }
        match confirm(&structure, &steps, index + 1, stable) {
            Verdict::Confirmed => verdicts.confirmed += 1,
            Verdict::Contradicted(lowest) => verdicts.contradicted.push((index, stable, lowest)),
            Verdict::Unknown => {}
        }
    }
    verdicts
}

/// Holds the verdict on the end of the first `count` steps against the lowest mode there, on the elements of the structure
/// and on those of the next order.
pub fn confirm(structure: &Structure, steps: &[Step], count: usize, stable: bool) -> Verdict {
    let weighs = structure.drives.iter().any(|drive| matches!(drive, Drive::Gravity(_)));
    let massless = modes::massless(structure);
    let mut structure = structure.clone();
    if !massless.is_empty() {
        if weighs {
            return Verdict::Unknown;
        }
        structure.laws =
            structure.laws.iter().map(|law| Arc::new(Weighed(Arc::clone(law))) as Arc<dyn SectionLaw>).collect();
    }
    let options = Options::default();
    let Ok(found) = modes::modes(&structure, steps, count, MODES, &options, &mut |_| true) else {
        return Verdict::Unknown;
    };
    let lowest = match found.result {
        Ok(pair) => pair.map(|modes| {
            let values = modes.modes.iter().map(|mode| mode.eigenvalue);
            let scale = values.clone().map(f64::abs).fold(0.0, f64::max);
            values.reduce(f64::min).map(|lowest| if lowest.abs() <= NEUTRAL * scale { 0.0 } else { lowest })
        }),
        Err(
            NoModes::NotReached | NoModes::NotSettled | NoModes::NoPotential | NoModes::Singular | NoModes::NotFound,
        ) => {
            return Verdict::Unknown;
        }
    };
    match lowest {
        [Some(coarse), Some(fine)] => {
            let against = |value: f64| if stable { value < 0.0 } else { value > 0.0 };
            if against(coarse) && against(fine) { Verdict::Contradicted([coarse, fine]) } else { Verdict::Confirmed }
        }
        _ => Verdict::Unknown,
    }
}

/// A law whose sections have a mass.
#[derive(Debug)]
struct Weighed(Arc<dyn SectionLaw>);

impl SectionLaw for Weighed {
    fn at(&self, control: f64) -> SectionState {
        let mut state = self.0.at(control);
        state.section.mass_per_length = state.section.mass_per_length.max(MASS);
        state
    }
}
