//! Memory for the tangents of one element, which the packs of a thread work in one after the other.
//!
//! An element of order 4 in space has 36 kB of them in lanes of eight. They are written anew for every element, but a value has to
//! begin as something: to set it to zero for every pack took a twentieth of the time of a network of few members.

use std::any::Any;
use std::cell::Cell;

use pennate_elements::beam::Local;
use pennate_elements::real::Real;

thread_local! {
    /// What the last pack worked in.
    static LAST: Cell<Option<Box<dyn Any>>> = const { Cell::new(None) };
}

/// Memory of the last pack, where that was of the same kind: its numbers are anything.
///
/// What works in lanes calls this and works on: what is handed to a function as a closure is none of the lanes' any more.
#[inline(never)]
pub(crate) fn take<T: Real, const D: usize, const P: usize>() -> Box<Local<T, D, P>> {
    match LAST.take().map(<Box<dyn Any>>::downcast) {
        Some(Ok(local)) => local,
        _ => Box::new(Local::zero()),
    }
}

/// Leaves it to the next pack.
#[inline(never)]
pub(crate) fn keep<T: Real, const D: usize, const P: usize>(local: Box<Local<T, D, P>>) {
    LAST.set(Some(local));
}
