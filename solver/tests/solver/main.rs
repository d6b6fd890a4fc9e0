//! Structures that are made without a network file.

#[path = "../common/mod.rs"]
mod common;

mod cantilever;
mod lanes;
mod sensitivity;
