//! The compliant gripper: a dyad closes two jaws of strips.

use super::file::NetworkFile;
use super::{Default, Parameter, Refused, Scene, Settings, parts};

/// Half of a gripper, symmetric about x = 0: the muscle pulls the apex down, a strip carries that to the jaw.
pub(crate) const COMPLIANT_GRIPPER: Scene = Scene {
    name: "compliant_gripper",
    title: "compliant gripper, one half",
    remarks: "\
        Given: two beams of ABS a half, jaw and link; the stroke is greatest near 30 degrees. Assumed: where they are and how thick.
        The jaw may pass the plane of symmetry: contact with the other one is not modelled.",
    parameters: &[
        Parameter::length("L", 130.0, 26.0, "length of the muscle"),
        Parameter::angle("chi", 30.0, "angle between muscle and the line of the anchors"),
        Parameter::length("thickness", 1.2, 0.0, "thickness of the strips"),
        Parameter::pressure("pressure", 20.0, 25.0, "pressure"),
        Parameter::new("test", "jaw free, or held sideways", Default::Choice(&["free", "blocked"])),
    ],
    build,
};

fn build(settings: &Settings, file: &mut NetworkFile) -> Result<(), Refused> {
    file.derived("h", "L * sin(chi)", "height of the apex");
    file.node("A", ["= L * cos(chi)", "0"], "anchor");
    file.node("B", ["0", "= h"], "apex, on the axis of symmetry");
    file.node("G", ["35", "= h"], "ground");
    file.node("K", ["35", "= h + 60"], "");
    file.node("T", ["35", "= h + 140"], "tip of the jaw");
    parts::abs(file);
    parts::strip(file, "strip", "12", "\"= thickness\"", "");
    parts::silicone(file);
    file.member("muscle", ["A", "B"], parts::MUSCLE);
    for (name, pair) in [("post", ["G", "K"]), ("jaw", ["K", "T"]), ("link", ["B", "K"])] {
        file.member(name, pair, "section = \"strip\", material = \"abs\"");
    }
    file.support("A", "\"clamped\"", "");
    file.support("G", "\"clamped\"", "");
    file.support("B", "[\"ux\", \"rz\"]", "symmetry");
    let blocked = settings.word("test") == "blocked";
    if blocked {
        file.support("T", "[\"ux\"]", "held");
    }
    parts::inflate(file);
    file.probe("stroke", "{ node = \"B\", displacement = [0, -1] }", "");
    file.probe("dx", "{ node = \"T\", displacement = \"ux\" }", "of the tip");
    file.probe("dy", "{ node = \"T\", displacement = \"uy\" }", "");
    if blocked {
        file.probe("force", "{ node = \"T\", reaction = \"ux\" }", "");
    }
    Ok(())
}
