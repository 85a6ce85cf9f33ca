//! What a file says of itself.

use std::io;
use std::path::Path;

use geometry::Bounds3;

use super::header::{Header, begins_like_ours};
use super::source::{OpenFile, Source};
use super::{CacheError, GeometryKey, TreeLayout, TreeOptions};
use crate::FlatBvh;

/// What the header of a file says of the tree in it.
#[derive(Clone, Debug)]
pub struct CacheInfo {
    header: Header,
    file_length: u64,
}

impl CacheInfo {
    /// Reads a header, and checks that it is whole; nothing behind it is looked at.
    ///
    /// # Errors
    /// [`CacheError`] where it cannot be read, is no header of this version, or is damaged; or where the file has
    /// another length than it says.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, CacheError> {
        let file = OpenFile::open(path.as_ref())?;
        Ok(Self { header: Header::read(&file)?, file_length: file.len() })
    }

    /// How the tree was built.
    pub fn options(&self) -> &TreeOptions {
        &self.header.options
    }

    /// Over what it was built.
    pub fn geometry(&self) -> GeometryKey {
        self.header.geometry
    }

    /// How many primitives the geometry has, counting those that cannot be hit.
    pub fn primitive_count(&self) -> u64 {
        self.header.counts.primitives
    }

    /// How many references to primitives the leaves have: more than active primitives where space was split.
    pub fn reference_count(&self) -> u64 {
        self.header.counts.references
    }

    /// How many nodes there are: of a binary tree all, of a wide one those with children.
    pub fn node_count(&self) -> u64 {
        self.header.counts.nodes
    }

    /// How many leaves there are.
    pub fn leaf_count(&self) -> u64 {
        self.header.counts.leaves
    }

    /// The number of nodes on the longest path, with the leaf; 0 for a tree over nothing.
    pub fn depth(&self) -> u32 {
        self.header.counts.depth
    }

    /// The box around everything, in the space of the primitives; empty for a tree over nothing.
    pub fn bounds(&self) -> Bounds3 {
        self.header.bounds
    }

    /// The length of the file in bytes.
    pub fn file_length(&self) -> u64 {
        self.file_length
    }
}

/// Whether the file begins as cache files do, of whatever version and however damaged behind: with the same eight
/// bytes, or as many of them as it has. So an empty one is a cache file that was cut.
///
/// # Errors
/// Where it cannot be read, or is no regular file.
pub fn is_cache_file(path: impl AsRef<Path>) -> io::Result<bool> {
    let file = OpenFile::open(path.as_ref())?;
    let mut begin = [0; 8];
    let begin = &mut begin[..file.len().min(8) as usize];
    file.read_exact_at(0, begin)?;
    Ok(begins_like_ours(begin))
}

/// Checks a file as far as that goes without the geometry: the header, all sums, and the structure. What is left is
/// whether the boxes of binary and compact trees are around the primitives, which are not in the file, whether the
/// vertices in blocks are those of the mesh, and whether any primitive is missing: that a load checks. Takes the memory
/// of the file, and for a list of the primitives up to one and a half times as much.
///
/// # Errors
/// [`CacheError`]: what is wrong, and where.
pub fn verify(path: impl AsRef<Path>) -> Result<CacheInfo, CacheError> {
    let file = OpenFile::open(path.as_ref())?;
    let header = Header::read(&file)?;
    match header.options.layout {
        TreeLayout::Binary => FlatBvh::read(&file, None, None).map(drop)?,
        TreeLayout::Wide(_) => super::wide::verify_alone(&file, &header)?,
    }
    Ok(CacheInfo { header, file_length: file.len() })
}
