//! `pennate._core`: what the Python package needs of the library.
//!
//! Everything here moves values between Python and `pennate-analysis`: arrays in, arrays out, errors as exceptions. What a
//! user sees is written in Python, in `python/pennate`. Rust works without the lock of the interpreter, on a thread of its
//! own where it may take long, so that signals are heard; a panic becomes an exception.

mod findings;
mod flow;
mod guard;
mod network;
mod problem;
mod program;
mod solution;
mod spectrum;
mod tree;
mod turns;

use pyo3::prelude::*;

#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    guard::keep_quiet();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<network::Network>()?;
    module.add_class::<solution::Solution>()?;
    module.add_class::<problem::Problem>()?;
    module.add_class::<problem::Live>()?;
    module.add_class::<problem::Lives>()?;
    module.add_function(wrap_pyfunction!(program::main, module)?)?;
    module.add_function(wrap_pyfunction!(program::scene, module)?)?;
    module.add_function(wrap_pyfunction!(program::scenes, module)?)?;
    module.add_function(wrap_pyfunction!(program::schema, module)?)?;
    module.add_function(wrap_pyfunction!(findings::unknown, module)?)?;
    module.add_function(wrap_pyfunction!(guard::fail, module)?)
}
