//! Every wrong input ends with a message that a person can act on: what, where, and what would help.

use pennate_models::{InputErrors, read_text};
use pennate_solver::structure::Formulation;

/// A network that is right; the cases below replace one line of it.
const GOOD: &str = r#"format = "pennate/1"
[parameters]
L = 130
[nodes]
A = [0, 0]
B = ["= L", 0]
C = ["= L", 50]
[materials]
abs = { youngs_modulus = 2200, poissons_ratio = 0.3 }
[sections]
strut = { circle = { radius = 1.5 } }
tube = { annulus = { outer_radius = 6, wall = 2 } }
[muscles.silicone]
diameter = 13
wall = 2.0
pressure_unit = "psi"
table = [
  { pressure = 10, E = 3.60, alpha = -9.135e-3, R1 = 6.80, R2 = 7.90 },
  { pressure = 25, E = 4.25, alpha = -6.885e-3, R1 = 7.15, R2 = 8.90 },
]
[members]
left = { nodes = ["A", "B"], muscle = "silicone", group = "pair" }
bar = { nodes = ["B", "C"], section = "strut", material = "abs" }
[supports]
A = "clamped"
[[steps]]
name = "inflate"
pressure = { left = 25 }
[probes]
x = { node = "B", displacement = "ux" }
"#;

fn errors(old: &str, new: &str) -> InputErrors {
    let text = GOOD.replace(old, new);
    assert_ne!(text, GOOD, "{old}");
    match read_text("net.toml", &text, &[]) {
        Ok(_) => panic!("accepted: {new}"),
        Err(errors) => errors,
    }
}

/// The first error for a replacement: its message, line, column, and help.
#[track_caller]
fn case(old: &str, new: &str, message: &str, line: usize, column: usize, help: &str) {
    let errors = errors(old, new);
    let first = &errors.errors[0];
    assert!(first.message.contains(message), "message: {errors}");
    assert_eq!(
        errors.place(first).map(|(file, line, column)| (file.to_owned(), line, column)),
        Some(("net.toml".into(), line, column)),
        "{errors}"
    );
    assert!(first.help.as_deref().is_some_and(|text| text.contains(help)), "help: {errors}");
}

#[test]
fn the_network_of_these_tests_is_right() {
    let model = read_text("net.toml", GOOD, &[]).unwrap();
    assert!(model.warnings.is_empty());
}

#[test]
fn unknown_keys_name_the_nearest() {
    case(
        "section = \"strut\"",
        "sectoin = \"strut\"",
        "unknown key 'sectoin' in a member",
        23,
        29,
        "did you mean 'section'?",
    );
    case("[supports]", "[suports]", "unknown key 'suports' in a network file", 24, 2, "did you mean 'supports'?");
    case("wall = 2.0", "wal = 2.0", "unknown key 'wal' in a muscle", 15, 1, "did you mean 'wall'?");
    case("R1 = 6.80", "r1 = 6.80", "unknown key 'r1'", 18, 49, "did you mean 'R1'?");
    case(
        "displacement = \"ux\"",
        "displcement = \"ux\"",
        "unknown key 'displcement' in a probe",
        30,
        19,
        "'displacement'",
    );
    case("pressure = { left", "presure = { left", "unknown key 'presure' in a step", 28, 1, "did you mean 'pressure'?");
}

#[test]
fn unknown_names_show_what_is_defined() {
    case(
        "\"strut\", mat",
        "\"strutt\", mat",
        "member 'bar' refers to section 'strutt', which is not defined",
        23,
        39,
        "did you mean 'strut'?",
    );
    case(
        "\"A\", \"B\"",
        "\"A\", \"X\"",
        "member 'left' refers to node 'X', which is not defined",
        22,
        24,
        "known nodes: 'A', 'B', 'C'",
    );
    case("muscle = \"silicone\"", "muscle = \"latex\"", "member 'left' refers to muscle 'latex'", 22, 39, "'silicone'");
    case("material = \"abs\"", "material = \"steel\"", "member 'bar' refers to material 'steel'", 23, 59, "'abs'");
    case("A = \"clamped\"", "Z = \"clamped\"", "a support refers to node 'Z'", 25, 1, "'A'");
    case("A = \"clamped\"", "A = \"clampd\"", "'clampd' is not a support", 25, 5, "did you mean 'clamped'?");
    case("{ left = 25 }", "{ lefft = 25 }", "'lefft', which is no member or group", 28, 14, "did you mean 'left'?");
    case("node = \"B\"", "node = \"Bb\"", "probe 'x' refers to node 'Bb'", 30, 14, "'B'");
    case("displacement = \"ux\"", "displacement = \"vx\"", "'vx' is not one of", 30, 34, "'ux'");
}

#[test]
fn wrong_units_name_the_expected_kind() {
    case("{ left = 25 }", "{ left = \"25 mm\" }", "'25 mm' is a length", 28, 21, "change the unit");
    case(
        "C = [\"= L\", 50]",
        "C = [\"= L\", \"50 kPa\"]",
        "a length (mm, m, in, …) is expected",
        7,
        13,
        "change the unit",
    );
    case("radius = 1.5", "radius = \"1.5 furlong\"", "unknown unit 'furlong'", 11, 31, "a length");
    case("radius = 1.5", "radius = \"1.5\"", "the text '1.5' has no unit", 11, 31, "without quotes");
    case("radius = 1.5", "radius = \"L / 2\"", "'L / 2' is no quantity", 11, 31, "\"= L / 2\"");
    case("pressure_unit = \"psi\"", "pressure_unit = \"N\"", "'N' of muscle 'silicone' is a force", 16, 17, "psi");
    case("L = 130", "L = \"130 foo\"", "unknown unit 'foo'", 3, 5, "172 kPa");
}

#[test]
fn numbers_are_finite() {
    case("[0, 0]", "[0, nan]", "not a number", 5, 9, "finite");
    case("[0, 0]", "[-inf, 0]", "infinite", 5, 6, "finite");
    case("[0, 0]", "[0, 1e400]", "", 5, 9, "");
    case("[0, 0]", "[0, \"1e300 km\"]", "too large", 5, 9, "1e100");
    case("radius = 1.5", "radius = 0", "the radius of 'strut' is 0, it must be greater than zero", 11, 31, "positive");
    case("youngs_modulus = 2200", "youngs_modulus = -1", "Young's modulus of 'abs' is -1", 9, 26, "positive");
    // Its inverse would overflow.
    case("youngs_modulus = 2200", "youngs_modulus = 2e-309", "is 2e-309, which is too small", 9, 26, "1e-100");
    case(
        "poissons_ratio = 0.3",
        "poissons_ratio = 0.6",
        "Poisson's ratio of 'abs' is 0.6",
        9,
        49,
        "between -1 and 0.5",
    );
}

#[test]
fn expressions_show_what_fails() {
    case("[\"= L\", 0]", "[\"= L / (L - 130)\", 0]", "division by zero", 6, 9, "with L = 130");
    case("[\"= L\", 0]", "[\"= 2 * Lx\", 0]", "unknown parameter 'Lx'", 6, 13, "did you mean 'L'?");
    case("[\"= L\", 0]", "[\"= sqrt(-L)\", 0]", "sqrt has no finite value", 6, 9, "L = 130");
    case("[\"= L\", 0]", "[\"= (L\", 0]", "not closed", 6, 9, "for example");
    case("[\"= L\", 0]", "[\"= sinh(L)\", 0]", "unknown function 'sinh'", 6, 9, "for example");
    case("L = 130", "L = \"= M\"\nM = \"= L + 1\"", "depends on itself", 3, 5, "number");
    case("L = 130", "L = \"= 1 / 0\"", "division by zero", 3, 8, "");
    case("L = 130", "L = 130\npi = 3", "a parameter cannot be called 'pi'", 4, 1, "another name");
    case("L = 130", "L = \"= x@y\"", "a meaning in probes only", 3, 8, "parameters");
}

#[test]
fn settings_name_the_parameters() {
    let set = |name: &str, value: &str| read_text("net.toml", GOOD, &[(name.into(), value.into())]);
    assert_eq!(set("L", "100").unwrap().nodes[1].position[0], 100.0);
    assert_eq!(
        set("L", "1 in").unwrap_err().errors[0].message,
        "member 'left' is 25.4 long, too short for a muscle with two end segments of 13"
    );
    let unknown = &set("l", "3").unwrap_err().errors[0];
    assert_eq!((unknown.message.as_str(), unknown.span), ("there is no parameter 'l' to set", None));
    assert_eq!(unknown.help.as_deref(), Some("did you mean 'L'?"));
    for text in ["abc", "nan", "inf", "1 parsec", "= 1/0", "= x", ""] {
        let error = &set("L", text).unwrap_err().errors[0];
        assert!(error.span.is_none() && error.help.is_some(), "{error:?}");
    }
}

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
fn steps_act_on_something() {
    case("{ left = 25 }", "{ bar = 25 }", "member 'bar' has nothing that pressure could act on", 28, 14, "muscle");
    case(
        "pressure = { left = 25 }",
        "actuation = { left = 1 }",
        "member 'left' has nothing that actuation could act on",
        28,
        15,
        "strain = 0 counts",
    );
    case(
        "pressure = { left = 25 }",
        "actuation = { all = 1 }",
        "'all' holds no member that actuation could act on",
        28,
        15,
        "strain or curvature",
    );
    case(
        "{ left = 25 }",
        "{ pair = 30 }",
        "the pressure 30 psi of member 'left' is beyond the table of muscle 'silicone', which ends at 25 psi",
        28,
        21,
        "within 0 and 25 psi",
    );
    case("{ left = 25 }", "{ all = -1 }", "is negative", 28, 20, "within 0 and 25");
    case("pressure = { left = 25 }", "gravity = [0, -9810]", "gravity acts on nothing", 28, 11, "density");
    case(
        "pressure = { left = 25 }",
        "force = { X = [1, 0] }",
        "force of step 'inflate' refers to node 'X'",
        28,
        11,
        "'A'",
    );
    case(
        "pressure = { left = 25 }",
        "free = { B = [\"ux\"] }",
        "frees ux of node 'B', which nothing holds",
        28,
        14,
        "support",
    );
    let twice = "displacement = { B = { ux = 1 } }\nhold = { B = [\"ux\"] }";
    case(
        "pressure = { left = 25 }",
        twice,
        "changes ux of node 'B' twice, by displacement and by hold",
        29,
        14,
        "two steps",
    );
    case("pressure = { left = 25 }", "rotation = { B = { ux = 1 } }", "has the component 'ux'", 28, 25, "displacement");
    case("[probes]", "[[steps]]\nname = \"inflate\"\n[probes]", "two steps are called 'inflate'", 30, 8, "of its own");
    case("pressure = { left = 25 }", "moment = { C = [0, 1] }", "it needs three", 28, 16, "zeros");
}

#[test]
fn a_moment_needs_a_rotation() {
    let released = GOOD.replace("material = \"abs\" }", "material = \"abs\", release = { end = \"pin\" } }");
    for load in ["moment = { C = [0, 0, 1] }", "follower_moment = { C = [0, 0, 1] }", "rotation = { C = [0, 0, 1] }"] {
        let text = released.replace("pressure = { left = 25 }", load);
        let error = &read_text("net.toml", &text, &[]).unwrap_err().errors[0];
        assert!(error.message.contains("all ends there are released"), "{error:?}");
        assert!(error.help.as_deref().unwrap().contains("weld"));
    }
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
fn probes_ask_for_one_thing() {
    case(
        "displacement = \"ux\"",
        "displacement = \"rx\"",
        "asks for the displacement 'rx'",
        30,
        34,
        "rotation = \"rx\"",
    );
    case(", displacement = \"ux\"", "", "does not ask for one quantity of one thing", 30, 5, "displacement");
    case("[probes]", "[probes]\ny = \"= z\"", "probe 'y' refers to 'z'", 30, 8, "names");
    case("[probes]", "[probes]\ny = \"= x@later\"", "refers to step 'later'", 30, 8, "'inflate'");
    case("[probes]", "[probes]\ny = \"= z\"\nz = \"= y\"", "probe 'y' depends on itself", 30, 5, "measure");
    case("[probes]", "[probes]\ny = \"x\"", "is no expression", 30, 5, "\"= x\"");
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
fn a_stop_belongs_to_an_arc_length_and_names_one_thing() {
    let stop = "name = \"inflate\"\nstop = { node = \"B\", displacement = \"uy\", at = -60 }";
    case("name = \"inflate\"", stop, "stop belongs to a step along the arc length", 28, 8, "arc_length");
    let both = "name = \"inflate\"\nmethod = \"arc_length\"\nstop = { fraction = 0.5, increments = 10 }";
    case("name = \"inflate\"", both, "a stop names one thing", 29, 8, "fraction = 0.8");
    let node = "name = \"inflate\"\nmethod = \"arc_length\"\nstop = { node = \"Q\", displacement = \"uy\", at = 1 }";
    case("name = \"inflate\"", node, "'Q'", 29, 17, "node");
    let word = "name = \"inflate\"\nmethod = \"arclength\"";
    case("name = \"inflate\"", word, "arclength", 28, 10, "arc_length");
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
fn several_errors_come_at_once() {
    let text = GOOD.replace("section = \"strut\"", "section = \"strat\"").replace("{ left = 25 }", "{ left = 99 }");
    let errors = read_text("net.toml", &text, &[]).unwrap_err();
    assert_eq!(errors.errors.len(), 2, "{errors}");
}

#[test]
fn missing_files_are_no_panic() {
    let errors = pennate_models::read("/nowhere/net.toml".as_ref(), &[]).unwrap_err();
    assert!(errors.errors[0].message.contains("/nowhere/net.toml cannot be read"));
    let text = GOOD.replace("[members]", "[muscles.other]\nfile = \"nowhere.toml\"\n[members]");
    let errors = read_text("net.toml", &text, &[]).unwrap_err();
    assert!(errors.errors[0].message.contains("the file 'nowhere.toml' of muscle 'other' cannot be read"), "{errors}");
    assert_eq!(errors.place(&errors.errors[0]).unwrap().1, 22);
}

#[test]
fn a_muscle_that_the_library_lacks_is_named_with_those_it_has() {
    let with = |line: &str| errors("[members]", &format!("[muscles.other]\n{line}\n[members]"));
    let unknown = with("library = \"silicon\"");
    let first = &unknown.errors[0];
    assert!(first.message.contains("'silicon', which is not in the library"), "{unknown}");
    assert!(first.help.as_deref().is_some_and(|help| help.contains("did you mean 'silicone'?")), "{unknown}");
    assert_eq!(unknown.place(first).map(|(_, line, _)| line), Some(22), "{unknown}");
    let twice = with("library = \"latex\"\nwall = 2");
    assert!(twice.errors[0].message.contains("both a library and data of its own"), "{twice}");
    let both = with("library = \"latex\"\nfile = \"m.toml\"");
    assert!(both.errors[0].message.contains("both a file and a name of the library"), "{both}");
}

/// Units of parameters are checked where they are used, as those of texts in place are.
#[test]
fn units_of_parameters_are_checked_where_they_are_used() {
    let with = |parameter: &str, old: &str, new: &str| {
        let text = GOOD.replace("L = 130", &format!("L = 130\n{parameter}")).replace(old, new);
        read_text("net.toml", &text, &[])
    };
    let refused = |parameter: &str, old: &str, new: &str, message: &str| {
        let errors = with(parameter, old, new).map(|_| ()).unwrap_err();
        assert!(errors.errors[0].message.contains(message), "{errors}");
        assert!(errors.place(&errors.errors[0]).is_some() && errors.errors[0].help.is_some(), "{errors}");
    };
    refused("r = \"3 N\"", "radius = 1.5", "radius = \"= r\"", "'= r' is a force (N, kN, lbf, …); a length");
    refused("p = \"20 deg\"", "left = 25", "left = \"= p\"", "'= p' is an angle (deg, rad, …); a pressure");
    refused("p = \"10 psi\"", "left = 25", "left = \"= p + 10\"", "adds a bare number to a pressure");
    refused("p = \"10 psi\"", "left = 25", "left = \"= max(p, 10)\"", "adds a bare number to a pressure");
    refused("r = \"3 N\"", "radius = 1.5", "radius = \"= r + L\"", "'= r + L' is a force");
    refused("r = \"3 N\"\nd = \"1 mm\"", "radius = 1.5", "radius = \"= r + d\"", "is added to");
    refused("r = \"3 N\"", "radius = 1.5", "radius = \"= sin(r)\"", "sin takes an angle");
    refused("n = 5", "material = \"abs\"", "material = \"abs\", elements = \"= n / 2\"", "is 2.5; a whole number");
    // A factor may be anything, and a bare parameter too.
    for (parameter, old, new) in [
        ("E = \"2 GPa\"\nA = 3", "circle = { radius = 1.5 }", "stiffness = { EA = \"= E * A\", EI3 = 2, GA2 = 3 }"),
        ("r = \"3 mm\"", "radius = 1.5", "radius = \"= r / 2\""),
        ("p = \"10 psi\"\ndp = \"5 psi\"", "left = 25", "left = \"= 2 * p + dp\""),
        ("p = \"10 psi\"", "left = 25", "left = \"= max(p, 0)\""),
        ("a = \"3 %\"", "radius = 1.5", "radius = \"= a * L\""),
        ("b = \"0.5 rad\"", "B = [\"= L\"", "B = [\"= L * cos(b) + 20 * b\""),
    ] {
        let model = with(parameter, old, new).unwrap_or_else(|errors| panic!("{errors}"));
        let about_units = model.warnings.iter().any(|warning| warning.message.contains("expected"));
        assert!(!about_units, "{:?}", model.warnings);
    }
    let model = with("r = \"3 N\"", "radius = 1.5", "radius = \"= 2 * r\"").unwrap();
    assert!(model.warnings[0].message.contains("'= 2 * r' is a force"), "{:?}", model.warnings);
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

/// Nothing of this is an error, and hardly any of it is meant.
#[test]
fn odd_muscles_and_magnitudes_get_a_word() {
    let word = |old: &str, new: &str, message: &str| {
        let text = GOOD.replace(old, new);
        assert_ne!(text, GOOD, "{old}");
        let model = read_text("net.toml", &text, &[]).unwrap_or_else(|errors| panic!("{errors}"));
        let found = model.warnings.iter().find(|warning| warning.message.contains(message));
        let found = found.unwrap_or_else(|| panic!("{message}: {:?}", model.warnings));
        assert!(found.span.is_some() && found.help.is_some(), "{found:?}");
    };
    word("pressure_unit = \"psi\"\n", "", "muscle 'silicone' has no pressure_unit");
    word("alpha = -9.135e-3", "alpha = 9.135e-3", "gets longer under pressure");
    word("R2 = 8.90", "R2 = 17.8", "R2 of muscle 'silicone' is 17.8, more than its undeformed diameter");
    word("youngs_modulus = 2200", "youngs_modulus = 2.2e9", "far stiffer than diamond");
    word("poissons_ratio = 0.3", "poissons_ratio = 0.3, density = 1040", "heavier than any metal");
    word("radius = 1.5", "radius = 0.00015", "thin as a hair");
    word("radius = 1.5", "radius = 1500", "a disc rather than a bar");
    let weight = "pressure = { left = 25 }\ngravity = [0, -9.81, 0]";
    let text = GOOD.replace("poissons_ratio = 0.3", "poissons_ratio = 0.3, density = 1e-9");
    let text = text.replace("pressure = { left = 25 }", weight);
    let model = read_text("net.toml", &text, &[]).unwrap();
    assert!(model.warnings[0].message.contains("the Earth's is 9810 mm/s^2"), "{:?}", model.warnings);
}

#[test]
fn one_step_in_single_brackets_hints_at_two() {
    case("[[steps]]", "[steps]", "'steps' is a list", 26, 2, "[[steps]]");
}

/// Stresses need a shape; a probe of them is one of a member, a group or all.
#[test]
fn stresses_need_a_shape() {
    let probe = "x = { node = \"B\", displacement = \"ux\" }";
    let stress = "x = { member = \"bar\", stress = \"max\" }";
    let text = GOOD.replace(probe, stress);
    assert!(read_text("net.toml", &text, &[]).is_ok());
    let given = text.replace("circle = { radius = 1.5 }", "stiffness = { EA = 1, EI3 = 2, GA2 = 3 }");
    let errors = read_text("net.toml", &given, &[]).unwrap_err();
    assert!(errors.errors[0].message.contains("whose section gives stiffnesses outright"), "{errors}");
    case(probe, "x = { member = \"bars\", stress = \"max\" }", "refers to member 'bars'", 30, 16, "bar");
    case(probe, "x = { node = \"B\", stress = \"max\" }", "does not ask for one quantity", 30, 5, "stress");
    case(probe, "x = { member = \"bar\", stress = \"least\" }", "'least' is not one of max, bending", 30, 32, "max");
}
