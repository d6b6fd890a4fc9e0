//! What is wrong or remarkable, as Python objects.

use numpy::PyArray1;
use pennate::diagnostics::{self, Message, Severity};
use pennate::problems::likely;
use pennate::{Refusal, explain};
use pennate_models::error::Source;
use pennate_models::{InputErrors, Model};
use pennate_solver::error::{Extent, FreeMotion, Place};
use pyo3::prelude::*;
use pyo3::types::PyList;

/// Marked places that are longer are no names.
const LONGEST_NAME: usize = 80;

fn class<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("pennate._errors")?.getattr(name)
}

/// A `Finding`.
pub(crate) fn finding<'py>(
    py: Python<'py>,
    severity: Severity,
    message: &Message,
    sources: &[Source],
) -> PyResult<Bound<'py, PyAny>> {
    let place = message.span.and_then(|span| Some((sources.get(span.file)?, span)));
    let (file, line, column, name) = match place {
        None => (None, None, None, None),
        Some((source, span)) => {
            let (line, column) = source.line_column(span.start);
            let marked = source.text.get(span.start..span.end).map(|text| text.trim().trim_matches(['"', '\'']));
            let name = marked.filter(|text| !text.is_empty() && text.len() <= LONGEST_NAME && !text.contains('\n'));
            (Some(source.name.as_str()), Some(line), Some(column), name)
        }
    };
    let name = name.or(message.name.as_deref());
    let word = match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    let Message { title, label, notes, help, .. } = message;
    let text = diagnostics::text(severity, message, sources);
    class(py, "Finding")?.call1((word, title, file, line, column, name, label, notes.clone(), help, text))
}

/// A list of `Finding`.
pub(crate) fn findings<'py>(
    py: Python<'py>,
    severity: Severity,
    messages: &[Message],
    sources: &[Source],
) -> PyResult<Bound<'py, PyList>> {
    let found: PyResult<Vec<_>> = messages.iter().map(|message| finding(py, severity, message, sources)).collect();
    PyList::new(py, found?)
}

/// The warnings of a network.
pub(crate) fn warnings<'py>(py: Python<'py>, model: &Model) -> PyResult<Bound<'py, PyList>> {
    let messages: Vec<Message> = model.warnings.iter().map(Message::from).collect();
    findings(py, Severity::Warning, &messages, &model.sources)
}

/// A `NetworkError`.
pub(crate) fn wrong(py: Python<'_>, errors: &InputErrors) -> PyErr {
    let made = || {
        let messages: Vec<Message> = errors.errors.iter().map(Message::from).collect();
        let found = findings(py, Severity::Error, &messages, &errors.sources)?;
        class(py, "NetworkError")?.call1((diagnostics::texts(errors), found))
    };
    made().map_or_else(|error| error, PyErr::from_value)
}

/// A `MechanismError`.
pub(crate) fn mechanism(py: Python<'_>, model: &Model, motions: &[FreeMotion]) -> PyErr {
    let made = || {
        let messages = explain::mechanisms(model, motions);
        let text: Vec<String> =
            messages.iter().map(|message| diagnostics::text(Severity::Error, message, &model.sources)).collect();
        let found = findings(py, Severity::Error, &messages, &model.sources)?;
        let moving: PyResult<Vec<_>> = motions.iter().map(|motion| one_motion(py, model, motion)).collect();
        class(py, "MechanismError")?.call1((text.join("\n\n"), found, moving?))
    };
    made().map_or_else(|error| error, PyErr::from_value)
}

fn one_motion<'py>(py: Python<'py>, model: &Model, motion: &FreeMotion) -> PyResult<Bound<'py, PyAny>> {
    let (node, member) = match motion.place {
        Place::Node(node) => (Some(model.nodes[node].name.as_str()), None),
        Place::Member(member) => (None, Some(model.members[member].name.as_str())),
    };
    let extent = match motion.extent {
        Extent::Local => "local",
        Extent::Part => "part",
        Extent::Whole => "whole",
    };
    let nodes: Vec<&str> = motion.nodes.iter().map(|&node| model.nodes[node].name.as_str()).collect();
    let words = explain::mechanism(model, motion).title;
    let direction = PyArray1::from_slice(py, &motion.direction);
    class(py, "Motion")?.call1((words, node, member, direction, motion.turns, nodes, extent))
}

/// The exception of a network that is not solved at all.
pub(crate) fn refused(py: Python<'_>, refusal: &Refusal) -> PyErr {
    match refusal {
        Refusal::Input(errors) => wrong(py, errors),
        Refusal::Mechanism(model, motions) => mechanism(py, model, motions),
    }
}

/// A `SolveError` of these messages.
pub(crate) fn unsolved(py: Python<'_>, messages: &[Message], sources: &[Source]) -> PyErr {
    let made = || {
        let texts: Vec<String> =
            messages.iter().map(|message| diagnostics::text(Severity::Error, message, sources)).collect();
        let found = findings(py, Severity::Error, messages, sources)?;
        class(py, "SolveError")?.call1((texts.join("\n\n"), found))
    };
    made().map_or_else(|error| error, PyErr::from_value)
}

/// A `NetworkError` of a name that there is not; `notes` say where it was given.
#[pyfunction]
pub(crate) fn unknown(
    py: Python<'_>,
    title: String,
    name: String,
    known: Vec<String>,
    plural: &str,
    notes: Vec<String>,
) -> Py<PyAny> {
    let help = Some(likely(&name, &known, plural));
    unfit(py, &Message { title, notes, help, name: Some(name), ..Message::default() }).into_value(py).into_any()
}

/// A `NetworkError` of what does not fit the network, and has no place in its file.
pub(crate) fn unfit(py: Python<'_>, message: &Message) -> PyErr {
    let made = || {
        let found = findings(py, Severity::Error, std::slice::from_ref(message), &[])?;
        class(py, "NetworkError")?.call1((diagnostics::text(Severity::Error, message, &[]), found))
    };
    made().map_or_else(|error| error, PyErr::from_value)
}
