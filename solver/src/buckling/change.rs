//! How the tangent changes at the beginning of a ramp.
//!
//! Theory: docs/theory/stability.md, Eq. 7.6.

use std::sync::Arc;

use pennate_elements::small::{add, cross, norm, scale, sub};

use super::Beginning;
use crate::chain;
use crate::joints::EndKind;
use crate::spectral::operators::{self, Entries, Evaluated, element_columns, mirror, scatter};
use crate::spectral::springs;
use crate::spectral::unknowns::{Unknowns, end_curvature};
use crate::system::System;

/// Largest motion of a joint up to a critical factor, over the size of the network.
///
/// Muscles that contract freely get no stresses but by rounding, which has factors of 10⁷ and more: there the linear response
/// would be that many times as long as the network.
const FARTHEST: f64 = 1e6;

/// K′ of the beginning of a ramp.
pub(super) struct Change {
    /// Over all unknowns.
    pub(super) entries: Entries,
    /// The inverse of the largest factor that is looked for.
    pub(super) least: f64,
    /// Part of it that it may be off.
    pub(super) error: f64,
    /// The part of the ramp that it was found on.
    pub(super) part: f64,
}

impl Beginning {
    /// K′; nothing where the state does not respond.
    pub(super) fn change(
        &mut self,
        unknowns: &Unknowns,
        without_potential: &mut Vec<(usize, usize)>,
    ) -> Option<Change> {
        let response = self.response()?;
        let motion = response.motions.iter().fold(0.0f64, |most, m| most.max(norm([m[0], m[1], m[2]])));
        let system = &mut self.base.system;
        let least = motion / (FARTHEST * system.size);
        let mut entries = Entries::with_capacity(operators::entries(system));
        let mut forces = vec![[0.0; 6]; system.tangent.forces.len()];
        for member in 0..system.members.count() {
            let slot = &system.members.slots[member];
            let pack = &system.members.packs[slot.pack];
            for e in 0..pack.mesh().elements() {
                let state = chain::element(pack.as_ref(), slot.lane, e);
                let own = Evaluated::of(&state, &response.stressings[member][e], operators::Part::Rate);
                scatter(&own.stiffness, &element_columns(system, unknowns, member, e), &mut entries);
            }
            let ends = &response.ends[member];
            end_curvature(system, unknowns, member, ends, &mut |i, j, value| entries.push((i, j, value)));
            add_end_forces(system, member, ends, &mut forces);
        }
        springs::add_change(system, &response.motions, &mut entries, &mut forces);

        // Loads on levers and followers, and constraints whose direction turns with the joint.
        let internal = system.tangent.forces.clone();
        let before = system.remainder();
        let loads = system.tangent.forces.clone();
        self.set(response.part);
        let system = &mut self.base.system;
        system.remainder();
        let total: Vec<[f64; 6]> = (0..internal.len())
            .map(|joint| {
                let change = add(sub(system.tangent.forces[joint], loads[joint]), scale(response.part, forces[joint]));
                add(internal[joint], change)
            })
            .collect();
        let (topology, joints) = (Arc::clone(&system.topology), system.places.joints.clone());
        system.pattern.equations.find_multipliers(&topology, &joints, &total, response.part);
        let after = system.remainder();
        without_potential.extend(system.tangent.without_potential());
        mirror(&after, 1.0 / response.part, &mut entries);
        mirror(&before, -1.0 / response.part, &mut entries);
        self.set(0.0);
        self.base.system.assemble(false);
        Some(Change { entries, least, error: response.error, part: response.part })
    }
}

/// Adds forces on the ends of a member to those of its joints.
fn add_end_forces(system: &System<6>, member: usize, ends: &[[f64; 6]; 2], forces: &mut [[f64; 6]]) {
    for (end, info) in system.end_info(member, ends).iter().enumerate() {
        let joint = system.topology.links[system.structure.members[member].nodes[end]].joint;
        let moment = if let EndKind::Free { .. } = info.kind { [0.0; 3] } else { info.moment };
        let moment = add(moment, cross(info.lever, info.force));
        for c in 0..3 {
            forces[joint][c] += info.force[c];
            forces[joint][3 + c] += moment[c];
        }
    }
}
