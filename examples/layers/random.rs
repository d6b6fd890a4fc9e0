//! Random strips, threads, taut rods and hanging cables: a network file of one rod, and the rod for the reference.

use std::fmt::Write;

use fastrand::Rng;
use nalgebra::Vector3;

use crate::reference::{Held, Turned};

/// A network of one rod along x from the clamped node A to B.
pub(crate) struct Case {
    pub text: String,
    pub space: bool,
    pub weight: Vector3<f64>,
    pub held: [Held; 3],
    pub turned: Turned,
    pub follower: Vector3<f64>,
}

pub(crate) const FAMILIES: [&str; 8] = [
    "turned strip",
    "shifted thread",
    "taut rod, released end",
    "hanging cable",
    "follower force",
    "rod in space",
    "corotational",
    "stiff rod",
];

/// A number between two others, evenly spread over their logarithms.
fn between(rng: &mut Rng, low: f64, high: f64) -> f64 {
    (low.ln() + rng.f64() * (high / low).ln()).exp()
}

fn signed(rng: &mut Rng, low: f64, high: f64) -> f64 {
    let size = low + rng.f64() * (high - low);
    if rng.bool() { size } else { -size }
}

pub(crate) fn case(seed: u64) -> Case {
    let mut rng = Rng::with_seed(seed);
    let family = FAMILIES[(seed % FAMILIES.len() as u64) as usize];
    let length = between(&mut rng, 10.0, 200.0);
    let modulus = between(&mut rng, 500.0, 200_000.0);
    let strip = matches!(family, "turned strip" | "rod in space") || rng.u8(0..3) == 0;
    let thin = between(&mut rng, 0.03, 0.3);
    let wide = thin * between(&mut rng, 1.5, 60.0);
    // Stiffness of the section against stretch and against bending about the softer axis.
    let (shape, area, bending) = match strip {
        true => {
            (format!("rectangle = {{ width = {wide:?}, height = {thin:?} }}"), wide * thin, wide * thin.powi(3) / 12.0)
        }
        false => {
            let radius = 0.5 * thin;
            let pi = std::f64::consts::PI;
            (format!("circle = {{ radius = {radius:?} }}"), pi * radius * radius, 0.25 * pi * radius.powi(4))
        }
    };
    let (stretching, bending) = (modulus * area, modulus * bending);
    let stiff = match rng.u8(0..6) {
        0 => ", shear = false",
        1 => ", shear = false, stretch = false",
        _ => "",
    };
    // Straight and inextensible between two held ends nothing hangs.
    let stiff = if matches!(family, "corotational" | "hanging cable") { "" } else { stiff };
    // So many layers in the length.
    let layers = match family {
        "stiff rod" => between(&mut rng, 0.3, 5.0),
        "corotational" => between(&mut rng, 2.0, 60.0),
        _ => between(&mut rng, 5.0, 800.0),
    };
    let pull = (bending * (layers / length).powi(2)).min(0.02 * stretching);
    let held = "\n[supports]\nA = \"clamped\"\n";
    let member = match family {
        "corotational" => "formulation = \"corotational\", ",
        _ => "",
    };
    let mut text = format!(
        "format = \"pennate/1\"\n{}nodes = {{ A = [0, 0], B = [{length:?}, 0] }}\n\
         materials.m = {{ youngs_modulus = {modulus:?}, poissons_ratio = 0.3 }}\n\
         sections.s = {{ {shape}{stiff} }}\n\
         members.rod = {{ {member}nodes = [\"A\", \"B\"], section = \"s\", material = \"m\"{} }}\n{held}",
        if family == "rod in space" { "" } else { "dimension = \"plane\"\n" },
        if strip && family != "rod in space" { ", orientation = [0, 1, 0]" } else { "" }
    );
    let mut case = Case {
        text: String::new(),
        space: family == "rod in space",
        weight: Vector3::zeros(),
        held: [Held::Pulled(pull), Held::Pulled(0.0), Held::By(0.0)],
        turned: Turned::To(Vector3::zeros()),
        follower: Vector3::zeros(),
    };
    let two = rng.bool();
    let next = if two { "[[steps]]\nname = \"move\"\n" } else { "" };
    let begin = "[[steps]]\nname = \"pull\"\n";
    match family {
        "turned strip" | "corotational" | "stiff rod" => {
            let angle = signed(&mut rng, 5.0, if family == "turned strip" { 150.0 } else { 60.0 });
            let _ =
                write!(text, "{begin}force = {{ B = [{pull:?}, 0] }}\n{next}rotation = {{ B = [0, 0, {angle:?}] }}\n");
            case.turned = Turned::To(Vector3::new(0.0, 0.0, angle.to_radians()));
        }
        "shifted thread" => {
            let aside = length * signed(&mut rng, 0.002, 0.3);
            case.held[1] = Held::By(aside);
            let _ = write!(
                text,
                "{begin}force = {{ B = [{pull:?}, 0] }}\nrotation = {{ B = [0, 0, 0] }}\n{next}displacement = {{ B = {{ uy = {aside:?} }} }}\n"
            );
        }
        "taut rod, released end" => {
            let aside = pull * signed(&mut rng, 0.02, 1.5);
            case.held[1] = Held::Pulled(aside);
            case.turned = Turned::Free(Vector3::zeros());
            let _ =
                write!(text, "{begin}force = {{ B = [{pull:?}, 0] }}\n{next}force = {{ B = [{pull:?}, {aside:?}] }}\n");
            if !two {
                text = text.replacen(&format!("force = {{ B = [{pull:?}, 0] }}\n"), "", 1);
            }
        }
        "hanging cable" => {
            let layers = layers.min(200.0);
            let weight = (bending * (layers / length).powi(2) / length).min(0.01 * stretching / length);
            let nearer = -length * between(&mut rng, 0.005, 0.3);
            case.weight = Vector3::new(0.0, -weight, 0.0);
            case.held = [Held::By(nearer), Held::By(0.0), Held::By(0.0)];
            let _ = write!(
                text,
                "{begin}distributed = {{ rod = [0, {:?}, 0] }}\nrotation = {{ B = [0, 0, 0] }}\n{next}displacement = {{ B = [{nearer:?}, 0] }}\n",
                -weight
            );
            if two {
                text = text.replacen("rotation = {", "displacement = { B = [0, 0] }\nrotation = {", 1);
            }
        }
        "follower force" => {
            let aside = pull * signed(&mut rng, 0.01, 0.3);
            case.follower = Vector3::new(0.0, aside, 0.0);
            case.turned = Turned::Free(Vector3::zeros());
            let _ = write!(
                text,
                "{begin}force = {{ B = [{pull:?}, 0] }}\n{next}follower_force = {{ B = [0, {aside:?}] }}\n"
            );
        }
        _ => {
            let turn =
                Vector3::new(signed(&mut rng, 0.0, 30.0), signed(&mut rng, 5.0, 50.0), signed(&mut rng, 5.0, 50.0));
            let [y, z] = [0, 1].map(|_| length * signed(&mut rng, 0.0, 0.15));
            case.held = [Held::Pulled(pull), Held::By(y), Held::By(z)];
            case.turned = Turned::To(turn.map(f64::to_radians));
            let _ = write!(
                text,
                "{begin}force = {{ B = [{pull:?}, 0, 0] }}\n{next}displacement = {{ B = {{ uy = {y:?}, uz = {z:?} }} }}\n\
                 rotation = {{ B = [{:?}, {:?}, {:?}] }}\n",
                turn.x, turn.y, turn.z
            );
        }
    }
    let free = |i: usize| matches!(case.held[i], Held::Pulled(_));
    let axes = if case.space { 3 } else { 2 };
    text.push_str("[probes]\n");
    for i in 0..axes {
        let axis = ["x", "y", "z"][i];
        let _ = writeln!(text, "A_force_{axis} = {{ node = \"A\", reaction = \"u{axis}\" }}");
        let what = if free(i) { "displacement" } else { "reaction" };
        let name = if free(i) { "place" } else { "force" };
        let _ = writeln!(text, "B_{name}_{axis} = {{ node = \"B\", {what} = \"u{axis}\" }}");
    }
    for i in 3 - (2 * axes - 3)..3 {
        let axis = ["x", "y", "z"][i];
        let _ = writeln!(text, "A_moment_{axis} = {{ node = \"A\", reaction = \"r{axis}\" }}");
        let (name, what) = match case.turned {
            Turned::To(_) => ("moment", "reaction"),
            Turned::Free(_) => ("turn", "rotation"),
        };
        let _ = writeln!(text, "B_{name}_{axis} = {{ node = \"B\", {what} = \"r{axis}\" }}");
    }
    case.text = text;
    case
}
