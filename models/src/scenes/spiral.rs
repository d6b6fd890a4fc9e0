//! The spiral gripper: cells that bend, each turned against the one below.

use super::file::NetworkFile;
use super::parameter::{Bound, Default, Dimension, Range};
use super::{Parameter, Refused, Scene, Settings, parts};

/// A stack of cells between rigid rings; eight muscles tilt the upper ring of each.
pub const SPIRAL: Scene = Scene {
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
        Parameter::new("cells", "cells", Default::Count(36, 1, 200)),
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
    file.node("R0", ["0", "0", "0"], "centre of the base");
    let cells = settings.count("cells");
    let mut rings: Vec<Vec<String>> = vec![Vec::new(); cells + 1];
    for index in 1..=cells {
        cell(index, file);
        rings[index - 1].extend(SEATS.map(|(seat, ..)| format!("{seat}l{index}")));
        rings[index].extend(SEATS.map(|(seat, ..)| format!("{seat}u{index}")));
    }
    for (index, seats) in rings.iter().enumerate() {
        let quoted: Vec<String> = seats.iter().map(|name| format!("\"{name}\"")).collect();
        let value = format!("{{ nodes = [{}], reference = \"R{index}\" }}", quoted.join(", "));
        file.line("rigid_bodies", format!("ring{index}"), value, "");
    }
    file.support("R0", "\"clamped\"", "");
    parts::inflate(file);
    file.probe("tilt", "{ body = \"ring1\", normal = [0, 0, 1] }", "of the first cell, degrees");
    for (probe, axis) in [("ux", "ux"), ("uz", "uz")] {
        file.probe(probe, &format!("{{ node = \"R1\", displacement = \"{axis}\" }}"), "");
    }
    for axis in ["x", "y", "z"] {
        file.probe(axis, &format!("{{ node = \"R{cells}\", position = \"{axis}\" }}"), "of the last ring");
    }
    Ok(())
}

/// One cell: its nodes, turned about the axis, and its members.
fn cell(index: usize, file: &mut NetworkFile) {
    let turn = format!("{} * offset", index - 1);
    let mut node = |name: String, x: &str, y: &str, z: &str| {
        let across = format!("= {x} * cos({turn}) - {y} * sin({turn})");
        let along = format!("= {x} * sin({turn}) + {y} * cos({turn})");
        file.node(name, [&across, &along, &format!("= {z}")], "");
    };
    let (low, middle, high) =
        (format!("{} * H", index - 1), format!("{} * H", index as f64 - 0.5), format!("{index} * H"));
    node(format!("hub{index}"), "xh", "0", &middle);
    for (seat, x, y) in SEATS {
        node(format!("{seat}l{index}"), x, y, &low);
        node(format!("{seat}u{index}"), x, y, &high);
    }
    node(format!("k1_{index}"), "60", "30", &middle);
    node(format!("k2_{index}"), "60", "-30", &middle);
    file.node(format!("R{index}"), ["0", "0", &format!("= {high}")], "");
    let name = |part: &str| format!("{part}{index}");
    for seat in ["s1l", "s2l", "s1u", "s2u", "f1l", "f2l", "f1u", "f2u"] {
        file.member(format!("m{}", name(seat)), [&name("hub"), &name(seat)], parts::MUSCLE);
    }
    // Axis 2 in the plane of bending: radial, as the cell is turned.
    let radial = format!("orientation = [\"= cos({turn})\", \"= sin({turn})\", 0]");
    for side in ["1", "2"] {
        let beam = format!("section = \"beam\", material = \"abs\", {radial}");
        file.member(name(&format!("beam{side}_")), [&name(&format!("b{side}l")), &name(&format!("b{side}u"))], &beam);
        let knee = format!("section = \"knee\", material = \"abs\", {radial}");
        let middle = name(&format!("k{side}_"));
        file.member(name(&format!("lower{side}_")), [&name(&format!("d{side}l")), &middle], &knee);
        file.member(name(&format!("upper{side}_")), [&middle, &name(&format!("d{side}u"))], &knee);
    }
}
