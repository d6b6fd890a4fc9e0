//! `pennate modes` and `pennate buckle`: the network is read and asked, and what there is instead of an answer is put into
//! words.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use pennate_analysis::spectrum::{self, NoSpectrum, Note, Request, Spectrum};
use pennate_models::{InputError, InputErrors, Model};
use pennate_solver::buckling::NoFactors;
use pennate_solver::modes::NoModes;
use pennate_solver::options::{Options, Progress};
use pennate_solver::spectral::unknowns::Family;

use crate::diagnostics::Message;
use crate::output::text::shown;
use crate::problems::likely;
use crate::{Input, clock, explain, on_threads, options, read};

/// What to compute about which network.
#[derive(Clone, Debug)]
pub struct Job {
    /// The network file.
    pub input: Input,
    /// What is asked for.
    pub request: Request,
    /// Threads to solve on; as many as there are processors by default.
    pub threads: Option<usize>,
}

/// Why there is no answer.
#[derive(Debug)]
pub enum NoAnswer {
    /// The input is wrong, or asks for what it does not have.
    Input(InputErrors),
    /// The state has no such eigenvalues, or was not reached.
    Spectrum(NoSpectrum),
}

/// Reads a network and answers a question about it; `observe` hears of every accepted increment and may stop the solve.
///
/// # Errors
/// [`NoAnswer`] says why there is none.
pub fn run(job: &Job, observe: &mut (dyn FnMut(&Progress) -> bool + Send)) -> Result<Spectrum, NoAnswer> {
    let start = clock();
    let model = read(&job.input).map_err(NoAnswer::Input)?;
    let read = clock().saturating_sub(start);
    let mut spectrum = answer(model, &job.request, job.threads, None, observe)?;
    spectrum.timing.read = read;
    Ok(spectrum)
}

/// Answers a question about a network that was read; given up as soon as `stop` is set.
///
/// # Errors
/// [`NoAnswer`] says why there is no answer.
pub fn answer(
    model: Model,
    request: &Request,
    threads: Option<usize>,
    stop: Option<Arc<AtomicBool>>,
    observe: &mut (dyn FnMut(&Progress) -> bool + Send),
) -> Result<Spectrum, NoAnswer> {
    let solve = |threads| spectrum::solve(model, request, &Options { stop, ..options(threads) }, observe);
    on_threads(threads, solve).map_err(refused)
}

/// What the input is to blame for, with its place.
fn refused(why: NoSpectrum) -> NoAnswer {
    match why {
        NoSpectrum::NoStep(model, name) => {
            let known: Vec<String> = model.step_names().into_iter().map(str::to_owned).collect();
            let error = InputError::new(format!("the network has no step '{}'", shown(&name)))
                .help(likely(&name, &known, "steps"))
                .about(name);
            NoAnswer::Input(InputErrors { errors: vec![error], sources: model.sources })
        }
        NoSpectrum::Massless(model, members) => {
            let errors = members.into_iter().map(|member| massless(&model, member)).collect();
            NoAnswer::Input(InputErrors { errors, sources: model.sources })
        }
        other => NoAnswer::Spectrum(other),
    }
}

fn massless(model: &Model, member: usize) -> InputError {
    let member = &model.members[member];
    InputError::new(format!("member '{}' has no mass, or a part without mass", shown(&member.name)))
        .at(member.span)
        .help(
            "give its material or muscle a density, or its stiffness a mass_per_length (tiny, if it is to be left out)",
        )
}

/// Why a spectrum was not found, where it is not the input that is to blame.
pub fn messages(why: NoSpectrum) -> Vec<Message> {
    match why {
        NoSpectrum::NoModes(why) => vec![no_modes(why)],
        NoSpectrum::NoFactors(why) => vec![no_factors(why)],
        NoSpectrum::NotSolved(model, history) => explain::failed_steps(&model, &history.steps).collect(),
        NoSpectrum::NoStep(..) | NoSpectrum::Massless(..) | NoSpectrum::Mechanism(..) | NoSpectrum::Interrupted => {
            Vec::new()
        }
    }
}

/// A note as one sentence without a full stop.
pub fn note(note: &Note) -> String {
    match *note {
        Note::Unstable(count) => {
            format!("the state is unstable in {count} of these motions: their eigenvalue is negative and no frequency")
        }
        Note::NoStiffness => "a motion of frequency zero has no stiffness: the state is neutral in it".to_owned(),
        Note::PlaneOnly => {
            "motions in the plane alone: out of it the file gives the network no stiffness, or asks for the plane"
                .to_owned()
        }
        Note::NotHeldOutOfPlane => {
            "motions in the plane alone: the supports do not hold the network out of it".to_owned()
        }
        Note::NoPotential(Family::OutOfPlane) => {
            "motions in the plane alone: out of it the loads have no potential".to_owned()
        }
        Note::NoPotential(_) => "motions out of the plane alone: in it the loads have no potential".to_owned(),
        Note::MayMiss => "the count of pivots does not confirm that none is missing between these".to_owned(),
        Note::Neutral(family) => {
            let side = if family == Family::OutOfPlane { "out of the plane" } else { "in the plane" };
            format!("the state is neutral {side}: motions there are left out")
        }
        Note::NothingCritical => "no critical factor was found: the ramp does not soften the network".to_owned(),
        Note::LessAccurate(asked) => {
            format!(
                "the estimated error is more than the {asked:.1e} asked for, and a finer mesh would not make it less"
            )
        }
    }
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
        NoModes::NotFound => not_found("mode"),
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
        NoFactors::NotFound => not_found("critical factor"),
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

fn not_found(what: &str) -> Message {
    Message {
        title: format!("no {what} is found: rounding hides all motions that the members allow"),
        notes: vec![
            "the stiffness of the network is too far apart, that of members or that of what cannot be stretched"
                .to_owned(),
        ],
        help: Some("give what is all but rigid less stiffness, or make a rigid body of it".to_owned()),
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
