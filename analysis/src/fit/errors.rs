//! Error analysis: how far a muscle with fitted parameters is from load cases, fitted or not (Fig. 12).

use pennate_models::hsim::Row;

use super::Fitted;
use super::data::Case;
use super::problem::{Difference, Tube};

/// Mean absolute differences of load cases: axial motion and deflection in mm, slope in degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Of each kind; not a number where no case tells of it.
    pub mean: [f64; 3],
    /// Largest measured of each kind.
    pub largest: [f64; 3],
    /// Load cases that tell of each kind.
    pub counts: [usize; 3],
    /// Load cases without a stable equilibrium.
    pub lost: usize,
}

/// Errors at one length, over the pressures.
#[derive(Clone, Debug, PartialEq)]
pub struct LengthErrors {
    /// Unloaded length, mm.
    pub length: f64,
    /// Length over outer diameter.
    pub aspect_ratio: f64,
    /// Mean of the pressures' means: axial motion and deflection in mm, slope in degrees.
    pub mean: [f64; 3],
    /// Standard deviation of the pressures' means.
    pub deviation: [f64; 3],
    /// Largest measured of each kind.
    pub largest: [f64; 3],
    /// Load cases with a stable equilibrium.
    pub cases: usize,
    /// Load cases without one.
    pub lost: usize,
}

impl Errors {
    /// Errors of the cases of one pressure.
    pub fn of(tube: &Tube, row: Row, cases: &[Case]) -> Self {
        Self::over(cases, tube.compare(row, cases).into_iter())
    }

    /// Errors of cases whose differences are known, in their order.
    pub fn over(cases: &[Case], differences: impl Iterator<Item = Option<Difference>>) -> Self {
        let mut errors = Self::default();
        for (case, difference) in cases.iter().zip(differences) {
            let mut add = |kind: usize, difference: f64, measured: f64| {
                errors.mean[kind] += difference.abs();
                errors.largest[kind] = errors.largest[kind].max(measured.abs());
                errors.counts[kind] += 1;
            };
            match difference {
                Some(Difference::Axial(difference)) => add(0, difference, case.length - case.tip[0]),
                Some(Difference::Lateral { deflection, slope }) => {
                    add(1, deflection, case.tip[1]);
                    add(2, slope.to_degrees(), case.slope.to_degrees());
                }
                None => errors.lost += 1,
            }
        }
        for kind in 0..3 {
            errors.mean[kind] = match errors.counts[kind] {
                0 => f64::NAN,
                count => errors.mean[kind] / count as f64,
            };
        }
        errors
    }
}

/// Errors at every length of the data with the parameters fitted at one; of kinked cases those alone that are wanted.
pub fn by_length(fitted: &Fitted, min_ovality: Option<f64>) -> Vec<LengthErrors> {
    let tests = &fitted.selection.tests;
    let wanted = |case: &&Case| {
        let round = match (min_ovality, case.ovality) {
            (Some(least), Some(ovality)) => ovality >= least,
            _ => true,
        };
        !case.is_free() && tests.contains(&case.test) && round
    };
    fitted
        .selection
        .lengths
        .iter()
        .map(|&length| {
            let errors: Vec<Errors> = fitted
                .rows
                .iter()
                .map(|row| {
                    let at = |case: &&Case| case.length == length && case.pressure == row.row.pressure;
                    let cases: Vec<Case> = fitted.selection.all.iter().filter(at).filter(wanted).cloned().collect();
                    Errors::of(&fitted.tube, row.row, &cases)
                })
                .collect();
            over_pressures(length, fitted.tube.diameter, &errors)
        })
        .collect()
}

/// Mean and standard deviation (of the whole, not of a sample) over pressures.
pub fn over_pressures(length: f64, diameter: f64, errors: &[Errors]) -> LengthErrors {
    let all = |kind: usize| errors.iter().map(move |errors| errors.mean[kind]).filter(|mean| mean.is_finite());
    let mean = std::array::from_fn(|kind| all(kind).sum::<f64>() / all(kind).count().max(1) as f64);
    let variance =
        |kind: usize, mean: f64| all(kind).map(|x| (x - mean).powi(2)).sum::<f64>() / all(kind).count().max(1) as f64;
    LengthErrors {
        length,
        aspect_ratio: length / diameter,
        mean,
        deviation: std::array::from_fn(|kind| variance(kind, mean[kind]).sqrt()),
        largest: std::array::from_fn(|kind| errors.iter().map(|errors| errors.largest[kind]).fold(0.0, f64::max)),
        cases: errors.iter().map(|errors| errors.counts[0] + errors.counts[1]).sum(),
        lost: errors.iter().map(|errors| errors.lost).sum(),
    }
}
