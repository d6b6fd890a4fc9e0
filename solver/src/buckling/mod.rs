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

mod lacks;
mod response;

use std::cell::OnceCell;
use std::cmp::Ordering;
use std::sync::Arc;

use pennate_elements::small::{V3, add, cross, norm, scale, sub};

use crate::base::{self, Base, Reach};
use crate::chain;
use crate::error::SolveError;
use crate::modes::{Found, Part, Place, place, split};
use crate::options::{Options, Progress};
use crate::packs;
use crate::spectral::factor::{Analyzed, Factor};
use crate::spectral::operators::{
    self, Assembled, Entries, Evaluated, Operators, element_columns, matrix, mirror, scatter, spring_change,
};
use crate::spectral::pencil::{self, Pairs, Pencil};
use crate::spectral::prolong::{Grid, Motion};
use crate::spectral::shape::Shape;
use crate::spectral::unknowns::{Family, Unknowns, end_curvature};
use crate::structure::{Step, Structure};
use crate::system::System;

/// Largest motion of a joint up to a critical factor, over the size of the network.
///
/// Muscles that contract freely get no stresses but by rounding, which has factors of 10⁷ and more: there the linear response
/// would be that many times as long as the network.
const FARTHEST: f64 = 1e6;
/// Factors of the ramp the other way are looked for up to so many times the first one.
const OTHER_WAY: f64 = 1e3;
/// Between two factors of other elements that are further apart than this part, a limit tells one side from the other on these;
const APART: f64 = 1e-2;
/// where a count confirms it, than this.
const BARELY: f64 = 1e-3;
/// Such a limit is so many times the lower one at most,
const WITHIN: f64 = 1.05;
/// or this part of the first one where there is no such gap.
const BEFORE: f64 = 0.9;
/// Part of the nearest factor that the beginning of a ramp is found on at most, and how often that is made shorter.
const SHORT: f64 = 1e-2;
const SHORTENED: usize = 3;
/// Part of a response that it may be out of proportion by rounding.
const EXACT: f64 = 1e-13;
/// Rounding of a factor that nothing is known of but that it is there.
const UNKNOWN: f64 = 1.0;
/// Limits that are tried at most before factors are searched for anew.
const TRIES: usize = 8;
/// Of the ramp the other way there is none nearer than this part of the one found again.
const NEARER: f64 = 1.0 - 1e-3;
/// Part of a factor that may be left where it is found near that of other elements.
const ANSWER: f64 = 1e-11;
/// or, beside what the response to the ramp is off by, this part of that.
const BESIDE: f64 = 0.1;
/// The same of one that is compared with that of other elements, of their difference.
const COMPARED: f64 = 1e-2;
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

/// K′ of the beginning of a ramp.
struct Change {
    /// Over all unknowns.
    entries: Entries,
    /// The inverse of the largest factor that is looked for.
    least: f64,
    /// Part of it that it may be off.
    error: f64,
    /// The part of the ramp that it was found on.
    part: f64,
}

/// A state and a ramp, ready for the search.
struct Problem {
    unknowns: Unknowns,
    grid: Grid,
    change: Change,
    families: Vec<Matrices>,
    left_out: Vec<Family>,
}

/// The matrices of one family of motions.
struct Matrices {
    family: Family,
    numbers: Vec<Option<usize>>,
    operators: Operators,
    /// −K′
    softening: sprs::CsMat<f64>,
    /// Factors of K, once they are asked for.
    factor: OnceCell<Option<Factor>>,
    analyzed: Analyzed,
}

/// How many factors there are to be up to a limit for none to be missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Counted {
    /// Those that are looked for.
    All,
    /// None: the limit is this side of the one looked for.
    None,
}

/// A limit of factors, negative of the ramp the other way, with what K + limit K′ is factorized into in every family.
struct Limit {
    value: f64,
    /// Nothing of families that are not asked.
    families: Vec<Option<Factor>>,
}

impl Limit {
    /// How many factors there are up to it.
    fn count(&self) -> usize {
        self.families.iter().flatten().map(|factor| factor.negative).sum()
    }
}

impl Near {
    /// This side of the next factor; nothing where it is too near the largest of these.
    fn limit(&self) -> Option<f64> {
        let next = self.next.unwrap_or(1.0 + 2.0 * APART);
        (next > 1.0 + BARELY).then(|| self.largest() * next.sqrt().min(WITHIN))
    }

    /// A shift for factors that are compared: as near the largest as there is a gap, and off all of them.
    fn amid(&self) -> f64 {
        let next = self.next.map(|next| next * self.largest());
        let factors: Vec<f64> = self.critical.iter().map(|start| start.factor).chain(next).collect();
        let gap = factors.windows(2).rev().find(|pair| pair[1] > (1.0 + APART) * pair[0]);
        gap.map_or_else(|| BEFORE * factors[0], |pair| (pair[0] * pair[1]).sqrt().min(WITHIN * pair[0]))
    }

    /// Part of a ramp that is short beside the nearest factor, either way.
    fn short(&self) -> f64 {
        let factors = self.critical.iter().chain(&self.reversed).map(|start| start.factor.abs());
        SHORT * factors.fold(f64::INFINITY, f64::min)
    }

    /// The same, and no longer than what the beginning of the ramp was found on.
    fn longest(&self) -> f64 {
        self.short().min(self.part.unwrap_or(f64::INFINITY))
    }

    fn largest(&self) -> f64 {
        self.critical.iter().fold(0.0f64, |largest, start| largest.max(start.factor))
    }
}

/// To what a factor near that of other elements is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Enough {
    /// It is the answer.
    Answer,
    /// How far it is from that of the other elements is asked for.
    Compared,
}

/// A factor with the vector of its motion over all unknowns.
struct Raw {
    factor: f64,
    rounding: f64,
    family: Family,
    x: Vec<f64>,
}

impl Matrices {
    fn pencil<'a>(&'a self, other: &'a sprs::CsMat<f64>, factor: Factor) -> Pencil<'a> {
        let Operators { stiffness, form, constraints, .. } = &self.operators;
        Pencil { factor, shift: 0.0, stiffness, form, other, constraints, analyzed: &self.analyzed }
    }

    /// The factors of K + λ K′, which have as many negative pivots as there are factors of the ramp up to λ.
    fn factor_at(&self, limit: f64) -> Option<Factor> {
        self.analyzed.factor(&(&self.operators.stiffness - &self.softening.map(|entry| limit * entry)))
    }

    /// K without a shift; nothing where it is neutral.
    fn factor(&self) -> Option<&Factor> {
        let factor = || self.analyzed.factor(&self.operators.stiffness).filter(|factor| factor.neutral == 0);
        self.factor.get_or_init(factor).as_ref()
    }

    /// What pairs are over all unknowns, of a ramp forwards or the other way.
    fn raw(&self, pairs: Pairs, sign: f64) -> Vec<Raw> {
        let full = |vector: &[f64]| self.numbers.iter().map(|number| number.map_or(0.0, |n| vector[n])).collect();
        let raw = |value: f64, rounding: f64, vector: &Vec<f64>| Raw {
            factor: sign / value,
            rounding,
            family: self.family,
            x: full(vector),
        };
        let found = pairs.values.iter().zip(&pairs.rounding).zip(&pairs.vectors);
        let found = found.map(|((value, rounding), vector)| raw(*value, *rounding, vector));
        let beyond = pairs.beyond.iter().filter(|(value, _)| *value > 0.0);
        found.chain(beyond.map(|(value, vector)| raw(*value, UNKNOWN, vector))).collect()
    }
}

/// The factors of all families by their size.
struct Search {
    found: Vec<Raw>,
    /// Those that follow, so near to the last and to each other that no count tells them apart.
    beyond: Vec<Raw>,
    /// How many times the largest of all of these the next one is, if that is known.
    next: Option<f64>,
    complete: bool,
}

impl Search {
    /// The smallest of some factors.
    fn of(mut found: Vec<Raw>, wanted: usize, complete: bool) -> Self {
        found.sort_by(|a, b| a.factor.total_cmp(&b.factor));
        let mut rest = found.split_off(wanted.min(found.len())).into_iter().peekable();
        let mut largest = found.last().map_or(0.0, |raw| raw.factor);
        let mut beyond: Vec<Raw> = Vec::new();
        while let Some(raw) = rest.next_if(|raw| raw.factor <= (1.0 + BARELY) * largest) {
            largest = raw.factor;
            beyond.push(raw);
        }
        Self { found, beyond, next: rest.next().map(|raw| raw.factor / largest), complete }
    }
}

impl Problem {
    /// Factors near those of other elements, and whether there are so many, `counted`, up to a limit; nothing where they are not
    /// found again.
    ///
    /// `enough` is how well the factors are wanted.
    fn near(
        &self,
        starts: &[Start],
        grid: &Grid,
        limit: Limit,
        counted: Counted,
        enough: Enough,
    ) -> Option<(Vec<Raw>, bool)> {
        let (mut found, mut complete) = (Vec::with_capacity(starts.len()), true);
        let Limit { value: limit, families } = limit;
        let sign = limit.signum();
        let answer = ANSWER.max(BESIDE * self.change.error);
        let is_answer = enough == Enough::Answer;
        for (matrices, factor) in self.families.iter().zip(families) {
            let Some(factor) = factor else { continue };
            let own: Vec<&Start> = starts.iter().filter(|start| start.family == matrices.family).collect();
            let expected = if counted == Counted::All { own.len() } else { 0 };
            complete &= factor.negative == expected && factor.neutral == 0;
            if own.is_empty() {
                continue;
            }
            if !complete && is_answer {
                return None;
            }
            let other = matrices.softening.map(|value| sign * value);
            let pencil = matrices.pencil(&other, factor);
            let motion = |start: &&Start| {
                let x = start.motion.onto(grid, &self.unknowns, &self.grid)?;
                let numbered = matrices.numbers.iter().zip(x);
                Some(numbered.filter_map(|(number, x)| number.map(|_| x)).collect())
            };
            let motions: Option<Vec<Vec<f64>>> = own.iter().map(motion).collect();
            let left = |k: usize, value: f64| match enough {
                Enough::Answer => answer,
                Enough::Compared => COMPARED * (value * own[k].factor.abs() - 1.0).abs() + answer,
            };
            let pairs = pencil.near(&motions?, &left)?;
            let are_within = expected == 0 || pairs.values.iter().all(|value| *value * limit.abs() >= 1.0);
            if pairs.values.iter().any(|value| *value <= 0.0) || (is_answer && !are_within) {
                return None;
            }
            found.extend(matrices.raw(pairs, sign));
        }
        Some((found, complete))
    }

    /// A limit in all families; nothing where a pivot vanishes.
    fn at(&self, value: f64) -> Option<Limit> {
        self.at_in(value, &|_| true)
    }

    /// The same in the families of some motions alone.
    fn at_of(&self, value: f64, starts: &[Start]) -> Option<Limit> {
        self.at_in(value, &|family| starts.iter().any(|start| start.family == family))
    }

    fn at_in(&self, value: f64, is_asked: &dyn Fn(Family) -> bool) -> Option<Limit> {
        let factor = |matrices: &Matrices| match is_asked(matrices.family) {
            true => matrices.factor_at(value).map(Some),
            false => Some(None),
        };
        Some(Limit { value, families: self.families.iter().map(factor).collect::<Option<_>>()? })
    }

    /// A limit up to which there are as many factors as are known of other elements.
    fn limit(&self, near: &Near) -> Option<Limit> {
        let (mut limit, mut below, mut above) = (near.limit()?, None, None);
        for _ in 0..TRIES {
            let at = self.at(limit)?;
            match at.count().cmp(&near.critical.len()) {
                Ordering::Equal => return Some(at),
                Ordering::Less => below = Some(limit),
                Ordering::Greater => above = Some(limit),
            }
            limit = match (below, above) {
                (Some(below), Some(above)) => f64::sqrt(below * above),
                (Some(below), None) => WITHIN * below,
                (None, above) => above.map_or(limit, |above| above / WITHIN),
            };
        }
        None
    }

    /// The nearest factor of the ramp the other way, as [`Self::near`], where one of other elements is known.
    fn nearest(&self, near: &Near, enough: Enough) -> Option<(Vec<Raw>, bool)> {
        let [known] = near.reversed.as_slice() else { return None };
        let mut limit = NEARER * known.factor;
        let at = |limit: Limit| self.near(&near.reversed, &near.grid, limit, Counted::None, enough);
        if enough == Enough::Compared {
            return at(self.at_of(limit, &near.reversed)?);
        }
        for _ in 0..TRIES {
            let known = self.at(limit)?;
            if known.count() == 0 {
                let found = at(known)?;
                // It may be farther than the limit.
                let nearer = NEARER * found.0.iter().fold(f64::NEG_INFINITY, |nearest, raw| nearest.max(raw.factor));
                let is_nearest = nearer >= limit || self.at(nearer)?.count() == 0;
                return is_nearest.then_some(found);
            }
            limit /= WITHIN;
        }
        None
    }

    /// The `wanted` smallest factors.
    fn search(&self, wanted: usize) -> Search {
        let (mut found, mut complete) = (Vec::new(), true);
        for matrices in &self.families {
            let Some(factor) = matrices.factor() else { continue };
            let pairs = matrices.pencil(&matrices.softening, factor.clone()).largest_above(self.change.least, wanted);
            complete &= pairs.complete;
            found.extend(matrices.raw(pairs, 1.0));
        }
        Search::of(found, wanted, complete)
    }

    /// Of every family the nearest factor of the ramp the other way, up to so many times the first factor.
    fn reversed(&self, first: Option<f64>) -> Vec<Raw> {
        let mut least = first.map_or(0.0, |first| 1.0 / (first * OTHER_WAY)).max(self.change.least);
        let mut found = Vec::new();
        for matrices in &self.families {
            let other = matrices.softening.map(|value| -value);
            let Some(factor) = matrices.factor() else { continue };
            let pairs = matrices.pencil(&other, factor.clone()).nearest(least);
            // Of another family only a nearer one is looked for.
            least = pairs.values.first().map_or(least, |value| least.max(*value));
            found.extend(matrices.raw(pairs, -1.0));
        }
        found
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

    /// K′; nothing where the state does not respond.
    fn change(&mut self, unknowns: &Unknowns, without_potential: &mut Vec<(usize, usize)>) -> Option<Change> {
        let response = self.response()?;
        let motion = response.motions.iter().fold(0.0f64, |most, m| most.max(norm([m[0], m[1], m[2]])));
        let system = &mut self.base.system;
        let least = motion / (FARTHEST * system.size);
        let mut entries = Entries::with_capacity(operators::entries(system));
        let mut forces = vec![[0.0; 6]; system.tangent.forces.len()];
        for member in 0..system.members.count() {
            let slot = &system.members.slots[member];
            let pack = &system.members.packs[slot.pack];
            for e in 0..pack.mesh().elements() {
                let state = chain::element(pack.as_ref(), slot.lane, e);
                let own = Evaluated::of(&state, &response.stressings[member][e], operators::Part::Rate);
                scatter(&own.stiffness, &element_columns(system, unknowns, member, e), &mut entries);
            }
            let ends = &response.ends[member];
            end_curvature(system, unknowns, member, ends, &mut |i, j, value| entries.push((i, j, value)));
            add_end_forces(system, member, ends, &mut forces);
        }
        let moved = |node: usize| -> V3<f64> {
            let link = &system.topology.links[node];
            let m = response.motions[link.joint];
            let lever = pennate_elements::rotation::turn(system.places.joints[link.joint].place.rotation, link.arm);
            add([m[0], m[1], m[2]], cross([m[3], m[4], m[5]], lever))
        };
        spring_change(system, &moved, &mut entries);

        // Loads on levers and followers, and constraints whose direction turns with the joint. Forces of springs on a
        // joint with such constraints are left out of the change of its reactions.
        let internal = system.tangent.forces.clone();
        let before = system.remainder();
        let loads = system.tangent.forces.clone();
        self.set(response.part);
        let system = &mut self.base.system;
        system.remainder();
        let total: Vec<[f64; 6]> = (0..internal.len())
            .map(|joint| {
                let change = add(sub(system.tangent.forces[joint], loads[joint]), scale(response.part, forces[joint]));
                add(internal[joint], change)
            })
            .collect();
        let (topology, joints) = (Arc::clone(&system.topology), system.places.joints.clone());
        system.pattern.equations.find_multipliers(&topology, &joints, &total, response.part);
        let after = system.remainder();
        without_potential.extend(system.tangent.without_potential());
        mirror(&after, 1.0 / response.part, &mut entries);
        mirror(&before, -1.0 / response.part, &mut entries);
        self.set(0.0);
        self.base.system.assemble(false);
        Some(Change { entries, least, error: response.error, part: response.part })
    }
}

/// Adds forces on the ends of a member to those of its joints.
fn add_end_forces(system: &System<6>, member: usize, ends: &[[f64; 6]; 2], forces: &mut [[f64; 6]]) {
    use crate::joints::EndKind;
    for (end, info) in system.end_info(member, ends).iter().enumerate() {
        let joint = system.topology.links[system.structure.members[member].nodes[end]].joint;
        let moment = if let EndKind::Free { .. } = info.kind { [0.0; 3] } else { info.moment };
        let moment = add(moment, cross(info.lever, info.force));
        for c in 0..3 {
            forces[joint][c] += info.force[c];
            forces[joint][3 + c] += moment[c];
        }
    }
}
