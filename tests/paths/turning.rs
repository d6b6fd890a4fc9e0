//! Round members in a line that buckle in any plane: nothing resists turning that plane, and nothing else is hidden by it.

use std::f64::consts::{PI, TAU};

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_analysis::solution::Solution;
use pennate_solver::history::{CriticalKind, Equilibrium, Note, Status, StepHistory};
use pennate_solver::options::Options;
use pennate_testing::network::model;

/// A network as a user has it solved.
fn solve(text: &str) -> Solution {
    let options = Options { estimate: true, ..Options::default() };
    solve_to_accuracy(model(text), 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}"))
}

fn end(step: &StepHistory) -> &Equilibrium {
    &step.increments.last().expect("a state").state
}

/// Displacement of a node along y, and away from that axis.
fn moved(solution: &Solution, step: usize, node: &str) -> [f64; 2] {
    let index = solution.model.nodes.iter().position(|n| n.name == node).expect("the node");
    let [x, y, z] = end(&solution.history.steps[step]).nodes[index].displacement;
    [y, x.hypot(z)]
}

/// Whether a step came to its stable end by one bifurcation, at this fraction.
#[track_caller]
fn assert_buckled(step: &StepHistory, fraction: f64, within: f64) {
    assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{:?}", step.critical_points);
    let [point] = step.critical_points.as_slice() else { panic!("{:?}", step.critical_points) };
    assert_eq!(point.kind, CriticalKind::Bifurcation);
    assert!((point.fraction / fraction - 1.0).abs() < within, "{} against {fraction}", point.fraction);
}

/// Nodes N0, N1, ... on the y axis at these parts of a length, and round members of a section `s` between them.
fn line(length: f64, parts: &[f64]) -> String {
    let nodes: Vec<_> =
        parts.iter().enumerate().map(|(i, part)| format!("N{i} = [0, {:?}, 0]", part * length)).collect();
    let members = (1..parts.len()).map(|i| format!("m{i} = {{ nodes = ['N{}', 'N{i}'], section = 's' }}", i - 1));
    format!("[nodes]\n{}\n[members]\n{}\n", nodes.join("\n"), members.collect::<Vec<_>>().join("\n"))
}

/// A round column that stands on its foot and buckles under its own weight, q L³ = 7.83735 EI (Greenhill 1881), leans in some vertical
/// plane as it does where it cannot leave one.
#[test]
fn round_columns_lean_under_their_own_weight() {
    for (parts, torsion, times) in [
        (&[0.0, 1.0][..], 2000.0, 8.0),
        (&[0.0, 0.5, 1.0], 2000.0, 2.0),
        (&[0.0, 0.5, 1.0], 8000.0, 4.0),
        (&[0.0, 0.2, 0.6, 1.0], 4000.0, 1.1),
        (&[0.0, 0.2, 0.6, 1.0], 8000.0, 8.0),
    ] {
        let (length, bending) = (300.0_f64, 1e4);
        let mass = times * 7.837_347_4 * bending / length.powi(3) / 9810.0;
        let [space, plane] = ["space", "plane"].map(|dimension| {
            solve(&format!(
                "format = 'pennate/1'\ndimension = '{dimension}'\n{}[supports]\nN0 = 'clamped'\n\
                 [sections.s]\nstretch = false\nshear = false\nstiffness = {{ EI2 = {bending}, EI3 = {bending}, GJ = {torsion}, \
                 mass_per_length = {mass:e} }}\n[[steps]]\ngravity = [0, -9810, 0]\n",
                line(length, parts)
            ))
        });
        assert_buckled(&space.history.steps[0], 1.0 / times, 1e-5);
        let tip = format!("N{}", parts.len() - 1);
        let [free, held] = [&space, &plane].map(|solution| moved(solution, 0, &tip));
        for (free, held) in free.into_iter().zip(held) {
            assert!((free - held).abs() < 3e-6 * length, "{free} instead of {held} of {parts:?}");
        }
    }
}

/// Round struts whose ends come nearer by a tenth, which cannot be sheared or can, are bent as much as where they cannot leave a plane.
#[test]
fn round_struts_bend_in_some_plane() {
    for (ends, parts, shear) in [
        ("pinned", &[0.0, 1.0][..], false),
        ("pinned", &[0.0, 1.0], true),
        ("pinned", &[0.0, 0.4, 1.0], false),
        ("clamped", &[0.0, 0.3, 1.0], false),
        ("clamped", &[0.0, 0.3, 0.7, 1.0], true),
    ] {
        let (length, last) = (1000.0, parts.len() - 1);
        let [space, plane] = ["space", "plane"].map(|dimension| {
            solve(&format!(
                "format = 'pennate/1'\ndimension = '{dimension}'\n{}[supports]\nN0 = '{ends}'\nN{last} = '{ends}'\n\
                 [sections.s]\nshear = {shear}\nstiffness = {{ EA = 1, GA2 = 0.3, GA3 = 0.3, EI2 = 1, EI3 = 1, GJ = 0.8 }}\n\
                 [[steps]]\ndisplacement = {{ N{last} = {{ uy = -100 }} }}\n",
                line(length, parts)
            ))
        });
        // Euler's strain, π² over the square of the slenderness, shear and the shortening before left out.
        let slenderness = if ends == "pinned" { 1000.0 } else { 500.0 };
        assert_buckled(&space.history.steps[0], (PI / slenderness).powi(2) / 0.1, 1e-3);
        let [free, held] = [&space, &plane].map(|solution| end(&solution.history.steps[0]).energy);
        assert!((free / held - 1.0).abs() < 1e-6, "{free} instead of {held}: {ends} {parts:?} {shear}");
    }
}

/// Along the arc a clamped round strut goes on along the elastica as well.
#[test]
fn a_clamped_round_strut_bends_along_the_arc() {
    let solution = solve(&format!(
        "format = 'pennate/1'\ndimension = 'space'\n{}[supports]\nN0 = 'clamped'\nN2 = 'clamped'\n\
         [sections.s]\nstiffness = {{ EA = 500, EI2 = 1, EI3 = 1, GJ = 0.8 }}\n\
         [[steps]]\nmethod = 'arc_length'\ndisplacement = {{ N2 = {{ uy = -3 }} }}\n",
        line(100.0, &[0.0, 0.5, 1.0])
    ));
    assert_buckled(&solution.history.steps[0], (TAU / 100.0).powi(2) / 500.0 * 100.0 / 3.0, 1e-3);
}

/// What bends in any plane says so, turns to where the first load across it wants it, whichever way that is, and no stiffness is said to
/// resist it before.
#[test]
fn a_load_across_decides_about_the_plane_of_bending() {
    let solve = |[x, z]: [f64; 2]| {
        solve(&format!(
            "format = 'pennate/1'\ndimension = 'space'\n{}[supports]\nN0 = 'clamped'\nN2 = ['ux', 'uz', 'rx', 'ry', 'rz']\n\
             [sections.s]\nshear = false\nstiffness = {{ EA = 1e3, EI2 = 1, EI3 = 1, GJ = 0.8 }}\n\
             [probes]\nkx = {{ node = 'N1', stiffness = 'ux' }}\nkz = {{ node = 'N1', stiffness = 'uz' }}\n\
             [[steps]]\ndisplacement = {{ N2 = {{ uy = -10 }} }}\n[[steps]]\nforce = {{ N1 = [{x}, 0, {z}] }}\n",
            line(100.0, &[0.0, 0.5, 1.0])
        ))
    };
    let ways = [[1e-3, 0.0], [0.0, -1e-3], [-6e-4, 8e-4]];
    let found = ways.map(|[x, z]| {
        let solution = solve([x, z]);
        let [pushed, across] = &solution.history.steps[..] else { panic!("two steps") };
        assert_eq!((across.status, across.stable), (Status::Converged, Some(true)), "{x} {z}");
        let note = Note::TurnsFreely { nodes: vec![0, 1, 2], axis: [0.0, 1.0, 0.0] };
        let said = [pushed, across].map(|step| step.notes.contains(&note));
        assert_eq!(said, [true, false], "{x} {z}");
        // In the plane of bending a unit force moves the middle by some L³ / (192 EI), at right angles to it without end.
        let softest = end(pushed).compliances.iter().map(|columns| columns[0][0] + columns[2][2]);
        let softest = softest.fold(0.0, |most: f64, compliance| most.max(compliance.abs()));
        assert!(softest > 1e3 * 100.0f64.powi(3) / 192.0, "{softest}");
        let index = solution.model.nodes.iter().position(|n| n.name == "N1").expect("the middle");
        let [dx, _, dz] = end(across).nodes[index].displacement;
        let away = dx.hypot(dz);
        let along = (x * dx + z * dz) / x.hypot(z);
        assert!((along / away - 1.0).abs() < 1e-9 && away > 10.0, "{dx} {dz} under {x} {z}");
        (away, end(across).energy)
    });
    for (away, energy) in &found[1..] {
        assert!((away / found[0].0 - 1.0).abs() < 1e-6 && (energy / found[0].1 - 1.0).abs() < 1e-6, "{found:?}");
    }
}

/// A round column between held ends, which no joint tells of: pushed in it bends in some plane, and a load across turns that to where it
/// wants it, as one member and as two.
#[test]
fn a_load_across_turns_a_column_between_held_joints() {
    let energies = [&[0.0, 1.0][..], &[0.0, 0.5, 1.0]].map(|parts| {
        let last = parts.len() - 1;
        let solution = solve(&format!(
            "format = 'pennate/1'\ndimension = 'space'\n{}[supports]\nN0 = 'clamped'\nN{last} = 'clamped'\n\
             [sections.s]\nstiffness = {{ EA = 0.5, EI2 = 1, EI3 = 1, GJ = 0.8 }}\n\
             [[steps]]\ndisplacement = {{ N{last} = {{ uy = -1.6 }} }}\n\
             [[steps]]\ndistributed = {{ all = [-2e-6, 0, 0] }}\n",
            line(100.0, parts)
        ));
        for step in &solution.history.steps {
            assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{:?}", step.critical_points);
        }
        end(&solution.history.steps[1]).energy
    });
    assert!((energies[0] / energies[1] - 1.0).abs() < 1e-5, "{energies:?}");
}

/// Round columns that are hinged at their feet, or at both ends, which a load along them bends: the released ends turn as joints do.
#[test]
fn hinged_round_columns_bend_in_some_plane() {
    let euler = (PI / 100.0).powi(2);
    // Over Euler's load; the root of tan x = x for a hinge and a clamp.
    let hinged = (4.493_409_457_9_f64 / PI).powi(2);
    let (foot, head) = ("release = { start = 'pin' }", "release = { end = 'pin' }");
    for (members, critical) in [(&[foot, head][..], 1.0), (&[foot], hinged), (&[foot, ""], hinged)] {
        // A column with one hinge bears 1.1396 times its critical load at most.
        for times in [1.02, if critical == 1.0 { 1.6 } else { 1.1 }] {
            let last = members.len();
            let [space, plane] = ["space", "plane"].map(|dimension| {
                let node = |i: usize| format!("N{i} = [0, {:?}, 0]\n", 100.0 * i as f64 / last as f64);
                let nodes: String = (0..=last).map(node).collect();
                let member = |(i, release): (usize, &&str)| {
                    let comma = if release.is_empty() { "" } else { ", " };
                    format!("m{i} = {{ nodes = ['N{i}', 'N{}'], section = 's'{comma}{release} }}\n", i + 1)
                };
                let members: String = members.iter().enumerate().map(member).collect();
                solve(&format!(
                    "format = 'pennate/1'\ndimension = '{dimension}'\n[nodes]\n{nodes}[members]\n{members}\
                     [sections.s]\nstretch = false\nshear = false\nstiffness = {{ EI2 = 1, EI3 = 1, GJ = 0.8 }}\n\
                     [supports]\nN0 = 'clamped'\nN{last} = ['ux', 'uz', 'rx', 'ry', 'rz']\n\
                     [[steps]]\nforce = {{ N{last} = [0, {}, 0] }}\n",
                    -times * critical * euler
                ))
            });
            assert_buckled(&space.history.steps[0], 1.0 / times, 1e-5);
            let tip = format!("N{last}");
            let [free, held] = [&space, &plane].map(|solution| moved(solution, 0, &tip)[0]);
            assert!((free / held - 1.0).abs() < 1e-5, "{free} instead of {held}: {members:?} {times}");
        }
    }
}

/// A weightless body that stands on a spring alike in all directions leans by θ where P L / k = θ / sin θ, in any plane, and loses no
/// stability by that: followed in its plane, and free to leave it.
#[test]
fn a_body_on_a_spring_leans_in_some_plane() {
    for dimension in ["plane", "space"] {
        for method in ["newton", "arc_length", "jump"] {
            let solution = solve(&format!(
                "format = 'pennate/1'\ndimension = '{dimension}'\n\
                 [nodes]\nP = [0, 0]\nC = [0, 30]\nA = [500, 500]\nB = [510, 500]\n\
                 [sections]\ns = {{ stiffness = {{ EA = 1e8, GJ = 1e8, EI2 = 1e8, EI3 = 1e8 }} }}\n\
                 [members]\nelsewhere = {{ nodes = ['A', 'B'], section = 's' }}\n\
                 [rigid_bodies]\nb = {{ nodes = ['P', 'C'], reference = 'C' }}\n\
                 [supports]\nP = ['ux', 'uy', 'uz']\nA = 'clamped'\n\
                 [springs]\nk = {{ node = 'P', stiffness = {{ rx = 1, ry = 1, rz = 1 }} }}\n\
                 [[steps]]\nforce = {{ C = [0, {:?}] }}\nmethod = '{method}'\n",
                -2.0 / 30.0
            ));
            let step = &solution.history.steps[0];
            assert_buckled(step, 0.5, 1e-8);
            // The root of θ = 2 sin θ.
            let lean = 1.895_494_267_034_f64;
            let [down, aside] = moved(&solution, 0, "C");
            assert!(
                (aside / 30.0 - lean.sin()).abs() < 1e-9 && (down / 30.0 + 1.0 - lean.cos()).abs() < 1e-9,
                "{aside}"
            );
            let says = step.notes.contains(&Note::TurnsFreely { nodes: vec![0, 1], axis: [0.0, 1.0, 0.0] });
            assert_eq!(says, dimension == "space", "{method}");
        }
    }
}

/// Two round columns that nothing joins but the ground bend each in a plane of its own, by as much as one that cannot leave its plane; one
/// of them stands on a spring. A spring that is stiffer in one direction decides about the plane.
#[test]
fn columns_apart_bend_in_planes_of_their_own() {
    let network = |dimension: &str, about_x: f64| {
        format!(
            "format = 'pennate/1'\ndimension = '{dimension}'\n\
             [nodes]\nA = [0, 0]\nB = [0, 100]\nC = [300, 0]\nD = [300, 100]\n\
             [sections]\ns = {{ stiffness = {{ EA = 1e6, GJ = 8e3, EI2 = 1e4, EI3 = 1e4 }} }}\n\
             [members]\none = {{ nodes = ['A', 'B'], section = 's' }}\nother = {{ nodes = ['C', 'D'], section = 's' }}\n\
             [supports]\nA = ['ux', 'uy', 'uz']\nC = 'clamped'\n\
             [springs]\nk = {{ node = 'A', stiffness = {{ rx = {about_x:?}, ry = 200, rz = 200 }} }}\n\
             [[steps]]\nforce = {{ B = [0, -1.4], D = [0, -2.6] }}\n"
        )
    };
    let [space, plane] = ["space", "plane"].map(|dimension| solve(&network(dimension, 200.0)));
    let step = &space.history.steps[0];
    assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{:?}", step.critical_points);
    assert_eq!(step.critical_points.len(), 2);
    for (node, part) in [("B", vec![0, 1]), ("D", vec![2, 3])] {
        let [free, held] = [&space, &plane].map(|solution| moved(solution, 0, node));
        assert!((free[0] / held[0] - 1.0).abs() < 1e-5 && (free[1] / held[1] - 1.0).abs() < 1e-5, "{free:?} {held:?}");
        assert!(step.notes.contains(&Note::TurnsFreely { nodes: part, axis: [0.0, 1.0, 0.0] }), "{:?}", step.notes);
    }
    let stiffer = solve(&network("space", 250.0));
    let step = &stiffer.history.steps[0];
    let says = |note: &Note| matches!(note, Note::TurnsFreely { nodes, .. } if nodes.contains(&0));
    assert!(step.stable == Some(true) && !step.notes.iter().any(says), "{:?}", step.notes);
    let index = stiffer.model.nodes.iter().position(|n| n.name == "B").expect("the head");
    let [x, _, z] = end(step).nodes[index].displacement;
    assert!(x.abs() > 10.0 && z.abs() < 1e-3 * x.abs(), "{x} {z}");
}

/// A round strut whose ends are released, all about or about both axes across it, turns freely about the line between fixed ends, by one
/// motion: resisted twice it would be stiffer. It goes the way of one that cannot leave its plane.
#[test]
fn a_round_strut_between_released_ends_buckles_as_in_the_plane() {
    let network = |dimension: &str, release: &str, step: &str| {
        format!(
            "format = 'pennate/1'\ndimension = '{dimension}'\nnodes = {{ A = [0, 0], B = [100, 0] }}\n\
             materials.m = {{ youngs_modulus = 2000, poissons_ratio = 0.3 }}\nsections.s = {{ circle = {{ radius = 1 }} }}\n\
             members.b = {{ nodes = ['A', 'B'], section = 's', material = 'm', release = {{ start = {release}, end = {release} }} }}\n\
             supports = {{ A = 'clamped', B = ['uy', 'uz', 'rx', 'ry', 'rz'] }}\nsteps = [{step}]\n"
        )
    };
    for step in ["{ force = { B = [-1.86, 0] } }", "{ displacement = { B = { ux = -0.5 } } }"] {
        let plane = solve(&network("plane", "['rz']", step));
        for release in ["'pin'", "['ry', 'rz']", "['rx', 'ry', 'rz']"] {
            let space = solve(&network("space", release, step));
            let found = &space.history.steps[0];
            assert_eq!((found.status, found.stable), (Status::Converged, Some(true)), "{release} {step}");
            assert_eq!(found.critical_points.len(), 1, "{release} {step}");
            let [free, held] = [&space, &plane].map(|solution| moved(solution, 0, "B"));
            assert!((free[1] / held[1] - 1.0).abs() < 1e-5, "{release} {step}: {free:?} {held:?}");
            let [free, held] = [&space, &plane].map(|solution| end(&solution.history.steps[0]).energy);
            assert!((free / held - 1.0).abs() < 1e-5, "{release} {step}: {free} {held}");
        }
    }
}

/// Two legs between pins, or hinges that lie askew, of which the second buckles soon after the first: the elastica of both, and a
/// spring, bear the load.
#[test]
fn legs_that_buckle_one_after_the_other_go_on() {
    for start in ["'pin'", "['ry', 'rz']"] {
        let release = format!("release = {{ start = {start}, end = 'pin' }}");
        let solution = solve(&format!(
            "format = 'pennate/1'\ndimension = 'space'\n\
             nodes = {{ C = [0, 0, 100], P = [40, 0, 0], Q = [-20, 34.64101615137755, 0] }}\n\
             materials.m = {{ youngs_modulus = 2000, poissons_ratio = 0.3 }}\n\
             sections.p = {{ circle = {{ radius = 0.6746166958506707 }}, shear = false, stretch = false }}\n\
             sections.q = {{ circle = {{ radius = 0.6952537918363026 }}, shear = false, stretch = false }}\n\
             members.p = {{ nodes = ['P', 'C'], section = 'p', material = 'm', {release} }}\n\
             members.q = {{ nodes = ['Q', 'C'], section = 'q', material = 'm', {release} }}\n\
             supports = {{ C = ['ux', 'uy', 'rx', 'ry', 'rz'], P = 'clamped', Q = 'clamped' }}\n\
             springs.k = {{ node = 'C', stiffness = {{ uz = 0.04202331385020206 }} }}\n\
             steps = [{{ force = {{ C = [0, 0, -1.406408242897443] }} }}]\n",
        ));
        let step = &solution.history.steps[0];
        assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{start} {:?}", step.critical_points);
        assert!(!step.critical_points.is_empty(), "{start}");
        // N = 4 K(p)² EI / L² in a leg whose chord is L (2 E(p) / K(p) - 1).
        let [_, _, z] = end(step).nodes[0].displacement;
        assert!((z + 19.760_778_702).abs() < 2e-6, "{start} {z}");
    }
}

/// A brace that buckled upwards in the prestress stands there until weight comes: the first part of that swings it to where it hangs
/// down, with no energy released. Drawn bent downwards by a hundred-thousandth of its length, and held aside by a spring of 1e-7 N/mm,
/// it moves B by 7.607922 and -0.5142628 without a jump.
#[test]
fn a_brace_that_buckled_upwards_swings_down_by_a_jump() {
    let solution = solve(include_str!("../cases/brace_buckled_upwards.toml"));
    let step = &solution.history.steps[0];
    assert_eq!((step.status, step.stable), (Status::Converged, Some(true)));
    let [ux, uy, _] = end(step).nodes[1].displacement;
    assert!((ux - 7.607922).abs() < 1e-4 && (uy + 0.5142628).abs() < 1e-5, "{ux} {uy}");
    let [jump] = step.jumps.as_slice() else { panic!("{:?}", step.jumps) };
    assert_eq!(jump.member.map(|member| solution.model.members[member].name.as_str()), Some("brace"));
    assert!(jump.released == 0.0 && jump.moved > 10.0, "{jump:?}");
}
