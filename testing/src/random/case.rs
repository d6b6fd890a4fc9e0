//! A network and its steps, by seed.

use pennate_solver::structure::{Branch, Change, Dimension, Formulation, Method, Release, Step, Stop};

use super::network::{LENGTH, Network, Recipe, network};
use super::shapes::shape;

/// Nodes of most networks at most.
const SMALL_NETWORK: usize = 16;

/// The network and the steps of a seed: of up to 16 nodes, one in twenty of up to `most`.
pub fn case(seed: u64, most: usize) -> (Recipe, Network, Vec<Step>) {
    let mut random = fastrand::Rng::with_seed(!seed);
    let deep = random.bool();
    let size = random.f64();
    let small = most.min(SMALL_NETWORK);
    let nodes = if seed % 20 == 7 {
        small + ((most - small) as f64 * size) as usize
    } else {
        3 + ((small - 3) as f64 * size.powi(4)) as usize
    };
    let recipe = Recipe {
        seed,
        dimension: if deep { Dimension::Space } else { Dimension::Plane },
        nodes,
        extra: random.usize(0..=nodes * 4 / 5),
        follower: random.bool(),
    };
    let mut network = network(&recipe);
    vary(&mut network, &recipe, &mut random);
    let mut steps = steps(&network, &mut random);
    if seed % 2 == 1 {
        shape(&mut network, recipe.follower, &mut random);
        stops(&mut steps, &network, &mut random);
    }
    (recipe, network, steps)
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

/// Ends arcs where a component reaches a value, or a part of the ramp.
fn stops(steps: &mut [Step], network: &Network, random: &mut fastrand::Rng) {
    let structure = &network.structure;
    for step in steps.iter_mut().filter(|step| step.method == Method::ArcLength) {
        let node = random.usize(1..structure.nodes.len());
        let of = if structure.dimension == Dimension::Space { [0, 1, 2, 3, 4, 5].as_slice() } else { &[0, 1, 5] };
        let component = of[random.usize(0..of.len())];
        let value = (random.f64() - 0.5) * if component < 3 { 0.3 * LENGTH } else { 1.0 };
        step.stop = match random.u8(0..4) {
            0 => step.stop,
            1 => Some(Stop::Fraction(random.f64())),
            _ => Some(Stop::At { node, component, value }),
        };
        if random.bool() {
            step.branch = Branch::Primary;
        }
    }
}

/// Every load on its own at up to twice its size, some left as they are.
fn targets(network: &Network, random: &mut fastrand::Rng) -> Vec<(usize, f64)> {
    let part = 2.0 * random.f64();
    let control = (0, random.f64());
    let loads = network.loads[1..].iter().map(|&(drive, value)| (drive, part * value));
    std::iter::once(control).chain(loads).filter(|_| random.u8(0..5) > 0).collect()
}
