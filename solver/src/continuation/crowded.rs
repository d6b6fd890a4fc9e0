//! Paths on which so many motions are unstable that singular points are counted, and not located one by one.
//!
//! A thin column that is pushed straight by a part of its length passes hundreds of critical loads, the n-th at n² of the first: n half
//! waves lie between its ends, as short as it is thick in the end and shorter than elements before. Each takes some hundred
//! factorizations to locate, on a mesh that is finer for each, and a mesh has as many as its elements can bend in.

use super::follow::Run;
use super::{Continuation, Count};
use crate::history::{Crowded, Note, StepHistory};
use crate::structure::{Branch, Method};

/// Points of a step, and motions that are unstable, up to which singular points are located one by one. A mesh that has the eleventh load
/// of a pinned column to 4·10⁻⁵ of it has seven elements of order 4 for each of its half waves; the points of one mesh take a
/// thousand factorizations.
const MANY: usize = 10;

/// Whether so many unstable motions are too many to tell one from the other.
pub(super) fn is_crowd(negative: usize) -> bool {
    negative > MANY
}

/// What is noted already of what a step counted.
pub(super) fn noted(record: &mut StepHistory) -> Option<&mut Crowded> {
    record.notes.iter_mut().find_map(|note| match note {
        Note::Crowded(known) => Some(known),
        _ => None,
    })
}

impl<const D: usize> Continuation<'_, D> {
    /// Whether so many points of a step are located, and so many motions unstable at the last state, that no further point is to be
    /// located, nor any branch looked for there.
    fn is_in_a_crowd(&self, run: &Run<'_>) -> bool {
        let goes_straight_on = run.request.branch == Branch::Primary || run.request.method == Method::ArcLength;
        let lists_enough = self.is_crowded || run.record.critical_points.len() >= MANY;
        run.is_step && goes_straight_on && self.base.potential && lists_enough && is_crowd(self.base.negative())
    }

    /// Whether what is passed between the last state and one with this count is only counted: as many motions are unstable there, and no
    /// more of them have changed, which would leave the path in doubt.
    ///
    /// A path that comes back to where fewer are unstable locates its points from there on.
    pub(super) fn only_counts(&self, run: &Run<'_>, count: &Count) -> bool {
        let fewest = self.base.negative().min(count.negative());
        let changes = self.changes_to(count);
        self.is_in_a_crowd(run) && count.potential && is_crowd(fewest) && (1..=fewest).contains(&changes)
    }

    /// How many pivots an increment may lose before it is made again shorter without a look at its end.
    pub(super) fn may_lose(&self, run: &Run<'_>) -> usize {
        if self.is_in_a_crowd(run) { self.base.negative() } else { 0 }
    }

    /// Pivots that change their signs between the last state and one with this count.
    fn changes_to(&self, count: &Count) -> usize {
        let events = self.events_at(count, false);
        events.changed + events.aside
    }

    /// Notes that what changed between the last state and one with this count, at these fractions, was counted, but for so many points.
    pub(super) fn note_counted(
        &mut self,
        record: &mut StepHistory,
        count: &Count,
        [from, to]: [f64; 2],
        located: usize,
    ) {
        let changes = self.changes_to(count).saturating_sub(located);
        match noted(record) {
            Some(known) => (known.changes, known.to) = (known.changes + changes, to),
            None => record.notes.push(Note::Crowded(Crowded { changes, from, to, other: None })),
        }
        self.is_crowded = true;
    }

    /// Notes what an increment of the fraction that leads out of a crowd regained beside the points that it located.
    pub(super) fn note_left_out(&mut self, run: &mut Run<'_>, count: &Count, ends: [f64; 2], located: usize) {
        if self.is_in_a_crowd(run) && self.changes_to(count) > located {
            self.note_counted(run.record, count, ends, located);
        }
    }
}
