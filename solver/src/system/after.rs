//! Forces on the ends of members as the last solution of the joint equations makes them, to first order.

use pennate_elements::beam::Ends;
use pennate_elements::small::{V3, add, cross, scale, sub};

use super::System;
use crate::reduce;
use crate::structure::MemberId;

impl System<6> {
    /// Forces and moments on the sections at both ends of a member after the motions of the last solution; as vectors that do not
    /// turn with their sections, on which `before` was.
    ///
    /// The stiffness of the ends gives them, which is that of all between them: they are as exact as the motions of the joints,
    /// where stresses at Gauss points lose half of the order on the way to an end. To be asked at the shape and the loads of the
    /// assembly.
    pub(crate) fn forces_after(&self, index: MemberId, before: &[[f64; 6]; 2]) -> [[f64; 6]; 2] {
        let kinds = self.topology.ends[index].each_ref();
        let links = self.structure.members[index].nodes.map(|node| &self.topology.links[node]);
        let moves = links.map(|link| self.places.motion_of(link, &self.moves.motions));
        let ([first, last], _) =
            reduce::recover(&self.pattern.equations.active, kinds, &self.tangent.releases[index], &moves);
        let (pack, lane) = self.members.chain(index);
        let Ends { k00, k01, k11, r0, r1 } = pack.condensed(lane);
        let row = |a: &[f64; 6], x: &[f64; 6]| -> f64 { a.iter().zip(x).map(|(a, x)| a * x).sum() };
        let start: [f64; 6] = std::array::from_fn(|i| r0[i] + row(&k00[i], &first) + row(&k01[i], &last));
        let end: [f64; 6] =
            std::array::from_fn(|i| r1[i] + (0..6).map(|j| k01[j][i] * first[j]).sum::<f64>() + row(&k11[i], &last));
        [unturned(start, &first, &before[0]), unturned(end, &last, &before[1])]
    }
}

/// Forces and moments without what those `before` turn by with a motion.
///
/// The tangent is the Hessian by rotation vectors: of the moment m it holds the change less ½ φ × m, the other half of which is
/// no change of the stresses either.
fn unturned(after: [f64; 6], motion: &[f64; 6], before: &[f64; 6]) -> [f64; 6] {
    let part = |all: &[f64; 6], first: usize| -> V3<f64> { std::array::from_fn(|c| all[first + c]) };
    let spin = part(motion, 3);
    let force = sub(part(&after, 0), cross(spin, part(before, 0)));
    let moment = add(part(&after, 3), scale(-0.5, cross(spin, part(before, 3))));
    [force[0], force[1], force[2], moment[0], moment[1], moment[2]]
}
