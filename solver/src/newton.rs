//! Newton's iteration at fixed loads, with mixed integration points.
//!
//! Theory: docs/theory/mixed-points.md, Eq. 6.3 and 6.6.

use crate::held::HeldForces;
use crate::rounding;
use crate::structure::MemberId;
use crate::system::{Inertia, Residual, State, System};

/// Part of the loads at which linear buckling tells that they are too much for one increment.
const FORESEEN: f64 = 0.3;

/// An increment larger than this part of the one before comes little nearer.
const SLOW: f64 = 0.5;
/// So many of them are no way to an equilibrium nearby.
const WANDERING: usize = 3;
/// An increment larger by this factor than the one before leads away.
const AWAY: f64 = 2.0;
/// What is left may be so many times what rounding is estimated to leave, and this part of the forces at most.
const TIMES: f64 = 10.0;
const WORST: f64 = 1e-2;
/// Increments smaller than this are near, whatever their rate.
pub const NEAR: f64 = 1e-2;
/// Part of the first residual at which a state is known well enough to be compared.
const COMPARED: f64 = 1e-2;

/// When an iteration is converged and when it is given up.
#[derive(Clone, Copy, Debug)]
pub struct Newton {
    /// Iterations after which it is given up.
    pub max_iterations: usize,
    /// Size of the last increment (radians, or lengths of a member) below which the next would be rounding: its square.
    pub increment: f64,
    /// Residual above which such a state is iterated once more.
    pub settled: f64,
    /// Residual of the joints over the largest force or moment that counts as equilibrium.
    pub residual: f64,
    /// Increment that is rounding, whatever the residual.
    pub still: f64,
    /// What the next increment is foreseen to be where a settled state needs no further one.
    pub foreseen: f64,
    /// Strain that a rigid component may still have.
    pub violation: f64,
    /// An increment that grows and exceeds this has lost its way.
    pub lost: f64,
}

impl Default for Newton {
    fn default() -> Self {
        Self {
            max_iterations: 16,
            increment: 1e-7,
            settled: 1e-10,
            residual: 1e-6,
            still: 1e-13,
            foreseen: 1e-12,
            violation: 1e-6,
            lost: 0.5,
        }
    }
}

/// An equilibrium that was found.
#[derive(Clone, Copy, Debug, Default)]
pub struct Convergence {
    /// Iterations that it took.
    pub iterations: usize,
    /// One an iteration, and one where linear buckling was asked.
    pub factorizations: usize,
    /// Pivots and residual at the equilibrium.
    pub inertia: Inertia,
    /// What is left of the equations.
    pub residual: Residual,
}

/// An iteration that was given up.
#[derive(Clone, Copy, Debug)]
pub struct Lost {
    /// Iterations until then.
    pub iterations: usize,
    /// See [`Convergence::factorizations`].
    pub factorizations: usize,
    /// What was left of the equations.
    pub residual: Residual,
    /// Why it was.
    pub why: Why,
}

/// Why an iteration was given up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Why {
    /// Too many iterations.
    Slow,
    /// Increments grow.
    Astray,
    /// The tangent has no factors.
    Singular,
    /// The linear extrapolation to these loads is unstable: a limit point may lie between. With the number of negative
    /// pivots that are too many.
    Unstable(usize),
    /// The iteration came little nearer three times, or went away once: it may arrive anywhere.
    Wandered,
    /// The axial force of this member, which cannot be stretched, grows without end.
    Overheld(MemberId),
}

/// Where an iteration starts from.
#[derive(Clone, Copy, Debug)]
pub struct Start<'a> {
    /// The state is an extrapolation already, not the last equilibrium.
    pub predicted: bool,
    /// The last equilibrium.
    pub rest: Option<&'a State>,
    /// Give up where the linear extrapolation to the loads has more negative pivots than this.
    pub negative_limit: usize,
    /// What the equilibrium is for.
    pub aim: Aim,
    /// An equilibrium that is not the nearest one will do.
    pub may_wander: bool,
}

/// What an equilibrium is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aim {
    /// To be read off.
    Result,
    /// To go on from: a larger residual will do.
    Passing,
    /// To go on from, on a finer mesh in the end: an even larger one will do.
    Rough,
    /// To be compared with the state that the iteration starts from: a small part of the way there does not matter.
    Comparison,
}

impl Start<'_> {
    /// To full accuracy from a state nearby.
    pub fn nearby() -> Self {
        Self { predicted: true, rest: None, negative_limit: usize::MAX, aim: Aim::Result, may_wander: true }
    }
}

impl Newton {
    /// Brings the system to equilibrium at its present loads; every iteration is one factorization.
    ///
    /// The last factorization is at the equilibrium itself: it gives the residual there, the reactions and the pivots.
    pub fn solve<const D: usize>(&self, system: &mut System<D>, start: Start<'_>) -> Result<Convergence, Lost> {
        let mut held = std::mem::take(&mut system.held_forces);
        held.begin(system);
        let result = self.iterate(system, start, &mut held);
        system.held_forces = held;
        result
    }

    fn iterate<const D: usize>(
        &self,
        system: &mut System<D>,
        start: Start<'_>,
        held: &mut HeldForces,
    ) -> Result<Convergence, Lost> {
        let mut last = f64::INFINITY;
        let mut before = f64::INFINITY;
        let mut misfit = 0.0;
        let mut violation = self.violation;
        let mut asked = 0;
        let mut slow = 0;
        let mut astray = false;
        for iterations in 1..=self.max_iterations {
            if system.is_stopped() {
                let residual = Residual::default();
                return Err(Lost { iterations: 0, factorizations: 0, residual, why: Why::Slow });
            }
            let pending = iterations == 1 || system.equations.has_general();
            let inertia = system.assemble(pending);
            let residual = system.residual();
            #[cfg(feature = "trace")]
            eprintln!("{iterations:3} {:.1e} {:.1e} {last:.1e} {inertia:?}", residual.force, residual.moment);
            if iterations == 1 {
                misfit = residual.largest();
                violation = match start.aim {
                    Aim::Result | Aim::Passing => self.violation,
                    Aim::Rough => 1e2 * self.violation,
                    Aim::Comparison => self.violation.max(COMPARED * system.violation()),
                };
            }
            let enough = match start.aim {
                Aim::Result => false,
                Aim::Passing => last <= 1e3 * self.increment && residual.largest() <= 1e4 * self.settled,
                Aim::Rough => last <= 1e4 * self.increment && residual.largest() <= 1e6 * self.settled,
                Aim::Comparison => last <= self.lost && residual.largest() <= COMPARED * misfit,
            };
            let converged =
                enough || self.is_converged(last, before, residual) || self.is_rounding(system, last, before, residual);
            let factorizations = iterations + asked;
            // A multiplier grows without end where a rigid rod would have to stretch: no increment shows it.
            let is_held = || system.violation() <= violation && held.are_settled(system, self.held_part(start.aim));
            if converged && is_held() {
                return Ok(Convergence { iterations, factorizations, inertia, residual });
            }
            let lost = |why| Err(Lost { iterations, factorizations, residual, why });
            if iterations == 1 && start.predicted && inertia.negative > start.negative_limit {
                return lost(Why::Unstable(inertia.negative - start.negative_limit));
            }
            if iterations == self.max_iterations {
                return lost(Why::Slow);
            }
            if system.advance(pending).is_none() {
                return lost(Why::Singular);
            }
            if iterations == 1 {
                system.note_first();
                if let Some(rest) = start.rest
                    && start.negative_limit < usize::MAX
                    && !start.predicted
                {
                    asked = 1;
                    let negative = self.buckling(system, rest);
                    if negative > start.negative_limit {
                        let why = Why::Unstable(negative - start.negative_limit);
                        return Err(Lost { iterations, factorizations: factorizations + 1, residual, why });
                    }
                }
            }
            // How far parts swing with what carries them says little: what counts is what is left without.
            let own = system.own_size.largest();
            if let Some(member) = held.follow(system, own <= NEAR) {
                return lost(Why::Overheld(member));
            }
            // The negation catches a NaN too.
            if !(own <= self.lost || own <= last) {
                return lost(Why::Astray);
            }
            if own > NEAR {
                slow += usize::from(own > SLOW * last);
                astray |= own > AWAY * last;
                if !start.may_wander && (astray || slow >= WANDERING) {
                    return lost(Why::Wandered);
                }
            }
            before = last;
            last = own;
        }
        unreachable!("the loop ends at its last iteration")
    }

    /// Whether an iteration with these last two increments has nothing left to gain.
    ///
    /// A second increment below the limit is rounding: no iteration makes the residual smaller. Where nothing is
    /// stressed, the residual is small against the stiffness alone, and the increment tells.
    pub fn is_converged(&self, last: f64, before: f64, residual: Residual) -> bool {
        let still = last <= self.still && residual.largest() < 1.0;
        let settled = residual.largest() <= self.settled;
        // Increments fall by their squares: from the last two follows the next.
        let next = last * last * (last / (before * before)).max(1.0);
        let foreseen = before <= self.lost && next <= self.foreseen;
        let twice = before <= self.increment || foreseen && last <= 0.1 * self.increment;
        let rounding = twice && (residual.largest() <= self.residual || still);
        last <= self.increment && (settled || rounding) || settled && foreseen
    }

    /// Part of the largest force that the axial forces of members that cannot be stretched may be off by: ten times what
    /// the residual of a settled state may be, and as many times more as that may where an aim is lower.
    pub fn held_part(&self, aim: Aim) -> f64 {
        let lower = match aim {
            Aim::Result => 1.0,
            Aim::Passing => 1e4,
            Aim::Rough | Aim::Comparison => 1e6,
        };
        (10.0 * lower * self.settled).min(COMPARED)
    }

    /// Whether two small increments left a residual that no iteration makes smaller: a short stiff member between places
    /// far from where they were.
    fn is_rounding<const D: usize>(&self, system: &mut System<D>, last: f64, before: f64, residual: Residual) -> bool {
        let stays = last <= self.increment && before <= self.increment && residual.largest() > self.residual;
        stays && residual.largest() <= (TIMES * rounding::floor(system)).min(WORST)
    }

    /// Linear buckling: negative pivots of the shape of the last equilibrium under a part of the stresses that the first
    /// increment foresees.
    ///
    /// Linear factors a little below one are common where nothing buckles (a curved beam bent out of its plane).
    fn buckling<const D: usize>(&self, system: &mut System<D>, rest: &State) -> usize {
        let here = system.snapshot();
        system.restore_shape(rest, FORESEEN);
        let inertia = system.assemble(false);
        system.restore(&here);
        inertia.negative
    }
}
