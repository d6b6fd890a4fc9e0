//! Networks of pneumatic muscles and compliant members.

use std::path::Path;

pub mod error;
pub mod hsim;
pub mod mesh;
pub mod model;
pub mod probes;
pub mod section;

pub use error::{InputError, InputErrors};
pub use mesh::Mesh;
pub use model::Model;

use pennate_solver::structure::{Step, Structure};

/// Reads and checks a network file, TOML or JSON by its extension, after setting parameters (name, text).
///
/// # Errors
/// Everything found wrong, with its place.
pub fn read(path: &Path, settings: &[(String, String)]) -> Result<Model, InputErrors> {
    let _ = settings;
    Err(InputErrors { errors: vec![InputError::new(format!("cannot read {}", path.display()))], sources: Vec::new() })
}

/// The JSON Schema of the network file.
pub fn schema() -> serde_json::Value {
    serde_json::Value::Bool(true)
}

/// Turns a model into what the solver takes: members become chains of elements, targets become drives.
///
/// Nodes, members, springs and bodies keep their order and so their indices.
pub fn discretize(model: &Model, mesh: &Mesh) -> (Structure, Vec<Step>) {
    let _ = (model, mesh);
    todo!()
}
