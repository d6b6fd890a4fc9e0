//! Load flow: roles, senses and steps of mechanisms, and transferred loads against the reaction of a clamp.

mod clamp;
mod roles;

use std::path::Path;

use pennate_analysis::flow::{Flow, flow};
use pennate_models::Document;
use pennate_solver::options::Options;

/// The text of a case.
fn text(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/flow/cases").join(name).with_extension("toml");
    std::fs::read_to_string(path).unwrap()
}

/// The load flow of a text.
fn of_text(text: &str, settings: &[(&str, &str)]) -> Flow {
    let settings: Vec<_> = settings.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
    flow(&Document::from_text("case.toml", text), &settings, &Options::default(), &mut |_| true).unwrap()
}

/// The load flow of a case.
fn of(name: &str) -> Flow {
    of_text(&text(name), &[])
}
