//! Derivatives at one equilibrium by the adjoint method.
//!
//! Motions d of the joints leave the forces F(d, p) on them: F = 0 along what is free, d = d(p) along what is held. For a
//! probe q with the derivatives v by the motions and w by the forces, let λ be free motions with Kᵀ λ = −(v + Kᵀ w) along
//! what is free: one solve with the factors at hand. With μ = λ + w then dq/dp = μ · ∂F/∂p + (v + Kᵀ μ) · ∂d/∂p + ∂q/∂p.
//! Of a parameter only ∂F/∂p is left to find: forces of the parts that it reaches, where the joints stay where they are.

use std::collections::BTreeSet;

use pennate_elements::rotation::{turn, turn_less_identity};
use pennate_elements::small::{add, cross, dot, scale, sub};
use pennate_models::Model;
use pennate_models::probes::Operand;
use pennate_models::slopes::Weights;
use pennate_solver::history::Equilibrium;
use pennate_solver::joints::HeldKind;
use pennate_solver::packs::{self, Auxiliary};
use pennate_solver::rigid::{AUXILIARIES, Limit};
use pennate_solver::system::System;

use super::Reason;
use super::explicit::{Explicit, Joints, Kept};
use super::moved::Mover;
use super::nearby::{Nearby, apart, size};
use super::neighbour;
use super::numbers::Places;
use super::slopes::{Component, Slopes};
use crate::together;

/// Part of every parameter by which the tangent is looked at, and by how much it may change there: near a limit point, at a
/// distance of the part δ of a parameter, it changes by that part over 4 δ.
const NEAR: f64 = 1e-4;
const CHANGED: f64 = 0.1;
/// A second difference larger than this part of the first one is a corner.
const CORNER: f64 = 0.05;
const ROUNDING: f64 = 1e-12;
/// Auxiliary stiffnesses that are tried at most: of what statics fixes, all of them leave rounding, which never agrees.
const ENOUGH: usize = 6;
/// Derivatives that no distance goes into, of probes and of components beyond them; not a number where there are none.
pub(super) struct Exact {
    pub slopes: Vec<f64>,
    /// Whether the tangent changes little along the parameters: no singular point is near.
    pub regular: bool,
    /// Whether all are there.
    pub whole: bool,
}

impl Slopes<'_> {
    /// Derivatives of the probes that are needed at the end of a step, and of components that the next step keeps; `None` where all
    /// of them have to be found in another way, or, if `whole`, any.
    pub(super) fn adjoint<const D: usize>(
        &mut self,
        system: &mut System<D>,
        (index, state): (usize, &Equilibrium),
        (kept, whole): (&[Component], bool),
        copies: &mut Option<Kept<D>>,
    ) -> Option<Result<Exact, Reason>> {
        if !self.is_linear(system) || D == 6 && kept.iter().any(|&(_, component)| component >= 3) {
            return None;
        }
        let probes = &self.design.model.probes;
        let needed = self.needed(index);
        let plain = |probe: &&usize| probes.operands(**probe).is_none();
        let mut read: Vec<(usize, Weights)> = Vec::new();
        let mut missing = BTreeSet::new();
        for &probe in needed.iter().filter(plain) {
            match probes.weights(probe, state) {
                Some(weights) => read.push((probe, weights)),
                None if whole => return None,
                None => _ = missing.insert(probe),
            }
        }
        for (place, &component) in kept.iter().enumerate() {
            read.push((probes.len() + place, weights_of(system, component)));
        }
        if read.is_empty() && !missing.is_empty() {
            return None;
        }
        let all = self.nearby.take().unwrap_or_else(|| self.problem.nearby(self.row, self.design));
        let Some(all) = all else {
            self.nearby = Some(None);
            return None;
        };
        let found = self.slopes_of(system, (index, state), (&needed, &read, missing), (&all, kept.len()), copies);
        self.nearby = Some(Some(all));
        found
    }

    fn slopes_of<const D: usize>(
        &self,
        system: &mut System<D>,
        (index, state): (usize, &Equilibrium),
        (needed, read, mut missing): (&BTreeSet<usize>, &[(usize, Weights)], BTreeSet<usize>),
        (all, kept): (&[Nearby], usize),
        copies: &mut Option<Kept<D>>,
    ) -> Option<Result<Exact, Reason>> {
        let (inputs, probes) = (self.row.len(), self.design.model.probes.len());
        let sizes: Vec<f64> = self.row.iter().map(|&value| size(value)).collect();
        let mut limit = Limit::new(&sizes);
        let mut explicit = Vec::new();
        let auxiliaries = if system.loading.holds_strains() { &AUXILIARIES[..ENOUGH] } else { &[packs::AUXILIARY] };
        for &auxiliary in auxiliaries {
            if let Err(reason) = self.wanted() {
                set_auxiliary(system, packs::AUXILIARY);
                return Some(Err(reason));
            }
            take_auxiliary(system, auxiliary);
            system.assemble(false);
            let Some(found) = self.explicit(system, (index, all), copies) else {
                set_auxiliary(system, packs::AUXILIARY);
                return None;
            };
            explicit = found;
            let moves = explicit.iter().any(|explicit| explicit.moves);
            system.tangent.transpose();
            let mut slopes = vec![f64::NAN; (probes + kept) * inputs];
            for (quantity, weights) in read {
                let Some((mu, pull)) = adjoint_of(system, weights, moves) else {
                    system.tangent.transpose();
                    set_auxiliary(system, packs::AUXILIARY);
                    return Some(Err(Reason::Singular { step: index }));
                };
                for (input, explicit) in explicit.iter().enumerate() {
                    let of = |a: &Joints, b: &Joints| a.iter().zip(b).map(|(a, b)| dot6(a, b)).sum::<f64>();
                    let held = if explicit.moves { of(&pull, &explicit.held) } else { 0.0 };
                    slopes[quantity * inputs + input] = of(&mu, &explicit.forces) + held;
                }
            }
            system.tangent.transpose();
            if limit.add(slopes) {
                break;
            }
        }
        let mut slopes = limit.take();
        for nearby in all {
            for &input in &nearby.inputs {
                self.add_own(system, state, read, (nearby, input), &mut slopes);
            }
        }
        if self.combine(index, all, (needed, &mut missing), &mut slopes).is_none() {
            set_auxiliary(system, packs::AUXILIARY);
            return None;
        }
        let regular = system.pattern.equations.size == 0 || self.is_regular(system, index, &explicit);
        // Nobody goes on from the end of the last step, unless neighbours are looked at.
        if !regular || !missing.is_empty() || index + 1 < self.design.steps.len() {
            set_auxiliary(system, packs::AUXILIARY);
        }
        // A singular point may be near, or wires so stiff that motions of second order count: neighbours tell the two apart.
        Some(Ok(Exact { slopes, regular, whole: missing.is_empty() }))
    }

    /// Whether forces and motions are all that there is: no rows that turn with their joint.
    fn is_linear<const D: usize>(&self, system: &System<D>) -> bool {
        let equations = &system.pattern.equations;
        let general = |joint: usize| equations.is_general(joint) && !equations.holds_nothing(joint);
        !(0..equations.joints.len()).any(general)
    }

    /// The probes whose derivatives are asked for at a step, or go into others that are.
    fn needed(&self, index: usize) -> BTreeSet<usize> {
        let probes = &self.design.model.probes;
        let mut open: Vec<(usize, usize)> =
            self.problem.outputs.iter().map(|output| (output.step, output.probe)).collect();
        let mut seen = BTreeSet::new();
        while let Some((step, probe)) = open.pop() {
            if !seen.insert((step, probe)) {
                continue;
            }
            for operand in probes.operands(probe).into_iter().flatten() {
                match *operand {
                    Operand::Parameter(_) => {}
                    Operand::Probe(other) => open.push((step, other)),
                    Operand::After { probe: other, step: at } => open.push((at, other)),
                }
            }
        }
        seen.into_iter().filter(|&(step, _)| step == index).map(|(_, probe)| probe).collect()
    }

    /// Adds what quantities change by where nothing moves: by their own numbers, and by those of arms of bodies.
    fn add_own<const D: usize>(
        &self,
        system: &System<D>,
        state: &Equilibrium,
        read: &[(usize, Weights)],
        (nearby, input): (&Nearby, usize),
        slopes: &mut [f64],
    ) {
        let model = &self.design.model;
        let places = Places::of(&self.design.structure, &self.design.steps);
        let mover = Mover { design: self.design, nearby, places: &places, input, drives: &[] };
        let far = 2.0 * apart(self.row[input]);
        let owned = |quantity: usize| quantity < model.probes.len() && nearby.is_owned(places.probes + quantity, input);
        let mut both: Option<[Vec<f64>; 2]> = None;
        for (quantity, weights) in read {
            let slope = &mut slopes[quantity * self.row.len() + input];
            if owned(*quantity) {
                let values = |model: &Model| model.probes.evaluate(state, &[]);
                let [low, high] = both.get_or_insert_with(|| [values(&nearby.low.model), values(&nearby.high.model)]);
                *slope += (high[*quantity] - low[*quantity]) / far;
            }
            for &(node, [x, y, z, ..]) in &weights.motions {
                let link = system.topology.links[node];
                let arm = sub(mover.node(node), mover.node(system.topology.references[link.joint]));
                if arm != [0.0; 3] {
                    let rotation = system.places.joints[link.joint].place.rotation;
                    *slope += dot([x, y, z], turn_less_identity(rotation, scale(1.0 / far, arm)));
                }
            }
        }
    }

    /// Derivatives of expressions by those of what they refer to, but for what is missing; `None` where one has a corner.
    fn combine(
        &self,
        index: usize,
        all: &[Nearby],
        (needed, missing): (&BTreeSet<usize>, &mut BTreeSet<usize>),
        slopes: &mut [f64],
    ) -> Option<()> {
        let (probes, inputs) = (&self.design.model.probes, self.row.len());
        let values = &self.after[index];
        for &probe in probes.order().iter().filter(|&probe| needed.contains(probe)) {
            let Some(operands) = probes.operands(probe) else { continue };
            let misses = |operand: &Operand| match *operand {
                Operand::Parameter(_) => false,
                Operand::Probe(other) => missing.contains(&other),
                Operand::After { probe: other, step } => step == index && missing.contains(&other),
            };
            if operands.iter().any(misses) {
                missing.insert(probe);
                continue;
            }
            for (nearby, &input) in all.iter().flat_map(|nearby| nearby.inputs.iter().map(move |input| (nearby, input)))
            {
                let by = apart(self.row[input]);
                let moved = |values: &[f64], slopes: &[f64], by: f64| -> Vec<f64> {
                    let rate = |probe: usize| slopes.get(probe * inputs + input).copied().unwrap_or(f64::NAN);
                    values.iter().enumerate().map(|(probe, value)| value + by * rate(probe)).collect()
                };
                let at = |model: &Model, by: f64| {
                    let before = self.after[..index].iter().zip(&self.slopes);
                    let before: Vec<Vec<f64>> = before.map(|(values, slopes)| moved(values, slopes, by)).collect();
                    model.probes.combine(probe, &moved(values, slopes, by), &before)
                };
                // Numbers that other parameters set are those of the design.
                let places = Places::of(&self.design.structure, &self.design.steps);
                let owned = nearby.is_owned(places.probes + probe, input);
                let [low, high] = match owned {
                    true => [&nearby.low.model, &nearby.high.model],
                    false => [&self.design.model; 2],
                };
                let (low, middle, high) = (at(low, -by), values[probe], at(high, by));
                let corner = (high - 2.0 * middle + low).abs();
                if !(corner <= CORNER * (high - low).abs() + ROUNDING * middle.abs().max(1.0)) {
                    return None;
                }
                slopes[probe * inputs + input] = (high - low) / (2.0 * by);
            }
        }
        Some(())
    }

    /// Moves on by a small part of all parameters at once, and looks at what the tangent makes of what is left there: next to
    /// a limit point it is another one.
    fn is_regular<const D: usize>(&self, system: &mut System<D>, index: usize, explicit: &[Explicit]) -> bool {
        let joints = system.places.joints.len();
        let (mut forces, mut held) = (vec![[0.0; 6]; joints], vec![[0.0; 6]; joints]);
        for (input, explicit) in explicit.iter().enumerate() {
            // No two the same, and of both signs: no motion is left out by chance.
            let times = 0.5 + 0.5 * (input as f64 * 0.618_033_988_749_895).fract();
            let part = if input % 2 == 0 { times } else { -times } * NEAR * size(self.row[input]);
            add_times(&mut forces, part, &explicit.forces);
            add_times(&mut held, part, &explicit.held);
        }
        if explicit.iter().any(|explicit| explicit.moves) {
            let moved = system.transposed_times(&held);
            add_times(&mut forces, 1.0, &moved);
        }
        let mut wanted = vec![0.0; system.pattern.equations.size];
        for (joint, force) in forces.iter().enumerate() {
            system.pattern.equations.project(joint, &force.map(|force| -force), &mut wanted);
        }
        let mut step = wanted.clone();
        if !system.tangent.solve(&mut step) {
            return false;
        }
        let first = neighbour::size_of(system, &step);
        if first < neighbour::NOTHING {
            return true;
        }
        let here = system.snapshot();
        system.move_by(&step, false);
        // What is left is of second order, and so are these forces.
        system.refresh(false);
        let mut left: Vec<f64> = wanted.iter().zip(&system.tangent.rhs).map(|(wanted, force)| wanted - force).collect();
        let solved = system.tangent.solve(&mut left);
        let regular = solved && neighbour::size_of(system, &left) <= CHANGED * first;
        system.restore(&here);
        if index + 1 < self.design.steps.len() {
            system.gather(false);
        }
        regular
    }
}

fn add_times(sum: &mut Joints, times: f64, joints: &Joints) {
    for (sum, joint) in sum.iter_mut().zip(joints) {
        for (sum, x) in sum.iter_mut().zip(joint) {
            *sum += times * x;
        }
    }
}

/// Takes another stiffness for held strains.
fn take_auxiliary<const D: usize>(system: &mut System<D>, auxiliary: Auxiliary) -> bool {
    let is_another = system.loading.auxiliary != auxiliary;
    if is_another {
        system.loading.auxiliary = auxiliary;
        system.apply_drives();
    }
    is_another
}

/// The same, and linearizes with it where it is another one.
fn set_auxiliary<const D: usize>(system: &mut System<D>, auxiliary: Auxiliary) {
    if take_auxiliary(system, auxiliary) {
        system.assemble(false);
    }
}

/// μ of a quantity, and where anything that is held moves also what moves with that.
fn adjoint_of<const D: usize>(system: &mut System<D>, weights: &Weights, moves: bool) -> Option<(Joints, Joints)> {
    let joints = system.places.joints.len();
    let (mut motions, mut forces) = (vec![[0.0; 6]; joints], vec![[0.0; 6]; joints]);
    for &(node, weight) in &weights.motions {
        let link = system.topology.links[node];
        let own = &mut motions[link.joint];
        let force = [weight[0], weight[1], weight[2]];
        let lever = turn(system.places.joints[link.joint].place.rotation, link.arm);
        let moment = add([weight[3], weight[4], weight[5]], cross(lever, force));
        for c in 0..3 {
            own[c] += force[c];
            own[3 + c] += moment[c];
        }
    }
    for &(node, weight) in &weights.reactions {
        for held in system.pattern.equations.held.iter().filter(|held| held.node == node) {
            let (vector, offset) = match held.kind {
                HeldKind::Translation { direction } => (direction, 0),
                HeldKind::Rotation { axis } => (axis, 3),
            };
            let along = dot(vector, [weight[offset], weight[offset + 1], weight[offset + 2]]);
            for c in 0..3 {
                forces[system.topology.links[node].joint][offset + c] += along * vector[c];
            }
        }
    }
    let by_motions = |system: &mut System<D>, forces: &Joints| -> Joints {
        let mut all = if weights.reactions.is_empty() && forces.iter().flatten().all(|&force| force == 0.0) {
            vec![[0.0; 6]; joints]
        } else {
            system.transposed_times(forces)
        };
        for (all, own) in all.iter_mut().zip(&motions) {
            for c in 0..6 {
                all[c] += own[c];
            }
        }
        all
    };
    let pull = by_motions(system, &forces);
    let mut solution = vec![0.0; system.pattern.equations.size];
    for (joint, pull) in pull.iter().enumerate() {
        system.pattern.equations.project(joint, &pull.map(|pull| -pull), &mut solution);
    }
    if !system.tangent.solve(&mut solution) {
        return None;
    }
    let mut mu = forces;
    for (joint, mu) in mu.iter_mut().enumerate() {
        let motion = system.pattern.equations.motion(joint, &solution, false);
        for c in 0..6 {
            mu[c] += motion[c];
        }
    }
    let pull = if moves { by_motions(system, &mu) } else { Vec::new() };
    Some((mu, pull))
}

/// The component of a node, in the axes of its support.
fn weights_of<const D: usize>(system: &System<D>, (node, component): Component) -> Weights {
    let axis = together::axis(&system.structure, node, component);
    let offset = if component < 3 { 0 } else { 3 };
    let mut weights = [0.0; 6];
    weights[offset..offset + 3].copy_from_slice(&axis);
    Weights { motions: vec![(node, weights)], reactions: Vec::new() }
}

fn dot6(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
