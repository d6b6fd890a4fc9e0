//! Whether a state is an equilibrium, found out without the solver: from positions, rotations and member end forces alone.
//!
//! Joints: the actions of members, springs and loads add up to the reaction, about the reference of the body if there is one.
//! Members: the equations of the rod are integrated from a welded end, with the pose and the actions there, by the
//! classical Runge-Kutta formula; they must arrive at the other end.

use std::collections::HashMap;

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use pennate_solver::history::Equilibrium;
use pennate_solver::structure::{Dimension, Drive, Release, Segment, Spring, Structure};

use super::network::{Network, Vector};
use super::shapes::unloaded;

/// Steps of an integration along a member.
const STEPS: usize = 200;
/// √(force / bending stiffness) × length beyond which errors of the start grow more than a thousandfold on the way.
const STIFF: f64 = 6.0;

/// What is left at joints that are in balance.
const BALANCED: f64 = 1e-9;

/// What is left of the equations.
#[derive(Clone, Copy, Debug, Default)]
pub struct Residual {
    /// Of the joints: forces over the largest force, moments over the largest moment (no smaller than force times length).
    pub joints: f64,
    /// Of the members: distance of the integrated end from the node, over the length.
    pub members: f64,
    /// Of what is held: distance from where it was told to be, in lengths of a member or radians.
    pub places: f64,
    /// Members that were integrated.
    pub integrated: usize,
}

impl Residual {
    /// The larger of two, for states checked one after the other.
    pub fn join(&mut self, other: &Self) {
        self.joints = self.joints.max(other.joints);
        self.members = self.members.max(other.members);
        self.places = self.places.max(other.places);
        self.integrated += other.integrated;
    }
}

/// Checks a state under the values of its drives, and what is left of reactions that fade: node, component, value.
pub fn residual(network: &Network, state: &Equilibrium, values: &[f64], fading: &[(usize, usize, f64)]) -> Residual {
    let joints = unbalanced(&network.structure, state, values, fading);
    let mut residual = Residual { joints, ..Residual::default() };
    for member in 0..network.structure.members.len() {
        if let Some(miss) = integrate(network, state, values, member) {
            residual.members = residual.members.max(miss);
            residual.integrated += 1;
        }
    }
    residual
}

struct Poses<'a> {
    structure: &'a Structure,
    state: &'a Equilibrium,
}

impl Poses<'_> {
    fn place(&self, node: usize) -> Vector {
        Vector::from(self.structure.nodes[node]) + Vector::from(self.state.nodes[node].displacement)
    }

    fn rotation(&self, node: usize) -> Rotation3<f64> {
        Rotation3::new(Vector::from(self.state.nodes[node].rotation))
    }
}

/// What is left at the joints of a state under the values of its drives: forces over the largest force, moments over the
/// largest moment.
///
/// A rotation is given without its whole turns, which springs know: for each of them those count that leave least.
pub fn unbalanced(structure: &Structure, state: &Equilibrium, values: &[f64], fading: &[(usize, usize, f64)]) -> f64 {
    let mut turns = vec![0; structure.springs.len()];
    let mut least = joints(structure, state, values, fading, &turns);
    for spring in 0..turns.len() {
        let mut best = turns[spring];
        for whole in [-2, -1, 1, 2] {
            if least <= BALANCED {
                break;
            }
            turns[spring] = whole;
            let left = joints(structure, state, values, fading, &turns);
            if left < least {
                (least, best) = (left, whole);
            }
        }
        turns[spring] = best;
    }
    least
}

fn joints(
    structure: &Structure,
    state: &Equilibrium,
    values: &[f64],
    fading: &[(usize, usize, f64)],
    turns: &[i32],
) -> f64 {
    let poses = Poses { structure, state };
    let mut sums = vec![(Vector::zeros(), Vector::zeros()); structure.nodes.len()];
    let (mut force_scale, mut moment_scale) = (1e-9f64, 1e-9f64);
    let mut act = |node: usize, force: Vector, moment: Vector| {
        sums[node].0 += force;
        sums[node].1 += moment;
        force_scale = force_scale.max(force.norm());
        moment_scale = moment_scale.max(moment.norm());
    };
    for (member, now) in structure.members.iter().zip(&state.members) {
        for end in 0..2 {
            act(member.nodes[end], -Vector::from(now.end_forces[end]), -Vector::from(now.end_moments[end]));
        }
    }
    for (spring, &turns) in structure.springs.iter().zip(turns) {
        spring_actions(&poses, spring, turns, &mut act);
    }
    for (drive, &value) in structure.drives.iter().zip(values) {
        let unit = |component: usize| value * Vector::ith(component, 1.0);
        match *drive {
            Drive::Force(node, c) => act(node, unit(c), Vector::zeros()),
            Drive::Moment(node, c) => act(node, Vector::zeros(), unit(c)),
            Drive::FollowerForce(node, c) => act(node, poses.rotation(node) * unit(c), Vector::zeros()),
            Drive::FollowerMoment(node, c) => act(node, Vector::zeros(), poses.rotation(node) * unit(c)),
            // These act along members; bodies have no mass.
            Drive::Control | Drive::Distributed(..) | Drive::Gravity(_) => {}
        }
    }
    for &(node, component, value) in fading {
        let unit = value * Vector::ith(component % 3, 1.0);
        if component < 3 { act(node, unit, Vector::zeros()) } else { act(node, Vector::zeros(), unit) }
    }
    for (node, now) in state.nodes.iter().enumerate() {
        act(node, now.reaction_force.into(), now.reaction_moment.into());
    }
    // A body takes the actions on its nodes to its reference.
    let mut owner: HashMap<usize, usize> = HashMap::new();
    for body in &structure.bodies {
        owner.extend(body.nodes.iter().map(|&node| (node, body.reference)));
    }
    let mut totals: HashMap<usize, (Vector, Vector)> = HashMap::new();
    for (node, &(force, moment)) in sums.iter().enumerate() {
        let at = owner.get(&node).copied().unwrap_or(node);
        let total = totals.entry(at).or_default();
        total.0 += force;
        total.1 += moment + (poses.place(node) - poses.place(at)).cross(&force);
    }
    moment_scale = moment_scale.max(force_scale * super::network::LENGTH);
    totals.values().fold(0.0, |worst, (f, m)| worst.max(f.norm() / force_scale).max(m.norm() / moment_scale))
}

fn spring_actions(poses: &Poses, spring: &Spring, turns: i32, act: &mut impl FnMut(usize, Vector, Vector)) {
    match *spring {
        Spring::Axial { nodes: [a, b], stiffness, natural_length } => {
            let chord = poses.place(b) - poses.place(a);
            let force = stiffness * (chord.norm() - natural_length) * chord.normalize();
            act(a, force, Vector::zeros());
            act(b, -force, Vector::zeros());
        }
        Spring::Ground { node, stiffness: k } => {
            let u = Vector::from(poses.state.nodes[node].displacement);
            let moment = gradient(&turn(&poses.rotation(node), turns), &k);
            act(node, -Vector::new(k[0] * u.x, k[1] * u.y, k[2] * u.z), -moment);
        }
        Spring::Coupling { nodes: [a, b], stiffness: k } => {
            let [from, to] = [a, b].map(|node| poses.rotation(node));
            let [before, now] = [
                Vector::from(poses.structure.nodes[b]) - Vector::from(poses.structure.nodes[a]),
                poses.place(b) - poses.place(a),
            ];
            let d = from.inverse() * now - before;
            let force = from * Vector::new(k[0] * d.x, k[1] * d.y, k[2] * d.z);
            let moment = from * gradient(&turn(&(from.inverse() * to), turns), &k);
            act(b, -force, -moment);
            act(a, force, moment + now.cross(&force));
        }
    }
}

/// The rotation vector of a rotation and so many whole turns about its axis.
fn turn(rotation: &Rotation3<f64>, turns: i32) -> Vector {
    let theta = UnitQuaternion::from_rotation_matrix(rotation).scaled_axis();
    let angle = theta.norm();
    if angle > 0.0 { theta * (1.0 + f64::from(turns) * std::f64::consts::TAU / angle) } else { theta }
}

/// Moment of ½ Σ kᵢ θᵢ²: its derivative by a spin, T⁻ᵀ(θ) k θ.
fn gradient(theta: &Vector, k: &[f64; 6]) -> Vector {
    let g = Vector::new(k[3] * theta.x, k[4] * theta.y, k[5] * theta.z);
    let angle = theta.norm();
    let eta = if angle < 1e-2 { 1.0 / 12.0 } else { (1.0 - 0.5 * angle / (0.5 * angle).tan()) / (angle * angle) };
    let skew = theta.cross_matrix();
    // δθ = (I − ½ S + η S²) δω; transposed, the sign of S changes.
    (Matrix3::identity() + 0.5 * skew + eta * skew * skew) * g
}

/// By how much the rod that begins at a welded end misses its other end, over its length.
fn integrate(network: &Network, state: &Equilibrium, values: &[f64], index: usize) -> Option<f64> {
    let structure = &network.structure;
    let (member, now) = (&structure.members[index], &state.members[index]);
    let start = (0..2).find(|&end| member.releases[end] == Release::Welded)?;
    let control = member.control.map_or(0.0, |drive| values[drive]);
    let length: f64 = member.segments.iter().map(|segment| segment.length).sum();
    let laws = member.segments.iter().map(|segment| &network.laws[segment.law]);
    let softest = laws.map(|law| law.section(control)).fold(f64::INFINITY, |ei, s| ei.min(s.ei2).min(s.ei3));
    let largest = Vector::from(now.end_forces[0]).norm().max(Vector::from(now.end_forces[1]).norm());
    if (largest / softest).sqrt() * length > STIFF {
        return None;
    }
    let poses = Poses { structure, state };
    let mut load = Vector::zeros();
    let mut gravity = Vector::zeros();
    for (drive, &value) in structure.drives.iter().zip(values) {
        match *drive {
            Drive::Distributed(of, c) if of == index => load[c] += value,
            Drive::Gravity(c) => gravity[c] += value,
            _ => {}
        }
    }
    let sign = if start == 0 { 1.0 } else { -1.0 };
    let first = Matrix3::from_columns(&member.axes.map(Vector::from));
    let frames = [first, first * unloaded(&member.segments).1.matrix()];
    let mut rod = Rod {
        place: poses.place(member.nodes[start]),
        frame: poses.rotation(member.nodes[start]) * frames[start],
        // The section force at the start is what the part beyond exerts: minus the action there, seen along the rod.
        force: -sign * Vector::from(now.end_forces[start]),
        moment: -sign * Vector::from(now.end_moments[start]),
    };
    let mut order: Vec<&Segment> = member.segments.iter().collect();
    if start == 1 {
        order.reverse();
    }
    for segment in order {
        let law = &network.laws[segment.law];
        let section = law.section(control);
        let initial = Vector::from(segment.initial_curvature);
        let load = load + section.mass_per_length * gravity;
        let rate = |rod: &Rod| {
            let n = rod.frame.transpose() * rod.force;
            let m = rod.frame.transpose() * rod.moment;
            let gamma =
                Vector::new(1.0 + control * law.strain + n.x / section.ea, n.y / section.ga2, n.z / section.ga3);
            let bent = Vector::new(m.x / section.gj, m.y / section.ei2, m.z / section.ei3 + control * law.curvature);
            let kappa = initial + bent;
            let tangent = rod.frame * gamma;
            Rod {
                place: tangent,
                frame: rod.frame * kappa.cross_matrix(),
                force: -load,
                moment: -tangent.cross(&rod.force),
            }
        };
        let steps = (STEPS as f64 * segment.length / length).ceil();
        let h = sign * segment.length / steps;
        for _ in 0..steps as usize {
            let k1 = rate(&rod);
            let k2 = rate(&rod.plus(&k1, 0.5 * h));
            let k3 = rate(&rod.plus(&k2, 0.5 * h));
            let k4 = rate(&rod.plus(&k3, h));
            rod = rod.plus(&k1, h / 6.0).plus(&k2, h / 3.0).plus(&k3, h / 3.0).plus(&k4, h / 6.0);
        }
    }
    let other = 1 - start;
    let mut miss = (rod.place - poses.place(member.nodes[other])).norm() / length;
    if member.releases[other] == Release::Welded {
        let end = poses.rotation(member.nodes[other]) * frames[other];
        miss = miss.max((rod.frame - end).norm());
    }
    debug_assert!(structure.dimension == Dimension::Space || rod.place.z == 0.0);
    Some(miss)
}

/// Place, frame and section forces of a rod at one point, or their rates.
struct Rod {
    place: Vector,
    frame: Matrix3<f64>,
    force: Vector,
    moment: Vector,
}

impl Rod {
    fn plus(&self, rate: &Self, step: f64) -> Self {
        Self {
            place: self.place + step * rate.place,
            frame: self.frame + step * rate.frame,
            force: self.force + step * rate.force,
            moment: self.moment + step * rate.moment,
        }
    }
}
