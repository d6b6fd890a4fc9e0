//! The program, and what it knows without a network.

use std::ffi::OsString;

use pennate_models::scenes::{SCENES, Scene, write};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::findings::wrong;
use crate::guard::{broken, caught, quick};

/// The program with its arguments, without its name; returns the exit status.
#[pyfunction]
pub(crate) fn main(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<u8> {
    let arguments = std::iter::once(OsString::from("pennate")).chain(arguments);
    let arguments: Vec<OsString> = arguments.collect();
    py.detach(|| caught(|| pennate::cli::run_in_package(arguments.into_iter()))).map_err(|message| broken(py, message))
}

/// The network file of a scene.
#[pyfunction]
pub(crate) fn scene(py: Python<'_>, name: &str, settings: Vec<(String, String)>) -> PyResult<String> {
    quick(py, || write(name, &settings))?.map_err(|errors| wrong(py, &errors))
}

/// Parameters of a scene: name, default value, what it is.
type Parameters = Vec<(&'static str, String, &'static str)>;

/// All scenes: name, title, remarks, parameters.
#[pyfunction]
pub(crate) fn scenes() -> Vec<(&'static str, &'static str, &'static str, Parameters)> {
    let parameters = |scene: &Scene| {
        let all = scene.parameters.iter();
        all.map(|each| (each.name, each.default.to_string(), each.what)).collect::<Parameters>()
    };
    SCENES.iter().map(|scene| (scene.name, scene.title, scene.remarks, parameters(scene))).collect()
}

/// The JSON Schema of the network file, as text.
#[pyfunction]
pub(crate) fn schema() -> PyResult<String> {
    serde_json::to_string(&pennate_models::schema()).map_err(|error| PyRuntimeError::new_err(error.to_string()))
}
