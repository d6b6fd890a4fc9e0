//! A solved network, as arrays.

use numpy::{IntoPyArray, PyArray1, PyArrayMethods};
use pennate::diagnostics::Severity;
use pennate::explain;
use pennate::output::csv::Table;
use pennate::output::drawing::{Drawing, Values};
use pennate::output::{json, table};
use pennate_analysis::solution::{self as solved, last_state, status_name};
use pennate_solver::history::Equilibrium;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::findings::{findings, warnings};
use crate::guard::quick;

/// A solution. Arrays have one entry a step first; what was not reached is not a number.
#[pyclass(frozen, module = "pennate._core")]
pub(crate) struct Solution {
    solved: solved::Solution,
}

impl Solution {
    /// A solution as Python holds it.
    pub(crate) fn new(solved: solved::Solution) -> Self {
        Self { solved }
    }

    /// An array of so many values a step, of the states at the ends of the steps.
    fn array<'py>(
        &self,
        py: Python<'py>,
        shape: &[usize],
        of: impl Fn(&Equilibrium) -> Vec<f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let steps = &self.solved.history.steps;
        let each: usize = shape.iter().product();
        let mut values = Vec::with_capacity(steps.len() * each);
        for step in steps {
            match last_state(step) {
                Some(state) => values.extend(of(state)),
                None => values.extend(std::iter::repeat_n(f64::NAN, each)),
            }
        }
        let whole: Vec<usize> = [steps.len()].into_iter().chain(shape.iter().copied()).collect();
        Ok(values.into_pyarray(py).reshape(whole)?.into_any())
    }

    fn nodes(&self) -> usize {
        self.solved.model.nodes.len()
    }

    fn members(&self) -> usize {
        self.solved.model.members.len()
    }
}

#[pymethods]
impl Solution {
    /// Names, and how it went.
    fn facts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (model, history) = (&self.solved.model, &self.solved.history);
        let facts = PyDict::new(py);
        facts.set_item("title", &model.title)?;
        facts.set_item("status", status_name(self.solved.status()))?;
        facts.set_item("steps", model.step_names())?;
        let steps = || history.steps.iter();
        facts.set_item("statuses", steps().map(|step| status_name(step.status)).collect::<Vec<_>>())?;
        facts.set_item("fractions", steps().map(|step| step.fraction).collect::<Vec<_>>())?;
        facts.set_item("stable", steps().map(|step| step.stable).collect::<Vec<_>>())?;
        facts.set_item("increments", steps().map(|step| step.increments.len()).collect::<Vec<_>>())?;
        facts.set_item("nodes", model.nodes.iter().map(|node| node.name.as_str()).collect::<Vec<_>>())?;
        facts.set_item("members", model.members.iter().map(|each| each.name.as_str()).collect::<Vec<_>>())?;
        facts.set_item("springs", model.springs.iter().map(|each| each.name.as_str()).collect::<Vec<_>>())?;
        facts.set_item("probes", &model.probes.names)?;
        let units = (0..model.probes.names.len()).map(|probe| table::probe_unit(model, probe));
        facts.set_item("probe_units", units.collect::<Vec<_>>())?;
        facts.set_item("symbols", model.units.symbols())?;
        facts.set_item("plane", model.dimension == pennate_solver::structure::Dimension::Plane)?;
        let reached = self.solved.accuracy;
        facts.set_item("accuracy", (reached.asked, reached.estimated, reached.is_met(), reached.verdict.name()))?;
        facts.set_item("shapes", steps().any(|step| step.increments.iter().any(|each| !each.shapes.is_empty())))?;
        Ok(facts)
    }

    /// (steps, nodes, 3), length.
    fn displacement<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.array(py, &[self.nodes(), 3], |state| state.nodes.iter().flat_map(|node| node.displacement).collect())
    }

    /// (steps, nodes, 3), rotation vectors in radians.
    fn rotation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.array(py, &[self.nodes(), 3], |state| state.nodes.iter().flat_map(|node| node.rotation).collect())
    }

    /// (steps, nodes, 6), force and moment.
    fn reaction<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.array(py, &[self.nodes(), 6], |state| {
            let both = |node: &pennate_solver::history::NodeState| [node.reaction_force, node.reaction_moment];
            state.nodes.iter().flat_map(both).flatten().collect()
        })
    }

    /// (steps, members, 2, 6), force and moment on the start and on the end.
    fn end_forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.array(py, &[self.members(), 2, 6], |state| {
            let ends = |member: &pennate_solver::history::MemberState| {
                let [first, last] = [0, 1].map(|end| [member.end_forces[end], member.end_moments[end]]);
                [first, last]
            };
            state.members.iter().flat_map(ends).flatten().flatten().collect()
        })
    }

    /// (steps, members, 3): deformed length, axial force at the middle, pressure or actuation.
    fn member_values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.array(py, &[self.members(), 3], |state| {
            state.members.iter().flat_map(|member| [member.length, member.axial_force, member.control]).collect()
        })
    }

    /// (steps, springs), force.
    fn spring_forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.array(py, &[self.solved.model.springs.len()], |state| state.springs.clone())
    }

    /// (steps,), strain energy.
    fn energy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.array(py, &[], |state| vec![state.energy])
    }

    /// (steps, probes), values and estimated errors.
    fn probes<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let count = self.solved.model.probes.names.len();
        let steps = &self.solved.probes.steps;
        let table = |of: &dyn Fn(&solved::ProbeSteps) -> Option<Vec<f64>>| {
            let rows = steps.iter().flat_map(|step| of(step).unwrap_or_else(|| vec![f64::NAN; count]));
            let rows: Vec<f64> = rows.collect();
            Ok::<_, PyErr>(rows.into_pyarray(py).reshape([steps.len(), count])?.into_any())
        };
        let values = table(&|step| step.last().map(<[f64]>::to_vec))?;
        Ok((values, table(&solved::ProbeSteps::errors)?))
    }

    /// Steps and fractions of the rows, then name, unit and values of each column.
    fn history<'py>(&self, py: Python<'py>) -> PyResult<(Vec<String>, Bound<'py, PyAny>, Bound<'py, PyList>)> {
        let Table { steps, fractions, columns } = Table::of(&self.solved);
        let columns = columns.into_iter().map(|each| (each.name, each.unit, PyArray1::from_vec(py, each.values)));
        Ok((steps, fractions.into_pyarray(py).into_any(), PyList::new(py, columns.collect::<Vec<_>>())?))
    }

    /// `results.json`.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        let mut text = Vec::new();
        quick(py, || json::write(&self.solved, &[], &mut text))??;
        String::from_utf8(text).map_err(|error| PyRuntimeError::new_err(error.to_string()))
    }

    /// The table that the program prints.
    fn report(&self) -> String {
        table::report(&self.solved)
    }

    /// What is remarkable.
    fn warnings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let all = warnings(py, &self.solved.model)?;
        let sources = &self.solved.model.sources;
        for each in findings(py, Severity::Warning, &explain::remarks(&self.solved), sources)? {
            all.append(each)?;
        }
        Ok(all)
    }

    /// Why steps failed.
    fn failures<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        findings(py, Severity::Error, &explain::failures(&self.solved), &self.solved.model.sources)
    }

    /// Places, lines, and arrays by name of points and of lines, of an increment of a step; of the unloaded state without
    /// one. Nothing where there is no such increment.
    #[pyo3(signature = (step, increment))]
    fn drawing<'py>(
        &self,
        py: Python<'py>,
        step: Option<usize>,
        increment: usize,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        quick(py, || Drawing::of(&self.solved, step, increment))?.map(|drawing| drawn(py, drawing)).transpose()
    }

    /// Fractions of the increments of a step.
    fn fractions<'py>(&self, py: Python<'py>, step: usize) -> Option<Bound<'py, PyArray1<f64>>> {
        let step = self.solved.history.steps.get(step)?;
        Some(PyArray1::from_vec(py, step.increments.iter().map(|each| each.fraction).collect()))
    }
}

/// Places, lines, and arrays by name of points and of lines.
pub(crate) fn drawn(py: Python<'_>, drawing: Drawing) -> PyResult<Bound<'_, PyDict>> {
    let (points, lines) = (drawing.points.len() / 3, drawing.lines.len() / 2);
    let found = PyDict::new(py);
    found.set_item("points", drawing.points.into_pyarray(py).reshape([points, 3])?)?;
    let ends: Vec<i64> = drawing.lines.into_iter().filter_map(|point| i64::try_from(point).ok()).collect();
    found.set_item("lines", ends.into_pyarray(py).reshape([lines, 2])?)?;
    found.set_item("point_data", arrays(py, drawing.point_data, points)?)?;
    found.set_item("cell_data", arrays(py, drawing.cell_data, lines)?)?;
    Ok(found)
}

fn arrays<'py>(py: Python<'py>, all: Vec<(String, Values)>, count: usize) -> PyResult<Bound<'py, PyDict>> {
    let found = PyDict::new(py);
    for (name, values) in all {
        match values {
            Values::Numbers(values) if values.len() == count => found.set_item(name, values.into_pyarray(py))?,
            Values::Numbers(values) => found.set_item(name, values.into_pyarray(py).reshape([count, 3])?)?,
            Values::Integers(values) => found.set_item(name, values.into_pyarray(py))?,
        }
    }
    Ok(found)
}
