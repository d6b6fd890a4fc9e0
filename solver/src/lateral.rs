//! The stability of a plane network out of its plane.
//!
//! At a plane state the tangents in the plane and out of it do not couple. The lateral one, uz, φx, φy a joint, is
//! factorized at accepted increments alone; its negative pivots count as those of the plane do.

use std::sync::Arc;

use crate::joints::{Held, HeldKind};
use crate::reduce;
use crate::system::{Inertia, System, finite_stiffness};

/// The lateral equations of a plane network.
pub struct Lateral {
    system: System<3>,
}

impl Lateral {
    /// `held` are the lateral rows of the supports.
    pub fn new(plane: &System<3>, held: Vec<Held>) -> Self {
        let structure = Arc::clone(&plane.structure);
        let topology = Arc::clone(&plane.topology);
        let mut system = System::new(structure, topology, Vec::new(), [2, 3, 4], false);
        system.members = plane.members.clone();
        system.hold(held);
        Self { system }
    }

    /// Pivots of the lateral tangent at the state of the plane system's last assembly, and whether all loads have a
    /// potential out of the plane.
    pub fn inertia(&mut self, plane: &mut System<3>) -> (Inertia, bool) {
        let system = &mut self.system;
        system.state.joints.copy_from_slice(&plane.state.joints);
        system.state.releases.copy_from_slice(&plane.state.releases);
        system.loads.copy_from_slice(&plane.loads);
        system.prestress = plane.prestress;
        system.fraction = plane.fraction;
        system.begin();
        let mut inertia = Inertia { smallest: 1.0, ..Inertia::default() };
        let mut stiffness = Vec::new();
        for index in 0..plane.members.len() {
            stiffness.clear();
            for segment in 0..plane.structure.members[index].segments.len() {
                let slot = &plane.members[index];
                let length = plane.packs[slot.pack].element_length(slot.lane, segment);
                stiffness.push(finite_stiffness(&plane.section(index, segment).section, length, &slot.turn));
            }
            let (pack, lane) = (plane.members[index].pack, plane.members[index].lane);
            let (ends, negative, smallest) = plane.packs[pack].lateral(lane, &stiffness);
            inertia.negative += negative;
            inertia.smallest = inertia.smallest.min(smallest);
            let mut factor = system.members[index].factor;
            let info = plane.end_info(index, plane.members[index].ends);
            let reduced = reduce::reduce(&ends, &[2, 3, 4], &info, &mut factor);
            system.add_member(index, &reduced);
        }
        system.add_springs_and_loads(Some(plane));
        system.finish(&mut inertia);
        (inertia, system.has_potential())
    }
}

/// What supports hold out of the plane: what they name, uz with any translation, rx and ry with rz.
pub fn rows(structure: &crate::structure::Structure) -> Vec<Held> {
    let mut held = Vec::new();
    for support in &structure.supports {
        let translation = support.fixed[..3].iter().any(|&f| f);
        let rotation = support.fixed[5];
        let fixed = [translation, support.fixed[3] || rotation, support.fixed[4] || rotation];
        for (component, fixed) in [2, 3, 4].into_iter().zip(fixed) {
            if !fixed {
                continue;
            }
            let mut axis = [0.0; 3];
            axis[component % 3] = 1.0;
            let kind = if component == 2 {
                HeldKind::Translation { direction: axis }
            } else if rotation {
                HeldKind::Rotation { axis }
            } else {
                HeldKind::Rotation { axis: support.axes[component - 3] }
            };
            held.push(Held { node: support.node, component, kind, from: 0.0, to: 0.0 });
        }
    }
    held
}
