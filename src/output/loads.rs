//! Loads and pressures along a run: what the steps move, with everything that moves alike in one column.

use pennate_models::Model;
use pennate_models::model::{MemberKind, Target, Units};
use pennate_solver::history::StepHistory;

use super::text::shown;

/// Names in a head before the rest is counted.
const NAMED: usize = 3;
const AXES: [&str; 3] = ["x", "y", "z"];

/// A value that steps move, of one or more members or nodes.
#[derive(Clone, Debug)]
pub struct Column {
    /// What it is, and of what.
    pub name: String,
    /// Empty where there is none.
    pub unit: String,
    /// Values at the beginning of every step and at the end of its ramp.
    levels: Vec<[f64; 2]>,
}

impl Column {
    /// The value at a fraction of a step.
    pub fn at(&self, step: usize, fraction: f64) -> f64 {
        self.levels.get(step).map_or(0.0, |&level| on_the_way(level, fraction))
    }
}

/// The columns of a model whose steps came so far, in the order in which its steps name them; what stays zero is left out.
pub fn columns(model: &Model, steps: &[StepHistory]) -> Vec<Column> {
    let mut together: Vec<Together> = Vec::new();
    for target in targets(model) {
        let levels = levels(model, steps, target);
        if levels.iter().flatten().all(|&level| level == 0.0) {
            continue;
        }
        let (kind, unit, of) = describe(model, target);
        let same = |known: &&mut Together| known.kind == kind && known.unit == unit && known.levels == levels;
        match together.iter_mut().find(same) {
            Some(known) => known.of.push(of),
            None => together.push(Together { kind, unit, levels, of: vec![of] }),
        }
    }
    let column = |Together { kind, unit, levels, of }| {
        let whom = whom(model, &kind, &of);
        Column { name: kind.replace("{}", &whom), unit, levels }
    };
    together.into_iter().map(column).collect()
}

/// Targets of one kind that move alike.
struct Together {
    /// With a place for the name.
    kind: String,
    unit: String,
    levels: Vec<[f64; 2]>,
    /// Members or nodes.
    of: Vec<usize>,
}

/// Everything that a step moves, once.
fn targets(model: &Model) -> Vec<Target> {
    let mut known = std::collections::HashSet::new();
    let all = model.steps.iter().flat_map(|step| &step.targets).map(|(target, _)| *target);
    all.filter(|target| known.insert(*target)).collect()
}

/// Values of a target at the beginning of every step and at the end of its ramp, where the steps came so far: a step begins where the one
/// before it ended, which a `stop` puts before the end of its ramp.
pub fn levels(model: &Model, steps: &[StepHistory], target: Target) -> Vec<[f64; 2]> {
    let mut here = 0.0;
    let mut levels = Vec::with_capacity(model.steps.len());
    for (index, step) in model.steps.iter().enumerate() {
        let to = step.targets.iter().rev().find(|(other, _)| *other == target).map_or(here, |(_, value)| *value);
        levels.push([here, to]);
        here = on_the_way([here, to], end(steps, index));
    }
    levels
}

/// The fraction of its ramp at which a step ended: the whole of one that nobody followed.
pub fn end(steps: &[StepHistory], index: usize) -> f64 {
    steps.get(index).map_or(1.0, |step| step.fraction)
}

/// The value at a fraction of a ramp.
pub fn on_the_way([from, to]: [f64; 2], fraction: f64) -> f64 {
    // The end is met exactly, whatever rounding makes of the sum.
    if fraction == 1.0 { to } else { from + fraction * (to - from) }
}

/// The kind with a place for the name, the unit, and the member or node.
fn describe(model: &Model, target: Target) -> (String, String, usize) {
    let [length, force, _] = model.units.symbols();
    let along = |what: &str, axis: usize| format!("{what} {{}} {}", AXES[axis]);
    let moment = || format!("{force} {length}");
    match target {
        Target::Control(member) => match model.members[member].kind {
            MemberKind::Muscle(muscle) => {
                ("pressure {}".to_owned(), model.muscles[muscle].pressure_unit.clone(), member)
            }
            _ => ("actuation {}".to_owned(), String::new(), member),
        },
        Target::Force(node, axis) => (along("force", axis), force.to_owned(), node),
        Target::FollowerForce(node, axis) => (along("follower_force", axis), force.to_owned(), node),
        Target::Moment(node, axis) => (along("moment", axis), moment(), node),
        Target::FollowerMoment(node, axis) => (along("follower_moment", axis), moment(), node),
        Target::Gravity(axis) => {
            let unit = match model.units {
                Units::MmNMpa => "mm/s^2",
                Units::MNPa => "m/s^2",
            };
            (format!("gravity {}", AXES[axis]), unit.to_owned(), 0)
        }
        Target::Distributed(member, axis) => (along("distributed", axis), format!("{force}/{length}"), member),
    }
}

/// Names of members or nodes that move alike: all of them, a group, or one by one.
fn whom(model: &Model, kind: &str, of: &[usize]) -> String {
    let of_nodes = kind.starts_with("force") || kind.contains("moment") || kind.starts_with("follower");
    if of_nodes {
        return listed(of.iter().map(|&node| shown(&model.nodes[node].name)));
    }
    let members = &model.members;
    let alike = |member: &pennate_models::model::Member| match kind.split(' ').next() {
        Some("pressure") => member.is_muscle(),
        Some("actuation") => member.kind == MemberKind::Actuated,
        _ => true,
    };
    if of.len() > 1 && of.len() == members.iter().filter(|member| alike(member)).count() {
        return "all".to_owned();
    }
    let group = members.get(of[0]).and_then(|member| member.group.as_deref());
    if let (Some(group), true) = (group, of.len() > 1) {
        let whole = members.iter().filter(|member| member.group.as_deref() == Some(group)).count() == of.len();
        if whole && of.iter().all(|&member| members[member].group.as_deref() == Some(group)) {
            return shown(group);
        }
    }
    listed(of.iter().map(|&member| shown(&members[member].name)))
}

fn listed(names: impl ExactSizeIterator<Item = String>) -> String {
    let count = names.len();
    let named = if count > NAMED + 1 { NAMED } else { count };
    let first: Vec<String> = names.take(named).collect();
    match count - named {
        0 => first.join(" + "),
        more => format!("{} + {more} more", first.join(" + ")),
    }
}
