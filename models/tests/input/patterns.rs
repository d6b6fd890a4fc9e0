//! Copies are the original, moved as a rigid body.

use nalgebra::{Rotation3, Vector3};
use pennate_models::{Model, read_text, scenes};
use pennate_solver::structure::Release;

/// One curved, one straight and one hinged member.
const ORIGINAL: &str = r#"format = "pennate/1"
[parameters]
turn = 40
[nodes]
A = [10, 0, 0]
B = [10, 0, 30]
C = [20, 5, 30]
[materials]
steel = { youngs_modulus = 2e5, poissons_ratio = 0.3 }
[sections]
strip = { rectangle = { width = 3, height = 1 } }
[members]
post = { nodes = ["A", "B"], section = "strip", material = "steel", group = "all of them" }
bow = { nodes = ["B", "C"], section = "strip", material = "steel", arc = [13, 6, 33] }
door = { nodes = ["A", "C"], section = "strip", material = "steel", release = { end = { hinge = [0, 1, 1] } } }
[supports]
A = "clamped"
"#;

fn model(text: &str) -> Model {
    read_text("net.toml", text, &[]).unwrap_or_else(|errors| panic!("{errors}"))
}

#[track_caller]
fn near(a: [f64; 3], b: Vector3<f64>) {
    assert!((Vector3::from(a) - b).norm() < 1e-12 * (1.0 + b.norm()), "{a:?} is not {b:?}");
}

#[test]
fn copies_are_moved_as_rigid_bodies() {
    let pattern = "[[patterns]]\ncount = 3\ntranslation = [1, 2, 3]\nsupports = true\n\
                   rotation = { angle = \"= turn\", axis = [1, 1, 0], point = [0, 0, 5] }\n";
    let model = model(&format!("{ORIGINAL}{pattern}"));
    assert_eq!((model.nodes.len(), model.members.len(), model.supports.len()), (9, 9, 3));
    let turn =
        Rotation3::from_axis_angle(&nalgebra::Unit::new_normalize(Vector3::new(1.0, 1.0, 0.0)), 40_f64.to_radians());
    let centre = Vector3::new(0.0, 0.0, 5.0);
    let step = |place: Vector3<f64>| turn * (place - centre) + centre + Vector3::new(1.0, 2.0, 3.0);
    for index in 0..3 {
        let mut place = Vector3::from(model.nodes[index].position);
        let member = &model.members[index];
        let mut rotation = Rotation3::identity();
        for copy in 1..3 {
            place = step(place);
            rotation = turn * rotation;
            near(model.nodes[3 * copy + index].position, place);
            let copied = &model.members[3 * copy + index];
            assert_eq!(copied.name, format!("{}-{}", member.name, copy + 1));
            assert!((copied.length - member.length).abs() < 1e-12);
            assert_eq!(copied.group, member.group);
            for axis in 0..3 {
                near(copied.axes[axis], rotation * Vector3::from(member.axes[axis]));
            }
            for (segment, original) in copied.segments.iter().zip(&member.segments) {
                near(segment.initial_curvature, Vector3::from(original.initial_curvature));
            }
            if let (Release::Axes(axes), Release::Axes(original)) = (&copied.releases[1], &member.releases[1]) {
                near(axes[0], rotation * Vector3::from(original[0]));
            }
        }
    }
    assert!(matches!(model.members[8].releases[1], Release::Axes(_)));
}

/// Six chords of 60 degrees close a hexagon: the last ends where the first begins.
#[test]
fn a_ring_closes() {
    let text = r#"format = "pennate/1"
        nodes = { A = [10, 0, 0], B = [5, 8.660254037844386, 0] }
        materials.m = { youngs_modulus = 1, poissons_ratio = 0.3 }
        sections.s = { circle = { radius = 1 } }
        members.side = { nodes = ["A", "B"], section = "s", material = "m" }
        supports.A = "clamped"
        patterns = [{ count = 6, rotation = { angle = 60 } }]"#;
    let model = model(text);
    assert_eq!((model.nodes.len(), model.members.len()), (6, 6));
    assert_eq!(model.members[5].nodes, [5, 0]);
}

#[test]
fn bodies_that_share_a_node_become_one_and_their_masses_add() {
    let text = r#"format = "pennate/1"
        nodes = { A = [0, 0, 0], B = [0, 0, 10], a = [1, 0, 0], b = [1, 0, 10] }
        materials.m = { youngs_modulus = 1, poissons_ratio = 0.3 }
        sections.s = { circle = { radius = 1 } }
        members.bar = { nodes = ["a", "b"], section = "s", material = "m" }
        rigid_bodies.low = { nodes = ["A", "a"], mass = 1 }
        rigid_bodies.high = { nodes = ["B", "b"], mass = 2 }
        supports.A = "clamped"
        [[patterns]]
        count = 3
        translation = [0, 0, 10]
        rotation = { angle = 90 }"#;
    let model = model(text);
    let names: Vec<&str> = model.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["low", "high", "high-2", "high-3"]);
    assert_eq!(model.bodies.iter().map(|body| body.mass).collect::<Vec<_>>(), [1.0, 3.0, 3.0, 2.0]);
    assert_eq!(model.bodies.iter().map(|body| body.nodes.len()).collect::<Vec<_>>(), [2, 3, 3, 2]);
    let reference = |body: usize| model.nodes[model.bodies[body].reference].position;
    near(reference(3), Vector3::new(0.0, 0.0, 30.0));
}

/// A column on the axis of a turn, a plate about it and a spring under it are there once, however often the legs about them are; so is a
/// leg that a count too many turns onto the first.
#[test]
fn what_falls_on_itself_is_there_once() {
    let text = |count: usize| {
        format!(
            r#"format = "pennate/1"
            nodes = {{ O = [0, 0, 0], T = [0, 0, 100], P = [50, 0, 100] }}
            materials.m = {{ youngs_modulus = 1e3, poissons_ratio = 0.3 }}
            sections.s = {{ circle = {{ radius = 3 }} }}
            members.column = {{ nodes = ["O", "T"], section = "s", material = "m" }}
            members.arm = {{ nodes = ["T", "P"], section = "s", material = "m" }}
            rigid_bodies.cap = {{ nodes = ["P"], reference = "T", mass = "60 g" }}
            springs.foot = {{ nodes = ["O", "T"], stiffness = 3 }}
            supports.O = "clamped"
            [[patterns]]
            count = {count}
            rotation = {{ angle = 120 }}"#
        )
    };
    for count in [3, 4, 7] {
        let model = model(&text(count));
        let names: Vec<&str> = model.members.iter().map(|member| member.name.as_str()).collect();
        assert_eq!(names, ["column", "arm", "arm-2", "arm-3"], "{count}");
        assert_eq!((model.nodes.len(), model.springs.len(), model.bodies.len()), (5, 1, 1));
        assert!((model.bodies[0].mass - 6e-5).abs() < 1e-15 && model.warnings.is_empty());
        assert_eq!(model.bodies[0].nodes.len(), 4);
    }
}

/// A cell whose left side falls on the right side of the one before has both, and a word about it; curved ones lie on each other where
/// they go through one point.
#[test]
fn copies_that_lie_on_other_members_are_named() {
    for (arcs, warned) in
        [(["", ""], true), ([", arc = [-1, 5]", ", arc = [9, 5]"], true), (["", ", arc = [9, 5]"], false)]
    {
        let text = format!(
            r#"format = "pennate/1"
            nodes = {{ A = [0, 0], B = [0, 10], C = [10, 0], D = [10, 10] }}
            materials.m = {{ youngs_modulus = 1e3, poissons_ratio = 0.3 }}
            sections.s = {{ circle = {{ radius = 1 }} }}
            members.left = {{ nodes = ["A", "B"], section = "s", material = "m"{} }}
            members.right = {{ nodes = ["D", "C"], section = "s", material = "m"{} }}
            members.top = {{ nodes = ["B", "D"], section = "s", material = "m" }}
            supports.A = "clamped"
            [[patterns]]
            count = 3
            translation = [10, 0]"#,
            arcs[0], arcs[1]
        );
        let model = model(&text);
        assert_eq!(model.members.len(), 9);
        let said: Vec<&str> = model.warnings.iter().map(|warning| warning.message.as_str()).collect();
        let word =
            "a copy of member 'left' lies on member 'right', between the same nodes, and so do 1 more: both count";
        assert_eq!(said, if warned { vec![word] } else { vec![] }, "{arcs:?}");
    }
}

/// A bar turned end for end is the same bar where both of its ends are alike.
#[test]
fn a_bar_turned_end_for_end_is_there_once_if_its_ends_are_alike() {
    for (release, count) in [("", 1), (", release = { start = \"pin\" }", 2)] {
        let model = model(&format!(
            r#"format = "pennate/1"
            nodes = {{ A = [0, 0], B = [10, 0] }}
            materials.m = {{ youngs_modulus = 1e3, poissons_ratio = 0.3 }}
            sections.s = {{ circle = {{ radius = 1 }} }}
            members.bar = {{ nodes = ["A", "B"], section = "s", material = "m"{release} }}
            supports.A = "clamped"
            [[patterns]]
            count = 2
            rotation = {{ angle = 180, point = [5, 0, 0] }}"#
        ));
        assert_eq!((model.members.len(), model.warnings.len()), (count, count - 1));
    }
}

/// Of the two nodes of a hinge that a spring joins each copy has two, and a bar that is turned about one stays on that one.
#[test]
fn nodes_at_one_place_stay_two() {
    let text = |pattern: &str| {
        format!(
            r#"format = "pennate/1"
            nodes = {{ A = [0, 0], J = [50, 0], K = [50, 0], B = [100, 0] }}
            materials.m = {{ youngs_modulus = 1e3, poissons_ratio = 0.3 }}
            sections.s = {{ circle = {{ radius = 1 }} }}
            members.a = {{ nodes = ["A", "J"], section = "s", material = "m" }}
            members.b = {{ nodes = ["K", "B"], section = "s", material = "m" }}
            springs.k = {{ nodes = ["J", "K"], stiffness = {{ ux = 1000, uy = 1000, rz = 100 }} }}
            supports.A = "clamped"
            [[patterns]]
            {pattern}"#
        )
    };
    let row = model(&text("count = 3\ntranslation = [0, 50]\nsupports = true"));
    assert_eq!((row.nodes.len(), row.members.len(), row.springs.len()), (12, 6, 3));
    let name = |node: usize| row.nodes[node].name.as_str();
    assert_eq!([2, 3].map(|member: usize| row.members[member].nodes.map(name)), [["A-2", "J-2"], ["K-2", "B-2"]]);
    let star = model(&text("count = 3\nmembers = [\"b\"]\nrotation = { angle = 120, point = [50, 0, 0] }"));
    let name = |node: usize| star.nodes[node].name.as_str();
    assert_eq!([2, 3].map(|member: usize| star.members[member].nodes.map(name)), [["K", "B-2"], ["K", "B-3"]]);
    // Here both would become what is one node there.
    let errors =
        read_text("net.toml", &text("count = 2\nmembers = [\"a\", \"b\"]\ntranslation = [-50, 0]"), &[]).unwrap_err();
    let message = &errors.errors[0].message;
    assert_eq!(message, "nodes 'J' and 'K' of a pattern both fall on node 'A' in copy 2");
}

/// Bodies that become one keep their masses where these are, or are refused.
#[test]
fn masses_of_bodies_that_become_one_stay_where_they_are() {
    let text = |reference: &str, mass: &str| {
        format!(
            r#"format = "pennate/1"
            nodes = {{ A = [0, 0], B = [100, 0], C = [120, 0], R = [110, 0] }}
            materials.m = {{ youngs_modulus = 1e3, poissons_ratio = 0.3 }}
            sections.s = {{ circle = {{ radius = 1 }} }}
            members.b = {{ nodes = ["A", "B"], section = "s", material = "m" }}
            rigid_bodies.p = {{ nodes = ["B", "C"], reference = "{reference}"{mass} }}
            supports.A = "clamped"
            [[patterns]]
            count = 2
            translation = [20, 0]"#
        )
    };
    let errors = read_text("net.toml", &text("R", ", mass = \"10 g\""), &[]).unwrap_err();
    assert!(errors.errors[0].message.contains("their references, where masses are, lie apart"), "{errors}");
    assert_eq!(model(&text("R", "")).bodies.len(), 1);
}

#[test]
fn named_members_and_groups_are_copied_alone() {
    let pattern = "[[patterns]]\ncount = 2\nmembers = [\"post\"]\ntranslation = [0, 0, 30]\n";
    let model = model(&format!("{ORIGINAL}{pattern}"));
    // The copy of A falls on B.
    assert_eq!((model.nodes.len(), model.members.len()), (4, 4));
    assert_eq!(model.members[3].nodes, [1, 3]);
}

#[test]
fn patterns_multiply() {
    let patterns = "[[patterns]]\ncount = 4\ntranslation = [0, 100, 0]\nsupports = true\n\
                    [[patterns]]\ncount = 5\ntranslation = [100, 0, 0]\nsupports = true\n";
    let model = model(&format!("{ORIGINAL}{patterns}"));
    assert_eq!((model.nodes.len(), model.members.len(), model.supports.len()), (60, 60, 20));
    assert_eq!(model.members[59].name, "door-4-5");
    assert_eq!(model.members[12].name, "post-1-2");
}

#[test]
fn patterns_that_cannot_be_are_refused() {
    for (pattern, message) in [
        ("count = 2", "neither moves nor turns"),
        ("translation = [1, 0, 0]", "needs the key 'count'"),
        ("count = 2\ntranslation = [0, 0, 0]", "neither moves nor turns"),
        ("count = 2\ntranslation = [1, 0, 0]\nmembers = [\"pots\"]", "repeats 'pots', which is no member"),
        ("count = 900000\ntranslation = [1, 0, 0]", "more than 100000 nodes, members and other parts"),
        ("count = 2\nrotation = { angel = 2 }", "unknown key 'angel'"),
        ("count = 2\nrotation = { angle = 2, axis = [0, 0, 0] }", "points nowhere"),
        ("count = 2\ntranslation = [1, 0, 0]\nmerge = -1", "must not be negative"),
        (
            "count = 2\ntranslation = [100, 0, 0]\n[[patterns]]\ncount = 2\ntranslation = [0, 0, 90]\n[members.post-2]\nnodes = [\"A\", \"C\"]",
            "a second member 'post-2'",
        ),
    ] {
        let errors = read_text("net.toml", &format!("{ORIGINAL}[[patterns]]\n{pattern}\n"), &[]).unwrap_err();
        assert!(errors.to_string().contains(message), "{pattern}: {errors}");
        assert!(errors.errors[0].span.is_some() && errors.errors[0].help.is_some(), "{errors}");
    }
}

/// The last ring of the spiral sits on the axis, turned by its cells; the file is a page.
#[test]
fn the_spiral_gripper_is_a_page() {
    let text = scenes::write("spiral", &[]).unwrap();
    assert!(text.lines().count() < 110, "{}", text.lines().count());
    let model = model(&text);
    let muscles = model.members.iter().filter(|member| member.is_muscle()).count();
    assert_eq!((muscles, model.members.len(), model.bodies.len()), (288, 504, 37));
    let top = &model.bodies[36];
    near(model.nodes[top.reference].position, Vector3::new(0.0, 0.0, 3600.0));
}
