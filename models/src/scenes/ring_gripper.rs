//! The 3D gripper: muscles turn a ring that twists a cage of wires.

use super::file::NetworkFile;
use super::{Default, Parameter, Refused, Scene, Settings, parts};

/// Two muscles at a ring, six wires from the ring to a fixed circle; twisted farther, the cage narrows.
pub(crate) const RING_GRIPPER: Scene = Scene {
    name: "ring_gripper",
    title: "3D gripper of a ring and a cage of wires",
    remarks: "\
        Given: muscles on level 1, or on levels 1 and 2; loss of radius 5.2 and 5.4 mm. Inferred: the ring is free along its axis, or a cage
        of wires that hardly stretch would lock. Assumed: all dimensions. The gain of level 2 is small because only 6 of its 32 mm
        contract. Straight wires, not twisted beforehand, lose less than 1 mm.",
    parameters: &[
        Parameter::length("L", 130.0, 26.0, "length of the muscles of level 1"),
        Parameter::length("L2", 32.0, 26.0, "length of the members of level 2"),
        Parameter::length("rl", 25.0, 0.0, "radius of the lugs"),
        Parameter::length("R", 70.0, 0.0, "radius of the cage"),
        Parameter::length("H", 100.0, 0.0, "height of the cage"),
        Parameter::angle("twist", 75.0, "twist of the cage as built"),
        Parameter::length("cage", 0.8, 0.0, "diameter of the cage's wires"),
        Parameter::length("rod", 1.1, 0.0, "diameter of the wires of level 2"),
        Parameter::pressure("pressure", 25.0, 25.0, "pressure"),
        Parameter::new("levels", "levels of muscles", Default::Count(1, 1, 2)),
    ],
    build,
};

fn build(settings: &Settings, file: &mut NetworkFile) -> Result<(), Refused> {
    parts::steel(file);
    parts::wire(file, "cage", "\"= cage / 2\"");
    parts::wire(file, "rod", "\"= rod / 2\"");
    parts::silicone(file);
    file.node("ring", ["0", "0", "0"], "centre of the ring");
    let mut on_ring = Vec::new();
    let level2 = match settings.count("levels") {
        1 => "section = \"rod\", material = \"steel\"",
        _ => parts::MUSCLE,
    };
    for (side, sign) in [(1, ""), (2, "-")] {
        let [lug, joint, foot] = ["P", "J", "F"].map(|name| format!("{name}{side}"));
        let x = format!("= {sign}rl");
        file.node(lug.as_str(), [&x, "0", "0"], "lug");
        file.node(joint.as_str(), [&x, &format!("= {sign}L2"), "0"], "");
        file.node(foot.as_str(), [&x, &format!("= {sign}(L2 + L)"), "0"], "");
        file.member(format!("second{side}"), [&lug, &joint], level2);
        file.member(format!("first{side}"), [&joint, &foot], parts::MUSCLE);
        file.support(foot, "\"clamped\"", "");
        on_ring.push(format!("\"{lug}\""));
    }
    for wire in 0..6 {
        let [low, middle, high] = ["a", "m", "b"].map(|name| format!("{name}{wire}"));
        let at = |angle: &str, function: &str| format!("R * {function}({angle})");
        let (from, to) = (format!("{}", 60 * wire), format!("{} - twist", 60 * wire));
        file.node(low.as_str(), [&format!("= {}", at(&from, "cos")), &format!("= {}", at(&from, "sin")), "0"], "");
        file.node(high.as_str(), [&format!("= {}", at(&to, "cos")), &format!("= {}", at(&to, "sin")), "= H"], "");
        let half = |function: &str| format!("= ({} + {}) / 2", at(&from, function), at(&to, function));
        file.node(middle.as_str(), [&half("cos"), &half("sin"), "= H / 2"], "");
        let rest = "section = \"cage\", material = \"steel\"";
        file.member(format!("lower{wire}"), [&low, &middle], rest);
        file.member(format!("upper{wire}"), [&middle, &high], rest);
        file.support(high, "\"clamped\"", "");
        on_ring.push(format!("\"{low}\""));
    }
    let ring = format!("{{ nodes = [{}], reference = \"ring\" }}", on_ring.join(", "));
    file.line("rigid_bodies", "ring", ring, "");
    file.support("ring", "[\"ux\", \"uy\", \"rx\", \"ry\"]", "turns about its axis and moves along it");
    parts::inflate(file);
    let mut radii = Vec::new();
    for wire in 0..6 {
        for axis in ["x", "y"] {
            file.probe(&format!("{axis}{wire}"), &format!("{{ node = \"m{wire}\", position = \"{axis}\" }}"), "");
        }
        radii.push(format!("sqrt(x{wire}^2 + y{wire}^2)"));
    }
    file.probe("loss", &format!("= R * cos(twist / 2) - ({}) / 6", radii.join(" + ")), "of radius, mean of the wires");
    file.probe("turn", "{ node = \"ring\", rotation = \"rz\" }", "degrees");
    file.probe("rise", "{ node = \"ring\", displacement = \"uz\" }", "");
    Ok(())
}
