//! The soft rotary motor: four muscles turn a rotor.

use super::file::NetworkFile;
use super::parameter::{Bound, Default, Dimension, Range};
use super::{Parameter, Refused, Scene, Settings, parts};

/// A rotor on a bearing, turned by muscles that are pinned to its rim.
pub(crate) const MOTOR: Scene = Scene {
    name: "motor",
    title: "soft rotary motor",
    remarks: "\
        Given: four muscles of 130 mm, greatest rotation 48 degrees at 27 degrees and 20 psi. Inferred: pins at the rotor, clamps outside
        of the tangent, from which zeta is measured. Assumed: the radius. With fixed joints at the rotor no such maximum appears.",
    parameters: &[
        Parameter::length("L", 130.0, 26.0, "length of a muscle"),
        Parameter::length("r", 32.0, 0.0, "radius of the pins"),
        Parameter::new(
            "zeta",
            "angle of the muscles from the tangent, outwards",
            Default::Quantity(27.0, Dimension::Angle, Range { low: Bound::Closed(0.0), high: Bound::Open(90.0) }),
        ),
        Parameter::pressure("pressure", 20.0, 25.0, "pressure"),
        Parameter::new("muscles", "muscles round the rotor", Default::Count(4, 2, 36)),
    ],
    build,
};

fn build(settings: &Settings, file: &mut NetworkFile) -> Result<(), Refused> {
    parts::silicone(file);
    file.node("rotor", ["0", "0"], "bearing");
    let count = settings.count("muscles");
    let mut pins = Vec::new();
    for index in 0..count {
        let azimuth = 360.0 * index as f64 / count as f64;
        let (pin, clamp) = (format!("P{}", index + 1), format!("F{}", index + 1));
        let (x, y) = (format!("= r * cos({azimuth})"), format!("= r * sin({azimuth})"));
        file.node(pin.as_str(), [&x, &y], "");
        let outer_x = format!("{x} + L * (sin(zeta) * cos({azimuth}) - cos(zeta) * sin({azimuth}))");
        let outer_y = format!("{y} + L * (sin(zeta) * sin({azimuth}) + cos(zeta) * cos({azimuth}))");
        file.node(clamp.as_str(), [&outer_x, &outer_y], "");
        let rest = format!("{}, release = {{ end = \"pin\" }}", parts::MUSCLE);
        file.member(format!("muscle{}", index + 1), [&clamp, &pin], &rest);
        file.support(clamp, "\"clamped\"", "");
        pins.push(format!("\"{pin}\""));
    }
    let value = format!("{{ nodes = [{}], reference = \"rotor\" }}", pins.join(", "));
    file.line("rigid_bodies", "rotor", value, "");
    file.support("rotor", "[\"ux\", \"uy\"]", "bearing");
    parts::inflate(file);
    file.probe("turn", "{ node = \"rotor\", rotation = \"rz\" }", "degrees");
    Ok(())
}
