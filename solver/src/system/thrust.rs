//! How the network as a whole answers to forces that single out no motion: how stiff it is, and how it carries them.
//!
//! Theory: docs/theory/stability.md, Eq. 7.11.

use pennate_elements::small::{V3, norm, scale};

use super::System;
use crate::chain::MemberEnds;
use crate::structure::NodeId;

/// The answer of a network, in its present state, to forces that single out no motion.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The stiffness against them, with a sign: it passes zero where the tangent is singular.
    pub(crate) test: f64,
    /// The axial forces by which members, and after these bars, carry them, where members can turn against each other; else none.
    ///
    /// They pass infinity, from one sign to the other, where members come to lie so that they can carry nothing, as the bars of a
    /// linkage in one line.
    thrusts: Vec<f64>,
}

impl Answer {
    /// How far members carry them as in another answer: the product of their forces.
    pub(crate) fn like(&self, other: &Self) -> f64 {
        self.thrusts.iter().zip(&other.thrusts).map(|(a, b)| a * b).sum()
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
        let thrusts = if self.may_carry_otherwise() { self.thrusts_by(&solution) } else { Vec::new() };
        Some(Answer { test, thrusts })
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

    /// The parts of the network that carry a load by opposite forces in two states.
    pub(crate) fn parts_that_carry_otherwise(&self, one: &Answer, other: &Answer) -> Vec<usize> {
        let mut like = vec![0.0; self.pattern.parts.count];
        for ((a, b), part) in one.thrusts.iter().zip(&other.thrusts).zip(self.parts_of_all()) {
            like[part] += a * b;
        }
        (0..like.len()).filter(|&part| like[part] < 0.0).collect()
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
