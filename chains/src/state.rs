//! The state of a chain as a row of numbers: a value that can be kept, copied and compared, whatever the chain's lanes.

use pennate_elements::beam::{Beam, Piece};
use pennate_elements::real::{self, Real, Work};
use pennate_elements::small::{add, axpy, scale, sub};

use crate::Chain;

/// A state of a chain of so many lanes, components and order, seen in its row of numbers: poses of the element ends, local
/// unknowns, mixed stresses.
pub(super) struct Saved<'a> {
    nodes: &'a [f64],
    local: &'a [f64],
    stress: &'a [f64],
}

impl Saved<'_> {
    /// Pose of an element end.
    #[inline(always)]
    pub(super) fn node<T: Real, B: Beam<T, D>, const D: usize>(&self, index: usize) -> B::Pose {
        let size = B::POSE * T::LANES;
        B::load_pose(&self.nodes[index * size..(index + 1) * size])
    }

    /// Local unknowns of the end of an element.
    #[inline(always)]
    fn last_local<T: Real, B: Beam<T, D>, const D: usize>(&self, piece: &Piece<T>, e: usize) -> [T; D] {
        B::last_local(&B::frame(piece, &self.node::<T, B, D>(e), &self.node::<T, B, D>(e + 1)))
    }

    /// Local unknowns, P an element.
    #[inline(always)]
    pub(super) fn local<T: Real, const D: usize>(&self, index: usize) -> [T; D] {
        real::load(&self.local[index * D * T::LANES..(index + 1) * D * T::LANES])
    }

    /// Mixed stresses, P an element.
    #[inline(always)]
    pub(super) fn stress<T: Real, const D: usize>(&self, index: usize) -> [T; D] {
        real::load(&self.stress[index * D * T::LANES..(index + 1) * D * T::LANES])
    }
}

/// The extrapolation from two states, or from three, as work in lanes.
pub(super) struct Predict<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize> {
    pub chain: &'a mut Chain<T, B, D, P>,
    pub before: &'a [f64],
    pub last: &'a [f64],
    pub ratio: f64,
    /// A state before these, and how many times what led from it to the next is added.
    pub bend: Option<(&'a [f64], f64)>,
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Predict<'_, T, B, D, P> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let chain = self.extrapolate();
        chain.reach = chain.reached();
    }
}

impl<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize> Predict<'a, T, B, D, P> {
    #[inline(always)]
    fn extrapolate(self) -> &'a mut Chain<T, B, D, P> {
        let Self { chain, before, last, ratio, bend } = self;
        let [before, last] = [before, last].map(|row| chain.saved(row));
        let ratio = T::splat(ratio);
        let bend = bend.map(|(earlier, times)| (chain.saved(earlier), T::splat(times)));
        for i in 0..chain.state.local.len() {
            let (a, b) = (before.stress::<T, D>(i), last.stress::<T, D>(i));
            let mut stress = add(b, scale(ratio, sub(b, a)));
            if let Some((earlier, times)) = &bend {
                axpy(&mut stress, *times, sub(a, earlier.stress(i)));
            }
            chain.state.stress[i] = stress;
            if i % P + 1 == P {
                continue;
            }
            let (a, b) = (before.local::<T, D>(i), last.local::<T, D>(i));
            let mut local = add(b, scale(ratio, sub(b, a)));
            if let Some((earlier, times)) = &bend {
                axpy(&mut local, *times, sub(a, earlier.local(i)));
            }
            chain.state.local[i] = local;
        }
        for e in 0..chain.frames.len() {
            let piece = chain.piece(e);
            let (a, b) = (before.last_local::<T, B, D>(piece, e), last.last_local::<T, B, D>(piece, e));
            let mut local = add(b, scale(ratio, sub(b, a)));
            if let Some((earlier, times)) = &bend {
                axpy(&mut local, *times, sub(a, earlier.last_local::<T, B, D>(piece, e)));
            }
            chain.state.local[e * P + P - 1] = local;
        }
        chain
    }
}

/// The way back to a saved state, but for a part of the change of the stresses since, as work in lanes.
pub(super) struct Restore<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize> {
    pub chain: &'a mut Chain<T, B, D, P>,
    pub row: &'a [f64],
    pub part: f64,
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Restore<'_, T, B, D, P> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { chain, row, part } = self;
        let saved = chain.saved(row);
        for (i, node) in chain.state.nodes.iter_mut().enumerate() {
            *node = saved.node::<T, B, D>(i);
        }
        for (i, local) in chain.state.local.iter_mut().enumerate() {
            *local = saved.local(i);
        }
        for (i, stress) in chain.state.stress.iter_mut().enumerate() {
            let then = saved.stress(i);
            // Without a part of them, what is no number goes too.
            *stress = if part == 0.0 { then } else { add(then, scale(T::splat(part), sub(*stress, then))) };
        }
    }
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    /// Numbers of the poses, and of the local unknowns or of the stresses, on elements of an order.
    fn counts(&self, order: usize) -> [usize; 2] {
        [self.state.nodes.len() * B::POSE * T::LANES, self.frames.len() * order * D * T::LANES]
    }

    #[inline(always)]
    pub(super) fn saved<'a>(&self, row: &'a [f64]) -> Saved<'a> {
        self.saved_on(row, P)
    }

    /// A state of the same elements of another order.
    #[inline(always)]
    pub(super) fn saved_on<'a>(&self, row: &'a [f64], order: usize) -> Saved<'a> {
        let [nodes, local] = self.counts(order);
        let (nodes, rest) = row.split_at(nodes);
        let (local, stress) = rest.split_at(local);
        Saved { nodes, local, stress }
    }

    pub(super) fn save_impl(&self, row: &mut Vec<f64>) {
        let [nodes, local] = self.counts(P);
        row.resize(nodes + 2 * local, 0.0);
        let (poses, rest) = row.split_at_mut(nodes);
        let (unknowns, stresses) = rest.split_at_mut(local);
        for (pose, numbers) in self.state.nodes.iter().zip(poses.chunks_exact_mut(B::POSE * T::LANES)) {
            B::store_pose(pose, numbers);
        }
        for (all, numbers) in [(&self.state.local, unknowns), (&self.state.stress, stresses)] {
            for (array, numbers) in all.iter().zip(numbers.chunks_exact_mut(D * T::LANES)) {
                real::store(array, numbers);
            }
        }
    }
}
