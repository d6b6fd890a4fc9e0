//! Magnitudes that nothing real has: a word about a unit that was meant otherwise.

use std::fmt::Display;

use super::context::Context;
use crate::error::{InputError, Span};
use crate::model::{Member, SegmentLaw, Units};
use crate::unit::Unit;

/// Pa: below the softest gels there is no solid to speak of; diamond has 1.2e12, and moduli in psi, which serve with
/// inches and pounds as well, reach 6e7 of what the file calls MPa.
const MODULI: [f64; 2] = [1e2, 1e14];
/// kg/m³: aerogels have 1, osmium 22,590.
const DENSITIES: [f64; 2] = [0.1, 2.5e4];
/// m/s²: a thousandth of the Earth's pull is what 9.81 mm/s² is; a thousand times is 9,810 m/s².
const FEEBLE_GRAVITY: [f64; 2] = [5e-3, 2e-2];
const STRONG_GRAVITY: f64 = 1e3;
/// Length over thickness: a hair of 0.05 mm and a metre has 2e4.
const THREAD: f64 = 2.5e4;
/// Thickness over length from which on a bar is a disc.
const DISC: f64 = 10.0;

/// A word about a modulus that no material has.
pub(crate) fn modulus(value: f64, what: impl Display, span: Span, cx: &mut Context) {
    let pascal = value * Unit::file_pressure(cx.units);
    if (MODULI[0]..=MODULI[1]).contains(&pascal) {
        return;
    }
    let side = if pascal < MODULI[0] { "softer than any gel" } else { "far stiffer than diamond" };
    let unit = cx.units.symbols()[2];
    cx.warn(
        InputError::new(format!("{what} is {value} {unit}, {side}"))
            .at(span)
            .label(format!("in {unit}"))
            .help("write it with its unit, such as \"210 GPa\" or \"0.4 MPa\""),
    );
}

/// A word about a density that no material has.
pub(crate) fn density(value: f64, what: impl Display, span: Span, cx: &mut Context) {
    let (factor, unit) = match cx.units {
        Units::MmNMpa => (1e12, "tonne/mm^3"),
        Units::MNPa => (1.0, "kg/m^3"),
    };
    if value == 0.0 || (DENSITIES[0]..=DENSITIES[1]).contains(&(value * factor)) {
        return;
    }
    let side = if value * factor < DENSITIES[0] { "lighter than any solid" } else { "heavier than any metal" };
    cx.warn(
        InputError::new(format!("{what} is {value:e} {unit}, {side}"))
            .at(span)
            .label(format!("in {unit}"))
            .help("write it with its unit, such as \"1040 kg/m^3\" or \"1.04 g/cm^3\""),
    );
}

/// A word about gravity that is the Earth's in another unit.
pub(crate) fn gravity(vector: [f64; 3], span: Span, cx: &mut Context) {
    let (factor, unit, earth) = match cx.units {
        Units::MmNMpa => (1e-3, "mm/s^2", 9810.0),
        Units::MNPa => (1.0, "m/s^2", 9.81),
    };
    let size = vector.iter().fold(0.0, |sum: f64, part| sum.hypot(*part));
    let feeble = (FEEBLE_GRAVITY[0]..=FEEBLE_GRAVITY[1]).contains(&(size * factor));
    if !feeble && size * factor <= STRONG_GRAVITY {
        return;
    }
    cx.warn(
        InputError::new(format!("gravity is {size} {unit}; the Earth's is {earth} {unit}"))
            .at(span)
            .label(format!("in {unit}"))
            .help("write it with its unit, such as [0, \"-9.81 m/s^2\", 0]"),
    );
}

/// A word about members that are far thinner or far thicker than long: one of each kind.
pub(crate) fn proportions(members: &[Option<Member>], cx: &mut Context) {
    let unit = cx.units.symbols()[0];
    let thickness = |member: &Member| {
        let shapes = member.segments.iter().filter_map(|segment| match &segment.material {
            SegmentLaw::Fixed(law) => law.shape,
            SegmentLaw::MuscleEnd(_) | SegmentLaw::MuscleMiddle(_) => None,
        });
        shapes.map(|shape| 2.0 * shape.fibres.distance[0].max(shape.fibres.distance[1])).reduce(f64::max)
    };
    let known = || members.iter().flatten().filter_map(|member| Some((member, thickness(member)?)));
    let thin = known().find(|(member, thickness)| member.length > THREAD * thickness);
    let thick = known().find(|(member, thickness)| *thickness > DISC * member.length);
    for (member, thickness, how) in
        [thin.map(|(m, t)| (m, t, "thin as a hair")), thick.map(|(m, t)| (m, t, "a disc rather than a bar"))]
            .into_iter()
            .flatten()
    {
        cx.warn(
            InputError::new(format!(
                "member '{}' is {} {unit} long and {thickness} {unit} thick: {how}",
                member.name, member.length
            ))
            .at(member.span)
            .help(format!(
                "its section or its nodes may be in another unit than {unit}: write \"1.5 mm\" or \"0.3 m\""
            )),
        );
    }
}
