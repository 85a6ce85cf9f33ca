//! What builds of hard input take beside those of a uniform scene of the same size.

use std::sync::Arc;
use std::time::Duration;

use anyhow::Result;
use bvh_flat::geometry::TriangleMesh;
use bvh_flat::{BuildConfig, SplitMethod, WideMesh};
use hard_cases::adversarial_meshes;
use indicatif::ProgressBar;

use crate::measure::{median, timed};
use crate::table::{count, table};

/// How many triangles each mesh has.
const TRIANGLES: usize = 50_000;

/// How often each tree is built; the median counts.
const ROUNDS: usize = 3;

/// So many times as long as a uniform scene none should take.
const LIMIT: f64 = 4.0;

/// Builds wide trees over all meshes by every split method and preset, and prints the times as multiples of those of
/// the uniform mesh. A figure and no condition: it depends on the machine.
pub fn print(seed: u64) -> Result<()> {
    let methods = SplitMethod::ALL.map(|method| (method.name(), BuildConfig::new(method)));
    let ways: Vec<(&str, BuildConfig)> = methods.into_iter().chain(BuildConfig::PRESETS).collect();
    let meshes = adversarial_meshes(TRIANGLES, seed).into_iter().map(|(name, mesh)| (name, Arc::new(mesh)));
    let meshes: Vec<(&str, Arc<TriangleMesh>)> = meshes.collect();
    let names: Vec<&str> = ways.iter().map(|(name, _)| *name).collect();
    let mut rows = table(&[&["mesh"], &names[..]].concat(), 1);
    let bar = ProgressBar::new((meshes.len() * ways.len()) as u64);
    let mut uniform: Vec<f64> = Vec::new();
    let mut worst = (0.0, String::new());
    for (mesh_name, mesh) in &meshes {
        let mut row = vec![(*mesh_name).to_owned()];
        for (i, (name, config)) in ways.iter().enumerate() {
            let time = build_time(mesh, config)?.as_secs_f64();
            bar.inc(1);
            if uniform.len() <= i {
                uniform.push(time);
                row.push(format!("{:.1} ms", 1e3 * time));
                continue;
            }
            let ratio = time / uniform[i];
            row.push(format!("{ratio:.2}"));
            if ratio > worst.0 {
                worst = (ratio, format!("{name}, {mesh_name}"));
            }
        }
        rows.add_row(row);
    }
    bar.finish_and_clear();
    println!("wide trees over {} triangles of hard input: time beside that of a uniform mesh", count(TRIANGLES as u64));
    println!("{rows}");
    let verdict = if worst.0 <= LIMIT { "within" } else { "MORE than" };
    println!("at most {:.2} times as long ({}): {verdict} {LIMIT}", worst.0, worst.1);
    Ok(())
}

fn build_time(mesh: &Arc<TriangleMesh>, config: &BuildConfig) -> Result<Duration> {
    let mut times = Vec::new();
    for _ in 0..ROUNDS {
        let (time, built) = timed(|| WideMesh::build(Arc::clone(mesh), config));
        drop(built?);
        times.push(time);
    }
    Ok(median(times))
}
