//! The equations of the joints, linearized at a state: what is left of them, their matrix and its factors.

use pennate_elements::small::dot;

use super::Pattern;
use super::loading::Loading;
use super::scatter::unit_motion;
use super::skew::Skew;
use crate::chain::any;
use crate::linear::{Pivots, Symmetric};
use crate::reduce::ReleaseFactor;
use crate::structure::MemberId;

/// Part of its diagonal that is added to a tangent without an inverse, to find what it does not resist: far more than rounding, and far
/// less than what a soft network has.
const BESIDE: f64 = 1e-12;
/// Part of the smallest pivot of the unloaded structure that is far from none.
const FIRM: f64 = 0.5;

/// Largest residual of the joints, over the scale of its kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    /// Of forces, over the largest force that acts on a joint.
    pub force: f64,
    /// Of moments, over the largest moment that acts on a joint.
    pub moment: f64,
    /// Index of the joint where most is left.
    pub worst_joint: usize,
    /// Component there: 0, 1, 2 of force, 3, 4, 5 of moment.
    pub worst_component: usize,
}

impl Residual {
    /// The larger of both.
    pub(crate) fn largest(&self) -> f64 {
        self.force.max(self.moment)
    }
}

/// Pivots of a whole network: joints, interiors, released ends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inertia {
    /// Negative pivots.
    pub negative: usize,
    /// Pivots that are rounding.
    pub neutral: usize,
    /// Pivots that would be rounding in an unloaded structure, neutral ones included.
    pub idle: usize,
    /// The smallest pivot, over the largest stiffness of its component.
    pub smallest: f64,
    /// Sign of the determinant of the unsymmetric correction.
    pub skew_negative: bool,
}

impl Inertia {
    /// Whether the determinant of the whole tangent is negative.
    pub fn is_odd(&self) -> bool {
        (self.negative % 2 == 1) != self.skew_negative
    }
}

/// What an assembly sums over members, springs and loads, but for the matrix.
pub(super) struct Sums {
    forces: Vec<[f64; 6]>,
    stiffness: Vec<[f64; 6]>,
    scales: [f64; 2],
    released: [usize; 2],
    idle_members: Vec<MemberId>,
}

/// Residual and tangent at the state of the last assembly.
///
/// What needs an equilibrium reads it here: it says nothing of a state that was moved since.
pub struct Tangent<const D: usize> {
    /// The symmetric part of the tangent of the joints, and its factors.
    pub linear: Symmetric,
    /// Internal less external force of every joint.
    pub forces: Vec<[f64; 6]>,
    /// The same in the equations of the joints.
    pub rhs: Vec<f64>,
    /// Forces on the ends of every member.
    pub ends: Vec<[[f64; 6]; 2]>,
    /// Factors of the released rotations of every member.
    pub releases: Vec<ReleaseFactor>,
    /// Forces of axial springs, positive in tension; zero of others.
    pub spring_forces: Vec<f64>,
    /// Energy of all springs.
    pub spring_energy: f64,
    /// Largest force that acts on a joint.
    pub force_scale: f64,
    /// Largest moment that acts on a joint, no smaller than 1e-3 of force times size.
    pub moment_scale: f64,
    /// Members with a released rotation that nothing resists.
    pub idle_members: Vec<MemberId>,
    /// Whether the matrix stays what it is while forces are put together anew.
    pub(super) keeps_matrix: bool,
    /// What has no potential.
    pub(super) skew: Skew,
    pub(super) released_neutral: usize,
    pub(super) released_negative: usize,
    pub(super) inertia: Inertia,
    pub(super) linearizations: u64,
    /// Sum of the stiffness of members and springs on every component where the matrix is from, and the same of the unloaded
    /// structure.
    pub(super) stiffness: Vec<[f64; 6]>,
    rest_stiffness: Vec<[f64; 6]>,
    /// The smallest pivot of the unloaded structure; infinite where it is not known.
    rest_smallest: f64,
}

impl<const D: usize> Tangent<D> {
    /// Of nothing yet.
    pub(super) fn new(joints: usize, members: usize, springs: usize) -> Self {
        Self {
            linear: Symmetric::new(0, &mut Vec::new(), false),
            forces: vec![[0.0; 6]; joints],
            rhs: Vec::new(),
            ends: vec![[[0.0; 6]; 2]; members],
            releases: vec![ReleaseFactor::default(); members],
            spring_forces: vec![0.0; springs],
            spring_energy: 0.0,
            force_scale: 0.0,
            moment_scale: 0.0,
            idle_members: Vec::new(),
            keeps_matrix: false,
            skew: Skew::default(),
            released_neutral: 0,
            released_negative: 0,
            inertia: Inertia::default(),
            linearizations: 0,
            stiffness: vec![[0.0; 6]; joints],
            rest_stiffness: vec![[0.0; 6]; joints],
            rest_smallest: f64::INFINITY,
        }
    }

    /// The same in the memory at hand, of as many joints, members and springs. Factors are made before they are read.
    pub(super) fn renew(&mut self) {
        self.keeps_matrix = false;
        self.clear();
        self.skew = Skew::default();
        self.inertia = Inertia::default();
        self.ends.fill([[0.0; 6]; 2]);
        self.spring_forces.fill(0.0);
        self.spring_energy = 0.0;
        self.rest_stiffness.fill([0.0; 6]);
        self.rest_smallest = f64::INFINITY;
        self.linear.rest.fill(0.0);
    }

    /// Takes the memory for other equations.
    pub(super) fn resize(&mut self, linear: Symmetric, pattern: &Pattern<D>) {
        self.linear = linear;
        self.rhs = vec![0.0; pattern.equations.size];
        self.skew = Skew::default();
        self.measure_by_rest(pattern);
    }

    /// Empties it before an assembly.
    pub(super) fn clear(&mut self) {
        if !self.keeps_matrix {
            self.linear.clear();
            self.stiffness.fill([0.0; 6]);
        }
        self.forces.fill([0.0; 6]);
        (self.force_scale, self.moment_scale) = (0.0, 0.0);
        (self.released_neutral, self.released_negative) = (0, 0);
        self.idle_members.clear();
    }

    /// What was summed at the last assembly.
    pub(super) fn sums(&self) -> Sums {
        Sums {
            forces: self.forces.clone(),
            stiffness: self.stiffness.clone(),
            scales: [self.force_scale, self.moment_scale],
            released: [self.released_negative, self.released_neutral],
            idle_members: self.idle_members.clone(),
        }
    }

    /// Goes back to what was summed then.
    pub(super) fn set_sums(&mut self, sums: Sums) {
        let Sums { forces, stiffness, scales, released, idle_members } = sums;
        (self.forces, self.stiffness, self.idle_members) = (forces, stiffness, idle_members);
        [self.force_scale, self.moment_scale] = scales;
        [self.released_negative, self.released_neutral] = released;
    }

    /// A number that changes with every linearization: what was found at one holds until the next.
    pub fn linearizations(&self) -> u64 {
        self.linearizations
    }

    /// Pivots of the last assembly.
    pub fn inertia(&self) -> Inertia {
        self.inertia
    }

    /// Takes a force and a moment on a joint into the scales of both.
    pub(super) fn note_scale(&mut self, force: &[f64; 6]) {
        let [f0, f1, f2, m0, m1, m2] = *force;
        self.note_squares([[f0, f1, f2], [m0, m1, m2]].map(|part| dot(part, part)));
    }

    /// The same by their squares. Few are larger than all before, and roots take long.
    #[inline]
    pub(super) fn note_squares(&mut self, [force, moment]: [f64; 2]) {
        if force > self.force_scale * self.force_scale {
            self.force_scale = self.force_scale.max(force.sqrt());
        }
        if moment > self.moment_scale * self.moment_scale {
            self.moment_scale = self.moment_scale.max(moment.sqrt());
        }
    }

    /// Factorizes what was assembled; `inertia` is that of the interiors of the members.
    pub(super) fn factorize(&mut self, mut inertia: Inertia) -> Inertia {
        let Pivots { negative, neutral, idle, smallest } = self.linear.factorize();
        inertia.negative += negative + self.released_negative;
        inertia.neutral += neutral + self.released_neutral;
        inertia.idle += idle + self.released_neutral;
        inertia.smallest = inertia.smallest.min(smallest);
        self.factorize_skew(&mut inertia);
        inertia
    }

    /// Takes the stiffness of the last assembly as that of the unloaded structure, which pivots are measured by.
    pub fn note_rest(&mut self, pattern: &Pattern<D>) {
        self.rest_stiffness.copy_from_slice(&self.stiffness);
        self.rest_smallest = self.inertia.smallest;
        self.measure_by_rest(pattern);
    }

    /// Takes the stiffness of the unloaded structure from the same structure on another mesh.
    pub(crate) fn take_rest(&mut self, pattern: &Pattern<D>, other: &Self) {
        self.rest_stiffness.copy_from_slice(&other.rest_stiffness);
        self.rest_smallest = other.rest_smallest;
        self.measure_by_rest(pattern);
    }

    /// Whether no pivot of the last assembly is negative or much smaller than the smallest of the unloaded structure.
    pub(crate) fn is_firm(&self) -> bool {
        let Inertia { negative, neutral, smallest, .. } = self.inertia;
        negative + neutral == 0 && smallest >= FIRM * self.rest_smallest
    }

    fn measure_by_rest(&mut self, pattern: &Pattern<D>) {
        for joint in 0..self.rest_stiffness.len() {
            let equations = &pattern.equations.joints[joint];
            for e in 0..equations.count {
                let mut local = [0.0; 6];
                local[e] = 1.0;
                let motion = unit_motion(&pattern.equations, joint, &local[..equations.count]);
                let sum: f64 = (0..6).map(|c| motion[c] * motion[c] * self.rest_stiffness[joint][c].abs()).sum();
                self.linear.rest[equations.first + e] = sum;
            }
        }
    }

    /// Mean stiffness of the unloaded joints against displacements.
    pub(crate) fn rest_stiffness_of_displacements(&self) -> f64 {
        let sum: f64 = self.rest_stiffness.iter().map(|k| k[..3].iter().sum::<f64>()).sum();
        sum / (3 * self.rest_stiffness.len().max(1)) as f64
    }

    /// What residuals of forces and moments are measured by: the largest of their kind, and no less than what rounding
    /// makes of the stiffness.
    pub(super) fn scales(&self, loading: &Loading, size: f64) -> (f64, f64) {
        let (force, moment, noise) = (self.force_scale, self.moment_scale, loading.noise());
        (
            force.max(1e-3 * moment / size).max(noise[0]).max(f64::MIN_POSITIVE),
            moment.max(1e-3 * force * size).max(noise[1]).max(f64::MIN_POSITIVE),
        )
    }

    /// Residual of the joints, forces and moments apart.
    pub(super) fn residual(&self, pattern: &Pattern<D>, loading: &Loading, size: f64) -> Residual {
        // Largest force and moment, of which joint and component. What is not a number is larger than all.
        let mut largest = [(0.0, 0, 0); 2];
        let mut contradicts = false;
        for joint in 0..self.forces.len() {
            let [shift, turn] = pattern.equations.missed[joint];
            contradicts |= shift > 1e-9 * size || turn > 1e-9;
            if pattern.equations.holds_all(joint) {
                continue;
            }
            let free = pattern.equations.unbalanced(joint, &self.forces[joint]);
            for &c in &pattern.equations.active {
                let (x, largest) = (free[c].abs(), &mut largest[usize::from(c >= 3)]);
                if !(x <= largest.0) {
                    *largest = (if x.is_nan() { f64::INFINITY } else { x }, joint, c);
                }
            }
        }
        let (force_scale, moment_scale) = self.scales(loading, size);
        let over = |x: f64, scale: f64| if x.is_infinite() { x } else { x / scale };
        let [force, moment] = [over(largest[0].0, force_scale), over(largest[1].0, moment_scale)];
        let (_, worst_joint, worst_component) = largest[usize::from(moment > force)];
        // Rows that contradict each other are no equilibrium, whatever the forces.
        let force = if contradicts { force.max(1.0) } else { force };
        Residual { force, moment, worst_joint, worst_component }
    }

    /// The stiffness against forces, and moments of `size` times as much, that single out no motion; `None` where there are no
    /// factors. It is small against that of another state where the tangent is nearly singular.
    pub(crate) fn overall_stiffness(&mut self, pattern: &Pattern<D>, size: f64) -> Option<f64> {
        self.singular_test_of_all(pattern, size).map(f64::abs)
    }

    /// The same with its sign, which changes where the tangent is singular, and where the stiffness is beyond all bounds. Forces are those of
    /// every part by itself, whatever others there are.
    pub(crate) fn singular_test_of_all(&mut self, pattern: &Pattern<D>, size: f64) -> Option<f64> {
        let mut joints = vec![0; pattern.parts.count];
        let force = |&part: &usize| -> [f64; 6] {
            let joint = joints[part];
            joints[part] += 1;
            std::array::from_fn(|c| any(6 * joint + c) * if c < 3 { 1.0 } else { size })
        };
        let forces: Vec<[f64; 6]> = pattern.parts.joints.iter().map(force).collect();
        self.singular_test(&pattern.along_equations(&forces))
    }

    /// The softest motion, by inverse iteration on the factors; the largest part of it is positive, and of size one (in lengths of
    /// the network, `size`, or radians).
    pub(crate) fn softest_motion(&mut self, pattern: &Pattern<D>, size: f64) -> Vec<f64> {
        self.softest_motion_after(6, pattern, size)
    }

    /// The same after so many iterations: where others are nearly as soft few leave some of these in it.
    pub(crate) fn softest_motion_after(&mut self, iterations: usize, pattern: &Pattern<D>, size: f64) -> Vec<f64> {
        let begin = (0..self.linear.size()).map(|i| any(i) / self.weight(i).sqrt()).collect();
        self.softest_motion_from(begin, iterations, pattern, size)
    }

    /// The same from what these motions of the joints have of it: of equally soft ones that which they are made of.
    pub(crate) fn softest_motion_in(
        &mut self,
        motions: &[[f64; 6]],
        iterations: usize,
        pattern: &Pattern<D>,
        size: f64,
    ) -> Vec<f64> {
        self.softest_motion_from(pattern.along_equations(motions), iterations, pattern, size)
    }

    /// What motions are weighed by, so that an iteration for the softest one is indifferent to units.
    fn weight(&self, row: usize) -> f64 {
        self.linear.diagonal(row).abs().max(self.linear.rest[row]).max(f64::MIN_POSITIVE)
    }

    /// The same from this solution, which the iteration goes on from.
    pub(crate) fn softest_motion_from(
        &mut self,
        mut x: Vec<f64>,
        iterations: usize,
        pattern: &Pattern<D>,
        size: f64,
    ) -> Vec<f64> {
        let count = self.linear.size();
        let weights: Vec<f64> = (0..count).map(|i| self.weight(i)).collect();
        // Pivots of exactly zero leave nothing to go on with; right beside them the softest motion is the same.
        let singular = (!self.linear.is_factorized()).then(|| self.linear.values.clone());
        if singular.is_some() {
            self.linear.shift(BESIDE, &weights);
            self.linear.factorize();
        }
        for _ in 0..iterations {
            // What is looked for is soft against the rest.
            for (x, weight) in x.iter_mut().zip(&weights) {
                *x *= weight;
            }
            if !self.linear.solve(&mut x, 1) {
                break;
            }
            let length = x.iter().zip(&weights).map(|(x, w)| x * x * w).sum::<f64>().sqrt();
            x.iter_mut().for_each(|x| *x /= length.max(f64::MIN_POSITIVE));
        }
        if let Some(values) = singular {
            self.linear.values = values;
            self.linear.factorize();
        }
        let motions = pattern.motions_of(&x);
        let largest = motions.iter().flat_map(|m| (0..6).map(|c| if c < 3 { m[c] / size } else { m[c] }));
        let largest = largest.fold(0.0, |best: f64, x| if x.abs() > (1.0 + 1e-6) * best.abs() { x } else { best });
        if largest != 0.0 && largest.is_finite() {
            x.iter_mut().for_each(|x| *x /= largest);
        }
        x
    }

    /// Stiffness of the softest motion, over that of its components one by one.
    ///
    /// A pivot says whether a tangent is singular, and not how nearly: it is large where its component hardly takes part
    /// in the motion.
    pub(crate) fn softest_stiffness(&mut self, pattern: &Pattern<D>, size: f64) -> f64 {
        let x = self.softest_motion(pattern, size);
        let stiffness = self.linear.energy(&self.linear.values, &x);
        let weight = |i: usize| self.linear.diagonal(i).abs().max(self.linear.rest[i]);
        let apart: f64 = x.iter().enumerate().map(|(i, x)| x * x * weight(i)).sum();
        if apart > 0.0 { stiffness / apart } else { 1.0 }
    }

    /// The inverse of how far forces move what they act on: 1 / (bᵀ K⁻¹ b) passes zero, smoothly, where the tangent is singular.
    pub(crate) fn singular_test(&mut self, b: &[f64]) -> Option<f64> {
        let mut y = b.to_vec();
        if !self.solve(&mut y) {
            return None;
        }
        let compliance: f64 = y.iter().zip(b).map(|(y, b)| y * b).sum();
        (compliance != 0.0).then(|| 1.0 / compliance)
    }
}
