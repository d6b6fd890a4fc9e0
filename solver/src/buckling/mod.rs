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

mod response;

use std::sync::Arc;

use pennate_elements::small::{V3, add, cross, norm, scale, sub};

use crate::base::{self, Base, Reach};
use crate::error::SolveError;
use crate::modes::{Found, Part, Place, place, split};
use crate::options::{Options, Progress};
use crate::packs;
use crate::spectral::factor::Factor;
use crate::spectral::operators::{
    self, Assembled, Entries, Evaluated, Operators, element_columns, matrix, mirror, scatter, spring_change,
};
use crate::spectral::pencil::{Known, Pairs, Pencil, SETTLED};
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
/// A family without a factor among those of a lower order is looked at up to so many times the largest of these.
const BEYOND: f64 = 1.5;
/// Residual of a motion of a lower order, over its eigenvalue: the square of it is nothing beside the error of that order.
const ROUGHLY: f64 = 1e-5;
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
}

/// Critical factors about a state.
#[derive(Clone, Debug)]
pub struct Buckling {
    /// Positive ones, the smallest first.
    pub critical: Vec<Critical>,
    /// The nearest factor of the ramp the other way, up to a thousand times the first one.
    pub reversed: Option<f64>,
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
}

/// A state, the ramp that begins there, and the drives at its two ends.
struct Beginning {
    base: Base,
    from: Vec<f64>,
    to: Vec<f64>,
}

/// The `wanted` smallest factors of a ramp: on the elements asked for and on those of the next two orders, or of the next one
/// where there are no more.
///
/// # Errors
/// Those of [`crate::solve`].
pub fn buckle(
    structure: &Structure,
    steps: &[Step],
    ramp: Ramp,
    wanted: usize,
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
    let highest = structure.members.iter().map(|member| member.order).max().unwrap_or(1);
    let most = packs::HIGHEST.saturating_sub(highest).clamp(1, MORE_ORDERS);
    let mut level = |enrich: usize, below: Option<&Buckling>| {
        let base = match ramp {
            Ramp::Of(step) => followed.beginning(&steps[step], enrich),
            Ramp::Present(_) => followed.base(enrich).map(|mut base| {
                base.once_more();
                base
            }),
        };
        let base = base.ok_or(NoFactors::NotSettled)?;
        let asked = Asked { wanted, below, last: enrich == most };
        Beginning { base, from: from.clone(), to: to.clone() }.factors(&asked)
    };
    let mut levels: Vec<Buckling> = Vec::new();
    for enrich in 0..=most {
        match level(enrich, levels.last()) {
            Ok(found) => levels.push(found),
            Err(why) => return Ok(Found { history, result: Err(why) }),
        }
    }
    Ok(Found { history, result: Ok(levels) })
}

/// What is looked for on one order of the elements.
struct Asked<'a> {
    /// How many factors.
    wanted: usize,
    /// Those of the order below.
    below: Option<&'a Buckling>,
    /// Whether this is the highest order, whose factors are the answer.
    last: bool,
}

impl Asked<'_> {
    /// How many factors of a family to look for, and what is known of them, all being smaller than the inverse of `least`.
    ///
    /// One more than were found on the order below: where all of them are among those wanted, some may be missing.
    fn of(&self, family: Family, least: f64) -> (usize, Known) {
        let everything = (self.wanted, Known { least, about: None });
        let Some(below) = self.below else { return everything };
        let Some(largest) = below.critical.last() else { return everything };
        let own: Vec<f64> = below.critical.iter().filter(|c| c.family == family).map(|c| c.factor).collect();
        let near = least.max(1.0 / (BEYOND * largest.factor));
        let known = match own.first() {
            Some(first) => Known { least, about: Some(1.0 / first) },
            None => Known { least: near, about: None },
        };
        ((own.len() + 1).min(self.wanted), known)
    }
}

impl Base {
    /// Makes the held motions those of a ramp on which they are made once more.
    fn once_more(&mut self) {
        let mut rows = self.system.equations.held.clone();
        for row in &mut rows {
            row.from = row.to;
            row.to *= 2.0;
        }
        self.system.fading.clear();
        self.system.hold(rows);
        self.system.fraction = 0.0;
        self.system.apply_drives();
        self.system.assemble(false);
    }
}

/// K′ of the beginning of a ramp.
struct Change {
    /// Over all unknowns.
    entries: Entries,
    /// The largest displacement of a joint per unit of the ramp.
    motion: f64,
    /// Part of it that it may be off.
    error: f64,
}

/// Factors of all families.
#[derive(Default)]
struct Factors {
    critical: Vec<Critical>,
    complete: bool,
    reversed: Option<f64>,
    neutral: Vec<Family>,
    /// Whether a family may have more of those wanted.
    crowded: bool,
}

impl Beginning {
    fn factors(mut self, asked: &Asked) -> Result<Buckling, NoFactors> {
        let system = &mut self.base.system;
        let moving = system.equations.held.iter().any(|row| row.from != row.to);
        if self.from == self.to && !moving && system.fading.is_empty() {
            return Err(NoFactors::NothingMoves);
        }
        let unknowns = Unknowns::new(system);
        let assembled = Assembled::without_mass(system, &unknowns);
        let mut without_potential = system.without_potential();
        let change = self.change(&unknowns, &mut without_potential).ok_or(NoFactors::Neutral)?;

        let (parts, left_out) = split(&self.base, &unknowns, &without_potential);
        if parts.is_empty() {
            return Err(NoFactors::NoPotential);
        }
        let mut found = self.of_families(&unknowns, &assembled, &change, &parts, asked)?;
        if found.crowded {
            let asked = Asked { below: None, ..*asked };
            found = self.of_families(&unknowns, &assembled, &change, &parts, &asked)?;
        }
        let Factors { critical, complete, reversed, neutral, .. } = found;
        if neutral.len() == parts.len() {
            return Err(NoFactors::Neutral);
        }
        let place = place(&mut self.base.system);
        let (reach, unknowns) = (self.base.reach, unknowns.size);
        Ok(Buckling { critical, reversed, place, reach, left_out, neutral, complete, unknowns })
    }

    fn of_families(
        &self,
        unknowns: &Unknowns,
        assembled: &Assembled,
        change: &Change,
        parts: &[Part],
        asked: &Asked,
    ) -> Result<Factors, NoFactors> {
        let system = &self.base.system;
        let settled = if asked.last { SETTLED } else { ROUGHLY };
        let least = change.motion / (FARTHEST * system.size);
        let mut all = Factors { complete: true, ..Factors::default() };
        let mut counts = Vec::new();
        for (family, numbers) in parts {
            let operators = assembled.of_family(numbers);
            if operators.stiffness.rows() == 0 {
                continue;
            }
            let forwards = matrix(&change.entries, numbers).map(|value| -value);
            let factor = || Factor::new(&operators.stiffness).filter(|factor| factor.neutral == 0);
            let Some(pivots) = factor() else {
                all.neutral.push(*family);
                continue;
            };
            if pivots.negative > 0 {
                return Err(NoFactors::Unstable(pivots.negative));
            }
            let pairs = |factor: Factor, other: &sprs::CsMat<f64>, known: Known, wanted: usize| -> Pairs {
                let Operators { stiffness, form, constraints, .. } = &operators;
                let pencil = Pencil { factor, shift: 0.0, stiffness, form, other, constraints, settled };
                pencil.largest_above(known, wanted)
            };
            let (count, known) = asked.of(*family, least);
            counts.push((*family, count));
            let found = pairs(pivots, &forwards, known, count);
            all.complete &= found.complete;
            for ((value, vector), &rounding) in found.values.iter().zip(&found.vectors).zip(&found.rounding) {
                let x: Vec<f64> = numbers.iter().map(|number| number.map_or(0.0, |n| vector[n])).collect();
                let shape = Shape::new(system, unknowns, &x);
                let largest = shape.largest(system.size).value;
                let shape = shape.scaled(1.0 / largest);
                let rounding = rounding.max(change.error);
                all.critical.push(Critical { factor: 1.0 / value, rounding, family: *family, shape });
            }
            if !asked.last {
                continue;
            }
            let backwards = forwards.map(|value| -value);
            let least = least.max(found.values.first().map_or(0.0, |first| first / OTHER_WAY));
            let nearest = factor().and_then(|factor| {
                let known = Known { least, about: None };
                pairs(factor, &backwards, known, 1).values.first().map(|value| -1.0 / value)
            });
            if let Some(factor) = nearest {
                all.reversed = Some(all.reversed.map_or(factor, |known| known.max(factor)));
            }
        }
        all.critical.sort_by(|a, b| a.factor.total_cmp(&b.factor));
        all.critical.truncate(asked.wanted);
        let is_full = |&(family, count): &(Family, usize)| {
            count < asked.wanted && all.critical.iter().filter(|c| c.family == family).count() == count
        };
        all.crowded = counts.iter().any(is_full);
        Ok(all)
    }

    /// K′; nothing where the state does not respond.
    fn change(&mut self, unknowns: &Unknowns, without_potential: &mut Vec<(usize, usize)>) -> Option<Change> {
        let response = self.response()?;
        let motion = response.motions.iter().fold(0.0f64, |most, m| most.max(norm([m[0], m[1], m[2]])));
        let system = &mut self.base.system;
        let mut entries = Entries::new();
        let mut forces = vec![[0.0; 6]; system.forces.len()];
        for member in 0..system.members.len() {
            let slot = &system.members[member];
            let pack = &system.packs[slot.pack];
            for e in 0..pack.elements() {
                let state = pack.element(slot.lane, e);
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
            let lever = pennate_elements::rotation::turn(system.state.joints[link.joint].place.rotation, link.arm);
            add([m[0], m[1], m[2]], cross([m[3], m[4], m[5]], lever))
        };
        spring_change(system, &moved, &mut entries);

        // Loads on levers and followers, and constraints whose direction turns with the joint. Forces of springs on a
        // joint with such constraints are left out of the change of its reactions.
        let internal = system.forces.clone();
        let before = system.remainder();
        let loads = system.forces.clone();
        self.set(response.part);
        let system = &mut self.base.system;
        system.remainder();
        let total: Vec<[f64; 6]> = (0..internal.len())
            .map(|joint| {
                let change = add(sub(system.forces[joint], loads[joint]), scale(response.part, forces[joint]));
                add(internal[joint], change)
            })
            .collect();
        let (topology, joints) = (Arc::clone(&system.topology), system.state.joints.clone());
        system.equations.find_multipliers(&topology, &joints, &total, response.part);
        let after = system.remainder();
        without_potential.extend(system.without_potential());
        mirror(&after, 1.0 / response.part, &mut entries);
        mirror(&before, -1.0 / response.part, &mut entries);
        self.set(0.0);
        self.base.system.assemble(false);
        Some(Change { entries, motion, error: response.error })
    }
}

/// Adds forces on the ends of a member to those of its joints.
fn add_end_forces(system: &System<6>, member: usize, ends: &[[f64; 6]; 2], forces: &mut [[f64; 6]]) {
    use crate::joints::EndKind;
    for (end, info) in system.end_info(member, *ends).iter().enumerate() {
        let joint = system.topology.links[system.structure.members[member].nodes[end]].joint;
        let moment = if let EndKind::Free { .. } = info.kind { [0.0; 3] } else { info.moment };
        let moment = add(moment, cross(info.lever, info.force));
        for c in 0..3 {
            forces[joint][c] += info.force[c];
            forces[joint][3 + c] += moment[c];
        }
    }
}
