//! One muscle as a cantilever.

use super::file::NetworkFile;
use super::parameter::{Bound, Default, Dimension, Range};
use super::{Parameter, Refused, Scene, Settings};

/// A muscle contracts, then bends under a load at its tip.
pub(crate) const MUSCLE: Scene = Scene {
    name: "muscle",
    title: "silicone muscle, clamped at one end",
    remarks: "\
        Contracts first, then carries a dead load across its tip.
        Given: 130 mm, 13 mm diameter; greatest mean stroke 17.9 mm, deflection 73.6 mm, slope 55.3 degrees.
        Inferred: deflection and slope belong to one load at 10 psi. Assumed: that load, 1.22 N, which the text does not give.
        The text gives 'radius 13 mm' beside a slenderness of 10 at 130 mm; 13 mm is the diameter.",
    parameters: &[
        Parameter::length("L", 130.0, 26.0, "length"),
        Parameter::pressure("pressure", 10.0, 25.0, "pressure"),
        Parameter::new("load", "force across the tip", Default::Quantity(1.22, Dimension::Force, FORCE)),
    ],
    build,
};

const FORCE: Range = Range { low: Bound::None, high: Bound::None };

fn build(_: &Settings, file: &mut NetworkFile) -> Result<(), Refused> {
    file.node("A", ["0", "0"], "");
    file.node("T", ["= L", "0"], "tip");
    file.line("muscles", "silicone", "{ library = \"silicone\" }", "");
    file.member("muscle", ["A", "T"], "muscle = \"silicone\"");
    file.support("A", "\"clamped\"", "");
    file.step("inflate", &["pressure = { all = \"= pressure\" }"]);
    file.step("load", &["force = { T = [0, \"= load\"] }"]);
    file.probe("stroke", "= L - x", "contraction along the axis");
    file.probe("x", "{ node = \"T\", position = \"x\" }", "");
    file.probe("deflection", "{ node = \"T\", position = \"y\" }", "");
    file.probe("slope", "{ node = \"T\", rotation = \"rz\" }", "degrees");
    Ok(())
}
