//! Members whose ends are released: pins, hinges and free rotations.

use nalgebra::{UnitQuaternion, UnitVector3};
use pennate::output::text::undecided;
use pennate_solver::history::Note;
use pennate_testing::network::{Vector, assert_close, assert_near, rod, solve, solve_finely};

/// A bar between two pinned supports spins about itself without force, which is no mechanism.
#[test]
fn bar_between_pinned_supports_is_a_truss_bar() {
    let solved = solve(&rod(r#"
        dimension = "space"
        nodes = { A = [0, 0, 0], B = [30, 40, 0] }
        members.bar = { nodes = ["A", "B"], section = "rod" }
        supports = { A = "pinned", B = "pinned" }
        steps = [{ displacement = { B = [0.3, 0.4, 0] } }]
    "#));
    assert_near(solved.member("bar").axial_force, 3e4 * 0.5 / 50.0, 1e-9);
}

/// A space truss of pinned bars carries its load by axial forces alone.
#[test]
fn pinned_bars_of_a_space_truss_carry_no_moment() {
    let truss = |first: &str, ends: &str| {
        rod(&format!(
            r#"
        [nodes]
        A = [40, 0, 0]
        B = [-20, 34, 0]
        C = [-20, -34, 0]
        T = [3, 2, 50]
        [members]
        a = {{ nodes = {first}, section = "rod", release = {ends} }}
        b = {{ nodes = ["B", "T"], section = "rod", release = {ends} }}
        c = {{ nodes = ["C", "T"], section = "rod", release = {ends} }}
        [supports]
        A = "clamped"
        B = "pinned"
        C = "clamped"
        [[steps]]
        force = {{ T = [10, -7, 40] }}
    "#
        ))
    };
    let pinned = solve(&truss(r#"["A", "T"]"#, r#"{ start = "pin", end = "pin" }"#));
    let listed = solve(&truss(r#"["T", "A"]"#, r#"{ start = ["rx", "ry", "rz"], end = "pin" }"#));
    assert_close(listed.shift("T"), pinned.shift("T"), 1e-9);
    for solved in [pinned, listed] {
        for member in &solved.last().members {
            assert_eq!(member.end_moments, [[0.0; 3]; 2]);
        }
        let a = solved.member("a");
        let force = Vector::from(a.end_forces[0]);
        let line = solved.place("T") - solved.place("A");
        assert!(force.cross(&line).norm() < 1e-9 * force.norm() * line.norm());
        let (force, moment) = solved.imbalance(&[("T", [10.0, -7.0, 40.0], [0.0; 3])]);
        assert!(force < 1e-9 && moment < 1e-7, "{force} {moment}");
        assert!(solved.factorizations() < 45);
    }
}

/// A stiff bar that sags between hinges on fixed supports pulls on these by what its ends are pulled with, to the last digit. The rest of the
/// network comes to rest at once, and the turn that is left at the hinges by then makes 10⁻⁷ of that force.
#[test]
fn supports_bear_what_hinged_ends_are_pulled_with() {
    let solved = solve(
        r#"
        format = "pennate/1"
        dimension = "plane"
        [nodes]
        A = [54.795, 56.427]
        J = [22.470, 36.769]
        B = [99.348, 63.910]
        [sections]
        active = { stiffness = { EA = 16656.8, GA2 = 5829.9, EI3 = 16055.9, mass_per_length = 1e-6 } }
        soft = { stiffness = { EA = 743.54, EI3 = 7180.47, mass_per_length = 1e-6 } }
        stiff = { stiffness = { EA = 2.56e8, GA2 = 43260.5, EI3 = 26051.5, mass_per_length = 1e-6 } }
        [members]
        a = { nodes = ["A", "J"], section = "active", elements = 4, order = 3 }
        b = { nodes = ["J", "B"], section = "soft", elements = 4, order = 3 }
        [members.bar]
        nodes = ["B", "A"]
        section = "stiff"
        elements = 4
        order = 3
        release = { start = { hinge = [0, 0, 1] }, end = { hinge = [0, 0, 1] } }
        [supports]
        A = "clamped"
        B = "clamped"
        [[steps]]
        force = { J = [0.0307, -0.9109] }
        gravity = [1765, -1457.5, 0]
    "#,
    );
    for (support, ends) in [("A", [("a", 0), ("bar", 1)]), ("B", [("b", 1), ("bar", 0)])] {
        let pulled: Vector = ends.map(|(member, end)| Vector::from(solved.member(member).end_forces[end])).iter().sum();
        let reaction = Vector::from(solved.node(support).reaction_force);
        assert!((pulled - reaction).norm() < 1e-14 * pulled.norm(), "{support}: {pulled:?} {reaction:?}");
    }
}

/// A hinge about a skew axis in space: no moment about the axis, which the joint carries along.
#[test]
fn hinge_in_space_carries_no_moment_about_its_axis() {
    let frame = |member: &str| {
        rod(&format!(
            r#"
        [nodes]
        A = [0, 0, 0]
        J = [0, 50, 10]
        B = [60, 40, 0]
        [members]
        post = {{ nodes = ["A", "J"], section = "rod" }}
        beam = {member}
        [supports]
        A = "clamped"
        B = "clamped"
        [[steps]]
        force = {{ J = [8, -30, 25] }}
        moment = {{ J = [100, -150, 60] }}
    "#
        ))
    };
    let axis = Vector::new(1.0, 2.0, -0.5).normalize();
    let straight =
        frame(r#"{ nodes = ["J", "B"], section = "round", release = { start = { hinge = [1, 2, -0.5] } } }"#);
    let swapped = frame(r#"{ nodes = ["B", "J"], section = "round", release = { end = { hinge = [1, 2, -0.5] } } }"#);
    let (straight, swapped) = (solve_finely(&straight, 3), solve_finely(&swapped, 3));
    assert_close(straight.shift("J"), swapped.shift("J"), 1e-5);
    for (solved, end) in [(straight, 0), (swapped, 1)] {
        assert!(solved.rotation("J").angle() > 0.1, "the joint turns far enough to tell");
        let moment = Vector::from(solved.member("beam").end_moments[end]);
        assert!(moment.norm() > 10.0);
        assert_near(moment.dot(&(solved.rotation("J") * axis)), 0.0, 1e-8 * moment.norm());
        let (force, moment) = solved.imbalance(&[("J", [8.0, -30.0, 25.0], [100.0, -150.0, 60.0])]);
        assert!(force < 1e-8 && moment < 1e-6, "{force} {moment}");
        // An increment of six iterations is looked at half way.
        assert!(solved.factorizations() < 55, "{}", solved.factorizations());
    }
}

/// Lists of free rotations, one and two, at either end and in both directions of the member.
#[test]
fn released_rotations_about_own_axes_carry_no_moment() {
    for (free, first) in [("\"rx\"", 0), ("\"ry\"", 1), ("\"rz\"", 2)] {
        let solved = solve(&rod(&format!(
            r#"
            [nodes]
            A = [0, 0, 0]
            J = [50, 0, 0]
            B = [50, 60, 10]
            [members]
            first = {{ nodes = ["A", "J"], section = "rod", release = {{ end = [{free}] }} }}
            second = {{ nodes = ["J", "B"], section = "rod" }}
            [supports]
            A = "clamped"
            B = "clamped"
            [[steps]]
            force = {{ J = [5, -20, 30] }}
            moment = {{ J = [100, 150, 60] }}
        "#
        )));
        let mut axis = Vector::zeros();
        axis[first] = 1.0;
        let moment = Vector::from(solved.member("first").end_moments[1]);
        assert!(moment.norm() > 1.0);
        assert_near(moment.dot(&(solved.rotation("J") * axis)), 0.0, 1e-8 * moment.norm());
        let (force, moment) = solved.imbalance(&[("J", [5.0, -20.0, 30.0], [100.0, 150.0, 60.0])]);
        assert!(force < 1e-8 && moment < 1e-6, "{free} {force} {moment}");
        assert!(solved.factorizations() < 45, "{}", solved.factorizations());
    }
}

/// Two free rotations at an end, whichever way the member runs.
#[test]
fn two_released_rotations_balance() {
    let frame = |first: &str, release: &str| {
        rod(&format!(
            r#"
        [nodes]
        A = [0, 0, 0]
        J = [50, 0, 0]
        B = [50, 60, 10]
        [members]
        first = {{ nodes = {first}, section = "round", release = {release} }}
        second = {{ nodes = ["J", "B"], section = "rod" }}
        [supports]
        A = "clamped"
        B = "clamped"
        [[steps]]
        force = {{ J = [5, -20, 30] }}
        moment = {{ J = [300, 150, 260] }}
    "#
        ))
    };
    let one = solve_finely(&frame(r#"["A", "J"]"#, r#"{ end = ["ry", "rz"] }"#), 3);
    let other = solve_finely(&frame(r#"["J", "A"]"#, r#"{ start = ["ry", "rz"] }"#), 3);
    assert_close(one.shift("J"), other.shift("J"), 1e-5);
    let (force, moment) = one.imbalance(&[("J", [5.0, -20.0, 30.0], [300.0, 150.0, 260.0])]);
    assert!(force < 1e-8 && moment < 1e-6, "{force} {moment}");
    // An increment of six iterations is looked at half way.
    assert!(one.factorizations() < 50, "{}", one.factorizations());
}

/// A parallelogram of bars hinged about parallel skew axes is driven around without force.
#[test]
fn hinged_parallelogram_turns_without_force() {
    let solved = solve(&rod(r#"
        dimension = "space"
        [nodes]
        A = [0, 0, 0]
        B = [0, 50, 0]
        C = [80, 50, 0]
        D = [80, 0, 0]
        [members]
        crank = { nodes = ["A", "B"], section = "rod", orientation = [0, 0, 1] }
        coupler = { nodes = ["B", "C"], section = "rod", orientation = [0, 0, 1], release = { start = { hinge = [0, 0, 1] }, end = { hinge = [0, 0, 1] } } }
        follower = { nodes = ["C", "D"], section = "rod", orientation = [0, 0, 1] }
        [supports]
        A = "clamped"
        D = ["ux", "uy", "uz", "rx", "ry"]
        [[steps]]
        rotation = { A = [0, 0, -70] }
        [[steps]]
        rotation = { A = [0, 0, -250] }
    "#));
    let angle = -250f64.to_radians();
    let turned = Vector::new(-50.0 * angle.sin(), 50.0 * angle.cos(), 0.0);
    assert_close(solved.place("B"), turned, 1e-8);
    assert_close(solved.place("C"), turned + Vector::new(80.0, 0.0, 0.0), 1e-8);
    assert!(solved.last().energy < 1e-12, "{}", solved.last().energy);
}

/// A joint whose ends all turn about one axis has no spin about it, in space as in the plane.
#[test]
fn joint_of_hinged_ends_alone_is_no_mechanism() {
    let network = |dimension: &str, joint: &str| {
        rod(&format!(
            r#"
        dimension = "{dimension}"
        [nodes]
        A = [0, 0, 0]
        J = [50, 10, 0]
        B = [90, -10, 0]
        [members]
        first = {{ nodes = ["A", "J"], section = "round", release = {{ end = {joint} }} }}
        second = {{ nodes = ["B", "J"], section = "round", release = {{ end = {joint} }} }}
        [supports]
        A = "clamped"
        B = "clamped"
        [[steps]]
        force = {{ J = [1, -4, 0] }}
    "#
        ))
    };
    let plane = solve(&network("plane", "\"pin\""));
    for (dimension, joint) in
        [("plane", "{ hinge = [0, 0, 1] }"), ("space", "{ hinge = [0, 0, -1] }"), ("space", "\"pin\"")]
    {
        let solved = solve(&network(dimension, joint));
        assert_close(solved.shift("J"), plane.shift("J"), 1e-5);
        assert_near(solved.member("first").end_moments[1][2], 0.0, 1e-8);
    }
}

/// Two released rotations at a joint that takes no moment anyway are a pin.
#[test]
fn lone_end_with_two_released_rotations_is_a_pin() {
    let network = |release: &str| {
        rod(&format!(
            r#"
            [nodes]
            A = [0, 0, 0]
            B = [60, 0, 0]
            C = [0, 60, 0]
            J = [30, 30, 40]
            [members]
            a = {{ nodes = ["A", "J"], section = "rod", release = {{ end = {release}, start = {release} }} }}
            b = {{ nodes = ["B", "J"], section = "rod", release = {{ end = "pin" }} }}
            c = {{ nodes = ["J", "C"], section = "rod", release = {{ start = "pin" }} }}
            [supports]
            A = "pinned"
            B = "clamped"
            C = "clamped"
            [[steps]]
            force = {{ J = [10, 20, -50] }}
            "#
        ))
    };
    let pinned = solve(&network("\"pin\""));
    for release in ["[\"ry\", \"rz\"]", "[\"rx\", \"rz\"]", "[\"ry\"]", "{ hinge = [1, 2, 3] }"] {
        let solved = solve(&network(release));
        assert_close(solved.shift("J"), pinned.shift("J"), 1e-10);
        assert_eq!(solved.member("a").end_moments, [[0.0; 3]; 2]);
    }
}

/// What a later step turns stands still about the axes that its members are released about until then; where the network comes to does not
/// depend on when it is turned.
#[test]
fn a_released_joint_stands_still_until_a_step_turns_it() {
    let network = |release: &str, first: &str, second: &str| {
        rod(&format!(
            "nodes = {{ A = [0, 0, 0], B = [12, 5, -45] }}\n\
             members.ab = {{ nodes = ['A', 'B'], section = 'rod', release = {release} }}\n\
             supports = {{ A = 'clamped' }}\nsteps = [ {{ {first} }}, {{ {second} }} ]"
        ))
    };
    let (load, turn) = ("force = { B = [0.1, 1, 0] }", "rotation = { B = [10, 20, 0] }");
    for release in ["{ end = ['ry', 'rz'] }", "{ end = ['rx', 'ry'] }", "{ end = { hinge = [0, 0, 1] } }"] {
        let last = solve(&network(release, load, turn));
        let first = solve(&network(release, turn, load));
        assert!(last.history.steps.iter().all(|step| step.stable == Some(true)), "{release}");
        assert_close(last.shift("B"), first.shift("B"), 1e-8);
        assert!(last.factorizations() < 60, "{release}: {}", last.factorizations());
    }
}

/// A bar that is kept from spinning about itself as long as nothing turns it follows what a later step turns: it comes to the same as where
/// it is held against the spin from the first step on.
#[test]
fn a_bar_that_a_later_step_turns_about_itself_follows() {
    let network = |release: &str, first: &str| {
        rod(&format!(
            "nodes = {{ A = [0, 0, 0], B = [60, 0, 0] }}\n\
             members.ab = {{ nodes = ['A', 'B'], section = 'rod', release = {{ start = {release} }} }}\n\
             supports = {{ A = 'clamped', B = ['uy', 'uz'] }}\n\
             steps = [ {{ force = {{ B = [1, 0, 0] }}{first} }}, {{ rotation = {{ B = [30, 0, 10] }} }} ]"
        ))
    };
    for release in ["'pin'", "['rx', 'rz']", "['rx']"] {
        let [late, early] = ["", ", hold = { B = ['rx'] }"].map(|first| solve(&network(release, first)));
        assert!(late.history.steps.iter().all(|step| step.notes.is_empty()), "{:?}", late.history.steps[1].notes);
        let moments = [&late, &early].map(|solved| Vector::from(solved.member("ab").end_moments[1]));
        assert!(moments[0].norm() > 1.0);
        assert_close(moments[0], moments[1], 1e-8);
    }
}

/// What holds a node about an axis that is only partly one that its end is released about is met by turns of the node alone: it takes no
/// moment, and the end goes where it would go without. It was held against turning about the released axis, too, and took one.
#[test]
fn what_released_turns_make_up_for_takes_no_moment() {
    let network = |release: &str, support: &str, step: &str| {
        rod(&format!(
            "nodes = {{ A = [0, 0, 0], B = [30, 20, 50] }}\n\
             members.ab = {{ nodes = ['A', 'B'], section = 'rod', release = {{ end = {release} }} }}\n\
             supports = {{ A = 'clamped'{support} }}\nsteps = [ {{ force = {{ B = [5, -3, 2] }} }}, {{ {step} }} ]"
        ))
    };
    let pinned = solve(&network("'pin'", "", "pressure = {}"));
    for (release, support, step) in [
        ("{ hinge = [0.6, 0.8, 0] }", ", B = ['rx']", "pressure = {}"),
        ("['ry', 'rz']", ", B = ['rx']", "pressure = {}"),
        ("['ry', 'rz']", "", "rotation = { B = { rx = 20 } }"),
        ("['ry', 'rz']", "", "rotation = { B = { rx = 10, rz = -15 } }"),
    ] {
        let held = solve(&network(release, support, step));
        assert_close(held.shift("B"), pinned.shift("B"), 1e-7);
        let [moment, force] = [held.member("ab").end_moments[1], held.member("ab").end_forces[1]];
        let none = Vector::from(moment).norm() < 1e-7 * Vector::from(force).norm() * 60.0;
        assert!(none, "{release}, {support}, {step}: {moment:?}");
    }
}

/// A held component of a rotation vector, across a hinge at rest, acts about it in part once the node has turned. What keeps the node from
/// turning about the hinge takes a moment then, which the residual cannot see: it is measured, and said.
#[test]
fn a_moment_that_nothing_takes_is_named() {
    let network = |held: &str| {
        rod(&format!(
            r#"
            [nodes]
            A = [0, 0, 0]
            J = [50, 0, 0]
            B = [90, 20, 10]
            [members]
            first = {{ nodes = ["A", "J"], section = "rod", release = {{ end = {{ hinge = [0, 1, 0] }} }} }}
            second = {{ nodes = ["J", "B"], section = "rod", release = {{ start = {{ hinge = [0, 1, 0] }} }} }}
            [supports]
            A = "clamped"
            B = "pinned"
            J = {held}
            [[steps]]
            force = {{ J = [0, -20, 30] }}
        "#
        ))
    };
    for (held, taken) in
        [("[\"rx\"]", false), ("[\"ry\"]", true), ("[\"rx\", \"rz\"]", true), ("[\"rx\", \"ry\", \"rz\"]", true)]
    {
        let solved = solve(&network(held));
        let said =
            solved.step("step 1").notes.iter().any(|note| matches!(note, Note::Untaken { nodes } if nodes == &[1]));
        assert_eq!(said, !taken, "{held}");
        let step = solved.step("step 1");
        let why = if taken { None } else { Some("where a moment on a node is taken by nothing") };
        assert_eq!((step.stable, undecided(step)), (taken.then_some(true), why), "{held}");
        let left = solved.last().joint_balance;
        assert!(if taken { left < 1e-9 } else { (1e-6..1e-2).contains(&left) }, "{held}: {left:e}");
        assert!(solved.last().residual < 1e-9 && solved.last().balance < 1e-9);
    }
}

/// A node whose ends are all hinged about one axis is turned about another: what lies along the hinge's axis, as it is turned itself, makes
/// no difference to the members.
#[test]
fn a_turn_across_a_skew_hinge_turns_the_members() {
    let network = |turn: &str| {
        rod(&format!(
            r#"
            [nodes]
            A = [0, 0, 0]
            J = [50, 0, 0]
            B = [90, 20, 10]
            [members]
            first = {{ nodes = ["A", "J"], section = "rod", release = {{ end = {{ hinge = [0.6, 0.8, 0] }} }} }}
            second = {{ nodes = ["J", "B"], section = "rod", release = {{ start = {{ hinge = [0.6, 0.8, 0] }} }} }}
            [supports]
            A = "clamped"
            B = "clamped"
            [[steps]]
            rotation = {{ J = {turn} }}
            force = {{ J = [0, -2, 3] }}
        "#
        ))
    };
    // The same rotation after a turn of -25 degrees about the hinge.
    let turn = UnitQuaternion::new(Vector::x() * 40f64.to_radians());
    let hinge = UnitVector3::new_normalize(Vector::new(0.6, 0.8, 0.0));
    let other =
        (turn * UnitQuaternion::from_axis_angle(&hinge, -25f64.to_radians())).scaled_axis().map(f64::to_degrees);
    let one = solve(&network("[40, 0, 0]"));
    let two = solve(&network(&format!("[{}, {}, {}]", other.x, other.y, other.z)));
    for solved in [&one, &two] {
        assert!(solved.last().joint_balance < 1e-9 && solved.last().balance < 1e-9);
        let moment = Vector::from(solved.member("second").end_moments[0]);
        assert!(moment.norm() > 1.0);
        assert_near(moment.dot(&(solved.rotation("J") * hinge.into_inner())), 0.0, 1e-8 * moment.norm());
    }
    assert_close(one.shift("J"), two.shift("J"), 1e-8);
    assert_close(one.member("first").end_moments[0], two.member("first").end_moments[0], 1e-6);
}
