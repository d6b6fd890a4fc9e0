//! What the modes on a mesh and on elements of the next order say: values and their errors.

use pennate_solver::base::Reach;
use pennate_solver::buckling::{Buckling, Ramp};
use pennate_solver::modes::{Modes, Place};
use pennate_solver::spectral::unknowns::Family;
use pennate_solver::structure::{Dimension, Stability, Structure};

use super::{Entry, Note};
use crate::solution::diagonal;

/// An eigenvalue counts as no smaller than this part of the largest wanted, when errors are judged.
const SMALLEST: f64 = 1e-9;

/// The modes of the higher order, with the errors of those on the mesh itself.
#[derive(Debug, Default)]
pub(super) struct Values {
    pub entries: Vec<Entry>,
    pub reversed: Option<f64>,
    pub place: Place,
    pub notes: Vec<Note>,
    pub unknowns: usize,
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
        Self { entries, reversed: None, place: fine.place, notes, unknowns: fine.unknowns }
    }

    pub(super) fn of_buckling(structure: &Structure, ramp: Ramp, [coarse, fine]: [Buckling; 2]) -> Self {
        let size = diagonal(structure.nodes.iter().copied());
        // Of loads that are present once a factor counts from nothing.
        let present = if let Ramp::Present(_) = ramp { 1.0 } else { 0.0 };
        let none = fine.critical.is_empty();
        let mut coarse_values = coarse.critical.iter().map(|critical| critical.factor);
        let entries = fine
            .critical
            .into_iter()
            .map(|critical| {
                let value = critical.factor + present;
                let error = coarse_values
                    .next()
                    .map(|coarse| ((coarse - critical.factor).abs() / value).max(critical.rounding));
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
        let reversed = fine.reversed.map(|factor| factor + present);
        Self { entries, reversed, place: fine.place, notes, unknowns: fine.unknowns }
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
