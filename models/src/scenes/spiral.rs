//! The spiral gripper: cells that bend, each turned against the one below.

use super::file::NetworkFile;
use super::parameter::{Bound, Default, Dimension, Range};
use super::{Parameter, Refused, Scene, Settings, parts};

/// A stack of cells between rigid rings; eight muscles tilt the upper ring of each.
pub(crate) const SPIRAL: Scene = Scene {
    name: "spiral",
    title: "spiral gripper",
    remarks: "\
        Each cell tilts its upper ring towards its steep muscles; turned cells on top of each other bend into a spiral.
        Given: 36 cells, 10 degrees from cell to cell, eight muscles a cell, half of them steep and half shallow, two parallel beams
        and two dyads of beams; 9.5 degrees a cell. Inferred: 60 and 30 degrees against the ring plane. Assumed: the height of a
        cell, the sections and places of the beams; these must sit on the shallow side and the dyads on the steep one.",
    parameters: &[
        Parameter::length("H", 100.0, 0.0, "height of a cell"),
        Parameter::angle("steep", 60.0, "angle of the steep muscles against the rings"),
        Parameter::angle("shallow", 30.0, "angle of the shallow muscles against the rings"),
        Parameter::new(
            "offset",
            "turn from a cell to the next",
            Default::Quantity(10.0, Dimension::Angle, Range { low: Bound::Closed(-180.0), high: Bound::Closed(180.0) }),
        ),
        Parameter::pressure("pressure", 25.0, 25.0, "pressure"),
        Parameter::new("cells", "cells", Default::Count(36, 1, 1000)),
    ],
    build,
};

/// Where the parts of a cell are joined to its rings: name, x, y.
const SEATS: [(&str, &str, &str); 8] = [
    ("s1", "xs", "ys"),
    ("s2", "xs", "-ys"),
    ("f1", "xf", "yf"),
    ("f2", "xf", "-yf"),
    ("b1", "-45", "30"),
    ("b2", "-45", "-30"),
    ("d1", "45", "30"),
    ("d2", "45", "-30"),
];

fn build(settings: &Settings, file: &mut NetworkFile) -> Result<(), Refused> {
    for angle in ["steep", "shallow"] {
        let shortest = settings.number("H") / 2.0 / settings.number(angle).to_radians().sin();
        let least = 52.0 * settings.number(angle).to_radians().sin();
        settings.require(
            "H",
            shortest > 26.0,
            &format!("greater than {least:.4} mm, for muscles longer than their two ends of 13 mm"),
        )?;
    }
    file.derived("xh", "H / 2 / tan(steep)", "place of the hubs");
    file.derived("xs", "xh + H / 2 / tan(steep) * cos(30)", "seats of the steep muscles");
    file.derived("ys", "H / 2 / tan(steep) * sin(30)", "");
    file.derived("xf", "xh - H / 2 / tan(shallow) * cos(30)", "seats of the shallow muscles");
    file.derived("yf", "H / 2 / tan(shallow) * sin(30)", "");
    parts::abs(file);
    parts::strip(file, "beam", "10", "4", "two parallel beams");
    parts::strip(file, "knee", "8", "1.5", "legs of the dyads");
    parts::silicone(file);
    cell(file);
    for (ring, level) in [("ring0", "l"), ("ring1", "u")] {
        let seats: Vec<String> = SEATS.iter().map(|(seat, ..)| format!("\"{seat}{level}\"")).collect();
        let centre = ring.replace("ring", "R");
        let value = format!("{{ nodes = [{}], reference = \"{centre}\" }}", seats.join(", "));
        file.line("rigid_bodies", ring, value, "");
    }
    file.support("R0", "\"clamped\"", "");
    let cells = settings.count("cells");
    if cells > 1 {
        file.pattern(&[
            "# The upper ring of a cell is the lower ring of the next.".to_owned(),
            format!("count = {cells}"),
            "translation = [0, 0, \"= H\"]".to_owned(),
            "rotation = { angle = \"= offset\" }".to_owned(),
        ]);
    }
    parts::inflate(file);
    file.probe("tilt", "{ body = \"ring1\", normal = [0, 0, 1] }", "of the first cell, degrees");
    for (probe, axis) in [("ux", "ux"), ("uz", "uz")] {
        file.probe(probe, &format!("{{ node = \"R1\", displacement = \"{axis}\" }}"), "");
    }
    let last = if cells > 1 { format!("R1-{cells}") } else { "R1".to_owned() };
    for axis in ["x", "y", "z"] {
        file.probe(axis, &format!("{{ node = \"{last}\", position = \"{axis}\" }}"), "of the last ring");
    }
    Ok(())
}

/// The first cell: its nodes and its members.
fn cell(file: &mut NetworkFile) {
    file.node("R0", ["0", "0", "0"], "centre of the base");
    file.node("R1", ["0", "0", "= H"], "centre of the upper ring");
    file.node("hub", ["= xh", "0", "= H / 2"], "");
    for (level, height, remark) in [("l", "0", "lower seats"), ("u", "= H", "upper seats")] {
        for (index, (seat, x, y)) in SEATS.into_iter().enumerate() {
            let [x, y] = [x, y].map(|place| match place.parse::<f64>() {
                Ok(_) => place.to_owned(),
                Err(_) => format!("= {place}"),
            });
            file.node(format!("{seat}{level}"), [&x, &y, height], if index == 0 { remark } else { "" });
        }
    }
    file.node("k1", ["60", "30", "= H / 2"], "knees of the dyads of beams");
    file.node("k2", ["60", "-30", "= H / 2"], "");
    for seat in ["s1l", "s2l", "s1u", "s2u", "f1l", "f2l", "f1u", "f2u"] {
        file.member(format!("m_{seat}"), ["hub", seat], parts::MUSCLE);
    }
    // Axis 2 in the plane of bending.
    for side in ["1", "2"] {
        let beam = "section = \"beam\", material = \"abs\", orientation = [1, 0, 0]";
        file.member(format!("beam{side}"), [&format!("b{side}l"), &format!("b{side}u")], beam);
        let knee = "section = \"knee\", material = \"abs\", orientation = [1, 0, 0]";
        let middle = format!("k{side}");
        file.member(format!("lower{side}"), [&format!("d{side}l"), &middle], knee);
        file.member(format!("upper{side}"), [&middle, &format!("d{side}u")], knee);
    }
}
