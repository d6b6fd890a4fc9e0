//! What results come from: the program, the files that were read, and the parameters.

use std::path::Path;

use pennate_models::Model;
use pennate_models::parameter::Parameter;
use serde::Serialize;
use sha2::{Digest, Sha256};

use super::json::Map;

/// Where a solution comes from.
#[derive(Serialize)]
pub(crate) struct Origin<'a> {
    /// Version of the program.
    version: &'static str,
    /// The network file first, then the muscle files that it refers to.
    files: Vec<File>,
    /// All parameters, each in its unit; those without one in the units of the file, angles in degrees.
    parameters: Map<'a, f64>,
    /// The units of those that have one.
    #[serde(skip_serializing_if = "Map::is_empty")]
    parameter_units: Map<'a, &'a str>,
    /// Those that were set from outside, as written there.
    set: Map<'a, &'a str>,
}

#[derive(Serialize)]
struct File {
    name: String,
    sha256: String,
}

impl<'a> Origin<'a> {
    pub(crate) fn of(model: &'a Model) -> Self {
        let file = |source: &pennate_models::error::Source| {
            let name = Path::new(&source.name)
                .file_name()
                .map_or_else(|| source.name.clone(), |name| name.to_string_lossy().into_owned());
            let sha256 = Sha256::digest(source.text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect();
            File { name, sha256 }
        };
        let parameters = model.parameters.iter();
        let unit = |each: &'a Parameter| Some((each.name.as_str(), &*each.unit.as_ref()?.name));
        Self {
            version: env!("CARGO_PKG_VERSION"),
            files: model.sources.iter().map(file).collect(),
            parameters: Map(parameters.clone().map(|each| (each.name.as_str(), each.value)).collect()),
            parameter_units: Map(parameters.filter_map(unit).collect()),
            set: Map(model.settings.iter().map(|(name, value)| (name.as_str(), value.as_str())).collect()),
        }
    }
}
