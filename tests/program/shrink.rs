//! The shrinker of network files, and the writer of structures that feeds it.

use pennate_models::{Model, read_text};
use pennate_solver::options::Options;
use pennate_solver::structure::{Drive, Step, Structure};
use pennate_testing::failures::Failure;
use pennate_testing::increments::{self, read};
use pennate_testing::random::case::case;
use pennate_testing::random::network::Vector;
use pennate_testing::shrink::shrink;
use pennate_testing::tree::print;
use pennate_testing::write::write;

/// A random network of 9 nodes and 15 members under loads of every kind.
fn large() -> String {
    let (_, network, steps) = case(1178, 16);
    print(&write(&network.structure, &steps).0)
}

fn model(text: &str) -> Option<Model> {
    read_text("network.toml", text, &[]).ok()
}

/// A follower force needs its node, a node a member, and a member two nodes and a section: nothing else is left of 15 members.
#[test]
fn what_a_failure_does_not_need_goes() {
    let pushed = |text: &str| {
        let Ok((structure, steps)) = read(text) else { return false };
        let pushes = |&(drive, value): &(usize, f64)| {
            matches!(structure.drives[drive], Drive::FollowerForce(..)) && f64::abs(value) > 0.01
        };
        steps.iter().any(|step| step.targets.iter().any(pushes))
    };
    let text = large();
    assert!(text.len() > 5_000 && pushed(&text));
    let shrunk = shrink(&text, pushed).unwrap();
    let model = model(&shrunk.text).unwrap();
    assert_eq!((model.nodes.len(), model.members.len(), model.steps.len()), (2, 1, 1), "{}", shrunk.text);
    assert!(model.springs.is_empty() && model.bodies.is_empty());
    let force = shrunk.text.lines().filter(|line| line.starts_with("follower_force"));
    let numbers: Vec<&str> = force.flat_map(|line| line.split(['[', ',', ']']).skip(1)).map(str::trim).collect();
    assert!(numbers.contains(&"1") && !shrunk.text.contains('.'), "{}", shrunk.text);
}

/// The length of a member is what fails: its segments follow its nodes, so that they can have short coordinates.
#[test]
fn segments_follow_the_nodes_that_are_rounded() {
    let text = "format = \"pennate/1\"\n\
        nodes = { A = [0.123456789, 0], B = [71.98765432101, 33.3333333333] }\n\
        sections.s = { stiffness = { EA = 100, EI3 = 10 } }\n\
        supports.A = \"clamped\"\n\
        members.m = { nodes = [\"A\", \"B\"], segments = [{ length = 39.6092602747, section = \"s\" }, \
        { length = 39.6092602747, section = \"s\", strain = -0.123456 }] }\n";
    let contracts = |text: &str| {
        model(text).is_some_and(|model| {
            model
                .members
                .iter()
                .any(|member| member.length > 60.0 && member.segments.len() == 2 && text.contains("strain"))
        })
    };
    let shrunk = shrink(text, contracts).unwrap().text;
    let nodes = shrunk.split("[sections]").next().unwrap();
    assert!(!nodes.contains('.'), "{shrunk}");
    assert!(contracts(&shrunk) && shrunk.len() < text.len());
}

#[test]
fn a_file_that_does_not_fail_is_not_shrunk() {
    assert!(shrink(&large(), |_| false).unwrap_err().contains("does not fail"));
    assert!(shrink("nodes = [", |_| true).is_err());
}

/// What the command line of the shrinker asks for.
#[test]
fn failures_are_told_from_what_is_sound() {
    let sound = include_str!("../../models/networks/dyad.toml");
    for failure in
        [Failure::Elsewhere, Failure::Status, Failure::Contradicted, Failure::Panics, Failure::Probe("stroke".into())]
    {
        assert!(!failure.holds(sound), "{failure:?}");
    }
    assert!(Failure::Command("grep -q pressure {}".into()).holds(sound));
    assert!(!Failure::Command("grep -q actuation {}".into()).holds(sound));
}

fn end(structure: &Structure, steps: &[Step]) -> Vec<[f64; 3]> {
    let history = pennate_solver::solve(structure, steps, &Options::default(), &mut |_| true).unwrap();
    let last = history.steps.iter().rev().find_map(|step| step.increments.last()).unwrap();
    last.state.nodes.iter().map(|node| node.displacement).collect()
}

/// Random networks whose sections stay as they are, in the plane and in space, curved and of several segments: read from the file
/// that is written of them, they end in the same state.
#[test]
fn a_structure_is_solved_as_its_file_is() {
    let mut seen = [0, 0];
    for seed in 0..60 {
        let (_, network, steps) = case(seed, 6);
        let (tree, unsaid) = write(&network.structure, &steps);
        if !unsaid.is_empty() {
            continue;
        }
        let text = print(&tree);
        let (structure, read) = increments::read(&text).unwrap_or_else(|error| panic!("seed {seed}: {error}\n{text}"));
        for (a, b) in end(&network.structure, &steps).iter().zip(end(&structure, &read)) {
            let apart = (Vector::from(*a) - Vector::from(b)).norm();
            assert!(apart < 1e-6, "seed {seed}: {apart:.1e}\n{text}");
        }
        seen[usize::from(structure.dimension == pennate_solver::structure::Dimension::Space)] += 1;
    }
    assert!(seen[0] >= 3 && seen[1] >= 3, "{seen:?}");
}
