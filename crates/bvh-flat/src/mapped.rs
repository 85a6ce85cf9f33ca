//! Files in memory, and lines that lie in them: beside `simd` the only place with `unsafe` code.
//!
//! # What a mapping relies on
//! Nobody may change or shorten the file while it is mapped. This library never does: it writes a new file and renames it,
//! and the old one stays as it is for whoever has it open. Where another program does, a read beyond the new end ends the
//! process (`SIGBUS`), and changed bytes are undefined behaviour as far as the language goes; in practice rays get wrong
//! answers. Whoever cannot rule that out reads the file instead.

#![allow(unsafe_code)]

use std::fmt;
use std::fs::File;
use std::io;
use std::ops::{Deref, Range};
use std::sync::Arc;

use memmap2::{Mmap, MmapMut};

use crate::wide::Line;

/// A whole file.
pub(crate) struct Map(Arc<Mmap>);

impl Map {
    pub(crate) fn new(file: &File) -> io::Result<Self> {
        // SAFETY: the bytes must not change while they are mapped. That is the condition under which the feature `mmap` and
        // the functions that map are offered, and no function of this library writes to an existing file.
        unsafe { Mmap::map(file) }.map(|map| Self(Arc::new(map)))
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

/// New memory, of zeros, in pages of 2 MiB where the system has them: with those of 4 KiB a tree of 89 MB takes 50 ms of the
/// processor's time to be read, with these 20, since every page is made by a fault of its own.
pub(crate) struct LargePages(MmapMut);

impl LargePages {
    pub(crate) fn new(len: usize) -> io::Result<Self> {
        let pages = MmapMut::map_anon(len)?;
        // A wish: without large pages it is slower, and right.
        #[cfg(target_os = "linux")]
        let _ = pages.advise(memmap2::Advice::HugePage);
        Ok(Self(pages))
    }

    pub(crate) fn bytes_mut(&mut self) -> &mut [u8] {
        &mut self.0
    }

    /// The same memory as lines; `None` where it is no whole number of them.
    pub(crate) fn into_lines(self) -> Option<Lines> {
        let owner = self.0.make_read_only().ok()?;
        let len = owner.len();
        Map(Arc::new(owner)).lines(0..len)
    }
}

/// Lines, and what they lie in. Reading them is reading a slice, wherever they are: an enum would be asked at each step of
/// each ray.
pub(crate) struct Lines {
    /// Not for longer than `owner`: no function gives it out for `'static`.
    lines: &'static [Line],
    owner: Owner,
}

/// Is never looked at but to be cloned, and keeps the memory until it is dropped.
enum Owner {
    Vec(Vec<Line>),
    Map(Arc<Mmap>),
}

impl From<Vec<Line>> for Lines {
    fn from(owner: Vec<Line>) -> Self {
        // SAFETY: the memory of a vector stays where it is when the vector itself is moved, and this one is never changed, nor
        // dropped before the reference: both are fields of the same value, and `deref` gives the slice out for no longer than
        // that is borrowed.
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
