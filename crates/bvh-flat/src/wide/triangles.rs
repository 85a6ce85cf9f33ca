//! Triangles in the leaves of a wide tree.

use std::ops::Range;

use geometry::TriangleMesh;
use geometry::glam::Vec3;

use super::arena::{Arena, Child, Line};
use super::collapse::LeafWriter;
use crate::simd::LEAF_NUMBERS;

/// Numbers of primitives are stored with this added: small ones, read as f32 by a load that begins in the numbers before
/// them, would be denormal, which some processors are slow at.
const BIAS: u32 = 0x3f80_0000;

/// Writes the triangles of a mesh into leaves. Of n triangles: their largest extent along any axis; nine times n
/// coordinates, of the first vertices x, y and z, of the second, of the third; and n numbers.
///
/// They are not padded to eight: a load of eight lanes goes on into what follows, and the lanes from n on are masked.
pub(crate) struct TriangleBlocks<'a> {
    pub(crate) mesh: &'a TriangleMesh,
    pub(crate) order: &'a [u32],
}

impl LeafWriter for TriangleBlocks<'_> {
    fn write(&self, range: Range<usize>, lines: &mut Vec<Line>) -> usize {
        let place = lines.len();
        let ids = &self.order[range];
        let triangles = ids.iter().map(|&i| self.mesh.vertices(i as usize));
        // Rounded up: a difference of two f32 is wrong by half an ulp.
        let extent = triangles.clone().map(|v| largest_extent(&v)).fold(0.0, f32::max).next_up();
        let mut words = vec![extent.to_bits()];
        for vertex in 0..3 {
            for axis in 0..3 {
                words.extend(triangles.clone().map(|v| v[vertex][axis].to_bits()));
            }
        }
        words.extend(ids.iter().map(|id| id.wrapping_add(BIAS)));
        lines.extend(words.chunks(16).map(|chunk| {
            let mut line = Line::default();
            line.0[..chunk.len()].copy_from_slice(chunk);
            line
        }));
        place
    }

    /// A step to a leaf takes half as much time again as one to a node, whatever it holds; the rest makes the tree that
    /// tests less win among equal ones. (From 0.5 to 2.5 for the leaf and 0 to 0.3 for a triangle, nothing was faster by
    /// more than the noise on bunny, sponza and kitchen; but 0.3 takes a fifth more memory.)
    fn cost(&self, count: usize) -> f64 {
        1.5 + 0.1 * count as f64
    }
}

fn largest_extent(v: &[Vec3; 3]) -> f32 {
    (v[0].max(v[1]).max(v[2]) - v[0].min(v[1]).min(v[2])).max_element()
}

/// A triangle of a leaf.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleLeaf<'a> {
    numbers: &'a [f32; LEAF_NUMBERS],
    count: usize,
}

impl<'a> TriangleLeaf<'a> {
    #[inline(always)]
    pub(crate) fn new(arena: &'a Arena, leaf: Child) -> Option<Self> {
        Some(Self { numbers: arena.leaf(leaf.place())?, count: leaf.count() })
    }

    #[inline(always)]
    pub(crate) fn numbers(&self) -> &'a [f32; LEAF_NUMBERS] {
        self.numbers
    }

    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// The vertices of a triangle.
    #[inline(always)]
    pub(crate) fn vertices(&self, lane: usize) -> [Vec3; 3] {
        // At most 1 + 8 · 8 + 7; the mask tells the compiler so.
        let number = |i: usize| self.numbers[(1 + i * self.count + lane) & 127];
        [
            Vec3::new(number(0), number(1), number(2)),
            Vec3::new(number(3), number(4), number(5)),
            Vec3::new(number(6), number(7), number(8)),
        ]
    }

    /// The coordinates of the vertices along three axes.
    #[inline(always)]
    pub(crate) fn permuted(&self, lane: usize, [x, y, z]: [usize; 3]) -> [[f32; 3]; 3] {
        let vertex = |i: usize| {
            // Hidden from the compiler: for AVX-512 it would make one gather with 64-bit multiplications of all nine loads,
            // which costs 6 % of a primary ray.
            let first = std::hint::black_box(1 + 3 * i * self.count + lane);
            let number = |axis: usize| self.numbers[(first + axis * self.count) & 127];
            [number(x), number(y), number(z)]
        };
        [vertex(0), vertex(1), vertex(2)]
    }

    /// The number of a triangle in its mesh.
    #[inline(always)]
    pub(crate) fn primitive(&self, lane: usize) -> u32 {
        self.numbers[(1 + 9 * self.count + lane) & 127].to_bits().wrapping_sub(BIAS)
    }
}
