//! The axial force of a member that cannot be stretched, or hardly, a number of its own, which no strain gives; and the force
//! that any member carries.

use pennate_elements::beam::{Beam, Moduli};
use pennate_elements::real::{Real, Work};

use crate::{Chain, MOST_LANES};

/// The axial force of the parts of a member that cannot be stretched, or hardly, in the mean over their length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldForce {
    /// Axial force, positive in tension.
    pub force: f64,
    /// Force that an iteration adds for a unit of the strain that is left.
    pub auxiliary: f64,
    /// Unloaded length of these parts.
    pub length: f64,
    /// Whether nothing but the auxiliary stiffness is behind it: the parts cannot be stretched at all.
    pub is_rigid: bool,
}

/// Stiffness against a strain, infinite for one that is held.
pub(crate) fn stiffness<T: Real, const D: usize>(moduli: &Moduli<T, D>, component: usize, lane: usize) -> f64 {
    moduli.stiffness[component].lane(lane) / (1.0 - moduli.held[component].lane(lane))
}

/// The largest force of the mixed stresses, along the axis and across, as work in lanes.
struct Carried<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize>(&'a Chain<T, B, D, P>);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Carried<'_, T, B, D, P> {
    type Output = T;

    #[inline(always)]
    fn run(self) -> T {
        let mut largest = T::zero();
        for stress in &self.0.state.stress {
            let mut square = T::zero();
            for part in &stress[..Chain::<T, B, D, P>::TRANSLATIONS] {
                square += *part * *part;
            }
            largest = largest.max(square);
        }
        largest.sqrt()
    }
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    /// `None` where the strain of every part of the member gives its force.
    pub(super) fn held_force_impl(&self, lane: usize) -> Option<HeldForce> {
        if self.moduli.iter().all(|moduli| moduli.held[0].lane(lane) == 0.0) {
            return None;
        }
        let (mut length, mut force, mut compliance) = (0.0, 0.0, 0.0);
        let mut is_rigid = true;
        for (e, piece) in self.pieces.iter().enumerate() {
            let moduli = &self.moduli[self.mesh.segment_of[e]];
            if moduli.held[0].lane(lane) == 0.0 {
                continue;
            }
            let own = piece.length.lane(lane);
            is_rigid &= moduli.held[0].lane(lane) == 1.0;
            length += own;
            compliance += own / moduli.stiffness[0].lane(lane);
            for g in 0..P {
                force += own * self.table.weights[g] * self.state.stress[e * P + g][0].lane(lane);
            }
        }
        Some(HeldForce { force: force / length, auxiliary: length / compliance, length, is_rigid })
    }

    pub(super) fn carried_forces_impl(&self) -> [f64; MOST_LANES] {
        let largest = T::run(Carried(self));
        let mut forces = [0.0; MOST_LANES];
        largest.store(&mut forces[..T::LANES]);
        forces
    }

    /// Adds the same to the axial force of all these parts.
    pub(super) fn add_held_force_impl(&mut self, lane: usize, by: f64) {
        for e in 0..self.pieces.len() {
            if self.moduli[self.mesh.segment_of[e]].held[0].lane(lane) == 0.0 {
                continue;
            }
            for stress in &mut self.state.stress[e * P..(e + 1) * P] {
                let force = stress[0].lane(lane) + by;
                stress[0].set_lane(lane, force);
            }
        }
    }
}
