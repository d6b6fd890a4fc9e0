//! Steps and probes.

use pennate_models::read_text;

use super::{GOOD, case};

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
