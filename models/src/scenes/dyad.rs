//! The pennate dyad: two muscles that pull on one joint.

use super::file::NetworkFile;
use super::{Default, Parameter, Refused, Scene, Settings};

/// Two muscles between fixed anchors and an apex, which they pull towards the line of the anchors.
pub(crate) const DYAD: Scene = Scene {
    name: "dyad",
    title: "pennate dyad",
    remarks: "\
        Two muscles pull their common apex towards the line of the anchors.
        Given: 130 mm, pinned or fixed joints; greatest stroke near 22 degrees, amplified more than 5 times, pinned above fixed,
        greatest force at 90 degrees. Inferred: the angle chi is measured from the line of the anchors; section 3.1 measures it
        from the output axis. The amplification rises and falls with chi as a ratio of displacements, not of strains.",
    parameters: &[
        Parameter::length("L", 130.0, 26.0, "length of a muscle"),
        Parameter::angle("chi", 22.0, "angle between muscle and the line of the anchors"),
        Parameter::pressure("pressure", 10.0, 25.0, "pressure"),
        Parameter::new("joints", "anchors and apex", Default::Choice(&["fixed", "pinned"])),
        Parameter::new("test", "apex free, or held where it is", Default::Choice(&["free", "blocked"])),
    ],
    build,
};

fn build(settings: &Settings, file: &mut NetworkFile) -> Result<(), Refused> {
    file.node("A", ["= -L * cos(chi)", "0"], "");
    file.node("B", ["= L * cos(chi)", "0"], "");
    file.node("C", ["0", "= L * sin(chi)"], "apex");
    file.line("muscles", "silicone", "{ library = \"silicone\" }", "");
    let pinned = settings.word("joints") == "pinned";
    let rest = if pinned { "muscle = \"silicone\", release = { end = \"pin\" }" } else { "muscle = \"silicone\"" };
    file.member("left", ["A", "C"], rest);
    file.member("right", ["B", "C"], rest);
    for anchor in ["A", "B"] {
        file.support(anchor, if pinned { "\"pinned\"" } else { "\"clamped\"" }, "");
    }
    let blocked = settings.word("test") == "blocked";
    match (pinned, blocked) {
        (_, true) => file.support("C", "[\"ux\", \"uy\"]", "held"),
        (true, false) => file.support("C", "[\"ux\"]", "guided"),
        (false, false) => {}
    }
    file.step("inflate", &["pressure = { all = \"= pressure\" }"]);
    file.probe("stroke", "{ node = \"C\", displacement = [0, -1] }", "");
    file.probe("foot", "{ node = \"A\", reaction = [-1, 0] }", "along the line of the anchors");
    if blocked {
        file.probe("force", "{ node = \"C\", reaction = \"uy\" }", "that holds the apex");
    }
    Ok(())
}
