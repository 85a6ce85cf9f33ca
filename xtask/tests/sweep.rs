//! `xtask sweep` and `merge` as a person, a scheduler and a script run them.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::Value;

const XTASK: &str = env!("CARGO_BIN_EXE_xtask");

/// The exit code, and what was said.
fn run(arguments: &[&str], directory: &Path) -> (i32, String) {
    let output = Command::new(XTASK).args(arguments).current_dir(directory).output().expect("xtask starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(!text.contains("panicked"), "{arguments:?}: {text}");
    (output.status.code().expect("no signal"), text)
}

fn directory() -> tempfile::TempDir {
    tempfile::tempdir().expect("a directory for the test")
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// results.csv without what depends on time: the columns from `host` on.
fn timeless(folder: &Path) -> String {
    let text = read(&folder.join("results.csv"));
    let host = text.lines().next().and_then(|heading| heading.split(',').position(|name| name == "host"));
    let host = host.expect("a column of hosts");
    assert!(host > 30, "most columns are before it");
    text.lines().map(|line| line.split(',').take(host).collect::<Vec<_>>().join(",") + "\n").collect()
}

/// The plan's jobs.
fn list(arguments: &[&str], directory: &Path) -> Vec<Value> {
    let (code, text) = run(&[arguments, &["--list"]].concat(), directory);
    assert_eq!(code, 0, "{text}");
    text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
}

/// A small sweep with jobs of every kind.
const SMALL: [&str; 12] = [
    "sweep",
    "builtin:terrain:2k",
    "--split-method",
    "sah,high",
    "--rays",
    "256",
    "--judged-rays",
    "32",
    "--rounds",
    "2",
    "--quick",
    "--out",
];

fn small<'a>(out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&SMALL[..], &[out], more].concat()
}

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
    assert!(count("<svg viewBox=\"0 0 640 400\" role=\"img\"") == 4 && count("<g><title>") > 20, "points have titles");
    assert!(count("data:image/png;base64,") >= 4, "pictures are in the page");
    for words in ["prefers-color-scheme: dark", "@media print", "seed", "compiler", "revision", "machine"] {
        assert!(page.contains(words), "{words}");
    }
    // A command under each row, which measures that row.
    let rows = list(&small("out", &[]), folder.path()).iter().filter(|job| job["kind"] == "trace").count();
    let commands: Vec<&str> = page.split("<code>").skip(1).filter_map(|rest| rest.split("</code>").next()).collect();
    assert_eq!(commands.len(), rows);
    for command in [commands[0], commands[commands.len() - 1]] {
        let words: Vec<&str> = command.split(' ').skip(2).collect();
        let jobs = list(&words, folder.path());
        assert_eq!(jobs.len(), 1, "{command}: {jobs:?}");
    }
    for file in ["pictures/1-front.svg", "pictures/1-visits-sah.png", "pictures/1-leaks-naive.png"] {
        assert!(folder.path().join("out").join(file).exists(), "{file}");
    }
}

#[test]
fn a_sweep_that_is_killed_goes_on_and_finds_the_same() {
    let folder = directory();
    let here = folder.path();
    let (code, text) = run(&small("whole", &[]), here);
    assert_eq!(code, 0, "{text}");
    let whole = timeless(&here.join("whole"));
    for (i, delay) in [40, 150, 300, 500, 900].into_iter().enumerate() {
        let out = format!("killed{i}");
        let mut child = Command::new(XTASK)
            .args(small(&out, &[]))
            .current_dir(here)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("xtask starts");
        std::thread::sleep(Duration::from_millis(delay));
        child.kill().expect("killed or ended");
        child.wait().expect("ended");
        let (code, text) = run(&small(&out, &[]), here);
        assert_eq!(code, 0, "{text}");
        assert_eq!(timeless(&here.join(&out)), whole, "killed after {delay} ms");
    }
    // What is done is not done again, until that is asked for.
    let file = |job: &Value| here.join("whole/jobs").join(format!("{}.json", job["id"].as_str().expect("an id")));
    let first = file(&list(&small("whole", &[]), here)[0]);
    let before = read(&first);
    let (code, text) = run(&small("whole", &[]), here);
    assert!(code == 0 && text.contains("were done before"), "{text}");
    assert_eq!(read(&first), before);
    let (code, text) = run(&small("whole", &["--fresh"]), here);
    assert!(code == 0 && !text.contains("were done before"), "{text}");
    assert_ne!(read(&first), before, "times are measured anew");
    assert_eq!(timeless(&here.join("whole")), whole);
    // A file that was cut short is done again.
    std::fs::write(&first, &before[..before.len() / 2]).expect("written");
    assert_eq!(run(&small("whole", &[]), here).0, 0);
    assert_eq!(timeless(&here.join("whole")), whole);
    // Another plan begins anew in the same directory.
    let other = ["sweep", "builtin:terrain:1k", "--layout", "wide", "--quick", "--rounds", "1", "--out", "whole"];
    let (code, text) = run(&other, here);
    assert_eq!(code, 0, "{text}");
    assert!(timeless(&here.join("whole")).lines().skip(1).all(|line| line.starts_with("builtin:terrain:1000,")));
}

/// Ctrl-C keeps what is done, and says how to go on.
#[test]
#[cfg(unix)]
fn an_interrupted_sweep_goes_on() {
    let folder = directory();
    let here = folder.path();
    let many = [
        "sweep",
        "builtin:terrain:2k",
        "--quick",
        "--rays",
        "256",
        "--judged-rays",
        "32",
        "--rounds",
        "1000",
        "--out",
        "out",
    ];
    let child = Command::new(XTASK).args(many).current_dir(here).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let child = child.expect("xtask starts");
    let kept = || std::fs::read_dir(here.join("out/jobs")).map_or(0, Iterator::count);
    for _ in 0..600 {
        if kept() > 3 {
            break;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let status = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill is there");
    assert!(status.success());
    let output = child.wait_with_output().expect("ended");
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{text}");
    assert!(text.contains("the same command goes on") && kept() > 3, "{text}");
    let more = [&many[..7], &["--rounds", "1", "--out", "out"]].concat();
    let (code, text) = run(&more, here);
    assert_eq!(code, 0, "{text}");
    assert!(here.join("out/report.html").exists());
}

#[test]
fn shards_put_together_are_the_whole() {
    let folder = directory();
    let here = folder.path();
    assert_eq!(run(&small("whole", &[]), here).0, 0);
    let whole = timeless(&here.join("whole"));
    // Half of them in directories of their own, the others in one.
    let shards: Vec<(String, &str)> =
        (1..=8).map(|i| (format!("{i}/8"), ["own1", "own2", "one", "one"][i % 4])).collect();
    let mut planned = Vec::new();
    for (shard, out) in &shards {
        planned.extend(list(&small(out, &["--shard", shard]), here));
        let (code, text) = run(&small(out, &["--shard", shard]), here);
        assert_eq!(code, 0, "{text}");
        assert!(text.contains("is complete"), "{text}");
    }
    let id = |job: &Value| job["id"].to_string();
    let mut ids: Vec<String> = planned.iter().map(id).collect();
    let mut all: Vec<String> = list(&small("whole", &[]), here).iter().map(id).collect();
    ids.sort();
    all.sort();
    assert_eq!(ids, all, "every job is in one shard");
    let (code, text) = run(&["merge", "own1", "own2", "one", "--out", "merged"], here);
    assert_eq!(code, 0, "{text}");
    assert_eq!(timeless(&here.join("merged")), whole);
    assert!(here.join("merged/report.html").exists());
    for picture in ["1-visits-sah.png", "1-leaks-naive.png", "1-leaks-watertight.png"] {
        let bytes = |out: &str| std::fs::read(here.join(out).join("pictures").join(picture)).expect("a picture");
        assert!(bytes("merged") == bytes("whole"), "{picture}");
    }
    // What lacks a shard says which jobs, and is no success.
    let (code, text) = run(&["merge", "own1", "one", "--out", "part"], here);
    assert_eq!(code, 3, "{text}");
    assert!(text.contains("jobs are missing: "), "{text}");
    // Other plans are not mixed in, whether in a directory of their own or in the same.
    let other =
        ["sweep", "builtin:terrain:1k", "--layout", "wide", "--quick", "--rounds", "1", "--shard", "1/2", "--out"];
    assert_eq!(run(&[&other[..], &["foreign"]].concat(), here).0, 0);
    let (code, text) = run(&["merge", "own1", "foreign", "--out", "mixed"], here);
    assert!(code == 1 && text.contains("different plans") && text.contains("other scenes"), "{text}");
    let (code, text) = run(&[&other[..], &["one"]].concat(), here);
    assert!(code == 1 && text.contains("take another --out"), "{text}");
}

/// Times of two machines are beside each other in a merged report, never together.
#[test]
fn times_of_two_machines_are_not_mixed() {
    let folder = directory();
    let here = folder.path();
    for (shard, out) in [("1/2", "a"), ("2/2", "b")] {
        assert_eq!(run(&small(out, &["--shard", shard]), here).0, 0);
    }
    // As if the second had been another machine.
    for entry in std::fs::read_dir(here.join("b/jobs")).expect("there").flatten() {
        let mut job: Value = serde_json::from_str(&read(&entry.path())).expect("JSON");
        job["timings"]["host"]["name"] = "elsewhere".into();
        job["timings"]["host"]["fingerprint"] = "0123456789abcdef".into();
        std::fs::write(entry.path(), job.to_string()).expect("written");
    }
    let (code, text) = run(&["merge", "a", "b", "--out", "both"], here);
    assert_eq!(code, 0, "{text}");
    assert_eq!(text.matches("verdict  ").count(), 2, "a verdict for each machine: {text}");
    let page = read(&here.join("both/report.html"));
    assert!(page.contains(", on elsewhere</h2>") && page.matches("<h3>Speed against error</h3>").count() == 2);
    let hosts: std::collections::BTreeSet<String> = read(&here.join("both/results.jsonl"))
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).expect("JSON")["host"].to_string())
        .collect();
    assert_eq!(hosts.len(), 2);
    // And a machine does not go on with another's times: it measures its own.
    let jobs = || std::fs::read_dir(here.join("b/jobs")).expect("there").flatten().map(|entry| entry.path());
    for path in jobs() {
        let mut job: Value = serde_json::from_str(&read(&path)).expect("JSON");
        job["is_complete"] = false.into();
        std::fs::write(path, job.to_string()).expect("written");
    }
    let (code, text) = run(&small("b", &["--shard", "2/2"]), here);
    assert_eq!(code, 0, "{text}");
    assert!(jobs().all(|path| !read(&path).contains("elsewhere")));
}

/// The recipe of docs/sweeping-clusters.md, as it stands there.
#[test]
fn gnu_parallel_runs_shards() {
    let is_there = Command::new("parallel").arg("--version").output().is_ok_and(|output| output.status.success());
    if !is_there {
        eprintln!("skipped: GNU parallel is not there");
        return;
    }
    let docs = read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/sweeping-clusters.md"));
    let recipe = docs.split("```sh parallel\n").nth(1).and_then(|rest| rest.split("```").next()).expect("a recipe");
    let folder = directory();
    let here = folder.path();
    std::fs::create_dir_all(here.join("target/release")).expect("made");
    #[cfg(unix)]
    std::os::unix::fs::symlink(XTASK, here.join("target/release/xtask")).expect("linked");
    // Smaller, and the same otherwise.
    let script = recipe.replace("sweep kitchen.ply", "sweep builtin:terrain:1k --quick --rounds 1 --split-method sah");
    assert_ne!(script, recipe);
    let output = Command::new("sh").args(["-ec", &script]).current_dir(here).output().expect("sh starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{script}: {text}");
    assert!(text.matches("is complete").count() == 8 && here.join("run/report.html").exists(), "{text}");
}

#[test]
fn a_sweep_file_says_what_is_measured() {
    let folder = directory();
    let here = folder.path();
    let (code, text) = run(&["sweep", "--print-config"], here);
    assert!(code == 0 && text.contains("[[grid]]"), "{text}");
    // The built-in file, given as a file, is the default.
    std::fs::write(here.join("default.toml"), text).expect("written");
    assert_eq!(list(&["sweep", "--config", "default.toml"], here), list(&["sweep"], here));
    std::fs::write(
        here.join("own.toml"),
        "scenes = [\"builtin:terrain:1k\"]\nrays = 100\njudged_rays = 10\nrounds = 1\npictures = false\ncache = false\n\
         ray_sets = [\"random\"]\n[[grid]]\nlayout = [\"binary\"]\nmax_primitives_in_leaf = [1, 4]\nthreads = [1, 2]\n\
         kernels = [\"exact\"]\n",
    )
    .expect("written");
    let (code, text) = run(&["sweep", "--config", "own.toml", "--out", "own"], here);
    assert_eq!(code, 0, "{text}");
    let lines: Vec<Value> =
        read(&here.join("own/results.jsonl")).lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let leaves: Vec<_> =
        lines.iter().map(|l| (l["max_primitives_in_leaf"].as_u64(), l["build_threads"].as_u64())).collect();
    assert_eq!(leaves, [(Some(1), Some(1)), (Some(1), Some(2)), (Some(4), Some(1)), (Some(4), Some(2))]);
    assert!(lines[0]["nodes"].as_u64() > lines[2]["nodes"].as_u64(), "smaller leaves are more nodes");
    assert!(lines.iter().all(|line| line["ray_kind"] == "random" && line["rays"] == 100));
    // An option goes before the file.
    assert_eq!(list(&["sweep", "--config", "own.toml", "--leaf-size", "2", "--threads", "1"], here).len(), 1);
}

/// An engine's own rays: as many hits as `trace` finds. And batches, which a scene of one mesh can be asked.
#[test]
fn an_engines_own_rays_are_replayed() {
    let folder = directory();
    let here = folder.path();
    std::fs::write(here.join("square.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").expect("written");
    let rays: [[f32; 8]; 4] = [
        [0.75, 0.25, 2.0, 0.0, 0.0, 0.0, -1.0, f32::INFINITY],
        [5.0, 5.0, 2.0, 0.0, 0.0, 0.0, -1.0, f32::INFINITY],
        [0.25, 0.75, 2.0, 0.0, 0.0, 0.0, -2.0, f32::INFINITY],
        [0.75, 0.25, 2.0, 0.0, 0.0, 0.0, -1.0, 1.5],
    ];
    let bytes: Vec<u8> = rays.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    std::fs::write(here.join("engine.rays"), bytes).expect("written");
    let arguments = ["sweep", "square.obj", "--rays", "engine.rays", "--rounds", "1", "--quick", "--out", "out"];
    let (code, text) = run(&arguments, here);
    assert_eq!(code, 0, "{text}");
    let lines: Vec<Value> =
        read(&here.join("out/results.jsonl")).lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert!(lines.iter().all(|l| l["ray_kind"] == "engine.rays" && l["rays"] == 4 && l["hits"] == 2));
    assert!(lines.iter().any(|line| line["calls"] == "batch"));
    assert!(lines.iter().all(|line| line["judged_rays"] == 4 && line["missed"] == 0));
    let both = [&arguments[..], &["--ray-set", "random", "--rays", "64"]].concat();
    let (code, text) = run(&both, here);
    assert_eq!(code, 0, "{text}");
    let kinds: std::collections::BTreeSet<String> = read(&here.join("out/results.jsonl"))
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).expect("JSON")["ray_kind"].to_string())
        .collect();
    assert_eq!(kinds.into_iter().collect::<Vec<_>>(), ["\"engine.rays\"", "\"random\""]);
}
