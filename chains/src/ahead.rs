//! Memory that is asked for before it is needed.
//!
//! The chains of a large network are more than caches hold, and what an element needs lies in a dozen arrays, of which the processor
//! reads none far enough ahead on its own. So while one pack is worked on, each of its elements asks for what the same element of
//! the next pack needs. Nothing is read or written by that, and no number depends on it.

#![allow(unsafe_code, reason = "the instruction that asks for memory takes a pointer")]

use pennate_elements::beam::{Beam, Ends};
use pennate_elements::real::Real;

use crate::Chain;

/// What the next pack will be asked to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// See [`Pack::condense`](crate::Pack::condense).
    Condense,
    /// See [`Pack::advance`](crate::Pack::advance).
    Advance,
    /// See [`Pack::place_nodes`](crate::Pack::place_nodes).
    PlaceNodes,
    /// See [`Pack::condensed`](crate::Pack::condensed): for members, by lane, in place of elements.
    TakeEnds,
}

/// Asks for a value, into the second-level cache: into the first one it would push out what is being worked on.
#[inline(always)]
fn prefetch<V: ?Sized>(value: &V) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T1, _mm_prefetch};

        /// Bytes that memory comes in.
        const LINE: usize = 64;
        let start: *const i8 = std::ptr::from_ref(value).cast();
        for offset in (0..size_of_val(value)).step_by(LINE) {
            // SAFETY: the offset is within the value, and the instruction takes any address.
            unsafe { _mm_prefetch::<_MM_HINT_T1>(start.add(offset)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}

impl<T: Real, B: Beam<T, D>, const D: usize, const P: usize> Chain<T, B, D, P> {
    /// See [`Pack::prefetch`](crate::Pack::prefetch).
    pub(super) fn prefetch_impl(&self, task: Task, e: usize) {
        if task == Task::TakeEnds {
            return self.prefetch_ends(e);
        }
        let Some(node) = self.state.nodes.get(e + 1) else { return };
        prefetch(node);
        // There may be fewer of them than elements, as of segments.
        if let Some(piece) = self.pieces.get(e) {
            prefetch(piece);
        }
        let local: &[[[T; D]; P]] = self.state.local.as_chunks().0;
        if task == Task::PlaceNodes {
            prefetch(&local[e][P - 1]);
            return;
        }
        // Of the local unknowns elimination reads those within the element.
        if P > 1 || task == Task::Advance {
            prefetch(&local[e]);
        }
        prefetch(self.stress_of(e));
        prefetch(&self.frames[e]);
        if let Some(moduli) = self.moduli.get(e) {
            prefetch(moduli);
        }
        if let Some(factor) = self.factors.get(e) {
            prefetch(factor);
        }
        let rows = |count: usize| e * count..(e + 1) * count;
        if let (Some(blocks), Some(rests)) =
            (self.inner.get(rows(Self::INNER_BLOCKS)), self.inner_rest.get(rows(Self::INNER_NODES)))
        {
            prefetch(blocks);
            prefetch(rests);
        }
        if task == Task::Advance
            && let Some(increment) = self.increments.get(e)
        {
            prefetch(increment);
        }
        if task == Task::Condense && e == 0 {
            prefetch(&self.ends);
        }
    }

    /// Asks for a part of what is left at the ends: all lanes together ask for all of it.
    fn prefetch_ends(&self, lane: usize) {
        let Ends { k00, k01, k11, r0, r1 } = &self.ends;
        for row in (lane..D).step_by(T::LANES) {
            for block in [k00, k01, k11] {
                prefetch(&block[row]);
            }
            for force in [r0, r1, &self.mixed[0], &self.mixed[1]] {
                prefetch(&force[row]);
            }
        }
    }
}
