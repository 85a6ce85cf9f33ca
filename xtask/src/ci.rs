//! `xtask ci`: the one check before a push. What it runs is what must hold for a change to land.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use clap::Args;

use crate::measure::timed;

/// The library's crates.
const CRATES: [&str; 4] = ["geometry", "primitive", "bvh-build", "bvh-flat"];

/// Machines unlike this one: no threads and no files, other lanes, no reads at an offset. The library is checked for
/// those of which the toolchain has the standard library.
const TARGETS: [&str; 3] = ["wasm32-unknown-unknown", "aarch64-unknown-linux-gnu", "x86_64-pc-windows-gnu"];

#[derive(Args)]
pub struct Arguments {
    /// Print the steps and run none
    #[arg(long)]
    list: bool,
}

/// A command, as it would be typed.
struct Step {
    /// Of cargo, or of this runner where they begin with `xtask`.
    words: Vec<String>,
    environment: Option<(&'static str, &'static str)>,
}

impl Step {
    fn new(line: &str) -> Self {
        Self { words: line.split(' ').map(str::to_owned).collect(), environment: None }
    }

    /// Of documentation, in which a warning is an error.
    fn doc(line: &str) -> Self {
        Self { environment: Some(("RUSTDOCFLAGS", "-D warnings")), ..Self::new(line) }
    }

    fn line(&self) -> String {
        let variable = self.environment.map_or(String::new(), |(name, value)| format!("{name}=\"{value}\" "));
        format!("{variable}cargo {}", self.words.join(" "))
    }

    fn run(&self, root: &Path) -> Result<()> {
        let (program, words) = match self.words.split_first() {
            Some((first, rest)) if first == "xtask" => (std::env::current_exe()?, rest),
            _ => (std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()).into(), &self.words[..]),
        };
        let mut command = Command::new(program);
        command.args(words).envs(self.environment).current_dir(root);
        let status = command.status().with_context(|| format!("{} cannot be started", self.line()))?;
        ensure!(status.success(), "{} ended with {status}", self.line());
        Ok(())
    }
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().context("the workspace is around the runner")?;
    let (installed, absent): (Vec<&str>, Vec<&str>) = TARGETS.into_iter().partition(|target| is_installed(target));
    let has_deny = is_deny_installed();
    let steps = steps(root, &installed, has_deny)?;
    for (i, step) in (1..).zip(&steps) {
        println!("{i}/{}  {}", steps.len(), step.line());
        if !arguments.list {
            let (time, done) = timed(|| step.run(root));
            done?;
            println!("{i}/{}  {:.0} s", steps.len(), time.as_secs_f64());
        }
    }
    if !has_deny {
        println!("not checked: licences and sources of the dependencies; cargo install --locked cargo-deny");
    }
    for target in absent {
        println!("not checked for {target}: rustup target add {target}");
    }
    Ok(())
}

/// Whether cargo has `cargo deny`.
fn is_deny_installed() -> bool {
    Command::new("cargo-deny").arg("--version").output().is_ok_and(|output| output.status.success())
}

/// Whether the toolchain has the standard library of a target.
fn is_installed(target: &str) -> bool {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc).args(["--print", "target-libdir", "--target", target]).output();
    output.is_ok_and(|output| Path::new(String::from_utf8_lossy(&output.stdout).trim()).is_dir())
}

fn steps(root: &Path, targets: &[&str], has_deny: bool) -> Result<Vec<Step>> {
    let mut steps = vec![
        Step::new("fmt --all --check"),
        Step::new("clippy --locked --workspace --all-targets -- -D warnings"),
        Step::doc("doc --locked --no-deps --workspace"),
    ];
    // Links lead to items that every choice of features has.
    let packages = CRATES.map(|name| format!("-p {name}")).join(" ");
    for features in ["--no-default-features", "--all-features"] {
        steps.push(Step::doc(&format!("doc --locked --no-deps {features} {packages}")));
    }
    if has_deny {
        // Without advisories, which need a network.
        steps.push(Step::new("deny check bans licenses sources"));
    }
    // Each of the library's crates by itself, as its users have it.
    for name in CRATES {
        steps.push(Step::new(&format!("check --locked -p {name} --no-default-features")));
    }
    for target in targets {
        for name in CRATES {
            steps.push(Step::new(&format!("check --locked -p {name} --no-default-features --target {target}")));
        }
        steps.push(Step::new(&format!("check --locked -p bvh-flat --all-features --target {target}")));
    }
    // The README's two commands. The first in one round: what is asked here is that all rows give the same answers, of
    // which few rays showed nothing once, not how fast.
    steps.push(Step::new("xtask sweep --rounds 1 --out target/sweep/ci"));
    steps.push(Step::new("test --locked --workspace"));
    steps.push(Step::new("xtask museum --rays 4096 --out target/museum/ci"));
    for name in examples(&root.join("examples"))? {
        steps.push(Step::new(&format!("run --locked --quiet -p examples --example {name}")));
    }
    Ok(steps)
}

/// The names of all examples.
fn examples(directory: &Path) -> Result<Vec<String>> {
    let entries = std::fs::read_dir(directory).with_context(|| format!("{}: cannot be read", directory.display()))?;
    let paths: Vec<PathBuf> = entries.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>()?;
    let is_example = |path: &&PathBuf| path.extension().is_some_and(|e| e == "rs") && !path.ends_with("lib.rs");
    let mut names: Vec<String> = paths
        .iter()
        .filter(is_example)
        .filter_map(|path| Some(path.file_stem()?.to_string_lossy().into_owned()))
        .collect();
    names.sort();
    Ok(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A crate is the library's if one may depend on it: `bvh-flat`, and all that it depends on.
    #[test]
    fn every_crate_is_built_alone_for_every_target() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace");
        let steps = steps(root, &TARGETS, true).expect("the examples are there");
        let lines: Vec<String> = steps.iter().map(Step::line).collect();
        let (mut names, mut next) = (vec!["bvh-flat".to_owned()], 0);
        while let Some(name) = names.get(next) {
            let manifest = std::fs::read_to_string(root.join(format!("crates/{name}/Cargo.toml"))).expect("is there");
            let manifest: toml::Table = manifest.parse().expect("is TOML");
            let dependencies = manifest["dependencies"].as_table().expect("is a table");
            let own = dependencies.keys().filter(|name| root.join("crates").join(name).is_dir());
            let new: Vec<String> = own.filter(|name| !names.contains(name)).cloned().collect();
            names.extend(new);
            next += 1;
        }
        assert!(names.len() >= 4, "{names:?}");
        for name in names {
            let line = format!("cargo check --locked -p {name} --no-default-features");
            assert!(lines.contains(&line), "{line}");
            assert!(TARGETS.iter().all(|target| lines.contains(&format!("{line} --target {target}"))), "{line}");
        }
    }

    #[test]
    fn the_library_is_documented_with_each_choice_of_features() {
        let steps = steps(Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace"), &[], false);
        let steps = steps.expect("the examples are there");
        for features in ["--no-default-features", "--all-features"] {
            let mut documented = steps.iter().filter(|step| step.words[0] == "doc" && step.line().contains(features));
            assert!(documented.any(|step| {
                let all = CRATES.iter().all(|name| step.words.iter().any(|word| word == name));
                all && step.environment == Some(("RUSTDOCFLAGS", "-D warnings"))
            }));
        }
    }

    #[test]
    fn every_example_is_run() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a workspace");
        let lines: Vec<String> =
            steps(root, &[], false).expect("the examples are there").iter().map(Step::line).collect();
        let manifest = std::fs::read_to_string(root.join("examples/Cargo.toml")).expect("the manifest is there");
        let names: Vec<&str> =
            manifest.lines().filter_map(|l| l.strip_prefix("path = \"")?.strip_suffix(".rs\"")).collect();
        assert!(names.len() > 6);
        for name in names.into_iter().filter(|name| *name != "lib") {
            assert!(lines.iter().any(|line| line.ends_with(&format!("--example {name}"))), "{name}: {lines:?}");
            let text = std::fs::read_to_string(root.join(format!("examples/{name}.rs"))).expect("is there");
            assert!(text.lines().count() < 60, "{name} has {} lines", text.lines().count());
        }
    }
}
