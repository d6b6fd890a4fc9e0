//! The load flow of a mechanism: which members transmit what its input puts in, and which of them muscles may replace.
//!
//! With the compliance C of the unloaded mechanism and the unit load fᵢ of the input i, the load transferred to a point p is
//! the one that moves p alone as the input does,
//!
//! ```text
//! uₚ = Cₚᵢ fᵢ        fₜ(p) = Cₚₚ⁻¹ uₚ        W(p) = fₜ · uₚ ≥ 0
//! ```
//!
//! and minus what a clamp at p would receive. It does not depend on what is attached behind p: a stiffness S there changes
//! both Cₚₚ and Cₚᵢ by the factor (1 + Cₚₚ S)⁻¹. A member is a transmitter where at least half of the energy W along it is axial.
//! Theory: docs/synthesis.md.

mod base;
mod compliance;
mod graph;
mod members;
mod replace;

use pennate_models::model::{LoadFlow, MemberId};
use pennate_models::{Document, InputErrors, Model};
use pennate_solver::error::FreeMotion;
use pennate_solver::history::Status;
use pennate_solver::options::{Options, Progress};
use pennate_solver::structure::NodeId;

pub use graph::{Decision, Edge, Graph, Level, levels};
pub use members::{MemberFlow, Point, Role};

/// The load flow of a network.
#[derive(Debug)]
pub struct Flow {
    /// The network as its file has it.
    pub model: Model,
    /// What the file says for the load flow.
    pub request: LoadFlow,
    /// Members of the mechanism, in the order of [`LoadFlow::members`].
    pub members: Vec<MemberFlow>,
    /// Motions of the outputs under the unit load of the input: displacement and rotation (radians).
    pub outputs: Vec<[f64; 6]>,
    /// Joints, members that carry the flow, and the paths between inputs and outputs.
    pub graph: Graph,
    /// What may be replaced, level by level from the input.
    pub levels: Vec<Level>,
    /// The networks with muscles, in the order in which they were solved.
    pub steps: Vec<Replacement>,
    /// Why there are no more of them.
    pub end: End,
}

/// A network in which muscles took the place of transmitters.
#[derive(Clone, Debug)]
pub struct Replacement {
    /// The level that was replaced last, counted from one.
    pub level: usize,
    /// All members that are muscles now.
    pub muscles: Vec<MemberId>,
    /// The network file.
    pub document: Document,
    /// Where its one step ended.
    pub status: Status,
    /// Whether that state is stable; `None` where nobody can say.
    pub stable: Option<bool>,
    /// Displacement and rotation (radians) of the outputs.
    pub outputs: Vec<[f64; 6]>,
    /// The greatest stress of a fibre of any member, where all sections have a shape.
    pub stress: Option<f64>,
    /// The probes that something is required of, in the order of the requirements.
    pub required: Vec<f64>,
}

/// Why the replacement ends.
#[derive(Clone, Debug, PartialEq)]
pub enum End {
    /// All levels of all paths were treated.
    Paths,
    /// The last network meets all requirements.
    Met,
    /// Some members of a level may be replaced and these may not: the paths cannot be treated together.
    Mixed(Vec<MemberId>),
    /// This member is shorter than the shortest muscle.
    Short(MemberId),
    /// The last network was not solved, or its state is unstable.
    Lost,
    /// The file has no muscle.
    NoMuscle,
}

/// Why there is no load flow.
#[derive(Debug)]
pub enum NoFlow {
    /// The network is wrong.
    Input(InputErrors),
    /// The file says nothing of a load flow.
    NotAsked(Box<Model>),
    /// The mechanism can move without force.
    Mechanism(Box<Model>, Vec<FreeMotion>),
    /// The load moves its own input by nothing: it is held.
    InputHeld(Box<Model>, NodeId),
    /// The supports hold this output.
    OutputHeld(Box<Model>, NodeId),
    /// More paths than this lead from the inputs to the outputs.
    Paths(Box<Model>, usize),
    /// The user did not want to wait.
    Interrupted,
}

/// The load flow of a network, with some parameters set (name, text); `observe` hears of every accepted increment of the
/// networks with muscles, and ends the work where it says false.
///
/// # Errors
/// [`NoFlow`] says why there is none.
pub fn flow(
    document: &Document,
    settings: &[(String, String)],
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Result<Flow, NoFlow> {
    let model = document.model(settings).map_err(NoFlow::Input)?;
    let Some(request) = model.load_flow.clone() else { return Err(NoFlow::NotAsked(Box::new(model))) };
    let base = base::base(&model, &request);
    let graph = Graph::new(&base, &request);
    if let Some(&output) = request.outputs.iter().find(|&&output| graph.is_grounded(output)) {
        return Err(NoFlow::OutputHeld(Box::new(model), output));
    }
    let Ok(graph) = graph.with_paths(&request) else { return Err(NoFlow::Paths(Box::new(model), graph::PATHS)) };
    let found = members::members(&base, &request, &graph, options);
    let (members, outputs) = match found {
        Ok(found) => found,
        Err(members::Nothing::Mechanism(motions)) => return Err(NoFlow::Mechanism(Box::new(base), motions)),
        Err(members::Nothing::Held(input)) => return Err(NoFlow::InputHeld(Box::new(model), input)),
    };
    let contracts = request.muscle.is_none_or(|muscle| model.muscles[muscle].at(request.pressure).alpha < 0.0);
    let fits = |member: usize| members[member].is_replaceable(contracts);
    let (levels, mixed) = levels(&graph.paths, &fits);
    let mut flow = Flow { model, request, members, outputs, graph, levels, steps: Vec::new(), end: End::Paths };
    if let Some(mixed) = mixed {
        flow.end = End::Mixed(mixed.into_iter().map(|member| flow.request.members[member]).collect());
    }
    replace::replace(&mut flow, document, settings, options, observe)?;
    Ok(flow)
}
