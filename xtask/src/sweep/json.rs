//! What a sweep says to programs: results.jsonl, one object for each configuration and kind of rays.

use std::time::Duration;

use serde::Serialize;

use super::report::per_second;
use super::run::{Configuration, Sweep, Trace};
use crate::errors::quantile;

#[derive(Serialize)]
struct Line<'a> {
    scene: &'a str,
    primitives: u64,
    instanced_primitives: u64,
    layout: &'a str,
    simd_width: &'a str,
    split_method: &'a str,
    build_ms: f64,
    build_rounds: u32,
    build_phases_ms: serde_json::Map<String, serde_json::Value>,
    nodes: u64,
    leaves: u64,
    depth: u32,
    sah_cost: f64,
    bytes: u64,
    bytes_on_disk: u64,
    box_test: &'a str,
    triangle_test: &'a str,
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
    #[serde(flatten)]
    errors: Option<ErrorFields>,
    /// Leaks and rays, by what was aimed at; of the whole configuration.
    leaks: serde_json::Map<String, serde_json::Value>,
}

#[derive(Serialize)]
struct ErrorFields {
    judged_rays: u64,
    missed: u64,
    false_hits: u64,
    wrong_primitive: u64,
    any_closest_mismatches: u64,
    t_ulp_p50: f64,
    t_ulp_p99_99: f64,
    t_ulp_max: f64,
    bound_violations: u64,
    bound_tightness_p50: f64,
    spawned_rays: u64,
    self_hits: u64,
}

/// All results, one JSON object a line. Numbers that do not exist (of no hits) are null.
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
    let build = &sweep.builds[configuration.build];
    let [box_test, triangle_test] = configuration.traversal.tests();
    let milliseconds = |d: Duration| d.as_secs_f64() * 1e3;
    let leaks = configuration.leaks.iter().map(|(aim, leaks, rays)| ((*aim).to_owned(), vec![*leaks, *rays].into()));
    Line {
        scene: &sweep.scene,
        primitives: sweep.primitives,
        instanced_primitives: sweep.instanced_primitives,
        layout: build.layout.name(),
        simd_width: configuration.traversal.width(),
        split_method: build.method.name(),
        build_ms: milliseconds(build.time),
        build_rounds: build.rounds,
        build_phases_ms: build.phases.iter().map(|(name, d)| (name.clone(), milliseconds(*d).into())).collect(),
        nodes: build.nodes,
        leaves: build.leaves,
        depth: build.depth,
        sah_cost: build.sah_cost,
        bytes: build.bytes,
        bytes_on_disk: build.bytes_on_disk,
        box_test,
        triangle_test,
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
        errors: trace.errors.as_ref().map(|e| ErrorFields {
            judged_rays: e.rays,
            missed: e.missed,
            false_hits: e.false_hits,
            wrong_primitive: e.wrong,
            any_closest_mismatches: e.mismatches,
            t_ulp_p50: quantile(&e.t_ulps, 0.5),
            t_ulp_p99_99: quantile(&e.t_ulps, 0.9999),
            t_ulp_max: quantile(&e.t_ulps, 1.0),
            bound_violations: e.bound_violations,
            bound_tightness_p50: quantile(&e.tightness, 0.5),
            spawned_rays: e.spawned,
            self_hits: e.self_hits,
        }),
        leaks: leaks.collect(),
    }
}
