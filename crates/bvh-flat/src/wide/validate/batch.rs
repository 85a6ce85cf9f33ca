//! Leaves that were met, and whose triangles are looked at together.

use geometry::{MAX_COORDINATE, TriangleMesh};

use super::InvalidWideTree;
use crate::simd::{LANES, LEAF_NUMBERS, Lanes, prefetch};
use crate::wide::arena::{Arena, Line};
use crate::wide::triangles::{CheckedLayout, prefetch_vertices};

/// Up to so many triangles are together.
const SIZE: usize = 128;

/// What sees each primitive once.
pub(super) trait See {
    /// Asks the memory for what is known of it.
    fn prefetch(&self, primitive: u32);

    /// Whether there is such a one, and it was not seen before.
    fn see(&self, primitive: u32) -> bool;
}

/// A leaf of a batch.
#[derive(Clone, Copy, Default)]
pub(super) struct Leaf {
    /// Its first line.
    pub(super) place: usize,
    /// How many triangles there are.
    pub(super) count: usize,
    /// The planes between which they must be: min x, max x, min y, ….
    pub(super) within: [f32; 6],
}

/// Leaves, and the vertices of their triangles as the mesh has them.
///
/// Those come from anywhere in memory: all are asked for, then all are read. And triangles are gone through without
/// regard to leaves, whose sizes no processor can foresee.
pub(super) struct Batch {
    leaves: [Leaf; SIZE],
    leaf_count: usize,
    /// Of the triangles of all leaves. Behind them is what eight lanes have too much.
    ids: [u32; SIZE + LANES],
    count: usize,
    /// Row 3 v + a has coordinate a of vertex v of each triangle.
    rows: [[f32; SIZE + LANES]; 9],
}

impl Batch {
    pub(super) fn new() -> Self {
        let (leaves, rows) = ([Leaf::default(); SIZE], [[0.0; SIZE + LANES]; 9]);
        Self { leaves, leaf_count: 0, ids: [0; SIZE + LANES], count: 0, rows }
    }

    /// Whether there may be no room for another leaf.
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.count > SIZE - LANES
    }

    /// Adds a leaf, of which the first lanes are the triangles.
    #[inline(always)]
    pub(super) fn add(&mut self, leaf: Leaf, ids: &[u32; LANES]) {
        self.leaves[self.leaf_count % SIZE] = leaf;
        self.leaf_count += 1;
        if let Some(to) = self.ids.get_mut(self.count..self.count + LANES) {
            to.copy_from_slice(ids);
        }
        self.count += leaf.count;
    }

    /// Whether each leaf is zero behind its triangles, and these are primitives that are not in another, in their
    /// boxes, as large as it says, and those of the mesh. Then there are no leaves any more.
    #[inline(always)]
    pub(super) fn check<L: Lanes, Y: CheckedLayout>(
        &mut self,
        arena: &Arena,
        mesh: Option<&TriangleMesh>,
        see: &impl See,
        is_split: bool,
    ) -> Result<(), InvalidWideTree> {
        let checked = self.check_all::<L, Y>(arena, mesh, see, is_split);
        (self.leaf_count, self.count) = (0, 0);
        checked
    }

    #[inline(always)]
    fn check_all<L: Lanes, Y: CheckedLayout>(
        &mut self,
        arena: &Arena,
        mesh: Option<&TriangleMesh>,
        see: &impl See,
        is_split: bool,
    ) -> Result<(), InvalidWideTree> {
        let seen = self.see(mesh, see);
        let are_known = mesh.is_some_and(|mesh| self.read(mesh, seen).is_some());
        let mut first = 0;
        for leaf in &self.leaves[..self.leaf_count.min(SIZE)] {
            let &Leaf { place, count, .. } = leaf;
            if let Some(&primitive) = self.ids.get(seen).filter(|_| first + count > seen) {
                return Err(InvalidWideTree::Primitive { leaf: place, primitive });
            }
            let words = Y::word_count(count);
            let (Some(stored), Some([last, ..])) = (arena.leaf(place), arena.lines(place + (words - 1) / 16)) else {
                return Err(InvalidWideTree::Leaf { leaf: place });
            };
            if !is_zero_behind::<L>(last, (words - 1) % 16 + 1) {
                return Err(InvalidWideTree::Leaf { leaf: place });
            }
            let vertices = |axis: usize| {
                if Y::HAS_VERTICES {
                    L::load_vertices(stored, count, axis)
                } else {
                    [0, 1, 2].map(|vertex| L::load(lanes(&self.rows[3 * vertex + axis], first)))
                }
            };
            let are_there = Y::HAS_VERTICES || are_known;
            if are_there && !is_within::<L>(stored[0], vertices, count, &leaf.within, is_split) {
                return Err(InvalidWideTree::Leaf { leaf: place });
            }
            if mesh.is_some() && !(are_known && (!Y::HAS_VERTICES || self.are_stored::<L>(stored, count, first))) {
                return Err(InvalidWideTree::Vertices { leaf: place });
            }
            first += count;
        }
        Ok(())
    }

    /// How many of the triangles are there, and were not seen before; and asks for their vertices.
    ///
    /// Without asking for vertices bunny, which fits the caches, is a twentieth faster, dragon as much slower, and
    /// kitchen as it is; without asking for anything all are slower, kitchen by a quarter.
    #[inline(always)]
    fn see(&self, mesh: Option<&TriangleMesh>, see: &impl See) -> usize {
        let ids = &self.ids[..self.count.min(SIZE)];
        for &id in ids {
            see.prefetch(id);
            if let Some(triangle) = mesh.and_then(|mesh| mesh.triangles().get(id as usize)) {
                prefetch(triangle);
            }
        }
        let is_seen = |&id: &u32| {
            if let Some(mesh) = mesh {
                prefetch_vertices(mesh, id as usize);
            }
            see.see(id)
        };
        ids.iter().position(|id| !is_seen(id)).unwrap_or(ids.len())
    }

    /// Reads the vertices of the first triangles; `None` where there is no such triangle.
    #[inline(always)]
    fn read(&mut self, mesh: &TriangleMesh, count: usize) -> Option<()> {
        for (i, &id) in self.ids[..count.min(SIZE)].iter().enumerate() {
            let triangle = mesh.triangles().get(id as usize)?;
            for (vertex, &index) in triangle.iter().enumerate() {
                let position = mesh.positions().get(index as usize)?.to_array();
                for (axis, x) in position.into_iter().enumerate() {
                    self.rows[3 * vertex + axis][i] = x;
                }
            }
        }
        Some(())
    }

    /// Whether a leaf's own copies of its vertices are those that were read, bit by bit.
    #[inline(always)]
    fn are_stored<L: Lanes>(&self, stored: &[f32; LEAF_NUMBERS], count: usize, first: usize) -> bool {
        let mut differences = [0; LANES];
        for (i, row) in self.rows.iter().enumerate() {
            let (read, stored) = (lanes(row, first), lanes(stored, 1 + i * (count % (LANES + 1))));
            for (lane, difference) in differences.iter_mut().enumerate() {
                *difference |= read[lane].to_bits() ^ stored[lane].to_bits();
            }
        }
        let all = (1 << count) - 1;
        L::eq_u32(L::load_u32(&differences), L::splat_u32(0)) & all == all
    }
}

/// Eight numbers from `first` on.
#[inline(always)]
fn lanes<const N: usize>(numbers: &[f32; N], first: usize) -> &[f32; LANES] {
    // Never out of range: the first of 128 triangles, or a row of a leaf.
    let first = first.min(N - LANES);
    numbers[first..].first_chunk().unwrap_or(&[0.0; LANES])
}

/// Whether the vertices of a leaf's triangles are between planes, or with spatial splits on both sides at most, and
/// none so far out that rays do not meet its triangle; and its first number is one ulp more than the largest extent of
/// any of them.
#[inline(always)]
fn is_within<L: Lanes>(
    extent_above: f32,
    vertices: impl Fn(usize) -> [L::F32; 3],
    count: usize,
    within: &[f32; 6],
    is_split: bool,
) -> bool {
    let all = (1 << count) - 1;
    let [least, most] = [L::splat(-MAX_COORDINATE), L::splat(MAX_COORDINATE)];
    let mut valid = all;
    let (mut extent, mut sum) = (L::splat(0.0), L::splat(0.0));
    for axis in 0..3 {
        let [low, high] = [0, 1].map(|side| L::splat(within[2 * axis + side]));
        let [a, b, c] = vertices(axis);
        let (min, max) = (L::min(L::min(a, b), c), L::max(L::max(a, b), c));
        sum = L::add(sum, L::add(L::add(a, b), c));
        valid &= if is_split {
            L::le(low, max) & L::le(min, high) & L::le(least, min) & L::le(max, most)
        } else {
            L::le(low, min) & L::le(max, high)
        };
        extent = L::max(extent, L::sub(max, min));
    }
    // Min and max do not keep NaN, a sum does; and infinities of both signs, which make one, are in no box either.
    valid &= L::le(sum, sum);
    let largest = L::splat(extent_above.next_down());
    valid & L::le(extent, largest) & all == all && L::le(largest, extent) & all != 0
}

/// Whether a line is zero behind its first words.
#[inline(always)]
fn is_zero_behind<L: Lanes>(line: &Line, words: usize) -> bool {
    let [low, high]: &[[u32; LANES]; 2] = bytemuck::must_cast_ref(line);
    let zeros = L::eq_u32(L::load_u32(low), L::splat_u32(0)) | L::eq_u32(L::load_u32(high), L::splat_u32(0)) << LANES;
    (zeros | ((1 << words) - 1)) & 0xffff == 0xffff
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SimdWidth;
    use crate::simd::Kernel;

    /// A triangle across the box from −1 to 1, with a vertex at `far` on the first axis.
    struct Across {
        far: f32,
        is_split: bool,
    }

    impl Kernel for Across {
        type Output = bool;

        #[inline(always)]
        fn run<L: Lanes>(self) -> bool {
            let vertices = |axis: usize| [-0.5, if axis == 0 { self.far } else { 0.5 }, 0.25].map(L::splat);
            is_within::<L>((self.far + 0.5).next_up(), vertices, 1, &[-1.0, 1.0, -1.0, 1.0, -1.0, 1.0], self.is_split)
        }
    }

    #[test]
    fn parts_of_triangles_are_taken_but_of_those_that_no_ray_meets() {
        let is_taken = |far, is_split| SimdWidth::PORTABLE.run(Across { far, is_split });
        assert!(is_taken(0.75, false) && is_taken(0.75, true));
        assert!(!is_taken(3.0, false) && is_taken(3.0, true));
        assert!(is_taken(MAX_COORDINATE, true) && !is_taken(MAX_COORDINATE.next_up(), true) && !is_taken(1e30, true));
    }
}
