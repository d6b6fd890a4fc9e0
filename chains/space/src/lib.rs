//! The chains in space of elements of the lower orders, compiled: those of the higher ones are another crate, since all kinds in
//! space take as long to compile as the rest of the program.

use pennate_chains::{Pack, Part, Side};
use pennate_elements::lanes::Width;

/// The chain of members that lie side by side in this width.
pub fn pack(width: Width, side: Side<'_, 6>) -> Box<dyn Pack<6>> {
    width.run(Part::<6, false>(side))
}
