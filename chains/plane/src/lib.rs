//! All kinds of chains in the plane, compiled: a crate of its own, so that those of the plane, those of space and the solver are
//! compiled side by side.

use pennate_chains::{Pack, Part, Side};
use pennate_elements::lanes::Width;

/// The chain of members that lie side by side in this width.
pub fn pack(width: Width, side: Side<'_, 3>) -> Box<dyn Pack<3>> {
    if side.is_high() { width.run(Part::<3, true>(side)) } else { width.run(Part::<3, false>(side)) }
}
