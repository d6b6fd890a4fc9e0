//! Networks that nobody would write: values, keys, rows and bytes of real ones exchanged, repeated, torn out.

use fastrand::Rng;
use serde_json::{Map, Value, json};

use super::corpus::{Corpus, toml_text};

/// Numbers at which something ends.
const NUMBERS: [f64; 28] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    2.0,
    3.0,
    0.5,
    90.0,
    360.0,
    1e-3,
    1e3,
    1e5,
    1e6,
    1_000_001.0,
    1e9,
    4_294_967_296.0,
    9_007_199_254_740_993.0,
    1e19,
    1e99,
    1e101,
    1e300,
    f64::MAX,
    f64::MIN_POSITIVE,
    5e-324,
    1e-12,
    1e-15,
    1e-99,
    1e-300,
];

/// Texts at which something ends.
const TEXTS: [&str; 44] = [
    "",
    " ",
    "=",
    "= ",
    "= 1 / 0",
    "= 0 / 0",
    "= L",
    "= pi",
    "= -L * cos(beta)",
    "= ((((1))))",
    "= 1e400",
    "= 9 ^ 9 ^ 9",
    "= (-8) ^ (1 / 3)",
    "= atan2(0, 0)",
    "= ln(0)",
    "= sqrt(-1)",
    "= min()",
    "= max(1, 2, 3)",
    "= u@one",
    "= u@",
    "= @",
    "25 psi",
    "1e400 mm",
    "-0 N",
    "1 kg m/s^2",
    "3 N^9999999999",
    "1 mm mm mm",
    "nan",
    "inf",
    "-inf N",
    "1 °",
    "50 %",
    "all",
    "clamped",
    "pinned",
    "pin",
    "uy",
    "rz",
    "x",
    "A-2",
    "\u{feff}",
    "\u{0}",
    "ä\u{301}\u{202e}🦀",
    "\\\"\n\t",
];

/// Pieces of files, for changes that know nothing of the structure.
const PIECES: [&str; 30] = [
    "[",
    "]",
    "{",
    "}",
    "=",
    ",",
    "\"",
    "'",
    "\"\"\"",
    "#",
    "\n",
    "\r\n",
    "\t",
    "\u{feff}",
    "\\u0000",
    "\\",
    "nan",
    "inf",
    "-inf",
    "1e999",
    "0x7fffffffffffffffffff",
    "1979-05-27T07:32:00Z",
    "[[steps]]\n",
    "[members]\n",
    "true",
    "null",
    ".",
    "a.b.c",
    "ä",
    "🦀",
];

/// Bytes of a file at most.
const LONGEST: usize = 1 << 20;

/// What a file of the fuzz is.
#[derive(Debug)]
pub struct Case {
    /// Name of the file, which says whether it is TOML or JSON.
    pub name: &'static str,
    /// What stands in it.
    pub bytes: Vec<u8>,
}

/// The case of a seed.
pub fn case(corpus: &Corpus, seed: u64) -> Case {
    let mut random = Rng::with_seed(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5bf0_3635);
    let json = random.u8(0..3) == 0;
    let name = if json { "fuzz.json" } else { "fuzz.toml" };
    // Short networks say as much as long ones, and sooner.
    let tries = [(); 4].map(|()| &corpus.entries[random.usize(0..corpus.entries.len())]);
    let entry = tries.into_iter().min_by_key(|entry| entry.text.len()).expect("four entries");
    // Texts as they were written have headers and comments, trees are written anew.
    let mut bytes = if random.u8(0..4) == 0 {
        if json { entry.tree.to_string() } else { entry.text.clone() }
    } else {
        let mut tree = entry.tree.clone();
        for _ in 0..count(&mut random) {
            change(&mut tree, corpus, &mut random);
        }
        if json { infinite(&tree.to_string(), &mut random) } else { infinite(&toml_text(&tree), &mut random) }
    }
    .into_bytes();
    if random.u8(0..4) == 0 {
        for _ in 0..count(&mut random) {
            tear(&mut bytes, corpus, &mut random);
        }
    }
    bytes.truncate(LONGEST);
    Case { name, bytes }
}

/// One change mostly, sometimes many.
fn count(random: &mut Rng) -> usize {
    1 + (8.0 * random.f64().powi(3)) as usize
}

/// A valid network with other numbers, most of them not far from what they were.
pub fn varied(corpus: &Corpus, seed: u64) -> Case {
    let mut random = Rng::with_seed(!seed);
    let mut tree = corpus.entries[random.usize(0..corpus.entries.len())].tree.clone();
    let part = random.f64();
    vary(&mut tree, part * part, &mut random);
    Case { name: "fuzz.toml", bytes: toml_text(&tree).into_bytes() }
}

fn vary(tree: &mut Value, part: f64, random: &mut Rng) {
    match tree {
        Value::Object(map) => map.values_mut().for_each(|value| vary(value, part, random)),
        Value::Array(items) => items.iter_mut().for_each(|value| vary(value, part, random)),
        Value::Number(number) if random.f64() < part => {
            let value = number.as_f64().unwrap_or(0.0);
            let factor = match random.u8(0..8) {
                0 => 10f64.powi(random.i32(-6..=6)),
                1 => -1.0,
                2 => 0.0,
                _ => 0.5 + random.f64(),
            };
            // Counts stay whole.
            let varied = value * factor;
            *tree = if number.is_f64() { json!(varied) } else { json!(varied.round() as i64) };
        }
        _ => {}
    }
}

/// Numbers that JSON's writer knows no text for.
fn infinite(text: &str, random: &mut Rng) -> String {
    if random.u8(0..16) != 0 {
        return text.to_owned();
    }
    text.replacen(
        "4096.25",
        ["nan", "inf", "-inf", "1e999", "1979-05-27", "0xffffffffffffffffffffff"][random.usize(0..6)],
        1,
    )
}

/// Changes one value somewhere in a tree.
fn change(tree: &mut Value, corpus: &Corpus, random: &mut Rng) {
    let total = size(tree);
    let mut at = random.usize(0..total);
    let other = &corpus.entries[random.usize(0..corpus.entries.len())].tree;
    let donor = pick(other, random.usize(0..size(other))).clone();
    let Some(place) = pick_mut(tree, &mut at) else { return };
    match random.u8(0..16) {
        0..=2 => *place = json!(NUMBERS[random.usize(0..NUMBERS.len())] * [1.0, -1.0][random.usize(0..2)]),
        3 => *place = json!(TEXTS[random.usize(0..TEXTS.len())]),
        4 => *place = json!(corpus.words[random.usize(0..corpus.words.len())]),
        5 => *place = donor,
        6 => *place = [json!(null), json!(true), json!({}), json!([]), json!(4096.25)][random.usize(0..5)].clone(),
        7 => *place = json!("long ".repeat(1 << random.u32(0..13))),
        8 => {
            // Deep nesting, as lists or tables.
            for _ in 0..1 << random.u32(0..8) {
                let inner = place.take();
                *place = if random.bool() { json!([inner]) } else { json!({ "a": inner }) };
            }
        }
        9 if place.is_number() => {
            let value = place.as_f64().unwrap_or(0.0);
            *place = json!(value * 10f64.powi(random.i32(-12..=12)));
        }
        9 | 10 if place.is_string() => {
            let text = place.as_str().unwrap_or("");
            *place = json!(format!("{text}{}", TEXTS[random.usize(0..TEXTS.len())]));
        }
        _ => match place {
            Value::Object(map) => change_table(map, donor, corpus, random),
            Value::Array(items) => change_list(items, donor, random),
            place => *place = json!(NUMBERS[random.usize(0..NUMBERS.len())]),
        },
    }
}

fn change_table(map: &mut Map<String, Value>, donor: Value, corpus: &Corpus, random: &mut Rng) {
    let keys: Vec<String> = map.keys().cloned().collect();
    let known = &corpus.keys[random.usize(0..corpus.keys.len())];
    let Some(key) = (!keys.is_empty()).then(|| &keys[random.usize(0..keys.len())]) else {
        map.insert(known.clone(), donor);
        return;
    };
    match random.u8(0..6) {
        0 => drop(map.remove(key)),
        1 => drop(map.insert(known.clone(), donor)),
        2 => {
            let value = map[key].clone();
            map.insert(known.clone(), value);
        }
        3 => {
            let value = map.remove(key).unwrap_or_default();
            map.insert(TEXTS[random.usize(0..TEXTS.len())].to_owned(), value);
        }
        4 => {
            let other = &keys[random.usize(0..keys.len())];
            let (a, b) = (map[key].clone(), map[other].clone());
            map.insert(key.clone(), b);
            map.insert(other.clone(), a);
        }
        _ => {
            let value = map[key].clone();
            (0..1 << random.u32(0..8)).for_each(|copy| drop(map.insert(format!("{key}{copy}"), value.clone())));
        }
    }
}

fn change_list(items: &mut Vec<Value>, donor: Value, random: &mut Rng) {
    let at = random.usize(0..=items.len());
    match random.u8(0..5) {
        0 => items.truncate(at),
        1 => items.insert(at, donor),
        2 if !items.is_empty() => {
            let item = items[at.min(items.len() - 1)].clone();
            items.extend(vec![item; 1 << random.u32(0..9)]);
        }
        3 if !items.is_empty() => drop(items.remove(at.min(items.len() - 1))),
        _ => items.reverse(),
    }
}

fn size(tree: &Value) -> usize {
    1 + match tree {
        Value::Object(map) => map.values().map(size).sum(),
        Value::Array(items) => items.iter().map(size).sum(),
        _ => 0,
    }
}

/// The value of a number, counted from the root.
fn pick(tree: &Value, at: usize) -> &Value {
    fn find<'a>(tree: &'a Value, at: &mut usize) -> Option<&'a Value> {
        if *at == 0 {
            return Some(tree);
        }
        *at -= 1;
        match tree {
            Value::Object(map) => map.values().find_map(|value| find(value, at)),
            Value::Array(items) => items.iter().find_map(|value| find(value, at)),
            _ => None,
        }
    }
    find(tree, &mut { at }).unwrap_or(tree)
}

fn pick_mut<'a>(tree: &'a mut Value, at: &mut usize) -> Option<&'a mut Value> {
    if *at == 0 {
        return Some(tree);
    }
    *at -= 1;
    match tree {
        Value::Object(map) => map.values_mut().find_map(|value| pick_mut(value, at)),
        Value::Array(items) => items.iter_mut().find_map(|value| pick_mut(value, at)),
        _ => None,
    }
}

/// Changes bytes, whatever they mean.
fn tear(bytes: &mut Vec<u8>, corpus: &Corpus, random: &mut Rng) {
    let at = random.usize(0..=bytes.len());
    let end = (at + (random.f64().powi(4) * 200.0) as usize).min(bytes.len());
    match random.u8(0..9) {
        0 if at < bytes.len() => bytes[at] ^= 1 << random.u8(0..8),
        1 => drop(bytes.drain(at..end)),
        2 => {
            let part = bytes[at..end].to_vec();
            bytes.splice(at..at, part);
        }
        3 => {
            let other = corpus.entries[random.usize(0..corpus.entries.len())].text.as_bytes();
            let from = random.usize(0..other.len());
            let part = other[from..(from + random.usize(0..300)).min(other.len())].to_vec();
            bytes.splice(at..at, part);
        }
        4 => bytes.truncate(at),
        5 => {
            // A line twice: a name twice.
            let start = bytes[..at].iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
            let stop = bytes[at..].iter().position(|&byte| byte == b'\n').map_or(bytes.len(), |length| at + length + 1);
            let line = bytes[start..stop].to_vec();
            bytes.splice(start..start, line);
        }
        6 => drop(bytes.splice(0..0, "\u{feff}".bytes())),
        7 => {
            let deep = PIECES[random.usize(0..4)].repeat(1 << random.u32(0..12));
            bytes.splice(at..at, deep.into_bytes());
        }
        _ => drop(bytes.splice(at..at, PIECES[random.usize(0..PIECES.len())].bytes())),
    }
}
