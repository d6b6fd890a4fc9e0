//! Why there is no answer, in words: mechanisms, and steps that stop short of their end.

use nalgebra::Vector3;
use pennate_analysis::accuracy::{Accuracy, Verdict};
use pennate_analysis::solution::{Solution, fewest_digits, last_state, whole_digits};
use pennate_models::Model;
use pennate_models::model::{Member, Target};
use pennate_solver::error::{Extent, FreeMotion, NearMotion, Place};
use pennate_solver::history::{Cause, Failure, History, Note, Status, StepHistory};
use pennate_solver::structure::{Branch, Change, Method, NodeId, Release};

use crate::diagnostics::Message;
use crate::output::loads;
use crate::output::text::{direction, list, number, percent, shown};
use crate::strains;

/// Names listed before the rest is counted.
const NAMES: usize = 6;
/// Residual, over the largest force, of a try that converged.
const CONVERGED: f64 = 1e-9;
/// Mechanisms that are described one by one.
const MECHANISMS: usize = 10;
/// Digits with which nobody need worry about rounding.
const ENOUGH: f64 = 6.0;
const AXES: [&str; 3] = ["x", "y", "z"];
const COMPONENTS: [&str; 6] = ["ux", "uy", "uz", "rx", "ry", "rz"];

/// What is remarkable about a run, besides the warnings of its input.
pub fn remarks(solution: &Solution) -> Vec<Message> {
    let (model, history) = (&solution.model, &solution.history);
    let near = history.near_motion.as_ref().map(|near| near_mechanism(model, near));
    let remarks = near.into_iter().chain(few_digits(model, history)).chain(inaccurate(solution));
    remarks.chain(strains::warnings(solution)).collect()
}

/// Why a run is no answer, or no answer to all that was asked: steps that failed, and a missing estimate.
pub fn failures(solution: &Solution) -> Vec<Message> {
    failed_steps(&solution.model, &solution.history.steps).chain(no_estimate(solution)).collect()
}

/// Why a network that can move without force is not solved.
pub fn mechanisms(model: &Model, motions: &[FreeMotion]) -> Vec<Message> {
    let bare = |title: String| Message { title, ..Message::default() };
    let mut messages: Vec<Message> = motions.iter().take(MECHANISMS).map(|motion| mechanism(model, motion)).collect();
    if motions.is_empty() {
        messages.push(bare("the network is a mechanism: it can move without force".to_owned()));
    }
    if motions.len() > MECHANISMS {
        messages.push(bare(format!("the network has {} more free motions", motions.len() - MECHANISMS)));
    }
    messages
}

/// A motion of the unloaded network that needs no force.
pub fn mechanism(model: &Model, motion: &FreeMotion) -> Message {
    let (subject, span) = match motion.place {
        Place::Node(node) => (format!("node {}", shown(&model.nodes[node].name)), model.nodes[node].span),
        Place::Member(member) => (format!("member {}", shown(&model.members[member].name)), model.members[member].span),
    };
    let subject = match motion.extent {
        Extent::Local => subject,
        Extent::Part => format!("the part with {subject}"),
        Extent::Whole => "the whole network".to_owned(),
    };
    let how = match (motion.turns, about(model, motion)) {
        _ if motion.extent != Extent::Local => rigid(model, motion),
        (false, _) => format!("moves freely along {}", direction(upward(motion.direction))),
        (true, Some(axis)) => format!("turns freely about {axis}"),
        (true, None) => format!("turns freely about {}", direction(upward(motion.direction))),
    };
    let others: Vec<String> = motion.nodes.iter().map(|&node| shown(&model.nodes[node].name)).collect();
    let notes = (others.len() > 1).then(|| format!("nodes that move with it: {}", list(&others, NAMES)));
    let help = match motion.turns {
        _ if motion.extent != Extent::Local => {
            "hold it by a support or a spring to the ground, or connect it to what is held"
        }
        true => "hold the turn by a support, a spring or a body, or release one end less",
        false => "hold the motion by a support, a spring or another member",
    };
    let let_go = motion.nodes.iter().find(|node| model.let_go.binary_search(node).is_ok());
    let help = let_go.map_or_else(|| help.to_owned(), |&node| {
        let node = shown(&model.nodes[node].name);
        format!("the pattern that made node {node} did not copy what holds its original: write supports = true in it, or {help}")
    });
    Message {
        title: format!("the network is a mechanism: {subject} {how}"),
        span: Some(span),
        notes: notes.into_iter().collect(),
        help: Some(help),
        ..Message::default()
    }
}

/// A motion of the unloaded network that needs next to no force.
pub fn near_mechanism(model: &Model, near: &NearMotion) -> Message {
    let free = mechanism(model, &near.motion);
    let motion = free.title.trim_start_matches("the network is a mechanism: ").replace(" freely", " almost freely");
    let part = format!("it meets {:.0e} of the stiffness that its parts have one by one", near.stiffness.abs());
    let lost = format!("{part}: about {:.0} of 16 digits of the results are lost", -near.stiffness.abs().log10());
    Message {
        title: format!("the network is nearly a mechanism: {motion}"),
        notes: [lost].into_iter().chain(free.notes).collect(),
        help: Some(
            "hold the motion by a support or a spring, if nothing is to move that way; else look at the units of the \
             softest and the stiffest section and spring: a rigid body, a support or stretch = false holds exactly what a \
             very large stiffness holds badly"
                .to_owned(),
        ),
        ..free
    }
}

/// A step at whose end rounding leaves few digits: of what, where, and what would help.
pub fn few_digits(model: &Model, history: &History) -> Option<Message> {
    let (index, kind, digits) = fewest_digits(history).filter(|&(.., digits)| digits < ENOUGH)?;
    let rounding = last_state(&history.steps[index])?.rounding?;
    let (what, least) = [
        ("displacements", "the largest displacement"),
        ("rotations", "the largest rotation"),
        ("forces", "the largest force"),
        ("moments", "the largest moment"),
    ][kind];
    let left = match whole_digits(digits) {
        0 => format!("no digit of the {what}"),
        1 => format!("about 1 digit of the {what}"),
        many => format!("about {many} digits of the {what}"),
    };
    let node = node_name(model, rounding.nodes[kind]);
    let error = rounding.errors[kind]?;
    let mut notes = vec![format!(
        "numbers of 16 digits hold the motion of every member to 1e-16 of its length; that moves {what} by {error:.0e} of \
         {least}, most at {node}, and no mesh or step makes it less"
    )];
    let kinds = ["displacements", "rotations", "forces", "moments"].iter().enumerate();
    let others: Vec<String> = kinds
        .filter(|&(other, _)| other != kind)
        .filter_map(|(other, name)| Some(format!("{} of the {name}", whole_digits(rounding.digits(other)?))))
        .collect();
    if !others.is_empty() {
        notes.push(format!("digits left of the rest: {}", list(&others, 3)));
    }
    let name = shown(model.step_names()[index]);
    Some(Message {
        title: format!("rounding leaves {left} at the end of step '{name}'"),
        span: model.steps.get(index).map(|step| step.span),
        notes,
        help: Some(
            "look at the units of the softest and the stiffest section and spring, and of loads that hardly strain \
             anything; a rigid body, a support or stretch = false holds exactly what a very large stiffness holds badly; \
             next to a limit point or a bifurcation, ask for a state a little before or beyond it"
                .to_owned(),
        ),
        ..Message::default()
    })
}

/// The error of the mesh, where it is known and more than asked for, or a finer mesh that was to confirm it did not.
pub fn inaccurate(solution: &Solution) -> Option<Message> {
    let Accuracy { asked, estimated, verdict, .. } = solution.accuracy;
    if let (Verdict::PathLost, Some(error)) = (verdict, estimated.filter(|error| *error <= asked)) {
        return Some(Message {
            title: format!("the estimated error of {error:.1e} is not confirmed: a finer mesh got less far along the path"),
            help: Some(
                "the results of the finer mesh may differ; follow the path in more increments, or look at the states that its step passes"
                    .to_owned(),
            ),
            ..Message::default()
        });
    }
    let error = estimated.filter(|error| *error > asked)?;
    let help = match verdict {
        Verdict::Forced => "leave `elements` out of the file: the mesh is chosen by the accuracy asked for then",
        _ => "ask for what can be had (--accuracy), or look at what makes the network so hard to resolve",
    };
    Some(Message {
        title: format!("the estimated error is {error:.1e} of the largest values, more than the {asked:.1e} asked for"),
        help: Some(help.to_owned()),
        ..Message::default()
    })
}

/// What is said of a run that came to its end with an error nobody knows.
pub fn no_estimate(solution: &Solution) -> Option<Message> {
    let unknown = solution.status() == Status::Converged && solution.accuracy.verdict == Verdict::NotEstimated;
    unknown.then(|| Message {
        title: "the results have no error estimate and may be wrong by any amount".to_owned(),
        notes: vec![
            "the same state could not be found on finer elements, or these are still longer than the boundary layers \
             that the forces in the members make"
                .to_owned(),
        ],
        help: Some(
            "load the network in more steps or with `increments`; look for members that are far more slender than \
             they need to be, and for `elements` that the file forces"
                .to_owned(),
        ),
        ..Message::default()
    })
}

/// How a part moves as a rigid body.
fn rigid(model: &Model, motion: &FreeMotion) -> String {
    let vector = upward(motion.direction);
    let axis = (0..3).find(|&axis| vector[axis] > 1.0 - 1e-9);
    let axis = axis.map_or_else(|| direction(vector), |axis| AXES[axis].to_owned());
    match (motion.turns, motion.about) {
        (false, _) => format!("moves freely along {axis}"),
        (true, None) => format!("turns freely about {axis}"),
        (true, Some(node)) => format!("turns freely about {axis} at node {}", shown(&model.nodes[node].name)),
    }
}

/// The same motion with its largest component positive: a free motion goes both ways.
fn upward(vector: [f64; 3]) -> [f64; 3] {
    let largest =
        vector.into_iter().fold(0.0, |largest: f64, value| if value.abs() > largest.abs() { value } else { largest });
    if largest < 0.0 { vector.map(|value| -value) } else { vector }
}

/// The member along which the axis of a turn lies.
fn about(model: &Model, motion: &FreeMotion) -> Option<String> {
    let axis = Vector3::from(motion.direction);
    let along = |member: &pennate_models::model::Member| {
        let [start, end] = member.nodes.map(|node| Vector3::from(model.nodes[node].position));
        (end - start).cross(&axis).norm() <= 1e-6 * (end - start).norm()
    };
    match motion.place {
        Place::Member(member) => along(&model.members[member]).then(|| "its own axis".to_owned()),
        Place::Node(node) => {
            let member = model.members.iter().find(|member| member.nodes.contains(&node) && along(member))?;
            Some(format!("member {}", shown(&member.name)))
        }
    }
}

/// What helps where a network does not come into its prestress.
const STRAINED: &str = "let strains, curvatures and springs strain it less, or bring them in by a step of their own, as an actuation or a \
                        prescribed displacement, which may jump or follow the arc";

/// The steps that did not reach their end: how far they came, what that looks like and what to try.
pub fn failed_steps(model: &Model, steps: &[StepHistory]) -> impl Iterator<Item = Message> {
    (0..steps.len()).filter_map(move |index| failed_step(model, steps, index))
}

fn failed_step(model: &Model, steps: &[StepHistory], index: usize) -> Option<Message> {
    let step = &steps[index];
    let cause = match step.status {
        Status::Converged | Status::NotReached => return None,
        Status::LimitPoint => Cause::LimitPoint,
        Status::Bifurcation => Cause::Bifurcation,
        Status::NotConverged => Cause::StepTooSmall,
        Status::Interrupted => Cause::Interrupted,
    };
    let (tried, worst_component, worst_residual) = (step.fraction, 0, 0.0);
    let bare = Failure { tried, worst_node: None, worst_component, worst_residual, cause };
    Some(describe(model, steps, index, step.failure.as_ref().unwrap_or(&bare)))
}

fn describe(model: &Model, steps: &[StepHistory], index: usize, failure: &Failure) -> Message {
    let step = &steps[index];
    let names = model.step_names();
    let name = shown(names[index]);
    // Before a ramp begins a network comes into its prestress.
    let (way, reached, of) = match step.prestress {
        Some(part) => (format!("the prestress before step '{name}'"), percent(part), "it"),
        None => (format!("step '{name}'"), percent(step.fraction), "its ramp"),
    };
    let title = match failure.cause {
        Cause::LimitPoint | Cause::Unbounded | Cause::Taut { .. } => {
            format!("{way} ends at a limit point, at {reached} of {of}")
        }
        Cause::Bifurcation | Cause::SidewaysBifurcation => {
            format!("{way} ends at a bifurcation, at {reached} of {of}")
        }
        Cause::Interrupted => format!("{way} was interrupted at {reached} of {of}"),
        Cause::Endless => format!("{way} does not come to its end: its path is left at {reached} of {of}"),
        Cause::LeadsAway => format!("the path of {way} leads away from its ramp, to {reached} of it"),
        Cause::StepTooSmall | Cause::IllConditioned | Cause::Overheld { .. } => {
            format!("{way} finds no equilibrium beyond {reached} of {of}")
        }
    };
    let inside = step.critical_points.last().and_then(|point| point.member);
    let overheld = match failure.cause {
        Cause::Overheld { member } => Some(member),
        _ => None,
    };
    let place = match (overheld.or(inside), failure.worst_node) {
        (Some(member), _) => format!("member {}", shown(&model.members[member].name)),
        (None, Some(node)) => node_name(model, node),
        (None, None) => "a node".to_owned(),
    };
    let mut notes = Vec::new();
    match step.prestress {
        Some(_) => notes.push(
            "no load of the step acts yet: strains, curvatures and springs strain the network by themselves".to_owned(),
        ),
        None => notes.extend(reached_values(model, steps, index)),
    }
    let taut = match failure.cause {
        Cause::LimitPoint => strains::taut(model, step),
        Cause::Taut { member } => strains::taut_towards(model, step, member),
        _ => None,
    };
    let undecided = undecided(model, step, failure.cause);
    let whole = whole_turn(model, step, failure.cause);
    let help = match step.prestress {
        Some(_) if failure.cause != Cause::Interrupted => Some(STRAINED.to_owned()),
        None if undecided.is_some() => Some(DECIDES.to_owned()),
        None if whole.is_some() => Some(HELD_WHOLE.to_owned()),
        _ => taut.as_ref().map_or_else(|| advice(model, index, failure, &place), |taut| Some(taut.help.clone())),
    };
    notes.extend(
        taut.map(|taut| taut.note).or(undecided).or(whole).or_else(|| looks_like(model, index, failure.cause, &place)),
    );
    notes.extend(worst_residual(model, failure));
    notes.extend(pushed_muscles(model, step));
    notes.extend(strains::tension(model, step));
    notes.extend(strains::overload(model, index, step));
    let left = names.len() - index - 1;
    if left > 0 {
        notes.push(format!("{left} later step{} not tried", if left == 1 { " was" } else { "s were" }));
    }
    Message { title, span: model.steps.get(index).map(|step| step.span), notes, help, ..Message::default() }
}

/// What helps where a step turns a node through a whole turn.
const HELD_WHOLE: &str = "hold all three rotations of the node, and release that end of a member about the axes that are to be free; or turn \
                          it by less than a whole turn";

/// Where the iteration fails at a whole turn of a node that is held in part.
fn whole_turn(model: &Model, step: &StepHistory, cause: Cause) -> Option<String> {
    let node = step.notes.iter().find_map(|note| match *note {
        Note::WholeTurn { node, is_there: true } if cause == Cause::StepTooSmall => Some(node),
        _ => None,
    })?;
    Some(format!(
        "{} is at a whole turn there, with other rotations free: that is the same rotation about any axis, so what is held does not tell \
         how the node is turned, and there may be no way on",
        node_name(model, node)
    ))
}

/// What helps where less than rounding decides which way a network goes.
const DECIDES: &str = "a small force across, an offset by a thousandth of the length, or members that are not all alike decide, as they do \
                       about the real network; what is found then shows how much depends on them";

/// What it looks like where a network cannot go on from a state that rounding does not tell from a singular one: right behind a bifurcation
/// it may lead to any side, and no iteration finds one of these.
fn undecided(model: &Model, step: &StepHistory, cause: Cause) -> Option<String> {
    if cause != Cause::StepTooSmall || !step.notes.contains(&Note::WithinRounding) {
        return None;
    }
    let point = step.critical_points.last()?;
    Some(format!(
        "hardly anything resists a motion of the network there: right behind the singular point at {}, where {} moves most, less than \
         rounding decides which way it goes",
        percent(point.fraction),
        node_name(model, point.node)
    ))
}

fn node_name(model: &Model, node: NodeId) -> String {
    format!("node {}", shown(&model.nodes[node].name))
}

fn looks_like(model: &Model, index: usize, cause: Cause, place: &str) -> Option<String> {
    Some(match cause {
        Cause::LimitPoint => format!(
            "the equilibrium path turns back there: beyond it no equilibrium lies near, and the network would snap; \
             {place} moves most"
        ),
        Cause::Bifurcation => format!(
            "another equilibrium branches off there and the present one loses its stability, as when a strut buckles; \
             {place} moves most"
        ),
        Cause::SidewaysBifurcation => {
            format!("the network loses its stability out of its plane there; {place} moves most")
        }
        Cause::Unbounded => "nothing holds the network beyond that point: its energy falls without bound".to_owned(),
        Cause::StepTooSmall => {
            format!("Newton's iteration fails however small the step{}", lost_way(model, index))
        }
        Cause::Endless => {
            "thousands of increments along the path do not lead there: it winds on, or closes to a loop; what it passed is listed"
                .to_owned()
        }
        Cause::LeadsAway => {
            "the path turned back at a limit point and only bears the loads the other way since: what it passed is \
                             listed, but it does not come to the end of the ramp"
                .to_owned()
        }
        Cause::IllConditioned => "stiff and soft parts differ by more than double precision can hold".to_owned(),
        Cause::Overheld { .. } => format!(
            "{place} cannot be stretched, and what holds its ends does not let them come nearer: it could not bend, and no \
             finite axial force carries what acts across it"
        ),
        Cause::Taut { .. } | Cause::Interrupted => return None,
    })
}

/// What may stop a step at which neither a limit point nor a bifurcation was seen, by what the step asks for and the network has.
fn lost_way(model: &Model, index: usize) -> String {
    let freed = let_go(model, index);
    if !freed.is_empty() {
        return format!(
            ": the step lets go of {}, and without that a part may be loose, or come to rest only far away",
            list(&freed, NAMES)
        );
    }
    let turns = |member: &Member| member.releases.iter().any(|release| !matches!(release, Release::Welded));
    let like = if model.members.iter().any(Member::is_muscle) {
        "when a muscle kinks"
    } else if !model.springs.is_empty() || model.members.iter().any(turns) {
        "where parts that turn against each other come into one line"
    } else {
        "where a slender member snaps aside"
    };
    format!(", though the stiffness is regular: the path may bend sharply there, as {like}")
}

/// What a step lets go of: components and their nodes.
fn let_go(model: &Model, index: usize) -> Vec<String> {
    let changes = model.steps.get(index).map_or(&[][..], |step| &step.changes);
    let freed = |change: &Change| match *change {
        Change::Free { node, component } => Some(format!("{} of {}", COMPONENTS[component], node_name(model, node))),
        _ => None,
    };
    changes.iter().filter_map(freed).collect()
}

/// How a step might ask to go on from a singular point where it stops, besides what it asks for already.
fn ways_on(model: &Model, index: usize, cause: Cause) -> Vec<&'static str> {
    let asked = model.steps.get(index);
    let method = asked.map_or(Method::Newton, |step| step.method);
    let mut ways = Vec::new();
    if method != Method::Jump {
        ways.push("method = \"jump\" goes on to the next stable equilibrium");
    }
    let bifurcates = cause == Cause::Bifurcation;
    if bifurcates && asked.is_none_or(|step| step.branch == Branch::Stable) {
        ways.push("branch = \"primary\" follows the unstable path");
    } else if method != Method::ArcLength && let_go(model, index).is_empty() {
        // Along the arc nothing can be let go of.
        ways.push(if bifurcates {
            "method = \"arc_length\" looks for it along its arc"
        } else {
            "method = \"arc_length\" follows the path past this point"
        });
    }
    ways
}

fn advice(model: &Model, index: usize, failure: &Failure, place: &str) -> Option<String> {
    let asked = model.steps.get(index);
    Some(match failure.cause {
        Cause::LimitPoint => {
            let ways = ways_on(model, index, failure.cause);
            let before = if ways.is_empty() { String::new() } else { format!("{}; or ", ways.join(", ")) };
            format!(
                "{before}ask for less in this step, or prescribe a displacement, for example of {place}, instead of the load"
            )
        }
        Cause::Bifurcation => {
            let what = match asked.map(|step| step.branch) {
                Some(Branch::Primary) => "the unstable path that branch = \"primary\" asks for was not found beyond this point",
                _ => "no stable branch leads on from there",
            };
            let ways = ways_on(model, index, failure.cause);
            let ways = if ways.is_empty() { String::new() } else { format!(": {}", ways.join(", ")) };
            format!(
                "{what}{ways}; a small imperfection, such as an offset of {place} by a thousandth of the length, shows what \
                 the real network does before"
            )
        }
        Cause::SidewaysBifurcation => {
            "set dimension = \"space\" and give a small force or offset out of the plane, which leads onto the stable \
             branch; dimension = \"plane\" if something holds the network in its plane"
                .to_owned()
        }
        Cause::Unbounded => {
            "a support, a spring or a stop is missing, or the load grows beyond what the network can carry in any shape"
                .to_owned()
        }
        Cause::StepTooSmall if !let_go(model, index).is_empty() => {
            "hold what is loose by a support, a spring or a member, or take it back by a prescribed displacement in place \
             of free"
                .to_owned()
        }
        Cause::StepTooSmall => {
            "look at the units of loads and stiffnesses; split the step, or ask for more increments (increments = 20); \
             apply a prestress that keeps slender members in tension first"
                .to_owned()
        }
        Cause::IllConditioned => {
            "look at the units of the stiffest section and the stiffest spring; a rigid body, a support or \
             stretch = false holds exactly what a very large stiffness holds badly"
                .to_owned()
        }
        Cause::Overheld { .. } => {
            format!("let {place} be stretched (leave out stretch = false), or let one of its ends slide along it")
        }
        Cause::Endless | Cause::LeadsAway if asked.is_some_and(|step| step.method == Method::Jump) => {
            "ask for less in this step; the last limit points say what the network carries along this path".to_owned()
        }
        Cause::Endless | Cause::LeadsAway => {
            "method = \"jump\" goes on from each limit point to the next stable equilibrium; the last limit \
                             points say what the network carries along this path"
                .to_owned()
        }
        Cause::Taut { .. } | Cause::Interrupted => return None,
    })
}

fn worst_residual(model: &Model, failure: &Failure) -> Option<String> {
    // A try that converged, and was taken back for its loss of stability, has none to speak of.
    let node = failure.worst_node.filter(|_| failure.worst_residual > CONVERGED)?;
    let (kind, word) = if failure.worst_component < 3 { ("force", "along") } else { ("moment", "about") };
    Some(format!(
        "the last try, at {}, left its largest residual at {} {word} {}: {:.1e} of the largest {kind}",
        percent(failure.tried),
        node_name(model, node),
        AXES[failure.worst_component % 3],
        failure.worst_residual
    ))
}

/// Muscles in compression at the last state: what kinks is among them.
fn pushed_muscles(model: &Model, step: &StepHistory) -> Option<String> {
    let state = last_state(step)?;
    let strongest = state.members.iter().map(|member| member.axial_force.abs()).fold(0.0, f64::max);
    let pushed = model.members.iter().zip(&state.members);
    let pushed = pushed.filter(|(member, now)| member.is_muscle() && now.axial_force < -1e-6 * strongest);
    let names: Vec<String> = pushed
        .map(|(member, now)| format!("{} ({} {})", shown(&member.name), number(now.axial_force), force_unit(model)))
        .collect();
    (!names.is_empty()).then(|| format!("muscles in compression, which may buckle or kink: {}", list(&names, 3)))
}

/// Where the loads, pressures and prescribed displacements of a step were when it stopped.
fn reached_values(model: &Model, steps: &[StepHistory], index: usize) -> Option<String> {
    let (now, step) = (model.steps.get(index)?, steps.get(index)?);
    let mut groups: Vec<(String, f64, &str, Vec<String>)> = Vec::new();
    for (target, _) in &now.targets {
        let level = loads::levels(model, steps, *target)[index];
        if level[0] == level[1] {
            continue;
        }
        let value = loads::on_the_way(level, step.fraction);
        let (what, unit, name) = target_in_words(model, target);
        match groups.iter_mut().find(|group| group.0 == what && group.1 == value && group.2 == unit) {
            Some(group) => group.3.extend(name),
            None => groups.push((what, value, unit, name.into_iter().collect())),
        }
    }
    let mut values: Vec<String> = groups.into_iter().map(in_words).collect();
    values.extend(now.changes.iter().filter_map(|change| prescribed_value(model, index, step, change)));
    (!values.is_empty()).then(|| format!("reached: {}", list(&values, NAMES)))
}

fn in_words((what, value, unit, names): (String, f64, &str, Vec<String>)) -> String {
    let of = if names.is_empty() { String::new() } else { format!(" in {}", list(&names, 3)) };
    let blank = if unit.is_empty() { "" } else { " " };
    format!("{what} {}{blank}{unit}{of}", number(value))
}

/// What a target moves, its unit, and the member that it belongs to.
fn target_in_words<'a>(model: &'a Model, target: &Target) -> (String, &'a str, Option<String>) {
    let node = |node: NodeId| shown(&model.nodes[node].name);
    let member = |member: usize| Some(shown(&model.members[member].name));
    match *target {
        Target::Control(id) => match model.members[id].kind {
            pennate_models::model::MemberKind::Muscle(muscle) => {
                ("pressure".to_owned(), model.muscles[muscle].pressure_unit.as_str(), member(id))
            }
            _ => ("actuation".to_owned(), "", member(id)),
        },
        Target::Force(id, axis) => (format!("force on {} along {}", node(id), AXES[axis]), force_unit(model), None),
        Target::Moment(id, axis) => (format!("moment on {} about {}", node(id), AXES[axis]), moment_unit(model), None),
        Target::FollowerForce(id, axis) => {
            (format!("follower force on {} along {}", node(id), AXES[axis]), force_unit(model), None)
        }
        Target::FollowerMoment(id, axis) => {
            (format!("follower moment on {} about {}", node(id), AXES[axis]), moment_unit(model), None)
        }
        Target::Gravity(axis) => (format!("gravity along {}", AXES[axis]), "", None),
        Target::Distributed(id, axis) => (format!("distributed force along {}", AXES[axis]), "", member(id)),
    }
}

fn prescribed_value(model: &Model, index: usize, step: &StepHistory, change: &Change) -> Option<String> {
    let (node, component) = match *change {
        Change::Prescribe { node, component, .. } | Change::MoveBy { node, component, .. } => (node, component),
        Change::Hold { .. } | Change::Free { .. } => return None,
    };
    // In turned axes the components of the state are not those of the change.
    let turned = |support: &&pennate_solver::structure::Support| {
        support.node == node && support.axes != [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    };
    if model.supports.iter().any(|support| turned(&support)) {
        return None;
    }
    let now = last_state(step)?.nodes[node];
    let (value, unit) = match component {
        0..3 => (now.displacement[component], model.units.symbols()[0]),
        // The rotation vector of the state is reduced to half a turn.
        _ => match *change {
            Change::Prescribe { to, .. } if index == 0 => ((step.fraction * to).to_degrees(), "deg"),
            _ => (now.rotation[component - 3].to_degrees(), "deg"),
        },
    };
    Some(format!("{} of {} = {} {unit}", COMPONENTS[component], shown(&model.nodes[node].name), number(value)))
}

/// Unit of forces.
pub fn force_unit(model: &Model) -> &'static str {
    model.units.symbols()[1]
}

/// Unit of moments.
pub fn moment_unit(model: &Model) -> &'static str {
    match model.units {
        pennate_models::model::Units::MmNMpa => "N mm",
        pennate_models::model::Units::MNPa => "N m",
    }
}
