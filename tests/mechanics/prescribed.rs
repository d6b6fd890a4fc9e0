//! Motions that steps prescribe, hold and set free.

use std::f64::consts::PI;

use pennate_testing::network::{Vector, assert_close, assert_near, rod, solve, solve_finely};

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
