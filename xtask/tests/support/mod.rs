//! The runner as a process of its own.

use std::path::Path;
use std::process::Command;

pub const XTASK: &str = env!("CARGO_BIN_EXE_xtask");

/// The exit code, and what was said.
pub fn run(arguments: &[&str], directory: &Path) -> (i32, String) {
    let output = Command::new(XTASK).args(arguments).current_dir(directory).output().expect("xtask starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(!text.contains("panicked"), "{arguments:?}: {text}");
    (output.status.code().expect("no signal"), text)
}

pub fn directory() -> tempfile::TempDir {
    tempfile::tempdir().expect("a directory for the test")
}
