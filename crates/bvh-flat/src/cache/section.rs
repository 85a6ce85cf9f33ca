//! Sections, read and checked.

use std::io;

use bytemuck::Pod;

use super::checksum::read_and_sum;
use super::header::{ALIGNMENT, SectionRecord};
use super::source::Source;
use super::{CacheError, Section};

/// The entries of a section whose place in the file has been checked, read once into memory of their alignment; and a
/// look at its sum and at the zeros behind.
pub(crate) fn read_section<T: Pod>(
    source: &impl Source,
    section: Section,
    record: &SectionRecord,
) -> Result<Vec<T>, CacheError> {
    // No more than the file has, whose length has been checked.
    let count = record.entries::<T>()?;
    let mut entries: Vec<T> = bytemuck::try_zeroed_vec(count).map_err(|()| out_of_memory())?;
    read_into(source, section, record, bytemuck::cast_slice_mut(&mut entries))?;
    Ok(entries)
}

/// Fills `to`, which is as long as the section, and checks the same.
pub(crate) fn read_into(
    source: &impl Source,
    section: Section,
    record: &SectionRecord,
    to: &mut [u8],
) -> Result<(), CacheError> {
    record.check_sum(section, read_and_sum(source, record.offset, to)?)?;
    let end = record.offset + record.length;
    let mut behind = [0; ALIGNMENT as usize];
    let behind = &mut behind[..(end.next_multiple_of(ALIGNMENT) - end) as usize];
    source.read_exact_at(end, behind)?;
    match behind.iter().position(|&byte| byte != 0) {
        Some(place) => Err(CacheError::NotZero { offset: end + place as u64 }),
        None => Ok(()),
    }
}

impl SectionRecord {
    /// How many entries there are.
    pub(crate) fn entries<T>(&self) -> Result<usize, CacheError> {
        let size = size_of::<T>() as u64;
        if !self.length.is_multiple_of(size) {
            return Err(CacheError::Header("a section has no whole number of entries"));
        }
        usize::try_from(self.length / size).map_err(|_| out_of_memory())
    }

    /// An error where `found` is not the sum of what was written.
    pub(crate) fn check_sum(&self, section: Section, found: u128) -> Result<(), CacheError> {
        if self.sum == found { Ok(()) } else { Err(CacheError::Checksum { section }) }
    }
}

pub(crate) fn out_of_memory() -> CacheError {
    io::Error::from(io::ErrorKind::OutOfMemory).into()
}
