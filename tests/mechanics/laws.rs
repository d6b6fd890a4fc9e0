//! Laws that every network keeps, tried on random ones.

use nalgebra::{Matrix3, Rotation3};
use pennate_solver::history::{Equilibrium, History, Status};
use pennate_solver::options::Options;
use pennate_solver::structure::{
    Dimension, Drive, Member, Method, Release, Segment, Spring, Stability, Step, Structure, Support,
};
use pennate_testing::random::network::{Actuated, EI, LENGTH, Network, Recipe, Vector, network};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};

/// Cases of a law; the seed is fixed, so that a failure is one for everybody.
fn cases(cases: u32) -> Config {
    Config { cases, rng_seed: RngSeed::Fixed(20_260), failure_persistence: None, ..Config::default() }
}

fn recipes(follower: bool) -> impl Strategy<Value = Recipe> {
    (any::<bool>(), 3..10usize, 0..8usize, any::<u64>()).prop_map(move |(deep, nodes, extra, seed)| Recipe {
        seed,
        dimension: if deep { Dimension::Space } else { Dimension::Plane },
        nodes,
        extra,
        follower,
    })
}

fn run(structure: &Structure, steps: &[Step]) -> History {
    let solved = pennate_solver::solve(structure, steps, &Options::default(), &mut |_| true);
    solved.unwrap_or_else(|error| panic!("{error}: {structure:?}"))
}

/// The end of the last step, where all converged without a singular point on the way.
fn calm(history: &History) -> Option<&Equilibrium> {
    let smooth = history.steps.iter().all(|step| step.status == Status::Converged && step.critical_points.is_empty());
    let last = history.steps.last()?.increments.last()?;
    smooth.then_some(&last.state)
}

/// The state under all loads.
fn end(network: &Network) -> Option<Equilibrium> {
    let step = Step { targets: network.loads.clone(), ..Step::default() };
    calm(&run(&network.structure, &[step])).cloned()
}

/// One long increment of loads without a potential may converge to a far, unstable state: of the first of these it leaps over a
/// limit point.
#[test]
fn loads_without_a_potential_lead_to_one_state_in_any_increments() {
    let (plane, space) = (Dimension::Plane, Dimension::Space);
    for (seed, dimension, nodes, extra, factor) in [
        (138, space, 3, 0, 4.0),
        (108, space, 4, 2, 4.0),
        (11, plane, 4, 3, 2.0),
        (275, plane, 5, 5, 1.0),
        (18221567323697450071, space, 9, 5, 1.0),
    ] {
        let network = network(&Recipe { seed, dimension, nodes, extra, follower: true });
        let load = |&(drive, value): &(usize, f64)| (drive, if drive == 0 { value } else { factor * value });
        let step = Step { targets: network.loads.iter().map(load).collect(), ..Step::default() };
        let small = Step { min_increments: Some(100), ..step.clone() };
        let [a, b] = [step, small].map(|step| run(&network.structure, &[step]).steps.remove(0));
        assert_eq!((a.status, a.critical_points.len()), (b.status, b.critical_points.len()), "seed {seed}");
        assert!((a.fraction - b.fraction).abs() < 1e-6, "seed {seed}: {} {}", a.fraction, b.fraction);
        let [a, b] = [a, b].map(|step| step.increments.last().unwrap().state.clone());
        for (a, b) in a.nodes.iter().zip(&b.nodes) {
            let apart = (Vector::from(a.displacement) - Vector::from(b.displacement)).norm() / LENGTH;
            assert!(apart < 1e-4, "seed {seed}: {apart:.1e}");
        }
    }
}

/// Largest differences of displacements over lengths, of forces and moments over the largest force, and of the energy.
#[track_caller]
fn differences(
    network: &Network,
    plain: &Equilibrium,
    other: &Equilibrium,
    (shift, turn): (impl Fn([f64; 3]) -> Vector, impl Fn([f64; 3]) -> Vector),
    nodes: impl Fn(usize) -> usize,
) -> f64 {
    let norm = |v: [f64; 3]| Vector::from(v).norm();
    let force = plain.members.iter().map(|member| norm(member.end_forces[0])).fold(1e-3, f64::max);
    let mut worst = (plain.energy - other.energy).abs() / (force * LENGTH);
    for node in 0..network.structure.nodes.len() {
        let (a, b) = (&plain.nodes[node], &other.nodes[nodes(node)]);
        worst = worst.max((shift(a.displacement) - Vector::from(b.displacement)).norm() / LENGTH);
        worst = worst.max((shift(a.reaction_force) - Vector::from(b.reaction_force)).norm() / force);
        worst = worst.max((turn(a.reaction_moment) - Vector::from(b.reaction_moment)).norm() / (force * LENGTH));
    }
    worst
}

/// The network after a rotation, or a mirror, and a shift.
fn moved(network: &Network, by: Matrix3<f64>, shift: Vector) -> Network {
    let sign = by.determinant().signum();
    let turn = |v: [f64; 3]| -> [f64; 3] { (by * Vector::from(v)).into() };
    // Axes stay right-handed.
    let frame = |axes: [[f64; 3]; 3]| [turn(axes[0]), turn(axes[1]).map(|x| sign * x), turn(axes[2])];
    let mut moved = network.clone();
    let structure = &mut moved.structure;
    structure.nodes.iter_mut().for_each(|node| *node = (by * Vector::from(*node) + shift).into());
    structure.supports.iter_mut().for_each(|support| support.axes = frame(support.axes));
    for member in &mut structure.members {
        member.axes = frame(member.axes);
        for release in &mut member.releases {
            if let Release::Axes(axes) = release {
                axes.iter_mut().for_each(|axis| *axis = turn(*axis));
            }
        }
    }
    for three in moved.loads[1..].chunks_mut(3) {
        let axial = matches!(structure.drives[three[0].0], Drive::Moment(..) | Drive::FollowerMoment(..));
        let vector = turn([three[0].1, three[1].1, three[2].1]);
        three.iter_mut().zip(vector).for_each(|(load, x)| load.1 = if axial { sign * x } else { x });
    }
    moved.laws.iter_mut().for_each(|law| law.curvature *= sign);
    moved.adopt_laws();
    moved
}

proptest! {
    #![proptest_config(cases(60))]

    #[test]
    fn a_rigid_motion_changes_directions_alone(recipe in recipes(true), angles in [-3.0..3.0, -3.0..3.0, -3.0..3.0f64]) {
        let plain = network(&recipe);
        let angles = Vector::from(angles);
        let angles = if recipe.dimension == Dimension::Plane { Vector::new(0.0, 0.0, angles.z) } else { angles };
        let by = Rotation3::new(angles).into_inner();
        let shift = if recipe.dimension == Dimension::Plane { Vector::new(70.0, -90.0, 0.0) } else { Vector::new(70.0, -90.0, 30.0) };
        // Ground springs, whose stiffness is the same in all directions, turn too.
        let Some(before) = end(&plain) else { return Err(TestCaseError::reject("singular points")) };
        let after = end(&moved(&plain, by, shift));
        prop_assert!(after.is_some());
        let turn = |v: [f64; 3]| by * Vector::from(v);
        let worst = differences(&plain, &before, &after.unwrap(), (turn, turn), |node| node);
        prop_assert!(worst < 1e-9, "{worst:.1e}");
    }

    #[test]
    fn a_mirrored_network_gives_the_mirrored_answer(recipe in recipes(true)) {
        let plain = network(&recipe);
        let by = Matrix3::from_diagonal(&Vector::new(1.0, -1.0, 1.0));
        let Some(before) = end(&plain) else { return Err(TestCaseError::reject("singular points")) };
        let after = end(&moved(&plain, by, Vector::zeros()));
        prop_assert!(after.is_some());
        let worst = differences(&plain, &before, &after.unwrap(), (|v| by * Vector::from(v), |v| -(by * Vector::from(v))), |node| node);
        prop_assert!(worst < 1e-9, "{worst:.1e}");
    }

    /// Forces in other units, by powers of two, give the same bits; lengths are weighed against angles and round otherwise.
    #[test]
    fn other_units_give_the_same_digits(recipe in recipes(true), lengths in -20..20i32, forces in -20..20i32) {
        let plain = network(&recipe);
        let f = 2f64.powi(forces);
        let Some(before) = end(&plain) else { return Err(TestCaseError::reject("singular points")) };
        for (l, least) in [(1.0, 0.0), (2f64.powi(lengths), 1e-12)] {
            let after = end(&scaled(&plain, l, f));
            prop_assert!(after.is_some());
            let mut after = after.unwrap();
            after.energy /= l * f;
            for node in &mut after.nodes {
                node.displacement = node.displacement.map(|x| x / l);
                node.reaction_force = node.reaction_force.map(|x| x / f);
                node.reaction_moment = node.reaction_moment.map(|x| x / (f * l));
            }
            let worst = differences(&plain, &before, &after, (Vector::from, Vector::from), |node| node);
            // Forces of slender members keep fewer digits than displacements.
            prop_assert!(worst <= 100.0 * least, "{worst:.1e}");
            for (a, b) in before.nodes.iter().zip(&after.nodes) {
                let apart = (Vector::from(a.displacement) - Vector::from(b.displacement)).norm();
                prop_assert!(apart <= least * LENGTH, "{apart:.1e}");
            }
        }
    }

    /// The file may list nodes and members in any order.
    #[test]
    fn order_makes_no_difference(recipe in recipes(true), seed in any::<u64>()) {
        let plain = network(&recipe);
        let Some(before) = end(&plain) else { return Err(TestCaseError::reject("singular points")) };
        let mut place: Vec<usize> = (0..plain.structure.nodes.len()).collect();
        fastrand::Rng::with_seed(seed).shuffle(&mut place);
        let after = end(&reordered(&plain, &place));
        prop_assert!(after.is_some());
        let worst = differences(&plain, &before, &after.unwrap(), (Vector::from, Vector::from), |node| place[node]);
        prop_assert!(worst < 1e-9, "{worst:.1e}");
    }

    /// A welded node anywhere on a member changes it by its mesh alone.
    #[test]
    fn a_member_may_be_split_anywhere(recipe in recipes(false), at in 0.2..0.8f64) {
        let mut plain = network(&recipe);
        plain.structure.members.iter_mut().for_each(|member| { member.order = 4; member.segments[0].elements = 6; });
        let Some(before) = end(&plain) else { return Err(TestCaseError::reject("singular points")) };
        let after = end(&split(&plain, at));
        prop_assert!(after.is_some());
        let worst = differences(&plain, &before, &after.unwrap(), (Vector::from, Vector::from), |node| node);
        prop_assert!(worst < 1e-6, "{worst:.1e}");
    }

    /// Elements refer their rotations to their first node: the other way round they differ, of the same rod, by their mesh.
    #[test]
    fn a_member_may_run_the_other_way(recipe in recipes(false)) {
        let mut plain = network(&recipe);
        plain.structure.members.iter_mut().for_each(|member| { member.order = 4; member.segments[0].elements = 24; });
        // Nothing but the order of its nodes says how a bar of two pins is turned about itself.
        for (member, law) in plain.structure.members.iter().zip(&mut plain.laws) {
            if member.releases == [Release::Pin, Release::Pin] {
                law.section.ei2 = law.section.ei3;
                law.curvature = 0.0;
            }
        }
        plain.adopt_laws();
        let Some(before) = end(&plain) else { return Err(TestCaseError::reject("singular points")) };
        let after = end(&reversed(&plain));
        prop_assert!(after.is_some());
        let worst = differences(&plain, &before, &after.unwrap(), (Vector::from, Vector::from), |node| node);
        prop_assert!(worst < 1e-6, "{worst:.1e}");
    }

    /// Loads with a potential: the compliance is symmetric.
    #[test]
    fn compliance_is_reciprocal(recipe in recipes(false)) {
        let Some(state) = end(&network(&recipe)) else { return Err(TestCaseError::reject("singular points")) };
        let c = state.compliances[0];
        let size = |a: usize| c[a][a].abs().sqrt();
        for (a, b) in (0..6).flat_map(|a| (0..a).map(move |b| (a, b))) {
            prop_assert!((c[a][b] - c[b][a]).abs() <= 1e-9 * size(a) * size(b), "{a}, {b}: {c:?}");
        }
        prop_assert!((0..3).any(|a| c[a][a] > 0.0));
    }

    /// Reactions and loads on the whole: forces, and moments about the origin.
    #[test]
    fn reactions_balance_loads(recipe in recipes(true)) {
        let network = network(&recipe);
        let Some(state) = end(&network) else { return Err(TestCaseError::reject("singular points")) };
        prop_assert!(state.balance < 1e-9, "{:.1e}", state.balance);
        // Without what acts along members, at unknown places, and what turns.
        let still = |drive: &Drive| matches!(drive, Drive::Force(..) | Drive::Moment(..) | Drive::Control);
        let mut bare = network.clone();
        bare.loads.retain(|(drive, _)| still(&bare.structure.drives[*drive]));
        bare.structure.springs.retain(|spring| !matches!(spring, Spring::Ground { .. }));
        let Some(state) = end(&bare) else { return Err(TestCaseError::reject("singular points")) };
        let place = |node: usize| Vector::from(bare.structure.nodes[node]) + Vector::from(state.nodes[node].displacement);
        let (mut force, mut moment, mut size) = (Vector::zeros(), Vector::zeros(), 0.0f64);
        for (node, now) in state.nodes.iter().enumerate() {
            let f = Vector::from(now.reaction_force);
            force += f;
            moment += place(node).cross(&f) + Vector::from(now.reaction_moment);
            size = size.max(f.norm());
        }
        for &(drive, value) in &bare.loads {
            let unit = |component: usize| { let mut v = Vector::zeros(); v[component] = value; v };
            match bare.structure.drives[drive] {
                Drive::Force(node, c) => { force += unit(c); moment += place(node).cross(&unit(c)); }
                Drive::Moment(_, c) => moment += unit(c),
                _ => {}
            }
        }
        prop_assert!(force.norm() <= 1e-9 * size, "{:.1e} of {size}", force.norm());
        prop_assert!(moment.norm() <= 1e-8 * size * LENGTH, "{:.1e} of {size}", moment.norm());
    }

    /// Loads with a potential, brought one after the other and taken away in the same order, leave nothing behind.
    #[test]
    fn a_closed_cycle_does_no_work(recipe in recipes(false)) {
        let mut network = network(&recipe);
        network.structure.springs.retain(|spring| !matches!(spring, Spring::Axial { .. }));
        let half = network.loads.len() / 2;
        let part = |range: &[(usize, f64)], factor: f64| Step {
            targets: range.iter().map(|&(drive, value)| (drive, factor * value)).collect(),
            ..Step::default()
        };
        let (first, second) = network.loads.split_at(half);
        let steps = [part(first, 1.0), part(second, 1.0), part(first, 0.0), part(second, 0.0)];
        let history = run(&network.structure, &steps);
        let Some(end) = calm(&history) else { return Err(TestCaseError::reject("singular points")) };
        let most = history.steps.iter().map(|step| step.increments.last().unwrap().state.energy).fold(0.0, f64::max);
        prop_assert!(most > 0.0 && end.energy <= 1e-12 * most, "{:.1e} of {most:.1e}", end.energy);
        let far = end.nodes.iter().map(|node| Vector::from(node.displacement).norm()).fold(0.0, f64::max);
        prop_assert!(far < 1e-9 * LENGTH, "{far:.1e}");
    }
}

proptest! {
    #![proptest_config(cases(40))]

    /// Shallow arches snap, and the energy of the rod and its load falls by what is reported.
    #[test]
    fn energy_falls_along_a_jump(height in 2.0..6.0f64, place in 0.3..0.7f64, slenderness in 60.0..200.0f64) {
        let recipe = Recipe { seed: 1, dimension: Dimension::Plane, nodes: 3, extra: 0, follower: false };
        let mut arch = network(&recipe);
        let structure = &mut arch.structure;
        structure.stability = Stability::Plane;
        structure.nodes = vec![[0.0; 3], [120.0 * place, height, 0.0], [120.0, 0.0, 0.0]];
        structure.bodies.clear();
        structure.springs.clear();
        structure.compliances.clear();
        let held = |node| Support { node, fixed: [true; 6], axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] };
        structure.supports = vec![held(0), held(2)];
        structure.drives = vec![Drive::Force(1, 1)];
        for (member, pair) in structure.members.iter_mut().zip([[0, 1], [1, 2]]) {
            let ends = pair.map(|node| Vector::from(structure.nodes[node]));
            let tangent = (ends[1] - ends[0]).normalize();
            member.nodes = pair;
            member.axes = [tangent.into(), [-tangent.y, tangent.x, 0.0], [0.0, 0.0, 1.0]];
            member.segments[0].length = (ends[1] - ends[0]).norm();
            member.control = None;
        }
        for law in &mut arch.laws {
            *law = Actuated { strain: 0.0, curvature: 0.0, ..*law };
            law.section.ei3 = EI;
            law.section.ea = EI * (slenderness / 60.0).powi(2);
        }
        arch.adopt_laws();
        let force = -400.0;
        let step = Step { targets: vec![(0, force)], method: Method::Jump, min_increments: Some(20), ..Step::default() };
        let history = run(&arch.structure, &[step]);
        let step = &history.steps[0];
        prop_assert_eq!(step.status, Status::Converged);
        let Some(jump) = step.jumps.first() else { return Err(TestCaseError::reject("no snap")) };
        prop_assert!(jump.released > 0.0);
        // The jump leads from one state at its fraction to another.
        let after = step.increments.iter().rposition(|increment| increment.fraction <= jump.fraction);
        prop_assert!(after.is_some_and(|after| after > 0));
        let [before, after] = [after.unwrap() - 1, after.unwrap()].map(|at| &step.increments[at]);
        let potential = |state: &Equilibrium| state.energy - jump.fraction * force * state.nodes[1].displacement[1];
        let fallen = potential(&before.state) - potential(&after.state);
        prop_assert!(fallen > 0.0 && (fallen - jump.released).abs() < 1e-3 * fallen, "{fallen} {}", jump.released);
    }
}

/// Lengths times `l`, forces times `f`.
fn scaled(network: &Network, l: f64, f: f64) -> Network {
    let mut scaled = network.clone();
    let structure = &mut scaled.structure;
    structure.nodes.iter_mut().flatten().for_each(|x| *x *= l);
    structure.members.iter_mut().flat_map(|member| &mut member.segments).for_each(|segment| segment.length *= l);
    for spring in &mut structure.springs {
        match spring {
            Spring::Axial { stiffness, natural_length, .. } => {
                *stiffness *= f / l;
                *natural_length *= l;
            }
            Spring::Ground { stiffness, .. } | Spring::Coupling { stiffness, .. } => {
                stiffness[..3].iter_mut().for_each(|k| *k *= f / l);
                stiffness[3..].iter_mut().for_each(|k| *k *= f * l);
            }
        }
    }
    for law in &mut scaled.laws {
        let s = &mut law.section;
        [&mut s.ea, &mut s.ga2, &mut s.ga3].into_iter().for_each(|k| *k *= f);
        [&mut s.gj, &mut s.ei2, &mut s.ei3].into_iter().for_each(|k| *k *= f * l * l);
        // The unit of mass stays, that of acceleration is force over mass.
        s.mass_per_length /= l;
        law.curvature /= l;
    }
    scaled.adopt_laws();
    for load in &mut scaled.loads {
        load.1 *= match scaled.structure.drives[load.0] {
            Drive::Control => 1.0,
            Drive::Force(..) | Drive::FollowerForce(..) | Drive::Gravity(_) => f,
            Drive::Moment(..) | Drive::FollowerMoment(..) => f * l,
            Drive::Distributed(..) => f / l,
        };
    }
    scaled
}

/// Node `i` becomes node `place[i]`, and the last member the first.
fn reordered(network: &Network, place: &[usize]) -> Network {
    let mut other = network.clone();
    let structure = &mut other.structure;
    for (node, &to) in place.iter().enumerate() {
        structure.nodes[to] = network.structure.nodes[node];
    }
    let count = structure.members.len();
    structure.members.reverse();
    structure.members.iter_mut().for_each(|member| member.nodes = member.nodes.map(|node| place[node]));
    structure.supports.iter_mut().for_each(|support| support.node = place[support.node]);
    structure.compliances.iter_mut().for_each(|wanted| wanted.node = place[wanted.node]);
    for body in &mut structure.bodies {
        body.nodes.iter_mut().for_each(|node| *node = place[*node]);
        body.reference = place[body.reference];
    }
    structure.springs.iter_mut().flat_map(Spring::nodes_mut).for_each(|node| *node = place[*node]);
    for drive in &mut structure.drives {
        match drive {
            Drive::Force(node, _)
            | Drive::Moment(node, _)
            | Drive::FollowerForce(node, _)
            | Drive::FollowerMoment(node, _) => *node = place[*node],
            Drive::Distributed(member, _) => *member = count - 1 - *member,
            Drive::Control | Drive::Gravity(_) => {}
        }
    }
    other
}

/// The last member in two parts.
fn split(network: &Network, at: f64) -> Network {
    let mut other = network.clone();
    let structure = &mut other.structure;
    let index = structure.members.len() - 1;
    let [a, b] = structure.members[index].nodes.map(|node| Vector::from(structure.nodes[node]));
    structure.nodes.push((a + at * (b - a)).into());
    let new = structure.nodes.len() - 1;
    let part = |member: &Member, nodes, part: f64, releases| Member {
        nodes,
        releases,
        segments: vec![Segment { length: part * member.segments[0].length, ..member.segments[0] }],
        ..member.clone()
    };
    let whole = structure.members[index].clone();
    let [start, end] = whole.releases.clone();
    structure.members[index] = part(&whole, [whole.nodes[0], new], at, [start, Release::Welded]);
    structure.members.push(part(&whole, [new, whole.nodes[1]], 1.0 - at, [Release::Welded, end]));
    // A load per length acts on both parts.
    let drives: Vec<(usize, usize)> = (structure.drives.iter().enumerate())
        .filter_map(|(drive, what)| match what {
            Drive::Distributed(member, c) if *member == index => Some((drive, *c)),
            _ => None,
        })
        .collect();
    for (drive, c) in drives {
        structure.drives.push(Drive::Distributed(index + 1, c));
        let value = other.loads.iter().find(|load| load.0 == drive).unwrap().1;
        other.loads.push((structure.drives.len() - 1, value));
    }
    other
}

/// Every member from its end to its start: turned by half a turn about its axis 2.
fn reversed(network: &Network) -> Network {
    let mut other = network.clone();
    let back = |axis: [f64; 3]| axis.map(|x| -x);
    let deep = network.structure.dimension == Dimension::Space;
    for (member, law) in other.structure.members.iter_mut().zip(&mut other.laws) {
        member.nodes.reverse();
        member.releases.reverse();
        let [first, second, third] = member.axes;
        member.axes = if deep { [back(first), second, back(third)] } else { [back(first), back(second), third] };
        // What bends towards axis 2, which stays in space and turns in the plane.
        law.curvature *= if deep { 1.0 } else { -1.0 };
    }
    other.adopt_laws();
    other
}
