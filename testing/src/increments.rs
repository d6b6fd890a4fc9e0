//! The end of a path, held against where small increments end.

use nalgebra::Vector3;
use pennate_models::{Mesh, discretize, read_text};
use pennate_solver::history::{Status, StepHistory};
use pennate_solver::options::Options;
use pennate_solver::structure::{Member, Method, Step, Structure};

/// How many increments are small.
pub const SMALL: usize = 100;
/// Differences of the fraction of the ramp, and of displacements over a length, that tell two states apart.
const FRACTION: f64 = 1e-6;
const DISPLACEMENT: f64 = 1e-5;

/// How two ends of one path differ.
#[derive(Clone, Debug, PartialEq)]
pub enum Apart {
    /// One stopped for another reason, or in another step.
    Status([Status; 2]),
    /// They stopped at other fractions of the ramp.
    Fraction([f64; 2]),
    /// A node is elsewhere, by this many lengths.
    Displacement(f64),
}

/// The structure and the steps of a network file, on the mesh that it begins with.
///
/// # Errors
/// What is wrong with the file.
pub fn read(text: &str) -> Result<(Structure, Vec<Step>), String> {
    let model = read_text("network.toml", text, &[]).map_err(|errors| errors.to_string())?;
    Ok(discretize(&model, &Mesh::initial(&model, 1e-6)))
}

/// The last step that was begun, in at least so many increments; along an arc in as many as it takes.
pub fn last(structure: &Structure, steps: &[Step], increments: Option<usize>) -> Option<StepHistory> {
    let count = |step: &Step| increments.filter(|_| step.method != Method::ArcLength).or(step.min_increments);
    let steps: Vec<_> = steps.iter().map(|step| Step { min_increments: count(step), ..step.clone() }).collect();
    let history = pennate_solver::solve(structure, &steps, &Options::default(), &mut |_| true).ok()?;
    history.steps.into_iter().rfind(|step| step.status != Status::NotReached)
}

/// How the end of a network file differs from that of small increments, if it does; displacements over the longest member.
///
/// # Errors
/// Where there is no network to solve.
pub fn apart(text: &str) -> Result<Option<Apart>, String> {
    let (structure, steps) = read(text)?;
    let longest = structure.members.iter().map(Member::length).fold(0.0, f64::max);
    apart_from_small(&structure, &steps, longest)
}

/// How the end of some steps differs from that of small increments, if it does; displacements over a length.
///
/// # Errors
/// Where there is no equilibrium to begin with.
pub fn apart_from_small(structure: &Structure, steps: &[Step], length: f64) -> Result<Option<Apart>, String> {
    let ends = [None, Some(SMALL)].map(|increments| last(structure, steps, increments));
    let [Some(a), Some(b)] = ends else { return Err("the network is a mechanism".to_owned()) };
    if a.status != b.status {
        return Ok(Some(Apart::Status([a.status, b.status])));
    }
    if (a.fraction - b.fraction).abs() >= FRACTION {
        return Ok(Some(Apart::Fraction([a.fraction, b.fraction])));
    }
    let states = [a, b].map(|step| step.increments.last().map(|increment| increment.state.clone()));
    let [Some(a), Some(b)] = states else { return Err("no state was found".to_owned()) };
    let far = |(a, b): (&[f64; 3], &[f64; 3])| (Vector3::from(*a) - Vector3::from(*b)).norm() / length;
    let pairs = a.nodes.iter().zip(&b.nodes).map(|(a, b)| (&a.displacement, &b.displacement));
    let farthest = pairs.map(far).fold(0.0, f64::max);
    Ok((farthest >= DISPLACEMENT).then_some(Apart::Displacement(farthest)))
}
