//! Braided sleeves of latex muscles: one that shortens, one that squeezes.

use super::file::NetworkFile;
use super::parameter::{Default, Dimension};
use super::{Bound, Parameter, Range, Refused, Scene, Settings};

const TEST: Parameter = Parameter::new("test", "free, or held", Default::Choice(&["free", "blocked"]));
const LEVELS: Parameter = Parameter::new("levels", "rings of joints", Default::Count(5, 3, 60));
const HELICES: Parameter = Parameter::new("helices", "helices of each hand", Default::Count(3, 2, 60));
const PRESSURE: Parameter = Parameter::pressure("pressure", 30.0, 30.0, "pressure");

const fn angle(value: f64) -> Parameter {
    let range = Range { low: Bound::Open(0.0), high: Bound::Open(90.0) };
    Parameter::new("theta", "angle of the muscles from the axis", Default::Quantity(value, Dimension::Angle, range))
}

/// The sleeve that shortens along its axis.
pub(crate) const STROKE: Scene = Scene {
    name: "sleeve_stroke",
    title: "compression sleeve 1: stroke along the axis",
    remarks: "\
        Six muscles as three right-handed and three left-handed helices, of straight cells between their crossings.
        Given: six muscles, height 110 mm, 60 degrees, fixed joints, latex; contraction 30 mm and blocked force 29.33 N at 30 psi.
        Inferred: the angle is measured from the axis (from the transverse plane the muscles would have to contract by 19.5 %, twice
        what latex does). Assumed: four cells a helix; joints held radially, in place of inner compliant beams. With pins it is a mechanism.",
    parameters: &[
        Parameter::length("L", 55.0, 16.0, "length of a cell"),
        angle(60.0),
        PRESSURE,
        LEVELS,
        HELICES,
        TEST,
    ],
    build: stroke,
};

/// The sleeve that is held at its ends and squeezes what is in it.
pub(crate) const COMPRESSION: Scene = Scene {
    name: "sleeve_compression",
    title: "compression sleeve 2: radial compression",
    remarks: "\
        The braid of sleeve 1 at 45 degrees, held at both ends; its middle moves inwards.
        Given: both ends held along the axis, 45 degrees; errors of 1.49 mm = 14.6 % and 4.27 N = 6.8 %. Inferred from these: 10.2 mm
        and 62.8 N. Assumed: height 180 mm, ends held radially and in rotation too, and that the net force of compression is half
        the sum of the radial reactions, as between two jaws.",
    parameters: &[
        Parameter::length("L", 63.64, 16.0, "length of a cell"),
        angle(45.0),
        PRESSURE,
        LEVELS,
        HELICES,
        TEST,
    ],
    build: compression,
};

fn stroke(settings: &Settings, file: &mut NetworkFile) -> Result<(), Refused> {
    braid(settings, file);
    let top = settings.count("levels") - 1;
    let blocked = settings.word("test") == "blocked";
    for (level, joint) in joints(settings) {
        let held = match level {
            0 => "\"clamped\"",
            _ if level < top => "[\"ux\", \"uy\"]",
            _ if blocked => "\"clamped\"",
            _ => "[\"ux\", \"uy\", \"rx\", \"ry\", \"rz\"]",
        };
        file.support(name(level, joint), held, "");
    }
    file.step("inflate", &["pressure = { all = \"= pressure\" }"]);
    if blocked {
        for joint in 0..settings.count("helices") {
            let probe = format!("{{ node = \"{}\", reaction = \"uz\" }}", name(top, joint));
            file.probe(&format!("f{joint}"), &probe, "");
        }
        file.probe("force", &format!("= {}", sum(settings, "f")), "of the three upper joints");
    } else {
        let node = name(top, 0);
        file.probe("contraction", &format!("{{ node = \"{node}\", displacement = [0, 0, -1] }}"), "of the whole");
    }
    Ok(())
}

fn compression(settings: &Settings, file: &mut NetworkFile) -> Result<(), Refused> {
    braid(settings, file);
    let (levels, helices) = (settings.count("levels"), settings.count("helices"));
    let blocked = settings.word("test") == "blocked";
    let ends = [0, levels - 1];
    for (level, joint) in joints(settings) {
        if ends.contains(&level) {
            file.support(name(level, joint), "\"clamped\"", "");
        } else if blocked {
            file.support(name(level, joint), "[\"ux\", \"uy\"]", "");
        }
    }
    file.step("inflate", &["pressure = { all = \"= pressure\" }"]);
    let outwards = |level: usize, joint: usize| {
        let azimuth = azimuth(level, joint, helices);
        let [cosine, sine] = [format!("cos({azimuth})"), format!("sin({azimuth})")];
        move |sign: &str| format!("[\"= {sign}{cosine}\", \"= {sign}{sine}\", 0]")
    };
    if !blocked {
        for (probe, level) in [("radial1", 1), ("radial2", levels / 2)] {
            let direction = outwards(level, 0)("-");
            file.probe(probe, &format!("{{ node = \"{}\", displacement = {direction} }}", name(level, 0)), "inwards");
        }
        return Ok(());
    }
    let mut sums = Vec::new();
    for level in 1..levels - 1 {
        for joint in 0..helices {
            let probe = format!("r{level}_{joint}");
            let direction = outwards(level, joint)("");
            file.probe(&probe, &format!("{{ node = \"{}\", reaction = {direction} }}", name(level, joint)), "");
            sums.push(probe);
        }
    }
    file.probe("radial", &format!("= {}", sums.join(" + ")), "sum that keeps the joints out");
    file.probe("net", "= radial / 2", "between two jaws");
    for joint in 0..helices {
        let probe = format!("{{ node = \"{}\", reaction = \"uz\" }}", name(levels - 1, joint));
        file.probe(&format!("f{joint}"), &probe, "");
    }
    file.probe("axial", &format!("= {}", sum(settings, "f")), "at the upper end");
    Ok(())
}

/// Joints where helices of both hands cross, and the muscles between them.
fn braid(settings: &Settings, file: &mut NetworkFile) {
    let (levels, helices) = (settings.count("levels"), settings.count("helices"));
    let half = format!("{}", 90.0 / helices as f64);
    file.derived("h", "L * cos(theta)", "distance of levels");
    file.derived("R", &format!("L * sin(theta) / (2 * sin({half}))"), "radius of the joints");
    file.line("muscles", "latex", "{ library = \"latex\" }", "");
    for (level, joint) in joints(settings) {
        let azimuth = azimuth(level, joint, helices);
        let x = format!("= R * cos({azimuth})");
        let y = format!("= R * sin({azimuth})");
        file.node(name(level, joint), [&x, &y, &format!("= {level} * h")], "");
    }
    for level in 0..levels - 1 {
        for joint in 0..helices {
            // Levels turn by half the distance of joints, so the neighbours above are the same joint and the one before.
            let start = name(level, joint);
            let before = (joint + helices - 1) % helices;
            file.member(format!("r{level}_{joint}"), [&start, &name(level + 1, joint)], "muscle = \"latex\"");
            file.member(format!("l{level}_{joint}"), [&start, &name(level + 1, before)], "muscle = \"latex\"");
        }
    }
}

/// Levels and joints, upwards and round.
fn joints(settings: &Settings) -> impl Iterator<Item = (usize, usize)> + use<> {
    let helices = settings.count("helices");
    (0..settings.count("levels")).flat_map(move |level| (0..helices).map(move |joint| (level, joint)))
}

fn name(level: usize, joint: usize) -> String {
    format!("n{level}_{joint}")
}

/// Azimuth in degrees of a joint.
fn azimuth(level: usize, joint: usize, helices: usize) -> f64 {
    180.0 / helices as f64 * ((level + 2 * joint) % (2 * helices)) as f64
}

fn sum(settings: &Settings, probe: &str) -> String {
    let names: Vec<String> = (0..settings.count("helices")).map(|joint| format!("{probe}{joint}")).collect();
    names.join(" + ")
}
