//! Units in texts: "172 kPa", "1.1 g/cm^3", "5 N mm/rad".
//!
//! A unit is a factor to SI and the exponents of length, mass, time and angle. Angles have a dimension of their
//! own, so that a moment is no angle; where a radian goes without saying (curvature, moment per rad) both
//! forms are taken.

use std::f64::consts::PI;

use crate::input::read::suggest;
use crate::model::Units;

/// Exponents of length, mass, time and angle.
pub type Exponents = [i32; 4];

/// A unit: what one of it is in metres, kilograms, seconds and radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// What one of it is in SI units.
    pub factor: f64,
    /// Of length, mass, time and angle.
    pub exponents: Exponents,
}

/// Kinds of quantity that keys ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A number without a unit.
    Pure,
    /// Length.
    Length,
    /// Angle; bare ones are degrees.
    Angle,
    /// Force.
    Force,
    /// Moment.
    Moment,
    /// Stress or modulus.
    Stress,
    /// Strain per pressure.
    InversePressure,
    /// Mass per volume.
    Density,
    /// Mass.
    Mass,
    /// Mass per length.
    MassPerLength,
    /// Acceleration.
    Acceleration,
    /// Radians per length.
    Curvature,
    /// Force per length.
    Stiffness,
    /// Moment per radian.
    RotationalStiffness,
    /// Force times length squared.
    BendingStiffness,
    /// Force per length of a member.
    ForcePerLength,
}

/// Every kind once; the first that fits a unit names it.
const KINDS: [Kind; 16] = [
    Kind::Pure,
    Kind::Length,
    Kind::Angle,
    Kind::Force,
    Kind::Moment,
    Kind::Stress,
    Kind::InversePressure,
    Kind::Density,
    Kind::Mass,
    Kind::MassPerLength,
    Kind::Acceleration,
    Kind::Curvature,
    Kind::Stiffness,
    Kind::RotationalStiffness,
    Kind::BendingStiffness,
    Kind::ForcePerLength,
];

impl Kind {
    /// Name with article, and some units.
    pub fn description(self) -> &'static str {
        match self {
            Self::Pure => "a number without unit",
            Self::Length => "a length (mm, m, in, …)",
            Self::Angle => "an angle (deg, rad, …)",
            Self::Force => "a force (N, kN, lbf, …)",
            Self::Moment => "a moment (N mm, N m, lbf in, …)",
            Self::Stress => "a pressure or stress (kPa, MPa, psi, …)",
            Self::InversePressure => "an inverse pressure (1/psi, 1/MPa, …)",
            Self::Density => "a density (g/cm^3, kg/m^3, tonne/mm^3, …)",
            Self::Mass => "a mass (g, kg, tonne, …)",
            Self::MassPerLength => "a mass per length (g/mm, kg/m, …)",
            Self::Acceleration => "an acceleration (m/s^2, mm/s^2, …)",
            Self::Curvature => "a curvature (rad/mm, 1/m, …)",
            Self::Stiffness => "a stiffness (N/mm, N/m, …)",
            Self::RotationalStiffness => "a rotational stiffness (N mm/rad, N m/deg, …)",
            Self::BendingStiffness => "a bending stiffness (N mm^2, N m^2, …)",
            Self::ForcePerLength => "a force per length (N/mm, N/m, …)",
        }
    }

    /// Exponents of its quantities.
    pub fn exponents(self) -> Exponents {
        match self {
            Self::Pure => [0, 0, 0, 0],
            Self::Length => [1, 0, 0, 0],
            Self::Angle => [0, 0, 0, 1],
            Self::Force => [1, 1, -2, 0],
            Self::Moment => [2, 1, -2, 0],
            Self::Stress => [-1, 1, -2, 0],
            Self::InversePressure => [1, -1, 2, 0],
            Self::Density => [-3, 1, 0, 0],
            Self::Mass => [0, 1, 0, 0],
            Self::MassPerLength => [-1, 1, 0, 0],
            Self::Acceleration => [1, 0, -2, 0],
            Self::Curvature => [-1, 0, 0, 1],
            Self::Stiffness | Self::ForcePerLength => [0, 1, -2, 0],
            Self::RotationalStiffness => [2, 1, -2, -1],
            Self::BendingStiffness => [3, 1, -2, 0],
        }
    }

    /// Whether exponents are those of this kind.
    pub fn fits(self, exponents: Exponents) -> bool {
        let own = self.exponents();
        let radian_may_be_left_out = matches!(self, Self::Curvature | Self::RotationalStiffness);
        own == exponents || (radian_may_be_left_out && own[..3] == exponents[..3] && exponents[3] == 0)
    }
}

impl Unit {
    /// Whether the unit is one of pressure.
    pub fn is_pressure(&self) -> bool {
        self.fits(Kind::Stress)
    }

    /// Whether the unit measures a kind of quantity.
    pub fn fits(&self, kind: Kind) -> bool {
        kind.fits(self.exponents)
    }

    /// Whether the unit is one of plane angle and nothing else.
    pub fn is_angle(&self) -> bool {
        self.exponents == Kind::Angle.exponents()
    }

    /// What the unit measures, in words.
    pub fn description(&self) -> &'static str {
        describe(self.exponents)
    }

    /// Multiplies a value in this unit to give one in a file's units; angles stay radians.
    pub fn to_file(&self, units: Units) -> f64 {
        let [length, mass] = match units {
            Units::MmNMpa => [1e-3, 1e3],
            Units::MNPa => [1.0, 1.0],
        };
        let [of_length, of_mass, ..] = self.exponents;
        self.factor / (power(length, of_length) * power(mass, of_mass))
    }

    /// The unit of stress in a file's units, as a factor to pascals.
    pub fn file_pressure(units: Units) -> f64 {
        match units {
            Units::MmNMpa => 1e6,
            Units::MNPa => 1.0,
        }
    }
}

/// What exponents measure, in words.
pub fn describe(exponents: Exponents) -> &'static str {
    let kind = KINDS.iter().find(|kind| kind.fits(exponents));
    kind.map_or("a quantity of another kind", |kind| kind.description())
}

fn power(base: f64, exponent: i32) -> f64 {
    // Division rounds once where powi(-n) rounds twice: 1e-3 and 1e3 stay exact decimals.
    if exponent < 0 { 1.0 / base.powi(-exponent) } else { base.powi(exponent) }
}

const PREFIXES: [(&str, f64); 6] = [("k", 1e3), ("M", 1e6), ("G", 1e9), ("m", 1e-3), ("c", 1e-2), ("h", 1e2)];

const SYMBOLS: &[(&str, f64, Exponents)] = &[
    ("mm", 1e-3, [1, 0, 0, 0]),
    ("cm", 1e-2, [1, 0, 0, 0]),
    ("dm", 1e-1, [1, 0, 0, 0]),
    ("m", 1.0, [1, 0, 0, 0]),
    ("km", 1e3, [1, 0, 0, 0]),
    ("um", 1e-6, [1, 0, 0, 0]),
    ("µm", 1e-6, [1, 0, 0, 0]),
    ("μm", 1e-6, [1, 0, 0, 0]),
    ("nm", 1e-9, [1, 0, 0, 0]),
    ("in", 0.0254, [1, 0, 0, 0]),
    ("inch", 0.0254, [1, 0, 0, 0]),
    ("ft", 0.3048, [1, 0, 0, 0]),
    ("mil", 2.54e-5, [1, 0, 0, 0]),
    ("mg", 1e-6, [0, 1, 0, 0]),
    ("g", 1e-3, [0, 1, 0, 0]),
    ("kg", 1.0, [0, 1, 0, 0]),
    ("t", 1e3, [0, 1, 0, 0]),
    ("tonne", 1e3, [0, 1, 0, 0]),
    ("lb", 0.453_592_37, [0, 1, 0, 0]),
    ("lbm", 0.453_592_37, [0, 1, 0, 0]),
    ("s", 1.0, [0, 0, 1, 0]),
    ("ms", 1e-3, [0, 0, 1, 0]),
    ("min", 60.0, [0, 0, 1, 0]),
    ("rad", 1.0, [0, 0, 0, 1]),
    ("mrad", 1e-3, [0, 0, 0, 1]),
    ("deg", PI / 180.0, [0, 0, 0, 1]),
    ("degree", PI / 180.0, [0, 0, 0, 1]),
    ("degrees", PI / 180.0, [0, 0, 0, 1]),
    ("°", PI / 180.0, [0, 0, 0, 1]),
    ("turn", 2.0 * PI, [0, 0, 0, 1]),
    ("N", 1.0, [1, 1, -2, 0]),
    ("lbf", 4.448_221_615_260_5, [1, 1, -2, 0]),
    ("ozf", 0.278_013_850_953_781_2, [1, 1, -2, 0]),
    ("gf", 9.806_65e-3, [1, 1, -2, 0]),
    ("kgf", 9.806_65, [1, 1, -2, 0]),
    ("dyn", 1e-5, [1, 1, -2, 0]),
    ("Pa", 1.0, [-1, 1, -2, 0]),
    ("bar", 1e5, [-1, 1, -2, 0]),
    ("mbar", 1e2, [-1, 1, -2, 0]),
    ("atm", 101_325.0, [-1, 1, -2, 0]),
    ("mmHg", 133.322_387_415, [-1, 1, -2, 0]),
    ("psi", 4.448_221_615_260_5 / (0.0254 * 0.0254), [-1, 1, -2, 0]),
    ("ksi", 4_448.221_615_260_5 / (0.0254 * 0.0254), [-1, 1, -2, 0]),
    ("J", 1.0, [2, 1, -2, 0]),
    ("%", 0.01, [0, 0, 0, 0]),
    ("percent", 0.01, [0, 0, 0, 0]),
];

fn symbol(name: &str) -> Result<Unit, String> {
    if let Some(&(_, factor, exponents)) = SYMBOLS.iter().find(|(symbol, ..)| *symbol == name) {
        return Ok(Unit { factor, exponents });
    }
    for (prefix, scale) in PREFIXES {
        for base in ["N", "Pa"] {
            if name.strip_prefix(prefix) == Some(base) {
                let unit = symbol(base)?;
                return Ok(Unit { factor: unit.factor * scale, ..unit });
            }
        }
    }
    let common =
        ["mm", "m", "in", "N", "kN", "lbf", "Pa", "kPa", "MPa", "psi", "bar", "g", "kg", "tonne", "s", "rad", "deg"];
    Err(format!("unknown unit '{name}'; {}", suggest(name, common.into_iter(), "units")))
}

/// Reads a unit: symbols with powers, multiplied by spaces, `*` or `·`, divided by `/`, grouped by parentheses.
/// What follows a `/` up to the next `*` or `/` is divided by symbol by symbol: "N/m s" is N/m times s.
///
/// # Errors
/// A sentence that says what is not understood.
pub fn parse(text: &str) -> Result<Unit, String> {
    let mut reader = Reader { rest: text.trim(), depth: 0 };
    let unit = reader.product()?;
    if !reader.rest.is_empty() {
        return Err(format!("'{}' in the unit '{}' is not understood", reader.rest, text.trim()));
    }
    Ok(unit)
}

struct Reader<'a> {
    rest: &'a str,
    depth: usize,
}

impl Reader<'_> {
    fn product(&mut self) -> Result<Unit, String> {
        let mut unit = self.factor()?;
        loop {
            self.rest = self.rest.trim_start();
            let divide = self.rest.starts_with('/');
            if let Some(rest) = self.rest.strip_prefix(['/', '*', '·', '⋅']) {
                self.rest = rest;
            } else if self.rest.is_empty() || self.rest.starts_with(')') {
                return Ok(unit);
            }
            let next = self.factor()?;
            let sign = if divide { -1 } else { 1 };
            unit.factor = if divide { unit.factor / next.factor } else { unit.factor * next.factor };
            for (exponent, other) in unit.exponents.iter_mut().zip(next.exponents) {
                *exponent = exponent.saturating_add(sign * other);
            }
        }
    }

    fn factor(&mut self) -> Result<Unit, String> {
        self.rest = self.rest.trim_start();
        let mut unit = if let Some(rest) = self.rest.strip_prefix('(') {
            self.depth += 1;
            if self.depth > 8 {
                return Err("the parentheses of the unit are nested too deeply".to_owned());
            }
            self.rest = rest;
            let unit = self.product()?;
            self.rest =
                self.rest.strip_prefix(')').ok_or_else(|| "a parenthesis of the unit is not closed".to_owned())?;
            self.depth -= 1;
            unit
        } else if let Some(rest) = self.rest.strip_prefix('1') {
            self.rest = rest;
            Unit { factor: 1.0, exponents: [0; 4] }
        } else {
            let end = self.rest.find(|c: char| !(c.is_alphabetic() || c == '°' || c == '%')).unwrap_or(self.rest.len());
            if end == 0 {
                return Err(match self.rest.chars().next() {
                    Some(odd) => format!("a unit cannot hold '{odd}' here"),
                    None => "the unit is not complete".to_owned(),
                });
            }
            let (name, rest) = self.rest.split_at(end);
            self.rest = rest;
            symbol(name)?
        };
        let exponent = self.exponent()?;
        unit.factor = power(unit.factor, exponent);
        for own in &mut unit.exponents {
            *own = own.saturating_mul(exponent);
        }
        Ok(unit)
    }

    fn exponent(&mut self) -> Result<i32, String> {
        for (sign, value) in [("²", 2), ("³", 3), ("⁴", 4)] {
            if let Some(rest) = self.rest.strip_prefix(sign) {
                self.rest = rest;
                return Ok(value);
            }
        }
        let trimmed = self.rest.trim_start();
        let (rest, marked) = match trimmed.strip_prefix("**").or_else(|| trimmed.strip_prefix('^')) {
            Some(rest) => (rest.trim_start(), true),
            None => (self.rest, false),
        };
        let sign = usize::from(rest.starts_with('-') && marked);
        let digits = rest[sign..].find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len() - sign);
        if digits == 0 {
            return if marked { Err("the power of a unit is a whole number".to_owned()) } else { Ok(1) };
        }
        let exponent: i32 = rest[..sign + digits].parse().unwrap_or(i32::MAX);
        if !(-6..=6).contains(&exponent) {
            return Err("the power of a unit is at most 6".to_owned());
        }
        self.rest = &rest[sign + digits..];
        Ok(exponent)
    }
}

/// Splits a text such as "172 kPa" into its number and its unit; `None` where it does not begin with a number.
pub fn split_quantity(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let bytes = text.as_bytes();
    let digits = |mut at: usize| {
        while bytes.get(at).is_some_and(|byte| byte.is_ascii_digit() || *byte == b'_') {
            at += 1;
        }
        at
    };
    let mut end = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let start = end;
    end = digits(end);
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if end == start {
        return None;
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = end + 1 + usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        if digits(sign) > sign {
            end = digits(sign);
        }
    }
    let number = text[..end].replace('_', "").parse().ok()?;
    Some((number, text[end..].trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn in_mm(text: &str, kind: Kind) -> f64 {
        let (value, unit) = split_quantity(text).unwrap();
        let unit = parse(unit).unwrap();
        assert!(kind.fits(unit.exponents), "{text} is no {kind:?}");
        value * unit.to_file(Units::MmNMpa)
    }

    #[test]
    fn quantities_become_file_units() {
        let near = |text: &str, kind, expected: f64| {
            let value = in_mm(text, kind);
            assert!((value - expected).abs() <= 1e-14 * expected.abs(), "{text}: {value} for {expected}");
        };
        near("172 kPa", Kind::Stress, 0.172);
        near("25 psi", Kind::Stress, 25.0 * 6.894_757_293_168_361e-3);
        near("0.5 in", Kind::Length, 12.7);
        near("0.5in", Kind::Length, 12.7);
        near("40 deg", Kind::Angle, 40.0_f64.to_radians());
        near("5 N/mm", Kind::Stiffness, 5.0);
        near("2 N mm", Kind::Moment, 2.0);
        near("2 N*m", Kind::Moment, 2000.0);
        near("1.1 g/cm^3", Kind::Density, 1.1e-9);
        near("1100 kg/m³", Kind::Density, 1.1e-9);
        near("9.81 m/s^2", Kind::Acceleration, 9810.0);
        near("9.81 m s^-2", Kind::Acceleration, 9810.0);
        near("3 tonne", Kind::Mass, 3.0);
        near("2 N m/rad", Kind::RotationalStiffness, 2000.0);
        near("2 N/(mm rad) mm^2", Kind::RotationalStiffness, 2.0);
        near("90 deg/m", Kind::Curvature, 1.570_796_326_794_896_6e-3);
        near("4 1/m", Kind::Curvature, 4e-3);
        near("1e3 N mm2", Kind::BendingStiffness, 1e3);
        near("1 lbf", Kind::Force, 4.448_221_615_260_5);
    }

    #[test]
    fn what_is_no_unit_is_refused() {
        for text in ["", "parsec", "N/", "N^", "N^x", "N^9", "(N", "N)", "N$", "((((((((((N", "ms/ (", "N^-"] {
            assert!(parse(text).is_err(), "{text}");
        }
        assert!(parse("mpa").unwrap_err().contains("did you mean 'MPa'"));
        assert!(split_quantity("abc").is_none());
        assert!(split_quantity("-").is_none());
        assert!(split_quantity("1e").is_some_and(|(value, unit)| value == 1.0 && unit == "e"));
    }
}
