//! What a renderer wants: the tree, from wherever it comes.

#[cfg(feature = "build")]
use std::io;
#[cfg(feature = "build")]
use std::path::Path;

use super::CacheError;
#[cfg(feature = "build")]
use super::is_cache_file;
#[cfg(feature = "build")]
use crate::BuildError;

/// A tree that was loaded or built.
#[derive(Debug)]
#[cfg(feature = "build")]
pub struct Cached<T> {
    /// The tree.
    pub tree: T,
    /// Where it comes from.
    pub origin: Origin,
}

/// Where a tree comes from.
#[derive(Debug)]
pub enum Origin {
    /// From the file.
    Loaded,
    /// It was built.
    Built {
        /// Why the file there was not taken; `None` where there was none.
        refused: Option<CacheError>,
        /// Why the tree could not be saved in its place; `None` where it was.
        not_saved: Option<CacheError>,
    },
}

impl Origin {
    /// Whether it comes from the file.
    pub fn is_loaded(&self) -> bool {
        matches!(self, Self::Loaded)
    }

    /// What a person should be told, once: that a file was refused or could not be written. Nothing where all went
    /// well, and nothing of a file that was not there.
    pub fn message(&self) -> Option<String> {
        match self {
            Self::Loaded | Self::Built { refused: None, not_saved: None } => None,
            Self::Built { refused: Some(refused), not_saved: None } => Some(format!("replaced: {refused}")),
            Self::Built { refused: None, not_saved: Some(error) } => Some(format!("not saved: {error}")),
            Self::Built { refused: Some(refused), not_saved: Some(CacheError::Kept) } => {
                Some(format!("left as it is, and not used: {refused}"))
            }
            Self::Built { refused: Some(refused), not_saved: Some(error) } => {
                Some(format!("not used: {refused}; and not replaced: {error}"))
            }
        }
    }
}

/// Loads; where that is refused, builds and saves. Only what begins like a cache file is replaced: a wrong path must
/// not cost somebody's scene.
#[cfg(feature = "build")]
pub(crate) fn load_or_build<T>(
    path: &Path,
    load: impl FnOnce(&Path) -> Result<T, CacheError>,
    build: impl FnOnce() -> Result<T, BuildError>,
    save: impl FnOnce(&T, &Path) -> Result<(), CacheError>,
) -> Result<Cached<T>, BuildError> {
    let refused = match load(path) {
        Ok(tree) => return Ok(Cached { tree, origin: Origin::Loaded }),
        Err(CacheError::Io(error)) if is_nothing_there(&error) => None,
        Err(refused) => Some(refused),
    };
    let tree = build()?;
    // Asked after the build, which can take minutes.
    let may_be_replaced = is_cache_file(path).unwrap_or_else(|error| is_nothing_there(&error));
    let not_saved = if may_be_replaced { save(&tree, path).err() } else { Some(CacheError::Kept) };
    Ok(Cached { tree, origin: Origin::Built { refused, not_saved } })
}

#[cfg(feature = "build")]
fn is_nothing_there(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory)
}
