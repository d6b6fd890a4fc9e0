//! Rigid bodies: levers, prescribed points, and the choice of a reference.

use pennate_testing::network::{Vector, assert_close, assert_near, attempt, rod, solve};

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
    // An increment that turns aside is made again shorter.
    assert!(solved.factorizations() < 60, "{}", solved.factorizations());
}

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
