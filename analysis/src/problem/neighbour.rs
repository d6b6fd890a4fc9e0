//! Equilibria next to one that is known, found with its factors alone.
//!
//! The system of a neighbour, whose numbers differ a little, takes over the displacements, rotations, local unknowns and
//! stresses of the equilibrium at hand. What is out of balance then, interiors of members included, is solved for with the
//! factors at hand, by back-substitutions instead of factorizations. The error of one such step is of second order in the
//! distance, and what is left of it in differences of neighbours on both sides goes with the square of the slenderness. So steps are
//! repeated until one changes nothing that counts: each leaves of the last one what the tangent changes by over the distance, and
//! of multipliers of held strains the ratio of their auxiliary stiffness. Factors of the neighbour's own bring it to its last digits then.

use pennate_solver::compliance;
use pennate_solver::history::{Equilibrium, History, Increment, StepHistory};
use pennate_solver::joints::{Held, HeldKind};
use pennate_solver::results;
use pennate_solver::structure::Structure;
use pennate_solver::system::System;

use crate::together::axis;

/// A first step smaller than this (radians, or sizes of the network) is rounding: the numbers that differ have no influence.
pub(super) const NOTHING: f64 = 1e-10;
/// Steps with the factors at hand, at most, and the part of the first one at which one more changes nothing that counts.
const MOST: usize = 12;
const SETTLED: f64 = 1e-11;
/// The part of the first one that the last one may be: the rest is left to factors of the neighbour's own.
const NEARLY: f64 = 0.1;

/// Steps by which an equilibrium is brought to its last digits, at most, and one (radians, or lengths of a member) after which what
/// is left is rounding.
const MORE: usize = 6;
const EXACT: f64 = 1e-13;

/// Brings the end of a path to its last digits: paths end where what is left counts for no value, but of derivatives that are left
/// of large ones it is a part. Mixed stresses are one iteration behind the state, besides.
pub(super) fn settle<const D: usize>(system: &mut System<D>) {
    system.advance(system.pattern.equations.has_general());
    polish(system);
}

/// Brings a state that is next to its equilibrium to the last digits, by factors of its own. Tells whether it came there.
pub(super) fn polish<const D: usize>(system: &mut System<D>) -> bool {
    let pending = system.pattern.equations.has_general();
    system.assemble(pending);
    let mut last = f64::INFINITY;
    for _ in 0..MORE {
        let Some(size) = system.advance(pending) else { break };
        last = size.largest();
        let goes_on = system.refresh(pending);
        if last <= if goes_on { EXACT } else { SETTLED } {
            break;
        }
        if !goes_on {
            system.assemble(pending);
        }
    }
    last <= SETTLED
}

/// Brings a system that stands where `known` does to its own equilibrium next to it, to first order, and leaves it assembled
/// there but for the factors. Gives how far its joints moved (radians, or sizes of the network), to second order: the step
/// after the last one that was made counts; and whether steps became small. `None` where the tangent has no inverse.
pub(super) fn approach<const D: usize>(system: &mut System<D>, known: &mut System<D>) -> Option<(Vec<f64>, bool)> {
    let (mut first, mut last, mut moved) = (0.0, 0.0, Vec::new());
    let mut most: f64 = 0.0;
    system.gather(true);
    for pass in 0..MOST {
        let (step, components) = step(system, known)?;
        let size = components.iter().fold(0.0, |most: f64, component| most.max(component.abs()));
        last = size;
        if pass == 0 {
            first = size;
            moved = components;
        } else {
            moved.iter_mut().zip(&components).for_each(|(sum, component)| *sum += component);
        }
        let inside = system.move_by(&step, true).largest();
        if !inside.is_finite() {
            return None;
        }
        system.gather(true);
        most = most.max(inside);
        if pass > 0 && inside <= SETTLED * most {
            break;
        }
    }
    let settled = last <= NEARLY * first || first < NOTHING;
    Some((moved, settled))
}

/// What the factors of `known` make of what is out of balance, and the displacements (over the size of the network) and
/// rotations (radians) of the joints in it.
fn step<const D: usize>(system: &System<D>, known: &mut System<D>) -> Option<(Vec<f64>, Vec<f64>)> {
    let mut step: Vec<f64> = system.tangent.rhs.iter().map(|residual| -residual).collect();
    let solved = known.tangent.solve(&mut step);
    let components: Vec<f64> = components(system, &step).collect();
    (solved && components.iter().all(|component| component.is_finite())).then_some((step, components))
}

/// The largest rotation (radians) or displacement (over the size of the network) of a joint in a step.
pub(super) fn size_of<const D: usize>(system: &System<D>, step: &[f64]) -> f64 {
    components(system, step).fold(0.0, |most: f64, component| most.max(component.abs()))
}

fn components<const D: usize>(system: &System<D>, step: &[f64]) -> impl Iterator<Item = f64> {
    let size = system.size;
    system.pattern.motions_of(step).into_iter().flat_map(move |motion| {
        let [ux, uy, uz, rx, ry, rz] = motion;
        [ux / size, uy / size, uz / size, rx, ry, rz]
    })
}

/// What a user may ask of the state that a system was polished to, with forces in balance.
pub(super) fn read<const D: usize>(system: &mut System<D>) -> Equilibrium {
    let pending = system.pattern.equations.has_general();
    let asks_compliances = !system.structure.compliances.is_empty();
    if asks_compliances {
        system.assemble(pending);
    }
    system.correct_forces(pending);
    let state = results::equilibrium(system);
    let compliances = if asks_compliances { compliance::of_nodes(system) } else { Vec::new() };
    Equilibrium { compliances, ..state }
}

/// The rows that hold a system, with directions of supports as a structure has them.
pub(super) fn rows(held: &[Held], structure: &Structure) -> Vec<Held> {
    let row = |held: &Held| {
        let axis = axis(structure, held.node, held.component);
        let kind = match held.kind {
            HeldKind::Translation { .. } => HeldKind::Translation { direction: axis },
            HeldKind::Rotation { .. } => HeldKind::Rotation { axis },
        };
        Held { kind, ..*held }
    };
    held.iter().map(row).collect()
}

/// A history of one state alone, for what is asked of histories.
pub(super) fn history_of(like: &StepHistory, state: Equilibrium) -> History {
    let increment = Increment { fraction: 1.0, state, shapes: Vec::new() };
    let step = StepHistory {
        increments: vec![increment],
        refined: None,
        missing: Vec::new(),
        variations: Vec::new(),
        critical_points: Vec::new(),
        jumps: Vec::new(),
        notes: Vec::new(),
        failure: None,
        ..*like
    };
    History { steps: vec![step], ..History::default() }
}
