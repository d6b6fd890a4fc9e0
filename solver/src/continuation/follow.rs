//! A ramp, followed increment by increment.
//!
//! An increment is a prediction and its correction; it is accepted, made again shorter, or the end of what can be reached in this
//! way. What is accepted may have passed singular points, which are located, and left or stopped at. Increments are measured by
//! the fraction of the ramp as long as that grows along the path, and else, and next to a suspected singular point, by the
//! length of the arc.
//!
//! Theory: docs/theory/continuation.md, Eq. 8.1.

use super::Continuation;
use super::arc::{ByArc, Purpose};
use super::fraction::ByFraction;
use super::ramp::Ramp;
use crate::history::{Status, StepHistory};
use crate::newton::{Convergence, Lost, Start, Why};
use crate::structure::{Branch, Method, Stop};
use crate::system::Turning;

/// What a step asks of its path.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Request {
    pub method: Method,
    pub branch: Branch,
    pub stop: Option<Stop>,
}

/// What following a ramp has cost.
#[derive(Default)]
pub(super) struct Effort {
    pub iterations: usize,
    pub factorizations: usize,
    /// Increments that were accepted.
    pub accepted: usize,
}

impl Effort {
    /// Counts an iteration whose last factorization is at the equilibrium that it found.
    pub(super) fn count(&mut self, outcome: &Result<Convergence, Lost>) {
        match outcome {
            Ok(found) => {
                self.iterations += found.iterations - 1;
                self.factorizations += found.factorizations;
            }
            Err(lost) => {
                self.iterations += lost.iterations;
                self.factorizations += lost.factorizations;
            }
        }
    }
}

/// A ramp on its way: what it moves, what is asked for, what is recorded.
pub(super) struct Run<'r> {
    pub ramp: &'r Ramp,
    /// The longest increment that is asked for.
    pub longest: f64,
    pub record: &'r mut StepHistory,
    /// Told of every accepted increment; false where nobody wants to wait any longer.
    pub watch: &'r mut dyn FnMut(f64) -> bool,
    pub request: Request,
    /// Whether it is a step of the user's: else nothing is recorded on the way.
    pub is_step: bool,
    /// Whether loads have a potential along the whole ramp.
    pub conservative: bool,
    /// Where increments of a coarser mesh ended that were accepted on the way: none here leads beyond the next.
    pub landmarks: Vec<f64>,
    /// Whether branches that seemed to meet were seen not to: the network is nearly symmetric.
    pub is_nearly_symmetric: bool,
    /// Parts that nothing resisted turning at the end of the last step, where loads of this one do.
    pub turns: Vec<Turning>,
    /// The firmest that every part has been on the way, where members can turn over.
    pub firmest: Vec<f64>,
    pub effort: Effort,
}

/// What increments are measured by.
pub(super) enum Control {
    Fraction(ByFraction),
    Arc(Box<ByArc>),
}

/// What became of one increment.
pub(super) enum Tried<Accepted, Lost> {
    Accepted(Accepted),
    /// Not to be believed, or not found: the control has a shorter one now.
    Again,
    /// No shorter increment would be better.
    Lost(Lost),
    Interrupted,
}

/// How a ramp is followed from here.
pub(super) enum Next {
    GoOn,
    By(Control),
    /// It ends; whether at its end.
    End(bool),
}

impl<const D: usize> Continuation<'_, D> {
    /// Follows a ramp to its end, from the present state at the fraction 0; false where it stopped short.
    pub(super) fn follow(&mut self, run: &mut Run<'_>) -> bool {
        let mut control = match self.first_control(run) {
            Ok(control) => control,
            Err(lost) => return self.end_lost(run, 0.0, &lost),
        };
        loop {
            let next = match &mut control {
                Control::Fraction(by) if by.is_before_a_fold(&self.tuning) => self.look_for_fold(run, by),
                Control::Fraction(by) => match self.increment_by_fraction(run, by) {
                    Tried::Accepted(increment) => self.advance_by_fraction(run, by, increment),
                    Tried::Lost(ending) => self.search(run, by, ending),
                    Tried::Again => Next::GoOn,
                    Tried::Interrupted => Next::End(self.interrupted(run, by.fraction)),
                },
                Control::Arc(by) => match self.increment_by_arc(run, by) {
                    Tried::Accepted(increment) => self.advance_by_arc(run, by, increment),
                    Tried::Lost(lost) => self.leave_arc(run, by, lost),
                    Tried::Again => Next::GoOn,
                    Tried::Interrupted => Next::End(self.interrupted(run, by.fraction)),
                },
            };
            match next {
                Next::GoOn => {}
                Next::By(other) => control = other,
                Next::End(reached) => return reached,
            }
        }
    }

    /// What a ramp is measured by at first.
    fn first_control(&mut self, run: &mut Run<'_>) -> Result<Control, Lost> {
        self.system.save(&mut self.last);
        let turned = if run.turns.is_empty() { None } else { self.turn_with_loads(run) };
        let purpose = match run.request.method {
            Method::ArcLength => Purpose::Whole,
            Method::Jump if run.conservative => Purpose::Jump,
            Method::Newton | Method::Jump => {
                return Ok(Control::Fraction(self.by_fraction(run, turned.unwrap_or(0.0))));
            }
        };
        if let Some(at) = turned {
            let arc = self.arc_from_last(run, at, at, purpose).ok_or_else(|| self.no_direction())?;
            return Ok(Control::Arc(Box::new(arc)));
        }
        match self.first_arc(run, purpose) {
            Some(by) => Ok(Control::Arc(Box::new(by))),
            None if purpose == Purpose::Jump => Ok(Control::Fraction(self.by_fraction(run, 0.0))),
            None => Err(self.no_direction()),
        }
    }

    /// What becomes of a path that has no direction at the present state.
    pub(super) fn no_direction(&self) -> Lost {
        Lost { iterations: 1, factorizations: 1, residual: self.system.residual(), why: Why::Singular }
    }

    /// Goes on by the fraction, from the present state at this one.
    pub(super) fn by_fraction(&mut self, run: &mut Run<'_>, from: f64) -> ByFraction {
        self.system.save(&mut self.last);
        run.effort.accepted = 0;
        let first = self.options.first_increment.min(run.longest).clamp(self.tuning.shortest, 1.0);
        ByFraction::new(from, first, self.first_answer.take())
    }

    /// Iterates to an equilibrium at this fraction, near the present state.
    pub(super) fn solve_at(&mut self, run: &mut Run<'_>, fraction: f64) -> Option<Convergence> {
        run.ramp.apply(&mut self.system, fraction);
        let outcome = self.newton.solve(&mut self.system, Start::nearby());
        run.effort.factorizations += outcome.as_ref().map_or_else(|lost| lost.iterations, |found| found.iterations);
        outcome.ok()
    }

    /// Goes back to the last accepted state, at this fraction.
    pub(super) fn back_to_last(&mut self, ramp: &Ramp, fraction: f64) {
        self.system.restore(&self.last);
        ramp.apply(&mut self.system, fraction);
        self.system.assemble(false);
    }

    /// Goes to the state that was kept ahead, at this fraction.
    pub(super) fn on_to_next(&mut self, ramp: &Ramp, fraction: f64) {
        self.system.restore(&self.next);
        ramp.apply(&mut self.system, fraction);
        self.system.assemble(false);
    }

    /// The last state becomes the one before it, and the present one the last.
    pub(super) fn shift_states(&mut self) {
        std::mem::swap(&mut self.last, &mut self.before);
        self.system.save(&mut self.last);
    }

    /// Ends a ramp at its end.
    pub(super) fn arrived(&mut self, run: &mut Run<'_>) -> bool {
        run.record.status = Status::Converged;
        self.settle(run, 1.0);
        true
    }

    /// Ends a ramp where nobody wants to wait any longer.
    pub(super) fn interrupted(&mut self, run: &mut Run<'_>, fraction: f64) -> bool {
        run.record.status = Status::Interrupted;
        self.settle(run, fraction);
        false
    }

    /// Ends a ramp at the last state, beyond which no equilibrium was found.
    pub(super) fn end_lost(&mut self, run: &mut Run<'_>, fraction: f64, lost: &Lost) -> bool {
        let ending = self.ending_of([fraction; 2], lost, false);
        run.record.status = ending.status;
        run.record.failure = Some(ending.failure);
        self.settle(run, fraction);
        false
    }
}
