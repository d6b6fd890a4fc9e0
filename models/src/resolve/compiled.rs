//! A network that was evaluated once, ready for other values of its parameters: only what these go into is evaluated again.
//!
//! Names, and what hangs together, are those of the first evaluation. What follows the parameters is found out by the
//! expressions that are met where it is read; members follow their nodes and sections besides. Where anything is wrong with
//! the numbers the whole network is evaluated, which tells what it is.

use std::fmt;
use std::sync::Arc;

use pennate_solver::structure::{Formulation, Release};

use super::context::{Context, Names};
use super::joints::{self, Bodies};
use super::lasting::Lasting;
use super::members::{self, Surroundings};
use super::properties::{self, Properties};
use super::steps::{self, Actors, Groups};
use super::topology::JointRotation;
use super::{again, node};
use crate::error::Span;
use crate::expression::Quantity;
use crate::file::Folder;
use crate::input::read::{Map, Named};
use crate::input::{self, Network};
use crate::model::{Member, MemberKind, Model};
use crate::parameter::Stated;
use crate::probes::{Operand, Probe};

/// What the first evaluation found, besides the model.
pub(crate) struct Found {
    pub(crate) nodes: Names,
    pub(crate) member_names: Names,
    pub(crate) properties: Properties,
    pub(crate) bodies: Bodies,
    pub(crate) groups: Groups,
    pub(crate) rotations: Vec<JointRotation>,
    pub(crate) has_mass: bool,
    pub(crate) planar_only: Vec<(usize, Vec<&'static str>, Span)>,
    pub(crate) support_places: Vec<Span>,
    /// Components that supports hold.
    pub(crate) held: Vec<[bool; 6]>,
}

/// What a network is made of that was evaluated, and what of it follows the parameters.
pub(crate) struct Compiled {
    /// Without patterns and paths.
    pub(super) network: Network,
    /// The model of the first evaluation.
    pub(super) first: Model,
    /// Its members, as steps are read with them.
    pub(super) members: Vec<Option<Member>>,
    pub(super) found: Found,
    pub(super) follows: Follows,
    folder: Folder,
    parameters: Parameters,
}

struct Parameters {
    names: Names,
    values: Vec<Option<Quantity>>,
    stated: Vec<Stated>,
    /// Those that are expressions, each after what it needs.
    worked_out: Vec<(usize, String, Span)>,
}

/// Parts by their places, in the order of the file: ascending.
#[derive(Debug, Default)]
pub(super) struct Follows {
    pub(super) nodes: Vec<usize>,
    pub(super) materials: Vec<usize>,
    pub(super) sections: Vec<usize>,
    pub(super) muscles: Vec<usize>,
    /// Members that follow with all of their numbers.
    pub(super) members: Vec<usize>,
    /// Those of which only sections follow.
    pub(super) made: Vec<usize>,
    pub(super) bodies: bool,
    pub(super) supports: bool,
    pub(super) springs: bool,
    /// Whether ends of members, or springs, follow that decide what may turn.
    pub(super) rotations: bool,
    /// Steps, each with the components that something holds before it.
    pub(super) steps: Vec<(usize, Vec<[bool; 6]>)>,
    /// Probe, operand and parameter of expressions of probes.
    pub(super) operands: Vec<(usize, usize, usize)>,
}

impl fmt::Debug for Compiled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Compiled").field("follows", &self.follows).finish_non_exhaustive()
    }
}

impl Compiled {
    /// Finds out what follows the parameters; nothing where a load flow does, whose muscle follows.
    pub(crate) fn new(network: &Network, found: Found, first: &Model, cx: &mut Context) -> Option<Self> {
        let members = first.members.iter().cloned().map(Some).collect();
        let (network, first, folder) = (network.clone(), first.clone(), cx.folder.clone());
        let (names, values, stated) = (cx.parameter_names.clone(), cx.parameters.clone(), cx.stated.clone());
        let parameters = Parameters { names, values, stated, worked_out: cx.worked_out.clone() };
        let follows = Follows::default();
        let mut compiled = Self { network, first, members, found, follows, folder, parameters };
        compiled.follows = compiled.follows(cx);
        (compiled.follows.muscles.is_empty() || compiled.first.load_flow.is_none()).then_some(compiled)
    }

    /// The network with other numbers for some parameters, given by their places; nothing where anything is wrong with it, or
    /// more than numbers would change. An earlier one, which came from here, is evaluated again where there is one to spare.
    pub(crate) fn model(
        &self,
        given: &[(usize, f64)],
        known: &Arc<Lasting>,
        beside: bool,
        spare: Option<Model>,
    ) -> Option<Model> {
        let mut cx = self.context(given, known, beside)?;
        let mut model = spare.unwrap_or_else(|| self.first.clone());
        again::evaluate(self, &mut model, &mut cx)?;
        cx.errors.is_empty().then_some(model)
    }

    /// A reading in which the parameters have their values.
    fn context(&self, given: &[(usize, f64)], known: &Arc<Lasting>, beside: bool) -> Option<Context> {
        let Parameters { names, values, stated, worked_out } = &self.parameters;
        let mut cx = Context::new(self.folder.clone());
        (cx.units, cx.beside, cx.known) = (self.first.units, beside, Arc::clone(known));
        (cx.parameter_names, cx.parameters, cx.stated) = (names.clone(), values.clone(), stated.clone());
        for &(parameter, number) in given {
            cx.stated[parameter].number = number;
            cx.parameters[parameter] = Some(cx.stated[parameter].quantity());
        }
        for (parameter, text, span) in worked_out {
            if !given.iter().any(|(given, _)| given == parameter) {
                let quantity = cx.expression(text, *span)?;
                cx.work_out(*parameter, quantity);
            }
        }
        Some(cx)
    }

    /// What steps refer to.
    pub(super) fn actors<'a>(&'a self, properties: &'a Properties, rotations: &'a [JointRotation]) -> Actors<'a> {
        let found = &self.found;
        Actors {
            nodes: &found.nodes,
            member_names: &found.member_names,
            members: &self.members,
            groups: &found.groups,
            properties,
            bodies: &found.bodies,
            rotations,
            has_mass: found.has_mass,
        }
    }

    /// The formulation of members that do not ask for one.
    pub(super) fn formulation(&self) -> Formulation {
        self.network.formulation.map_or(Formulation::default(), |word| word.value.0)
    }

    fn follows(&self, cx: &mut Context) -> Follows {
        let (network, properties) = (&self.network, &self.found.properties);
        let mut follows = Follows {
            nodes: met(&network.nodes, cx, |named, cx| node(named, cx).is_some()),
            materials: met(&network.materials, cx, |named, cx| properties::material(named, cx).is_some()),
            sections: met(&network.sections, cx, |named, cx| properties::profile(named, cx).is_some()),
            muscles: met(&network.muscles, cx, |named, cx| cx.muscle(named).is_some()),
            ..Follows::default()
        };
        self.members(&mut follows, cx);
        self.joints(&mut follows, cx);
        let mut held = self.found.held.clone();
        let always = follows.rotations || !follows.muscles.is_empty();
        let actors = self.actors(properties, &self.found.rotations);
        for (index, (step, data)) in self.first.steps.iter().zip(network.steps.iter().flatten()).enumerate() {
            let (before, mut step) = (held.clone(), step.clone());
            let met = cx.meets(|cx| steps::again(&mut step, &data.value, &actors, &mut held, cx));
            if met || always {
                follows.steps.push((index, before));
            }
        }
        follows.operands = self.operands(cx);
        follows
    }

    fn members(&self, follows: &mut Follows, cx: &mut Context) {
        let place = |node: usize| Some(self.first.nodes[node].position);
        let (names, properties, formulation) = (&self.found.nodes, &self.found.properties, self.formulation());
        let around = Surroundings { names, place: &place, properties, formulation };
        for (index, (member, named)) in self.first.members.iter().zip(self.network.members.iter().flatten()).enumerate()
        {
            let data = &named.value.value;
            let own = cx.meets(|cx| members::again(&mut member.clone(), named, &around, cx));
            let muscle = |muscle: usize| follows.muscles.binary_search(&muscle).is_ok();
            let moved = member.nodes.iter().any(|node| follows.nodes.binary_search(node).is_ok());
            if own || moved || matches!(member.kind, MemberKind::Muscle(index) if muscle(index)) {
                follows.members.push(index);
                follows.rotations |= member.releases.iter().any(|release| matches!(release, Release::Axes(_)));
            } else if self.is_made_of(data, follows) {
                follows.made.push(index);
            }
        }
    }

    /// Whether a member has a section or a material that follows.
    fn is_made_of(&self, data: &input::Member, follows: &Follows) -> bool {
        let properties = &self.found.properties;
        let segments = data.segments.iter().flat_map(|segments| &segments.value);
        let segments = segments.map(|segment| (Some(&segment.value.section), segment.value.material.as_ref()));
        let mut parts = segments.chain([(data.section.as_ref(), data.material.as_ref())]);
        parts.any(|(section, material)| {
            let section = section.and_then(|name| properties.section_names.get(&name.value));
            let material = material.and_then(|name| properties.material_names.get(&name.value));
            section.is_some_and(|index| follows.sections.binary_search(&index).is_ok())
                || material.is_some_and(|index| follows.materials.binary_search(&index).is_ok())
        })
    }

    fn joints(&self, follows: &mut Follows, cx: &mut Context) {
        let (network, found) = (&self.network, &self.found);
        let (names, place) = (&found.nodes, |node: usize| Some(self.first.nodes[node].position));
        let count = self.first.nodes.len();
        follows.bodies = cx.meets(|cx| Bodies::resolve(network.rigid_bodies.as_ref(), names, count, cx));
        follows.supports = cx.meets(|cx| joints::supports(network.supports.as_ref(), names, &found.bodies, cx));
        let own = cx.meets(|cx| joints::springs(network.springs.as_ref(), names, &place, cx));
        let moved = |nodes: [usize; 2]| nodes.iter().any(|node| follows.nodes.binary_search(node).is_ok());
        let moved = self.first.springs.iter().any(|spring| spring.spring.pair().is_some_and(moved));
        follows.springs = own || moved;
        follows.rotations |= follows.springs;
    }

    fn operands(&self, cx: &Context) -> Vec<(usize, usize, usize)> {
        let mut operands = Vec::new();
        for (index, probe) in self.first.probes.probes.iter().enumerate() {
            let Probe::Expression { expression, operands: all } = probe else { continue };
            for (operand, (reference, of)) in expression.references().iter().zip(all).enumerate() {
                let parameter = cx.parameter_names.get(&reference.name);
                if let (Operand::Parameter(_), Some(parameter)) = (of, parameter) {
                    operands.push((index, operand, parameter));
                }
            }
        }
        operands
    }
}

/// The entries of a table in which expressions are met.
fn met<T>(map: &Option<Map<T>>, cx: &mut Context, read: fn(&Named<T>, &mut Context) -> bool) -> Vec<usize> {
    let entries = map.iter().flat_map(Map::iter).enumerate();
    entries.filter_map(|(index, named)| cx.meets(|cx| read(named, cx)).then_some(index)).collect()
}
