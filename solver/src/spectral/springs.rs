//! What springs add to the matrices of a network over all its nodes.
//!
//! Of every strain q with the stiffness k and the force f = k q the tangent has k ∂q ∂qᵀ, which is a product of rows as it is of
//! members, and f ∂²q.

use pennate_elements::small::{V3, cross, norm};
use pennate_elements::spring::SpringStrain;

use super::operators::{Assembled, Entries, scatter, scatter_row};
use super::unknowns::{Column, lever_curvature, network_node};
use crate::system::System;

/// A spring with the motions of its nodes.
struct Placed<'a> {
    nodes: &'a [usize],
    columns: Vec<Vec<Column>>,
    strains: Vec<SpringStrain>,
}

impl<'a> Placed<'a> {
    /// All springs as they are.
    fn all(system: &'a System<6>) -> impl Iterator<Item = Self> {
        system.structure.springs.iter().enumerate().map(|(index, spring)| {
            let nodes = spring.nodes();
            let columns = nodes.iter().map(|&node| network_node(system, node)).collect();
            Self { nodes, columns, strains: spring.strains(&system.placed(index)) }
        })
    }

    /// Adds what forces on the strains have beside the products of rows; gives the forces and moments that they are at each node.
    fn add_forces(&self, system: &System<6>, forces: &[f64], entries: &mut Entries) -> Vec<[f64; 6]> {
        let sum = |of: &dyn Fn(&SpringStrain) -> f64| -> f64 {
            self.strains.iter().zip(forces).map(|(strain, force)| force * of(strain)).sum()
        };
        let size = 6 * self.nodes.len();
        let curvature = |i: usize| (0..size).map(|j| sum(&|strain| strain.curvature[i][j])).collect();
        scatter(&(0..size).map(curvature).collect(), &self.columns, entries);
        let forces: Vec<[f64; 6]> =
            (0..self.nodes.len()).map(|n| std::array::from_fn(|c| sum(&|strain| strain.gradient[6 * n + c]))).collect();
        for (&node, force) in self.nodes.iter().zip(&forces) {
            let link = &system.topology.links[node];
            let first = system.pattern.equations.joints[link.joint].first;
            let motions = system.pattern.joint_motions(link.joint);
            let lever = (direct(force), system.places.lever(link));
            lever_curvature(first, &motions, lever, &mut |i, j, value| entries.push((i, j, value)));
        }
        forces
    }
}

/// The force of a force and a moment, or the displacement of a motion.
fn direct(components: &[f64]) -> V3<f64> {
    std::array::from_fn(|c| components[c])
}

/// The spin of a motion.
fn turn(components: &[f64]) -> V3<f64> {
    std::array::from_fn(|c| components[3 + c])
}

/// Adds the tangents of all springs: rows, their products and what forces have beside these.
pub(super) fn add_present(system: &System<6>, all: &mut Assembled) {
    for spring in Placed::all(system) {
        let forces: Vec<f64> = spring.strains.iter().map(|strain| strain.force).collect();
        spring.add_forces(system, &forces, &mut all.rest);
        for strain in &spring.strains {
            let row = scatter_row(&strain.gradient[..6 * spring.nodes.len()], &spring.columns);
            for &(i, left) in &row {
                all.stiffness.extend(row.iter().map(|&(j, right)| (i, j, strain.stiffness * left * right)));
            }
            let root = strain.stiffness.sqrt();
            all.strains.push(row.into_iter().map(|(i, value)| (i, root * value)).collect());
        }
    }
}

/// What springs add to the tangent, and to the forces on the joints, where the forces in them change with motions of the joints and
/// the shape is frozen.
pub(crate) fn add_change(system: &System<6>, motions: &[[f64; 6]], entries: &mut Entries, forces: &mut [[f64; 6]]) {
    for spring in Placed::all(system) {
        let mut motion = [0.0; 12];
        for (own, &node) in motion.chunks_exact_mut(6).zip(spring.nodes) {
            own.copy_from_slice(&system.places.motion_of(&system.topology.links[node], motions));
        }
        let change = |strain: &SpringStrain| -> f64 {
            strain.stiffness * strain.gradient.iter().zip(&motion).map(|(g, m)| g * m).sum::<f64>()
        };
        let changes: Vec<f64> = spring.strains.iter().map(change).collect();
        for (&node, change) in spring.nodes.iter().zip(spring.add_forces(system, &changes, entries)) {
            let link = &system.topology.links[node];
            let moment = cross(system.places.lever(link), direct(&change));
            for c in 0..3 {
                forces[link.joint][c] += change[c];
                forces[link.joint][3 + c] += change[3 + c] + moment[c];
            }
        }
    }
}

/// The largest force and moment by which motions of the joints change a spring, and the largest that are rounding of these motions.
pub(crate) fn changed(system: &System<6>, motions: &[[f64; 6]]) -> [[f64; 2]; 2] {
    let (mut changes, mut rounding) = ([0.0f64; 2], [0.0f64; 2]);
    for spring in Placed::all(system) {
        for strain in &spring.strains {
            let (mut change, mut parts, mut is_moment) = (0.0, 0.0, true);
            for (gradient, &node) in strain.gradient.chunks_exact(6).zip(spring.nodes) {
                let link = &system.topology.links[node];
                let motion = system.places.motion_of(link, motions);
                change += gradient.iter().zip(&motion).map(|(g, m)| g * m).sum::<f64>();
                let [shift, spin] = [direct(&motions[link.joint]), turn(&motions[link.joint])].map(norm);
                let shift = shift + spin * norm(system.places.lever(link));
                parts += norm(direct(gradient)) * shift + norm(turn(gradient)) * spin;
                is_moment &= direct(gradient) == [0.0; 3];
            }
            let kind = usize::from(is_moment);
            changes[kind] = changes[kind].max(strain.stiffness * change.abs());
            rounding[kind] = rounding[kind].max(strain.stiffness * f64::EPSILON * parts);
        }
    }
    [changes, rounding]
}
