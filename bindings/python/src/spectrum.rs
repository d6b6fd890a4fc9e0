//! Vibration and buckling.

use pennate::output::spectrum::{json, table};
use pennate::spectrum::{self, NoAnswer};
use pennate_analysis::spectrum::{NoSpectrum, Question, Request};
use pennate_models::Model;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use crate::findings::{mechanism, unsolved, wrong};
use crate::guard::{Listener, patient};
use crate::network::Network;

/// Modes or factors of a network, as `modes.json` or `buckling.json`, and the table that a person reads.
#[expect(clippy::too_many_arguments, reason = "each is an option of the command")]
pub(crate) fn answer(
    py: Python<'_>,
    network: &Network,
    question: &str,
    (step, along): (Option<String>, Option<String>),
    count: usize,
    accuracy: f64,
    threads: Option<usize>,
    progress: &Listener,
) -> PyResult<(String, String)> {
    let question = match question {
        "modes" => Question::Modes,
        "buckling" => Question::Buckling,
        _ => return Err(PyValueError::new_err("'modes' or 'buckling' expected")),
    };
    let request = Request { question, step, along, count, accuracy };
    let model = Model::clone(&network.model);
    let (outcome, raised) = patient(py, progress, |stop, observe| {
        spectrum::answer(model, &request, threads, Some(stop), observe).map(|found| {
            let mut text = Vec::new();
            json::write(&found, &[], &mut text).map(|()| (text, table::report(&found)))
        })
    })?;
    if let Some(raised) = raised {
        return Err(raised);
    }
    let (text, report) = outcome.map_err(|why| refused(py, why))??;
    let text = String::from_utf8(text).map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    Ok((text, report))
}

fn refused(py: Python<'_>, why: NoAnswer) -> PyErr {
    match why {
        NoAnswer::Input(errors) => wrong(py, &errors),
        NoAnswer::Spectrum(NoSpectrum::Mechanism(model, motions)) => mechanism(py, &model, &motions),
        NoAnswer::Spectrum(why) => {
            let sources = match &why {
                NoSpectrum::NotSolved(model, _) => model.sources.clone(),
                _ => Vec::new(),
            };
            unsolved(py, &spectrum::messages(why), &sources)
        }
    }
}
