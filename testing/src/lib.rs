//! Networks, readers and independent references that tests and campaigns share; nothing of it is part of the program.

use std::path::{Path, PathBuf};

pub mod comparison;
pub mod failures;
pub mod frames;
pub mod fuzz;
pub mod increments;
pub mod muscle;
pub mod network;
pub mod page;
pub mod program;
pub mod random;
pub mod scenes;
pub mod shrink;
pub mod tree;
pub mod verdict;
pub mod write;

/// A file or folder of the repository, by its path from the top.
pub fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}
