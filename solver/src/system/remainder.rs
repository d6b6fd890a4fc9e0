//! What the equations of the joints hold besides members: for operators over all nodes, where members come element by
//! element.

use super::System;

impl<const D: usize> System<D> {
    /// Stiffness of springs, loads and curved constraints in the equations of the joints: lower triangle.
    ///
    /// The state is that of the last assembly, whose forces and factors are lost.
    pub(crate) fn remainder(&mut self) -> Vec<(usize, usize, f64)> {
        self.begin(true);
        self.add_springs_and_loads(None);
        if self.pattern.equations.has_general() {
            self.add_constraint_stiffness(None);
        }
        self.tangent.linear.entries().filter(|entry| entry.2 != 0.0).collect()
    }
}
