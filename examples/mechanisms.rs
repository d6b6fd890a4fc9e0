//! Random networks, solved with the defaults and again with very small increments: who agrees, and who says what.
//!
//! `cargo run --release --example mechanisms [-- COUNT [FIRST]]` prints the table, for so many networks of each family at most, from
//! seed FIRST on. Nodes lie at random in a square or a cube, members join them to a tree and beyond, some of them contract. A network
//! "agrees" where both runs end in the same stable equilibrium, or at the same singular point.

use std::sync::Arc;

use pennate_elements::section::Section;
use pennate_solver::history::{Status, StepHistory};
use pennate_solver::options::Options;
use pennate_solver::structure::{
    Dimension, Drive, Formulation, Member, Release, SectionLaw, SectionState, Segment, Stability, Step, Structure,
    Support,
};

const SIDE: f64 = 100.0;
/// Increments of the run that the defaults are held against.
const SMALL: usize = 200;
/// Displacement over the side of the square within which two states are the same.
const SAME: f64 = 1e-6;
/// Part of the ramp within which two singular points are the same.
const SAME_POINT: f64 = 1e-6;

/// A section that contracts with the control.
#[derive(Debug)]
struct Contracting {
    section: Section,
    strain: f64,
}

impl SectionLaw for Contracting {
    fn at(&self, control: f64) -> SectionState {
        SectionState { section: self.section, strain: control * self.strain, curvature: [0.0; 3] }
    }
}

struct Family {
    name: &'static str,
    dimension: Dimension,
    members: usize,
    nodes: usize,
    count: usize,
}

const FAMILIES: [Family; 3] = [
    Family { name: "plane, 10 members, 8 nodes", dimension: Dimension::Plane, members: 10, nodes: 8, count: 500 },
    Family { name: "plane, 15 members, 12 nodes", dimension: Dimension::Plane, members: 15, nodes: 12, count: 500 },
    Family { name: "space, 15 members, 10 nodes", dimension: Dimension::Space, members: 15, nodes: 10, count: 300 },
];

fn main() {
    let number = |place: usize| std::env::args().nth(place).and_then(|text| text.parse().ok());
    let (limit, first) = (number(1).unwrap_or(usize::MAX), number(2).unwrap_or(0));
    println!(
        "| networks | solved, stable | of them by a branch | stopped at a singular point | no equilibrium found | \
         agree with {SMALL} increments | silently elsewhere | factorizations, mean |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|");
    for family in &FAMILIES {
        let count = family.count.min(limit);
        let (mut solved, mut branched, mut stopped, mut lost, mut agree, mut silent, mut work) = (0, 0, 0, 0, 0, 0, 0);
        for seed in first..first + count {
            let (structure, mut step) = network(family, seed as u64);
            let usual = run(&structure, &step);
            step.min_increments = Some(SMALL);
            let careful = run(&structure, &step);
            work += usual.factorizations;
            match (usual.status, usual.stable) {
                (Status::Converged, Some(true)) => {
                    solved += 1;
                    branched += usize::from(!usual.critical_points.is_empty());
                }
                (Status::LimitPoint | Status::Bifurcation, _) => stopped += 1,
                _ => lost += 1,
            }
            let same = agrees(&usual, &careful);
            agree += usize::from(same);
            // Somewhere else without a word: both converged, to different states, and the usual run noticed nothing.
            let quiet = usual.status == Status::Converged && usual.critical_points.is_empty();
            if !same && quiet {
                silent += 1;
                eprintln!(
                    "{}, seed {seed}: {:.1e} of the side apart; {:?} at {} against {:?} at {}, {:?}",
                    family.name,
                    apart(&usual, &careful),
                    usual.status,
                    usual.fraction,
                    careful.status,
                    careful.fraction,
                    careful.critical_points.first().map(|point| (point.kind, point.fraction))
                );
            }
            if !matches!(usual.status, Status::Converged | Status::LimitPoint | Status::Bifurcation) {
                eprintln!(
                    "{}, seed {seed}: {:?} at {}: {:?}",
                    family.name, usual.status, usual.fraction, usual.failure
                );
            }
        }
        println!(
            "| {} ({count}) | {solved} | {branched} | {stopped} | {lost} | {agree} | {silent} | {:.0} |",
            family.name,
            work as f64 / count.max(1) as f64
        );
    }
}

fn run(structure: &Structure, step: &Step) -> StepHistory {
    let steps = std::slice::from_ref(step);
    let mut history = pennate_solver::solve(structure, steps, &Options::default(), &mut |_| true)
        .unwrap_or_else(|error| panic!("{error}"));
    history.steps.remove(0)
}

fn agrees(a: &StepHistory, b: &StepHistory) -> bool {
    if a.status != b.status {
        // A branch that turns back where it begins may be called either.
        let singular = |step: &StepHistory| matches!(step.status, Status::LimitPoint | Status::Bifurcation);
        return singular(a) && singular(b) && (a.fraction - b.fraction).abs() < SAME_POINT;
    }
    (a.fraction - b.fraction).abs() < SAME_POINT && (apart(a, b) < SAME || a.status != Status::Converged)
}

/// Largest difference of a displacement at the ends of two runs, over the side of the square.
fn apart(a: &StepHistory, b: &StepHistory) -> f64 {
    let (Some(last), Some(other)) = (a.increments.last(), b.increments.last()) else { return f64::INFINITY };
    last.state.nodes.iter().zip(&other.state.nodes).fold(0.0f64, |far, (a, b)| {
        (0..3).fold(far, |far, c| far.max((a.displacement[c] - b.displacement[c]).abs() / SIDE))
    })
}

/// A random network of its family, and the step that contracts some of its members.
fn network(family: &Family, seed: u64) -> (Structure, Step) {
    let mut random = fastrand::Rng::with_seed(seed);
    let deep = family.dimension == Dimension::Space;
    let mut nodes: Vec<[f64; 3]> = Vec::new();
    while nodes.len() < family.nodes {
        let mut coordinate = || SIDE * random.f64();
        let node = [coordinate(), coordinate(), if deep { coordinate() } else { 0.0 }];
        if nodes.iter().all(|other| distance(other, &node) > 0.15 * SIDE) {
            nodes.push(node);
        }
    }
    let mut pairs: Vec<[usize; 2]> = Vec::new();
    for node in 1..family.nodes {
        // To the nearest of the earlier ones: long members across everything are rare in a network.
        let mut earlier: Vec<usize> = (0..node).collect();
        earlier.sort_by(|&a, &b| distance(&nodes[a], &nodes[node]).total_cmp(&distance(&nodes[b], &nodes[node])));
        pairs.push([earlier[random.usize(0..earlier.len().min(3))], node]);
    }
    while pairs.len() < family.members {
        let (a, b) = (random.usize(0..family.nodes), random.usize(0..family.nodes));
        if a != b && !pairs.contains(&[a, b]) && !pairs.contains(&[b, a]) {
            pairs.push([a, b]);
        }
    }
    let mut laws: Vec<Arc<dyn SectionLaw>> = Vec::new();
    let mut members = Vec::new();
    for [a, b] in pairs {
        let length = distance(&nodes[a], &nodes[b]);
        let slenderness = 20.0 * 50f64.powf(random.f64());
        let ei = 1e4 * 3f64.powf(2.0 * random.f64() - 1.0);
        let ea = ei * (slenderness / length).powi(2);
        let strain = if random.bool() { -0.25 * random.f64() } else { 0.0 };
        let section = Section {
            ea,
            ga2: 0.35 * ea,
            ga3: 0.35 * ea,
            gj: 0.77 * ei,
            ei2: ei,
            ei3: ei,
            mass_per_length: 0.0,
            rotary_inertia: [0.0; 2],
        };
        laws.push(Arc::new(Contracting { section, strain }));
        members.push(Member {
            nodes: [a, b],
            axes: axes(&nodes[a], &nodes[b], deep),
            segments: vec![Segment { length, elements: 2, law: laws.len() - 1, initial_curvature: [0.0; 3] }],
            releases: [Release::Welded, Release::Welded],
            control: Some(0),
            formulation: Formulation::Exact,
            order: 3,
        });
    }
    let support = |node| Support { node, fixed: [true; 6], axes: [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]] };
    let far =
        (1..family.nodes).max_by(|&a, &b| distance(&nodes[0], &nodes[a]).total_cmp(&distance(&nodes[0], &nodes[b])));
    let structure = Structure {
        dimension: family.dimension,
        stability: Stability::Plane,
        nodes,
        members,
        laws,
        supports: vec![support(0), support(far.unwrap_or(1))],
        bodies: Vec::new(),
        springs: Vec::new(),
        drives: vec![Drive::Control],
        compliances: Vec::new(),
        sections: Vec::new(),
    };
    (structure, Step { targets: vec![(0, 1.0)], ..Step::default() })
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
}

/// Axes along a member, axis 3 along z in the plane.
fn axes(a: &[f64; 3], b: &[f64; 3], deep: bool) -> [[f64; 3]; 3] {
    use nalgebra::Vector3;
    let tangent = (Vector3::from(*b) - Vector3::from(*a)).normalize();
    let aside = if deep && tangent.z.abs() > 0.9 { Vector3::y() } else { Vector3::z() };
    let second = aside.cross(&tangent).normalize();
    [tangent.into(), second.into(), tangent.cross(&second).into()]
}
