//! Whether small vibrations grow about a state whose loads have no potential.
//!
//! The tangent K + N has a part N that is not symmetric, of the nodes that such loads act on, so that its pivots do not tell.
//! Motions x e^(λ t) with (K + N) x = ω² M x and λ² = −ω² stay bounded where all ω² are real and positive. The state diverges
//! where one is real and negative, and flutters where two are complex: the network oscillates ever farther (Bolotin,
//! Nonconservative Problems of the Theory of Elastic Stability, 1963). Nothing damps it here.
//!
//! N is of low rank. The lowest ω² are those of a space of motions: modes of the symmetric part, and what it yields to under
//! forces where N has some, static and with the inertia of that. A smaller space of the same kind tells how near they are.
//!
//! Theory: docs/theory/stability.md, Eq. 7.7.

use faer::Mat;
use sprs::CsMat;

use crate::base::{Base, Reach};
use crate::continuation::mesh_size;
use crate::history::{Growth, Vibration};
use crate::modes::Shifted;
use crate::packs::HIGHEST;
use crate::spectral::eigen;
use crate::spectral::factor::Analyzed;
use crate::spectral::operators::{Assembled, Form, dot, matrix, multiply};
use crate::spectral::pencil::Pencil;
use crate::spectral::unknowns::{Family, Unknowns};
use crate::structure::Structure;
use crate::system::System;

/// Unknowns of a mesh up to which vibrations are looked at: those of 5,000 take two seconds.
const MOST: usize = 5000;
/// By how much the orders of elements are raised; those beyond the highest are that.
const RAISED: usize = 4;
/// Modes of the symmetric part in the space, and in the smaller one.
const MODES: [usize; 2] = [32, 20];
/// Responses to a force: the static one, and so many times the one to the inertia of the last.
const RESPONSES: usize = 3;
/// Lowest frequencies that are judged among those that the unsymmetric part moves, and how many of them have to be known. Those of members
/// that such loads do not reach, however many lie lower, are judged too and take no place of these.
const JUDGED: usize = 10;
const LEAST: usize = 4;
/// Energy, over that of a motion of length one, below which a combination of the motions is rounding.
const DEPENDENT: f64 = 1e-11;
/// What is left of the energy one of a motion that has nothing beside others but rounding.
const NOTHING: f64 = 1e-10;
/// Part by which 1/ω² may differ between both spaces for it to be known.
const KNOWN: f64 = 1e-3;
/// Part of the largest 1/ω² below which one is that of a motion without mass, or of one that is looked at with another shift.
const MASSLESS: f64 = 1e-9;
/// How many times the first 1/ω² below that the largest is made by a shift, where there is any.
const NEXT: f64 = 1e3;
/// Part of the largest 1/ω² that rounding may make of any.
const ROUNDING: f64 = 1e-12;
/// Part by which rounding splits two equal ones into a complex pair, or moves one.
const EQUAL: f64 = 1e-7;
/// Share of the unsymmetric part in a motion, over the largest, from which on it is reached.
const REACHED: f64 = 1e-3;
/// What differs from zero by so many times its error does so.
const CLEAR: f64 = 10.0;
/// ω² over the shift of the symmetric part that is rounding of zero.
const ZERO: f64 = 1e-9;

/// All mass of a structure, where it is known: every member has one, or bodies have and members have none at all.
pub(crate) fn known_mass(structure: &Structure) -> Option<f64> {
    let bodies: f64 = structure.bodies.iter().map(|body| body.mass).sum();
    let mut members = 0.0;
    let mut missing = false;
    for segment in structure.members.iter().flat_map(|member| &member.segments) {
        let own = structure.laws[segment.law].at(0.0).section.mass_per_length;
        missing |= !(own > 0.0);
        members += own * segment.length;
    }
    let known = if missing { members == 0.0 && bodies > 0.0 } else { members > 0.0 };
    known.then_some(members + bodies)
}

/// Whether vibrations about a state are looked at: masses are known, and unknowns not too many.
pub(crate) fn may_judge<const D: usize>(system: &System<D>) -> bool {
    known_mass(&system.structure).is_some() && mesh_size(system).unknowns <= MOST
}

/// What the vibrations about a state do; nothing where that cannot be said.
///
/// `state` gives the state on elements of an order higher by so much. A mesh that is fine enough for an equilibrium may be too
/// coarse for its vibrations: they are those of the highest order, and those of a lower one must do the same.
pub(crate) fn judge(structure: &Structure, state: &dyn Fn(usize) -> Option<Base>) -> Option<Vibration> {
    let highest = structure.members.iter().map(|member| member.order).max().unwrap_or(1);
    // Raised by one, elements of the order below the highest would be those of the highest: they tell the error as they are, and are
    // not fine enough to be asked for the verdict.
    let is_below = highest + 1 >= HIGHEST;
    let [coarse, fine] = [usize::from(!is_below), RAISED].map(|enrich| state(enrich).and_then(about));
    let (fine, kind) = (fine?, |growth: &Growth| std::mem::discriminant(growth));
    let coarse = coarse.map(|coarse| coarse.growth);
    if !is_below && coarse.as_ref().map(kind) != Some(kind(&fine.growth)) {
        return None;
    }
    let [rate, frequency] = parts(&fine.growth);
    let size = rate.hypot(frequency);
    let apart = coarse.map_or(size, |coarse| {
        let [other_rate, other_frequency] = parts(&coarse);
        (rate - other_rate).hypot(frequency - other_frequency)
    });
    let error = if size > 0.0 { fine.error + apart / size } else { 0.0 };
    Some(Vibration { error, ..fine })
}

/// Rate and angular frequency of what grows.
fn parts(growth: &Growth) -> [f64; 2] {
    match *growth {
        Growth::None => [0.0; 2],
        Growth::Divergence { rate } => [rate, 0.0],
        Growth::Flutter { frequency, rate } => [rate, frequency],
    }
}

fn about(mut base: Base) -> Option<Vibration> {
    let mass = known_mass(&base.system.structure)?;
    let unknowns = Unknowns::new(&base.system);
    let assembled = Assembled::new(&mut base.system, &unknowns);
    let family = if base.reach == Reach::InPlane { Family::InPlane } else { Family::Space };
    let numbers = unknowns.of_family(&base.system, family)?;
    let operators = assembled.of_family(&numbers);
    let skew = matrix(&base.system.tangent.skew_part(), &numbers);
    let Shifted { shift, stiffness, form, constraints, factor } = Shifted::of(&operators)?;
    let pencil = Pencil {
        factor,
        shift: 0.0,
        stiffness: &stiffness,
        form: &form,
        other: &operators.mass,
        constraints: &constraints,
        analyzed: &Analyzed::default(),
        is_mass: true,
    };
    let modes = pencil.largest(MODES[0]);
    let responses = responses(&pencil, &skew);
    let mut fastest = (Growth::None, 0.0);
    let mut moved = 0;
    for more in shifts(&modes.values) {
        let heavy = modes.values.iter().take_while(|value| more * **value > 1.0).count();
        let responses = without(&modes.vectors[..heavy], &responses, pencil.form);
        let [larger, smaller] = MODES.map(|count| {
            let motions: Vec<Vec<f64>> = modes.vectors.iter().take(count).chain(&responses).cloned().collect();
            inverse_squares(&pencil, &skew, &motions, more)
        });
        let found = growth(&larger?, &smaller?.values, shift + more, &mut moved)?;
        if parts(&found.0)[0] > parts(&fastest.0)[0] {
            fastest = found;
        } else if fastest.0 == Growth::None {
            fastest.1 = fastest.1.max(found.1);
        }
        if moved >= JUDGED {
            break;
        }
    }
    let (growth, error) = fastest;
    Some(Vibration { mass, growth, error })
}

/// What motions have beside modes of energy one, which are so heavy that little of them would be large beside the rest.
fn without(modes: &[Vec<f64>], motions: &[Vec<f64>], form: &Form) -> Vec<Vec<f64>> {
    let images: Vec<Vec<f64>> = modes.iter().map(|mode| form.image(mode)).collect();
    let mut left = motions.to_vec();
    for motion in &mut left {
        // Twice is enough (Kahan and Parlett).
        for (mode, image) in modes.iter().zip(&images).chain(modes.iter().zip(&images)) {
            let part = dot(image, motion);
            motion.iter_mut().zip(mode).for_each(|(x, mode)| *x -= part * mode);
        }
    }
    left.retain(|motion| form.energy(motion) > NOTHING);
    left
}

/// What is added to the shift for each scale of frequencies: nothing for the lowest ones, and where others lie so far above these that the
/// lowest leave them no digits, as much as makes the lowest ones no larger than a thousand times theirs.
fn shifts(values: &[f64]) -> Vec<f64> {
    let mut shifts = vec![0.0];
    let mut largest = values.first().copied().unwrap_or(0.0);
    for &value in values {
        if value <= MASSLESS * largest {
            largest = NEXT * value;
            shifts.push(1.0 / largest);
        }
    }
    shifts
}

/// What the network yields to under forces where the unsymmetric part has some.
fn responses(pencil: &Pencil<'_>, skew: &CsMat<f64>) -> Vec<Vec<f64>> {
    let size = skew.rows();
    let forced = (0..size).filter(|&row| skew.outer_view(row).is_some_and(|row| row.nnz() > 0));
    let mut found = Vec::new();
    for unknown in forced {
        let mut force = vec![0.0; size];
        force[unknown] = 1.0;
        for _ in 0..RESPONSES {
            let motion = pencil.response(&force);
            let energy = dot(&motion, &force).abs();
            if !(energy > 0.0) {
                break;
            }
            multiply(pencil.other, &motion, &mut force);
            let unit = 1.0 / energy.sqrt();
            found.push(motion.iter().map(|x| unit * x).collect());
            force.iter_mut().for_each(|x| *x *= unit);
        }
    }
    found
}

/// 1/(ω² + s) in a space of motions, s the shift of the pencil's stiffness.
struct InverseSquares {
    /// Real and imaginary parts by falling size.
    values: Vec<[f64; 2]>,
    /// Those of the symmetric part alone, and whether the unsymmetric part reaches their motions.
    symmetric: Vec<(f64, bool)>,
}

impl InverseSquares {
    /// Whether the unsymmetric part moves a value, or would move it if it were larger.
    fn moves(&self, [real, imaginary]: [f64; 2]) -> bool {
        let from = |&(other, reached): &(f64, bool)| ((real - other).hypot(imaginary), reached);
        let rounding = EQUAL * real.hypot(imaginary) + CLEAR * ROUNDING * self.largest();
        let nearest = self.symmetric.iter().map(from).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.is_none_or(|(distance, reached)| reached || distance > rounding)
    }

    fn largest(&self) -> f64 {
        self.values.first().map_or(0.0, size_of)
    }
}

/// The same for `more` of a shift.
fn inverse_squares(pencil: &Pencil<'_>, skew: &CsMat<f64>, motions: &[Vec<f64>], more: f64) -> Option<InverseSquares> {
    let size = motions.len();
    let products = |operator: &CsMat<f64>| {
        let mut image = vec![0.0; operator.rows()];
        let mut products = nalgebra::DMatrix::zeros(size, size);
        for (j, motion) in motions.iter().enumerate() {
            multiply(operator, motion, &mut image);
            for (i, left) in motions.iter().enumerate() {
                products[(i, j)] = dot(left, &image);
            }
        }
        products
    };
    let (mass, skew) = (products(pencil.other), products(skew));
    let mut energy = pencil.form.products(motions);
    for (i, row) in energy.iter_mut().enumerate() {
        row.iter_mut().enumerate().for_each(|(j, energy)| *energy += more * mass[(i, j)]);
    }
    let lengths: Vec<f64> = (0..size).map(|i| energy[i][i].sqrt()).collect();
    if lengths.iter().any(|length| !(*length > 0.0)) {
        return None;
    }
    let scaled = |i: usize, j: usize| energy[i.max(j)][i.min(j)] / (lengths[i] * lengths[j]);
    let (levels, turns) = eigen::symmetric(Mat::from_fn(size, size, scaled).as_ref())?;
    let kept: Vec<usize> = (0..size).filter(|&k| levels[k] > DEPENDENT).collect();
    // Combinations of energy one, and both forms in them.
    let weights = nalgebra::DMatrix::from_fn(size, kept.len(), |i, k| {
        turns[(i, kept[k])] / (levels[kept[k]].sqrt() * lengths[i])
    });
    let [mass, skew] = [mass, skew].map(|products| weights.transpose() * products * &weights);
    let tangent = nalgebra::DMatrix::identity(kept.len(), kept.len()) + &skew;
    let inverse = tangent.lu().solve(&mass)?;
    let size = kept.len();
    if !inverse.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    // Equal frequencies, of members that are alike, are no rarity: the iteration of some libraries has no end there.
    let found = Mat::from_fn(size, size, |i, j| inverse[(i, j)]).eigenvalues().ok()?;
    let mut values: Vec<[f64; 2]> = found.iter().map(|value| [value.re, value.im]).collect();
    values.sort_by(|a, b| size_of(b).total_cmp(&size_of(a)));
    let (symmetric, turns) = eigen::symmetric(Mat::from_fn(size, size, |i, j| mass[(i, j)]).as_ref())?;
    let reached = reached(&skew, &nalgebra::DMatrix::from_fn(size, size, |i, k| turns[(i, k)]));
    Some(InverseSquares { values, symmetric: symmetric.into_iter().zip(reached).collect() })
}

/// Which motions of energy one, columns of `modes`, the unsymmetric part has a share in that is not small beside the largest: a weak one moves
/// no value by more than its square.
fn reached(skew: &nalgebra::DMatrix<f64>, modes: &nalgebra::DMatrix<f64>) -> Vec<bool> {
    let couplings = modes.transpose() * skew * modes;
    let share = |k: usize| couplings.row(k).norm().hypot(couplings.column(k).norm());
    let shares: Vec<f64> = (0..couplings.nrows()).map(share).collect();
    let largest = shares.iter().copied().fold(0.0, f64::max);
    shares.into_iter().map(|share| share > REACHED * largest).collect()
}

fn size_of(value: &[f64; 2]) -> f64 {
    value[0].hypot(value[1])
}

/// The fastest growth among the lowest frequencies, those known from both spaces; nothing where none is. So many that the unsymmetric
/// part moves have been judged already, and are then.
fn growth(squares: &InverseSquares, smaller: &[[f64; 2]], shift: f64, moved: &mut usize) -> Option<(Growth, f64)> {
    let mut found: Option<(Growth, f64)> = None;
    let mut fastest = 0.0;
    let largest = squares.largest();
    for value in &squares.values {
        let size = size_of(value);
        if size <= MASSLESS * largest {
            break;
        }
        let apart = |other: &[f64; 2]| size_of(&[value[0] - other[0], value[1] - other[1]]);
        let error = smaller.iter().map(apart).fold(f64::INFINITY, f64::min) + ROUNDING * largest;
        let moves = squares.moves(*value);
        if !(error <= KNOWN * size) {
            match moves {
                // It is that of a mode of the symmetric part, which is stiffer than all that are known.
                false => continue,
                // What grows does so whatever else there is.
                true if *moved < LEAST && fastest == 0.0 => return None,
                true => break,
            }
        }
        if moves && *moved == JUDGED {
            break;
        }
        *moved += usize::from(moves);
        found.get_or_insert((Growth::None, 0.0));
        // ω² = 1/μ − s
        let (real, imaginary) = (value[0] / (size * size) - shift, -value[1] / (size * size));
        // The error of the root of ω², over the root.
        let of_root = |square: f64| 0.5 * error / (size * size * square);
        if value[1].abs() > CLEAR * error + EQUAL * size {
            // The root of −ω² with a positive real part.
            let length = real.hypot(imaginary);
            let rate = (0.5 * (length - real)).max(0.0).sqrt();
            let frequency = (0.5 * (length + real)).max(0.0).sqrt();
            if rate > fastest {
                fastest = rate;
                found = Some((Growth::Flutter { frequency, rate }, of_root(length)));
            }
        } else if value[1].abs() > CLEAR * ROUNDING * largest + EQUAL * size {
            // Complex by less than the spaces differ: it may be one or the other.
            return None;
        } else if real < -ZERO * shift - CLEAR * error / (size * size) && (-real).sqrt() > fastest {
            fastest = (-real).sqrt();
            found = Some((Growth::Divergence { rate: fastest }, of_root(-real)));
        }
    }
    found
}
