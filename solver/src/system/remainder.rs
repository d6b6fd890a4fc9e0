//! What the equations of the joints hold besides members: for operators over all nodes, where members come element by
//! element.

use super::System;
use super::scatter::unit_motion;

impl<const D: usize> System<D> {
    /// Stiffness of springs, loads and curved constraints in the equations of the joints: lower triangle.
    ///
    /// The state is that of the last assembly, whose forces and factors are lost.
    pub fn remainder(&mut self) -> Vec<(usize, usize, f64)> {
        self.begin();
        self.add_springs_and_loads(None);
        if self.equations.has_general() {
            self.add_constraint_stiffness();
        }
        self.linear.entries().filter(|entry| entry.2 != 0.0).collect()
    }

    /// Part without a potential of the loads of the last assembly: equations of a joint that it couples, two by two.
    pub fn without_potential(&self) -> Vec<(usize, usize)> {
        self.skew_part().into_iter().filter(|entry| entry.2 != 0.0).map(|(row, column, _)| (row, column)).collect()
    }

    /// The part of the tangent that is not symmetric, by pairs of equations.
    pub fn skew_part(&self) -> Vec<(usize, usize, f64)> {
        let mut entries = Vec::new();
        for (joint, block) in &self.skew.joints {
            let equations = &self.equations.joints[*joint];
            for a in 0..equations.count {
                for b in 0..equations.count {
                    entries.push((equations.first + a, equations.first + b, block[(a, b)]));
                }
            }
        }
        entries
    }

    /// The motions of a joint that its equations stand for, one after the other.
    pub fn joint_motions(&self, joint: usize) -> Vec<[f64; 6]> {
        let count = self.equations.joints[joint].count;
        let unit = |e: usize| -> [f64; 6] { std::array::from_fn(|i| if i == e { 1.0 } else { 0.0 }) };
        (0..count).map(|e| unit_motion(&self.equations, joint, &unit(e)[..count])).collect()
    }
}
