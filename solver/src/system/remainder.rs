//! What the equations of the joints hold besides members and springs: for operators over all nodes, where members come element
//! by element, and springs strain by strain.

use super::System;

impl<const D: usize> System<D> {
    /// Stiffness of loads and curved constraints in the equations of the joints: lower triangle.
    ///
    /// The state is that of the last assembly, whose forces and factors are lost.
    pub(crate) fn remainder(&mut self) -> Vec<(usize, usize, f64)> {
        self.begin(true);
        self.assemble_loads(None);
        if self.pattern.equations.has_general() {
            self.add_constraint_stiffness(None);
        }
        self.tangent.linear.entries().filter(|entry| entry.2 != 0.0).collect()
    }
}
