//! Derivatives of a displacement or rotation with respect to the sections of all members.
//!
//! With the residual r(u, p) = 0 of all nodes, du/dp = −K⁻¹ ∂r/∂p. For one component o of u this is −λᵀ ∂r/∂p with
//! K λ = e_o: λ is the motion under a unit force (or moment) on o, read off the factorized tangent. The strains of that
//! motion are δε, those of the equilibrium ε, and σ = C (ε − ε*); so
//! ```text
//! ∂o/∂ ln Cᵢ = −∫ δεᵢ σᵢ dS        ∂o/∂ε*ᵢ = ∫ Cᵢ δεᵢ dS
//! ```
//! over the segment concerned: the theorem of the unit load, about a state of large displacements. Exact for the
//! elements at hand, whatever their number; where a strain is held, to the 1e-7 that its auxiliary stiffness leaves.
//!
//! Theory: docs/theory/muscles.md, Eq. 11.4.

use pennate_elements::rotation::turn;
use pennate_elements::small::cross;

use crate::reduce;
use crate::structure::NodeId;
use crate::system::System;

/// Derivatives of one component of one node with respect to the section of one segment of a member.
///
/// Components are EA, GA₂, GA₃, GJ, EI₂, EI₃ and the strains that belong to them, about axes of which, in the plane, the
/// third is z. Zero where a stiffness is infinite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SegmentSensitivity {
    /// With respect to the logarithms of the stiffnesses.
    pub stiffness: [f64; 6],
    /// With respect to the induced strains.
    pub strain: [f64; 6],
}

impl<const D: usize> System<D> {
    /// Derivatives of a displacement (component 0, 1, 2) or spin (3, 4, 5) of a node, member by member and segment by segment.
    ///
    /// The last assembly must be that of an equilibrium. `None` where its tangent has no factors, or is not symmetric:
    /// then the loads have no potential, and λ would be another one. `None` too where bending within elements makes
    /// them compliant in shear, as corotational ones are: one stiffness depends on another.
    pub fn sensitivities(&mut self, node: NodeId, component: usize) -> Option<Vec<Vec<SegmentSensitivity>>> {
        if self.members.packs.iter().any(|pack| pack.mesh().about().sheared_by_bending) || !self.tangent.has_potential()
        {
            return None;
        }
        let link = self.topology.links[node];
        let mut unit = [0.0; 6];
        unit[component] = 1.0;
        if link.has_arm() {
            let lever = turn(self.places.joints[link.joint].place.rotation, link.arm);
            let turning = cross(lever, [unit[0], unit[1], unit[2]]);
            for c in 0..3 {
                unit[3 + c] += turning[c];
            }
        }
        let mut response = vec![0.0; self.pattern.equations.size];
        self.pattern.equations.project(link.joint, &unit, &mut response);
        if !self.tangent.solve(&mut response) {
            return None;
        }
        let motions = self.pattern.motions_of(&response);
        let rest = vec![[0.0; 6]; motions.len()];
        Some((0..self.members.count()).map(|member| self.member_sensitivity(member, &motions, &rest)).collect())
    }

    fn member_sensitivity(&self, member: usize, motions: &[[f64; 6]], rest: &[[f64; 6]]) -> Vec<SegmentSensitivity> {
        let nodes = self.structure.members[member].nodes;
        let kinds = self.topology.ends[member].each_ref();
        let active = self.pattern.equations.active;
        let ends = |motions: &[[f64; 6]]| {
            let moves = nodes.map(|n| self.places.motion_of(&self.topology.links[n], motions));
            reduce::recover(&active, kinds, &self.tangent.releases[member], &moves).0
        };
        // What a released end would still move at rest is no part of the derivative.
        let (moved, still) = (ends(motions), ends(rest));
        let ends = std::array::from_fn(|e| std::array::from_fn(|i| moved[e][i] - still[e][i]));
        let one = |variation: &crate::chain::SegmentVariation<D>| {
            let mut sensitivity = SegmentSensitivity::default();
            for i in 0..D {
                // Strains of a chain: Γ₁ Γ₂ κ₃ in the plane, all six in space.
                let component = if D == 6 { i } else { [0, 1, 5][i] };
                sensitivity.stiffness[component] = -variation.work[i];
                sensitivity.strain[component] = variation.stress[i];
            }
            sensitivity
        };
        let (pack, lane) = self.members.chain(member);
        pack.variation(lane, &ends).iter().map(one).collect()
    }
}
