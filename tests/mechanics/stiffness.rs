//! Probes of stiffness against closed forms.

use pennate_analysis::solution::ProbeTable;
use pennate_solver::history::Increment;
use pennate_testing::network::{ROD, model, solve};

/// Values of all probes at the end of the last step, and their names.
fn probes(text: &str) -> Vec<(String, f64)> {
    let solved = solve(text);
    let table = ProbeTable::new(&model(text), &solved.history);
    let last = table.steps.last().expect("a step").increments.last().expect("a state").clone();
    solved.model.probes.names.iter().cloned().zip(last).collect()
}

#[track_caller]
fn assert_near(now: f64, expected: f64, tolerance: f64) {
    assert!((now / expected - 1.0).abs() < tolerance, "{now} instead of {expected}");
}

/// EA / L along, 1 / (L^3 / 3 EI + L / GA) across, EI / L in bending; the clamp at the other end holds all three.
#[test]
fn a_straight_cantilever_has_the_stiffness_of_the_textbook() {
    let text = format!(
        "{ROD}
nodes = {{ A = [0, 0], T = [10, 0] }}
members.rod = {{ nodes = [\"A\", \"T\"], section = \"round\" }}
supports.A = \"clamped\"
steps = [{{ force = {{ T = [0, 0, 0] }} }}]
[probes]
along = {{ node = \"T\", stiffness = \"ux\" }}
across = {{ node = \"T\", stiffness = \"uy\" }}
oblique = {{ node = \"T\", stiffness = [1, 1, 0] }}
turning = {{ node = \"T\", stiffness = \"rz\" }}
soft = {{ node = \"T\", compliance = \"uy\" }}
"
    );
    let values = probes(&text);
    let across = 1.0 / (1e3 / 3e4 + 10.0 / 1e4);
    let expected = [3e3, across, 2.0 / (1.0 / 3e3 + 1.0 / across), 1e3, 1.0 / across];
    for ((name, now), expected) in values.iter().zip(expected) {
        println!("{name}");
        assert_near(*now, expected, 1e-9);
    }
}

/// A bracket of a beam and a wire that cannot be stretched: the beam's end can move across the wire alone, which bends and stretches the beam.
/// So it is whatever the wire's own bending stiffness is, a ten-billionth of the beam's too; a small force has moved it by what the stiffness says.
#[test]
fn a_wire_that_cannot_be_stretched_is_none_the_softer_for_being_thin() {
    for bending in [1.0, 1e-4, 1e-6] {
        let text = format!(
            "{ROD}
nodes = {{ A = [0, 0], B = [10, 0], C = [0, 10] }}
sections.wire = {{ stiffness = {{ EA = 1, EI3 = {bending:e}, EI2 = {bending:e}, GJ = {bending:e} }}, stretch = false }}
members.beam = {{ nodes = [\"A\", \"B\"], section = \"round\" }}
members.wire = {{ nodes = [\"C\", \"B\"], section = \"wire\" }}
supports = {{ A = \"clamped\", C = \"clamped\" }}
steps = [{{ force = {{ B = [0, -1e-4] }} }}]
[probes]
stiffness = {{ node = \"B\", stiffness = \"uy\" }}
moved = {{ node = \"B\", displacement = \"uy\" }}
"
        );
        let values: Vec<f64> = probes(&text).into_iter().map(|(_, value)| value).collect();
        // Sideways and down by the same, and the end of the beam turns as it likes but for the bending of the wire.
        let stiffness = 3e3 + 1.0 / (1e3 / 3e4 + 10.0 / 1e4);
        assert_near(values[0], -1e-4 / values[1], 1e-6);
        assert_near(values[0], stiffness, 2.0 * bending / 1e4 + 1e-6);
    }
}

/// Where a step holds what is asked for, the stiffness is what its reaction would grow by.
#[test]
fn a_held_component_shows_the_slope_of_its_reaction() {
    let text = |to: f64| {
        format!(
            "{ROD}
nodes = {{ A = [0, 0], J = [10, 3], B = [20, 0] }}
members.left = {{ nodes = [\"A\", \"J\"], section = \"round\" }}
members.right = {{ nodes = [\"J\", \"B\"], section = \"round\" }}
supports = {{ A = \"clamped\", B = \"clamped\" }}
steps = [{{ displacement = {{ J = {{ uy = {to} }} }} }}]
[probes]
push = {{ node = \"J\", reaction = \"uy\" }}
slope = {{ node = \"J\", stiffness = \"uy\" }}
"
        )
    };
    let values = |to| probes(&text(to)).into_iter().map(|(_, value)| value).collect::<Vec<_>>();
    let (before, here, after) = (values(-0.301), values(-0.3), values(-0.299));
    assert_near(here[1], (after[0] - before[0]) / 0.002, 1e-6);
}

/// A plate on three springs: the stiffness of the body is the sum of theirs, about a point of its own.
#[test]
fn a_body_has_the_stiffness_of_what_carries_it() {
    let text = format!(
        "{ROD}
nodes = {{ O = [0, 0, 0], P = [2, 0, 0], Q = [-1, 2, 0], R = [-1, -2, 0] }}
rigid_bodies.plate = {{ nodes = [\"P\", \"Q\", \"R\"], reference = \"O\" }}
[springs]
p = {{ node = \"P\", stiffness = {{ ux = 5, uy = 5, uz = 3 }} }}
q = {{ node = \"Q\", stiffness = {{ ux = 5, uy = 5, uz = 3 }} }}
r = {{ node = \"R\", stiffness = {{ ux = 5, uy = 5, uz = 3 }} }}
[[steps]]
force = {{ O = [0, 0, 0] }}
[probes]
heave = {{ body = \"plate\", stiffness = \"uz\" }}
roll = {{ body = \"plate\", stiffness = \"rx\" }}
pitch = {{ body = \"plate\", stiffness = \"ry\" }}
"
    );
    let values = probes(&text);
    for ((_, now), expected) in values.iter().zip([9.0, 3.0 * 8.0, 3.0 * 6.0]) {
        assert_near(*now, expected, 1e-9);
    }
}

/// What is probed is only looked at: a component that a step frees is freed as without the probe, its reaction fading over
/// the step.
#[test]
fn a_component_is_freed_alike_with_its_stiffness_probed() {
    let ways = |probes: &str| {
        let solved = solve(&format!(
            "{ROD}
nodes = {{ A = [0, 0], J = [10, 3], B = [20, 0] }}
members.left = {{ nodes = [\"A\", \"J\"], section = \"round\" }}
members.right = {{ nodes = [\"J\", \"B\"], section = \"round\" }}
supports = {{ A = \"clamped\", B = [\"ux\", \"uy\", \"rz\"] }}
{probes}
[[steps]]
force = {{ J = [200, -100] }}
[[steps]]
free = {{ B = [\"ux\", \"rz\"] }}
increments = 4
"
        ));
        let end = solved.node_index("B");
        let way = |increment: &Increment| increment.state.nodes[end].displacement[0];
        solved.history.steps[1].increments.iter().map(way).collect::<Vec<_>>()
    };
    let plain = ways("");
    let probed =
        ways("probes.k = { node = \"B\", stiffness = \"ux\" }\nprobes.t = { node = \"B\", stiffness = \"rz\" }");
    assert!(plain.len() == 4 && plain[0].abs() < 0.5 * plain[3].abs(), "{plain:?}");
    for (plain, probed) in plain.iter().zip(&probed) {
        assert!((plain - probed).abs() < 1e-9, "{plain} {probed}");
    }
}
