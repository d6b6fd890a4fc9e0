//! How the network as a whole answers to forces that single out no motion: how stiff it is, and how it carries them.
//!
//! Theory: docs/theory/stability.md, Eq. 7.11.

use pennate_elements::rotation::{inverse, turn};
use pennate_elements::small::{V3, cross, norm, scale};

use super::System;
use crate::chain::MemberEnds;
use crate::structure::NodeId;

/// Steps of a power iteration from forces that single out no motion towards the load that members carry with the greatest ones: where two
/// loads are carried by forces as great it stays with what both make of those, which moves evenly with the state.
const STEPS: usize = 2;

/// Part of what they are at most, product by product, that loads and their forces have against each other where a load is carried by opposite
/// forces: four bars that went over to the other way on had nine tenths, but for one of 4,600 with a twelfth, and rods that turn far in
/// space have a sixteenth.
const OPPOSITE: f64 = 0.3;

/// The answer of a network, in its present state, to forces that single out no motion.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The stiffness against them, with a sign: it passes zero where the tangent is singular.
    pub(crate) test: f64,
    /// What every part of the network carries with great forces, where members can turn against each other; else nothing.
    carried: Vec<Carried>,
}

/// A load that is carried by great axial forces.
///
/// The forces pass infinity, from one sign to the other, where members come to lie so that they can carry nothing, as the bars of a
/// linkage in one line.
#[derive(Clone, Debug, Default)]
struct Carried {
    /// Forces on the joints of the part, and moments over the size of the network, as these see them; of size one in all.
    load: Vec<[V3<f64>; 2]>,
    /// The axial forces of its members, and after these of its bars.
    thrusts: Vec<f64>,
}

impl Carried {
    /// How far another load is the same one, carried by the same forces; negative where the same load is carried by opposite ones.
    fn like(&self, other: &Self) -> f64 {
        let both = self.load.iter().flatten().flatten().zip(other.load.iter().flatten().flatten());
        let loads: f64 = both.map(|(a, b)| a * b).sum();
        loads * self.thrusts.iter().zip(&other.thrusts).map(|(a, b)| a * b).sum::<f64>()
    }

    /// Whether the same load is carried by opposite forces.
    fn is_opposite(&self, other: &Self) -> bool {
        self.like(other) < -OPPOSITE * (self.like(self) * other.like(other)).sqrt()
    }
}

impl Answer {
    /// How far members carry what they carry as in another answer: the product of their forces, and of the loads.
    pub(crate) fn like(&self, other: &Self) -> f64 {
        self.carried.iter().zip(&other.carried).map(|(own, other)| own.like(other)).sum()
    }

    /// The parts of the network that carry a load by forces opposite to those in another answer.
    pub(crate) fn parts_unlike(&self, other: &Self) -> Vec<usize> {
        let pairs = self.carried.iter().zip(&other.carried).enumerate();
        pairs.filter(|(_, (own, other))| own.is_opposite(other)).map(|(part, _)| part).collect()
    }

    /// The overall stiffness.
    pub(crate) fn stiffness(&self) -> f64 {
        self.test.abs()
    }
}

impl<const D: usize> System<D> {
    /// The answer of the network by the factors of the last assembly, where there are some.
    pub(crate) fn answer(&mut self) -> Option<Answer> {
        let (test, solution) = self.tangent.answer_to_all(&self.pattern, self.size)?;
        let carried = if self.may_carry_otherwise() { self.carried(solution)? } else { Vec::new() };
        Some(Answer { test, carried })
    }

    /// The same where members may come to carry a load by opposite forces; `None` elsewhere, too.
    pub fn answer_of_hinged(&mut self) -> Option<Answer> {
        if self.may_carry_otherwise() { self.answer() } else { None }
    }

    /// Whether members may come to carry a load by opposite forces: where they can turn against each other, and there are two of
    /// them at least.
    pub fn may_carry_otherwise(&self) -> bool {
        let several = self.members.count() + self.bars().count() > 1;
        several && (!self.structure.is_welded() || !self.structure.springs.is_empty())
    }

    /// What members carry with great forces, part by part, from a solution of the equations of the joints to begin with.
    fn carried(&mut self, mut solution: Vec<f64>) -> Option<Vec<Carried>> {
        let mut thrusts = self.thrusts_by(&solution);
        let mut loads = Vec::new();
        for _ in 0..STEPS {
            // How far loads move the ends of members apart is how much of them these carry.
            solution = self.tangent.solve_for(&self.pattern, &self.pushes(&thrusts))?;
            loads = self.pattern.motions_of(&solution);
            self.normalize(&mut loads);
            let size = self.size;
            let full = |load: &[f64; 6]| std::array::from_fn(|c| if c < 3 { load[c] } else { size * load[c] });
            solution = self.tangent.solve_for(&self.pattern, &loads.iter().map(full).collect::<Vec<_>>())?;
            thrusts = self.thrusts_by(&solution);
        }
        let mut carried = vec![Carried::default(); self.pattern.parts.count];
        // A load that turns with the joints is the same.
        for ((load, &part), joint) in loads.iter().zip(&self.pattern.parts.joints).zip(&self.places.joints) {
            let [force, moment] = [[load[0], load[1], load[2]], [load[3], load[4], load[5]]];
            let back = inverse(joint.place.rotation);
            carried[part].load.push([turn(back, force), turn(back, moment)]);
        }
        for (&thrust, part) in thrusts.iter().zip(self.parts_of_all()) {
            carried[part].thrusts.push(thrust);
        }
        Some(carried)
    }

    /// Motions of the joints as lengths, of size one in every part.
    fn normalize(&self, motions: &mut [[f64; 6]]) {
        let parts = &self.pattern.parts;
        let mut squares = vec![0.0; parts.count];
        for (motion, &part) in motions.iter_mut().zip(&parts.joints) {
            motion[3..].iter_mut().for_each(|spin| *spin *= self.size);
            squares[part] += motion.iter().map(|x| x * x).sum::<f64>();
        }
        for (motion, &part) in motions.iter_mut().zip(&parts.joints).filter(|(_, part)| squares[**part] > 0.0) {
            motion.iter_mut().for_each(|x| *x /= squares[part].sqrt());
        }
    }

    /// The forces and moments on joints by which members, and after these bars, push their ends apart with these axial forces.
    fn pushes(&self, thrusts: &[f64]) -> Vec<[f64; 6]> {
        let mut loads = vec![[0.0; 6]; self.pattern.equations.joints.len()];
        let members = self.structure.members.iter().map(|member| member.nodes);
        for (nodes, thrust) in members.chain(self.bars().map(|(_, nodes)| nodes)).zip(thrusts) {
            let Some(along) = self.along(nodes) else { continue };
            for (node, sign) in nodes.into_iter().zip([-1.0, 1.0]) {
                let link = &self.topology.links[node];
                let force = scale(sign * thrust, along);
                let moment = cross(self.places.lever(link), force);
                for c in 0..3 {
                    loads[link.joint][c] += force[c];
                    loads[link.joint][3 + c] += moment[c];
                }
            }
        }
        loads
    }

    /// The axial forces that members, and springs that are bars, have from a solution of the equations of the joints.
    fn thrusts_by(&self, solution: &[f64]) -> Vec<f64> {
        let motions = self.pattern.motions_of(solution);
        let rest = vec![[0.0; 6]; motions.len()];
        let active = &self.pattern.equations.active;
        let axial = |member: usize| {
            let Some(along) = self.along(self.structure.members[member].nodes) else { return 0.0 };
            // What a released end would still move at rest is no part of the answer.
            let ([moved, still], MemberEnds { k01, k11, .. }) =
                ([&motions, &rest].map(|motions| self.end_motions(member, motions).0), self.members.condensed(member));
            let [first, last]: [[f64; D]; 2] =
                std::array::from_fn(|end| std::array::from_fn(|i| moved[end][i] - still[end][i]));
            let translations = active.iter().enumerate().filter(|(_, component)| **component < 3);
            let force = translations.map(|(i, &component)| {
                let own: f64 = (0..D).map(|j| k01[j][i] * first[j] + k11[i][j] * last[j]).sum();
                along[component] * own
            });
            force.sum()
        };
        let of_bar = |(spring, nodes): (usize, [NodeId; 2])| {
            let stiffness = self.structure.springs[spring].line_stiffness().unwrap_or(0.0);
            let [start, end] = nodes.map(|node| self.places.motion_of(&self.topology.links[node], &motions));
            let stretched = |along: V3<f64>| (0..3).map(|c| along[c] * (end[c] - start[c])).sum::<f64>();
            stiffness * self.along(nodes).map_or(0.0, stretched)
        };
        (0..self.members.count()).map(axial).chain(self.bars().map(of_bar)).collect()
    }

    /// The direction from one node to another, where they are apart.
    fn along(&self, nodes: [NodeId; 2]) -> Option<V3<f64>> {
        let chord = self.chord(nodes, &self.places);
        let length = norm(chord);
        (length > 0.0).then(|| scale(1.0 / length, chord))
    }
}
