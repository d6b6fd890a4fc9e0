//! Networks that can move without force, and some that only seem to.

use pennate_testing::network::{assert_close, assert_near, attempt, places, rod, solve};

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
