//! What a sweep says: tables for people, lines for programs.

use std::time::Duration;

use serde::Serialize;

use super::run::{Configuration, Sweep, Trace};
use crate::table::{count, table};

/// The tables of one scene.
pub fn print(sweep: &Sweep, threads: usize) {
    println!("\n{}: {} primitives", sweep.scene, count(sweep.primitives));
    if sweep.instanced_primitives != sweep.primitives {
        println!("instanced: {} primitives", count(sweep.instanced_primitives));
    }
    println!("\nBuild, {threads} threads");
    let header = ["split method", "build ms", "Mprim/s", "nodes", "leaves", "depth", "SAH cost", "bytes/prim"];
    let mut builds = table(&header, 1);
    for Configuration { method, build, .. } in &sweep.configurations {
        builds.add_row([
            method.name().to_owned(),
            format!("{:.1}", build.time.as_secs_f64() * 1e3),
            format!("{:.2}", per_second(sweep.primitives as usize, build.time)),
            count(build.nodes),
            count(build.leaves),
            build.depth.to_string(),
            format!("{:.2}", build.sah_cost),
            format!("{:.1}", build.bytes as f64 / sweep.primitives.max(1) as f64),
        ]);
    }
    println!("{builds}");

    println!("\nTrace, 1 thread");
    let header = [
        "split method",
        "rays",
        "hit %",
        "closest Mray/s",
        "any Mray/s",
        "nodes/ray",
        "tests/ray",
        "any nodes/ray",
        "any tests/ray",
    ];
    let mut traces = table(&header, 2);
    for Configuration { method, traces: kinds, .. } in &sweep.configurations {
        for trace in kinds {
            let rays = trace.rays.max(1) as f64;
            traces.add_row([
                method.name().to_owned(),
                trace.kind.to_owned(),
                format!("{:.1}", 100.0 * trace.hits as f64 / rays),
                format!("{:.2}", per_second(trace.rays, trace.closest)),
                format!("{:.2}", per_second(trace.rays, trace.any)),
                format!("{:.1}", trace.closest_work.nodes as f64 / rays),
                format!("{:.1}", trace.closest_work.primitives as f64 / rays),
                format!("{:.1}", trace.any_work.nodes as f64 / rays),
                format!("{:.1}", trace.any_work.primitives as f64 / rays),
            ]);
        }
    }
    println!("{traces}\n");
}

/// How the cost of a build grows over several scenes.
pub fn print_growth(sweeps: &[Sweep]) {
    println!("Growth");
    let mut growth = table(&["scene", "split method", "primitives", "build ms", "ns/prim", "bytes/prim"], 2);
    for i in 0..sweeps.iter().map(|s| s.configurations.len()).min().unwrap_or(0) {
        for sweep in sweeps {
            let Configuration { method, build, .. } = &sweep.configurations[i];
            let primitives = sweep.primitives.max(1) as f64;
            growth.add_row([
                sweep.scene.clone(),
                method.name().to_owned(),
                count(sweep.primitives),
                format!("{:.1}", build.time.as_secs_f64() * 1e3),
                format!("{:.0}", build.time.as_secs_f64() * 1e9 / primitives),
                format!("{:.1}", build.bytes as f64 / primitives),
            ]);
        }
    }
    println!("{growth}\n");
}

/// One line of results.jsonl: one configuration and one kind of rays on one scene.
#[derive(Serialize)]
struct Line<'a> {
    scene: &'a str,
    primitives: u64,
    instanced_primitives: u64,
    split_method: &'a str,
    build_ms: f64,
    build_phases_ms: serde_json::Map<String, serde_json::Value>,
    nodes: u64,
    leaves: u64,
    depth: u32,
    sah_cost: f64,
    bytes: u64,
    ray_kind: &'a str,
    rays: usize,
    hits: usize,
    closest_mrays_per_s: f64,
    any_mrays_per_s: f64,
    closest_nodes: u64,
    closest_tests: u64,
    any_nodes: u64,
    any_tests: u64,
    hits_hash: String,
}

/// All results, one JSON object a line.
pub fn json_lines(sweeps: &[Sweep]) -> String {
    let mut text = String::new();
    for sweep in sweeps {
        for configuration in &sweep.configurations {
            for trace in &configuration.traces {
                if let Ok(line) = serde_json::to_string(&line(sweep, configuration, trace)) {
                    text += &line;
                    text.push('\n');
                }
            }
        }
    }
    text
}

fn line<'a>(sweep: &'a Sweep, configuration: &'a Configuration, trace: &'a Trace) -> Line<'a> {
    let build = &configuration.build;
    let milliseconds = |d: Duration| d.as_secs_f64() * 1e3;
    Line {
        scene: &sweep.scene,
        primitives: sweep.primitives,
        instanced_primitives: sweep.instanced_primitives,
        split_method: configuration.method.name(),
        build_ms: milliseconds(build.time),
        build_phases_ms: build.phases.iter().map(|(name, d)| (name.clone(), milliseconds(*d).into())).collect(),
        nodes: build.nodes,
        leaves: build.leaves,
        depth: build.depth,
        sah_cost: build.sah_cost,
        bytes: build.bytes,
        ray_kind: trace.kind,
        rays: trace.rays,
        hits: trace.hits,
        closest_mrays_per_s: per_second(trace.rays, trace.closest),
        any_mrays_per_s: per_second(trace.rays, trace.any),
        closest_nodes: trace.closest_work.nodes,
        closest_tests: trace.closest_work.primitives,
        any_nodes: trace.any_work.nodes,
        any_tests: trace.any_work.primitives,
        hits_hash: format!("{:016x}", trace.hash),
    }
}

/// Millions a second.
fn per_second(count: usize, time: Duration) -> f64 {
    count as f64 / time.as_secs_f64().max(1e-9) / 1e6
}
