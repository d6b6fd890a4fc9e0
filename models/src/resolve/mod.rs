//! From the input as written to the checked model.

mod again;
mod compiled;
mod context;
mod course;
mod curve;
mod grid;
mod joints;
mod lasting;
mod line;
mod load_flow;
mod magnitudes;
mod members;
mod motions;
mod muscles;
mod parameters;
mod paths;
mod patterns;
mod plane;
mod probes;
mod properties;
mod steps;
mod topology;

use std::sync::Arc;

use rustc_hash::FxHashMap;

use pennate_solver::structure::{Dimension, Formulation, Stability};

use self::compiled::Found;
use self::context::{Context, Names, Owner};
use self::joints::Bodies;
use self::members::{Members, Surroundings};
use self::properties::Properties;
use self::steps::{Actors, Groups};
use self::topology::{JointRotation, Parts};
use crate::discretize::plane_turn;
use crate::error::{InputError, InputErrors, Source};
use crate::file::Folder;
use crate::input::read::{Input, Map, Named, Number, Spanned};
use crate::input::tree::{self, Language};
use crate::input::{DimensionWord, Network, Probe, UnitsWord};
use crate::model::{Member, Model, Node, SegmentLaw, Units};
use crate::parameter::{Parameter, Stated};
use crate::unit::Kind;

pub(crate) use self::compiled::Compiled;
pub(crate) use self::lasting::Lasting;
pub(crate) use self::muscles::language;

/// The format that this reader knows.
const FORMAT: &str = "pennate/1";

/// Reads a text; files that it refers to come from a folder.
///
/// # Errors
/// Everything found wrong.
pub(crate) fn read(
    source: Source,
    language: Language,
    folder: &Folder,
    settings: &[(String, String)],
) -> Result<Model, InputErrors> {
    let network = parse(&source, language)?;
    let request = Request {
        source: Some(&source),
        folder,
        settings,
        given: FxHashMap::default(),
        known: None,
        beside: false,
        again: false,
    };
    let (mut model, _) = evaluate(&network, &request)?;
    model.settings = settings.to_vec();
    Ok(model)
}

/// What a network is evaluated with.
pub(crate) struct Request<'a> {
    /// The text that places are in; without it messages have none to show.
    pub(crate) source: Option<&'a Source>,
    /// Where files that it refers to come from.
    pub(crate) folder: &'a Folder,
    /// Parameters set from outside, as written.
    pub(crate) settings: &'a [(String, String)],
    /// Parameters that take the place of those of the file and of the settings.
    pub(crate) given: FxHashMap<String, Stated>,
    /// What an evaluation before found out for good; without one it is asked for.
    pub(crate) known: Option<Arc<Lasting>>,
    /// Whether pressures may lie beside the tables of their muscles: in networks that only tell how a design nearby changes.
    pub(crate) beside: bool,
    /// Whether the network is to be evaluated again: what follows its parameters is found out then.
    pub(crate) again: bool,
}

/// What an evaluation learned about the parameters.
pub(crate) struct Known {
    /// Those that could be evaluated, in the order of the file.
    pub(crate) parameters: Vec<Parameter>,
    /// Those that a count depends on.
    pub(crate) counting: Vec<String>,
    /// What holds for any values of the parameters.
    pub(crate) lasting: Lasting,
    /// The network, ready to be evaluated again; nothing where that has to be done as a whole.
    pub(crate) compiled: Option<Compiled>,
}

/// Reads the keys of a network; nothing is evaluated.
///
/// # Errors
/// Everything found wrong.
pub(crate) fn parse(source: &Source, language: Language) -> Result<Network, InputErrors> {
    let refused = |errors| InputErrors { errors, sources: vec![source.clone()] };
    let mut errors = Vec::new();
    let value = tree::parse(&source.text, language, 0).map_err(|error| refused(vec![*error]))?;
    match Network::read(&value, &mut errors) {
        Some(mut network) if errors.is_empty() => {
            muscles::define_known(&mut network);
            Ok(network)
        }
        _ => Err(refused(errors)),
    }
}

/// Evaluates and checks a network.
///
/// # Errors
/// Everything found wrong.
pub(crate) fn evaluate(network: &Network, request: &Request<'_>) -> Result<(Model, Known), InputErrors> {
    let mut cx = Context::new(request.folder.clone());
    cx.sources.extend(request.source.cloned());
    cx.given.clone_from(&request.given);
    (cx.beside, cx.again) = (request.beside, request.again);
    match &request.known {
        Some(known) => cx.known = Arc::clone(known),
        None => cx.lasting = Some(Lasting::default()),
    }
    match resolve(network, request.settings, &mut cx) {
        Some(mut model) if cx.errors.is_empty() => {
            let known = Known {
                parameters: model.parameters.clone(),
                counting: std::mem::take(&mut cx.counting),
                lasting: cx.lasting.take().unwrap_or_default(),
                compiled: cx.compiled.take(),
            };
            model.warnings = cx.warnings;
            model.sources = cx.sources;
            Ok((model, known))
        }
        _ => Err(cx.into_errors()),
    }
}

/// Everything short of a source; `None` or errors in the context where something is wrong.
fn resolve(network: &Network, settings: &[(String, String)], cx: &mut Context) -> Option<Model> {
    check_format(network, cx);
    cx.units = match network.units {
        Some(UnitsWord::MNPa) => Units::MNPa,
        _ => Units::MmNMpa,
    };
    let none = Map::default();
    cx.set_parameters(network.parameters.as_ref().unwrap_or(&none), settings);
    let written = network;
    let met_before = cx.expressions_met;
    let plain = if cx.errors.is_empty() { paths::expand(network, cx) } else { None };
    let network = plain.as_ref().unwrap_or(network);
    let expanded = match &network.patterns {
        Some(_) if cx.errors.is_empty() => Some(patterns::expand(network, cx)?),
        _ => None,
    };
    let network = expanded.as_ref().map_or(network, |expanded| &expanded.network);
    // Numbers of copies and of parts of paths are those of this evaluation.
    let mut whole = cx.expressions_met != met_before;
    let none = Map::default();
    let node_map = network.nodes.as_ref().unwrap_or(&none);
    let names = Names::new("node", node_map.iter().map(|named| named.name.as_str()));
    let nodes: Vec<Option<Node>> = node_map.iter().map(|named| node(named, cx)).collect();
    let properties = Properties::resolve(network, cx);
    let none = Map::default();
    let member_map = network.members.as_ref().unwrap_or(&none);
    let member_names = Names::new("member", member_map.iter().map(|named| named.name.as_str()));
    let formulation = network.formulation.map_or(Formulation::default(), |word| word.value.0);
    let place = |node: usize| nodes[node].as_ref().map(|node| node.position);
    let around = Surroundings { names: &names, place: &place, properties: &properties, formulation };
    let Members { members, planar_only } = Members::resolve(member_map, &around, cx);
    let bodies = Bodies::resolve(network.rigid_bodies.as_ref(), &names, nodes.len(), cx);
    let supports = joints::supports(network.supports.as_ref(), &names, &bodies, cx);
    let (mut supports, support_places): (Vec<_>, Vec<_>) = supports.into_iter().unzip();
    let springs = joints::springs(network.springs.as_ref(), &names, &place, cx);
    if member_map.0.is_empty() && springs.is_empty() && cx.errors.is_empty() {
        cx.error(InputError::new("the network has no members").help("add nodes, and members under [members]"));
    }
    let let_go = expanded.iter().flat_map(|expanded| &expanded.let_go);
    let mut let_go: Vec<_> = let_go.filter_map(|name| names.get(name)).collect();
    let_go.sort_unstable();
    let parts = Parts {
        nodes: &nodes,
        members: &members,
        springs: &springs,
        bodies: &bodies,
        supports: &supports,
        let_go: &let_go,
    };
    // What is wrong with a member is said already, and not once more by what its nodes lack without it.
    let rotations = if members.iter().any(Option::is_none) {
        vec![JointRotation::Full; nodes.len()]
    } else {
        topology::rotations(nodes.len(), members.iter().flatten(), &springs, &bodies)
    };
    let has_mass = members.iter().flatten().any(|member| has_mass(member, &properties))
        || bodies.bodies.iter().any(|body| body.mass > 0.0);
    let path_names = cx.paths.clone();
    let mut groups = Groups::default();
    for (index, member) in members.iter().enumerate() {
        let group = member.as_ref().and_then(|member| member.group.as_ref());
        let path = member.as_ref().and_then(|member| path_names.get(&member.name));
        for name in group.into_iter().chain(path) {
            match groups.get_mut(name) {
                Some(group) => group.push(index),
                None => drop(groups.insert(name.clone(), vec![index])),
            }
        }
    }
    let actors = Actors {
        nodes: &names,
        member_names: &member_names,
        members: &members,
        groups: &groups,
        properties: &properties,
        bodies: &bodies,
        rotations: &rotations,
        has_mass,
    };
    let no_steps = Vec::new();
    let held = parts.held();
    let steps = steps::steps(network.steps.as_ref().unwrap_or(&no_steps), &actors, held.clone(), cx);
    parts.check(&steps, cx);
    let observed = probes::Observed {
        nodes: &nodes,
        node_names: &names,
        member_names: &member_names,
        members: &members,
        groups: &groups,
        properties: &properties,
        bodies: &bodies,
        steps: &steps,
    };
    let met_before = cx.expressions_met;
    let mut probes = probes::probes(network.probes.as_ref(), &observed, cx);
    let is_expression = |named: &&Named<Spanned<Probe>>| matches!(named.value.value, Probe::Expression(_));
    let expressions = network.probes.iter().flatten().filter(is_expression).count();
    // Directions in them follow the parameters.
    whole |= cx.expressions_met != met_before + expressions;
    let still = topology::stand_still(&parts, &steps);
    let nodes: Vec<Node> = nodes.into_iter().collect::<Option<_>>()?;
    probes::warn_of_rotations(&probes, network.probes.as_ref(), &still, &nodes, cx);
    let members: Vec<Member> = members.into_iter().collect::<Option<_>>()?;
    let out = plane::leaves_plane(&nodes, &members, (&supports, &support_places), &steps)
        .or_else(|| plane::probe_leaves(&probes, network.probes.as_ref()));
    let dimension = dimension(network.dimension, out.as_ref(), cx);
    check_planar_only(&members, &planar_only, dimension, out.as_ref(), cx);
    let judged_in_plane =
        matches!(network.dimension, Some(Spanned { value: DimensionWord::Plane, .. })) || !planar_only.is_empty();
    probes.in_plane = dimension == Dimension::Plane;
    let mechanism = load_flow::Mechanism {
        nodes: &names,
        member_names: &member_names,
        bodies: &bodies,
        properties: &properties,
        probes: &probes,
        dimension,
        has_copies: written.patterns.is_some() || !cx.paths.is_empty(),
    };
    let met_before = cx.expressions_met;
    let load_flow = network.load_flow.as_ref().and_then(|flow| load_flow::load_flow(flow, &mechanism, cx));
    whole |= cx.expressions_met != met_before;
    if dimension == Dimension::Plane {
        joints::pin_about_z(network.supports.as_ref(), &names, &mut supports);
    }
    let mut model = Model {
        title: network.title.clone().unwrap_or_default(),
        units: cx.units,
        dimension,
        why_space: out.map(|(reason, _)| reason).filter(|_| dimension == Dimension::Space),
        strain_limit: strain_limit(network, cx),
        stability: if judged_in_plane { Stability::Plane } else { Stability::Space },
        parameters: cx.stated_parameters(),
        settings: Vec::new(),
        nodes,
        muscles: properties
            .muscles
            .iter()
            .map(|data| data.as_ref().map(|data| data.muscle.clone()))
            .collect::<Option<_>>()?,
        members,
        supports,
        let_go,
        bodies: bodies.bodies.clone(),
        springs,
        steps,
        probes,
        load_flow,
        warnings: Vec::new(),
        sources: Vec::new(),
    };
    let turns: Vec<_> = model.members.iter().map(|member| plane_turn(dimension, member)).collect();
    model.probes.set_turns(|member| turns[member]);
    if cx.again && cx.errors.is_empty() && !whole {
        let found = Found {
            nodes: names,
            member_names,
            properties,
            bodies,
            groups,
            rotations,
            has_mass,
            planar_only,
            support_places,
            held,
        };
        cx.compiled = Compiled::new(network, found, &model, cx);
    }
    Some(model)
}

/// Default of the strain above which a person is warned: linear elasticity holds to about a tenth.
const STRAIN_LIMIT: f64 = 0.1;

fn strain_limit(network: &Network, cx: &mut Context) -> f64 {
    let given = network.strain_limit.as_ref().and_then(|limit| cx.positive(limit, Kind::Pure, "the strain limit"));
    given.unwrap_or(STRAIN_LIMIT)
}

fn check_format(network: &Network, cx: &mut Context) {
    match &network.format {
        Some(format) if format.value != FORMAT => cx.error(
            InputError::new(format!("the format '{}' is not known", format.value))
                .at(format.span)
                .help(format!("this program reads format = \"{FORMAT}\"")),
        ),
        Some(_) => {}
        None => cx.warn(
            InputError::new(format!("the file does not say its format; it is read as \"{FORMAT}\""))
                .help(format!("add format = \"{FORMAT}\"")),
        ),
    }
}

fn node_place(named: &Named<Spanned<Vec<Number>>>, cx: &mut Context) -> Option<[f64; 3]> {
    cx.vector(&named.value, Kind::Length, Owner("node", &named.name))
}

fn node(named: &Named<Spanned<Vec<Number>>>, cx: &mut Context) -> Option<Node> {
    let position = node_place(named, cx)?;
    Some(Node { name: named.name.clone(), position, span: named.span })
}

fn has_mass(member: &Member, properties: &Properties) -> bool {
    member.segments.iter().any(|segment| match &segment.material {
        SegmentLaw::Fixed(law) => law.section.mass_per_length > 0.0,
        SegmentLaw::MuscleEnd(muscle) | SegmentLaw::MuscleMiddle(muscle) => {
            properties.muscles[*muscle].as_ref().is_some_and(|data| data.muscle.density > 0.0)
        }
    })
}

fn dimension(word: Option<Spanned<DimensionWord>>, out: Option<&plane::Reason>, cx: &mut Context) -> Dimension {
    match (word, out) {
        (Some(Spanned { value: DimensionWord::Space, .. }), _) => Dimension::Space,
        (Some(Spanned { span, value: DimensionWord::Plane }), Some((reason, _))) => {
            cx.error(
                InputError::new(format!("the network is no plane one: {reason}"))
                    .at(span)
                    .help("leave dimension out, or bring everything into the plane z = 0"),
            );
            Dimension::Plane
        }
        (_, None) => Dimension::Plane,
        (None, Some(_)) => Dimension::Space,
    }
}

/// Sections without EI2 or GJ serve in the plane only, and there with axis 3 along z.
fn check_planar_only(
    members: &[Member],
    planar_only: &[(usize, Vec<&'static str>, crate::error::Span)],
    dimension: Dimension,
    out: Option<&plane::Reason>,
    cx: &mut Context,
) {
    for (index, missing, span) in planar_only {
        let member = &members[*index];
        let why = if dimension == Dimension::Space {
            out.map_or("dimension = \"space\" asks for space".to_owned(), |(reason, _)| reason.clone())
        } else if member.axes[2][2].abs() < 1.0 - 1e-9 {
            "its axis 3 is not along z".to_owned()
        } else {
            continue;
        };
        cx.error(
            InputError::new(format!("the section of member '{}' needs {}: {why}", member.name, missing.join(" and ")))
                .at(*span)
                .help("EA, GA2 and EI3 suffice only where a network is solved in the plane; add the others to its stiffness"),
        );
    }
}
