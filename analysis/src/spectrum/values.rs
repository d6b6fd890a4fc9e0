//! What the modes on a mesh and on elements of the next order say: values and their errors.

use pennate_solver::base::Reach;
use pennate_solver::buckling::{Buckling, Near, Ramp};
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
#[derive(Debug, Default)]
pub(super) struct Values {
    pub entries: Vec<Entry>,
    pub reversed: Option<Reversed>,
    pub place: Place,
    pub notes: Vec<Note>,
    pub unknowns: usize,
    /// By how much the order of the elements whose error is stated is higher than that of the mesh.
    pub raised: usize,
    /// Of buckling: where the motions are on other elements.
    pub near: Near,
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
        let factors = |level: &Buckling| level.critical.iter().map(|critical| critical.factor).collect();
        let by_level: Vec<Vec<f64>> = levels.iter().map(factors).collect();
        let (errors, raised) = errors_of(&by_level, order);
        let back: Option<Vec<Vec<f64>>> = levels.iter().map(|level| Some(vec![level.reversed?.factor])).collect();
        let back = back.and_then(|back| errors_of(&back, order).0.first().copied());
        let Some(fine) = levels.pop() else { return Self::default() };
        let mut errors = errors.into_iter();
        let size = diagonal(structure.nodes.iter().copied());
        // Of loads that are present once a factor counts from nothing.
        let present = if let Ramp::Present(_) = ramp { 1.0 } else { 0.0 };
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
        Self { entries, reversed, place: fine.place, notes, unknowns: fine.unknowns, raised, near: fine.near }
    }
}

/// Errors of the values on the highest of two or three orders of elements, and by how much the order that they are those of is
/// higher than the lowest, `order`.
///
/// Of two it is the difference, which is the error of the lower one. Of three the differences fall by a ratio r from one
/// order to the next, and that falls by (2P − 1)/(2P + 3) about the order P between them (M. Ainsworth, SIAM J. Numer. Anal. 42,
/// 2004, 553), so that the highest one is off by the last difference times q/(1 − q), with q the next ratio. The ratio is the largest of
/// any value.
fn errors_of(levels: &[Vec<f64>], order: usize) -> (Vec<f64>, usize) {
    let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).collect::<Vec<f64>>();
    let relative = |apart: &[f64], to: &[f64]| apart.iter().zip(to).map(|(d, v)| d / v.abs()).fold(0.0, f64::max);
    match levels {
        [.., low, middle, high] => {
            let last = apart(middle, high);
            let first = apart(low, middle);
            let counted = CHANCE * relative(&first, high);
            let ratios =
                first.iter().zip(&last).zip(high).filter(|((first, _), value)| **first > counted * value.abs());
            let ratio = ratios.map(|((first, last), _)| last / first).fold(0.0, f64::max);
            let order = (order + 1) as f64;
            let next = (ratio * (2.0 * order - 1.0) / (2.0 * order + 3.0)).max(LEFT / high.len() as f64);
            // Differences that do not fall by half say nothing of what follows.
            let left = if next < 0.5 { next / (1.0 - next) } else { 1.0 };
            // Those of one value that do not, where those of others do, are its rounding.
            let error = |(first, last): (&f64, f64)| if last > 0.5 * first { last.max(*first) } else { left * last };
            (first.iter().zip(last).map(error).collect(), 2)
        }
        [low, high] => (apart(low, high), 0),
        _ => (Vec::new(), 0),
    }
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
