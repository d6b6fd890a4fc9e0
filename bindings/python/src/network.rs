//! A network that was read.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pennate::diagnostics::Severity;
use pennate::explain;
use pennate::output::drawing::Drawing;
use pennate::output::table;
use pennate_models::{Document, InputErrors, Model};
use pennate_solver::options::Options;
use pennate_solver::structure::Dimension;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::findings::{finding, mechanism, refused, warnings, wrong};
use crate::guard::{Listener, Wanted, patient_while, quick};
use crate::problem::Problem;
use crate::solution::{Solution, drawn};
use crate::tree;

type Settings = Vec<(String, String)>;
type Files = Vec<(PathBuf, String)>;

/// A network with some parameters set: a value, which nothing changes.
#[pyclass(frozen, module = "pennate._core")]
pub(crate) struct Network {
    pub document: Document,
    pub settings: Settings,
    pub model: Arc<Model>,
}

fn read(document: Document, settings: Settings) -> Result<Network, InputErrors> {
    let model = document.model(&settings)?;
    // What a file says later is no matter of a network that was read.
    let files = model.sources.iter().skip(1).filter(|source| !source.path.as_os_str().is_empty());
    let files: Files = files.map(|source| (source.path.clone(), source.text.clone())).collect();
    Ok(Network { document: document.with_files(files), settings, model: Arc::new(model) })
}

#[pymethods]
impl Network {
    /// From a text; `name` stands in messages, and files are looked for in `directory`.
    #[new]
    fn new(
        py: Python<'_>,
        text: &str,
        name: &str,
        directory: PathBuf,
        settings: Settings,
        files: Files,
    ) -> PyResult<Self> {
        let made = || read(Document::new(name, text, &directory).with_files(files), settings);
        quick(py, made)?.map_err(|errors| wrong(py, &errors))
    }

    /// From a file.
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf, settings: Settings) -> PyResult<Self> {
        let opened = || Document::open(&path).and_then(|document| read(document, settings));
        quick(py, opened)?.map_err(|errors| wrong(py, &errors))
    }

    /// The same file with other settings.
    fn with_settings(&self, py: Python<'_>, settings: Settings) -> PyResult<Self> {
        quick(py, || read(self.document.clone(), settings))?.map_err(|errors| wrong(py, &errors))
    }

    /// What makes the same network again: the arguments of the constructor.
    fn parts(&self) -> (String, String, PathBuf, Settings, Files) {
        let source = self.document.source();
        let files = self.model.sources.iter().skip(1).filter(|source| !source.path.as_os_str().is_empty());
        let files = files.map(|source| (source.path.clone(), source.text.clone())).collect();
        let directory = self.document.directory().to_owned();
        (source.text.clone(), source.name.clone(), directory, self.settings.clone(), files)
    }

    /// What is written in the file.
    fn tree<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        tree::object(py, &self.document.tree().map_err(|errors| wrong(py, &errors))?)
    }

    /// Names, counts, parameters and positions.
    fn facts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let model = &*self.model;
        let facts = PyDict::new(py);
        facts.set_item("title", &model.title)?;
        facts.set_item("dimension", if model.dimension == Dimension::Plane { "plane" } else { "space" })?;
        facts.set_item("units", model.units.name())?;
        facts.set_item("symbols", model.units.symbols())?;
        facts.set_item("pressure_unit", model.pressure_unit().unwrap_or_default())?;
        facts.set_item("nodes", names(&model.nodes, |node| &node.name))?;
        facts.set_item("members", names(&model.members, |member| &member.name))?;
        let muscles = model.members.iter().filter(|member| member.is_muscle());
        facts.set_item("muscles", muscles.map(|member| member.name.as_str()).collect::<Vec<_>>())?;
        facts.set_item("springs", names(&model.springs, |spring| &spring.name))?;
        facts.set_item("bodies", names(&model.bodies, |body| &body.name))?;
        facts.set_item("steps", model.step_names())?;
        facts.set_item("probes", &model.probes.names)?;
        let units = (0..model.probes.names.len()).map(|probe| table::probe_unit(model, probe));
        facts.set_item("probe_units", units.collect::<Vec<_>>())?;
        let parameters = model.parameters.iter().map(|each| (each.name.as_str(), each.value));
        facts.set_item("parameters", parameters.collect::<Vec<_>>())?;
        let units = model.parameters.iter().filter_map(|each| Some((each.name.as_str(), each.unit.as_ref()?)));
        let units = units.map(|(name, unit)| (name, &*unit.name, unit.scale));
        facts.set_item("parameter_units", units.collect::<Vec<_>>())?;
        let places = model.nodes.iter().flat_map(|node| node.position).collect();
        let places: Bound<'py, PyArray2<f64>> = PyArray1::from_vec(py, places).reshape([model.nodes.len(), 3])?;
        facts.set_item("positions", places)?;
        let ends: Vec<[&str; 2]> =
            model.members.iter().map(|each| each.nodes.map(|node| model.nodes[node].name.as_str())).collect();
        facts.set_item("ends", ends)?;
        facts.set_item("lengths", PyArray1::from_vec(py, model.members.iter().map(|each| each.length).collect()))?;
        facts.set_item("warnings", warnings(py, model)?)?;
        facts.set_item("summary", table::summary(model))?;
        Ok(facts)
    }

    /// Everything short of solving: what the program says, and what is remarkable.
    fn check<'py>(&self, py: Python<'py>) -> PyResult<(String, Vec<Bound<'py, PyAny>>)> {
        let model = &*self.model;
        let near = quick(py, || pennate::near_motion(model))?.map_err(|motions| mechanism(py, model, &motions))?;
        let mut found: Vec<Bound<'py, PyAny>> = warnings(py, model)?.iter().collect();
        if let Some(near) = near {
            let message = explain::near_mechanism(model, &near);
            found.push(finding(py, Severity::Warning, &message, &model.sources)?);
        }
        Ok((table::checked(model), found))
    }

    /// Places, lines, and arrays by name of points and of lines, of the network as it is built.
    fn drawing<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let model = &*self.model;
        quick(py, || Drawing::as_built(model))?.map(|drawing| drawn(py, drawing)).transpose()
    }

    /// The solution, and the exception that ended the solve early, if one did; `wanted` is asked now and then whether it goes on.
    #[pyo3(signature = (accuracy, threads, shapes, progress, wanted = None))]
    fn solve(
        &self,
        py: Python<'_>,
        accuracy: f64,
        threads: Option<usize>,
        shapes: bool,
        progress: Listener,
        wanted: Wanted,
    ) -> PyResult<(Solution, Option<PyErr>)> {
        let model = Model::clone(&self.model);
        let (outcome, raised) = patient_while(py, &progress, &wanted, |stop, observe| {
            let options = Options { shapes, stop: Some(stop), ..Options::default() };
            pennate::solve(model, accuracy, threads, &options, observe)
        })?;
        match (outcome, raised) {
            (Ok(solution), raised) => Ok((Solution::new(solution), raised)),
            (Err(_), Some(raised)) => Err(raised),
            (Err(refusal), None) => Err(refused(py, &refusal)),
        }
    }

    /// The network compiled for some of its parameters and probes; `sample` has one row of values a design.
    fn problem(
        &self,
        py: Python<'_>,
        parameters: Vec<String>,
        probes: Vec<String>,
        accuracy: f64,
        sample: Vec<f64>,
        threads: usize,
    ) -> PyResult<Problem> {
        crate::problem::compile(py, self, &parameters, &probes, accuracy, &sample, threads)
    }

    /// The load flow, as the JSON, the table and the picture of the program, and the networks of its steps: name and text.
    #[pyo3(signature = (threads, progress))]
    fn flow(&self, py: Python<'_>, threads: Option<usize>, progress: Listener) -> PyResult<crate::flow::Answer> {
        crate::flow::answer(py, self, threads, &progress)
    }

    /// Modes or factors, as the JSON and the table of the program.
    #[pyo3(signature = (question, step, along, count, accuracy, threads, progress))]
    #[expect(clippy::too_many_arguments, reason = "each is an option of the command")]
    fn spectrum(
        &self,
        py: Python<'_>,
        question: &str,
        step: Option<String>,
        along: Option<String>,
        count: usize,
        accuracy: f64,
        threads: Option<usize>,
        progress: Listener,
    ) -> PyResult<(String, String)> {
        crate::spectrum::answer(py, self, question, (step, along), count, accuracy, threads, &progress)
    }
}

fn names<T>(items: &[T], name: impl Fn(&T) -> &str) -> Vec<&str> {
    items.iter().map(name).collect()
}
