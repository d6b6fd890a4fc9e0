//! Vibration and buckling about a converged state.
//!
//! Both are eigenvalue problems of the whole network. They are solved on the elements of a mesh and on those of the next
//! order; what differs there is the error of the mesh, and the mesh is refined until that is as small as asked for. What is
//! reported is of the higher order.

mod place;
mod search;
mod values;

use pennate_models::model::MemberId;
use pennate_models::{Mesh, Model};
use pennate_solver::buckling::{self, NoFactors, Ramp};
use pennate_solver::error::FreeMotion;
use pennate_solver::history::History;
use pennate_solver::modes::{NoModes, Place};
use pennate_solver::options::{Options, Progress};
use pennate_solver::packs;
use pennate_solver::spectral::shape::{Largest, Shape};
use pennate_solver::spectral::unknowns::Family;

use self::place::Where;
use self::search::{Round, Search};
use self::values::Values;
use crate::adapt::{Adapted, adapt};
use crate::solution::Timing;

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// Natural frequencies and modes.
    Modes,
    /// Critical factors of a ramp.
    Buckling,
}

/// What to compute about which state.
#[derive(Clone, Debug)]
pub struct Request {
    /// What is asked for.
    pub question: Question,
    /// The step at whose end the state is; the last where nothing is said.
    pub step: Option<String>,
    /// Of buckling: the step whose ramp the factor multiplies.
    pub along: Option<String>,
    /// How many modes.
    pub count: usize,
    /// Error asked for, relative to each value.
    pub accuracy: f64,
}

/// One mode with its value.
#[derive(Clone, Debug)]
pub struct Entry {
    /// ω² of a vibration, in 1/s²; the factor of a ramp.
    pub value: f64,
    /// Estimated discretization error of the frequency or factor, relative to it.
    pub error: Option<f64>,
    /// Whether the motion is in space, in the plane or out of it.
    pub family: Family,
    /// The motion, of modal mass 1 for a vibration, with a largest component of 1 for buckling.
    pub shape: Shape,
    /// Where it is largest.
    pub largest: Largest,
}

/// The nearest factor of a ramp the other way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reversed {
    /// The factor.
    pub value: f64,
    /// Estimated discretization error, relative to it; nothing where it is not found on elements of other orders.
    pub error: Option<f64>,
}

/// What was asked for, ready to be written.
#[derive(Debug)]
pub struct Spectrum {
    /// The network.
    pub model: Model,
    /// What was asked for.
    pub question: Question,
    /// The mesh; what is reported is of the next order on it.
    pub mesh: Mesh,
    /// Name of the step at whose end the state is; nothing for the unloaded network.
    pub step: Option<String>,
    /// Name of the step that the factor multiplies; nothing where it multiplies the present loads.
    pub along: Option<String>,
    /// The modes, by their values.
    pub entries: Vec<Entry>,
    /// Of buckling: the nearest factor of the ramp the other way.
    pub reversed: Option<Reversed>,
    /// The state itself.
    pub place: Place,
    /// What a reader must know besides.
    pub notes: Vec<Note>,
    /// Unknowns of the eigenvalue problem.
    pub unknowns: usize,
    /// Error that was asked for.
    pub accuracy: f64,
    /// What it took; all of it counts as solving.
    pub timing: Timing,
}

/// What a reader of a spectrum must know besides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Note {
    /// So many of the vibrations have a negative eigenvalue: the state is unstable in them.
    Unstable(usize),
    /// A vibration has the frequency zero.
    NoStiffness,
    /// Motions in the plane alone: out of it the file gives no stiffness, or asks for the plane.
    PlaneOnly,
    /// Motions in the plane alone: the supports do not hold the network out of it.
    NotHeldOutOfPlane,
    /// Motions of this family are left out: the loads have no potential there.
    NoPotential(Family),
    /// The count of pivots does not confirm that no mode is missing between these.
    MayMiss,
    /// Motions of this family are left out of buckling: the state is neutral there.
    Neutral(Family),
    /// The ramp does not soften the network.
    NothingCritical,
    /// The estimated error is more than this, which was asked for, and a finer mesh would not make it less.
    LessAccurate(f64),
}

/// Why there is no answer.
#[derive(Debug)]
pub enum NoSpectrum {
    /// The network has no step of this name.
    NoStep(Box<Model>, String),
    /// These members have no mass, or a part without mass: they would move as if they were not there.
    Massless(Box<Model>, Vec<MemberId>),
    /// The unloaded network can move without force.
    Mechanism(Box<Model>, Vec<FreeMotion>),
    /// A step did not reach its end.
    NotSolved(Box<Model>, Box<History>),
    /// The user did not want to wait.
    Interrupted,
    /// The state has no modes.
    NoModes(NoModes),
    /// The state has no critical factors.
    NoFactors(NoFactors),
}

/// Answers a question about a network; `observe` hears of every accepted increment, and stops the solve where it says
/// false.
///
/// # Errors
/// [`NoSpectrum`] says why there is no answer.
pub fn solve(
    model: Model,
    request: &Request,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Result<Spectrum, NoSpectrum> {
    let place = match Where::of(request, &model) {
        Ok(place) => place,
        Err(unknown) => return Err(NoSpectrum::NoStep(Box::new(model), unknown)),
    };
    let start = (options.clock)();
    let mut search =
        Search { model: &model, request, place, options, observe, rounds: 0, lost: 0, stalls: 0, asks_of_state: true };
    let adapted = adapt(&mut search, first_mesh(&model, request));
    let solve = (options.clock)().saturating_sub(start);
    let timing = Timing { solve, ..Timing::default() };
    match adapted {
        Ok(Adapted { found: Round { mesh, values, worst, .. }, .. }) => {
            Ok(finish(model, request, place, mesh, values.unwrap_or_default(), worst, timing))
        }
        Err(failure) => Err(failure.with(model)),
    }
}

/// The mesh to begin with.
fn first_mesh(model: &Model, request: &Request) -> Mesh {
    with_orders_beyond(Mesh::initial(model, request.accuracy), request.question)
}

/// A mesh of elements with orders enough beyond theirs for what is found on these.
fn with_orders_beyond(mesh: Mesh, question: Question) -> Mesh {
    match question {
        Question::Modes => mesh,
        Question::Buckling => Mesh { order: mesh.order.min(packs::HIGHEST - buckling::MORE_ORDERS), ..mesh },
    }
}

fn finish(
    model: Model,
    request: &Request,
    place: Where,
    mesh: Mesh,
    values: Values,
    worst: f64,
    timing: Timing,
) -> Spectrum {
    let names = model.step_names();
    let name = |index: usize| names.get(index).map(|name| (*name).to_owned());
    let step = match place.count {
        0 if model.steps.is_empty() => name(0),
        0 => None,
        count => name(count - 1),
    };
    let along = match (request.question, place.ramp) {
        (Question::Buckling, Ramp::Of(index)) => name(index),
        _ => None,
    };
    let mut notes = values.notes;
    if worst > request.accuracy {
        notes.push(Note::LessAccurate(request.accuracy));
    }
    Spectrum {
        question: request.question,
        mesh,
        step,
        along,
        entries: values.entries,
        reversed: values.reversed,
        place: values.place,
        notes,
        unknowns: values.unknowns,
        accuracy: request.accuracy,
        timing,
        model,
    }
}
