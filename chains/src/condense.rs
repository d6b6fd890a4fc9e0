//! Elimination of what lies between the ends of a member, and the way back.
//!
//! Theory: docs/theory/condensation.md, Eq. 4.1 to 4.5.

use pennate_elements::beam::{Beam, Condensed, Ends, Local, Turn};
use pennate_elements::real::{Real, Work, load};
use pennate_elements::small::{
    Ldl, add, axpy, madd, scale, sub_apply, sub_tapply, sub_tmul, sub_tmul_symmetric, transpose, zeros,
};

use crate::ahead::Task;
use crate::{Chain, NodeFactor, Pack, scratch};

/// Pivots smaller than this part of the diagonal entry they came from are rounding: a unit in the last place for each of a
/// few operations.
pub const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The elimination, as work in lanes.
pub(super) struct Condense<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize> {
    pub chain: &'a mut Chain<T, B, D, P>,
    pub next: Option<&'a dyn Pack<D>>,
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Condense<'_, T, B, D, P> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let mut local = scratch::take();
        self.chain.condense_all(self.next, &mut local);
        scratch::keep(local);
    }
}

/// Forces on the ends by the factors of the last elimination, or of that of another chain, as work in lanes; with `RESTS` what is
/// left inside as well, by the factors that this chain keeps.
pub(super) struct Refresh<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize, const RESTS: bool>(
    pub &'a mut Chain<T, B, D, P>,
    pub Option<&'a Chain<T, B, D, P>>,
);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize, const RESTS: bool> Work
    for Refresh<'_, T, B, D, P, RESTS>
{
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let mut local = scratch::take();
        self.0.refresh_all::<RESTS>(self.1, &mut local);
        scratch::keep(local);
    }
}

/// The way back from motions of joints, as work in lanes.
pub(super) struct Advance<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize> {
    pub chain: &'a mut Chain<T, B, D, P>,
    pub motions: &'a [f64],
    pub joints: [usize; 2],
    pub next: Option<&'a dyn Pack<D>>,
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Advance<'_, T, B, D, P> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { chain, motions, joints, next } = self;
        let last = chain.increments.len() - 1;
        let size = D * T::LANES;
        chain.increments[0] = load(&motions[joints[0] * size..(joints[0] + 1) * size]);
        chain.increments[last] = load(&motions[joints[1] * size..(joints[1] + 1) * size]);
        chain.advance_all(next);
    }
}

/// What elimination subtracts from at both ends, as work in lanes.
pub(super) struct Bare<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize>(pub &'a Chain<T, B, D, P>);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Bare<'_, T, B, D, P> {
    type Output = [[[T; D]; D]; 2];

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Chain { frames, bare: [start, end], .. } = self.0;
        let o = [T::zero(); D];
        let mut own = Condensed { tangent: zeros(), gradient: o, mixed_end: o, turn: None };
        for d in 0..D {
            own.tangent[d][d] = start[d];
        }
        let first = B::expand(&frames[0], &own).k00;
        for d in 0..D {
            own.tangent[d][d] = end[d];
        }
        [first, B::expand(&frames[frames.len() - 1], &own).k11]
    }
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    /// Makes room for all factors.
    pub(super) fn keep_factors(&mut self) {
        let elements = self.frames.len();
        if self.kept.own.len() + 1 == elements && self.kept.inner_own.len() == elements * Self::INNER_NODES {
            return;
        }
        let zero = Ldl::new(&zeros());
        self.kept.own.resize(elements - 1, zero);
        self.kept.inner_own.resize(elements * Self::INNER_NODES, zero);
    }

    /// What an element is at its present state: its frame, and its local unknowns.
    #[inline(always)]
    fn evaluate<const TANGENT: bool>(&mut self, e: usize, k: &mut Local<T, D, P>) -> (B::Frame, [[T; D]; P]) {
        let frame = B::frame(self.piece(e), &self.state.nodes[e], &self.state.nodes[e + 1]);
        self.frames[e] = frame;
        let local = self.local_of(e, &frame);
        if self.settings.plain {
            self.reset_stress(e, &local);
        }
        let at = self.at(e, &local);
        B::local::<P, TANGENT>(&at, k);
        self.energy += k.energy;

        if self.settings.acts_on_nodes() {
            for i in 0..P - 1 {
                let node = e * Self::INNER_NODES + i;
                for d in 0..D {
                    if TANGENT {
                        k.tangent[i][i][d][d] += self.dashpots.inner_stiffness[node][d];
                    }
                    k.gradient[i][d] += self.dashpots.inner_force[node][d];
                }
            }
        }
        (frame, local)
    }

    /// Makes room for the factors of an element and of its first node, where there was none: memory that is cleared right before it is
    /// written costs little, and to clear that of a large network apart is one more way through all of it.
    #[inline(always)]
    fn make_room(&mut self, e: usize) {
        if self.inner_rest.len() < (e + 1) * Self::INNER_NODES {
            self.inner.resize((e + 1) * Self::INNER_BLOCKS, zeros());
            self.inner_rest.resize((e + 1) * Self::INNER_NODES, [T::zero(); D]);
        }
        if self.factors.len() < e {
            self.factors.resize(e, NodeFactor { left: zeros(), next: zeros(), rest: [T::zero(); D] });
        }
    }

    /// Condenses one element to its last node, and stores the factors.
    #[inline(always)]
    fn condense_element(&mut self, e: usize, k: &mut Local<T, D, P>) -> Ends<T, D> {
        self.make_room(e);
        let (frame, local) = self.evaluate::<true>(e, k);
        if e == 0 || e + 1 == self.frames.len() {
            for d in 0..D {
                let own = k.tangent[P - 1][P - 1][d][d].abs();
                self.bare[1][d] = own;
                if e == 0 {
                    self.bare[0][d] = own;
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
            let (above, below) = k.tangent.split_at_mut(i + 1);
            let row = &above[i];
            let ldl = Ldl::with_noise(&row[i], T::splat(ROUNDING));
            self.negative += ldl.negative;
            self.softest = self.softest.max(ldl.largest);
            let rest = ldl.solve_vector(&k.gradient[i]);
            if let (Some((t, _)), Some(coupling)) = (&mut turn, &mut coupling) {
                let solved = ldl.solve(&coupling[i]);
                let own = coupling[i];
                sub_tmul_symmetric(&mut t.tangent, &own, &solved);
                sub_tapply(&mut t.gradient, &own, &rest);
                for (coupling, own) in coupling.iter_mut().zip(row).skip(i + 1) {
                    sub_tmul(coupling, own, &solved);
                }
                self.inner_turn[nodes + i] = solved;
            }
            if let Some(kept) = self.kept.inner_own.get_mut(nodes + i) {
                *kept = ldl;
            }
            for j in i + 1..P {
                let solved = &mut self.inner[block];
                ldl.solve_into(&row[j], solved);
                block += 1;
                sub_tapply(&mut k.gradient[j], &row[j], &rest);
                for l in i + 1..j {
                    sub_tmul(&mut below[l - i - 1][j], &row[l], solved);
                }
                sub_tmul_symmetric(&mut below[j - i - 1][j], &row[j], solved);
            }
            self.inner_rest[nodes + i] = rest;
        }
        let turn = match (turn, coupling) {
            (Some((turn, _)), Some(coupling)) => Some(Turn { coupling: coupling[P - 1], ..turn }),
            _ => None,
        };
        let condensed =
            Condensed { tangent: k.tangent[P - 1][P - 1], gradient: k.gradient[P - 1], mixed_end: k.mixed_end, turn };
        let mut ends = B::expand(&frame, &condensed);
        self.add_load_on_ends(e, [&mut ends.r0, &mut ends.r1]);
        let own = [e == 0, e + 1 == self.frames.len()];
        if own[0] || own[1] {
            let mut mixed = B::expand_gradient(&frame, &k.mixed_end, [T::zero(); 3]);
            let [first, last] = &mut mixed;
            self.add_load_on_ends(e, [first, last]);
            for end in (0..2).filter(|&end| own[end]) {
                self.mixed[end] = mixed[end];
            }
        }
        ends
    }

    /// The load along an element that its ends take without its interior.
    #[inline(always)]
    fn add_load_on_ends(&self, e: usize, [first, last]: [&mut [T; D]; 2]) {
        if !self.loaded {
            return;
        }
        let force = scale(self.piece(e).length, self.loads[self.mesh.segment_of[e]]);
        let part = T::splat(self.table.integrals[P - 1]);
        for d in 0..Self::TRANSLATIONS {
            first[d] -= (T::one() - part) * force[d];
            last[d] -= part * force[d];
        }
    }

    /// Forces on the ends of one element at its present state, by the factors that were stored here or in another chain; with
    /// `RESTS` what is left inside it as well, for the way back.
    #[inline(always)]
    fn refresh_element<const RESTS: bool>(
        &mut self,
        e: usize,
        source: Option<&Self>,
        k: &mut Local<T, D, P>,
    ) -> [[T; D]; 2] {
        let (frame, local) = self.evaluate::<false>(e, k);
        let mut turn = [T::zero(); 3];
        if self.loaded {
            turn = self.load_element(e, &frame, &local, k).0.gradient;
        }
        let (mut block, nodes) = (e * Self::INNER_BLOCKS, e * Self::INNER_NODES);
        for i in 0..P - 1 {
            let own = k.gradient[i];
            if RESTS {
                self.inner_rest[nodes + i] = self.kept.inner_own[nodes + i].solve_vector(&own);
            }
            let factors = source.unwrap_or(self);
            // What couples to the turn goes with the load: without one there is none.
            if factors.loaded {
                sub_tapply(&mut turn, &factors.inner_turn[nodes + i], &own);
            }
            for j in i + 1..P {
                sub_tapply(&mut k.gradient[j], &factors.inner[block], &own);
                block += 1;
            }
        }
        let [mut first, mut last] = B::expand_gradient(&frame, &k.gradient[P - 1], turn);
        self.add_load_on_ends(e, [&mut first, &mut last]);
        [first, last]
    }

    /// Forces on the ends of the member: x_ij stand for what elimination makes of those inside.
    #[inline(always)]
    fn refresh_all<const RESTS: bool>(&mut self, source: Option<&Self>, k: &mut Local<T, D, P>) {
        self.energy = T::zero();
        let [mut left, mut rest] = self.refresh_element::<RESTS>(0, source, k);
        for e in 1..self.frames.len() {
            let [first, last] = self.refresh_element::<RESTS>(e, source, k);
            rest = add(rest, first);
            if self.settings.acts_on_nodes() {
                rest = add(rest, self.dashpots.forces[e]);
            }
            if RESTS {
                self.factors[e - 1].rest = self.kept.own[e - 1].solve_vector(&rest);
            }
            let factor = &source.unwrap_or(self).factors[e - 1];
            sub_tapply(&mut left, &factor.left, &rest);
            let mut next = last;
            sub_tapply(&mut next, &factor.next, &rest);
            rest = next;
        }
        (self.ends.r0, self.ends.r1) = (left, rest);
    }

    /// Stresses of the present strains in place of mixed ones; multipliers stay.
    #[inline(always)]
    fn reset_stress(&mut self, e: usize, local: &[[T; D]; P]) {
        let stress = B::extrapolate(&self.at(e, local), &[[T::zero(); D]; P]);
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
        let load = scale(self.piece(e).length, B::pull_back(frame, self.loads[self.mesh.segment_of[e]]));
        let inverse = T::one() / self.piece(e).length;
        let mut arm = scale(inverse, self.piece(e).bulge);
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
    fn condense_all(&mut self, coming: Option<&dyn Pack<D>>, k: &mut Local<T, D, P>) {
        self.negative = T::zero();
        self.softest = T::one();
        self.energy = T::zero();
        if let Some(pack) = coming {
            pack.prefetch(Task::Condense, 0);
        }
        let first = self.condense_element(0, k);
        let (mut left, mut here) = (first.k00, first.k11);
        let (mut left_rest, mut rest) = (first.r0, first.r1);
        // How the last node depends on the first: rows of the last, columns of the first.
        let mut link = transpose(&first.k01);
        for e in 1..self.frames.len() {
            if let Some(pack) = coming {
                pack.prefetch(Task::Condense, e);
            }
            let next = self.condense_element(e, k);
            let mut pivot = madd(here, next.k00);
            rest = add(rest, next.r0);
            if self.settings.acts_on_nodes() {
                for d in 0..D {
                    pivot[d][d] += self.dashpots.stiffnesses[e][d];
                    rest[d] += self.dashpots.forces[e][d];
                }
            }
            let ldl = Ldl::with_noise(&pivot, T::splat(ROUNDING));
            self.negative += ldl.negative;
            self.softest = self.softest.max(ldl.largest);
            let factor = &mut self.factors[e - 1];
            ldl.solve_into(&link, &mut factor.left);
            ldl.solve_into(&next.k01, &mut factor.next);
            factor.rest = ldl.solve_vector(&rest);
            if let Some(kept) = self.kept.own.get_mut(e - 1) {
                *kept = ldl;
            }
            sub_tmul_symmetric(&mut left, &link, &factor.left);
            sub_tapply(&mut left_rest, &link, &factor.rest);
            here = next.k11;
            sub_tmul_symmetric(&mut here, &next.k01, &factor.next);
            rest = next.r1;
            sub_tapply(&mut rest, &next.k01, &factor.rest);
            let mut coupled = zeros();
            sub_tmul(&mut coupled, &factor.next, &link);
            link = coupled;
        }
        let mut ends = Ends { k00: left, k01: transpose(&link), k11: here, r0: left_rest, r1: rest };
        if !self.settings.acts_on_nodes() {
            balance(&mut ends, Self::TRANSLATIONS);
        }
        self.ends = ends;
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
            let mut sum = [T::zero(); D];
            if RESIDUAL {
                sum = scale(-T::one(), self.inner_rest[nodes + i]);
            }
            // Blocks of row i start after those of the rows before it.
            let row = blocks + i * (2 * P - i - 1) / 2;
            for j in i + 1..P {
                sub_apply(&mut sum, &self.inner[row + j - i - 1], &change[j]);
            }
            if self.loaded {
                sub_apply(&mut sum, &self.inner_turn[nodes + i], &turn);
            }
            change[i] = sum;
        }
        change
    }

    #[inline(always)]
    fn advance_all(&mut self, next: Option<&dyn Pack<D>>) {
        let elements = self.frames.len();
        let first = self.increments[0];
        for k in (1..elements).rev() {
            let factor = &self.factors[k - 1];
            let ahead = self.increments[k + 1];
            let mut increment = scale(-T::one(), factor.rest);
            sub_apply(&mut increment, &factor.left, &first);
            sub_apply(&mut increment, &factor.next, &ahead);
            self.increments[k] = increment;
        }
        for e in 0..elements {
            if let Some(next) = next {
                next.prefetch(Task::Advance, e);
            }
            let frame = self.frames[e];
            let change = self.interior_change::<true>(e, &self.increments[e], &self.increments[e + 1]);
            let local = self.local_of(e, &frame);
            let stress = B::extrapolate(&self.at(e, &local), &change);
            for i in 0..P {
                self.state.stress[e * P + i] = stress[i];
                self.state.local[e * P + i] = add(local[i], change[i]);
            }
            let ends = [&self.state.nodes[e], &self.state.nodes[e + 1]];
            let turns = [&self.increments[e], &self.increments[e + 1]];
            self.state.local[e * P + P - 1] = B::moved(self.piece(e), ends, turns, &local[P - 1], &change[P - 1]);
        }
        self.sizes = self.sizes();
        self.reach = self.reached();
    }
}

/// Makes the stiffness of a member that moves as a whole exactly zero, by what its last end has.
///
/// Elimination leaves the rounding of the axial stiffness of an element there, which is what a slender frame would sway
/// against.
#[inline(always)]
fn balance<T: Real, const D: usize>(ends: &mut Ends<T, D>, translations: usize) {
    let o = T::zero();
    for t in 0..translations {
        for j in 0..D {
            ends.k01[t][j] = o - ends.k11[t][j];
        }
    }
    for t in 0..translations {
        for i in 0..D {
            let own = o - ends.k01[i][t];
            ends.k00[i][t] = own;
            ends.k00[t][i] = own;
        }
    }
}
