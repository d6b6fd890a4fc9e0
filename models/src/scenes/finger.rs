//! The bending finger: a spine that contracts on one side.

use super::file::NetworkFile;
use super::{Default, Parameter, Refused, Scene, Settings, parts};

/// Dyads in an inverted chain pull one side of a compliant spine; a zigzag of muscles stiffens the other.
pub(crate) const FINGER: Scene = Scene {
    name: "finger",
    title: "bending finger",
    remarks: "\
        Given: height 528 mm, six dyads in the compliant section, three and a half in the stiff one, beams from the ground up;
        tip displacement 295 and 79 mm, blocked force about 26 N at 25 psi. Assumed: the angle of the dyads and all sections.
        The reported displacement cannot belong to a point of the neutral line: sqrt(295^2 + 449^2) = 537 is more than 528.
        Inferred from that: the tip lies 35 mm beside it, on the convex side.",
    parameters: &[
        Parameter::length("H", 528.0, 0.0, "height"),
        Parameter::angle("chi", 35.0, "angle of the dyads against the ground"),
        Parameter::length("b", 35.0, 0.0, "width of the stiff section"),
        Parameter::length("depth", 5.0, 0.0, "thickness of the two strips of the spine"),
        Parameter::pressure("pressure", 25.0, 25.0, "pressure"),
        Parameter::new("test", "tip free, or held sideways", Default::Choice(&["free", "blocked"])),
    ],
    build,
};

fn build(settings: &Settings, file: &mut NetworkFile) -> Result<(), Refused> {
    let (height, sine) = (settings.number("H"), settings.number("chi").to_radians().sin());
    let long_enough = height / 6.0 / sine > 26.0 && height / 7.0 > 26.0;
    settings.require("H", long_enough, "greater than 182 mm, for muscles longer than their two ends of 13 mm")?;
    file.derived("h", "H / 6", "height of a stage");
    file.derived("a", "h / tan(chi)", "half width of a dyad");
    parts::abs(file);
    parts::strip(file, "strip", "15", "\"= depth\"", "");
    parts::tube(file, "strut", 5.0, 2.0);
    parts::silicone(file);
    nodes(file);
    // The spine, from node to node upwards: two strips side by side.
    let spine = ["S0", "S1", "S2", "E1", "S3", "S4", "E2", "S5", "S6", "S7"];
    for (index, pair) in spine.windows(2).enumerate() {
        for strip in ["a", "b"] {
            file.member(format!("spine{index}{strip}"), [pair[0], pair[1]], "section = \"strip\", material = \"abs\"");
        }
    }
    for (index, [edge, outer, centre]) in [
        ["S0", "F0", "C1"],
        ["E1", "F1", "C1"],
        ["E1", "F1", "C2"],
        ["E2", "F2", "C2"],
        ["E2", "F2", "C3"],
        ["S7", "F3", "C3"],
    ]
    .into_iter()
    .enumerate()
    {
        file.member(format!("right{}", index + 1), [edge, centre], parts::MUSCLE);
        file.member(format!("left{}", index + 1), [outer, centre], parts::MUSCLE);
    }
    let zigzag = ["S0", "O1", "S2", "O3", "S4", "O5", "S6", "O7"];
    for (index, pair) in zigzag.windows(2).enumerate() {
        file.member(format!("stiff{}", index + 1), [pair[0], pair[1]], parts::MUSCLE);
    }
    for (name, pair) in [
        ("strut1", ["E1", "F1"]),
        ("strut2", ["E2", "F2"]),
        ("bar1", ["S1", "O1"]),
        ("bar3", ["S3", "O3"]),
        ("bar5", ["S5", "O5"]),
    ] {
        file.member(name, pair, "section = \"strut\", material = \"abs\"");
    }
    file.line("rigid_bodies", "tip", "{ nodes = [\"S7\", \"F3\", \"O7\"] }", "plate at the top");
    file.support("S0", "\"clamped\"", "");
    file.support("F0", "\"clamped\"", "");
    let blocked = settings.word("test") == "blocked";
    if blocked {
        file.support("S7", "[\"ux\"]", "held");
    }
    parts::inflate(file);
    file.probe("dx", "{ node = \"O7\", displacement = \"ux\" }", "of the tip");
    file.probe("dy", "{ node = \"O7\", displacement = \"uy\" }", "");
    file.probe("turn", "{ node = \"O7\", rotation = \"rz\" }", "of the plate, degrees");
    if blocked {
        file.probe("force", "{ node = \"S7\", reaction = \"ux\" }", "");
    }
    Ok(())
}

fn nodes(file: &mut NetworkFile) {
    file.node("S0", ["0", "0"], "spine");
    for index in 1..=7 {
        let y = format!("= {index} * H / 7");
        file.node(format!("S{index}"), ["0", &y], "");
        if index % 2 == 1 {
            file.node(format!("O{index}"), ["= b", &y], if index == 7 { "tip" } else { "stiff section" });
        }
    }
    for index in 1..=2 {
        file.node(format!("E{index}"), ["0", &format!("= {} * h", 2 * index)], "spine, where the dyads meet it");
    }
    for index in 0..=3 {
        file.node(format!("F{index}"), ["= -2 * a", &format!("= {} * h", 2 * index)], "outer edge of the dyads");
    }
    for index in 1..=3 {
        file.node(format!("C{index}"), ["= -a", &format!("= {} * h", 2 * index - 1)], "centre of the dyads");
    }
}
