//! Random networks that are no mechanisms, by seed and size.
//!
//! Members join nodes to a welded tree and beyond; only the members beyond the tree have releases, so that the tree holds
//! everything. Node 0 is clamped, and the node farthest from it is held in turned axes. Drives come in threes, the
//! components of one vector, but for the control.

use std::sync::Arc;

use nalgebra::Vector3;
use pennate_elements::section::Section;
use pennate_solver::structure::{
    ComplianceOf, Dimension, Drive, Formulation, Member, Release, RigidBody, SectionLaw, SectionState, Segment, Spring,
    Stability, Structure, Support,
};

/// Three components along global axes.
pub type Vector = Vector3<f64>;

/// Typical length of a member.
pub const LENGTH: f64 = 60.0;
/// Typical bending stiffness.
pub const EI: f64 = 1e4;

/// A section that contracts and bends with the control.
#[derive(Clone, Copy, Debug)]
pub struct Actuated {
    /// At a control of zero.
    pub section: Section,
    /// Axial strain at a control of one.
    pub strain: f64,
    /// Curvature about axis 3 at a control of one (1/length).
    pub curvature: f64,
    /// Part of the stiffness by which it grows with the control, as that of a muscle does with its pressure.
    pub stiffening: f64,
}

impl Actuated {
    /// The section at a control.
    pub fn section(&self, control: f64) -> Section {
        let factor = 1.0 + self.stiffening * control;
        let Section { ea, ga2, ga3, gj, ei2, ei3, .. } = self.section;
        let [ea, ga2, ga3, gj, ei2, ei3] = [ea, ga2, ga3, gj, ei2, ei3].map(|stiffness| factor * stiffness);
        Section { ea, ga2, ga3, gj, ei2, ei3, ..self.section }
    }
}

impl SectionLaw for Actuated {
    fn at(&self, control: f64) -> SectionState {
        SectionState {
            section: self.section(control),
            strain: control * self.strain,
            curvature: [0.0, 0.0, control * self.curvature],
        }
    }
}

/// What a random network is made from.
#[derive(Clone, Copy, Debug)]
pub struct Recipe {
    /// Of its random numbers.
    pub seed: u64,
    /// Plane or space.
    pub dimension: Dimension,
    /// Number of nodes.
    pub nodes: usize,
    /// Members beyond those of the tree.
    pub extra: usize,
    /// Loads without a potential too.
    pub follower: bool,
}

/// A network, its sections once more with their types, and its loads.
#[derive(Clone, Debug)]
pub struct Network {
    /// What is solved; its first drive is the control.
    pub structure: Structure,
    /// The sections of the structure, by index.
    pub laws: Vec<Actuated>,
    /// Targets of the loads at their full size, the control among them.
    pub loads: Vec<(usize, f64)>,
}

impl Network {
    /// The laws of the structure are those of `laws`.
    pub fn adopt_laws(&mut self) {
        self.structure.laws = self.laws.iter().map(|&law| Arc::new(law) as Arc<dyn SectionLaw>).collect();
    }
}

/// The network of a recipe.
pub fn network(recipe: &Recipe) -> Network {
    let mut random = fastrand::Rng::with_seed(recipe.seed);
    let deep = recipe.dimension == Dimension::Space;
    let nodes = places(recipe, &mut random);
    let count = nodes.len();
    let (pairs, tree) = pairs(&nodes, recipe.extra, &mut random);
    let mut laws = Vec::new();
    let members: Vec<Member> = pairs
        .iter()
        .enumerate()
        .map(|(index, &pair)| {
            laws.push(section(&mut random, distance(&nodes, pair), deep));
            let frame = axes(&nodes[pair[0]], &nodes[pair[1]], deep);
            Member {
                nodes: pair,
                axes: frame,
                segments: vec![Segment {
                    length: distance(&nodes, pair),
                    elements: 4,
                    law: index,
                    initial_curvature: [0.0; 3],
                }],
                releases: [0, 1]
                    .map(|_| if index < tree { Release::Welded } else { release(&mut random, &frame, deep) }),
                control: Some(0),
                formulation: Formulation::Exact,
                order: 3,
            }
        })
        .collect();
    let far = (1..count).max_by(|&a, &b| distance(&nodes, [0, a]).total_cmp(&distance(&nodes, [0, b]))).unwrap_or(1);
    let angle = 2.0 * random.f64();
    let turned = [[angle.cos(), angle.sin(), 0.0], [-angle.sin(), angle.cos(), 0.0], [0.0, 0.0, 1.0]];
    let straight = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let supports = vec![
        Support { node: 0, fixed: [true; 6], axes: straight },
        Support { node: far, fixed: [random.bool(), true, random.bool(), false, false, random.bool()], axes: turned },
    ];
    let free: Vec<usize> = (1..count).filter(|&node| node != far).collect();
    let bodies = body(&pairs, &free, &mut random).into_iter().collect();
    let springs = springs(&nodes, &free, &mut random);
    let (drives, loads) = loads(recipe, count, members.len(), &mut random);
    let mut network = Network {
        structure: Structure {
            dimension: recipe.dimension,
            stability: Stability::Plane,
            nodes: nodes.into_iter().map(Into::into).collect(),
            members,
            laws: Vec::new(),
            supports,
            bodies,
            springs,
            drives,
            sections: Vec::new(),
            compliances: vec![ComplianceOf {
                node: free.first().copied().unwrap_or(far),
                along: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            }],
        },
        laws,
        loads,
    };
    network.adopt_laws();
    network
}

fn places(recipe: &Recipe, random: &mut fastrand::Rng) -> Vec<Vector> {
    let deep = recipe.dimension == Dimension::Space;
    let side = LENGTH * (recipe.nodes as f64).powf(if deep { 1.0 / 3.0 } else { 0.5 });
    let mut nodes: Vec<Vector> = Vec::new();
    while nodes.len() < recipe.nodes {
        let mut coordinate = || side * random.f64();
        let node = Vector::new(coordinate(), coordinate(), if deep { coordinate() } else { 0.0 });
        if nodes.iter().all(|other| (other - node).norm() > 0.3 * LENGTH) {
            nodes.push(node);
        }
    }
    nodes
}

/// Ends of members, and how many of them, the first ones, are the tree.
fn pairs(nodes: &[Vector], extra: usize, random: &mut fastrand::Rng) -> (Vec<[usize; 2]>, usize) {
    let near = |node: usize, among: &mut Vec<usize>| {
        among.sort_by(|&a, &b| distance(nodes, [a, node]).total_cmp(&distance(nodes, [b, node])));
    };
    let mut pairs: Vec<[usize; 2]> = Vec::new();
    for node in 1..nodes.len() {
        let mut earlier: Vec<usize> = (0..node).collect();
        near(node, &mut earlier);
        pairs.push([earlier[random.usize(0..earlier.len().min(3))], node]);
    }
    let tree = pairs.len();
    for _ in 0..20 * extra {
        let node = random.usize(0..nodes.len());
        let mut others: Vec<usize> = (0..nodes.len()).filter(|&other| other != node).collect();
        near(node, &mut others);
        let pair = [node, others[random.usize(0..others.len().min(5))]];
        if pairs.len() < tree + extra && !pairs.contains(&pair) && !pairs.contains(&[pair[1], pair[0]]) {
            pairs.push(pair);
        }
    }
    (pairs, tree)
}

fn section(random: &mut fastrand::Rng, length: f64, deep: bool) -> Actuated {
    let slenderness = 10.0 * 30f64.powf(random.f64());
    let ei3 = EI * 3f64.powf(2.0 * random.f64() - 1.0);
    let ea = ei3 * (slenderness / length).powi(2);
    let ei2 = if deep { ei3 * (0.5 + random.f64()) } else { ei3 };
    let rigid = random.u8(0..4) == 0;
    let shear = if rigid { f64::INFINITY } else { 0.35 * ea };
    let section = Section {
        ea,
        ga2: shear,
        ga3: shear,
        gj: 0.8 * ei3,
        ei2,
        ei3,
        mass_per_length: 1e-6,
        rotary_inertia: [0.0; 2],
    };
    let strain = if random.bool() { -0.15 * random.f64() } else { 0.0 };
    let curvature = if random.u8(0..4) == 0 { (random.f64() - 0.5) / length } else { 0.0 };
    Actuated { section, strain, curvature, stiffening: 0.0 }
}

fn release(random: &mut fastrand::Rng, frame: &[[f64; 3]; 3], deep: bool) -> Release {
    match random.u8(0..4) {
        0 => Release::Pin,
        1 if deep => Release::Axes(vec![frame[1 + random.usize(0..2)]]),
        1 => Release::Axes(vec![[0.0, 0.0, 1.0]]),
        _ => Release::Welded,
    }
}

/// Two free nodes that no member joins, as a rigid body, now and then.
fn body(pairs: &[[usize; 2]], free: &[usize], random: &mut fastrand::Rng) -> Option<RigidBody> {
    let (a, b) = (free.first()?, free.last()?);
    let joined = pairs.iter().any(|pair| pair.contains(a) && pair.contains(b));
    (a != b && !joined && random.bool()).then(|| RigidBody { nodes: vec![*a, *b], reference: *b, mass: 0.0 })
}

fn springs(nodes: &[Vector], free: &[usize], random: &mut fastrand::Rng) -> Vec<Spring> {
    let k = EI / LENGTH.powi(3);
    let (t, r) = (k * random.f64(), k * LENGTH * LENGTH * random.f64());
    let stiffness = [t, t, t, r, r, r];
    let mut springs = Vec::new();
    let Some(&node) = free.first() else { return springs };
    let other = *free.last().unwrap_or(&node);
    if random.bool() {
        springs.push(Spring::Ground { node, stiffness });
    }
    if node != other && random.bool() {
        let natural_length = distance(nodes, [node, other]) * (0.8 + 0.4 * random.f64());
        springs.push(Spring::Axial { nodes: [node, other], stiffness: k, natural_length });
    }
    if node != other && random.bool() {
        springs.push(Spring::Coupling { nodes: [node, other], stiffness });
    }
    springs
}

fn loads(recipe: &Recipe, nodes: usize, members: usize, random: &mut fastrand::Rng) -> (Vec<Drive>, Vec<(usize, f64)>) {
    let deep = recipe.dimension == Dimension::Space;
    let force = 0.3 * EI / (LENGTH * LENGTH);
    let (mut drives, mut loads) = (vec![Drive::Control], vec![(0, 1.0)]);
    let mut vector = |random: &mut fastrand::Rng, drive: &dyn Fn(usize) -> Drive, size: f64, turns: bool| {
        for component in 0..3 {
            drives.push(drive(component));
            let acts = deep || (component == 2) == turns;
            let value = size * (2.0 * random.f64() - 1.0);
            loads.push((drives.len() - 1, if acts { value } else { 0.0 }));
        }
    };
    for _ in 0..1 + nodes / 6 {
        let node = random.usize(1..nodes);
        vector(random, &|c| Drive::Force(node, c), force, false);
    }
    let (node, member) = (random.usize(1..nodes), random.usize(0..members));
    // In space a dead moment has no potential.
    if !deep || recipe.follower {
        vector(random, &|c| Drive::Moment(node, c), force * LENGTH, true);
    }
    if recipe.follower {
        vector(random, &|c| Drive::FollowerForce(node, c), force, false);
    }
    vector(random, &|c| Drive::Distributed(member, c), force / LENGTH, false);
    vector(random, &|c| Drive::Gravity(c), 1e5 * force / LENGTH, false);
    (drives, loads)
}

/// Distance of two nodes.
pub fn distance(nodes: &[Vector], [a, b]: [usize; 2]) -> f64 {
    (nodes[a] - nodes[b]).norm()
}

/// Axes along a member, axis 3 along z in the plane.
fn axes(a: &Vector, b: &Vector, deep: bool) -> [[f64; 3]; 3] {
    let tangent = (b - a).normalize();
    let aside = if deep && tangent.z.abs() > 0.9 { Vector::y() } else { Vector::z() };
    let second = aside.cross(&tangent).normalize();
    [tangent.into(), second.into(), tangent.cross(&second).into()]
}
