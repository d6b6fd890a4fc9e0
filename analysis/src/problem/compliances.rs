//! Derivatives of compliances and stiffnesses, by tangents along the way of each parameter.

use pennate_elements::rotation::turn;
use pennate_elements::small::{add, cross, dot, scale, sub};
use pennate_solver::compliance::{self, Pull};
use pennate_solver::system::System;

use super::adjoint::{Read, add_times};
use super::explicit::{self, Explicit, Joints, Kept, TIMES};
use super::moved::Mover;
use super::nearby::{Nearby, apart, size};
use super::numbers::Places;
use super::slopes::{Slopes, Stage};

/// The part of a parameter at which tangents are compared, and the longest one, where rounding counts. Joints move with it, so that members are
/// strained as little as they are along it: by motions of second order, which the square of the slenderness makes a stress. Four times the
/// first one left 3e-7 of a derivative beside an arc whose rise follows the square of a radius.
const FOR_STIFFNESS: f64 = 5e-4;
const LONGEST: f64 = 2e-3;
/// Part of what entries of a stiffness add to its work along a motion that rounding leaves of its changes.
const ROUNDED: f64 = 3e-16;

/// What a compliance changes by with the stiffness of the network along a parameter.
struct Softening {
    slope: f64,
    /// By how much that differs from what the nearer distance tells alone.
    correction: f64,
    /// Over which distance it was found.
    distance: f64,
}

impl Slopes<'_> {
    /// Derivatives of what is read of compliances, and what rounding may leave of them.
    ///
    /// With w · u, K u = w, and joints that move by d' along a parameter, a compliance changes by 2 w' · u − u · K' u: of the tangent
    /// K' is what it changes by along d' and the parameter at once. Apart these would be large, and nearly cancel.
    pub(super) fn compliances<const D: usize>(
        &self,
        system: &mut System<D>,
        (stage, all, explicit): (Stage, &[Nearby], &[Explicit]),
        (read, floors): (&[Read], &[f64]),
        (slopes, cancelled): (&mut [f64], &mut [f64]),
        copies: &mut Kept<D>,
    ) -> Option<()> {
        let inputs = self.row.len();
        let asked =
            || read.iter().enumerate().filter_map(|(place, read)| Some((place, read.quantity, read.compliance?)));
        let pulls: Option<Vec<Pull>> = asked().map(|(.., (index, _))| compliance::pull(system, index)).collect();
        let pulls = pulls?;
        let ways: Option<Vec<Joints>> = explicit.iter().map(|explicit| way_along(system, explicit)).collect();
        let ways = ways?;
        let mut parts = vec![FOR_STIFFNESS; inputs];
        asked().for_each(|(place, ..)| cancelled[place * inputs..][..inputs].fill(f64::INFINITY));
        loop {
            let softenings = self.softenings(system, (stage, all, &parts), (&pulls, &ways), copies);
            let (mut far, mut near) = (vec![false; inputs], vec![false; inputs]);
            for ((place, quantity, (_, is_inverse)), (at, pull)) in asked().zip(pulls.iter().enumerate()) {
                // What is read of a compliance c is c, or 1 / c.
                let times = if is_inverse { -pull.compliance.powi(-2) } else { 1.0 };
                let slopes = &mut slopes[quantity * inputs..][..inputs];
                let errors = &mut cancelled[place * inputs..][..inputs];
                let mut found = vec![[0.0; 2]; inputs];
                for (input, softenings) in softenings.iter().enumerate() {
                    let softening = &softenings[at];
                    let rounding = ROUNDED * (times * pull.terms / softening.distance).abs();
                    let left = times.abs() * explicit::left_of(softening.slope, softening.correction);
                    // Another distance may leave more: then the one before stands.
                    if !(rounding + left >= errors[input]) {
                        let by_lever = self.by_lever(system, all, pull, (input, &ways[input]));
                        slopes[input] = times * (softening.slope + by_lever);
                        errors[input] = rounding + left;
                        found[input] = [rounding, left];
                    }
                }
                let largest = slopes
                    .iter()
                    .zip(self.row)
                    .map(|(slope, &value)| (slope * size(value)).abs())
                    .fold(floors[place], f64::max);
                for (input, [rounding, left]) in found.into_iter().enumerate() {
                    let counts = |error: f64| error * size(self.row[input]) > explicit::LEFT * largest;
                    far[input] |= counts(left) && explicit::SHORTER * rounding < left;
                    near[input] |= counts(rounding) && left < rounding;
                }
            }
            let mut is_last = true;
            for ((part, far), near) in parts.iter_mut().zip(far).zip(near) {
                let next = match (far, near) {
                    (true, _) => explicit::shorter(*part),
                    (false, true) if *part == FOR_STIFFNESS => Some(LONGEST),
                    _ => None,
                };
                if let Some(next) = next {
                    (*part, is_last) = (next, false);
                }
            }
            if is_last {
                return Some(());
            }
        }
    }

    /// What a compliance changes by with the lever of its node along a parameter, as joints move this way along it.
    fn by_lever<const D: usize>(
        &self,
        system: &System<D>,
        all: &[Nearby],
        pull: &Pull,
        (input, way): (usize, &Joints),
    ) -> f64 {
        let link = system.topology.links[pull.node];
        let rotation = system.places.joints[link.joint].place.rotation;
        let [_, _, _, rx, ry, rz] = way[link.joint];
        let turned = cross([rx, ry, rz], turn(rotation, link.arm));
        let places = Places::of(&self.design.structure, &self.design.steps);
        let placed = all.iter().find(|nearby| nearby.inputs.contains(&input)).map_or([0.0; 3], |nearby| {
            let mover = Mover { design: self.design, nearby, places: &places, input, drives: &[] };
            let arm = sub(mover.node(pull.node), mover.node(system.topology.references[link.joint]));
            turn(rotation, scale(0.5 / apart(self.row[input]), arm))
        });
        dot(pull.by_lever, add(turned, placed))
    }

    /// What the compliances of these pulls change by with the stiffness of the network along every parameter, while joints move as they do
    /// along it; by differences at these parts of the parameters.
    fn softenings<const D: usize>(
        &self,
        system: &System<D>,
        (stage, all, parts): (Stage, &[Nearby], &[f64]),
        (pulls, ways): (&[Pull], &[Joints]),
        kept: &mut Kept<D>,
    ) -> Vec<Vec<Softening>> {
        let places = Places::of(&self.design.structure, &self.design.steps);
        let rates = self.rates(stage, all, &places);
        let movers = self.movers(all, &places, &rates);
        let moved = self.moved(system, (&movers, parts, true), &mut kept.works);
        let far = |input: usize| parts[input] * size(self.row[input]);
        let moves = |mover: &Mover<'_>| {
            TIMES.map(|times| {
                let by = times * far(mover.input);
                ways[mover.input].iter().map(|way| way.map(|x| by * x)).collect::<Joints>()
            })
        };
        let moves: Vec<Joints> = movers.iter().flat_map(moves).collect();
        let works = moved.copies.works(system, &moved.drives, &moves, pulls);
        let mut found: Vec<Vec<Softening>> = (0..self.row.len()).map(|_| Vec::new()).collect();
        for (works, mover) in works.chunks_exact(TIMES.len()).zip(&movers) {
            let far = far(mover.input);
            let softening = |place: usize| {
                let slope = |at: usize| (works[at][place] - works[at + 1][place]) / (2.0 * far * TIMES[at]);
                let correction = (slope(2) - slope(0)) / 3.0;
                Softening { slope: correction - slope(0), correction, distance: far }
            };
            found[mover.input] = (0..pulls.len()).map(softening).collect();
        }
        found
    }
}

/// How the joints move along a parameter, by the factors at hand; `None` where they do not tell.
fn way_along<const D: usize>(system: &mut System<D>, explicit: &Explicit) -> Option<Joints> {
    let mut forces = explicit.forces.clone();
    if explicit.moves {
        let moved = system.tangent_times(&explicit.held);
        add_times(&mut forces, 1.0, &moved);
    }
    let mut solution = vec![0.0; system.pattern.equations.size];
    for (joint, force) in forces.iter().enumerate() {
        system.pattern.equations.project(joint, &force.map(|force| -force), &mut solution);
    }
    if !system.tangent.solve(&mut solution) {
        return None;
    }
    let mut way = system.pattern.motions_of(&solution);
    add_times(&mut way, 1.0, &explicit.held);
    Some(way)
}
