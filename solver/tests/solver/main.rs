//! Structures that are made without a network file.

mod common;

mod cantilever;
mod lanes;
mod sensitivity;
