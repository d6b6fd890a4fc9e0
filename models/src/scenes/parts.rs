//! What several scenes are made of.

use super::file::NetworkFile;

/// ABS, as printed.
pub(crate) fn abs(file: &mut NetworkFile) {
    let value = "{ youngs_modulus = 2200, poissons_ratio = 0.3, density = \"1.04 g/cm^3\" }";
    file.line("materials", "abs", value, "");
}

/// Spring steel.
pub(crate) fn steel(file: &mut NetworkFile) {
    let value = "{ youngs_modulus = 2e5, poissons_ratio = 0.3, density = \"7.85 g/cm^3\" }";
    file.line("materials", "steel", value, "");
}

/// The silicone muscle.
pub(crate) fn silicone(file: &mut NetworkFile) {
    file.line("muscles", "silicone", "{ library = \"silicone\" }", "");
}

/// What makes a member a silicone muscle.
pub(crate) const MUSCLE: &str = "muscle = \"silicone\"";

/// A shear-rigid rectangular section, as the dissertation's beams are; `depth` lies along axis 2.
pub(crate) fn strip(file: &mut NetworkFile, name: &str, width: &str, depth: &str, remark: &str) {
    let value = format!("{{ rectangle = {{ width = {width}, height = {depth} }}, shear = false }}");
    file.line("sections", name, value, remark);
}

/// A shear-rigid wire.
pub(crate) fn wire(file: &mut NetworkFile, name: &str, radius: &str) {
    let value = format!("{{ circle = {{ radius = {radius} }}, shear = false }}");
    file.line("sections", name, value, "");
}

/// A shear-rigid tube.
pub(crate) fn tube(file: &mut NetworkFile, name: &str, radius: f64, wall: f64) {
    let value = format!("{{ annulus = {{ outer_radius = {radius}, wall = {wall} }}, shear = false }}");
    file.line("sections", name, value, "");
}

/// Inflates all muscles at once.
pub(crate) fn inflate(file: &mut NetworkFile) {
    file.step("inflate", &["pressure = { all = \"= pressure\" }"]);
}
