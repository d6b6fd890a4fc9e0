//! What the modes on a mesh and on elements of the next order say: values and their errors.

use pennate_solver::base::Reach;
use pennate_solver::buckling::{Buckling, Critical, Near, Ramp};
use pennate_solver::modes::{Modes, Place};
use pennate_solver::spectral::unknowns::Family;
use pennate_solver::structure::{Dimension, Stability, Structure};

use super::{Entry, Note, Reversed};
use crate::solution::diagonal;

/// An eigenvalue counts as no smaller than this part of the largest wanted, when errors are judged.
const SMALLEST: f64 = 1e-9;
/// Part of the difference of two orders that is left of it on the higher one, at least, where one value tells: two orders may agree
/// by chance, of several values so many times less. On a dyad of eight elements a sixth is left of the first factor, where the
/// ratio of the differences foresees a hundredth.
const LEFT: f64 = 0.15;
/// Part of the largest difference of any value on the two lower orders below which one of them is chance.
const CHANCE: f64 = 1e-2;

/// The modes of the higher order, with the errors of those on the mesh itself.
#[derive(Debug)]
pub(super) struct Values {
    pub entries: Vec<Entry>,
    pub reversed: Option<Reversed>,
    pub place: Place,
    pub notes: Vec<Note>,
    pub unknowns: usize,
    /// By how much the order of the elements whose error is known is higher than that of the mesh.
    pub raised: usize,
    /// Part of that error which is expected to be the one asked for.
    pub left: f64,
    /// Of buckling: where the motions are on other elements.
    pub near: Near,
}

impl Default for Values {
    fn default() -> Self {
        Self {
            entries: Vec::new(),
            reversed: None,
            place: Place::default(),
            notes: Vec::new(),
            unknowns: 0,
            raised: 0,
            left: 1.0,
            near: Near::default(),
        }
    }
}

impl Values {
    pub(super) fn of_modes(structure: &Structure, [coarse, fine]: [Modes; 2]) -> Self {
        let size = diagonal(structure.nodes.iter().copied());
        let scale = fine.modes.iter().fold(0.0f64, |scale, mode| scale.max(mode.eigenvalue.abs()));
        let mut coarse_values = coarse.modes.iter().map(|mode| mode.eigenvalue);
        let entries: Vec<Entry> = fine
            .modes
            .into_iter()
            .map(|mode| {
                let value = mode.eigenvalue;
                // The frequency is the root: half the relative error of its square.
                let relative = |coarse: f64| 0.5 * (coarse - value).abs() / value.abs().max(SMALLEST * scale);
                let error = coarse_values.next().map(|coarse| {
                    let error = if coarse == value { 0.0 } else { relative(coarse) };
                    error.max(0.5 * mode.rounding)
                });
                Entry { value, error, family: mode.family, largest: mode.shape.largest(size), shape: mode.shape }
            })
            .collect();
        let mut notes = Vec::new();
        let unstable = entries.iter().filter(|entry| entry.value < 0.0).count();
        if unstable > 0 {
            notes.push(Note::Unstable(unstable));
        }
        if entries.iter().any(|entry| entry.value == 0.0) {
            notes.push(Note::NoStiffness);
        }
        notes.extend(remarks(structure, &fine.left_out, fine.reach, fine.complete));
        Self { entries, reversed: None, place: fine.place, notes, unknowns: fine.unknowns, ..Self::default() }
    }

    /// `order` is that of the mesh.
    pub(super) fn of_buckling(structure: &Structure, ramp: Ramp, mut levels: Vec<Buckling>, order: usize) -> Self {
        let Errors { errors, raised, left } = Errors::of(&levels, order);
        let factors: Option<Vec<f64>> = levels.iter().map(|level| Some(level.reversed?.factor)).collect();
        let back = factors.and_then(|factors| match factors.as_slice() {
            [low, middle, high] => left_over(&[(low - middle).abs()], &[(middle - high).abs()], &[*high], order).pop(),
            [.., low, high] => Some((low - high).abs()),
            _ => None,
        });
        let Some(fine) = levels.pop() else { return Self::default() };
        let mut errors = errors.into_iter();
        let size = diagonal(structure.nodes.iter().copied());
        let present = present(ramp);
        let none = fine.critical.is_empty();
        let entries = fine
            .critical
            .into_iter()
            .map(|critical| {
                let value = critical.factor + present;
                let error = errors.next().map(|error| (error / value).max(critical.rounding));
                Entry {
                    value,
                    error,
                    family: critical.family,
                    largest: critical.shape.largest(size),
                    shape: critical.shape,
                }
            })
            .collect();
        let mut notes = remarks(structure, &fine.left_out, fine.reach, fine.complete);
        notes.extend(fine.neutral.first().map(|&family| Note::Neutral(family)));
        if none {
            notes.push(Note::NothingCritical);
        }
        let reversed = fine.reversed.map(|reversed| {
            let value = reversed.factor + present;
            Reversed { value, error: back.map(|error| (error / value.abs()).max(reversed.rounding)) }
        });
        Self { entries, reversed, place: fine.place, notes, unknowns: fine.unknowns, raised, left, near: fine.near }
    }
}

/// Of loads that are present once a factor counts from nothing: what is to be added to that of a ramp.
fn present(ramp: Ramp) -> f64 {
    if let Ramp::Present(_) = ramp { 1.0 } else { 0.0 }
}

/// Whether factors on some orders, the highest one first, are off by more than `accuracy`, whatever those of lower orders are.
///
/// Of one order the motions say how far those of the order below would be. That is no bound, and no error that is stated: a finer mesh follows.
pub(super) fn are_off(ramp: Ramp, levels: &[Buckling], accuracy: f64) -> bool {
    let [high, lower @ ..] = levels else { return false };
    let apart = match lower {
        [] => high.critical.iter().map(|critical| critical.lacking).fold(0.0, f64::max),
        [low, ..] => {
            let apart = |(high, low): (&Critical, &Critical)| {
                ((high.factor - low.factor) / (high.factor + present(ramp))).abs()
            };
            high.critical.iter().zip(&low.critical).map(apart).fold(0.0, f64::max)
        }
    };
    let least = LEFT / high.critical.len().max(1) as f64;
    apart * least / (1.0 - least) > accuracy
}

/// Errors of the factors.
struct Errors {
    errors: Vec<f64>,
    /// By how much the order of the elements that they are those of is higher than that of the mesh.
    raised: usize,
    /// Part of them that is expected to be those of the highest order.
    left: f64,
}

impl Errors {
    /// Of the highest of some orders of elements, or of the one below; `order` is that of the mesh.
    fn of(levels: &[Buckling], order: usize) -> Self {
        let factors = |level: &Buckling| level.critical.iter().map(|critical| critical.factor).collect::<Vec<f64>>();
        let apart = |a: &Buckling, b: &Buckling| -> Vec<f64> {
            factors(a).iter().zip(factors(b)).map(|(a, b)| (a - b).abs()).collect()
        };
        match levels {
            [low, middle, high] => {
                let errors = left_over(&apart(low, middle), &apart(middle, high), &factors(high), order);
                Self { errors, raised: 2, left: 1.0 }
            }
            [low, high] if low.raised == 0 => Self { errors: apart(low, high), raised: 0, left: 1.0 },
            [low, high] => Self { errors: apart(low, high), raised: low.raised, left: LEFT },
            [only] if only.raised > 0 => {
                let lacking = |critical: &Critical| critical.lacking * critical.factor;
                Self { errors: only.critical.iter().map(lacking).collect(), raised: only.raised - 1, left: LEFT }
            }
            _ => Self { errors: Vec::new(), raised: 0, left: 1.0 },
        }
    }
}

/// What is left of differences on the highest of three orders of elements, of which the lowest is `order`.
///
/// They fall by a ratio r from one order to the next, and that falls by (2P − 1)/(2P + 3) about the order P between them (M.
/// Ainsworth, SIAM J. Numer. Anal. 42, 2004, 553), so that the highest one is off by the last difference times q/(1 − q), with q the
/// next ratio. The ratio is the largest of any value.
fn left_over(first: &[f64], last: &[f64], values: &[f64], order: usize) -> Vec<f64> {
    let relative = |apart: &[f64]| apart.iter().zip(values).map(|(d, v)| d / v.abs()).fold(0.0, f64::max);
    let counted = CHANCE * relative(first);
    let ratios = first.iter().zip(last).zip(values).filter(|((first, _), value)| **first > counted * value.abs());
    let ratio = ratios.map(|((first, last), _)| last / first).fold(0.0, f64::max);
    let order = (order + 1) as f64;
    let next = (ratio * (2.0 * order - 1.0) / (2.0 * order + 3.0)).max(LEFT / values.len() as f64);
    // Differences that do not fall by half say nothing of what follows.
    let left = if next < 0.5 { next / (1.0 - next) } else { 1.0 };
    // Those of one value that do not, where those of others do, are its rounding.
    let error = |(first, last): (&f64, &f64)| if *last > 0.5 * first { last.max(*first) } else { left * last };
    first.iter().zip(last).map(error).collect()
}

/// What is left out, and why.
fn remarks(structure: &Structure, left_out: &[Family], reach: Reach, complete: bool) -> Vec<Note> {
    let mut notes = Vec::new();
    if structure.dimension == Dimension::Plane && reach == Reach::InPlane {
        notes.push(match structure.stability {
            Stability::Plane => Note::PlaneOnly,
            Stability::Space => Note::NotHeldOutOfPlane,
        });
    }
    let families = [Family::OutOfPlane, Family::InPlane].into_iter().filter(|family| left_out.contains(family));
    notes.extend(families.map(Note::NoPotential));
    if !complete {
        notes.push(Note::MayMiss);
    }
    notes
}
