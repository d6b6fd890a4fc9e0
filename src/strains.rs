//! What is said of strains beyond what the mechanics of small strains holds for, and of rods that shear makes unstable in
//! tension.

use pennate_analysis::solution::{Solution, last_state};
use pennate_analysis::strains::{self, Excess, GreatestPull, Overload, Pull, Strain, Tension};
use pennate_models::Model;
use pennate_models::model::{Member, MemberId};
use pennate_solver::history::{CriticalKind, StepHistory};

use crate::diagnostics::Message;
use crate::output::text::{list, number, percent, shown};

/// Members named besides the worst one.
const NAMED: usize = 5;

/// What a person should know about the strains of a run.
pub fn warnings(solution: &Solution) -> Vec<Message> {
    let model = &solution.model;
    let Excess { bent, stretched, sheared, pulled } = strains::excess(solution);
    let mut messages = Vec::new();
    messages.extend(beyond(model, &bent, "bent to a strain of"));
    let way =
        if stretched.first().is_some_and(|found| found.peak.value < 0.0) { "compressed by" } else { "stretched by" };
    messages.extend(beyond(model, &stretched, way));
    messages.extend(unstable(model, &sheared));
    messages.extend(overpulled(model, &pulled));
    messages
}

/// What the members of a step's last state say about its failure: one of them is beyond the strain that its shear
/// stiffness lets it be stretched to, or beyond the force that it lets it carry.
pub fn tension(model: &Model, step: &StepHistory) -> Option<String> {
    let Some(Tension { member, stretch, limit }) = strains::tension(model, step) else {
        let Pull { member, force, limit } = strains::last_pull(model, step)?;
        let unit = model.units.symbols()[1];
        return Some(format!(
            "member '{}' is pulled by {} {unit}: a rod that cannot be stretched, but sheared, loses its stability in tension at its \
             shear stiffness, GA = {} {unit}, which is a property of the model and not of the bar; shear = false in its section \
             takes it away",
            shown(&model.members[member].name),
            number(force),
            number(limit)
        ));
    };
    Some(format!(
        "member '{}' is stretched by {}: a shear-flexible rod loses its stability in tension at 1/(EA/GA - 1) = {}, which \
         is a property of the model and not of the bar; shear = false in its section takes it away",
        shown(&model.members[member].name),
        rough(stretch),
        rough(limit)
    ))
}

/// What is said where a path turns back since a member is pulled straight.
pub struct Taut {
    /// Which, and with what force.
    pub note: String,
    /// What would help.
    pub help: String,
}

/// What the last state of a step says of a member that cannot be stretched and is pulled straight.
pub fn taut(model: &Model, step: &StepHistory) -> Option<Taut> {
    let strains::Taut { member, force } = strains::taut(model, step)?;
    Some(pulled(model, member, force, "its ends cannot go any further apart"))
}

/// The same of a member whose force was seen to grow without bound towards the limit point of the step.
pub fn taut_towards(model: &Model, step: &StepHistory, member: MemberId) -> Option<Taut> {
    let force = last_state(step)?.members.get(member)?.axial_force;
    // What a coarser mesh met may be listed behind it.
    let mut points = step.critical_points.iter().rev();
    let limit = percent(points.find(|point| point.kind == CriticalKind::LimitPoint)?.fraction);
    let how = format!("it grows without bound towards {limit} of the ramp, where its ends cannot go any further apart");
    Some(pulled(model, member, force, &how))
}

fn pulled(model: &Model, member: MemberId, force: f64, how: &str) -> Taut {
    let (name, unit) = (shown(&model.members[member].name), model.units.symbols()[1]);
    Taut {
        note: format!(
            "member '{name}' cannot be stretched and is pulled straight, by {force:.1e} {unit} by now: {how}"
        ),
        help: format!(
            "ask for less of what pulls them, or let member '{name}' be stretched (leave out stretch = false, with its EA)"
        ),
    }
}

/// What the loads of a step that got nowhere would do to the bar that they could bend most, if one carried them alone.
pub fn overload(model: &Model, index: usize, step: &StepHistory) -> Option<String> {
    let Overload { member, force, times } = strains::overload(model, index, step)?;
    let member = &model.members[member];
    let [length, unit, _] = model.units.symbols();
    Some(format!(
        "the largest load, {} {unit}, is {times:.0e} times what bends member '{}', {} {length} long, by about its length \
         (F L²/EI): a magnitude may be wrong, such as metres for millimetres",
        number(force),
        shown(&member.name),
        number(member.length)
    ))
}

/// A warning of strains beyond the limit: the worst one with its place, and the names of the others.
fn beyond(model: &Model, found: &[Strain], how: &str) -> Option<Message> {
    let worst = found.first()?;
    let member = &model.members[worst.member];
    let title = format!(
        "member '{}' is {how} {} {}, {}",
        shown(&member.name),
        rough(worst.peak.value.abs()),
        place(model, member, worst.peak.at),
        when(model, worst.step, worst.fraction)
    );
    let limit = rough(model.strain_limit);
    let mut notes = vec![format!(
        "sections are linear elastic: beyond a strain of {limit} that is no longer what most materials do, and a magnitude \
         may be wrong"
    )];
    notes.extend(others(model, &found[1..], &limit));
    let [length, force, stress] = model.units.symbols();
    Some(Message {
        title,
        span: Some(member.span),
        notes,
        help: Some(format!(
            "bare numbers are in {length}, {force} and {stress}: look at section, material and loads; if the strain is \
             meant, raise the limit with strain_limit = {:.1} beside format",
            (1.2 * 10.0 * worst.peak.value.abs()).ceil() / 10.0
        )),
        ..Message::default()
    })
}

fn others(model: &Model, rest: &[Strain], limit: &str) -> Option<String> {
    let name =
        |found: &Strain| format!("'{}' ({})", shown(&model.members[found.member].name), rough(found.peak.value.abs()));
    let names: Vec<String> = rest.iter().map(name).collect();
    (!names.is_empty()).then(|| format!("beyond {limit} as well: {}", list(&names, NAMED)))
}

fn unstable(model: &Model, found: &[Strain]) -> Option<Message> {
    let worst = found.first()?;
    let member = &model.members[worst.member];
    Some(Message {
        title: format!(
            "member '{}' is stretched by {} {}, {}: near or beyond where a shear-flexible rod loses its stability in tension",
            shown(&member.name),
            rough(worst.peak.value),
            place(model, member, worst.peak.at),
            when(model, worst.step, worst.fraction)
        ),
        span: Some(member.span),
        notes: vec![
            "a rod with shear stiffness GA below its axial stiffness EA becomes unstable at the strain 1/(EA/GA - 1): it \
             shears instead of being stretched; that is a property of linear shear, and no real bar does it"
                .to_owned(),
        ],
        help: Some("give its section shear = false; or look at its units, if it should not be stretched so far".to_owned()),
        ..Message::default()
    })
}

fn overpulled(model: &Model, found: &[GreatestPull]) -> Option<Message> {
    let GreatestPull { pull: worst, step, fraction } = found.first()?;
    let member = &model.members[worst.member];
    let unit = model.units.symbols()[1];
    let name = |GreatestPull { pull, .. }: &GreatestPull| {
        format!("'{}' ({} {unit})", shown(&model.members[pull.member].name), number(pull.force))
    };
    let mut notes = vec![format!(
        "a rod that cannot be stretched, but sheared, becomes unstable in tension at its shear stiffness, GA = {} {unit}: it shears, and \
         comes out longer than it is; that is a property of linear shear, and no real bar does it",
        number(worst.limit)
    )];
    let others: Vec<String> = found[1..].iter().map(name).collect();
    notes.extend((!others.is_empty()).then(|| format!("pulled too much as well: {}", list(&others, NAMED))));
    Some(Message {
        title: format!(
            "member '{}' is pulled by {} {unit}, {}: near or beyond where a rod that cannot be stretched, but sheared, loses its \
             stability in tension",
            shown(&member.name),
            number(worst.force),
            when(model, *step, *fraction)
        ),
        span: Some(member.span),
        notes,
        help: Some(
            "give its section shear = false; or look at its units, if it should not be pulled so much".to_owned(),
        ),
        ..Message::default()
    })
}

/// Where on a member, as a part of its length and the node that is nearest.
fn place(model: &Model, member: &Member, at: f64) -> String {
    let end = usize::from(at > 0.5);
    let node = shown(&model.nodes[member.nodes[end]].name);
    format!("at {} of its length from node '{node}'", rough(if end == 0 { at } else { 1.0 - at }))
}

fn when(model: &Model, step: usize, fraction: f64) -> String {
    let name = shown(model.step_names()[step]);
    match fraction >= 1.0 {
        true => format!("at the end of step '{name}'"),
        false => format!("at {} of step '{name}'", percent(fraction)),
    }
}

/// A part in percent with two digits: strains at integration points are worth no more.
fn rough(part: f64) -> String {
    let percent = 100.0 * part;
    match percent.abs() {
        0.0 => "0 %".to_owned(),
        size if size >= 10.0 => format!("{percent:.0} %"),
        size if size >= 0.1 => format!("{percent:.1} %"),
        _ => format!("{percent:.1e} %"),
    }
}
