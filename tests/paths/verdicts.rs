//! Where the stability of plane networks is judged, and what holds them out of their plane.

use pennate_solver::history::{Note, Status};
use pennate_solver::structure::Dimension;
use pennate_testing::network::{assert_near, attempt, solve};

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

/// That verdict is the one of the same network where the file asks for the plane alone.
#[test]
fn a_frame_under_a_moment_is_judged_as_in_the_plane_alone() {
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
}

/// A follower load has no potential anywhere: no verdict.
#[test]
fn a_follower_load_leaves_no_verdict() {
    let solved = solve(&format!("{FRAME}[[steps]]\nfollower_force = {{ B = [0, -1] }}\n"));
    assert_eq!(solved.history.steps[0].stable, None);
}

/// A column along x between two supports, twice as stiff in the plane as out of it, under `times` Euler's load of pinned ends
/// about its soft axis; its verdict out of the plane.
fn column(supports: &str, times: f64) -> (Status, bool) {
    // EI2 = 1, L = 10.
    let load = times * std::f64::consts::PI.powi(2) / 100.0;
    let text = format!(
        "format = \"pennate/1\"\nnodes = {{ A = [0, 0], B = [10, 0] }}\n\
         sections.s = {{ stiffness = {{ EA = 1e4, GJ = 1, EI2 = 1, EI3 = 20 }} }}\n\
         members.m = {{ nodes = [\"A\", \"B\"], section = \"s\" }}\nsupports = {{ {supports} }}\n\
         [[steps]]\nforce = {{ B = [-{load}, 0] }}\n"
    );
    let solved = attempt(&text).expect("no mechanism");
    let step = &solved.history.steps[0];
    (step.status, step.critical_points.iter().any(|point| point.sideways))
}

/// Out of the plane a pin about z is a clamp, which holds four times the load of one that may turn about y, and a mirror plane
/// x = 0 holds ry and lets rx be.
#[test]
fn supports_hold_out_of_the_plane_what_they_stand_for() {
    let (holds, buckles) = ((Status::Converged, false), (Status::Bifurcation, true));
    let pin = "A = \"pinned\", B = { fix = [\"uy\", \"ry\", \"rx\"] }";
    assert_eq!(column(pin, 3.9), holds);
    assert_eq!(column(pin, 4.1), buckles);
    // Held about its axis alone at both ends.
    let free = "A = [\"ux\", \"uy\", \"rx\"], B = [\"uy\", \"rx\"]";
    assert_eq!(column(free, 0.97), holds);
    assert_eq!(column(free, 1.03), buckles);
    // rz alone holds rx and ry as well; with rx it holds no more than that.
    assert_eq!(column("A = [\"ux\", \"uy\", \"rz\"], B = [\"uy\", \"rz\"]", 3.9), holds);
    let mirror = "A = [\"ux\", \"uy\", \"rx\", \"rz\"], B = [\"uy\", \"rx\", \"rz\"]";
    assert_eq!(column(mirror, 0.97), holds);
    assert_eq!(column(mirror, 1.03), buckles);
}

/// Two dyads with a bar on top that pins let turn about the line of their feet: no force holds it there, and no mesh finds in
/// the rounding of what the pins take away that one does.
#[test]
fn a_network_that_turns_about_its_feet_is_judged_in_its_plane_on_any_mesh() {
    for elements in [1, 2, 4, 8, 12, 24, 48] {
        let member = |from: &str, to: &str| {
            format!(
                "{{ nodes = [\"{from}\", \"{to}\"], muscle = \"m\", release = {{ start = \"pin\", end = \"pin\" }}, \
                 elements = {elements} }}"
            )
        };
        let text = format!(
            "format = \"pennate/1\"\nmuscles.m = {{ library = \"silicone\" }}\nrigid_bodies.bar = {{ nodes = [\"D\", \"E\"] }}\n\
             nodes = {{ A = [-90, 0], B = [90, 0], C = [0, 90], D = [-90, 180], E = [90, 180] }}\n\
             supports = {{ A = \"pinned\", B = \"pinned\", D = [\"ux\", \"rz\"] }}\n\
             members.a = {}\nmembers.b = {}\nmembers.c = {}\nmembers.d = {}\n[[steps]]\npressure.all = 10\n",
            member("A", "C"),
            member("B", "C"),
            member("D", "C"),
            member("E", "C"),
        );
        let step = &solve(&text).history.steps[0];
        assert_eq!((step.stable, step.stability), (Some(true), Dimension::Plane), "{elements} elements");
    }
}

/// A post whose halves are both pinned where they meet in line gives way there: what pins leave of its stiffness is rounding, on
/// any mesh.
#[test]
fn a_post_hinged_in_its_middle_is_a_mechanism_on_any_mesh() {
    for elements in [1, 3, 8, 24, 64] {
        let text = format!(
            "format = \"pennate/1\"\nsections.s = {{ stiffness = {{ EA = 1e6, EI3 = 2e4 }} }}\n\
             nodes = {{ A = [0, 0], B = [0, 50], C = [0, 100], D = [80, 100], E = [80, 0] }}\n\
             supports = {{ A = \"clamped\", E = \"clamped\" }}\n[members]\n\
             a = {{ nodes = [\"A\", \"B\"], section = \"s\", elements = {elements}, release = {{ start = \"pin\" }} }}\n\
             b = {{ nodes = [\"B\", \"C\"], section = \"s\", elements = {elements}, \
             release = {{ start = \"pin\", end = \"pin\" }} }}\n\
             c = {{ nodes = [\"C\", \"D\"], section = \"s\", elements = {elements} }}\n\
             d = {{ nodes = [\"D\", \"E\"], section = \"s\", elements = {elements}, release = {{ end = \"pin\" }} }}\n\
             [[steps]]\nforce.D = [1, 0]\n"
        );
        assert!(attempt(&text).is_err(), "{elements} elements");
    }
}

/// A cantilever under `load` along its axis, followed straight on; in the plane, or in space with a section that is or is not as
/// stiff about one axis as about the other, and that can be sheared or not.
fn pushed(dimension: &str, second: f64, shear: &str, load: f64) -> (Option<bool>, bool) {
    let text = format!(
        "format = \"pennate/1\"\ndimension = \"{dimension}\"\nnodes = {{ A = [0, 0], B = [10, 0] }}\n\
         sections.s = {{ stiffness = {{ EA = 1e4, {shear}GJ = 1, EI2 = {second}, EI3 = 1 }} }}\n\
         members.m = {{ nodes = [\"A\", \"B\"], section = \"s\" }}\nsupports = {{ A = \"clamped\" }}\n\
         [[steps]]\nforce = {{ B = [-{load:e}, 0, 0] }}\nbranch = \"primary\"\n"
    );
    let solved = solve(&text);
    let step = &solved.history.steps[0];
    (step.stable, step.notes.contains(&Note::WithinRounding))
}

/// The load between these two where a condition that holds at the first of them ends.
fn edge(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    low
}

/// As near to a critical load as rounding can tell there is no verdict, and that is said; next to it there is one.
///
/// The large stiffness in place of one that is infinite, against shear, costs digits.
#[test]
fn within_rounding_of_a_critical_load_there_is_no_verdict() {
    let euler = std::f64::consts::PI.powi(2) / 400.0;
    let soft = "GA2 = 1e3, GA3 = 1e3, ";
    let cases = [("plane", 20.0, soft, 1e-9), ("space", 20.0, soft, 1e-9), ("space", 1.0, soft, 1e-9)];
    for (dimension, second, shear, wide) in cases.into_iter().chain([("plane", 1.0, "", 1e-6)]) {
        let verdict = |load: f64| pushed(dimension, second, shear, load);
        let stable = edge(0.99 * euler, 1.01 * euler, |load| verdict(load).0 == Some(true));
        let unstable = edge(stable, 1.01 * euler, |load| verdict(load).0 != Some(false));
        let (critical, width) = (0.5 * (stable + unstable), (unstable - stable) / euler);
        assert!(width < wide, "{dimension} {second} {shear}: nothing is known within {width:.1e} of the load");
        for times in [1.0 - 1e-13, 1.0, 1.0 + 1e-13] {
            assert_eq!(verdict(times * critical), (None, true), "{dimension} {second} {shear}, {width:.1e}");
        }
        assert_eq!(verdict((1.0 - 10.0 * wide) * critical), (Some(true), false), "{dimension} {second} {shear}");
        assert_eq!(verdict((1.0 + 10.0 * wide) * critical), (Some(false), false), "{dimension} {second} {shear}");
    }
}

/// A round strut that has buckled in space turns freely about its axis: that has no part in the verdict.
#[test]
fn a_motion_that_needs_no_force_leaves_the_verdict() {
    let text = "format = \"pennate/1\"\ndimension = \"space\"\nnodes = { A = [0, 0, 0], B = [10, 0, 0] }\n\
        sections.s = { stiffness = { EA = 1e4, GJ = 1, EI2 = 1, EI3 = 1 } }\n\
        members.m = { nodes = [\"A\", \"B\"], section = \"s\" }\nsupports = { A = \"clamped\" }\n\
        [[steps]]\nforce = { B = [-0.03, 0, 0] }\n";
    let solved = solve(text);
    let step = &solved.history.steps[0];
    assert_eq!(step.stable, Some(true), "{:?}", step.notes);
    assert!(!step.notes.contains(&Note::WithinRounding));
}

/// A critical load right before the end of a step leaves the step to end at its loads, not at that point and not beyond.
#[test]
fn a_step_that_ends_right_after_a_critical_load_ends_at_its_own() {
    let euler = std::f64::consts::PI.powi(2) / 400.0;
    for branch in ["primary", "stable"] {
        for beyond in [1e-4, 5e-4, 1.5e-3] {
            let load = (1.0 + beyond) * euler;
            let solved = solve(&format!(
                "format = \"pennate/1\"\ndimension = \"plane\"\nnodes = {{ A = [0, 0], B = [10, 0] }}\n\
                 sections.s = {{ stiffness = {{ EA = 1e4, GA2 = 1e3, EI3 = 1 }} }}\n\
                 members.m = {{ nodes = [\"A\", \"B\"], section = \"s\" }}\nsupports = {{ A = \"clamped\" }}\n\
                 [[steps]]\nforce = {{ B = [-{load:e}, 0] }}\nbranch = \"{branch}\"\n"
            ));
            let step = &solved.history.steps[0];
            assert_eq!(step.stable, Some(branch == "stable"), "{branch} {beyond:e}");
            assert_eq!(step.increments.last().expect("a state").fraction, 1.0, "{branch} {beyond:e}");
            assert_near(solved.force("A").x, load, 1e-9 * load);
        }
    }
}

/// Thousands of elements that cannot be sheared or stretched cost the digits of a column's own stiffness: the sign of what is left
/// is none to go by.
#[test]
fn a_column_of_thousands_of_rigid_elements_is_not_called_stable() {
    for elements in [512, 4096] {
        let text = format!(
            "format = \"pennate/1\"\ndimension = \"plane\"\nnodes = {{ A = [0, 0], T = [1, 0] }}\n\
             sections.s = {{ stiffness = {{ EA = 1, EI2 = 2, EI3 = 1, GJ = 1 }}, stretch = false }}\n\
             members.m = {{ nodes = [\"A\", \"T\"], section = \"s\", elements = {elements} }}\nsupports.A = \"clamped\"\n\
             [[steps]]\nforce.T = [-4, 0, 0]\nbranch = \"primary\"\n"
        );
        let solved = solve(&text);
        let step = &solved.history.steps[0];
        assert!(step.stable != Some(true) || step.status != Status::Converged, "{elements} elements: {:?}", step.notes);
    }
}
