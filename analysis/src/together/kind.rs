//! Networks in the plane and in space: what builds their systems, and what holds them.

use std::sync::Arc;

use pennate_solver::base::{self, Judges};
use pennate_solver::chain::Pack;
use pennate_solver::continuation::{self, OutOfPlane};
use pennate_solver::joints::{Active, Topology};
use pennate_solver::lateral::Lateral;
use pennate_solver::packs;
use pennate_solver::structure::{Step, Structure};
use pennate_solver::system::System;

/// Builds the chains of a structure.
pub(crate) type Packs<const D: usize> = fn(&Structure, usize) -> Vec<Box<dyn Pack<D>>>;

/// The same of so many equal structures in one.
pub(crate) type PacksOfParts<const D: usize> = fn(&Structure, usize, usize) -> Vec<Box<dyn Pack<D>>>;

/// What systems of D components a node are built with, and what judges their stability out of the plane.
#[derive(Clone, Copy)]
pub(crate) struct Kind<const D: usize> {
    pub packs: Packs<D>,
    pub packs_of_parts: PacksOfParts<D>,
    /// So many designs are side by side.
    pub designs: usize,
    pub active: Active<D>,
    /// Of networks in the plane alone.
    pub lateral: Option<Sideways<D>>,
    /// What judges states that the tangent does not tell the stability of.
    pub judges: Judges<D>,
}

impl<const D: usize> Kind<D> {
    /// A system on elements of an order higher by `enrich`.
    pub(super) fn build(&self, structure: Arc<Structure>, topology: Arc<Topology>, enrich: usize) -> System<D> {
        let chains = (self.packs_of_parts)(&structure, enrich, self.designs);
        let mut system = System::new(structure, topology, chains, self.active, false);
        system.pattern.in_blocks = true;
        system
    }
}

/// Builds what judges the stability of a plane system out of its plane.
pub(crate) type Sideways<const D: usize> = fn(&System<D>) -> Box<dyn OutOfPlane<D> + Send>;

/// So many networks in the plane.
pub(crate) fn plane(designs: usize) -> Kind<3> {
    let lateral = |plane: &System<3>| -> Box<dyn OutOfPlane<3> + Send> { Box::new(Lateral::new(plane)) };
    let (packs, packs_of_parts) = (packs::plane, packs::plane_of_parts);
    let judges = base::JUDGES_IN_PLANE;
    Kind { packs, packs_of_parts, designs, active: [0, 1, 5], lateral: Some(lateral), judges }
}

/// So many networks in space.
pub(crate) fn space(designs: usize) -> Kind<6> {
    let (packs, packs_of_parts) = (packs::space, packs::space_of_parts);
    let judges = base::JUDGES_IN_SPACE;
    Kind { packs, packs_of_parts, designs, active: [0, 1, 2, 3, 4, 5], lateral: None, judges }
}

/// A system for a structure of the same topology and mesh.
pub(crate) fn system<const D: usize>(
    like: &System<D>,
    packs: Packs<D>,
    structure: Structure,
    steps: &[Step],
) -> System<D> {
    let structure = Arc::new(structure);
    let topology = continuation::topology(&structure, steps);
    let chains = packs(&structure, 0);
    System::new(structure, topology, chains, like.pattern.equations.active, false)
}

/// The direction of a component of a node, in the axes of its support.
pub(crate) fn axis(structure: &Structure, node: usize, component: usize) -> [f64; 3] {
    let support = structure.supports.iter().find(|support| support.node == node);
    let mut global = [0.0; 3];
    global[component % 3] = 1.0;
    support.map_or(global, |support| support.axes[component % 3])
}

/// The present value of a component of a node, in the axes of its support.
pub(crate) fn present<const D: usize>(system: &System<D>, node: usize, component: usize) -> f64 {
    system.present(node, component, axis(&system.structure, node, component))
}
