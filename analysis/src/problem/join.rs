//! Several designs in one structure, side by side: members of equal mesh share the lanes of the processor.

use std::ops::Range;

use pennate_solver::history::Equilibrium;
use pennate_solver::join;
use pennate_solver::structure::{Step, Structure};

/// What belongs to one of the designs in a state of all.
#[derive(Clone, Debug)]
pub(super) struct Share {
    nodes: Range<usize>,
    members: Range<usize>,
    springs: Range<usize>,
    sections: Range<usize>,
}

impl Share {
    /// The state of one design.
    pub(super) fn of(&self, all: &Equilibrium) -> Equilibrium {
        Equilibrium {
            nodes: all.nodes[self.nodes.clone()].to_vec(),
            members: all.members[self.members.clone()].to_vec(),
            springs: all.springs[self.springs.clone()].to_vec(),
            sections: all.sections[self.sections.clone()].to_vec(),
            compliances: Vec::new(),
            rounding: None,
            ..*all
        }
    }

    /// The largest force on the members of one design.
    pub(super) fn largest_force(&self, all: &Equilibrium) -> f64 {
        let forces = all.members[self.members.clone()].iter().flat_map(|member| member.end_forces);
        forces.flatten().fold(0.0, |largest, force| largest.max(force.abs()))
    }
}

/// One structure of designs that have nothing in common but their topology, the steps of all, and what belongs to each.
pub(super) fn join(designs: Vec<(Structure, Vec<Step>)>) -> Option<(Structure, Vec<Step>, Vec<Share>)> {
    let mut at = [0; 4];
    let shares = designs.iter().map(|(structure, _)| share(structure, &mut at)).collect();
    let (structure, steps) = join::join(designs)?;
    Some((structure, steps, shares))
}

/// What belongs to a structure that comes after so many nodes, members, springs and sections.
fn share(structure: &Structure, at: &mut [usize; 4]) -> Share {
    let counts = [structure.nodes.len(), structure.members.len(), structure.springs.len(), structure.sections.len()];
    let [nodes, members, springs, sections] = std::array::from_fn(|kind| at[kind]..at[kind] + counts[kind]);
    *at = [nodes.end, members.end, springs.end, sections.end];
    Share { nodes, members, springs, sections }
}
