//! Steps: targets of pressures and loads, and changes of what holds the nodes.

use std::fmt::Display;

use rustc_hash::{FxHashMap, FxHashSet};

use nalgebra::Vector3;
use pennate_solver::structure::{Branch, Change, Method, Stop};

use super::context::{Context, Names, Owner};
use super::course::course;
use super::joints::Bodies;
use super::magnitudes;
use super::properties::Properties;
use super::topology::JointRotation;
use crate::error::{InputError, Span};
use crate::input;
use crate::input::read::{Map, Named, Number, Spanned, suggest};
use crate::model::{Member, MemberKind, Step, Target};
use crate::unit::Kind;

/// Members by the name of their group, or of their path.
pub(crate) type Groups = FxHashMap<String, Vec<usize>>;

/// What steps refer to.
pub(crate) struct Actors<'a> {
    pub(crate) nodes: &'a Names,
    pub(crate) member_names: &'a Names,
    pub(crate) members: &'a [Option<Member>],
    pub(crate) groups: &'a Groups,
    pub(crate) properties: &'a Properties,
    pub(crate) bodies: &'a Bodies,
    pub(crate) rotations: &'a [JointRotation],
    /// Whether anything has a mass.
    pub(crate) has_mass: bool,
}

/// Resolves the steps; `held` says which components supports hold.
pub(crate) fn steps(
    steps: &[Spanned<input::Step>],
    actors: &Actors<'_>,
    mut held: Vec<[bool; 6]>,
    cx: &mut Context,
) -> Vec<Step> {
    let mut known = FxHashSet::default();
    let mut all = Vec::new();
    for (index, data) in steps.iter().enumerate() {
        let (name, span) = match &data.value.name {
            Some(name) => (name.value.clone(), name.span),
            None => (format!("step {}", index + 1), data.span),
        };
        if !known.insert(name.clone()) {
            cx.error(
                InputError::new(format!("two steps are called '{name}'"))
                    .at(span)
                    .help("give every step a name of its own"),
            );
        }
        let (targets, changes, course) = read(&data.value, &name, actors, &mut held, cx);
        let Course { increments, method, branch, stop } = course;
        all.push(Step { name, span, targets, changes, increments, method, branch, stop });
    }
    all
}

/// How a step goes along its ramp.
struct Course {
    increments: Option<usize>,
    method: Method,
    branch: Branch,
    stop: Option<Stop>,
}

/// Targets and changes of a step, and how it goes along its ramp; `held` are the components that something holds before
/// it, and then after it.
fn read(
    step: &input::Step,
    name: &str,
    actors: &Actors<'_>,
    held: &mut [[bool; 6]],
    cx: &mut Context,
) -> (Vec<(Target, f64)>, Vec<Change>, Course) {
    let (method, branch, stop) = course(step, actors.nodes, cx);
    let (targets, changes, changed) = (Vec::new(), Vec::new(), FxHashMap::default());
    let mut reader = StepReader { actors, cx, name, held, targets, changes, changed };
    reader.read(step);
    let (targets, changes) = (reader.targets, reader.changes);
    let increments = step.increments.as_ref().and_then(|count| cx.count(count));
    (targets, changes, Course { increments, method, branch, stop })
}

/// Evaluates a step again, before which something holds these components; afterwards they are those that it leaves held.
pub(crate) fn again(
    step: &mut Step,
    data: &input::Step,
    actors: &Actors<'_>,
    held: &mut [[bool; 6]],
    cx: &mut Context,
) {
    let (targets, changes, course) = read(data, &step.name, actors, held, cx);
    (step.targets, step.changes, step.stop) = (targets, changes, course.stop);
}

/// The reading of one step.
pub(crate) struct StepReader<'a, 'b> {
    pub(crate) actors: &'a Actors<'a>,
    pub(crate) cx: &'b mut Context,
    pub(crate) name: &'a str,
    /// Components that something holds at the end of the step.
    pub(crate) held: &'b mut [[bool; 6]],
    pub(crate) targets: Vec<(Target, f64)>,
    pub(crate) changes: Vec<Change>,
    /// Components changed in this step, and by which key.
    pub(crate) changed: FxHashMap<(usize, usize), &'static str>,
}

impl StepReader<'_, '_> {
    fn read(&mut self, step: &input::Step) {
        self.pressure(step.pressure.as_ref());
        self.actuation(step.actuation.as_ref());
        self.node_loads(step.force.as_ref(), Kind::Force, "force", Target::Force);
        self.node_loads(step.follower_force.as_ref(), Kind::Force, "follower_force", Target::FollowerForce);
        self.node_loads(step.moment.as_ref(), Kind::Moment, "moment", Target::Moment);
        self.node_loads(step.follower_moment.as_ref(), Kind::Moment, "follower_moment", Target::FollowerMoment);
        self.gravity(step.gravity.as_ref());
        self.distributed(step.distributed.as_ref());
        self.motions(step.displacement.as_ref(), "displacement");
        self.motions(step.rotation.as_ref(), "rotation");
        self.motions(step.displace_by.as_ref(), "displace_by");
        self.hold_or_free(step.hold.as_ref(), "hold");
        self.hold_or_free(step.free.as_ref(), "free");
    }

    /// The members that a name means, and how closely: a member 2, a group 1, "all" 0.
    fn address(&mut self, name: &str, span: Span, what: &str, fits: impl Fn(&Member) -> bool) -> (u8, Vec<usize>) {
        let members = self.actors.members;
        if let Some(index) = self.actors.member_names.get(name) {
            let Some(member) = &members[index] else { return (2, Vec::new()) };
            if fits(member) {
                return (2, vec![index]);
            }
            self.cx.error(
                InputError::new(format!("member '{name}' has nothing that {what} could act on"))
                    .at(span)
                    .label(format!("no {what} here"))
                    .help(nothing_to_act_on(what)),
            );
            return (2, Vec::new());
        }
        let group = self.actors.groups.get(name);
        if name != "all" && group.is_none() {
            // A member or group whose definition failed has been reported already.
            if members.iter().all(Option::is_some) && !self.cx.has_many_errors() {
                let groups = self.actors.groups.keys().map(String::as_str);
                let mut known: Vec<&str> = groups.chain(self.actors.member_names.iter()).chain(["all"]).collect();
                known.sort_unstable();
                known.dedup();
                self.cx.error(
                    InputError::new(format!(
                        "{what} of step '{}' names '{name}', which is no member or group",
                        self.name
                    ))
                    .at(span)
                    .label("no such member or group")
                    .help(suggest(name, known.into_iter(), "members and groups")),
                );
            }
            return (1, Vec::new());
        }
        let fits = |&index: &usize| members[index].as_ref().is_some_and(&fits);
        let found: Vec<usize> = match group {
            _ if name == "all" => (0..members.len()).filter(fits).collect(),
            Some(group) => group.iter().copied().filter(fits).collect(),
            None => Vec::new(),
        };
        if found.is_empty() && members.iter().all(Option::is_some) {
            self.cx.error(
                InputError::new(format!("'{name}' holds no member that {what} could act on"))
                    .at(span)
                    .label(format!("no {what} here"))
                    .help(nothing_to_act_on(what)),
            );
        }
        (u8::from(name != "all"), found)
    }

    /// Sets targets so that a member's own entry wins over that of its group, and that over "all".
    fn set_targets(&mut self, mut found: Vec<(u8, Target, f64)>) {
        found.sort_by_key(|(closeness, ..)| *closeness);
        let mut place = FxHashMap::default();
        for (_, target, value) in found {
            let next = self.targets.len();
            let at = *place.entry(target).or_insert(next);
            if at == next {
                self.targets.push((target, value));
            } else {
                self.targets[at].1 = value;
            }
        }
    }

    fn pressure(&mut self, entries: Option<&Map<Number>>) {
        let mut found = Vec::new();
        for entry in entries.into_iter().flatten() {
            let (closeness, members) = self.address(&entry.name, entry.span, "pressure", Member::is_muscle);
            let mut values: FxHashMap<usize, Option<f64>> = FxHashMap::default();
            for index in members {
                let Some(Some(member)) = self.actors.members.get(index) else { continue };
                let MemberKind::Muscle(muscle) = member.kind else { continue };
                let value = match values.get(&muscle) {
                    Some(value) => *value,
                    None => {
                        let value = self.muscle_pressure(muscle, &member.name, &entry.value);
                        values.insert(muscle, value);
                        value
                    }
                };
                found.extend(value.map(|value| (closeness, Target::Control(index), value)));
            }
        }
        self.set_targets(found);
    }

    fn muscle_pressure(&mut self, muscle: usize, member: &str, number: &Number) -> Option<f64> {
        let data = self.actors.properties.muscles[muscle].as_ref()?;
        let value = self.cx.pressure(number, &data.unit)?;
        let (limit, unit) = (data.muscle.pressure_limit(), &data.muscle.pressure_unit);
        if self.cx.beside {
            return Some(value);
        }
        // Conversions of units round.
        if value > limit * (1.0 + 1e-9) {
            self.cx.error(
                InputError::new(format!(
                    "the pressure {value} {unit} of member '{member}' is beyond the table of muscle '{}', which ends at {limit} {unit}",
                    data.muscle.name
                ))
                .at(number.span)
                .label("beyond the table")
                .help(format!("stay within 0 and {limit} {unit}, or add rows to the table")),
            );
            return None;
        }
        if value < 0.0 {
            self.cx.error(
                InputError::new(format!("the pressure {value} {unit} of member '{member}' is negative"))
                    .at(number.span)
                    .label("below zero")
                    .help(format!("stay within 0 and {limit} {unit}")),
            );
            return None;
        }
        Some(value.min(limit))
    }

    fn actuation(&mut self, entries: Option<&Map<Number>>) {
        let mut found = Vec::new();
        for entry in entries.into_iter().flatten() {
            let fits = |member: &Member| member.kind == MemberKind::Actuated;
            let (closeness, members) = self.address(&entry.name, entry.span, "actuation", fits);
            let Some(value) = self.cx.number(&entry.value, Kind::Pure) else { continue };
            found.extend(members.into_iter().map(|index| (closeness, Target::Control(index), value)));
        }
        self.set_targets(found);
    }

    /// The node that an entry is about.
    pub(crate) fn node(&mut self, named: &Named<impl Sized>, key: &str) -> Option<usize> {
        let owner = format_args!("{key} of step '{}'", self.name);
        self.actors.nodes.find(&named.name, named.span, owner, self.cx)
    }

    fn node_loads(
        &mut self,
        entries: Option<&Map<Spanned<Vec<Number>>>>,
        kind: Kind,
        key: &str,
        target: impl Fn(usize, usize) -> Target,
    ) {
        for named in entries.into_iter().flatten() {
            let node = self.node(named, key);
            let what = format_args!("{key} on node '{}'", named.name);
            let vector = if kind == Kind::Moment {
                self.cx.triple(&named.value, kind, what)
            } else {
                self.cx.vector(&named.value, kind, what)
            };
            let (Some(node), Some(vector)) = (node, vector) else { continue };
            let is_follower = matches!(target(node, 0), Target::FollowerForce(..));
            if kind == Kind::Moment {
                self.check_moment(node, vector, what, named.value.span);
            } else if is_follower && vector != [0.0; 3] && self.actors.rotations[node] == JointRotation::None {
                self.cx.warn(
                    InputError::new(format!(
                        "{what} keeps its direction: all ends there are released, so the node does not turn"
                    ))
                    .at(named.value.span)
                    .label("follows nothing")
                    .help("weld the member that it is to follow to the node, or write it under force"),
                );
            }
            self.targets.extend((0..3).map(|component| (target(node, component), vector[component])));
        }
    }

    /// A moment needs something to turn.
    fn check_moment(&mut self, node: usize, moment: [f64; 3], what: impl Display, span: Span) {
        if self.actors.rotations[node].lacks(Vector3::from(moment)) {
            self.cx.error(
                InputError::new(format!("{what} has nothing to turn: all ends there are released"))
                    .at(span)
                    .label("no rotation here")
                    .help("weld one of the members to the node, or apply a pair of forces"),
            );
        }
    }

    fn gravity(&mut self, gravity: Option<&Spanned<Vec<Number>>>) {
        let Some(list) = gravity else { return };
        let Some(vector) = self.cx.vector(list, Kind::Acceleration, "gravity") else { return };
        if !self.actors.has_mass && vector != [0.0; 3] && self.actors.members.iter().all(Option::is_some) {
            self.cx.error(
                InputError::new("gravity acts on nothing: no material, section, muscle or body has a mass")
                    .at(list.span)
                    .label("no mass anywhere")
                    .help("add density = … to a material or muscle, or mass_per_length to a stiffness"),
            );
        }
        magnitudes::gravity(vector, list.span, self.cx);
        self.targets.extend((0..3).map(|component| (Target::Gravity(component), vector[component])));
    }

    fn distributed(&mut self, entries: Option<&Map<Spanned<Vec<Number>>>>) {
        let mut found = Vec::new();
        for named in entries.into_iter().flatten() {
            let (closeness, members) = self.address(&named.name, named.span, "distributed", |_| true);
            let what = Owner("the distributed force on", &named.name);
            let Some(vector) = self.cx.vector(&named.value, Kind::ForcePerLength, what) else { continue };
            for index in members {
                found.extend((0..3).map(|c| (closeness, Target::Distributed(index, c), vector[c])));
            }
        }
        self.set_targets(found);
    }
}

fn nothing_to_act_on(what: &str) -> &'static str {
    match what {
        "pressure" => "pressure acts on members with muscle = \"…\"",
        "actuation" => "actuation acts on members whose segments have strain or curvature (strain = 0 counts)",
        _ => "name a member, a group or \"all\"",
    }
}
