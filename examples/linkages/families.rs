//! Families of linkages: their networks, and how a design of each is drawn.

/// Linkages of one topology.
pub(crate) struct Family {
    pub(crate) name: &'static str,
    pub(crate) dimension: &'static str,
    /// Values of the parameters of an ordinary design, by which the mesh is chosen, and random ones.
    pub(crate) parameters: &'static [(&'static str, f64)],
    /// Tables of the network file; members that say nothing else are of one rod.
    pub(crate) network: fn() -> String,
    pub(crate) outputs: &'static [&'static str],
    pub(crate) draw: fn(&mut fastrand::Rng) -> Vec<f64>,
    /// Length of a bar (mm).
    pub(crate) size: f64,
}

/// A chain of three bars between two supports, and more nodes, members and tables.
fn four_bars(nodes: &str, members: &str, tables: &str) -> String {
    format!(
        r#"
[nodes]
A = [0, 0]
B = ["= xb", "= yb"]
C = ["= xc", "= yc"]
D = ["= xd", 0]
{nodes}
[members]
AB = {{ nodes = ["A", "B"] }}
BC = {{ nodes = ["B", "C"], release = {{ start = "pin", end = "pin" }} }}
CD = {{ nodes = ["C", "D"], release = {{ end = "pin" }} }}
{members}
[probes]
x = {{ node = "C", displacement = "ux" }}
y = {{ node = "C", displacement = "uy" }}
{tables}"#
    )
}

const TURNED: &str = r#"
[supports]
A = "clamped"
D = "clamped"
[springs]
S = { node = "C", stiffness = { uy = "= k" } }
[[steps]]
rotation.A = [0, 0, "= turn"]
"#;

const FORCED: &str = r#"
[supports]
A = "pinned"
D = "clamped"
[springs]
S = { node = "C", stiffness = { ux = "= k", uy = "= k" } }
[[steps]]
force.B = ["= fx", "= fy"]
"#;

const MUSCLE_ANCHOR: &str = r#"M = ["= xb + 80 * cos(along)", "= yb + 80 * sin(along)"]"#;

const MUSCLE: &str = r#"pull = { nodes = ["M", "B"], muscle = "silicone", release = { start = "pin", end = "pin" } }"#;

const PULLED: &str = r#"
[supports]
A = "pinned"
D = "clamped"
M = "clamped"
[springs]
S = { node = "C", stiffness = { ux = "= k", uy = "= k" } }
[[steps]]
pressure.pull = "25 psi"
"#;

const TOGGLES: &str = r#"
[nodes]
A = [0, 0]
B = [1, "= y1"]
C = ["= 2 + x2", 0]
D = ["= 3 + x2", "= y2"]
E = [4, 0]
[members]
AB = { nodes = ["A", "B"] }
BC = { nodes = ["B", "C"], release = { start = "pin" } }
CD = { nodes = ["C", "D"], release = { start = "pin", end = "pin" } }
DE = { nodes = ["D", "E"] }
[supports]
A = "pinned"
E = "pinned"
C = ["uy"]
[springs]
S = { node = "D", stiffness = { uy = "= k" } }
[[steps]]
displacement.B = { uy = "= -move * y1" }
[probes]
x = { node = "C", displacement = "ux" }
y = { node = "D", displacement = "uy" }
"#;

const SLIDER: &str = r#"
[nodes]
A = [0, 0]
B = ["= xb", "= yb"]
C = ["= xc", 0]
[members]
AB = { nodes = ["A", "B"] }
BC = { nodes = ["B", "C"], release = { start = "pin", end = "pin" } }
[supports]
A = "clamped"
C = ["uy", "rz"]
[springs]
S = { node = "C", stiffness = { ux = "= k" } }
[[steps]]
rotation.A = [0, 0, "= turn"]
[probes]
x = { node = "B", displacement = "uy" }
y = { node = "C", displacement = "ux" }
"#;

const SIX_BARS: &str = r#"
[nodes]
A = [0, 0]
B = ["= xb", "= yb"]
C = ["= xc", "= yc"]
D = ["= xd", 0]
E = ["= xe", "= ye"]
F = ["= xf", 0]
[members]
AB = { nodes = ["A", "B"] }
BC = { nodes = ["B", "C"], release = { start = "pin", end = "pin" } }
CD = { nodes = ["C", "D"], release = { end = "pin" } }
CE = { nodes = ["C", "E"], release = { start = "pin", end = "pin" } }
EF = { nodes = ["E", "F"], release = { end = "pin" } }
[supports]
A = "clamped"
D = "clamped"
F = "clamped"
[springs]
S = { node = "E", stiffness = { uy = "= k" } }
[[steps]]
rotation.A = [0, 0, "= turn"]
[probes]
x = { node = "C", displacement = "ux" }
y = { node = "E", displacement = "uy" }
"#;

/// A crank about one axis and a rocker about another, between them a bar on ball joints.
const SPACE_FOUR_BARS: &str = r#"
[nodes]
A = [0, 0, 0]
B = ["= xb", "= yb", "= zb"]
C = ["= xc", "= yc", "= zc"]
D = ["= xd", 0, 0]
[members]
AB = { nodes = ["A", "B"] }
BC = { nodes = ["B", "C"], release = { start = "pin", end = "pin" } }
CD = { nodes = ["C", "D"], release = { end = { hinge = ["= hx", "= hy", 1] } } }
[supports]
A = "clamped"
D = "clamped"
[springs]
S = { node = "C", stiffness = { ux = "= k", uy = "= k", uz = "= k" } }
[[steps]]
rotation.A = [0, 0, "= turn"]
[probes]
x = { node = "C", displacement = "ux" }
y = { node = "C", displacement = "uy" }
z = { node = "C", displacement = "uz" }
"#;

/// A rigid plate in its plane, held by three bars that three cranks move.
const PLATFORM: &str = r#"
[nodes]
A1 = [0, 0]
A2 = [2.4, 0]
A3 = [1.2, 2.1]
B1 = ["= cos(a1)", "= sin(a1)"]
B2 = ["= 2.4 + cos(a2)", "= sin(a2)"]
B3 = ["= 1.2 + cos(a3)", "= 2.1 + sin(a3)"]
P0 = ["= px", "= py"]
P1 = ["= px + 0.5 * cos(turned + 210)", "= py + 0.5 * sin(turned + 210)"]
P2 = ["= px + 0.5 * cos(turned + 330)", "= py + 0.5 * sin(turned + 330)"]
P3 = ["= px + 0.5 * cos(turned + 90)", "= py + 0.5 * sin(turned + 90)"]
[members]
AB1 = { nodes = ["A1", "B1"] }
AB2 = { nodes = ["A2", "B2"] }
AB3 = { nodes = ["A3", "B3"] }
BP1 = { nodes = ["B1", "P1"], release = { start = "pin", end = "pin" } }
BP2 = { nodes = ["B2", "P2"], release = { start = "pin", end = "pin" } }
BP3 = { nodes = ["B3", "P3"], release = { start = "pin", end = "pin" } }
[rigid_bodies]
plate = { nodes = ["P1", "P2", "P3"], reference = "P0" }
[supports]
A1 = "clamped"
A2 = "clamped"
A3 = "clamped"
[springs]
S = { node = "P0", stiffness = { ux = "= k", uy = "= k", rz = "= 0.1 * k" } }
[[steps]]
rotation.A1 = [0, 0, "= t1"]
rotation.A2 = [0, 0, "= t2"]
rotation.A3 = [0, 0, "= t3"]
[probes]
x = { node = "P0", displacement = "ux" }
y = { node = "P0", displacement = "uy" }
turn = { node = "P0", rotation = "rz" }
"#;

/// A number between two others.
fn between(random: &mut fastrand::Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * random.f64()
}

/// A stiffness from a thousandth to a tenth (N/mm), even in its logarithm.
fn stiffness(random: &mut fastrand::Rng) -> f64 {
    10f64.powf(between(random, -3.0, -1.0))
}

/// Crank and coupler nearly in one line, as the ordinary design is; a turn leads past the line.
fn near_the_line(random: &mut fastrand::Rng) -> Vec<f64> {
    vec![
        between(random, -0.995, -0.985),
        between(random, 0.06, 0.14),
        between(random, 1.0, 1.01),
        between(random, -0.06, 0.12),
        2.0,
        between(random, 13.0, 14.0),
        stiffness(random),
    ]
}

fn of_any_proportion(random: &mut fastrand::Rng) -> Vec<f64> {
    vec![
        between(random, -1.0, 1.0),
        between(random, 0.0, 0.2),
        between(random, 0.3, 1.3),
        between(random, -0.2, 0.2),
        between(random, 1.4, 2.2),
        between(random, -25.0, 25.0),
        stiffness(random),
    ]
}

fn parallelogram(random: &mut fastrand::Rng) -> Vec<f64> {
    let angle = between(random, 0.05, 0.4);
    let near = 10f64.powf(between(random, -6.0, -2.0));
    let mut miss = || near * between(random, -1.0, 1.0);
    let [b, c] = [[angle.cos() + miss(), angle.sin() + miss()], [1.5 + angle.cos() + miss(), angle.sin() + miss()]];
    let turn = -angle.to_degrees() * between(random, 1.05, 3.0);
    vec![b[0], b[1], c[0], c[1], 1.5, turn, stiffness(random)]
}

fn two_toggles(random: &mut fastrand::Rng) -> Vec<f64> {
    vec![
        between(random, 0.03, 0.3),
        between(random, -0.1, 0.1),
        between(random, -0.3, 0.3),
        stiffness(random),
        between(random, 1.0, 2.5),
    ]
}

fn slider(random: &mut fastrand::Rng) -> Vec<f64> {
    let angle = between(random, -3.0, 3.0);
    let crank = between(random, 0.4, 1.0);
    let [x, y] = [crank * angle.cos(), crank * angle.sin()];
    let coupler = (crank * between(random, 0.9, 1.3)).max(1.02 * y.abs());
    vec![x, y, x + (coupler * coupler - y * y).sqrt(), between(random, -60.0, 60.0), stiffness(random)]
}

fn six_bars(random: &mut fastrand::Rng) -> Vec<f64> {
    let mut values = of_any_proportion(random);
    let (turn, k) = (values[5], values[6]);
    values.truncate(5);
    values.extend([between(random, 1.6, 2.6), between(random, -0.3, 0.3), between(random, 2.4, 3.4), turn, k]);
    values
}

fn forced(random: &mut fastrand::Rng) -> Vec<f64> {
    let mut values = of_any_proportion(random);
    let k = values[6];
    values.truncate(5);
    let size = k * between(random, 0.02, 0.5);
    let angle = between(random, -3.2, 3.2);
    values.extend([size * angle.cos(), size * angle.sin(), k]);
    values
}

/// Bars of half a muscle and more, and a muscle about square to the crank.
fn pulled_by_a_muscle(random: &mut fastrand::Rng) -> Vec<f64> {
    let [mut crank, angle] = [between(random, 20.0, 45.0), between(random, -180.0, 180.0)];
    let xc = between(random, 20.0, 60.0);
    crank *= if random.bool() { 1.0 } else { 0.6 };
    vec![
        crank * angle.to_radians().cos(),
        crank * angle.to_radians().sin(),
        xc,
        between(random, -10.0, 10.0),
        between(random, 60.0, 100.0),
        angle + if random.bool() { 90.0 } else { -90.0 } + between(random, -30.0, 30.0),
        stiffness(random),
    ]
}

fn space_four_bars(random: &mut fastrand::Rng) -> Vec<f64> {
    let mut tenth = || between(random, -0.1, 0.1);
    let [zb, zc, hx, hy] = [tenth(), tenth(), 5.0 * tenth(), 5.0 * tenth()];
    let plane = of_any_proportion(random);
    vec![plane[0], plane[1], zb, plane[2], plane[3], zc, plane[4], hx, hy, plane[5], plane[6]]
}

fn platform(random: &mut fastrand::Rng) -> Vec<f64> {
    let mut values: Vec<f64> = (0..3).map(|_| between(random, -180.0, 180.0)).collect();
    values.extend([between(random, 0.9, 1.5), between(random, 0.4, 1.0), between(random, -40.0, 40.0)]);
    values.extend((0..3).map(|_| between(random, -40.0, 40.0)));
    values.push(stiffness(random));
    values
}

const FOUR: &[(&str, f64)] =
    &[("xb", -0.99), ("yb", 0.1), ("xc", 1.005), ("yc", 0.03), ("xd", 2.0), ("turn", 13.5), ("k", 0.01)];

/// A family in the plane of bars about as long as 1 mm.
const PLANE: Family = Family {
    name: "",
    dimension: "plane",
    parameters: FOUR,
    network: || four_bars("", "", TURNED),
    outputs: &["x", "y"],
    draw: near_the_line,
    size: 1.0,
};

pub(crate) const FAMILIES: [Family; 10] = [
    Family { name: "four bars near their change point", ..PLANE },
    Family { name: "four bars of any proportion", draw: of_any_proportion, ..PLANE },
    Family {
        name: "parallelograms through their line",
        parameters: &[("xb", 0.95), ("yb", 0.3), ("xc", 2.45), ("yc", 0.3), ("xd", 1.5), ("turn", -25.0), ("k", 0.01)],
        draw: parallelogram,
        ..PLANE
    },
    Family {
        name: "two toggles in a row",
        parameters: &[("y1", 0.1), ("x2", 0.0), ("y2", 0.1), ("k", 0.01), ("move", 1.5)],
        network: || TOGGLES.to_owned(),
        draw: two_toggles,
        ..PLANE
    },
    Family {
        name: "slider cranks",
        parameters: &[("xb", 0.5), ("yb", 0.5), ("xc", 1.4), ("turn", 30.0), ("k", 0.01)],
        network: || SLIDER.to_owned(),
        draw: slider,
        ..PLANE
    },
    Family {
        name: "six bars",
        parameters: &[
            ("xb", -0.99),
            ("yb", 0.1),
            ("xc", 1.005),
            ("yc", 0.03),
            ("xd", 2.0),
            ("xe", 2.1),
            ("ye", 0.1),
            ("xf", 3.0),
            ("turn", 13.5),
            ("k", 0.01),
        ],
        network: || SIX_BARS.to_owned(),
        draw: six_bars,
        ..PLANE
    },
    Family {
        name: "four bars under a force",
        parameters: &[
            ("xb", -0.99),
            ("yb", 0.1),
            ("xc", 1.005),
            ("yc", 0.03),
            ("xd", 2.0),
            ("fx", 1e-4),
            ("fy", 1e-4),
            ("k", 0.01),
        ],
        network: || four_bars("", "", FORCED),
        draw: forced,
        ..PLANE
    },
    Family {
        name: "four bars pulled by a muscle",
        parameters: &[
            ("xb", 0.0),
            ("yb", 40.0),
            ("xc", 50.0),
            ("yc", 5.0),
            ("xd", 80.0),
            ("along", 180.0),
            ("k", 0.01),
        ],
        network: || four_bars(MUSCLE_ANCHOR, MUSCLE, PULLED),
        draw: pulled_by_a_muscle,
        size: 50.0,
        ..PLANE
    },
    Family {
        name: "four bars in space",
        dimension: "space",
        parameters: &[
            ("xb", -0.99),
            ("yb", 0.1),
            ("zb", 0.05),
            ("xc", 1.005),
            ("yc", 0.03),
            ("zc", -0.05),
            ("xd", 2.0),
            ("hx", 0.2),
            ("hy", 0.1),
            ("turn", 13.5),
            ("k", 0.01),
        ],
        network: || SPACE_FOUR_BARS.to_owned(),
        outputs: &["x", "y", "z"],
        draw: space_four_bars,
        ..PLANE
    },
    Family {
        name: "plates on three cranks",
        parameters: &[
            ("a1", 120.0),
            ("a2", 150.0),
            ("a3", -60.0),
            ("px", 1.2),
            ("py", 0.7),
            ("turned", 10.0),
            ("t1", 15.0),
            ("t2", -10.0),
            ("t3", 20.0),
            ("k", 0.01),
        ],
        network: || PLATFORM.to_owned(),
        outputs: &["x", "y", "turn"],
        draw: platform,
        ..PLANE
    },
];
