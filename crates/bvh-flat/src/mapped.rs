//! Files in memory, and lines that lie in them: beside `simd` the only place with `unsafe` code.
//!
//! # What a mapping relies on
//! Nobody may change or shorten the file while it is mapped. This library never does: it writes a new file and renames
//! it, and the old one stays as it is for whoever has it open. Where another program does, a read beyond the new end
//! ends the process (`SIGBUS`), and changed bytes are undefined behaviour as far as the language goes; in practice rays
//! get wrong answers. Whoever cannot rule that out reads the file instead.

#![allow(unsafe_code)]

use std::fmt;
use std::fs::File;
use std::io;
use std::ops::{Deref, Range};
use std::sync::Arc;

use memmap2::{Mmap, MmapMut, MmapOptions};

use crate::wide::Line;

/// A whole file.
pub(crate) struct Map(Arc<Mmap>);

impl Map {
    pub(crate) fn new(file: &File) -> io::Result<Self> {
        // SAFETY: the bytes must not change while they are mapped. That is the condition under which the feature `mmap`
        // and the functions that map are offered, and no function of this library writes to an existing file.
        unsafe { MmapOptions::new().populate().map(file) }.map(|map| Self(Arc::new(map)))
    }

    /// How many bytes there are.
    pub(crate) fn len(&self) -> u64 {
        self.0.len() as u64
    }

    /// The lines at a range of bytes; `None` where those are not there or no whole, aligned lines.
    pub(crate) fn lines(&self, range: Range<usize>) -> Option<Lines> {
        let lines: &[Line] = bytemuck::try_cast_slice(self.0.get(range)?).ok()?;
        // SAFETY: as in `Lines::from`; the mapping is neither moved nor unmapped while an `Arc` of it is there.
        let lines = unsafe { &*std::ptr::from_ref(lines) };
        Some(Lines { lines, owner: Owner::Map(Arc::clone(&self.0)) })
    }
}

/// New memory, of zeros, in pages of 2 MiB where the system has them: with those of 4 KiB a tree of 89 MB takes 50 ms
/// of the processor's time to be read, with these 20, since every page is made by a fault of its own.
pub(crate) struct LargePages(MmapMut);

/// From so many bytes on large pages are worth asking for.
const LARGE: usize = 4 << 20;

impl LargePages {
    /// Memory for so many lines; `None` where there are few, or the system has no memory for them.
    pub(crate) fn for_lines(count: usize) -> Option<Self> {
        let len = count.checked_mul(size_of::<Line>()).filter(|&len| len >= LARGE)?;
        let pages = MmapMut::map_anon(len).ok()?;
        // A wish: without large pages it is slower, and right.
        #[cfg(target_os = "linux")]
        let _ = pages.advise(memmap2::Advice::HugePage);
        Some(Self(pages))
    }

    /// The lines: their number is whole, and pages are aligned for more.
    pub(crate) fn lines_mut(&mut self) -> &mut [Line] {
        bytemuck::cast_slice_mut(&mut self.0)
    }

    /// The same memory as lines that do not change.
    pub(crate) fn into_lines(self) -> Lines {
        // SAFETY: as in `Lines::from`; the mapping is private, stays where it is, and `Lines` writes to it no more than
        // to a vector.
        let lines = unsafe { &*std::ptr::from_ref::<[Line]>(bytemuck::cast_slice(&self.0)) };
        Lines { lines, owner: Owner::Pages(Arc::new(self.0)) }
    }
}

/// Lines, and what they lie in. Reading them is reading a slice, wherever they are: an enum would be asked at each step
/// of each ray.
pub(crate) struct Lines {
    /// Not for longer than `owner`: no function gives it out for `'static`.
    lines: &'static [Line],
    owner: Owner,
}

/// Is never looked at but to be cloned, and keeps the memory until it is dropped.
enum Owner {
    Vec(Vec<Line>),
    Map(Arc<Mmap>),
    Pages(Arc<MmapMut>),
}

impl Lines {
    /// The result of `write`, which may change all lines: in place where nobody else has them, else in a copy.
    pub(crate) fn rewrite<T>(&mut self, write: impl FnOnce(&mut [Line]) -> T) -> T {
        let old = std::mem::replace(self, Vec::new().into());
        let mut own = match old.owner {
            Owner::Vec(lines) => lines,
            Owner::Map(_) => old.lines.to_vec(),
            Owner::Pages(pages) => match Arc::try_unwrap(pages) {
                Ok(pages) => {
                    let mut pages = LargePages(pages);
                    let result = write(pages.lines_mut());
                    *self = pages.into_lines();
                    return result;
                }
                Err(_shared) => old.lines.to_vec(),
            },
        };
        let result = write(&mut own);
        *self = own.into();
        result
    }
}

impl From<Vec<Line>> for Lines {
    fn from(owner: Vec<Line>) -> Self {
        // SAFETY: the memory of a vector stays where it is when the vector itself is moved, and this one is never
        // changed, nor dropped before the reference: both are fields of the same value, and `deref` gives the slice out
        // for no longer than that is borrowed.
        let lines = unsafe { &*std::ptr::from_ref(owner.as_slice()) };
        Self { lines, owner: Owner::Vec(owner) }
    }
}

impl Deref for Lines {
    type Target = [Line];

    #[inline(always)]
    fn deref(&self) -> &[Line] {
        self.lines
    }
}

impl Clone for Lines {
    fn clone(&self) -> Self {
        match &self.owner {
            Owner::Vec(owner) => owner.clone().into(),
            Owner::Map(map) => Self { lines: self.lines, owner: Owner::Map(Arc::clone(map)) },
            Owner::Pages(pages) => Self { lines: self.lines, owner: Owner::Pages(Arc::clone(pages)) },
        }
    }
}

impl PartialEq for Lines {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl fmt::Debug for Lines {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}
