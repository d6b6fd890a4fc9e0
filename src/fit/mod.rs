//! What is written of a fitted muscle: a report, its file, and pictures.

pub mod curves;
pub mod file;
pub mod plot;
pub mod report;
