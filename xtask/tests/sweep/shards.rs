//! Sweeps that are divided, and put together.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use super::{XTASK, directory, list, read, run, small, timeless};

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
