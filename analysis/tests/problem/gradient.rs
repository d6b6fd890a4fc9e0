//! Derivatives against differences of converged solves.

use pennate_analysis::problem::{Problem, Reason};
use pennate_models::Document;

/// The derivatives of a network at its own values, against differences of fourth order of solves at three distances: the
/// nearest of them counts, since the longest are curved and the shortest rounding.
pub(crate) fn check(text: &str, parameters: &[&str], probes: &[&str]) {
    let document = Document::from_text("network.toml", text);
    let problem = Problem::new(&document, &[], parameters, probes, 1e-6).unwrap();
    check_at(&problem, &problem.middle(), probes);
}

/// The same at other values.
fn check_at(problem: &Problem, x: &[f64], probes: &[&str]) {
    check_within(problem, x, probes, 1e-8);
}

/// The same within another part of the largest derivative of a probe.
fn check_within(problem: &Problem, x: &[f64], probes: &[&str], within: f64) {
    let found = problem.gradient(x);
    assert!(found.reasons[0].is_none(), "{:?}", found.reasons);
    let (k, m) = (x.len(), probes.len());
    assert_eq!(found.jacobian.len(), k * m);
    let mut nearest = vec![f64::INFINITY; m * k];
    for part in [1e-2, 3e-3, 1e-3] {
        for input in 0..k {
            let apart = part * if x[input] == 0.0 { 1.0 } else { x[input] };
            let rows: Vec<f64> = [1.0, -1.0, 2.0, -2.0]
                .into_iter()
                .flat_map(|times| (0..k).map(move |j| (j, times)))
                .map(|(j, times)| if j == input { x[j] + times * apart } else { x[j] })
                .collect();
            let answer = problem.evaluate(&rows);
            assert!(answer.reasons.iter().all(Option::is_none), "{:?}", answer.reasons);
            for output in 0..m {
                let y = |row: usize| answer.values[row * m + output];
                let (one, two) = ((y(0) - y(1)) / (2.0 * apart), (y(2) - y(3)) / (4.0 * apart));
                let slope = one + (one - two) / 3.0;
                let miss = (slope - found.jacobian[output * k + input]).abs();
                let at = &mut nearest[output * k + input];
                *at = at.min(miss);
            }
        }
    }
    for output in 0..m {
        let row =
            |of: &[f64]| (0..k).map(|i| of[output * k + i] * if x[i] == 0.0 { 1.0 } else { x[i] }).collect::<Vec<_>>();
        let largest = row(&found.jacobian).iter().fold(0.0f64, |most, slope| most.max(slope.abs()));
        let worst = row(&nearest).iter().fold(0.0f64, |most, miss| most.max(miss.abs()));
        assert!(
            worst <= within * largest,
            "{}: {:e} of {largest:e}\n{:?}",
            probes[output],
            worst / largest,
            found.jacobian
        );
    }
}

const DYAD: &str = include_str!("../../../models/networks/dyad.toml");

/// Geometry by the places of nodes, a prescribed displacement, and probes at both steps, one of them an expression.
#[test]
fn geometry_of_the_dyad() {
    check(DYAD, &["L", "beta"], &["stroke@inflate", "holding", "gear@inflate"]);
}

/// Ends released about axes of their own member, which turn with the places of its nodes.
#[test]
fn releases_whose_axes_turn() {
    for release in [r#"["ry", "rz"]"#, r#"["rz"]"#, r#"["ry"]"#, r#"["rx"]"#, r#"["rx", "rz"]"#] {
        let text = format!(
            r#"format = "pennate/1"
            dimension = "space"
            parameters = {{ g = 30, f = 0.4 }}
            nodes = {{ A = [0, 0, 0], B = [60, 10, 0], C = [20, "= g", 50] }}
            sections = {{ s = {{ stiffness = {{ EA = 1e4, GA2 = 4e3, GA3 = 3e3, GJ = 6e3, EI2 = 9e3, EI3 = 7e3 }} }} }}
            members = {{ a = {{ nodes = ["A", "B"], section = "s" }}, b = {{ nodes = ["A", "C"], section = "s" }},
                         c = {{ nodes = ["B", "C"], section = "s", release = {{ end = {release} }} }} }}
            supports = {{ A = "clamped" }}
            steps = [{{ force = {{ B = [2, -3, "= 10 * f"] }} }}]
            probes = {{ u = {{ node = "B", displacement = "uy" }}, v = {{ node = "C", displacement = "ux" }},
                        turn = {{ node = "B", rotation = "rz" }}, root = {{ node = "A", reaction = "rx" }} }}
        "#
        );
        check(&text, &["g", "f"], &["u", "v", "turn", "root"]);
        // By neighbours, since forces along members are asked for.
        let text = text.replace("u = {", "pull = { member = \"b\", axial_force = \"end\" }, u = {");
        let document = Document::from_text("network.toml", &text);
        let probes = ["u", "pull"];
        let problem = Problem::new(&document, &[], &["g", "f"], &probes, 1e-6).unwrap();
        check_within(&problem, &problem.middle(), &probes, 1e-7);
    }
}

/// One component of a rotation in space that is prescribed, or kept, while the others are free; hinges and orientations that are
/// parameters themselves.
#[test]
fn rotations_that_are_held_in_part_and_axes_that_are_parameters() {
    let steps = [
        r#"[[steps]]
        force = { B = [0.7, -1, 1] }
        rotation = { B = { rz = "= 20 * t" } }"#,
        r#"[[steps]]
        force = { B = [0.7, -1, 1] }
        [[steps]]
        displace_by = { B = { rz = "= 20 * t" } }"#,
        r#"[[steps]]
        force = { B = [0.7, -1, 1], C = [0, 0, "= t"] }
        rotation = { B = { rz = 10 } }"#,
    ];
    let ends = ["", r#", release = { end = { hinge = ["= t", 1, 0.3] } }"#];
    let turned = r#", orientation = ["= t", 1, 0.3], release = { end = ["ry"] }"#;
    let plain = "[[steps]]\nforce = { B = [0.7, -1, 1] }";
    let all = steps.map(|step| (ends[0], step)).into_iter().chain([(ends[1], plain), (turned, plain)]);
    for (end, steps) in all {
        let text = format!(
            r#"format = "pennate/1"
            dimension = "space"
            parameters = {{ t = 0.5 }}
            nodes = {{ A = [0, 0, 0], B = [60, 10, 0], C = [20, 30, 50] }}
            sections = {{ s = {{ stiffness = {{ EA = 1e4, GA2 = 4e3, GA3 = 3e3, GJ = 6e3, EI2 = 9e3, EI3 = 7e3 }} }} }}
            members = {{ a = {{ nodes = ["A", "B"], section = "s" }}, b = {{ nodes = ["A", "C"], section = "s" }},
                         c = {{ nodes = ["B", "C"], section = "s"{end} }} }}
            supports = {{ A = "clamped" }}
            probes = {{ u = {{ node = "B", displacement = "uy" }}, v = {{ node = "C", displacement = "ux" }},
                        root = {{ node = "A", reaction = "rz" }} }}
            {steps}
        "#
        );
        let document = Document::from_text("network.toml", &text);
        let problem = Problem::new(&document, &[], &["t"], &["u", "v", "root"], 1e-6).unwrap();
        // The moment at the root is two thousand times as large as what a turn of the hinge changes it by: rounding of it, over the
        // three millionths by which differences are taken, is more than a hundred millionth of that.
        let within = if end == ends[1] { 1e-7 } else { 1e-8 };
        check_within(&problem, &problem.middle(), &["u", "v", "root"], within);
    }
}

/// Derivatives of designs side by side are those of each of them by itself.
#[test]
fn derivatives_in_company_and_alone() {
    let document = Document::from_text("dyad.toml", DYAD);
    let problem = Problem::new(&document, &[], &["L", "beta"], &["stroke@inflate", "holding"], 1e-6).unwrap();
    let rows: Vec<f64> =
        (0..9).flat_map(|design| [130.0 - f64::from(design), 22.0 + 0.3 * f64::from(design)]).collect();
    let all = problem.gradient(&rows);
    let largest = all.jacobian.iter().fold(0.0f64, |most, slope| most.max(slope.abs()));
    for (row, found) in rows.chunks_exact(2).zip(all.jacobian.chunks_exact(4)) {
        let alone = problem.gradient(row).jacobian;
        let worst = alone.iter().zip(found).fold(0.0f64, |most, (alone, found)| most.max((alone - found).abs()));
        assert!(worst <= 1e-9 * largest, "{row:?}: {worst:e} of {largest:e}");
    }
}

/// Tables of muscles, sections, pressures and springs.
#[test]
fn muscles_pressures_and_springs() {
    let text = DYAD
        .replace("L = 130", "E10 = 3.6\nwall = 2.0\np = 22\nk = 0.4\ndown = -3.0\nL = 130")
        .replace("E = 3.60", "E = \"= E10\"")
        .replace("wall = 2.0\npressure_unit", "wall = \"= wall\"\npressure_unit")
        .replace("left = \"25 psi\"", "left = \"= p\"")
        .replace("uy = 0.0", "uy = \"= down\"")
        .replace("[probes]", "[springs]\ngrip = { node = \"J\", stiffness = { uy = \"= k\" } }\n[probes]");
    check(&text, &["E10", "wall", "p", "k", "down", "L"], &["stroke@inflate", "holding"]);
}

/// A rigid body on pinned muscles in space, at three steps.
#[test]
fn the_stage() {
    let text = include_str!("../../../models/networks/tip_tilt_stage.toml")
        .replace("dyad1 = 20", "dyad1 = \"= p\"")
        .replace("L = 130", "p = 18\nL = 130");
    check(&text, &["p", "L", "beta", "rp"], &["tilt@tilt", "height", "stroke@lower"]);
}

/// A rod that can neither be stretched nor sheared, under its weight and two pressures.
#[test]
fn an_inextensible_rod_in_space() {
    check(include_str!("../../../examples/designs/br2.toml"), &["Pb", "Pr", "load"], &["x", "y", "z", "x@hang"]);
}

/// Forces and moments that turn with their node have no potential, in the plane and in space.
#[test]
fn follower_loads() {
    let text = r#"
        format = "pennate/1"
        parameters = { L = 100, F = 2, M = 40, side = 0, r = 1.5 }
        nodes = { A = [0, 0], B = ["= L", 0] }
        materials.polymer = { youngs_modulus = 2000, poissons_ratio = 0.4 }
        sections.rod = { circle = { radius = "= r" } }
        members.rod = { nodes = ["A", "B"], section = "rod", material = "polymer" }
        supports = { A = "clamped" }
        steps = [{ name = "push", follower_force = { B = ["= -0.2 * F", "= F"] } },
                 { name = "turn", follower_moment = { B = [0, 0, "= M"] } }]
        probes = { x = { node = "B", position = "x" }, turn = { node = "B", rotation = "rz" },
                   root = { node = "A", reaction = "rz" } }
    "#;
    check(text, &["L", "F", "M", "r"], &["x@push", "x", "turn", "root"]);
    let space = text.replace("\"= F\"]", "\"= F\", \"= 0.4 * F\"]").replace("rotation = \"rz\"", "rotation = \"ry\"");
    check(&space, &["L", "F", "M", "r"], &["x@push", "x", "turn", "root"]);
}

/// What is held where it was carries the derivatives of the step before; what is moved on from there adds its own.
#[test]
fn what_is_held_where_it_was() {
    let end = DYAD.find("[[steps]]").unwrap();
    let probes = DYAD.find("[probes]").unwrap();
    let steps = r#"
[[steps]]
name = "inflate"
pressure = { all = "= p" }
[[steps]]
name = "hold"
hold = { J = ["uy"] }
pressure = { all = "= 0.5 * p" }
[[steps]]
name = "move"
displace_by = { J = { uy = "= d" } }
[[steps]]
name = "free"
free = { J = ["uy"] }
pressure = { left = "= p" }
"#;
    let text = format!("{}{steps}{}", &DYAD[..end], &DYAD[probes..]).replace("L = 130", "p = 22\nd = -2\nL = 130");
    check(&text, &["p", "d", "L", "beta"], &["stroke@inflate", "holding@hold", "holding@move", "stroke"]);
}

/// What the first step holds where it is, or moves on from there, is where the prestress has brought it: that follows the section, the
/// spring and the geometry.
#[test]
fn what_the_first_step_holds_where_a_prestress_brought_it() {
    let first = [
        r#"hold = { B = ["uy"] }"#,
        r#"hold = { B = ["ux", "uy"], A = ["ux"] }"#,
        r#"displace_by = { B = { uy = "= d" } }"#,
        r#"displace_by = { B = { rz = "= 2 * d" } }"#,
    ];
    for (dimension, height) in [("plane", "0"), ("space", "\"= z\"")] {
        for first in first {
            let text = format!(
                r#"
                format = "pennate/1"
                dimension = "{dimension}"
                parameters = {{ EI = 12000, k = 0.05, natural = 40, x = 100, d = -3, f = 0.2, z = 12 }}
                nodes = {{ A = [0, 0, 0], B = ["= x", 10, {height}], C = [160, 0, 0], G = [100, -60, 0] }}
                sections.given = {{ stiffness = {{ EI3 = "= EI", EA = 9000, EI2 = 15000, GJ = 8000 }} }}
                members = {{ a = {{ nodes = ["A", "B"], section = "given" }}, b = {{ nodes = ["B", "C"], section = "given" }} }}
                supports = {{ A = "clamped", G = "clamped" }}
                springs.pull = {{ nodes = ["C", "G"], stiffness = "= k", natural_length = "= natural" }}
                steps = [
                    {{ name = "first", {first}, force = {{ C = [0.1, "= f", 0] }} }},
                    {{ name = "on", displace_by = {{ C = {{ uy = "= d" }} }}, force = {{ C = [0, 0, 0] }} }},
                ]
                probes.at = {{ node = "B", displacement = "uy" }}
                probes.push = {{ node = "B", reaction = "uy" }}
                probes.turn = {{ node = "C", rotation = "rz" }}
                probes.root = {{ node = "A", reaction = "rz" }}
                "#
            );
            let parameters = ["EI", "k", "natural", "x", "d", "f", "z"];
            let used = if dimension == "space" { &parameters[..] } else { &parameters[..6] };
            check(&text, used, &["at@first", "push@first", "turn@first", "root@first", "at", "root"]);
        }
    }
}

/// A spring that its natural length leaves without force has one beside.
#[test]
fn what_the_first_step_holds_where_a_prestress_sets_in() {
    // What is held bears nothing there, whatever the parameters are.
    let all = [
        (r#"hold = { B = ["uy"] }"#, &["at", "turn"][..]),
        ("displace_by = { B = { uy = -5 } }", &["at", "turn", "push"]),
    ];
    for (first, probes) in all {
        let text = format!(
            r#"
            format = "pennate/1"
            dimension = "plane"
            parameters = {{ EI = 5000, natural = 60 }}
            nodes = {{ A = [0, 0], B = [100, 0], G = [100, -60] }}
            sections.given = {{ stiffness = {{ EI3 = "= EI", EA = 9000 }} }}
            members.a = {{ nodes = ["A", "B"], section = "given" }}
            supports = {{ A = "clamped", G = "clamped" }}
            springs.pull = {{ nodes = ["B", "G"], stiffness = 0.01, natural_length = "= natural" }}
            steps = [{{ {first} }}]
            probes = {{ at = {{ node = "B", displacement = "uy" }}, turn = {{ node = "B", rotation = "rz" }},
                        push = {{ node = "B", reaction = "uy" }} }}
            "#
        );
        check(&text, &["EI", "natural"], probes);
    }
}

/// A bar that nothing but a prestress keeps from turning is where that brings it; one that the prestress would turn over is held where it is
/// drawn.
#[test]
fn what_the_first_step_holds_of_a_bar_that_is_free_to_turn() {
    for (natural, h, height) in [(40, 10, "\"= h\""), (40, 0, "\"= h\""), (80, 0, "0")] {
        for first in [r#"hold = { B = ["uy"] }"#, r#"displace_by = { B = { uy = "= d" } }"#] {
            let text = format!(
                r#"
                format = "pennate/1"
                dimension = "plane"
                parameters = {{ EA = 500, natural = {natural}, x = 100, h = {h}, d = 6, f = 0.1 }}
                nodes = {{ A = [0, 0], B = ["= x", 0], G = [160, {height}] }}
                sections.given = {{ stiffness = {{ EI3 = 5000, EA = "= EA" }} }}
                members.a = {{ nodes = ["A", "B"], section = "given" }}
                supports = {{ A = "pinned", G = "clamped" }}
                springs.pull = {{ nodes = ["B", "G"], stiffness = 0.05, natural_length = "= natural" }}
                steps = [{{ {first}, force = {{ B = ["= f", 0] }} }}]
                probes = {{ at = {{ node = "B", displacement = "ux" }}, turn = {{ node = "A", rotation = "rz" }},
                            push = {{ node = "B", reaction = "uy" }} }}
                "#
            );
            let parameters = ["EA", "natural", "x", "h", "d", "f"];
            let used: Vec<&str> =
                parameters.into_iter().filter(|name| text.contains(&format!("\"= {name}\""))).collect();
            check(&text, &used, &["at", "turn", "push"]);
        }
    }
}

/// A prestress comes in before the first step alone: a later one that is to go by increments would lose a bar that all of it holds upright.
#[test]
fn a_prestress_comes_in_once() {
    let text = r#"
        format = "pennate/1"
        dimension = "plane"
        parameters = { natural = 40, f = 0.02, P = 1.2 }
        nodes = { A = [0, 0], B = [100, 0], G = [160, 0] }
        sections.given = { stiffness = { EI3 = 5000, EA = 500 } }
        members.a = { nodes = ["A", "B"], section = "given" }
        supports = { A = "pinned", G = "clamped" }
        springs.pull = { nodes = ["B", "G"], stiffness = 0.05, natural_length = "= natural" }
        steps = [{ force = { B = ["= -P", "= f"] } }, { force = { B = ["= -P", "= 2 * f"] }, increments = 4 }]
        probes = { at = { node = "B", displacement = "uy" }, turn = { node = "A", rotation = "rz" } }
    "#;
    check(text, &["natural", "f", "P"], &["at", "turn"]);
}

/// Stiff wires make much of a joint that is moved with their ends held, and nothing of it is left in equilibrium.
#[test]
fn joints_between_stiff_wires() {
    let text = r#"
        format = "pennate/1"
        dimension = "plane"
        parameters = { length = 60, turn = 153, far = 540 }
        nodes = { A = [0, 0], J = ["= -length * cos(turn)", "= -length * sin(turn)"], G = ["= 120 - length * cos(turn)", "= 30 - length * sin(turn)"],
                  M = ["= -length * cos(turn)", "= -100 - length * sin(turn)"], B = ["= far", 0] }
        materials.steel = { youngs_modulus = 2e5, poissons_ratio = 0.3 }
        sections.wire = { circle = { radius = 0.75 }, shear = false }
        muscles.silicone = { library = "silicone" }
        members = { o = { nodes = ["J", "A"], section = "wire", material = "steel" }, c = { nodes = ["J", "G"], section = "wire", material = "steel" },
                    m = { nodes = ["J", "M"], muscle = "silicone" }, s = { nodes = ["A", "B"], section = "wire", material = "steel" } }
        supports = { G = "clamped", M = "clamped", B = ["uy"] }
        steps = [{ name = "inflate", pressure = { all = 25 } }]
        probes = { a = { node = "A", displacement = "uy" }, x = { node = "A", displacement = "ux" } }
    "#;
    check(text, &["turn", "length"], &["a", "x"]);
}

/// A hundredth before its limit point an arch has derivatives; a ten-thousandth before it, none that are worth a number.
#[test]
fn next_to_a_limit_point_there_is_a_reason() {
    let text = r#"
        format = "pennate/1"
        dimension = "plane"
        parameters = { F = 0.1 }
        nodes = { A = [-100, 0], C = [0, 10], B = [100, 0] }
        sections = { bar = { stiffness = { EA = 1000, GA2 = 1000, EI3 = 1e4 } } }
        members = { a = { nodes = ["A", "C"], section = "bar" }, b = { nodes = ["C", "B"], section = "bar" } }
        supports = { A = "pinned", B = "pinned" }
        steps = [{ name = "push", force = { C = [0, "= -F"] } }]
        probes = { drop = { node = "C", displacement = "uy" } }
    "#;
    let problem = Problem::new(&Document::from_text("arch.toml", text), &[], &["F"], &["drop"], 1e-6).unwrap();
    // The limit, by bisection between what is solved and what is not.
    let (mut low, mut high) = (0.1, 50.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        let solved = problem.evaluate(&[middle]).reasons[0].is_none();
        if solved { low = middle } else { high = middle }
    }
    let away = problem.gradient(&[0.99 * low]);
    assert!(away.reasons[0].is_none() && away.jacobian[0].is_finite(), "{away:?}");
    let near = problem.gradient(&[low * (1.0 - 1e-4)]);
    assert!(matches!(near.reasons[0], Some(Reason::Singular { step: 0, begins: false })), "{near:?}");
    assert!(near.values[0].is_finite() && near.jacobian[0].is_nan());
}

/// A plate on wires in space: weight, arms of a rigid body, a line load, what the plate is turned by, and reactions.
#[test]
fn weight_arms_and_line_loads() {
    let text = r#"
        format = "pennate/1"
        parameters = { span = 60, side = 20, mass = 1.2e-5, push = 0.05, w = 2e-4, fall = -1 }
        [nodes]
        plate = [0, 0, 0]
        P1 = ["= side", 0, 0]
        P2 = [0, "= side", 0]
        P3 = ["= -side", 0, 0]
        G1 = ["= side + span", 0, 0]
        G2 = [0, "= side + span", 0]
        G3 = ["= -side - span", 0, 0]
        [materials]
        steel = { youngs_modulus = 2e5, poissons_ratio = 0.3, density = 7.85e-9 }
        [sections]
        wire = { circle = { radius = 0.4 } }
        [members]
        w1 = { nodes = ["G1", "P1"], section = "wire", material = "steel" }
        w2 = { nodes = ["G2", "P2"], section = "wire", material = "steel" }
        w3 = { nodes = ["G3", "P3"], section = "wire", material = "steel" }
        [rigid_bodies]
        body = { nodes = ["P1", "P2", "P3"], reference = "plate", mass = "= mass" }
        [supports]
        G1 = "clamped"
        G2 = "clamped"
        G3 = "clamped"
        [[steps]]
        name = "hang"
        gravity = [0, 0, -9810]
        [[steps]]
        name = "push"
        force = { P1 = ["= push", "= 0.3 * push", 0] }
        distributed = { w2 = [0, 0, "= -w"] }
        [[steps]]
        name = "fall"
        displacement = { plate = { uz = "= fall" } }
        [probes]
        sink = { node = "plate", displacement = "uz" }
        corner = { node = "P1", displacement = "uz" }
        gap = { nodes = ["P1", "G2"], distance = true }
        tilt = { body = "body", normal = [0, 0, 1] }
        lift = { node = "plate", reaction = "uz" }
        root = { node = "G1", reaction = "ry" }
        both = "= lift * side + root@push"
    "#;
    let probes = ["sink@hang", "corner@push", "gap", "tilt@push", "lift", "root@push", "both"];
    check(text, &["span", "side", "mass", "push", "w", "fall"], &probes);
}

/// Parameters that reach nothing in common at the values of the file may do so elsewhere.
#[test]
fn what_parameters_reach_may_be_other_things_elsewhere() {
    let text = r#"
        format = "pennate/1"
        dimension = "plane"
        parameters = { a = 100, b = 80, F = 1, k = 2, E = 2000 }
        nodes = { A = [0, 0], B = ["= max(a, b)", 0] }
        materials.polymer = { youngs_modulus = "= E", poissons_ratio = 0.4 }
        sections.rod = { circle = { radius = 1.5 } }
        members.rod = { nodes = ["A", "B"], section = "rod", material = "polymer" }
        supports = { A = "clamped" }
        springs.s = { node = "B", stiffness = { uy = "= min(k, E / 1000)" } }
        steps = [{ name = "push", force = { B = [0, "= F"] } }]
        probes = { drop = { node = "B", displacement = "uy" }, root = { node = "A", reaction = "rz" } }
    "#;
    let probes = ["drop", "root"];
    let problem =
        Problem::new(&Document::from_text("rod.toml", text), &[], &["a", "b", "F", "k", "E"], &probes, 1e-6).unwrap();
    check_at(&problem, &[100.0, 80.0, 1.0, 1.0, 2500.0], &probes);
    check_at(&problem, &[80.0, 120.0, 1.0, 1.5, 1200.0], &probes);
    let found = problem.gradient(&[80.0, 120.0, 1.0, 1.5, 1200.0]);
    assert_eq!((found.jacobian[0], found.jacobian[3]), (0.0, 0.0), "{found:?}");
}

/// Probes that the adjoint does not serve are those of equilibria nearby.
#[test]
fn forces_along_members() {
    let text = DYAD.replace("[probes]", "[probes]\npull = { member = \"left\", axial_force = \"end\" }");
    check(&text, &["L", "beta"], &["pull@inflate", "holding"]);
}

/// Tables of muscles have corners at their rows: derivatives are those of the piece below, next to a row those of their own
/// piece, and at the ends of a table those of the side where there is a network. By the adjoint, and by neighbours.
#[test]
fn rows_and_ends_of_tables() {
    let text = DYAD
        .replace("{ left = \"25 psi\", pair = 25 }", "{ all = \"= pressure\" }")
        .replace("beta = 22 ", "pressure = 25\nbeta = 22 ")
        .replace("[probes]", "[probes]\npulled = { member = \"left\", axial_force = \"middle\" }");
    for probe in ["stroke@inflate", "pulled"] {
        let problem = Problem::new(&Document::from_text("dyad.toml", &text), &[], &["pressure"], &[probe], 1e-6);
        let problem = problem.unwrap();
        // Pressure, and the side that it is compared with.
        for (pressure, side) in
            [(25.0, -1.0), (24.99, -1.0), (20.0, -1.0), (19.99, -1.0), (20.01, 1.0), (10.0, -1.0), (0.0, 1.0)]
        {
            let found = problem.gradient(&[pressure]);
            assert!(found.reasons[0].is_none(), "{probe} at {pressure}: {:?}", found.reasons);
            // Differences of fourth order to one side.
            let by = side * 0.05;
            let rows: Vec<f64> = (0..5).map(|times| pressure + by * f64::from(times)).collect();
            let y = problem.evaluate(&rows).values;
            let slope = (-25.0 * y[0] + 48.0 * y[1] - 36.0 * y[2] + 16.0 * y[3] - 3.0 * y[4]) / (12.0 * by);
            let miss = (found.jacobian[0] - slope).abs();
            assert!(miss < 1e-6 * slope.abs(), "{probe} at {pressure}: {} instead of {slope}", found.jacobian[0]);
        }
    }
}

/// Where there is no network beside a design, values are known, and a reason says which derivative is not.
#[test]
fn at_the_edge_of_what_makes_a_network_there_is_a_reason() {
    let text = r#"
        format = "pennate/1"
        parameters = { L = 100, nu = 0.5 }
        nodes = { A = [0, 0], B = ["= L", 0] }
        materials.rubber = { youngs_modulus = 1, poissons_ratio = "= nu" }
        sections.rod = { circle = { radius = 5 } }
        members.rod = { nodes = ["A", "B"], section = "rod", material = "rubber" }
        supports = { A = "clamped" }
        steps = [{ name = "push", force = { B = [0, -0.001] } }]
        probes = { drop = { node = "B", displacement = "uy" } }
    "#;
    let problem = Problem::new(&Document::from_text("rod.toml", text), &[], &["L", "nu"], &["drop"], 1e-6).unwrap();
    let found = problem.gradient(&[100.0, 0.5]);
    assert!(found.values[0] < 0.0 && found.jacobian[1].is_nan());
    assert!(matches!(found.reasons[0], Some(Reason::Edge { parameter: 1, .. })), "{:?}", found.reasons);
}

/// A reaction that statics fixes has no derivative, beside what is found by neighbours too.
#[test]
fn what_statics_fixes_has_the_derivative_zero() {
    let text = r#"
        format = "pennate/1"
        parameters = { g = 30 }
        nodes = { A = [0, 0], B = [60, 10], C = [20, "= g"] }
        sections = { s = { stiffness = { EA = 1e4, GA2 = 4e3, GA3 = 3e3, GJ = 6e3, EI2 = 9e3, EI3 = 7e3 } } }
        members = { a = { nodes = ["A", "B"], section = "s" }, b = { nodes = ["A", "C"], section = "s" },
                    c = { nodes = ["B", "C"], section = "s" } }
        supports = { A = "clamped" }
        steps = [{ name = "s", force = { B = [0.21, -0.3] } }]
        probes = { u = { node = "B", displacement = "uy" }, pull = { member = "c", axial_force = "middle" },
                   r = { node = "A", reaction = "ux" } }
    "#;
    check(text, &["g"], &["u", "pull"]);
    let document = Document::from_text("frame.toml", text);
    let problem = Problem::new(&document, &[], &["g"], &["u", "pull", "r"], 1e-6).unwrap();
    let found = problem.gradient(&[30.0]);
    assert!(found.reasons[0].is_none(), "{:?}", found.reasons);
    assert!(found.jacobian[2].abs() * 30.0 < 1e-9 * found.values[2].abs(), "{:?}", found.jacobian);
}

/// Stiffnesses and compliances by geometry, sections, loads, pressures and the levers of bodies, large rotations among them; of a node
/// that is held along what is asked for, too, and beside a hinge.
#[test]
fn stiffnesses_follow_all_kinds_of_parameters() {
    let arm = r#"
        format = "pennate/1"
        parameters = { L = 100, beta = 30, F = 0.3, r = 1.1, lever = 40 }
        nodes = { A = [0, 0, 0], B = ["= L * cos(beta)", "= L * sin(beta)", 10], C = ["= 1.6 * L", 20, 40],
                  D = ["= 1.6 * L", "= 20 + lever", 40] }
        materials = { m = { youngs_modulus = 2000, poissons_ratio = 0.3 } }
        sections = { s = { rectangle = { height = 3, width = "= 2 * r" } } }
        members = { a = { nodes = ["A", "B"], section = "s", material = "m" },
                    b = { nodes = ["B", "C"], section = "s", material = "m", release = { start = ["rz"] } },
                    c = { nodes = ["A", "C"], section = "s", material = "m", release = { start = "pin" } } }
        rigid_bodies = { plate = { nodes = ["C", "D"] } }
        supports = { A = "clamped" }
        steps = [{ name = "s", force = { D = ["= F", "= 0.5 * F", "= -F"] } }]
        probes = { k = { node = "D", stiffness = "uy" }, c = { node = "D", compliance = "rx" },
                   turn = { node = "D", stiffness = "rz" }, x = { node = "D", displacement = "uz" } }
    "#;
    let parameters = ["L", "beta", "F", "r", "lever"];
    let document = Document::from_text("arm.toml", arm);
    let probes = ["k", "c", "turn", "x"];
    let problem = Problem::new(&document, &[], &parameters, &probes, 1e-5).unwrap();
    // The members' stretch is a ten-thousandth of what bends them: rounding counts.
    check_within(&problem, &problem.middle(), &probes, 1e-7);
    let free = arm.replace(", release = { start = [\"rz\"] }", "").replace(", release = { start = \"pin\" }", "");
    let held = free.replace("} }]", "}, displacement = { D = { uy = 6.0 } } }]");
    let problem = Problem::new(&Document::from_text("held.toml", &held), &[], &parameters, &probes, 1e-5).unwrap();
    check_within(&problem, &problem.middle(), &probes, 1e-7);
    let dyad = include_str!("../../../models/networks/dyad.toml")
        .replace("L = 130", "p = 18\nL = 130")
        .replace("left = \"25 psi\", pair = 25", "all = \"= p\"")
        .replace(
            "[probes]",
            "[probes]\nk = { node = \"J\", stiffness = \"uy\" }\nside = { node = \"J\", compliance = \"ux\" }",
        );
    check_within(
        &Problem::new(&Document::from_text("dyad.toml", &dyad), &[], &["p", "L", "beta"], &["k@inflate", "side"], 1e-6)
            .unwrap(),
        &[18.0, 130.0, 22.0],
        &["k@inflate", "side"],
        2e-8,
    );
}

/// The stiffness of a straight cantilever that cannot be sheared, across its axes, hardly depends on its stretch: what it does is what
/// beam theory says, to 10⁻¹⁰ of the stiffness; by its bending, which makes nearly all of it, to 10⁻⁸.
#[test]
fn the_stiffness_of_a_cantilever_by_its_stretch() {
    let text = r#"
        format = "pennate/1"
        parameters = { EA = 8475, EI = 11227 }
        nodes = { A = [0, 0], B = [54, -40] }
        sections = { s = { stiffness = { EA = "= EA", EI3 = "= EI", EI2 = 12490, GJ = 4845 } } }
        members = { m = { nodes = ["A", "B"], section = "s" } }
        supports = { A = "clamped" }
        steps = [{ name = "s" }]
        probes = { k = { node = "B", stiffness = "uy" } }
    "#;
    let document = Document::from_text("cantilever.toml", text);
    let problem = Problem::new(&document, &[], &["EA", "EI"], &["k"], 1e-6).unwrap();
    let found = problem.gradient(&problem.middle());
    assert!(found.reasons[0].is_none(), "{:?}", found.reasons);
    // Along the member L/EA, across it L³/3EI.
    let (length, [x, y]) = (54.0f64.hypot(40.0), [54.0, 40.0]);
    let (stretch, bending) = (y * y / length / 8475.0, x * x * length / (3.0 * 11227.0));
    let stiffness = 1.0 / (stretch + bending);
    assert!((found.values[0] / stiffness - 1.0).abs() < 1e-8, "{:?} {stiffness}", found.values);
    let slopes = [found.jacobian[0] * 8475.0, found.jacobian[1] * 11227.0];
    for ((slope, expected), within) in slopes.iter().zip([stretch, bending]).zip([1e-10, 1e-8]) {
        let miss = (slope / stiffness - expected * stiffness).abs();
        assert!(miss < within, "{slope} {miss:e}");
    }
}

/// Closed frames of members that cannot be stretched, and a muscle that cannot: derivatives are those of rigid strains.
#[test]
fn closed_frames_that_cannot_be_stretched() {
    let frame = |stretch: &str| {
        format!(
            r#"format = "pennate/1"
            parameters = {{ L = 112, h = 118, q = 0.14 }}
            nodes = {{ A = ["= L", 80], B = [4, "= h"], C = [60, 20] }}
            materials.m = {{ youngs_modulus = 2000, poissons_ratio = 0.35 }}
            sections = {{ r = {{ circle = {{ radius = 1.4 }}, stretch = {stretch}, shear = false }}, t = {{ circle = {{ radius = 1.5 }} }} }}
            members = {{ a = {{ nodes = ["A", "B"], section = "r", material = "m", elements = 3 }},
                         b = {{ nodes = ["B", "C"], section = "t", material = "m", elements = 3 }},
                         c = {{ nodes = ["A", "C"], section = "t", material = "m", elements = 3 }} }}
            supports = {{ A = "clamped" }}
            steps = [{{ name = "s", force = {{ B = ["= -q", "= 2 * q"], C = [0.05, "= -q"] }} }}]
            probes = {{ ux = {{ node = "B", displacement = "ux" }}, uy = {{ node = "C", displacement = "uy" }},
                        rz = {{ node = "B", rotation = "rz" }}, m = {{ node = "A", reaction = "rz" }} }}
        "#
        )
    };
    for stretch in ["true", "false"] {
        check(&frame(stretch), &["L", "h", "q"], &["ux", "uy", "rz", "m"]);
    }
    let muscle = r#"
        format = "pennate/1"
        parameters = { L = 112, h = 118, q = 0.14, p = 18 }
        nodes = { A = ["= L", 80], B = [4, "= h"] }
        members = { a = { nodes = ["A", "B"], muscle = "m", elements = 3 } }
        supports = { A = "clamped" }
        steps = [{ name = "s", pressure = { all = "= p" }, force = { B = ["= -q", "= 2 * q"] } }]
        probes = { ux = { node = "B", displacement = "ux" }, rz = { node = "B", rotation = "rz" },
                   m = { node = "A", reaction = "rz" } }
        [muscles.m]
        diameter = 13
        wall = 2
        pressure_unit = "psi"
        density = 1.1e-9
        stretch = false
        table = [{ pressure = 10, E = 3.6, alpha = -9.1e-3, R1 = 6.8, R2 = 7.9 },
                 { pressure = 25, E = 4.25, alpha = -6.9e-3, R1 = 7.15, R2 = 8.9 }]
    "#;
    check(muscle, &["L", "h", "q", "p"], &["ux", "rz", "m"]);
}

/// A thin wire that cannot be stretched closes a frame, and a step holds what another has led to: the compliance that stands for the
/// wire while derivatives are found is no small part of that of the frame.
#[test]
fn a_thin_wire_that_closes_a_frame() {
    let text = r#"
        format = "pennate/1"
        dimension = "plane"
        parameters = { k = 0.05, l = 167.5, F = 0.4 }
        nodes = { A = [98, 146], B = [129, 92], C = [136, 44], D = [77, 62], E = [89, 6] }
        materials.polymer = { youngs_modulus = 2500, poissons_ratio = 0.35 }
        [sections]
        beam = { stiffness = { EA = 582, GA2 = 233, EI3 = 8769 } }
        wire = { circle = { radius = 0.5 }, stretch = false }
        [members]
        ab = { nodes = ["A", "B"], section = "beam" }
        bc = { nodes = ["B", "C"], section = "beam" }
        bd = { nodes = ["B", "D"], section = "beam" }
        de = { nodes = ["D", "E"], section = "beam" }
        ae = { nodes = ["A", "E"], section = "wire", material = "polymer" }
        [supports]
        A = "clamped"
        [springs]
        pull = { nodes = ["A", "E"], stiffness = "= k", natural_length = "= l" }
        [[steps]]
        force = { B = ["= F", -0.35, 0], C = [0, 0.3, 0] }
        [[steps]]
        hold = { D = ["uy"] }
        force = { C = [-0.35, "= -2 * F", 0] }
        [probes]
        x = { node = "D", displacement = "ux" }
        turn = { node = "D", rotation = "rz" }
        root = { node = "A", reaction = "rz" }
    "#;
    check(text, &["k", "l", "F"], &["x", "turn", "root"]);
}

/// A support along an axis that a parameter turns, and a point of a body, at an arm that a parameter sets, that is moved on:
/// reactions and motions follow both.
#[test]
fn axes_and_arms_of_what_is_held() {
    for (dimension, height) in [("plane", "0"), ("space", "12")] {
        let text = format!(
            r#"
            format = "pennate/1"
            dimension = "{dimension}"
            parameters = {{ y = 15, a = 0.6, arm = 128, by = 4, EI = 12000 }}
            nodes = {{ A = [0, 0, 0], B = [60, "= y", 0], C = [120, 10, {height}], TOOL = ["= arm", 16, {height}] }}
            sections.given = {{ stiffness = {{ EI3 = "= EI", EA = 9000, EI2 = 15000, GJ = 8000, mass_per_length = 2e-7 }} }}
            members = {{ m0 = {{ nodes = ["A", "B"], section = "given" }}, m1 = {{ nodes = ["B", "C"], section = "given" }} }}
            supports = {{ A = "clamped", B = {{ fix = ["ux"], x_axis = ["= a", 0.8, 0] }} }}
            rigid_bodies.hand = {{ nodes = ["C"], reference = "TOOL" }}
            steps = [
                {{ name = "load", force = {{ C = [0.4, -0.5, 0] }}, moment = {{ TOOL = [0, 0, 20] }} }},
                {{ name = "on", displace_by = {{ C = {{ uy = "= by" }} }} }},
            ]
            probes.x = {{ node = "TOOL", displacement = "ux" }}
            probes.turn = {{ node = "C", rotation = "rz" }}
            probes.root = {{ node = "A", reaction = "rz" }}
            probes.beside = {{ node = "B", reaction = "uy" }}
            probes.push = {{ node = "C", reaction = "uy" }}
            "#
        );
        check(&text, &["y", "a", "arm", "by", "EI"], &["x", "turn", "root", "beside", "push"]);
        // Reactions of the only step are read in the same state as its displacements; held strains would take another look at it.
        let only = text.replace(r#"{ name = "on", displace_by = { C = { uy = "= by" } } },"#, "");
        let only = only.replace(r#"probes.push = { node = "C", reaction = "uy" }"#, "");
        let only = only.replace("EA = 9000", "EA = 9000, GA2 = 4000, GA3 = 4000");
        check(&only, &["y", "a", "arm", "EI"], &["x", "turn", "root", "beside"]);
    }
}

/// A place that a parameter moves, beside the largest moment of a member whose elements are graded into the layers at its ends.
#[test]
fn places_beside_a_largest_moment_on_a_graded_mesh() {
    let text = r#"
        format = "pennate/1"
        parameters = { p = -22 }
        nodes = { A = [-39.3, -73.1], B = [131.2, 0.83], C = [225.6, "= p"], D = [278.1, 9.34] }
        materials = { m = { youngs_modulus = 2200, poissons_ratio = 0.3 } }
        sections = { s = { rectangle = { width = 2.18, height = 1.46 } } }
        members = { a = { nodes = ["A", "B"], section = "s", material = "m" },
                    b = { nodes = ["B", "C"], section = "s", material = "m" },
                    c = { nodes = ["C", "D"], section = "s", material = "m" } }
        supports = { A = "clamped", D = "clamped" }
        steps = [{ name = "s", displacement = { B = { uy = 22.4 } } }]
        probes = { gap = { nodes = ["A", "C"], distance = true }, most = { member = "a", moment = "max" } }
    "#;
    check(text, &["p"], &["gap"]);
    let document = Document::from_text("bars.toml", text);
    let problem = Problem::new(&document, &[], &["p"], &["gap", "most"], 1e-5).unwrap();
    let found = problem.gradient(&[-22.0]);
    // What is greatest is a moment of a shape, known to fewer digits than the answers.
    assert!(matches!(found.reasons[0], None | Some(Reason::Inexact { output: 1, .. })), "{:?}", found.reasons);
    let values = problem.evaluate(&[-22.02, -21.98]).values;
    for output in 0..2 {
        let slope = (values[2 + output] - values[output]) / 0.04;
        assert!((found.jacobian[output] / slope - 1.0).abs() < 1e-5, "{output}: {:?}, {slope}", found.jacobian);
    }
}

/// What an expression refers to at the end of a step before, in which a prescribed rotation follows a parameter.
#[test]
fn a_step_before_with_a_prescribed_rotation_in_space() {
    let text = r#"
        format = "pennate/1"
        dimension = "space"
        parameters = { p = 10 }
        nodes = { A = [0, 0, 0], B = [100, 10, 0], C = [200, 0, 0] }
        materials = { m = { youngs_modulus = 2200, poissons_ratio = 0.3 } }
        sections = { s = { circle = { radius = 2 } } }
        members = { a = { nodes = ["A", "B"], section = "s", material = "m" },
                    b = { nodes = ["B", "C"], section = "s", material = "m" } }
        supports = { A = "clamped", C = "pinned" }
        steps = [{ name = "turn", rotation = { B = [-30, 12, "= p"] } }, { name = "push", force = { B = [0, 0.1, 0] } }]
        probes = { d = { node = "B", displacement = "uy" }, before = "= 2 * d@turn", both = "= before + d" }
    "#;
    check(text, &["p"], &["before"]);
    let problem = Problem::new(&Document::from_text("bars.toml", text), &[], &["p"], &["both"], 1e-6).unwrap();
    check_within(&problem, &problem.middle(), &["both"], 1e-6);
}
