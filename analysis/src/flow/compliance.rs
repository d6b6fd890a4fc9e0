//! Compliances of an unloaded structure: motions under unit loads.

use pennate_solver::base::{self, Followed};
use pennate_solver::error::{FreeMotion, SolveError};
use pennate_solver::options::Options;
use pennate_solver::structure::{NodeId, Structure};
use pennate_solver::system::System;

/// A structure whose tangent is factorized.
pub(super) trait Linear {
    /// Small motions of nodes under a load (force and moment) on one of them.
    fn motions(&mut self, node: NodeId, load: &[f64; 6], wanted: &[NodeId]) -> Vec<[f64; 6]>;
}

impl<const D: usize> Linear for System<D> {
    fn motions(&mut self, node: NodeId, load: &[f64; 6], wanted: &[NodeId]) -> Vec<[f64; 6]> {
        let link = self.topology.links[node];
        let [x, y, z] = link.arm;
        let mut force = *load;
        // The load on a point of a body, at its joint; nothing has turned yet.
        force[3] += y * load[2] - z * load[1];
        force[4] += z * load[0] - x * load[2];
        force[5] += x * load[1] - y * load[0];
        let mut solution = vec![0.0; self.pattern.equations.size];
        self.pattern.equations.project(link.joint, &force, &mut solution);
        if !self.tangent.solve(&mut solution) {
            return vec![[f64::NAN; 6]; wanted.len()];
        }
        let moved = self.pattern.motions_of(&solution);
        wanted.iter().map(|&node| self.places.motion_of(&self.topology.links[node], &moved)).collect()
    }
}

/// Does work on the tangent of an unloaded structure.
///
/// # Errors
/// The motions that need no force.
pub(super) fn linear<T>(
    structure: &Structure,
    options: &Options,
    work: impl FnOnce(&mut dyn Linear) -> T,
) -> Result<T, Vec<FreeMotion>> {
    let followed = base::follow(structure, &[], 0, options, &mut |_| true);
    let (mut followed, _) = followed.map_err(|SolveError::Mechanism(motions)| motions)?;
    Ok(match &mut followed {
        Followed::Plane(path) => {
            path.system.assemble(false);
            work(&mut path.system)
        }
        Followed::Space(path) => {
            path.system.assemble(false);
            work(&mut path.system)
        }
    })
}
