//! What follows each of the parameters at an equilibrium while the joints stay where they are: forces of the parts that it
//! reaches, and the motion of what is held.

use std::collections::BTreeMap;

use pennate_elements::small::{add, scale, sub};
use pennate_solver::joints::{Held, HeldKind, dot6};
use pennate_solver::structure::{Drive, MemberId};
use pennate_solver::system::System;

use super::design::Design;
use super::moved::{Copies, Mover};
use super::nearby::{self, Nearby, apart, size};
use super::numbers::{Places, change_value};
use super::slopes::{Hold, Slopes, Stage};

/// Times the part of a parameter at which forces are compared.
pub(super) const TIMES: [f64; 4] = [1.0, -1.0, 2.0, -2.0];
/// That part over the slenderness λ of the members that a parameter reaches: h and 2 h, extrapolated to h = 0, leave (λ h)⁴ / 30, since
/// interiors follow by the factors of the middle.
const OVER_SLENDERNESS: f64 = 6e-3;
/// The shortest and the longest: rounding leaves 10⁻¹⁶ λ² / h of a derivative.
const SHORTEST: f64 = 3e-6;
const LONGEST: f64 = 3e-4;
/// Slenderness of a member that is at least as stiff as what holds strains first, and of one that is held as it is held in the end.
const HELD: [f64; 2] = [1e2, 1e3];
/// How many times shorter the next distance is where one is too long.
pub(super) const SHORTER: f64 = 8.0;
/// Part of what derivatives of a quantity are measured by that extrapolation may leave of one without a shorter distance being tried.
pub(super) const LEFT: f64 = 2.5e-8;

/// Part of what rows of a joint are to move by that they may miss: more where they depend on each other.
const MISSED: f64 = 1e-9;

/// Values for every joint.
pub(super) type Joints = Vec<[f64; 6]>;

/// What was moved along the parameters: for forces, and for stiffnesses, over other distances.
pub(super) struct Kept<const D: usize> {
    forces: Option<MovedParts<D>>,
    pub works: Option<MovedParts<D>>,
}

impl<const D: usize> Default for Kept<D> {
    fn default() -> Self {
        Self { forces: None, works: None }
    }
}

/// Parts moved so far along the parameters, which serve as long as they are made of the same members on the same pieces of their
/// tables: sections under another auxiliary stiffness, and the ends of other steps.
pub(super) struct MovedParts<const D: usize> {
    pub copies: Copies<D>,
    members: Vec<Vec<MemberId>>,
    controls: Vec<f64>,
    parts: Vec<f64>,
    /// Drives of each of them, at present.
    pub drives: Vec<Vec<f64>>,
}

/// What follows a parameter while the joints stay where they are, and the motion of what is held.
pub(super) struct Explicit {
    pub forces: Joints,
    /// By how much the forces differ from those that the nearer distance tells alone.
    pub corrections: Joints,
    pub held: Joints,
    pub moves: bool,
}

/// The part of a parameter, which reaches these members, at which forces are compared.
fn part_of<const D: usize>(system: &System<D>, members: &[MemberId]) -> f64 {
    let slenderness =
        members.iter().map(|&member| system.loading.slenderness_of(member)).fold(OVER_SLENDERNESS / LONGEST, f64::max);
    let [first, last] = HELD;
    let is_held = system.loading.holds_strains() && slenderness >= 0.9 * first;
    (OVER_SLENDERNESS / if is_held { slenderness.max(last) } else { slenderness }).max(SHORTEST)
}

/// What extrapolation to no distance leaves of a derivative, from what it changed of it: changes go with the square of the distance over a length
/// of the parameter's own, what is left with the fourth power. It is 1.2 times c²/s of sines and exponentials, 4 times of 1/x.
pub(super) fn left_of(slope: f64, change: f64) -> f64 {
    4.0 * change.abs() * (change / slope).abs().min(1.0)
}

/// A shorter part; `None` where there is none.
pub(super) fn shorter(part: f64) -> Option<f64> {
    (part > SHORTEST).then(|| (part / SHORTER).max(SHORTEST))
}

fn pairs(all: &[Nearby]) -> impl Iterator<Item = (&Nearby, usize)> {
    all.iter().flat_map(|nearby| nearby.inputs.iter().map(move |&input| (nearby, input)))
}

impl Slopes<'_> {
    /// What follows each of the parameters while the joints stay where they are, by differences at these parts of the parameters; those
    /// that are not known yet, not numbers, are chosen.
    pub(super) fn explicit<const D: usize>(
        &self,
        system: &System<D>,
        (stage, all, parts): (Stage, &[Nearby], &mut [f64]),
        kept: &mut Kept<D>,
    ) -> Option<Vec<Explicit>> {
        let places = Places::of(&self.design.structure, &self.design.steps);
        let joints = system.places.joints.len();
        let mut explicit: Vec<Explicit> = (0..self.row.len())
            .map(|_| Explicit {
                forces: vec![[0.0; 6]; joints],
                corrections: vec![[0.0; 6]; joints],
                held: vec![[0.0; 6]; joints],
                moves: false,
            })
            .collect();
        for (nearby, input) in pairs(all) {
            self.hold_along(system, (nearby, input), &places, &mut explicit[input])?;
        }
        let rates = self.rates(stage, all, &places);
        let movers = self.movers(all, &places, &rates);
        for mover in &movers {
            if parts[mover.input].is_nan() {
                parts[mover.input] = part_of(system, &mover.members(&system.topology));
            }
        }
        let moved = self.moved(system, (&movers, parts, false), &mut kept.forces);
        let forces = moved.copies.forces(system, &moved.drives);
        let whose = movers.iter().map(|mover| mover.input);
        for (forces, input) in forces.chunks_exact(TIMES.len()).zip(whose) {
            let far = parts[input] * size(self.row[input]);
            let Explicit { forces: totals, corrections, .. } = &mut explicit[input];
            for (joint, (total, correction)) in totals.iter_mut().zip(corrections).enumerate() {
                for c in 0..6 {
                    let slope = |at: usize| (forces[at][joint][c] - forces[at + 1][joint][c]) / (2.0 * far * TIMES[at]);
                    correction[c] = (slope(0) - slope(2)) / 3.0;
                    total[c] += slope(0) + correction[c];
                }
            }
        }
        Some(explicit)
    }

    /// By how much every drive changes along every parameter.
    pub(super) fn rates(&self, stage: Stage, all: &[Nearby], places: &Places) -> Vec<Vec<f64>> {
        let count = self.design.structure.drives.len();
        pairs(all).map(|(nearby, input)| nearby.drives(input, stage.behind(), places, count)).collect()
    }

    pub(super) fn movers<'b>(&'b self, all: &'b [Nearby], places: &'b Places, rates: &'b [Vec<f64>]) -> Vec<Mover<'b>> {
        let mover = |((nearby, input), drives): ((&'b Nearby, usize), &'b Vec<f64>)| Mover {
            design: self.design,
            nearby,
            places,
            input,
            drives,
        };
        pairs(all).zip(rates).map(mover).collect()
    }

    /// Parts that are moved by every parameter, or the whole network: those at hand, where they are the same.
    pub(super) fn moved<'a, const D: usize>(
        &self,
        system: &System<D>,
        (movers, parts, whole): (&[Mover<'_>], &[f64], bool),
        kept: &'a mut Option<MovedParts<D>>,
    ) -> &'a mut MovedParts<D> {
        let times = |input: usize| {
            let times = parts[input] * size(self.row[input]) / apart(self.row[input]);
            TIMES.map(|far| far * times)
        };
        let every: Vec<MemberId> = (0..self.design.structure.members.len()).collect();
        let of = |mover: &Mover<'_>| if whole { every.clone() } else { mover.members(&system.topology) };
        let members: Vec<Vec<MemberId>> = movers.iter().map(of).collect();
        let drives = self.design.structure.drives.iter().zip(&system.loading.drives);
        let controls: Vec<f64> =
            drives.filter(|(drive, _)| **drive == Drive::Control).map(|(_, &value)| value).collect();
        let is_same =
            |kept: &MovedParts<D>| kept.members == members && kept.controls == controls && kept.parts == parts;
        let known = kept.take().filter(is_same);
        let kept = kept.insert(known.unwrap_or_else(|| {
            let at = |(mover, members): (&Mover<'_>, &Vec<MemberId>)| {
                let laws = mover.laws(members, &system.loading.drives);
                times(mover.input).map(|times| mover.at(members, &laws, times, whole))
            };
            let still = |members: &[MemberId]| {
                movers[0].at(members, &movers[0].laws(members, &system.loading.drives), 0.0, false)
            };
            let copies = Copies::of(system, movers.iter().zip(&members).flat_map(at).collect(), still);
            MovedParts { copies, members, controls, parts: parts.to_vec(), drives: Vec::new() }
        }));
        let drives = |mover: &Mover<'_>| times(mover.input).map(|times| mover.drives_at(&system.loading.drives, times));
        kept.drives = movers.iter().flat_map(drives).collect();
        kept
    }

    /// The motion of what is held by a parameter, and what is left out of balance where reactions turn with what holds them;
    /// `None` where it is a turn in space, or where rows depend on each other.
    ///
    /// Rows gᵢ(d, p) = 0 with gradients Gᵢ bear the forces of their joint, F = Σ λᵢ Gᵢ: they move by −∂gᵢ/∂p, and of the forces
    /// Σ λᵢ ∂Gᵢ/∂p is no change of λ.
    fn hold_along<const D: usize>(
        &self,
        system: &System<D>,
        (nearby, input): (&Nearby, usize),
        places: &Places,
        explicit: &mut Explicit,
    ) -> Option<()> {
        let counts = self.design.steps.iter().scan(places.changes, |at, step| {
            let first = *at;
            *at += step.changes.len();
            Some(first)
        });
        let firsts: Vec<usize> = counts.collect();
        let change = |(step, place): (usize, usize)| {
            if !nearby.is_owned(firsts[step] + place, input) {
                return 0.0;
            }
            let value = |design: &Design| change_value(&design.steps[step].changes[place]);
            nearby::change(nearby.around().map(value)) / (2.0 * apart(self.row[input]))
        };
        let mover = Mover { design: self.design, nearby, places, input, drives: &[] };
        let equations = &system.pattern.equations;
        let mut general: BTreeMap<usize, Vec<(usize, f64)>> = BTreeMap::new();
        for (row, held) in equations.held.iter().enumerate() {
            let rate = match self.holds.get(&(held.node, held.component)) {
                None => 0.0,
                Some(Hold::To(step, place)) => change((*step, *place)),
                Some(Hold::From(moved, rates)) => moved.map_or(0.0, change) + rates[input],
            };
            let link = system.topology.links[held.node];
            let arm = sub(mover.node(held.node), mover.node(system.topology.references[link.joint]));
            let turn = mover.axis(held.node, held.component);
            if equations.is_general(link.joint) || arm != [0.0; 3] || turn != [0.0; 3] {
                if rate == 0.0 && arm == [0.0; 3] && turn == [0.0; 3] {
                    continue;
                }
                let at = |times: f64| {
                    let kind = held.kind.turned(scale(times, turn));
                    system.row_at(&Held { kind, ..*held }, add(link.arm, scale(times, arm)))
                };
                let ((low, before), (high, after)) = (at(-0.5), at(0.5));
                let far = 2.0 * apart(self.row[input]);
                let reaction = system.reaction_along(row);
                for c in 0..6 {
                    explicit.forces[link.joint][c] -= reaction * (after[c] - before[c]) / far;
                }
                if matches!(held.kind, HeldKind::Rotation { .. }) && D == 6 {
                    return None;
                }
                general.entry(link.joint).or_default().push((row, rate - (high - low) / far));
                continue;
            }
            if rate == 0.0 {
                continue;
            }
            explicit.moves = true;
            let motion = &mut explicit.held[link.joint];
            let (vector, offset) = match held.kind {
                HeldKind::Translation { direction } => (direction, 0),
                HeldKind::Rotation { .. } if D == 6 => return None,
                HeldKind::Rotation { axis } => (axis, 3),
            };
            for c in 0..3 {
                motion[offset + c] += rate * vector[c];
            }
        }
        for (joint, rates) in general {
            let motion = system.along_rows(joint, &rates);
            let missed = |&(row, rate): &(usize, f64)| {
                let held = &equations.held[row];
                let (_, gradient) = system.row_at(held, system.topology.links[held.node].arm);
                (dot6(&gradient, &motion) - rate).abs() > MISSED * rate.abs()
            };
            if rates.iter().any(missed) {
                return None;
            }
            explicit.moves |= motion != [0.0; 6];
            for (own, motion) in explicit.held[joint].iter_mut().zip(motion) {
                *own += motion;
            }
        }
        Some(())
    }
}
