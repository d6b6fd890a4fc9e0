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
use pennate_elements::small::{V3, add, scale, sub, tapply};

use crate::{Chain, lanes};

/// The placing, as work in lanes.
pub(super) struct Unroll<'a, T: Real, B: Beam<T, D>, const D: usize, const P: usize>(pub &'a mut Chain<T, B, D, P>);

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Work for Unroll<'_, T, B, D, P> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.0.unroll_all();
    }
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    #[inline(always)]
    fn unroll_all(&mut self) {
        let elements = self.pieces.len();
        if elements == 1 {
            return;
        }
        let end = self.state.nodes[elements];
        for (e, piece) in self.pieces.iter().enumerate() {
            self.state.nodes[e + 1] = B::last(piece, &self.state.nodes[e], &self.state.local[e * P + P - 1]);
        }
        let missed = scale(T::one() / self.total_length, B::between(&self.state.nodes[elements], &end));
        let mut passed = T::zero();
        for (piece, node) in self.pieces.iter().zip(&mut self.state.nodes[1..]) {
            passed += piece.length;
            B::advance(node, &scale(passed, missed));
        }
        self.state.nodes[elements] = end;
    }

    pub(super) fn carried_impl(&self, lane: usize, end: usize, from: &Placement) -> Placement {
        let first = if end == 1 { *from } else { B::pose(&self.state.nodes[0], lane) };
        let mut last = first;
        let mut chord: V3<f64> = [0.0; 3];
        for (e, piece) in self.pieces.iter().enumerate() {
            let local = lanes::lane(&self.state.local[e * P + P - 1], lane);
            let own = lanes::lane(&piece.chord, lane);
            last = B::interior(piece, &last, own, local, lane);
            chord = add(chord, tapply(&lanes::lanes(&piece.axes, lane), &own));
        }
        if end == 1 {
            return last;
        }
        // The same chain, moved as a whole until its last node is at `from`.
        let moved = compose(from.rotation, inverse(last.rotation));
        let back = turn(moved, sub(first.displacement, last.displacement));
        Placement {
            displacement: add(from.displacement, sub(back, turn_less_identity(moved, chord))),
            rotation: compose(moved, first.rotation),
            angle: from.angle + (first.angle - last.angle),
        }
    }
}
