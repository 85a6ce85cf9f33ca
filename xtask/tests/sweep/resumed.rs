//! Sweeps that are killed or interrupted go on and find the same.

use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::Value;

use super::{XTASK, directory, list, read, run, small, timeless};

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
