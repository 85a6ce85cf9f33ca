//! The memory of a wide tree: cache lines that hold nodes, and leaves after the node that has them.

use bytemuck::{Pod, Zeroable};

use crate::simd::{LANES, LEAF_NUMBERS, prefetch_from};

/// A cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub(crate) struct Line(pub(crate) [u32; 16]);

/// How many lines can be read from the first line of a leaf on, whatever its size: as many follow the last leaf.
pub(crate) const LEAF_LINES: usize = LEAF_NUMBERS / 16;

/// The most lines that references of 28 bits can name: 16 GiB.
pub(crate) const MAX_LINES: usize = 1 << 28;

/// What a node refers to: another node by its first line, or a leaf by a place and a number of primitives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Child(pub(crate) u32);

impl Child {
    const LEAF: u32 = 1 << 31;

    /// The node that begins at `line`.
    pub(crate) fn node(line: usize) -> Self {
        debug_assert!(line < MAX_LINES);
        Self(line as u32)
    }

    /// `count` primitives, 1 to 8, at a place below [`MAX_LINES`].
    pub(crate) fn leaf(place: usize, count: usize) -> Self {
        debug_assert!(place < MAX_LINES && (1..=LANES).contains(&count));
        Self(Self::LEAF | (count as u32 - 1) << 28 | place as u32)
    }

    #[inline(always)]
    pub(crate) fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    /// The first line of a node.
    #[inline(always)]
    pub(crate) fn line(self) -> usize {
        self.0 as usize
    }

    /// The place of a leaf.
    #[inline(always)]
    pub(crate) fn place(self) -> usize {
        (self.0 & (MAX_LINES as u32 - 1)) as usize
    }

    /// The number of primitives of a leaf.
    #[inline(always)]
    pub(crate) fn count(self) -> usize {
        (self.0 >> 28 & 7) as usize + 1
    }
}

/// Lines in memory.
#[cfg(not(feature = "mmap"))]
pub(crate) type Lines = Vec<Line>;
#[cfg(feature = "mmap")]
pub(crate) use crate::mapped::Lines;

/// The lines of a tree.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Arena {
    lines: Lines,
}

impl Arena {
    /// So many lines, of zeros, as `write` leaves them, and what it says.
    ///
    /// With the feature `mmap` in large pages: those of 4 KiB, each made by a fault of its own, take a fifth of the
    /// time of the fastest build.
    #[cfg_attr(not(feature = "mmap"), expect(clippy::useless_conversion, reason = "with `mmap` a type of its own"))]
    pub(crate) fn written<T>(count: usize, write: impl FnOnce(&mut [Line]) -> T) -> (Self, T) {
        #[cfg(feature = "mmap")]
        if let Some(mut pages) = crate::mapped::LargePages::for_lines(count) {
            let said = write(pages.lines_mut());
            return (Self { lines: pages.into_lines() }, said);
        }
        let mut lines = bytemuck::allocation::zeroed_vec(count);
        let said = write(&mut lines);
        (Self { lines: lines.into() }, said)
    }

    /// The result of `write`, which may change all lines. Where they are in memory of this arena alone it changes them
    /// in place; lines of a file that is mapped, or of another arena's, are copied first.
    pub(crate) fn rewrite<T>(&mut self, write: impl FnOnce(&mut [Line]) -> T) -> T {
        #[cfg(not(feature = "mmap"))]
        return write(&mut self.lines);
        #[cfg(feature = "mmap")]
        self.lines.rewrite(write)
    }

    /// Lines in which children name nodes and leaves, and [`LEAF_LINES`] of zeros behind them.
    ///
    /// Rejected: large pages. With all 84 MB of kitchen's tree in pages of 2 MiB no kind of ray was faster by more than
    /// the noise of 2 %, nor on dragon and black-forest.
    #[cfg(feature = "cache")]
    pub(crate) fn from_all(lines: Lines) -> Self {
        Self { lines }
    }

    /// All lines, with those of zeros behind the last leaf.
    #[cfg(feature = "cache")]
    pub(crate) fn all(&self) -> &[Line] {
        &self.lines
    }

    /// The lines from `first` on; `None` where there are none, which a tree's own references never name.
    ///
    /// (An option, and not some lines in place of them: a branch that is never taken costs nothing, where a conditional
    /// move would wait for the reference and make the next load wait for it.)
    #[inline(always)]
    pub(crate) fn lines(&self, first: usize) -> Option<&[Line]> {
        self.lines.get(first..)
    }

    /// The numbers of a leaf from line `first` on, and what follows them; `None` as for [`lines`](Self::lines).
    #[inline(always)]
    pub(crate) fn leaf(&self, first: usize) -> Option<&[f32; LEAF_NUMBERS]> {
        let lines: &[Line; LEAF_LINES] = self.some_lines(first, LEAF_LINES)?.first_chunk()?;
        Some(bytemuck::must_cast_ref(lines))
    }

    /// So many lines from `first` on. (One comparison, since `first` comes from 32 bits and the sum cannot overflow;
    /// `get(first..)` and `first_chunk` compare twice.)
    #[inline(always)]
    pub(crate) fn some_lines(&self, first: usize, count: usize) -> Option<&[Line]> {
        self.lines.get(first..first.wrapping_add(count))
    }

    /// Asks for the lines of a node, or the most of a leaf, from line `first` on.
    #[inline(always)]
    pub(crate) fn prefetch(&self, first: usize) {
        prefetch_from::<4, _>(&self.lines, first);
    }

    /// Its memory in bytes.
    pub(crate) fn memory(&self) -> usize {
        size_of_val::<[Line]>(&self.lines)
    }
}
