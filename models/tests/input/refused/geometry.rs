//! Nodes, members and what holds them.

use pennate_models::read_text;
use pennate_solver::structure::Formulation;

use super::{GOOD, case};

#[test]
fn geometry_must_be_possible() {
    case("C = [\"= L\", 50]", "C = [\"= L\", 0]", "member 'bar' has zero length", 23, 17, "move one of the nodes");
    case("[\"B\", \"C\"]", "[\"B\", \"B\"]", "member 'bar' starts and ends at node 'B'", 23, 17, "two different nodes");
    case(
        "C = [\"= L\", 50]",
        "C = [\"= L\", 50]\nD = [0, 0]",
        "nodes 'A' and 'D' are at one place",
        8,
        1,
        "a spring or a rigid body",
    );
    case(
        "material = \"abs\" }",
        "material = \"abs\", orientation = [0, 2] }",
        "the orientation of member 'bar' is along its axis",
        23,
        80,
        "axis 2",
    );
    case(
        "material = \"abs\" }",
        "material = \"abs\", orientation = [0, 0] }",
        "is zero and points nowhere",
        23,
        80,
        "direction",
    );
    case("wall = 2 }", "wall = 6 }", "the inner radius of section 'tube' is 0", 12, 47, "thinner");
    case("R1 = 6.80", "R1 = 1.80", "the inner radius of muscle 'silicone' (R1) is", 18, 54, "thinner");
    case("wall = 2.0", "wall = 7", "the inner radius of muscle 'silicone'", 15, 8, "thinner");
    case("L = 130", "L = 26", "too short for a muscle", 22, 1, "end_length");
    case("material = \"abs\" }", "material = \"abs\", arc = [130, 20] }", "three points in one line", 23, 72, "beside");
    case(
        "material = \"abs\" }",
        "material = \"abs\", length = 51 }",
        "is 50 long between its nodes, not 51",
        23,
        75,
        "leave length out",
    );
    let curved = "material = \"abs\", length = 51, tangent = [1, 1], initial_curvature = [0, 0, 0.01] }";
    case("material = \"abs\" }", curved, "does not meet its end node", 23, 89, "move the end node");
    case(
        "material = \"abs\" }",
        "material = \"abs\", length = 51, initial_curvature = [0, 0, 1] }",
        "no tangent",
        23,
        1,
        "add tangent",
    );
    case(
        "material = \"abs\" }",
        "material = \"abs\", tangent = [0, 1], initial_curvature = [0, 0, 1] }",
        "no length",
        23,
        1,
        "add length",
    );
    let segments = "segments = [{ length = 20, section = \"strut\", material = \"abs\" }, { length = 20, section = \"strut\", material = \"abs\" }] }";
    case(
        "section = \"strut\", material = \"abs\" }",
        segments,
        "the segments of member 'bar' sum to 40, but it is 50 long",
        23,
        40,
        "by 10 in all",
    );
}

#[test]
fn definitions_must_be_complete() {
    case(
        ", poissons_ratio = 0.3",
        "",
        "material 'abs' needs poissons_ratio or shear_modulus",
        9,
        1,
        "poissons_ratio = 0.3",
    );
    case("wall = 2.0\n", "", "muscle 'silicone' needs the key 'wall'", 13, 10, "table");
    case(", R2 = 7.90", "", "a row of a muscle's table needs the key 'R2'", 18, 3, "add R2");
    case("pressure = 25, E", "pressure = 5, E", "do not increase: 5 follows 10", 19, 16, "increasing");
    case(", material = \"abs\"", "", "member 'bar' has section 'strut' but no material", 23, 39, "'abs'");
    case(
        "section = \"strut\", material = \"abs\"",
        "group = \"x\"",
        "member 'bar' is made of nothing",
        23,
        1,
        "muscle = ",
    );
    case("group = \"pair\"", "section = \"strut\"", "more than one of muscle, section, segments", 22, 1, "keep one");
    case("circle = { radius = 1.5 }", "shear = true", "section 'strut' needs exactly one of", 11, 1, "circle");
    case("circle = { radius = 1.5 }", "stiffness = { EI3 = 1 }", "needs 'EA'", 11, 23, "in the plane");
    case("group = \"pair\"", "group = \"bar\"", "the group 'bar' has the name of a member", 22, 59, "another name");
    case("nodes = [\"B\", \"C\"]", "nodes = [\"B\"]", "member 'bar' has 1 node(s)", 23, 17, "where it starts");
    case("format = \"pennate/1\"", "format = \"pennate/2\"", "'pennate/2' is not known", 1, 10, "pennate/1");
    case(
        "material = \"abs\" }",
        "material = \"abs\", elements = 2000000 }",
        "a whole number from 1 to 1000000",
        23,
        77,
        "write",
    );
    case("material = \"abs\" }", "material = \"abs\", order = 5 }", "order 5", 23, 74, "1, 2, 3 or 4");
    case("[0, 0]", "[0]", "node 'A' has 1 number(s)", 5, 5, "[x, y]");
    case("[0, 0]", "3", "a list is expected here, not a number", 5, 5, "a list");
    case("L = 130", "L = [", "this is not TOML", 5, 1, "quotes");
}

#[test]
fn everything_hangs_on_a_support() {
    case("A = \"clamped\"", "", "member 'left' hangs on no support", 22, 1, "[supports]");
    case(
        "C = [\"= L\", 50]",
        "C = [\"= L\", 50]\nD = [0, 9]",
        "node 'D' is in no member, spring or body and nothing holds it",
        8,
        1,
        "connect it",
    );
    let loaded = GOOD
        .replace("A = [0, 0]", "A = [0, 0]\nD = [0, 9]")
        .replace("A = \"clamped\"", "A = \"clamped\"\nD = \"pinned\"");
    let model = read_text("net.toml", &loaded, &[]).unwrap();
    assert!(model.warnings[0].message.contains("node 'D' is in no member"));
    let text = loaded.replace("pressure = { left = 25 }", "force = { D = [1, 0] }");
    assert!(read_text("net.toml", &text, &[]).unwrap_err().errors[0].message.contains("but a step loads or moves it"));
}

#[test]
fn joints_are_consistent() {
    let body = "[rigid_bodies]\nstage = { nodes = [\"C\", \"B\"], reference = \"B\" }\n[supports]\nC = [\"rz\"]";
    case(
        "[supports]",
        body,
        "the support of node 'C' holds a rotation, but the node turns with its rigid body",
        27,
        5,
        "reference 'B'",
    );
    case(
        "[supports]",
        "[rigid_bodies]\na = { nodes = [\"B\"] }\nb = { nodes = [\"B\"] }\n[supports]",
        "node 'B' is in two rigid bodies",
        26,
        1,
        "one body",
    );
    case(
        "[supports]",
        "[springs]\nk = { node = \"B\", stiffness = 3 }\n[supports]",
        "needs a stiffness for each component",
        25,
        31,
        "{ ux = 2.0",
    );
    case(
        "[supports]",
        "[springs]\nk = { nodes = [\"B\", \"B\"], stiffness = 3 }\n[supports]",
        "starts and ends at node 'B'",
        25,
        15,
        "different",
    );
    case(
        "[supports]",
        "[springs]\nk = { nodes = [\"B\", \"A\"], stiffness = -3 }\n[supports]",
        "must not be negative",
        25,
        39,
        "zero or",
    );
    case("A = \"clamped\"", "A = \"clamped\"\nB = []", "holds nothing", 26, 5, "pinned");
}

#[test]
fn corotational_elements_have_no_order() {
    let own = "material = \"abs\", order = 3, formulation = \"corotational\" }";
    case("material = \"abs\" }", own, "member 'bar' is corotational", 23, 74, "formulation = \"exact\"");
    let network = "format = \"pennate/1\"\nformulation = \"corotational\"";
    let both = GOOD.replace("format = \"pennate/1\"", network).replace("\"abs\" }", "\"abs\", order = 2 }");
    let errors = read_text("net.toml", &both, &[]).unwrap_err();
    assert!(errors.errors[0].message.contains("asks for elements of order 2"), "{errors}");
    // A member that says otherwise is free to have one.
    let exact = both.replace("order = 2", "order = 2, formulation = \"exact\"");
    let model = read_text("net.toml", &exact, &[]).unwrap();
    let orders: Vec<_> = model.members.iter().map(|member| (member.formulation, member.order(4))).collect();
    assert_eq!(orders, [(Formulation::Corotational, 1), (Formulation::Exact, 2)]);
    case("material = \"abs\" }", "material = \"abs\", formulation = \"fancy\" }", "fancy", 23, 80, "corotational");
}

#[test]
fn a_plane_network_stays_in_its_plane() {
    let plane = |change: &str, by: &str| {
        let text = GOOD.replace("[parameters]", "dimension = \"plane\"\n[parameters]").replace(change, by);
        read_text("net.toml", &text, &[])
    };
    assert!(plane("", "").is_ok());
    for (change, by, reason) in [
        ("C = [\"= L\", 50]", "C = [\"= L\", 50, 1]", "node 'C' has z = 1"),
        ("pressure = { left = 25 }", "force = { C = [0, 0, 1] }", "step 'inflate' has a force along z"),
        (
            "pressure = { left = 25 }",
            "displacement = { C = { uz = 1 } }",
            "step 'inflate' moves a node out of the plane",
        ),
        (
            "material = \"abs\" }",
            "material = \"abs\", release = { end = { hinge = [1, 0] } } }",
            "member 'bar' is hinged",
        ),
    ] {
        let errors = plane(change, by).unwrap_err();
        assert!(errors.errors[0].message.contains(reason), "{errors}");
        assert_eq!(errors.place(&errors.errors[0]).unwrap().1, 2);
    }
    let text = GOOD
        .replace("circle = { radius = 1.5 }", "stiffness = { EA = 1, EI3 = 1 }")
        .replace("C = [\"= L\", 50]", "C = [\"= L\", 50, 1]");
    let errors = read_text("net.toml", &text, &[]).unwrap_err();
    assert_eq!(errors.errors[0].message, "the section of member 'bar' needs EI2 and GJ: node 'C' has z = 1");
}

#[test]
fn paths_and_arcs_say_what_they_need() {
    let bar = "nodes = [\"B\", \"C\"], section";
    case(bar, "section", "member 'bar' needs the key 'nodes'", 23, 7, "path = ");
    case(bar, "path = [\"B\"], section", "the path of member 'bar' has 1 node(s)", 23, 16, "two nodes");
    case(bar, "path = [\"B\", \"B\"], section", "starts and ends at node 'B'", 23, 16, "two different nodes");
    case(bar, "path = [\"B\", \"X\"], section", "refers to node 'X'", 23, 22, "known nodes");
    case(bar, "path = [\"B\", \"C\"], arc = [0, 1], section", "has a path, and arc too", 23, 34, "straight");
    case(bar, "nodes = [\"B\", \"C\"], arc = { rise = 0 }, section", "has no rise", 23, 44, "leave arc out");
    case(bar, "nodes = [\"B\", \"C\"], arc = { height = 3 }, section", "unknown key 'height'", 23, 37, "rise");
}
