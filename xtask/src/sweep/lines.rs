//! What a sweep says to programs: a line for each configuration and set of rays, as JSON and as comma-separated values.
//! `docs/sweep-results.md` is the schema.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::results::{QualityFigures, SetAnswers};
use super::rows::{Row, Sweep, per_second};
use crate::errors::ErrorSummary;

/// A line, of which everything before `host` does not depend on time: the same bytes on every machine.
#[derive(Serialize)]
struct Line<'a> {
    scene: &'a str,
    plan: &'a str,
    job: &'a str,
    primitives: u64,
    instanced_primitives: u64,
    layout: &'a str,
    simd_width: &'a str,
    calls: &'a str,
    split_method: &'a str,
    max_primitives_in_leaf: Option<u32>,
    nodes: u64,
    leaves: u64,
    depth: u32,
    sah_cost: f64,
    bytes: u64,
    bytes_on_disk: u64,
    expected_cost: Option<f64>,
    overlap: Option<f64>,
    effective_primitive_overlap: Option<f64>,
    /// How many leaves have 1, 2, 3, … primitives, the last 8 and more.
    leaf_histogram: Option<[u64; QualityFigures::SIZES]>,
    box_test: &'a str,
    triangle_test: &'a str,
    ray_kind: &'a str,
    rays: u64,
    hits: u64,
    closest_nodes: u64,
    closest_tests: u64,
    any_nodes: u64,
    any_tests: u64,
    hits_hash: &'a str,
    judged_rays: Option<u64>,
    missed: Option<u64>,
    false_hits: Option<u64>,
    wrong_primitive: Option<u64>,
    any_closest_mismatches: Option<u64>,
    t_ulp_p50: Option<f64>,
    t_ulp_p99_99: Option<f64>,
    t_ulp_max: Option<f64>,
    bound_violations: Option<u64>,
    bound_tightness_p50: Option<f64>,
    spawned_rays: Option<u64>,
    self_hits: Option<u64>,
    /// Leaks and rays, by what was aimed at; of the whole configuration.
    leaks: Map<String, Value>,
    host: &'a str,
    build_threads: u32,
    build_rounds: usize,
    build_ms: f64,
    build_phases_ms: BTreeMap<&'a str, f64>,
    rounds: usize,
    closest_mrays_per_s: f64,
    any_mrays_per_s: f64,
}

/// All results, one JSON object a line. Numbers that do not exist (of no hits, or not asked for) are null.
pub fn json_lines(sweeps: &[Sweep]) -> String {
    let line = |line: Line| serde_json::to_string(&line).ok();
    lines(sweeps).into_iter().filter_map(line).fold(String::new(), |text, line| text + &line + "\n")
}

/// The same with a heading, and what does not exist empty. Objects have a column for each of their keys.
pub fn csv(sweeps: &[Sweep]) -> String {
    let mut text = String::new();
    for line in lines(sweeps) {
        let Ok(Value::Object(fields)) = serde_json::to_value(&line) else { continue };
        // Phases differ from builder to builder; the whole is in the lines of JSON.
        let flat: Vec<(String, Value)> =
            fields.into_iter().filter(|(name, _)| name != "build_phases_ms").flat_map(flatten).collect();
        if text.is_empty() {
            let names: Vec<&str> = flat.iter().map(|(name, _)| name.as_str()).collect();
            text = names.join(",") + "\n";
        }
        let values: Vec<String> = flat.iter().map(|(_, value)| cell(value)).collect();
        text += &(values.join(",") + "\n");
    }
    text
}

fn flatten((name, value): (String, Value)) -> Vec<(String, Value)> {
    if name == "leaf_histogram" {
        let size =
            |i: usize| if i + 1 < QualityFigures::SIZES { format!("{}", i + 1) } else { format!("{}_up", i + 1) };
        let of = |i: usize| value.get(i).cloned().unwrap_or(Value::Null);
        return (0..QualityFigures::SIZES).map(|i| (format!("leaves_of_{}", size(i)), of(i))).collect();
    }
    if name != "leaks" {
        return vec![(name, value)];
    }
    // The same columns in every scene, whether it has closed meshes or not.
    let aims = ["edges", "vertices", "corners"].into_iter().flat_map(|aim| {
        let of = |i: usize| value.get(aim).and_then(|pair| pair.get(i)).cloned().unwrap_or(Value::Null);
        [(format!("{aim}_leaks"), of(0)), (format!("{aim}_aimed"), of(1))]
    });
    aims.collect()
}

fn cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) if text.contains([',', '"', '\n']) => format!("\"{}\"", text.replace('"', "\"\"")),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// The lines in the order of the plan, whatever the machines.
fn lines<'a>(sweeps: &'a [Sweep]) -> Vec<Line<'a>> {
    let mut rows: Vec<(&Sweep, &Row)> = sweeps.iter().flat_map(|s| s.rows.iter().map(move |row| (s, row))).collect();
    rows.sort_by_key(|(_, row)| row.place);
    let of_row = |(sweep, row): (&'a Sweep, &'a Row)| {
        row.answers.sets.iter().enumerate().map(move |(i, set)| line(sweep, row, i, set))
    };
    rows.into_iter().flat_map(of_row).collect()
}

fn line<'a>(sweep: &'a Sweep, row: &'a Row, i: usize, set: &'a SetAnswers) -> Line<'a> {
    let [box_test, triangle_test] = row.traversal.tests();
    let (trees, timings) = (&row.answers.trees, row.timings);
    let errors = set.errors.as_ref();
    let count = |f: fn(&ErrorSummary) -> u64| errors.map(f);
    let leaks = row.answers.leaks.iter().map(|(aim, leaks, rays)| (aim.clone(), json!([leaks, rays])));
    let phases = timings.phases.iter().flat_map(|phases| phases.keys());
    let phase = |name: &'a String| {
        let of_rounds = timings.phases.iter().filter_map(|phases| phases.get(name).copied());
        (name.as_str(), 1e3 * super::results::median(of_rounds.collect()))
    };
    Line {
        scene: sweep.scene_name(),
        plan: &sweep.plan.id,
        job: &row.job.id,
        primitives: sweep.primitives(),
        instanced_primitives: row.answers.instanced_primitives,
        layout: row.tree.layout.name(),
        simd_width: row.traversal.width(),
        calls: row.traversal.calls().name(),
        split_method: row.tree.split_method.name(),
        max_primitives_in_leaf: row.tree.max_primitives_in_leaf,
        nodes: trees.nodes,
        leaves: trees.leaves,
        depth: trees.depth,
        sah_cost: trees.sah_cost,
        bytes: trees.bytes,
        bytes_on_disk: trees.bytes_on_disk,
        expected_cost: trees.quality.as_ref().map(|q| q.expected_cost),
        overlap: trees.quality.as_ref().map(|q| q.overlap),
        effective_primitive_overlap: trees.quality.as_ref().map(|q| q.effective_primitive_overlap),
        leaf_histogram: trees.quality.as_ref().map(|q| q.leaves),
        box_test,
        triangle_test,
        ray_kind: &set.name,
        rays: set.rays,
        hits: set.hits,
        closest_nodes: set.closest_nodes,
        closest_tests: set.closest_tests,
        any_nodes: set.any_nodes,
        any_tests: set.any_tests,
        hits_hash: &set.hash,
        judged_rays: count(|e| e.rays),
        missed: count(|e| e.missed),
        false_hits: count(|e| e.false_hits),
        wrong_primitive: count(|e| e.wrong),
        any_closest_mismatches: count(|e| e.mismatches),
        t_ulp_p50: errors.and_then(|e| e.t_ulp_p50),
        t_ulp_p99_99: errors.and_then(|e| e.t_ulp_p99_99),
        t_ulp_max: errors.and_then(|e| e.t_ulp_max),
        bound_violations: count(|e| e.bound_violations),
        bound_tightness_p50: errors.and_then(|e| e.bound_tightness_p50),
        spawned_rays: count(|e| e.spawned),
        self_hits: count(|e| e.self_hits),
        leaks: leaks.collect(),
        host: &sweep.host.fingerprint,
        build_threads: timings.build_threads,
        build_rounds: timings.builds.len(),
        build_ms: 1e3 * timings.build(),
        build_phases_ms: phases.map(phase).collect(),
        rounds: timings.rounds.len(),
        closest_mrays_per_s: per_second(set.rays, timings.step(2 * i)),
        any_mrays_per_s: per_second(set.rays, timings.step(2 * i + 1)),
    }
}
