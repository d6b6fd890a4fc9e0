//! Random networks whose numbers are parameters, by seed.

use std::fmt::Write as _;

/// Typical length of a member (mm), and the bending stiffness of most (N mm²).
const LENGTH: f64 = 60.0;
const BENDING: f64 = 1e4;
/// Parameters of a network at most.
const PARAMETERS: usize = 10;

/// A network file, the names of its parameters, and those of its probes.
pub(crate) struct Random {
    pub text: String,
    pub parameters: Vec<String>,
    pub probes: Vec<String>,
    /// A tenth of what such networks move, turn and weigh, or thereabouts.
    pub scales: Vec<f64>,
    /// What kinds of numbers the parameters are.
    pub kinds: Vec<&'static str>,
}

/// Writes numbers, some of them as parameters.
struct Numbers {
    random: fastrand::Rng,
    values: Vec<f64>,
    kinds: Vec<&'static str>,
}

impl Numbers {
    /// A number of some kind: a parameter now and then.
    fn number(&mut self, kind: &'static str, value: f64) -> String {
        let few = self.values.len() < PARAMETERS;
        if value == 0.0 || !few || self.random.u8(0..3) > 0 {
            return format!("{value:?}");
        }
        self.values.push(value);
        self.kinds.push(kind);
        format!("\"= p{}\"", self.values.len())
    }

    fn numbers(&mut self, kind: &'static str, values: &[f64]) -> String {
        let numbers: Vec<String> = values.iter().map(|&value| self.number(kind, value)).collect();
        format!("[{}]", numbers.join(", "))
    }

    /// A size of either sign, of a third of the largest at least.
    fn signed(&mut self, largest: f64) -> f64 {
        let size = largest * (1.0 + 2.0 * self.random.f64()) / 3.0;
        if self.random.bool() { size } else { -size }
    }

    fn within(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.random.f64()
    }

    /// A vector of the plane, or of space.
    fn vector(&mut self, kind: &'static str, largest: f64, deep: bool) -> String {
        let vector = [self.signed(largest), self.signed(largest), if deep { self.signed(largest) } else { 0.0 }];
        self.numbers(kind, &vector)
    }
}

/// The network of a seed.
pub(crate) fn network(seed: u64) -> Random {
    network_with(seed, false)
}

/// The same with a step before the others that holds a component, or moves it on, from where the prestress has brought it.
pub(crate) fn network_held(seed: u64) -> Random {
    network_with(seed, true)
}

fn network_with(seed: u64, holds_first: bool) -> Random {
    let mut numbers = Numbers { random: fastrand::Rng::with_seed(seed), values: Vec::new(), kinds: Vec::new() };
    let deep = numbers.random.bool();
    let places = places(&mut numbers, deep);
    let pairs = pairs(&mut numbers, &places);
    let mut file = String::new();
    let body = (places.len() > 3 && numbers.random.u8(0..3) == 0).then(|| places.len() - 1);
    let fixed = write_nodes(&mut file, &mut numbers, &places, body);
    write_sections(&mut file, &mut numbers, deep);
    write_muscle(&mut file, &mut numbers);
    let kinds = write_members(&mut file, &mut numbers, (&places, &fixed), &pairs, deep);
    write_held(&mut file, &mut numbers, &places, body, deep);
    let before_steps = file.len();
    let steps = write_steps(&mut file, &mut numbers, places.len(), &kinds, deep);
    let (probes, scale) = write_probes(&mut file, &mut numbers, places.len(), pairs.len(), steps, deep);
    if holds_first {
        file.insert_str(before_steps, &first_hold(&mut numbers, seed, places.len()));
    }
    let Numbers { values, kinds, .. } = numbers;
    let parameters: Vec<String> = (1..=values.len()).map(|index| format!("p{index}")).collect();
    let written: Vec<String> =
        parameters.iter().zip(&values).map(|(name, value)| format!("{name} = {value:?}")).collect();
    let dimension = if deep { "space" } else { "plane" };
    let text = format!(
        "format = \"pennate/1\"\ndimension = \"{dimension}\"\nparameters = {{ {} }}\n{file}",
        written.join(", ")
    );
    let scales = vec![0.1 * LENGTH, 10.0, 0.1 * BENDING / LENGTH, scale][..probes.len()].to_vec();
    Random { text, parameters, probes, scales, kinds }
}

fn places(numbers: &mut Numbers, deep: bool) -> Vec<[f64; 3]> {
    let count = numbers.random.usize(2..=6);
    let side = LENGTH * (count as f64).sqrt();
    let mut places: Vec<[f64; 3]> = Vec::new();
    while places.len() < count {
        let mut coordinate = || numbers.within(0.0, side);
        let place = [coordinate(), coordinate(), if deep { coordinate() } else { 0.0 }];
        let far = |other: &[f64; 3]| distance(other, &place) > 0.6 * LENGTH;
        if places.iter().all(far) {
            places.push(place);
        }
    }
    places
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// A tree from the first node, and up to two members beyond it.
fn pairs(numbers: &mut Numbers, places: &[[f64; 3]]) -> Vec<[usize; 2]> {
    let mut pairs = Vec::new();
    for node in 1..places.len() {
        let nearest = (0..node)
            .min_by(|&a, &b| distance(&places[a], &places[node]).total_cmp(&distance(&places[b], &places[node])));
        pairs.push([nearest.unwrap_or(0), node]);
    }
    for _ in 0..numbers.random.usize(0..3) {
        let pair = [0, 1].map(|_| numbers.random.usize(0..places.len()));
        let is_new = !pairs.contains(&pair) && !pairs.contains(&[pair[1], pair[0]]);
        if pair[0] != pair[1] && is_new {
            pairs.push(pair);
        }
    }
    pairs
}

/// Writes where nodes are, and tells of each of them whether that is no parameter.
fn write_nodes(file: &mut String, numbers: &mut Numbers, places: &[[f64; 3]], body: Option<usize>) -> Vec<bool> {
    file.push_str("[nodes]\n");
    let mut fixed = Vec::new();
    for (node, place) in places.iter().enumerate() {
        let before = numbers.values.len();
        let _ = writeln!(file, "N{node} = {}", numbers.numbers("place", place));
        fixed.push(numbers.values.len() == before);
    }
    if let Some(node) = body {
        let [x, y, z] = places[node];
        let _ = writeln!(file, "TOOL = {}", numbers.numbers("place of a tool", &[x + 9.0, y + 4.0, z]));
    }
    fixed
}

fn write_sections(file: &mut String, numbers: &mut Numbers, deep: bool) {
    file.push_str("[sections]\n");
    let radius = numbers.within(1.0, 2.0);
    let _ = writeln!(file, "round = {{ circle = {{ radius = {} }} }}", numbers.number("radius", radius));
    let size = [numbers.within(3.0, 5.0), numbers.within(1.5, 3.0)];
    let [width, height] = size.map(|size| numbers.number("width or height", size));
    let _ = writeln!(file, "flat = {{ rectangle = {{ width = {width}, height = {height} }} }}");
    let bending = BENDING * numbers.within(0.5, 2.0);
    let slenderness = numbers.within(10.0, 60.0);
    let stretch = bending * (slenderness / LENGTH).powi(2);
    let _ = write!(file, "given = {{ stiffness = {{ EI3 = {}", numbers.number("EI", bending));
    let _ = write!(file, ", EA = {}", numbers.number("EA", stretch));
    if numbers.random.bool() {
        let _ = write!(file, ", GA2 = {}", numbers.number("GA", 0.4 * stretch));
        if deep {
            let _ = write!(file, ", GA3 = {}", numbers.number("GA", 0.3 * stretch));
        }
    }
    let (second, twist) = (bending * numbers.within(0.5, 2.0), bending * numbers.within(0.4, 1.0));
    let _ = write!(file, ", EI2 = {}, GJ = {}", numbers.number("EI", second), numbers.number("GJ", twist));
    let _ = writeln!(file, ", mass_per_length = {} }} }}", numbers.number("mass", 2e-7));
    let _ = writeln!(file, "wire = {{ circle = {{ radius = 1.2 }}, stretch = false }}");
    let modulus = numbers.number("modulus", 2500.0);
    let _ = writeln!(
        file,
        "[materials]\npolymer = {{ youngs_modulus = {modulus}, poissons_ratio = {}, density = {} }}",
        numbers.number("Poisson's ratio", 0.35),
        numbers.number("density", 1.1e-9)
    );
}

fn write_muscle(file: &mut String, numbers: &mut Numbers) {
    let rows = [(10.0, 3.6, -9.1e-3, 6.8, 7.9), (17.5, 3.75, -8.2e-3, 7.0, 8.5), (25.0, 4.25, -6.9e-3, 7.15, 8.9)];
    let _ = writeln!(
        file,
        "[muscles.tube]\ndiameter = {}\nend_length = 8\nwall = {}\npressure_unit = \"psi\"\ndensity = 1.1e-9\ntable = [",
        numbers.number("diameter of a muscle", 13.0),
        numbers.number("wall of a muscle", 2.0),
    );
    for (pressure, modulus, contraction, ends, middle) in rows {
        let _ = writeln!(
            file,
            "  {{ pressure = {pressure:?}, E = {}, alpha = {}, R1 = {}, R2 = {} }},",
            numbers.number("table: E", modulus),
            numbers.number("table: alpha", contraction),
            numbers.number("table: R1", ends),
            numbers.number("table: R2", middle)
        );
    }
    file.push_str("]\n");
}

/// What a member is made of.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Section,
    Muscle,
    Actuator,
}

fn write_members(
    file: &mut String,
    numbers: &mut Numbers,
    (places, fixed): (&[[f64; 3]], &[bool]),
    pairs: &[[usize; 2]],
    deep: bool,
) -> Vec<Kind> {
    file.push_str("[members]\n");
    let mut kinds = Vec::new();
    for (index, &[a, b]) in pairs.iter().enumerate() {
        let far = distance(&places[a], &places[b]);
        let beyond = index + 1 > pairs.len().saturating_sub(1).max(1);
        let release = match numbers.random.u8(0..5) {
            0 if beyond => ", release = { end = \"pin\" }".to_owned(),
            1 if beyond => ", release = { end = [\"rz\"] }".to_owned(),
            _ => String::new(),
        };
        let orientation = if deep && numbers.random.u8(0..3) == 0 {
            format!(", orientation = {}", numbers.numbers("orientation", &[0.3, 0.9, 1.1]))
        } else {
            String::new()
        };
        let (kind, made) = match numbers.random.u8(0..8) {
            0 => (Kind::Section, "section = \"round\", material = \"polymer\"".to_owned()),
            1 => (Kind::Section, "section = \"flat\", material = \"polymer\"".to_owned()),
            2 => (Kind::Section, "section = \"wire\", material = \"polymer\"".to_owned()),
            3 | 4 => (Kind::Muscle, "muscle = \"tube\"".to_owned()),
            // Lengths of segments are those of the file.
            5 if fixed[a] && fixed[b] => {
                let strain = numbers.within(-0.1, 0.05);
                let curvature = [0.0, if deep { numbers.signed(0.004) } else { 0.0 }, numbers.signed(0.006)];
                let strain = numbers.number("strain", strain);
                let curvature = numbers.numbers("curvature", &curvature);
                let length = numbers.within(0.2, 0.4);
                let rest = format!("{{ length = {:?}, section = \"given\" }}", (1.0 - length) * far);
                let bent = format!("strain = {strain}, curvature = {curvature}");
                let segment = format!("{{ length = {:?}, section = \"given\", {bent} }}", length * far);
                (Kind::Actuator, format!("segments = [{segment}, {rest}]"))
            }
            _ => (Kind::Section, "section = \"given\"".to_owned()),
        };
        let _ = writeln!(file, "m{index} = {{ nodes = [\"N{a}\", \"N{b}\"], {made}{orientation}{release} }}");
        kinds.push(kind);
    }
    kinds
}

fn write_held(file: &mut String, numbers: &mut Numbers, places: &[[f64; 3]], body: Option<usize>, deep: bool) {
    file.push_str("[supports]\nN0 = \"clamped\"\n");
    let last = places.len() - 1;
    if body.is_none() && last > 1 && numbers.random.u8(0..3) == 0 {
        let _ =
            writeln!(file, "N{last} = {{ fix = [\"ux\"], x_axis = {} }}", numbers.numbers("axis", &[0.6, 0.8, 0.0]));
    }
    if let Some(node) = body {
        let mass = numbers.number("mass of a body", 2e-6);
        let _ =
            writeln!(file, "[rigid_bodies]\nhand = {{ nodes = [\"N{node}\"], reference = \"TOOL\", mass = {mass} }}");
    }
    let stiffness = BENDING / LENGTH.powi(3);
    if numbers.random.bool() {
        let (k, turn) = (stiffness * numbers.within(0.2, 2.0), stiffness * 1e3 * numbers.within(0.2, 2.0));
        let [k, turn] = [k, turn].map(|k| numbers.number("stiffness of a spring", k));
        let _ = writeln!(file, "[springs.ground]\nnode = \"N1\"\nstiffness = {{ uy = {k}, rz = {turn} }}");
    }
    if last > 1 && numbers.random.bool() {
        let (k, length) = (stiffness * numbers.within(0.5, 3.0), distance(&places[0], &places[last]));
        let length = length * numbers.within(0.8, 1.2);
        let k = numbers.number("stiffness of a spring", k);
        let length = numbers.number("natural length", length);
        let _ =
            writeln!(file, "[springs.pull]\nnodes = [\"N0\", \"N{last}\"]\nstiffness = {k}\nnatural_length = {length}");
    }
    if last > 1 && numbers.random.u8(0..3) == 0 {
        let k = numbers.number("stiffness of a spring", stiffness);
        let turn = numbers.number("stiffness of a spring", 1e3 * stiffness);
        let out = if deep { format!(", uz = {k}") } else { String::new() };
        let _ = writeln!(
            file,
            "[springs.couple]\nnodes = [\"N1\", \"N{last}\"]\nstiffness = {{ ux = {k}, rz = {turn}{out} }}"
        );
    }
}

/// A step that holds a component where the network begins, or moves it on from there; of random numbers of its own, so that the rest of the
/// network of a seed stays what it is.
fn first_hold(numbers: &mut Numbers, seed: u64, nodes: usize) -> String {
    let mut random = fastrand::Rng::with_seed(!seed);
    let node = random.usize(1..nodes);
    let component = ["ux", "uy"][random.usize(0..2)];
    if random.bool() {
        return format!("[[steps]]\nname = \"first\"\nhold = {{ N{node} = [\"{component}\"] }}\n");
    }
    let by = (2.0 * random.f64() - 1.0) * 0.1 * LENGTH;
    numbers.values.push(by);
    numbers.kinds.push("moved by");
    let by = format!("\"= p{}\"", numbers.values.len());
    format!("[[steps]]\nname = \"first\"\ndisplace_by = {{ N{node} = {{ {component} = {by} }} }}\n")
}

/// One to three steps: loads, and then more loads, a place that is prescribed, or one that is held and moved on.
fn write_steps(file: &mut String, numbers: &mut Numbers, nodes: usize, kinds: &[Kind], deep: bool) -> usize {
    let steps = numbers.random.usize(1..=3);
    let force = 0.3 * BENDING / LENGTH.powi(2);
    let mut held: Option<(usize, &str)> = None;
    for step in 0..steps {
        let _ = writeln!(file, "[[steps]]\nname = \"s{step}\"");
        let node = numbers.random.usize(1..nodes);
        let kind = numbers.random.u8(0..8);
        match kind {
            0 | 1 if step > 0 && held.is_none() => {
                let _ = writeln!(file, "hold = {{ N{node} = [\"uy\"] }}");
                held = Some((node, "uy"));
            }
            2 if step > 0 && held.is_none() => {
                let by = numbers.signed(0.1 * LENGTH);
                let by = numbers.number("moved by", by);
                let _ = writeln!(file, "displace_by = {{ N{node} = {{ uy = {by} }} }}");
                held = Some((node, "uy"));
            }
            3 if step > 0 && held.is_none() => {
                let to = numbers.signed(0.1 * LENGTH);
                let to = numbers.number("prescribed displacement", to);
                let _ = writeln!(file, "displacement = {{ N{node} = {{ ux = {to} }} }}");
                held = Some((node, "ux"));
            }
            4 if held.is_some() => {
                if let Some((node, component)) = held.take() {
                    let _ = writeln!(file, "free = {{ N{node} = [\"{component}\"] }}");
                }
                continue;
            }
            5 if !deep && held.is_none() => {
                let turn = numbers.signed(15.0);
                let turn = numbers.number("prescribed rotation", turn);
                let _ = writeln!(file, "rotation = {{ N{node} = {{ rz = {turn} }} }}");
            }
            _ => {}
        }
        write_loads(file, numbers, nodes, kinds, force, deep);
    }
    steps
}

fn write_loads(file: &mut String, numbers: &mut Numbers, nodes: usize, kinds: &[Kind], force: f64, deep: bool) {
    let node = numbers.random.usize(1..nodes);
    if kinds.contains(&Kind::Muscle) {
        let pressure = numbers.within(11.0, 24.0);
        let _ = writeln!(file, "pressure = {{ all = {} }}", numbers.number("pressure", pressure));
    }
    if kinds.contains(&Kind::Actuator) {
        let actuation = numbers.within(0.3, 1.0);
        let _ = writeln!(file, "actuation = {{ all = {} }}", numbers.number("actuation", actuation));
    }
    if numbers.random.bool() {
        let _ = writeln!(file, "force = {{ N{node} = {} }}", numbers.vector("force", force, deep));
    }
    match numbers.random.u8(0..6) {
        0 => {
            let _ =
                writeln!(file, "follower_force = {{ N1 = {} }}", numbers.vector("follower force", 0.5 * force, deep));
        }
        1 => {
            let moment = numbers.signed(0.5 * force * LENGTH);
            let moment = numbers.numbers("moment", &[0.0, 0.0, moment]);
            let _ = writeln!(file, "moment = {{ N{node} = {moment} }}");
        }
        2 => {
            let line = numbers.vector("line load", force / LENGTH / 3.0, deep);
            let _ = writeln!(file, "distributed = {{ m0 = {line} }}");
        }
        3 => {
            let _ = writeln!(file, "gravity = {}", numbers.numbers("gravity", &[0.0, -9810.0, 0.0]));
        }
        4 => {
            let moment = numbers.signed(0.5 * force * LENGTH);
            let moment = numbers.numbers("follower moment", &[0.0, 0.0, moment]);
            let _ = writeln!(file, "follower_moment = {{ N1 = {moment} }}");
        }
        _ => {}
    }
}

fn write_probes(
    file: &mut String,
    numbers: &mut Numbers,
    nodes: usize,
    members: usize,
    steps: usize,
    deep: bool,
) -> (Vec<String>, f64) {
    file.push_str("[probes]\n");
    let mut probes = vec!["x".to_owned(), "turn".to_owned(), "root".to_owned()];
    let (node, other) = (numbers.random.usize(1..nodes), nodes - 1);
    let _ = writeln!(file, "x = {{ node = \"N{node}\", displacement = \"ux\" }}");
    let _ = writeln!(file, "turn = {{ node = \"N{node}\", rotation = \"rz\" }}");
    let component = if deep { "rx" } else { "rz" };
    let _ = writeln!(file, "root = {{ node = \"N0\", reaction = \"{component}\" }}");
    let mut scale = 0.1 * LENGTH;
    match numbers.random.u8(0..5) {
        0 => file.push_str(&format!("more = {{ nodes = [\"N0\", \"N{other}\"], distance = true }}\n")),
        1 => {
            let member = numbers.random.usize(0..members);
            file.push_str(&format!("more = {{ member = \"m{member}\", axial_force = \"middle\" }}\n"));
            scale /= LENGTH.powi(3) / BENDING;
        }
        2 => {
            file.push_str(&format!("more = {{ node = \"N{node}\", stiffness = \"uy\" }}\n"));
            scale /= LENGTH.powi(4) / BENDING;
        }
        3 => file.push_str(&format!("more = \"= x@s{} - turn / 3\"\n", steps - 1)),
        _ if steps > 1 => file.push_str("more = \"= x@s0 * 2\"\n"),
        _ => return (probes, scale),
    }
    probes.push("more".to_owned());
    (probes, scale)
}
