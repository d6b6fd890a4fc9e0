//! Linear buckling about a converged state: factors λ at which K + λ K′ is singular.
//!
//! λ is the fraction of a ramp that begins at the state: of the next step, or of one that adds the present loads,
//! pressures and prescribed motions once more. K is the tangent of the state. K′ is its change along the ramp at the shape
//! of the state: by the change of section stiffness with pressure, of the stresses, which is that of the linear response to
//! the beginning of the ramp, and of the loads. The tangent is linear in all of them, so that K′ is exact and no
//! difference of two tangents.
//!
//! The shape is frozen on purpose. A tangent that is linearized along with the rotations of its elements, K + λ (WᵀK + KW),
//! lacks the term λ² WᵀKW, and turns negative in stiff directions as soon as elements turn by their slenderness: long
//! before anything buckles. What is left out is of the order of the deformation up to the critical load; about a state near
//! it the factor is exact.
//!
//! Theory: docs/theory/stability.md, Eq. 7.6.

mod change;
mod lacks;
mod problem;
mod response;

use std::cell::OnceCell;

use crate::base::{self, Base, Reach};
use crate::error::SolveError;
use crate::modes::{Found, Part, Place, place, split};
use crate::options::{Options, Progress};
use crate::packs;
use crate::spectral::factor::{Analyzed, Factor};
use crate::spectral::operators::{Assembled, Operators, matrix};
use crate::spectral::pencil;
use crate::spectral::prolong::{Grid, Motion};
use crate::spectral::shape::Shape;
use crate::spectral::unknowns::{Family, Unknowns};
use crate::structure::{Step, Structure};
use problem::{Counted, Enough, Matrices, Problem, Raw, Search};

/// How often the part of a ramp that its beginning is found on is made shorter.
const SHORTENED: usize = 3;
/// Part of a response that it may be out of proportion by rounding.
const EXACT: f64 = 1e-13;
/// Orders beyond that of the elements asked for, at most.
pub const MORE_ORDERS: usize = 2;

/// What λ multiplies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ramp {
    /// The ramp of this step, which begins at the end of the one before it.
    Of(usize),
    /// All loads, pressures, actuations and prescribed motions at the end of this step, once more.
    Present(usize),
}

/// A critical factor and its mode.
#[derive(Clone, Debug)]
pub struct Critical {
    /// Fraction of the ramp, negative for a ramp the other way.
    pub factor: f64,
    /// Part of it that rounding may be, and what the response to the ramp is known to.
    pub rounding: f64,
    /// Whether it leaves the plane.
    pub family: Family,
    /// Scaled to a largest component of one.
    pub shape: Shape,
    /// The part by which the factor is larger on elements of one order less, as far as it comes from the motion, and by how much
    /// more it is on those of two orders less.
    pub lacking: [f64; 2],
}

/// The nearest factor of a ramp the other way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reversed {
    /// Fraction of the ramp, negative.
    pub factor: f64,
    /// Part of it that rounding may be, and what the response to the ramp is known to.
    pub rounding: f64,
    /// As [`Critical::lacking`].
    pub lacking: [f64; 2],
}

/// Critical factors about a state.
#[derive(Clone, Debug)]
pub struct Buckling {
    /// Positive ones, the smallest first.
    pub critical: Vec<Critical>,
    /// The nearest factor of the ramp the other way, up to a thousand times the first one.
    pub reversed: Option<Reversed>,
    /// The state that it is about.
    pub place: Place,
    /// How far the steps came.
    pub reach: Reach,
    /// Families that have no symmetric tangent, for want of a potential of the loads.
    pub left_out: Vec<Family>,
    /// Families in which the state is neutral, so that any factor is critical.
    pub neutral: Vec<Family>,
    /// Whether the count of pivots confirms that no smaller factor is missing.
    pub complete: bool,
    /// Unknowns of the eigenvalue problem.
    pub unknowns: usize,
    /// By how much the order of the elements is higher than that of those asked for.
    pub raised: usize,
    /// Where they are on other elements.
    pub near: Near,
}

/// Critical motions, near which those on other elements of the same network are.
#[derive(Clone, Debug, Default)]
pub struct Near {
    grid: Grid,
    /// How many are asked for.
    wanted: usize,
    /// These by rising factors, and those that are not apart from the last of them.
    critical: Vec<Start>,
    /// How many times the largest of them the next one is, if that is known.
    next: Option<f64>,
    /// The nearest one of the ramp the other way, if there is any.
    reversed: Vec<Start>,
    /// The part of the ramp that its beginning was found on; nothing where the response is in exact proportion.
    part: Option<f64>,
}

/// A critical motion, and its factor.
#[derive(Clone, Debug)]
struct Start {
    factor: f64,
    family: Family,
    motion: Motion,
}

/// Why there are no factors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoFactors {
    /// A step before the ramp did not reach its end.
    NotReached,
    /// The state is not found again on the elements that factors are computed with.
    NotSettled,
    /// Loads without a potential make the tangent unsymmetric.
    NoPotential,
    /// The state is unstable already, in so many motions.
    Unstable(usize),
    /// The state is neutral, or the network a mechanism in motions that only prestress holds.
    Neutral,
    /// The ramp moves nothing.
    NothingMoves,
    /// Of what was found nothing is a motion that the members allow, and no count says that there is nothing.
    NotFound,
}

/// What is asked of a ramp.
pub struct Asked<'a> {
    /// How many factors.
    pub count: usize,
    /// Those of other elements, where they are known.
    pub near: Option<&'a Near>,
    /// Whether the factors of the orders that are known, the highest one first and the others from the lowest on, say enough: of more
    /// orders nothing is asked then.
    pub are_enough: &'a dyn Fn(&[Buckling]) -> bool,
}

/// A state, the ramp that begins there, and the drives at its two ends.
struct Beginning {
    base: Base,
    /// By how much the order of its elements is higher than that of those asked for.
    raised: usize,
    from: Vec<f64>,
    to: Vec<f64>,
    /// The longest part of the ramp that its beginning may be found on.
    longest: f64,
}

/// The smallest factors of a ramp: on the elements asked for and on those of the next two orders, or of the next one
/// where there are no more; the highest order comes last. Others are left out where those that are known say enough.
///
/// They are looked for on the lowest order, unless those of other elements are known; found near these on the highest one, and near
/// those on the lowest one, where they are not known, and on orders between.
///
/// # Errors
/// Those of [`crate::solve`].
pub fn buckle(
    structure: &Structure,
    steps: &[Step],
    ramp: Ramp,
    asked: &Asked<'_>,
    options: &Options,
    observe: &mut dyn FnMut(&Progress) -> bool,
) -> Result<Found<Vec<Buckling>, NoFactors>, SolveError> {
    let count = match ramp {
        Ramp::Of(step) => step,
        Ramp::Present(step) => (step + 1).min(steps.len()),
    };
    let (mut followed, history) = base::follow(structure, steps, count, options, observe)?;
    if !base::is_complete(&history) {
        return Ok(Found { history, result: Err(NoFactors::NotReached) });
    }
    let from = followed.drives().to_vec();
    let mut to = from.clone();
    match ramp {
        Ramp::Of(step) => {
            for &(drive, value) in &steps[step].targets {
                to[drive] = value;
            }
        }
        Ramp::Present(_) => to.iter_mut().for_each(|value| *value *= 2.0),
    }
    let &Asked { count: wanted, near, are_enough } = asked;
    let mut beginning = |raised: usize, longest: f64| {
        let base = match ramp {
            Ramp::Of(step) => followed.beginning(&steps[step], raised),
            Ramp::Present(_) => followed.base(raised).map(|mut base| {
                base.once_more();
                base
            }),
        };
        let beginning = |base| Beginning { base, raised, from: from.clone(), to: to.clone(), longest };
        base.map(beginning).ok_or(NoFactors::NotSettled)
    };
    let highest = structure.members.iter().map(|member| member.order).max().unwrap_or(1);
    let most = packs::HIGHEST.saturating_sub(highest).clamp(1, MORE_ORDERS);
    let mut levels = || {
        let mut longest = near.map_or(1.0, Near::longest);
        let mut first = match near {
            Some(_) => None,
            // What these elements cannot do is for those of the highest order to say.
            None => beginning(0, longest).and_then(|state| state.answer(wanted, None)).ok(),
        };
        // Far beyond a critical load stresses are in proportion too, to another stiffness.
        for _ in 0..SHORTENED {
            let Some(found) = first.as_ref().filter(|found| !found.is_short()) else { break };
            longest = found.near.longest();
            first = beginning(0, longest).and_then(|state| state.answer(wanted, None)).ok();
        }
        let near = near.or(first.as_ref().map(|first| &first.near));
        longest = near.map_or(longest, |near| near.longest().min(longest));
        let mut found = beginning(most, longest)?.answer(wanted, near)?;
        for _ in 0..SHORTENED {
            if found.is_short() {
                break;
            }
            longest = found.near.longest();
            // What was found on a longer part is of another response.
            first = None;
            found = beginning(most, longest)?.answer(wanted, None)?;
        }
        // A part of the ramp that is short enough on one order is as short on the others.
        longest = found.near.longest().min(longest);
        let mut levels = vec![found];
        for raised in 0..most {
            if are_enough(&levels) {
                break;
            }
            let known = if raised == 0 { first.take() } else { None };
            let lower = match known {
                Some(known) => known,
                None => beginning(raised, longest)?.again(&levels[0].near)?,
            };
            levels.push(lower);
        }
        levels.sort_by_key(|level| level.raised);
        Ok(levels)
    };
    let result = levels();
    Ok(Found { history, result })
}

impl Buckling {
    /// Whether the beginning of the ramp was found on a part that is short beside the nearest factor, or on any.
    fn is_short(&self) -> bool {
        self.near.part.is_none_or(|part| self.near.short() >= part)
    }
}

impl Base {
    /// Makes the held motions those of a ramp on which they are made once more.
    fn once_more(&mut self) {
        let mut rows = self.system.pattern.equations.held.clone();
        for row in &mut rows {
            row.from = row.to;
            row.to *= 2.0;
        }
        self.system.loading.fading.clear();
        self.system.hold(rows);
        self.system.loading.fraction = 0.0;
        self.system.apply_drives();
        self.system.assemble(false);
    }
}

impl Beginning {
    fn problem(&mut self) -> Result<Problem, NoFactors> {
        let system = &mut self.base.system;
        let moving = system.pattern.equations.held.iter().any(|row| row.from != row.to);
        if self.from == self.to && !moving && system.loading.fading.is_empty() {
            return Err(NoFactors::NothingMoves);
        }
        let unknowns = Unknowns::new(system);
        let assembled = Assembled::without_mass(system, &unknowns);
        let mut without_potential = system.tangent.without_potential();
        let change = self.change(&unknowns, &mut without_potential).ok_or(NoFactors::Neutral)?;
        let (parts, left_out) = split(&self.base, &unknowns, &without_potential);
        let matrices = |(family, numbers): Part| {
            let operators = assembled.of_family(&numbers);
            let softening = matrix(&change.entries, &numbers).map(|value| -value);
            let analyzed = Analyzed::default();
            let made =
                |operators: &Operators| analyzed.factor(&operators.stiffness).filter(|factor| factor.neutral == 0);
            let firm = || pencil::firm(&operators, &made, &|factor| factor);
            let (raised, factor) = match operators.holds_stretches().then(firm) {
                None => (None, OnceCell::new()),
                Some(None) => (None, OnceCell::from(None)),
                Some(Some((raised, factor))) => (raised, OnceCell::from(Some(factor))),
            };
            let operators = raised.unwrap_or(operators);
            Matrices { family, numbers, operators, softening, factor, analyzed }
        };
        let families = parts.into_iter().map(matrices).filter(|own| own.operators.stiffness.rows() > 0).collect();
        let grid = Grid::of(&self.base.system);
        Ok(Problem { unknowns, grid, change, families, left_out })
    }

    /// The factors, and the nearest one of the ramp the other way.
    fn answer(mut self, wanted: usize, near: Option<&Near>) -> Result<Buckling, NoFactors> {
        let mut problem = self.problem()?;
        if problem.families.is_empty() {
            return Err(NoFactors::NoPotential);
        }
        // A count of as many negative pivots as there are factors also says that the state is stable.
        let again = near.filter(|near| near.critical.len() >= wanted).and_then(|near| {
            let (limit, enough) = (problem.limit(near)?, Enough::Answer);
            let (found, complete) = problem.near(&near.critical, &near.grid, limit, Counted::All, enough)?;
            complete.then(|| Search { next: near.next, ..Search::of(found, wanted, true) })
        });
        let neutral = if again.is_some() { Vec::new() } else { self.neutral(&problem)? };
        problem.families.retain(|matrices| !neutral.contains(&matrices.family));
        if problem.families.is_empty() {
            return Err(NoFactors::Neutral);
        }
        let found = again.unwrap_or_else(|| problem.search(wanted));
        if found.found.is_empty() && !found.complete {
            return Err(NoFactors::NotFound);
        }
        let before = near.and_then(|near| problem.nearest(near, Enough::Answer)).filter(|found| found.1);
        let reversed = match before {
            Some((reversed, _)) => reversed,
            None => problem.reversed(found.found.first().map(|raw| raw.factor)),
        };
        Ok(self.finish(problem, found, reversed, neutral))
    }

    /// Families in which the state is neutral.
    ///
    /// # Errors
    /// Where it is unstable.
    fn neutral(&mut self, problem: &Problem) -> Result<Vec<Family>, NoFactors> {
        let factors: Vec<_> = problem.families.iter().map(Matrices::factor).collect();
        let negative = factors.iter().flatten().map(|factor| factor.negative).sum::<usize>();
        let system = &mut self.base.system;
        if negative > 0 && system.certain_negative() > 0 {
            return Err(NoFactors::Unstable(negative));
        }
        let is_neutral = |factor: &Option<&Factor>| factor.is_none_or(|factor| factor.negative > 0);
        let mut neutral: Vec<bool> = factors.iter().map(is_neutral).collect();
        if !neutral.contains(&true) && system.hidden_signs() > 0 {
            let softness = |matrices: &Matrices, factor: &Option<&Factor>| {
                factor.map_or(0.0, |factor| factor.softest(&matrices.operators.stiffness))
            };
            let softest = problem.families.iter().zip(&factors).map(|(matrices, factor)| softness(matrices, factor));
            let softest: Vec<f64> = softest.collect();
            let least = softest.iter().copied().fold(f64::INFINITY, f64::min);
            neutral = softest.iter().map(|own| *own == least).collect();
        }
        let neutral = problem.families.iter().zip(neutral).filter(|(_, neutral)| *neutral);
        Ok(neutral.map(|(matrices, _)| matrices.family).collect())
    }

    /// The factors on other elements than those that they are known on.
    fn again(mut self, near: &Near) -> Result<Buckling, NoFactors> {
        let problem = self.problem()?;
        let found = match near.critical.as_slice() {
            [] => None,
            starts => problem
                .at_of(near.amid(), starts)
                .and_then(|limit| problem.near(starts, &near.grid, limit, Counted::All, Enough::Compared)),
        };
        let found = match found {
            Some((found, complete)) => Search::of(found, near.wanted, complete),
            None if near.wanted == 0 => Search::of(Vec::new(), 0, true),
            None => problem.search(near.wanted),
        };
        let reversed = problem.nearest(near, Enough::Compared).map(|found| found.0);
        Ok(self.finish(problem, found, reversed.unwrap_or_default(), Vec::new()))
    }

    fn finish(mut self, problem: Problem, search: Search, reversed: Vec<Raw>, neutral: Vec<Family>) -> Buckling {
        let Search { found, beyond, next, complete } = search;
        let system = &self.base.system;
        let Problem { unknowns, grid, change, left_out, .. } = problem;
        let start = |raw: &Raw| {
            let shape = Shape::new(system, &unknowns, &raw.x);
            let motion = Motion::new(&unknowns, &raw.x, &shape);
            (Start { factor: raw.factor, family: raw.family, motion }, shape)
        };
        let (mut critical, mut starts) = (Vec::new(), Vec::new());
        for raw in &found {
            let (start, shape) = start(raw);
            let largest = shape.largest(system.size).value;
            let (factor, family, lacking) = (raw.factor, raw.family, lacks::lacking(system, &shape));
            let (rounding, shape) = (raw.rounding.max(change.error), shape.scaled(1.0 / largest));
            critical.push(Critical { factor, rounding, family, shape, lacking });
            starts.push(start);
        }
        starts.extend(beyond.iter().map(|raw| start(raw).0));
        let nearest = reversed.iter().max_by(|a, b| a.factor.total_cmp(&b.factor));
        let back = nearest.map(start);
        let of_reversed = |raw: &Raw| Reversed {
            factor: raw.factor,
            rounding: raw.rounding.max(change.error),
            lacking: back.as_ref().map_or([0.0; 2], |(_, shape)| lacks::lacking(system, shape)),
        };
        let reversed = nearest.map(of_reversed);
        let back: Vec<Start> = back.into_iter().map(|(start, _)| start).collect();
        Buckling {
            critical,
            reversed,
            place: place(&mut self.base.system),
            reach: self.base.reach,
            left_out,
            neutral,
            complete,
            unknowns: unknowns.size,
            raised: self.raised,
            near: Near {
                grid,
                wanted: found.len(),
                critical: starts,
                next,
                reversed: back,
                part: (change.error > EXACT).then_some(change.part),
            },
        }
    }
}
