//! No text, however mangled, makes the reader panic.

use std::panic::catch_unwind;

use pennate_models::{Mesh, discretize, read_text};

/// A small generator of repeatable noise (xorshift64*).
struct Noise(u64);

impl Noise {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) as usize % limit.max(1)
    }
}

fn survives(name: &str, text: &str) {
    let outcome = catch_unwind(|| {
        if let Ok(model) = read_text(name, text, &[]) {
            let mesh = Mesh::initial(&model, 1e-6);
            let refined = mesh.refined(&model, &vec![2; model.members.len()]);
            if refined.elements() < 10_000 {
                let (structure, _) = discretize(&model, &refined);
                let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
                assert!(structure.nodes.iter().all(|node| finite(node)));
                for member in &structure.members {
                    assert!(member.axes.iter().all(|axis| finite(axis)));
                    assert!(
                        member
                            .segments
                            .iter()
                            .all(|s| s.length > 0.0 && s.elements > 0 && finite(&s.initial_curvature))
                    );
                }
            }
        }
    });
    assert!(outcome.is_ok(), "panic for:\n{text}");
}

const TOKENS: &[&str] = &[
    "0",
    "-1",
    "1e308",
    "-1e-308",
    "nan",
    "inf",
    "\"\"",
    "\"= 1/0\"",
    "\"= L\"",
    "\"5 kPa\"",
    "[]",
    "{}",
    "[0, 0]",
    "[0, 0, 0]",
    "[1e99, 0]",
    "[1, 2, 3, 4]",
    "true",
    "1979-05-27",
    "\"A\"",
    "\"all\"",
    "\"clamped\"",
    "\"ü\"",
    "[[1]]",
    "{ ux = 0 }",
    "1e-200",
    "99999",
    "\"1e99 km\"",
    "-13",
    "130",
    "\"= (((((1)))))\"",
    "1e17",
    "\"0 mm\"",
];

#[test]
fn mangled_networks_are_errors_or_networks() {
    let every_key = include_str!("../every_key.toml").replace("dimension = \"space\"\n", "").replace(
        "file = \"../muscles/silicone.toml\"",
        "diameter = 13\nwall = 2\ntable = [{ pressure = 1, E = 1, alpha = -0.1, R1 = 7, R2 = 8 }]",
    );
    let sources = [
        ("a.toml", every_key.as_str()),
        ("b.toml", include_str!("../../networks/dyad.toml")),
        ("c.json", include_str!("../../networks/dyad.json")),
    ];
    let mut noise = Noise(0x9E37_79B9_7F4A_7C15);
    for (name, source) in sources {
        // Values replaced by other values: what a user's slip looks like.
        let values: Vec<(usize, usize)> = values(source);
        for round in 0..1_500 {
            let mut text = source.to_owned();
            let count = 1 + round % 2;
            let mut chosen: Vec<(usize, usize)> = (0..count).map(|_| values[noise.below(values.len())]).collect();
            chosen.sort_unstable();
            chosen.dedup();
            for (start, end) in chosen.into_iter().rev() {
                text.replace_range(start..end, TOKENS[noise.below(TOKENS.len())]);
            }
            survives(name, &text);
        }
        // Bytes lost, doubled or changed.
        for _ in 0..500 {
            let mut bytes = source.as_bytes().to_vec();
            let (at, length) = (noise.below(bytes.len()), 1 + noise.below(20));
            let end = (at + length).min(bytes.len());
            match noise.below(3) {
                0 => drop(bytes.drain(at..end)),
                1 => bytes[at] = b"=[]{}\"',.-+0x\n"[noise.below(14)],
                _ => {
                    let copy = bytes[at..end].to_vec();
                    let to = noise.below(bytes.len());
                    bytes.splice(to..to, copy);
                }
            }
            survives(name, &String::from_utf8_lossy(&bytes));
        }
    }
}

/// Ranges of the numbers and quoted texts of a source.
fn values(source: &str) -> Vec<(usize, usize)> {
    let bytes = source.as_bytes();
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let start = at;
        if bytes[at] == b'"' {
            at += 1;
            while at < bytes.len() && bytes[at] != b'"' {
                at += 1;
            }
            at += 1;
            found.push((start, at));
        } else if bytes[at].is_ascii_digit() && (at == 0 || b" [-".contains(&bytes[at - 1])) {
            while at < bytes.len() && (bytes[at].is_ascii_alphanumeric() || b".-".contains(&bytes[at])) {
                at += 1;
            }
            found.push((start, at));
        } else {
            at += 1;
        }
    }
    found
}

#[test]
fn absurd_sizes_end_soon() {
    let deep = format!("a = {}1{}", "[".repeat(5_000), "]".repeat(5_000));
    survives("a.toml", &deep);
    survives("a.json", &deep[4..]);
    let chain: String = (0..20_000).map(|i| format!("p{i} = \"= p{} + 1\"\n", i + 1)).collect();
    survives("a.toml", &format!("[parameters]\n{chain}p20000 = 1\n"));
    survives("a.toml", &format!("[parameters]\n{chain}p20000 = \"= p0\"\n"));
    let nodes: String = (0..20_000).map(|i| format!("n{i} = [{}, {}]\n", i % 3, i / 7)).collect();
    survives("a.toml", &format!("[nodes]\n{nodes}"));
    let turns = "nodes = { A = [0, 0], B = [1e9, 0] }\nsections.s.stiffness = { EA = 1, EI3 = 1 }\nsupports.A = \"clamped\"\n\
        members.m = { nodes = [\"A\", \"B\"], section = \"s\", tangent = [1, 0], length = 1e90, initial_curvature = [0, 0, 1e50] }";
    survives("a.toml", turns);
}
