//! Numbers wanted by name at every increment.

use pennate_solver::history::Equilibrium;

/// The probes of a network, in the order of the file.
#[derive(Clone, Debug, Default)]
pub struct Probes {
    pub names: Vec<String>,
}

impl Probes {
    /// Values of all probes in an equilibrium, in order. Angles are degrees.
    ///
    /// `after` holds the values after each finished step, which `name@step` looks up. While that step is under
    /// way the present value stands for it; before it the value is not a number.
    pub fn evaluate(&self, state: &Equilibrium, after: &[Vec<f64>]) -> Vec<f64> {
        let _ = (state, after);
        vec![f64::NAN; self.names.len()]
    }
}
