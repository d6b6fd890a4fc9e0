//! Strains beyond what the mechanics of small strains holds for, and rods that shear makes unstable in tension.

use pennate_models::Model;
use pennate_models::model::{Member, SegmentLaw, Target};
use pennate_solver::history::{MemberState, Peak, StepHistory};

use crate::diagnostics::Message;
use crate::output::text::{list, number, percent, shown};
use crate::solution::{Solution, last_state};

/// Members named besides the worst one.
const NAMED: usize = 5;
/// Part of the strain at which a rod becomes unstable in tension from which on that is said.
const CLOSE: f64 = 0.9;

/// A strain that a member had, and when.
#[derive(Clone, Copy, Debug)]
struct Found {
    member: usize,
    peak: Peak,
    step: usize,
    fraction: f64,
}

/// What a person should know about the strains of a run.
pub fn warnings(solution: &Solution) -> Vec<Message> {
    let model = &solution.model;
    let sheared = greatest(solution, |model, member, state| {
        let limit = model.tensile_limit(member, state.control)?;
        (state.stretch.value >= CLOSE * limit).then_some(state.stretch)
    });
    let limit = model.strain_limit;
    let over = |peak: Peak| (peak.value.abs() > limit).then_some(peak);
    let bent = greatest(solution, |model, member, state| {
        let member = &model.members[member];
        over(state.bending).filter(|_| !member.is_muscle() && is_solid(member))
    });
    let stretched =
        greatest(solution, |model, member, state| over(state.stretch).filter(|_| !model.members[member].is_muscle()));
    let told = |found: &Found| sheared.iter().any(|other| other.member == found.member);
    let stretched: Vec<Found> = stretched.into_iter().filter(|found| !told(found)).collect();
    let mut messages = Vec::new();
    messages.extend(beyond(model, &bent, "bent to a strain of"));
    let way =
        if stretched.first().is_some_and(|found| found.peak.value < 0.0) { "compressed by" } else { "stretched by" };
    messages.extend(beyond(model, &stretched, way));
    messages.extend(unstable(model, &sheared));
    messages
}

/// Whether a bar has a solid section somewhere. Tubes are what muscles are made of, and bend by more.
fn is_solid(member: &Member) -> bool {
    member.segments.iter().any(|segment| match &segment.material {
        SegmentLaw::Fixed(law) => law.shape.is_some_and(|shape| shape.is_solid),
        SegmentLaw::MuscleEnd(_) | SegmentLaw::MuscleMiddle(_) => false,
    })
}

/// What the members of a step's last state say about its failure: one of them is beyond the strain that its shear
/// stiffness lets it be stretched to.
pub fn tension(model: &Model, step: &StepHistory) -> Option<String> {
    let state = last_state(step)?;
    let near = model.members.iter().zip(&state.members).enumerate().find_map(|(index, (member, now))| {
        let limit = model.tensile_limit(index, now.control)?;
        (now.stretch.value >= CLOSE * limit).then_some((member, now.stretch.value, limit))
    });
    let (member, value, limit) = near?;
    Some(format!(
        "member '{}' is stretched by {}: a shear-flexible rod loses its stability in tension at 1/(EA/GA - 1) = {}, which \
         is a property of the model and not of the bar; shear = false in its section takes it away",
        shown(&member.name),
        rough(value),
        rough(limit)
    ))
}

/// What the loads of a step that got nowhere would do to the bar that they could bend most, if one carried them alone.
pub fn overload(model: &Model, index: usize, step: &StepHistory) -> Option<String> {
    /// Beyond this many times the load that would bend a bar by about its length, no bar is meant to carry it.
    const ABSURD: f64 = 1e4;
    if step.fraction > 0.01 {
        return None;
    }
    let targets = model.steps.get(..=index)?.iter().flat_map(|step| &step.targets);
    let force = targets.filter_map(|(target, value)| match target {
        Target::Force(..) | Target::FollowerForce(..) => Some(value.abs()),
        _ => None,
    });
    let force = force.fold(0.0, f64::max);
    let bends = |member: &Member| {
        let stiffness = member.segments.iter().filter_map(|segment| match &segment.material {
            SegmentLaw::Fixed(law) => Some(law.section.ei2.min(law.section.ei3)),
            SegmentLaw::MuscleEnd(_) | SegmentLaw::MuscleMiddle(_) => None,
        });
        Some(force * member.length.powi(2) / stiffness.reduce(f64::min)?)
    };
    let all = model.members.iter().filter_map(|member| Some((member, bends(member)?)));
    let (member, times) = all.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, times)| *times > ABSURD)?;
    let [length, unit, _] = model.units.symbols();
    Some(format!(
        "the largest load, {} {unit}, is {times:.0e} times what bends member '{}', {} {length} long, by about its length \
         (F L²/EI): a magnitude may be wrong, such as metres for millimetres",
        number(force),
        shown(&member.name),
        number(member.length)
    ))
}

/// The greatest strain of every member that `of` takes, the greatest of all first.
fn greatest(solution: &Solution, of: impl Fn(&Model, usize, &MemberState) -> Option<Peak>) -> Vec<Found> {
    let model = &solution.model;
    let mut worst: Vec<Option<Found>> = vec![None; model.members.len()];
    for (step, record) in solution.history.steps.iter().enumerate() {
        for increment in &record.increments {
            for (member, state) in increment.state.members.iter().enumerate() {
                let Some(peak) = of(model, member, state) else { continue };
                if worst[member].is_none_or(|before| peak.value.abs() > before.peak.value.abs()) {
                    worst[member] = Some(Found { member, peak, step, fraction: increment.fraction });
                }
            }
        }
    }
    let mut all: Vec<Found> = worst.into_iter().flatten().collect();
    all.sort_by(|a, b| b.peak.value.abs().total_cmp(&a.peak.value.abs()));
    all
}

/// A warning of strains beyond the limit: the worst one with its place, and the names of the others.
fn beyond(model: &Model, found: &[Found], how: &str) -> Option<Message> {
    let worst = found.first()?;
    let member = &model.members[worst.member];
    let title = format!(
        "member '{}' is {how} {} {}, {}",
        shown(&member.name),
        rough(worst.peak.value.abs()),
        place(model, member, worst.peak.at),
        when(model, worst)
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
        label: None,
        notes,
        help: Some(format!(
            "bare numbers are in {length}, {force} and {stress}: look at section, material and loads; if the strain is \
             meant, raise the limit with strain_limit = {:.1} beside format",
            (1.2 * 10.0 * worst.peak.value.abs()).ceil() / 10.0
        )),
    })
}

fn others(model: &Model, rest: &[Found], limit: &str) -> Option<String> {
    let name =
        |found: &Found| format!("'{}' ({})", shown(&model.members[found.member].name), rough(found.peak.value.abs()));
    let names: Vec<String> = rest.iter().map(name).collect();
    (!names.is_empty()).then(|| format!("beyond {limit} as well: {}", list(&names, NAMED)))
}

fn unstable(model: &Model, found: &[Found]) -> Option<Message> {
    let worst = found.first()?;
    let member = &model.members[worst.member];
    Some(Message {
        title: format!(
            "member '{}' is stretched by {} {}, {}: near or beyond where a shear-flexible rod loses its stability in tension",
            shown(&member.name),
            rough(worst.peak.value),
            place(model, member, worst.peak.at),
            when(model, worst)
        ),
        span: Some(member.span),
        label: None,
        notes: vec![
            "a rod with shear stiffness GA below its axial stiffness EA becomes unstable at the strain 1/(EA/GA - 1): it \
             shears instead of being stretched; that is a property of linear shear, and no real bar does it"
                .to_owned(),
        ],
        help: Some("give its section shear = false; or look at its units, if it should not be stretched so far".to_owned()),
    })
}

/// Where on a member, as a part of its length and the node that is nearest.
fn place(model: &Model, member: &Member, at: f64) -> String {
    let end = usize::from(at > 0.5);
    let node = shown(&model.nodes[member.nodes[end]].name);
    format!("at {} of its length from node '{node}'", rough(if end == 0 { at } else { 1.0 - at }))
}

fn when(model: &Model, found: &Found) -> String {
    let name = shown(model.step_names()[found.step]);
    match found.fraction >= 1.0 {
        true => format!("at the end of step '{name}'"),
        false => format!("at {} of step '{name}'", percent(found.fraction)),
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
