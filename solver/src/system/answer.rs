//! How the network as a whole answers to forces that single out no motion, and in which posture.
//!
//! Theory: docs/theory/stability.md, Eq. 7.11.

use super::System;
use super::posture::Posture;

/// The answer of a network, in its present state, to forces that single out no motion.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The stiffness against them, with a sign: it passes zero where the tangent is singular.
    pub(crate) test: f64,
    /// Which motions strain which members, where members can turn against each other.
    pub(crate) posture: Option<Box<Posture>>,
}

impl Answer {
    /// The overall stiffness.
    pub(crate) fn stiffness(&self) -> f64 {
        self.test.abs()
    }

    /// The parts of the network whose members are strained the other way than in another answer.
    pub(crate) fn parts_turned_over(&self, other: &Self) -> Vec<usize> {
        let postures = self.posture.as_ref().zip(other.posture.as_ref());
        postures.map_or_else(Vec::new, |(own, other)| own.against(other).turned_over)
    }
}

impl<const D: usize> System<D> {
    /// The answer of the network by the factors of the last assembly, where there are some.
    pub(crate) fn answer(&mut self) -> Option<Answer> {
        let test = self.tangent.singular_test_of_all(&self.pattern, self.size)?;
        let posture = if self.may_turn_over() { self.posture().map(Box::new) } else { None };
        Some(Answer { test, posture })
    }

    /// The same where members may come to be strained the other way; `None` elsewhere, too.
    pub fn answer_of_hinged(&mut self) -> Option<Answer> {
        if self.may_turn_over() { self.answer() } else { None }
    }

    /// Whether members may come to be strained the other way: where they can turn against each other, and there are two of them at
    /// least.
    pub fn may_turn_over(&self) -> bool {
        let several = self.members.count() + self.bars().count() > 1;
        several && (!self.structure.is_welded() || !self.structure.springs.is_empty())
    }
}
