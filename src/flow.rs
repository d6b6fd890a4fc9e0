//! `pennate flow`: the network is read, and why there is no load flow is put into words.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use pennate_analysis::flow::{self, End, Flow, NoFlow};
use pennate_models::model::Requirement;
use pennate_models::{Document, InputError, InputErrors, Model};
use pennate_solver::options::{Options, Progress};

use crate::output::text::{list, number, shown};
use crate::{Input, Refusal, on_threads, options};

/// Why there is no load flow.
#[derive(Debug)]
pub enum NoAnswer {
    /// The input is wrong, or asks for what it does not have.
    Refused(Refusal),
    /// The user did not want to wait.
    Interrupted,
}

/// The document of an input.
///
/// # Errors
/// A file that cannot be read.
pub fn document(input: &Input) -> Result<Document, InputErrors> {
    if input.file != Path::new("-") {
        return Document::open(&input.file);
    }
    match pennate_models::file::read_from(std::io::stdin().lock()) {
        Ok(text) => Ok(Document::from_text("<stdin>", &text)),
        Err(error) => {
            let error = InputError::new(format!("standard input cannot be read: {error}"));
            Err(InputErrors { errors: vec![error], sources: Vec::new() })
        }
    }
}

/// The load flow of a network, with some parameters set; given up as soon as `stop` is set.
///
/// # Errors
/// [`NoAnswer`] says why there is none.
pub fn answer(
    document: &Document,
    settings: &[(String, String)],
    threads: Option<usize>,
    stop: Option<Arc<AtomicBool>>,
    observe: &mut (dyn FnMut(&Progress) -> bool + Send),
) -> Result<Flow, NoAnswer> {
    let found =
        on_threads(threads, |threads| flow::flow(document, settings, &Options { stop, ..options(threads) }, observe));
    found.map_err(refused)
}

/// What the input is to blame for, with its place.
fn refused(why: NoFlow) -> NoAnswer {
    fn node(model: &Model, node: usize) -> String {
        shown(&model.nodes[node].name)
    }
    let input = |model: Model, error: InputError| {
        let span = model.load_flow.as_ref().map(|flow| flow.span);
        let error = span.into_iter().fold(error, InputError::at);
        NoAnswer::Refused(Refusal::Input(InputErrors { errors: vec![error], sources: model.sources }))
    };
    match why {
        NoFlow::Input(errors) => NoAnswer::Refused(Refusal::Input(errors)),
        NoFlow::Interrupted => NoAnswer::Interrupted,
        NoFlow::Mechanism(model, motions) => NoAnswer::Refused(Refusal::Mechanism(model, motions)),
        NoFlow::NotAsked(model) => {
            let error = InputError::new("the network does not say where it is driven and what it moves");
            let help = "add [load_flow] with input = { node = \"I\", direction = [1, 0] } and outputs = [\"O\"]";
            input(*model, error.help(help))
        }
        NoFlow::InputHeld(model, held) => {
            let title = format!("the load at input '{}' moves nothing", node(&model, held));
            input(*model, InputError::new(title).help("give it a direction in which the mechanism can move"))
        }
        NoFlow::OutputHeld(model, held) => {
            let title = format!("output '{}' is held by its support", node(&model, held));
            input(*model, InputError::new(title).help("leave outputs free but for their guides"))
        }
        NoFlow::Paths(model, most) => {
            let title = format!("more than {most} paths lead from the input to the outputs");
            input(*model, InputError::new(title).help("name the members of the mechanism: members = [\"T1\", \"T2\"]"))
        }
    }
}

/// Why the replacement ends, as one sentence without a full stop.
pub fn end(flow: &Flow) -> String {
    let named = |members: &[usize]| -> String {
        let names: Vec<String> = members.iter().map(|&member| shown(&flow.model.members[member].name)).collect();
        list(&names, 8)
    };
    let why = match &flow.end {
        End::Met => "ends here: all requirements are met".to_owned(),
        End::Paths if flow.steps.is_empty() => "no member of a path may be replaced".to_owned(),
        End::Paths => "all levels of all paths are treated".to_owned(),
        End::Mixed(stay) => format!("ends at a level where {} may not be replaced, and others may", named(stay)),
        End::Short(member) => {
            let model = &flow.model;
            let [length, ..] = model.units.symbols();
            let (own, least) = (model.members[*member].length, flow.request.shortest);
            format!("ends at {}: it is {own:.4} {length} long, a muscle at least {least} {length}", named(&[*member]))
        }
        End::Lost => "ends here: the last network has no stable equilibrium".to_owned(),
        End::NoMuscle => "the file has no muscle to replace members by, or several and does not name one".to_owned(),
    };
    why + &missed(flow)
}

/// What the last network falls short of, as the rest of a sentence.
fn missed(flow: &Flow) -> String {
    let requirements = &flow.request.requirements;
    if requirements.is_empty() || flow.end == End::Met {
        return String::new();
    }
    let Some(last) = flow.steps.last() else { return "; no requirement is met".to_owned() };
    let short = |(limits, &value): (&Requirement, &f64)| {
        let name = shown(&flow.model.probes.names[limits.probe]);
        let bound = match value {
            value if limits.is_met(value) => return None,
            value if value > limits.most => format!("at most {}", number(limits.most)),
            _ if limits.least.is_finite() => format!("at least {}", number(limits.least)),
            _ => format!("at most {}", number(limits.most)),
        };
        let value = if value.is_nan() { "not known".to_owned() } else { number(value) };
        Some(format!("{name} is {value}, {bound} is required"))
    };
    let short: Vec<String> = requirements.iter().zip(&last.required).filter_map(short).collect();
    if short.is_empty() { String::new() } else { format!("; {}", short.join(", ")) }
}
