//! Newton's iteration, with mixed integration points: at fixed loads, or along a path with the loads as one more unknown.
//!
//! Theory: docs/theory/mixed-points.md, Eq. 6.3 and 6.6; docs/theory/continuation.md, Eq. 8.2.

use crate::continuation::Tuning;
use crate::held::HeldForces;
use crate::rounding;
use crate::structure::MemberId;
use crate::system::{Inertia, Residual, State, System};

/// What is left may be so many times what rounding is estimated to leave.
const TIMES: f64 = 10.0;
/// Factors serve on where an increment turns no member by more than this over its slenderness: what is stiff along a member and
/// soft across it lies in another direction then, and the stiffness differs by the square of this.
const TURNED: f64 = 0.3;
/// They do so as long as every increment is at most this part of the one before. Where they are far from singular, the
/// equilibrium has as many negative pivots as they: one of another sign would make increments grow.
const SERVES: f64 = 0.1;

/// Tangent of an angle by which no element of a rod that cannot be stretched leans against its own chord for the bending within it: that
/// is a twelfth of what its curvature changes by from end to end times its length, three radians.
///
/// A corotational element resists it by 12 EI over the square of its present length, and so gives way to a pull: leaning more and more
/// it comes as long as it takes, for an energy of 6 EI/h at most. Where a rod is to come longer than it is, one element that does so
/// holds all forces in balance; up to here it is longer by three hundredths.
const LEANS: f64 = 0.25;

/// Newton's iteration, and the numbers that say when it is converged and when it is given up.
#[derive(Clone, Copy, Debug, Default)]
pub struct Newton {
    /// Those of the whole solve, as a rule.
    pub tuning: Tuning,
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
    /// The largest of its increments that are not near over the one before.
    pub contraction: f64,
    /// Negative pivots where it began.
    pub negative_at_first: usize,
    /// The last of its increments (radians, or lengths of a member).
    pub last: f64,
    /// The next one, as the last two foresee it.
    pub left: f64,
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
    /// The path has left its ramp, for many times the loads the other way.
    Away,
    /// The path has not come to the end of its ramp after as many increments as are made at most.
    Long,
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
    /// The system is linearized at the state, the motion of held components included.
    pub linearized: bool,
    /// Factors serve on once increments are small, as long as the smallest of their pivots is no less than this: an increment then
    /// costs a fraction of what it costs with new ones. `None` where every increment has factors of its own. Those of a comparison
    /// serve for its last look at the forces alone, and stay those of the state before.
    pub reuses_factors: Option<f64>,
    /// They do so after an increment no larger than this (radians, or lengths of a member).
    pub reuses_within: f64,
    /// So much of the increments may be left (radians, or lengths of a member) for one more step with the factors at hand, which
    /// follows then.
    pub leaves: f64,
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
        Self {
            predicted: true,
            rest: None,
            negative_limit: usize::MAX,
            aim: Aim::Result,
            may_wander: true,
            linearized: false,
            reuses_factors: None,
            reuses_within: f64::INFINITY,
            leaves: 0.0,
        }
    }
}

/// What an iteration solves for: the state alone, or the fraction of a ramp as well.
pub(crate) trait Unknowns<const D: usize> {
    /// Linearizes at the present state and factorizes.
    fn linearize(&mut self, system: &mut System<D>, first: bool) -> Inertia;
    /// Forces at the present state alone, by the factors of the last linearization; `None` where these do not tell them. Whether the
    /// iteration can go on with these factors is said.
    fn refresh(&mut self, _: &mut System<D>) -> Option<bool> {
        None
    }
    /// Whether what they have beside the state has converged.
    fn are_settled(&self, tuning: &Tuning) -> bool;
    /// Motions beside those of the tangent that have lost their stiffness at the last linearization.
    fn lost_aside(&mut self, _: &mut System<D>) -> usize {
        0
    }
    /// Solves, and moves the state; the size of the increment (radians, or lengths of a member), `None` where there is none.
    fn advance(&mut self, system: &mut System<D>) -> Option<f64>;
}

/// Counts motions beside those of the tangent that have lost their stiffness at the last assembly.
pub type Aside<'a, const D: usize> = &'a mut dyn FnMut(&mut System<D>) -> usize;

/// The state at fixed loads.
struct AtFixedLoads<'a, const D: usize> {
    pending: bool,
    aside: Option<Aside<'a, D>>,
}

impl<const D: usize> Unknowns<D> for AtFixedLoads<'_, D> {
    fn linearize(&mut self, system: &mut System<D>, first: bool) -> Inertia {
        self.pending = first || system.pattern.equations.has_general();
        system.assemble(self.pending)
    }

    fn refresh(&mut self, system: &mut System<D>) -> Option<bool> {
        self.pending = system.pattern.equations.has_general();
        let goes_on = system.refresh(self.pending);
        system.tangent.has_potential().then_some(goes_on)
    }

    fn are_settled(&self, _: &Tuning) -> bool {
        true
    }

    fn lost_aside(&mut self, system: &mut System<D>) -> usize {
        self.aside.as_mut().map_or(0, |aside| aside(system))
    }

    fn advance(&mut self, system: &mut System<D>) -> Option<f64> {
        system.advance(self.pending)?;
        // How far parts swing with what carries them says little: what counts is what is left without.
        Some(system.moves.own.largest())
    }
}

impl Newton {
    /// An iteration with these numbers.
    pub(crate) fn new(tuning: Tuning) -> Self {
        Self { tuning }
    }

    /// The same, to a smaller increment: the stiffness of a motion that needs no force is as small as the state is exact.
    pub(crate) fn exact(self) -> Self {
        Self { tuning: Tuning { increment: self.tuning.exact, ..self.tuning } }
    }

    /// Brings the system to equilibrium at its present loads; every iteration is one factorization, or none where factors serve on.
    ///
    /// The last factorization is at the equilibrium itself: it gives the residual there, the reactions and the pivots.
    ///
    /// # Errors
    /// Where the iteration does not converge, or to a state that is not to be believed.
    pub fn solve<const D: usize>(&self, system: &mut System<D>, start: Start<'_>) -> Result<Convergence, Lost> {
        self.solve_for(system, start, &mut AtFixedLoads { pending: true, aside: None })
    }

    /// The same, where motions beside those of the tangent count for what the start's limit is for.
    ///
    /// # Errors
    /// As [`Newton::solve`].
    pub fn solve_beside<const D: usize>(
        &self,
        system: &mut System<D>,
        start: Start<'_>,
        aside: Aside<'_, D>,
    ) -> Result<Convergence, Lost> {
        self.solve_for(system, start, &mut AtFixedLoads { pending: true, aside: Some(aside) })
    }

    /// The same for other unknowns.
    pub(crate) fn solve_for<const D: usize>(
        &self,
        system: &mut System<D>,
        start: Start<'_>,
        unknowns: &mut impl Unknowns<D>,
    ) -> Result<Convergence, Lost> {
        let mut held = std::mem::take(&mut system.held_forces);
        held.begin(system);
        let result = self.iterate(system, start, unknowns, &mut held);
        system.held_forces = held;
        result
    }

    fn iterate<const D: usize>(
        &self,
        system: &mut System<D>,
        start: Start<'_>,
        unknowns: &mut impl Unknowns<D>,
        held: &mut HeldForces,
    ) -> Result<Convergence, Lost> {
        let mut last = f64::INFINITY;
        let mut before = f64::INFINITY;
        let mut misfit = 0.0;
        let mut violation = self.tuning.tolerance();
        let mut asked = 0;
        let mut so_far = Convergence::default();
        let mut slow = 0;
        let mut inertia = Inertia::default();
        let mut has_factors = false;
        let mut astray = false;
        let mut left = f64::INFINITY;
        for iterations in 1..=self.tuning.iterations {
            if system.is_stopped() {
                let residual = Residual::default();
                return Err(Lost { iterations: 0, factorizations: 0, residual, why: Why::Slow });
            }
            let small = last * system.loading.slenderness().max(1.0) <= TURNED && last <= SERVES * before;
            let may_end = start.aim == Aim::Rough && last <= self.tuning.tolerance().sqrt();
            let serve = has_factors
                && start.aim != Aim::Comparison
                && (small || may_end)
                && last <= start.reuses_within
                && start.reuses_factors.is_some_and(|smallest| inertia.smallest >= smallest);
            if self.may_end_by_forces(system, start, &inertia, last) && unknowns.refresh(system).is_some() {
                let residual = system.residual();
                if residual.largest() <= self.tuning.near * misfit {
                    let factorizations = iterations - 1 + asked;
                    return Ok(Convergence { iterations, factorizations, inertia, residual, ..so_far });
                }
            }
            let fresh = if iterations == 1 && start.linearized {
                (inertia, has_factors) = (system.tangent.inertia(), true);
                true
            } else if !(serve
                && unknowns.refresh(system) == Some(true)
                && (small || system.residual().largest() <= self.tuning.shortest))
            {
                inertia = unknowns.linearize(system, iterations == 1);
                has_factors = true;
                true
            } else {
                false
            };
            let residual = system.residual();
            #[cfg(feature = "trace")]
            eprintln!("{iterations:3} {:.1e} {:.1e} {last:.1e} {inertia:?}", residual.force, residual.moment);
            if iterations == 1 {
                misfit = residual.largest();
                so_far.negative_at_first = inertia.negative;
                violation = match start.aim {
                    Aim::Result | Aim::Passing => self.tuning.tolerance(),
                    Aim::Rough => self.tuning.shortest,
                    Aim::Comparison => self.tuning.tolerance().max(self.tuning.near * system.members.violation()),
                };
            }
            let enough = match start.aim {
                Aim::Result => false,
                // Right beyond a limit point forces nearly balance, and increments go on without end.
                Aim::Passing => {
                    last <= self.tuning.shortest.min(self.tuning.contraction * before)
                        && residual.largest() <= self.tuning.tolerance()
                }
                Aim::Rough => last <= self.tuning.tolerance().sqrt() && residual.largest() <= self.tuning.shortest,
                Aim::Comparison => last <= self.tuning.trust && residual.largest() <= self.tuning.near * misfit,
            };
            let converged =
                enough || self.is_converged(last, before, residual) || self.is_rounding(system, last, before, residual);
            let settles = residual.largest() <= self.tuning.residual && before <= self.tuning.trust;
            let followed = !converged && settles && left <= start.leaves;
            let factorizations = iterations + asked;
            // A multiplier grows without end where a rigid rod would have to stretch: no increment shows it.
            let is_held = || {
                !system.loading.holds_strains()
                    || system.members.violation() <= violation && held.are_settled(system, self.held_part(start.aim))
            };
            let settled = (converged || followed) && unknowns.are_settled(&self.tuning) && is_held();
            if settled && system.members.lean() > LEANS {
                return Err(Lost { iterations, factorizations, residual, why: Why::Astray });
            }
            if settled && !system.follow_carried_forces() {
                // The step that follows is one of the iteration.
                let iterations = iterations + usize::from(followed);
                return Ok(Convergence { iterations, factorizations, inertia, residual, last, left, ..so_far });
            }
            let lost = |why| Err(Lost { iterations, factorizations, residual, why });
            if iterations == 1 && start.predicted && start.negative_limit < usize::MAX {
                let excess = inertia.negative.saturating_sub(start.negative_limit) + unknowns.lost_aside(system);
                if excess > 0 {
                    return lost(Why::Unstable(excess));
                }
            }
            if iterations == self.tuning.iterations {
                return lost(Why::Slow);
            }
            let Some(size) = unknowns.advance(system) else { return lost(Why::Singular) };
            if iterations == 1 {
                system.moves.note_first();
                if let Some(rest) = start.rest
                    && start.negative_limit < usize::MAX
                    && !start.predicted
                {
                    asked = 1;
                    has_factors = false;
                    let excess = self.buckling_pivots(system, rest, start.negative_limit, unknowns);
                    if excess > 0 {
                        let why = Why::Unstable(excess);
                        return Err(Lost { iterations, factorizations: factorizations + 1, residual, why });
                    }
                }
            }
            if let Some(member) = held.follow(system, size <= self.tuning.near) {
                return lost(Why::Overheld(member));
            }
            // The negation catches a NaN too.
            if !(size <= self.tuning.trust || size <= last) {
                return lost(Why::Astray);
            }
            if size > self.tuning.near {
                so_far.contraction = f64::max(so_far.contraction, size / last);
                slow += usize::from(size > self.tuning.contraction * last);
                astray |= self.tuning.contraction * size > last;
                if !start.may_wander && (astray || slow > self.tuning.many / 3) {
                    return lost(Why::Wandered);
                }
            }
            before = last;
            last = size;
            // With factors of the state increments fall by their squares, with others by as much each time.
            left = if fresh { foreseen(last, before) } else { last * last / before };
        }
        unreachable!("the loop ends at its last iteration")
    }

    /// Whether forces by the factors at hand may tell that a comparison has come to its end: nothing that was moved since by so
    /// little turns a sign of these.
    fn may_end_by_forces<const D: usize>(
        &self,
        system: &System<D>,
        start: Start<'_>,
        inertia: &Inertia,
        last: f64,
    ) -> bool {
        let firm = start.reuses_factors.is_some_and(|smallest| inertia.smallest >= smallest);
        let stable = inertia.negative + inertia.neutral == 0;
        let moved = last <= self.tuning.shortest && !system.loading.holds_strains();
        start.aim == Aim::Comparison && firm && stable && moved
    }

    /// Whether an iteration with these last two increments has nothing left to gain.
    ///
    /// A second increment below the limit is rounding: no iteration makes the residual smaller. Where nothing is
    /// stressed, the residual is small against the stiffness alone, and the increment tells.
    pub(crate) fn is_converged(&self, last: f64, before: f64, residual: Residual) -> bool {
        let still = last <= 0.1 * self.tuning.rounding && residual.largest() < 1.0;
        let settled = residual.largest() <= self.tuning.residual;
        let foreseen = before <= self.tuning.trust && foreseen(last, before) <= self.tuning.rounding;
        let twice = before <= self.tuning.increment || foreseen && last <= 0.1 * self.tuning.increment;
        let rounding = twice && (residual.largest() <= self.tuning.tolerance() || still);
        last <= self.tuning.increment && (settled || rounding) || settled && foreseen
    }

    /// Part of the largest force that the axial forces of members that cannot be stretched may be off by: ten times what
    /// the residual of a state may be, a hundredth at most.
    pub(crate) fn held_part(&self, aim: Aim) -> f64 {
        let residual = match aim {
            Aim::Result => self.tuning.residual,
            Aim::Passing => self.tuning.tolerance(),
            Aim::Rough | Aim::Comparison => self.tuning.shortest,
        };
        (10.0 * residual).min(self.tuning.near)
    }

    /// Whether two small increments left a residual that no iteration makes smaller: a short stiff member between places
    /// far from where they were.
    fn is_rounding<const D: usize>(&self, system: &mut System<D>, last: f64, before: f64, residual: Residual) -> bool {
        let stays = last <= self.tuning.increment
            && before <= self.tuning.increment
            && residual.largest() > self.tuning.tolerance();
        stays && residual.largest() <= (TIMES * rounding::floor(system)).min(self.tuning.near)
    }

    /// Linear buckling: how many more negative pivots than this limit the shape of the last equilibrium has under a part of the
    /// stresses that the first increment foresees, and motions beside.
    fn buckling_pivots<const D: usize>(
        &self,
        system: &mut System<D>,
        rest: &State,
        limit: usize,
        unknowns: &mut impl Unknowns<D>,
    ) -> usize {
        let mut here = std::mem::take(&mut system.aside);
        system.save(&mut here);
        system.restore_shape(rest, self.tuning.buckling);
        system.follow_carried_forces();
        let negative = system.assemble(false).negative;
        let excess = negative.saturating_sub(limit) + unknowns.lost_aside(system);
        system.restore(&here);
        system.aside = here;
        excess
    }
}

/// The increment after the last two: with factors of the state they fall by their squares.
fn foreseen(last: f64, before: f64) -> f64 {
    last * last * (last / (before * before)).max(1.0)
}
