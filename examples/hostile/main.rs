//! Random valid networks with steps of every kind, each state checked without the solver.
//!
//! `cargo run --release --example hostile [-- COUNT [FIRST [NODES]]]` solves COUNT networks (10,000 unless given) from seed FIRST
//! on, of up to NODES nodes (110, which makes up to 200 members) in the plane and in space, and prints how they ended. A step
//! that stops short is tried again in small increments, which must stop it too. What is wrong is listed by its seed, and
//! ends the program with status 1: a state that is no equilibrium, a cause that was not confirmed, a panic, a network
//! refused, a run beyond its time.

mod check;
mod random;

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use check::{Residual, residual};
use pennate_solver::history::{Equilibrium, History, Status, StepHistory};
use pennate_solver::options::Options;
use pennate_solver::structure::{Branch, Change, Dimension, Formulation, Method, Release, Step, Stop};
use random::{LENGTH, Network, Recipe, network};
use rayon::prelude::*;

/// Time of one run.
const BUDGET: Duration = Duration::from_secs(20);
/// Time after which the runs of a network, three of them at most, hang: they were told to stop.
const HANGS: Duration = Duration::from_secs(120);
/// Residual of the joints, over the largest force or moment.
const JOINTS: f64 = 1e-7;
/// Miss of an integrated member over its length, on the mesh in use or on the finer one.
const MEMBERS: f64 = 1e-3;
/// Part of that miss which a mesh of twenty elements for one may leave: they converge by the square of their size at least.
const FALLS: f64 = 1e-2;
/// Increments of a step that is tried again.
const SMALL: usize = 100;

fn main() -> std::process::ExitCode {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse().expect("a number"));
    let count: u64 = arguments.next().unwrap_or(10_000);
    let first: u64 = arguments.next().unwrap_or(0);
    let most: u64 = arguments.next().unwrap_or(110).max(4);
    std::panic::set_hook(Box::new(|_| {}));
    let start = Instant::now();
    let outcomes: Vec<(u64, Outcome)> = (first..first + count)
        .into_par_iter()
        .map(|seed| {
            (seed, catch_unwind(AssertUnwindSafe(|| judge(seed, most as usize))).unwrap_or(Outcome::bad("a panic")))
        })
        .collect();
    let mut table: BTreeMap<&str, usize> = BTreeMap::new();
    let (mut states, mut members, mut joint, mut miss, mut slowest) = (0, 0, 0.0f64, 0.0f64, Duration::ZERO);
    for (seed, outcome) in &outcomes {
        *table.entry(outcome.what).or_default() += 1;
        states += outcome.states;
        members += outcome.residual.integrated;
        joint = joint.max(outcome.residual.joints);
        miss = miss.max(outcome.residual.members);
        slowest = slowest.max(outcome.time);
        if outcome.wrong || outcome.what.contains("out of time") {
            println!("seed {seed}: {} {}", outcome.what, outcome.detail);
        }
    }
    println!("| how it ended | networks |\n|---|---:|");
    table.iter().for_each(|(what, count)| println!("| {what} | {count} |"));
    println!(
        "\n{states} states and {members} members of them checked: joints within {joint:.1e}, members within {miss:.1e}; slowest \
         {slowest:.1?}, all {:.0?}",
        start.elapsed()
    );
    std::process::ExitCode::from(u8::from(outcomes.iter().any(|(_, outcome)| outcome.wrong)))
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

fn judge(seed: u64, most: usize) -> Outcome {
    let start = Instant::now();
    let mut random = fastrand::Rng::with_seed(!seed);
    let deep = random.bool();
    // Many small networks, some of a hundred nodes.
    let nodes = 3 + ((most - 3) as f64 * random.f64().powi(4)) as usize;
    let recipe = Recipe {
        seed,
        dimension: if deep { Dimension::Space } else { Dimension::Plane },
        nodes,
        extra: random.usize(0..=nodes * 4 / 5),
        follower: random.bool(),
    };
    let mut network = network(&recipe);
    vary(&mut network, &recipe, &mut random);
    let steps = steps(&network, &mut random);
    let Some(history) = run(&network, &steps) else { return Outcome::bad("refused as a mechanism") };
    let (worst, states) = verify(&network, &steps, &history);
    let mut outcome = match history.steps.iter().position(|step| step.status != Status::Converged) {
        None => converged(&network, &steps, &history),
        Some(index) => stopped(&network, &steps, &history, index),
    };
    if recipe.follower {
        outcome.detail += "; loads have no potential";
    }
    outcome.residual = worst;
    if worst.joints > JOINTS {
        let kinds: Vec<_> = steps.iter().map(|step| (step.method, &step.changes)).collect();
        outcome = Outcome { detail: format!("{worst:?}, {recipe:?}, {kinds:?}"), ..Outcome::bad("no equilibrium") };
    } else if worst.members > MEMBERS {
        // What members miss is to be that of the mesh: it falls with it.
        let finer = finer(&network);
        let better = run(&finer, &steps).map(|history| verify(&finer, &steps, &history).0.members);
        match better {
            Some(better) if better <= MEMBERS.max(FALLS * worst.members) => outcome.residual.members = better,
            _ => outcome = Outcome { detail: format!("{worst:?}, finer {better:?}"), ..Outcome::bad("no equilibrium") },
        }
    }
    outcome.states = states;
    outcome.time = start.elapsed();
    if outcome.time > HANGS {
        return Outcome { time: outcome.time, ..Outcome::bad("hangs") };
    }
    outcome
}

/// What the recipe knows nothing of: stiffness that grows with the control, twist and two axes that are free, corotational
/// elements.
fn vary(network: &mut Network, recipe: &Recipe, random: &mut fastrand::Rng) {
    let corotational = random.u8(0..6) == 0;
    let structure = &mut network.structure;
    let tree = structure.nodes.len() - 1;
    for (index, (member, law)) in structure.members.iter_mut().zip(&mut network.laws).enumerate() {
        if random.u8(0..3) == 0 {
            law.stiffening = random.f64();
        }
        if corotational {
            (member.formulation, member.order) = (Formulation::Corotational, 1);
        }
        let [first, second, third] = member.axes;
        // A bar that is free to spin at one end is held by the other.
        let free = if random.bool() { vec![first] } else { vec![second, third] };
        let held = index < tree || member.releases != [Release::Welded, Release::Welded];
        if recipe.dimension == Dimension::Space && !held && random.u8(0..4) == 0 {
            member.releases[0] = Release::Axes(free);
        }
    }
    network.adopt_laws();
}

fn converged(network: &Network, steps: &[Step], history: &History) -> Outcome {
    // Where loads have no potential nothing tells whether a large increment went to the right state.
    let doubtful = history.steps.iter().any(|step| step.stable.is_none() && step.negative_pivots > 0);
    if doubtful {
        let small = run(network, &small(steps));
        let same = small.is_some_and(|small| apart(history, &small) < 1e-5);
        if !same {
            return Outcome::bad("converged, to another state than in small increments");
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

/// A step that did not reach its end is tried in small increments.
fn stopped(network: &Network, steps: &[Step], history: &History, index: usize) -> Outcome {
    let step = &history.steps[index];
    let singular = |step: &StepHistory| matches!(step.status, Status::LimitPoint | Status::Bifurcation);
    if step.status == Status::Interrupted {
        let members = network.structure.members.len();
        let detail = format!(
            "step {index} of {:?} at {} after {} factorizations, {members} members, {:?}",
            steps[index].method, step.fraction, step.factorizations, network.structure.members[0].formulation
        );
        return Outcome { detail, ..Outcome::good("out of time") };
    }
    let Some(again) = run(network, &small(&steps[..=index])) else { return Outcome::bad("refused as a mechanism") };
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
fn small(steps: &[Step]) -> Vec<Step> {
    // So many along an arc would end elsewhere.
    let count = |step: &Step| (step.method != Method::ArcLength).then_some(SMALL);
    steps.iter().map(|step| Step { min_increments: count(step), ..step.clone() }).collect()
}

fn finer(network: &Network) -> Network {
    let mut finer = network.clone();
    for member in &mut finer.structure.members {
        let exact = member.formulation == Formulation::Exact;
        (member.order, member.segments[0].elements) = if exact { (4, 20) } else { (1, 80) };
    }
    finer
}

/// Largest distance of a node between the ends of two runs, over the length of a member.
fn apart(a: &History, b: &History) -> f64 {
    let last =
        |history: &History| history.steps.last().and_then(|step| step.increments.last()).map(|i| i.state.clone());
    let (Some(a), Some(b)) = (last(a), last(b)) else { return f64::INFINITY };
    let far = |(a, b): (&[f64; 3], &[f64; 3])| (random::Vector::from(*a) - random::Vector::from(*b)).norm() / LENGTH;
    a.nodes.iter().zip(&b.nodes).map(|(a, b)| far((&a.displacement, &b.displacement))).fold(0.0, f64::max)
}

fn run(network: &Network, steps: &[Step]) -> Option<History> {
    let start = Instant::now();
    pennate_solver::solve(&network.structure, steps, &Options::default(), &mut |_| start.elapsed() < BUDGET).ok()
}

/// The largest residuals of the last states of all steps, and how many states these are.
fn verify(network: &Network, steps: &[Step], history: &History) -> (Residual, usize) {
    let mut values = vec![0.0; network.structure.drives.len()];
    let (mut worst, mut states) = (Residual::default(), 0);
    let mut before: Option<&Equilibrium> = None;
    for (step, result) in steps.iter().zip(&history.steps) {
        let Some(last) = result.increments.last() else { break };
        for &(drive, target) in &step.targets {
            values[drive] += last.fraction * (target - values[drive]);
        }
        // What a step sets free loses its reaction over the step, which may stop short.
        let fading: Vec<(usize, usize, f64)> = (step.changes.iter())
            .filter_map(|change| match *change {
                Change::Free { node, component } => {
                    let reactions = &before?.nodes[node];
                    let all = [reactions.reaction_force, reactions.reaction_moment].concat();
                    Some((node, component, (1.0 - last.fraction) * all[component]))
                }
                _ => None,
            })
            .collect();
        before = Some(&last.state);
        let found = residual(network, &last.state, &values, &fading);
        worst.joints = worst.joints.max(found.joints);
        worst.members = worst.members.max(found.members);
        worst.integrated += found.integrated;
        states += 1;
    }
    (worst, states)
}

/// One to four steps of random kinds, the first of which brings loads.
fn steps(network: &Network, random: &mut fastrand::Rng) -> Vec<Step> {
    let structure = &network.structure;
    let taken = |node: usize| {
        structure.supports.iter().any(|support| support.node == node)
            || structure.bodies.iter().any(|body| body.nodes.contains(&node))
    };
    let free: Vec<usize> = (1..structure.nodes.len()).filter(|&node| !taken(node)).collect();
    let components = if structure.dimension == Dimension::Space { 3 } else { 2 };
    let mut held: Vec<(usize, usize)> = Vec::new();
    let mut steps = vec![Step { targets: targets(network, random), ..Step::default() }];
    for _ in 0..random.usize(0..4) {
        let mut step = Step::default();
        let place = free.get(random.usize(0..free.len().max(1))).map(|&node| (node, random.usize(0..components)));
        let by = 0.3 * LENGTH * (2.0 * random.f64() - 1.0);
        match (random.u8(0..10), place) {
            (0, Some((node, component))) => step.changes.push(Change::Prescribe { node, component, to: by }),
            (1, Some((node, component))) => {
                step.changes.push(Change::Hold { node, component });
                step.targets = targets(network, random);
            }
            (2, Some((node, component))) => step.changes.push(Change::MoveBy { node, component, by }),
            (3, _) if !held.is_empty() => {
                let (node, component) = held.swap_remove(random.usize(0..held.len()));
                step.changes.push(Change::Free { node, component });
            }
            (4 | 5, _) => {
                step.targets = targets(network, random);
                step.method = Method::ArcLength;
                step.stop = Some(Stop::Increments(20));
            }
            (6, _) => {
                step.targets = targets(network, random);
                step.method = Method::Jump;
            }
            (7, Some((node, _))) => {
                let component = if components == 3 { random.usize(3..6) } else { 5 };
                step.changes.push(Change::Prescribe { node, component, to: random.f64() - 0.5 });
            }
            (8, _) => {
                step.targets = targets(network, random);
                (step.branch, step.min_increments) = (Branch::Primary, Some(5));
            }
            _ => step.targets = targets(network, random),
        }
        for change in &step.changes {
            match *change {
                Change::Prescribe { node, component, .. }
                | Change::Hold { node, component }
                | Change::MoveBy { node, component, .. } => {
                    if !held.contains(&(node, component)) {
                        held.push((node, component));
                    }
                }
                Change::Free { .. } => {}
            }
        }
        steps.push(step);
    }
    steps
}

/// Every load on its own at up to twice its size, some left as they are.
fn targets(network: &Network, random: &mut fastrand::Rng) -> Vec<(usize, f64)> {
    let part = 2.0 * random.f64();
    let control = (0, random.f64());
    let loads = network.loads[1..].iter().map(|&(drive, value)| (drive, part * value));
    std::iter::once(control).chain(loads).filter(|_| random.u8(0..5) > 0).collect()
}
