//! What [`Layout::write`] never makes.

use super::{BIAS, Blocks, Compact, Layout};
use crate::simd::{LANES, LEAF_NUMBERS};
use crate::wide::node::CheckedNode;

/// A layout whose leaves tell whether they are as `write` makes them.
pub(crate) trait CheckedLayout: Layout<Node: CheckedNode> {
    /// Whether leaves have copies of the vertices.
    const HAS_VERTICES: bool;

    /// The numbers of the triangles of a leaf, and what eight lanes have too much.
    #[inline(always)]
    fn ids(stored: &[f32; LEAF_NUMBERS], count: usize) -> [u32; LANES] {
        let first = Self::place_of_id(count, 0) & 127;
        std::array::from_fn(|lane| stored[first + lane].to_bits().wrapping_sub(BIAS))
    }
}

impl CheckedLayout for Blocks {
    const HAS_VERTICES: bool = true;
}

impl CheckedLayout for Compact {
    const HAS_VERTICES: bool = false;
}
