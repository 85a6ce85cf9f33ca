//! `xtask sweep` and `merge` as a person, a scheduler and a script run them.

mod asked;
mod results;
mod resumed;
mod shards;
#[path = "../support/mod.rs"]
mod support;

use std::path::Path;

use serde_json::Value;

use support::{XTASK, directory, run};

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
