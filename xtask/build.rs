//! Tells the runner what it was made from and by: the revision, the compiler, the target.

use std::process::Command;

fn main() {
    for (name, program, arguments) in [
        ("SWEEP_REVISION", "git", &["rev-parse", "--short=12", "HEAD"][..]),
        ("SWEEP_CHANGES", "git", &["status", "--porcelain", "--untracked-files=no"][..]),
        ("SWEEP_COMPILER", &std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned()), &["--version"][..]),
    ] {
        let output = Command::new(program).args(arguments).output().ok().filter(|output| output.status.success());
        let text = output.map(|output| String::from_utf8_lossy(&output.stdout).trim().replace('\n', "; "));
        println!("cargo::rustc-env={name}={}", text.unwrap_or_default());
    }
    println!("cargo::rustc-env=SWEEP_TARGET={}", std::env::var("TARGET").unwrap_or_default());
    println!("cargo::rustc-env=SWEEP_PROFILE={}", std::env::var("PROFILE").unwrap_or_default());
    // Whatever changes the program, and the revision.
    let mut places = vec!["../crates".to_owned(), "src".to_owned(), "../Cargo.lock".to_owned()];
    for file in ["HEAD", "logs/HEAD"] {
        let output = Command::new("git").args(["rev-parse", "--git-path", file]).output().ok();
        let output = output.filter(|output| output.status.success());
        places.extend(output.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned()));
    }
    for place in places {
        println!("cargo::rerun-if-changed={place}");
    }
}
