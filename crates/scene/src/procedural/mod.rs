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
    let distance = |to: &str| {
        let to: Vec<char> = to.chars().collect();
        let mut row: Vec<usize> = (0..=to.len()).collect();
        for (i, c) in name.chars().enumerate() {
            let mut diagonal = row[0];
            row[0] = i + 1;
            for (j, &d) in to.iter().enumerate() {
                let substituted = diagonal + usize::from(c.to_ascii_lowercase() != d);
                diagonal = row[j + 1];
                row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
            }
        }
        row[to.len()]
    };
    known.iter().copied().min_by_key(|k| distance(k)).filter(|k| 2 * distance(k) < k.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SceneShape;

    #[test]
    fn names_and_numbers_are_read() {
        let terrain = |triangles| Ok(BuiltIn::Terrain { triangles });
        for (text, expected) in [
            ("stadium", Ok(BuiltIn::Stadium)),
            ("terrain", terrain(1_000_000)),
            ("hairball", Ok(BuiltIn::Hairball { triangles: 180_000 })),
            ("terrain:10000", terrain(10_000)),
            ("terrain:10k", terrain(10_000)),
            ("terrain:1M", terrain(1_000_000)),
            ("terrain:1m", terrain(1_000_000)),
            ("terrain:1e6", terrain(1_000_000)),
            ("terrain:2.5K", terrain(2_500)),
            ("terrain:1.001k", terrain(1_001)),
            ("terrain:1", terrain(1)),
            ("hairball:200M", Ok(BuiltIn::Hairball { triangles: MAX_TRIANGLES })),
            ("stadium:7", Err(BuiltInError::FixedSize { name: "stadium" })),
            ("terrain:", Err(BuiltInError::Number(String::new()))),
            ("terrain:k", Err(BuiltInError::Number("k".into()))),
            ("terrain:many", Err(BuiltInError::Number("many".into()))),
            ("terrain:1.5", Err(BuiltInError::Number("1.5".into()))),
            ("terrain:nan", Err(BuiltInError::Number("nan".into()))),
            ("terrain:inf", Err(BuiltInError::Number("inf".into()))),
            ("terrain:1e308M", Err(BuiltInError::Number("1e308M".into()))),
            ("terrain:1k:2", Err(BuiltInError::Number("1k:2".into()))),
            ("terrain:0", Err(BuiltInError::Size(0))),
            ("terrain:-3", Err(BuiltInError::Size(0))),
            ("terrain:200000001", Err(BuiltInError::Size(200_000_001))),
            ("terrain:1e30", Err(BuiltInError::Size(u64::MAX))),
        ] {
            assert_eq!(BuiltIn::parse(text), expected, "{text}");
        }
        for scene in [BuiltIn::default(), BuiltIn::Terrain { triangles: 123 }, BuiltIn::Hairball { triangles: 7 }] {
            assert_eq!(BuiltIn::parse(&scene.to_string()), Ok(scene));
        }
    }

    #[test]
    fn unknown_names_are_answered_by_the_nearest() {
        for (text, expected) in [
            ("stadion", Some("stadium")),
            ("Terrain", Some("terrain")),
            ("tarrain:10k", Some("terrain")),
            ("hair", None),
            ("hairbal", Some("hairball")),
            ("bunny", None),
            ("", None),
            ("ß", None),
        ] {
            let error = BuiltIn::parse(text).expect_err("unknown");
            assert!(matches!(&error, BuiltInError::Unknown { nearest, .. } if *nearest == expected), "{text}: {error}");
            assert!(error.to_string().contains("known are stadium, terrain"), "{error}");
        }
        let message = BuiltIn::parse("stadion").expect_err("unknown").to_string();
        assert!(
            message.starts_with("there is no built-in scene \"stadion\", did you mean \"stadium\"?; known"),
            "{message}"
        );
    }

    #[test]
    fn sizes_out_of_range_are_refused_without_parsing_too() {
        for triangles in [0, MAX_TRIANGLES + 1, u64::MAX] {
            for scene in [BuiltIn::Terrain { triangles }, BuiltIn::Hairball { triangles }] {
                assert_eq!(scene.scene(0).expect_err("refused"), BuiltInError::Size(triangles));
            }
        }
    }

    fn meshes_of(scene: &Scene) -> Vec<&geometry::TriangleMesh> {
        let shapes = scene.geometries().iter().map(|g| &g.shape);
        shapes.filter_map(|s| if let SceneShape::Mesh(mesh) = s { Some(&**mesh) } else { None }).collect()
    }

    /// Of each scene: as many triangles as asked for, all of them in the domain, and a camera that sees.
    #[test]
    fn every_scene_is_sound_and_belongs_to_its_seed() {
        for (built_in, triangles) in [
            (BuiltIn::Stadium, 80_000..=120_000),
            (BuiltIn::Terrain { triangles: 1 }, 2..=2),
            (BuiltIn::Terrain { triangles: 10_000 }, 9_900..=10_100),
            (BuiltIn::Terrain { triangles: 99_999 }, 99_600..=100_400),
            (BuiltIn::Hairball { triangles: 1 }, 60..=60),
            (BuiltIn::Hairball { triangles: 10_000 }, 9_970..=10_030),
        ] {
            let scene = |seed| built_in.scene(seed).expect("its size is in range");
            let one = scene(1);
            assert!(triangles.contains(&one.triangle_count()), "{built_in}: {}", one.triangle_count());
            assert!(one.warnings.is_empty(), "{built_in}: {:?}", one.warnings);
            assert!(one.geometries().iter().all(|g| g.shape.bounds().is_valid()));
            let camera = one.camera.expect("a built-in scene has a camera");
            assert!(camera.view(16, 16).is_ok());
            assert_eq!(meshes_of(&one), meshes_of(&scene(1)), "{built_in}");
            assert_ne!(format!("{one:?}"), format!("{:?}", scene(2)), "{built_in}");
        }
    }

    /// Figures measured in these scenes stay comparable, from one platform and version to another.
    #[test]
    fn not_a_bit_changes() {
        let mut checksums = Vec::new();
        for text in ["stadium", "terrain:1k", "hairball:1k"] {
            let scene = BuiltIn::parse(text).expect("known").scene(42).expect("in range");
            let numbers = meshes_of(&scene).into_iter().flat_map(|m| m.positions()).flat_map(|p| p.to_array());
            checksums.push(numbers.fold(0, |sum, x| random::scramble(sum ^ u64::from(x.to_bits()))));
        }
        assert_eq!(checksums, [0x4864_bf65_f720_bc55, 0x6603_fa66_f0f2_2af2, 0x7a5b_07d2_24f6_6263]);
    }

    /// Hairs are thin; where the ground is seen from above, it faces up, and the camera stands above it.
    #[test]
    fn terrain_and_hairball_are_what_they_are_called() {
        for seed in 0..4 {
            let scene = BuiltIn::Terrain { triangles: 5_000 }.scene(seed).expect("in range");
            let terrain = meshes_of(&scene)[0];
            let faces_up = |[a, b, c]: [geometry::glam::Vec3; 3]| (b - a).cross(c - a).y > 0.0;
            assert!((0..terrain.len()).all(|i| faces_up(terrain.vertices(i))));
            let eye = geometry::glam::Vec3::from(scene.camera.expect("a built-in scene has a camera").eye);
            let near = terrain.positions().iter().filter(|p| (**p - eye).with_y(0.0).length() < 10.0);
            assert!(near.clone().count() > 0 && near.map(|p| p.y).fold(f32::MIN, f32::max) < eye.y, "{seed}");
        }
        let scene = BuiltIn::Hairball { triangles: 6_000 }.scene(0).expect("in range");
        let hair = meshes_of(&scene)[0];
        for i in 0..hair.len() {
            let [a, b, c] = hair.vertices(i);
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            assert!((b - a).cross(c - a).length() < 0.2 * longest * longest, "{i}");
        }
        assert!(hair.positions().iter().all(|p| p.length() < 1.4));
    }
}
