//! Network files, their errors, and the models that they make.

mod again;
mod networks;
mod never_panics;
mod patterns;
mod refused;
mod scenes;
mod schema;
