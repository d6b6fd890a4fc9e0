//! Random valid networks with steps of every kind, each state checked without the solver.
//!
//! `cargo run --release --example hostile [-- COUNT [FIRST [NODES]] [every]]` solves COUNT networks (10,000 unless given) from
//! seed FIRST on, in the plane and in space, and prints how they ended. Most have up to 16 nodes, one in twenty has up to
//! NODES (110, which makes up to 200 members); every other one has curved members and members of several segments too, and
//! half of them members that cannot be stretched or sheared, or hardly. The verdict on the stability of the last state is
//! held against the lowest mode of vibration about it. A step that stops short is tried again in small increments, which
//! must stop it too, and one under loads without a potential that lost positive pivots must end where small increments do;
//! with `every`, which takes ten times as long, each one must. What is wrong is listed by its seed, and ends the program
//! with status 1: a state that is no equilibrium, a cause that was not confirmed, a panic, a network refused, a run beyond
//! its time. `-- show SEED` prints one of the networks as a file, and how its steps ended.

mod clock;

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use clock::Clock;
use pennate_solver::history::{Equilibrium, History, Note, Status, StepHistory};
use pennate_solver::options::Options;
use pennate_solver::structure::{Change, Formulation, Method, Step, Stop};
use pennate_testing::random::check::{Residual, residual};
use pennate_testing::random::network::{LENGTH, Network, Vector};
use pennate_testing::random::stiff::stiff_case;
use pennate_testing::verdict::{self, Verdict};
use pennate_testing::write::write;
use rayon::prelude::*;

/// Time of one run.
const BUDGET: Duration = Duration::from_secs(20);
/// Time after which the runs of a network, three of them at most, hang: they were told to stop.
const HANGS: Duration = Duration::from_secs(120);
/// Residual of the joints, over the largest force or moment, beyond so many times what the run says that rounding leaves of
/// forces and moments.
const JOINTS: f64 = 1e-7;
const TIMES_ROUNDING: f64 = 10.0;
/// Distance of a component from where a step holds it or was to stop, in lengths of a member or radians.
const PLACES: f64 = 1e-6;
/// Miss of an integrated member over its length, on the mesh in use or on the finer one.
const MEMBERS: f64 = 1e-3;
/// Part of that miss which a mesh of twenty elements for one may leave: they converge by the square of their size at least.
const FALLS: f64 = 1e-2;
/// Distance of a node between two runs that end alike, in lengths of a member.
const NEAR: f64 = 1e-5;
/// Increments of a step that is tried again; the smaller ones, where the others end elsewhere.
const SMALL: [usize; 2] = [100, 1000];

fn main() -> std::process::ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let ["show", seed] = arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        show(seed.parse().expect("a seed"));
        return std::process::ExitCode::SUCCESS;
    }
    let (words, numbers): (Vec<_>, Vec<_>) = arguments.into_iter().partition(|text| text == "every");
    let every = !words.is_empty();
    let mut arguments = numbers.iter().map(|text| text.parse().expect("a number"));
    let count: u64 = arguments.next().unwrap_or(10_000);
    let first: u64 = arguments.next().unwrap_or(0);
    let most: u64 = arguments.next().unwrap_or(110).max(4);
    std::panic::set_hook(Box::new(|_| {}));
    let start = Instant::now();
    let outcomes: Vec<Outcome> = (first..first + count)
        .into_par_iter()
        .map(|seed| {
            let judged = catch_unwind(AssertUnwindSafe(|| judge(seed, most as usize, every)));
            let outcome = judged.unwrap_or(Outcome::bad("a panic"));
            if outcome.wrong || outcome.what.contains("out of time") {
                println!("seed {seed}: {} {}", outcome.what, outcome.detail);
            }
            outcome
        })
        .collect();
    let mut table: BTreeMap<&str, usize> = BTreeMap::new();
    let (mut states, mut worst, mut slowest) = (0, Residual::default(), Duration::ZERO);
    for outcome in &outcomes {
        *table.entry(outcome.what).or_default() += 1;
        states += outcome.states;
        worst.join(&outcome.residual);
        slowest = slowest.max(outcome.time);
    }
    println!("| how it ended | networks |\n|---|---:|");
    table.iter().for_each(|(what, count)| println!("| {what} | {count} |"));
    println!(
        "\n{states} states and {} members of them checked: joints within {:.1e}, members within {:.1e}, places within \
         {:.1e}; slowest {slowest:.1?}, all {:.0?}",
        worst.integrated,
        worst.joints,
        worst.members,
        worst.places,
        start.elapsed()
    );
    std::process::ExitCode::from(u8::from(outcomes.iter().any(|outcome| outcome.wrong)))
}

/// Prints a network as a file, and beside it what a file cannot say of it and how its steps ended.
fn show(seed: u64) {
    let (_, network, steps) = stiff_case(seed, 110);
    let (file, unsaid) = write(&network.structure, &steps);
    println!("{file}");
    unsaid.iter().for_each(|what| eprintln!("not in the file: {what}"));
    for step in run(&network, &steps).iter().flat_map(|history| &history.steps) {
        let points: Vec<_> = step.critical_points.iter().map(|point| (point.kind, point.fraction)).collect();
        eprintln!("{:?} at {} of its ramp, past {points:?}: {:?}", step.status, step.fraction, step.failure);
    }
}

/// How a network ended.
#[derive(Debug)]
struct Outcome {
    what: &'static str,
    detail: String,
    wrong: bool,
    states: usize,
    residual: Residual,
    time: Duration,
}

impl Outcome {
    fn good(what: &'static str) -> Self {
        let (detail, residual, time) = (String::new(), Residual::default(), Duration::ZERO);
        Self { what, detail, wrong: false, states: 0, residual, time }
    }

    fn bad(what: &'static str) -> Self {
        Self { wrong: true, ..Self::good(what) }
    }
}

fn judge(seed: u64, most: usize, every: bool) -> Outcome {
    let start = Clock::start();
    let (recipe, network, steps) = stiff_case(seed, most);
    let Some(history) = run(&network, &steps) else { return Outcome::bad("refused as a mechanism") };
    let (worst, states) = verify(&network, &steps, &history);
    let mut outcome = match history.steps.iter().position(|step| step.status != Status::Converged) {
        None => match contradicted(&network, &steps, &history) {
            Some(detail) => Outcome { detail, ..Outcome::bad("stability that the modes contradict") },
            None => converged(&network, &steps, &history, every),
        },
        Some(index) => stopped(&network, &steps, &history, index),
    };
    if recipe.follower {
        outcome.detail += "; loads have no potential";
    }
    outcome.residual = worst;
    if worst.joints > JOINTS || worst.places > PLACES {
        let kinds: Vec<_> = steps.iter().map(|step| (step.method, &step.changes)).collect();
        outcome = Outcome { detail: format!("{worst:?}, {recipe:?}, {kinds:?}"), ..Outcome::bad("no equilibrium") };
    } else if worst.members > MEMBERS {
        // What members miss is to be that of the mesh: it falls with it. A coarse mesh may miss by less than its order says.
        let on = |times: usize| {
            let finer = finer(&network, times);
            run(&finer, &steps).map_or(f64::INFINITY, |history| verify(&finer, &steps, &history).0.members)
        };
        let fine = on(1);
        let better = if fine <= MEMBERS.max(FALLS * worst.members) { fine } else { on(4) };
        if better <= MEMBERS.max(FALLS * worst.members) {
            outcome.residual.members = better;
        } else {
            outcome = Outcome {
                detail: format!("{worst:?}, finer {fine:.1e}, {better:.1e}"),
                ..Outcome::bad("no equilibrium")
            };
        }
    }
    outcome.states = states;
    outcome.time = start.elapsed();
    if outcome.time > HANGS {
        return Outcome { time: outcome.time, ..Outcome::bad("hangs") };
    }
    outcome
}

/// Whether the lowest modes about the last state, on two orders of elements, both say other than the verdict on it.
fn contradicted(network: &Network, steps: &[Step], history: &History) -> Option<String> {
    let last = history.steps.last()?;
    let stable = last.stable.filter(|_| !verdict::is_on_spins(last))?;
    match verdict::confirm(&network.structure, steps, steps.len(), stable) {
        Verdict::Contradicted(lowest) => Some(format!("stable: {stable}, lowest eigenvalues {lowest:?}")),
        Verdict::Confirmed | Verdict::Unknown => None,
    }
}

fn converged(network: &Network, steps: &[Step], history: &History, every: bool) -> Outcome {
    // Where loads have no potential nothing tells whether a large increment went to the right state.
    let doubtful = history.steps.iter().any(|step| step.stable.is_none() && step.negative_pivots > 0);
    let untaken = |note: &Note| matches!(note, Note::Untaken { .. });
    if history.steps.iter().any(|step| step.notes.iter().any(untaken)) {
        return Outcome::bad("converged, with a moment that nothing takes");
    }
    // What turns about itself unhindered ends where the way leads it, and that is said.
    let turned = |note: &Note| matches!(note, Note::TurnedAboutItself { .. });
    let turned = history.steps.iter().any(|step| step.notes.iter().any(turned));
    if turned && (doubtful || every) {
        return Outcome::good("converged, where members turn about themselves");
    }
    if doubtful || every {
        let mut ends = SMALL.iter().map(|&count| from_small(network, steps, history, count));
        match ends.find(|end| *end != Some(false)) {
            Some(Some(_)) => {}
            Some(None) => return Outcome::good("converged, and out of time in small increments"),
            None => return Outcome::bad("converged, to another state than in small increments"),
        }
    }
    let branched = history.steps.iter().any(|step| !step.critical_points.is_empty());
    let jumped = history.steps.iter().any(|step| !step.jumps.is_empty());
    match (jumped, branched) {
        (true, _) => Outcome::good("converged, after a jump"),
        (false, true) => Outcome::good("converged, past singular points"),
        (false, false) => Outcome::good("converged"),
    }
}

/// Whether small increments end where a solve did, `None` where they take too long.
fn from_small(network: &Network, steps: &[Step], history: &History, count: usize) -> Option<bool> {
    let Some(end) = run(network, &small(steps, count)) else { return Some(false) };
    let interrupted = end.steps.iter().any(|step| step.status == Status::Interrupted);
    (!interrupted).then(|| apart(history, &end) < NEAR)
}

/// A step that did not reach its end is tried in small increments.
fn stopped(network: &Network, steps: &[Step], history: &History, index: usize) -> Outcome {
    let step = &history.steps[index];
    if step.status == Status::Interrupted {
        let members = network.structure.members.len();
        let detail = format!(
            "step {index} of {:?} at {} after {} factorizations, {members} members, {:?}",
            steps[index].method, step.fraction, step.factorizations, network.structure.members[0].formulation
        );
        return Outcome { detail, ..Outcome::good("out of time") };
    }
    let mut outcomes = SMALL.iter().map(|&count| confirm(network, &steps[..=index], step, count));
    let first = outcomes.next().expect("one at least");
    if first.wrong { outcomes.find(|outcome| !outcome.wrong).unwrap_or(first) } else { first }
}

/// Whether the last of these steps ends in small increments as it did.
fn confirm(network: &Network, steps: &[Step], step: &StepHistory, count: usize) -> Outcome {
    let index = steps.len() - 1;
    let singular = |step: &StepHistory| matches!(step.status, Status::LimitPoint | Status::Bifurcation);
    let Some(again) = run(network, &small(steps, count)) else { return Outcome::bad("refused as a mechanism") };
    let end = again.steps.iter().position(|step| step.status != Status::Converged).unwrap_or(index);
    let careful = &again.steps[end];
    let detail = format!(
        "step {index} of {:?}: {:?} at {}, in small increments step {end}, {:?} at {}; {:?}",
        steps[index].method, step.status, step.fraction, careful.status, careful.fraction, step.failure
    );
    let stops = careful.status != Status::Converged;
    match (singular(step), singular(careful), stops) {
        _ if careful.status == Status::Interrupted => Outcome::good("stopped, and out of time in small increments"),
        (true, true, _) if end == index && (careful.fraction - step.fraction).abs() < 1e-3 => match step.status {
            Status::LimitPoint => Outcome::good("limit point, confirmed"),
            _ => Outcome::good("bifurcation, confirmed"),
        },
        (true, _, _) => Outcome { detail, ..Outcome::bad("singular point that small increments do not find") },
        (false, _, true) => Outcome { detail, ..Outcome::good("no equilibrium found, in small increments neither") },
        (false, _, false) => Outcome { detail, ..Outcome::bad("no equilibrium found, but in small increments") },
    }
}

/// The same steps in small increments.
fn small(steps: &[Step], count: usize) -> Vec<Step> {
    // So many along an arc would end elsewhere.
    let count = |step: &Step| (step.method != Method::ArcLength).then_some(count);
    steps.iter().map(|step| Step { min_increments: count(step), ..step.clone() }).collect()
}

/// The network on a mesh of twenty elements for one, or on so many times more.
fn finer(network: &Network, times: usize) -> Network {
    let mut finer = network.clone();
    for member in &mut finer.structure.members {
        let exact = member.formulation == Formulation::Exact;
        let (order, elements) = if exact { (4, 20) } else { (1, 80) };
        member.order = order;
        member.segments.iter_mut().for_each(|segment| segment.elements = times * elements);
    }
    finer
}

/// Largest distance of a node between the ends of two runs, over the length of a member.
fn apart(a: &History, b: &History) -> f64 {
    let last =
        |history: &History| history.steps.last().and_then(|step| step.increments.last()).map(|i| i.state.clone());
    let (Some(a), Some(b)) = (last(a), last(b)) else { return f64::INFINITY };
    let far = |(a, b): (&[f64; 3], &[f64; 3])| (Vector::from(*a) - Vector::from(*b)).norm() / LENGTH;
    a.nodes.iter().zip(&b.nodes).map(|(a, b)| far((&a.displacement, &b.displacement))).fold(0.0, f64::max)
}

fn run(network: &Network, steps: &[Step]) -> Option<History> {
    let start = Clock::start();
    pennate_solver::solve(&network.structure, steps, &Options::default(), &mut |_| start.elapsed() < BUDGET).ok()
}

/// The largest residuals of the last states of all steps, and how many states these are.
fn verify(network: &Network, steps: &[Step], history: &History) -> (Residual, usize) {
    let mut values = vec![0.0; network.structure.drives.len()];
    // Values where a component may be told to be.
    let mut held: BTreeMap<(usize, usize), Vec<f64>> = BTreeMap::new();
    let (mut worst, mut states) = (Residual::default(), 0);
    let mut before: Option<&Equilibrium> = None;
    for (step, result) in steps.iter().zip(&history.steps) {
        let Some(last) = result.increments.last() else { break };
        // A state on the way to the first step holds a part of the prestress, which nobody tells here.
        if result.prestress.is_some() {
            break;
        }
        for &(drive, target) in &step.targets {
            values[drive] += last.fraction * (target - values[drive]);
        }
        // What a step sets free loses its reaction over the step, which may stop short.
        let mut fading: Vec<(usize, usize, f64)> = Vec::new();
        for change in &step.changes {
            let present = |node, component| before.map_or(vec![0.0], |state| values_of(state, node, component));
            match *change {
                Change::Prescribe { node, component, to } => {
                    let told = |from: f64| from + last.fraction * (to - from);
                    held.insert((node, component), present(node, component).into_iter().map(told).collect());
                }
                Change::Hold { node, component } => _ = held.insert((node, component), present(node, component)),
                Change::MoveBy { node, component, by } => {
                    let told = |from: f64| from + last.fraction * by;
                    held.insert((node, component), present(node, component).into_iter().map(told).collect());
                }
                Change::Free { node, component } => {
                    held.remove(&(node, component));
                    let Some(state) = before else { continue };
                    let all = [state.nodes[node].reaction_force, state.nodes[node].reaction_moment].concat();
                    // What holds one component of a rotation vector has a moment about all axes, where others are large.
                    let alone = component > 2 && !(3..6).any(|other| held.contains_key(&(node, other)));
                    let of_it = if alone { 3..6 } else { component..component + 1 };
                    fading.extend(of_it.map(|other| (node, other, (1.0 - last.fraction) * all[other])));
                }
            }
        }
        let mut found = residual(network, &last.state, &values, &fading);
        let rounding = last.state.rounding.map_or(0.0, |rounding| {
            rounding.errors[2..].iter().flatten().fold(0.0, |largest, &error| error.max(largest))
        });
        found.joints = (found.joints - TIMES_ROUNDING * rounding).max(0.0);
        let missed = |node: usize, component: usize, told: &[f64]| {
            let values = values_of(&last.state, node, component);
            let apart = |told: &f64| values.iter().map(|value| (value - told).abs()).fold(f64::INFINITY, f64::min);
            let miss = told.iter().map(apart).fold(f64::INFINITY, f64::min);
            if component < 3 { miss / LENGTH } else { miss }
        };
        for (&(node, component), told) in &held {
            found.places = found.places.max(missed(node, component, told));
        }
        if let (Some(stop), Status::Converged, true) = (step.stop, result.status, last.fraction != 1.0) {
            let missed = match stop {
                Stop::At { node, component, value } => missed(node, component, &[value]),
                Stop::Fraction(at) => (last.fraction - at).abs(),
                Stop::Increments(_) => 0.0,
            };
            found.places = found.places.max(missed);
        }
        before = Some(&last.state);
        worst.join(&found);
        states += 1;
    }
    (worst, states)
}

/// A component of the displacement of a node, or of its rotation vector: results keep that below π, steps count on.
fn values_of(state: &Equilibrium, node: usize, component: usize) -> Vec<f64> {
    let node = &state.nodes[node];
    if component < 3 {
        return vec![node.displacement[component]];
    }
    let rotation = Vector::from(node.rotation);
    let angle = rotation.norm();
    let axis = if angle > 0.0 { rotation / angle } else { Vector::zeros() };
    (-2..=2).map(|turns| (angle + f64::from(turns) * std::f64::consts::TAU) * axis[component - 3]).collect()
}
