//! Triangles in the leaves of a wide tree.

use std::marker::PhantomData;
use std::ops::Range;
use std::sync::Arc;

use geometry::TriangleMesh;
use geometry::glam::Vec3;

#[cfg(feature = "cache")]
mod checked;

use super::arena::{Child, Line};
use super::collapse::{LeafWriter, WideTree};
use super::node::{CompactNode, FullNode, WideNode};
use crate::simd::{LANES, LEAF_NUMBERS, load_triangle, prefetch};

#[cfg(feature = "cache")]
pub(crate) use checked::CheckedLayout;

/// Numbers of primitives are stored with this added: small ones, read as f32 by a load that begins in the numbers
/// before them, would be denormal, which some processors are slow at.
const BIAS: u32 = 0x3f80_0000;

/// How the triangles of a wide tree are kept.
pub(crate) trait Layout: Copy + 'static {
    /// The form of the nodes.
    type Node: WideNode;

    /// Room for the numbers of a leaf where they are not in the arena.
    type Scratch: Scratch;

    /// How many words a leaf of `count` triangles has.
    fn word_count(count: usize) -> usize;

    /// Writes the words of a leaf.
    fn write(mesh: &TriangleMesh, ids: &[u32], words: &mut [u32]);

    /// The numbers of a leaf, as [`write_block`] has them; `None` where there is none.
    fn numbers<'a>(
        triangles: &'a Triangles,
        leaf: Child,
        scratch: &'a mut Self::Scratch,
    ) -> Option<&'a [f32; LEAF_NUMBERS]>;

    /// Which of the stored words of a leaf of `count` triangles has the number of one of them.
    fn place_of_id(count: usize, lane: usize) -> usize;

    /// The number of a triangle of a leaf of `count` triangles, as [`write`](Self::write) left it in its words.
    fn stored_id(words: &[u32], count: usize, lane: usize) -> u32 {
        words[Self::place_of_id(count, lane)].wrapping_sub(BIAS)
    }

    /// The number of a triangle in its mesh; `None` where there is none.
    #[inline(always)]
    fn primitive(triangles: &Triangles, leaf: Child, lane: usize) -> Option<u32> {
        let stored = triangles.tree.arena.leaf(leaf.place())?;
        Some(stored[Self::place_of_id(leaf.count(), lane) & 127].to_bits().wrapping_sub(BIAS))
    }
}

/// What a wide tree over a mesh consists of.
#[derive(Clone, Debug)]
pub(crate) struct Triangles {
    pub(crate) mesh: Arc<TriangleMesh>,
    pub(crate) tree: WideTree,
}

/// Room that need not be initialised with anything in particular.
pub(crate) trait Scratch {
    fn new() -> Self;
}

impl Scratch for () {
    #[inline(always)]
    fn new() -> Self {}
}

impl Scratch for [f32; LEAF_NUMBERS] {
    #[inline(always)]
    fn new() -> Self {
        [0.0; LEAF_NUMBERS]
    }
}

/// Leaves have their own copies of the vertices, in blocks. About 58 bytes a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blocks;

/// Leaves name their triangles, and the vertices are read from the mesh; boxes are quantised. About 20 bytes a
/// triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Compact;

impl Layout for Blocks {
    type Node = FullNode;
    type Scratch = ();

    #[inline(always)]
    fn word_count(count: usize) -> usize {
        1 + 10 * count
    }

    fn write(mesh: &TriangleMesh, ids: &[u32], words: &mut [u32]) {
        write_block(mesh, ids, words);
    }

    #[inline(always)]
    fn numbers<'a>(triangles: &'a Triangles, leaf: Child, (): &'a mut ()) -> Option<&'a [f32; LEAF_NUMBERS]> {
        triangles.tree.arena.leaf(leaf.place())
    }

    #[inline(always)]
    fn place_of_id(count: usize, lane: usize) -> usize {
        1 + 9 * count + lane
    }
}

impl Layout for Compact {
    type Node = CompactNode;
    type Scratch = [f32; LEAF_NUMBERS];

    #[inline(always)]
    fn word_count(count: usize) -> usize {
        1 + count
    }

    /// The largest extent, and the numbers.
    fn write(mesh: &TriangleMesh, ids: &[u32], words: &mut [u32]) {
        let extents = ids.iter().map(|&id| extent(&mesh.vertices(id as usize)));
        words[0] = largest(extents).to_bits();
        for (word, id) in words[1..].iter_mut().zip(ids) {
            *word = id.wrapping_add(BIAS);
        }
    }

    #[inline(always)]
    fn numbers<'a>(
        triangles: &'a Triangles,
        leaf: Child,
        scratch: &'a mut [f32; LEAF_NUMBERS],
    ) -> Option<&'a [f32; LEAF_NUMBERS]> {
        let (stored, count) = (triangles.tree.arena.leaf(leaf.place())?, leaf.count());
        gather(&triangles.mesh, stored, count, scratch)?;
        Some(scratch)
    }

    #[inline(always)]
    fn place_of_id(_: usize, lane: usize) -> usize {
        1 + lane
    }
}

/// Makes the block of a compact leaf.
#[inline(never)]
fn gather(
    mesh: &TriangleMesh,
    stored: &[f32; LEAF_NUMBERS],
    count: usize,
    block: &mut [f32; LEAF_NUMBERS],
) -> Option<()> {
    block[0] = stored[0];
    for (lane, id) in stored[1..].iter().take(count).enumerate() {
        let triangle = mesh.triangles().get(id.to_bits().wrapping_sub(BIAS) as usize)?;
        for (vertex, &index) in triangle.iter().enumerate() {
            let position = mesh.positions().get(index as usize)?.to_array();
            for (axis, x) in position.into_iter().enumerate() {
                *block.get_mut(1 + (3 * vertex + axis) * count + lane)? = x;
            }
        }
        *block.get_mut(1 + 9 * count + lane)? = *id;
    }
    Some(())
}

/// The block of some triangles. Of n: their largest extent along any axis; nine times n coordinates, of the first
/// vertices x, y and z, of the second, of the third; and n numbers.
///
/// They are not padded to eight: a load of eight lanes goes on into what follows, and the lanes from n on are masked.
fn write_block(mesh: &TriangleMesh, ids: &[u32], words: &mut [u32]) {
    let (first, numbers) = words.split_at_mut(1);
    let (coordinates, numbers) = numbers.split_at_mut(9 * ids.len());
    let mut extents = [0.0; LANES];
    for (lane, (&id, number)) in ids.iter().zip(numbers).enumerate() {
        let vertices = mesh.vertices(id as usize);
        extents[lane % LANES] = extent(&vertices);
        *number = id.wrapping_add(BIAS);
        for (vertex, v) in vertices.iter().enumerate() {
            for axis in 0..3 {
                coordinates[(3 * vertex + axis) * ids.len() + lane] = v[axis].to_bits();
            }
        }
    }
    first[0] = largest(extents.into_iter()).to_bits();
}

/// The largest extent of a triangle along an axis.
fn extent(v: &[Vec3; 3]) -> f32 {
    (v[0].max(v[1]).max(v[2]) - v[0].min(v[1]).min(v[2])).max_element()
}

/// The largest of some extents, rounded up: a difference of two f32 is wrong by half an ulp.
fn largest(extents: impl Iterator<Item = f32>) -> f32 {
    extents.fold(0.0, f32::max).next_up()
}

/// A step to a leaf takes half as much time again as one to a node, whatever it holds; the rest makes the tree that
/// tests less win among equal ones. (From 0.5 to 2.5 for the leaf and 0 to 0.3 for a triangle, nothing was faster by
/// more than the noise on bunny, sponza and kitchen; but 0.3 takes a fifth more memory.)
pub(crate) const LEAF_COST: f64 = 1.5;

/// What a triangle adds to it.
pub(crate) const TRIANGLE_COST: f64 = 0.1;

/// What a step to a leaf of `count` triangles costs, where one to a node costs 1.
pub(crate) fn leaf_cost(count: usize) -> f64 {
    LEAF_COST + TRIANGLE_COST * count as f64
}

/// Asks for the vertices of a triangle, if there is one of this number.
#[inline(always)]
pub(crate) fn prefetch_vertices(mesh: &TriangleMesh, id: usize) {
    if let Some(triangle) = mesh.triangles().get(id) {
        triangle.iter().filter_map(|&i| mesh.positions().get(i as usize)).for_each(prefetch);
    }
}

/// Writes leaves of a layout.
pub(crate) struct TriangleWriter<'a, Y> {
    mesh: &'a TriangleMesh,
    order: &'a [u32],
    /// Whether a triangle may be in the order more than once.
    is_split: bool,
    layout: PhantomData<fn() -> Y>,
}

impl<'a, Y: Layout> TriangleWriter<'a, Y> {
    pub(crate) fn new(mesh: &'a TriangleMesh, order: &'a [u32], is_split: bool) -> Self {
        Self { mesh, order, is_split, layout: PhantomData }
    }

    /// Asks for triangles that stand behind a leaf's in the order, and for vertices of nearer ones: leaves are written
    /// nearly in that order, and would spend two thirds of the time waiting.
    fn prefetch(&self, leaf: &Range<usize>) {
        const TRIANGLES: usize = 48;
        const VERTICES: usize = 16;
        let ahead = |distance: usize| self.order.get(leaf.start + distance..leaf.end + distance).into_iter().flatten();
        for triangle in ahead(TRIANGLES).filter_map(|&id| self.mesh.triangles().get(id as usize)) {
            prefetch(triangle);
        }
        for &id in ahead(VERTICES) {
            prefetch_vertices(self.mesh, id as usize);
        }
    }

    /// The numbers of the triangles at a range of the order, at most eight, each once, and how many they are.
    fn ids(&self, range: Range<usize>) -> ([u32; LANES], usize) {
        let (mut ids, mut count) = ([0; LANES], 0);
        for &id in &self.order[range] {
            if !(self.is_split && ids[..count].contains(&id)) {
                ids[count] = id;
                count += 1;
            }
        }
        (ids, count)
    }
}

impl<Y: Layout> LeafWriter for TriangleWriter<'_, Y> {
    fn line_count(&self, range: Range<usize>) -> usize {
        let count = if self.is_split { self.ids(range).1 } else { range.len() };
        Y::word_count(count).div_ceil(16)
    }

    fn write(&self, range: Range<usize>, at: usize, lines: &mut [Line]) -> (usize, usize) {
        self.prefetch(&range);
        let (ids, count) = self.ids(range);
        let words: &mut [u32] = bytemuck::cast_slice_mut(lines);
        Y::write(self.mesh, &ids[..count], &mut words[..Y::word_count(count)]);
        (at, count)
    }

    fn cost(&self, count: usize) -> f64 {
        leaf_cost(count)
    }
}

/// The triangles of a leaf.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleLeaf<'a> {
    numbers: &'a [f32; LEAF_NUMBERS],
    count: usize,
}

impl<'a> TriangleLeaf<'a> {
    #[inline(always)]
    pub(crate) fn new<Y: Layout>(triangles: &'a Triangles, leaf: Child, scratch: &'a mut Y::Scratch) -> Option<Self> {
        Some(Self { numbers: Y::numbers(triangles, leaf, scratch)?, count: leaf.count() })
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
    pub(crate) fn permuted(&self, lane: usize, axes: [usize; 3]) -> [[f32; 3]; 3] {
        load_triangle(self.numbers, lane, self.count, axes)
    }

    /// The number of a triangle in its mesh.
    #[inline(always)]
    pub(crate) fn primitive(&self, lane: usize) -> u32 {
        self.numbers[(1 + 9 * self.count + lane) & 127].to_bits().wrapping_sub(BIAS)
    }
}
