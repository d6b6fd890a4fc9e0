//! The BR² manipulator: one bending and two rotating actuators side by side, as one rod that hangs from its base.

use super::file::NetworkFile;
use super::parameter::{Bound, Default, Dimension, Range};
use super::{Parameter, Refused, Scene, Settings};

/// An arm whose natural curvature, twist and stiffness follow two pressures.
pub(crate) const BR2: Scene = Scene {
    name: "br2",
    title: "BR2 manipulator",
    remarks: "\
        One bending and two rotating FREEs side by side hang from their base; only one of the rotating ones is used at a time.
        Given: length 0.31 m, mass 30 g, greatest pressures 172.36 kPa (bending) and 193.05 kPa (rotating), a Cosserat rod whose
        elasticity and precurvature were fitted to experiments; no number of that fit is printed.
        Inferred: the laws of curvature and stiffness below, by a least-squares fit of their twelve numbers to the simulated
        rows of Tables 9 and 10 with weak priors; the twist beyond 124 kPa is assumed. They are not unique: other fits do nearly
        as well. Assumed: no stretch, no shear, a base that swivels about the vertical, and that a negative pressure Pr means the
        other rotating FREE, with the mirrored motion.
        The text contradicts itself: rows that cannot be reached are numbered i, i, iii, iii in Table 9 and i to iv in Table 10.",
    parameters: &[
        Parameter::new("Pb", "bending pressure", within(124.1, Dimension::Kilopascal, 0.0, 172.36)),
        Parameter::new(
            "Pr",
            "rotating pressure, negative in the other actuator",
            within(124.1, Dimension::Kilopascal, -193.05, 193.05),
        ),
        Parameter::new(
            "load",
            "mass at the tip",
            Default::Quantity(0.0, Dimension::Gram, Range { low: Bound::Closed(0.0), high: Bound::None }),
        ),
        Parameter::new("swivel", "turn of the base about the vertical", within(0.0, Dimension::Angle, -180.0, 180.0)),
    ],
    build,
};

/// A quantity with its bounds, both of which belong to it.
const fn within(value: f64, dimension: Dimension, low: f64, high: f64) -> Default {
    Default::Quantity(value, dimension, Range { low: Bound::Closed(low), high: Bound::Closed(high) })
}

fn build(_: &Settings, file: &mut NetworkFile) -> Result<(), Refused> {
    file.derived("p", "Pb / 172.36", "share of the greatest bending pressure");
    file.derived("q", "Pr / 193.05", "share of the greatest rotating pressure");
    file.derived("EI", "10700 * (1 + 1.75 * p + 1.2 * abs(q))", "N mm2");
    file.derived("GJ", "2000 * (1 + 0.6 * abs(q))", "N mm2");
    file.derived("twist", "1e-3 * q * (4.2 + 4.8 * q^2)", "rad/mm");
    file.derived("sideways", "1e-3 * 0.65 * q", "curvature by the rotating actuator, rad/mm");
    file.derived("bending", "1e-3 * (16 * p - 8.1 * p^2 - 0.9 * abs(q))", "curvature by the bending actuator, rad/mm");
    file.node("B", ["0", "0", "0"], "base");
    file.node("T", ["0", "0", "-310"], "tip");
    // 30 g over 310 mm, in tonne/mm. Without stretch, EA counts for nothing.
    let stiffness = r#"EA = 500, GJ = "= GJ", EI2 = "= EI", EI3 = "= EI", mass_per_length = 9.6774e-8"#;
    file.line("sections", "arm", format!("{{ stiffness = {{ {stiffness} }}, stretch = false }}"), "");
    // Axis 1 points down, axis 2 along x and axis 3 against y, where the base is not turned.
    let orientation = r#"orientation = ["= cos(swivel)", "= sin(swivel)", 0]"#;
    let curvature = r#"curvature = ["= twist", "= sideways", "= bending"]"#;
    let segments = format!(r#"segments = [{{ length = 310, section = "arm", {curvature} }}]"#);
    file.member("arm", ["B", "T"], &format!("{orientation}, {segments}"));
    file.support("B", "\"clamped\"", "");
    file.step("hang", &["gravity = [0, 0, -9810]", r#"force = { T = [0, 0, "= -9.81e-3 * load"] }"#]);
    file.step("inflate", &["actuation = { arm = 1 }"]);
    for axis in ["x", "y", "z"] {
        file.probe(axis, &format!("{{ node = \"T\", position = \"{axis}\" }}"), "");
    }
    Ok(())
}
