//! Network files, their errors, and the models that they make.

mod bad_input;
mod networks;
mod never_panics;
mod patterns;
mod scenes;
mod schema;
