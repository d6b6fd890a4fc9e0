//! Calibration: from test data to the table of a muscle.
//!
//! Two stages, as in section 2.2 of the dissertation. Stage 1 takes the contraction coefficient from the free stroke, stage 2
//! radii and moduli from what the muscle does under loads, each pressure on its own. The forward model is the solver's own
//! stepped rod ([`cantilever`]), shear-rigid unless asked otherwise.

pub mod cantilever;
pub mod data;
pub mod end_length;
pub mod errors;
pub mod muscle;
pub mod optimize;
pub mod parameters;
pub mod prb;
pub mod problem;
pub mod regression;
pub mod select;
pub mod stroke;
pub mod uncertainty;

use std::path::PathBuf;

use pennate_models::error::{InputError, InputErrors};
use pennate_models::hsim::{Muscle, Row};
use rayon::prelude::*;

use data::{Case, Data};
use errors::Errors;
use optimize::{Method, Optimum};
use parameters::{Parameter, Space};
use problem::{Problem, Scales, Tube, scales};
use select::Selection;
use uncertainty::Uncertainty;

/// What to fit, to what and how. Lengths are mm.
#[derive(Clone, Debug)]
pub struct Request {
    /// The test data, CSV.
    pub data: PathBuf,
    /// Which muscle of a file that holds several.
    pub variant: Option<String>,
    /// The length whose load cases are fitted; the middle one of those in the file by default.
    pub length: Option<f64>,
    /// Kinds of test that are fitted.
    pub tests: Vec<String>,
    /// Leaves out load cases of a smaller ovality: kinked ones.
    pub min_ovality: Option<f64>,
    /// Undeformed outer diameter.
    pub diameter: f64,
    /// Wall of the undeformed tube.
    pub wall: f64,
    /// Length of the ends that do not contract.
    pub end_length: EndLength,
    /// Shear-flexible (Timoshenko) instead of shear-rigid.
    pub shear: bool,
    /// A modulus for the ends and one for the middle.
    pub two_moduli: bool,
    /// How the differences are made least.
    pub method: Method,
    /// What errors call what can be asked for.
    pub words: Words,
}

/// How a caller calls what it lets a user ask for, in the help of errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Words {
    /// [`Request::variant`].
    pub variant: &'static str,
    /// [`Request::end_length`].
    pub end_length: &'static str,
}

impl Default for Words {
    fn default() -> Self {
        Self { variant: "variant", end_length: "end_length" }
    }
}

/// Length of the ends that do not contract.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EndLength {
    /// One undeformed diameter.
    Diameter,
    /// So many mm.
    Given(f64),
    /// That explains the free strokes of all lengths of the file.
    Fitted,
}

/// The kinds of test that are fitted unless others are named.
pub const TESTS: [&str; 2] = ["axial+", "bend"];
/// Below this ratio of its diameters a tube has kinked.
pub const KINKED: f64 = 0.93;

/// A fitted muscle.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// All that was read.
    pub data: Data,
    /// The lengths, and the cases of the chosen muscle.
    pub selection: Selection,
    /// The undeformed tube.
    pub tube: Tube,
    /// How the differences were made least.
    pub method: Method,
    /// One row a pressure, by increasing pressure.
    pub rows: Vec<FittedRow>,
}

/// The parameters of one pressure, and how they were found.
#[derive(Clone, Debug)]
pub struct FittedRow {
    /// Pressure, contraction coefficient, radii (mm) and moduli (MPa).
    pub row: Row,
    /// Mean differences of the cases that were fitted.
    pub errors: Errors,
    /// Sum of squared differences over their scales.
    pub cost: f64,
    /// How many starts came to this optimum, of how many.
    pub agreeing: [usize; 2],
    /// Parameters that ended on a bound, whether on the upper one, and the bound.
    pub on_bounds: Vec<(Parameter, bool, f64)>,
    /// How often all cases were solved, and with how many factorizations.
    pub evaluations: usize,
    /// Factorizations of the tangent that it took.
    pub factorizations: usize,
    /// Standard errors; `None` where the cases do not tell the parameters apart.
    pub uncertainty: Option<Uncertainty>,
}

impl Fitted {
    /// The muscle with its whole table.
    pub fn muscle(&self) -> Muscle {
        let mut rows = self.rows.iter().map(|fitted| fitted.row);
        let first = rows.next().unwrap_or_else(|| muscle::row(0.0, 0.0, [0.0; 2], [0.0; 2]));
        let mut muscle = self.tube.muscle(first);
        muscle.pressure_unit.clone_from(&self.data.pressure_unit);
        muscle.rows.extend(rows);
        muscle
    }

    /// Whether ends and middle have moduli of their own.
    pub fn has_two_moduli(&self) -> bool {
        self.rows.iter().any(|fitted| fitted.row.end_modulus != fitted.row.youngs_modulus)
    }
}

/// Reads test data and fits a muscle to them, pressure by pressure on the threads of the current pool.
///
/// # Errors
/// Data that cannot be read or fitted: everything found wrong, with row and column.
pub fn run(request: &Request) -> Result<Fitted, InputErrors> {
    let data = data::read(&request.data)?;
    let refuse = |errors| InputErrors { errors, sources: vec![data.source.clone()] };
    let selection = select::select(&data, request).map_err(refuse)?;
    let (tube, rows) = fit(&selection, request).map_err(refuse)?;
    Ok(Fitted { selection, tube, method: request.method, rows, data })
}

fn fit(selection: &Selection, request: &Request) -> Result<(Tube, Vec<FittedRow>), Vec<InputError>> {
    let end_length = match request.end_length {
        EndLength::Diameter => request.diameter,
        EndLength::Given(length) => length,
        EndLength::Fitted => end_length::fit(selection, request).map_err(|error| vec![*error])?,
    };
    let tube = Tube { diameter: request.diameter, wall: request.wall, end_length, shear: request.shear };
    let rows = fit_tube(selection, tube, request)?;
    Ok((tube, rows))
}

/// Both stages for a tube of given end length, pressure by pressure.
pub(crate) fn fit_tube(
    selection: &Selection,
    tube: Tube,
    request: &Request,
) -> Result<Vec<FittedRow>, Vec<InputError>> {
    let results: Vec<Result<FittedRow, Vec<InputError>>> =
        selection.pressures.par_iter().map(|pressure| fit_pressure(pressure, tube, request)).collect();
    let mut rows = Vec::new();
    let mut errors = Vec::new();
    for result in results {
        match result {
            Ok(row) => rows.push(row),
            Err(found) => errors.extend(found),
        }
    }
    if errors.is_empty() { Ok(rows) } else { Err(errors) }
}

fn fit_pressure(at: &select::Pressure, tube: Tube, request: &Request) -> Result<FittedRow, Vec<InputError>> {
    let alpha = stroke::contraction(&at.free, tube, request.words)?;
    let space = Space::new(tube.diameter, tube.wall, request.two_moduli);
    let mut problem = Problem::new(tube, space, alpha, sizes(&at.cases), &at.cases);
    let Some(Optimum { variables, cost, agreeing }) = optimize::optimize(&mut problem, request.method) else {
        let message = format!("no muscle has an equilibrium for all load cases at pressure {}", at.pressure);
        let error = InputError::new(message).at(at.cases[0].span);
        return Err(vec![error.help("look for a wrong unit or sign of a load")]);
    };
    let values = problem.space.values(&variables);
    let row = problem.row(&values);
    let on_bounds = problem.space.on_bounds(&variables);
    let bound: Vec<Parameter> = on_bounds.iter().map(|(parameter, ..)| *parameter).collect();
    let (evaluations, factorizations) = (problem.evaluations, problem.factorizations());
    Ok(FittedRow {
        uncertainty: Uncertainty::of(&mut problem, &values, &bound),
        row,
        errors: Errors::of(&tube, row, &at.cases),
        cost,
        agreeing,
        on_bounds,
        evaluations,
        factorizations,
    })
}

fn sizes(cases: &[Case]) -> Scales {
    scales(cases.iter())
}
