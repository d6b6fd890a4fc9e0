//! The networks that are measured.

use pennate_analysis::problem::Problem;
use pennate_models::Document;

/// A network with what goes in and what comes out.
pub(crate) struct Network {
    pub name: &'static str,
    pub text: String,
    pub parameters: Vec<&'static str>,
    pub probes: Vec<&'static str>,
    /// By how large a part of their value parameters differ from those of the file.
    pub spread: f64,
}

impl Network {
    pub(crate) fn problem(&self) -> Problem {
        let document = Document::from_text(&format!("{}.toml", self.name), &self.text);
        let problem = Problem::new(&document, &[], &self.parameters, &self.probes, 1e-6);
        problem.unwrap_or_else(|error| panic!("{}: {error}", self.name))
    }

    /// Random designs about the values of the file.
    pub(crate) fn rows(&self, problem: &Problem, count: usize) -> Vec<f64> {
        rows_about(&problem.middle(), self.spread, count, 1)
    }
}

/// Random designs about the middle, each number within a part of its value.
pub(crate) fn rows_about(middle: &[f64], spread: f64, count: usize, mut seed: u64) -> Vec<f64> {
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut row = |_| middle.iter().map(|value| value * (1.0 + spread * (2.0 * random() - 1.0))).collect::<Vec<_>>();
    (0..count).flat_map(&mut row).collect()
}

const DYAD: &str = include_str!("../../models/networks/dyad.toml");
const STAGE: &str = include_str!("../../models/networks/tip_tilt_stage.toml");
const CANTILEVER: &str = include_str!("../../models/networks/muscle_cantilever.toml");
const TRIPOD: &str = include_str!("../../models/networks/tripod.toml");
const ARM: &str = include_str!("br2.toml");
const INVERTER: &str = include_str!("../../bindings/python/studies/inverter.toml");
const WHOLE: &str = include_str!("../../bindings/python/studies/inverter_whole.toml");

/// Those of the table.
pub(crate) fn all() -> Vec<Network> {
    vec![dyad(), stage(), stiff_stage(), arm(), mechanism(), stiff_mechanism()]
}

/// The one of the table that has this in its name.
pub(crate) fn find(name: &str) -> Network {
    all().into_iter().find(|network| network.name.contains(name)).expect("a network of the table")
}

/// Those of the campaign: most of their designs have an answer. Some go through a limit point, or buckle.
pub(crate) fn topologies() -> Vec<Network> {
    let mut networks = all();
    networks.extend([cantilever(), tripod(), pressed_dyad(), arch(), frame(), follower(), suspension()]);
    networks.extend([("inverter", INVERTER), ("whole inverter", WHOLE)].map(|(name, text)| inverter(name, text)));
    networks
}

fn of(name: &'static str, text: &str, parameters: &[&'static str], probes: &[&'static str], spread: f64) -> Network {
    Network { name, text: text.to_owned(), parameters: parameters.to_vec(), probes: probes.to_vec(), spread }
}

/// A muscle with a load on its tip.
fn cantilever() -> Network {
    let muscles = DYAD.find("[muscles.silicone]").unwrap_or_default();
    let members = DYAD.find("[members]").unwrap_or_default();
    let file = "[muscles]\nsilicone = { file = \"../muscles/silicone.toml\" }\n";
    let text = CANTILEVER.replace(file, &DYAD[muscles..members]);
    of("muscle cantilever", &text, &["L", "load", "p"], &["x", "y", "slope", "stroke"], 0.2)
}

fn tripod() -> Network {
    of("tripod", TRIPOD, &["side", "foot"], &["lift", "tilt", "pull of leg 1"], 0.1)
}

/// The dyad under pressures beyond its table too: some designs are refused, and it may buckle.
fn pressed_dyad() -> Network {
    Network { name: "dyad beyond its table", text: dyad().text.replace("p = 22\n", "p = 25\n"), ..dyad() }
}

fn arch() -> Network {
    of("flat arch", include_str!("arch.toml"), &["F", "h", "EA"], &["drop", "thrust"], 0.2)
}

fn frame() -> Network {
    let parameters = ["height", "width", "radius", "k", "F"];
    of("portal", include_str!("frame.toml"), &parameters, &["sway", "sway under the push", "pull"], 0.2)
}

fn follower() -> Network {
    of("follower loads", include_str!("follower.toml"), &["L", "F", "M", "r"], &["x", "z", "root"], 0.15)
}

fn suspension() -> Network {
    let parameters = ["span", "side", "mass", "push"];
    of("suspended plate", include_str!("suspension.toml"), &parameters, &["sink", "shift", "tilt"], 0.2)
}

/// Inverters that are pushed back to where they were: many of their wires snap on the way.
fn inverter(name: &'static str, text: &str) -> Network {
    of(name, text, &["L1", "t1", "xO", "xG", "yG"], &["u@free", "f@blocked"], 0.3)
}

fn dyad() -> Network {
    let text = DYAD.replace("L = 130", "p = 22\nL = 130").replace("left = \"25 psi\", pair = 25", "all = \"= p\"");
    Network {
        name: "dyad",
        text,
        parameters: vec!["p", "L", "beta"],
        probes: vec!["stroke@inflate", "holding"],
        spread: 0.1,
    }
}

/// One step.
fn stage() -> Network {
    let begin = STAGE.find("[[steps]]").unwrap_or_default();
    let end = STAGE.find("[probes]").unwrap_or_default();
    let steps = "[[steps]]\nname = \"lower\"\npressure = { dyad1 = \"= p\", dyad2 = 10, dyad3 = 10 }\n\n";
    let text = format!("{}{steps}{}", &STAGE[..begin], &STAGE[end..]).replace("L = 130", "p = 15\nL = 130");
    Network {
        name: "tip-tilt stage",
        text,
        parameters: vec!["p", "L", "beta", "rp"],
        probes: vec!["height", "tilt"],
        spread: 0.05,
    }
}

/// The stage with how stiff it is besides how it stands.
fn stiff_stage() -> Network {
    let stage = stage();
    let probes =
        "[probes]\nlift = { body = \"stage\", stiffness = \"uz\" }\nturn = { body = \"stage\", stiffness = \"rx\" }\n";
    Network {
        name: "stage, stiffness",
        text: stage.text.replace("[probes]\n", probes),
        probes: vec!["height", "tilt", "lift", "turn"],
        ..stage
    }
}

/// The mechanism with the stiffness of its tip at the end.
fn stiff_mechanism() -> Network {
    let mechanism = mechanism();
    Network {
        name: "mechanism, stiffness",
        text: mechanism.text + "kx = { node = \"n8\", stiffness = \"ux\" }\n",
        probes: vec!["ux", "uy", "kx"],
        ..mechanism
    }
}

fn arm() -> Network {
    Network {
        name: "BR² arm",
        text: ARM.to_owned(),
        parameters: vec!["Pb", "Pr"],
        probes: vec!["x", "y", "z"],
        spread: 0.2,
    }
}

/// Ten members in the plane on three rows of nodes, ten steps.
fn mechanism() -> Network {
    let nodes = [(0, 0), (100, 0), (200, 0), (10, 95), (105, 100), (195, 110), (0, 205), (110, 200), (205, 195)];
    let pairs = [(0, 3), (1, 4), (2, 5), (3, 6), (4, 7), (5, 8), (3, 4), (4, 5), (6, 7), (7, 8)];
    let mut text = "format = \"pennate/1\"\ndimension = \"plane\"\n[parameters]\n".to_owned();
    for k in 0..10 {
        text += &format!("t{k} = {}\n", 10.0 + 0.3 * f64::from(k));
    }
    text += "[nodes]\n";
    for (k, (x, y)) in nodes.iter().enumerate() {
        text += &format!("n{k} = [{x}, {y}]\n");
    }
    text += "[sections]\n";
    for k in 0..10 {
        text += &format!("s{k} = {{ stiffness = {{ EA = \"= 2000 * t{k}\", EI3 = \"= 40 * t{k}^3\" }} }}\n");
    }
    text += "[members]\n";
    for (k, (a, b)) in pairs.into_iter().enumerate() {
        text += &format!("m{k} = {{ nodes = [\"n{a}\", \"n{b}\"], section = \"s{k}\" }}\n");
    }
    text += "[supports]\nn0 = \"clamped\"\nn1 = \"clamped\"\nn2 = \"clamped\"\n";
    for step in 1..=10 {
        let force = 2.0 * f64::from(step);
        text += &format!("[[steps]]\nname = \"{step}\"\nforce = {{ n8 = [{force}, {}, 0] }}\n", -0.5 * force);
    }
    text += "[probes]\nux = { node = \"n8\", displacement = \"ux\" }\nuy = { node = \"n8\", displacement = \"uy\" }\n";
    let parameters = vec!["t0", "t1", "t2", "t3", "t4", "t5", "t6", "t7", "t8", "t9"];
    Network { name: "mechanism of 10 members, 10 steps", text, parameters, probes: vec!["ux", "uy"], spread: 0.3 }
}
