//! Why a file is refused.

use std::fmt;
use std::io;

use thiserror::Error;

use super::TreeLayout;
use crate::{InvalidBvh, InvalidWideTree};

/// Why a cache file is refused, or cannot be written: one variant for each cause, in the order in which a loader looks;
/// the last is of writers.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CacheError {
    /// The file cannot be opened, read or written.
    #[error("the cache file cannot be read or written: {0}; see that its path, its permissions and the disk are right")]
    Io(io::Error),
    /// It begins like no cache file.
    #[error("this is no cache file of a tree; give the name of one")]
    NotACache,
    /// There are fewer bytes than the file says or must have.
    #[error(
        "the file has {found} of {expected} bytes: it was cut, or is still being copied; copy it again or rebuild it"
    )]
    Truncated {
        /// How many there should be.
        expected: u64,
        /// How many there are.
        found: u64,
    },
    /// It was written on a machine with the other byte order.
    #[error("the file comes from a machine with the other byte order; build the tree again on this one")]
    ByteOrder,
    /// A later version of this library wrote it.
    #[error("{what} {found} is newer than {supported}, the newest known here; update this program or rebuild the file")]
    NewerVersion {
        /// Of what: the format, or the layout of a section.
        what: &'static str,
        /// The version of the file.
        found: u32,
        /// The newest that can be read.
        supported: u32,
    },
    /// An earlier version of this library wrote it.
    #[error("{what} {found} is older than {supported}, the oldest known here; rebuild the file")]
    OlderVersion {
        /// Of what: the format, or the layout of a section.
        what: &'static str,
        /// The version of the file.
        found: u32,
        /// The oldest that can be read.
        supported: u32,
    },
    /// Bytes are not those that were written.
    #[error("the {section} of the file is damaged: its checksum is not that of what was written; rebuild the file")]
    Checksum {
        /// Where.
        section: Section,
    },
    /// The header's sum is right, but what it says cannot be.
    #[error("the header of the file is not valid: {0}; rebuild the file with this program")]
    Header(&'static str),
    /// More bytes than the file says.
    #[error("the file has {found} bytes, not {expected}: something was appended to it; rebuild it")]
    TrailingBytes {
        /// How many there should be.
        expected: u64,
        /// How many there are.
        found: u64,
    },
    /// A tree of another kind than was asked for; of a writer, options of another layout than the tree's.
    #[error("the layout is {found}, not {expected}; ask for what is there, or build the tree again")]
    OtherLayout {
        /// What was asked for, or is the tree's.
        expected: &'static str,
        /// What is in the file, or in the options.
        found: TreeLayout,
    },
    /// The tree was built over other geometry.
    #[error("the tree was built over other geometry; build it again over this one")]
    StaleGeometry,
    /// The tree was built in another way: with another configuration, or by another version of the builder.
    #[error("the tree was built as \"{found}\", not as \"{expected}\"; build it again, or ask for what is there")]
    StaleOptions {
        /// The way that was asked for.
        expected: String,
        /// The way that the file names.
        found: String,
    },
    /// A byte between the sections is not zero.
    #[error("byte {offset} of the file should be zero; rebuild it")]
    NotZero {
        /// Which.
        offset: u64,
    },
    /// The bytes are those that were written, but they are no tree.
    #[error("the file has no valid tree: {0}; rebuild it with this program")]
    Structure(InvalidTree),
    /// There is something at the path that is not replaced: it does not begin like a cache file, or cannot be read.
    /// (What is empty begins like one that was cut.)
    #[error("what is there is no cache file, or cannot be read, and was left as it is; give another path")]
    Kept,
}

/// Why sections are no tree, or none over the geometry given.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum InvalidTree {
    /// A binary one.
    #[error(transparent)]
    Binary(#[from] InvalidBvh),
    /// A wide one.
    #[error(transparent)]
    Wide(#[from] InvalidWideTree),
    /// The tree has other counts than the header says.
    #[error("the header says {recorded} {what}, the tree has {found}")]
    Recorded {
        /// Of what.
        what: &'static str,
        /// In the header.
        recorded: u64,
        /// In the tree.
        found: u64,
    },
}

// Not as sources: their words are in the message already.
impl From<io::Error> for CacheError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl From<InvalidTree> for CacheError {
    fn from(invalid: InvalidTree) -> Self {
        Self::Structure(invalid)
    }
}

impl From<InvalidBvh> for CacheError {
    fn from(invalid: InvalidBvh) -> Self {
        InvalidTree::from(invalid).into()
    }
}

impl From<InvalidWideTree> for CacheError {
    fn from(invalid: InvalidWideTree) -> Self {
        InvalidTree::from(invalid).into()
    }
}

/// A part of a file with a checksum of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Section {
    /// The first 512 bytes.
    Header,
    /// The nodes of a binary tree.
    Nodes,
    /// The primitives in the order of a binary tree's leaves.
    Order,
    /// The nodes and leaves of a wide tree.
    Arena,
}

impl fmt::Display for Section {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Header => "header",
            Self::Nodes => "nodes section",
            Self::Order => "order section",
            Self::Arena => "arena section",
        })
    }
}
