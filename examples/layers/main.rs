//! Random strips, threads, taut rods and hanging cables, whose boundary layers are short, against another method.
//!
//! `cargo run --release --example layers [-- COUNT [FIRST]]` solves COUNT networks (200 unless given) from seed FIRST on with
//! default settings, compares every probe with collocation of the rod's equations, and prints a table. It ends with
//! status 1 where an error is larger than ten times the stated one, where more than one in a hundred is larger than three
//! times that, or where a run came to its end without an estimate. `-- 0 SEED` prints a network, and `-- reference` the
//! results of `validation/20_boundary_layers/reference.json`.

mod random;
mod reference;
mod validation;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;
use std::time::Instant;

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_analysis::solution::{Solution, last_state};
use pennate_models::{discretize, read_text};
use pennate_solver::history::Status;
use pennate_solver::options::Options;
use random::{Case, FAMILIES, case};
use rayon::prelude::*;
use reference::{Rod, State, rotation_vector};

const ACCURACY: f64 = 1e-6;
/// Errors below this part of the largest value of their kind are not judged: rounding, and the reference's own error.
const FLOOR: f64 = 1e-9;
/// By how much the reference may change from its coarser mesh.
const TRUSTED: f64 = 1e-9;

/// What came of one network.
struct Outcome {
    seed: u64,
    family: &'static str,
    what: &'static str,
    elements: usize,
    factorizations: usize,
    rounds: usize,
    seconds: f64,
    /// Stated error over the largest value of its kind.
    stated: f64,
    /// Of every probe: true error over the largest value of its kind, and over the stated one.
    probes: Vec<(String, f64, f64)>,
}

fn main() -> ExitCode {
    if std::env::args().nth(1).as_deref() == Some("reference") {
        validation::print();
        return ExitCode::SUCCESS;
    }
    let mut arguments = std::env::args().skip(1).map(|text| text.parse().expect("a number"));
    let count: u64 = arguments.next().unwrap_or(200);
    let first: u64 = arguments.next().unwrap_or(0);
    if count == 0 {
        println!("{}", case(first).text);
        return ExitCode::SUCCESS;
    }
    let one = |seed| catch_unwind(AssertUnwindSafe(|| judge(seed))).unwrap_or_else(|_| empty(seed, "a panic"));
    let outcomes: Vec<Outcome> = (first..first + count).into_par_iter().map(one).collect();
    let mut wrong = false;
    for outcome in &outcomes {
        let worst = outcome.probes.iter().max_by(|a, b| a.2.total_cmp(&b.2));
        let bad = outcome.what != "solved" || worst.is_some_and(|probe| probe.2 > 3.0);
        if bad {
            let text = worst.map_or_else(String::new, |(name, error, ratio)| {
                format!("; {name} is off by {error:.1e}, {ratio:.1} times what is stated")
            });
            println!(
                "seed {}, {}: {}; {} elements, {} meshes, stated {:.1e}{text}",
                outcome.seed, outcome.family, outcome.what, outcome.elements, outcome.rounds, outcome.stated
            );
        }
        wrong |= !matches!(outcome.what, "solved" | "stopped and said so");
    }
    println!(
        "| family | networks | solved | elements | factorizations | meshes | largest error | over the stated: 99 % | largest | ms |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    for family in FAMILIES.into_iter().chain(["all"]) {
        let own: Vec<&Outcome> = outcomes.iter().filter(|one| family == "all" || one.family == family).collect();
        let solved: Vec<&&Outcome> = own.iter().filter(|one| one.what == "solved").collect();
        let mean = |value: &dyn Fn(&Outcome) -> f64| {
            solved.iter().map(|one| value(one)).sum::<f64>() / solved.len().max(1) as f64
        };
        let probes = || solved.iter().flat_map(|one| &one.probes);
        let mut ratios: Vec<f64> = probes().map(|probe| probe.2).collect();
        ratios.sort_by(f64::total_cmp);
        let nearly_all =
            ratios.get(((ratios.len() as f64 * 0.99) as usize).min(ratios.len().max(1) - 1)).copied().unwrap_or(0.0);
        let largest = ratios.last().copied().unwrap_or(0.0);
        println!(
            "| {family} | {} | {} | {:.0} | {:.0} | {:.1} | {:.1e} | {nearly_all:.2} | {largest:.2} | {:.1} |",
            own.len(),
            solved.len(),
            mean(&|one| one.elements as f64),
            mean(&|one| one.factorizations as f64),
            mean(&|one| one.rounds as f64),
            probes().map(|probe| probe.1).fold(0.0, f64::max),
            1e3 * mean(&|one| one.seconds),
        );
        wrong |= family == "all" && (nearly_all > 3.0 || largest > 10.0);
    }
    println!("{} probes", outcomes.iter().map(|one| one.probes.len()).sum::<usize>());
    if wrong { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

fn empty(seed: u64, what: &'static str) -> Outcome {
    let family = FAMILIES[(seed % FAMILIES.len() as u64) as usize];
    let probes = Vec::new();
    Outcome { seed, family, what, elements: 0, factorizations: 0, rounds: 0, seconds: 0.0, stated: f64::NAN, probes }
}

fn judge(seed: u64) -> Outcome {
    let case = case(seed);
    let model = match read_text("layers.toml", &case.text, &[]) {
        Ok(model) => model,
        Err(errors) => {
            println!("seed {seed}: {:?}", errors.errors);
            return empty(seed, "not read");
        }
    };
    let options = Options { estimate: true, shapes: true, ..Options::default() };
    let start = Instant::now();
    let Ok(solution) = solve_to_accuracy(model, ACCURACY, &options, &mut |_| true) else {
        return empty(seed, "a mechanism");
    };
    let seconds = start.elapsed().as_secs_f64();
    let mut outcome = Outcome {
        elements: solution.history.mesh.elements,
        factorizations: solution.history.steps.iter().map(|step| step.factorizations).sum(),
        rounds: solution.accuracy.rounds,
        seconds,
        stated: solution.accuracy.estimated.unwrap_or(f64::NAN),
        ..empty(seed, "solved")
    };
    if solution.status() != Status::Converged {
        outcome.what = "stopped and said so";
        return outcome;
    }
    if solution.accuracy.estimated.is_none() {
        outcome.what = "no estimate";
        return outcome;
    }
    match compare(&case, &solution) {
        Some(probes) => outcome.probes = probes,
        None => outcome.what = "no reference",
    }
    outcome
}

/// States of the rod at both ends after the last step, what they count by, and how far they are to be trusted.
fn reference(case: &Case, solution: &Solution) -> Option<([State; 2], State, f64)> {
    let (structure, _) = discretize(&solution.model, &solution.mesh);
    let member = &structure.members[0];
    let rod = Rod {
        section: structure.laws[member.segments[0].law].at(0.0).section,
        axes: Matrix3::from_columns(&member.axes.map(Vector3::from)),
        length: solution.model.members[0].length,
        weight: case.weight,
        held: case.held,
        turned: case.turned,
        follower: case.follower,
    };
    let step = solution.history.steps.last()?;
    let state = last_state(step)?;
    let points = &step.increments.last()?.shapes[0].points;
    let force = -Vector3::from(state.members[0].end_forces[0]);
    let at = |s: f64| {
        let k = points.partition_point(|point| point.reference[0] <= s).clamp(1, points.len() - 1);
        let [a, b] = [&points[k - 1], &points[k]];
        let t = ((s - a.reference[0]) / (b.reference[0] - a.reference[0])).clamp(0.0, 1.0);
        let place =
            |p: &pennate_solver::history::ShapePoint| Vector3::from(p.reference) + Vector3::from(p.displacement);
        let turn = |rotation: [f64; 3]| UnitQuaternion::from_scaled_axis(Vector3::from(rotation));
        (place(a).lerp(&place(b), t), turn(a.rotation).slerp(&turn(b.rotation), t))
    };
    let largest_moment = state.members[0].end_moments.iter().map(|m| Vector3::from(*m).norm()).fold(0.0, f64::max);
    let scale = State::from_fn(|i, _| match i {
        0..3 => rod.length,
        3..7 => 1.0,
        7..10 => state.members[0].end_forces.iter().map(|f| Vector3::from(*f).norm()).fold(0.0, f64::max),
        _ => largest_moment,
    });
    // Section moments in the middle of the cells, by how the axes turn from one point to the next.
    let bent: Vec<(f64, Vector3<f64>)> = points
        .windows(2)
        .map(|ends| {
            let [a, b] =
                [&ends[0], &ends[1]].map(|p| (p.reference[0], UnitQuaternion::from_scaled_axis(p.rotation.into())));
            let frame = a.1.to_rotation_matrix().matrix() * rod.axes;
            let curvature = frame.transpose() * (b.1 * a.1.inverse()).scaled_axis() / (b.0 - a.0);
            let stiffness = Vector3::new(rod.section.gj, rod.section.ei2, rod.section.ei3);
            (0.5 * (a.0 + b.0), frame * curvature.component_mul(&stiffness))
        })
        .collect();
    let guess = |s: f64| {
        let (place, turn) = at(s);
        let n = force - s * case.weight;
        let k = bent.partition_point(|cell| cell.0 <= s).clamp(1, bent.len() - 1);
        let m = bent[k - 1].1.lerp(&bent[k].1, (s - bent[k - 1].0) / (bent[k].0 - bent[k - 1].0));
        let turn: &Quaternion<f64> = turn.quaternion();
        let sign = if turn.w < 0.0 { -1.0 } else { 1.0 };
        let q = [turn.w, turn.i, turn.j, turn.k].map(|x| sign * x);
        State::from_iterator(place.iter().copied().chain(q).chain(n.iter().copied()).chain(m.iter().copied()))
    };
    let (ends, miss) = rod.solve(&guess, &scale)?;
    (miss <= TRUSTED).then_some((ends, scale, miss))
}

/// True errors of the probes after the last step.
fn compare(case: &Case, solution: &Solution) -> Option<Vec<(String, f64, f64)>> {
    let ([start, end], scale, _) = reference(case, solution)?;
    let largest_moment = scale[10];
    let turned = rotation_vector(&end);
    let probes = solution.probes.steps.last()?;
    let (values, stated) = (probes.last()?, probes.errors()?);
    let mut found = Vec::new();
    for (index, name) in solution.model.probes.names.iter().enumerate() {
        let axis = ["x", "y", "z"].iter().position(|axis| name.ends_with(axis))?;
        let (reference, kind) = match name.rsplit_once('_')?.0 {
            "A_force" => (-start[7 + axis], scale[7]),
            "B_force" => (end[7 + axis], scale[7]),
            "A_moment" => (-start[10 + axis], largest_moment),
            "B_moment" => (end[10 + axis], largest_moment),
            "B_place" => (end[axis] - if axis == 0 { scale[0] } else { 0.0 }, largest_place(solution)),
            _ => (turned[axis].to_degrees(), turned.norm().to_degrees()),
        };
        let error = (values[index] - reference).abs();
        let ratio = (error - FLOOR * kind).max(0.0) / stated[index].max(f64::MIN_POSITIVE);
        found.push((name.clone(), error / kind, ratio));
    }
    Some(found)
}

fn largest_place(solution: &Solution) -> f64 {
    let states = solution.history.steps.iter().filter_map(last_state);
    states.flat_map(|state| &state.nodes).map(|node| Vector3::from(node.displacement).norm()).fold(0.0, f64::max)
}
