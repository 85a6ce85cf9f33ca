//! `peers DIRECTORY ROUNDS`: traces the directory's rays with every peer, in turn. README.md says what is read and
//! written.

mod allocation;
mod bvh_crate;
mod clock;
mod embree;
mod obvhs_crate;
mod ours;
mod parry;
mod tracer;

use std::error::Error;
use std::path::Path;

use clock::{median, timed, timed_on_processor};
use tracer::{Hit, Peer, Ray, Triangles};

struct Entry {
    name: String,
    peer: Box<dyn Peer>,
    build: f64,
    bytes: Option<usize>,
}

struct RaySet {
    name: String,
    rays: Vec<Ray>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, directory, rounds] = &arguments[..] else { return Err("usage: peers DIRECTORY ROUNDS".into()) };
    let (directory, rounds) = (Path::new(directory), rounds.parse::<usize>()?.max(1));
    let triangles = Triangles::from_floats(&floats(&directory.join("triangles.f32"))?);
    let sets = ray_sets(directory)?;
    let entries = build(&triangles);

    let mut times = vec![vec![(Vec::new(), Vec::new()); sets.len()]; entries.len()];
    for round in 0..=rounds {
        for (entry, times) in entries.iter().zip(&mut times) {
            eprintln!("round {round} of {rounds}: {}", entry.name);
            for (set, (closest_times, any_times)) in sets.iter().zip(times) {
                let mut hits = vec![Hit::MISS; set.rays.len()];
                let mut any = vec![0_u8; set.rays.len()];
                let closest_time = timed_on_processor(|| entry.peer.closest(&set.rays, &mut hits));
                let any_time = timed_on_processor(|| entry.peer.any(&set.rays, &mut any));
                // The first pass fills the caches, and its answers are those that are judged.
                if round == 0 {
                    write_answers(directory, &file_name(&entry.name), &set.name, &hits, &any)?;
                } else {
                    closest_times.push(closest_time);
                    any_times.push(any_time);
                }
            }
        }
    }
    for (entry, times) in entries.iter().zip(times) {
        print_line(entry, &sets, times);
    }
    Ok(())
}

/// Every peer that is there, built.
fn build(triangles: &Triangles) -> Vec<Entry> {
    let mut entries = Vec::new();
    let mut add = |name: String, build: &dyn Fn() -> Option<Box<dyn Peer>>| {
        eprintln!("build: {name}");
        let before = allocation::live();
        let (build, peer) = timed(build);
        let grown = allocation::live().saturating_sub(before);
        if let Some(peer) = peer {
            let bytes = peer.bytes().or(Some(grown));
            entries.push(Entry { name, peer, build, bytes });
        }
    };
    let mesh = triangles.mesh();
    for (name, config) in ours::configurations() {
        add(format!("bvh-flat {name}"), &|| ours::build(mesh.clone(), &config));
    }
    let input = obvhs_crate::input(triangles);
    for (name, params) in obvhs_crate::presets() {
        add(format!("obvhs 0.4.0 bvh2 {name}"), &|| obvhs_crate::build_bvh2(&input, params));
        add(format!("obvhs 0.4.0 cwbvh {name}"), &|| obvhs_crate::build_cwbvh(&input, params));
    }
    let input = bvh_crate::input(triangles);
    add("bvh 0.13.0".to_owned(), &|| bvh_crate::build(&input));
    add("parry3d 0.31.1".to_owned(), &|| parry::build(triangles));
    match embree::Embree::open() {
        Some(embree) => {
            let vertices = embree::vertices(triangles);
            for mode in embree::Mode::ALL {
                add(format!("embree {} {}", embree.version(), mode.name()), &|| embree.build(&vertices, mode));
            }
        }
        None => eprintln!("embree: no library of it is installed"),
    }
    entries
}

fn floats(path: &Path) -> Result<Vec<f32>, Box<dyn Error>> {
    let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let (words, _) = bytes.as_chunks::<4>();
    Ok(words.iter().map(|word| f32::from_le_bytes(*word)).collect())
}

fn ray_sets(directory: &Path) -> Result<Vec<RaySet>, Box<dyn Error>> {
    let mut sets = Vec::new();
    for entry in std::fs::read_dir(directory)? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "rays") {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let floats = floats(&path)?;
            let (records, _) = floats.as_chunks::<8>();
            sets.push(RaySet { name, rays: records.iter().map(Ray::from_record).collect() });
        }
    }
    sets.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(sets)
}

/// A peer's name as the beginning of a file's name.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' }).collect()
}

fn write_answers(directory: &Path, peer: &str, set: &str, hits: &[Hit], any: &[u8]) -> std::io::Result<()> {
    let record = |hit: &Hit| [hit.t.to_le_bytes(), hit.primitive.to_le_bytes()].concat();
    std::fs::write(directory.join(format!("{peer}.{set}.hits")), hits.iter().flat_map(record).collect::<Vec<u8>>())?;
    std::fs::write(directory.join(format!("{peer}.{set}.any")), any)
}

/// Names have neither quotes nor backslashes, and times are finite.
fn print_line(entry: &Entry, sets: &[RaySet], times: Vec<(Vec<f64>, Vec<f64>)>) {
    let sets = sets.iter().zip(times).map(|(set, (closest, any))| {
        let [closest, any] = [closest, any].map(median);
        format!("{{\"rays\":\"{}\",\"closest_s\":{closest},\"any_s\":{any}}}", set.name)
    });
    println!(
        "{{\"peer\":\"{}\",\"file\":\"{}\",\"build_s\":{},\"bytes\":{},\"sets\":[{}]}}",
        entry.name,
        file_name(&entry.name),
        entry.build,
        entry.bytes.map_or("null".to_owned(), |bytes| bytes.to_string()),
        sets.collect::<Vec<_>>().join(",")
    );
}
