//! Mechanics of one element; knows no equations and no files.

pub mod section;
