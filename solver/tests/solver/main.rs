//! Structures that are made without a network file.

mod common;

mod cantilever;
mod comparison;
mod lanes;
mod sensitivity;
