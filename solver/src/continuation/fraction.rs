//! Increments by the fraction of a ramp: how far they go, and which of them are believed.
//!
//! The first increment is the whole ramp. One that is found is not believed at once, since it may lie on another branch: see
//! `passage.rs` and `acceptance.rs`. One that is not is made again, shorter.
//!
//! Theory: docs/theory/continuation.md, Eq. 8.1.

use super::arc::Purpose;
use super::follow::{Control, Next, Run, Tried};
use super::foretold::{Foretold, Slope};
use super::passage::{HALF_A_TURN, Passage};
use super::record::Ending;
use super::touching::Between;
use super::{Continuation, Count, Tuning};
use crate::chain::Size;
use crate::history::{Cause, CriticalPoint};
use crate::newton::{Aim, Convergence, Lost, Start, Why};
use crate::options::Options;
use crate::system::{Answer, System};

/// Pivots that may be lost together at a point that is not singular.
const PAIR: usize = 2;
/// Where a ramp is, and how far its next increment goes.
#[derive(Clone)]
pub(super) struct ByFraction {
    pub fraction: f64,
    /// Whether the state before the last one is on the same branch, near enough to extrapolate from.
    is_extrapolated: bool,
    length: f64,
    last_length: f64,
    /// What parts of a ramp are parts of: the whole of it, as a rule, and where the linear answer to that is beyond belief what lies
    /// behind, or the increment whose linear answer is to be believed.
    pub whole: f64,
    /// How fast the linear answer to the first increment moves, once one was tried in vain that it turns by no more than half a turn.
    linear_rate: Option<f64>,
    /// How fast the network moved in the first increment, if there was one, and in the last.
    first_rate: Option<f64>,
    last_rate: f64,
    /// Increments in a row that found nothing.
    failures: usize,
    /// Whether the increment that is tried was made shorter.
    is_shortened: bool,
    /// Whether linear buckling foresees, from the state that the ramp begins at, a critical load on the way: many iterations
    /// may lead to the other side of it.
    foresees_buckling: bool,
    /// Why the last increments failed, where a member is held at both ends.
    overheld: Option<Why>,
    /// How the network answers at the last state, where that is known.
    answer: Option<Answer>,
    /// Whether it became softer in the last increment.
    softens: bool,
    /// How its stiffness goes on, where that foretells a fold, until that was looked for.
    fold: Option<Foretold>,
    /// How the stiffness changed in the last increment, where that is known.
    slope: Option<Slope>,
}

/// An increment that is tried: its length, where it leads to, what the state there is for, and how far each part of the
/// network is foreseen to move by it.
struct Trial {
    length: f64,
    target: f64,
    aim: Aim,
    foreseen: Vec<Size>,
}

/// An equilibrium that follows the last one on its path.
pub(super) struct Increment {
    length: f64,
    target: f64,
    found: Convergence,
    count: Count,
    /// Singular points on the way, where there are any or stability is another.
    passed: Option<Vec<CriticalPoint>>,
    /// What the first increment of the iteration moved by, in radians or lengths of a member.
    missed: f64,
    /// How far the network moved, in radians or lengths, for a unit of the fraction.
    rate: f64,
    /// How the network answers.
    answer: Option<Answer>,
    /// Whether it leaves the branch of the last state for another one that meets it.
    leaves: bool,
    /// Whether singular points on the way are counted alone.
    counted: bool,
    /// The fraction at which the path touched another one, if it did.
    touched: Option<f64>,
}

/// What is to be made of an equilibrium that was found.
enum Judged {
    Accepted(Increment),
    /// It may lie on another path: try again with this length.
    TooLong(f64),
    /// Stability is lost before it, or the path cannot be followed there.
    Lost(Ending),
}

impl ByFraction {
    pub(super) fn new(fraction: f64, length: f64, answer: Option<Answer>) -> Self {
        Self {
            fraction,
            is_extrapolated: false,
            length,
            last_length: 0.0,
            whole: 1.0,
            linear_rate: None,
            first_rate: None,
            last_rate: 0.0,
            failures: 0,
            is_shortened: false,
            foresees_buckling: false,
            overheld: None,
            answer,
            softens: false,
            fold: None,
            slope: None,
        }
    }

    /// Whether the next increment would go beyond a fold that is foretold too near for a shorter one.
    pub(super) fn is_before_a_fold(&self, tuning: &Tuning) -> bool {
        self.fold.is_some_and(|fold| fold.ahead < self.length.min(tuning.bracket * self.whole))
    }

    /// The next increment, one that would leave next to nothing of the ramp drawn out to its end, and that leads to the next of
    /// these landmarks at most.
    fn trial(&self, landmarks: &[f64], options: &Options) -> Trial {
        let left = 1.0 - self.fraction;
        let length = if self.fraction + self.length * 1.0001 >= 1.0 { left } else { self.length };
        let ahead = landmarks
            .iter()
            .map(|landmark| landmark - self.fraction)
            .find(|&ahead| ahead > options.tuning.shortest * self.whole);
        let length = length.min(ahead.unwrap_or(left));
        let fold = self.fold.map(|fold| fold.longest(&options.tuning).max(options.tuning.bracket * self.whole));
        let length = length.min(fold.unwrap_or(left));
        let target = if self.fraction + length >= 1.0 - 1e-12 { 1.0 } else { self.fraction + length };
        let aim = match target {
            _ if options.rough => Aim::Rough,
            ..1.0 => Aim::Passing,
            _ => Aim::Result,
        };
        Trial { length, target, aim, foreseen: Vec::new() }
    }

    fn advance(&mut self, increment: &mut Increment, longest: f64, tuning: &Tuning) {
        // What was not extrapolated says too little of how far one can go.
        let missed = self.is_extrapolated.then_some(increment.missed);
        let next = tuning.next_length(increment.length, increment.found.iterations, missed);
        self.fraction = increment.target;
        self.whole = self.whole.max(self.fraction);
        // Where what lies behind is the measure, twice as much is not far as long as the state is foreseen well.
        let doubles = self.whole < 1.0 && !self.is_shortened && increment.missed <= tuning.miss;
        self.length = next.max(if doubles { self.fraction } else { 0.0 }).min(longest);
        self.last_rate = increment.rate;
        self.first_rate.get_or_insert(increment.rate);
        self.last_length = increment.length;
        self.is_extrapolated = !increment.leaves;
        self.failures = 0;
        self.is_shortened = false;
        self.foresees_buckling = false;
        self.overheld = None;
        let stiffness = [&increment.answer, &self.answer].map(|answer| answer.as_ref().map(Answer::stiffness));
        // Stiffness that hardly changes says nothing.
        self.softens = matches!(stiffness, [Some(here), Some(last)] if here < (1.0 - tuning.near) * last);
        let before = self.slope.take();
        self.fold = None;
        if let [Some(here), Some(last)] = stiffness {
            let slope = Slope::of(last, here, increment.length);
            // Where the extrapolation is the state the path is straight: what comes near is a bifurcation, if anything.
            let is_straight = missed.is_some_and(|missed| missed <= tuning.shortest);
            if self.softens && !is_straight {
                self.fold = before.and_then(|before| Foretold::by(here, [before, slope]));
            }
            self.slope = Some(slope);
        }
        self.answer = increment.answer.take();
    }

    /// Goes on from a singular point, or from beyond it; `last` is the increment between the last two states, where they may
    /// be extrapolated.
    pub(super) fn begin_again(&mut self, at: f64, next: f64, last: Option<f64>) {
        self.fraction = at;
        self.whole = self.whole.max(at);
        self.length = next;
        self.last_length = last.unwrap_or(0.0);
        self.is_extrapolated = last.is_some();
        self.failures = 0;
        self.is_shortened = false;
        self.foresees_buckling = false;
        self.answer = None;
        self.softens = false;
        self.fold = None;
        self.slope = None;
    }

    /// Near a fold the state moves ever faster with the loads.
    fn nears_a_fold(&self, tuning: &Tuning) -> bool {
        self.first_rate.is_some_and(|first| self.last_rate > tuning.longer * first)
    }

    /// Why no equilibrium was found in the end; an iteration is lost where its residual is larger than `residual`.
    fn reason(&self, lost: Lost, residual: f64) -> Lost {
        // What grew without end under more load does not settle under less, where forces are in balance.
        let settled = lost.why == Why::Slow && lost.residual.largest() <= residual;
        Lost { why: self.overheld.filter(|_| settled).unwrap_or(lost.why), ..lost }
    }

    /// Takes parts of the ramp of no more than is tried next, after a first increment that was not to be believed; `first` is how far
    /// its linear answer moved, `rests` whether the network has a stiffness where it begins, `found` whether there was an equilibrium.
    ///
    /// A slender thread that is straight answers linearly up to a sag of about its radius, and that may be a billionth of the ramp: the
    /// ramp says nothing of how long increments are there. A linear answer whose square is rounding is exact, and one that does not
    /// fall with the load is none: the network begins with a motion that nothing resists.
    fn begin_nearer(&mut self, trial: &Trial, (first, rests, found): (f64, bool, bool), tuning: &Tuning) {
        if self.first_rate.is_some() {
            return;
        }
        let rate = first / trial.length;
        // What turns by more than half a turn is measured too small.
        let is_linear = first > HALF_A_TURN || rate <= tuning.longer * *self.linear_rate.get_or_insert(rate);
        let is_beyond = rate > HALF_A_TURN || !found && self.length < tuning.shortest;
        if rests && is_linear && is_beyond && first > tuning.increment {
            self.whole = self.whole.min(self.fraction.max(self.length));
        }
    }

    /// Shortens the increment after an iteration that was given up, `first` is how far its first increment moved and `rests` as in
    /// [`Self::begin_nearer`]; whether that leads nearer to what is known, or else may go on so.
    fn shorten(&mut self, trial: &Trial, lost: &Lost, (first, rests): (f64, bool), tuning: &Tuning) -> Retry {
        (self.length, self.is_shortened) = (tuning.shorter * trial.length, true);
        // What turns by more than half a turn is no extrapolation: it foresees nothing, and no more than that is to be tried.
        let wild = first > HALF_A_TURN;
        let tame = tuning.shorter * HALF_A_TURN / first * trial.length;
        self.foresees_buckling |= self.first_rate.is_none() && !wild && matches!(lost.why, Why::Unstable(_));
        if let Why::Overheld(_) = lost.why {
            self.overheld = Some(lost.why);
        }
        let retry = match lost.why {
            Why::Wandered => {
                self.length = 0.5 * trial.length;
                Retry::Nearer
            }
            Why::Unstable(excess) => {
                // Past a limit point the extrapolation is unstable: go nearer before believing what comes; the more of it
                // is unstable, the farther away are stable loads.
                if !self.is_extrapolated {
                    self.length *= tuning.shorter.powf(excess.min(9) as f64 / 4.0 - 0.25);
                }
                let length = self.length.max(0.9 * tuning.bracket * self.whole);
                self.length = if wild { length.min(tame) } else { length };
                Retry::Nearer
            }
            why => {
                if why == Why::Astray && wild {
                    self.length = self.length.min(tame);
                }
                self.failures += 1;
                Retry::Shorter
            }
        };
        // What nothing gives way to does not settle under less.
        if !matches!(lost.why, Why::Overheld(_)) {
            self.begin_nearer(trial, (first, rests, false), tuning);
        }
        match retry {
            Retry::Shorter if self.length < tuning.shortest * self.whole => Retry::Never,
            Retry::Shorter if self.failures > tuning.iterations => Retry::Never,
            retry => retry,
        }
    }
}

/// What a shorter increment is worth.
enum Retry {
    /// It is nearer to what is known.
    Nearer,
    /// The same as before, so many times.
    Shorter,
    Never,
}

impl<const D: usize> Continuation<'_, D> {
    /// Tries the next increment: the state is at its end then, or the last one again.
    pub(super) fn increment_by_fraction(&mut self, run: &mut Run<'_>, by: &mut ByFraction) -> Tried<Increment, Ending> {
        let trial = self.predict_by_fraction(run, by);
        let (tried, first) = self.correct_by_fraction(run, by, &trial);
        let rests = self.base.negative() == 0 && !self.base.neutral;
        #[cfg(feature = "trace")]
        eprintln!(
            "at {:.3e} by {:.3e} whole {:.1e} first {:.1e}: {:?}",
            by.fraction, trial.length, by.whole, first, tried
        );
        match tried {
            Ok(found) => match self.assess(run, by, &trial, found) {
                Judged::Accepted(increment) => Tried::Accepted(increment),
                Judged::Lost(ending) => Tried::Lost(ending),
                Judged::TooLong(length) => {
                    debug_assert!(
                        length < trial.length,
                        "an increment is made again shorter, or it would be the same for ever"
                    );
                    self.system.restore(&self.last);
                    self.cut_short(by);
                    (by.length, by.is_shortened) = (length, true);
                    by.begin_nearer(&trial, (first, rests, true), &self.tuning);
                    Tried::Again
                }
            },
            Err(lost) => {
                self.system.restore(&self.last);
                if self.system.is_stopped() {
                    return Tried::Interrupted;
                }
                self.cut_short(by);
                match by.shorten(&trial, &lost, (first, rests), &self.tuning) {
                    Retry::Nearer => Tried::Again,
                    Retry::Shorter if (run.watch)(by.fraction) => Tried::Again,
                    Retry::Shorter => Tried::Interrupted,
                    Retry::Never => {
                        let fold = by.nears_a_fold(&self.tuning) && run.effort.accepted > 1;
                        let lost = by.reason(lost, self.tuning.tolerance());
                        Tried::Lost(self.ending_of([by.fraction, trial.target], &lost, fold))
                    }
                }
            }
        }
    }

    /// Takes an increment that was accepted.
    pub(super) fn advance_by_fraction(
        &mut self,
        run: &mut Run<'_>,
        by: &mut ByFraction,
        mut increment: Increment,
    ) -> Next {
        let ends = [by.fraction, increment.target];
        for answer in by.answer.iter().chain(&increment.answer) {
            self.way.go_on(answer.stiffness());
        }
        if let Some(fraction) = increment.touched {
            self.note_touched(run, fraction);
        }
        if increment.counted {
            self.note_counted(run.record, &increment.count, ends, 0);
        } else {
            let passed = increment.passed.take();
            let located = passed.as_ref().map_or(0, |points| points.len().max(1));
            self.note_changes(run.record, &increment.count, ends, passed);
            self.note_left_out(run, &increment.count, ends, located);
        }
        self.base = increment.count;
        self.shift_states();
        run.effort.accepted += 1;
        by.advance(&mut increment, run.longest, &self.tuning);
        if run.is_step {
            self.accept(run.record, by.fraction, increment.found.residual);
        }
        if !(run.watch)(by.fraction) && by.fraction < 1.0 {
            return Next::End(self.interrupted(run, by.fraction));
        }
        if by.fraction >= 1.0 { Next::End(self.arrived(run)) } else { Next::GoOn }
    }

    /// Looks beyond the last state for what stops the ramp, along the arc of its path.
    pub(super) fn search(&mut self, run: &mut Run<'_>, by: &mut ByFraction, ending: Ending) -> Next {
        // A member that is held at both ends, or pulled straight, is no singular point, and shorter increments change nothing.
        if matches!(ending.failure.cause, Cause::Overheld { .. }) {
            return Next::End(self.end_short(run, by.fraction, self.base, ending));
        }
        if let Some(taut) = self.at_reach(run, &ending) {
            return Next::End(self.end_short(run, by.fraction, self.base, taut));
        }
        let reach = 0.5 * self.tuning.bracket * by.whole;
        let arc = self.arc_from_last(run, by.fraction, reach, Purpose::Search);
        let Some(mut arc) = arc else { return Next::End(self.end_short(run, by.fraction, self.base, ending)) };
        arc.suspended = Some((by.clone(), self.base, Some(ending)));
        Next::By(Control::Arc(Box::new(arc)))
    }

    /// Looks for a fold that is foretold, along the arc of the path, which goes on by the fraction where there is none.
    pub(super) fn look_for_fold(&mut self, run: &mut Run<'_>, by: &mut ByFraction) -> Next {
        let Some(Foretold { ahead, .. }) = by.fold.take() else { return Next::GoOn };
        let reach = ahead.min(0.5 * self.tuning.bracket * by.whole);
        #[cfg(feature = "trace")]
        eprintln!("at {:.6e} a fold is foretold {ahead:.2e} ahead", by.fraction);
        let Some(mut arc) = self.arc_from_last(run, by.fraction, reach, Purpose::Search) else { return Next::GoOn };
        arc.suspended = Some((by.clone(), self.base, None));
        Next::By(Control::Arc(Box::new(arc)))
    }

    /// Puts the system at the loads of the next increment, on the extrapolation of the last two states where there are two.
    fn predict_by_fraction(&mut self, run: &mut Run<'_>, by: &mut ByFraction) -> Trial {
        let mut trial = by.trial(&run.landmarks, &self.options);
        if by.answer.is_none() && trial.target < 1.0 {
            run.ramp.apply(&mut self.system, by.fraction);
            self.system.assemble(false);
            run.effort.factorizations += 1;
            by.answer = self.system.answer();
        }
        run.ramp.apply(&mut self.system, trial.target);
        if by.is_extrapolated {
            self.system.predict(&self.before, &self.last, trial.length / by.last_length);
            trial.foreseen = self.system.distances(&self.last);
        }
        trial
    }

    /// Iterates to the equilibrium at the end of an increment; where that gets lost, again from the last state, more carefully. With how
    /// far the first increment of the first iteration moved, in radians or lengths of a member: without mixed stresses, elements that
    /// lock answer less.
    fn correct_by_fraction(
        &mut self,
        run: &mut Run<'_>,
        by: &ByFraction,
        trial: &Trial,
    ) -> (Result<Convergence, Lost>, f64) {
        let doubt = run.conservative && trial.length > self.tuning.bracket * by.whole;
        let may_lose = self.may_lose(run);
        let start = Start {
            predicted: by.is_extrapolated,
            rest: Some(&self.last),
            negative_limit: if doubt { self.base.own + may_lose } else { usize::MAX },
            aim: trial.aim,
            may_wander: trial.length <= self.tuning.near * by.whole,
            ..Start::nearby()
        };
        let again = Start { predicted: false, rest: None, ..start };
        let known = self.base.lateral;
        // Where a motion out of the plane needs no force, rounding and the mesh decide about a sign that is no loss.
        let mut aside =
            self.lateral.as_mut().filter(|_| self.base.lateral_stiffness >= self.tuning.bracket * self.stiffest_aside);
        let mut lost_aside = |system: &mut System<D>| match &mut aside {
            Some(lateral) => match lateral.inertia(system) {
                (inertia, true) => inertia.negative.saturating_sub(known + may_lose),
                _ => 0,
            },
            None => 0,
        };
        let mut outcome = self.newton.solve_beside(&mut self.system, start, &mut lost_aside);
        let first = self.system.moves.first_own;
        if let Err(lost) = &outcome
            && lost.why == Why::Astray
            && first < HALF_A_TURN
        {
            // A chain that is bent far too much at first curls up beyond measure: straight on it comes back.
            run.effort.count(&outcome);
            self.system.restore(&self.last);
            self.system.straight = true;
            outcome = self.newton.solve(&mut self.system, again);
            self.system.straight = false;
        }
        if let Err(lost) = &outcome
            && by.failures > 0
            && !matches!(lost.why, Why::Unstable(_) | Why::Wandered)
        {
            // Mixed stresses of a far iterate can mislead where stresses change sign: try without them.
            run.effort.count(&outcome);
            self.system.restore(&self.last);
            self.system.members.set_plain(true);
            outcome = self.newton.solve(&mut self.system, again);
            self.system.members.set_plain(false);
        }
        run.effort.count(&outcome);
        (outcome, first)
    }

    /// Whether the equilibrium that an increment led to is the one that follows the last on its path.
    fn assess(&mut self, run: &mut Run<'_>, by: &ByFraction, trial: &Trial, mut found: Convergence) -> Judged {
        let tuning = self.tuning;
        let [bracket, shortest] = [tuning.bracket, tuning.shortest].map(|part| part * by.whole);
        let (step, predicted) = (trial.length, by.is_extrapolated);
        let ends = [by.fraction, trial.target];
        // An iteration that begins whole turns away may well end there.
        let turn = self.system.moves.first_turn;
        if turn > HALF_A_TURN && step > shortest {
            return Judged::TooLong(tuning.shorter * HALF_A_TURN / turn * step);
        }
        let missed = self.system.moves.first_own;
        let first_moves = self.system.moves.first_by_part.clone();
        let foreseen = if predicted { &trial.foreseen } else { &first_moves };
        let mut answer = if trial.target < 1.0 || by.fold.is_some() { self.system.answer() } else { None };
        let shorter = |floor: f64| Judged::TooLong((tuning.shorter * step).max(0.9 * floor));
        // So near to a singular point the sign of its stiffness is noise, and which of the branches that meet there the iteration
        // came out on is chance: no place to end an increment at.
        if let Some((here, last)) = answer.as_ref().zip(by.answer.as_ref())
            && here.stiffness() < tuning.bracket * last.stiffness()
            && step > bracket
        {
            return shorter(bracket);
        }
        let mut count = self.count(&found.inertia);
        if count.neutral
            && trial.aim != Aim::Result
            && let Ok(better) = self.newton.exact().solve(&mut self.system, Start::nearby())
        {
            run.effort.factorizations += better.factorizations;
            count = self.count(&better.inertia);
        }
        // A moment on a joint that supports hold about some axes may have a potential where the joint has not turned yet.
        let conservative = run.conservative && count.potential;
        let counted = self.only_counts(run, &count);
        let guarded = !counted && self.loses_stability(&count);
        let moved = self.system.distances(&self.last);
        let ratio = predicted.then_some(step / by.last_length);
        let stiffness = [&by.answer, &answer].map(|answer| answer.as_ref().map(Answer::stiffness));
        let times = if let [Some(last), Some(here)] = stiffness { here / last } else { 1.0 };
        let double = tuning.longer.sqrt();
        let softens = by.softens || times > double;
        // So much softer or stiffer in one increment, a network may have passed a limit point by however few iterations.
        let is_another = times > double || times * double < 1.0;
        let passage = Passage {
            last: &self.last,
            before: ratio.map(|ratio| (&self.before, ratio)),
            ramp: Some(run.ramp),
            ends,
            from_rest: self.began_at_rest(),
            negative: self.base.own,
            softens,
            found,
            moved: &moved,
            foreseen,
        };
        #[cfg(feature = "trace")]
        eprintln!(
            "iterations {} contraction {:.1e} missed {missed:.1e} stiffness {:?} to {:?}, quick {}",
            found.iterations,
            found.contraction,
            stiffness[0],
            stiffness[1],
            passage.is_quick(&tuning),
        );
        let mut doubtful = passage.leapt(&tuning);
        let wrong = passage.is_doubtful(&self.system, &tuning);
        let quick = passage.is_quick(&tuning);
        let was_beyond = passage.began_beyond();
        let may_have_passed = passage.may_have_passed(&self.system, &tuning);
        let too_hard = passage.is_too_hard(&tuning);
        let mut aside = conservative && !guarded && !passage.parts_aside(&mut self.system, &tuning).is_empty();
        let same_aside =
            count.lateral == self.base.lateral || !(count.lateral_potential && self.base.lateral_potential);
        let same_count = count.own == self.base.own && same_aside;
        let steady = conservative && same_count;
        let was_nearly_symmetric = run.is_nearly_symmetric;
        let met = if steady { self.meeting(run, ends, (count, ratio, quick)) } else { None };
        if run.is_nearly_symmetric && !was_nearly_symmetric && step > bracket {
            // Followed back, what it came to folds on the way: the last state lies on another path, and that may end.
            run.is_nearly_symmetric = false;
            return shorter(bracket);
        }
        let met = match met {
            Some(met) if !met.is_behind() && step > bracket => {
                return shorter(bracket);
            }
            Some(met) => met.is_plain().then_some(met),
            None => None,
        };
        if met.is_some() {
            (doubtful, aside) = (false, false);
        }
        let looks = same_count && met.is_none() && step > shortest && !guarded && !doubtful && !aside;
        if looks && (may_have_passed || conservative && is_another) {
            aside = too_hard || self.swings_between(run, ends, ratio, (found, softens), (&moved, foreseen));
        }
        if met.is_none()
            && step > shortest
            && let Some((fold, end)) = by.fold.zip(answer.as_ref())
            && fold.is_missed(step, end.stiffness(), &tuning)
        {
            return shorter(shortest);
        }
        let flipped = !conservative && count.odd != self.base.odd;
        let rose = !conservative && count.own > self.base.own;
        let beyond = by.foresees_buckling && found.iterations >= tuning.many;
        let hard = met.is_none() && (wrong || beyond) || !conservative && found.iterations >= self.too_many(rose);
        // Far rotations take many iterations on any path: they are no reason to go nearer, but one to look twice; an extrapolation that had
        // lost a pivot which the end has is another.
        let twice = found.iterations >= tuning.most_nearby(rose) || was_beyond;
        let unsure = hard || !conservative && twice;
        let far = (guarded || doubtful || aside || flipped) && step > bracket;
        let mut torn = doubtful && found.iterations >= tuning.many;
        let mut passed = None;
        if flipped && !far && !torn {
            // A determinant that is zero nowhere on the way belongs to another path.
            passed = self.locate_changes(run, &count, ends);
            torn = passed.as_ref().is_some_and(Vec::is_empty);
        }
        if torn && (far || step > shortest) {
            return shorter(shortest);
        }
        // One pair of pivots may be lost at once where nothing is singular; more of them hide what lies between.
        if !conservative && count.own > self.base.own + PAIR && step > shortest {
            return shorter(shortest);
        }
        if far {
            return shorter(bracket);
        }
        if aside && !guarded && step > shortest {
            return shorter(shortest);
        }
        torn |= hard && step <= shortest;
        if rose && step > bracket || unsure && step > shortest {
            let again = if rose && hard { None } else { self.in_two_parts(run, ends, ratio) };
            let Some(again) = again else { return Judged::TooLong(0.5 * step) };
            if rose
                && step > bracket
                && !self.system.hangs()
                && let Some(part) = self.passed_twice(run, ends)
            {
                return Judged::TooLong((part * step).max(0.9 * bracket));
            }
            count = self.count(&again.inertia);
            found = Convergence { iterations: found.iterations, ..again };
        }
        // Increments are long where hardly anything moves, however much loads take of the stiffness.
        let still = moved.iter().all(|moved| moved.largest() <= tuning.miss);
        if !conservative
            && still
            && !flipped
            && step > bracket
            && !self.system.hangs()
            && let Some(part) = self.dipped_below(run, ends, by.answer.as_ref().map(|answer| answer.stiffness()))
        {
            return Judged::TooLong((part * step).max(0.9 * bracket));
        }
        let before = predicted.then_some(&self.before);
        if guarded || torn || aside || doubtful && self.system.jumped(&self.last, before, &tuning) {
            let sideways = guarded && count.own <= self.base.own;
            return Judged::Lost(Ending { loses: guarded, ..self.ending_at_loss(ends, sideways, predicted) });
        }
        let leaves = met.is_some();
        if let Some(met) = met {
            passed = Some(vec![met.point]);
        }
        if passed.is_none() && !counted {
            passed = self.locate_changes(run, &count, ends);
        }
        let several =
            passed.as_ref().is_some_and(|points| self.events_at(&count, false).number() > points.len().max(1));
        if several && step > bracket {
            let negative = [self.base.own, found.inertia.negative];
            if !conservative || !self.are_together(run, ends, negative, bracket / step) {
                return shorter(bracket);
            }
        }
        let rate = moved.into_iter().fold(Size::default(), Size::join).largest() / step;
        answer = answer.or_else(|| self.system.answer());
        let same = !leaves && passed.is_none() && !self.events_at(&count, false).any();
        let between = if same { self.seen_between(run, ends, [&by.answer, &answer]) } else { Between::Nothing };
        let touched = match between {
            // States between the ends need not lie on the path of the first.
            Between::Touched(_) | Between::Turned if step > bracket => return shorter(bracket),
            Between::Nothing | Between::Turned => None,
            Between::Leapt(_) if step > shortest => return shorter(shortest),
            Between::Touched(fraction) | Between::Leapt(fraction) => Some(fraction),
        };
        Judged::Accepted(Increment {
            length: step,
            target: trial.target,
            found,
            count,
            passed,
            missed,
            rate,
            answer,
            leaves,
            counted,
            touched,
        })
    }

    /// Notes that an increment is made again shorter on the way of a path. What the first ones foresee from where a ramp begins says
    /// little of the way.
    fn cut_short(&mut self, by: &ByFraction) {
        if by.first_rate.is_some() {
            self.way.cut_short();
        }
    }

    /// The overall stiffness at the last assembly.
    pub(super) fn overall_stiffness(&mut self) -> Option<f64> {
        self.system.tangent.overall_stiffness(&self.system.pattern, self.system.size)
    }

    /// Whether a rise of the count is to be trusted as a loss of stability.
    fn loses_stability(&self, count: &Count) -> bool {
        let own = count.own > self.base.own && count.potential;
        let aside = count.lateral > self.base.lateral && count.lateral_potential;
        own || aside
    }
}
