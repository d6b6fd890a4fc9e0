//! Where the stability of plane networks is judged, and what holds them out of their plane.

mod network;

use network::{attempt, solve};
use pennate_solver::history::{Note, Status};
use pennate_solver::structure::Dimension;

const FRAME: &str = r#"
    format = "pennate/1"
    nodes = { A = [0, 0], B = [0, 100], C = [80, 100], D = [80, 0] }
    materials.m = { youngs_modulus = 2000, poissons_ratio = 0.3 }
    sections.s = { rectangle = { width = 10, height = 5 } }
    supports = { A = "clamped", D = "pinned" }
    [members]
    a = { nodes = ["A", "B"], section = "s", material = "m" }
    b = { nodes = ["B", "C"], section = "s", material = "m" }
    c = { nodes = ["C", "D"], section = "s", material = "m" }
"#;

/// A dead moment about z has a potential for rotations in the plane alone: there it is judged, and no longer once it is gone.
#[test]
fn a_moment_on_a_joint_of_a_plane_frame_leaves_the_verdict_in_the_plane() {
    let steps = "
        [[steps]]
        moment = { B = [0, 0, 1000] }
        [[steps]]
        force = { B = [1, -5] }
        [[steps]]
        moment = { B = [0, 0, 0] }
    ";
    let solved = solve(&format!("{FRAME}{steps}"));
    let verdicts: Vec<_> = solved.history.steps.iter().map(|step| (step.stable, step.stability)).collect();
    assert_eq!(
        verdicts,
        [(Some(true), Dimension::Plane), (Some(true), Dimension::Plane), (Some(true), Dimension::Space)]
    );
    let noted = solved.history.steps.iter().map(|step| step.notes.contains(&Note::NoPotentialOutOfPlane));
    assert_eq!(noted.collect::<Vec<_>>(), [true, true, false]);
}

/// The verdict in the plane is one: the frame that a moment bends buckles under the load that it buckles under in the plane.
#[test]
fn a_frame_under_a_moment_is_found_unstable_in_the_plane() {
    let text = |dimension: &str| {
        let steps = "
            [[steps]]
            moment = { B = [0, 0, 50] }
            [[steps]]
            force = { B = [0, -700], C = [0, -700] }
            branch = \"primary\"
        ";
        format!("{dimension}{FRAME}{steps}").replace("rectangle = { width = 10", "rectangle = { width = 30")
    };
    let [open, plane] = [text(""), text("dimension = \"plane\"\n")].map(|text| attempt(&text).expect("no mechanism"));
    for (open, plane) in open.history.steps.iter().zip(&plane.history.steps) {
        assert_eq!((open.stable, open.negative_pivots), (plane.stable, plane.negative_pivots));
        assert_eq!(open.critical_points.len(), plane.critical_points.len());
    }
    assert_eq!(open.history.steps[1].stable, Some(false));
}

/// A follower load has no potential anywhere: no verdict.
#[test]
fn a_follower_load_leaves_no_verdict() {
    let solved = solve(&format!("{FRAME}[[steps]]\nfollower_force = {{ B = [0, -1] }}\n"));
    assert_eq!(solved.history.steps[0].stable, None);
}
