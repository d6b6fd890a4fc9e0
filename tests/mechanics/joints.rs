//! What joins members, bodies and the ground: releases, supports, rigid bodies, springs.

use std::f64::consts::PI;

use pennate_testing::network;

use pennate_testing::network::{ROD, Vector, assert_close, assert_near, attempt, places, solve, solve_finely};

fn rod(rest: &str) -> String {
    format!("{ROD}{rest}")
}

// Releases.

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
        assert!(solved.factorizations() < 45, "{}", solved.factorizations());
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
    assert!(one.factorizations() < 45, "{}", one.factorizations());
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

// Supports.

/// A guide in turned axes is the guide of the turned network.
#[test]
fn guide_in_turned_axes_is_the_guide_of_the_turned_network() {
    let plain = solve_finely(
        &rod(r#"
        nodes = { A = [0, 0], B = [60, 0] }
        members.beam = { nodes = ["A", "B"], section = "round" }
        supports = { A = "clamped", B = ["uy", "rz"] }
        steps = [{ force = { B = [-20, 3] }, displacement = { B = { uy = 7 } } }]
    "#),
        4,
    );
    for dimension in ["plane", "space"] {
        let turned = solve_finely(
            &rod(&format!(
                r#"
            dimension = "{dimension}"
            nodes = {{ A = [0, 0], B = ["= 60 * cos(35)", "= 60 * sin(35)"] }}
            members.beam = {{ nodes = ["A", "B"], section = "round" }}
            [supports]
            A = "clamped"
            B = {{ fix = ["uy", "uz", "rx", "ry", "rz"], x_axis = ["= cos(35)", "= sin(35)", 0] }}
            [[steps]]
            force = {{ B = ["= -20 * cos(35) - 3 * sin(35)", "= -20 * sin(35) + 3 * cos(35)", 0] }}
            displacement = {{ B = {{ uy = 7 }} }}
        "#
            )),
            4,
        );
        let turn = nalgebra::Rotation3::from_axis_angle(&Vector::z_axis(), 35f64.to_radians());
        assert_close(turned.shift("B"), turn * plain.shift("B"), 1e-9);
        assert_close(turned.force("B"), turn * plain.force("B"), 1e-9);
        assert_close(turned.moment("B"), plain.moment("B"), 1e-7);
        assert_near((turn.inverse() * turned.shift("B")).y, 7.0, 1e-12);
    }
}

/// Three nodes of a body held in all directions clamp it, however many of the nine reactions are redundant.
#[test]
fn redundant_supports_on_a_body_clamp_it() {
    let network = |supports: &str| {
        rod(&format!(
            r#"
        [nodes]
        A = [0, 0, 0]
        P = [60, 5, 0]
        Q = [60, -5, 3]
        R = [65, 0, -6]
        [members]
        beam = {{ nodes = ["A", "P"], section = "rod" }}
        [rigid_bodies]
        plate = {{ nodes = ["P", "Q", "R"] }}
        [supports]
        {supports}
        [[steps]]
        distributed = {{ beam = [0.1, -0.4, 0.6] }}
        force = {{ R = [0, 9, 0] }}
    "#
        ))
    };
    let clamped = solve(&network("A = \"clamped\"\nP = \"clamped\""));
    let held = solve(&network("A = \"clamped\"\nP = \"pinned\"\nQ = \"pinned\"\nR = \"pinned\""));
    let enough = solve(&network("A = \"clamped\"\nP = \"pinned\"\nQ = [\"ux\", \"uz\"]\nR = [\"uy\"]"));
    for solved in [&clamped, &held, &enough] {
        assert_close(solved.shift("R"), [0.0; 3], 1e-12);
        assert_close(solved.moment("A"), clamped.moment("A"), 1e-8);
        let length = 3625f64.sqrt();
        let weight = Vector::new(0.1, -0.4, 0.6) * length + Vector::new(0.0, 9.0, 0.0);
        let sum = ["A", "P", "Q", "R"].iter().fold(Vector::zeros(), |sum, node| sum + solved.force(node));
        assert_close(sum, -weight, 1e-9);
    }
    let moment = |solved: &network::Solved| {
        ["P", "Q", "R"].iter().fold(Vector::zeros(), |sum, node| {
            sum + solved.moment(node) + (solved.place(node) - solved.place("P")).cross(&solved.force(node))
        })
    };
    assert_close(moment(&held), moment(&clamped), 1e-7);
    assert_close(moment(&enough), moment(&clamped), 1e-7);
}

/// Rotations held in part, with large rotations about what is free: reactions balance the loads all the same.
#[test]
fn partly_held_rotations_react_with_moments_that_balance() {
    for held in ["\"rx\"", "\"ry\"", "\"rz\"", "\"rx\", \"ry\"", "\"ry\", \"rz\""] {
        let solved = solve(&rod(&format!(
            r#"
            [nodes]
            A = [0, 0, 0]
            B = [60, 0, 0]
            [members]
            beam = {{ nodes = ["A", "B"], section = "rod" }}
            [supports]
            A = "clamped"
            B = [{held}]
            [[steps]]
            force = {{ B = [-10, 3, 4] }}
            moment = {{ B = [90, 200, 250] }}
        "#
        )));
        assert!(solved.rotation("B").angle() > 0.3, "{held}: {}", solved.rotation("B").angle());
        let (force, moment) = solved.imbalance(&[("B", [-10.0, 3.0, 4.0], [90.0, 200.0, 250.0])]);
        assert!(force < 1e-9 && moment < 1e-7, "{held}: {force:.1e} {moment:.1e}");
        // The reference is from 400 increments; two long ones lead to another, unstable state with 40 factorizations. What
        // was hard to find under loads without a potential is made again in two parts.
        let enough = if held == "\"rx\"" {
            assert_close(solved.shift("B"), [-35.371033, 27.844493, 38.119512], 1e-5);
            80
        } else {
            60
        };
        assert!(solved.factorizations() < enough, "{held}: {}", solved.factorizations());
    }
}

/// A dead force has a potential, however skew the support that guides its node.
#[test]
fn skew_supports_do_not_take_the_potential_of_a_force() {
    let solved = solve(&rod(r#"
        nodes = { A = [0, 0, 0], B = [60, 0, 0] }
        members.b = { nodes = ["A", "B"], section = "rod" }
        supports = { A = "clamped", B = { fix = ["ux", "ry"], x_axis = [1, 2, 3] } }
        steps = [
            { name = "load", force = { B = [5, 4, 1] } },
            { name = "unload", force = { B = [0, 0, 0] } },
        ]
    "#));
    for step in &solved.history.steps {
        assert_eq!(step.stable, Some(true));
    }
    assert_eq!(solved.after("unload").balance, 0.0);
}

/// Prescribed end rotations roll a rod up to any angle: a circle with the moment EI θ/L.
#[test]
fn prescribed_rotation_beyond_half_a_turn_rolls_a_rod_up() {
    for dimension in ["plane", "space"] {
        for (held, angle) in [("[0, 0, 250]", 250f64), ("{ rz = 200 }", 200.0)] {
            let solved = solve_finely(
                &rod(&format!(
                    r#"
                dimension = "{dimension}"
                nodes = {{ A = [0, 0, 0], B = [60, 0, 0] }}
                members.beam = {{ nodes = ["A", "B"], section = "round" }}
                supports = {{ A = "clamped" }}
                steps = [{{ rotation = {{ B = {held} }} }}]
            "#
                )),
                6,
            );
            let angle = angle.to_radians();
            assert_near(solved.moment("B").z, 1e4 * angle / 60.0, 1e-6);
            let radius = 60.0 / angle;
            assert_close(solved.place("B"), Vector::new(radius * angle.sin(), radius * (1.0 - angle.cos()), 0.0), 1e-6);
        }
    }
}

/// A rod twisted by 250 degrees is not one twisted back by 110.
#[test]
fn prescribed_twist_beyond_half_a_turn_keeps_its_sense() {
    for increments in [1, 2, 7] {
        let solved = solve_finely(
            &rod(&format!(
                r#"
            dimension = "space"
            nodes = {{ A = [0, 0, 0], B = [60, 0, 0] }}
            members.beam = {{ nodes = ["A", "B"], section = "round" }}
            supports = {{ A = "clamped", B = ["uy", "uz", "rx", "ry", "rz"] }}
            steps = [{{ rotation = {{ B = [250, 0, 0] }}, increments = {increments} }}]
        "#
            )),
            6,
        );
        assert_near(solved.moment("B").x, 7e3 * 250f64.to_radians() / 60.0, 1e-6);
    }
}

/// A skew rotation vector beyond half a turn, met exactly and with balanced reactions.
#[test]
fn prescribed_skew_rotation_beyond_half_a_turn_is_met() {
    let solved = solve(&rod(r#"
        nodes = { A = [0, 0, 0], B = [60, 0, 0] }
        members.beam = { nodes = ["A", "B"], section = "round", elements = 8 }
        supports = { A = "clamped" }
        steps = [{ rotation = { B = [60, 120, 150] } }]
    "#));
    let goal = nalgebra::UnitQuaternion::from_scaled_axis(Vector::new(60.0, 120.0, 150.0) * (PI / 180.0));
    assert!(solved.rotation("B").angle_to(&goal) < 1e-9);
    let (force, moment) = solved.imbalance(&[]);
    assert!(force < 1e-9 && moment < 1e-7, "{force} {moment}");
}

/// What a step sets free fades to the equilibrium that was never held.
#[test]
fn freed_components_end_where_they_would_have_been() {
    let network = |steps: &str| {
        rod(&format!(
            r#"
        [nodes]
        A = [0, 0, 0]
        B = [60, 10, 0]
        [members]
        beam = {{ nodes = ["A", "B"], section = "rod" }}
        [supports]
        A = "clamped"
        {steps}
    "#
        ))
    };
    let load = "force = { B = [-5, 3, 4] }\nmoment = { B = [90, -200, 120] }";
    let never = solve(&network(&format!("[[steps]]\n{load}")));
    for held in ["\"ux\", \"uy\"", "\"ry\"", "\"rx\", \"rz\"", "\"uz\", \"rx\", \"ry\", \"rz\""] {
        let freed = solve(&network(
            &format!(
                r#"
            [[steps]]
            hold = {{ B = [{held}] }}
            force = {{ B = [-5, 3, 4] }}
            [[steps]]
            moment = {{ B = [90, -200, 120] }}
            displace_by = {{ B = {{ uz = 3 }} }}
            [[steps]]
            hold = {{ B = [{held}] }}
            [[steps]]
            free = {{ B = ["uz", {held}] }}
        "#
            )
            .replace("\"uz\", \"uz\"", "\"uz\""),
        ));
        assert_close(freed.shift("B"), never.shift("B"), 1e-8);
        assert_close(freed.force("B"), [0.0; 3], 0.0);
        assert_close(freed.moment("A"), never.moment("A"), 1e-7);
        for step in &freed.history.steps {
            assert!(step.increments.last().unwrap().state.residual < 1e-9);
        }
    }
}

/// Freeing begins where holding ended: at a small fraction the state has hardly moved.
#[test]
fn freeing_begins_at_the_held_state() {
    let solved = solve(&rod(r#"
        [nodes]
        A = [0, 0, 0]
        B = [60, 10, 0]
        [members]
        beam = { nodes = ["A", "B"], section = "rod" }
        [supports]
        A = "clamped"
        [[steps]]
        name = "hold"
        rotation = { B = { rx = 30, ry = 50 } }
        moment = { B = [0, 0, 250] }
        [[steps]]
        name = "free"
        free = { B = ["rx", "ry"] }
        increments = 1000
    "#));
    let held = &solved.after("hold").nodes[1];
    let first = &solved.step("free").increments[0];
    assert!(first.fraction < 2e-3);
    assert_close(first.state.nodes[1].displacement, held.displacement, 0.2);
}

/// A displacement prescribed at a point of a body moves the body about what else holds it.
#[test]
fn body_is_moved_by_a_prescribed_point() {
    let solved = solve(&rod(r#"
        dimension = "space"
        [nodes]
        A = [0, 0, 0]
        P = [60, 0, 0]
        Q = [60, 40, 0]
        [members]
        beam = { nodes = ["A", "P"], section = "rod" }
        [rigid_bodies]
        arm = { nodes = ["P", "Q"] }
        [supports]
        A = "clamped"
        [[steps]]
        displacement = { Q = { ux = -50, uz = 10 } }
    "#));
    assert_near(solved.shift("Q").x, -50.0, 1e-10);
    assert_near(solved.shift("Q").z, 10.0, 1e-10);
    assert_near((solved.place("Q") - solved.place("P")).norm(), 40.0, 1e-11);
    let (force, moment) = solved.imbalance(&[]);
    assert!(force < 1e-8 && moment < 1e-6, "{force} {moment}");
    assert!(solved.factorizations() < 45, "{}", solved.factorizations());
}

// Springs.

/// A coupling with six components works like two ground springs seen from the first node, wherever that goes.
#[test]
fn coupling_turns_with_its_first_node() {
    let solved = solve(&rod(r#"
        [nodes]
        A = [0, 0, 0]
        B = [10, 4, 3]
        C = [10, 44, 3]
        [members]
        arm = { nodes = ["B", "C"], section = "strong" }
        [springs]
        k = { nodes = ["A", "B"], stiffness = { ux = 3, uy = 4, uz = 5, rx = 800, ry = 700, rz = 900 } }
        [supports]
        A = "clamped"
        [[steps]]
        name = "bend"
        follower_force = { C = [6, 0, -4] }
        [[steps]]
        name = "turn"
        rotation = { A = [50, 70, -80] }
        displacement = { A = [1, 2, 3] }
    "#));
    let (before, after) = (&solved.after("bend").nodes, &solved.after("turn").nodes);
    let turn = nalgebra::Rotation3::new(Vector::new(50.0, 70.0, -80.0) * (PI / 180.0));
    let place = Vector::new(10.0, 44.0, 3.0) + Vector::from(before[2].displacement);
    let moved = turn * place + Vector::new(1.0, 2.0, 3.0);
    assert_close(Vector::new(10.0, 44.0, 3.0) + Vector::from(after[2].displacement), moved, 1e-8);
    assert_near(solved.after("bend").energy, solved.after("turn").energy, 1e-9 * solved.last().energy);
}

/// A coupling is a short stiff beam in the limit: a force on the second node bends a beam at the first.
#[test]
fn coupling_with_offset_balances_about_its_first_node() {
    let solved = solve(&rod(r#"
        [nodes]
        A = [0, 0, 0]
        B = [60, 0, 0]
        C = [65, 12, -4]
        [members]
        beam = { nodes = ["A", "B"], section = "rod" }
        [springs]
        k = { nodes = ["B", "C"], stiffness = { ux = 30, uy = 40, uz = 50, rx = 8000, ry = 7000, rz = 9000 } }
        [supports]
        A = "clamped"
        [[steps]]
        force = { C = [3, 8, -7] }
        moment = { C = [100, 20, 80] }
    "#));
    let (force, moment) = solved.imbalance(&[("C", [3.0, 8.0, -7.0], [100.0, 20.0, 80.0])]);
    assert!(force < 1e-9 && moment < 1e-7, "{force} {moment}");
    // Dead moments have no potential: an increment that was hard to find is made again in two parts.
    assert!(solved.factorizations() < 70, "{}", solved.factorizations());
}

/// Springs without rotational stiffness hold a node without a rotation: no mechanism.
#[test]
fn node_on_translational_springs_alone_is_no_mechanism() {
    let solved = solve(&rod(r#"
        [nodes]
        A = [0, 0, 0]
        B = [60, 0, 0]
        C = [65, 0, 0]
        [members]
        beam = { nodes = ["A", "B"], section = "round" }
        [springs]
        k = { nodes = ["B", "C"], stiffness = { ux = 30, uy = 40, uz = 50 } }
        [supports]
        A = "clamped"
        [[steps]]
        force = { C = [3, 0, -0.7] }
    "#));
    let (force, moment) = solved.imbalance(&[("C", [3.0, 0.0, -0.7], [0.0; 3])]);
    assert!(force < 1e-9 && moment < 1e-7, "{force} {moment}");
}

/// Ground springs on the rotation of a node: the moment is the gradient of ½ Σ k θ².
#[test]
fn ground_spring_resists_large_rotations() {
    for dimension in ["plane", "space"] {
        for angle in [100.0_f64, 200.0, 400.0] {
            let solved = solve(&rod(&format!(
                r#"
                dimension = "{dimension}"
                nodes = {{ A = [0, 0, 0], B = [60, 0, 0] }}
                members.beam = {{ nodes = ["A", "B"], section = "strong" }}
                springs.k = {{ node = "A", stiffness = {{ rz = 5 }} }}
                supports.A = ["ux", "uy", "uz", "rx", "ry"]
                steps = [{{ follower_moment = {{ B = [0, 0, {}] }} }}]
            "#,
                5.0 * angle.to_radians()
            )));
            let turned = solved.rotation("B") * Vector::x();
            let expected = Vector::new(angle.to_radians().cos(), angle.to_radians().sin(), 0.0);
            assert_close(turned, expected, 1e-3);
            assert_near(solved.last().energy, 2.5 * angle.to_radians().powi(2), 1e-2);
        }
    }
}

/// A coupling in the plane counts whole turns; in space its rotation vector ends at half a turn.
#[test]
fn coupling_resists_large_rotations() {
    for (dimension, angles) in [("plane", &[100.0_f64, 200.0, 400.0][..]), ("space", &[100.0, 170.0])] {
        for angle in angles {
            let solved = solve(&rod(&format!(
                r#"
                dimension = "{dimension}"
                nodes = {{ G = [0, 0, 0], A = [0, 0, 0], B = [60, 0, 0] }}
                members.beam = {{ nodes = ["A", "B"], section = "strong" }}
                springs.k = {{ nodes = ["G", "A"], stiffness = {{ ux = 1e3, uy = 1e3, uz = 1e3, rx = 1e5, ry = 1e5, rz = 5 }} }}
                supports.G = "clamped"
                steps = [{{ follower_moment = {{ B = [0, 0, {}] }} }}]
            "#,
                5.0 * angle.to_radians()
            )));
            let turned = solved.rotation("B") * Vector::x();
            let expected = Vector::new(angle.to_radians().cos(), angle.to_radians().sin(), 0.0);
            assert_close(turned, expected, 1e-3);
        }
    }
}

/// Two prestressed axial springs in line share their misfit; nothing but the prestress acts.
#[test]
fn springs_of_another_natural_length_prestress_a_network_without_steps() {
    let solved = solve(&rod(r#"
        [nodes]
        A = [0, 0, 0]
        M = [40, 0, 0]
        B = [100, 0, 0]
        [springs]
        left = { nodes = ["A", "M"], stiffness = 3, natural_length = 30 }
        right = { nodes = ["M", "B"], stiffness = 2, natural_length = 50 }
        [supports]
        A = "pinned"
        B = "pinned"
    "#));
    let force = 20.0 / (1.0 / 3.0 + 1.0 / 2.0);
    assert_near(solved.last().springs[0], force, 1e-10);
    assert_near(solved.last().springs[1], force, 1e-10);
    assert_near(solved.shift("M").x, -10.0 + force / 3.0, 1e-10);
    assert_close(solved.force("A"), [-force, 0.0, 0.0], 1e-10);
}

// Rigid bodies.

/// A dead force on a node of a body acts with its lever, as at the end of a very stiff arm.
#[test]
fn force_on_a_body_acts_with_its_lever() {
    let arm = |how: &str| {
        rod(&format!(
            r#"
        [nodes]
        A = [0, 0, 0]
        P = [60, 0, 0]
        Q = [70, 30, 5]
        [members]
        beam = {{ nodes = ["A", "P"], section = "rod" }}
        {how}
        [supports]
        A = "clamped"
        [[steps]]
        force = {{ Q = [-6, 4, 5] }}
        moment = {{ Q = [30, -20, 10] }}
        follower_force = {{ Q = [-2, 3, 1] }}
        follower_moment = {{ Q = [-30, 40, 50] }}
    "#
        ))
    };
    let body = solve(&arm("[rigid_bodies]\narm = { nodes = [\"P\", \"Q\"] }"));
    let stiff = solve(&arm("arm = { nodes = [\"P\", \"Q\"], section = \"strong\" }"));
    assert_close(body.shift("Q"), stiff.shift("Q"), 1e-2);
    let turned = body.rotation("Q");
    let force = Vector::new(-6.0, 4.0, 5.0) + turned * Vector::new(-2.0, 3.0, 1.0);
    let moment = Vector::new(30.0, -20.0, 10.0) + turned * Vector::new(-30.0, 40.0, 50.0);
    let (force, moment) = body.imbalance(&[("Q", force.into(), moment.into())]);
    assert!(force < 1e-9 && moment < 1e-7, "{force} {moment}");
    assert!(body.factorizations() < 45, "{}", body.factorizations());
}

/// The reference of a body may be any of its nodes: the answer is the same.
#[test]
fn reference_of_a_body_is_a_matter_of_taste() {
    let network = |reference: &str| {
        rod(&format!(
            r#"
        [nodes]
        A = [0, 0, 0]
        B = [0, 40, 10]
        P = [60, 0, 0]
        Q = [60, 40, 5]
        R = [90, 10, -20]
        [members]
        one = {{ nodes = ["A", "P"], section = "rod", release = {{ end = {{ hinge = [1, 3, 2] }} }} }}
        two = {{ nodes = ["Q", "B"], section = "rod", release = {{ start = "pin" }} }}
        [rigid_bodies]
        stage = {{ nodes = ["P", "Q", "R"], reference = "{reference}" }}
        [springs]
        k = {{ nodes = ["R", "A"], stiffness = 0.5, natural_length = 70 }}
        [supports]
        A = "clamped"
        B = "clamped"
        [[steps]]
        force = {{ R = [-6, 4, 5] }}
        [[steps]]
        displace_by = {{ R = {{ uz = 10 }} }}
    "#
        ))
    };
    let first = solve(&network("P"));
    for reference in ["Q", "R"] {
        let other = solve(&network(reference));
        for node in ["P", "Q", "R"] {
            assert_close(other.shift(node), first.shift(node), 1e-8);
            assert_close(other.force(node), first.force(node), 1e-8);
        }
        assert_close(other.moment("B"), first.moment("B"), 1e-7);
    }
    let (force, moment) = first.imbalance(&[("R", [-6.0, 4.0, 5.0], [0.0; 3])]);
    assert!(force < 1e-8 && moment < 1e-6, "{force} {moment}");
}

/// Motions prescribed at two points of a body that its length cannot follow are no equilibrium.
#[test]
fn motions_that_would_stretch_a_body_are_not_believed() {
    let solved = attempt(&rod(r#"
        [nodes]
        A = [0, 0, 0]
        P = [60, 0, 0]
        Q = [100, 0, 0]
        [members]
        beam = { nodes = ["A", "P"], section = "rod" }
        [rigid_bodies]
        arm = { nodes = ["P", "Q"] }
        [supports]
        A = "clamped"
        [[steps]]
        displacement = { P = { ux = -1 }, Q = { ux = 4 } }
    "#));
    if let Ok(solved) = solved {
        let end = solved.history.steps[0].increments.last();
        assert!(
            solved.history.steps[0].status != pennate_solver::history::Status::Converged,
            "{:?}",
            end.map(|increment| increment.state.nodes[2].displacement)
        );
    }
}

// Mechanisms.

#[test]
fn mechanisms_are_named_with_node_and_direction() {
    use pennate_solver::error::Place;
    // A pinned bar on one pinned support swings.
    let found = places(attempt(&rod(r#"
        [nodes]
        A = [0, 0]
        B = [60, 0]
        C = [120, 0]
        [members]
        first = { nodes = ["A", "B"], section = "round" }
        second = { nodes = ["B", "C"], section = "round", release = { start = "pin" } }
        [supports]
        A = "clamped"
        [[steps]]
        force = { C = [1, 0] }
    "#)));
    assert_eq!(found.len(), 1);
    let (place, direction, turns) = found[0];
    assert_eq!((place, turns), (Place::Node(2), false));
    assert_close(direction.abs(), [0.0, 1.0, 0.0], 1e-6);

    // A loose body.
    let found = places(attempt(&rod(r#"
        [nodes]
        A = [0, 0, 0]
        P = [60, 0, 0]
        Q = [60, 40, 0]
        [members]
        beam = { nodes = ["A", "P"], section = "round", release = { end = { hinge = [0, 1, 0] } } }
        [rigid_bodies]
        arm = { nodes = ["P", "Q"] }
        [supports]
        A = "clamped"
        [[steps]]
        force = { Q = [0, 0, 1] }
    "#)));
    assert_eq!(found.len(), 1);
    let (place, direction, turns) = found[0];
    assert!(matches!(place, Place::Node(1 | 2)) && turns, "{place:?}");
    assert_close(direction.abs(), [0.0, 1.0, 0.0], 1e-6);
}

/// A straight line of members may spin unless something turns it.
#[test]
fn twist_that_nothing_takes_is_a_mechanism() {
    let found = places(attempt(&rod(r#"
        dimension = "space"
        [nodes]
        A = [0, 0, 0]
        B = [60, 0, 0]
        C = [120, 0, 0]
        [members]
        first = { nodes = ["A", "B"], section = "round", release = { start = ["rx"] } }
        second = { nodes = ["B", "C"], section = "round" }
        [supports]
        A = "clamped"
        [[steps]]
        moment = { C = [1, 0, 0] }
    "#)));
    assert_eq!(found.len(), 1);
    assert!(found[0].2);
    assert_close(found[0].1.abs(), [1.0, 0.0, 0.0], 1e-6);
}

/// Supports that hold one rotation of a joint of pinned ends have nothing to hold, in space as in the plane.
#[test]
fn rotation_held_where_there_is_none_has_no_effect() {
    for held in ["\"rz\"", "\"rx\", \"rz\"", "\"rx\", \"ry\", \"rz\""] {
        let solved = solve(&rod(&format!(
            r#"
            dimension = "space"
            [nodes]
            A = [0, 0, 0]
            J = [50, 30, 0]
            B = [100, 0, 0]
            [members]
            first = {{ nodes = ["A", "J"], section = "round", release = {{ end = "pin" }} }}
            second = {{ nodes = ["B", "J"], section = "round", release = {{ end = "pin" }} }}
            [supports]
            A = "clamped"
            B = "clamped"
            J = ["uz", {held}]
            [[steps]]
            force = {{ J = [0, -20, 0] }}
        "#
        )));
        assert_close(solved.moment("J"), [0.0; 3], 0.0);
        assert_near(solved.shift("J").x, 0.0, 1e-10);
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

/// A pin-ended column split at a node, as anyone would write it, loaded sideways.
#[test]
fn pinned_column_of_two_members_is_no_mechanism() {
    let column = |members: &str| {
        rod(&format!(
            r#"
        dimension = "space"
        [nodes]
        A = [0, 0, 0]
        M = [30, 0, 0]
        B = [60, 0, 0]
        [members]
        {members}
        [supports]
        A = "pinned"
        B = ["uy", "uz"]
        [[steps]]
        force = {{ M = [0, -2, 0], B = [0.5, 0, 0] }}
    "#
        ))
    };
    let solved = solve(&column(
        "a = { nodes = [\"A\", \"M\"], section = \"round\" }\nb = { nodes = [\"M\", \"B\"], section = \"round\" }",
    ));
    assert_near(solved.force("A").y, 1.0, 1e-9);
}
