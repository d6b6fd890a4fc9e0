//! What is fitted at one pressure, within bounds.
//!
//! Optimizers work on unbounded variables z: ln p = a + (b − a) (1 + sin z)/2 for the bounds eᵃ and eᵇ, as in MINUIT. Each
//! parameter is positive and of unknown size, hence the logarithm.

use pennate_models::hsim::Row;
use pennate_solver::sensitivity::SegmentSensitivity;

use super::muscle;

/// A parameter of a muscle at one pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// Outer radius of the ends, mm.
    EndRadius,
    /// Outer radius of the middle, mm.
    MiddleRadius,
    /// Of the whole muscle, or of the middle where the ends have their own.
    Modulus,
    /// Young's modulus of the ends, MPa.
    EndModulus,
}

impl Parameter {
    /// Its key in the muscle's table.
    pub fn key(self) -> &'static str {
        match self {
            Self::EndRadius => "R1",
            Self::MiddleRadius => "R2",
            Self::Modulus => "E",
            Self::EndModulus => "E1",
        }
    }

    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::EndRadius | Self::MiddleRadius => "mm",
            Self::Modulus | Self::EndModulus => "MPa",
        }
    }
}

/// The parameters of a fit with their bounds.
#[derive(Clone, Debug)]
pub struct Space {
    /// In the order of the variables.
    pub parameters: Vec<Parameter>,
    /// Logarithms of the bounds.
    bounds: Vec<[f64; 2]>,
    wall: f64,
}

/// Moduli in MPa between which a muscle is looked for.
const MODULI: [f64; 2] = [0.01, 100.0];
/// A parameter this near to a bound, as a part of the logarithmic range, is on it.
const ON_BOUND: f64 = 1e-3;

impl Space {
    /// Radii and one modulus, or one for the ends and one for the middle. The outer radius may be a quarter to one and a half
    /// of the undeformed diameter, and no less than 1.05 walls.
    pub fn new(diameter: f64, wall: f64, two_moduli: bool) -> Self {
        let mut parameters = vec![Parameter::EndRadius, Parameter::MiddleRadius, Parameter::Modulus];
        if two_moduli {
            parameters.push(Parameter::EndModulus);
        }
        let radii = [(0.25 * diameter).max(1.05 * wall), 1.5 * diameter];
        let bounds = |parameter: &Parameter| match parameter {
            Parameter::EndRadius | Parameter::MiddleRadius => radii.map(f64::ln),
            Parameter::Modulus | Parameter::EndModulus => MODULI.map(f64::ln),
        };
        Self { bounds: parameters.iter().map(bounds).collect(), parameters, wall }
    }

    /// Number of parameters.
    pub fn len(&self) -> usize {
        self.parameters.len()
    }

    /// Whether there is nothing to fit.
    pub fn is_empty(&self) -> bool {
        self.parameters.is_empty()
    }

    /// Parameters of optimizer variables.
    pub fn values(&self, z: &[f64]) -> Vec<f64> {
        let one = |(z, [low, high]): (&f64, &[f64; 2])| (low + (high - low) * 0.5 * (1.0 + z.sin())).exp();
        z.iter().zip(&self.bounds).map(one).collect()
    }

    /// d ln p/dz.
    pub fn slopes(&self, z: &[f64]) -> Vec<f64> {
        z.iter().zip(&self.bounds).map(|(z, [low, high])| (high - low) * 0.5 * z.cos()).collect()
    }

    /// Optimizer variables of parameters; outside of the bounds those of the nearest bound.
    pub fn variables(&self, values: &[f64]) -> Vec<f64> {
        let one = |(value, [low, high]): (&f64, &[f64; 2])| {
            (2.0 * (value.ln() - low) / (high - low) - 1.0).clamp(-1.0, 1.0).asin()
        };
        values.iter().zip(&self.bounds).map(one).collect()
    }

    /// Which parameters lie on a bound, and whether it is the upper one.
    pub fn on_bounds(&self, z: &[f64]) -> Vec<(Parameter, bool, f64)> {
        let near = |((parameter, z), [low, high]): ((&Parameter, &f64), &[f64; 2])| {
            let part = 0.5 * (1.0 + z.sin());
            let upper = part > 0.5;
            let on = !(ON_BOUND..=1.0 - ON_BOUND).contains(&part);
            on.then(|| (*parameter, upper, if upper { high.exp() } else { low.exp() }))
        };
        self.parameters.iter().zip(z).zip(&self.bounds).filter_map(near).collect()
    }

    /// The row of a muscle's table with these parameters.
    pub fn row(&self, values: &[f64], pressure: f64, alpha: f64) -> Row {
        let value = |wanted| self.parameters.iter().position(|parameter| *parameter == wanted).map(|i| values[i]);
        let modulus = value(Parameter::Modulus).unwrap_or(f64::NAN);
        let radii = [Parameter::EndRadius, Parameter::MiddleRadius].map(|radius| value(radius).unwrap_or(f64::NAN));
        muscle::row(pressure, alpha, radii, [value(Parameter::EndModulus).unwrap_or(modulus), modulus])
    }

    /// Derivatives of an output by the logarithms of the parameters, from those by the sections of end, middle, end.
    ///
    /// Annulus of outer radius R and wall t, r = R − t: d ln A/dR = 2/(2R − t), d ln I/dR = 4(R³ − r³)/(R⁴ − r⁴).
    pub fn derivatives(&self, values: &[f64], segments: &[SegmentSensitivity; 3]) -> Vec<f64> {
        let two = self.parameters.contains(&Parameter::EndModulus);
        let moduli = |segment: &SegmentSensitivity| segment.stiffness.iter().sum::<f64>();
        let [first, middle, last] = segments;
        let radius = |radius: f64, segment: &SegmentSensitivity| {
            let inner = radius - self.wall;
            let area = 2.0 / (2.0 * radius - self.wall);
            let second = 4.0 * (radius.powi(3) - inner.powi(3)) / (radius.powi(4) - inner.powi(4));
            let [ea, ga2, ga3, gj, ei2, ei3] = segment.stiffness;
            radius * (area * (ea + ga2 + ga3) + second * (gj + ei2 + ei3))
        };
        let one = |(parameter, &value): (&Parameter, &f64)| match parameter {
            Parameter::EndRadius => radius(value, first) + radius(value, last),
            Parameter::MiddleRadius => radius(value, middle),
            Parameter::Modulus if two => moduli(middle),
            Parameter::Modulus => moduli(first) + moduli(middle) + moduli(last),
            Parameter::EndModulus => moduli(first) + moduli(last),
        };
        self.parameters.iter().zip(values).map(one).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_and_values_are_inverse_and_bounded() {
        let space = Space::new(13.0, 2.0, true);
        let values = [6.1, 8.0, 3.6, 2.0];
        let there = space.values(&space.variables(&values));
        assert!(values.iter().zip(&there).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!(space.on_bounds(&space.variables(&values)).is_empty());
        let far = space.values(&[1e3, -40.0, 7.0, 0.1]);
        assert!(far[0] <= 19.5 + 1e-9 && far[0] >= 3.25 - 1e-9);
        let bound = space.on_bounds(&space.variables(&[100.0, 1e-9, 1.0, 1.0]));
        assert_eq!(bound.len(), 2);
        assert_eq!((bound[0].0, bound[0].1), (Parameter::EndRadius, true));
        assert_eq!((bound[1].0, bound[1].1), (Parameter::MiddleRadius, false));
    }
}
