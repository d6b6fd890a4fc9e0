//! What the modes on a mesh and on elements of the next order say: values and their errors.

use pennate_models::Mesh;
use pennate_solver::base::Reach;
use pennate_solver::buckling::{Buckling, Critical, Near, Ramp};
use pennate_solver::modes::{Modes, Place};
use pennate_solver::spectral::unknowns::Family;
use pennate_solver::structure::{Dimension, Stability, Structure};

use super::{Entry, Note, Reversed};
use crate::accuracy::refine::multiplied;
use crate::solution::diagonal;

/// A vibration's eigenvalue counts as no smaller than this part of what it is the difference of, when errors are judged.
const SMALLEST: f64 = 1e-9;
/// Part of the difference of two orders that is left of it on the higher one, at least, where one value tells: two orders may agree
/// by chance, of several values so many times less. On a dyad of eight elements a sixth is left of the first factor, where the
/// ratio of the differences foresees a hundredth.
const LEFT: f64 = 0.15;
/// Part of the largest difference of any value on the two lower orders below which one of them is chance.
const CHANCE: f64 = 1e-2;
/// How many times what the motions of the highest order say of the difference to the lowest one it may be for these to tell how fast
/// differences fall: what is beyond comes from the state and its response. Of differences smaller than this part of the largest one
/// nothing is asked.
const EXPLAINED: f64 = 3.0;
const ASKED: f64 = 0.1;
/// An error by two orders that is so many times too large is not looked at with a third one.
const FAR_OFF: f64 = 2.0;
/// Errors below this show rounding, of which two orders or two meshes may show too little.
const SHOWN: f64 = 1e-8;

/// The modes of the higher order, with the errors of those on the mesh itself.
#[derive(Debug)]
pub(super) struct Values {
    pub entries: Vec<Entry>,
    pub reversed: Option<Reversed>,
    pub place: Place,
    pub notes: Vec<Note>,
    pub unknowns: usize,
    /// By how much the order of the elements whose error is known is higher than that of the mesh.
    pub raised: usize,
    /// Part of that error which is expected to be the one asked for.
    pub left: f64,
    /// Of buckling: the largest part of a factor that rounding may be, and what the response to the ramp is known to.
    pub rounding: f64,
    /// Of buckling: where the motions are on other elements.
    pub near: Near,
    /// Of buckling: factors on the highest order, and the one of the ramp the other way.
    known: [Known; 2],
}

impl Default for Values {
    fn default() -> Self {
        Self {
            entries: Vec::new(),
            reversed: None,
            place: Place::default(),
            notes: Vec::new(),
            unknowns: 0,
            raised: 0,
            left: 1.0,
            rounding: 0.0,
            near: Near::default(),
            known: Default::default(),
        }
    }
}

impl Values {
    pub(super) fn of_modes(structure: &Structure, [coarse, fine]: [Modes; 2]) -> Self {
        let size = diagonal(structure.nodes.iter().copied());
        let mut coarse_values = coarse.modes.iter().map(|mode| mode.eigenvalue);
        let entries: Vec<Entry> = fine
            .modes
            .into_iter()
            .map(|mode| {
                let value = mode.eigenvalue;
                // The frequency is the root: half the relative error of its square.
                let relative = |coarse: f64| 0.5 * (coarse - value).abs() / value.abs().max(SMALLEST * mode.parts);
                let error = coarse_values.next().map(|coarse| {
                    // One without stiffness is exactly zero.
                    if value == 0.0 && coarse == 0.0 {
                        return 0.0;
                    }
                    relative(coarse).max(0.5 * mode.rounding).max(f64::EPSILON)
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
        Self { entries, reversed: None, place: fine.place, notes, unknowns: fine.unknowns, ..Self::default() }
    }

    pub(super) fn of_buckling(structure: &Structure, judged: &Judged<'_>, mut levels: Vec<Buckling>) -> Self {
        let ramp = judged.ramp;
        let Errors { errors, raised, left } = judged.errors(&levels.iter().map(Known::of).collect::<Vec<_>>(), 0);
        let back: Vec<Known> = levels.iter().map(Known::reversed).collect();
        let is_known = back.iter().all(|known| !known.factors.is_empty());
        let back = if is_known { judged.errors(&back, 1).errors.pop() } else { None };
        let Some(fine) = levels.pop() else { return Self::default() };
        let known = [Known::of(&fine), Known::reversed(&fine)];
        let mut errors = errors.into_iter();
        let size = diagonal(structure.nodes.iter().copied());
        let present = present(ramp);
        let none = fine.critical.is_empty();
        let rounding = fine.critical.iter().map(|critical| critical.rounding).fold(0.0, f64::max);
        let entries = fine
            .critical
            .into_iter()
            .map(|critical| {
                let value = critical.factor + present;
                let error = errors.next().map(|error| (error / value).max(critical.rounding));
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
        let reversed = fine.reversed.map(|reversed| {
            let value = reversed.factor + present;
            Reversed { value, error: back.map(|error| (error / value.abs()).max(reversed.rounding)) }
        });
        Self {
            entries,
            reversed,
            place: fine.place,
            notes,
            unknowns: fine.unknowns,
            raised,
            left,
            rounding,
            near: fine.near,
            known,
        }
    }
}

/// Factors on elements of one order.
#[derive(Clone, Debug, Default)]
pub(super) struct Known {
    factors: Vec<f64>,
    /// By how much they are larger on elements of one order less, as far as motions tell, and by how much more on those of two.
    lacking: Vec<[f64; 2]>,
    /// By how much the order is higher than that of the mesh.
    raised: usize,
}

impl Known {
    fn of(level: &Buckling) -> Self {
        let lacking = |critical: &Critical| critical.lacking.map(|part| part * critical.factor);
        Self {
            factors: level.critical.iter().map(|critical| critical.factor).collect(),
            lacking: level.critical.iter().map(lacking).collect(),
            raised: level.raised,
        }
    }

    /// The nearest one of the ramp the other way, where there is any.
    fn reversed(level: &Buckling) -> Self {
        let reversed = level.reversed.iter();
        Self {
            factors: reversed.clone().map(|reversed| reversed.factor).collect(),
            lacking: reversed.map(|reversed| reversed.lacking.map(|part| part * reversed.factor.abs())).collect(),
            raised: level.raised,
        }
    }

    fn apart(&self, other: &Self) -> Vec<f64> {
        self.factors.iter().zip(&other.factors).map(|(a, b)| (a - b).abs()).collect()
    }

    /// The largest part of any factor.
    fn largest(&self, parts: &[f64]) -> f64 {
        parts.iter().zip(&self.factors).map(|(part, factor)| part / factor.abs()).fold(0.0, f64::max)
    }

    /// The part of differences that is left of them at least.
    fn least(&self) -> f64 {
        LEFT / self.factors.len().max(1) as f64
    }

    /// The largest ratio of what motions lack on one order less to what they lack on the one below that, of values that count.
    fn fall(&self, counts: &dyn Fn(usize) -> bool) -> f64 {
        let counted = self.lacking.iter().enumerate().filter(|(k, lacking)| counts(*k) && lacking[1] > 0.0);
        counted.map(|(_, lacking)| lacking[0] / lacking[1]).fold(0.0, f64::max)
    }

    /// The largest part of what its motions lack on two orders that those of other elements lack, of values that count.
    fn fall_to(&self, other: &Self, counts: &dyn Fn(usize) -> bool) -> f64 {
        let sum = |lacking: &[f64; 2]| lacking[0] + lacking[1];
        let pairs = self.lacking.iter().zip(&other.lacking).enumerate();
        let counted = pairs.filter(|(k, (own, _))| counts(*k) && sum(own) > 0.0);
        counted.map(|(_, (own, other))| sum(other) / sum(own)).fold(0.0, f64::max)
    }
}

/// Factors on a mesh before, with elements so many times as long everywhere.
struct Before<'a> {
    known: &'a [Known; 2],
    times: f64,
}

/// What errors of factors on a mesh are judged by.
pub(super) struct Judged<'a> {
    ramp: Ramp,
    /// The order of the mesh.
    order: usize,
    accuracy: f64,
    before: Option<Before<'a>>,
    /// Whether this is the first mesh.
    is_first: bool,
    /// Whether a finer mesh may follow: where it does anyway, no error of this one is stated.
    may_follow: bool,
}

impl<'a> Judged<'a> {
    /// `before` is what is known of another mesh.
    pub(super) fn new(
        ramp: Ramp,
        accuracy: f64,
        (mesh, order): (&Mesh, usize),
        before: Option<(&'a Values, &Mesh)>,
        may_follow: bool,
    ) -> Self {
        let is_first = before.is_none();
        let before = before.and_then(|(values, other)| {
            let times = multiplied(mesh, other).filter(|_| other.order == mesh.order)?;
            Some(Before { known: &values.known, times: times as f64 })
        });
        Self { ramp, order, accuracy, before, is_first, may_follow }
    }

    /// Whether factors on some orders, the highest one first, say enough: that they are as near as asked for, or, whatever those of
    /// other orders are, that they are not.
    pub(super) fn is_enough(&self, levels: &[Buckling]) -> bool {
        let known: Vec<Known> = levels.iter().map(Known::of).collect();
        let worst = |errors: &[f64]| {
            let relative = errors.iter().zip(&known[0].factors);
            relative.map(|(error, factor)| (error / (factor + present(self.ramp))).abs()).fold(0.0, f64::max)
        };
        match known.as_slice() {
            // Of one order the motions say how far those of the order below would be. That is no bound, and no error that is stated: a
            // finer mesh follows.
            [high] => {
                let lacking: Vec<f64> = high.lacking.iter().map(|lacking| lacking[0]).collect();
                let is_off = high.largest(&lacking) * high.least() / (1.0 - high.least()) > self.accuracy;
                let errors = self.by_meshes(high, 0);
                self.may_follow && is_off && self.is_first
                    || errors.is_some_and(|errors| worst(&errors) <= self.accuracy)
            }
            [high, low] => {
                let (errors, is_explained) = self.by_orders(low, high);
                let worst = worst(&errors);
                is_explained && (worst <= self.accuracy || self.may_follow && worst > FAR_OFF * self.accuracy)
            }
            _ => false,
        }
    }

    /// Errors of the highest of some orders of elements, or of the one below; of the ramp forwards, or of the other way.
    fn errors(&self, levels: &[Known], way: usize) -> Errors {
        match levels {
            [low, middle, high] => {
                let errors = left_over(&low.apart(middle), &middle.apart(high), &high.factors, self.order);
                Errors { errors, raised: high.raised, left: 1.0 }
            }
            [low, high] if high.raised == low.raised + 2 => {
                let (errors, is_explained) = self.by_orders(low, high);
                let most =
                    |(error, apart): (&f64, &f64)| if is_explained { *error } else { error.max(LEFT * LEFT * apart) };
                let errors = errors.iter().zip(&low.apart(high)).map(most).collect();
                Errors { errors, raised: high.raised, left: 1.0 }
            }
            [low, high] => Errors { errors: low.apart(high), raised: low.raised, left: 1.0 },
            [only] => match self.by_meshes(only, way) {
                Some(errors) => Errors { errors, raised: only.raised, left: 1.0 },
                None if only.raised == 0 => Errors::none(),
                None if way == 1 => Errors::none(),
                None => {
                    let errors = only.lacking.iter().map(|lacking| lacking[0]).collect();
                    Errors { errors, raised: only.raised - 1, left: LEFT }
                }
            },
            _ => Errors::none(),
        }
    }

    /// Errors of the highest of two orders with one between them, and whether motions explain how far they are apart.
    ///
    /// What motions of the highest order lack on the order between, beside what more they lack on the lower one, is the ratio by which
    /// differences fall: what is left is as of three orders, see [`left_over`]. Of motions that are symmetric about the middle of their
    /// elements every second part is nothing, so that the ratio is no less than what the sums of two parts, of either order, say of it.
    fn by_orders(&self, low: &Known, high: &Known) -> (Vec<f64>, bool) {
        let apart = low.apart(high);
        let part = |k: usize| apart[k] / high.factors[k].abs();
        let largest = high.largest(&apart);
        let explained = |(k, lacking): (usize, &[f64; 2])| {
            part(k) < ASKED * largest || apart[k] <= EXPLAINED * (lacking[0] + lacking[1])
        };
        let is_explained = self.accuracy >= SHOWN
            && apart.len() == high.factors.len()
            && high.lacking.iter().enumerate().all(explained);
        // Errors fall from an order p to the next with one over this (Ainsworth, see `left_over`).
        let by_order = |p: usize| ((2 * p + 1) * (2 * p + 3)) as f64;
        let lowest = self.order + low.raised;
        let next = match lowest.checked_sub(2) {
            Some(first) => (by_order(first) * by_order(first + 1)).sqrt() / by_order(lowest),
            None => 1.0,
        };
        let counts = |k: usize| k < apart.len() && part(k) > CHANCE * largest;
        let ratio = high.fall(&counts).max(next * low.fall_to(high, &counts).sqrt());
        let left = left_of(ratio, self.order, high.least());
        let error = |(apart, lacking): (&f64, &[f64; 2])| left * (ratio * apart).max(lacking[0]);
        (apart.iter().zip(&high.lacking).map(error).collect(), is_explained)
    }

    /// Errors by what the same order is off by on the mesh before; nothing where that is not known.
    ///
    /// They fall with elements of order p by h²ᵖ in the end, and by less while these are long beside the waves of a motion: taken is
    /// h²ᵖ⁻², or h³ beside what motions lack on the two orders below, whose error falls by h²ᵖ⁻⁴ in the end, where that is less. As on three
    /// orders, a part of what these lack is left at least.
    fn by_meshes(&self, now: &Known, way: usize) -> Option<Vec<f64>> {
        let Before { known, times } = self.before.as_ref()?;
        let before = &known[way];
        let is_known = before.raised == now.raised && before.factors.len() == now.factors.len();
        if !is_known || now.factors.is_empty() || self.accuracy < SHOWN {
            return None;
        }
        let order = self.order + now.raised;
        let rate = times.powi(2 - 2 * order as i32).max(before.fall_to(now, &|_| true) * times.powi(-3));
        let error = |(apart, lacking): (&f64, &[f64; 2])| (rate * apart).max(now.least() * lacking[0]);
        Some(before.apart(now).iter().zip(&now.lacking).map(error).collect())
    }
}

/// Of loads that are present once a factor counts from nothing: what is to be added to that of a ramp.
fn present(ramp: Ramp) -> f64 {
    if let Ramp::Present(_) = ramp { 1.0 } else { 0.0 }
}

/// Errors of the factors.
struct Errors {
    errors: Vec<f64>,
    /// By how much the order of the elements that they are those of is higher than that of the mesh.
    raised: usize,
    /// Part of them that is expected to be those of the highest order.
    left: f64,
}

impl Errors {
    fn none() -> Self {
        Self { errors: Vec::new(), raised: 0, left: 1.0 }
    }
}

/// The part of the last difference between orders that is left on the highest of three, of which the lowest is `order`, where
/// differences fall by a ratio, and no less than so much of the next one.
fn left_of(ratio: f64, order: usize, least: f64) -> f64 {
    let order = (order + 1) as f64;
    let next = (ratio * (2.0 * order - 1.0) / (2.0 * order + 3.0)).max(least);
    // Differences that do not fall by half say nothing of what follows.
    if next < 0.5 { next / (1.0 - next) } else { 1.0 }
}

/// What is left of differences on the highest of three orders of elements, of which the lowest is `order`.
///
/// They fall by a ratio r from one order to the next, and that falls by (2P − 1)/(2P + 3) about the order P between them (M.
/// Ainsworth, SIAM J. Numer. Anal. 42, 2004, 553), so that the highest one is off by the last difference times q/(1 − q), with q the
/// next ratio. The ratio is the largest of any value.
fn left_over(first: &[f64], last: &[f64], values: &[f64], order: usize) -> Vec<f64> {
    let relative = |apart: &[f64]| apart.iter().zip(values).map(|(d, v)| d / v.abs()).fold(0.0, f64::max);
    let counted = CHANCE * relative(first);
    let ratios = first.iter().zip(last).zip(values).filter(|((first, _), value)| **first > counted * value.abs());
    let ratio = ratios.map(|((first, last), _)| last / first).fold(0.0, f64::max);
    let left = left_of(ratio, order, LEFT / values.len() as f64);
    // Those of one value that do not, where those of others do, are its rounding.
    let error = |(first, last): (&f64, &f64)| if *last > 0.5 * first { last.max(*first) } else { left * last };
    first.iter().zip(last).map(error).collect()
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
