//! Networks of pneumatic muscles and compliant members: their files, what is wrong with them, and what the
//! solver makes of them.
//!
//! ```
//! use pennate_models::{Mesh, discretize, read_text};
//!
//! let text = r#"
//!     format = "pennate/1"
//!     nodes = { A = [0, 0], B = [100, 0] }
//!     materials.steel = { youngs_modulus = "200 GPa", poissons_ratio = 0.3 }
//!     sections.wire = { circle = { radius = "0.75 mm" } }
//!     members.wire = { nodes = ["A", "B"], section = "wire", material = "steel" }
//!     supports = { A = "clamped" }
//!     steps = [{ name = "push", force = { B = [0, -1] } }]
//! "#;
//! let model = read_text("wire.toml", text, &[])?;
//! let (structure, steps) = discretize(&model, &Mesh::initial(&model, 1e-6));
//! assert_eq!((structure.members.len(), steps.len()), (1, 1));
//! # Ok::<(), pennate_models::InputErrors>(())
//! ```

use std::path::{Path, PathBuf};
use std::sync::Arc;

pub mod discretize;
pub mod error;
pub mod expression;
pub mod file;
pub mod grading;
pub mod hsim;
pub mod input;
pub mod library;
pub mod mesh;
pub mod model;
pub mod parameter;
pub mod prb;
pub mod probes;
mod reading;
mod resolve;
pub mod scenes;
pub mod section;
pub mod slopes;
pub mod unit;

pub use discretize::discretize;
pub use error::{InputError, InputErrors};
pub use input::schema;
pub use mesh::{Mesh, Stretch};
pub use model::Model;
pub use reading::Reading;

use error::Source;
use file::Folder;

/// The text of a network file, from which models with different parameters can be made.
#[derive(Clone, Debug)]
pub struct Document {
    source: Source,
    language: input::tree::Language,
    folder: Folder,
}

impl Document {
    /// Opens a network file, TOML or JSON by its extension.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn open(path: &Path) -> Result<Self, InputErrors> {
        let name = path.display().to_string();
        match file::read(path) {
            Ok(text) => {
                let folder = Folder::at(path.parent().unwrap_or(Path::new("")));
                let language = resolve::language(path, &text);
                Ok(Self { source: Source { name, path: path.to_owned(), text }, language, folder })
            }
            Err(error) => {
                let error = InputError::new(format!("{name} cannot be read: {error}"))
                    .help("give the path of a network file, .toml or .json");
                Err(InputErrors { errors: vec![error], sources: Vec::new() })
            }
        }
    }

    /// A text that is no file of its own, in the language that the extension of its name tells; files that it refers to are
    /// looked for in `directory`.
    pub fn new(name: &str, text: &str, directory: &Path) -> Self {
        let source = Source { name: name.to_owned(), path: PathBuf::new(), text: text.to_owned() };
        let language = resolve::language(Path::new(name), text);
        Self { source, language, folder: Folder::at(directory) }
    }

    /// The same, with the texts of files that it refers to: what stands at their paths does not matter any more.
    pub fn with_files(self, files: impl IntoIterator<Item = (PathBuf, String)>) -> Self {
        let known = Arc::new(files.into_iter().collect());
        Self { folder: Folder { known, ..self.folder }, ..self }
    }

    /// Name, text and path; the path is empty where the text is no file.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// Where files that the network refers to are looked for.
    pub fn directory(&self) -> &Path {
        &self.folder.directory
    }

    /// What is written, before anything is evaluated.
    ///
    /// # Errors
    /// What the language forbids, at its place.
    pub fn tree(&self) -> Result<input::tree::Value, InputErrors> {
        input::tree::parse(&self.source.text, self.language, 0)
            .map_err(|error| InputErrors { errors: vec![*error], sources: vec![self.source.clone()] })
    }

    /// The text of another tree, in TOML; files that it refers to are found where those of this one are.
    #[must_use]
    pub fn with_tree(&self, name: &str, tree: &input::tree::Value) -> Self {
        let source = Source { name: name.to_owned(), path: PathBuf::new(), text: input::write::toml(tree) };
        Self { source, language: input::tree::Language::Toml, folder: self.folder.clone() }
    }

    /// A network from its text; `name` stands in messages and tells the language by its extension.
    pub fn from_text(name: &str, text: &str) -> Self {
        Self::new(name, text, Path::new(""))
    }

    /// Reads the network once, after setting parameters (name, text), to evaluate it for other values of them; and the model
    /// that it is as it stands.
    ///
    /// # Errors
    /// Everything found wrong, with its place.
    pub fn reading(&self, settings: &[(String, String)]) -> Result<(Reading, Model), InputErrors> {
        Reading::new(self.source.clone(), self.language, self.folder.clone(), settings)
    }

    /// The checked model, after setting parameters (name, text).
    ///
    /// # Errors
    /// Everything found wrong, with its place.
    pub fn model(&self, settings: &[(String, String)]) -> Result<Model, InputErrors> {
        resolve::read(self.source.clone(), self.language, &self.folder, settings)
    }
}

/// Reads and checks a network file, TOML or JSON by its extension, after setting parameters (name, text).
///
/// # Errors
/// Everything found wrong, with its place.
pub fn read(path: &Path, settings: &[(String, String)]) -> Result<Model, InputErrors> {
    Document::open(path)?.model(settings)
}

/// Reads and checks a network from a text; `name` stands in messages and tells the language by its extension.
///
/// # Errors
/// Everything found wrong, with its place.
pub fn read_text(name: &str, text: &str, settings: &[(String, String)]) -> Result<Model, InputErrors> {
    Document::from_text(name, text).model(settings)
}
