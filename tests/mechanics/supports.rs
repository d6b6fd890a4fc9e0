//! Supports: in turned axes, on bodies, of some rotations.

use pennate_testing::network::{self, Vector, assert_close, assert_near, rod, solve, solve_finely};

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
        // was hard to find under loads without a potential, or was extrapolated from beyond a singular point, is looked at half way and made
        // again in two parts.
        let enough = if held == "\"rx\"" {
            assert_close(solved.shift("B"), [-35.371033, 27.844493, 38.119512], 1e-5);
            105
        } else {
            80
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
