//! Eq. 5 of the dissertation with the coefficients that its Table 3 prints.
//!
//! A parameter is i₀ + i₁ λ + i₂ α + i₃ P + i₄ λ² + i₅ α² + i₆ P² of the aspect ratio λ = L/D, the fibre angle α in degrees
//! and the pressure P in psi; that of K_th is linear. K_ex is that of one of the two springs along the middle: Table 4
//! prints 2 K_ex, which [`Prb`] counts itself. The γ of Table 4 does not follow from Table 3 (0.623 for 0.65, 0.716 for
//! 0.61), so it may be replaced: the quadratic in α has its least value near 36 degrees and rises beyond it.

use super::{Prb, TORSION_UNIT};

/// Coefficients i₀ to i₆, as Table 3 prints them.
const GAMMA: [f64; 7] = [1.5937, 0.10667, -0.075852, -0.022, -0.0044444, 0.0010519, 0.00062222];
const TORSION: [f64; 7] = [5.4016, -0.072562, -0.12284, 0.079778, 0.0, 0.0, 0.0];
const EXTENSION: [f64; 7] = [20.854, -0.82746, -0.70704, -0.061333, 0.031074, 0.0083259, 0.0032];

/// Muscles that the regression was made from (Table 1): aspect ratios, fibre angles in degrees, pressures in psi.
const RANGES: [(&str, [f64; 2]); 3] =
    [("aspect ratio", [6.0, 10.0]), ("fibre angle", [25.0, 40.0]), ("pressure", [15.0, 20.0])];

/// A muscle as the regression knows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Design {
    /// Length over undeformed diameter.
    pub aspect_ratio: f64,
    /// Degrees.
    pub fibre_angle: f64,
    /// psi.
    pub pressure: f64,
}

/// What Eq. 5 gives, in the units of the dissertation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Part of the length between the two torsion springs.
    pub gamma: f64,
    /// K_th in units of [`TORSION_UNIT`].
    pub torsion: f64,
    /// K_ex of one of the two springs, N/mm.
    pub extension: f64,
}

impl Design {
    /// The parameters of Eq. 5.
    pub fn parameters(&self) -> Parameters {
        let Self { aspect_ratio: l, fibre_angle: a, pressure: p } = *self;
        let terms = [1.0, l, a, p, l * l, a * a, p * p];
        let value = |coefficients: [f64; 7]| coefficients.iter().zip(terms).map(|(i, term)| i * term).sum();
        Parameters { gamma: value(GAMMA), torsion: value(TORSION), extension: value(EXTENSION) }
    }

    /// What lies outside of the muscles that the regression was made from, in words.
    pub fn outside(&self) -> Vec<String> {
        let values = [self.aspect_ratio, self.fibre_angle, self.pressure];
        let beyond = values.iter().zip(RANGES).filter(|(value, (_, [low, high]))| !(*low..=*high).contains(*value));
        beyond
            .map(|(value, (what, [low, high]))| format!("the {what} {value} lies outside of {low} to {high}"))
            .collect()
    }
}

impl Parameters {
    /// The model of a muscle of a length and a free stroke, in mm. `gamma` stands in for that of Eq. 5, where given.
    pub fn model(&self, length: f64, stroke: f64, gamma: Option<f64>) -> Prb {
        Prb {
            length,
            stroke,
            gamma: gamma.unwrap_or(self.gamma),
            torsion: TORSION_UNIT * self.torsion,
            extension: self.extension,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INSIDE: Design = Design { aspect_ratio: 8.5, fibre_angle: 35.0, pressure: 15.0 };
    const OUTSIDE: Design = Design { aspect_ratio: 8.5, fibre_angle: 45.0, pressure: 22.5 };

    /// Table 4 of the dissertation: 1.68 and 2.64, 1.05 and 2.70.
    #[test]
    fn table_4_has_the_torsion_and_twice_the_extension_of_eq_5() {
        for (design, torsion, twice) in [(INSIDE, 1.68, 2.64), (OUTSIDE, 1.05, 2.70)] {
            let found = design.parameters();
            assert!((found.torsion - torsion).abs() < 5e-3, "{found:?}");
            assert!((2.0 * found.extension - twice).abs() < 5e-3, "{found:?}");
        }
    }

    /// Evaluated by hand from the printed coefficients.
    #[test]
    fn eq_5_is_evaluated_as_printed() {
        for (design, expected) in [(INSIDE, [0.623, 1.682, 1.3185]), (OUTSIDE, [0.716, 1.052, 1.3488])] {
            let Parameters { gamma, torsion, extension } = design.parameters();
            for ((value, expected), half) in
                [gamma, torsion, extension].into_iter().zip(expected).zip([5e-4, 5e-4, 5e-5])
            {
                assert!((value - expected).abs() <= half, "{value} {expected}");
            }
        }
    }

    /// The γ of Table 4 is not that of Table 3: 0.65 and 0.61.
    #[test]
    fn gamma_does_not_reproduce_and_can_be_replaced() {
        for (design, printed) in [(INSIDE, 0.65), (OUTSIDE, 0.61)] {
            let parameters = design.parameters();
            assert!((parameters.gamma - printed).abs() > 0.02);
            assert_eq!(parameters.model(110.5, 15.0, Some(printed)).gamma, printed);
            assert_eq!(parameters.model(110.5, 15.0, None).gamma, parameters.gamma);
        }
    }

    /// A pull stretches the two springs of the model together: δ = F/(2 K_ex).
    #[test]
    fn the_model_counts_both_springs() {
        let model = INSIDE.parameters().model(110.5, 15.0, None);
        let tip = model.under_load([2.0, 0.0], 0.0).unwrap();
        assert!((tip[0] - (110.5 - 15.0 + 2.0 / (2.0 * 1.3185))).abs() < 1e-3, "{tip:?}");
    }

    #[test]
    fn what_lies_outside_of_the_data_is_said() {
        assert!(INSIDE.outside().is_empty());
        assert_eq!(OUTSIDE.outside().len(), 2);
        assert!(OUTSIDE.outside()[0].contains("the fibre angle 45 lies outside of 25 to 40"));
    }
}
