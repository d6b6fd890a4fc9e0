//! Derivatives at one equilibrium by the adjoint method.
//!
//! Motions d of the joints leave the forces F(d, p) on them: F = 0 along what is free, d = d(p) along what is held. For a
//! probe q with the derivatives v by the motions and w by the forces, let λ be free motions with Kᵀ λ = −(v + Kᵀ w) along
//! what is free: one solve with the factors at hand. With μ = λ + w then dq/dp = μ · ∂F/∂p + (v + Kᵀ μ) · ∂d/∂p + ∂q/∂p.
//! Of a parameter only ∂F/∂p is left to find: forces of the parts that it reaches, where the joints stay where they are.

use pennate_elements::rotation::{turn, turn_less_identity};
use pennate_elements::small::{add, cross, dot, scale, sub};
use pennate_models::slopes::Weights;
use pennate_solver::compliance;
use pennate_solver::history::Equilibrium;
use pennate_solver::joints::{Held, HeldKind};
use pennate_solver::packs::{self, Auxiliary};
use pennate_solver::rigid::{AUXILIARIES, Limit};
use pennate_solver::system::System;

use super::Reason;
use super::design::Design;
use super::estimate::{Estimate, Greatest, WITHIN};
use super::explicit::{self, Explicit, Joints, Kept};
use super::moved::Mover;
use super::nearby::{self, Nearby, apart, size};
use super::neighbour;
use super::numbers::Places;
use super::slopes::{Component, Slopes, Stage};
use crate::together;

/// Part of every parameter by which the tangent is looked at, and by how much it may change there: near a limit point, at a
/// distance of the part δ of a parameter, it changes by that part over 4 δ.
const NEAR: f64 = 1e-4;
const CHANGED: f64 = 0.1;
/// What extrapolation to no distance may change of a derivative, over the largest of its probe: its square is left, or less. Where it
/// changes more, distances are shorter.
const CORRECTED: f64 = 1e-5;
/// Part of what derivatives of a quantity are measured by at least that rounding of the state leaves of each.
const ROUNDED: f64 = 1e-9;
/// Auxiliary stiffnesses that are tried at most: of what statics fixes, all of them leave rounding, which never agrees.
const ENOUGH: usize = 6;
/// Part of what forces do along motions, each taken by itself, that rounding leaves where they cancel: with an auxiliary stiffness up to this
/// one, and beyond it with the square root of that.
const CANCELS: f64 = 3e-14;
const UP_TO: f64 = packs::MODERATE.member;

/// Derivatives that no distance goes into, of probes but for expressions, and of components beyond them; not a number where there are
/// none.
pub(super) struct Exact {
    /// By quantity and parameter.
    pub found: Vec<Estimate>,
    /// By how much each may be wrong, over the largest of its quantity.
    errors: Vec<f64>,
    inputs: usize,
    /// Whether the tangent changes little along the parameters: no singular point is near.
    pub regular: bool,
    /// Whether all are there.
    whole: bool,
}

impl Exact {
    /// Whether there is nothing left to find in another way.
    pub(super) fn serves(&self) -> bool {
        self.regular && self.whole && self.errors.iter().all(|&error| error <= WITHIN)
    }

    /// Whether there is a derivative of a quantity.
    pub(super) fn states(&self, quantity: usize, input: usize) -> bool {
        self.found[quantity * self.inputs + input].slope.is_finite()
    }

    /// Whether it is as near as is promised.
    pub(super) fn is_near(&self, quantity: usize, input: usize) -> bool {
        self.states(quantity, input) && self.errors[quantity * self.inputs + input] <= WITHIN
    }
}

/// A quantity that derivatives are found of by the adjoint method.
pub(super) struct Read {
    pub quantity: usize,
    /// What it follows of motions and reactions of nodes.
    weights: Weights,
    /// The compliance that it is made of, by its place among those of the structure, where it is; and whether it is the inverse of that.
    pub compliance: Option<(usize, bool)>,
}

/// What one auxiliary stiffness gives.
struct Round {
    /// By quantity and parameter.
    slopes: Vec<f64>,
    /// By how much rounding may move them, by what is read and parameter.
    cancelled: Vec<f64>,
    explicit: Vec<Explicit>,
}

impl Slopes<'_> {
    /// Derivatives of the probes that are needed in a state, and of components that the next step keeps; `None` where all
    /// of them have to be found in another way, or, if `whole`, any.
    pub(super) fn adjoint<const D: usize>(
        &mut self,
        system: &mut System<D>,
        (stage, state): (Stage, &Equilibrium),
        (kept, whole): (&[Component], bool),
        copies: &mut Kept<D>,
    ) -> Option<Result<Exact, Reason>> {
        if !self.bears_along_vectors(system) || D == 6 && kept.iter().any(|&(_, component)| component >= 3) {
            return None;
        }
        let probes = &self.design.model.probes;
        let needed = self.needed(stage);
        let plain = |probe: &&usize| probes.operands(**probe).is_none();
        let mut read: Vec<Read> = Vec::new();
        let mut misses = false;
        if needed.iter().any(|&probe| probes.is_stiffness(probe)) {
            system.assemble(false);
        }
        for &quantity in needed.iter().filter(plain) {
            let of_compliance = || {
                let (place, gives_compliance) = probes.compliance(quantity)?;
                let compliance = Some((place, !gives_compliance));
                compliance::pull(system, place).map(|_| (Weights::default(), compliance))
            };
            let found = probes.weights(quantity, state).map(|weights| (weights, None)).or_else(of_compliance);
            match found {
                Some((weights, compliance)) => read.push(Read { quantity, weights, compliance }),
                None if whole => return None,
                None => misses = true,
            }
        }
        for (place, &component) in kept.iter().enumerate() {
            let (quantity, weights) = (probes.len() + place, weights_of(system, component));
            read.push(Read { quantity, weights, compliance: None });
        }
        if read.is_empty() && misses {
            return None;
        }
        let all = self.nearby.take().unwrap_or_else(|| self.problem.nearby(self.row, self.design));
        let Some(all) = all else {
            self.nearby = Some(None);
            return None;
        };
        let found = self.slopes_of(system, (stage, state), (&read, !misses), (&all, kept), copies);
        self.nearby = Some(Some(all));
        // Nobody goes on from the end of the last step, unless neighbours are looked at.
        let is_done = matches!(&found, Some(Ok(exact)) if exact.regular && exact.whole);
        if !is_done || stage.behind() < self.design.steps.len() {
            set_auxiliary(system, packs::AUXILIARY);
        }
        found
    }

    /// The same with what is read at hand, and whether that is all; leaves the system with the auxiliary stiffness that was
    /// taken last.
    fn slopes_of<const D: usize>(
        &self,
        system: &mut System<D>,
        (stage, state): (Stage, &Equilibrium),
        (read, whole): (&[Read], bool),
        (all, kept): (&[Nearby], &[Component]),
        copies: &mut Kept<D>,
    ) -> Option<Result<Exact, Reason>> {
        let (inputs, probes) = (self.row.len(), self.design.model.probes.len());
        let sizes: Vec<f64> = self.row.iter().map(|&value| size(value)).collect();
        let mut limit = Limit::new(&sizes);
        let (mut regular, mut cancelled) = (None, Vec::new());
        let mut parts = vec![f64::NAN; inputs];
        let greatest = Greatest::of(state);
        let floors: Vec<f64> = read.iter().map(|read| self.floor(stage, &greatest, read.quantity)).collect();
        let auxiliaries = if system.loading.holds_strains() { &AUXILIARIES[..ENOUGH] } else { &[packs::AUXILIARY] };
        for &auxiliary in auxiliaries {
            take_auxiliary(system, auxiliary);
            let round = self.round(system, (stage, all, &mut parts), (read, &floors, probes + kept.len()), copies);
            let round = match round? {
                Ok(round) => round,
                Err(reason) => return Some(Err(reason)),
            };
            // What is held gives most with the first of them: motions of second order strain it least then.
            regular
                .get_or_insert_with(|| system.pattern.equations.size == 0 || self.is_regular(system, &round.explicit));
            cancelled.push(round.cancelled);
            if limit.add(round.slopes) {
                break;
            }
        }
        let off: Vec<(f64, usize)> = read.iter().map(|read| limit.off(read.quantity)).collect();
        let mut slopes = limit.take();
        let mut errors = vec![0.0; slopes.len()];
        for ((place, read), (off, count)) in read.iter().enumerate().zip(off) {
            let own = read.quantity * inputs..(read.quantity + 1) * inputs;
            let largest =
                slopes[own.clone()].iter().zip(&sizes).map(|(slope, size)| (slope * size).abs()).fold(0.0, f64::max);
            let cancelled = &cancelled[count - 1][place * inputs..][..inputs];
            for ((error, size), cancelled) in errors[own].iter_mut().zip(&sizes).zip(cancelled) {
                *error = off * largest / size + cancelled + ROUNDED * floors[place] / size;
            }
        }
        for nearby in all {
            for &input in &nearby.inputs {
                self.add_own(system, state, (read, kept), (nearby, input), &mut slopes);
            }
        }
        let regular = regular.unwrap_or(true);
        let estimate =
            |(slope, error): (f64, f64)| if slope.is_finite() { Estimate { slope, error } } else { Estimate::NONE };
        let found: Vec<Estimate> = slopes.into_iter().zip(errors).map(estimate).collect();
        let errors = self.relative(stage, &greatest, &found);
        // A singular point may be near, or wires so stiff that motions of second order count: neighbours tell the two apart.
        Some(Ok(Exact { found, errors, inputs, regular, whole }))
    }

    /// Derivatives with the auxiliary stiffness that the system has, of `count` quantities, some of which are read, each of them measured by
    /// `floors` at least. Parameters are moved by `parts` of them, which become shorter where they are too long.
    fn round<const D: usize>(
        &self,
        system: &mut System<D>,
        (stage, all, parts): (Stage, &[Nearby], &mut [f64]),
        (read, floors, count): (&[Read], &[f64], usize),
        copies: &mut Kept<D>,
    ) -> Option<Result<Round, Reason>> {
        if let Err(reason) = self.wanted() {
            return Some(Err(reason));
        }
        system.assemble(false);
        let mut explicit = self.explicit(system, (stage, all, parts), copies)?;
        let moves = explicit.iter().any(|explicit| explicit.moves);
        system.tangent.transpose();
        let plain: Vec<(usize, &Read)> =
            read.iter().enumerate().filter(|(_, read)| read.compliance.is_none()).collect();
        let adjoints: Option<Vec<(Joints, Joints)>> =
            plain.iter().map(|(_, read)| adjoint_of(system, &read.weights, moves)).collect();
        system.tangent.transpose();
        let Some(adjoints) = adjoints else { return Some(Err(stage.singular())) };
        let inputs = self.row.len();
        let mut slopes = vec![f64::NAN; count * inputs];
        loop {
            let mut far = vec![false; inputs];
            for (&(place, read), (mu, pull)) in plain.iter().zip(&adjoints) {
                let own = &mut slopes[read.quantity * inputs..][..inputs];
                for (slope, explicit) in own.iter_mut().zip(&explicit) {
                    let held = if explicit.moves { product(pull, &explicit.held) } else { 0.0 };
                    *slope = product(mu, &explicit.forces) + held;
                }
                let sizes = || self.row.iter().map(|&value| size(value));
                let largest =
                    own.iter().zip(sizes()).map(|(slope, size)| (slope * size).abs()).fold(floors[place], f64::max);
                for ((far, explicit), size) in far.iter_mut().zip(&explicit).zip(sizes()) {
                    *far |= (product(mu, &explicit.corrections) * size).abs() > CORRECTED * largest;
                }
            }
            let shorter = |input: usize| if far[input] { explicit::shorter(parts[input]) } else { None };
            let nearer: Vec<Option<f64>> = (0..inputs).map(shorter).collect();
            if nearer.iter().all(Option::is_none) {
                break;
            }
            parts.iter_mut().zip(nearer).for_each(|(part, nearer)| *part = nearer.unwrap_or(*part));
            explicit = self.explicit(system, (stage, all, parts), copies)?;
        }
        let loading = &system.loading;
        let rounding =
            CANCELS * if loading.holds_strains() { (loading.auxiliary.member / UP_TO).sqrt().max(1.0) } else { 1.0 };
        let mut cancelled = vec![0.0; read.len() * inputs];
        for (&(place, _), (mu, _)) in plain.iter().zip(&adjoints) {
            for (cancelled, explicit) in cancelled[place * inputs..].iter_mut().zip(&explicit) {
                *cancelled = rounding * work(mu, &explicit.forces);
            }
        }
        if read.iter().any(|read| read.compliance.is_some()) {
            let found = (&mut slopes[..], &mut cancelled[..]);
            self.compliances(system, (stage, all, &explicit), (read, floors), found, copies)?;
        }
        Some(Ok(Round { slopes, cancelled, explicit }))
    }

    /// By how much derivatives may be wrong, over the largest of their quantity.
    fn relative(&self, stage: Stage, greatest: &Greatest, found: &[Estimate]) -> Vec<f64> {
        let inputs = self.row.len();
        let mut errors = vec![0.0; found.len()];
        for (quantity, own) in found.chunks_exact(inputs.max(1)).enumerate() {
            let measure = self.measure(own, self.floor(stage, greatest, quantity));
            for ((error, found), &value) in errors[quantity * inputs..].iter_mut().zip(own).zip(self.row) {
                if found.slope.is_finite() && measure > 0.0 {
                    *error = found.error * size(value) / measure;
                }
            }
        }
        errors
    }

    /// Whether rows bear what they bear along vectors of their own: those that hold a turn in space in part follow that turn.
    fn bears_along_vectors<const D: usize>(&self, system: &System<D>) -> bool {
        let equations = &system.pattern.equations;
        let turns = |held: &Held| {
            let general = equations.is_general(system.topology.links[held.node].joint);
            D == 6 && general && matches!(held.kind, HeldKind::Rotation { .. })
        };
        !equations.held.iter().any(turns)
    }

    /// Adds what quantities change by where nothing moves: by their own numbers, and by those of arms of bodies.
    fn add_own<const D: usize>(
        &self,
        system: &System<D>,
        state: &Equilibrium,
        (read, kept): (&[Read], &[Component]),
        (nearby, input): (&Nearby, usize),
        slopes: &mut [f64],
    ) {
        let model = &self.design.model;
        let places = Places::of(&self.design.structure, &self.design.steps);
        let mover = Mover { design: self.design, nearby, places: &places, input, drives: &[] };
        let far = 2.0 * apart(self.row[input]);
        let owned = |quantity: usize| quantity < model.probes.len() && nearby.is_owned(places.probes + quantity, input);
        let mut around: Option<[Vec<f64>; 4]> = None;
        for Read { quantity, weights, .. } in read {
            let slope = &mut slopes[quantity * self.row.len() + input];
            if owned(*quantity) {
                let values = || {
                    let mut named = state.clone();
                    self.problem.mesh.name_sections(model, &mut named);
                    nearby.around().map(|design: &Design| design.model.probes.evaluate(&named, &[]))
                };
                let around = around.get_or_insert_with(values);
                *slope += nearby::change(around.each_ref().map(|values| values[*quantity])) / far;
            }
            for &(node, weight) in &weights.reactions {
                let rows = system.pattern.equations.held.iter().enumerate().filter(|(_, held)| held.node == node);
                for (row, held) in rows {
                    let turn = mover.axis(node, held.component);
                    if turn != [0.0; 3] {
                        let offset = if matches!(held.kind, HeldKind::Rotation { .. }) { 3 } else { 0 };
                        let along = dot(turn, [weight[offset], weight[offset + 1], weight[offset + 2]]) / far;
                        *slope += system.reaction_along(row) * along;
                    }
                }
            }
            if let Some(&(node, component)) = quantity.checked_sub(model.probes.len()).and_then(|place| kept.get(place))
            {
                *slope += dot(mover.axis(node, component), state.nodes[node].displacement) / far;
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

    /// Moves on by a small part of all parameters at once, and looks at what the tangent makes of what is left there: next to
    /// a limit point it is another one.
    fn is_regular<const D: usize>(&self, system: &mut System<D>, explicit: &[Explicit]) -> bool {
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
            let moved = system.tangent_times(&held);
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
        // Reactions are read afterwards.
        system.gather(false);
        regular
    }
}

pub(super) fn add_times(sum: &mut Joints, times: f64, joints: &Joints) {
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
        let joint = system.topology.links[node].joint;
        let mut shares = Vec::new();
        for (row, held) in system.pattern.equations.held.iter().enumerate().filter(|(_, held)| held.node == node) {
            let (vector, offset) = match held.kind {
                HeldKind::Translation { direction } => (direction, 0),
                HeldKind::Rotation { axis } => (axis, 3),
            };
            let along = dot(vector, [weight[offset], weight[offset + 1], weight[offset + 2]]);
            if system.pattern.equations.is_general(joint) {
                shares.push((row, along));
                continue;
            }
            for c in 0..3 {
                forces[joint][offset + c] += along * vector[c];
            }
        }
        if !shares.is_empty() {
            let own = system.along_rows(joint, &shares);
            forces[joint].iter_mut().zip(own).for_each(|(sum, share)| *sum += share);
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

/// The work of forces along motions.
fn product(a: &Joints, b: &Joints) -> f64 {
    a.iter().zip(b).map(|(a, b)| dot6(a, b)).sum()
}

/// The same with each part taken by itself.
fn work(a: &Joints, b: &Joints) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.iter().zip(b).map(|(a, b)| (a * b).abs()).sum::<f64>()).sum()
}

fn dot6(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
