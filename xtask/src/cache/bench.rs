//! `xtask cache bench`: what a load takes beside a build, and when a cache pays.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use bvh_flat::cache::{CacheInfo, GeometryKey, TreeLayout, TreeOptions};
use bvh_flat::geometry::{Interval, Ray, Shape, TraversalRay, TriangleMesh};
use bvh_flat::{BuildConfig, SplitMethod, WideLayout, WideMesh};
use clap::Args;

use super::meshes;
use crate::input::{SCENE_HELP, SceneSource};
use crate::measure::{median, timed};
use crate::table::{count, table};

#[derive(Args)]
pub struct Arguments {
    #[arg(help = SCENE_HELP, value_parser = SceneSource::parse)]
    scene: SceneSource,
    /// How many threads build and load
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..), value_name = "N")]
    threads: u32,
    /// How many rounds, of which the median counts; each goes through everything in turn
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..), value_name = "N")]
    rounds: u32,
}

/// What is measured of one layout, in this order.
const STEPS: [&str; 8] = [
    "build, hlbvh",
    "build, sah",
    "save",
    "geometry key",
    "load, all checks",
    "map, all checks",
    "header alone",
    "first ray after map",
];

pub fn run(arguments: &Arguments) -> Result<()> {
    let scene = arguments.scene.load()?;
    let meshes = meshes(&scene);
    ensure!(!meshes.is_empty(), "{}: there is no mesh in it", arguments.scene.name());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(arguments.threads as usize).build()?;
    let folder = tempfile::tempdir().context("no directory for the files")?;
    let triangles: usize = meshes.iter().map(|mesh| mesh.len()).sum();
    println!(
        "{}: {} meshes, {} triangles; {} threads, the median of {} rounds, files in the page cache",
        arguments.scene.name(),
        meshes.len(),
        count(triangles as u64),
        arguments.threads,
        arguments.rounds,
    );
    for layout in WideLayout::ALL {
        let mut times = vec![Vec::new(); STEPS.len()];
        let mut bytes = 0;
        for _ in 0..arguments.rounds {
            let mut sums = [Duration::ZERO; STEPS.len()];
            bytes = 0;
            for (i, mesh) in meshes.iter().enumerate() {
                let path = folder.path().join(format!("{i}.bvh"));
                let (of_mesh, length) = pool.install(|| steps(mesh, layout, &path))?;
                bytes += length;
                sums.iter_mut().zip(of_mesh).for_each(|(sum, time)| *sum += time);
            }
            times.iter_mut().zip(sums).for_each(|(times, sum)| times.push(sum));
        }
        let times: Vec<Duration> = times.into_iter().map(median).collect();
        report(layout, &times, bytes, triangles);
    }
    Ok(())
}

/// The time of each of [`STEPS`], and the length of the file.
fn steps(mesh: &Arc<TriangleMesh>, layout: WideLayout, path: &std::path::Path) -> Result<([Duration; 8], u64)> {
    let build = |method| {
        let config = BuildConfig::new(method);
        timed(|| WideMesh::build_observed(Arc::clone(mesh), &config, layout, &()))
    };
    let (hlbvh, built) = build(SplitMethod::Hlbvh);
    drop(built?);
    let (sah, built) = build(SplitMethod::Sah);
    let built = built?;
    let options = TreeOptions::new(&BuildConfig::new(SplitMethod::Sah), TreeLayout::Wide(layout));
    let (save, saved) = timed(|| built.save(path, &options));
    saved?;
    drop(built);
    let (key, _) = timed(|| black_box(GeometryKey::of_mesh(mesh)));
    let (load, loaded) = timed(|| WideMesh::load(path, Arc::clone(mesh), Some(&options)));
    drop(loaded?);
    let (map, mapped) = timed(|| WideMesh::map(path, Arc::clone(mesh), Some(&options)));
    let mapped = mapped?;
    let (header, info) = timed(|| CacheInfo::read(path));
    let ray = ray_through(mesh);
    let (first, _) = timed(|| black_box(ray.and_then(|ray| mapped.intersect(&ray, Interval::FULL))));
    Ok(([hlbvh, sah, save, key, load, map, header, first], info?.file_length()))
}

/// Along the diagonal of the bounds.
fn ray_through(mesh: &TriangleMesh) -> Option<TraversalRay> {
    let bounds = mesh.object_bound();
    TraversalRay::new(&Ray::new(bounds.min - bounds.diagonal(), bounds.diagonal()))
}

fn report(layout: WideLayout, times: &[Duration], bytes: u64, triangles: usize) {
    let [hlbvh, sah, save, _, load, map, header, first] = times else { return };
    let ms = |time: &Duration| time.as_secs_f64() * 1e3;
    let mut rows = table(&[layout.name(), "ms", "GB/s", "of the fastest build", "of sah"], 1);
    for (step, time) in STEPS.iter().zip(times) {
        let is_of_all_bytes = ["save", "load, all checks", "map, all checks"].contains(step);
        let speed = is_of_all_bytes.then(|| format!("{:.2}", bytes as f64 / time.as_secs_f64() / 1e9));
        let part = |of: &Duration| format!("1/{:.1}", of.as_secs_f64() / time.as_secs_f64());
        let fastest = hlbvh.min(sah);
        rows.add_row([
            (*step).to_owned(),
            format!("{:.2}", ms(time)),
            speed.unwrap_or_default(),
            part(fastest),
            part(sah),
        ]);
    }
    println!("\n{rows}");
    println!("{} bytes on disk, {:.1} a triangle", count(bytes), bytes as f64 / triangles.max(1) as f64);
    println!("first hit of a mapped tree: {:.2} ms beside the checks", ms(header) + ms(first));
    for (name, build) in [("hlbvh", hlbvh), ("sah", sah)] {
        println!("{}", break_even(name, *build, *save, (*load).min(*map)));
    }
}

fn break_even(name: &str, build: Duration, save: Duration, load: Duration) -> String {
    match uses_until_a_file_pays(build.as_secs_f64(), save.as_secs_f64(), load.as_secs_f64()) {
        None => format!("{name}: a build is faster than a load; keep no file"),
        Some(uses) => format!("{name}: a file pays from use {uses} on"),
    }
}

/// From which use on a tree in a file is faster than one that is built each time; `None` where it never is.
pub fn uses_until_a_file_pays(build: f64, save: f64, load: f64) -> Option<u64> {
    let gain = build - load;
    (gain > 0.0).then(|| 1 + (save / gain).ceil().max(1.0) as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cache_pays_when_loads_have_saved_what_it_cost() {
        let ms = Duration::from_millis;
        assert_eq!(break_even("sah", ms(100), ms(40), ms(10)), "sah: a file pays from use 2 on");
        assert_eq!(break_even("sah", ms(100), ms(181), ms(10)), "sah: a file pays from use 4 on");
        assert!(break_even("sah", ms(10), ms(1), ms(10)).contains("keep no file"));
    }
}
