//! What is written in a network file, as dictionaries, lists, numbers and texts.

use pennate_models::input::tree::{Kind, Value};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// Whole numbers up to here are whole numbers in Python too: doubles hold all of them.
const WHOLE: f64 = 9_007_199_254_740_992.0;

/// The Python object of a value.
pub(crate) fn object<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match &value.kind {
        Kind::Null | Kind::Date => py.None().into_bound(py),
        Kind::Bool(flag) => flag.into_pyobject(py)?.to_owned().into_any(),
        #[expect(clippy::cast_possible_truncation, reason = "it is whole, and small enough")]
        Kind::Number(number) if number.fract() == 0.0 && number.abs() < WHOLE => {
            (*number as i64).into_pyobject(py)?.into_any()
        }
        Kind::Number(number) => number.into_pyobject(py)?.into_any(),
        Kind::String(text) => text.into_pyobject(py)?.into_any(),
        Kind::Array(items) => {
            let items: PyResult<Vec<_>> = items.iter().map(|item| object(py, item)).collect();
            PyList::new(py, items?)?.into_any()
        }
        Kind::Table(entries) => {
            let table = PyDict::new(py);
            for entry in entries {
                table.set_item(&entry.key, object(py, &entry.value)?)?;
            }
            table.into_any()
        }
    })
}
