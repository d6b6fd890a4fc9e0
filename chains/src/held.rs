//! The axial force of a member that cannot be stretched, or hardly, a number of its own, which no strain gives; and the force
//! that any member carries.

use pennate_elements::beam::Beam;
use pennate_elements::real::{Real, Work};

use crate::{Chain, MOST_LANES, NewNodes, NewState, Pack};

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

/// The axial force of what cannot be stretched; `None` where the strain of every part of the member gives its force.
pub fn held_force<const D: usize>(pack: &dyn Pack<D>, lane: usize) -> Option<HeldForce> {
    let mesh = pack.mesh();
    let weights = mesh.weights();
    let (mut length, mut force, mut compliance) = (0.0, 0.0, 0.0);
    let mut is_rigid = true;
    for segment in 0..mesh.segments() {
        let moduli = pack.segment(lane, segment).moduli;
        if moduli.held[0] == 0.0 {
            continue;
        }
        is_rigid &= moduli.held[0] == 1.0;
        let own = mesh.element_length(lane, segment);
        let (first, count) = mesh.elements_of(segment);
        for e in first..first + count {
            length += own;
            compliance += own / moduli.stiffness[0];
            for (stress, weight) in pack.stress(lane, e).iter().zip(weights) {
                force += own * weight * stress[0];
            }
        }
    }
    (length > 0.0).then(|| HeldForce { force: force / length, auxiliary: length / compliance, length, is_rigid })
}

/// Adds to that force in all parts of a member that have one.
pub fn add_held_force<const D: usize>(pack: &mut dyn Pack<D>, lane: usize, by: f64) {
    for e in 0..pack.mesh().elements() {
        if pack.segment(lane, pack.mesh().segment_of(e)).moduli.held[0] == 0.0 {
            continue;
        }
        let mut stress = pack.stress(lane, e);
        stress.iter_mut().for_each(|stress| stress[0] += by);
        let ends = [pack.node(lane, e), pack.node(lane, e + 1)];
        let local = pack.local(lane, e);
        pack.set_element(lane, e, &NewState { ends, nodes: NewNodes::Local(&local), stress });
    }
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
    pub(super) fn carried_forces_impl(&self) -> [f64; MOST_LANES] {
        let largest = T::run(Carried(self));
        let mut forces = [0.0; MOST_LANES];
        largest.store(&mut forces[..T::LANES]);
        forces
    }
}
