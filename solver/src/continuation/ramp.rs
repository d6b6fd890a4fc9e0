//! What a step moves, from where the last one left it.
//!
//! Theory: docs/theory/continuation.md, Eq. 8.1.

use crate::system::System;

/// Values that go along a straight line from those at the fraction 0 to those at 1.
#[derive(Clone, Debug)]
pub struct Ramp {
    /// Of the drives.
    pub(super) drives: [Vec<f64>; 2],
    /// Parts of the prestress.
    pub(super) prestress: [f64; 2],
}

impl Ramp {
    /// One of drives alone, where all of the prestress has come in.
    pub fn of_drives(from: Vec<f64>, to: Vec<f64>) -> Self {
        Self { drives: [from, to], prestress: [1.0, 1.0] }
    }

    /// Brings the drives of a system to a fraction; rows that move are brought there by its iterations.
    pub fn apply<const D: usize>(&self, system: &mut System<D>, fraction: f64) {
        let [from, to] = &self.drives;
        system.loading.fraction = fraction;
        for (value, (from, to)) in system.loading.drives.iter_mut().zip(from.iter().zip(to)) {
            *value = if fraction == 1.0 { *to } else { from + fraction * (to - from) };
        }
        system.loading.prestress = self.prestress[0] + fraction * (self.prestress[1] - self.prestress[0]);
        system.apply_drives();
    }
}
