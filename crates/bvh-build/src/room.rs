//! Memory to work in.

use std::ops::{Deref, DerefMut};

use bytemuck::Pod;

/// Room for many values, which are zero at first.
///
/// With the feature `mmap` in large pages: those of 4 KiB, each made by a fault of its own, take a seventh of the time
/// of a build of a million primitives.
pub(crate) struct Room<T> {
    memory: Memory<T>,
    count: usize,
}

enum Memory<T> {
    Heap(Vec<T>),
    #[cfg(feature = "mmap")]
    Pages(memmap2::MmapMut),
}

/// From so many bytes on large pages are worth asking for.
#[cfg(feature = "mmap")]
const LARGE: usize = 4 << 20;

impl<T: Pod> Room<T> {
    pub(crate) fn zeroed(count: usize) -> Self {
        #[cfg(feature = "mmap")]
        if let Some(bytes) = count.checked_mul(size_of::<T>()).filter(|&bytes| bytes >= LARGE)
            && let Ok(pages) = memmap2::MmapMut::map_anon(bytes)
        {
            // A wish: without large pages it is slower, and right.
            #[cfg(target_os = "linux")]
            let _ = pages.advise(memmap2::Advice::HugePage);
            return Self { memory: Memory::Pages(pages), count };
        }
        Self { memory: Memory::Heap(bytemuck::zeroed_vec(count)), count }
    }

    /// Forgets all but the first `count` values.
    pub(crate) fn truncate(&mut self, count: usize) {
        self.count = self.count.min(count);
    }
}

impl<T: Pod> Deref for Room<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        match &self.memory {
            Memory::Heap(values) => &values[..self.count],
            #[cfg(feature = "mmap")]
            Memory::Pages(pages) => &bytemuck::cast_slice(pages)[..self.count],
        }
    }
}

impl<T: Pod> DerefMut for Room<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        match &mut self.memory {
            Memory::Heap(values) => &mut values[..self.count],
            #[cfg(feature = "mmap")]
            Memory::Pages(pages) => &mut bytemuck::cast_slice_mut(pages)[..self.count],
        }
    }
}
