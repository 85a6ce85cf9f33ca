//! `xtask compare`: other libraries beside this one, on the same triangles and rays, in one run; their speed, and
//! their errors by the exact oracle.
//!
//! The other libraries are called by a program in `benches/peers`, a workspace of its own, which is built when it is
//! needed: it is given triangles and rays, and writes answers and times. It knows no oracle, and here no other library
//! is known.

mod judge;
mod soup;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;

use anyhow::{Context, Result, bail, ensure};
use bvh_flat::geometry::{Interval, TriangleMesh};
use bvh_flat::primitive::{GeometricPrimitive, MaterialId, MediumInterface, Surface};
use bvh_flat::{BuildConfig, WideMesh};
use clap::Args;
use hard_cases::{Aim, Random, aimed_rays};
use scene::{Camera, RaySets, SceneRay, write_rays};
use serde::{Deserialize, Serialize};

use self::judge::{PeerErrors, Truth};
use crate::errors::per_million;
use crate::input::{SCENE_HELP, SEED, SceneSource};
use crate::table::{count, table};

#[derive(Args)]
pub struct Arguments {
    #[arg(help = SCENE_HELP, value_parser = SceneSource::parse, default_value = "builtin:stadium")]
    scene: SceneSource,
    /// Rays of each kind, at most; every answer is judged
    #[arg(long, default_value_t = 1 << 15, value_name = "N")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1 << 22))]
    rays: u32,
    /// Timed rounds; each goes through all libraries in turn, and the median counts
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Where compare.jsonl goes
    #[arg(long, default_value = "target/compare", value_name = "DIR")]
    out: PathBuf,
}

/// A line of the program's output.
#[derive(Deserialize)]
struct PeerLine {
    peer: String,
    file: String,
    build_s: f64,
    bytes: Option<u64>,
    sets: Vec<SetLine>,
}

#[derive(Deserialize)]
struct SetLine {
    rays: String,
    closest_s: f64,
    any_s: f64,
}

/// A line of compare.jsonl: a library on a set of rays.
#[derive(Serialize)]
struct Line<'a> {
    scene: &'a str,
    triangles: usize,
    peer: &'a str,
    build_ms: f64,
    bytes_per_triangle: Option<f64>,
    ray_kind: &'a str,
    rays: u64,
    closest_mrays_per_s: f64,
    any_mrays_per_s: f64,
    missed: u64,
    false_hits: u64,
    wrong_primitive: u64,
    any_wrong: u64,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let scene = arguments.scene.load()?;
    let time = scene.camera.map_or(0.0, |camera| camera.shutter[0]);
    let (mesh, spheres) = soup::soup(&scene, time).with_context(|| arguments.scene.name())?;
    ensure!(!mesh.is_empty(), "{}: there is no triangle in it", arguments.scene.name());
    if spheres > 0 {
        eprintln!("warning: {}: {spheres} spheres are left out; not every library has them", arguments.scene.name());
    }
    let sets = ray_sets(&mesh, scene.camera, arguments.rays as usize)?;

    let directory = tempfile::tempdir()?;
    write_input(directory.path(), &mesh, &sets)?;
    let lines = run_peers(directory.path(), arguments.rounds)?;
    ensure!(!lines.is_empty(), "no library has answered");
    let truths: Vec<Truth> = sets.iter().map(|(name, rays)| Truth::new(&mesh, name, rays)).collect();
    let mut judged = Vec::new();
    for line in &lines {
        let errors: Result<Vec<PeerErrors>> = truths.iter().map(|t| t.judge(directory.path(), &line.file)).collect();
        judged.push(errors?);
    }
    print(&arguments.scene.name(), mesh.len(), &sets, &lines, &judged);
    write_lines(arguments, mesh.len(), &sets, &lines, &judged)?;
    let ours = lines.iter().zip(&judged).filter(|(line, _)| line.peer.starts_with("bvh-flat"));
    let wrong: u64 = ours.flat_map(|(_, errors)| errors).map(PeerErrors::sum).sum();
    ensure!(wrong == 0, "{wrong} answers of this library are wrong");
    Ok(())
}

/// The four sets of a renderer, and rays that are aimed at vertices and edges from random points of the box: random
/// rays seldom meet what libraries get wrong.
fn ray_sets(
    mesh: &Arc<TriangleMesh>,
    camera: Option<Camera>,
    size: usize,
) -> Result<Vec<(&'static str, Vec<SceneRay>)>> {
    let tree = WideMesh::build(Arc::clone(mesh), &BuildConfig::balanced())?;
    let surface = Surface::of_material(MaterialId::from_index(0).context("an index below the last")?);
    let world = GeometricPrimitive::new(tree, surface, MediumInterface::VACUUM);
    let bounds = bvh_flat::primitive::Primitive::world_bound(&world);
    let camera = camera.unwrap_or_else(|| Camera::looking_at_bounds(&bounds));
    let sets = RaySets::generate(&world, &bounds, &camera, size, SEED)?;
    let mut all: Vec<(&'static str, Vec<SceneRay>)> =
        sets.named().map(|(name, rays)| (name, rays.to_vec())).into_iter().collect();
    let mut random = Random::new(SEED, 1);
    let aimed = [Aim::Vertex, Aim::Edge].map(|aim| {
        let rays = aimed_rays(mesh, aim, size / 2, &mut random, |random| random.point_in(&bounds));
        rays.map(|ray| SceneRay { ray, interval: Interval::FULL }).collect::<Vec<_>>()
    });
    all.push(("aimed", aimed.concat()));
    Ok(all)
}

fn write_input(directory: &Path, mesh: &TriangleMesh, sets: &[(&str, Vec<SceneRay>)]) -> Result<()> {
    let floats = mesh.positions().iter().flat_map(|p| p.to_array());
    let bytes: Vec<u8> = floats.flat_map(f32::to_le_bytes).collect();
    std::fs::write(directory.join("triangles.f32"), bytes)?;
    for (name, rays) in sets {
        write_rays(&directory.join(format!("{name}.rays")), rays)?;
    }
    Ok(())
}

/// Builds the program where it is not built yet, and runs it.
fn run_peers(directory: &Path, rounds: u32) -> Result<Vec<PeerLine>> {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("../benches/peers/Cargo.toml");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut build = Command::new(&cargo);
    build.args(["build", "--release", "--locked", "--manifest-path"]).arg(&manifest);
    if !build.status().with_context(|| "cargo cannot be started")?.success() {
        bail!("the other libraries cannot be built: benches/peers needs a registry, or its crates in cargo's cache");
    }
    let mut run = Command::new(&cargo);
    run.args(["run", "--release", "--locked", "--quiet", "--manifest-path"]).arg(&manifest).arg("--");
    let output = run.arg(directory).arg(rounds.to_string()).stderr(Stdio::inherit()).output()?;
    ensure!(output.status.success(), "the other libraries have ended with {}", output.status);
    let text = String::from_utf8(output.stdout)?;
    text.lines().map(|line| serde_json::from_str(line).with_context(|| line.to_owned())).collect()
}

fn speed(rays: usize, seconds: f64) -> f64 {
    if seconds > 0.0 { rays as f64 / seconds * 1e-6 } else { 0.0 }
}

fn set_of<'a>(line: &'a PeerLine, name: &str) -> Result<&'a SetLine> {
    line.sets.iter().find(|set| set.rays == name).with_context(|| format!("{} has no times of {name} rays", line.peer))
}

fn print(
    scene: &str,
    triangles: usize,
    sets: &[(&str, Vec<SceneRay>)],
    lines: &[PeerLine],
    judged: &[Vec<PeerErrors>],
) {
    println!("{scene}: {} triangles, one mesh; one ray a call on one thread, builds on all", count(triangles as u64));
    println!("Mray/s of the closest hit, and of any hit");
    let names: Vec<String> = sets.iter().flat_map(|(name, _)| [(*name).to_owned(), "any".to_owned()]).collect();
    let header: Vec<&str> =
        ["library", "build ms", "B/tri"].into_iter().chain(names.iter().map(String::as_str)).collect();
    let mut rows = table(&header, 1);
    for line in lines {
        let bytes = line.bytes.map_or("-".to_owned(), |bytes| format!("{:.0}", bytes as f64 / triangles as f64));
        let mut row = vec![line.peer.clone(), format!("{:.0}", line.build_s * 1e3), bytes];
        for (name, rays) in sets {
            let [closest, any] = set_of(line, name).map_or([0.0; 2], |set| [set.closest_s, set.any_s]);
            row.extend([closest, any].map(|seconds| format!("{:.2}", speed(rays.len(), seconds))));
        }
        rows.add_row(row);
    }
    println!("{rows}\n\nwrong answers a million, by exact arithmetic");
    println!("aimed: at vertices and edges, where a wrong triangle is mostly the neighbour of the right one");
    let header = ["library", "missed", "false", "wrong", "any hit", "aimed: missed", "false", "wrong", "any hit"];
    let mut rows = table(&header, 1);
    for (line, errors) in lines.iter().zip(judged) {
        let mut row = vec![line.peer.clone()];
        for is_aimed in [false, true] {
            let some = errors.iter().zip(sets).filter(|(_, (name, _))| (*name == "aimed") == is_aimed);
            let sum = some.map(|(errors, _)| *errors).fold(PeerErrors::default(), PeerErrors::and);
            let PeerErrors { rays, missed, false_hits, wrong, any_wrong } = sum;
            row.extend([missed, false_hits, wrong, any_wrong].map(|n| per_million(n, rays)));
        }
        rows.add_row(row);
    }
    println!("{rows}");
}

fn write_lines(
    arguments: &Arguments,
    triangles: usize,
    sets: &[(&str, Vec<SceneRay>)],
    lines: &[PeerLine],
    judged: &[Vec<PeerErrors>],
) -> Result<()> {
    let scene = arguments.scene.name();
    let mut text = String::new();
    for (line, errors) in lines.iter().zip(judged) {
        for ((name, rays), errors) in sets.iter().zip(errors) {
            let times = set_of(line, name)?;
            let json = Line {
                scene: &scene,
                triangles,
                peer: &line.peer,
                build_ms: line.build_s * 1e3,
                bytes_per_triangle: line.bytes.map(|bytes| bytes as f64 / triangles as f64),
                ray_kind: name,
                rays: errors.rays,
                closest_mrays_per_s: speed(rays.len(), times.closest_s),
                any_mrays_per_s: speed(rays.len(), times.any_s),
                missed: errors.missed,
                false_hits: errors.false_hits,
                wrong_primitive: errors.wrong,
                any_wrong: errors.any_wrong,
            };
            text += &serde_json::to_string(&json)?;
            text.push('\n');
        }
    }
    let path = arguments.out.join("compare.jsonl");
    std::fs::create_dir_all(&arguments.out)
        .and_then(|()| std::fs::write(&path, text))
        .with_context(|| format!("{}: cannot be written", path.display()))?;
    println!("results  {}", path.display());
    Ok(())
}
