//! One network compiled for "these numbers in, those numbers out": parameters of its file in, probes at ends of steps out.
//!
//! Reading, checking and meshing happen once; other values of the parameters re-evaluate expressions, geometry, sections
//! and loads on the same mesh and topology.
//!
//! ```
//! use pennate_analysis::problem::Problem;
//! use pennate_models::Document;
//!
//! let text = r#"
//!     format = "pennate/1"
//!     parameters = { L = 100, F = 5 }
//!     nodes = { A = [0, 0], B = ["= L", 0] }
//!     materials.steel = { youngs_modulus = "200 GPa", poissons_ratio = 0.3 }
//!     sections.wire = { circle = { radius = "0.75 mm" } }
//!     members.wire = { nodes = ["A", "B"], section = "wire", material = "steel" }
//!     supports = { A = "clamped" }
//!     steps = [{ name = "push", force = { B = [0, "= -F"] } }]
//!     probes = { drop = { node = "B", displacement = "uy" } }
//! "#;
//! let document = Document::from_text("wire.toml", text);
//! let problem = Problem::new(&document, &[], &["L", "F"], &["drop"], 1e-6)?;
//! // Two designs: rows of values in the order of the parameters.
//! let answer = problem.evaluate(&[100.0, 5.0, 80.0, 5.0]);
//! assert!((answer.values[0] + 30.325).abs() < 1e-3 && answer.values[1] > answer.values[0]);
//! assert!(answer.reasons.iter().all(Option::is_none));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod adjoint;
mod compliances;
mod design;
mod differences;
mod error;
mod estimate;
mod evaluate;
mod explicit;
mod expressions;
mod gradient;
mod group;
mod live;
mod mesh;
mod moved;
mod nearby;
mod neighbour;
mod numbers;
mod outputs;
mod slopes;
mod topology;
mod track;

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use pennate_models::{Document, InputErrors, Mesh, Model, Reading};
use pennate_solver::error::SolveError;
use pennate_solver::options::Options;

use crate::accuracy::solve_to_accuracy;
use crate::together::Workspaces;
use mesh::Served;

pub use error::{ProblemError, Reason};
pub use evaluate::Evaluation;
pub use gradient::Derivatives;
pub use live::{Live, Lives};
pub use outputs::Output;

/// A network compiled for some of its parameters and probes.
///
/// It is a value that any number of threads may use at once: nothing that an answer depends on changes.
#[derive(Clone, Debug)]
pub struct Problem {
    reading: Arc<Reading>,
    /// The network with the values of its file.
    middle: Arc<Model>,
    mesh: Mesh,
    /// Names and places of the parameters.
    inputs: Vec<(String, usize)>,
    outputs: Vec<Output>,
    accuracy: f64,
    /// Estimated error of every output: the largest of the designs that the mesh was made for.
    error: Vec<f64>,
    /// Once derivatives were asked for: nothing where the design of the file has none.
    reach: Arc<OnceLock<Option<nearby::Reach>>>,
    workspaces: Arc<Workspaces>,
}

impl Problem {
    /// Compiles a network, with some parameters set first (name, text) as on the command line.
    ///
    /// `parameters` are names under `[parameters]`; values are in the unit that the file writes each with, else in the units of the
    /// file, angles in degrees. `probes` are names of probes: at the end of the last step, or `name@step` at the end of that step. The mesh is what `accuracy`
    /// needs at the file's own values.
    ///
    /// # Errors
    /// A network that is wrong or cannot be solved at its own values, a name that is not known, or a parameter that changes
    /// the topology of the network.
    pub fn new(
        document: &Document,
        settings: &[(String, String)],
        parameters: &[&str],
        probes: &[&str],
        accuracy: f64,
    ) -> Result<Self, ProblemError> {
        Self::with_sample(document, settings, parameters, probes, accuracy, &[], &Control::default())
    }

    /// The same with a mesh that also serves a sample of designs: rows of values of the parameters.
    ///
    /// Designs that have no answer do not count, that of the file among them as long as one of the sample has one. It may be
    /// stopped on the way.
    ///
    /// # Errors
    /// As [`Problem::new`], and [`ProblemError::Interrupted`].
    pub fn with_sample(
        document: &Document,
        settings: &[(String, String)],
        parameters: &[&str],
        probes: &[&str],
        accuracy: f64,
        sample: &[f64],
        control: &Control,
    ) -> Result<Self, ProblemError> {
        let (reading, middle) = document.reading(settings).map_err(ProblemError::Network)?;
        let inputs = inputs(&reading, parameters)?;
        let outputs = outputs::outputs(&middle, probes)?;
        topology::check(&reading, &middle, &inputs)?;
        let solve = |model: Model| {
            let served = serve(model, &middle, &outputs, accuracy, control);
            if control.is_stopped() { Err(ProblemError::Interrupted) } else { Ok(served) }
        };
        let mut served = solve(middle.clone())?;
        for row in sample.chunks_exact(inputs.len().max(1)) {
            let Ok(model) = evaluated(&reading, &middle, &inputs, row, Reading::model) else { continue };
            served = mesh::joined(served, solve(model)?, &middle);
        }
        let Served { mesh, error } = served.map_err(ProblemError::Unsolvable)?;
        let (reading, middle) = (Arc::new(reading), Arc::new(middle));
        let (reach, workspaces) = (Arc::default(), Arc::default());
        Ok(Self { reading, middle, mesh, inputs, outputs, accuracy, error, reach, workspaces })
    }

    /// Names of the parameters, in the order of a row of values.
    pub fn parameters(&self) -> impl ExactSizeIterator<Item = &str> {
        self.inputs.iter().map(|(name, _)| name.as_str())
    }

    /// The outputs, in the order of a row of answers.
    pub fn outputs(&self) -> &[Output] {
        &self.outputs
    }

    /// The values of the parameters in the file, each in the unit of its parameter.
    pub fn middle(&self) -> Vec<f64> {
        self.inputs.iter().map(|&(_, place)| self.middle.parameters[place].value).collect()
    }

    /// The network with the values of a row.
    ///
    /// # Errors
    /// Values that make none, or one with other nodes, members, supports or steps.
    pub fn model(&self, row: &[f64]) -> Result<Model, Reason> {
        self.evaluated(row, Reading::model)
    }

    /// A network that tells how the one beside it changes, beyond the end of a table too.
    fn model_beside(&self, row: &[f64]) -> Result<Model, Reason> {
        self.evaluated(row, Reading::model_beside)
    }

    fn evaluated(
        &self,
        row: &[f64],
        model: impl FnOnce(&Reading, &[(usize, f64)]) -> Result<Model, InputErrors>,
    ) -> Result<Model, Reason> {
        evaluated(&self.reading, &self.middle, &self.inputs, row, model)
    }

    /// The network as its file has it.
    pub fn network(&self) -> &Model {
        &self.middle
    }

    /// The mesh of all designs.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The relative accuracy that the mesh was made for.
    pub fn accuracy(&self) -> f64 {
        self.accuracy
    }

    /// Estimated discretization error of every output: the largest of the designs that the mesh was made for.
    pub fn error(&self) -> &[f64] {
        &self.error
    }

    /// Steps that have to be solved for the outputs.
    fn steps(&self) -> usize {
        self.outputs.iter().map(|output| output.step + 1).max().unwrap_or(1)
    }
}

/// The parameters of some names.
fn inputs(reading: &Reading, names: &[&str]) -> Result<Vec<(String, usize)>, ProblemError> {
    let mut inputs: Vec<(String, usize)> = Vec::with_capacity(names.len());
    for &name in names {
        let Some(place) = reading.parameter(name) else {
            let known = reading.parameters().map(str::to_owned).collect();
            return Err(ProblemError::UnknownParameter { name: name.to_owned(), known });
        };
        if inputs.iter().any(|(_, known)| *known == place) {
            return Err(ProblemError::Twice { name: name.to_owned() });
        }
        if reading.counts(place) {
            return Err(ProblemError::Counts { name: name.to_owned() });
        }
        inputs.push((name.to_owned(), place));
    }
    Ok(inputs)
}

/// The network of a row of values, if it is of the topology of the one in the middle.
fn evaluated(
    reading: &Reading,
    middle: &Model,
    inputs: &[(String, usize)],
    row: &[f64],
    model: impl FnOnce(&Reading, &[(usize, f64)]) -> Result<Model, InputErrors>,
) -> Result<Model, Reason> {
    if let Some((index, _)) = row.iter().enumerate().find(|(_, value)| !value.is_finite()) {
        return Err(Reason::NotFinite { parameter: index });
    }
    let values: Vec<(usize, f64)> = inputs.iter().zip(row).map(|(&(_, place), &value)| (place, value)).collect();
    let model = model(reading, &values).map_err(|errors| Reason::Refused(Box::new(errors)))?;
    if topology::alike(middle, &model) { Ok(model) } else { Err(Reason::OtherTopology) }
}

/// The mesh that one design needs, for the one in the middle.
fn serve(
    model: Model,
    middle: &Model,
    outputs: &[Output],
    accuracy: f64,
    control: &Control,
) -> Result<Served, SolveError> {
    let options = Options { estimate: true, stop: control.stop.clone(), ..Options::default() };
    let solution = solve_to_accuracy(model, accuracy, &options, &mut |_| !control.is_stopped());
    let solution = solution.map_err(|(_, error)| error)?;
    let mesh = mesh::fitted(&solution.mesh, &solution.model, middle).into_owned();
    Ok(Served { error: outputs::errors(&solution, outputs), mesh })
}

/// What a caller may ask of an evaluation while it runs.
#[derive(Clone, Debug, Default)]
pub struct Control {
    /// Set from outside where nobody wants to wait any longer: designs that are not done have [`Reason::Interrupted`].
    pub stop: Option<Arc<AtomicBool>>,
    /// The moment from which on nobody waits.
    pub until: Option<Instant>,
}
