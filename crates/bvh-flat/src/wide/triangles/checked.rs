//! What [`Layout::write`] never makes.

use geometry::TriangleMesh;

use super::{BIAS, Blocks, Compact, Layout, gather};
use crate::simd::LEAF_NUMBERS;
use crate::wide::node::CheckedNode;

/// A layout whose leaves tell whether they are as `write` makes them.
pub(crate) trait CheckedLayout: Layout<Node: CheckedNode> {
    /// The numbers of a leaf as blocks have them, as far as they are known: those of a compact leaf only with its mesh.
    /// The numbers of the triangles must be in range.
    fn block<'a>(
        stored: &'a [f32; LEAF_NUMBERS],
        count: usize,
        mesh: Option<&TriangleMesh>,
        scratch: &'a mut Self::Scratch,
    ) -> Option<&'a [f32; LEAF_NUMBERS]>;

    /// Whether the leaf's own copies of the vertices are those of the mesh, bit by bit.
    fn equals_mesh(stored: &[f32; LEAF_NUMBERS], count: usize, mesh: &TriangleMesh) -> bool;

    /// The number of triangle `i` of a leaf.
    #[inline(always)]
    fn id(stored: &[f32; LEAF_NUMBERS], count: usize, i: usize) -> u32 {
        stored[Self::place_of_id(count, i) & 127].to_bits().wrapping_sub(BIAS)
    }
}

impl CheckedLayout for Blocks {
    #[inline(always)]
    fn block<'a>(
        stored: &'a [f32; LEAF_NUMBERS],
        _: usize,
        _: Option<&TriangleMesh>,
        (): &'a mut (),
    ) -> Option<&'a [f32; LEAF_NUMBERS]> {
        Some(stored)
    }

    #[inline(always)]
    fn equals_mesh(stored: &[f32; LEAF_NUMBERS], count: usize, mesh: &TriangleMesh) -> bool {
        let mut differences = 0;
        for lane in 0..count {
            let Some(triangle) = mesh.triangles().get(Self::id(stored, count, lane) as usize) else { return false };
            for (vertex, &index) in triangle.iter().enumerate() {
                let Some(position) = mesh.positions().get(index as usize) else { return false };
                for (axis, x) in position.to_array().into_iter().enumerate() {
                    differences |= x.to_bits() ^ stored[(1 + (3 * vertex + axis) * count + lane) & 127].to_bits();
                }
            }
        }
        differences == 0
    }
}

impl CheckedLayout for Compact {
    #[inline(always)]
    fn block<'a>(
        stored: &'a [f32; LEAF_NUMBERS],
        count: usize,
        mesh: Option<&TriangleMesh>,
        scratch: &'a mut [f32; LEAF_NUMBERS],
    ) -> Option<&'a [f32; LEAF_NUMBERS]> {
        gather(mesh?, stored, count, scratch)?;
        Some(scratch)
    }

    /// It has none.
    #[inline(always)]
    fn equals_mesh(_: &[f32; LEAF_NUMBERS], _: usize, _: &TriangleMesh) -> bool {
        true
    }
}
