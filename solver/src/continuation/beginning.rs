//! Before the first step: what is loose at rest, and the prestress.
//!
//! Theory: docs/theory/continuation.md.

use super::follow::{Effort, Request, Run};
use super::ramp::Ramp;
use super::{Continuation, HeldRows, SoFar, first_rows, longest_asked};
use crate::error::{FreeMotion, NearMotion};
use crate::history::StepHistory;
use crate::joints::Held;
use crate::mechanism;
use crate::structure::Step;
use crate::system::{Inertia, State, System};

/// The equilibrium that the first step goes on from: that of the prestress, or the unloaded state where there is none.
#[derive(Clone, Debug)]
pub struct Beginning {
    /// The state.
    pub state: State,
    /// What is held there: the supports, and what the first step holds where the prestress would move it without resistance.
    pub held: Vec<Held>,
}

impl<const D: usize> Continuation<'_, D> {
    /// Comes to where the first step begins.
    pub(super) fn begin_first(
        &mut self,
        steps: &[Step],
        record: &mut StepHistory,
        watch: &mut dyn FnMut(f64) -> bool,
        so_far: &mut SoFar,
    ) {
        self.bring_in_prestress(steps, record, watch, so_far);
        let keeps = steps.first().is_some_and(|step| step.kept().next().is_some());
        self.beginning = (keeps && so_far.going)
            .then(|| Beginning { state: self.system.snapshot(), held: self.held.values().copied().collect() });
    }

    /// Brings in the prestress, and counts pivots where the first step does not do without.
    fn bring_in_prestress(
        &mut self,
        steps: &[Step],
        record: &mut StepHistory,
        watch: &mut dyn FnMut(f64) -> bool,
        so_far: &mut SoFar,
    ) {
        // A run that goes on from the steps of another one has its prestress.
        let prestressed = self.is_prestressed() && self.system.loading.prestress < 1.0;
        self.change(&[]);
        so_far.counted = prestressed || !self.is_known_from_coarse(0);
        if so_far.counted {
            self.start_count(record);
        }
        if !prestressed && !steps.is_empty() {
            return;
        }
        let longest = steps.first().map_or(1.0, longest_asked);
        let unloaded = self.system.snapshot();
        if self.needs_first_rows(steps) {
            let (supports, notes) = (self.held.clone(), record.notes.clone());
            self.hold_first_rows(steps);
            self.start_count(record);
            self.first_prestress(record, watch, longest, so_far, false);
            if !self.is_held_by_prestress(&supports) {
                note_prestress(record, so_far.going);
                return;
            }
            // It holds the network by itself: the first step goes on from where it does so.
            *record = StepHistory { notes, ..StepHistory::empty(self.stability) };
            self.held = supports;
            self.system.restore(&unloaded);
            self.change(&[]);
            self.start_count(record);
        }
        self.first_prestress(record, watch, longest, so_far, steps.is_empty());
        if !steps.is_empty() {
            note_prestress(record, so_far.going);
        }
        if self.is_loose {
            let here = self.system.snapshot();
            if !so_far.going {
                // What the prestress does not come to hold is loose.
                self.system.restore(&unloaded);
            }
            self.free = self.free_under_prestress(steps);
            self.system.restore(&here);
            self.system.assemble(false);
            so_far.going &= self.free.is_empty();
        }
    }

    /// Follows the prestress, with what is held.
    fn first_prestress(
        &mut self,
        record: &mut StepHistory,
        watch: &mut dyn FnMut(f64) -> bool,
        longest: f64,
        so_far: &mut SoFar,
        is_step: bool,
    ) {
        let rest = self.system.loading.drives.clone();
        let ramp = Ramp { drives: [rest.clone(), rest], prestress: [0.0, 1.0] };
        let conservative = self.is_conservative(&ramp);
        so_far.going = self.follow(&mut Run {
            ramp: &ramp,
            longest,
            record: &mut *record,
            watch,
            request: Request::default(),
            is_step,
            conservative,
            landmarks: Vec::new(),
            is_nearly_symmetric: false,
            turns: Vec::new(),
            firmest: Vec::new(),
            effort: Effort::default(),
        });
        self.judge_end(&ramp, record);
    }

    /// Whether supports alone leave a motion free, at the last assembly of the unloaded structure, that the first step holds: under a
    /// prestress it would go anywhere.
    fn needs_first_rows(&mut self, steps: &[Step]) -> bool {
        let at_rest = self.system.tangent.inertia();
        let rows = first_rows(&self.system.structure, steps);
        let holds_more = rows.iter().any(|row| !self.held.contains_key(row));
        let is_free = at_rest.idle + at_rest.negative > 0 || self.system.hides_signs_at_rest(&at_rest);
        !self.is_loose && holds_more && is_free
    }

    /// Holds what the first step holds where it is.
    fn hold_first_rows(&mut self, steps: &[Step]) {
        for (node, component) in first_rows(&self.system.structure, steps) {
            let here = self.present(node, component);
            self.insert(node, component, here, here);
        }
        self.system.hold(self.held.values().copied().collect());
    }

    /// Whether the present state is stable with these rows alone.
    fn is_held_by_prestress(&mut self, supports: &HeldRows) -> bool {
        self.system.hold(supports.values().copied().collect());
        let negative = self.system.assemble(false).negative;
        let is_held = negative == 0 && self.system.hidden_signs() == 0;
        self.system.hold(self.held.values().copied().collect());
        self.system.assemble(false);
        is_held
    }

    /// Motions that the unloaded structure can make without force, with what the first step holds in place.
    ///
    /// Springs that are stretched or compressed from the start may hold a network that is loose without them: such a network is
    /// looked at once they are in place, but for what turns about the place that it hangs on, which none of them feels.
    pub fn free_motions(&mut self, steps: &[Step]) -> Vec<FreeMotion> {
        let prestressed = self.is_prestressed();
        let wants_near = self.options.near_motion;
        let mut is_loose = false;
        let (free, near) = self.look_at_rest(steps, &mut |system, at_rest| match at_rest.idle + at_rest.negative {
            count if prestressed => {
                is_loose = count > 0 || system.hides_signs_at_rest(at_rest);
                (if is_loose { mechanism::free_in_place(system) } else { Vec::new() }, None)
            }
            // What rounding explains of a stiffness is none.
            0 if !system.hides_signs_at_rest(at_rest) => {
                (Vec::new(), wants_near.then(|| mechanism::near_motion(system)).flatten())
            }
            _ => (mechanism::free_motions(system), None),
        });
        self.near = near;
        self.is_loose = is_loose;
        free
    }

    /// Motions at the present state, the equilibrium of the prestress, that need no force, with what the first step holds.
    fn free_under_prestress(&mut self, steps: &[Step]) -> Vec<FreeMotion> {
        let held = self.held.clone();
        self.hold_first_rows(steps);
        self.system.assemble(false);
        let free = if self.system.hidden_signs() > 0 { mechanism::free_motions(&mut self.system) } else { Vec::new() };
        self.held = held;
        self.system.hold(self.held.values().copied().collect());
        self.system.assemble(false);
        free
    }

    /// A motion that the unloaded structure resists by next to nothing, where there is one and none is free.
    pub(crate) fn near_motion(&mut self, steps: &[Step]) -> Option<NearMotion> {
        let prestressed = self.is_prestressed();
        self.look_at_rest(steps, &mut |system, at_rest| {
            let free = at_rest.idle + at_rest.negative > 0;
            if free || prestressed { None } else { mechanism::near_motion(system) }
        })
    }

    /// Looks at the unloaded structure with what the first step holds, and at the number of its pivots that are not positive.
    fn look_at_rest<R>(&mut self, steps: &[Step], look: &mut dyn FnMut(&mut System<D>, &Inertia) -> R) -> R {
        let mut held = self.held.clone();
        for (node, component) in first_rows(&self.system.structure, steps) {
            self.insert(node, component, 0.0, 0.0);
        }
        self.system.hold(self.held.values().copied().collect());
        std::mem::swap(&mut self.held, &mut held);
        // The system is assembled with the rows of the first step; `held` has them, `self.held` those of the supports.
        let inertia = self.system.assemble(false);
        self.system.tangent.note_rest(&self.system.pattern);
        let seen = look(&mut self.system, &inertia);
        let same = held.len() == self.held.len();
        self.system.hold(self.held.values().copied().collect());
        self.at_rest = Some(if same { inertia } else { self.system.assemble(false) });
        seen
    }

    pub(super) fn is_prestressed(&self) -> bool {
        self.system.structure.is_prestressed()
    }
}

/// Says of what the way to the first step left in its record that it lies before the ramp of that step, and whether the way came to an
/// end: fractions are parts of the prestress there.
fn note_prestress(record: &mut StepHistory, came_to_its_end: bool) {
    record.prestress = (!came_to_its_end).then_some(record.fraction);
    record.fraction = 0.0;
    record.increments.iter_mut().for_each(|increment| increment.fraction = 0.0);
    record.critical_points.iter_mut().for_each(|point| point.in_prestress = true);
}
