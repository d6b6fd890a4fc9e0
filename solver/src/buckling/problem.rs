//! The factors of a ramp, sought in every family of motions: from nothing, or near those of other elements.
//!
//! Theory: docs/theory/stability.md, Eq. 7.6.

use std::cell::OnceCell;
use std::cmp::Ordering;

use super::change::Change;
use super::{Near, Start};
use crate::spectral::factor::{Analyzed, Factor};
use crate::spectral::operators::Operators;
use crate::spectral::pencil::{Pairs, Pencil};
use crate::spectral::prolong::Grid;
use crate::spectral::unknowns::{Family, Unknowns};

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
/// Part of the nearest factor that the beginning of a ramp is found on at most.
const SHORT: f64 = 1e-2;
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

/// A state and a ramp, ready for the search.
pub(super) struct Problem {
    pub(super) unknowns: Unknowns,
    pub(super) grid: Grid,
    pub(super) change: Change,
    pub(super) families: Vec<Matrices>,
    pub(super) left_out: Vec<Family>,
}

/// The matrices of one family of motions.
pub(super) struct Matrices {
    pub(super) family: Family,
    pub(super) numbers: Vec<Option<usize>>,
    pub(super) operators: Operators,
    /// −K′
    pub(super) softening: sprs::CsMat<f64>,
    /// Factors of K, once they are asked for.
    pub(super) factor: OnceCell<Option<Factor>>,
    pub(super) analyzed: Analyzed,
}

/// How many factors there are to be up to a limit for none to be missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Counted {
    /// Those that are looked for.
    All,
    /// None: the limit is this side of the one looked for.
    None,
}

/// A limit of factors, negative of the ramp the other way, with what K + limit K′ is factorized into in every family.
pub(super) struct Limit {
    pub(super) value: f64,
    /// Nothing of families that are not asked.
    pub(super) families: Vec<Option<Factor>>,
}

impl Limit {
    /// How many factors there are up to it.
    pub(super) fn count(&self) -> usize {
        self.families.iter().flatten().map(|factor| factor.negative).sum()
    }
}

/// To what a factor near that of other elements is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Enough {
    /// It is the answer.
    Answer,
    /// How far it is from that of the other elements is asked for.
    Compared,
}

/// A factor with the vector of its motion over all unknowns.
pub(super) struct Raw {
    pub(super) factor: f64,
    pub(super) rounding: f64,
    pub(super) family: Family,
    pub(super) x: Vec<f64>,
}

impl Matrices {
    fn pencil<'a>(&'a self, other: &'a sprs::CsMat<f64>, factor: Factor) -> Pencil<'a> {
        let Operators { stiffness, form, constraints, .. } = &self.operators;
        Pencil { factor, shift: 0.0, stiffness, form, other, constraints, analyzed: &self.analyzed, is_mass: false }
    }

    /// The factors of K + λ K′, which have as many negative pivots as there are factors of the ramp up to λ.
    fn factor_at(&self, limit: f64) -> Option<Factor> {
        self.analyzed.factor(&(&self.operators.stiffness - &self.softening.map(|entry| limit * entry)))
    }

    /// K without a shift; nothing where it is neutral.
    pub(super) fn factor(&self) -> Option<&Factor> {
        let factor = || self.analyzed.factor(&self.operators.stiffness).filter(|factor| factor.neutral == 0);
        self.factor.get_or_init(factor).as_ref()
    }

    /// What pairs are over all unknowns, of a ramp forwards or the other way.
    pub(super) fn raw(&self, pairs: Pairs, sign: f64) -> Vec<Raw> {
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
pub(super) struct Search {
    pub(super) found: Vec<Raw>,
    /// Those that follow, so near to the last and to each other that no count tells them apart.
    pub(super) beyond: Vec<Raw>,
    /// How many times the largest of all of these the next one is, if that is known.
    pub(super) next: Option<f64>,
    pub(super) complete: bool,
}

impl Search {
    /// The smallest of some factors.
    pub(super) fn of(mut found: Vec<Raw>, wanted: usize, complete: bool) -> Self {
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
    pub(super) fn near(
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
    pub(super) fn at(&self, value: f64) -> Option<Limit> {
        self.at_in(value, &|_| true)
    }

    /// The same in the families of some motions alone.
    pub(super) fn at_of(&self, value: f64, starts: &[Start]) -> Option<Limit> {
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
    pub(super) fn limit(&self, near: &Near) -> Option<Limit> {
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
    pub(super) fn nearest(&self, near: &Near, enough: Enough) -> Option<(Vec<Raw>, bool)> {
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
    pub(super) fn search(&self, wanted: usize) -> Search {
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
    pub(super) fn reversed(&self, first: Option<f64>) -> Vec<Raw> {
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

impl Near {
    /// This side of the next factor; nothing where it is too near the largest of these.
    pub(super) fn limit(&self) -> Option<f64> {
        let next = self.next.unwrap_or(1.0 + 2.0 * APART);
        (next > 1.0 + BARELY).then(|| self.largest() * next.sqrt().min(WITHIN))
    }

    /// A shift for factors that are compared: as near the largest as there is a gap, and off all of them.
    pub(super) fn amid(&self) -> f64 {
        let next = self.next.map(|next| next * self.largest());
        let factors: Vec<f64> = self.critical.iter().map(|start| start.factor).chain(next).collect();
        let gap = factors.windows(2).rev().find(|pair| pair[1] > (1.0 + APART) * pair[0]);
        gap.map_or_else(|| BEFORE * factors[0], |pair| (pair[0] * pair[1]).sqrt().min(WITHIN * pair[0]))
    }

    /// Part of a ramp that is short beside the nearest factor, either way.
    pub(super) fn short(&self) -> f64 {
        let factors = self.critical.iter().chain(&self.reversed).map(|start| start.factor.abs());
        SHORT * factors.fold(f64::INFINITY, f64::min)
    }

    /// The same, and no longer than what the beginning of the ramp was found on.
    pub(super) fn longest(&self) -> f64 {
        self.short().min(self.part.unwrap_or(f64::INFINITY))
    }

    pub(super) fn largest(&self) -> f64 {
        self.critical.iter().fold(0.0f64, |largest, start| largest.max(start.factor))
    }
}
