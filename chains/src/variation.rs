//! How strains along a member change with its ends, for derivatives with respect to its sections.

use pennate_elements::beam::Beam;
use pennate_elements::real::{Real, Work};
use pennate_elements::small::{add, apply, scale};

use crate::{Chain, lanes};

/// What a small motion of the ends of a member does in one segment, the interior following in equilibrium.
///
/// Components as those of the chain: Γ₁ Γ₂ κ₃ in the plane, Γ₁ Γ₂ Γ₃ κ₁ κ₂ κ₃ in space; zero where a strain is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentVariation<const D: usize> {
    /// ∫ δε σ dS.
    pub work: [f64; D],
    /// ∫ C δε dS.
    pub stress: [f64; D],
}

/// Integrals of all segments, as work in lanes.
struct Integrals<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize>(&'a Chain<T, B, D, P>, [[T; D]; 2]);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Integrals<'_, T, B, D, P> {
    /// ∫ δε σ dS and ∫ C δε dS of every segment.
    type Output = Vec<[[T; D]; 2]>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self(chain, [first, last]) = self;
        let elements = chain.frames.len();
        let mut nodes = vec![first; elements + 1];
        nodes[elements] = last;
        for k in (1..elements).rev() {
            let factor = &chain.factors[k - 1];
            let sum = add(apply(&factor.left, &first), apply(&factor.next, &nodes[k + 1]));
            nodes[k] = scale(-T::one(), sum);
        }
        let mut sums = vec![[[T::zero(); D]; 2]; chain.mesh.segments()];
        for e in 0..elements {
            let change = chain.interior_change::<false>(e, &nodes[e], &nodes[e + 1]);
            let local = chain.local_of(e, &chain.frames[e]);
            let moduli = &chain.moduli[chain.mesh.segment_of[e]];
            let at = chain.at(e, &local);
            let strains = B::strains(&at);
            let after = B::extrapolate(&at, &change);
            let [work, change] = &mut sums[chain.mesh.segment_of[e]];
            for g in 0..P {
                let weight = T::splat(chain.table.weights[g]) * chain.piece(e).length;
                for i in 0..D {
                    let free = T::one() - moduli.held[i];
                    let elastic = strains[g][i] - moduli.rest[i];
                    let here = moduli.stiffness[i] * elastic;
                    let delta = weight * free * (after[g][i] - moduli.held[i] * at.stress[g][i] - here);
                    work[i] += delta * elastic;
                    change[i] += delta;
                }
            }
        }
        sums
    }
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    pub(super) fn variation_impl(&self, lane: usize, ends: &[[f64; D]; 2]) -> Vec<SegmentVariation<D>> {
        let ends = ends.map(|end| end.map(T::splat));
        let sums = T::run(Integrals(self, ends));
        let one = |[work, stress]: &[[T; D]; 2]| SegmentVariation {
            work: lanes::lane(work, lane),
            stress: lanes::lane(stress, lane),
        };
        sums.iter().map(one).collect()
    }
}
