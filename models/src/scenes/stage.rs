//! The tip-tilt stage: three dyads under a rigid plate.

use super::file::NetworkFile;
use super::parameter::{Bound, Default, Dimension, Range};
use super::{Parameter, Refused, Scene, Settings};

/// A plate on three dyads, lowered by even pressure, tilted by uneven pressure.
pub(crate) const STAGE: Scene = Scene {
    name: "stage",
    title: "tip-tilt stage",
    remarks: "\
        A rigid stage on three dyads, each in the vertical plane tangent to its rim.
        Given: 130 mm, 10 to 20 psi, fixed joints at the stage, stroke about 44 mm, tilt about 12 degrees, and a stiffness that is least
        at the angle of greatest stroke. Assumed: the tangential layout (radial legs tilt by 1 degree only), the radius, the feet.",
    parameters: &[
        Parameter::length("L", 130.0, 26.0, "length of a muscle"),
        Parameter::angle("beta", 27.0, "inclination of the muscles from the base plane"),
        Parameter::length("rp", 30.0, 0.0, "radius of the stage"),
        Parameter::pressure("low", 10.0, 25.0, "lower pressure"),
        Parameter::pressure("high", 20.0, 25.0, "higher pressure"),
        Parameter::new(
            "push",
            "force on the lowered stage, to measure its stiffness",
            Default::Quantity(0.5, Dimension::Force, Range { low: Bound::Open(0.0), high: Bound::None }),
        ),
        Parameter::new("feet", "joints at the base", Default::Choice(&["pinned", "clamped"])),
    ],
    build,
};

fn build(settings: &Settings, file: &mut NetworkFile) -> Result<(), Refused> {
    file.derived("H", "L * sin(beta)", "height of the stage");
    file.derived("s", "L * cos(beta)", "distance of a foot from its rim point");
    file.node("stage", ["0", "0", "= H"], "");
    file.line("muscles", "silicone", "{ library = \"silicone\" }", "");
    for (dyad, azimuth) in [(1, 0), (2, 120), (3, 240)] {
        let rim = format!("P{dyad}");
        let x = format!("rp * cos({azimuth})");
        let y = format!("rp * sin({azimuth})");
        file.node(rim.as_str(), [&format!("= {x}"), &format!("= {y}"), "= H"], "");
        for (foot, [minus, plus]) in [("a", ["+", "-"]), ("b", ["-", "+"])] {
            let name = format!("F{dyad}{foot}");
            let x = format!("= {x} {minus} s * sin({azimuth})");
            let y = format!("= {y} {plus} s * cos({azimuth})");
            file.node(name.as_str(), [&x, &y, "0"], "");
            let rest = format!("muscle = \"silicone\", group = \"dyad{dyad}\"");
            file.member(format!("leg{dyad}{foot}"), [&name, &rim], &rest);
            file.support(name, &format!("\"{}\"", settings.word("feet")), "");
        }
    }
    file.line("rigid_bodies", "stage", "{ nodes = [\"P1\", \"P2\", \"P3\"], reference = \"stage\" }", "");
    file.step("low", &["pressure = { all = \"= low\" }"]);
    file.step("one_high", &["pressure = { dyad1 = \"= high\" }"]);
    file.step("two_high", &["pressure = { dyad2 = \"= high\" }"]);
    file.step("high", &["pressure = { dyad3 = \"= high\" }"]);
    file.step("push", &["force = { stage = [0, 0, \"= -push\"] }"]);
    file.probe("stroke", "{ node = \"stage\", displacement = [0, 0, -1] }", "");
    file.probe("tilt", "{ body = \"stage\", normal = [0, 0, 1] }", "degrees");
    file.probe("stiffness", "= push / (stroke - stroke@high)", "against the push, N/mm");
    Ok(())
}
