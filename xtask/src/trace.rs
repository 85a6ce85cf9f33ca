//! `xtask trace`: rays from somebody's own engine in, hits out.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use bvh_flat::geometry::{FirstHit, Hit, Interval, Ray, TraversalRay};
use bvh_flat::primitive::{HitKind, Primitive};
use clap::Args;
use npyz::WriterBuilder;
use rayon::prelude::*;
use scene::{CompiledScene, SceneRay};

use crate::input::{self, SCENE_HELP, SceneSource, SplitMethodName};
use crate::table::count;

#[derive(Args)]
pub struct Arguments {
    #[arg(help = SCENE_HELP, value_parser = SceneSource::parse)]
    scene: SceneSource,
    /// The rays: a .rays file (little-endian f32 records ox oy oz tmin dx dy dz tmax) or a .npy file with a float32
    /// array of shape (N, 8), in the same order. Hits have tmin < t < tmax, both ends excluded; a record with NaN, a
    /// zero direction or a negative tmin is a miss
    #[arg(long, value_name = "FILE")]
    rays: PathBuf,
    /// Where the hits go: a structured .npy array with the fields t (+inf on a miss), instance, geometry, primitive
    /// (0xFFFFFFFF on a miss), u, v
    #[arg(long, value_name = "HITS.npy")]
    out: PathBuf,
    /// Stop at the first hit found, as shadow rays do, instead of the closest
    #[arg(long)]
    any_hit: bool,
    /// How the tree is built; the closest hits do not depend on it
    #[arg(long, value_enum, default_value_t = SplitMethodName::Sah, value_name = "METHOD")]
    split_method: SplitMethodName,
}

/// One record of the output.
#[derive(npyz::Serialize, npyz::AutoSerialize, Clone, Copy)]
struct HitRecord {
    t: f32,
    instance: u32,
    geometry: u32,
    primitive: u32,
    u: f32,
    v: f32,
}

const MISS: HitRecord = HitRecord { t: f32::INFINITY, instance: 0, geometry: 0, primitive: u32::MAX, u: 0.0, v: 0.0 };

pub fn run(arguments: &Arguments) -> Result<()> {
    let rays = read_rays(&arguments.rays)?;
    let compiled = input::compile(&arguments.scene, arguments.split_method)?;
    let records = trace(&compiled, &rays, arguments.any_hit)?;
    let hits = records.iter().filter(|r| r.primitive != u32::MAX).count();
    write_hits(&arguments.out, &records)?;
    println!("{} rays, {} hits, written to {}", count(rays.len() as u64), count(hits as u64), arguments.out.display());
    Ok(())
}

fn trace(compiled: &CompiledScene, rays: &[SceneRay], any_hit: bool) -> Result<Vec<HitRecord>> {
    rays.par_iter()
        .map(|segment| {
            let Some(ray) = TraversalRay::new(&segment.ray) else { return Ok(MISS) };
            let hit = if any_hit {
                first_found(compiled.world(), &ray, segment.interval)
            } else {
                compiled.world().intersect(&ray, segment.interval)
            };
            let Some(hit) = hit else { return Ok(MISS) };
            let name = compiled.name(&hit);
            let instance =
                u32::try_from(name.instance).context("more than 2^32 instances cannot be named in the output")?;
            Ok(HitRecord { t: hit.t, instance, geometry: name.geometry, primitive: name.primitive, u: hit.u, v: hit.v })
        })
        .collect()
}

/// Whichever hit ends an any-hit query.
fn first_found(primitive: &impl Primitive, ray: &TraversalRay, interval: Interval) -> Option<Hit> {
    let mut first = FirstHit::default();
    let _ = primitive.visit_hits(ray, interval, HitKind::Material, &mut first);
    first.hit()
}

/// Reads a .rays or a .npy file.
pub fn read_rays(path: &Path) -> Result<Vec<SceneRay>> {
    match path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).as_deref() {
        Some("npy") => read_npy(path),
        Some("rays") => Ok(scene::read_rays(path)?),
        _ => bail!("{}: rays come from a .rays or a .npy file", path.display()),
    }
}

fn read_npy(path: &Path) -> Result<Vec<SceneRay>> {
    let context = || format!("{}: cannot be read as an array", path.display());
    let bytes = std::fs::read(path).with_context(context)?;
    let npy = npyz::NpyFile::new(&bytes[..]).with_context(context)?;
    ensure!(
        matches!(npy.shape(), [_, 8]),
        "{}: the array must have the shape (N, 8), not {:?}",
        path.display(),
        npy.shape()
    );
    ensure!(npy.dtype().descr() == "'<f4'", "{}: the array must be of little-endian float32", path.display());
    let expected = npy.shape()[0].checked_mul(32);
    ensure!(
        expected.is_some_and(|bytes_of_rays| bytes_of_rays <= bytes.len() as u64),
        "{}: the file ends before the {} rays that its header promises",
        path.display(),
        npy.shape()[0]
    );
    let (rows, order) = (npy.shape()[0] as usize, npy.order());
    let values: Vec<f32> = npy.into_vec().with_context(context)?;
    let segment = |row: usize| {
        let v: [f32; 8] = std::array::from_fn(|column| match order {
            npyz::Order::C => values[8 * row + column],
            npyz::Order::Fortran => values[rows * column + row],
        });
        let [ox, oy, oz, t_min, dx, dy, dz, t_max] = v;
        SceneRay { ray: Ray::new([ox, oy, oz], [dx, dy, dz]), interval: Interval::new(t_min, t_max) }
    };
    Ok((0..rows).map(segment).collect())
}

fn write_hits(path: &Path, records: &[HitRecord]) -> Result<()> {
    let context = || format!("{}: cannot be written", path.display());
    let file = std::io::BufWriter::new(std::fs::File::create(path).with_context(context)?);
    let options = npyz::WriteOptions::new().default_dtype().shape(&[records.len() as u64]);
    let mut writer = options.writer(file).begin_nd().with_context(context)?;
    writer.extend(records.iter().copied()).with_context(context)?;
    writer.finish().with_context(context)
}
