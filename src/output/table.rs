//! The short table that a person reads.

use std::fmt::Write;

use pennate_analysis::accuracy::Verdict;
use pennate_analysis::solution::{
    NodeError, Solution, diagonal, fewest_digits, largest_force, last_state, norm, status_name, whole_digits,
};
use pennate_models::Model;
use pennate_models::probes::ProbeKind;
use pennate_solver::history::{
    CriticalKind, CriticalPoint, Equilibrium, Growth, Jump, Note, Status, StepHistory, Vibration,
};
use pennate_solver::structure::{Dimension, MemberId, NodeId};

use super::text::{Align, columns, duration, estimate, list, number, percent, shown, undecided};
use crate::explain::{force_unit, moment_unit};

/// Steps that get a column of their own; of more the last ones.
const STEP_COLUMNS: usize = 5;
/// Rows of nodes at most, where there are no probes.
const NODE_ROWS: usize = 20;
/// Members that a remark names before it counts the rest.
const MEMBERS: usize = 6;
/// Part of what the network's size or forces suggest below which a number is rounding.
const ROUNDING: f64 = 1e-12;

/// The whole report of a run.
pub fn report(solution: &Solution) -> String {
    let mut parts = vec![headline(solution), steps(solution)];
    parts.push(if solution.model.probes.names.is_empty() { nodes(solution) } else { probes(solution) });
    parts.push(remarks(solution));
    parts.retain(|part| !part.is_empty());
    parts.join("\n")
}

/// What a network is, in a line or two.
pub fn summary(model: &Model) -> String {
    let dimension = match model.dimension {
        Dimension::Plane => "plane",
        Dimension::Space => "spatial",
    };
    let mut parts = vec![counted(model.nodes.len(), "node")];
    let muscles = model.members.iter().filter(|member| member.is_muscle()).count();
    let counts = [
        (muscles, "muscle"),
        (model.members.len() - muscles, "member"),
        (model.bodies.len(), "rigid body"),
        (model.springs.len(), "spring"),
    ];
    parts.extend(counts.iter().filter(|(count, _)| *count > 0).map(|(count, noun)| counted(*count, noun)));
    format!("{dimension} network of {}; units {}", super::text::list(&parts, parts.len()), model.units.name())
}

/// What `pennate check` says of a network in which it finds nothing wrong.
pub fn checked(model: &Model) -> String {
    let count = match model.steps.len() {
        0 => "no steps: prestress alone".to_owned(),
        1 => "1 step".to_owned(),
        many => format!("{many} steps"),
    };
    format!("{}; {count}; ready to be solved", summary(model))
}

fn counted(count: usize, noun: &str) -> String {
    match (count, noun.strip_suffix('y')) {
        (1, _) => format!("1 {noun}"),
        (_, Some(stem)) => format!("{count} {stem}ies"),
        (_, None) => format!("{count} {noun}s"),
    }
}

fn headline(solution: &Solution) -> String {
    let mut out = String::new();
    if !solution.model.title.is_empty() {
        let _ = writeln!(out, "{}", shown(&solution.model.title));
    }
    let mesh = solution.history.mesh;
    let size = format!("{}, {}", counted(mesh.elements, "element"), counted(mesh.unknowns, "unknown"));
    let _ = writeln!(out, "{}; {size}", summary(&solution.model));
    out
}

fn steps(solution: &Solution) -> String {
    let head = ["step", "status", "reached", "increments", "iterations", "stable"];
    let mut rows = vec![head.map(String::from).to_vec()];
    for (name, step) in solution.steps() {
        rows.push(vec![
            shown(name),
            status_name(step.status).replace('_', " "),
            percent(step.fraction),
            step.increments.len().to_string(),
            step.iterations.to_string(),
            stability(solution.model.dimension, step),
        ]);
    }
    use Align::{Left, Right};
    columns(&[Left, Left, Right, Right, Right, Left], &rows)
}

fn stability(dimension: Dimension, step: &StepHistory) -> String {
    let verdict = match (step.stable, undecided(step)) {
        _ if step.increments.is_empty() => return "-".to_owned(),
        (None, Some(why)) => return format!("not known: {why}"),
        (None, None) => return "not known: the loads have no potential".to_owned(),
        (Some(true), _) => "yes".to_owned(),
        (Some(false), _) if step.vibration.is_some() => match step.vibration.map(|vibration| vibration.growth) {
            Some(Growth::Flutter { .. }) => "NO, it flutters".to_owned(),
            _ => "NO, it diverges".to_owned(),
        },
        (Some(false), _) => format!("NO, {}", counted(step.negative_pivots, "negative pivot")),
    };
    if dimension == Dimension::Plane && step.stability == Dimension::Plane {
        format!("{verdict}, in the plane")
    } else {
        verdict
    }
}

/// One row a probe, one column a step.
fn probes(solution: &Solution) -> String {
    let model = &solution.model;
    let done: Vec<(&str, usize)> = solution
        .steps()
        .enumerate()
        .filter(|(_, (_, step))| !step.increments.is_empty())
        .map(|(index, (name, _))| (name, index))
        .collect();
    let shown_steps = &done[done.len().saturating_sub(STEP_COLUMNS)..];
    let head = ["probe".to_owned()].into_iter().chain(shown_steps.iter().map(|(name, _)| shown(name)));
    let mut rows = vec![head.chain(["unit".to_owned(), "error".to_owned()]).collect::<Vec<_>>()];
    let scales = Scales::of_run(solution);
    for (index, name) in model.probes.names.iter().enumerate() {
        let mut row = vec![shown(name)];
        let values: Vec<f64> =
            shown_steps.iter().filter_map(|&(_, step)| Some(solution.probes.steps[step].last()?[index])).collect();
        let scale = scales.of(model.probes.kind(index));
        row.extend(values.iter().map(|&value| rounded(value, scale)));
        let errors = shown_steps.iter().filter_map(|&(_, step)| Some(solution.probes.steps[step].errors()?[index]));
        row.push(unit(model, model.probes.kind(index)).to_owned());
        row.push(errors.reduce(f64::max).map_or_else(|| "-".to_owned(), estimate));
        rows.push(row);
    }
    let mut align = vec![Align::Right; shown_steps.len() + 3];
    align[0] = Align::Left;
    align[shown_steps.len() + 1] = Align::Left;
    columns(&align, &rows)
}

fn rounded(value: f64, scale: f64) -> String {
    number(if value.abs() <= ROUNDING * scale { 0.0 } else { value })
}

/// What the network's size and forces suggest about its numbers.
struct Scales {
    size: f64,
    force: f64,
}

impl Scales {
    fn of_run(solution: &Solution) -> Self {
        let states = solution.history.steps.iter().filter_map(last_state);
        Self {
            size: diagonal(solution.model.nodes.iter().map(|node| node.position)),
            force: states.map(largest_force).fold(0.0, f64::max),
        }
    }

    fn of(&self, kind: ProbeKind) -> f64 {
        match kind {
            ProbeKind::Displacement => self.size,
            ProbeKind::Rotation => 90.0,
            ProbeKind::Force => self.force,
            ProbeKind::Moment | ProbeKind::GreatestMoment => self.force * self.size,
            ProbeKind::Stress | ProbeKind::Strain | ProbeKind::Other => 0.0,
        }
    }
}

/// Unit of what a probe gives.
pub fn unit(model: &Model, kind: ProbeKind) -> &'static str {
    match kind {
        ProbeKind::Displacement => model.units.symbols()[0],
        ProbeKind::Rotation => "deg",
        ProbeKind::Force => force_unit(model),
        ProbeKind::Moment | ProbeKind::GreatestMoment => moment_unit(model),
        ProbeKind::Stress => model.units.symbols()[2],
        ProbeKind::Strain | ProbeKind::Other => "",
    }
}

/// Unit of a probe, by its place; empty for an expression, and for what has none.
pub fn probe_unit(model: &Model, index: usize) -> &'static str {
    if index < model.probes.len() { unit(model, model.probes.kind(index)) } else { "" }
}

/// Displacements and reactions of the nodes at the end of the last step.
fn nodes(solution: &Solution) -> String {
    let model = &solution.model;
    let steps = solution.steps().zip(&solution.errors);
    let Some((name, step, state, errors)) =
        steps.filter_map(|((name, step), errors)| Some((name, step, last_state(step)?, errors))).last()
    else {
        return String::new();
    };
    let [length, force, _] = model.units.symbols();
    let mut rows = vec![node_head(model.dimension, length, force)];
    let scales = Scales::of_run(solution);
    for index in 0..model.nodes.len().min(NODE_ROWS) {
        rows.push(node_row(model, (state, errors), index, &scales));
    }
    let mut align = vec![Align::Right; rows[0].len()];
    align[0] = Align::Left;
    let place = match (step.prestress, step.fraction) {
        (Some(part), _) => format!("at {} of the prestress, before '{}'", percent(part), shown(name)),
        (None, 1.0) => format!("after '{}'", shown(name)),
        (None, part) => format!("at {} of '{}'", percent(part), shown(name)),
    };
    let mut out = format!("{place}:\n{}", columns(&align, &rows));
    if model.nodes.len() > NODE_ROWS {
        let _ = writeln!(out, "… and {} more (-o DIR writes all)", counted(model.nodes.len() - NODE_ROWS, "node"));
    }
    out
}

fn node_head(dimension: Dimension, length: &str, force: &str) -> Vec<String> {
    let axes: &[&str] = if dimension == Dimension::Plane { &["x", "y"] } else { &["x", "y", "z"] };
    let mut head = vec!["node".to_owned()];
    head.extend(axes.iter().map(|axis| format!("u{axis}, {length}")));
    head.push(if dimension == Dimension::Plane { "turn, deg" } else { "turned by, deg" }.to_owned());
    head.extend(axes.iter().map(|axis| format!("reaction {axis}, {force}")));
    head.push("error of u".to_owned());
    head
}

fn node_row(
    model: &Model,
    (state, errors): (&Equilibrium, &[NodeError]),
    index: usize,
    scales: &Scales,
) -> Vec<String> {
    let node = &state.nodes[index];
    let plane = model.dimension == Dimension::Plane;
    let axes = if plane { 2 } else { 3 };
    let turn = if plane { node.rotation_total } else { norm(node.rotation) };
    let mut row = vec![shown(&model.nodes[index].name)];
    row.extend(node.displacement[..axes].iter().map(|&value| rounded(value, scales.of(ProbeKind::Displacement))));
    row.push(rounded(turn.to_degrees(), scales.of(ProbeKind::Rotation)));
    row.extend(node.reaction_force[..axes].iter().map(|&value| rounded(value, scales.of(ProbeKind::Force))));
    row.push(errors.get(index).map_or_else(|| "-".to_owned(), |error| estimate(error.displacement)));
    row
}

/// What a reader must know besides, one sentence a line.
fn remarks(solution: &Solution) -> String {
    let mut out = String::new();
    let open = |step: &StepHistory| !step.increments.is_empty() && step.stable.is_none() && undecided(step).is_none();
    if solution.steps().any(|(_, step)| open(step)) {
        let _ = writeln!(
            out,
            "Whether a state under loads without a potential is stable is told by small vibrations, where every member has a \
             density and the mesh has no more than 5,000 unknowns."
        );
    }
    for (name, step) in solution.steps() {
        for point in &step.critical_points {
            let _ = writeln!(out, "{}: {}", shown(name), critical_point(&solution.model, point));
        }
        for jump in &step.jumps {
            let _ = writeln!(out, "{}: {}", shown(name), jump_in_words(&solution.model, jump));
        }
        if let Some(vibration) = &step.vibration {
            let _ = writeln!(out, "{}: {}", shown(name), vibration_in_words(&solution.model, vibration));
        }
        for note in notes_in_words(&solution.model, &step.notes) {
            let _ = writeln!(out, "{}: {note}", shown(name));
        }
    }
    if let Some(why) = &solution.model.why_space {
        let _ = writeln!(out, "Solved in space: {}.", shown(why.trim_end_matches('.')));
    }
    let _ = writeln!(out, "{}", accuracy(solution));
    out
}

fn critical_point(model: &Model, point: &CriticalPoint) -> String {
    let kind = match point.kind {
        CriticalKind::LimitPoint => "limit point",
        CriticalKind::Bifurcation => "bifurcation",
    };
    let sideways = if point.sideways { " out of the plane" } else { "" };
    let place = place(model, point.node, point.member);
    let error = point.error.map_or_else(|| "not known".to_owned(), estimate);
    let of = if point.in_prestress { " of the prestress" } else { "" };
    // What lies at the beginning by rounding lies there, without a sign.
    let fraction = if point.fraction.abs() < 5e-10 { 0.0 } else { point.fraction };
    format!("{kind}{sideways} at fraction {fraction:.9}{of} (error {error}), where {place} moves most.")
}

/// The member that something is said of, or else the node.
fn place(model: &Model, node: NodeId, member: Option<MemberId>) -> String {
    match member {
        Some(member) => format!("member {}", shown(&model.members[member].name)),
        None => format!("node {}", shown(&model.nodes[node].name)),
    }
}

fn jump_in_words(model: &Model, jump: &Jump) -> String {
    let [length, force] = [model.units.symbols()[0], model.units.symbols()[1]];
    format!(
        "snapped at {} to the next stable equilibrium: {} moved by {} {length}, {} {force} {length} of energy were released.",
        percent(jump.fraction),
        place(model, jump.node, jump.member),
        number(jump.moved),
        number(jump.released),
    )
}

fn vibration_in_words(model: &Model, vibration: &Vibration) -> String {
    let mass = format!("without damping, and with a mass of {} {} in all", number(vibration.mass), model.units.mass());
    let fold = |rate: f64| format!("e-fold in {} (error {:.1e})", duration(1.0 / rate), vibration.error);
    match vibration.growth {
        Growth::None => format!("the loads have no potential; no small vibration grows, {mass}."),
        Growth::Divergence { rate } => {
            format!("the loads have no potential; a small motion grows {}, {mass}.", fold(rate))
        }
        Growth::Flutter { frequency, rate } => format!(
            "the loads have no potential; a vibration of {} Hz grows {}, {mass}.",
            number(frequency / std::f64::consts::TAU),
            fold(rate)
        ),
    }
}

/// So many singular states that were touched in one step are told of one by one.
const FEW_TOUCHED: usize = 3;

/// Remarks on a step, as sentences; of many singular states that were touched, one for all.
pub(super) fn notes_in_words(model: &Model, notes: &[Note]) -> Vec<String> {
    let touched = |note: &Note| match note {
        Note::TouchedSingular { fraction } => Some(*fraction),
        _ => None,
    };
    let fractions: Vec<f64> = notes.iter().filter_map(touched).collect();
    let (first, last) = match fractions[..] {
        [first, .., last] if fractions.len() > FEW_TOUCHED => (first, last),
        _ => return notes.iter().map(|note| note_in_words(model, note)).collect(),
    };
    let others = notes.iter().filter(|note| touched(note).is_none()).map(|note| note_in_words(model, note));
    let all = format!(
        "touched singular states {} times, between {} and {}, and went on, its stability unchanged: some motion needs no \
         force there, as far as rounding can tell, so what is shown may be one of many that are equally near, as for a rod \
         that is as stiff against twist as against bending, or another way may go on.",
        fractions.len(),
        percent(first),
        percent(last)
    );
    std::iter::once(all).chain(others).collect()
}

/// A remark on a step, as a sentence.
fn note_in_words(model: &Model, note: &Note) -> String {
    match note {
        Note::EndlessMoment { node } => format!(
            "the moment on node {} has no potential: a node that turns over and over takes energy from it without end, so \
             the energy falls without bound and the equilibrium found is one of many.",
            shown(&model.nodes[*node].name)
        ),
        Note::TouchedSingular { fraction } => {
            format!(
                "touched a singular state at {} and went on, its stability unchanged: another way may go on from there, as \
                 where the bars of a linkage come into one line.",
                percent(*fraction)
            )
        }
        Note::Undetermined { members } => {
            let names: Vec<String> = members.iter().map(|&member| shown(&model.members[member].name)).collect();
            format!(
                "nothing determines the axial force of {}, which cannot be stretched and whose ends cannot come nearer: any \
                 force that the joints pass on is in equilibrium, and what is shown, with the reactions and the stability that \
                 depend on it, is one of them. Let it be stretched, or let one end slide.",
                list(&names, MEMBERS)
            )
        }
        Note::TurnedAboutItself { members } => {
            let names: Vec<String> = members.iter().map(|&member| shown(&model.members[member].name)).collect();
            format!(
                "what bends {} would turn it about itself, and pins at both ends hold nothing against that: one end is kept from \
                 turning, so what is shown depends on the way there. Let a node hold it, with release = [\"ry\", \"rz\"] at one \
                 end in place of \"pin\".",
                list(&names, MEMBERS)
            )
        }
        Note::WouldTurn { members } => {
            let names: Vec<String> = members.iter().map(|&member| shown(&model.members[member].name)).collect();
            format!(
                "not stable: nothing keeps {} from turning about itself, which its loads want: it is bent about an axis about \
                 which it is stiffer than about others, and would turn until it is not. Hold that turn at a node, by \"rx\" in \
                 its axes or by welding an end, or turn the section.",
                list(&names, MEMBERS)
            )
        }
        Note::SpinsUnknown => {
            "whether bars that nothing keeps from turning about themselves would turn is not known.".to_owned()
        }
        Note::Untaken { nodes } => {
            let names: Vec<String> = nodes.iter().map(|&node| shown(&model.nodes[node].name)).collect();
            format!(
                "{} kept from turning about hinges, as what turns there would only turn about itself; by now something acts about \
                 these in part, and a moment there is taken by nothing. Hold the rotation of a node along the axes of its hinges, or across \
                 all of them, or weld an end.",
                if let [name] = &names[..] { format!("{name} is") } else { format!("{} are", list(&names, MEMBERS)) }
            )
        }
        Note::TurnsFreely { nodes, axis } => {
            let names: Vec<String> = nodes.iter().map(|&node| shown(&model.nodes[node].name)).collect();
            format!(
                "nothing resists turning what lay on the line through {} about it, along ({}): it has bent or leans, and the direction \
                 in which it does is one of many. Displacements across that line, and moments, are those of the direction shown; a small \
                 force across it decides.",
                list(&names, MEMBERS),
                axis.map(number).join(", ")
            )
        }
        Note::WholeTurn { node, .. } => format!(
            "turns {} to a whole turn or through it, with other rotations free: a whole turn is the same rotation about any axis, so \
             what is held does not tell there how the node is turned, and where the path goes on may depend on the increments. \
             Hold all three rotations, with release = [\"ry\", \"rz\"] where the end of a member is to turn.",
            shown(&model.nodes[*node].name)
        ),
        Note::WithinRounding => {
            "the end is a singular state, as far as rounding can tell: whether it is stable is not known.".to_owned()
        }
        Note::TooCoarse => {
            "elements of the next order have another verdict on the end: it is nearer to a singular state than the mesh can tell."
                .to_owned()
        }
        Note::Crowded(crowd) => {
            let on_others = match crowd.other {
                Some(other) => format!(
                    "; at the end elements of the next order, which bend in shorter waves, have {}, and finer ones others again",
                    counted(other, "negative pivot")
                ),
                None => String::new(),
            };
            format!(
                "{} of stability between {} and {} that are not located one by one, since many motions are unstable there already{on_others}.",
                counted(crowd.changes, "change"),
                percent(crowd.from),
                percent(crowd.to)
            )
        }
        Note::VibrationsUnknown => {
            "small vibrations about the end differ from one mesh to the next: whether it is stable is not known.".to_owned()
        }
        Note::StabilityInPlane => "stability is judged in the plane alone.".to_owned(),
        Note::NoPotentialOutOfPlane => {
            "stability is judged in the plane alone: out of it the loads have no potential.".to_owned()
        }
    }
}

fn accuracy(solution: &Solution) -> String {
    let accuracy = solution.accuracy;
    let time = solution.timing.solve.as_secs_f64() + solution.timing.estimate.as_secs_f64();
    let took = format!("Took {}", duration(time));
    let Some(error) = accuracy.estimated else {
        return match solution.status() {
            Status::Converged => format!("{took}; NO ERROR ESTIMATE: the figures may be wrong by any amount."),
            _ if solution.history.steps.iter().any(|step| step.status == Status::Converged) => {
                format!("{took}; no error estimate, not even of the steps that reached their end.")
            }
            _ => format!("{took}; no error estimate, because no step reached its end."),
        };
    };
    let digits = fewest_digits(&solution.history)
        .map_or_else(String::new, |(.., digits)| format!("; rounding leaves {} digits", whole_digits(digits)));
    let found = format!("{took}{digits}; estimated error {} of the largest values", estimate(error));
    let asked = format!("more than the {} asked for", estimate(accuracy.asked));
    match accuracy.verdict {
        Verdict::Met | Verdict::NotEstimated => format!("{found}."),
        Verdict::UnknownPoints => format!("{found}, but for singular points, whose errors are not all known."),
        Verdict::Forced => format!("{found}, {asked}: the file forces the number of elements."),
        Verdict::TooFine => format!("{found}, {asked}: it would take too fine a mesh."),
        Verdict::Stalled => format!("{found}, {asked}: elements half as long make it no better."),
        Verdict::PathLost if error <= accuracy.asked => {
            format!("{found}, but the finer mesh that was to confirm it got less far along the path.")
        }
        Verdict::PathLost => format!("{found}, {asked}: the finer mesh got less far along the path."),
        Verdict::Interrupted => format!("{found}, {asked}: interrupted before the finer mesh was solved."),
    }
}
