//! The shape-morphing wheel: three chains of dyads pull in a triangle's corners.

use super::file::NetworkFile;
use super::parameter::{Bound, Default, Dimension, Range};
use super::{Parameter, Refused, Scene, Settings, parts};

/// A wheel whose three farthest points move inwards, until six points carry it.
pub(crate) const WHEEL: Scene = Scene {
    name: "wheel",
    title: "shape-morphing wheel",
    remarks: "\
        Three inverted chains of three dyads pull the farthest points in; the load-bearing points stand on spokes.
        Given: triangle to hexagon, 420 to 280 mm, spokes to the load-bearing points; 20 N on the axle move these by 0 and the farthest
        points by 95 mm. Assumed: the chains, guides along their radius, struts between edges, three such layers.
        The text does not fit together: the incircle of a triangle of circumradius 420 is 210 and not 280; 485 = 280 sqrt(3) is
        the distance of neighbouring load-bearing points; 314 has no meaning. The skin is left out, it would shrink by 24 %.
        Pressing a point passes a greatest force near 6.6 N a layer at 72 mm, so that 20 N on three layers lie beyond it; the edges
        lean to one side a little before.",
    parameters: &[
        Parameter::length("rm", 420.0, 0.0, "radius of the farthest points"),
        Parameter::length("rb", 280.0, 0.0, "radius of the load-bearing points"),
        Parameter::length("h", 95.0, 0.0, "height of a stage"),
        Parameter::length("w", 130.0, 0.0, "half width of a chain"),
        Parameter::pressure("pressure", 25.0, 25.0, "pressure"),
        Parameter::new(
            "press",
            "way by which a farthest point is pressed in",
            Default::Quantity(60.0, Dimension::Length, Range { low: Bound::Closed(0.0), high: Bound::None }),
        ),
        Parameter::new(
            "load",
            "force on a load-bearing point",
            Default::Quantity(20.0, Dimension::Force, Range { low: Bound::Closed(0.0), high: Bound::None }),
        ),
        Parameter::new("path", "when edges would lean to one side", Default::Choice(&["stable", "symmetric"])),
        Parameter::new("layers", "such layers over the width of the wheel", Default::Count(3, 1, 20)),
    ],
    build,
};

fn build(settings: &Settings, file: &mut NetworkFile) -> Result<(), Refused> {
    let [rm, h, w] = ["rm", "h", "w"].map(|name| settings.number(name));
    let range = format!("greater than {} mm, three stages of {h} mm: the ring is too small for its muscles", 3.0 * h);
    settings.require("rm", rm > 3.0 * h, &range)?;
    let least = (26.0_f64.powi(2) - h.powi(2)).max(0.0).sqrt();
    settings.require(
        "w",
        h.hypot(w) > 26.0,
        &format!("greater than {least:.4} mm, for muscles longer than their ends"),
    )?;
    parts::abs(file);
    parts::steel(file);
    parts::tube(file, "strut", 6.0, 2.0);
    parts::wire(file, "spoke", "10");
    parts::silicone(file);
    file.node("axle", ["0", "0"], "");
    file.support("axle", "\"clamped\"", "");
    for (index, azimuth) in [(1, 0), (2, 120), (3, 240)] {
        chain(index, azimuth, file);
        let azimuth = azimuth + 60;
        let (x, y) = (format!("= rb * cos({azimuth})"), format!("= rb * sin({azimuth})"));
        file.node(format!("P{index}"), [&x, &y], "load-bearing");
        let spoke = "section = \"spoke\", material = \"steel\"";
        file.member(format!("spoke{index}"), ["axle", &format!("P{index}")], spoke);
    }
    let layers = settings.count("layers");
    parts::inflate(file);
    let force = |part: &str| {
        format!("force = {{ P1 = [\"= {part}load * cos(60) / {layers}\", \"= {part}load * sin(60) / {layers}\"] }}")
    };
    file.step("stand on a load-bearing point", &[&force("-")]);
    let press = "displace_by = { Q1 = { ux = \"= -press\" } }";
    let mut lines = vec![force("0 * "), press.to_owned()];
    if settings.word("path") == "symmetric" {
        lines.push("branch = \"primary\"".to_owned());
    }
    let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
    file.step("stand on a farthest point", &lines);
    file.probe("inward", "{ node = \"Q1\", displacement = [-1, 0] }", "of a farthest point");
    file.probe("sunk", "{ node = \"P1\", displacement = [\"= -cos(60)\", \"= -sin(60)\"] }", "of a load-bearing point");
    file.probe("one_layer", "{ node = \"Q1\", reaction = [-1, 0] }", "");
    file.probe("force", &format!("= {layers} * one_layer"), "that presses the farthest point in");
    Ok(())
}

/// A chain along the radius of an azimuth: anchors, centre, edges, farthest point.
fn chain(index: usize, azimuth: usize, file: &mut NetworkFile) {
    let mut node = |name: &str, stages: usize, across: &str| {
        let radius = format!("(rm - {stages} * h)");
        let place = |along: &str, beside: &str| match across {
            "" => format!("= {radius} * {along}({azimuth})"),
            sign => format!("= {radius} * {along}({azimuth}) {sign} w * {beside}({azimuth})"),
        };
        let flipped = if across == "+" { "-" } else { "+" };
        let x = match across {
            "" => place("cos", ""),
            _ => format!("= {radius} * cos({azimuth}) {flipped} w * sin({azimuth})"),
        };
        file.node(format!("{name}{index}"), [&x, &place("sin", "cos")], "");
    };
    node("A", 3, "+");
    node("B", 3, "-");
    node("C", 2, "");
    node("E", 1, "+");
    node("F", 1, "-");
    node("Q", 0, "");
    let name = |part: &str| format!("{part}{index}");
    for (muscle, [start, end]) in [
        ("m1_", ["A", "C"]),
        ("m2_", ["B", "C"]),
        ("m3_", ["C", "E"]),
        ("m4_", ["C", "F"]),
        ("m5_", ["E", "Q"]),
        ("m6_", ["F", "Q"]),
    ] {
        file.member(name(muscle), [&name(start), &name(end)], parts::MUSCLE);
    }
    file.member(name("strut"), [&name("E"), &name("F")], "section = \"strut\", material = \"abs\"");
    for anchor in ["A", "B"] {
        file.support(name(anchor), "\"clamped\"", "");
    }
    for guided in ["C", "E", "F", "Q"] {
        let guide = match azimuth {
            0 => "[\"uy\"]".to_owned(),
            _ => format!("{{ fix = [\"uy\"], x_axis = [\"= cos({azimuth})\", \"= sin({azimuth})\", 0] }}"),
        };
        file.support(name(guided), &guide, "along its radius");
    }
}
