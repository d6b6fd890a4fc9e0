//! Writers of `pennate flow`.

pub mod json;
mod names;
pub mod svg;
pub mod table;

use std::io;
use std::path::Path;

use pennate_analysis::flow::{Flow, MemberFlow, Role};

use super::files::{WriteError, make_directory, write_whole};

/// Writes `flow.json`, `flow.svg` and the network of every step into a directory.
///
/// # Errors
/// [`WriteError`] names the file that could not be written; no half file remains.
pub fn write_files(flow: &Flow, directory: &Path) -> Result<(), WriteError> {
    make_directory(directory)?;
    for step in &flow.steps {
        let source = step.document.source();
        write_whole(&directory.join(&source.name), |out| out.write_all(source.text.as_bytes()))?;
    }
    let picture = directory.join("flow.svg");
    svg::draw(flow, &picture)
        .map_err(|error| WriteError { path: picture, source: io::Error::other(error.to_string()) })?;
    write_whole(&directory.join("flow.json"), |out| json::write(flow, out))
}

/// Word for what a member is.
pub fn role(member: &MemberFlow) -> &'static str {
    match member.role {
        Role::Transmitter => "transmitter",
        Role::Constraint => "constraint",
        Role::Idle => "idle",
    }
}

/// Word for the sense of a transmitter; nothing for other members.
pub fn sense(member: &MemberFlow) -> Option<&'static str> {
    let word = if member.axial > 0.0 { "tension" } else { "compression" };
    (member.role == Role::Transmitter).then_some(word)
}

/// The level of a member, counted from one, where it lies on a path.
pub fn level(flow: &Flow, member: usize) -> Option<usize> {
    let at = |path: &Vec<usize>| path.iter().position(|&other| other == member).map(|place| place + 1);
    flow.graph.paths.iter().filter_map(at).min()
}

/// Names of the members of a path.
pub fn path(flow: &Flow, path: &[usize]) -> Vec<String> {
    path.iter().map(|&member| flow.model.members[flow.request.members[member]].name.clone()).collect()
}
