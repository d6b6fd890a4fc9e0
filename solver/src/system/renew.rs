//! One system after the other in the same memory: for designs of one topology.

use std::sync::Arc;

use super::{Dashpots, System, extent};
use crate::joints::Topology;
use crate::packs;
use crate::structure::Structure;

impl<const D: usize> System<D> {
    /// Begins anew with another structure of the same topology and mesh, unloaded and at rest, as [`System::new`] does. The same
    /// rows stay held; [`System::hold`] says at which values, and [`System::apply_drives`] makes the sections: both have to come
    /// before anything else. False where its joints have other equations or its members other meshes: the system is of no use then.
    pub fn renew(&mut self, structure: Arc<Structure>, topology: Arc<Topology>) -> bool {
        let counts = |structure: &Structure| {
            [structure.nodes.len(), structure.members.len(), structure.springs.len(), structure.drives.len()]
        };
        let alike = counts(&structure) == counts(&self.structure)
            && topology.references == self.topology.references
            && self.pattern.renew(&self.topology, &topology)
            && packs::renew(&mut self.members.packs, &structure);
        if !alike {
            return false;
        }
        self.size = extent(&structure.nodes);
        self.places.unload();
        if !self.members.packs.is_empty() {
            self.members.renew(&structure, &topology);
        }
        self.loading.renew(&structure, &topology, !self.members.packs.is_empty());
        self.tangent.renew();
        self.moves.renew();
        self.dashpots = Dashpots::default();
        self.turning.clear();
        (self.stop, self.straight) = (None, false);
        (self.structure, self.topology) = (structure, topology);
        self.check_side();
        // Which way is the stiffest differs from one structure to the next, and with what is held.
        self.pattern.forget_carriers();
        true
    }
}
