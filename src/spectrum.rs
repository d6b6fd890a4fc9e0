//! Vibration and buckling about a converged state: `pennate modes` and `pennate buckle`.
//!
//! Both are eigenvalue problems of the whole network. They are solved on the elements of a mesh and on those of the next
//! order; what differs there is the error of the mesh, and the mesh is refined until that is as small as asked for. What is
//! reported is of the higher order.

use std::time::Instant;

use pennate_models::{InputError, InputErrors, Mesh, Model, discretize};
use pennate_solver::buckling::{self, Buckling, NoFactors, Ramp};
use pennate_solver::error::SolveError;
use pennate_solver::history::History;
use pennate_solver::modes::{self, Found, Modes, NoModes, Place};
use pennate_solver::options::{Options, Progress};
use pennate_solver::spectral::shape::{Largest, Shape};
use pennate_solver::spectral::unknowns::Family;
use pennate_solver::structure::{Dimension, Stability, Step, Structure};

use crate::accuracy::{capped, refinement_factor};
use crate::diagnostics::Message;
use crate::output::text::{list, shown};
use crate::solution::{Timing, diagonal};
use crate::{Input, Refusal, read};

/// Meshes that are tried at most.
const MAX_ROUNDS: usize = 6;
/// A finer mesh whose error is larger than this part of the one before ends the search,
const STALLED: f64 = 0.5;
/// if that was smaller than this.
const NEAR: f64 = 1e-3;
/// An eigenvalue counts as no smaller than this part of the largest wanted, when errors are judged.
const SMALLEST: f64 = 1e-9;

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
pub struct Job {
    pub input: Input,
    pub question: Question,
    /// The step at whose end the state is; the last where nothing is said.
    pub step: Option<String>,
    /// Of buckling: the step whose ramp the factor multiplies.
    pub along: Option<String>,
    /// How many modes.
    pub count: usize,
    /// Error asked for, relative to each value.
    pub accuracy: f64,
    pub threads: Option<usize>,
}

/// One mode with its value.
#[derive(Clone, Debug)]
pub struct Entry {
    /// ω² of a vibration, in 1/s²; the factor of a ramp.
    pub value: f64,
    /// Estimated discretization error of the frequency or factor, relative to it.
    pub error: Option<f64>,
    pub family: Family,
    pub shape: Shape,
    pub largest: Largest,
}

/// What was asked for, ready to be written.
#[derive(Debug)]
pub struct Spectrum {
    pub model: Model,
    pub question: Question,
    pub mesh: Mesh,
    /// Name of the step at whose end the state is; nothing for the unloaded network.
    pub step: Option<String>,
    /// Name of the step that the factor multiplies; nothing where it multiplies the present loads.
    pub along: Option<String>,
    pub entries: Vec<Entry>,
    /// Of buckling: the nearest factor of the ramp the other way.
    pub reversed: Option<f64>,
    pub place: Place,
    /// Remarks, one sentence each.
    pub notes: Vec<String>,
    pub unknowns: usize,
    pub accuracy: f64,
    pub timing: Timing,
}

/// Why there is no answer.
#[derive(Debug)]
pub enum NoSpectrum {
    /// The input is wrong, or asks for what it does not have.
    Refused(Refusal),
    /// A step did not reach its end.
    NotSolved(Box<Model>, Box<History>),
    /// The user did not want to wait.
    Interrupted,
    /// The state has no answer to give.
    Failed(Box<Message>),
}

/// The state and the ramp that a job names, by index.
#[derive(Clone, Copy, Debug)]
struct Where {
    /// Steps that are solved.
    count: usize,
    ramp: Ramp,
}

/// Answers a question; `observe` hears of every accepted increment and may stop the solve.
///
/// # Errors
/// [`NoSpectrum`] says why there is no answer.
pub fn run(job: &Job, observe: &mut dyn FnMut(&Progress) -> bool) -> Result<Spectrum, NoSpectrum> {
    let start = Instant::now();
    let refuse = |errors| NoSpectrum::Refused(Refusal::Input(errors));
    let model = read(&job.input).map_err(refuse)?;
    let place = Where::of(job, &model).map_err(|error| refuse(*error))?;
    let threads = job.threads.unwrap_or(1);
    if threads > 1 {
        // A pool that another run in this process has made serves as well.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    }
    let options = Options { threads, ..Options::default() };
    let mut timing = Timing { read: start.elapsed(), ..Timing::default() };
    let start = Instant::now();
    let mut mesh = Mesh::initial(&model, job.accuracy);
    let mut best: Option<(Mesh, Values, f64)> = None;
    for round in 1.. {
        let (structure, steps) = discretize(&model, &mesh);
        if job.question == Question::Modes {
            check_mass(&model, &structure).map_err(|error| refuse(*error))?;
        }
        let outcome = solve(job, place, (&structure, &steps), &options, observe);
        let (history, answer) = match outcome {
            Ok(outcome) => outcome,
            Err(SolveError::Mechanism(motions)) => {
                return Err(NoSpectrum::Refused(Refusal::Mechanism(Box::new(model), motions)));
            }
        };
        let may_refine = round < MAX_ROUNDS;
        let answer = match answer {
            Answer::Found(answer) => answer,
            // A path that ends early may do so for want of elements.
            Answer::NotReached if may_refine && round < 3 && !interrupted(&history) => {
                let finer = refined(&mesh, &model, 2);
                if finer != mesh {
                    mesh = finer;
                    continue;
                }
                return Err(NoSpectrum::NotSolved(Box::new(model), Box::new(history)));
            }
            Answer::NotReached if interrupted(&history) => return Err(NoSpectrum::Interrupted),
            Answer::NotReached => return Err(NoSpectrum::NotSolved(Box::new(model), Box::new(history))),
            Answer::None(message) => return Err(NoSpectrum::Failed(message)),
        };
        let worst = answer.entries.iter().filter_map(|entry| entry.error).fold(0.0, f64::max);
        // All nodes of all elements take part, and rounding grows with the fourth power of their number.
        let stalled = best.as_ref().is_some_and(|before| before.2 < NEAR && worst > STALLED * before.2);
        let finer = refined(&mesh, &model, refinement_factor(worst / job.accuracy, mesh.lowest_order(&model)));
        let goes_on = worst > job.accuracy && may_refine && !stalled && finer != mesh;
        // Whatever comes last, the best is handed out.
        let (mesh_here, answer, worst) = match best.take() {
            Some(before) if before.2 < worst => before,
            _ => (std::mem::replace(&mut mesh, finer.clone()), answer, worst),
        };
        if goes_on {
            best = Some((mesh_here, answer, worst));
            mesh = finer;
            continue;
        }
        timing.solve = start.elapsed();
        return Ok(finish(job, model, mesh_here, place, answer, worst, timing));
    }
    unreachable!("the number of rounds is bounded")
}

fn refined(mesh: &Mesh, model: &Model, factor: usize) -> Mesh {
    let factors: Vec<usize> = mesh.refinement.iter().map(|segments| capped(factor, segments)).collect();
    mesh.refined(model, &factors)
}

fn interrupted(history: &History) -> bool {
    history.steps.iter().any(|step| step.status == pennate_solver::history::Status::Interrupted)
}

fn finish(job: &Job, model: Model, mesh: Mesh, place: Where, answer: Values, worst: f64, timing: Timing) -> Spectrum {
    let names = model.step_names();
    let name = |index: usize| names.get(index).map(|name| (*name).to_owned());
    let step = match place.count {
        0 if model.steps.is_empty() => name(0),
        0 => None,
        count => name(count - 1),
    };
    let along = match (job.question, place.ramp) {
        (Question::Buckling, Ramp::Of(index)) => name(index),
        _ => None,
    };
    let mut notes = answer.notes;
    if worst > job.accuracy {
        notes.push(format!(
            "the estimated error is more than the {:.1e} asked for, and a finer mesh would not make it less",
            job.accuracy
        ));
    }
    Spectrum {
        question: job.question,
        mesh,
        step,
        along,
        entries: answer.entries,
        reversed: answer.reversed,
        place: answer.place,
        notes,
        unknowns: answer.unknowns,
        accuracy: job.accuracy,
        timing,
        model,
    }
}

impl Where {
    fn of(job: &Job, model: &Model) -> Result<Self, Box<InputErrors>> {
        let names = model.step_names();
        let find = |name: &Option<String>| match name {
            None => Ok(None),
            Some(name) => match names.iter().position(|known| known == name) {
                Some(index) => Ok(Some(index)),
                None => {
                    let known: Vec<String> = names.iter().map(|name| format!("'{}'", shown(name))).collect();
                    let error = InputError::new(format!("the network has no step '{}'", shown(name)))
                        .help(format!("its steps are {}", list(&known, 12)));
                    Err(Box::new(InputErrors { errors: vec![error], sources: model.sources.clone() }))
                }
            },
        };
        let (step, along) = (find(&job.step)?, find(&job.along)?);
        let last = model.steps.len().saturating_sub(1);
        let end_of = |index: usize| if model.steps.is_empty() { 0 } else { index + 1 };
        Ok(match (job.question, step, along) {
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

/// Every member must have a mass: one without would move as if it were not there.
fn check_mass(model: &Model, structure: &Structure) -> Result<(), Box<InputErrors>> {
    let errors: Vec<InputError> = modes::massless(structure)
        .into_iter()
        .map(|index| {
            let member = &model.members[index];
            InputError::new(format!("member '{}' has no mass, or a part without mass", shown(&member.name)))
                .at(member.span)
                .help("give its material or muscle a density, or its stiffness a mass_per_length (tiny, if it is to be left out)")
        })
        .collect();
    if errors.is_empty() { Ok(()) } else { Err(Box::new(InputErrors { errors, sources: model.sources.clone() })) }
}

/// What a mesh and the next order say.
enum Answer {
    Found(Values),
    NotReached,
    None(Box<Message>),
}

#[derive(Debug, Default)]
struct Values {
    entries: Vec<Entry>,
    reversed: Option<f64>,
    place: Place,
    notes: Vec<String>,
    unknowns: usize,
}

fn solve(
    job: &Job,
    place: Where,
    (structure, steps): (&Structure, &[Step]),
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Result<(History, Answer), SolveError> {
    match job.question {
        Question::Modes => {
            let Found { history, result } = modes::modes(structure, steps, place.count, job.count, options, observe)?;
            let answer = match result {
                Ok(levels) => Answer::Found(Values::of_modes(structure, levels)),
                Err(NoModes::NotReached) => Answer::NotReached,
                Err(why) => Answer::None(Box::new(no_modes(why))),
            };
            Ok((history, answer))
        }
        Question::Buckling => {
            let Found { history, result } =
                buckling::buckle(structure, steps, place.ramp, job.count, options, observe)?;
            let answer = match result {
                Ok(levels) => Answer::Found(Values::of_buckling(structure, place.ramp, levels)),
                Err(NoFactors::NotReached) => Answer::NotReached,
                Err(why) => Answer::None(Box::new(no_factors(why))),
            };
            Ok((history, answer))
        }
    }
}

impl Values {
    fn of_modes(structure: &Structure, [coarse, fine]: [Modes; 2]) -> Self {
        let size = diagonal(structure.nodes.iter().copied());
        let scale = fine.modes.iter().fold(0.0f64, |scale, mode| scale.max(mode.eigenvalue.abs()));
        let mut coarse_values = coarse.modes.iter().map(|mode| mode.eigenvalue);
        let entries: Vec<Entry> = fine
            .modes
            .into_iter()
            .map(|mode| {
                let value = mode.eigenvalue;
                // The frequency is the root: half the relative error of its square.
                let relative = |coarse: f64| 0.5 * (coarse - value).abs() / value.abs().max(SMALLEST * scale);
                let error = coarse_values.next().map(|coarse| {
                    let error = if coarse == value { 0.0 } else { relative(coarse) };
                    error.max(0.5 * mode.rounding)
                });
                Entry { value, error, family: mode.family, largest: mode.shape.largest(size), shape: mode.shape }
            })
            .collect();
        let mut notes = Vec::new();
        let unstable = entries.iter().filter(|entry| entry.value < 0.0).count();
        if unstable > 0 {
            notes.push(format!(
                "the state is unstable in {unstable} of these motions: their eigenvalue is negative and no frequency"
            ));
        }
        if entries.iter().any(|entry| entry.value == 0.0) {
            notes.push("a motion of frequency zero has no stiffness: the state is neutral in it".to_owned());
        }
        notes.extend(remarks(structure, &fine.left_out, fine.reach, fine.complete));
        Self { entries, reversed: None, place: fine.place, notes, unknowns: fine.unknowns }
    }

    fn of_buckling(structure: &Structure, ramp: Ramp, [coarse, fine]: [Buckling; 2]) -> Self {
        let size = diagonal(structure.nodes.iter().copied());
        // Of loads that are present once a factor counts from nothing.
        let present = if let Ramp::Present(_) = ramp { 1.0 } else { 0.0 };
        let none = fine.critical.is_empty();
        let mut coarse_values = coarse.critical.iter().map(|critical| critical.factor);
        let entries = fine
            .critical
            .into_iter()
            .map(|critical| {
                let value = critical.factor + present;
                let error = coarse_values
                    .next()
                    .map(|coarse| ((coarse - critical.factor).abs() / value).max(critical.rounding));
                Entry {
                    value,
                    error,
                    family: critical.family,
                    largest: critical.shape.largest(size),
                    shape: critical.shape,
                }
            })
            .collect();
        let mut notes = remarks(structure, &fine.left_out, fine.reach, fine.complete);
        if let Some(&family) = fine.neutral.first() {
            let side = if family == Family::OutOfPlane { "out of the plane" } else { "in the plane" };
            notes.push(format!("the state is neutral {side}: motions there are left out"));
        }
        if none {
            notes.push("no critical factor was found: the ramp does not soften the network".to_owned());
        }
        let reversed = fine.reversed.map(|factor| factor + present);
        Self { entries, reversed, place: fine.place, notes, unknowns: fine.unknowns }
    }
}

fn remarks(
    structure: &Structure,
    left_out: &[Family],
    reach: pennate_solver::base::Reach,
    complete: bool,
) -> Vec<String> {
    let mut notes = Vec::new();
    if structure.dimension == Dimension::Plane && reach == pennate_solver::base::Reach::InPlane {
        let why = match structure.stability {
            Stability::Plane => "out of it the file gives the network no stiffness, or asks for the plane",
            Stability::Space => "the supports do not hold the network out of it",
        };
        notes.push(format!("motions in the plane alone: {why}"));
    }
    if left_out.contains(&Family::OutOfPlane) {
        notes.push("motions in the plane alone: out of it the loads have no potential".to_owned());
    }
    if left_out.contains(&Family::InPlane) {
        notes.push("motions out of the plane alone: in it the loads have no potential".to_owned());
    }
    if !complete {
        notes.push("the count of pivots does not confirm that none is missing between these".to_owned());
    }
    notes
}

fn no_modes(why: NoModes) -> Message {
    match why {
        NoModes::NoPotential => no_potential(),
        NoModes::Singular => Message {
            title: "the stiffness is singular in motions that have no mass".to_owned(),
            help: Some(
                "give the members that move freely a rotatory inertia (a material with a density), or hold them"
                    .to_owned(),
            ),
            ..Message::default()
        },
        NoModes::NotSettled | NoModes::NotReached => not_settled(),
    }
}

fn no_factors(why: NoFactors) -> Message {
    let message = |title: &str, help: &str| Message {
        title: title.to_owned(),
        help: Some(help.to_owned()),
        ..Message::default()
    };
    match why {
        NoFactors::NoPotential => no_potential(),
        NoFactors::Unstable(count) => message(
            &format!("the state is unstable already, in {count} motion{}", if count == 1 { "" } else { "s" }),
            "ask about an earlier state: --step NAME, or --along NAME for the beginning of a step",
        ),
        NoFactors::Neutral => message(
            "the state is neutral: a motion has no stiffness, and any factor is critical",
            "ask about a state in which the network is held or prestressed: --step NAME, or --along NAME",
        ),
        NoFactors::NothingMoves => message(
            "nothing is loaded, inflated or moved by the ramp: there is nothing to multiply",
            "name a step with loads, pressures or prescribed motions: --along NAME, or --step NAME for its end",
        ),
        NoFactors::NotSettled | NoFactors::NotReached => not_settled(),
    }
}

fn no_potential() -> Message {
    Message {
        title: "the loads have no potential: the tangent is unsymmetric, and its modes are not natural modes"
            .to_owned(),
        notes: vec!["follower loads, and dead moments on nodes that turn in space, are such loads".to_owned()],
        help: Some("apply dead forces, prescribed motions or pressures in their place".to_owned()),
        ..Message::default()
    }
}

fn not_settled() -> Message {
    Message {
        title: "the state is not found again on the elements that its modes are computed with".to_owned(),
        help: Some("give the members more elements (elements = 8)".to_owned()),
        ..Message::default()
    }
}
