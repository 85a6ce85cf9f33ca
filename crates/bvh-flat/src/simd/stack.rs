//! The stack of a traversal that pushes eight entries at once.

use std::mem::MaybeUninit;

use super::Lanes;
use crate::wide::Child;

/// Subtrees to come, each with the ray's entry, in memory that is not cleared for every ray.
///
/// What was written is below `len`; what is above is never read.
#[repr(align(64))]
pub(crate) struct Stack<const CAPACITY: usize> {
    children: [MaybeUninit<u32>; CAPACITY],
    entries: [MaybeUninit<f32>; CAPACITY],
    len: usize,
}

impl<const CAPACITY: usize> Stack<CAPACITY> {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self {
            children: [const { MaybeUninit::uninit() }; CAPACITY],
            entries: [const { MaybeUninit::uninit() }; CAPACITY],
            len: 0,
        }
    }

    /// Forgets everything.
    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.len = 0;
    }

    /// Pushes the lanes of the mask, the highest last. `None` where there is no room: `CAPACITY` must be eight more
    /// than what is ever held.
    #[inline(always)]
    pub(crate) fn push<L: Lanes>(&mut self, children: L::U32, entries: L::F32, mask: u32) -> Option<()> {
        let children_to = self.children.get_mut(self.len..)?.first_chunk_mut()?;
        let entries_to = self.entries.get_mut(self.len..)?.first_chunk_mut()?;
        L::compress_u32(children, mask, children_to);
        L::compress(entries, mask, entries_to);
        self.len += (mask & 0xff).count_ones() as usize;
        Some(())
    }

    /// The entry pushed last.
    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<Child> {
        self.len = self.len.checked_sub(1)?;
        // SAFETY: places below a former `len` were written by `push`: `len` grows by the number of lanes written.
        Some(Child(unsafe { self.children[self.len].assume_init() }))
    }

    /// The entry pushed last among those that the ray enters at `t_max` at the latest.
    ///
    /// Rejected: to leave out the others as soon as `t_max` changes, eight at a time (primary rays of sponza and
    /// kitchen 3 and 5 % slower), or once the last one is to be left out (within 1 %).
    #[inline(always)]
    pub(crate) fn pop_before(&mut self, t_max: f32) -> Option<Child> {
        while let Some(child) = self.pop() {
            // SAFETY: see `pop`.
            if unsafe { self.entries[self.len].assume_init() } <= t_max {
                return Some(child);
            }
        }
        None
    }
}
