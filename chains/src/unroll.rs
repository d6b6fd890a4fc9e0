//! Nodes placed one after the other by the local unknowns of the elements.
//!
//! An increment moves the local unknowns of every element linearly, so that its strains change as the linearization
//! foresees; where the nodes go follows by composition along the chain. A long chain that curls up keeps its elements
//! undistorted that way, however far its far end swings.
//!
//! Theory: docs/theory/condensation.md, the way back.

use pennate_elements::beam::{Beam, Placement};
use pennate_elements::real::{Real, Work};
use pennate_elements::rotation::{compose, inverse, turn, turn_less_identity};
use pennate_elements::small::{add, scale, sub};

use crate::ahead::Task;
use crate::{Chain, Pack, lanes};

/// The placing, as work in lanes.
pub(super) struct Unroll<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize> {
    pub chain: &'a mut Chain<T, B, D, P>,
    pub next: Option<&'a dyn Pack<D>>,
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Unroll<'_, T, B, D, P> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.chain.unroll_all(self.next);
    }
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    #[inline(always)]
    fn unroll_all(&mut self, next: Option<&dyn Pack<D>>) {
        let elements = self.frames.len();
        if elements == 1 {
            return;
        }
        let end = self.state.nodes[elements];
        for e in 0..elements {
            if let Some(next) = next {
                next.prefetch(Task::PlaceNodes, e);
            }
            self.state.nodes[e + 1] = B::last(self.piece(e), &self.state.nodes[e], &self.state.local[e * P + P - 1]);
        }
        let missed = scale(T::one() / self.total_length, B::between(&self.state.nodes[elements], &end));
        let mut passed = T::zero();
        for e in 0..elements {
            passed += self.piece(e).length;
            B::advance(&mut self.state.nodes[e + 1], &scale(passed, missed));
        }
        self.state.nodes[elements] = end;
    }

    /// Where the local unknowns carry the end of the member, if its start is where it was unloaded.
    #[inline(always)]
    pub(super) fn reached(&self) -> B::Pose {
        let mut last = B::Pose::default();
        for e in 0..self.frames.len() {
            last = B::last(self.piece(e), &last, &self.state.local[e * P + P - 1]);
        }
        last
    }

    /// The chain with its end at [`Chain::reached`], moved as a whole until its other end is at `from`.
    pub(super) fn carried_impl(&self, lane: usize, end: usize, from: &Placement) -> Placement {
        let reach = B::pose(&self.reach, lane);
        let chord = lanes::lane(&self.chord, lane);
        if end == 1 {
            let shift = add(turn(from.rotation, reach.displacement), turn_less_identity(from.rotation, chord));
            return Placement {
                displacement: add(from.displacement, shift),
                rotation: compose(from.rotation, reach.rotation),
                angle: from.angle + reach.angle,
            };
        }
        let first = compose(from.rotation, inverse(reach.rotation));
        let shift = add(turn(first, reach.displacement), turn_less_identity(first, chord));
        Placement { displacement: sub(from.displacement, shift), rotation: first, angle: from.angle - reach.angle }
    }
}
