//! Trees in files: written once, then loaded instead of built, by any number of processes and machines.
//!
//! ```
//! # use bvh_flat::geometry::TriangleMesh;
//! # use bvh_flat::{BuildConfig, WideLayout, WideMesh};
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("square.bvh");
//! # let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
//! # let mesh = std::sync::Arc::new(TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]])?);
//! let config = BuildConfig::balanced();
//! let cached = WideMesh::load_or_build(&path, mesh, &config, WideLayout::Blocks)?;
//! if let Some(message) = cached.origin.message() {
//!     eprintln!("{}: {message}", path.display());
//! }
//! let mesh = cached.tree;
//! # assert!(!cached.origin.is_loaded());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The format is described in `FORMAT.md` of this crate, byte by byte. A tree that loads answers like the one that was
//! saved, bit for bit. Every other file is refused with a [`CacheError`] that says why: damage by checksums, other
//! geometry and options by their keys, and whatever is left by a look at the whole structure, since a sum proves
//! nothing about who made it. One thing rests on the checksum: that the parts of a triangle make up all of it, where
//! space was split. No file makes a program crash, hang, or allocate more than the file's size, a byte for each
//! triangle of the mesh given, or in a binary tree the order once more, and 1 MiB.
//!
//! Is it worth it? `cargo xtask cache bench SCENE` measures what a load takes beside a build.

mod binary;
mod checksum;
mod error;
mod file;
mod header;
mod info;
mod key;
mod load_or_build;
mod section;
mod source;
mod wide;

pub use error::{CacheError, InvalidTree, Section};
pub use file::TEMPORARY_PREFIX;
pub use info::{CacheInfo, is_cache_file, verify};
pub use key::{GeometryKey, TreeLayout, TreeOptions};
#[cfg(feature = "build")]
pub use load_or_build::Cached;
pub use load_or_build::Origin;
