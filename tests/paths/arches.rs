//! Arches, which lean and snap, and their ways back.

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_analysis::solution::Solution;
use pennate_models::read_text;
use pennate_solver::history::{Cause, CriticalKind, Status, StepHistory};
use pennate_solver::options::Options;

use super::critical_points::{assert_load, solve, solve_text};

/// An arch of one member between clamped nodes has no joint that moves, and snaps all the same: as one with a node in its crown.
#[test]
fn an_arch_without_a_joint_that_moves_snaps_like_one_with_a_node_in_its_crown() {
    let network = |node: &str, members: &str, method: &str| {
        let text = format!(
            "format = \"pennate/1\"\ndimension = \"plane\"\nnodes = {{ A = [0, 0], B = [100, 0]{node} }}
            sections.s = {{ stiffness = {{ EA = 4e5, EI3 = 1e3 }} }}
            supports = {{ A = \"clamped\", B = \"clamped\" }}\n{members}
            [[steps]]\nmethod = \"{method}\"\ndistributed = {{ all = [0.002, -0.15] }}\n"
        );
        let model = pennate_models::read_text("arch.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
        let options = Options { estimate: true, ..Options::default() };
        solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}"))
    };
    let one = "members.a = { nodes = [\"A\", \"B\"], section = \"s\", arc = [50, 4] }";
    // The circle through A, M and B: a quarter of it from A.
    let radius = (50.0f64.powi(2) + 16.0) / 8.0;
    let part = 0.5 * (50.0 / radius).asin();
    let [x, y] = [50.0 - radius * part.sin(), radius * (part.cos() - 1.0) + 4.0];
    let half = |name: &str, ends: &str, x: f64| {
        format!("members.{name} = {{ nodes = [{ends}], section = \"s\", arc = [{x}, {y}] }}\n")
    };
    let two = half("a", "\"A\", \"M\"", x) + &half("b", "\"M\", \"B\"", 100.0 - x);
    for method in ["newton", "jump", "arc_length"] {
        let (one, two) = (network("", one, method), network(", M = [50, 4]", &two, method));
        let (a, b) = (&one.history.steps[0], &two.history.steps[0]);
        assert_eq!((a.status, a.stable), (b.status, b.stable), "{method}");
        assert_eq!(a.critical_points.len(), b.critical_points.len(), "{method}");
        for (a, b) in a.critical_points.iter().zip(&b.critical_points) {
            assert_eq!((a.kind, a.member), (b.kind, Some(0)), "{method}");
            assert_load(a.fraction, b.fraction);
        }
        if a.status == Status::Converged {
            let reaction = |step: &StepHistory| step.increments.last().expect("a state").state.nodes[0].reaction_force;
            let (a, b) = (reaction(a), reaction(b));
            assert!((0..2).all(|c| (a[c] - b[c]).abs() < 1e-5 * b[0].abs()), "{method}: {a:?} {b:?}");
        }
    }
}

/// A shallow clamped arch, pushed down by its crown and let up again: it leans aside between two points of its straight path.
const ARCH: &str = r#"
    format = "pennate/1"
    nodes = { A = [-50, 0], M = [0, 8], B = [50, 0] }
    materials.abs = { youngs_modulus = 2200, poissons_ratio = 0.3 }
    sections.strip = { rectangle = { width = 10, height = 1 } }
    supports = { A = "clamped", B = "clamped" }
    [members]
    left  = { nodes = ["A", "M"], section = "strip", material = "abs", arc = [-25, 6.037910151091438] }
    right = { nodes = ["M", "B"], section = "strip", material = "abs", arc = [25, 6.037910151091438] }
    [probes]
    force = { node = "M", reaction = "uy" }
    turn = { node = "M", rotation = "rz" }
"#;

fn arch(steps: &str) -> Solution {
    let text = format!("{ARCH}{steps}");
    let model = pennate_models::read_text("arch.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
    let options = Options { estimate: true, ..Options::default() };
    solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}"))
}

/// Arches whose crown is pushed down by so much lean to a side, in space as in the plane, whichever way their halves are
/// drawn: a mesh that is not the same from either end of an element would bend the path to the leaning branch.
#[test]
fn arches_in_space_lean_at_the_bifurcation_that_they_have_in_the_plane() {
    let hinged = "[\"ux\", \"uy\", \"uz\", \"rx\", \"ry\"]";
    for (radius, side, rise, down, support) in
        [(65.72, 28.43, 27.06, 17.8, hinged), (50.0, 20.0, 20.0, 14.0, hinged), (109.0, 27.3, 12.1, 9.0, "\"clamped\"")]
    {
        let height = |x: f64| rise - radius + f64::sqrt(radius * radius - x * x);
        let end = f64::sqrt(radius * radius - (radius - rise).powi(2));
        let text = |dimension: &str, halves: [&str; 2]| {
            let way = |x: f64| format!("[{x}, {}]", height(x));
            format!(
                "format = \"pennate/1\"\ndimension = \"{dimension}\"\n\
                 [sections.s]\nstiffness = {{ EA = 8000, EI2 = 5, EI3 = 1, GJ = 0.8 }}\n\
                 [nodes]\nA = [{}, 0]\nB = [{end}, 0]\nC = [0, {rise}]\n\
                 [members]\n1 = {{ nodes = [{}], section = \"s\", arc = {} }}\n\
                 2 = {{ nodes = [{}], section = \"s\", arc = {} }}\n\
                 [supports]\nA = {support}\nB = {support}\n[[steps]]\ndisplacement = {{ C = {{ uy = {} }} }}\n",
                -end,
                halves[0],
                way(-side),
                halves[1],
                way(side),
                -down,
            )
        };
        let run = |dimension: &str, halves: [&str; 2]| {
            let text = text(dimension, halves);
            let model = read_text("arch.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors:?}"));
            let options = Options { estimate: true, ..Options::default() };
            let solution =
                solve_to_accuracy(model, 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, e)| panic!("{e}"));
            let step = &solution.history.steps[0];
            assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{dimension} {halves:?}");
            step.critical_points.iter().map(|point| (point.kind, point.fraction)).collect::<Vec<_>>()
        };
        let plane = run("plane", ["\"A\", \"C\"", "\"C\", \"B\""]);
        assert_eq!(plane.len(), 1, "{plane:?}");
        for halves in [["\"A\", \"C\"", "\"C\", \"B\""], ["\"A\", \"C\"", "\"B\", \"C\""]] {
            let space = run("space", halves);
            assert_eq!(space.len(), 1, "{space:?}");
            assert_eq!((plane[0].0, space[0].0), (CriticalKind::Bifurcation, CriticalKind::Bifurcation));
            assert_load(space[0].1, plane[0].1);
        }
    }
}

/// A mesh that is refined for the leaning state of an arch is not symmetric, and meets no bifurcation: that of the mesh before it is
/// listed all the same, without an error, and the accuracy is not met.
#[test]
fn a_point_that_a_finer_mesh_does_not_meet_is_kept() {
    let text = "format = \"pennate/1\"\ndimension = \"plane\"\n\
        [sections.s]\nstiffness = { EA = 0.38007009, EI3 = 1 }\n\
        [nodes]\nA = [-50, 0]\nB = [50, 0]\nC = [0, 49]\n\
        [members]\nl = { nodes = [\"A\", \"C\"], section = \"s\", arc = [-35.00357124637428, 34.7077257616064] }\n\
        r = { nodes = [\"C\", \"B\"], section = \"s\", arc = [35.00357124637428, 34.7077257616064] }\n\
        [supports]\nA = \"pinned\"\nB = \"pinned\"\n[[steps]]\ndisplacement = { C = { uy = -22.9494 } }\n";
    for accuracy in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8] {
        let solution = solve_text(text, accuracy);
        let step = &solution.history.steps[0];
        assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{accuracy}");
        let [point] = step.critical_points.as_slice() else { panic!("{accuracy}: {:?}", step.critical_points.len()) };
        assert_eq!(point.kind, CriticalKind::Bifurcation);
        // On the meshes that these accuracies need it lies within 2e-4 of where the finest has it.
        assert!((point.fraction - 0.436_741_26).abs() < 2e-4, "{accuracy}: {}", point.fraction);
        assert!(point.error.is_some() || !solution.accuracy.is_met(), "{accuracy}");
    }
}

/// Two bars as a V, `h` high, whose middle at `x` is pushed down by `by` and let back, with as many increments for each step.
fn pushed_and_let_back((h, x): (f64, f64), (stiffness, by): (f64, f64), increments: usize) -> Solution {
    let step = |to: f64| format!("[[steps]]\nincrements = {increments}\ndisplacement = {{ M = {{ uy = {to} }} }}\n");
    let text = format!(
        "format = \"pennate/1\"\ndimension = \"plane\"\n[sections.s]\nstiffness = {{ EA = {stiffness}, EI3 = 1 }}\n\
         [nodes]\nA = [-50, 0]\nM = [{x}, {h}]\nB = [50, 0]\n\
         [members]\nl = {{ nodes = [\"A\", \"M\"], section = \"s\" }}\nr = {{ nodes = [\"M\", \"B\"], section = \"s\" }}\n\
         [supports]\nA = \"pinned\"\nB = \"pinned\"\n{}{}",
        step(by),
        step(0.0)
    );
    solve_text(&text, 1e-6)
}

/// On the way back a leaning branch ends where it began on the way there, whatever the increments: at the same place of the ramp, seen
/// from its other end. A network that is nearly symmetric has no such place on its way.
#[test]
fn the_way_back_lists_where_a_leaning_branch_ends() {
    let nets = [(8.106_386_75, 23.905_871_05, -6.055_898_47), (7.905_168_92, 730.959_027_68, -2.821_107_19)];
    for (h, stiffness, by) in nets {
        for increments in [1, 7, 60] {
            let solution = pushed_and_let_back((h, 0.0), (stiffness, by), increments);
            let [there, back] = &solution.history.steps[..] else { panic!("two steps") };
            let one = |step: &StepHistory| {
                assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{h} {increments}");
                let [point] = step.critical_points.as_slice() else { panic!("{h} {increments}: not one point") };
                assert_eq!((point.kind, point.sideways), (CriticalKind::Bifurcation, false));
                (point.fraction, point.error.expect("an error"))
            };
            let ((first, doubt), (last, other)) = (one(there), one(back));
            let apart = (first + last - 1.0).abs();
            assert!(apart <= doubt + other && apart < 1e-7, "{h} {increments}: {first} {last}, {doubt:e} {other:e}");
        }
    }
    let imperfect = pushed_and_let_back((nets[0].0, 0.1), (nets[0].1, nets[0].2), 1);
    for step in &imperfect.history.steps {
        assert_eq!((step.status, step.critical_points.len()), (Status::Converged, 0));
    }
}

/// Where the branch that leans aside comes back to the straight one the arc goes on along that, both ways and from any
/// number of increments, to the state that the ramp of displacements leads to.
#[test]
fn the_arc_of_a_shallow_arch_goes_on_where_its_leaning_branch_ends() {
    let ramp = |method: &str, increments: usize| {
        let step = |by: i32| {
            format!(
                "[[steps]]\nmethod = \"{method}\"\nincrements = {increments}\ndisplace_by = {{ M = {{ uy = {by} }} }}\n"
            )
        };
        arch(&format!("{}{}", step(-16), step(16)))
    };
    let direct = ramp("newton", 1);
    for (method, increments) in
        [("arc_length", 1), ("arc_length", 3), ("arc_length", 40), ("arc_length", 200), ("jump", 1), ("jump", 15)]
    {
        let solution = ramp(method, increments);
        for (index, step) in solution.history.steps.iter().enumerate() {
            assert_eq!((step.status, step.stable), (Status::Converged, Some(true)), "{method} {increments}");
            let kinds: Vec<_> = step.critical_points.iter().map(|point| point.kind).collect();
            assert_eq!(kinds, [CriticalKind::Bifurcation; 2], "{method} {increments}");
            for (point, expected) in step.critical_points.iter().zip(&direct.history.steps[index].critical_points) {
                assert_load(point.fraction, expected.fraction);
            }
            let probes = |solution: &Solution| solution.probes.steps[index].last().expect("a state").to_vec();
            for (found, expected) in probes(&solution).iter().zip(probes(&direct)) {
                assert!((found - expected).abs() < 1e-5, "{method} {increments}: {found} {expected}");
            }
            // It did lean aside on the way.
            let leant = step.increments.iter().map(|increment| increment.state.nodes[1].rotation_total.abs());
            assert!(leant.fold(0.0, f64::max) > 0.05);
        }
    }
}

/// Under a force the same arch goes through both limit points, and through both ends of the branch that leans aside.
#[test]
fn the_arc_of_a_shallow_arch_under_a_force_goes_through_its_limit_points_both_ways() {
    for increments in [1, 30] {
        let step = |force: f64| {
            format!("[[steps]]\nmethod = \"arc_length\"\nincrements = {increments}\nforce = {{ M = [0, {force}] }}\n")
        };
        let solution = arch(&format!("{}{}", step(-20.0), step(20.0)));
        for step in &solution.history.steps {
            assert_eq!((step.status, step.stable), (Status::Converged, Some(true)));
            let kinds: Vec<_> = step.critical_points.iter().map(|point| point.kind).collect();
            use CriticalKind::{Bifurcation, LimitPoint};
            assert_eq!(kinds, [LimitPoint, Bifurcation, Bifurcation, LimitPoint]);
        }
    }
}

/// A path that comes through one of its limit points again is a loop: no further round is made.
#[test]
fn a_path_that_closes_to_a_loop_is_left_after_one_round() {
    let step = &solve("../tests/cases/toggles_in_a_loop.toml", &[]).history.steps[0];
    let cause = step.failure.as_ref().map(|failure| failure.cause);
    assert_eq!((step.status, cause), (Status::NotConverged, Some(Cause::Endless)));
    assert!(step.increments.len() < 2000, "{}", step.increments.len());
}
