//! Elimination of what lies between the ends of a member, and the way back.

use pennate_elements::beam::{At, Beam, Condensed, Ends, Local, Moduli, Turn};
use pennate_elements::real::{Real, Work};
use pennate_elements::small::{Ldl, add, apply, axpy, madd, mscale, scale, sub, tapply, tmul, transpose, zeros};

use super::lanes::{mul_block, sub_matrix};
use super::{Chain, NodeFactor};

/// The elimination, as work in lanes.
pub(super) struct Condense<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize>(pub &'a mut Chain<T, B, D, P>);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Condense<'_, T, B, D, P> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.0.condense_all();
    }
}

/// The way back, as work in lanes.
pub(super) struct Advance<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize>(pub &'a mut Chain<T, B, D, P>);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Advance<'_, T, B, D, P> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.0.advance_all();
    }
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    /// Condenses one element to its last node, and stores the factors.
    #[inline(always)]
    fn condense_element(&mut self, e: usize, k: &mut Local<T, D, P>) -> Ends<T, D> {
        let frame = B::frame(&self.pieces[e], &self.state.nodes[e], &self.state.nodes[e + 1]);
        self.frames[e] = frame;
        let local = self.local_of(e, &frame);
        let moduli = self.moduli[self.segment_of[e]];
        if self.plain {
            self.reset_stress(e, &local, &moduli);
        }
        let stress = self.stress_of(e);
        let at = At {
            table: &self.table,
            piece: &self.pieces[e],
            curved: self.curved(e),
            moduli: &moduli,
            local: &local,
            stress: &stress,
        };
        B::local::<P, true>(&at, k);
        self.energy += k.energy;

        if self.dashpots.stiffness > 0.0 {
            for i in 0..P - 1 {
                let node = e * Self::INNER_NODES + i;
                for d in 0..D {
                    k.tangent[i][i][d][d] += self.dashpots.inner_stiffness[node][d];
                    k.gradient[i][d] += self.dashpots.inner_force[node][d];
                }
            }
        }
        let mut turn = None;
        if self.loaded {
            turn = Some(self.load_element(e, &frame, &local, k));
        }
        let mut coupling = turn.map(|t| t.1);
        let (blocks, nodes) = (e * Self::INNER_BLOCKS, e * Self::INNER_NODES);
        let mut block = blocks;
        for i in 0..P - 1 {
            let ldl = Ldl::with_noise(&k.tangent[i][i], T::splat(self.noise));
            self.negative += ldl.negative;
            self.smallest = -((-self.smallest).max(-ldl.smallest));
            let rest = ldl.solve_vector(&k.gradient[i]);
            self.inner_rest[nodes + i] = rest;
            if let (Some((t, _)), Some(coupling)) = (&mut turn, &mut coupling) {
                let solved = ldl.solve(&coupling[i]);
                self.inner_turn[nodes + i] = solved;
                let own = coupling[i];
                t.tangent = sub_matrix(t.tangent, tmul(&own, &solved));
                t.gradient = sub(t.gradient, tapply(&own, &rest));
                for (j, row) in k.tangent[i].iter().enumerate().skip(i + 1) {
                    coupling[j] = sub_matrix(coupling[j], tmul(row, &solved));
                }
            }
            for j in i + 1..P {
                let kij = k.tangent[i][j];
                let solved = ldl.solve(&kij);
                self.inner[block] = solved;
                block += 1;
                k.gradient[j] = sub(k.gradient[j], tapply(&kij, &rest));
                for l in i + 1..=j {
                    let other = k.tangent[i][l];
                    let update = tmul(&other, &solved);
                    k.tangent[l][j] = sub_matrix(k.tangent[l][j], update);
                }
            }
        }
        let turn = turn.map(|(t, _)| Turn { coupling: coupling.unwrap_or([zeros(); P])[P - 1], ..t });
        let condensed =
            Condensed { tangent: k.tangent[P - 1][P - 1], gradient: k.gradient[P - 1], mixed_end: k.mixed_end, turn };
        let mut ends = B::expand(&frame, &condensed);
        if self.loaded {
            let force = scale(self.pieces[e].length, self.loads[self.segment_of[e]]);
            let last = T::splat(self.table.integrals[P - 1]);
            for d in 0..Self::TRANSLATIONS {
                ends.r0[d] -= (T::one() - last) * force[d];
                ends.r1[d] -= last * force[d];
            }
        }
        ends
    }

    /// Stresses of the present strains in place of mixed ones; multipliers stay.
    #[inline(always)]
    fn reset_stress(&mut self, e: usize, local: &[[T; D]; P], moduli: &Moduli<T, D>) {
        let stress = self.stress_of(e);
        let at =
            At { table: &self.table, piece: &self.pieces[e], curved: self.curved(e), moduli, local, stress: &stress };
        let stress = B::extrapolate(&at, &[[T::zero(); D]; P]);
        self.state.stress[e * P..(e + 1) * P].copy_from_slice(&stress);
    }

    /// Adds the load along an element to its interior nodes; gives what couples to the turn of the frame.
    #[inline(always)]
    fn load_element(
        &self,
        e: usize,
        frame: &B::Frame,
        local: &[[T; D]; P],
        k: &mut Local<T, D, P>,
    ) -> (Turn<T, D>, [[[T; 3]; D]; P]) {
        let load = scale(self.pieces[e].length, B::pull_back(frame, self.loads[self.segment_of[e]]));
        let inverse = T::one() / self.pieces[e].length;
        let mut arm = scale(inverse, self.pieces[e].bulge);
        let mut coupling = [zeros(); P];
        for i in 0..P - 1 {
            let weight = T::splat(self.table.integrals[i]);
            let mut position = self.reference(e, i);
            for d in 0..Self::TRANSLATIONS {
                position[d] += local[i][d];
                k.gradient[i][d] -= weight * load[d];
            }
            axpy(&mut arm, weight, position);
            coupling[i] = B::load_coupling(scale(weight, load));
        }
        let (gradient, tangent) = B::load_turn(load, arm);
        (Turn { coupling: zeros(), tangent, gradient }, coupling)
    }

    #[inline(always)]
    fn condense_all(&mut self) {
        self.negative = T::zero();
        self.smallest = T::one();
        self.energy = T::zero();
        // One place for all elements: clearing what counts is cheaper than a new one for each.
        let mut k = Local::zero();
        let first = self.condense_element(0, &mut k);
        let (mut left, mut link, mut here) = (first.k00, first.k01, first.k11);
        let (mut left_rest, mut rest) = (first.r0, first.r1);
        for e in 1..self.frames.len() {
            let next = self.condense_element(e, &mut k);
            let mut pivot = madd(here, next.k00);
            if self.dashpots.stiffness > 0.0 {
                for d in 0..D {
                    pivot[d][d] += self.dashpots.stiffnesses[e][d];
                    rest[d] += self.dashpots.forces[e][d];
                }
            }
            let ldl = Ldl::with_noise(&pivot, T::splat(self.noise));
            self.negative += ldl.negative;
            self.smallest = -((-self.smallest).max(-ldl.smallest));
            let factor = NodeFactor {
                left: ldl.solve(&transpose(&link)),
                next: ldl.solve(&next.k01),
                rest: ldl.solve_vector(&add(rest, next.r0)),
            };
            left = sub_matrix(left, mul_block(&link, &factor.left));
            left_rest = sub(left_rest, apply(&link, &factor.rest));
            here = sub_matrix(next.k11, tmul(&next.k01, &factor.next));
            rest = sub(next.r1, tapply(&next.k01, &factor.rest));
            link = mscale(-T::one(), mul_block(&link, &factor.next));
            self.factors[e - 1] = factor;
        }
        self.ends = Ends { k00: left, k01: link, k11: here, r0: left_rest, r1: rest };
    }

    /// Change of the local unknowns of an element for a motion of its ends; with `RESIDUAL` also for the forces that
    /// were left inside it.
    #[inline(always)]
    pub(super) fn interior_change<const RESIDUAL: bool>(&self, e: usize, first: &[T; D], last: &[T; D]) -> [[T; D]; P] {
        let (last, turn) = B::restrict(&self.frames[e], first, last);
        let mut change = [[T::zero(); D]; P];
        change[P - 1] = last;
        let (blocks, nodes) = (e * Self::INNER_BLOCKS, e * Self::INNER_NODES);
        for i in (0..P - 1).rev() {
            let mut sum = if RESIDUAL { self.inner_rest[nodes + i] } else { [T::zero(); D] };
            // Blocks of row i start after those of the rows before it.
            let row = blocks + i * (2 * P - i - 1) / 2;
            for j in i + 1..P {
                sum = add(sum, apply(&self.inner[row + j - i - 1], &change[j]));
            }
            if self.loaded {
                sum = add(sum, apply(&self.inner_turn[nodes + i], &turn));
            }
            change[i] = scale(-T::one(), sum);
        }
        change
    }

    #[inline(always)]
    fn advance_all(&mut self) {
        let elements = self.frames.len();
        let first = self.increments[0];
        for k in (1..elements).rev() {
            let factor = &self.factors[k - 1];
            let ahead = self.increments[k + 1];
            let sum = add(add(apply(&factor.left, &first), apply(&factor.next, &ahead)), factor.rest);
            self.increments[k] = scale(-T::one(), sum);
        }
        for e in 0..elements {
            let frame = self.frames[e];
            let change = self.interior_change::<true>(e, &self.increments[e], &self.increments[e + 1]);
            let local = self.local_of(e, &frame);
            let stress = self.stress_of(e);
            let moduli = self.moduli[self.segment_of[e]];
            let at = At {
                table: &self.table,
                piece: &self.pieces[e],
                curved: self.curved(e),
                moduli: &moduli,
                local: &local,
                stress: &stress,
            };
            let stress = B::extrapolate(&at, &change);
            for i in 0..P {
                self.state.stress[e * P + i] = stress[i];
                self.state.local[e * P + i] = add(local[i], change[i]);
            }
            let ends = [&self.state.nodes[e], &self.state.nodes[e + 1]];
            let turns = [&self.increments[e], &self.increments[e + 1]];
            self.state.local[e * P + P - 1] = B::moved(&self.pieces[e], ends, turns, &local[P - 1], &change[P - 1]);
        }
    }
}
