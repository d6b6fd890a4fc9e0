//! The lateral stiffness of plane chains: what lies between the ends is eliminated, as in their plane.

use pennate_elements::beam::{At, Beam, Ends, Local, Moduli};
use pennate_elements::plane::{self, LateralTurn, Pose};
use pennate_elements::real::{Real, Work, load};
use pennate_elements::rotation;
use pennate_elements::small::{
    Ldl, V3, axpy, cross, madd, mscale, scale, sub_tmul, sub_tmul_symmetric, tmul, transpose, zeros,
};

use crate::{Chain, MOST_LANES, lanes, scratch};

/// What is left of a plane member out of its plane.
#[derive(Clone, Copy, Debug)]
pub struct LateralEnds {
    /// Stiffness of the ends, components uz, φx, φy; they have no forces.
    pub ends: Ends<f64, 3>,
    /// Number of negative pivots of the eliminated interior.
    pub negative: usize,
    /// The smallest pivot over the diagonal entry that elimination left it of.
    pub smallest: f64,
}

/// The tangent of a plane chain out of its plane.
struct Lateral<T> {
    ends: Ends<T, 3>,
    /// Pivots of the interior that are negative, and the largest diagonal entry over the pivot that is left of it.
    negative: T,
    softest: T,
}

/// The elimination, as work in lanes; with the spatial moduli of every segment.
struct Condense<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize>(&'a Chain<T, B, D, P>, &'a [Moduli<T, 6>]);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Condense<'_, T, B, D, P> {
    type Output = Lateral<T>;

    #[inline(always)]
    fn run(self) -> Lateral<T> {
        let mut local = scratch::take();
        let left = self.0.condense_lateral_all(self.1, &mut local);
        scratch::keep(local);
        left
    }
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    pub(super) fn condense_lateral_impl(&self, moduli: &[Vec<Moduli<f64, 6>>]) -> Vec<LateralEnds> {
        let mut all = vec![Moduli::<T, 6>::default(); self.mesh.segments()];
        for (lane, of_member) in moduli.iter().enumerate() {
            for (target, moduli) in all.iter_mut().zip(of_member) {
                for d in 0..6 {
                    target.stiffness[d].set_lane(lane, moduli.stiffness[d]);
                    target.rest[d].set_lane(lane, moduli.rest[d]);
                    target.held[d].set_lane(lane, moduli.held[d]);
                }
                for (target, value) in target.softening.iter_mut().zip(moduli.softening) {
                    target.set_lane(lane, value);
                }
            }
        }
        let Lateral { ends, negative, softest } = T::run(Condense(self, &all));
        let one = |lane: usize| LateralEnds {
            ends: Ends {
                k00: lanes::lanes(&ends.k00, lane),
                k01: lanes::lanes(&ends.k01, lane),
                k11: lanes::lanes(&ends.k11, lane),
                r0: [0.0; 3],
                r1: [0.0; 3],
            },
            negative: negative.lane(lane) as usize,
            smallest: 1.0 / softest.lane(lane),
        };
        (0..self.mesh.members.len()).map(one).collect()
    }

    #[inline(always)]
    fn condense_lateral_all(&self, moduli: &[Moduli<T, 6>], k: &mut Local<T, 3, P>) -> Lateral<T> {
        let o = T::zero();
        let ends = Ends { k00: zeros(), k01: zeros(), k11: zeros(), r0: [o; 3], r1: [o; 3] };
        // A chain in space has no plane that it could leave.
        if D != 3 {
            return Lateral { ends, negative: o, softest: T::one() };
        }
        let (mut negative, mut softest) = (T::zero(), T::one());
        let mut before = self.flat_pose(0);
        let mut chain: Option<Ends<T, 3>> = None;
        for e in 0..self.frames.len() {
            let after = self.flat_pose(e + 1);
            let next = self.lateral_element(e, moduli, [&before, &after], k, &mut negative, &mut softest);
            before = after;
            chain = Some(match chain {
                None => next,
                Some(so_far) => {
                    let ldl = Ldl::new(&madd(so_far.k11, next.k00));
                    negative += ldl.negative;
                    softest = softest.max(ldl.largest);
                    let link = transpose(&so_far.k01);
                    let (back, ahead) = (ldl.solve(&link), ldl.solve(&next.k01));
                    let mut joined =
                        Ends { k00: so_far.k00, k01: mscale(-T::one(), tmul(&link, &ahead)), k11: next.k11, ..next };
                    sub_tmul_symmetric(&mut joined.k00, &link, &back);
                    sub_tmul_symmetric(&mut joined.k11, &next.k01, &ahead);
                    joined
                }
            });
        }
        Lateral { ends: chain.unwrap_or(ends), negative, softest }
    }

    /// Where a node of a plane chain is.
    #[inline(always)]
    fn flat_pose(&self, node: usize) -> Pose<T> {
        let mut row = [0.0; 3 * MOST_LANES];
        let row = &mut row[..3 * T::LANES];
        B::store_pose(&self.state.nodes[node], row);
        load(row)
    }

    /// Lateral stiffness of one element between its ends.
    #[inline(always)]
    fn lateral_element(
        &self,
        e: usize,
        moduli: &[Moduli<T, 6>],
        [first, last]: [&Pose<T>; 2],
        k: &mut Local<T, 3, P>,
        negative: &mut T,
        softest: &mut T,
    ) -> Ends<T, 3> {
        let piece = self.piece(e);
        let segment = self.mesh.segment_of[e];
        let frame = <plane::Plane as Beam<T, 3>>::frame(piece, first, last);
        let (mut local, mut stress) = ([[T::zero(); 3]; P], [[T::zero(); 3]; P]);
        for i in 0..P {
            local[i].copy_from_slice(&self.state.local[e * P + i][..3]);
            stress[i].copy_from_slice(&self.state.stress[e * P + i][..3]);
        }
        local[P - 1] = frame.local;
        let moduli = &moduli[segment];
        let flat = plane::plane_moduli(moduli);
        let curved = self.curved(e);
        let at = At { table: &self.table, piece, curved, moduli: &flat, local: &local, stress: &stress };
        plane::lateral::<T, B::Law, P>(&at, moduli, k);

        // Weight in the plane turns with the frame about axes 1 and 2.
        let mut turn = None;
        let mut coupling = [zeros::<T, 3, 3>(); P];
        if self.loaded {
            let load: V3<T> = scale(piece.length, self.loads[segment]);
            let load = <plane::Plane as Beam<T, 3>>::pull_back(&frame, load);
            let mut arm = scale(T::one() / piece.length, piece.bulge);
            for i in 0..P - 1 {
                let weight = T::splat(self.table.integrals[i]);
                let mut position = self.reference(e, i);
                position[0] += local[i][0];
                position[1] += local[i][1];
                axpy(&mut arm, weight, position);
                // Row U₃ of the spatial coupling: columns of the spins about axes 1 and 2.
                coupling[i][0] = [weight * load[1], -weight * load[0], T::zero()];
            }
            let moment = cross(load, arm)[2];
            let tangent = mscale(-T::one(), rotation::second_variation(load, arm));
            turn = Some(LateralTurn { tangent, coupling: zeros(), moment });
        }
        for i in 0..P - 1 {
            let (above, below) = k.tangent.split_at_mut(i + 1);
            let row = &above[i];
            let ldl = Ldl::new(&row[i]);
            *negative += ldl.negative;
            *softest = softest.max(ldl.largest);
            if let Some(turn) = &mut turn {
                let solved = ldl.solve(&coupling[i]);
                sub_tmul_symmetric(&mut turn.tangent, &coupling[i], &solved);
                for j in i + 1..P {
                    sub_tmul(&mut coupling[j], &row[j], &solved);
                }
            }
            for j in i + 1..P {
                let solved = ldl.solve(&row[j]);
                for l in i + 1..j {
                    sub_tmul(&mut below[l - i - 1][j], &row[l], &solved);
                }
                sub_tmul_symmetric(&mut below[j - i - 1][j], &row[j], &solved);
            }
        }
        let turn = turn.map(|turn| LateralTurn { coupling: coupling[P - 1], ..turn });
        plane::expand_lateral(&frame, &k.tangent[P - 1][P - 1], k.mixed_end, turn.as_ref())
    }
}
