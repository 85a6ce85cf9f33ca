//! What commands have in common: scenes and split methods as the command line names them.

use std::fmt;
use std::path::PathBuf;

use anyhow::{Result, ensure};
use bvh_flat::primitive::Primitive;
use bvh_flat::{BuildConfig, SplitMethod};
use clap::ValueEnum;
use clap::error::ErrorKind;
use scene::{BuiltIn, Camera, CompiledScene, Scene};
use serde::{Deserialize, Serialize};

use crate::build_bar::BuildBar;

/// The seed of everything that is random: the same scene and the same rays on every machine.
pub const SEED: u64 = 42;

/// A scene, as the command line names it.
#[derive(Clone, Debug)]
pub enum SceneSource {
    BuiltIn(BuiltIn),
    File(PathBuf),
}

impl SceneSource {
    /// Parses `builtin:NAME` or a path; whether the path is there, the loader says.
    pub fn parse(text: &str) -> Result<Self, String> {
        match text.strip_prefix("builtin:") {
            Some(name) => BuiltIn::parse(name).map(Self::BuiltIn).map_err(|e| e.to_string()),
            None => Ok(Self::File(PathBuf::from(text))),
        }
    }

    /// The scene's name in tables.
    pub fn name(&self) -> String {
        match self {
            Self::BuiltIn(built_in) => format!("builtin:{built_in}"),
            Self::File(path) => path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
        }
    }

    /// Loads or makes the scene, and prints its warnings.
    pub fn load(&self) -> Result<Scene> {
        let scene = match self {
            Self::BuiltIn(built_in) => built_in.scene(SEED)?,
            Self::File(path) => scene::load(path)?,
        };
        let name = match self {
            Self::BuiltIn(_) => self.name(),
            Self::File(path) => path.display().to_string(),
        };
        for warning in &scene.warnings {
            // Those that say where in the file they are begin with its name.
            let named = warning.strip_prefix(&name).and_then(|rest| rest.strip_prefix(": "));
            eprintln!("warning: {name}: {}", named.unwrap_or(warning));
        }
        let can_be_hit = scene.geometries().iter().any(|g| g.shape.bounds().is_valid());
        ensure!(can_be_hit, "{name}: there is nothing in it that a ray could hit");
        Ok(scene)
    }
}

/// As the command line names it.
impl fmt::Display for SceneSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BuiltIn(built_in) => write!(f, "builtin:{built_in}"),
            Self::File(path) => write!(f, "{}", path.display()),
        }
    }
}

/// The help text of a SCENE argument.
pub const SCENE_HELP: &str = "\
A .ply, .obj, .gltf, .glb, .stl or .pbrt file, or one of builtin:stadium, builtin:terrain[:TRIANGLES], \
builtin:hairball[:TRIANGLES], with TRIANGLES such as 100k or 10M";

/// The split methods of the builder and its presets, as the command line and results name them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SplitMethodName {
    /// Surface area heuristic, 12 buckets
    Sah,
    /// Morton codes, treelets, SAH above: the fastest builds
    Hlbvh,
    /// The middle of the centroids' extent
    Middle,
    /// Half of the primitives on each side
    EqualCounts,
    /// A preset: the fastest builds, by HLBVH
    Fastest,
    /// A preset: SAH over 16 buckets, with leaves of up to eight
    Fast,
    /// A preset: SAH over more buckets, on all axes
    Balanced,
    /// A preset: SAH with reinsertion, and spatial splits of large nodes
    High,
    /// A preset: spatial splits of small nodes too, the best trees
    Highest,
}

impl SplitMethodName {
    /// Its name on the command line and in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sah => "sah",
            Self::Hlbvh => "hlbvh",
            Self::Middle => "middle",
            Self::EqualCounts => "equal-counts",
            Self::Fastest => "fastest",
            Self::Fast => "fast",
            Self::Balanced => "balanced",
            Self::High => "high",
            Self::Highest => "highest",
        }
    }

    pub fn config(self) -> BuildConfig {
        match self {
            Self::Sah => BuildConfig::new(SplitMethod::Sah),
            Self::Hlbvh => BuildConfig::new(SplitMethod::Hlbvh),
            Self::Middle => BuildConfig::new(SplitMethod::Middle),
            Self::EqualCounts => BuildConfig::new(SplitMethod::EqualCounts),
            Self::Fastest => BuildConfig::fastest(),
            Self::Fast => BuildConfig::fast(),
            Self::Balanced => BuildConfig::balanced(),
            Self::High => BuildConfig::high(),
            Self::Highest => BuildConfig::highest(),
        }
    }
}

/// Loads a scene and builds its trees.
pub fn compile(source: &SceneSource, method: SplitMethodName) -> Result<CompiledScene> {
    Ok(CompiledScene::build(source.load()?, &method.config(), &BuildBar::new())?)
}

/// The scene's own camera, else a view from outside.
pub fn camera(compiled: &CompiledScene) -> Camera {
    let own = compiled.scene().camera;
    own.unwrap_or_else(|| Camera::looking_at_bounds(&compiled.world().world_bound()))
}

/// The error of a command line that makes no sense, where only the scene or the catalogue could tell.
pub fn usage_error(message: impl fmt::Display) -> anyhow::Error {
    clap::Error::raw(ErrorKind::ValueValidation, format!("{message}\n")).into()
}
