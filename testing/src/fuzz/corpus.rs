//! Networks to begin with: those that come with pennate, small enough to be tried often.

use std::path::Path;

use pennate_models::scenes::SCENES;
use serde_json::{Map, Value};

/// Longer networks take so long that others are not tried.
const LONGEST: usize = 5_000;

/// Every table of the file that the networks in the repository leave out.
const REST: &str = r#"
format = "pennate/1"
title = "rest"
units = "mm-N-MPa"
formulation = "corotational"
nodes = { A = [0, 0, 0], B = ["10 cm", 0, 0], C = [200, 0, 3], D = [300, 0, 0], E = [300, 50, 0] }
materials.m = { youngs_modulus = "2 GPa", shear_modulus = 700, density = 1e-9 }
sections.r = { rectangle = { width = 10, height = 2 }, shear_factor = 0.8, stretch = false }
sections.c = { circle = { radius = 1.5 }, shear = false }
sections.a = { annulus = { outer_radius = 6, wall = 2 } }
sections.s = { stiffness = { EA = 100, GA2 = 50, GA3 = 50, GJ = 700, EI2 = 900, EI3 = 900, mass_per_length = 1e-9 } }
[members]
ab = { nodes = ["A", "B"], section = "r", material = "m", orientation = [0, 0, 1], release = { start = "pin", end = ["rz"] }, group = "g" }
bc = { nodes = ["B", "C"], section = "s", arc = [150, 20, 0], elements = 3, order = 2, formulation = "exact" }
de = { nodes = ["D", "E"], segments = [{ length = 20, section = "s", strain = -0.1, curvature = [0, 0, 0.01] }, { length = 30, section = "s", elements = 2 }], release = { end = { hinge = [0, 0, 1] } } }
[supports]
A = "clamped"
E = { fix = ["ux", "uy", "uz"], x_axis = [0.6, 0.8, 0] }
[rigid_bodies]
cd = { nodes = ["C", "D"], reference = "C", mass = 1e-6 }
[springs]
ground = { node = "B", stiffness = { uy = 2, rz = 5 } }
axial = { nodes = ["A", "C"], stiffness = 0.01, natural_length = 60 }
coupling = { nodes = ["B", "D"], stiffness = { ux = 1, rz = 5 } }
[[steps]]
name = "one"
force = { B = [0, 1, 0] }
moment = { B = [0, 0, 3] }
follower_force = { C = [0, 0.1, 0] }
follower_moment = { C = [0, 0, 0.1] }
distributed = { ab = [0, 1e-3, 0] }
gravity = [0, -9810, 0]
actuation = { de = 1 }
displacement = { D = { uy = 1 } }
[[steps]]
name = "two"
method = "arc_length"
branch = "primary"
increments = 3
hold = { B = ["ux"] }
displace_by = { D = { uy = -1 } }
stop = { node = "B", displacement = "uy", at = -60 }
[[steps]]
free = { B = ["ux"] }
method = "jump"
rotation = { C = [0, 0, 15] }
[probes]
u = { node = "B", displacement = "uy" }
r = { node = "A", reaction = [1, 1, 0] }
t = { body = "cd", normal = [0, 0, 1] }
g = { nodes = ["A", "C"], distance = true }
n = { member = "ab", axial_force = "middle" }
k = { node = "B", stiffness = "uy" }
x = "= 2 * u@one - r / 3"
"#;

/// Patterns of every kind.
const COPIES: &str = r#"
format = "pennate/1"
parameters = { n = 6, a = "= 360 / n" }
nodes = { A = [100, 0], B = [50, 80], C = [20, 0, 5] }
sections.s = { stiffness = { EA = 100, GA2 = 50, GA3 = 50, GJ = 700, EI2 = 900, EI3 = 900 } }
members.ab = { nodes = ["A", "B"], section = "s", group = "g", release = { end = { hinge = [0, 0, 1] } } }
members.bc = { nodes = ["B", "C"], section = "s", arc = [30, 30, 0] }
rigid_bodies.b = { nodes = ["B", "C"], mass = 1 }
springs.k = { nodes = ["A", "C"], stiffness = 0.1 }
supports = { A = "clamped", B = { fix = ["uy"], x_axis = [1, 1, 0] } }
[[patterns]]
count = 6
rotation = { angle = "= a", axis = [0, 0, 1], point = [0, 0, 0] }
supports = true
merge = 1e-6
[[patterns]]
count = 2
members = ["g", "bc"]
translation = [0, 0, "10 mm"]
[[steps]]
force = { C-2 = [0, 0, 1] }
"#;

/// A network as text, and as a tree.
#[derive(Debug)]
pub struct Entry {
    /// As the file has it.
    pub text: String,
    /// What it says.
    pub tree: Value,
}

/// All networks, and the keys and texts that stand in them.
#[derive(Debug)]
pub struct Corpus {
    /// All networks.
    pub entries: Vec<Entry>,
    /// Every key that one of them has, once.
    pub keys: Vec<String>,
    /// Every text that one of them has, once.
    pub words: Vec<String>,
}

impl Corpus {
    /// Reads the networks of the repository at `root`.
    pub fn read(root: &Path) -> Self {
        let mut texts = vec![REST.to_owned(), COPIES.to_owned()];
        let cases = folders(&root.join("validation"));
        for folder in [root.join("models/networks")].into_iter().chain(cases) {
            let mut files: Vec<_> =
                std::fs::read_dir(&folder).expect("a folder").map(|entry| entry.expect("a file").path()).collect();
            files.sort();
            let networks = files.iter().filter(|file| file.extension().is_some_and(|extension| extension == "toml"));
            texts.extend(networks.map(|file| std::fs::read_to_string(file).expect("a text")));
        }
        texts.extend(SCENES.iter().map(|scene| scene.write(&[]).expect("a scene")));
        texts.retain(|text| text.len() <= LONGEST && text.contains("[members") || text.contains("members."));
        let mut corpus = Self { entries: Vec::new(), keys: Vec::new(), words: Vec::new() };
        for text in texts {
            let tree: Value = toml::from_str(&text).expect("a network");
            corpus.gather(&tree);
            corpus.entries.push(Entry { text, tree });
        }
        corpus.keys.sort();
        corpus.keys.dedup();
        corpus.words.sort();
        corpus.words.dedup();
        corpus
    }

    fn gather(&mut self, tree: &Value) {
        match tree {
            Value::Object(map) => map.iter().for_each(|(key, value)| {
                self.keys.push(key.clone());
                self.gather(value);
            }),
            Value::Array(items) => items.iter().for_each(|item| self.gather(item)),
            Value::String(text) => self.words.push(text.clone()),
            _ => {}
        }
    }
}

fn folders(root: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(root).expect("a folder").map(|entry| entry.expect("a folder").path());
    let mut folders: Vec<_> = entries.filter(|path| path.is_dir()).collect();
    folders.sort();
    folders
}

/// A tree as TOML: every table of the top on a line of its own, the rest inline. Null has no TOML, which is one more
/// thing to be refused.
pub(super) fn toml_text(tree: &Value) -> String {
    let empty = Map::new();
    let top = tree.as_object().unwrap_or(&empty);
    let lines = top.iter().map(|(key, value)| format!("{} = {}\n", quoted(key), inline(value)));
    lines.collect()
}

fn inline(value: &Value) -> String {
    match value {
        Value::Object(map) => {
            let entries: Vec<String> =
                map.iter().map(|(key, value)| format!("{} = {}", quoted(key), inline(value))).collect();
            format!("{{ {} }}", entries.join(", "))
        }
        Value::Array(items) => format!("[{}]", items.iter().map(inline).collect::<Vec<_>>().join(", ")),
        Value::String(text) => quoted(text),
        other => other.to_string(),
    }
}

/// JSON's way of quoting is one of TOML's.
fn quoted(text: &str) -> String {
    Value::String(text.to_owned()).to_string()
}
