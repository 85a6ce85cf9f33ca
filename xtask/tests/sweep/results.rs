//! What a sweep prints and writes.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use super::{directory, list, read, run, small};

#[test]
fn sweep_prints_its_tables_and_writes_its_results() {
    let folder = directory();
    let (code, text) =
        run(&["sweep", "--quick", "--rays", "512", "--rounds", "2", "--judged-rays", "64"], folder.path());
    assert_eq!(code, 0, "{text}");
    let words = ["sah", "hlbvh", "middle", "equal-counts", "primary", "shadow", "diffuse", "random", "Mray/s"];
    let more = [
        "wide",
        "compact",
        "binary",
        "balanced",
        "portable",
        "exact",
        "watertight",
        "moller-trumbore",
        "vertex leaks",
        "EPO",
        "price",
        "verdict",
        "0 (<",
        "a file pays",
        "noise",
    ];
    for word in words.into_iter().chain(more) {
        assert!(text.contains(word), "{word} is not in: {text}");
    }
    let latest = folder.path().join("target/sweep/latest");
    let lines = read(&latest.join("results.jsonl"));
    // Four kinds of rays; four split methods, with wide trees of each width and binary ones of five kernels; two
    // presets, and compact trees.
    let widths = bvh_flat::SimdWidth::available();
    assert_eq!(lines.lines().count(), 16 * (widths.len() + 5) + 4 * 3);
    let first: Value = lines.lines().next().and_then(|line| serde_json::from_str(line).ok()).expect("a line");
    let fields: Vec<&String> = first.as_object().expect("an object").keys().collect();
    assert_eq!(fields, documented_fields().iter().collect::<Vec<_>>(), "docs/sweep-results.md says all, in order");
    let mut hashes = BTreeMap::new();
    let mut costs: BTreeMap<(String, String), f64> = BTreeMap::new();
    for line in lines.lines() {
        let value: Value = serde_json::from_str(line).expect("JSON");
        let [cost, epo] = ["expected_cost", "effective_primitive_overlap"].map(|name| value[name].as_f64());
        let leaves: u64 = value["leaf_histogram"].as_array().into_iter().flatten().filter_map(Value::as_u64).sum();
        assert!(cost.is_some_and(|x| x > 1.0) && epo.is_some_and(|x| x > 0.0) && leaves > 1000, "{line}");
        costs.insert((value["layout"].to_string(), value["split_method"].to_string()), cost.unwrap_or_default());
        let [layout, width, triangles] = ["layout", "simd_width", "triangle_test"].map(|name| value[name].as_str());
        match layout {
            Some("wide" | "compact") => {
                assert!(widths.iter().any(|w| Some(w.name()) == width), "{line}");
                assert_eq!(triangles, Some("exact"));
            }
            _ => assert_eq!((layout, width), (Some("binary"), Some("scalar"))),
        }
        if triangles == Some("exact") {
            let first = hashes.entry(value["ray_kind"].to_string()).or_insert(value["hits_hash"].clone());
            assert_eq!(*first, value["hits_hash"], "{line}");
        }
        assert!(value["closest_mrays_per_s"].as_f64().is_some_and(|x| x > 0.0));
        assert!(value["build_ms"].as_f64().is_some_and(|x| x > 0.0));
        assert_eq!((&value["build_rounds"], &value["rounds"]), (&2.into(), &2.into()));
        assert_eq!(value["judged_rays"].as_u64().map(|n| n > 20), Some(true));
        if triangles == Some("exact") || (triangles == Some("watertight") && value["box_test"] == "padded") {
            assert_eq!(value["bound_violations"], 0);
            assert_eq!(value["leaks"]["vertices"][0], 0);
        }
    }
    // What half of the primitives on each side costs, by the heuristic that the others go by.
    for layout in ["\"wide\"", "\"binary\""] {
        let cost = |method: &str| costs[&(layout.to_owned(), format!("\"{method}\""))];
        assert!(cost("sah") < cost("equal-counts"), "{costs:?}");
    }
    // Naive kernels are seen to leak, and watertight ones are not.
    let page = read(&latest.join("report.html"));
    assert!(page.contains("watertight kernels: 0 rays lost, in 0 pixels"));
    assert!(page.contains("naive kernels: ") && !page.contains("naive kernels: 0 rays"));
}

/// What the schema says that a line has.
fn documented_fields() -> Vec<String> {
    let docs = read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/sweep-results.md"));
    let (_, table) = docs.split_once("Fields, in this order").expect("a table of fields");
    let names = table.lines().filter(|line| line.starts_with("| `")).filter_map(|line| line.split('|').nth(1));
    names.flat_map(|cell| cell.split('`').skip(1).step_by(2).map(str::to_owned)).collect()
}

/// Every preset is a way to build, and each makes a tree of its own.
#[test]
fn presets_are_ways_to_build() {
    let folder = directory();
    let presets = "fastest,fast,balanced,high,highest";
    let sweep = "sweep builtin:terrain:5k --layout wide --simd-width portable --calls single --rays 64 --judged-rays 8 \
                 --rounds 1 --pictures false --cache false --out out --split-method";
    let words: Vec<&str> = sweep.split_whitespace().chain([presets]).collect();
    let (code, text) = run(&words, folder.path());
    assert_eq!(code, 0, "{text}");
    let lines = read(&folder.path().join("out/results.jsonl"));
    let mut costs = BTreeMap::new();
    for line in lines.lines() {
        let value: Value = serde_json::from_str(line).expect("JSON");
        costs.insert(value["split_method"].as_str().expect("a name").to_owned(), value["expected_cost"].to_string());
    }
    assert_eq!(costs.len(), 5, "{costs:?}");
    assert_ne!(costs["fastest"], costs["balanced"]);
    assert_ne!(costs["fastest"], costs["fast"]);
    let page = read(&folder.path().join("out/report.html"));
    assert!(presets.split(',').all(|preset| page.contains(&format!("</svg>{preset}</li>"))), "all are in the legend");
    assert!(!page.contains("<section class=\"museum\">"), "no pictures, no museum");
}

/// The page needs nothing but itself, and has every number as text.
#[test]
fn the_report_is_one_file_with_its_numbers() {
    let folder = directory();
    let (code, text) = run(&small("out", &[]), folder.path());
    assert_eq!(code, 0, "{text}");
    let page = read(&folder.path().join("out/report.html"));
    let (measured, museum) = page.split_once("<section class=\"museum\">").expect("the museum is a part of the page");
    assert!(!measured.contains("NaN") && !measured.contains("inf<"));
    for foreign in ["<script", "<link", "src=\"http", "href=\"http", "url(", "@import", "<iframe"] {
        // What one may follow is not what the page needs: the museum's threads.
        let page = page.replace("<a href=\"https://github.com/", "");
        assert!(!page.contains(foreign), "{foreign}");
    }
    for exhibit in ["museum-edges", "museum-chain", "museum-nan"] {
        assert!(museum.contains(&format!("<article id=\"{exhibit}\">")), "{exhibit}");
    }
    let count = |words: &str| page.matches(words).count();
    assert_eq!(
        (count("<figure><h3>"), count("<summary>The numbers</summary><div")),
        (4, 4),
        "a table under each chart"
    );
    assert!(count("<svg viewBox=\"0 0 520 370\" role=\"img\"") == 4 && count("<g><title>") > 20, "points have titles");
    assert!(count("data:image/png;base64,") >= 4, "pictures are in the page");
    for words in ["prefers-color-scheme: dark", "@media print", "seed", "compiler", "revision", "machine"] {
        assert!(page.contains(words), "{words}");
    }
    // A command under each row, which measures that row.
    let rows = list(&small("out", &[]), folder.path()).iter().filter(|job| job["kind"] == "trace").count();
    let commands: Vec<&str> = page.split("<code>").skip(1).filter_map(|rest| rest.split("</code>").next()).collect();
    assert_eq!(commands.len(), rows);
    let as_text = |command: &str| command.replace("<span>", "").replace("</span>", "");
    for command in [commands[0], commands[commands.len() - 1]].map(as_text) {
        let words: Vec<&str> = command.split(' ').skip(2).collect();
        let jobs = list(&words, folder.path());
        assert_eq!(jobs.len(), 1, "{command}: {jobs:?}");
    }
    for file in ["pictures/1-front.svg", "pictures/1-visits-sah.png", "pictures/1-leaks-naive.png"] {
        assert!(folder.path().join("out").join(file).exists(), "{file}");
    }
}
