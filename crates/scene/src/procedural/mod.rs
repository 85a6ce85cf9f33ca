//! Scenes that need no file: seeded, the same on every platform.

mod hairball;
mod kit;
pub mod meshes;
mod props;
mod random;
mod stadium;
mod stands;
mod terrain;

use std::fmt;

use geometry::{AnimatedTransformError, MeshError, SphereError, TransformError};
use thiserror::Error;

pub(crate) use random::Random;

use crate::spelling::distance;
use crate::{Scene, SceneError};

/// A procedural scene.
///
/// Written `stadium`, `terrain` or `terrain:TRIANGLES`, `hairball` or `hairball:TRIANGLES`, with 10000, 10k, 1M or 1e6
/// for the number; [`parse`](Self::parse) and `Display` agree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BuiltIn {
    /// A teapot in a stadium: a bowl of instanced seats around a pitch with closed meshes, slivers, spheres, moving
    /// instances and fog. It has everything that a scene can have, in about 100 k triangles.
    #[default]
    Stadium,
    /// A fractal landscape: one regular grid, hence triangles of nearly equal size.
    Terrain {
        /// About how many triangles: the grid of whole rows nearest to it.
        triangles: u64,
    },
    /// Thin curled hairs on a ball: triangles that hardly fill their boxes, which overlap.
    Hairball {
        /// About how many triangles: whole hairs of 60, the nearest number of them.
        triangles: u64,
    },
}

/// The most triangles that are generated on demand; about 5 GB.
pub const MAX_TRIANGLES: u64 = 200_000_000;

/// Why there is no such built-in scene.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum BuiltInError {
    /// There is none of this name.
    #[error("there is no built-in scene \"{name}\"{}; known are stadium, terrain[:TRIANGLES] and hairball[:TRIANGLES]",
        .nearest.map(|n| format!(", did you mean \"{n}\"?")).unwrap_or_default())]
    Unknown {
        /// The name asked for.
        name: String,
        /// The known name most like it, if any is.
        nearest: Option<&'static str>,
    },
    /// The scene is of one size.
    #[error("the built-in scene \"{name}\" takes no number of triangles")]
    FixedSize {
        /// The scene.
        name: &'static str,
    },
    /// What should be a number of triangles is none.
    #[error("\"{0}\" is no number of triangles; write 10000, 10k, 1M or 1e6")]
    Number(String),
    /// The number of triangles is out of range.
    #[error("{0} triangles: a built-in scene has at least 1 and at most {MAX_TRIANGLES}")]
    Size(u64),
    /// A mesh could not be made.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A sphere could not be made.
    #[error(transparent)]
    Sphere(#[from] SphereError),
    /// A transform could not be made.
    #[error(transparent)]
    Transform(#[from] TransformError),
    /// A moving transform could not be made.
    #[error(transparent)]
    Motion(#[from] AnimatedTransformError),
    /// The scene could not be put together.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

impl BuiltIn {
    const NAMES: [&str; 3] = ["stadium", "terrain", "hairball"];

    /// The scene of a name, with a number of triangles behind a colon where it takes one; the default sizes are a
    /// terrain of 1 M and a hairball of 180 k triangles.
    ///
    /// # Errors
    /// [`BuiltInError::Unknown`], [`BuiltInError::FixedSize`], [`BuiltInError::Number`], [`BuiltInError::Size`].
    pub fn parse(text: &str) -> Result<Self, BuiltInError> {
        let (name, triangles) = match text.split_once(':') {
            Some((name, number)) => (name, Some(parse_triangles(number)?)),
            None => (text, None),
        };
        match (name, triangles) {
            ("stadium", None) => Ok(Self::Stadium),
            ("stadium", Some(_)) => Err(BuiltInError::FixedSize { name: "stadium" }),
            ("terrain", triangles) => Ok(Self::Terrain { triangles: triangles.unwrap_or(1_000_000) }),
            ("hairball", triangles) => Ok(Self::Hairball { triangles: triangles.unwrap_or(180_000) }),
            _ => Err(BuiltInError::Unknown { name: name.to_owned(), nearest: nearest(name, &Self::NAMES) }),
        }
    }

    /// The scene that belongs to `seed`, with its camera.
    ///
    /// # Errors
    /// [`BuiltInError::Size`] where the number of triangles is 0 or above [`MAX_TRIANGLES`]. The other kinds are passed
    /// on from the constructors of meshes and transforms, which do not fail on what these scenes consist of.
    pub fn scene(&self, seed: u64) -> Result<Scene, BuiltInError> {
        match *self {
            Self::Stadium => stadium::scene(seed),
            Self::Terrain { triangles } => terrain::scene(check_size(triangles)?, seed),
            Self::Hairball { triangles } => hairball::scene(check_size(triangles)?, seed),
        }
    }
}

impl fmt::Display for BuiltIn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stadium => write!(f, "stadium"),
            Self::Terrain { triangles } => write!(f, "terrain:{triangles}"),
            Self::Hairball { triangles } => write!(f, "hairball:{triangles}"),
        }
    }
}

fn check_size(triangles: u64) -> Result<u64, BuiltInError> {
    if (1..=MAX_TRIANGLES).contains(&triangles) { Ok(triangles) } else { Err(BuiltInError::Size(triangles)) }
}

/// A whole number, of which k or M stands for three or six zeros; a fraction or an exponent may stand before them.
fn parse_triangles(text: &str) -> Result<u64, BuiltInError> {
    let no_number = || BuiltInError::Number(text.to_owned());
    let (digits, factor) = match text.char_indices().last() {
        Some((end, 'k' | 'K')) => (&text[..end], 1e3),
        Some((end, 'm' | 'M')) => (&text[..end], 1e6),
        _ => (text, 1.0),
    };
    let number = digits.parse::<f64>().map_err(|_| no_number())? * factor;
    // 1.001k is not 1001 in binary, but nearly.
    let whole = number.round();
    if !number.is_finite() || (number - whole).abs() > 1e-9 * whole.abs() {
        return Err(no_number());
    }
    // The cast saturates: -1 becomes 0, which is out of range too.
    check_size(whole as u64)
}

/// The one of `known` that takes the fewest single-letter changes to become `name`, if less than half of it changes.
fn nearest(name: &str, known: &[&'static str]) -> Option<&'static str> {
    known.iter().copied().min_by_key(|k| distance(name, k)).filter(|k| 2 * distance(name, k) < k.len())
}

#[cfg(test)]
mod tests;
