//! The chains in space of elements of the higher orders, compiled: see [`Side::is_high`].

use pennate_chains::{Pack, Part, Side};
use pennate_elements::lanes::Width;

/// The chain of members that lie side by side in this width.
pub fn pack(width: Width, side: Side<'_, 6>) -> Box<dyn Pack<6>> {
    width.run(Part::<6, true>(side))
}
