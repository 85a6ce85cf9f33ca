//! `xtask cache`: trees in files.

mod bench;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use bvh_flat::cache::{CacheError, CacheInfo, GeometryKey, TEMPORARY_PREFIX, TreeLayout, TreeOptions, is_cache_file};
use bvh_flat::geometry::TriangleMesh;
use bvh_flat::{FlatBvh, MeshBvh, WideLayout, WideMesh};
use clap::{Args, Subcommand, ValueEnum};
use scene::{Scene, SceneShape};

use crate::build_bar::BuildBar;
use crate::input::{self, SCENE_HELP, SceneSource, SplitMethodName};
use crate::measure::peak_memory;
use crate::table::count;

pub use bench::uses_until_a_file_pays;

#[derive(Args)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Build the tree of each mesh of a scene and save it
    Build(BuildArguments),
    /// Print what a file says of itself
    Info {
        /// A cache file
        file: PathBuf,
    },
    /// Say that a file is good, or exactly what is wrong with it, and where
    Verify {
        /// A cache file
        file: PathBuf,
        /// The scene with its mesh: then the vertices are compared too, and nothing may be missing
        #[arg(long, long_help = SCENE_HELP, value_parser = SceneSource::parse)]
        scene: Option<SceneSource>,
    },
    /// Measure build, save, load and mapped load of a scene, and when a cache pays
    Bench(bench::Arguments),
    /// Delete the cache files of a directory, and what writers that were ended have left there; nothing else
    Clear {
        /// The directory
        #[arg(long, default_value = DIRECTORY)]
        dir: PathBuf,
        /// Minutes without a write after which a writer's unfinished file is taken for left over
        #[arg(long, value_name = "MINUTES", default_value_t = 60)]
        abandoned_after: u64,
    },
}

#[derive(Args)]
struct BuildArguments {
    #[arg(help = SCENE_HELP, value_parser = SceneSource::parse)]
    scene: SceneSource,
    /// The file, of a scene with one mesh
    #[arg(long, value_name = "FILE", conflicts_with = "dir")]
    out: Option<PathBuf>,
    /// The directory, where each file has the name of its content
    #[arg(long, default_value = DIRECTORY)]
    dir: PathBuf,
    #[command(flatten)]
    way: Way,
}

/// Where files go that are given no name.
const DIRECTORY: &str = "target/bvh-cache";

/// How trees are built.
#[derive(Args)]
pub struct Way {
    /// How they are split
    #[arg(long, value_enum, default_value_t = SplitMethodName::Sah, value_name = "METHOD")]
    split_method: SplitMethodName,
    /// Their form
    #[arg(long, value_enum, default_value_t = LayoutName::Blocks, value_name = "LAYOUT")]
    layout: LayoutName,
}

/// The forms of trees, as the command line names them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum LayoutName {
    /// Wide, with the vertices in the leaves: the fastest to trace
    Blocks,
    /// Wide and quantised: the smallest
    Compact,
    /// Nodes of two children
    Binary,
}

impl LayoutName {
    fn layout(self) -> TreeLayout {
        match self {
            Self::Blocks => TreeLayout::Wide(WideLayout::Blocks),
            Self::Compact => TreeLayout::Wide(WideLayout::Compact),
            Self::Binary => TreeLayout::Binary,
        }
    }
}

pub fn run(arguments: &Arguments) -> Result<()> {
    match &arguments.command {
        Command::Build(arguments) => build(arguments),
        Command::Info { file } => info(file),
        Command::Verify { file, scene } => verify(file, scene.as_ref()),
        Command::Bench(arguments) => bench::run(arguments),
        Command::Clear { dir, abandoned_after } => clear(dir, Duration::from_secs(abandoned_after.saturating_mul(60))),
    }
}

/// The meshes of a scene, each once.
fn meshes(scene: &Scene) -> Vec<Arc<TriangleMesh>> {
    let mut meshes: Vec<Arc<TriangleMesh>> = Vec::new();
    for geometry in scene.geometries() {
        if let SceneShape::Mesh(mesh) = &geometry.shape
            && !meshes.iter().any(|known| Arc::ptr_eq(known, mesh))
        {
            meshes.push(Arc::clone(mesh));
        }
    }
    meshes
}

fn build(arguments: &BuildArguments) -> Result<()> {
    let meshes = meshes(&arguments.scene.load()?);
    let one = meshes.len() == 1;
    if arguments.out.is_some() && !one {
        let meshes = meshes.len();
        return Err(input::usage_error(format!(
            "the scene has {meshes} meshes; --dir makes a file for each, --out one"
        )));
    }
    if let Some(out) = arguments.out.as_deref().filter(|out| out.exists())
        && !is_cache_file(out).with_context(|| out.display().to_string())?
    {
        return Err(CacheError::Kept).with_context(|| out.display().to_string());
    }
    if arguments.out.is_none() {
        let dir = &arguments.dir;
        std::fs::create_dir_all(dir).with_context(|| format!("{}: cannot be made", dir.display()))?;
    }
    let config = arguments.way.split_method.config();
    let options = TreeOptions::new(&config, arguments.way.layout.layout());
    for mesh in meshes {
        let key = GeometryKey::of_mesh(&mesh);
        let path = arguments.out.clone().unwrap_or_else(|| arguments.dir.join(options.file_name(key)));
        let (peak, length, memory) = match options.layout() {
            TreeLayout::Wide(layout) => {
                let (peak, tree) = peak_memory(|| WideMesh::build_observed(mesh, &config, layout, &BuildBar::new()));
                let tree = tree?;
                tree.save(&path, &options).with_context(|| path.display().to_string())?;
                (peak, tree.file_length(), tree.memory())
            }
            TreeLayout::Binary => {
                let (peak, tree) = peak_memory(|| MeshBvh::build_observed(mesh, &config, &BuildBar::new()));
                let tree = tree?;
                tree.bvh().save(&path, key, &options).with_context(|| path.display().to_string())?;
                (peak, tree.bvh().file_length(), tree.memory())
            }
        };
        println!("{}: {} bytes", path.display(), count(length));
        // What a small build takes is the process's own.
        if let Some(peak) = peak.filter(|_| memory >= 1 << 20) {
            let ratio = peak as f64 / memory.max(1) as f64;
            println!(
                "in memory {} bytes; while it was built at most {} ({ratio:.2} times)",
                count(memory as u64),
                count(peak)
            );
        }
    }
    Ok(())
}

fn info(file: &Path) -> Result<()> {
    let info = CacheInfo::read(file).with_context(|| file.display().to_string())?;
    let per_primitive = info.file_length() as f64 / info.primitive_count().max(1) as f64;
    let rows = [
        ("layout", info.options().layout().to_string()),
        ("built as", info.options().description().to_owned()),
        ("geometry", info.geometry().to_string()),
        ("primitives", format!("{} ({} in leaves)", count(info.primitive_count()), count(info.reference_count()))),
        ("nodes", count(info.node_count())),
        ("leaves", count(info.leaf_count())),
        ("depth", info.depth().to_string()),
        ("bounds", format!("{} to {}", info.bounds().min, info.bounds().max)),
        ("file", format!("{} bytes, {per_primitive:.1} a primitive", count(info.file_length()))),
        ("name", info.options().file_name(info.geometry())),
    ];
    for (what, value) in rows {
        println!("{what:<11} {value}");
    }
    Ok(())
}

fn verify(file: &Path, source: Option<&SceneSource>) -> Result<()> {
    let named = || file.display().to_string();
    let info = bvh_flat::cache::verify(file).with_context(named)?;
    let Some(source) = source else {
        println!("{}: good, as far as can be told without its scene", file.display());
        return Ok(());
    };
    let meshes = meshes(&source.load()?);
    let mesh = meshes.into_iter().find(|mesh| GeometryKey::of_mesh(mesh) == info.geometry());
    let mesh = mesh.ok_or(CacheError::StaleGeometry).with_context(named)?;
    match info.options().layout() {
        TreeLayout::Wide(_) => drop(WideMesh::load(file, mesh, None).with_context(named)?),
        TreeLayout::Binary => {
            let tree = FlatBvh::load(file, info.geometry(), None).with_context(named)?;
            MeshBvh::from_parts(mesh, tree).map_err(CacheError::from).with_context(named)?;
        }
    }
    println!("{}: good, a tree over a mesh of {}", file.display(), source.name());
    Ok(())
}

fn clear(directory: &Path, abandoned_after: Duration) -> Result<()> {
    let context = || format!("{}: cannot be read", directory.display());
    let entries = match std::fs::read_dir(directory) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            println!("{}: is not there", directory.display());
            return Ok(());
        }
        entries => entries.with_context(context)?,
    };
    let (mut files, mut bytes, mut left) = (0, 0, 0);
    for entry in entries {
        let path = entry.with_context(context)?.path();
        match clear_file(&path, abandoned_after) {
            Ok(None) => (),
            Ok(Some(length)) => (files, bytes) = (files + 1, bytes + length),
            // A writer has made the whole file of it, or somebody else has cleared it.
            Err(error) if error.kind() == io::ErrorKind::NotFound => (),
            Err(error) => {
                eprintln!("{}: left: {error}", path.display());
                left += 1;
            }
        }
    }
    println!("{}: deleted {files} files of {} bytes", directory.display(), count(bytes));
    ensure!(left == 0, "{left} files could not be read or deleted");
    Ok(())
}

/// Deletes a file that begins like ours and has our ending, of whatever version, however damaged behind; or one that a
/// writer began and no longer writes to. How long it was; `None` for what stays.
fn clear_file(path: &Path, abandoned_after: Duration) -> io::Result<Option<u64>> {
    let metadata = path.symlink_metadata()?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let is_candidate = if name.starts_with(TEMPORARY_PREFIX) {
        metadata.modified()?.elapsed().is_ok_and(|since| since >= abandoned_after)
    } else {
        path.extension().is_some_and(|extension| extension == "bvh") && metadata.len() > 0
    };
    if !metadata.is_file() || !is_candidate || !is_cache_file(path)? {
        return Ok(None);
    }
    std::fs::remove_file(path)?;
    Ok(Some(metadata.len()))
}
