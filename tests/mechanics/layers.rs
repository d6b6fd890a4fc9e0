//! Boundary layers of taut, slender members: meshes graded into them, and errors that know of them.

use pennate_analysis::accuracy::{Verdict, solve_to_accuracy};
use pennate_analysis::solution::{Solution, last_state};
use pennate_models::{Mesh, read_text};
use pennate_solver::history::Status;
use pennate_solver::options::Options;

/// A strip of 60 mm x 10 mm x 0.1 mm, pulled by 50 N and then turned by 90 degrees at its end: layers of 0.18 mm.
fn strip(member: &str, accuracy: f64) -> Solution {
    solve(
        &format!(
            "nodes = {{ A = [0, 0], B = [60, 0] }}\n\
             materials.m = {{ youngs_modulus = 2000, poissons_ratio = 0.25 }}\n\
             sections.s = {{ rectangle = {{ width = 10, height = 0.1 }} }}\n\
             members.rod = {{ nodes = ['A', 'B'], section = 's', material = 'm'{member} }}\n\
             supports.A = 'clamped'\n\
             steps = [{{ name = 'pull', force = {{ B = [50, 0] }} }}, {{ name = 'turn', rotation = {{ B = [0, 0, 90] }} }}]\n"
        ),
        accuracy,
    )
}

fn solve(text: &str, accuracy: f64) -> Solution {
    let model = read_text("layers.toml", &format!("format = \"pennate/1\"\n{text}"), &[]).expect("a network");
    let options = Options { estimate: true, shapes: true, ..Options::default() };
    solve_to_accuracy(model, accuracy, &options, &mut |_| true).expect("a solution")
}

/// Moment that turns the end, by collocation (validation/20_boundary_layers).
const MOMENT: f64 = 12.747_548_783_982_2;

fn moment(solution: &Solution) -> f64 {
    last_state(solution.history.steps.last().unwrap()).unwrap().nodes[1].reaction_moment[2]
}

#[test]
fn a_taut_strip_takes_a_few_elements_of_growing_length() {
    for (accuracy, most) in [(1e-3, 32), (1e-6, 40), (1e-9, 150)] {
        let solution = strip("", accuracy);
        let error = (moment(&solution) - MOMENT).abs() / MOMENT;
        let stated = solution.accuracy.estimated.expect("an estimate");
        assert!(solution.accuracy.is_met() && error < accuracy, "{accuracy:.0e}: {error:.1e}");
        assert!(error < 3.0 * stated + 1e-10, "{accuracy:.0e}: {error:.1e}, stated {stated:.1e}");
        // Equal elements as short as the first would be more than three hundred.
        assert!(solution.mesh.elements() <= most, "{accuracy:.0e}: {} elements", solution.mesh.elements());
    }
}

/// Points of the shape run from end to end and belong to the one segment that the member has.
#[test]
fn shapes_of_graded_members_are_those_of_their_segments() {
    let solution = strip("", 1e-6);
    assert!(!solution.mesh.grading.is_empty());
    let shape = &solution.history.steps[1].increments.last().unwrap().shapes[0];
    assert_eq!((shape.points[0].reference[0], shape.points.len()), (0.0, shape.cells.len() + 1));
    assert!((shape.points.last().unwrap().reference[0] - 60.0).abs() < 1e-9);
    assert!(shape.cells.iter().all(|cell| cell.segment == 0));
    assert!(shape.points.windows(2).all(|ends| ends[0].reference[0] < ends[1].reference[0]));
    // The moment in the last cell is nearly that at the end, and none is left in the middle.
    let bending = |index: usize| shape.cells[index].moment[1].hypot(shape.cells[index].moment[2]);
    assert!((bending(shape.cells.len() - 1) - MOMENT).abs() < 0.2 * MOMENT);
    assert!(bending(shape.cells.len() / 2) < 1e-4 * MOMENT, "{}", bending(shape.cells.len() / 2));
}

/// Elements of 3 mm that the file forces see nothing of the layer, and nor do those of the next order: what they are
/// compared with has elements short enough.
#[test]
fn elements_that_are_forced_are_judged_by_ones_that_resolve_the_layer() {
    let solution = strip(", elements = 20", 1e-6);
    assert_eq!(solution.status(), Status::Converged);
    assert_eq!(solution.accuracy.verdict, Verdict::Forced);
    let error = (moment(&solution) - MOMENT).abs();
    let refined = solution.history.steps[1].refined.as_ref().expect("an estimate");
    let stated = (moment(&solution) - refined.nodes[1].reaction_moment[2]).abs();
    assert!(error > 0.05 * MOMENT, "{error:.1e}");
    assert!((stated / error - 1.0).abs() < 1e-4, "{stated:.3e} stated of {error:.3e}");
    assert!(solution.accuracy.estimated.unwrap() > 0.05);
}

/// What corotational elements lack that the file forces, no finer ones of the member beside them make up for: the search ends there, with
/// the error that is left, however small the one asked for.
#[test]
fn members_beside_elements_that_are_forced_do_not_grow_without_end() {
    for accuracy in [1e-6, 1e-10] {
        let solution = solve(
            "nodes = { A = [0, 0], B = [60, 0], C = [100, 30] }
             materials.m = { youngs_modulus = 2000, poissons_ratio = 0.3 }
             sections.s = { circle = { radius = 2 } }
             members.forced = { nodes = ['A', 'B'], section = 's', material = 'm', formulation = 'corotational', elements = 8 }
             members.free = { nodes = ['B', 'C'], section = 's', material = 'm' }
             supports.A = 'clamped'
             steps = [{ name = 'bend', force = { C = [-3, 20] } }]",
            accuracy,
        );
        assert_eq!(solution.accuracy.verdict, Verdict::Forced);
        assert!(
            solution.accuracy.estimated.is_some_and(|error| error > 1e-5 && error < 1e-2),
            "{:?}",
            solution.accuracy
        );
        assert!(solution.mesh.elements() < 100, "{accuracy:e}: {} elements", solution.mesh.elements());
    }
}

/// Where there is no layer, nothing is graded: the mesh to begin with will do.
#[test]
fn a_short_stiff_rod_keeps_its_mesh() {
    let solution = solve(
        "nodes = { A = [0, 0], B = [60, 0] }
         materials.m = { youngs_modulus = 2000, poissons_ratio = 0.3 }
         sections.s = { circle = { radius = 2 } }
         members.rod = { nodes = ['A', 'B'], section = 's', material = 'm' }
         supports.A = 'clamped'
         steps = [{ name = 'bend', force = { B = [50, 5] } }]",
        1e-6,
    );
    assert!(solution.mesh.grading.is_empty());
    assert_eq!((solution.accuracy.rounds, &solution.mesh), (1, &Mesh::initial(&solution.model, 1e-6)));
}

/// A metre of nylon, straight between its pins, under its own weight: twenty thousand times its radius of gyration, so that the first
/// increment turns its ends by many turns.
#[test]
fn a_straight_thread_hangs_by_its_ends() {
    let (length, area, weight): (f64, f64, f64) = (1000.0, 0.01 * std::f64::consts::PI, 1.1e-9 * 9810.0);
    let solution = solve(
        "nodes = { A = [0, 0], B = [1000, 0] }
         materials.nylon = { youngs_modulus = 2500, poissons_ratio = 0.35, density = 1.1e-9 }
         sections.thread = { circle = { radius = 0.1 } }
         members.thread = { nodes = ['A', 'B'], section = 'thread', material = 'nylon' }
         supports = { A = 'pinned', B = 'pinned' }
         steps = [{ name = 'hang', gravity = [0, -9810, 0] }]",
        1e-6,
    );
    assert!(solution.accuracy.is_met());
    let step = &solution.history.steps[0];
    assert_eq!((step.status, step.stable), (Status::Converged, Some(true)));
    assert!(step.critical_points.is_empty());
    // The elastic catenary, whose span is H S/EA + 2 H/w asinh(w S/2 H); bending takes less than a thousandth of the pull.
    let line = weight * area;
    let span = |pull: f64| pull * length / (2500.0 * area) + 2.0 * pull / line * (0.5 * line * length / pull).asinh();
    let (mut low, mut high) = (1e-4, 1e-1);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if span(middle) < length { &mut low } else { &mut high }) = middle;
    }
    let pull = last_state(step).expect("a state").nodes[1].reaction_force[0];
    assert!((pull / low - 1.0).abs() < 1e-3, "{pull} against {low}");
}

/// Half a millimetre of nylon between a muscle and its lever.
#[test]
fn a_thread_between_muscle_and_lever_is_resolved() {
    let solution = solve(
        "nodes = { A = [0, 0], B = [130, 0], C = [150, 0], D = [150, -30] }
         materials.nylon = { youngs_modulus = 2000, poissons_ratio = 0.4 }
         materials.steel = { youngs_modulus = 200000, poissons_ratio = 0.3 }
         sections.thread = { circle = { radius = 0.05 } }
         sections.bar = { circle = { radius = 2 } }
         supports = { A = 'clamped', D = ['ux', 'uy', 'uz', 'rx', 'ry'] }
         springs.k = { node = 'D', stiffness = { rz = 500 } }
         [muscles.silicone]
         diameter = 13
         wall = 2.0
         pressure_unit = 'psi'
         table = [
           { pressure = 10, E = 3.60, alpha = -9.135e-3, R1 = 6.80, R2 = 7.90 },
           { pressure = 25, E = 4.25, alpha = -6.885e-3, R1 = 7.15, R2 = 8.90 },
         ]
         [members]
         muscle = { nodes = ['A', 'B'], muscle = 'silicone' }
         thread = { nodes = ['B', 'C'], section = 'thread', material = 'nylon' }
         lever = { nodes = ['C', 'D'], section = 'bar', material = 'steel' }
         [[steps]]
         name = 'inflate'
         pressure = { muscle = 25 }",
        1e-6,
    );
    assert!(solution.accuracy.is_met());
    // Three dozen elements more than the thread needs would do too; equal ones take 60 and more.
    assert!(solution.mesh.elements() < 40, "{}", solution.mesh.elements());
    let state = last_state(&solution.history.steps[0]).unwrap();
    let turned = state.nodes[3].rotation_total.to_degrees();
    assert!((turned - 17.780_64).abs() < 1e-4, "{turned}");
}

/// Two bars that cannot be stretched, turned about the line between their ball joints as one body, have no force: what rounding leaves of
/// the auxiliary stiffness was to be known to 1e-6 of itself, on 101,632 elements.
#[test]
fn members_without_forces_are_not_meshed_for_their_rounding() {
    let solution = solve(
        "nodes = { A = [94.54314134087437, -32.58211818466459, 0.6053957495215128],\
         B = [-84.2001125189498, -53.94757688530778, -8.494672216716943],\
         C = [44.2343906057933, -7.746202669096636, 32.898422631767495] }\n\
         sections.s = { stiffness = { EA = 31320, GJ = 30024, EI2 = 390323, EI3 = 39032 }, stretch = false }\n\
         members.a = { nodes = ['A', 'C'], section = 's' }\n\
         members.b = { nodes = ['B', 'C'], section = 's' }\n\
         supports = { A = ['ux', 'uy', 'uz'], B = ['ux', 'uy', 'uz'] }\n\
         steps = [{ displacement = { C = { uy = 7.533329427174061 } } }]\n",
        1e-6,
    );
    assert!(solution.accuracy.is_met(), "{:?}", solution.accuracy);
    assert!(solution.mesh.elements() <= 32, "{} elements", solution.mesh.elements());
}
