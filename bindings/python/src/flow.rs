//! The load flow.

use pennate::flow::{self, NoAnswer};
use pennate::output::flow::{json, svg, table};
use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError};
use pyo3::prelude::*;

use crate::findings::refused;
use crate::guard::{Listener, patient};
use crate::network::Network;

/// `flow.json`, the table that a person reads, `flow.svg`, and the networks of the steps: name and text.
pub(crate) type Answer = (String, String, String, Vec<(String, String)>);

/// The load flow of a network; given up where a signal or the listener stops it.
pub(crate) fn answer(
    py: Python<'_>,
    network: &Network,
    threads: Option<usize>,
    progress: &Listener,
) -> PyResult<Answer> {
    let (outcome, raised) = patient(py, progress, |stop, observe| {
        flow::answer(&network.document, &network.settings, threads, Some(stop), observe).map(|found| {
            let mut text = Vec::new();
            let written = json::write(&found, &mut text).map(|()| text);
            let picture = svg::picture(&found).map_err(|error| error.to_string());
            let steps = found.steps.iter().map(|step| step.document.source());
            let steps = steps.map(|source| (source.name.clone(), source.text.clone())).collect::<Vec<_>>();
            (written, table::report(&found), picture, steps)
        })
    })?;
    if let Some(raised) = raised {
        return Err(raised);
    }
    let (text, report, picture, steps) = outcome.map_err(|why| match why {
        NoAnswer::Refused(refusal) => refused(py, &refusal),
        NoAnswer::Interrupted => PyKeyboardInterrupt::new_err(()),
    })?;
    let text = String::from_utf8(text?).map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    Ok((text, report, picture.map_err(PyRuntimeError::new_err)?, steps))
}
