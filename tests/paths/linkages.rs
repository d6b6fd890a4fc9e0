//! Linkages that are turned through poses where their bars come into one line, and two ways go on.

use pennate_analysis::accuracy::solve_to_accuracy;
use pennate_analysis::solution::Solution;
use pennate_solver::history::{Note, Status};
use pennate_solver::options::Options;
use pennate_testing::network::model;

/// A crank AB of 40 and a rocker DC with a coupler BC between them, AD = `ground`, that stands at 60 degrees; its crank is turned by so
/// many degrees. `c` is where C is at first.
fn turned(ground: f64, c: [f64; 2], angle: f64, method: &str) -> Solution {
    let b = at_sixty();
    let text = format!(
        "format = 'pennate/1'\n[nodes]\nA = [0, 0]\nB = {b:?}\nC = {c:?}\nD = [{ground:?}, 0]\n\
         [sections]\ns = {{ stiffness = {{ EA = 1e6, EI3 = 1e6, EI2 = 1e6, GJ = 1e6 }} }}\n\
         [members]\ncrank = {{ nodes = ['A', 'B'], section = 's' }}\nrocker = {{ nodes = ['D', 'C'], section = 's' }}\n\
         coupler = {{ nodes = ['B', 'C'], section = 's', \
         release = {{ start = {{ hinge = [0, 0, 1] }}, end = {{ hinge = [0, 0, 1] }} }} }}\n\
         [supports]\nA = 'clamped'\nD = ['ux', 'uy', 'uz', 'rx', 'ry']\n\
         [[steps]]\nmethod = '{method}'\nrotation.A = [0, 0, {angle:?}]\n"
    );
    let options = Options { estimate: true, ..Options::default() };
    let solution =
        solve_to_accuracy(model(&text), 1e-6, &options, &mut |_| true).unwrap_or_else(|(_, error)| panic!("{error}"));
    assert_eq!(solution.history.steps[0].status, Status::Converged);
    solution
}

fn at_sixty() -> [f64; 2] {
    [20.0, 40.0 * 60.0_f64.to_radians().sin()]
}

/// Fractions at which a singular state was touched.
fn touched(solution: &Solution) -> Vec<f64> {
    let fraction = |note: &Note| match note {
        Note::TouchedSingular { fraction } => Some(*fraction),
        _ => None,
    };
    solution.history.steps[0].notes.iter().filter_map(fraction).collect()
}

/// Where circles about two centres meet that is farther up.
fn upper_meeting([a, b]: [[f64; 2]; 2], [of_a, of_b]: [f64; 2]) -> [f64; 2] {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let apart = dx.hypot(dy);
    let along = (of_a * of_a - of_b * of_b + apart * apart) / (2.0 * apart);
    let aside = (of_a * of_a - along * along).sqrt();
    let foot = [a[0] + along * dx / apart, a[1] + along * dy / apart];
    let meetings = [1.0, -1.0].map(|s| [foot[0] - s * aside * dy / apart, foot[1] + s * aside * dx / apart]);
    if meetings[0][1] > meetings[1][1] { meetings[0] } else { meetings[1] }
}

/// A parallelogram and a kite whose bars come into one line go on, and it is said that another way goes on there: in each of these poses, and
/// nowhere else.
#[test]
fn a_change_point_is_not_passed_without_a_word() {
    let parallelogram = [120.0, at_sixty()[1]];
    // Bars of 40 and 40, of 90 and 90.
    let kite = upper_meeting([at_sixty(), [90.0, 0.0]], [40.0, 90.0]);
    for (ground, c, angle, method, places) in [
        (100.0, parallelogram, 180.0, "newton", &[120.0][..]),
        (100.0, parallelogram, 720.0, "newton", &[120.0, 300.0, 480.0, 660.0]),
        (90.0, kite, 180.0, "newton", &[120.0]),
        (90.0, kite, 180.0, "arc_length", &[120.0]),
        // A crank and rocker of 40, 100, 80 and 90 never has all of its bars in one line.
        (90.0, upper_meeting([at_sixty(), [90.0, 0.0]], [100.0, 80.0]), 360.0, "newton", &[]),
    ] {
        let found = touched(&turned(ground, c, angle, method));
        assert_eq!(found.len(), places.len(), "{found:?} for {places:?}");
        for (found, place) in found.iter().zip(places) {
            assert!((found - place / angle).abs() < 1e-5, "{found} for {place} of {angle} degrees");
        }
    }
}

/// A parallelogram whose coupler is longer by any small part cannot come through the line as a parallelogram: it turns over, as it does in
/// small increments.
#[test]
fn a_linkage_that_misses_the_line_keeps_to_its_way() {
    for part in [1e-3, 1e-5, 1e-7] {
        for method in ["newton", "arc_length"] {
            let b = at_sixty();
            let c = [120.0 * (1.0 + part), b[1]];
            let solution = turned(100.0, c, 180.0, method);
            let turned_over = upper_meeting([[-b[0], -b[1]], [100.0, 0.0]], [c[0] - b[0], (c[0] - 100.0).hypot(c[1])]);
            let index = solution.model.nodes.iter().position(|node| node.name == "C").expect("the node");
            let moved = solution.history.steps[0].increments.last().expect("a state").state.nodes[index].displacement;
            for i in 0..2 {
                let place = c[i] + moved[i];
                assert!((place - turned_over[i]).abs() < 1e-6, "{part:e} by {method}: {place} for {turned_over:?}");
            }
            assert!(touched(&solution).is_empty(), "{:?}", touched(&solution));
        }
    }
}
