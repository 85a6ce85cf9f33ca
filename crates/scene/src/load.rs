//! From a path to a scene.

use std::fmt;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::{Scene, SceneError, gltf, obj, pbrt, ply, stl};

/// Why a file is no scene. Each message names the file, the place where it can, and the reason.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The file cannot be read.
    #[error("{}: cannot be read", .path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The path is a directory.
    #[error("{}: is a directory; name a scene file in it", .path.display())]
    Directory {
        /// The directory.
        path: PathBuf,
    },
    /// The file's extension is not one of a scene format.
    #[error("{}: \"{extension}\" is no scene format; known are .ply, .obj, .gltf, .glb, .stl and .pbrt", .path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// Its extension.
        extension: String,
    },
    /// The file is damaged, or not what its name says.
    #[error("{}: {place}{reason}", .path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Where.
        place: Place,
        /// Why.
        reason: String,
    },
    /// The file is sound but needs something that is not supported.
    #[error("{}: {place}{feature} is not supported{advice}", .path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// Where.
        place: Place,
        /// What it needs.
        feature: String,
        /// What can be done, beginning with "; ", or empty.
        advice: String,
    },
}

/// A place in a file; printed with a colon and a space behind it, or as nothing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Place {
    /// Not known.
    #[default]
    Unknown,
    /// A line, counted from 1.
    Line(usize),
    /// A byte, counted from 0.
    Byte(u64),
    /// A named part, such as "mesh 3" or "vertex 17".
    Part(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown => Ok(()),
            Self::Line(line) => write!(f, "line {line}: "),
            Self::Byte(byte) => write!(f, "byte {byte}: "),
            Self::Part(part) => write!(f, "{part}: "),
        }
    }
}

impl LoadError {
    pub(crate) fn malformed(path: &Path, place: Place, reason: impl Into<String>) -> Self {
        Self::Malformed { path: path.to_owned(), place, reason: reason.into() }
    }

    pub(crate) fn scene(path: &Path, error: SceneError) -> Self {
        Self::malformed(path, Place::Unknown, error.to_string())
    }
}

/// Reads the scene file at `path`; its format is told by its extension.
///
/// # Errors
/// [`LoadError`] where the file cannot be read, is damaged, or needs what is not supported.
pub fn load(path: &Path) -> Result<Scene, LoadError> {
    let metadata = std::fs::metadata(path).map_err(|source| LoadError::Io { path: path.to_owned(), source })?;
    if metadata.is_dir() {
        return Err(LoadError::Directory { path: path.to_owned() });
    }
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "ply" => ply::load(path),
        "obj" => obj::load(path),
        "stl" => stl::load(path),
        "gltf" | "glb" => gltf::load(path),
        "pbrt" => pbrt::load(path),
        _ => Err(LoadError::UnknownFormat { path: path.to_owned(), extension }),
    }
}
